"""Claims that are decided by the words at rest: no equilibrium, an accelerating mode, Theorem 3, Goyal's bound."""

from fractions import Fraction
from typing import Any

from .intervals import ONE, Interval, dot, positive, require
from .scene import Body, entry, numbers
from .words import Pair, kinematics, motion, room, words_at_rest


def not_equilibrium(body: Body, data: Any) -> None:
    """No forces in the friction cones balance gravity: y separates them, y·(N_i ± μ_iT_i) ≥ 0 for all i and y·e_y < 0 (Farkas)."""
    first, second, third = numbers(entry(data, "separates", "data"), 3, "separates")
    require(second < 0, "separates[1] is not negative")
    y = [
        Interval.of(Fraction(first)),
        Interval.of(Fraction(second)),
        Interval.of(Fraction(third) * body.size),
    ]
    for i, foot in enumerate(body.feet):
        for side, name in ((-1, "n + μt"), (1, "n - μt")):
            work = dot(body.rubbing(i, side), y)
            require(
                work.lo >= 0,
                f"y·w of the edge {name} of contact {foot.name} is not certainly at least 0: {work}",
            )


def word_at_rest(body: Body, data: Any) -> None:
    """A word at rest is consistent and moves the body: q = ½q̈t² is a motion for ever."""
    word = entry(data, "word", "data")
    require(
        isinstance(word, str)
        and len(word) == len(body.feet)
        and set(word) <= set("SFRL"),
        f"data.word {word!r} has no letter S, F, R or L for each contact",
    )
    found = motion(body, word)
    for i, letter in enumerate(word):
        if letter == "F":
            for part in room(body, found, i):
                require(
                    part.lo >= 0,
                    f"the force of contact {body.feet[i].name} is not certainly in its friction cone: {part}",
                )
        if letter != "S":
            normal = found.forces[i][1]
            require(
                normal.lo >= 0,
                f"the normal force of contact {body.feet[i].name} is not certainly at least 0: {normal}",
            )
    tests = kinematics(body, found, word)
    require(bool(tests), f"the word {word} does not move")
    for name, value in tests:
        positive(value, name)


def kinematic_strong(pair: Pair, strict: bool) -> None:
    """Every word that moves has positive normal forces and violates a strict kinematic inequality."""
    body = pair.body
    for word in words_at_rest(pair):
        found = motion(body, word)
        for i, letter in enumerate(word):
            if letter != "S":
                positive(
                    found.forces[i][1],
                    f"the normal force of contact {body.feet[i].name} in the word {word}",
                )
            if letter == "F" and strict:
                for part in room(body, found, i):
                    positive(
                        part,
                        f"the distance from the edge of the friction cone of contact {body.feet[i].name} in the word {word}",
                    )
        require(
            any(value.hi < 0 for _, value in kinematics(body, found, word)),
            f"no kinematic inequality of the word {word} is certainly violated",
        )


def strong(body: Body, strict: bool) -> tuple[Interval, list[Interval]]:
    """What Theorem 3 and the theorem with Goyal's bound have in common; p_1p_2 and the restitutions.

    Kinematic-strong; one word goes on from each slide of both contacts; λ > 0; ψ_1, ψ_2 > 0."""
    require(len(body.feet) == 2, "the body does not stand on two contacts")
    require(not body.between, "the bound is one for two contacts alone")
    pair = Pair(body)
    kinematic_strong(pair, strict)
    for way in (1, -1):
        found = pair.continuations(way)
        require(
            len(found) == 1 and found[0][0] != "falls",
            f"not one word goes on from the slide {pair.word(way)}",
        )
    for foot, weight, psi in zip(body.feet, pair.weights, pair.psi, strict=True):
        positive(weight, f"λ of contact {foot.name}")
        positive(psi, f"ψ of contact {foot.name}")
    e = [foot.restitution for foot in body.feet]
    p = [(ONE + e[i]) * pair.psi[i] for i in range(2)]
    return p[0] * p[1], e


def theorem_3(body: Body, data: Any, strict: bool = True) -> None:
    """Kinematic-strong, and (10): Λ₊³ > e_1e_2 with Λ₊ the larger root of Λ² − PΛ + e_1e_2, P = p_1p_2 − e_1 − e_2, p_i = (1+e_i)ψ_i."""
    product, e = strong(body, strict)
    trace, both = product - e[0] - e[1], e[0] * e[1]
    positive(trace, "P = p_1p_2 - e_1 - e_2")
    root = trace.square() - both.times(4)
    require(root.lo >= 0, f"P² - 4e_1e_2 is not certainly at least 0: {root}")
    large = (trace + root.sqrt()).half()
    positive(large.square() * large - both, "Λ³ - e_1e_2 of the bound (10)")


def theorem_3_loose(body: Body, data: Any) -> None:
    """As `theorem_3`, without the friction cone of fixed contacts."""
    theorem_3(body, data, strict=False)


def goyal(body: Body, data: Any) -> None:
    """Kinematic-strong, and Goyal's bound: p_1p_2 ≥ (√e_1 + √e_2)²."""
    product, e = strong(body, strict=False)
    room = product - (e[0].sqrt() + e[1].sqrt()).square()
    require(
        room.lo >= 0, f"p_1p_2 - (√e_1 + √e_2)² is not certainly at least 0: {room}"
    )


def single_support(body: Body, _data: Any) -> None:
    """One contact does not hold a body against a turn about it. With its arm (x, y), the velocity (−y, x, −1) moves neither the contact along its
    ground nor off it. If the centre of mass is straight above the contact, this motion neither rises nor falls to first order, and
    goes on for ever; otherwise no forces of one contact are an equilibrium, because their moment about the contact is zero and that of gravity is
    not."""
    require(len(body.feet) == 1, "the body does not stand on one contact")
    require(
        body.feet[0].point[1] < body.center[1], "the body may hang from its contact"
    )
