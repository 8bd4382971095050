"""The corner map: from corners (ξ, y) in a cell to the next ones."""

from dataclasses import dataclass, replace
from itertools import combinations

from .flights import Arc, Course, Flights
from .intervals import (
    BITS,
    ONE,
    UNIT,
    ZERO,
    Interval,
    Vector,
    cross,
    dot,
    known,
    require,
)
from .tails import falls, never_lands, not_below_zero


@dataclass(frozen=True)
class Cell:
    """Corners (ξ, y): either y = 1 and ξ between two numbers, or ξ = ±1 and y between two numbers."""

    xi: Interval
    y: Interval
    #: Ends of ξ/y; None is infinite.
    low: int | None
    high: int | None

    @staticmethod
    def between(low: int | None, high: int | None) -> "Cell":
        if low is not None and low >= UNIT:
            far = 0 if high is None else inverse(high, up=False)
            return Cell(ONE, Interval(far, inverse(low, up=True)), low, high)
        if high is not None and high <= -UNIT:
            far = 0 if low is None else inverse(-low, up=False)
            return Cell(-ONE, Interval(far, inverse(-high, up=True)), low, high)
        if low is None or high is None:
            raise ValueError("the outermost limits are not below -1 and above 1")
        return Cell(Interval(low, high), ONE, low, high)

    def halves(self) -> tuple["Cell", "Cell"]:
        """Both parts."""
        if self.xi.lo < self.xi.hi:
            middle = (self.xi.lo + self.xi.hi) >> 1
        else:
            w = (self.y.lo + self.y.hi) >> 1
            middle = self.xi.lo // abs(self.xi.lo) * inverse(w, up=False)
        return Cell.between(self.low, middle), Cell.between(middle, self.high)


def inverse(x: int, up: bool) -> int:
    """1/x in units, rounded."""
    return -(-UNIT * UNIT // x) if up else UNIT * UNIT // x


@dataclass(frozen=True)
class Corner:
    """An image: contact `contact` lands with ξ/y between low and high (None is infinite). `form`: (xx, xy, yy) of ξ'² + y'² as a quadratic
    form of (ξ, y) that bounds it; or None, and `square` bounds it."""

    contact: int
    low: int | None
    high: int | None
    square: Interval
    form: tuple[Interval, Interval, Interval] | None = None


#: The other images.
REST, ESCAPE = "rest", "escape"


Image = Corner | str


def quotient(xi: Interval, y: Interval) -> tuple[int | None, int | None]:
    """The ends of ξ/y for y ≥ 0."""
    if xi.lo == xi.hi == 0:
        return 0, 0

    def divide(x: int, near: int, far: int, up: bool) -> int | None:
        by = near if (x < 0) != up else far
        if x == 0:
            return 0
        if by <= 0:
            return None
        return -(-(x << BITS) // by) if up else (x << BITS) // by

    return divide(xi.lo, y.lo, y.hi, False), divide(xi.hi, y.lo, y.hi, True)


def with_form(image: Image, form: tuple[Interval, Interval, Interval]) -> Image:
    """The image with a bound by a quadratic form."""
    return image if isinstance(image, str) else replace(image, form=form)


def clipped(value: Interval, side: int) -> Interval | None:
    """The part of an interval with this sign; None if it is empty."""
    low, high = (
        (max(value.lo, 0), value.hi) if side > 0 else (value.lo, min(value.hi, 0))
    )
    return Interval(low, high) if low <= high else None


class Corners(Flights):
    """The corner map of a body on two contacts."""

    def both(self, way: int) -> tuple[str, bool | None]:
        """How a slide of both contacts goes on."""
        found = self.pair.continuations(way)
        if not found and self.body.resolves_jams:
            return "jams", None
        require(
            len(found) == 1 and found[0][0] != "falls",
            f"not one word goes on from the slide {self.pair.word(way)}",
        )
        return found[0]

    def images(self, j: int, cell: Cell) -> list[Image]:
        """The images of the corners of a cell at contact j. Raises ValueError where a sign is not certain."""
        found: list[Image] = []
        for course in self.course(j):
            found += self.images_of(course, cell)
        return found

    def images_of(self, course: Course, cell: Cell) -> list[Image]:
        """The images after one of the flights that may follow."""
        flight = course.flight
        if flight.away:
            return [ESCAPE]
        start = cell.xi + course.shift * cell.y
        if flight.kept is None:
            return self.together(start)
        found: list[Image] = []
        if start.sign() == 0:
            h, u = flight.h * cell.y.square(), flight.u * cell.y
            return self.turn(flight.kept, h, u, None)
        for side in (-1, 1):
            part = clipped(start, side)
            if part is not None and (part.lo < part.hi or start.sign() == side):
                found += self.after(course, flight.kept, cell, part, side)
        return found

    def after(
        self, course: Course, k: int, cell: Cell, xi: Interval, side: int
    ) -> list[Image]:
        """Contact k slides at ξ, which has this sign; the other one is in the air."""
        flight = course.flight
        jump = self.jumps[k][side]
        if jump is not None:
            return self.jam(course, k, cell, xi, side, jump)
        arc = known(
            self.slides[k][side],
            f"contact {self.body.feet[k].name} is not certainly pressed onto its ground",
        )
        slows = arc.along.times(side).sign()
        found: list[Image] = []
        lands = course.lands[side]
        if lands is not None:
            t, bend, factor = lands.t, lands.bend, lands.factor
            end = xi + arc.along * t * cell.y
            part = clipped(end, side)
            if part is not None:
                form = (ONE, bend, bend.square() + factor.square())
                low, high = quotient(part, factor * cell.y)
                if factor.lo > 0:
                    low, high = self.moved(cell, bend, factor, side)
                found.append(
                    Corner(
                        1 - k,
                        low,
                        high,
                        part.square() + (factor * cell.y).square(),
                        form,
                    )
                )
            require(slows is not None, "whether a slide slows down is not certain")
            if not lands.never and slows == -1 and end.times(side).lo <= 0:
                stop = -xi / arc.along
                stop = Interval(max(stop.lo, 0), min(stop.hi, (t * cell.y).hi))
                if stop.lo <= stop.hi:
                    found += self.stop(course, k, cell, side, arc, stop)
            if not lands.never:
                return found
        else:
            require(
                never_lands(flight.h, flight.u, arc.normal),
                "whether a contact lands during a slide is not certain",
            )
        return found + self.lift(course, k, cell, xi, side)

    def lift(
        self, course: Course, k: int, cell: Cell, xi: Interval, side: int
    ) -> list[Image]:
        """Contact k slides at ξ, which has this sign, and the other one does not land before the slide ends."""
        arc = known(
            self.slides[k][side],
            f"contact {self.body.feet[k].name} is not certainly pressed onto its ground",
        )
        slows = arc.along.times(side).sign()
        require(slows is not None, "whether a slide slows down is not certain")
        if slows != -1:
            return [ESCAPE]
        stop = -xi / arc.along
        return self.stop(course, k, cell, side, arc, Interval(max(stop.lo, 0), stop.hi))

    def moved(
        self, cell: Cell, bend: Interval, factor: Interval, side: int
    ) -> tuple[int | None, int | None]:
        """The ends of ξ'/y' = (ξ/y + B)/K, with this sign."""

        def end(x: int | None, up: bool) -> int | None:
            if x is None:
                return None
            found = Interval(x + bend.lo, x + bend.hi) / factor
            return found.hi if up else found.lo

        low, high = end(cell.low, False), end(cell.high, True)
        if side > 0:
            return 0 if low is None else max(low, 0), high
        return low, 0 if high is None else min(high, 0)

    def stop(
        self, course: Course, k: int, cell: Cell, side: int, arc: Arc, t: Interval
    ) -> list[Image]:
        """The slide of contact k has ended after the time t, at −(ξ + shift y)/along."""
        h, u, y = course.flight.h, course.flight.u, cell.y
        gap = h * y.square() + u * y * t + (arc.normal * t.square()).half()
        rate = u * y + arc.normal * t
        if gap.hi < 0:
            return []  # the other contact has landed before: that is another image
        images = self.turn(k, not_below_zero(gap, "a gap"), rate, side)
        still = self.starts[k]
        if still is None or still[0] != 0:
            return images
        # y'² = A y² + 2B yτ + C τ² with τ = p ξ + q y
        normal = still[1].normal
        less = arc.normal - normal
        a = u.square() - (normal * h).times(2)
        b, c = u * less, arc.normal * less
        p, q = -ONE / arc.along, -course.shift / arc.along
        form = (c * p.square(), (b + c * q) * p, a + (b * q).times(2) + c * q.square())
        return [with_form(image, form) for image in images]

    def jam(
        self,
        course: Course,
        k: int,
        cell: Cell,
        xi: Interval,
        side: int,
        jump: Interval,
    ) -> list[Image]:
        """Contact k, which slides at ξ + shift y, jams: it stops at once, and the gap rate of the other contact changes."""
        h, u, y = course.flight.h, course.flight.u, cell.y
        images = self.turn(k, h * y.square(), u * y + jump * xi, side)
        still = self.starts[k]
        if still is None or still[0] != 0:
            return images
        # y'² = (J ξ + r y)² − 2 a h y², r = u + J shift
        rate = u + jump * course.shift
        form = (
            jump.square(),
            jump * rate,
            rate.square() - (still[1].normal * h).times(2),
        )
        return [with_form(image, form) for image in images]

    def jam_together(self, s: Interval, side: int) -> list[Image]:
        """Both contacts slide at s, and no word goes on: what follows all impulses in the friction cones that stop both, or stop one that jams
        alone and lift the other one off."""
        found: list[Image] = []
        stops = self.stops_both(side)
        require(
            stops is not None, "whether an impact stops both contacts is not certain"
        )
        if stops:
            found.append(REST)
        for k in range(2):
            jump, name = self.jumps[k][side], self.body.feet[k].name
            if jump is None:
                require(
                    self.body.stiffness(k, self.pair.side(k, side)).lo > 0,
                    f"whether contact {name} jams is not certain",
                )
                continue
            opens = jump.times(side).sign()
            require(
                opens is not None,
                f"whether contact {self.body.feet[1 - k].name} lifts off in a jam is not certain",
            )
            if opens == 1:
                rate = not_below_zero(jump * s, "a gap rate")
                found += self.turn(k, ZERO, rate, side)
        require(bool(found), "no impact ends the jam of both contacts")
        return found

    def stops_both(self, way: int) -> bool | None:
        """Whether impulses in the friction cones stop a slide of both along `way` z; None if that is not certain.

        With the edges w = N_j + σμ_jT_j as (N_1M⁻¹w, N_2M⁻¹w, w·z), it is the question whether (0, 0, −way) is in their cone. It is, if it is a
        sum of three of them; it is not, if a plane through two of them separates it from the others."""
        body = self.body
        edges: list[Vector] = []
        for j in range(2):
            for side in (1, -1):
                w = body.rubbing(j, side)
                one, two = (body.couple(foot.normal, w) for foot in body.feet)
                edges.append((one, two, dot(w, self.pair.along)))
        target = (ZERO, ZERO, -ONE.times(way))
        for three in combinations(edges, 3):
            planes = [cross(three[(i + 1) % 3], three[(i + 2) % 3]) for i in range(3)]
            signs = {dot(three[i], plane).sign() for i, plane in enumerate(planes)}
            parts = {dot(target, plane).sign() for plane in planes}
            if len(signs) == 1 and signs == parts and signs <= {1, -1}:
                return True
        for i, j in combinations(range(4), 2):
            plane = cross(edges[i], edges[j])
            others = [dot(edges[k], plane) for k in range(4) if k not in (i, j)]
            at = dot(target, plane).sign()
            if at == 1 and all(other.hi <= 0 for other in others):
                return False
            if at == -1 and all(other.lo >= 0 for other in others):
                return False
        return None

    def turn(self, k: int, h: Interval, u: Interval, side: int | None) -> list[Image]:
        """Contact k is at rest after it slid with this sign of ξ; the other one is in the air."""
        start = known(
            self.starts[k],
            f"the motion of contact {self.body.feet[k].name} from rest is not certain",
        )
        way, arc = start
        require(
            way == 0 or way != side,
            f"contact {self.body.feet[k].name} stops and goes on in the same direction",
        )
        ends = known(falls(h, u, arc.normal), "whether a contact lands is not certain")
        found: list[Image] = [ESCAPE] if ends.never else []
        if ends.t is not None:
            xi, y = arc.along * ends.t, ends.speed
            low, high = quotient(xi, y)
            found.append(Corner(1 - k, low, high, xi.square() + y.square()))
        return found

    def together(self, s: Interval) -> list[Image]:
        """Both contacts are on the ground and slide at s."""
        found: list[Image] = [REST] if s.lo <= 0 <= s.hi else []
        for side in (-1, 1):
            part = clipped(s, side)
            if part is None or part.sign() == 0:
                continue
            what, stops = self.both(side)
            if what == "jams":
                found += self.jam_together(part, side)
                continue
            if what == "both":
                found.append(REST if stops else ESCAPE)
                continue
            k = 0 if what == "lifts 2" else 1
            arc = self.slides[k][side]
            slows = None if arc is None else arc.along.times(side).sign()
            if arc is None or slows is None:
                raise ValueError("whether a slide slows down is not certain")
            if slows != -1:
                found.append(ESCAPE)
                continue
            t = not_below_zero(-part / arc.along, "a time")
            gap = (arc.normal * t.square()).half()
            found += self.turn(k, gap, arc.normal * t, side)
        return found

    def alone(self, k: int, way: int) -> bool:
        """Whether the motion of contact k on the ground with this sign of ξ (0: from rest) ends with a landing of the other one, however
        high that one is."""
        name = self.body.feet[k].name
        still = known(
            self.starts[k], f"the motion of contact {name} from rest is not certain"
        )
        back = still[1].normal.sign()
        if way == 0:
            require(
                back is not None,
                f"whether contact {self.body.feet[1 - k].name} comes down is not certain",
            )
            return back == -1
        if self.jumps[k][way] is not None:
            return self.alone(k, 0)  # it stops at once
        arc = known(
            self.slides[k][way],
            f"contact {name} is not certainly pressed onto its ground",
        )
        down, along = arc.normal.sign(), arc.along.times(way).sign()
        if down == -1:
            return True
        require(
            down is not None,
            f"whether contact {self.body.feet[1 - k].name} comes down during a slide is not certain",
        )
        require(
            along is not None,
            f"whether the slide of contact {name} slows down is not certain",
        )
        if along == -1:
            require(
                back is not None,
                f"whether contact {self.body.feet[1 - k].name} comes down is not certain",
            )
            return back == -1
        return False
