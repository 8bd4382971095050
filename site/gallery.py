"""Draws the pictures gallery_*.png and tutorial_*.png of the pages in docs/ with the code before them: `python site/gallery.py`."""

import doctest
import re
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
BLOCK_OR_PICTURE = re.compile(
    r"^```python\n(.*?)^```|\(((?:gallery|tutorial)_\w+\.png)\)",
    re.DOTALL | re.MULTILINE,
)

for page in [DOCS / "gallery.md", *sorted(DOCS.glob("tutorial_*.md"))]:
    names: dict[str, object] = {}
    for block, picture in BLOCK_OR_PICTURE.findall(page.read_text(encoding="utf-8")):
        if picture:
            names["figure"].savefig(DOCS / picture)  # type: ignore[attr-defined]
        for example in doctest.DocTestParser().get_examples(block):
            exec(compile(example.source, page.name, "single"), names)
