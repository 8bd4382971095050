"""Certificates of verdicts: the scene as exact doubles, the claim, and what its checker needs."""

import math
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from standfast import certificate
from standfast._core import (
    Contact,
    Mechanism,
    MechanismProblem,
    Posture,
    Verdict,
    contact_modes,
    stability,
)
from standfast.certificate.exact import inner
from standfast.certificate.goes_on import Sliding, sliding_of
from standfast.certificate.levels import raised_sets, sliding_sets
from standfast.certificate.mechanism import Pad, Rows, rows_of

Vectors = npt.NDArray[np.float64]

#: Rounding error of a product of two unit vectors, with room.
ROUNDING = 1e-14
#: Largest number of edges with which fractions are tried.
MOST = 41


def make(verdict: Verdict) -> dict[str, Any]:
    """The certificate of a verdict, which has been checked. Raises ValueError if there is none."""
    if verdict.by is None:
        raise ValueError(
            "the verdict is undecided; only a decided one has a certificate"
        )
    if verdict.mechanism is not None:
        body = body_of(verdict.mechanism)
        if body is not None:
            return make(stability(body, jams=verdict.after_jam, width=verdict.width))
    by = verdict.by
    found: dict[str, Any] = {
        "conventions": certificate.CONVENTIONS,
        "scene": scene_of(verdict),
    }
    if verdict.mechanism is None:
        assert verdict.posture is not None
        found |= _claimed(
            verdict.posture,
            verdict.contacts,
            verdict.frictional_stability,
            by,
            verdict.evidence,
            verdict.after_jam,
        )
    else:
        found["claim"] = {
            "frictional_stability": verdict.frictional_stability,
            "by": by,
            "contacts": verdict.contacts,
            "jams": verdict.after_jam,
        }
        found["data"] = mechanism_data(
            verdict.mechanism, rows_of(found["scene"]), by, verdict.evidence
        )
    try:
        certificate.check(found)
    except ValueError as error:
        if by == "theorem-3":
            # The strict reading may hold by a tie only.
            found["claim"]["by"] = "theorem-3-loose"
            with suppress(ValueError):
                certificate.check(found)
                return found
        raise ValueError(
            f"the verdict is {verdict.frictional_stability}, but its certificate does not hold: {error}"
        ) from error
    return found


def _contacts(posture: Posture) -> list[Contact]:
    """The contacts of a posture, and its sides on corners of the ground."""
    return [*posture.contacts, *posture.side_contacts]


def scene(posture: Posture, contacts: Sequence[int]) -> dict[str, Any]:
    """The body on the contacts that touch, each on the straight line of its ground."""
    feet = [(k, _contacts(posture)[k - 1]) for k in contacts]
    rest = posture.restitution
    return {
        "mass": posture.mass.hex(),
        "gyration_radius": posture.gyration_radius.hex(),
        "center_of_mass": [float(part).hex() for part in posture.center_of_mass],
        "gravity": posture.gravity.hex(),
        "contacts": [
            {
                "number": k,
                "point": [float(part).hex() for part in foot.point],
                "slope": foot.slope.hex(),
                "friction": foot.friction.hex(),
                "restitution": (
                    rest if foot.restitution is None else foot.restitution
                ).hex(),
            }
            for k, foot in feet
        ],
    }


def body_of(mechanism: Mechanism) -> Posture | None:
    """The rigid body that a mechanism is with all joints locked; None if it is none."""
    with suppress(ValueError):
        return mechanism.posture()
    return None


def scene_of(verdict: Verdict) -> dict[str, Any]:
    """The scene of the certificate of a verdict."""
    if verdict.mechanism is None:
        assert verdict.posture is not None
        return scene(verdict.posture, verdict.contacts)
    body = body_of(verdict.mechanism)
    if body is not None:
        return scene(body, verdict.contacts)
    return mechanism_scene(verdict.mechanism)


def free_coordinates(mechanism: Mechanism) -> list[int]:
    """Those that are not locked."""
    return sorted(set(range(mechanism.dof)) - set(mechanism.locked))


def mechanism_scene(mechanism: Mechanism) -> dict[str, Any]:
    """The constant rows of a mechanism, in the coordinates that are not locked."""
    free = free_coordinates(mechanism)

    def exact(row: Vectors) -> list[str]:
        return [float(row[k]).hex() for k in free]

    mass = mechanism.mass_matrix.copy()
    if mechanism.armature is not None:
        mass += np.diag(mechanism.armature)
    rest = mechanism.restitution
    return {
        "mass_matrix": [exact(mass[k]) for k in free],
        "load": exact(mechanism.load),
        "contacts": [
            {
                "number": k,
                "normal": exact(rows.normal),
                "tangential": exact(rows.tangential),
                "friction": rows.friction.hex(),
                "restitution": (
                    rest if rows.restitution is None else rows.restitution
                ).hex(),
                "tangential_restitution": rows.tangential_restitution.hex(),
            }
            for k, rows in enumerate(mechanism.contacts, start=1)
        ],
    }


def same_scene(stated: Any, real: Any, path: Path, name: str = "scene") -> None:
    """Refuses the scene of a certificate that is not the one of a scene file, and names the first value that differs."""
    if isinstance(real, dict):
        for key, part in real.items():
            if key not in stated:
                raise ValueError(f"{name} has no entry {key!r}; {path} has one")
            same_scene(stated[key], part, path, f"{name}.{key}")
    elif isinstance(real, list) and len(stated) == len(real):
        for k, part in enumerate(real):
            same_scene(stated[k], part, path, f"{name}[{k}]")
    elif isinstance(real, list):
        raise ValueError(f"{name} has {len(stated)} entries; {path} has {len(real)}")
    elif stated != real:
        value, own = (
            float.fromhex(x) if isinstance(x, str) else x for x in (stated, real)
        )
        raise ValueError(f"{name} is {value}; in {path} it is {own}")


def _claimed(
    posture: Posture,
    contacts: Sequence[int],
    stability: str,
    by: str,
    evidence: Any,
    jams: str,
) -> dict[str, Any]:
    """The claim and its data, for a body on these contacts only."""
    return {
        "claim": {
            "frictional_stability": stability,
            "by": by,
            "contacts": list(contacts),
            "jams": jams,
        },
        "data": _data(posture, contacts, by, evidence, jams),
    }


def _data(
    posture: Posture, contacts: Sequence[int], by: str, evidence: Any, jams: str
) -> Any:
    def exact(values: Sequence[float]) -> list[str]:
        return [float(value).hex() for value in values]

    match by:
        case "not-equilibrium":
            return {"separates": exact(separating(posture, contacts).tolist())}
        case "no-solution":
            return start(evidence)
        case "theorem-3" | "theorem-3-loose" | "goyal" | "single-support":
            return {}
        case "well":
            return {
                "width": float(evidence["width"]).hex(),
                "rays": [ray["contacts"] for ray in evidence["rays"]],
            }
        case "descending-pair":
            return {
                "rays": [ray["contacts"] for ray in evidence["rays"]],
                "pairs": [
                    _claimed(
                        posture,
                        pair["contacts"],
                        pair["frictional_stability"],
                        pair["by"],
                        pair["evidence"],
                        jams,
                    )
                    for pair in evidence["pairs"]
                ],
            }
        case "neutral":
            return {"outer": evidence["outer"]}
        case "corner-map":
            return {
                "limits": exact(evidence["limits"]),
                "potential": [exact(values) for values in evidence["potential"]],
                "ends": [
                    [None if end is None else float(end).hex() for end in ends]
                    for ends in evidence["ends"]
                ],
            }
        case "growing-cycle":
            return {"corners": [_corner(corner) for corner in evidence]}
        case "growing-trap":
            return {"ranges": [_range(part) for part in evidence]}
        case "accelerating-mode" if isinstance(evidence, str):
            return {"word": evidence}
        case "accelerating-mode" if "phi" in evidence:
            return {"corner": _corner(evidence)}
        case "accelerating-mode":
            return {"word": evidence["word"], "velocity": exact(evidence["velocity"])}
    raise ValueError(
        f"there is no certificate yet of a verdict by {by} with this evidence"
    )


def _corner(corner: Any) -> dict[str, Any]:
    """A corner: the contact that lands, and the speed of the slide of the other one over the landing speed."""
    return {"contact": corner["contact"], "slope": math.tan(corner["phi"]).hex()}


def _range(part: Any) -> dict[str, Any]:
    """Corners of a trap: the ends of ξ/y, and W."""
    slope = [end if isinstance(end, str) else float(end).hex() for end in part["slope"]]
    weight = float(part["weight"]).hex()
    return {"contact": part["contact"], "slope": slope, "weight": weight}


def start(evidence: Any, among: Sequence[int] | None = None) -> dict[str, Any]:
    """A start without a motion, in some of the coordinates."""
    found = {key: evidence[key] for key in ("contacts", "slides")}
    for key in ("q", "qdot"):
        values = evidence[key]
        found[key] = [float(values[k]).hex() for k in among or range(len(values))]
    return found


def mechanism_data(mechanism: Mechanism, rows: Rows, by: str, evidence: Any) -> Any:
    match by:
        case "not-equilibrium":
            return {"separates": texts(holding_none(rows, rows.feet))}
        case "no-solution":
            return start(evidence, free_coordinates(mechanism))
        case "potential-well":
            forces = bearing_forces(rows, evidence["largest"])
            sliding = sliding_sets(rows, forces)
            sets = sliding and {*sliding, *raised_sets(rows, forces)}
            largest = [own for own in sets if not any(own < other for other in sets)]
            return going_on(mechanism, rows) | {
                "forces": texts(forces),
                "separates": [
                    {
                        "contacts": [rows.feet[k].name for k in own],
                        "y": texts(holding_none(rows, [rows.feet[k] for k in own])),
                    }
                    for own in sorted(map(sorted, largest))
                ],
            }
    raise ValueError(f"there is no certificate yet of a verdict by {by} on a mechanism")


def going_on(mechanism: Mechanism, rows: Rows) -> dict[str, Any]:
    """A lift, and the modes of the states of contact in which the contacts are not stiff; nothing if there are none."""
    sliding = sliding_of(rows)
    found = []
    for state in sliding.loose_states():
        closed, sides = sorted(state[0]), sliding.sides(state[1])
        slides = [
            None if k not in state[0] else sides[k] if sliding.of[k][1] else 1
            for k in range(len(rows.feet))
        ]
        modes = contact_modes(MechanismProblem(mechanism, slides))
        names = [rows.feet[k].name for k in closed]
        if not modes.consistent:
            raise ValueError(
                f"no mode of contacts {names} is found while they slide {sliding.letters(state)}"
            )
        one = modes[modes.consistent[0]]
        found.append(
            {
                "contacts": names,
                "slides": sliding.letters(state),
                "word": "".join(one.word[k] for k in closed),
                "forces": [
                    [part.hex() for part in pair]
                    for pair in shared(one.forces, closed, one.word, rows, sliding)
                ],
            }
        )
    if not found:
        return {}
    edges = [foot.edge(side) for foot in rows.feet for side in (1, -1)]
    return {"lift": texts(strictly_positive(rows, edges)), "modes": found}


def shared(
    forces: Vectors, closed: Sequence[int], word: str, rows: Rows, sliding: Sliding
) -> list[list[float]]:
    """Forces (tangential, normal) of closed contacts. Those of an interface that holds use the same share of their friction, away from the edges of the cones."""
    found = forces.copy()
    for g in sliding.touched(frozenset(closed)):
        own = [
            k for k in closed if word[k] == "F" and sliding.of[k] in ((g, 1), (g, -1))
        ]
        sides = [sliding.of[k][1] for k in own]
        most = [float(rows.feet[k].friction) * forces[k, 1] for k in own]
        if sum(most) > 0:
            share = np.dot(sides, forces[own, 0]) / sum(most)
            found[own, 0] = share * np.multiply(sides, most)
    return [found[k].tolist() for k in closed]


def bearing_forces(rows: Rows, largest: Sequence[float]) -> list[Fraction]:
    """Normal forces that carry the load without friction, positive at all contacts that can have one: `largest` is the largest force of each."""
    bearing = [k for k, force in enumerate(largest) if force > 0]
    normals = [rows.feet[k].normal for k in bearing]
    total, found = [-part for part in rows.load], list[list[Fraction]]()
    for place, k in enumerate(bearing):
        if any(forces[place] for forces in found):
            continue
        # Half of the largest force at this contact, and the rest from all of them.
        part = Fraction(largest[k]) / 2
        rest = [a - part * b for a, b in zip(total, normals[place], strict=True)]
        forces, _ = weights_of(normals, rest)
        if forces is None:
            raise ValueError(f"contact {k + 1} bears nothing without friction, exactly")
        forces[place] += part
        found.append(forces)
    mean = [Fraction(0)] * len(largest)
    for place, k in enumerate(bearing):
        mean[k] = sum((forces[place] for forces in found), Fraction(0)) / len(found)
    return mean


def texts(values: Sequence[Fraction]) -> list[str]:
    """Doubles in hexadecimal, others as fractions."""
    return [
        float(value).hex() if Fraction(float(value)) == value else str(value)
        for value in values
    ]


def strictly_positive(
    rows: Rows, vectors: Sequence[Sequence[Fraction]]
) -> list[Fraction]:
    """y with y·w > 0 for all of some vectors w, if doubles find one."""
    roots = np.sqrt([float(row[k]) for k, row in enumerate(rows.mass)])
    points = np.array(vectors, dtype=float) / roots
    points /= np.linalg.norm(points, axis=1)[:, None]
    found = nearest_to_zero(points) / roots
    found /= np.abs(found).max(initial=1e-300)
    return [Fraction(part) for part in found.tolist()]


def holding_none(rows: Rows, feet: Sequence[Pad]) -> list[Fraction]:
    """y with y·w ≥ 0 for the edges w of the friction cones of some contacts, and y·load > 0: as `separating`, in any number of coordinates."""
    edges = [foot.edge(side) for foot in feet for side in (1, -1)]
    y = strictly_positive(rows, [*filter(any, edges), rows.load])
    if inner(y, rows.load) > 0 and all(inner(y, edge) >= 0 for edge in edges):
        return y
    weights, y = weights_of(edges, [-part for part in rows.load])
    if weights is not None:
        raise ValueError("forces in the friction cones hold the load exactly")
    return y


def weights_of(
    columns: Sequence[Sequence[Fraction]], total: Sequence[Fraction]
) -> tuple[list[Fraction] | None, list[Fraction]]:
    """Weights a ≥ 0 of columns w with Σ a w = total, or None and a y with y·w ≥ 0 for all columns and y·total < 0.

    The first phase of the simplex method in fractions, with the rule of Bland [1977] for the least Σ of what is missing in each row."""
    n, count = len(total), len(columns)
    signs = [-1 if part < 0 else 1 for part in total]
    tableau = [
        [signs[k] * column[k] for column in columns]
        + [Fraction(j == k) for j in range(n)]
        + [signs[k] * total[k]]
        for k in range(n)
    ]
    basis = list(range(count, count + n))
    # The reduced costs: those of the columns that are missing are 1 less a multiplier.
    cost = [-sum(column) for column in zip(*tableau, strict=True)]
    cost[count : count + n] = [Fraction(0)] * n
    while (new := next((j for j in range(count) if cost[j] < 0), None)) is not None:
        rows = [k for k in range(n) if tableau[k][new] > 0]
        out = min(rows, key=lambda k: (tableau[k][-1] / tableau[k][new], basis[k]))
        lead = [part / tableau[out][new] if part else part for part in tableau[out]]
        tableau[out], basis[out] = lead, new
        for row in (*tableau, cost):
            factor = row[new]
            if row is not lead and factor:
                row[:] = [
                    a - factor * b if b else a for a, b in zip(row, lead, strict=True)
                ]
    if cost[-1] == 0:
        weights = [Fraction(0)] * count
        for k, j in enumerate(basis):
            if j < count:
                weights[j] = tableau[k][-1]
        return weights, []
    multipliers = [1 - part for part in cost[count : count + n]]
    return None, [-sign * part for sign, part in zip(signs, multipliers, strict=True)]


def separating(posture: Posture, contacts: Sequence[int]) -> Vectors:
    """y with y·w ≥ 0 for the edges w of the friction cones, as forces and moments about the centre of mass, and y·e_y < 0.

    The point nearest to zero in the convex hull of these edges and −e_y, all of length one, is such a y. If doubles do not find it, it is
    sought in fractions. If zero is in the hull, only weak signs are possible, and exact directions are tried."""
    feet = [_contacts(posture)[k - 1] for k in contacts]
    edges = []
    for foot in feet:
        turn = np.array([np.cos(foot.slope), np.sin(foot.slope)])
        arm = np.subtract(foot.point, posture.center_of_mass)
        for side in (1, -1):
            force = np.array([-turn[1], turn[0]]) + side * foot.friction * turn
            moment = arm[0] * force[1] - arm[1] * force[0]
            edges.append([*force, moment / posture.gyration_radius])
    wrenches = np.array([*edges, [0.0, -1.0, 0.0]])
    wrenches /= np.linalg.norm(wrenches, axis=1)[:, None]
    found = nearest_to_zero(wrenches)
    if np.min(wrenches @ found) <= ROUNDING * np.linalg.norm(found):
        found = nearest_in_fractions(wrenches)
    if np.min(wrenches @ found) <= 0:
        tries = [np.array([x, -1.0, z]) for x in (-1, 0, 1) for z in (-1, 0, 1)]
        found = max(tries, key=lambda y: float(np.min(wrenches @ y)))
    return found / [1, 1, posture.gyration_radius]


def nearest_in_fractions(points: Vectors) -> Vectors:
    """As `nearest_to_zero`, in exact arithmetic, for up to MOST points: one, two or three of them have the nearest point in their affine hull.
    Zero if there is none."""
    exact = [[Fraction(x) for x in point] for point in points.tolist()]
    for count in (1, 2, 3) if len(exact) <= MOST else ():
        for some in combinations(exact, count):
            y = _normal(some)
            if all(_dot(y, point) > 0 for point in exact):
                largest = max(abs(part) for part in y)
                return np.array([float(part / largest) for part in y])
    return np.zeros(3)


def _normal(points: Sequence[list[Fraction]]) -> list[Fraction]:
    """The direction of the point of the affine hull of one, two or three points nearest to zero."""
    a = points[0]
    edges = [[x - y for x, y in zip(b, a, strict=True)] for b in points[1:]]
    if len(edges) == 2:
        (x, y, z), (u, v, w) = edges
        normal = [y * w - z * v, z * u - x * w, x * v - y * u]
        return [part * _dot(normal, a) for part in normal]
    square = sum(_dot(edge, edge) for edge in edges)
    share = sum(_dot(edge, a) for edge in edges) / square if square else Fraction(0)
    return [x - share * sum(e[k] for e in edges) for k, x in enumerate(a)]


def _dot(one: Sequence[Fraction], two: Sequence[Fraction]) -> Fraction:
    return sum((a * b for a, b in zip(one, two, strict=True)), Fraction(0))


def nearest_to_zero(points: Vectors) -> Vectors:
    """The point of the convex hull nearest to zero [Wolfe 1976]."""
    active = [int(np.argmin(np.linalg.norm(points, axis=1)))]
    weights = np.array([1.0])
    for _ in range(1000):
        x = weights @ points[active]
        new = int(np.argmin(points @ x))
        if points[new] @ x >= x @ x * (1 - 1e-12) or new in active:
            break
        active.append(new)
        weights = np.append(weights, 0.0)
        while True:
            # The point of the affine hull nearest to zero.
            n = len(active)
            system = np.ones((n + 1, n + 1))
            system[0, 0] = 0
            system[1:, 1:] = points[active] @ points[active].T
            aim = np.linalg.lstsq(system, np.eye(n + 1)[0], rcond=None)[0][1:]
            if np.all(aim > 1e-14):
                weights = aim
                break
            falls = aim < weights
            step = np.min(weights[falls] / (weights - aim)[falls], initial=1.0)
            weights = weights + step * (aim - weights)
            keep = weights > 1e-14
            if np.all(keep):
                keep[int(np.argmin(weights))] = False
            active = [k for k, kept in zip(active, keep, strict=True) if kept]
            weights = weights[keep] / weights[keep].sum()
    return np.asarray(weights @ points[active])
