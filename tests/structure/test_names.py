"""The public names: few at the root, nothing else in `dir`, and an old name is answered by its new place."""

import importlib
import pickle
import subprocess
import sys

import pytest
import standfast as sf

#: A reader takes in the names at the root on one screen.
MOST_NAMES = 45

MODULES = ("certificate", "results", "robots", "theory")


def public(module):
    return {name for name in dir(module) if not name.startswith("_")}


def test_few_names_at_the_root():
    assert len(public(sf)) <= MOST_NAMES
    assert public(sf) == set(sf.__all__) - {"__version__"}


@pytest.mark.parametrize("name", MODULES)
def test_a_module_has_its_own_names_only(name):
    module = getattr(sf, name)
    assert name in sf.__all__
    assert public(module) == set(module.__all__)
    assert not public(module) & public(sf)


@pytest.mark.parametrize(
    ("holder", "name"),
    [
        (holder, name)
        for holder in ("results", "theory")
        for name in importlib.import_module(f"standfast.{holder}").__all__
    ],
)
def test_an_old_name_is_answered_by_its_place(holder, name):
    with pytest.raises(AttributeError, match=rf"it is standfast\.{holder}\.{name}$"):
        getattr(sf, name)
    thing = getattr(getattr(sf, holder), name)
    assert pickle.loads(pickle.dumps(thing)) is thing
    if isinstance(thing, type):
        assert thing.__module__ == f"standfast.{holder}"


def test_each_result_type_is_only_made_by_functions():
    """Those that can be constructed are made from parts of an answer, for pictures of them."""
    constructed = set()
    for name in sf.results.__all__:
        try:
            getattr(sf.results, name)()
        except TypeError as error:
            if "cannot create" not in str(error):
                constructed.add(name)
    assert constructed == {"LoadFactor", "SystemMode"}


def test_an_import_leaves_these_modules_for_later():
    program = f"import sys, standfast; print([n for n in {MODULES} if 'standfast.' + n in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
