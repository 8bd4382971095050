"""Linear algebra in fractions, for scenes whose numbers are exact."""

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import combinations
from math import lcm
from typing import Any

from .intervals import require

Row = Sequence[Fraction]


def rational(value: Any, name: str) -> Fraction:
    """A number, from the text of a double that `float.hex` writes, or from that of a fraction of integers."""
    found = None
    if isinstance(value, str):
        with suppress(ValueError, ZeroDivisionError, OverflowError):
            if re.fullmatch(r"-?\d+(/\d+)?", value, re.ASCII):
                found = Fraction(value)
            elif float.fromhex(value).hex() == value:
                found = Fraction(float.fromhex(value))
    if found is None:
        raise ValueError(
            f"{name} is not a finite double as float.hex writes it, and no fraction: {value!r}"
        )
    return found


def rationals(values: Any, count: int, name: str) -> list[Fraction]:
    require(
        isinstance(values, list) and len(values) == count,
        f"{name} is not a list of {count} numbers",
    )
    return [rational(value, f"{name}[{k}]") for k, value in enumerate(values)]


def inner(one: Row, two: Row) -> Fraction:
    """a·b"""
    return sum((a * b for a, b in zip(one, two, strict=True) if a and b), Fraction(0))


def reduced(rows: Sequence[Row]) -> tuple[list[list[Fraction]], list[int]]:
    """The rows in reduced echelon form without those that are zero, and the columns of their pivots."""
    left, pivots = [list(row) for row in rows], list[int]()
    done: list[list[Fraction]] = []
    for column in range(len(left[0]) if left else 0):
        place = next((k for k, row in enumerate(left) if row[column]), None)
        if place is None:
            continue
        lead = left.pop(place)
        lead = [part / lead[column] if part else part for part in lead]
        left, done = (
            [
                [
                    a - row[column] * b if b else a
                    for a, b in zip(row, lead, strict=True)
                ]
                if row[column]
                else row
                for row in part
            ]
            for part in (left, done)
        )
        done.append(lead)
        pivots.append(column)
    return done, pivots


def kernel(rows: Sequence[Row], count: int) -> list[list[Fraction]]:
    """A basis of the vectors, with this number of entries, to which all rows are orthogonal."""
    done, pivots = reduced(rows)
    basis = []
    for free in sorted(set(range(count)) - set(pivots)):
        vector = [Fraction(k == free) for k in range(count)]
        for row, pivot in zip(done, pivots, strict=True):
            vector[pivot] = -row[free]
        basis.append(vector)
    return basis


def solutions(
    matrix: Sequence[Row], right: Sequence[Row]
) -> tuple[list[list[Fraction]] | None, bool]:
    """For each of some right sides (rows) a solution x of A x = b, None if one has none; and whether it is the only one."""
    count = len(matrix[0]) if matrix else 0
    done, pivots = reduced(
        [[*row, *b] for row, b in zip(matrix, zip(*right, strict=True), strict=True)]
    )
    inside = [k for k in pivots if k < count]
    if len(inside) < len(pivots):
        return None, False
    found = [[Fraction(0)] * count for _ in right]
    for row, pivot in zip(done, pivots, strict=True):
        for x, value in zip(found, row[count:], strict=True):
            x[pivot] = value
    return found, len(inside) == count


def solution_near(matrix: Sequence[Row], guess: Row) -> list[Fraction] | None:
    """The solution x of A x = b, with the rows of A and then an entry of b, that has the unknowns without a pivot as guessed; None if there is none."""
    done, pivots = reduced(matrix)
    if len(guess) in pivots:
        return None
    found = list(guess)
    for row, pivot in zip(done, pivots, strict=True):
        found[pivot] = row[-1] - sum(
            (row[j] * x for j, x in enumerate(guess) if j != pivot and row[j]),
            Fraction(0),
        )
    return found


def is_positive_definite(matrix: Sequence[Row]) -> bool:
    """Whether all leading minors of a symmetric matrix are positive, by elimination without fractions [Bareiss 1968]."""
    whole = lcm(*(part.denominator for row in matrix for part in row))
    left = [[int(part * whole) for part in row] for row in matrix]
    before = 1
    while left:
        lead = left.pop(0)
        minor = lead[0]
        if minor <= 0:
            return False
        left = [
            [
                (minor * a - row[0] * b) // before
                for a, b in zip(row[1:], lead[1:], strict=True)
            ]
            for row in left
        ]
        before = minor
    return True


def lines(rows: Sequence[Row], most: int) -> Iterator[list[Fraction]]:
    """The vectors x ≠ 0, up to a factor, to which as many rows are orthogonal as can be: independent ones up to one less than the number of entries.

    The rows have to span the space. Some x may come more than once. Raises ValueError if there are more than `most` choices of rows."""
    count = len(rows[0])
    for n, some in enumerate(combinations(rows, count - 1)):
        require(n < most, f"more than {most} sets of contacts have to be tried")
        basis = kernel(some, count)
        if len(basis) == 1:
            yield basis[0]


def is_strictly_copositive(matrix: Sequence[Row]) -> bool:
    """Whether x·S x > 0 for all x ≥ 0, x ≠ 0, of a symmetric matrix.

    Take a smallest set of places such that x·S x ≤ 0 for some x > 0 on it, and there the x with the least x·S x and Σx = 1. Then S x = m 1, m ≤ 0,
    for the part S of this set. If m < 0, S has an inverse and S⁻¹1 < 0; if m = 0, the x with S x = 0 are one line: along any other one x could be
    moved to the border of the set without a larger x·S x. So it is enough to try the parts S. A place with S_ii > 0 and no S_ij < 0 is in no such set, and
    a definite part has no such set in it.
    """
    if any(row[i] <= 0 for i, row in enumerate(matrix)):
        return False
    seen: set[tuple[int, ...]] = set()

    def holds(places: tuple[int, ...]) -> bool:
        while True:
            some = tuple(i for i in places if any(matrix[i][j] < 0 for j in places))
            if some == places:
                break
            places = some
        part = [[matrix[i][j] for j in places] for i in places]
        if places in seen:
            return True
        seen.add(places)
        if is_positive_definite(part):
            return True
        return not is_low_inside(part) and all(
            holds(places[:k] + places[k + 1 :]) for k in range(len(places))
        )

    return holds(tuple(range(len(matrix))))


def is_low_inside(part: Sequence[Row]) -> bool:
    """Whether S x = m 1 for some x > 0 and m < 0, with an inverse of S, or for the x of one line and m = 0."""
    if all(sum(row) > 0 for row in part):
        return False  # then x·S 1 > 0, and not m Σ1
    found, unique = solutions(part, [[Fraction(1)] * len(part)])
    if unique:
        return found is not None and all(x < 0 for x in found[0])
    basis = kernel(part, len(part))
    signs = {x > 0 for x in basis[0] if x} if len(basis) == 1 else set()
    return len(signs) == 1 and all(basis[0])
