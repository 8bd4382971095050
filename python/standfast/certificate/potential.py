"""The claim that no sequence of corners grows for ever: a potential over cells of ξ/y."""

from bisect import bisect_left, bisect_right
from fractions import Fraction
from itertools import pairwise
from typing import Any

from .corners import ESCAPE, REST, Cell, Corners, Image, inverse
from .ends import Attracting, End, Ends, Repelling
from .intervals import (
    ONE,
    UNIT,
    Interval,
    at_least_zero,
    exponential,
    positive,
    require,
)
from .scene import Body, entry, number, numbers
from .words import SIDES, kinematics, motion, room, words_at_rest

#: Halvings of a cell on which a step is not certain. The bound may be attained at one end, with a margin of 1e-9.
HALVINGS = 48


#: Most parts of cells that are tried. Certificates of random postures need up to 1306.
MOST_PARTS = 20_000


#: ε: the least decrease of the potential from corner to corner.
DECREASE = UNIT >> 40


class Potential:
    """Cells, and V ≥ ln G + ε + V(next) for all next cells."""

    def __init__(self, corners: Corners, data: Any) -> None:
        self.corners = corners
        self.kinds = Ends(corners)
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
        self.ends: list[dict[int, tuple[range, End] | None]] = [
            {way: self.end(j, way, ends[j][way > 0]) for way in (-1, 1)}
            for j in range(2)
        ]

    def end(self, j: int, way: int, limit: Any) -> tuple[range, End] | None:
        """The cells beyond a limit, and the kind of the fast-slide end there."""
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
        return cells, self.kinds.kind(j, way, width, name)

    def in_end(self, j: int, k: int) -> tuple[int, End] | None:
        for way, end in self.ends[j].items():
            if end is not None and k in end[0]:
                return way, end[1]
        return None

    def check(self) -> None:
        """Every cell."""
        repelling = [
            (way, end[1], min(self.values[j][k] for k in end[0]))
            for j in range(2)
            for way, end in self.ends[j].items()
            if end is not None and isinstance(end[1], Repelling)
        ]
        for j in range(2):
            for k in range(self.count):
                found = self.in_end(j, k)
                name = f"cell {k} of contact {self.corners.body.feet[j].name}"
                if found is None:
                    self.step(j, self.cell(k), self.values[j][k], None, name)
                elif isinstance(found[1], Attracting):
                    cell = self.cell(k)
                    for image in self.kinds.after(found[1], found[0], cell):
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
            repels = end is not None and isinstance(end[1], Repelling)
            same = end[0] if end is not None and repels else range(0)
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
