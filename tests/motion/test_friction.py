"""Motion on contacts with friction, compared with closed forms and with the equations of motion to 26 digits."""

import math
import os
import random
from collections import Counter
from decimal import Decimal
from itertools import pairwise

import numpy as np
import pytest
import standfast as sf
from bodies import feet_on_slope, frame
from checks import close
from friction_oracle import DIGITS, Body, integrate, precise
from mpmath import mp, mpf

G = 9.81
#: Step of the oracle, in s.
STEP = Decimal(1) / 64


@pytest.fixture(autouse=True)
def digits():
    """Digits of the oracles."""
    with mp.workdps(DIGITS), precise():
        yield


def words(run):
    return [phase.mode for phase in run.phases]


# --- a block on a slope -------------------------------------------------------------------------------------------

FEET = (-0.5, 0.25)  # along the slope, from the point below the centre of mass
HEIGHT = 0.4


def block(slope, friction, feet=FEET, height=HEIGHT):
    """A block of 2 kg on two feet on one slope: its centre of mass is above the point between them."""
    return sf.Posture(
        mass=2.0,
        gyration_radius=0.3,
        center_of_mass=height * frame(slope)[1],
        contacts=feet_on_slope(slope, feet, friction),
        restitution=0.3,
        gravity=G,
    )


def normal_forces(slope, friction, way):
    """Normal forces of a block that slides along ``way``: f_1 + f_2 = m g cos β, and no moment about the centre of mass."""
    (a, b), (mu, nu) = FEET, friction
    # a f_1 + b f_2 + H f_t = 0 with f_t = −way (μ f_1 + ν f_2)
    one, two = a - way * HEIGHT * mu, b - way * HEIGHT * nu
    load = 2 * G * mp.cos(slope)
    return load * two / (two - one), -load * one / (two - one)


@pytest.mark.parametrize("model", ["full", "local"])
@pytest.mark.parametrize("speed", [1.5, -0.7])
@pytest.mark.parametrize(
    ("slope", "friction"),
    [(0.0, (0.4, 0.3)), (0.3, (0.4, 0.5)), (-0.3, (0.2, 0.25)), (0.45, (0.6, 0.1))],
)
def test_a_block_slides_and_stays_or_goes_on(model, speed, slope, friction):
    """Constant deceleration by forces from moments; then it rests, slides back, or never stops."""
    body = block(slope, friction)
    velocity = (speed * math.cos(slope), speed * math.sin(slope), 0.0)
    way = 1 if speed > 0 else -1
    f = normal_forces(slope, friction, way)
    assert min(f) > 0
    mode = sf.contact_modes(body, (0, 0, 0), velocity)["RR" if way > 0 else "LL"]
    for i in (0, 1):
        close(mode.forces[i][1], f[i])
        close(mode.forces[i][0], -way * friction[i] * f[i])

    rub = (friction[0] * f[0] + friction[1] * f[1]) / 2
    slowing = rub + way * G * mp.sin(slope)
    run = sf.simulate(body, (0, 0, 0), velocity, model=model)
    if slowing > 0:
        # where the rounded initial velocity has a component into the slope, a bounce of 1e-17 s comes first
        phase = next(p for p in run.phases if p.mode != "SS")
        stop = abs(mpf(speed)) / slowing
        close(phase.end, stop)
        q, qdot = run.at(phase.end)
        way_to_go = mpf(speed) * stop / 2
        along = q[0] * math.cos(slope) + q[1] * math.sin(slope)
        close(along, way_to_go)
        assert np.abs(qdot).max() <= 1e-15 * abs(speed)
        assert np.abs(body.gaps(q)).max() <= 1e-15
        half = run.at(phase.end / 2)[1]
        close(math.hypot(half[0], half[1]), abs(mpf(speed)) / 2)
    down = -1 if slope > 0 else 1
    f = normal_forces(slope, friction, down)
    pull = G * abs(mp.sin(slope)) - (friction[0] * f[0] + friction[1] * f[1]) / 2
    if pull <= 0:
        assert run.outcome == "rest"
        assert words(run)[-1] == "FF"
    else:
        assert run.outcome == "sliding"
        assert words(run)[-1] == ("RR" if down > 0 else "LL")
        a = run.acceleration
        close(a[0] * math.cos(slope) + a[1] * math.sin(slope), down * pull)
        assert a[2] == 0


@pytest.mark.parametrize("slope", [0.0, 0.2])
def test_a_sliding_block_tips_over_its_front_foot(slope):
    """The rear foot is unloaded where the friction force of the front foot passes through the centre of mass: μ H = b."""
    threshold = FEET[1] / HEIGHT
    velocity = (math.cos(slope), math.sin(slope), 0.0)
    for factor, word in [(1 - 1e-9, "RR"), (1 + 1e-9, "SR")]:
        body = block(slope, (0.3, threshold * factor))
        assert sf.contact_modes(body, (0, 0, 0), velocity).consistent == [word]
        run = sf.simulate(body, (0, 0, 0), velocity, time_limit=1e-3)
        assert words(run)[0] == word


# --- one fixed contact --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("omega", [0.5, 3.0, -6.0])
def test_a_hanging_body_swings_like_a_physical_pendulum(omega):
    """θ = 2 asin(k sn(Ωt, k)), Ω² = gL/(ρ² + L²), k = ω_0/(2Ω); the period is 4K(k)/Ω."""
    length, rho = 0.5, 0.3
    body = sf.Posture(
        mass=1.5,
        gyration_radius=rho,
        center_of_mass=(0, 0),
        contacts=[sf.Contact(point=(0, length), friction=50)],
        restitution=0.3,
        gravity=G,
    )
    start = (length * omega, 0, omega)
    run = sf.simulate(body, (0, 0, 0), start, model="full", time_limit=20.0)
    assert run.outcome == "time-limit"
    assert words(run) == ["F"]
    rate = mp.sqrt(G * mpf(length) / (mpf(rho) ** 2 + mpf(length) ** 2))
    k = mpf(omega) / (2 * rate)
    period = 4 * mp.ellipk(k * k) / rate
    turn = 2 * mp.asin(abs(k))
    sign = 1 if omega > 0 else -1
    for n in range(1, int(80 / period)):
        t = float(n * period / 4)
        q, qdot = run.at(t)
        angle = sign * [0, turn, 0, -turn][n % 4]
        close(q[2], angle, 1e-13 * n, scale=turn)
        spin = omega * [1, 0, -1, 0][n % 4]
        close(qdot[2], spin, 1e-13 * n, scale=abs(omega))
    times = np.linspace(0, 20, 301)
    for t in times[::30]:
        angle = 2 * mp.asin(k * mp.ellipfun("sn", rate * mpf(t), k=k))
        close(run.at(t)[0][2], angle, 1e-12, scale=turn)
    energy = run.energy(times)
    assert np.abs(energy - energy[0]).max() <= 1e-13 * energy[0]
    q, _ = run.at(times)
    # Drift of the pivot is corrected beyond 2 eps of the distances, 2L and L; q itself is rounded.
    eps = np.finfo(float).eps
    assert np.abs([body.gaps(x) for x in q]).max() <= 2 * eps * 3 * length + 4 * eps


# --- one sliding contact ------------------------------------------------------------------------------------------

SLIDERS = [
    # slope, friction, x_1, centre of mass, ρ, sliding speed, spin
    (0.0, 0.3, (0.1, 0.0), (0.0, 0.5), 0.4, 1.0, 0.8),
    (0.2, 0.5, (-0.2, 0.1), (0.0, 0.6), 0.5, -1.5, -1.2),
    (-0.4, 0.8, (0.05, 0.0), (0.0, 0.3), 0.2, 0.6, 2.5),
    (0.1, 0.1, (0.3, 0.0), (0.1, 0.4), 0.3, 3.0, -2.0),
]


def slider(slope, friction, point, centre, rho, slip, omega, other=None):
    """A body that slides on contact 1, and its velocity."""
    contacts = [sf.Contact(point=point, slope=slope, friction=friction)]
    if other:
        contacts.append(other)
    body = sf.Posture(
        mass=1.2,
        gyration_radius=rho,
        center_of_mass=centre,
        contacts=contacts,
        restitution=0.2,
        gravity=G,
    )
    dx, dy = point[0] - centre[0], point[1] - centre[1]
    t = (math.cos(slope), math.sin(slope))
    v = (slip * t[0] + omega * dy, slip * t[1] - omega * dx)
    return body, (*v, omega)


def assert_state(run, t, y, rel=1e-12):
    """Compares the state of a run at time t with the oracle's."""
    q, qdot = run.at(t)
    lengths = max(1, *(abs(float(x)) for x in y[:3]))
    speeds = max(1, *(abs(float(v)) for v in y[3:]))
    for k in range(3):
        close(q[k], y[k], rel, scale=lengths)
        close(qdot[k], y[3 + k], rel, scale=speeds)


@pytest.mark.parametrize("scene", SLIDERS)
def test_one_contact_slides_to_a_stop(scene):
    """Newton and Euler's equations to 26 digits, until the point stops or its force becomes zero."""
    posture, velocity = slider(*scene)
    run = sf.simulate(posture, (0, 0, 0), velocity, model="full", time_limit=2.0)
    word = "R" if scene[5] > 0 else "L"
    index = words(run).index(word)
    assert run.phases[index].start < 1e-15
    body = Body(posture)
    start = [Decimal(0)] * 3 + [Decimal(v) for v in velocity]
    t, y, event = body.until(word, start, STEP)
    close(run.phases[index].end, t, 2e-13)
    assert event[0] == ("lift" if words(run)[index + 1] == "S" else "stop")
    assert_state(run, float(t), y)
    for share in (0.3, 0.7):
        at = float(t) * share
        y = integrate(body.flow(word), start, Decimal(0), Decimal(at), STEP)
        assert_state(run, at, y)


@pytest.mark.parametrize("scene", SLIDERS)
def test_the_square_of_the_spin_obeys_a_linear_equation(scene):
    """With B = b + σμc: (ρ² + bB) dω²/dθ = 2B (g cos β + c ω²). Solved with only the height c of the point above the centre
    and the integrating factor: ω² = I (ω_0² + ∫ 2B g cos β/((ρ² + bB) I) dθ)."""
    slope, mu, point, centre, rho, slip, omega = scene
    posture, velocity = slider(*scene)
    run = sf.simulate(posture, (0, 0, 0), velocity, model="full", time_limit=2.0)
    slide = next(p for p in run.phases if p.mode in "RL")
    t = slide.start + 0.3 * (slide.end - slide.start)
    q, qdot = run.at(t)
    (q0, v0) = run.at(slide.start)
    if qdot[2] * v0[2] <= 0:
        t = slide.start + 0.05 * (slide.end - slide.start)
        q, qdot = run.at(t)
    sigma = 1 if slip > 0 else -1
    cos, sin = mp.cos(slope), mp.sin(slope)
    dx, dy = mpf(point[0]) - mpf(centre[0]), mpf(point[1]) - mpf(centre[1])

    def parts(theta):
        x = mp.cos(theta) * dx - mp.sin(theta) * dy
        y = mp.sin(theta) * dx + mp.cos(theta) * dy
        b, c = cos * x + sin * y, cos * y - sin * x
        arm = b + sigma * mpf(mu) * c
        return 2 * arm / (mpf(rho) ** 2 + b * arm), c

    def exponent(theta):
        return mp.quad(
            lambda s: parts(s)[0] * parts(s)[1],
            [mpf(float(q0[2])), theta],
            method="gauss-legendre",
        )

    end = mpf(float(q[2]))
    inner = mp.quad(
        lambda s: parts(s)[0] * G * cos * mp.exp(-exponent(s)),
        [mpf(float(q0[2])), end],
        method="gauss-legendre",
    )
    square = mp.exp(exponent(end)) * (mpf(float(v0[2])) ** 2 + inner)
    close(qdot[2] ** 2, square, 1e-12, scale=omega**2)


def test_a_sliding_foot_until_the_other_lands():
    """A body tips forward on its sliding rear foot, which comes to rest, until the front foot lands."""
    front = sf.Contact(point=(0.4, -0.15), slope=0.1, friction=0.2)
    scene = (0.0, 0.25, (-0.25, 0.0), (0.0, 0.5), 0.4, 2.0, 1.0)
    posture, velocity = slider(*scene, front)
    # the front foot starts above the terrain: lift the body and rotate it about the rear foot
    theta = 0.25
    s, c = math.sin(theta), math.cos(theta)
    dx, dy = -0.25, -0.5
    q = (dx - (c * dx - s * dy), dy - (s * dx + c * dy), theta)
    arm = (c * dx - s * dy, s * dx + c * dy)
    omega = -0.5
    velocity = (2.0 + omega * arm[1], -omega * arm[0], omega)
    assert abs(posture.gaps(q)[0]) < 1e-16
    run = sf.simulate(posture, q, velocity, model="full", time_limit=2.0)
    body = Body(posture)
    now, t = [Decimal(x) for x in (*q, *velocity)], Decimal(0)
    first = next(k for k, p in enumerate(run.phases) if p.mode != "SS")
    for phase in run.phases[first : first + 4]:
        assert phase.mode[1] == "S"
        dt, now, event = body.until(phase.mode, now, STEP)
        t += dt
        close(phase.end, t, 1e-12)
        if event == ("land", 1):
            break
        assert_state(run, float(t), now)
    assert event == ("land", 1)
    impact = next(i for i in run.impacts if i["contact"] == 2)
    close(impact["time"], t, 1e-12)
    close(impact["rates_before"][1], body.rate(1, now), 1e-12)


# --- both contacts slide ------------------------------------------------------------------------------------------

HALF = 0.5


def ladder(friction, rho=0.3):
    """A ladder in a right-angled V: both ends slide and its centre moves on a circle about the vertex."""
    return sf.Posture(
        mass=1.0,
        gyration_radius=rho,
        center_of_mass=(0, 0),
        contacts=[
            sf.Contact(point=(s * HALF, 0), slope=s * math.pi / 4, friction=friction)
            for s in (-1, 1)
        ],
        restitution=0.0,
        gravity=G,
    )


def sliding_phase(run):
    """The first phase in which both contacts are closed."""
    return next(p for p in run.phases if "S" not in p.mode)


@pytest.mark.parametrize("omega", [2.0, 3.0, -4.0])
def test_a_smooth_ladder_lifts_off(omega):
    """φ̇² = φ̇_0² + 2κ(g/L)(1 − cos φ), κ = L²/(L² + ρ²): time by quadrature up to the angle at which a force becomes zero."""
    run = sf.simulate(
        ladder(0.0),
        (0, 0, 0),
        (HALF * omega, 0, omega),
        model="full",
        time_limit=1.0,
    )
    kappa = mpf(HALF) ** 2 / (mpf(HALF) ** 2 + mpf(0.3) ** 2)
    pull = mpf(G) / mpf(HALF)

    def square(phi):
        return mpf(omega) ** 2 + 2 * kappa * pull * (1 - mp.cos(phi))

    def force(phi):
        # projection of the radial and tangential components on the normal of the remaining wall
        radial = pull * mp.cos(phi) - square(phi)
        return radial * (mp.sin(phi) + mp.cos(phi)) - (1 - kappa) * pull * mp.sin(
            phi
        ) * (mp.cos(phi) - mp.sin(phi))

    off = mp.findroot(force, (mpf("0.01"), mpf("0.7")), solver="anderson", tol=1e-40)
    assert 0 < off < mp.pi / 2
    assert all(force(off * k / 20) > 0 for k in range(20))
    time = mp.quad(lambda phi: 1 / mp.sqrt(square(phi)), [0, off / 2, off])
    phase = sliding_phase(run)
    assert phase.mode == ("RR" if omega > 0 else "LL")
    close(phase.end, time, 1e-12)
    q, qdot = run.at(phase.end)
    close(abs(q[2]), off, 1e-12)
    close(abs(qdot[2]), mp.sqrt(square(off)), 1e-12)
    assert words(run)[words(run).index(phase.mode) + 1] == ("SR" if omega > 0 else "LS")
    for share in (0.25, 0.5, 0.75):
        q, qdot = run.at(share * phase.end)
        phi = mpf(float(q[2]))
        spent = mp.quad(lambda x: 1 / mp.sqrt(square(x)), [0, abs(phi)])
        close(share * phase.end, spent, 1e-12)
        close(abs(q[0]), HALF * mp.sin(abs(phi)), 1e-12)
        close(q[1], HALF * (mp.cos(phi) - 1), 1e-12)
        close(abs(qdot[2]), mp.sqrt(square(phi)), 1e-12)


@pytest.mark.parametrize(
    ("friction", "omega"), [(0.1, 1.5), (0.3, -2.0), (0.05, 2.5), (0.5, 1.0)]
)
def test_a_rough_ladder(friction, omega):
    """The same with friction, by the equations of motion to 26 digits: to lift-off or to a stop."""
    posture = ladder(friction)
    start = (0, 0, 0, HALF * omega, 0, omega)
    run = sf.simulate(posture, start[:3], start[3:], model="full", time_limit=1.0)
    phase = sliding_phase(run)
    body = Body(posture)
    first = [Decimal(x) for x in start]
    t, y, _ = body.until(phase.mode, first, STEP)
    close(phase.end, t, 1e-12)
    q = run.at(phase.end)[0]
    for k in range(3):
        close(q[k], y[k], 1e-12, scale=HALF)
    for share in (0.4, 0.8):
        at = float(t) * share
        y = integrate(body.flow(phase.mode), first, Decimal(0), Decimal(at), STEP)
        assert_state(run, at, y)


# --- frozen geometry ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("speed", "spin"), [(1.0, 20.0), (1.0, 40.0), (2.0, 0.0)])
def test_a_disc_with_backspin_rolls_in_the_end(speed, spin):
    """A ball of 10 cm: it slips for 2(v + Rω)/(7μg) and rolls at (5v − 2Rω)/7."""
    radius, mu = 0.1, 0.2
    disc = sf.Posture(
        mass=1.0,
        gyration_radius=math.sqrt(0.4) * radius,
        center_of_mass=(0, radius),
        contacts=[sf.Contact(point=(0, 0), friction=mu)],
        restitution=0.5,
        gravity=G,
    )
    run = sf.simulate(disc, (0, 0, 0), (speed, 0, spin), model="local")
    assert words(run) == ["R", "F"]
    assert run.outcome == "sliding"
    slip = mpf(speed) + mpf(radius) * mpf(spin)
    time = 2 * slip / (7 * mpf(mu) * mpf(G))
    rolls = (5 * mpf(speed) - 2 * mpf(radius) * mpf(spin)) / 7
    close(run.phases[0].end, time, 1e-15)
    close(run.qdot[0], rolls, 1e-14)
    close(run.qdot[2], -rolls / mpf(radius), 1e-14)
    close(run.q[0], (speed + rolls) * time / 2, 1e-14)
    assert run.q[1] == 0
    assert np.abs(run.acceleration).max() <= 1e-15 * G


# --- rocking ------------------------------------------------------------------------------------------------------


def table(restitution, friction=1.0, half=0.375, height=0.3125, rho=0.5):
    """A body on two level feet whose far foot is lifted by an impact of the other: ρ > half."""
    return sf.Posture(
        mass=1.0,
        gyration_radius=rho,
        center_of_mass=(0, height),
        contacts=[sf.Contact(point=(s * half, 0), friction=friction) for s in (-1, 1)],
        restitution=restitution,
        gravity=G,
    )


def rocking(posture, y, count):
    """A body that rocks from foot to foot, event by event: words, starts and states of the phases, and the times of
    the landings that begin a round."""
    body = Body(posture)
    t, phases, landings, held, word = Decimal(0), [], [], 0, "FS"
    while True:
        phases.append((word, t, y))
        if len(phases) > count:
            return phases, landings
        up, rate = body.gap(1 - held, y), body.rate(1 - held, y)
        scale = max(abs(rate) / body.g, (abs(up) / body.g).sqrt())
        dt, y, event = body.until(word, y, min(STEP, scale / 2))
        t += dt
        if event[0] == "stop":
            word = "".join("F" if k == held else "S" for k in (0, 1))
            _, forces = body.motion(word, y)
            assert abs(forces[held][0]) < body.mu[held] * forces[held][1]
            continue
        assert event == ("land", 1 - held), event
        held = 1 - held
        landings.append(t)
        y = body.hit(held, y)
        assert body.rate(1 - held, y) > 0
        if body.e:
            phases.append(("SS", t, y))
            dt, y = body.bounce(held, y)
            t += dt
        slip = "R" if body.slip(held, y) > 0 else "L"
        word = "".join(slip if k == held else "S" for k in (0, 1))


@pytest.mark.parametrize(
    ("restitution", "friction", "omega"),
    [(0.0, 1.0, 0.625), (0.0, 0.7, -0.25), (0.2, 1.0, 0.5), (0.1, 0.8, 0.375)],
)
def test_rocking_ends_in_rest(restitution, friction, omega):
    """Rotation about one foot, impact of the other, its bounces, slide, rotation about that foot: ever smaller rounds whose
    limit is the Zeno point. The phases are compared with the oracle, the end with the limit of the rounds."""
    posture = table(restitution, friction)
    # Rotation about one foot from upright, in numbers for which the rate at that foot is not rounded.
    side = 1 if omega > 0 else -1
    start = (0, 0, 0, -0.3125 * omega, 0.375 * abs(omega), omega)
    run = sf.simulate(posture, start[:3], start[3:], impact="newton", model="full")
    assert run.outcome == "rest"
    point = run.zeno_points[-1]
    assert (point.kind, point.method) == ("2-zeno", "nested")
    # the remaining velocity is along the floor, and friction stops it
    rest = point.time + abs(point.qdot[0]) / (friction * G)
    close(run.time, mpf(float(rest)))
    got = [p for p in run.phases if p.end > p.start]
    first = [Decimal(x) for x in start]
    if side < 0:  # the oracle begins on foot 1: mirror
        first = [-first[0], first[1], -first[2], -first[3], first[4], -first[5]]
    count = 16 if restitution == 0 else 20
    phases, starts = rocking(posture, first, count)
    mirror = str.maketrans("RL", "LR")
    for k, (word, t, y) in enumerate(phases[:-1]):
        if side < 0:
            word = word[::-1].translate(mirror)
            y = [-y[0], y[1], -y[2], -y[3], y[4], -y[5]]
        end = phases[k + 1][1]
        assert got[k].mode == word
        close(got[k].start, t, 1e-13, scale=run.time)
        if k < 8:
            close(got[k].end - got[k].start, end - t, 1e-11)
        q, qdot = run.at((got[k].start + got[k].end) / 2)
        assert abs(min(posture.gaps(q))) <= 1e-15 or word == "SS"
        if k:
            q, qdot = run.at(got[k].start)
            for i in range(3):
                close(q[i], y[i], 1e-13, scale=0.01)
                close(qdot[i], y[3 + i], 1e-13, scale=abs(omega))
    lengths = [b - a for a, b in pairwise(starts)]
    # every second one, because left and right may have different patterns
    ratios = [b / a for a, b in zip(lengths, lengths[2:], strict=False)]
    changes = [abs(b - a) for a, b in pairwise(ratios)]
    assert 20 * changes[-1] < max(changes)
    assert ratios[-1] < 0.5
    tail = (lengths[-1] + lengths[-2]) * ratios[-1] / (1 - ratios[-1])
    error = tail * changes[-1] / (1 - ratios[-1]) ** 2
    limit = 2 * error + Decimal("1e-14")
    assert abs(Decimal(point.time) - (starts[-1] + tail)) <= limit
    assert error < 1e-9 * run.time


# --- many runs ----------------------------------------------------------------------------------------------------


def random_scene(seed):
    """A body with one or two contacts of any friction near rest on them."""
    random = np.random.default_rng(seed)
    uniform = random.uniform
    points = [(uniform(-0.5, 0.5), uniform(-0.1, 0.1))]
    if seed % 3:
        points = [(s * uniform(0.2, 1), uniform(-0.1, 0.1)) for s in (-1, 1)]
    contacts = [
        sf.Contact(point=p, slope=uniform(-0.5, 0.5), friction=uniform(0, 2))
        for p in points
    ]
    posture = sf.Posture(
        mass=uniform(0.5, 2),
        gyration_radius=uniform(0.2, 0.8),
        center_of_mass=(uniform(-0.2, 0.2), uniform(0.2, 0.8)),
        contacts=contacts,
        restitution=uniform(0, 0.9),
        gravity=G,
    )
    q = (0, 0, 0) if random.integers(2) else (0, uniform(0, 0.05), 0)
    kick = random.choice([0, 0.01, 0.1, 0.5])
    return posture, q, tuple(kick * uniform(-1, 1, 3))


OUTCOMES = {
    "rest",
    "zeno",
    "escape",
    "sliding",
    "time-limit",
    "event-limit",
    "inconsistent",
    "ambiguous",
}


def flaws(posture, run):
    """Violations of the laws of motion in a run of the full model."""
    phases = run.phases if len(run.phases) < 80 else run.phases[:40] + run.phases[-40:]
    times = np.concatenate([np.linspace(p.start, p.end, 5) for p in phases])
    times = np.maximum.accumulate(times)
    q, qdot = run.at(times)
    rho = posture.gyration_radius
    kinetic = 0.5 * posture.mass * (qdot**2 @ [1, 1, rho**2])
    size = 1 + np.abs(q).max(axis=1)
    scale = np.maximum.accumulate(kinetic) + posture.mass * G * size
    found = []
    if (np.diff(run.energy(times)) > 1e-12 * scale[1:]).any():
        found.append("energy rises")
    gaps = np.array([posture.gaps(x) for x in q])
    if (gaps < -1e-12 * size[:, None]).any():
        found.append("in the terrain")
    if (np.abs(gaps - run.gaps_at(times)) > 1e-12 * size[:, None]).any():
        found.append("gaps are not those of q")
    if run.outcome not in OUTCOMES:
        found.append("outcome")
    if run.outcome in ("inconsistent", "ambiguous") and not found:
        expected = {"inconsistent": "none", "ambiguous": "ambiguous"}[run.outcome]
        # The contacts are those of the run: at its rounded q, far away, the body would not touch the ground any more.
        if sf.contact_modes(run.undecided).status != expected:
            found.append("contact modes disagree")
    return found


#: Number of random scenes; `make long` has more.
SCENES = int(os.environ.get("STANDFAST_FRICTION_SCENES", "120"))
#: A body that tumbles down its slope in flights of hours: its gaps have errors of 1e-8 of the height of its fall. And two
#: that swing about one foot for hours, sticking and slipping: the gap of the other foot drifts by 1e-12 m per swing.
FLAWED = {85, 164, 199}


def test_no_run_gains_energy_or_enters_the_terrain():
    """-s prints their outcomes."""
    table, flawed, limited = {}, {}, []
    for seed in range(SCENES):
        posture, q, qdot = random_scene(seed)
        run = sf.simulate(
            posture, q, qdot, impact="newton", model="full", event_limit=20_000
        )
        key = (len(posture.contacts), run.outcome)
        table[key] = table.get(key, 0) + 1
        if run.outcome == "event-limit":
            limited.append((seed, round(run.time, 4)))
        if found := flaws(posture, run):
            flawed[seed] = found
    for (contacts, outcome), count in sorted(table.items()):
        print(f"{contacts} contact(s)  {outcome:14}{count:5}")
    print("event limit (seed, time):", limited)
    print("flawed:", flawed)
    assert set(flawed) <= FLAWED


# --- several modes, or none ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("friction", [1.2, 1.4, 1.6, 2.0])
def test_painleves_rod(friction):
    """A uniform rod slides on its lower end: 1 + 3cos φ (cos φ − μ sin φ) < 0 is possible only for μ > 4/3. A rod with no
    motion except its slide then has no consistent mode; a rod that rotates fast enough has two."""
    seen = set()
    for k in range(1, 30):
        phi = math.pi / 2 * k / 30
        rod = sf.Posture(
            mass=1.0,
            gyration_radius=1 / math.sqrt(3),
            center_of_mass=(math.cos(phi), math.sin(phi)),
            contacts=[sf.Contact(point=(0, 0), friction=friction)],
            restitution=0.0,
            gravity=G,
        )
        mass = 1 + 3 * math.cos(phi) * (math.cos(phi) - friction * math.sin(phi))
        for omega in (0.0, 5.0):
            v = (-2.0 - omega * math.sin(phi), omega * math.cos(phi), omega)
            if rod.gap_rates((0, 0, 0), v)[0] != 0:
                continue  # by rounding an impact or a flight instead of sliding
            # the end lifts off without force: a_n = −g + ω² sin φ with c = −sin φ
            lifts = omega**2 * math.sin(phi) > G
            expected = {
                (True, False): "unique",  # slides
                (True, True): "unique",  # leaves
                (False, False): "none",
                (False, True): "ambiguous",
            }[mass > 0, lifts]
            status = sf.contact_modes(rod, (0, 0, 0), v).status
            run = sf.simulate(rod, (0, 0, 0), v, model="full", time_limit=1e-6)
            seen.add(status)
            assert status == expected, (phi, omega)
            outcome = {
                "unique": "time-limit",
                "none": "inconsistent",
                "ambiguous": "ambiguous",
            }
            assert run.outcome == outcome[status]
    assert ("none" in seen) == (friction > 4 / 3)
    assert ("ambiguous" in seen) == (friction > 1.5)  # at 1.4 between the samples


def test_a_swing_that_slips_at_its_ends_loses_energy():
    """Shorter and shorter slips; at 80 s one does not end, and friction accelerates the body to 1000 m/s."""
    body = sf.Posture(
        mass=1.0,
        gyration_radius=0.3,
        center_of_mass=(0, 0),
        contacts=[sf.Contact(point=(0, 0.5), friction=0.5)],
        restitution=0.0,
        gravity=G,
    )
    run = sf.simulate(body, (0, 0, 0), (1.5, 0, 3), model="full", time_limit=300)
    assert flaws(body, run) == []


def test_a_slide_goes_on_when_the_other_contact_lifts_off():
    """Both slide to the right at 5 and 3 m/s, one lifts off: the other continues to the right."""
    posture, q, qdot = random_scene(304)
    run = sf.simulate(posture, q, qdot, model="full", event_limit=20_000)
    k = words(run).index("RR")
    assert words(run)[k + 1] == "SR"


def test_a_contact_in_the_air_has_no_mode_but_s():
    """From rest on both contacts the body swings about the second, which slips when the first is .7 m above the ground."""
    posture = sf.Posture(
        mass=1.7223667390837893,
        gyration_radius=0.70004355779108,
        center_of_mass=(0.18067246599022818, 0.7223003143998428),
        contacts=[
            sf.Contact(
                point=(-0.7435599075611132, -0.10934212670696004),
                slope=0.2110014577124668,
                friction=0.47571733050042275,
            ),
            sf.Contact(
                point=(0.10526823005500549, 0.1416546513369853),
                slope=-0.277569919749138,
                friction=0.5931947276300742,
            ),
        ],
        restitution=0.5418971432678209,
        gravity=G,
    )
    run = sf.simulate(posture, (0, 0, 0), (0, 0, 0), model="full", time_limit=2.0)
    assert flaws(posture, run) == []


def test_an_end_of_a_ladder_turns_back():
    """At 45 degrees the upper end has zero velocity while the ladder rotates: energy is continuous."""
    posture = ladder(0.05)
    run = sf.simulate(posture, (0, 0, 0), (1.0, 0, 2.0), model="full", time_limit=0.4)
    t = sliding_phase(run).end
    close(run.at(t)[0][2], mp.pi / 4)
    near = run.energy([t - 1e-6, t + 1e-6])
    assert abs(near[1] - near[0]) < 1e-4


@pytest.mark.parametrize("seed", [49])
def test_two_fixed_contacts_do_not_drift(seed):
    """A body on two fixed contacts cannot move. Formerly it slid at 1e-9 m/s for 190 000 s."""
    posture, q, qdot = random_scene(seed)
    run = sf.simulate(posture, q, qdot, model="full", event_limit=20_000)
    assert run.outcome == "rest"
    assert run.time < 10


@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_rocking_on_a_slope_ends(restitution):
    """The centre of mass is above the feet, but its projection along the normal is not between them: without friction the
    body would tip over."""
    slope = 0.4
    t, n = frame(slope)
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.5,
        center_of_mass=0.6 * n + 0.2537 * t,
        contacts=feet_on_slope(slope, (-0.25, 0.25), (1.0, 1.0)),
        restitution=restitution,
        gravity=G,
    )
    run = sf.simulate(
        posture, (0, 0, 0), (0, 0.05, 0.1), model="full", event_limit=20_000
    )
    assert run.outcome == "rest"


def test_no_motion_beyond_the_pole_of_the_force():
    """The normal force of a sliding point grows without bound as 1 + b(b + σμc)/ρ² decreases to zero."""
    posture = sf.Posture(
        mass=1.7100641222786925,
        gyration_radius=0.1150509336682351,
        center_of_mass=(-0.13332250385006805, 1.0846773183203156),
        contacts=[
            sf.Contact(
                point=(0.46381058947336773, -0.10895103695681924),
                slope=-0.1693576722834751,
                friction=1.4276212472485426,
            )
        ],
        restitution=0.8058644624976203,
        gravity=G,
    )
    start = (0, 0.010153353803426163, 0)
    run = sf.simulate(posture, start, (0, 0, 0), model="full", time_limit=0.72)
    assert flaws(posture, run) == []


@pytest.mark.parametrize(
    ("fields", "feet", "q", "qdot"),
    [
        # Contact 1 slides in the first rounds and sticks in the later ones, with the same ratio of landing speeds.
        (
            {
                "gyration_radius": 0.4624986910592488,
                "center_of_mass": (-0.062031417851914045, 0.0),
                "restitution": 0.4888280151195165,
            },
            [(-0.4768948023716393, 0.61427), (0.5242310623325359, 0.63911)],
            (9.28e-6, 1.4437871542614737e-5, 1.823070786275864e-6),
            (0.0038975443889205483, 0.01041141620670623, 0.0010773409463390707),
        ),
        # Two contacts slide in turn, first in opposite directions, finally in the same direction.
        (
            {
                "gyration_radius": 0.2545149776432233,
                "center_of_mass": (-0.10287569900817745, 0.13531510587264417),
                "restitution": 0.6355446836898297,
            },
            [
                (-0.47307343196254104, 0.25984384005827643),
                (0.4759600013831592, 0.5360555551638693),
            ],
            (2.4377074636973644e-6, 5.4722852819882685e-6, -2.9964394739482616e-6),
            (0, 0, 0),
        ),
    ],
)
def test_rounds_are_summed_only_once_they_slide_alike(fields, feet, q, qdot):
    """The body rotates by 1e-5 rad during the rocking, and the full model sums later than the local one. Both
    contacts must come to rest together."""
    contacts = [sf.Contact(point=(x, 0.0), friction=mu) for x, mu in feet]
    body = sf.Posture(mass=1.0, gravity=G, contacts=contacts, **fields)
    local, full = (sf.simulate(body, q, qdot, model=m) for m in ("local", "full"))
    assert local.zeno_points[-1].method == full.zeno_points[-1].method == "nested"
    assert local.elapsed == pytest.approx(full.elapsed, rel=1e-5)
    assert local.q[0] == pytest.approx(full.q[0], rel=1e-5)


@pytest.mark.parametrize("slope", [1e-13, 1e-21, 1e-40])
def test_a_body_slides_for_ages_on_ground_that_is_nearly_level(slope):
    """Two smooth feet, one of them on a slope. By energy ½v² = ½v₀² + g·drop(θ), and slope·x = −d sin θ, both up to
    terms of the order of the slope."""
    speed = 1e-3  # at the start: at rest such a small slope has no effect
    width, arm = 3.25, (-1.75, 0.5)  # of the centre of mass, from the level foot
    feet = [sf.Contact((-1.5, 0.0), slope=slope), sf.Contact((1.75, 0.0))]
    body = sf.Posture(1.0, 0.5, (0.0, 0.5), feet, 0.0, 9.81)
    run = sf.simulate(body, (0, 0, 0), (-speed, 0, 0), model="full", event_limit=200)

    def per_angle(theta):
        drop = -arm[0] * mp.sin(theta) + arm[1] * (1 - mp.cos(theta))
        return width * mp.cos(theta) / slope / mp.sqrt(speed**2 + 2 * G * drop)

    for theta in (0.01, 0.3, 0.55):
        with mp.workdps(30):
            time = mp.quad(per_angle, [0, mpf(theta)])
        q, qdot = run.at(float(time))
        assert q[2] == pytest.approx(theta, rel=1e-11)
        assert run.energy(float(time)) == pytest.approx(
            speed**2 / 2, abs=1e-13 * qdot[0] ** 2
        )


def test_a_foot_at_the_centre_of_mass_spins_on_while_it_slides():
    slope, mu, v = 0.001, 0.0005, 0.6
    foot = sf.Contact((0.0, 0.0), slope=slope, friction=mu)
    body = sf.Posture(1.0, 0.43, (0.0, 0.0), [foot], 0.0, G)
    start = (v * math.cos(slope), v * math.sin(slope), 0.94)
    run = sf.simulate(body, (0, 0, 0.7), start, model="full")
    assert words(run) == ["R", "L"]
    slows = G * (mp.sin(mpf(slope)) + mpf(mu) * mp.cos(mpf(slope)))
    close(run.phases[1].start, mpf(v) / slows)
    assert (run.outcome, run.omega) == ("sliding", 0.94)


@pytest.mark.parametrize("slope", [2.5e-313, 1e-200, 1e-30])
def test_a_slope_of_no_account_changes_nothing(slope):
    """A body tips over onto almost level ground, and slides until friction has stopped it."""

    def tipped(slope):
        feet = [
            sf.Contact((-1.99996, 0.0), friction=0.0019),
            sf.Contact((-0.4567, 0.0), friction=0.83),
            sf.Contact((0.0431, 0.537), slope=slope),
        ]
        body = sf.Posture(1.0, 0.5454, (-2.0, 1.0021), feet, 0.0, G)
        return sf.simulate(
            body, (0, 0, 0), (0, 0, 0), model="full", simultaneous="first-contact-first"
        )

    level, run = tipped(0.0), tipped(slope)
    assert (run.outcome, words(run)[:-1]) == ("rest", words(level)[:-1])
    assert run.time == pytest.approx(level.time, rel=1e-9)


def test_a_swing_of_which_half_is_done_is_not_without_end():
    """The second half of the swing ends with a landing of the other foot, with a time limit and without one."""
    feet = [sf.Contact((-0.58, 0), friction=1), sf.Contact((-0.52, 0), friction=1)]
    body = sf.Posture(1.0, 0.95, (-0.97, 1.2), feet, 0.0, 9.81)
    start = (-0.49, 0.06, 0), (-1.6, 0, -1.88)
    timed = sf.simulate(body, *start, model="full", time_limit=6.0)
    run = sf.simulate(body, *start, model="full", event_limit=3000)
    assert run.elapsed > 6
    early = run.impacts["elapsed"] < 6
    assert run.impacts["elapsed"][early].tolist() == timed.impacts["elapsed"].tolist()
    assert (timed.impacts["elapsed"] > 3.4).any()
    # One foot on a slope: it lifts off in the second half.
    foot = [sf.Contact((-0.958, 0.0), slope=-0.6178, friction=1.3277)]
    body = sf.Posture(1.0, 0.4991, (-0.7827, 1.6407), foot, 0.0, 9.81)
    run = sf.simulate(body, (0, 0, 0), (-0.8187, 0, -0.1851), model="full")
    assert run.elapsed > 2


def test_a_swing_about_a_fixed_foot_is_no_flight():
    """The swing begins in the last moments of a clattering, for which the geometry is frozen. With this frozen
    geometry the other foot would fly for ever."""
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.7,
        center_of_mass=(1.05, 0.6),
        restitution=0.0,
        gravity=10.0,
        contacts=[
            sf.Contact((-1, 0), slope=0.1, friction=1.0, restitution=0.5),
            sf.Contact((1, 0), slope=-0.1, friction=1.0, restitution=0.2),
        ],
    )
    start = (0, 0.02, -0.01), (0, 0, 0)
    run = sf.simulate(posture, *start, impact="newton")
    assert (run.outcome, run.phases[-1].mode) == ("sliding", "SF")
    later = sf.simulate(
        posture, *start, impact="newton", time_limit=1000.0, stop="time"
    )
    assert (later.outcome, later.phases[-1].mode) == ("time-limit", "SF")
    assert not (later.impacts["time"] > run.time).any()


def test_a_body_that_turns_while_it_slides_slides():
    """Without friction, downhill on one foot, with many revolutions: it leaves the ground of the other foot, but not its own."""
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.862439166683181,
        center_of_mass=(0.44903228794343564, 0.4936859085775866),
        restitution=0.3,
        gravity=10.0,
        contacts=[
            sf.Contact((0.5001321757241988, 0), slope=0.13451846301705067),
            sf.Contact((0.31560408244439775, 0), slope=0.24593206609258927),
        ],
    )
    run = sf.simulate(posture, (0, 0.02, 0.0003242), (0, 0, 0))
    assert (run.outcome, run.phases[-1].mode) == ("sliding", "LS")
    assert abs(run.q[2]) > math.pi


@pytest.mark.parametrize("restitutions", [(0.0, 0.9), (0.9, 0.0), (0.3, 0.8)])
@pytest.mark.parametrize("spin", [0.0, 1e-14, -1e-12, 1e-11])
def test_a_block_that_slides_from_the_start_slides(restitutions, spin):
    """v (cos β, sin β) is along the slope except for rounding errors. A spin that is hardly larger makes the feet
    land in turn, at speeds as small as the rounding error of v. The motion is x = v t + ½ g sin β t² downhill."""
    slope, speed = 0.24, -0.8
    way = np.array([math.cos(slope), math.sin(slope)])
    contacts = [
        sf.Contact(tuple(x * way), slope=slope, restitution=e)
        for x, e in zip((-0.5, 0.5), restitutions, strict=True)
    ]
    block = sf.Posture(1.0, 0.5, (-0.2, 0.47), contacts, 0.0, 10.0)
    run = sf.simulate(
        block, (0, 0, 0), (*speed * way, spin), time_limit=1.0, event_limit=20_000
    )
    assert (run.outcome, run.phases[-1].mode) == ("time-limit", "LL")
    slid = run.q[:2] @ way
    assert slid == pytest.approx(speed - 5 * math.sin(slope), abs=1e-9)


def test_a_run_goes_on_from_where_another_ended():
    """While a rod slides on both ends, the computed rates of its gaps are tiny: 1e-85 m/s, too slow for a landing. A
    gap that is a rounding error, 1e-18 m, takes 5e-10 s to fall through."""
    for k in range(60):
        rod = sf.Posture.rod(0.5, 0.1 + 0.005 * k, restitution=0.2, friction=0.1)
        whole = sf.simulate(rod, (0, 0.011, 0.003), (2, 0, 0))
        first = sf.simulate(rod, (0, 0.011, 0.003), (2, 0, 0), time_limit=0.49)
        second = sf.simulate(rod, first.q, first.qdot, time=first.time)
        assert (second.outcome, whole.outcome) == ("rest", "rest")
        assert second.time == pytest.approx(whole.time, abs=1e-8)
        assert second.q == pytest.approx(whole.q, abs=1e-8)


def test_a_foot_that_sticks_sticks_on():
    """A body tips over its foot. In an intermediate state the rounded position of the foot is 1e-21 m above the
    ground, and its velocity 1e-18 m/s. The foot must still count as fixed. As a foot in flight it would land a
    moment later, sliding, and jam."""
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.12,
        center_of_mass=(-0.08, 0.88),
        restitution=0.0,
        gravity=10.0,
        contacts=[sf.Contact((0, 0), friction=0.7)],
    )
    whole = sf.simulate(posture, (0, 0, 0), (0, 0, 0), time_limit=0.2)
    assert whole.outcome == "time-limit"
    for k in range(1, 100):
        first = sf.simulate(posture, (0, 0, 0), (0, 0, 0), time_limit=k / 1000)
        second = sf.simulate(
            posture, first.q, first.qdot, time=first.time, time_limit=0.2
        )
        assert second.outcome == "time-limit"
        assert second.q == pytest.approx(whole.q, abs=1e-9)


def test_a_motion_in_pieces_is_the_motion():
    """Bodies on one or two feet, from rest: stopped at any time and restarted, they continue in the same mode."""
    random = np.random.default_rng(31)
    cuts = Counter()
    for _ in range(60):
        count = random.choice([1, 2])
        slopes = random.uniform(-0.8, 0.8, count) * (random.random() < 0.6)
        friction = random.choice([0.2, 1, 3])
        posture = sf.Posture(
            1.0,
            random.uniform(0.1, 0.8),
            random.uniform([-0.6, 0.1], [0.6, 1]),
            [
                sf.Contact(
                    (random.uniform(-1, 1), -0.2 * i),
                    slope=slopes[i],
                    friction=friction,
                )
                for i in range(count)
            ],
            0.3,
            10.0,
        )
        options = {"model": "full", "event_limit": 50_000}
        whole = sf.simulate(posture, (0, 0, 0), (0, 0, 0), time_limit=3.0, **options)
        for phase in whole.phases:
            if phase.mode == "S" * count or phase.end - phase.start < 1e-3:
                continue
            at = random.uniform(0.1, 0.9) * (phase.end - phase.start) + phase.start
            first = sf.simulate(posture, (0, 0, 0), (0, 0, 0), time_limit=at, **options)
            second = sf.simulate(
                posture, first.q, first.qdot, time=at, time_limit=3.0, **options
            )
            assert second.phases[0].mode == phase.mode
            assert second.phases[0].end == pytest.approx(phase.end, abs=1e-6)
            cuts[phase.mode] += 1
    assert min(cuts[mode] for mode in "FRL") > 10


def test_feet_that_slide_without_gravity_slide_on():
    """Nothing presses them on the ground: all forces are zero, although three feet on a line have more forces than equations."""
    rng = random.Random(31)
    for case in range(200):
        feet = [rng.uniform(-1, 1) for _ in range(1 + case % 4)]
        contacts = [sf.Contact((x, 0.0), friction=rng.uniform(0, 1.5)) for x in feet]
        body = sf.Posture(1.0, 0.4, (0.1, 0.7), contacts, 0.3, gravity=0.0)
        speed = rng.choice([-1, 1]) * rng.uniform(0.1, 1)
        model = "full" if case % 2 else "local"
        run = sf.simulate(body, (0, 0, 0), (speed, 0, 0), model=model, time_limit=3.0)
        assert run.outcome == "time-limit"
        assert run.q == pytest.approx([3.0 * speed, 0, 0], rel=1e-14, abs=1e-14)
        assert len(run.phases) == 1


def test_a_rotation_of_rounding_size_does_not_decide_without_gravity():
    """A steep foot slides although friction is high. The only load is a centripetal acceleration of about 1e-33
    m/s², which comes from rounding errors of the rotation. It must not decide whether the foot lifts off or
    slides on."""
    rng = random.Random(32)
    for _ in range(200):
        slope = rng.uniform(-1, 1)
        foot = sf.Contact((0.0, 0.0), slope=slope, friction=rng.uniform(1, 3))
        centre = (rng.uniform(-0.5, 0.5), rng.uniform(0.3, 1.5))
        body = sf.Posture(1.0, rng.uniform(0.1, 0.6), centre, [foot], 0.0, gravity=0.0)
        speed, spin = rng.uniform(-1, 1), rng.uniform(-1e-16, 1e-16)
        start = (speed * math.cos(slope), speed * math.sin(slope), spin)
        run = sf.simulate(body, (0, 0, 0), start, time_limit=2.0)
        assert run.outcome == "time-limit"
        assert run.q[:2] == pytest.approx([2 * v for v in start[:2]], abs=1e-13)
