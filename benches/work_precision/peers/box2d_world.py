"""Box2D 2.3 (pybox2d): a fixed step in single precision, with continuous collision detection.

Model: a body of the given mass and moment of inertia, with a disc centred above each contact point. The floor is an edge. Box2D keeps
a skin of .01 between shapes; the edge lies lower by this skin, so that the gaps are those of the contact points. Bodies that turn over
have discs around the points and lower ground: see harness.RADIUS.

Box2D has absolute lengths: it drops restitution below 1 m/s, leaves .005 m of penetration, and limits the displacement in a step to
2 m. Therefore all lengths are multiplied by L / dt, at most by 1e5. Restitution is then dropped below dt / L, to be compared with the
change g dt of the speed in a step. L is .1 s, or a value with smaller errors (LENGTHS): the ball comes to rest better if its
restitution is dropped early.

Settings: the usual 8 velocity and 3 position iterations (30 and 10 did not help). Sleep and continuous collisions are on, as they
are by default. (A sleeping body has no velocity, but it falls asleep only after half a second; this had no effect.) The last step is
shortened to end at the requested time. For steps below about 1e-5 s the rounding errors of single precision grow again."""

import math
import sys

import harness

try:
    import Box2D
except ImportError:
    print("Box2D is not installed: skipped", file=sys.stderr)
    sys.exit(0)

#: L in s, by scene and task.
LENGTHS = {
    ("ball", "rest"): 0.01,
    ("rod", "before"): 0.3,
    ("nested", "before"): 0.3,
    ("rocking", "rest"): 1.0,
}


def build(name, scene, task, dt, end):
    rigid, scale = scene["body"], min(LENGTHS.get((name, task), 0.1) / dt, 1e5)
    (x, y, theta), (vx, vy, omega) = scene["start"]["q"], scene["start"]["v"]
    mass, rho = rigid["mass"], rigid["gyration_radius"]
    cos, sin = math.cos(rigid["slope"]), math.sin(rigid["slope"])
    radius = 0.02 * scale
    world = Box2D.b2World(gravity=(0, -harness.GRAVITY * scale))
    turns = name in harness.TURNING
    skin, a, b = Box2D.b2_polygonRadius, 10 * scale * cos, 10 * scale * sin
    if turns:
        radius = harness.RADIUS * scale
        skin += radius
    low = (skin * sin, -skin * cos)
    edges = [[(low[0] - a, low[1] - b), (low[0] + a, low[1] + b)]]
    if "terrain" in scene:
        edges = [
            [(x * scale, y * scale - skin) for x in (begin, end)]
            for begin, end, y in harness.treads(scene)
        ]
    for vertices in edges:
        world.CreateStaticBody().CreateFixture(
            shape=Box2D.b2EdgeShape(vertices=vertices),
            friction=rigid["friction"],
            restitution=0,
        )
    body = world.CreateDynamicBody(
        position=(x * scale, y * scale),
        angle=theta,
        linearVelocity=(vx * scale, vy * scale),
        angularVelocity=omega,
    )
    for arm in rigid["arms"]:
        centre = (arm[0] * scale, arm[1] * scale)
        if not turns:
            centre = (centre[0] - radius * sin, centre[1] + radius * cos)
        disc = Box2D.b2CircleShape(radius=radius, pos=centre)
        body.CreateFixture(
            shape=disc,
            density=0 if turns else 1,  # the mass is set below
            friction=rigid["friction"],
            restitution=rigid["restitution"],
        )
    body.massData = Box2D.b2MassData(
        mass=mass, center=(0, 0), I=mass * (rho * scale) ** 2
    )
    return world, body, scale


def simulate(world, body, scale, scene, task, dt, end):
    rho = scene["body"]["gyration_radius"]
    steps = int(end / dt - 1e-9)
    times, speeds = [], []
    for step in range(1, steps + 2):
        world.Step(dt if step <= steps else end - steps * dt, 8, 3)
        if task == "before":
            continue
        vx, vy = body.linearVelocity
        times.append(step * dt)
        speeds.append(
            max(abs(vx), abs(vy), abs(body.angularVelocity) * rho * scale) / scale
        )
    x, y = body.position
    return [x / scale, y / scale, body.angle], harness.settled(times, speeds)


if __name__ == "__main__":
    harness.fixed_step(
        f"Box2D {Box2D.__version__}", sys.argv[1], build, simulate, harness.FRAME
    )
