"""The options of a run have the same defaults in the core, in signatures and in stubs."""

import ast
import inspect
from pathlib import Path

import pytest
import standfast as sf

# Functions that take options: the options that they leave out, and their own defaults.
# Keywords that are no options of a run.
NO_OPTIONS = {"threads", "kicks", "forces", "ground_motion"}
OWN_OF_A_BODY = {"model", "impact", "neighbourhood", "edges", "jams"}
CALLS = {
    "simulate": (set(), {}),
    "simulate_many": (set(), {"record": False}),
    "LocalModel.simulate": (OWN_OF_A_BODY, {}),
}


def core_defaults():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    return sf.Scene(rod, (0, 1, 0), (0, 0, 0)).options


def expected(name):
    without, own = CALLS[name]
    return {k: v for k, v in core_defaults().items() if k not in without} | own


def keywords(name):
    """The options of the function at run time."""
    function = sf
    for part in name.split("."):
        function = getattr(function, part)
    parameters = inspect.signature(function).parameters.values()
    return {
        p.name: p.default
        for p in parameters
        if p.kind is inspect.Parameter.KEYWORD_ONLY and p.name not in NO_OPTIONS
    }


def stub_keywords(name):
    """The options of the function in the type stubs."""
    body = ast.parse(
        (Path(sf.__file__).parent / "_core.pyi").read_text(encoding="utf-8")
    ).body
    *classes, function = name.split(".")
    for one in classes:
        body = next(
            n for n in body if isinstance(n, ast.ClassDef) and n.name == one
        ).body
    node = next(
        n for n in body if isinstance(n, ast.FunctionDef) and n.name == function
    )
    pairs = zip(node.args.kwonlyargs, node.args.kw_defaults, strict=True)
    return {a.arg: ast.literal_eval(d) for a, d in pairs if a.arg not in NO_OPTIONS}


@pytest.mark.parametrize("name", CALLS)
def test_signature_has_the_defaults_of_the_core(name):
    assert keywords(name) == expected(name)
    assert list(keywords(name)) == list(expected(name))


@pytest.mark.parametrize("name", CALLS)
def test_stub_has_the_defaults_of_the_core(name):
    found = stub_keywords(name)
    assert found.pop("neighbourhood", ...) is ...  # infinity has no literal in a stub
    wanted = expected(name)
    wanted.pop("neighbourhood", None)
    assert found == wanted


@pytest.mark.parametrize("name", CALLS)
def test_options_that_a_call_does_not_have_are_refused(name):
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    local = sf.LocalModel(gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.1)
    calls = {
        "simulate": lambda **k: sf.simulate(rod, (0, 1, 0), (0, 0, 0), **k),
        "simulate_many": lambda **k: sf.simulate_many(rod, (0, 1, 0), [(0, 0, 0)], **k),
        "LocalModel.simulate": lambda **k: local.simulate((0, 0.1), (0.1, -1.9), **k),
    }
    for option in {"toleranse", *CALLS[name][0]}:
        message = rf"^{name}\(\) got an unexpected keyword argument '{option}'"
        with pytest.raises(TypeError, match=message):
            calls[name](**{option: 1})
