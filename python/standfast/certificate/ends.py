"""The fast-slide ends of the corner map: ξ/y near ±∞, where r does not change from corner to corner."""

from dataclasses import dataclass, replace

from .corners import Cell, Corners, Image
from .intervals import ONE, UNIT, ZERO, Interval, known, logarithm, positive, require
from .tails import never_lands

#: Rounds in which the sum of the landing speeds in a fast-slide end is found.
SUM_ROUNDS = 64


@dataclass(frozen=True)
class Repelling:
    """A fast-slide end that the corners leave: a bound of the growth ln r until then."""

    transit: int


@dataclass(frozen=True)
class Attracting:
    """A fast-slide end in which both contacts finally slide together. With ξ = ±1 and w = y at the first corner: |ξ| is finally
    1 + limit w, and until then 1 + w times a number between 0 and `change`; y grows at most by `stretch` on the way. `leaves`: the contacts
    whose corners may also leave the end, because the other contact lifts off."""

    limit: Interval
    change: Interval
    stretch: Interval
    leaves: list[int]


End = Repelling | Attracting


@dataclass(frozen=True)
class Fast:
    """A corner of a fast slide, with ξ > 0: the contact that lands next, and A, B, K. The slide begins at ξ + A y and ends at ξ' = ξ + B y
    with a landing, y' = K y."""

    then: int
    shift: Interval
    bend: Interval
    factor: Interval


def fast_end(one: Fast, two: Fast, width: int, name: str) -> End:
    """The corners with w = y/ξ ≤ width at a fast-slide end; `two` follows `one`, and `one` follows `two`.

    Once around, from the first corner, y is multiplied by κ = K_1K_2, and ξ grows by a y, a = B_1 + B_2K_1. So C = ξ − x y keeps its value
    there, x = a/(κ − 1), and so it does at the second corners with their own x. With C > 0, w = y/(C + x y) rises and falls with y.

    κ < 1: w falls at the first corners, and both contacts slide together at C in the end, which is 1 − x w for ξ = 1.
    κ > 1: w rises until the corners leave the end. ξ = C/(1 − x w) grows on the way from first to first corners at most by 1/(1 − x width)
    if x > 0, and otherwise not at all; then half a round may follow. This bounds ln r'/r.
    """
    wide = Interval(0, width)
    kappa = one.factor * two.factor
    x = (one.bend + two.bend * one.factor) / (kappa - ONE)
    keeps_on(one, wide, name)
    if kappa.hi < UNIT:
        most = one.factor * wide / (ONE + one.bend * wide)
        keeps_on(two, Interval(0, most.hi), name)
        positive(ONE - x * wide, f"{name}: the speed of the slide of both contacts")
        return Attracting(-x, ZERO, ONE, [])
    require(kappa.lo > UNIT, f"{name}: whether y grows is not certain")
    steep = Interval(max(x.hi, 0), max(x.hi, 0))
    left = ONE - steep * wide
    positive(left, f"{name}: 1 - xw")
    half = (ONE + one.bend * wide).square() + (one.factor * wide).square()
    square = max((ONE + wide.square()).hi, half.hi)
    growth = Interval(square, square) / left.square()
    return Repelling(-(-logarithm(growth.hi) >> 1))


def keeps_on(corner: Fast, wide: Interval, name: str) -> None:
    """The slide after a corner does not turn."""
    positive(ONE + corner.shift * wide, f"{name}: ξ at the start of a slide")
    positive(ONE + corner.bend * wide, f"{name}: ξ at the end of a slide")


class Ends:
    """The fast-slide ends of a corner map."""

    def __init__(self, corners: Corners) -> None:
        self.corners = corners

    def kind(self, j: int, way: int, width: int, name: str) -> End:
        """The end of the corners at j with this sign of ξ and y/|ξ| ≤ width. There ξ' = ξ + B y, y' = K y at each corner."""
        own = self.fast(j, way)
        if len(own) == 1:
            [one] = own
            back = own if one.then == j else self.fast(one.then, way)
            if len(back) == 1 and back[0].then == j and self.certain(j, one.then):
                return fast_end(one, back[0], width, name)
        return self.several(j, way, width, name)

    def certain(self, *contacts: int) -> bool:
        """Whether one course follows the corners at each of these contacts."""
        return all(len(self.corners.course(j)) == 1 for j in contacts)

    def fast(self, j: int, way: int) -> list[Fast]:
        """The corners that may follow at a fast-slide end."""
        found = []
        for course in self.corners.course(j):
            lands = course.lands[way]
            require(
                not course.flight.away, f"the body may move away at contact {j + 1}"
            )
            k = course.flight.kept
            if k is None:
                continue
            if lands is None:
                arc = known(
                    self.corners.slides[k][way],
                    f"contact {k + 1} is not certainly pressed onto its ground",
                )
                require(
                    never_lands(course.flight.h, course.flight.u, arc.normal),
                    "whether a contact lands during a slide is not certain",
                )
            else:
                shift, bend = course.shift.times(way), lands.bend.times(way)
                found.append(Fast(1 - k, shift, bend, lands.factor))
        return found

    def several(self, j: int, way: int, width: int, name: str) -> Attracting:
        """An end in which several corners may follow one. With K_jm the largest y'/y of a corner at m after one at j, the sum of all y is at
        most S_j y, S_j ≥ 1 + max_m K_jm S_m, and each y at most y max(1, K_jm), because no round of corners enlarges it."""
        reached: list[int] = []
        opened, bend, factors = [j], ZERO, [[0, 0], [0, 0]]
        while opened:
            at = opened.pop()
            if at in reached:
                continue
            reached.append(at)
            for fast in self.fast(at, way):
                low, high = fast.shift, fast.bend
                bend = Interval(
                    min(bend.lo, low.lo, high.lo), max(bend.hi, low.hi, high.hi)
                )
                factors[at][fast.then] = max(factors[at][fast.then], fast.factor.hi)
                opened.append(fast.then)
        most = [[Interval(k, k) for k in row] for row in factors]
        sums = [ONE, ONE]

        def rounds(sums: list[Interval]) -> list[Interval]:
            return [
                Interval(*[max((ONE + row[m] * sums[m]).hi for m in range(2))] * 2)
                for row in most
            ]

        for _ in range(SUM_ROUNDS):
            sums = rounds(sums)
        sums = [total + total * Interval(UNIT >> 6, UNIT >> 6) for total in sums]
        require(
            all(new.hi <= old.lo for new, old in zip(rounds(sums), sums, strict=True)),
            f"{name}: the landing speeds do not certainly have a finite sum",
        )
        change = bend * Interval(*[sums[j].hi] * 2)
        stretch = max(UNIT, *factors[j])
        reach = ONE + change * Interval(0, width)
        positive(reach, f"{name}: ξ during the slides")
        return Attracting(change, change, Interval(stretch, stretch), reached)

    def after(self, end: Attracting, way: int, cell: Cell) -> list[Image]:
        """What follows the corners of a cell of an attracting end."""
        corners, w = self.corners, cell.y
        found = corners.together((ONE + w * end.limit).times(way))
        reach = ONE + w * Interval(min(end.change.lo, 0), max(end.change.hi, 0))
        positive(reach, "ξ during the slides")
        wide = (Interval(w.hi, w.hi) * end.stretch / reach).hi
        last = Cell(ONE.times(way), Interval(0, wide), None, None)
        larger = Interval(max(reach.lo, 0), reach.hi).square()
        for j in end.leaves:
            for course in corners.course(j):
                k, lands = course.flight.kept, course.lands[way]
                if k is None or (lands is not None and not lands.never):
                    continue
                start = last.xi + course.shift * last.y
                require(start.sign() == way, "a slide may turn in a fast-slide end")
                for image in corners.lift(course, k, last, start, way):
                    if isinstance(image, str):
                        found.append(image)
                        continue
                    square = image.square * larger
                    found.append(replace(image, square=square, form=None))
        return found
