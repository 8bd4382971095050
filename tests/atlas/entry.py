"""The type of an entry of the atlas, and helper functions that several entries use."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, localcontext
from functools import cached_property
from pathlib import Path

import standfast as sf
from mpmath import mp, mpf

from . import baseline_methods

SCENES = Path(__file__).parent / "scenes"
DIGITS = 40
#: Additional digits of decimal numbers, compared with mpmath.
MORE = 5
#: Some rounding errors of the scene's numbers and of intermediate results.
WITHIN = 4e-15


@dataclass(eq=False)
class Entry:
    """One scene. Its exact result, the failure and the answer are computed once, with the digits of the exact results."""

    name: str
    title: str
    #: The difficulty, in a sentence.
    breaks: str
    #: The method that fails; its result, and whether that is wrong.
    method: str
    fails: Callable[[sf.Scene], tuple[str, bool]]
    #: The source of the exact result, and the result: name → number (within `within`) or any other value (equal).
    source: str
    truth: Callable[[sf.Scene], dict]
    answer: Callable[[sf.Scene], dict]
    #: Allowed relative errors of numbers, by name, if not `WITHIN`; absolute where the exact result is zero.
    within: Callable[[sf.Scene], dict[str, float]] | None = None
    #: A module that the method needs and that may not be installed.
    needs: str | None = None

    @property
    def scene(self):
        return sf.load(str(SCENES / f"{self.name}.toml"))

    @cached_property
    def failure(self):
        with mp.workdps(DIGITS):
            return self.fails(self.scene)

    @cached_property
    def right(self):
        with mp.workdps(DIGITS):
            return self.truth(self.scene)

    @cached_property
    def answered(self):
        with mp.workdps(DIGITS):
            return self.answer(self.scene)

    @cached_property
    def allowed(self):
        """Allowed error of each number."""
        with mp.workdps(DIGITS):
            other = self.within(self.scene) if self.within else {}
        return dict.fromkeys(self.errors, WITHIN) | other

    @cached_property
    def errors(self):
        """Errors of the numbers: relative, or absolute where the exact result is zero."""
        with mp.workdps(DIGITS):
            return {
                name: abs(mpf(float(self.answered[name])) - value) / (abs(value) or 1)
                for name, value in self.right.items()
                if isinstance(value, mpf)
            }


class Family(list[Entry]):
    """Entries with one kind of difficulty, in the order of the page."""

    def __init__(self, title):
        super().__init__()
        self.title = title

    def entry(self, **fields):
        """Adds the entry whose exact result is the decorated function."""

        def add(truth):
            self.append(Entry(truth=truth, **fields))
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


def refused(scene):
    try:
        scene.simulate()
    except ValueError as error:
        return {"refused": str(error).split(" = ")[0]}
    return {"refused": None}


def first_impact(scene):
    return {"first impact": scene.simulate().impacts["time"][0]}


def rod(scene):
    """Coupling ψ of a level rod: (L² − ρ²)/(L² + ρ²)."""
    half = exact(scene.posture.contacts[1].point[0])
    rho = exact(scene.posture.gyration_radius)
    return (half**2 - rho**2) / (half**2 + rho**2)


def integrated(*names):
    """The allowed relative error of the times and angles of a run that is integrated numerically."""
    return lambda _: dict.fromkeys(names, 1e-12)


def first_zeno(scene):
    point = scene.simulate(stop="zeno").zeno_points[0]
    return {
        "elapsed": point.elapsed,
        "contacts": point.contacts,
        "method": point.method,
    }


def decimals():
    """The decimal context for the digits of mpmath."""
    return localcontext(prec=mp.dps + MORE)


def decimal(value):
    """A number of mpmath with all its digits and some more. Decimal numbers are faster in long sums."""
    return Decimal(mp.nstr(mpf(value), mp.dps + MORE))


def time_left(state, gravity, psi, e, least):
    """Time of all later impacts of a level rod, divided by the speed of the last impact. Impacts are computed one by
    one until they are this small."""
    with decimals():
        v, y, gravity, psi, e = map(decimal, (*state, gravity, psi, e))
        impacts = baseline_methods.impacts_up_to_scale(
            (v, y), gravity, psi, e, Decimal.sqrt
        )
        total, size, least = Decimal(0), Decimal(1), decimal(least)
        for _, factor, t in impacts:
            total, size = total + size * t, size * factor
            if size < least:
                return mpf(total)
    return None


def dropped_rod(low, high, gravity, psi, e, least):
    """Time of rest of a level rod at rest, its ends at these heights, geometry frozen: the first landing, and all impacts after it."""
    u = mp.sqrt(2 * gravity * low)
    state = (-u - (1 + e) * psi * u) / (e * u), (high - low) / (e * u) ** 2
    return u / gravity + e * u * time_left(state, gravity, psi, e, least)


def bisect(f, low, high):
    """Root of f from + to −, to all digits."""
    assert f(low) > 0 > f(high)
    for _ in range(mp.prec + 10):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) > 0 else (low, middle)
    return high
