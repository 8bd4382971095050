"""Which bodies on random feet are left undecided, and which verdicts have certificates? Two tables in Markdown: `make feet`.

The first: feet at random places in |x| < 1, |y| < 0.6, with random slopes and frictions; of the postures whose contacts hold the body, the share that is undecided. The second: for
random feet and for special positions (boxes, rods, mirror images, rows of feet, stairs) how many decided verdicts have a certificate that its checker
accepts. Two numbers set how many postures each table has.
"""

import math
import sys
from collections import Counter
from collections.abc import Iterator

import numpy as np
import standfast as sf

#: Largest slope in rad, and limits of the friction.
DRAWS = ((1.2, (0.05, 1.0)), (0.4, (0.3, 0.9)))


def random_feet(
    rng: np.random.Generator, count: int, slope: float, friction: tuple[float, float]
) -> sf.Posture:
    places = rng.uniform([-1, -0.6], [1, 0.6], (count, 2))
    feet = [
        sf.Contact(
            (x, y), slope=rng.uniform(-slope, slope), friction=rng.uniform(*friction)
        )
        for x, y in places[np.argsort(places[:, 0])]
    ]
    return sf.Posture(
        mass=1,
        gyration_radius=rng.uniform(0.2, 1),
        center_of_mass=(rng.uniform(-1, 1), rng.uniform(0.1, 1.5)),
        contacts=feet,
        restitution=rng.uniform(0, 0.9),
    )


def special(rng: np.random.Generator, kind: int) -> sf.Posture:
    """A box, a rod, mirror images, a level row, a row on a slope, or stairs, with numbers of few digits."""
    friction = float(rng.choice([0.1, 0.3, 0.5, 0.8, 1.0]))
    common = {
        "friction": friction,
        "restitution": float(rng.choice([0, 0.3, 0.5, 0.8])),
    }
    if kind == 0:
        return sf.Posture.box(*rng.choice([0.3, 0.5, 1.0, 2.0], 2), **common)
    if kind == 1:
        return sf.Posture.rod(0.5, gyration_radius=rng.uniform(0.1, 0.6), **common)
    row = np.sort(rng.choice(np.arange(-8, 9), 3, replace=False)) / 8
    slope = float(rng.choice([0.1, 0.3, 0.5]))
    places = {
        2: [(-1, 0, -slope), (1, 0, slope)],
        3: [(x, 0, 0) for x in row],
        4: [(x, 0.25 * x, math.atan(0.25)) for x in row],
        5: [(-0.5, 0, 0), (0.5, 0.25, 0)],
    }[kind]
    return sf.Posture(
        mass=1,
        gyration_radius=0.4,
        center_of_mass=(0, float(rng.choice([0.3, 0.5, 1.0]))),
        contacts=[
            sf.Contact((x, y), slope=turn, friction=friction) for x, y, turn in places
        ],
        restitution=common["restitution"],
    )


def shares(count: int) -> None:
    print("| slopes, friction | 3 feet | 4 | 6 |\n| --- | --- | --- | --- |")
    for slope, friction in DRAWS:
        cells = []
        for feet in (3, 4, 6):
            rng, words = np.random.default_rng(7), Counter[str]()
            while words.total() < count:
                verdict = sf.stability(random_feet(rng, feet, slope, friction))
                if verdict.by != "not-equilibrium":
                    words[verdict.reason or "decided"] += 1
            open_ = {word: n for word, n in words.items() if word != "decided"}
            each = ", ".join(f"{word} {n}" for word, n in sorted(open_.items()))
            cells.append(f"{100 * sum(open_.values()) / count:.1f} % ({each})")
        name = f"±{slope}, {friction[0]} to {friction[1]}"
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def drawn(count: int) -> Iterator[tuple[str, sf.Posture]]:
    """As many random postures, and a quarter as many in special positions."""
    rng = np.random.default_rng(5)
    for k in range(count):
        feet = int(rng.choice([2, 2, 2, 3, 3, 4, 6]))
        slope = float(rng.choice([0.4, 1.2]))
        yield "random feet", random_feet(rng, feet, slope, (0.05, 1.0))
        if k % 4 == 0:
            yield "special positions", special(rng, k // 4 % 6)


def certificates(count: int) -> None:
    found: dict[str, Counter[str]] = {}
    for name, posture in drawn(count):
        verdict, counts = sf.stability(posture), found.setdefault(name, Counter())
        counts["all"] += 1
        if verdict.by is None:
            continue
        counts["decided"] += 1
        try:
            verdict.certificate()  # checks it, too
        except ValueError:
            continue
        counts["certificates"] += 1
    print("| | postures | decided | with a certificate |\n| --- | --- | --- | --- |")
    for name, counts in found.items():
        cells = [str(counts[key]) for key in ("all", "decided", "certificates")]
        print(f"| {name} | {' | '.join(cells)} |")


def main() -> None:
    first, second = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else (2000, 4000)
    shares(first)
    print()
    certificates(second)


if __name__ == "__main__":
    main()
