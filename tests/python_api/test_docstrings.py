"""Every example in a docstring or in the README runs and prints the stated output."""

import doctest
import inspect
import math
import pydoc
import re
import shlex
from pathlib import Path

import pytest
import standfast
import standfast._core
import standfast.certificate
import standfast.certificate.intervals
import standfast.cli
import standfast.explorer
import standfast.film
import standfast.kicks
import standfast.kicks_plot
import standfast.map_plot
import standfast.maps
import standfast.plot
import standfast.report
import standfast.results
import standfast.robots
import standfast.scenery
import standfast.series
import standfast.suggest
import standfast.system_plot
import standfast.table
import standfast.theory
import standfast.units
from standfast.cli import main

ROOT = Path(__file__).parents[2]
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def core_docstrings():
    """Docstrings of the compiled module, which the doctest finder does not find."""
    for name, thing in vars(standfast._core).items():
        if name.startswith("__") or not inspect.getdoc(thing):
            continue
        yield name, inspect.getdoc(thing)
        if inspect.isclass(thing):
            for part, member in vars(thing).items():
                document = getattr(member, "__doc__", None)
                if not part.startswith("__") and document:
                    yield f"{name}.{part}", inspect.cleandoc(document)


CORE = dict(sorted(core_docstrings()))
PUBLIC = [
    (holder, name)
    for holder in (standfast, standfast.results, standfast.theory)
    for name in holder.__all__
    if name != "__version__"
]


def run_text(text, name):
    """Run the examples of a text; return their number."""
    test = doctest.DocTestParser().get_doctest(text, {}, name, name, 0)
    result = doctest.DocTestRunner(optionflags=OPTIONS).run(test)
    assert result.failed == 0, name
    return result.attempted


@pytest.mark.parametrize(
    "module",
    [
        standfast,
        standfast.certificate,
        standfast.certificate.intervals,
        standfast.cli,
        standfast.explorer,
        standfast.kicks,
        standfast.kicks_plot,
        standfast.map_plot,
        standfast.maps,
        standfast.film,
        standfast.plot,
        standfast.report,
        standfast.results,
        standfast.scenery,
        standfast.series,
        standfast.suggest,
        standfast.system_plot,
        standfast.table,
        standfast.theory,
        standfast.units,
    ],
    ids=lambda m: m.__name__,
)
def test_modules(module):
    result = doctest.testmod(module, optionflags=OPTIONS)
    assert result.failed == 0


@pytest.mark.parametrize("name", CORE)
def test_core(name):
    run_text(CORE[name], name)


def test_every_public_name_is_explained():
    for holder, name in PUBLIC:
        thing = getattr(holder, name)
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for part, member in vars(thing).items():
                if not part.startswith("_"):
                    assert member.__doc__ or re.search(rf"\b{part}\b", thing.__doc__), (
                        f"{name}.{part}"
                    )


def callables():
    """The public functions, constructors and methods, with the docstring that has their parameters."""
    modules = (standfast.certificate, standfast.robots)
    names = [(module, name) for module in modules for name in module.__all__]
    for holder, name in [*PUBLIC, *names]:
        thing = getattr(holder, name)
        if inspect.ismodule(thing) or name in ("SolverError", "Sagittal"):
            continue
        if not inspect.isclass(thing):
            yield name, thing
            continue
        if inspect.getdoc(thing) and thing not in MADE_BY_FUNCTIONS:
            yield name, thing
        for part, member in vars(thing).items():
            method = getattr(member, "__func__", member)
            if not part.startswith("_") and callable(method):
                yield f"{name}.{part}", method


#: Types of results: they have no constructor.
MADE_BY_FUNCTIONS = {
    thing
    for thing in vars(standfast._core).values()
    if inspect.isclass(thing) and getattr(thing, "__text_signature__", None) is None
}
CALLABLES = dict(callables())


def table(document):
    """What the section "Parameters" says of the type of each parameter."""
    section = re.search(
        r"^Parameters\n-{10}\n(.*?)(?=\n\n\w+\n---|\Z)",
        document,
        re.DOTALL | re.MULTILINE,
    )
    found = {}
    for line in section[1].splitlines() if section else []:
        if not line.startswith(" ") and line:
            names, _, kind = line.partition(" : ")
            found |= dict.fromkeys(names.split(", "), kind)
    return found


def wrong_entries(thing):
    """Parameters without a line of their own, and lines with another default."""
    document, stars = (
        inspect.getdoc(thing),
        {"VAR_KEYWORD": "**", "VAR_POSITIONAL": "*"},
    )
    said, found = table(document), []
    for name, parameter in inspect.signature(thing).parameters.items():
        if name == "self":
            continue
        kind = said.pop(stars.get(parameter.kind.name, "") + name, None)
        if kind is None:
            found.append(name)
        elif parameter.default is not parameter.empty and kind != "see simulate":
            text = re.search(r"default (.*)$", kind) or re.match(r"\{(.*?)[,}]", kind)
            if not text or eval(text[1], {"inf": math.inf}) != parameter.default:
                found.append(f"{name}={parameter.default!r}")
    return [*found, *said]


@pytest.mark.parametrize("name", CALLABLES)
def test_each_parameter_has_a_line_with_its_default(name):
    assert wrong_entries(CALLABLES[name]) == []


def test_a_parameter_without_a_line_is_found():
    def area(width, height=1.0, *, unit="m²"):
        """Area.

        Parameters
        ----------
        width : float, m
        height : float, m, default 2.0
        depth : float, m
        """

    assert wrong_entries(area) == ["height=1.0", "unit", "depth"]


@pytest.mark.parametrize(
    "name", sorted(set(CALLABLES) - set(standfast.certificate.__all__))
)
def test_help_begins_with_names_alone(name):
    """Except in the checker of certificates, which uses nothing else of the package."""
    first = pydoc.plain(pydoc.render_doc(CALLABLES[name])).splitlines()[2]
    assert "typing" not in first
    assert ": " not in first
    assert "->" not in first


def test_the_main_classes_show_an_example():
    for name in (
        "Contact",
        "Posture",
        "LocalModel",
        "Scene",
        "ContactProblem",
        "ContactMode",
        "Modes",
        "Sweep",
        "contact_modes",
        "simulate",
    ):
        assert ">>>" in CORE[name], name


def blocks(language, page="README.md"):
    text = (ROOT / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def test_the_examples_of_the_scope_table_run():
    """In the order of the rows, in one namespace."""
    text = (ROOT / "docs" / "scope.md").read_text(encoding="utf-8")
    rows = [row for row in text.splitlines() if row.startswith("| ")]
    codes = [code for row in rows for code in re.findall(r"`([^`]*\(.*?)`", row)]
    assert len(codes) > 15
    names = {"math": math, "sf": standfast}
    for code in codes:
        exec(code, names)  # text of the page


def pages():
    """Every page with blocks in Python."""
    for path in [
        ROOT / "README.md",
        ROOT / "python" / "README.md",
        *sorted((ROOT / "docs").glob("*.md")),
    ]:
        page = path.relative_to(ROOT).as_posix()
        if blocks("python", page):
            # Libraries that Dask uses warn.
            dask = "distributed" in path.read_text(encoding="utf-8")
            marks = [pytest.mark.filterwarnings("default")] if dask else []
            yield pytest.param(page, marks=marks)


@pytest.mark.parametrize("page", list(pages()))
def test_pages_python(page):
    """The blocks of a page, in one namespace."""
    examples = blocks("python", page)
    assert examples
    for example in examples:
        assert ">>> " in example
    run_text("\n\n".join(examples), page)


def test_the_readme_is_short():
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 150
    assert max(map(len, lines)) <= 160


def test_the_first_lines_say_what_ground_a_contact_has():
    for name in ("Contact", "Posture"):
        first = " ".join(CORE[name].split("\n\n")[0].split())
        for words in ("line of", "terrain", "warns where"):
            assert words in first, (name, words)


def test_the_scene_file_of_the_page_is_the_example():
    (text,) = blocks("toml", "docs/cli.md")
    example = ROOT / "examples" / "clattering_rod.toml"
    assert text == example.read_text(encoding="utf-8")


def test_commands(capsys, monkeypatch, tmp_path):
    """The page shows after `$ standfast …` the output of the command."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    shown = [
        block
        for block in blocks("console", "docs/cli.md")
        if block.startswith("$ standfast ")
    ]
    assert shown
    for block in shown:
        line, _, output = block.partition("\n")
        assert main(shlex.split(line)[2:]) == 0
        assert capsys.readouterr().out == output
