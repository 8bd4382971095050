"""Numbers at the ends of their ranges."""

from . import naive
from .entry import Family, refused

FAMILY = Family("Ends of the ranges")
entry = FAMILY.entry


def squares_vanish(scene):
    u, gravity = float(scene.qdot[1]), scene.posture.gravity
    h = float(scene.posture.gaps(scene.q)[0])
    error = abs(naive.textbook_root(h, u, gravity) / (2 * u / gravity) - 1)
    return (
        f"√(u² + 2gh) of u = {u:.0e} m/s is 0, the time of the landing off by {error:.0%}",
        h == 0 and error > 0.1,
    )


@entry(
    name="speeds_whose_squares_vanish",
    title="A ball that starts at 1e-170 m/s",
    breaks="The square of a speed below 1e-162 is zero.",
    method="textbook root",
    fails=squares_vanish,
    source="no double holds the square: to be refused by name",
    answer=refused,
)
def _(_scene):
    return {"refused": "speed of qdot"}


def divides(scene):
    h, u = float(scene.posture.gaps(scene.q)[0]), float(scene.qdot[1])
    try:
        naive.textbook_root(h, u, scene.posture.gravity)
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
