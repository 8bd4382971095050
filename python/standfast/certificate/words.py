"""Contact modes: the motion of a word from rest, and the words that go on from a slide of two contacts."""

from dataclasses import dataclass
from functools import cached_property

from .intervals import (
    ONE,
    ZERO,
    Interval,
    Vector,
    cross,
    dot,
    plus,
    require,
    scaled,
    solve,
)
from .scene import Body

SIDES = {"R": 1, "L": -1}


@dataclass(frozen=True)
class Motion:
    """The motion of a word from rest: for each contact a_n, a_t, and its forces (f_t, f_n), per unit mass."""

    acceleration: Vector
    normal: list[Interval]
    tangential: list[Interval]
    forces: list[tuple[Interval, Interval]]


def motion(body: Body, word: str) -> Motion:
    """The rows of the word vanish: N and T of a fixed contact, N of a sliding one."""
    rows: list[Vector] = []
    columns: list[Vector] = []
    for i, (letter, foot) in enumerate(zip(word, body.feet, strict=True)):
        if letter == "F":
            rows += [foot.normal, foot.tangent]
            columns += [foot.normal, foot.tangent]
        elif letter in SIDES:
            rows.append(foot.normal)
            columns.append(body.rubbing(i, SIDES[letter]))
    require(len(rows) <= 3, f"the word {word} does not move")
    fall = (ZERO, -body.gravity, ZERO)
    force = solve(
        [[body.couple(row, column) for column in columns] for row in rows],
        [-dot(row, fall) for row in rows],
    )
    total = fall
    for column, size in zip(columns, force, strict=True):
        total = plus(total, body.over_mass(scaled(column, size)))
    forces, left = [], iter(force)
    for letter, foot in zip(word, body.feet, strict=True):
        if letter == "S":
            forces.append((ZERO, ZERO))
        elif letter == "F":
            normal = next(left)
            forces.append((next(left), normal))
        else:
            normal = next(left)
            forces.append((-foot.friction.times(SIDES[letter]) * normal, normal))
    return Motion(
        total,
        [dot(foot.normal, total) for foot in body.feet],
        [dot(foot.tangent, total) for foot in body.feet],
        forces,
    )


def room(body: Body, found: Motion, i: int) -> list[Interval]:
    """μf_n ± f_t: not negative within the friction cone."""
    tangential, normal = found.forces[i]
    most = body.feet[i].friction * normal
    return [most - tangential, most + tangential]


def kinematics(body: Body, found: Motion, word: str) -> list[tuple[str, Interval]]:
    """The strict kinematic inequalities of a word: what has to be positive."""
    tests = []
    for i, letter in enumerate(word):
        name = f"contact {body.feet[i].name} in the word {word}"
        if letter == "S":
            tests.append((f"a_n of {name}", found.normal[i]))
        elif letter in SIDES:
            tests.append((f"a_t of {name}", found.tangential[i].times(SIDES[letter])))
    return tests


@dataclass(frozen=True)
class Pair:
    """A body on two contacts, with the direction z in which both slide: along N_1 × N_2, zᵀMz = 1."""

    body: Body

    @cached_property
    def along(self) -> Vector:
        one, two = self.body.feet
        z = cross(one.normal, two.normal)
        length = z[0].square() + z[1].square() + (self.body.rho * z[2]).square()
        return scaled(z, ONE / length.sqrt())

    @cached_property
    def alpha(self) -> list[Interval]:
        """T_i z"""
        found = [dot(foot.tangent, self.along) for foot in self.body.feet]
        for foot, part in zip(self.body.feet, found, strict=True):
            require(
                part.sign() in (1, -1),
                f"contact {foot.name} may stay in place while both contacts slide",
            )
        return found

    @cached_property
    def coupling(self) -> list[list[Interval]]:
        """D = N M⁻¹ Nᵀ"""
        rows = [foot.normal for foot in self.body.feet]
        return [[self.body.couple(a, b) for b in rows] for a in rows]

    @cached_property
    def psi(self) -> list[Interval]:
        return [-self.coupling[0][1] / self.coupling[i][i] for i in range(2)]

    @cached_property
    def weights(self) -> list[Interval]:
        """λ = D⁻¹(g_1, g_2)"""
        return solve(self.coupling, [self.body.pull(0), self.body.pull(1)])

    def side(self, i: int, way: int) -> int:
        """The direction σ in which contact i slides while the body moves along `way` z."""
        return way if self.alpha[i].lo > 0 else -way

    def word(self, way: int) -> str:
        return "".join("R" if self.side(i, way) > 0 else "L" for i in range(2))

    def continuations(self, way: int) -> list[tuple[str, bool | None]]:
        """The words that may go on from a slide of both contacts along `way` z, with their forces: ("both", whether it stops), ("lifts 1",
        None), ("lifts 2", None), ("falls", None). A word that certainly fails is left out; one that is not certain is refused."""
        body = self.body
        found: list[tuple[str, bool | None]] = []
        sides = [self.side(i, way) for i in range(2)]
        columns = [body.rubbing(i, sides[i]) for i in range(2)]
        pulls = [body.pull(0), body.pull(1)]
        matrix = [[body.couple(foot.normal, c) for c in columns] for foot in body.feet]
        forces = solve(matrix, pulls)
        signs = [force.sign() for force in forces]
        if signs == [1, 1]:
            # s̈ = zᵀM q̈, with N z = 0
            speeding = -body.gravity * self.along[1]
            for foot, side, force, alpha in zip(
                body.feet, sides, forces, self.alpha, strict=True
            ):
                speeding = speeding - (foot.friction * force * alpha).times(side)
            sign = speeding.times(way).sign()
            require(
                sign is not None,
                "whether a slide of both contacts stops is not certain",
            )
            found.append(("both", sign == -1))
        else:
            require(-1 in signs, "whether both contacts go on sliding is not certain")
        for k in range(2):
            m, own, pull = 1 - k, matrix[k][k].sign(), pulls[k].sign()
            if own in (1, -1) and pull in (1, -1) and own != pull:
                continue  # its normal force would be negative
            require(
                own == 1, f"whether contact {body.feet[k].name} jams is not certain"
            )
            require(
                pulls[k].lo >= 0,
                f"whether contact {body.feet[k].name} is pressed onto its ground is not certain",
            )
            lift = (matrix[m][k] * pulls[k] / matrix[k][k] - pulls[m]).sign()
            require(
                lift in (1, -1),
                f"whether contact {body.feet[m].name} lifts off is not certain",
            )
            if lift == 1:
                found.append((f"lifts {m + 1}", None))
        signs = [pull.sign() for pull in pulls]
        if signs == [-1, -1]:
            found.append(("falls", None))
        else:
            require(
                any(pull.lo >= 0 for pull in pulls),
                "whether both contacts separate is not certain",
            )
        return found


def words_at_rest(pair: Pair) -> list[str]:
    """The words in which a body on two contacts can move, if both contacts move when they slide together."""
    return ["SS", "SF", "SR", "SL", "FS", "RS", "LS", pair.word(1), pair.word(-1)]
