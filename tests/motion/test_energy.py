"""Energy never increases between any two instants of a run, with any law of impact for which this is proved.

The scale of the energy of a run is the largest energy available to the motion: the initial energy above that of the lowest
position of the centre of mass, at least that of a start that counts as touching. Kinetic and potential energy are each
rounded to 1e-16 of it, and every event adds a few rounding errors.
"""

import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import draw_order, draw_rough, lift
from walls import flush_box, random_scene

#: Number of random runs for each law.
RUNS = int(os.environ.get("STANDFAST_ENERGY_RUNS", "250"))
#: Increase of the energy, relative to the scale of the run, that counts as rounding error: a few hundred units in the last
#: place.
ROUNDING = 1e-13
#: Height of a start that counts as touching: 1e-12 of a body of about a metre.
TOUCH = 1e-12
#: Largest number of contacts for which a law does not increase energy. Single impacts of Newton's and of Chatterjee and
#: Ruina's laws lose energy with any other closed contacts; so do Routh's processes, but with them other contacts may be
#: pressed during the impact.
LAWS = {"newton": 4, "poisson": 1, "stronge": 1, "chatterjee-ruina": 4}


def draw(rng, law):
    """A body of about a metre above terrain of any slopes, and its start."""
    g = 9.81
    level = rng.random() < 0.3
    rise, steep = (0, 0) if level else (0.3, 0.7)
    contacts = draw_rough(rng, rng.integers(1, LAWS[law] + 1), rise, steep)
    posture = sf.Posture(
        mass=math.exp(rng.uniform(-2, 2)),
        gyration_radius=math.exp(rng.uniform(math.log(0.05), math.log(1.5))),
        center_of_mass=(rng.uniform(-0.5, 0.5), rng.uniform(-0.2, 1.0)),
        contacts=contacts,
        restitution=rng.uniform(0, 0.95) if rng.random() < 0.8 else 0.0,
        gravity=g,
    )
    q = np.array([0.0, 0.0, rng.uniform(-0.1, 0.1) if rng.random() < 0.7 else 0.0])
    model = "full" if rng.random() < 0.6 else "local"
    height = 10 ** rng.uniform(-5, 0) if rng.random() < 0.9 else 0.0
    q[1] = lift(posture, q, model) + height
    spin = 10 ** rng.uniform(-2, 2) if rng.random() < 0.5 else 0.5
    qdot = rng.normal(size=3) * (0.5, 0.5, spin) * (rng.random() < 0.9)
    options = {
        "model": model,
        "impact": law,
        "simultaneous": draw_order(rng, law),
        "time_limit": 10.0,
        "event_limit": 20_000,
    }
    return posture, q, qdot, options


def draw_on_walls(rng, law, flush):
    """A body between walls and overhangs, or a box flush with a wall and the floor, and its start; `None` with too many contacts."""
    posture, qdot = flush_box(rng) if flush else random_scene(rng)[1:3]
    options = {
        "impact": law,
        "simultaneous": draw_order(rng, law),
        "time_limit": 4.0,
        "event_limit": 20_000,
    }
    if len(posture.contacts) > LAWS[law]:
        return None
    return posture, np.zeros(3), qdot, options


def rise(run):
    """Largest increase of the energy from any instant to a later one, relative to the scale of the run."""
    posture = run.posture
    events = [t for phase in run.phases for t in (phase.start, phase.end)]
    struck = run.impacts["time"]
    times = np.concatenate(
        [run.sample(300)[0], events[:600], struck[:300], struck[-50:]]
    )
    times = np.unique(np.clip(times, 0.0, run.time))
    energy = run.energy(times)
    heights = run.at(times)[0][:, 1]
    weight = posture.mass * posture.gravity
    scale = max(energy[0] - weight * heights.min(), weight * TOUCH)
    assert np.isfinite(energy).all()
    # Two rounding errors of the number itself, which is relative to the origin of heights.
    rounded = 2 * np.finfo(float).eps * np.abs(energy).max()
    rises = energy - np.minimum.accumulate(energy) - rounded
    return float(rises.max() / scale)


@pytest.mark.parametrize(
    ("law", "ground"),
    [(law, ground) for law in LAWS for ground in ("slopes", "walls")]
    + [(law, "flush") for law, count in LAWS.items() if count >= 4],
)
def test_energy_never_rises(law, ground):
    worst, outcomes = (0.0, 0), {}
    for seed in range(RUNS):
        rng = np.random.default_rng([1988, seed])
        if ground == "slopes":
            drawn = draw(rng, law)
        else:
            drawn = draw_on_walls(rng, law, ground == "flush")
        if drawn is None:
            continue
        posture, q, qdot, options = drawn
        run = sf.simulate(posture, q, qdot, **options)
        outcomes[run.outcome] = outcomes.get(run.outcome, 0) + 1
        risen = rise(run)
        worst = max(worst, (risen, seed))
        assert risen <= ROUNDING, f"seed {seed}: {posture!r}, {q}, {qdot}, {options}"
    print(f"{law}, {ground}: largest rise {worst[0]:.1e}, {outcomes}")
    assert sum(outcomes.values()) > RUNS / 5


def test_a_run_warns_if_an_impact_raises_the_energy():
    """Boxes under the default law: it may where restitution is near 1 and there is no tangential restitution."""
    warned, quiet = 0, 0
    for k in range(120):
        rng = np.random.default_rng([5, k])
        e, mu = float(rng.choice([0.3, 0.8, 0.9, 0.95])), float(rng.choice([0.2, 0.5, 1.0]))  # fmt: skip
        q, v = (0, rng.uniform(1.2, 2), rng.uniform(-1, 1)), rng.uniform(-1, 1, 3) * (3, 0, 5)  # fmt: skip
        width = rng.uniform(0.3, 2)
        box = sf.Posture.box(width, 1, friction=mu, restitution=e)
        run = sf.simulate(box, q, v, time_limit=3.0)
        times = np.unique(run.impacts["time"])
        times = times[times < run.time]
        before, after = (np.array([run.energy(t) for t in at]) for at in (np.nextafter(times, 0), times))  # fmt: skip
        gain = (after - before).max(initial=0) / run.energy(0.0)
        told = any(text.startswith("energy-gain") for text in run.warnings)
        if gain > 1e-8:
            assert told, (k, gain)
        assert gain > 1e-12 or not told, (k, gain)
        warned, quiet = warned + told, quiet + (not told)
        if e < 0.8:
            assert not told
    assert warned > 20
    assert quiet > 20


def test_equal_restitutions_raise_no_energy():
    for k in range(40):
        rng = np.random.default_rng([6, k])
        e = float(rng.choice([0.8, 0.9, 0.95]))
        feet = [sf.Contact((x, 0), friction=0.5, tangential_restitution=e) for x in (-0.7, 0.7)]  # fmt: skip
        body = sf.Posture(1, 0.6, (0, 0.6), feet, e, ground="shared")
        run = sf.simulate(body, (0, 1.2, rng.uniform(-0.5, 0.5)), rng.uniform(-1, 1, 3) * (3, 0, 5), time_limit=2.0)  # fmt: skip
        assert run.impact == "moreau"
        assert not any(text.startswith("energy-gain") for text in run.warnings)
