"""How deep a polygonal body and the ground are in each other, from the two polygons alone.

The ground is to the right of its polyline, which goes from left to right. Depths are in m: positive inside, otherwise minus the
distance.
"""

import itertools

import numpy as np

#: Distance in m by which the ground is continued below the terrain.
FAR = 1e6


def placed(points, center, q):
    """Points of a body at configurations q : (n, 3); (n, k, 2)."""
    arms = np.asarray(points, dtype=float) - np.asarray(center, dtype=float)
    x, y, theta = np.atleast_2d(np.asarray(q, dtype=float)).T[:, :, None]
    cos, sin = np.cos(theta), np.sin(theta)
    return np.stack(
        [
            center[0] + x + cos * arms[:, 0] - sin * arms[:, 1],
            center[1] + y + sin * arms[:, 0] + cos * arms[:, 1],
        ],
        axis=-1,
    )


def distance(points, a, b):
    """Distance of points : (..., 2) from the segment a b : (..., 2)."""
    way = b - a
    along = ((points - a) * way).sum(-1) / (way * way).sum(-1)
    off = points - a - np.clip(along, 0, 1)[..., None] * way
    return np.hypot(off[..., 0], off[..., 1])


def crosses(points, a, b):
    """Whether the ray upwards from the points crosses the segment a b."""
    x, y = points[..., 0], points[..., 1]
    right, left = a[..., 0] > x, b[..., 0] > x
    run = np.where(right != left, b[..., 0] - a[..., 0], 1.0)
    height = a[..., 1] + (x - a[..., 0]) * (b[..., 1] - a[..., 1]) / run
    return (right != left) & (y < height)


def in_ground(points, terrain):
    """Depth of points : (..., 2) below a polyline. A point is in the ground if a ray upwards from it leaves the ground."""
    terrain = np.asarray(terrain, dtype=float)
    below = [(terrain[-1, 0], -FAR), (terrain[0, 0], -FAR)]
    around = np.concatenate([terrain, below])
    inside = np.zeros(points.shape[:-1], dtype=bool)
    for a, b in zip(around, np.roll(around, -1, axis=0), strict=True):
        inside ^= crosses(points, a, b)
    away = np.full(points.shape[:-1], np.inf)
    for a, b in itertools.pairwise(terrain):
        away = np.minimum(away, distance(points, a, b))
    return np.where(inside, away, -away)


def in_body(point, corners):
    """Depth of a point in polygons with the corners : (n, k, 2)."""
    inside = np.zeros(len(corners), dtype=bool)
    away = np.full(len(corners), np.inf)
    point = np.asarray(point, dtype=float)
    for k in range(corners.shape[1]):
        a, b = corners[:, k - 1], corners[:, k]
        inside ^= crosses(point, a, b)
        away = np.minimum(away, distance(point, a, b))
    return np.where(inside, away, -away)


def deepest(outline, center, terrain, q):
    """At each of the configurations q : (n, 3), the largest depth of a corner of the body in the ground, and of a corner of
    the ground in the body; (2, n)."""
    corners = placed(outline, center, q)
    into_body = [in_body(vertex, corners) for vertex in terrain]
    return np.stack(
        [in_ground(corners, terrain).max(axis=1), np.max(into_body, axis=0)]
    )


def deepest_of_run(run, count=1000):
    """The same, at ``count`` times of a run and at its first thousand events; (times, depths : (2, n))."""
    events = [t for phase in run.phases for t in (phase.start, phase.end)]
    times = [np.linspace(0, run.time, count), events[:1000], run.impacts["time"][:1000]]
    times = np.unique(np.clip(np.concatenate(times), 0, run.time))
    posture = run.posture
    body = posture.outline, posture.center_of_mass, posture.terrain
    return times, deepest(*body, run.at(times)[0])


def crossings(outline, center, terrain, q):
    """At each of the configurations q : (n, 3), how far a side of the body and a piece of the ground are through each other: the least
    distance of their four ends from the other line, where they cross; (n,)."""
    corners = placed(outline, center, q)
    deepest = np.zeros(len(corners))

    def heights(a, b, points):
        way = b - a
        off = points - a
        cross = way[..., 0] * off[..., 1] - way[..., 1] * off[..., 0]
        return cross / np.hypot(way[..., 0], way[..., 1])

    for k in range(corners.shape[1]):
        a, b = corners[:, k - 1], corners[:, k]
        for one, other in itertools.pairwise(np.asarray(terrain, dtype=float)):
            ends = [heights(one, other, p) for p in (a, b)]
            ends += [heights(a, b, p) for p in (one, other)]
            cross = (ends[0] * ends[1] < 0) & (ends[2] * ends[3] < 0)
            depth = np.where(cross, np.abs(ends).min(axis=0), 0.0)
            deepest = np.maximum(deepest, depth)
    return deepest


#: Time in s from the state before an impact to the impact, and of the flight after it.
BEFORE, FLIGHT = 1e-9, 1e-6
#: Slower impacts, in m/s, have less depth in this time than gravity and rotation account for.
SLOW = 0.01


def without_approach(run):
    """The times of impacts at which nothing approaches: were the body free from there on, neither polygon would enter the other. All
    impacts of an instant are looked at as one, and only if they change the velocity by some amount."""
    found, posture = [], run.posture
    size = np.hypot(*(np.array(posture.outline) - posture.center_of_mass).T).max()
    for t in np.unique(run.impacts["time"]):
        q, v = (np.array(x) for x in run.at(t - BEFORE))
        change = np.abs(run.at(t)[1] - v) * (1, 1, size)
        if change.max() < SLOW:
            continue
        free = q + v * (BEFORE + FLIGHT) - (0, FLIGHT**2 * posture.gravity / 2, 0)
        shapes = posture.outline, posture.center_of_mass, posture.terrain, [free]
        depth = max(deepest(*shapes).max(), crossings(*shapes).max())
        if depth < 1e-3 * change.max() * FLIGHT:
            found.append(float(t))
    return found


def through(run, count=400):
    """The largest depth of the body and the ground of a run in each other, in m, at so many times and at all events."""
    posture = run.posture
    events = [phase.start for phase in run.phases] + list(run.impacts["time"])
    times = np.unique(np.append(np.linspace(0, run.time, count), events))
    shapes = posture.outline, posture.center_of_mass, posture.terrain, run.at(times)[0]
    return max(deepest(*shapes).max(), crossings(*shapes).max())
