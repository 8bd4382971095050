"""The page of the atlas, and the files of its truths: `python -m atlas.page` in `tests` writes both anew."""

import json
from pathlib import Path

from mpmath import mp, mpf

from .entries import ATLAS, DIGITS, SCENES

PAGE = Path(__file__).parents[2] / "docs" / "atlas.md"


def error(answer, truth):
    """Relative, or absolute beside a truth of zero."""
    return abs(mpf(float(answer)) - truth) / (abs(truth) or 1)


def written(truth):
    """A truth as its file has it."""
    plain = {
        name: mp.nstr(value, 25) if isinstance(value, mpf) else value
        for name, value in truth.items()
    }
    return json.loads(json.dumps(plain))


def told(value):
    if isinstance(value, mpf):
        return mp.nstr(value, 17)
    return (
        ", ".join(map(str, value)) or "none" if isinstance(value, tuple) else str(value)
    )


def section(entry):
    scene = entry.scene
    truth, answer = entry.truth(scene), entry.answer(scene)
    said, _ = entry.fails(scene)
    numbers = [name for name, value in truth.items() if isinstance(value, mpf)]
    worst = max((error(answer[name], truth[name]) for name in numbers), default=None)
    right = "; ".join(f"{name}: {told(value)}" for name, value in truth.items())
    verdict = "the same" if worst is None else f"the same, to {mp.nstr(worst, 2)}"
    return [
        f"## {entry.title}",
        "",
        f"`tests/atlas/scenes/{entry.name}.toml`",
        "",
        f"* What breaks: {entry.breaks}",
        f"* How it fails ({entry.method}): {said}.",
        f"* What is right ({entry.source}): {right}.",
        f"* What standfast answers: {verdict}.",
        "",
    ]


def text():
    lines = [
        "# An atlas of hard scenes",
        "",
        "Scenes at which a usual method fails. How it fails, what is right and what standfast answers are computed:",
        "`tests/atlas` holds a file for each scene, the methods, and the sources of the truth; `make atlas` writes this page.",
        "Errors are relative, of a number that is zero absolute.",
        "",
    ]
    with mp.workdps(DIGITS):
        for entry in ATLAS:
            lines += section(entry)
    return "\n".join(lines).rstrip() + "\n"


def main():
    with mp.workdps(DIGITS):
        for entry in ATLAS:
            truth = json.dumps(written(entry.truth(entry.scene)), indent=2) + "\n"
            (SCENES / f"{entry.name}.json").write_text(truth, encoding="utf-8")
    PAGE.write_text(text(), encoding="utf-8")


if __name__ == "__main__":
    main()
