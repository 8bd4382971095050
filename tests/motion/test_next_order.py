"""Bodies at rest on contacts whose normals meet in one point: only the next order decides their mode.

The reference method needs no accelerations. It integrates every mode with at most two rows for a short time, in 26 digits,
and keeps those in which the laws of contact hold in the middle and at the end; rest is kept if it is possible.
"""

import math
import random
from contextlib import suppress
from decimal import Decimal, DivisionByZero, InvalidOperation
from itertools import product

import pytest
import standfast as sf
from friction_oracle import Body, integrate, precise
from standfast import Contact, Posture

#: Time of integration of the modes, in s: short compared with √(size/g) = 0.3 s, long enough for gaps of 1e-10 m to open.
MOMENT = Decimal("0.01")
#: Allowed difference of states after that time, in m, rad and their rates: rounding errors of a step of the package.
ROUNDING = 1e-14


def lawful(body, word, y):
    """Whether gaps are positive, forces in their cones, and sliding directions those of the letters."""
    forces = body.motion(word, y)[1]
    for i, letter in enumerate(word):
        tangential, normal = forces[i]
        way = {"R": 1, "L": -1}.get(letter)
        if letter == "S":
            holds = body.gap(i, y) > 0
        elif letter == "F":
            holds = abs(tangential) <= body.mu[i] * normal
        else:
            holds = normal >= 0 and way * body.slip(i, y) > 0
        if not holds:
            return False
    return True


def goes_on_in(posture):
    """The words in which the body may move from rest, and its states after a short time."""
    rows = {"S": 0, "R": 1, "L": 1, "F": 2}
    found = {}
    with precise():
        body = Body(posture)
    for letters in product(rows, repeat=len(posture.contacts)):
        word = "".join(letters)
        if not 1 <= sum(rows[letter] for letter in word) <= 2:
            continue
        # Equal rows give a pivot of zero.
        with precise(), suppress(DivisionByZero, InvalidOperation):
            half = MOMENT / 2
            middle = integrate(
                body.flow(word), [Decimal(0)] * 6, Decimal(0), half, half
            )
            end = integrate(body.flow(word), middle, half, MOMENT, half)
            if lawful(body, word, middle) and lawful(body, word, end):
                found[word] = end
    return found


def rough(rng):
    return rng.choice([0.0, rng.uniform(0, 0.3), rng.uniform(0.3, 1.2)])


def on_a_normal(rng):
    """Two contacts, one on the normal of the other."""
    slope = rng.choice([0.0, 0.0, 0.0, rng.uniform(-0.6, 0.6)])
    above = rng.uniform(0.3, 2)
    foot = (rng.uniform(-2, 2), 0.0) if slope == 0.0 else (0.0, 0.0)
    head = (foot[0] - above * math.sin(slope), above * math.cos(slope))
    tilt = rng.choice([0.0, rng.uniform(-1.2, 1.2)])
    contacts = [
        Contact(head, slope=tilt, friction=rough(rng)),
        Contact(foot, slope=slope, friction=rough(rng)),
    ]
    return contacts[:: rng.choice([1, -1])]


def concurrent(rng):
    """Three contacts whose normals meet in the origin."""
    contacts = []
    for _ in range(3):
        slope = rng.uniform(-1.2, 1.2)
        away = rng.choice([1, 1, 1, -1]) * rng.uniform(0.3, 2)
        point = (away * math.sin(slope), -away * math.cos(slope))
        contacts.append(Contact(point, slope=slope, friction=rough(rng)))
    return contacts


@pytest.mark.parametrize(("family", "seeds"), [(on_a_normal, 40), (concurrent, 10)])
def test_the_next_order_decides(family, seeds):
    moved = 0
    for seed in range(seeds):
        rng = random.Random(seed)
        contacts = family(rng)
        centre = (rng.uniform(-2, 2), rng.uniform(-1, 2))
        posture = Posture(1.0, rng.uniform(0.3, 2.0), centre, contacts, 0.0, 9.81)
        run = sf.simulate(posture, (0, 0, 0), (0, 0, 0), model="full", time_limit=0.2)
        if run.outcome.startswith("rest"):
            continue
        found = goes_on_in(posture)
        if run.outcome == "ambiguous" and run.time == 0.0:
            modes = sf.contact_modes(run.undecided)
            answers = [modes[word] for word in modes]
            static = any(
                one.consistent and not any(one.acceleration) for one in answers
            )
            assert len(found) + static > 1, (seed, found)
            continue
        assert list(found) == [run.phases[0].mode], seed
        (word, state) = next(iter(found.items()))
        if run.time > MOMENT:
            q, qdot = run.at(float(MOMENT))
            off = [
                abs(Decimal(float(a)) - b)
                for a, b in zip([*q, *qdot], state, strict=True)
            ]
            assert max(off) < ROUNDING, (seed, word, off)
            moved += 1
    assert moved > seeds / 2
