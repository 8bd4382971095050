"""Pictures of maps: one panel for each quantity of a sweep. Needs matplotlib."""

import math
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, Stroke

from standfast._core import Posture
from standfast.maps import described
from standfast.plot import save

if TYPE_CHECKING:
    import xarray

#: Colours of words, after Okabe and Ito: readable with every kind of colour vision. Unknown results are grey.
COLORS = {
    "stable": "#0072B2",
    "unstable": "#D55E00",
    "not-equilibrium": "#7F7F7F",
    "theorem-3": "#004C78",
    "theorem-3-loose": "#0072B2",
    "goyal": "#56B4E9",
    "corner-map": "#009E73",
    "growing-cycle": "#D55E00",
    "accelerating-mode": "#E69F00",
    "undecided": "#D9D9D9",
    "rest": "#0072B2",
    "zeno": "#56B4E9",
    "escape": "#D55E00",
    "sliding": "#E69F00",
    "inconsistent": "#000000",
    "ambiguous": "#CC79A7",
    "time-limit": "#D9D9D9",
    "event-limit": "#7F7F7F",
    "yes": "#0072B2",
    "no": "#D9D9D9",
}
#: A map over both coordinates of the centre of mass is drawn to scale.
PLACES = {"center_of_mass.x", "center_of_mass.y"}
#: Width of a panel and of the figure's height, in inches.
WIDTH, HEIGHT = 6.0, 5.2
#: Position and size of the colour scale beside a panel, relative to the width and height of the panel.
SCALE = (1.03, 0.0, 0.05, 1.0)
#: Share of the lowest and of the highest values, in percent, that are drawn in the colour of the end of the scale.
POLES = 2.0
#: Panels in a row.
ROW = 2


def draw(
    grid: "xarray.Dataset",
    path: str | PathLike[str] | None = None,
    *,
    posture: Posture | None = None,
) -> Figure:
    """Draw every quantity of a sweep over one or two parameters; if `path` is given, save the figure there.

    Words and flags are drawn as areas; the legend has the share of the map that each covers. Numbers are drawn as
    colours with a scale, and a line where they change their sign. If the parameters are both coordinates of the
    centre of mass, the contacts of `posture` are shown, too.
    """
    refuse(list(grid.sizes))
    names = [str(name) for name in grid.data_vars]
    rows = math.ceil(len(names) / ROW)
    columns = min(len(names), ROW)
    size = (WIDTH * columns, HEIGHT * rows)
    layout: Literal["compressed", "constrained"] = (
        "compressed" if set(grid.sizes) == PLACES else "constrained"
    )
    if path is None:
        import matplotlib.pyplot as plt

        figure = plt.figure(figsize=size, dpi=110, layout=layout)
    else:
        figure = Figure(figsize=size, dpi=110, layout=layout)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, name in zip(panels, names, strict=False):
        panel(axes, grid, name)
        if posture is not None:
            contacts(axes, grid, posture)
    for axes in panels[len(names) :]:
        axes.remove()
    if path is not None:
        save(figure, path)
    return figure


def refuse(parameters: list[Any]) -> None:
    """Raise ValueError unless there are one or two parameters."""
    if not 1 <= len(parameters) <= 2:
        raise ValueError(
            f"over = {', '.join(map(str, parameters))} cannot be drawn: one or two parameters are allowed"
        )


def panel(axes: Axes, grid: "xarray.Dataset", name: str) -> None:
    """One quantity over one or two parameters. The first parameter is on the horizontal axis."""
    variable = grid[name].sortby(list(grid[name].dims))
    paths = [str(dim) for dim in variable.dims]
    coordinates = [variable[path].values for path in paths]
    axes.set_title(described(name)[0])
    axes.set_xlabel(label(paths[0]))
    values = variable.values
    if values.dtype.kind == "f":
        if len(paths) == 1:
            axes.plot(coordinates[0], values, color=COLORS["stable"])
            axes.set_ylabel(label(name))
        else:
            numbers(axes, coordinates, values, name)
    else:
        areas(axes, coordinates, values)
    if len(paths) == 2:
        axes.set_ylabel(label(paths[1]))
    else:
        axes.margins(x=0)
    if set(paths) == PLACES:
        axes.set_aspect("equal")


def label(name: str) -> str:
    """The text of an axis."""
    text, unit = described(name)
    return f"{text} / {unit}" if unit else text


def areas(
    axes: Axes, coordinates: list[npt.NDArray[Any]], values: npt.NDArray[Any]
) -> None:
    """Words or flags as areas, in the order of their legend."""
    if values.dtype == bool:
        values = np.where(values, "yes", "no")
    present = [word for word in COLORS if (values == word).any()]
    codes = np.zeros(values.shape)
    for code, word in enumerate(present):
        codes[values == word] = code
    if len(coordinates) == 1:
        coordinates = [*coordinates, np.array([0.0, 1.0])]
        codes = np.column_stack([codes, codes])
        axes.set_yticks([])
    axes.pcolormesh(
        *coordinates,
        codes.T,
        shading="nearest",
        cmap=ListedColormap([COLORS[word] for word in present]),
        vmin=-0.5,
        vmax=len(present) - 0.5,
        rasterized=True,
    )
    shares = [f"{word}  {percent((values == word).mean())}" for word in present]
    handles = [
        Patch(facecolor=COLORS[word], edgecolor="0.3", label=share)
        for word, share in zip(present, shares, strict=True)
    ]
    axes.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0.0,
        frameon=False,
    )


def percent(share: float) -> str:
    """A share in percent. A share above zero is not rounded to 0 %, and a share below one not to 100 %.

    >>> percent(0.25), percent(1e-6), percent(1.0), percent(1.0 - 1e-6)
    ('25.0 %', '<0.1 %', '100 %', '>99.9 %')
    """
    if share in (0.0, 1.0):
        return f"{100 * share:.0f} %"
    if share < 0.0005:
        return "<0.1 %"
    if share > 0.9995:
        return ">99.9 %"
    return f"{100 * share:.1f} %"


def numbers(
    axes: Axes,
    coordinates: list[npt.NDArray[Any]],
    values: npt.NDArray[Any],
    name: str,
) -> None:
    """Numbers as colours, with the line on which a margin changes its sign."""
    finite = np.where(np.isfinite(values), values, np.nan)
    known = finite[np.isfinite(finite)]
    # Without this a few poles would take the whole range of colours.
    low, high = np.percentile(known, [POLES, 100 - POLES]) if known.size else (0, 1)
    image = axes.pcolormesh(
        *coordinates,
        finite.T,
        shading="nearest",
        cmap="cividis",
        vmin=low,
        vmax=high,
        rasterized=True,
    )
    extend = {
        (False, False): "neither",
        (True, False): "min",
        (False, True): "max",
        (True, True): "both",
    }[bool((known < low).any()), bool((known > high).any())]
    axes.figure.colorbar(
        image, cax=axes.inset_axes(SCALE), label=label(name), extend=extend
    )
    if (
        min(values.shape) > 1
        and known.size
        and known.min() < 0.0 < known.max()
        and np.isfinite(values).all()
    ):
        lines = axes.contour(*coordinates, finite.T, levels=[0.0], colors="white")
        lines.set_path_effects([Stroke(linewidth=3.5, foreground="black"), Normal()])


def contacts(axes: Axes, grid: "xarray.Dataset", posture: Posture) -> None:
    """The contacts and their terrain, if the map is over both coordinates of the centre of mass."""
    if list(grid.sizes) != ["center_of_mass.x", "center_of_mass.y"]:
        return
    x, y = axes.get_xlim(), axes.get_ylim()
    reach = 0.12 * (x[1] - x[0])
    for contact in posture.contacts:
        tangent = np.array([math.cos(contact.slope), math.sin(contact.slope)])
        ends = [contact.point + side * reach * tangent for side in (-1, 1)]
        axes.plot(*np.transpose(ends), color="black", linewidth=2.5)
        axes.plot(*contact.point, "o", color="black", markerfacecolor="white")
    axes.set_xlim(x)
    axes.set_ylim(y)
