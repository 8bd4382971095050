"""Runs in files."""

import json

import numpy as np
import pytest
import standfast as sf

ROD = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
START = ((0, 0.011, 0.002), (0, 0, 0))
ROOM = [(-5, 3), (-5, 0), (5, 0), (5, 3)]


def runs():
    yield sf.simulate(ROD, *START)
    yield sf.simulate(ROD, *START, model="full", certify=True)
    yield sf.simulate(ROD, *START, kicks=[sf.Kick(0.02, (0, 0.3), (0.1, 0))])
    yield sf.simulate(ROD, *START, ground_motion=sf.GroundMotion([0], tilt=[0.01]))
    box = sf.Posture.box(1, 2, friction=0.5, restitution=0.3, terrain=ROOM)
    yield sf.simulate(box, (0, 1, 0.3), (3, 0, 1), impact="poisson")
    yield sf.simulate(box, (0, 1, 0.3), (3, 0, 1), impact="moreau", record=False)
    model = sf.LocalModel(gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.1)
    yield model.simulate((0.1, 0.2), (0, 0))
    rng = np.random.default_rng(1)
    for _ in range(40):
        q = (0, *(rng.uniform(0.01, 0.3, 2) * (1, 0.05)))
        yield sf.simulate(ROD, q, rng.normal(size=3), time_limit=2.0)


def test_a_run_is_loaded_to_the_last_bit(tmp_path):
    for run in runs():
        run.save(tmp_path / "run.json")
        again = sf.Run.load(tmp_path / "run.json")
        assert again.to_dict() == run.to_dict()
        assert (again.time, again.kicks) == (run.time, run.kicks)


@pytest.mark.parametrize(
    ("path", "value", "text"),
    [
        (
            ["impacts", 0, "time"],
            0.1,
            r"impacts\.1\.time = 0\.1 cannot be used: the run",
        ),
        (["elapsed"], 1.0, r"elapsed = 1\.0"),
        (["outcome"], "zeno", "outcome"),
        (["posture", "mass"], -1.0, "mass"),
        (["collisions"], 3, "collisions = 3"),
    ],
)
def test_a_file_that_does_not_match_is_refused(tmp_path, path, value, text):
    file = tmp_path / "run.json"
    sf.simulate(ROD, *START).save(file)
    data = json.loads(file.read_text(encoding="utf-8"))
    place = data
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    file.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(ValueError, match=text):
        sf.Run.load(file)


def test_a_file_without_a_run(tmp_path):
    with pytest.raises(FileNotFoundError):
        sf.Run.load(tmp_path / "none.json")
    with pytest.raises(ValueError, match="is a directory, not a file of a run"):
        sf.Run.load(tmp_path)
    scene = tmp_path / "scene.json"
    sf.Scene(ROD, *START).save(scene)
    with pytest.raises(ValueError, match="holds no run"):
        sf.Run.load(scene)


def test_a_key_given_twice_is_refused_by_name(tmp_path):
    """A reader may see one of the values, and the program take the other."""
    file = tmp_path / "run.json"
    sf.simulate(ROD, *START).save(file)
    text = file.read_text(encoding="utf-8")
    for key in ("outcome", "mass", "rates_after"):
        first = text.index(f'"{key}"')
        file.write_text(f'{text[:first]}"{key}": 0, {text[first:]}', encoding="utf-8")
        with pytest.raises(ValueError, match=f"duplicate key `{key}`"):
            sf.Run.load(file)
