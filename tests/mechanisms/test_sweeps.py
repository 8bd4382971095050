"""Sweeps over the parameters of chains."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import standfast as sf
from test_chains import Q, biped

WIDE = biped(slopes=(-0.066, -0.091), mu=0.667), [0, 0, -0.166, -0.325, 0.841]


def held(chain, q, **changes):
    """The mechanism of a biped under the torques that hold it."""
    found = chain.holding_torques(q)
    torques = (0, 0) if found is None else found.torques
    return biped(torques=torques, **changes).mechanism(q)


def test_every_point_is_the_verdict_on_its_mechanism(tmp_path):
    chain = biped(slopes=(0.1, -0.1), mu=0.6)
    over = {
        "joint.1.angle": np.linspace(-1.0, -0.2, 5),
        "joint.2.angle": np.linspace(0.2, 1.0, 4),
        "base.angle": [-0.1, 0.2],
    }
    names = ["stability", "by", "equilibrium", "equilibrium_margin", "coupling"]
    grid = sf.sweep(chain, over, names, q=Q)
    for a, first in enumerate(over["joint.1.angle"]):
        for b, second in enumerate(over["joint.2.angle"]):
            for c, turn in enumerate(over["base.angle"]):
                q = [0, 0, turn, first, second]
                verdict = sf.stability(held(chain, q, slopes=(0.1, -0.1), mu=0.6))
                point = grid.isel(
                    {"joint.1.angle": a, "joint.2.angle": b, "base.angle": c}
                )
                assert str(point.stability.values) == verdict.frictional_stability
                assert str(point.by.values) == (verdict.by or "undecided")
                assert bool(point.equilibrium) == verdict.equilibrium
                assert float(point.equilibrium_margin) == verdict.equilibrium_margin
                assert np.isnan(point.coupling)
    assert set(np.unique(grid.by)) == {"bounded-corners", "no-solution", "undecided"}
    assert grid["joint.1.angle"].attrs == {"long_name": "joint 1 angle", "units": "rad"}
    assert grid.attrs["chain"] == repr(chain)
    again = sf.sweep(chain, over, names, q=Q, cache=tmp_path, chunk=7)
    known = sf.sweep(chain, over, names, q=Q, cache=tmp_path, chunk=7)
    with ThreadPoolExecutor() as executor:
        other = sf.sweep(chain, over, names, q=Q, executor=executor)
    assert grid.identical(again)
    assert grid.identical(known)
    assert grid.identical(other)


def test_the_armature_at_which_jams_end():
    # The zero of k of the foot of theory, found elsewhere with more digits.
    threshold = 1.602467664252
    chain, q = WIDE
    over = {"armature": [0, threshold - 1e-9, threshold + 1e-9, 10]}
    grid = sf.sweep(chain, over, "by", q=q)
    assert grid.by.values.tolist() == ["no-solution"] * 2 + ["undecided"] * 2


def test_locked_joints_have_all_that_a_body_has():
    chain = biped("locked", mu=0.6)
    grid = sf.sweep(
        chain, {"friction": [0.4, 0.6]}, ["by", "coupling", "theorem_3"], q=Q
    )
    verdict = sf.stability(chain.mechanism(Q))
    assert grid.by.values[1] == verdict.by
    assert grid.coupling.values[1] == verdict.coupling


def test_torques_that_are_given():
    chain, q = WIDE
    found = chain.holding_torques(q).torques
    over = {"joint.1.torque": [found[0], found[0] + 100]}
    moved = sf.Chain(
        links=chain.links,
        joints=[
            sf.Joint("torque", torque=torque, parent=1, at=0, angle=joint.angle)
            for torque, joint in zip(found, chain.joints, strict=True)
        ],
        feet=chain.feet,
    )
    grid = sf.sweep(moved, over, "equilibrium", q=q)
    assert grid.equilibrium.values.tolist() == [True, False]
    for torques, holds in ((found, True), (found + 100, False)):
        grid = sf.sweep(chain, {"gravity": [9.81]}, "equilibrium", q=q, torques=torques)
        assert grid.equilibrium.values.tolist() == [holds]


WRONG = [
    ({"over": {"joint.3.angle": [0]}}, r"parameters of a chain .* from 1 to 2"),
    ({"over": {"mass": [1]}}, "parameters of a chain"),
    ({"over": {"joint.1.angle": [30]}}, r"q\.3 = 30.0 .*math\.radians"),
    ({"over": {"joint.1.torque": [3]}, "torques": "holding"}, "no torque, because"),
    ({"over": {"friction": [1], "foot.1.friction": [1]}}, "different numbers"),
    ({"over": {"armature": [1], "joint.1.armature": [1]}}, "different numbers"),
    ({"over": {"friction": [-1]}}, r"feet\.1\.friction = -1"),
    ({"q": None}, "q = None .* configuration of the chain"),
    ({"q": [0, 0]}, "5 coordinates"),
    ({"quantity": "fate"}, "a quantity of a verdict"),
    ({"torques": [1, 2, 3]}, r"torques = array of shape \[3\] .* of the 2 joints"),
    ({"torques": "hold"}, "torques = 'hold' .*'holding', 'least', 'given' or an"),
]


@pytest.mark.parametrize(("changes", "message"), WRONG)
def test_wrong_sweeps_name_the_field(changes, message):
    chain, q = WIDE
    with pytest.raises(ValueError, match=message):
        sf.sweep(chain, **({"over": {"friction": [0.5]}, "q": q} | changes))


def test_only_chains_have_torques():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2)
    with pytest.raises(ValueError, match="only a Chain has torques"):
        sf.sweep(rod, {"friction": [0.5]}, torques="holding")
    with pytest.raises(TypeError, match="a Posture"):
        sf.sweep(1, {"friction": [0.5]})


def test_a_sweep_can_be_sent_elsewhere():
    chain, q = WIDE
    question = sf._core.Sweep(
        chain, [("friction", [0.2, 0.5])], ["by"], q, hold="middle"
    )
    copy = pickle.loads(pickle.dumps(question))
    assert (copy.run(0, 2)[0] == question.run(0, 2)[0]).all()
