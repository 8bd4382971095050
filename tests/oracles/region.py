"""The region over a terrain in exact integers: whether a point is free, on the ground or in it, its nearest ground, and its gap.

A terrain is a part of the boundary of a polygon: `closure` has the vertices from its last vertex back to its first one. The number of
edges of the polygon that a ray crosses decides on which side of the terrain a point lies. This holds where the terrain is nearer to the
point than the rest of the polygon.
"""

import math
from fractions import Fraction
from itertools import pairwise

#: Digits of a binary fraction that coordinates may have.
DIGITS = 200


def exact(point):
    """A point in integers; the unit is 2^-DIGITS."""
    ratios = (float(x).as_integer_ratio() for x in point)
    scaled = tuple(Fraction(n << DIGITS, d) for n, d in ratios)
    assert all(x.denominator == 1 for x in scaled)
    return tuple(x.numerator for x in scaled)


def cross(a, b, c):
    """Twice the area of a triangle: positive if c lies on the left of the way from a to b."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def along(a, b, c):
    return (b[0] - a[0]) * (c[0] - a[0]) + (b[1] - a[1]) * (c[1] - a[1])


def square(a, b):
    return (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2


def meets(a, b, c, d):
    """Whether the edges ab and cd have a point in common."""

    def side(p, q, r):
        z = cross(p, q, r)
        return (z > 0) - (z < 0)

    def holds(p, q, r):
        return (
            side(p, q, r) == 0
            and min(p[0], q[0]) <= r[0] <= max(p[0], q[0])
            and min(p[1], q[1]) <= r[1] <= max(p[1], q[1])
        )

    if (
        side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
    ):  # they cross
        return True
    return holds(a, b, c) or holds(a, b, d) or holds(c, d, a) or holds(c, d, b)


def is_simple(polygon):
    """Whether the edges of a closed polygon meet only in their vertices."""
    polygon = [exact(v) for v in polygon]
    count = len(polygon)
    edges = [(polygon[k], polygon[(k + 1) % count]) for k in range(count)]
    for j, (c, d) in enumerate(edges):
        if c == d:
            return False
        for i, (a, b) in enumerate(edges[:j]):
            if (i + 1) % count == j or (j + 1) % count == i:
                p, q, r = (a, b, d) if b == c else (b, a, c)
                if cross(p, q, r) == 0 and along(q, p, r) > 0:
                    return False
            elif meets(a, b, c, d):
                return False
    return True


class Region:
    """The polygon of a terrain and its closure."""

    def __init__(self, terrain, closure):
        self.vertices = [exact(v) for v in terrain]
        self.polygon = [*self.vertices, *(exact(v) for v in closure)]
        edges = list(
            zip(self.polygon, self.polygon[1:] + self.polygon[:1], strict=True)
        )
        self.rest = edges[len(terrain) - 1 :]
        self.pieces = list(pairwise(self.vertices))
        self.edges = edges
        # Counterclockwise, the left side of the terrain is the inside of the polygon.
        self.free_is_inside = sum(a[0] * b[1] - a[1] * b[0] for a, b in edges) > 0

    def side(self, p):
        """1: free, 0: on the polygon, -1: in the ground."""
        inside = False
        for a, b in self.edges:
            z = cross(a, b, p)
            if z == 0 and along(a, b, p) >= 0 and along(b, a, p) >= 0:
                return 0
            if (a[1] > p[1]) != (b[1] > p[1]):
                inside ^= (z > 0) == (b[1] > a[1])
        return 1 if inside == self.free_is_inside else -1

    @staticmethod
    def distance(edge, p):
        """Square of the distance of a point from an edge."""
        a, b = edge
        if along(a, b, p) <= 0:
            return Fraction(square(a, p))
        if along(b, a, p) <= 0:
            return Fraction(square(b, p))
        return Fraction(cross(a, b, p) ** 2, square(a, b))

    def beyond(self, k, end, p):
        """Whether a point lies beyond the free end of the first or last piece, k: over this end of a piece that faces up, else over its line."""
        a, b = self.pieces[k]
        if end == 0:
            return p[0] < a[0] if b[0] > a[0] else along(a, b, p) < 0
        return p[0] > b[0] if b[0] > a[0] else along(b, a, p) < 0

    def separates(self, k, p):
        """The side of p of the line between pieces k and k + 1: positive towards the latter."""
        (a, v), (_, b) = self.pieces[k], self.pieces[k + 1]
        if v[0] > a[0] and b[0] > v[0]:
            return p[0] - v[0]
        # x/|a| + y/|b| by the squares of its terms
        x, y = -along(v, a, p), along(v, b, p)
        one, two = x * abs(x) * square(v, b), y * abs(y) * square(a, v)
        return one + two

    def height(self, k, p):
        """Height over the line of piece k, in m, as a double."""
        a, b = self.pieces[k]
        z = cross(a, b, p)
        value = Fraction(z * z, square(a, b) << (2 * DIGITS))
        return root(value) if z > 0 else -root(value)

    def nearest(self, p):
        """The distance of a point from the terrain, in m, and the pieces that may be the nearest one: all pieces
        within the distance times (1 + 1e-13); at a vertex only those on the point's side of the separating line.
        None: the point may be beyond the ends of the terrain."""
        squares = [self.distance(piece, p) for piece in self.pieces]
        least = min(squares)
        if any(self.distance(edge, p) <= least for edge in self.rest):
            return None, None
        near = {
            k for k, s in enumerate(squares) if s <= least * (1 + Fraction(1, 10**13))
        }
        distance, last = root(least / (1 << (2 * DIGITS))), len(self.pieces) - 1
        if all(b[0] > a[0] for a, b in self.pieces):  # no walls: the piece under it
            under = {k for k, (a, b) in enumerate(self.pieces) if a[0] <= p[0] <= b[0]}
            return distance, under or None
        if any(
            (k == 0 and self.beyond(0, 0, p)) or (k == last and self.beyond(last, 1, p))
            for k in near
        ):
            return distance, None
        found = set(near)
        for k in near:
            if k + 1 in near:
                v = self.vertices[k + 1]
                a, b = self.pieces[k][0], self.pieces[k + 1][1]
                if along(v, a, p) <= 0 and along(v, b, p) <= 0:  # nearest to v
                    s = self.separates(k, p)
                    if s:
                        found.discard(k if s > 0 else k + 1)
        return distance, found


def root(x):
    """Square root of a fraction, with an error of a few ulp."""
    if x == 0:
        return 0.0
    shift = 2 * (128 + max(0, x.denominator.bit_length() - x.numerator.bit_length()))
    return float(
        Fraction(math.isqrt((x.numerator << shift) // x.denominator), 1 << (shift // 2))
    )
