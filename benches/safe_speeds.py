"""How far is the guaranteed speed of a kick from the smallest kick that does not come back? A table in Markdown, as docs/maps.md has it: `make safe`.

Random bodies on three and four feet that stand in a well, and boxes on level ground, full model. Of each posture kicks in random directions, just below
`verdict.safe_speed`, all have to come back; then kicks of larger sizes, until one does not. With two numbers: postures, and kicks of each.
"""

import sys
from collections.abc import Callable

import numpy as np
import standfast as sf

#: Sizes of kicks, in units of the guaranteed speed.
BELOW = 1 - 1e-6
ABOVE = (1.02, 1.05, 1.1, 1.2, 1.35, 1.5, 2.0, 3.0, 5.0)
#: Kicks of each size above the guaranteed one.
SEARCHED = 100


def box(rng: np.random.Generator) -> sf.Posture:
    return sf.Posture.box(
        rng.uniform(0.3, 1.5),
        1.0,
        friction=rng.uniform(0.2, 0.9),
        restitution=rng.uniform(0, 0.8),
    )


def feet(rng: np.random.Generator) -> sf.Posture:
    count = rng.integers(3, 5)
    contacts = []
    for k in range(count):
        x = -1 + 2 * k / (count - 1) + rng.uniform(-0.2, 0.2)
        place, slope = (x, rng.uniform(-0.2, 0.2)), rng.uniform(-0.6, 0.6)
        contacts.append(sf.Contact(place, slope=slope, friction=rng.uniform(0.1, 1.2)))
    return sf.Posture(
        mass=1,
        gyration_radius=rng.uniform(0.2, 1.5),
        center_of_mass=(rng.uniform(-0.6, 0.6), rng.uniform(0.3, 2)),
        contacts=contacts,
        restitution=rng.uniform(0, 0.8),
    )


def measured(
    draw: Callable[[np.random.Generator], sf.Posture],
    postures: int,
    kicks: int,
    seed: int,
) -> tuple[int, int, list[float]]:
    """How many kicks below the guaranteed speed did not come back, how many runs met the limit of events, and for each posture the smallest size that
    did not come back, in units of that speed."""
    rng = np.random.default_rng(seed)
    done = failed = endless = 0
    ratios = []
    while done < postures:
        posture = draw(rng)
        speed = sf.stability(posture).safe_speed
        if speed is None:
            continue
        done += 1
        options = {"seed": done, "impact": "newton"}
        below = sf.robustness(posture, [BELOW * speed], trials=kicks, **options)
        # Runs that meet the limit chatter at speeds of 1e-13 m/s, on a pair of feet that alone is unstable.
        [unended] = below.outcomes.get("event-limit", [0])
        [back] = np.count_nonzero(below.returned, axis=1)
        endless += int(unended)
        if back + unended < kicks:
            failed += kicks - int(back + unended)
            print("not back:", posture, speed, below.outcomes)
        sizes = [factor * speed for factor in ABOVE]
        above = sf.robustness(posture, sizes, trials=SEARCHED, **options)
        unended = above.outcomes.get("event-limit", 0)
        lost = np.count_nonzero(above.returned, axis=1) + unended < SEARCHED
        ratios.append(ABOVE[int(np.argmax(lost))] if lost.any() else np.inf)
    return failed, endless, ratios


def main() -> None:
    postures, kicks = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else (20, 200)
    head = " | ".join(f"{factor:g}" for factor in ABOVE)
    print(f"| | kicks below | not back | event limit | lost at {head} | none lost |")
    print("| --- " * (len(ABOVE) + 5) + "|")
    for name, draw, share in (("feet in a well", feet, 0.8), ("boxes", box, 0.2)):
        count = int(share * postures)
        failed, endless, ratios = measured(draw, count, kicks, 1)
        cells = [f"{count} × {kicks}", f"{failed}", f"{endless}"]
        cells += [f"{np.mean([r <= f for r in ratios]):.0%}" for f in ABOVE]
        cells += [f"{np.mean(np.isinf(ratios)):.0%}"]
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
