"""Frictionless flights that end although λ > 0 fails: contact j with λ_j < 0 drifts away from its ground.

STANDFAST_DRIFT sets the number of random flights and postures (300)."""

import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import jacobian, paper_vee

CASES = int(os.environ.get("STANDFAST_DRIFT", "300"))
KICKS = 60


def weights(posture):
    """λ = (N M⁻¹ Nᵀ)⁻¹ g, from the rows N = (n, b)."""
    rows, _ = jacobian(posture)
    matrix = rows @ np.diag([1, 1, posture.gyration_radius**-2]) @ rows.T
    return np.linalg.solve(matrix, posture.gravity * rows[:, 1])


def test_a_place_in_the_v_that_the_energy_leaves_open():
    posture = paper_vee(0.8, 1.5)
    assert weights(posture) == pytest.approx([-1.291105722, 8.030511303], abs=1e-8)
    verdict = sf.stability(posture)
    assert (verdict.energy, verdict.flight) == (False, "drift")
    assert repr(verdict) == "<Verdict: stable by corner-map>"
    assert "end by drift" in str(verdict)
    assert sf.stability(paper_vee(0, 0.2)).flight == "energy"


def last_hits(g, psi, e, gaps, rates):
    """Time of the last impact of contact 2 until the first Zeno point, and the kind of that."""
    model = sf.LocalModel(g, psi, (0.0, 0.0), (e, e))
    run = model.simulate(gaps, rates, stop="zeno", event_limit=100_000)
    hits = run.impacts["elapsed"][run.impacts["contact"] == 2]
    return max(hits, default=0.0), run


def test_a_contact_that_drifts_away_is_not_hit_after_a_known_time():
    rng, ends = np.random.default_rng(5), set()
    worst = 0.0
    for _ in range(CASES):
        psi = -rng.uniform(0.01, 1.5, 2)
        psi *= math.sqrt(min(1.0, rng.uniform(0.1, 0.99999) / (psi[0] * psi[1])))
        g_1 = math.exp(rng.uniform(-3, 3))
        kappa = g_1 * 10.0 ** rng.uniform(-4, 0.5)
        g = (g_1, -psi[0] * g_1 - kappa)  # κ = −(g_2 + ψ_1 g_1) > 0
        gaps = rng.choice([0.0, 1.0], 2) * rng.exponential(size=2)
        rates = rng.normal(size=2)
        late, run = last_hits(g, psi, rng.choice([0, 0.1, 0.7]), gaps, rates)
        s, y = rates[1] + psi[0] * rates[0], gaps[1] + psi[0] * gaps[0]
        down, below = max(0.0, -s), max(0.0, -y)
        most = (down + math.sqrt(down**2 + 2 * kappa * below)) / kappa
        assert late <= most * (1 + 1e-9)
        worst = max(worst, late / most if most else 0.0)
        assert run.outcome == "zeno"
        point = run.zeno_points[0]
        assert point.kind == "1-zeno"
        assert point.contact == 1 or point.elapsed <= most * (1 + 1e-9)
        ends.add(point.contact)
    print("last hit over the bound:", worst)
    assert ends == {1, 2}
    assert 0.3 < worst <= 1


def test_postures_that_are_stable_by_drift_return_after_every_kick():
    rng, checked = np.random.default_rng(8), 0
    while checked < CASES // 10:
        posture = paper_vee(
            rng.uniform(-0.95, 0.95),
            rng.uniform(0, 3),
            rng.uniform(0.3, 0.8),
            rng.choice([0, 0.1, 0.4]),
        )
        verdict = sf.stability(posture)
        if verdict.flight != "drift" or verdict.frictional_stability != "stable":
            continue
        checked += 1
        assert min(weights(posture)) < 0
        velocities = rng.normal(size=(KICKS, 3)) * 10.0 ** rng.uniform(
            -4, -2, (KICKS, 1)
        )
        runs = sf.simulate_many(
            posture, np.zeros((KICKS, 3)), velocities, model="local", impact="newton"
        )
        assert (runs.outcome == "rest").all(), posture
