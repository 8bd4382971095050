"""Sums of the bounces of one of three contacts of a mechanism, beside its impacts one by one with forty digits."""

import mpmath
import numpy as np
import pytest
import standfast as sf

DIGITS = 40
# Beyond, rounding errors of the run decide which contact is hit next.
LONGEST = 40
# Impacts followed one by one; so many have multiplied the landing speed by less than 1e-20.
MOST = 400


def draw(rng):
    """Three frictionless contacts that all load presses down, and a start above the ground."""
    while True:
        rows = rng.normal(size=(3, 3))
        if abs(np.linalg.det(rows)) > 0.3:
            break
    contacts = [sf.ContactRows(row, rng.normal(size=3)) for row in rows]
    load = np.linalg.solve(rows, -rng.uniform(0.5, 2, 3))
    mechanism = sf.Mechanism(
        np.eye(3), load, contacts, restitution=rng.uniform(0.2, 0.7)
    )
    gaps = rng.uniform(0.01, [0.2, 1, 1])
    q, qdot = np.linalg.solve(rows, gaps), np.linalg.solve(rows, rng.normal(size=3))
    return mechanism, rows, q, qdot


class OneByOne:
    """Gaps and rates from impact to impact: h'' = N a, and u⁺ = u + W_i (1 + e)|u_i|/W_ii, W = N Nᵀ."""

    def __init__(self, mechanism, rows, q, qdot):
        rows, load, q, qdot = (
            mpmath.matrix(x.tolist()) for x in (rows, mechanism.load, q, qdot)
        )
        self.e, self.w = mpmath.mpf(mechanism.restitution), rows * rows.T
        self.t, self.h, self.u, self.a = (
            mpmath.mpf(0),
            rows * q,
            rows * qdot,
            rows * load,
        )

    def fly(self, t):
        self.h += self.u * t + self.a * t**2 / 2
        self.u += self.a * t
        self.t += t

    def landing(self, i):
        return (
            self.u[i] + mpmath.sqrt(self.u[i] ** 2 - 2 * self.a[i] * self.h[i])
        ) / -self.a[i]

    def hit(self):
        """The next impact; returns its contact."""
        i = min(range(3), key=self.landing)
        self.fly(self.landing(i))
        self.h[i] = mpmath.mpf(0)
        self.u += self.w[:, i] * (-(1 + self.e) * self.u[i] / self.w[i, i])
        return i


def test_bounces_are_summed_as_soon_as_no_other_contact_lands():
    rng, late = np.random.default_rng(5), []
    with mpmath.workdps(DIGITS):
        for _ in range(150):
            mechanism, rows, q, qdot = draw(rng)
            run = sf.simulate(
                mechanism, q, qdot, stop="zeno", impact="newton", event_limit=MOST
            )
            one = run.outcome == "zeno" and run.zeno_points[0].kind == "1-zeno"
            if not one or run.collisions > LONGEST:
                continue
            (zeno,) = run.zeno_points
            i, motion = zeno.contacts[0] - 1, OneByOne(mechanism, rows, q, qdot)
            hits = [motion.hit() for _ in range(run.collisions)]
            assert hits == list(run.impacts["contact"] - 1)
            last = max((k + 1 for k, hit in enumerate(hits) if hit != i), default=0)
            while motion.t < zeno.time * (1 - 1e-14) and len(hits) < MOST:
                hits.append(motion.hit())
            assert set(hits[run.collisions :]) <= {i}
            assert float(motion.t) == pytest.approx(zeno.time, rel=1e-13)
            for values, limit in ((zeno.gaps, motion.h), (zeno.gap_rates, motion.u)):
                assert values == pytest.approx([float(x) for x in limit], abs=1e-12)
            # The first attempt is after the second impact in succession.
            late.append(run.collisions - last - 2)
    assert len(late) > 60
    assert max(late) <= 1
    assert np.mean(late) < 0.1
