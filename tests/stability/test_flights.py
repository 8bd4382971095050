"""Frictionless flights after a corner that are long: hundreds of impacts before one contact bounces alone, or impacts that repeat for
ever, each time smaller. STANDFAST_FLIGHTS sets the number of postures (20)."""

import os

import numpy as np
import pytest
import standfast as sf
from bodies import paper_vee

POSTURES = int(os.environ.get("STANDFAST_FLIGHTS", "20"))
KICKS = 20


def test_a_self_similar_flight_is_followed_to_its_end():
    """From the corner at contact 2 the impacts of the two contacts alternate for ever; from that at contact 1, contact 1 soon bounces alone."""
    posture = paper_vee(-0.9537479270315091, -0.055276381909547756)
    verdict = sf.stability(posture)
    assert (verdict.frictional_stability, verdict.by) == ("stable", "corner-map")


# Intervals of 53 bits alone leave 46, 19 and 67 % of these flights open.
@pytest.mark.parametrize(
    ("rho", "e", "share"), [(0.4, 0.5, 0.1), (0.8, 0.5, 0.1), (0.8, 0.8, 0.5)]
)
def test_kicks_do_not_contradict_verdicts_from_long_flights(rho, e, share):
    rng = np.random.default_rng([int(10 * rho), int(10 * e)])
    reasons = []
    for k in range(POSTURES):
        posture = paper_vee(
            rng.uniform(-0.9, 0.9),
            rng.uniform(-0.9, 0.9),
            gyration_radius=rho,
            restitution=e,
        )
        verdict = sf.stability(posture, trials=KICKS, seed=k)
        reasons.append(verdict.reason)
        if verdict.frictional_stability == "stable":
            assert verdict.trials["rest"] == KICKS, (posture, verdict.trials)
    assert reasons.count("flight") <= share * POSTURES
