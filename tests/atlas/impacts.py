"""Impacts at one instant."""

import numpy as np
from mpmath import mp, mpf

from . import naive
from .entry import Family, ball_rest, exact, rest, rod

FAMILY = Family("Impacts at one instant")
entry = FAMILY.entry


def cut_corner(scene):
    psi, e = float(rod(scene)), scene.posture.restitution
    rates = scene.posture.gap_rates(scene.q, scene.qdot)
    hits, _, slow = naive.corner_hits(psi, e, rates, 1e-10)
    return (
        f"{hits} impacts in one instant until all speeds are below 1e-10 m/s",
        slow and hits > 1e5,
    )


def first_zeno(scene):
    point = scene.simulate(stop="zeno").zeno_points[0]
    return {
        "elapsed": point.elapsed,
        "contacts": point.contacts,
        "method": point.method,
    }


@entry(
    name="corner_of_endless_chatter",
    title="One end of a rod hits while the other touches, e = 0.18, ψ = 0.9999",
    breaks="Infinitely many impacts in one instant, each of which leaves nearly all of the speed.",
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
    hits, _, slow = naive.corner_hits(psi, e, rates, 1e-15)
    return (
        f"after {hits} impacts all speeds are below 1e-15 m/s: called an endless chatter, which it is not",
        slow,
    )


def not_certified(scene):
    point = scene.simulate(stop="zeno").zeno_points[0]
    return {"elapsed": point.elapsed, "proved endless": point.certified}


@entry(
    name="corner_just_below_the_bound",
    title="The same at e = 0.3 and ψ = 0.84265, just below Goyal's bound",
    breaks="The number of impacts is finite, but speeds fall far below any cutoff before the last one.",
    method="impact by impact until 1e-15 m/s",
    fails=falsely_dead,
    source="impact by impact with 40 digits, no cutoff: the last speeds are below any double",
    answer=not_certified,
)
def _(scene):
    psi, e = rod(scene), exact(scene.posture.restitution)
    assert (1 + e) * psi < 2 * mp.sqrt(e)
    _, u, slow = naive.corner_hits(
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
        return f"impulses of both: {error}", True
    return "impulses of both are found", False


entry(
    name="two_contacts_at_one_point",
    title="Two contacts at one point of the body",
    breaks="The matrix of their impulses is singular.",
    method="one linear system for all impulses",
    fails=singular,
    source="geometric series: it is a ball",
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
        f"hit from left to right the body leaves with {omega:.2f} rad/s, from right to left with {-omega:.2f}",
        omega != 0,
    )


def without_turning(scene):
    run = scene.simulate()
    return {"outcome": run.outcome, "elapsed": run.elapsed, "theta": run.q[2]}


@entry(
    name="three_feet_at_once",
    title="Three feet that land at the same instant",
    breaks="The order in which simultaneous impacts are taken decides the motion.",
    method="impacts one after the other",
    fails=in_turn,
    source="symmetry: it bounces like a ball",
    answer=without_turning,
    within=lambda _: {"theta": 1e-13},
)
def _(scene):
    return {**ball_rest(scene), "theta": mpf(0)}
