"""Pictures of a run: the gaps over time, the gaps before a Zeno point, and the body. Needs matplotlib."""

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
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import LogLocator, NullLocator

from standfast._core import Posture, Run, ZenoPoint, write_whole
from standfast.table import contacts_named, counted, is_infinite

_Floats = npt.NDArray[np.float64]

#: Okabe and Ito's colours, which can be distinguished with every kind of colour vision.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1, 1, 1)))
MARKERS = ("o", "^", "s", "D")
SHADE = "0.93"
GROUND, SURFACE = "0.85", "0.5"
LANDING = "0.6"
#: Width of a figure, in inches.
WIDTH = 9.0

#: Samples of a curve between two events, and of a whole curve.
ARC, CURVE = 60, 6000
#: Samples in one revolution of the body.
TURN = 20
#: Largest number of impacts that are marked one by one.
MARKS = 500
#: Least distance between marks on the time axis, as a share of the run: about the width of a marker.
APART = 0.015
#: Least distance between marks in axes that are given, in inches.
MARK = 0.12
#: Where the curve of the approach ends after the last simulated impact: the share of the time then left.
BEYOND = 1e-3
#: Largest number of entries in a legend: more would not fit beside the axes.
LEGEND = 14
#: Times around an impact, relative to the time left, at which the curve is sampled near its cusp.
CUSP = np.array([-1e-2, -1e-3, -1e-4, 0.0, 1e-4, 1e-3, 1e-2])
#: Number of poses of the body that are drawn.
POSES = 5
#: Distances, in sizes of the body: a body that moves farther than the first is drawn only within the second of its end.
JOURNEY, NEAR = 12.0, 3.0
#: Room around the body and the ground beneath it, and thickness of the ground, as shares of their extent.
MARGIN, THICKNESS = 0.08, 0.05
#: Width, least height and largest height of the panel of the body, in inches, without labels and title.
PANEL, LOW, HIGH = WIDTH - 1.2, 1.2, 4.0
#: Part of that width that a legend beside the panel above needs, in inches.
BESIDE = 2.3
#: Largest number of contacts whose legend is drawn among the curves.
FEW = 2
#: Two lines of ground are the same where their directions (rad) and their positions (in sizes of the body) differ by less than this.
SAME_LINE = 1e-6
#: Height that labels and title of that panel need, in inches.
LABELS = 0.9
#: Impacts that are not summed are simulated until their speeds are below rounding. They accumulate over a time, and not at one
#: instant, if the time left at the last of them is less than this share of the time they took.
FOLLOWED = 1e-3


def _png(figure: Figure) -> bytes:
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


#: A figure that is not managed by pyplot. A notebook shows it where it is the value of a cell, and only there. (A class statement would
#: get a method `set` from matplotlib that stubtest refuses.)
Picture: type[Figure] = type("Picture", (Figure,), {"_repr_png_": _png})


def axes_or_none(ax: object) -> Axes | None:
    """`ax` if it is None or matplotlib axes; else raises TypeError."""
    if ax is None or isinstance(ax, Axes):
        return ax
    raise TypeError(
        f"ax = {ax!r} cannot be used: None or matplotlib axes, such as those of plt.subplots(), are allowed"
    )


def plot(
    run: Run, path: str | PathLike[str] | None = None, ax: object = None
) -> Figure | Axes:
    """Draw a run into a new figure, and save it if `path` is given; or draw its gaps over time into the axes `ax`.

    The suffix of `path` determines the format. The figure has up to three panels:

    1. the gaps over time, with the impacts marked on the terrain;
    2. if impacts accumulate, the gaps against the time left until the last Zeno point of an accumulation, with two logarithmic
       axes: accumulating impacts are evenly spaced here;
    3. if the run has a posture, the body over its terrain at some instants, to scale.
    """
    axes = axes_or_none(ax)
    if axes is not None:
        if path is not None:
            raise ValueError(
                f"path = {str(path)!r} cannot be used: None is allowed with ax; save the figure of the axes instead"
            )
        width = axes.get_window_extent().width / axes.figure.dpi
        draw_gaps(axes, run, max(APART, MARK / width), ABOVE)
        return axes
    point = accumulation(run)
    view = None if run.posture is None else View(run)
    heights = [3.2] + [3.5] * (point is not None)
    if view is not None:
        heights.append(view.height + LABELS)
    size = (WIDTH, sum(heights) + 0.3 * len(heights))
    figure = Picture(figsize=size, dpi=110, layout="constrained")
    grid = figure.add_gridspec(len(heights), 1, height_ratios=heights)
    panels = iter([figure.add_subplot(grid[row]) for row in range(len(heights))])

    top = next(panels)
    draw_gaps(top, run, APART, BY_SIDE if len(run.gaps) > FEW else AMONG)
    top.set_title(_headline(run), loc="left", fontsize=11)
    if point is not None:
        draw_approach(next(panels), run, point)
    if view is not None:
        draw_body(next(panels), view)
    if path is not None:
        save(figure, path)
    return figure


def save(figure: Figure, path: str | PathLike[str]) -> None:
    """Write a figure to exactly this path, whole or not at all. The suffix determines the format.

    Raises ValueError for a suffix that is no picture format, and OSError if the file cannot be written.
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
    """The last Zeno point at which infinitely many impacts accumulate over a time, and not at one instant."""
    reached = (point for point in run.zeno_points[::-1] if accumulates(run, point))
    return next(reached, None)


def is_summed(point: ZenoPoint) -> bool:
    """Whether the last impacts were summed, and not simulated until they are below rounding."""
    return point.certified or point.method not in ("bounce", "mixed")


def accumulates(run: Run, point: ZenoPoint) -> bool:
    """Whether infinitely many impacts accumulate at this point over a time, and not at one instant."""
    if not is_infinite(point) or point.method == "chatter" or point.time <= start(run):
        return False
    if is_summed(point):
        return True
    earlier = [p for p in run.zeno_points if p.elapsed < point.elapsed]
    since = earlier[-1].elapsed if earlier else 0.0
    elapsed = run.impacts["elapsed"]
    before = elapsed[(elapsed > since) & (elapsed < point.elapsed)]
    if not len(before):
        return False
    return bool(point.elapsed - before[-1] < FOLLOWED * (point.elapsed - since))


def start(run: Run) -> float:
    """Time at which the run starts, in s."""
    return run.time - run.elapsed


def event_times(run: Run) -> _Floats:
    """Times of the start, impacts, ends of phases, Zeno points and the end. The motion is smooth between them."""
    times = [start(run), run.time]
    times += [point.time for point in run.zeno_points]
    times += [t for phase in run.phases for t in (phase.start, phase.end)]
    known = np.concatenate([np.asarray(times), run.impacts["time"]])
    known = known[(known >= start(run)) & (known <= run.time)]
    return np.unique(known)


def curves(run: Run) -> tuple[_Floats, _Floats]:
    """Times (k,) at which the curves over time are sampled, dense where there are many events, and the gaps (k, n) there."""
    events = event_times(run)
    spin = abs(run.at(events[:-1])[1][:, 2])
    # A share for each piece, and one by its duration.
    arc = max(3, min(ARC, CURVE // len(events)))
    whole = max(run.elapsed, np.finfo(float).tiny)
    pieces = [events]
    for (begin, end), omega in zip(pairwise(events), spin, strict=True):
        turns = omega * (end - begin) / (2.0 * math.pi)
        points = arc + TURN * turns + ARC * (end - begin) / whole
        pieces.append(np.linspace(begin, end, int(min(points, CURVE))))
    for point in [p for p in run.zeno_points if is_infinite(p)][:MARKS]:
        before = events[events < point.time]
        if len(before):
            way = point.time - before[-1]
            pieces.append(point.time - way * np.geomspace(1e-6, 1.0, CURVE // 4))
    times = np.unique(np.concatenate(pieces))
    times = times[(times >= events[0]) & (times <= events[-1])]
    return sharpened(times, lambda t: run.gaps_at(t))


def sharpened(
    times: _Floats, gaps: Callable[[_Floats], _Floats]
) -> tuple[_Floats, _Floats]:
    """The sorted `times` with more times around the minima of the gaps, and the gaps there. These minima are summed impacts,
    which have no record."""
    height = gaps(times)
    for _ in range(4):
        low = (height[1:-1] < height[:-2]) & (height[1:-1] < height[2:])
        at = 1 + np.flatnonzero(low.any(axis=1))[:MARKS]
        around = np.linspace(times[at - 1], times[at + 1], 21).ravel()
        new = np.setdiff1d(around, times)
        if not len(new):
            break
        # Evaluating a summed tail is slow: no time is evaluated twice.
        times, height = np.append(times, new), np.vstack([height, gaps(new)])
        order = np.argsort(times)
        times, height = times[order], height[order]
    return times, height


def apart(times: _Floats, least: float) -> list[int]:
    """Indices of a subset of the sorted times in which neighbours are at least `least` apart.

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
    """Indices of the impacts that are marked: the first of each contact, and others that are far enough apart from these."""
    times = impacts["time"]
    firsts = np.unique(impacts["index"], return_index=True)[1]
    clear = (abs(times[:, None] - times[firsts]) >= least).all(axis=1)
    others = np.flatnonzero(clear)
    return sorted([*firsts, *others[apart(times[others], least)]])


def _contacts(run: Run) -> Iterator[tuple[int, dict[str, Any]]]:
    """The index of every contact and the style of its line."""
    for index in range(len(run.gaps)):
        look = {"color": COLORS[index % 4], "linestyle": LINES[_style(index)]}
        yield index, {"lw": 1.6, **look}


def _style(index: int) -> int:
    """Index of the line style or marker: the first 16 contacts differ in this or in their colour."""
    return (index + index // 4) % 4


#: Places of a legend: among the curves, beside the axes where many lines leave no room among the curves, and above the axes.
AMONG = {"loc": "best", "framealpha": 0.9, "fontsize": 9}
BY_SIDE = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0), "fontsize": 9}
ABOVE = {
    "loc": "lower left",
    "bbox_to_anchor": (0.0, 1.0),
    "frameon": False,
    "fontsize": 8,
    "borderpad": 0.2,
}


def draw_gaps(axes: Axes, run: Run, spacing: float, place: dict[str, Any]) -> None:
    """Gaps over time; markers on the terrain for the impacts that were simulated. `spacing`: see `APART`; `place`: of the legend.

    Impacts and Zeno points that would be drawn over one another are left out, and the legend says so.
    """
    t, gaps = curves(run)
    for index, look in _contacts(run):
        if not run.elapsed:  # one point needs a marker
            look |= {"marker": MARKERS[_style(index)], "clip_on": False}
        axes.plot(t, gaps[:, index], label=f"contact {index + 1}", **look)
    least = spacing * run.elapsed
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
    infinite = [p for p in run.zeno_points if is_infinite(p)]
    plastic = [p for p in run.zeno_points if p.plastic]
    _draw_times(axes, infinite, least, "Zeno point", "black")
    _draw_times(axes, plastic, least, "plastic landing", LANDING)
    highest = gaps[np.isfinite(gaps)].max(initial=0.0)
    axes.set_ylim(0.0, 1.05 * highest if highest > 0.0 else None)
    axes.margins(x=0.03)
    if not run.elapsed:
        axes.set_xticks([run.time])
        text = f"The run ends at its start: {run.outcome}"
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", fontsize=9)
    axes.set_xlabel("time / s")
    axes.set_ylabel("gap / m")
    _draw_legend(axes, place)
    _bare(axes)


def _draw_times(
    axes: Axes, points: list[ZenoPoint], least: float, name: str, color: str
) -> None:
    """Vertical lines where contacts come to rest."""
    times = np.array([point.time for point in points])
    lines = times[apart(times, least)]
    label: str | None = name
    if len(times) > 1:
        label = f"{name} ({_count(len(times), len(lines), 'found')})"
    for time in lines:
        axes.axvline(time, color=color, lw=1.0, ls=":", zorder=0, label=label)
        label = None


def _draw_legend(axes: Axes, place: dict[str, Any]) -> None:
    """The legend of the gaps at a place: among the curves, beside the axes or above them."""
    entries = list(zip(*axes.get_legend_handles_labels(), strict=True))
    if len(entries) > LEGEND:
        place = {**place, "title": f"the first {LEGEND} of {len(entries)}"}
        # Vertical lines, which are few, come first: they are not among those left out.
        entries.sort(key=lambda entry: "contact" in entry[1] or "impact on" in entry[1])
    handles, labels = zip(*entries[:LEGEND], strict=True)
    axes.legend(handles, labels, labelspacing=0.3, **place)


def _count(number: int, shown: int, what: str) -> str:
    return f"{number} {what}" + (f", {shown} shown" if shown < number else "")


def _mark(index: int) -> dict[str, Any]:
    """The style of the marker of an impact."""
    return {
        "linestyle": "none",
        "marker": MARKERS[_style(index)],
        "color": COLORS[index % 4],
        "markerfacecolor": "white",
        "markersize": 7,
        "zorder": 5,
    }


def _headline(run: Run) -> str:
    """The title: the event at which contacts come to rest, if there is only one; else the outcome and the numbers of events."""
    moving = [point for point in run.zeno_points if point.method != "rest"]
    resting = [point for point in run.zeno_points if point.method == "rest"]
    if len(moving) == 1 and run.outcome in ("rest", "zeno"):
        (point,) = moving
        who = contacts_named(point.contacts)
        when = f"at t = {point.time:.12f} s"
        if point.plastic:
            lands = "lands" if len(point.contacts) == 1 else "land"
            one = " in one impact" if len(point.contacts) == 1 else ""
            return f"{who.capitalize()} {lands}{one} without rebound (e = 0) {when}"
        if not accumulates(run, point):
            return f"Infinitely many impacts on {who} in one instant, {when}"
        return f"Infinitely many impacts on {who} end {when}"
    infinite = sum(map(is_infinite, moving))
    events = [
        counted(number, noun)
        for number, noun in (
            (run.collisions, "impact"),
            (len(moving) - infinite, "plastic landing"),
            (infinite, "Zeno point"),
        )
        if number
    ]
    if not events and resting:
        touch = "touches" if len(resting[0].contacts) == 1 else "touch"
        who = contacts_named(resting[0].contacts)
        events = [f"{who} {touch} the ground from the start"]
    suffix = "; " + ", ".join(events) if events else ""
    return f"Outcome: {run.outcome} at t = {run.time:.12f} s{suffix}"


def draw_approach(axes: Axes, run: Run, point: ZenoPoint) -> None:
    """Gaps against the time left until a Zeno point, with two logarithmic axes. Time increases to the right."""
    impacts = run.impacts
    before = impacts[(impacts["time"] < point.time) & (impacts["time"] >= start(run))]
    left = point.elapsed - before["elapsed"]
    whole = point.time - start(run)
    left_at_last = float(left[-1]) if len(left) else whole
    # The clock does not resolve a shorter time left.
    finest = 256.0 * math.ulp(max(abs(point.time), abs(start(run))))
    shortest = min(max(left_at_last * BEYOND, finest), 0.5 * whole)
    around = np.outer(left, 1.0 + CUSP).ravel()
    rest = np.concatenate([np.geomspace(whole, shortest, CURVE), around[:CURVE]])
    rest = np.unique(rest[(rest >= shortest) & (rest <= whole)])

    def gaps_before(rest: _Floats) -> _Floats:
        return run.gaps_at(np.clip(point.time - rest, start(run), point.time))

    rest, gaps = (values[::-1] for values in sharpened(rest, gaps_before))
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
    if is_summed(point):
        axes.axvspan(left_at_last, shortest, color=SHADE, zorder=-1)
        caption = "summed, not simulated\nand so on, for ever \u2192"
    else:
        caption = "simulated until the time left\nis below the rounding of the clock"
    axes.text(
        0.985,
        0.95,
        caption,
        transform=axes.transAxes,
        ha="right",
        va="top",
        fontsize=9,
        bbox={"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 2.0},
    )
    axes.set_title(
        f"The same against the time left until t = {point.time:.12f} s",
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
    """Limits of a logarithmic axis: from below the last bounces to above the largest gap."""
    gaps = np.where(np.isfinite(gaps), gaps, 0.0)  # infinite: no ground under a contact
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


def poses(run: Run) -> tuple[_Floats, list[_Floats], list[_Floats]]:
    """Times, and for each the points of the body (n + 1, 2), its contact points and its centre of mass; and its outline (k + 1, 2).

    Without an outline the convex hull of the contact points stands for it.

    The times go from the start to the end. If the body moves far, they cover only the part near the end.
    """
    posture = _posture(run)
    center = np.asarray(posture.center_of_mass)
    arms = np.array([contact.point for contact in posture.contacts]) - center
    times = np.linspace(start(run), run.time, 400)
    places = run.at(times)[0][:, :2]
    away = np.hypot(*(places - places[-1]).T) / body_size(posture)
    if away.max() > JOURNEY:
        times = times[np.flatnonzero(away > NEAR)[-1] :]
    times = np.unique(np.linspace(times[0], times[-1], POSES))
    outline = None if posture.outline is None else np.array(posture.outline) - center
    corners, outlines = [], []
    for x, y, theta in run.at(times)[0]:
        turn = np.array(
            [[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]]
        )
        at = center + np.array([x, y])
        corners.append(np.vstack([arms @ turn.T, [0.0, 0.0]]) + at)
        if outline is None:
            outlines.append(hull(corners[-1][:-1]))
        else:
            outlines.append(np.vstack([outline, outline[:1]]) @ turn.T + at)
    return times, corners, outlines


def body_size(posture: Posture) -> float:
    """The largest of the radius of gyration and the distances of the contacts from the centre of mass, m."""
    points = np.array([contact.point for contact in posture.contacts])
    arms = points - posture.center_of_mass
    return float(max(posture.gyration_radius, *np.hypot(*arms.T)))


#: A straight piece of ground: a point (2,), the direction (2,) with the air on its left, and the interval along it, m.
Piece = tuple[_Floats, _Floats, float, float]


def ground(posture: Posture) -> list[Piece]:
    """The ground of a posture as straight pieces: those of its polyline, or the line that all contacts share, or the contacts' own lines."""
    if posture.terrain is not None:
        vertices = np.array(posture.terrain)
        ways = np.diff(vertices, axis=0)
        lengths = np.hypot(*ways.T)
        return [
            (p, way / length, 0.0, float(length))
            for p, way, length in zip(vertices[:-1], ways, lengths, strict=True)
        ]
    points = np.array([contact.point for contact in posture.contacts])
    slopes = [contact.slope for contact in posture.contacts]
    tangents = np.column_stack([np.cos(slopes), np.sin(slopes)])
    if posture.ground == "shared":
        lowest = min(range(len(points)), key=lambda i: _cross(tangents[i], points[i]))
        return [(points[lowest], tangents[lowest], -math.inf, math.inf)]
    return joined(own_lines(posture, points, tangents), body_size(posture))


def own_lines(posture: Posture, points: _Floats, tangents: _Floats) -> list[Piece]:
    """The line of each contact. It ends where it meets the line of another contact between both contacts. If they do not meet there,
    each line ends halfway to the other contact. Lines that are the same do not end each other."""
    size = body_size(posture)
    pieces = []
    for i, contact in enumerate(posture.contacts):
        low, high = contact.segment
        for j in range(len(points)):
            to = points[j] - points[i]
            turn = _cross(tangents[i], tangents[j])
            if same_line((points[i], tangents[i]), (points[j], tangents[j]), size):
                continue
            along, back = float(to @ tangents[i]), -float(to @ tangents[j])
            if abs(along) < SAME_LINE * size and abs(turn) < SAME_LINE:
                continue  # one right above the other
            end = along / 2.0
            if turn != 0.0:
                # Where the lines meet, from contact i and from contact j.
                here = _cross(to, tangents[j]) / turn
                there = _cross(to, tangents[i]) / turn
                if here * along > 0.0 and there * back > 0.0:
                    end = here
            if end > 0.0:
                high = min(high, end)
            elif end < 0.0:
                low = max(low, end)
        pieces.append((points[i], tangents[i], float(low), float(high)))
    return pieces


def same_line(
    one: tuple[_Floats, _Floats], other: tuple[_Floats, _Floats], size: float
) -> bool:
    """Whether two lines, each a point and a direction, are the same for a body of this size."""
    side = _cross(one[1], other[0] - one[0])
    return max(abs(side) / size, abs(_cross(one[1], other[1]))) < SAME_LINE


def joined(pieces: list[Piece], size: float) -> list[Piece]:
    """The pieces, with one piece for those that overlap on the same side of the same line."""
    kept: list[Piece] = []
    for point, tangent, low, high in pieces:
        for other in [*kept]:
            alike = same_line((point, tangent), other[:2], size)
            along = float((other[0] - point) @ tangent)
            begin, end = along + other[2], along + other[3]
            if alike and tangent @ other[1] > 0.0 and begin <= high and low <= end:
                low, high = min(low, begin), max(high, end)
                kept = [piece for piece in kept if piece is not other]
        kept.append((point, tangent, low, high))
    return kept


def _cross(a: _Floats, b: _Floats) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def clipped(piece: Piece, low: _Floats, high: _Floats) -> tuple[float, float] | None:
    """The interval along a piece of ground in which it is inside the box from `low` (2,) to `high` (2,); None if it is outside.

    >>> flat = np.array([0.0, 1.0]), np.array([1.0, 0.0]), -np.inf, 3.0
    >>> clipped(flat, np.array([-2.0, 0.0]), np.array([2.0, 2.0]))
    (-2.0, 2.0)
    """
    point, tangent, first, last = piece
    for axis in range(2):
        if tangent[axis] == 0.0:
            if not low[axis] <= point[axis] <= high[axis]:
                return None
            continue
        with np.errstate(over="ignore"):  # all but parallel to this side of the box
            ends = (np.array([low[axis], high[axis]]) - point[axis]) / tangent[axis]
        first, last = max(first, float(ends.min())), min(last, float(ends.max()))
    return (first, last) if first < last else None


class View:
    """The body at some instants, the ground around it, and the box that shows both, to scale.

    times (k,), s; corners and outlines: see `poses`, m; low, high (2,), m: the box; height: of the panel, in inches.
    """

    def __init__(self, run: Run) -> None:
        self.posture = _posture(run)
        self.times, self.corners, self.outlines = poses(run)
        self.pieces = ground(self.posture)
        shown = np.vstack(self.corners)
        if len(self.posture.contacts) == 1:  # its circle of gyration
            radius = self.posture.gyration_radius
            centers = shown[1::2]
            shown = np.vstack([shown, centers - radius, centers + radius])
        shown = np.vstack([shown, *self.outlines, *self._beneath()])
        low, high = shown.min(axis=0), shown.max(axis=0)
        margin = MARGIN * float((high - low).max())
        wide, tall = high - low + 2.0 * margin
        panel = PANEL - BESIDE * (len(self.posture.contacts) > FEW)
        self.height = float(np.clip(panel * tall / wide, LOW, HIGH))
        # Where the panel is wider or higher than its contents, the ground fills it.
        scale = max(wide / panel, tall / self.height)
        middle, half = 0.5 * (low + high), 0.5 * scale * np.array([panel, self.height])
        self.low, self.high = middle - half, middle + half

    def _beneath(self) -> Iterator[_Floats]:
        """The points of the ground (1, 2) that are nearest to the contacts, for poses in which the body is not far from the ground."""
        reach = JOURNEY * body_size(self.posture)
        points, tangents, first, last = map(np.array, zip(*self.pieces, strict=True))
        for shape in self.corners:
            for foot in shape[:-1]:
                along = np.clip(((foot - points) * tangents).sum(axis=1), first, last)
                places = points + tangents * along[:, None]
                away = np.hypot(*(foot - places).T)
                nearest = int(away.argmin())
                if away[nearest] <= reach:
                    yield places[nearest : nearest + 1]


def draw_body(axes: Axes, view: View) -> None:
    """The body over its terrain, to scale, at some instants of the run: its arms, its hull, its contacts."""
    posture = view.posture
    extent = view.high - view.low
    depth = THICKNESS * float(extent.min())
    shown = []
    for piece in view.pieces:
        if (ends := clipped(piece, view.low, view.high)) is not None:
            point, tangent, *_ = piece
            line = point + np.outer(ends, tangent)
            shown.append((line, line + depth * np.array([tangent[1], -tangent[0]])))
    for (line, under), (then, under_then) in pairwise(
        [*shown, shown[-1]] if shown else []
    ):
        axes.add_patch(
            Polygon(np.vstack([line, under[::-1]]), color=GROUND, lw=0.0, zorder=0)
        )
        if (line[1] == then[0]).all():  # the corner between two pieces of a polyline
            corner = np.vstack([line[1], under[1], under_then[0]])
            axes.add_patch(Polygon(corner, color=GROUND, lw=0.0, zorder=0))
    for line, _ in shown:
        axes.plot(
            *line.T, color=SURFACE, lw=1.0, zorder=0.5, scalex=False, scaley=False
        )
    shades = np.linspace(0.0, 0.8, len(view.times))[::-1]
    poses = zip(view.times, view.corners, view.outlines, shades, strict=True)
    for t, shape, outline, shade in poses:
        last = t == view.times[-1]
        label = f"t = {t:.6g} s" if last or t == view.times[0] else None
        style: dict[str, Any] = {"color": str(shade), "solid_joinstyle": "round"}
        axes.plot(*outline.T, lw=1.8 if last else 1.0, label=label, **style)
        arms = np.full((3 * len(shape) - 3, 2), np.nan)
        arms[0::3], arms[1::3] = shape[-1], shape[:-1]
        axes.plot(*arms.T, lw=1.0 if last else 0.6, **style)
        axes.plot(*shape[-1], marker="+", color=str(shade), markersize=7)
        if len(shape) == 2:  # one contact: the circle of gyration stands for the body
            radius = posture.gyration_radius
            axes.add_patch(Circle(shape[-1], radius, fill=False, edgecolor=str(shade)))
        for index, corner in enumerate(shape[:-1]):
            if last:
                axes.plot(*corner, **{**_mark(index), "markersize": 6})
    parts = "Contacts and centre of mass (+), joined by lines"
    if len(posture.contacts) > 2:
        parts = "Contacts with their hull, and centre of mass (+)"
    if posture.outline is not None:
        parts = "Body with its contacts, and centre of mass (+)"
    if len(posture.contacts) == 1:
        parts = "Contact, centre of mass (+) and circle of gyration"
    axes.set_title(f"{parts}; to scale", loc="left", fontsize=11)
    axes.set_aspect("equal", adjustable="box", anchor="W")
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    axes.set_xlabel("x / m")
    axes.set_ylabel("y / m")
    axes.legend(loc="upper right", fontsize=9)
    _bare(axes)


def hull(points: _Floats) -> _Floats:
    """Convex hull of points (n, 2), as a closed line (k + 1, 2), counterclockwise (Andrew's monotone chain).

    >>> hull(np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [1.0, 1.0]])).tolist()
    [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0], [0.0, 0.0]]
    """
    points = np.unique(points, axis=0)
    chain: list[_Floats] = []
    for way in (points, points[::-1]):
        begin = len(chain)
        for point in way:
            while (
                len(chain) >= begin + 2
                and _cross(chain[-1] - chain[-2], point - chain[-1]) <= 0.0
            ):
                chain.pop()
            chain.append(point)
        chain.pop()
    return np.vstack([*chain, chain[0]]) if chain else points


def _bare(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
