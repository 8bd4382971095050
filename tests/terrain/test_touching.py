"""A contact put onto its ground by a vertical displacement, on random terrains of every kind."""

import math
import os
from collections import Counter
from itertools import combinations, pairwise

import numpy as np
import pytest
from region import exact
from rings import EPSILON, SIZE, body, places, scene, start_of_run

#: Number of random scenes; `make long` has more.
TOUCHING = int(os.environ.get("STANDFAST_TOUCHING_SCENES", "300"))


def crossings(terrain, x):
    """Heights at which a vertical meets a terrain, and whether it passes near a vertex or along a wall."""
    heights, clear = [], True
    for (ax, ay), (bx, by) in pairwise(terrain):
        near = 1e-6 * max(1.0, abs(x))
        clear = clear and min(abs(x - ax), abs(x - bx)) > near
        if min(ax, bx) <= x <= max(ax, bx) and ax != bx:
            heights.append(ay + (by - ay) * (x - ax) / (bx - ax))
    return heights, clear


def touching(posture, number, theta):
    """The configuration or the message of the error."""
    try:
        return posture.touching(number, theta), None
    except ValueError as refusal:
        return None, str(refusal)


def test_a_contact_is_put_onto_its_ground():
    """The displacement is vertical, the contact is on the terrain, no other one is in the ground, and no smaller displacement does
    the same."""
    seen = Counter()
    seed = 0
    while seen.total() < TOUCHING:
        seed += 1
        (terrain, region), rng = scene(seed), np.random.default_rng([34, seed])
        terrain_size = np.abs(terrain).max()
        if terrain_size > 1e5:
            continue
        points = [p for p in places(rng, terrain, 12) if region.nearest(exact(p))[1]]
        points = [p for p in points if region.side(exact(p)) > 0]
        points = points[: rng.integers(1, 5)]
        apart = [math.dist(a, b) for a, b in combinations(points, 2)]
        if not points or min(apart, default=1) < 1e-4 * max(apart, default=1):
            continue
        posture = body(
            terrain,
            *points,
            center=np.add(points[0], rng.normal(size=2) * 0.1),
        )
        theta = float(rng.choice([0.0, rng.uniform(-3, 3)]))
        number = int(rng.integers(1, len(posture.contacts) + 1))
        where = f"terrain {seed}, contact {number}, theta {theta}"
        cos, sin = math.cos(theta), math.sin(theta)
        center = np.array(posture.center_of_mass)
        arms = np.array([c.point for c in posture.contacts]) - center
        turned = center + arms @ [[cos, sin], [-sin, cos]]

        def others(q, turned=turned, number=number, region=region):
            """Sides of the other contacts, with their distance from the ground."""
            found = []
            for k, p in enumerate(turned):
                if k != number - 1:
                    p = exact(p + q[:2])
                    distance, pieces = region.nearest(p)
                    if distance is None:
                        found.append((None, 0.0))
                    elif pieces is None:
                        found.append((1, math.inf))
                    else:
                        found.append((region.side(p), distance))
            return found

        error = 64 * EPSILON * (terrain_size + np.abs(turned).max() + 1)
        touch = 1e-12 * max(SIZE, np.hypot(*arms.T).max())
        heights, clear = crossings(terrain, turned[number - 1][0])
        ways = sorted(
            ((0.0, y - turned[number - 1][1], theta) for y in heights),
            key=lambda q: abs(q[1]),
        )
        stands = [all(s == 1 and d > 1e-6 for s, d in others(q)) for q in ways]
        q, refusal = touching(posture, number, theta)
        if q is None:
            assert not (clear and any(stands)), where
            assert ways or "above or below" in refusal or not clear, where
            seen["no ground" if not ways else "another contact in the ground"] += 1
            continue
        assert (q[0], q[2]) == (0, theta), where
        distance, _ = region.nearest(exact(turned[number - 1] + q[:2]))
        assert distance is None or distance <= error + touch, where
        gaps = posture.gaps(q)
        assert abs(gaps[number - 1]) <= error, where
        assert all(s != -1 or d <= error + touch for s, d in others(q)), where
        if clear and any(stands):
            assert abs(q[1]) <= abs(ways[stands.index(True)][1]) + 1e-6, where
        if clear and len(points) == 1:
            start = start_of_run(posture, q)
            assert abs(start.gaps[number - 1]) <= error + touch, where
        seen["on its ground"] += 1
    print(dict(seen))
    assert seen["on its ground"] > 0.4 * TOUCHING


def test_touching_under_an_overhang_and_beside_a_wall():
    for terrain in (
        [(-40, 0), (0, 0), (0, -2), (40, -2)],
        [(-40, 0), (0, 0), (-0.5, -2), (40, -2)],
    ):
        for point, y in (
            ((-1, 0.5), 0),
            ((0.3, 0.5), -2),
            ((0.5, 1.5), -2),
            ((0.5, -1), -2),
        ):
            posture = body(terrain, point)
            q = posture.touching(1, 0.0)
            assert q.tolist() == [0, y - point[1], 0]
            assert posture.gaps(q)[0] == 0
    shaft = body([(-1, 3), (-1, 0), (1, 0), (1, 3)], (1.0, 2.0), (0.0, 2.5))
    assert shaft.touching(1, 0.0).tolist() == [0, 0, 0]  # on the wall already
    room = body([(1, 2), (-1, 2), (-1, 0), (1, 0)], (0.0, 1.75), (0.0, 0.5))
    assert room.touching(1, 0.0).tolist() == [0, 0.25, 0]  # on the ceiling
    with pytest.raises(ValueError, match=r"contact 1 lies 1.0 m in the ground"):
        body([(-5, 0), (5, 0)], (0, 1), (1, 2)).touching(2, 0.0)
    edge = body([(-1, 0), (1, 0)], (0, 4), center=(0, 1))
    with pytest.raises(ValueError, match="above or below"):
        edge.touching(1, math.pi / 2)
