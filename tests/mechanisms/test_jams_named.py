"""Who jams, in which direction and from which friction on: 500 random bipeds beside the contact modes of sliding contacts and closed forms."""

import itertools
import math

import numpy as np
import pytest
import standfast as sf

SIGNS = {1: "R", -1: "L"}


def biped(rng, kind):
    """A trunk of 10 kg and two legs of 1 kg, on slopes up to 0.4, and its configuration."""
    leg = sf.Link(1, 1 / 12, 1)
    hip = sf.Joint(kind, parent=1, at=0, angle=-math.pi / 2)
    feet = [
        sf.Foot(k, slope=rng.uniform(-0.4, 0.4), friction=rng.uniform(0.3, 0.9))
        for k in (2, 3)
    ]
    links = [sf.Link(10, 0.4, 1, center=0), leg, leg]
    angles = rng.uniform([-0.3, -0.9, 0.1], [0.3, -0.1, 0.9])
    return sf.Chain(links=links, joints=[hip, hip], feet=feet), [0, 0, *angles]


def with_friction(mechanism, values):
    rows = [
        sf.ContactRows(c.normal, c.tangential, friction=mu)
        for c, mu in zip(mechanism.contacts, values, strict=True)
    ]
    return sf.Mechanism(
        mechanism.mass_matrix, mechanism.load, rows, locked=mechanism.locked
    )


def stuck(mechanism, sliding):
    """Whether no contact mode is consistent while these contacts slide and the others are in the air."""
    problem = sf.MechanismProblem(mechanism, sliding=sliding)
    return not sf.contact_modes(problem).consistent


def scaled(mechanism, jam, factor):
    values = [contact.friction for contact in mechanism.contacts]
    for number, friction in zip(jam["contacts"], jam["friction"], strict=True):
        values[number - 1] = friction * factor
    return with_friction(mechanism, values)


@pytest.mark.parametrize("kind", ["torque", "locked"])
def test_bipeds_name_their_jams(kind):
    rng = np.random.default_rng(20_261_129)
    alone = pairs = standing = 0
    while standing < 500:
        chain, q = biped(rng, kind)
        mechanism = chain.mechanism(q, torques="holding" if kind == "torque" else None)
        if (verdict := sf.stability(mechanism)).by in (
            "not-equilibrium",
            "accelerating-mode",
        ):
            continue
        standing += 1
        found = {
            (tuple(jam["contacts"]), jam["slides"]): jam["friction"]
            for jam in verdict.jams
        }
        free = [k for k in range(mechanism.dof) if k not in mechanism.locked]
        mass = np.linalg.inv(mechanism.mass_matrix[np.ix_(free, free)])
        rows = mechanism.contacts
        # One that slides alone, and the root of N M⁻¹ (N − σ μ T)ᵀ.
        for foot, sign in itertools.product((0, 1), SIGNS):
            sliding = [None, None]
            sliding[foot] = sign
            jams = found.get(((foot + 1,), SIGNS[sign]))
            assert stuck(mechanism, sliding) == (jams is not None)
            if jams is not None:
                n, t = rows[foot].normal[free], rows[foot].tangential[free]
                root = (n @ mass @ n) / (sign * n @ mass @ t)
                assert jams == [pytest.approx(root, rel=1e-9)]
                assert root < rows[foot].friction
                alone += 1
        # Both: below the friction that is named a mode is consistent, above it none.
        for signs in itertools.product(SIGNS, SIGNS):
            letters = "".join(SIGNS[sign] for sign in signs)
            single = any(((k + 1,), SIGNS[s]) in found for k, s in enumerate(signs))
            jams = found.get(((1, 2), letters))
            if jams is None:
                possible = kind == "torque" or slides_together(rows, free, signs)
                assert single or not possible or not stuck(mechanism, [*signs])
                continue
            assert not single
            pairs += 1
            jam = {"contacts": [1, 2], "friction": jams}
            assert stuck(scaled(mechanism, jam, 1 + 1e-9), [*signs])
            assert not stuck(scaled(mechanism, jam, 1 - 1e-9), [*signs])
            assert jams[0] / jams[1] == pytest.approx(
                rows[0].friction / rows[1].friction
            )
        if verdict.by == "no-solution":
            assert found
            assert verdict.evidence["jams"] == verdict.jams
            text = str(verdict)
            assert "jams              contact" in text
            for numbers, letters in found:
                assert all(f"{k}" in text for k in numbers)
                assert ("right" if "R" in letters else "left") in text
    print(kind, alone, pairs)
    assert alone > 100


def slides_together(rows, free, signs):
    """Whether a rigid body can slide on both feet in these directions."""
    normals = np.array([row.normal[free] for row in rows])
    slide = np.linalg.svd(normals)[2][-1]
    speeds = [row.tangential[free] @ slide for row in rows]
    return speeds[0] * signs[0] * speeds[1] * signs[1] > 0


def test_two_feet_that_jam_only_together():
    """Two sliders of 1 kg that press each other through a lever: neither jams alone."""
    mass = np.linalg.inv([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.9], [0, 0, -0.9, 1]])
    normal = [[1, 0, 0, 0], [0, 1, 0, 0]]
    # N_i M⁻¹ T_jᵀ: the friction of each foot presses the other one.
    space = np.linalg.inv(mass)
    cross = [[0.0, 0.6], [0.6, 0.0]]
    tangential = []
    for k in (0, 1):
        row = np.zeros(4)
        row[2 + k] = 1.0
        row[:2] = np.linalg.solve(space[:2, :2], np.array(cross)[:, k])
        tangential.append(row)
    contacts = [
        sf.ContactRows(n, t, friction=2.5)
        for n, t in zip(normal, tangential, strict=True)
    ]
    mechanism = sf.Mechanism(mass, [-10, -10, 0, 0], contacts)
    found = sf.stability(mechanism).jams
    # A = [[1, −0.6 μ], [−0.6 μ, 1]] for both to the right: det A = 0 at μ = 1/0.6.
    assert {jam["slides"] for jam in found} == {"RR"}
    assert found[0]["contacts"] == [1, 2]
    assert found[0]["friction"] == pytest.approx([1 / 0.6] * 2, rel=1e-12)
    text = str(sf.stability(mechanism))
    assert "contacts 1 and 2 only together while they slide right and right" in text


def test_a_foot_on_the_floor_and_a_hand_at_the_wall():
    """The wall bears no weight: two of the roots are one, and the interval between them is none."""

    def body(factor):
        foot = sf.Contact((-0.11, 0.86), friction=0.5 * factor)
        hand = sf.Contact((-0.92, 0.46), slope=-math.pi / 2, friction=2 * factor)
        return sf.Posture(
            mass=1,
            gyration_radius=0.3,
            center_of_mass=(-0.47, 0.08),
            contacts=[foot, hand],
            restitution=0,
        )

    [jam] = sf.stability(body(1)).jams
    assert jam["friction"] == pytest.approx([0.27319, 1.09275], abs=1e-5)
    factor = jam["friction"][0] / 0.5
    for around, jams in ((1 + 1e-9, True), (1 - 1e-9, False)):
        found = [
            j
            for j in sf.stability(body(factor * around)).jams
            if len(j["contacts"]) == 2
        ]
        assert bool(found) == jams
