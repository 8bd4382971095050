"""Verdicts on bodies on two contacts, with jams as impacts and without. STANDFAST_JAMS sets the number of postures (40), STANDFAST_JAMS_KICKS that
of kicks of each (40)."""

import collections
import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import paper_vee
from corners import corner_kick, rows_of

POSTURES = int(os.environ.get("STANDFAST_JAMS", "40"))
KICKS = int(os.environ.get("STANDFAST_JAMS_KICKS", "40"))
#: Number of events after which a run ends. A proof does not bound them.
EVENTS = 100_000
#: Slopes of both contacts, least and largest.
FAMILIES = {
    "V": ((-0.8, -0.1), (0.1, 0.8)),
    "steep V": ((-1.4, -0.8), (0.8, 1.4)),
    "roof": ((0.1, 0.8), (-0.8, -0.1)),
    "slope": ((0.0, 0.6), (0.0, 0.6)),
    "walls": ((-math.pi / 2, -0.1), (0.1, math.pi / 2)),
}


def draw(rng, family):
    """A body on two contacts of a family, its centre of mass over the equilibrium region."""
    while True:
        slopes = [
            rng.choice([low, high]) if family == "walls" else rng.uniform(low, high)
            for low, high in FAMILIES[family]
        ]
        feet = [
            sf.Contact(
                (side, rng.uniform(-0.5, 0.5)), slope, friction=rng.uniform(0.2, 1.5)
            )
            for side, slope in zip((-1, 1), slopes, strict=True)
        ]
        rho, e = rng.uniform(0.25, 1.2), rng.choice([0, rng.uniform(0, 0.9)])
        height = rng.uniform(-0.5, 2.5)
        region = sf.equilibrium_region(sf.Posture(1, rho, (0, height), feet, e))
        if region is None:
            continue
        low, high = max(region[0], -2.0), min(region[1], 2.0)
        if high - low > 1e-3:
            return sf.Posture(1, rho, (rng.uniform(low, high), height), feet, e)


def ends(posture, jams, rng, model="local", count=KICKS, speed=1e-3):
    """Outcomes of random velocities of the standing body; every third one keeps a contact, or both, on the ground."""
    normals, _, _ = rows_of(posture)
    metric = np.array([1, 1, 1 / posture.gyration_radius])
    velocities = rng.normal(size=(count, 3)) * metric * speed
    for k in range(0, count, 3):
        held = normals[[[0], [1], [0, 1]][k % 9 // 3]]
        velocities[k] -= np.linalg.pinv(held) @ (held @ velocities[k])
    runs = sf.simulate_many(
        posture,
        (0, 0, 0),
        velocities,
        model=model,
        event_limit=EVENTS,
        jams=jams,
        neighbourhood=0.5,
        impact="newton",
    )
    return collections.Counter(runs.outcome.tolist())


def check_cycle(posture, cycle, jams):
    """A corner of a growing cycle is the start of a motion that does not come to rest nearby."""
    corner = cycle[0]
    lands = corner["contact"] - 1
    _, tangents, both = rows_of(posture)
    phi = math.atan(math.tan(corner["phi"]) / (tangents[1 - lands] @ both))
    kick = corner_kick(posture, lands, phi) * 1e-6
    run = sf.simulate(
        posture,
        (0, 0, 0),
        kick,
        model="local",
        jams=jams,
        event_limit=2000,
        record=False,
        impact="newton",
    )
    metric = np.array([1, 1, posture.gyration_radius])
    total = sum(corner["growth"] for corner in cycle)
    assert total > 0
    if total > 1e-2:  # below, rounding errors leave the cycle before it has grown
        grown = np.abs(run.q * metric).max() / 1e-12
        assert run.outcome != "rest" or grown > 1e3, (posture, run, total)


def test_jams_at_five_places():
    """The V of the paper, both rules."""
    for com in ((0.5, 2.5), (0, 2.9), (0.8, 2.2), (0.79, 1.995)):
        posture = paper_vee(*com)
        assert sf.stability(posture).by == "no-solution"
        verdict = sf.stability(posture, jams="impact")
        assert verdict.frictional_stability == "stable"
        assert verdict.by == ("corner-map" if com[0] else "neutral")
        assert verdict.after_jam == "impact"
        assert ends(posture, "impact", np.random.default_rng(1)) == {"rest": KICKS}
    posture = paper_vee(-0.944257426, 2.797979798)
    verdict = sf.stability(posture, jams="impact")
    assert (verdict.frictional_stability, verdict.by) == ("unstable", "growing-cycle")
    assert sum(c["growth"] for c in verdict.evidence) > 0
    assert ends(posture, "impact", np.random.default_rng(1))["escape"] > KICKS / 2


def test_kicks_do_not_contradict_verdicts_under_either_rule(record_property):
    rng = np.random.default_rng(71)
    found = {rule: collections.Counter() for rule in ("none", "impact")}
    for k in range(POSTURES):
        family = list(FAMILIES)[k % len(FAMILIES)]
        posture = draw(rng, family)
        for jams, counts in found.items():
            verdict = sf.stability(posture, jams=jams)
            counts[family, verdict.by or verdict.reason] += 1
            if verdict.delicate:
                continue
            if verdict.frictional_stability == "stable":
                # The local model has no scale. In the full one kicks have to be small.
                for model, speed in (("local", 1e-3), ("full", 1e-5)):
                    outcomes = ends(posture, jams, rng, model, speed=speed)
                    late = outcomes["event-limit"]
                    if model == "full":
                        # A kick may be too large for the local model, and three or more modes may be consistent by a tie.
                        late += outcomes["ambiguous"]
                    assert outcomes["rest"] + late == KICKS, (
                        posture,
                        jams,
                        model,
                        verdict.by,
                        outcomes,
                    )
                    assert outcomes["rest"] or late == KICKS
            elif verdict.by == "no-solution":
                assert jams == "none"
                run = sf.simulate(
                    posture,
                    verdict.evidence["q"],
                    verdict.evidence["qdot"],
                    model="local",
                    impact="newton",
                )
                assert (run.outcome, len(run.impacts)) == ("inconsistent", 0)
            elif verdict.by == "growing-cycle":
                check_cycle(posture, verdict.evidence, jams)
    for jams, counts in found.items():
        record_property(jams, dict(counts))
        print(jams, dict(counts))
        decided = sum(
            n for (_, by), n in counts.items() if by in ("stable", "corner-map")
        )
        assert decided > 0
    assert not any(by == "no-solution" for _, by in found["impact"])


def test_both_rules_agree_where_nothing_jams():
    rng = np.random.default_rng(72)
    for _ in range(POSTURES):
        posture = draw(rng, "V")
        verdict = sf.stability(posture)
        other = sf.stability(posture, jams="impact")
        if verdict.frictional_stability == "stable":
            assert other.frictional_stability == "stable"
            assert (other.by, other.evidence) == (verdict.by, verdict.evidence)


def test_wells_that_jam_are_stable_with_impacts():
    from feet import draw_feet, jams, rays, width

    rng, tried = np.random.default_rng(73), 0
    while tried < 8:
        posture = draw_feet(rng, int(rng.choice([3, 4])))
        found = rays(posture)
        if width(found) <= 0 or not jams(posture, found):
            continue
        tried += 1
        verdict = sf.stability(posture, jams="impact")
        assert (verdict.frictional_stability, verdict.by) == ("stable", "well")
        qdot = rng.normal(0, 1e-4, (40, 3))
        options = {"model": "local", "neighbourhood": 1e-3, "event_limit": 30_000}
        runs = sf.simulate_many(
            posture, (0, 0, 0), qdot, jams="impact", **options, impact="newton"
        )
        assert set(runs.outcome) <= {"rest", "event-limit", "ambiguous"}, posture


def test_trials_beside_a_wall():
    """Upwards does not open a wall: random starts are moved away from it."""
    feet = [
        sf.Contact((0, 0), friction=0.6),
        sf.Contact((1, 1), slope=math.pi / 2, friction=0.6),
    ]
    verdict = sf.stability(sf.Posture(1, 0.5, (0.3, 1), feet, 0.1), trials=50)
    assert verdict.trials["rest"] == 50


def test_a_wrong_rule_is_named():
    with pytest.raises(ValueError, match='jams = "maybe"'):
        sf.stability(paper_vee(0, 1), jams="maybe")


def test_the_table_names_the_rule():
    assert "                    end by plastic impacts without collision" in str(
        sf.stability(paper_vee(0.5, 2.5), jams="impact")
    )


def test_a_contact_that_jams_alone_decides():
    """600 bodies on one to five contacts of any slope: where one jams while the others are in the air, no motion exists from some start."""
    rng = np.random.default_rng(20_261_130)
    bodies = []
    for _ in range(600):
        kind = rng.integers(3)
        feet = []
        for _ in range(rng.integers(1, 6)):
            slope = rng.uniform(-1, 1) if kind else 0.0
            if kind == 2:
                slope = rng.choice([0.0, math.pi / 2, -math.pi / 2, slope])
            point = (rng.uniform(-1, 1), rng.uniform(-0.5, 0.3) if kind else 0.0)
            feet.append(sf.Contact(point, slope, friction=rng.uniform(0, 2)))
        bodies.append(
            sf.Posture(
                mass=1,
                gyration_radius=rng.uniform(0.1, 1),
                center_of_mass=(rng.uniform(-0.5, 0.5), rng.uniform(0.2, 2)),
                contacts=feet,
                restitution=rng.uniform(0, 0.5),
            )
        )
    seen = collections.Counter()
    for body, verdict in zip(bodies, sf.stability(bodies), strict=True):
        jams = verdict.jams
        if verdict.frictional_stability == "stable":
            assert jams == []
        if verdict.by == "no-solution":
            assert verdict.evidence["jams"] == jams != []
            claim = verdict.certificate()["claim"]
            assert claim["by"] == "no-solution"
        alone = [jam for jam in jams if len(jam["contacts"]) == 1]
        if verdict.by is None:
            assert alone == []
        for jam in alone:
            # N M⁻¹ (N − σ μ T)ᵀ = 0 of a body: 1 + b² = −σ μ b c, with b = t·d/ρ and c = n·d/ρ, d from the centre of mass.
            [number], sign = jam["contacts"], {"R": 1, "L": -1}[jam["slides"]]
            foot = body.contacts[number - 1]
            d = np.subtract(foot.point, body.center_of_mass) / body.gyration_radius
            t = np.array([math.cos(foot.slope), math.sin(foot.slope)])
            b, c = t @ d, d[1] * t[0] - d[0] * t[1]
            assert jam["friction"] == [pytest.approx(-(1 + b * b) / (sign * b * c))]
            assert foot.friction > jam["friction"][0]
        seen[verdict.by, bool(alone)] += 1
    assert seen["no-solution", True] > 100
