"""Three and more feet on one line of ground: the inner ones are carried by the outer pair."""

import math
import os

import numpy as np
import pytest
import standfast as sf

#: Number of stable lines of feet that are kicked, 20 times each.
KICKED = int(os.environ.get("STANDFAST_LINES", "25"))


def line(rng, count, restitution, more=()):
    """Feet on a slope, at random places along it."""
    slope = rng.uniform(-0.5, 0.5)
    friction = rng.uniform(0.4, 1.0)
    places = np.sort(rng.uniform(-1, 1, count))
    along = np.array([math.cos(slope), math.sin(slope)])
    feet = [
        sf.Contact(tuple(x * along), slope=slope, friction=friction) for x in places
    ]
    return sf.Posture(
        mass=1,
        gyration_radius=rng.uniform(0.15, 1.2),
        center_of_mass=(rng.uniform(-0.7, 0.7), rng.uniform(0.2, 1.5)),
        contacts=[*feet, *more],
        restitution=restitution,
    )


def kicked(posture, rng):
    """A small kick that opens no gap backwards."""
    outer = [posture.contacts[0], posture.contacts[-1]]
    rates = rng.uniform(0, 1, 2) * 10 ** rng.uniform(-2, 0)
    c = np.array(posture.center_of_mass)
    rows = [
        [
            -math.sin(k.slope),
            math.cos(k.slope),
            (np.array(k.point) - c) @ [math.cos(k.slope), math.sin(k.slope)],
        ]
        for k in outer
    ]
    rows.append([math.cos(outer[0].slope), math.sin(outer[0].slope), 0.0])
    q = np.linalg.solve(rows, [*rates, rng.uniform(-1, 1)])
    return 1e-3 * q


def run(posture, kick, **options):
    return sf.simulate(
        posture,
        (0, 0, 0),
        kick,
        impact="newton",
        simultaneous="together",
        model="local",
        event_limit=20_000,
        **options,
    )


def test_stable_lines_come_to_rest():
    rng = np.random.default_rng(1)
    stable = 0
    while stable < KICKED:
        posture = line(rng, rng.integers(3, 6), rng.choice([0.0, 0.3, 0.6]))
        verdict = sf.stability(posture)
        if verdict.frictional_stability != "stable":
            continue
        stable += 1
        (pair,) = verdict.pairs
        assert pair.contacts == [1, len(posture.contacts)]
        for _ in range(20):
            kick = kicked(posture, rng)
            end = run(posture, kick)
            assert end.outcome == "rest", (posture, kick)


def with_feet(posture, places):
    return sf.Posture(
        mass=posture.mass,
        gyration_radius=posture.gyration_radius,
        center_of_mass=posture.center_of_mass,
        contacts=[posture.contacts[k] for k in places],
        restitution=posture.restitution,
    )


def test_lines_are_decided_like_their_outer_pairs():
    """Almost as many are open, and no verdict is the opposite one but where impacts at the inner foot change the motion."""
    rng = np.random.default_rng(2)
    left = {"line": 0, "pair": 0}
    for _ in range(600):
        posture = line(rng, 3, 0.4)
        whole, pair = sf.stability(posture), sf.stability(with_feet(posture, [0, 2]))
        left["line"] += whole.by is None
        left["pair"] += pair.by is None
        assert (whole.by == "not-equilibrium") == (pair.by == "not-equilibrium")
    assert left["line"] <= left["pair"] + 6, left


def test_inner_feet_change_verdicts():
    """Where the verdict on the outer pair alone is the opposite one, motions with all feet follow the verdict on the line."""
    rng = np.random.default_rng(11)
    found = {"stable": 0, "unstable": 0}
    while min(found.values()) < 1:
        posture = line(rng, 3, rng.choice([0.7, 0.8, 0.9]))
        whole, pair = sf.stability(posture), sf.stability(with_feet(posture, [0, 2]))
        words = {whole.frictional_stability, pair.frictional_stability}
        if words != {"stable", "unstable"} or whole.by == "not-equilibrium":
            continue
        found[whole.frictional_stability] += 1
        kicks = [kicked(posture, rng) for _ in range(40)]
        ends = {run(posture, kick).outcome for kick in kicks}
        assert (ends == {"rest"}) == (whole.frictional_stability == "stable"), (
            posture,
            ends,
        )
        alone = {run(with_feet(posture, [0, 2]), kick).outcome for kick in kicks}
        assert (alone == {"rest"}) == (pair.frictional_stability == "stable"), (
            posture,
            alone,
        )


def test_feet_that_differ_are_no_line():
    feet = [
        sf.Contact((x, 0.3 * x), slope=math.atan(0.3), friction=mu)
        for x, mu in ((-0.5, 0.8), (0, 0.6), (0.5, 0.8))
    ]
    posture = sf.Posture(
        mass=1,
        gyration_radius=0.4,
        center_of_mass=(0, 0.5),
        contacts=feet,
        restitution=0.2,
    )
    assert sf.stability(posture).reason == "degenerate"


def test_a_line_beside_a_wall():
    """Three feet on a slope and a hand at a wall: as with the outer feet alone."""
    rng = np.random.default_rng(4)
    hand = sf.Contact((1.2, 1.0), slope=math.pi / 2, friction=0.5)
    decided = 0
    for _ in range(60):
        posture = line(rng, 3, 0.2, more=[hand])
        verdict = sf.stability(posture)
        two = sf.stability(with_feet(posture, [0, 2, 3]))
        if verdict.by == two.by:
            decided += verdict.by is not None
        assert {verdict.frictional_stability, two.frictional_stability} != {
            "stable",
            "unstable",
        }
    assert decided > 20


@pytest.mark.parametrize("count", [3, 4])
def test_a_line_may_be_given_in_any_order(count):
    rng = np.random.default_rng(5)
    for _ in range(30):
        posture = line(rng, count, 0.5)
        order = rng.permutation(count)
        other = with_feet(posture, order)
        assert sf.stability(posture).by == sf.stability(other).by


def test_lines_have_certificates():
    """Those that are changed are refused: an inner foot at another place, or with another friction, or left out."""
    rng = np.random.default_rng(6)
    decided = made = 0
    while decided < 30:
        posture = line(rng, 3, rng.choice([0.0, 0.3, 0.6]))
        verdict = sf.stability(posture)
        if verdict.by != "descending-pair":
            continue
        decided += 1
        try:
            certificate = verdict.certificate()
        except ValueError:
            continue
        made += 1
        sf.certificate.check(certificate)
        inner = certificate["scene"]["contacts"][1]
        for key, value in (("friction", 0.1), ("slope", 0.3), ("restitution", 0.01)):
            kept, inner[key] = inner[key], value.hex()
            with pytest.raises(ValueError, match=r"contacts|rays"):
                sf.certificate.check(certificate)
            inner[key] = kept
        inner["point"][0] = (float.fromhex(inner["point"][0]) + 0.001).hex()
        with pytest.raises(ValueError, match=r"contacts|rays"):
            sf.certificate.check(certificate)
    assert made >= 28, made
