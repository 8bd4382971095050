"""How far is the guaranteed speed of a kick from the smallest kick that does not come back? A table in Markdown, as docs/maps.md has it: `make safe`.

Random bodies on three and four feet that stand in a well, and boxes on level ground, full model. Of each posture kicks in random directions, just below
`verdict.safe_speed`, all have to come back; then kicks of larger sizes, until one does not. With two numbers: postures, and kicks of each.
"""

import sys

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
    draw, postures: int, kicks: int, seed: int
) -> tuple[int, int, list[float]]:
    """Kicks below the guaranteed speed, how many did not come back, and the smallest size that did not, in units of that speed."""
    rng = np.random.default_rng(seed)
    done = failed = 0
    ratios = []
    while done < postures:
        posture = draw(rng)
        speed = sf.stability(posture).safe_speed
        if speed is None:
            continue
        done += 1
        options = {"seed": done, "impact": "newton"}
        below = sf.robustness(posture, [BELOW * speed], trials=kicks, **options)
        lost = kicks - int(np.count_nonzero(below.returned[0]))
        failed += lost
        if lost:
            print("not back:", posture, speed, below.outcomes)
        above = sf.robustness(
            posture, [f * speed for f in ABOVE], trials=SEARCHED, **options
        )
        far = np.flatnonzero(above.share < 1)
        ratios.append(ABOVE[far[0]] if len(far) else np.inf)
    return postures * kicks, failed, ratios


def main() -> None:
    postures, kicks = map(int, sys.argv[1:3]) if len(sys.argv) > 2 else (20, 200)
    cells = " | ".join(f"{factor:g}" for factor in ABOVE)
    print(f"| | kicks below | not back | lost at {cells} | none lost |")
    print("| --- " * (len(ABOVE) + 4) + "|")
    for name, draw, share in (("feet in a well", feet, 0.8), ("boxes", box, 0.2)):
        count, failed, ratios = measured(draw, int(share * postures), kicks, 1)
        at = [f"{np.mean([r <= factor for r in ratios]):.0%}" for factor in ABOVE]
        none = f"{np.mean(np.isinf(ratios)):.0%}"
        print(
            f"| {name} | {count} | {failed} | {' | '.join(at)} | {none} |", flush=True
        )


if __name__ == "__main__":
    main()
