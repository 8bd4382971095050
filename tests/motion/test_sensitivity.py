"""How much the end of a run depends on its start: `run.sensitivity`, beside differences of two motions.

Without friction both motions are those of the oracle with 70 digits, a change of 1e-45 apart; their growth is exact at any size.
With friction both are runs in doubles, 1e-9 apart, so that growth up to 1e5 is seen. STANDFAST_SENSITIVITY sets the number of
motions of each kind (12).
"""

import math
import os

import numpy as np
import oracle
import pytest
import standfast as sf

RUNS = int(os.environ.get("STANDFAST_SENSITIVITY", "12"))
#: Digits of the oracle, and the change of the start: growth up to 1e20 leaves it small beside the motion.
DIGITS, CHANGE = 70, "1e-45"
#: Impacts that the oracle follows.
IMPACTS = 60
GRAVITY = 9.81
#: Changes in doubles; three growths that agree to this factor are the derivative.
STEPS, AGREE = (1e-8, 1e-9, -1e-9), 1.3


def size_of(body):
    arms = np.array([c.point for c in body.contacts]) - np.array(body.center_of_mass)
    return max(body.gyration_radius, np.hypot(*arms.T).max())


def units(body):
    """The change of q and q̇ of which each part has the size 1, and the unit of time. Along the ground and of the turn it has the sign of
    the arm of the first contact."""
    size, rho = size_of(body), body.gyration_radius
    length, speed = size, math.sqrt(GRAVITY * size)
    of = np.array([length, length, length / rho, speed, speed, speed / rho])
    aside = 1.0 if body.contacts[0].point[0] >= body.center_of_mass[0] else -1.0
    return of * [aside, 1, aside, aside, 1, aside], math.sqrt(size / GRAVITY)


def follow(inputs, end):
    """(x, y, θ, ẋ, ẏ, ω) at this time, after all impacts before it; None after too many."""
    with oracle.arithmetic(DIGITS) as ctx:
        motion, hits = oracle.FullMotion(ctx, inputs), []
        end = ctx.number(end)
        while len(hits) < IMPACTS:
            before = motion.t, *motion.r, motion.theta, *motion.v, motion.omega
            oracle.collide(motion, hits)
            if motion.t > end:
                t, x, y, turn, vx, vy, spin = before
                dt = end - t
                fall = motion.g * dt
                return [
                    *(x + vx * dt, y + vy * dt - fall * dt / 2, turn + spin * dt),
                    *(vx, vy - fall, spin),
                ]
    return None


def difference(inputs, body, end):
    """Growth of a small change of the start until this time, in the oracle's digits."""
    unit, _ = units(body)
    names = ("r_x", "r_y", "theta", "v_x", "v_y", "omega")
    with oracle.arithmetic(DIGITS) as ctx:
        step = ctx.number(CHANGE)
        share = step / ctx.number(6).sqrt()
        near = dict(inputs) | {
            name: ctx.number(inputs[name]) + share * ctx.number(float(u))
            for name, u in zip(names, unit, strict=True)
        }
        one, two = follow(inputs, end), follow(near, end)
        if one is None or two is None:
            return None
        parts = [
            (b - a) / ctx.number(float(u))
            for a, b, u in zip(one, two, unit, strict=True)
        ]
        return float(sum(p * p for p in parts).sqrt() / step)


def drawn(rng):
    """A body on two feet without friction, its start, and a time before the impacts accumulate."""
    rho, e = rng.uniform(0.15, 0.6), rng.uniform(0.5, 0.99)
    center = (rng.uniform(-0.2, 0.2), rng.uniform(0.0, 0.3))
    slopes = rng.uniform(-0.3, 0.3, 2)
    feet = [(-0.5, 0.0), (0.5, 0.0)]
    body = sf.Posture(
        mass=1,
        gyration_radius=rho,
        center_of_mass=center,
        restitution=e,
        gravity=GRAVITY,
        contacts=[
            sf.Contact(point=p, slope=s) for p, s in zip(feet, slopes, strict=True)
        ],
    )
    q = (0.0, rng.uniform(0.3, 1.0), rng.uniform(-0.3, 0.3))
    v = rng.normal(size=3)
    inputs = {"e": e, "g": GRAVITY, "rho": rho}
    inputs |= {"x_x": center[0], "x_y": center[1]}
    for i, (p, s) in enumerate(zip(feet, slopes, strict=True), 1):
        inputs |= {f"x{i}_x": p[0], f"x{i}_y": p[1], f"alpha{i}": s}
    names = ("r_x", "r_y", "theta", "v_x", "v_y", "omega")
    inputs |= dict(zip(names, (*q, *v), strict=True))
    return body, q, v, inputs


def test_without_friction_it_is_the_growth_in_extended_precision():
    """All of it within a factor of 2, and nearly all within a thousandth, while the run is the motion."""
    rng = np.random.default_rng(66)
    compared, close, largest = 0, 0, 0.0
    while compared < RUNS:
        body, q, v, inputs = drawn(rng)
        whole = sf.simulate(body, q, v, event_limit=IMPACTS, model="full")
        # The last impacts of an accumulation, which the growth leaves out, come after this.
        rates = np.abs(whole.impacts["rates_before"]).max(axis=1)
        slow = np.flatnonzero(rates < 1e-3 * np.maximum.accumulate(rates))
        last = slow[0] if len(slow) else len(rates)
        if last < 5:
            continue
        k = int(rng.integers(3, last - 1))
        end = 0.5 * (whole.impacts["time"][k] + whole.impacts["time"][k + 1])
        run = sf.simulate(body, q, v, model="full", stop="time", time_limit=end)
        exact = difference(inputs, body, end)
        if exact is None or run.time_error > 1e-3 or run.determined_until is not None:
            continue
        assert 0.5 < run.sensitivity / exact < 2, (inputs, end)
        compared += 1
        close += abs(run.sensitivity / exact - 1) < 1e-3
        largest = max(largest, exact)
    assert close > 0.95 * compared - 1
    assert largest > 10


def known(run):
    return [p.mode for p in run.phases], run.impacts["contact"].tolist(), run.outcome


def growths(body, q, v, options):
    """The run, and its growth by differences of runs; None where they do not agree."""
    run = sf.simulate(body, q, v, **options)
    unit, second = units(body)
    found = []
    for step in STEPS:
        near = np.array([*q, *v]) + step * unit / math.sqrt(6)
        other = sf.simulate(body, near[:3], near[3:], **options)
        if known(other) != known(run) or run.outcome not in ("rest", "time-limit"):
            return run, None
        parts = (np.array([*other.q, *other.qdot]) - [*run.q, *run.qdot]) / unit
        late = (other.time - run.time) / second if run.outcome == "rest" else 0.0
        found.append(math.hypot(*parts, late) / abs(step))
    agrees = max(found) < AGREE * min(found) and max(found) < 1e5
    return run, found[1] if agrees else None


@pytest.mark.parametrize("law", ["moreau", "poisson", "stronge", "newton"])
@pytest.mark.parametrize("shape", ["rod", "box"])
def test_it_is_the_growth_between_two_runs(law, shape):
    """Through slides, rolls about a corner, accumulations and rest. Newton's law runs without friction here."""
    rng = np.random.default_rng([len(law), len(shape)])
    compared, off = 0, 0
    while compared < RUNS:
        e, mu = rng.uniform(0.1, 0.9), rng.choice([0.0, 0.2, 0.6])
        fields = {"restitution": e, "friction": 0.0 if law == "newton" else mu}
        if shape == "rod":
            rho = rng.uniform(0.1, 0.3)
            body = sf.Posture.rod(0.5, gyration_radius=rho, **fields)
        else:
            body = sf.Posture.box(1.0, rng.uniform(0.3, 2), **fields)
        q = (0.0, rng.uniform(0.3, 1.0), rng.uniform(-0.3, 0.3))
        v = rng.normal(size=3)
        options = {"event_limit": 5000, "impact": law}
        if rng.random() < 0.5:
            options |= {"stop": "time", "time_limit": rng.uniform(0.1, 1.5)}
        run, exact = growths(body, q, v, options)
        if exact is None or max(exact, run.sensitivity) < 1e-5:
            continue
        compared += 1
        off += not 0.5 < run.sensitivity / exact < 2
    assert off <= 0.01 * compared


def test_a_ball_does_not_amplify():
    """δ(end) is what is left of δ(start): the way along the ground and the turn, and the time of rest.

    Without friction x, ẋ, θ and ω go on. With an upward speed v the ball lands after (v + s)/g with s = √(v² + 2gh), and rests
    2 e s/(g (1 − e)) later. From rest T changes by δv/g + (1 + e)/(1 − e) δh/s.
    """
    h, e, g = 5.0, 0.5, 10.0
    ball = sf.Posture(
        mass=1,
        gyration_radius=1,
        center_of_mass=(0, 0),
        contacts=[sf.Contact(point=(0, 0))],
        restitution=e,
        gravity=g,
    )
    run = sf.simulate(ball, (0, h, 0))
    T, part = 3.0, 1 / math.sqrt(6)  # size 1
    speed = math.sqrt(g)
    late = part * speed / g + (1 + e) / (1 - e) * part / math.sqrt(2 * g * h)
    along = part + T * part * speed  # and the turn likewise
    left = [along, along, part, part, late * math.sqrt(g)]
    # The run is exact to its last digits; the outcome is a slide, and not rest, for a changed start.
    assert run.outcome == "rest"
    assert run.sensitivity == pytest.approx(math.hypot(*left), rel=1e-6)
    assert run.determined_until is None
    assert run.warnings == []
    assert run.time_error < 1e-14


def chaotic(**options):
    rod = sf.Posture.rod(0.5, gyration_radius=0.2, restitution=0.99)
    return sf.simulate(rod, (0, 0.4, 0.3), **options)


def test_a_chaotic_run_says_from_when_on_nothing_is_determined():
    """Another run, from a start 1e-15 apart, leaves it after about this time, and only then."""
    run = chaotic()
    assert run.sensitivity > 1e16
    [warning] = run.warnings
    assert warning.startswith(
        f"nothing is determined from {run.determined_until:.6f} s on"
    )
    assert run.time_error > 0.1 * run.time
    assert run.zeno_points[-1].time_error > 0.1 * run.time
    rod = sf.Posture.rod(0.5, gyration_radius=0.2, restitution=0.99)
    other = sf.simulate(rod, (0, 0.4 + 1e-15, 0.3))
    before, after = 0.5 * run.determined_until, 1.1 * run.determined_until
    apart = [np.abs(run.at(t)[0] - other.at(t)[0]).max() for t in (before, after)]
    assert apart[0] < 1e-7
    assert apart[1] > 1e-2
    assert chaotic(record=False).sensitivity is None
    assert chaotic(record=False).determined_until is None


def test_a_limit_ends_the_run_where_the_growth_exceeds_it():
    whole = chaotic()
    last = 0.0
    for limit in (1e3, 1e8, 4.5e15):
        run = chaotic(sensitivity_limit=limit)
        assert run.outcome == "sensitivity-limit"
        assert limit < run.sensitivity < 1e3 * limit
        assert last < run.time < whole.time
        for time in np.linspace(0, run.time, 7)[:-1]:
            np.testing.assert_array_equal(run.at(time)[0], whole.at(time)[0])
        bare = chaotic(sensitivity_limit=limit, record=False)
        assert (bare.outcome, bare.time) == (run.outcome, run.time)
        last = run.time
    assert abs(run.time / whole.determined_until - 1) < 0.2
    calm = sf.simulate(
        sf.Posture.rod(0.5, gyration_radius=0.2, restitution=0.1),
        (0, 0.4, 0.3),
        sensitivity_limit=1e6,
    )
    assert calm.outcome == "rest"
    ends = sf.simulate_many(
        sf.Posture.rod(0.5, gyration_radius=0.2, restitution=0.99),
        [(0, 0.4, 0.3), (0, 0.4, 0.0)],
        [(0, 0, 0)] * 2,
        sensitivity_limit=1e6,
    )
    assert list(ends.outcome) == ["sensitivity-limit", "rest"]
    with pytest.raises(
        ValueError, match=r"sensitivity_limit = 1\.0 is outside its range: > 1"
    ):
        chaotic(sensitivity_limit=1)


def test_the_time_of_rest_is_as_wrong_as_the_run_says():
    """The time of the Zeno point beside the oracle's. The estimate is one of size: at most ten times as much, but for one
    run in a hundred."""
    rng = np.random.default_rng(99)
    off = 0
    for _ in range(RUNS):
        body, q, v, inputs = drawn(rng)
        e = rng.uniform(0.3, 0.9)
        body, inputs["e"] = body.replace(restitution=e), e
        run = sf.simulate(body, q, v, stop="zeno", model="full", event_limit=300)
        if run.outcome != "zeno" or run.determined_until is not None:
            continue
        digits = 20 + int(math.log10(1 + run.sensitivity))
        exact = float(oracle.orbit(inputs, digits=digits).zeno.time)
        error = abs(run.zeno_points[0].time - exact)
        off += error > 10 * run.zeno_points[0].time_error
    assert off <= 0.01 * RUNS


def test_mechanisms_and_local_models_have_it_too():
    """A body as a mechanism: the growth of its local model."""
    body = sf.Posture.rod(0.5, gyration_radius=0.2, restitution=0.6, friction=0.3)
    start = ((0.0, 0.02, 0.01), (0.3, 0.0, 0.1))
    one = sf.simulate(body, *start, model="local")
    two = sf.simulate(sf.Mechanism.of_posture(body), *start)
    assert one.sensitivity > 0 < two.sensitivity
    model = sf.LocalModel(gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.9)
    assert model.simulate((0, 0.1), (0.1, -1.9)).sensitivity > 0


def test_the_end_at_a_zeno_point_has_the_error_of_its_time():
    """Chaos on smaller and smaller scales: a start changed by 1e-15 moves the Zeno point by 1e-6 s and more."""
    local = sf.LocalModel(
        gravity=(1, 1),
        psi=(0.6244270063384505,) * 2,
        phi=(0, 0),
        restitution=(0.7983,) * 2,
    )

    def run(off):
        gaps = (0.0, 0.13498785564096996 * (1 + off))
        return local.simulate(gaps, (1.0, -0.09796734446446131), stop="zeno")

    first = run(0.0)
    moved = [abs(run(k * 1e-15).elapsed - first.elapsed) for k in range(-5, 6)]
    assert max(moved) > 1e-8
    assert first.time_error == first.zeno_points[-1].time_error
    assert max(moved) < 100 * first.time_error
