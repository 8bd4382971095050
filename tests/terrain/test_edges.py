"""When corners of the ground meet the sides of a body: as contacts, or passing through them with edges="ignore"."""

import math
import os
import re

import numpy as np
import pytest
import standfast as sf

#: Runs of the comparison with samples.
RUNS = int(os.environ.get("STANDFAST_EDGE_RUNS", "150"))
#: Throws on stairs.
STAIRS = int(os.environ.get("STANDFAST_STAIRS", "100"))
#: Depth that counts as none, relative to the largest distance of a corner from the centre of mass.
DEPTH = 1e-9
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


def meets_at(run, corner, side):
    """When the corner of the ground touches the side (from 1) for the first time; no other corner has met a side before."""
    count = len(run.posture.contacts)
    first = run.contacts[count]
    assert (first.number, first.kind) == (count + 1, "side")
    assert (first.corner, first.index) == (corner, side - 1)
    assert not entries(run)
    hits = run.impacts["time"][run.impacts["contact"] == first.number]
    closed = [phase.start for phase in run.phases if phase.mode[count] != "S"]
    return min([*hits[:1], *closed[:1]])


def test_a_box_falls_on_a_peak():
    """Its lower side is a metre over the peak, at y = 0; the corners of the box are over the valleys."""
    box = sf.Posture.box(2.0, 1.0, terrain=[(-3, -3), (0, -1), (3, -3)])
    run = sf.simulate(box, (0, 0, 0), (0, 0, 0))
    t = meets_at(run, (0.0, -1.0), 1)
    assert t == pytest.approx(math.sqrt(2 / G), rel=1e-12)
    assert run.outcome == "rest"
    assert run.q == pytest.approx((0, -1, 0), abs=1e-12)
    [impact] = run.impacts
    assert impact["impulse"] == pytest.approx((0, G * t), abs=1e-12)
    on = sf.simulate(box, (0, 0, 0), (0, 0, 0), edges="ignore")
    assert entries(on) == [(pytest.approx(t, rel=1e-12), (0.0, -1.0), 1)]
    assert 'edges = "ignore"' in on.warnings[0]
    assert (on.outcome, on.time > t) == ("rest", True)


def test_a_box_turns_about_its_corner_onto_a_peak():
    """In free turn and fall: the right lower corner of the box is at (1/2, 0), the peak is under the middle of the lower side."""
    peak = [(-3, -3), (0, -1), (3, -3)]
    box = sf.Posture.box(1.0, 1.0, gravity=0.0, terrain=peak)
    run = sf.simulate(box, (0, 0, 0), (0, -1.0, 0.3))
    t = meets_at(run, (0.0, -1.0), 1)
    # In the axes of the body: y = cos(ωt)(t − 3/2) is the height of the peak over the centre, and −1/2 that of the side.
    low, high = 0.9, 1.1
    for _ in range(60):
        middle = (low + high) / 2
        outside = math.cos(0.3 * middle) * (middle - 1.5) < -0.5
        low, high = (middle, high) if outside else (low, middle)
    assert t == pytest.approx(low, rel=1e-12)


def test_a_box_that_would_fly_away_meets_a_corner():
    """One corner of the box is below the table, another one above it, and neither lands. The corner of the table
    meets the box: with a time limit, without one, and not with a limit before that time."""
    box = sf.Posture.box(2.0, 1.0, gravity=0.0, terrain=[(-1.2, -9), (1.2, -9)])
    start = (10.0, -9.5, 0), (-2.0, 0, 0)
    for limit in (None, 10.0):
        run = sf.simulate(box, *start, time_limit=limit)
        t = meets_at(run, (1.2, -9.0), 4)
        assert t == pytest.approx(3.9, rel=1e-12)
    assert sf.simulate(box, *start, edges="ignore").outcome == "escape"
    before = sf.simulate(box, *start, time_limit=3.8)
    assert (before.outcome, before.time) == ("time-limit", 3.8)
    assert len(before.contacts) == 4
    away = sf.simulate(box, start[0], (2.0, 0, 3.0))
    assert (away.outcome, away.warnings) == ("escape", [])
    # It only turns: without gravity, about its centre of mass. The peak is 0.1 m beside the side.
    box = sf.Posture.box(2.0, 1.0, gravity=0.0, terrain=[(-4, -4), (0, -0.1), (4, -4)])
    for omega in (1.0, 1e6):
        run = sf.simulate(box, (0, 0, 0), (0, 0, omega))
        t = meets_at(run, (0.0, -0.1), 1)
        assert t == pytest.approx(math.acos(0.5 / 0.6) / omega, rel=1e-12)


def test_a_time_limit_does_not_hide_that_the_body_has_left_the_terrain():
    """Thrown at 3 m/s, the box of 1 m is beyond the end at x = 2 m from 2.5/3 s on. On the way to the terrain it has not left it."""
    box = sf.Posture.box(1.0, 1.0, terrain=[(-2, 0), (2, 0)])
    for limit in (0.7, 0.82, 0.85, 2.0, None):
        run = sf.simulate(box, (0, 4, 0), (3.0, 0, 0), time_limit=limit)
        left = limit is None or limit > 2.5 / 3
        assert [w.startswith("the body has left the terrain") for w in run.warnings] == [True] * left  # fmt: skip
    run = sf.simulate(box, (4, 4, 0), (-3.0, 0, 0), time_limit=0.1)
    assert run.warnings == []


def test_a_box_tips_over_the_end_of_a_table():
    box = sf.Posture.box(1.0, 1.0, friction=1.0, terrain=[(-1, 0), (1, 0)])
    assert meets_at(sf.simulate(box, (1.1, 0, 0), (0, 0, 0)), (1.0, 0.0), 1) == 0
    run = sf.simulate(
        box, (1.1, 0, 0), (0, 0, 0), time_limit=0.5, stop="time", edges="ignore"
    )
    [(t, corner, side)] = entries(run)
    assert (t, corner, side) == (0, (1.0, 0.0), 1)
    assert depths(box, run.at(0.4)[0], corner)[0] > 1e-3


def test_a_box_that_stands_over_a_corner_of_the_ground_is_not_inside_it():
    """The box slides over the corner of a step with its lower side on the top, at depth 0. When its front corner has
    left the ground, the corner of the step supports the box there."""
    step = [(-5, 0), (0.2, 0), (0.2, -1), (5, -1)]
    box = sf.Posture.box(1.0, 1.0, friction=0.5, terrain=[(-5, 0), (5, 0), (5, -1)])
    run = sf.simulate(box, (0, 0, 0), (1.0, 0, 0))
    assert run.outcome == "rest"
    assert not run.warnings
    narrow = sf.Posture.box(0.2, 0.2, friction=0.3, terrain=step)
    t = meets_at(sf.simulate(narrow, (0, 0, 0), (0.9, 0, 0)), (0.2, 0.0), 1)
    deceleration = 0.3 * G
    leaves = (0.9 - math.sqrt(0.81 - 2 * deceleration * 0.1)) / deceleration
    assert t == pytest.approx(leaves, rel=1e-12)


def test_a_box_slides_with_its_side_against_a_point():
    """In a contact phase: a point of the ground stands above the level on which the box slides. The box meets the
    point at the time that follows from a slide without friction and with friction, also if the slide would be
    endless."""
    terrain = [(-9, 0), (3, 0), (3, 0.8), (2, 0.5), (3, 3)]
    for friction, speed in [(0.0, 2.0), (0.1, 3.0)]:
        box = sf.Posture.box(1.0, 1.0, friction=friction, terrain=terrain)
        t = meets_at(sf.simulate(box, (0, 0, 0), (speed, 0, 0)), (2.0, 0.5), 2)
        pull = friction * G
        way = 3 / (speed + math.sqrt(speed**2 - 3 * pull))
        assert t == pytest.approx(way, rel=1e-12)


def test_the_ends_of_all_segments_are_corners():
    """Each contact has its own segment, with a gap between them. The body falls by half a metre; its right corner lands, the left one is
    over the gap, and the body begins to turn about the right one."""
    body = sf.Posture(
        mass=1.0,
        gyration_radius=0.6,
        center_of_mass=(0, 0.5),
        contacts=[
            sf.Contact((-1, 0), segment=(-3, 0.5)),
            sf.Contact((1, 0), segment=(-0.5, 3)),
        ],
        restitution=0.0,
        outline=[(-1, 0), (1, 0), (1, 1), (-1, 1)],
    )
    t = meets_at(sf.simulate(body, (1.2, 0.5, 0), (0, 0, 0)), (0.5, 0.0), 1)
    assert t == pytest.approx(math.sqrt(1 / G), rel=1e-12)
    flat = sf.simulate(body, (0, 0.5, 0), (0, 0, 0))
    assert (flat.outcome, entries(flat)) == ("rest", [])


def test_a_body_with_a_corner_of_the_ground_in_it_does_not_start():
    """Its contacts are over the ground, the peak is 0.2 m deep in it."""
    box = sf.Posture.box(2.0, 1.0, terrain=[(-3, -3), (0, 0.2), (3, -3)])
    kick = [sf.Kick(time=0.0, impulse=(0, 1.0))]
    for keywords in ({}, {"kicks": kick}, {"record": False}, {"impact": "moreau"}):
        with pytest.raises(ValueError, match=r"q = .*\(0\.0, 0\.2\) m lies 0\.2 m in"):
            sf.simulate(box, (0, 0, 0), (0, 0, 0), **keywords)
    with pytest.raises(ValueError, match=r"q = .*\(0\.0, 0\.2\) m lies 0\.2 m in"):
        sf.contact_modes(box, (0, 0, 0), (0, 0, 0))
    # A narrow peak that passes right through the box, its tip above it.
    needle = [(-3, -3), (-0.01, -3), (0, 2), (0.01, -3), (3, -3)]
    pierced = sf.Posture.box(2.0, 1.0, terrain=needle)
    with pytest.raises(ValueError, match=r"lies 0\.\d+ m in the body.*ignore"):
        sf.simulate(pierced, (0, 0, 0), (0, 0, 0))
    on = sf.simulate(box, (0, 0, 0), (0, 0, 0), edges="ignore")
    assert "lies in the body" in on.warnings[0]


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


def test_it_is_the_same_without_a_record_in_many_runs_and_after_a_kick():
    box = sf.Posture.box(2.0, 1.0, terrain=[(-3, -3), (0, -1), (3, -3)])
    for edges in ("contact", "ignore"):
        keywords = {"time_limit": 1.0, "edges": edges}
        whole = sf.simulate(box, (0, 0, 0), (0, 0, 0), **keywords)
        bare = sf.simulate(box, (0, 0, 0), (0, 0, 0), record=False, **keywords)
        many = sf.simulate_many(box, (0, 0, 0), [(0, 0, 0)] * 3, **keywords)
        assert bare.warnings == whole.warnings
        assert (bare.outcome, bare.time) == (whole.outcome, whole.time)
        assert set(many.outcome) == {whole.outcome}
        assert set(many.time) == {whole.time}
    kick = [sf.Kick(time=0.1, impulse=(0, -1.0))]
    late = [*kick, sf.Kick(time=0.9, impulse=(0, -1.0))]
    fall = G * 0.1 + 1.0
    rest = 1 - G * 0.1**2 / 2
    for kicks in (kick, late):
        kicked = sf.simulate(box, (0, 0, 0), (0, 0, 0), time_limit=1.0, kicks=kicks)
        t = meets_at(kicked, (0.0, -1.0), 1)
        assert t == pytest.approx(
            0.1 + (math.sqrt(fall**2 + 2 * G * rest) - fall) / G, rel=1e-12
        )
        assert len(kicked.impacts) == len(kicks)  # the late kick presses it on the peak


def test_a_saved_run_meets_the_edge_again(tmp_path):
    box = sf.Posture.box(2.0, 1.0, terrain=[(-3, -3), (0, -1), (3, -3)])
    run = sf.simulate(box, (0, 0, 0), (0, 0, 0))
    run.save(tmp_path / "run.json")
    assert sf.Run.load(tmp_path / "run.json").contacts == run.contacts
    assert len(run.contacts) == 5
    scene = sf.Scene(box, (0, 0, 0), (0, 0, 0), {"edges": "ignore"})
    scene.save(tmp_path / "box.toml")
    assert sf.load(tmp_path / "box.toml").simulate().outcome == "rest"
    with pytest.raises(ValueError, match=r"edges.*contact.*ignore"):
        sf.simulate(box, (0, 0, 0), (0, 0, 0), edges="end")


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


def is_valley(vertices, corner):
    i = vertices.index(corner)
    if not 0 < i < len(vertices) - 1:
        return False
    before, here, after = np.array(vertices[i - 1 : i + 2])
    (a, b), (c, d) = here - before, after - here
    return a * d > b * c


def test_entries_are_those_of_samples():
    """The depth of all vertices of the ground at 4 000 times of each run that goes on, by the winding of the polygon around them. The run
    with contacts has the same events before the first of them."""
    rng = np.random.default_rng(2511)
    seen = 0
    for _ in range(RUNS):
        posture, q, qdot = random_scene(rng)
        scene = sf.Scene(
            posture,
            q,
            qdot,
            {"stop": "time", "time_limit": 2.0, "event_limit": 3000},
        )
        run = scene.simulate(edges="ignore")
        told = {corner: t for t, corner, _ in entries(run)}
        assert len(told) == len(entries(run))
        times = np.linspace(0, run.time, 4000)
        states = run.at(times)[0]
        vertices = [tuple(map(float, v)) for v in posture.terrain]
        assert set(told) <= set(vertices)
        for corner in vertices:
            deep = depths(posture, states, corner)
            inside = np.flatnonzero(deep > 1e-8)
            if corner not in told:
                # A valley enters only after a corner has, and is not told.
                if len(inside):
                    assert is_valley(vertices, corner), (posture, q, qdot, corner)
                    assert times[inside[0]] >= min(told.values(), default=math.inf)
                continue
            seen += 1
            first = told[corner]
            at_entry = depths(posture, run.at(first)[0], corner)[0]
            assert abs(at_entry) < 2 * DEPTH, (posture, q, qdot, corner)
            assert not len(inside) or times[inside[0]] >= first
        whole = scene.simulate()
        count = len(posture.contacts)
        sides = whole.contacts[count:]
        assert not told or sides, (posture, q, qdot)
        if told and run.time == whole.time:
            hits = whole.impacts[whole.impacts["contact"] > count]["time"]
            first = min([*told.values(), *hits])
            # A side that comes to lie flat touches several corners at one instant, and not all of them would enter it later.
            assert {side.corner for side in sides} & set(told)
            before = run.impacts[run.impacts["time"] < first - 1e-9]
            same = whole.impacts[whole.impacts["time"] < first - 1e-9]
            assert np.array_equal(before["time"], same["time"])
    assert seen > RUNS / 4


def stairs(rng):
    """A box or an L thrown on stairs that go down to the right."""
    count = int(rng.integers(3, 7))
    tread, rise = rng.uniform(0.3, 1.2), rng.uniform(0.1, 0.5)
    edges = [
        [(k * tread, -k * rise), (k * tread, -(k + 1) * rise)] for k in range(count)
    ]
    flat = [vertex for edge in edges for vertex in edge]
    terrain = [(-20, 0), *flat, (20 + count * tread, -count * rise)]
    keywords = {
        "friction": rng.choice([0.0, rng.uniform(0.05, 1.0)]),
        "restitution": rng.choice([0.0, rng.uniform(0.0, 0.7)]),
        "terrain": terrain,
    }
    if rng.random() < 0.5:
        body = sf.Posture.box(rng.uniform(0.2, 1.0), rng.uniform(0.2, 1.0), **keywords)
    else:
        size = rng.uniform(0.2, 1.0)
        shape = [(0, 0), (1, 0), (1, 0.4), (0.4, 0.4), (0.4, 1), (0, 1)]
        body = sf.Posture.polygon([(size * x, size * y) for x, y in shape], **keywords)
    q = (rng.uniform(-1, count * tread), rng.uniform(1.5, 2.5), rng.uniform(-3.1, 3.1))
    qdot = (rng.normal(), rng.normal(), 4 * rng.normal())
    laws = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
    return body, q, qdot, str(rng.choice(laws))


def test_no_side_passes_through_the_edge_of_a_stair():
    """At 2 000 times of each run no vertex of the stairs is inside the body."""
    rng = np.random.default_rng(88)
    met = 0
    for _ in range(STAIRS):
        body, q, qdot, law = stairs(rng)
        run = sf.simulate(
            body, q, qdot, impact=law, time_limit=10.0, event_limit=20_000
        )
        met += len(run.contacts) > len(body.contacts)
        radius = np.hypot(*(np.array(body.outline) - body.center_of_mass).T).max()
        states = run.at(np.linspace(0, run.time, 2000))[0]
        vertices = [tuple(map(float, v)) for v in body.terrain]
        deepest = max(depths(body, states, vertex).max() for vertex in vertices)
        assert deepest <= DEPTH * radius, (body, q, qdot, law, deepest)
        assert not entries(run)
    print(f"\n{STAIRS} throws on stairs, {met} with an edge on a side")
    assert met > STAIRS / 2


def test_a_concave_vertex_of_the_terrain_enters_no_body():
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
        assert len(run.contacts) == 4
        assert (
            depths(box, run.at(np.linspace(0, run.time, 200))[0], (0.0, -1.0)).max()
            < 1e-9
        )


def test_only_convex_corners_and_ends_are_told():
    """With edges="ignore" the body sinks over the whole peak. The valleys beside it are no corners."""
    terrain = [
        (-1, 0),
        (-0.4, 0),
        (-0.1, -0.8),
        (0, -0.1),
        (0.1, -0.8),
        (0.4, 0),
        (1, 0),
    ]
    body = sf.Posture(
        mass=1.0,
        gyration_radius=0.3,
        center_of_mass=(0, 1),
        contacts=[sf.Contact((-0.9, 1.5)), sf.Contact((0.9, 1.5))],
        restitution=0.0,
        terrain=terrain,
        outline=[(-0.3, 0.1), (0.3, 0.1), (0.9, 1.5), (-0.9, 1.5)],
    )
    run = sf.simulate(body, (0, 0, 0), (0, 0, 0), edges="ignore")
    found = [(corner, side) for _, corner, side in entries(run)]
    assert found[0] == ((0.0, -0.1), 1)
    assert {corner for corner, _ in found[1:]} == {(-0.4, 0.0), (0.4, 0.0)}


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


def test_a_body_that_falls_off_the_end_of_its_terrain_is_named():
    box = sf.Posture.box(0.4, 0.4, friction=0.1, terrain=[(-1, 0), (1, 0)])
    run = sf.simulate(box, (0, 0, 0), (4, 0, 0), impact="moreau")
    assert run.outcome == "escape"
    assert run.q[0] > 1
    (warning,) = run.warnings
    assert "ends at x = -1.0 m and x = 1.0 m" in warning


def test_a_run_without_a_mode_names_what_jams():
    tower = sf.Posture.box(0.5, 1.5, friction=2)
    kick = sf.Kick(time=0, impulse=(1e-9, 0))
    run = sf.simulate(tower, (0, 0, 0), (0, 0, 0), impact="moreau", kicks=[kick])
    assert run.outcome == "inconsistent"
    (warning,) = run.warnings
    assert "can jam (Painlevé)" in warning
    critical = min(least for _, _, margin, least in run.undecided.jamming if margin < 0)
    assert str(critical) in warning
