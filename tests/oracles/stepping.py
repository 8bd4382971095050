"""Moreau's time stepping with a fixed step, for many convex polygons on polylines at once: a method of first order, apart from
the library.

In each step the gaps are those in the middle of the step. The contacts that are closed there have impulses with

    0 ≤ p_n ⊥ u_n⁺ + e u_n⁻ ≥ 0,        −p_t ∈ μ p_n Sgn(u_t⁺ + e_t u_t⁻),

found by Gauss and Seidel's iterations. Contacts are corners of the body on pieces of the ground, and convex corners of the
ground on sides of the body. A corner that is in the ground, or in the body, by a little is held by the piece, or side, that is
nearest to it. Penetrations of the order of the step remain.
"""

from dataclasses import dataclass

import numpy as np

#: Contacts of a body that are treated at once; flush on a stair in a vertex it has four.
MOST = 5
#: Gauss and Seidel's iterations end when no velocity changes by more than this, in m/s, or after so many.
CHANGE, ITERATIONS = 1e-11, 300
#: A body that has been slower than this, in m/s, for so many steps is at rest.
SLOW, STILL = 1e-7, 100


@dataclass
class Bodies:
    """``count`` bodies with as many corners each, on terrains with as many vertices each. Angles in rad, SI units."""

    arms: np.ndarray  # (count, corners, 2) from the centre of mass, counterclockwise
    terrain: np.ndarray  # (count, vertices, 2) from left to right
    rho2: np.ndarray  # (count,) as all below
    friction: np.ndarray
    restitution: np.ndarray
    tangential_restitution: np.ndarray
    place: np.ndarray  # (count, 3) centre of mass and rotation
    speed: np.ndarray  # (count, 3)
    gravity: float = 9.81

    @staticmethod
    def of_postures(postures, q, qdot, tangential_restitution):
        """Postures whose contacts are the corners of their outlines, with their starts."""
        arrays = [
            [np.subtract(p.outline, p.center_of_mass) for p in postures],
            [p.terrain for p in postures],
            [p.gyration_radius**2 for p in postures],
            [p.contacts[0].friction for p in postures],
            [p.restitution for p in postures],
            tangential_restitution,
            [np.add(at, (*p.center_of_mass, 0)) for p, at in zip(postures, q, strict=True)],
            qdot,
        ]  # fmt: skip
        return Bodies(*(np.array(a, dtype=float) for a in arrays), postures[0].gravity)

    def some(self, rows):
        """The bodies with these numbers."""
        fields = {
            name: value[rows] if isinstance(value, np.ndarray) else value
            for name, value in vars(self).items()
        }
        return Bodies(**fields)


class Frames:
    """The numbers of the bodies that do not change, and their contacts at any place."""

    def __init__(self, bodies):
        self.bodies = bodies
        v = bodies.terrain
        way = np.diff(v, axis=1)
        self.length = np.hypot(way[..., 0], way[..., 1])
        self.tangent = way / self.length[..., None]
        self.normal = np.stack([-self.tangent[..., 1], self.tangent[..., 0]], -1)
        turn = _cross(self.tangent[:, :-1], self.tangent[:, 1:])
        #: Of the inner vertices: corners of the ground, where it turns to the right.
        self.convex = turn < -1e-12
        a = bodies.arms
        side = np.roll(a, -1, axis=1) - a
        self.side = side / np.hypot(side[..., 0], side[..., 1])[..., None]
        self.outward = np.stack([self.side[..., 1], -self.side[..., 0]], -1)
        self.offset = (self.outward * a).sum(-1)
        #: A corner that is deeper is on the other side of the ground, or of the body.
        self.deep = 0.5 * self.offset.min(axis=1)

    def closed(self, place):
        """Arms and normals of the closed contacts, and which of them there are: (count, MOST, 2) twice, (count, MOST), and
        numbers that name them."""
        b, rows = self.bodies, np.arange(len(place))[:, None]
        cos, sin = np.cos(place[:, 2]), np.sin(place[:, 2])
        turn = np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], 1)
        arms = np.einsum("nij,nkj->nki", turn, b.arms)
        outward = np.einsum("nij,nkj->nki", turn, self.outward)
        corners = place[:, None, :2] + arms
        deep = self.deep[:, None, None]

        # Corners of the body : (count, corners, pieces).
        off = corners[:, :, None] - b.terrain[:, None, :-1]
        gaps = (off * self.normal[:, None]).sum(-1)
        along = (off * self.tangent[:, None]).sum(-1)
        near = (along > -deep) & (along < self.length[:, None] + deep)
        on = (gaps <= 0) & (gaps > -deep) & near
        both = on[..., :-1] & on[..., 1:] & self.convex[:, None]
        first = gaps[..., :-1] >= gaps[..., 1:]
        on[..., 1:] &= ~(both & first)
        on[..., :-1] &= ~(both & ~first)
        # Beyond a convex end of its piece a corner is not over it; above a piece beside it, it is not in the ground.
        past = (along[..., :-1] > self.length[:, None, :-1]) & self.convex[:, None]
        on[..., :-1] &= ~(past & (gaps[..., 1:] > 0))
        past = (along[..., 1:] < 0) & self.convex[:, None]
        on[..., 1:] &= ~(past & (gaps[..., :-1] > 0))

        # Corners of the ground : (count, vertices, sides).
        vertex = b.terrain[:, 1:-1]
        lever = vertex - place[:, None, :2]
        height = np.einsum("nvi,nki->nvk", lever, outward) - self.offset[:, None]
        highest = height.max(-1)
        at = height.argmax(-1)
        touched = (highest <= 0) & (highest > -self.deep[:, None]) & self.convex

        # A corner of the body and one of the ground in each other: only the contact that is less deep.
        apart = corners[:, :, None] - vertex[:, None]
        close = np.hypot(apart[..., 0], apart[..., 1]) < 0.1 * deep
        gap_of_corner = np.where(on, gaps, -np.inf).max(-1)
        both = close & on.any(-1)[..., None] & touched[:, None]
        deeper = gap_of_corner[..., None] < highest[:, None]
        on &= ~(both & deeper).any(2)[..., None]
        touched &= ~(both & ~deeper).any(1)

        some = np.concatenate([on.reshape(len(place), -1), touched], axis=1)
        names = np.argsort(~some, axis=1, kind="stable")[:, :MOST]
        here = np.take_along_axis(some, names, 1)
        pieces, count = b.terrain.shape[1] - 1, on[0].size
        is_corner = names < count
        corner, piece = np.divmod(np.where(is_corner, names, 0), pieces)
        ground = np.where(is_corner, 0, names - count)
        arm = np.where(is_corner[..., None], arms[rows, corner], lever[rows, ground])
        normal = np.where(
            is_corner[..., None],
            self.normal[rows, piece],
            -outward[rows, at[rows, ground]],
        )
        return arm, normal, here, np.where(here, names, -1)


def _cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _impulses(bodies, free, before, arm, normal, here, start):
    """Impulses (normal, tangential) per unit mass : (count, MOST, 2), and the velocity with them."""
    tangent = np.stack([normal[..., 1], -normal[..., 0]], -1)
    inverse = 1 / bodies.rho2
    axes = []
    for way in (normal, tangent):
        moment = _cross(arm, way)
        row = np.concatenate([way, moment[..., None]], -1)
        answer = row.copy()
        answer[..., 2] *= inverse[:, None]
        yields = (row * answer).sum(-1)
        axes.append((row, answer, yields))
    (n, n_answer, n_yields), (t, t_answer, t_yields) = axes
    n_aim = bodies.restitution[:, None] * (n * before[:, None]).sum(-1)
    t_aim = bodies.tangential_restitution[:, None] * (t * before[:, None]).sum(-1)
    p = np.where(here[..., None], start, 0.0)
    u = free + (n_answer * p[..., :1] + t_answer * p[..., 1:]).sum(1)
    used = [k for k in range(MOST) if here[:, k].any()]
    for _ in range(ITERATIONS):
        last = u.copy()
        for k in used:
            wanted = p[:, k, 0] - ((n[:, k] * u).sum(-1) + n_aim[:, k]) / n_yields[:, k]
            wanted = np.where(here[:, k], np.maximum(wanted, 0.0), 0.0)
            u += n_answer[:, k] * (wanted - p[:, k, 0])[:, None]
            p[:, k, 0] = wanted
            most = bodies.friction * wanted
            wanted = p[:, k, 1] - ((t[:, k] * u).sum(-1) + t_aim[:, k]) / t_yields[:, k]
            wanted = np.clip(wanted, -most, most)
            u += t_answer[:, k] * (wanted - p[:, k, 1])[:, None]
            p[:, k, 1] = wanted
        if np.abs(u - last).max() < CHANGE:
            break
    return p, u


def simulate(bodies, step, end, each=None):
    """Places and velocities at ``end``. ``each(t, place, speed)`` is called after each step."""
    frames = Frames(bodies)
    place, speed = bodies.place.copy(), bodies.speed.copy()
    p = np.zeros((len(place), MOST, 2))
    names = np.full((len(place), MOST), -1)
    still = np.zeros(len(place), dtype=int)
    reach = np.hypot(*np.moveaxis(bodies.arms, -1, 0)).max(1)
    for k in range(round(end / step)):
        middle = place + 0.5 * step * speed
        arm, normal, here, now = frames.closed(middle)
        free = speed + np.array([0, -bodies.gravity, 0]) * step
        after = free.copy()
        rows = np.flatnonzero(here.any(1))
        if len(rows):
            # Impulses of the last step are a good start where the contacts are the same.
            same = (now[rows] == names[rows]).all(1)
            start = np.where(same[:, None, None], p[rows], 0.0)
            given = bodies.some(rows), free[rows], speed[rows]
            found = _impulses(*given, arm[rows], normal[rows], here[rows], start)
            p[rows], after[rows] = found
        names = now
        place, speed = middle + 0.5 * step * after, after
        if each is not None:
            each((k + 1) * step, place, speed)
            continue
        fast = np.hypot(speed[:, 0], speed[:, 1]) + reach * np.abs(speed[:, 2])
        still = np.where(fast < SLOW, still + 1, 0)
        if (still > STILL).all():
            break
    return place, speed
