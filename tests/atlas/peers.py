"""Other engines on the scenes of the atlas, with the models of `benches/work_precision/peers`."""

import importlib
import math
import sys
from pathlib import Path

PEERS = Path(__file__).parents[2] / "benches" / "work_precision" / "peers"


def told(scene):
    """A scene in the format of the files of `benches/work_precision/peers`: arms from the centre of mass, one floor
    through (0, 0)."""
    body = scene.posture
    (x, y), (first, *_) = body.center_of_mass, body.contacts
    return {
        "body": {
            "mass": body.mass,
            "gyration_radius": body.gyration_radius,
            "restitution": body.restitution,
            "friction": first.friction,
            "slope": first.slope,
            "arms": [[k.point[0] - x, k.point[1] - y] for k in body.contacts],
        },
        "start": {
            "q": [float(a) + b for a, b in zip(scene.q, (x, y, 0), strict=True)],
            "v": list(map(float, scene.qdot)),
        },
    }


def simulate(engine, scene, step, end, name="", task="rest"):
    """Final displacement (x, y, θ), and the time from which on all speeds are below 1e-6 m/s; None if there is none."""
    sys.path.insert(0, str(PEERS))
    try:
        peer = importlib.import_module(engine)
    finally:
        sys.path.remove(str(PEERS))
    known = told(scene)
    ready = peer.build(name, known, task, step, end)
    q, time = peer.simulate(*ready, known, task, step, end)
    at = (*scene.posture.center_of_mass, 0.0)
    return [a - b for a, b in zip(q, at, strict=True)], time


def box2d_ball(h, restitution, gravity, step, end):
    """Box2D in metres: a ball dropped from h, and its largest height after the first impact."""
    import Box2D

    world = Box2D.b2World(gravity=(0, -gravity))
    edge = Box2D.b2EdgeShape(vertices=[(-1, 0), (1, 0)])
    world.CreateStaticBody().CreateFixture(shape=edge, restitution=0)
    skin = Box2D.b2_polygonRadius
    body = world.CreateDynamicBody(position=(0, 0.1 + skin + h))
    circle = Box2D.b2CircleShape(radius=0.1)
    body.CreateFixture(shape=circle, density=1, restitution=restitution)
    highest, landed = 0.0, False
    for _ in range(round(end / step)):
        world.Step(step, 8, 3)
        now = body.position[1] - 0.1 - skin
        landed = landed or now < 0.01 * h
        highest = max(highest, now) if landed else 0.0
    return highest


def mujoco_block(slope, friction, gravity, end):
    """MuJoCo with its defaults: a box at rest on a slope, and its final displacement along it."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="{-gravity * math.sin(slope)!r} 0 {-gravity * math.cos(slope)!r}"/>
        <default><geom friction="{friction} 0 0"/></default><worldbody><geom type="plane" size="50 50 1"/>
        <body pos="0 0 .1"><freejoint/><geom type="box" size=".5 .5 .1" mass="1"/></body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, round(end / model.opt.timestep))
    return data.qpos[0]
