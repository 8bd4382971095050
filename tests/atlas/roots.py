"""Times at which a gap is zero."""

import numpy as np
from mpmath import mp, mpf

from . import baseline_methods
from .entry import Family, ball_rest, bisect, dropped, exact, first_impact, rest

FAMILY = Family("Roots")
entry = FAMILY.entry


def below_ground(scene):
    gravity = scene.posture.gravity
    heights = np.random.default_rng(1).uniform(0.1, 2.0, 10_000)
    t = np.sqrt(2 * gravity * heights) / gravity
    share = np.mean(heights - 0.5 * gravity * t * t < 0)
    h = float(dropped(scene)[0])
    landing = baseline_methods.textbook_root(h, 0.0, gravity)
    gap = h - 0.5 * gravity * landing**2
    return (
        f"h = {gap:.1e} m after the landing, and the event is found again; this happens in {share:.0%} of 10 000 drops",
        gap < 0,
    )


entry(
    name="landing_below_ground",
    title="A landing whose rounded root lies below the ground",
    breaks="At a rounded time of landing the gap is not zero. Where it is negative, the same landing is found again.",
    method="event loop that keeps the computed h",
    fails=below_ground,
    source="geometric series",
    answer=rest,
)(ball_rest)


def lost_root(scene):
    h = scene.posture.gaps(scene.q)[0]
    u, gravity = scene.qdot[1], scene.posture.gravity
    t = baseline_methods.textbook_root(h, u, gravity)
    return (
        f"t = {t}: the gap of {h:.0e} m is lost in the rounding of the speed",
        t == 0.0,
    )


@entry(
    name="a_gap_of_1e_20",
    title="Closing at 1 m/s over a gap of 1e-20 m",
    breaks="u + √(u² + 2gh) loses all digits by cancellation for u < 0.",
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
    """Gap of the only contact of a spinning body, as a function of time, in doubles."""
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
    found = baseline_methods.scan_and_bisect(gap, 1.0, step)
    first = float(spinning(scene)["first impact"])
    return (
        f"the first landing found is at {found:.4f} s; the first landing is at {first:.4f} s",
        found > first * (1 + 1e-6),
    )


@entry(
    name="fast_spin",
    title="A falling body that turns at 300 rad/s",
    breaks="Between two samples a foot goes below the ground and rises again.",
    method="scan every 10 ms, then bisect",
    fails=scanned,
    source="scan with 25 digits in steps of a hundredth of a radian",
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


def found_and_missed(scene):
    gap, end = spun(scene), scene.options["time_limit"]
    found = baseline_methods.landing_by_solve_ivp(gap, end)
    first = float(grazing(scene)["first impact"])
    return (
        f"a landing is found at {found:.4f} s; at {first:.4f} s the foot was already {-float(deepest(scene)):.0e} m below the ground",
        found > first * (1 + 1e-6),
    )


def taken_for_touching(scene):
    gap = spun(scene)
    found = baseline_methods.scan_and_bisect(lambda t: gap(t) - 1e-9, 0.4, 1e-6)
    first = float(grazing(scene)["first impact"])
    return (
        f"a landing at {found:.4f} s, where the foot is {gap(found):.0e} m above the ground; it lands at {first:.4f} s",
        found < first * (1 - 1e-6),
    )


def lows(scene):
    """Gap of the foot with 40 digits, and the times of its first two lowest points, where the rate changes from − to +."""
    gap, turn = spun(scene), mp.pi / mpf(float(scene.qdot[2]))

    def at(t):
        return gap(t, mp.sin, mp.cos, mpf)

    def falling(t):
        return -mp.diff(at, t)

    half = mpf(1) / 2
    return at, [bisect(falling, (k - half) * turn, (k + half) * turn) for k in (1, 3)]


def deepest(scene):
    """The gap that is nearest to zero among the lowest points."""
    at, points = lows(scene)
    return min((at(t) for t in points), key=abs)


def grazing(scene):
    """The first change of sign on a grid of a twentieth of a radian that includes the lowest points, refined by bisection."""
    at, points = lows(scene)
    step = 1 / (20 * exact(scene.qdot[2]))
    grid = sorted([*points, *(k * step for k in range(1, 500))])
    k = next(k for k, t in enumerate(grid) if at(t) < 0)
    return {"first impact": bisect(at, grid[k - 1], grid[k])}


def flat_root(scene):
    """Allowed error of the time of a root: the rounding error of the gap, 2⁻⁵³ of the initial height, divided by the
    rate of the gap."""
    at, _ = lows(scene)
    t = grazing(scene)["first impact"]
    moved = 2 * mpf(2) ** -53 * exact(scene.q[1]) / abs(mp.diff(at, t))
    return {"first impact": float(moved / t) + 4e-15}


for name, title, method, fails in (
    (
        "grazed_by_1e_12",
        "A foot that turns at 40 rad/s and grazes the ground by 1e-12 m",
        "`scipy.integrate.solve_ivp` with an event, steps of at most 1 ms",
        found_and_missed,
    ),
    (
        "missed_by_1e_12",
        "The same, but for 2e-12 m: it misses the ground",
        "scan every 1e-6 s, below 1e-9 m is contact",
        taken_for_touching,
    ),
):
    entry(
        name=name,
        title=title,
        breaks="There are two roots close together, or no root. A tolerance on the gap decides the motion.",
        method=method,
        fails=fails,
        source="lowest points of the arc and bisection with 40 digits",
        answer=first_impact,
        within=flat_root,
    )(grazing)
