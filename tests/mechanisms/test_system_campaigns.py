"""Campaigns of random assemblies. STANDFAST_ASSEMBLIES sets the number of assemblies of each kind whose statics and accelerations are compared (5), STANDFAST_DROPPED_STACKS that
of the stacks of three blocks that are dropped (4), STANDFAST_SYSTEM_VERDICTS that of the assemblies whose verdicts are compared with runs (24), each from
STANDFAST_SYSTEM_KICKS starts (4), and STANDFAST_PLANTED that of the towers with each planted error (6)."""

import collections
import dataclasses
import os
import time

import numpy as np
import pytest
import standfast as sf
from assemblies import (
    KINDS,
    G,
    accelerations,
    breach,
    drawn,
    equations,
    extremes,
    masses,
    programme,
    pushed,
    tower,
    words,
)
from scipy.optimize import linprog

ASSEMBLIES = int(os.environ.get("STANDFAST_ASSEMBLIES", "5"))
DROPPED = int(os.environ.get("STANDFAST_DROPPED_STACKS", "4"))
VERDICTS = int(os.environ.get("STANDFAST_SYSTEM_VERDICTS", "24"))
KICKS = int(os.environ.get("STANDFAST_SYSTEM_KICKS", "4"))
PLANTED = int(os.environ.get("STANDFAST_PLANTED", "6"))
#: The seeds of a campaign are divided among so many tests.
PARTS = 4
#: Of forces, factors and accelerations, relative to the largest, or to the weights and gravity.
CLOSE = 1e-9
#: The same for `onset` with more than six contacts: of convex programmes, whose law holds to 1e-9 of the load in the mass metric, of light bodies less.
PROGRAMMES = 1e-8
#: Largest number of contacts of which `contact_modes` finds all modes.
ALL_MODES = 6
#: Largest number of contacts for two linear programmes for each force, and for one for each word.
EXTREMES, WORDS = 12, 4
#: Other starts of the solver of complementarity problems, which may end at other solutions.
COVERS = 4

#: Lifts and tilts of dropped stacks, m and rad.
DROP = 1e-3
#: A rise of energy, relative to its largest terms: rounding of their sum.
ROUNDING = 1e-13
#: Energy of stacks at rest, relative to that of the start: rounding.
REST = 1e-12
#: Time after which a stable system is at rest, s, relative to √E of the start in J: ten times what theory's random towers need at most.
PATIENCE = 2000
#: Events after which a run ends, with so many contacts: contact modes of many take long. A proof of stability does not bound them.
EVENTS, MOST_EVENTS = 100, {2: 10_000, 4: 10_000, 6: 500}
#: The same for dropped stacks, and the least share of them that rest before: nested accumulations of contacts that are hit one after the other may be slow.
DROP_EVENTS, SHARE = 200_000, 0.75
#: Times at which a run is looked at.
SAMPLES = 100


def same(found, expected, scale, close=CLOSE):
    return np.abs(found - expected).max() <= close * max(scale, np.abs(expected).max())


def check_statics(system, push, call, seen):
    """Whether forces hold the assembly, their extremes, and the load factor."""
    weight = np.abs(equations(system)[1]).max()
    held = programme(system).status == 0
    forces = sf.static_forces(system)
    assert (forces is not None) == held
    if held and len(system.contacts) <= EXTREMES:
        for found, expected in zip(forces, extremes(system), strict=True):
            bounded = np.isfinite(expected)
            assert (np.isfinite(found) == bounded).all()
            assert same(found[bounded], expected[bounded], weight)
            assert (found[~bounded] == expected[~bounded]).all()
        seen["hyperstatic" if (forces[1] - forces[0]).max() > CLOSE * weight else "isostatic"] += 1  # fmt: skip
    factor, expected = sf.load_factor(system, **call), programme(system, push)
    seen["held" if held else "not held"] += 1
    if expected.status == 2:
        assert factor is None
    elif expected.status == 3:
        assert factor.static == np.inf
        seen["no largest load"] += 1
    else:
        assert factor.static == pytest.approx(-expected.fun, rel=CLOSE, abs=CLOSE)


def check_forces(system, mode):
    """Forces are unique where the columns of the forces that the word allows are independent."""
    columns = []
    for k, (letter, contact) in enumerate(zip(mode.word, system.contacts, strict=True)):
        t, n = equations(system)[0][:, 2 * k : 2 * k + 2].T
        side = {"R": -1, "L": 1}.get(letter, 0)
        columns += {"S": [], "F": [t, n]}.get(letter, [n + side * contact.friction * t])
    unique = not columns or np.linalg.matrix_rank(columns) == len(columns)
    assert (mode.determined == "unique") == unique, (mode, mode.determined)


def check_modes(system, push, call, rng, seen):
    """Contact modes and `onset`, beside the solutions of complementarity problems."""
    mechanism = system.mechanism
    loaded = sf.Mechanism(mechanism.mass_matrix, mechanism.load + push, mechanism.contacts)  # fmt: skip
    modes = sf.contact_modes(loaded)
    found = [modes[word] for word in modes.consistent]
    covers = [None, *rng.uniform(0.1, 1, (COVERS, 4 * len(system.contacts)))]
    solved = [accelerations(system, push, cover) for cover in covers]
    solved = [a for a in solved if a is not None]
    seen["unsolved by the oracle"] += not solved
    begun = time.perf_counter()
    onset = sf.onset(system, **call)
    seen["slowest onset, ms"] = max(seen["slowest onset, ms"], int(1e3 * (time.perf_counter() - begun)))  # fmt: skip
    seen["no onset"] += onset is None
    seen["no mode"] += not found
    for mode in found:
        assert breach(system, mode, push) < CLOSE
        check_forces(system, mode)
    if onset is not None:
        assert breach(system, onset, push) < PROGRAMMES
        still = np.abs(onset.acceleration).max() < PROGRAMMES * G
        assert still == (programme(system, load=push).status == 0)
    if len(system.contacts) <= ALL_MODES:
        assert found
        for acceleration in [*solved, onset.acceleration]:
            assert any(same(mode.acceleration, acceleration, G) for mode in found)
        seen["ambiguous"] += len(found) > 1
        if len(found) > 1 or len(system.contacts) <= WORDS:
            assert modes.consistent == sorted(
                words(system, push), key=list(modes).index
            )
            seen["all words"] += 1
    else:
        # Two that obey the law and differ are two modes of an ambiguous problem.
        several = [*solved, *([] if onset is None else [onset.acceleration])]
        several += [mode.acceleration for mode in found]
        seen["ambiguous"] += any(
            not same(a, several[0], G, PROGRAMMES) for a in several
        )


@pytest.mark.parametrize("kind", KINDS)
def test_random_assemblies(kind):
    seen = collections.Counter()
    for seed in range(ASSEMBLIES):
        rng = np.random.default_rng([1, seed])
        system = drawn(rng, kind)
        push, call = pushed(system, rng)
        check_statics(system, push, call, seen)
        check_modes(system, push, call, rng, seen)
    print(kind.__name__, dict(seen))


# Stacks that are dropped, and verdicts beside runs.


def energy(system, q, qdot):
    return 0.5 * qdot @ (masses(system) * qdot) - equations(system)[1] @ q


def lifted(system, rng, size):
    """A displacement of about this size, m and rad, from which all contacts are open."""
    normals = equations(system)[0][:, 1::2].T
    k = len(normals)
    # Of the least sum of the absolute values: up by one at every contact.
    both = np.hstack([normals, -normals])
    up = linprog(np.ones(both.shape[1]), A_ub=-both, b_ub=-np.ones(k)).x
    up = up[: system.dof] - up[system.dof :]
    q = rng.normal(size=system.dof) * size
    return q + up * (max(0, -(normals @ q).min()) + rng.uniform(0, size))


@dataclasses.dataclass
class Claim:
    """What a verdict says."""

    stability: str
    by: str | None
    evidence: dict
    laws: list

    @classmethod
    def of(cls, verdict):
        return cls(verdict.frictional_stability, verdict.by, verdict.evidence, verdict.laws)  # fmt: skip


def motion(system, q, qdot, law, seen, limit, events=None):
    """A run, whose energy never rises; with its energy at the start."""
    events = events or MOST_EVENTS.get(len(system.contacts), EVENTS)
    run = sf.simulate(system, q=q, qdot=qdot, impact=law, event_limit=events, time_limit=limit)  # fmt: skip
    most = energy(system, q, qdot)
    times = run.sample(SAMPLES)[0]
    terms = most + np.abs(run.at(times)[0] * equations(system)[1]).sum(axis=1).max()
    assert np.diff(run.energy(times)).max() <= ROUNDING * terms
    seen[f"{law}: {run.outcome}"] += 1
    return run, most


def contradiction(system, claim, q, qdot, law, seen, events=None):
    """How a motion of a system from a small start contradicts a verdict, or None."""
    well = claim.by == "potential-well"
    # Masses and lengths are of order 1: a well is at rest after some √E. A motion that is unstable may have no end.
    unstable = 1 if claim.stability == "unstable" else None
    limit = PATIENCE * np.sqrt(energy(system, q, qdot)) if well else unstable
    run, most = motion(system, q, qdot, law, seen, limit, events)
    if unstable:
        rests = claim.by == "not-equilibrium" and run.outcome == "rest"
        return "rest" if rests else None
    if run.outcome not in ("rest", "event-limit", "ambiguous"):
        return run.outcome
    if not well:
        return None
    heights = np.array(claim.evidence["largest"]) * run.gaps_at(run.sample(SAMPLES)[0])
    if heights.max() > most * (1 + CLOSE):
        return "gap"
    if run.outcome == "rest" and claim.evidence["level"] > 0:
        return None if energy(system, run.q, run.qdot) < REST * most else "held"
    return None


def starts(system, rng, count):
    """Small starts: every second one a kick, the others lifted and tilted."""
    for k in range(count):
        size, still = 10.0 ** rng.uniform(-5, -3), np.zeros(system.dof)
        if k % 2:
            yield lifted(system, rng, size), still
        else:
            yield still, rng.normal(size=system.dof) * size


def contradictions(system, claim, rng, count, seen):
    """Those of random small starts, and of the evidence of a verdict."""
    found = []
    if claim.stability == "stable" or claim.by == "not-equilibrium":
        for k, (q, qdot) in enumerate(starts(system, rng, count)):
            law = claim.laws[k // 2 % len(claim.laws)]
            found.append(contradiction(system, claim, q, qdot, law, seen))
    elif claim.by == "no-solution":
        start = np.array(claim.evidence["q"]), np.array(claim.evidence["qdot"])
        for size in (1, 1e-2):
            q, qdot = size**2 * start[0], size * start[1]
            for law in ("newton", "moreau"):
                run, _ = motion(system, q, qdot, law, seen, None)
                found.append(None if run.outcome == "inconsistent" else run.outcome)
    elif claim.by == "accelerating-mode":
        qdot = np.array(claim.evidence["velocity"])
        run, _ = motion(system, np.zeros(system.dof), qdot, "moreau", seen, 10)
        found.append(None if run.outcome == "time-limit" else run.outcome)
    return [word for word in found if word]


def case(seed):
    """A random assembly, half of them towers, with a generator of random numbers."""
    rng = np.random.default_rng([3, seed])
    restitution = rng.choice([0, 0.3, rng.uniform(0, 0.7)])
    few = lambda rng: tower(rng, 2, 3)  # noqa: E731
    kind = few if rng.random() < 0.5 else KINDS[rng.integers(len(KINDS))]
    return drawn(rng, kind, restitution), rng


@pytest.mark.parametrize("part", range(PARTS))
def test_dropped_stacks(part):
    """Random stacks of three blocks that are lifted and tilted by about a millimetre come to rest where they are stable, with Moreau's law and with Newton's; a few have not
    ended after DROP_EVENTS events, and have less energy and smaller gaps than at the start."""
    seen = collections.Counter()
    for seed in range(part, DROPPED, PARTS):
        rng = np.random.default_rng([2, seed])
        restitution = rng.choice([0, rng.uniform(0, 0.7)])
        system = drawn(rng, lambda rng: tower(rng, 3, 3), restitution)
        claim = Claim.of(sf.stability(system))
        q, still = lifted(system, rng, DROP), np.zeros(system.dof)
        for law in ("newton", "moreau"):
            of = collections.Counter()
            if claim.stability == "undecided":
                motion(system, q, still, law, of, 1, DROP_EVENTS)
            else:
                assert contradiction(system, claim, q, still, law, of, DROP_EVENTS) is None, (seed, law)  # fmt: skip
            seen.update({f"{claim.by}, {word}": count for word, count in of.items()})
    print(dict(seen))
    for law in ("newton", "moreau"):
        rest, open_ = (seen[f"potential-well, {law}: {end}"] for end in ("rest", "event-limit"))  # fmt: skip
        assert rest > 0
        assert rest >= SHARE * (rest + open_)


@pytest.mark.parametrize("part", range(PARTS))
def test_verdicts_beside_runs(part):
    """Random assemblies, half of them towers of two or three blocks: no run from a small start contradicts a verdict."""
    seen = collections.Counter()
    for seed in range(part, VERDICTS, PARTS):
        system, rng = case(seed)
        verdict = sf.stability(system)
        of = collections.Counter()
        found = contradictions(system, Claim.of(verdict), rng, KICKS, of)
        assert not found, (seed, found)
        name = verdict.by or verdict.reason
        seen[name] += 1
        seen.update({f"{name}, {word}": count for word, count in of.items()})
    print(dict(seen))
    assert seen["potential-well"] > 0


def planted(rng, error):
    """A tower of two blocks and a false claim about it."""
    bodies, _ = tower(rng, 2, 2)
    low, high = bodies
    true = sf.System(bodies)
    claim = Claim.of(sf.stability(true))
    if claim.by != "potential-well":
        return None
    if error == "no equilibrium":
        return true, Claim("unstable", "not-equilibrium", {}, claim.laws)
    if error == "smooth ground":
        contacts = [
            sf.SystemContact(*c.bodies, c.point, c.slope, 0 if c.bodies[1] is None else c.friction)
            for c in true.contacts
        ]  # fmt: skip
        return sf.System(bodies, contacts=contacts), claim
    edge = low.outline[:, 0].max() - high.center_of_mass[0]
    edge += 0.01 if error == "beyond the edge" else 0
    shift = np.array([edge, 0])
    moved = sf.Rigid(high.mass, high.gyration_radius, high.center_of_mass + shift, high.outline + shift, high.friction)  # fmt: skip
    system = sf.System([low, moved])
    if error == "over the edge":
        # Forces without friction hold it: λ ≥ 0, and not λ > 0.
        smooth = sf.System([low, moved], contacts=[sf.SystemContact(*c.bodies, c.point, c.slope, 0) for c in system.contacts])  # fmt: skip
        claim.evidence["largest"] = extremes(smooth)[1][:, 1]
    return system, claim


@pytest.mark.parametrize(
    "error", ["smooth ground", "beyond the edge", "over the edge", "no equilibrium"]
)
def test_planted_errors_contradict(error):
    """A run without friction on the ground, and false claims about blocks on the edge, beyond it and at rest, are contradictions."""
    caught = 0
    for seed in range(PLANTED):
        rng = np.random.default_rng([4, seed])
        scene = planted(rng, error)
        if scene is None:
            continue
        assert contradictions(*scene, rng, 12, collections.Counter())
        caught += 1
    print(error, caught)
    assert caught > PLANTED / 2
