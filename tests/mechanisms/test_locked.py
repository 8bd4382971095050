"""Robots with all joints locked beside the rigid bodies that they are: 500 random chains through every function that takes both."""

import math

import numpy as np
import pytest
import standfast as sf

#: Rounding errors of the products of some ten links, relative.
CLOSE = 1e-12


def turned(angle, x, y):
    return x * math.cos(angle) - y * math.sin(angle), x * math.sin(
        angle
    ) + y * math.cos(angle)


def random_chain(rng):
    """A trunk with two or three legs of two links, its feet points or discs; its configuration; and the rigid body, built link by link."""
    count = int(rng.integers(2, 4))
    links = [
        sf.Link(rng.uniform(1, 10), rng.uniform(0.1, 1), 0.5, rng.uniform(-0.2, 0.7))
    ]
    joints, feet, angles = [], [], []
    pose = (rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(-0.4, 0.4))
    parts = [(links[0], pose)]
    touching = []
    for leg in range(count):
        at = 0.5 * leg / (count - 1)
        place, parent = pose, 1
        for part in range(2):
            link = sf.Link(
                rng.uniform(0.1, 1), rng.uniform(0.001, 0.05), rng.uniform(0.2, 0.4)
            )
            start = at if part == 0 else links[parent - 1].length
            base = -math.pi / 2 if part == 0 else 0.0
            angle = rng.uniform(-0.6, 0.6)
            dx, dy = turned(place[2], start, 0)
            place = (place[0] + dx, place[1] + dy, place[2] + base + angle)
            joints.append(sf.Joint("locked", parent=parent, at=start, angle=base))
            angles.append(angle)
            links.append(link)
            parts.append((link, place))
            parent = len(links)
        radius = float(rng.choice([0.0, 0.04]))
        slope, mu = rng.uniform(-0.3, 0.3), rng.uniform(0.2, 1.2)
        feet.append(sf.Foot(parent, radius=radius, slope=slope, friction=mu))
        dx, dy = turned(place[2], links[-1].length, 0)
        point = (
            place[0] + dx + radius * math.sin(slope),
            place[1] + dy - radius * math.cos(slope),
        )
        touching.append(sf.Contact(point, slope, mu, radius=radius))
    chain = sf.Chain(links=links, joints=joints, feet=feet, restitution=0.1)
    places = [
        np.add(
            at[:2],
            turned(at[2], link.length / 2 if link.center is None else link.center, 0),
        )
        for link, at in parts
    ]
    masses = np.array([link.mass for link, _ in parts])
    center = masses @ np.array(places) / masses.sum()
    inertia = sum(
        link.inertia + link.mass * ((place - center) ** 2).sum()
        for (link, _), place in zip(parts, places, strict=True)
    )
    body = sf.Posture(
        mass=masses.sum(),
        gyration_radius=math.sqrt(inertia / masses.sum()),
        center_of_mass=center,
        contacts=touching,
        restitution=0.1,
    )
    return chain, [*pose, *angles], body


def same(found, expected, scale=1.0):
    if expected is None:
        assert found is None
        return
    found, expected = np.asarray(found, float), np.asarray(expected, float)
    finite = np.isfinite(expected)
    assert (found[~finite] == expected[~finite]).all()
    assert np.abs(found[finite] - expected[finite]).max(initial=0.0) <= CLOSE * scale


def test_a_locked_chain_is_its_rigid_body():
    rng = np.random.default_rng(20_261_128)
    decided, stable = 0, 0
    for _ in range(500):
        chain, q, body = random_chain(rng)
        mechanism, locked = chain.mechanism(q), chain.posture(q)
        size = np.abs(body.center_of_mass).max() + 2
        same(locked.mass, body.mass, 100)
        same(locked.gyration_radius, body.gyration_radius, 10)
        same(locked.center_of_mass, body.center_of_mass, 10)
        for mine, its in zip(locked.contacts, body.contacts, strict=True):
            same(mine.point, its.point, 10)
            assert (mine.slope, mine.friction, mine.radius) == (
                its.slope,
                its.friction,
                its.radius,
            )
        # The mechanism counts from the near end of its first link.
        own = mechanism.posture()
        for mine, its in zip(own.contacts, body.contacts, strict=True):
            same(mine.point + np.array(q[:2]), its.point, 10)
        region = sf.equilibrium_region(body)
        same(sf.equilibrium_region(locked), region, 100 * size)
        shifted = sf.equilibrium_region(mechanism)
        same(shifted and np.add(shifted, q[0]), region, 100 * size)
        for one in (locked, mechanism):
            same(sf.friction_margin(one), sf.friction_margin(body), 100)
            mine, its = sf.static_forces(one), sf.static_forces(body)
            assert (mine is None) == (its is None)
            if its is not None:
                same(
                    mine, its, 1e4 * (1 + np.abs(np.array(its)[np.isfinite(its)]).max())
                )
            verdict, expected = sf.stability(one), sf.stability(body)
            assert (verdict.frictional_stability, verdict.by, verdict.reason) == (
                expected.frictional_stability,
                expected.by,
                expected.reason,
            )
            same(verdict.equilibrium_margin, expected.equilibrium_margin, 100 * size)
            same(verdict.amplification, expected.amplification, 1e6)
            assert sf.contact_modes(one).consistent == sf.contact_modes(body).consistent
        if expected.by is not None:
            decided += 1
        stable += expected.frictional_stability == "stable"
    assert decided > 250
    assert stable > 50


def test_pushes_kicks_and_certificates_of_locked_chains():
    """The rows of a mechanism do not have the radius of its feet: here the feet are points."""
    rng = np.random.default_rng(5)
    found = 0
    while found < 3:
        chain, q, body = random_chain(rng)
        expected = sf.stability(body)
        round_feet = any(contact.radius for contact in body.contacts)
        if round_feet or expected.frictional_stability != "stable":
            continue
        found += 1
        pushed = {"scan": 4, "at_most": 2 * body.mass, "rtol": 1e-6}
        push = sf.smallest_push(body, **pushed).impulse
        shares = sf.robustness(body, [0.05, 0.3], trials=20).share
        for one in (chain.mechanism(q), chain.posture(q)):
            claim = sf.stability(one).certificate()["claim"]
            assert claim == expected.certificate()["claim"]
            same(sf.smallest_push(one, **pushed).impulse or 0, push or 0, 1e7)
            found_shares = sf.robustness(one, [0.05, 0.3], trials=20).share
            assert (found_shares == shares).all()


def test_a_pinned_chain_is_no_body():
    rod = sf.Link(1, 1 / 12, 1)
    arm = sf.Chain("pinned", [rod, rod], [sf.Joint("torque")] * 2, [sf.Foot(2)])
    with pytest.raises(ValueError, match="base = pinned cannot be used: floating"):
        arm.posture([0, 0.5])


def test_a_round_foot_touches_below_its_centre():
    """A wheel with a motor at the end of a stick: the sliding speed has a part of its radius."""
    radius = 0.3
    stick, wheel = sf.Link(2, 0.5, 1), sf.Link(1, radius**2 / 2, 0.1, center=0)

    def rolling(slope):
        foot = sf.Foot(2, at=0, radius=radius, slope=slope, friction=0.5)
        return sf.Chain(links=[stick, wheel], joints=[sf.Joint("torque")], feet=[foot])

    chain, q = rolling(0.2), [0, 0, -math.pi / 2, 0]
    [_, (axle, _)], [point] = chain.points(q)
    assert axle == pytest.approx([0, -1], abs=1e-15)
    n = np.array([-math.sin(0.2), math.cos(0.2)])
    assert point == pytest.approx(axle - radius * n, abs=1e-15)
    [rows] = chain.mechanism(q).contacts
    # A turn of the wheel alone lifts nothing, and moves its lowest point by its radius.
    assert rows.normal[3] == pytest.approx(0, abs=1e-15)
    assert rows.tangential[3] == pytest.approx(radius)
    assert rows.tangential[2] == pytest.approx(math.cos(0.2) + radius)
    assert chain.posture(q).contacts[0].radius == radius
    assert repr(chain.feet[0]) == "Foot(2, at=0.0, radius=0.3, slope=0.2, friction=0.5)"


def test_a_flat_foot_is_two_contacts_of_a_plate():
    """Its heel and toe beside the two contacts of a body with the same plate."""
    leg, plate = sf.Link(5, 0.6, 1), sf.Link(1, 0.01, 0.3, center=0.1)
    feet = [sf.Foot(2, at=at, friction=0.7) for at in (-0.05, 0.25)]
    ankle = sf.Joint("torque", angle=math.pi / 2)
    chain = sf.Chain(links=[leg, plate], joints=[ankle], feet=feet)
    q = [0, 1, -math.pi / 2, 0]
    held = chain.holding_torques(q)
    # The weight of both: the leg is above the ankle, the plate's centre 0.1 m before it.
    assert held.forces[:, 1].sum() == pytest.approx(6 * 9.81)
    assert held.torques == pytest.approx([0], abs=1e-12)
    verdict = sf.stability(chain.mechanism(q, torques="holding"))
    assert verdict.equilibrium
    body = sf.stability(chain.posture(q))
    assert (body.frictional_stability, body.equilibrium_region) == (
        "stable",
        pytest.approx((-0.05, 0.25)),
    )
