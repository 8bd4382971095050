"""Checks certificates of verdicts, with the standard library alone.

`check` derives everything again from the scene, in intervals of binary fractions with outward rounding, and shares no code with the core.
There is no tolerance: a sign is certain, or the certificate is refused. docs/certificates.md has the format and each step. The file
runs without the rest of the package: `python certificate.py CERT.json`.

Rows, per unit mass, with the arm from the centre of mass to contact i, t = (cos, sin) of its slope and n = (−sin, cos):

    N = (n, b), b = t·arm     T = (t, −c), c = n·arm     M = diag(1, 1, ρ²)     g_i = g n_i·e_y
"""

import json
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Any

#: The version of the format and of the conventions: axes, signs, names.
CONVENTIONS = 1

#: Numbers are multiples of 2^-BITS. The scene is scaled first, to a size and a gravity between 1/2 and 1.
BITS = 256
UNIT = 1 << BITS


class Interval:
    """All numbers between lo and hi, in units of 2^-BITS. Every operation rounds outwards."""

    __slots__ = ("hi", "lo")

    def __init__(self, lo: int, hi: int) -> None:
        self.lo = lo
        self.hi = hi

    @staticmethod
    def of(value: Fraction | int) -> "Interval":
        p, q = value.numerator << BITS, value.denominator
        return Interval(p // q, -(-p // q))

    def __add__(self, other: "Interval") -> "Interval":
        return Interval(self.lo + other.lo, self.hi + other.hi)

    def __sub__(self, other: "Interval") -> "Interval":
        return Interval(self.lo - other.hi, self.hi - other.lo)

    def __neg__(self) -> "Interval":
        return Interval(-self.hi, -self.lo)

    def __mul__(self, other: "Interval") -> "Interval":
        if self.lo >= 0 and other.lo >= 0:
            low, high = self.lo * other.lo, self.hi * other.hi
        else:
            products = (
                self.lo * other.lo,
                self.lo * other.hi,
                self.hi * other.lo,
                self.hi * other.hi,
            )
            low, high = min(products), max(products)
        return Interval(low >> BITS, -(-high >> BITS))

    def __truediv__(self, other: "Interval") -> "Interval":
        if other.lo <= 0 <= other.hi:
            raise ValueError(f"a divisor may be zero: {other}")
        ends = [
            (a << BITS, b) for a in (self.lo, self.hi) for b in (other.lo, other.hi)
        ]
        return Interval(min(a // b for a, b in ends), max(-(-a // b) for a, b in ends))

    def times(self, factor: int) -> "Interval":
        """Times an integer, exactly."""
        ends = self.lo * factor, self.hi * factor
        return Interval(min(ends), max(ends))

    def half(self) -> "Interval":
        return Interval(self.lo >> 1, -(-self.hi >> 1))

    def square(self) -> "Interval":
        low, high = sorted((abs(self.lo), abs(self.hi)))
        if self.lo < 0 < self.hi:
            low = 0
        return Interval(low * low >> BITS, -(-high * high >> BITS))

    def sqrt(self) -> "Interval":
        """By integer square roots. The part below zero, if any, is left out: the caller knows that the number is not negative."""
        if self.hi < 0:
            raise ValueError(f"a square root of a negative number: {self}")
        low, high = max(self.lo, 0) << BITS, self.hi << BITS
        root = math.isqrt(high)
        return Interval(math.isqrt(low), root + (root * root < high))

    def sign(self) -> int | None:
        """1, 0 or −1; None if it is not certain."""
        if self.lo > 0:
            return 1
        if self.hi < 0:
            return -1
        return 0 if self.lo == self.hi == 0 else None

    def __str__(self) -> str:
        return f"in [{self.lo / UNIT:.6g}, {self.hi / UNIT:.6g}]"


ZERO, ONE = Interval(0, 0), Interval(UNIT, UNIT)

Vector = tuple[Interval, Interval, Interval]


def hull(one: Interval, two: Interval) -> Interval:
    return Interval(min(one.lo, two.lo), max(one.hi, two.hi))


def cosine_and_sine(angle: float) -> tuple[Interval, Interval]:
    """By Taylor polynomials. For |x| ≤ 4 the first term that is left out bounds the rest: the terms alternate, and fall from the fourth on.

    The doubles nearest to ±π/2 and π stand for these angles themselves.

    >>> for part in cosine_and_sine(math.pi / 2) + cosine_and_sine(1.0):
    ...     print(part)
    in [0, 0]
    in [1, 1]
    in [0.540302, 0.540302]
    in [0.841471, 0.841471]
    """
    exact = {0.0: (1, 0), math.pi / 2: (0, 1), -math.pi / 2: (0, -1), math.pi: (-1, 0)}
    if angle in exact:
        cosine, sine = exact[angle]
        return ONE.times(cosine), ONE.times(sine)
    require(abs(angle) <= 4, f"the slope {angle} is not between -π and π")
    x = Interval.of(Fraction(angle))
    minus_square = -x.square()

    def series(term: Interval, order: int) -> Interval:
        total = term
        while True:
            order += 2
            term = term * minus_square / ONE.times(order * (order - 1))
            most = max(abs(term.lo), abs(term.hi))
            if most <= 1 and order > 4:
                return total + Interval(-most, most)
            total = total + term

    return series(ONE, 0), series(x, 1)


def require(holds: bool, otherwise: str) -> None:
    """Refuses the certificate unless a step holds."""
    if not holds:
        raise ValueError(otherwise)


def positive(value: Interval, name: str) -> None:
    require(value.lo > 0, f"{name} is not certainly positive: {value}")


def negative(value: Interval, name: str) -> None:
    require(value.hi < 0, f"{name} is not certainly negative: {value}")


def dot(one: Sequence[Interval], two: Sequence[Interval]) -> Interval:
    total = one[0] * two[0]
    for a, b in zip(one[1:], two[1:], strict=True):
        total = total + a * b
    return total


def scaled(vector: Vector, factor: Interval) -> Vector:
    return (vector[0] * factor, vector[1] * factor, vector[2] * factor)


def plus(one: Vector, two: Vector) -> Vector:
    return (one[0] + two[0], one[1] + two[1], one[2] + two[2])


def cross(one: Vector, two: Vector) -> Vector:
    (a, b, c), (d, e, f) = one, two
    return (b * f - c * e, c * d - a * f, a * e - b * d)


def solve(matrix: list[list[Interval]], right: list[Interval]) -> list[Interval]:
    """The solution of linear equations, by elimination with the largest pivot."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(rows[i][k].lo + rows[i][k].hi))
        rows[k], rows[best] = rows[best], rows[k]
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [
                a - factor * b if j > k else ZERO
                for j, (a, b) in enumerate(zip(rows[i], rows[k], strict=True))
            ]
    found = [ZERO] * n
    for k in reversed(range(n)):
        rest = rows[k][n]
        for j in range(k + 1, n):
            rest = rest - rows[k][j] * found[j]
        found[k] = rest / rows[k][k]
    return found


# The scene


def number(value: Any, name: str) -> float:
    """A double, from its hexadecimal form."""
    require(isinstance(value, str), f"{name} is not a hexadecimal number: {value!r}")
    try:
        found = float.fromhex(value)
    except (ValueError, OverflowError):
        raise ValueError(f"{name} is not a hexadecimal number: {value!r}") from None
    require(math.isfinite(found), f"{name} is not finite: {value!r}")
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


def power_of_two(value: Fraction) -> Fraction:
    """A power of two near to and above a positive number."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length() + 1
    return Fraction(1 << exponent) if exponent > 0 else Fraction(1, 1 << -exponent)


def body_of(scene: Any) -> Body:
    """The scene of a certificate."""
    rho, gravity = (
        Fraction(number(entry(scene, key, "scene"), f"scene.{key}"))
        for key in ("gyration_radius", "gravity")
    )
    require(rho > 0, "scene.gyration_radius is not positive")
    require(gravity > 0, "scene.gravity is not positive")
    center = numbers(entry(scene, "center_of_mass", "scene"), 2, "scene.center_of_mass")
    listed = entry(scene, "contacts", "scene")
    require(isinstance(listed, list) and bool(listed), "scene.contacts is empty")
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


# Contact modes

SIDES = {"R": 1, "L": -1}


@dataclass(frozen=True)
class Motion:
    """The motion of a word from rest: for each contact a_n, a_t, and its forces (f_t, f_n), per unit mass."""

    acceleration: Vector
    normal: list[Interval]
    tangential: list[Interval]
    forces: list[tuple[Interval, Interval]]


def motion(body: Body, word: str) -> Motion:
    """The rows of the word vanish: N and T of a fixed contact, N of a sliding one."""
    rows: list[Vector] = []
    columns: list[Vector] = []
    for i, (letter, foot) in enumerate(zip(word, body.feet, strict=True)):
        if letter == "F":
            rows += [foot.normal, foot.tangent]
            columns += [foot.normal, foot.tangent]
        elif letter in SIDES:
            rows.append(foot.normal)
            columns.append(body.rubbing(i, SIDES[letter]))
    require(len(rows) <= 3, f"the word {word} does not move")
    fall = (ZERO, -body.gravity, ZERO)
    force = solve(
        [[body.couple(row, column) for column in columns] for row in rows],
        [-dot(row, fall) for row in rows],
    )
    total = fall
    for column, size in zip(columns, force, strict=True):
        total = plus(total, body.over_mass(scaled(column, size)))
    forces, left = [], iter(force)
    for letter, foot in zip(word, body.feet, strict=True):
        if letter == "S":
            forces.append((ZERO, ZERO))
        elif letter == "F":
            normal = next(left)
            forces.append((next(left), normal))
        else:
            normal = next(left)
            forces.append((-foot.friction.times(SIDES[letter]) * normal, normal))
    return Motion(
        total,
        [dot(foot.normal, total) for foot in body.feet],
        [dot(foot.tangent, total) for foot in body.feet],
        forces,
    )


def room(body: Body, found: Motion, i: int) -> list[Interval]:
    """μf_n ± f_t: not negative within the friction cone."""
    tangential, normal = found.forces[i]
    most = body.feet[i].friction * normal
    return [most - tangential, most + tangential]


def kinematics(body: Body, found: Motion, word: str) -> list[tuple[str, Interval]]:
    """The strict kinematic inequalities of a word: what has to be positive."""
    tests = []
    for i, letter in enumerate(word):
        name = f"contact {body.feet[i].name} in the word {word}"
        if letter == "S":
            tests.append((f"a_n of {name}", found.normal[i]))
        elif letter in SIDES:
            tests.append((f"a_t of {name}", found.tangential[i].times(SIDES[letter])))
    return tests


@dataclass(frozen=True)
class Pair:
    """A body on two contacts, with the direction z in which both slide: N_1z = N_2z = 0, in the orientation and with the length of N_1 × N_2."""

    body: Body

    @cached_property
    def along(self) -> Vector:
        one, two = self.body.feet
        return cross(one.normal, two.normal)

    @cached_property
    def alpha(self) -> list[Interval]:
        """T_i z"""
        found = [dot(foot.tangent, self.along) for foot in self.body.feet]
        for foot, part in zip(self.body.feet, found, strict=True):
            require(
                part.sign() in (1, -1),
                f"contact {foot.name} may stay in place while both contacts slide",
            )
        return found

    @cached_property
    def coupling(self) -> list[list[Interval]]:
        """D = N M⁻¹ Nᵀ"""
        rows = [foot.normal for foot in self.body.feet]
        return [[self.body.couple(a, b) for b in rows] for a in rows]

    @cached_property
    def psi(self) -> list[Interval]:
        return [-self.coupling[0][1] / self.coupling[i][i] for i in range(2)]

    @cached_property
    def weights(self) -> list[Interval]:
        """λ = D⁻¹(g_1, g_2)"""
        return solve(self.coupling, [self.body.pull(0), self.body.pull(1)])

    def side(self, i: int, way: int) -> int:
        """The direction σ in which contact i slides while the body moves along `way` z."""
        return way if self.alpha[i].lo > 0 else -way

    def word(self, way: int) -> str:
        return "".join("R" if self.side(i, way) > 0 else "L" for i in range(2))

    def continuations(self, way: int) -> list[tuple[str, bool | None]]:
        """The words that may go on from a slide of both contacts along `way` z, with their forces: ("both", whether it stops), ("lifts 1",
        None), ("lifts 2", None), ("falls", None). A word that certainly fails is left out; one that is not certain is refused."""
        body = self.body
        found: list[tuple[str, bool | None]] = []
        sides = [self.side(i, way) for i in range(2)]
        columns = [body.rubbing(i, sides[i]) for i in range(2)]
        pulls = [body.pull(0), body.pull(1)]
        matrix = [[body.couple(foot.normal, c) for c in columns] for foot in body.feet]
        forces = solve(matrix, pulls)
        signs = [force.sign() for force in forces]
        if signs == [1, 1]:
            total: Vector = (ZERO, -body.gravity, ZERO)
            for column, force in zip(columns, forces, strict=True):
                total = plus(total, body.over_mass(scaled(column, force)))
            speeding = dot(body.feet[0].tangent, total).times(sides[0]).sign()
            require(
                speeding is not None,
                "whether a slide of both contacts stops is not certain",
            )
            found.append(("both", speeding == -1))
        else:
            require(-1 in signs, "whether both contacts go on sliding is not certain")
        for k in range(2):
            m, own, pull = 1 - k, matrix[k][k].sign(), pulls[k].sign()
            if own in (1, -1) and pull in (1, -1) and own != pull:
                continue  # its normal force would be negative
            require(
                own == 1, f"whether contact {body.feet[k].name} jams is not certain"
            )
            require(
                pulls[k].lo >= 0,
                f"whether contact {body.feet[k].name} is pressed onto its ground is not certain",
            )
            lift = (matrix[m][k] * pulls[k] / matrix[k][k] - pulls[m]).sign()
            require(
                lift in (1, -1),
                f"whether contact {body.feet[m].name} lifts off is not certain",
            )
            if lift == 1:
                found.append((f"lifts {m + 1}", None))
        signs = [pull.sign() for pull in pulls]
        if signs == [-1, -1]:
            found.append(("falls", None))
        else:
            require(
                any(pull.lo >= 0 for pull in pulls),
                "whether both contacts separate is not certain",
            )
        return found


# Claims


def not_equilibrium(body: Body, data: Any) -> None:
    """No forces in the friction cones balance gravity: y separates them, y·(N_i ± μ_iT_i) ≥ 0 for all i and y·e_y < 0 (Farkas)."""
    first, second, third = numbers(entry(data, "separates", "data"), 3, "separates")
    require(second < 0, "separates[1] is not negative")
    y = [
        Interval.of(Fraction(first)),
        Interval.of(Fraction(second)),
        Interval.of(Fraction(third) * body.size),
    ]
    for i, foot in enumerate(body.feet):
        for side, name in ((-1, "n + μt"), (1, "n - μt")):
            work = dot(body.rubbing(i, side), y)
            require(
                work.lo >= 0,
                f"y·w of the edge {name} of contact {foot.name} is not certainly at least 0: {work}",
            )


def slides_of(data: Any, body: Body) -> list[tuple[int, int]]:
    """The contacts that slide, by their places, and their directions."""
    places = body.places(entry(data, "contacts", "data"))
    ways = entry(data, "slides", "data")
    require(
        isinstance(ways, str) and len(ways) == len(places) and set(ways) <= set(SIDES),
        f"data.slides {ways!r} has no letter R or L for each contact",
    )
    return [(i, SIDES[way]) for i, way in zip(places, ways, strict=True)]


def direction(body: Body, data: Any, key: str) -> Vector:
    """A displacement or a velocity (x, y, θ), of any length."""
    parts = numbers(entry(data, key, "data"), 3, f"data.{key}")
    exact = [Fraction(part) for part in parts]
    exact = [exact[0] / body.size, exact[1] / body.size, exact[2]]
    largest = max(abs(part) for part in exact)
    require(largest > 0, f"data.{key} is zero")
    x, y, turn = (Interval.of(part / largest) for part in exact)
    return x, y, turn


def no_solution(body: Body, data: Any) -> None:
    """No motion exists from a start in which these contacts slide.

    One contact i: k_i^σ < 0 < g_i, and a displacement closes contact i only. It is q less its part along M⁻¹N_i.
    Two contacts: no word goes on from their slide (see `Pair.continuations`), and the displacement along z opens all others.
    """
    slides = slides_of(data, body)
    speed = direction(body, data, "qdot")
    for i, side in slides:
        name = body.feet[i].name
        positive(
            dot(body.feet[i].tangent, speed).times(side), f"σ v_t of contact {name}"
        )
    if len(slides) == 1:
        [(i, side)] = slides
        foot = body.feet[i]
        negative(body.stiffness(i, side), f"k of contact {foot.name}")
        positive(body.pull(i), f"g of contact {foot.name}")
        place = direction(body, data, "q")
        back = dot(foot.normal, place) / body.couple(foot.normal, foot.normal)
        place = plus(place, scaled(body.over_mass(foot.normal), -back))
        for k, other in enumerate(body.feet):
            if k != i:
                positive(dot(other.normal, place), f"the gap of contact {other.name}")
        return
    require(len(slides) == 2, "data.contacts are not one or two contacts")
    slides.sort()
    pair = Pair(body.part([body.feet[i].name for i, _ in slides]))
    sides = [side for _, side in slides]
    ways = [way for way in (1, -1) if [pair.side(k, way) for k in range(2)] == sides]
    require(bool(ways), "the contacts do not slide together in these directions")
    require(
        not pair.continuations(ways[0]),
        "a word goes on from the slide of both contacts",
    )
    if len(body.feet) > 2:
        opens = [
            dot(foot.normal, pair.along).sign()
            for k, foot in enumerate(body.feet)
            if k not in [i for i, _ in slides]
        ]
        require(
            opens in ([1] * len(opens), [-1] * len(opens)),
            "the two contacts do not stay closed while all others open",
        )


def words_at_rest(pair: Pair) -> list[str]:
    """The words in which a body on two contacts can move, if both contacts move when they slide together."""
    return ["SS", "SF", "SR", "SL", "FS", "RS", "LS", pair.word(1), pair.word(-1)]


def kinematic_strong(pair: Pair, strict: bool) -> None:
    """Every word that moves has positive normal forces and violates a strict kinematic inequality."""
    body = pair.body
    for word in words_at_rest(pair):
        found = motion(body, word)
        for i, letter in enumerate(word):
            if letter != "S":
                positive(
                    found.forces[i][1],
                    f"the normal force of contact {body.feet[i].name} in the word {word}",
                )
            if letter == "F" and strict:
                for part in room(body, found, i):
                    positive(
                        part,
                        f"the distance from the edge of the friction cone of contact {body.feet[i].name} in the word {word}",
                    )
        require(
            any(value.hi < 0 for _, value in kinematics(body, found, word)),
            f"no kinematic inequality of the word {word} is certainly violated",
        )


def strong(body: Body, strict: bool) -> tuple[Interval, list[Interval]]:
    """What Theorem 3 and the theorem with Goyal's bound have in common; p_1p_2 and the restitutions.

    Kinematic-strong; one word goes on from each slide of both contacts; λ > 0; ψ_1, ψ_2 > 0."""
    require(len(body.feet) == 2, "the body does not stand on two contacts")
    pair = Pair(body)
    kinematic_strong(pair, strict)
    for way in (1, -1):
        found = pair.continuations(way)
        require(
            len(found) == 1 and found[0][0] != "falls",
            f"not one word goes on from the slide {pair.word(way)}",
        )
    for foot, weight, psi in zip(body.feet, pair.weights, pair.psi, strict=True):
        positive(weight, f"λ of contact {foot.name}")
        positive(psi, f"ψ of contact {foot.name}")
    e = [foot.restitution for foot in body.feet]
    p = [(ONE + e[i]) * pair.psi[i] for i in range(2)]
    return p[0] * p[1], e


def theorem_3(body: Body, data: Any, strict: bool = True) -> None:
    """Kinematic-strong, and (10): Λ₊³ > e_1e_2 with Λ₊ the larger root of Λ² − PΛ + e_1e_2, P = p_1p_2 − e_1 − e_2, p_i = (1+e_i)ψ_i."""
    product, e = strong(body, strict)
    trace, both = product - e[0] - e[1], e[0] * e[1]
    positive(trace, "P = p_1p_2 - e_1 - e_2")
    root = trace.square() - both.times(4)
    require(root.lo >= 0, f"P² - 4e_1e_2 is not certainly at least 0: {root}")
    large = (trace + root.sqrt()).half()
    positive(large.square() * large - both, "Λ³ - e_1e_2 of the bound (10)")


def theorem_3_loose(body: Body, data: Any) -> None:
    """As `theorem_3`, without the friction cone of fixed contacts."""
    theorem_3(body, data, strict=False)


def goyal(body: Body, data: Any) -> None:
    """Kinematic-strong, and Goyal's bound: p_1p_2 ≥ (√e_1 + √e_2)²."""
    product, e = strong(body, strict=False)
    room = product - (e[0].sqrt() + e[1].sqrt()).square()
    require(
        room.lo >= 0, f"p_1p_2 - (√e_1 + √e_2)² is not certainly at least 0: {room}"
    )


# Three and more contacts


@dataclass(frozen=True)
class Ray:
    """A direction that keeps two contacts closed, by their places, and opens all others."""

    pair: tuple[int, int]
    direction: Vector
    rise: int | None


def mirrored(body: Body, i: int, j: int) -> bool:
    """Whether two contacts are mirror images in the vertical line through the centre of mass."""
    one, two = body.feet[i], body.feet[j]
    exact = Fraction(one.point[0]) + Fraction(two.point[0])
    return (
        exact == 2 * Fraction(body.center[0])
        and one.point[1] == two.point[1]
        and one.slope == -two.slope
        and one.point[0] != two.point[0]
    )


def rays(body: Body, data: Any) -> list[Ray]:
    """The extreme rays of {q : N q ≥ 0}, which have to be those of the certificate."""
    found = []
    for i, j in combinations(range(len(body.feet)), 2):
        z = cross(body.feet[i].normal, body.feet[j].normal)
        opens = [
            dot(foot.normal, z).sign()
            for k, foot in enumerate(body.feet)
            if k not in (i, j)
        ]
        if 1 in opens and -1 in opens:
            continue
        names = f"contacts {body.feet[i].name} and {body.feet[j].name}"
        require(
            bool(opens) and opens in ([1] * len(opens), [-1] * len(opens)),
            f"what {names} leave open is not certain",
        )
        z = scaled(z, ONE.times(opens[0] or 0))
        rise = 0 if mirrored(body, i, j) else z[1].sign()
        require(
            rise is not None, f"the sign of y along the ray of {names} is not certain"
        )
        found.append(Ray((i, j), z, rise))
    pairs = [[body.feet[k].name for k in ray.pair] for ray in found]
    stated = entry(data, "rays", "data")
    require(stated == pairs, f"data.rays are {stated!r}, the rays are {pairs!r}")
    require(bool(found), "the contacts leave no ray")
    return found


def moves_on(body: Body, found: Sequence[Ray]) -> None:
    """From every state a motion exists: no exposed contact jams while it slides alone, and no pair while it slides along its ray."""
    for i in sorted({i for ray in found for i in ray.pair}):
        if body.pull(i).hi > 0:
            for way, side in SIDES.items():
                positive(
                    body.stiffness(i, side), f"k of contact {body.feet[i].name}, {way}"
                )
    for ray in found:
        goes_on(Pair(body.part([body.feet[k].name for k in ray.pair])))


def goes_on(pair: Pair) -> None:
    names = [foot.name for foot in pair.body.feet]
    for way in (1, -1):
        require(
            bool(pair.continuations(way)),
            f"contacts {names} jam while both slide ({pair.word(way)})",
        )


def well(body: Body, data: Any) -> None:
    """All rays ascend, by at least w times their largest component, and a motion always exists."""
    found = rays(body, data)
    width = Interval.of(Fraction(number(entry(data, "width", "data"), "data.width")))
    positive(width, "data.width")
    for ray in found:
        x, y, turn = ray.direction
        name = f"the ray of contacts {[body.feet[k].name for k in ray.pair]}"
        for part, of in (
            (x, "x"),
            (-x, "x"),
            (y, "y"),
            (turn * body.rho, "ρθ"),
            (-turn * body.rho, "ρθ"),
        ):
            rest = y - width * part
            require(
                rest.lo >= 0,
                f"y - w|{of}| of {name} is not certainly at least 0: {rest}",
            )
        positive(y, f"y of {name}")
    moves_on(body, found)


def descending_pair(body: Body, data: Any) -> str:
    """One ray does not ascend, and its pair decides; or the pairs of all rays that descend do not hold the body."""
    found = rays(body, data)
    core = [ray for ray in found if ray.rise != 1]
    pairs = entry(data, "pairs", "data")
    require(isinstance(pairs, list), "data.pairs is not a list")
    names = [[body.feet[k].name for k in ray.pair] for ray in core]
    stated = [
        entry(entry(pair, "claim", "pair"), "contacts", "claim") for pair in pairs
    ]
    require(
        stated == names,
        f"data.pairs are {stated!r}, the pairs of the rays that do not ascend are {names!r}",
    )
    require(bool(core), "all rays ascend")
    verdicts = []
    for pair in pairs:
        claim = entry(pair, "claim", "pair")
        verdicts.append((claimed(body.part(claim["contacts"]), pair), claim.get("by")))
    if len(core) == 1 and verdicts[0][0] == "stable":
        moves_on(body, found)
        return "stable"
    require(all(ray.rise == -1 for ray in core), "a ray is level")
    require(
        len(core) == 1 or all(by == "not-equilibrium" for _, by in verdicts),
        "several pairs descend, and one of them may hold the body",
    )
    return "unstable"


def neutral(body: Body, data: Any) -> None:
    """Level ground, or two contacts that are mirror images: λ > 0 on the outer contacts, friction at all, k > 0, and a slide of both goes on."""
    outer = body.places(entry(data, "outer", "data"))
    require(len(outer) == 2, "data.outer are not two contacts")
    if not (len(body.feet) == 2 and mirrored(body, 0, 1)):
        x = [foot.point[0] for foot in body.feet]
        require(all(foot.slope == 0 for foot in body.feet), "the ground is not level")
        low, high = x[outer[0]], x[outer[1]]
        require(
            low < high
            and all(low < x[k] < high for k in range(len(x)) if k not in outer),
            "data.outer are not the outer contacts",
        )
    for foot in body.feet:
        positive(foot.friction, f"the friction of contact {foot.name}")
    for i in outer:
        for way, side in SIDES.items():
            positive(
                body.stiffness(i, side), f"k of contact {body.feet[i].name}, {way}"
            )
    pair = Pair(body.part(sorted(body.feet[i].name for i in outer)))
    for foot, weight in zip(pair.body.feet, pair.weights, strict=True):
        positive(weight, f"λ of contact {foot.name}")
    goes_on(pair)


def accelerating_mode(body: Body, data: Any) -> None:
    """A word at rest is consistent and moves the body: q = ½q̈t² is a motion for ever."""
    word = entry(data, "word", "data")
    require(
        isinstance(word, str)
        and len(word) == len(body.feet)
        and set(word) <= set("SFRL"),
        f"data.word {word!r} has no letter S, F, R or L for each contact",
    )
    found = motion(body, word)
    for i, letter in enumerate(word):
        if letter == "F":
            for part in room(body, found, i):
                require(
                    part.lo >= 0,
                    f"the force of contact {body.feet[i].name} is not certainly in its friction cone: {part}",
                )
        if letter != "S":
            normal = found.forces[i][1]
            require(
                normal.lo >= 0,
                f"the normal force of contact {body.feet[i].name} is not certainly at least 0: {normal}",
            )
    tests = kinematics(body, found, word)
    require(bool(tests), f"the word {word} does not move")
    for name, value in tests:
        positive(value, name)


#: What each argument proves, and its check. "descending-pair" proves either.
CHECKS: dict[str, tuple[str, Callable[[Body, Any], Any]]] = {
    "not-equilibrium": ("unstable", not_equilibrium),
    "no-solution": ("unstable", no_solution),
    "accelerating-mode": ("unstable", accelerating_mode),
    "theorem-3": ("stable", theorem_3),
    "theorem-3-loose": ("stable", theorem_3_loose),
    "goyal": ("stable", goyal),
    "well": ("stable", well),
    "neutral": ("stable", neutral),
    "descending-pair": ("stable or unstable", descending_pair),
}


def claimed(body: Body, certificate: Any) -> str:
    """Checks the claim of a certificate on a body, and returns it: "stable" or "unstable"."""
    claim = entry(certificate, "claim", "certificate")
    stability, by = (
        entry(claim, key, "claim") for key in ("frictional_stability", "by")
    )
    require(
        isinstance(by, str) and by in CHECKS,
        f"claim.by {by!r} is no argument that can be checked",
    )
    require(
        entry(claim, "jams", "claim") == "none",
        f"claim.jams {claim['jams']!r} is not 'none'",
    )
    require(
        entry(claim, "contacts", "claim") == [foot.name for foot in body.feet],
        f"claim.contacts {claim['contacts']!r} are not the contacts of the scene",
    )
    proves, check_claim = CHECKS[by]
    try:
        proved = check_claim(body, entry(certificate, "data", "certificate")) or proves
    except ValueError as error:
        raise ValueError(f"{by}: {error}") from None
    require(
        stability == proved,
        f"claim.frictional_stability is {stability!r}; {by} proves {proved!r}",
    )
    return str(proved)


def check(certificate: Any) -> None:
    """Checks a certificate of a verdict, as `Verdict.certificate` makes it. Returns None if every step holds.

    Raises ValueError naming the step and the value otherwise.

    >>> foot = {"number": 1, "point": ["0x0p0", "0x0p0"], "slope": "0x0p0", "friction": "0x1p-1", "restitution": "0x0p0"}
    >>> scene = {"mass": "0x1p0", "gyration_radius": "0x1p0", "center_of_mass": ["0x1p0", "0x1p0"], "gravity": "0x1p3", "contacts": [foot]}
    >>> claim = {"frictional_stability": "unstable", "by": "not-equilibrium", "contacts": [1], "jams": "none"}
    >>> cert = {"conventions": 1, "scene": scene, "claim": claim, "data": {"separates": ["0x0p0", "-0x1p-1", "-0x1p0"]}}
    >>> check(cert)
    >>> cert["data"]["separates"][2] = "0x0p0"
    >>> check(cert)
    Traceback (most recent call last):
    ValueError: not-equilibrium: y·w of the edge n + μt of contact 1 is not certainly at least 0: in [-0.5, -0.5]
    """
    version = entry(certificate, "conventions", "certificate")
    require(
        type(version) is int and version == CONVENTIONS,
        f"conventions {version!r}: this program checks version {CONVENTIONS}",
    )
    claimed(body_of(entry(certificate, "scene", "certificate")), certificate)


def read(path: Path) -> Any:
    """The certificate in a file. Raises ValueError naming the line that is not JSON."""
    try:
        return json.loads(path.read_bytes())
    except json.JSONDecodeError as error:
        raise ValueError(
            f"line {error.lineno}, column {error.colno}: {error.msg}"
        ) from None
    except (UnicodeDecodeError, RecursionError):
        raise ValueError("it is not a JSON text") from None


def summary(certificate: Any) -> str:
    """One line on a certificate that has been checked."""
    claim = certificate["claim"]
    return f"{claim['frictional_stability']} by {claim['by']}: every step holds"


def main(arguments: Iterable[str]) -> int:
    """Checks the certificates in files; 0 if all hold."""
    code = 0
    for name in arguments:
        try:
            certificate = read(Path(name))
            check(certificate)
            print(f"{name}: {summary(certificate)}")
        except (ValueError, OSError) as error:
            print(f"{name}: {error}", file=sys.stderr)
            code = 2
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
