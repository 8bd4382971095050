"""Intervals of binary fractions with outward rounding, and the steps of a check: a sign is certain, or the certificate is refused."""

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeVar

#: Numbers are multiples of 2^-BITS. The scene is scaled first, to a size and a gravity between 1/2 and 1.
BITS = 256


UNIT = 1 << BITS


class Interval:
    """All numbers between lo and hi, in units of 2^-BITS. Every operation rounds outwards."""

    __slots__ = ("hi", "lo")

    def __init__(self, lo: int, hi: int) -> None:
        self.lo: int = lo
        self.hi: int = hi

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


T = TypeVar("T")


def require(holds: bool, otherwise: str) -> None:
    """Refuses the certificate unless a step holds."""
    if not holds:
        raise ValueError(otherwise)


def known(value: T | None, otherwise: str) -> T:
    """Refuses the certificate if a value is not known."""
    if value is None:
        raise ValueError(otherwise)
    return value


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


#: Bits of the exponential function and of the logarithm.
COARSE = 128


def exponential(x: int) -> int:
    """A lower bound of e^x, in units, for a number in units. Above x = 1000 it is that of e^1000."""
    x = min(x, 1000 * UNIT)
    one = 1 << COARSE
    # ln 2 = 2 artanh(1/3), from below.
    log_2, power, k = 0, 2 * one // 3, 1
    while power:
        log_2, power, k = log_2 + power // k, power // 9, k + 2
    x >>= BITS - COARSE
    n = x // (log_2 + 256) if x > 0 else x // log_2
    x -= n * log_2 if n < 0 else n * (log_2 + 256)
    total, term, k = 0, one, 0
    while term:
        total, k = total + term, k + 1
        term = term * x // (one * k)
    shift = n + BITS - COARSE
    return total << shift if shift >= 0 else total >> -shift


def logarithm(x: int) -> int:
    """An upper bound of ln x, in units, for a number of at least 1 in units: 2 artanh z with z = (x − 1)/(x + 1). Above 2 it is x − 1."""
    if x > 2 * UNIT:
        return x - UNIT
    z = -(-(x - UNIT) * UNIT // (x + UNIT))
    square = -(-z * z >> BITS)
    total, power, k = 0, z, 1
    while power > k * (UNIT >> COARSE):
        total, power, k = total - (-power // k), -(-power * square >> BITS), k + 2
    # z ≤ 1/3: the rest of the series is below 9/8 of its first term.
    return 2 * (total + 2 * power)


def at_least_zero(a: Interval, b: Interval, c: Interval, low: int, high: int) -> bool:
    """Whether a x² + b x + c ≥ 0 for all x between two numbers, certainly."""
    for x in (Interval(low, low), Interval(high, high)):
        if ((a * x + b) * x + c).lo < 0:
            return False
    if a.hi <= 0:
        return True  # concave
    steep = a.times(2)
    left, right = steep * Interval(low, low) + b, steep * Interval(high, high) + b
    if left.lo >= 0 or right.hi <= 0:
        return True  # monotone
    return a.lo > 0 and (a.times(4) * c - b.square()).lo >= 0
