"""Fixed steps, and integrators with restarts."""

from . import baseline_methods, peers
from .entry import Family, ball_numbers, ball_rest, rest

FAMILY = Family("Steps and restarts")
entry = FAMILY.entry


def hops(scene):
    h, gravity, e, _ = ball_numbers(scene)
    step = 1e-3
    _, late = baseline_methods.semi_implicit_euler(h, 0.0, gravity, e, step, 20.0)
    cycle = gravity * step * e / (1 + e)
    return (
        f"the ball hops for ever with up to {late:.1e} m/s, above g·dt·e/(1 + e) = {cycle:.1e}, at 20 s as at 10 s",
        late >= cycle * 0.5,
    )


entry(
    name="hops_for_ever",
    title="A ball that never rests with a fixed step",
    breaks="In each step the impact returns the speed that gravity adds: below g·dt the speed no longer decreases.",
    method="semi-implicit Euler, gap clamped, dt = 1e-3 s",
    fails=hops,
    source="geometric series",
    answer=rest,
)(ball_rest)


def restarts(scene):
    h, gravity, e, _ = ball_numbers(scene)
    hits, t, lowest = baseline_methods.restart_loop(h, 0.0, gravity, e, limit=5.0)
    rest = float(ball_rest(scene)["elapsed"])
    if lowest < 0:
        return (
            f"{hits} impacts, then none is found any more, and the ball falls to {lowest:.0f} m",
            lowest < -1,
        )
    return (
        f"{hits} impacts, the last of them at {t:.6f} s, again and again; the ball should rest at {rest:.6f} s",
        hits == baseline_methods.MOST,
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
        breaks="The event function is zero where the integration restarts: the next root is missed, or the last root is found again.",
        method="`scipy.integrate.solve_ivp` with a terminal event, restarted",
        fails=restarts,
        source="geometric series",
        answer=rest,
    )(ball_rest)


def falls_through(scene):
    steps = (1 / 60, 1e-2)
    heights = [peers.simulate("pymunk_space", scene, step, 1.0)[0][1] for step in steps]
    return (
        f"after 1 s the ball is at a height of {heights[0]:.0f} m with 60 steps a second, and of {heights[1]:.0f} m with 100 steps",
        max(heights) < -100,
    )


entry(
    name="fast_fall",
    title="A ball thrown down at 300 m/s",
    breaks="Within one step the ball passes from above the ground to below the whole floor.",
    method="pymunk, floor 2 m thick",
    needs="pymunk",
    fails=falls_through,
    source="geometric series",
    answer=rest,
)(ball_rest)


def no_rebound(scene):
    h, gravity, e, _ = ball_numbers(scene)
    steps = (1 / 60, 1e-3)
    highest = [peers.box2d_ball(h, e, gravity, step, 0.5) for step in steps]
    return (
        f"the ball rises to {highest[0]:.1g} m and {highest[1]:.1g} m with 60 and 1000 steps a second, instead of {e * e * h:.3f} m",
        max(highest) < 0.1 * e * e * h,
    )


entry(
    name="low_drop",
    title="A ball dropped from 4 cm",
    breaks="Below a threshold speed an engine treats impacts as contact without rebound.",
    method="Box2D, which has no rebound below 1 m/s",
    needs="Box2D",
    fails=no_rebound,
    source="geometric series",
    answer=rest,
)(ball_rest)
