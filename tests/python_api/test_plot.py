"""Pictures of runs, checked by the objects drawn."""

import math
from itertools import combinations
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import standfast as sf
from drawn import approach_panels, body_panel, gaps_panel, inside_and_apart
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from plastic_scenes import local
from standfast import plot
from standfast.table import is_infinite

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = sorted(path.name for path in EXAMPLES.glob("*.toml"))


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def rod():
    return sf.load(EXAMPLES / "clattering_rod.toml").simulate()


def curves(axes):
    """The lines of the contacts, without markers and vertical lines."""
    return [line for line in axes.lines if line.get_linestyle() not in ("None", ":")]


def marks(axes):
    return [line for line in axes.lines if line.get_linestyle() == "None"]


def test_gaps_over_time():
    run = rod()
    axes = gaps_panel(run.plot())
    first, second = curves(axes)
    for index, line in enumerate((first, second)):
        t, gap = line.get_data()
        assert (t[0], t[-1]) == (0.0, run.time)
        np.testing.assert_array_equal(gap, run.gaps_at(t)[:, index])
    assert first.get_color() != second.get_color()
    assert first.get_linestyle() != second.get_linestyle()


def test_impacts_are_marked_where_they_happen():
    run = rod()
    found = marks(gaps_panel(run.plot()))
    assert len({line.get_marker() for line in found}) == 2
    for index, line in enumerate(found):
        times = run.impacts["time"][run.impacts["index"] == index]
        assert set(line.get_xdata()) <= set(times)
        np.testing.assert_array_equal(line.get_ydata(), 0.0)


def legend(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


@pytest.mark.parametrize("name", SCENES)
def test_marks_over_time_stand_apart(name):
    run = sf.load(EXAMPLES / name).simulate()
    axes = gaps_panel(run.plot())
    lines = [x.get_xdata()[:1] for x in axes.lines if x.get_linestyle() == ":"]
    for drawn in ([line.get_xdata() for line in marks(axes)], lines):
        times = np.sort(np.concatenate(drawn))
        assert len(times) > 0
        assert (np.diff(times) > 0.01 * run.elapsed).all()
    assert len(marks(axes)) == len(set(run.impacts["index"]))
    infinite = filter(is_infinite, run.zeno_points)
    summed = {number for point in infinite for number in point.contacts}
    for contact in set(run.impacts["contact"]):
        many = (run.impacts["contact"] == contact).sum() > 1 or contact in summed
        assert f"contact {contact}, impact{'s' if many else ''}" in legend(axes)


def test_of_many_zeno_points_those_that_can_be_told_apart_are_marked():
    run = sf.load(EXAMPLES / "rocking_block.toml").simulate()
    axes = gaps_panel(run.plot())
    lines = [line for line in axes.lines if line.get_linestyle() == ":"]
    count = sum(point.method != "rest" for point in run.zeno_points)
    assert len(lines) < 10 < count
    assert "Zeno points" in legend(axes)


def test_zeno_points_are_marked():
    run = rod()
    figure = run.plot()
    lines = gaps_panel(figure).lines
    (line,) = (line for line in lines if line.get_linestyle() == ":")
    assert list(line.get_xdata()) == [run.zeno_points[0].time] * 2
    assert "0.047784807064 s" in figure.axes[0].get_title(loc="left")


def test_approach_is_logarithmic_and_runs_to_the_right():
    run = rod()
    (axes,) = approach_panels(run.plot())
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    left, right = axes.get_xlim()
    assert left == run.zeno_points[0].elapsed
    assert 0.0 < right < 1e-6 * left
    for index, line in enumerate(curves(axes)):
        rest, height = line.get_data()
        gaps = run.gaps_at(run.time - rest)[:, index]
        shown = height > axes.get_ylim()[0]
        np.testing.assert_array_equal(height[shown], gaps[shown])


def test_impacts_are_evenly_spaced_in_the_end():
    """Without gravity the remaining time shrinks by e/λ₊² from impact to impact."""
    run = rod()
    e, psi = 0.1, run.posture.psi[0]
    product = (1 + e) * psi
    ratio = e / (0.5 * (product + math.sqrt(product**2 - 4 * e))) ** 2
    (axes,) = approach_panels(run.plot())
    shown = np.concatenate([line.get_xdata() for line in marks(axes)])
    left = np.sort(shown)[::-1]
    assert len(left) == len(run.impacts)
    assert left[-1] / left[-2] == pytest.approx(ratio, rel=1e-2)


def test_body_stands_on_its_contacts_in_the_end():
    run = rod()
    axes = body_panel(run.plot())
    corners = sorted(
        (float(x), float(y))
        for line in marks(axes)
        for x, y in [line.get_xydata()[0]]
        if line.get_marker() != "+"
    )
    np.testing.assert_allclose(corners, [(-0.5, 0.0), (0.5, 0.0)], atol=1e-15)
    texts = [text.get_text() for text in axes.texts]
    assert sorted(texts) == ["0 s", "0.0478 s", "1", "2"]


def panels(run):
    """What the panels of the figure of a run show, from top to bottom."""
    figure = run.plot()
    heights = [axes.get_subplotspec().rowspan.start for axes in figure.axes]
    assert heights == list(range(len(heights)))
    return [
        "body"
        if axes.get_aspect() == 1.0
        else "approach"
        if axes.get_xscale() == "log"
        else axes.get_ylabel().split()[0]
        for axes in figure.axes
    ]


def box(q=(0, 0, 0), qdot=(0, 0, 0), friction=0.5, **options):
    posture = sf.Posture.box(0.3, 0.5, friction=friction, restitution=0.3)
    return sf.simulate(posture, q, qdot, impact="moreau", **options)


def test_panels():
    """Each panel is there only where the run has something to show in it."""
    assert panels(rod()) == ["body", "gap", "approach"]
    assert panels(local()) == ["gap", "approach"]  # a local model has no body
    assert panels(box()) == ["body", "gap"]  # at rest from the start
    assert panels(box((0, 1, 0), time_limit=0.2)) == ["body", "gap"]  # a fall
    spinning = box((0, 1, 0), (0, 0, 1), time_limit=0.2)
    assert panels(spinning) == ["body", "gap", "θ"]
    sliding = box((0, 0, 0), (1, 0, 0))
    assert panels(sliding) == ["body", "gap", "force"]
    thrown = box((0, 0.6, 0.4), (1.5, 0.5, -3))
    assert panels(thrown) == ["body", "gap", "θ", "force"]
    shake = sf.GroundMotion([0.1, 0.4, 0.6], [(9, 0), (-9, 0), (0, 0)])
    slides = box(ground_motion=shake, time_limit=2)
    assert panels(slides) == ["body", "gap", "force", "ground"]
    shaken = box(ground_motion=shake, friction=0.9, time_limit=2)
    assert panels(shaken) == ["body", "gap", "θ", "force", "ground"]


def test_the_body_is_the_largest_panel():
    for run in (rod(), box((0, 0.6, 0.4), (1.5, 0.5, -3))):
        figure = run.plot()
        figure.draw_without_rendering()
        boxes = [axes.get_tightbbox() for axes in figure.axes]
        assert max(boxes, key=lambda box: box.height) is boxes[0]


def test_poses_are_few_and_apart():
    run = box((0, 0.6, 0.4), (1.5, 0.5, -3))
    axes = body_panel(run.plot())
    centers = [x.get_xydata()[0] for x in axes.lines if x.get_marker() == "+"]
    assert 4 <= len(centers) <= 7
    posture = run.posture
    for index, q in ((0, (0, 0.6)), (-1, run.q[:2])):
        np.testing.assert_allclose(centers[index], q + np.array([0, 0.25]), atol=1e-12)
    assert all(np.hypot(*(a - b)) > 0.1 for a, b in combinations(centers, 2))
    # The first impact is among the instants, and the body touches the ground then.
    first = run.impacts["time"][0]
    assert f"{first:.3g} s" in [text.get_text() for text in axes.texts]
    place = run.at(first)[0][:2] + posture.center_of_mass
    assert min(np.hypot(*(center - place)) for center in centers) < 1e-12


def test_forces_are_those_of_the_run():
    run = box((0, 0, 0), (1, 0, 0))
    (axes,) = [a for a in run.plot().axes if a.get_ylabel() == "force / N"]
    normal, tangential = axes.lines[0], axes.lines[1]
    for line, part in ((normal, 1), (tangential, 0)):
        times, values = line.get_data()
        known = np.isfinite(values)
        assert known.sum() > 5
        forces = run.forces_at(times[known])[:, 0, part]
        np.testing.assert_array_equal(values[known], forces)


def test_kicks_are_marked():
    kick = sf.Kick(0.1, (0.8, 0), (0, 0.5))
    figure = box(kicks=[kick, sf.Kick(0.3, (0, 0.4))], time_limit=1).plot()
    for axes in figure.axes[1:]:
        marked = [x.get_xdata()[0] for x in axes.lines if x.get_color() == plot.KICK]
        assert marked == [0.1, 0.3]
    assert "kicks" in legend(gaps_panel(figure))
    texts = body_panel(figure).texts
    first, second = [text for text in texts if isinstance(text, Annotation)]
    tail, head = np.array(first.xyann), np.array(first.xy)
    np.testing.assert_allclose(head, (0, 0.5), atol=1e-12)
    assert (head - tail)[1] == pytest.approx(0.0, abs=1e-12)
    assert (head - tail)[0] > 0.1
    length = np.subtract(second.xy, second.xyann)
    np.testing.assert_allclose(length, (0, 0.5 * (head - tail)[0]), atol=1e-12)


def test_the_motion_of_the_ground_is_drawn():
    run = box(ground_motion=sf.GroundMotion([0.2, 1.0], tilt=[0.3, 0.0]))
    figure = run.plot()
    (axes,) = [a for a in figure.axes if a.get_ylabel() == "ground / rad"]
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_xdata()[:3], [0.0, 0.2, 1.0])
    np.testing.assert_array_equal(line.get_ydata()[:3], [0.0, 0.3, 0.0])
    assert "relative to the ground" in body_panel(figure).get_xlabel()


def test_several_accumulations_have_no_panel_of_their_own():
    run = sf.load(EXAMPLES / "rocking_block.toml").simulate()
    assert "approach" not in panels(run)


@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_files(tmp_path, suffix):
    path = tmp_path / f"run.{suffix}"
    rod().plot(path)
    begin = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[suffix]
    assert path.read_bytes().startswith(begin)


def test_a_run_without_record_cannot_be_drawn():
    run = sf.load(EXAMPLES / "clattering_rod.toml").simulate(record=False)
    with pytest.raises(ValueError, match="record"):
        run.plot()


@pytest.mark.parametrize("name", SCENES)
def test_no_text_overlaps_in_examples(name):
    inside_and_apart(sf.load(EXAMPLES / name).simulate().plot())


def test_no_text_overlaps():
    kick = sf.Kick(0.1, (1.2, 0), (0, 0.5))
    shake = sf.GroundMotion([0.1, 0.4, 0.6], [(9, 0), (-9, 0), (0, 0)])
    for run in (
        box((0, 0.6, 0.4), (1.5, 0.5, -3)),
        box(),
        box(kicks=[kick]),
        box(ground_motion=shake, friction=0.9, time_limit=2),
        box((0, 3, 0.4), (9, 1, -3), time=1000.0, time_limit=1003.0),
    ):
        inside_and_apart(run.plot())


@pytest.mark.parametrize("layout", ["constrained", None])
@pytest.mark.parametrize("name", SCENES)
def test_into_given_axes(name, layout):
    """In one column of a paper: 3.4 inches. Axes that the caller has not arranged are arranged."""
    run = sf.load(EXAMPLES / name).simulate()
    figure = Figure(figsize=(3.4, 2.6), layout=layout)
    axes = figure.subplots()
    assert run.plot(ax=axes) is axes
    assert figure.axes == [axes]
    whole = gaps_panel(run.plot())
    for mine, other in zip(curves(axes), curves(whole), strict=True):
        np.testing.assert_array_equal(mine.get_xydata(), other.get_xydata())
    assert axes.get_title(loc="left") == ""
    inside_and_apart(figure)
    # Marks stand apart by more than their width, 7 points.
    wide = 72.0 * axes.get_window_extent().width / figure.dpi
    scale = wide / np.diff(axes.get_xlim())[0]
    for line in marks(axes):
        assert (np.diff(line.get_xdata()) * scale > 7.0).all()


def test_no_figure_is_left_open():
    """A figure that pyplot knows would be shown twice in a notebook."""
    figure = rod().plot()
    assert plt.get_fignums() == []
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_wrong_axes(tmp_path):
    axes = Figure().subplots()
    with pytest.raises(TypeError, match="ax = 3 cannot be used: None or matplotlib ax"):
        rod().plot(ax=3)
    with pytest.raises(ValueError, match=r"path = .*run\.png.*None is allowed with ax"):
        rod().plot(tmp_path / "run.png", ax=axes)
    assert not list(tmp_path.iterdir())


def test_a_legend_of_many_contacts_is_cut(tmp_path):
    feet = [sf.Contact((x / 10, 0.0)) for x in range(-24, 24)]
    posture = sf.Posture(
        mass=1, gyration_radius=2, center_of_mass=(0, 1), contacts=feet, restitution=0
    )
    run = sf.simulate(posture, (0, 0.1, 0.01), (0, 0, 0), event_limit=100)
    figure = run.plot(tmp_path / "run.png")  # without a warning of matplotlib
    legend = gaps_panel(figure).get_legend()
    assert len(legend.get_texts()) == 12
    assert legend.get_title().get_text().startswith("the first 12 of ")


def test_an_arrangement_of_the_caller_is_kept():
    figure = Figure(figsize=(3.4, 2.6))
    axes = figure.subplots()
    figure.subplots_adjust(left=0.3)
    rod().plot(ax=axes)
    assert figure.get_layout_engine() is None
    assert axes.get_position().x0 == pytest.approx(0.3)
