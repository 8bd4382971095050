"""Claims on mechanisms and assemblies: constant rows, any number of coordinates. All numbers are exact.

The coordinates are those that are not locked. With the mass matrix M, the load, and the rows N_i, T_i of contact i

    M q̈ = load + Σ_i (f_n,i N_i + f_t,i T_i)     h_i = N_i q     K = {q : h ≥ 0}     V = −load·q
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .exact import inner, is_positive_definite, rationals, solutions
from .intervals import require
from .scene import contacts_of, entry, number, numbers

#: Largest number of coordinates: with more, a check might last for minutes.
MOST_COORDINATES = 100


@dataclass(frozen=True)
class Pad:
    """A contact: its number, its rows, friction and restitutions."""

    name: int
    normal: list[Fraction]
    tangent: list[Fraction]
    friction: Fraction
    restitution: Fraction
    tangential_restitution: Fraction

    def friction_row(self) -> list[Fraction]:
        """μ T"""
        return [self.friction * part for part in self.tangent]

    def edge(self, side: int) -> list[Fraction]:
        """N + side μ T: an edge of the friction cone."""
        along = self.friction_row()
        return [n + side * t for n, t in zip(self.normal, along, strict=True)]


@dataclass(frozen=True)
class Rows:
    """The scene."""

    mass: list[list[Fraction]]
    load: list[Fraction]
    feet: tuple[Pad, ...]
    #: Whether a plastic impact ends a jam. Otherwise no motion goes on.
    resolves_jams: bool = False


def rows_of(scene: Any) -> Rows:
    """The scene of a certificate of a mechanism."""
    listed = entry(scene, "load", "scene")
    require(isinstance(listed, list) and bool(listed), "scene.load is empty")
    count = len(listed)
    require(
        count <= MOST_COORDINATES,
        f"scene.load has {count} entries; at most {MOST_COORDINATES} are checked",
    )

    def exact(values: Any, name: str) -> list[Fraction]:
        return [Fraction(value) for value in numbers(values, count, name)]

    load = exact(listed, "scene.load")
    matrix = entry(scene, "mass_matrix", "scene")
    require(
        isinstance(matrix, list) and len(matrix) == count,
        f"scene.mass_matrix is not a list of {count} rows",
    )
    mass = [exact(row, f"scene.mass_matrix[{k}]") for k, row in enumerate(matrix)]
    require(
        all(mass[i][j] == mass[j][i] for i in range(count) for j in range(i)),
        "scene.mass_matrix is not symmetric",
    )
    require(is_positive_definite(mass), "scene.mass_matrix is not positive definite")
    listed = contacts_of(scene)
    feet = []
    for k, contact in enumerate(listed):
        where = f"scene.contacts[{k}]"
        name = entry(contact, "number", where)
        require(type(name) is int, f"{where}.number is not an integer")
        normal, tangent = (
            exact(entry(contact, key, where), f"{where}.{key}")
            for key in ("normal", "tangential")
        )
        friction, restitution, tangential = (
            Fraction(number(entry(contact, key, where), f"{where}.{key}"))
            for key in ("friction", "restitution", "tangential_restitution")
        )
        require(friction >= 0, f"{where}.friction is negative")
        require(
            0 <= restitution < 1, f"{where}.restitution is not at least 0 and below 1"
        )
        feet.append(Pad(name, normal, tangent, friction, restitution, tangential))
    names = [foot.name for foot in feet]
    require(names == sorted(set(names)), "scene.contacts are not in order")
    return Rows(mass, load, tuple(feet))


def places(rows: Rows, names: Any) -> list[int]:
    """The places of contacts, given by their numbers."""
    known = {foot.name: k for k, foot in enumerate(rows.feet)}
    require(
        isinstance(names, list)
        and all(type(name) is int and name in known for name in names)
        and len(set(names)) == len(names),
        f"{names!r} are not numbers of contacts of the scene",
    )
    return [known[name] for name in names]


def couplings(
    rows: Rows,
    columns: Sequence[Sequence[Fraction]],
    left: Sequence[Sequence[Fraction]] | None = None,
) -> list[list[Fraction]]:
    """N_i M⁻¹ of each contact i times some vectors; or with other rows on the left."""
    moved, _ = solutions(rows.mass, columns)
    assert moved is not None
    left = [foot.normal for foot in rows.feet] if left is None else left
    return [[inner(row, column) for column in moved] for row in left]


def separates(rows: Rows, y: Sequence[Fraction], feet: Sequence[Pad]) -> None:
    """No forces in the friction cones of these contacts hold the load: y·(N_i ± μ_iT_i) ≥ 0 for all of them, and y·load > 0 (Farkas)."""
    power = inner(y, rows.load)
    require(power > 0, f"y·load is not positive: {float(power):.6g}")
    for foot in feet:
        for side, name in ((1, "N + μT"), (-1, "N - μT")):
            work = inner(y, foot.edge(side))
            require(
                work >= 0,
                f"y·w of the edge {name} of contact {foot.name} is not at least 0: {float(work):.6g}",
            )


def not_equilibrium(rows: Rows, data: Any) -> None:
    """No forces in the friction cones hold the load."""
    stated = entry(data, "separates", "data")
    separates(rows, rationals(stated, len(rows.load), "data.separates"), rows.feet)
