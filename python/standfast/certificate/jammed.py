"""No motion exists: contacts slide, and every word of them fails."""

from fractions import Fraction
from itertools import combinations
from typing import Any

from .exact import inner, rationals, solutions
from .intervals import require
from .mechanism import Rows, couplings, places
from .scene import entry
from .words import SIDES

#: Largest number of contacts that slide: there are 2^n words.
MOST_SLIDING = 8


def no_solution(rows: Rows, data: Any) -> None:
    """No motion exists from a start in which these contacts are closed and slide, and all others are open.

    Place and velocity are q and q̇ less their parts along M⁻¹N_iᵀ. With A = N M⁻¹(N − σμT)ᵀ and b = N M⁻¹load of the closed contacts, each set that stays closed
    has λ with A λ = −b, of which one is negative, or another contact would fall into the ground."""
    require(not rows.resolves_jams, "an impact ends a jam")
    own = places(rows, entry(data, "contacts", "data"))
    slides = entry(data, "slides", "data")
    require(
        isinstance(slides, str)
        and len(slides) == len(own)
        and set(slides) <= set(SIDES),
        f"data.slides {slides!r} has no letter R or L for each contact",
    )
    require(
        0 < len(own) <= MOST_SLIDING,
        f"data.contacts are {len(own)}; 1 to {MOST_SLIDING} are tried",
    )
    feet = [rows.feet[k] for k in own]
    sides = [SIDES[letter] for letter in slides]
    normals = [foot.normal for foot in feet]
    metric = couplings(rows, normals)
    between = [metric[k] for k in own]

    def closed(key: str) -> list[Fraction]:
        """q or q̇ without its parts along M⁻¹N_iᵀ."""
        vector = rationals(entry(data, key, "data"), len(rows.load), f"data.{key}")
        parts, _ = solutions(between, [[inner(row, vector) for row in normals]])
        away = [
            sum(
                (
                    c * row[k]
                    for c, row in zip((parts or [[]])[0], normals, strict=True)
                ),
                Fraction(0),
            )
            for k in range(len(vector))
        ]
        back, _ = solutions(rows.mass, [away])
        return [x - y for x, y in zip(vector, (back or [[]])[0], strict=True)]

    place, speed = closed("q"), closed("qdot")
    for k, foot in enumerate(rows.feet):
        gap = inner(foot.normal, place)
        require(
            k in own or gap > 0,
            f"the gap of contact {foot.name} is not positive: {float(gap):.6g}",
        )
    for foot, side in zip(feet, sides, strict=True):
        slip = side * inner(foot.tangent, speed)
        require(
            slip > 0 or foot.friction == 0,
            f"σ v_t of contact {foot.name} is not positive: {float(slip):.6g}",
        )
    rubbing = couplings(
        rows, [foot.edge(-side) for foot, side in zip(feet, sides, strict=True)]
    )
    matrix = [rubbing[k] for k in own]
    falls = [row[0] for row in couplings(rows, [rows.load])]
    falls = [falls[k] for k in own]
    for count in range(len(own) + 1):
        for stay in combinations(range(len(own)), count):
            word = "".join(slides[k] if k in stay else "S" for k in range(len(own)))
            # No equations at all have the empty solution.
            found, unique = solutions(
                [[matrix[i][j] for j in stay] for i in stay],
                [[-falls[i] for i in stay]],
            )
            if found is None:
                continue
            require(unique, f"the forces of the word {word} are not unique")
            rates = [
                falls[i] + inner([matrix[i][j] for j in stay], found[0])
                for i in range(len(own))
            ]
            require(
                min(found[0] + rates) < 0,
                f"the word {word} goes on from the slide of contacts {[foot.name for foot in feet]}",
            )
