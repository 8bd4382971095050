"""Messages for mistyped keywords, with the nearest keyword that the function has."""

import inspect
from collections.abc import Iterable
from difflib import get_close_matches
from operator import attrgetter

import standfast


def keywords(function: str) -> list[str]:
    """The names of the parameters of a function of the package.

    >>> keywords("stability")
    ['posture', 'trials', 'seed']
    """
    parameters = inspect.signature(attrgetter(function)(standfast)).parameters
    return [name for name in parameters if name not in ("self", "options")]


def nearest(name: str, names: Iterable[str]) -> str:
    """A question for the nearest name; empty if none is near.

    >>> nearest("modle", ["impact", "model"]), nearest("colour", ["impact", "model"])
    ("; did you mean 'model'?", '')
    """
    near = get_close_matches(name, list(names), 1)
    return f"; did you mean {near[0]!r}?" if near else ""


def unexpected(function: str, name: str) -> str:
    """The message for a keyword that a function does not have.

    >>> unexpected("Contact", "slop")
    "Contact() got an unexpected keyword argument 'slop'; did you mean 'slope'?"
    """
    meant = nearest(name, keywords(function))
    return f"{function}() got an unexpected keyword argument {name!r}{meant}"


def no_option(name: str) -> str:
    """What is allowed instead of an unknown option of a run: the keywords of `simulate` after the posture and the start.

    >>> no_option("modle")
    "the options of simulate are model, impact, ..., certify; did you mean 'model'?"
    """
    _, _, _, *options = keywords("simulate")
    return f"the options of simulate are {', '.join(options)}{nearest(name, options)}"
