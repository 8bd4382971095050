"""Bodies in a potential well: the hypotheses of the theorem, one by one."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from .exact import inner, kernel, lines, rationals, reduced
from .goes_on import MOST_CHOICES, directions, goes_on, rays
from .intervals import require
from .mechanism import Pad, Rows, places, separates
from .scene import entry


def carried(rows: Rows, data: Any) -> list[Fraction]:
    """Normal forces λ ≥ 0 that carry the load without friction: V = λ·h ≥ 0 on K."""
    forces = rationals(entry(data, "forces", "data"), len(rows.feet), "data.forces")
    for foot, force in zip(rows.feet, forces, strict=True):
        require(force >= 0, f"λ of contact {foot.name} is negative: {float(force):.6g}")
    for k, load in enumerate(rows.load):
        rest = load + inner(forces, [foot.normal[k] for foot in rows.feet])
        require(
            rest == 0,
            f"load + Σ λ_iN_i is not zero in coordinate {k + 1}: {float(rest):.6g}",
        )
    return forces


def sliding_sets(rows: Rows, forces: Sequence[Fraction]) -> list[frozenset[int]]:
    """The contacts, by their places, that can bear without resistance while the bodies slide along z ≠ 0 with N_i z = 0 where λ_i > 0, for those z for which there are most
    of them: N_i z = 0, and T_i z = 0 or no friction. None if the contacts that bear allow no slide."""
    bearing = [
        foot.normal for foot, force in zip(rows.feet, forces, strict=True) if force
    ]
    basis = kernel(bearing, len(rows.load))
    if not basis:
        return []
    normals, tangents = (
        [[inner(row, axis) for axis in basis] for row in those]
        for those in (
            [foot.normal for foot in rows.feet],
            [foot.friction_row() for foot in rows.feet],
        )
    )
    felt = directions(normals + tangents)
    require(
        bool(felt) and len(reduced(felt)[0]) == len(basis),
        "a slide with N_i z = 0 where λ_i > 0 meets no friction",
    )
    return [
        frozenset(
            k
            for k in range(len(rows.feet))
            if inner(normals[k], z) == 0 == inner(tangents[k], z)
        )
        for z in lines(felt, MOST_CHOICES)
    ]


def raised_sets(rows: Rows, forces: Sequence[Fraction]) -> list[frozenset[int]]:
    """The contacts, by their places, that are closed on the extreme rays of K with V > 0."""
    return [closed for closed, gaps in rays(rows) if inner(forces, gaps) != 0]


def is_moreau_dissipative(feet: Sequence[Pad]) -> bool:
    """One restitution of all contacts, and the same in tangential direction where there is friction."""
    e = feet[0].restitution
    return all(
        foot.restitution == e
        and (foot.friction == 0 or foot.tangential_restitution == e)
        for foot in feet
    )


def potential_well(rows: Rows, data: Any) -> None:
    """The load is carried, a motion goes on from every state, and every slide along a level resists and falls."""
    forces = carried(rows, data)
    goes_on(rows, data)
    sliding = sliding_sets(rows, forces)
    if not sliding:
        return
    require(
        is_moreau_dissipative(rows.feet),
        "the bodies can slide along a level, and the restitutions are not one number, the same in tangential direction",
    )
    stated = entry(data, "separates", "data")
    require(isinstance(stated, list), "data.separates is not a list")
    parted = []
    for k, part in enumerate(stated):
        where = f"data.separates[{k}]"
        own = places(rows, entry(part, "contacts", where))
        y = rationals(entry(part, "y", where), len(rows.load), f"{where}.y")
        separates(rows, y, [rows.feet[i] for i in own])
        parted.append(frozenset(own))
    for what, sets in (
        ("carry the load while it slides along a level", sliding),
        ("hold the load above its level", raised_sets(rows, forces)),
    ):
        for some in sets:
            require(
                any(some <= part for part in parted),
                f"contacts {[rows.feet[k].name for k in sorted(some)]} may {what}",
            )
