"""The claim that no sequence of corners grows for ever: a potential over cells of ξ/y."""

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from .corners import ESCAPE, REST, Cell, Corners, Image, inverse
from .intervals import (
    ONE,
    UNIT,
    ZERO,
    Interval,
    at_least_zero,
    exponential,
    logarithm,
    positive,
    require,
)
from .scene import Body, entry, number, numbers
from .words import SIDES, kinematics, motion, room, words_at_rest

#: Halvings of a cell on which a step is not certain. The bound may be attained at one end, with a margin of 1e-9.
HALVINGS = 48


#: Most parts of cells that are tried. Certificates of random postures need up to 1306.
MOST_PARTS = 20_000


#: Rounds in which the sum of the landing speeds in a fast-slide end is found.
SUM_ROUNDS = 64


#: ε: the least decrease of the potential from corner to corner.
DECREASE = UNIT >> 40


@dataclass(frozen=True)
class Repelling:
    """The cells of a fast-slide end that the corners leave, and a bound of the growth ln r until then."""

    cells: range
    transit: int


@dataclass(frozen=True)
class Attracting:
    """The cells of a fast-slide end in which both contacts finally slide together. With ξ = ±1 and w = y at the first corner: |ξ| is finally
    1 + limit w, and until then 1 + w times a number between 0 and `change`; y grows at most by `stretch` on the way. `leaves`: the contacts
    whose corners may also leave the end, because the other contact lifts off."""

    cells: range
    limit: Interval
    change: Interval
    stretch: Interval
    leaves: list[int]


End = Repelling | Attracting


class Potential:
    """Cells, and V ≥ ln G + ε + V(next) for all next cells."""

    def __init__(self, corners: Corners, data: Any) -> None:
        self.corners = corners
        self.parts = 0
        limits = entry(data, "limits", "data")
        require(
            isinstance(limits, list) and len(limits) > 1,
            "data.limits are not two or more numbers",
        )
        exact = [
            Interval.of(Fraction(x))
            for x in numbers(limits, len(limits), "data.limits")
        ]
        self.limits: list[int] = [x.lo for x in exact]
        require(
            all(x.lo == x.hi for x in exact),
            "data.limits has a number that is not a multiple of 2^-256",
        )
        require(
            all(a < b for a, b in pairwise(self.limits)),
            "data.limits are not increasing",
        )
        self.count: int = len(limits) + 1
        values = entry(data, "potential", "data")
        require(
            isinstance(values, list) and len(values) == 2,
            "data.potential is not two lists",
        )
        self.values: list[list[int]] = [
            [
                Interval.of(Fraction(v)).lo
                for v in numbers(part, self.count, f"data.potential[{j}]")
            ]
            for j, part in enumerate(values)
        ]
        require(
            min(min(part) for part in self.values) >= 0,
            "data.potential has a negative number",
        )
        ends = entry(data, "ends", "data")
        require(
            isinstance(ends, list)
            and len(ends) == 2
            and all(isinstance(pair, list) and len(pair) == 2 for pair in ends),
            "data.ends is not two pairs",
        )
        self.ends: list[dict[int, End | None]] = [
            {way: self.end(j, way, ends[j][way > 0]) for way in (-1, 1)}
            for j in range(2)
        ]

    def end(self, j: int, way: int, limit: Any) -> End | None:
        """The fast-slide end beyond a limit. There contact k stays on the ground, and ξ' = ξ + B y, y' = K y at each corner."""
        if limit is None:
            return None
        name = f"data.ends[{j}][{int(way > 0)}]"
        where = Interval.of(Fraction(number(limit, name))).lo
        require(
            where in self.limits and where * way > UNIT,
            f"{name} is not a limit above 1 or below -1",
        )
        place = self.limits.index(where)
        cells = range(place + 1, self.count) if way > 0 else range(place + 1)
        width = inverse(abs(where), up=True)
        own = self.fast(j, way)
        if len(own) == 1:
            [one] = own
            back = own if one.then == j else self.fast(one.then, way)
            if len(back) == 1 and back[0].then == j and self.certain(j, one.then):
                return fast_end(one, back[0], cells, width, name)
        return self.several(j, way, cells, width, name)

    def certain(self, *contacts: int) -> bool:
        """Whether one course follows the corners at each of these contacts."""
        return all(len(self.corners.course(j)) == 1 for j in contacts)

    def fast(self, j: int, way: int) -> list["Fast"]:
        """The corners that may follow at a fast-slide end."""
        found = []
        for course in self.corners.course(j):
            lands = course.lands[way]
            require(
                not course.flight.away, f"the body may move away at contact {j + 1}"
            )
            if course.flight.kept is not None and lands is not None:
                shift, bend = course.shift.times(way), lands.bend.times(way)
                found.append(Fast(1 - course.flight.kept, shift, bend, lands.factor))
        return found

    def several(
        self, j: int, way: int, cells: range, width: int, name: str
    ) -> Attracting:
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
        return Attracting(cells, change, change, Interval(stretch, stretch), reached)

    def after_end(self, end: Attracting, way: int, cell: Cell) -> list[Image]:
        """What follows the corners of a cell of an attracting end."""
        corners, w = self.corners, cell.y
        found = corners.together((ONE + w * end.limit).times(way))
        reach = ONE + w * Interval(min(end.change.lo, 0), max(end.change.hi, 0))
        positive(reach, "ξ during the slides")
        wide = (Interval(w.hi, w.hi) * end.stretch / reach).hi
        last = Cell(ONE.times(way), Interval(0, wide), None, None)
        larger = Interval(reach.hi, reach.hi).square()
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

    def in_end(self, j: int, k: int) -> tuple[int, End] | None:
        for way, end in self.ends[j].items():
            if end is not None and k in end.cells:
                return way, end
        return None

    def check(self) -> None:
        """Every cell."""
        repelling = [
            (way, end, min(self.values[j][k] for k in end.cells))
            for j in range(2)
            for way, end in self.ends[j].items()
            if isinstance(end, Repelling)
        ]
        for j in range(2):
            for k in range(self.count):
                found = self.in_end(j, k)
                name = f"cell {k} of contact {self.corners.body.feet[j].name}"
                if found is None:
                    self.step(j, self.cell(k), self.values[j][k], None, name)
                elif isinstance(found[1], Attracting):
                    cell = self.cell(k)
                    for image in self.after_end(found[1], found[0], cell):
                        require(
                            self.falls(image, cell, self.values[j][k], None),
                            f"the potential of {name} is too small, or the body moves away",
                        )
                else:
                    # The end may be left from any of its cells, at either contact.
                    way = found[0]
                    least = min(value for other, _, value in repelling if other == way)
                    transit = max(
                        end.transit for other, end, _ in repelling if other == way
                    )
                    self.step(j, self.cell(k), least - transit, way, name)

    def cell(self, k: int) -> Cell:
        low = None if k == 0 else self.limits[k - 1]
        return Cell.between(low, None if k == self.count - 1 else self.limits[k])

    def step(
        self,
        j: int,
        cell: Cell,
        value: int,
        inside: int | None,
        name: str,
        left: int = HALVINGS,
    ) -> None:
        """All images of a cell have a smaller potential. A cell of which this is not certain is halved."""
        self.parts += 1
        require(
            self.parts <= MOST_PARTS,
            f"the cells have to be cut into more than {MOST_PARTS} parts",
        )
        try:
            images = self.corners.images(j, cell)
            holds, problem = (
                all(self.falls(image, cell, value, inside) for image in images),
                "",
            )
        except ValueError as error:
            holds, problem = False, f": {error}"
        if holds:
            return
        require(
            left > 0, f"the potential of {name} is not certainly large enough{problem}"
        )
        for half in cell.halves():
            self.step(j, half, value, inside, name, left - 1)

    def falls(self, image: Image, cell: Cell, value: int, inside: int | None) -> bool:
        """Whether V ≥ ln G + ε + V' for an image of a cell. Cells of the repelling end `inside` are left out."""
        if isinstance(image, str):
            return image == REST
        low = 0 if image.low is None else bisect_left(self.limits, image.low)
        high = (
            self.count - 1
            if image.high is None
            else bisect_right(self.limits, image.high)
        )
        values = self.values[image.contact]
        if inside is None:
            most = max(values[low : high + 1])
        else:
            end = self.ends[image.contact][inside]
            same = end.cells if isinstance(end, Repelling) else range(0)
            outside = [values[k] for k in range(low, high + 1) if k not in same]
            if not outside:
                return True
            most = max(outside)
        # G² ≤ e^(2(V − V' − ε))
        bound = exponential(2 * (value - most - DECREASE))
        factor = Interval(bound, bound)
        if image.form is not None:
            xx, xy, yy = image.form
            a, b, c = factor - xx, -xy.times(2), factor - yy
            if cell.y.lo == cell.y.hi:
                certain = at_least_zero(a, b, c, cell.xi.lo, cell.xi.hi)
            else:
                certain = at_least_zero(c, b * cell.xi, a, cell.y.lo, cell.y.hi)
            if certain:
                return True
        before = cell.xi.square() + cell.y.square()
        return image.square.hi <= (factor * before).lo


@dataclass(frozen=True)
class Fast:
    """A corner of a fast slide, with ξ > 0: the contact that lands next, and A, B, K. The slide begins at ξ + A y and ends at ξ' = ξ + B y
    with a landing, y' = K y."""

    then: int
    shift: Interval
    bend: Interval
    factor: Interval


def fast_end(one: Fast, two: Fast, cells: range, width: int, name: str) -> End:
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
        return Attracting(cells, -x, ZERO, ONE, [])
    require(kappa.lo > UNIT, f"{name}: whether y grows is not certain")
    steep = Interval(max(x.hi, 0), max(x.hi, 0))
    left = ONE - steep * wide
    positive(left, f"{name}: 1 - xw")
    half = (ONE + one.bend * wide).square() + (one.factor * wide).square()
    square = max((ONE + wide.square()).hi, half.hi)
    growth = Interval(square, square) / left.square()
    return Repelling(cells, -(-logarithm(growth.hi) >> 1))


def keeps_on(corner: Fast, wide: Interval, name: str) -> None:
    """The slide after a corner does not turn."""
    positive(ONE + corner.shift * wide, f"{name}: ξ at the start of a slide")
    positive(ONE + corner.bend * wide, f"{name}: ξ at the end of a slide")


def corner_map(body: Body, data: Any) -> None:
    """No sequence of corners grows for ever: a potential V ≥ 0 falls by ln G + ε from each corner to the next one.

    Before that: only the body at rest is consistent at rest; no contact jams while it slides alone, or an impact ends the jam; every motion with one contact on the
    ground ends with a landing of the other; one word goes on from each slide of both, and the body does not move away in it; flights end."""
    corners = Corners(body)
    pair = corners.pair
    for word in words_at_rest(pair):
        found = motion(body, word)
        fails = [value.hi <= 0 for _, value in kinematics(body, found, word)]
        for i, letter in enumerate(word):
            fails.append(found.forces[i][1].hi < 0)
            fails += [part.hi < 0 for part in room(body, found, i) if letter == "F"]
        require(any(fails), f"the word {word} may be consistent at rest")
    for i in range(2):
        for letter, side in SIDES.items():
            if not (body.resolves_jams and body.jams(i, side)):
                positive(
                    body.stiffness(i, side),
                    f"k of contact {body.feet[i].name}, {letter}",
                )
    for k in range(2):
        for way in (0, 1, -1):
            require(
                corners.leaves_alone(k) or corners.alone(k, way),
                f"contact {body.feet[1 - k].name} may move away while the other one is on the ground",
            )
    for way in (1, -1):
        require(
            ESCAPE not in corners.together(ONE.times(way)),
            f"the body moves away in the slide {pair.word(way)}",
        )
    energy = all(weight.lo > 0 for weight in pair.weights)
    drift = all(psi.hi <= 0 for psi in pair.psi) and any(
        pair.weights[j].hi < 0 < corners.g[1 - j].lo for j in range(2)
    )
    require(energy or drift, "neither energy nor drift certainly ends the flights")
    Potential(corners, data).check()
