"""Documents beside the code name only files and functions that exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAPERS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])


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
            objects = re.findall("^::: (.*)", file.read_text(encoding="utf-8"), re.M)
            known = f'id="{anchor}"' in aim or anchor in titles or anchor in objects
            assert known, target


#: The folders from which a path in a paper may start.
BASES = [
    ROOT,
    ROOT / "crates" / "core" / "src",
    ROOT / "python" / "standfast",
    ROOT / "tests",
    ROOT / "benches",
]
#: The folders that have sources; a file may also be named without its folder.
FOLDERS = ["benches", "crates", "docs", "examples", "fuzz", "python", "tests"]
FILES = {
    path.name: path
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*.*")
    if path.is_file()
}
SOURCE_PATH = re.compile(
    rf"[\w./-]*\w\.(?:rs|pyi?|toml|json|txt)|(?:[\w.-]+/)+|(?:{'|'.join(FOLDERS)})/[\w./-]+"
)
FUNCTION = re.compile(r"\b(?:fn|def) (\w+)")


def code(text: str) -> list[str]:
    """The words of the spans of code and of the blocks that are code; a block of text has formulas."""
    fence = re.compile(r"^```(\w+)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
    blocks = [block for kind, block in fence.findall(text) if kind != "text"]
    spans = re.findall(r"`([^`]+)`", fence.sub("", text))
    return re.split(r"[^\w./:-]+", " ".join([*blocks, *spans]))


def file_named(path: str) -> Path | None:
    """The file or folder of this path from one of the bases, or the file of this name."""
    for base in BASES:
        if (base / path).exists():
            return base / path
    return FILES.get(path)


def wrong_paths(text: str) -> list[str]:
    words = [word.rstrip(".:") for word in code(text)]
    words = [word.partition("::")[0] for word in words]
    paths = [word for word in words if SOURCE_PATH.fullmatch(word)]
    return [path for path in paths if not file_named(path)]


@pytest.mark.parametrize(
    "paper",
    [paper for paper in PAPERS if paper.name != "CHANGELOG.md"],
    ids=lambda path: path.name,
)
def test_source_paths_exist(paper):
    """The changelog may name files that have gone."""
    assert wrong_paths(paper.read_text(encoding="utf-8")) == []


def test_a_wrong_path_is_found():
    for right in ("motion/driver.rs", "driver.rs", "modes/", "tests/oracles"):
        assert wrong_paths(f"See `{right}`.") == []
    for wrong in (
        "motion/drivers.rs",
        "drivers.rs",
        "mode/",
        "tests/oracle",
        "crates/core/src/newton.rs",
        "motion/test_auto.rs",
    ):
        assert wrong_paths(f"See `{wrong}`.") == [wrong]
        assert wrong_paths(f"```console\n$ python {wrong}\n```\n") == [wrong]


def functions(path: Path) -> set[str]:
    """The functions that are defined in a file, or in the files of a folder."""
    files = [path] if path.is_file() else [*path.rglob("*.rs"), *path.rglob("*.py")]
    found: set[str] = set()
    for file in files:
        found |= set(FUNCTION.findall(file.read_text(encoding="utf-8")))
    return found


def wrong_functions(text: str) -> list[str]:
    """Names in a table, bare or after the file or module, of functions that are not there."""
    everywhere = functions(ROOT / "crates") | functions(ROOT / "tests")
    rows = [line for line in text.splitlines() if line.startswith("| ") and "`" in line]
    assert rows
    found = []
    for name in re.findall(r"`([\w./]+(?:::\w+)*)`", "\n".join(rows)):
        *modules, function = name.split("::")
        if SOURCE_PATH.fullmatch(function):
            continue
        known = everywhere
        if modules:
            path = "/".join(modules)
            file = file_named(path) or file_named(f"{path}.rs")
            known = functions(file) if file else set()
        if function not in known:
            found.append(name)
    return found


def test_correspondence_names_functions_that_exist():
    text = (ROOT / "docs" / "correspondence.md").read_text(encoding="utf-8")
    assert wrong_functions(text) == []


def test_a_wrong_function_is_found():
    def row(name):
        return f"| equation | `zeno.rs` | `{name}` |\n"

    for right in (
        "rod_couplings_by_hand",
        "body/posture.rs::rod_couplings_by_hand",
        "body::rod_couplings_by_hand",
        "test_examples.py::test_bouncing_ball",
    ):
        assert wrong_functions(row(right)) == [], right
    for wrong in (
        "no_such_function",
        "flight.rs::rod_couplings_by_hand",
        "flight::rod_couplings_by_hand",
        "no_such_file.rs::rod_couplings_by_hand",
    ):
        assert wrong_functions(row(wrong)) == [wrong]


def test_the_crate_has_the_licences_of_the_project():
    root = Path(__file__).parents[2]
    for name in ("LICENSE-MIT", "LICENSE-APACHE"):
        own = (root / "crates" / "core" / name).read_bytes()
        assert own == (root / name).read_bytes()
