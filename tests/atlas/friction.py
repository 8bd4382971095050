"""Sliding, and the end of it."""

import math

from mpmath import mp

from . import naive
from .entry import Family, exact, rest

FAMILY = Family("Friction")
entry = FAMILY.entry


def never_stops(scene):
    v, gravity = float(scene.qdot[0]), scene.posture.gravity
    step = 1e-3
    left = naive.friction_by_sign(
        v, scene.posture.contacts[0].friction, gravity, step, 100_000
    )
    return (
        f"after 100 s the speed is {left:.1e} m/s, of either sign by turns",
        left != 0,
    )


@entry(
    name="sliding_to_a_stop",
    title="A block that friction stops",
    breaks="Friction has a sign until the speed is zero, and none of either sign after it.",
    method="v −= μg sign(v) dt, dt = 1e-3 s",
    fails=never_stops,
    source="v/(μg) and v²/(2μg)",
    answer=lambda scene: {**rest(scene), "x": scene.simulate().q[0]},
)
def _(scene):
    v, pull = (
        exact(scene.qdot[0]),
        exact(scene.posture.contacts[0].friction) * exact(scene.posture.gravity),
    )
    return {"outcome": "rest", "elapsed": v / pull, "x": v * v / (2 * pull)}


def slides_on(scene):
    contact, gravity = scene.posture.contacts[0], scene.posture.gravity
    pull = gravity * (
        math.sin(contact.slope) - contact.friction * math.cos(contact.slope)
    )
    step = 1e-3
    v, steps = naive.steps_until_slow(step * pull, pull, step, slow=1e-6)
    return (
        f"given up after {steps} steps of {step:g} s, at {v:.0f} m/s and faster with each",
        steps == naive.STEPS,
    )


@entry(
    name="a_slope_too_steep",
    title="A block on a slope of 0.3 rad with μ = 0.1",
    breaks="It never rests: a loop until rest has no end.",
    method="steps until all speeds are below a tolerance",
    fails=slides_on,
    source="g (sin φ − μ cos φ) down the slope",
    answer=lambda scene: {
        "outcome": scene.simulate().outcome,
        "acceleration": math.hypot(*scene.simulate().acceleration[:2]),
    },
)
def _(scene):
    slope, friction = (
        exact(getattr(scene.posture.contacts[0], x)) for x in ("slope", "friction")
    )
    pull = exact(scene.posture.gravity) * (mp.sin(slope) - friction * mp.cos(slope))
    return {"outcome": "sliding", "acceleration": pull}
