"""Scenes with corners of the ground on sides of the body in which random bodies on random ground showed an error of a first version."""

import math

import depths
import numpy as np
import pytest
import standfast as sf

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
