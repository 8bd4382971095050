"""Films of runs as files. The suffix of the name says which kind."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path

from standfast._core import Run, write_whole
from standfast.page import film_page
from standfast.table import without_posture

#: What a file of each kind needs.
NEEDS = {
    ".gif": "matplotlib",
    ".mp4": "matplotlib and the program ffmpeg",
    ".html": "a browser to play it",
}
SUFFIXES = ", ".join(list(NEEDS)[:-1]) + f" or {list(NEEDS)[-1]}"


def animate(
    run: Run, path: str | PathLike[str], fps: float, speed: float, clock: str
) -> None:
    """Write a film of the run to exactly this path, whole or not at all. See `Run.animate`."""
    target = Path(path)
    kind = target.suffix.lower()
    if kind not in NEEDS:
        raise ValueError(
            f"path = {str(path)!r} cannot be used: a file name that ends in {SUFFIXES} is allowed"
        )
    if run.posture is None:
        raise ValueError(
            f"run cannot be animated: it is of a {without_posture(run)}, which has no posture; a run of a Posture is needed"
        )
    write_whole(target, writer(kind, target.stem)(run, fps, speed, clock))


def writer(kind: str, title: str) -> Callable[[Run, float, float, str], bytes]:
    """What makes the bytes of a film of this kind."""
    if kind == ".html":
        return lambda run, _, speed, clock: film_page(run, title, speed, clock).encode()
    try:
        from standfast import film
    except ImportError as error:
        raise ImportError(
            f"{kind} needs matplotlib: pip install matplotlib; .html needs no other package"
        ) from error
    return film.as_gif if kind == ".gif" else film.as_mp4
