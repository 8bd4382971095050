"""Ground that accelerates linearly between the samples of a record: against closed forms and an independent integration."""

import math
import pickle

import numpy as np
import pytest
import standfast as sf
from scipy.integrate import solve_ivp

G = 10.0
HEIGHT, WIDTH = 4.0, 1.0


def block(friction=5.0, restitution=0.0):
    """A uniform slender block on two feet; with this friction it rocks and does not slip."""
    feet = [sf.Contact((side * WIDTH / 2, 0.0), friction=friction) for side in (-1, 1)]
    rho = math.hypot(WIDTH, HEIGHT) / math.sqrt(12)
    return sf.Posture(1.0, rho, (0.0, HEIGHT / 2), feet, restitution, gravity=G)


def record(seed, amplitude, step=0.02, duration=4.0):
    """Times and horizontal accelerations: a few waves of random phase that fade in and out."""
    rng = np.random.default_rng(seed)
    times = np.arange(0, duration + step / 2, step)
    waves = [
        np.sin(2 * math.pi * f * times + rng.uniform(0, 6))
        for f in rng.uniform(0.5, 3, 5)
    ]
    shape = np.sin(math.pi * times / duration)
    acceleration = amplitude * shape * np.sum(waves, axis=0) / 2
    acceleration[[0, -1]] = 0
    return times, acceleration


def rocking(times, acceleration, rtol=1e-13):
    """Housner's block under this record, integrated between events: angle at each sample, and the number of impacts.

    φ > 0: it turns counterclockwise about the left foot. (4/3) R² φ'' = −g R sin(α − φ) − a R cos(α − φ), and mirrored.
    """
    half, height = WIDTH / 2, HEIGHT / 2
    radius, alpha = math.hypot(half, height), math.atan2(half, height)
    kept = 1 - 1.5 * math.sin(alpha) ** 2
    state, at_rest, impacts = np.zeros(2), True, 0
    angles = [0.0]
    for k in range(len(times) - 1):
        start, end = times[k], times[k + 1]
        rate = (acceleration[k + 1] - acceleration[k]) / (end - start)

        def ground(t, k=k, start=start, rate=rate):
            return acceleration[k] + rate * (t - start)

        now = start
        if at_rest and np.abs(acceleration[k : k + 2]).max() > G * half / height:
            # It begins to turn where |a| passes g b/h: the ground runs away under it.
            limit = math.copysign(G * half / height, ground(end))
            now = start + (limit - acceleration[k]) / rate
            at_rest, side = False, -math.copysign(1, limit)
            # A ground that accelerates to the right leaves the block turning to the left: counterclockwise.
            side = -side
        while not at_rest and now < end:

            def turning(t, y, side=side, ground=ground):
                lean = alpha - side * y[0]
                moment = -side * G * math.sin(lean) + ground(t) * math.cos(lean)
                return [y[1], 0.75 * moment / radius]

            def lands(t, y, side=side):
                return side * y[0]

            lands.terminal, lands.direction = True, -1
            found = solve_ivp(
                turning,
                (now, end),
                state,
                method="DOP853",
                rtol=rtol,
                atol=1e-16,
                events=lands,
            )
            now, state = found.t[-1], found.y[:, -1]
            if found.status == 1:
                impacts, side = impacts + 1, -side
                state = np.array([0.0, kept * state[1]])
        angles.append(state[0])
    return np.array(angles), impacts


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_rocking_block_under_a_record(seed):
    times, acceleration = record(seed, 4.0)
    angles, impacts = rocking(times, acceleration)
    shake = sf.GroundMotion(times, acceleration, interpolation="linear")
    run = sf.simulate(block(), ground_motion=shake, time_limit=times[-1])
    found = np.array([run.at(t)[0][2] for t in times])
    assert impacts >= 2
    assert np.abs(angles).max() > 0.02
    np.testing.assert_allclose(found, angles, rtol=0, atol=1e-9)


def test_steps_converge_to_the_line():
    """The mean of each of n parts of the intervals, held: an error of second order in their length."""
    times, acceleration = record(1, 4.0)
    linear = sf.GroundMotion(times, acceleration, interpolation="linear")
    exact = sf.simulate(block(), ground_motion=linear, time_limit=2.5).q
    errors = []
    for parts in (1, 4, 16, 64):
        fine = np.linspace(0, times[-1], parts * (len(times) - 1) + 1)
        values = np.interp(fine, times, acceleration)
        means = [*(values[:-1] + values[1:]) / 2, 0.0]
        steps = sf.simulate(
            block(), ground_motion=sf.GroundMotion(fine, means), time_limit=2.5
        ).q
        errors.append(np.abs(steps - exact).max())
    orders = np.log(np.array(errors[:-1]) / errors[1:]) / math.log(4)
    assert errors[-1] < 1e-5
    np.testing.assert_allclose(orders, 2, atol=0.35)


def test_a_ball_flies_over_ground_that_accelerates():
    """Constant friction-free flight: y = h − g t²/2 + …, with a cubic in t; the fall onto ground that rises ever faster."""
    ball = sf.Posture(1.0, 1.0, (0, 0), [sf.Contact((0, 0))], 0.5, gravity=G)
    jerk = (3.0, 6.0)
    lift = sf.GroundMotion(
        [0, 2], [(0, 0), (2 * jerk[0], 2 * jerk[1])], interpolation="linear"
    )
    run = sf.simulate(ball, (0, 5.0, 0), ground_motion=lift, time_limit=1.9)
    # 5 − 5 t² − t³ = 0.
    roots = np.roots([-jerk[1] / 6, -G / 2, 0, 5])
    landing = roots[(np.abs(roots.imag) < 1e-12) & (roots.real > 0)].real[0]
    assert abs(run.impacts["time"][0] - landing) < 1e-14
    rate = G * landing + jerk[1] * landing**2 / 2
    np.testing.assert_allclose(run.impacts["rates_before"][0, 0], -rate, rtol=1e-14)
    np.testing.assert_allclose(run.impacts["rates_after"][0, 0], rate / 2, rtol=1e-14)
    q, qdot = run.at(0.5)
    np.testing.assert_allclose(
        q, [-jerk[0] / 6 * 0.125, 5 - 1.25 - 0.125, 0], rtol=1e-14
    )
    np.testing.assert_allclose(qdot, [-jerk[0] / 2 * 0.25, -5 - 0.75, 0], rtol=1e-14)


def test_a_block_slides_once_friction_is_exceeded():
    """a = j t: it slips from j t = μ g on, and its slip is −j (t − t*)³/6."""
    flat = sf.Posture(
        1.0,
        1.0,
        (0, 0.1),
        [sf.Contact((x, 0), friction=0.3) for x in (-1, 1)],
        0.0,
        gravity=G,
    )
    shake = sf.GroundMotion([0, 3], [0.0, 6.0], interpolation="linear")
    run = sf.simulate(flat, ground_motion=shake, time_limit=2.5)
    start = 0.3 * G / 2
    assert [phase.mode for phase in run.phases if phase.end > phase.start] == [
        "FF",
        "LL",
    ]
    assert abs(run.phases[-1].start - start) < 1e-14
    # At rest the feet carry the ground's acceleration, 2 t, and after the slip begins μ g.
    for t, friction in ((0.6, -1.2), (1.2, -2.4), (2.0, -0.3 * G)):
        forces = run.forces_at(t)
        np.testing.assert_allclose(forces.sum(axis=0), [-friction, G], rtol=1e-12)
    np.testing.assert_allclose(
        run.q, [-2 * (2.5 - start) ** 3 / 6, 0, 0], rtol=1e-13, atol=1e-14
    )
    # Forwards again: the ground slows down and reverses, and the block comes to rest on it.
    back = sf.GroundMotion([0, 3, 6, 8], [0.0, 6.0, -6.0, 0.0], interpolation="linear")
    run = sf.simulate(flat, ground_motion=back)
    assert run.outcome == "rest"
    assert run.time > 4


@pytest.mark.parametrize(
    ("ground", "words", "start"),
    [
        ([(0, 0), (0, 4)], ["FF"], 0),
        ([(0, 0), (0, -4)], ["SS"], 0),
        ([(0, 1), (0, -3)], ["FF", "SS"], 0.25),
        ([(0, 4), (4, 4)], ["FF", "LL"], 0.5),
    ],
)
def test_without_gravity_the_ground_alone_presses(ground, words, start):
    """Weightless: the floor holds the body while it accelerates upwards, and slides away where friction is exceeded."""
    feet = [sf.Contact((x, 0), friction=0.5) for x in (-1, 1)]
    body = sf.Posture(1.0, 0.5, (0, 0.1), feet, 0.0, gravity=0.0)
    motion = sf.GroundMotion([0, 1], ground, interpolation="linear")
    run = sf.simulate(body, ground_motion=motion, time_limit=0.9)
    phases = [phase for phase in run.phases if phase.end > phase.start]
    assert [phase.mode for phase in phases] == words
    assert abs(phases[-1].start - start) < 1e-14
    # The way of the ground in the last phase, relative to which the body stays or slides with half of the press.
    if words[-1] == "SS":
        left = 0.9 - start
        np.testing.assert_allclose(run.q, [0, 4 * left**3 / 6, 0], rtol=1e-13)


def test_bounces_end_while_the_ground_accelerates():
    """Bounces are summed once the change of the load until their end is below rounding."""
    ball = sf.Posture(1.0, 1.0, (0, 0), [sf.Contact((0, 0))], 0.5, gravity=G)
    shake = sf.GroundMotion([0, 10], [(0.0, 0.0), (0.0, 1.0)], interpolation="linear")
    run = sf.simulate(ball, (0, 1.0, 0), ground_motion=shake, time_limit=9.0)
    (zeno,) = run.zeno_points
    steps = np.linspace(0, 10, 4001)
    held = sf.GroundMotion(steps, [(0, t / 10 + 0.000125) for t in steps])
    other = sf.simulate(
        ball, (0, 1.0, 0), ground_motion=held, time_limit=9.0
    ).zeno_points[0]
    assert abs(zeno.time - other.time) < 1e-6
    assert 20 < run.collisions < 80


def test_records_from_arrays_and_files(tmp_path):
    times, acceleration = np.array([0, 0.1, 0.2]), np.array([0, 1.0, 0.5])
    motion = sf.GroundMotion.from_record((times, acceleration), scale=2.0)
    assert motion.interpolation == "linear"
    assert motion.acceleration == [(0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (0.0, 0.0)]
    np.testing.assert_allclose(motion.times, [0, 0.1, 0.2, 0.3])
    path = tmp_path / "record.csv"
    path.write_text("t, a\n0, 0\n0.1, 0.1\n0.2, 0\n")
    read = sf.GroundMotion.from_record(path)
    np.testing.assert_allclose(read.acceleration, [(0, 0), (0.980665, 0), (0, 0)])
    assert pickle.loads(pickle.dumps(read)) == read
    scene = sf.Scene(block(), ground_motion=read)
    scene.save(tmp_path / "scene.toml")
    assert sf.load(tmp_path / "scene.toml").ground_motion == read
    with pytest.raises(TypeError, match=r"record = .* a path, or a pair"):
        sf.GroundMotion.from_record((1, 2, 3))


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (
            lambda: sf.GroundMotion([0, 1], tilt=[0, 0.1], interpolation="linear"),
            'interpolation = "linear" .* with a tilt',
        ),
        (
            lambda: sf.GroundMotion([0, 1], [0, 1], interpolation="cubic"),
            "interpolation",
        ),
        (
            lambda: sf.simulate(
                block(),
                model="local",
                ground_motion=sf.GroundMotion([0, 1], [0, 1], interpolation="linear"),
            ),
            'model = "local" .* with a linear ground_motion',
        ),
    ],
)
def test_wrong_motions_are_named(make, text):
    with pytest.raises(ValueError, match=text):
        make()
