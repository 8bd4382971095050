"""Random terrain with walls and overhangs, and bodies on it."""

import math

import numpy as np
import standfast as sf
from bodies import LAWS

G = 9.81


def particle(terrain, at, restitution):
    return sf.Posture(
        mass=1,
        gyration_radius=0.1,
        center_of_mass=at,
        contacts=[sf.Contact(at)],
        restitution=restitution,
        gravity=G,
        terrain=terrain,
    )


def random_terrain(rng):
    while True:
        vertices, heading = [np.array([-4.0, rng.uniform(-1, 1)])], 0.0
        for _ in range(rng.integers(3, 9)):
            heading = rng.choice(
                [
                    0.0,
                    math.pi / 2,
                    -math.pi / 2,
                    rng.uniform(-2.6, 2.6),
                    rng.uniform(-1, 1),
                ]
            )
            way = np.round([math.cos(heading), math.sin(heading)], 12)
            vertices.append(vertices[-1] + rng.uniform(0.3, 3) * way)
        vertices = [tuple(map(float, v)) for v in vertices]
        try:
            particle(vertices, vertices[1], 0.0)
        except ValueError as error:
            if "meet" in str(error):
                continue
            raise
        return vertices


def random_scene(rng):
    while True:
        terrain = random_terrain(rng)
        x, y = rng.uniform(-4, 4), rng.uniform(-1, 4)
        friction = rng.choice([0.0, rng.uniform(0, 1.5)])
        contacts = [
            sf.Contact(np.add((x, y), rng.uniform(-0.5, 0.5, 2)), friction=friction)
            for _ in range(rng.integers(1, 4))
        ]
        try:
            posture = sf.Posture(
                mass=1,
                gyration_radius=rng.uniform(0.1, 0.7),
                center_of_mass=np.add((x, y), rng.uniform(-0.3, 0.3, 2)),
                contacts=contacts,
                restitution=rng.choice([0.0, rng.uniform(0, 0.9)]),
                gravity=G,
                terrain=terrain,
            )
        except ValueError:
            continue  # a contact is in the ground
        options = {
            "model": "full",
            "impact": str(rng.choice(LAWS)),
            "time_limit": float(rng.uniform(0.5, 4)),
            "stop": str(rng.choice(["rest", "time"])),
            "event_limit": 20_000,
        }
        return terrain, posture, rng.normal(size=3) * 3, options


def flush_box(rng):
    """A box whose sides are flush with a wall and the floor, with one corner in the vertex, or at a small distance from one or both;
    and its velocity."""
    width, height = rng.uniform(0.3, 2, 2)
    x, y = (
        rng.choice([0.0, rng.uniform(0, 0.3)]),
        rng.choice([0.0, rng.uniform(0, 0.3)]),
    )
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    friction = rng.choice([0.0, rng.uniform(0, 1.5)])
    posture = sf.Posture(
        mass=1,
        gyration_radius=rng.uniform(0.2, 0.6) * max(width, height),
        center_of_mass=(x + rng.uniform(0.2, 0.8) * width, y + 0.5 * height),
        contacts=[sf.Contact(corner, friction=friction) for corner in corners],
        restitution=rng.choice([0.0, rng.uniform(0, 0.9)]),
        gravity=G,
        terrain=[(0.0, 9.0), (0.0, 0.0), (9.0, 0.0)],
    )
    across = [-1.0, -1.0, 0.0] if rng.random() < 0.5 else rng.normal(size=3)
    return posture, np.array(across) * rng.choice([0.0, rng.uniform(0, 3)])


def nearest_piece(terrain, points):
    """Index of the piece of a polyline that is nearest to each of the points (n, 2)."""
    vertices = np.array(terrain)
    ways = np.diff(vertices, axis=0)
    tangents = ways / np.hypot(*ways.T)[:, None]
    along = ((points[:, None] - vertices[:-1]) * tangents).sum(axis=2)
    along = np.clip(along, 0, np.hypot(*ways.T))
    feet = vertices[:-1] + tangents * along[:, :, None]
    return np.hypot(*np.moveaxis(points[:, None] - feet, 2, 0)).argmin(axis=1)
