"""What contacts may do next."""

import math

import standfast as sf
from mpmath import mp, mpf

from . import naive
from .entry import Family, exact

FAMILY = Family("Contact modes")
entry = FAMILY.entry


def called_at_rest(scene):
    body = scene.posture
    (x, y), (cx, cy) = body.contacts[0].point, body.center_of_mass
    force = naive.static_force(x - cx, body.gyration_radius, body.gravity)
    lift = (cy - y) * scene.qdot[2] ** 2 - body.gravity
    return (
        f"a force of {force:.2f} N per kg holds the foot down, which leaves with {lift:.1f} m/s² without any",
        force > 0 and lift > 0,
    )


def lifts_off(scene):
    run = scene.simulate()
    return {"mode": run.phases[0].mode, "first impact": run.impacts["time"][0]}


@entry(
    name="lifted_by_its_own_spin",
    title="A foot that touches without speed, on a body that turns at 20 rad/s",
    breaks="h = 0 and u = 0, but the foot goes round the centre of mass: its acceleration is dω² − g > 0.",
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
    """Of a rod that slides on one end: a_n per force, and a_n without force."""
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
        f"λ = {force:.1f} m/s² per unit mass: the ground pulls the rod down",
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
    breaks="Sliding needs a negative force, and leaving the ground an acceleration into it.",
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
        f"λ = {force:.1f} m/s² per unit mass is taken; that leaving the ground is consistent as well (a_n = {free:.1f} m/s²) is not said",
        force > 0 and free > 0,
    )


@entry(
    name="painleve_with_two_modes",
    title="Painlevé's rod where two contact modes are consistent",
    breaks="A solver that returns one answer does not say that there are others.",
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
