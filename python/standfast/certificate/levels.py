"""Bodies in a potential well: the hypotheses of the theorem, one by one."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

from .exact import (
    inner,
    is_strictly_copositive,
    kernel,
    lines,
    rationals,
    reduced,
)
from .intervals import require
from .mechanism import Pad, Rows, couplings, places, separates
from .scene import entry, power_of_two

#: Largest number of interfaces with friction: there are 2^n pairs of signs.
MOST_INTERFACES = 8
#: Largest number of contacts of a well: there are 2^n sets of them.
MOST_IN_A_WELL = 10
#: Entries of A(σ) are rounded to the largest diagonal entry over this number.
ROUNDED = 2**80
#: Largest number of choices of rows that are tried for rays, or for slides.
MOST_CHOICES = 5000


def interfaces(feet: Sequence[Pad]) -> list[tuple[int, int]]:
    """The interface of each contact, and whether its row T is c > 0 (1) or c < 0 (-1) times that of the interface. Contacts without friction have none: (0, 0)."""
    leading: list[list[Fraction]] = []
    found = []
    for foot in feet:
        if foot.friction == 0 or not any(foot.tangent):
            found.append((0, 0))
            continue
        factors = (
            next(a / b for a, b in zip(foot.tangent, row, strict=True) if b)
            for row in leading
        )
        known = [
            (g, 1 if factor > 0 else -1)
            for g, (factor, row) in enumerate(zip(factors, leading, strict=True))
            if foot.tangent == [factor * part for part in row]
        ]
        if not known:
            leading.append(foot.tangent)
            known = [(len(leading) - 1, 1)]
        found.append(known[0])
    return found


def stiff(rows: Rows) -> None:
    """A(σ) = N M⁻¹(N − σμT)ᵀ is strictly copositive for all signs, one for each interface: its contacts slide together, and only the sum of their
    friction acts. So a motion goes on from every state, and there is a lift."""
    of = interfaces(rows.feet)
    count = max((g + 1 for g, side in of if side), default=0)
    require(
        count <= MOST_INTERFACES and len(of) <= MOST_IN_A_WELL,
        f"the scene has {len(of)} contacts and {count} interfaces with friction; at most {MOST_IN_A_WELL} and {MOST_INTERFACES} are tried",
    )
    normal = couplings(rows, [foot.normal for foot in rows.feet])
    rubbing = couplings(rows, [foot.friction_row() for foot in rows.feet])
    # Entries are rounded down, to integers: a matrix with smaller entries that is strictly copositive is enough.
    unit = power_of_two(max(normal[i][i] for i in range(len(of)))) / ROUNDED
    all_of = range(len(of))
    for signs in product((1, -1), repeat=count):
        sides = [side and side * signs[g] for g, side in of]
        matrix = [
            [
                Fraction(
                    (
                        normal[i][j]
                        + normal[j][i]
                        - sides[j] * rubbing[i][j]
                        - sides[i] * rubbing[j][i]
                    )
                    // unit
                )
                for j in all_of
            ]
            for i in all_of
        ]
        word = "".join("RL"[side < 0] if side else "F" for side in sides)
        require(
            is_strictly_copositive(matrix),
            f"contacts may jam: N M⁻¹(N - σμT)ᵀ is not strictly copositive while they slide {word}",
        )


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


def directions(rows: Iterator[list[Fraction]]) -> list[list[Fraction]]:
    """Those of the rows that are not zero, each once."""
    found = {}
    for row in rows:
        lead = next((part for part in row if part), None)
        if lead is not None:
            found[tuple(part / lead for part in row)] = row
    return list(found.values())


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
    felt = directions(iter(normals + tangents))
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
    """The contacts, by their places, that are closed on the extreme rays of K with V > 0: in the span of the rows N, of rank r, a ray closes r − 1 independent contacts."""
    axes, _ = reduced([foot.normal for foot in rows.feet])
    normals = [[inner(foot.normal, axis) for axis in axes] for foot in rows.feet]
    found = []
    for z in lines(directions(iter(normals)), MOST_CHOICES):
        gaps = [inner(row, z) for row in normals]
        sides = {gap > 0 for gap in gaps if gap}
        if len(sides) == 1 and inner(forces, gaps) != 0:
            found.append(frozenset(k for k, gap in enumerate(gaps) if gap == 0))
    return found


def is_moreau_dissipative(feet: Sequence[Pad]) -> bool:
    """One restitution of all contacts, and the same in tangential direction where there is friction."""
    e = feet[0].restitution
    return all(
        foot.restitution == e
        and (foot.friction == 0 or foot.tangential_restitution == e)
        for foot in feet
    )


def potential_well(rows: Rows, data: Any) -> None:
    """The load is carried, the contacts are stiff, and every slide along a level resists and falls."""
    forces = carried(rows, data)
    stiff(rows)
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
