"""Lists of bodies: the same answers as one by one, on any number of threads."""

import math
import pickle
import signal
import threading
import time

import numpy as np
import pytest
import standfast as sf

BOX = sf.Posture.box(1, 1, friction=0.5)
#: Its contact touches the ground at an end of its piece.
EDGE = sf.Posture(1, 0.5, (0, 1), [sf.Contact((0, 0), segment=(0, 6))], 0.1)


def posture(rng):
    feet = [
        sf.Contact(
            point=(x + rng.uniform(-0.3, 0.3), rng.uniform(-0.2, 0.2)),
            slope=rng.uniform(-0.6, 0.6),
            friction=rng.uniform(0, 1.2),
        )
        for x in np.linspace(-1, 1, rng.integers(1, 5))
    ]
    center = rng.uniform(-0.8, 0.8), rng.uniform(0.3, 1.5)
    return sf.Posture(
        1, rng.uniform(0.3, 1.5), center, feet, restitution=rng.uniform(0, 0.9)
    )


def mechanism(rng):
    """Feet on three to five coordinates."""
    dof, count = rng.integers(3, 6), rng.integers(1, 4)
    rows = rng.uniform(-1, 1, (count, 2, dof))
    forces = rng.uniform((-0.4, 0.5), (0.4, 1.5), (count, 2))
    load = -np.einsum("kij,ki->j", rows, forces)
    feet = [
        sf.ContactRows(normal=n, tangential=t, friction=rng.uniform(0.2, 0.9))
        for t, n in rows
    ]
    return sf.Mechanism(np.eye(dof), load, feet, restitution=rng.uniform(0, 0.9))


def bodies(count):
    rng = np.random.default_rng(7)
    return [(posture, mechanism)[rng.integers(2)](rng) for _ in range(count)]


def bits(verdict):
    """All that a verdict says. Its text has all digits of its numbers."""
    return str(verdict.to_dict())


MANY = bodies(500)


@pytest.fixture(scope="module")
def verdicts():
    return [sf.stability(body) for body in MANY]


@pytest.mark.parametrize("threads", [None, 1, 2, 7])
def test_verdicts_are_those_of_single_calls(verdicts, threads):
    found = sf.stability(MANY, threads=threads)
    assert type(found) is list
    assert [bits(v) for v in found] == [bits(v) for v in verdicts]
    for body, verdict in zip(MANY, found, strict=True):
        assert body in (verdict.posture, verdict.mechanism)


def test_the_random_bodies_have_verdicts_of_many_kinds(verdicts):
    assert {v.frictional_stability for v in verdicts} == {
        *("stable", "unstable", "undecided")
    }
    assert len({v.by for v in verdicts}) > 5


@pytest.mark.parametrize("threads", [None, 1, 3])
def test_modes_are_those_of_single_calls(threads):
    found = sf.contact_modes(tuple(MANY), threads=threads)
    assert found == [sf.contact_modes(body) for body in MANY]
    postures = [body for body in MANY if isinstance(body, sf.Posture)]
    loaded = {"wrench": (0.3, -1, 0.1), "method": "enumerate"}
    found = sf.contact_modes(postures, **loaded, threads=threads)
    assert found == [sf.contact_modes(body, **loaded) for body in postures]


@pytest.mark.parametrize("threads", [None, 1, 3])
def test_margins_are_those_of_single_calls(threads):
    found = sf.friction_margin(MANY, threads=threads)
    assert found.dtype == np.float64
    assert found.tolist() == [sf.friction_margin(body) for body in MANY]


@pytest.mark.parametrize("threads", [None, 1, 3])
def test_each_item_has_the_kicks_of_a_single_call(threads):
    options = {"trials": 3, "seed": 5, "jams": "impact", "width": 1e-6}
    found = sf.stability(MANY[:40], **options, threads=threads)
    single = [sf.stability(body, **options) for body in MANY[:40]]
    assert found == single
    assert [v.trials for v in found] == [v.trials for v in single]


def test_none_has_the_answer_none():
    assert sf.stability([None, BOX, None])[::2] == [None, None]
    assert sf.contact_modes([None, BOX])[0] is None
    np.testing.assert_array_equal(sf.friction_margin([BOX, None]), [1, math.nan])
    assert sf.stability([None]) == [None]
    with pytest.raises(TypeError, match=r"^posture = None cannot be used"):
        sf.stability(None)


def test_without_items_there_are_no_answers():
    for nothing in [], (), iter(()):
        assert sf.stability(nothing) == sf.contact_modes(nothing) == []
    assert sf.friction_margin([]).shape == (0,)
    for empty in np.empty((0, 3), object), np.array([]):
        assert sf.stability(empty, progress=True).shape == empty.shape
        assert sf.contact_modes(empty).dtype == object
        assert sf.friction_margin(empty).shape == empty.shape


def test_an_array_of_objects_has_an_array_of_its_shape():
    grid = np.empty((2, 3), object)
    grid[0], grid[1, :2] = BOX, MANY[0]
    found = sf.stability(grid)
    assert (found.shape, found.dtype, found[1, 2]) == ((2, 3), object, None)
    assert [v.posture or v.mechanism for v in found.flat[:5]] == [*grid.flat[:5]]
    assert sf.contact_modes(grid.T)[0, 0] == sf.contact_modes(BOX)
    squares = np.empty((2, 1), object)
    squares[0, 0] = BOX
    np.testing.assert_array_equal(sf.friction_margin(squares), [[1], [math.nan]])


def test_problems_of_modes_are_items_too():
    problem = sf.contact_modes(BOX).problem
    sliding = sf.MechanismProblem(sf.Mechanism.of_posture(BOX), sliding=[1, 1])
    items = [problem, sliding, BOX]
    assert sf.contact_modes(items) == [sf.contact_modes(item) for item in items]


def test_results_can_be_pickled():
    for found in sf.stability(MANY[:20], trials=2), sf.contact_modes(MANY[:20]):
        assert pickle.loads(pickle.dumps(found)) == found


@pytest.mark.parametrize("threads", [None, 1, 3])
def test_an_error_names_the_first_wrong_item(threads):
    with pytest.raises(
        ValueError, match=r"^contacts\.1\.point = .* \(at posture\[17\]\)$"
    ):
        sf.stability([*MANY[:17], EDGE, *MANY[:400], EDGE], threads=threads)
    grid = np.full((3, 4), BOX, object)
    grid[1, 2] = EDGE
    with pytest.raises(ValueError, match=r"\(at posture\[1, 2\]\)$"):
        sf.stability(grid, threads=threads)
    standing = [BOX, sf.Mechanism.of_posture(BOX)]
    with pytest.raises(ValueError, match=r"^wrench = .* \(at posture\[1\]\)$"):
        sf.contact_modes(standing, wrench=(1, 0, 0), threads=threads)


@pytest.mark.parametrize(
    "function", [sf.stability, sf.contact_modes, sf.friction_margin]
)
def test_what_is_no_body_is_named(function):
    for wrong, name in [
        ([BOX, 5], r"posture\[1\] = 5"),
        ([[BOX]], r"posture\[0\] = \[Posture"),
        (np.array([[BOX, "a"]], object), r"posture\[0, 1\] = 'a'"),
        (np.float64(3), r"posture = np\.float64"),
        ("box", "posture = 'box'"),
        ({BOX.mass: BOX}, r"posture = \{"),
        (7, "posture = 7"),
    ]:
        with pytest.raises(TypeError, match=f"^{name}.* cannot be used"):
            function(wrong)
    with pytest.raises(TypeError, match="None, True or False"):
        function([BOX], progress="x")
    with pytest.raises(ValueError, match=r"^threads = 0"):
        function([BOX], threads=0)


@pytest.mark.parametrize("threads", [None, 1])
def test_progress_counts_the_items(capsys, threads):
    items = [*MANY[:99], None]
    for function, given in [
        (sf.stability, items),
        (sf.contact_modes, items),
        (sf.friction_margin, [BOX] * 100),
    ]:
        function(given, progress=True, threads=threads)
        assert "100/100" in capsys.readouterr().err
        for quiet in None, False:
            function(given, progress=quiet, threads=threads)
            assert not capsys.readouterr().err


def test_a_list_goes_on_although_its_progress_cannot_be_shown(monkeypatch, capsys):
    class Broken:
        def update(self, count):
            raise OSError("no terminal")

        close = update

    monkeypatch.setattr("standfast.maps.bar", lambda *_: Broken())
    failed = []
    monkeypatch.setattr("sys.unraisablehook", failed.append)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Broken, "close", lambda self: None)
        assert sf.stability([BOX]) == [sf.stability(BOX)]
    assert [str(f.exc_value) for f in failed] == ["no terminal"]


@pytest.mark.parametrize("threads", [None, 1, 2])
def test_a_list_can_be_interrupted(threads):
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        sf.stability([BOX] * 10_000, trials=10_000, threads=threads)
    assert time.monotonic() - begin < 5.0
