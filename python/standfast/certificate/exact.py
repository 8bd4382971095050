"""Linear algebra in fractions, for scenes whose numbers are exact."""

import re
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction
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


def is_positive_definite(matrix: Sequence[Row]) -> bool:
    """Whether all pivots of a symmetric matrix are positive."""
    left = [list(row) for row in matrix]
    while left:
        lead = left.pop(0)
        if lead[0] <= 0:
            return False
        left = [
            [a - row[0] / lead[0] * b for a, b in zip(row[1:], lead[1:], strict=True)]
            if row[0]
            else row[1:]
            for row in left
        ]
    return True
