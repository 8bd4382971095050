"""The ground of contacts without a terrain: for each a straight line of its own slope through its own point. A run warns
where this is not plausible."""

import math
import os
import re
from collections import Counter

import numpy as np
import pytest
import standfast as sf
from bodies import size, with_defaults

#: Number of random postures for each shape of ground.
POSTURES = int(os.environ.get("STANDFAST_OWN_GROUND", "200"))
G = 9.81
GROUND = "without terrain= each contact meets only"


def said(run):
    """The warnings about the ground."""
    return [text for text in run.warnings if GROUND in text]


def places(posture, q, model="full"):
    """Positions of the contacts at configurations q : (..., 3); (..., n, 2)."""
    q = np.asarray(q, dtype=float)[..., None, :]
    points = np.array([contact.point for contact in posture.contacts])
    arms = points - posture.center_of_mass
    theta = q[..., 2]
    cos, sin = (
        (np.ones_like(theta), theta)
        if model == "local"
        else (np.cos(theta), np.sin(theta))
    )
    turned = np.stack(
        [cos * arms[:, 0] - sin * arms[:, 1], sin * arms[:, 0] + cos * arms[:, 1]], -1
    )
    return np.asarray(posture.center_of_mass) + q[..., :2] + turned


def heights(posture, at):
    """Heights of contacts at : (..., n, 2) over the lines: (..., contact, line)."""
    points = np.array([contact.point for contact in posture.contacts])
    slopes = np.array([contact.slope for contact in posture.contacts])
    normals = np.stack([-np.sin(slopes), np.cos(slopes)], -1)
    return np.einsum("...ijk,jk->...ij", at[..., :, None, :] - points, normals)


#: A box with a contact at each of its four corners: the ground of the two upper ones is at the height of the lid.
box = with_defaults(
    sf.Posture,
    mass=1.0,
    gyration_radius=math.sqrt(1 / 6),
    center_of_mass=(0.5, 0.5),
    contacts=[
        sf.Contact(point, friction=0.4) for point in [(0, 0), (1, 0), (1, 1), (0, 1)]
    ],
    restitution=0.2,
)


THROWN = {"q": (0.0, 2.5, -0.5), "qdot": (0.0, 0.5, -5.0)}


@pytest.mark.parametrize("record", [True, False])
def test_a_box_that_comes_to_rest_on_the_ground_of_its_lid_says_so(record):
    body = box()
    run = sf.simulate(body, **THROWN, impact="moreau", record=record)
    assert run.outcome == "rest"
    assert math.cos(run.q[2]) == pytest.approx(-1, abs=1e-9)  # upside down
    assert places(body, run.q)[:, 1].min() == pytest.approx(1, abs=1e-9)
    [text] = said(run)
    assert re.match(r"contact [34] touches its own ground line at t = [\d.]+ s", text)
    assert re.search(r"contact [12] lies below the ground line of contact [34]", text)
    assert "terrain=" in text
    assert "segment=" in text
    time = float(re.search(r"t = ([\d.]+) s", text)[1])
    assert 0 < time <= run.time


def test_with_a_terrain_the_box_lands_on_the_floor():
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    contacts = [sf.Contact(point, friction=0.4) for point in corners]
    body = box(contacts=contacts, terrain=[(-50, 0), (50, 0)])
    run = sf.simulate(body, **THROWN, impact="moreau")
    assert run.outcome == "rest"
    assert said(run) == []
    assert places(body, run.q)[:, 1].min() == pytest.approx(0, abs=1e-9)


def ladder(**foot):
    """A ladder with its foot on the floor and its top at a wall on the right."""
    return sf.Posture(
        mass=1.0,
        gyration_radius=0.6,
        center_of_mass=(0.5, 1.0),
        contacts=[
            sf.Contact((0.0, 0.0), **foot),
            sf.Contact((1.0, 2.0), slope=1.5),
        ],
        restitution=0.0,
    )


@pytest.mark.parametrize("model", ["full", "local"])
@pytest.mark.parametrize("time_limit", [1.3, 3.0])
def test_a_ladder_that_falls_through_the_floor_says_so(model, time_limit):
    body = ladder()
    run = sf.simulate(
        body, (0, 0, 0), (0, 0, 0), model=model, stop="time", time_limit=time_limit
    )
    # Its top falls below the floor, and may swing up again there.
    q, _ = run.at(np.linspace(0, time_limit, 100))
    assert heights(body, places(body, q, model))[:, 1, 0].min() < -0.1
    [text] = said(run)
    assert "contact 2 is below the ground line of contact 1 at t = " in text
    time = float(re.search(r"t = ([\d.]+) s", text)[1])
    q, _ = run.at(time)
    assert heights(body, places(body, q, model))[1, 0] < 0


def test_a_ladder_that_has_not_come_to_the_floor_says_nothing():
    body = ladder()
    run = sf.simulate(body, (0, 0, 0), (0, 0, 0), stop="time", time_limit=0.5)
    assert heights(body, places(body, run.q))[1, 0] > 0.5
    assert said(run) == []


def test_a_segment_says_what_ground_is_meant():
    """With a segment that ends beside the ladder, the top cannot fall through a line."""
    body = ladder(segment=(-10.0, 0.5))
    run = sf.simulate(body, (0, 0, 0), (0, 0, 0), stop="time", time_limit=1.2)
    assert heights(body, places(body, run.q))[1, 0] < -0.1
    assert said(run) == []
    # Two steps with segments of their true lengths; the body slides off both.
    steps = [
        sf.Contact((0, 0), segment=(-9, 0.4)),
        sf.Contact((1, 0.5), segment=(-0.6, 9)),
    ]
    body = sf.Posture(1.0, 0.5, (0.5, 0.7), steps, 0.0)
    run = sf.simulate(body, (0, 0, 0), (2, 0, 0), stop="time", time_limit=1.0)
    assert run.q[0] > 1
    assert said(run) == []


def test_the_same_floor_typed_with_few_digits_is_one():
    """Both contacts stand on one incline, but the second point is 3e-5 off the line of the first one."""
    feet = [
        sf.Contact((0, 0), slope=-0.3, friction=0.1),
        sf.Contact((1, -0.3093), slope=-0.3, friction=0.1),
    ]
    body = sf.Posture(1.0, 0.5, (0.6, 0.4), feet, 0.0)
    run = sf.simulate(body, (0, 0, 0), (1, -0.3, 0), stop="time", time_limit=3.0)
    assert np.hypot(*run.q[:2]) > 5 * size(body)
    assert said(run) == []


def posture_on(shape, rng):
    """Two or three feet on a V, a roof or stairs; the edges between their grounds are at least .15 from them."""
    scale = 10 ** rng.uniform(-2, 2)
    left, right = -rng.uniform(0.3, 1), rng.uniform(0.3, 1)
    if shape == "stairs":
        slopes, rise = (0.0, 0.0), rng.uniform(0.1, 0.6)
    else:
        slopes, rise = rng.uniform(0.05, 0.6, 2) * (-1, 1), 0.0
        if shape == "roof":
            slopes = -slopes
    feet = [
        (left, left * math.tan(slopes[0]), slopes[0]),
        (right, right * math.tan(slopes[1]) + rise, slopes[1]),
    ]
    if rng.random() < 0.3:  # a third one beside the second
        x = right + rng.uniform(0.1, 0.5)
        feet.append((x, x * math.tan(slopes[1]) + rise, slopes[1]))
    contacts = [
        sf.Contact((scale * x, scale * y), slope=slope, friction=rng.uniform(0.7, 1.5))
        for x, y, slope in feet
    ]
    return sf.Posture(
        mass=1.0,
        gyration_radius=scale * rng.uniform(0.2, 0.8),
        center_of_mass=(
            scale * rng.uniform(0.6 * left, 0.6 * right),
            scale * rng.uniform(0.1, 0.8),
        ),
        contacts=contacts,
        restitution=rng.uniform(0, 0.6),
        gravity=G,
    )


def kicked(posture, kick, rng, time_limit):
    """A run to the time limit with a random model and law."""
    return sf.simulate(
        posture,
        (0, 0, 0),
        kick,
        model=str(rng.choice(["full", "local", "auto"])),
        impact=str(rng.choice(["newton", "poisson", "moreau"])),
        stop="time",
        time_limit=time_limit,
        event_limit=20_000,
    )


@pytest.mark.parametrize("shape", ["V", "roof", "stairs"])
def test_a_posture_that_is_kicked_near_where_it_stands_says_nothing(shape):
    """Motions of up to half of the distance to the edge of the ground: flying, rocking, sliding and rotating there cause no
    warning."""
    rng = np.random.default_rng([23, len(shape)])
    ends = Counter()
    while ends["near"] < POSTURES:
        posture = posture_on(shape, rng)
        length = size(posture)
        speed = math.sqrt(G * length) * 10 ** rng.uniform(-3, -1)
        kick = speed * rng.uniform(-1, 1, 3) / (1, 1, length)
        run = kicked(posture, kick, rng, 20 * math.sqrt(length / G))
        t = np.linspace(0, run.time, 100)
        at = places(posture, run.at(t)[0], run.model)
        points = np.array([contact.point for contact in posture.contacts])
        way = np.linalg.norm(at - points, axis=-1).max()
        # The others have tipped over, or slide down.
        if way < 0.07 * length:
            ends["near"] += 1
            ends[run.outcome] += 1
            assert said(run) == [], (posture, kick, run.model)
        ends["all"] += 1
    assert ends["near"] > 0.3 * ends["all"], ends


def wrong(posture, q, model, gaps, by):
    """Whether contacts are at implausible places: (i) below a line, or (ii) far away from their own. The limits are
    exceeded by a factor of at least ``by``."""
    points = np.array([contact.point for contact in posture.contacts])
    length, nominal = size(posture), heights(posture, points)
    at = places(posture, q, model)
    way = np.linalg.norm(at - points, axis=-1)
    small = 1e-3 * (length + way[:, None])
    below = (nominal >= -1e-3 * length) & (heights(posture, at) < -by * small)
    apart = (nominal < -1e-3 * length).any()
    far = apart & (gaps == 0) & (way > by * length)
    return below.any(), far.any()


@pytest.mark.parametrize("shape", ["V", "roof", "stairs"])
def test_what_a_run_says_of_its_ground_is_so(shape):
    """Strong kicks. Each warning is true at its time, and each implausible place at the end, found independently, has a
    warning."""
    rng = np.random.default_rng([24, len(shape)])
    ends = Counter()
    for _ in range(POSTURES):
        posture = posture_on(shape, rng)
        length = size(posture)
        speed = math.sqrt(G * length) * rng.uniform(0.3, 3)
        kick = speed * rng.normal(0, 1, 3) / (1, 1, length)
        run = kicked(posture, kick, rng, 10 * math.sqrt(length / G))
        texts = said(run)
        assert len(texts) <= 1
        if texts:
            time = float(re.search(r"t = (\S+) s", texts[0])[1])
            q, _ = run.at(time)
            gaps = run.gaps_at(time)
            # The time is rounded, and the gaps at that time are those after an impact.
            gaps = np.where(gaps < 1e-9 * length, 0.0, gaps)
            below, far = wrong(posture, q, run.model, gaps, 0.999)
            assert below if "is below" in texts[0] else far, (texts, below, far)
        else:
            found = wrong(posture, run.q, run.model, run.gaps, 1.001)
            assert found == (False, False), (posture, kick)
        ends["warned" if texts else "quiet"] += 1
    assert min(ends["warned"], ends["quiet"]) > 0.05 * POSTURES, ends


@pytest.mark.parametrize("model", ["full", "local", "auto"])
def test_many_runs_know_what_one_says(model):
    """The same warnings in one call and in single runs; some runs have them, some not."""
    rng = np.random.default_rng(25)
    ramps = [
        sf.Contact((-0.5, 0.1), slope=-0.2, friction=0.0),
        sf.Contact((0.5, 0.2), slope=0.4, friction=0.3),
    ]
    body = sf.Posture(1.0, 0.4, (0.0, 0.4), ramps, 0.85)
    count = 300
    q = np.stack([np.zeros(count), rng.uniform(0.3, 1, count), np.zeros(count)], -1)
    qdot = rng.normal(0, 1, (count, 3)) * (0.7, 1, 0.5)
    options = {"model": model, "stop": "time", "time_limit": 1.0}
    runs = sf.simulate_many(body, q, qdot, **options)
    ones = [runs[i] for i in range(count)]
    assert [bool(one.warnings) for one in ones] == runs.warned.tolist()
    warned = sum(bool(said(one)) for one in ones)
    assert 0.02 * count < warned < 0.98 * count
