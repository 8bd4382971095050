"""Films of a run: the body on its ground with its contact modes and forces, above the gaps over the time of the film. Needs matplotlib."""

import math
import pathlib
import subprocess
import tempfile
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Patch, Wedge
from matplotlib.patches import Polygon as Area
from matplotlib.text import Text
from matplotlib.ticker import LogLocator, NullLocator
from PIL import Image

from standfast._core import Posture, Run, ZenoPoint
from standfast.maps import bar
from standfast.plot import (
    APART,
    BODY,
    COLORS,
    CURVE,
    FEW,
    GAPS,
    JOURNEY,
    KICK,
    LABELS,
    LEGEND,
    LINES,
    MARKERS,
    PATH,
    SMALL,
    Pose,
    View,
    apart,
    body_size,
    called,
    curves,
    draw_ground,
    event_times,
    kick_arrows,
    nearest,
    pose,
    sharpened,
    start,
    stays_closed,
    style,
    touching,
)
from standfast.scenery import ground
from standfast.table import contacts_named, is_infinite
from standfast.units import plain

_Floats = npt.NDArray[np.float64]

#: Width of the film, in inches, and pixels of an inch: texts can be read where the film fills the screen of a phone.
WIDE, DPI = 6.6, 100
#: Columns of the legend, and its height, in inches.
COLUMNS, ROWS = 3, 0.6
#: Seconds of the film for which the ring of an impact and the arrow of a kick are shown.
FLASH, KICKED = 0.25, 0.5
#: Size of the ring of an impact in points: at the impact, and at the end of its flash.
RING = (9.0, 22.0)
#: Length of the arrow of a contact force as large as the weight, and radius of the friction cones: in sizes of the body, and at least and
#: at most these shares of the shorter side of the picture. An arrow that would be longer than so many of these lengths ends there.
FORCE, SEEN, ROOM, LONGEST = 0.9, 0.16, 0.42, 3.0
#: Opacity of the friction cones and of their edges.
CONE, EDGES = 0.28, 0.8
#: Share of the length of the longest arrow from which a component of it counts for the room in the picture.
ASIDE = 0.1
#: Height of the largest gap of the magnified body, in sizes of the body; decades of the time left, before and after an instant, in which that
#: gap is the largest; factor from which the body is magnified.
LIFTED, DECADES, MAGNIFIED = 0.22, 0.5, 2.0
#: Length of the arrow of the largest acceleration of the ground, and height of the strip below the ground for it, in inches.
SHAKE, BELOW_GROUND = 0.45, 0.6
#: Room for labels of numbers that change their width where the view follows the body, in inches.
CHANGING = 0.25
#: Distance of the letter of a contact mode from its contact, into the ground, and least distance of two letters, in inches.
INTO, LETTER = 0.19, 0.12
#: Letters of the contact modes that are written, in words.
LETTERS = {"F": "fixed", "R": "slides right", "L": "slides left"}
#: Room around a body that the view follows, in sizes of the body.
AROUND = 4.0
#: Share of the lower of both neighbouring peaks of a gap below which a minimum of the gap is an impact. These minima are found closely;
#: those of a contact that comes near to the ground without touching it are not far below both peaks.
TOUCHED = 1e-3
#: Most frames per second of a GIF: programs that show GIFs slow down shorter frames than two hundredths of a second.
GIF_FPS = 50.0
#: Colours of a frame of a GIF, at most 256.
PALETTE = 255
#: Lowest gap on a logarithmic axis, in sizes of the body: below it a contact counts as closed.
CLOSED = 1e-12
#: Room to the right of the end of the film, as a share of the film.
EDGE = 0.01
#: Least share of the product of the normals of two contacts by which these are not parallel.
PARALLEL = 1e-9
#: Digits of a double.
DIGITS = 16


def as_gif(run: Run, fps: float, speed: float, clock: str) -> bytes:
    """The bytes of a GIF."""
    if fps > GIF_FPS:
        raise ValueError(
            f"fps = {fps!r} cannot be used: at most {GIF_FPS:g} for a .gif; .mp4 takes more"
        )
    return written(Gif(fps=fps), Film(run, fps, speed, clock))  # type: ignore[arg-type]


def as_mp4(run: Run, fps: float, speed: float, clock: str) -> bytes:
    """The bytes of an MP4 with H.264."""
    if not FFMpegWriter.isAvailable():
        raise ValueError(
            ".mp4 needs the program ffmpeg, which is not installed; .gif needs no other program"
        )
    film = Film(run, fps, speed, clock)
    try:
        return written(FFMpegWriter(fps=fps, codec="h264"), film)  # type: ignore[arg-type]
    except (subprocess.CalledProcessError, BrokenPipeError) as error:
        raise OSError(f"ffmpeg cannot write an .mp4: {error}") from error


def written(writer: AbstractMovieWriter, film: "Film") -> bytes:
    """The bytes that a writer of matplotlib makes of a film."""
    with tempfile.TemporaryDirectory() as folder:
        part = pathlib.Path(folder) / "film.mp4"
        with writer.saving(film.figure, str(part), DPI):
            for _ in film.frames():
                writer.grab_frame()
        return part.read_bytes()


def pixels(canvas: FigureCanvasAgg) -> npt.NDArray[np.uint8]:
    """A figure as drawn, (height, width, 4)."""
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]


class Gif(PillowWriter):
    """matplotlib's writer of GIFs, with few colours from the start, so that long films fit into the memory, and the right total time."""

    def setup(self, fig: Figure, outfile: Any, dpi: float | None = None) -> None:
        super().setup(fig, outfile, dpi)
        self.pictures: list[Image.Image] = []

    def grab_frame(self, **savefig_kwargs: Any) -> None:
        canvas = self.fig.canvas
        assert isinstance(canvas, FigureCanvasAgg)
        frame = Image.fromarray(pixels(canvas)[..., :3])
        self.pictures.append(
            frame.quantize(PALETTE, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        )

    def finish(self) -> None:
        # A GIF counts hundredths of a second.
        ends = [round(100.0 * k / self.fps) for k in range(len(self.pictures) + 1)]
        lengths = [10 * int(length) for length in np.diff(ends)]
        self.pictures[0].save(
            self.outfile,
            format="GIF",
            save_all=True,
            append_images=self.pictures[1:],
            duration=lengths,
            loop=0,
        )


def still(picture: npt.NDArray[np.uint8]) -> Artist:
    """A picture of the whole figure (height, width, 4), below everything else. An image of matplotlib would be resampled in every frame."""
    upright = picture[::-1].copy()

    def draw(renderer: RendererBase) -> None:
        renderer.draw_image(renderer.new_gc(), 0, 0, upright)

    artist = Artist()
    artist.set_zorder(-1)
    artist.draw = draw  # type: ignore[method-assign]
    return artist


def readable(run: Run, times: _Floats) -> _Floats:
    """The sorted times. For those so close to a Zeno point that too many summed impacts come before them, the last time that can be
    read."""
    try:
        run.at(times)
    except ValueError:
        times = times.copy()
    else:
        return times
    ends = [point.time for point in run.zeno_points if is_infinite(point)]
    edges = np.unique([0, *np.searchsorted(times, ends), len(times)])
    for begin, end in pairwise(edges):
        read, deep = begin, end
        while deep - read > 1:
            middle = (read + deep) // 2
            try:
                run.at(times[middle])
            except ValueError:
                deep = middle
            else:
                read = middle
        times[deep:end] = times[read]
    return times


def modes_at(run: Run, times: _Floats) -> list[str]:
    """The letters of the contact modes at these times: after an event at one of them."""
    starts = [phase.start for phase in run.phases]
    found = np.searchsorted(starts, times, side="right")
    modes = ["S" * len(run.contacts), *(phase.mode for phase in run.phases)]
    return [modes[index] for index in found]


def impacts(run: Run, times: _Floats, gaps: _Floats) -> list[_Floats]:
    """The times of the impacts of each contact, in s on the clock of the run: those on record, and those that are summed, as far as the
    gaps (k, n) at these times (k,) show them. Sides have no gaps; their impacts are all on record."""

    def recorded_of(index: int) -> _Floats:
        recorded = run.impacts["time"][run.impacts["index"] == index]
        return np.unique(np.clip(recorded, start(run), run.time))

    found = []
    for index, gap in enumerate(gaps.T):
        falls = gap[1:-1] < gap[:-2]
        low = 1 + np.flatnonzero(falls & (gap[1:-1] <= gap[2:]))
        peaks = np.maximum.reduceat(gap, [0, *low]) if len(low) else np.array([0.0])
        hits = gap[low] <= TOUCHED * np.minimum(peaks[:-1], peaks[1:])
        found.append(np.unique([*recorded_of(index), *times[low[hits]]]))
    sides = range(len(found), len(run.contacts))
    return found + [recorded_of(index) for index in sides]


def decimals(times: _Floats) -> int:
    """How many digits after the point tell these times apart, as far as doubles have them.

    >>> decimals(np.array([0.0, 0.5, 0.52]))
    4
    """
    steps = np.diff(times)
    whole = float(abs(times).max()) or 1.0
    least = float(steps.min(initial=whole, where=steps > 0.0))
    last = DIGITS - 1 - math.floor(math.log10(whole))
    return max(0, min(2 - math.floor(math.log10(least)), last))


class Film:
    """The figure of a film, and what changes in it from frame to frame.

    t (k,), s: times of the frames on the clock of the run; film (k,), s: their times in the film; points (k, m, 2) and forces (k, m, 2): of the
    contacts of the run, sides included; gaps (k, n): of those of the posture.
    """

    def __init__(self, run: Run, fps: float, speed: float, clock: str) -> None:
        self.run: Run = run
        self.clock: str = clock
        self.speed = speed
        self.t: _Floats = readable(run, run.frame_times(fps, speed, clock))  # type: ignore[arg-type]
        self.film: _Floats = self.in_film(self.t)
        self.points: _Floats = run.points_at(self.t)
        self.gaps: _Floats = run.gaps_at(self.t)
        self.forces: _Floats = run.forces_at(self.t)
        self.modes: list[str] = modes_at(run, self.t)
        self.frictions: list[float] = [contact.friction for contact in run.contacts]
        self.posture: Posture | None = run.posture
        assert self.posture is not None
        self.size: float = body_size(self.posture)
        self.infinite: list[ZenoPoint] = [
            point for point in run.zeno_points if is_infinite(point)
        ]
        self.q: _Floats = run.at(self.t)[0]
        centers = self.q[:, :2]
        self.follows: bool = bool(np.ptp(centers, axis=0).max() > JOURNEY * self.size)
        self.view: View = View(run, None if self.follows else self.t, WIDE)
        if self.follows:
            self._widen()
        if run.ground_motion is not None:
            self.view.low[1] -= BELOW_GROUND * self.view.scale
            self.view.height += BELOW_GROUND
        self.tangents: _Floats = self._tangents()
        self.largest = float(
            np.hypot(*np.moveaxis(np.nan_to_num(self.forces), -1, 0)).max()
        )
        weight = self.posture.mass * self.posture.gravity
        #: Force (N) whose arrow has the length `reach` (m).
        self.unit: float = weight or self.largest or 1.0
        self.reach: float = self._reach()
        self.decimals: int = decimals(self.t)
        self.draw()

    def in_film(self, t: npt.ArrayLike) -> _Floats:
        """Times in the film at times on the clock of the run, in s."""
        return self.run.film_time(t, self.speed, self.clock)  # type: ignore[arg-type]

    def _widen(self) -> None:
        """Makes the box large enough for the body in every direction."""
        box = self.view.high - self.view.low
        more = max(1.0, 2.0 * AROUND * self.size / float(box.min()))
        middle = 0.5 * (self.view.low + self.view.high)
        self.view.low = middle - 0.5 * more * box
        self.view.high = middle + 0.5 * more * box
        self.view.scale *= more

    def _tangents(self) -> _Floats:
        """Directions (k, m, 2) of the ground at the contacts; of a side, its own direction."""
        assert self.posture is not None
        own = len(self.run.gaps)
        tangents = np.empty_like(self.points)
        if self.posture.terrain is None and self.posture.ground == "own":
            slopes = np.array([contact.slope for contact in self.posture.contacts])
            tangents[:, :own] = np.column_stack([np.cos(slopes), np.sin(slopes)])
        else:
            pieces = ground(self.posture)
            feet = self.points[:, :own].reshape(-1, 2)
            found = np.array([nearest(pieces, foot)[1] for foot in feet])
            tangents[:, :own] = found.reshape(len(self.t), own, 2)
        for index, contact in enumerate(self.run.contacts[own:], start=own):
            assert contact.along is not None
            turns = 0.0 * self.t if self.run.model == "local" else self.q[:, 2]
            (x, y), c, s = contact.along, np.cos(turns), np.sin(turns)
            tangents[:, index] = np.column_stack([c * x - s * y, s * x + c * y])
        return tangents

    def _reach(self) -> float:
        """The length (m) of the arrow of a force as large as the weight: such that the arrows stay in the picture, as far as they are then long
        enough to be seen."""
        side = float((self.view.high - self.view.low).min())
        reach = min(FORCE * self.size, ROOM * side)
        if self.largest > 0.0 and not self.follows:
            normals = self.tangents[..., ::-1] * (-1.0, 1.0)
            ways = self.forces[..., :1] * self.tangents + self.forces[..., 1:] * normals
            ways = np.nan_to_num(ways) / self.unit
            long = np.maximum(1.0, np.hypot(*np.moveaxis(ways, -1, 0)) / LONGEST)
            ways /= long[..., None]
            with np.errstate(divide="ignore", invalid="ignore"):
                room = np.where(ways > 0.0, self.view.high, self.view.low) - self.points
                most = (room / ways)[abs(ways) > ASIDE * abs(ways).max()]
            reach = min(reach, float(most.min()))
        return max(SEEN * side, reach)

    def draw(self) -> None:
        """Draws what does not change, and prepares what does."""
        times, gaps = self._sampled()
        opens = not stays_closed(self.run)
        heights = [self.view.height + LABELS] + [GAPS] * opens
        tall = sum(heights) + ROWS
        # H.264 needs even numbers of pixels.
        wide, high = (2 * round(0.5 * DPI * side) / DPI for side in (WIDE, tall))
        self.figure: Figure = Figure((wide, high), dpi=DPI)
        canvas = FigureCanvasAgg(self.figure)
        self.figure.set_layout_engine("constrained", h_pad=0.08)
        grid = self.figure.add_gridspec(len(heights), 1, height_ratios=heights)
        self.body: Axes = self.figure.add_subplot(grid[0])
        self.curves: Axes | None = self.figure.add_subplot(grid[1]) if opens else None
        self.moving: list[Artist] = []
        self.entries: dict[str, Any] = {}
        self.shown_gaps: list[int] = []
        self.dots: list[Line2D] = []
        self._find_hits(times, gaps)
        self._list_contacts()
        if self.curves is not None:
            self._draw_gaps(self.curves, times, gaps)
        self._draw_body()
        first = dict(list(self.entries.items())[:LEGEND])
        self.figure.legend(
            list(first.values()),
            list(first),
            loc="outside lower left",
            ncols=min(len(first), COLUMNS),
            fontsize=SMALL,
            frameon=False,
            borderaxespad=0.2,
            columnspacing=1.4,
        )
        if self.follows:
            self.body.yaxis.labelpad += 72.0 * CHANGING
        self.update(0)
        pixels(canvas)
        if self.follows:
            x, _ = self.body.transAxes.inverted().transform(
                self.body.yaxis.label.get_window_extent().get_points().mean(axis=0)
            )
            self.body.yaxis.set_label_coords(x, 0.5)
        self.figure.set_layout_engine("none")
        self._freeze(canvas)

    def _freeze(self, canvas: FigureCanvasAgg) -> None:
        """Replaces everything that does not change by its picture, which is much faster than drawing it in every frame."""
        axes = [] if self.follows else [self.body]
        axes += [] if self.curves is None else [self.curves]
        visible = {artist: artist.get_visible() for artist in self.moving}
        for artist in self.moving:
            artist.set_visible(False)
        if self.follows:
            self.body.set_visible(False)
        background = still(pixels(canvas))
        for artist, seen in visible.items():
            artist.set_visible(seen)
        self.body.set_visible(True)
        for panel in axes:
            for artist in panel.get_children():
                if artist not in visible:
                    artist.set_visible(False)
        for legend in self.figure.legends:
            legend.set_visible(False)
        self.figure.add_artist(background)

    def _moves(self, artist: Any) -> Any:
        self.moving.append(artist)
        return artist

    # --- The panel of the gaps ---

    def _find_hits(self, times: _Floats, gaps: _Floats) -> None:
        """The impacts of each contact, in the film and in the world. The gaps (k, n) at these times (k,) get zeros there."""
        run = self.run
        self.hits: list[tuple[_Floats, _Floats]] = []
        for index, when in enumerate(impacts(run, times, gaps)):
            self.hits.append((self.in_film(when), run.points_at(when)[:, index]))
            if index < len(run.gaps):
                gaps[np.isin(times, when), index] = 0.0

    def _list_contacts(self) -> None:
        """The contacts in the legend, and those whose gaps are drawn."""
        run, own = self.run, len(self.run.gaps)
        touched = touching(run) if own > FEW else set(range(own))
        self.shown_gaps = sorted(index for index in touched if index < own)
        for index in self.shown_gaps:
            line = Line2D([], [], lw=1.4, **self._line(index))
            mark = self._mark(index)
            self.entries[f"contact {index + 1}"] = (
                mark if self.curves is None else (line, mark)
            )
        sides = sorted(k for k in touching(run) if k >= own)  # without gaps
        if len(sides) > FEW:
            label = f"{contacts_named([k + 1 for k in sides])} (sides)"
            self.entries[label] = tuple(self._mark(k) for k in sides[:FEW])
        else:
            self.entries |= {called(run, k): self._mark(k) for k in sides}

    @staticmethod
    def _line(index: int) -> dict[str, Any]:
        return {"color": COLORS[index % 4], "ls": LINES[style(index)]}

    def _draw_gaps(self, axes: Axes, times: _Floats, gaps: _Floats) -> None:
        zeno = self.clock == "zeno"
        shown = self.in_film(times)
        lowest = CLOSED * self.size
        highest = float(gaps[np.isfinite(gaps)].max(initial=0.0))
        if zeno:
            axes.set_yscale("log")
            gaps = np.maximum(gaps, 1e-3 * lowest)
        for index in self.shown_gaps:
            axes.plot(shown, gaps[:, index], lw=1.4, **self._line(index))
        if zeno:
            axes.set_ylim(lowest, max(3.0 * highest, 10.0 * lowest))
            axes.yaxis.set_major_locator(LogLocator(numticks=8))
            axes.yaxis.set_minor_locator(NullLocator())
        else:
            axes.set_ylim(0.0, 1.05 * highest if highest > 0.0 else None)
        end = float(self.film[-1])
        axes.set_xlim(0.0, (1.0 + EDGE) * end if end > 0.0 else 1.0)
        ends = self.in_film([point.time for point in self.infinite])
        for x in ends[apart(ends, APART * end)] if len(ends) else []:
            label = "Zeno point" if len(self.infinite) == 1 else "Zeno points"
            dotted = axes.axvline(x, color="black", lw=1.0, ls=":", zorder=0)
            self.entries[label] = dotted
        for kick in self._kicks():
            axes.axvline(float(self.in_film(kick.time)), color=KICK, lw=1.5, zorder=0.5)
        axes.set_ylabel("gap / m")
        axes.set_xlabel(f"time of the film / s ({self._pace()})")
        axes.spines[["top", "right"]].set_visible(False)
        self.cursor: Line2D = self._moves(axes.axvline(0.0, color="black", lw=1.2))
        self.dots = [
            self._moves(Line2D([], [], clip_on=False, **self._look(index)))
            for index in self.shown_gaps
        ]
        for dot in self.dots:
            axes.add_line(dot)

    def _pace(self) -> str:
        """What a second of the film is."""
        real = f"1 s is {self.speed:.3g} s of the run"
        if self.clock == "real" or not self.infinite:
            return real
        factor = "tenfold" if self.speed == 1.0 else f"10^{self.speed:.3g}-fold"
        left = f"1 s is a {factor} decrease of the time left to the Zeno point"
        after = self.infinite[-1].time < self.run.time
        return f"{left}, later {self.speed:.3g} s of the run" if after else left

    def _sampled(self) -> tuple[_Floats, _Floats]:
        """Times (k,) on the clock of the run, dense in the film, and the gaps (k, n) there."""
        if self.clock == "real" or not self.infinite:
            return curves(self.run)
        whole = float(self.film[-1]) * self.speed
        even = self.run.frame_times(1.0, max(whole, 1e-9) / CURVE, "zeno")
        times = np.unique([*readable(self.run, even), *event_times(self.run)])
        return sharpened(times, lambda t: self.run.gaps_at(t))

    def _look(self, index: int) -> dict[str, Any]:
        return {
            "linestyle": "none",
            "marker": MARKERS[style(index)],
            "color": COLORS[index % 4],
            "markerfacecolor": "white",
            "markeredgewidth": 1.6,
            "markersize": 6 if len(self.run.gaps) <= FEW else 3.5,
            "zorder": 5,
        }

    def _mark(self, index: int) -> Line2D:
        return Line2D([], [], **self._look(index))

    # --- The panel of the body ---

    def _kicks(self) -> list[Any]:
        begin, end = start(self.run), self.run.time
        return [kick for kick in self.run.kicks if begin <= kick.time <= end]

    def _draw_body(self) -> None:
        axes, view = self.body, self.view
        assert self.posture is not None
        axes.set_aspect("equal", adjustable="box", anchor="W")
        axes.set_xlim(view.low[0], view.high[0])
        axes.set_ylim(view.low[1], view.high[1])
        axes.set_autoscale_on(False)
        self.ground: list[Artist] = draw_ground(axes, view)
        if self.follows:
            self.middle: _Floats = 0.5 * (view.low + view.high)
        frame = "" if self.run.ground_motion is None else ", relative to the ground"
        axes.set_xlabel(f"x / m{frame}")
        axes.set_ylabel("y / m")
        axes.spines[["top", "right"]].set_visible(False)
        self.trail: Line2D
        (self.trail,) = axes.plot([], [], color=PATH, lw=1.0, ls=":")
        self._moves(self.trail)
        corners = view.poses[0].outline
        self.shape: Any = self._moves(
            Area(corners, closed=True, fc=BODY, alpha=0.35, lw=0)
        )
        axes.add_patch(self.shape)
        self.outline: Line2D
        (self.outline,) = axes.plot(*corners.T, color="black", lw=1.6)
        self.arms: Line2D
        (self.arms,) = axes.plot([], [], color="black", lw=0.6)
        self.center: Line2D
        (self.center,) = axes.plot([], [], color="black", marker="+", ms=7, ls="none")
        for artist in (self.outline, self.arms, self.center):
            self._moves(artist)
        self._draw_contacts()
        self._draw_excitation()
        self._draw_ghost()
        self.title: Text
        self.left: Text
        self.title, self.left = (
            self._moves(axes.set_title(" ", loc=loc, fontsize=9.5, y=1.0))
            for loc in ("left", "right")
        )

    def _draw_contacts(self) -> None:
        axes = self.body
        assert self.posture is not None
        self.cones: list[Wedge] = []
        self.arrows: list[FancyArrowPatch] = []
        self.letters: list[Text] = []
        self.rings: list[Line2D] = []
        self.feet: list[Line2D] = []
        for index, contact in enumerate(self.run.contacts):
            color = COLORS[index % 4]
            half = math.degrees(math.atan(contact.friction))
            cone = Wedge((0, 0), self.reach, -half, half, lw=0.8)
            cone.set(fc=to_rgba(color, CONE), ec=to_rgba(color, EDGES))
            axes.add_patch(cone)
            cone.set_zorder(1.5)
            arrow = self._arrow(color)
            look: dict[str, Any] = {"ha": "center", "va": "center", "zorder": 6}
            letter = axes.text(
                0, 0, "", fontsize=10, weight="bold", color=color, **look
            )
            ring = Line2D(
                [], [], ls="none", marker="o", mfc="none", mec=color, zorder=7
            )
            axes.add_line(ring)
            foot = Line2D([], [], **self._look(index))
            axes.add_line(foot)
            self.cones.append(self._moves(cone))
            self.arrows.append(self._moves(arrow))
            self.letters.append(self._moves(letter))
            self.rings.append(self._moves(ring))
            self.feet.append(self._moves(foot))
        if self.largest > 0.0:
            cut = self.largest > LONGEST * self.unit
            more = f", cut off at {LONGEST * self.unit:.3g} N" if cut else ""
            label = f"contact force (longest {self.largest:.3g} N{more})"
            self.entries[label] = Line2D([], [], color="black", lw=2.0, marker=">")
        rough = any(contact.friction > 0.0 for contact in self.run.contacts)
        if self.largest > 0.0 and rough:
            look = {"fc": to_rgba("black", CONE), "ec": to_rgba("black", EDGES)}
            label = f"friction cone (its length: {self.unit:.3g} N, the weight)"
            self.entries[label] = Patch(lw=0.8, **look)
        if any(len(times) for times, _ in self.hits):
            self.entries["impact"] = Line2D(
                [], [], ls="none", marker="o", mfc="none", mec="black", ms=10
            )
        words = set("".join(self.modes))
        for word, name in LETTERS.items():
            if word in words:
                self.entries[name] = Line2D(
                    [],
                    [],
                    ls="none",
                    marker=f"$\\mathbf{{{word}}}$",
                    color="black",
                    mew=0,
                    ms=7,
                )

    def _arrow(self, color: str, width: float = 2.2) -> FancyArrowPatch:
        arrow = FancyArrowPatch(
            (0, 0),
            (1, 1),
            arrowstyle="-|>",
            mutation_scale=12,
            lw=width,
            color=color,
            shrinkA=0,
            shrinkB=0,
            zorder=5.5,
        )
        self.body.add_patch(arrow)
        return arrow

    def _draw_excitation(self) -> None:
        kicks = self._kicks()
        self.kicked: list[tuple[float, _Floats, Any]] = [
            (float(self.in_film(kick.time)), arrow, self._moves(self._arrow(KICK, 3.0)))
            for kick, arrow in zip(kicks, kick_arrows(self.run, kicks), strict=False)
        ]
        if self.kicked:
            label = "kick" if len(kicks) == 1 else "kicks"
            self.entries[label] = Line2D([], [], color=KICK, lw=3.0, marker=">")
        motion = self.run.ground_motion
        self.shaken: FancyArrowPatch | None = None
        if motion is None:
            return
        if motion.tilt is not None:
            tilts = np.array([0.0, *motion.tilt])
            self.steps: _Floats = -np.column_stack([np.sin(tilts), np.cos(tilts)])
            self.words: list[str] = [
                f"gravity, the ground tilted by {plain(a, '.3g')} rad" for a in tilts
            ]
        else:
            self.steps = np.array([(0.0, 0.0), *(motion.acceleration or ())])
            sizes = np.hypot(*self.steps.T)
            self.words = [f"acceleration of the ground {a:.3g} m/s²" for a in sizes]
        longest = float(np.hypot(*self.steps.T).max())
        self.steps = self.steps * (SHAKE * self.view.scale / (longest or 1.0))
        self.shaken = self._moves(self._arrow("black", 2.6))
        self.shaking: Any = self._moves(self.body.text(0, 0, "", fontsize=SMALL + 1))

    # --- The frames ---

    def frames(self) -> Iterator[int]:
        """Sets the figure to each frame in turn."""
        progress = bar(len(self.t), "frame", None)
        for k in range(len(self.t)):
            self.update(k)
            yield k
            if progress is not None:
                progress.update(1)
        if progress is not None:
            progress.close()

    def update(self, k: int) -> None:
        """Sets the figure to frame k."""
        run, t, film = self.run, float(self.t[k]), float(self.film[k])
        shape = pose(run, t) if self.follows else self.view.poses[k]
        if self.follows:
            away = shape.center - self.middle
            view = self.view
            box = 0.5 * (view.high - view.low)
            view.low, view.high = shape.center - box, shape.center + box
            self.middle = self.middle + away
            self.body.set_xlim(view.low[0], view.high[0])
            self.body.set_ylim(view.low[1], view.high[1])
            for artist in self.ground:
                artist.remove()
            self.ground = draw_ground(self.body, view)
        self.shape.set_xy(shape.outline)
        self.outline.set_data(*shape.outline.T)
        if run.posture is not None and run.posture.outline is None:
            self.arms.set_data(*shape.spokes.T)
        self.center.set_data(*shape.center[:, None])
        begun = self.view.samples <= t
        self.trail.set_data(*np.vstack([self.view.path[begun], shape.center]).T)
        self._update_contacts(k, film)
        self._update_excitation(t, film)
        self.title.set_text(f"t = {self._written(t)} s")
        self.left.set_text(self._time_left(t))
        self._update_ghost(k, shape)
        if self.curves is None:
            return
        self.cursor.set_xdata([film, film])
        lowest = self.curves.get_ylim()[0]
        for index, dot in zip(self.shown_gaps, self.dots, strict=True):
            dot.set_data([film], [max(self.gaps[k, index], lowest)])

    # --- The body with magnified gaps ---

    def _draw_ghost(self) -> None:
        axes = self.body
        outline = Line2D([], [], color="black", lw=1.3, ls=(0, (5, 3)), zorder=3)
        feet = Line2D([], [], color="black", ls="none", marker="o", ms=4, zorder=5)
        self.ghost: list[Line2D] = [outline, feet]
        for line in self.ghost:
            axes.add_line(self._moves(line))
        look: dict[str, Any] = {"transform": axes.transAxes, "va": "top", "zorder": 7}
        self.caption: Text = self._moves(axes.text(0.01, 0.98, "", fontsize=9, **look))

    def _update_ghost(self, k: int, shape: Pose) -> None:
        found = self._magnified(k, shape.center)
        for artist in (*self.ghost, self.caption):
            artist.set_visible(found is not None)
        if found is None:
            return
        (*way, turn), factor = found

        def moved(points: _Floats) -> _Floats:
            x, y = (points - shape.center).T
            shifted: _Floats = points + way + turn * np.column_stack([-y, x])
            return shifted

        for line, points in zip(
            self.ghost, (shape.outline, shape.contacts), strict=True
        ):
            line.set_data(*moved(points).T)
        digits, power = f"{factor:.1e}".split("e")
        size = (
            f"{factor:.0f}"
            if factor < 1000.0
            else rf"${digits}\cdot 10^{{{int(power)}}}$"
        )
        self.caption.set_text(f"dashed: gaps {size} times as large")

    def _magnified(self, k: int, center: _Floats) -> tuple[_Floats, float] | None:
        """By the Zeno clock, a displacement (x, y, θ) of the body of frame k after which its gaps are larger by a factor, so that the
        largest of them can be seen; None where it can be seen anyway.

        It is (factor − 1) Nᵀ(N Nᵀ)⁻¹ h, with the rows N of the normal velocities and the gaps h of the contacts that come to rest.
        """
        later = [point for point in self.infinite if point.time > self.t[k]]
        if self.clock != "zeno" or not later:
            return None
        contacts = np.array(later[0].contacts[:2]) - 1
        if contacts.max() >= self.gaps.shape[1]:  # sides have no gaps
            return None
        near = abs(self.film - self.film[k]) * self.speed <= DECADES
        near &= self.t < later[0].time
        largest = float(np.nan_to_num(self.gaps[near][:, contacts]).max())
        if not 0.0 < largest < LIFTED * self.size / MAGNIFIED:
            return None
        factor = LIFTED * self.size / largest
        tangents = self.tangents[k, contacts]
        arms = self.points[k, contacts] - center
        levers = (arms * tangents).sum(axis=1) / self.size
        rows = np.column_stack([-tangents[:, 1], tangents[:, 0], levers])
        gram = rows @ rows.T
        if np.linalg.det(gram) <= PARALLEL * np.diag(gram).prod():
            return None
        lift = (factor - 1.0) * np.linalg.solve(gram, self.gaps[k, contacts]) @ rows
        lift[2] /= self.size
        return lift, factor

    def _update_contacts(self, k: int, film: float) -> None:
        mode = self.modes[k]
        inch = self.view.scale
        written: list[_Floats] = []
        for index, point in enumerate(self.points[k]):
            tangent = self.tangents[k, index]
            normal = np.array([-tangent[1], tangent[0]])
            closed = mode[index] != "S"
            pull, push = self.forces[k, index]
            force = pull * tangent + push * normal
            pressed = closed and bool(np.isfinite(force).all()) and force.any()
            self.feet[index].set_data(*point[:, None])
            self.feet[index].set_visible(closed or index < len(self.run.gaps))
            self.cones[index].set_visible(bool(pressed) and self.frictions[index] > 0.0)
            self.arrows[index].set_visible(bool(pressed))
            if pressed:
                turn = math.degrees(math.atan2(normal[1], normal[0]))
                half = math.degrees(math.atan(self.frictions[index]))
                self.cones[index].set_center(tuple(point))
                self.cones[index].set_theta1(turn - half)
                self.cones[index].set_theta2(turn + half)
                longest = max(1.0, math.hypot(*force) / (LONGEST * self.unit))
                way = self.reach * force / self.unit / longest
                self.arrows[index].set_positions(tuple(point), tuple(point + way))
            place = point - INTO * inch * normal
            free = all(math.hypot(*(place - p)) > LETTER * inch for p in written)
            self.letters[index].set_text(mode[index] if closed and free else "")
            if closed and free:
                self.letters[index].set_position(tuple(place))
                written.append(place)
            self._flash(index, film)

    def _flash(self, index: int, film: float) -> None:
        """The ring of the last impact of a contact, which grows and fades."""
        times, places = self.hits[index]
        last = int(np.searchsorted(times, film, side="right")) - 1
        age = film - times[last] if last >= 0 else math.inf
        ring = self.rings[index]
        ring.set_visible(age < FLASH)
        if age < FLASH:
            share = age / FLASH
            ring.set_data(*places[last][:, None])
            ring.set_markersize(RING[0] + (RING[1] - RING[0]) * share)
            ring.set_markeredgewidth(3.0 - 2.0 * share)

    def _update_excitation(self, t: float, film: float) -> None:
        for time, (tail, head), arrow in self.kicked:
            arrow.set_visible(time <= film < time + KICKED)
            arrow.set_positions(tuple(tail), tuple(head))
        if self.shaken is None:
            return
        motion = self.run.ground_motion
        assert motion is not None
        step = int(np.searchsorted(motion.times, t, side="right"))
        inch, view = self.view.scale, self.view
        way = self.steps[step]
        # In the middle of the strip, whatever its direction.
        middle = view.low + inch * np.array([0.2 + SHAKE, 0.5 * BELOW_GROUND])
        tail, head = middle - 0.5 * way, middle + 0.5 * way
        self.shaken.set_visible(bool(way.any()))
        self.shaken.set_positions(tuple(tail), tuple(head))
        self.shaking.set_text(self.words[step])
        self.shaking.set_position(tuple(middle + inch * np.array([SHAKE, -0.04])))

    def _written(self, t: float) -> str:
        """A time with as many digits as tell the frames apart, as far as a double has them."""
        return f"{t:.{self.decimals}f}"

    def _time_left(self, t: float) -> str:
        """The time left to the next Zeno point, in words; without one, what a second of the film is where no axis says so."""
        if not self.infinite:
            return self._pace() if self.curves is None else ""
        later = [point for point in self.infinite if point.time > t]
        if any(point.time == t for point in self.infinite):
            return f"at the Zeno point{self._who(t)}"
        if not later:
            return (
                "after the Zeno point"
                if len(self.infinite) == 1
                else "after the last Zeno point"
            )
        left = later[0].time - t
        return f"{left:#.2g} s before the Zeno point of {contacts_named(later[0].contacts)}"

    def _who(self, t: float) -> str:
        at: ZenoPoint = next(point for point in self.infinite if point.time == t)
        return f" of {contacts_named(at.contacts)}"
