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


def options() -> list[str]:
    """The options of a run: the keywords of `simulate` that may be given by name only."""
    parameters = inspect.signature(standfast.simulate).parameters.values()
    return [p.name for p in parameters if p.kind is inspect.Parameter.KEYWORD_ONLY]


def nearest(name: str, names: Iterable[str]) -> str:
    """A question for the nearest name; empty if none is near.

    >>> nearest("modle", ["impact", "model"]), nearest("colour", ["impact", "model"])
    (" Did you mean 'model'?", '')
    """
    return "".join(
        f" Did you mean {near!r}?" for near in get_close_matches(name, names, 1)
    )


def unexpected(function: str, name: str, names: Iterable[str] = ()) -> str:
    """The message for a keyword that a function does not have. `names`: keywords that its signature does not list.

    >>> unexpected("Contact", "slop")
    "Contact() got an unexpected keyword argument 'slop'. Did you mean 'slope'?"
    """
    known = [*keywords(function), *names]
    return f"{function}() got an unexpected keyword argument {name!r}.{nearest(name, known)}"


def no_option(name: str) -> str:
    """What is allowed instead of an unknown option of a run.

    >>> no_option("modle")[:62]
    "Did you mean 'model'? The options of simulate are model, impac"
    """
    known = options()
    return (
        f"{nearest(name, known)} The options of simulate are {', '.join(known)}".strip()
    )
