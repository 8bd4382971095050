"""Claims that the body moves away: a cycle of corners that grows, a corner, a motion."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .corners import ESCAPE, REST, Cell, Corners, Image
from .ends import Attracting, Ends
from .intervals import ONE, UNIT, ZERO, Interval, dot, exponential, require
from .potential import DECREASE, MOST_PARTS
from .rest import word_at_rest
from .scene import Body, direction, entry, number
from .words import SIDES

#: Halvings of a range.
HALVINGS = 40


#: Half-widths of the interval around a cycle, as powers of two, relative to 1 + σ².
AROUND = (33, 27, 20)


def corner_of(body: Body, data: Any, corners: Corners) -> tuple[int, Interval]:
    """The contact that lands, and ξ/y = v_t,i/(α_i y) from v_t,i/y."""
    [j] = body.places([entry(data, "contact", "corner")])
    slope = number(entry(data, "slope", "corner"), "corner.slope")
    return j, Interval.of(Fraction(slope)) / corners.alpha[1 - j]


def growing_cycle(body: Body, data: Any) -> None:
    """The map once around has a fixed point in an interval of ξ/y around a cycle, and r grows on all of that interval.

    With one image at every corner the map is continuous on the interval; its two ends are moved in opposite directions."""
    corners = Corners(body)
    listed = entry(data, "corners", "data")
    require(isinstance(listed, list) and bool(listed), "data.corners is empty")
    cycle = [corner_of(body, corner, corners) for corner in listed]
    first = next((n for n, (_, at) in enumerate(cycle) if at.sign() == 0), 0)
    cycle = cycle[first:] + cycle[:first]
    start, center = cycle[0]

    def around(at: Interval) -> tuple[Interval, Interval]:
        """Once around, from an interval of ξ/y: the image, and the growth of r²."""
        j, growth = start, ONE
        for n, (contact, _) in enumerate(cycle):
            name = f"corner {n + 1} of the cycle"
            require(j == contact, f"{name} is not at contact {body.feet[contact].name}")
            cell = Cell.between(at.lo, at.hi)
            images = corners.images(j, cell)
            image = images[0] if len(images) == 1 else REST
            if isinstance(image, str):
                raise ValueError(f"{name} has not exactly one corner as its image")
            require(
                image.low is not None and image.high is not None,
                f"{name}: its image may have y = 0",
            )
            growth = growth * image.square / (cell.xi.square() + cell.y.square())
            j, at = image.contact, Interval(image.low or 0, image.high or 0)
        require(j == start, "the cycle does not come back to its first contact")
        return at, growth

    if center.sign() == 0:
        image, growth = around(ZERO)
        require(image.sign() == 0, "the cycle does not come back to its first corner")
        require(
            growth.lo > UNIT,
            f"the growth of r² once around is not certainly above 1: {growth}",
        )
        return
    problem = ""
    for bits in AROUND:
        try:
            size = (UNIT + center.square().hi) >> bits
            wide = Interval(center.lo - size, center.hi + size)
            _, growth = around(wide)
            require(
                growth.lo > UNIT,
                f"the growth of r² once around is not certainly above 1: {growth}",
            )
            moves = []
            for end in (wide.lo, wide.hi):
                point = Interval(end, end)
                moves.append((around(point)[0] - point).sign())
            require(
                sorted(move or 0 for move in moves) == [-1, 1],
                "the map does not move the ends of the interval in opposite directions",
            )
            return
        except ValueError as error:
            problem = str(error)
    raise ValueError(problem)


@dataclass(frozen=True)
class Range:
    """Corners of a trap at a contact: the ends of ξ/y (None is infinite), and W."""

    contact: int
    low: int | None
    high: int | None
    weight: int


def growing_trap(body: Body, data: Any) -> None:
    """Every image of a corner in one of the ranges is a corner in a range, or moves away for ever, and W(range) + ε ≤ ln G + W(next)."""
    corners = Corners(body)
    listed = entry(data, "ranges", "data")
    require(isinstance(listed, list) and bool(listed), "data.ranges is empty")
    ranges = [
        range_of(body, item, f"data.ranges[{k}]") for k, item in enumerate(listed)
    ]
    trap = Trap(corners, ranges)
    for k, own in enumerate(ranges):
        trap.step(own, Cell.between(own.low, own.high), f"range {k + 1}")


def range_of(body: Body, data: Any, name: str) -> Range:
    [j] = body.places([entry(data, "contact", name)])
    ends = entry(data, "slope", name)
    require(isinstance(ends, list) and len(ends) == 2, f"{name}.slope is no pair")
    low, high = (
        None if end == infinite else Interval.of(Fraction(number(end, f"{name}.slope")))
        for end, infinite in zip(ends, ("-inf", "inf"), strict=True)
    )
    weight = Interval.of(
        Fraction(number(entry(data, "weight", name), f"{name}.weight"))
    )
    return Range(
        j,
        None if low is None else low.lo,
        None if high is None else high.hi,
        weight.hi,
    )


class Trap:
    """Ranges of corners that no motion leaves."""

    def __init__(self, corners: Corners, ranges: list[Range]) -> None:
        self.corners = corners
        self.ends = Ends(corners)
        self.ranges = ranges
        self.parts = 0

    def step(self, own: Range, cell: Cell, name: str, left: int = HALVINGS) -> None:
        """All images of a cell grow. A cell of which this is not certain is halved."""
        self.parts += 1
        require(
            self.parts <= MOST_PARTS,
            f"the ranges have to be cut into more than {MOST_PARTS} parts",
        )
        problem = ""
        for images in (self.plain, self.in_end):
            try:
                found = images(own.contact, cell)
                if found and all(
                    self.grows(image, cell, own.weight) for image in found
                ):
                    return
            except ValueError as error:
                problem = f": {error}"
        require(
            left > 0,
            f"{name} is not certainly left for a range that is larger{problem}",
        )
        for half in cell.halves():
            self.step(own, half, name, left - 1)

    def plain(self, j: int, cell: Cell) -> list[Image]:
        return self.corners.images(j, cell)

    def in_end(self, j: int, cell: Cell) -> list[Image]:
        """What follows all corners of a fast slide that begins in the cell."""
        require(cell.xi.lo == cell.xi.hi, "the cell is not near a fast-slide end")
        way = 1 if cell.xi.lo > 0 else -1
        end = self.ends.kind(j, way, cell.y.hi, "the fast-slide end")
        if not isinstance(end, Attracting):
            raise ValueError("the corners leave the fast-slide end")
        return self.ends.after(end, way, cell)

    def grows(self, image: Image, cell: Cell, weight: int) -> bool:
        if isinstance(image, str):
            return image == ESCAPE
        before = (cell.xi.square() + cell.y.square()).hi
        for other in self.ranges:
            inside = (
                other.contact == image.contact
                and not below(image.low, other.low, -1)
                and not below(other.high, image.high, 1)
            )
            # G² ≥ e^(2(W − W' + ε)), and e^x ≤ 1/(a lower bound of e^−x)
            least = exponential(2 * (other.weight - weight - DECREASE))
            if inside and image.square.lo * least >= before * UNIT:
                return True
        return False


def below(one: int | None, two: int | None, infinite: int) -> bool:
    """one < two, where None is ∞ with this sign."""
    if one is None or two is None:
        return one is not two and (one is None) == (infinite < 0)
    return one < two


def moves_away(body: Body, data: Any) -> None:
    """A motion with contacts on the ground goes on for ever, or ends in one that does; or every image of a corner does."""
    corners = Corners(body)
    if "corner" in data:
        j, at = corner_of(body, data["corner"], corners)
        images = corners.images(j, Cell.between(at.lo, at.hi))
        require(
            images == [ESCAPE], "the body does not certainly move away after the corner"
        )
        return
    word, velocity = entry(data, "word", "data"), direction(body, data, "velocity")
    slips = [dot(foot.tangent, velocity).sign() for foot in body.feet]
    slide = next(
        (w for w in (1, -1) if slips == [corners.pair.side(k, w) for k in range(2)]), 0
    )
    if slide and word == corners.pair.word(slide):
        require(
            corners.both(slide) == ("both", False),
            f"the slide {word} does not certainly go on for ever",
        )
        return
    require(
        word in ("SF", "SR", "SL", "FS", "RS", "LS"), f"data.word {word!r} is no motion"
    )
    m = word.index("S")
    k, name = 1 - m, body.feet[m].name
    if dot(body.feet[m].normal, velocity).lo > UNIT >> 20:
        side = SIDES.get(word[k], 0)
        require(side in (0, slips[k]), f"data.velocity does not slide as {word}")
        way = side if corners.alpha[k].lo > 0 else -side
        require(not corners.alone(k, way), f"contact {name} comes down in {word}")
        return
    require(slide != 0, "data.velocity is no slide of both contacts")
    require(
        corners.both(slide) == (f"lifts {m + 1}", None),
        f"the slide of both does not go on as {word}",
    )
    require(
        corners.together(ONE.times(slide)) == [ESCAPE],
        f"the body does not certainly move away in {word}",
    )


def accelerating_mode(body: Body, data: Any) -> None:
    """The body moves away: in a word at rest, after a corner, or from a velocity."""
    if isinstance(data, dict) and ("corner" in data or "velocity" in data):
        moves_away(body, data)
    else:
        word_at_rest(body, data)
