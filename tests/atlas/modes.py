"""Contact modes."""

import math
from fractions import Fraction

import modes_oracle
import numpy as np
import standfast as sf
from mpmath import mp, mpf

from . import baseline_methods
from .entry import Family, exact

FAMILY = Family("Contact modes")
entry = FAMILY.entry


def called_at_rest(scene):
    body = scene.posture
    (x, y), (cx, cy) = body.contacts[0].point, body.center_of_mass
    force = baseline_methods.static_force(x - cx, body.gyration_radius, body.gravity)
    lift = (cy - y) * scene.qdot[2] ** 2 - body.gravity
    return (
        f"a force of {force:.2f} N per kg holds the foot at the ground; in fact it leaves with {lift:.1f} m/s², without a force",
        force > 0 and lift > 0,
    )


def lifts_off(scene):
    run = scene.simulate()
    return {"mode": run.phases[0].mode, "first impact": run.impacts["time"][0]}


@entry(
    name="lifted_by_its_own_spin",
    title="A foot that touches without speed, on a body that turns at 20 rad/s",
    breaks="h = 0 and u = 0, but the foot turns about the centre of mass, and its acceleration is dω² − g > 0.",
    method="balance of forces where h = u = 0",
    fails=called_at_rest,
    source="h = −½gt² + d (1 − cos ωt), scanned with 40 digits",
    answer=lifts_off,
)
def _(scene):
    d, gravity = exact(scene.posture.center_of_mass[1]), exact(scene.posture.gravity)
    omega = exact(scene.qdot[2])
    assert d * omega**2 > gravity

    def gap(t):
        return -gravity * t * t / 2 + d * (1 - mp.cos(omega * t))

    step = mpf(1) / 1000
    t = step
    while gap(t) > 0:
        t += step
    return {
        "mode": "S",
        "first impact": mp.findroot(gap, (t - step, t), solver="anderson"),
    }


def painleve(scene):
    """For a rod that slides on one end: a_n per force, and a_n without force."""
    body = scene.posture
    (x, y), (cx, cy) = body.contacts[0].point, body.center_of_mass
    b, c = x - cx, y - cy
    way = math.copysign(1.0, scene.qdot[0] - c * scene.qdot[2])
    friction = body.contacts[0].friction
    slope = 1 + b * (b + way * friction * c) / body.gyration_radius**2
    return slope, -body.gravity - c * scene.qdot[2] ** 2


def negative_force(scene):
    slope, free = painleve(scene)
    force = -free / slope
    return (
        f"λ = {force:.1f} m/s² (force per unit mass): the ground would pull the rod down",
        force < 0,
    )


def words(scene):
    modes = sf.contact_modes(scene.posture, scene.q, scene.qdot)
    return {
        "status": modes.status,
        "words": tuple(sorted(str(word) for word in modes.consistent)),
        "outcome": scene.simulate(impact="newton").outcome,
    }


@entry(
    name="painleve_without_a_mode",
    title="Painlevé's rod where no contact mode is consistent",
    breaks="Sliding would need a negative normal force, and leaving the ground would need an acceleration into the ground.",
    method="a_n = 0 solved for the force of sliding",
    fails=negative_force,
    source="signs of a_n and of its slope in the force, with exact arms",
    answer=words,
)
def _(scene):
    slope, free = painleve(scene)
    assert slope < 0
    assert free < 0
    return {"status": "none", "words": (), "outcome": "inconsistent"}


def only_one(scene):
    slope, free = painleve(scene)
    force = -free / slope
    return (
        f"λ = {force:.1f} m/s² (force per unit mass) is taken; the method does not report that leaving the ground is consistent as well (a_n = {free:.1f} m/s²)",
        force > 0 and free > 0,
    )


@entry(
    name="painleve_with_two_modes",
    title="Painlevé's rod where two contact modes are consistent",
    breaks="A solver that returns one answer does not report that there are others.",
    method="a_n = 0 solved for the force of sliding",
    fails=only_one,
    source="signs of a_n and of its slope in the force, with exact arms",
    answer=words,
)
def _(scene):
    slope, free = painleve(scene)
    assert slope < 0
    assert free > 0
    way = "R" if scene.qdot[0] - scene.qdot[2] * (
        scene.posture.contacts[0].point[1] - scene.posture.center_of_mass[1]
    ) > 0 else "L"  # fmt: skip
    return {
        "status": "ambiguous",
        "words": tuple(sorted(("S", way))),
        "outcome": "ambiguous",
    }


def fraction_of(scene):
    """The contact problem of a scene at q = 0 in fractions. The tangent of half a slope is rounded to a millionth, or exact
    if the slope is that of a triangle with short integer sides."""
    body, (vx, vy, omega) = scene.posture, map(Fraction, map(float, scene.qdot))
    arms = tuple(
        tuple(
            Fraction(a) - Fraction(b)
            for a, b in zip(k.point, body.center_of_mass, strict=True)
        )
        for k in body.contacts
    )
    halves = [
        Fraction(math.tan(k.slope / 2)).limit_denominator(10**6) for k in body.contacts
    ]
    tangents = tuple(((1 - x * x) / (1 + x * x), 2 * x / (1 + x * x)) for x in halves)
    sliding, bias = [], []
    for (x, y), (tx, ty) in zip(arms, tangents, strict=True):
        assert -ty * (vx - omega * y) + tx * (vy + omega * x) == 0
        slip = tx * (vx - omega * y) + ty * (vy + omega * x)
        sliding.append((slip > 0) - (slip < 0))
        bias.append((-(omega**2) * (tx * x + ty * y), -(omega**2) * (tx * y - ty * x)))
    return modes_oracle.Problem(
        mass=Fraction(body.mass),
        rho2=Fraction(body.gyration_radius**2).limit_denominator(10**6),
        arms=arms,
        tangents=tangents,
        friction=tuple(Fraction(k.friction) for k in body.contacts),
        sliding=tuple(sliding),
        bias=tuple(bias),
        free_acceleration=(Fraction(0), -Fraction(body.gravity), Fraction(0)),
    )


def swept(scene, order, sweeps):
    """Forces after sweeps over the contacts in this order, and their last change."""
    problem = fraction_of(scene)
    contacts = [
        (
            np.array(problem.normal_row(i), float),
            np.array(problem.tangential_row(i), float),
            float(problem.friction[i]),
            problem.sliding[i],
            tuple(map(float, problem.bias[i])),
        )
        for i in range(problem.size)
    ]
    free = tuple(map(float, problem.free_acceleration))
    return baseline_methods.gauss_seidel(
        contacts, free, float(problem.rho2), order, sweeps
    )


def diverges(scene):
    changes = [swept(scene, (0, 1), sweeps)[1] for sweeps in (10, 20)]
    return (
        f"the forces change by {changes[0]:.0e} m/s² in the tenth sweep and by {changes[1]:.0e} in the twentieth: they do not converge",
        changes[1] > changes[0] > 1,
    )


def chosen(scene):
    """The closed contacts after sweeps in either order."""
    found = []
    for order in ((0, 1), (1, 0)):
        forces, change = swept(scene, order, 2000)
        closed = [str(i + 1) for i in (0, 1) if forces[i][1] > 1e-9]
        found.append(" and ".join(closed) or "none" if change < 1e-9 else "?")
    return found


def one_of_several(scene):
    first, second = chosen(scene)
    several = len(fraction_of_words(scene)["words"])
    came = first if first == second else f"{first}, or {second} in the other order"
    return (
        f"contacts kept: {came}; the method does not report that there are {several} answers",
        several > 1,
    )


def fraction_of_words(scene):
    words = tuple(sorted(modes_oracle.consistent_words(fraction_of(scene))))
    status = ("none", "unique")[len(words)] if len(words) < 2 else "ambiguous"
    return {"status": status, "words": words}


def modes_alone(scene):
    found = words(scene)
    return {"status": found["status"], "words": found["words"]}


SWEEPS = "one contact after the other, sweep by sweep (projected Gauss–Seidel)"
ALL_WORDS = "all words tried in exact fractions"

for name, title, breaks, fails in (
    (
        "painleve_two_feet_without_a_mode",
        "Two feet that slide, and no contact mode is consistent",
        "The force that should keep the front foot from sinking into the ground presses it in.",
        diverges,
    ),
    (
        "painleve_on_both_feet_with_one_mode",
        "Two feet, each of which would jam alone, and one mode of both",
        "Each foot is pressed into the ground by its own force; the force of the other foot prevents this.",
        diverges,
    ),
    (
        "painleve_with_four_modes",
        "Two feet, four consistent contact modes",
        "Both feet may leave the ground, or either foot, or neither.",
        one_of_several,
    ),
    (
        "three_ways_from_rest",
        "A body at rest that may stay at rest or tip over either foot",
        "At rest a mode always exists, but there may be several.",
        one_of_several,
    ),
):
    entry(
        name=name,
        title=title,
        breaks=breaks,
        method=SWEEPS,
        fails=fails,
        source=ALL_WORDS,
        answer=modes_alone,
    )(fraction_of_words)


def least_squares(scene):
    body = scene.posture
    at = [k.point[0] - body.center_of_mass[0] for k in body.contacts]
    forces, *_ = np.linalg.lstsq(
        np.array([np.ones(3), at]), np.array([body.gravity, 0.0]), rcond=None
    )
    return (
        f"normal forces {', '.join(f'{x:.2f}' for x in forces)} m/s²: one force is negative, and the method lets the body tip",
        min(forces) < 0,
    )


entry(
    name="three_feet_on_a_floor",
    title="Three feet on a level floor",
    breaks="There are three forces and two equations: the forces are not unique, and those of least squares may be negative.",
    method="least squares",
    fails=least_squares,
    source=ALL_WORDS,
    answer=modes_alone,
)(fraction_of_words)
