"""Pictures of assemblies: the bodies with their contacts, the forces of their joints, how they begin to move, and the load they hold.
Needs matplotlib."""

import math
import textwrap
from collections.abc import Callable, Sequence
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path
from matplotlib.transforms import ScaledTranslation

from standfast._core import LoadFactor, System, SystemMode
from standfast.plot import (
    BODY,
    COLORS,
    GROUND,
    MARGIN,
    SURFACE,
    THICKNESS,
    Picture,
    axes_or_none,
    fitted,
    save,
)
from standfast.scenery import (
    JointForce,
    displaced,
    joint_forces,
    joints,
    surface,
    system_ground,
)
from standfast.table import factor_in_words, system_holds, system_mode_in_words

_Floats = npt.NDArray[np.float64]

#: Width of a new figure, least and largest height of a panel, and height of the title, the legend and the labels of a panel, in inches;
#: size of the text, in points; dots per inch.
WIDTH, LOW, HIGH, LABELS, TEXT, DPI = 4.6, 1.1, 4.2, 0.95, 8.0, 200
#: Panels that are taller than this share of their width stand side by side.
TALL = 1.2
#: Width of a letter, height of a name, and width of axes from which on the legend has two columns, in sizes of the text.
LETTER, LINE, BROAD = 0.58, 0.9, 27.0
#: Room of the labels beside axes, in inches.
SIDE = 0.5
#: How far the ground is drawn beyond the bodies, in sizes of the picture.
BEYOND = 10.0
#: Largest length of a force, as a share of the size of the assembly and in sizes of a body.
FORCE, OWN = 0.25, 1.2
#: Size of a force that is too short to be seen, as a share of the largest one.
SMALL = 1e-3
#: Distance of a force from the limit of friction at which it is drawn as one at this limit, as a share of the limit: below what the eye can tell.
AT_LIMIT = 1e-3
#: Radius of a cone of friction, in lengths of its force.
CONE = 0.5
#: Number of contacts from which on lines and marks are thin, and those that hold are not marked where others open or slide.
MANY = 100
#: Diameters of the marks of contacts, and of those that open and of hinges, in points.
DOT, OPEN, HINGE = 3.0, 3.6, 5.0
#: Place of the legend below the axes, in points: below the label of the axis.
BELOW = 30.0
#: Colours of forces and of forces at the limit of friction; of bodies that move and of others; of contacts that open and slide.
PRESSES, SLIPS = COLORS[:2]
MOVES, STANDS = BODY, "0.88"
OPENS, RIGHT, LEFT = COLORS[1], COLORS[2], COLORS[3]
#: Bodies that move, before.
AT_REST: dict[str, Any] = {
    "facecolor": "none",
    "edgecolor": "0.45",
    "linestyle": (0, (3, 2)),
}


class View(NamedTuple):
    """What a panel draws into axes of a width in inches, and the box around it: its lowest and its highest point (2,), m."""

    draw: Callable[[Axes, float], None]
    low: _Floats
    high: _Floats


def plot_system(
    system: System,
    path: str | PathLike[str] | None = None,
    ax: object = None,
    forces: _Floats | None = None,
) -> Figure | Axes:
    """As `System.plot`."""
    return _plot([_of_system(system, forces)], path, ax)


def plot_mode(
    mode: SystemMode, path: str | PathLike[str] | None = None, ax: object = None
) -> Figure | Axes:
    """As `SystemMode.plot`."""
    return _plot([_of_mode(mode)], path, ax)


def plot_factor(
    factor: LoadFactor, path: str | PathLike[str] | None = None, ax: object = None
) -> Figure | Axes:
    """As `LoadFactor.plot`."""
    forces, moves = factor_in_words(factor)
    if factor.mode is None:
        title = f"{forces};\n{moves}"
        return _plot([_of_system(factor.system, factor.forces, title)], path, ax)
    does = system_mode_in_words(factor.mode).removeprefix("begins to move")
    mode = _of_mode(factor.mode, f"{moves}{does}")
    if ax is not None:
        return _plot([mode], path, ax)
    return _plot([_of_system(factor.system, factor.forces, forces), mode], path, ax)


def _plot(
    views: Sequence[View], path: str | PathLike[str] | None, ax: object
) -> Figure | Axes:
    axes = axes_or_none(ax)
    if axes is not None:
        if path is not None:
            raise ValueError(
                f"path = {str(path)!r} cannot be used: None is allowed with ax; save the figure of the axes instead"
            )
        views[0].draw(axes, axes.get_window_extent().width / axes.figure.dpi)
        fitted(axes)
        return axes
    width, height = np.max([view.high - view.low for view in views], axis=0)
    beside = height > TALL * width
    rows, columns = (1, len(views)) if beside else (len(views), 1)
    panel = (
        float(np.clip((WIDTH / columns - SIDE) * height / width, LOW, HIGH)) + LABELS
    )
    with rc_context({"font.size": TEXT}):
        figure = Picture(figsize=(WIDTH, rows * panel), dpi=DPI, layout="constrained")
        all_axes = figure.subplots(rows, columns, squeeze=False).flat
        for axes, view in zip(all_axes, views, strict=True):
            view.draw(axes, WIDTH / columns - SIDE)
        if path is not None:
            save(figure, path)
    return figure


def _of_system(
    system: System, forces: _Floats | None = None, title: str | None = None
) -> View:
    outlines = [body.outline for body in system.bodies.values()]
    bars = [] if forces is None else _bars(system, forces)
    low, high = _box([*outlines, *(bar.ends for bar in bars)])

    def draw(axes: Axes, inches: float) -> None:
        _frame(axes, system, low, high)
        _title(axes, title, inches)
        axes.add_collection(_polygons(outlines, MOVES if forces is None else STANDS))
        if forces is None:
            points = np.array([c.point for c in system.contacts]).reshape(-1, 2)
            size = DOT if len(points) < MANY else 0.3 * DOT
            axes.plot(*points.T, ls="none", marker="o", ms=size, color="black")
            _names(axes, system, outlines)
        else:
            _legend(axes, _forces(axes, system, bars), inches)

    return View(draw, low, high)


def _of_mode(mode: SystemMode, title: str | None = None) -> View:
    system = mode.system
    title = title or system_mode_in_words(mode)
    if system_holds(mode):
        return _of_system(system, mode.forces, title)
    outlines = [body.outline for body in system.bodies.values()]
    moved, contacts = displaced(mode)
    low, high = _box([*outlines, *moved])
    ways = [np.hypot(*(a - b).T).max() for a, b in zip(outlines, moved, strict=True)]
    moving = np.array(ways) > SMALL * max(ways)

    def draw(axes: Axes, inches: float) -> None:
        _frame(axes, system, low, high)
        _title(axes, title, inches)
        before = [outline for outline, own in zip(outlines, moving, strict=True) if own]
        colors = np.where(moving, MOVES, STANDS).tolist()
        axes.add_collection(_polygons(moved, colors))
        axes.add_collection(PolyCollection(before, lw=_width(outlines), **AT_REST))
        _names(axes, system, moved)
        _legend(axes, _contacts(axes, mode, contacts), inches)

    return View(draw, low, high)


def _box(outlines: Sequence[_Floats]) -> tuple[_Floats, _Floats]:
    """The lowest and the highest point of outlines, with a margin for the ground."""
    points = np.vstack(outlines)
    room = (MARGIN + THICKNESS) / 2 * np.ptp(points, axis=0).max()
    return points.min(axis=0) - room, points.max(axis=0) + room


def _polygons(outlines: Sequence[_Floats], color: str | list[str]) -> PolyCollection:
    return PolyCollection(outlines, facecolor=color, edgecolor="0.25", lw=_width(outlines), zorder=1)  # fmt: skip


def _width(outlines: Sequence[_Floats]) -> float:
    """Width of the lines of so many outlines, in points."""
    return 0.8 if 2 * len(outlines) < MANY else 0.2


def _frame(axes: Axes, system: System, low: _Floats, high: _Floats) -> None:
    """The ground, the limits, which become those of the axes, and the labels."""
    size = float((high - low).max())
    ends = low - BEYOND * size, high + BEYOND * size
    lines, strips = surface(system_ground(system), *ends, THICKNESS * size)
    axes.add_collection(PolyCollection(strips, color=GROUND, lw=0.5, zorder=0), autolim=False)  # fmt: skip
    axes.add_collection(LineCollection(lines, color=SURFACE, lw=1.0, zorder=0.5), autolim=False)  # fmt: skip
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.0)
    axes.update_datalim([low, high])
    axes.autoscale_view()
    axes.set_xlabel("x / m")
    axes.set_ylabel("y / m")
    axes.spines[["top", "right"]].set_visible(False)
    axes.locator_params(nbins=5)


def _title(axes: Axes, title: str | None, inches: float) -> None:
    if title is not None:
        text = textwrap.fill(title, max(1, int(inches / (LETTER * _size("large")))))
        axes.set_title(text, loc="left", fontsize="large")


def _size(name: str) -> float:
    """Size of text, in inches."""
    return FontProperties(size=name).get_size_in_points() / 72.0


def _names(axes: Axes, system: System, outlines: Sequence[_Floats]) -> None:
    """The names of the bodies that have room for them, in the middle of their outlines."""
    box = axes.get_window_extent()
    view = np.array([np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())])
    scale = float((view / [box.width, box.height]).max()) * axes.figure.dpi  # m per inch  # fmt: skip
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, 0), (1, 0)]) / 2
    for name, outline in zip(system.bodies, outlines, strict=True):
        middle = outline.mean(axis=0)
        size = scale * _size("medium") * np.array([LETTER * len(name), LINE])
        if Path(outline).contains_points(middle + size * corners).all():
            x, y = middle
            axes.text(x, y, name, ha="center", va="center", zorder=3)


class Bar(NamedTuple):
    """The force of a joint as a line: its ends (2, 2), m; whether it is at the limit of friction, and then the corners (3, 2) of the cone, m;
    the size of the force, N; and the joint."""

    ends: _Floats
    cone: _Floats | None
    size: float
    joint: JointForce


def _bars(system: System, forces: _Floats) -> list[Bar]:
    found = joint_forces(system, forces)
    sizes = [math.hypot(*joint.force) for joint in found]
    largest = max(sizes, default=0.0)
    outlines = [body.outline for body in system.bodies.values()]
    own = np.median([math.hypot(*np.ptp(outline, axis=0)) for outline in outlines])
    longest = min(FORCE * np.ptp(np.vstack(outlines), axis=0).max(), OWN * own)
    bars = []
    for joint, size in zip(found, sizes, strict=True):
        if size > SMALL * largest:
            half = joint.force * longest / largest / 2
            ends = np.array([joint.point - half, joint.point + half])
            bars.append(Bar(ends, _cone(joint, system, forces, half), size, joint))
    return bars


def _cone(
    joint: JointForce, system: System, forces: _Floats, way: _Floats
) -> _Floats | None:
    """The cone of friction with the edge `way` (2,), m, of a force with the largest tangential part that friction allows, which is more than none."""
    contact = system.contacts[joint.contacts[0]]
    tangential, normal = forces[joint.contacts].sum(axis=0)
    limit = contact.friction * normal
    if not abs(tangential) >= (1 - AT_LIMIT) * limit > 0.0:
        return None
    t = contact.tangent
    other = way - 2 * (way @ t) * t
    return np.array([joint.point, joint.point + way, joint.point + other])


def _forces(axes: Axes, system: System, bars: Sequence[Bar]) -> list[Artist]:
    """Draws the force of each joint and the line of thrust. Returns the entries of the legend."""
    if not bars:
        return [Line2D([], [], ls="none", label="no forces")]
    cones = [bar.cone for bar in bars if bar.cone is not None]
    if cones:
        axes.add_collection(PolyCollection(cones, facecolor=SLIPS, alpha=0.25, lw=0, zorder=2.5))  # fmt: skip
    longest = _newtons(max(bar.size for bar in bars))
    kinds = (
        (PRESSES, 3, [bar.ends for bar in bars if bar.cone is None], "force"),
        (SLIPS, 4, [bar.ends for bar in bars if bar.cone is not None], "at the limit of friction"),
        ("black", 2, _thrust(system, bars), "line of thrust"),
    )  # fmt: skip
    entries: list[Artist] = []
    for color, order, lines, label in kinds:
        width = 0.8 if color == "black" else 1.8 if len(bars) < MANY else 1.0
        if lines:
            axes.add_collection(LineCollection(lines, color=color, lw=width, zorder=order, capstyle="butt"))  # fmt: skip
            entries.append(Line2D([], [], color=color, lw=width, label=label))
    entries[0].set_label(
        f"{kinds[0][3] if kinds[0][2] else kinds[1][3]}, the longest {longest}"
    )
    return entries


def _thrust(system: System, bars: Sequence[Bar]) -> list[_Floats]:
    """Lines from joint to joint through the bodies of a chain such as an arch or a column, of which two joints press against each other."""
    on: dict[str, list[tuple[_Floats, _Floats]]] = {name: [] for name in system.bodies}
    for bar in bars:
        bodies = system.contacts[bar.joint.contacts[0]].bodies
        for name, sign in zip(bodies, (1, -1), strict=True):
            if name is not None:
                on[name].append((bar.joint.point, sign * bar.joint.force))
    if any(len(found) > 2 for found in on.values()):
        return []
    pairs = [found for found in on.values() if len(found) == 2]
    return [np.array([p, q]) for (p, one), (q, other) in pairs if one @ other < 0.0]


def _newtons(value: float) -> str:
    for size, unit in ((1e6, "MN"), (1e3, "kN")):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value:.3g} N"


def _contacts(axes: Axes, mode: SystemMode, points: _Floats) -> list[Artist]:
    """Draws the contacts of a mode by their letters. Returns the entries of the legend."""
    word = np.array(list(mode.word))
    hinged = np.zeros(len(word), bool)
    for pair in joints(mode.system):
        if sorted(word[pair]) == ["F", "S"]:
            hinged[pair] = word[pair] == "F"
    holds = (word == "F") & ~hinged & (len(word) < MANY)
    opening = points[word == "S"]
    axes.add_collection(LineCollection(opening, color=OPENS, lw=1.2, zorder=4))
    middle = points.mean(axis=1)
    looks: list[tuple[_Floats, str, dict[str, Any]]] = [
        (opening.reshape(-1, 2), "opens (S)", {"ms": OPEN, "color": OPENS}),
        (middle[hinged], "hinge (F, the other end opens)", {"ms": HINGE, "mfc": "white", "mec": "black"}),
        (middle[holds], "holds (F)", {"ms": DOT, "color": "black"}),
    ]  # fmt: skip
    entries: list[Artist] = []
    for chosen, label, look in looks:
        if len(chosen):
            entries += axes.plot(*chosen.T, ls="none", marker="o", zorder=4, label=label, **look)  # fmt: skip
    tangents = np.array([c.tangent for c in mode.system.contacts]).reshape(-1, 2)
    for letter, sign, color, marker in (("R", 1, RIGHT, ">"), ("L", -1, LEFT, "<")):
        chosen = word == letter
        if chosen.any():
            ways = sign * tangents[chosen]
            axes.quiver(*middle[chosen].T, *ways.T, color=color, pivot="mid", angles="xy", units="inches", scale=5.0, width=0.025, zorder=5)  # fmt: skip
            side = "right" if sign > 0 else "left"
            entries.append(Line2D([], [], color=color, marker=marker, ms=5.0, label=f"slides {side} ({letter})"))  # fmt: skip
    entries.append(Patch(label="at rest", **AT_REST))
    return entries


def _legend(axes: Axes, entries: Sequence[Artist], inches: float) -> None:
    figure = axes.figure.figure
    down = ScaledTranslation(0.0, -BELOW / 72.0, figure.dpi_scale_trans)
    axes.legend(handles=entries, loc="upper left", bbox_to_anchor=(0.0, 0.0), bbox_transform=axes.transAxes + down, borderaxespad=0.0, frameon=False, fontsize="medium", ncols=1 + (inches > BROAD * _size("medium")), columnspacing=1.2, handlelength=1.6)  # fmt: skip
