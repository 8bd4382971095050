"""The atlas of scenes at which methods fail: each method fails as its entry states, the exact result agrees with the entry's
file, and standfast computes it."""

import json
import re

import pytest
from mpmath import mp, mpf

from atlas import difficulty, page
from atlas.entries import ATLAS
from atlas.entry import DIGITS, SCENES, WITHIN

ENTRIES = pytest.mark.parametrize("entry", ATLAS, ids=lambda entry: entry.name)


@pytest.fixture(autouse=True)
def digits():
    """Digits of the exact results."""
    with mp.workdps(DIGITS):
        yield


def needed(entry):
    if entry.needs:
        pytest.importorskip(entry.needs)


@ENTRIES
def test_the_usual_method_fails(entry):
    needed(entry)
    said, fails = entry.failure
    assert fails, said


@ENTRIES
def test_the_answer_is_right(entry):
    written = json.loads((SCENES / f"{entry.name}.json").read_text(encoding="utf-8"))
    assert page.written(entry.right) == written
    assert entry.right.keys() == entry.answered.keys()
    for name, value in entry.right.items():
        if isinstance(value, mpf):
            assert entry.errors[name] <= entry.allowed[name], name
        else:
            assert entry.answered[name] == value, name


def test_files_and_entries_belong_together():
    names = {entry.name for entry in ATLAS}
    assert len(names) == len(ATLAS)
    assert names == {file.stem for file in SCENES.glob("*.toml")}
    assert names == {file.stem for file in SCENES.glob("*.json")}


@ENTRIES
def test_the_page_has_the_section(entry):
    needed(entry)
    assert page.section(entry) in page.PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "family", difficulty.FAMILIES, ids=lambda family: family.points.__name__
)
def test_errors_stay_below_the_conditioning_limit(family):
    """Rounding errors within the package may be a few times those of the scene's numbers."""
    points = [point for point in family.points() if point.error is not None]
    assert len(points) > 5
    for point in points:
        assert point.error <= 4 * point.limit + WITHIN, point


def test_the_page_lists_the_entries():
    text = page.PAGE.read_text(encoding="utf-8")
    assert text.startswith(page.head())
    assert re.findall('<a id="(.*)"></a>', text) == [entry.name for entry in ATLAS]
