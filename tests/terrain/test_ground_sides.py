"""Points in front of the ground, on it and in it, on random terrains of every kind, decided by exact integers."""

import math
import os
from collections import Counter

import numpy as np
import pytest
from region import exact
from rings import EPSILON, SIZE, body, places, scene, start_of_run

#: Number of random terrains and of points on each of them; `make long` has more.
TERRAINS = int(os.environ.get("STANDFAST_SIDES_TERRAINS", "84"))
POINTS = int(os.environ.get("STANDFAST_SIDES_POINTS", "50"))
#: Depth in the ground that counts as touching.
TOUCH = 1e-12 * SIZE
#: Rounding error of the place of a point that touches far from the origin; in ε times its coordinates.
ROUNDINGS = 32


def rounding(terrain, point):
    """Rounding error of a gap: of the coordinates of the piece and of the point."""
    return 16 * EPSILON * (np.abs(terrain).max() + np.abs(point).max())


def test_points_are_free_or_on_the_ground_or_in_it():
    """A point is refused exactly if it lies in the ground; the message has its depth. A gap is the height over the nearest piece."""
    seen = Counter()
    for seed in range(TERRAINS):
        (terrain, region), rng = scene(seed), np.random.default_rng([32, seed])
        for point in places(rng, terrain, POINTS):
            distance, pieces = region.nearest(exact(point))
            if pieces is None:
                seen["beyond the ends"] += 1
                continue
            side = region.side(exact(point))
            where = f"terrain {seed}, point {point}"
            touch = max(TOUCH, ROUNDINGS * EPSILON * (abs(point[0]) + abs(point[1])))
            if side < 0 and distance > touch * (1 + 1e-9):
                seen["in the ground"] += 1
                with pytest.raises(ValueError, match="m in the ground") as refusal:
                    body(terrain, point)
                depth = float(str(refusal.value).split()[-5])
                assert depth == pytest.approx(distance, rel=1e-9), where
                continue
            posture = body(terrain, point)
            seen["free" if side > 0 else "on the ground"] += 1
            gap = posture.gaps((0, 0, 0))[0]
            error = rounding(terrain, point) + touch
            heights = [region.height(k, exact(point)) for k in pieces]
            assert min(abs(gap - h) for h in heights) <= error, where
            start = start_of_run(posture, (0, 0, 0))
            assert start.gaps[0] >= 0, where
            assert abs(start.gaps[0] - gap) <= error, where
    print(dict(seen))
    assert min(seen.values()) > 0.02 * TERRAINS * POINTS


def test_gaps_of_displaced_bodies():
    """`gaps` and the gaps of a run have the sign of the side on which a contact lies, and the height over the nearest piece."""
    seen = Counter()
    for seed in range(TERRAINS):
        (terrain, region), rng = scene(seed), np.random.default_rng([33, seed])
        points = list(places(rng, terrain, POINTS))
        free = [
            p
            for p in points
            if region.nearest(exact(p))[1] and region.side(exact(p)) > 0
        ]
        if not free:
            continue
        posture = body(terrain, free[0])
        gaps = posture.gaps([(*np.subtract(p, free[0]), 0.0) for p in points])[:, 0]
        for point, gap in zip(points, gaps, strict=True):
            moved = np.add(free[0], np.subtract(point, free[0]))
            error = 2 * rounding(terrain, point) + TOUCH
            distance, pieces = region.nearest(exact(moved))
            # A contact nearer to the ground than 64 ε times the displacement and the coordinates is on it.
            on_it = 64 * EPSILON * (math.dist(point, free[0]) + np.abs(terrain).max())
            if distance is None or (
                pieces is not None and distance < max(error, on_it)
            ):
                continue
            where = f"terrain {seed}, point {point}"
            if pieces is None:
                seen["beyond"] += 1
                continue
            side = region.side(exact(moved))
            seen[side] += 1
            assert gap * side > -error, where
            heights = [region.height(k, exact(moved)) for k in pieces]
            assert min(abs(gap - h) for h in heights) <= error, where
    print(dict(seen))
    assert min(seen[1], seen[-1]) > 0.2 * TERRAINS * POINTS


@pytest.mark.parametrize(
    ("terrain", "free", "inside"),
    [
        (  # a floor that falls to a wall
            [(-30, 12), (0, 0), (0, 40)],
            [(-1, 1), (0, 0), (0, 1), (-1, 0.4)],
            [
                (-0.03, -1.15),
                (-0.03, -0.1),
                (-0.5, -2),
                (-1, -1),
                (0.5, 1),
                (0.03, -1.15),
            ],
        ),
        (  # ledges that overhang
            [(-38, -12), (0, 0), (-0.87, -2.1), (39, 9.7)],
            [(-0.06, 1.37), (-0.06, 0.5), (-0.5, 1.37), (0.5, 1.37), (0.1, 0)],
            [(-0.5, -0.5), (-1, -2), (0, -2.1)],
        ),
        (
            [(-40, 0), (0, 0), (-1, -1), (40, 4)],
            [(-0.1, 1), (-0.1, 0.1), (0.1, 0.1), (0.3, -0.2)],
            [(-0.3, -0.2), (-1.2, -1), (0, -1)],
        ),
    ],
)
def test_corners_and_ledges(terrain, free, inside):
    for point in free:
        assert body(terrain, point).gaps((0, 0, 0))[0] >= 0
    for point in inside:
        with pytest.raises(ValueError, match=r"contacts.1.point = .* m in the ground"):
            body(terrain, point)


def test_a_point_on_the_line_of_a_needle_beyond_its_tip_does_not_touch_it():
    terrain = [
        (-5.0, 1001.6826171875),
        (0.9773082289517591, 1000.0),
        (-1.1374508419794997, 1001.0),
        (0.9773082289517604, 1000.0),
        (5.0, 995.775390625),
    ]
    posture = body(terrain, (-2.19483037744513, 1001.5))
    start = start_of_run(posture, (0, 0, 0))
    assert start.gaps == posture.gaps((0, 0, 0)) == pytest.approx([0.58433], rel=1e-5)
