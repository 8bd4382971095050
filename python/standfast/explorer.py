"""The explorer in a cell of a notebook."""

from typing import TYPE_CHECKING

from standfast._core import Posture, Scene
from standfast.signatures import with_names_only

if TYPE_CHECKING:
    from standfast.widget import Widget


@with_names_only
def explore(scene: Posture | Scene | None = None) -> "Widget":
    """The explorer in a cell of a notebook: drag, tilt and kick a body, with its verdict, its contact modes and its motion.

    The kernel of the notebook answers, when it is not busy with a cell. The posture as it has been changed in the cell is
    `widget.posture`, the whole scene `widget.scene`; assigned, they change what the cell shows.

    Parameters
    ----------
    scene : Posture, Scene or None, default None
        What to begin with: a Posture at rest, or a Scene; None: an example.

    Returns
    -------
    Widget
        What the cell shows.

    Raises
    ------
    TypeError
        For anything else.
    ImportError
        Without anywidget (extra `notebook`).

    Examples
    --------
    >>> import standfast as sf
    >>> widget = sf.explore(sf.Posture.box(width=0.3, height=0.5, friction=0.5))     # in a notebook: the last line of a cell
    >>> widget.posture.mass
    1.0
    """
    try:
        from standfast.widget import Widget
    except ImportError as error:
        raise ImportError("explore needs anywidget: pip install anywidget") from error
    return Widget(scene)
