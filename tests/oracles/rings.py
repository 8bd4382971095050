"""Random terrains, each with the closure that makes it a polygon, points in critical places, and bodies there."""

import math
from fractions import Fraction
from functools import cache

import numpy as np
import standfast as sf
from region import Region, is_simple

EPSILON = 2.0**-52
#: Size of bodies with one contact.
SIZE = 0.25


def dyadic(x):
    return round(float(x) * 1024) / 1024


def uncrossed(rng):
    """Random points on a grid, joined to a polygon without crossings by exchanging edges."""
    count, size = int(rng.integers(4, 12)), int(rng.choice([4, 8, 1000]))
    points = {tuple(map(int, rng.integers(-size, size + 1, 2))) for _ in range(count)}
    ring = [tuple(map(float, p)) for p in points]
    rng.shuffle(ring)
    ring = [tuple(map(float, p)) for p in ring]
    count = len(ring)
    for _ in range(200):
        best = None
        for i in range(count - 1):
            for j in range(i + 2, count - (i == 0)):
                a, b, c, d = ring[i], ring[i + 1], ring[j], ring[(j + 1) % count]
                gain = (
                    math.dist(a, b)
                    + math.dist(c, d)
                    - math.dist(a, c)
                    - math.dist(b, d)
                )
                if gain > 1e-9 and (best is None or gain > best[0]):
                    best = gain, i, j
        if best is None:
            break
        _, i, j = best
        ring[i + 1 : j + 1] = ring[i + 1 : j + 1][::-1]
    return opened(rng, ring)


def opened(rng, ring):
    """A ring without one of its edges."""
    k = int(rng.integers(len(ring)))
    ring = ring[k:] + ring[:k]
    return (ring if rng.integers(2) else ring[::-1]), []


def cells(rng):
    """The boundary of squares that adjoin each other: walls, floors and ceilings."""
    filled = {(0, 0)}
    while len(filled) < rng.integers(3, 25):
        x, y = list(filled)[rng.integers(len(filled))]
        dx, dy = [(1, 0), (-1, 0), (0, 1), (0, -1)][rng.integers(4)]
        filled.add((x + dx, y + dy))
    after = {}
    for x, y in filled:
        for (dx, dy), a, b in (
            ((0, -1), (0, 0), (1, 0)),
            ((1, 0), (1, 0), (1, 1)),
            ((0, 1), (1, 1), (0, 1)),
            ((-1, 0), (0, 1), (0, 0)),
        ):
            if (x + dx, y + dy) not in filled:
                after.setdefault((x + a[0], y + a[1]), []).append((x + b[0], y + b[1]))
    if any(len(ends) > 1 for ends in after.values()):
        return [], []  # two squares meet in a corner
    start = next(iter(after))
    ring, at = [], start
    while not ring or at != start:
        ring.append(at)
        at = after[at][0]
    if len(ring) != len(after):
        return [], []  # a hole
    straight = [
        (b[0] - a[0]) * (c[1] - b[1]) == (b[1] - a[1]) * (c[0] - b[0])
        for a, b, c in zip(
            ring[-1:] + ring[:-1], ring, ring[1:] + ring[:1], strict=True
        )
    ]
    keep = rng.random() < 0.3  # with vertices between pieces of one line
    ring = [v for v, flat in zip(ring, straight, strict=True) if keep or not flat]
    return opened(rng, [tuple(map(float, v)) for v in ring])


def star(rng):
    """Long spikes around a point."""
    count = int(rng.integers(4, 14))
    angles = np.sort(rng.uniform(0, 2 * math.pi, count))
    radii = rng.choice([0.05, 0.3, 1.0, 6.0], count) * rng.uniform(0.8, 1.2, count)
    ring = [
        (dyadic(r * math.cos(a)), dyadic(r * math.sin(a)))
        for r, a in zip(radii, angles, strict=True)
    ]
    return opened(rng, ring)


def spiral(rng):
    """A band that is wound up."""
    count, turns = int(rng.integers(8, 24)), rng.uniform(1, 2.5)
    angles = np.linspace(0, 2 * math.pi * turns, count)
    ends = [[], []]
    for a in angles:
        for side, way in enumerate([0.0, 0.4]):
            r = 0.3 + a / (2 * math.pi) + way
            ends[side].append((dyadic(r * math.cos(a)), dyadic(r * math.sin(a))))
    return opened(rng, ends[0] + ends[1][::-1])


def ledges(rng):
    """Long ground on both sides of a few vertices that overhang; the closure goes round below it."""
    middle = [
        (dyadic(x), dyadic(y))
        for x, y in rng.uniform(-2.5, 2.5, (int(rng.integers(1, 5)), 2))
    ]
    left, right = dyadic(rng.uniform(-15, 15)), dyadic(rng.uniform(-15, 15))
    far = float(rng.choice([5, 40, 1000]))
    return [(-far, left), *middle, (far, right)], [(far, -3000.0), (-far, -3000.0)]


def hills(rng):
    """Ground without walls."""
    xs = np.cumsum(rng.choice([1 / 64, 0.5, 1.0, 3.0], int(rng.integers(2, 9))))
    steep = rng.choice([0.5, 3, 50])
    ring = [(dyadic(x), dyadic(rng.uniform(-steep, steep))) for x in xs]
    return ring, [(ring[-1][0], -3000.0), (ring[0][0], -3000.0)]


def needles(rng):
    """A needle of ground, or a slot in the ground, as thin as a few rounding errors, on an inclined floor."""
    thin = (
        float(10.0 ** rng.uniform(-17, -1))
        if rng.integers(2)
        else 2.0**-52 * int(rng.integers(1, 9))
    )
    foot, tip = (
        np.array([float(rng.choice([0.0, rng.uniform(0.1, 1)])), 0.0]),
        rng.uniform(-2, 2, 2),
    )
    feet = [
        tuple(map(float, foot)),
        tuple(map(float, foot + np.array([thin * rng.choice([1, 2]), 0.0]))),
    ]
    tip[1] = rng.choice([1.0, tip[1], -1.0])
    far = float(rng.choice([5, 40]))
    return [
        (-far, dyadic(rng.uniform(-5, 5))),
        feet[0],
        tuple(map(float, tip)),
        feet[1],
        (far, dyadic(rng.uniform(-5, 5))),
    ], [
        (far, -3000.0),
        (-far, -3000.0),
    ]


KINDS = [uncrossed, cells, star, spiral, ledges, hills, needles]


def terrain_with_closure(rng, kind):
    """A terrain of this kind at some place and of some size, and its closure."""
    while True:
        terrain, closure = kind(rng)
        if len(terrain) < 3 or not is_simple(terrain + closure):
            continue
        scale = 2.0 ** int(rng.choice([0, 0, 0, -10, 12]))
        shift = rng.choice([0.0, 0.0, 0.375, 1000.0], 2) * scale
        moved = [
            [
                (float(x * scale + shift[0]), float(y * scale + shift[1]))
                for x, y in part
            ]
            for part in (terrain, closure)
        ]
        if is_simple(moved[0] + moved[1]):
            return moved


def places(rng, terrain, count):
    """Random points, and points on pieces, at vertices, on lines of pieces and on bisectors, some of them a little aside."""
    corners = np.array(terrain)
    low, high = corners.min(axis=0), corners.max(axis=0)
    if len(corners) > 3 and high[0] - low[0] > 6 * (
        corners[1:-1, 0].max() - corners[1:-1, 0].min()
    ):
        low, high = (
            np.minimum(corners[1], corners[-2]) - 3,
            np.maximum(corners[1], corners[-2]) + 3,
        )
    size = float(max(high - low))
    for _ in range(count):
        k = int(rng.integers(len(corners) - 1))
        a, b = corners[k], corners[k + 1]
        v = corners[int(rng.integers(1, len(corners) - 1)) if len(corners) > 2 else 0]
        sort = int(rng.integers(8))
        if sort <= 1:
            p = rng.uniform(low - 0.3 * size, high + 0.3 * size)
        elif sort == 2:
            p = a + (b - a) * rng.choice([0.5, 0.25, rng.uniform()])
        elif sort == 3:
            p = v
        elif sort == 4:
            p = a + (b - a) * rng.choice([-0.5, 1.5, rng.uniform(-2, 3)])
        elif sort == 5 and 0 < k:
            one, two = (
                (b - a) / math.dist(a, b),
                (a - corners[k - 1]) / math.dist(a, corners[k - 1]),
            )
            way = np.array([-(one + two)[1], (one + two)[0]])
            p = a + way * size * rng.choice(
                [0.125, -0.125, rng.uniform(-0.5, 0.5), rng.uniform(-1e-3, 1e-3)]
            )
        elif sort == 6:
            p = v + size * rng.normal(size=2) * 10.0 ** rng.uniform(-14, 0)
        else:
            p = np.round(rng.uniform(low - 1, high + 1) * 2) / 2
        if rng.random() < 0.3:
            beside = np.nextafter(p, p + rng.choice([-1.0, 0.0, 1.0], 2))
            p = np.where(np.abs(p) < 1e-20, p, beside)
        yield tuple(map(float, p))


def start_of_run(posture, q):
    """A run that ends at its start."""
    return sf.simulate(posture, q, (0, 0, 0), time_limit=0, event_limit=10)


def body(terrain, *points, center=None):
    return sf.Posture(
        mass=1,
        gyration_radius=SIZE,
        center_of_mass=points[0] if center is None else center,
        contacts=[sf.Contact(point) for point in points],
        restitution=0,
        terrain=terrain,
    )


def corners_of(terrain):
    """The terrain without vertices on the straight line between their neighbours, which are no ends of pieces. Exact."""
    exact = [tuple(map(Fraction, vertex)) for vertex in terrain]
    kept = [0]
    for k in range(1, len(terrain) - 1):
        (ax, ay), (bx, by), (cx, cy) = exact[kept[-1]], exact[k], exact[k + 1]
        one, two = (bx - ax, by - ay), (cx - bx, cy - by)
        turns = one[0] * two[1] != one[1] * two[0]
        if turns or one[0] * two[0] + one[1] * two[1] < 0:
            kept.append(k)
    return [terrain[k] for k in [*kept, len(terrain) - 1]]


@cache
def scene(seed):
    """A terrain and its region."""
    rng = np.random.default_rng([31, seed])
    terrain, closure = terrain_with_closure(rng, KINDS[seed % len(KINDS)])
    return terrain, Region(corners_of(terrain), closure)
