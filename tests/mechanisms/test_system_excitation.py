"""Kicks, forces and motions of the ground of assemblies and mechanisms, beside those of one body and beside closed forms."""

import pickle

import numpy as np
import pytest
import standfast as sf

STILL = (0, 0, 0)
SHAKE = sf.GroundMotion([0.5, 0.7, 1.1], [(4.0, 0.5), (-7.0, 0.0), (0.0, 0.0)])


def block(friction=0.5, restitution=0.0):
    """A block as a System and as a Posture."""
    system = sf.System({"block": sf.Block(1, 0.6, density=2)}, friction=friction, restitution=restitution)  # fmt: skip
    posture = sf.Posture(
        mass=1.2,
        gyration_radius=((1 + 0.36) / 12) ** 0.5,
        center_of_mass=(0, 0.3),
        contacts=[sf.Contact(point=(x, 0), friction=friction) for x in (-0.5, 0.5)],
        restitution=restitution,
    )
    return system, posture


@pytest.mark.parametrize("friction", [0.0, 0.3, 0.8])
@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_one_body_moves_as_in_the_local_model(friction, restitution):
    system, posture = block(friction, restitution)
    kicks = [
        sf.Kick(0.2, (0.1, 0.7)),
        sf.Kick(0.9, (-0.6, 0.0), point=(-0.5, 0.6)),
        sf.Kick(0.9, (0.0, -0.2), point=(0.5, 0.6)),
    ]
    forces = [sf.Force(0.1, 0.8, (2.0, 1.0)), sf.Force(0.6, 1.3, (0.0, -3.0))]
    options = {"impact": "moreau", "time_limit": 4.0}
    one = sf.simulate(posture, STILL, STILL, kicks=kicks, forces=forces, ground_motion=SHAKE, model="local", **options)  # fmt: skip
    run = sf.simulate(
        system,
        kicks={"block": kicks},
        forces={"block": forces},
        ground_motion=SHAKE,
        **options,
    )
    assert (run.outcome, run.collisions) == (one.outcome, one.collisions)
    assert run.time == pytest.approx(one.time, rel=1e-12)
    assert [phase.mode for phase in run.phases] == [phase.mode for phase in one.phases]
    for t in np.linspace(0, run.time, 40):
        assert run.at(t)[0] == pytest.approx(one.at(t)[0], abs=1e-12)
        forces_of_one = one.forces_at(t)
        if np.isfinite(forces_of_one).all() and friction == 0:
            assert run.forces_at(t) == pytest.approx(forces_of_one, abs=1e-9)


def test_a_shaken_stack_slides_at_the_lower_friction():
    g, a = 10.0, 6.0
    stack = sf.System(
        {
            "low": sf.Block(1, 0.2, friction=0.8),
            "high": sf.Block(1, 0.2, at=(0, 0.2), friction=0.2),
        },
        gravity=g,
    )
    run = sf.simulate(stack, ground_motion=sf.GroundMotion([0, 0.5], [(a, 0), (0, 0)]))
    assert run.outcome == "rest"
    # The lower block holds: its friction carries its own inertia and the friction on it. Beside the ground the upper one gains (a − μ g) for
    # half a second, and then loses μ g.
    speed = (a - 0.2 * g) * 0.5
    assert run.q[0] == 0.0
    assert run.q[3] == pytest.approx(
        -(speed * 0.25 + speed**2 / (2 * 0.2 * g)), rel=1e-12
    )
    assert run.time == pytest.approx(0.5 + speed / (0.2 * g), rel=1e-12)
    # Its forces while it slides: friction to the right on the upper block, from the left on the lower one.
    t = run.forces_at(0.25)
    assert t[:, 1].sum() == pytest.approx(10 * 0.2 * (2 + 1))
    assert t[2:, 0].sum() == pytest.approx(0.2 * 0.2 * g)
    assert t[:2, 0].sum() == pytest.approx(0.2 * a + 0.2 * 0.2 * g)


def test_a_tilt_beyond_the_friction_angle_lets_a_block_slide():
    system, _ = block(friction=0.5)
    tilt = 0.6
    run = sf.simulate(system, ground_motion=sf.GroundMotion([0, 1], tilt=[tilt, 0]))
    speed = 9.81 * (np.sin(tilt) - 0.5 * np.cos(tilt))
    assert run.outcome == "rest"
    assert run.q[0] == pytest.approx(-(speed / 2 + speed**2 / (2 * 0.5 * 9.81)), rel=1e-12)  # fmt: skip
    held = sf.simulate(system, ground_motion=sf.GroundMotion([0, 1], tilt=[0.4, 0]))
    assert held.q.tolist() == [0, 0, 0]
    assert held.time == 1.0


def test_a_kick_where_no_contact_feels_it():
    """A ball on one foot below its centre: a kick above the centre spins it, and no frictionless contact stops that."""
    ball = sf.Rigid.polygon([(0, 0), (1, 1), (0, 2), (-1, 1)])
    other = sf.Block(1, 1, at=(3, 0))
    foot = sf.SystemContact("ball", None, (0, 0), friction=0.0)
    ends = [sf.SystemContact("other", None, (x, 0), friction=0.5) for x in (2.5, 3.5)]
    system = sf.System({"ball": ball, "other": other}, contacts=[foot, *ends])
    assert system.mechanism.contact_space.rank < 6
    spin = sf.Kick(0.5, (0.3, 0.0), point=(0, 1.0))
    run = sf.simulate(system, kicks={"ball": spin}, time_limit=2.0, stop="time")
    # Through the centre of mass: it slides at J/m.
    assert run.q[0] == pytest.approx(0.3 / 2 * 1.5, rel=1e-12)
    assert run.q[1:] == pytest.approx([0, 0, 0, 0, 0], abs=1e-12)
    assert run.at(0.5)[0][0] == 0.0
    push = sf.Force(0.5, 1.0, (2.0, 0.0))
    run = sf.simulate(system, forces={"ball": push}, time_limit=2.0, stop="time")
    assert run.q[0] == pytest.approx(0.5 * 0.25 + 0.5 * 1.0, rel=1e-12)
    assert run.at(1.0)[1][0] == pytest.approx(0.5, rel=1e-12)


def test_a_mechanism_is_kicked_in_its_coordinates():
    system, _ = block()
    of = system.mechanism
    m = of.mass_matrix[0, 0]
    run = sf.simulate(of, kicks=[(1.0, [3 * m, 0, 0])])
    assert run.q[0] == pytest.approx(9 / (2 * 0.5 * 9.81), rel=1e-12)
    pushed = sf.simulate(of, forces=[(0, [0.75 * m * 9.81, 0, 0]), (2, [0, 0, 0])])
    a = 0.25 * 9.81
    assert pushed.q[0] == pytest.approx(a * 2 + (a * 2) ** 2 / (2 * 0.5 * 9.81), rel=1e-12)  # fmt: skip
    forces = {"block": sf.Force(0, 2, (0.75 * m * 9.81, 0))}
    assert sf.simulate(system, forces=forces).to_dict() == pushed.to_dict()
    assert pickle.loads(pickle.dumps(pushed)).to_dict() == pushed.to_dict()
    endless = sf.simulate(of, forces=[(1, [m, 0, 0])])
    assert any("lasts from t = 1.0 s on for ever" in text for text in endless.warnings)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"kicks": [sf.Kick(0, (1, 0))]}, r"kicks = .*dict \{name of a body"),
        ({"kicks": {"brick": sf.Kick(0, (1, 0))}}, 'kicks = "brick".*a body of the system: block'),
        ({"kicks": {"block": 3}}, "kicks = 3"),
        ({"kicks": {"block": [sf.Kick(1, (1, 0)), sf.Kick(-1, (1, 0))]}}, r"kicks\.2\.time = -1\.0"),
        ({"forces": {"block": sf.Kick(0, (1, 0))}}, "a Force is needed|forces = "),
        ({"ground_motion": 3}, "ground_motion = 3"),
        ({"ground_motion": sf.GroundMotion([0, 1], [1, 0], interpolation="linear")}, "steps"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(given, message):
    with pytest.raises((TypeError, ValueError), match=message):
        sf.simulate(block()[0], **given)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"kicks": [sf.Kick(0, (1, 0))]}, r"kicks\.1 = .*pair \(time"),
        ({"kicks": [(0, [1, 2])]}, r"kicks\.1 = \[2 values\].*3 coordinates"),
        ({"kicks": [(-1, [1, 2, 3])]}, r"kicks\.1\.time = -1\.0"),
        ({"forces": [(1, [1, 2, 3]), (1, [0, 0, 0])]}, r"forces\.2\.time = 1\.0 after 1\.0"),
        ({"forces": [(1, [1, 2, np.nan])]}, r"forces\.1\.2 = |nan"),
        ({"ground_motion": SHAKE}, r"ground_motion = .*-M a"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_mechanism_is_named(given, message):
    with pytest.raises((TypeError, ValueError), match=message):
        sf.simulate(block()[0].mechanism, **given)


def test_a_scene_with_kicks_and_a_shaken_ground(tmp_path):
    stack = sf.System({"low": sf.Block(1, 1), "high": sf.Block(1, 1, at=(0.1, 1))})
    still = np.zeros(6)
    kicks = {"high": [sf.Kick(0.1, (0.1, 0.2)), sf.Kick(0.3, (0, 0.1), point=(0.2, 2))]}
    forces = {"low": [sf.Force(0.2, 0.4, (1, 0))], "high": [sf.Force(0, 1, (0, -1))]}
    scene = sf.MechanismScene(
        stack, still, still, kicks=kicks, forces=forces, ground_motion=SHAKE
    )
    assert (scene.kicks, scene.ground_motion) == (kicks, SHAKE)
    assert scene.forces == forces
    for name in ("scene.toml", "scene.json"):
        scene.save(tmp_path / name)
        assert sf.MechanismScene.load(tmp_path / name) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene
    run = sf.simulate(stack, kicks=kicks, forces=forces, ground_motion=SHAKE)
    assert scene.simulate().to_dict() == run.to_dict()
    text = scene.to_toml().replace("time = 0.3", "time = -0.3")
    (tmp_path / "late.toml").write_text(text)
    with pytest.raises(ValueError, match=r"line \d+, column 8: kick\.2\.time = -0\.3"):
        sf.MechanismScene.load(tmp_path / "late.toml")
    (tmp_path / "other.toml").write_text(
        scene.to_toml().replace('body = "low"', 'body = "lower"')
    )
    with pytest.raises(ValueError, match=r'force\.\d\.body = "lower"'):
        sf.MechanismScene.load(tmp_path / "other.toml")
    with pytest.raises((TypeError, ValueError), match="only a scene of a System"):
        sf.MechanismScene(stack.mechanism, still, still, ground_motion=SHAKE)


def test_bodies_that_slide_past_each_other_are_named():
    stack = sf.System(
        [sf.Block(0.3, 0.1), sf.Block(0.3, 0.1, at=(0, 0.1))], friction=0.2
    )
    far, near = (
        sf.simulate(stack, kicks={"2": sf.Kick(0, (impulse, 0))}).warnings
        for impulse in (0.06, 0.01)
    )
    assert any("2 on 1 at (-0.15, 0.1): the bodies have slid past each other" in text for text in far)  # fmt: skip
    assert near == []
