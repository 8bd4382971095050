"""Pages of one file: the player of a film, and the explorer. They load nothing and ask nobody but what they are given.

The scripts are modules in `page/`. A page or a widget gets them as one script, in the order of use, without their lines `import` and
`export`: all their names are different.
"""

import json
import re
import sys
from base64 import b64encode
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from standfast._core import Run
from standfast.colors import COLORS

#: The modules, each after those that it uses.
PLAYER = ("stage.js", "player.js")
EXPLORER = (
    *PLAYER,
    "presets.js",
    "fields.js",
    "report.js",
    "places.js",
    "files.js",
    "explorer.js",
    "engine.js",
    "ask.js",
)
#: Time after which a question of the explorer is given up, s.
PATIENCE = 10.0
#: The library that draws curves, and the styles.
LIBRARY, STYLES = "uPlot.iife.min.js", ("uPlot.min.css", "style.css")


def text(name: str) -> str:
    """A file of the folder `page`."""
    return (files("standfast") / "page" / name).read_text(encoding="utf-8")


def script(modules: tuple[str, ...]) -> str:
    """The library and these modules as one script."""
    parts = [text(LIBRARY)]
    for name in modules:
        source = re.sub(r"^import .*\n", "", text(name), flags=re.MULTILINE)
        parts.append(re.sub(r"^export ", "", source, flags=re.MULTILINE))
    return "\n".join(parts)


def style() -> str:
    """The styles as one text."""
    return "\n".join(map(text, STYLES))


def data(value: Any) -> str:
    """A value as JavaScript inside a script of a page."""
    # Where `<` is escaped, no text can end the script.
    return json.dumps(value, allow_nan=False).replace("<", "\\u003c")


def document(title: str, modules: tuple[str, ...], start: str) -> str:
    """An HTML page. `start`: the script that fills the element `root`."""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(title)}</title>
<style>
html, body {{ margin: 0; height: 100%; }}
{style()}
</style>
</head>
<body>
<div id="root" class="sf-root"></div>
<script type="module">
{script(modules)}
const root = document.getElementById("root");
{start}
</script>
</body>
</html>
"""


def film_page(run: Run, title: str, speed: float | None, clock: str) -> str:
    """A page that plays a run: it scrubs, and steps from event to event, by both clocks. speed: None: so that the film takes some seconds."""
    return document(
        title,
        PLAYER,
        f"play(root, {data(run.film())}, {data({'clock': clock, 'speed': speed})});",
    )


def explorer_page(scene: dict[str, Any] | str | None) -> str:
    """The page of the explorer, which asks the server that sends it. scene: as an object or in TOML; None: an example."""
    return document(
        "standfast explorer",
        EXPLORER,
        f"new Explorer(root, {{ ask: serverAsk(), scene: {data(scene)}, colors: {data(COLORS)} }});",
    )


def static_page(module: bytes) -> str:
    """The explorer without a server: the core as WebAssembly is in the page itself, so that it can be put on any site, or opened as a file.

    module: what `make explorer` builds.
    """
    text = b64encode(module).decode("ascii")
    return document(
        "standfast explorer",
        EXPLORER,
        f"""const bytes = Uint8Array.from(atob("{text}"), (c) => c.charCodeAt(0));
window.standfast = new Explorer(root, {{ ask: wasmAsk(bytes), colors: {data(COLORS)} }});""",
    )


if __name__ == "__main__":
    # python -m standfast.page MODULE PAGE
    Path(sys.argv[2]).write_text(
        static_page(Path(sys.argv[1]).read_bytes()), encoding="utf-8"
    )
