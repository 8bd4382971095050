"""Discs on corners of the ground: convex vertices, ends of a terrain and of a segment, and rough ground."""

import collections
import itertools
import math
import os

import depths
import numpy as np
import pytest
import standfast as sf
from scipy.integrate import solve_ivp

G = 9.81
LAWS = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
#: Random throws; `make long` has more.
THROWS = int(os.environ.get("STANDFAST_CORNER_THROWS", "300"))


def stairs(rng):
    count = rng.integers(2, 7)
    width, height = rng.uniform(0.1, 1, 2)
    height *= rng.choice([-1, 1])
    steps = [((k + d) * width, k * height) for k in range(count) for d in (0, 1)]
    return [(-3, 0), *steps[1:], (steps[-1][0] + width, steps[-1][1])]


def table(rng):
    end = (rng.uniform(0, 0.5), rng.uniform(-0.3, 0.3))
    side = (end[0] + rng.uniform(-0.3, 0.3), end[1] - 2)
    return [(-2, 0), end] if rng.random() < 0.5 else [(-2, 0), end, side]


def rough(rng):
    x = np.cumsum(rng.uniform(0.02, 0.4, rng.integers(4, 30)))
    y = rng.uniform(-0.2, 0.2, len(x)) * rng.uniform(0, 1.5)
    return list(zip(x - x.mean(), y, strict=True))


def slot(rng):
    width = rng.uniform(0.15, 1)
    wall = (width, rng.uniform(-0.2, 0.2))
    return [(-2, 0), (0, 0), (rng.uniform(-0.1, 0.1), -1), (width, -1), wall, (width + 2, 0)]  # fmt: skip


def bump(rng):
    top = (rng.uniform(0.05, 0.6), rng.uniform(0, 0.5))
    return [(-2, 0), (0, 0), (0, rng.uniform(0, 0.5)), top, (1, 0), (3, 0)]


def thrown(rng):
    """A disc, its centre of mass in its centre or beside it, over one of these grounds, and its velocity; and the arm of its centre."""
    ground = rng.choice([stairs, table, rough, slot, bump])(rng)
    terrain = [(float(x), float(y)) for x, y in ground]
    radius = rng.uniform(0.05, 0.5)
    x, top = [v[0] for v in terrain], max(v[1] for v in terrain)
    low, high = max(min(x), -1) - 0.3, min(max(x), 2) + 0.3
    center = np.array([rng.uniform(low, high), top + radius + rng.uniform(0.3, 1.5)])
    mass_at = center + rng.normal(size=2) * radius / 4 * rng.integers(2)
    contact = sf.Contact(center=tuple(map(float, center)), radius=radius, friction=float(rng.choice([0, rng.uniform(0, 2)])))  # fmt: skip
    restitution = float(rng.choice([0, rng.uniform(0, 0.8)]))
    disc = sf.Posture(1, radius * rng.uniform(0.3, 1), tuple(map(float, mass_at)), [contact], restitution, terrain=terrain)  # fmt: skip
    spin = 5 * rng.normal() * rng.integers(2)
    return disc, (*rng.normal(size=2), spin), center - mass_at


def centres(disc, q, arm):
    x, y, theta = np.atleast_2d(q).T
    cos, sin = np.cos(theta), np.sin(theta)
    turned = [x + cos * arm[0] - sin * arm[1], y + sin * arm[0] + cos * arm[1]]
    return np.stack(turned, axis=1) + disc.center_of_mass


def test_thrown_discs_stay_on_the_ground_and_gain_no_energy():
    """Under all laws, with jams as outcomes and as impacts: at all times and events the centre is no nearer to the ground than the radius, and
    the energy never rises. Runs end at rest or at the time limit, but where Coulomb's law has several motions or none."""
    outcomes = collections.Counter()
    for k in range(THROWS):
        rng = np.random.default_rng([64, k])
        disc, qdot, arm = thrown(rng)
        law, jams = str(rng.choice(LAWS)), str(rng.choice(["none", "impact"]))
        run = sf.simulate(disc, (0, 0, 0), qdot, model="full", impact=law, jams=jams, time_limit=4.0, event_limit=20_000)  # fmt: skip
        outcomes[run.outcome] += 1
        events = [t for phase in run.phases for t in (phase.start, phase.end)]
        times = [np.linspace(0, run.time, 301), events[:600], run.impacts["time"][:500]]
        times = np.unique(np.clip(np.concatenate(times), 0, run.time))
        q, v = run.at(times)
        center = centres(disc, q, arm)
        pieces = itertools.pairwise(np.array(disc.terrain))
        near = np.min([depths.distance(center, a, b) for a, b in pieces], axis=0)
        assert near.min() >= disc.contacts[0].radius * (1 - 1e-9), k
        kinetic = 0.5 * (v[:, 0] ** 2 + v[:, 1] ** 2 + (disc.gyration_radius * v[:, 2]) ** 2)  # fmt: skip
        assert np.diff(kinetic + G * q[:, 1]).max() <= 1e-9 * kinetic.max(), k
    print(f"\n{dict(outcomes)}")
    ended = outcomes["rest"] + outcomes["time-limit"]
    assert ended > 0.98 * THROWS
    assert outcomes["event-limit"] <= 0.002 * THROWS
    assert outcomes["rest"] > 0.02 * THROWS


def cart(rng):
    """A body on two or three discs and, at times, a point, over one of these grounds, and its velocity."""
    terrain = [(float(x), float(y)) for x, y in rng.choice([stairs, table, rough, slot, bump])(rng)]  # fmt: skip
    x, top = [v[0] for v in terrain], max(v[1] for v in terrain)
    at = np.array([rng.uniform(max(min(x), -1), min(max(x), 1.5)), top + rng.uniform(0.6, 1.6)])  # fmt: skip
    count, apart, radius = rng.integers(2, 4), rng.uniform(0.2, 0.8), rng.uniform(0.05, 0.4)  # fmt: skip
    contacts = []
    for k in range(count):
        center = tuple(map(float, np.add(at, [(k - (count - 1) / 2) * apart, rng.uniform(0, 0.2) * rng.integers(2)])))  # fmt: skip
        if rng.random() < 0.2:
            contacts.append(sf.Contact(center, friction=float(rng.uniform(0, 1))))
        else:
            friction = float(rng.choice([0, rng.uniform(0, 1.5)]))
            size = radius * float(rng.choice([1, rng.uniform(0.5, 1.5)]))
            contacts.append(sf.Contact(center=center, radius=size, friction=friction))
    mass_at = tuple(map(float, np.add(at, rng.uniform((-0.2, 0), (0.2, 0.4)))))
    restitution = float(rng.choice([0, rng.uniform(0, 0.8)]))
    body = sf.Posture(1, float(rng.uniform(0.1, 0.6)), mass_at, contacts, restitution, terrain=terrain)  # fmt: skip
    return body, (*map(float, rng.normal(size=2)), 3 * rng.normal() * rng.integers(2))


def test_bodies_on_several_discs_stay_on_the_ground():
    """Where a disc comes nearer to the ground than its radius, it comes from behind: its centre is in the ground, or beyond an end of the terrain."""
    ran = 0
    for k in range(THROWS):
        rng = np.random.default_rng([66, k])
        try:
            body, qdot = cart(rng)
        except ValueError:
            continue  # a point beside the terrain
        ran += 1
        law = str(rng.choice(LAWS))
        run = sf.simulate(body, (0, 0, 0), qdot, model="full", impact=law, time_limit=3.0, event_limit=20_000)  # fmt: skip
        times = np.linspace(0, run.time, 2001)
        q, _ = run.at(times)
        for contact in body.contacts:
            if contact.radius == 0:
                continue
            center = centres(body, q, np.array(contact.center) - body.center_of_mass)
            pieces = itertools.pairwise(np.array(body.terrain))
            near = np.min([depths.distance(center, a, b) for a, b in pieces], axis=0)
            deep = near < contact.radius * (1 - 1e-8)
            if deep.any():
                first = center[np.argmax(deep)]
                low, high = body.terrain[0][0], body.terrain[-1][0]
                behind = depths.in_ground(first[None], body.terrain)[0] > 0
                assert behind or not low <= first[0] <= high, k
    assert ran > 0.9 * THROWS


def test_elastic_discs_on_corners_keep_their_energy():
    """Restitution 1, no friction: over random ground the energy is constant."""
    for k in range(100):
        rng = np.random.default_rng([71, k])
        disc, qdot, _ = thrown(rng)
        smooth = sf.Contact(center=disc.contacts[0].center, radius=disc.contacts[0].radius)  # fmt: skip
        disc = sf.Posture(1, disc.gyration_radius, disc.center_of_mass, [smooth], 1.0, terrain=disc.terrain)  # fmt: skip
        run = sf.simulate(disc, (0, 0, 0), qdot, model="full", time_limit=3.0)
        q, v = run.at(np.linspace(0, run.time, 50))
        kinetic = 0.5 * (v[:, 0] ** 2 + v[:, 1] ** 2 + (disc.gyration_radius * v[:, 2]) ** 2)  # fmt: skip
        energy = kinetic + G * q[:, 1]
        assert np.abs(energy - energy[0]).max() < 1e-12 * kinetic.max(), k


def test_a_ball_bounces_to_rest_on_the_tip_of_a_corner():
    """It falls h = 0.7 m straight on it: as on level ground it rests after √(2h/g) (1 + e)/(1 − e), balanced; 1 nm beside it rolls off."""
    contact = sf.Contact(center=(0, 1), radius=0.3, friction=0.5)
    ball = sf.Posture(1, 0.1, (0, 1), [contact], 0.5, terrain=[(-1, -1), (0, 0), (1, -1)])  # fmt: skip
    run = sf.simulate(ball, (0, 0, 0), (0, 0, 0))
    assert run.outcome == "rest"
    assert run.time == pytest.approx(3 * math.sqrt(1.4 / G), rel=1e-12)
    np.testing.assert_allclose(run.q, (0, -0.7, 0), atol=1e-15)
    off = sf.simulate(ball, (1e-9, 0, 0), (0, 0, 0), time_limit=10)
    assert off.q[1] < -2


def rolled_off(speed, radius, friction, time):
    """q of a solid disc that rolls on a floor from (0, R) on, off its end at x = 1, and when it slips there and lifts off, by integration. With φ
    the angle of the centre from the vertical over the end, clockwise, N = g cos φ − R φ̇² and f the friction, both per unit mass,

        R φ̈ = g sin φ + f,   θ̈ = 2 f/R,   f = −(g/3) sin φ while it rolls, and −μ N while it slides
    """

    def normal(s):
        return G * math.cos(s[0]) - radius * s[1] ** 2

    def slips(_t, s):
        return friction * normal(s) - G * math.sin(s[0]) / 3

    def lifts(_t, s):
        return normal(s)

    def motion(rub):
        return lambda _t, s: [s[1], (G * math.sin(s[0]) + rub(s)) / radius, s[3], 2 * rub(s) / radius]  # fmt: skip

    slips.terminal = lifts.terminal = True
    exact = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}
    at_end = [0, speed / radius, -1 / radius, -speed / radius]
    rolls = solve_ivp(motion(lambda s: -G / 3 * math.sin(s[0])), (1 / speed, time), at_end, events=slips, **exact)  # fmt: skip
    slip = rolls.t[-1]
    slides = solve_ivp(motion(lambda s: -friction * normal(s)), (slip, time), rolls.y[:, -1], events=lifts, **exact)  # fmt: skip
    angle, rate, turned, spin = slides.y[:, -1]
    lift, sin, cos = slides.t[-1], math.sin(angle), math.cos(angle)
    left = time - lift
    x = 1 + radius * sin + radius * rate * cos * left
    y = radius * (cos - 1) - radius * rate * sin * left - G / 2 * left**2
    return (x, y, turned + spin * left), slip, lift


@pytest.mark.parametrize("speed", [0.3, 1.0, 1.8, 2.2])
@pytest.mark.parametrize("friction", [0.2, 0.7, 3.0])
@pytest.mark.parametrize("ends", ["terrain", "table", "segment"])
def test_a_disc_rolls_off_the_end_of_a_floor(speed, friction, ends):
    """It rolls over the end, slips, lifts off and falls: as integrated, where the floor ends as a terrain, with a side, or as a segment."""
    radius, time = 0.5, 1 / speed + 1.0
    if ends == "segment":
        contact = sf.Contact((0, 0), radius=radius, friction=friction, segment=(-3, 1))
        disc = sf.Posture(1, radius / math.sqrt(2), (0, radius), [contact], 0.3)
    else:
        terrain = [(-3, 0), (1, 0), *([(1, -9)] if ends == "table" else [])]
        disc = sf.Posture.disc(radius, friction=friction, restitution=0.3, terrain=terrain)  # fmt: skip
    run = sf.simulate(disc, (0, 0, 0), (speed, 0, -speed / radius), time_limit=time)
    q, slip, lift = rolled_off(speed, radius, friction, time)
    modes = [phase for phase in run.phases if phase.end - phase.start > 1e-12]
    assert [phase.mode for phase in modes] == ["F", "F", "R", "S"]
    assert abs(modes[2].start - slip) < 1e-9
    assert abs(modes[3].start - lift) < 1e-9
    np.testing.assert_allclose(run.q, q, rtol=0, atol=1e-9)


@pytest.mark.parametrize("speed", [0.1, 1.0, 2.0])
def test_a_disc_that_never_slips_lifts_off_at_an_angle_in_closed_form(speed):
    """w² = v² + (4/3) g R (1 − cos φ) while it rolls about the end; N = 0 where cos φ = (4 + 3v²/(gR))/7. With a finite friction it slips a
    moment before, for a time in proportion to 1/μ: the limit follows from two coefficients."""
    radius, found = 0.5, []
    for friction in (1e5, 1e6):
        disc = sf.Posture.disc(radius, friction=friction, terrain=[(-3, 0), (1, 0)])
        run = sf.simulate(disc, (0, 0, 0), (speed, 0, -speed / radius), time_limit=1 / speed + 2)  # fmt: skip
        lift = next(phase.start for phase in run.phases if phase.mode == "S" and phase.start > 0)  # fmt: skip
        (x, y, _), (vx, vy, _) = (each[0] for each in run.at([lift]))
        assert abs(math.hypot(x - 1, y + radius) - radius) < 1e-12
        found.append(((y + radius) / radius, vx**2 + vy**2))
    cos, square = np.array(found[1]) - (np.array(found[0]) - found[1]) / 9
    exact = (4 + 3 * speed**2 / (G * radius)) / 7
    assert abs(cos - exact) < 1e-9
    assert abs(square - speed**2 - 4 / 3 * G * radius * (1 - exact)) < 1e-8


@pytest.mark.parametrize("height", [1e-3, 0.02, 0.1, 0.2])
def test_energy_decides_whether_a_wheel_climbs_a_kerb(height):
    """A solid disc rolls against a kerb, e = 0: it keeps v⁺ = v (1 − 2h/(3R)), and climbs if v⁺² > (4/3) g h: tested 1e-9 on both sides."""
    radius = 0.5
    disc = sf.Posture.disc(radius, friction=1e3, restitution=0, terrain=[(-3, 0), (0.5, 0), (0.5, height), (3, height)])  # fmt: skip
    for factor, climbs in [(1 - 1e-9, False), (1 + 1e-9, True)]:
        speed = factor * math.sqrt(4 / 3 * G * height) / (1 - 2 * height / (3 * radius))
        run = sf.simulate(disc, (0, 0, 0), (speed, 0, -speed / radius), time_limit=30)
        (t,) = run.impacts["time"][:1]
        _, v = run.at([t])
        after = speed * (1 - 2 * height / (3 * radius))
        assert abs(math.hypot(*v[0][:2]) / after - 1) < 1e-12
        assert (run.at([12.0])[0][0][0] > 0.5) == climbs


def test_a_fast_wheel_jumps_from_a_kerb():
    """It lifts off at once if v⁺²/R > g (R − h)/R."""
    radius, height = 0.5, 0.1
    disc = sf.Posture.disc(radius, friction=1e3, restitution=0, terrain=[(-3, 0), (0.5, 0), (0.5, height), (3, height)])  # fmt: skip
    limit = math.sqrt(G * (radius - height)) / (1 - 2 * height / (3 * radius))
    for factor, word in [(0.999, "F"), (1.001, "S")]:
        speed = factor * limit
        run = sf.simulate(disc, (0, 0, 0), (speed, 0, -speed / radius), time_limit=1)
        (t,) = run.impacts["time"][:1]
        after = [phase.mode for phase in run.phases if phase.start <= t + 1e-9 < phase.end]  # fmt: skip
        assert after == [word]


def test_a_wheel_rolls_over_tiles_that_do_not_lie_level():
    """Steps of 1e-12 m, up and down, are walked over without a loss that can be seen."""
    rng = np.random.default_rng(3)
    heights = rng.choice([0, 1e-12, 2e-12], 21)
    heights[0] = 0
    tiles = [(0.1 * (k + d), h) for k, h in enumerate(heights) for d in (0, 1)]
    terrain = [v for k, v in enumerate(tiles) if k == 0 or v != tiles[k - 1]]
    disc = sf.Posture.disc(0.5, friction=0.5, restitution=0.5, terrain=[(-1, 0), *terrain[1:-1], (5, heights[-1])])  # fmt: skip
    run = sf.simulate(disc, (0, 0, 0), (1, 0, -2), time_limit=3)
    assert run.outcome == "time-limit"
    np.testing.assert_allclose(run.q, (3, heights[-1], -6), atol=1e-4)
    np.testing.assert_allclose(run.qdot, (1, 0, -2), atol=1e-4)


def test_a_disc_of_any_size_has_a_ground_or_an_error():
    """In a ring that is open on one side, with its free side within: small discs fit, larger ones lie on its opening, and no size panics."""
    fit, turns = 0, np.linspace(-1.5, 1.5 - 2 * math.pi, 40)
    ring = [(math.sin(a), math.cos(a)) for a in turns[::-1]]
    for terrain in (
        ring,
        ring[::-1],
        [(-1, 0), (1, 0)],
        [(0, 1), (0, 0), (1e-9, 0), (1e-9, 1)],
    ):
        for radius in 10.0 ** np.arange(-12, 76, 4):
            contact = sf.Contact(center=(0, 3 * radius + 3), radius=radius)
            try:
                disc = sf.Posture(
                    1, radius, contact.center, [contact], 0.5, terrain=terrain
                )
            except ValueError:
                continue
            assert np.isfinite(disc.gaps((0, 0, 0))[0])
            fit += 1
    assert fit > 40


@pytest.mark.parametrize("law", LAWS)
def test_an_impact_at_a_corner_is_that_at_its_tangent(law):
    """A disc with its centre of mass beside its centre falls on a corner, and on a slope that touches it at the same point: the same velocity."""
    rng = np.random.default_rng(11)
    for _ in range(40):
        angle, radius = rng.uniform(-0.7, 0.7), rng.uniform(0.1, 0.5)
        normal = np.array([math.sin(angle), math.cos(angle)])
        center = normal * radius
        mass_at = tuple(map(float, center + rng.uniform(-0.3, 0.3, 2) * radius))
        contact = sf.Contact(center=tuple(map(float, center)), radius=radius, friction=rng.uniform(0, 1))  # fmt: skip
        qdot = (rng.normal(), -1 - rng.random(), 3 * rng.normal())
        runs = []
        for terrain in ([(-1, -1), (0, 0), (1, -1)], [(-math.cos(angle), math.sin(angle)), (math.cos(angle), -math.sin(angle))]):  # fmt: skip
            disc = sf.Posture(1, radius / 2, mass_at, [contact], 0.4, terrain=terrain)
            run = sf.simulate(disc, (0, 0, 0), qdot, impact=law, event_limit=1)
            assert run.impacts.size <= 1
            runs.append(sf.simulate(disc, (0, 0, 0), qdot, impact=law, time_limit=1e-9))
        np.testing.assert_allclose(runs[0].qdot, runs[1].qdot, atol=1e-6)


def test_the_accelerations_of_a_state_on_a_corner_are_those_of_its_run():
    """Contact modes of a state about a corner: the term w²/R of the acceleration of the gap is in the problem."""
    disc = sf.Posture.disc(0.5, friction=0.4, terrain=[(-3, 0), (1, 0), (1, -9)])
    run = sf.simulate(disc, (0, 0, 0), (1, 0, -2), time_limit=3)
    seen = set()
    for phase in run.phases:
        if phase.start < 0.99 or phase.mode == "S":
            continue
        t = (phase.start + phase.end) / 2
        (q,), (v,) = run.at([t])
        step = 1e-4 * (phase.end - phase.start)
        (before, after) = run.at([t - step, t + step])[1]
        expected = (after - before) / (2 * step)
        modes = sf.contact_modes(disc, q=q, qdot=v)
        found = modes[phase.mode].acceleration
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5)
        seen.add(phase.mode)
    assert seen == {"F", "R"}


def test_a_ball_rests_in_a_slot_on_its_two_edges():
    """The slot is narrower than the ball: it comes to rest √(R² − w²/4) above the edges, one letter F for both."""
    radius, width = 0.3, 0.4
    slot = [(-2, 0), (0, 0), (0, -1), (width, -1), (width, 0), (2, 0)]
    start = (width / 2 + 0.02, 0.3)
    contact = sf.Contact(center=start, radius=radius, friction=0.4)
    ball = sf.Posture(1, radius / math.sqrt(2), start, [contact], 0.3, terrain=slot)
    run = sf.simulate(ball, (0, 0, 0), (0, 0, 0))
    assert run.outcome == "rest"
    assert run.phases[-1].mode == "F"
    exact = (width / 2, math.sqrt(radius**2 - width**2 / 4))
    np.testing.assert_allclose(run.q[:2] + ball.center_of_mass, exact, atol=1e-12)


def test_polygons_on_an_edge_converge_to_the_disc():
    """Regular polygons fall on a corner of the ground, without friction: their velocities after the first impact approach that of the disc as
    the number of corners grows."""
    rng = np.random.default_rng(5)
    terrain = [(-2, -2), (0, 0), (2, -2)]
    worst = {8: [], 64: []}
    for _ in range(60):
        x, angle = rng.uniform(-0.25, 0.25), rng.uniform(0, 1)
        v = (float(rng.normal()) / 4, -3.0, float(rng.normal()))
        contact = sf.Contact(center=(x, 1.0), radius=0.5)
        disc = sf.Posture(1, 0.3, (x, 1.0), [contact], 0.5, terrain=terrain)
        known = sf.simulate(disc, (0, 0, 0), v, time_limit=0.3).qdot
        for count, off in worst.items():
            turns = 2 * math.pi * (np.arange(count) + angle) / count
            corners = [(x + 0.5 * math.cos(a), 1 + 0.5 * math.sin(a)) for a in turns]
            polygon = sf.Posture(1, 0.3, (x, 1.0), [sf.Contact(c) for c in corners], 0.5, terrain=terrain, outline=corners)  # fmt: skip
            run = sf.simulate(polygon, (0, 0, 0), v, time_limit=0.3)
            off.append(np.abs(run.qdot - known)[:2].max())
    # Normals that differ by π/n turn what an impact changes, 1.5 · 4 m/s, by as much.
    assert np.median(worst[64]) < 0.25 * np.median(worst[8])
    assert np.median(worst[64]) < math.pi / 64 * 6


def test_a_posture_on_a_corner_has_the_verdict_of_the_slope_there():
    """Verdicts are about small motions to first order, in which the curvature of a contact does not count: a body with a round foot on a corner and
    a foot on a floor, and the same body on straight ground."""
    center = (0.05, 0.3 + math.sqrt(0.09 - 0.05**2))
    edge = [(-3, 0), (-0.02, 0), (0, 0.3), (1, -9)]
    normal = np.array([center[0], center[1] - 0.3]) / 0.3
    slope = -math.atan2(normal[0], normal[1])
    foot = sf.Contact((-1.0, 0), friction=0.6)
    corner = sf.Contact(center=center, radius=0.3, friction=0.6)
    straight = sf.Contact((0, 0.3), slope=slope, friction=0.6)
    body = {"mass": 1, "gyration_radius": 0.5, "center_of_mass": (-0.5, 0.6), "restitution": 0.2}  # fmt: skip
    on_corner = sf.Posture(contacts=[foot, corner], terrain=edge, **body)
    on_slope = sf.Posture(contacts=[foot, straight], **body)
    assert list(on_corner.gaps((0, 0, 0))) == [0, 0]
    assert on_corner.contacts[1].slope == pytest.approx(slope, rel=1e-14)
    verdicts = [sf.stability(posture) for posture in (on_corner, on_slope)]
    assert verdicts[0].equilibrium == verdicts[1].equilibrium
    assert verdicts[0].frictional_stability == verdicts[1].frictional_stability
    regions = [sf.equilibrium_region(posture) for posture in (on_corner, on_slope)]
    np.testing.assert_allclose(*regions, rtol=1e-12)


@pytest.mark.parametrize("speed", [1.0, 2.0])
def test_a_disc_leaves_an_edge_while_the_ground_shakes(speed):
    """Under an acceleration of the ground that is linear between samples, beside 1 600 steps with its means: it rolls over the end, slips, and lifts
    off once."""
    disc = sf.Posture.disc(0.5, friction=0.4, restitution=0.2, terrain=[(-3, 0), (1, 0)])  # fmt: skip
    times = np.array([0, 0.5, 1.2, 2.0, 3.0])
    values = np.array([(0, 0), (0.3, 1), (-0.2, -1), (0.4, 0.5), (0, 0)], dtype=float)
    fine = np.linspace(0, 3, 1601)
    exact = np.stack([np.interp(fine, times, values[:, i]) for i in (0, 1)], axis=1)
    steps = [*((exact[:-1] + exact[1:]) / 2), (0, 0)]
    linear = sf.GroundMotion(times, values, interpolation="linear")
    start = (0, 0, 0), (speed, 0, -speed / 0.5)
    runs = [
        sf.simulate(disc, *start, ground_motion=motion, time_limit=2.9)
        for motion in (linear, sf.GroundMotion(fine, steps))
    ]
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-5)
    modes = [phase.mode for phase in runs[0].phases if phase.end - phase.start > 1e-12]
    assert modes[-1] == "S"
    assert modes.count("S") == 1
