"""Sums and times: long, short, early and late ones."""

from . import baseline_methods
from .entry import Family, ball_numbers, ball_rest, rest

FAMILY = Family("Clocks and sums")
entry = FAMILY.entry


def stalls(scene):
    _, gravity, e, v = ball_numbers(scene)
    start = scene.options["time"]
    landing = start + v / gravity
    count, end = baseline_methods.bounces_on_an_absolute_clock(
        landing, e * v, gravity, e
    )
    error = abs((end - start) / float(ball_rest(scene)["elapsed"]) - 1)
    return (
        f"the time no longer changes after {count} bounces, while the ball still moves; the error of the time of rest is {error:.1e}",
        error > 1e-14,
    )


for name, when in (("clock_at_1000", "1000 s"), ("clock_at_1e9", "1e9 s")):
    entry(
        name=name,
        title=f"A ball that bounces at {when} on the clock",
        breaks="Flights become shorter than the rounding of the absolute time.",
        method="flights added to the absolute time",
        fails=stalls,
        source="geometric series",
        answer=rest,
    )(ball_rest)


def many_bounces(scene):
    _, gravity, e, v = ball_numbers(scene)
    count, end = baseline_methods.bounces_until_slow(v / gravity, e * v, gravity, e)
    error = abs(end / float(ball_rest(scene)["elapsed"]) - 1)
    return f"{count} bounces until 1e-10 m/s, with an error of {error:.1e}", count > 1e6


entry(
    name="nearly_elastic",
    title="A ball that loses a hundred-thousandth of its speed",
    breaks="As e → 1 the number of bounces until a speed of 1e-10 of the first grows as −10/log₁₀ e, and each bounce adds a rounding error.",
    method="bounce by bounce until 1e-10 m/s",
    fails=many_bounces,
    source="geometric series",
    answer=rest,
)(ball_rest)


def at_once(scene):
    _, gravity, e, v = ball_numbers(scene)
    count, end = baseline_methods.bounces_until_slow(
        v / gravity, e * v, gravity, e, slow=1e-5
    )
    error = abs(end / float(ball_rest(scene)["elapsed"]) - 1)
    return (
        f"{count} bounces: at {v:.1e} m/s the ball counts as at rest, {error:.0%} too early",
        error > 0.1,
    )


entry(
    name="small_scale",
    title="A ball dropped from a picometre",
    breaks="Absolute tolerances in metres and seconds stop a small motion at its start.",
    method="rest below 1e-5 m/s",
    fails=at_once,
    source="geometric series",
    answer=rest,
)(ball_rest)
