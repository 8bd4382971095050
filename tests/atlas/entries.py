"""The atlas: scenes at which methods fail. Each entry holds what a usual method makes of its scene, by code; what is true of it,
from a source that is not standfast; and what standfast answers."""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import standfast as sf
from mpmath import mp, mpf

from . import naive

SCENES = Path(__file__).parent / "scenes"
DIGITS = 40


@dataclass
class Entry:
    """One scene."""

    name: str
    title: str
    #: What breaks, in a sentence.
    breaks: str
    #: The method that fails; what it found, and whether that is wrong.
    method: str
    fails: Callable[[sf.Scene], tuple[str, bool]]
    #: How the truth is known, and the truth: name → number (within `within`) or anything that is equal.
    source: str
    truth: Callable[[sf.Scene], dict]
    answer: Callable[[sf.Scene], dict]
    #: Relative error allowed to numbers; absolute where the truth is zero.
    within: float = 4e-15
    truths: dict = field(default_factory=dict)

    @property
    def scene(self):
        return sf.load(str(SCENES / f"{self.name}.toml"))


ATLAS: list[Entry] = []


def entry(**fields):
    """Adds the entry whose truth is the decorated function."""

    def add(truth):
        ATLAS.append(Entry(truth=truth, **fields))
        return truth

    return add


def exact(value):
    return mpf(float(value))


def dropped(scene):
    """Height, gravity and restitution of a ball at rest above level ground."""
    return (
        exact(scene.posture.gaps(scene.q)[0]),
        exact(scene.posture.gravity),
        exact(scene.posture.restitution),
    )


def time_to_rest(h, gravity, e, u):
    """First landing, then 2v/(g(1 − e)) of bounces with the speed v after it."""
    root = mp.sqrt(u * u + 2 * gravity * h)
    return (u + root) / gravity + 2 * e * root / (gravity * (1 - e))


def ball_rest(scene):
    h, gravity, e = dropped(scene)
    u = exact(scene.qdot[1])
    return {"outcome": "rest", "elapsed": time_to_rest(h, gravity, e, u)}


def rest(scene):
    run = scene.simulate()
    return {"outcome": run.outcome, "elapsed": run.elapsed}


def ball_numbers(scene):
    h, gravity, e = (float(x) for x in dropped(scene))
    return h, gravity, e, math.sqrt(2 * gravity * h)


# --- clocks and sums ---------------------------------------------------------------------------------------------------------


def stalls(scene):
    _, gravity, e, v = ball_numbers(scene)
    start = scene.options["time"]
    landing = start + v / gravity
    count, end = naive.bounces_on_an_absolute_clock(landing, e * v, gravity, e)
    error = abs((end - start) / float(ball_rest(scene)["elapsed"]) - 1)
    return (
        f"time stands still after {count} bounces, with speed left; the time of rest is off by {error:.1e}",
        error > 1e-14,
    )


for name, when in (("clock_at_1000", "1000 s"), ("clock_at_1e9", "1e9 s")):
    entry(
        name=name,
        title=f"A ball that bounces at {when} on the clock",
        breaks="Flights become shorter than the rounding of the time of day.",
        method="flights added to the time of day",
        fails=stalls,
        source="geometric series",
        answer=rest,
    )(ball_rest)


def many_bounces(scene):
    _, gravity, e, v = ball_numbers(scene)
    count, end = naive.bounces_until_slow(v / gravity, e * v, gravity, e)
    error = abs(end / float(ball_rest(scene)["elapsed"]) - 1)
    return f"{count} bounces until 1e-10 m/s, an error of {error:.1e}", count > 1e6


entry(
    name="nearly_elastic",
    title="A ball that loses a hundred-thousandth of its speed",
    breaks="As e → 1 a rest needs ever more bounces, −10/log₁₀ e and more, and each adds a rounding.",
    method="bounce by bounce until 1e-10 m/s",
    fails=many_bounces,
    source="geometric series",
    answer=rest,
)(ball_rest)


def at_once(scene):
    h, gravity, _, v = ball_numbers(scene)
    slow = 1e-5
    return (
        f"at {v:.1e} m/s the ball counts as at rest before it has bounced at all: rest at {math.sqrt(2 * h / gravity):.1e} s",
        v < slow,
    )


entry(
    name="small_scale",
    title="A ball dropped from a picometre",
    breaks="Tolerances in metres and seconds end a small motion at its beginning.",
    method="rest below 1e-5 m/s",
    fails=at_once,
    source="geometric series",
    answer=rest,
)(ball_rest)


def squares_vanish(scene):
    u, gravity = float(scene.qdot[1]), scene.posture.gravity
    speed = math.sqrt(u * u + 2 * gravity * 0.0)
    return f"√(u² + 2gh) of u = {u:.0e} m/s is {speed}: at rest at once", speed == 0.0


def refused(scene):
    try:
        scene.simulate()
    except ValueError as error:
        return {"refused": str(error).split(" = ")[0]}
    return {"refused": None}


@entry(
    name="speeds_whose_squares_vanish",
    title="A ball that starts at 1e-170 m/s",
    breaks="The square of a speed below 1e-162 is zero.",
    method="√(u² + 2gh)",
    fails=squares_vanish,
    source="no double holds the square: to be refused by name",
    answer=refused,
)
def _(_scene):
    return {"refused": "speed of qdot"}


# --- roots -------------------------------------------------------------------------------------------------------------------


def below_ground(scene):
    gravity = scene.posture.gravity
    heights = np.random.default_rng(1).uniform(0.1, 2.0, 10_000)
    t = np.sqrt(2 * gravity * heights) / gravity
    share = np.mean(heights - 0.5 * gravity * t * t < 0)
    h = float(dropped(scene)[0])
    landing = naive.textbook_root(h, 0.0, gravity)
    gap = h - 0.5 * gravity * landing**2
    return (
        f"h = {gap:.1e} m after the landing, and the event fires again; so in {share:.0%} of 10 000 drops",
        gap < 0,
    )


entry(
    name="landing_below_ground",
    title="A landing whose rounded root lies below the ground",
    breaks="At a rounded time of landing the gap is not zero, and where it is negative the landing comes again.",
    method="event loop that keeps h",
    fails=below_ground,
    source="geometric series",
    answer=rest,
)(ball_rest)


def lost_root(scene):
    h = scene.posture.gaps(scene.q)[0]
    u, gravity = scene.qdot[1], scene.posture.gravity
    t = naive.textbook_root(h, u, gravity)
    return f"t = {t}: the gap of {h:.0e} m is lost beside the speed", t == 0.0


def first_impact(scene):
    return {"first impact": scene.simulate().impacts["time"][0]}


@entry(
    name="a_gap_of_1e_20",
    title="Closing at 1 m/s over a gap of 1e-20 m",
    breaks="u + √(u² + 2gh) cancels where u < 0.",
    method="textbook root",
    fails=lost_root,
    source="2h/(√(u² + 2gh) − u)",
    answer=first_impact,
)
def _(scene):
    h, gravity, _ = dropped(scene)
    u = exact(scene.qdot[1])
    return {"first impact": 2 * h / (mp.sqrt(u * u + 2 * gravity * h) - u)}


def spun(scene):
    """Gap of the one contact of a spinning body, at any time, in doubles."""
    (x, y), gravity = scene.posture.contacts[0].point, scene.posture.gravity
    dx, dy = x - scene.posture.center_of_mass[0], y - scene.posture.center_of_mass[1]
    height, v, omega = scene.q[1], scene.qdot[1], scene.qdot[2]

    def gap(t, sin=np.sin, cos=np.cos, number=float):
        turn = number(omega) * t
        b, c = number(dx), number(dy)
        return (
            number(height) + number(v) * t - number(gravity) * t * t / 2
            + b * sin(turn) - c * (1 - cos(turn))
        )  # fmt: skip

    return gap


def scanned(scene):
    gap = spun(scene)
    step = 0.01
    found = naive.scan_and_bisect(gap, 1.0, step)
    first = float(spinning(scene)["first impact"])
    return (
        f"the first landing found is at {found:.4f} s; the first is at {first:.4f} s",
        found > first * (1 + 1e-6),
    )


@entry(
    name="fast_spin",
    title="A falling body that turns at 300 rad/s",
    breaks="Between two samples a foot dips below the ground and comes back.",
    method="scan every 10 ms, then bisect",
    fails=scanned,
    source="scan with 25 digits at a hundredth of a radian",
    answer=first_impact,
)
def spinning(scene):
    gap = spun(scene)

    def at(t):
        return gap(t, mp.sin, mp.cos, mpf)

    step = mpf(1) / 100 / abs(mpf(float(scene.qdot[2])))
    t = step
    while at(t) > 0:
        t += step
    return {"first impact": mp.findroot(at, (t - step, t), solver="anderson")}


# --- fixed steps -------------------------------------------------------------------------------------------------------------


def hops(scene):
    h, gravity, e, _ = ball_numbers(scene)
    step = 1e-3
    _, late = naive.semi_implicit_euler(h, 0.0, gravity, e, step, 20.0)
    cycle = gravity * step * e / (1 + e)
    return (
        f"hops for ever with up to {late:.1e} m/s, above g·dt·e/(1 + e) = {cycle:.1e}, at 20 s as at 10",
        late >= cycle * 0.5,
    )


entry(
    name="hops_for_ever",
    title="A ball that a fixed step never lets rest",
    breaks="Each step gives back what gravity adds: below g·dt the speed no longer falls.",
    method="semi-implicit Euler, gap clamped, dt = 1e-3 s",
    fails=hops,
    source="geometric series",
    answer=rest,
)(ball_rest)


def restarts(scene):
    h, gravity, e, _ = ball_numbers(scene)
    hits, t, lowest = naive.restart_loop(h, 0.0, gravity, e, limit=5.0)
    rest = float(ball_rest(scene)["elapsed"])
    if lowest < 0:
        return (
            f"{hits} impacts, then none is found any more, and the ball falls to {lowest:.0f} m",
            lowest < -1,
        )
    return (
        f"{hits} impacts, the last of them at {t:.6f} s, over and over; it should rest at {rest:.6f} s",
        hits == naive.MOST,
    )


for name, title in (
    (
        "restarted_integrator",
        "A ball and an integrator that starts again after each impact",
    ),
    ("plastic_restart", "A ball that does not rebound, e = 0"),
):
    entry(
        name=name,
        title=title,
        breaks="The event function is zero where the integration starts again: the next root is not seen, or the last one is.",
        method="`scipy.integrate.solve_ivp` with a terminal event, restarted",
        fails=restarts,
        source="geometric series",
        answer=rest,
    )(ball_rest)


def rod(scene):
    """Coupling ψ of a level rod: (L² − ρ²)/(L² + ρ²)."""
    half = exact(scene.posture.contacts[1].point[0])
    rho = exact(scene.posture.gyration_radius)
    return (half**2 - rho**2) / (half**2 + rho**2)


def slow_to_rest(scene):
    body, end = scene.posture, 0.1
    gaps, psi = body.gaps(scene.q), float(rod(scene))
    rest = float(clattering(scene)["elapsed"])
    errors = []
    for step in (1e-4, 1e-5, 1e-6):
        model = (body.gravity,) * 2, (psi,) * 2, body.restitution
        errors.append(
            abs(naive.moreau_jean(gaps, (0, 0), *model, step, end) / rest - 1)
        )
    order = math.log10(errors[0] / errors[2]) / 2
    told = ", ".join(f"{x:.1%}" for x in errors)
    return (
        f"time of rest off by {told} at dt = 1e-4, 1e-5, 1e-6 s: order {order:.2f}",
        order < 0.6,
    )


@entry(
    name="through_a_2_zeno_point",
    title="Moreau–Jean through the Zeno point of a rod",
    breaks="Infinitely many impacts within a step: the order falls below one.",
    method="Moreau–Jean, θ = 1/2, exact contact solve",
    fails=slow_to_rest,
    source="integrated impact by impact with 40 digits",
    answer=rest,
)
def clattering(scene):
    """Flight by flight of the finite rotation, with 40 digits, until the flights are below 1e-25 s."""
    body = scene.posture
    half, rho = exact(body.contacts[1].point[0]), exact(body.gyration_radius)
    gravity, e = exact(body.gravity), exact(body.restitution)

    def flight(state, side, touches):
        """Time to the landing of the end on this side."""
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


def stuck(scene):
    body = scene.posture
    gravity, psi = (body.gravity,) * 2, (float(rod(scene)),) * 2
    hits, t = naive.event_loop(
        body.gaps(scene.q), (0.0, 0.0), gravity, psi, body.restitution
    )
    end = float(nested(scene)["elapsed"])
    return (
        f"after {hits} impacts time stands still at {t:.5f} s, the first Zeno point; there are infinitely many more until {end:.5f} s",
        t < 0.95 * end,
    )


@entry(
    name="zeno_points_that_accumulate",
    title="A uniform rod, e = 0.5: Zeno points that accumulate",
    breaks="After infinitely many impacts of one end come infinitely many of the other, and so on without end.",
    method="event loop, time added up",
    fails=stuck,
    source="`benches/work_precision/scenes.py`: finite rotation in mpmath",
    answer=rest,
)
def nested(_scene):
    known = json.loads(BENCHES.read_text(encoding="utf-8"))["scenes"]["nested"]
    return {"outcome": "rest", "elapsed": mpf(known["rest"]["time"])}


# --- impacts -----------------------------------------------------------------------------------------------------------------


def cut_corner(scene):
    psi, e = float(rod(scene)), scene.posture.restitution
    rates = scene.posture.gap_rates(scene.q, scene.qdot)
    hits, _, slow = naive.corner_hits(psi, e, rates, 1e-10)
    return (
        f"{hits} impacts in one instant until all speeds are below 1e-10 m/s",
        slow and hits > 1e5,
    )


def first_zeno(scene):
    point = scene.simulate(stop="zeno").zeno_points[0]
    return {
        "elapsed": point.elapsed,
        "contacts": point.contacts,
        "method": point.method,
    }


@entry(
    name="corner_of_endless_chatter",
    title="One end of a rod hits while the other touches, e = 0.18, ψ = 0.9999",
    breaks="Infinitely many impacts in one instant, each of which leaves nearly all of the speed.",
    method="impact by impact until 1e-10 m/s",
    fails=cut_corner,
    source="Goyal's bound: (1 + e) ψ ≥ 2 √e",
    answer=first_zeno,
)
def _(scene):
    e = exact(scene.posture.restitution)
    assert (1 + e) * rod(scene) >= 2 * mp.sqrt(e)
    return {"elapsed": mpf(0), "contacts": (1, 2), "method": "chatter"}


def falsely_dead(scene):
    psi, e = float(rod(scene)), scene.posture.restitution
    rates = scene.posture.gap_rates(scene.q, scene.qdot)
    hits, _, slow = naive.corner_hits(psi, e, rates, 1e-15)
    return (
        f"after {hits} impacts all speeds are below 1e-15 m/s: called an endless chatter, which it is not",
        slow,
    )


def not_certified(scene):
    point = scene.simulate(stop="zeno").zeno_points[0]
    return {"elapsed": point.elapsed, "proved endless": point.certified}


@entry(
    name="corner_just_below_the_bound",
    title="The same at e = 0.3 and ψ = 0.84265, just below Goyal's bound",
    breaks="The number of impacts is finite, but speeds fall far below any cutoff before the last one.",
    method="impact by impact until 1e-15 m/s",
    fails=falsely_dead,
    source="impact by impact with 40 digits, no cutoff: the last speeds are below any double",
    answer=not_certified,
)
def _(scene):
    psi, e = rod(scene), exact(scene.posture.restitution)
    assert (1 + e) * psi < 2 * mp.sqrt(e)
    _, u, slow = naive.corner_hits(
        psi,
        e,
        [mpf(float(x)) for x in scene.posture.gap_rates(scene.q, scene.qdot)],
        mpf(0),
    )
    assert not slow
    assert all(x >= 0 for x in u)
    assert 0 < max(u) < mpf(5e-324)
    return {"elapsed": mpf(0), "proved endless": False}


def singular(scene):
    body = scene.posture
    rho2 = body.gyration_radius**2
    b = [k.point[0] - body.center_of_mass[0] for k in body.contacts]
    matrix = np.array([[1 + x * y / rho2 for y in b] for x in b])
    try:
        np.linalg.solve(matrix, np.array([1.0, 1.0]))
    except np.linalg.LinAlgError as error:
        return f"impulses of both: {error}", True
    return "impulses of both are found", False


entry(
    name="two_contacts_at_one_point",
    title="Two contacts at one point of the body",
    breaks="The matrix of their impulses is singular.",
    method="one linear system for all impulses",
    fails=singular,
    source="geometric series: it is a ball",
    answer=rest,
)(ball_rest)


def in_turn(scene):
    body = scene.posture
    rho2, e = body.gyration_radius**2, body.restitution
    b = [k.point[0] - body.center_of_mass[0] for k in body.contacts]
    v, omega = -1.0, 0.0
    for x in b:
        u = v + x * omega
        if u < 0:
            p = -(1 + e) * u / (1 + x * x / rho2)
            v, omega = v + p, omega + p * x / rho2
    return (
        f"hit from left to right the body leaves with {omega:.2f} rad/s, from right to left with {-omega:.2f}",
        omega != 0,
    )


def without_turning(scene):
    run = scene.simulate()
    return {"outcome": run.outcome, "elapsed": run.elapsed, "theta": run.q[2]}


@entry(
    name="three_feet_at_once",
    title="Three feet that land at the same instant",
    breaks="The order in which simultaneous impacts are taken decides the motion.",
    method="impacts one after the other",
    fails=in_turn,
    source="symmetry: it bounces like a ball",
    answer=without_turning,
    within=1e-13,
)
def _(scene):
    return {**ball_rest(scene), "theta": mpf(0)}


def called_at_rest(scene):
    h, u = (
        scene.posture.gaps(scene.q)[0],
        scene.posture.gap_rates(scene.q, scene.qdot)[0],
    )
    return f"h = {h:g}, u = {u:g}: taken for a contact at rest", h == 0 and u == 0


def lifts_off(scene):
    run = scene.simulate()
    return {"mode": run.phases[0].mode, "first impact": run.impacts["time"][0]}


@entry(
    name="lifted_by_its_own_spin",
    title="A foot that touches without speed, on a body that turns at 20 rad/s",
    breaks="h = 0 and u = 0, but the foot goes round the centre of mass: its acceleration is dω² − g > 0.",
    method="contact at rest where h = u = 0",
    fails=called_at_rest,
    source="h = −½gt² + d (1 − cos ωt), scanned with 40 digits",
    answer=lifts_off,
)
def _(scene):
    d, gravity = exact(scene.posture.center_of_mass[1]), exact(scene.posture.gravity)
    omega = exact(scene.qdot[2])
    assert d * omega**2 > gravity

    def gap(t):
        return -gravity * t * t / 2 + d * (1 - mp.cos(omega * t))

    step = mpf(1) / 1000
    t = step
    while gap(t) > 0:
        t += step
    return {
        "mode": "S",
        "first impact": mp.findroot(gap, (t - step, t), solver="anderson"),
    }


# --- friction ----------------------------------------------------------------------------------------------------------------


def never_stops(scene):
    v, gravity = float(scene.qdot[0]), scene.posture.gravity
    step = 1e-3
    left = naive.friction_by_sign(
        v, scene.posture.contacts[0].friction, gravity, step, 100_000
    )
    return (
        f"after 100 s the speed is {left:.1e} m/s, of either sign by turns",
        left != 0,
    )


@entry(
    name="sliding_to_a_stop",
    title="A block that friction stops",
    breaks="Friction has a sign until the speed is zero, and none of either sign after it.",
    method="v −= μg sign(v) dt, dt = 1e-3 s",
    fails=never_stops,
    source="v/(μg) and v²/(2μg)",
    answer=lambda scene: {**rest(scene), "x": scene.simulate().q[0]},
)
def _(scene):
    v, pull = (
        exact(scene.qdot[0]),
        exact(scene.posture.contacts[0].friction) * exact(scene.posture.gravity),
    )
    return {"outcome": "rest", "elapsed": v / pull, "x": v * v / (2 * pull)}


def divides(scene):
    h, u = float(scene.posture.gaps(scene.q)[0]), float(scene.qdot[1])
    try:
        naive.textbook_root(h, u, scene.posture.gravity)
    except ZeroDivisionError as error:
        return f"{type(error).__name__}: {error}", True
    return "a number", False


@entry(
    name="without_gravity",
    title="A body that drifts away, without gravity",
    breaks="There is no next collision, and the formula for it divides by g.",
    method="textbook root",
    fails=divides,
    source="a straight line away from the ground",
    answer=lambda scene: {"outcome": scene.simulate().outcome},
)
def _(scene):
    assert scene.posture.gravity == 0
    assert scene.qdot[1] > 0
    return {"outcome": "escape"}


def slides_on(scene):
    contact, gravity = scene.posture.contacts[0], scene.posture.gravity
    pull = gravity * (
        math.sin(contact.slope) - contact.friction * math.cos(contact.slope)
    )
    return f"still waiting after 1e6 s, at {pull * 1e6:.1e} m/s", pull > 0


@entry(
    name="a_slope_too_steep",
    title="A block on a slope of 0.3 rad with μ = 0.1",
    breaks="It never rests: a loop until rest has no end.",
    method="steps until all speeds are below a tolerance",
    fails=slides_on,
    source="g (sin φ − μ cos φ) down the slope",
    answer=lambda scene: {
        "outcome": scene.simulate().outcome,
        "acceleration": math.hypot(*scene.simulate().acceleration[:2]),
    },
)
def _(scene):
    slope, friction = (
        exact(getattr(scene.posture.contacts[0], x)) for x in ("slope", "friction")
    )
    pull = exact(scene.posture.gravity) * (mp.sin(slope) - friction * mp.cos(slope))
    return {"outcome": "sliding", "acceleration": pull}


def no_edge(scene):
    end = scene.posture.contacts[0].segment[1]
    return (
        f"slides on at {scene.qdot[0]:g} m/s for ever, {end:g} m of ground behind it",
        math.isfinite(end),
    )


@entry(
    name="over_the_edge",
    title="A foot that slides off its terrain",
    breaks="Ground has an end; the contact must end with it.",
    method="contact with an unbounded line",
    fails=no_edge,
    source="the way to the end over the speed",
    answer=lambda scene: {
        "outcome": scene.simulate().outcome,
        "leaves": scene.simulate().phases[0].end,
    },
)
def _(scene):
    way = exact(scene.posture.contacts[0].segment[1])
    return {"outcome": "escape", "leaves": way / exact(scene.qdot[0])}


def painleve(scene):
    """Of a rod that slides on one end: a_n per force, and a_n without force."""
    body = scene.posture
    (x, y), (cx, cy) = body.contacts[0].point, body.center_of_mass
    b, c = x - cx, y - cy
    way = math.copysign(1.0, scene.qdot[0] - c * scene.qdot[2])
    friction = body.contacts[0].friction
    slope = 1 + b * (b + way * friction * c) / body.gyration_radius**2
    return slope, -body.gravity - c * scene.qdot[2] ** 2


def negative_force(scene):
    slope, free = painleve(scene)
    force = -free / slope
    return (
        f"λ = {force:.1f} m/s² per unit mass: the ground pulls the rod down",
        force < 0,
    )


def words(scene):
    modes = sf.contact_modes(scene.posture, scene.q, scene.qdot)
    return {
        "status": modes.status,
        "words": tuple(sorted(str(word) for word in modes.consistent)),
        "outcome": scene.simulate(impact="newton").outcome,
    }


@entry(
    name="painleve_without_a_mode",
    title="Painlevé's rod where no contact mode is consistent",
    breaks="Sliding needs a negative force, and leaving the ground an acceleration into it.",
    method="a_n = 0 solved for the force of sliding",
    fails=negative_force,
    source="signs of a_n and of its slope in the force, with exact arms",
    answer=words,
)
def _(scene):
    slope, free = painleve(scene)
    assert slope < 0
    assert free < 0
    return {"status": "none", "words": (), "outcome": "inconsistent"}


def only_one(scene):
    slope, free = painleve(scene)
    force = -free / slope
    return (
        f"λ = {force:.1f} m/s² per unit mass is taken; that leaving the ground is consistent as well (a_n = {free:.1f} m/s²) is not said",
        force > 0 and free > 0,
    )


@entry(
    name="painleve_with_two_modes",
    title="Painlevé's rod where two contact modes are consistent",
    breaks="A solver that returns one answer does not say that there are others.",
    method="a_n = 0 solved for the force of sliding",
    fails=only_one,
    source="signs of a_n and of its slope in the force, with exact arms",
    answer=words,
)
def _(scene):
    slope, free = painleve(scene)
    assert slope < 0
    assert free > 0
    way = "R" if scene.qdot[0] - scene.qdot[2] * (
        scene.posture.contacts[0].point[1] - scene.posture.center_of_mass[1]
    ) > 0 else "L"  # fmt: skip
    return {
        "status": "ambiguous",
        "words": tuple(sorted(("S", way))),
        "outcome": "ambiguous",
    }
