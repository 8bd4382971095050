"""Regular motions towards e = 1, whose time is summed, beside the impacts one by one in extended precision."""

import numpy as np
import pytest
import standfast as sf

#: 64 bits of mantissa: errors of 500 000 impacts stay below those of a double.
Number = np.longdouble

#: Of each case: ψ, e, and the rates and the second gap after an impact at contact 1, beside the motion that repeats.
CASES = [
    (0.72, (0.9997, 0.9997), (0.8675, -0.6124), 0.0180),
    (0.72, (0.9997, 0.9998), (0.8575, -0.6174), 0.0180),
    (0.6, (0.9998, 0.9998), (0.8820, -0.5240), 0.0248),
]


def time_until_rest(gravity, psi, restitution, rates, gap):
    """Both contacts are hit in turn, h = u t − g t²/2: the time until the speeds have fallen by 19 digits."""
    g, psi = Number(gravity), Number(psi)
    e = [Number(one) for one in restitution]
    (u_a, u_b), h_b = map(Number, rates), Number(gap)
    time, other, impacts = Number(0), 1, 0
    while True:
        s = np.sqrt(u_b * u_b + 2 * g * h_b)
        flight = 2 * h_b / (s - u_b)
        w = u_a - g * flight
        assert u_a + w > 0  # the contact hit last is still in the air
        time += flight
        u_a, u_b, h_b = (
            e[other] * s,
            w - (1 + e[other]) * psi * s,
            flight * (u_a + w) / 2,
        )
        other, impacts = 1 - other, impacts + 1
        if s < 1e-19:
            return time, impacts


@pytest.mark.skipif(np.finfo(Number).eps > 2e-19, reason="no extended precision here")
@pytest.mark.parametrize(("psi", "restitution", "rates", "gap"), CASES)
def test_the_sum_is_the_time_of_all_impacts(psi, restitution, rates, gap):
    model = sf.LocalModel(
        gravity=(9.81, 9.81), psi=(psi, psi), phi=(0.0, 0.0), restitution=restitution
    )
    run = model.simulate(gaps=(0.0, gap), rates=rates)
    assert run.collisions < 3000
    (zeno,) = run.zeno_points
    assert (zeno.kind, zeno.method, zeno.certified) == ("2-zeno", "self-similar", False)
    time, impacts = time_until_rest(9.81, psi, restitution, rates, gap)
    assert impacts > 200_000
    assert abs(float(run.elapsed - time)) < 2e-14 * run.elapsed
    assert abs(float(run.elapsed - time)) < 10 * zeno.time_error


@pytest.mark.parametrize("model", ["local", "full"])
def test_a_body_rests_where_its_impacts_lead_it(model):
    """A rod that goes on at .3 m/s: its time and its place, with a time limit just before the end, impact by impact, and summed."""
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.9998)
    start = {"q": (0, 0.0089, 0.0178), "qdot": (0.3, 0.118, -1.4765), "model": model}
    summed = sf.simulate(rod, **start, stop="zeno")
    assert summed.zeno_points[0].method == "self-similar"
    until = summed.elapsed * (1 - 1e-9)
    followed = sf.simulate(
        rod, **start, time_limit=until, event_limit=10**7, record=False
    )
    assert (followed.outcome, summed.outcome) == ("time-limit", "zeno")
    assert followed.collisions > 200_000
    assert abs(followed.q[1:]).max() < 1e-9
    assert summed.q[1:] == pytest.approx((0, 0), abs=1e-15)
    assert summed.q[0] == pytest.approx(0.3 * summed.elapsed, rel=1e-13)
    assert followed.qdot == pytest.approx((0.3, 0, 0), abs=1e-7)


@pytest.mark.parametrize("model", ["local", "full"])
def test_states_within_the_sum_are_those_of_the_impacts(model):
    """Up to more impacts than are recorded."""
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.9999)
    start = {"q": (0, 0.0089, 0.0178), "qdot": (0.3, 0.118, -1.4765), "model": model}
    summed = sf.simulate(rod, **start)
    for share in (0.1, 0.9, 0.999):
        t = share * summed.elapsed
        followed = sf.simulate(
            rod, **start, time_limit=t, event_limit=10**7, record=False
        )
        q, qdot = summed.at(t)
        assert np.abs(q - followed.q).max() < 1e-11
        # The clocks of 650 s differ by up to 1e-11 s, and the body falls meanwhile.
        assert np.abs(qdot - followed.qdot).max() < 9.81e-11


def time_until_body_rests(feet, height, radius, restitution, q, qdot):
    """The same of a body on level ground, with its centre of mass at `height`, h = y + x sin θ + H(1 − cos θ). The last 10 digits of its motion
    are similar to those before."""
    g, squared, e = Number(9.81), Number(radius) ** 2, Number(restitution)
    x, height = [Number(foot) for foot in feet], Number(height)
    y, theta, v, omega = map(Number, (*q, *qdot))
    time, last, impacts, marks = Number(0), None, 0, []

    def turned(angle):
        """sin and 1 − cos, by series: the angles are small."""
        square = angle * angle
        sine, lift = Number(1), Number(1)
        for k in range(11, 1, -2):
            sine = 1 - square * sine / (k * (k - 1))
            lift = 1 - square * lift / (k * (k + 1))
        return angle * sine, square / 2 * lift

    def gap(i, t):
        sine, lift = turned(theta + omega * t)
        h = y + v * t - g * t * t / 2 + x[i] * sine + height * lift
        return h, v - g * t + omega * (x[i] * (1 - lift) + height * sine)

    def landing(i):
        h, u = gap(i, 0)
        t = 2 * h / (np.sqrt(u * u + 2 * g * h) - u)
        for _ in range(8):
            h, u = gap(i, t)
            t -= h / u
            if abs(h) < -1e-19 * u * t:
                break
        return t

    while True:
        i = 1 - last if last is not None else min((0, 1), key=landing)
        t = landing(i)
        assert last is None or gap(last, t)[0] > 0
        time, y, v, theta = (
            time + t,
            y + v * t - g * t * t / 2,
            v - g * t,
            theta + omega * t,
        )
        sine, lift = turned(theta)
        arm = x[i] * (1 - lift) + height * sine
        speed = -(v + arm * omega)
        jump = (1 + e) * speed / (arm * arm + squared)
        omega, v = omega + arm * jump, v + squared * jump
        y = -(x[i] * sine + height * lift)
        last, impacts = i, impacts + 1
        if i == 0 and speed < 10.0 ** (-9 - len(marks)):
            root = np.sqrt((v * v + squared * omega * omega) / 2 + g * y)
            marks.append((time, root))
            if len(marks) == 2:
                (before, large), (now, small) = marks
                return now + (now - before) / (large / small - 1), impacts


@pytest.mark.skipif(np.finfo(Number).eps > 2e-19, reason="no extended precision here")
def test_the_sum_of_a_body_that_turns_is_the_time_of_all_impacts():
    body = sf.Posture(
        mass=1,
        gyration_radius=0.2,
        center_of_mass=(0, 0.02),
        contacts=[sf.Contact(point=(-0.5, 0)), sf.Contact(point=(0.52, 0))],
        restitution=0.9997,
    )
    q, qdot = (0.0089, 0.0178), (0.118, -1.4765)
    run = sf.simulate(body, (0, *q), (0, *qdot), stop="zeno")
    assert run.collisions < 20_000
    (zeno,) = run.zeno_points
    assert (zeno.kind, zeno.method, zeno.certified) == ("2-zeno", "self-similar", False)
    time, impacts = time_until_body_rests((-0.5, 0.52), 0.02, 0.2, 0.9997, q, qdot)
    assert impacts > 150_000
    assert abs(float(run.elapsed - time)) < 2e-14 * run.elapsed
    assert abs(float(run.elapsed - time)) < 10 * zeno.time_error
