"""The end of a flight in a self-similar tail: impacts that repeat for ever, smaller by the same factor from round to round.

The shape after an impact at a is v = u_b/u_a and y = h_b/u_a². The next impact multiplies u_a by f after the time τ u_a:

    a again:   τ = 2/g_a, f = e_a     v' = (v − g_bτ − (1+e_a)ψ_a)/f     y' = (y + vτ − ½g_bτ²)/f²
    b lands:   s = √(v² + 2g_b y), τ = (v + s)/g_b, f = e_b s, w = 1 − g_aτ
               v' = w/f − (1+e_b)ψ_b/e_b     y' = (τ − ½g_aτ²)/f²     ds = (v dv + g_b dy)/s     dτ = (τ dv + dy)/s
"""

import math
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction

from .intervals import ONE, UNIT, ZERO, Interval, positive, require

Matrix = list[list[Interval]]
Pair = tuple[Interval, Interval]

#: Longest cycle, and largest number of impacts in a round.
LONGEST, ROUND = 12, 96
#: Largest difference of two shapes that count as the same, and half-widths of the boxes, relative to 1 + |v| and y.
SAME, BOXES = 2.0**-10, (2.0**-10, 2.0**-14, 2.0**-18)
#: Newton's steps from a shape to the cycle.
NEWTON_STEPS = 3
#: Width of shapes from which on they are followed in a frame.
ROUGH = UNIT >> 160
#: Number of proofs that are tried in a flight.
PROOFS = 4


def not_below_zero(value: Interval, name: str) -> Interval:
    require(value.hi >= 0, f"{name} is negative: {value}")
    return Interval(max(value.lo, 0), value.hi)


def landing(h: Interval, u: Interval, a: Interval) -> Interval | None:
    """The time at which a gap h ≥ 0 with rate u and acceleration a becomes zero; None if that is not certain."""
    square = u.square() - (a * h).times(2)
    if a.hi < 0:
        root = square.sqrt()
        if u.hi < 0:
            return not_below_zero(h.times(2) / (root - u), "a time")
        return not_below_zero((u + root) / -a, "a time")
    if u.hi < 0 and square.lo > 0:
        return h.times(2) / (square.sqrt() - u)
    return None


def never_lands(h: Interval, u: Interval, a: Interval) -> bool:
    """Whether such a gap certainly never becomes zero."""
    rises = u.lo >= 0 and a.lo >= 0
    return rises or (a.lo > 0 and (u.square() - (a * h).times(2)).hi < 0)


@dataclass(frozen=True)
class Falls:
    """What a gap may do: it lands after the time `t` with the speed `speed`, if `t` is not None; it stays open for ever, if `never`."""

    t: Interval | None
    speed: Interval
    never: bool


def falls(h: Interval, u: Interval, a: Interval) -> Falls | None:
    """The next landing of a gap h ≥ 0 with rate u and acceleration a; None if nothing bounds it.

    If a > 0 and it is not certain whether it lands: it does only if u < 0 and u² ≥ 2ah, within |u|/a and with at most the speed |u|."""
    t = landing(h, u, a)
    if t is not None:
        return Falls(t, fall(h, u, a), False)
    if never_lands(h, u, a):
        return Falls(None, ZERO, True)
    if a.lo <= 0:
        return None
    speed = Interval(0, max(-u.lo, 0))
    return Falls(Interval(0, (speed / a).hi), speed, True)


def fall(h: Interval, u: Interval, a: Interval) -> Interval:
    """The landing speed √(u² − 2ah)."""
    return (u.square() - (a * h).times(2)).sqrt()


def product(one: Matrix, two: Matrix) -> Matrix:
    return [[row[0] * two[0][k] + row[1] * two[1][k] for k in range(2)] for row in one]


def inverse_of(matrix: Matrix) -> Matrix:
    [[a, b], [c, d]] = matrix
    det = a * d - b * c
    return [[d / det, -b / det], [-c / det, a / det]]


def eigenvectors(matrix: list[list[float]]) -> tuple[list[list[float]], float]:
    """As columns (real and imaginary part, if they are complex), and the largest absolute eigenvalue; in rounded numbers: any basis will do."""
    [[a, b], [c, d]] = matrix
    mean, half = (a + d) / 2, (a - d) / 2
    square = half * half + b * c
    root = math.sqrt(abs(square))
    if square < 0:
        columns = [[b, -half], [0.0, root]]
        largest = math.hypot(mean, root)
    else:
        columns = [
            [b, first] if abs(first) > abs(second) else [second, c]
            for first, second in ((root - half, root + half), (-root - half, half - root))
        ]  # fmt: skip
        largest = abs(mean) + root
    unit = [max(map(abs, column)) or 1.0 for column in columns]
    if square < 0:
        unit = [max(unit)] * 2
    return [[columns[k][i] / unit[k] for k in range(2)] for i in range(2)], largest


def middle(x: Interval) -> Interval:
    half = (x.lo + x.hi) >> 1
    return Interval(half, half)


def rotation_along(long: Matrix, off: Pair) -> Matrix:
    """The rotation, in rounded numbers, that turns the first axis along the longer one of the images of two sides of a box."""
    sides = [
        [(row[k].lo + row[k].hi) / (2 * UNIT) * ((off[k].hi - off[k].lo) / UNIT) for row in long]
        for k in range(2)
    ]  # fmt: skip
    x, y = max(sides, key=lambda side: math.hypot(*side))
    length = math.hypot(x, y)
    if length == 0:
        return [[ONE, ZERO], [ZERO, ONE]]
    c, s = (Interval.of(Fraction(part / length)) for part in (x, y))
    return [[c, -s], [s, c]]


@dataclass(frozen=True)
class Frame:
    """Shapes c + Q d with d in a box. Q turns with them, so that a narrow set is not replaced by a square around it [Lohner 1987]."""

    contact: int
    center: Pair
    turn: Matrix
    off: Pair

    @staticmethod
    def around(a: int, shape: Pair) -> "Frame":
        v, y = middle(shape[0]), middle(shape[1])
        unit = [[ONE, ZERO], [ZERO, ONE]]
        return Frame(a, (v, y), unit, (shape[0] - v, shape[1] - y))

    def box(self) -> Pair:
        v, y = (
            c + row[0] * self.off[0] + row[1] * self.off[1]
            for c, row in zip(self.center, self.turn, strict=True)
        )
        return v, y


class Tails:
    """The shapes of a flight, from impact to impact."""

    def __init__(
        self, g: list[Interval], e: list[Interval], psi: list[Interval]
    ) -> None:
        self.g: list[Interval] = g
        self.e: list[Interval] = e
        self.psi: list[Interval] = psi
        self.seen: list[tuple[int, float, float]] = []
        self.tries: int = 0
        self.same: float = SAME
        self.frame: Frame | None = None

    def narrowed(self, a: int, shape: Pair) -> Pair:
        """The shapes after an impact, without those that are not in the frame. It begins once the shapes are no longer precise."""
        wide = max(part.hi - part.lo for part in shape)
        frame = self.frame and self.turned(self.frame)
        if frame is not None and frame.contact == a:
            v, y = (
                Interval(max(one.lo, two.lo), min(one.hi, two.hi))
                for one, two in zip(shape, frame.box(), strict=True)
            )
            self.frame = frame
            return v, y
        self.frame = Frame.around(a, shape) if wide > ROUGH else None
        return shape

    def turned(self, frame: Frame) -> Frame | None:
        """The next impact of the shapes in a frame: the images lie in c' + D Q d, with c' the image of c and D the derivatives on a box around
        them [mean value theorem]. None if it is not certain."""
        try:
            a, _, _, _, slopes = self.step(frame.contact, *frame.box())
            also, image, _, _, _ = self.step(frame.contact, *frame.center)
            long = product(slopes, frame.turn)
            turn = rotation_along(long, frame.off)
            back = inverse_of(turn)
        except ValueError:
            return None
        center = middle(image[0]), middle(image[1])
        rest = [p - c for p, c in zip(image, center, strict=True)]
        x, y = (
            row[0] * frame.off[0] + row[1] * frame.off[1] + more[0] * rest[0] + more[1] * rest[1]
            for row, more in zip(product(back, long), back, strict=True)
        )  # fmt: skip
        return Frame(a, center, turn, (x, y)) if a == also else None

    def after(self, a: int, v: Interval, y: Interval) -> Interval | None:
        """The time until both contacts rest, in units of u_a, if the impacts from this shape on certainly repeat for ever; else None."""
        at = [(part.lo + part.hi) / (2 * UNIT) for part in (v, y)]
        self.seen = [*self.seen[-LONGEST:], (a, at[0], at[1])]
        if at[1] <= 0 or self.tries >= PROOFS:
            return None
        back = next((p for p in range(1, len(self.seen)) if self.is_same(p)), None)
        if back is None:
            return None
        self.tries, self.same = self.tries + 1, self.same / 32
        try:
            return self.repeats(a, (v, y), back)
        except (ValueError, ZeroDivisionError, OverflowError):
            return None

    def is_same(self, p: int) -> bool:
        (a, v, y), (b, rate, gap) = self.seen[-1], self.seen[-1 - p]
        off = max(abs(v - rate) / (1 + abs(v)), abs(y - gap) / y)
        return a == b and off <= self.same

    def step(
        self, a: int, v: Interval, y: Interval
    ) -> tuple[int, Pair, Interval, Interval, Matrix]:
        """The next impact from all of these shapes: its contact and shapes, f, τ, and the derivatives."""
        b = 1 - a
        again = ONE.times(2) / self.g[a] if self.g[a].lo > 0 else None
        require(y.lo >= 0, "a gap may be negative")
        lands = landing(y, v, -self.g[b])
        if lands is None:
            require(
                never_lands(y, v, -self.g[b]), "whether a contact lands is not certain"
            )
        if again is not None and (lands is None or (again - lands).hi < 0):
            t, f = again, self.e[a]
            positive(f, "the speed after an impact")
            lost = (ONE + f) * self.psi[a]
            gap = y + v * t - (self.g[b] * t.square()).half()
            shape = (v - self.g[b] * t - lost) / f, gap / f.square()
            inverse = ONE / f
            slopes = [[inverse, ZERO], [t / f.square(), ONE / f.square()]]
            return a, shape, f, t, slopes
        first = self.g[a].hi <= 0 if again is None else lands and (lands - again).hi < 0
        if lands is None or not first:
            raise ValueError("the order of impacts is not certain")
        t, s, w = lands, fall(y, v, -self.g[b]), ONE - self.g[a] * lands
        f = self.e[b] * s
        positive(f, "the speed after an impact")
        gap = (t * (ONE + w)).half() / f.square()
        shape = w / f - (ONE + self.e[b]) * self.psi[b] / self.e[b], gap
        ds, dt = (v / s, self.g[b] / s), (t / s, ONE / s)
        slopes = [
            [-(w / (f * s) * p + self.g[a] / f * q) for p, q in zip(ds, dt, strict=True)],
            [w / f.square() * q - gap.times(2) / s * p for p, q in zip(ds, dt, strict=True)],
        ]  # fmt: skip
        return b, shape, f, t, slopes

    def repeats(self, a: int, now: Pair, period: int) -> Interval | None:
        """With F^q of q impacts, c near the shape, and a basis X, the box Z = c + X[−r, r]² is mapped into itself if

            X⁻¹(F^q(c) − c) + (X⁻¹ DF^q(Z) X)[−r, r]² ⊂ (−r, r)²     [mean value theorem].

        If u_a is multiplied by f < 1 in such a round of duration T, both contacts rest after T/(1 − f)."""
        x, y = middle(now[0]), middle(now[1])
        unit = [[ONE, ZERO], [ZERO, ONE]]
        slopes = unit
        for _ in range(NEWTON_STEPS):
            # (1 − J)(c' − c) = F^p(c) − c
            j, shape, slopes = a, (x, y), unit
            for _ in range(period):
                j, shape, _, _, step = self.step(j, *shape)
                slopes = product(step, slopes)
            require(j == a, "the cycle does not come back to its contact")
            back = inverse_of([[p - q for p, q in zip(*rows, strict=True)] for rows in zip(unit, slopes, strict=True)])  # fmt: skip
            off = shape[0] - x, shape[1] - y
            x, y = (
                middle(c + row[0] * off[0] + row[1] * off[1])
                for c, row in zip((x, y), back, strict=True)
            )
        center = [x, y]
        at = [x.lo / UNIT, y.lo / UNIT]
        # In units of 1 + |v| and y.
        size = [1 + abs(at[0]), at[1]]
        rough = [
            [(slopes[i][k].lo / UNIT) * size[k] / size[i] for k in range(2)]
            for i in range(2)
        ]
        basis, largest = eigenvectors(rough)
        require(largest < 1, "the cycle does not attract")
        rounds = 1 if largest < 0.6 else math.ceil(math.log(0.6) / math.log(largest))
        require(rounds * period <= ROUND, "the cycle attracts too slowly")
        basis_of = [
            [Interval.of(Fraction(basis[i][k] * size[i])) for k in range(2)]
            for i in range(2)
        ]
        for r in BOXES:
            with suppress(ValueError):
                box = Interval.of(Fraction(r))
                found = self.round(a, center, now, basis_of, box, rounds * period)
                if found is not None:
                    return found
        return None

    def round(
        self,
        a: int,
        center: list[Interval],
        now: Pair,
        x: Matrix,
        r: Interval,
        impacts: int,
    ) -> Interval | None:
        """The time until both contacts rest, if a round maps the box into itself. F^n(Z) lies in F^n(c) + (DF^n(Z) X)[−r, r]²."""
        sides = Interval(-r.hi, r.hi)
        back = inverse_of(x)

        def inside(off: list[Interval], spread: Matrix) -> bool:
            moved = (
                row[0] * off[0] + row[1] * off[1] + sum_of(wide) * sides
                for row, wide in zip(back, spread, strict=True)
            )
            return all(-r.lo < part.lo and part.hi < r.lo for part in moved)

        def sum_of(row: list[Interval]) -> Interval:
            most = sum(max(abs(part.lo), abs(part.hi)) for part in row)
            return Interval(most, most)

        nothing = [[ZERO, ZERO], [ZERO, ZERO]]
        if not inside([p - c for p, c in zip(now, center, strict=True)], nothing):
            return None
        j, middle, long = a, (center[0], center[1]), x
        factor, time = ONE, ZERO
        for _ in range(impacts):
            v, y = (
                p + sum_of(row) * sides for p, row in zip(middle, long, strict=True)
            )
            then, _, f, t, slopes = self.step(j, v, y)
            also, middle, _, _, _ = self.step(j, *middle)
            require(then == also, "the order of impacts is not certain")
            time, factor, long, j = time + factor * t, factor * f, product(slopes, long), then  # fmt: skip
        off = [p - c for p, c in zip(middle, center, strict=True)]
        if j != a or factor.hi >= UNIT or not inside(off, product(back, long)):
            return None
        return time / (ONE - factor)
