"""Zeno times known in closed form or to twenty digits, in scenes without friction."""

import math
import random
from fractions import Fraction

import pytest
import standfast as sf

CLATTERING = [
    # (u_a, u_b, h_b), e, (ψ_a, ψ_b), (g_a, g_b), time from the impact at a to the 2-Zeno point
    ((-1, -1, 0.01), 0.05, (0.5, 0.5), (1, 1), "0.00707955940720602182"),
    ((-1, -1, 0.1), 0.1, (0.9, 0.9), (1, 1), "0.0517789980484233041"),
    ((-1, -0.5, 0.2), 0.1, (0.8, 0.7), (1, 1.5), "0.139234445014142763"),
]


def ball(restitution, gravity, radius=1.0):
    """A ball on a flat floor, at rest at q = 0: one contact below the centre of mass."""
    return sf.Posture(
        mass=1.0,
        gyration_radius=math.sqrt(0.4) * radius,
        center_of_mass=(0.0, radius),
        contacts=[sf.Contact(point=(0.0, 0.0))],
        restitution=restitution,
        gravity=gravity,
    )


def zeno_point(run):
    """The Zeno point at which a run ended."""
    assert run.outcome == "zeno"
    assert len(run.zeno_points) == 1
    return run.zeno_points[0]


def assert_ulps(value, exact, ulps):
    """``value`` lies within ``ulps`` of ``exact``, which has more digits than a double."""
    exact = Fraction(exact)
    error = abs(Fraction(float(value)) - exact) / Fraction(math.ulp(float(exact)))
    assert error <= ulps, (
        f"{float(value)!r} is {float(error):.2f} ulp from {float(exact)!r}"
    )


def drop_time(height, gravity, restitution):
    """√(2h/g) (1 + e)/(1 − e) to thirty digits, for the doubles given."""
    scale = 10**60
    square = 2 * Fraction(height) / Fraction(gravity) * scale
    root = Fraction(math.isqrt(square.numerator * scale // square.denominator), scale)
    e = Fraction(restitution)
    return root * (1 + e) / (1 - e)


def test_the_rod_clatters_to_rest_on_both_ends():
    """Full model, ends at 10 and 12 mm: 2-Zeno at .0477848070642202037540 s for the decimals, at
    .0477848070642202012761 s for the doubles next to them, most collisions summed and not simulated.
    """
    rod = sf.Posture.rod(
        half_length=0.5, gyration_radius=0.2, restitution=0.1, gravity=9.81
    )
    start = {"q": (0.0, 0.011, math.asin(0.002)), "qdot": (0.0, 0.0, 0.0)}
    run = sf.simulate(rod, **start, model="full", stop="zeno")
    point = zeno_point(run)
    assert (point.kind, tuple(point.contacts), point.contact) == (
        "2-zeno",
        (1, 2),
        None,
    )
    assert_ulps(point.time, "0.0477848070642202037540", 2)
    assert_ulps(point.time, "0.0477848070642202012761", 2)
    assert len(run.impacts) <= 10


@pytest.mark.parametrize("model", ["local", "full"])
def test_a_ball_comes_to_rest_after_three_seconds_exactly(model):
    """x'' = −10, x_0 = 5, e = 1/2: every intermediate value is a double."""
    run = sf.simulate(
        ball(0.5, 10.0), q=(0, 5, 0), qdot=(0, 0, 0), model=model, stop="zeno"
    )
    point = zeno_point(run)
    assert (point.kind, point.contact) == ("1-zeno", 1)
    assert point.time == point.elapsed == 3.0


@pytest.mark.parametrize("model", ["local", "full"])
@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.7, 0.9, 0.999, 0.99999])
def test_a_ball_dropped_from_one_metre(model, restitution):
    """√(2h/g)(1 + e)/(1 − e), also at e = .99999, where a loop over the bounces needs millions of them. 4 ulp: one rounding
    error each of the fall, the speed, 1 − e and the sum."""
    posture = ball(restitution, 9.81)
    run = sf.simulate(posture, q=(0, 1, 0), qdot=(0, 0, 0), model=model, stop="zeno")
    point = zeno_point(run)
    assert (point.kind, point.contact) == ("1-zeno", 1)
    assert point.method == "bounce"
    assert_ulps(point.time, drop_time(1.0, 9.81, restitution), 4)
    assert len(run.impacts) <= 10


@pytest.mark.parametrize("model", ["local", "full"])
def test_a_ball_of_ten_centimetres(model):
    """R = .1, centre at y = 1, g = 9.81, e = .5: first impact and Zeno time."""
    posture = ball(0.5, 9.81, radius=0.1)
    run = sf.simulate(posture, q=(0, 0.9, 0), qdot=(0, 0, 0), model=model, stop="zeno")
    assert run.impacts["time"][0] == pytest.approx(0.428352936878119, rel=2e-15)
    assert zeno_point(run).time == pytest.approx(1.28505881063436, rel=4e-15)


@pytest.mark.parametrize("first", [1, 2])
@pytest.mark.parametrize(("state", "e", "psi", "g", "time"), CLATTERING)
def test_clattering_times_from_the_first_impact(first, state, e, psi, g, time):
    """The local model starts when contact ``first`` lands; the numbering of the contacts is arbitrary."""
    u_a, u_b, h_b = state
    turned = (lambda a, b: (a, b)) if first == 1 else (lambda a, b: (b, a))
    model = sf.LocalModel(
        gravity=turned(*g), psi=turned(*psi), phi=turned(0.5, -0.5), restitution=e
    )
    run = model.simulate(
        gaps=turned(0.0, h_b), rates=turned(u_a, u_b), theta=0.0, omega=0.0, stop="zeno"
    )
    point = zeno_point(run)
    assert point.kind == "2-zeno"
    assert run.impacts["contact"][0] == first
    assert_ulps(point.elapsed, time, 4)


@pytest.mark.parametrize("model", ["local", "full"])
def test_the_clock_does_not_stall_at_a_thousand_seconds(model):
    """The duration of the motion has the same bits for any initial time."""
    rod = sf.Posture.rod(
        half_length=0.5, gyration_radius=0.2, restitution=0.1, gravity=9.81
    )
    for posture, q in [
        (ball(0.5, 10.0), (0, 5, 0)),
        (rod, (0, 0.011, math.asin(0.002))),
    ]:
        keywords = {"q": q, "qdot": (0, 0, 0), "model": model, "stop": "zeno"}
        now = zeno_point(sf.simulate(posture, **keywords))
        later = zeno_point(sf.simulate(posture, **keywords, time=1000.0))
        assert later.elapsed == now.elapsed
        assert later.time == 1000.0 + now.elapsed


@pytest.mark.parametrize("loss", [2**-53, 2**-52, 1e-14, 1e-8])
def test_a_rod_that_bounces_for_ages_comes_to_rest_where_it_is(loss):
    """Both ends land together at every impact: a fall from 0.97 m takes t(1 + e)/(1 − e), and the rod is then at rest on the
    ground."""
    feet = [sf.Contact((-2.0, 0.0)), sf.Contact((1.2282, 0.0))]
    body = sf.Posture(1.0, 0.34, (-1.4038, 0.1137), feet, 1.0 - loss, 9.81)
    run = sf.simulate(body, (0, 0.97, 0), (0, 0, 0), model="full")
    fall, loss = math.sqrt(2 * 0.97 / 9.81), 1.0 - body.restitution  # exactly
    assert run.time == pytest.approx(fall * (2 - loss) / loss, rel=1e-14)
    assert run.outcome == "rest"
    assert max(map(abs, run.q)) < 1e-15


@pytest.mark.parametrize("model", ["full", "local", "auto"])
def test_a_rod_that_lands_flat_stays_flat(model):
    """For any slenderness: v = √(2gh) at t₁ = v/g, and bounces of both ends with a total duration of t₁ (1 + 2e/(1 − e))."""
    for k in range(1, 60):
        rod = sf.Posture.rod(
            half_length=1.0, gyration_radius=k / 60, restitution=0.1, gravity=10.0
        )
        run = sf.simulate(rod, (0, 0.2, 0), (0, 0, 0), model=model)
        assert run.outcome == "rest"
        assert run.time == pytest.approx(0.2 * 1.1 / 0.9, rel=1e-14)
        assert abs(run.q[2]) <= 1e-12


def test_no_impact_is_listed_after_the_end_of_a_run():
    """A time limit one rounding step before an impact. The clock is a sum of two doubles: the first one alone may tie with the limit."""
    rng = random.Random(1)
    late = 0
    for n in range(600):
        feet = [
            sf.Contact((x, 0.0), friction=0.3 * (n % 3 == 0))
            for x in ([0], [-0.5, 0.5])[n % 2]
        ]
        body = sf.Posture(1, 0.3, (0, 0), feet, rng.choice([0.15, 0.5, 0.8]))
        start = (
            (0, rng.uniform(0.6, 2), rng.uniform(-1, 1)),
            (0.3, rng.uniform(-1, 1), rng.uniform(-1, 1)),
        )
        options = {
            "model": rng.choice(["full", "local"]),
            "impact": rng.choice(["newton", "moreau", "poisson"]),
        }
        for t in sf.simulate(body, *start, event_limit=200, **options).impacts["time"][
            :4
        ]:
            run = sf.simulate(body, *start, time_limit=math.nextafter(t, 0), **options)
            assert run.impacts["elapsed"].max(initial=0) <= run.elapsed
            run.at(run.impacts["elapsed"])
            late += len(run.impacts) > 1
    assert late > 300
