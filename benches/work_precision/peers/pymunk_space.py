"""pymunk (Chipmunk): a fixed step in double precision.

Model: a body of the given mass and moment of inertia, with a disc of radius .02 centred above each contact point. A disc touches a
line under its centre, so that its gap and the lever of its normal force are those of the contact point. The floor is a static line of
half thickness 1 whose surface is the floor: a disc that has sunk in is still pushed out upwards.

Bodies that turn over have discs around the points and lower ground: see harness.RADIUS.

Settings: elasticity e on the discs and 1 on the floor, friction likewise (they are multiplied), collision_slop = 0 (the default
of 0.1 is a length), 10 iterations (50 did not help), no damping, no sleep. Penetration is removed at the default rate; for the rocking
block the rate is higher, which gave smaller errors there and larger ones elsewhere. The last step is shortened to end at the requested
time. In free flight the error of a step is g dt²/2 (semi-implicit Euler)."""

import math
import sys

import harness

try:
    import pymunk
except ImportError:
    print("pymunk is not installed: skipped", file=sys.stderr)
    sys.exit(0)

RADIUS, THICK = 0.02, 1.0


def build(name, scene, task, dt, end):
    rigid, start = scene["body"], scene["start"]
    space = pymunk.Space()
    space.gravity = (0, -harness.GRAVITY)
    space.collision_slop = 0.0
    if name == "rocking":
        space.collision_bias = (
            1e-30  # the share of a penetration that remains after 1 s
        )
    mass = rigid["mass"]
    body = pymunk.Body(mass, mass * rigid["gyration_radius"] ** 2)
    cos, sin = math.cos(rigid["slope"]), math.sin(rigid["slope"])
    body.position, body.angle = start["q"][:2], start["q"][2]
    body.velocity, body.angular_velocity = start["v"][:2], start["v"][2]
    turns = name in harness.TURNING
    low = harness.RADIUS if turns else 0.0
    if "terrain" in scene:
        ground = [
            pymunk.Poly(
                space.static_body,
                [
                    (a, y - low),
                    (b, y - low),
                    (b, y - harness.DEEP),
                    (a, y - harness.DEEP),
                ],
            )
            for a, b, y in harness.treads(scene)
        ]
    else:
        a, b = 20 * cos, 20 * sin
        x, y = (THICK + low) * sin, -(THICK + low) * cos
        ends = (x - a, y - b), (x + a, y + b)
        ground = [pymunk.Segment(space.static_body, *ends, THICK)]
    for piece in ground:
        piece.elasticity, piece.friction = 1.0, 1.0
    discs = []
    for x, y in rigid["arms"]:
        centre = (x, y) if turns else (x - RADIUS * sin, y + RADIUS * cos)
        disc = pymunk.Circle(body, low or RADIUS, centre)
        disc.elasticity, disc.friction = rigid["restitution"], rigid["friction"]
        discs.append(disc)
    space.add(body, *ground, *discs)
    return space, body


def simulate(space, body, scene, task, dt, end):
    rho = scene["body"]["gyration_radius"]
    steps = int(end / dt - 1e-9)
    times, speeds = [], []
    for step in range(1, steps + 2):
        space.step(dt if step <= steps else end - steps * dt)
        if task == "before":
            continue
        vx, vy = body.velocity
        times.append(step * dt)
        speeds.append(max(abs(vx), abs(vy), abs(body.angular_velocity) * rho))
    return [*body.position, body.angle], harness.settled(times, speeds)


if __name__ == "__main__":
    harness.fixed_step(
        f"pymunk {pymunk.version}", sys.argv[1], build, simulate, harness.FRAME
    )
