"""Tests of the oracle of contact modes: closed forms, symmetries, and a proof of each of its verdicts."""

import random
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from itertools import product

import modes_problems
import numpy as np
import pytest
from modes_oracle import (
    ALLOWED,
    Pair,
    Problem,
    Row,
    consistent_motions,
    consistent_words,
    find_motion,
    force_interval_FF,
    integers,
    nonnegative_solution,
    satisfies,
)
from modes_problems import CLASSES, Case, Draw, all_cases, build, stated_cases

ZERO, ONE = Fraction(0), Fraction(1)


def draw(purpose):
    return Draw(random.Random(purpose))


@pytest.mark.parametrize("case", stated_cases(), ids=lambda case: case.name)
def test_stated_answers(case):
    assert case.words == case.stated


# Proof of each verdict.


def conditions(problem: Problem, word: str):
    """Equations, weak and strict inequalities on (q̈, f_t1, f_n1, …, 1), by the definitions."""
    width = 3 + 2 * problem.size + 1
    inertia = (problem.mass, problem.mass, problem.mass * problem.rho2)

    def row(acceleration: Row, constant: Fraction, forces: dict[int, Fraction]):
        out = [*acceleration, *[ZERO] * (2 * problem.size), constant]
        for k, x in forces.items():
            out[k] = x
        assert len(out) == width
        return out

    def scaled(values, factor):
        return [factor * x for x in values]

    nothing = (ZERO, ZERO, ZERO)
    equal, weak, strict = [], [], [row(nothing, ONE, {})]
    for k in range(3):  # M (q̈ − free) − Σ (Tᵀ f_t + Nᵀ f_n) = 0
        unit = [ZERO] * 3
        unit[k] = inertia[k]
        forces = {}
        for i in range(problem.size):
            forces[3 + 2 * i] = -problem.tangential_row(i)[k]
            forces[4 + 2 * i] = -problem.normal_row(i)[k]
        constant = -inertia[k] * problem.free_acceleration[k]
        equal.append(row((unit[0], unit[1], unit[2]), constant, forces))
    for i, letter in enumerate(word):
        sliding, mu = problem.sliding[i], problem.friction[i]
        t, n = 3 + 2 * i, 4 + 2 * i
        a_t = row(problem.tangential_row(i), problem.bias[i][0], {})
        a_n = row(problem.normal_row(i), problem.bias[i][1], {})
        f_t, f_n = row(nothing, ZERO, {t: ONE}), row(nothing, ZERO, {n: ONE})
        if letter == "S":
            equal += [f_t, f_n]
            if sliding is not None:
                strict.append(a_n)
            continue
        equal.append(a_n)
        if letter == "F":
            equal.append(a_t)
            weak += [row(nothing, ZERO, {t: s, n: mu}) for s in (ONE, -ONE)]
            weak.append(f_n)
            continue
        side = ONE if letter == "R" else -ONE
        equal.append(row(nothing, ZERO, {t: ONE, n: side * mu}))
        weak.append(f_n)
        if sliding == 0:
            strict.append(scaled(a_t, side))
    return equal, weak, strict


def is_refuted(problem: Problem, word: str) -> bool:
    """Whether multipliers exist that sum the conditions of the word to 0 > 0 [Motzkin].

    Any multipliers of the equations, ≥ 0 of the inequalities, not all 0 of the strict ones. The sum
    is checked here; how the multipliers were found does not matter.
    """
    equal, weak, strict = conditions(problem, word)
    columns = [
        *equal,
        *([-x for x in row] for row in equal),
        *weak,
        *strict,
    ]
    E = [integers(entries) for entries in zip(*columns, strict=True)]
    E.append([0] * (len(columns) - len(strict)) + [1] * len(strict))
    weights = nonnegative_solution(E, [0] * (len(E) - 1) + [1])
    if weights is None:
        return False
    assert min(weights) >= 0
    assert sum(weights[-len(strict) :]) > 0
    weights = integers(weights)
    for entries in E[:-1]:
        assert sum(w * x for w, x in zip(weights, entries, strict=True)) == 0
    return True


@pytest.mark.parametrize("kind", ["stated", *CLASSES])
def test_each_verdict_is_proved(kind):
    """For each word either a motion that satisfies the definitions, or multipliers that contradict them; never both.

    For larger problems, with up to 64 or 256 words each, a random selection of words.
    """
    rng = random.Random(kind)
    for case in (case for case in all_cases() if case.kind == kind):
        motions = consistent_motions(case.problem)
        words = list(case.problem.words())
        assert set(motions) == case.words <= set(words)
        if len(words) > 16:
            words = [*motions, *rng.sample(words, 12)]
        for word in words:
            if word in motions:
                assert satisfies(case.problem, word, motions[word]), (case, word)
            assert is_refuted(case.problem, word) == (word not in motions), (case, word)
            assert (find_motion(case.problem, word) is None) == (word not in motions)


# Closed forms.


def single(sliding: int, mu: Fraction, a: Pair, W: tuple[Fraction, ...]) -> set[str]:
    """The words of one contact with a = (a_t, a_n) without forces, W = (w_tt, w_tn, w_nn) = J M⁻¹ Jᵀ."""
    (a_t, a_n), (w_tt, w_tn, w_nn) = a, W
    words = {"S"} if a_n > 0 else set()
    for letter, side in (("R", 1), ("L", -1)):
        if sliding == -side:
            continue
        P = w_nn - side * mu * w_tn  # a_n = a_n0 + P f_n
        slope = w_tn - side * mu * w_tt  # a_t = a_t0 + slope f_n
        if P != 0:
            f_n = -a_n / P
            if f_n >= 0 and (sliding or side * (a_t + slope * f_n) > 0):
                words.add(letter)
        elif a_n == 0 and (sliding or side * a_t > 0 or side * slope > 0):
            words.add(letter)
    if sliding == 0:
        det = w_tt * w_nn - w_tn * w_tn
        f_t = -(w_nn * a_t - w_tn * a_n) / det
        f_n = -(w_tt * a_n - w_tn * a_t) / det
        if abs(f_t) <= mu * f_n:
            words.add("F")
    return words


def test_one_contact_in_closed_form():
    d, seen = draw("one contact"), Counter()
    for _ in range(3000):
        (x, y), mu, rho2 = d.arm(), d.grid(0, 3, "1/2"), d.grid(0.25, 2, "1/4")
        tangent, sliding = d.tangent(), d.rng.choice((-1, 0, 1))
        problem = build(
            [(x, y)],
            [tangent],
            [mu],
            [sliding],
            spin2=d.grid(0, 2, "1/2"),
            free=(d.grid(-1, 1, "1/2"), d.grid(-1, 1, "1/2"), d.grid(-1, 1, "1/2")),
            mass=Fraction(2),
            rho2=rho2,
        )
        (tx, ty), (b_t, b_n) = tangent, problem.bias[0]
        b, c = tx * x + ty * y, tx * y - ty * x  # t·d, n·d
        ax, ay, turn = problem.free_acceleration
        a = (tx * ax + ty * ay - c * turn + b_t, tx * ay - ty * ax + b * turn + b_n)
        W = ((1 + c * c / rho2) / 2, -b * c / rho2 / 2, (1 + b * b / rho2) / 2)
        expected = single(sliding, mu, a, W)
        assert consistent_words(problem) == expected, problem
        seen[len(expected)] += 1
    assert min(seen[0], seen[1], seen[2]) > 20, seen


def test_a_body_on_two_legs():
    """A symmetric body at rest on a floor: FF for any friction. With horizontal load a: sliding if a > μ g."""
    legs, flat = [(-ONE, -ONE), (ONE, -ONE)], [modes_problems.FLAT] * 2
    for mu in (ZERO, Fraction(1, 4)):
        for pull in (ZERO, Fraction(1, 8), Fraction(1, 4), Fraction(3, 8)):
            problem = build(legs, flat, [mu] * 2, [0, 0], free=(pull, -ONE, ZERO))
            assert consistent_words(problem) == {"FF" if pull <= mu else "RR"}


def test_hyperstatic_floors():
    """Four contacts on one line carry the load in a three-parameter family; one of them may be listed twice."""
    for places in ((-2, -1, 1, 2), (-1, -1, 1, 1), (0, 0, 0, 0)):
        arms = [(Fraction(x), -ONE) for x in places]
        for sliding, word in ((0, "FFFF"), (1, "RRRR"), (-1, "LLLL")):
            problem = build(
                arms,
                [modes_problems.FLAT] * 4,
                [Fraction(1, 4)] * 4,
                [sliding] * 4,
                rho2=ONE,
            )
            assert consistent_words(problem) == {word}, (places, sliding)


def test_no_contact_closed():
    problem = build(
        [(ZERO, -ONE)] * 3, [modes_problems.FLAT] * 3, [ONE] * 3, [None] * 3
    )
    assert consistent_words(problem) == {"SSS"}


def test_forces_of_two_fixed_contacts():
    """Within the interval of the internal force the contacts hold the body; outside they slip."""
    seen, d = Counter(), draw("squeezed")
    wedges = [
        Case(f"wedge {k}", "squeezed", CLASSES["squeezed"](d, k))
        for k in range(0, 400, 2)
    ]
    for case in (*all_cases(), *wedges):
        problem = case.problem
        if problem.size != 2 or problem.arms[0] == problem.arms[1]:
            continue
        family = force_interval_FF(problem)
        assert (family is not None) == ("FF" in case.words), case
        if family is None:
            continue
        motion = consistent_motions(problem)["FF"]
        (ax, ay), (bx, by) = problem.arms
        chord = bx - ax, by - ay
        push = []
        for (tx, ty), (f_t, f_n) in zip(problem.tangents, motion.forces, strict=True):
            push.append((f_t * tx - f_n * ty, f_t * ty + f_n * tx))
        along = sum((f - g) * x for f, g, x in zip(*push, chord, strict=True))
        found = along / (2 * sum(x * x for x in chord))
        assert family.forces(found) == motion.forces
        for end, outwards in ((family.low, -1), (family.high, 1)):
            far = Fraction(outwards * 10**6) if end is None else end
            held = replace(motion, forces=family.forces(far))
            assert satisfies(problem, "FF", held), case
            assert outwards * (far - found) >= 0
            seen[end is None] += 1
            if end is not None:
                slipped = family.forces(far + Fraction(outwards, 10**12))
                assert not satisfies(problem, "FF", replace(motion, forces=slipped))
    assert seen[False] > 50, seen
    assert seen[True] > 5, seen


def test_squeeze_between_two_walls():
    """A body of weight 1 between walls, μ = 1/2: the normal force is at least 1, hence τ ≥ 1/2, without upper bound."""
    walls = [(ZERO, -ONE), (ZERO, ONE)]  # normals to the right and to the left
    problem = build([(-ONE, ZERO), (ONE, ZERO)], walls, [Fraction(1, 2)] * 2, [0, 0])
    family = force_interval_FF(problem)
    assert (family.low, family.high) == (Fraction(1, 2), None)
    half = Fraction(1, 2)
    assert family.forces(half) == ((-half, ONE), (half, ONE))


# Symmetries.


def mirrored(problem: Problem) -> Problem:
    """The problem mirrored, x → −x: tangential quantities change their sign."""
    x, y, turn = problem.free_acceleration
    return replace(
        problem,
        arms=tuple((-dx, dy) for dx, dy in problem.arms),
        tangents=tuple((tx, -ty) for tx, ty in problem.tangents),
        sliding=tuple(None if s is None else -s for s in problem.sliding),
        bias=tuple((-b_t, b_n) for b_t, b_n in problem.bias),
        free_acceleration=(-x, y, -turn),
    )


def turned(problem: Problem) -> Problem:
    """The problem rotated by the angle of (20, 21, 29)."""
    cos, sin = Fraction(20, 29), Fraction(21, 29)

    def turn(v: Pair) -> Pair:
        return cos * v[0] - sin * v[1], sin * v[0] + cos * v[1]

    x, y, alpha = problem.free_acceleration
    return replace(
        problem,
        arms=tuple(turn(d) for d in problem.arms),
        tangents=tuple(turn(t) for t in problem.tangents),
        free_acceleration=(*turn((x, y)), alpha),
    )


def rescaled(problem: Problem) -> Problem:
    """The problem in other units of length, of mass, and of acceleration and bias, which have a unit of their own."""
    size, pull = Fraction(7, 3), Fraction(5, 11)
    x, y, alpha = problem.free_acceleration
    return replace(
        problem,
        mass=13 * problem.mass,
        rho2=size * size * problem.rho2,
        arms=tuple((size * dx, size * dy) for dx, dy in problem.arms),
        bias=tuple((pull * b_t, pull * b_n) for b_t, b_n in problem.bias),
        free_acceleration=(pull * x, pull * y, pull * alpha / size),
    )


def reordered(problem: Problem) -> Problem:
    """The problem with the last contact first."""
    return replace(
        problem,
        arms=problem.arms[::-1],
        tangents=problem.tangents[::-1],
        friction=problem.friction[::-1],
        sliding=problem.sliding[::-1],
        bias=problem.bias[::-1],
    )


@pytest.mark.parametrize("kind", ["stated", *CLASSES])
def test_symmetries(kind):
    swap = str.maketrans("RL", "LR")
    for case in (case for case in all_cases() if case.kind == kind):
        mirror = {word.translate(swap) for word in case.words}
        assert consistent_words(mirrored(case.problem)) == mirror, case
        assert consistent_words(turned(case.problem)) == case.words, case
        assert consistent_words(rescaled(case.problem)) == case.words, case
        reverse = {word[::-1] for word in case.words}
        assert consistent_words(reordered(case.problem)) == reverse, case


def test_at_rest_a_mode_always_exists():
    d = draw("at rest")
    problems = [
        build(
            [d.arm(below=False) for _ in range(n)],
            [d.any_tangent() for _ in range(n)],
            [d.grid(0, 4) for _ in range(n)],
            [0] * n,
            free=d.load(),
            **d.body(),
        )
        for n in (1, 2, 2, 3) * 50
    ]
    problems += [
        case.problem
        for case in all_cases()
        if case.problem.level == "acceleration"
        and not any(x for pair in case.problem.bias for x in pair)
        and all(not sliding for sliding in case.problem.sliding)
    ]
    assert len(problems) > 300
    for problem in problems:
        assert consistent_words(problem), problem


def test_without_any_load_a_body_at_rest_stays():
    d = draw("no load")
    for n in (1, 2, 3):
        arms, tangents = d.contacts(n)
        free = modes_problems.WEIGHTLESS
        problem = build(arms, tangents, [ONE] * n, [0] * n, free=free)
        assert consistent_words(problem) == {"F" * n}


# Another method: linear algebra in doubles.

#: Quantities below this are not decided in doubles; such problems are left out.
DOUBT = 1e-7


class Doubtful(Exception):
    """A quantity is too close to its bound for doubles."""


def clearly_positive(x):
    if abs(x) < DOUBT:
        raise Doubtful
    return x > 0


def words_in_doubles(problem: Problem) -> set[str]:
    """Up to two contacts, word by word: solve for the forces and check the signs."""
    n = problem.size
    inertia = float(problem.mass) * np.array([1, 1, float(problem.rho2)])
    J = np.array(
        [
            [float(x) for x in row]
            for i in range(n)
            for row in (problem.tangential_row(i), problem.normal_row(i))
        ]
    )
    W = (J / inertia) @ J.T
    free = np.array([float(x) for x in problem.free_acceleration])
    a0 = J @ free + np.array([float(x) for pair in problem.bias for x in pair])
    allowed = [ALLOWED[s] for s in problem.sliding]
    return {
        "".join(word)
        for word in product(*allowed)
        if holds_in_doubles(problem, word, W, a0)
    }


def holds_in_doubles(problem, word, W, a0):
    columns, equal = [], []  # force combinations; zero accelerations
    for i, letter in enumerate(word):
        mu, unit = float(problem.friction[i]), np.eye(len(a0))
        if letter == "F":
            columns += [unit[2 * i], unit[2 * i + 1]]
            equal += [2 * i, 2 * i + 1]
        elif letter != "S":
            side = 1 if letter == "R" else -1
            columns.append(unit[2 * i + 1] - side * mu * unit[2 * i])
            equal.append(2 * i + 1)
    B = np.array(columns).reshape(len(columns), len(a0)).T
    A, rhs = (W @ B)[equal], -a0[equal]
    if not columns:
        return signs_in_doubles(problem, word, np.zeros(len(a0)), a0)
    singular = np.linalg.svd(A, compute_uv=False)
    x = np.linalg.lstsq(A, rhs, rcond=1e-10)[0]
    if word == ("F", "F"):
        if np.abs(A @ x - rhs).max() > DOUBT:
            return False
        squeeze = np.linalg.svd(A)[2][3]  # the direction without motion
        return squeeze_in_doubles(problem, x, squeeze)
    if singular[-1] < DOUBT:
        raise Doubtful
    return signs_in_doubles(problem, word, B @ x, a0 + W @ B @ x)


def signs_in_doubles(problem, word, f, a):
    for i, letter in enumerate(word):
        sliding, mu = problem.sliding[i], float(problem.friction[i])
        f_t, f_n, a_t, a_n = f[2 * i], f[2 * i + 1], a[2 * i], a[2 * i + 1]
        tests = {
            "S": [a_n] if sliding is not None else [],
            "F": [mu * f_n - abs(f_t), f_n],
            "R": [f_n] if sliding else [f_n, a_t],
            "L": [f_n] if sliding else [f_n, -a_t],
        }[letter]
        if not all(clearly_positive(x) for x in tests):
            return False
    return True


def squeeze_in_doubles(problem, x, squeeze):
    low, high = -np.inf, np.inf
    for i in (0, 1):
        mu = float(problem.friction[i])
        for row in ((1.0, mu), (-1.0, mu), (0.0, 1.0)):
            value = np.dot(row, x[2 * i : 2 * i + 2])
            slope = np.dot(row, squeeze[2 * i : 2 * i + 2])
            if abs(slope) < DOUBT:
                if not clearly_positive(value):
                    return False
            elif slope > 0:
                low = max(low, -value / slope)
            else:
                high = min(high, -value / slope)
    return clearly_positive(high - low)


def test_linear_algebra_in_doubles_agrees():
    d, decided, counts = draw("doubles"), 0, Counter()
    kinds = [kind for kind in CLASSES if "sought" not in kind]
    for k in range(3000):
        problem = CLASSES[kinds[k % len(kinds)]](d, k // len(kinds))
        if problem.size > 2:
            continue
        try:
            rough = words_in_doubles(problem)
        except Doubtful:
            continue
        decided += 1
        counts[min(len(rough), 2)] += 1
        assert consistent_words(problem) == rough, problem
    assert decided > 600, decided
    assert min(counts.values()) > 30, counts


# The collection of problems.


def test_the_problems_are_many_different_and_always_the_same():
    assert len({case.name for case in all_cases()}) == len(all_cases()) >= 400
    by_name = {case.name: case.problem for case in all_cases()}
    for case in all_cases(per_class=4):  # more cases extend the fewer
        assert by_name[case.name] == case.problem
    count = Counter(min(len(case.words), 2) for case in all_cases())
    assert count[0] > len(all_cases()) / 12, count
    assert count[2] > len(all_cases()) / 6, count
    assert {case.problem.size for case in all_cases()} == {1, 2, 3, 4}
    assert any(case.delicate for case in all_cases() if case.kind == "stated")
    used = {letter for case in all_cases() for word in case.words for letter in word}
    assert used == set("SFRL")


def test_problems_in_doubles_are_the_problems():
    """Tangents are unit vectors. Where no number had to be rounded, the doubles equal the rationals."""
    exact = 0
    for case in all_cases():
        problem, keywords = case.problem, case.keywords
        assert all(tx * tx + ty * ty == 1 for tx, ty in problem.tangents)
        if not modes_problems.is_representable(problem):
            continue
        exact += 1
        back = build(
            [tuple(map(Fraction, d)) for d in keywords["arms"]],
            [tuple(map(Fraction, t)) for t in keywords["tangents"]],
            [Fraction(mu) for mu in keywords["friction"]],
            keywords["sliding"],
            bias=[tuple(map(Fraction, b)) for b in keywords["bias"]],
            free=tuple(map(Fraction, keywords["free_acceleration"])),
            mass=Fraction(keywords["mass"]),
            rho2=Fraction(keywords["gyration_radius"]) ** 2,
            level=keywords["level"],
        )
        assert back == problem
        assert not case.delicate
    assert exact > 100


def test_the_verdict_changes_at_the_painleve_threshold():
    """The uniform rod, at μ = 4/3 and on either side of it, at decreasing distances."""
    at = next(c.problem for c in all_cases() if c.name == "uniform rod at 4/3")
    for k in range(1, 30):
        step = Fraction(1, 10**k)
        less = replace(at, friction=(Fraction(4, 3) - step,))
        more = replace(at, friction=(Fraction(4, 3) + step,))
        assert consistent_words(less) == {"L"}
        assert consistent_words(more) == set()
    assert consistent_words(at) == set()
