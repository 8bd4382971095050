"""Pictures of maps: one panel for each quantity of a sweep. Needs matplotlib."""

import math
from collections.abc import Mapping
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from matplotlib import rc_context, rcParams
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, is_color_like
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, Stroke
from matplotlib.text import Text

from standfast._core import Posture
from standfast.colors import COLORS
from standfast.plot import Picture, axes_or_none, fitted
from standfast.units import described, quantities

if TYPE_CHECKING:
    import xarray

#: A map over both coordinates of the centre of mass is drawn to scale.
PLACES = {"center_of_mass.x", "center_of_mass.y"}
#: Width of a panel (one column of a paper), of its labels and of its scale of colours, in inches.
WIDTH, LABELS, BAR = 3.4, 0.6, 0.6
#: Height of a panel, in inches: of its axes, least and largest of axes that are to scale, of a strip (one parameter), of the labels
#: below and the title above, and of a line of the legend.
HEIGHT, LEAST, LARGEST, STRIP, AROUND, LINE = 2.2, 0.8, 4.5, 0.5, 0.75, 0.16
#: Size of the text of a new figure, in points, and its resolution in dots per inch.
TEXT, DPI = 8.0, 220
#: A figure of given axes that is narrower than this, in inches, has text of at most this size.
NARROW = 4.5
#: Mean width of a character, relative to the size of the text.
CHARACTER = 0.55
#: Position and size of the colour scale beside a panel, relative to the width and height of the panel.
SCALE = (1.03, 0.0, 0.05, 1.0)
#: Share of the lowest and of the highest values, in percent, that are drawn in the colour of the end of the scale.
POLES = 2.0
#: Panels in a row.
ROW = 2


def draw(
    grid: "xarray.Dataset",
    ax: object = None,
    colors: Mapping[str, Any] | None = None,
    labels: Mapping[str, str] | None = None,
    posture: Posture | None = None,
) -> Figure | Axes:
    """As `standfast.plot_map`."""
    if not (hasattr(grid, "data_vars") and hasattr(grid, "sizes")):
        raise TypeError(
            f"dataset = {grid!r} cannot be used: a Dataset of sweep is allowed"
        )
    for name, value in (("colors", colors), ("labels", labels)):
        if not (value is None or isinstance(value, Mapping)):
            raise TypeError(
                f"{name} = {value!r} cannot be used: None or a mapping from names is allowed"
            )
    if not (posture is None or isinstance(posture, Posture)):
        raise TypeError(
            f"posture = {posture!r} cannot be used: None or a Posture is allowed"
        )
    axes = axes_or_none(ax)
    names = quantities(grid)
    refuse(list(grid.sizes))
    if not names:
        raise ValueError(
            "dataset cannot be used: a Dataset of sweep with at least one quantity is allowed"
        )
    style = Style(grid, colors or {}, labels or {})
    if axes is not None:
        if len(names) > 1:
            raise ValueError(
                f"dataset has the quantities {', '.join(names)}: with ax one is allowed, such as dataset[[{names[0]!r}]]"
            )
        panel(axes, grid, names[0], style, posture)
        if axes.figure.bbox.width / axes.figure.dpi < NARROW:
            smaller(axes)
        fitted(axes)
        return axes
    rows = math.ceil(len(names) / ROW)
    columns = min(len(names), ROW)
    heights = [height(grid, name) for name in names]
    tall = sum(max(heights[k : k + ROW]) for k in range(0, len(names), ROW))
    with rc_context({"font.size": TEXT}):
        figure = Picture(
            figsize=(WIDTH * columns, tall),
            dpi=DPI,
            layout="compressed" if set(grid.sizes) == PLACES else "constrained",
        )
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=False):
            panel(axes, grid, name, style, posture)
        for axes in panels[len(names) :]:
            axes.remove()
        for axes in figure.findobj(Axes):
            # Ticks are created later, when the size of text is another one.
            axes.tick_params(labelsize=TEXT)
    return figure


def smaller(axes: Axes) -> None:
    """Text of at most the size of a new figure, in axes and in the colour scale beside them."""
    for text in axes.findobj(Text):
        text.set_fontsize(min(text.get_fontsize(), TEXT))
    for one in axes.findobj(Axes):
        one.tick_params(labelsize=TEXT)


class Style:
    """The colours and texts of a map: the defaults, and what the caller has replaced."""

    def __init__(
        self,
        grid: "xarray.Dataset",
        colors: Mapping[str, Any],
        labels: Mapping[str, str],
    ) -> None:
        names = quantities(grid)
        words = {word for name in names for word in words_of(grid[name])}
        for field, given, known in (
            ("colors", colors, {*words, *names}),
            ("labels", labels, {*words, *names, *map(str, grid.sizes)}),
        ):
            for key in given:
                if key not in known and key not in COLORS:
                    raise ValueError(
                        f"{field} = {{{key!r}: ...}} cannot be used: the names in this dataset are {', '.join(sorted(known))}"
                    )
        for word in sorted(words | (set(colors) - set(names))):
            color = colors.get(word, COLORS.get(word))
            if not is_color_like(color):
                raise ValueError(
                    f"colors[{word!r}] = {color!r} cannot be used: a colour of matplotlib is needed"
                )
        self.colors: dict[str, Any] = {**COLORS, **colors}
        self.labels = labels

    def text(self, name: str) -> str:
        """The text for a word, or for a parameter or quantity without its unit."""
        if name in self.labels:
            return self.labels[name]
        try:
            return described(name)[0]
        except KeyError:
            return name

    def axis(self, name: str) -> str:
        """The text for a parameter or quantity, with its unit."""
        text = self.text(name)
        try:
            unit = "" if name in self.labels else described(name)[1]
        except KeyError:
            unit = ""
        return f"{text} / {unit}" if unit else text


def refuse(parameters: list[Any]) -> None:
    """Raise ValueError unless there are one or two parameters."""
    if not 1 <= len(parameters) <= 2:
        raise ValueError(
            f"over = {', '.join(map(str, parameters))} cannot be drawn: one or two parameters are allowed"
        )


def words_of(variable: "xarray.DataArray") -> list[str]:
    """The words of a quantity that occur, in the order of `COLORS` and then of the alphabet; none for numbers."""
    values = variable.values
    if values.dtype == bool:
        values = np.where(values, "yes", "no")
    if values.dtype.kind not in "UO":
        return []
    order = list(COLORS)
    found = [str(word) for word in np.unique(values)]
    return sorted(found, key=lambda w: order.index(w) if w in COLORS else len(order))


def height(grid: "xarray.Dataset", name: str) -> float:
    """The height of the panel of a quantity, in inches."""
    words = words_of(grid[name])
    tall = STRIP if words and len(grid.sizes) == 1 else HEIGHT
    if set(grid.sizes) == PLACES:
        across, up = (np.ptp(grid[path].values) for path in list(grid.sizes))
        wide = WIDTH - LABELS - (0.0 if words else BAR)
        if across > 0.0:
            tall = float(np.clip(wide * up / across, LEAST, LARGEST))
    return tall + AROUND + LINE * len(words)


def panel(
    axes: Axes,
    grid: "xarray.Dataset",
    name: str,
    style: Style,
    posture: Posture | None,
) -> None:
    """One quantity over one or two parameters. The first parameter is on the horizontal axis."""
    variable = grid[name].sortby(list(grid[name].dims))
    paths = [str(dim) for dim in variable.dims]
    coordinates = [variable[path].values for path in paths]
    axes.set_xlabel(style.axis(paths[0]))
    if words := words_of(variable):
        areas(axes, coordinates, variable.values, words, name, style)
    elif len(paths) == 1:
        axes.plot(coordinates[0], variable.values, color=COLORS["stable"])
        axes.set_ylabel(wrapped(axes, style.axis(name), upright=True))
    else:
        axes.set_title(wrapped(axes, style.axis(name)), loc="left", fontsize="medium")
        numbers(axes, coordinates, variable.values, style.colors.get(name, "cividis"))
    if len(paths) == 2:
        axes.set_ylabel(style.axis(paths[1]))
    else:
        axes.margins(x=0)
    if set(paths) == PLACES:
        axes.set_aspect("equal")
    if posture is not None:
        contacts(axes, grid, posture)


def areas(
    axes: Axes,
    coordinates: list[npt.NDArray[Any]],
    values: npt.NDArray[Any],
    words: list[str],
    name: str,
    style: Style,
) -> None:
    """Words or flags as areas, in the order of their legend. The legend is above the axes and has the description as its title."""
    if values.dtype == bool:
        values = np.where(values, "yes", "no")
    codes = np.zeros(values.shape)
    for code, word in enumerate(words):
        codes[values == word] = code
    if len(coordinates) == 1:
        coordinates = [*coordinates, np.array([0.0, 1.0])]
        codes = np.column_stack([codes, codes])
        axes.set_yticks([])
    axes.pcolormesh(
        *coordinates,
        codes.T,
        shading="nearest",
        cmap=ListedColormap([style.colors[word] for word in words]),
        vmin=-0.5,
        vmax=len(words) - 0.5,
        rasterized=True,
    )
    handles = [
        Patch(
            facecolor=style.colors[word],
            edgecolor="0.3",
            label=f"{style.text(word)}  {percent((values == word).mean())}",
        )
        for word in words
    ]
    axes.legend(
        handles=handles,
        title=wrapped(axes, style.text(name)),
        title_fontsize="medium",
        fontsize="medium",
        alignment="left",
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.0,
        borderpad=0.3,
        labelspacing=0.25,
        frameon=False,
    )


def wrapped(axes: Axes, text: str, upright: bool = False) -> str:
    """A text in lines that are not wider than the axes, or than they are high."""
    box = axes.get_window_extent()
    width = 72.0 * (box.height if upright else box.width) / axes.figure.dpi
    return fill(text, max(1, int(width / (CHARACTER * rcParams["font.size"]))))


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
    colors: Any,
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
        cmap=colors,
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
    axes.figure.colorbar(image, cax=axes.inset_axes(SCALE), extend=extend)
    if (
        min(values.shape) > 1
        and known.size
        and known.min() < 0.0 < known.max()
        and np.isfinite(values).all()
    ):
        lines = axes.contour(
            *coordinates, finite.T, levels=[0.0], colors="white", linewidths=1.0
        )
        lines.set_path_effects([Stroke(linewidth=2.5, foreground="black"), Normal()])


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
