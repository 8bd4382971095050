"""A map of a million postures on one thread, on all cores, and on a Dask cluster of this machine with a process for each core: `make sweeps`.

The postures are those of part (b) of examples/third_figure.py, the quantities `stability`, `by` and `reason`. The time covers the whole
call of `sf.sweep`; beside it is the CPU time of all threads and workers together. The results must have the same bits.
"""

import os
import runpy
import sys
import time
from pathlib import Path

import distributed
import numpy as np
import standfast as sf

EXAMPLE = Path(__file__).parent.parent / "examples" / "third_figure.py"
POINTS = 1000


def main() -> None:
    """Each in turn, beside the first."""
    points = int(sys.argv[1]) if len(sys.argv) > 1 else POINTS
    posture = runpy.run_path(str(EXAMPLE))["vee"](0.4)
    over = {
        "center_of_mass.x": np.linspace(-1.3, 1.3, points),
        "center_of_mass.y": np.linspace(-1.0, 3.0, points),
    }

    def measured(name, used=time.process_time, **where):
        begun, before = time.perf_counter(), used()
        grid = sf.sweep(
            posture, over, ["stability", "by", "reason"], progress=False, **where
        )
        took, cores = time.perf_counter() - begun, used() - before
        print(
            f"{name}: {points} x {points} postures in {took:.1f} s"
            f" ({cores:.1f} s of all cores together, {1e6 * cores / points**2:.1f} µs a posture)"
        )
        return grid

    sf.sweep(posture, {"mass": [1.0]}, "theorem_3")  # imports xarray
    one = measured("one thread", threads=1)
    cores = os.cpu_count() or 1
    assert one.identical(measured(f"{cores} threads"))
    with (
        distributed.LocalCluster(
            n_workers=cores, threads_per_worker=1, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):

        def of_all():
            return time.process_time() + sum(client.run(time.process_time).values())

        name, executor = f"Dask, {cores} processes", client.get_executor()
        assert one.identical(measured(name, of_all, executor=executor, chunk=10_000))


if __name__ == "__main__":
    main()
