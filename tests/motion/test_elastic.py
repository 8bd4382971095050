"""Restitution 1: impacts that keep the energy. A run needs a time limit; verdicts and certificates need e < 1."""

import mpmath
import numpy as np
import pytest
import standfast as sf

G = 9.81
SCENES = 1000
ROOM = [(-5, 0), (5, 0), (5, 1), (-5, 1)]


def ball(terrain=None):
    """A disc of radius 0.1 m."""
    disc = sf.Contact(center=(0, 0.1), radius=0.1)
    return sf.Posture(1.0, 0.07, (0, 0.1), [disc], 1.0, gravity=G, terrain=terrain)


def periods(speed, height):
    """Times of flight from the floor to a ceiling at `height` with this speed, to 40 digits."""
    with mpmath.workdps(40):
        g, v = mpmath.mpf(G), mpmath.mpf(speed)
        return (v - mpmath.sqrt(v * v - 2 * g * height)) / g


def test_ten_thousand_impacts_between_floor_and_ceiling():
    run = sf.simulate(ball(ROOM), qdot=(0, 6.0, 0), time_limit=1600.0)
    assert run.outcome == "time-limit"
    assert len(run.impacts) > 10_000
    assert not run.warnings
    with mpmath.workdps(40):
        flight = periods(6.0, 1 - 2 * mpmath.mpf(0.1))
        times = np.array([float((k + 1) * flight) for k in range(len(run.impacts))])
    # The clock has twice the digits of a double; the times are right to a few roundings each.
    np.testing.assert_allclose(run.impacts["time"], times, rtol=1e-15)


def test_ten_thousand_bounces():
    run = sf.simulate(ball(), q=(0, 1.0, 0), time_limit=10_000.0)
    assert len(run.impacts) > 10_000
    with mpmath.workdps(40):
        fall = mpmath.sqrt(2 / mpmath.mpf(G))
        times = np.array([float((2 * k + 1) * fall) for k in range(len(run.impacts))])
    np.testing.assert_allclose(run.impacts["time"], times, rtol=1e-15)


def scene(rng):
    """A body on one to four points without friction, over lines of their own or in a valley."""
    count = int(rng.integers(1, 5))
    points = rng.uniform(-0.5, 0.5, (count, 2)) * [1, 0.3]
    valley = rng.random() < 0.4
    slopes = np.zeros(count) if valley else rng.normal(0, 0.3, count)
    feet = [
        sf.Contact(tuple(point), slope=slope)
        for point, slope in zip(points, slopes, strict=True)
    ]
    return sf.Posture(
        mass=rng.uniform(0.5, 2),
        gyration_radius=rng.uniform(0.1, 0.5),
        center_of_mass=(rng.normal(0, 0.1), rng.uniform(0.1, 0.5)),
        contacts=feet,
        restitution=1.0,
        gravity=G,
        terrain=[(-100, 200), (-1, -0.3), (1, -0.3), (100, 200)] if valley else None,
    )


def energy(posture, q, qdot):
    kinetic = (
        posture.mass
        * (qdot[0] ** 2 + qdot[1] ** 2 + (posture.gyration_radius * qdot[2]) ** 2)
        / 2
    )
    return kinetic, kinetic + posture.mass * G * q[1]


def test_energy_is_constant_without_friction():
    rng = np.random.default_rng(1)
    collisions = 0
    for k in range(SCENES):
        posture = scene(rng)
        q = (rng.normal(0, 0.05), rng.uniform(0.5, 1.5), rng.normal(0, 0.3))
        qdot = rng.normal(0, 1, 3)
        options = {"time_limit": rng.uniform(1, 10), "event_limit": 5000}
        kind = (
            rng.choice(["full", "local", "mechanism"])
            if posture.terrain is None
            else "full"
        )
        if kind == "mechanism":
            run = sf.simulate(sf.Mechanism.of_posture(posture), q, qdot, **options)
        else:
            run = sf.simulate(
                posture,
                q,
                qdot,
                model=kind,
                impact=rng.choice(["newton", "moreau"]),
                **options,
            )
        assert run.outcome == "time-limit", k
        collisions += run.collisions
        # A body that has fallen far has energies much larger than those of its start.
        before, after = energy(posture, q, qdot), energy(posture, run.q, run.qdot)
        size = max(abs(before[1]), after[0], abs(after[1] - after[0]))
        assert abs(after[1] - before[1]) <= 1e-12 * size, (k, kind)
    assert collisions > 10 * SCENES


def test_a_contact_that_rests_is_not_hit():
    """A box that stands with e = 1 stands; tilted, it rocks for ever at the same height."""
    box = sf.Posture.box(1, 2, friction=1.0, restitution=1.0)
    assert sf.simulate(box, time_limit=10.0).outcome == "rest"
    tilted = sf.simulate(box, (0, 0.3, 0), (0, 0, 0), time_limit=10.0, impact="moreau")
    assert tilted.outcome == "time-limit"
    # It lands flat each time and rises to 0.3 m again.
    np.testing.assert_allclose(
        tilted.impacts["rates_before"].min(axis=1), -np.sqrt(2 * G * 0.3), rtol=1e-12
    )


def test_one_contact_with_losses_brings_the_other_to_rest():
    """Foot 1 keeps nothing and foot 2 everything: they are hit in turn, and each turn keeps one fraction of the speed."""
    feet = [sf.Contact((-0.5, 0), restitution=0), sf.Contact((0.5, 0))]
    body = sf.Posture(1.0, 0.4, (0, 0.2), feet, 1.0, gravity=G)
    start = {"q": (0, 0, 0), "qdot": (0, 0, 0.05), "time_limit": 50.0}
    full, local = (
        sf.simulate(body, **start, model=model) for model in ("full", "local")
    )
    for run in (full, local):
        assert run.outcome == "rest"
        assert {1, 2} == set(run.impacts["contact"])
    assert abs(full.time / local.time - 1) < 0.01


def test_a_run_without_an_end_is_refused():
    body, text = (
        ball(),
        "restitution of contact 1 = 1.0 is outside its range: below 1, or with a time_limit",
    )
    for options in ({}, {"stop": "zeno"}, {"time_limit": np.inf}):
        with pytest.raises(ValueError, match=text):
            sf.simulate(body, (0, 1, 0), **options)
    rod = sf.Posture.rod(0.5, restitution=1.0)
    with pytest.raises(ValueError, match=text):
        sf.simulate(sf.Mechanism.of_posture(rod), (0, 0.1, 0.01))
    with pytest.raises(ValueError, match=text):
        sf.LocalModel((G, G), (0, 0), (0, 0), 1.0).simulate((0.1, 0.2), (0, 0))


def test_an_elastic_piece_of_ground_needs_an_end_too():
    """The error names the contact that may come to such a piece."""
    feet = [sf.Contact((-3, 0), restitution=0.2), sf.Contact((-2, 0), restitution=0.2)]
    terrain, shares = [(-5, 0), (0, 0), (5, 0)], [None, 1.0]
    body = sf.Posture(
        1.0, 0.4, (-2.5, 0.2), feet, 0.2, terrain=terrain, terrain_restitution=shares
    )
    with pytest.raises(
        ValueError, match=r"restitution of contact 1 = 1\.0 is outside .* time_limit"
    ):
        sf.simulate(body, (0, 1, 0))
    assert sf.simulate(body, (0, 1, 0), time_limit=5.0).outcome == "rest"


def test_verdicts_and_certificates_need_losses():
    rod = sf.Posture.rod(0.5, friction=0.5, restitution=1.0)
    text = "restitution of contact 1 = 1.0 is outside its range: below 1"
    for subject in (rod, sf.Mechanism.of_posture(rod)):
        with pytest.raises(ValueError, match=text):
            sf.stability(subject)
    with pytest.raises(ValueError, match=text):
        sf.simulate(rod, (0, 0.1, 0.01), certify=True, time_limit=1.0)
    # A contact in the air takes no part in a verdict.
    feet = [
        sf.Contact((-0.5, 0), friction=0.5),
        sf.Contact((0.5, 0), friction=0.5),
        sf.Contact((0, 1.0), restitution=1.0),
    ]
    body = sf.Posture(1.0, 0.4, (0, 0.2), feet, 0.1, terrain=[(-5, 0), (5, 0)])
    assert sf.stability(body).frictional_stability == "stable"
