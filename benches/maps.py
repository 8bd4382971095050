"""Time of a map of 500 x 500 postures, and the share of it that is undecided: `make maps`.

The postures are those of examples/third_figure.py. In part (b) Theorem 3 decides a third of the equilibria. In part (a) it decides
one in twenty, so that nearly all need the corner map. In part (c), where jams end by impacts, the corner map decides the postures that
are unstable by a jam in (b). The time covers the whole call of `sf.sweep` on all cores. The CPU time of all cores together is shown
beside it.
"""

import runpy
import sys
import time
from pathlib import Path

import numpy as np
import standfast as sf

EXAMPLE = Path(__file__).parent.parent / "examples" / "third_figure.py"
POINTS = 500
#: A restitution at which the impacts of a flight are chaotic.
BOUNCY = 0.8


def measure(posture: sf.Posture, points: int, jams: str) -> None:
    """Time Theorem 3 alone, then the whole verdict with its argument and its reason."""
    over = {
        "center_of_mass.x": np.linspace(-1.3, 1.3, points),
        "center_of_mass.y": np.linspace(-1.0, 3.0, points),
    }
    grids = {}
    for quantity in (["theorem_3", "equilibrium"], ["stability", "by", "reason"]):
        begun, used = time.perf_counter(), time.process_time()
        grids[quantity[0]] = sf.sweep(
            posture, over, quantity, jams=jams, progress=False
        )
        wall, cores = time.perf_counter() - begun, time.process_time() - used
        print(
            f"{quantity[0]}: {points} x {points} postures in {wall:.2f} s ({cores:.2f} s of all cores together)"
        )
    theorem = grids["theorem_3"]
    equilibria = int(theorem["equilibrium"].sum())
    before = int((theorem["equilibrium"] & ~theorem["theorem_3"]).sum())
    after = int((grids["stability"]["stability"] == "undecided").sum())
    for text, count in (("by Theorem 3", before), ("by all tests", after)):
        print(
            f"undecided {text}: {100 * count / equilibria:.2f} % of the equilibria,"
            f" {100 * count / points**2:.2f} % of the map"
        )


def main() -> None:
    """Parts (b), (a) and (c), and the bodies of (b) and (a) at a large restitution."""
    points = int(sys.argv[1]) if len(sys.argv) > 1 else POINTS
    example = runpy.run_path(str(EXAMPLE))
    # A first call imports xarray, so that the timed calls do not.
    sf.sweep(example["vee"](0.4), {"mass": [1.0]}, "theorem_3")
    for part in ("b", "a", "c"):
        radius, jams = example["PANELS"][part]
        print(f"part ({part}), radius of gyration {radius}, jams={jams!r}")
        measure(example["vee"](radius), points, jams)
    for radius in (0.4, 0.8):
        print(f"radius of gyration {radius}, restitution {BOUNCY}, jams='none'")
        measure(example["vee"](radius, BOUNCY), points, "none")


if __name__ == "__main__":
    main()
