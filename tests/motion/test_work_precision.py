"""The scenes of the work-precision chart: the results of standfast are exact up to rounding."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

FOLDER = Path(__file__).parents[2] / "benches" / "work_precision"
sys.path.insert(0, str(FOLDER / "peers"))

import standfast_run  # noqa: E402

SCENES = json.loads((FOLDER / "scenes.json").read_text())["scenes"]
#: Allowed relative error: some rounding errors of states and times.
ROUNDINGS = 16 * np.finfo(float).eps


@pytest.mark.parametrize("name", SCENES)
def test_the_chart_compares_with_the_truth(name):
    scene = SCENES[name]
    body, q, v = standfast_run.posture(name, scene)
    options = {"model": "full"}
    if scene["body"].get("rocks"):
        options |= {"impact": "moreau", "simultaneous": "first-contact-first"}
    run = sf.simulate(body, q, v, **options)
    assert run.outcome == "rest"
    assert run.time == pytest.approx(float(scene["rest"]["time"]), rel=ROUNDINGS)
    end = np.add(run.q[:2], body.center_of_mass)
    exact = [float(x) for x in scene["rest"]["q"][:2]]
    assert end == pytest.approx(exact, abs=ROUNDINGS)
    if "before" in scene:
        at = sf.simulate(body, q, v, time_limit=scene["before"]["time"], **options).q
        found = (
            np.add(at[:2], body.center_of_mass) if name == "block" else body.gaps(at)
        )
        exact = [float(x) for x in scene["before"]["values"]]
        assert found == pytest.approx(exact, rel=1e3 * ROUNDINGS, abs=ROUNDINGS)
