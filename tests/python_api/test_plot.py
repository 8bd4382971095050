"""Pictures of runs, checked by the objects drawn."""

import math
from itertools import combinations
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import standfast as sf
from drawn import visible_texts
from matplotlib.figure import Figure
from plastic_scenes import local

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
    axes = run.plot().axes[0]
    first, second = curves(axes)
    for index, line in enumerate((first, second)):
        t, gap = line.get_data()
        assert (t[0], t[-1]) == (0.0, run.time)
        np.testing.assert_array_equal(gap, run.gaps_at(t)[:, index])
    assert first.get_color() != second.get_color()
    assert first.get_linestyle() != second.get_linestyle()


def test_impacts_are_marked_where_they_happen():
    run = rod()
    found = marks(run.plot().axes[0])
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
    axes = run.plot().axes[0]
    lines = [x.get_xdata()[:1] for x in axes.lines if x.get_linestyle() == ":"]
    for drawn in ([line.get_xdata() for line in marks(axes)], lines):
        times = np.sort(np.concatenate(drawn))
        assert len(times) > 0
        assert (np.diff(times) > 0.01 * run.elapsed).all()
    assert len(marks(axes)) == len(set(run.impacts["index"]))
    for index, line in enumerate(marks(axes)):
        shown, count = len(line.get_xdata()), (run.impacts["index"] == index).sum()
        counts = f"{count} simulated" + (f", {shown} shown" if shown < count else "")
        assert f"impact on {index + 1} ({counts})" in legend(axes)


def test_many_zeno_points_are_counted():
    run = sf.load(EXAMPLES / "rocking_block.toml").simulate()
    axes = run.plot().axes[0]
    lines = [line for line in axes.lines if line.get_linestyle() == ":"]
    count = sum(point.method != "rest" for point in run.zeno_points)
    assert len(lines) < 10 < count
    assert f"Zeno point ({count} found, {len(lines)} shown)" in legend(axes)


def test_zeno_points_are_marked():
    run = rod()
    (line,) = (line for line in run.plot().axes[0].lines if line.get_linestyle() == ":")
    assert list(line.get_xdata()) == [run.zeno_points[0].time] * 2
    assert "0.047784807064 s" in run.plot().axes[0].get_title(loc="left")


def test_approach_is_logarithmic_and_runs_to_the_right():
    run = rod()
    axes = run.plot().axes[1]
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
    shown = np.concatenate([line.get_xdata() for line in marks(run.plot().axes[1])])
    left = np.sort(shown)[::-1]
    assert len(left) == len(run.impacts)
    assert left[-1] / left[-2] == pytest.approx(ratio, rel=1e-2)


def test_body_stands_on_its_contacts_in_the_end():
    run = rod()
    axes = run.plot().axes[2]
    assert axes.get_aspect() == 1.0
    assert "Contacts and centre of mass" in axes.get_title(loc="left")
    corners = sorted(
        (float(x), float(y))
        for line in marks(axes)
        for x, y in [line.get_xydata()[0]]
        if line.get_marker() != "+"
    )
    np.testing.assert_allclose(corners, [(-0.5, 0.0), (0.5, 0.0)], atol=1e-15)
    assert len(axes.get_legend().get_texts()) == 2


def test_a_local_model_has_no_body():
    assert len(local().plot().axes) == 2


def test_a_run_without_impacts_has_no_approach():
    resting = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    run = sf.simulate(resting, q=(0, 0, 0), qdot=(0, 0, 0))
    assert run.outcome == "rest"
    assert len(run.plot().axes) == 2


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
def test_no_text_overlaps(name):
    figure = sf.load(EXAMPLES / name).simulate().plot()
    figure.draw_without_rendering()
    boxes = [
        (text.get_text(), text.get_window_extent()) for text in visible_texts(figure)
    ]
    inside = figure.bbox
    for text, box in boxes:
        assert inside.x0 <= box.x0, text
        assert box.x1 <= inside.x1, text
    for (one, box), (other, second) in combinations(boxes, 2):
        assert not box.padded(-1.0).overlaps(second.padded(-1.0)), (one, other)


@pytest.mark.parametrize("name", SCENES)
def test_into_given_axes(name):
    """In one column of a paper: 3.4 inches."""
    run = sf.load(EXAMPLES / name).simulate()
    figure = Figure(figsize=(3.4, 2.8), layout="constrained")
    axes = figure.subplots()
    assert run.plot(ax=axes) is axes
    assert figure.axes == [axes]
    whole = run.plot().axes[0]
    for mine, other in zip(curves(axes), curves(whole), strict=True):
        np.testing.assert_array_equal(mine.get_xydata(), other.get_xydata())
    assert axes.get_title(loc="left") == ""
    figure.draw_without_rendering()
    boxes = [(t.get_text(), t.get_window_extent()) for t in visible_texts(figure)]
    for text, box in boxes:
        assert figure.bbox.x0 <= box.x0, text
        assert box.x1 <= figure.bbox.x1, text
    for (one, box), (other, second) in combinations(boxes, 2):
        assert not box.padded(-1.0).overlaps(second.padded(-1.0)), (one, other)
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
    legend = figure.axes[0].get_legend()
    assert len(legend.get_texts()) == 14
    assert legend.get_title().get_text().startswith("the first 14 of ")
