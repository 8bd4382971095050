"""Sines and cosines of decimal numbers, to the digits of the decimal context in use.

The oracles compute with ``decimal.Decimal``, which is written in C and about ten times as fast as mpmath.
"""

from decimal import Decimal, getcontext, localcontext
from functools import lru_cache

from mpmath import mp

#: Additional digits beyond those of the context.
GUARD = 8


@lru_cache
def quarter_turn(digits):
    """π/2."""
    with mp.workdps(digits + GUARD):
        return Decimal(mp.nstr(mp.pi / 2, digits + GUARD))


@lru_cache
def _unit(digits):
    """Number of bits after the binary point of a fixed-point number, and the number one."""
    bits = (digits + GUARD) * 10 // 3
    return bits, 1 << bits, Decimal(1 << bits)


def _series(x):
    """``turn`` for |x| < 1: power series of (1 − cos x)/x² and (sin x − x)/x³, summed in integers."""
    bits, one, unit = _unit(getcontext().prec)
    square = x * x
    z = int(square * unit)
    even, odd, n = one >> 1, -(one // 6), 4
    cosine, sine = even, odd
    while even:
        even = -((even * z) >> bits) // ((n - 1) * n)
        odd = -((odd * z) >> bits) // (n * (n + 1))
        cosine += even
        sine += odd
        n += 2
        if -1 <= even <= 0:  # integers are rounded down
            break
    less_one = Decimal(cosine) / unit * square
    less_x = Decimal(sine) / unit * square * x
    return 1 - less_one, x + less_x, less_one, less_x


def cos_sin(x):
    """Cosine and sine."""
    turns = 0
    if abs(x) > 1:
        with localcontext() as wide:
            wide.prec += GUARD + max(0, x.adjusted())
            quarter = quarter_turn(wide.prec)
            turns = int((x / quarter).to_integral_value())
            x = x - turns * quarter
    cos, sin, _, _ = _series(x)
    return ((cos, sin), (-sin, cos), (-cos, -sin), (sin, -cos))[turns % 4]


def turn(x):
    """cos x, sin x, 1 − cos x and sin x − x, each to full relative accuracy."""
    if abs(x) < 1:
        return _series(x)
    cos, sin = cos_sin(x / 2)
    lost, whole = 2 * sin * sin, 2 * sin * cos
    return 1 - lost, whole, lost, whole - x
