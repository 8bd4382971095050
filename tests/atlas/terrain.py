"""Terrain with ends and vertices."""

from . import naive
from .entry import Family, exact

FAMILY = Family("Terrain")
entry = FAMILY.entry


def no_edge(scene):
    end, gravity = scene.posture.contacts[0].segment[1], scene.posture.gravity
    x, height = naive.on_a_line(float(scene.qdot[0]), gravity, 1e-3, 1.0)
    return (
        f"after 1 s the foot stands at a height of {height:g} m, {x - end:.2f} m beyond the last of the ground",
        x > end and height == 0,
    )


@entry(
    name="over_the_edge",
    title="A foot that slides off its terrain",
    breaks="Ground has an end; the contact must end with it.",
    method="contact with an unbounded line",
    fails=no_edge,
    source="the way to the end over the speed",
    answer=lambda scene: {
        "outcome": scene.simulate().outcome,
        "leaves": scene.simulate().phases[0].end,
    },
)
def _(scene):
    way = exact(scene.posture.contacts[0].segment[1])
    return {"outcome": "escape", "leaves": way / exact(scene.qdot[0])}
