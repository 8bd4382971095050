"""Terrain with ends and vertices."""

import math

from mpmath import mp, mpf

from . import baseline_methods
from .entry import Family, exact, first_impact, rest
from .wedge import Wedge

FAMILY = Family("Terrain")
entry = FAMILY.entry


def no_edge(scene):
    end, gravity = scene.posture.contacts[0].segment[1], scene.posture.gravity
    x, height = baseline_methods.on_a_line(float(scene.qdot[0]), gravity, 1e-3, 1.0)
    return (
        f"after 1 s the foot is at a height of {height:g} m, {x - end:.2f} m beyond the end of the ground",
        x > end and height == 0,
    )


@entry(
    name="over_the_edge",
    title="A foot that slides off its terrain",
    breaks="The ground has an end, and the contact must end there.",
    method="contact with an unbounded line",
    fails=no_edge,
    source="distance to the end divided by the speed",
    answer=lambda scene: {
        "outcome": scene.simulate().outcome,
        "leaves": scene.simulate().phases[0].end,
    },
)
def _(scene):
    way = exact(scene.posture.contacts[0].segment[1])
    return {"outcome": "escape", "leaves": way / exact(scene.qdot[0])}


def piece(scene, k):
    """Length along x and rise of the k-th piece of terrain."""
    (x0, y0), (x1, y1) = scene.posture.terrain[k : k + 2]
    return x1 - x0, y1 - y0


def kept_on_the_ground(scene):
    run, fall = piece(scene, 1)
    edge, v = -scene.posture.contacts[0].point[0], float(scene.qdot[0])

    def ground(x):
        return fall / run * max(0.0, x - edge)

    gravity, t = scene.posture.gravity, edge / v + 0.2
    above = baseline_methods.on_the_ground(ground, v, gravity, 1e-3, t)
    flies = -gravity * 0.2**2 / 2 - ground(v * t)
    return (
        f"{t - edge / v:g} s after the vertex the foot is {above:g} m above the ground, instead of {flies:.2f} m",
        above < 0.5 * flies,
    )


@entry(
    name="over_a_vertex",
    title="A foot that slides over a vertex from which the ground falls away",
    breaks="The contact ends because the ground falls away, while its force is still positive.",
    method="the foot is put back onto the ground when it is closer than twice the distance of a step, dt = 1e-3 s",
    fails=kept_on_the_ground,
    source="distance to the vertex divided by the speed, then the parabola above the slope",
    answer=first_impact,
)
def _(scene):
    run, fall = piece(scene, 1)
    v, gravity = exact(scene.qdot[0]), exact(scene.posture.gravity)
    way = -exact(scene.posture.contacts[0].point[0])
    return {"first impact": way / v + 2 * v * mpf(-fall) / mpf(run) / gravity}


def never_settles(scene):
    run, fall = piece(scene, 0)
    slope, gravity = math.atan2(-fall, run), scene.posture.gravity
    way = math.hypot(*scene.posture.contacts[0].point)
    kept, pull = math.cos(2 * slope), gravity * math.sin(slope)
    late = baseline_methods.in_a_valley(way, pull, kept, 1e-3, 20.0)
    end = float(valley(scene)["elapsed"])
    return (
        f"between 18 and 20 s the foot still moves at up to {late:.1e} m/s; it should rest after {end:.2f} s",
        late > 1e-3,
    )


def wedge(scene):
    at = [exact(x) for x in scene.posture.center_of_mass]
    contacts = scene.posture.contacts
    return Wedge(
        slopes=tuple(exact(k.slope) for k in contacts),
        arms=tuple(
            tuple(exact(x) - y for x, y in zip(k.point, at, strict=True))
            for k in contacts
        ),
        rho=exact(scene.posture.gyration_radius),
        gravity=exact(scene.posture.gravity),
    )


def told(outcome, q, qdot):
    x, y, theta = q
    xdot, ydot, omega = qdot
    return {
        "outcome": outcome, "x": x, "y": y, "theta": theta,
        "xdot": xdot, "ydot": ydot, "omega": omega,
    }  # fmt: skip


def end(scene):
    run = scene.simulate()
    return told(run.outcome, run.q, run.qdot)


def rounded_turn(scene):
    turn = wedge(scene).acceleration_by_forces()[2]
    theta, t = nearly_parallel(scene)["theta"], exact(scene.options["time_limit"])
    mean = float(2 * theta / t**2)
    return (
        f"{turn:.1e} rad/s²; the body turns by {float(theta):.2f} rad in {float(t):.0e} s, {mean:.1e} rad/s² on average",
        abs(turn - mean) > 100 * abs(mean),
    )


@entry(
    name="nearly_parallel_ground",
    title="A body on two pieces of ground that are parallel to 1e-9 rad",
    breaks="The body is turned by the difference of two forces that nearly cancel. This difference is below their rounding.",
    method="ω̇ from the forces with a_n = 0 at both contacts",
    fails=rounded_turn,
    source="position from two linear equations for each θ, speed from the energy, time by quadrature",
    answer=end,
)
def nearly_parallel(scene):
    slide, late = wedge(scene), exact(scene.options["time_limit"])
    theta = mp.findroot(
        lambda x: slide.time(x) - late, (mpf("0.05"), mpf("0.1")), tol=mpf(10) ** -25
    )
    theta *= slide.downhill()
    (x, y), (dx, dy) = slide.place(theta)
    omega = slide.downhill() * slide.spin(theta)
    return told("time-limit", (x, y, theta), (dx * omega, dy * omega, omega))


def cut_off(_scene):
    """A foot counts as at rest in the valley below 1e-14 of its largest speed (docs/theory.md)."""
    return {"elapsed": 2e-14}


@entry(
    name="to_and_fro_in_a_valley",
    title="A foot that slides to and fro in a valley",
    breaks="Each passage of the lowest point multiplies the speed by a constant: there are infinitely many passages in finite time.",
    method="semi-implicit Euler, dt = 1e-3 s",
    fails=never_settles,
    source="geometric series: each passage multiplies the speed by cos 2α",
    answer=rest,
    within=cut_off,
)
def valley(scene):
    run, fall = (mpf(x) for x in piece(scene, 0))
    length = mp.hypot(run, fall)
    sin, kept = -fall / length, (run**2 - fall**2) / length**2
    way = mp.hypot(*map(exact, scene.posture.contacts[0].point))
    pull = exact(scene.posture.gravity) * sin
    return {
        "outcome": "rest",
        "elapsed": mp.sqrt(2 * way / pull) * (1 + 2 * kept / (1 - kept)),
    }
