"""The docstrings of the compiled module for the API pages: the stub beside it has the types, and no docstrings."""

import importlib
import inspect
from typing import Any

import griffe


class Docstrings(griffe.Extension):
    """Adds its docstring to each object of the compiled module."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        _add(pkg["_core"], importlib.import_module(f"{pkg.path}._core"))
        _mark(pkg)


def _add(to: griffe.Object, value: object) -> None:
    for name, member in to.members.items():
        found = inspect.getattr_static(value, name, None)
        if found is None:
            continue
        text = inspect.getdoc(getattr(found, "__func__", found))
        if text:
            member.docstring = griffe.Docstring(_fenced(text), parent=member)
        if member.is_class:
            _add(member, found)


def _mark(at: griffe.Object) -> None:
    """Marks the examples in the docstrings of this object and of its members."""
    if at.docstring is not None:
        at.docstring.value = _fenced(at.docstring.value)
    for member in at.members.values():
        if not member.is_alias:
            _mark(member)


def _fenced(text: str) -> str:
    """Its examples as blocks of code: from a line with >>> up to the next empty line."""
    if "```" in text:
        return text
    lines, inside = [], False
    for line in [*text.splitlines(), ""]:
        if not inside and line.lstrip().startswith(">>>"):
            lines.append("```pycon")
            inside = True
        elif inside and not line.strip():
            lines.append("```")
            inside = False
        lines.append(line)
    return "\n".join(lines)
