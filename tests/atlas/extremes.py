"""Numbers at the ends of their ranges."""

import math

import numpy as np
import oracle
import standfast as sf
from mpmath import mp, mpf

from . import baseline_methods
from .entry import Family, ball_rest, dropped, exact, first_zeno, refused, rest, rod

FAMILY = Family("Ends of the ranges")
entry = FAMILY.entry


def squares_vanish(scene):
    u, gravity = float(scene.qdot[1]), scene.posture.gravity
    h = float(scene.posture.gaps(scene.q)[0])
    error = abs(baseline_methods.textbook_root(h, u, gravity) / (2 * u / gravity) - 1)
    return (
        f"√(u² + 2gh) of u = {u:.0e} m/s is 0; the error of the time of the landing is {error:.0%}",
        h == 0 and error > 0.1,
    )


@entry(
    name="speeds_whose_squares_vanish",
    title="A ball that starts at 1e-170 m/s",
    breaks="The square of a speed below 1e-162 is zero.",
    method="textbook root",
    fails=squares_vanish,
    source="no double can represent the square: the start must be refused with the name of the field",
    answer=refused,
)
def _(_scene):
    return {"refused": "speed of qdot"}


def divides(scene):
    h, u = float(scene.posture.gaps(scene.q)[0]), float(scene.qdot[1])
    try:
        baseline_methods.textbook_root(h, u, scene.posture.gravity)
    except ZeroDivisionError as error:
        return f"{type(error).__name__}: {error}", True
    return "a number", False


@entry(
    name="without_gravity",
    title="A body that drifts away, without gravity",
    breaks="There is no next collision, and the formula for it divides by g.",
    method="textbook root",
    fails=divides,
    source="a straight line away from the ground",
    answer=lambda scene: {"outcome": scene.simulate().outcome},
)
def _(scene):
    assert scene.posture.gravity == 0
    assert scene.qdot[1] > 0
    return {"outcome": "escape"}


def ill_conditioned(scene):
    body = scene.posture
    rho2, b = body.gyration_radius**2, [k.point[0] for k in body.contacts]
    matrix = np.array([[1 + x * y / rho2 for y in b] for x in b])
    forces = np.linalg.solve(matrix, np.full(2, body.gravity))
    error = max(abs(forces / (body.gravity / 2) - 1))
    return f"the error of the force of each foot at rest is {error:.0e}", error > 1e-11


def clatters(scene):
    inputs = oracle_inputs(scene)
    return {"outcome": "rest", "elapsed": mpf(str(oracle.orbit(inputs).zeno.time))}


def with_forces(scene):
    body = scene.posture
    force = sf.contact_modes(body)["FF"].forces[:, 1]
    return {**rest(scene), "force of foot 1": force[0], "force of foot 2": force[1]}


def oracle_inputs(scene):
    body = scene.posture
    q, qdot = ([float(x) for x in y] for y in (scene.q, scene.qdot))
    points = {
        f"x{i}_{axis}": k.point[n]
        for i, k in enumerate(body.contacts, 1)
        for n, axis in enumerate("xy")
    }
    return {
        "e": body.restitution, "g": body.gravity, "rho": body.gyration_radius,
        "x_x": body.center_of_mass[0], "x_y": body.center_of_mass[1], **points,
        "alpha1": body.contacts[0].slope, "alpha2": body.contacts[1].slope,
        **dict(zip(("r_x", "r_y", "theta"), q, strict=True)), **dict(zip(("v_x", "v_y", "omega"), qdot, strict=True)),
    }  # fmt: skip


@entry(
    name="rho_tiny",
    title="A radius of gyration of a ten-thousandth of a metre under a rod of one metre",
    breaks="ψ₁ψ₂ → 1: the two contact rows become nearly equal, because ρ is small beside the arms.",
    method="forces by the matrix of the contacts",
    fails=ill_conditioned,
    source="impact by impact with 36 digits and more; half of the weight by symmetry",
    answer=with_forces,
)
def _(scene):
    half = exact(scene.posture.mass) * exact(scene.posture.gravity) / 2
    return {**clatters(scene), "force of foot 1": half, "force of foot 2": half}


def difference(scene):
    body = scene.posture
    psi, half = float(rod(scene)), body.contacts[1].point[0]
    low, _ = sorted(body.gaps(scene.q))
    u = -math.sqrt(2 * body.gravity * low)
    rates = -body.restitution * u, u + (1 + body.restitution) * psi * u
    omega = (rates[1] - rates[0]) / (2 * half)
    right = float(first_turn(scene))
    error = abs(omega / right - 1)
    return (
        f"the error of the angular velocity after the first impact is {error:.0e}",
        error > 1e-9,
    )


def first_turn(scene):
    """Angular velocity after the first impact."""
    body = scene.posture
    half, rho2 = exact(body.contacts[1].point[0]), exact(body.gyration_radius) ** 2
    theta, gravity = exact(scene.q[2]), exact(body.gravity)
    u = mp.sqrt(2 * gravity * (exact(scene.q[1]) - half * mp.sin(theta)))
    b = half * mp.cos(theta)
    return -(1 + exact(body.restitution)) * u * b / (rho2 + b * b)


@entry(
    name="rho_huge",
    title="A radius of gyration of fifty kilometres",
    breaks="ψ → −1: both ends rebound together, and the small rotation is lost in the rounding of their rates.",
    method="ω as a difference of the rates of both ends",
    fails=difference,
    source="impact by impact with 36 digits and more",
    answer=lambda scene: {
        **first_zeno(scene),
        "ω": scene.simulate().zeno_points[0].omega,
    },
)
def _(scene):
    zeno = oracle.orbit(oracle_inputs(scene)).zeno
    return {
        "elapsed": mpf(str(zeno.time)),
        "contacts": (zeno.contact,),
        "method": zeno.method,
        "ω": mpf(str(zeno.state["omega"])),
    }


def by_energy(scene):
    h, gravity, _ = (float(x) for x in dropped(scene))
    speed = baseline_methods.speed_by_energy(scene.posture.mass, gravity, h)
    return f"the speed at the landing is {speed:g} m/s", speed in (0.0, math.inf)


for name, title, breaks in (
    (
        "a_denormal_height",
        "A ball of 1e-10 kg dropped from 1e-320 m",
        "The energy mgh is below the least double.",
    ),
    (
        "heights_of_1e100",
        "A ball of 1e140 kg dropped from 1e100 m with a gravity of 1e100 m/s²",
        "The energy mgh is above the largest double.",
    ),
):
    entry(
        name=name,
        title=title,
        breaks=breaks,
        method="√(2E/m), E = mgh",
        fails=by_energy,
        source="geometric series",
        answer=rest,
    )(ball_rest)
