"""Impacts at the same instant."""

import numpy as np
from mpmath import mp, mpf

from . import baseline_methods
from .entry import Family, ball_rest, exact, first_zeno, rest, rod, time_left

FAMILY = Family("Impacts at one instant")
entry = FAMILY.entry


def cut_corner(scene):
    psi, e = float(rod(scene)), scene.posture.restitution
    rates = scene.posture.gap_rates(scene.q, scene.qdot)
    hits, _, slow = baseline_methods.corner_hits(psi, e, rates, 1e-10)
    return (
        f"{hits} impacts at one instant until all speeds are below 1e-10 m/s",
        slow and hits > 1e5,
    )


@entry(
    name="corner_of_endless_chatter",
    title="One end of a rod hits while the other touches, e = 0.18, ψ = 0.9999",
    breaks="There are infinitely many impacts at one instant, and each keeps nearly all of the speed.",
    method="impact by impact until 1e-10 m/s",
    fails=cut_corner,
    source="Goyal's bound: (1 + e) ψ ≥ 2 √e",
    answer=first_zeno,
)
def _(scene):
    e = exact(scene.posture.restitution)
    assert (1 + e) * rod(scene) >= 2 * mp.sqrt(e)
    return {"elapsed": mpf(0), "contacts": (1, 2), "method": "chatter"}


def falsely_dead(scene):
    psi, e = float(rod(scene)), scene.posture.restitution
    rates = scene.posture.gap_rates(scene.q, scene.qdot)
    hits, _, slow = baseline_methods.corner_hits(psi, e, rates, 1e-15)
    return (
        f"after {hits} impacts all speeds are below 1e-15 m/s; the method calls this an endless chatter, but the sequence ends",
        slow,
    )


def not_certified(scene):
    point = scene.simulate(stop="zeno").zeno_points[0]
    return {"elapsed": point.elapsed, "proved endless": point.certified}


@entry(
    name="corner_just_below_the_bound",
    title="The same at e = 0.3 and ψ = 0.84265, just below Goyal's bound",
    breaks="The number of impacts is finite, but the speeds fall far below any cutoff before the last impact.",
    method="impact by impact until 1e-15 m/s",
    fails=falsely_dead,
    source="impact by impact with 40 digits, no cutoff; the last speeds are below the least double",
    answer=not_certified,
)
def _(scene):
    psi, e = rod(scene), exact(scene.posture.restitution)
    assert (1 + e) * psi < 2 * mp.sqrt(e)
    _, u, slow = baseline_methods.corner_hits(
        psi,
        e,
        [mpf(float(x)) for x in scene.posture.gap_rates(scene.q, scene.qdot)],
        mpf(0),
    )
    assert not slow
    assert all(x >= 0 for x in u)
    assert 0 < max(u) < mpf(5e-324)
    return {"elapsed": mpf(0), "proved endless": False}


def singular(scene):
    body = scene.posture
    rho2 = body.gyration_radius**2
    b = [k.point[0] - body.center_of_mass[0] for k in body.contacts]
    matrix = np.array([[1 + x * y / rho2 for y in b] for x in b])
    try:
        np.linalg.solve(matrix, np.array([1.0, 1.0]))
    except np.linalg.LinAlgError as error:
        return f"the linear solver fails: {error}", True
    return "impulses of both are found", False


entry(
    name="two_contacts_at_one_point",
    title="Two contacts at one point of the body",
    breaks="The matrix of their impulses is singular.",
    method="one linear system for all impulses",
    fails=singular,
    source="geometric series: the body bounces like a ball",
    answer=rest,
)(ball_rest)


def in_turn(scene):
    body = scene.posture
    rho2, e = body.gyration_radius**2, body.restitution
    b = [k.point[0] - body.center_of_mass[0] for k in body.contacts]
    v, omega = -1.0, 0.0
    for x in b:
        u = v + x * omega
        if u < 0:
            p = -(1 + e) * u / (1 + x * x / rho2)
            v, omega = v + p, omega + p * x / rho2
    return (
        f"if the feet are hit from left to right, the body leaves with {omega:.2f} rad/s, from right to left with {-omega:.2f}",
        omega != 0,
    )


def without_turning(scene):
    return {**rest(scene), "theta": scene.simulate().q[2]}


@entry(
    name="three_feet_at_once",
    title="Three feet that land at the same instant",
    breaks="The order in which simultaneous impacts are computed decides the motion.",
    method="impacts one after the other",
    fails=in_turn,
    source="symmetry: the body bounces like a ball",
    answer=without_turning,
    within=lambda _: {"theta": 1e-13},
)
def _(scene):
    return {**ball_rest(scene), "theta": mpf(0)}


def struck(scene):
    """Arm, velocity of the contact (tangential, normal), impact matrix (tt, nt, nn), mass one, level ground: exact."""
    body = scene.posture
    b, c = (
        exact(x) - exact(y)
        for x, y in zip(body.contacts[0].point, body.center_of_mass, strict=True)
    )
    rho2 = exact(body.gyration_radius) ** 2
    v = exact(scene.qdot[0]), exact(scene.qdot[1])
    assert (body.mass, scene.qdot[2]) == (1, 0)
    return v, (1 + c * c / rho2, -b * c / rho2, 1 + b * b / rho2)


def work(v, w, p):
    """Work of impulses (tangential, normal) on a contact: v·p + p·Wp/2."""
    (tt, nt, nn), (p_t, p_n) = w, p
    return (
        v[0] * p_t + v[1] * p_n + (tt * p_t**2 + 2 * nt * p_t * p_n + nn * p_n**2) / 2
    )


def gained(v, w, after):
    """Kinetic energy added by this change of the contact's velocity: the work v̄·p of its impulse."""
    tt, nt, nn = (float(x) for x in w)
    jump = np.array([after[k] - float(v[k]) for k in (0, 1)])
    p = np.linalg.solve([[tt, nt], [nt, nn]], jump)
    return float(p @ (np.array([float(x) for x in v]) + jump / 2))


def energy_told(scene):
    run = scene.simulate()
    (vx, vy, omega), rho = run.at(0.0)[1], scene.posture.gyration_radius
    lost = (vx**2 + vy**2 + (rho * omega) ** 2) / 2 - sum(scene.qdot**2) / 2
    return {"energy gained": lost}


def adds_energy(scene, energy):
    return (
        f"the impact adds {energy:.3f} J to {sum(scene.qdot**2) / 2:.2f} J",
        energy > 0,
    )


def by_newton(scene):
    v, w = struck(scene)
    body = scene.posture
    numbers = [float(x) for x in v], [float(x) for x in w]
    after = baseline_methods.newton_with_friction(
        *numbers, body.contacts[0].friction, body.restitution
    )
    return adds_energy(scene, gained(v, w, after))


@entry(
    name="energy_from_an_impact",
    title="A rod that falls on its end at 45°, e = 0.9, μ = 1",
    breaks="With friction Newton's law, v⁺ = −e v⁻, can increase the energy.",
    method="friction during the impact, ended where v⁺ = −e v⁻",
    fails=by_newton,
    source="Poisson's law by hand: slides until v_t = 0, sticks, ends at (1 + e) times the impulse of compression",
    answer=energy_told,
)
def _(scene):
    v, w = struck(scene)
    tt, nt, nn = w
    mu, e = exact(scene.posture.contacts[0].friction), exact(scene.posture.restitution)
    assert v[0] < 0
    assert abs(nt) <= mu * tt
    # It slides to the left with P_t = μ P_n until v_t = 0; then P_t = −(nt/tt) P_n + const, v_n' = nn − nt²/tt.
    stop = -v[0] / (nt + mu * tt)
    normal = v[1] + (nn + mu * nt) * stop
    assert normal < 0
    end = (1 + e) * (stop - normal / (nn - nt**2 / tt))
    return {"energy gained": work(v, w, (mu * stop - nt / tt * (end - stop), end))}


def by_moreau(scene):
    v, w = struck(scene)
    contact, e = scene.posture.contacts[0], scene.posture.restitution
    after = baseline_methods.moreau_impact(
        [float(x) for x in v], e, contact.tangential_restitution
    )
    return adds_energy(scene, gained(v, w, after))


@entry(
    name="energy_from_tangential_restitution",
    title="The same rod with restitutions 0.1 and, along the ground, 0.9",
    breaks="Where the two coefficients differ, Moreau's law can increase the energy.",
    method="Moreau's law",
    fails=by_moreau,
    source="the formula of Chatterjee and Ruina",
    answer=energy_told,
)
def _(scene):
    v, w = struck(scene)
    tt, nt, nn = w
    contact, e = scene.posture.contacts[0], exact(scene.posture.restitution)
    mu, e_t = exact(contact.friction), exact(contact.tangential_restitution)
    det = tt * nn - nt**2
    stop = -v[1] / nn
    both = -(nn * v[0] - nt * v[1]) / det, -(tt * v[1] - nt * v[0]) / det
    p = (1 + e_t) * both[0], (1 + e) * stop + (1 + e_t) * (both[1] - stop)
    if abs(p[0]) > mu * p[1]:
        k = mu * (1 + e) * stop / (abs(both[0]) - mu * (both[1] - stop))
        p = k * both[0], (1 + e) * stop + k * (both[1] - stop)
    return {"energy gained": work(v, w, p)}


#: Number of sweeps over the contacts per step of an engine.
SWEEPS = 10


def cut_sweeps(scene):
    rates = scene.posture.gap_rates(scene.q, scene.qdot)
    u = baseline_methods.sequential_impulses(float(rod(scene)), rates, SWEEPS)
    hits, right = after_the_corner(scene, rod(scene))
    return (
        f"after {SWEEPS} sweeps the rates are {u[0]:.1e} and {u[1]:.1e} m/s; after all {hits} impacts {float(right[0]):.1e} and {float(right[1]):.1e}",
        abs(u[0] - right[0]) > 0.01,
    )


def after_the_corner(scene, psi):
    rates = [exact(x) for x in scene.posture.gap_rates(scene.q, scene.qdot)]
    hits, u, _ = baseline_methods.corner_hits(
        psi, exact(scene.posture.restitution), rates, mpf(0)
    )
    return hits, u


def left_after_the_corner(scene, psi):
    _, (u1, u2) = after_the_corner(scene, psi)
    gravity, e = exact(scene.posture.gravity), exact(scene.posture.restitution)
    rest = u1 * time_left((u2 / u1, mpf(0)), gravity, psi, e, mpf(10) ** -30)
    return {"elapsed": rest, "rate 1": u1, "rate 2": u2}


def rounded_coupling(scene):
    """Error caused by an error of four ulp of ψ = (b² − ρ²)/(b² + ρ²). The rates rotate by arccos(ψ/bound) per
    impact, and for this ratio the derivative of the arccosine is large."""
    psi = rod(scene)
    one, other = (
        left_after_the_corner(scene, x) for x in (psi, psi * (1 + mpf(2) ** -51))
    )
    return {name: float(abs(other[name] / x - 1)) for name, x in one.items()}


def told_after_the_corner(scene):
    run = scene.simulate()
    rates = scene.posture.gap_rates(*run.at(0.0))
    return {**rest(scene), "rate 1": rates[0], "rate 2": rates[1]}


@entry(
    name="corner_of_3000_impacts",
    title="Three thousand impacts at one instant, e = 0.99",
    breaks="One end hits the ground while the other touches it. Both are hit in turn thousands of times before both leave.",
    method=f"sequential impulses, {SWEEPS} sweeps",
    fails=cut_sweeps,
    source="impact by impact with 40 digits",
    answer=told_after_the_corner,
    within=rounded_coupling,
)
def _(scene):
    return {"outcome": "rest", **left_after_the_corner(scene, rod(scene))}
