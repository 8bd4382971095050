"""The Python interface: names, shapes, units, errors."""

import copy
import json
import math
import pickle
import re
import signal
import threading
import time
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import standfast as sf
from bodies import with_defaults
from checks import assert_copies, assert_named, assert_refused
from hypothesis import given, settings
from hypothesis import strategies as st

ROOT = Path(__file__).parents[2]
ROD = ROOT / "examples" / "clattering_rod.toml"
START = {"q": (0.0, 0.011, math.asin(0.002)), "qdot": (0.0, 0.0, 0.0)}


rod = with_defaults(
    sf.Posture.rod,
    half_length=0.5,
    gyration_radius=0.2,
    restitution=0.1,
    friction=0.0,
    gravity=9.81,
)
#: A posture in which every field differs from its default.
body = with_defaults(
    sf.Posture,
    mass=2.0,
    gyration_radius=0.4,
    center_of_mass=(0.1, 0.3),
    contacts=[
        sf.Contact(point=(-0.5, 0.1), slope=-0.2, friction=0.5, restitution=0.3),
        sf.Contact((0.75, 0.0), 0.1, 0.25, None, 0.125, (-1.0, math.inf)),
    ],
    restitution=0.2,
    gravity=1.62,
)
local = with_defaults(
    sf.LocalModel,
    gravity=(9.81, 9.81),
    psi=(0.7, 0.7),
    phi=(0.5, -0.5),
    restitution=0.1,
)


# Contacts and postures.


def test_defaults():
    contact = sf.Contact(point=(0.5, 0.0))
    assert (contact.slope, contact.friction, contact.restitution) == (0.0, 0.0, None)
    assert (contact.tangential_restitution, contact.segment) == (
        0.0,
        (-math.inf, math.inf),
    )


def test_fields_come_back():
    posture = body()
    assert (posture.mass, posture.gyration_radius, posture.center_of_mass) == (
        2.0,
        0.4,
        (0.1, 0.3),
    )
    assert (posture.restitution, posture.gravity) == (0.2, 1.62)
    first, second = posture.contacts
    assert (first.point, first.slope, first.friction, first.restitution) == (
        (-0.5, 0.1),
        -0.2,
        0.5,
        0.3,
    )
    assert (second.tangential_restitution, second.segment) == (0.125, (-1.0, math.inf))


def test_rod_is_the_posture_it_stands_for():
    ends = [sf.Contact(point=(x, 0.0), friction=0.5) for x in (-0.5, 0.5)]
    spelled = sf.Posture(
        mass=1.0,
        gyration_radius=0.2,
        center_of_mass=(0.0, 0.0),
        contacts=ends,
        restitution=0.1,
        gravity=9.81,
    )
    assert rod(friction=0.5) == spelled
    assert rod() != spelled


def test_couplings_of_the_uniform_rod():
    uniform = rod(gyration_radius=0.5 / math.sqrt(3))
    assert uniform.psi == pytest.approx((0.5, 0.5), rel=1e-15)
    assert uniform.phi == pytest.approx((1.5, -1.5), rel=1e-15)
    assert uniform.normal_gravity == (9.81, 9.81)


def test_gaps_and_rates_by_hand():
    gaps = rod().gaps(START["q"])
    np.testing.assert_allclose(gaps, [0.01, 0.012], rtol=0, atol=2e-18)
    rates = rod().gap_rates((0.0, 0.0, 0.0), (5.0, 1.0, 2.0))
    np.testing.assert_array_equal(rates, [0.0, 2.0])


def test_gaps_are_vectorised_over_leading_axes():
    posture, random = body(), np.random.default_rng(0)
    q, qdot = random.normal(size=(2, 4, 5, 3))
    gaps, rates = posture.gaps(q), posture.gap_rates(q, qdot)
    assert gaps.shape == rates.shape == (4, 5, 2)
    for index in np.ndindex(4, 5):
        np.testing.assert_array_equal(gaps[index], posture.gaps(q[index]))
        np.testing.assert_array_equal(
            rates[index], posture.gap_rates(q[index], qdot[index])
        )
    assert posture.gaps(q[0, 0]).shape == (2,)
    assert posture.gaps(np.empty((0, 3))).shape == (0, 2)


def test_local_model_of_a_posture():
    posture = body()
    model = posture.local()
    assert (model.psi, model.phi, model.gravity) == (
        posture.psi,
        posture.phi,
        posture.normal_gravity,
    )
    assert model.restitution == (0.3, 0.2)
    assert posture.local(q=(0, 0, 0)) == model
    assert posture.local(q=(0, 0, 0.1)) != model


def test_local_model_takes_one_restitution_or_two():
    assert local(restitution=0.1) == local(restitution=(0.1, 0.1))
    assert local(restitution=(0.1, 0.2)).restitution == (0.1, 0.2)


@pytest.mark.parametrize(
    "run",
    [
        sf.simulate(rod(), (0, 0.011, 0.002), (0, 0, 0), time=3.0, stop="zeno"),
        sf.simulate(rod(), (0, 0.011, 0.002), (0.1, 0, 0), record=False),
        local().simulate((0, 0.01), (0.1, -0.5), theta=0.1, omega=0.2, stop="zeno"),
    ],
    ids=["posture", "unrecorded", "local"],
)
def test_runs_are_pickled_as_what_was_asked(run):
    for other in (
        pickle.loads(pickle.dumps(run)),
        copy.copy(run),
        copy.deepcopy(run),
    ):
        assert other.to_dict() == run.to_dict()
    assert len(pickle.dumps(run)) < 1000


def parts():
    """What a run and a local model are asked for, of every kind."""
    feet = [sf.Contact(point=(x, 0), friction=0.2, segment=(-1, 1)) for x in (0, 1)]
    slide = sf.simulate(body(contacts=feet), (0, 0.1, 0), (1, 0, 0.5))
    reduced = local().simulate((0, 0.01), (0.1, -0.5))
    return [
        *slide.phases,
        *slide.zeno_points,
        *reduced.phases,
        *reduced.zeno_points,
        local().exponents((0, 0.3), (1, -1), 100),
        local(psi=(0.9, 0.9)).fate((0, 0.1), (0.1, -1.9)),
        local(psi=(0.22, 0.22), restitution=0.9).fate((0, 0.3), (1, -1), 100),
        sf.theory.self_similar(0.5, 0.9),
        sf.stability(rod(friction=0.5), trials=10, seed=3),
    ]


@pytest.mark.parametrize("value", parts(), ids=lambda value: type(value).__name__)
def test_parts_of_answers_are_pickled_and_copied(value):
    assert_copies(value)


def test_lists_of_phases_and_orbits_are_pickled():
    run = sf.simulate(rod(), **START)
    for values in (run.phases, run.zeno_points):
        assert values
        assert pickle.loads(pickle.dumps(values)) == values
    orbit = local(psi=(0.9, 0.9)).orbit((0, 0.3), (1, -1), 50)
    other = pickle.loads(pickle.dumps(orbit))
    np.testing.assert_array_equal(other.shapes, orbit.shapes)
    assert (other.end, len(other)) == (orbit.end, len(orbit))


@pytest.mark.parametrize("posture", [rod(), [rod(), rod()]], ids=["one", "two"])
def test_many_runs_are_pickled_as_what_was_asked(posture):
    starts = [(0, 0.011, 0.002), (0, 0.012, 0.003)]
    runs = sf.simulate_many(posture, starts, (0, 0, 0), model="full", stop="zeno")
    other = pickle.loads(pickle.dumps(runs))
    assert (other.time == runs.time).all()
    assert (other.q == runs.q).all()
    assert other[1].to_dict() == runs[1].to_dict()


@pytest.mark.parametrize(
    "value",
    [body().contacts[0], body().contacts[1], body(), rod(), local()],
    ids=lambda v: type(v).__name__,
)
def test_values_print_copy_and_compare(value):
    names = {
        "Contact": sf.Contact,
        "Posture": sf.Posture,
        "LocalModel": sf.LocalModel,
        "inf": math.inf,
    }
    assert eval(repr(value), names) == value
    assert_copies(value)
    with pytest.raises(AttributeError):
        value.restitution = 0.5


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: rod(restitution=1.5), ["restitution", "1.5"]),
        (lambda: rod(restitution=-0.1), ["restitution", "-0.1"]),
        (lambda: rod(restitution=math.nan), ["restitution"]),
        (lambda: rod(gyration_radius=0.0), ["gyration_radius", "0", "> 0"]),
        (lambda: rod(gravity=-1.0), ["gravity", "-1", ">= 0"]),
        (lambda: rod(half_length=math.inf), ["half_length", "inf"]),
        (lambda: rod(friction=-0.1), ["friction", "-0.1", ">= 0"]),
        (lambda: body(mass=0.0), ["mass", "0", "> 0"]),
        (lambda: body(center_of_mass=(math.nan, 0.0)), ["center_of_mass", "finite"]),
        (lambda: body(contacts=[]), ["contacts"]),
        (lambda: body(contacts=[sf.Contact((0, 0))]).psi, ["contacts", "2"]),
        (
            lambda: body(contacts=[sf.Contact((0, 0), slope=-math.pi)]),
            ["slope", "-pi < slope"],
        ),
        (lambda: body(contacts=[sf.Contact((0, 0), segment=(1.0, 2.0))]), ["segment"]),
        (lambda: local(psi=(2.0, 2.0)), ["psi"]),
        (lambda: local(gravity=(1.0, math.inf)), ["gravity", "inf"]),
        (lambda: local(restitution=(0.1, 1.5)), ["restitution", "1.5"]),
        (lambda: sf.simulate(rod(), (0, -0.1, 0), (0, 0, 0)), ["contact 1", "gap"]),
        (lambda: sf.simulate(rod(), (0, math.nan, 0), (0, 0, 0)), ["q"]),
        (
            lambda: sf.simulate(rod(gyration_radius=1e-5), **START),
            ["contacts.1.point", "gyration_radius", "1e4"],
        ),
        (lambda: sf.simulate(rod(), (0, 1, 0), (0, math.inf, 0)), ["qdot", "inf"]),
        (lambda: sf.simulate(rod(), **START, model="exact"), ["model", "exact"]),
        (lambda: sf.simulate(rod(), **START, impact="coulomb"), ["impact", "coulomb"]),
        (
            lambda: sf.simulate(
                rod(), **START, impact="poisson", simultaneous="newton"
            ),
            ["simultaneous"],
        ),
        (
            lambda: sf.simulate(rod(), **START, simultaneous="both"),
            ["simultaneous", "both"],
        ),
        (lambda: sf.simulate(rod(), **START, stop="never"), ["stop", "never"]),
        (lambda: sf.simulate(rod(), **START, stop="time"), ["time_limit"]),
        (
            lambda: sf.simulate(rod(), **START, time=1.0, time_limit=0.5),
            ["time_limit", "0.5"],
        ),
        (lambda: sf.simulate(rod(), **START, time=math.inf), ["time", "inf"]),
        (
            lambda: sf.simulate(rod(), **START, neighbourhood=-1.0),
            ["neighbourhood", "-1"],
        ),
        (lambda: local(psi=(1, 1)).simulate((1, 1), (0, 0)), ["psi.1 * psi.2", "1.0"]),
        (lambda: local().simulate((-1e-30, 1), (0, 0)), ["gaps.1 = -1e-30", ">= 0"]),
        (lambda: local().simulate((0, -1), (0, 0)), ["gaps.2 = -1.0", ">= 0"]),
        (lambda: local().simulate(gaps=(0.1, 0), rates=(0, math.nan)), ["rates"]),
    ],
)
def test_wrong_input_is_named(make, words):
    assert_named(make, words)


@pytest.mark.parametrize(
    "make",
    [
        lambda: sf.Contact(point=(0.0, 0.0, 0.0)),
        lambda: sf.Contact(point="ab"),
        lambda: sf.simulate(rod(), (0, 1), (0, 0, 0)),
        lambda: rod().gaps(np.zeros(2)),
        lambda: rod().gaps("abc"),
        lambda: sf.simulate(1.0, **START),
        lambda: rod(mass=1.0),
    ],
)
def test_wrong_shapes_and_types(make):
    with pytest.raises((TypeError, ValueError)):
        make()


def simulate(q=START["q"], qdot=START["qdot"], **options):
    return sf.simulate(rod(), q, qdot, **options)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: simulate(q=(0, 0.011)),
            "q = (0, 0.011) * 3 numbers are needed, not 2",
        ),
        (lambda: simulate(qdot=np.zeros(2)), "qdot = * 3 numbers * not 2"),
        (lambda: rod().local(q=(0, 0)), "q = (0, 0) * 3 numbers"),
        (lambda: sf.Scene(rod(), (0, 1), (0, 0, 0)), "q = (0, 1) * 3 numbers"),
        (lambda: local().simulate((0,), (0, 0)), "gaps = (0,) * 2 numbers"),
        (lambda: local().simulate((0, 1), (0, 0, 0)), "rates = (0, 0, 0) * 2 numbers"),
        (lambda: sf.Contact(point=range(10**9)), "point = range(0, 1000000000) * 2 n"),
        (lambda: sf.Contact((0, 0), segment=(1,)), "segment = (1,) * 2 numbers"),
        (lambda: body(center_of_mass=[0]), "center_of_mass = [0] * 2 numbers"),
        (lambda: local(psi=(1,)), "psi = (1,) * 2 numbers"),
        (lambda: local(phi=(1, 2, 3)), "phi = (1, 2, 3) * 2 numbers"),
        (lambda: local(gravity=()), "gravity = () * 2 numbers"),
        (lambda: local(restitution=(0.1,)), "restitution = (0.1,) * 2 numbers"),
        (lambda: rod().gap_rates((0, 0, 0), (0, 0)), "qdot = * shape"),
    ],
)
def test_a_wrong_length_is_named(make, words):
    assert_refused(make, ValueError, words)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: simulate(event_limit=-1), "event_limit = -1 * an integer from 0 to"),
        (lambda: simulate(event_limit=10**30), "event_limit = 1000* an integer from"),
        (lambda: simulate(event_limit=10**5000), "event_limit = * an integer from 0"),
        (lambda: rod(gyration_radius=10**400), "gyration_radius = inf * finite"),
        (lambda: simulate(q=(0, -(10**400), 0)), "q.y = -inf * finite"),
        (lambda: simulate(time=10**5000), "time = inf * finite"),
    ],
)
def test_a_huge_integer_is_named(make, words):
    assert_refused(make, ValueError, words)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: body(mass="1"), "mass = '1' * a number is needed"),
        (lambda: body(mass=None), "mass = None * a number"),
        (lambda: body(mass=True), "mass = True * a number"),
        (lambda: body(mass=np.True_), "mass = np.True_ * a number"),
        (lambda: body(mass=np.complex128(1)), "mass = * a number"),
        (lambda: body(mass=np.ones(1)), "mass = array([1.]) * a number"),
        (
            lambda: local(restitution="x"),
            "restitution = 'x' * a number * or one for each",
        ),
        (lambda: local(restitution=(0, "x")), "restitution = (0, 'x') * a number"),
        (lambda: simulate(q=None), "q = None * 3 numbers"),
        (lambda: simulate(q="abc"), "q = 'abc' * 3 numbers"),
        (lambda: simulate(q={0: 0, 1: 1, 2: 0}), "q = {0: 0, 1: 1, 2: 0} * 3 numbers"),
        (lambda: simulate(q=(0, True, 0)), "q = (0, True, 0) * 3 numbers"),
        (lambda: simulate(q=np.array([0, 1j, 0])), "q = array([* 3 numbers"),
        (lambda: simulate(q=np.ones((3, 1))), "q = array([[1.], [1.], [1.]]) * 3 n"),
        (lambda: simulate(time_limit="1"), "time_limit = '1' * a number"),
        (lambda: simulate(event_limit=1.5), "event_limit = 1.5 * an integer"),
        (lambda: simulate(event_limit=True), "event_limit = True * an integer"),
        (lambda: simulate(record=0), "record = 0 * True or False"),
        (lambda: simulate(stop=None), "stop = None * a string"),
        (lambda: scene().simulate(time="1"), "time = '1' * a number"),
        (lambda: scene().simulate(record=0), "record = 0 * True or False"),
        (lambda: scene().simulate(model=None), "model = None * a string"),
        (lambda: rod().gaps(None), "q = None * numbers"),
        (lambda: rod().gaps([[0, 0], [0]]), "q = [[0, 0], [0]] * numbers"),
        (lambda: rod().gaps(np.zeros(3, complex)), "q = * numbers"),
    ],
)
def test_a_wrong_type_is_named(make, words):
    assert_refused(make, TypeError, words)


@pytest.mark.parametrize("t", ["0.01", None, True, 0.01 + 0j, [0.01, None], object()])
def test_times_are_numbers(run, t):
    for ask in (run.at, run.gaps_at, run.gap_rates_at, run.energy):
        assert_refused(lambda ask=ask: ask(t), TypeError, "t = * numbers")


@pytest.mark.parametrize("n", [-1, 1, 10**12, 10**30])
def test_a_wrong_number_of_samples_is_named(run, n):
    assert_refused(lambda: run.sample(n), ValueError, f"n = {n} * from 2 to 10000000 *")


def test_long_words_are_shortened():
    x = "x" * 100_000
    assert_refused(lambda: simulate(model=x), ValueError, 'model = "xxx*… cannot be')
    assert_refused(lambda: body(mass=x), TypeError, "mass = 'xxx*… cannot be")
    assert_refused(lambda: scene().simulate(**{x: 1}), TypeError, "xxx*… = 1 cannot be")


def test_every_kind_of_real_number_is_taken():
    for two in (
        2,
        2.0,
        np.float32(2),
        np.int64(2),
        np.array(2),
        Fraction(2),
        Decimal(2),
    ):
        assert body(mass=two).mass == 2.0
        assert local(phi=(0, two)).phi == (0.0, 2.0)
        assert rod().gaps([0, two, 0]).tolist() == [2.0, 2.0]
    assert local(restitution=np.array([0.1, 0.2])).restitution == (0.1, 0.2)


def test_a_start_within_rounding_of_the_terrain_is_taken_as_touching():
    run = sf.simulate(rod(), (0, -1e-14, 0), (0, 0, 0))
    assert any("contact 1" in warning for warning in run.warnings)
    assert run.outcome == "rest"


# Runs.


@pytest.fixture(scope="module")
def run():
    return sf.simulate(rod(), **START, model="full")


def test_outcome_of_the_rod(run):
    assert run.outcome == "rest"
    assert (run.model, run.posture) == ("full", rod())
    assert run.model_reason
    assert run.time == run.elapsed == run.zeno_points[0].time
    assert run.q.shape == run.qdot.shape == (3,)
    np.testing.assert_array_equal(run.qdot, 0.0)
    np.testing.assert_array_equal(run.gaps, 0.0)
    np.testing.assert_array_equal(run.rates, 0.0)
    assert run.theta == run.q[2]
    assert run.omega == run.qdot[2]


def test_impacts_are_an_array(run):
    impacts = run.impacts
    assert impacts.dtype.names == (
        *(
            "time",
            "elapsed",
            "contact",
            "index",
            "rates_before",
            "rates_after",
            "impulse",
        ),
    )
    assert (
        impacts["rates_before"].shape
        == impacts["rates_after"].shape
        == (len(impacts), 2)
    )
    assert impacts["impulse"].shape == (len(impacts), 2)
    np.testing.assert_array_equal(impacts["contact"], impacts["index"] + 1)
    assert (np.diff(impacts["time"]) >= 0).all()
    for impact in impacts:
        i = impact["index"]
        before, after = impact["rates_before"], impact["rates_after"]
        assert before[i] < 0.0
        assert after[i] == pytest.approx(-0.1 * before[i], rel=1e-15)
        # (tangential, normal): D_ii = 1 + b²/ρ², b the arm of this moment.
        q, _ = run.at(impact["time"])
        inertia = 1 + (0.5 * math.cos(q[2]) / 0.2) ** 2
        assert impact["impulse"] == pytest.approx(
            [0.0, -1.1 * before[i] / inertia], rel=1e-12
        )


def test_zeno_point_of_the_rod(run):
    (zeno,) = run.zeno_points
    assert (zeno.kind, zeno.contacts, zeno.contact) == ("2-zeno", (1, 2), None)
    assert (zeno.method, zeno.certified) == ("clatter", True)
    assert zeno.first_summed == len(run.impacts)
    assert zeno.time == zeno.elapsed
    assert 0.0 <= zeno.time_error <= 1e-14 * zeno.time  # with what rounding grows to
    assert zeno.q.shape == zeno.qdot.shape == (3,)
    np.testing.assert_array_equal(zeno.gaps, 0.0)
    np.testing.assert_array_equal(zeno.gap_rates, 0.0)


def test_stop_at_the_first_zeno_point():
    stopped = sf.simulate(rod(friction=0.5), **START, model="full", stop="zeno")
    assert stopped.outcome == "zeno"
    assert len(stopped.zeno_points) == 1
    assert stopped.time == stopped.zeno_points[0].time
    np.testing.assert_array_equal(stopped.q, stopped.zeno_points[0].q)


def test_hold_on_until_the_time_limit():
    held = sf.simulate(rod(), **START, stop="time", time_limit=1.0)
    assert (held.outcome, held.time) == ("time-limit", 1.0)
    np.testing.assert_array_equal(held.gaps, 0.0)
    early = sf.simulate(rod(), **START, stop="time", time_limit=0.01)
    assert (early.outcome, early.time, len(early.impacts)) == ("time-limit", 0.01, 0)
    assert early.q[1] == pytest.approx(0.011 - 0.5 * 9.81 * 0.01**2, rel=1e-15)


def test_a_time_limit_of_zero_has_any_sign():
    for zero in (0.0, -0.0):
        run = sf.simulate(rod(), **START, time_limit=zero)
        assert (run.outcome, str(run.time)) == ("time-limit", "0.0")


def test_event_limit():
    cut = sf.simulate(rod(), **START, model="full", event_limit=3)
    assert cut.outcome == "event-limit"
    assert len(cut.impacts) <= 3


def test_a_late_start_keeps_elapsed_times(run):
    late = sf.simulate(rod(), **START, model="full", time=1000.0)
    assert late.elapsed == run.elapsed
    assert late.time == 1000.0 + run.elapsed
    np.testing.assert_array_equal(late.impacts["elapsed"], run.impacts["elapsed"])
    np.testing.assert_array_equal(late.q, run.q)


def test_phases_cover_the_run(run):
    phases = run.phases
    assert phases
    assert phases[0].start == 0.0
    assert phases[-1].end == run.time
    for one, following in pairwise(phases):
        assert one.end == following.start
    assert phases[0].mode == "SS"


def test_at_any_time(run):
    q, qdot = run.at(0.0)
    np.testing.assert_array_equal(q, START["q"])
    np.testing.assert_array_equal(qdot, 0.0)
    t = 0.02
    q, qdot = run.at(t)
    assert q.shape == qdot.shape == (3,)
    np.testing.assert_allclose(
        q, [0.0, 0.011 - 0.5 * 9.81 * t**2, math.asin(0.002)], rtol=1e-15
    )
    np.testing.assert_allclose(qdot, [0.0, -9.81 * t, 0.0], rtol=1e-15)
    times = np.linspace(0.0, run.time, 7)
    q, qdot = run.at(times)
    assert q.shape == qdot.shape == (7, 3)
    gaps, rates = run.gaps_at(times), run.gap_rates_at(times)
    assert gaps.shape == rates.shape == (7, 2)
    np.testing.assert_allclose(gaps, run.posture.gaps(q), atol=1e-15)
    for k, moment in enumerate(times):
        np.testing.assert_array_equal(q[k], run.at(moment)[0])
    np.testing.assert_array_equal(run.at(run.time)[0], run.q)


@pytest.mark.parametrize("t", [-1e-9, math.nan])
def test_times_outside_the_run(run, t):
    with pytest.raises(ValueError, match=r"t = \S+ cannot be used: from 0\.0 on"):
        run.at(t)


def test_after_its_end_a_body_at_rest_is_at_rest_and_another_one_is_not(run):
    assert run.outcome == "rest"
    for t in (1.0, 1e9, math.inf):
        for one, end in zip(run.at(t), run.at(run.time), strict=True):
            np.testing.assert_array_equal(one, end)
        assert not run.at(t)[1].any()
        np.testing.assert_array_equal(run.gaps_at(t), run.gaps_at(run.time))
        np.testing.assert_array_equal(run.forces_at(t), run.forces_at(run.time))
    flies = sf.simulate(run.posture, (0, 5, 0), stop="time", time_limit=0.1)
    with pytest.raises(ValueError, match=r"t = 0\.2 cannot be used: from 0\.0 to 0\.1"):
        flies.at(0.2)


def test_a_closed_ring_is_the_same_polygon():
    ring = [(0, 0), (2, 0), (2, 1), (0, 0)]
    once, closed = sf.Posture.polygon(ring[:-1]), sf.Posture.polygon(ring)
    assert once == closed
    feet = [sf.Contact(point) for point in ring[:2]]
    body = sf.Posture(1, 1, (1, 0.5), feet, 0, outline=ring)
    assert body.outline == ring[:-1]
    with pytest.raises(ValueError, match=r"edges 1 and 2 meet"):
        sf.Posture.polygon([(0, 0), (1, 0), (0, 0)])


def test_a_verdict_names_a_contact_that_is_a_little_above_the_ground():
    corners = [(0, 0), (1, 1e-11), (1, 1), (0, 1)]
    floor = [(-3, 0), (3, 0)]
    body = sf.Posture.polygon(corners, friction=0.5, terrain=floor)
    text = "contact 2         is 1e-11 m above the ground: almost on it"
    assert text in str(sf.stability(body))
    level = [(x, round(y)) for x, y in corners]
    flat = sf.Posture.polygon(level, friction=0.5, terrain=floor)
    assert "almost" not in str(sf.stability(flat))


def test_a_body_starts_in_its_posture_at_rest():
    box = sf.Posture.box(1, 1, friction=0.5)
    run = sf.simulate(box)
    assert (run.outcome, run.time, *run.q) == ("rest", 0, 0, 0, 0)
    assert sf.Scene(box) == sf.Scene(box, (0, 0, 0), (0, 0, 0))
    mechanism = sf.Mechanism.of_posture(box)
    assert sf.simulate(mechanism).outcome == "rest"
    with pytest.raises(TypeError, match="one Posture or one Mechanism is needed"):
        sf.simulate([box, box])


def test_sample(run):
    t, q, qdot = run.sample(101)
    assert (t.shape, q.shape, qdot.shape) == ((101,), (101, 3), (101, 3))
    assert (t[0], t[-1]) == (0.0, run.time)
    assert (np.diff(t) >= 0).all()
    np.testing.assert_array_equal(q, run.at(t)[0])


def test_energy(run):
    assert run.energy(0.0) == pytest.approx(9.81 * 0.011, rel=1e-15)
    energy = run.energy(run.sample(500)[0])
    assert energy.shape == (500,)
    assert np.diff(energy).max() <= 1e-15


def test_without_a_record():
    bare = sf.simulate(rod(), **START, record=False)
    assert bare.outcome == "rest"
    for ask in (lambda: bare.at(0.0), lambda: bare.energy(0.0), lambda: bare.sample(3)):
        with pytest.raises(ValueError, match="record"):
            ask()


def test_a_run_of_a_local_model():
    done = local().simulate(
        gaps=(0.0, 0.01), rates=(0.1, -0.5), theta=0.25, omega=0.5, stop="zeno"
    )
    assert (done.q, done.qdot, done.posture, done.model) == (None, None, None, "local")
    zeno = done.zeno_points[0]
    assert (zeno.q, zeno.qdot) == (None, None)
    assert done.gaps.shape == done.rates.shape == (2,)
    assert isinstance(done.theta, float)
    gaps, rates = done.gaps_at(0.0), done.gap_rates_at(0.0)
    np.testing.assert_array_equal(gaps, [0.0, 0.01])
    np.testing.assert_array_equal(rates, [0.1, -0.5])


def test_runs_to_json(run, tmp_path):
    path = tmp_path / "run.json"
    run.to_json(path)
    told = run.to_dict()
    assert json.loads(path.read_text(encoding="utf-8")) == told
    assert told["outcome"] == "rest"
    assert told["time"] == run.time
    assert len(told["impacts"]) == len(run.impacts)
    assert told["zeno_points"][0]["kind"] == "2-zeno"
    json.dumps(told, allow_nan=False)


def test_repr_of_a_run(run):
    text = repr(run)
    assert "rest" in text
    assert "2-zeno" in text


def test_simulate_agrees_with_its_scene(run):
    scene = sf.load(ROD)
    assert scene.posture == rod()
    other = scene.simulate()
    np.testing.assert_array_equal(other.impacts, run.impacts)
    assert scene.simulate(stop="zeno").outcome == "zeno"
    with pytest.raises((TypeError, ValueError), match="colour"):
        scene.simulate(colour="red")


# Scenes and files.


def scene():
    return sf.Scene(
        body(), (0.1, 0.2, 0.3), (1.0, 2.0, 3.0), {"stop": "zeno", "neighbourhood": 5.0}
    )


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_scenes_round_trip(tmp_path, suffix):
    path = tmp_path / f"scene.{suffix}"
    first = scene()
    first.save(path)
    second = sf.load(path)
    assert second == first
    assert second.posture == first.posture
    np.testing.assert_array_equal(second.q, first.q)
    np.testing.assert_array_equal(second.qdot, first.qdot)
    assert second.options == first.options
    assert pickle.loads(pickle.dumps(first)) == first


number = st.floats(-1e150, 1e150)
positive = st.floats(min_value=1e-3, max_value=1e3)


@settings(max_examples=200, deadline=None)
@given(
    positive,
    st.tuples(number, number, number),
    st.tuples(number, number, number),
    st.just(0.0) | st.floats(1e-60, 1.0, exclude_max=True),
)
def test_scenes_round_trip_to_the_bit(tmp_path_factory, mass, q, qdot, e):
    first = sf.Scene(body(mass=mass, restitution=e), q, qdot)
    for suffix in ("toml", "json"):
        path = tmp_path_factory.getbasetemp() / f"scene.{suffix}"
        first.save(path)
        second = sf.load(path)
        assert second.posture.mass == mass
        assert second.posture.restitution == e
        assert [x.hex() for x in second.q] == [float(x).hex() for x in q]
        assert [x.hex() for x in second.qdot] == [float(x).hex() for x in qdot]


def test_the_published_schema_holds():
    published = json.loads(
        (ROOT / "docs" / "scene.schema.json").read_text(encoding="utf-8")
    )
    assert published == json.loads(sf.schema())
    jsonschema.Draft202012Validator.check_schema(published)
    validator = jsonschema.Draft202012Validator(published)
    written = json.loads(scene().to_json())
    validator.validate(written)
    assert not validator.is_valid(written | {"colour": "red"})
    assert not validator.is_valid({k: v for k, v in written.items() if k != "body"})


def test_infinities_in_json_are_strings(tmp_path):
    path = tmp_path / "scene.json"
    scene().save(path)
    text = path.read_text(encoding="utf-8")
    assert '"inf"' in text
    json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_a_byte_order_mark_is_skipped(tmp_path, suffix):
    path = tmp_path / f"scene.{suffix}"
    scene().save(path)
    path.write_text(path.read_text(encoding="utf-8"), encoding="utf-8-sig")
    assert sf.load(path) == scene()
    path.write_text(path.read_text(encoding="utf-8-sig"), encoding="utf-16")
    with pytest.raises(ValueError, match="UTF-8"):
        sf.load(path)


def test_an_empty_path_is_quoted():
    for use in (sf.load, scene().save):
        with pytest.raises(FileNotFoundError, match="No such file or directory: ''"):
            use("")


def test_wrong_json_names_the_key(tmp_path):
    path = tmp_path / "scene.json"
    text = scene().to_json()
    for old, new, words in [
        ('"mass": 2.0', '"mass": "2"', 'mass: * string "2", expected a number'),
        (
            '"event_limit": 1000000',
            '"event_limit": -1',
            "event_limit: * an integer >= 0",
        ),
        ('"record": true', '"record" : 0', "record: * true or false"),
        ('"stop": "zeno"', '"colour": 0', "* unknown field `colour`"),
    ]:
        assert old in text
        path.write_text(text.replace(old, new), encoding="utf-8")
        message = f"{path}: line *, column *{words}"
        with pytest.raises(ValueError, match="line") as error:
            sf.load(path)
        pattern = ".*".join(re.escape(word) for word in message.split("*"))
        assert re.match(pattern, str(error.value)), error.value


# Long runs.


def endless(**options):
    """A body that slides to and fro in a V for ever."""
    contacts = [sf.Contact(point=(x, 0.0), slope=0.35 * x) for x in (-1.0, 1.0)]
    posture = body(
        contacts=contacts,
        gyration_radius=0.5,
        center_of_mass=(0.0, 0.2),
        restitution=0.05,
    )
    options = {
        "stop": "time",
        "time_limit": 1e12,
        "event_limit": 10**12,
        "record": False,
    } | options
    return sf.simulate(posture, (0.001, 0.01, 0.0), (0, 0, 0), model="full", **options)


def test_a_long_run_can_be_interrupted():
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        endless()
    assert time.monotonic() - begin < 5.0


def test_a_run_lets_other_threads_go_on():
    count, done = 0, threading.Event()

    def work():
        endless(event_limit=300_000)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        count += 1
        time.sleep(0.0005)
    thread.join()
    assert count > 3


def test_phases_count_the_impacts_inside_them():
    rod = sf.Posture.rod(
        half_length=0.5, gyration_radius=0.2, restitution=0.3, friction=0.4
    )
    run = sf.simulate(rod, q=(0, 0.2, 0.3), qdot=(0.5, 0, 2.0), model="full")
    times = run.impacts["time"]
    inside = [int(((times > p.start) & (times < p.end)).sum()) for p in run.phases]
    assert [phase.impacts for phase in run.phases] == inside
    assert [phase["impacts"] for phase in run.to_dict()["phases"]] == inside
    assert max(inside) > 3
    assert pickle.loads(pickle.dumps(run.phases)) == run.phases
    assert f"impacts={inside[0]})" in repr(run.phases[0])


def unaligned(values):
    """The same numbers at a memory address that is not a multiple of their size."""
    values = np.asarray(values, float)
    array = np.frombuffer(b"." + values.tobytes(), np.uint8)[1:].view(float)
    assert not array.flags.aligned
    return array.reshape(values.shape)


def test_arrays_may_be_unaligned():
    body, q = rod(), np.array([[0, 0.011, 0.002], [0, 0.012, -0.001]])
    assert (body.gaps(unaligned(q)) == body.gaps(q)).all()
    assert (body.gap_rates(unaligned(q), unaligned(q)) == body.gap_rates(q, q)).all()
    runs = [
        sf.simulate_many(body, states, (0, 0, 0), stop="zeno")
        for states in (q, unaligned(q))
    ]
    assert (runs[0].zeno_time == runs[1].zeno_time).all()
    values = [0.1, 0.2, 0.3]
    maps = [
        sf.sweep(body, {"restitution": axis}, "coupling")
        for axis in (values, unaligned(values))
    ]
    assert maps[0].identical(maps[1])
