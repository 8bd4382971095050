"""The oracles of a corner of the ground on a side of a body, against closed forms. No test here uses such a contact of the
library."""

import math

import depths
import edge
import numpy as np
import pytest
import standfast as sf
import stepping
from mpmath import mp, mpf
from scipy.integrate import quad

G = 9.81
TABLE = [(-5.0, 0.0), (0.0, 0.0), (0.0, -5.0), (5.0, -5.0)]

# The rows of a side on a corner.


def smooth_motion(seed):
    """Functions x, y, θ of time, and the direction and distance of a side; all at random."""
    rng = np.random.default_rng([41, seed])
    a = [[mpf(v) for v in row] for row in rng.normal(size=(3, 4))]

    def coordinate(row):
        return lambda t: row[0] + row[1] * t + mp.sin(row[2] * t + row[3])

    return [coordinate(row) for row in a], rng.uniform(-3, 3), rng.uniform(0.1, 1)


@pytest.mark.parametrize("seed", range(20))
def test_rates_of_the_gap_are_its_derivatives(seed):
    """ḣ, ḧ = n·r̈ + b ω̇ − c ω² − 2 ω v_t and, in the axes of the body, the acceleration of a point with those of Euler and
    Coriolis, against derivatives of h to thirty digits. Without the term of Coriolis ḧ is far off."""
    motion, direction, d = smooth_motion(seed)
    corner = (0.3, -0.7)

    def h(t):
        x, y, theta = (f(t) for f in motion)
        phi = theta + mpf(direction)
        return mp.cos(phi) * (corner[0] - x) + mp.sin(phi) * (corner[1] - y) - d

    with mp.workdps(40):
        t = mpf(0.4)
        place, speed, change = (
            np.array([float(mp.diff(f, t, k)) for f in motion]) for k in (0, 1, 2)
        )
        exact = [float(mp.diff(h, t, k)) for k in (0, 1, 2)]
    side = corner, direction, d
    first, second, slip = edge.rates(place, speed, change, *side)
    # Rounding errors of a few terms of order 1 to 10.
    assert edge.gap(place, *side) == pytest.approx(exact[0], abs=1e-14)
    assert first == pytest.approx(exact[1], abs=1e-13)
    assert second == pytest.approx(exact[2], abs=1e-12)
    in_body = edge.second_in_body_axes(place, speed, change, *side)
    assert in_body == pytest.approx(exact[2], abs=1e-12)
    coriolis = 2 * speed[2] * slip
    assert abs(coriolis) > 1e-4
    assert abs(second + coriolis - exact[2]) > 1e-4


def random_side(rng, friction):
    box = edge.Side.of_box(*rng.uniform(0.3, 2, 2), friction, index=rng.integers(1, 5))
    z = rng.uniform(box.low, box.high), *rng.normal(size=3) * (0.5, 1, 1)
    return box, np.array(z)


@pytest.mark.parametrize("seed", range(20))
def test_lagranges_equations_agree_with_newtons_and_the_rows(seed):
    """The acceleration follows from gravity, λ n + τ t, and their moment bλ − cτ; with it ḣ = ḧ = 0, and v̇_t = −b̈."""
    rng = np.random.default_rng([42, seed])
    side, z = random_side(rng, 0.3)
    z[2] = abs(z[2])
    change, spin, normal = side.slips(z, 1.0)
    t, n = edge.vectors(z[1])
    tangential = side.friction * normal
    force = normal * n + tangential * t - [0, side.gravity]
    acceleration = np.array([*force, spin])
    assert side.rho2 * spin == pytest.approx(z[0] * normal + side.d * tangential)
    place, speed = side.state((0.2, 0.1), z)
    outward = side.angle - math.pi / 2
    on = (0.2, 0.1), outward, side.d
    first, second, slip = edge.rates(place, speed, acceleration, *on)
    assert edge.gap(place, *on) == pytest.approx(0, abs=1e-14)
    assert first == pytest.approx(0, abs=1e-14)
    assert slip == pytest.approx(-z[2], abs=1e-14)
    assert second == pytest.approx(0, abs=1e-11)
    along = t @ force + side.d * spin - z[0] * z[3] ** 2
    assert along == pytest.approx(-change, abs=1e-11)
    assert side.coordinates((0.2, 0.1), place, speed) == pytest.approx(z, abs=1e-14)


def test_a_pivot_keeps_a_corner_of_the_side():
    """The same with ω̇ of a pivot: v̇_t = 0."""
    side, z = random_side(np.random.default_rng(43), 10.0)
    z[2] = 0
    spin, normal, tangential = side.pivots(z)
    t, n = edge.vectors(z[1])
    force = normal * n + tangential * t - [0, side.gravity]
    acceleration = np.array([*force, spin])
    assert side.rho2 * spin == pytest.approx(z[0] * normal + side.d * tangential)
    place, speed = side.state((0, 0), z)
    on = (0, 0), side.angle - math.pi / 2, side.d
    assert edge.rates(place, speed, acceleration, *on)[1] == pytest.approx(0, abs=1e-11)
    assert t @ force + side.d * spin == pytest.approx(z[0] * z[3] ** 2, abs=1e-11)


# The motion from event to event.


@pytest.mark.parametrize("outside", [1e-9, 1e-3, 0.1])
def test_a_pivot_is_a_physical_pendulum(outside):
    """½ I ω² = g × the fall of the centre of mass, and the time is ∫ dφ/ω, with φ = −u²."""
    side = edge.Side.of_box(1.0, 0.5, 0.5)
    motion = edge.tipping(side, outside, 20.0)
    slips = motion.parts[1].start
    z = motion.parts[1].z
    moment = side.rho2 + side.d**2 + outside**2

    def fall(u):
        # d (1 − cos φ) + outside sin|φ|, without cancellation.
        return 2 * side.d * math.sin(u * u / 2) ** 2 + outside * math.sin(u * u)

    def spin(u):
        return math.sqrt(2 * side.gravity * fall(u) / moment)

    end = math.sqrt(-z[1])
    assert z[3] == pytest.approx(-spin(end), rel=1e-12)
    _, normal, tangential = side.pivots(np.array([z[0], z[1], 0, z[3]]))
    assert tangential == pytest.approx(-side.friction * normal, rel=1e-11)
    # In ln u the integrand is smooth over many decades.
    least = end * 1e-9
    start = 2 * least / math.sqrt(2 * side.gravity * outside / moment)
    time = quad(
        lambda s: 2 * math.exp(2 * s) / spin(math.exp(s)),
        math.log(least),
        math.log(end),
        epsabs=1e-13,
        epsrel=1e-13,
        limit=500,
    )[0]
    assert slips == pytest.approx(start + time, rel=1e-12)


def test_friction_takes_the_energy_of_a_slip():
    """It falls by ∫ μλ|ḃ| dt while the side slips, and not else; at the end the force is zero."""
    side = edge.Side.of_box(1.0, 0.5, 0.5)
    motion = edge.tipping(side, 0.01, 2.0)
    pivot, slip, flight = motion.parts
    assert motion.word() == "pivot slip flight"
    assert motion.left == "lift-off"
    end = edge._follow(side, slip, slip.z, slip.end)
    assert side.energy(slip.z) == pytest.approx(side.energy(pivot.z), rel=1e-13)

    def power(t):
        z = edge._follow(side, slip, slip.z, t)
        return side.friction * side.slips(z, slip.sense)[2] * abs(z[2])

    work = quad(power, slip.start, slip.end, epsabs=1e-13, epsrel=1e-13)[0]
    assert work > 1e-3
    assert side.energy(slip.z) - side.energy(end) == pytest.approx(work, rel=1e-11)
    assert side.slips(end, slip.sense)[2] == pytest.approx(0, abs=1e-10)
    place, _ = flight.z
    assert motion.at(flight.start)[0] == pytest.approx(place, abs=1e-13)
    # In flight the gap grows from zero, with ḣ = 0.
    gap = edge.gap(motion.at(flight.start + 1e-3)[0], (0, 0), -math.pi / 2, side.d)
    assert 0 < gap < 1e-6


def test_without_gravity_and_friction_a_side_has_two_integrals():
    """The force passes through V: with w = ḃ + d ω, L = (ρ² + b²) ω + d w and 2E = w² + (ρ² + b²) ω² are
    constant. Both give ḃ(b), and the time by quadrature."""
    side = edge.Side.of_box(1.0, 0.5, 0.0, gravity=0.0)
    z = np.array([0.4, 0.0, -1.0, 0.5])
    motion = edge.follow(side, (0, 0), z, 0.5, (-1.4, 1.4))
    assert motion.word() == "slip"
    momentum, twice = side.momentum(z), 2 * side.energy(z)

    def rate(b):
        """ḃ and ω: of a quadratic equation for w; w < 0 here."""
        j, d = side.rho2 + b * b, side.d
        a, half, c = 1 + d * d / j, -momentum * d / j, momentum**2 / j - twice
        w = (-half - math.sqrt(half**2 - a * c)) / a
        omega = (momentum - d * w) / j
        return w - d * omega, omega

    assert rate(z[0]) == pytest.approx(z[2:], rel=1e-13)
    part = motion.parts[0]
    for t in (0.1, 0.3, 0.5):
        b, phi, change, omega = edge._follow(side, part, z, t)
        assert (change, omega) == pytest.approx(rate(b), rel=1e-12)
        time = quad(lambda b: 1 / rate(b)[0], z[0], b, epsabs=1e-13, epsrel=1e-13)[0]
        assert time == pytest.approx(t, rel=1e-12)
        turned = quad(lambda b: rate(b)[1] / rate(b)[0], z[0], b, epsabs=1e-13, epsrel=1e-13)[0]  # fmt: skip
        assert turned == pytest.approx(phi, rel=1e-12)


def test_without_gravity_a_side_stays_if_it_slips_fast_enough_and_a_corner_never():
    """λ (1 + b²/ρ²) = c ω² − 2 ḃ ω for a side, with c = −d < 0: it depends on the term of Coriolis. A corner of the body on a fixed
    line has λ (1 + b²/ρ²) = c ω², and lifts off at once: it moves on its line with constant t·ṙ only in flight."""
    side = edge.Side.of_box(1.0, 0.5, 0.0, gravity=0.0)
    for b in (-0.3, 0.2):
        for omega in (-0.7, 1.3):
            for slip in (-1.0, 0.1, 2.0):
                force = side.slips(np.array([b, 0.1, slip, omega]), 0.0)[2]
                expected = -side.d * omega**2 - 2 * slip * omega
                expected *= side.rho2 / (side.rho2 + b * b)
                assert force == pytest.approx(expected, rel=1e-12)
    limit = -side.d * 0.5 / 2
    for over, word in [(-1e-6, "slip"), (1e-6, "flight")]:
        motion = edge.follow(side, (0, 0), (0.2, 0, limit + over, 0.5), 1e-3, (-1, 1))
        assert motion.parts[0].kind == word


def test_a_box_that_slides_flat_tips_before_its_centre_is_over_the_edge():
    """The rear corner has no force at b = μ d; then the front goes down, and the rear lifts off: ω̇ = 0 there, and then < 0."""
    side = edge.Side.of_box(1.0, 0.5, 0.3)
    start, motion = edge.slides_over(side, 2.0, 0.2)
    z = motion.parts[0].z
    assert side.slips(z, -1.0)[1] == pytest.approx(0, abs=1e-14)
    pull = side.friction * side.gravity
    assert 0.5 - 2.0 * start + pull * start**2 / 2 == pytest.approx(0.3 * 0.25)
    later = edge._follow(side, motion.parts[0], z, 0.01)
    assert later[1] < 0
    assert side.slips(later, -1.0)[1] < 0


def test_a_side_slips_to_its_end():
    side = edge.Side.of_box(1.0, 0.5, 0.3)
    _, motion = edge.slides_over(side, 3.0, 1.0)
    assert motion.left == "end"
    end = edge._follow(side, motion.parts[0], motion.parts[0].z, motion.parts[0].end)
    assert end[0] == pytest.approx(side.low, abs=1e-13)


# Depths.


def test_depths_of_a_box_and_a_peak():
    box = [(-1, 0), (1, 0), (1, 1), (-1, 1)]
    peak = [(-4, -4), (0, 0.2), (4, -4)]
    q = [(0, 0, 0), (0, 0.5, 0), (0, 0.2, math.pi), (5, -4.2, 0)]
    ground, body = depths.deepest(box, (0, 0.5), peak, q)
    slope = math.hypot(4.2, 4)
    # Distance of (1, 0) from the line 4.2 x + 4 (y − 0.2) = 0.
    away = (4.2 * 1 - 4 * 0.2) / slope
    assert body[:3] == pytest.approx([0.2, -0.3, 0.0], abs=1e-14)
    assert ground[0] == pytest.approx(-away, rel=1e-14)
    # Its left lower corner is at (4, −4.2), 0.2 below the end of the ground.
    assert ground[3] == pytest.approx(-0.2, rel=1e-12)


def test_depths_below_a_table_and_an_overhang():
    points = np.array([(-1, -0.1), (-0.05, -0.3), (0.05, -0.3), (1, -5.2), (-9, -1)])
    expected = [0.1, 0.05, -0.05, 0.2, -math.hypot(4, 1)]
    found = depths.in_ground(points, TABLE)
    assert found == pytest.approx(expected, rel=1e-12)
    roof = [(-5, 0), (2, 0), (2, 1), (-1, 1), (-1, 2), (5, 2)]
    points = np.array([(0, 0.5), (0, 1.5), (3, 1.5), (-1.5, 1.5)])
    found = depths.in_ground(points, roof)
    assert found == pytest.approx([-0.5, 0.5, 0.5, -0.5], rel=1e-12)


def test_depths_agree_with_half_planes():
    """For a convex body and a convex ground, in any position."""
    rng = np.random.default_rng(44)
    triangle = np.array([(0, 0), (1, 0.2), (0.3, 0.9)])
    q = rng.uniform(-1, 1, (500, 3)) * (1, 1, 3)
    corners = depths.placed(triangle, (0.4, 0.4), q)
    for row, found in zip(corners, depths.in_body((0.1, 0.2), corners), strict=True):
        sides = np.roll(row, -1, axis=0) - row
        off = np.array((0.1, 0.2)) - row
        heights = sides[:, 0] * off[:, 1] - sides[:, 1] * off[:, 0]
        least = (heights / np.hypot(*sides.T)).min()
        if least > 0:
            assert found == pytest.approx(least, rel=1e-12)
        else:
            assert found <= 0


# Fixed steps.


def errors(posture, q, qdot, end, exact, steps):
    """Differences of the places with fixed steps from the exact one."""
    found = []
    for step in steps:
        bodies = stepping.Bodies.of_postures([posture], [q], [qdot], [0.0])
        place, _ = stepping.simulate(bodies, step, end, each=lambda *_: None)
        found.append(np.abs(place[0] - exact).max())
    return found


def assert_first_order(found, steps, constant):
    """Each error is below ``constant`` × step."""
    for error, step in zip(found, steps, strict=True):
        assert error < constant * step, found


STEPS = (4e-3, 1e-3, 2.5e-4)


def test_fixed_steps_of_a_box_that_tips():
    """Largest measured error: 0.31 steps."""
    box = sf.Posture.box(1.0, 0.5, friction=0.5, terrain=TABLE)
    motion = edge.tipping(edge.Side.of_box(1.0, 0.5, 0.5), 0.01, 1.2)
    found = errors(box, (0.01, 0, 0), (0, 0, 0), 1.2, motion.at(1.2)[0], STEPS)
    assert_first_order(found, STEPS, 0.6)
    assert found[2] < found[0] / 4


def test_fixed_steps_of_a_box_that_bounces_on_a_peak():
    """It falls flat by 0.1 m with the peak 0.2 m beside its middle, without friction. At the impact p = (1 + e) v/(1 + b²/ρ²)."""
    peak = [(-9, -9), (0, -0.1), (9, -9)]
    box = sf.Posture.box(1.0, 0.5, restitution=0.5, terrain=peak)
    fall, end = math.sqrt(0.2 / G), 0.22  # before the next impact
    p = 1.5 * G * fall / (1 + 0.04 / box.gyration_radius**2)
    rise, spin, left = p - G * fall, 0.2 * p / box.gyration_radius**2, end - fall
    exact = -0.2, 0.25 - 0.1 + rise * left - G * left**2 / 2, spin * left
    found = errors(box, (-0.2, 0, 0), (0, 0, 0), end, exact, STEPS)
    # The error of the time of the impact, up to half a step, times the change of speeds of about 3.
    assert_first_order(found, STEPS, 2)


def test_fixed_steps_of_a_box_that_slides_to_rest():
    """v²/(2μg) on level ground, which is held by corners of the body."""
    box = sf.Posture.box(1.0, 0.5, friction=0.4, terrain=[(-5, 0), (1, 0), (9, 0)])
    exact = 1.0 / (2 * 0.4 * G), 0.25, 0.0
    found = errors(box, (0, 0, 0), (1.0, 0, 0), 0.5, exact, STEPS)
    # Only the step in which it stops has an error: it lasts too long by up to a step, with a speed of up to μ g × step.
    assert_first_order(found, STEPS, 0.4 * G * STEPS[0])


def test_fixed_steps_have_the_law_of_impact_with_friction():
    """One corner of a square hits level ground: the velocity after the step is that of Moreau's law, by the library."""
    floor = [(-9, 0), (0, 0), (9, 0)]
    rng = np.random.default_rng(45)
    for _ in range(20):
        friction, e = rng.uniform(0, 1, 2)
        e_t = float(rng.uniform(0, 1))
        box = sf.Posture.box(
            1.0, 1.0, friction=friction, restitution=e, tangential_restitution=e_t,
            gravity=0.0, terrain=floor,
        )  # fmt: skip
        theta = rng.uniform(0.2, 1.2)
        arms = np.subtract(box.outline, box.center_of_mass)
        low = (math.sin(theta) * arms[:, 0] + math.cos(theta) * arms[:, 1]).min()
        q = (0, -low - 0.5 + 1e-4, theta)
        qdot = (rng.normal(), -2.0, rng.uniform(-1, 1))
        run = sf.simulate(box, q, qdot, impact="moreau", time_limit=0.01, stop="time")
        bodies = stepping.Bodies.of_postures([box], [q], [qdot], [e_t])
        _, speed = stepping.simulate(bodies, 1e-3, 1e-2, each=lambda *_: None)
        # The arm of the corner turns by up to a milliradian until the step.
        assert speed[0] == pytest.approx(run.qdot, abs=0.02)
