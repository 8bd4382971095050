"""The scenes of the work-precision chart: the results of standfast are exact up to rounding. Its page is made from its points."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

FOLDER = Path(__file__).parents[2] / "benches" / "work_precision"
DOCS = Path(__file__).parents[2] / "docs"
sys.path[:0] = [str(FOLDER), str(FOLDER / "peers")]

import chart  # noqa: E402
import standfast_run  # noqa: E402

SCENES = json.loads((FOLDER / "scenes.json").read_text())["scenes"]
#: Allowed relative error: some rounding errors of states and times.
ROUNDINGS = 16 * np.finfo(float).eps


@pytest.mark.parametrize("name", SCENES)
def test_the_chart_compares_with_the_truth(name):
    scene = SCENES[name]
    body, q, v = standfast_run.posture(name, scene)
    options = {"model": "full"} | standfast_run.options(scene)
    if "rest" in scene:
        run = sf.simulate(body, q, v, **options)
        assert run.outcome == "rest"
        assert run.time == pytest.approx(float(scene["rest"]["time"]), rel=ROUNDINGS)
        end = np.add(run.q[:2], body.center_of_mass)
        exact = [float(x) for x in scene["rest"]["q"][:2]]
        assert end == pytest.approx(exact, abs=ROUNDINGS)
    if "before" in scene:
        limit = scene["before"]["time"]
        run = sf.simulate(body, q, v, time_limit=limit, **options)
        assert run.outcome == "time-limit"
        found = standfast_run.watched(name, scene, body, run.q)
        exact = [float(x) for x in scene["before"]["values"]]
        assert found == pytest.approx(exact, rel=1e3 * ROUNDINGS, abs=ROUNDINGS)


def test_the_laws_of_a_thrown_box_differ():
    """Engines without Poisson's law are compared with the answer by Moreau's law, to which standfast comes with this law."""
    scene = SCENES["thrown"]
    body, q, v = standfast_run.posture("thrown", scene)
    limit = scene["before"]["time"]
    end = sf.simulate(body, q, v, impact="moreau", time_limit=limit).q
    found = standfast_run.watched("thrown", scene, body, end)
    by_moreau, by_poisson = (
        np.array(scene["before"][law], dtype=float) for law in ("moreau", "values")
    )
    assert found == pytest.approx(by_moreau, rel=1e3 * ROUNDINGS)
    assert np.abs(by_moreau - by_poisson).max() > 0.01


def test_the_page_is_that_of_its_points(tmp_path):
    """`chart.py --draw` makes the page from the file of points, and the file can be written again from what is read."""
    points = DOCS / "work_precision.csv"
    found = chart.read(points)
    assert {p["family"] for p in found} == set(chart.TOOLS)
    chart.table(SCENES, found, tmp_path)
    page = (DOCS / "work_precision.md").read_text(encoding="utf-8")
    assert (tmp_path / "work_precision.md").read_text(encoding="utf-8") == page
    chart.write(found, tmp_path / "points.csv")
    assert chart.read(tmp_path / "points.csv") == found
    for name, _ in chart.SHOWN:
        assert (DOCS / chart.picture(name)).is_file()
