"""Verdicts on joints under torques: two feet whose four rows are independent."""

import os

import numpy as np
import pytest
import standfast as sf
from two_feet import TwoFeet

#: Number of mechanisms that are kicked; each gets ten kicks. `make long-joints` sets more.
KICKED = int(os.environ.get("STANDFAST_JOINTS", "60"))


def bipeds(count, restitution):
    """Trunk and two straight legs under torques in the middle of those that hold it; None where none do."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        q = [
            0,
            0,
            rng.uniform(-0.3, 0.3),
            rng.uniform(-0.9, -0.1),
            rng.uniform(0.1, 0.9),
        ]
        slopes, friction = rng.uniform(-0.4, 0.4, 2), rng.uniform(0.3, 0.9)

        def robot(torques, slopes=slopes, friction=friction):
            leg = sf.Link(mass=1, inertia=1 / 12, length=1)
            hips = [
                sf.Joint("torque", torque=t, parent=1, at=0, angle=-np.pi / 2)
                for t in torques
            ]
            feet = [sf.Foot(k + 2, slope=slopes[k], friction=friction) for k in (0, 1)]
            links = [sf.Link(mass=10, inertia=0.4, length=1, center=0), leg, leg]
            return sf.Chain(
                links=links, joints=hips, feet=feet, restitution=restitution
            )

        held = robot((0, 0)).holding_torques(q)
        if held is None or held.torques is None:
            yield None
            continue
        line, torques = np.array(held.internal_torques).reshape(-1), held.torques
        k = int(np.argmax(abs(line)))
        middle = np.mean(held.torque_interval[k])
        torques = torques + line * ((middle - torques[k]) / line[k])
        yield robot(torques).mechanism(q)


def rows_apart(rng, restitution, mixed=0.7):
    """A mechanism of four coordinates whose four rows are near the axes, held by forces near the middle of the cones."""
    rows = np.eye(4) + rng.uniform(0, mixed) * rng.uniform(-1, 1, (4, 4))
    forces = rng.uniform([-0.3, 0.5] * 2, [0.3, 1.5] * 2)
    feet = [
        sf.ContactRows(rows[2 * i + 1], rows[2 * i], friction=rng.uniform(0.2, 0.9))
        for i in (0, 1)
    ]
    return sf.Mechanism(np.eye(4), -rows.T @ forces, feet, restitution=restitution)


def oracle(mechanism):
    space = mechanism.contact_space
    friction = [foot.friction for foot in mechanism.contacts]
    return TwoFeet(space.W, space.b, friction, [mechanism.restitution] * 2)


def kicks(rng, count):
    for _ in range(count):
        h = np.maximum(rng.uniform(-1, 1, 2), 0) * 10 ** rng.uniform(-2, 0)
        u = np.where(h > 0, rng.uniform(-1, 1, 2), np.maximum(rng.uniform(-1, 1, 2), 0))
        yield h, u, rng.uniform(-1, 1, 2) * 10 ** rng.uniform(-1, 1)


def test_most_bipeds_under_torques_are_decided():
    for restitution, least in ((0.0, 0.86), (0.5, 0.86), (0.8, 0.84)):
        words = [sf.stability(m).by for m in bipeds(300, restitution) if m is not None]
        open_ = [w for w in words if w in (None, "bounded-corners")]
        assert len(open_) > 100
        assert sum(w is not None for w in open_) >= least * len(open_)


def test_stable_ones_come_to_rest_from_every_kick():
    """The conditions hold in plain floats, and an independent simulator follows every kick to rest."""
    rng = np.random.default_rng(1)
    stable = 0
    while stable < KICKED:
        mechanism = rows_apart(rng, rng.choice([0.0, 0.3, 0.6, 0.8]))
        verdict = sf.stability(mechanism)
        if verdict.by != "bounded-corners":
            continue
        stable += 1
        assert verdict.evidence["growth"] < 1
        assert verdict.amplification_reason == "joints"
        two = oracle(mechanism)
        assert two.presses()
        assert two.goes_on()
        assert two.stays()
        for start in kicks(rng, 10):
            assert two.run(*start) == "rest", (mechanism, start)


#: One contact slides on the ground, either way, and the other one is in the air.
ALONE = [
    (h, (0.0, 0.0), v)
    for h, v in (
        ((0, 1), (1, 0)),
        ((0, 1), (-1, 0)),
        ((1, 0), (0, 1)),
        ((1, 0), (0, -1)),
    )
]


@pytest.mark.parametrize("left_out", ["presses", "stays", "stops"])
def test_each_condition_is_needed(left_out):
    """Where one condition fails, some mechanism does not come to rest: without it the theorem would be wrong, and the attack finds it."""
    rng = np.random.default_rng(2)
    others = {
        "presses": [],
        "stays": ["presses"],
        "stops": ["presses", "stays"],
    }[left_out]
    for _ in range(2000):
        mechanism = rows_apart(rng, 0.3, 2.0)
        two = oracle(mechanism)
        if getattr(two, left_out)() or not all(getattr(two, name)() for name in others):
            continue
        ends = {two.run(*start, events=300) for start in [*ALONE, *kicks(rng, 6)]}
        if ends - {"rest", "long"}:
            assert sf.stability(mechanism).frictional_stability != "stable", ends
            return
    pytest.fail("nothing fails without it")


def spectator(mechanism, at, coupling=0.0):
    """The same with one more coordinate, which no contact feels."""
    n = mechanism.dof
    mass = np.insert(np.insert(mechanism.mass_matrix, at, 0.0, 0), at, 0.0, 1)
    mass[at, at] = 2.0
    turn = np.eye(n + 1)
    others = [k for k in range(n + 1) if k != at]
    turn[at, others[-1]] = coupling
    feet = [
        sf.ContactRows(
            turn.T @ np.insert(foot.normal, at, 0.0),
            turn.T @ np.insert(foot.tangential, at, 0.0),
            friction=foot.friction,
        )
        for foot in mechanism.contacts
    ]
    load = turn.T @ np.insert(mechanism.load, at, 0.0)
    mass = turn.T @ mass @ turn
    return sf.Mechanism(
        0.5 * (mass + mass.T), load, feet, restitution=mechanism.restitution
    )


@pytest.mark.parametrize("feet", [2, 3])
def test_a_spectator_changes_no_verdict(feet):
    rng = np.random.default_rng(3)
    decided = 0
    for _ in range(100):
        places = np.sort(rng.uniform(-1, 1, feet))
        contacts = [
            sf.Contact(
                (x, 0), slope=rng.uniform(-0.5, 0.5), friction=rng.uniform(0.3, 0.9)
            )
            for x in places
        ]
        body = sf.Mechanism.of_posture(
            sf.Posture(
                mass=1.5,
                gyration_radius=rng.uniform(0.2, 1),
                center_of_mass=(rng.uniform(-0.4, 0.4), rng.uniform(0.2, 1)),
                contacts=contacts,
                restitution=rng.uniform(0, 0.6),
            )
        )
        verdict = sf.stability(body)
        decided += verdict.by is not None
        more = sf.stability(spectator(body, rng.integers(0, 4)))
        assert (more.by, more.reason, more.free_motion) == (
            verdict.by,
            verdict.reason,
            1,
        )
        if feet == 2 and verdict.by is not None:
            # A spectator that moves with the last coordinate: the contacts still feel three coordinates.
            coupled = sf.stability(spectator(body, 3, coupling=0.4))
            assert (coupled.by, coupled.free_motion) == (verdict.by, 1)
    assert decided > 50
