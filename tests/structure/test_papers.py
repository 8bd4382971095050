"""The papers beside the code say what is there."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAPERS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])


@pytest.mark.parametrize("paper", PAPERS, ids=lambda path: path.name)
def test_links_lead_somewhere(paper):
    text = paper.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" in target:
            continue
        path, _, anchor = target.partition("#")
        file = (paper.parent / path) if path else paper
        assert file.exists(), target
        if anchor:
            aim = file.read_text(encoding="utf-8").lower()
            titles = [
                re.sub(r"[^\w -]", "", line.lstrip("# ")).replace(" ", "-")
                for line in aim.splitlines()
                if line.startswith("#")
            ]
            assert f'id="{anchor}"' in aim or anchor in titles, target


def test_correspondence_names_files_and_tests_that_exist():
    text = (ROOT / "docs" / "correspondence.md").read_text(encoding="utf-8")
    sources = [*(ROOT / "crates").rglob("*.rs"), *(ROOT / "tests").rglob("*.py")]
    known = set()
    for source in sources:
        known |= set(
            re.findall(r"\b(?:fn|def) (\w+)", source.read_text(encoding="utf-8"))
        )
        known |= {source.name, source.stem}
    rows = [line for line in text.splitlines() if line.startswith("| ") and "`" in line]
    assert rows
    named = {name for row in rows for name in re.findall(r"`([\w.:]+)`", row)}
    for name in named:
        assert name.split("::")[-1] in known, name
