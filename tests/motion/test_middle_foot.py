"""Feet between others on one straight line of the body: they do not land while an outer one is in the air.

The gap of a middle foot is a weighted mean of those of the outer ones. So the motion up to the first accumulation is that of the body
without it.
"""

import os

import numpy as np
import pytest
import standfast as sf
from mpmath import mp, mpf

SCENES = int(os.environ.get("STANDFAST_MIDDLE_FEET", "60"))
#: Digits of the oracle: gaps shrink to 1e-160 m while rates shrink to 1e-40 m/s.
DIGITS = 250
#: Change of the height at the start, in m, that is rounding error: what it changes is not known.
SHIFT = 1e-15
#: Rate in m/s at which the oracle stops. The time left is then about this rate divided by g.
SLOWEST = mpf(10) ** -30


def clatter(feet, center, rho, e, q, v):
    """The time at which two frictionless feet on level ground end their impacts, with finite rotation; event by event. s"""
    with mp.workdps(DIGITS):
        arms = [(mpf(x) - mpf(center[0]), -mpf(center[1])) for x in feet]
        g, rho, e = mpf(9.81), mpf(rho), mpf(e)
        y, theta, vy, omega = mpf(center[1]) + mpf(q[1]), mpf(q[2]), mpf(v[1]), mpf(v[2])  # fmt: skip

        def lever(i, t):
            a, (x, z) = theta + omega * t, arms[i]
            return mp.cos(a) * x - mp.sin(a) * z

        def height(i, t):
            a, (x, z) = theta + omega * t, arms[i]
            return y + vy * t - g * t**2 / 2 + mp.sin(a) * x + mp.cos(a) * z

        def rate(i, t):
            return vy - g * t + omega * lever(i, t)

        def touchdown(i):
            h, u, (x, z) = height(i, 0), rate(i, 0), arms[i]
            fall = g + omega**2 * (mp.sin(theta) * x + mp.cos(theta) * z)
            t = (u + mp.sqrt(u**2 + 2 * fall * h)) / fall
            for _ in range(14):
                t -= height(i, t) / rate(i, t)
            return t

        time, u = mpf(0), mpf(-1)
        while abs(u) > SLOWEST:
            t, i = min((touchdown(i), i) for i in (0, 1))
            y, theta, vy, time = y + vy * t - g * t**2 / 2, theta + omega * t, vy - g * t, time + t  # fmt: skip
            u, b = rate(i, 0), lever(i, 0)
            push = -(1 + e) * u / (1 + (b / rho) ** 2)
            vy, omega = vy + push, omega + push * b / rho**2
            y -= height(i, 0)
        return time


def test_three_feet_end_their_impacts_as_the_outer_two():
    scene = (0, 0.98), 0.23, 0.21, (0, 0.15, 0.108), (0, -0.07, 0.27)
    center, rho, e, q, v = scene
    right = float(clatter((-0.85, 0.7), *scene))
    for feet in ((-0.85, 0.7), (-0.85, 0.15, 0.7), (-0.85, -0.4, 0.1, 0.3, 0.7)):
        contacts = [sf.Contact((x, 0)) for x in feet]
        body = sf.Posture(1, rho, center, contacts, e, ground="shared")
        run = sf.simulate(body, q, v, model="full", stop="zeno")
        (zeno,) = run.zeno_points
        assert zeno.time == pytest.approx(right, abs=1e-14)
        assert zeno.contacts == tuple(range(1, len(feet) + 1))
        assert not run.warnings


def test_middle_feet_do_not_change_the_first_accumulation():
    same = 0
    for k in range(SCENES):
        rng = np.random.default_rng([91, k])
        left, right = -rng.uniform(0.3, 1), rng.uniform(0.3, 1)
        middle = sorted(rng.uniform(left, right, rng.integers(1, 3)))
        center, rho = (rng.uniform(-0.5, 0.5), rng.uniform(0.2, 1.2)), rng.uniform(0.2, 1)  # fmt: skip
        e = rng.choice([0, 0.1, 0.21, 0.4])
        ground = rng.choice(["shared", "own", "terrain"])
        others = {"own": {}, "shared": {"ground": "shared"}, "terrain": {"terrain": [(-50, 0), (50, 0)]}}  # fmt: skip
        q = (0, rng.uniform(0.05, 0.3), rng.uniform(-0.15, 0.15))
        v = (0, rng.uniform(-0.2, 0.2), rng.uniform(-0.4, 0.4))
        shift = (0, q[1] + SHIFT, q[2])
        runs = ([left, right], q), ([left, right], shift), ([left, *middle, right], q)
        ends = []
        try:
            for feet, at in runs:
                contacts = [sf.Contact((x, 0)) for x in feet]
                body = sf.Posture(1, rho, center, contacts, e, **others[str(ground)])
                run = sf.simulate(body, at, v, model="full", time_limit=8.0)
                outer = {1: "left", len(feet): "right"}
                first = run.zeno_points[0]
                ends.append((first.time, [outer[c] for c in first.contacts if c in outer]))  # fmt: skip
        except ValueError:
            continue  # it starts in the ground
        (time, contacts), (shifted, _), (with_middle, closed) = ends
        known = 1e-13 + abs(shifted - time)
        assert with_middle == pytest.approx(time, abs=known), (k, ends)
        assert closed == contacts, (k, ends)
        same += 1
    assert same > 0.8 * SCENES


ROWS = int(os.environ.get("STANDFAST_ROWS_OF_FEET", "30"))


def sole(places, friction, restitution, height):
    return sf.Posture(
        mass=1,
        gyration_radius=0.3,
        center_of_mass=(0, height),
        contacts=[sf.Contact(point=(x, 0.0), friction=friction) for x in places],
        restitution=restitution,
    )


def test_a_row_of_many_feet_moves_as_its_outer_feet():
    """All inner feet are between the two outer ones, in impacts and in modes: the motion to rest is that on two feet. Where rounding errors
    decide whether a foot slides, the two may differ."""
    off = 0
    for k in range(ROWS):
        rng = np.random.default_rng([k, 9])
        count = int(rng.integers(9, 40))
        places = np.sort(rng.uniform(-0.6, 0.6, count))
        friction, restitution = rng.choice([0.1, 0.4, 0.9]), rng.uniform(0, 0.6)
        height = rng.uniform(0.2, 0.6)
        start = (0, rng.uniform(0.3, 0.6), rng.uniform(-0.3, 0.3))
        kick = rng.uniform(-1, 1, 3) * [0.6, 0.3, 0.6]
        one, two = (
            sf.simulate(
                sole(feet, friction, restitution, height), start, kick, time_limit=4
            )
            for feet in (places, places[[0, -1]])
        )
        known = 1e-12 + 100 * (one.time_error + two.time_error)
        same = one.outcome == two.outcome and abs(one.time - two.time) <= known
        off += not (same and np.abs(one.q - two.q).max() <= known)
        if one.outcome == "rest":
            held = set(one.phases[-1].mode)
            assert len(held) == 1
    assert off <= 0.01 * ROWS
