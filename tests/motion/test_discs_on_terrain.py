"""Discs on terrains with ends, in valleys and beside walls: what is refused, and nothing that falls through the ground."""

import itertools
import math
import os

import depths
import numpy as np
import pytest
import standfast as sf

LAWS = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
#: Random starts of discs; `make long` has more.
DISCS = int(os.environ.get("STANDFAST_DISCS", "300"))


def test_a_disc_meets_the_end_of_its_terrain():
    """Its centre is 0.1 m beyond the end, dropped from 2 m: its rim meets the end at a height of √(R² − 0.01). One that falls farther away meets
    nothing."""
    disc = sf.Posture.disc(0.5, friction=0.5, terrain=[(-1, 0), (1, 0)])
    run = sf.simulate(disc, (1.1, 2, 0), (0, 0, 0), impact="moreau", time_limit=3.0)
    exact = math.sqrt(2 * (2.5 - math.sqrt(0.24)) / 9.81)
    assert run.impacts["time"][0] == pytest.approx(exact, rel=1e-15)
    assert sf.simulate(disc, (1.6, 2, 0), (0, 0, 0), time_limit=3.0).impacts.size == 0


@pytest.mark.parametrize("top", [0.0, 0.01, 0.5, 1.0, 3.0])
def test_a_disc_does_not_start_in_a_steep_piece(top):
    """A piece from (0, 0) to (top, 5), a disc of radius 0.5 on the floor before it: refused where the centre is nearer than the radius."""
    terrain = [(-5, 0), (0, 0), (top, 5)]

    def on_floor(x):
        contact = sf.Contact((x, 0), radius=0.5, friction=0.5)
        return sf.Posture(1, 0.3, (x, 0.5), [contact], 0.3, terrain=terrain)

    def away(x, y):
        return (y * top - x * 5) / math.hypot(top, 5)

    disc = on_floor(-1.5)
    for x in np.linspace(-0.9, -0.06, 18):
        distance = away(x, 0.5)
        assert abs(distance - 0.5) > 1e-3
        if distance > 0.5:
            assert (
                sf.simulate(disc, (x + 1.5, 0, 0), (0, 0, 0), time_limit=0.1).q[1]
                > -0.1
            )
            on_floor(x)
            continue
        with pytest.raises(
            ValueError, match=r"contacts\.1\.point .* reaches 0\.\d+ m in"
        ):
            on_floor(x)
        with pytest.raises(ValueError, match=r"contact 1 .*-0\."):
            sf.simulate(disc, (x + 1.5, 0, 0), (0, 0, 0))


def disc_scene(rng):
    """A disc, its centre of mass off its centre, on a piece of a random valley, shaft or floor with ends; and a start near it."""
    kind = rng.integers(4)
    if kind == 0:
        low, high = rng.uniform(0.1, 30.0, 2)
        terrain = [(-20, low), (0, 0), (20, high)]
    elif kind == 1:
        width, lean = rng.uniform(0.3, 2.0), rng.uniform(-0.3, 1.0)
        terrain = [(-lean, 5), (0, 0), (width, 0), (width + lean, 5)]
    elif kind == 2:
        terrain = [(-rng.uniform(0.1, 2), rng.uniform(0, 1)), (0, 0), (rng.uniform(0.1, 2), rng.uniform(0, 1))]  # fmt: skip
    else:
        terrain = [(-rng.uniform(0.1, 1), 0), (rng.uniform(0.1, 1), rng.uniform(-0.5, 0.5))]  # fmt: skip
    terrain = np.array(terrain, dtype=float)
    k = rng.integers(len(terrain) - 1)
    way = terrain[k + 1] - terrain[k]
    length = math.hypot(*way)
    radius = rng.uniform(0.05, 0.4)
    share = rng.uniform(0, min(1.0, 2.0 / length)) if rng.random() < 0.5 else rng.uniform()  # fmt: skip
    point = terrain[k] + share * way
    normal = np.array([-way[1], way[0]]) / length
    center = point + radius * normal
    off = rng.normal(size=2) * radius / 3 * rng.integers(2)
    contact = sf.Contact(tuple(point), radius=radius, friction=float(rng.choice([0.0, rng.uniform(0, 2)])))  # fmt: skip
    disc = sf.Posture(
        1, radius * rng.uniform(0.2, 1), tuple(center + off), [contact], float(rng.choice([0.0, rng.uniform(0, 0.8)])), terrain=[tuple(map(float, v)) for v in terrain]
    )  # fmt: skip
    rise = rng.choice([0.0, rng.uniform(0, 1.0)])
    q = (*(rise * normal), 0.0 if rise == 0 else rng.uniform(-3, 3))
    qdot = (rng.normal(), rng.normal(), 5 * rng.normal() * rng.integers(2))
    return disc, q, qdot, center - disc.center_of_mass


def is_behind(center, terrain):
    """Whether a point is behind the piece that is nearest to it."""
    pieces = list(itertools.pairwise(np.array(terrain)))
    a, b = min(pieces, key=lambda piece: depths.distance(center, *piece))
    (x, y), (u, v) = b - a, center - a
    return x * v - y * u < 0


def test_no_disc_falls_through_the_ground():
    """Under all laws, with jams as outcomes and as impacts: a run ends with an outcome, and no centre comes nearer to a piece than the
    radius."""
    rng = np.random.default_rng(77)
    ran = 0
    for _ in range(DISCS):
        try:
            disc, q, qdot, arm = disc_scene(rng)
            run = sf.simulate(disc, q, qdot, model="full", impact=str(rng.choice(LAWS)), jams=str(rng.choice(["none", "impact"])), time_limit=2.0, event_limit=2000)  # fmt: skip
        except ValueError:
            continue  # it does not fit, or starts in the ground
        ran += 1
        scene = disc, q, qdot
        x, y, theta = run.at(np.linspace(0, run.time, 300))[0].T
        cos, sin = np.cos(theta), np.sin(theta)
        center = np.stack([x + cos * arm[0] - sin * arm[1], y + sin * arm[0] + cos * arm[1]], 1) + disc.center_of_mass  # fmt: skip
        if len(center) and is_behind(center[0], disc.terrain):
            continue  # beyond an end, where the ground has another side
        for a, b in itertools.pairwise(np.array(disc.terrain)):
            near = depths.distance(center, a, b).min(initial=math.inf)
            assert near >= disc.contacts[0].radius * (1 - 1e-8), (scene, near)
    print(f"\n{ran} of {DISCS} discs")
    assert ran > DISCS / 2


def test_a_disc_comes_to_both_pieces_of_a_valley_in_a_series_of_impacts():
    """Its second point is added within a series that began with one: a list of the length before had no place for it, and the core panicked."""
    for x in np.linspace(-0.5, 0.4975, 100):
        over, up = x + 0.05, 0.2 / math.sqrt(2)
        contact = sf.Contact(center=(over - math.copysign(up, over), abs(x) + 0.3 + up), radius=0.2, friction=1.0)  # fmt: skip
        valley = [(-20, 20), (0, 0), (20, 20)]
        disc = sf.Posture(1, 0.1, (x, 1.0), [contact], 0.2, terrain=valley)
        run = sf.simulate(disc, (0, 0, 0), (0.3, 0, -0.4), impact="newton", jams="impact", time_limit=3.0)  # fmt: skip
        assert run.outcome in ("rest", "time-limit", "sliding", "inconsistent", "ambiguous"), x  # fmt: skip
