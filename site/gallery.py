"""Draws the pictures gallery_*.png of docs/gallery.md with the code beside them: `python site/gallery.py`."""

import doctest
import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "gallery.md"
BLOCK_OR_PICTURE = re.compile(
    r"^```python\n(.*?)^```|\((gallery_\w+\.png)\)", re.DOTALL | re.MULTILINE
)

names: dict[str, object] = {}
for block, picture in BLOCK_OR_PICTURE.findall(PAGE.read_text(encoding="utf-8")):
    if picture:
        names["figure"].savefig(PAGE.with_name(picture))  # type: ignore[attr-defined]
    for example in doctest.DocTestParser().get_examples(block):
        exec(compile(example.source, picture or "gallery", "single"), names)
