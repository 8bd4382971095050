"""A body in the local model, and the same body as a mechanism: one motion."""

import os

import numpy as np
import standfast as sf

#: Number of random scenes.
SCENES = int(os.environ.get("STANDFAST_POSTURES_AS_MECHANISMS", "1500"))


def draw(rng):
    """A body of 1 kg on two contacts: on one line or on two, thrown, dropped or pushed."""
    xs = (-1 + rng.uniform(-0.2, 0.2), 1 + rng.uniform(-0.2, 0.2))
    slopes = (0, 0) if rng.random() < 0.5 else rng.uniform(-0.4, 0.4, 2)
    friction = rng.choice([0, 0, 0.4])
    contacts = [
        sf.Contact((x, 0), slope=slope, friction=friction)
        for x, slope in zip(xs, slopes, strict=True)
    ]
    center = (rng.uniform(-0.8, 0.8), rng.uniform(0.3, 2))
    e = rng.choice([0, 0.1, 0.3, 0.5, 0.7])
    body = sf.Posture(1.0, rng.uniform(0.3, 1.5), center, contacts, e)
    dropped = rng.integers(3) == 0
    q = (0, rng.uniform(1e-4, 1e-2) if dropped else 0, 0)
    v = rng.uniform(-0.1, 0.1, 3)
    if not dropped and min(body.gap_rates(q, v)) < 0:
        v[1] = abs(v[1]) + 0.3
    return body, q, v


def told(run):
    """The discrete part of a run."""
    points = [(z.kind, z.contacts, z.method, z.certified) for z in run.zeno_points]
    return run.outcome, points, [phase.mode for phase in run.phases], run.collisions


def test_a_body_and_its_mechanism_move_as_one():
    """Of 1 kg: the rows of both have the same bits, and so have all times."""
    rng = np.random.default_rng(20261126)
    nested = 0
    for _ in range(SCENES):
        body, q, v = draw(rng)
        if min(body.gaps(q)) < 0 or (min(body.gap_rates(q, v)) < 0 and q[1] == 0):
            continue
        options = {"impact": "newton", "time_limit": 5.0, "event_limit": 20_000}
        one = sf.simulate(body, q, v, model="local", **options)
        other = sf.simulate(sf.Mechanism.of_posture(body), q, v, **options)
        assert told(one) == told(other), (body, q, v)
        assert one.elapsed == other.elapsed
        np.testing.assert_allclose(one.q, other.q, rtol=0, atol=1e-13)
        nested += len(one.zeno_points) > 1
    assert nested > SCENES / 10


def test_contacts_at_one_point_move_as_one():
    """A contact that is listed twice changes no motion, and each of the two has the gap, the letter and half of the force of the one."""
    feet = [sf.Contact((-0.3, 0), friction=0.4), sf.Contact((0.5, 0), friction=0.4)]
    body = {"mass": 1.0, "gyration_radius": 0.4, "center_of_mass": (0.1, 0.6), "restitution": 0.5}  # fmt: skip
    start = {"q": (0, 0.1, 0.01), "qdot": (0.1, 0, -0.2), "model": "local"}
    for law in ("newton", "moreau", "stronge"):
        one = sf.simulate(sf.Posture(contacts=feet, **body), impact=law, **start)
        two = sf.simulate(
            sf.Posture(contacts=[feet[0], *feet], **body), impact=law, **start
        )
        assert (one.outcome, two.outcome) == ("rest", "rest")
        np.testing.assert_allclose(two.q, one.q, atol=1e-12)
        assert abs(two.elapsed - one.elapsed) <= 1e-12
        t = one.elapsed / 2
        np.testing.assert_allclose(
            two.gaps_at(t)[[0, 1, 2]], one.gaps_at(t)[[0, 0, 1]], atol=1e-12
        )
        assert two.phases[-1].mode == one.phases[-1].mode[0] + one.phases[-1].mode
        np.testing.assert_allclose(
            two.forces_at(two.time)[[0, 2]],
            one.forces_at(one.time) * [[0.5], [1]],
            atol=1e-9,
        )
        assert all(len(before) == 3 for before in two.impacts["rates_before"])
        assert {1, 3} == set(two.impacts["contact"].tolist())


def test_moreaus_law_acts_on_contacts_at_rest_without_friction_too():
    """The first contact approaches and the second one rests. Their rates w p + u are complementary to impulses p ≥ 0 with the restitution e:
    an impulse at the first alone would throw the second into its ground."""
    rows = [
        sf.ContactRows(normal=[1.25, -0.25, -1.75], tangential=[0, 1, 0]),
        sf.ContactRows(normal=[-1.875, -0.625, 1.625], tangential=[1, 0, 0]),
    ]
    system = sf.Mechanism(np.eye(3), [0, 0, 0], rows, restitution=0.375)
    start = np.array([-0.625, 1.875, 0.0])
    run = sf.simulate(system, np.zeros(3), start, impact="moreau", time_limit=1e-3)
    normals = np.array([row.normal for row in rows])
    p = np.linalg.solve(normals @ normals.T, -1.375 * (normals @ start))
    assert (p > 0).all()
    assert [impact["contact"] for impact in run.impacts] == [1, 2]
    np.testing.assert_allclose(run.qdot, start + p @ normals, atol=1e-13)


def test_a_box_has_constant_rows():
    """All its corners meet one level line. In the local model its small motion is that of its two lower corners."""
    box = sf.Posture.box(1.0, 0.5, friction=0.3, restitution=0.4)
    feet = sf.Posture(
        box.mass,
        box.gyration_radius,
        box.center_of_mass,
        list(box.contacts)[:2],
        0.4,
    )
    start = {"q": (0, 0.01, 0.002), "qdot": (0.1, 0, 0), "model": "local"}
    for options in ({}, {"kicks": [sf.Kick(0.03, (0.1, 0.2))]}):
        one, two = (sf.simulate(body, **start, **options) for body in (box, feet))
        assert (one.model, one.outcome) == ("local", "rest") == (two.model, two.outcome)
        assert abs(one.elapsed - two.elapsed) <= 1e-12
        np.testing.assert_allclose(one.q, two.q, atol=1e-12)
        np.testing.assert_allclose(one.gaps[2:] - one.gaps[:2], 0.5, atol=1e-12)


def test_forces_in_the_local_model_follow_tilted_ground():
    """At rest they carry the weight in the axes of the tilted ground."""
    body = sf.Posture.rod(0.5, 0.3, 0.0, 0.9)
    motion = sf.GroundMotion(times=[0.0], tilt=[0.1])
    run = sf.simulate(
        body,
        (0, 0, 0),
        (0, 0, 0),
        model="local",
        ground_motion=motion,
        stop="time",
        time_limit=1.0,
    )
    weight = body.mass * body.gravity
    total = run.forces_at(0.5).sum(axis=0)
    np.testing.assert_allclose(
        total, [weight * np.sin(0.1), weight * np.cos(0.1)], rtol=1e-12
    )
