"""Installs a built wheel in a new environment of each Python and tries it there: `python tests/pythons.py FOLDER [PYTHON ...]`.

FOLDER holds one wheel. Without further arguments it is tried in the Python that runs this file. No compiler can be used: the path of
programs is empty. In each Python it runs the tests of known answers, and compares the bits of 11 000 scenes with tests/data/bits.txt.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

TESTS = Path(__file__).resolve().parent
# Tests of the answers and of the package as it is installed that need no other packages than pytest, mpmath and those of the
# extras `map` and `plot`.
QUICK = [
    "modes/test_modes.py",
    "motion/test_known_answers.py",
    "motion/test_plastic.py",
    "motion/test_reference.py",
    "python_api/test_messages.py",
    "python_api/test_zero.py",
]


def try_wheel(wheel: Path, python: str) -> None:
    """Raises CalledProcessError if the wheel does not pass in this Python."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([python, "-m", "venv", folder], check=True)
        own = Path(folder, "Scripts" if os.name == "nt" else "bin", "python")
        # Windows needs SYSTEMROOT to start a program.
        bare = {
            name: os.environ[name]
            for name in ("HOME", "SYSTEMROOT", "TEMP")
            if name in os.environ
        }
        bare |= {
            name: value for name, value in os.environ.items() if name.startswith("PIP_")
        }

        def run(*arguments: object) -> None:
            command = [str(own), *map(str, arguments)]
            subprocess.run(command, check=True, env=bare, cwd=folder)

        install = ("-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        run(*install, wheel)
        run("-c", "import standfast")
        run(*install, f"{wheel}[map,plot]", "mpmath", "pytest")
        settings = TESTS.parent / "pyproject.toml"
        run("-m", "pytest", "-q", "-c", settings, *(TESTS / test for test in QUICK))
        run(TESTS / "bits.py")


def main() -> None:
    (wheel,) = Path(sys.argv[1]).resolve().glob("*.whl")
    for python in sys.argv[2:] or [sys.executable]:
        try_wheel(wheel, python)
        print(f"{wheel.name} passes in {python}", flush=True)


if __name__ == "__main__":
    main()
