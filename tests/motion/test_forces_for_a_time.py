"""Forces through the centre of mass that act for a time, against closed forms and against the motion of the ground that they equal."""

import math
import pickle

import numpy as np
import pytest
import standfast as sf
from bits import GROUNDS, LAWS, Draw, posture, state

G = 9.81
BOX = sf.Posture.box(1.0, 0.4, mass=2.0, friction=0.5, gravity=G)


def test_a_push_above_friction_slides_a_box_and_one_below_does_not():
    """F > μ m g: v = (F/m − μg) T at the end, then it stops after v/(μg)."""
    force, length = 15.0, 0.3
    push = sf.Force(0.1, 0.1 + length, (force, 0))
    run = sf.simulate(BOX, forces=[push])
    gained = (force / 2 - 0.5 * G) * length
    stop = gained / (0.5 * G)
    assert run.outcome == "rest"
    assert run.time == pytest.approx(0.1 + length + stop, abs=1e-14)
    assert run.q == pytest.approx([gained * (length + stop) / 2, 0, 0], abs=1e-14)
    assert [phase.mode[:2] for phase in run.phases] == ["FF", "RR", "RR", "FF"]
    still = sf.simulate(BOX, forces=[sf.Force(0, 1, (9.8, 0))])
    assert still.outcome == "rest"
    assert not still.q.any()


def test_forces_of_the_ground_hold_against_the_push():
    run = sf.simulate(BOX, forces=[sf.Force(0, 1, (6, -2))])
    (held,) = [run.forces_at(0.5)[:2]]
    assert held.sum(axis=0) == pytest.approx([-6, 2 * G + 2], abs=1e-12)


def test_a_lift_raises_the_body_and_lets_it_fall():
    """F = 2 m g upwards for T: v = gT and h = gT²/2; then it flies for (1 + √2) T."""
    length = 0.25
    push = sf.Force(0, length, (0, 2 * 2 * G))
    run = sf.simulate(BOX, forces=[push], stop="rest")
    (landing,) = {float(t) for t in run.impacts["time"]}
    assert landing == pytest.approx(length * (2 + math.sqrt(2)), abs=1e-14)


def test_forces_that_overlap_add_up():
    both = [sf.Force(0.0, 0.4, (8, 0)), sf.Force(0.2, 0.6, (8, 0))]
    turns = (
        sf.Force(0, 0.2, (8, 0)),
        sf.Force(0.2, 0.4, (16, 0)),
        sf.Force(0.4, 0.6, (8, 0)),
    )
    one, other = (
        sf.simulate(BOX, forces=f, stop="time", time_limit=1.0) for f in (both, turns)
    )
    assert np.array_equal(one.q, other.q)
    assert one.phases[1].mode[:2] == "RR"


def test_a_force_equals_an_acceleration_of_the_ground():
    """Of 200 random scenes: the same motion as with the acceleration −F/m, bit by bit."""
    differ = 0
    for k in range(200):
        draw = Draw(47, k)
        body = posture(draw, 1 + k // 5 % 4, GROUNDS[k // 20 % 4])
        q, qdot = state(draw, body)
        start, length = draw.number(0, 0.5), draw.number(0.1, 1)
        # Divisions by the mass are exact: it is a power of two.
        force = np.array([draw.number(-8, 8), draw.number(-4, 12)])
        times = [start, start + length]
        options = {"impact": LAWS[k % 5], "time_limit": 2.0, "event_limit": 5000}
        shake = sf.GroundMotion(times, [tuple(-force / body.mass), (0, 0)])
        try:
            shaken = sf.simulate(body, q, qdot, ground_motion=shake, **options)
        except ValueError:
            continue  # out of the range of the laws of this number of contacts
        pushed = sf.simulate(
            body, q, qdot, forces=[sf.Force(*times, tuple(force))], **options
        )
        assert pushed.outcome == shaken.outcome, k
        assert np.array_equal(pushed.q, shaken.q), k
        assert np.array_equal(pushed.impacts, shaken.impacts), k
        differ += not np.array_equal(pushed.q, sf.simulate(body, q, qdot, model="full", **options).q)  # fmt: skip
    assert differ > 100


def test_a_force_goes_through_files_batches_and_pickles(tmp_path):
    forces = [sf.Force(0.25, 0.5, (20, 1))]
    scene = sf.Scene(BOX, forces=forces)
    for name in ("scene.toml", "scene.json"):
        scene.save(tmp_path / name)
        assert sf.load(tmp_path / name).forces == forces
    run = scene.simulate()
    assert run.forces == forces
    for copy in (pickle.loads(pickle.dumps(run)), sf.simulate_many(BOX, (0, 0, 0), (0, 0, 0), forces=forces)[0]):  # fmt: skip
        assert copy.forces == forces
        assert np.array_equal(copy.q, run.q)
    run.save(tmp_path / "run.json")
    assert sf.Run.load(tmp_path / "run.json").forces == forces
    assert eval(repr(forces[0]), {"Force": sf.Force}) == forces[0]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"start": 1, "end": 1}, "end = 1.0 is outside its range: finite, after start"),
        ({"end": math.inf}, "end = inf is outside its range: finite, after start"),
        ({"force": (math.nan, 0)}, "force.x = NaN is outside its range"),
        ({"point": (0, 1)}, r"point = \(0, 1\) cannot be used: not given: a force acts through the centre of mass"),
        ({"torque": 2}, "torque = 2 cannot be used: not given: .* kicks="),
    ],
)  # fmt: skip
def test_wrong_forces_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        sf.Force(**({"start": 0, "end": 1, "force": (1, 0)} | arguments))


def test_a_force_on_a_mechanism_is_one_for_each_coordinate():
    mechanism = sf.Mechanism.of_posture(BOX)
    with pytest.raises(TypeError, match=r"forces\.1 = .* a pair \(time, values"):
        sf.simulate(mechanism, forces=[sf.Force(0, 1, (1, 0))])
