"""Every consistent contact mode of a planar body, decided in exact rational arithmetic.

An oracle for the tests, written from the definitions alone. Contact i has the arm d, the unit tangent
t and the normal n = t turned by +90°, hence the rows N = (n, d×n) and T = (t, d×t) with d×n = d_x n_y
− d_y n_x. A motion is an acceleration q̈ with forces f = (f_t, f_n) at the contacts,

    q̈ = free + M⁻¹ Σ (Tᵀ f_t + Nᵀ f_n),   M = diag(m, m, m ρ²),   a_t = T q̈ + b_t,   a_n = N q̈ + b_n,

and a word has one letter per contact. ``sliding`` is the sign of v_t, None where the contact is separated:

| letter | equations             | inequalities                            | allowed where sliding is |
| ------ | --------------------- | --------------------------------------- | ------------------------ |
| S      | f = 0                 | a_n > 0                                 | +1, −1, 0                |
| S      | f = 0                 | none                                    | None                     |
| R      | a_n = 0, f_t = −μ f_n | f_n ≥ 0; a_t > 0 if sliding is 0        | +1, 0                    |
| L      | a_n = 0, f_t = +μ f_n | f_n ≥ 0; a_t < 0 if sliding is 0        | −1, 0                    |
| F      | a_n = 0, a_t = 0      | −μ f_n ≤ f_t ≤ μ f_n                    | 0                        |

A word is consistent if some motion satisfies all of its conditions; where the forces are not unique
(two fixed contacts, a flat floor) one solution is enough. At the level of impulses the same
holds with the velocity before the impact as ``free_acceleration``, the velocity after it as q̈, and
e times the normal rate before it as b_n.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import gcd, lcm

Row = tuple[Fraction, Fraction, Fraction]
Pair = tuple[Fraction, Fraction]

ALLOWED = {None: "S", 1: "SR", -1: "SL", 0: "SRLF"}


@dataclass(frozen=True)
class Problem:
    """Coulomb contacts of one body; names and order as in ``standfast.ContactProblem``, except for ρ²."""

    mass: Fraction
    rho2: Fraction
    arms: tuple[Pair, ...]
    tangents: tuple[Pair, ...]
    friction: tuple[Fraction, ...]
    sliding: tuple[int | None, ...]
    bias: tuple[Pair, ...]
    free_acceleration: Row
    level: str = "acceleration"

    @property
    def size(self) -> int:
        """The number of contacts."""
        return len(self.arms)

    @cached_property
    def rows(self) -> list[tuple[Row, Row]]:
        """T = (t, d×t) and N = (n, d×n), n = (−t_y, t_x), of each contact."""
        return [
            ((tx, ty, dx * ty - dy * tx), (-ty, tx, dx * tx + dy * ty))
            for (dx, dy), (tx, ty) in zip(self.arms, self.tangents, strict=True)
        ]

    def tangential_row(self, i: int) -> Row:
        """T of contact i."""
        return self.rows[i][0]

    def normal_row(self, i: int) -> Row:
        """N of contact i."""
        return self.rows[i][1]

    @cached_property
    def tables(self) -> "_Tables":
        """The conditions of all words."""
        return _Tables(self)

    @cached_property
    def motions(self) -> dict[str, "Motion"]:
        """All consistent words, each with one motion that has been substituted into its definition.

        The beginning of a word is rejected as soon as no acceleration satisfies its conditions on a_n and a_t: then no
        continuation can be consistent, with any forces.
        """
        prefixes = [""]
        for sliding in self.sliding:
            prefixes = [
                prefix + letter
                for prefix in prefixes
                if not prefix or self.tables.is_possible(prefix)
                for letter in ALLOWED[sliding]
            ]
        return _decided(self, prefixes)

    def words(self) -> Iterator[str]:
        """All words that the velocities allow, up to 4ⁿ."""
        prefixes = [""]
        for sliding in self.sliding:
            prefixes = [p + letter for p in prefixes for letter in ALLOWED[sliding]]
        return iter(prefixes)


@dataclass(frozen=True)
class Motion:
    """A motion that proves a word: the acceleration (at the level of impulses the velocity after the impact) and forces (f_t,
    f_n)."""

    acceleration: Row
    forces: tuple[Pair, ...]


def satisfies(problem: Problem, word: str, motion: Motion) -> bool:
    """Whether the motion satisfies every condition of the word, by substitution."""
    m, rho2 = problem.mass, problem.rho2
    wrench = [Fraction(0)] * 3
    for i, (f_t, f_n) in enumerate(motion.forces):
        T, N = problem.tangential_row(i), problem.normal_row(i)
        wrench = [w + f_t * t + f_n * n for w, t, n in zip(wrench, T, N, strict=True)]
    newton = tuple(
        free + w / inertia
        for free, w, inertia in zip(
            problem.free_acceleration, wrench, (m, m, m * rho2), strict=True
        )
    )
    return newton == motion.acceleration and all(
        _letter_holds(problem, i, letter, motion) for i, letter in enumerate(word)
    )


def _letter_holds(problem: Problem, i: int, letter: str, motion: Motion) -> bool:
    sliding, mu = problem.sliding[i], problem.friction[i]
    f_t, f_n = motion.forces[i]
    b_t, b_n = problem.bias[i]
    a_t = _dot(problem.tangential_row(i), motion.acceleration) + b_t
    a_n = _dot(problem.normal_row(i), motion.acceleration) + b_n
    if letter not in ALLOWED[sliding]:
        return False
    if letter == "S":
        return f_t == f_n == 0 and (sliding is None or a_n > 0)
    if letter == "F":
        return a_n == a_t == 0 and abs(f_t) <= mu * f_n
    side = 1 if letter == "R" else -1
    onset = sliding != 0 or side * a_t > 0
    return a_n == 0 and f_t == -side * mu * f_n and f_n >= 0 and onset


def consistent_words(problem: Problem) -> set[str]:
    """All consistent words. Every other word is refuted without a tolerance."""
    return set(consistent_motions(problem))


def consistent_motions(problem: Problem) -> dict[str, Motion]:
    """All consistent words, each with one motion."""
    return problem.motions


def _decided(problem: Problem, words: Iterable[str]) -> dict[str, Motion]:
    """The consistent ones of these words, each with one motion that has been substituted into its definition."""
    motions = {}
    for word in words:
        motion = problem.tables.motion(word)
        if motion is not None:
            assert satisfies(problem, word, motion), (problem, word, motion)
            motions[word] = motion
    return motions


def brute_force(problem: Problem) -> set[str]:
    """All consistent words; each of the up to 4ⁿ allowed words is decided separately."""
    return set(_decided(problem, problem.words()))


def find_motion(problem: Problem, word: str) -> Motion | None:
    """A motion for this one word, or None; without the pruning of ``consistent_motions``."""
    return problem.tables.motion(word)


class _Tables:
    """The conditions of a problem as integer rows, combined word by word.

    Forces are sums of generators with weights λ ≥ 0: N + μT and N − μT. R has only the second, L only the first, F both. Each
    of a_n and a_t is then a row: coefficients of the generators, then those of four accelerations that positively span R³
    (any acceleration is a sum of them with weights ≥ 0), and last the constant. A row is scaled by a positive number that
    removes its denominators.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        m, rho2, n = problem.mass, problem.rho2, problem.size
        pushes: list[Row] = []
        for i in range(n):
            mu, T, N = (
                problem.friction[i],
                problem.tangential_row(i),
                problem.normal_row(i),
            )
            for side in (1, -1):
                x, y, turn = (
                    a + side * mu * b for a, b in zip(N, T, strict=True)
                )  # M⁻¹(N ± μT)ᵀ
                pushes.append((x / m, y / m, turn / (m * rho2)))
        zero, one = Fraction(0), Fraction(1)
        pushes += [(one, zero, zero), (zero, one, zero), (zero, zero, one)]
        pushes.append((-one, -one, -one))
        self.spanning = [2 * n + k for k in range(4)]
        self.tangential: list[list[int]] = []
        self.normal: list[list[int]] = []
        scale = lcm(*(x.denominator for push in pushes for x in push))
        whole = [_times(push, scale) for push in pushes]
        for i in range(n):
            b_t, b_n = problem.bias[i]
            for rows, row, bias in (
                (self.tangential, problem.tangential_row(i), b_t),
                (self.normal, problem.normal_row(i), b_n),
            ):
                constant = _dot(row, problem.free_acceleration) + bias
                unit = lcm(*(x.denominator for x in row))
                x, y, turn = _times(row, unit)
                factor, unit = constant.denominator, unit * scale
                out = [factor * (x * a + y * b + turn * c) for a, b, c in whole]
                out.append(constant.numerator * unit)
                common = gcd(unit * factor, *out)
                rows.append([value // common for value in out])

    def generators(self, word: str) -> list[int]:
        """Columns of the generators of the closed contacts."""
        columns = []
        for i, letter in enumerate(word):
            columns += {
                "S": [],
                "F": [2 * i, 2 * i + 1],
                "L": [2 * i],
                "R": [2 * i + 1],
            }[letter]
        return columns

    def system(
        self, word: str, columns: list[int]
    ) -> tuple[list[list[int]], list[int]]:
        """The word's conditions as E x = f ≥ 0 on x = (λ, s, surpluses) ≥ 0.

        The constants are multiplied by a further unknown s > 0. This does not change whether a solution exists, and makes the
        conditions homogeneous. Hence "all of these are positive" becomes "all of these are at least 1", without a margin to
        maximise.
        """
        equal, positive = [], []
        for i, letter in enumerate(word):
            sliding = self.problem.sliding[i]
            if letter == "S":
                if sliding is not None:
                    positive.append(self.normal[i])
                continue
            equal.append(self.normal[i])
            if letter == "F":
                equal.append(self.tangential[i])
            elif sliding == 0:
                a_t = self.tangential[i]
                positive.append(a_t if letter == "R" else [-x for x in a_t])
        chosen, count = [*columns, -1], len(positive) + 1
        E = [[row[c] for c in chosen] + [0] * count for row in equal]
        picked = [[row[c] for c in chosen] for row in positive]
        picked.append([0] * len(columns) + [1])  # s itself
        for k, row in enumerate(picked):
            surplus = [0] * count
            surplus[k] = -1
            E.append(row + surplus)
        return E, [0] * len(equal) + [1] * count

    def is_possible(self, word: str) -> bool:
        """Whether some acceleration, with any forces, satisfies the conditions of the beginning of a word."""
        return nonnegative_solution(*self.system(word, self.spanning)) is not None

    def motion(self, word: str) -> Motion | None:
        """Forces and acceleration from weights of the generators."""
        problem, columns = self.problem, self.generators(word)
        x = nonnegative_solution(*self.system(word, columns))
        if x is None:
            return None
        scale = x[len(columns)]
        forces = [(Fraction(0), Fraction(0))] * problem.size
        qdd = list(problem.free_acceleration)
        inertia = (problem.mass, problem.mass, problem.mass * problem.rho2)
        for column, weight in zip(columns, x, strict=False):
            i, side = column // 2, 1 - 2 * (column % 2)
            f_n = weight / scale
            f_t = side * problem.friction[i] * f_n
            forces[i] = (forces[i][0] + f_t, forces[i][1] + f_n)
            T, N = problem.tangential_row(i), problem.normal_row(i)
            for k in range(3):
                qdd[k] += (f_t * T[k] + f_n * N[k]) / inertia[k]
        return Motion((qdd[0], qdd[1], qdd[2]), tuple(forces))


def nonnegative_solution(
    E: Sequence[Sequence[int]], f: Sequence[int]
) -> list[Fraction] | None:
    """Some x ≥ 0 with E x = f (integers, f ≥ 0), or None if there is none.

    The first phase of the simplex method, with Bland's rule against cycling. The tableau has integers over one common
    denominator, the last pivot (Edmonds): each division below is exact.
    """
    width = len(E[0])
    rows = [[*row, rhs] for row, rhs in zip(E, f, strict=True)]
    basis = [k - len(rows) for k in range(len(rows))]  # negative: artificial
    infeasibility = [sum(column) for column in zip(*rows, strict=True)]
    denominator = 1
    while infeasibility[-1]:
        enter = next((j for j in range(width) if infeasibility[j] > 0), None)
        if enter is None:
            return None
        leave = -1
        for i, row in enumerate(rows):
            if row[enter] <= 0:
                continue
            if leave >= 0:
                ratio = row[-1] * rows[leave][enter] - rows[leave][-1] * row[enter]
                if ratio > 0 or (ratio == 0 and basis[i] > basis[leave]):
                    continue
            leave = i
        pivot_row = rows[leave]
        pivot = pivot_row[enter]
        for row in (*rows, infeasibility):
            if row is pivot_row:
                continue
            factor = row[enter]
            if factor:
                row[:] = [
                    (x * pivot - factor * y) // denominator
                    for x, y in zip(row, pivot_row)  # noqa: B905
                ]
            elif pivot != denominator:
                row[:] = [x * pivot // denominator for x in row]
        denominator, basis[leave] = pivot, enter
    solution = [Fraction(0)] * width
    for column, row in zip(basis, rows, strict=True):
        if column >= 0:
            solution[column] = Fraction(row[-1], denominator)
    return solution


@dataclass(frozen=True)
class ForceFamily:
    """Forces of two fixed contacts: unique except for the internal force τ along the line ℓ = d_2 − d_1.

    τ = (f_1 − f_2)·ℓ / (2 ℓ·ℓ), in N/m: the force on contact 1 includes τℓ, that on contact 2 −τℓ. ``low`` and ``high`` bound
    τ; None: no bound on that side.
    """

    neutral: tuple[Pair, Pair]  # (f_t, f_n) at τ = 0
    per_squeeze: tuple[Pair, Pair]  # their change per unit of τ
    low: Fraction | None
    high: Fraction | None

    def forces(self, tau: Fraction) -> tuple[Pair, Pair]:
        """(f_t, f_n) of both contacts at the squeeze τ."""
        first, second = (
            (at[0] + tau * by[0], at[1] + tau * by[1])
            for at, by in zip(self.neutral, self.per_squeeze, strict=True)
        )
        return first, second


def force_interval_FF(problem: Problem) -> ForceFamily | None:
    """All forces of the word FF of two contacts at different places; None if there are none."""
    if problem.size != 2 or problem.arms[0] == problem.arms[1]:
        raise ValueError("two contacts at different places are needed")
    acceleration = _acceleration_FF(problem)
    if acceleration is None or problem.sliding != (0, 0):
        return None
    m, rho2, free = problem.mass, problem.rho2, problem.free_acceleration
    (ax, ay), (bx, by) = problem.arms
    px, py = (m * (acceleration[k] - free[k]) for k in (0, 1))
    torque = m * rho2 * (acceleration[2] - free[2])
    # p = f_1 + f_2 is halved; the remaining torque is balanced by opposite forces ± κ (ℓ_y, −ℓ_x).
    lx, ly = bx - ax, by - ay
    rest = torque - ((ax + bx) * py - (ay + by) * px) / 2
    kappa = rest / (lx * lx + ly * ly)
    # τ = 0 requires (f_1 − f_2)·ℓ = 0, which holds because the difference is perpendicular to ℓ.
    first, second = problem.tangents
    neutral = (
        _on_axes(first, (px / 2 + kappa * ly, py / 2 - kappa * lx)),
        _on_axes(second, (px / 2 - kappa * ly, py / 2 + kappa * lx)),
    )
    per_squeeze = _on_axes(first, (lx, ly)), _on_axes(second, (-lx, -ly))
    low: Fraction | None = None
    high: Fraction | None = None
    for i, mu in enumerate(problem.friction):
        (at_t, at_n), (by_t, by_n) = neutral[i], per_squeeze[i]
        for constant, slope in (
            (at_n, by_n),
            (mu * at_n - at_t, mu * by_n - by_t),
            (mu * at_n + at_t, mu * by_n + by_t),
        ):  # constant + slope τ ≥ 0
            if slope == 0:
                if constant < 0:
                    return None
                continue
            bound = -constant / slope
            if slope > 0:
                low = bound if low is None else max(low, bound)
            else:
                high = bound if high is None else min(high, bound)
    if low is not None and high is not None and low > high:
        return None
    return ForceFamily(neutral, per_squeeze, low, high)


def _on_axes(tangent: Pair, force: Pair) -> Pair:
    """(f_t, f_n) of a force in world axes; the tangent need not be exactly a unit vector."""
    (tx, ty), (x, y) = tangent, force
    norm2 = tx * tx + ty * ty
    return (x * tx + y * ty) / norm2, (y * tx - x * ty) / norm2


def _acceleration_FF(problem: Problem) -> Row | None:
    """The acceleration that holds both contacts, or None if their biases exclude it.

    In world axes contact i requires a + α × d_i = −β_i; the difference of the two gives α twice.
    """
    beta = []
    for (tx, ty), (b_t, b_n) in zip(problem.tangents, problem.bias, strict=True):
        norm2 = tx * tx + ty * ty
        beta.append(((b_t * tx - b_n * ty) / norm2, (b_t * ty + b_n * tx) / norm2))
    (ax, ay), (bx, by) = problem.arms
    lx, ly = bx - ax, by - ay
    gap_x, gap_y = beta[0][0] - beta[1][0], beta[0][1] - beta[1][1]
    alpha = (lx * gap_y - ly * gap_x) / (lx * lx + ly * ly)
    if (-ly * alpha, lx * alpha) != (gap_x, gap_y):
        return None
    return alpha * ay - beta[0][0], -alpha * ax - beta[0][1], alpha


def _dot(a: Row, b: Row) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def integers(row: Sequence[Fraction]) -> list[int]:
    """The row times the least positive number that removes its denominators."""
    return _times(row, lcm(*(x.denominator for x in row)))


def _times(row: Sequence[Fraction], scale: int) -> list[int]:
    """The row times a multiple of all its denominators."""
    return [x.numerator * (scale // x.denominator) for x in row]
