"""The page of the atlas, and the files of its truths: `python -m atlas.page` in `tests` writes both anew."""

import json
from pathlib import Path

from mpmath import mp, mpf

from .entries import ATLAS, FAMILIES
from .entry import DIGITS, SCENES, WITHIN

PAGE = Path(__file__).parents[2] / "docs" / "atlas.md"


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


def limit(entry, name):
    """What the error may be, where the scene limits it to more than some roundings."""
    allowed = entry.allowed[name]
    return f" (of {allowed:.1g} that are allowed)" if allowed > WITHIN else ""


def section(entry):
    right = "; ".join(f"{name}: {told(value)}" for name, value in entry.right.items())
    verdict = "the same" + "".join(
        f", {name} {f'to {mp.nstr(error, 2)}' if error else 'exactly'}{limit(entry, name)}"
        for name, error in entry.errors.items()
    )
    lines = [
        f'<a id="{entry.name}"></a>',
        "",
        f"### {entry.title}",
        "",
        f"`tests/atlas/scenes/{entry.name}.toml`",
        "",
        f"* What breaks: {entry.breaks}",
        f"* How it fails ({entry.method}): {entry.failure[0]}.",
        f"* What is right ({entry.source}): {right}.",
        f"* What standfast answers: {verdict}.",
        "",
    ]
    return "\n".join(lines)


def head():
    lines = [
        "# An atlas of hard scenes",
        "",
        f"{len(ATLAS)} scenes at which a usual method fails. How it fails, what is right and what standfast answers are computed:",
        "`tests/atlas` holds a file for each scene, the methods, and the sources of the truth; `make atlas` writes this page.",
        "Errors are relative, of a number that is zero absolute.",
        "",
        "What difficulty does to errors and to the work, as it goes to its limit (`tests/atlas/difficulty.py`):",
        "",
        "![Errors and numbers of impacts of families of scenes against their difficulty](difficulty.png)",
        "",
    ]
    for family in FAMILIES:
        links = (f"  [{entry.title}](#{entry.name})" for entry in family)
        lines += [f"* **{family.title}**", " ·\n".join(links)]
    return "\n".join([*lines, ""])


def text():
    parts = [head()]
    for family in FAMILIES:
        parts += [f"## {family.title}\n", *map(section, family)]
    return "\n".join(parts)


def main():
    with mp.workdps(DIGITS):
        for entry in ATLAS:
            truth = json.dumps(written(entry.right), indent=2) + "\n"
            (SCENES / f"{entry.name}.json").write_text(truth, encoding="utf-8")
        PAGE.write_text(text(), encoding="utf-8")


if __name__ == "__main__":
    main()
