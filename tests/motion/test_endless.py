"""Runs that formerly did not end, and random scenes like them: each ends with a named outcome or a reason why not."""

import math
import os
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import standfast as sf
from bodies import LAWS, lift

#: Number of random scenes, and number of those that may end by a limit.
SCENES = int(os.environ.get("STANDFAST_ENDLESS", "400"))
ENDED_BY_A_LIMIT = 1e-4
FILES = sorted((Path(__file__).parents[1] / "data" / "endless").glob("*.json"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_what_used_to_rattle_for_ever_ends(path):
    scene = sf.load(path)
    run = scene.simulate(event_limit=1_000_000, record=False)
    assert run.outcome in ("rest", "ambiguous", "time-limit"), run.warnings


def draw(k):
    """One to four contacts on a floor, a slope, steps or slopes of their own; 0.1 to 10 m, 10 s."""
    rng = np.random.default_rng([77, k])
    size = 10 ** rng.uniform(-1, 1)
    kind, tilt = (
        rng.choice(["level", "flat", "slopes", "steps"]),
        rng.uniform(-0.5, 0.5),
    )
    friction, each = rng.choice([0.0, rng.uniform(0, 1.5)]), rng.random() < 0.5
    tangential = rng.choice([0.0, rng.uniform(0, 0.9)])
    contacts = []
    for _ in range(rng.integers(1, 5)):
        x = size * rng.uniform(-1, 1)
        y, slope = {
            "level": lambda x=x: (0.0, 0.0),
            "flat": lambda x=x: (x * math.tan(tilt), tilt),
            "steps": lambda x=x: (size * rng.uniform(-0.3, 0.3), 0.0),
            "slopes": lambda x=x: (size * rng.uniform(-0.3, 0.3), rng.uniform(-1, 1)),
        }[kind]()
        contacts.append(
            sf.Contact(
                (x, y),
                slope=slope,
                friction=rng.uniform(0, 1.5) if each else friction,
                tangential_restitution=tangential,
            )
        )
    posture = sf.Posture(
        10 ** rng.uniform(-1, 1),
        size * rng.uniform(0.1, 1),
        (size * rng.uniform(-0.6, 0.6), size * rng.uniform(-0.2, 1.0)),
        contacts,
        rng.choice([0.0, rng.uniform(0, 0.9), rng.uniform(0, 0.9)]),
        9.81,
    )
    law, speed = str(rng.choice(LAWS)), math.sqrt(9.81 * size)
    q = np.array([rng.uniform(-0.3, 0.3) * size, 0.0, rng.uniform(-0.4, 0.4)])
    up = max(0.0, lift(posture, q))
    q[1] = up + size * rng.choice([0.0, rng.uniform(0, 0.3)])
    qdot = speed * np.array(
        [rng.uniform(-1, 1), rng.uniform(-1, 0.3), rng.uniform(-1, 1) / size]
    )
    together = rng.random() < 0.5
    order = str(rng.choice(["first-contact-first", "last-contact-first"]))
    options = {
        "impact": law,
        "simultaneous": "newton" if law == "newton" and together else order,
    }
    return posture, q, qdot * rng.choice([0.0, 1.0, 1.0]), options


def ending(k):
    posture, q, qdot, options = draw(k)
    run = sf.simulate(
        posture, q, qdot, model="full", time_limit=10.0, record=False, **options
    )
    return k, run.outcome, run.warnings


def test_random_scenes_end():
    outcomes, limited = Counter(), []
    with ProcessPoolExecutor() as pool:
        for k, outcome, warnings in pool.map(ending, range(SCENES), chunksize=50):
            outcomes[outcome] += 1
            if outcome == "event-limit":
                reasons = [warning for warning in warnings if "ended after" in warning]
                limited.append((k, reasons))
                assert len(reasons) == 1
                assert any(
                    told in reasons[0]
                    for told in ("m/s", "on the ground", "without an impact")
                )
    print(dict(outcomes), limited)
    assert len(limited) <= ENDED_BY_A_LIMIT * SCENES, limited


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("contacts", [1, 2, 3, 8])
def test_an_event_limit_counts_collisions(law, contacts):
    feet = [
        sf.Contact((x, 0.0), friction=0.4) for x in np.linspace(-0.5, 0.6, contacts)
    ]
    body = sf.Posture(1.0, 0.4, (0.0, 0.5), feet, 0.95, 9.81)
    run = sf.simulate(
        body,
        (0, 1, 0.1),
        (0, 0, 0),
        model="full",
        impact=law,
        simultaneous="first-contact-first",
        event_limit=100,
    )
    if run.outcome == "event-limit":
        assert len(run.impacts) + len(run.phases) - 1 == 100
        [limit] = [warning for warning in run.warnings if "ended after" in warning]
        assert f"ended after 100 events, {len(run.impacts)} collisions" in limit
        assert " m/s" in limit or "on the ground" in limit
    else:
        assert contacts < 3
        assert run.outcome == "rest"
    if contacts == 3:
        assert len(run.impacts) == 100


def test_a_swing_that_returns_to_where_it_lifted_off_passes():
    """Two feet slide until one of them stops. The body then rotates about that foot, and the other foot is at its
    lowest point. After each rotation a rounding error decides whether this foot touches the ground again."""
    run = sf.load(FILES[[path.stem[:2] for path in FILES].index("15")]).simulate()
    same = run.impacts["time"][1:] == run.impacts["time"][:-1]
    assert run.outcome == "rest"
    assert same.sum() < 0.5 * len(same)


def test_contacts_that_stop_are_not_moved_by_the_rounding_errors_of_others():
    """Three feet on one line: the rate of one foot follows from the rates of the others. Its rounding error, 3e-17
    m/s, once caused impacts without end.

    The feet on the line slide with different friction, so that their motion depends on forces that are not
    determined.
    """
    points = [
        (-4.034095787283142, 8.565427286954161),
        (0.15684090535366502, 0.15867135571823907),
        (3.2373101863529468, 3.767834177222519),
        (6.9881080208761235, 8.162372431130517),
    ]
    slopes = [-1.128593669635232, *[0.8642660137310463] * 3]
    friction = [0.06860169126723391, 1.4061662498730414, 1.118189316305001, 1.1284604194271852]  # fmt: skip
    feet = [
        sf.Contact(point, slope=slope, friction=mu)
        for point, slope, mu in zip(points, slopes, friction, strict=True)
    ]
    body = sf.Posture(
        0.2871256482521775,
        2.4523296933233723,
        (1.3199071564125222, 1.618385952472074),
        feet,
        0.04833737887454173,
    )
    run = sf.simulate(
        body,
        (1.007529460932893, 1.468272495774019, 0.09482717200264969),
        (3.481520570389231, 2.0989477535509717, -0.869342712283682),
        model="full",
        time_limit=100.0,
    )
    assert run.outcome == "ambiguous"
    assert len(run.impacts) < 100


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.7])
def test_a_box_without_friction_slides_for_ever(law, restitution):
    """Nothing slows it down: it keeps its horizontal velocity to the last bit, and its other corners keep their heights."""
    rng = np.random.default_rng(78)
    for _ in range(20):
        width, height = rng.uniform(0.2, 1, 2)
        box = sf.Posture.box(width, height, restitution=restitution)
        q, spin = (0, height + 1, rng.uniform(-3, 3)), rng.uniform(-3, 3)
        run = sf.simulate(box, q, (1, 0, spin), impact=law)
        assert run.outcome == "sliding"
        assert run.time < 10
        assert run.qdot[0] == 1
        lying = [
            side
            for side in (width, height)
            if run.gaps.max() == pytest.approx(side, rel=1e-12)
        ]
        assert lying, run.gaps
        assert (run.rates == 0).all()
