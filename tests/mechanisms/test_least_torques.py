"""Torques with the least Σ τ² within the friction cones, in postures where many sides of cones meet in one point.

At the least torques the mechanism cannot be held with less: the change of Σ τ² along each edge of a cone that the base does not feel is not
negative. That is one linear programme, of another library.
"""

import numpy as np
import pytest
import standfast as sf
from scipy.optimize import linprog


def mechanism(normal, tangential, friction, load):
    rows = zip(normal, tangential, friction, strict=True)
    contacts = [sf.ContactRows(n, t, friction=mu) for n, t, mu in rows]
    return sf.Mechanism(np.eye(len(load)), load, contacts)


def degenerate(rng):
    """A random mechanism that forces on the borders of cones, zero at some contacts, hold without torques."""
    n, count = int(rng.integers(2, 8)), int(rng.integers(2, 7))
    whole = rng.random() < 0.5
    normal, tangential = (
        rng.integers(-3, 4, (count, n)) if whole else rng.normal(size=(count, n))
        for _ in "nt"
    )
    friction = rng.choice([0, 0.5, 1], count)
    force = rng.random(count) * (rng.random(count) < 0.5)
    along = friction * force * rng.choice([-1, 0, 1], count)
    load = -(tangential.T @ along + normal.T @ force)
    joints = list(range(n - int(rng.integers(1, n)), n))
    return normal, tangential, friction, load, joints


def random_mechanism(rng):
    normal, tangential, friction, load, joints = degenerate(rng)
    load = load + (0.3 if rng.random() < 0.5 else 3) * np.isin(
        np.arange(len(load)), joints
    ) * rng.normal(size=len(load))
    return normal, tangential, friction, load, joints


def test_of_a_mechanism_that_stands_by_itself_they_are_zero():
    rng, degrees = np.random.default_rng(11), 0
    for _ in range(1500):
        normal, tangential, friction, load, joints = degenerate(rng)
        try:
            made = mechanism(normal, tangential, friction, load)
        except ValueError:  # a row that is zero
            continue
        held = made.holding_torques(joints, choose="least")
        assert np.abs(held.torques).max() < 1e-9
        degrees += held.freedom > 2
    assert degrees > 500


def test_no_edge_of_a_cone_makes_them_less():
    rng, bound = np.random.default_rng(12), 0
    for _ in range(600):
        normal, tangential, friction, load, joints = random_mechanism(rng)
        try:
            made = mechanism(normal, tangential, friction, load)
        except ValueError:
            continue
        held = made.holding_torques(joints, choose="least")
        if held is None:
            continue
        tau, force = held.torques, held.forces
        edges = []
        for side in (1, -1):
            edges += list(side * friction[:, None] * tangential + normal)
        edges = np.array(edges).T
        base = [c for c in range(len(load)) if c not in joints]
        # τ = −load − (columns of edges) a: along da it changes by −columns da.
        cost = -tau @ edges[joints]
        # Multiples a ≥ 0 of the edges now, by f_t and f_n; da ≥ −a, and of any size: at most 1.
        now = []
        for side in (1, -1):
            share = np.where(friction > 0, force[:, 0] / np.where(friction > 0, friction, 1), 0)  # fmt: skip
            now += list((force[:, 1] + side * share) / 2)
        now = np.maximum(np.array(now), 0)
        found = linprog(
            cost,
            A_eq=edges[base] if base else None,
            b_eq=np.zeros(len(base)) if base else None,
            bounds=[(-min(a, 1), 1) for a in now],
        )
        assert found.status == 0
        scale = np.abs(load).max() + np.abs(tau).max()
        assert found.fun > -1e-7 * scale**2, (held, found.fun)
        bound += bool(np.abs(tau).max() > 1e-3 * scale)
    assert bound > 100


def test_the_order_of_contacts_does_not_matter():
    rng = np.random.default_rng(13)
    for _ in range(300):
        normal, tangential, friction, load, joints = random_mechanism(rng)
        try:
            made = mechanism(normal, tangential, friction, load)
        except ValueError:
            continue
        held = made.holding_torques(joints, choose="least")
        order = rng.permutation(len(friction))
        again = made.holding_torques(joints, (order + 1).tolist(), choose="least")
        if held is None:
            assert again is None
            continue
        scale = np.abs(load).max() + np.abs(held.forces).max()
        assert again.torques == pytest.approx(held.torques, abs=1e-9 * scale)
        assert again.forces == pytest.approx(held.forces[order], abs=1e-7 * scale)


@pytest.mark.parametrize("unit", [1, 1e2, 1e4, 1e6])
def test_units_of_joints_may_differ(unit):
    rng = np.random.default_rng(0)
    units = np.array([1, 1, unit])
    tangential, normal = (
        rng.normal(size=(4, 3)) * units,
        rng.normal(size=(4, 3)) * units,
    )
    load = -normal.sum(axis=0)
    made = mechanism(normal, tangential, np.full(4, 0.5), load)
    held = made.holding_torques([1, 2], choose="least")
    assert held.torques / units[1:] == pytest.approx([0, 0], abs=1e-12)


def test_equal_questions_have_equal_answers():
    rng = np.random.default_rng(4)
    normal, tangential, friction, load, joints = degenerate(rng)
    made = mechanism(normal, tangential, friction, load)
    assert made.holding_torques(joints) == made.holding_torques(joints)
    assert made.holding_torques(joints) != mechanism(normal, tangential, friction, 2 * load).holding_torques(joints)  # fmt: skip


@pytest.mark.parametrize(
    ("joints", "why"),
    [
        ([-1], r"joints\.1 = -1 .* from 0 to 3"),
        ([3], r"joints = \[3\] .* locked is coordinate 3"),
        ([2, 2], r"twice there is coordinate 2"),
        ([4], r"joints\.1 = 4 .* from 0 to 3"),
    ],
)
def test_wrong_joints_are_named(joints, why):
    foot = sf.ContactRows([0, 1, 0, 0], [1, 0, 0, 0], friction=0.5)
    made = sf.Mechanism(np.eye(4), [0, -10, 0, 0], [foot], locked=[3])
    with pytest.raises(ValueError, match=why):
        made.holding_torques(joints)
