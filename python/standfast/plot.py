"""Pictures of a run: the body on its ground, what happens over time, and the gaps before a Zeno point. Needs matplotlib."""

import math
import pathlib
import textwrap
from collections.abc import Callable, Iterable, Iterator, Sequence
from io import BytesIO
from itertools import pairwise
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotParams
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.path import Path
from matplotlib.ticker import LogLocator, NullLocator
from matplotlib.transforms import Bbox

from standfast._core import GroundMotion, Kick, Posture, Run, ZenoPoint, write_whole
from standfast.scenery import Piece, body_outline, ground, spokes, surface
from standfast.table import contacts_named, counted, is_infinite, without_posture

_Floats = npt.NDArray[np.float64]

#: Okabe and Ito's colours, which can be distinguished with every kind of colour vision.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (5, 1, 1, 1)))
MARKERS = ("o", "^", "s", "D")
KICK = "#E69F00"
BODY = "#56B4E9"
SHADE = "0.93"
GROUND, SURFACE = "0.85", "0.5"
#: Of contacts that never touch the ground, where there are many; of the path of the centre of mass.
ALOOF, PATH = "0.8", "0.6"
#: Width of a figure, in inches, and the largest number of its panels.
WIDTH, PANELS = 7.0, 5
#: Heights of the panels of the gaps, of another quantity over time, and of the gaps against the time left, in inches.
GAPS, OTHER, APPROACH = 2.2, 1.5, 2.4
#: Most characters in a line of the headline.
HEADLINE = 72
#: Size of small text, in points.
SMALL = 8

#: Samples of a curve between two events, and of a whole curve.
ARC, CURVE = 60, 6000
#: Samples in one revolution of the body.
TURN = 20
#: Samples of the forces between two events, and the shortest time between these for which forces are drawn, as a share of the run.
FORCES, VISIBLE = 16, 1e-3
#: Least share of the run with contacts on the ground for which the forces have a panel, and least range of the angle (rad).
CLOSED, TURNED = 0.02, 0.05
#: Largest number of impacts that are marked one by one.
MARKS = 500
#: Least distance between marks on the time axis, as a share of the run: about the width of a marker.
APART = 0.015
#: Least distance between marks in axes that are given, in inches.
MARK = 0.12
#: Where the curve of the approach ends after the last simulated impact: the share of the time then left.
BEYOND = 1e-3
#: Largest number of entries in a legend; width of its columns and height of its rows, in inches.
LEGEND, COLUMN, ROW = 12, 1.3, 0.17
#: Times around an impact, relative to the time left, at which the curve is sampled near its cusp.
CUSP = np.array([-1e-2, -1e-3, -1e-4, 0.0, 1e-4, 1e-3, 1e-2])
#: Largest number of poses of the body that are drawn, and of instants among which they are chosen.
POSES, CHOICE = 7, 200
#: Least distance of two poses, as a share of the longest distance between poses, and in sizes of the body.
SPREAD, STEP = 0.15, 0.25
#: Distances, in sizes of the body: a body that moves farther than the first is drawn only within the second of its end.
JOURNEY, NEAR = 30.0, 8.0
#: Distance, in sizes of the body, from which the ground beneath a point of the body is not shown.
REACH = 12.0
#: Shares of the room that the body leaves in the panel: on its left, and below the ground.
BELOW = np.array([0.5, 0.3])
#: Room around the body and the ground beneath it, and thickness of the ground, as shares of their extent.
MARGIN, THICKNESS = 0.08, 0.05
#: Width of the labels beside the panel of the body, and least and largest height of the panel without labels and title, in inches.
BESIDE, LOW, HIGH = 0.7, 2.0, 4.6
#: Largest number of contacts that are all drawn in colour and whose numbers are written at the body.
FEW = 4
#: Height that labels and title of that panel need, in inches.
LABELS = 0.8
#: Impacts that are not summed are simulated until their speeds are below rounding. They accumulate over a time, and not at one
#: instant, if the time left at the last of them is less than this share of the time they took.
FOLLOWED = 1e-3
#: An accumulation is the main event of a run if it ends after this share of the run.
MAIN = 0.5


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


def fitted(axes: Axes) -> None:
    """Lets matplotlib arrange given axes, so that no label is cut off, where the caller has arranged nothing."""
    figure = axes.figure.figure
    arranged = vars(figure.subplotpars) != vars(SubplotParams())
    if figure.get_layout_engine() is None and not arranged:
        figure.set_layout_engine("constrained")


def plot(
    run: Run, path: str | PathLike[str] | None = None, ax: object = None
) -> Figure | Axes:
    """Draw a run into a new figure, and save it if `path` is given; or draw its gaps over time into the axes `ax`.

    The suffix of `path` determines the format. The figure has at most five panels:

    1. if the run has a posture, the body on its ground at some instants, to scale, with arrows for kicks;
    2. the gaps over time, with the impacts marked on the terrain, unless all contacts stay closed;
    3. the angle, the contact forces and the motion of the ground over time, each only if there is something to see;
    4. if one accumulation of impacts is the main event, the gaps against the time left until its end, with two logarithmic axes:
       accumulating impacts are evenly spaced here.
    """
    axes = axes_or_none(ax)
    if axes is not None:
        if path is not None:
            raise ValueError(
                f"path = {str(path)!r} cannot be used: None is allowed with ax; save the figure of the axes instead"
            )
        width = axes.get_window_extent().width / axes.figure.dpi
        draw_gaps(axes, run, max(APART, MARK / width))
        axes.set_xlabel("time / s")
        fitted(axes)
        return axes
    view = None if run.posture is None else View(run)
    point = accumulation(run)
    opens = view is None or not stays_closed(run)
    others = list(over_time(run))
    rest = opens + (view is not None) + (point is not None)
    others = others[max(0, rest + len(others) - PANELS) :]
    heights = [] if view is None else [view.height + LABELS]
    heights += [GAPS] * opens + [OTHER] * len(others)
    heights += [APPROACH] * (point is not None)
    figure = Picture(figsize=(WIDTH, sum(heights)), dpi=110, layout="constrained")
    grid = figure.add_gridspec(len(heights), 1, height_ratios=heights)
    rows = iter(range(len(heights)))
    if view is not None:
        draw_body(figure.add_subplot(grid[next(rows)]), view)
    timed: list[Axes] = []
    gaps = [lambda axes: draw_gaps(axes, run, APART)] if opens else []
    for draw in (*gaps, *others):
        first = timed[0] if timed else None
        timed.append(figure.add_subplot(grid[next(rows)], sharex=first))
        draw(timed[-1])
    for axes in timed:
        for time in kick_times(run):
            axes.axvline(time, color=KICK, lw=1.5, zorder=0.5)
        axes.tick_params(labelbottom=axes is timed[-1])
    for axes in timed[-1:]:
        axes.set_xlabel("time / s")
    if point is not None:
        draw_approach(figure.add_subplot(grid[next(rows)]), run, point)
    headline = textwrap.fill(_headline(run), HEADLINE)
    figure.axes[0].set_title(headline, loc="left", fontsize=11)
    if path is not None:
        save(figure, path)
    return figure


def save(figure: Figure, path: str | PathLike[str]) -> None:
    """Write a figure to exactly this path, whole or not at all. The suffix determines the format.

    Raises ValueError for a suffix that is no picture format, and OSError if the file cannot be written.
    """
    target = pathlib.Path(path)
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
    """The Zeno point of a run whose main event it is: the only one, at which infinitely many impacts accumulate over a time, on a contact
    that has a gap."""
    points = [point for point in run.zeno_points if is_infinite(point)]
    if len(points) != 1 or not accumulates(run, points[0]):
        return None
    if min(points[0].contacts) > len(run.gaps):
        return None
    return points[0] if points[0].elapsed >= MAIN * run.elapsed else None


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
    if not (elapsed == point.elapsed).any():
        return True  # summed after the last impact
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


def stays_closed(run: Run) -> bool:
    """Whether all contacts of the posture of a run that lasts stay closed: their gaps are nothing to draw.

    >>> from standfast import simulate
    >>> ball = Posture.disc(0.1, friction=0.3)
    >>> [stays_closed(simulate(ball, (0, height, 0), (1, 0, 0), time_limit=1)) for height in (0, 0.1)]
    [True, False]
    """
    modes = [phase.mode[: len(run.gaps)] for phase in run.phases]
    return run.elapsed > 0.0 and not any("S" in mode for mode in modes)


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


def called(run: Run, index: int) -> str:
    """A contact in words: its number, and whether it is a side.

    >>> box = Posture.box(1.0, 0.5, friction=0.5, terrain=[(-5, 0), (0, 0), (0, -5)])
    >>> from standfast import simulate
    >>> run = simulate(box, (-0.1, 0, 0), (0, 0, 0))
    >>> called(run, 0), called(run, 4)
    ('contact 1', 'contact 5 (side)')
    """
    side = " (side)" if run.contacts[index].kind == "side" else ""
    return f"contact {index + 1}{side}"


def _contacts(run: Run) -> Iterator[tuple[int, dict[str, Any]]]:
    """The index of every contact that has a gap, and the style of its line: a side has none."""
    for index in range(len(run.gaps)):
        look = {"color": COLORS[index % 4], "linestyle": LINES[style(index)]}
        yield index, {"lw": 1.6, **look}


def style(index: int) -> int:
    """Index of the line style or marker: the first 16 contacts differ in this or in their colour."""
    return (index + index // 4) % 4


def touching(run: Run) -> set[int]:
    """The contacts that touch the ground at some instant, sides included, counted from 0."""
    closed = {
        index
        for phase in run.phases
        for index, letter in enumerate(phase.mode)
        if letter != "S"
    }
    landed = {number - 1 for point in run.zeno_points for number in point.contacts}
    return closed | landed | {int(index) for index in np.unique(run.impacts["index"])}


def kick_times(run: Run) -> _Floats:
    """Times of the kicks during the run that can be told apart."""
    times = np.array([kick.time for kick in run.kicks if start(run) <= kick.time])
    times = np.unique(times[times <= run.time])
    return times[apart(times, APART * run.elapsed)]


def draw_gaps(axes: Axes, run: Run, spacing: float) -> None:
    """Gaps over time; markers on the terrain for the impacts that can be told apart. `spacing`: see `APART`."""
    t, gaps = curves(run)
    least = spacing * run.elapsed
    impacts = run.impacts
    shown = impacts[marked(impacts, least)]
    touched = touching(run) if len(run.gaps) > FEW else set(range(len(run.gaps)))
    infinite = [point for point in run.zeno_points if is_infinite(point)]
    summed = {number for point in infinite for number in point.contacts}

    def mark_impacts(index: int) -> tuple[str, Line2D] | None:
        seen = shown["time"][shown["index"] == index]
        if not len(seen):
            return None
        on_ground = np.zeros_like(seen)
        (marks,) = axes.plot(seen, on_ground, clip_on=False, **_mark(index))
        many = (impacts["index"] == index).sum() > 1 or index + 1 in summed
        return f"{called(run, index)}, impact{'s' if many else ''}", marks

    entries: dict[str, Any] = {}
    for index, look in _contacts(run):
        if not run.elapsed:  # one point needs a marker
            look |= {"marker": MARKERS[style(index)], "clip_on": False}
        if index not in touched:
            look |= {"color": ALOOF, "linestyle": "-", "lw": 0.8, "zorder": 1.0}
        (line,) = axes.plot(t, gaps[:, index], **look)
        if (hits := mark_impacts(index)) is not None:
            label, marks = hits
            entries[label] = line, marks
        elif index in touched:
            entries[f"contact {index + 1}"] = line
        else:
            entries["contacts that never touch"] = line
    for index in range(len(run.gaps), len(run.contacts)):  # sides have no gaps
        if (hits := mark_impacts(index)) is not None:
            label, marks = hits
            entries[label] = marks
    ends = np.array([point.time for point in infinite])
    for time in ends[apart(ends, least)]:
        label = "Zeno point" if len(infinite) == 1 else "Zeno points"
        look = {"color": "black", "lw": 1.0, "ls": ":", "zorder": 0}
        entries[label] = axes.axvline(time, **look)
    if len(kick_times(run)):
        label = "kick" if len(kick_times(run)) == 1 else "kicks"
        entries[label] = Line2D([], [], color=KICK, lw=1.5)
    highest = gaps[np.isfinite(gaps)].max(initial=0.0)
    axes.set_ylim(0.0, 1.05 * highest if highest > 0.0 else None)
    axes.margins(x=0.03)
    if not run.elapsed:
        axes.set_xticks([run.time])
        text = f"The run ends at its start: {run.outcome}"
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", fontsize=9)
    axes.set_ylabel("gap / m")
    _legend(axes, entries, row=len(entries) > FEW + 1)
    _bare(axes)


def _legend(
    axes: Axes, entries: dict[str, Any], row: bool = False, title: str | None = None
) -> None:
    """A legend in the axes: handles by their labels; in rows above the curves, or where they leave room."""
    first = dict(list(entries.items())[:LEGEND])
    if len(entries) > LEGEND:
        title = f"the first {LEGEND} of {len(entries)}"
    box = axes.get_window_extent().transformed(axes.figure.dpi_scale_trans.inverted())
    columns = max(1, int(box.width / COLUMN)) if row else 1
    if row:
        rows = math.ceil(len(first) / columns) + (title is not None)
        low, high = axes.get_ylim()
        share = min(0.6, ROW * (rows + 1) / box.height)
        axes.set_ylim(low, low + (high - low) / (1.0 - share))
    axes.legend(
        list(first.values()),
        list(first),
        title=title,
        title_fontsize=SMALL,
        fontsize=SMALL,
        framealpha=0.9,
        labelspacing=0.3,
        columnspacing=1.2,
        ncols=columns,
        loc="upper right" if row else "best",
    )


def over_time(run: Run) -> Iterator[Callable[[Axes], None]]:
    """What draws the further panels over time, those first that are left out first where there are too many."""
    if run.posture is None or not run.elapsed:
        return
    times = np.unique([*event_times(run), *np.linspace(start(run), run.time, CURVE)])
    theta = run.at(times)[0][:, 2]
    if np.ptp(theta) > TURNED:

        def draw_angle(axes: Axes) -> None:
            axes.plot(times, theta, color="black", lw=1.6)
            axes.set_ylabel("θ / rad")
            _bare(axes)

        yield draw_angle
    pressed = forces(run)
    if pressed is not None:

        def draw(axes: Axes) -> None:
            draw_forces(axes, run, *pressed)

        yield draw
    motion = run.ground_motion
    if motion is not None:

        def draw_motion(axes: Axes) -> None:
            draw_ground_motion(axes, run, motion)

        yield draw_motion


def forces(run: Run) -> tuple[_Floats, _Floats] | None:
    """Times (k,) and the forces of the contacts there (k, n, 2), with NaN between pieces of smooth motion; None if too little of the run
    has contacts on the ground."""
    events = event_times(run)
    phases = [phase for phase in run.phases if set(phase.mode) != {"S"}]
    begins, ends = (
        np.array([getattr(phase, end) for phase in phases]) for end in ("start", "end")
    )
    pieces = [
        (begin, end)
        for begin, end in pairwise(events)
        if end - begin > VISIBLE * run.elapsed
        and ((begins <= begin) & (end <= ends)).any()
    ]
    if sum(end - begin for begin, end in pieces) <= CLOSED * run.elapsed:
        return None
    # At the end of a piece the forces may be those after an event.
    shares = np.append(np.linspace(0.0, 1.0 - 1e-6, FORCES), np.nan)
    times = np.concatenate([begin + (end - begin) * shares for begin, end in pieces])
    values = np.full((len(times), len(run.contacts), 2), np.nan)
    known = np.isfinite(times)
    values[known] = run.forces_at(times[known])
    values[(values == 0.0).all(axis=2)] = np.nan  # open contacts
    return times, values


def draw_forces(axes: Axes, run: Run, times: _Floats, values: _Floats) -> None:
    """Normal and tangential forces over time. See `forces`."""
    normal = Line2D([], [], color="black")
    tangential = Line2D([], [], color="black", ls=LINES[1])
    entries: dict[str, Any] = {"normal": normal, "tangential": tangential}
    for index in np.flatnonzero(np.nan_to_num(abs(values)).max(axis=(0, 2)) > 0.0):
        look: dict[str, Any] = {
            "color": COLORS[index % 4],
            "lw": 1.6 / (1 + index // 4),
        }
        (line,) = axes.plot(times, values[:, index, 1], **look)
        axes.plot(times, values[:, index, 0], ls=LINES[1], **look)
        entries[called(run, int(index))] = line
    axes.axhline(0.0, color=PATH, lw=0.6, zorder=0)
    axes.set_ylabel("force / N")
    _legend(axes, entries, row=True)
    _bare(axes)


def draw_ground_motion(axes: Axes, run: Run, motion: GroundMotion) -> None:
    """The acceleration or the tilt of the ground over time."""
    times = [start(run), *motion.times, max(run.time, motion.times[-1])]
    linear = motion.interpolation == "linear"
    if linear:  # upright where the record begins with a jump
        times.insert(1, motion.times[0])
    if motion.tilt is not None:
        values = {"tilt": np.array(motion.tilt)}
        axes.set_ylabel("ground / rad")
    else:
        across, up = np.array(motion.acceleration).T
        values = {"acceleration x": across, "acceleration y": up}
        values = {label: a for label, a in values.items() if a.any()}
        axes.set_ylabel("ground / (m/s²)")
    entries: dict[str, Any] = {}
    for (label, steps), color, style in zip(
        values.items(), COLORS, LINES, strict=False
    ):
        level = [0.0, *([0.0] if linear else []), *steps, steps[-1]]
        look: dict[str, Any] = {"color": color, "ls": style, "lw": 1.6}
        look["drawstyle"] = "default" if linear else "steps-post"
        (entries[label],) = axes.plot(times, level, **look)
    axes.set_xlim(axes.get_xlim())
    _legend(axes, entries, row=True)
    _bare(axes)


def _mark(index: int) -> dict[str, Any]:
    """The style of the marker of an impact."""
    return {
        "linestyle": "none",
        "marker": MARKERS[style(index)],
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
    plastic = len(moving) - infinite
    # Impacts on several contacts at one instant are one for the eye.
    instants = max(len(np.unique(run.impacts["time"])), plastic)
    events = []
    if instants and not infinite > plastic:
        events.append(counted(instants, "impact"))
    if plastic and events:
        events[0] += (
            " without rebound"
            if plastic == instants
            else f", {plastic} of them without rebound"
        )
    if infinite:
        events.append(counted(infinite, "Zeno point"))
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
    looks = dict(_contacts(run))
    for index in range(len(run.contacts)):
        hits = left[before["index"] == index]
        if index in looks:  # sides have no gaps
            height = np.where(np.isin(rest, hits), 0.0, gaps[:, index])
            axes.plot(rest, np.maximum(height, 1e-3 * low), **looks[index])
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
    title = "Gaps against the time left until the Zeno point"
    axes.set_title(title, loc="left", fontsize=11)
    axes.set_xlabel("time left / s")
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
        raise ValueError(f"run has no posture: it is of a {without_posture(run)}")
    return run.posture


class Pose(NamedTuple):
    """The body at a time (s): its contacts (n, 2), without sides, centre of mass (2,), closed outline (k + 1, 2) and the lines in it, m."""

    time: float
    contacts: _Floats
    center: _Floats
    outline: _Floats
    spokes: _Floats


def own_points(run: Run, t: npt.ArrayLike) -> _Floats:
    """The points (..., n, 2) of the contacts of the posture, without sides, at times (...), m."""
    return run.points_at(t)[..., : len(run.gaps), :]


def pose(run: Run, time: float) -> Pose:
    """The body at this time."""
    posture = _posture(run)
    q, contacts, frozen = run.at(time)[0], own_points(run, time), run.model == "local"
    return Pose(
        time,
        contacts,
        np.asarray(posture.center_of_mass) + q[:2],
        body_outline(posture, q, frozen),
        spokes(posture, contacts, q, frozen),
    )


def instants(run: Run) -> list[float]:
    """Times at which the body is drawn: the start and the end, changes of the course between them, and times between these, as far as
    the body is not drawn over itself. If the body moves far, they cover only the part near the end."""
    size = body_size(_posture(run))
    even = np.linspace(start(run), run.time, CHOICE)
    away = np.hypot(*(run.at(even)[0][:, :2] - run.at(run.time)[0][:2]).T) / size
    if away.max() > JOURNEY:
        even = even[np.flatnonzero(away > NEAR)[-1] :]
    events = event_times(run)
    events = events[(events >= even[0]) & (events <= run.time)]
    events = events[apart(events, run.elapsed / CHOICE)]
    kicks = kick_times(run)
    kicks = kicks[kicks >= even[0]]
    times = np.array([even[0], run.time, *kicks, *events, *even])
    if not run.elapsed:
        return [run.time]
    # The centre of mass counts twice: a body that turns at its place is drawn over itself.
    q = run.at(times)[0]
    points = np.concatenate([own_points(run, times), q[:, None, :2]], axis=1)
    shapes = np.column_stack([points.reshape(len(times), -1), q[:, :2]])

    def distance(i: int, chosen: list[int]) -> float:
        moves = (shapes[chosen] - shapes[i]).reshape(len(chosen), -1, 2)
        return float(np.hypot(moves[..., 0], moves[..., 1]).mean(axis=1).min())

    longest = max(distance(i, [0]) for i in range(len(times)))
    least = max(SPREAD * longest, STEP * size)
    while True:
        chosen = [0, 1]
        for i in range(2, len(times)):
            if distance(i, chosen) >= least:
                chosen.append(i)
        if len(chosen) <= POSES:
            return sorted(float(times[i]) for i in chosen)
        least *= 1.1


def body_size(posture: Posture) -> float:
    """The largest of the radius of gyration and the distances of the contacts from the centre of mass, m."""
    points = np.array([contact.point for contact in posture.contacts])
    arms = points - posture.center_of_mass
    return float(max(posture.gyration_radius, *np.hypot(*arms.T)))


class View:
    """The body at some instants, the ground around it, and the box that shows both, to scale.

    poses: the body at these instants; path (k, 2), m: of the centre of mass at the times samples (k,), s; kicks: the tail and the head of an arrow for each; low, high
    (2,), m: the box; height: of the panel, in inches; scale: metres in an inch.
    """

    def __init__(
        self, run: Run, times: Iterable[float] | None = None, width: float = WIDTH
    ) -> None:
        """The instants of the picture, or these in increasing order. width: of the figure, in inches."""
        panel = width - BESIDE
        self.run = run
        self.posture: Posture = _posture(run)
        self.poses: list[Pose] = [
            pose(run, time) for time in (instants(run) if times is None else times)
        ]
        begin = self.poses[0].time
        samples = np.linspace(begin, run.time, CURVE // 4)
        samples = np.unique([*samples, *event_times(run)])
        self.samples: npt.NDArray[Any] = samples[samples >= begin]
        self.path: _Floats = (
            run.at(self.samples)[0][:, :2] + self.posture.center_of_mass
        )
        shown_kicks = [time for time in kick_times(run) if time >= begin]
        kicks = [kick for kick in run.kicks if kick.time in shown_kicks][:POSES]
        self.kicks: list[_Floats] = list(kick_arrows(run, kicks))
        self.pieces: list[Piece] = ground(self.posture)
        shown = [self.path, *self.kicks, *self._beneath()]
        shown += [point[None] for _, point in self.marked()]
        for _, contacts, _, outline, _ in self.poses:
            shown += [contacts, outline]
        corners = np.vstack(shown)
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = MARGIN * float((high - low).max())
        wide, tall = high - low + 2.0 * margin
        self.height: float = float(np.clip(panel * tall / wide, LOW, HIGH))
        # Where the panel is wider or higher than its contents, the ground fills it.
        self.scale: float = max(wide / panel, tall / self.height)
        low, high = low - margin, high + margin
        room = self.scale * np.array([panel, self.height]) - (high - low)
        self.low: _Floats = low - BELOW * room
        self.high: _Floats = high + (1.0 - BELOW) * room

    def marked(self) -> list[tuple[int, _Floats]]:
        """The indices of the contacts at the last pose, and their points (2,): those of the posture, and the sides that have touched since
        the first pose."""
        run, own, begin = self.run, len(self.run.gaps), self.poses[0].time
        hits = run.impacts["index"][run.impacts["time"] >= begin]
        closed = {
            index
            for phase in run.phases
            if phase.end >= begin
            for index, letter in enumerate(phase.mode)
            if letter != "S"
        }
        seen = closed | {int(index) for index in np.unique(hits)}
        points = run.points_at(self.poses[-1].time)
        return [(k, p) for k, p in enumerate(points) if k < own or k in seen]

    def shades(self) -> list[float]:
        """The grey of each pose, from light to black."""
        return [float(s) for s in np.linspace(0.0, 0.7, len(self.poses))[::-1]]

    def clock(self, time: float) -> str:
        """A time with as many digits as tell the poses apart."""
        whole = max(self.run.elapsed, np.finfo(float).tiny)
        longer = math.log10(max(abs(self.run.time), whole) / whole)
        return f"{time:.{3 + max(0, math.ceil(longer))}g} s"

    def _beneath(self) -> Iterator[_Floats]:
        """The points of the ground (1, 2) that are nearest to the contacts and the centre of mass, where these are not far from it."""
        reach = REACH * body_size(self.posture)
        for foot in np.vstack([[*p.contacts, p.center] for p in self.poses]):
            place, _ = nearest(self.pieces, foot)
            if math.hypot(*(foot - place)) <= reach:
                yield place[None]


def nearest(pieces: list[Piece], foot: _Floats) -> tuple[_Floats, _Floats]:
    """The point (2,) of the ground that is nearest to a point, and the direction (2,) of the ground there."""
    points, tangents, first, last = map(np.array, zip(*pieces, strict=True))
    along = np.clip(((foot - points) * tangents).sum(axis=1), first, last)
    places = points + tangents * along[:, None]
    index = int(np.hypot(*(foot - places).T).argmin())
    return places[index], tangents[index]


def kick_arrows(run: Run, kicks: Sequence[Kick]) -> Iterator[_Floats]:
    """Arrows (2, 2), from tail to head, to the points of the body that kicks act on. The longest is as long as the largest radius of
    the body."""
    posture = _posture(run)
    nominal = np.array(posture.center_of_mass)
    largest = max((math.hypot(*kick.impulse) for kick in kicks), default=0.0)
    for kick in kicks if largest > 0.0 else []:
        x, y, theta = run.at(kick.time)[0]
        arm = np.subtract(kick.point or nominal, nominal)
        c, s = math.cos(theta), math.sin(theta)
        head = arm @ [[c, s], [-s, c]] + nominal + (x, y)
        way = body_size(posture) * np.array(kick.impulse) / largest
        yield np.array([head - way, head])


def draw_body(axes: Axes, view: View) -> None:
    """The body on its ground, to scale, at some instants of the run, with their times, its contacts and the path of its centre of mass."""
    axes.set_aspect("equal", adjustable="box", anchor="W")
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    axes.set_autoscale_on(False)
    draw_ground(axes, view)
    entries: dict[str, Any] = {}
    posture = view.posture
    thin = 0.6 if len(posture.contacts) <= FEW else 0.25
    for shade, shape in zip(view.shades(), view.poses, strict=True):
        last = shape is view.poses[-1]
        look: dict[str, Any] = {"color": str(shade), "lw": 1.8 if last else 1.0}
        axes.fill(*shape.outline.T, color=BODY, alpha=0.15, lw=0.0)
        axes.plot(*shape.outline.T, solid_joinstyle="round", **look)
        if posture.outline is None:
            axes.plot(*shape.spokes.T, **{**look, "lw": thin * look["lw"]})
        (entries["centre of mass"],) = axes.plot(
            *shape.center, marker="+", color=str(shade), markersize=7, ls="none"
        )
    (entries["its path"],) = axes.plot(*view.path.T, color=PATH, lw=1.0, ls=":")
    if not posture.drawn_corners:
        circle = Line2D([], [], ls="none", marker="o", ms=9, mfc="none", mec="black")
        entries["radius of gyration"] = circle
    for tail, head in view.kicks:
        arrow = {"color": KICK, "arrowstyle": "-|>", "lw": 2.0}
        axes.annotate("", head, tail, arrowprops={**arrow, "shrinkA": 0, "shrinkB": 0})
        label = "kick" if len(view.kicks) == 1 else "kicks"
        entries[label] = Line2D([], [], color=KICK, lw=2.0, marker=">")
    for index, corner in view.marked():
        axes.plot(*corner, **{**_mark(index), "markersize": 6})
    write_times(axes, view)
    frame = "" if view.run.ground_motion is None else ", relative to the ground"
    axes.set_xlabel(f"x / m{frame}")
    axes.set_ylabel("y / m")
    begin = view.poses[0].time
    late = begin > start(view.run)
    _legend(axes, entries, title=f"from t = {view.clock(begin)}" if late else None)
    _bare(axes)


def draw_ground(axes: Axes, view: View) -> list[Artist]:
    """The surface of the ground, and a strip under it. Returns what is drawn."""
    depth = THICKNESS * float((view.high - view.low).min())
    lines, strips = surface(view.pieces, view.low, view.high, depth)
    drawn: list[Artist] = [
        axes.add_patch(Polygon(strip, color=GROUND, lw=0.5, zorder=0))
        for strip in strips
    ]
    for line in lines:
        drawn += axes.plot(*line.T, color=SURFACE, lw=1.0, zorder=0.5)
    return drawn


def write_times(axes: Axes, view: View) -> None:
    """The numbers of the contacts at the last pose, and the times at the poses, where they cover no text and, if possible, no pose."""
    end = view.poses[-1]
    bodies = [Path(shape.outline) for shape in view.poses]
    strips = [patch.get_path() for patch in axes.patches if patch.get_zorder() == 0]
    taken: list[Bbox] = []

    def size(text: str) -> _Floats:
        """Half of its width and height, in inches."""
        return np.array([0.035 * len(text) + 0.02, 0.08])

    def write(text: str, places: list[_Floats], color: str = "black") -> None:
        half = view.scale * size(text)
        free: list[tuple[float, int, _Floats, Bbox]] = []
        for place in places:
            box = Bbox([place - half, place + half])
            inside = (view.low <= box.min).all() and (box.max <= view.high).all()
            if inside and not box.count_overlaps(taken):
                covered = sum(body.intersects_bbox(box) for body in bodies)
                on_ground = any(strip.intersects_bbox(box) for strip in strips)
                free.append((covered + 0.5 * on_ground, len(free), place, box))
        for _, _, (x, y), box in sorted(free, key=lambda found: found[:2])[:1]:
            taken.append(box)
            look: dict[str, Any] = {"ha": "center", "va": "center", "zorder": 6}
            axes.text(x, y, text, fontsize=SMALL, color=color, **look)

    own = len(end.contacts)
    sides = view.marked()[own:]
    numbered = list(enumerate(end.contacts)) if own <= FEW else []
    for index, corner in [*numbered, *(sides if len(sides) <= FEW else [])]:
        out = corner - end.center
        if not out.any():
            out = np.array([0.0, -1.0])
        far = 0.18 * view.scale / math.hypot(*out)
        write(str(index + 1), [corner + far * out, corner - far * out])
    # Upwards; then to both sides and downwards.
    turns = math.pi * np.array([6, 5, 7, 4, 8, 3, 9, 2, 10, 0, 12, 18]) / 12.0
    ways = np.column_stack([np.cos(turns), np.sin(turns)])
    shades = view.shades()
    for index in dict.fromkeys([0, len(shades) - 1, *range(1, len(shades) - 1)]):
        shape, shade = view.poses[index], shades[index]
        points = np.vstack([shape.outline, shape.center])
        heights = points @ ways.T
        highest = heights >= heights.max(axis=0) - 1e-6 * view.scale
        # At the corner that is farthest in a direction.
        tied = [points[high] for high in highest.T]
        corners = np.array([0.5 * (p.min(axis=0) + p.max(axis=0)) for p in tied])
        text = view.clock(shape.time)
        room = view.scale * (size(text) + 0.06) * ways
        corners += room
        # Beside the sides of the body, the highest first.
        begin, way = shape.outline[:-1], np.diff(shape.outline, axis=0)
        turn = math.copysign(
            1.0, (begin[:, 0] * way[:, 1] - begin[:, 1] * way[:, 0]).sum()
        )
        out = turn * np.column_stack([way[:, 1], -way[:, 0]])
        out /= np.maximum(np.hypot(*out.T), np.finfo(float).tiny)[:, None]
        aside = view.scale * (abs(out) @ size(text) + 0.03)
        sides = begin + 0.5 * way + aside[:, None] * out
        sides = sides[np.argsort(-sides[:, 1], kind="stable")]
        places = [*corners[:-3], *sides, *corners[-3:]]
        write(text, places, str(min(shade, 0.5)))


def _bare(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
