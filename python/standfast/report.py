"""The report of a run, as text."""

import math
from collections.abc import Sequence
from decimal import ROUND_UP, Decimal
from typing import Any

import numpy as np

import standfast._core as sf
from standfast.table import (
    ROWS,
    aligned,
    contacts_named,
    counted,
    is_infinite,
    listed,
    mechanism_named,
    side_named,
)
from standfast.units import plain


def decimal(seconds: float) -> str:
    """A time in decimal notation: all digits of the double, and at least 12 after the point.

    >>> decimal(0.1), decimal(1.5e-15)
    ('0.100000000000', '0.0000000000000015')
    """
    if not math.isfinite(seconds):
        return str(seconds)
    digits = format(Decimal(repr(float(seconds))), "f")
    whole, _, fraction = digits.partition(".")
    return f"{whole}.{fraction:0<12}"


def estimate(seconds: float) -> str:
    """An error in decimal notation, rounded up to two digits.

    >>> estimate(1.234e-15), estimate(0.0)
    ('0.0000000000000013', '0.000000000000')
    """
    if not (0.0 < seconds < math.inf):
        return decimal(seconds)
    exact = Decimal(seconds)
    step = Decimal(1).scaleb(exact.adjusted() - 1)
    digits = format(exact.quantize(step, ROUND_UP), "f")
    whole, _, fraction = digits.partition(".")
    return f"{whole}.{fraction:0<12}"


def account(run: sf.Run, title: str) -> str:
    """The report of a run, as text."""
    lines = [title]

    def row(name: str, value: str) -> None:
        lines.append(f"  {name:<11} {value}")

    posture = run.posture
    if posture is not None:
        row(
            "body",
            f"mass {posture.mass:g} kg, radius of gyration {posture.gyration_radius:g} m,"
            f" centre of mass {_tuple(posture.center_of_mass)} m, gravity {posture.gravity:g} m/s^2",
        )
        for number, contact in enumerate(posture.contacts, start=1):
            e = contact.restitution
            row(
                f"contact {number}",
                f"point {_tuple(contact.point)} m, slope {plain(contact.slope)} rad,"
                f" friction {contact.friction:g},"
                + (f" radius {contact.radius:g} m," if contact.radius else "")
                + f" restitution {posture.restitution if e is None else e:g}",
            )
    if (mechanism := run.mechanism) is not None:
        row("mechanism", mechanism_named(mechanism))
        for number, foot in enumerate(mechanism.contacts, start=1):
            e = foot.restitution
            row(
                f"contact {number}",
                f"friction {foot.friction:g}, restitution {mechanism.restitution if e is None else e:g}",
            )
    sides = [contact for contact in run.contacts if contact.corner is not None]
    for side in sides[:ROWS]:
        row(f"contact {side.number}", f"{side_named(side)}, friction {side.friction:g}")
    if len(sides) > ROWS:
        row("", f"... and {len(sides) - ROWS} more sides (all with --json)")
    row("model", f"{run.model}: {run.model_reason}")

    impacts = run.impacts
    lines.append("")
    if len(impacts):
        no_gap = "; a side has no gap" if sides else ""
        lines.append(
            f"  impacts simulated one by one (rates: all gaps, in contact order{no_gap})"
        )
        table, listed_impacts = _impact_table(impacts)
        lines.extend(table)
        if len(impacts) > listed_impacts:
            more = len(impacts) - listed_impacts
            lines.append(f"    ... and {more} more (all with --json)")
    elif run.collisions:
        lines.append(
            f"  impacts simulated one by one: {run.collisions}, not recorded (record = false)"
        )
    else:
        lines.append("  no impact was simulated")

    lines.append("")
    if run.zeno_points:
        lines.append(f"  {_zeno_title(run.zeno_points)}")
        lines.extend(_zeno_table(run.zeno_points[:ROWS]))
        if len(run.zeno_points) > ROWS:
            lines.append(
                f"    ... and {len(run.zeno_points) - ROWS} more (all with --json)"
            )
        lines.extend(
            f"    {method}: {meaning}"
            for method, meaning in METHODS.items()
            if method in {method_named(point) for point in run.zeno_points}
        )
    else:
        lines.append("  no Zeno point")
    if proved := _enclosure(run):
        lines += ["", *proved]

    lines.append("")
    if run.phases:
        lines.append(
            "  phases (a letter for each contact: S separate, F fixed, R, L slides right, left)"
        )
        ends = {
            p.time: "plastic landing" if p.plastic else "contact at rest"
            for p in run.zeno_points
            if not is_infinite(p)
        }
        rows = [("mode", "start / s", "end / s", "begins with")]
        rows += [
            (p.mode, decimal(p.start), decimal(p.end), _cause(p, ends))
            for p in run.phases[:ROWS]
        ]
        lines.extend(aligned(rows))
        if len(run.phases) > ROWS:
            lines.append(f"    ... and {len(run.phases) - ROWS} more (all with --json)")
        lines.append("")
    row("outcome", f"{run.outcome} at {decimal(run.time)} s")
    if run.q is not None and run.qdot is not None:
        units = ("", "") if mechanism else (" m, m, rad", " m/s, m/s, rad/s")
        row("q", f"({_numbers(run.q)}){units[0]}")
        row("qdot", f"({_numbers(run.qdot)}){units[1]}")
    else:
        row("theta", f"{run.theta!r} rad")
        row("omega", f"{run.omega!r} rad/s")
    row("gaps", f"({_numbers(run.gaps)}) m")
    row("gap rates", f"({_numbers(run.rates)}) m/s")
    for warning in run.warnings:
        row("warning", warning)
    if run.undecided is not None:
        lines += ["", str(sf.contact_modes(run.undecided))]
    return "\n".join(lines)


def _impact_table(impacts: np.ndarray[Any, Any]) -> tuple[list[str], int]:
    """The first rows of the table of impacts, and the number of impacts in them. Impacts at one instant are one row, with the rates
    before the first and after the last of them."""
    rows = [("#", "time / s", "contact", "rates before / (m/s)", "rates after / (m/s)")]
    # The instants begin where the time changes.
    begins = np.flatnonzero(np.diff(impacts["elapsed"], prepend=-1.0))
    ends = [*begins[1:], len(impacts)]
    for begin, end in list(zip(begins, ends, strict=True))[:ROWS]:
        first, last = impacts[begin], impacts[end - 1]
        count = f"{begin + 1}" if end == begin + 1 else f"{begin + 1} to {end}"
        rows.append(
            (
                count,
                decimal(first["time"]),
                listed(sorted(set(impacts["contact"][begin:end].tolist()))),
                " ".join(f"{rate: .6e}" for rate in first["rates_before"]),
                " ".join(f"{rate: .6e}" for rate in last["rates_after"]),
            )
        )
    shown = ends[min(ROWS, len(ends)) - 1]
    return aligned(rows), int(shown)


#: Text of the report for each method of a Zeno point.
METHODS = {
    "bounce": "bouncing, summed in closed form if certified, else simulated until the speeds are below rounding",
    "clatter": "clattering on both contacts in turn, summed in closed form",
    "chatter": "infinitely many impacts in zero time",
    "rest": "the contact rests on the terrain from the start, without an impact",
    "self-similar": "impacts repeat on a smaller and smaller scale, summed as a geometric series",
    "mixed": "impacts without a pattern, simulated until the time left or the speeds are below rounding",
    "nested": "Zeno points that themselves accumulate, summed as a geometric series",
    "plastic": "the restitution is 0: the contact comes to rest in an impact, without rebound",
}


def method_named(point: sf.ZenoPoint) -> str:
    """The method of a Zeno point as the report names it: "plastic" instead of "bounce" where there is no rebound."""
    return "plastic" if point.plastic else point.method


def _zeno_title(points: list[sf.ZenoPoint]) -> str:
    """The title of the table: infinitely many impacts, plastic landings or contacts at rest from the start."""
    kinds = {
        "Zeno points (infinitely many impacts end)": any(map(is_infinite, points)),
        "plastic landings (no rebound)": any(p.plastic for p in points),
        "contacts on the ground from the start": any(
            p.method == "rest" for p in points
        ),
    }
    return ", ".join(kind for kind, there in kinds.items() if there)


def _enclosure(run: sf.Run) -> list[str]:
    """The lines of the report on proved times."""
    enclosure = run.enclosure
    if enclosure is None:
        return []
    proved = f"  proved, after the start: {counted(len(enclosure.impacts), 'impact')} within bounds (all with --json)"
    if enclosure.zeno is None:
        return [f"{proved}; then {enclosure.reason}"]
    low, high = map(decimal, enclosure.zeno)
    plastic = run.zeno_points[:1] and run.zeno_points[0].plastic
    first = "plastic landing" if plastic else "Zeno point"
    return [
        proved,
        f"    first {first}, of {contacts_named(enclosure.contacts)}: from {low} to {high} s",
    ]


def _zeno_table(points: list[sf.ZenoPoint]) -> list[str]:
    rows = [
        (
            "time / s",
            "error of the time / s",
            "kind",
            "contacts",
            "method",
            "certified",
            "summed",
        )
    ]
    rows += [
        (
            decimal(point.time),
            "about " + estimate(point.time_error),
            point.kind,
            listed(point.contacts),
            method_named(point),
            "yes" if point.certified else "no",
            "no impact"
            if point.method == "rest" or point.plastic
            else f"from impact {point.first_summed + 1} on",
        )
        for point in points
    ]
    return aligned(rows)


#: Text of the report for each event with which a phase begins.
CAUSES = {
    "lift-off": "lift-off of contact {}",
    "impact": "impact of contact {}",
    "ground-motion": "the motion of the ground changes",
    "kick": "kick",
    "left-segment": "end of the ground under contact {}",
    "slip": "contact {} breaks loose",
    "stop": "contact {} stops sliding",
    "zeno": "Zeno point",
}


def _cause(phase: sf.Phase, ends: dict[float, str]) -> str:
    """The event with which a phase begins. `ends`: text for each time at which contacts come to rest without infinitely many impacts."""
    if phase.cause == "zeno" and phase.start in ends:
        return ends[phase.start]
    return CAUSES.get(phase.cause, phase.cause).format(phase.contact)


def _tuple(values: Sequence[float]) -> str:
    return f"({', '.join(plain(value) for value in values)})"


def _numbers(values: np.ndarray[Any, Any]) -> str:
    return ", ".join(repr(float(value)) for value in values)
