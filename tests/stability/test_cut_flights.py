"""Long flights at large restitution: verdicts that hold whatever follows where the flight is cut, and for all scenes within the width.
STANDFAST_CUT sets the number of postures (60), STANDFAST_MOVED that of the postures that are moved (150)."""

import collections
import math
import os
from fractions import Fraction

import numpy as np
import pytest
import standfast as sf
from bodies import paper_vee, stance
from corners import corner_kick, rows_of
from standfast.certificate.corners import Cell, Corners
from standfast.certificate.intervals import Interval
from standfast.certificate.scene import body_of
from standfast.certificate_maker import scene

POSTURES = int(os.environ.get("STANDFAST_CUT", "60"))
MOVED = int(os.environ.get("STANDFAST_MOVED", "150"))
KICKS = 200
EVENTS = 100_000
WIDTH = 1e-12


def draw(rng, low=0.7, high=0.95):
    """A posture on two contacts of any slopes below 45 degrees, with its centre of mass over the equilibrium region."""
    while True:
        slopes = rng.uniform(-0.8, 0.8, 2)
        contacts = [
            sf.Contact((-1, 0), float(slopes[0]), rng.uniform(0.1, 1)),
            sf.Contact((1, rng.uniform(-0.5, 0.5)), float(slopes[1]), rng.uniform(0.1, 1)),
        ]  # fmt: skip
        rho, e = rng.uniform(0.3, 1.2), rng.uniform(low, high)
        height = rng.uniform(-0.5, 2)
        region = sf.equilibrium_region(stance(contacts, (0, height), rho, e))
        if region is None or min(region[1], 3) - max(region[0], -3) < 1e-3:
            continue
        x = rng.uniform(max(region[0], -3), min(region[1], 3))
        return stance(contacts, (x, height), rho, e, 9.81)


def starts(posture, rng, count):
    """Starts as at the ends of cut flights: one contact slides or is at rest, and the other one has a rate that is smaller by up to 1e-12;
    and corners in random directions."""
    normals, tangents, _ = rows_of(posture)
    found = []
    for k in range(count):
        if k % 4 == 0:
            phi = rng.uniform(-math.pi / 2, math.pi / 2)
            found.append(corner_kick(posture, k // 4 % 2, phi))
            continue
        held = k % 2
        slip = rng.choice([0.0, 1.0, -1.0]) * rng.uniform(0.1, 1)
        rate = rng.choice([1.0, -1.0]) * 10.0 ** rng.uniform(-12, 0)
        system = [normals[held], tangents[held], normals[1 - held]]
        found.append(np.linalg.solve(system, [0.0, slip, rate]))
    return 1e-3 * np.array(found)


def within(posture, rng):
    """A posture whose numbers differ by at most the width."""

    def near(value):
        return float(value) * (1 + WIDTH * rng.uniform(-1, 1))

    center = np.array(posture.center_of_mass)
    contacts = []
    for contact in posture.contacts:
        arm = np.subtract(contact.point, center)
        change = WIDTH * np.hypot(*arm) * rng.uniform(-1, 1, 2)
        contacts.append(
            sf.Contact(tuple(center + arm + change), near(contact.slope), near(contact.friction))
        )  # fmt: skip
    return sf.Posture(
        posture.mass,
        near(posture.gyration_radius),
        tuple(center),
        contacts,
        near(posture.restitution),
        posture.gravity,
    )


def check_trap(posture, evidence, rng):
    """From a corner of a trap the motion grows, or goes away."""
    _, tangents, both = rows_of(posture)
    unit = math.sqrt(both @ (np.array([1, 1, posture.gyration_radius**2]) * both))
    outcomes = collections.Counter()
    for part in evidence:
        lands = part["contact"] - 1
        low, high = (math.atan(float(end)) for end in part["slope"])
        alpha = tangents[1 - lands] @ both / unit
        slip = alpha * math.tan(rng.uniform(low, high))
        phi = math.atan(slip / (tangents[1 - lands] @ both))
        kick = 1e-6 * corner_kick(posture, lands, phi)
        run = sf.simulate(
            within(posture, rng), (0, 0, 0), kick, model="local", impact="newton",
            event_limit=4000, neighbourhood=1.0, record=False,
        )  # fmt: skip
        start = np.linalg.norm(kick * [1, 1, posture.gyration_radius])
        grown = np.linalg.norm(run.qdot * [1, 1, posture.gyration_radius]) / start
        outcomes["rest" if run.outcome == "rest" else "away" if grown > 10 or run.outcome == "escape" else "still on"] += 1  # fmt: skip
    return outcomes


def test_nothing_contradicts_a_verdict_at_large_restitution(record_property):
    rng = np.random.default_rng(65)
    found, traps, events = (collections.Counter() for _ in range(3))
    for _ in range(POSTURES):
        posture = draw(rng)
        verdict = sf.stability(posture)
        found[verdict.frictional_stability, verdict.by] += 1
        if verdict.frictional_stability == "stable":
            first = starts(posture, rng, KICKS)
            runs = sf.simulate_many(
                [within(posture, rng) for _ in first], np.zeros_like(first), first,
                model="local", event_limit=EVENTS, impact="newton",
            )  # fmt: skip
            outcomes = collections.Counter(map(str, runs.outcome))
            assert outcomes["rest"] + outcomes["event-limit"] == KICKS, (
                posture,
                outcomes,
            )
            # A proof of stability does not bound the number of events: a contact may bounce very often while the other one slides.
            metric = np.array([1, 1, posture.gyration_radius])
            sizes = [np.linalg.norm(x * metric, axis=1) for x in (runs.qdot, first)]
            bound = verdict.amplification or 1e3
            assert np.all(sizes[0] <= bound * sizes[1]), posture
            events[outcomes["event-limit"] > 0] += 1
        elif verdict.by == "growing-trap":
            traps += check_trap(posture, verdict.evidence, rng)
    for k in range(20):
        posture = paper_vee(0.05 * (k - 10), 2.7, 0.8, 0.8)
        verdict = sf.stability(posture)
        found["V", verdict.by] += 1
        if verdict.by == "growing-trap":
            traps += check_trap(posture, verdict.evidence, rng)
    text = f"{POSTURES} postures with {KICKS} kicks: {dict(found)}; in traps: {dict(traps)}; postures with a run at the event limit: {events[True]}"
    print(f"\n{text}")
    record_property("cut_flights", text)
    assert traps["away"] > 0
    assert traps["rest"] == 0


def moved(posture, shift, factor, swap):
    """The same posture elsewhere, in another unit of length, and with its contacts in the other order."""
    contacts = [
        sf.Contact(
            tuple(factor * np.add(contact.point, shift)), contact.slope, contact.friction
        )
        for contact in posture.contacts
    ]  # fmt: skip
    return sf.Posture(
        posture.mass,
        factor * posture.gyration_radius,
        tuple(factor * np.add(posture.center_of_mass, shift)),
        contacts[::-1] if swap else contacts,
        posture.restitution,
        posture.gravity,
    )


@pytest.mark.parametrize("jams", ["none", "impact"])
def test_a_verdict_does_not_depend_on_place_unit_and_order(jams, record_property):
    """No posture is stable here and unstable there; and hardly any is undecided only in one of the two places."""
    rng = np.random.default_rng(66)
    changes = collections.Counter()
    for _ in range(MOVED):
        posture = draw(rng, 0, 0.95)
        own = sf.stability(posture, jams=jams)
        for shift, factor, swap in (((1, 1), 1, False), ((1e3, -1e3), 1, False), ((0, 0), 3, False), ((0.3, 0.1), 1, True)):  # fmt: skip
            other = sf.stability(moved(posture, shift, factor, swap), jams=jams)
            pair = {own.frictional_stability, other.frictional_stability}
            assert pair != {"stable", "unstable"}, (posture, shift, factor)
            changes[len(pair)] += 1
    text = f"{MOVED} postures, jams {jams}: {changes[2]} of {changes.total()} changes"
    print(f"\n{text}")
    record_property("moved", text)
    assert changes[2] <= max(1, 0.003 * changes.total()), text


def test_one_posture_in_400_places():
    """The last speeds of its flights are 1e-9 to 1e-14 of the first: rounding decides which contact rests. It has one verdict."""
    rng = np.random.default_rng(67)
    posture = delicate_posture()
    decisions = collections.Counter()
    for _ in range(400):
        other = moved(posture, rng.uniform(-1, 1, 2), 1, False)
        verdict = sf.stability(other, jams="impact")
        decisions[verdict.frictional_stability, verdict.delicate] += 1
    assert len({stability for stability, _ in decisions}) == 1, decisions


def delicate_posture():
    """A posture at e = .8 whose flights are long."""
    rng = np.random.default_rng(2)
    while True:
        posture = draw(rng, 0.8, 0.8000001)
        verdict = sf.stability(posture, jams="impact")
        if verdict.delicate:
            return posture


def test_a_wider_width_decides_less_and_never_the_opposite():
    rng = np.random.default_rng(68)
    counts = collections.Counter()
    for _ in range(60):
        posture = draw(rng, 0, 0.7)
        verdicts = [sf.stability(posture, width=w) for w in (0, 1e-12, 1e-6, 1e-3)]
        assert [v.width for v in verdicts] == [0, 1e-12, 1e-6, 1e-3]
        decided = [v.frictional_stability for v in verdicts]
        assert not {"stable", "unstable"} <= set(decided), (posture, decided)
        counts.update(k for k, d in enumerate(decided) if d != "undecided")
    assert counts[3] >= 20, counts
    assert counts[0] >= counts[3]


def growth_once_around(posture, cycle):
    """ln r'/r once around a cycle, by the map of the checker of certificates in numbers of 256 bits."""
    corners = Corners(body_of(scene(posture, [1, 2])))
    j, total = cycle[0]["contact"] - 1, 0.0
    at = Interval.of(Fraction(math.tan(cycle[0]["phi"]))) / corners.alpha[1 - j]
    for _ in cycle:
        cell = Cell.between(at.lo, at.lo)
        [image] = corners.images(j, cell)
        before = cell.xi.square() + cell.y.square()
        total += math.log(Fraction(image.square.hi, before.hi)) / 2
        j, at = image.contact, Interval(image.low, image.high)
    return total


def test_the_growth_shown_is_proved():
    """The sum of the growths of a cycle is a lower bound, and it has all its digits."""
    found = 0
    for x in np.linspace(-0.9, 0.9, 13):
        for restitution in (0.5, 0.7):
            posture = paper_vee(x, 2.9, 0.8, restitution)
            verdict = sf.stability(posture)
            if verdict.by != "growing-cycle":
                continue
            shown = sum(corner["growth"] for corner in verdict.evidence)
            exact = growth_once_around(posture, verdict.evidence)
            # The angle that is shown has an error of 1e-9.
            assert 0 < shown < exact + 1e-7, posture
            assert shown == pytest.approx(exact, abs=1e-4), posture
            found += 1
    assert found >= 5


def test_without_friction_a_larger_width_is_not_called_a_border():
    """The centre of mass is in the middle; that forces hold the rod is a closed form, which counts with the default width only."""
    rod = sf.Posture.rod(0.5, gyration_radius=0.2, restitution=0.1)
    assert sf.stability(rod, width=1e-3).reason == "degenerate"
    assert sf.stability(rod).equilibrium


@pytest.mark.parametrize("width", [-1e-3, 0.2, math.nan, math.inf])
def test_a_width_out_of_its_range_is_refused(width):
    posture = draw(np.random.default_rng(1))
    with pytest.raises(ValueError, match=r"width = .*0 <= width <= 0\.1"):
        sf.stability(posture, width=width)
    with pytest.raises(ValueError, match=r"width = .*0 <= width <= 0\.1"):
        sf.sweep(posture, over={"restitution": [0.1]}, width=width)
