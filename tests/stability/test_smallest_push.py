"""The smallest push, against closed forms of boxes that turn about a corner, and against simulations on both sides of each end.

STANDFAST_PUSHED sets the number of random bodies (6).
"""

import importlib.util
import math
import os
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

BODIES = int(os.environ.get("STANDFAST_PUSHED", "6"))
G = 9.81


def corner_inertia(width, height):
    """About a lower corner, per unit mass, in m²."""
    return (width**2 + height**2) / 3


def rise(width, height):
    """Of the centre of mass until it is above the corner, in m."""
    return (math.hypot(width, height) - height) / 2


def came_back(posture, size, direction, point, **options):
    """A run of its own, judged by where the feet end."""
    unit = np.array(direction) / np.linalg.norm(direction)
    kick = sf.Kick(0, tuple(size * unit), point)
    run = sf.simulate(posture, kicks=[kick], model="full", record=False, **options)
    return run.outcome == "rest" and abs(run.theta) < 1e-6 and abs(run.gaps[:2]).max() < 1e-9  # fmt: skip


@pytest.mark.parametrize(("width", "height"), [(1, 2), (0.5, 3), (2, 2.5)])
def test_a_box_pushed_at_its_top_turns_about_its_corner(width, height):
    """J h = I ω, ½ I ω² = m g Δh. The corner does not slip: friction is large."""
    mass = 3.0
    box = sf.Posture.box(width, height, mass=mass, friction=5.0, gravity=G)
    found = sf.smallest_push(box, point=(0, height))
    inertia, lifted = corner_inertia(width, height), rise(width, height)
    exact = mass * math.sqrt(2 * G * lifted * inertia) / height
    assert found.impulse == pytest.approx(exact, rel=2e-9)
    assert found.force is None
    assert found.scale is None
    low, high = found.intervals[0]
    assert low < high <= found.at_most
    assert not found.came_back[(found.sizes > low) & (found.sizes < high)].any()
    assert found.came_back[found.sizes < low].all()


def test_a_push_that_lasts_long_is_the_static_one_and_a_short_one_a_kick():
    """A force at the centre of mass tips a box at F = m g w/h if it lasts, and with J h/2 = I ω, ½ I ω² = m g Δh if it is short."""
    width, height = 1.0, 4.0
    box = sf.Posture.box(width, height, friction=5.0, gravity=G)
    long = sf.smallest_push(box, duration=50.0, rtol=1e-7)
    # Once it has lifted off, the force does more work than gravity takes.
    assert long.force == pytest.approx(G * width / height, rel=1e-4)
    assert long.impulse is None
    short = sf.smallest_push(box, duration=1e-6)
    inertia, lifted = corner_inertia(width, height), rise(width, height)
    exact = 2 * math.sqrt(2 * G * lifted * inertia) / height
    assert short.force * 1e-6 == pytest.approx(exact, rel=1e-5)


def test_the_scale_of_a_record_is_that_of_a_single_run():
    box = sf.Posture.box(1.0, 4.0, friction=5.0, gravity=G)
    pulse = sf.GroundMotion([0, 0.3, 0.6], [(2, 0), (-2, 0), (0, 0)])
    found = sf.smallest_push(box, ground_motion=pulse)
    low = found.scale
    for factor, outcome in ((1 - 1e-6, True), (1 + 1e-6, False)):
        size = low * factor
        scaled = sf.GroundMotion([0, 0.3, 0.6], [(2 * size, 0), (-2 * size, 0), (0, 0)])
        run = sf.simulate(box, ground_motion=scaled, model="full")
        assert (abs(run.theta) < 1e-6) == outcome
    assert len(found.intervals) >= 1


def test_ends_of_intervals_bracket_of_random_bodies():
    rng, islands, checked = np.random.default_rng(641), 0, 0
    for _ in range(BODIES):
        width, height = rng.uniform(0.3, 1.5), rng.uniform(0.8, 2.0)
        box = sf.Posture.box(width, height, mass=rng.uniform(1, 5), friction=rng.uniform(0.3, 1.5), restitution=rng.choice([0, 0.2]), gravity=G)  # fmt: skip
        direction = (1, rng.uniform(-0.3, 0.3))
        point = (rng.uniform(-0.5, 0.5) * width, rng.uniform(0.5, 1.0) * height)
        found = sf.smallest_push(box, direction, point, scan=64)
        if found.impulse is None:
            continue
        islands += len(found.intervals) > 1
        for low, high in found.intervals:
            assert came_back(box, low * (1 - 1e-6), direction, point)
            assert not came_back(box, low * (1 + 1e-12), direction, point)
            if high < found.at_most:
                assert not came_back(box, high * (1 - 1e-12), direction, point)
                assert came_back(box, high * (1 + 1e-6), direction, point)
        for part in rng.uniform(0, 1 - 1e-6, 20):
            first = found.sizes[np.flatnonzero(~found.came_back)[0]] if (~found.came_back).any() else found.at_most  # fmt: skip
            assert came_back(box, part * min(found.impulse, first), direction, point)
        checked += 1
    assert checked >= BODIES / 2


def test_islands_of_a_pulse_are_those_of_scipy():
    """Between two intervals of amplitudes the second half of the pulse throws the block back. An integration of Housner's equation by scipy
    changes its answer at the same ends, to 1e-5."""
    pytest.importorskip("scipy")
    pytest.importorskip("matplotlib")
    path = Path(__file__).parents[2] / "examples" / "overturning_spectrum.py"
    spec = importlib.util.spec_from_file_location("overturning_spectrum", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    block = sf.Posture.box(example.WIDTH, example.HEIGHT, friction=example.FRICTION, gravity=G)  # fmt: skip
    least = G * math.tan(example.SLENDER)
    frequency = 1.48
    pulse = example.pulse(frequency, least)
    found = sf.smallest_push(block, ground_motion=pulse, at_most=6, scan=96)
    assert len(found.intervals) == 2
    (low, high), (again, most) = found.intervals
    assert most == 6
    for end, falls_above in ((low, True), (high, False), (again, True)):
        for factor in (1 - 1e-5, 1 + 1e-5):
            falls = example.overturns(example.pulse(frequency, least * end * factor))  # fmt: skip
            assert falls == ((factor > 1) == falls_above), (frequency, end, factor)


def test_nothing_found_unstable_bodies_and_wrong_arguments():
    low = sf.Posture.box(4.0, 0.2, friction=0.1, gravity=G)
    safe = sf.smallest_push(low, at_most=1.0, scan=8)
    assert safe.impulse is None
    assert safe.intervals.shape == (0, 2)
    assert safe.came_back.all()
    assert "comes back from all up to" in repr(safe)
    box = sf.Posture.box(1, 1, friction=0.5)
    for arguments, message in (
        ({"at_most": 0}, "at_most = 0"),
        ({"direction": (0, 0)}, "direction = 0"),
        ({"duration": -1}, "duration = -1"),
        ({"scan": 0}, "scan = 0"),
        ({"rtol": 2}, "rtol = 2"),
        ({"point": (0, 1), "duration": 1}, "at most one"),
        ({"ground_motion": sf.GroundMotion([0], tilt=[0.1])}, "by accelerations"),
    ):
        with pytest.raises(ValueError, match=message):
            sf.smallest_push(box, **arguments)


def test_many_runs_with_motions_of_their_own():
    box = sf.Posture.box(1, 2, friction=0.5)
    motions = [None, *[sf.GroundMotion([0, 0.2], [(a, 0), (0, 0)]) for a in (3, 6, 9)]]
    runs = sf.simulate_many(box, (0, 0, 0), (0, 0, 0), ground_motion=motions)
    for k, motion in enumerate(motions):
        one = sf.simulate(box, ground_motion=motion)
        assert np.array_equal(runs.q[k], one.q)
        assert runs[k].ground_motion == motion
    with pytest.raises(ValueError, match=r"ground_motion = .4 motions. cannot be used: one motion of the ground, or one for each of the 3 states"):  # fmt: skip
        sf.simulate_many(box, np.zeros((3, 3)), (0, 0, 0), ground_motion=motions)


def test_a_push_without_a_motion_says_so():
    """A tall block whose blow makes it slide jams at once (Painlevé): the smallest push is 0, and not because the block falls."""
    block = sf.Posture.box(0.5, 1.5, friction=2)
    jams = sf.smallest_push(block)
    assert jams.impulse < 1e-9
    assert jams.outcome == "inconsistent"
    assert "inconsistent" in repr(jams)
    topples = sf.smallest_push(block, point=(0, 1.5))
    assert topples.outcome == "rest"
    assert "inconsistent" not in repr(topples)
    assert sf.smallest_push(block, point=(0, 1.5), at_most=0.1).outcome is None


@pytest.mark.parametrize(
    ("half", "height", "rho"), [(0.2, 0.7, 0.5), (0.3, 0.6, 0.4), (0.5, 0.8, 0.3)]
)
def test_a_body_on_feet_alone_that_turns_over_does_not_come_back(half, height, rho):
    """Without contacts on top a body that falls over its foot goes on through the ground, and after half a turn its feet are on their line again."""
    feet = [sf.Contact((x, 0), friction=5.0) for x in (-half, half)]
    body = sf.Posture(1, rho, (0, height), feet, restitution=0)
    radius = math.hypot(half, height)
    exact = math.sqrt(2 * G * (radius - height) * (rho**2 + radius**2)) / (2 * height)
    found = sf.smallest_push(body, point=(0, 2 * height), scan=1000)
    assert found.impulse == pytest.approx(exact, rel=2e-9)
    # Once over, always over: no larger push counts as harmless.
    assert found.intervals.shape == (1, 2)
    kicked = sf.robustness(body, [1.0, 3.0], trials=300)
    speeds = kicked.qdot[kicked.returned]
    assert 0 < len(speeds) < kicked.returned.size
    ends = sf.simulate_many(body, np.zeros(3), speeds, model="full")
    assert (abs(ends.q[:, 2]) < 1).all()


def test_a_long_record_of_fine_samples_is_scaled():
    """2001 samples, each a load of its own: laps of rocking that outlast their load are given up, or this would take minutes."""
    times = 0.01 * np.arange(2001)
    random = np.random.default_rng(8)
    waves = sum(
        a * np.sin(w * times + p)
        for a, w, p in random.uniform((0.5, 3, 0), (1, 18, 6), (12, 3))
    )
    shape = waves * np.sin(np.pi * times / times[-1])
    acceleration = 0.35 * G * shape / abs(shape).max()
    record = sf.GroundMotion.from_record((times, acceleration))
    statue = sf.Posture.box(0.6, 2.0, friction=0.5, gravity=G)
    found = sf.smallest_push(
        statue, ground_motion=record, at_most=4, scan=24, rtol=1e-3
    )
    low, high = found.intervals[0]
    # It does not rock below g b/h.
    assert low > 0.3 / 0.35
    for factor, falls in ((0.99 * low, False), (0.5 * (low + high), True)):
        scaled = sf.GroundMotion.from_record((times, factor * acceleration))
        run = sf.simulate(statue, ground_motion=scaled, model="full")
        assert (abs(run.theta) > 1) == falls
