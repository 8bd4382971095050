"""Certificates of verdicts on assemblies and mechanisms: they hold, and none holds for a claim that is false.

STANDFAST_ASSEMBLY_CERTIFICATES sets the number of random assemblies (40)."""

import collections
import copy
import json
import os
import time
from fractions import Fraction

import numpy as np
import pytest
import standfast as sf
from assemblies import KINDS, arch, drawn, equations, tower
from standfast.certificate.exact import is_strictly_copositive, rational
from standfast.certificate.levels import sliding_sets
from standfast.certificate.mechanism import rows_of
from standfast.certificate_maker import holding_none, texts, weights_of
from standfast.cli import main

ASSEMBLIES = int(os.environ.get("STANDFAST_ASSEMBLY_CERTIFICATES", "40"))
#: Rounding of doubles, relative to the largest of them.
ROUNDING = 1e-12


def leaning(friction=0.6):
    """The upper block is over the edge."""
    return sf.System([sf.Block(1, 0.5), sf.Block(1, 0.5, at=(0.6, 0.5))], friction=friction)  # fmt: skip


def refused(certificate, words):
    with pytest.raises(ValueError, match=words):
        sf.certificate.check(certificate)


def changed(certificate, path, value):
    """A copy with another value in this place; a function makes it of the old one."""
    other = copy.deepcopy(certificate)
    place = other
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value(place[path[-1]]) if callable(value) else value
    return other


def assemblies():
    """Random assemblies, half of them towers of two or three blocks."""
    for seed in range(ASSEMBLIES):
        rng = np.random.default_rng([5, seed])
        kind = (lambda rng: tower(rng, 2, 3)) if seed % 2 else KINDS[rng.integers(len(KINDS))]  # fmt: skip
        yield drawn(rng, kind, rng.choice([0, 0.3]))


def test_random_assemblies_out_of_equilibrium():
    seen = collections.Counter()
    for system in assemblies():
        verdict = sf.stability(system)
        if verdict.by != "not-equilibrium":
            continue
        certificate = json.loads(json.dumps(verdict.certificate()))
        sf.certificate.check(certificate)
        assert certificate["claim"]["contacts"] == verdict.contacts
        refused(changed(certificate, ("data", "separates"), lambda y: [str(-rational(part, "y")) for part in y]), "not-equilibrium: y·load is not positive")  # fmt: skip
        seen[len(system.bodies)] += 1
    print(dict(seen))
    assert seen


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        # The corner of the lower block is beyond the centre of mass of the upper one.
        (("scene", "contacts", 3, "normal", 5), (0.1).hex(), "not-equilibrium: y·w of the edge N . μT of contact 4"),
        (("scene", "load"), lambda load: [(-float.fromhex(x)).hex() for x in load], "not-equilibrium: y·load is not positive"),
        (("scene", "contacts"), lambda contacts: contacts[:-1], "claim.contacts"),
        (("scene", "mass_matrix", 0, 0), (-1.0).hex(), "mass_matrix is not positive definite"),
        (("scene", "mass_matrix", 0, 1), (0.1).hex(), "mass_matrix is not symmetric"),
        (("scene", "mass_matrix"), [], "mass_matrix is not a list of 6 rows"),
        (("scene", "load"), [], "scene.load is empty"),
        (("scene", "load"), [(0.0).hex()] * 101, "at most 100 are checked"),
        (("scene", "contacts", 0, "friction"), (-0.1).hex(), r"contacts\[0\].friction is negative"),
        (("scene", "contacts", 0, "friction"), "1/2", r"contacts\[0\].friction is not a finite double"),
        (("scene", "contacts", 0, "restitution"), (1.0).hex(), "below 1"),
        (("scene", "contacts", 1, "number"), 1, "not in order"),
        (("claim", "frictional_stability"), "stable", "not-equilibrium proves 'unstable'"),
        (("claim", "by"), "well", "no argument that can be checked"),
        (("data", "separates"), lambda y: y[1:], "data.separates is not a list of 6 numbers"),
        (("data", "separates", 0), "1/0", r"data.separates\[0\] is not a finite double"),
        (("data", "separates", 0), 0.5, r"data.separates\[0\] is not a finite double"),
    ],
)  # fmt: skip
def test_a_false_certificate_out_of_equilibrium_is_refused_by_name(path, value, words):
    certificate = sf.stability(leaning()).certificate()
    refused(changed(certificate, path, value), words)


def test_more_friction_than_stated_is_refused():
    """A block on a slope of 30° slides on friction .5, not on .6."""
    line = [(-9 * np.cos(0.5236), -9 * np.sin(0.5236)), (9 * np.cos(0.5236), 9 * np.sin(0.5236))]  # fmt: skip
    up = np.array([-np.sin(0.5236), np.cos(0.5236)])
    blocks = [sf.Block(1, 0.3, at=0.3 * k * up, turn=0.5236) for k in (0, 1)]
    certificate = sf.stability(sf.System(blocks, ground=line, friction=0.5)).certificate()  # fmt: skip
    for contact in certificate["scene"]["contacts"]:
        contact["friction"] = (0.6).hex()
    refused(certificate, "not-equilibrium: y·w of the edge")


def test_weak_signs_are_found_in_fractions():
    """Walls without friction press from both sides: y·w = 0 for them, exactly."""
    walls = [sf.ContactRows(side * np.array([1, 0, 0.1 * x, x]), [0, side, 0.3, 0]) for side in (1, -1) for x in (0.1, 0.7)]  # fmt: skip
    certificate = sf.stability(sf.Mechanism(np.eye(4), [0, -9, 0, 0], walls)).certificate()  # fmt: skip
    assert certificate["claim"]["by"] == "not-equilibrium"
    sf.certificate.check(certificate)
    y = [rational(part, "y") for part in certificate["data"]["separates"]]
    for contact in certificate["scene"]["contacts"]:
        assert sum(a * Fraction(float.fromhex(b)) for a, b in zip(y, contact["normal"], strict=True)) == 0  # fmt: skip


def test_weights_or_a_separating_vector():
    """Of random columns, most of them degenerate: one of the two always, exactly."""
    rng, seen = np.random.default_rng(6), collections.Counter()
    for _ in range(200):
        n = int(rng.integers(1, 5))
        columns = [[Fraction(int(x)) for x in rng.integers(-2, 3, n)] for _ in range(rng.integers(1, 8))]  # fmt: skip
        total = [Fraction(int(x)) for x in rng.integers(-2, 3, n)]
        weights, y = weights_of(columns, total)
        inner = lambda a, b: sum(p * q for p, q in zip(a, b, strict=True))  # noqa: E731
        if weights is None:
            assert all(inner(y, column) >= 0 for column in columns)
            assert inner(y, total) < 0
        else:
            assert min(weights) >= 0
            assert [inner(weights, row) for row in zip(*columns, strict=True)] == total
        seen[weights is None] += 1
    assert min(seen.values()) > 50


# Bodies in a potential well.


def stack(friction=0.5, restitution=0.3):
    """Two blocks; each slides on a level of its own."""
    blocks = {"low": sf.Block(1, 0.5), "high": sf.Block(1, 0.5, at=(0.4, 0.5))}
    return sf.System(blocks, friction=friction, restitution=restitution, tangential_restitution=restitution)  # fmt: skip


def test_random_assemblies_in_a_well(record_property):
    seen, slowest = collections.Counter(), 0.0
    for system in assemblies():
        verdict = sf.stability(system)
        if verdict.by != "potential-well":
            continue
        try:
            certificate = json.loads(json.dumps(verdict.certificate()))
        except ValueError as error:
            assert "at most 10" in str(error)  # noqa: PT017
            seen["too many contacts"] += 1
            continue
        start = time.perf_counter()
        sf.certificate.check(certificate)
        slowest = max(slowest, time.perf_counter() - start)
        columns, weights = equations(system)
        forces = np.array([float(rational(part, "λ")) for part in certificate["data"]["forces"]])  # fmt: skip
        assert (forces <= np.array(verdict.evidence["largest"]) * (1 + ROUNDING)).all()
        assert np.abs(columns[:, 1::2] @ forces + weights).max() < ROUNDING * np.abs(weights).max()  # fmt: skip
        seen["stiff" if "modes" not in certificate["data"] else "modes"] += 1
    text = f"{dict(seen)}, a check takes at most {slowest:.1f} s"
    print(text)
    record_property("certificates", text)
    assert min(seen["stiff"], seen["modes"]) > 0


def negated(values):
    return [str(-rational(value, "")) for value in values]


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("data", "forces", 0), "-1", "λ of contact 1 is negative"),
        (("data", "forces", 0), lambda force: str(rational(force, "") + Fraction(1, 10**40)), "load . Σ λ_iN_i is not zero in coordinate 2"),
        (("data", "forces"), lambda forces: forces[1:], "data.forces is not a list of 4 numbers"),
        # The centre of mass of the upper block is beyond the edge.
        (("scene", "contacts", 3, "normal", 5), (-0.1).hex(), "Σ λ_iN_i is not zero"),
        (("scene", "load", 0), (0.1).hex(), "Σ λ_iN_i is not zero in coordinate 1"),
        (("scene", "contacts", 2, "friction"), (5.0).hex(), "may jam while they slide"),
        # A small moment of inertia.
        (("scene", "mass_matrix", 5, 5), (0.001).hex(), "may jam while they slide"),
        (("scene", "contacts", 2, "restitution"), (0.2).hex(), "restitutions are not one number"),
        (("scene", "contacts", 0, "tangential_restitution"), (0.2).hex(), "the same in tangential direction"),
        (("data", "separates"), [], r"contacts \[.*\] may carry the load while it slides along a level"),
        (("data", "separates", 0, "y"), negated, "y·load is not positive"),
        (("data", "separates", 0, "contacts"), [1, 2, 3, 4], "y·w of the edge"),
        (("data", "separates", 0, "contacts"), [5], "are not numbers of contacts"),
        (("data", "separates"), None, "data.separates is not a list"),
        (("claim", "frictional_stability"), "unstable", "potential-well proves 'stable'"),
        (("claim", "contacts"), [1, 2, 3], "are not the contacts of the scene"),
    ],
)  # fmt: skip
def test_a_false_well_is_refused_by_the_step_that_fails(path, value, words):
    certificate = sf.stability(stack()).certificate()
    assert certificate["claim"]["by"] == "potential-well"
    refused(changed(certificate, path, value), f"^(potential-well|claim).*{words}")


def test_a_contact_less_is_refused():
    certificate = sf.stability(stack()).certificate()
    other = changed(certificate, ("scene", "contacts"), lambda contacts: contacts[1:])
    other["claim"]["contacts"] = [2, 3, 4]
    refused(changed(other, ("data", "forces"), lambda forces: forces[1:]), "Σ λ_iN_i is not zero")  # fmt: skip


@pytest.mark.parametrize("smooth", [(0, 1), (2, 3)])
def test_an_interface_without_friction_is_refused(smooth):
    """One contact of an interface with friction is enough."""
    certificate = sf.stability(stack()).certificate()
    for k in smooth:
        certificate["scene"]["contacts"][k]["friction"] = (0.0).hex()
    refused(certificate, "potential-well: a slide with N_i z = 0 .* meets no friction")
    one = stack().mechanism
    contacts = [sf.ContactRows(c.normal, c.tangential, friction=c.friction * (k != smooth[0]), tangential_restitution=0.3) for k, c in enumerate(one.contacts)]  # fmt: skip
    verdict = sf.stability(sf.Mechanism(one.mass_matrix, one.load, contacts, restitution=0.3))  # fmt: skip
    assert verdict.by == "potential-well"
    sf.certificate.check(verdict.certificate())


def test_a_vertical_joint_is_exact():
    """Its normal had a vertical part of 6e-17: two blocks side by side were `degenerate`, and walls without friction held a block by forces of 1e17 N."""
    beside = sf.System([sf.Block(1, 1), sf.Block(1, 1, at=(1, 0))], friction=0.5)
    verdict = sf.stability(beside)
    assert verdict.by == "potential-well"
    sf.certificate.check(verdict.certificate())
    for row in beside.mechanism.contacts[2:4]:
        assert (row.normal[[1, 4]] == 0).all()
    blocks = {"low": sf.Block(1, 1), "high": sf.Block(1, 1, at=(0, 1))}
    sides = [sf.SystemContact(name, None, (x, y + z), x * np.pi, 0) for z, name in enumerate(blocks) for x in (-0.5, 0.5) for y in (0, 1)]  # fmt: skip
    verdict = sf.stability(sf.System(blocks, contacts=sides, ground=None))
    assert verdict.by == "not-equilibrium"
    sf.certificate.check(verdict.certificate())


def test_bodies_that_friction_may_hold_above_their_level_are_refused():
    """With the separating vectors of the slides alone."""
    certificate = sf.stability(stack()).certificate()
    data = certificate["data"]
    rows = rows_of(certificate["scene"])
    forces = [rational(part, "") for part in data["forces"]]
    sliding = sliding_sets(rows, forces)
    data["separates"] = [
        {"contacts": [k + 1 for k in own], "y": texts(holding_none(rows, [rows.feet[k] for k in own]))}
        for own in map(sorted, sliding)
    ]  # fmt: skip
    refused(certificate, r"contacts \[.*\] may hold the load above its level")


def test_a_mechanism_without_levels_needs_no_separation():
    """A plate on three feet in space, with its height and two turns."""
    supports = [sf.ContactRows([1, x, y], [0, 0.1, 0.2 * x], friction=0.2, restitution=0.1 * k) for k, (x, y) in enumerate([(-1, -1), (1, -1), (0, 1.5)])]  # fmt: skip
    plate = sf.Mechanism(np.diag([1, 0.3, 0.4]), [-9.81, 0, 0], supports)
    verdict = sf.stability(plate)
    assert verdict.by == "potential-well"
    certificate = verdict.certificate()
    assert certificate["data"]["separates"] == []
    sf.certificate.check(certificate)


LOOSE = "data.modes has no mode"


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("data", "modes"), lambda modes: modes[1:], LOOSE),
        (("data", "modes"), lambda modes: modes[:-1], LOOSE),
        (("data", "modes", 0, "slides"), lambda slides: slides.translate({82: 76, 76: 82}), r"data.modes\[0\]: contact . is not that of its slide"),
        (("data", "modes", 0, "word"), lambda word: "S" * len(word), r"data.modes\[0\]: contact . is pulled, or falls"),
        (("data", "modes", 0, "word"), lambda word: word[1:], r"data.modes\[0\].word '.*' has no letter of SFRL for each contact"),
        (("data", "modes", 0, "forces"), lambda forces: forces[1:], r"data.modes\[0\].forces has no pair"),
        (("data", "modes", 0, "contacts"), lambda own: own[::-1], r"data.modes\[0\].contacts are not in order"),
        (("data", "modes"), "RR", "data.modes is not a list"),
        (("data", "lift"), negated, "N·z . μ|T·z| of contact 1 is not positive"),
        # They jam from 5/6 on.
        (("scene", "contacts"), lambda all: [contact | {"friction": (0.834).hex()} for contact in all], r"data.modes\[\d+\]"),
    ],
)  # fmt: skip
def test_two_cubes_go_on_and_are_not_stiff(path, value, words):
    """From friction .6764 on A(σ) is not strictly copositive; no contacts jam below 5/6."""
    stiff, loose = (sf.stability(cubes(mu)).certificate() for mu in (0.67, 0.83))
    assert "modes" not in stiff["data"]
    sf.certificate.check(loose)
    refused(changed(loose, path, value), f"potential-well: .*{words}")


# Contacts that jam.


def cubes(friction):
    """They jam from friction 5/6 on."""
    return sf.System([sf.Block(1, 1), sf.Block(1, 1, at=(0, 1))], friction=friction)


@pytest.mark.parametrize("friction", [0.834, 0.9, 1.2])
def test_two_cubes_that_jam(friction):
    verdict = sf.stability(cubes(friction))
    assert verdict.by == "no-solution"
    certificate = json.loads(json.dumps(verdict.certificate()))
    sf.certificate.check(certificate)
    assert len(certificate["data"]["contacts"]) == 3


def test_an_arch_jams_at_two_contacts():
    verdict = sf.stability(arch(9, 0.12))
    certificate = verdict.certificate()
    assert certificate["data"]["contacts"] in [jam["contacts"] for jam in verdict.jams]
    sf.certificate.check(certificate)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        # Just below 5/6.
        (("scene", "contacts"), lambda all: [contact | {"friction": (0.833).hex()} for contact in all], "the word LLL goes on"),
        (("data", "qdot"), negated, "σ v_t of contact 1 is not positive"),
        (("data", "q"), negated, "the gap of contact 2 is not positive"),
        (("data", "slides"), "RRR", "σ v_t of contact 1 is not positive"),
        (("data", "slides"), "LL", "no letter R or L for each contact"),
        (("data", "contacts"), [1, 3, 3], "are not numbers of contacts"),
        (("data", "contacts"), [1, 2, 3], "the word LSL goes on"),
        (("data", "q"), lambda q: q[1:], "data.q is not a list of 6 numbers"),
        (("claim", "frictional_stability"), "stable", "no-solution proves 'unstable'"),
        (("claim", "jams"), "impact", "an impact ends a jam"),
    ],
)  # fmt: skip
def test_a_false_jam_is_refused_by_the_step_that_fails(path, value, words):
    certificate = sf.stability(cubes(0.84)).certificate()
    refused(changed(certificate, path, value), f"^(no-solution|claim).*{words}")


def test_a_contact_that_jams_alone_beside_a_locked_coordinate():
    """Painlevé's rod of 2 m at 60°, beside a block with coordinates of its own."""
    x, y = 0.5, 3**0.5 / 2
    rod = sf.ContactRows([0, 1, -x, 0, 0, 0], [1, 0, y, 0, 0, 0], friction=2)
    block = sf.ContactRows([0, 0, 0, 0.5, 0, 1], [0, 0, 0, 0, 1, 0], friction=0.2)
    mass, load = np.diag([1, 1, 1 / 3, 1, 1, 1]), [0, -9.81, 0, 0, 0, -9.81]
    # A force and a torque hold the rod.
    load[0], load[2] = 1, 9.81 * x + y
    verdict = sf.stability(sf.Mechanism(mass, load, [rod, block], locked=[3]))
    assert verdict.by == "no-solution"
    certificate = verdict.certificate()
    assert certificate["data"]["contacts"] == [1]
    assert len(certificate["data"]["q"]) == 5
    sf.certificate.check(certificate)
    for contact in certificate["scene"]["contacts"]:
        contact["friction"] = (
            1.3
        ).hex()  # Painlevé's limit is 4/3 for the slope of the rod's least one
    refused(certificate, "no-solution: the word [LR] goes on")


def test_strict_copositivity():
    """Against the closed form of Hadeler [1983] for three rows, and the matrix of Horn."""
    rng, seen = np.random.default_rng(8), collections.Counter()
    for _ in range(2000):
        matrix = rng.integers(-9, 10, (3, 3))
        matrix = np.triu(matrix) + np.triu(matrix, 1).T + np.diag(rng.integers(0, 12, 3))  # fmt: skip
        d = np.sqrt(np.maximum(np.diag(matrix), 0))
        pairs = [matrix[i, j] + d[i] * d[j] for i, j in ((0, 1), (0, 2), (1, 2))]
        value = d.prod() + matrix[0, 1] * d[2] + matrix[0, 2] * d[1] + matrix[1, 2] * d[0] + np.sqrt(2 * np.maximum(pairs, 0).prod())  # fmt: skip
        signs = [*np.diag(matrix), *pairs, value]
        if np.abs(signs).min() < ROUNDING * 100:
            continue
        expected = min(signs) > 0
        exact = [[Fraction(int(x)) for x in row] for row in matrix]
        assert is_strictly_copositive(exact) == expected, matrix
        seen[bool(expected)] += 1
    assert min(seen.values()) > 200
    for more in (Fraction(1, 10**20), Fraction(0), Fraction(-1, 10**20)):
        horn = [[1 + more if i == j else Fraction(-1 if (i - j) % 5 in (1, 4) else 1) for j in range(5)] for i in range(5)]  # fmt: skip
        assert is_strictly_copositive(horn) == (more > 0)


def test_a_locked_joint_is_no_coordinate_of_the_scene():
    rows = [sf.ContactRows([0, 1, x, 0.3], [1, 0, 0.5, 0.1], friction=0.3) for x in (-1, 1)]  # fmt: skip
    mechanism = sf.Mechanism(np.diag([1, 1, 0.3, 2]), [5, -9, 0, 1], rows, locked=[3], armature=[0, 0.5, 0, 0])  # fmt: skip
    verdict = sf.stability(mechanism)
    assert verdict.by == "not-equilibrium"
    scene = verdict.certificate()["scene"]
    assert [float.fromhex(x) for x in scene["load"]] == [5, -9, 0]
    assert float.fromhex(scene["mass_matrix"][1][1]) == 1.5


def test_on_the_command_line(tmp_path, capsys):
    path, scene, other = (tmp_path / name for name in ("certificate.json", "leaning.toml", "rough.toml"))  # fmt: skip
    still = np.zeros(6)
    sf.MechanismScene(leaning(), still, still).save(scene)
    sf.MechanismScene(leaning(0.7), still, still).save(other)
    assert main(["stability", str(scene), "--certificate", str(path)]) == 0
    assert main(["check", str(path), str(scene)]) == 0
    shown = capsys.readouterr().out
    assert "unstable by not-equilibrium: every step holds\n" in shown
    assert "load = (0.0, -4.905, " in shown
    assert shown.endswith("  the scene of leaning.toml\n")
    assert main(["check", str(path), str(other)]) == 2
    assert f"scene.contacts[0].friction is 0.6; in {other} it is 0.7" in capsys.readouterr().err  # fmt: skip
    body = tmp_path / "body.toml"
    sf.Scene(sf.Posture.rod(0.5, 0.2)).save(body)
    assert main(["check", str(path), str(body)]) == 2
    assert "scene has no entry 'mass'" in capsys.readouterr().err
