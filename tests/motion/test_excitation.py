"""Kicks, and ground that moves: closed forms, the run without them, and worlds turned as a whole."""

import math
import os
import pickle

import numpy as np
import pytest
import standfast as sf
from bits import GROUNDS, LAWS, Draw, posture, state
from mpmath import mp, mpf

G = 9.81
#: Number of random scenes with a kick; `make long` has more.
KICKED = int(os.environ.get("STANDFAST_KICKED_RUNS", "100"))
ROD = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
DROP = (0, 0.011, 0.002)
REST = (0, 0, 0)


def block(friction=1.0, gravity=10.0):
    """Half-width 1 m, centre of mass 2 m high."""
    feet = [sf.Contact(point=(x, 0), friction=friction) for x in (-1, 1)]
    return sf.Posture(
        mass=1,
        gyration_radius=math.sqrt(5 / 3),
        center_of_mass=(0, 2),
        contacts=feet,
        restitution=0,
        gravity=gravity,
    )


@pytest.mark.parametrize("before", [0.02, 1e-6, 1e-9, 1e-13])
def test_a_kick_in_a_zeno_tail_leaves_the_run_before_it(before):
    """Before the kick the run has the same bits as a run without it, in which the tail is summed. At the kick the
    velocity jumps by M⁻¹(J, a × J)."""
    whole = sf.simulate(ROD, DROP, REST, model="full")
    time = whole.zeno_points[0].time - before
    impulse, arm = np.array([0.1, 0.5]), 0.3
    kick = sf.Kick(time, impulse, point=(arm, 0))
    run = sf.simulate(ROD, DROP, REST, model="full", kicks=[kick])
    cut = sf.simulate(ROD, DROP, REST, model="full", stop="time", time_limit=time)
    for t in np.linspace(0, time, 60)[:-1]:
        for other in (whole, cut):
            np.testing.assert_array_equal(run.at(t), other.at(t))
    (_, _, theta), was = cut.q, cut.qdot
    turned = arm * np.array([math.cos(theta), math.sin(theta)])
    jump = [*impulse, (turned[0] * impulse[1] - turned[1] * impulse[0]) / 0.2**2]
    np.testing.assert_allclose(run.at(time)[1] - was, jump, atol=1e-14)
    assert run.outcome == "sliding"  # without friction, and kicked to the side
    assert pickle.loads(pickle.dumps(run)).time == run.time


def test_a_kick_lifts_a_body_at_rest():
    """Kicked upwards at the centre of mass, a rod flies and bounces: 2v/(g(1 − e))."""
    run = sf.simulate(ROD, REST, REST, kicks=[sf.Kick(2.0, (0, 1.5))])
    assert run.outcome == "rest"
    assert run.time - 2 == pytest.approx(2 * 1.5 / (G * 0.9), rel=1e-12)


def test_a_kick_into_the_ground_is_an_impact():
    """Both feet are hit at once. The rod rebounds with e times the speed of the kick."""
    run = sf.simulate(ROD, REST, REST, kicks=[sf.Kick(1.0, (0, -1))])
    assert run.at(1.0 + 1e-9)[1][1] == pytest.approx(0.1, abs=1e-7)
    assert {int(i["contact"]) for i in run.impacts[:2]} == {1, 2}


def test_a_kick_along_the_ground_slides():
    """The block slides until v²/(2 μ g)."""
    body = sf.Posture.box(2, 1, friction=0.5, gravity=10)
    run = sf.simulate(body, REST, REST, kicks=[sf.Kick(0.5, (2, 0))])
    assert run.outcome == "rest"
    assert run.time == pytest.approx(0.5 + 2 / 5)
    assert run.q[0] == pytest.approx(4 / (2 * 5))


def test_kicks_of_one_time_add_up():
    two = [sf.Kick(0.01, (0.1, 0.2)), sf.Kick(0.01, (0.2, 0.1))]
    runs = [
        sf.simulate(ROD, DROP, REST, kicks=kicks, time_limit=0.011)
        for kicks in (two, [sf.Kick(0.01, (0.3, 0.3))])
    ]
    np.testing.assert_allclose(runs[0].qdot, runs[1].qdot, rtol=1e-15)


@pytest.mark.parametrize(
    ("acceleration", "rocks"),
    [(4.999999999, False), (5.0, False), (5.000000001, True)],
)
def test_a_block_begins_to_rock_at_g_b_over_h(acceleration, rocks):
    """g b/h = 5 m/s², exactly."""
    shake = sf.GroundMotion([0.0, 0.2], [(acceleration, 0), (0, 0)])
    run = sf.simulate(block(), REST, REST, ground_motion=shake)
    assert (run.phases[0].mode != "FF") == rocks
    assert run.phases[0].cause == "ground-motion"


def test_ground_that_accelerates_upwards():
    """Gravity is g + A: a ball falls accordingly; with A = −2 g it flies away."""
    ball = sf.Posture(
        mass=1,
        gyration_radius=1,
        center_of_mass=(0, 0),
        contacts=[sf.Contact((0, 0))],
        restitution=0.5,
        gravity=10,
    )
    up = sf.GroundMotion([0], [(0, 10)])
    assert sf.simulate(ball, (0, 10, 0), REST, ground_motion=up).time == pytest.approx(
        3
    )
    away = sf.GroundMotion([0, 1], [(0, 0), (0, -20)])
    run = sf.simulate(ball, REST, REST, ground_motion=away, time_limit=3.0)
    assert run.q[1] == pytest.approx(10 * 2**2 / 2)
    assert [phase.mode for phase in run.phases] == ["F", "S"]


def overturns(pulse, steps, duration, height=2.0, width=1.0):
    """Whether a half-sine pulse, approximated by steps, overturns the block. Computed with mpmath: the block rocks
    about one foot during the pulse; afterwards its energy decides."""
    with mp.workdps(20):
        rho2, g = mpf(5) / 3, mpf(10)
        inertia = rho2 + height**2 + width**2
        theta, omega = mpf(0), mpf(0)
        dt = mpf(duration) / steps
        small = 12
        started = False
        for k in range(steps):
            a = mpf(pulse) * mp.sin(mp.pi * (k + mpf(1) / 2) / steps)
            if not started and a <= g * width / height:
                continue
            started = True

            # In the frame of the ground: moment about the left foot of (−a, −g) at the centre of mass (width, height) turned by θ.
            def acceleration(angle, a=a):
                x = width * mp.cos(angle) - height * mp.sin(angle)
                y = width * mp.sin(angle) + height * mp.cos(angle)
                return (a * y - g * x) / inertia

            h = dt / small
            for _ in range(small):
                k1, l1 = omega, acceleration(theta)
                k2, l2 = omega + h / 2 * l1, acceleration(theta + h / 2 * k1)
                k3, l3 = omega + h / 2 * l2, acceleration(theta + h / 2 * k2)
                k4, l4 = omega + h * l3, acceleration(theta + h * k3)
                theta += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
                omega += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
            if theta < 0:
                return (
                    None  # it has fallen back on both feet: not a case of this oracle
                )
        y = width * mp.sin(theta) + height * mp.cos(theta)
        top = mp.sqrt(width**2 + height**2)
        upright = math.atan2(width, height)
        rises = inertia * omega**2 / 2 > g * (top - y)
        return bool(theta > upright or (omega > 0 and rises))


@pytest.mark.parametrize("duration", [0.5, 0.7, 1.0, 1.4, 2.0])
def test_overturning_by_a_half_sine_pulse(duration):
    """The least pulse that overturns the block in its first swing: 1e-6 above it overturns, 1e-6 below it does not."""
    steps = 20
    low, high = 5.0, 60.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (
            (low, middle) if overturns(middle, steps, duration) else (middle, high)
        )
    # The ground moves to the right, the block tilts to the left about its left foot.
    tall = sf.Posture(
        mass=1,
        gyration_radius=math.sqrt(5 / 3),
        center_of_mass=(0, 2),
        contacts=[sf.Contact(point=(x, 0), friction=20) for x in (-1, 1)],
        restitution=0,
        gravity=10,
    )
    upright = math.atan2(1, 2)
    for factor, expected in ((1 + 1e-6, True), (1 - 1e-6, False)):
        times = [duration * k / steps for k in range(steps + 1)]
        pulse = [
            (high * factor * math.sin(math.pi * (k + 0.5) / steps), 0)
            for k in range(steps)
        ]
        shake = sf.GroundMotion(times, [*pulse, (0, 0)])
        run = sf.simulate(
            tall, REST, REST, ground_motion=shake, stop="time", time_limit=duration + 12
        )
        turned = max(run.at(t)[0][2] for t in np.linspace(0, run.time, 400))
        assert (turned > upright + 0.1) == expected, (duration, factor, turned)


def turned_world(posture, angle):
    cos, sin = math.cos(angle), math.sin(angle)

    def point(p):
        return (cos * p[0] - sin * p[1], sin * p[0] + cos * p[1])

    return sf.Posture(
        mass=posture.mass,
        gyration_radius=posture.gyration_radius,
        center_of_mass=point(posture.center_of_mass),
        contacts=[
            sf.Contact(
                point(k.point),
                slope=k.slope + angle,
                friction=k.friction,
                restitution=k.restitution,
            )
            for k in posture.contacts
        ],
        restitution=posture.restitution,
        gravity=posture.gravity,
    )


def test_a_tilted_ground_is_a_turned_world():
    """A ground tilted by τ moves a body as the world turned by τ does, whose slopes are τ larger."""
    rng = np.random.default_rng(3)
    compared = 0
    for _ in range(150):
        posture = sf.Posture(
            mass=1,
            gyration_radius=rng.uniform(0.2, 0.6),
            center_of_mass=(rng.uniform(-0.2, 0.2), rng.uniform(0.1, 0.6)),
            contacts=[
                sf.Contact(
                    (x, 0), slope=rng.uniform(-0.4, 0.4), friction=rng.uniform(0, 1)
                )
                for x in (-0.5, 0.5)
            ],
            restitution=rng.choice([0.0, rng.uniform(0, 0.8)]),
            gravity=G,
        )
        tilt = rng.uniform(-1.6, 1.6)
        cos, sin = math.cos(tilt), math.sin(tilt)
        turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        q, qdot = np.array([0, 0.1, 0]), rng.normal(size=3)
        if (posture.gaps(q) < 0).any():
            continue
        options = {
            "impact": str(rng.choice(["newton", "poisson", "stronge"])),
            "model": "full",
            "stop": "time",
            "time_limit": 0.6,
        }
        tilted = sf.simulate(
            posture, q, qdot, ground_motion=sf.GroundMotion([0], tilt=[tilt]), **options
        )
        turned = sf.simulate(
            turned_world(posture, tilt), turn @ q, turn @ qdot, **options
        )
        if len(tilted.impacts) > 12:
            continue  # rounding errors grow from impact to impact
        compared += 1
        assert tilted.outcome == turned.outcome
        np.testing.assert_allclose(turn @ tilted.q, turned.q, atol=1e-9)
        np.testing.assert_allclose(turn @ tilted.qdot, turned.qdot, atol=1e-8)
    assert compared > 50


def test_files_have_kicks_and_the_motion_of_the_ground(tmp_path):
    kicks = [sf.Kick(0.01, (0.1, 0.2)), sf.Kick(0.02, (0, 1), point=(0.1, 0.0))]
    shake = sf.GroundMotion([0.0, 0.005], [(1, 0), (0, 0)])
    scene = sf.Scene(ROD, DROP, REST, kicks=kicks, ground_motion=shake)
    for name in ("scene.toml", "scene.json"):
        scene.save(tmp_path / name)
        again = sf.load(tmp_path / name)
        assert again == scene
        assert again.kicks == kicks
        assert again.ground_motion == shake
        assert again.simulate().time == scene.simulate().time
    direct = sf.simulate(ROD, DROP, REST, kicks=kicks, ground_motion=shake)
    assert scene.simulate().time == direct.time


def test_a_run_ends_before_a_kick_at_its_time_limit():
    runs = [
        sf.simulate(ROD, DROP, REST, time_limit=0.02, kicks=kicks, model="full")
        for kicks in ([], [sf.Kick(0.02, (0, 5))])
    ]
    np.testing.assert_array_equal(runs[0].qdot, runs[1].qdot)


def test_a_body_thrown_up_against_turned_gravity_comes_back():
    """Under a floor that is tilted by half a turn, a ball falls up to a ceiling, from far below it."""
    ball = sf.Posture(
        mass=1,
        gyration_radius=0.1,
        center_of_mass=(0, 1),
        contacts=[sf.Contact((0, 1))],
        restitution=0,
        gravity=G,
        terrain=[(3, 5), (-3, 5)],
    )
    half = sf.GroundMotion([0], tilt=[math.pi])
    run = sf.simulate(ball, (0, -50, 0), (0, -1, 0), ground_motion=half)
    assert run.outcome == "rest"
    way = 54.0
    assert run.impacts[0]["time"] == pytest.approx(
        (1 + math.sqrt(1 + 2 * G * way)) / G, rel=1e-12
    )
    beside = sf.simulate(ball, (0, -50, 0), (5, -1, 0), ground_motion=half)
    assert beside.outcome == "escape"
    assert not len(beside.impacts)


def test_a_body_below_all_of_its_terrain_has_no_ground():
    """The body has fallen past the end of an overhang, and swings across the line of the overhang."""
    rod = sf.Posture(
        mass=1,
        gyration_radius=0.5,
        center_of_mass=(4, 0.5),
        contacts=[sf.Contact((4.5, 0.5)), sf.Contact((3.5, 0.5))],
        restitution=0,
        gravity=G,
        terrain=[(-4, 0), (0, 0), (0, -1), (-1, -1.2)],
    )
    run = sf.simulate(rod, (0, 0, 0), (-3, 0, 9), time_limit=4)
    assert run.outcome in ("escape", "time-limit")
    assert not len(run.impacts)
    low = run.gaps_at(np.linspace(1.5, run.time, 50))
    assert (low > 0).all()


#: Two feet that are hit in turn at the first instant, infinitely often: points, slopes, coefficients of friction and of restitution,
#: the centre of mass, the radius of gyration, the velocity, and the outcome.
HIT_IN_TURN = {
    "between two ceilings": (
        [(-0.9386, 0.0601), (0.947, -0.0957)],
        [-1.783, 1.797],
        [0.571, 0.819],
        [0.42, 0.461],
        (0.287, 0.363),
        0.607,
        (0.807, 0.809, 1.163),
        "ambiguous",
    ),
    "between two slopes": (
        [(-0.942, -0.0846), (0.866, 0.0782)],
        [-0.564, 0.913],
        [0.918, 1.124],
        [0.111, 0.111],
        (0.27, 0.198),
        0.2037,
        (0.382, -0.316, -0.172),
        "rest",
    ),
}


@pytest.mark.parametrize("feet", HIT_IN_TURN)
@pytest.mark.parametrize("model", ["local", "full"])
def test_impacts_at_the_start_are_summed_on_ground_that_moves_from_then_on(feet, model):
    """The ground moves from the start on. The impacts at the start are summed as on ground at rest: the speeds of
    the sum are compared with the largest speed so far, which is that of the start."""
    points, slopes, friction, e, center, gyration, speed, outcome = HIT_IN_TURN[feet]
    rows = zip(points, slopes, friction, e, strict=True)
    posture = sf.Posture(
        mass=1,
        gyration_radius=gyration,
        center_of_mass=center,
        contacts=[
            sf.Contact(at, slope=slope, friction=mu, restitution=e)
            for at, slope, mu, e in rows
        ],
        restitution=0,
        gravity=G,
    )
    still, level = (
        sf.simulate(
            posture,
            (0, 0, 0),
            speed,
            model=model,
            impact="poisson",
            ground_motion=ground,
        )
        for ground in (None, sf.GroundMotion([0], tilt=[0.0]))
    )
    assert still.outcome == level.outcome == outcome
    assert level.elapsed == still.elapsed == 0
    np.testing.assert_array_equal(level.impacts, still.impacts)


def test_the_run_before_a_kick_has_the_same_bits():
    """At any time before the kick, on ground of every kind: events, motion, gaps and forces. Exception: a kick
    within the sum of the bounces of a contact makes the run simulate them one by one, with other rounding errors."""
    compared = 0
    for k in range(KICKED):
        draw = Draw(5, k)
        law, count, ground = LAWS[k % 5], 1 + k // 5 % 4, GROUNDS[k // 20 % 4]
        body = posture(draw, count, ground)
        q, qdot = state(draw, body)
        options = {
            "model": draw.of(["full", "local"]),
            "impact": law,
            "event_limit": 3000,
            "stop": draw.of(["rest", "time"]),
            "time": draw.of([0.0, 0.0, 1.25]),
            "time_limit": 4.0,
        }
        try:
            plain = sf.simulate(body, q, qdot, **options)
        except ValueError:
            continue  # out of the range of the laws of this number of contacts
        kicks = [sf.Kick(options["time"] + draw.number(0.01, 4), (0.25, 1.0))]
        kicked = sf.simulate(body, q, qdot, kicks=kicks, **options)
        start, end = options["time"], min(kicks[0].time, plain.time, kicked.time)
        times = [*np.linspace(start, end, 20), *plain.impacts["time"]]
        times = np.array([t for t in times if t < end])
        impacts = plain.impacts["time"]
        for zeno in plain.zeno_points:
            if zeno.method == "bounce" and zeno.time > kicks[0].time:
                before = impacts[impacts < zeno.time]
                summed = times >= max(before, default=start)
                for one, other in zip(
                    plain.at(times[summed]), kicked.at(times[summed]), strict=True
                ):
                    np.testing.assert_allclose(one, other, atol=1e-13, rtol=1e-12)
                times = times[~summed]
                break
        compared += len(times)
        if not len(times):
            continue
        for one, other in (
            *zip(plain.at(times), kicked.at(times), strict=True),
            (plain.gaps_at(times), kicked.gaps_at(times)),
            (plain.forces_at(times), kicked.forces_at(times)),
        ):
            np.testing.assert_array_equal(one, other, err_msg=f"scene {k}")
    print(compared)
    assert compared > 30 * KICKED


def test_a_kick_between_two_landings_is_no_cycle_of_an_accumulation():
    """Without friction one cycle of two feet shows all later ones, but not if a kick falls into it: the run goes on as a run
    that starts just after the kick."""
    rng, compared = np.random.default_rng(1), 0
    for _ in range(1000):
        xs = (-1 + rng.uniform(-0.2, 0.2), 1 + rng.uniform(-0.2, 0.2))
        center = (rng.uniform(-0.6, 0.6), rng.uniform(0.3, 1))
        body = sf.Posture(
            1.0,
            rng.uniform(0.3, 0.9),
            center,
            [sf.Contact((x, 0)) for x in xs],
            rng.choice([0, 0.2, 0.5]),
            9.81,
        )
        q = (0, 0.01, rng.uniform(-0.005, 0.005))
        if min(body.gaps(q)) <= 0:
            continue
        free = sf.simulate(body, q, (0, 0, 0), model="local").zeno_points
        if len(free) < 2:
            continue
        first, last = free[0].time, free[-1].time
        t = first + (last - first) * rng.uniform(0.05, 0.5)
        kick = sf.Kick(t, (0, rng.uniform(0.1, 1)), point=(xs[0], 0.0))
        run = sf.simulate(body, q, (0, 0, 0), model="local", kicks=[kick])
        later = min(t + 1e-9, run.time)
        at, moving = run.at(later)[:2]
        if min(body.gaps(at)) < 0:
            continue
        onward = sf.simulate(body, at, moving, model="local")
        assert later + onward.elapsed == pytest.approx(run.time, rel=1e-6), body
        compared += 1
    assert compared > 500
