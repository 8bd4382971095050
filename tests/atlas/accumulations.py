"""Impacts that accumulate."""

import json
import math
from pathlib import Path

from mpmath import mp, mpf

from . import naive
from .entry import Family, exact, rest, rod

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
