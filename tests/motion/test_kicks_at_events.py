"""Kicks of zero at, just before and just after events, between walls too: the motion is that without kicks.

STANDFAST_ZERO_KICKS sets the number of kicks (600).
"""

import math
import os
from collections import Counter

import numpy as np
import pytest
import standfast as sf
import walls

KICKS = int(os.environ.get("STANDFAST_ZERO_KICKS", "600"))
#: Kicks of each motion.
PER_RUN = 12
#: Change of the state after the event, in m, m/s, rad and rad/s, that a restart in between may cause by rounding.
SAME = 1e-9
#: Time after the kick at which the motions are compared, in s. Later a motion of many impacts magnifies every rounding error.
LATER = 1e-6
#: Events that are nearer to each other are one accumulation, in s.
APART = 1e-13


#: Speed of an impact after which a contact rises by less than 1e-12 m. Rounding errors of its position decide when it lands again, and on
#: which of two pieces in a vertex: the velocity is known up to such speeds.
SLOW = 5e-6


def unknown_speed(run, event, time):
    """Of the slow impacts about an event, up to a time, m/s; zero if the last one before this time is not slow."""
    times = run.impacts["time"]
    hits = run.impacts[(times > event - LATER) & (times < time)]
    speeds = -hits["rates_before"][np.arange(len(hits)), hits["index"]]
    slow = len(speeds) and speeds[-1] < SLOW
    return 2 * speeds[speeds < SLOW].max() if slow else 0.0


def several_contacts_are_hit(run, event):
    near = np.abs(run.impacts["time"] - event) < APART
    return len(np.unique(run.impacts["contact"][near])) > 1


def event_times(run):
    times = [*run.impacts["time"], *(p.start for p in run.phases)]
    return np.unique([t for t in times if 0 < t < run.time])


def test_a_kick_of_zero_changes_nothing():
    rng = np.random.default_rng(4304)
    seen = Counter()
    while seen.total() - seen["several at once"] < KICKS:
        _, body, qdot, options = walls.random_scene(rng)
        options["event_limit"], q = 3000, (0, 0, 0)
        base = sf.simulate(body, q, qdot, **options)
        times = event_times(base)
        if not len(times):
            continue
        for _ in range(PER_RUN):
            event = float(rng.choice(times))
            near = str(rng.choice(["at", "before", "after", "a little before"]))
            time = {
                "at": event,
                "before": np.nextafter(event, 0),
                "after": np.nextafter(event, 9),
                "a little before": event - 10 ** rng.uniform(-15, -6),
            }[near]
            kick = sf.Kick(float(time), (0, 0), tuple(rng.uniform(-1, 1, 2)))
            kicked = sf.simulate(body, q, qdot, kicks=[kick], **options)
            later = times[times > event + APART]
            before_next = 0.5 * (event + later[0]) if len(later) else np.inf
            t = min(event + LATER, before_next, base.time, kicked.time)
            assert kicked.time >= min(base.time, event) - APART, (kicked, base)
            seen[near] += 1
            if min(base.time, kicked.time) < event + APART:
                assert (
                    kicked.outcome == base.outcome
                )  # at the end of the last accumulation
                continue
            if several_contacts_are_hit(base, event):
                seen["several at once"] += (
                    1  # rounding errors decide the order of their impacts
                )
                continue
            gaps, known = kicked.gaps_at(t), base.gaps_at(t)
            about = (near, event, body, q, qdot, options)
            # Beside the ends of the terrain a gap may be negative.
            assert np.all(gaps >= np.minimum(known, 0) - SAME), about
            same = SAME + unknown_speed(base, event, t)
            for one, other in zip(kicked.at(t), base.at(t), strict=True):
                np.testing.assert_allclose(
                    one, other, atol=same, rtol=0, err_msg=str(about)
                )
            np.testing.assert_array_equal(np.isfinite(gaps), np.isfinite(known))
    print(dict(seen))
    assert seen["several at once"] < 0.2 * KICKS


def test_a_kick_at_the_recorded_time_of_an_impact_acts_after_it():
    """A ball on a floor: after the impact its speed is e times that before; the kick adds to it."""
    ball = sf.Posture(1.0, 0.1, (0, 0), [sf.Contact((0, 0))], 0.5)
    drop = sf.simulate(ball, (0, 1, 0), (0, 0, 0))
    for time in drop.impacts["time"][:5]:
        up = drop.at(np.nextafter(time, 9))[1][1]
        run = sf.simulate(ball, (0, 1, 0), (0, 0, 0), kicks=[sf.Kick(time, (0, 0.25))])
        assert run.at(np.nextafter(time, 9))[1][1] == pytest.approx(
            up + 0.25, abs=1e-14
        )


def test_a_kick_at_a_landing_between_walls_keeps_the_ground():
    """The floor is not next to the piece under which the contact is: its gap of -1e-16 m counted as behind it."""
    at = (-0.8132055810656555, 1.4686091033214461)
    terrain = [
        (-25.84556199348131, 0.004952326310626466),
        (1.8649493357704408, 0.0),
        (2.030356092743995, 1.3870612205340678),
        (-0.49892384951389007, 1.411634548318553),
        (-0.551015471766247, 25.84556199348131),
    ]
    contact = sf.Contact(at, friction=0.534207834839808)
    body = sf.Posture(0.3028205514992822, 0.16273116532940926, at, [contact], 0.0, terrain=terrain)  # fmt: skip
    qdot = (-1.496168447411337, -3.065210872001489, -1.5991020566862022)
    options = {"model": "full", "impact": "moreau", "time_limit": 1.9938453792268962}
    base = sf.simulate(body, (0, 0, 0), qdot, **options)
    [landing] = base.impacts["time"]
    for early in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0, -1e-15):
        kick = sf.Kick(landing - early, (0, 0))
        run = sf.simulate(body, (0, 0, 0), qdot, kicks=[kick], **options)
        assert len(run.impacts) == 1
        np.testing.assert_allclose(run.q, base.q, atol=1e-12)


def test_a_sum_of_bounces_does_not_end_after_a_kick():
    """A kick one rounding step before the end of the bounces, v/g (1 + 2e/(1 − e)) after the start. The sum must not reach beyond it: the phases
    would begin after the end of the run, and pictures and tables of it fail."""
    rng = np.random.default_rng(4)
    kicked = 0
    for _ in range(60):
        ball = sf.Posture(
            1, 0.3, (0, 0), [sf.Contact((0, 0))], rng.choice([0, 0.3, 0.5])
        )
        start = (
            (0, rng.uniform(0.6, 2), rng.uniform(-0.5, 0.5)),
            (0.3, rng.uniform(-1, 1), rng.uniform(-1, 1)),
        )
        end = sf.simulate(ball, *start).zeno_points[0].time
        for t in (math.nextafter(end, 0), end, math.nextafter(end, 9)):
            run = sf.simulate(ball, *start, kicks=[sf.Kick(t, (0.01, 0))])
            events = [x for phase in run.phases for x in (phase.start, phase.end)]
            assert max(*events, *run.impacts["time"]) <= run.time
            run.at(events)
            kicked += run.qdot[0] != 0.3
    assert kicked > 90
    run.to_xarray()
    run.plot()
