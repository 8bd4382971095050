"""Contact-mode problems with rational data, by class, for ``modes_oracle``; as a script it prints their properties.

All are generated from one seed. Classes differ by the difficulty for a solver. Numbers are short dyadic fractions in classes
with exact ties. Tangents such as (4/5, 3/5) are not doubles: a case is ``delicate`` if rounding the data may break a tie and
change the answer.
"""

import functools
import math
import random
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TypedDict

from modes_oracle import Pair, Problem, Row, consistent_words

SEED = 2008
#: Number of cases of every random class.
PER_CLASS = 30
#: Relative size of the changes that test for ties: far above rounding errors, far below the spacing of the numbers.
MOVE = Fraction(1, 2**40)
#: Number of random directions of such changes; each is applied with both signs.
DIRECTIONS = 2

FLAT = (Fraction(1), Fraction(0))
TRIPLES = ((3, 4, 5), (5, 12, 13), (8, 15, 17), (7, 24, 25))
DOWN = (Fraction(0), Fraction(-1), Fraction(0))
WEIGHTLESS = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True)
class Case:
    """A problem, its source, and the expected answer if it is known from elsewhere."""

    name: str
    kind: str
    problem: Problem
    stated: frozenset[str] | None = None

    @cached_property
    def words(self) -> frozenset[str]:
        """The consistent words."""
        return frozenset(consistent_words(self.problem))

    @cached_property
    def doubtful(self) -> frozenset[str]:
        """Words whose verdict changes when every number changes by 2⁻⁴⁰ of itself: ties."""
        changed: set[str] = set()
        for k in range(DIRECTIONS):
            for move in (MOVE, -MOVE):
                rng = random.Random(f"{self.name} {k}")
                changed |= self.words ^ consistent_words(moved(self.problem, rng, move))
        return frozenset(changed)

    @cached_property
    def delicate(self) -> bool:
        """Whether the data are not doubles and have a tie that rounding may break."""
        return not is_representable(self.problem) and bool(self.doubtful)

    @property
    def keywords(self) -> dict[str, object]:
        """The arguments of ``standfast.ContactProblem``, in doubles."""
        p = self.problem
        return {
            "mass": float(p.mass),
            "gyration_radius": root(p.rho2),
            "arms": [floats(x) for x in p.arms],
            "tangents": [floats(x) for x in p.tangents],
            "friction": [float(x) for x in p.friction],
            "sliding": list(p.sliding),
            "bias": [floats(x) for x in p.bias],
            "free_acceleration": floats(p.free_acceleration),
            "level": p.level,
        }


def floats(values: tuple[Fraction, ...]) -> tuple[float, ...]:
    """The nearest doubles."""
    return tuple(float(x) for x in values)


def root(square: Fraction) -> float:
    """The square root, exact where it is rational and a double."""
    exact = exact_root(square)
    return math.sqrt(square) if exact is None else float(exact)


def exact_root(square: Fraction) -> Fraction | None:
    """The square root, or None where it is irrational."""
    found = Fraction(math.isqrt(square.numerator), math.isqrt(square.denominator))
    return found if found * found == square else None


def is_representable(problem: Problem) -> bool:
    """Whether all numbers, including the gyration radius, are doubles without rounding."""
    radius = exact_root(problem.rho2)
    pairs = (*problem.arms, *problem.tangents, *problem.bias, problem.free_acceleration)
    numbers = (problem.mass, *problem.friction, *(x for pair in pairs for x in pair))
    return radius is not None and all(
        Fraction(float(x)) == x for x in (radius, *numbers)
    )


def moved(problem: Problem, rng: random.Random, move: Fraction) -> Problem:
    """The problem with every nonzero number changed by up to ``move`` of itself, and tangents rotated."""

    def near(x: Fraction) -> Fraction:
        return x * (1 + move * Fraction(rng.randint(-64, 64), 64))

    def turned(t: Pair) -> Pair:
        s = move * Fraction(rng.randint(-64, 64), 64)
        c, s = (1 - s * s) / (1 + s * s), 2 * s / (1 + s * s)
        return t[0] * c - t[1] * s, t[0] * s + t[1] * c

    def both(pair: Pair) -> Pair:
        return near(pair[0]), near(pair[1])

    x, y, turn = problem.free_acceleration
    return replace(
        problem,
        mass=near(problem.mass),
        rho2=near(problem.rho2),
        arms=tuple(both(d) for d in problem.arms),
        tangents=tuple(turned(t) for t in problem.tangents),
        friction=tuple(near(mu) for mu in problem.friction),
        bias=tuple(both(b) for b in problem.bias),
        free_acceleration=(near(x), near(y), near(turn)),
    )


def build(
    arms: list[Pair],
    tangents: list[Pair],
    friction: list[Fraction],
    sliding: list[int | None],
    *,
    spin2: Fraction = Fraction(0),
    bias: list[Pair] | None = None,
    free: Row = DOWN,
    mass: Fraction = Fraction(1),
    rho2: Fraction = Fraction(1, 4),
    level: str = "acceleration",
) -> Problem:
    """A problem; the bias is that of the spin, (−b, −c) θ̇² with b = t·d and c = n·d, unless given."""
    if bias is None:
        bias = [
            (-(tx * dx + ty * dy) * spin2, -(tx * dy - ty * dx) * spin2)
            for (dx, dy), (tx, ty) in zip(arms, tangents, strict=True)
        ]
    return Problem(
        mass,
        rho2,
        tuple(arms),
        tuple(tangents),
        tuple(friction),
        tuple(sliding),
        tuple(bias),
        free,
        level,
    )


def ratio(text: str) -> Fraction:
    """A rational from its decimal or fraction form."""
    return Fraction(text)


def pair(x: str, y: str) -> Pair:
    """A pair of rationals."""
    return Fraction(x), Fraction(y)


def stated_cases() -> list[Case]:
    """Examples with answers computed by hand."""
    gravity, flat = DOWN, [FLAT]
    cases = []

    def add(name: str, stated: str, problem: Problem) -> None:
        answer = frozenset(stated.split(",") if stated else [])
        cases.append(Case(name, "stated", problem, answer))

    # The uniform rod at the slope tan = 2, on its left end, sliding left: P(μ) = 8/5 − 6μ/5.
    def rod(mu: str, spin2: str) -> Problem:
        return build(
            [pair("-1", "-2")],
            flat,
            [ratio(mu)],
            [-1],
            spin2=ratio(spin2),
            rho2=Fraction(5, 3),
        )

    add("uniform rod below 4/3", "L", rod("1.3330078125", "0"))
    add("uniform rod above 4/3", "", rod("1.3339843750", "0"))
    add("uniform rod at 4/3", "", rod("4/3", "0"))
    add("uniform rod above 4/3, spinning", "S,L", rod("1.333984375", "1"))
    add("uniform rod below 4/3, spinning", "S", rod("1.3330078125", "1"))
    add("uniform rod at 4/3, spinning", "S", rod("4/3", "1"))
    add("uniform rod at 4/3, no normal load", "L", rod("4/3", "1/2"))

    def rod_345(mu: str, spin2: str, sliding: int = -1) -> Problem:
        return build(
            [pair("-3/5", "-4/5")],
            flat,
            [ratio(mu)],
            [sliding],
            spin2=ratio(spin2),
            rho2=Fraction(1, 3),
        )

    add("3-4-5 rod at 13/9", "", rod_345("13/9", "0"))
    add("3-4-5 rod at 13/9, no normal load", "L", rod_345("13/9", "5/4"))
    add("3-4-5 rod below 13/9", "L", rod_345("1.4443359375", "0"))
    add("3-4-5 rod, friction 2", "", rod_345("2", "0"))
    add("3-4-5 rod, friction 2, spinning", "S,L", rod_345("2", "5/2"))
    add("3-4-5 rod, friction 2, other way", "R", rod_345("2", "0", 1))

    for name, sliding in (("right", 1), ("left", -1)):
        add(
            f"two contacts sliding {name}",
            "",
            build(
                [pair("-1", "-1"), pair("1", "-1")],
                flat * 2,
                [ratio("3/2")] * 2,
                [sliding] * 2,
            ),
        )
    add(
        "two contacts at rest, three modes",
        "SF,FS,FF",
        build(
            [pair("-1", "-3"), pair("1", "0")],
            [pair("4/5", "-3/5")] * 2,
            [ratio("1")] * 2,
            [0, 0],
            rho2=Fraction(1, 2),
            free=gravity,
        ),
    )
    return cases


class Body(TypedDict):
    """A body without its contacts."""

    mass: Fraction
    rho2: Fraction


def mixed_speeds(rng: random.Random, n: int) -> list[int | None]:
    """Any mixture of sliding, resting and separated contacts, n in number, at least one of them closed."""
    while True:
        found = [rng.choice((0, 0, 1, 1, -1, -1, None)) for _ in range(n)]
        if any(x is not None for x in found):
            return found


class Draw:
    """Random rationals with small denominators."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng

    def grid(self, low: float, high: float, step: str = "1/8") -> Fraction:
        """A multiple of ``step`` between ``low`` and ``high``."""
        unit = Fraction(step)
        return unit * self.rng.randint(round(low / unit), round(high / unit))

    def nonzero(self, low: float, high: float, step: str = "1/8") -> Fraction:
        """A nonzero multiple of ``step`` between ``low`` and ``high``."""
        return next(x for x in iter(lambda: self.grid(low, high, step), None) if x)

    def tangent(self, steepest: int = 1) -> Pair:
        """A flat or a Pythagorean slope of either sign; steeper than 45° if ``steepest`` > 1."""
        if self.rng.random() < 0.25:
            return FLAT
        a, b, c = self.rng.choice(TRIPLES)
        if steepest > 1 and self.rng.random() < 0.5:
            a, b = b, a
        return Fraction(b, c), Fraction(self.rng.choice((-1, 1)) * a, c)

    def any_tangent(self) -> Pair:
        """Any Pythagorean direction, walls and ceilings included."""
        x, y = self.tangent(2)
        for _ in range(self.rng.randrange(4)):
            x, y = -y, x
        return x, y

    def arm(self, below: bool = True) -> Pair:
        """A contact, by default under the centre of mass."""
        return self.grid(-2, 2), self.grid(-2, -0.25) if below else self.grid(-2, 2)

    def body(self) -> Body:
        """Mass and ρ²; ρ is a double."""
        radius = Fraction(self.rng.choice((1, 2, 3, 4, 6, 8)), 4)
        return {"mass": Fraction(self.rng.choice((1, 1, 2, 3))), "rho2": radius**2}

    def load(self) -> Row:
        """Gravity, in half of the cases with an additional wrench."""
        if self.rng.random() < 0.5:
            return DOWN
        return self.grid(-1, 1), self.grid(-2, 0.5), self.grid(-2, 2)

    def contacts(self, n: int) -> tuple[list[Pair], list[Pair]]:
        """n different places, and their tangents."""
        arms: list[Pair] = []
        while len(arms) < n:
            arm = self.arm()
            if arm not in arms:
                arms.append(arm)
        return arms, [self.tangent() for _ in range(n)]

    def speeds(self, n: int) -> list[int | None]:
        """Any mixture of sliding, resting and separated contacts, at least one of them closed."""
        return mixed_speeds(self.rng, n)


def at_rest(friction: tuple[str, ...]) -> Callable[[Draw, int], Problem]:
    """Bodies at rest with friction from a list."""

    def make(draw: Draw, k: int) -> Problem:
        n = 1 + k % 4
        arms, tangents = draw.contacts(n)
        mu = [Fraction(draw.rng.choice(friction)) for _ in range(n)]
        return build(arms, tangents, mu, [0] * n, free=draw.load(), **draw.body())

    return make


def mixed_sliding(draw: Draw, k: int) -> Problem:
    """Sliding, resting and separated contacts in any mixture, whether a rigid body can move so or not."""
    n = 1 + k % 4
    arms, tangents = draw.contacts(n)
    mu = [draw.grid(0, 2) for _ in range(n)]
    spin2 = draw.grid(0, 2)
    return build(
        arms, tangents, mu, draw.speeds(n), spin2=spin2, free=draw.load(), **draw.body()
    )


def rigid_sliding(draw: Draw, k: int) -> Problem:
    """Two contacts whose sliding velocities are those of one rigid motion; on one line both slide."""
    while True:
        arms, tangents = draw.contacts(2)
        mu = [draw.grid(0, 2) for _ in range(2)]
        still = build(arms, tangents, mu, [0, 0], **draw.body())
        (a, b, c), (d, e, f) = (still.normal_row(i) for i in (0, 1))
        motion = (
            b * f - c * e,
            c * d - a * f,
            a * e - b * d,
        )  # orthogonal to both rows
        if not any(motion):
            continue
        sense = draw.rng.choice((-1, 1))
        sliding: list[int | None] = []
        for i in (0, 1):
            row = still.tangential_row(i)
            v = sense * _rate(row, motion)
            sliding.append((v > 0) - (v < 0))
        spin2 = (motion[2] * draw.grid(0, 1)) ** 2
        return build(
            arms,
            tangents,
            mu,
            sliding,
            spin2=spin2,
            free=draw.load(),
            mass=still.mass,
            rho2=still.rho2,
        )


def slender(draw: Draw, k: int) -> Problem:
    """Small ρ, long arms, high friction, sliding towards the arm: near Painlevé's paradox."""
    n = 1 + k % 3
    arms: list[Pair] = []
    while len(arms) < n:
        arm = (draw.nonzero(-2, 2), draw.grid(-3, -1))
        if arm not in arms:
            arms.append(arm)
    tangents = [draw.tangent() for _ in range(n)]
    mu = [draw.grid(1, 3) for _ in range(n)]
    sliding: list[int | None] = [1 if arm[0] > 0 else -1 for arm in arms]
    if draw.rng.random() < 0.4:
        sliding[-1] = draw.rng.choice((0, 1, -1))
    spin2 = draw.grid(0, 2) if draw.rng.random() < 0.7 else Fraction(0)
    radius = Fraction(draw.rng.choice((1, 2, 3)), 4)
    return build(arms, tangents, mu, sliding, spin2=spin2, rho2=radius**2)


def slender_at_rest(draw: Draw, k: int) -> Problem:
    """Two or three long legs, high friction, no motion: several consistent modes."""
    n = 2 + k % 2
    arms: list[Pair] = []
    while len(arms) < n:
        arm = (draw.grid(-2, 2), draw.grid(-4, 0))
        if arm not in arms:
            arms.append(arm)
    tangent = draw.tangent()
    tangents = [tangent if draw.rng.random() < 0.6 else draw.tangent() for _ in arms]
    mu = [draw.grid(0.5, 3) for _ in range(n)]
    radius = Fraction(draw.rng.choice((1, 2, 3)), 4)
    return build(arms, tangents, mu, [0] * n, rho2=radius**2)


def flat_floor(draw: Draw, k: int) -> Problem:
    """Three or four contacts on one flat floor: at rest, all sliding one way, or mixed."""
    n = 3 + k % 2
    tangent = FLAT if k % 5 < 3 else draw.tangent()
    height = draw.grid(-2, -0.25)
    places: set[Fraction] = set()
    while len(places) < n:
        places.add(draw.grid(-2, 2, "1/4"))
    tx, ty = tangent
    arms = [(x * tx - height * ty, x * ty + height * tx) for x in sorted(places)]
    if draw.rng.random() < 0.7:
        mu = [draw.grid(0, 2)] * n
    else:
        mu = [draw.grid(0, 2) for _ in range(n)]
    style = k // 2 % 3
    sliding: list[int | None]
    if style == 0:
        sliding = [0] * n
    elif style == 1:
        sliding = [draw.rng.choice((-1, 1))] * n
    else:
        sliding = draw.speeds(n)
    return build(arms, [tangent] * n, mu, sliding, free=draw.load(), **draw.body())


def coincident(draw: Draw, k: int) -> Problem:
    """Two contacts at one place, on one slope or in a groove; sometimes a third one elsewhere."""
    arms, tangents = draw.contacts(2 + k % 2)
    arms[1] = arms[0]
    if draw.rng.random() < 0.5:
        tangents[1] = tangents[0]
    n = len(arms)
    mu = [draw.grid(0, 2)] * n if k % 3 else [draw.grid(0, 2) for _ in range(n)]
    sliding: list[int | None] = [0] * n
    if draw.rng.random() < 0.4:
        sliding = [draw.rng.choice((-1, 1))] * n
    return build(arms, tangents, mu, sliding, free=draw.load(), **draw.body())


def parallel(draw: Draw, k: int) -> Problem:
    """Contacts on parallel slopes at any height, as on stairs."""
    n = 2 + k % 3
    arms, _ = draw.contacts(n)
    tangent = draw.tangent(2)
    mu = [draw.grid(0, 2) for _ in range(n)]
    sliding: list[int | None] = [0] * n
    if draw.rng.random() < 0.5:
        sliding = [draw.rng.choice((-1, 1))] * n
    return build(arms, [tangent] * n, mu, sliding, free=draw.load(), **draw.body())


def separated(draw: Draw, k: int) -> Problem:
    """At least one contact is separated; in some cases all are."""
    n = 1 + k % 4
    arms, tangents = draw.contacts(n)
    mu = [draw.grid(0, 2) for _ in range(n)]
    sliding: list[int | None] = [draw.rng.choice((0, 0, 1, -1, None)) for _ in range(n)]
    sliding[draw.rng.randrange(n)] = None
    return build(arms, tangents, mu, sliding, free=draw.load(), **draw.body())


def squeezed(draw: Draw, k: int) -> Problem:
    """Walls and ceilings too: normals in all directions, possibly wedging."""
    n = 2 + k % 2
    arms = [draw.arm(below=False) for _ in range(n)]
    tangents = [draw.any_tangent() for _ in range(n)]
    mu = [draw.grid(0, 2) for _ in range(n)]
    sliding: list[int | None] = [0] * n
    if draw.rng.random() < 0.4:
        sliding = draw.speeds(n)
    return build(arms, tangents, mu, sliding, free=draw.load(), **draw.body())


def impulse(newton: bool) -> Callable[[Draw, int], Problem]:
    """Impacts: velocities instead of accelerations; the bias of Newton's law is (0, e v_n)."""

    def make(draw: Draw, k: int) -> Problem:
        n = 1 + k % 3
        while True:
            arms, tangents = draw.contacts(n)
            velocity = draw.grid(-2, 2), draw.grid(-2, 1), draw.grid(-2, 2)
            mu = [draw.grid(0, 2) for _ in range(n)]
            still = build(arms, tangents, mu, [0] * n, **draw.body())
            rates = [_rate(still.normal_row(i), velocity) for i in range(n)]
            if min(rates) < 0:
                break
        e = draw.grid(0.125, 0.875) if newton else Fraction(0)
        return replace(
            still,
            sliding=tuple(
                0 if v <= 0 or draw.rng.random() < 0.5 else None for v in rates
            ),
            bias=tuple((Fraction(0), e * v) for v in rates),
            free_acceleration=velocity,
            level="impulse",
        )

    return make


def no_gravity(draw: Draw, k: int) -> Problem:
    """No load except spin: at rest all forces can be zero."""
    n = 1 + k % 3
    arms, tangents = draw.contacts(n)
    mu = [draw.grid(0, 2) for _ in range(n)]
    sliding: list[int | None] = [0] * n
    spin2 = Fraction(0)
    if k % 2:
        sliding, spin2 = draw.speeds(n), draw.grid(0, 1)
    return build(
        arms, tangents, mu, sliding, spin2=spin2, free=WEIGHTLESS, **draw.body()
    )


def no_normal_force(draw: Draw, k: int) -> Problem:
    """A contact whose normal acceleration is 0 without forces: it is closed with force 0."""
    n = 1 + k % 2
    arms, _ = draw.contacts(n)
    mu = [draw.grid(0, 2) for _ in range(n)]
    b = arms[0][0]
    pull = draw.grid(-1, 1)
    sliding: list[int | None] = [draw.rng.choice((0, 1, -1)) for _ in range(n)]
    body = draw.body()
    if k % 3 == 0:  # gravity balanced by the spin: −1 − c θ̇² = 0
        return build(
            [(b, Fraction(-1)), *arms[1:]],
            [FLAT] * n,
            mu,
            sliding,
            spin2=Fraction(1),
            free=(pull, Fraction(-1), Fraction(0)),
            **body,
        )
    if k % 3 == 1:  # a load along the floor
        free = (pull, Fraction(0), Fraction(0))
    else:  # a fall and a rotation without motion of the contact
        turn = draw.nonzero(-1, 1)
        free = (pull, -b * turn, turn)
    return build(arms, [FLAT] * n, mu, sliding, free=free, **body)


def squeezed_impulse(draw: Draw, k: int) -> Problem:
    """Newton's law with walls and ceilings: restitution and friction may have no common solution."""
    problem = impulse(newton=True)(draw, 1 + k % 2)
    tangents = tuple(draw.any_tangent() for _ in problem.tangents)
    turned = replace(problem, tangents=tangents)
    e = draw.grid(0.125, 0.875)
    rates = [
        _rate(turned.normal_row(i), turned.free_acceleration)
        for i in range(turned.size)
    ]
    return replace(
        turned,
        sliding=tuple(0 if v <= 0 else None for v in rates),
        bias=tuple((Fraction(0), e * v) for v in rates),
    )


def _rate(row: Row, velocity: Row) -> Fraction:
    return sum((x * y for x, y in zip(row, velocity, strict=True)), Fraction(0))


def sought(
    wanted: Callable[[int], bool], *makers: Callable[[Draw, int], Problem]
) -> Callable[[Draw, int], Problem]:
    """Problems of other classes in turn, drawn until their number of words is the required one."""

    def make(draw: Draw, k: int) -> Problem:
        while True:
            problem = makers[k % len(makers)](draw, draw.rng.randrange(12))
            k += 1
            if wanted(len(consistent_words(problem))):
                return problem

    return make


def axis_painleve(draw: Draw, k: int) -> Problem:
    """A sliding contact exactly at Painlevé's threshold P = 0, with all numbers doubles.

    With ρ = 1/2 and b = 1/2: 1 + 4b(b + σμc) = 0 for c = −1/μ if σ = 1; mirrored for σ = −1.
    """
    mu = Fraction(draw.rng.choice(("1/2", "1", "2")))
    side = draw.rng.choice((-1, 1))
    height = -1 / mu
    if k % 3 == 2:
        height += Fraction(draw.rng.choice((-1, 1)), 2**10)
    loads = (Fraction(-1), Fraction(0), Fraction(1, 2))
    free = (draw.grid(-1, 1), loads[k % 3], Fraction(0))
    arms, mus, sliding = [(side * Fraction(1, 2), height)], [mu], [side]
    if k % 2:
        arms.append((draw.nonzero(-2, 2), height))
        mus.append(mu)
        sliding.append(side)
    return build(arms, [FLAT] * len(arms), mus, list(sliding), free=free)


CLASSES: dict[str, Callable[[Draw, int], Problem]] = {
    "at rest, low friction": at_rest(("0", "1/8", "1/4", "3/8")),
    "at rest, high friction": at_rest(("1/2", "1", "3/2", "2", "3")),
    "mixed sliding": mixed_sliding,
    "rigid sliding": rigid_sliding,
    "slender, sliding": slender,
    "slender, at rest": slender_at_rest,
    "flat floor": flat_floor,
    "coincident contacts": coincident,
    "parallel contacts": parallel,
    "separated contacts": separated,
    "squeezed": squeezed,
    "impulse, inelastic": impulse(newton=False),
    "impulse, Newton": impulse(newton=True),
    "no gravity": no_gravity,
    "no normal force": no_normal_force,
    "Painlevé threshold": axis_painleve,
    "impulse, squeezed": squeezed_impulse,
    "none, sought": sought(
        lambda count: count == 0,
        rigid_sliding,
        slender,
        squeezed,
        mixed_sliding,
        squeezed_impulse,
        flat_floor,
    ),
    "several, sought": sought(
        lambda count: count > 1,
        slender,
        slender_at_rest,
        squeezed,
        parallel,
        mixed_sliding,
        impulse(newton=False),
        at_rest(("1", "3/2", "2", "3")),
        flat_floor,
    ),
    "many, sought": sought(
        lambda count: count > 2, slender, squeezed, slender_at_rest, coincident
    ),
    "impulse, sought": sought(
        lambda count: count != 1, impulse(newton=False), squeezed_impulse
    ),
}


@functools.cache
def all_cases(seed: int = SEED, per_class: int = PER_CLASS) -> list[Case]:
    """The stated cases, then ``per_class`` of every class; the same for the same seed.

    Each class has its own stream: a larger number of cases extends the smaller one.
    """
    cases = stated_cases()
    for kind, make in CLASSES.items():
        draw = Draw(random.Random(f"{seed} {kind}"))
        cases += [Case(f"{kind} {k}", kind, make(draw, k)) for k in range(per_class)]
    return cases


def main() -> None:
    """Prints the numbers of words of the problems of every class, and the time to solve them."""
    cases = all_cases()
    seconds: dict[int, list[float]] = {}
    for case in cases:
        start = time.perf_counter()
        len(case.words)
        seconds.setdefault(case.problem.size, []).append(time.perf_counter() - start)
    header = ("class", "cases", "none", "one", "several", "ties", "delicate", "most")
    print("{:24}{:>7}{:>7}{:>7}{:>9}{:>7}{:>10}{:>6}".format(*header))
    for kind in ("stated", *CLASSES, "all"):
        some = [case for case in cases if kind in (case.kind, "all")]
        count = Counter(min(len(case.words), 2) for case in some)
        ties = sum(bool(case.doubtful) for case in some)
        delicate = sum(case.delicate for case in some)
        most = max(len(case.words) for case in some)
        print(
            f"{kind:24}{len(some):7}{count[0]:7}{count[1]:7}{count[2]:9}{ties:7}{delicate:10}{most:6}"
        )
    for n, spent in sorted(seconds.items()):
        mean, worst = sum(spent) / len(spent), max(spent)
        print(
            f"n = {n}: {len(spent)} problems, mean {1e3 * mean:.1f} ms, worst {1e3 * worst:.1f} ms"
        )


if __name__ == "__main__":
    main()
