"""The documentation site: its pages, its API page, and its links. `make site` builds it."""

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
    assert sorted(listed) == sorted(page.name for page in DOCS.glob("*.md"))


def test_the_api_page_has_every_public_name():
    text = (DOCS / "api.md").read_text(encoding="utf-8")
    listed = re.findall(r"^::: standfast\.([\w.]+)$", text, re.MULTILINE)
    names = set(sf.__all__) - {"__version__", "results", "theory"}
    for holder in ("results", "theory"):
        names |= {f"{holder}.{name}" for name in getattr(sf, holder).__all__}
    assert sorted(listed) == sorted(names)


def test_links_of_the_pages_stay_in_the_site():
    """Other files of the project are named, not linked: the site does not have them."""
    for page in DOCS.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for link in re.findall(r"\]\(([^)#]+)", text):
            if "://" not in link:
                assert (DOCS / link).is_file(), (page.name, link)
                assert not link.startswith(".."), (page.name, link)


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
