"""Order of the error of the local model: gaps ∝ s² and rates ∝ s, relative errors of times ∝ s² [docs/theory.md, two models].

Both models start in the same state. The local one is invariant under this scaling; it is still run for each s, and its times
must be s times as long up to rounding. The error is the difference from the full model, without a third method: the order of
both would have to be wrong in the same way.
"""

import os
from collections import Counter

import numpy as np
import pytest
import standfast as sf
from bodies import jacobian

G = 9.81
#: Number of postures for each way to run.
POSTURES = int(os.environ.get("STANDFAST_POSTURES", "80"))
#: Powers of two: the local model is scaled without rounding.
SCALES = 2.0 ** np.arange(-14.0, -4.0)
#: More than two decades.
OCTAVES = 7
#: Smaller relative errors may be those of sums and accumulations, some of which have errors of a few 1e-12.
ROUNDING = 2e-10
#: Allowed error of the order in s.
ALLOWED = 0.02
#: Parts of a run's time: shorter phases belong to accumulations, of which more or fewer impacts are recorded.
BRIEF = 1e-3
#: Parts of the largest speed: slower impacts are not compared.
SLOW = 1e-9


def posture_and_state(seed, friction):
    """Two feet with c_i ≠ 0, and a state whose gaps are positive: N q > 0."""
    rng = np.random.default_rng([4, seed])
    u = rng.uniform
    while True:
        contacts = [
            sf.Contact(
                point=(side * u(0.3, 1.0), u(-0.1, 0.1)),
                slope=side * u(-0.1, 0.4),
                friction=friction * u(0.6, 1.5),
            )
            for side in (-1, 1)
        ]
        posture = sf.Posture(
            mass=1.0,
            gyration_radius=u(0.2, 0.7),
            center_of_mass=(u(-0.2, 0.2), u(0.2, 0.8)),
            contacts=contacts,
            restitution=u(0.0, 0.5),
            gravity=G,
        )
        if abs(jacobian(posture)[1][:, 2]).min() > 0.05:
            break
    rows = jacobian(posture)[0]
    q = np.linalg.pinv(rows) @ u(0.05, 0.5, 2)
    # along the direction in which no gap changes
    q += u(-0.3, 0.3) * np.linalg.svd(rows)[2][2]
    return posture, q, u(-1.0, 1.0, 3)


def course(run):
    """The sequence that must be the same in all runs: phases before the last Zeno point and after it, and the contacts hit up
    to each Zeno point, as far as they are not summed."""
    last = run.zeno_points[-1].time
    long = [p for p in run.phases if p.end - p.start > BRIEF * run.elapsed]
    before = [p.mode for p in long if p.end < last * (1 - BRIEF)]
    after = [p.mode for p in long if p.start >= last * (1 - 1e-9)]
    speeds = np.abs(run.impacts["rates_before"]).max(axis=1)
    fast = speeds > SLOW * speeds.max()
    hits, first = [], 0
    for zeno in run.zeno_points:
        piece = slice(first, zeno.first_summed)
        hits.append(run.impacts["contact"][piece][fast[piece]].tolist())
        first = zeno.first_summed
        if last - zeno.time < SLOW * run.elapsed:
            break
    return before, after, hits


def alike(one, other):
    """Whether phases and impacts are the same, as far as both runs have them."""
    return one[:2] == other[:2] and all(
        a == b
        for hits, others in zip(one[2], other[2], strict=False)
        for a, b in zip(hits, others, strict=False)
    )


def same_state(_posture, q, qdot):
    return q, qdot


def same_gaps(posture, q, qdot):
    """The state of the full model, at the same rotation and spin, that has the gaps and rates of the local one."""
    rows, q = jacobian(posture)[0], q.copy()
    gaps, rates = rows @ q, rows @ qdot
    for _ in range(3):
        now = posture.gaps(q)
        q[:2] += np.linalg.solve(rows[:, :2], gaps - now)
    rest = rates - posture.gap_rates(q, [0.0, 0.0, qdot[2]])
    return q, [*np.linalg.solve(rows[:, :2], rest), qdot[2]]


def errors(
    posture,
    q,
    qdot,
    state=same_state,
    scales=SCALES,
    octaves=OCTAVES,
    rounding=ROUNDING,
    **options,
):
    """Scales and relative errors of the local model's time, or the reason why there are too few. The scales increase until
    enough errors are above rounding."""
    found, first, unit = [], None, None
    for s in scales:
        start = q * s * s, qdot * s
        local, full = (
            sf.simulate(
                posture,
                *begin,
                model=model,
                time_limit=20 * s,
                event_limit=20_000,
                **options,
            )
            for model, begin in (("local", start), ("full", state(posture, *start)))
        )
        if {local.outcome, full.outcome} != {options["stop"]}:
            return f"{local.outcome}, {full.outcome}"
        first = first or course(local)
        if not (alike(course(local), first) and alike(course(full), first)):
            return "other events"
        unit = unit or local.elapsed / s
        assert local.elapsed / s == pytest.approx(unit, rel=4e-16)
        error = abs(local.elapsed - full.elapsed) / full.elapsed
        if error > rounding:
            found.append((s, error))
        if len(found) == octaves + 1:
            return np.array(found)
    return "too exact"


def order(found, step):
    """p of C sᵖ (1 + d s^step), by least squares in the logarithm: the next term has the order p + step."""
    s, error = found.T
    terms = np.transpose([np.ones_like(s), np.log(s), s**step])
    return np.linalg.lstsq(terms, np.log(error), rcond=None)[0][1]


WAYS = {
    "smooth, Zeno": (0.0, {"stop": "zeno"}),
    "smooth impacts, rest": (0.9, {"stop": "rest"}),
    "Chatterjee-Ruina, Zeno": (
        0.5,
        {"stop": "zeno", "impact": "chatterjee-ruina"},
    ),
    "Stronge, Zeno": (0.5, {"stop": "zeno", "impact": "stronge"}),
    "Poisson, rest": (0.9, {"stop": "rest", "impact": "poisson"}),
}


def check(way, orders, skipped, expected):
    """Prints the counts and asserts the order."""
    print(f"\n{way}: skipped {dict(skipped)}")
    worst = max(orders, key=lambda seed: abs(orders[seed] - expected))
    print(f"{len(orders)} of order {expected}, worst {orders[worst]:.5f}")
    assert len(orders) >= 20
    assert abs(orders[worst] - expected) <= ALLOWED, worst


@pytest.mark.parametrize("way", WAYS)
def test_errors_of_times_are_of_second_order(way):
    """-s prints the number of skipped postures, and the largest deviation from 2."""
    friction, options = WAYS[way]
    if "impact" in options:
        options = options | {"simultaneous": "first-contact-first"}
    skipped, orders = Counter(), {}
    for seed in range(POSTURES):
        found = errors(*posture_and_state(seed, friction), **options)
        if isinstance(found, str):
            skipped[found] += 1
        else:
            orders[seed] = order(found, 2)
    check(way, orders, skipped, 2)


def test_nor_does_it_matter_what_is_the_same_at_the_start():
    """The full model starts with the gaps and rates of the local model instead of with its q and q̇. The order is
    the same."""
    skipped, orders = Counter(), {}
    for seed in range(POSTURES):
        start = posture_and_state(seed, 0.0)
        found = errors(*start, state=same_gaps, stop="zeno")
        if isinstance(found, str):
            skipped[found] += 1
        else:
            orders[seed] = order(found, 2)
    check("same gaps", orders, skipped, 2)


@pytest.mark.parametrize("stop", ["zeno", "rest"])
def test_errors_are_of_fourth_order_for_a_rod(stop):
    """c_i = 0: the gaps are y ± L sin θ, there is no centrifugal acceleration at θ = 0, and ψ is even in θ. The
    scales cover one decade. With two decades, errors at one end would be too large for the asymptotic order, or
    errors at the other end would be rounding errors."""
    skipped, orders = Counter(), {}
    for seed in range(POSTURES):
        u = np.random.default_rng([5, seed]).uniform
        rod = sf.Posture.rod(
            half_length=u(0.3, 1.0), gyration_radius=u(0.15, 0.5), restitution=u(0, 0.5)
        )
        tilt = u(-0.5, 0.5)
        q = np.array([0.0, abs(tilt) + u(0.05, 0.5), tilt])
        qdot = np.array([0.0, *u(-1.0, 1.0, 2)])
        found = errors(
            rod,
            q,
            qdot,
            scales=2.0 ** np.arange(-10.0, -1.0),
            octaves=4,
            rounding=1e-12,
            stop=stop,
        )
        if isinstance(found, str):
            skipped[found] += 1
        else:
            orders[seed] = order(found, 4)
    check(f"rod, {stop}", orders, skipped, 4)


def enlarged(posture, run, rows, left):
    """Time of the last Zeno point by a separate run from a flight that long before it, enlarged by a power of two. Of summed
    parts only the time counts as flight: in the middle of it a contact may rest."""
    inverse, end = np.linalg.pinv(rows), run.zeno_points[-1].time
    flights = [p for p in run.phases if p.mode == "SS" and p.end < end * (1 - 1e-12)]
    flight = [p for p in flights if p.start < end - left][-1]
    t = (flight.start + flight.end) / 2
    gaps, rates = run.gaps_at(t), run.gap_rates_at(t)
    _, qdot = run.at(t)
    qdot = qdot + inverse @ (rates - rows @ qdot)
    scale = 2.0 ** -np.round(np.log2(end - t))
    tail = sf.simulate(posture, inverse @ gaps * scale**2, qdot * scale, model="local")
    return t + tail.zeno_points[-1].time / scale


def test_the_end_of_ever_smaller_rounds_is_as_exact_as_it_says():
    """The local model has no scale: parts of the end, enlarged, end at the same time, with much smaller errors."""
    wrong, compared = {}, 0
    # In posture 200 the ratio of the landing speeds repeats before that of the durations does.
    for seed in {*range(POSTURES), 200}:
        posture, q, qdot = posture_and_state(seed, 0.9)
        run = sf.simulate(posture, q, qdot, model="local", time_limit=20.0)
        if run.outcome != "rest" or run.zeno_points[-1].method != "nested":
            continue
        end, rows = run.zeno_points[-1], jacobian(posture)[0]
        if run.phases[0].end > end.time - 1e-2:
            continue
        times = [enlarged(posture, run, rows, left) for left in (1e-2, 1e-3, 1e-4)]
        if np.ptp(times) > 5e-14 * end.time:
            continue
        compared += 1
        error = abs(end.time - times[-1])
        if error > 10 * end.time_error + 1e-13 * end.time:
            wrong[seed] = (error / end.time, end.time_error / end.time)
    print(f"\n{compared} compared; seed: (relative error, said): {wrong}")
    assert compared > POSTURES / 4
    assert not wrong
