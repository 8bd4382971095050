"""Round contacts: discs that roll, slide, bounce and rock, against closed forms, quadratures and independent integrations.

Of a disc of radius R about a point of the body on ground with normal n and tangent t, with the arm p of its centre: b = t·p, C = n·p, and
c = C − R is the arm of the touching point, whose speed is v_t = t·ṙ − c θ̇. Under the gap is the centre: h = n·(centre) − R.
"""

import itertools
import math
import pickle
from fractions import Fraction

import numpy as np
import pytest
import standfast as sf
from modes_oracle import Problem, brute_force
from scipy.integrate import quad, solve_ivp

LAWS = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
#: A hundred roundings of a double, for states of order one.
ROUNDED = 1e-13


def states_at(run, times):
    q, v = run.at(np.array(times))
    return np.hstack([q, v])


# ---------------------------------------------------------------- rolling and sliding


@pytest.mark.parametrize("friction", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("slope", [0.2, 0.5, 0.9, 1.2])
def test_a_disc_on_a_slope_rolls_or_slides(slope, friction):
    """It rolls iff tan α ≤ 3μ, with a = (2/3) g sin α; else a = g(sin α − μ cos α) and θ̈ = −μ g cos α R/ρ²."""
    radius, g, times = 0.1, 9.81, np.array([0.3, 1.0, 1.7])
    disc = sf.Posture.disc(radius, friction=friction, slope=-slope, gravity=g)
    run = sf.simulate(disc, (0, 0, 0), (0, 0, 0), time_limit=2.0, model="full")
    rolls = math.tan(slope) <= 3 * friction
    assert {phase.mode for phase in run.phases} == {"F" if rolls else "R"}
    if rolls:
        a = 2 / 3 * g * math.sin(slope)
        spin = -a / radius
    else:
        a = g * (math.sin(slope) - friction * math.cos(slope))
        spin = -friction * g * math.cos(slope) * radius / (radius**2 / 2)
    way = 0.5 * times**2
    q = np.stack([a * way * math.cos(slope), -a * way * math.sin(slope), spin * way])
    v = np.stack(
        [a * times * math.cos(slope), -a * times * math.sin(slope), spin * times]
    )
    np.testing.assert_allclose(
        states_at(run, times), np.hstack([q.T, v.T]), rtol=1e-13, atol=ROUNDED
    )
    endless = sf.simulate(disc, (0, 0, 0), (0, 0, 0))
    assert (endless.outcome, endless.time) == ("sliding", 0.0)
    # The acceleration of the endless motion.
    expected = [a * math.cos(slope), -a * math.sin(slope), spin]
    np.testing.assert_allclose(endless.acceleration, expected, rtol=1e-13)


@pytest.mark.parametrize("omega", [5.0, 30.0, -20.0])
def test_backspin(omega):
    """It slides for |v + Rω|/(3μg), then rolls with v = (2/3)(v_0 − Rω_0/2): back iff Rω_0/2 > v_0."""
    radius, mu, g, speed = 0.1, 0.3, 9.81, 1.0
    disc = sf.Posture.disc(radius, friction=mu, gravity=g)
    run = sf.simulate(disc, (0, 0, 0), (speed, 0, omega), time_limit=5.0)
    slides, rolls = run.phases
    assert (slides.mode, rolls.mode) == (
        "R" if speed + radius * omega > 0 else "L",
        "F",
    )
    assert rolls.start == pytest.approx(
        abs(speed + radius * omega) / (3 * mu * g), rel=1e-14
    )
    final = (speed - radius / 2 * omega) / 1.5
    np.testing.assert_allclose(
        run.qdot, [final, 0, -final / radius], rtol=1e-13, atol=ROUNDED
    )
    assert (final < 0) == (radius * omega / 2 > speed)
    # Rolling for ever is an endless slide, with the letter F.
    endless = sf.simulate(disc, (0, 0, 0), (speed, 0, omega))
    assert (endless.outcome, endless.phases[-1].mode) == ("sliding", "F")


@pytest.mark.parametrize("friction", [0.05, 0.4])
def test_an_eccentric_disc_slides_and_rolls_like_its_equations(friction):
    """Slope 0.3; the centre of mass is 0.04 off the centre of the disc. Integration of the equations of each mode (DOP853, rtol 1e-12);
    the run says when the mode changes, and force and speed are then at their limits."""
    radius, off, rho, g, slope = 0.2, 0.04, 0.15, 9.81, -0.3
    t, n = (
        np.array([math.cos(slope), math.sin(slope)]),
        np.array([-math.sin(slope), math.cos(slope)]),
    )
    center = radius * n
    body = sf.Posture(
        mass=1.0,
        gyration_radius=rho,
        center_of_mass=(center[0] + off, center[1]),
        contacts=[sf.Contact((0, 0), slope=slope, friction=friction, radius=radius)],
        restitution=0.0,
        gravity=g,
    )

    def rates(state, mode):
        turn = state[2]
        arm = -off * np.array([math.cos(turn), math.sin(turn)])
        b, high = t @ arm, n @ arm
        c, omega = high - radius, state[5]
        # n·a + b θ̈ = C ω² and, if it rolls, t·a − c θ̈ = b ω²; a = fall + n λ + t τ, ρ²θ̈ = b λ − c τ
        normal, along = (
            np.array([1 + b * b / rho**2, -b * c / rho**2]),
            np.array([-b * c / rho**2, 1 + c * c / rho**2]),
        )
        right = np.array([high * omega**2 + g * n[1], b * omega**2 + g * t[1]])
        if mode == "F":
            load, rub = np.linalg.solve(np.array([normal, along]), right)
        else:
            push = {"R": -friction, "L": friction}[mode]
            load = right[0] / (normal[0] + push * normal[1])
            rub = push * load
        force = n * load + t * rub
        change = [force[0], force[1] - g, (b * load - c * rub) / rho**2]
        return np.array([*state[3:], *change]), (load, rub), t @ state[3:5] - c * omega

    run = sf.simulate(body, (0, 0, 0), (0, 0, 0), time_limit=1.0, model="full")
    state = np.zeros(6)
    for phase in run.phases:
        _, (load, rub), slip = rates(state, phase.mode)
        assert load > 0
        if phase.mode == "F":
            assert abs(slip) < 1e-10  # of the integration
            assert abs(rub) <= friction * load * (1 + 1e-9)
        else:
            assert slip * {"R": 1, "L": -1}[phase.mode] > -1e-10
        solved = solve_ivp(
            lambda _, y, mode=phase.mode: rates(y, mode)[0],
            (phase.start, phase.end),
            state,
            method="DOP853",
            rtol=1e-12,
            atol=1e-13,
        )
        state = solved.y[:, -1]
        found = states_at(run, [np.nextafter(phase.end, 0.0)])[0]
        np.testing.assert_allclose(found, state, rtol=1e-9, atol=1e-10)
    assert run.phases[-1].mode == ("R" if friction == 0.05 else "F")


# ---------------------------------------------------------------- bounces


def bounced(times, ceiling):
    """The super ball by exact parabolas: v_n → −e v_n, v_t → −e_t v_t, ΔP = −(1 + e_t) v_t/(1/m + R²/(mρ²)). States at these times,
    with the centre at first at height .9, and the number of bounces before each time."""
    radius, inertia, e, g = 0.1, 0.004, 0.9, 10.0
    x, y, turn, vx, vy, omega, now, count = 0.0, 0.9, 0.0, 1.0, -1.0, 0.0, 0.0, 0
    found, counts = [], []
    for end in times:
        while True:
            down = (vy + math.sqrt(vy * vy + 2 * g * (y - radius))) / g
            side, dt = -1, down
            square = vy * vy - 2 * g * (1 - radius - y)
            if ceiling and vy > 0 and square > 0:
                side, dt = 1, (vy - math.sqrt(square)) / g
            if now + dt > end:
                break
            now, x, turn = now + dt, x + vx * dt, turn + omega * dt
            y = radius if side < 0 else 1 - radius
            vy = -e * (vy - g * dt)
            push = -(1 + e) * (vx - side * radius * omega) / (1 + radius**2 / inertia)
            vx, omega, count = (
                vx + push,
                omega - side * radius * push / inertia,
                count + 1,
            )
        dt = end - now
        found.append(
            [
                x + vx * dt,
                y + vy * dt - 0.5 * g * dt**2 - 0.1,
                turn + omega * dt,
                vx,
                vy - g * dt,
                omega,
            ]
        )
        counts.append(count)
    return np.array(found), counts


@pytest.mark.parametrize("ceiling", [False, True])
def test_super_ball(ceiling):
    """m = 1, R = .1, mρ² = .004, μ = 1, e = e_t = .9 under Moreau's law, on a floor and between floor and table."""
    terrain = [(-50, 0), (50, 0), (50, 1), (-50, 1)] if ceiling else None
    ball = sf.Posture.disc(
        0.1,
        gyration_radius=math.sqrt(0.004),
        friction=1.0,
        restitution=0.9,
        tangential_restitution=0.9,
        gravity=10.0,
        terrain=terrain,
    )
    end = (
        7.6975 if not ceiling else 3.0
    )  # of 7.734 s with infinitely many bounces on the floor
    run = sf.simulate(
        ball, (0, 0.8, 0), (1, -1, 0), impact="moreau", time_limit=end, model="full"
    )
    times = np.linspace(0.05, end - 1e-3, 40)
    expected, counts = bounced(times, ceiling)
    # Each bounce divides small gaps of time by e: at most 1e-16 · 0.9⁻⁵⁰ = 2e-14 of the speed of 4 m/s.
    np.testing.assert_allclose(states_at(run, times), expected, rtol=1e-11, atol=1e-11)
    assert counts[-1] >= (50 if not ceiling else 5)
    assert run.collisions >= counts[-1]


# ---------------------------------------------------------------- rocking


def half_disc():
    """A half disc that rocks on its round side, with friction enough to roll."""
    radius = 0.2
    off = 4 * radius / (3 * math.pi)
    body = sf.Posture(
        mass=1.0,
        gyration_radius=math.sqrt(radius**2 / 2 - off**2),
        center_of_mass=(0.0, radius - off),
        contacts=[sf.Contact((0, 0), friction=2.0, radius=radius)],
        restitution=0.0,
    )
    return body, radius, off


def rocking_period(amplitude):
    """Quadrature of the energy: ½ I(θ) θ̇² = g δ (cos θ − cos A), I = ρ² + δ² sin² θ + (R − δ cos θ)²; θ = A sin s."""
    body, radius, off = half_disc()

    def rate(s):
        angle = amplitude * math.sin(s)
        inertia = (
            body.gyration_radius**2
            + (off * math.sin(angle)) ** 2
            + (radius - off * math.cos(angle)) ** 2
        )
        # A − A sin s = 2 A sin²(π/4 − s/2), without cancellation
        lower = amplitude * math.sin(0.25 * math.pi - 0.5 * s) ** 2
        fall = (
            2
            * body.gravity
            * off
            * math.sin(0.5 * (amplitude + angle))
            * math.sin(lower)
        )
        return math.sqrt(inertia / (2 * fall)) * amplitude * math.cos(s)

    return 4 * quad(rate, 0, math.pi / 2, epsabs=1e-13, epsrel=1e-12, limit=400)[0]


@pytest.mark.parametrize("amplitude", [0.01, 0.3, 1.0, 1.3])
def test_a_half_disc_rocks_with_the_period_of_its_energy(amplitude):
    body, radius, off = half_disc()
    q = (
        -radius * amplitude + off * math.sin(amplitude),
        off * (1 - math.cos(amplitude)),
        amplitude,
    )
    period = rocking_period(amplitude)
    run = sf.simulate(body, q, (0, 0, 0), time_limit=2 * period, model="full")
    assert {phase.mode for phase in run.phases} == {"F"}
    for k in (1, 2):  # the quadrature is accurate to 1e-12, of about 1 s
        found = states_at(run, [k * period])[0]
        np.testing.assert_allclose(found, [*q, 0, 0, 0], atol=2e-11)
    np.testing.assert_allclose(
        run.energy(np.linspace(0, run.time, 50)), run.energy(0.0), rtol=1e-13
    )
    # It rolls without slip: the touching point follows from the angle.
    turns = run.at(np.linspace(0, run.time, 20))[0][:, 2]
    touching = run.points_at(np.linspace(0, run.time, 20))[:, 0]
    np.testing.assert_allclose(
        touching, np.stack([-radius * turns, 0 * turns], 1), atol=1e-13
    )
    # Without a time limit its motion repeats for ever.
    assert sf.simulate(body, q, (0, 0, 0)).outcome == "sliding"


def test_the_period_of_small_swings():
    """2π√((ρ² + (R − δ)²)/(gδ)), with a difference of second order."""
    body, radius, off = half_disc()
    small = (
        2
        * math.pi
        * math.sqrt(
            (body.gyration_radius**2 + (radius - off) ** 2) / (body.gravity * off)
        )
    )
    one, two = (rocking_period(a) / small - 1 for a in (0.02, 0.01))
    assert 0 < two < 1e-4
    assert one / two == pytest.approx(4.0, rel=1e-3)


def test_a_wheel_rolls_over_the_whole_turn():
    """An eccentric wheel that is fast enough rolls for ever on level ground; its energy decides."""
    radius, off = 0.3, 0.1
    wheel = sf.Posture(
        1.0,
        0.25,
        (0.0, radius - off),
        [sf.Contact((0, 0), friction=5.0, radius=radius)],
        0.0,
    )
    # At the lowest position: ½(ρ² + (R − δ)²) ω² against 2 g δ.
    limit = math.sqrt(4 * 9.81 * off / (0.25**2 + (radius - off) ** 2))
    for factor, turns in ((0.999, False), (1.001, True)):
        omega = factor * limit
        run = sf.simulate(
            wheel,
            (0, 0, 0),
            (-(radius - off) * omega, 0, omega),
            time_limit=5.0,
            model="full",
        )
        assert ("S" in {p.mode for p in run.phases}) is False
        assert (run.q[2] > math.pi) == turns
        endless = sf.simulate(wheel, (0, 0, 0), (-(radius - off) * omega, 0, omega))
        assert endless.outcome == "sliding"


# ---------------------------------------------------------------- terrain


def test_a_disc_that_rolls_into_a_wall_stops_there():
    """Without restitution the wall takes its speed; its spin ends by friction on floor and wall."""
    box = [(-2, 3), (-2, 0), (2, 0), (2, 3)]
    disc = sf.Posture.disc(0.5, friction=0.4, terrain=box)
    run = sf.simulate(disc, (0, 0, 0), (1, 0, -2), impact="poisson")
    assert run.outcome == "rest"
    np.testing.assert_allclose(run.q[:2], [1.5, 0.0], atol=1e-13)
    np.testing.assert_allclose(run.gaps, [0.0], atol=1e-13)


def test_a_spinning_disc_in_a_groove_is_stopped_by_both_sides():
    """A right-angled groove: N_l = N_r·(1 + μ)/(1 − μ) for clockwise spin; ρ²θ̈ = μR(N_l + N_r)."""
    mu, radius, g, omega = 0.2, 0.3, 9.81, -10.0
    rho2 = radius**2 / 2
    groove = [(-3, 3), (0, 0), (3, 3)]
    at = (radius / math.sqrt(2), radius / math.sqrt(2))
    disc = sf.Posture(
        1.0,
        math.sqrt(rho2),
        (
            at[0] - radius * math.sin(math.pi / 4),
            at[1] + radius * math.cos(math.pi / 4),
        ),
        [sf.Contact(at, friction=mu, radius=radius)],
        0.0,
        terrain=groove,
    )
    run = sf.simulate(disc, (0, 0, 0), (0, 0, omega))
    # Along n_l and n_r: N_l + μ N_r = N_r − μ N_l = g cos 45° up to the side to which it spins.
    load = g * math.sqrt(0.5)
    total = (load * (1 + mu) + load * (1 - mu)) / (1 + mu**2)
    assert run.outcome == "rest"
    assert run.time == pytest.approx(-omega * rho2 / (mu * radius * total), rel=1e-12)
    np.testing.assert_allclose(run.q[:2], [0, 0], atol=1e-13)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"outline": [(0, 0), (1, 0), (0, 1)]},
            r"outline = .* contacts.1.radius = 0.1 > 0",
        ),
    ],
)
def test_what_a_disc_does_not_fit(change, message):
    with pytest.raises(ValueError, match=message):
        sf.Posture(
            1.0,
            0.1,
            (-1.0, 1.0),
            [sf.Contact(center=(-1.0, 0.7), radius=0.1)],
            0.0,
            **change,
        )


SHAFT = [(-0.4, 5), (-0.4, -1), (1.9, -1), (1.9, 5)]


def test_a_disc_that_does_not_touch_needs_its_center():
    """A ball 2 m above the floor of a shaft, nearest to its left wall: it does not spin after it has met a wall."""
    radius = 0.25
    with pytest.raises(ValueError, match=r"contacts.1.point .* which is 0.4 m away"):
        sf.Posture(1, 0.2, (0, 1), [sf.Contact((0, 0.75), radius=radius)], 0.9, terrain=SHAFT)  # fmt: skip
    contact = sf.Contact(center=(0, 1), radius=radius)
    assert contact.point == (0, 0.75)
    ball = sf.Posture(1, 0.2, (0, 1), [contact], 0.9, gravity=0, terrain=SHAFT)
    assert ball.contacts[0].point == pytest.approx((-radius, 1))
    assert ball.gaps((0, 0, 0)) == pytest.approx([0.4 - radius])
    run = sf.simulate(ball, (0.1, 0.5, 0), (2, 0, 0), time_limit=1.5)
    assert run.impacts["time"][0] == pytest.approx((1.9 - radius - 0.1) / 2)
    assert run.qdot == pytest.approx([-1.8, 0, 0])
    again = pickle.loads(pickle.dumps(ball))
    assert again == ball
    assert again.contacts[0].center == (0, 1)
    assert "center=(0.0, 1.0)" in repr(contact)
    scene = sf.Scene(ball, q=(0, 0.5, 0), qdot=(0, 0, 0))
    assert sf.Scene.from_json(scene.to_json()).posture == ball
    wrong = scene.to_json().replace(f'"radius": {radius}', '"radius": 0.5')
    with pytest.raises(ValueError, match=r"center = .* 0.25 m away"):
        sf.Scene.from_json(wrong)
    on_a_line = sf.Posture(1, 0.2, (0, 1), [contact], 0.9)
    radii = sf.sweep(on_a_line, {"contacts.1.radius": [0.25, 0.35]}, "stability")
    assert radii.sizes == {"contacts.1.radius": 2}  # about the same centre


def test_a_disc_on_a_terrain_is_swept():
    disc = sf.Posture.disc(0.3, terrain=[(-5, 0), (5, 0)])
    alone = sf.stability(disc).frictional_stability
    for path, values in {"mass": [1, 2], "contacts.1.friction": [0.2, 0.3]}.items():
        assert set(sf.sweep(disc, {path: values}, "stability")["stability"].values) == {alone}  # fmt: skip


def test_a_center_is_a_radius_away():
    with pytest.raises(ValueError, match=r"center = \(0.0, 1.0\) .*1.0 m away"):
        sf.Contact((0, 0), radius=0.5, center=(0, 1))
    with pytest.raises(ValueError, match=r"center = .*radius = 0.0 m > 0"):
        sf.Contact((0, 0), center=(0, 0))
    with pytest.raises(TypeError, match="point"):
        sf.Contact()
    assert sf.Contact((0, 0.5), radius=0.5, center=(0, 1)).center == (0, 1)


@pytest.mark.parametrize("radius", [-0.1, math.inf, math.nan, 1e76])
def test_radii_out_of_range(radius):
    with pytest.raises(ValueError, match=r"radius = .*0 <= radius <= 1e75, in m"):
        sf.Contact((0, 0), radius=radius)


def test_shared_ground_is_below_the_lowest_point():
    """The lower disc touches; the gap of the higher one is that of its lowest point."""
    discs = [sf.Contact((-0.5, 0.0), radius=0.2), sf.Contact((0.5, 0.1), radius=0.3)]
    body = sf.Posture(1.0, 0.3, (0.0, 0.5), discs, 0.0, ground="shared")
    np.testing.assert_allclose(body.gaps((0, 0, 0)), [0.0, 0.1], atol=1e-16)
    turned = body.gaps((0, 0, 0.2))
    s, c = math.sin(0.2), math.cos(0.2)
    centers = [(-0.5, -0.3), (0.5, -0.1)]  # from the centre of mass
    np.testing.assert_allclose(
        turned,
        [
            0.5 + x * s + y * c - r
            for (x, y), r in zip(centers, (0.2, 0.3), strict=True)
        ],
    )


# ---------------------------------------------------------------- limits and relations


def feet(radius, friction=0.6, restitution=0.3):
    """A body on two rounded feet."""
    contacts = [
        sf.Contact((-0.5, 0.0), slope=0.1, friction=friction, radius=radius),
        sf.Contact((0.5, 0.0), slope=-0.2, friction=friction, radius=radius),
    ]
    return sf.Posture(1.0, 0.4, (0.05, 0.6), contacts, restitution)


def test_statics_and_frozen_rows_are_those_of_the_touching_points():
    sharp, round_ = feet(0.0), feet(0.07)
    assert (sharp.psi, sharp.phi) == (round_.psi, round_.phi)
    assert sf.equilibrium_region(sharp) == sf.equilibrium_region(round_)
    one, two = sf.static_forces(sharp), sf.static_forces(round_)
    np.testing.assert_allclose(one, two, rtol=1e-12)
    one, two = sf.stability(sharp), sf.stability(round_)
    assert (one.frictional_stability, one.by) == (two.frictional_stability, two.by)


@pytest.mark.parametrize("impact", ["newton", "poisson"])
def test_rounded_feet_tend_to_sharp_ones(impact):
    """The difference of the motions is of first order in the radius."""
    q, v = (0.0, 0.05, 0.02), (0.3, 0.0, -0.4)
    times = [0.09, 0.1, 0.109, 0.13, 0.145]  # not within 1e-4 s of an impact

    def motion(radius):
        body = feet(radius)
        run = sf.simulate(body, q, v, impact=impact, time_limit=0.3, model="full")
        return states_at(run, times), run.collisions

    sharp, hits = motion(0.0)
    found = [motion(radius) for radius in (4e-4, 2e-4, 1e-4)]
    assert hits > 3
    errors = [np.abs(state - sharp).max() for state, _ in found]
    assert errors[0] < 0.05
    for one, two in itertools.pairwise(errors):
        assert one / two == pytest.approx(2.0, rel=0.05)


def test_local_and_full_motion_agree_to_first_order():
    """Kicks of size s from the posture, with motions of size s² in times s: the angular velocity is of order s, and the relative difference
    of order s²."""
    body = feet(0.2, friction=0.5, restitution=0.2)

    def difference(s):
        end = {}
        for model in ("local", "full"):
            run = sf.simulate(
                body,
                (0.0, 0.02 * s * s, 0.01 * s * s),
                (0.1 * s, 0.05 * s, -0.2 * s),
                impact="poisson",
                time_limit=0.1 * s,
                model=model,
            )
            end[model] = np.array([*run.q / s**2, *run.qdot / s]), run.collisions
        assert end["local"][1] == end["full"][1] > 0
        return np.abs(end["local"][0] - end["full"][0]).max()

    errors = [difference(s) for s in (0.02, 0.01, 0.005)]
    assert errors[0] < 0.05
    for one, two in itertools.pairwise(errors):
        assert one / two == pytest.approx(4.0, rel=0.1)


def random_bodies(count, seed):
    """Random bodies with round and sharp contacts, and a start above the ground."""
    rng = np.random.default_rng(seed)
    bowl = [(-8.0, 4.0), (-2.0, 0.0), (2.0, 0.0), (5.0, 2.0), (5.5, 6.0)]
    for k in range(count):
        n = int(rng.integers(1, 4))
        contacts = []
        for i in range(n):
            x, y = -0.5 + i / max(n - 1, 1) + rng.uniform(-0.1, 0.1), 0.1 * rng.uniform()  # fmt: skip
            friction, radius = float(rng.choice([0.0, 0.2, 0.8])), float(rng.choice([0.0, 0.05, 0.2]))  # fmt: skip
            place = {"center": (x, y + radius), "radius": radius} if radius else {"point": (x, y)}  # fmt: skip
            contacts.append(sf.Contact(**place, friction=friction))
        terrain = {"terrain": bowl} if k % 2 else {"ground": "shared"}
        body = sf.Posture(
            1.0,
            float(rng.uniform(0.2, 0.5)),
            (rng.uniform(-0.3, 0.3), rng.uniform(0.3, 0.8)),
            contacts,
            float(rng.choice([0.0, 0.4])),
            **terrain,
        )
        yield (
            body,
            (0.0, float(rng.uniform(0.3, 1.0)), 0.0),
            rng.uniform(-1, 1, 3) * (2, 2, 6),
        )


@pytest.mark.parametrize("law", LAWS[1:4])
def test_energy_never_rises_and_no_disc_enters_the_ground(law):
    """Newton's law with friction in sliding, and Moreau's law with e_t ≠ e, may gain energy."""
    for body, q, v in random_bodies(24, 5):
        run = sf.simulate(
            body, q, v, impact=law, time_limit=2.0, model="full", event_limit=20000,
            simultaneous="first-contact-first",
        )  # fmt: skip
        times = np.linspace(0, run.time, 120)
        energy = run.energy(times)
        assert np.diff(energy).max() <= 1e-11 * np.abs(energy).max(), (body, law)
        for state, gaps in zip(run.at(times)[0], run.gaps_at(times), strict=True):
            exact = body.gaps(state)
            known = np.isfinite(exact) & np.isfinite(gaps)
            np.testing.assert_allclose(exact[known], gaps[known], atol=1e-11)
            assert exact.min() >= -1e-11


def test_a_batch_has_the_bits_of_single_runs():
    for body, q, _ in random_bodies(4, 8):
        speeds = np.random.default_rng(1).uniform(-2, 2, (6, 3))
        many = sf.simulate_many(
            body, np.tile(q, (6, 1)), speeds, impact="poisson", time_limit=1.0,
            simultaneous="first-contact-first",
        )  # fmt: skip
        for k, v in enumerate(speeds):
            one = sf.simulate(
                body,
                q,
                v,
                impact="poisson",
                time_limit=1.0,
                simultaneous="first-contact-first",
            )
            assert (one.q.tolist(), one.qdot.tolist()) == (
                many.q[k].tolist(),
                many.qdot[k].tolist(),
            )


def test_contact_modes_are_those_of_brute_force():
    """The problem of a moving body with round contacts, set up here in rational numbers: arms of the touching points, and the curvature
    −(b, C) ω² of the centres."""
    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(200):
        center = [float(x) for x in rng.integers(-8, 9, 2) / 16 + (0.0, 1.0)]
        contacts = [
            sf.Contact((x, 0.0), friction=float(rng.choice([0.25, 1.0])), radius=radius)
            for x, radius in zip(
                (-0.5, 0.5), rng.choice([0.25, 0.5, 0.0], 2), strict=True
            )
        ]
        body = sf.Posture(1.0, 0.5, tuple(center), contacts, 0.0, gravity=8.0)
        omega = 0.0  # two contacts on one floor
        speed = float(rng.choice([-1.0, 0.0, 1.0]))
        if rng.random() < 0.5:  # on one foot, it may turn
            body, contacts = (
                sf.Posture(1.0, 0.5, tuple(center), contacts[:1], 0.0, gravity=8.0),
                contacts[:1],
            )
            omega = float(rng.choice([-2.0, 2.0]))
        arms, bias = [], []
        for contact in contacts:
            b, c = (
                Fraction(x) - Fraction(y)
                for x, y in zip(contact.point, center, strict=True)
            )
            arms.append((b, c))
            high = c + Fraction(contact.radius)
            bias.append((-b * Fraction(omega) ** 2, -high * Fraction(omega) ** 2))
        slip = Fraction(speed) - arms[0][1] * Fraction(omega)
        problem = Problem(
            mass=Fraction(1),
            rho2=Fraction(1, 4),
            arms=tuple(arms),
            tangents=((Fraction(1), Fraction(0)),) * len(arms),
            friction=tuple(Fraction(c.friction) for c in contacts),
            sliding=((slip > 0) - (slip < 0),) * len(arms),
            bias=tuple(bias),
            free_acceleration=(Fraction(0), Fraction(-8), Fraction(0)),
        )
        # The velocity keeps the gap: ẏ = −b ω.
        v = (speed, float(-arms[0][0]) * omega, omega)
        modes = sf.contact_modes(body, (0, 0, 0), v)
        words = brute_force(problem)
        assert set(modes.consistent) == words, (body, v)
        seen |= words
    assert {"F", "R", "L"} <= {word for word in seen if len(word) == 1}


# ---------------------------------------------------------------- face


def test_a_round_contact_is_printed_compared_and_pickled():
    contact = sf.Contact((1.0, 2.0), friction=0.5, radius=0.25)
    assert repr(contact).endswith("friction=0.5, radius=0.25)")
    assert eval(repr(contact), {"Contact": sf.Contact}) == contact
    assert pickle.loads(pickle.dumps(contact)) == contact
    assert contact != sf.Contact((1.0, 2.0), friction=0.5)
    assert sf.Contact((0, 0)).radius == 0.0


def test_a_solid_disc():
    disc = sf.Posture.disc(radius=0.3, slope=0.4, friction=0.2)
    assert disc.gyration_radius == pytest.approx(0.3 / math.sqrt(2), rel=1e-15)
    assert disc.center_of_mass == (0.3 * -math.sin(0.4), 0.3 * math.cos(0.4))
    ring = sf.Posture.disc(radius=0.3, gyration_radius=0.3)
    assert (ring.gyration_radius, ring.center_of_mass) == (0.3, (0.0, 0.3))
    bowl = sf.Posture.disc(radius=0.3, terrain=[(-1, 1), (1, -1), (3, 1)])
    assert bowl.contacts[0].slope == -math.pi / 4
    assert disc.replace(**{"contacts.1.radius": 0.2}).contacts[0].radius == 0.2


def test_points_at_are_the_touching_points():
    disc = sf.Posture.disc(0.1, friction=1.0, slope=-0.2)
    run = sf.simulate(disc, (0, 0, 0), (0, 0, 0), time_limit=1.0)
    q, _ = run.at(0.7)
    center = np.array(disc.center_of_mass) + q[:2]
    np.testing.assert_allclose(
        run.points_at(0.7)[0],
        center - 0.1 * np.array([math.sin(0.2), math.cos(0.2)]),
        atol=1e-15,
    )
    assert abs(run.points_at(0.7)[0] @ (math.sin(0.2), math.cos(0.2))) < 1e-15
