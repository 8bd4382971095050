"""The panels and the texts of a figure."""

from itertools import combinations

from matplotlib.axes import Axes
from matplotlib.text import Text


def visible_texts(figure):
    """Every visible text. Labels of ticks outside of the view are not visible."""
    hidden = set()
    for axes in figure.findobj(Axes):
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            for tick in axis.get_major_ticks() + axis.get_minor_ticks():
                if not low <= tick.get_loc() <= high:
                    hidden |= {tick.label1, tick.label2}
    for text in figure.findobj(Text):
        if text.get_visible() and text.get_text() and text not in hidden:
            yield text


def body_panel(figure):
    (axes,) = [axes for axes in figure.axes if axes.get_aspect() == 1.0]
    return axes


def gaps_panel(figure):
    """The gaps over time."""
    (axes,) = [
        axes
        for axes in figure.axes
        if axes.get_ylabel() == "gap / m" and axes.get_xscale() == "linear"
    ]
    return axes


def approach_panels(figure):
    """The gaps against the time left: one panel or none."""
    return [axes for axes in figure.axes if axes.get_xscale() == "log"]


def inside_and_apart(figure):
    """No text leaves the figure or covers another one."""
    figure.draw_without_rendering()
    boxes = [(t.get_text(), t.get_window_extent()) for t in visible_texts(figure)]
    for text, box in boxes:
        assert figure.bbox.x0 <= box.x0, text
        assert box.x1 <= figure.bbox.x1, text
        assert figure.bbox.y0 <= box.y0, text
        assert box.y1 <= figure.bbox.y1, text
    for (one, box), (other, second) in combinations(boxes, 2):
        assert not box.padded(-1.0).overlaps(second.padded(-1.0)), (one, other)
