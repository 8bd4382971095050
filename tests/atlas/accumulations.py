"""Impacts that accumulate."""

import json
import math
from pathlib import Path

import oracle
import standfast as sf
from mpmath import mp, mpf

from . import baseline_methods, peers
from .entry import (
    Family,
    decimal,
    dropped_rod,
    exact,
    integrated,
    rest,
    rod,
    time_left,
    time_to_rest,
)

FAMILY = Family("Accumulating impacts")
entry = FAMILY.entry


def slow_to_rest(scene):
    body, end = scene.posture, 0.1
    gaps, psi = body.gaps(scene.q), float(rod(scene))
    rest = float(clattering(scene)["elapsed"])
    errors = []
    for step in (1e-4, 1e-5, 1e-6):
        model = (body.gravity,) * 2, (psi,) * 2, body.restitution
        errors.append(
            abs(
                baseline_methods.moreau_jean(gaps, (0, 0), *model, step, end) / rest - 1
            )
        )
    order = math.log10(errors[0] / errors[2]) / 2
    told = ", ".join(f"{x:.1%}" for x in errors)
    return (
        f"the error of the time of rest is {told} at dt = 1e-4, 1e-5, 1e-6 s: order {order:.2f}",
        order < 0.6,
    )


@entry(
    name="through_a_2_zeno_point",
    title="Moreau–Jean through the Zeno point of a rod",
    breaks="There are infinitely many impacts within one step, and the order of convergence falls below one.",
    method="Moreau–Jean, θ = 1/2, exact contact solve",
    fails=slow_to_rest,
    source="integrated impact by impact with 40 digits",
    answer=rest,
)
def clattering(scene):
    """Flights with finite rotation, one by one, with 40 digits, until they are below 1e-25 s."""
    body = scene.posture
    half, rho = exact(body.contacts[1].point[0]), exact(body.gyration_radius)
    gravity, e = exact(body.gravity), exact(body.restitution)

    def flight(state, side, touches):
        """Time until the end on this side lands."""
        y, v, theta, omega = state

        def gap(s):
            return (
                y
                + v * s
                - gravity * s * s / 2
                + side * half * mp.sin(theta + omega * s)
            )

        rate = v + side * half * mp.cos(theta) * omega
        height = mpf(0) if touches else max(gap(mpf(0)), mpf(0))
        guess = (rate + mp.sqrt(rate * rate + 2 * gravity * height)) / gravity
        return mp.findroot(gap, guess) if guess > 0 else mp.inf

    y, v, theta, omega, t = exact(scene.q[1]), mpf(0), exact(scene.q[2]), mpf(0), mpf(0)
    last = None
    while True:
        state = y, v, theta, omega
        s, side = min((flight(state, side, side == last), side) for side in (-1, 1))
        if s < mpf(10) ** -25:
            return {"outcome": "rest", "elapsed": t}
        y, v = y + v * s - gravity * s * s / 2, v - gravity * s
        theta, t, last = theta + omega * s, t + s, side
        b = side * half * mp.cos(theta)
        impulse = -(1 + e) * (v + b * omega) / (1 + b * b / rho**2)
        v, omega = v + impulse, omega + b * impulse / rho**2


BENCHES = Path(__file__).parents[2] / "benches" / "work_precision" / "scenes.json"


def rest_of_bench(name):
    """Time of rest of a scene of the benchmarks, from its file."""
    known = json.loads(BENCHES.read_text(encoding="utf-8"))["scenes"][name]
    return {"outcome": "rest", "elapsed": mpf(known["rest"]["time"])}


def flights_added_up(scene, gaps, psi):
    """Number of impacts of a body let go at rest until adding a further flight no longer changes the time; and that
    time."""
    body = scene.posture
    return baseline_methods.event_loop(
        gaps, (0.0, 0.0), (body.gravity,) * 2, (psi, psi), body.restitution
    )


def stuck(scene):
    gaps = scene.posture.gaps(scene.q)
    hits, t = flights_added_up(scene, gaps, float(rod(scene)))
    end = float(nested(scene)["elapsed"])
    return (
        f"after {hits} impacts the time no longer changes, at {t:.5f} s, the first Zeno point; there are infinitely many more until {end:.5f} s",
        t < 0.95 * end,
    )


@entry(
    name="zeno_points_that_accumulate",
    title="A uniform rod, e = 0.5: Zeno points that accumulate",
    breaks="After infinitely many impacts of one end there are infinitely many of the other end, and so on without end.",
    method="event loop, times of flights added up",
    fails=stuck,
    source="`benches/work_precision/scenes.py`: finite rotation in mpmath",
    answer=rest,
)
def nested(_scene):
    return rest_of_bench("nested")


def one_end_after_the_other(scene):
    hits, t = flights_added_up(scene, local_gaps(scene), 0.0)
    error = abs(t / float(apart(scene)["elapsed"]) - 1)
    return (
        f"the time no longer changes after {hits} impacts; the error of the time of rest is {error:.1e}",
        error > 1e-13,
    )


def local_gaps(scene, number=float):
    """Gaps of a level rod, to first order in its angle."""
    y, theta = number(float(scene.q[1])), number(float(scene.q[2]))
    half = number(scene.posture.contacts[1].point[0])
    return y - half * theta, y + half * theta


def a_rounding_an_impact(scene):
    return {"elapsed": len(scene.simulate().impacts) * 2.0**-53}


@entry(
    name="nearly_elastic_rod",
    title="A rod that loses a thousandth of its speed, ρ equal to half its length",
    breaks="There are thousands of impacts at both ends, and each adds a rounding error. With ψ = 0 the impacts of one end have no effect on the other.",
    method="event loop, times of flights added up",
    fails=one_end_after_the_other,
    source="two geometric series, one for each end",
    answer=rest,
    within=a_rounding_an_impact,
)
def apart(scene):
    assert rod(scene) == 0
    gravity, e = exact(scene.posture.gravity), exact(scene.posture.restitution)
    times = (time_to_rest(h, gravity, e, mpf(0)) for h in local_gaps(scene, mpf))
    return {"outcome": "rest", "elapsed": max(times)}


def shape_after_first_impact(scene):
    """(v, y) after the lower end of a rod that falls from rest has hit the ground, and its speed after the impact."""
    low, high = sorted(local_gaps(scene))
    u = math.sqrt(2 * scene.posture.gravity * low)
    e, psi = scene.posture.restitution, float(rod(scene))
    state = (-u - (1 + e) * psi * u) / (e * u), (high - low) / (e * u) ** 2
    return state, e * u


def still_matters(scene):
    state, _ = shape_after_first_impact(scene)
    count, left = baseline_methods.impacts_until_gravity_is_negligible(
        state,
        scene.posture.gravity,
        float(rod(scene)),
        scene.posture.restitution,
        1e-10,
    )
    told = "" if left < 1e-10 else f", and it has decreased to {left:.1e} only"
    return f"{count} impacts{told}", count > 10_000


def near_bound(scene):
    """The margin of the bound (10) on ψ of the paper, and the time of rest, found by simulating impact by impact."""
    psi, e = rod(scene), exact(scene.posture.restitution)
    bound = (mp.cbrt(e) + mp.cbrt(e) ** 2) / (1 + e)
    found = oracle.orbit(local_inputs(scene))
    return {
        "outcome": "rest",
        "elapsed": mpf(str(found.zeno.time)),
        "margin of [10]": psi - bound,
        "[10] holds": bool(psi > bound),
    }


def margin_told(scene):
    verdict = sf.stability(scene.posture)
    return {
        **rest(scene),
        "margin of [10]": verdict.clattering_margin,
        "[10] holds": verdict.clattering,
    }


def within_rounding_of_psi(scene):
    """Allowed error: ψ has a rounding error, and the distance of ψ from its bound has the same absolute error."""
    margin = near_bound(scene)["margin of [10]"]
    return {"margin of [10]": float(2 * 2.0**-53 / margin)}


for name, title in (
    (
        "near_the_clattering_bound",
        "A rod near the bound of clattering, e = 0.2, ψ = 0.7724",
    ),
    (
        "clattering_bound_to_1e_12",
        "The same, within 1e-12 of the bound",
    ),
):
    entry(
        name=name,
        title=title,
        breaks="Near the bound gravity becomes negligible only after very many impacts: e/λ₊³ → 1.",
        method="impact by impact until 2gh/u² has decreased by the factor 1e-10",
        fails=still_matters,
        source="ψ and the bound (e^⅓ + e^⅔)/(1 + e), and impacts one by one, with 40 digits",
        answer=margin_told,
        within=within_rounding_of_psi,
    )(near_bound)


def local_inputs(scene):
    """Inputs of the oracle for a level rod: geometry frozen, all of them exact."""
    body = scene.posture
    half, rho = exact(body.contacts[1].point[0]), exact(body.gyration_radius)
    y, theta, v, omega = (exact(x) for x in (*scene.q[1:], *scene.qdot[1:]))
    g, psi, phi = exact(body.gravity), rod(scene), half / (half**2 + rho**2)
    inputs = {
        "e": exact(body.restitution), "g1": g, "g2": g, "psi1": psi, "psi2": psi, "phi1": phi, "phi2": -phi,
        "h1": y - half * theta, "h2": y + half * theta, "theta": theta,
        "u1": v - half * omega, "u2": v + half * omega, "omega": omega,
    }  # fmt: skip
    return {name: decimal(x) for name, x in inputs.items()}


def neglected(scene):
    state = told_shape(scene)
    summed = baseline_methods.sum_without_gravity(
        state, float(rod(scene)), scene.posture.restitution
    )
    error = summed / float(self_similar(scene)["elapsed"]) - 1
    return f"the error of the time of rest is {error:.0%}", abs(error) > 0.1


def rounded_start(scene):
    """The start is on the self-similar orbit, up to rounding errors."""
    body, state = scene.posture, [mpf(x) for x in told_shape(scene)]
    actual = time_left(
        state, exact(body.gravity), rod(scene), exact(body.restitution), mpf(10) ** -30
    )
    return {"elapsed": 4e-15 + float(abs(actual / self_similar(scene)["elapsed"] - 1))}


def told_shape(scene):
    """(v, y) of a scene that starts right after an impact of end 1, with the take-off speed 1 m/s."""
    (_, h), half = local_gaps(scene), scene.posture.contacts[1].point[0]
    return float(scene.qdot[1] + half * scene.qdot[2]), float(h)


@entry(
    name="self_similar_shrinking",
    title="A rod below the bound of clattering, e = 0.2, ψ = 0.76",
    breaks="Without gravity the ends would clatter. With gravity each impact repeats the last one, smaller by a constant factor.",
    method="sum of the impacts without gravity",
    fails=neglected,
    source="c³ + Kc² + (1 − K − e)c − e = 0, K = 1 + (1 + e)ψ: the time from impact to impact is multiplied by c",
    answer=rest,
    within=rounded_start,
)
def self_similar(scene):
    e, psi, gravity = (
        exact(scene.posture.restitution),
        rod(scene),
        exact(scene.posture.gravity),
    )
    assert gravity == 1
    k = 1 + (1 + e) * psi
    c = mp.findroot(
        lambda c: c**3 + k * c * c + (1 - k - e) * c - e, (e + mp.cbrt(e)) / 2
    )
    assert e < c < mp.cbrt(e)
    assert c > e ** (mpf(2) / 5)
    v = (2 - (c + c**3) / e) / (1 - c * c)
    return {"outcome": "rest", "elapsed": (v + c / e) / (1 - c)}


def forgotten(scene):
    state, _ = shape_after_first_impact(scene)
    count = baseline_methods.impacts_until_apart(
        state,
        scene.posture.gravity,
        float(rod(scene)),
        scene.posture.restitution,
        2.0**-52,
        0.1,
    )
    return (
        f"two states that differ by one rounding differ by 10 % after {count} impacts",
        count < 400,
    )


#: Number of impacts in the averages of the chaotic motion, and number before them. Λ₁ ≈ 0.2 per impact limits the digits that
#: remain.
AVERAGED, BEFORE = 2000, 200


def statistics(scene):
    local = scene.posture.local()
    found = local.exponents((0, 0.5), (1, -0.3))
    run = scene.simulate()
    return {
        "outcome": run.outcome,
        "elapsed": run.elapsed,
        "proved": run.zeno_points[-1].certified,
        "fate": local.fate(local_gaps(scene), (0, 0)).kind,
        "σ": found.sigma,
        "Λ1": found.lyapunov[0],
    }


def chaotic_rest(scene, psi):
    gravity, e = exact(scene.posture.gravity), exact(scene.posture.restitution)
    with mp.workdps(300):
        low, high = sorted(local_gaps(scene, mpf))
        return dropped_rod(low, high, gravity, psi, e, mpf(10) ** -20)


def sensitive(scene):
    """Allowed errors. For the averages: four of the standard errors that the package states, scaled as 1/√n. For the
    time of rest: its change when ψ changes by its rounding error."""
    found = scene.posture.local().exponents((0, 0.5), (1, -0.3))
    more = 4 * math.sqrt(found.hits / AVERAGED + 1)
    psi = rod(scene)
    one, other = (chaotic_rest(scene, x) for x in (psi, psi * (1 + mpf(2) ** -53)))
    return {
        "elapsed": float(abs(other / one - 1)),
        "σ": more * found.sigma_error / abs(found.sigma),
        "Λ1": more * found.lyapunov_error[0] / found.lyapunov[0],
    }


@entry(
    name="chaos",
    title="Chaos: e = 0.9, ψ = 0.22",
    breaks="The impacts shrink to a point without any pattern, and each impact amplifies the rounding errors of the earlier ones.",
    method="impact by impact in doubles",
    fails=forgotten,
    source="2000 impacts with 300 digits, two orbits 1e-270 apart; the time of rest impact by impact",
    answer=statistics,
    within=sensitive,
)
def _(scene):
    gravity, e = exact(scene.posture.gravity), exact(scene.posture.restitution)
    with mp.workdps(300):
        start = mpf(-1), mpf(1)
        pair = [
            baseline_methods.impacts_up_to_scale(
                (v, y), gravity, rod(scene), e, mp.sqrt
            )
            for v, y in (start, (start[0], start[1] * (1 + mpf(10) ** -270)))
        ]
        first, log = None, mpf(0)
        for k, (one, other) in enumerate(zip(*pair, strict=False)):
            distance = mp.hypot(*(x - y for x, y in zip(one[0], other[0], strict=True)))
            if k == BEFORE:
                first = distance
            if k > BEFORE:
                log += mp.log(one[1])
            if k == BEFORE + AVERAGED:
                break
        sigma, exponent = log / AVERAGED, mp.log(distance / first) / AVERAGED
    return {
        "outcome": "rest",
        "elapsed": +chaotic_rest(scene, rod(scene)),
        "proved": False,
        "fate": "other",
        "σ": +sigma,
        "Λ1": +exponent,
    }


def no_flight(scene):
    gaps = scene.posture.gaps(scene.q)
    hits, t = flights_added_up(scene, gaps, float(rod(scene)))
    end = float(falls_on(scene)["elapsed"])
    return (
        f"the time no longer changes after {hits} impact, at {t:.4f} s, with flights of zero length; the rod rests at {end:.4f} s",
        t < 0.99 * end,
    )


@entry(
    name="plastic_rod",
    title="A rod that does not rebound, e = 0",
    breaks="The end that has landed stays on the ground and slides while the other end falls. Its next flight has zero length.",
    method="event loop, times of flights added up",
    fails=no_flight,
    source="energy about the sliding end, by quadrature",
    answer=rest,
    within=integrated("elapsed"),
)
def falls_on(scene):
    """The lower end lands and remains closed: y = L sin φ, ½(ρ² + L²cos²φ) φ'² + gL sin φ is constant until φ = 0. There e =
    0 and ψ > 0 stop the motion."""
    body = scene.posture
    half, rho2 = exact(body.contacts[1].point[0]), exact(body.gyration_radius) ** 2
    gravity, phi = exact(body.gravity), exact(scene.q[2])
    assert body.restitution == 0
    assert half**2 > rho2
    fall = exact(scene.q[1]) - half * mp.sin(phi)
    u, b = mp.sqrt(2 * gravity * fall), half * mp.cos(phi)
    rate = -u * b / (rho2 + b * b)
    energy = (rho2 + b * b) * rate**2 / 2 + gravity * half * mp.sin(phi)

    def slowness(at):
        inertia = rho2 + (half * mp.cos(at)) ** 2
        return mp.sqrt(inertia / (2 * (energy - gravity * half * mp.sin(at))))

    return {"outcome": "rest", "elapsed": u / gravity + mp.quad(slowness, [0, phi])}


def too_soon(scene):
    right = float(rocks(scene)["elapsed"])
    errors = [
        abs(
            peers.simulate("pymunk_space", scene, step, 1.5 * right, "rocking")[1]
            / right
            - 1
        )
        for step in (1e-2, 1e-3)
    ]
    return (
        f"the error of the time of rest is {errors[0]:.0%} at dt = 1e-2 s and {errors[1]:.1%} at 1e-3 s",
        errors[0] > 0.1 and errors[1] > 0.01,
    )


@entry(
    name="rocking_block",
    title="A block that rocks to rest",
    breaks="The swings from one foot to the other become shorter and shorter, and each begins with an impact that takes energy.",
    method="pymunk",
    needs="pymunk",
    fails=too_soon,
    source="`benches/work_precision/scenes.py`: swings by quadrature",
    answer=rest,
    within=integrated("elapsed"),
)
def rocks(_scene):
    return rest_of_bench("rocking")
