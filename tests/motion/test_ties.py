"""Contacts that are hit at one instant: the energy, which contacts are hit, and in which order.

STANDFAST_TIES sets the number of random multiple impacts for each law (1000), STANDFAST_FLUSH_HITS the number of bodies that come flush
to a piece of ground (100).
"""

import itertools
import math
import os
from collections import Counter

import numpy as np
import pytest
import standfast as sf
from bodies import LAWS, jacobian

TIES = int(os.environ.get("STANDFAST_TIES", "1000"))
HITS = int(os.environ.get("STANDFAST_FLUSH_HITS", "100"))
ORDERS = ["first-contact-first", "last-contact-first"]
#: Kicks of each body.
KICKS = 20


def feet_of(rng, law):
    """Feet on lines of any slope through their points. With Moreau's law e_t = e, for which its impacts lose energy."""
    e = rng.uniform(0, 0.95)
    contacts = [
        sf.Contact(
            rng.uniform((-1, -0.6), (1, 0.6)),
            slope=rng.uniform(-1.2, 1.2),
            friction=rng.uniform(0.05, 1),
            tangential_restitution=e if law == "moreau" else 0.0,
        )
        for _ in range(rng.integers(3, 7))
    ]
    center = rng.uniform((-1, 0.2), (1, 1.5))
    return sf.Posture(1.0, rng.uniform(0.2, 1), center, contacts, e)


def velocities(body, rng):
    """Of a body all of whose feet touch."""
    scale = np.array([1, 1, 1 / body.gyration_radius])
    return rng.normal(size=(KICKS, 3)) * scale


def kinetic(body, qdot):
    square = np.array([1, 1, body.gyration_radius**2])
    return 0.5 * np.asarray(qdot) ** 2 @ square


def after_impacts(body, qdot, law, order):
    """Velocities after all impacts at the start."""
    # Flights of 1e-12 s change no velocity by more than 1e-11 m/s.
    return sf.simulate_many(
        body,
        np.zeros_like(qdot),
        qdot,
        model="local",
        impact=law,
        simultaneous=order,
        time_limit=1e-12,
        event_limit=100_000,
    )


CASES = [("newton", "newton"), *itertools.product(LAWS, ORDERS)]


def jams(body):
    """Whether a foot can jam: frictional impacts may then press other feet without end."""
    normal, tangential = jacobian(body)
    mobility = np.diag([1, 1, body.gyration_radius**-2])
    mu = np.array([contact.friction for contact in body.contacts])[:, None]
    push = [
        np.einsum("ij,jk,ik->i", normal, mobility, normal - side * mu * tangential)
        for side in (-1, 1)
    ]
    return np.min(push) <= 0


@pytest.mark.parametrize(("law", "order"), CASES)
def test_no_multiple_impact_gains_energy(law, order):
    rng = np.random.default_rng([4301, LAWS.index(law), len(order)])
    bodies, unfinished = 0, 0
    while bodies * KICKS < TIES:
        body = feet_of(rng, law)
        if law in ("chatterjee-ruina", "moreau") and jams(body):
            continue
        bodies += 1
        qdot = velocities(body, rng)
        runs = after_impacts(body, qdot, law, order)
        ended = np.isin(runs.outcome, ["time-limit", "escape", "rest", "sliding"])
        unfinished += np.sum(~ended)
        gain = kinetic(body, runs.qdot) - kinetic(body, qdot)
        # Free fall in 1e-12 s.
        assert np.all(gain <= 1e-10), (body, qdot[np.argmax(gain)], gain.max())
    assert unfinished <= 0.01 * bodies * KICKS


def test_three_feet_hit_at_once():
    """The kinetic energy before the impact is 2.43 J. Impulses that also push the foot that recedes would give 3.87
    J."""
    feet = [
        sf.Contact(point, slope=slope)
        for point, slope in [((-0.4, 0), -0.8), ((0.1, -0.3), 1), ((0.7, -0.1), -0.6)]
    ]
    body = sf.Posture(1, 0.3, (0.3, 1), feet, 0.5)
    qdot = (0.2, -1.1, -19 / 3)
    before = kinetic(body, qdot)
    for order in ("newton", *ORDERS):
        run = sf.simulate(body, (0, 0, 0), qdot, model="local", simultaneous=order, time_limit=1e-3)  # fmt: skip
        assert run.energy(1e-6) < before, order


def one_newton_impact(normal, mobility, e, rates):
    """(rate changes) of u⁺ + e u⁻ ≥ 0 ⊥ P ≥ 0 over the contacts that approach: the subset of them that satisfies it."""
    delassus = normal @ mobility @ normal.T
    coming = np.flatnonzero(rates < 0)
    found = []
    for size in range(1, len(coming) + 1):
        for hit in itertools.combinations(coming, size):
            hit = list(hit)
            block = delassus[np.ix_(hit, hit)]
            if np.linalg.cond(block) > 1e8:
                return None
            impulse = np.linalg.solve(block, -(1 + e) * rates[hit])
            after = rates + delassus[:, hit] @ impulse
            if np.all(impulse > 1e-9) and np.all((after + e * rates)[coming] > -1e-9):
                found.append((hit, impulse))
    return found[0] if len(found) == 1 else None


def test_the_contacts_that_approach_are_hit_together_until_none_does():
    """Three feet, by all subsets of them, in numpy."""
    rng = np.random.default_rng(4302)
    compared = 0
    for _ in range(100):
        six = feet_of(rng, "newton")
        body = sf.Posture(1.0, six.gyration_radius, six.center_of_mass, six.contacts[:3], six.restitution)  # fmt: skip
        normal, _ = jacobian(body)
        mobility, e = np.diag([1, 1, body.gyration_radius**-2]), body.restitution
        qdot = velocities(body, rng)
        runs = after_impacts(body, qdot, "newton", "newton")
        for v, found in zip(qdot, runs.qdot, strict=True):
            rates, impacts = normal @ v, 0
            while np.any(rates < -1e-9) and impacts < 40:
                one = one_newton_impact(normal, mobility, e, rates)
                if one is None:
                    break
                hit, impulse = one
                v = v + mobility @ normal[hit].T @ impulse
                rates, impacts = normal @ v, impacts + 1
                rates[hit] = np.abs(rates[hit])
            if impacts and np.all(rates >= 0) and np.min(np.abs(rates)) > 1e-6:
                np.testing.assert_allclose(found, v, atol=1e-9)
                compared += 1
    assert compared > 1000


def turned(points, angle):
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(points) @ np.array([[cos, sin], [-sin, cos]])


class Flush:
    """A box one side of which comes flush to a piece of ground: two corners arrive at the same instant."""

    def __init__(self, rng, law):
        self.law = law
        width, height = rng.uniform(0.2, 2, 2)
        self.way = str(rng.choice(["wall", "floor"]))
        self.start = str(rng.choice(["slides", "from rest", "after a landing"]))
        self.angle = float(rng.choice([0.0, rng.uniform(0.1, 0.6)]))
        if self.way == "wall" and self.start == "from rest":
            self.angle = rng.uniform(0.3, 0.6)  # it slides down
        wall = width / 2 + rng.uniform(0.05, 3)
        self.speed = (0.0 if self.start == "from rest" else rng.uniform(1, 4)) + (
            6.0 if self.start == "after a landing" else 0.0
        )
        lift = 0.0
        if self.way == "floor" or self.start == "after a landing":
            lift = rng.uniform(0.01, 0.2)
        if self.way == "floor":
            wall = 50.0
        box = [
            (-width / 2, 0),
            (width / 2, 0),
            (width / 2, height),
            (-width / 2, height),
        ]
        ground = [(-60, 0), (wall, 0), (wall, 60)]
        self.box, self.ground = turned(box, -self.angle), turned(ground, -self.angle)
        self.q = np.append(turned([(0, lift)], -self.angle)[0], 0.0)
        self.qdot = np.append(turned([(self.speed, 0)], -self.angle)[0], 0.0)
        self.e = rng.choice([0.0, rng.uniform(0.1, 0.8)])
        if self.start == "after a landing":
            self.e = 0.0
        self.friction = rng.uniform(0.02, 0.2)
        self.pair = (2, 3) if self.way == "wall" else (1, 2)

    def run(self, order, mirrored=False):
        side = np.array([-1, 1]) if mirrored else np.array([1, 1])
        ground = self.ground * side
        body = sf.Posture.polygon(
            self.box * side,
            friction=0.0 if self.law == "newton" else self.friction,
            restitution=self.e,
            terrain=ground[::-1] if mirrored else ground,
        )
        turn = np.append(side, side[0])
        return sf.simulate(
            body,
            self.q * turn,
            self.qdot * turn,
            model="full",
            impact=self.law,
            simultaneous=order,
            time_limit=3.0,
            event_limit=20_000,
        )

    def arrival(self, run):
        """When the pair is hit first."""
        impacts = run.impacts
        both = np.isin(impacts["contact"], self.pair)
        if self.way == "wall":
            # Before this the box may have landed on its lower side.
            both &= impacts["contact"] == 3
        return float(impacts["time"][both][0]) if both.any() else None

    def names_the_pair(self, run):
        words = (
            f"contacts {' and '.join(map(str, self.pair))} collided at the same instant"
        )
        return any(words in warning for warning in run.warnings)


def lies_flat(run, time):
    q, qdot = run.at(time - 1e-9)
    return max(abs(q[2]), abs(qdot[2])) < 1e-12


def after(run, time):
    return run.at(min(run.time, time + 1e-9))[1]


def test_corners_that_come_flush_to_the_ground_are_hit_at_one_instant():
    """On level ground and on a slope. The mirrored body moves in the mirrored way; the order of the impacts has an
    effect; Newton's law for both corners at once reverses the motion."""
    rng = np.random.default_rng(4303)
    seen, effects = Counter(), Counter()
    while sum(seen.values()) < HITS:
        law = LAWS[sum(seen.values()) % len(LAWS)]
        scene = Flush(rng, law)
        orders = ["newton", *ORDERS] if law == "newton" else ORDERS
        runs = [scene.run(order) for order in orders]
        times = [scene.arrival(run) for run in runs]
        if None in times or not all(map(lies_flat, runs, times)):
            continue  # friction has stopped it, or it tumbles after a landing
        seen[scene.way, scene.start, law] += 1
        for order, run, time in zip(orders, runs, times, strict=True):
            assert scene.names_the_pair(run), (order, scene.__dict__, run.warnings)
            image = scene.run(order, mirrored=True)
            assert scene.names_the_pair(image), (order, scene.__dict__)
            turn = np.array([-1, 1, -1])
            np.testing.assert_allclose(
                after(image, time) * turn, after(run, time), atol=1e-7
            )
        if law == "newton":
            before, now = runs[0].at(times[0] - 1e-9)[1], after(runs[0], times[0])
            x = turned([(1, 0), (0, 1)], -scene.angle)[0 if scene.way == "wall" else 1]
            assert now[:2] @ x == pytest.approx(-scene.e * (before[:2] @ x), abs=1e-7)
            assert abs(now[2]) < 1e-12
        first, last = (
            after(run, time) for run, time in zip(runs[-2:], times[-2:], strict=True)
        )
        effects[abs(first - last).max() > 1e-9, scene.e > 0] += 1
    print(dict(seen), dict(effects))
    assert effects[False, True] == 0


@pytest.mark.parametrize("wall", [3 + 0.01 * k for k in range(0, 200, 5)])
def test_a_box_that_slides_flush_into_a_wall_stops(wall):
    """Without friction and restitution, by Newton's law for both corners. Formerly the box hopped at 0.6 m/s for
    most places of the wall."""
    box = sf.Posture.box(1.0, 2.0, terrain=[(-10.0, 0.0), (wall, 0.0), (wall, 10.0)])
    run = sf.simulate(box, (0, 0, 0), (2.0, 0, 0), model="full", time_limit=6.0)
    assert run.outcome == "rest"
    assert run.time == pytest.approx((wall - 0.5) / 2, rel=1e-12)
    assert any(
        "contacts 2 and 3 collided at the same instant" in w for w in run.warnings
    )
