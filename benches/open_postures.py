"""Which postures are left undecided, and why? A table in Markdown, as docs/maps.md has it: `make maps`.

The body stands in the V of examples/third_figure.py, for several radii of gyration ρ and restitutions e. The centre of mass takes 120 x 120
places at -1 ≤ y ≤ 3 and |x| < 289/300, inside the border of the equilibria: on the border forces hold the body by a tie. The
table has the share of these postures that Theorem 3 leaves undecided, and the share that all arguments leave undecided; in brackets the
number of postures for each reason, of all 14 400. It takes 22 s on two free cores.
"""

import runpy
import time
from pathlib import Path

import numpy as np
import standfast as sf
import xarray

EXAMPLE = Path(__file__).parent.parent / "examples" / "third_figure.py"
POINTS = 120
#: Largest |x| of an equilibrium, in m.
BORDER = 289 / 300
RADII = (0.8, 0.4)
RESTITUTIONS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.8, 0.9)
HEAD = (
    "ρ",
    "e",
    "undecided by Theorem 3",
    'by all arguments, `jams="none"`',
    '`jams="impact"`',
)


def verdicts(posture: sf.Posture, points: int, jams: str) -> xarray.Dataset:
    """Verdicts at centres of mass inside the border."""
    over = {
        "center_of_mass.x": np.linspace(-BORDER, BORDER, points + 2)[1:-1],
        "center_of_mass.y": np.linspace(-1.0, 3.0, points),
    }
    names = ["theorem_3", "stability", "reason"]
    return sf.sweep(posture, over, names, jams=jams, progress=False)


def share(found: xarray.Dataset) -> str:
    """The share of the undecided postures, and their number for each reason."""
    undecided = found["stability"].values == "undecided"
    reasons, counts = np.unique(found["reason"].values[undecided], return_counts=True)
    each = ", ".join(f"{reason} {n}" for reason, n in zip(reasons, counts, strict=True))
    return f"{100 * undecided.mean():.2f} %" + (f" ({each})" if each else "")


def row(radius: float, restitution: float, points: int = POINTS) -> str:
    """A row of the table."""
    vee = runpy.run_path(str(EXAMPLE))["vee"]
    posture = vee(radius, restitution)
    found = {jams: verdicts(posture, points, jams) for jams in ("none", "impact")}
    theorem = 1.0 - float(found["none"]["theorem_3"].mean())
    cells = [
        f"{radius}",
        f"{restitution:g}",
        f"{100 * theorem:.1f} %",
        share(found["none"]),
        share(found["impact"]),
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Print the table row by row, then the time."""
    print(f"| {' | '.join(HEAD)} |\n|{' --- |' * len(HEAD)}")
    begun, used = time.perf_counter(), time.process_time()
    for radius in RADII:
        for restitution in RESTITUTIONS:
            print(row(radius, restitution), flush=True)
    wall, cores = time.perf_counter() - begun, time.process_time() - used
    print(f"\n{wall:.0f} s ({cores:.0f} s of all cores together)")


if __name__ == "__main__":
    main()
