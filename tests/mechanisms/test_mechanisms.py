"""Mechanisms through Python: verdicts, contact modes, runs, files, and wrong input."""

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
import standfast as sf
from standfast.cli import main
from standfast.report import account

ROD = sf.Posture.rod(
    half_length=0.5, gyration_radius=0.2, friction=0.5, restitution=0.3
)
START = (0, 0.01, 0.002), (0.0, 0.0, 0.0)
# A body on two feet with a joint whose coordinate moves the first foot, held by its torque.
JOINTED = {
    "mass_matrix": [[2, 0, 0, 0], [0, 2, 0, 0.2], [0, 0, 0.5, 0], [0, 0.2, 0, 0.3]],
    "load": [0, -20, 0, -10],
    "contacts": [
        sf.ContactRows([0, 1, -0.5, 1], [1, 0, 0, 0.2], friction=0.5),
        sf.ContactRows([0, 1, 0.5, 0], [1, 0, 0, 0], friction=0.5),
    ],
}


def jointed(**changes):
    return sf.Mechanism(**(JOINTED | changes))


@pytest.mark.parametrize("jams", ["none", "impact"])
def test_the_verdict_on_a_body_is_that_on_its_posture(jams):
    verdict = sf.stability(ROD, jams=jams)
    other = sf.stability(sf.Mechanism.of_posture(ROD), jams=jams)
    assert (other.posture, verdict.mechanism) == (None, None)
    assert other.mechanism == sf.Mechanism.of_posture(ROD)
    for name in (
        "frictional_stability",
        "by",
        "after_jam",
        "jams",
        "laws",
        "coupling",
        "flight",
    ):
        assert getattr(verdict, name) == getattr(other, name), name
    assert verdict.kinematic_margin == pytest.approx(other.kinematic_margin, abs=1e-12)
    assert list(verdict.modes) == list(other.modes)
    if verdict.by is not None:
        assert other.certificate()["claim"] == verdict.certificate()["claim"]


def test_the_table_says_what_the_joints_change():
    verdict = sf.stability(jointed(), trials=20)
    assert (verdict.frictional_stability, verdict.by) == ("stable", "bounded-corners")
    assert verdict.trials["kicks"] == 20
    locked = sf.stability(jointed(locked=[3]))
    assert locked.frictional_stability == "stable"
    text = str(verdict)
    assert "mechanism         4 coordinates, 2 contacts; rank 4 of the contacts" in text
    assert f"joints            with coordinate 3 locked: stable, by {locked.by}" in text
    assert "evidence, no proof" in text
    assert "3 of them locked (counted from 0)" in str(locked)
    assert "joints" not in str(locked)
    assert "<pre" in verdict._repr_html_()


def test_trials_say_that_motions_no_contact_feels_go_on():
    scene = sf.MechanismScene.load(EXAMPLE)
    verdict = sf.stability(scene.mechanism, trials=5)
    space = scene.mechanism.contact_space
    free = scene.mechanism.dof - len(scene.mechanism.locked)
    assert verdict.free_motion == free - space.rank == 1
    assert sf.stability(jointed()).free_motion == 0
    text = str(verdict)
    assert "5 ended with all contacts at rest" in text
    assert "1 motion that no contact feels, of coordinates 2 to 4 (from 0)" in text
    # A spectator: a mass on a rail that nothing else feels.
    of = jointed()
    dof = of.dof
    mass = np.eye(dof + 1)
    mass[:dof, :dof] = of.mass_matrix
    rows = [
        sf.ContactRows([*c.normal, 0], [*c.tangential, 0], friction=c.friction)
        for c in of.contacts
    ]
    with_mass = sf.Mechanism(mass, [*of.load, 0], rows, restitution=of.restitution)
    verdict, alone = (sf.stability(one, trials=20) for one in (with_mass, of))
    assert (verdict.free_motion, verdict.by) == (1, alone.by)
    assert verdict.trials["rest"] == alone.trials["rest"]
    assert f"of coordinate {dof} (from 0): after a kick it goes on" in str(verdict)
    assert "came to rest" in str(sf.stability(jointed(), trials=5))


def test_contact_modes_of_a_mechanism_balance():
    mechanism = jointed()
    modes = sf.contact_modes(mechanism)
    assert modes.consistent == ["FF"]
    assert modes.problem == sf.MechanismProblem(mechanism)
    rows = mechanism.contacts
    for word in modes:
        mode = modes[word]
        push = sum(
            c.tangential * t + c.normal * n
            for c, (t, n) in zip(rows, mode.forces, strict=True)
        )
        balance = mechanism.mass_matrix @ mode.acceleration - mechanism.load - push
        assert np.abs(balance).max() < 1e-12, word
    text = str(modes)
    assert "acceleration of q" in text
    slides = sf.contact_modes(sf.MechanismProblem(mechanism, sliding=[1, None]))
    assert [way[:2] for way in slides.problem.jamming] == [(1, "R")]
    low, high = sf.static_forces(mechanism)
    assert modes["FF"].forces == pytest.approx(low)
    assert low == pytest.approx(high)


def test_a_run_of_a_mechanism_is_kept_whole(tmp_path):
    mechanism = sf.Mechanism.of_posture(ROD)
    run = sf.simulate(mechanism, *START)
    body = sf.simulate(ROD, *START, model="local")
    assert (run.outcome, run.model, run.posture) == ("rest", "local", None)
    assert run.mechanism == mechanism
    assert run.q == pytest.approx(body.q, abs=1e-14)
    assert run.time == pytest.approx(body.time, rel=1e-14)
    run.save(tmp_path / "run.json")
    for copy in (
        pickle.loads(pickle.dumps(run)),
        sf.Run.load(tmp_path / "run.json"),
    ):
        assert copy.to_dict() == run.to_dict()
        assert copy.mechanism == mechanism
        times = np.linspace(0, run.time, 9)
        assert (copy.at(times)[0] == run.at(times)[0]).all()
    assert json.loads((tmp_path / "run.json").read_text())
    data = run.to_xarray()
    assert data.q.shape[1] == mechanism.dof
    assert "mechanism   3 coordinates, 2 contacts" in account(run, "run")
    with pytest.raises(ValueError, match="it is of a Mechanism"):
        run.animate(tmp_path / "run.gif")
    run.plot(tmp_path / "run.png")


def test_impacts_are_in_order_of_time():
    """One without friction at the start, then bounces: they are computed in different places."""
    contact = sf.ContactRows(normal=[1.75, -1.75], tangential=[1.0, 1.0], restitution=0.125)  # fmt: skip
    system = sf.Mechanism(np.eye(2), [-1.75, 1.75], [contact])
    run = sf.simulate(system, (0, 0), (0, 0.25), time_limit=1.0)
    assert len(run.impacts) > 1
    assert run.impacts["elapsed"][0] == 0
    assert (np.diff(run.impacts["elapsed"]) > 0).all()
    after, before = run.impacts["rates_after"][:-1], run.impacts["rates_before"][1:]
    assert before == pytest.approx(-after, rel=1e-12)


def test_copies():
    mechanism = jointed(armature=[0, 0, 0, 0.1], locked=[3], restitution=0.2)
    problem = sf.MechanismProblem(mechanism, sliding=[1, None])
    verdict = sf.stability(jointed())
    for value in (mechanism, problem, verdict, *mechanism.contacts):
        assert pickle.loads(pickle.dumps(value)) == value
    assert (
        eval(repr(mechanism), {name: getattr(sf, name) for name in sf.__all__})
        == mechanism
    )
    assert (
        eval(repr(problem), {name: getattr(sf, name) for name in sf.__all__}) == problem
    )


WRONG = [
    ({"mass_matrix": [[1, 0], [0, 1]]}, r"mass_matrix"),
    ({"mass_matrix": np.diag([1, 1, 1, -1.0])}, r"mass_matrix.*positive definite"),
    ({"mass_matrix": np.triu(np.ones((4, 4))) + np.eye(4)}, r"mass_matrix.*symmetric"),
    ({"load": [0, -20, 0]}, r"mass_matrix|load"),
    ({"load": [0, 20, 0, 10]}, r"load.*downwards"),
    ({"load": [0, np.nan, 0, 0]}, r"load"),
    ({"contacts": [sf.ContactRows([0, 1, 0], [1, 0, 0])]}, r"contacts\.1\.normal"),
    ({"contacts": []}, r"contacts"),
    ({"locked": [4]}, r"locked"),
    ({"locked": [0, 1, 2, 3]}, r"locked"),
    ({"armature": [0, 0, 0, -1]}, r"armature"),
    ({"armature": [1, 1]}, r"armature"),
    ({"restitution": 1.5}, r"restitution"),
]


@pytest.mark.parametrize(("changes", "message"), WRONG, ids=lambda x: str(x)[:20])
def test_wrong_input_names_the_field(changes, message):
    with pytest.raises(ValueError, match=message) as caught:
        jointed(**changes)
    assert len(str(caught.value)) < 600


def test_wrong_questions_name_the_field():
    mechanism = jointed()
    for call, message in (
        (lambda: sf.simulate(mechanism, (0, 0.01, 0), (0, 0, 0)), "q = "),
        (
            lambda: sf.simulate(mechanism, (0, -1, 0, 0), (0,) * 4),
            "q puts contact 1 into",
        ),
        (lambda: sf.simulate(mechanism, (0, 1, 0, 0), (0,) * 4, model="full"), "model"),
        (lambda: sf.MechanismProblem(mechanism, sliding=[1]), "sliding"),
        (lambda: sf.robustness(mechanism, [0.1]), "4 coordinates that are not locked"),
        (lambda: sf.equilibrium_region(mechanism), "a rigid body: all joints locked"),
        (lambda: sf.smallest_push(mechanism), "a rigid body: all joints locked"),
        (lambda: sf.MechanismProblem(mechanism, sliding=[2, 1]), "sliding"),
    ):
        with pytest.raises(ValueError, match=message):
            call()
    for call, message in (
        (lambda: sf.robustness(1, [0.1]), "a Posture, or a Mechanism with all joints"),
        (lambda: sf.stability(1), "a Posture, a Mechanism or a sequence of them"),
    ):
        with pytest.raises(TypeError, match=message):
            call()


EXAMPLE = Path(__file__).parents[2] / "examples" / "mechanisms" / "biped.toml"


def test_a_scene_file_of_a_mechanism(tmp_path):
    scene = sf.MechanismScene.load(EXAMPLE)
    assert (scene.mechanism.dof, scene.options["impact"]) == (5, "poisson")
    for name in ("scene.toml", "scene.json"):
        scene.save(tmp_path / name)
        assert sf.MechanismScene.load(tmp_path / name) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene
    run = scene.simulate()
    again = sf.simulate(scene.mechanism, scene.q, scene.qdot, impact="poisson")
    assert run.outcome == "rest"
    assert run.to_dict() == again.to_dict()
    chain = sf.Chain(
        links=[sf.Link(10, 0.4, 1, center=0), *[sf.Link(1, 1 / 12, 1)] * 2],
        joints=[sf.Joint("torque", parent=1, at=0, angle=-np.pi / 2)] * 2,
        feet=[
            sf.Foot(2, slope=0.3, friction=0.6),
            sf.Foot(3, slope=-0.25, friction=0.6),
        ],
    )
    q = [0, 0, 0.1, -0.5, 0.6]
    made = chain.mechanism(q)
    assert made.mass_matrix == pytest.approx(scene.mechanism.mass_matrix, abs=1e-12)
    torques = scene.mechanism.load - made.load
    assert torques[:3] == pytest.approx([0, 0, 0], abs=1e-12)
    interval = chain.holding_torques(q).torque_interval
    assert ((interval[:, 0] < torques[3:]) & (torques[3:] < interval[:, 1])).all()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("load = [0.0", "load = [nan", r"line 5, column 9: load\.1 = NaN"),
        ("load = [0.0, ", "load = [", "mass_matrix = .*the load has 4 coordinates"),
        ("friction = 0.6", "friction = -1", r"contact\.1\.friction = -1"),
        ("friction = 0.6", "frict = 1", r"contact\.1\.frict: unknown field"),
        ("q = [0.0, ", "q = [", r"start\.q = .* each of the 5 coordinates"),
        ("[run]", "[[kick]]", "kick"),
        ("12.0, 0.0, 0.84", "12.0, 1.0, 0.84", r"mass_matrix\.2\.1 .* symmetric"),
    ],
)
def test_wrong_scene_files_name_line_and_field(tmp_path, old, new, message):
    text = EXAMPLE.read_text()
    assert old in text
    path = tmp_path / "scene.toml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ValueError, match=message):
        sf.MechanismScene.load(path)


def test_a_scene_of_a_mechanism_is_none_of_a_body():
    with pytest.raises(ValueError, match="of a body, and this is one of a mechanism"):
        sf.load(EXAMPLE)


@pytest.mark.parametrize("command", ["run", "modes", "stability"])
def test_commands_read_mechanisms(command, capsys):
    assert main([command, str(EXAMPLE)]) == 0
    out = capsys.readouterr().out
    expected = {
        "run": "mechanism   5 coordinates, 2 contacts",
        "modes": "acceleration of q",
        "stability": "joints            with coordinates 3 and 4 locked: stable",
    }
    assert expected[command] in out
