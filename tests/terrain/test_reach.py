"""Pieces and corners of the ground that a body does not reach have no effect on its motion, and nearly none on its cost.

STANDFAST_REACH sets the number of scenes (40).
"""

import os

import numpy as np
import pytest
import standfast as sf

SCENES = int(os.environ.get("STANDFAST_REACH", "40"))


def far_ground(rng, count):
    """`count` vertices from x = 30 m on: a rough way down, with walls and overhangs."""
    x, y, found = 30.0, -3.0, []
    for k in range(count):
        if k % 3 == 2:
            y -= rng.uniform(0.05, 0.3)
        else:
            x += rng.uniform(0.05, 0.3)
            y += rng.uniform(-0.1, 0.1)
        found.append((x, y))
    return found


def near_ground(rng):
    """A rough way about the origin: steps, walls, a trough."""
    x, y, found = -6.0, 0.0, [(-40.0, 0.0), (-6.0, 0.0)]
    while x < 5:
        x += rng.uniform(0.3, 1.5)
        found.append((x, y))
        y += rng.uniform(-0.4, 0.4)
        found.append((x + rng.choice([0.0, 0.1]), y))
        x = found[-1][0]
    found.append((29.0, y))
    top = max(y for _, y in found)
    return [(x, y - top) for x, y in found]  # below the body in its nominal posture


def body_on(rng, ground):
    width, height = rng.uniform(0.3, 1.5, 2)
    fields = {"restitution": rng.uniform(0, 0.7), "friction": rng.choice([0, 0.4])}
    try:
        if rng.random() < 0.3:
            return sf.Posture.disc(0.5 * width, 0.0, terrain=ground, **fields)
        return sf.Posture.box(width, height, terrain=ground, **fields)
    except ValueError:
        return None  # a disc does not fit


def test_ground_out_of_reach_changes_no_bit():
    """One body on one ground that goes on far away in two ways: all impacts, Zeno points and the end have the same bits."""
    compared = 0
    for k in range(SCENES):
        rng = np.random.default_rng([k, 13])
        near = near_ground(rng)
        few, many = far_ground(rng, 2), far_ground(rng, 700)
        seed = int(rng.integers(1 << 32))
        start = (0.0, rng.uniform(0.3, 1.5), rng.uniform(-0.5, 0.5))
        kick = rng.uniform(-1, 1, 3) * [1.0, 1.0, 3.0]
        runs = []
        for far in (few, many):
            body = body_on(np.random.default_rng(seed), near + far)
            if body is None:
                break
            try:
                run = sf.simulate(body, start, kick, time_limit=2.5, event_limit=3000)
            except ValueError:
                break  # it starts in the ground
            runs.append(run)
        if len(runs) < 2:
            continue
        one, other = runs
        assert one.outcome == other.outcome
        assert one.time == other.time
        np.testing.assert_array_equal(one.q, other.q)
        np.testing.assert_array_equal(one.impacts, other.impacts)
        assert [z.time for z in one.zeno_points] == [z.time for z in other.zeno_points]
        assert [p.mode for p in one.phases] == [p.mode for p in other.phases]
        compared += len(one.impacts) > 2
    assert compared > 0.4 * SCENES


def test_corners_near_the_body_are_all_found():
    """A box falls flat onto a fine hill: the corner of the ground that it meets first is the highest one, wherever it is."""
    for count in (20, 200, 900):
        xs = np.linspace(-3, 3, count)
        for top in (-0.3, 0.1, 0.37):
            ground = [(float(x), float(-0.05 * abs(x - top))) for x in xs]
            highest = max(ground, key=lambda p: p[1])
            box = sf.Posture.box(
                2.0, 0.5, restitution=0.0, friction=0.5, terrain=ground
            )
            run = sf.simulate(box, (0, 0.5, 0))
            side = next(c for c in run.contacts if c.corner is not None)
            assert tuple(side.corner) == pytest.approx(highest)
