"""Sums of rocking, compared with the same laps followed event by event.

A sum is taken only if it ends before the time limit. So a second run whose limit is just before the limit of the sum has the same bits up to
the landing at which the sum begins, and follows everything after it. STANDFAST_ROCKING sets the number of random scenes for each law (40).
"""

import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import LAWS, draw_order, lift, size

SCENES = int(os.environ.get("STANDFAST_ROCKING", "40"))
#: Time from the end of the second run to the sum, in units in the last place.
BEFORE = 4
#: Relative to the size of the body and to the largest speed.
TOLERANCE = 1e-12
#: The difference of the times of rest is within this many times the errors that the two runs state, or 1e-12 of the time.
STATED = 10
#: Of so many sums one may differ by more, but by no more than FAR: its laps have hundreds of impacts each, and the second run has the rounding
#: errors of all of them.
ONE_OF, FAR = 200, 1e-11


def draw(rng, law):
    """A body on two to eight feet of level or sloping ground, thrown so that it rocks."""
    slope = rng.uniform(-0.3, 0.3) if rng.random() < 0.4 else 0.0
    t, n = np.array(
        [[math.cos(slope), math.sin(slope)], [-math.sin(slope), math.cos(slope)]]
    )
    half, high = rng.uniform(0.2, 0.6), rng.uniform(0.2, 1.5)
    kind = rng.choice(["two", "inner", "box", "round"])
    if kind == "two":
        feet = [(-half, 0.0), (half * rng.uniform(0.6, 1.0), 0.0)]
    elif kind == "inner":
        feet = [
            (x, 0.0)
            for x in (-half, *rng.uniform(-half, half, rng.integers(1, 3)), half)
        ]
    elif kind == "box":
        feet = [(-half, 0.0), (half, 0.0), (half, 2 * high), (-half, 2 * high)]
    else:
        count = rng.integers(5, 9)
        angles = 2 * math.pi * (np.arange(count) + 0.5) / count - math.pi / 2
        r = half / math.sin(math.pi / count)
        high = r * math.cos(math.pi / count)
        feet = [(r * math.cos(a), high + r * math.sin(a)) for a in angles]
    center = t * rng.uniform(-0.3, 0.3) * half * (kind != "round") + n * high
    contacts = [
        sf.Contact(
            tuple(x * t + y * n),
            slope=slope,
            friction=0.0 if rng.random() < 0.2 else rng.uniform(0.05, 1.5),
        )
        for x, y in feet
    ]
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=high * rng.uniform(0.3, 1.0),
        center_of_mass=tuple(center),
        contacts=contacts,
        restitution=0.0 if rng.random() < 0.4 else rng.uniform(0.02, 0.8),
        gravity=9.81,
        ground="shared",
    )
    q = np.array([0.0, 0.0, rng.uniform(-0.15, 0.15)])
    q[1] = lift(posture, q) + (0.0 if rng.random() < 0.5 else 10 ** rng.uniform(-4, -1))
    qdot = rng.normal(size=3) * (0.2, 0.1, 10 ** rng.uniform(-2, 0))
    return (
        posture,
        q,
        qdot,
        {
            "model": "full",
            "impact": law,
            "simultaneous": draw_order(rng, law),
            "time_limit": 30.0,
            "event_limit": 100_000,
        },
    )


def sums(run):
    """The ends of nested sums in the run."""
    return [z for z in run.zeno_points if z.method == "nested"]


@pytest.mark.parametrize("law", LAWS)
def test_sums_equal_the_laps_one_by_one(law):
    found, ended, missed = 0, 0, []
    for seed in range(SCENES):
        posture, q, qdot, options = draw(np.random.default_rng([66, seed]), law)
        run = sf.simulate(posture, q, qdot, **options)
        scale = np.array([1, 1, size(posture)])
        for point in sums(run)[:2]:
            stop = point.elapsed - BEFORE * np.spacing(point.elapsed)
            one = sf.simulate(posture, q, qdot, **(options | {"time_limit": stop}))
            if len(one.impacts) < point.first_summed + 6:
                continue
            # Accumulations that end a few units in the last place before the sum are not summed in the second run.
            begin = run.impacts["elapsed"][: point.first_summed]
            begin = begin[begin < stop - TOLERANCE]
            assert np.array_equal(one.impacts["elapsed"][: len(begin)], begin), seed
            found += 1
            if one.outcome in ("ambiguous", "inconsistent", "event-limit"):
                ended += 1  # rounding errors decide what is left of the motion
                continue
            early = point.elapsed - one.elapsed
            known = max(
                TOLERANCE * max(1, point.elapsed),
                STATED * (run.time_error + one.time_error),
            )
            fastest = max(1.0, np.abs(qdot * scale).max())
            errors = {
                "time": early / known,
                "place": (np.abs(one.q - point.q) * scale).max()
                / size(posture)
                / TOLERANCE,
                "speed": (np.abs(one.qdot - point.qdot) * scale).max()
                / max(TOLERANCE * fastest, posture.gravity * known),
            }
            missed += [(seed, *error) for error in errors.items() if error[1] > 1]
    print(law, found, ended, missed)
    assert len(missed) <= found / ONE_OF, missed
    assert all(error <= FAR / TOLERANCE for _, _, error in missed), missed
    assert ended <= 1 + found / ONE_OF
    assert found > SCENES / 5
