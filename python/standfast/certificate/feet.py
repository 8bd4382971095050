"""Claims on any number of contacts: no motion exists; the rays along which the body rises or descends."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from .intervals import (
    ONE,
    Interval,
    Vector,
    cross,
    dot,
    negative,
    plus,
    positive,
    require,
    scaled,
)
from .scene import Body, direction, entry, number, without_carried
from .words import SIDES, Pair


def slides_of(data: Any, body: Body) -> list[tuple[int, int]]:
    """The contacts that slide, by their places, and their directions."""
    places = body.places(entry(data, "contacts", "data"))
    ways = entry(data, "slides", "data")
    require(
        isinstance(ways, str) and len(ways) == len(places) and set(ways) <= set(SIDES),
        f"data.slides {ways!r} has no letter R or L for each contact",
    )
    return [(i, SIDES[way]) for i, way in zip(places, ways, strict=True)]


def no_solution(body: Body, data: Any) -> None:
    """No motion exists from a start in which these contacts slide.

    One contact i: k_i^σ < 0 < g_i, and a displacement closes contact i only. It is q less its part along M⁻¹N_i.
    Two contacts: no word goes on from their slide (see `Pair.continuations`), and the displacement along z opens all others.
    """
    require(not body.resolves_jams, "an impact ends a jam")
    body, _ = without_carried(body)
    slides = slides_of(data, body)
    speed = direction(body, data, "qdot")
    for i, side in slides:
        name = body.feet[i].name
        positive(
            dot(body.feet[i].tangent, speed).times(side), f"σ v_t of contact {name}"
        )
    if len(slides) == 1:
        [(i, side)] = slides
        foot = body.feet[i]
        negative(body.stiffness(i, side), f"k of contact {foot.name}")
        positive(body.pull(i), f"g of contact {foot.name}")
        place = direction(body, data, "q")
        back = dot(foot.normal, place) / body.couple(foot.normal, foot.normal)
        place = plus(place, scaled(body.over_mass(foot.normal), -back))
        for k, other in enumerate(body.feet):
            if k != i:
                positive(dot(other.normal, place), f"the gap of contact {other.name}")
        return
    require(len(slides) == 2, "data.contacts are not one or two contacts")
    slides.sort()
    pair = Pair(body.part([body.feet[i].name for i, _ in slides]))
    sides = [side for _, side in slides]
    ways = [way for way in (1, -1) if [pair.side(k, way) for k in range(2)] == sides]
    require(bool(ways), "the contacts do not slide together in these directions")
    require(
        not pair.continuations(ways[0]),
        "a word goes on from the slide of both contacts",
    )
    if len(body.feet) > 2:
        opens = [
            dot(foot.normal, pair.along).sign()
            for k, foot in enumerate(body.feet)
            if k not in [i for i, _ in slides]
        ]
        require(
            opens in ([1] * len(opens), [-1] * len(opens)),
            "the two contacts do not stay closed while all others open",
        )


@dataclass(frozen=True)
class Ray:
    """A direction that keeps two contacts closed, by their places, and opens all others."""

    pair: tuple[int, int]
    direction: Vector
    rise: int | None


def mirrored(body: Body, i: int, j: int) -> bool:
    """Whether two contacts are mirror images in the vertical line through the centre of mass."""
    one, two = body.feet[i], body.feet[j]
    exact = Fraction(one.point[0]) + Fraction(two.point[0])
    return (
        exact == 2 * Fraction(body.center[0])
        and one.point[1] == two.point[1]
        and one.slope == -two.slope
        and one.point[0] != two.point[0]
    )


def rays(body: Body, data: Any) -> list[Ray]:
    """The extreme rays of {q : N q ≥ 0}, which have to be those of the certificate.

    A pair whose crossing opens all other contacts is a ray, and the cone then has an interior and no line in it. The rays of such a cone are
    one cycle, in which each contact that has rays has two. So rays that leave no contact with one ray are all rays.
    """
    stated = entry(data, "rays", "data")
    require(isinstance(stated, list) and bool(stated), "data.rays is empty")
    found = []
    for pair in stated:
        places = body.places(pair)
        require(len(places) == 2, f"{pair!r} of data.rays is no pair of contacts")
        i, j = places
        z = cross(body.feet[i].normal, body.feet[j].normal)
        opens = [
            dot(foot.normal, z).sign()
            for k, foot in enumerate(body.feet)
            if k not in (i, j)
        ]
        names = f"contacts {body.feet[i].name} and {body.feet[j].name}"
        require(
            bool(opens) and opens in ([1] * len(opens), [-1] * len(opens)),
            f"that {names} leave all others open is not certain",
        )
        z = scaled(z, ONE.times(opens[0] or 0))
        rise = 0 if mirrored(body, i, j) else z[1].sign()
        require(
            rise is not None, f"the sign of y along the ray of {names} is not certain"
        )
        found.append(Ray((i, j), z, rise))
    require(
        len({frozenset(ray.pair) for ray in found}) == len(found),
        "data.rays has a pair twice",
    )
    for i, count in Counter(i for ray in found for i in ray.pair).items():
        require(
            count == 2,
            f"data.rays has only one of the two rays of contact {body.feet[i].name}",
        )
    return found


def moves_on(body: Body, found: Sequence[Ray]) -> None:
    """From every state a motion exists: no exposed contact jams while it slides alone, and no pair while it slides along its ray; or an
    impact ends a jam, which loses energy."""
    if body.resolves_jams:
        return
    for i in sorted({i for ray in found for i in ray.pair}):
        if body.pull(i).hi > 0:
            for way, side in SIDES.items():
                positive(
                    body.stiffness(i, side), f"k of contact {body.feet[i].name}, {way}"
                )
    for ray in found:
        goes_on(Pair(body.part([body.feet[k].name for k in ray.pair])))


def goes_on(pair: Pair) -> None:
    """A motion goes on from each slide of both contacts. With A = N M⁻¹(N − σμT)ᵀ it is a solution of a = Aλ − g ≥ 0 ⊥ λ ≥ 0, and there is one
    for every g if both entries of the diagonal of A and its determinant are positive."""
    body = pair.body
    names = [foot.name for foot in body.feet]
    for way in (1, -1):
        columns = [body.rubbing(i, pair.side(i, way)) for i in range(2)]
        [[a, b], [c, d]] = [
            [body.couple(foot.normal, column) for column in columns]
            for foot in body.feet
        ]
        if min(a.lo, d.lo, (a * d - b * c).lo) > 0:
            continue
        require(
            bool(pair.continuations(way)),
            f"contacts {names} jam while both slide ({pair.word(way)})",
        )


def well(body: Body, data: Any) -> None:
    """All rays ascend, by at least w times their largest component, and a motion always exists."""
    body, _ = without_carried(body)
    found = rays(body, data)
    width = Interval.of(Fraction(number(entry(data, "width", "data"), "data.width")))
    positive(width, "data.width")
    for ray in found:
        x, y, turn = ray.direction
        name = f"the ray of contacts {[body.feet[k].name for k in ray.pair]}"
        for part, of in (
            (x, "x"),
            (-x, "x"),
            (y, "y"),
            (turn * body.rho, "ρθ"),
            (-turn * body.rho, "ρθ"),
        ):
            rest = y - width * part
            require(
                rest.lo >= 0,
                f"y - w|{of}| of {name} is not certainly at least 0: {rest}",
            )
        positive(y, f"y of {name}")
    moves_on(body, found)


def descending_pair(body: Body, data: Any, claimed: Callable[[Body, Any], str]) -> str:
    """One ray does not ascend, and its pair decides; or the pairs of all rays that descend do not hold the body. `claimed` checks the claim
    on a pair as the only contacts. On one line of ground the outer contacts are the pair, and there is no ray."""
    body, lines = without_carried(body)

    def part(names: list[int]) -> Body:
        one, two = names
        return replace(body.part(names), between=tuple(lines.get((one, two), [])))

    if len(body.feet) == 2 and lines and entry(data, "rays", "data") == []:
        outer = [foot.name for foot in body.feet]
        pairs = entry(data, "pairs", "data")
        require(
            isinstance(pairs, list) and len(pairs) == 1,
            "data.pairs is not one pair",
        )
        return claimed(part(outer), pairs[0])
    found = rays(body, data)
    core = [ray for ray in found if ray.rise != 1]
    pairs = entry(data, "pairs", "data")
    require(isinstance(pairs, list), "data.pairs is not a list")
    names = [[body.feet[k].name for k in ray.pair] for ray in core]
    stated = [
        entry(entry(pair, "claim", "pair"), "contacts", "claim") for pair in pairs
    ]
    require(
        stated == names,
        f"data.pairs are {stated!r}, the pairs of the rays that do not ascend are {names!r}",
    )
    require(bool(core), "all rays ascend")
    require(
        len(core) == 1
        or all(pair["claim"].get("by") == "not-equilibrium" for pair in pairs),
        "several pairs descend, and one of them may hold the body",
    )
    verdicts = []
    for pair in pairs:
        claim = entry(pair, "claim", "pair")
        verdicts.append(claimed(part(claim["contacts"]), pair))
    if len(core) == 1 and verdicts[0] == "stable":
        moves_on(body, found)
        return "stable"
    require(all(ray.rise == -1 for ray in core), "a ray is level")
    return "unstable"


def neutral(body: Body, data: Any) -> None:
    """Level ground, or two contacts that are mirror images: λ > 0 on the outer contacts, friction at all; k > 0, and a slide of both goes on; or
    impacts end jams."""
    outer = body.places(entry(data, "outer", "data"))
    require(len(outer) == 2, "data.outer are not two contacts")
    if not (len(body.feet) == 2 and mirrored(body, 0, 1)):
        x = [foot.point[0] for foot in body.feet]
        require(all(foot.slope == 0 for foot in body.feet), "the ground is not level")
        low, high = x[outer[0]], x[outer[1]]
        require(
            low < high
            and all(low < x[k] < high for k in range(len(x)) if k not in outer),
            "data.outer are not the outer contacts",
        )
    for foot in body.feet:
        positive(foot.friction, f"the friction of contact {foot.name}")
    if not body.resolves_jams:
        for i in outer:
            for way, side in SIDES.items():
                positive(
                    body.stiffness(i, side), f"k of contact {body.feet[i].name}, {way}"
                )
    pair = Pair(body.part(sorted(body.feet[i].name for i in outer)))
    for foot, weight in zip(pair.body.feet, pair.weights, strict=True):
        positive(weight, f"λ of contact {foot.name}")
    if not body.resolves_jams:
        goes_on(pair)
