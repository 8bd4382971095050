"""Walls, overhangs and ceilings: closed forms, a linear programme, and a falling ladder integrated to 15 digits by other means."""

import math
import os

import numpy as np
import pytest
import standfast as sf
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

G = 9.81
WALL, CEILING = math.pi / 2, math.pi
#: Number of random stances; `make long` has more.
STANCES = int(os.environ.get("STANDFAST_WALL_STANCES", "600"))
#: Number of random postures whose verdict is compared with kicks.
KICKED = int(os.environ.get("STANDFAST_WALL_KICKED", "12"))


def stance(center, *contacts, rho=0.5):
    return sf.Posture(
        mass=1,
        gyration_radius=rho,
        center_of_mass=center,
        contacts=contacts,
        restitution=0,
        gravity=G,
    )


def ladder(floor, wall, center=None):
    """4 m long, at 65 degrees to the floor, its top at a wall on the right."""
    top = (4 * math.cos(math.radians(65)), 4 * math.sin(math.radians(65)))
    return stance(
        center or (top[0] / 2, top[1] / 2),
        sf.Contact((0, 0), friction=floor),
        sf.Contact(top, slope=WALL, friction=wall),
        rho=math.sqrt(4 / 3),
    )


@pytest.mark.parametrize(
    ("floor", "wall", "end"),
    [
        (0.5, 0.3, 1.83417013768),
        (0.4, 0.2, 1.46789842872),
        (0.1, 0.1, 0.375671133945),
        (0.3, 0.0, 1.08756934444),
    ],
)
def test_region_of_a_ladder(floor, wall, end):
    """Moments about the foot at the end, where the foot is about to slide away, N_w = μ_f N_f. The wall pushes up or down by μ_w N_w."""
    low, high = sf.equilibrium_region(ladder(floor, wall))
    assert low == pytest.approx(0, abs=1e-15)
    assert high == pytest.approx(end, abs=1e-10)
    top_x, top_y = ladder(floor, wall).contacts[1].point
    closed = max(floor * (top_y + w * top_x) / (1 + floor * w) for w in (wall, -wall))
    assert high == pytest.approx(closed, rel=1e-14)


def test_friction_that_a_ladder_needs():
    posture = ladder(0.4, 0.2)
    assert sf.friction_margin(posture) == pytest.approx(1 - 0.567848398167, abs=1e-11)
    assert sf.contact_modes(posture).consistent == ["FF"]


FALLS = [
    # μ, forces (floor, wall), q̈, (angle, ω) at 0.25 s and 0.5 s, (time, angle, ω) at which the wall is lost
    (
        0.1,
        (8.82182263180578, 2.47135226453317),
        (-1.58917000135259, -0.741042141740903, -0.876727544485022),
        [
            (1.10650584111750, -0.228186985830061),
            (1.01567609029376, -0.513172111921251),
        ],
        (0.965257320837192, 0.586682856007756, -1.45562810615946),
    ),
    (
        0.0,
        (8.49590491913436, 2.81808599512394),
        (-2.81808599512394, -1.31409508086564, -1.55470693037860),
        [
            (1.08503385098227, -0.402219947921309),
            (0.926533970321500, -0.886296663732895),
        ],
        (0.736542548258553, 0.648768024969730, -1.49087888431870),
    ),
]


@pytest.mark.parametrize(
    ("friction", "forces", "acceleration", "states", "lost"), FALLS
)
def test_a_falling_ladder(friction, forces, acceleration, states, lost):
    """The foot slides away from the wall and the top slides down, until the top leaves the wall."""
    posture = ladder(friction, friction)
    modes = sf.contact_modes(posture)
    assert modes.consistent == ["LL"]
    np.testing.assert_allclose(modes["LL"].acceleration, acceleration, atol=1e-10)
    np.testing.assert_allclose(modes["LL"].forces[:, 1], forces, atol=1e-10)
    rest = (0, 0, 0)
    run = sf.simulate(posture, rest, rest, model="full", stop="time", time_limit=1.2)
    for t, (angle, omega) in zip((0.25, 0.5), states, strict=True):
        q, qdot = run.at(t)
        assert math.radians(65) + q[2] == pytest.approx(angle, abs=1e-12)
        assert qdot[2] == pytest.approx(omega, abs=1e-12)
    time, angle, omega = lost
    first, second = run.phases[:2]
    assert (first.mode, second.mode, second.cause) == ("LL", "LS", "lift-off")
    assert second.start == pytest.approx(time, abs=1e-12)
    q, qdot = run.at(second.start)
    assert (math.radians(65) + q[2], qdot[2]) == pytest.approx(
        (angle, omega), abs=1e-12
    )


@pytest.mark.parametrize(
    ("height", "friction", "region"),
    [
        (1.5, 0.8, (-math.inf, math.inf)),
        (1.6, 0.8, (1.0, math.inf)),
        (2.0, 0.8, (1.25, math.inf)),
        (0.0, 0.0, None),
    ],
)
def test_a_chimney(height, friction, region):
    """Two facing walls hold any body whose contacts lie in each other's friction cones. At rest it is ambiguous: a rigid model knows no
    preload. Without friction, nothing holds it."""
    posture = stance(
        (0, 0),
        sf.Contact((-1, 0), slope=-WALL, friction=friction),
        sf.Contact((1, height), slope=WALL, friction=friction),
    )
    assert sf.equilibrium_region(posture) == (region and pytest.approx(region))
    if height == 0.0:
        assert sf.contact_modes(posture).consistent == ["RL"]
    if height == 1.5:
        assert set(sf.contact_modes(posture).consistent) == {"FF", "RL"}
        assert sf.stability(posture).frictional_stability != "stable"


@pytest.mark.parametrize(
    ("other", "friction", "region"),
    [
        (((0.3, 2), CEILING, 0.5), 0.5, (-math.inf, math.inf)),
        (((1.5, 2), CEILING, 0.5), 0.5, (-math.inf, 0.0)),
        (((1, 1), 2.4, 0.6), 0.4, (-math.inf, 0.319082743069)),
        (((1, 2), 1.7, 0.3), 0.3, (0.0, 0.618723581908)),
    ],
)
def test_a_floor_and_another_side(other, friction, region):
    point, slope, rough = other
    posture = stance(
        (0.5, 0.5),
        sf.Contact((0, 0), friction=friction),
        sf.Contact(point, slope=slope, friction=rough),
    )
    assert sf.equilibrium_region(posture) == pytest.approx(region, abs=1e-11)


def test_ceilings_do_not_hold():
    posture = stance(
        (0, 0), *(sf.Contact((x, 2), slope=CEILING, friction=0.3) for x in (-1, 1))
    )
    assert sf.equilibrium_region(posture) is None
    assert sf.contact_modes(posture).consistent == ["SS"]
    run = sf.simulate(posture, (0, 0, 0), (0, 0, 0), stop="time", time_limit=1.0)
    assert run.phases[0].mode == "SS"
    assert run.q == pytest.approx((0, -G / 2, 0))


@pytest.mark.parametrize(
    ("center", "expected"), [((0, 1), {"FF"}), ((0.5, 1), {"FF", "FS"})]
)
def test_between_floor_and_ceiling(center, expected):
    posture = stance(
        center,
        sf.Contact((0, 0), friction=0.5),
        sf.Contact((0.3, 2), slope=CEILING, friction=0.5),
    )
    assert set(sf.contact_modes(posture).consistent) == expected


def test_an_overhang_does_not_hold():
    """The foot slides away from under the overhang."""
    posture = stance(
        (0.5, 0.5),
        sf.Contact((0, 0), friction=0.4),
        sf.Contact((1, 1), slope=2.4, friction=0.6),
    )
    assert sf.contact_modes(posture).consistent == ["LS"]


def random_contacts(rng, count):
    """Half of the slopes are exact floors, walls and ceilings."""
    exact = (0.0, WALL, -WALL, CEILING)
    return [
        sf.Contact(
            rng.uniform(-2, 2, 2),
            slope=rng.choice([rng.choice(exact), rng.uniform(-3.14, 3.14)]),
            friction=rng.choice([0.0, rng.uniform(0, 1.5)]),
        )
        for _ in range(count)
    ]


def ends_of_programme(posture):
    """Least and largest abscissa of the weight over all forces in the cones: a linear programme."""
    edges, moments = [], []
    for contact in posture.contacts:
        cos, sin = math.cos(contact.slope), math.sin(contact.slope)
        if abs(cos) < 1e-15 or abs(sin) < 1e-15:
            cos, sin = round(cos), round(sin)
        for side in (1, -1):
            edge = np.array([-sin, cos]) + side * contact.friction * np.array(
                [cos, sin]
            )
            edges.append(edge)
            moments.append(contact.point[0] * edge[1] - contact.point[1] * edge[0])
    found = []
    for sign in (1, -1):
        answer = linprog(
            sign * np.array(moments),
            A_eq=np.array(edges).T,
            b_eq=[0.0, 1.0],
            bounds=(0, None),
            method="highs",
        )
        if answer.status == 3 or answer.status == 4:
            found.append(-sign * math.inf)
        elif answer.status == 2:
            return None
        else:
            found.append(sign * answer.fun)
    return tuple(found)


def test_region_agrees_with_a_linear_programme():
    rng = np.random.default_rng(11)
    count = {}
    for _ in range(STANCES):
        posture = stance((0, 0), *random_contacts(rng, rng.choice([1, 2, 2, 2, 3, 4])))
        region, expected = sf.equilibrium_region(posture), ends_of_programme(posture)
        kind = region and tuple(map(math.isfinite, region))
        count[kind] = count.get(kind, 0) + 1
        case = f"{posture!r}: {region}, {expected}"
        assert (region is None) == (expected is None), case
        if region is not None:
            assert region == pytest.approx(expected, rel=1e-7, abs=1e-7), case
    print(count)
    assert len(count) == 5


def test_stable_verdicts_between_walls_withstand_kicks():
    """Postures on a floor and at any other side. After small kicks, those with the verdict "stable" come to rest near their place; the
    farthest of them moves ever less as the kicks get smaller."""
    rng = np.random.default_rng(12)
    held = 0
    for _ in range(100 * KICKED):
        slope = rng.choice([WALL, -WALL, CEILING, rng.uniform(1.2, 3.1), -1.4])
        side = 1 if slope > 0 else -1
        posture = stance(
            (side * rng.uniform(-0.2, 1), rng.uniform(0, 1.5)),
            sf.Contact(
                (0, 0), slope=rng.uniform(-0.3, 0.3), friction=rng.uniform(0, 1)
            ),
            sf.Contact(
                (side * rng.uniform(0.2, 1), rng.uniform(0.5, 2)),
                slope=slope,
                friction=rng.uniform(0, 1),
            ),
            rho=rng.uniform(0.3, 0.8),
        )
        if sf.stability(posture).frictional_stability != "stable":
            continue
        held += 1
        moved = []
        for size in (1e-3, 1e-5):
            far = 0.0
            for _ in range(8):
                qdot = size * rng.normal(size=3)
                run = sf.simulate(
                    posture, (0, 0, 0), qdot, model="local", time_limit=100.0
                )
                assert run.outcome == "rest", f"{posture!r}, {qdot}: {run}"
                far = max(far, np.abs(run.q).max())
            moved.append(far)
        assert moved[1] < 0.1 * moved[0], f"{posture!r}: {moved}"
        if held == KICKED:
            break
    assert held == KICKED


def falls_without_the_wall(friction, time, angle, omega):
    """Time at which the top of the ladder is on the floor, ω and the speed of the centre along the floor then. The foot slides away
    from the wall: ÿ = 2 cos θ θ̈ − 2 sin θ ω² = N − g, (4/3) θ̈ = 2 N (μ sin θ − cos θ), ẍ = μ N."""

    def motion(_, state):
        angle, omega, _ = state
        lever = 1.5 * (friction * math.sin(angle) - math.cos(angle))
        normal = (G - 2 * math.sin(angle) * omega**2) / (
            1 - 2 * math.cos(angle) * lever
        )
        return omega, lever * normal, friction * normal

    def lands(_, state):
        return state[0]

    lands.terminal = True
    start = (angle, omega, 2 * math.sin(angle) * omega)
    fall = solve_ivp(
        motion, (time, time + 5), start, rtol=1e-12, atol=1e-13, events=lands
    )
    return fall.t[-1], fall.y[1, -1], fall.y[2, -1]


@pytest.mark.parametrize(("friction", "lost"), [(f[0], f[-1]) for f in FALLS])
def test_the_top_of_a_falling_ladder_lands_on_the_floor(friction, lost):
    """Floor and wall are one terrain. Without friction the momentum of the ladder along the floor is conserved after
    the ladder has left the wall."""
    posture = ladder(friction, friction)
    wall = posture.contacts[1].point[0]
    posture = sf.Posture(
        mass=1,
        gyration_radius=posture.gyration_radius,
        center_of_mass=posture.center_of_mass,
        contacts=[sf.Contact(k.point, friction=friction) for k in posture.contacts],
        restitution=0,
        gravity=G,
        terrain=[(-20, 0), (wall, 0), (wall, 20)],
    )
    rest = (0, 0, 0)
    run = sf.simulate(posture, rest, rest, model="full", impact="moreau")
    hit = run.impacts[0]
    assert hit["contact"] == 2
    _, (speed, _, omega) = run.at(np.nextafter(hit["time"], 0))
    expected = falls_without_the_wall(friction, *lost)
    assert (hit["time"], omega, speed) == pytest.approx(expected, abs=1e-9)
    if friction == 0:
        _, angle, turning = lost
        assert speed == pytest.approx(2 * math.sin(angle) * turning, abs=1e-12)
        energy = 2 * G * math.sin(math.radians(65)) - speed**2 / 2
        assert omega == pytest.approx(-math.sqrt(energy * 3 / 8), abs=1e-12)
