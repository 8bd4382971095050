"""Scene files of assemblies, and the commands that read them."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import standfast as sf
from standfast.cli import main

STACK = Path(__file__).parents[2] / "examples" / "mechanisms" / "stack.toml"

#: Bodies in each form, a line of ground with a wall, and a contact that is found at each.
FORMS = """
friction = 0.4
gravity = 10
restitution = 0.1
ground = [[-3, 0], [2, 0], [2, 3]]

[[body]]
name = "wedge"
polygon = { vertices = [[0, 0], [2, 0], [0, 1]], density = 3 }
friction = 0.7

[[body]]
block = { width = 1, height = 2, at = [-2, 0] }

[[body]]
name = "any"
mass = 2.5
gyration_radius = 0.3
center_of_mass = [-2, 2.5]
outline = [[-2.5, 2], [-1.5, 2], [-2, 3]]
"""

#: A block between two walls that are given by hand.
BETWEEN = """
ground = "none"
[[body]]
name = "block"
block = { width = 1, height = 1 }
[[contact]]
body = "block"
point = [-0.5, 0.5]
slope = -1.5707963267948966
friction = 0.8
[[contact]]
body = "block"
point = [0.5, 0.5]
slope = 1.5707963267948966
friction = 0.8
"""


def written(tmp_path, text, name="scene.toml"):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_every_form_of_a_body(tmp_path):
    system = sf.MechanismScene.load(written(tmp_path, FORMS)).system
    assert list(system.bodies) == ["wedge", "2", "any"]
    assert system == sf.System(
        {
            "wedge": sf.Rigid.polygon(
                [(0, 0), (2, 0), (0, 1)], density=3, friction=0.7
            ),
            "2": sf.Block(1, 2, at=(-2, 0)),
            "any": sf.Rigid(2.5, 0.3, (-2, 2.5), [(-2.5, 2), (-1.5, 2), (-2, 3)]),
        },
        friction=0.4,
        gravity=10,
        restitution=0.1,
        ground=[(-3, 0), (2, 0), (2, 3)],
    )
    assert sum(contact.friction == 0.7 for contact in system.contacts) == 2


@pytest.mark.parametrize("text", [FORMS, BETWEEN], ids=["forms", "between"])
def test_a_scene_is_read_as_it_was_written(text, tmp_path):
    scene = sf.MechanismScene.load(written(tmp_path, text))
    assert scene.q.tolist() == [0.0] * 3 * len(scene.system.bodies)
    for name in ("again.toml", "again.json"):
        scene.save(tmp_path / name)
        assert sf.MechanismScene.load(tmp_path / name) == scene
    assert sf.MechanismScene.from_json(scene.to_json()) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene
    made = sf.MechanismScene(scene.system, scene.q, scene.qdot, scene.options)
    assert made == scene
    assert made.mechanism == scene.system.mechanism


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (FORMS, "mass = 2.5", "mass = -1", r"line 17, column 8: body\.3\.mass = -1\.0 is"),
        (FORMS, "width = 1", "width = 0", r"body\.2\.block\.width = 0\.0 is"),
        (FORMS, "density = 3", "density = nan", r"body\.1\.polygon\.density = NaN"),
        (FORMS, "gravity = 10", "gravity = -1", r"line 3, column 11: gravity = -1\.0"),
        (FORMS, "mass = 2.5", "block = { width = 1, height = 1 }", r"body\.3\.block = .*either block, or polygon"),
        (FORMS, "mass = 2.5", "weight = 2.5", "unknown field `weight`"),
        (FORMS, "at = [-2, 0]", "at = [-2, 0.0, 1]", "invalid length 3"),
        (FORMS, "[2, 0], [0, 1]]", "[2, 0], [0, 1, 5]]", "invalid length 3"),
        (FORMS, "[2, 0], [2, 3]]", "[2, 0], [2, 3, 4]]", "a height, the points of a line, or"),
        (FORMS, "at = [-2, 0]", "at = [1, 0]", r'"2" overlaps "wedge"'),
        (FORMS, 'name = "any"', 'name = "wedge"', '"wedge" twice'),
        (FORMS, "[[-3, 0], [2, 0], [2, 3]]", '"level"', "a height, the points of a line, or"),
        (BETWEEN, '[[contact]]\nbody = "block"', '[[contact]]\nbody = "brick"', r'contact\.1\.body = "brick" cannot be used: a body of the system: block'),
        (BETWEEN, "friction = 0.8", "friction = -0.8", r"contact\.1\.friction = -0\.8"),
        (BETWEEN, "[[contact]]", "[start]\nq = [1]\n[[contact]]", r"start\.q = \[1\.0\].*3 coordinates"),
        (BETWEEN, "[[contact]]", "[run]\ntime = inf\n[[contact]]", r"run\.time = inf"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(text, old, new, message, tmp_path):
    assert old in text
    path = written(tmp_path, text.replace(old, new, 1))
    with pytest.raises(ValueError, match=message):
        sf.MechanismScene.load(path)


def test_a_scene_of_an_assembly_is_none_of_a_body():
    with pytest.raises(ValueError, match="of a body, and this is one of an assembly"):
        sf.load(STACK)


def test_a_stack_dropped_by_a_millimetre_comes_to_rest(capsys):
    scene = sf.MechanismScene.load(STACK)
    assert scene.q.reshape(3, 3)[:, 1].tolist() == [0.001, 0.001, 0.002]
    run = scene.simulate()
    assert run.outcome == "rest"
    # The beam falls by a millimetre more than the bricks under it: √(2h/g).
    assert run.time == pytest.approx((2 * 0.002 / 9.81) ** 0.5, abs=1e-15)
    assert np.abs(run.q).max() < 1e-15
    assert main(["run", str(STACK)]) == 0
    assert "outcome     rest" in capsys.readouterr().out
    assert main(["stability", str(STACK)]) == 0
    assert "stable, by potential-well" in capsys.readouterr().out


def test_the_modes_of_a_stack_by_the_names_of_its_bodies(capsys, tmp_path):
    assert main(["modes", str(STACK)]) == 0
    out = capsys.readouterr().out
    assert "status  found: FFFFFFFF" in out
    assert "begins so" not in out  # it holds
    over = STACK.read_text().replace("at = [0.4, 0.5]", "at = [-0.3, 0.5]")
    over = over.replace("width = 1.5", "width = 0.9")
    assert main(["modes", str(written(tmp_path, over))]) == 0
    out = capsys.readouterr().out
    assert "opens         beam on left at (0.15, 0.5)" in out


def test_one_mode_of_a_large_assembly(capsys, tmp_path):
    bricks = "\n".join(
        f'[[body]]\nname = "brick {k}"\nblock = {{ width = 1, height = 0.1, at = [{k * 0.06}, {k / 10}] }}'
        for k in range(60)
    )
    path = written(tmp_path, bricks)
    assert main(["modes", str(path)]) == 0
    out = capsys.readouterr().out
    assert "the system begins to move" in out
    system = sf.MechanismScene.load(path).system
    assert str(sf.onset(system)) in out
    assert main(["modes", str(path), "--json", str(tmp_path / "modes.json")]) == 2
    assert "at most 64 contacts" in capsys.readouterr().err
    for command in ("run", "stability"):
        assert main([command, str(path)]) == 2
        assert "1 to 64 contacts for this question" in capsys.readouterr().err
