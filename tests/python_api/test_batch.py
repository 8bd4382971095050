"""Many runs at once: the ends of single runs, with the same bits, as arrays."""

import math

import numpy as np
import pytest
import standfast as sf

ROD = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)


def starts(count):
    share = np.arange(count) / count
    q = np.zeros((count, 3))
    q[:, 1], q[:, 2] = 0.011, 0.02 * (share - 0.5)
    return q


def rods(count):
    """Rods with short and long clattering, with and without friction."""
    return [
        sf.Posture.rod(
            half_length=0.5,
            gyration_radius=0.1 + 0.3 * k / count,
            restitution=(0.1, 0.6, 0.97)[k % 3],
            friction=(0.0, 0.5)[k % 2],
        )
        for k in range(count)
    ]


@pytest.mark.parametrize("model", ["local", "full", "auto"])
@pytest.mark.parametrize("stop", ["rest", "zeno"])
def test_each_run_is_the_single_one(model, stop):
    count = 60
    q, postures = starts(count), rods(count)
    options = {"model": model, "stop": stop, "time": 0.25, "time_limit": 2.0}
    runs = sf.simulate_many(postures, q, (0.1, 0, 0), **options)
    again = sf.simulate_many(postures, q, (0.1, 0, 0), threads=1, **options)
    assert len(runs) == count
    for k in range(count):
        one = sf.simulate(postures[k], q[k], (0.1, 0, 0), **options)
        assert runs.outcome[k] == one.outcome
        for mine, single in (
            (runs.time, one.time),
            (runs.elapsed, one.elapsed),
            (runs.q, one.q),
            (runs.qdot, one.qdot),
            (runs.collisions, one.collisions),
        ):
            assert np.array_equal(mine[k], single)
        assert np.array_equal(runs.q[k], again.q[k])
        # Without a record a run does not know how much its end depends on its start.
        bare = sf.simulate(postures[k], q[k], (0.1, 0, 0), record=False, **options)
        assert runs.warned[k] == bool(bare.warnings)
        if one.zeno_points:
            zeno = one.zeno_points[0]
            assert runs.zeno_kind[k] == zeno.kind
            assert runs.zeno_contact[k] == (zeno.contact or 0)
            assert (runs.zeno_time[k], runs.zeno_elapsed[k]) == (
                zeno.time,
                zeno.elapsed,
            )
        else:
            assert runs.zeno_kind[k] == ""
            assert runs.zeno_contact[k] == 0
            assert math.isnan(runs.zeno_time[k])
    assert len(set(runs.zeno_kind)) > 1


@pytest.mark.parametrize("model", ["local", "full", "auto"])
def test_drops_without_friction_are_single_runs(model):
    """Bodies on two contacts, most of which come to rest on both: the ends of a batch have the bits of single runs."""
    rng = np.random.default_rng(66)
    ends = []
    for k in range(150):
        width, tilt = rng.uniform(0.2, 1.0), 0.3 * rng.random() * (k % 6 == 0)
        restitution = rng.choice([0.05, 0.1, 0.2, 0.9]) * np.ones(2)
        if k % 5 == 0:
            restitution[1] *= 0.5
        high = 0.2 * rng.random() * (k % 2)
        body = sf.Posture(
            mass=1,
            gyration_radius=rng.uniform(0.1, 0.6),
            center_of_mass=(0.0, high),
            restitution=0.0,
            contacts=[
                sf.Contact(point=(-width, 0), slope=-tilt, restitution=restitution[0]),
                sf.Contact(
                    point=(0.8 * width, 0), slope=tilt, restitution=restitution[1]
                ),
            ],
        )
        q = np.zeros((4, 3))
        q[:, 1] = rng.choice([0.01, 0.3], 4)
        q[:, 2] = rng.uniform(-0.5, 0.5, 4) * q[:, 1] / width
        qdot = np.zeros((4, 3)) if k % 4 else rng.normal(0, 0.1, (4, 3))
        # Without friction a body in a valley slides to and fro for ever.
        runs = sf.simulate_many(body, q, qdot, model=model, time_limit=20)
        for i in range(4):
            one = sf.simulate(body, q[i], qdot[i], model=model, time_limit=20)
            assert runs.outcome[i] == one.outcome
            assert (runs.elapsed[i], runs.collisions[i]) == (
                one.elapsed,
                one.collisions,
            )
            assert np.array_equal(runs.q[i], one.q)
            assert np.array_equal(runs.qdot[i], one.qdot)
            assert np.signbit(runs.q[i]).tolist() == np.signbit(one.q).tolist()
            kind = one.zeno_points[0].kind if one.zeno_points else ""
            assert runs.zeno_kind[i] == kind
            ends.append((one.outcome, kind))
    assert ends.count(("rest", "2-zeno")) > 100


def test_three_contacts_and_laws_with_friction():
    body = sf.Posture(
        mass=1,
        gyration_radius=0.3,
        center_of_mass=(0, 0.4),
        contacts=[sf.Contact(point=(x, 0), friction=0.5) for x in (-0.5, 0, 0.5)],
        restitution=0.3,
    )
    law = {"impact": "moreau", "simultaneous": "first-contact-first"}
    runs = sf.simulate_many(body, starts(5), (0, 0, 0), time_limit=1.0, **law)
    for k, q in enumerate(starts(5)):
        one = sf.simulate(body, q, (0, 0, 0), time_limit=1.0, **law)
        assert (runs.outcome[k], runs.elapsed[k]) == (one.outcome, one.elapsed)


def test_one_run_again_with_its_events():
    runs = sf.simulate_many(ROD, starts(7), (0, 0, 0))
    assert runs[-1].elapsed == runs.elapsed[6]
    assert len(runs[2].impacts) == runs.collisions[2] > 0
    with pytest.raises(IndexError, match="there are 7 runs"):
        runs[7]


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_shapes(threads):
    empty = sf.simulate_many(ROD, np.zeros((0, 3)), (0, 0, 0), threads=threads)
    assert len(empty) == 0
    assert empty.q.shape == (0, 3)
    assert empty.outcome.shape == (0,)
    one = sf.simulate_many(ROD, (0, 0.01, 0), (0, 0, 0), threads=threads)
    assert one.q.shape == (1, 3)
    same = sf.simulate_many([ROD] * 4, (0, 0.01, 0.001), (0, 0, 0), threads=threads)
    assert len(set(same.time)) == 1
    objects = sf.simulate_many(np.array([ROD] * 3, dtype=object), starts(3), (0, 0, 0))
    given = sf.simulate_many((ROD for _ in range(3)), starts(3), (0, 0, 0))
    assert np.array_equal(objects.q, given.q)
    fast = sf.simulate_many(ROD, (0, 0.01, 0), [(1, 0, 0), (2, 0, 0)], threads=threads)
    assert list(fast.outcome) == ["sliding", "sliding"]


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (
            {"q": [(0, 1, 0), (0, -1, 0)]},
            ValueError,
            r"contact 1 into the terrain.*run 1",
        ),
        ({"q": np.zeros((2, 4))}, ValueError, r"q = array of shape \[2, 4\]"),
        ({"q": np.zeros((2, 2, 3))}, ValueError, r"q = array of shape \[2, 2, 3\]"),
        (
            {"qdot": np.zeros((3, 3))},
            ValueError,
            r"qdot = \[3 rows\].*one for each of 2 runs",
        ),
        ({"posture": [ROD] * 3}, ValueError, r"q = \[2 rows\].*one for each of 3 runs"),
        ({"posture": 3}, TypeError, "a Posture or a sequence of Postures"),
        ({"posture": [ROD, None]}, TypeError, r"posture\[1\] = None .* a Posture"),
        (
            {"q": np.ma.array(np.zeros((2, 3)), mask=np.eye(2, 3))},
            TypeError,
            "q = .* without masked entries",
        ),
        ({"threads": 0}, ValueError, "threads = 0"),
        ({"model": "fast"}, ValueError, "model"),
        ({"qdot": [(0, 0, 0), (0, math.inf, 0)]}, ValueError, r"qdot.y = inf.*run 1"),
    ],
)
def test_wrong_input_is_named(change, error, message):
    told = {"posture": ROD, "q": [(0, 1, 0), (0, 2, 0)], "qdot": (0, 0, 0)} | change
    with pytest.raises(error, match=message):
        sf.simulate_many(**told)


def test_the_options_of_a_scene_are_taken():
    scene = sf.Scene(ROD, (0, 0.01, 0), (0, 0, 0), {"stop": "zeno"})
    assert scene.options["record"] is True
    runs = sf.simulate_many(scene.posture, [scene.q], scene.qdot, **scene.options)
    assert list(runs.outcome) == ["zeno"]
    assert runs[0].phases


@pytest.mark.parametrize(
    ("index", "error"),
    [
        (1, IndexError),
        (-2, IndexError),
        (10**30, IndexError),
        (True, TypeError),
        (0.0, TypeError),
        ("a", TypeError),
        (slice(1), TypeError),
    ],
)
def test_a_wrong_index_is_named(index, error):
    runs = sf.simulate_many(ROD, [(0, 0.01, 0)], (0, 0, 0))
    with pytest.raises(error, match=r"index = .* cannot be used"):
        runs[index]
    assert runs[np.int64(-1)].time == runs.time[0]
