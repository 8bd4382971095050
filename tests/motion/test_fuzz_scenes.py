"""Random scenes of every kind: each run ends within its limits, in a possible state of a body."""

import math
import os
from collections import Counter
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import standfast as sf
from bodies import LAWS, draw_contacts, draw_order, lift
from walls import flush_box, random_scene

#: Number of random scenes.
SCENES = int(os.environ.get("STANDFAST_FUZZ_SCENES", "120"))
#: Time limit, in units of √(size/g).
TIME = 20
#: Part of the scenes whose impacts have no end in time: they grow from the rounding error of an unstable state of rest.
STUCK = 0.001
#: Collisions of one instant are counted after the last of them.
BURST = 10_000
#: A run that does not end within the first number of events is repeated with the second. `make long` uses the default of
#: `simulate` for it.
EVENTS = (1_000, int(os.environ.get("STANDFAST_FUZZ_EVENTS", "100000")))
#: A run that would not reach its time limit within these events is repeated with this number of them. Impacts that lose a millionth of
#: their speed each come down to rounding errors, by fourteen orders of magnitude, in 3e7; most begin nearer to them.
MANY_EVENTS = 30_000_000
#: Part of the scenes that need so many events.
SLOW = 0.003


def draw(rng):
    """One to five contacts on a body of any size; at rest, touching, in flight or rotating."""
    size = 10 ** rng.uniform(-3, 3)
    gravity = 9.81 * 10 ** rng.uniform(-1, 1)
    speed = math.sqrt(gravity * size)
    level = rng.random() < 0.3
    rise, steep = (0, 0) if level else (0.3, 0.9)
    contacts = draw_contacts(
        rng,
        (size * rng.uniform(-1, 1) for _ in range(rng.choice([1, 2, 2, 3, 4, 5]))),
        rise,
        steep,
        size,
        friction=lambda: rng.choice([0.0, rng.uniform(0, 1), rng.uniform(0, 3)]),
        restitution=lambda: rng.choice([None, 0.0, rng.uniform(0, 0.95)]),
        tangential_restitution=lambda: rng.choice([0.0, rng.uniform(0, 0.95)]),
    )
    posture = sf.Posture(
        mass=10 ** rng.uniform(-3, 3),
        gyration_radius=size * 10 ** rng.uniform(-1.3, 0.3),
        center_of_mass=(size * rng.uniform(-0.6, 0.6), size * rng.uniform(-0.3, 1.0)),
        contacts=contacts,
        restitution=rng.choice([0.0, rng.uniform(0, 0.95)]),
        gravity=gravity,
    )
    model = str(rng.choice(["full", "full", "local", "auto"]))
    theta = rng.choice([0.0, rng.uniform(-0.2, 0.2)])
    q = np.array([0.0, 0.0, theta if model != "local" else 0.0])
    q[1] = lift(posture, q)
    start = rng.choice(["rest", "touching", "flight", "spinning"])
    if start in ("flight", "spinning"):
        q[1] += size * 10 ** rng.uniform(-6, 0)
    turn = 10 ** rng.uniform(0, 2) if start == "spinning" else 1.0
    qdot = rng.normal(size=3) * (speed, speed, turn * speed / size)
    if start == "rest":
        qdot *= 0.0
    elif start == "touching":
        qdot *= 10 ** rng.uniform(-6, 0)
    law = str(rng.choice(LAWS))
    order = draw_order(rng, law)
    limit = rng.choice([None, TIME * speed / gravity])
    options = {
        "model": model,
        "impact": law,
        "simultaneous": order,
        "time_limit": limit,
        "record": False,
    }
    return size, posture, q, qdot, options


def draw_on_walls(rng, flush):
    """One to three contacts between walls and overhangs, or the four corners of a box flush with a wall and the floor."""
    posture, qdot = flush_box(rng) if flush else random_scene(rng)[1:3]
    law = str(rng.choice(LAWS))
    options = {
        "model": "full",
        "impact": law,
        "simultaneous": draw_order(rng, law),
        "time_limit": rng.choice([None, 4.0]),
        "record": False,
    }
    return 1.0, posture, np.zeros(3), qdot, options


def over_terrain(run):
    """Whether each contact is between the ends of the terrain and not below all of it, where a body falls that has passed an end."""
    posture = run.posture
    if posture.terrain is None:
        return np.full(len(posture.contacts), True)
    points = np.array([contact.point for contact in posture.contacts])
    x, y = (points - posture.center_of_mass).T
    cos, sin = math.cos(run.q[2]), math.sin(run.q[2])
    arms = np.array([cos * x - sin * y, sin * x + cos * y])
    x, y = arms + np.array(posture.center_of_mass)[:, None] + run.q[:2, None]
    (left, _), *_, (right, _) = posture.terrain
    lowest = min(y for _, y in posture.terrain)
    return (x > left) & (x < right) & (y > lowest)


def flaws(size, options, run):
    """Violations that no run may have."""
    found = []
    state = np.concatenate([run.q, run.qdot, run.rates, [run.time]])
    # Only beyond the end of a terrain there is no ground.
    gaps = np.isnan(run.gaps) if run.posture.terrain else ~np.isfinite(run.gaps)
    if not np.isfinite(state).all() or gaps.any():
        found.append("not finite")
    if (np.array(run.gaps) < -1e-9 * size)[over_terrain(run)].any():
        found.append("in the terrain")
    limit = options["time_limit"]
    if not 0 <= run.time <= (math.inf if limit is None else limit):
        found.append("time")
    if run.outcome == "time-limit" and run.time != limit:
        found.append("ends before its time")
    # An endless motion has no further events; a body at rest does not move.
    if run.outcome == "rest" and (
        np.abs(run.qdot).max() != 0 or max(map(abs, run.rates))
    ):
        found.append("moves at rest")
    return found


def outcome(seed):
    """Number of contacts, outcome and event limit of a scene; where this limit ends it, also what becomes of it with a time limit."""
    rng = np.random.default_rng([2026, seed])
    drawn = draw(rng) if seed % 5 < 3 else draw_on_walls(rng, flush=seed % 5 == 4)
    size, posture, q, qdot, options = drawn
    for limit in EVENTS:
        run = sf.simulate(posture, q, qdot, **options, event_limit=limit)
        assert run.collisions <= limit + BURST
        if run.outcome != "event-limit":
            rest = None
            break
    else:
        limited = options | {"time_limit": TIME * math.sqrt(size / posture.gravity)}
        again = sf.simulate(posture, q, qdot, **limited, event_limit=limit)
        rest = "endless"
        if again.outcome == "event-limit":
            again = sf.simulate(posture, q, qdot, **limited, event_limit=MANY_EVENTS)
            rest = "stuck" if again.outcome == "event-limit" else "slow"
        found = flaws(size, limited, again)
        assert not found, f"seed {seed}: {found}, {posture!r}, {q}, {qdot}, {limited}"
    found = flaws(size, options, run)
    assert not found, f"seed {seed}: {found}, {posture!r}, {q}, {qdot}, {options}"
    return len(posture.contacts), run.outcome, limit, rest


def test_every_scene_ends():
    """Nearly all end; -s prints the outcomes and the numbers of events. The others continue without end and without a
    pattern: given a time limit, they reach it. In a few, each impact is slower than the last one by so little that this takes many events."""
    outcomes, events = Counter(), Counter()
    others = {"endless": [], "slow": [], "stuck": []}
    with ProcessPoolExecutor() as workers:
        answers = workers.map(outcome, range(SCENES), chunksize=20)
        for seed, (contacts, ending, limit, rest) in enumerate(answers):
            outcomes[contacts, ending] += 1
            if rest is None:
                events[limit] += 1
            else:
                others[rest].append(seed)
    for (contacts, ending), count in sorted(outcomes.items()):
        print(f"{contacts} contact(s)  {ending:14}{count:7}")
    for limit in EVENTS:
        print(f"at most {limit:9} events  {events[limit]:7}")
    for rest, seeds in others.items():
        print(f"more, {rest:8} {len(seeds):7}: {seeds[:20]}")
    assert len(others["endless"]) <= 0.05 * outcomes.total()
    assert len(others["slow"]) <= max(1, SLOW * outcomes.total())
    assert len(others["stuck"]) <= max(1, STUCK * outcomes.total())
