"""Contact-mode problems with continuous data, by class, and problems close to an edge of a word.

All numbers are doubles, stored as fractions: the problems solved in doubles and exactly are the same. Tangents are of length
one up to rounding, as they are if computed from an angle.
"""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction

from modes_oracle import (
    ALLOWED,
    Motion,
    Pair,
    Problem,
    Row,
    force_interval_FF,
    satisfies,
)
from modes_problems import mixed_speeds

#: Range of the powers of ten of the distances from an edge, relative to the load or to the friction.
NEAREST, FARTHEST = -12, -5
#: Largest change of a number to reach an edge, for loads of order one; the remaining load is at least its reciprocal.
LARGEST = 8
FLAT = (Fraction(1), Fraction(0))
ZERO = Fraction(0)


def rounded(x: Fraction) -> Fraction:
    """The nearest double."""
    return Fraction(float(x))


class Draw:
    """Random doubles."""

    def __init__(self, seed: object) -> None:
        self.rng = random.Random(str(seed))

    def number(self, low: float, high: float) -> Fraction:
        """Any double between ``low`` and ``high``."""
        return Fraction(self.rng.uniform(low, high))

    def distance(self) -> Fraction:
        """A distance from an edge: all powers of ten are equally likely."""
        return Fraction(10 ** self.rng.uniform(NEAREST, FARTHEST))

    def sign(self) -> int:
        """1 or −1."""
        return self.rng.choice((1, -1))

    def tangent(self, steepest: float) -> Pair:
        """The direction of an angle of either sign up to ``steepest``, rad."""
        angle = self.rng.uniform(-steepest, steepest)
        return Fraction(math.cos(angle)), Fraction(math.sin(angle))

    def short(self, low: float, high: float, bits: int) -> Fraction:
        """A multiple of 2^−bits between ``low`` and ``high``."""
        scale = 2**bits
        return Fraction(
            self.rng.randint(round(low * scale), round(high * scale)), scale
        )

    def short_tangent(self, steepest: float) -> Pair:
        """As ``tangent``, in multiples of 2⁻³⁰, of length one to 10⁻¹²."""
        one = 2**30
        while True:
            x = round(one * math.cos(self.rng.uniform(0, min(steepest, math.pi / 2))))
            y = math.isqrt(one**2 - x**2)
            if one**2 - x**2 - y**2 < 1e-12 * one**2:
                break
        if steepest > math.pi / 2:
            x *= self.sign()
        return Fraction(x, one), Fraction(self.sign() * y, one)

    def legs(self, n: int, longest: float = 2) -> tuple[Pair, ...]:
        """Contacts under the centre of mass."""
        return tuple(
            (self.number(-2, 2), self.number(-longest, -0.25)) for _ in range(n)
        )

    def load(self) -> Row:
        """Gravity; in three cases of four with an additional wrench."""
        if self.rng.random() < 0.25:
            return ZERO, Fraction(-1), ZERO
        return self.number(-1, 1), self.number(-2, 0.5), self.number(-2, 2)

    def speeds(self, n: int) -> tuple[int | None, ...]:
        """Any mixture of sliding, resting and separated contacts, at least one closed."""
        return tuple(mixed_speeds(self.rng, n))


def spun(problem: Problem, spin2: Fraction) -> Problem:
    """The bias of a body rotating with θ̇² = ``spin2``: (−b, −c) θ̇², b = t·d and c = n·d, rounded."""
    bias = tuple(
        (
            rounded(-(tx * dx + ty * dy) * spin2),
            rounded(-(tx * dy - ty * dx) * spin2),
        )
        for (dx, dy), (tx, ty) in zip(problem.arms, problem.tangents, strict=True)
    )
    return replace(problem, bias=bias)


def body(draw: Draw, arms: tuple[Pair, ...], **fields: object) -> Problem:
    """Contacts on slopes up to 45° of a body at rest, unless ``fields`` are given."""
    n = len(arms)
    radius = fields.pop("radius", None) or draw.number(0.25, 2)
    resting = Problem(
        mass=draw.number(0.5, 3),
        rho2=radius**2,
        arms=arms,
        tangents=tuple(draw.tangent(math.pi / 4) for _ in arms),
        friction=tuple(draw.number(0, 2) for _ in arms),
        sliding=(0,) * n,
        bias=((ZERO, ZERO),) * n,
        free_acceleration=draw.load(),
    )
    return replace(resting, **fields)


def pair_at_rest(low: float, high: float) -> Callable[[Draw, int], Problem]:
    """Two contacts at rest with friction between ``low`` and ``high``."""

    def make(draw: Draw, k: int) -> Problem:
        mu = draw.number(low, high), draw.number(low, high)
        return body(draw, draw.legs(2), friction=mu)

    return make


def at_rest(draw: Draw, k: int) -> Problem:
    """One to four contacts at rest, in every other problem also on walls and ceilings."""
    n = 1 + k % 4
    problem = body(draw, draw.legs(n))
    if k // 4 % 2:
        arms = tuple((draw.number(-2, 2), draw.number(-2, 2)) for _ in range(n))
        tangents = tuple(draw.tangent(math.pi) for _ in range(n))
        problem = replace(problem, arms=arms, tangents=tangents)
    return problem


def mixed_sliding(draw: Draw, k: int) -> Problem:
    """One to four sliding, resting or separated contacts in any mixture, while the body rotates."""
    n = 1 + k % 4
    problem = body(draw, draw.legs(n), sliding=draw.speeds(n))
    return spun(problem, draw.number(0, 2))


def slender(draw: Draw, k: int) -> Problem:
    """Long legs, small ρ, high friction, most contacts sliding towards their legs: near Painlevé's paradox."""
    n = 1 + k % 4
    arms = tuple((draw.number(-2, 2), draw.number(-3, -1)) for _ in range(n))
    problem = body(
        draw,
        arms,
        radius=draw.number(0.25, 0.75),
        tangents=tuple(draw.tangent(0.4) for _ in range(n)),
        friction=tuple(draw.number(1, 3) for _ in range(n)),
        sliding=tuple(
            draw.rng.choice((1, 1, 1, 0, -1)) * (1 if x > 0 else -1) for x, _ in arms
        ),
        free_acceleration=(ZERO, Fraction(-1), ZERO),
    )
    return spun(problem, draw.number(0, 1) if draw.rng.random() < 0.7 else ZERO)


def flat_floor(draw: Draw, k: int) -> Problem:
    """Two to four contacts on one level floor: at rest, all sliding one way, or mixed."""
    n = 2 + k % 3
    height = draw.number(-2, -0.25)
    arms = tuple((draw.number(-2, 2), height) for _ in range(n))
    problem = body(draw, arms, tangents=(FLAT,) * n)
    if draw.rng.random() < 0.5:
        problem = replace(problem, friction=(draw.number(0, 2),) * n)
    style = k // 3 % 3
    if style == 1:
        problem = replace(problem, sliding=(draw.sign(),) * n)
    if style == 2:
        problem = replace(problem, sliding=draw.speeds(n))
    return problem


def impulse(draw: Draw, k: int) -> Problem:
    """An impact on one to four contacts, inelastic or with Newton's law, in every other problem between walls.

    Newton's law has bias e·rate, which is exact for doubles of few bits: −e times the velocity is then a solution for any
    number of contacts.
    """
    n = 1 + k % 4
    while True:
        arms = tuple((draw.short(-2, 2, 6), draw.short(-2, -0.25, 6)) for _ in range(n))
        velocity = draw.short(-2, 2, 5), draw.short(-2, 1, 5), draw.short(-2, 2, 5)
        steepest = math.pi if k // 8 % 2 else math.pi / 4
        tangents = tuple(draw.short_tangent(steepest) for _ in range(n))
        problem = body(draw, arms, tangents=tangents, free_acceleration=velocity)
        rates = [_dot(problem.normal_row(i), velocity) for i in range(n)]
        if min(rates) < 0:
            break
    e = draw.short(0.125, 0.875, 3) if k // 4 % 2 else ZERO
    return replace(
        problem,
        sliding=tuple(
            0 if rate <= 0 or draw.rng.random() < 0.5 else None for rate in rates
        ),
        bias=tuple((ZERO, e * rate) for rate in rates),
        level="impulse",
    )


#: Classes in which numbers are close to an edge only by chance.
CLASSES: dict[str, Callable[[Draw, int], Problem]] = {
    "two at rest, low friction": pair_at_rest(0, 0.4),
    "two at rest, high friction": pair_at_rest(0.5, 3),
    "one to four at rest": at_rest,
    "mixed sliding": mixed_sliding,
    "slender, sliding": slender,
    "flat floor": flat_floor,
    "impulse": impulse,
}


# Close to an edge.


@dataclass(frozen=True)
class Edge:
    """A problem in which a condition of a word is nearly violated or nearly satisfied."""

    problem: Problem
    word: str
    #: Margin of the condition, relative to the load (FF: margin of the friction, relative to itself); negative where it
    #: fails.
    distance: float


def solved(problem: Problem, word: str) -> Motion | None:
    """The motion by the word's equations, without its inequalities; None if it is not unique."""
    m, rho2 = problem.mass, problem.rho2
    rows: list[tuple[Row, Fraction]] = []
    pushes: list[tuple[int, Fraction, Fraction]] = []  # contact, f_t and f_n of a unit
    for i, letter in enumerate(word):
        if letter == "S":
            continue
        b_t, b_n = problem.bias[i]
        rows.append((problem.normal_row(i), b_n))
        side = {"F": 0, "R": -1, "L": 1}[letter]
        pushes.append((i, side * problem.friction[i], Fraction(1)))
        if letter == "F":
            rows.append((problem.tangential_row(i), b_t))
            pushes.append((i, Fraction(1), ZERO))
    moves: list[Row] = []
    for i, t, n in pushes:
        T, N = problem.tangential_row(i), problem.normal_row(i)
        x, y, turn = (t * a + n * b for a, b in zip(T, N, strict=True))
        moves.append((x / m, y / m, turn / (m * rho2)))
    free = problem.free_acceleration
    weights = linear_solution(
        [
            [*(_dot(row, move) for move in moves), -_dot(row, free) - bias]
            for row, bias in rows
        ]
    )
    if weights is None:
        return None
    forces = [(ZERO, ZERO)] * problem.size
    x, y, turn = free
    for (i, t, n), move, w in zip(pushes, moves, weights, strict=True):
        forces[i] = (forces[i][0] + w * t, forces[i][1] + w * n)
        x, y, turn = x + w * move[0], y + w * move[1], turn + w * move[2]
    return Motion((x, y, turn), tuple(forces))


def linear_solution(rows: list[list[Fraction]]) -> list[Fraction] | None:
    """Solution of the square system whose last column is the right-hand side; None if singular."""
    n = len(rows)
    for k in range(n):
        pivot = next((i for i in range(k, n) if rows[i][k]), None)
        if pivot is None:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                factor = rows[i][k]
                rows[i] = [
                    x - factor * y for x, y in zip(rows[i], rows[k], strict=True)
                ]
    return [row[-1] for row in rows]


def spare(problem: Problem, word: str, kind: str, i: int, side: int) -> Fraction | None:
    """Margin of the condition of contact ``i``: a force over the mass, or an acceleration."""
    motion = solved(problem, word)
    if motion is None:
        return None
    f_t, f_n = (f / problem.mass for f in motion.forces[i])
    b_t, b_n = problem.bias[i]
    if kind == "cone":
        return problem.friction[i] * f_n - side * f_t
    if kind == "lift-off":
        return f_n
    if kind == "onset":
        return side * (_dot(problem.tangential_row(i), motion.acceleration) + b_t)
    return _dot(problem.normal_row(i), motion.acceleration) + b_n


def unit(problem: Problem) -> Fraction:
    """The unit of accelerations: the largest of the load and the biases."""
    x, y, turn = problem.free_acceleration
    rho = Fraction(math.sqrt(problem.rho2))
    biases = (b for pair in problem.bias for b in pair)
    return max(map(abs, (x, y, rho * turn, *biases)))


def moves(problem: Problem, kind: str, i: int) -> list[Callable[[Fraction], Problem]]:
    """The possible changes of a problem in one number: μ_i, the load, or the bias if there is one."""
    found: list[Callable[[Fraction], Problem]] = []
    if kind == "cone":

        def rougher(by: Fraction) -> Problem:
            mu = list(problem.friction)
            mu[i] = rounded(mu[i] + by)
            return replace(problem, friction=tuple(mu))

        found.append(rougher)
    for axis in range(3):

        def pushed(by: Fraction, axis: int = axis) -> Problem:
            free = list(problem.free_acceleration)
            free[axis] = rounded(free[axis] + by)
            return replace(problem, free_acceleration=(free[0], free[1], free[2]))

        found.append(pushed)
    if any(b for pair in problem.bias for b in pair):
        for j in range(problem.size):
            for axis in range(2):

                def biased(by: Fraction, j: int = j, axis: int = axis) -> Problem:
                    bias = [list(pair) for pair in problem.bias]
                    bias[j][axis] = rounded(bias[j][axis] + by)
                    return replace(problem, bias=tuple((t, n) for t, n in bias))

                found.append(biased)
    return found


def near_base(draw: Draw, n: int) -> Problem:
    """A problem to start from: at rest, sliding, slender or an impact."""
    makers = (at_rest, mixed_sliding, slender, impulse)
    return draw.rng.choice(makers)(draw, n - 1 + 4 * draw.rng.randrange(4))


LETTERS = {"cone": "F", "lift-off": "FRL", "onset": "RL", "separation": "S"}


def near(kind: str) -> Callable[[Draw, int], Edge]:
    """One to three contacts; one condition of one word is nearly violated or nearly satisfied, all others are satisfied.

    | kind       | condition       |
    | ---------- | --------------- |
    | cone       | μ f_n − |f_t|   |
    | lift-off   | f_n             |
    | onset      | a_t             |
    | separation | a_n             |
    """

    def make(draw: Draw, k: int) -> Edge:
        n = 1 + k % 3
        aim = draw.distance()
        sense = draw.sign()
        while True:
            problem = near_base(draw, n)
            word = "".join(draw.rng.choice(ALLOWED[s]) for s in problem.sliding)
            edges = [
                i
                for i, (letter, s) in enumerate(zip(word, problem.sliding, strict=True))
                if letter in LETTERS[kind]
                and (s == 0 if kind == "onset" else s is not None)
            ]
            if not edges or sum({"S": 0, "F": 2}.get(x, 1) for x in word) > 3:
                continue
            i = draw.rng.choice(edges)
            side = draw.sign()
            if kind == "onset":
                side = 1 if word[i] == "R" else -1
            move = draw.rng.choice(moves(problem, kind, i))
            found = placed(problem, move, word, kind, i, side, aim)
            if found is None:
                continue
            motion = solved(found.problem, word)
            if motion is None or not satisfies(found.problem, word, motion):
                continue
            if sense < 0:
                other = placed(problem, move, word, kind, i, side, -aim)
                if other is None:
                    continue
                found = other
            return found

    return make


def placed(
    problem: Problem,
    move: Callable[[Fraction], Problem],
    word: str,
    kind: str,
    i: int,
    side: int,
    aim: Fraction,
) -> Edge | None:
    """The problem changed until the condition has the margin ``aim``: the margin is affine in the changed number."""
    here, there = (spare(move(Fraction(by)), word, kind, i, side) for by in (0, 1))
    if here is None or there is None or here == there:
        return None
    by = (aim * unit(problem) - here) / (there - here)
    if abs(by) > LARGEST:
        return None
    found = move(by)
    left = spare(found, word, kind, i, side)
    if left is None or min(found.friction) < 0 or unit(found) * LARGEST < 1:
        return None
    return Edge(found, word, float(left / unit(found)))


def near_squeeze(draw: Draw, k: int) -> Edge:
    """Two fixed contacts whose internal force has a short interval, or just none, by a factor on friction.

    Either the interval vanishes, or the contacts begin to wedge and it starts at infinity: then the forces are as large as
    the distance is small.
    """
    while True:
        problem = body(draw, draw.legs(2), friction=(draw.number(0.2, 2),) * 2)
        if k % 2:
            tangents = draw.tangent(math.pi), draw.tangent(math.pi)
            problem = replace(problem, tangents=tangents)

        def rougher(factor: Fraction, problem: Problem = problem) -> Problem:
            mu = tuple(rounded(mu * factor) for mu in problem.friction)
            return replace(problem, friction=mu)

        low, high = Fraction(1, 16), Fraction(4)
        if force_interval_FF(rougher(low)) or not force_interval_FF(rougher(high)):
            continue
        while float(high - low) > math.ulp(high):
            middle = (low + high) / 2
            if force_interval_FF(rougher(middle)):
                high = middle
            else:
                low = middle
        aim = draw.sign() * draw.distance()
        return Edge(rougher(high * (1 + aim)), "FF", float(aim))


def near_floor(draw: Draw, k: int) -> Edge:
    """Two to four contacts on a level floor, about to slide together or to tip over the outer one."""
    n = 2 + k % 3
    while True:
        problem = replace(
            flat_floor(draw, 3 * draw.rng.randrange(3) + n - 2), sliding=(0,) * n
        )
        mu = draw.number(0.25, 2)
        problem = replace(problem, friction=(mu,) * n)
        x, y, turn = problem.free_acceleration
        push, height = -y, -problem.arms[0][1]  # over the mass
        if push <= 0:
            continue
        aim = draw.sign() * draw.distance()
        # If the body is held, the force of the floor is (−x, −y) at the point that balances the torque.
        torque = -turn * problem.rho2
        place = (torque + height * x) / push
        feet = sorted(foot for foot, _ in problem.arms)
        if k // 3 % 2:
            mu = rounded(abs(x) / push * (1 + aim))
            problem = replace(problem, friction=(mu,) * n)
            if not (x and feet[0] < place < feet[-1]):
                continue
            distance = (mu * push - abs(x)) / unit(problem)
        else:
            edge = feet[-1] - aim
            turn = rounded((height * x - edge * push) / problem.rho2)
            problem = replace(problem, free_acceleration=(x, y, turn))
            place = (height * x - turn * problem.rho2) / push
            if not (abs(x) < mu * push and feet[0] < place):
                continue
            distance = feet[-1] - place
        return Edge(problem, "F" * n, float(distance))


#: Classes of problems close to an edge.
EDGES: dict[str, Callable[[Draw, int], Edge]] = {
    "edge: friction cone": near("cone"),
    "edge: lift-off": near("lift-off"),
    "edge: onset of sliding": near("onset"),
    "edge: separation": near("separation"),
    "edge: squeeze of FF": near_squeeze,
    "edge: flat floor": near_floor,
}


def _dot(a: Row, b: Row) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
