"""Messages for mistyped keywords, with the nearest keyword that the function has."""

import inspect
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from operator import attrgetter

from standfast import _core


def parameters(function: Callable[..., object]) -> list[str]:
    """The names of the parameters of a function, without `self` and `options`."""
    names = inspect.signature(function).parameters
    return [name for name in names if name not in ("self", "options")]


def keywords(function: str) -> list[str]:
    """The names of the parameters of a function of the compiled module.

    >>> keywords("stability")
    ['posture', 'jams', 'trials', 'seed']
    """
    return parameters(attrgetter(function)(_core))


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
    """What is allowed instead of an unknown option of a run: the other keywords of `simulate`.

    >>> no_option("modle")
    "the options of simulate are model, impact, ..., certify; did you mean 'model'?"
    """
    not_an_option = ("posture", "q", "qdot", "kicks", "ground_motion")
    options = [one for one in keywords("simulate") if one not in not_an_option]
    return f"the options of simulate are {', '.join(options)}{nearest(name, options)}"
