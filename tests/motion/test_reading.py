"""The motion at many times in one call has the bits of a call for each time, in any order of the times."""

import math

import numpy as np
import pytest
import standfast as sf
from walls import random_scene

#: Number of random scenes on polylines with walls.
SCENES = 30
#: Even times of each run.
TIMES = 60


def runs():
    """A run for each way in which a piece of motion is computed."""
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    uniform = sf.Posture.rod(0.5, math.sqrt(1 / 12), restitution=0.5)
    box = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
    block = sf.Posture.box(0.5, 1.5, friction=2)
    tilted = sf.Posture.box(1, 1, friction=0.2)
    low, still = (0, 0.011, 0.002), (0, 0, 0)
    thrown = {"q": (0, 0.6, 0.4), "qdot": (1.5, 0.5, -3)}
    kicks = [sf.Kick(time=0.4, impulse=(0.4, 1.0))]
    reduced = sf.LocalModel((9.81, 9.81), (0.7, 0.7), (0.5, -0.5), 0.1)
    held = {"impact": "moreau", "time_limit": 2}
    return {
        "flights in a frozen frame": sf.simulate(rod, low, still, model="local"),
        "flights and sums": sf.simulate(rod, low, still, model="full"),
        "nested sums": sf.simulate(uniform, low, still, model="full"),
        "without a body": reduced.simulate(
            gaps=(0.0, 0.01), rates=(0.1, -0.5), theta=0.0, omega=0.0
        ),
        "impacts with friction": sf.simulate(box, impact="moreau", **thrown),
        "Poisson's law": sf.simulate(box, impact="poisson", **thrown),
        "rocking": sf.simulate(
            block, block.touching(contact=1, theta=0.1), still, **held
        ),
        "sliding": sf.simulate(tilted, still, (2, 0, 0), **held),
        "at rest, kicked, at rest": sf.simulate(
            block, still, still, kicks=kicks, **held
        ),
        # Taylor series that follow each other: a slide that falls over an edge has no event for long.
        "slow fall on a foot": sf.simulate(
            block, block.touching(contact=1, theta=0.3217), still, **held
        ),
    }


def same_bits(run, shuffle):
    impacts = run.impacts["time"]
    events = [zeno.time for zeno in run.zeno_points] + [p.start for p in run.phases]
    start = run.phases[0].start if run.phases else run.time
    times = np.concatenate([np.linspace(start, run.time, TIMES), impacts[:20], events])
    times.sort()
    reads = [run.gaps_at, run.gap_rates_at, run.points_at, run.energy, run.forces_at]
    reads += [lambda t: run.at(t)[0], lambda t: run.at(t)[1]]
    for order in (np.arange(len(times)), shuffle(len(times))):
        for read in reads:
            at_once = read(times[order])
            one_by_one = np.stack([read(t) for t in times[order]])
            assert at_once.tobytes() == one_by_one.tobytes()


@pytest.mark.parametrize("name", runs())
def test_many_times_have_the_bits_of_each(name):
    same_bits(runs()[name], np.random.default_rng(1).permutation)


def test_many_times_on_random_ground_have_the_bits_of_each():
    rng = np.random.default_rng(2)
    for _ in range(SCENES):
        _, posture, qdot, options = random_scene(rng)
        same_bits(sf.simulate(posture, (0, 0, 0), qdot, **options), rng.permutation)


def test_times_within_a_sum_of_rocking_have_the_same_bits_in_any_order():
    """Up to the last units in the last place before the limit."""
    block = sf.Posture.box(0.4, 1.0, friction=1.0, restitution=0.0)
    run = sf.simulate(block, block.touching(contact=1, theta=0.1), (0, 0, 0))
    begin, end = run.phases[-2].start, run.zeno_points[-1].time
    assert run.zeno_points[-1].method == "nested"
    shares = 1 - np.geomspace(1, 1e-12, 30)
    close = end - np.arange(1, 6) * np.spacing(end)
    times = np.sort([*(begin + (end - begin) * shares), *close])
    alone = np.array([np.concatenate(run.at(t)) for t in times])
    for order in (np.arange(len(times)), np.arange(len(times))[::-1]):
        q, qdot = run.at(times[order])
        assert np.array_equal(np.hstack([q, qdot]), alone[order])
