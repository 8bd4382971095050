"""Tables for a person to read."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

import standfast as sf

#: Rows of a table that are printed.
ROWS = 20
#: Forces of a word that are printed.
FORCES = 3


def aligned(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Rows in aligned columns; the first one heads them."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["    " + "  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def modes_table(modes: sf.Modes) -> str:
    """Contact modes: consistent words first, then those that fail by least.

    >>> ball = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, 1), restitution=0,
    ...                   gravity=10, contacts=[sf.Contact(point=(0, 0), friction=0.5)])
    >>> print(sf.contact_modes(ball))
      contact modes (a letter for each contact: S separate, F fixed, R, L slides right, left)
        word  consistent                   acceleration / (m/s^2, rad/s^2)  forces (tangential, normal) / N
        F     yes                          (0, 0, 0)                        1: (0, 10)
        S     no: contact 1: a_n > 0 by 1  (0, -10, 0)                      none
        R     no: contact 1: a_t > 0 by 1  (-5, 0, -5)                      1: (-5, 10)
        L     no: contact 1: a_t < 0 by 1  (5, 0, 5)                        1: (5, 10)
      status  unique: F
    """
    solved = [modes[word] for word in modes]
    solved.sort(key=_failure)
    shown = max(ROWS, len(modes.consistent))
    units = (
        ("acceleration / (m/s^2, rad/s^2)", "forces (tangential, normal) / N")
        if modes.level == "acceleration"
        else ("velocity after / (m/s, rad/s)", "impulses (tangential, normal) / (N s)")
    )
    rows = [("word", "consistent", *units)]
    rows += [_row(mode) for mode in solved[:shown]]
    lines = [
        "  contact modes (a letter for each contact: S separate, F fixed, R, L slides right, left)",
        *aligned(rows),
    ]
    if len(solved) > shown:
        lines.append(f"    ... and {len(solved) - shown} more, none of them consistent")
    if any(mode.near_degenerate for mode in solved[:shown]):
        lines.append(
            "    tie: a test is met or missed by so little that rounding may decide"
        )
    lines += [
        f"  {mode.word}  holds with any internal force from {low:.6g} to {high:.6g} along the line"
        " between the contacts"
        for mode in solved
        if mode.consistent and mode.force_interval is not None
        for low, high in [np.add(mode.force_interval, 0.0)]
    ]
    lines += [
        f"  {mode.word}  the motion depends on how the contacts share their forces; that of the smallest is given"
        for mode in solved
        if mode.consistent and mode.determined == "undetermined"
    ]
    words = ", ".join(modes.consistent)
    lines.append(f"  status  {modes.status}{': ' if words else ''}{words}")
    lines += [
        f"  jams    contact {number} while it slides {'right' if way == 'R' else 'left'}:"
        f" friction is above {critical:.6g}"
        for number, way, margin, critical in modes.problem.jamming
        if margin <= 0.0
    ]
    return "\n".join(lines)


def _failure(mode: sf.ContactMode) -> tuple[bool, bool, float]:
    """How far a word is from being consistent; 0 for all that are."""
    worst = min((value for _, _, value in mode.margins), default=0.0)
    return (
        not mode.consistent,
        mode.determined == "impossible",
        0.0 if mode.consistent else -worst,
    )


def _row(mode: sf.ContactMode) -> tuple[str, str, str, str]:
    tie = ", tie" if mode.near_degenerate else ""
    if mode.determined == "impossible":
        return mode.word, "no: no forces lead to it", "", ""
    if mode.consistent:
        verdict = "yes"
    else:
        failed = set(mode.violated)
        number, test, value = min(
            (m for m in mode.margins if f"contact {m[0]}: {m[1]}" in failed),
            key=lambda m: m[2],
        )
        verdict = f"no: contact {number}: {test} by {abs(value):.3g}"
        if len(failed) > 1:
            verdict += f", and {len(failed) - 1} more"
    return mode.word, verdict + tie, _vector(mode.acceleration), _forces(mode.forces)


def _forces(forces: npt.NDArray[np.float64]) -> str:
    """Those that are not zero, with the numbers of their contacts."""
    acting = [f"{i}: {_vector(f)}" for i, f in enumerate(forces, start=1) if f.any()]
    if len(acting) > FORCES:
        acting[FORCES:] = [f"and {len(acting) - FORCES} more"]
    return "  ".join(acting) or "none"


def _vector(values: npt.NDArray[np.float64]) -> str:
    # Adding zero turns −0 into 0.
    return f"({', '.join(f'{value + 0.0:.6g}' for value in values)})"
