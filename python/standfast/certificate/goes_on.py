"""A motion goes on from every state of contact: the contacts are stiff, or the modes of the states in which they are not are given."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Any

from .exact import (
    inner,
    is_strictly_copositive,
    lines,
    rational,
    rationals,
    reduced,
    solution_near,
)
from .intervals import require
from .mechanism import Pad, Rows, couplings, places
from .scene import entry, power_of_two
from .words import SIDES

#: Largest number of interfaces with friction: there are 2^n pairs of signs.
MOST_INTERFACES = 8
#: Largest number of contacts of a well: there are 2^n sets of them.
MOST_IN_A_WELL = 10
#: Entries of A(σ) are rounded to the largest diagonal entry over this number.
ROUNDED = 2**80
#: Largest number of choices of rows that are tried for rays, or for slides.
MOST_CHOICES = 5000
#: Largest number of states of contact that are tried.
MOST_STATES = 2000

#: Closed contacts, by their places, and the sign of each interface, 0 where it does not slide or is open.
State = tuple[frozenset[int], tuple[int, ...]]


def directions(rows: Sequence[list[Fraction]]) -> list[list[Fraction]]:
    """Those of the rows that are not zero, each direction once."""
    found = {}
    for row in rows:
        lead = next((part for part in row if part), None)
        if lead is not None:
            found[tuple(part / lead for part in row)] = row
    return list(found.values())


def rays(rows: Rows) -> list[tuple[frozenset[int], list[Fraction]]]:
    """The extreme rays of K: the contacts that are closed, by their places, and the gaps. In the span of the rows N, of rank r, a ray closes r − 1 independent
    contacts."""
    axes, _ = reduced([foot.normal for foot in rows.feet])
    normals = [[inner(foot.normal, axis) for axis in axes] for foot in rows.feet]
    found = {}
    for z in lines(directions(normals), MOST_CHOICES):
        gaps = [inner(row, z) for row in normals]
        if len({gap > 0 for gap in gaps if gap}) == 1:
            closed = frozenset(k for k, gap in enumerate(gaps) if gap == 0)
            found[closed] = [abs(gap) for gap in gaps]
    return list(found.items())


def interfaces(feet: Sequence[Pad]) -> list[tuple[int, int]]:
    """The interface of each contact, and whether its row T is c > 0 (1) or c < 0 (-1) times that of the interface. Contacts without friction have none: (0, 0)."""
    leading: list[list[Fraction]] = []
    found = []
    for foot in feet:
        if foot.friction == 0 or not any(foot.tangent):
            found.append((0, 0))
            continue
        factors = (
            next(a / b for a, b in zip(foot.tangent, row, strict=True) if b)
            for row in leading
        )
        known = [
            (g, 1 if factor > 0 else -1)
            for g, (factor, row) in enumerate(zip(factors, leading, strict=True))
            if foot.tangent == [factor * part for part in row]
        ]
        if not known:
            leading.append(foot.tangent)
            known = [(len(leading) - 1, 1)]
        found.append(known[0])
    return found


@dataclass(frozen=True)
class Sliding:
    """The matrices A(σ) = N M⁻¹(N − σμT)ᵀ, with one sign for each interface: its contacts slide together, and only the sum of their friction acts."""

    rows: Rows
    #: As `interfaces`.
    of: tuple[tuple[int, int], ...]

    @cached_property
    def count(self) -> int:
        return max((g + 1 for g, side in self.of if side), default=0)

    @cached_property
    def parts(self) -> tuple[list[list[Fraction]], list[list[Fraction]], Fraction]:
        """N_iM⁻¹N_jᵀ, μ_j N_iM⁻¹T_jᵀ, and the unit to which entries are rounded."""
        feet = self.rows.feet
        normal = couplings(self.rows, [foot.normal for foot in feet])
        rubbing = couplings(self.rows, [foot.friction_row() for foot in feet])
        largest = max(normal[i][i] for i in range(len(feet)))
        return normal, rubbing, power_of_two(largest) / ROUNDED

    def sides(self, signs: Sequence[int]) -> list[int]:
        """The sign of each contact."""
        return [side and side * signs[g] for g, side in self.of]

    def touched(self, closed: frozenset[int]) -> list[int]:
        """The interfaces of these contacts."""
        return sorted({self.of[k][0] for k in closed if self.of[k][1]})

    def is_stiff(self, closed: frozenset[int], signs: Sequence[int]) -> bool:
        """Whether A(σ) of these contacts is strictly copositive. Entries are rounded down: it is enough if the smaller ones have this property."""
        normal, rubbing, unit = self.parts
        sides, own = self.sides(signs), sorted(closed)

        def entry_of(i: int, j: int) -> Fraction:
            both = normal[i][j] + normal[j][i]
            return Fraction(
                (both - sides[j] * rubbing[i][j] - sides[i] * rubbing[j][i]) // unit
            )

        return is_strictly_copositive([[entry_of(i, j) for j in own] for i in own])

    def loose_states(self) -> list[State]:
        """The states of contact in which A(σ) may not be strictly copositive, for the signs σ of the slides and any where there is none."""
        require(
            self.count <= MOST_INTERFACES and len(self.of) <= MOST_IN_A_WELL,
            f"the scene has {len(self.of)} contacts and {self.count} interfaces with friction; at most {MOST_IN_A_WELL} and {MOST_INTERFACES} are tried",
        )
        whole = frozenset(range(len(self.of)))
        all_signs = product((1, -1), repeat=self.count)
        loose = [signs for signs in all_signs if not self.is_stiff(whole, signs)]
        if not loose:
            return []
        faces = {whole}
        for closed, _ in rays(self.rows):
            faces |= {closed & face for face in faces} | {closed}
            require(
                len(faces) <= MOST_STATES, f"there are more than {MOST_STATES} faces"
            )
        found: set[State] = set()
        for closed in faces:
            own = self.touched(closed)
            for signs in {
                tuple(sign * (g in own) for g, sign in enumerate(signs))
                for signs in loose
            }:
                if self.is_stiff(closed, signs):
                    continue
                for still in product((0, 1), repeat=len(own)):
                    part = list(signs)
                    for g, moves in zip(own, still, strict=True):
                        part[g] *= moves
                    found.add((closed, tuple(part)))
                require(
                    len(found) <= MOST_STATES,
                    f"there are more than {MOST_STATES} states of contact",
                )
        return sorted(found, key=lambda state: (sorted(state[0]), state[1]))

    def letters(self, state: State) -> str:
        """R, L, or F (it does not slide, or has no friction) of each closed contact."""
        closed, signs = state
        return "".join("FRL"[self.sides(signs)[k]] for k in sorted(closed))


def sliding_of(rows: Rows) -> Sliding:
    return Sliding(rows, tuple(interfaces(rows.feet)))


def goes_on(rows: Rows, data: Any) -> None:
    """A(σ) is strictly copositive for all signs; or there is a lift, and in each state of contact in which it is not, a mode."""
    sliding = sliding_of(rows)
    states = sliding.loose_states()
    if not states:
        return
    vectors = [row for foot in rows.feet for row in (foot.tangent, foot.normal)]
    coupled = couplings(rows, [*vectors, rows.load], vectors)
    stated = data.get("modes", [])
    require(isinstance(stated, list), "data.modes is not a list")
    known = set()
    for n, one in enumerate(stated):
        where = f"data.modes[{n}]"
        own = places(rows, entry(one, "contacts", where))
        slides = entry(one, "slides", where)
        mode(rows, coupled, own, slides, one, where)
        known.add((frozenset(own), slides))
    for state in states:
        letters = sliding.letters(state)
        names = [rows.feet[k].name for k in sorted(state[0])]
        require(
            (state[0], letters) in known,
            f"contacts {names} may jam while they slide {letters}: N M⁻¹(N - σμT)ᵀ is not strictly copositive, and data.modes has no mode",
        )
    z = rationals(entry(data, "lift", "data"), len(rows.load), "data.lift")
    for foot in rows.feet:
        rise = min(inner(foot.edge(side), z) for side in (1, -1))
        require(
            rise > 0,
            f"N·z - μ|T·z| of contact {foot.name} is not positive: {float(rise):.6g}",
        )


def mode(
    rows: Rows,
    coupled: Sequence[Sequence[Fraction]],
    own: Sequence[int],
    slides: Any,
    stated: Any,
    where: str,
) -> None:
    """A mode of closed contacts that slide so: of its word, the forces near to those given obey the laws of contact."""
    word = entry(stated, "word", where)
    for key, text in (("slides", slides), ("word", word)):
        letters = {"slides": "FRL", "word": "SFRL"}[key]
        require(
            isinstance(text, str)
            and len(text) == len(own)
            and set(text) <= set(letters),
            f"{where}.{key} {text!r} has no letter of {letters} for each contact",
        )
    require(list(own) == sorted(own), f"{where}.contacts are not in order")
    given = entry(stated, "forces", where)
    require(
        isinstance(given, list) and len(given) == len(own),
        f"{where}.forces has no pair for each contact",
    )
    # Unknown forces as combinations of the columns, and the rates that are zero.
    columns: list[dict[int, Fraction]] = []
    zero, guess = [], []
    for k, letter, pair in zip(own, word, given, strict=True):
        t, n = (rational(part, f"{where}.forces") for part in _pair(pair, where))
        if letter == "S":
            continue
        zero.append(2 * k + 1)
        if letter == "F":
            columns.append({2 * k: Fraction(1)})
            guess.append(t)
            zero.append(2 * k)
        side = SIDES.get(letter, 0) * rows.feet[k].friction
        columns.append({2 * k + 1: Fraction(1), 2 * k: -side})
        guess.append(n)
    equations = [
        [
            sum((c * coupled[row][j] for j, c in column.items()), Fraction(0))
            for column in columns
        ]
        + [-coupled[row][-1]]
        for row in zero
    ]
    found = solution_near(equations, guess)
    require(found is not None, f"{where}: no forces of the word {word}")
    forces = [Fraction(0)] * (2 * len(rows.feet))
    for x, column in zip(found or [], columns, strict=True):
        for j, c in column.items():
            forces[j] += c * x
    for k, slide in zip(own, slides, strict=True):
        foot = rows.feet[k]
        along, rise = (
            inner([*forces, Fraction(1)], coupled[j]) for j in (2 * k, 2 * k + 1)
        )
        t, n = forces[2 * k], forces[2 * k + 1]
        limit = foot.friction * n
        moves = SIDES.get(slide) or (along > 0) - (along < 0)
        name = f"{where}: contact {foot.name}"
        require(n >= 0 and rise >= 0 and n * rise == 0, f"{name} is pulled, or falls")
        require(
            t == -moves * limit if moves else abs(t) <= limit,
            f"the friction of {name} is not that of its slide",
        )


def _pair(pair: Any, where: str) -> list[Any]:
    require(
        isinstance(pair, list) and len(pair) == 2,
        f"{where}.forces has no pair for each contact",
    )
    return list(pair)
