"""Feet one above the other that land together: their gaps change equally, with any material of each."""

from decimal import Decimal

import numpy as np
import pytest
import standfast as sf
from decimals import cos_sin
from friction_oracle import integrate, precise
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
        # During the bounces it rotates by less than 1e-20 rad.
        assert float(abs(mpf(float(first.elapsed)) / end - 1)) < 4e-16


@pytest.mark.parametrize("restitution", [0.2, 0.3, 0.5])
@pytest.mark.parametrize("height", [0.05, 0.1, 0.25, 0.3])
@pytest.mark.parametrize(
    "order", ["newton", "first-contact-first", "last-contact-first"]
)
def test_a_body_between_its_feet_comes_to_rest(restitution, height, order):
    """Tilted by 1e-11 rad, two of the feet have almost equal rows."""
    feet = [Contact((0.0, 0.4)), Contact((0.0, 1.3)), Contact((0.5, 0.0))]
    body = Posture(1.0, 0.1, (0.1, 1.0), feet, restitution, 9.81)
    run = sf.simulate(body, (0, height, 0), (0, 0, 0), model="full", simultaneous=order)
    assert run.outcome == "rest"
    assert np.abs(run.q).max() < 1e-14


def pivoted(posture, theta, time):
    """Rotation after a time of a body that rotates from rest about its upper foot: the equation of the pendulum, in 26
    digits."""
    x, y = (
        Decimal(a) - Decimal(b)
        for a, b in zip(posture.contacts[1].point, posture.center_of_mass, strict=True)
    )
    inertia = Decimal(posture.gyration_radius) ** 2 + x * x + y * y
    g = Decimal(posture.gravity)

    def rates(_, state):
        turn, omega = state
        cos, sin = cos_sin(turn)
        return [omega, g * (x * cos - y * sin) / inertia]

    start = [Decimal(theta), Decimal(0)]
    return integrate(rates, start, Decimal(0), Decimal(time), Decimal(1) / 64)[0]


@pytest.mark.parametrize("theta", [3e-11, 3e-9, 3e-7, 5e-6, 9e-5, 3e-3, 0.02])
def test_a_foot_that_swings_past_the_other_does_not_land(theta):
    """It comes down to the ground below the foot that is held, and reverses there."""
    feet = [Contact((0.0, 0.4), friction=0.5), Contact((0.0, 1.3), friction=0.5)]
    body = Posture(1.0, 0.1, (0.1, 1.0), feet, 0.2, 9.81)
    y = 0.1 * np.sin(theta)
    y -= body.gaps((0.0, y, theta)).min()
    run = sf.simulate(body, (0.0, y, theta), (0, 0, 0), model="full", time_limit=0.1)
    assert run.outcome == "time-limit"
    assert [phase.mode for phase in run.phases][-1] == "SF"
    assert (run.impacts["elapsed"] < 1e-9).all()
    with precise():
        assert run.theta == pytest.approx(float(pivoted(body, theta, 0.1)), rel=1e-12)


FEET = [(0.8, 0.5), (0.3, 0.0), (0.3, 0.6)]


@pytest.mark.parametrize("order", [(0, 1, 2), (0, 2, 1), (1, 2, 0), (2, 1, 0)])
def test_forces_of_one_line_leave_the_motion_to_the_third(order):
    """A slide to the left at v = 1 on three feet with mu = 1: two of the forces lie on one line, and the deceleration of all
    together is g."""
    feet = [Contact(FEET[i], friction=1.0) for i in order]
    body = Posture(1.0, 0.2, (0.0, 0.0), feet, 0.0, 10.0)
    run = sf.simulate(body, (0, 0, 0), (-1, 0, 0), model="full", time_limit=0.01)
    assert [phase.mode for phase in run.phases] == ["LLL"]
    assert run.qdot == pytest.approx([-0.9, 0, 0], abs=1e-14)


@pytest.mark.parametrize("friction", [0.1, 1e2, 1e5, 1e6])
@pytest.mark.parametrize("gyration_radius", [2e-4, 0.01, 0.3])
def test_undetermined_forces_are_so_however_rough_a_foot(friction, gyration_radius):
    """The load on the third foot is undetermined, and only this foot has friction."""
    feet = [
        Contact((0.26, 0)),
        Contact((-0.55, 0)),
        Contact((-0.6, 0), friction=friction),
    ]
    body = Posture(1.0, gyration_radius, (0.0, 1.1), feet, 0.0, 9.81)
    modes = sf.contact_modes(body, (0, 0, 0), (-2, 0, 0))
    assert modes["LLL"].determined == "undetermined"
    run = sf.simulate(body, (0, 0, 0), (-2, 0, 0), model="full", time_limit=0.05)
    assert run.outcome == "ambiguous"
