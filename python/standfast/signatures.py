"""Signatures that a reader takes in at once."""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

_Function = TypeVar("_Function", bound=Callable[..., Any])


def with_names_only(function: _Function) -> _Function:
    """The function itself, of which `help` shows names and defaults alone: the types are in its docstring, and type checkers read the source.

    >>> @with_names_only
    ... def area(width: float, height: float = 1.0) -> float: ...
    >>> inspect.signature(area)
    <Signature (width, height=1.0)>
    """
    whole = inspect.signature(function)
    names = [
        parameter.replace(annotation=inspect.Parameter.empty)
        for parameter in whole.parameters.values()
    ]
    short = whole.replace(parameters=names, return_annotation=inspect.Signature.empty)
    setattr(function, "__signature__", short)  # noqa: B010 (a type checker knows no such attribute of a function)
    return function
