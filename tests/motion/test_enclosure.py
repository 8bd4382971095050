"""Enclosures of the local model compared with plain summation in 60 digits: impact after impact until flights are below 1e-45
of the time. STANDFAST_ENCLOSURES sets the number of random cases of each kind (100)."""

import collections
import json
import math
import os
import pickle
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path

import numpy as np
import oracle
import pytest
import standfast as sf
from bodies import with_defaults
from decimals import cos_sin
from mpmath import mp, mpf
from oracle_inputs import (
    draw_flight,
    draw_full,
    draw_local,
    draw_restitution,
    draw_spinning,
    simulate_full,
)

CASES = int(os.environ.get("STANDFAST_ENCLOSURES", "100"))
SEED = 1972
DIGITS = 60
#: Flights, relative to the time elapsed, and speeds, relative to those of the start, at which a sum ends: later ones are
#: shorter by a factor bounded away from one.
NOTHING = Decimal(10) ** -45
#: Number of impacts after which a sum is abandoned.
MOST = 20_000
NEVER = "no contact lands again"
#: Contacts of a Zeno point.
ZENO = [(1,), (2,), (1, 2)]


@pytest.fixture(autouse=True)
def digits():
    """Digits of decimal numbers."""
    with localcontext(prec=DIGITS):
        yield


def summed(v):
    """(times of the impacts, their contacts, whether a contact lands again), by plain summation; None if it does not end."""
    g, psi, e, h, u = ([Decimal(x) for x in v[name]] for name in ("g", "psi", "e", "h", "u"))  # fmt: skip
    fall = (2 * max(abs(a * b) for a, b in zip(g, h, strict=True))).sqrt()
    t, times, contacts, fastest = Decimal(0), [], [], max(map(abs, u)) + fall
    while len(times) < MOST:
        flights = [_touchdown(h[i], u[i], g[i]) for i in (0, 1)]
        dt = min(flights)
        if dt == math.inf:
            return times, contacts, False
        i = flights.index(dt)
        t += dt
        h = [h[j] + dt * (u[j] - g[j] * dt / 2) for j in (0, 1)]
        u = [u[j] - g[j] * dt for j in (0, 1)]
        h[i] = Decimal(0)
        kick = -(1 + e[i]) * u[i]
        u[i], u[1 - i] = -e[i] * u[i], u[1 - i] - psi[i] * kick
        times.append(t)
        contacts.append(i + 1)
        # Flights of zero duration, in a corner, end by their speeds.
        if 0 < dt <= NOTHING * t or max(map(abs, u)) <= NOTHING * fastest:
            return times, contacts, True
    return None


def _touchdown(h, u, g):
    """The first root t > 0 of h + ut − gt²/2 with h ≥ 0, or 0 if the contact is on the ground and moves into it."""
    square = u * u + 2 * g * h
    if square < 0 or (u >= 0 and g <= 0):
        return Decimal("Infinity")
    root = square.sqrt()
    return 2 * h / (root - u) if u < 0 else (u + root) / g


def case(v):
    """A case as the argument of `summed`."""
    pair = lambda name: (v[f"{name}1"], v[f"{name}2"])  # noqa: E731
    return {name: pair(name) for name in ("g", "psi", "h", "u")} | {"e": (v["e"],) * 2}


def enclosed(v, **options):
    model = sf.LocalModel(gravity=v["g"], psi=v["psi"], phi=(0, 0), restitution=v["e"])
    options = {"stop": "zeno", "certify": True} | options
    return model.simulate(gaps=v["h"], rates=v["u"], **options).enclosure


def holds(low, high, time):
    return low <= high and Fraction(low) <= Fraction(time) <= Fraction(high)


def check(v):
    """The enclosure of a case, after a check of all its statements; None if the sum has no end."""
    truth, enclosure = summed(v), enclosed(v)
    if truth is None:
        return None
    times, contacts, lands = truth
    impacts = enclosure.impacts
    # A sum ends where flights are too short for it: impacts may follow, in the enclosure too.
    assert lands or len(impacts) <= len(times), v
    for name in ("low", "high"):
        assert all(np.diff(impacts[name]) >= 0), v
    for impact, time, contact in zip(impacts, times, contacts, strict=False):
        assert impact["contact"] == contact, v
        assert holds(impact["low"], impact["high"], time), (v, impact, time)
    if enclosure.reason == NEVER:
        assert (len(impacts), lands) == (len(times), False), v
    if enclosure.zeno is not None:
        assert lands, v
        assert holds(*enclosure.zeno, times[-1]), (v, enclosure, times[-1])
        last = tuple(sorted(set(contacts[-5:])))
        assert enclosure.contacts == last, v
    else:
        assert enclosure.reason
    return enclosure


def width(enclosure):
    low, high = enclosure.zeno
    return (high - low) / high


def test_inside_the_bound_of_clattering(record_property):
    """Condition [Or & Rimon 2008, eq. 10] holds by 2 % or more. All Zeno points are then enclosed, in intervals of a
    few ulp."""
    rng = np.random.default_rng(SEED)
    widths = []
    for _ in range(CASES):
        enclosure = check(case(draw_local(rng)))
        assert enclosure is not None
        assert enclosure.reason is None
        widths.append(width(enclosure))
    text = f"{CASES} enclosures, widths: median {np.median(widths):.1e}, largest {max(widths):.1e} of the time"
    print(f"\n{text}")
    record_property("widths", text)
    assert max(widths) <= 1e-14
    assert np.median(widths) <= 1e-15


def draw_any(rng):
    """Couplings of either sign, unequal restitutions, equally likely outside and inside the bound."""
    e = (draw_restitution(rng), draw_restitution(rng))
    psi, skew = rng.uniform(-1, 1), math.exp(rng.uniform(-1.5, 1.5))
    g, h, u, _ = draw_flight(rng)
    return {"g": g, "psi": (psi * skew, psi / skew), "e": e, "h": h, "u": u}


def test_anywhere(record_property):
    """For any parameters all statements are true, and a reason is given if nothing further is certain."""
    rng = np.random.default_rng(SEED)
    found = [check(draw_any(rng)) for _ in range(CASES)]
    summable = [enclosure for enclosure in found if enclosure is not None]
    zeno = [enclosure for enclosure in summable if enclosure.zeno is not None]
    narrow = sum(width(enclosure) <= 1e-12 for enclosure in zeno)
    text = f"{CASES} cases, {len(summable)} with an end: {len(zeno)} Zeno points enclosed, {narrow} of them to 1e-12"
    print(f"\n{text}")
    record_property("anywhere", text)
    assert len(summable) >= 0.9 * CASES
    assert len(zeno) >= 0.8 * len(summable)
    assert narrow >= 0.9 * len(zeno)


def test_gravity_of_either_sign(record_property):
    """Gravity that presses a contact to its ground, pulls it off, or neither."""
    rng = np.random.default_rng(SEED)
    ends, pulls = collections.Counter(), collections.Counter()
    for _ in range(CASES):
        v = draw_any(rng)
        signs = [int(sign) for sign in rng.choice([-1, 0, 1], 2)]
        v["g"] = [sign * g for sign, g in zip(signs, v["g"], strict=True)]
        if rng.random() < 0.2:
            v["h"][rng.integers(2)] = 0.0
        enclosure = check(v)
        if enclosure is not None:
            end = enclosure.reason or enclosure.contacts
            ends[end] += 1
            pulls[min(signs), max(signs)] += 1
    text = f"{CASES} cases: {dict(ends)}, signs of gravity: {dict(pulls)}"
    print(f"\n{text}")
    record_property("ends", text)
    assert len(pulls) == 6
    assert ends[NEVER] >= 0.3 * CASES
    assert sum(ends[end] for end in ZENO) >= 0.3 * CASES
    assert sum(ends[end] for end in (NEVER, *ZENO)) >= 0.9 * CASES


@pytest.mark.parametrize("slope", [math.pi, math.pi / 2, -math.pi / 2, *np.linspace(-3, 3, 13)])  # fmt: skip
def test_one_contact_on_any_side(slope):
    """Ground, walls and ceilings: impacts of a ball at h = 0.3 m, and its Zeno point, in 60 digits."""
    cos, sin = cos_sin(Decimal(slope))
    exact = {math.pi: (-1, 0), math.pi / 2: (0, 1), -math.pi / 2: (0, -1)}
    cos, sin = map(Decimal, exact.get(slope, (cos, sin)))
    body = sf.Posture(1.0, 0.3, (0.0, 0.0), [sf.Contact((0.0, 0.0), slope=slope)], 0.5, 9.81)  # fmt: skip
    for speed in (-3.0, -1.0, 0.0, 1.0):
        q, qdot = ([float(k * n) for n in (-sin, cos)] for k in (Decimal("0.3"), Decimal(speed)))  # fmt: skip
        run = sf.simulate(body, (*q, 0), (*qdot, 0), model="local", certify=True, time_limit=1e6, stop="zeno")  # fmt: skip
        h, u = (cos * Decimal(y) - sin * Decimal(x) for x, y in (q, qdot))
        g, e = cos * Decimal(body.gravity), Decimal(body.restitution)
        time = _touchdown(h, u, g)
        impacts, zeno = run.enclosure.impacts, run.enclosure.zeno
        assert len(impacts) == (time < math.inf)
        if time < math.inf:
            assert holds(impacts["low"][0], impacts["high"][0], time)
        if g > 0:
            bounces = 2 * e * (u * u + 2 * g * h).sqrt() / (g * (1 - e))
            assert holds(*zeno, time + bounces)
        else:
            assert (zeno, run.enclosure.reason) == (None, NEVER)


def test_a_contact_that_gravity_pulls_off_does_not_bounce():
    """One impact of a contact below an overhang, which then leaves."""
    contact = sf.Contact((0.4395002850928258, 0.8413566258744476), slope=1.757934141167694)  # fmt: skip
    body = sf.Posture(1.0, 0.6335982494460324, (-0.274994547145047, 0.8822366234529742), [contact], 0.2513139736084264)  # fmt: skip
    q = (-0.17685205293876693, -0.033487539869622586, -0.031156385677099305)
    qdot = (1.045286511047693, -0.28203352577242424, -0.3581684060580372)
    run = sf.simulate(body, q, qdot, model="local", certify=True, time_limit=3.0)
    (impact,) = run.enclosure.impacts
    assert impact["low"] <= run.impacts[0]["time"] <= impact["high"]
    assert (run.enclosure.zeno, run.enclosure.reason) == (None, NEVER)


def test_unequal_restitutions_clatter():
    """Well inside Λ³ > e_1e_2, with Λ the larger eigenvalue of two impacts, motions with unequal restitutions are
    enclosed as narrowly as those with equal ones."""
    rng = np.random.default_rng(SEED)
    kinds = 0
    for _ in range(CASES // 4):
        v = draw_any(rng) | {"e": (rng.uniform(0.01, 0.2), rng.uniform(0.01, 0.2))}
        skew = math.exp(rng.uniform(-1, 1))
        psi = rng.uniform(0.85, 0.99)
        v["psi"] = (psi * skew, psi / skew)
        enclosure = check(v)
        kinds += enclosure.contacts == (1, 2)
        assert width(enclosure) <= 1e-14, v
    assert kinds >= CASES // 10


def test_the_reference():
    """All of its cases have an enclosed Zeno point, except one below the bound, for which no theorem proves endless
    alternation."""
    path = Path(__file__).parents[1] / "data" / "reference_local.json"
    for known in json.loads(path.read_text(encoding="utf-8"))["cases"]:
        inputs = {name: float.fromhex(x["hex"]) for name, x in known["inputs"].items()}
        zeno, v = known["expected"]["zeno"], case(inputs)
        enclosure = enclosed(v)
        assert (enclosure.zeno is not None) == zeno["certified"]
        if enclosure.zeno is not None:
            assert holds(*enclosure.zeno, zeno["time"])
        for impact, collision in zip(
            enclosure.impacts, known["expected"]["collisions"], strict=False
        ):
            assert impact["contact"] == collision["contact"]
            assert holds(impact["low"], impact["high"], collision["t"])


model = with_defaults(
    sf.LocalModel, gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.1
)


def of(model, gaps, rates, **options):
    options = {"stop": "zeno", "certify": True} | options
    return model.simulate(gaps=gaps, rates=rates, **options).enclosure


def test_times_that_are_exact():
    """A ball from 5 m, e = 1/2, g = 10: impacts at 1 s and 2 s, rest at 3 s."""
    ball = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, 0), contacts=[sf.Contact(point=(0, 0))], restitution=0.5, gravity=10)  # fmt: skip
    start = {"q": (0, 5, 0), "qdot": (0, 0, 0), "model": "local", "certify": True}
    enclosure = sf.simulate(ball, **start).enclosure
    (impact,) = enclosure.impacts
    for (low, high), time in (((impact["low"], impact["high"]), 1), (enclosure.zeno, 3)):  # fmt: skip
        assert low < time < high
        assert high - low <= 4 * math.ulp(time)
    assert enclosure.contacts == (1,)


def test_a_corner_of_endless_chatter_takes_no_time():
    enclosure = of(model(), (0, 0), (0, -1))
    low, high = enclosure.zeno
    assert low <= 0 <= high < 1e-300
    assert enclosure.contacts == (1, 2)


def test_a_start_at_rest():
    for gaps, contacts in (((0, 1), (1,)), ((1, 0), (2,)), ((0, 0), (1, 2))):
        enclosure = of(model(), gaps, (0, 0))
        low, high = enclosure.zeno
        assert low <= 0 <= high < 1e-300
        assert (enclosure.contacts, len(enclosure.impacts)) == (contacts, 0)


@pytest.mark.parametrize(
    ("parameters", "gaps", "rates", "options", "reason"),
    [
        ({}, (1, 1), (0, 0), {}, "which contact lands next is not certain"),
        ({"gravity": (0, 0)}, (1, 1), (1, 2), {}, NEVER),
        ({}, (1, 2), (0, 0), {"time_limit": 1.5}, "a limit of the run is reached"),
        ({}, (1, 2), (0, 0), {"event_limit": 0}, "a limit of the run is reached"),
    ],
)
def test_where_nothing_is_certain_it_is_said(parameters, gaps, rates, options, reason):
    enclosure = of(model(**parameters), gaps, rates, **options)
    assert (enclosure.zeno, enclosure.contacts) == (None, ())
    assert enclosure.reason == reason
    assert reason in repr(enclosure)


def test_a_body_is_enclosed_like_its_local_model():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    q, qdot = (0.0, 0.011, 0.002), (0.1, -0.2, 0.3)
    run = sf.simulate(rod, q, qdot, model="local", certify=True)
    start = run.gaps_at(0.0), run.gap_rates_at(0.0)
    other = of(rod.local(), *start)
    low, high = run.enclosure.zeno
    # Parameters, gaps and rates of the other one are rounded.
    assert abs(low - other.zeno[0]) <= 1e-14 * low
    assert low <= run.zeno_points[0].elapsed <= high
    assert pickle.loads(pickle.dumps(run)).enclosure == run.enclosure
    assert pickle.loads(pickle.dumps(run.enclosure)) == run.enclosure


def test_speeds_of_any_size_or_refused():
    """The same motion at speeds times 2^−k has the same times, as long as products of three speeds are doubles."""
    local = model(gravity=(0.522868521775169, 0.19732141343207195), psi=(2.0093833863278636, 0.49457687972207576), restitution=0.8422745640016168)  # fmt: skip
    times = []
    for k in range(0, 400, 20):
        s = 2.0**-k
        start = (27.1 * s * s, 0.289 * s * s), (-0.55 * s, 2.1 * s)
        try:
            run = local.simulate(*start, stop="zeno", certify=True)
        except ValueError as error:
            assert "from 1e-80 to 1e80 m/s" in str(error)  # noqa: PT017
            assert s < 1e-80
            continue
        times.append(run.elapsed / s)
        low, high = run.enclosure.zeno
        assert low * (1 - 1e-14) <= run.elapsed <= high * (1 + 1e-14)
    assert len(times) >= 13
    assert len(set(times)) == 1


def test_two_slopes_reached_at_once():
    """A body that falls vertically lands on both at the same instant, with any rounding errors of its gaps."""
    contacts = [sf.Contact((-1.0, 0.0)), sf.Contact((1.0, 0.2), slope=1.5)]
    body = sf.Posture(1.0, 0.3, (0.0, 0.5), contacts, 0.2, 9.81)
    for model in ("local", "full"):
        enclosure = sf.simulate(body, (0, 0.3, 0), (0, 0, 0), model=model, certify=True).enclosure  # fmt: skip
        assert (len(enclosure.impacts), enclosure.zeno) == (0, None)
        assert enclosure.reason == "which contact lands next is not certain"


@pytest.mark.parametrize(
    ("gravity", "psi", "e", "gaps", "rates", "contacts", "time"),
    [
        # One contact at rest while the other flies, or leaves: no impact.
        ((1, 1), (-0.5, -0.5), 0.1, (0, 1), (0, 0), (1,), 0.0),
        ((1, 1), (0.5, 0.5), 0.1, (0, 0), (0, 1), (1,), 0.0),
        # One impact without rebound, after which contact 1 rests.
        ((1, 1), (0.5, 0.5), 0.0, (0, 1), (-1, 0), (1,), 0.0),
        ((1, 1), (-0.5, -0.5), 0.0, (0.125, 1), (0, 0), (1,), 0.5),
        # Each bounce lifts contact 2, but its gap decreases until the end of the bounces.
        ((226273.18493724658, 80.73842815310807), (-0.004177961679880355, -23.2427098131835), (0.2284888864105247, 3.609030856423116e-09), (7.695428375451866e-06, 4.409564607818612e-06), (2.079329730803277, -0.14651071998290763), (1,), None),
        # Outside the cone a corner ends after one impact, and contact 2 bounces alone.
        ((1, 1), (0.9, 0.9), 0.1, (0, 0), (1, -0.1), (2,), 2 * 0.01 / 0.9),
    ],
)  # fmt: skip
def test_few_impacts(gravity, psi, e, gaps, rates, contacts, time):
    local = model(gravity=gravity, psi=psi, restitution=e)
    run = local.simulate(gaps=gaps, rates=rates, stop="zeno", certify=True)
    low, high = run.enclosure.zeno
    assert run.enclosure.contacts == contacts == run.zeno_points[0].contacts
    assert len(run.enclosure.impacts) < 10
    time = run.zeno_points[0].elapsed if time is None else time
    assert abs(low - time) <= 1e-14 * time
    assert high - low <= 1e-14 * time


@pytest.mark.parametrize(("rate", "time"), [(-1e60, 1.0000000000000001e-310), (-7e75, 1.43e-326)])  # fmt: skip
def test_times_below_the_normal_range(rate, time):
    """A gap of 1e-250 m: quotients underflow, bounds do not shrink to a point."""
    first = of(model(), (1e-250, 1), (rate, 0)).impacts[0]
    assert first["low"] <= time <= first["high"]
    assert first["low"] < first["high"] < 1e-300


@pytest.mark.parametrize(("draw", "least"), [(draw_full, 10), (draw_spinning, 4)])
def test_collisions_of_the_full_model(draw, least, record_property):
    """Each enclosed collision is that of the oracle, and its time lies within; Zeno points are not enclosed."""
    rng = np.random.default_rng(SEED)
    cases, claimed, widths = max(1, CASES // 5), 0, []
    for _ in range(cases):
        v = draw(rng)
        enclosure = simulate_full(v, certify=True).enclosure
        truth = oracle.orbit(v, at_least=len(enclosure.impacts)).collisions
        for impact, collision in zip(enclosure.impacts, truth, strict=False):
            assert impact["contact"] == collision.contact, v
            assert holds(impact["low"], impact["high"], collision.time), v
            widths.append((impact["high"] - impact["low"]) / impact["high"])
        claimed += min(len(enclosure.impacts), len(truth))
        assert enclosure.zeno is None
        assert enclosure.reason
    text = f"{cases} runs, {claimed} collisions enclosed, half of them to {np.median(widths):.1e} of the time"
    print(f"\n{text}")
    record_property(draw.__name__, text)
    assert claimed >= least * cases
    assert np.median(widths) <= 1e-15


def test_a_foot_that_goes_round():
    """One foot of a body that rotates at 3 rad/s: the root of a gap with a cosine, in 60 digits."""
    body = sf.Posture(1.0, 0.3, (0.0, 0.4), [sf.Contact((0.2, 0.0))], 0.5, 9.81)
    q, qdot = (0.0, 0.7, 0.3), (0.2, -0.1, 3.0)
    enclosure = sf.simulate(body, q, qdot, model="full", certify=True).enclosure
    x, y, height = mpf(0.2), -mpf(0.4), mpf(0.7)

    def gap(t):
        turn = mpf(0.3) + 3 * t
        fall = height - mpf(0.1) * t - mpf(9.81) * t * t / 2
        return fall + x * mp.sin(turn) + y * mp.cos(turn) - y

    first = enclosure.impacts[0]
    with mp.workdps(DIGITS):
        assert holds(first["low"], first["high"], str(mp.findroot(gap, first["low"])))
    assert first["high"] - first["low"] <= 4 * math.ulp(first["low"])


def test_a_run_that_leaves_its_bounds_says_so():
    """Where impacts amplify rounding errors, the run in doubles leaves the bounds proved with 106 bits."""
    rng = np.random.default_rng(SEED)
    strayed = 0
    for _ in range(400):
        psi, e = rng.uniform(0.15, 0.4), rng.uniform(0.5, 0.9)
        model = sf.LocalModel((9.81, 9.81), (psi, psi), (0, 0), e)
        run = model.simulate(rng.uniform(0, 0.02, 2), rng.normal(size=2), certify=True, stop="zeno")  # fmt: skip
        if not (run.enclosure.zeno and run.zeno_points):
            continue
        low, high = run.enclosure.zeno
        off = max(low - run.elapsed, run.elapsed - high)
        said = any("outside its proved bounds" in text for text in run.warnings)
        assert said == (off > 1e-13 * run.elapsed)
        strayed += said
    assert 10 < strayed < 200


@pytest.mark.parametrize("model", ["local", "full"])
def test_a_start_that_touches_but_for_a_rounding(model):
    """A foot displaced along its slope has a gap of rounding error. The gap as computed in doubles counts, unless it
    is negative."""
    rng = np.random.default_rng(SEED)
    above = 0
    for _ in range(200):
        slope, way = rng.uniform(-1, 1), 2.0 ** rng.integers(0, 10)
        rate = rng.choice([-0.1, 1.0])
        body = sf.Posture(1.0, 0.3, (0.0, 0.5), [sf.Contact((0.0, 0.0), slope=slope)], 0.5, 9.81)  # fmt: skip
        x, y = way * math.cos(slope), way * math.sin(slope)
        run = sf.simulate(body, (x, y, 0), (0, rate, 0), model=model, certify=True, stop="zeno")  # fmt: skip
        cos, sin = cos_sin(Decimal(slope))
        h = max(cos * Decimal(y) - sin * Decimal(x), Decimal(0))
        u, g = cos * Decimal(rate), cos * Decimal(body.gravity)
        time = (u + (u * u + 2 * g * h).sqrt()) / g
        first = run.enclosure.impacts[0]
        assert first["low"] <= first["high"], slope
        assert holds(first["low"], first["high"], time), slope
        above += h > 0
    assert 50 < above < 150


def test_a_body_at_rest_is_a_zeno_point_in_the_full_model_too():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    enclosure = sf.simulate(rod, (0, 0, 0), (0, 0, 0), model="full", certify=True).enclosure  # fmt: skip
    assert (enclosure.zeno, enclosure.contacts) == ((0.0, 0.0), (1, 2))


def test_only_where_it_can():
    three = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, 1), contacts=[sf.Contact(point=(x, 0)) for x in (-1, 0, 1)], restitution=0.5)  # fmt: skip
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    rough = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)  # fmt: skip
    for body, options in ((three, {}), (rough, {"impact": "poisson", "simultaneous": "first-contact-first"})):  # fmt: skip
        with pytest.raises(ValueError, match=r"^certify = true"):
            sf.simulate(body, (0, 1, 0), (0, 0, 0), certify=True, **options)
    with pytest.raises(ValueError, match=r"^certify = True"):
        sf.simulate_many(rod, (0, 1, 0), (0, 0, 0), certify=True)
    assert sf.simulate(rod, (0, 1, 0), (0, 0, 0)).enclosure is None


def test_a_fast_spin_is_the_reason_why_bounds_end():
    """After its first impact a uniform rod with e = 0.5 spins so fast that ω² half_length > g; with e = 0.45 it does not."""
    for restitution, fast in ((0.45, False), (0.5, True)):
        rod = sf.Posture.rod(half_length=0.5, restitution=restitution)
        q = np.add(rod.touching(contact=1, theta=np.radians(10)), (0, 0.2, 0))
        run = sf.simulate(rod, q, (0, 0, 0), model="full", certify=True)
        omega = run.at(np.nextafter(run.impacts["time"][0], 9))[1][2]
        assert (omega**2 * 0.5 > 9.81) == fast
        assert run.enclosure.reason.startswith("the body spins fast") == fast
