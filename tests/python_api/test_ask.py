"""Questions and answers as JSON: the answers are those of the functions of the package."""

import json
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

EXAMPLES = sorted(Path(__file__).parents[2].glob("examples/*.toml"))


def ask(**question):
    return json.loads(sf.ask(json.dumps(question)))


def text(path):
    return path.read_text(encoding="utf-8")


@pytest.fixture(params=EXAMPLES, ids=[path.stem for path in EXAMPLES])
def scene(request):
    return request.param


def test_a_scene_comes_back_as_json_and_as_toml(scene, tmp_path):
    answer = ask(ask="scene", scene=text(scene))
    again = ask(ask="scene", scene=answer["scene"])
    assert answer == again == ask(ask="scene", scene=answer["toml"])
    (tmp_path / "scene.toml").write_text(answer["toml"], encoding="utf-8")
    loaded, original = sf.load(tmp_path / "scene.toml"), sf.load(scene)
    assert repr(loaded) == repr(original)


def test_the_posture_has_the_verdict_the_modes_and_the_region_of_the_package(scene):
    posture = sf.load(scene).posture
    answer = ask(ask="posture", scene=text(scene))
    region = sf.equilibrium_region(posture)
    found = answer["region"]
    assert (None if found is None else tuple(float(end) for end in found)) == region
    verdict = sf.stability(posture, jams=sf.load(scene).options["jams"])
    assert answer["verdict"]["in_words"] == verdict.in_words
    assert answer["verdict"]["reason"] == verdict.reason
    written = verdict.to_dict()
    assert {name: answer["verdict"][name] for name in written} == written
    modes = sf.contact_modes(posture)
    assert answer["modes"]["consistent"] == modes.consistent
    assert answer["modes"]["status"] == modes.status
    drawing = answer["drawing"]
    assert [tuple(p) for p in drawing["corners"]] == posture.drawn_corners
    ground = [
        (*map(tuple, (p["point"], p["direction"])), *map(float, p["ends"]))
        for p in drawing["ground"]
    ]
    assert ground == posture.drawn_ground


def test_a_film_shows_the_run(scene):
    film = ask(ask="motion", scene=text(scene), frames=200)
    run = sf.load(scene).simulate(record=True)
    assert (film["outcome"], film["end"]) == (run.outcome, run.time)
    assert film["phases"][0]["mode"] == run.phases[0].mode
    frames = film["frames"]
    t = np.array(frames["t"])
    assert t[0] == film["start"]
    assert t[-1] == run.time
    assert (np.diff(t) > 0).all()
    assert len(t) >= 100  # times that occur twice have one frame
    q, _ = run.at(t)
    assert (np.array(frames["q"]) == q).all()
    # The other columns are single precision.
    gaps = run.gaps_at(t).astype(np.float32)
    drawn = np.array(frames["gaps"], dtype=float).astype(np.float32)
    assert (drawn[np.isfinite(gaps)] == gaps[np.isfinite(gaps)]).all()
    forces = run.forces_at(t).astype(np.float32)
    drawn = np.array(frames["forces"], dtype=float).astype(np.float32)
    np.testing.assert_array_equal(drawn, forces)
    for impact in run.impacts["time"][:100]:
        assert impact in t
    # Zeno time is the other clock of a film.
    zeno = np.array(frames["zeno"])
    assert (np.diff(zeno) >= 0).all()
    whole = len(run.frame_times(fps=10.0, speed=1.0, clock="zeno")) - 1
    assert whole - 1 < 10 * zeno[-1] <= whole


def test_a_map_has_the_values_of_sweep():
    scene = text(EXAMPLES[1])
    posture = sf.load(EXAMPLES[1]).posture
    xs, ys = [-0.3, 0.0, 0.6], [0.0, 0.1]
    over = {"center_of_mass.x": xs, "center_of_mass.y": ys}
    names = ["by", "equilibrium", "equilibrium_margin"]
    answer = ask(
        ask="map",
        scene=scene,
        over=[{"path": path, "values": values} for path, values in over.items()],
        quantity=names,
    )
    by, holds, margin = answer["quantity"]
    grid = sf.sweep(posture, over, names)
    assert [q["name"] for q in answer["quantity"]] == names
    assert [by["words"][code] for code in by["codes"]] == list(
        grid["by"].values.ravel()
    )
    assert holds["values"] == list(grid["equilibrium"].values.ravel())
    assert margin["values"] == list(grid["equilibrium_margin"].values.ravel())


@pytest.mark.parametrize(
    ("question", "named"),
    [
        ("", "EOF"),
        ("[]", "ask"),
        ('{"ask": "weather"}', "weather"),
        ('{"ask": "scene"}', "scene"),
        ('{"ask": "scene", "scene": {}, "more": 1}', "more"),
        ('{"ask": "scene", "scene": 3}', "scene: invalid type"),
        ('{"ask": "scene", "scene": "gravity = -1"}', "line 1"),
        ('{"ask": "motion", "scene": {}, "frames": 1}', "frames = 1 is outside 2 to"),
        ('{"ask": "motion", "scene": {}, "frames": 1e9}', "floating point"),
    ],
)
def test_a_wrong_question_has_an_error_that_names_it(question, named):
    answer = json.loads(sf.ask(question))
    assert list(answer) == ["error"]
    assert named in answer["error"]


def test_a_wrong_scene_has_an_error_with_field_value_and_range():
    scene = ask(ask="scene", scene=text(EXAMPLES[0]))["scene"]
    scene["body"]["mass"] = -1.0
    for question in ("scene", "posture", "motion"):
        error = ask(ask=question, scene=scene)["error"]
        assert error.startswith("scene: body.mass = -1.0 is outside")


def test_a_map_has_a_largest_size():
    scene = ask(ask="scene", scene=text(EXAMPLES[1]))["scene"]
    over = [{"path": f"center_of_mass.{axis}", "values": [0] * 1001} for axis in "xy"]
    error = ask(ask="map", scene=scene, over=over, quantity=["by"])["error"]
    assert error == "over has [1001, 1001] values: at most 1000000 points"


def test_a_question_that_takes_too_long_is_stopped():
    slow = """
gravity = 9.81
restitution = 0.999
contact = [{point = [-0.5, 0.0], friction = 0.5}, {point = [0.5, 0.0], friction = 0.5}]
body = {mass = 1.0, gyration_radius = 0.2, center_of_mass = [0.0, 0.0]}
start = {q = [0.0, 1.0, 0.1], qdot = [0.0, 0.0, 1.0]}
run = {model = "full", impact = "moreau"}
"""
    question = json.dumps({"ask": "motion", "scene": slow, "frames": 100_000})
    assert json.loads(sf.ask(question, seconds=0.005)) == {"error": "stopped"}
    with pytest.raises(ValueError, match=r"^seconds = -1 cannot be used: a time > 0"):
        sf.ask(question, seconds=-1)
