"""Small kicks of postures: stable ones come to rest at their place, an unstable one does not."""

import math
from itertools import pairwise

import numpy as np
import pytest
import standfast as sf
from bodies import jacobian, lift, odd, vee

STEEP = math.atan(8 / 15)
STABLE = {
    "20 degrees": vee(math.radians(20), 0.5, (0, 0.2), restitution=0.05),
    "slim, above its feet": vee(
        STEEP, 0.5, (0, 0.8), height=8 / 15, gyration_radius=0.4
    ),
    "wide, hanging": vee(STEEP, 0.5, (0, -0.7), height=8 / 15, gyration_radius=0.8),
}


@pytest.mark.parametrize("name", STABLE)
def test_stable_postures_come_to_rest_where_they_stood(name):
    """Kinematic-strong equilibria whose clattering converges [Or & Rimon 2008, Theorem 3]."""
    posture, rng = STABLE[name], np.random.default_rng(2008)
    for _ in range(350):
        q = 1e-3 * rng.normal(size=3)
        q[1] += max(lift(posture, q), 0.0) + 1e-6
        run = sf.simulate(posture, q, 1e-3 * rng.normal(size=3), impact="newton")
        assert run.outcome == "rest"
        assert np.abs(run.q).max() < 1e-2


def landings(run):
    """(contact that lands, r, φ) with −u = r cos φ of the landing contact, v_t = r sin φ of the sliding one."""
    found = []
    for phase in run.phases:
        if phase.mode not in ("LS", "SL"):
            continue
        held = phase.mode.index("L")
        late = phase.start + (phase.end - phase.start) * (1 - 1e-9)
        _, qdot = run.at(late)
        speed = jacobian(run.posture)[1][held] @ qdot
        rate = run.gap_rates_at(late)[1 - held]
        found.append((2 - held, math.hypot(rate, speed), math.atan2(speed, -rate)))
    return found


def test_a_posture_that_is_strong_and_yet_unstable():
    """At e = .26 corners converge to a cycle of two that grows by .744834 in ln r: contact 2 lands at φ = −1.05991; contact 1
    lands next with ln r larger by 1.391633, at φ = −1.28054, with a growth of −.646799. At e = .05 it comes to rest."""
    start = ((0, 3e-9, 0), (1e-7, 0, 2e-7))
    assert sf.contact_modes(odd(0.26)).consistent == ["FF"]
    run = sf.simulate(
        odd(0.26), *start, model="local", event_limit=1500, impact="newton"
    )
    cycle = landings(run)[-9:-1]
    for (contact, r, phi), (_, after, _) in pairwise(cycle):
        at, growth = {2: (-1.05991, 1.391633), 1: (-1.28054, -0.646799)}[contact]
        assert phi == pytest.approx(at, abs=2e-5)
        assert math.log(after / r) == pytest.approx(growth, abs=2e-6)
    assert (
        sf.simulate(odd(0.05), *start, model="local", impact="newton").outcome == "rest"
    )
