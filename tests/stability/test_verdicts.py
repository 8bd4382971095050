"""Verdicts on random postures with ground, walls, overhangs and ceilings. Every verdict has evidence, the evidence
holds, and simulated kicks do not contradict it. STANDFAST_VERDICTS sets the number of postures (100)."""

import collections
import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import stance
from corners import corner_kick, next_corner, rows_of

POSTURES = int(os.environ.get("STANDFAST_VERDICTS", "100"))
KICKS = 100
#: Number of events after which a run ends. A proof of stability does not bound them.
EVENTS = 100_000
EXACT = (0.0, math.pi / 2, -math.pi / 2, math.pi)


def draw_posture(rng):
    """Slopes in (−π, π], half of them exact floors, walls and ceilings, half of the pairs like a V; most centres of mass over the
    equilibrium region, and few postures without one."""
    while True:
        slopes = [
            float(rng.choice(EXACT))
            if rng.random() < 0.3
            else rng.uniform(-math.pi, math.pi)
            for _ in range(2)
        ]
        if rng.random() < 0.5:
            slopes = [-abs(slopes[0]), abs(slopes[1])]
            if -math.pi in slopes:
                continue
        contacts = [
            sf.Contact(
                (side * rng.uniform(0.05, 1), rng.uniform(-0.7, 0.7)),
                slope=slope,
                friction=rng.choice([0.0, rng.uniform(0, 1.5)]),
            )
            for side, slope in zip((-1, 1), slopes, strict=True)
        ]
        rho, e = (
            math.exp(rng.uniform(-1.5, 0.5)),
            rng.choice([0.0, rng.uniform(0, 0.9)]),
        )
        height = rng.uniform(-1, 1.5)
        region = sf.equilibrium_region(stance(contacts, (0, height), rho, e))
        if region is None and rng.random() < 0.99:
            continue
        x = rng.uniform(-1.5, 1.5)
        if region is not None and rng.random() < 0.95:
            low, high = max(region[0], -3.0), min(region[1], 3.0)
            if high - low < 1e-6:
                continue  # rounding would decide
            x = rng.uniform(low, high)
        return stance(contacts, (x, height), rho, e)


def kicks(posture, rng, count=KICKS):
    """Outcomes of random velocities; some start with one of the contacts, or both, at rest."""
    normals, _, _ = rows_of(posture)
    metric = np.array([1, 1, 1 / posture.gyration_radius])
    velocities = rng.normal(size=(count, 3)) * metric
    for k in range(0, count, 3):
        held = normals[[[0], [1], [0, 1]][k % 9 // 3]]
        velocities[k] -= np.linalg.pinv(held) @ (held @ velocities[k])
    velocities *= 10.0 ** rng.uniform(-4, -2, (count, 1))
    runs = sf.simulate_many(
        posture,
        np.zeros((count, 3)),
        velocities,
        model="local",
        event_limit=EVENTS,
        impact="newton",
    )
    return collections.Counter(map(str, runs.outcome))


def check_away(posture, velocity):
    run = sf.simulate(
        posture, (0, 0, 0), velocity, model="local", event_limit=EVENTS, impact="newton"
    )
    assert run.outcome != "rest", (posture, velocity, run)


def check_unstable(posture, verdict):
    """The evidence of a verdict "unstable"."""
    evidence = verdict.evidence
    if verdict.by == "not-equilibrium":
        assert (
            float(evidence["equilibrium_margin"]) == verdict.equilibrium_margin < 0
        ), posture
        assert "FF" not in sf.contact_modes(posture).consistent, posture
        return "region"
    if verdict.by == "growing-cycle":
        growth = 0.0
        for corner, then in zip(evidence, evidence[1:] + evidence[:1], strict=True):
            found = next_corner(posture, corner["contact"] - 1, ratio(posture, corner))
            assert found is not None, posture
            contact, angle, more = found
            assert contact == then["contact"] - 1, posture
            assert angle == pytest.approx(ratio(posture, then), abs=1e-4), posture
            growth += more
        assert growth == pytest.approx(
            sum(corner["growth"] for corner in evidence), abs=1e-3
        )
        assert growth > 0, posture
        return "cycle"
    if verdict.by == "no-solution":
        run = sf.simulate(
            posture, evidence["q"], evidence["qdot"], model="local", impact="newton"
        )
        assert (run.outcome, len(run.impacts)) == ("inconsistent", 0), posture
        return "no motion"
    assert verdict.by == "accelerating-mode"
    if isinstance(evidence, str):
        assert evidence != "FF"
        assert evidence in sf.contact_modes(posture).consistent, (posture, evidence)
        return "word"
    if "word" in evidence:
        velocity = evidence["velocity"]
        modes = sf.contact_modes(posture, qdot=velocity)
        assert evidence["word"] in modes.consistent, (posture, evidence, modes)
        check_away(posture, velocity)
        return "motion"
    check_away(
        posture, corner_kick(posture, evidence["contact"] - 1, ratio(posture, evidence))
    )
    return "corner"


def ratio(posture, corner):
    """The angle of a corner with the sliding speed along the direction in which both contacts slide."""
    _, tangents, both = rows_of(posture)
    return math.atan(math.tan(corner["phi"]) / (tangents[2 - corner["contact"]] @ both))


def test_verdicts_on_slopes_of_any_kind(record_property):
    rng = np.random.default_rng(41)
    found, pulled = collections.Counter(), collections.Counter()
    for _ in range(POSTURES):
        posture = draw_posture(rng)
        verdict = sf.stability(posture)
        decision, kind = verdict.frictional_stability, None
        assert decision == "undecided" or verdict.evidence is not None, posture
        if verdict.delicate:
            kind = "delicate"
        elif decision == "stable":
            outcomes = kicks(posture, rng)
            assert outcomes == {"rest": KICKS}, (posture, verdict.by, outcomes)
        elif decision == "unstable":
            kind = check_unstable(posture, verdict)
            outcomes = kicks(posture, rng)
            if kind == "region":
                assert outcomes["rest"] == 0, (posture, outcomes)
        found[decision, verdict.by, kind] += 1
        signs = sorted(
            0 if abs(g) < 1e-12 else int(np.sign(g)) for g in posture.local().gravity
        )
        pulled[*signs, decision] += 1
    text = f"{POSTURES} postures with {KICKS} kicks: {dict(found)}, by the signs of gravity: {dict(pulled)}"
    print(f"\n{text}")
    record_property("verdicts", text)
    decisions = collections.Counter()
    for (decision, _, _), n in found.items():
        decisions[decision] += n
    assert (
        min(decisions[d] for d in ("stable", "unstable", "undecided"))
        >= 0.04 * POSTURES
    )


FALSE = [
    (
        [
            sf.Contact((-0.2571232304054009, -0.40783200345187465), slope=2.996737527191598, friction=0.9247055241744488),
            sf.Contact((0.2571524762515129, 0.25354080201612283), slope=-0.7757306136906122, friction=1.2341360159834807),
        ],
        ((0.41515925930364374, 1.1511027720340752), 1.151552476850011, 0.0),
    ),
    (
        [
            sf.Contact((-0.48948384646617954, 0.44803738142211025), slope=-2.8518158410398886, friction=1.149741226373866),
            sf.Contact((0.26060409276217494, -0.4463118751591202), slope=-0.3451497562785084, friction=1.149741226373866),
        ],
        ((0.27078199884279996, -0.11351304966535436), 0.4679813529216489, 0.21474773994347493),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("contacts", "rest"), FALSE)
def test_a_contact_that_gravity_pulls_off_does_not_slide_alone(contacts, rest):
    """All kicks come to rest, and no word but FF is consistent."""
    posture = stance(contacts, *rest, gravity=9.81)
    assert kicks(posture, np.random.default_rng(1), 400) == {"rest": 400}
    assert sf.contact_modes(posture).consistent == ["FF"]
    assert sf.stability(posture).frictional_stability != "unstable"
