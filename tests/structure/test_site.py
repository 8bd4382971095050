"""The documentation site: its pages, those of the API, and their links. `make site` builds it."""

import re
import tomllib
from pathlib import Path

import standfast as sf

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def pages(nav):
    """The files of a table of contents."""
    for entry in nav:
        for value in [entry] if isinstance(entry, str) else entry.values():
            yield from pages(value) if isinstance(value, list) else [value]


def test_each_page_is_in_the_table_of_contents_once():
    site = tomllib.loads((ROOT / "zensical.toml").read_text(encoding="utf-8"))
    listed = list(pages(site["project"]["nav"]))
    files = [page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md")]
    assert sorted(listed) == sorted(files)


def public_names():
    """The names after `standfast.`."""
    names = set(sf.__all__) - {"__version__", "results", "theory"}
    for holder in ("results", "theory"):
        names |= {f"{holder}.{name}" for name in getattr(sf, holder).__all__}
    return sorted(names)


def test_each_public_name_is_on_one_page_and_in_the_index():
    found = {}
    for page in DOCS.rglob("*.md"):
        text = page.read_text(encoding="utf-8")
        for name in re.findall(r"^::: standfast\.([\w.]+)$", text, re.MULTILINE):
            found.setdefault(name, []).append(page.relative_to(DOCS).as_posix())
    assert sorted(found) == public_names()
    index = (DOCS / "api.md").read_text(encoding="utf-8")
    rows = re.findall(
        r"^\| \[`([\w.]+)`\]\((\S+)#standfast\.([\w.]+)\) \|", index, re.M
    )
    assert sorted(name for name, _, _ in rows) == public_names()
    for name, page, anchor in rows:
        assert anchor == name
        assert found[name] == [page]


def test_a_page_is_named_after_what_it_has():
    """The search finds titles first."""
    for page in (DOCS / "api").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        title = re.match("# (.*): ", text)[1].split(", ")
        names = re.findall(r"^::: standfast\.([\w.]+)$", text, re.MULTILINE)
        assert (
            set(title) & {name.split(".")[-1] for name in names} or page.stem in title
        )


def test_links_of_the_pages_stay_in_the_site():
    """Other files of the project are named, not linked: the site does not have them."""
    for page in DOCS.rglob("*.md"):
        text = page.read_text(encoding="utf-8")
        for link in re.findall(r"\]\(([^)#]+)", text):
            if "://" not in link:
                file = (page.parent / link).resolve()
                assert file.is_file(), (page.name, link)
                assert file.is_relative_to(DOCS), (page.name, link)


def test_rows_of_tables_have_the_cells_of_their_heads():
    """A bar in a cell, also in a span of code, cuts it off unless it is written as an escape."""
    for page in [ROOT / "README.md", *DOCS.rglob("*.md")]:
        cells = None
        text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.M | re.S)
        for line in text.splitlines():
            found = (
                len(re.findall(r"(?<!\\)\|", line)) if line.startswith("|") else None
            )
            assert None in (found, cells) or found == cells, (page.name, line)
            cells = found


def test_the_glossary_has_every_word_of_a_verdict():
    stub = (ROOT / "python" / "standfast" / "_core.pyi").read_text(encoding="utf-8")
    words = re.findall(r'"([\w-]+)"', re.search(r"_By.*?\]", stub, re.DOTALL)[0])
    glossary = (DOCS / "glossary.md").read_text(encoding="utf-8")
    assert len(words) > 10
    assert [word for word in words if f"`{word}`" not in glossary] == []


def test_the_gallery_shows_each_of_its_pictures_twice():
    """In the index, whose links zensical checks, and below its heading; films are small enough for a page."""
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    index, sections = text.split("</div>", 1)
    shown = [re.findall(r"!\[[^]]*\]\((\S+?)\)", part) for part in (index, sections)]
    assert set(shown[0]) <= set(shown[1])
    assert len(shown[0]) == sections.count("\n## ") >= 12
    films = re.findall(r'^run\.animate\("(\w+\.gif)"', sections, re.MULTILINE)
    assert films == [name for name in shown[1] if name.endswith(".gif")]
    for film in films:
        assert (DOCS / film).stat().st_size < 1e6, film
    files = {file.name for file in DOCS.glob("gallery_*.*")}
    assert files <= set(shown[1])
