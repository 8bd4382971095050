"""Copies every command of the README and of the site, and runs it in a fresh clone with a clean environment: `make commands`.

A command is a line that begins with `$ ` in a block of the kind `console`. They have a new environment of Python in the path. Those whose line says that they hold once the package is published are listed and not run.
"""

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: Words of a line that is about a package on a registry.
LATER = "once it is published"


def commands(page: Path) -> list[str]:
    """The commands of a page, as they are copied."""
    text = page.read_text(encoding="utf-8")
    found = []
    for block in re.findall(r"^```console\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
        found += [line[2:] for line in block.splitlines() if line.startswith("$ ")]
    return found


def run(command: str, folder: Path, environment: dict[str, str]) -> bool:
    """Whether the command ends without an error."""
    begin = time.monotonic()
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    print(
        f"{'ok' if done.returncode == 0 else 'FAILS':6}{time.monotonic() - begin:6.0f} s  {command}",
        flush=True,
    )
    if done.returncode:
        print(done.stdout[-2000:], flush=True)
    return done.returncode == 0


def main() -> int:
    wrong = 0
    with tempfile.TemporaryDirectory() as place:
        clone = Path(place) / "standfast"
        subprocess.run(["git", "clone", "--quiet", ROOT, clone], check=True)
        bin_folder = Path(place) / "environment" / "bin"
        subprocess.run([sys.executable, "-m", "venv", bin_folder.parent], check=True)
        environment = {
            "HOME": os.environ["HOME"],
            "PATH": f"{bin_folder}:{os.environ['PATH']}",
        }
        # A reader who adds the crate has a package of his own, beside the checkout.
        mine = Path(place) / "mine"
        subprocess.run(["cargo", "new", "--quiet", mine], check=True)
        for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
            for command in commands(page):
                if LATER in command:
                    print(f"later           {command}")
                    continue
                folder = mine if page.name == "rust.md" else clone
                if "standfast-*.whl" in command:
                    # The wheel of `make demo`, in the folder that has it.
                    wrong += not run("make demo", clone, environment)
                    folder = clone / "target" / "wheels"
                wrong += not run(command, folder, environment)
        wrong += not run("cargo check --quiet", mine, environment)
    return wrong


if __name__ == "__main__":
    sys.exit(main() > 0)
