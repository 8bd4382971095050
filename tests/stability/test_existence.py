"""Postures from which arbitrarily small kicks lead to no motion: the closed forms in numpy, and simulated starts.

STANDFAST_EXISTENCE sets the number of random postures (200)."""

import os

import numpy as np
import pytest
import standfast as sf
from bodies import paper_vee
from corners import rows_of

POSTURES = int(os.environ.get("STANDFAST_EXISTENCE", "200"))
G = 9.81


def stiffness(posture, i, j, sigma):
    """N_i M⁻¹ (N_j − σ μ_j T_j)ᵀ per unit mass."""
    normals, tangents, _ = rows_of(posture)
    inverse = np.diag([1, 1, posture.gyration_radius**-2])
    mu = posture.contacts[j].friction
    return float(normals[i] @ inverse @ (normals[j] - sigma * mu * tangents[j]))


def gravity(posture):
    normals, _, _ = rows_of(posture)
    return posture.gravity * normals[:, 1]


def jams_alone(posture):
    """The contacts (from 1) and directions in which a contact jams while it slides alone."""
    g = gravity(posture)
    return [
        (i + 1, way)
        for i in range(2)
        for way, sigma in (("R", 1), ("L", -1))
        if g[i] > 0 and stiffness(posture, i, i, sigma) < 0
    ]


def jams_together(posture):
    """The directions (of both contacts) in which no mode continues a slide of both."""
    normals, tangents, _ = rows_of(posture)
    g = gravity(posture)
    if min(g) <= 0:
        return []
    z = np.cross(*normals)  # N z = 0
    found = []
    for side in (1, -1):
        ways = np.sign(tangents @ z) * side
        matrix = np.array(
            [[stiffness(posture, i, j, ways[j]) for j in range(2)] for i in range(2)]
        )
        slides = (np.linalg.solve(matrix, g) >= 0).all()
        lifts = [
            matrix[i, i] > 0 and matrix[1 - i, i] * g[i] / matrix[i, i] > g[1 - i]
            for i in range(2)
        ]
        if not slides and not any(lifts):
            found.append("".join("R" if way > 0 else "L" for way in ways))
    return found


@pytest.mark.parametrize(
    ("com", "expected"),
    [
        ((0.5, 2.5), [5.026732507, -1.046292291, 5.448445309, -0.516448001]),
        ((0.8, 2.0), [12.049404075, 0.031526336, 4.878123799, 0.420799692]),
        ((0.8, 1.5), [15.048611, 3.006944, 2.308559, 0.660491]),
    ],
)
def test_the_closed_form_at_three_places(com, expected):
    """k to the right and to the left, of contact 1 and of contact 2. Jams: of both contacts alone; of both together; none."""
    posture = paper_vee(*com)
    found = [stiffness(posture, i, i, sigma) for i in range(2) for sigma in (1, -1)]
    assert found == pytest.approx(expected, abs=1e-6)
    verdict = sf.stability(posture)
    lacks = bool(jams_alone(posture) or jams_together(posture))
    assert lacks == (min(expected) < 0.5)
    assert (verdict.by == "no-solution") == lacks


def check_evidence(posture, evidence):
    """The evidence names a jam, and from its start, however small, there is no motion."""
    contacts, slides = evidence["contacts"], evidence["slides"]
    if len(contacts) == 1:
        assert (contacts[0], slides) in jams_alone(posture)
        i, sigma = contacts[0] - 1, 1 if slides == "R" else -1
        k = stiffness(posture, i, i, sigma)
        assert k < 0
        assert evidence["stiffness"] == pytest.approx(k, rel=1e-9)
    else:
        assert contacts == [1, 2]
        assert slides in jams_together(posture)
    q, qdot = np.array(evidence["q"]), np.array(evidence["qdot"])
    for factor in (1.0, 0.5, 1e-3):
        run = sf.simulate(
            posture, q * factor**2, qdot * factor, model="local", impact="newton"
        )
        assert (run.outcome, run.elapsed, len(run.impacts)) == ("inconsistent", 0, 0)


def test_no_solution_on_random_postures(record_property):
    rng, found = np.random.default_rng(71), {}
    for _ in range(POSTURES):
        slopes = rng.uniform(-1.2, 1.2, 2)
        mu, heights = rng.uniform(0, 1.5), rng.uniform(-0.5, 0.5, 2)
        feet = [
            sf.Contact((side, height), slope, friction=mu)
            for side, slope, height in zip((-1, 1), slopes, heights, strict=True)
        ]
        com = rng.uniform((-1, 0), (1, 3))
        posture = sf.Posture(
            1, rng.uniform(0.2, 1.2), com, feet, rng.choice([0, 0.1, 0.5])
        )
        verdict = sf.stability(posture)
        found[verdict.by] = found.get(verdict.by, 0) + 1
        lacks = jams_alone(posture) + jams_together(posture)
        if verdict.by == "no-solution":
            assert verdict.frictional_stability == "unstable"
            check_evidence(posture, verdict.evidence)
            assert "no motion exists" in str(verdict)
        elif verdict.frictional_stability == "stable":
            assert not lacks, posture
        elif verdict.frictional_stability == "undecided":
            assert not lacks or verdict.delicate, posture
    record_property("verdicts", found)
    print(found)
    assert found["no-solution"] > POSTURES / 50
