"""Landings without rebound are distinguished from accumulations of infinitely many impacts."""

import pytest
import standfast as sf
from plastic_scenes import block, body, drop, rod


def test_a_plastic_landing_is_told_from_what_accumulates():
    """In both kinds of coordinates, also where landings without rebound accumulate."""
    for run in (drop(body([0.0])), drop(body([0.0]), impact="moreau")):
        (point,) = run.zeno_points
        assert (point.kind, point.method, point.plastic) == ("1-zeno", "bounce", True)
        assert "without rebound" in repr(point)
    *landings, last = block().zeno_points[1:]
    assert {point.plastic for point in landings} == {True}
    assert (last.method, last.plastic) == ("nested", False)
    for law in ("newton", "poisson"):
        (point,) = drop(body([0.0], 1e-3), impact=law).zeno_points
        assert not point.plastic
    (point,) = sf.simulate(rod(0.0), (0, 0, 0), (0, 0, 0)).zeno_points
    assert (point.method, point.plastic) == ("rest", False)


@pytest.mark.parametrize("model", ["local", "full"])
def test_an_uncoupled_plastic_impact_is_one_impact(model):
    """Two masses on a rod: each end stops separately, and an impact on the second does not change the first."""
    dumbbell = body([-0.5, 0.5], gyration_radius=0.5, height=0.0)
    assert dumbbell.psi == (0.0, 0.0)
    run = drop(dumbbell, 0.1, model=model)
    assert list(run.impacts["contact"]) == [1, 2]
    assert [p.contacts for p in run.zeno_points] == [(1,), (2,)]
    assert [p.plastic for p in run.zeno_points] == [True, True]
