"""Pictures of what a posture withstands: the share of random kicks over their size, the sizes of pushes. Needs matplotlib."""

from os import PathLike

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, PercentFormatter

from standfast._core import Robustness, SmallestPush, stability
from standfast.plot import COLORS, Picture, axes_or_none, fitted, save
from standfast.table import rounded_down

#: Width and height of a new figure, in inches (one column of a paper); size of its text, in points; dots per inch.
WIDTH, HEIGHT, TEXT, DPI = 3.4, 2.5, 8.0, 220
#: Room below 0 % and above 100 %, so that marks there are whole.
ROOM = 0.04


def plot(
    result: Robustness | SmallestPush,
    path: str | PathLike[str] | None = None,
    ax: object = None,
) -> Figure | Axes:
    """As `Robustness.plot` and `SmallestPush.plot`."""
    draw = draw_shares if isinstance(result, Robustness) else draw_push
    axes = axes_or_none(ax)
    if axes is not None:
        if path is not None:
            raise ValueError(
                f"path = {str(path)!r} cannot be used: None is allowed with ax; save the figure of the axes instead"
            )
        draw(axes, result)  # type: ignore[arg-type]
        fitted(axes)
        return axes
    with rc_context({"font.size": TEXT}):
        figure = Picture(figsize=(WIDTH, HEIGHT), dpi=DPI, layout="constrained")
        draw(figure.subplots(), result)  # type: ignore[arg-type]
        if path is not None:
            save(figure, path)
    return figure


def draw_shares(axes: Axes, result: Robustness) -> None:
    """The share over the size, both ends of its interval as a bar, in the order of the sizes."""
    order = np.argsort(result.sizes, kind="stable")
    sizes, share = result.sizes[order], result.share[order]
    # The share lies in its interval but for rounding.
    errors = np.maximum(np.abs(result.interval[order] - share[:, None]), 0.0)
    axes.errorbar(
        sizes,
        share,
        yerr=errors.T,
        color=COLORS[0],
        marker="o",
        markersize=3.5,
        linewidth=1.0,
        elinewidth=1.2,
        capsize=2.5,
        label=f"{result.trials} kicks of each size, interval of 95 %",
    )
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    verdict = stability(result.posture)
    speed = verdict.safe_speed
    law = result.options["impact"]
    if speed is not None and result.options["model"] == "full" and law in verdict.laws:
        axes.axvline(
            speed,
            color=COLORS[1],
            linestyle="--",
            linewidth=1.2,
            label=f"safe speed {rounded_down(speed)} m/s, proved",
        )
    axes.set_ylim(-ROOM, 1.0 + ROOM)
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, symbol=" %"))
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_xlabel("size of the kick / (m/s)")
    axes.set_ylabel("back after the kick")
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.0,
        frameon=False,
        fontsize="medium",
    )


def draw_push(axes: Axes, result: SmallestPush) -> None:
    """The sizes as a bar, dark where the body does not come back, with the ends of its intervals as numbers below."""
    name = {"N s": "kick / N s", "N": "force / N", "": "factor of the record"}
    axes.axvspan(0, result.at_most, color=COLORS[0], alpha=0.25, lw=0, label="back")
    label: str | None = "not back"
    for low, high in result.intervals:
        axes.axvspan(low, high, color=COLORS[1], lw=0, label=label)
        label = None
    axes.set_xlim(0, result.at_most)
    axes.set_yticks([])
    axes.set_xlabel(name[result.unit])
    if len(result.intervals):
        smallest = result.intervals[0, 0]
        axes.set_title(
            f"not back from {smallest:.6g} {result.unit} on",
            loc="left",
            fontsize="medium",
        )
    axes.legend(loc="upper right", framealpha=0.9, fontsize="medium")
