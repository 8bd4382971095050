"""A body, or an assembly, and its ground as pictures show them, whatever draws the pictures."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from standfast._core import Contact, Posture, System, SystemMode

_Floats = npt.NDArray[np.float64]

#: A straight piece of ground: a point (2,), the direction (2,) with the air on its left, and the interval along it, m.
Piece = tuple[_Floats, _Floats, float, float]
#: Points of a circle.
ARC = 60
#: Distance of a point from a line on which it is, as a share of the size of the body. Contacts are where sides touch within 1e-9 of it.
ON_LINE = 1e-8
#: Largest displacement of a corner of an assembly that begins to move, as a share of the size of the assembly.
MOVED = 0.1


def placed(posture: Posture, points: _Floats, q: _Floats, frozen: bool) -> _Floats:
    """Points (k, 2) of the body, given in its nominal posture, m, at the configuration q (3,). frozen: with the geometry of the local model.

    >>> rod = Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    >>> placed(rod, np.array([[0.5, 0.0]]), np.array([0.0, 1.0, math.pi / 2]), False).round(12)
    array([[0. , 1.5]])
    """
    nominal = np.array(posture.center_of_mass)
    c, s = (1.0, q[2]) if frozen else (math.cos(q[2]), math.sin(q[2]))
    turned: _Floats = (points - nominal) @ np.array([[c, s], [-s, c]])
    return nominal + q[:2] + turned


def body_outline(posture: Posture, q: _Floats, frozen: bool) -> _Floats:
    """The closed outline of the body (k + 1, 2), m. Without an outline the convex hull of the contacts stands for it, or for one
    point the circle of gyration."""
    corners = posture.drawn_corners
    if corners:
        return placed(posture, np.array([*corners, corners[0]]), q, frozen)
    turns = np.linspace(0.0, 2.0 * math.pi, ARC)
    circle = posture.gyration_radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    return np.array(posture.center_of_mass) + q[:2] + circle


def disc_center(contact: Contact) -> _Floats:
    """The centre (2,) of a round contact in the nominal posture, m; the point of another one."""
    if contact.center is not None:
        return np.array(contact.center)
    up = np.array([-math.sin(contact.slope), math.cos(contact.slope)])
    return np.array(contact.point) + contact.radius * up


def touching_points(posture: Posture, q: _Floats, frozen: bool) -> _Floats:
    """The contacts (n, 2) at the configuration q (3,), m; of a disc, its point nearest to the ground.

    >>> wheel = Posture.disc(radius=0.5)
    >>> touching_points(wheel, np.array([1.0, 0.0, -2.0]), False)
    array([[1., 0.]])
    """
    contacts = posture.contacts
    feet = placed(posture, np.array([disc_center(c) for c in contacts]), q, frozen)
    for foot, contact in zip(feet, contacts, strict=True):
        if contact.radius > 0.0:
            away = []
            for point, tangent, low, high in ground(posture):
                along = np.clip((foot - point) @ tangent, low, high)
                away.append(float(np.hypot(*(foot - point - along * tangent))))
            _, (tx, ty), _, _ = ground(posture)[int(np.argmin(away))]
            foot -= contact.radius * np.array([-ty, tx])
    return feet


def spokes(posture: Posture, contacts: _Floats, q: _Floats, frozen: bool) -> _Floats:
    """Lines (k, 2) of the body, with NaN between them, m: from the centre of mass to the contacts (n, 2), and instead of the line to a
    round contact that to its centre, its circle, and a radius that turns with it."""
    center = np.array(posture.center_of_mass) + q[:2]
    gap = np.full(2, np.nan)
    lines: list[_Floats] = []
    for contact, foot in zip(posture.contacts, contacts, strict=True):
        if contact.radius == 0.0:
            lines += [center, foot, gap]
            continue
        points = np.array([disc_center(contact), contact.point])
        middle, mark = placed(posture, points, q, frozen)
        turns = np.linspace(0.0, 2.0 * math.pi, ARC)
        circle = contact.radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        lines += [center, middle, mark, gap, *(middle + circle), gap]
    return np.array(lines)


def ground(posture: Posture) -> list[Piece]:
    """The ground of a posture as straight pieces: those of its polyline, or the line that all contacts share, or the contacts' own lines."""
    pieces = posture.drawn_ground
    return [(np.array(p), np.array(t), low, high) for p, t, low, high in pieces]


def clipped(piece: Piece, low: _Floats, high: _Floats) -> tuple[float, float] | None:
    """The interval along a piece of ground in which it is inside the box from `low` (2,) to `high` (2,); None if it is outside.

    >>> flat = np.array([0.0, 1.0]), np.array([1.0, 0.0]), -np.inf, 3.0
    >>> clipped(flat, np.array([-2.0, 0.0]), np.array([2.0, 2.0]))
    (-2.0, 2.0)
    """
    point, tangent, first, last = piece
    for axis in range(2):
        if tangent[axis] == 0.0:
            if not low[axis] <= point[axis] <= high[axis]:
                return None
            continue
        with np.errstate(over="ignore"):  # all but parallel to this side of the box
            ends = (np.array([low[axis], high[axis]]) - point[axis]) / tangent[axis]
        first, last = max(first, float(ends.min())), min(last, float(ends.max()))
    return (first, last) if first < last else None


def surface(
    pieces: list[Piece], low: _Floats, high: _Floats, depth: float
) -> tuple[list[_Floats], list[_Floats]]:
    """The ground inside a box: the lines (2, 2) of its surface, and the polygons (k, 2) of a strip of this depth under them, m."""
    shown = []
    for piece in pieces:
        if (ends := clipped(piece, low, high)) is not None:
            point, tangent, *_ = piece
            line = point + np.outer(ends, tangent)
            shown.append((line, line + depth * np.array([tangent[1], -tangent[0]])))
    strips = [np.vstack([line, under[::-1]]) for line, under in shown]
    strips += [  # in the corners between two pieces
        np.vstack([line[1], under[1], under_then[0]])
        for line, under in shown
        for then, under_then in shown
        if np.allclose(line[1], then[0], rtol=0.0, atol=1e-6 * depth)
    ]
    return [line for line, _ in shown], strips


def system_ground(system: System) -> list[Piece]:
    """The ground of an assembly as straight pieces.

    >>> from standfast import Block
    >>> [(point.tolist(), low, high) for point, _, low, high in system_ground(System([Block(1, 1)], ground=0.0))]
    [([0.0, 0.0], -inf, inf)]
    """
    line = system.ground
    if line is None:
        return []
    if np.ndim(line) == 0:
        return [(np.array([0.0, line]), np.array([1.0, 0.0]), -math.inf, math.inf)]
    ways = [(p, q - p, math.hypot(*(q - p))) for p, q in pairwise(np.asarray(line))]
    return [(p, way / length, 0.0, length) for p, way, length in ways]


def joints(system: System) -> list[list[int]]:
    """The contacts, from 0, by joints: the two of a pair of flush sides, or one.

    >>> from standfast import Block
    >>> joints(System([Block(1, 1), Block(1, 1, at=(0, 1))]))
    [[0, 1], [2, 3]]
    """
    corners = {name: body.outline for name, body in system.bodies.items()}
    found: list[list[int]] = []
    for k, contact in enumerate(system.contacts):
        last = found[-1] if found else []
        if len(last) == 1:
            other = system.contacts[last[0]]
            ends = np.array([other.point, contact.point])
            both = [corners[name] for name in contact.bodies if name is not None]
            if contact.bodies == other.bodies and all(on_side(ends, c) for c in both):
                last.append(k)
                continue
        found.append([k])
    return found


def on_side(points: _Floats, corners: _Floats) -> bool:
    """Whether one side of a polygon (n, 2) has all points (k, 2), m.

    >>> square = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    >>> on_side(np.array([(0, 0), (0.5, 0)]), square), on_side(np.array([(0, 0), (1, 1)]), square)
    (True, False)
    """
    way = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*way.T)[:, None]
    arm = points - corners[:, None]
    across = (way[:, None, 0] * arm[..., 1] - way[:, None, 1] * arm[..., 0]) / length
    along = (way[:, None] * arm).sum(axis=-1) / length
    room = ON_LINE * float(np.ptp(corners, axis=0).max())
    on = (abs(across) <= room) & (along >= -room) & (along <= length + room)
    return bool(on.all(axis=1).any())


class JointForce(NamedTuple):
    """The force of a joint on the first of its bodies: its contacts, from 0, the point where it acts (2,), m, and the force (2,), N."""

    contacts: list[int]
    point: _Floats
    force: _Floats


def joint_forces(system: System, forces: _Floats) -> list[JointForce]:
    """The forces of joints that press, from those of the contacts, tangential and normal (n, 2), N.

    >>> from standfast import Block
    >>> (force,) = joint_forces(System([Block(1, 1)]), np.array([(0, 1), (0, 3)]))
    >>> force.point.tolist(), force.force.tolist()
    ([0.25, 0.0], [0.0, 4.0])
    """
    contacts, found = system.contacts, []
    for joint in joints(system):
        normal = forces[joint, 1]
        if normal.sum() > 0.0:
            point = normal @ np.array([contacts[k].point for k in joint]) / normal.sum()
            t = contacts[joint[0]].tangent
            force = forces[joint].sum(axis=0) @ np.array([t, [-t[1], t[0]]])
            found.append(JointForce(joint, point, force))
    return found


def displaced(mode: SystemMode) -> tuple[list[_Floats], _Floats]:
    """The outlines of the bodies of a mode, moved along their accelerations and turned, by so much that to first order the corner that moves
    farthest moves by a tenth of the size of the assembly; and the points of both bodies of its contacts (n, 2, 2), m.

    >>> from standfast import Block
    >>> brick = System([Block(2, 1)])
    >>> outlines, contacts = displaced(SystemMode(brick, "RR", [3, 0, 0], np.zeros((2, 2))))
    >>> contacts.tolist()
    [[[-0.8, 0.0], [-1.0, 0.0]], [[1.2, 0.0], [1.0, 0.0]]]
    """
    bodies = mode.system.bodies
    motions = mode.acceleration.reshape(-1, 3)
    arms = [body.outline - body.center_of_mass for body in bodies.values()]
    ways = [a[:2] + a[2] * arm[:, ::-1] * (-1, 1) for a, arm in zip(motions, arms, strict=True)]  # fmt: skip
    farthest = max(float(np.hypot(*way.T).max()) for way in ways)
    whole = np.ptp(np.vstack([body.outline for body in bodies.values()]), axis=0)
    scale = MOVED * float(whole.max()) / farthest if farthest > 0.0 else 0.0
    steps = dict(zip(bodies, scale * motions, strict=True))

    def moved(name: str | None, points: _Floats) -> _Floats:
        if name is None:
            return points
        step, center = steps[name], bodies[name].center_of_mass
        c, s = math.cos(step[2]), math.sin(step[2])
        turned = (points - center) @ np.array([[c, s], [-s, c]])
        placed: _Floats = center + step[:2] + turned
        return placed

    outlines = [moved(name, body.outline) for name, body in bodies.items()]
    points = [
        [moved(name, contact.point) for name in contact.bodies]
        for contact in mode.system.contacts
    ]
    return outlines, np.array(points).reshape(-1, 2, 2)
