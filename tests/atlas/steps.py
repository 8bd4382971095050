"""Fixed steps, and integrators that start again."""

from . import naive
from .entry import Family, ball_numbers, ball_rest, rest

FAMILY = Family("Steps and restarts")
entry = FAMILY.entry


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
