"""Feet one above the other that land together: their gaps change alike, whatever each of them is made of."""

import numpy as np
import pytest
import standfast as sf
from mpmath import mp, mpf
from standfast import Contact, Posture


@pytest.mark.parametrize("restitutions", [(0.2, 0.5), (0.5, 0.2), (0.2, 0.2, 0.5)])
def test_the_more_elastic_of_them_rules(restitutions):
    feet = [
        Contact((-0.5, float(i)), restitution=e) for i, e in enumerate(restitutions)
    ]
    body = Posture(1.0, 0.3, (0.0, 0.0), feet, 0.9, 9.81)
    run = sf.simulate(body, (0.0, 0.01, 0.0), (0.1, -0.3, 0.0), event_limit=100)
    hit = run.impacts[run.impacts["elapsed"] == run.impacts["elapsed"][0]]
    speed = np.sqrt(0.3**2 + 2 * 9.81 * 0.01)
    rates = np.array(hit["rates_after"][-1])
    assert rates == pytest.approx(np.full(len(feet), 0.5 * speed), rel=1e-14)
    _, qdot = run.at(float(hit["elapsed"][0]))
    assert qdot[1] - 0.5 * qdot[2] == pytest.approx(0.5 * speed, rel=1e-13)


@pytest.mark.parametrize("gravity", [1e20, 1e30, 1e44, 1e48, 1e60, 1e100, 1e140])
def test_in_step_they_come_to_rest_under_a_load_that_leaves_no_time_to_turn(gravity):
    feet = [Contact((-2.0, 1.000765931372549), friction=0.18), Contact((-2.0, 0.0))]
    center, speed, omega, e = (-1.9963, 0.0594), 0.2582, 0.949, 0.00384
    body = Posture(1.0, 0.11665, center, feet, e, gravity)
    qdot = (0.74, speed, omega)
    run = sf.simulate(body, (0.3, 0.0, 0.0), qdot, event_limit=2000, model="full")
    assert np.isfinite(run.q).all()
    assert np.isfinite(run.qdot).all()
    with mp.workdps(40):
        rise = mpf(speed) + (mpf(feet[0].point[0]) - mpf(center[0])) * mpf(omega)
        end = 2 * rise / (mpf(gravity) * (1 - mpf(e)))  # takes off at t = 0
        first = run.zeno_points[0]
        assert first.contacts == (1, 2)
        # While they bounce it turns by less than 1e-20 rad.
        assert float(abs(mpf(float(first.elapsed)) / end - 1)) < 4e-16
