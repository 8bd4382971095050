"""Problems of a textbook: examples of R. I. Leine, *An Introduction to Nonsmooth Dynamics*, by their parameters.

The oracle is a pivot of a body about a fixed point, which is a physical pendulum, integrated apart from the library.
"""

import math

import edge
import numpy as np
import pytest
import standfast as sf
import stepping

#: Half-width and half-height of the block, and the angle at which it is released, at rest on its left corner.
SLENDER = (0.0125, 0.05, math.radians(8))
FLAT = (0.05, 0.0125, math.radians(30))
FRICTION = 0.3
FLOOR = [(-1.0, 0.0), (0.0, 0.0), (1.0, 0.0)]


def released(half_width, half_height, angle):
    """The block, and q at which its left lower corner is where it was at q = 0."""
    block = sf.Posture.box(2 * half_width, 2 * half_height, friction=FRICTION)
    cos, sin = math.cos(angle), math.sin(angle)
    x = -half_width + cos * half_width - sin * half_height
    y = sin * half_width + cos * half_height - half_height
    return block, (x, y, angle)


def angles(which, times):
    block, q = released(*which)
    run = sf.simulate(block, q, (0, 0, 0), impact="moreau")
    return run, [run.at(t)[0][2] for t in times]


def pendulum(which, t):
    """θ before the first impact, while the left corner sticks: a pivot about a point at the end of a side."""
    half_width, half_height, angle = which
    side = edge.Side.of_box(2 * half_width, 2 * half_height, 100.0)
    z = -half_width, angle, 0.0, 0.0
    motion = edge.follow(side, (0, 0), z, t, (0.0, 3.0))
    assert motion.word() == "pivot"
    assert motion.left == "time"
    return motion.at(t)[0][2]


def test_a_slender_block_rocks():
    """Angles of a solution with fixed steps of 5e-5 s, which differ from those of the library by 5e-8, 4e-7 and 4e-6; twice that is
    allowed. The time of rest is the library's own: a sum of all the swings."""
    run, found = angles(SLENDER, (0.05, 0.1, 0.15))
    for theta, stepped, error in zip(
        found, (0.12030008, 0.05527450, -0.05059532), (1e-7, 8e-7, 8e-6), strict=True
    ):
        assert theta == pytest.approx(stepped, abs=error)
    assert run.outcome == "rest"
    assert run.time == pytest.approx(1.88338743, abs=1e-8)
    assert run.q == pytest.approx((run.q[0], 0, 0), abs=1e-12)


def test_a_flat_block_rocks():
    _, [theta] = angles(FLAT, (0.05,))
    assert theta == pytest.approx(0.35351343, abs=4e-7)


def test_before_the_first_impact_the_slender_block_is_a_pendulum():
    """The corner of the flat one slips."""
    _, found = angles(SLENDER, (0.05, 0.1))
    for t, theta in zip((0.05, 0.1), found, strict=True):
        # The run is integrated to 1e-12 of its size.
        assert theta == pytest.approx(pendulum(SLENDER, t), abs=1e-11)


def test_fixed_steps_agree():
    """The same block on a terrain, by the baseline of this project, to first order: 0.15 s with steps of 2e-4 s."""
    half_width, half_height, _ = SLENDER
    block, q = released(*SLENDER)
    on_floor = sf.Posture.box(
        2 * half_width, 2 * half_height, friction=FRICTION, terrain=FLOOR
    )
    bodies = stepping.Bodies.of_postures([on_floor], [q], [(0, 0, 0)], [0.0])
    place, _ = stepping.simulate(bodies, 2e-4, 0.15, each=lambda *_: None)
    run = sf.simulate(
        block, q, (0, 0, 0), impact="moreau", stop="time", time_limit=0.15
    )
    # An impact is late by up to a step; there ω changes by up to 0.5 rad/s.
    assert place[0][2] == pytest.approx(run.q[2], abs=2e-4)
    assert np.abs(place[0][:2] - run.q[:2] - (0, half_height)).max() < 2e-5
