"""The model that "auto" takes."""

import math

import numpy as np
import pytest
import standfast as sf
from bodies import draw_contacts

G = 9.81


def body(rng):
    """A body under whose centre of mass is its only contact, or, in two of five cases, any body with one to three contacts."""
    if rng.random() < 0.6:
        contacts = [
            sf.Contact(
                (0, 0), friction=rng.choice([0, 0.5]), slope=rng.choice([0, 0.2])
            )
        ]
        return sf.Posture(1.0, 0.3, (0, rng.choice([0, 0.4])), contacts, 0.6, G)
    count = rng.choice([1, 2, 3])
    places = rng.uniform(-0.5, 0.5, count)
    slopes = rng.choice([0, 0.3])
    contacts = draw_contacts(
        rng,
        places,
        0.1,
        slopes,
        friction=lambda: rng.choice([0, 0.5]),
        restitution=lambda: rng.uniform(0, 0.8),
    )
    return sf.Posture(1.0, 0.3, (rng.uniform(-0.2, 0.2), 0.4), contacts, 0.5, G)


def test_auto_is_the_local_model_where_the_full_one_does_not_turn():
    rng = np.random.default_rng(20261127)
    taken = {"local": 0, "full": 0}
    for _ in range(300):
        posture = body(rng)
        q = (0, 1, rng.choice([0, 0.1]))
        qdot = rng.choice([0, 1], 3) * rng.uniform(-1, 1, 3)
        if (posture.gaps(q) < 0).any():
            continue
        options = {"time_limit": 20.0, "event_limit": 20_000}
        auto = sf.simulate(posture, q, qdot, **options)
        same = sf.simulate(posture, q, qdot, model=auto.model, **options)
        assert (auto.outcome, auto.elapsed) == (same.outcome, same.elapsed)
        np.testing.assert_array_equal(auto.q, same.q)
        taken[auto.model] += 1
        full = sf.simulate(posture, q, qdot, model="full", **options)
        if auto.model == "local":
            assert full.q[2] == full.qdot[2] == 0, posture
            assert full.outcome == auto.outcome
            assert full.elapsed == pytest.approx(auto.elapsed, rel=1e-14)
            np.testing.assert_allclose(full.q, auto.q, rtol=1e-13, atol=1e-13)
    assert min(taken.values()) > 20, taken


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
    full = sf.simulate(rough, (0, 5.0, 0), (0, 0, 0), model="full")
    exact = math.sqrt(2 * 5.0 / G) * (1 + 0.7) / (1 - 0.7)
    assert abs(run.elapsed - exact) <= 2 * math.ulp(exact)
    assert abs(full.elapsed - exact) <= full.time_error
    # Thrown along the ground, it is turned by friction.
    thrown = sf.simulate(rough, (0, 5.0, 0), (1, 0, 0))
    assert (thrown.model, thrown.model_reason) == ("full", "the body may turn")
    kicks = [sf.Kick(0.1, (0, 1))]
    kicked = sf.simulate(rough, (0, 5.0, 0), (0, 0, 0), kicks=kicks)
    assert kicked.model == "full"
