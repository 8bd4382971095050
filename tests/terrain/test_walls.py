"""Terrain with walls and overhangs: a particle between walls in closed form, and random polylines that nothing may enter."""

import math
import os
from collections import Counter
from itertools import pairwise

import depths
import numpy as np
import pytest
import standfast as sf
from walls import particle, random_scene

G = 9.81
#: Number of random scenes; `make long` has more.
SCENES = int(os.environ.get("STANDFAST_WALL_SCENES", "200"))


def bounces(y, vx, vy, e, count):
    """Times and normal speeds of the bounces of a particle between walls at x = −1 and 1, from x = 0."""
    x, t, found = 0.0, 0.0, []
    while len(found) < count:
        wall = (math.copysign(1, vx) - x) / vx
        floor = (vy + math.sqrt(vy * vy + 2 * G * y)) / G
        dt = min(wall, floor)
        t, x, y, vy = t + dt, x + vx * dt, y + vy * dt - G * dt * dt / 2, vy - G * dt
        if wall < floor:
            found.append((t, abs(vx)))
            x, vx = math.copysign(1, vx), -e * vx
        else:
            found.append((t, -vy))
            y, vy = 0.0, -e * vy
    return found


@pytest.mark.parametrize("speed", [5.0, -7.3, 40.0])
def test_a_particle_between_walls(speed):
    box = [(-1, 20), (-1, 0), (1, 0), (1, 20)]
    posture = particle(box, (0.0, 0.5), 0.8)
    run = sf.simulate(
        posture, (0, 0.3, 0), (speed, 0, 0), model="full", stop="time", time_limit=2.5
    )
    expected = bounces(0.8, speed, 0.0, 0.8, 8)
    found = [(float(i["time"]), -float(i["rates_before"][0])) for i in run.impacts[:8]]
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_gaps_between_walls():
    box = [(-1, 2), (-1, 0), (1, 0), (1, 2)]
    posture = particle(box, (0.0, 0.5), 0.5)
    for q, gap in (
        ((0, 0, 0), 0.5),
        ((0.9, 0, 0), 0.1),
        ((-0.7, 1, 0), 0.3),
        ((0, -0.5, 0), 0.0),
    ):
        assert posture.gaps(q) == pytest.approx([gap], abs=1e-15)


def test_a_contact_above_a_ledge_may_be_nearest_to_its_end():
    box = sf.Posture.box(
        1, 2, friction=0.5, terrain=[(-9, 5), (-9, 0), (0, 0), (0, -3), (9, -3), (9, 5)]
    )
    assert box.gaps((-3, 0, 0))[:2] == pytest.approx((0, 0))
    run = sf.simulate(box, (-3, 1, 0.3), (5, 0, 2), impact="poisson", edges="ignore")
    assert run.outcome == "rest"


def test_a_particle_slides_around_a_corner():
    """Down a ramp, over a ledge, into a shaft: it hits the wall of the shaft from inside, and rests on its floor."""
    shaft = [(-3, 2), (-1, 0), (0, 0), (0, -2), (1, -2), (1, 3)]
    run = sf.simulate(
        particle(shaft, (-2.0, 1.0), 0.0), (0, 0, 0), (0, 0, 0), impact="moreau"
    )
    assert run.outcome == "sliding" or run.outcome == "rest"
    x, y = np.array([-2.0, 1.0]) + run.q[:2]
    assert y == pytest.approx(-2, abs=1e-12)
    assert 0 <= x <= 1


def test_an_overhang_is_hit_from_below():
    """A roof over the floor: a particle thrown up hits it after the time at which it reaches the height."""
    roof = [(-3, 0), (2, 0), (2, 1), (-3, 1)]
    run = sf.simulate(
        particle(roof, (0.0, 0.0), 0.5),
        (0, 0, 0),
        (0, 6, 0),
        model="full",
        stop="time",
        time_limit=0.5,
    )
    hit = (6 - math.sqrt(36 - 2 * G)) / G
    assert float(run.impacts[0]["time"]) == pytest.approx(hit, rel=1e-12)


#: A rod whose foot circles under the left end of a hill with a wall: its speed, and its place, sideways.
UNDER_THE_END = [
    (0.0, 6.0, -0.6),
    (0.0, -6.0, -0.6),
    (2.0, 9.0, -0.6),
    (0.6, 4.0, -0.9),
]


@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.parametrize(("speed", "spin", "x"), UNDER_THE_END)
def test_a_contact_that_has_come_under_the_end_of_the_terrain_meets_nothing(
    speed, spin, x, mirror
):
    """The gap of the contact is infinite, whichever piece is nearest: while the contact is behind pieces, and after
    the event with which it leaves them."""
    hill = [(0.0, 0.0), (1.0, 0.3), (2.0, 0.0), (2.0, -30.0), (4.0, -30.0)]
    rod = sf.Posture(
        mass=1,
        gyration_radius=0.5,
        center_of_mass=(mirror * x, 0.5),
        contacts=[sf.Contact((mirror * (x + 1.5), 0.5))],
        restitution=0.3,
        gravity=G,
        terrain=[(mirror * x, y) for x, y in hill][::mirror],
    )
    start = (0.0, -1.0, -mirror * math.pi / 2), (mirror * speed, 2.0, mirror * spin)
    run = sf.simulate(rod, *start, model="full")
    assert run.outcome == "escape"
    times = np.append(np.linspace(0, run.elapsed, 1000), run.elapsed)
    gaps = np.append(run.gaps_at(times), run.gaps)
    x, y = run.points_at(times)[:, 0].T * [[mirror], [1]]
    behind = (x > 1e-3) & (x < 2 - 1e-3) & (y < -0.5)
    assert behind.sum() > 50
    assert np.isinf(gaps[:-1][behind]).all()
    assert (gaps >= 0).all()


def turned(points, angle):
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(points) @ np.array([[cos, sin], [-sin, cos]])


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.5, 0.7, 1.1, 1.5, 2.0, -2.7])
def test_at_a_wall_the_rounding_error_of_gravity_brings_no_contact_to_rest(angle):
    """Two feet of a body that jams between a wall and a slope are hit in turn. The component of gravity along the
    normal of the wall is zero. In a turned world its computed value is a rounding error, and the time in which it
    would stop the foot has no meaning."""
    ground = [(-9, -3.695), (-3.156, -0.42), (-2.248, -1.251)]
    wall = [(-2.248, 1.126), (-3.114, 2.775)]
    feet = [(-3.655, 0.574), (-3.699, 1.374), (-3.36, 0.712)]
    posture = sf.Posture(
        mass=1,
        gyration_radius=0.2347,
        center_of_mass=turned((-3.338, 1.094), angle),
        contacts=[sf.Contact(turned(foot, angle), friction=1.023) for foot in feet],
        restitution=0.2176,
        gravity=G,
        terrain=turned(ground + wall, angle),
    )
    run = sf.simulate(
        posture,
        (0, 0, 0),
        (*turned((1.156, 0.732), angle), -1.79),
        impact="stronge",
        model="full",
        ground_motion=sf.GroundMotion([0], tilt=[-angle]),
        record=False,  # the error of the sum alone
    )
    assert run.outcome == "rest"
    (zeno,) = run.zeno_points
    assert zeno.contacts == (2, 3)
    assert zeno.time_error < 1e-14


def entries(terrain, posture, run):
    """The contacts and pieces that a contact has crossed from its front, away from its ends, at 1000 times."""
    q = np.array([run.at(t)[0] for t in np.linspace(0, run.time, 1000)])
    center, found = np.array(posture.center_of_mass), []
    cos, sin = np.cos(q[:, 2]), np.sin(q[:, 2])
    for i, contact in enumerate(posture.contacts):
        arm = np.array(contact.point) - center
        at = (
            center
            + q[:, :2]
            + np.stack(
                [cos * arm[0] - sin * arm[1], sin * arm[0] + cos * arm[1]], axis=1
            )
        )
        for k, (a, b) in enumerate(pairwise(terrain)):
            length = math.dist(a, b)
            tangent = np.subtract(b, a) / length
            along = (at - a) @ tangent
            height = (at - a) @ (-tangent[1], tangent[0])
            inside = (along > 1e-3) & (along < length - 1e-3)
            front, behind = height[:-1] > -1e-8, height[1:] < -1e-6
            if (front & behind & inside[:-1] & inside[1:]).any():
                found.append((i + 1, k + 1))
    return found


def heights_over_pieces(terrain, points):
    """Heights of points (..., 2) over the nearest piece, NaN where its nearest point is one of its ends, and where it faces up:
    there a vertical separates it from neighbours that face up, too."""
    least, heights = (
        np.full(points.shape[:-1], np.inf),
        np.full(points.shape[:-1], np.nan),
    )
    for a, b in pairwise(np.array(terrain)):
        length = math.dist(a, b)
        tangent = (b - a) / length
        along = (points - a) @ tangent
        height = (points - a) @ (-tangent[1], tangent[0])
        distance = np.hypot(along - np.clip(along, 0, length), height)
        nearer = distance < least
        least[nearer] = distance[nearer]
        heights[nearer] = np.where(
            (along > 1e-9) & (along < length - 1e-9) & (tangent[0] <= 0), height, np.nan
        )[nearer]
    return heights


def test_nothing_enters_walls_and_overhangs():
    """No contact enters the ground, and no run gains energy. Exception: with Moreau's law energy may increase in an
    impact."""
    outcomes, compared = Counter(), np.zeros(2)
    for seed in range(SCENES):
        terrain, posture, qdot, options = random_scene(np.random.default_rng([7, seed]))
        run = sf.simulate(posture, (0, 0, 0), qdot, **options)
        outcomes[run.outcome] += 1
        assert not entries(terrain, posture, run), seed
        times = np.linspace(0, run.time, 200)
        heights = heights_over_pieces(terrain, run.points_at(times))
        over = heights > 1e-9
        for gaps in run.gaps_at(times), posture.gaps(run.at(times)[0]):
            near = over & np.isfinite(gaps)  # a vertical ends the terrain
            np.testing.assert_allclose(
                gaps[near], heights[near], atol=1e-9, err_msg=f"scene {seed}"
            )
            compared += np.array([near.sum(), over.sum()])
        if options["impact"] == "moreau":
            continue
        energies = [run.energy(t) for t in np.linspace(0, run.time, 200)]
        rise = np.max(np.diff(energies), initial=0.0)
        assert rise <= 1e-9 * (1 + np.abs(energies).max()), seed
    print(outcomes)
    assert compared[0] > 0.9 * compared[1]
    assert outcomes["event-limit"] <= 0.01 * SCENES


@pytest.mark.parametrize(
    ("terrain", "text"),
    [
        ([(0, 0), (2, 0), (1, 0)], "pieces 1 and 2 meet"),
        ([(-1, 0), (2, 0), (2, 2), (1, 2), (1, -1)], "pieces 1 and 4 meet"),
        ([(-1, 0), (1, 0), (1, 1), (-1, 1), (-1, 0)], "pieces 1 and 4 meet"),
    ],
)
def test_a_terrain_that_meets_itself_is_refused(terrain, text):
    with pytest.raises(ValueError, match=text):
        particle(terrain, (0.0, 0.0), 0.5)


@pytest.mark.parametrize("y", [0.3, 0.1 * 3, 0.0, -0.0])
def test_a_ceiling_that_is_level_up_to_rounding(y):
    posture = particle(
        [(-1, 0.3 * (y != 0)), (-1, -2), (1, -2), (1, y), (-0.9, 0.3 * (y != 0))],
        (0, y - 0.05),
        0.0,
    )
    assert posture.contacts[0].slope == math.pi
    assert posture.gaps((0, 0, 0))[0] == pytest.approx(0.05, rel=1e-14)


def test_the_slope_of_a_ceiling():
    with pytest.raises(
        ValueError, match=r"slope = -3.14.*a ceiling has slope = math.pi"
    ):
        sf.Posture(
            mass=1,
            gyration_radius=1,
            center_of_mass=(0, 0),
            contacts=[sf.Contact((0, 0), slope=-math.pi)],
            restitution=0,
        )


def test_a_fast_spinning_box_is_hit_only_where_it_touches():
    """It falls towards a slit, with some 2 800 rad/s: at its first impact the contacts whose gap is zero are on the ground. Its corners pass
    over hundreds of pieces before, and the gap of one of four corners follows from those of the others."""
    slit = [(-40.0, 0.0), (-0.2, 0.0), (-0.2, -1.0), (0.2, -1.0), (0.2, 0.1), (40.0, 0.0)]  # fmt: skip
    corners = [(-1.17, 2.1), (-0.74, 1.255), (-0.014, 1.625), (-0.443, 2.47)]
    box = sf.Posture.polygon(corners, terrain=slit)
    points = sf.Posture(box.mass, box.gyration_radius, box.center_of_mass, box.contacts, 0.3, terrain=slit)  # fmt: skip
    at, hit = np.array(box.center_of_mass), 0
    for k in range(40):
        rng = np.random.default_rng([28, k])
        v = rng.uniform(0.5, 0.8), rng.uniform(-0.5, -0.2), rng.uniform(2000, 3500)
        run = sf.simulate(points, (0, 0, 0), v, model="full", impact="poisson", time_limit=1.5, event_limit=200)  # fmt: skip
        if not len(run.impacts):
            continue
        t = run.impacts["time"][0]
        c, s = math.cos(v[2] * t), math.sin(v[2] * t)
        center = at + np.array([v[0] * t, v[1] * t - 9.81 * t**2 / 2])
        for i in np.nonzero(run.gaps_at(t) == 0)[0]:
            x, y = np.array(box.contacts[i].point) - at
            point = center + np.array([c * x - s * y, s * x + c * y])
            away = min(depths.distance(point, np.array(a), np.array(b)) for a, b in pairwise(slit))  # fmt: skip
            assert away < 1e-9, (k, i, away)
            hit += 1
    assert hit > 15
