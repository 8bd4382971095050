"""Checks certificates of verdicts, with the standard library of Python alone.

`check` derives everything again from the scene and shares no code with the core. There is no tolerance: a sign is certain, or the
certificate is refused. docs/certificates.md has the format and each step. The folder runs without the rest of the package:
`PYTHONPATH=python/standfast python -m certificate FILE`.
"""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from .feet import descending_pair, neutral, no_solution, well
from .intervals import require
from .leaving import accelerating_mode, growing_cycle
from .potential import corner_map
from .rest import goyal, not_equilibrium, theorem_3, theorem_3_loose
from .scene import Body, body_of, entry

#: The version of the format and of the conventions: axes, signs, names.
CONVENTIONS = 1


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
}


def claimed(body: Body, certificate: Any) -> str:
    """Checks the claim of a certificate on a body, and returns it: "stable" or "unstable"."""
    claim = entry(certificate, "claim", "certificate")
    stability, by = (
        entry(claim, key, "claim") for key in ("frictional_stability", "by")
    )
    require(
        isinstance(by, str) and by in CHECKS,
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
    proves, check_claim = CHECKS[by]
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

    Raises ValueError naming the step and the value otherwise.

    >>> foot = {"number": 1, "point": ["0x0p0", "0x0p0"], "slope": "0x0p0", "friction": "0x1p-1", "restitution": "0x0p0"}
    >>> scene = {"mass": "0x1p0", "gyration_radius": "0x1p0", "center_of_mass": ["0x1p0", "0x1p0"], "gravity": "0x1p3", "contacts": [foot]}
    >>> claim = {"frictional_stability": "unstable", "by": "not-equilibrium", "contacts": [1], "jams": "none"}
    >>> cert = {"conventions": 1, "scene": scene, "claim": claim, "data": {"separates": ["0x0p0", "-0x1p-1", "-0x1p0"]}}
    >>> check(cert)
    >>> cert["data"]["separates"][2] = "0x0p0"
    >>> check(cert)
    Traceback (most recent call last):
    ValueError: not-equilibrium: y·w of the edge n + μt of contact 1 is not certainly at least 0: in [-0.5, -0.5]
    """
    version = entry(certificate, "conventions", "certificate")
    require(
        type(version) is int and version == CONVENTIONS,
        f"conventions {version!r}: this program checks version {CONVENTIONS}",
    )
    body = body_of(entry(certificate, "scene", "certificate"))
    rule = entry(entry(certificate, "claim", "certificate"), "jams", "claim")
    claimed(replace(body, resolves_jams=rule == "impact"), certificate)


def read(path: Path) -> Any:
    """The certificate in a file. Raises ValueError naming the line that is not JSON."""
    try:
        return json.loads(path.read_bytes())
    except json.JSONDecodeError as error:
        raise ValueError(
            f"line {error.lineno}, column {error.colno}: {error.msg}"
        ) from None
    except (UnicodeDecodeError, RecursionError):
        raise ValueError("it is not a JSON text") from None


def summary(certificate: Any) -> str:
    """One line on a certificate that has been checked."""
    claim = certificate["claim"]
    return f"{claim['frictional_stability']} by {claim['by']}: every step holds"
