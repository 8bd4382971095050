"""Scenes with corners of the ground on sides of the body in which random bodies on random ground showed an error of a first version."""

import math

import depths
import numpy as np
import pytest
import standfast as sf
from scipy.integrate import solve_ivp
from scipy.optimize import linprog

#: Two pins, 1 m high, that lean outwards, with their tips at (±0.25, 0).
PINS = [(-9.0, -1.0), (-0.2, -1.0), (-0.25, 0.0), (-0.15, -1.0), (0.15, -1.0), (0.25, 0.0), (0.2, -1.0), (9.0, -1.0)]  # fmt: skip
PIN = [(-9.0, -1.0), (-0.01, -1.0), (0.0, 0.0), (0.01, -1.0), (9.0, -1.0)]
#: Of a bridge that is 1 m wide, with an opening of 0.6 m x 0.4 m: its height for a centre of mass at the height of the ceiling.
HEIGHT = 0.4 + math.sqrt(0.064)


def bridge(terrain, **keywords):
    """With the middle of its ceiling at (0, 0)."""
    feet = [(-0.5, -0.4), (-0.3, -0.4), (-0.3, 0.0), (0.3, 0.0), (0.3, -0.4), (0.5, -0.4)]  # fmt: skip
    top = [(0.5, HEIGHT - 0.4), (-0.5, HEIGHT - 0.4)]
    return sf.Posture.polygon([*feet, *top], terrain=terrain, **keywords)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("way", [1, -1])
def test_corners_of_the_ground_slide_into_the_concave_corners_of_a_body(
    restitution, way
):
    """Its ceiling slides on two pins, until one of them hits its leg in the concave corner, at the height of its centre of mass: after
    every 0.1 m it goes back with e times its speed."""
    body = bridge(PINS, restitution=restitution)
    assert body.center_of_mass == pytest.approx((0, 0), abs=1e-15)
    run = sf.simulate(
        body, (0, 0, 0), (0.5 * way, 0, 0), impact="moreau", stop="time", time_limit=3.0
    )
    assert not [warning for warning in run.warnings if "was in the body" in warning]
    times = np.linspace(0, 3.0, 61)
    place, speed, last, end = 0.0, 0.5 * way, 0.0, 0.1
    for t in times:
        while t >= end:
            place, speed, last = place + speed * (end - last), -restitution * speed, end
            end = last + 0.1 / abs(speed) if speed else math.inf
        expected = place + speed * (t - last)
        assert run.at(t)[0] == pytest.approx((expected, 0, 0), abs=1e-12)
    _, deep = depths.deepest_of_run(run)
    assert deep.max() < 1e-12


@pytest.mark.parametrize("law", ["poisson", "stronge", "moreau"])
@pytest.mark.parametrize("speed", [0.3, -0.3])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_body_hangs_on_a_pin_in_its_concave_corner(law, speed, restitution):
    """It falls on the pin, slides and turns until both sides of the corner are on it, and stays on both."""
    body = bridge(PIN, friction=0.3, restitution=restitution)
    run = sf.simulate(body, (0.05, 0.1, 0), (speed, 0, 0.5), impact=law, time_limit=5.0)
    times, deep = depths.deepest_of_run(run)
    assert deep.max() < 1e-11
    assert not [warning for warning in run.warnings if "was in the body" in warning]
    energy = run.energy(times)
    assert (energy - np.minimum.accumulate(energy)).max() < 1e-10
    assert run.outcome == "rest"
    held = [c.number for c, mode in zip(run.contacts, run.phases[-1].mode, strict=True) if mode != "S"]  # fmt: skip
    assert sum(run.contacts[k - 1].kind == "side" for k in held) == 2


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("clockwise", [False, True])
def test_a_body_swings_about_a_pin_in_its_concave_corner(friction, clockwise):
    """A pendulum, with the sum of the two forces on the corner. θ̈ (ρ² + l²) = −g l sin θ (DOP853, rtol 1e-12)."""
    shape = [(-0.5, -2.0), (0.0, 0.0), (0.5, -2.0), (0.9, -2.0), (0.0, 0.3), (-0.9, -2.0)]  # fmt: skip
    if clockwise:
        shape.reverse()
    pin = [(-9.0, -9.0), (-0.01, -9.0), (0.0, 0.0), (0.01, -9.0), (9.0, -9.0)]
    body = sf.Posture.polygon(shape, friction=friction, terrain=pin)
    length, theta, omega = -body.center_of_mass[1], 0.15, 0.4

    def place(angle, rate):
        q = length * math.sin(angle), length * (1 - math.cos(angle)), angle
        v = length * rate * math.cos(angle), length * rate * math.sin(angle), rate
        return q, v

    ratio = 9.81 * length / (body.gyration_radius**2 + length**2)
    times = np.linspace(0, 2.0, 21)
    solved = solve_ivp(
        lambda _, z: (z[1], -ratio * math.sin(z[0])),
        (0, 2.0),
        (theta, omega),
        "DOP853",
        times,
        rtol=1e-12,
        atol=1e-13,
    )
    run = sf.simulate(
        body, *place(theta, omega), impact="moreau", stop="time", time_limit=2.0
    )
    for t, z in zip(times, solved.y.T, strict=True):
        for found, expected in zip(run.at(t), place(*z), strict=True):
            assert found == pytest.approx(expected, abs=1e-9), t


def test_statics_of_a_pin_in_a_concave_corner():
    """Both sides count: the body with its centre of mass over the pin stands without friction."""
    corner = [(-0.5, -0.9), (0.0, 0.0), (0.5, -0.9), (0.5, 1.0), (-0.5, 1.0)]
    body = sf.Posture.polygon(corner, terrain=PIN)
    assert len(body.side_contacts) == 2
    run = sf.simulate(body, (0, 0, 0), (0, 0, 0))
    assert run.outcome == "rest"
    # Both normals have the angle atan 1.8 with the vertical.
    low, high = sf.static_forces(body)
    normal = 9.81 / (2 * math.cos(math.atan(1.8)))
    for forces in (low, high):
        assert forces[-2:] == pytest.approx(np.array([[0, normal]] * 2), rel=1e-12)
        assert abs(forces[:-2]).max() == 0


@pytest.mark.parametrize("friction", [0.0, 0.2])
@pytest.mark.parametrize("slit", [0.03, 0.3])
@pytest.mark.parametrize("turn", [0, 1, 2, 3])
@pytest.mark.parametrize("way", [1, -1])
def test_the_rear_corner_of_a_box_passes_a_slit(friction, slit, turn, way):
    """It comes to the far edge of the slit at the instant at which the edge leaves the side before it: the edge does not stay on the side.
    The box was turned by right angles, so that its corners have rounding errors."""
    half = (slit, 0.0), (slit, -1.0)
    terrain = [(-50, 0), (0, 0), (0, -1), half[1], half[0], (50, 0)]
    width, height = (0.7, 0.4) if turn % 2 == 0 else (0.4, 0.7)
    box = sf.Posture.box(width, height, friction=friction, terrain=[(-50, -9), (50, -9)])  # fmt: skip
    corners = [(x, y + 5.0) for x, y in box.outline]
    body = sf.Posture.polygon(corners, friction=friction, terrain=terrain)
    start = slit / 2 - way * 0.6
    center = np.array(body.center_of_mass)
    q = (start - center[0], 0.2 - center[1], turn * math.pi / 2)
    run = sf.simulate(
        body, q, (3.0 * way, 0, 0), impact="moreau", stop="time", time_limit=0.6, event_limit=2000
    )  # fmt: skip
    assert run.outcome == "time-limit"
    passed = 3.0 * 0.6 - friction * 9.81 * 0.18
    assert run.q == pytest.approx((q[0] + way * passed, q[1], q[2]), abs=1e-9)


def test_an_edge_that_leaves_a_side_as_the_corner_behind_it_lands():
    """A bridge slides over a slit in a ground that is tilted, and has roundings of its turns: an endless loop of steps of no time."""
    opening = [
        (0.0, 5.7877567725068),
        (0.0622985045000087, 5.7877567725068),
        (0.0622985045000087, 5.895816586569853),
        (0.14994472299319136, 5.895816586569853),
        (0.14994472299319136, 5.7877567725068),
        (0.21224322749320007, 5.7877567725068),
        (0.21224322749320007, 6.0),
        (0.0, 6.0),
    ]
    terrain = [
        (-200.0, 0.0),
        (0.0, 0.0),
        (0.0, -1.0),
        (0.029472870265462386, -1.0),
        (0.029472870265462386, 0.0),
        (200.0, 0.0),
    ]
    body = sf.Posture.polygon(opening, restitution=0.7300301488795152, terrain=terrain)
    body = body.replace(gyration_radius=0.09034607754651029)
    q, qdot = (
        (1.1211020287830444, -5.751965361585088, 0.4636476090008061),
        (-0.6414588034600334, 1.2343782823636502, -4.753171598370052),
    )
    tilt = sf.GroundMotion(
        [0.0, 1.0, 2.0, 3.0], tilt=[0.0, -0.02339631024110922, 0.6147308876148692, 0.0]
    )
    run = sf.simulate(
        body,
        q,
        qdot,
        impact="poisson",
        ground_motion=tilt,
        time_limit=2.2,
        event_limit=20_000,
    )
    assert run.outcome == "time-limit"
    assert run.q[2] == pytest.approx(-math.pi / 2, abs=1e-12)


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.3])
def test_a_corner_of_a_flush_board_passes_over_an_edge_at_no_height(friction):
    """The walls of these stairs are vertical but for rounding errors. The front corner of the board comes to an edge within its rounding
    error, passes the wall at once, and must not hit the tread that it has left."""
    stairs = [(-9.0, 0.0), (0.0, 0.0)]
    for k in range(10):
        low = -0.2 * k - 0.2
        stairs += [(0.3 * k, low), (0.3 * k + 0.3, low)]
    board = sf.Posture.box(1.0, 0.2, friction=friction, terrain=stairs)
    theta = -math.atan2(0.2, 0.3)
    down = np.array([math.cos(theta), math.sin(theta)])
    center = 0.55 * down + 0.1 * np.array([-down[1], down[0]])
    q = (*(center - board.center_of_mass), theta)
    run = sf.simulate(
        board,
        q,
        (0, 0, 0),
        impact="moreau",
        stop="time",
        time_limit=0.9,
        event_limit=2000,
    )
    assert run.outcome == "time-limit"
    pull = 9.81 * (-down[1] - friction * down[0])
    way = pull * 0.9**2 / 2
    assert run.q == pytest.approx((*(np.array(q[:2]) + way * down), theta), abs=1e-9)


def test_statics_and_verdicts_are_those_of_contacts_at_the_corners():
    """Boxes over the edge of a table, beside the same bodies on contacts at the corner of the box and at the edge. The certificates hold."""
    rng = np.random.default_rng(48)
    stable = 0
    for _ in range(40):
        edge, friction = rng.uniform(-0.3, 0.45), rng.uniform(0.05, 1.0)
        table = [(-9, 0), (edge, 0), (edge, -9), (9, -9)]
        box = sf.Posture.box(
            1.0,
            rng.uniform(0.2, 2.0),
            friction=friction,
            restitution=0.2,
            terrain=table,
        )
        feet = [sf.Contact((x, 0), friction=friction) for x in (-0.5, edge)]
        plain = sf.Posture(1.0, box.gyration_radius, box.center_of_mass, feet, 0.2)
        assert box.side_contacts[0].point == feet[1].point
        assert sf.equilibrium_region(box) == pytest.approx(
            sf.equilibrium_region(plain), abs=1e-12
        )
        assert sf.friction_margin(box) == pytest.approx(
            sf.friction_margin(plain), abs=1e-12
        )
        one, other = sf.static_forces(box), sf.static_forces(plain)
        assert (one is None) == (other is None)
        if one is not None:
            for with_side, bare in zip(one, other, strict=True):
                assert with_side[[0, 4]] == pytest.approx(bare, abs=1e-11)
        verdict, known = sf.stability(box), sf.stability(plain)
        assert verdict.contacts == [1, 5]
        assert (verdict.frictional_stability, verdict.by) == (
            known.frictional_stability,
            known.by,
        )
        if verdict.frictional_stability != "undecided":
            sf.certificate.check(verdict.certificate())
        stable += verdict.frictional_stability == "stable"
    assert 10 < stable < 40


@pytest.mark.parametrize("x", [0.0, 1e4])
def test_a_side_has_the_coefficients_of_the_contacts_at_its_ends(x):
    """Wherever the body stands: the smaller ones of its two ends, not those of the other contacts."""
    corners = [(x, 0.0), (x + 0.1, 0.0), (x + 0.1, 0.3), (x, 0.3)]
    contacts = [
        sf.Contact(corner, friction=mu, restitution=e)
        for corner, mu, e in zip(
            corners, (0.5, 0.6, 0.1, 0.2), (0.3, 0.2, 0.0, 0.1), strict=True
        )
    ]
    edge = x + 0.07
    table = [(x - 9, 0), (edge, 0), (edge, -9), (x + 9, -9)]
    box = sf.Posture(
        1, 0.1, (x + 0.05, 0.15), contacts, 0.5, terrain=table, outline=corners
    )
    [side] = box.side_contacts
    assert (side.friction, side.restitution) == (0.5, 0.2)


def decelerations(posture, run, t):
    """Smallest and largest deceleration that the forces on the feet that slide on level ground may cause; m/s²."""
    mode = next(p.mode for p in run.phases if p.start <= t <= p.end)
    feet = [i for i, letter in enumerate(mode) if letter in "RL"]
    q, _ = run.at(t)
    x, y = (run.points_at(t)[feet] - np.array(posture.center_of_mass) - q[:2]).T
    mu = np.array([run.contacts[i].friction for i in feet])
    way = np.array([1 if mode[i] == "R" else -1 for i in feet])
    moments = [np.ones(len(feet)), x + y * mu * way]
    found = [
        linprog(sign * mu, A_eq=moments, b_eq=[posture.gravity, 0]) for sign in (1, -1)
    ]
    return [abs(one.fun) for one in found if one.success]


def test_the_share_of_feet_that_slide_with_unequal_friction_is_ambiguous():
    """A U on a table edge: with three feet on the table the load of each, and with it the deceleration, is not determined."""
    corners = [(0.05, 0.38), (-0.39, 0.38), (-0.39, 0.01), (-0.3, 0.01), (-0.05, 0.01), (0.05, 0.01)]  # fmt: skip
    outline = [*corners[:4], (-0.3, 0.29), (-0.05, 0.29), *corners[4:]]
    edge = [(-40, 0), (0, 0), (-0.28, -2), (40, -2)]
    rng, ambiguous = np.random.default_rng(17), 0
    for _ in range(40):
        friction = rng.uniform(0.15, 0.45, 6)
        feet = [sf.Contact(p, friction=f) for p, f in zip(corners, friction, strict=True)]  # fmt: skip
        body = sf.Posture(0.38, 0.19, (-0.17, 0.23), feet, 0.0, terrain=edge, outline=outline)  # fmt: skip
        law = str(rng.choice(["poisson", "moreau"]))
        run = sf.simulate(body, (0, 0, 0), (rng.uniform(0.2, 1), -0.04, rng.uniform(-1, 1)), model="full", impact=law, time_limit=0.3)  # fmt: skip
        for phase in run.phases:
            if sum(letter in "RL" for letter in phase.mode) < 3 or phase.end == phase.start:  # fmt: skip
                continue
            t = (phase.start + min(phase.end, run.time)) / 2
            least, most = decelerations(body, run, t)
            assert most - least < 1e-6, (phase, run)
        if run.outcome == "ambiguous":
            assert any("several contact modes" in text for text in run.warnings)
            ambiguous += 1
    assert ambiguous > 10
