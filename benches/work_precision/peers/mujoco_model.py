"""MuJoCo: a fixed step (semi-implicit Euler; RK4 costs three times as much and gained little: the error comes from the impacts).

Model: a body of the mass and moment on joints along x, y, z and about z (the body never moves along z, but MuJoCo scales a
contact by the mean over the three directions), with a disc (sphere) of radius .02 above each contact point, on an inclined plane. Bodies
that turn over have discs around the points and lower ground: see harness.RADIUS.

MuJoCo has no coefficient of restitution: a contact is a spring and a damper that cannot pull, `solref` = (-k, -b) for the mass
1 that it feels. The damping ratio follows from e in closed form (`rebound`). The frequency is c / dt, about the highest that the step
resolves; c is chosen for each scene by trial. For bounces c decreases with the step as dt^(1/4): with shorter steps a contact then
lasts a shorter time and has more steps. For the slide c is .03, because a stiff spring lifts a sliding contact (the friction cone is
convex), but .5 for the slide until rest; for rocking it is .5. `solimp` is constant: .9999, the hardest contact, but .9 for bounces
until rest, because the hardest contact chatters for ever at the size of a step. Elliptic cones, Newton's method, tolerance 1e-12. The
last step is shortened to end at the requested time.

Limits of the model: an impact is not instantaneous, and an impact of two contacts does not follow Newton's law. In an impact friction
is a damper, too, which often does not stop the sliding before the contact ends, with steps of any length: the spin after it then differs
from that of a law of restitution with Coulomb's friction."""

import math
import sys

import harness

try:
    import mujoco
except ImportError:
    print("MuJoCo is not installed: skipped", file=sys.stderr)
    sys.exit(0)

RADIUS = 0.02
#: The step unless told otherwise, in s.
TWO_MILLISECONDS = 0.002


def rebound(zeta):
    """The coefficient of restitution of a mass on a spring with this damping ratio that cannot pull."""
    if zeta < 1:
        w = math.sqrt(1 - zeta**2)
        return math.exp(
            -zeta / w * (math.pi - math.atan2(2 * zeta * w, w * w - zeta * zeta))
        )
    w = math.sqrt(zeta**2 - 1)
    return (
        math.exp(-zeta / w * math.log((zeta + w) / (zeta - w)))
        if w > 0
        else math.exp(-2)
    )


def damping(e):
    """The damping ratio that gives this restitution, by bisection."""
    low, high = 0.0, 50.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > e else (low, middle)
    return low


def model(name, scene, task, dt):
    rigid = scene["body"]
    cos, sin = math.cos(rigid["slope"]), math.sin(rigid["slope"])
    bounces = rigid["restitution"] > 0
    if bounces:
        zeta, frequency = damping(rigid["restitution"]), 0.2 * (dt / 1e-3) ** 0.25 / dt
    else:
        zeta, frequency = (
            1.0,
            (0.03 if name == "block" and task == "before" else 0.5) / dt,
        )
    impedance = 0.9 if bounces and task == "rest" else 0.9999
    spring = f"{-(frequency**2)!r} {-2 * zeta * frequency!r}"
    mass, rho2 = rigid["mass"], rigid["gyration_radius"] ** 2
    turns = name in harness.TURNING
    radius = harness.RADIUS if turns else RADIUS
    up = (0.0, 0.0) if turns else (-radius * sin, radius * cos)
    discs = "".join(
        f'<geom size="{radius}" pos="{a + up[0]!r} {b + up[1]!r} 0"/>'
        for a, b in rigid["arms"]
    )
    low = radius if turns else 0.0
    ground = f'<geom type="plane" size="50 50 1" pos="0 {-low!r} 0" zaxis="{-sin!r} {cos!r} 0"/>'
    if "terrain" in scene:
        deep = harness.DEEP / 2
        ground = "".join(
            f'<geom type="box" size="{(b - a) / 2!r} {deep!r} 1" pos="{(a + b) / 2!r} {y - low - deep!r} 0"/>'
            for a, b, y in harness.treads(scene)
        )
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="0 {-harness.GRAVITY} 0" timestep="{dt!r}"
        cone="elliptic" tolerance="1e-12"><flag refsafe="disable"/></option>
        <default><geom type="sphere" friction="{rigid["friction"]} 0 0" condim="{3 if rigid["friction"] else 1}"
        solref="{spring}" solimp="{impedance} {impedance} 1"/></default>
        <worldbody>{ground}<body>
        <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 0 1"/>
        <inertial pos="0 0 0" mass="{mass}" diaginertia="{mass * rho2} {mass * rho2} {mass * rho2}"/>
        {discs}</body></worldbody></mujoco>"""
    )


def build(name, scene, task, dt, end):
    world = model(name, scene, task, dt)
    data = mujoco.MjData(world)
    (x, y, theta), (vx, vy, omega) = scene["start"]["q"], scene["start"]["v"]
    data.qpos, data.qvel = (x, y, 0, theta), (vx, vy, 0, omega)
    return world, data


def simulate(world, data, scene, task, dt, end):
    rho = scene["body"]["gyration_radius"]
    steps = int(end / dt - 1e-9)
    times, speeds = [], []
    if task == "before":  # no state is read on the way
        mujoco.mj_step(world, data, steps)
    for step in range(steps + 1 if task == "before" else 1, steps + 2):
        if step > steps:
            world.opt.timestep = end - steps * dt
        mujoco.mj_step(world, data)
        vx, vy, _, omega = data.qvel.tolist()
        times.append(step * dt)
        speeds.append(max(abs(vx), abs(vy), abs(omega) * rho))
    x, y, _, theta = data.qpos.tolist()
    return [x, y, theta], harness.settled(times, speeds)


if __name__ == "__main__":
    harness.fixed_step(
        f"MuJoCo {mujoco.__version__}", sys.argv[1], build, simulate, TWO_MILLISECONDS
    )
