"""The time of importing the package, without the time of importing numpy, and the size of its wheel."""

import statistics
import subprocess
import sys
from pathlib import Path

WHEELS = Path(__file__).parent.parent / "target" / "wheels"
TIMED = "import time, numpy; start = time.perf_counter(); import standfast; print(time.perf_counter() - start)"


def main():
    times = [
        float(
            subprocess.run(
                [sys.executable, "-c", TIMED], capture_output=True, check=True
            ).stdout
        )
        for _ in range(15)
    ]
    print(
        f"import beyond numpy: {1e3 * statistics.median(times):.1f} ms (median of {len(times)})"
    )
    for wheel in WHEELS.glob("standfast-*.whl"):
        print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
