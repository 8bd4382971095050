"""Where a side ends on a corner of the ground: boxes that slide flush past an upper edge or over a roof, and boxes thrown at an edge.

An impact needs a point that approaches what is in front of it. A corner of the ground beyond the end of a side, and a corner of the body
that moves along one piece of a vertex away from the other one, are not in front.
"""

import math
import os

import depths
import numpy as np
import pytest
import standfast as sf

#: Boxes thrown at an edge, and boxes that slide flush on a roof; `make long` has more.
THROWS = int(os.environ.get("STANDFAST_EDGE_THROWS", "200"))
SLIDES = int(os.environ.get("STANDFAST_FLUSH_SLIDES", "200"))
LAWS = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
#: Depth in m that counts as none, for bodies of about 1 m.
DEPTH = 1e-9
#: Differences from a closed form, in m and rad.
CLOSE = 1e-9
G = 9.81
#: Length of a roof on both sides, in m.
FAR = 9.0


def on_roof(left, right, over, height, **keywords):
    """A box 2 m long, flush on the left side of a roof of these slopes (rad) with its ridge at the origin; so much of it is over the ridge."""
    t = np.array([math.cos(left), math.sin(left)])
    n = np.array([-t[1], t[0]])
    shape = [(over - 2) * t, over * t, over * t + height * n, (over - 2) * t + height * n]  # fmt: skip
    roof = [-FAR * t, (0, 0), (FAR * math.cos(right), -FAR * math.sin(right))]
    roof = [tuple(map(float, vertex)) for vertex in roof]
    return sf.Posture.polygon(shape, terrain=roof, **keywords), t


@pytest.mark.parametrize("over", [0.2, 0.3, 0.4, 0.5, 0.6, 0.8])
@pytest.mark.parametrize("slope", [0.1, 0.35, 0.6, 0.85, 1.0, 1.25])
def test_a_box_slides_down_past_the_upper_edge(slope, over):
    """Without friction, from rest: g sin α, and it does not turn."""
    box, t = on_roof(slope, slope, over, 1.0)
    run = sf.simulate(box, (0, 0, 0), (0, 0, 0), model="full", time_limit=1.0)
    end = min(run.time, 1.0)
    way = G * math.sin(slope) * end**2 / 2
    assert run.outcome in ("time-limit", "sliding")
    assert not run.warnings
    assert run.at(end)[0] == pytest.approx((*(-way * t), 0), abs=CLOSE)


@pytest.mark.parametrize("law", LAWS)
def test_boxes_slide_down_past_the_upper_edge(law):
    """With friction and a speed at the start, on any roof: a = g (sin α − μ cos α). Nothing is hit."""
    rng = np.random.default_rng([71, LAWS.index(law)])
    for _ in range(max(SLIDES // 5, 1)):
        left = rng.uniform(0.1, 1.3)
        right = rng.uniform(0.05 - left, 1.3)
        friction = float(rng.choice([0.0, rng.uniform(0, 0.9 * math.tan(left))]))
        height = rng.uniform(0.2, 1.2)
        if friction * height / 2 > 0.9:
            continue  # it would tip
        speed = float(rng.choice([0.0, rng.uniform(0, 2.0)]))
        keywords = {"friction": friction, "restitution": float(rng.choice([0.0, 0.5]))}
        box, t = on_roof(left, right, rng.uniform(0.05, 0.95), height, **keywords)
        start = (*(-speed * t), 0)
        run = sf.simulate(box, (0, 0, 0), start, model="full", impact=law, time_limit=1.0)  # fmt: skip
        pull = G * (math.sin(left) - friction * math.cos(left))
        end = min(run.time, 1.0)
        way = speed * end + pull * end**2 / 2
        scene = left, right, box, start, law
        assert run.outcome in ("time-limit", "sliding"), scene
        assert not len(run.impacts), scene
        assert run.at(end)[0] == pytest.approx((*(-way * t), 0), abs=CLOSE), scene


def assert_possible(run, scene):
    assert not depths.without_approach(run), scene
    assert depths.through(run) <= DEPTH, scene


@pytest.mark.parametrize("law", LAWS)
def test_boxes_slide_flush_over_a_roof(law):
    """Up and down, beyond the balance too: they tip over the ridge, fall and bounce."""
    rng = np.random.default_rng([72, LAWS.index(law)])
    hits = 0
    for _ in range(max(SLIDES // 5, 1)):
        left, right = rng.uniform(0.05, 1.4, 2)
        box, t = on_roof(
            left,
            right,
            rng.uniform(0.05, 1.5),
            rng.uniform(0.2, 1.2),
            friction=float(rng.choice([0.0, rng.uniform(0, 1.0)])),
            restitution=float(rng.choice([0.0, rng.uniform(0, 0.7)])),
        )
        start = (*(rng.normal() * t), 0)
        run = sf.simulate(box, (0, 0, 0), start, model="full", impact=law, stop="time", time_limit=1.0, event_limit=5000)  # fmt: skip
        hits += len(run.impacts) > 0
        assert_possible(run, (left, right, box, start, law))
    assert hits > SLIDES / 50


@pytest.mark.parametrize("law", LAWS)
def test_boxes_thrown_at_the_edge_of_a_table(law):
    rng = np.random.default_rng([73, LAWS.index(law)])
    met = 0
    for _ in range(max(THROWS // 5, 1)):
        width, height = rng.uniform(0.3, 1.3), rng.uniform(0.2, 0.8)
        table = [(-5, 0), (0, 0), (0, -1), (5, -1)]
        box = sf.Posture.box(
            width,
            height,
            friction=float(rng.choice([0.0, rng.uniform(0, 0.8)])),
            restitution=float(rng.choice([0.0, rng.uniform(0, 0.7)])),
            terrain=table,
        )
        radius = math.hypot(width, height) / 2
        q = rng.uniform(-0.8, 0.2), rng.uniform(radius, 1.2) - height / 2, rng.uniform(-3, 3)  # fmt: skip
        v = rng.uniform(0, 1.5), rng.uniform(-1, 0.5), rng.uniform(-4, 4)
        run = sf.simulate(box, q, v, model="full", impact=law, stop="time", time_limit=0.7, event_limit=5000)  # fmt: skip
        met += len(run.contacts) > len(box.contacts)
        assert_possible(run, (box, q, v, law))
    assert met > THROWS / 20
