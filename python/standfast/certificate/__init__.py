"""Checks certificates of verdicts, with the standard library of Python alone.

`check` derives everything again from the scene and shares no code with the core. There is no tolerance: a sign is certain, or the
certificate is refused. docs/certificates.md has the format and each step. The folder runs without the rest of the package:
`PYTHONPATH=python/standfast python -m certificate FILE`.
"""

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from . import jammed, mechanism
from .feet import descending_pair, neutral, no_solution, well
from .intervals import require
from .leaving import accelerating_mode, growing_cycle, growing_trap
from .levels import potential_well
from .potential import corner_map
from .rest import (
    goyal,
    not_equilibrium,
    single_support,
    theorem_3,
    theorem_3_loose,
)
from .scene import Body, body_of, entry

__all__ = ["check", "read", "summary"]


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


#: What a claim is about.
Scene = TypeVar("Scene", Body, mechanism.Rows)

#: The version of the format and of the conventions: axes, signs, names.
CONVENTIONS = 1


#: Largest certificate in bytes; those of random postures have up to 20 kB.
MOST_BYTES = 1_000_000


#: What each argument proves, and its check. "descending-pair" proves either.
CHECKS: dict[str, tuple[str, Callable[[Body, Any], Any]]] = {
    "not-equilibrium": ("unstable", not_equilibrium),
    "no-solution": ("unstable", no_solution),
    "accelerating-mode": ("unstable", accelerating_mode),
    "theorem-3": ("stable", theorem_3),
    "theorem-3-loose": ("stable", theorem_3_loose),
    "goyal": ("stable", goyal),
    "well": ("stable", well),
    "neutral": ("stable", neutral),
    "descending-pair": (
        "stable or unstable",
        lambda body, data: descending_pair(body, data, claimed),
    ),
    "corner-map": ("stable", corner_map),
    "growing-cycle": ("unstable", growing_cycle),
    "growing-trap": ("unstable", growing_trap),
    "single-support": ("unstable", single_support),
}

#: The same for mechanisms and assemblies, whose scene has a mass matrix.
MECHANISM_CHECKS: dict[str, tuple[str, Callable[[mechanism.Rows, Any], Any]]] = {
    "not-equilibrium": ("unstable", mechanism.not_equilibrium),
    "no-solution": ("unstable", jammed.no_solution),
    "potential-well": ("stable", potential_well),
}


def claimed(body: Body, certificate: Any) -> str:
    """Checks the claim of a certificate on a body, and returns it: "stable" or "unstable"."""
    return _proved(body, certificate, CHECKS)


def _proved(
    body: Scene,
    certificate: Any,
    checks: dict[str, tuple[str, Callable[[Scene, Any], Any]]],
) -> str:
    claim = entry(certificate, "claim", "certificate")
    stability, by = (
        entry(claim, key, "claim") for key in ("frictional_stability", "by")
    )
    require(
        isinstance(by, str) and by in checks,
        f"claim.by {by!r} is no argument that can be checked",
    )
    rule = "impact" if body.resolves_jams else "none"
    require(
        entry(claim, "jams", "claim") == rule,
        f"claim.jams {claim['jams']!r} is not {rule!r}",
    )
    require(
        entry(claim, "contacts", "claim") == [foot.name for foot in body.feet],
        f"claim.contacts {claim['contacts']!r} are not the contacts of the scene",
    )
    proves, check_claim = checks[by]
    try:
        proved = check_claim(body, entry(certificate, "data", "certificate")) or proves
    except ValueError as error:
        raise ValueError(f"{by}: {error}") from None
    require(
        stability == proved,
        f"claim.frictional_stability is {stability!r}; {by} proves {proved!r}",
    )
    return str(proved)


def check(certificate: Any) -> None:
    """Checks a certificate of a verdict, as `Verdict.certificate` makes it. Returns None if every step holds.

    Parameters
    ----------
    certificate : dict
        As it is read from JSON.

    Raises
    ------
    ValueError
        Names the step that does not hold, and the value.

    Examples
    --------
    >>> zero, half, one = map(float.hex, (0.0, 0.5, 1.0))
    >>> foot = {"number": 1, "point": [zero, zero], "slope": zero, "friction": half, "restitution": zero}
    >>> scene = {"mass": one, "gyration_radius": one, "center_of_mass": [one, one], "gravity": one, "contacts": [foot]}
    >>> claim = {"frictional_stability": "unstable", "by": "not-equilibrium", "contacts": [1], "jams": "none"}
    >>> cert = {"conventions": 1, "scene": scene, "claim": claim, "data": {"separates": [zero, (-0.5).hex(), (-1.0).hex()]}}
    >>> check(cert)
    >>> cert["data"]["separates"][2] = zero
    >>> check(cert)
    Traceback (most recent call last):
    ValueError: not-equilibrium: y·w of the edge n + μt of contact 1 is not certainly at least 0: in [-0.5, -0.5]
    """
    version = entry(certificate, "conventions", "certificate")
    require(
        type(version) is int and version == CONVENTIONS,
        f"conventions {version!r}: this program checks version {CONVENTIONS}",
    )
    scene = entry(certificate, "scene", "certificate")
    rule = entry(entry(certificate, "claim", "certificate"), "jams", "claim")
    if isinstance(scene, dict) and "mass_matrix" in scene:
        rows = replace(mechanism.rows_of(scene), resolves_jams=rule == "impact")
        _proved(rows, certificate, MECHANISM_CHECKS)
    else:
        claimed(replace(body_of(scene), resolves_jams=rule == "impact"), certificate)


def read(path: Path) -> Any:
    """The certificate in a file.

    Parameters
    ----------
    path : pathlib.Path

    Raises
    ------
    ValueError
        Names the line that is not JSON, or the key that is given twice.
    """
    with path.open("rb") as file:
        text = file.read(MOST_BYTES + 1)
    require(
        len(text) <= MOST_BYTES,
        f"the file has more than {MOST_BYTES} bytes, the most of a certificate",
    )
    try:
        return json.loads(text, object_pairs_hook=_once)
    except json.JSONDecodeError as error:
        raise ValueError(
            f"line {error.lineno}, column {error.colno}: {error.msg}"
        ) from None
    except (UnicodeDecodeError, RecursionError):
        raise ValueError("it is not a JSON text") from None


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The table of these entries, whose keys must differ: a reader and the checker must not see different values."""
    table = dict(pairs)
    if len(table) < len(pairs):
        [(key, _), *_] = Counter(key for key, _ in pairs).most_common(1)
        raise ValueError(f"the key {key!r} is given twice in one table")
    return table


def summary(certificate: Any) -> str:
    """The claim of a certificate that has been checked, and the scene on which it holds.

    Parameters
    ----------
    certificate : dict

    Returns
    -------
    str
        Some lines.
    """
    claim, scene = certificate["claim"], certificate["scene"]
    if "mass_matrix" in scene:
        numbers: tuple[str, ...] = ("mass_matrix", "load")
        rows: tuple[str, ...] = ("normal", "tangential", "tangential_restitution")
    else:
        numbers = ("mass", "gyration_radius", "center_of_mass", "gravity")
        rows = ("point", "slope")
    lines = [
        f"{claim['frictional_stability']} by {claim['by']}: every step holds",
        f"contacts {', '.join(map(str, claim['contacts']))}, jams = {claim['jams']!r}",
        _values(scene, *numbers),
    ]
    for foot in scene["contacts"]:
        values = _values(foot, *rows, "friction", "restitution")
        lines.append(f"contact {foot['number']}: {values}")
    return "\n  ".join(lines)


def _values(table: Any, *keys: str) -> str:
    """Doubles in decimals that have the same bits when they are read."""

    def decimal(value: Any) -> Any:
        if isinstance(value, list):
            return tuple(map(decimal, value))
        return float.fromhex(value)

    return ", ".join(f"{key} = {decimal(table[key])}" for key in keys)
