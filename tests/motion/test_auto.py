"""The model that "auto" chooses satisfies the tolerance, compared with the full model on random scenes."""

import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import draw_contacts, size

G = 9.81
#: Number of random scenes; `make long` has more.
SCENES = int(os.environ.get("STANDFAST_AUTO_SCENES", "100"))


def scene(rng):
    """One to three contacts on level or sloping ground, thrown from gaps of 1e-7 to 1e-1 m."""
    count = rng.choice([1, 2, 2, 2, 2, 2, 2, 3])
    level, smooth = rng.random(2) < 0.5
    feet = {1: [0.0], 2: [-0.5, 0.5], 3: [-0.5, 0.1, 0.5]}[count]
    rise, steep = (0, 0) if level else (0.2, 0.4)
    contacts = draw_contacts(
        rng,
        (x + rng.uniform(-0.05, 0.05) for x in feet),
        rise,
        steep,
        friction=lambda: 0.0 if smooth else rng.uniform(0.0, 1.0),
        restitution=lambda: rng.choice([None, rng.uniform(0.0, 0.9)]),
    )
    low = rng.random() < 0.3
    posture = sf.Posture(
        mass=rng.uniform(0.5, 2.0),
        gyration_radius=rng.uniform(0.1, 0.7),
        center_of_mass=(rng.uniform(-0.2, 0.2), 0.0 if low else rng.uniform(0.0, 0.6)),
        contacts=contacts,
        restitution=rng.uniform(0.0, 0.9),
        gravity=G,
    )
    height = 10 ** rng.uniform(-7, -1)
    tilt = height * rng.choice([0.0, 1.0, 1.0, 1.0])
    q = rng.uniform(-1, 1, 3) * (height, 0, tilt) + (0, 1.5 * height, 0)
    moves = math.sqrt(2 * G * height) * rng.choice([0.0, 1.0])
    if rng.random() < 0.1:
        # A vertical fall: all contacts land at once, on any slopes.
        q, moves = np.array([0.0, height, 0.0]), 0.0
    qdot = rng.uniform(-1, 1, 3) * moves
    options = {
        "impact": "newton",
        "tolerance": 10 ** rng.uniform(-12, -2),
        "stop": rng.choice(["zeno", "rest", "rest", "time"]),
        "record": bool(rng.choice([True, False])),
        "event_limit": 20_000,
    }
    if options["stop"] == "time":
        options["time_limit"] = rng.uniform(0.5, 20.0) * math.sqrt(2 * height / G)
    return posture, q, qdot, options


def errors(run, full, length):
    """Errors of times, relative to the duration, and of q, relative to the size."""
    times = [run.elapsed - full.elapsed]
    if run.zeno_points:
        times.append(run.zeno_points[0].elapsed - full.zeno_points[0].elapsed)
    dx, dy, turn = run.q - full.q
    return max(map(abs, times)) / (full.elapsed or 1.0), max(
        math.hypot(dx, dy) / length, abs(turn)
    )


def test_every_scene_keeps_its_tolerance():
    rng = np.random.default_rng(20260)
    served, tight, worst = 0, 0, 0.0
    tried = 0
    while tried < SCENES:
        posture, q, qdot, options = scene(rng)
        if (posture.gaps(q) < 0).any():
            continue
        tried += 1
        full = sf.simulate(posture, q, qdot, model="full", **options)
        auto = sf.simulate(posture, q, qdot, **options)
        case = f"{posture!r}, q={q.tolist()}, qdot={qdot.tolist()}, {options}: {auto.model_reason}"
        assert auto.outcome == full.outcome, case
        first = [
            [(z.kind, z.contacts) for z in run.zeno_points[:1]] for run in (auto, full)
        ]
        assert first[0] == first[1], case
        if auto.model == "full":
            assert auto.elapsed == full.elapsed, case
            np.testing.assert_array_equal(auto.q, full.q)
            continue
        served += 1
        error = max(errors(auto, full, size(posture)))
        assert error <= options["tolerance"], case
        worst = max(worst, error / options["tolerance"])
        tight += error > 1e-3 * options["tolerance"]
    print(
        f"{tried} scenes, local in {served}; largest error {worst:.3f} of the tolerance"
    )
    # The local model is chosen often enough, also in nontrivial scenes.
    assert served > SCENES / 20
    assert tight > SCENES / 100


@pytest.mark.parametrize("stop", ["zeno", "rest"])
def test_a_scene_is_served_down_to_its_error(stop):
    """One scene with many tolerances: the local model is chosen if the tolerance is above twice its error, and the
    full model below its error."""
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.3,
        center_of_mass=(0.0, 0.3),
        contacts=[
            sf.Contact(point=(-0.5, 0), friction=0.4),
            sf.Contact(point=(0.4, 0), friction=0.4),
        ],
        restitution=0.3,
        gravity=G,
    )
    start = {"q": (0, 2e-5, 7e-6), "qdot": (0, 0, 0), "stop": stop, "impact": "newton"}
    full = sf.simulate(posture, model="full", **start)
    local = sf.simulate(posture, model="local", **start)
    error = max(errors(local, full, size(posture)))
    assert 1e-8 < error < 1e-4
    for tolerance in (1e-2, 1e-3, 4 * error):
        run = sf.simulate(posture, tolerance=tolerance, **start)
        assert run.model == "local"
        assert run.elapsed == local.elapsed
    for tolerance in (error, 0.1 * error, 1e-12):
        run = sf.simulate(posture, tolerance=tolerance, **start)
        assert run.model == "full"
        assert run.elapsed == full.elapsed


def test_exact_at_any_height():
    ball = {
        "mass": 1.0,
        "gyration_radius": 0.1,
        "center_of_mass": (0, 0.2),
        "restitution": 0.7,
        "gravity": G,
    }
    rough = sf.Posture(contacts=[sf.Contact(point=(0, 0), friction=0.5)], **ball)
    run = sf.simulate(rough, (0, 5.0, 0), (0, 0, 0))
    assert run.model == "local"
    assert "exact" in run.model_reason
    assert (
        run.elapsed == sf.simulate(rough, (0, 5.0, 0), (0, 0, 0), model="full").elapsed
    )
    # Thrown along the ground, it is rotated by friction.
    assert sf.simulate(rough, (0, 5.0, 0), (1, 0, 0)).model == "full"


def test_a_run_that_is_not_recorded_keeps_nothing():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    start = ((0, 1.1e-6, 2e-7), (0, 0, 0))
    kept = sf.simulate(rod, *start, tolerance=1e-3, stop="zeno")
    bare = sf.simulate(rod, *start, tolerance=1e-3, stop="zeno", record=False)
    assert kept.model == bare.model == "local"
    assert kept.elapsed == bare.elapsed
    assert len(kept.impacts) > 0
    assert len(bare.impacts) == 0
    with pytest.raises(ValueError, match="record"):
        bare.at(0.0)


def test_a_limit_that_comes_first_is_kept():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    start = ((0, 1.1e-4, 2e-5), (0, 0, 0))
    end = sf.simulate(rod, *start, model="full").elapsed
    for limit in (0.5 * end, end * (1 - 1e-9), end, end * (1 + 1e-9), 2 * end):
        auto, full = (
            sf.simulate(rod, *start, model=model, time_limit=limit, tolerance=1e-2)
            for model in ("auto", "full")
        )
        assert auto.outcome == full.outcome, limit


def test_a_body_that_rests_on_one_foot_is_not_local():
    """The centre of mass is right above foot 1. In the linearised model the body rests at any rotation; really,
    rotated by 1e-9 rad, it tips over."""
    posture = sf.Posture(
        mass=1.0,
        gyration_radius=0.3,
        center_of_mass=(0, 0.5),
        restitution=0.5,
        gravity=10.0,
        contacts=[sf.Contact((x, 0), friction=0.5) for x in (0, 1)],
    )
    run = sf.simulate(posture, (0, 1e-5, 1e-9), (0, 0, 0), impact="newton")
    assert (run.model, run.outcome) == ("full", "rest")
    assert "tips over" in run.model_reason
    assert run.q[2] == pytest.approx(math.pi)


def test_a_body_that_tips_over_at_the_end_of_its_slide_does_not_rest():
    """The centre of mass is just inside of a foot, and beyond the foot after a small rotation that the local model
    neglects. So the full model must decide."""
    rng = np.random.default_rng(43)
    local = 0
    for _ in range(600):
        slopes, friction = rng.uniform(-0.4, 0.4, 2), rng.uniform(0.5, 1)
        inside, side = 10 ** rng.uniform(-5, -1.5), rng.choice([-1, 1])
        posture = sf.Posture(
            1.0,
            rng.uniform(0.3, 0.8),
            (side * (1 - inside), rng.uniform(0.3, 1)),
            [
                sf.Contact((x, 0), slope=slope, friction=friction)
                for x, slope in zip((-1, 1), slopes, strict=True)
            ],
            0.05,
            10.0,
        )
        qdot = rng.normal(size=3) * 10 ** rng.uniform(-2, -0.5)
        options = {"tolerance": 1e-3, "time_limit": 20.0, "impact": "newton"}
        run = sf.simulate(posture, (0, 0, 0), qdot, **options)
        if run.model != "local":
            continue
        local += 1
        full = sf.simulate(posture, (0, 0, 0), qdot, model="full", **options)
        assert run.outcome == full.outcome
        assert run.q == pytest.approx(full.q, abs=2e-3)
    assert local > 100


def test_the_tolerance_of_an_early_zeno_point_is_that_of_the_whole_run():
    """Landing takes milliseconds, the slide after it a second: the tolerance of times is tolerance × run.elapsed."""
    feet = [sf.Contact((x, 0.0), friction=0.15) for x in (-0.5, 0.5)]
    body = sf.Posture(1.0, 0.4, (0.05, 0.1), feet, 0.2)
    tolerance, q, qdot = 1e-4, (0, 1e-4, 5e-7), (2.0, 0, 0)
    auto = sf.simulate(body, q, qdot, impact="newton", tolerance=tolerance)
    full = sf.simulate(body, q, qdot, impact="newton", model="full")
    assert (auto.model, auto.outcome) == ("local", "rest")
    first, true = auto.zeno_points[0], full.zeno_points[0]
    assert true.elapsed < 0.02 * full.elapsed
    error = abs(first.elapsed - true.elapsed)
    assert (
        first.time_error < error <= tolerance * auto.elapsed
    )  # time_error does not include the error of the model
