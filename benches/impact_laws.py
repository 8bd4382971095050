"""The law of impact of other engines: one impact of one contact in each random scene, compared with the laws of standfast.

A body without gravity hits a level floor with one contact; friction is from 0 to 1, restitution from 0 to .9. In both engines the
contact is a small disc that touches the floor under its centre. They make one step that is so short that nothing moves. The changes
of velocity are compared; the difference is relative to the change in the engine. Needs the extra `peers`."""

import Box2D
import numpy as np
import pymunk
import standfast as sf

SCENES = 2000
LAWS = ["moreau", "poisson", "stronge", "chatterjee-ruina", "newton"]
STEP = 1e-12  # s


def draw(rng):
    """Arm of the contact, ρ², μ, e, and the velocity of the body, computed from that of the contact."""
    arm = np.array([rng.uniform(-1, 1), -rng.uniform(0, 1)])
    mu, e, omega = rng.uniform(0, 1), rng.uniform(0, 0.9), rng.normal()
    slip, rate = rng.normal(0, 3), -rng.uniform(3, 9)
    velocity = slip + arm[1] * omega, rate - arm[0] * omega, omega
    return arm, rng.uniform(0.2, 1) ** 2, mu, e, np.array(velocity)


def by_standfast(law, arm, rho2, mu, e, velocity):
    contact = sf.Contact(arm, friction=mu)
    body = sf.Posture(1.0, rho2**0.5, (0, 0), [contact], e, gravity=0.0)
    run = sf.simulate(
        body, (0, 0, 0), velocity, impact=law, model="full", stop="time", time_limit=0.0
    )
    return run.qdot - velocity


def by_pymunk(arm, rho2, mu, e, velocity):
    radius, thick = 1e-3, 5.0
    space = pymunk.Space()
    space.gravity, space.collision_slop, space.iterations = (0, 0), 0.0, 200
    body = pymunk.Body(1.0, rho2)
    body.velocity, body.angular_velocity = tuple(velocity[:2]), velocity[2]
    disc = pymunk.Circle(body, radius, (arm[0], arm[1] + radius))
    disc.elasticity, disc.friction = e, mu
    top = arm[1] - thick + 1e-9
    floor = pymunk.Segment(space.static_body, (-50, top), (50, top), thick)
    floor.elasticity, floor.friction = 1.0, 1.0
    space.add(body, disc, floor)
    space.step(STEP)
    return np.array([*body.velocity, body.angular_velocity]) - velocity


def by_box2d(arm, rho2, mu, e, velocity):
    radius, skin = 0.02, Box2D.b2_polygonRadius
    world = Box2D.b2World(gravity=(0, 0))
    low = arm[1] - skin + 1e-4
    edge = Box2D.b2EdgeShape(vertices=[(-50, low), (50, low)])
    world.CreateStaticBody().CreateFixture(shape=edge, friction=mu, restitution=0)
    body = world.CreateDynamicBody(
        linearVelocity=velocity[:2], angularVelocity=velocity[2]
    )
    disc = Box2D.b2CircleShape(radius=radius, pos=(arm[0], arm[1] + radius))
    body.CreateFixture(shape=disc, density=1, friction=mu, restitution=e)
    body.massData = Box2D.b2MassData(mass=1, center=(0, 0), I=rho2)
    world.Step(1e-7, 200, 0)
    return np.array([*body.linearVelocity, body.angularVelocity]) - velocity


def main():
    for name, engine in [("pymunk", by_pymunk), ("Box2D", by_box2d)]:
        rng = np.random.default_rng(1)
        off = {law: [] for law in LAWS}
        for _ in range(SCENES):
            scene = draw(rng)
            found = engine(*scene)
            for law in LAWS:
                error = np.linalg.norm(by_standfast(law, *scene) - found)
                off[law].append(error / np.linalg.norm(found))
        for law, errors in off.items():
            median, most = np.median(errors), max(errors)
            print(f"{name:8}{law:18} median {median:.0e}  largest {most:.0e}")


if __name__ == "__main__":
    main()
