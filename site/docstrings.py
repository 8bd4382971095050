"""The compiled module for the API pages: the stub beside it has the types, and neither docstrings nor all defaults."""

import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import griffe

#: Before a type that is a text, such as "float, m": it is shown as it is written, and not as an expression of Python.
AS_TEXT = "\u200b"
#: A line `name : type` of a table, unless the type is the name of a class, or such names with "or" between them.
TYPE = re.compile(r"^( *[*\w]+ : )(?!(?:[A-Z]\w*(?: or )?)+$)(?=\S)", re.MULTILINE)

#: An entry of a table that is for several names, with its text: each gets a row, with its own default.
SEVERAL = re.compile(
    r"^( *)(\w+(?:, \w+)+) : (.*)\n((?:(?:\1 +\S.*)?\n)*)", re.MULTILINE
)


class Docstrings(griffe.Extension):
    """Gives each object of the compiled module its docstring, and its signature as `help` shows it."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        compiled = importlib.import_module(f"{pkg.path}._core")
        path = Path(str(compiled.__file__)).with_name("_core.pyi")
        text = path.read_text(encoding="utf-8")
        stub = griffe.visit("_core", filepath=path, code=text, parent=pkg)
        _add(stub, compiled)
        # Each object has its place where users find it, so that nothing names the compiled module.
        homes = {}
        for module in (pkg, pkg["results"], pkg["theory"]):
            for name, member in list(module.members.items()):
                if not (member.is_alias and name in stub.members):
                    continue
                if member.target_path != f"{pkg.path}._core.{name}":
                    continue
                homes[name] = module.members[name] = stub[name]
                stub[name].parent = module
        for module in pkg.modules.values():
            for name, member in module.members.items():
                if member.is_alias and name in homes:
                    module.members[name] = griffe.Alias(
                        name, homes[name], parent=module
                    )
        del pkg.members["_core"]
        # A page has the names that a module is for.
        for module in pkg.modules.values():
            if module.exports is not None:
                for name in set(module.members) - set(map(str, module.exports)):
                    del module.members[name]
        _mark(pkg)


def _add(to: griffe.Module | griffe.Class, value: object) -> None:
    for name, overloads in to.overloads.items():
        if overloads:
            to.set_member(name, griffe.Function(name, lineno=overloads[0].lineno))
    for name, member in to.members.items():
        found = inspect.getattr_static(value, name, None)
        if found is None:
            continue
        thing = getattr(found, "__func__", found)
        text = inspect.getdoc(thing)
        if text:
            member.docstring = griffe.Docstring(text, parent=member, parser="numpy")
        if isinstance(member, griffe.Function):
            member.parameters = _parameters(thing)
        if isinstance(member, griffe.Class):
            _add(member, found)
            if "__new__" in member.members:
                constructor = griffe.Function("__init__", parameters=_parameters(found))
                member.set_member("__init__", constructor)


def _parameters(thing: Any) -> griffe.Parameters:
    """Names and defaults."""
    try:
        shown = inspect.signature(thing).parameters.values()
    except (TypeError, ValueError):
        return griffe.Parameters()
    return griffe.Parameters(
        *(
            griffe.Parameter(
                one.name,
                kind=griffe.ParameterKind[one.kind.name.lower()],
                default=None if one.default is one.empty else repr(one.default),
            )
            for one in shown
        )
    )


def _mark(at: griffe.Object | griffe.Alias) -> None:
    """Marks the types and the examples in the docstrings of this object and of its members."""
    if at.docstring is not None:
        text = SEVERAL.sub(_each, at.docstring.value + "\n")
        at.docstring.value = _fenced(TYPE.sub(rf"\1{AS_TEXT}", text))
    for member in at.members.values():
        if not member.is_alias:
            _mark(member)


def _each(entry: re.Match[str]) -> str:
    indent, names, kind, text = entry.groups()
    return "".join(f"{indent}{name} : {kind}\n{text}" for name in names.split(", "))


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
