"""The speed of a kick below which a body comes back in the full model."""

import math
import os
import sys
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

sys.path.append(str(Path(__file__).parents[2] / "benches"))
from safe_speeds import BELOW, box, feet

#: Number of postures that are kicked, with a hundred kicks each. `make long-cut` sets more.
KICKED = int(os.environ.get("STANDFAST_SAFE", "8"))


def tipping(width, height):
    """The speed that lifts the centre of mass of a box over its corner: √(2gH) [West 1882]."""
    rise = math.hypot(0.5 * width, 0.5 * height) - 0.5 * height
    return math.sqrt(2 * 9.81 * rise)


@pytest.mark.parametrize(("width", "height"), [(0.3, 0.5), (1, 1), (2, 1), (0.5, 1)])
def test_a_box_is_safe_until_it_can_tip(width, height):
    speed = sf.stability(sf.Posture.box(width, height, friction=0.4)).safe_speed
    assert (1 - 1e-4) * tipping(width, height) < speed < tipping(width, height)


def test_kicks_a_little_faster_tip_a_box():
    """The bound could not be much larger: a kick about its corner tips the box."""
    posture = sf.Posture.box(0.3, 0.5, friction=0.9, restitution=0)
    speed = sf.stability(posture).safe_speed
    rho = posture.gyration_radius
    turn = np.array([-0.25, 0.15, 1.0])
    turn /= math.hypot(turn[0], turn[1], rho)
    for factor, back in ((0.999, True), (1.002, False)):
        run = sf.simulate(posture, (0, 0, 0), factor * speed * turn, impact="newton")
        assert (abs(run.q[2]) < 0.1) == back


@pytest.mark.parametrize("draw", [feet, box])
def test_slower_kicks_come_back(draw):
    rng = np.random.default_rng(7)
    kicked = 0
    while kicked < KICKED:
        posture = draw(rng)
        verdict = sf.stability(posture)
        if verdict.safe_speed is None:
            continue
        kicked += 1
        for law in verdict.laws:
            size = BELOW * verdict.safe_speed
            found = sf.robustness(posture, [size], trials=100, seed=kicked, impact=law)
            assert found.share[0] == 1, (posture, found.outcomes)


def test_it_does_not_depend_on_place_and_order():
    rng = np.random.default_rng(8)
    compared = 0
    while compared < 20:
        posture = feet(rng)
        speed = sf.stability(posture).safe_speed
        if speed is None:
            continue
        compared += 1
        moved = [
            sf.Contact(
                (k.point[0] + 3, k.point[1] - 2), slope=k.slope, friction=k.friction
            )
            for k in posture.contacts[::-1]
        ]
        x, y = posture.center_of_mass
        other = sf.Posture(
            mass=3,
            gyration_radius=posture.gyration_radius,
            center_of_mass=(x + 3, y - 2),
            contacts=moved,
            restitution=posture.restitution,
        )
        assert sf.stability(other).safe_speed == pytest.approx(speed, rel=1e-3)


def test_where_there_is_none():
    rod = sf.Posture.rod(0.5, friction=0.5)
    level = {"friction": 0.5, "restitution": 0.2}
    for posture in (
        sf.Posture.box(0.3, 0.5, friction=0),
        sf.Posture.box(0.3, 0.5, terrain=[(-1, 0), (1, 0)], **level),
        sf.Posture.disc(0.2, **level),
    ):
        assert sf.stability(posture).safe_speed is None
    for same in (rod, sf.Mechanism.of_posture(sf.Posture.box(0.3, 0.5, **level))):
        assert sf.stability(same).safe_speed is None
    posture = sf.Posture.box(0.3, 0.5, **level)
    wide, narrow = sf.stability(posture, width=1e-3), sf.stability(posture)
    assert wide.safe_speed < narrow.safe_speed
    assert "comes back from every slower kick" in str(narrow)
