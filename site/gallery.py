"""Draws the pictures and films of the gallery, the recipes and the tutorials in docs/ with the code before them: `python site/gallery.py`.

A picture gallery_*.png, recipe_*.png or tutorial_*.png is what `figure` then is. A block in `py` makes a film. With names of pages, such as
`gallery.md`, only these are drawn.
"""

import doctest
import os
import re
import sys
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
#: Blocks of examples, blocks that make films, and pictures below headings (those before the first are the index).
PARTS = re.compile(
    r"^```python\n(.*?)^```|^```py\n(.*?)^```|^!\[[^\]\n]*\]\(((?:gallery|recipe|tutorial)_\w+\.png)\)",
    re.DOTALL | re.MULTILINE,
)


def draw(page: Path) -> None:
    """Runs the blocks of a page up to its last picture or film; a picture before all blocks is that of the last one."""
    parts = PARTS.findall(page.read_text(encoding="utf-8"))
    if not parts[0][2]:
        while parts and parts[-1][0]:
            parts.pop()
    names: dict[str, object] = {}
    first = None
    for block, film, picture in parts:
        if picture and not names:
            first = picture
        elif picture.startswith(page.stem):
            names["figure"].savefig(picture)  # type: ignore[attr-defined]
        for example in doctest.DocTestParser().get_examples(block):
            exec(compile(example.source, page.name, "single"), names)
        exec(compile(film, page.name, "exec"), names)
    if first:
        names["figure"].savefig(first)  # type: ignore[attr-defined]


if __name__ == "__main__":
    pages = [DOCS / name for name in sys.argv[1:]]
    os.chdir(DOCS)
    for page in pages or [
        DOCS / "gallery.md",
        *sorted(DOCS.glob("recipe_*.md")),
        *sorted(DOCS.glob("tutorial_*.md")),
    ]:
        draw(page)
