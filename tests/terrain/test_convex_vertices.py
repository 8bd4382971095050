"""Contacts exactly on convex vertices of the terrain. Each contact is on one of the two pieces: on one on which it
stays, if there is such a piece.

STANDFAST_CONVEX_BODIES sets the number of random bodies (200).
"""

import itertools
import math
import os
from collections import Counter

import numpy as np
import pytest
import standfast as sf

BODIES = int(os.environ.get("STANDFAST_CONVEX_BODIES", "200"))
REST = (0, 0, 0)


def mirrored(points):
    return [(-x, y) for x, y in reversed(points)]


def box_on(ground, **fields):
    return sf.Posture.box(0.3, 0.2, terrain=ground, **{"friction": 0.4, **fields})


def start(body, qdot=REST, law="moreau"):
    return sf.simulate(body, REST, qdot, impact=law, time_limit=2, event_limit=3000)


TABLE = [(-2, 0), (0.15, 0), (0.15, -0.75), (3, -0.75)]
STEEP = [(-2, 0), (0.15, 0), (0.151, -0.75), (3, -0.75)]
PEDESTAL = [
    (-3, -0.75),
    (-0.15, -0.75),
    (-0.15, 0),
    (0.15, 0),
    (0.15, -0.75),
    (3, -0.75),
]


@pytest.mark.parametrize(
    "ground", [TABLE, mirrored(TABLE), STEEP, mirrored(STEEP), PEDESTAL]
)
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_a_box_flush_with_an_edge_stands(ground, friction):
    body = box_on(ground, friction=friction)
    run = start(body, law="newton")
    assert (run.outcome, run.time) == ("rest", 0)
    assert sf.friction_margin(body) == 1.0
    low, high = sf.equilibrium_region(body)
    assert low <= -0.15
    assert high >= 0.15
    assert sf.contact_modes(body, REST, REST).consistent == ["FFSS"]
    assert sf.static_forces(body) is not None


@pytest.mark.parametrize("beyond", [1e-9, -1e-9])
def test_beside_an_edge_nothing_changes(beyond):
    ground = [(-2, 0), (0.15 - beyond, 0), (0.15 - beyond, -0.75), (3, -0.75)]
    for body in (box_on(ground), box_on(mirrored(ground))):
        ways = {"impact": "moreau", "time_limit": 1e-3, "stop": "time"}
        run = sf.simulate(body, REST, REST, **ways)
        assert "F" in run.phases[-1].mode[:2]
        assert run.qdot[1] == 0
        # If the edge does not meet the side, the box falls over it.
        bare = sf.simulate(body, REST, REST, edges="ignore", **ways)
        stands = "F" in bare.phases[-1].mode[:2] and bare.qdot[1] == 0
        assert stands == (beyond < 0)


@pytest.mark.parametrize("ground", [TABLE, STEEP, PEDESTAL])
@pytest.mark.parametrize("height", [0.0, 0.1])
def test_a_box_moves_from_an_edge_and_lands_on_it(ground, height):
    """Pushed onto the table it slides; dropped flush with the edge it lands flat; mirrored likewise."""
    for side, terrain in ((1, ground), (-1, mirrored(ground))):
        body = box_on(terrain)
        if height:
            run = sf.simulate(body, (0, height, 0), REST)  # both corners at once
            assert run.outcome == "rest"
            assert run.time == pytest.approx(math.sqrt(2 * height / 9.81), rel=1e-12)
            np.testing.assert_allclose(run.q, 0, atol=1e-15)
        elif ground is not PEDESTAL:
            run = start(body, (-side * 0.5, 0, 0))
            assert run.outcome == "rest"
            assert run.q[0] == pytest.approx(-side * 0.25 / (2 * 0.4 * 9.81), rel=1e-12)
            assert len(run.impacts) == 0


@pytest.mark.parametrize(("vx", "hit"), [(0.0, True), (1e-6, False), (-1e-6, True)])
def test_a_point_that_falls_on_an_edge(vx, hit):
    """In line with the wall it hits the edge; with a velocity away from the wall it flies past."""
    for side, ground in ((1, TABLE), (-1, mirrored(TABLE))):
        at = (side * 0.15, 0.0)
        body = sf.Posture(1, 0.1, at, [sf.Contact(at)], 0.5, terrain=ground)
        run = sf.simulate(body, REST, (side * vx, -1, 0), time_limit=0.05)
        assert len(run.impacts) == hit
        if vx == 0:
            drop = sf.simulate(body, (0, 0.05, 0), REST, time_limit=0.11)
            assert len(drop.impacts) == 1


class Drawn:
    """A body on two or three points, at least one of them a convex vertex of the terrain; the slopes beside each vertex."""

    def __init__(self, rng):
        count = int(rng.integers(2, 4))
        x = np.cumsum(rng.uniform(0.4, 1.5, count))
        y = rng.uniform(-0.3, 0.3, count)
        points = [(float(a), float(b)) for a, b in zip(x, y, strict=True)]
        walls = rng.random() < 0.3
        terrain = []
        for k, (a, b) in enumerate(points):
            if k == 0:
                rise = rng.uniform(-0.8, 0.8)
                terrain.append((a - 3.0, b - 3.0 * rise))
            terrain.append((a, b))
            if k + 1 == count:
                steep = (
                    (b - terrain[-2][1]) / (a - terrain[-2][0])
                    if a > terrain[-2][0]
                    else 9
                )
                fall = rng.uniform(-0.8, min(0.8, steep - 0.05))
                terrain.append((a + 3.0, b + 3.0 * fall))
                continue
            low = min(b, points[k + 1][1]) - rng.uniform(0.05, 0.8)
            if walls:
                terrain += [(a, low), (points[k + 1][0], low)]
            else:
                terrain.append(
                    (float(rng.uniform(a + 0.1, points[k + 1][0] - 0.1)), low)
                )
        self.points, self.terrain = points, terrain
        # The first slope must be steeper than the second one for the first vertex to be convex.
        self.friction = [float(f) for f in rng.uniform(0, 1, count)]
        self.center = (
            float(rng.uniform(x[0] - 0.3, x[-1] + 0.3)),
            float(rng.uniform(0.3, 1.5)),
        )
        self.rho = float(rng.uniform(0.2, 1))

    def is_convex(self):
        ways = np.diff(np.array(self.terrain), axis=0)
        for k, vertex in enumerate(self.terrain[1:-1]):
            if vertex in self.points and np.linalg.det(ways[k : k + 2]) >= -1e-3:
                return False
        return True

    def body(self, side=1):
        contacts = [
            sf.Contact((side * x, y), friction=f)
            for (x, y), f in zip(self.points, self.friction, strict=True)
        ]
        terrain = self.terrain if side == 1 else mirrored(self.terrain)
        return self.posture(contacts, side, terrain=terrain)

    def posture(self, contacts, side=1, **other):
        center = (side * self.center[0], self.center[1])
        return sf.Posture(1, self.rho, center, contacts, 0.0, **other)

    def alone(self):
        """The same body with each contact on one of its two pieces alone."""
        ways = []
        for x, y in self.points:
            k = self.terrain.index((x, y))
            (a, b), (c, d) = self.terrain[k - 1], self.terrain[k + 1]
            left = (math.atan2(y - b, x - a), (-math.hypot(x - a, y - b), 0))
            right = (math.atan2(d - y, c - x), (0, math.hypot(c - x, d - y)))
            ways.append([left, right])
        for pieces in itertools.product(*ways):
            yield self.posture(
                [
                    sf.Contact(point, slope=slope, friction=f, segment=segment)
                    for point, f, (slope, segment) in zip(
                        self.points, self.friction, pieces, strict=True
                    )
                ]
            )


def test_a_body_is_held_where_one_piece_for_each_contact_would_hold_it():
    """Forces, margins, regions, modes and motion; and the mirrored body."""
    rng = np.random.default_rng(4306)
    seen = Counter()
    while seen["bodies"] < BODIES:
        drawn = Drawn(rng)
        if not drawn.is_convex():
            continue
        seen["bodies"] += 1
        body, image, alone = drawn.body(), drawn.body(-1), list(drawn.alone())
        margins = [sf.friction_margin(one) for one in alone]
        if min(abs(margin) for margin in margins) < 1e-9:
            continue
        held = any(sf.static_forces(one) is not None for one in alone)
        about = (drawn.points, drawn.terrain, drawn.center, drawn.friction, drawn.rho)
        for one in (body, image):
            assert (sf.static_forces(one) is not None) == held, about
            assert sf.friction_margin(one) == pytest.approx(max(margins), abs=1e-9), (
                about
            )
        if held:
            low, high = sf.equilibrium_region(body)
            assert low <= drawn.center[0] <= high
            assert sf.equilibrium_region(image) == pytest.approx((-high, -low))
        rests = [
            modes.status == "unique" and set(modes.consistent[0]) == {"F"}
            for modes in (sf.contact_modes(one, REST, REST) for one in alone)
        ]
        modes = sf.contact_modes(body, REST, REST)
        run, other = start(body), start(image)
        if any(rests):
            seen["rests"] += 1
            assert "F" * len(drawn.points) in modes.consistent, about
            assert (run.outcome, run.time) in [("rest", 0), ("ambiguous", 0)], about
            seen[run.outcome] += 1
        if run.outcome == "ambiguous" and run.time == 0:
            continue
        # Where several combinations are as good, the body and its image may take different ones.
        t = min(1e-3, run.time, other.time)
        apart = np.abs(run.at(t)[1] - other.at(t)[1] * (-1, 1, -1)).max()
        seen["mirrored" if apart < 1e-9 else "another choice"] += 1
        assert not any(rests) or apart < 1e-9, about
    print(dict(seen))
    assert seen["rests"] > BODIES / 20
