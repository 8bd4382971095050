import math
import sys

import told

try:
    import mujoco
except ImportError:
    print("MuJoCo is not installed: skipped", file=sys.stderr)
    sys.exit(0)

RADIUS = 0.02


def rebound(zeta):
    """The coefficient of restitution of a mass on a spring with this damping ratio that cannot pull."""
    if zeta < 1:
        w = math.sqrt(1 - zeta**2)
        return math.exp(-zeta / w * (math.pi - math.atan2(2 * zeta * w, w * w - zeta * zeta)))
    w = math.sqrt(zeta**2 - 1)
    return math.exp(-zeta / w * math.log((zeta + w) / (zeta - w))) if w > 0 else math.exp(-2)


def damping(e):
    """The damping ratio that gives this restitution, by bisection."""
    low, high = 0.0, 50.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle) > e else (low, middle)
    return low


def model(scene, dt, c=0.3, integrator="Euler", imp=1, zmin=1.0,d=0.9999):
    rigid = scene["body"]
    cos, sin = math.cos(rigid["slope"]), math.sin(rigid["slope"])
    frequency = c / dt
    zeta = damping(rigid["restitution"]) if rigid["restitution"] else zmin
    spring = f"{-(frequency**2)!r} {-2 * zeta * frequency!r}"
    mass, rho2 = rigid["mass"], rigid["gyration_radius"] ** 2
    discs = "".join(
        f'<geom size="{RADIUS}" pos="{a - RADIUS * sin!r} {b + RADIUS * cos!r} 0"/>'
        for a, b in rigid["arms"]
    )
    return mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="0 {-told.GRAVITY} 0" timestep="{dt!r}" integrator="{integrator}"
        cone="elliptic" impratio="{imp}" tolerance="1e-12"><flag refsafe="disable" sleep="disable"/></option>
        <default><geom type="sphere" friction="{rigid["friction"]} 0 0" condim="{3 if rigid["friction"] else 1}"
        solref="{spring}" solimp="{d} {d} 1" /></default>
        <worldbody><geom type="plane" size="50 50 1" zaxis="{-sin!r} {cos!r} 0"/><body>
        <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/><joint type="slide" axis="0 0 1"/><joint axis="0 0 1"/>
        <inertial pos="0 0 0" mass="{mass}" diaginertia="{mass * rho2} {mass * rho2} {mass * rho2}"/>
        {discs}</body></worldbody></mujoco>"""
    )


def simulate(name, scene, task, dt, end, **kw):
    world = model(scene, dt, **kw)
    data = mujoco.MjData(world)
    (x, y, theta), (vx, vy, omega) = scene["start"]["q"], scene["start"]["v"]
    data.qpos, data.qvel = (x, y, 0, theta), (vx, vy, 0, omega)
    rho = scene["body"]["gyration_radius"]
    steps = int(end / dt - 1e-9)
    times, speeds = [], []
    for step in range(1, steps + 2):
        if step > steps:
            world.opt.timestep = end - steps * dt
        mujoco.mj_step(world, data)
        vx, vy, _, omega = data.qvel.tolist()
        times.append(step * dt)
        speeds.append(max(abs(vx), abs(vy), abs(omega) * rho))
    x, y, _, theta = data.qpos.tolist()
    return [x, y, theta], told.settled(times, speeds)
