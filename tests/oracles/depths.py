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
