"""The scene of a certificate, and its rows.

Per unit mass, with the arm from the centre of mass to contact i, t = (cos, sin) of its slope and n = (−sin, cos):

    N = (n, b), b = t·arm     T = (t, −c), c = n·arm     M = diag(1, 1, ρ²)     g_i = g n_i·e_y
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from .intervals import (
    ONE,
    UNIT,
    Interval,
    Vector,
    cosine_and_sine,
    dot,
    plus,
    require,
    scaled,
)

#: Distance from the line of two other contacts below which a contact counts as on it, in sizes of the body: coordinates in decimals are rounded.
ON_ONE_LINE = UNIT // 10**12

#: Largest number of contacts: with more, a check might last for minutes.
MOST_CONTACTS = 1000


def number(value: Any, name: str) -> float:
    """A double, from the text that `float.hex` writes."""
    found = math.nan
    with suppress(TypeError, ValueError, OverflowError):
        found = float.fromhex(value)
    require(
        math.isfinite(found) and found.hex() == value,
        f"{name} is not a finite double as float.hex writes it: {value!r}",
    )
    return found


def entry(table: Any, key: str, where: str) -> Any:
    require(isinstance(table, dict) and key in table, f"{where} has no entry {key!r}")
    return table[key]


def numbers(values: Any, count: int, name: str) -> list[float]:
    require(
        isinstance(values, list) and len(values) == count,
        f"{name} is not a list of {count} numbers",
    )
    return [number(value, f"{name}[{k}]") for k, value in enumerate(values)]


@dataclass(frozen=True)
class Foot:
    """A contact: its number, its doubles, and its rows."""

    name: int
    point: tuple[float, float]
    slope: float
    friction: Interval
    restitution: Interval
    normal: Vector
    tangent: Vector


@dataclass(frozen=True)
class Body:
    """The scene, with lengths in `size` (a power of two, in m) and gravity over a power of two. No claim depends on these scales."""

    size: Fraction
    rho: Interval
    gravity: Interval
    center: tuple[float, float]
    feet: tuple[Foot, ...]
    #: Whether a plastic impact ends a jam. Otherwise no motion goes on.
    resolves_jams: bool = False
    #: Of a body on two contacts: places of contacts that they carry, from the first (0) to the second (1).
    between: tuple[Interval, ...] = ()

    @cached_property
    def inverse(self) -> Vector:
        """The diagonal of M⁻¹."""
        return ONE, ONE, ONE / self.rho.square()

    def over_mass(self, force: Vector) -> Vector:
        """M⁻¹ f"""
        return (force[0], force[1], force[2] * self.inverse[2])

    def couple(self, one: Vector, two: Vector) -> Interval:
        """a M⁻¹ bᵀ"""
        return dot(one, self.over_mass(two))

    def pull(self, i: int) -> Interval:
        """g_i: gravity into the ground of contact i."""
        return self.gravity * self.feet[i].normal[1]

    def rubbing(self, i: int, side: int) -> Vector:
        """N_i − σμ_iT_i: the force of a contact that slides in direction σ, per unit normal force."""
        foot = self.feet[i]
        return plus(foot.normal, scaled(foot.tangent, -foot.friction.times(side)))

    def stiffness(self, i: int, side: int) -> Interval:
        """k_i^σ = N_i M⁻¹ (N_i − σμ_iT_i)ᵀ"""
        return self.couple(self.feet[i].normal, self.rubbing(i, side))

    def jams(self, i: int, side: int) -> bool:
        """Whether contact i certainly jams if it slides alone in direction σ: gravity presses it down, and its force would be negative."""
        return self.stiffness(i, side).hi < 0 < self.pull(i).lo

    def part(self, names: Sequence[int]) -> "Body":
        """The body on these of its contacts only."""
        return replace(self, feet=tuple(self.feet[i] for i in self.places(names)))

    def places(self, names: Any) -> list[int]:
        """The places of contacts, given by their numbers."""
        known = {foot.name: i for i, foot in enumerate(self.feet)}
        require(
            isinstance(names, list)
            and all(type(k) is int and k in known for k in names)
            and len(set(names)) == len(names),
            f"{names!r} are not numbers of contacts of the scene",
        )
        return [known[k] for k in names]


def without_carried(body: Body) -> tuple[Body, dict[tuple[int, int], list[Interval]]]:
    """The body without the contacts that others carry, and their places, by the numbers of the outer contacts of their line.

    A line: three or more contacts of one slope, friction and restitution, all of which are within 1e-12 of the size of the body of the line
    through the outer two. Places go from 0 at the first of these to 1 at the other one, in the order of the list of contacts."""
    groups: dict[tuple[float, int, int], list[Foot]] = {}
    for foot in body.feet:
        key = foot.slope, foot.friction.lo, foot.restitution.lo
        groups.setdefault(key, []).append(foot)
    left, lines = list(body.feet), {}
    for feet in groups.values():
        low, high = (
            choose(feet, key=lambda foot: foot.normal[2].lo) for choose in (min, max)
        )
        ends = [foot for foot in feet if foot.name in (low.name, high.name)]
        inner = [foot for foot in feet if foot not in ends]
        if len(ends) != 2 or not inner:
            continue
        first, last = ends
        places = []
        for foot in inner:
            place = (foot.normal[2] - first.normal[2]) / (
                last.normal[2] - first.normal[2]
            )
            off = foot.tangent[2] - first.tangent[2]
            off -= place * (last.tangent[2] - first.tangent[2])
            on_line = max(abs(off.lo), abs(off.hi)) <= ON_ONE_LINE
            if on_line and place.lo > 0 and (ONE - place).lo > 0:
                places.append(place)
        if len(places) == len(inner):
            lines[first.name, last.name] = places
            left = [foot for foot in left if foot not in inner]
    return replace(body, feet=tuple(left)), lines


def power_of_two(value: Fraction) -> Fraction:
    """A power of two near to and above a positive number."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length() + 1
    return Fraction(1 << exponent) if exponent > 0 else Fraction(1, 1 << -exponent)


def contacts_of(scene: Any) -> list[Any]:
    """The entries of the contacts of a scene: at least one, and not too many."""
    listed = entry(scene, "contacts", "scene")
    require(isinstance(listed, list) and bool(listed), "scene.contacts is empty")
    require(
        len(listed) <= MOST_CONTACTS,
        f"scene.contacts has {len(listed)} entries; at most {MOST_CONTACTS} are checked",
    )
    return list(listed)


def body_of(scene: Any) -> Body:
    """The scene of a certificate."""
    sizes = []
    for key in ("mass", "gyration_radius", "gravity"):
        sizes.append(Fraction(number(entry(scene, key, "scene"), f"scene.{key}")))
        require(sizes[-1] > 0, f"scene.{key} is not positive")
    _, rho, gravity = sizes  # every claim is one per unit mass
    center = numbers(entry(scene, "center_of_mass", "scene"), 2, "scene.center_of_mass")
    listed = contacts_of(scene)
    drafts = []
    for k, contact in enumerate(listed):
        where = f"scene.contacts[{k}]"
        point = numbers(entry(contact, "point", where), 2, f"{where}.point")
        rest = {
            key: number(entry(contact, key, where), f"{where}.{key}")
            for key in ("slope", "friction", "restitution")
        }
        require(rest["friction"] >= 0, f"{where}.friction is negative")
        require(
            0 <= rest["restitution"] < 1,
            f"{where}.restitution is not at least 0 and below 1",
        )
        name = entry(contact, "number", where)
        require(type(name) is int, f"{where}.number is not an integer")
        arm = [Fraction(a) - Fraction(b) for a, b in zip(point, center, strict=True)]
        drafts.append((name, point, rest, arm))
    names = [name for name, *_ in drafts]
    require(names == sorted(set(names)), "scene.contacts are not in order")
    size = power_of_two(max([rho] + [abs(part) for *_, arm in drafts for part in arm]))
    feet = []
    for name, point, rest, arm in drafts:
        cosine, sine = cosine_and_sine(rest["slope"])
        x, y = (Interval.of(part / size) for part in arm)
        feet.append(
            Foot(
                name,
                (point[0], point[1]),
                rest["slope"],
                Interval.of(Fraction(rest["friction"])),
                Interval.of(Fraction(rest["restitution"])),
                normal=(-sine, cosine, cosine * x + sine * y),
                tangent=(cosine, sine, sine * x - cosine * y),
            )
        )
    return Body(
        size,
        Interval.of(rho / size),
        Interval.of(gravity / power_of_two(gravity)),
        (center[0], center[1]),
        tuple(feet),
    )


def direction(body: Body, data: Any, key: str) -> Vector:
    """A displacement or a velocity (x, y, θ), of any length."""
    parts = numbers(entry(data, key, "data"), 3, f"data.{key}")
    exact = [Fraction(part) for part in parts]
    exact = [exact[0] / body.size, exact[1] / body.size, exact[2]]
    largest = max(abs(part) for part in exact)
    require(largest > 0, f"data.{key} is zero")
    x, y, turn = (Interval.of(part / largest) for part in exact)
    return x, y, turn
