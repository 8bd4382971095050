"""Pictures of a run: the gaps, their way into the Zeno point, and the body. Needs matplotlib."""

import math
from collections.abc import Callable, Iterator
from io import BytesIO
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import LogLocator, NullLocator

from standfast._core import Posture, Run, ZenoPoint, write_whole

_Floats = npt.NDArray[np.float64]

#: Okabe and Ito's colours: told apart with every kind of colour vision.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1, 1, 1)))
MARKERS = ("o", "^", "s", "D")
SHADE = "0.93"
GROUND = "0.8"
#: Width of a figure, in inches.
WIDTH = 9.0

#: Samples of a curve between two events, and of a whole curve.
ARC, CURVE = 60, 6000
#: Samples of a turn of the body.
TURN = 20
#: Impacts that are marked one by one.
MARKS = 500
#: Least distance of marks over time, as a share of the run: about the width of a marker.
APART = 0.015
#: How far the approach is followed beyond the last simulated impact: share of the time then left.
BEYOND = 1e-3
#: Entries of a legend: more of them would not fit beside the axes.
LEGEND = 14
#: Distances from an impact, relative to the time left, at which the curve into its cusp is sampled.
CUSP = np.array([-1e-2, -1e-3, -1e-4, 0.0, 1e-4, 1e-3, 1e-2])
#: Poses of the body that are drawn.
POSES = 5
#: Distances, in sizes of the body: of a journey that is long, and of what is near its end.
JOURNEY, NEAR = 12.0, 3.0


def plot(run: Run, path: str | PathLike[str] | None = None) -> Figure:
    """Draw a run and, if `path` is given, save the figure there (the suffix says the format).

    Panels, as far as the run has them:

    1. the gaps over time, with the impacts marked on the terrain;
    2. the same against the time that is left until the Zeno point, both axes logarithmic: impacts that
       pile up in time stand evenly spaced here, and go on so for ever;
    3. the body over its terrain at some moments, to scale.
    """
    point = accumulation(run)
    heights = (
        [3.2]
        + [3.5] * (point is not None)
        + [_body_height(run)] * (run.posture is not None)
    )
    size = (WIDTH, sum(heights) + 0.3 * len(heights))
    if path is None:
        import matplotlib.pyplot as plt

        figure = plt.figure(figsize=size, dpi=110, layout="constrained")
    else:
        figure = Figure(figsize=size, dpi=110, layout="constrained")
    grid = figure.add_gridspec(len(heights), 1, height_ratios=heights)
    axes = iter([figure.add_subplot(grid[row]) for row in range(len(heights))])

    draw_gaps(next(axes), run)
    if point is not None:
        draw_approach(next(axes), run, point)
    if run.posture is not None:
        draw_body(next(axes), run)
    if path is not None:
        save(figure, path)
    return figure


def save(figure: Figure, path: str | PathLike[str]) -> None:
    """Write a figure to exactly this path, whole or not at all; its suffix says the format.

    Raises ValueError for a suffix that is none, and OSError where it cannot be written.
    """
    target = Path(path)
    kind = target.suffix[1:].lower()
    known = sorted(figure.canvas.get_supported_filetypes())
    if kind not in known:
        raise ValueError(
            f"path = {str(path)!r} cannot be used: a file name that ends in one of {', '.join(known)} is allowed"
        )
    picture = BytesIO()
    figure.savefig(picture, format=kind)
    write_whole(target, picture.getvalue())


def accumulation(run: Run) -> ZenoPoint | None:
    """The first Zeno point that impacts have led to, if there is one."""
    reached = (p for p in run.zeno_points if p.method != "rest" and p.time > start(run))
    return next(reached, None)


def start(run: Run) -> float:
    """Time at which the run starts, in s."""
    return run.time - run.elapsed


def event_times(run: Run) -> _Floats:
    """Start, impacts, ends of phases, Zeno points and end: the motion is smooth in between."""
    times = [start(run), run.time]
    times += [point.time for point in run.zeno_points]
    times += [t for phase in run.phases for t in (phase.start, phase.end)]
    known = np.concatenate([np.asarray(times), run.impacts["time"]])
    known = known[(known >= start(run)) & (known <= run.time)]
    return np.unique(known)


def curve_times(run: Run) -> _Floats:
    """Times at which the curves over time are sampled: dense where the motion is busy."""
    events = event_times(run)
    spin = abs(run.at(events[:-1])[1][:, 2])
    arc = max(3, min(ARC, CURVE // len(events)))
    pieces = [events]
    for (begin, end), omega in zip(pairwise(events), spin, strict=True):
        turns = omega * (end - begin) / (2.0 * math.pi)
        pieces.append(np.linspace(begin, end, int(min(arc + TURN * turns, CURVE))))
    for point in run.zeno_points[:MARKS]:
        before = events[events < point.time]
        if len(before):
            way = point.time - before[-1]
            pieces.append(point.time - way * np.geomspace(1e-6, 1.0, CURVE // 4))
    times = np.unique(np.concatenate(pieces))
    times = times[(times >= events[0]) & (times <= events[-1])]
    return sharpened(times, lambda t: run.gaps_at(t)[0])


def sharpened(times: _Floats, gaps: Callable[[_Floats], _Floats]) -> _Floats:
    """`times` with more of them around the lows of the gaps: impacts that were summed have no record."""
    for _ in range(4):
        height = gaps(times)
        low = (height[1:-1] < height[:-2]) & (height[1:-1] < height[2:])
        at = 1 + np.flatnonzero(low.any(axis=1))[:MARKS]
        around = np.linspace(times[at - 1], times[at + 1], 21).ravel()
        times = np.unique(np.concatenate([times, around]))
    return times


def apart(times: _Floats, least: float) -> list[int]:
    """Indices of the times, sorted ones, that are left if none follows another by less than `least`.

    >>> apart(np.array([0.0, 0.5, 1.0, 1.1, 3.0]), 1.0)
    [0, 2, 4]
    """
    kept: list[int] = []
    index = 0
    while index < len(times):
        kept.append(index)
        index = max(index + 1, int(np.searchsorted(times, times[index] + least)))
    return kept


def marked(impacts: npt.NDArray[Any], least: float) -> list[int]:
    """Indices of the impacts that are marked: the first of each contact, and what stands apart from it."""
    times = impacts["time"]
    firsts = np.unique(impacts["index"], return_index=True)[1]
    clear = (abs(times[:, None] - times[firsts]) >= least).all(axis=1)
    others = np.flatnonzero(clear)
    return sorted([*firsts, *others[apart(times[others], least)]])


def _contacts(run: Run) -> Iterator[tuple[int, dict[str, Any]]]:
    """Every contact's index and the look of its line."""
    for index in range(len(run.gaps)):
        look = {"color": COLORS[index % 4], "linestyle": LINES[index % 4], "lw": 1.6}
        yield index, look


def draw_gaps(axes: Axes, run: Run) -> None:
    """Gaps over time; markers on the terrain for the impacts that were simulated.

    Impacts and Zeno points that would be drawn over one another are left out, and the legend says so.
    """
    t = curve_times(run)
    gaps, _ = run.gaps_at(t)
    for index, look in _contacts(run):
        axes.plot(t, gaps[:, index], label=f"contact {index + 1}", **look)
    least = APART * run.elapsed
    impacts = run.impacts
    shown = impacts[marked(impacts, least)]
    for index, _ in _contacts(run):
        hits = impacts["time"][impacts["index"] == index]
        if len(hits):
            seen = shown["time"][shown["index"] == index]
            axes.plot(
                seen,
                np.zeros_like(seen),
                clip_on=False,
                label=f"impact on {index + 1} ({_count(len(hits), len(seen), 'simulated')})",
                **_mark(index),
            )
    ends = np.array([p.time for p in run.zeno_points if p.method != "rest"])
    lines = ends[apart(ends, least)]
    label: str | None = "Zeno point"
    if len(ends) > 1:
        label = f"Zeno point ({_count(len(ends), len(lines), 'found')})"
    for time in lines:
        axes.axvline(time, color="black", lw=1.0, ls=":", zorder=0, label=label)
        label = None
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.03)
    axes.set_xlabel("time / s")
    axes.set_ylabel("gap / m")
    axes.set_title(_headline(run), loc="left", fontsize=11)
    place: dict[str, Any] = {"loc": "best", "framealpha": 0.9}
    if len(run.gaps) > 2:  # many lines leave no room among the curves
        place = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > LEGEND:
        place["title"] = f"the first {LEGEND} of {len(labels)}"
    axes.legend(handles[:LEGEND], labels[:LEGEND], frameon=True, fontsize=9, **place)
    _bare(axes)


def _count(number: int, shown: int, what: str) -> str:
    return f"{number} {what}" + (f", {shown} shown" if shown < number else "")


def _mark(index: int) -> dict[str, Any]:
    """The look of an impact's marker."""
    return {
        "linestyle": "none",
        "marker": MARKERS[index % 4],
        "color": COLORS[index % 4],
        "markerfacecolor": "white",
        "markersize": 7,
        "zorder": 5,
    }


def _headline(run: Run) -> str:
    point = accumulation(run)
    if point is None:
        return f"Outcome: {run.outcome} at t = {run.time:.12f} s"
    who = " and ".join(map(str, point.contacts))
    contacts = f"contact {who}" if len(point.contacts) == 1 else f"contacts {who}"
    count = sum(other.method != "rest" for other in run.zeno_points)
    first = f" (first of {count} Zeno points)" if count > 1 else ""
    return (
        f"Infinitely many impacts on {contacts} end at t = {point.time:.12f} s{first}"
    )


def draw_approach(axes: Axes, run: Run, point: ZenoPoint) -> None:
    """Gaps against the time left until a Zeno point, both logarithmic, time running to the right."""
    impacts = run.impacts
    before = impacts[(impacts["time"] < point.time) & (impacts["time"] >= start(run))]
    left = point.elapsed - before["elapsed"]
    whole = point.time - start(run)
    left_at_last = float(left[-1]) if len(left) else whole
    # The clock resolves no more than this of the time that is left.
    finest = 256.0 * math.ulp(max(abs(point.time), abs(start(run))))
    shortest = min(max(left_at_last * BEYOND, finest), 0.5 * whole)
    around = np.outer(left, 1.0 + CUSP).ravel()
    rest = np.concatenate([np.geomspace(whole, shortest, CURVE), around[:CURVE]])
    rest = np.unique(rest[(rest >= shortest) & (rest <= whole)])

    def gaps_before(rest: _Floats) -> _Floats:
        return run.gaps_at(np.clip(point.time - rest, start(run), point.time))[0]

    rest = sharpened(rest, gaps_before)[::-1]
    gaps = gaps_before(rest)
    low, high = _decades(rest, gaps)
    for index, look in _contacts(run):
        hits = left[before["index"] == index]
        height = np.where(np.isin(rest, hits), 0.0, gaps[:, index])
        axes.plot(rest, np.maximum(height, 1e-3 * low), **look)
        if 0 < len(hits) and len(before) <= MARKS:
            at_bottom = {"transform": axes.get_xaxis_transform(), **_mark(index)}
            axes.plot(hits, np.full_like(hits, 0.05), **at_bottom)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(whole, shortest)
    axes.set_ylim(low, high)
    axes.axvspan(left_at_last, shortest, color=SHADE, zorder=-1)
    axes.text(
        0.985,
        0.95,
        "summed, not simulated\nand so on, for ever \u2192",
        transform=axes.transAxes,
        ha="right",
        va="top",
        fontsize=9,
    )
    axes.set_title(
        "The same against the time that is left: it repeats, ever smaller and ever faster",
        loc="left",
        fontsize=11,
    )
    axes.set_xlabel("time left until the Zeno point / s")
    axes.set_ylabel("gap / m")
    axes.xaxis.set_major_locator(LogLocator(numticks=20))
    axes.yaxis.set_major_locator(LogLocator(numticks=9))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_locator(NullLocator())
    _bare(axes)


def _decades(rest: _Floats, gaps: _Floats) -> tuple[float, float]:
    """Limits of a logarithmic axis: from below the last bounces to above everything."""
    gaps = np.where(np.isfinite(gaps), gaps, 0.0)  # nothing is under a contact
    high = float(gaps.max())
    if not high > 0.0:
        return 1e-3, 1.0
    # The last sixth of the other axis.
    late = gaps[rest <= rest.min() * (rest.max() / rest.min()) ** (1.0 / 6.0)]
    low = min((float(peak) for peak in late.max(axis=0) if peak > 0.0), default=high)
    low *= 0.02
    return low, high * max(3.0, (high / low) ** 0.15)  # room for a text at the top


def _posture(run: Run) -> Posture:
    if run.posture is None:
        raise ValueError("run has no posture: it is of a LocalModel")
    return run.posture


def poses(run: Run) -> tuple[_Floats, list[_Floats]]:
    """Times, and for each the corners of the body (m, 2): its contact points, then its centre of mass.

    From the start to rest, or to the first Zeno point; of a long journey only the end, near where it leads.
    """
    posture = _posture(run)
    center = np.asarray(posture.center_of_mass)
    arms = np.array([contact.point for contact in posture.contacts]) - center
    point = accumulation(run)
    end = run.time if point is None or run.outcome == "rest" else point.time
    times = np.linspace(start(run), end, 400)
    places = run.at(times)[0][:, :2]
    size = max(posture.gyration_radius, *np.hypot(*arms.T))
    away = np.hypot(*(places - places[-1]).T) / size
    if away.max() > JOURNEY:
        times = times[np.flatnonzero(away > NEAR)[-1] :]
    times = np.unique(np.linspace(times[0], times[-1], POSES))
    corners = []
    for x, y, theta in run.at(times)[0]:
        turn = np.array(
            [[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]]
        )
        corners.append(np.vstack([arms @ turn.T, [0.0, 0.0]]) + center + [x, y])
    return times, corners


def _terrain(run: Run, corners: _Floats) -> list[_Floats]:
    """What is drawn of the terrain, as broken lines (k, 2): all of it, or a piece for every contact."""
    posture = _posture(run)
    contacts = posture.contacts
    low, high = corners[:, 0].min(), corners[:, 0].max()
    margin = 0.15 * max(high - low, float(np.ptp(corners[:, 1])), 1e-6)
    if posture.terrain is not None:
        vertices = np.array(posture.terrain)
        ends = np.clip([low - margin, high + margin], *vertices[[0, -1], 0])
        inner = vertices[(vertices[:, 0] > ends[0]) & (vertices[:, 0] < ends[1]), 0]
        x = np.concatenate([ends[:1], inner, ends[1:]])
        return [np.column_stack([x, np.interp(x, *vertices.T)])]
    points = [contact.point for contact in contacts]
    # Two terrains meet halfway between their contacts.
    middle = sum(x for x, _ in points) / len(points)
    pieces = []
    for contact in contacts:
        px, py = contact.point
        left, right = low - margin, high + margin
        if len(points) > 1:
            left, right = (left, middle) if px < middle else (middle, right)
        ends = px + math.cos(contact.slope) * np.array(contact.segment)
        x = np.clip([left, right], *ends)
        pieces.append(np.column_stack([x, py + math.tan(contact.slope) * (x - px)]))
    return pieces


def _body_height(run: Run) -> float:
    """Height of the panel of the body, in inches: as its contents ask for, within reason."""
    if run.posture is None:
        return 0.0
    corners = np.vstack(poses(run)[1])
    everything = np.vstack([corners, *_terrain(run, corners)])
    wide, high = np.ptp(everything, axis=0)
    return float(np.clip((WIDTH - 1.5) * high / max(wide, 1e-300) + 0.9, 1.5, 3.4))


def draw_body(axes: Axes, run: Run) -> None:
    """The body over its terrain, to scale, at some moments up to rest or to the first Zeno point."""
    posture = _posture(run)
    times, corners = poses(run)
    terrain = _terrain(run, np.vstack(corners))
    depth = 0.02 * float(np.ptp(np.vstack(terrain)[:, 0]))
    for x, y in (piece.T for piece in terrain):
        axes.fill_between(x, y - depth, y, color=GROUND, lw=0.0, zorder=0)
    shades = np.linspace(0.8, 0.0, len(times))
    for t, shape, shade in zip(times, corners, shades, strict=True):
        last = t == times[-1]
        # One contact or two are joined to the centre of mass, more of them to each other.
        outline = shape[:-1] if len(shape) > 3 else shape
        outline = np.vstack([outline, outline[:1]])
        label = f"t = {t:.6g} s" if last or t == times[0] else None
        axes.plot(*outline.T, color=str(shade), lw=1.8 if last else 1.0, label=label)
        axes.plot(*shape[-1], marker="+", color=str(shade), markersize=7)
        if len(shape) == 2:  # one contact: the circle of gyration stands for the body
            radius = posture.gyration_radius
            axes.add_patch(Circle(shape[-1], radius, fill=False, edgecolor=str(shade)))
        for index, corner in enumerate(shape[:-1]):
            if last:
                axes.plot(*corner, **{**_mark(index), "markersize": 6})
    parts = "Contacts and centre of mass, joined by lines"
    if len(posture.contacts) > 2:
        parts = "Contacts, joined by lines, and centre of mass (+)"
    if len(posture.contacts) == 1:
        parts = "Contact, centre of mass (+) and circle of gyration"
    axes.set_title(f"{parts}; to scale", loc="left", fontsize=11)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x / m")
    axes.set_ylabel("y / m")
    axes.legend(loc="upper right", fontsize=9, ncols=2)
    _bare(axes)


def _bare(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
