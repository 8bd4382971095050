"""Terrain with ends: polylines and segments, compared with closed forms, a second method and the same ground in one piece."""

import itertools
import math
import os
import pickle
import random
from collections import Counter

import numpy as np
import pytest
import standfast as sf
from bodies import LAWS, draw_contacts, frame, order_for, valley
from scipy.optimize import linprog

G = 10.0
#: Number of random scenes on polylines.
SCENES = int(os.environ.get("STANDFAST_TERRAIN_SCENES", "500"))
#: Height of vertices on a floor that is straight but for this, in m.
BEND = 1e-13
#: Part of them whose accumulations take more than 1e5 events.
LONG = 0.006


def particle(terrain, x, y, *, friction=0.0, restitution=0.0, gravity=G):
    """A body whose only contact is its centre of mass."""
    return sf.Posture(
        mass=1.0,
        gyration_radius=0.1,
        center_of_mass=(x, y),
        contacts=[sf.Contact(point=(x, y), friction=friction)],
        restitution=restitution,
        gravity=gravity,
        terrain=terrain,
    )


def mode_events(run):
    return [(phase.mode, phase.cause) for phase in run.phases]


def in_a_valley(run, feet, left, right):
    """Positions along a valley with these slopes, and heights above it, of feet given from the centre of mass, at 200 times
    of a run, from the rotation alone."""
    q, _ = run.at(np.linspace(0, run.elapsed, 200))
    center = run.posture.center_of_mass
    cos, sin = np.cos(q[:, 2]), np.sin(q[:, 2])
    places, gaps = [], []
    for u, w in feet:
        x = center[0] + q[:, 0] + cos * u - sin * w
        y = center[1] + q[:, 1] + sin * u + cos * w
        places.append(x)
        gaps.append(y - np.maximum(-left * x, right * x))
    return np.array(places), np.array(gaps)


def test_a_body_that_comes_to_rest_with_a_foot_in_a_vertex_stays_on_the_ground():
    """One of its feet slides to and fro over the vertex in infinitely many rounds that are summed."""
    rng = random.Random(2)
    wedged = 0
    for _ in range(600):
        left, right = (round(rng.uniform(0.2, 1.2), 1) for _ in range(2))
        feet = [
            (round(rng.uniform(-0.4, 0.4), 1), round(rng.uniform(-0.4, 0.1), 1))
            for _ in range(2)
        ]
        if feet[0] == feet[1]:
            continue
        contacts = [
            sf.Contact((x, 6 + y), friction=rng.choice([0, 0.3])) for x, y in feet
        ]
        ground = valley(left, right, 9)
        body = sf.Posture(
            1.0, rng.choice([0.2, 0.5]), (0.0, 6.0), contacts, 0.0, 9.81, terrain=ground
        )
        q = [
            round(rng.uniform(*ends), 1) for ends in ((-0.5, 0.5), (-4.5, -4), (-1, 1))
        ]
        qdot = (rng.uniform(-2, 2), 0, rng.uniform(-2, 2))
        try:
            run = sf.simulate(
                body, q, qdot, model="full", time_limit=4.0, event_limit=3000
            )
        except ValueError:
            continue  # starts in the ground
        places, gaps = in_a_valley(run, feet, left, right)
        assert gaps.min() > -1e-12, (left, right, feet, q, qdot)
        hit = run.impacts
        rates = hit["rates_before"][np.arange(len(hit)), hit["index"]]
        assert (rates <= 0).all()  # zero: at rest, and hit together with another
        wedged += run.outcome == "rest" and abs(places[:, -1]).min() < 1e-9
    assert wedged > 10


def test_feet_that_come_to_vertices_at_once_collide_at_once():
    ground = [(-2, 0.5), (-1, 0), (-0.5, 0.5), (0, 0), (0.5, 0.5), (1, 0), (1.5, 0.5), (2, 0), (3, 1)]  # fmt: skip
    feet = [sf.Contact((x, 0.25)) for x in (-0.25, 0.75)]
    ends = {}
    for order in (feet, feet[::-1]):
        body = sf.Posture(1.0, 0.5, (0.5625, 0.5), order, 0.5, 8.0, terrain=ground)
        for policy in ("newton", "first-contact-first", "last-contact-first"):
            run = sf.simulate(
                body, (0, 0, 0), (0, 0, 0), model="full", time_limit=0.5, simultaneous=policy
            )  # fmt: skip
            assert "contacts 1 and 2 collided at the same instant" in run.warnings[0]
            first = run.impacts[0]
            # Sliding down a slope of 45° for .25 m on both feet: a = g/√2.
            assert first["elapsed"] == pytest.approx(0.5 / math.sqrt(2), rel=1e-15)
            ends[policy, order is feet] = run.q
    for one, other in (
        ("newton", "newton"),
        ("first-contact-first", "last-contact-first"),
        ("last-contact-first", "first-contact-first"),
    ):
        assert ends[one, True] == pytest.approx(ends[other, False], abs=1e-13)
    sequence = ends["first-contact-first", True] - ends["last-contact-first", True]
    assert abs(sequence).max() > 0.1


def test_off_a_table_onto_the_floor():
    posture = particle([(-5, 0), (0, 0), (1e-9, -2), (9, -2)], -1, 0, friction=0.5)
    run = sf.simulate(posture, (0, 0, 0), (4, 0, 0), impact="newton")
    # Decelerated by 5 m/s² over 1 m: √(16 − 10); a fall of 2 m; then 6/(2·5) m on the floor.
    fall = math.sqrt(2 * 2 / G)
    speed = math.sqrt(6)
    assert run.outcome == "rest"
    assert mode_events(run) == [
        ("R", "start"),
        ("S", "left-segment"),
        ("R", "zeno"),
        ("F", "stop"),
    ]
    assert run.phases[1].contact == 1
    assert run.phases[1].start == pytest.approx((4 - speed) / 5, rel=1e-15)
    assert run.phases[2].start == pytest.approx((4 - speed) / 5 + fall, rel=1e-15)
    assert run.q[0] == pytest.approx(1 + speed * fall + 0.6, rel=1e-15)
    assert run.q[1] == pytest.approx(-2, rel=1e-15)


def test_past_the_end_of_a_segment_there_is_nothing():
    contact = sf.Contact(point=(0.0, 0.0), segment=(-1.0, 2.0))
    posture = sf.Posture(1.0, 0.1, (0.0, 0.0), [contact], restitution=0.5, gravity=G)
    run = sf.simulate(posture, (0, 0, 0), (1, 0, 0))
    assert (run.outcome, run.time) == ("escape", 2.0)
    assert mode_events(run) == [("R", "start"), ("S", "left-segment")]
    assert run.gaps[0] == math.inf
    # The first bounce lands on the segment, the next one beyond its end.
    run = sf.simulate(posture, (0, 5, 0), (1.5, 0, 0), time_limit=4.0)
    assert [float(t) for t in run.impacts["time"]] == [1.0]
    assert run.outcome == "time-limit"
    assert run.q == pytest.approx([6.0, 10 * 0.5 * 3 - 5 * 9 + 0.0, 0.0])
    for x, gap in ((-1.0, 1.0), (-1.0000001, math.inf), (2.0, 1.0), (2.1, math.inf)):
        assert posture.gaps((x, 1, 0))[0] == gap


@pytest.mark.parametrize(("alpha", "beta"), [(0.4, 0.3), (0.9, 0.1), (0.6, 0.6)])
def test_to_and_fro_in_a_valley(alpha, beta):
    """Each passage of the vertex multiplies the speed by cos(α + β); up and down a side take 2v/(g sin) each."""
    down = 1.0
    terrain = [(-9, 9 * math.tan(alpha)), (0, 0), (9, 9 * math.tan(beta))]
    start = (-down * math.cos(alpha), down * math.sin(alpha))
    posture = particle(terrain, *start)
    speed = math.sqrt(2 * G * down * math.sin(alpha))
    keep = math.cos(alpha + beta)
    first = speed / (G * math.sin(alpha))
    up, back = (2 * speed / (G * math.sin(slope)) for slope in (beta, alpha))
    expected = first + (up * keep + back * keep**2) / (1 - keep**2)
    run = sf.simulate(posture, (0, 0, 0), (0, 0, 0))
    assert run.outcome == "rest"
    assert run.phases[-1].mode == "F"
    assert run.elapsed == pytest.approx(expected, rel=1e-13)
    assert run.q == pytest.approx([-start[0], -start[1], 0.0], abs=1e-13)
    assert run.collisions < 2 * math.log(1e-14) / math.log(keep) + 20


def test_a_corner_of_a_body_rests_in_a_vertex():
    """The other foot supports it: the vertex carries forces of both of its sides, and the body stays."""
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.3,
        center_of_mass=(0.0, 0.5),
        contacts=[sf.Contact(point=(-0.5, 0.0)), sf.Contact(point=(0.5, 0.0))],
        restitution=0.1,
        gravity=G,
        terrain=[(-2, 0.75), (-0.5, 0), (0, 0.4), (0.2, 0), (3, 0)],
    )
    run = sf.simulate(posture, (0.0, 0.02, 0.001), (-0.1, 0, 0))
    assert run.outcome == "rest"
    assert run.phases[-1].mode == "FF"
    assert run.q == pytest.approx([0, 0, 0], abs=1e-12)


@pytest.mark.parametrize("law", ["newton", "stronge"])
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_a_pendulum_in_a_vertex(friction, law):
    """A rod stands in a vertex and falls over. The sides hold its foot like a hinge, I θ̇²/2 + m g l cos θ constant, until
    one of their forces would be negative: the force leaves the cone of the vertex, and the foot slides up the other side."""
    rho, length, tilt = 0.4, 0.8, 0.01
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=rho,
        center_of_mass=(0.0, length),
        contacts=[sf.Contact((0.0, 0.0), friction=friction)],
        restitution=0.5,
        gravity=G,
        terrain=[(-9, 9), (0, 0), (9, 9)],
    )
    inertia = rho**2 + length**2
    start = (-length * math.sin(tilt), length * (math.cos(tilt) - 1), tilt)
    rate = 0.1
    qdot = (-length * math.cos(tilt) * rate, -length * math.sin(tilt) * rate, rate)
    run = sf.simulate(posture, start, qdot, impact=law, time_limit=3.0, model="full")
    assert run.outcome == "time-limit"
    hinge = run.phases[0]
    assert hinge.mode == "F"
    # Forces of the hinge: a = l (−θ̈ cos θ + θ̇² sin θ, −θ̈ sin θ − θ̇² cos θ), in a cone of 45° + α about the vertical.
    q, qdot = run.at(hinge.end)
    theta, omega = q[2], qdot[2]
    assert omega**2 == pytest.approx(
        rate**2 + 2 * G * length * (math.cos(tilt) - math.cos(theta)) / inertia,
        rel=1e-11,
    )
    alpha = G * length * math.sin(theta) / inertia
    sin, cos = math.sin(theta), math.cos(theta)
    force = (
        length * (-alpha * cos + omega**2 * sin),
        G + length * (-alpha * sin - omega**2 * cos),
    )
    edge = math.pi / 4 + math.atan(friction)
    assert abs(math.atan2(force[0], force[1])) == pytest.approx(edge, abs=1e-9)
    times, q, _ = run.sample(500)
    assert posture.gaps(q).min() > -1e-12
    energy = run.energy(times)
    assert np.diff(energy).max() <= 1e-12 * np.ptp(energy)


def test_a_foot_that_stops_without_gravity_is_in_no_vertex():
    """Poisson's law stops it on a side of a valley. It continues to slide there, .27 m from the vertex."""
    posture = sf.Posture(
        1.0,
        0.1,
        (-1.0, 1.6),
        [sf.Contact((-0.7, 1.5), friction=0.8), sf.Contact((-0.6, 1.9), friction=0.8)],
        0.0,
        0.0,
        terrain=[(-5, 3), (-1, 0.2), (0, 0.6), (1, 0.2), (5, 3)],
    )
    start = np.array([0.0, 0.0, -0.25])
    start[1] = 1e-9 - posture.gaps(start)[0] / math.cos(math.atan(0.4))
    run = sf.simulate(
        posture,
        start,
        (-0.46, -1.2, 0),
        impact="poisson",
        simultaneous="first-contact-first",
        time_limit=0.5,
    )
    assert run.collisions > 0
    for t in np.linspace(0, run.time, 100):
        gaps = run.gaps_at(t)
        assert gaps == pytest.approx(posture.gaps(run.at(t)[0]), abs=1e-12)


def test_a_foot_far_off_does_not_rest_without_gravity():
    """Impacts at feet 1 and 2, in turn, make the body slide along their side; foot 3 is then equally slow, .4 m above it."""
    points = [(-0.22, 1.28), (-0.96, 1.38), (-0.22, 1.69)]
    posture = sf.Posture(
        1.0,
        0.1,
        (-0.38, 1.59),
        [sf.Contact(point) for point in points],
        0.0,
        0.0,
        terrain=[(-5, 0.47), (-1.2, -0.36), (-1.12, 0.2), (-0.2, -0.07), (5, 0.4)],
    )
    start = np.array([0.0, 0.0, -0.18])
    start[1] = 1e-9 - posture.gaps(start)[0] / math.cos(math.atan(0.27 / 0.92))
    run = sf.simulate(
        posture,
        start,
        (-1.11, 0, 0),
        simultaneous="last-contact-first",
        time_limit=1.0,
    )
    assert run.zeno_points[-1].contacts == (1, 2)
    for t in np.linspace(0, run.time, 100, endpoint=False):
        gaps, expected = run.gaps_at(t), posture.gaps(run.at(t)[0])
        met = np.isfinite(gaps)
        assert gaps[met] == pytest.approx(expected[met], abs=1e-12)


def test_a_point_over_a_piece_again_is_not_there_at_once():
    """A point beside the terrain has no gap. When it comes above the terrain again, it falls from its current
    position and does not touch the ground at once."""
    posture = sf.Posture(
        1.0,
        0.3,
        (0.0, 1.0),
        [sf.Contact((-0.5, 0.5)), sf.Contact((0.5, 0.5))],
        0.3,
        G,
        terrain=[(-0.7, 0), (0.7, 0)],
    )
    for spin in (-9.0, -4.0, 4.0, 9.0):
        run = sf.simulate(posture, (0.5, 1.0, 0), (-1.5, 0, spin), time_limit=1.0)
        for t in np.linspace(0, run.time, 300, endpoint=False):
            gaps, expected = run.gaps_at(t), posture.gaps(run.at(t)[0])
            met = np.isfinite(gaps)
            assert gaps[met] == pytest.approx(expected[met], abs=1e-12)


def bounces(terrain, position, velocity, restitution, count):
    """The first bounces of a particle on a polyline: roots of quadratics, piece by piece, the earliest one."""
    time, hits = 0.0, []
    (x, y), (vx, vy) = position, velocity
    last = None
    for _ in range(count):
        best = None
        for k, ((x0, y0), (x1, y1)) in enumerate(itertools.pairwise(terrain)):
            length = math.hypot(x1 - x0, y1 - y0)
            nx, ny = -(y1 - y0) / length, (x1 - x0) / length
            h, u = nx * (x - x0) + ny * (y - y0), nx * vx + ny * vy
            for t in np.roots([-G * ny / 2, u, 0.0 if k == last else h]):
                if abs(t.imag) > 0 or t.real <= 1e-9 or u - G * ny * t.real >= 0:
                    continue
                t = float(t.real)
                inside = x0 <= x + vx * t <= x1
                if inside and (best is None or t < best[0]):
                    best = (t, k, nx, ny)
        if best is None:
            break
        t, last, nx, ny = best
        time, x, y, vy = time + t, x + vx * t, y + vy * t - G * t * t / 2, vy - G * t
        rate = nx * vx + ny * vy
        vx, vy = vx - (1 + restitution) * rate * nx, vy - (1 + restitution) * rate * ny
        hits.append((time, vx, vy))
    return hits


def test_bounces_of_a_particle_on_random_polylines():
    """Compared with textbook roots as long as these are accurate: a few bounces, then errors have grown."""
    random = np.random.default_rng(20)
    compared = 0
    for _ in range(150):
        count = int(random.integers(2, 9))
        xs = np.sort(random.uniform(-3, 3, count))
        if np.min(np.diff(xs)) < 1e-2:
            continue
        terrain = [(float(x), float(random.uniform(-1, 1))) for x in xs]
        x = float(random.uniform(xs[0], xs[-1]))
        y, e = 2.0, float(random.uniform(0.3, 0.9))
        v = [float(s) for s in random.normal(0, 2, 2)]
        posture = particle(terrain, x, y, restitution=e)
        run = sf.simulate(posture, (0, 0, 0), (*v, 0), time_limit=3.0, model="full")
        mine = run.impacts[:4]
        others = [hit for hit in bounces(terrain, (x, y), v, e, 4) if hit[0] < 3.0]
        assert len(mine) == len(others)
        for hit, (time, vx, vy) in zip(mine, others, strict=True):
            assert hit["time"] == pytest.approx(time, rel=1e-9)
            if hit["time"] < run.time:
                _, qdot = run.at(hit["time"])
                assert qdot[:2] == pytest.approx([vx, vy], abs=1e-7)
            compared += 1
    assert compared > 200


def test_a_floor_in_pieces_is_a_floor():
    """Random bodies on one or two feet have the same final state as on the floor in one piece. (More feet on one line land
    together.) The pieces are bent against each other by about 1e-13 rad: exactly straight, they would be one piece."""
    random = np.random.default_rng(7)
    rests = left = 0
    for case in range(150):
        feet = 1 if case % 4 == 0 else 2
        xs = [float(x) for x in np.sort(random.uniform(-1, 1, feet))]
        friction = float(random.choice([0.0, 0.2, 0.6]))
        contacts = [
            sf.Contact((x, 0.0), friction=friction, restitution=0.1 if i else 0.1000001)
            for i, x in enumerate(xs)
        ]
        whole = sf.Posture(1.0, 0.5, (0.05, 0.4), contacts, 0.1, G)
        inner = np.sort(random.uniform(-2, 2, 7))
        parts = sf.Posture(
            1.0,
            0.5,
            (0.05, 0.4),
            contacts,
            0.1,
            G,
            terrain=[
                (-50.0, 0.0),
                *((float(x), BEND * random.normal()) for x in inner),
                (50.0, 0.0),
            ],
        )
        q = (0.0, 0.1, float(random.normal(0, 0.02)))
        qdot = tuple(float(v) for v in random.normal(0, 0.5, 3))
        options = {
            "impact": "chatterjee-ruina" if friction else "newton",
            "simultaneous": "first-contact-first",
            "time_limit": 4.0,
        }
        one, other = (sf.simulate(body, q, qdot, **options) for body in (whole, parts))
        if abs(one.q[2]) > 1.0:
            continue  # upside down all its feet land at once: rounding breaks the tie
        assert one.outcome == other.outcome
        assert other.elapsed == pytest.approx(one.elapsed, rel=1e-9)
        assert other.q == pytest.approx(one.q, abs=1e-9)
        rests += one.outcome == "rest"
        left += any(phase.cause == "left-segment" for phase in other.phases)
    assert rests > 20
    assert left > 10


def test_energy_never_rises_on_a_polyline():
    random = np.random.default_rng(11)
    for _ in range(60):
        xs = np.linspace(-4, 4, 9)
        ys = np.concatenate([[3], random.uniform(-0.5, 0.5, 7), [3]])
        posture = sf.Posture(
            1.0,
            0.3,
            (0.0, 1.5),
            [
                sf.Contact((-0.4, 1.1), friction=0.3),
                sf.Contact((0.4, 1.1), friction=0.3),
                sf.Contact((0.0, 1.9), friction=0.3),
            ],
            0.3,
            G,
            terrain=list(zip(xs.tolist(), ys.tolist(), strict=True)),
        )
        qdot = random.normal(0, 2, 3)
        run = sf.simulate(
            posture,
            (0, 0, 0),
            qdot,
            impact="chatterjee-ruina",
            simultaneous="first-contact-first",
            event_limit=20_000,
        )
        times, _, _ = run.sample(400)
        energy = run.energy(times)
        scale = float(np.ptp(energy))
        assert np.max(np.diff(energy)) <= 1e-12 * scale
        for t in times[:-1]:
            gaps = run.gaps_at(t)
            assert np.min(gaps) >= 0.0


def test_a_spinning_body_that_falls_past_the_end_is_gone():
    posture = sf.Posture(
        1.0,
        0.3,
        (0.0, 0.5),
        [sf.Contact((-0.5, 0.0)), sf.Contact((0.5, 0.0))],
        0.5,
        G,
        terrain=[(-1, 0), (1, 0)],
    )
    run = sf.simulate(posture, (1.2, 0.0, 0.0), (0.5, -1.0, 30.0))
    assert run.outcome == "escape"
    assert len(run.phases) < 100


def test_slopes_and_segments_follow_from_the_terrain():
    terrain = [(-2, 2), (0, 0), (1, 0), (3, 1)]
    contacts = [sf.Contact((-1.0, 1.0)), sf.Contact((2.0, 0.5), friction=0.2)]
    posture = sf.Posture(1.0, 0.5, (0.5, 1.0), contacts, 0.1, terrain=terrain)
    one, two = posture.contacts
    assert one.slope == pytest.approx(-math.pi / 4, rel=1e-15)
    assert one.segment == pytest.approx((-math.sqrt(2), math.sqrt(2)), rel=1e-15)
    assert two.slope == pytest.approx(math.atan(0.5), rel=1e-15)
    same = pickle.loads(pickle.dumps(posture))
    assert same == posture
    assert eval(repr(posture), vars(sf)) == posture
    assert posture.terrain == terrain
    # A contact may begin in the air; gaps are those over the piece below.
    high = sf.Posture(1.0, 0.5, (0, 0.5), [sf.Contact((0.5, 0.25))], 0, terrain=terrain)
    assert high.gaps([[0, 0, 0], [-1.5, 2.0, 0], [9, 0, 0]])[:, 0] == pytest.approx(
        [0.25, (2.25 - 1.0) / math.sqrt(2), math.inf]
    )


def test_a_scene_with_terrain_survives_its_file(tmp_path):
    text = """
        gravity = 10.0
        restitution = 0.0
        terrain = [[-5.0, 0.0], [0.0, 0.0], [5.0, 2.5]]
        [body]
        mass = 1.0
        gyration_radius = 0.1
        center_of_mass = [-1.0, 0.0]
        [[contact]]
        point = [-1.0, 0.0]
        [start]
        qdot = [1.0, 0.0, 0.0]
        [run]
        model = "full"
        time_limit = 1.1
    """
    path = tmp_path / "scene.toml"
    path.write_text(text, encoding="utf-8")
    scene = sf.load(path)
    run = scene.simulate()
    # Up the slope at the speed after the inelastic impact with it, decelerated by g sin.
    up = math.cos(math.atan(0.5)) - 0.1 * G * math.sin(math.atan(0.5))
    assert run.qdot[:2] == pytest.approx(
        [up * math.cos(math.atan(0.5)), up * math.sin(math.atan(0.5))]
    )
    for name in ("again.toml", "again.json"):
        scene.save(tmp_path / name)
        again = sf.load(tmp_path / name)
        assert again.posture == scene.posture
        assert (again.simulate().q == run.q).all()


@pytest.mark.parametrize(
    ("terrain", "text"),
    [
        ([(0, 0)], "terrain"),
        ([(0, 0), (0, 0)], "terrain.2"),
        ([(0, 0), (1, 0), (0.5, 0)], "meet"),
        ([(0, 0), (math.nan, 1)], "terrain.2.x"),
        ([(0, 0), (1, 2, 3)], "terrain.2"),
        ([(1, 0), (2, 0)], "contacts.1.point.x"),
        ([(-1, 1), (1, 1)], "contacts.1.point"),
        ([(k, 0) for k in range(1025)], "terrain"),
        ([(-1e-300, 0), (1e-300, 1e300)], "terrain.2.y"),
    ],
)
def test_a_wrong_terrain_is_named(terrain, text):
    with pytest.raises(ValueError, match=text):
        particle(terrain, 0.0, 0.0)


@pytest.mark.parametrize(
    "contact",
    [
        sf.Contact((0.0, 0.0), slope=0.1),
        sf.Contact((0.0, 0.0), segment=(-0.5, 0.5)),
    ],
)
def test_a_slope_of_its_own_contradicts_a_terrain(contact):
    with pytest.raises(ValueError, match="terrain of the posture determines it"):
        sf.Posture(1.0, 0.1, (0, 0), [contact], 0.0, terrain=[(-1, 0), (1, 0)])


@pytest.mark.parametrize("terrain", ["flat", 3, [1, 2], {1: 2, 3: 4}])
def test_what_is_no_terrain(terrain):
    with pytest.raises((TypeError, ValueError), match="terrain"):
        particle(terrain, 0.0, 0.0)


def hills(rng):
    """One to four contacts over three to seven vertices; `None` where a contact begins in the ground."""
    vertices = rng.integers(3, 8)
    x = np.sort(rng.uniform(-2, 2, vertices))
    x[[0, -1]] = -4, 4
    y = rng.uniform(-0.6, 0.6, vertices) * rng.choice([0.2, 1.0, 2.0])
    contacts = draw_contacts(
        rng,
        (rng.uniform(-0.6, 0.6) for _ in range(rng.choice([1, 2, 2, 3, 4]))),
        rise=0.1,
        steep=0,
        friction=lambda: rng.choice([0.0, rng.uniform(0, 2)]),
    )
    if (np.diff(x) < 1e-3).any() or any(
        np.interp(c.point[0], x, y) > c.point[1] for c in contacts
    ):
        return None
    return sf.Posture(
        mass=1.0,
        gyration_radius=rng.uniform(0.1, 0.6),
        center_of_mass=(rng.uniform(-0.3, 0.3), rng.uniform(-0.1, 0.8)),
        contacts=contacts,
        restitution=rng.choice([0.0, rng.uniform(0, 0.9)]),
        gravity=G,
        terrain=list(zip(x.tolist(), y.tolist(), strict=True)),
    )


def test_random_scenes_on_polylines_end():
    """No run slides to and fro over a vertex for ever; -s prints the outcomes."""
    outcomes, long = Counter(), []
    for seed in itertools.count():
        rng = np.random.default_rng([77, seed])
        posture = hills(rng)
        if posture is None:
            continue
        q = np.array([0.0, 0.0, rng.uniform(-0.3, 0.3)])
        while (gaps := posture.gaps(q)).min() < 0:
            q[1] += max(-gaps.min(), 0.05)
        qdot = rng.normal(size=3) * rng.choice([0.0, 0.3, 1.0])
        run = sf.simulate(
            posture,
            q,
            qdot,
            impact=str(rng.choice(LAWS)),
            simultaneous="first-contact-first",
            time_limit=5.0,
            event_limit=100_000,
            record=False,
        )
        outcomes[run.outcome] += 1
        assert min(run.gaps) > -1e-9, seed
        if run.outcome == "event-limit":
            long.append(seed)
        if outcomes.total() == SCENES:
            break
    print(f"\n{dict(outcomes)}, more than 1e5 events: {long}")
    assert len(long) <= LONG * SCENES


def test_a_foot_that_starts_on_a_convex_vertex_with_a_speed_of_rounding_leaves_it():
    """The velocities of the body cancel in the foot up to 1e-16 m/s. Over each of the two pieces of terrain the foot
    moves towards the other piece."""
    foot = (0.0, 0.27064503871920126)
    ridge = [(-0.6549354226966, 0.20285948495668776), foot]
    ridge += [(0.6922633590620269, 0.00859543729937201), (9.0, 4.0)]
    feet = [foot, (0.4644279622394105, 0.33758088338440995)]
    body = sf.Posture(
        1.0,
        0.256586794998143,
        (0.9479755790580011, 0.6173078950414242),
        [sf.Contact(point, friction=0.4103640628390497) for point in feet],
        0.0,
        G,
        terrain=ridge,
    )
    qdot = (0.4790219354926696, -1.3099214074958787, -1.3818092326782736)
    for law in ("newton", "moreau", "poisson", "stronge", "chatterjee-ruina"):
        run = sf.simulate(body, (0, 0, 0), qdot, impact=law, time_limit=0.2)
        assert run.outcome == "time-limit", run.warnings


def test_feet_at_one_point_bounce_into_a_vertex_as_one():
    """Rounding errors separate them in the end: one bounces off the piece on the right, the others off that on the left, and
    impacts of 1e-15 m/s that no longer shrink have no sum."""
    ends = []
    for count in (1, 2, 3):
        posture = sf.Posture(
            1.0,
            0.05191482843137255,
            (-0.03155637254901977, 0.49211090686274506),
            [sf.Contact((-0.03155637254901977, 0.0), friction=0.49211090686274506)]
            * count,
            0.396078431372549,
            G,
            terrain=[
                (-0.7137254901960783, 0.6499387254901962),
                (0.006387867647058823, -0.6980392156862745),
                (1.0901960784313727, 0.0),
            ],
        )
        start = (
            (1.5318627450980392e-5, 0, 0),
            (0.8351256127450981, 1e-9, 0.48030024509803926),
        )
        run = sf.simulate(posture, *start, stop="zeno")
        assert run.outcome == "zeno"
        times, _, _ = run.sample(1000)
        assert np.diff(run.energy(times)).max() <= 1e-12
        ends.append((run.time, *run.q, *run.qdot))
    assert np.ptp(ends, axis=0) == pytest.approx(0, abs=1e-12)


def test_a_foot_that_spins_out_of_a_vertex_leaves_it():
    """Plastic impacts on both pieces stop the foot in the vertex. The body rotates at 5 rad/s, ω² times the height of the
    foot above its centre of mass is more than g, and the foot leaves the vertex at once."""
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.7,
        center_of_mass=(0.3, 1.0),
        restitution=0.0,
        gravity=10.0,
        contacts=[sf.Contact((-0.5, 0.6))],
        terrain=[(-20, 24), (0, 0), (20, 16)],
    )
    start = (-0.5, 1, -0.1), (-6, 2, 0)
    run = sf.simulate(posture, *start, time_limit=3.0, event_limit=3000)
    assert run.outcome == "time-limit"
    first = run.impacts["time"] < 1.59
    stop = run.impacts["time"][first][-1]
    q, (vx, vy, omega) = run.at(stop)
    arm = np.array([-0.3, -1.0]) - q[:2]  # of the foot, in the vertex at (0, 0)
    assert np.hypot(vx - omega * arm[1], vy + omega * arm[0]) < 1e-12
    assert -arm[1] * omega**2 > 20
    cos, sin = math.cos(0.01 * omega), math.sin(0.01 * omega)
    turned = np.array([[cos, -sin], [sin, cos]]) @ arm
    x, y = np.array([vx, vy]) * 0.01 - (0, 0.5 * 10 * 0.01**2) + turned - arm
    above = y - (0.8 if x > 0 else -1.2) * x
    cosine = 1 / math.hypot(1, 0.8 if x > 0 else 1.2)
    assert run.gaps_at(stop + 0.01)[0] == pytest.approx(above * cosine, rel=1e-9)


def test_plastic_landings_on_a_floor_and_on_a_terrain_are_the_same():
    """A body that rotates fast may lift off at once, or be held by friction, or both (Painlevé). One and two contacts on
    lines are computed in other coordinates than those on a polyline, with the same result."""
    rng = np.random.default_rng(4)
    outcomes = []
    for _ in range(400):
        scene = {
            "mass": 1.0,
            "gyration_radius": rng.uniform(0.2, 1),
            "center_of_mass": (rng.uniform(-0.5, 0.5), rng.uniform(0.2, 1.3)),
            "restitution": 0.0,
            "gravity": 10.0,
            "contacts": [
                sf.Contact((x, 0), friction=rng.choice([0, 0.5, 1, 2]))
                for x in rng.uniform(-1, 1, rng.integers(1, 3))
            ],
        }
        floors = (None, [(-50, 0), (50, 0)])
        bodies = [sf.Posture(**scene, terrain=terrain) for terrain in floors]
        q = (0, 0.5, rng.uniform(-0.4, 0.4))
        qdot = (rng.uniform(-3, 3), 0, rng.uniform(-3, 3))
        options = {"model": "full", "impact": "newton", "time_limit": 1.0}
        one, other = (sf.simulate(body, q, qdot, **options) for body in bodies)
        assert one.outcome == other.outcome
        assert one.q == pytest.approx(other.q, abs=1e-9)
        outcomes.append(one.outcome)
    assert outcomes.count("ambiguous") > 10
    assert outcomes.count("inconsistent") > 10


def test_a_foot_over_a_vertex_is_over_one_piece():
    """After a stop in the vertex it takes off with 1e-15 m/s. Rounding decides on which side of the vertex it is."""
    scenes = [
        (0.2, (-0.2, 1.4), [(-0.5, 0.3)], (-20, 12), (20, 16), (0.5, -0.1), (3, -6)),
        (
            0.5,
            (0.1, 1.3),
            [(-0.5, 0.55), (0.5, 0.4)],
            (-20, 22),
            (20, 16),
            (-0.2, 0.4),
            (5, 0),
        ),
    ]
    for gyration, center, points, left, right, (x, theta), (slide, spin) in scenes:
        posture = sf.Posture(
            1.0,
            gyration,
            center,
            [sf.Contact(point) for point in points],
            0.0,
            10.0,
            terrain=[left, (0, 0), right],
        )
        fall = 0 if spin else 2
        run = sf.simulate(
            posture,
            (x, 1, theta),
            (slide, fall, spin),
            time_limit=3.0,
            event_limit=5000,
        )
        assert run.outcome == "time-limit"
        times, _, _ = run.sample(500)
        assert np.diff(run.energy(times)).max() <= 1e-12 * np.ptp(run.energy(times))


def test_a_foot_in_flight_right_above_a_vertex():
    """Level with the centre of mass of a rotating body, it has no horizontal velocity there, and moves to one side
    afterwards: it is at x = d (1 − cos ωt), y = y₀ + vt − gt²/2 − d sin ωt."""
    rng = random.Random(3)
    for _ in range(200):
        d, spin = (rng.uniform(0.1, 0.5) * rng.choice([-1, 1]) for _ in range(2))
        spin *= 10
        rise, left, right = rng.uniform(-1, 1), rng.uniform(-1, 2), rng.uniform(-1, 2)
        posture = sf.Posture(
            1.0,
            0.25,
            (d, 0),
            [sf.Contact((0, 0))],
            0.5,
            G,
            terrain=valley(left, right, 4),
        )
        run = sf.simulate(
            posture,
            (0, 0.25, 0),
            (0, rise, spin),
            model="full",
            time_limit=2.0,
            event_limit=100_000,
        )
        slope = right if d > 0 else -left
        t = np.linspace(0, 0.9, 200_000)
        x = d * (1 - np.cos(spin * t))
        gap = 0.25 + rise * t - G / 2 * t**2 - d * np.sin(spin * t) - slope * x
        first = t[np.argmax(gap < 0)]
        assert run.impacts["time"][0] == pytest.approx(first, abs=1e-5)
        assert run.time == 2.0


@pytest.mark.parametrize("ground", ["slopes", "valley"])
def test_feet_at_one_point_move_as_one(ground):
    """Contacts listed once, twice or three times have the same bits: in flight, in impacts, slides and lift-offs, and in a
    vertex."""
    rng = random.Random(4)
    outcomes = Counter()
    for _ in range(60):
        terrain = valley(rng.choice([0.5, 2]), rng.choice([0.5, 2]), 9)
        friction = rng.choice([0, 0.5, 1, 2])
        points = [(0.0, 0.0)]
        if ground == "slopes":
            points = [(rng.uniform(-1, 1), rng.uniform(-0.3, 0.3)) for _ in range(3)]
        slopes = {"slopes": lambda: {"slope": rng.uniform(-1, 1)}, "valley": dict}[
            ground
        ]
        feet = [sf.Contact(point, friction=friction, **slopes()) for point in points]
        center = (rng.uniform(-0.5, 0.5), rng.uniform(0.4, 1.0))
        gyration, restitution = rng.uniform(0.2, 0.8), rng.choice([0, 0.3])
        law = rng.choice(["newton", "poisson", "chatterjee-ruina"])
        runs = []
        for copies in (1, 2, 3):
            posture = sf.Posture(
                1.0,
                gyration,
                center,
                feet[:1] * copies + feet[1:],
                restitution,
                G,
                terrain=terrain if ground == "valley" else None,
            )
            runs.append(
                sf.simulate(
                    posture,
                    (0, 0, 0),
                    (0, 0, 0),
                    model="full",
                    impact=law,
                    simultaneous=order_for(law),
                    time_limit=2.0,
                    event_limit=20_000,
                )
            )
        outcomes[runs[0].outcome] += 1
        one = runs[0]
        for copies, run in zip((2, 3), runs[1:], strict=True):
            assert run.outcome == one.outcome
            if one.outcome == "event-limit":
                continue  # limit of the recorded rates
            assert (*run.q, *run.qdot, run.time) == (*one.q, *one.qdot, one.time)
            assert [p.mode for p in run.phases] == [
                p.mode[0] * (copies - 1) + p.mode for p in one.phases
            ]
            assert run.gaps[:copies].tolist() == [one.gaps[0]] * copies
            first = [one.impacts["rates_after"][:, 0]] * copies
            assert np.array_equal(run.impacts["rates_after"][:, :copies].T, first)
            again = {c for z in one.zeno_points for c in z.contacts} & {1}
            assert {c for z in run.zeno_points for c in z.contacts if c <= copies} == (
                set(range(1, copies + 1)) if again else set()
            )
    assert outcomes["time-limit"] > 10
    assert len(outcomes) > 1


def both_ways(points, center, gyration, friction, restitution, terrain):
    """A body with its feet at these points over this terrain, and its mirror image."""
    for way in (1, -1):
        yield sf.Posture(
            1.0,
            gyration,
            (way * center[0], center[1]),
            [sf.Contact((way * x, y), friction=friction) for x, y in points],
            restitution,
            G,
            terrain=sorted((way * x, y) for x, y in terrain),
        )


def test_a_body_with_a_foot_in_a_vertex_stands_where_forces_of_both_pieces_can_hold_it():
    """A linear program over the edges of all cones gives the positions; the mirror image behaves in the same way."""
    rng = random.Random(5)
    seen = Counter()
    for _ in range(300):
        left, right = rng.uniform(0.1, 1.5), rng.uniform(0.1, 1.5)
        friction = rng.choice([0.0, 0.3, 1.0])
        x = rng.choice([-1, 1]) * rng.uniform(0.3, 1.0)
        points = [(0.0, 0.0), (x, -left * x if x < 0 else right * x)]
        center, gyration = (
            (rng.uniform(-0.6, 0.6), rng.uniform(0.1, 1)),
            rng.uniform(0.1, 0.6),
        )

        terrain = valley(left, right, 4)
        posture, mirrored = both_ways(points, center, gyration, friction, 0.3, terrain)
        columns = []
        for foot, slope in [
            (points[0], -left),
            (points[0], right),
            (points[1], -left if x < 0 else right),
        ]:
            tangent, normal = frame(math.atan(slope))
            arm = np.subtract(foot, center)
            for mu in (-friction, friction):
                edge = normal + mu * tangent
                columns.append([*edge, arm[0] * edge[1] - arm[1] * edge[0]])
        found = linprog(np.zeros(6), A_eq=np.transpose(columns), b_eq=[0, G, 0])
        held = found.status == 0
        assert (sf.static_forces(posture) is not None) == held
        assert (sf.friction_margin(posture) >= 0) == held
        options = {"model": "full", "time_limit": 2.0, "event_limit": 50_000}
        run, other = (
            sf.simulate(each, (0, 0, 0), (0, 0, 0), **options)
            for each in (posture, mirrored)
        )
        assert run.outcome == other.outcome
        assert held == (run.outcome in ("rest", "ambiguous") and run.time == 0)
        seen[run.outcome if held else "moves"] += 1
    assert seen["rest"] > 30
    assert seen["moves"] > 100
    with pytest.raises(ValueError, match="contact 1 off the vertex of its terrain"):
        sf.contact_modes(posture)


def test_a_foot_in_a_vertex_is_hit_by_both_pieces_at_once():
    """A body rotates about a foot in a vertex, the other foot lands, and its impact presses the first one into both pieces;
    the mirror image behaves in the same way."""
    rng = random.Random(6)
    fell = 0
    for _ in range(200):
        left, right = rng.uniform(0.1, 1.5), rng.uniform(0.1, 1.5)
        friction, restitution = rng.choice([0.0, 0.3, 1.0]), rng.choice([0.0, 0.3])
        x = rng.choice([-1, 1]) * rng.uniform(0.3, 1.0)
        y = (-left * x if x < 0 else right * x) + rng.uniform(0, 0.3)
        center = (rng.uniform(-0.6, 0.6), rng.uniform(0.1, 1))
        gyration = rng.uniform(0.1, 0.6)
        terrain = valley(left, right, 4)
        run, other = (
            sf.simulate(posture, (0, 0, 0), (0, 0, 0), model="full", time_limit=0.5)
            for posture in both_ways(
                [(0, 0), (x, y)], center, gyration, friction, restitution, terrain
            )
        )
        landed = run.impacts["time"][run.impacts["index"] == 1]
        if len(landed) == 0 or run.phases[0].mode != "FS":
            continue
        fell += 1
        # Only the first few impacts: later ones amplify rounding errors.
        end = min(run.time, other.time, landed[0] + 1e-3)
        for t in (landed[0] / 2, end):
            assert run.at(t)[0] == pytest.approx(other.at(t)[0] * (-1, 1, -1), abs=1e-9)
    assert fell > 20


def test_the_local_model_needs_straight_lines_without_ends():
    foot = sf.Contact((0, 0), segment=(-1.0, 1.0))
    body = {"mass": 1.0, "gyration_radius": 0.3, "center_of_mass": (0, 0.5), "restitution": 0.5}  # fmt: skip
    on_segment = sf.Posture(contacts=[foot], **body)
    on_terrain = sf.Posture(
        contacts=[sf.Contact((0, 0))], terrain=[(-1, 0), (1, 0)], **body
    )
    for posture in (on_segment, on_terrain):
        for starts in ((0, 0.1, 0), [(0, 0.1, 0)]):
            run = sf.simulate if isinstance(starts, tuple) else sf.simulate_many
            with pytest.raises(ValueError, match=r'model = "local" .* "full"'):
                run(posture, starts, np.zeros_like(starts), model="local")
        run = sf.simulate(posture, (0, 0.1, 0), (0, 0, 0))
        assert (run.model, run.outcome) == ("full", "rest")
        assert "straight line" in run.model_reason
        # Small motions do not reach the ends: trials have straight lines.
        assert sf.stability(posture, trials=5).trials["kicks"] == 5


def test_a_foot_leaves_the_end_of_its_ground_once_while_it_is_in_the_air():
    """It leaves again only after it has been on its ground again."""
    random = np.random.default_rng(5)
    left = 0
    for _ in range(500):
        contacts = [
            sf.Contact(
                tuple(random.uniform((-1, -0.2), (1, 0.2))),
                slope=random.uniform(-0.5, 0.5),
                friction=random.uniform(0, 1),
                segment=(-random.uniform(0.05, 1), random.uniform(0.05, 1)),
            )
            for _ in range(random.integers(1, 4))
        ]
        rho, centre = random.uniform(0.2, 1), random.uniform((-0.5, 0), (0.5, 1))
        e = random.choice([0, 0.3, 0.7])
        body = sf.Posture(1.0, rho, tuple(centre), contacts, e, 9.81)
        kick = random.uniform((-2, 0, -2), (2, 1, 2))
        run = sf.simulate(body, (0, 0, 0), kick, event_limit=2000, time_limit=5.0)
        for before, phase in itertools.pairwise(run.phases):
            if phase.cause == "left-segment":
                assert before.mode[phase.contact - 1] != "S"
                left += 1
    assert left > 100


def test_a_vertex_on_a_straight_line_changes_no_bit():
    """A vertex on a straight line has no effect, also if its coordinates are rounded: the scene is the same, and no
    foot is in the vertex or leaves a piece there."""
    random = np.random.default_rng(9)
    for case in range(300):
        slope = 0.0 if case % 3 == 0 else round(random.uniform(-0.6, 0.6), case % 3)
        turn = [0.0, 0.3, math.pi / 2][case // 3 % 3]  # on the floor, a slope or a wall
        cos, sin = math.cos(turn), math.sin(turn)

        def world(x, y, cos=cos, sin=sin):
            return (float(cos * x - sin * y), float(sin * x + cos * y))

        feet = random.uniform(-1, 1, random.integers(1, 4))
        inner = np.sort([*feet, *random.uniform(-2, 2, 3)])
        contacts = [
            sf.Contact(world(x, slope * x), friction=random.choice([0, 0.3, 0.8]))
            for x in feet
        ]
        e, gravity = random.choice([0, 0.4, 0.7]), random.choice([0, 9.81])
        kick = random.uniform(-1, 1, 3) * random.choice([0, 1])
        runs = []
        for xs in (), inner:
            terrain = [world(x, slope * x) for x in (-16, *xs, 16)]
            centre = world(0.1, 0.6 + slope * 0.1)
            body = sf.Posture(1.0, 0.4, centre, contacts, e, gravity, terrain=terrain)
            assert body.terrain == terrain
            runs.append(
                sf.simulate(body, (0, 0, 0), kick, event_limit=2000, time_limit=2.0)
            )
        one, two = runs
        assert (one.outcome, one.time) == (two.outcome, two.time)
        assert one.q.tobytes() == two.q.tobytes()
        assert mode_events(one) == mode_events(two)


def test_a_small_bend_is_no_straight_line():
    """A bump of 1e-14 m is above the rounding errors of its coordinates."""
    for height in (0.0, 1e-14):
        terrain = [(-1e9, 0.0), (0.0, height), (1.0, 0.0)]
        body = sf.Posture(
            1.0, 0.3, (0.5, 0.5), [sf.Contact((0.5, 0.5))], 0, terrain=terrain
        )
        assert (body.contacts[0].slope != 0.0) == (height > 0.0)


@pytest.mark.parametrize("far", [0.0, 1e2, 1e4, 1e5, 1e6])
def test_feet_on_a_slope_far_from_the_origin_touch_it(far):
    """Their places have rounding errors of some ε times this distance."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        slope, half = np.tan(rng.uniform(-0.5, 0.5)), rng.uniform(0.3, 1)
        feet = [sf.Contact((x, x * slope), friction=0.8) for x in (far - half, far + half)]  # fmt: skip
        ground = [(x, x * slope) for x in (far - 9, far + 9)]
        body = sf.Posture(1, 0.4, (far, far * slope + 0.5), feet, 0.2, terrain=ground)
        assert body.gaps((0, 0, 0)).tolist() == [0, 0]
        run = sf.simulate(body, (0, 0, 0), (0, 0, 0))
        assert (run.outcome, run.time, len(run.impacts)) == ("rest", 0, 0)
        assert sf.contact_modes(body)["FF"].consistent
