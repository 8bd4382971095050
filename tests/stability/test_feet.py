"""Verdicts on three and more contacts: the rays of the free cone decide. STANDFAST_FEET sets the number of postures (30), STANDFAST_FEET_KICKS
that of kicks of each (30), STANDFAST_WELLS that of wells (6)."""

import collections
import itertools
import math
import os

import numpy as np
import pytest
import standfast as sf
from feet import draw_feet, jams, rays, scaled_rows, stiffness, width
from scipy.optimize import linprog

POSTURES = int(os.environ.get("STANDFAST_FEET", "30"))
KICKS = int(os.environ.get("STANDFAST_FEET_KICKS", "30"))
WELLS = int(os.environ.get("STANDFAST_WELLS", "6"))
RUNS = 50 if WELLS < 100 else 500
#: Number of events after which a run ends. A proof does not bound them, and at a large restitution they are many.
EVENTS = int(os.environ.get("STANDFAST_FEET_EVENTS", "5000"))


def feet(points, slopes, frictions, com, rho, e, **more):
    contacts = [
        sf.Contact(point, slope, friction=mu)
        for point, slope, mu in zip(points, slopes, frictions, strict=True)
    ]
    return sf.Posture(1.0, rho, com, contacts, e, 9.81, **more)


A = feet(
    [(-0.9, 0.1), (-0.4, -0.2), (0.2, -0.1)],
    [-0.3, -0.8, 0.3],
    [0.6, 0.8, 0.8],
    (-0.15, 1.1),
    0.6,
    0.6,
)
B = feet(
    [(-1, -0.1), (-0.3, -0.4), (0.3, -0.1), (0.6, -0.3)],
    [-0.6, 0.3, 0.2, 0.2],
    [0.5, 0.6, 0.5, 0.5],
    (-0.67, 1.23),
    0.5,
    0.5,
)
C = feet(
    [(-0.4, 0), (-0.1, -0.2), (0.8, 0)],
    [-0.5, 0.8, 0.8],
    [0.5, 0.8, 0.8],
    (0.6, 1.06),
    0.4,
    0.4,
)
D = feet(
    [(-0.8, 0.2), (-0.1, 0.1), (0.2, 0), (0.9, 0.3)],
    [-1, 0.9, -0.2, -0.3],
    [0.5, 0.6, 0.5, 0.5],
    (0.25, 1.36),
    0.3,
    0.4,
)
F = feet(
    [(-0.8, 0), (0.1, -0.3), (0.7, 0.2)],
    [0, 0, 0],
    [0.5, 0.9, 0.3],
    (0.4, 1.1),
    0.4,
    0.9,
)


def rises(verdict):
    return {
        tuple(ray["contacts"]): ray["direction"][1] for ray in verdict.evidence["rays"]
    }


def test_a_well_is_stable_although_a_pair_of_its_contacts_is_not():
    verdict = sf.stability(A)
    assert (verdict.frictional_stability, verdict.by) == ("stable", "well")
    expected = {(1, 2): 0.4453645826, (1, 3): 0.2471589392, (2, 3): 0.2240036897}
    assert rises(verdict) == pytest.approx(expected, abs=1e-9)
    assert verdict.evidence["width"] == pytest.approx(0.2837526761, abs=1e-9)
    assert verdict.stays
    assert verdict.radius(2.0) == pytest.approx(2 / (9.81 * 0.2837526761), rel=1e-9)
    assert verdict.amplification == 1
    pairs = {tuple(pair.contacts): pair.by for pair in verdict.pairs}
    assert pairs == {(1, 3): "corner-map", (2, 3): "growing-cycle"}
    assert verdict.kinematic_strong is verdict.coupling is verdict.energy is None
    k = [stiffness(A, i, s) for i in range(3) for s in (1, -1)]
    expected = [2.3181046702, 0.6664841031, 0.7689872192]
    expected += [4.4262888380, 1.0574003937, 0.9448791888]
    assert k == pytest.approx(expected, abs=1e-9)
    assert verdict.laws == ["newton", "poisson", "stronge"]


def test_the_only_pair_that_descends_decides():
    verdict = sf.stability(B)
    assert (verdict.frictional_stability, verdict.by) == ("stable", "descending-pair")
    expected = {(1, 2): -0.1001512593, (1, 4): 0.7983764936, (2, 4): 0.2837429337}
    assert rises(verdict) == pytest.approx(expected, abs=1e-9)
    [pair] = verdict.evidence["pairs"]
    assert (pair["contacts"], pair["by"]) == ([1, 2], "corner-map")
    assert not verdict.stays
    assert verdict.radius(1.0) is None
    assert {tuple(p.contacts): p.by for p in verdict.pairs}[1, 4] == "growing-cycle"
    verdict = sf.stability(C)
    assert (verdict.frictional_stability, verdict.by) == ("unstable", "descending-pair")
    expected = {(1, 2): 0.6681260997, (1, 3): -0.7601919266, (2, 3): 0.7173560909}
    assert rises(verdict) == pytest.approx(expected, abs=1e-9)
    # A lower bound for all scenes within the width; without width, that of this scene.
    shown = []
    for wide in (1e-12, 0):
        [pair] = sf.stability(C, width=wide).evidence["pairs"]
        shown.append(sum(c["growth"] for c in pair["evidence"]))
    assert shown[0] < shown[1] == pytest.approx(0.6521614570, abs=1e-9)


def test_a_well_in_which_an_exposed_contact_jams():
    verdict = sf.stability(D)
    assert (verdict.frictional_stability, verdict.by) == ("unstable", "no-solution")
    assert verdict.stays
    found = verdict.evidence
    assert (found["contacts"], found["slides"]) == ([1], "R")
    assert found["stiffness"] == pytest.approx(-0.5731954718, abs=1e-9)
    assert stiffness(D, 2, 1) == pytest.approx(-0.1064878835, abs=1e-9)  # harmless
    assert width(rays(D)) == pytest.approx(0.2170571550, abs=1e-9)
    assert jams(D, rays(D)) == [((0,), "R"), ((0, 1), "RR")]
    check_no_motion(D, found)


def test_level_ground_is_neutral():
    verdict = sf.stability(F)
    assert (verdict.frictional_stability, verdict.by) == ("stable", "neutral")
    assert verdict.evidence["outer"] == [1, 3]
    found = np.ravel(verdict.evidence["stiffness"]).tolist()
    assert found == pytest.approx([14.125, 5.875, 1.05625, 2.06875], abs=1e-9)
    assert stiffness(F, 1, 1) == pytest.approx(3.925)
    assert stiffness(F, 1, -1) == pytest.approx(-0.8)  # an inner contact: harmless
    assert verdict.laws == ["newton"]


def check_no_motion(posture, found):
    q, qdot = np.array(found["q"]), np.array(found["qdot"])
    for factor in (1.0, 0.5, 1e-3):
        run = sf.simulate(
            posture, q * factor**2, qdot * factor, model="local", impact="newton"
        )
        assert (run.outcome, run.elapsed, len(run.impacts)) == ("inconsistent", 0, 0)


def test_two_runs_of_the_reference():
    """A comes to rest from its ray 23; C escapes on its ray 13, on contacts 1 and 3."""
    down = next(z for i, j, z in rays(A) if (i, j) == (1, 2))
    start = down * [1, 1, 1 / 0.6]
    qdot = (-0.0034653195, -0.0010107182, 0.0017326597 / 0.6)
    run = sf.simulate(A, start, qdot, model="local", impact="newton")
    assert run.outcome == "rest"
    assert run.elapsed == pytest.approx(7.2620, abs=1e-4)
    assert np.abs(run.q).max() < 1e-9
    down = next(z for i, j, z in rays(C) if (i, j) == (0, 2))
    start = down * [1, 1, 1 / 0.4]
    run = sf.simulate(
        C,
        start,
        (0.0012678697, -0.0011961035, -0.0004784414 / 0.4),
        model="local",
        neighbourhood=100.0,
        impact="newton",
    )
    assert run.outcome == "escape"
    assert {int(c) for c in run.impacts["contact"]} == {1, 3}


#: Energy of a start per unit mass, in J/kg. The local model has no scale; at this one its displacements are far above the gaps, 1e-12 of the
#: size of the body, that count as touching.
ENERGY = 1e-2
#: Factor for the velocities of kicks in the full model, which have to be small.
SMALL = 1e-3


def starts(posture, found, rng, count):
    """Displacements in the cone of free motions, half of them zero, and velocities, all with the energy ½(ẋ² + ẏ² + ρ²θ̇²) + g y = ENERGY
    per unit mass (or −ENERGY where it is negative)."""
    rho = np.array([1, 1, 1 / posture.gyration_radius])
    weights = rng.exponential(0.1, (count, len(found))) * rng.integers(0, 2, (count, 1))
    q = weights @ np.array([z for *_, z in found])
    qdot = rng.normal(0, 1, (count, 3))
    energy = 0.5 * np.sum(qdot**2, axis=1) + 9.81 * q[:, 1]
    scale = (ENERGY / np.abs(energy))[:, None]
    return q * scale * rho, qdot * np.sqrt(scale) * rho


def laws_of(verdict):
    options = {"newton": {}, "poisson": {"impact": "poisson"}}
    options["stronge"] = {"impact": "stronge"}
    return [options[law] for law in verdict.laws if law in options]


def test_verdicts_on_random_bodies_are_those_of_the_rays(record_property):
    rng, counts = np.random.default_rng(5), collections.Counter()
    ended = collections.Counter()
    for _ in range(POSTURES):
        posture = draw_feet(rng, int(rng.choice([3, 4, 6])), rng.choice([0.4, 1.2]))
        verdict, found = sf.stability(posture), rays(posture)
        counts[verdict.frictional_stability, verdict.by or verdict.reason] += 1
        assert found, posture
        lacks = jams(posture, found)
        wide = width(found)
        if verdict.by == "no-solution":
            places = tuple(k - 1 for k in verdict.evidence["contacts"])
            assert (places, verdict.evidence["slides"]) in lacks
            check_no_motion(posture, verdict.evidence)
            continue
        assert not lacks, posture
        assert verdict.stays == (wide > 0)
        assert (verdict.by == "well") == (wide > 0)
        if verdict.stays:
            assert verdict.evidence["width"] == pytest.approx(wide, rel=1e-9)
        if verdict.frictional_stability == "stable":
            check_rest(posture, verdict, found, rng, ended)
        elif verdict.by == "descending-pair":
            [pair] = verdict.evidence["pairs"]
            if pair["by"] == "growing-cycle":
                check_growth(posture, pair, found)
    record_property("verdicts", dict(counts))
    print(counts, ended)
    assert counts["stable", "well"] > POSTURES / 6
    late = ended["event-limit"] + ended["ambiguous"]
    assert late <= (0.4 if EVENTS >= 5000 else 0.8) * ended.total()


def check_rest(posture, verdict, found, rng, ended):
    """Kicked bodies come to rest, in a well within its radius, under each law that the verdict covers. Several modes may be consistent on the
    way: then the run ends, and the verdict holds for each of them."""
    q, qdot = starts(posture, found, rng, KICKS)
    most = verdict.radius(ENERGY) * (1 + 1e-9) if verdict.stays else 1e5 * ENERGY
    full = {"model": "full", "q": (0, 0, 0), "qdot": SMALL * qdot}
    for options in [*laws_of(verdict), full]:
        options = {"model": "local", "impact": "newton", "q": q, "qdot": qdot} | options
        runs = sf.simulate_many(
            posture,
            event_limit=EVENTS,
            neighbourhood=math.sqrt(2) * most,  # of √(x² + y²)
            record=False,
            **options,
        )
        ended.update(runs.outcome.tolist())
        rested = np.isin(runs.outcome, ("rest", "event-limit", "ambiguous"))
        assert np.all(rested), (posture, options, set(runs.outcome))
        if verdict.stays and options["model"] == "local":
            rho = np.array([1, 1, posture.gyration_radius])
            assert np.abs(runs.q * rho).max() <= most
            # Energy never rises: also where impacts accumulate that are followed one by one until the limit of events.
            left = 0.5 * np.sum((runs.qdot * rho) ** 2, axis=1) + 9.81 * runs.q[:, 1]
            assert left.max() <= ENERGY * (1 + 1e-9)


def check_growth(posture, pair, found):
    """From a start far down the ray, the cycle of the pair never brings another contact to the ground."""
    i, j = (k - 1 for k in pair["contacts"])
    [down] = [z for a, b, z in found if (a, b) == (i, j)]
    assert down[1] < 0
    rho = posture.gyration_radius
    rng = np.random.default_rng(1)
    grown = []
    for _ in range(10):
        qdot = rng.normal(0, 1e-4, 3)
        run = sf.simulate(
            posture,
            down * [1, 1, 1 / rho],
            qdot * [1, 1, 1 / rho],
            model="local",
            neighbourhood=1.5,
            event_limit=3000,
            impact="newton",
        )
        assert {int(c) for c in run.impacts["contact"]} <= {i + 1, j + 1}
        grown.append(run.outcome)
    assert "escape" in grown or "event-limit" in grown


def test_no_motion_leaves_a_well_under_four_laws(record_property):
    """Kicked bodies in wells stay within the radius for their energy, which never rises. (They may still bounce at the limit of events.)"""
    rng, wells, count = np.random.default_rng(8), 0, collections.Counter()
    laws = ("newton", "poisson", "stronge", "moreau")
    while wells < WELLS:
        body = draw_feet(rng, int(rng.integers(3, 7)))
        equal = {
            f"contacts.{k}.tangential_restitution": body.restitution
            for k in range(1, len(body.contacts) + 1)
        }
        posture = body.replace(**equal)
        verdict = sf.stability(posture)
        if verdict.by != "well" or verdict.laws != list(laws):
            continue
        wells += 1
        q, qdot = starts(posture, rays(posture), rng, RUNS)
        most = verdict.radius(ENERGY) * (1 + 1e-9)
        rho = np.array([1, 1, posture.gyration_radius])
        for law in laws:
            runs = sf.simulate_many(
                posture,
                q,
                qdot,
                model="local",
                impact=law,
                event_limit=300,
                neighbourhood=math.sqrt(2) * most,
                record=False,
            )
            count.update(runs.outcome.tolist())
            assert "escape" not in runs.outcome, (posture, law)
            assert "inconsistent" not in runs.outcome, (posture, law)
            assert np.abs(runs.q * rho).max() <= most, (posture, law)
            left = 0.5 * np.sum((runs.qdot * rho) ** 2, axis=1) + 9.81 * runs.q[:, 1]
            assert left.max() <= ENERGY * (1 + 1e-9), (posture, law)
    record_property("outcomes", dict(count))
    print(count)


def test_planted_errors_are_caught():
    """Were the checks of jams, of the well or of friction at all contacts left out, kicks would contradict the verdict."""
    rng, wrong = np.random.default_rng(10), collections.Counter()
    while min(wrong["jam"], wrong["no well"]) < 2:
        posture = draw_feet(rng, int(rng.choice([3, 4])))
        verdict = sf.stability(posture)
        if verdict.by == "no-solution" and verdict.stays:
            wrong["jam"] += 1
            check_no_motion(posture, verdict.evidence)
        elif verdict.by == "descending-pair" and not verdict.stays:
            q, qdot = starts(posture, rays(posture), rng, 100)
            options = {"model": "local", "neighbourhood": 100.0, "event_limit": 3000}
            runs = sf.simulate_many(posture, q, qdot, **options, impact="newton")
            wrong["no well"] += "escape" in runs.outcome
    level = feet([(-1, 0), (0, 0), (1, 0)], [0] * 3, [0.5, 0, 0.5], (0, 1), 1, 0.5)
    runs = sf.simulate_many(
        level, (0, 0, 0), rng.normal(0, 1e-3, (50, 3)), impact="newton"
    )
    assert "rest" not in runs.outcome


def least_rise(normals):
    """min y over N q ≥ 0, max(|x|, |y|, ρ|θ|) = 1, by a linear programme on each face of the cube."""
    values = []
    for axis, side in itertools.product(range(3), (1, -1)):
        bounds = [(-1, 1)] * 3
        bounds[axis] = (side, side)
        found = linprog(
            [0, 1, 0], A_ub=-normals, b_ub=np.zeros(len(normals)), bounds=bounds
        )
        if found.success:
            values.append(found.fun)
    return min(values)


def test_the_least_rise_agrees_with_linear_programmes():
    rng, seen = np.random.default_rng(6), set()
    for _ in range(POSTURES):
        posture = draw_feet(rng, int(rng.integers(3, 7)))
        least = least_rise(scaled_rows(posture)[0])
        verdict = sf.stability(posture)
        assert verdict.stays == (least > 0)
        if verdict.by == "well":
            assert verdict.evidence["width"] == pytest.approx(least, rel=1e-7)
        seen.add(verdict.stays)
    assert seen == {True, False}


def test_a_uniform_box_stands_on_level_ground_unless_a_corner_jams():
    """Stable iff μ < (4/3)(w/h) + (1/3)(h/w), for every restitution."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        w, h, friction = [*rng.uniform(0.2, 2, 2).tolist(), rng.uniform(0.1, 4)]
        box = sf.Posture.box(w, h, friction=friction, restitution=rng.uniform(0, 0.99))
        jam = friction > 4 / 3 * w / h + h / w / 3
        verdict = sf.stability(box)
        assert verdict.frictional_stability == ("unstable" if jam else "stable")
        if jam:
            assert verdict.by == "no-solution"


def test_a_rod_is_stable_where_clattering_does_not_converge():
    rod = sf.Posture.rod(0.5, 0.45, 0.6, friction=0.5)
    verdict = sf.stability(rod)
    assert not verdict.clattering
    assert (verdict.frictional_stability, verdict.by) == ("stable", "neutral")
    runs = sf.stability(rod, trials=200).trials
    assert runs["rest"] == 200


def test_a_mirrored_pair_is_neutral_only_exactly():
    """A V that is its own mirror image: both contacts slide together along a level line. A little beside it they do not."""
    for x, by in ((0.0, "neutral"), (0.003, None)):
        found = sf.stability(
            feet([(-1, 0.2), (1, 0.2)], [-0.3, 0.3], [0.5, 0.5], (x, 0.9), 0.9, 0.9)
        )
        assert (found.by == "neutral") == (by == "neutral")


def test_one_contact_and_none():
    foot = sf.Contact((0, 0), friction=0.5)
    assert sf.stability(sf.Posture(1, 0.5, (0.1, 1), [foot], 0)).by == "not-equilibrium"
    verdict = sf.stability(sf.Posture(1, 0.5, (0, 1), [foot], 0))
    assert (verdict.frictional_stability, verdict.by) == ("unstable", "single-support")
    sf.certificate.check(verdict.certificate())
    # The velocity moves neither the foot along its ground nor off it.
    assert verdict.evidence == {"word": "F", "velocity": [-1.0, 0.0, 1.0]}
    hangs = sf.Posture(1, 0.5, (0, -1), [foot], 0)
    assert sf.stability(hangs).frictional_stability == "undecided"
    disc = sf.Posture.disc(0.1, friction=0.5)
    assert sf.stability(disc).by == "single-support"
    high = sf.Posture(
        1, 0.5, (0, 1), [sf.Contact((0, 0.5))], 0, terrain=[(-1, 0), (1, 0)]
    )
    with pytest.raises(ValueError, match=r"contacts = \[1 contacts, none"):
        sf.stability(high)


def test_a_frictionless_middle_foot_may_carry_everything():
    """Level ground with a contact without friction is not decided by energy."""
    level = feet([(-1, 0), (0, 0), (1, 0)], [0] * 3, [0.5, 0, 0.5], (0, 1), 1, 0.5)
    verdict = sf.stability(level)
    assert (verdict.frictional_stability, verdict.reason) == ("undecided", "degenerate")


def test_the_table_shows_the_rays():
    text = str(sf.stability(B))
    assert "rays (two contacts stay closed" in text
    assert "descends" in text
    assert "holds it: unstable, by growing-cycle" in text
    assert "stays" in str(sf.stability(A))


@pytest.mark.parametrize(
    ("width", "height", "friction"), [(0.5, 1, 0.5), (1, 1, 1), (0.3, 0.5, 0.6)]
)
def test_a_box_whose_slide_is_a_tie(width, height, friction):
    """μh = w: while the box slides, its rear edge carries exactly nothing. Sliding on both edges and on one of them is the same motion."""
    box = sf.Posture.box(width, height, friction=friction, restitution=0.3)
    verdict = sf.stability(box)
    assert (verdict.frictional_stability, verdict.by) == ("stable", "neutral")
    assert not verdict.delicate
    sf.certificate.check(verdict.certificate())
    run = sf.simulate(box, (0, 0, 0), (0.1, 0, 0), model="local", impact="newton")
    assert run.outcome == "rest"
