"""The atlas of scenes at which methods fail: each method fails as its entry says, the truth is what the entry's file says, and
standfast answers it."""

import json

import pytest
from atlas import page
from atlas.entries import ATLAS, DIGITS, SCENES
from mpmath import mp, mpf

ENTRIES = pytest.mark.parametrize("entry", ATLAS, ids=lambda entry: entry.name)


@pytest.fixture(autouse=True)
def digits():
    """Digits of the truths."""
    with mp.workdps(DIGITS):
        yield


@ENTRIES
def test_the_usual_method_fails(entry):
    said, fails = entry.fails(entry.scene)
    assert fails, said


@ENTRIES
def test_the_answer_is_right(entry):
    truth, answer = entry.truth(entry.scene), entry.answer(entry.scene)
    written = json.loads((SCENES / f"{entry.name}.json").read_text(encoding="utf-8"))
    assert page.written(truth) == written
    assert truth.keys() == answer.keys()
    for name, value in truth.items():
        if isinstance(value, mpf):
            assert page.error(answer[name], value) <= entry.within, name
        else:
            assert answer[name] == value, name


def test_files_and_entries_belong_together():
    names = {entry.name for entry in ATLAS}
    assert names == {file.stem for file in SCENES.glob("*.toml")}
    assert names == {file.stem for file in SCENES.glob("*.json")}


def test_the_page_is_that_of_the_entries():
    assert page.PAGE.read_text(encoding="utf-8") == page.text()
