"""Corners of the ground that enter a body through its sides, where only its contacts meet the ground."""

import math
import os
import re

import numpy as np
import pytest
import standfast as sf

#: Runs of the comparison with samples.
RUNS = int(os.environ.get("STANDFAST_EDGE_RUNS", "150"))
G = 9.81


def entries(run):
    """Time, corner of the ground and side of the body of each warning."""
    pattern = r"edge-contact: at t = (\S+) s the corner of the ground at \((\S+), (\S+)\) m enters the body through side (\d+) of"
    found = [re.match(pattern, warning) for warning in run.warnings]
    return [(float(m[1]), (float(m[2]), float(m[3])), int(m[4])) for m in found if m]


def depths(posture, q, corner):
    """Depth of a corner of the ground in the body at configurations q (k, 3), negative outside: from all sides of the polygon."""
    outline = np.array(posture.outline) - posture.center_of_mass
    x, y, theta = np.atleast_2d(q).T
    dx, dy = (
        corner[0] - posture.center_of_mass[0] - x,
        corner[1] - posture.center_of_mass[1] - y,
    )
    p = np.stack(
        [
            np.cos(theta) * dx + np.sin(theta) * dy,
            np.cos(theta) * dy - np.sin(theta) * dx,
        ],
        axis=1,
    )
    away = np.full(len(p), np.inf)
    winding = np.zeros(len(p))
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        along = np.clip(((p - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
        away = np.minimum(away, np.hypot(*(p - a - along[:, None] * (b - a)).T))
        one, two = a - p, b - p
        winding += np.arctan2(
            one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0], (one * two).sum(axis=1)
        )
    return np.where(np.abs(winding) > math.pi, away, -away)


def test_a_box_falls_on_a_peak():
    """Its lower side is a metre over the peak, at y = 0; the corners of the box are over the valleys."""
    box = sf.Posture.box(2.0, 1.0, terrain=[(-3, -3), (0, -1), (3, -3)])
    run = sf.simulate(box, (0, 0, 0), (0, 0, 0))
    [(t, corner, side)] = entries(run)
    assert corner == (0.0, -1.0)
    assert side == 1
    assert t == pytest.approx(math.sqrt(2 / G), rel=1e-8)
    speed = G * t
    # It is reported at the depth of 1e-9 of the half diagonal.
    assert 0 <= t - math.sqrt(2 / G) <= 3e-9 * math.hypot(1, 0.5) / speed


def test_a_box_tips_over_the_end_of_a_table():
    box = sf.Posture.box(1.0, 1.0, friction=1.0, terrain=[(-1, 0), (1, 0)])
    run = sf.simulate(box, (1.1, 0, 0), (0, 0, 0), time_limit=0.5, stop="time")
    [(t, corner, side)] = entries(run)
    assert (corner, side) == ((1.0, 0.0), 1)
    assert 0 <= t < 1e-3
    assert depths(box, run.at(0.4)[0], corner)[0] > 1e-3


def test_a_box_that_stands_over_a_corner_of_the_ground_is_not_inside_it():
    """It slides over the corner of a step with its lower side on the top, at depth 0. When its front corner has left the ground it has no
    support there but the corner of the ground, and enters it."""
    step = [(-5, 0), (0.2, 0), (0.2, -1), (5, -1)]
    box = sf.Posture.box(1.0, 1.0, friction=0.5, terrain=[(-5, 0), (5, 0), (5, -1)])
    run = sf.simulate(box, (0, 0, 0), (1.0, 0, 0))
    assert run.outcome == "rest"
    assert not run.warnings
    narrow = sf.Posture.box(0.2, 0.2, friction=0.3, terrain=step)
    run = sf.simulate(narrow, (0, 0, 0), (0.9, 0, 0), time_limit=0.2, stop="time")
    [(t, corner, side)] = entries(run)
    assert (corner, side) == ((0.2, 0.0), 1)
    deceleration = 0.3 * G
    leaves = (0.9 - math.sqrt(0.81 - 2 * deceleration * 0.1)) / deceleration
    assert leaves < t < leaves + 1e-3


def test_a_posture_without_outline_and_a_ground_without_corners_have_no_warning():
    terrain = [(-3, -3), (0, -1), (3, -3)]
    box = sf.Posture.box(2.0, 1.0, terrain=terrain)
    bare = sf.Posture(
        mass=1.0,
        gyration_radius=box.gyration_radius,
        center_of_mass=(0, 0.5),
        contacts=[sf.Contact(c.point) for c in box.contacts],
        restitution=0.0,
        terrain=terrain,
    )
    assert not entries(sf.simulate(bare, (0, 0, 0), (0, 0, 0)))
    valley = sf.Posture.box(2.0, 1.0, terrain=[(-100, 30), (0, -1), (100, 30)])
    assert not entries(sf.simulate(valley, (0, 0, 0), (0, 0, 0)))


def test_it_is_said_without_a_record_and_after_a_kick():
    box = sf.Posture.box(2.0, 1.0, terrain=[(-3, -3), (0, -1), (3, -3)])
    whole = sf.simulate(box, (0, 0, 0), (0, 0, 0), time_limit=1.0)
    bare = sf.simulate(box, (0, 0, 0), (0, 0, 0), time_limit=1.0, record=False)
    assert bare.warnings == whole.warnings
    kick = [sf.Kick(time=0.1, impulse=(0, -1.0))]
    kicked = sf.simulate(box, (0, 0, 0), (0, 0, 0), time_limit=1.0, kicks=kick)
    [(t, *_)] = entries(kicked)
    fall = G * 0.1 + 1.0
    rest = 1 - G * 0.1**2 / 2
    assert t == pytest.approx(
        0.1 + (math.sqrt(fall**2 + 2 * G * rest) - fall) / G, rel=1e-8
    )


def random_scene(rng):
    """A box or an L on a hilly terrain, with or without walls, thrown."""
    if rng.random() < 0.5:
        count = int(rng.integers(3, 9))
        x = np.sort(rng.uniform(-4, 4, count))
        x[[0, -1]] = -8, 8
        terrain = np.stack([x, rng.uniform(-1, 0, count)], axis=1)
    else:
        edge = rng.uniform(0.2, 1.0)
        terrain = np.array(
            [(-8, 0), (-edge, 0), (-edge, -0.7), (edge, -0.7), (edge, 0), (8, 0.0)]
        )
    keywords = {
        "friction": rng.uniform(0, 0.8),
        "restitution": rng.uniform(0, 0.6),
        "terrain": np.add(terrain, (0, -0.01)),
    }
    if rng.random() < 0.5:
        lift = sf.Posture.box(rng.uniform(0.3, 1.5), rng.uniform(0.3, 1.5), **keywords)
    else:
        lift = sf.Posture.polygon(
            [(0, 0), (1, 0), (1, 0.4), (0.4, 0.4), (0.4, 1), (0, 1)], **keywords
        )
    return (
        lift,
        (rng.uniform(-1, 1), rng.uniform(1.5, 2.0), rng.uniform(-3, 3)),
        (rng.normal(), rng.normal(), 3 * rng.normal()),
    )


def test_entries_are_those_of_samples():
    """The depth of all corners of the ground at 4 000 times of each run, by the winding of the polygon around them."""
    rng = np.random.default_rng(2511)
    seen = 0
    for _ in range(RUNS):
        posture, q, qdot = random_scene(rng)
        run = sf.simulate(
            posture, q, qdot, stop="time", time_limit=2.0, event_limit=3000
        )
        told = {corner: t for t, corner, _ in entries(run)}
        times = np.linspace(0, run.time, 4000)
        states = run.at(times)[0]
        vertices = [tuple(map(float, v)) for v in posture.terrain]
        assert set(told) <= set(vertices)
        for corner in vertices:
            deep = depths(posture, states, corner)
            inside = np.flatnonzero(deep > 1e-8)
            if corner not in told:
                assert not len(inside), (posture, q, qdot, corner)
                continue
            seen += 1
            first = told[corner]
            assert abs(depths(posture, run.at(first)[0], corner)[0]) < 1e-7, (
                posture,
                q,
                qdot,
                corner,
            )
            assert not len(inside) or times[inside[0]] >= first - 1e-12
    assert seen > RUNS / 4


def test_a_concave_vertex_of_the_terrain_is_not_watched():
    """No point of a body gets into it from above, since all corners that are convex are contacts."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        box = sf.Posture.box(
            rng.uniform(0.2, 1),
            rng.uniform(0.2, 1),
            restitution=0.3,
            friction=rng.uniform(0, 1),
            terrain=[(-50, 20), (0, -1), (50, 20)],
        )
        run = sf.simulate(box, (0, 1, rng.uniform(-3, 3)), rng.normal(size=3))
        assert not entries(run)
        assert (
            depths(box, run.at(np.linspace(0, run.time, 200))[0], (0.0, -1.0)).max()
            < 1e-9
        )


def test_outlines_in_files_copies_and_errors(tmp_path):
    box = sf.Posture.box(2.0, 1.0, terrain=[(-3, -3), (0, -1), (3, -3)])
    assert box.outline == [(-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0)]
    assert eval(repr(box), {"Posture": sf.Posture, "Contact": sf.Contact}) == box
    scene = sf.Scene(box, (0, 0, 0), (0, 0, 0))
    scene.save(tmp_path / "box.toml")
    assert sf.load(tmp_path / "box.toml").posture == box
    assert sf.Posture.rod(0.5, 0.2, 0.1).outline is None
    fields = {
        "mass": 1,
        "gyration_radius": 1,
        "center_of_mass": (0, 0),
        "contacts": [sf.Contact((0, 0))],
        "restitution": 0,
    }
    for outline, text in [
        ([(0, 0), (1, 0)], "3 to 1024 vertices"),
        ([(0, 0), (1, 1), (1, 0), (0, 1)], r"outline = \[edges 1 and 3 meet\]"),
        ([(0, 0), (1, 0), (math.nan, 1)], r"outline.3.x = NaN"),
    ]:
        with pytest.raises(ValueError, match=text):
            sf.Posture(**fields, outline=outline)
