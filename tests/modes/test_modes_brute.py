"""Contact modes of random problems against brute force over all words, in exact arithmetic.

STANDFAST_MODES_CASES sets the number of problems of each class (60). The seed does not depend on it: a larger campaign
contains the smaller one. ``pytest -s`` prints the properties of the classes.
"""

import math
import os
from collections import Counter
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np
import pytest
import standfast as sf
from modes_oracle import Problem, brute_force, force_interval_FF
from modes_problems import Case, is_representable
from modes_random import CLASSES, EDGES, FARTHEST, NEAREST, Draw, pair_at_rest, unit

CASES = int(os.environ.get("STANDFAST_MODES_CASES", "60"))
PAIRS = 2000
SEED = 2008
#: The TIE of the solver (crates/core/src/modes/answer.rs), which Python does not expose.
TIE = 1e-10
#: Parts of problems without a word and with several words that justify the name of a class.
SHARES = {"slender, sliding": (0.1, 0.1), "two at rest, high friction": (0, 0.05)}
#: Allowed rounding error of forces, relative to the load: about 10⁴ roundings of a double.
ROUNDING = 1e-12


def keywords(problem: Problem) -> dict[str, object]:
    """The arguments of ``standfast.ContactProblem``, exactly."""
    assert is_representable(problem), problem
    return Case("", "", problem).keywords


@dataclass
class Row:
    """Results of a class."""

    name: str
    counts: Counter[int] = field(default_factory=Counter)  # 2: two or more
    #: Words consistent by one method only, among all words of both methods: with the warning, and without.
    warned: int = 0
    wrong: list[object] = field(default_factory=list)

    def compare(self, problem: Problem) -> set[str]:
        """Solves the problem by both methods; the consistent words."""
        words = brute_force(problem)
        self.counts[min(len(words), 2)] += 1
        given = sf.ContactProblem(**keywords(problem))
        for method in ("auto", "enumerate"):
            modes = sf.contact_modes(given, method=method)
            for word in words.symmetric_difference(modes.consistent):
                if word in modes and is_tie(modes[word]):
                    self.warned += 1
                else:
                    self.wrong.append((problem, method, words, modes.consistent))
        return words

    def __str__(self) -> str:
        counts, n = self.counts, self.counts.total()
        shares = f"{counts[0]:7}{counts[1]:7}{counts[2]:9}"
        return f"{self.name:28}{n:9}{shares}{self.warned:9}{len(self.wrong):9}"


def is_tie(mode: sf.results.ContactMode) -> bool:
    """Whether a margin is a tie and the warning is given."""
    nearest = min((abs(margin) for _, _, margin in mode.margins), default=math.inf)
    return mode.near_degenerate and nearest <= TIE


@pytest.fixture(scope="module")
def table():
    rows: list[Row] = []
    yield rows
    header = ("class", "problems", "none", "one", "several", "warned", "wrong")
    print("\n{:28}{:>9}{:>7}{:>7}{:>9}{:>9}{:>9}".format(*header))
    for row in rows:
        print(row)


@pytest.mark.parametrize("name", CLASSES)
def test_words_are_those_of_brute_force(table, name):
    row, draw = Row(name), Draw(f"{SEED} {name}")
    table.append(row)
    sizes = Counter()
    for k in range(CASES):
        problem = CLASSES[name](draw, k)
        sizes[problem.size] += 1
        row.compare(problem)
    assert not row.wrong, row.wrong[0]
    assert not row.warned
    expected = {2} if "two" in name else {2, 3, 4} if "floor" in name else {1, 2, 3, 4}
    assert set(sizes) == expected
    for count, share in zip((0, 2), SHARES.get(name, (0, 0)), strict=True):
        assert row.counts[count] >= share * CASES


@pytest.mark.parametrize("name", EDGES)
def test_words_close_to_an_edge_differ_by_ties_only(table, name):
    row, draw = Row(name), Draw(f"{SEED} {name}")
    table.append(row)
    distances, sizes = [], Counter()
    for k in range(CASES):
        edge = EDGES[name](draw, k)
        sizes[edge.problem.size] += 1
        words = row.compare(edge.problem)
        # The edge is at the stated place: the word holds on one side of it.
        assert (edge.word in words) == (edge.distance > 0), edge
        distances.append(edge.distance)
    assert not row.wrong, row.wrong[0]
    assert row.warned  # the class has ties
    assert len(sizes) == (1 if "FF" in name else 3)
    powers = np.log10(np.abs(distances))
    # Two more powers, for the factors that load and friction are divided by.
    assert NEAREST - 2 < powers.min() < NEAREST + 1
    assert FARTHEST - 1 < powers.max() < FARTHEST + 2
    assert np.histogram(powers, 7, (NEAREST, FARTHEST))[0].min() >= 0.02 * CASES
    assert 0.3 < np.mean(np.greater(distances, 0)) < 0.7


def test_two_resting_contacts_offer_ten_words():
    """The words that some acceleration of a rigid body allows. If one contact is fixed, the other cannot slide."""
    draw, seen = Draw(f"{SEED} ten words"), Counter()
    alone = {"SS", "SF", "SR", "SL", "FS", "RS", "LS", "FF"}
    for k in range(PAIRS):
        problem = pair_at_rest(0, 3)(draw, k)
        # Both closed: the body rotates about the intersection of the normals, one way or the other.
        first, second = (np.array(problem.normal_row(i), float) for i in (0, 1))
        line = np.cross(first, second)
        slips = [np.array(problem.tangential_row(i), float) @ line for i in (0, 1)]
        together = {"RR", "LL"} if slips[0] * slips[1] > 0 else {"RL", "LR"}
        for method in ("auto", "enumerate"):
            modes = sf.contact_modes(
                sf.ContactProblem(**keywords(problem)), method=method
            )
            assert set(modes) == alone | together, problem
        seen["RR" in together] += 1
    assert min(seen[True], seen[False]) > 0.05 * PAIRS


def test_forces_of_two_fixed_contacts():
    """The interval of the internal force, and the smallest forces in it."""
    draw, ends = Draw(f"{SEED} intervals"), Counter()
    for k in range(PAIRS):
        problem = pair_at_rest(0, 3)(draw, k)
        if k % 2:  # normals in all directions
            tangents = draw.tangent(math.pi), draw.tangent(math.pi)
            problem = replace(problem, tangents=tangents)
        family = force_interval_FF(problem)
        given = sf.ContactProblem(**keywords(problem))
        for method in ("auto", "enumerate"):
            mode = sf.contact_modes(given, method=method)["FF"]
            assert mode.consistent == (family is not None), problem
            if family is None:
                continue
            span = math.dist(*problem.arms)  # τ is the force over this
            load = float(problem.mass * unit(problem))
            tau = Fraction(0)
            for found, end, sign in zip(
                mode.force_interval, (family.low, family.high), (-1, 1), strict=True
            ):
                ends[end is None] += 1
                if end is None:
                    assert found == sign * math.inf
                    continue
                tau = max(tau, end) if sign < 0 else min(tau, end)
                # A quotient whose denominator may be small, so its rounding error is large.
                worst = load * (1 + (float(end) * span / load) ** 2)
                assert abs(found - float(end) * span) <= ROUNDING * worst, problem
            worst = load * (1 + (float(tau) * span / load) ** 2)
            smallest = np.array(family.forces(tau), float)
            assert np.abs(mode.forces - smallest).max() <= ROUNDING * worst, problem
    assert min(ends.values()) > 0.05 * PAIRS, ends
