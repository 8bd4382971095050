"""The page of the atlas, and the files of its exact results: `python -m atlas.page` in `tests` writes both."""

import json
from pathlib import Path

from mpmath import mp, mpf

from .entries import ATLAS, FAMILIES
from .entry import DIGITS, SCENES, WITHIN

PAGE = Path(__file__).parents[2] / "docs" / "atlas.md"


def written(truth):
    """An exact result in the format of its file."""
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
    """The allowed error, if it is more than a few rounding errors."""
    allowed = entry.allowed[name]
    return f" (allowed: {allowed:.1g})" if allowed > WITHIN else ""


def section(entry):
    right = "; ".join(f"{name}: {told(value)}" for name, value in entry.right.items())
    verdict = "the same" + "".join(
        f", {name} {f'within {mp.nstr(error, 2)}' if error else 'exactly'}{limit(entry, name)}"
        for name, error in entry.errors.items()
    )
    lines = [
        f'<a id="{entry.name}"></a>',
        "",
        f"### {entry.title}",
        "",
        f"`tests/atlas/scenes/{entry.name}.toml`",
        "",
        f"* Difficulty: {entry.breaks}",
        f"* Wrong answer ({entry.method}): {entry.failure[0]}.",
        f"* Right answer ({entry.source}): {right}.",
        f"* Answer of standfast: {verdict}.",
        "",
    ]
    return "\n".join(lines)


def head():
    lines = [
        "# An atlas of hard scenes",
        "",
        f"This page has {len(ATLAS)} scenes on which a usual method fails. For each scene it names the difficulty, the wrong answer of the",
        "usual method, the right answer, and the answer of standfast. The method, and the source of the right answer, are in parentheses.",
        "All answers are computed: `tests/atlas` has two files for each scene (TOML and JSON), the usual methods, and the sources of the right answers.",
        "`make atlas` writes this page. Errors are relative; the error of a number that is zero is absolute.",
        "",
        'A mode word has a letter for each contact: S separates, F stays fixed, R or L slides right or left. "Allowed" after an error is the',
        "error that the answer may have; 4e-15 if nothing is said.",
        "",
        "The picture shows families of scenes in which a parameter goes to its limit (`tests/atlas/difficulty.py`). Errors and numbers of",
        "impacts are drawn against the difficulty:",
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
