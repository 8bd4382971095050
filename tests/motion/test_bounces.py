"""Sums of the bounces of one contact, compared with the same bounces one by one.

A sum is taken only if it ends before the time limit. So a second run whose limit is just before the sum has the same bits up to the last
bounce that the first run wrote down, and follows all the others one by one. STANDFAST_BOUNCES sets the number of random scenes for each law
(40).
"""

import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import LAWS, draw_order, draw_rough, lift, size

SCENES = int(os.environ.get("STANDFAST_BOUNCES", "40"))
#: Time from the end of the second run to the sum, in units in the last place.
BEFORE = 4
#: Sums of one run that are looked at.
MOST = 6
#: Relative to the size of the body and to the largest speed, from the start on.
TOLERANCE = 1e-12
#: Rounding of a place far from the origin, or of an angle of many turns. Unit: ε times the coordinate. 13 were seen after 100 turns.
FAR = 32
#: Gap below which rounding errors of the place decide whether a contact lands before the limit. Unit: ε times distance and size. 61 were seen.
TIE = 64


def draw(rng, law):
    """A body of about a metre on one to six contacts, and its start up to a metre above the ground."""
    level = rng.random() < 0.5
    rise, steep = (0, 0) if level else (0.3, 0.5)
    contacts = draw_rough(rng, rng.integers(1, 7), rise, steep)
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=math.exp(rng.uniform(math.log(0.1), math.log(1.5))),
        center_of_mass=(rng.uniform(-0.5, 0.5), rng.uniform(0.2, 1.0)),
        contacts=contacts,
        restitution=rng.uniform(0.02, 0.9),
        gravity=9.81,
    )
    model = "full" if rng.random() < 0.6 else "local"
    q = np.array([0.0, 0.0, rng.uniform(-0.1, 0.1)])
    q[1] = lift(posture, q, model) + 10 ** rng.uniform(-5, 0)
    qdot = rng.normal(size=3) * (0.5, 0.5, 10 ** rng.uniform(-2, 1))
    options = {
        "model": model,
        "impact": law,
        "simultaneous": draw_order(rng, law),
        "time_limit": 10.0,
        "event_limit": 20_000,
    }
    return posture, q, qdot, options


@pytest.mark.parametrize("law", LAWS)
def test_sums_equal_the_bounces_one_by_one(law):
    found, ties, missed = 0, 0, []
    for seed in range(SCENES):
        posture, q, qdot, options = draw(np.random.default_rng([46, seed]), law)
        run = sf.simulate(posture, q, qdot, **options)
        reach = size(posture)
        scale = np.array([1, 1, reach])
        fastest = max(math.sqrt(2 * posture.gravity * abs(q[1])), np.abs(qdot * scale).max())  # fmt: skip
        for k, point in list(enumerate(run.zeno_points))[:MOST]:
            if point.method != "bounce" or point.elapsed == 0:
                continue
            stop = point.elapsed - BEFORE * np.spacing(point.elapsed)
            one = sf.simulate(posture, q, qdot, **(options | {"time_limit": stop}))
            if len(one.impacts) < point.first_summed + 3:
                continue  # too few bounces were left out
            hit = set(one.impacts["index"][point.first_summed :].tolist())
            others = [i for i in hit if i + 1 not in point.contacts]
            if others:  # one by one, another contact is hit before the limit
                known = np.finfo(float).eps * (math.hypot(*point.q[:2]) + reach)
                assert max(point.gaps[i] for i in others) <= TIE * known, seed
                ties += 1
                continue
            # Had the sum ended too early, the contact would still bounce, and the speeds would differ; had it ended too late, the
            # second run would have come to the end before.
            for end in one.zeno_points[k:]:
                early = point.elapsed - end.elapsed
                known = point.time_error + end.time_error
                if early > known + BEFORE * np.spacing(point.elapsed):
                    missed.append((seed, k, "time", early - known))
            found += 1
            fastest = max(fastest, np.abs(point.qdot * scale).max())
            known = np.finfo(float).eps * np.abs(point.q)
            beyond = np.maximum(np.abs(one.q - point.q) - FAR * known, 0)
            error = {
                "place": (beyond * scale).max() / reach,
                "speed": np.abs((one.qdot - point.qdot) * scale).max() / fastest,
            }
            # Bounces that are followed have rounding errors of their own, which grow like a change of the start.
            grown = np.finfo(float).eps * one.sensitivity
            missed += [
                (seed, k, *e) for e in error.items() if e[1] > max(TOLERANCE, grown)
            ]
    assert not missed, (len(missed), found, ties, missed)
    assert found > SCENES / 2
    assert ties <= 1 + found / 500


def nested(rng):
    """A body on two feet of parallel ground without friction whose accumulations of one contact accumulate, and its start."""
    slope = rng.uniform(-0.4, 0.4) if rng.random() < 0.5 else 0.0
    t = np.array([math.cos(slope), math.sin(slope)])
    place = rng.uniform(-0.2, 0.2)
    # Near ρ² = −b_1 b_2/3 most of the velocity goes over from one contact to the other in an impact.
    rho = math.sqrt((0.5 - place) * (0.5 + place) / 3) * rng.uniform(0.97, 1.03)
    center = t * place + np.array([-t[1], t[0]]) * rng.uniform(0.05, 0.6)
    feet = [sf.Contact(tuple(side * 0.5 * t), slope=slope) for side in (-1, 1)]
    posture = sf.Posture(1.0, rho, tuple(center), feet, rng.uniform(0.85, 0.98), 9.81)
    q = np.array([0.0, 0.0, rng.uniform(-0.05, 0.05)])
    q[1] = lift(posture, q) + rng.uniform(0.001, 0.05)
    return posture, q, np.array([rng.normal(), 0, 0])


def test_accumulations_of_accumulations_equal_their_cycles_one_by_one():
    """The same for cycles, each with accumulations in it, that do not repeat themselves because the body turns."""
    found, turned = 0, 0.0
    for seed in range(SCENES):
        posture, q, qdot = nested(np.random.default_rng([4650, seed]))
        run = sf.simulate(posture, q, qdot, model="full", event_limit=200_000)
        last = run.zeno_points[-1] if run.zeno_points else None
        if last is None or last.method != "nested":
            continue
        stop = last.elapsed - BEFORE * np.spacing(last.elapsed)
        options = {"model": "full", "event_limit": 2_000_000, "time_limit": stop}
        one = sf.simulate(posture, q, qdot, **options)
        if len(one.impacts) < last.first_summed + 100:
            continue
        before = one.impacts["elapsed"][: last.first_summed]
        assert np.array_equal(run.impacts["elapsed"], before), seed
        found += 1
        summed = one.impacts["elapsed"][last.first_summed :]
        turned = max(turned, float(np.abs(one.at(summed)[0][:, 2]).max()))
        for end in one.zeno_points[len(run.zeno_points) - 1 :]:
            assert end.elapsed <= last.elapsed + end.time_error
        drift = max(1.0, float(np.abs(last.q).max()))
        assert np.abs(one.q - last.q).max() <= TOLERANCE * drift, seed
        fastest = max(math.sqrt(2 * 9.81 * q[1]), np.abs(last.qdot).max())
        assert np.abs(one.qdot - last.qdot).max() <= TOLERANCE * fastest, seed
    assert found > SCENES / 5
    assert turned > 1e-3
