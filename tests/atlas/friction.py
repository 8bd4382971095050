"""Sliding and its end."""

import math
from decimal import Decimal

from decimals import cos_sin
from friction_oracle import extrapolated
from mpmath import mp, mpf

from . import baseline_methods, peers
from .entry import Family, decimal, decimals, exact, integrated, rest

FAMILY = Family("Friction")
entry = FAMILY.entry


def stopped_by_friction(scene, way):
    """A block on level ground, in closed form: its time of rest, and its distance under this name."""
    v, pull = (
        exact(scene.qdot[0]),
        exact(scene.posture.contacts[0].friction) * exact(scene.posture.gravity),
    )
    return {"outcome": "rest", "elapsed": v / pull, way: v * v / (2 * pull)}


def never_stops(scene):
    v, gravity = float(scene.qdot[0]), scene.posture.gravity
    step = 1e-3
    left, turns, _ = baseline_methods.friction_by_sign(
        v, scene.posture.contacts[0].friction, gravity, step, 100_000
    )
    return (
        f"after 100 s the speed is {left:.1e} m/s and has changed its sign {turns} times",
        left != 0 and turns > 1e4,
    )


@entry(
    name="sliding_to_a_stop",
    title="A block that friction stops",
    breaks="The friction force has a sign until the speed is zero, and vanishes after that.",
    method="v −= μg sign(v) dt, dt = 1e-3 s",
    fails=never_stops,
    source="v/(μg) and v²/(2μg)",
    answer=lambda scene: {**rest(scene), "x": scene.simulate().q[0]},
)
def _(scene):
    return stopped_by_friction(scene, "x")


def slides_on(scene):
    contact, gravity = scene.posture.contacts[0], scene.posture.gravity
    pull = gravity * (
        math.sin(contact.slope) - contact.friction * math.cos(contact.slope)
    )
    step = 1e-3
    v, steps = baseline_methods.steps_until_slow(step * pull, pull, step, slow=1e-6)
    return (
        f"given up after {steps} steps of {step:g} s, at {v:.0f} m/s and accelerating",
        steps == baseline_methods.STEPS,
    )


@entry(
    name="a_slope_too_steep",
    title="A block on a slope of 0.3 rad with μ = 0.1",
    breaks="The block never rests, so that a loop until rest does not end.",
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


def toggles(scene):
    contact, gravity = scene.posture.contacts[0], scene.posture.gravity
    cos, sin = math.cos(contact.slope), math.sin(contact.slope)
    way = float(stopped(scene)["way"])
    _, turns, x = baseline_methods.friction_by_sign(
        math.hypot(*scene.qdot[:2]),
        contact.friction,
        gravity * cos,
        1e-3,
        100_000,
        gravity * sin,
    )
    return (
        f"the speed changes its sign {turns} times in 100 s, and the block creeps {way - x:.2f} m down",
        turns > 1e4 and way - x > 0.01,
    )


def rest_along(scene):
    return {**rest(scene), "way": math.hypot(*scene.simulate().q[:2])}


@entry(
    name="block_that_stops_on_a_slope",
    title="A block that slides up a slope, stops and stays",
    breaks="At the top the friction force must balance gravity; it is smaller than its largest possible value.",
    method="v −= (g sin φ + μ g cos φ sign(v)) dt, dt = 1e-3 s",
    fails=toggles,
    source="v/a and v²/(2a), a = g (μ cos φ + sin φ)",
    answer=rest_along,
)
def stopped(scene):
    slope, friction = (
        exact(getattr(scene.posture.contacts[0], x)) for x in ("slope", "friction")
    )
    assert friction > mp.tan(slope)
    v = exact(scene.qdot[0]) * mp.cos(slope) + exact(scene.qdot[1]) * mp.sin(slope)
    pull = exact(scene.posture.gravity) * (friction * mp.cos(slope) + mp.sin(slope))
    return {"outcome": "rest", "elapsed": v / pull, "way": v * v / (2 * pull)}


def creeps(scene):
    contact = scene.posture.contacts[0]
    x = peers.mujoco_block(
        contact.slope, contact.friction, scene.posture.gravity, 100.0
    )
    return f"the block creeps {x * 1e3:.0f} mm down in 100 s, and continues", abs(
        x
    ) > 1e-2


@entry(
    name="block_that_stays",
    title="A block on a slope of 10° with μ = 0.3",
    breaks="A soft contact gives a friction force only where there is sliding.",
    method="MuJoCo, its defaults",
    needs="mujoco",
    fails=creeps,
    source="|tan φ| < μ and both normal forces are positive: the block stays",
    answer=lambda scene: {
        "outcome": scene.simulate().outcome,
        "mode": scene.simulate().phases[-1].mode,
        "x": scene.simulate().q[0],
    },
)
def _(scene):
    body, contact = scene.posture, scene.posture.contacts[0]
    assert mp.tan(abs(exact(contact.slope))) < contact.friction
    low, high = sorted(k.point[0] for k in body.contacts)
    assert low < body.center_of_mass[0] < high
    return {"outcome": "rest", "mode": "FF", "x": mpf(0)}


def too_stiff(scene):
    friction, gravity = scene.posture.contacts[0].friction, scene.posture.gravity
    v = baseline_methods.friction_smoothed(
        float(scene.qdot[0]), friction, gravity, 1e-3, 1e-3, 1000
    )
    return f"the foot oscillates with up to {v:.0e} m/s", v > 1e3


@entry(
    name="friction_of_1e6",
    title="A foot with μ = 1e6",
    breaks="The foot stops within the first step.",
    method="friction smoothed by tanh(v/0.001), dt = 1e-3 s",
    fails=too_stiff,
    source="v/(μg) and v²/(2μg)",
    answer=rest_along,
)
def _(scene):
    return stopped_by_friction(scene, "way")


def jamming(scene):
    """Arm of the contact, ρ², μ, sliding direction, gravity; level ground."""
    body = scene.posture
    contact = body.contacts[0]
    arm = [
        exact(a) - exact(b)
        for a, b in zip(contact.point, body.center_of_mass, strict=True)
    ]
    rho2, friction = exact(body.gyration_radius) ** 2, exact(contact.friction)
    way = 1 if scene.qdot[0] - float(arm[1]) * scene.qdot[2] > 0 else -1
    return arm, rho2, friction, way, exact(body.gravity)


def through_the_jam(scene):
    arm, rho2, friction, way, gravity = jamming(scene)
    steps, before, force = baseline_methods.sliding_rod(
        float(scene.q[2]), float(scene.qdot[2]), [float(x) for x in arm],
        float(rho2), float(friction), way, float(gravity), 1e-4, 100_000,
    )  # fmt: skip
    return (
        f"from step {steps - 1} to step {steps} the force goes from {before:.0f} to {force:.0f} N per kg: the ground would pull",
        before > 0 > force,
    )


def stretching(scene):
    """For a slide in stretched time s, with dt = Q ds. The functions of the state: Q; the sliding velocity along its
    direction, and the height of the contact above the centre of mass; the rates of (θ, ω, t, v_x). And the state
    at the start. All in decimal numbers."""
    arm, *numbers = jamming(scene)
    dx, dy, rho2, friction, way, gravity = (decimal(x) for x in (*arm, *numbers))

    def levers(theta):
        c, s = cos_sin(theta)
        b, h = c * dx - s * dy, s * dx + c * dy
        return b, h, b + way * friction * h

    def now(y):
        b, h, lever = levers(y[0])
        return 1 + b * lever / rho2, way * (y[3] - h * y[1]), h

    def rates(_s, y):
        theta, omega, _t, _v = y
        _b, h, lever = levers(theta)
        press = gravity + h * omega**2
        left, *_ = now(y)
        return [left * omega, lever / rho2 * press, left, -way * friction * press]

    start = [decimal(x) for x in (scene.q[2], scene.qdot[2], 0, scene.qdot[0])]
    return now, rates, start


@entry(
    name="jam_during_a_slide",
    title="A rod that slides into Painlevé's paradox",
    breaks="The force of the ground grows beyond all bounds in finite time.",
    method="slide with the force that gives a_n = 0, dt = 1e-4 s",
    fails=through_the_jam,
    source="stretched time s, dt = Q ds, with Q = 1 + b(b + σμc)/ρ² → 0, to 20 digits",
    answer=lambda scene: {
        "outcome": scene.simulate().outcome,
        "time": scene.simulate().time,
        "theta": scene.simulate().q[2],
    },
    within=integrated("time", "theta"),
)
def jam(scene):
    with decimals():
        now, rates, y = stretching(scene)
        gravity, step = decimal(scene.posture.gravity), Decimal(1) / 16
        while True:
            y, before = extrapolated(rates, y, Decimal(0), step), y
            left, slip, height = now(y)
            assert slip > 0
            assert gravity + height * y[1] ** 2 > 0
            if left < Decimal(10) ** -13:
                break
        # Q decreases exponentially: the remaining time and rotation are Q over its rate, to second order in Q.
        rate = (now(before)[0] / left).ln() / step
        time, theta = y[2] + left / rate, y[0] + y[1] * left / rate
    return {"outcome": "inconsistent", "time": mpf(time), "theta": mpf(theta)}


def stop_of_a_slide(scene):
    run = scene.simulate()
    phase = run.phases[1]
    (_, _, theta), (_, _, omega) = run.at(phase.start)
    return {
        "cause": phase.cause,
        "mode": phase.mode,
        "time": phase.start,
        "theta": theta,
        "omega": omega,
    }


@entry(
    name="slide_that_stops_at_its_pole",
    title="A rod whose slide stops where its force would be infinite",
    breaks="The force grows beyond all bounds and stops the slide within 1e-12 s of the pole.",
    method="slide with the force that gives a_n = 0, dt = 1e-4 s",
    fails=through_the_jam,
    source="the same stretched time, until the slide stops",
    answer=stop_of_a_slide,
    within=integrated("time", "theta", "omega"),
)
def _(scene):
    with decimals():
        now, rates, y = stretching(scene)
        step = Decimal(1) / 1024
        while step > Decimal(10) ** -18:
            later = extrapolated(rates, y, Decimal(0), step)
            if now(later)[1] > 0:
                y = later
            else:
                step /= 4
    theta, omega, time, _ = map(mpf, y)
    # Then it slides back: in that direction the force is finite.
    return {"cause": "stop", "mode": "R", "time": time, "theta": theta, "omega": omega}
