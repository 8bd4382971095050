"""Effect of difficulty on the results: `python -m atlas.difficulty` in `tests` draws docs/difficulty.png.

The scenes form families with a parameter that tends to a limit. For each family the figure has the error of the computed
time; the change of the exact time if the numbers of the scene change by a rounding error (the ratio of the two is the backward
error, in units of these rounding errors); and the number of impacts simulated one by one. The error and the number of impacts
are also given for a usual method. A mark shows the parameter from which on the package refuses, or states that its result is
not proved."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib
import numpy as np
import standfast as sf
from matplotlib import pyplot as plt
from matplotlib.ticker import NullLocator
from mpmath import mp, mpf

from . import baseline_methods
from .entry import DIGITS, bisect, dropped_rod, exact, time_to_rest
from .wedge import Wedge

PICTURE = Path(__file__).parents[2] / "docs" / "difficulty.png"
GRAVITY, HALF = 9.81, 0.5
ROUNDING = mpf(2) ** -53
matplotlib.use("Agg")
#: Errors are drawn between these limits: exact, and no result.
LEAST, MOST = 1e-18, 1.0
#: Number of impacts after which a usual method is stopped.
PATIENCE = 1_000_000


@dataclass
class Point:
    """One scene of a family; None: no answer."""

    x: float
    #: Relative error of the time that the family computes.
    error: float | None
    #: Sum of the changes of the exact result when each of the scene's numbers changes by a rounding.
    limit: float
    impacts: int | None
    proved: bool = True
    baseline_error: float | None = None
    baseline_impacts: int | None = None


@dataclass
class Family:
    title: str
    x: str
    #: Name of the usual method.
    method: str
    points: Callable[[], Iterator[Point]]
    #: Whether x increases with difficulty; otherwise it decreases.
    grows: bool = False
    #: Whether the axis of x is logarithmic.
    logarithmic: bool = True
    #: Label where a result is not proved or not given.
    cannot: str = "not proved"


def conditioned(truth, **numbers):
    """An exact result, and the sum of its relative changes when each input is reduced by one rounding error. Inputs are reduced
    and not increased, so that all of them stay within their ranges."""
    given = {name: mpf(value) for name, value in numbers.items()}
    right = truth(**given)
    moved = (truth(**given | {name: x * (1 - ROUNDING)}) for name, x in given.items())
    return right, float(sum(abs(other / right - 1) for other in moved))


def off(found, right):
    return None if found is None else float(abs(mpf(float(found)) / right - 1))


def ball(e, gravity=GRAVITY):
    return sf.Posture(1.0, 0.3, (0.0, 0.1), [sf.Contact((0.0, 0.0))], e, gravity)


def rod(psi, e, gravity=GRAVITY):
    """A level rod with this coupling of its ends, and its radius of gyration."""
    rho = HALF * math.sqrt((1 - psi) / (1 + psi))
    body = sf.Posture.rod(
        half_length=HALF,
        gyration_radius=rho,
        restitution=e,
        friction=0.0,
        gravity=gravity,
    )
    return body, rho


def coupling(rho):
    return (mpf(HALF) ** 2 - rho**2) / (mpf(HALF) ** 2 + rho**2)


def decades(first, last, each=1):
    count = round(abs(last - first) * each)
    return (10.0 ** (first + (last - first) * k / count) for k in range(count + 1))


# The families.


def elastic():
    for left in (*decades(-1, -15), 2.0**-53):
        e = 1 - left
        run = sf.simulate(ball(e), (0, 1, 0), (0, 0, 0))
        right, limit = conditioned(
            lambda h, gravity, e: time_to_rest(h, gravity, e, mpf(0)),
            h=1.0,
            gravity=GRAVITY,
            e=e,
        )
        found = Point(1 - e, off(run.elapsed, right), limit, len(run.impacts))
        if -math.log(1e10) / math.log(e) < 3 * PATIENCE:
            v = math.sqrt(2 * GRAVITY)
            count, t = baseline_methods.bounces_until_slow(
                v / GRAVITY, e * v, GRAVITY, e
            )
            found.baseline_error, found.baseline_impacts = off(t, right), count
        yield found


def falling_rod(rho, e, gravity, y, theta):
    """Time of the first Zeno point of a level rod dropped with one end lower, geometry frozen."""
    low, high = y - theta / 2, y + theta / 2
    return dropped_rod(low, high, gravity, coupling(rho), e, mpf(10) ** -22)


def rod_point(x, psi, e, y, theta):
    body, rho = rod(psi, e)
    run = sf.simulate(body, (0, y, theta), (0, 0, 0), model="local", stop="zeno")
    right, limit = conditioned(
        falling_rod, rho=rho, e=e, gravity=GRAVITY, y=y, theta=theta
    )
    (zeno,) = run.zeno_points
    return Point(x, off(zeno.elapsed, right), limit, len(run.impacts), zeno.certified)


def clattering():
    e = 0.2
    bound = sf.theory.clattering_bound(e)
    for margin in decades(-1, -15):
        psi = bound * (1 + margin)
        found = rod_point(margin, psi, e, 0.011, 0.002)
        if margin > 1e-7:
            u = math.sqrt(2 * GRAVITY * 0.01)
            state = -(1 + (1 + e) * psi) / e, 0.002 / (e * u) ** 2
            found.baseline_impacts, _ = (
                baseline_methods.impacts_until_gravity_is_negligible(
                    state, GRAVITY, psi, e, 1e-10, PATIENCE
                )
            )
        yield found


def left_corner(psi, e, gravity):
    """Time of the next landing after end 2 has hit with 1 m/s while end 1 touches, in closed form: n impacts, with speeds
    e^(k/2) sin(kf)/sin f."""
    angle = mp.acos((1 + e) * psi / (2 * mp.sqrt(e)))
    n = mp.ceil(mp.pi / angle) - 1
    last = e ** ((n + 1) / 2) * mp.sin(n * angle)
    other = -(e ** (n / 2)) * mp.sin((n + 1) * angle)
    return 2 * min(last, other) / mp.sin(angle) / gravity


def corners():
    e = 0.99
    bound = 2 * math.sqrt(e) / (1 + e)
    for margin in decades(-1, -12):
        body, rho = rod(bound * (1 - margin), e)
        start = (0, 0, 0), (0, -0.5, -1)
        run = sf.simulate(body, *start, model="local", stop="zeno")
        landings = run.impacts["time"][run.impacts["time"] > 0]
        if not landings.size:
            yield Point(margin, None, math.nan, None)
            continue
        # The limit includes the rounding of ψ as computed from ρ.
        right, limit = conditioned(
            left_corner, psi=coupling(mpf(rho)), e=e, gravity=GRAVITY
        )
        hits, _, _ = baseline_methods.corner_hits(
            float(coupling(mpf(rho))), e, [0.0, -1.0], 0.0
        )
        simulated = int((run.impacts["time"] == 0).sum())
        yield Point(
            margin, off(landings[0], right), limit, simulated, baseline_impacts=hits
        )


def touchdown(y, arm, omega, gravity):
    """First landing of a foot that starts below a centre of mass at rest, `y` above the ground, and rotates about it. It
    lands in the first revolution whose lowest point is below the ground. These points fall from revolution to revolution."""

    def at(t):
        return y - gravity * t * t / 2 + arm * (1 - mp.cos(omega * t))

    def falling(t):
        return gravity * t - arm * omega * mp.sin(omega * t)

    def lowest(turn):
        return bisect(
            falling, 2 * turn * mp.pi / omega, (2 * turn + mpf(1) / 2) * mp.pi / omega
        )

    turn = mp.floor(omega * mp.sqrt(2 * y / gravity) / (2 * mp.pi)) - 1
    while turn < 1 or at(lowest(turn)) > 0:
        turn += 1
    assert turn == 1 or at(lowest(turn - 1)) > 0
    return bisect(at, (2 * turn - 1) * mp.pi / omega, lowest(turn))


def spins():
    y, arm = 1.0, 0.125
    body = sf.Posture(1.0, 0.3, (0.0, arm), [sf.Contact((0.0, 0.0))], 0.5, GRAVITY)
    for omega in decades(2, 16):
        run = sf.simulate(body, (0, y, 0), (0, 0, omega), model="full", event_limit=2)
        if not run.impacts.size:
            yield Point(omega, None, math.nan, None)
            continue
        with mp.workdps(2 * DIGITS):
            right, limit = conditioned(
                touchdown, y=y, arm=arm, omega=omega, gravity=GRAVITY
            )
            found = run.impacts["time"][0]
            point = Point(omega, off(found, right), limit, 1)

            def gap(t, omega=omega):
                return y - GRAVITY * t * t / 2 + arm * (1 - np.cos(omega * t))

            scanned = baseline_methods.scan_and_bisect(gap, 1.0, 1e-3)
            point.baseline_error = off(scanned, right)
        yield point


def clocks():
    h, e = 1.0, 0.5
    v = math.sqrt(2 * GRAVITY * h)
    right, limit = conditioned(
        lambda h, gravity, e: time_to_rest(h, gravity, e, mpf(0)),
        h=h,
        gravity=GRAVITY,
        e=e,
    )
    for start in decades(0, 16):
        run = sf.simulate(ball(e), (0, h, 0), (0, 0, 0), time=start)
        count, end = baseline_methods.bounces_on_an_absolute_clock(
            start + v / GRAVITY, e * v, GRAVITY, e
        )
        yield Point(
            start, off(run.elapsed, right), limit, len(run.impacts),
            baseline_error=off(end - start, right), baseline_impacts=count + 1,
        )  # fmt: skip


def speeds():
    e = 0.5
    for u in decades(-180, 180, 0.1):
        point = Point(u, None, math.nan, None)
        try:
            run = sf.simulate(ball(e), (0, 0, 0), (0, u, 0))
        except ValueError:
            pass
        else:
            right, point.limit = conditioned(
                lambda u, gravity, e: 2 * u / gravity / (1 - e),
                u=u,
                gravity=GRAVITY,
                e=e,
            )
            point.error, point.impacts = off(run.elapsed, right), len(run.impacts)
        landing = baseline_methods.textbook_root(0.0, u, GRAVITY)
        point.baseline_error = min(off(landing, 2 * exact(u) / exact(GRAVITY)), MOST)
        yield point


def gaps():
    for h in decades(0, -300, 0.1):
        run = sf.simulate(ball(0.5), (0, h, 0), (0, -1, 0))
        right, limit = conditioned(
            lambda h, u, gravity: 2 * h / (mp.sqrt(u * u + 2 * gravity * h) - u),
            h=h,
            u=-1.0,
            gravity=GRAVITY,
        )
        yield Point(
            h, off(run.impacts["time"][0], right), limit, 1,
            baseline_error=off(baseline_methods.textbook_root(h, -1.0, GRAVITY), right),
        )  # fmt: skip


def chaotic():
    for k in range(25):
        e = 0.1 + 0.035 * k
        with mp.workdps(250):
            yield rod_point(e, 0.22, e, 0.011, 0.01)


def slid(slope, rho, height, one, two, end, gravity):
    """Time at which a body that slides down from rest on a slope and on level ground reaches the end of the slope."""
    slide = Wedge((slope, mpf(0)), ((one, -height), (two, -height)), rho, gravity)
    # At that distance the displacement is nearly linear in θ.
    first = slide.downhill() * end * slope
    theta = mp.findroot(
        lambda theta: (abs(slide.way(theta, 0)) - end) / end,
        (first / 4, first / 2),
        tol=mpf(10) ** -30,
    )
    return slide, theta


def wedges():
    rho, height, one, two = 0.25, 0.5, 0.75, -2.25
    for slope in decades(-1, -15):
        end = 0.5 / slope
        body = sf.Posture(
            1.0, rho, (0.0, height),
            [
                sf.Contact((one, 0.0), slope=slope, segment=(-end, end)),
                sf.Contact((two, 0.0)),
            ],
            0.0, GRAVITY,
        )  # fmt: skip
        run = sf.simulate(body, (0, 0, 0), (0, 0, 0), model="full", event_limit=100_000)

        def truth(**numbers):
            slide, theta = slid(**numbers)
            return slide.time(theta)

        numbers = {
            "slope": slope, "rho": rho, "height": height, "one": one, "two": two,
            "end": end, "gravity": GRAVITY,
        }  # fmt: skip
        right, limit = conditioned(truth, **numbers)
        slide, _ = slid(**{name: mpf(x) for name, x in numbers.items()})
        stepped = baseline_methods.steps_along_a_wedge(
            slide, 0, end, float(right) / 500, 1000
        )
        ours = None if run.outcome == "rest" else off(run.phases[0].end, right)
        yield Point(
            slope, ours, limit, None,
            baseline_error=MOST if stepped is None else min(off(stepped, right), MOST),
        )  # fmt: skip


FAMILIES = (
    Family("A ball as e → 1", "1 − e", "bounce by bounce to 1e-10 m/s", elastic),
    Family("Clattering near bound (10), e = 0.2", "ψ / bound − 1", "impacts until gravity is negligible", clattering),
    Family("A corner near Goyal's bound, e = 0.99", "1 − ψ / bound", "impacts one by one", corners,
           cannot="rest, not proved"),
    Family("First landing of a fast spin", "ω / (rad/s)", "scan every 1 ms", spins, grows=True,
           cannot="ends: too many turns"),
    Family("A ball dropped late in the day", "time of the start / s", "flights added to the time", clocks, grows=True),
    Family("A ball thrown up at any speed", "speed / (m/s)", "textbook root", speeds, grows=True, cannot="refused"),
    Family("A gap closed at 1 m/s", "gap / m", "textbook root", gaps),
    Family("Ground parallel but for an angle", "angle / rad", "Runge–Kutta steps by the forces", wedges,
           cannot="counted as level"),
    Family("Clattering and chaos, ψ = 0.22", "e", "", chaotic, grows=True, logarithmic=False),
)  # fmt: skip

OURS, USUAL, SHADE = "#0072B2", "#D55E00", "0.88"  # Okabe and Ito's blue and vermilion
DOTS = {"color": OURS, "marker": "o", "markersize": 4, "linestyle": ""}
USUALLY = {"color": USUAL, "marker": "^", "markersize": 4, "linewidth": 1}


def drawn(error):
    return min(max(error, LEAST), MOST)


def draw(family, points, above, below):
    """Errors above, impacts below."""
    told = [p for p in points if p.error is not None]

    def dots(axis, get, chosen=points, **style):
        found = [(p.x, get(p)) for p in chosen if get(p) is not None]
        if found:
            axis.plot(*zip(*found, strict=True), **style)

    limits = [drawn(p.limit) for p in told]
    above.fill_between([p.x for p in told], LEAST, limits, color=SHADE, linewidth=0)
    dots(above, lambda p: p.baseline_error and drawn(p.baseline_error), **USUALLY)
    dots(below, lambda p: p.baseline_impacts, **USUALLY)
    for proved, fill in ((True, OURS), (False, "white")):
        chosen = [p for p in told if p.proved is proved]
        dots(above, lambda p: drawn(p.error), chosen, **DOTS, markerfacecolor=fill)
        dots(below, lambda p: p.impacts, chosen, **DOTS, markerfacecolor=fill)
    for axis in (above, below):
        axis.set(yscale="log", xscale="log" if family.logarithmic else "linear")
        axis.margins(x=0.04)
        for first, last in silent(points):
            axis.axvspan(first, last, color=OURS, alpha=0.15, linewidth=0)
        axis.grid(True, color="0.93", linewidth=0.6)
        axis.set_axisbelow(True)
        if family.logarithmic:
            axis.set_xticks(ticks([p.x for p in points]))
            axis.xaxis.set_minor_locator(NullLocator())
        if not family.grows:
            axis.invert_xaxis()
    for first, last in silent(points):
        middle = math.sqrt(first) * math.sqrt(last)
        above.text(
            middle,
            1e-9,
            family.cannot,
            fontsize=8,
            color=OURS,
            ha="center",
            va="center",
            rotation=90,
        )
    above.set_ylim(LEAST / 3, 3e4)
    above.set_yticks([1e-18, 1e-12, 1e-6, 1])
    backward = max(p.error / p.limit for p in told)
    above.set_title(family.title, fontsize=10, pad=18)
    above.text(
        0.5,
        1.02,
        f"backward error at most {backward:.1f} roundings",
        transform=above.transAxes,
        fontsize=8,
        color="0.35",
        ha="center",
    )
    above.tick_params(labelbottom=False)
    below.set_ylim(0.5, 3e7)
    below.set_xlabel(family.x, fontsize=9)
    below.set_xlim(above.get_xlim())
    if family.method:
        above.plot([], [], **USUALLY, label=family.method)
        above.legend(loc="upper left", fontsize=8, frameon=False, handlelength=1.5)


def ticks(values):
    """About four powers of ten, with exponents that are multiples of a round number."""
    low, high = (round(math.log10(f(values))) for f in (min, max))
    step = next(s for s in (1, 2, 3, 5, 10, 20, 50, 100) if high - low <= 5 * s)
    return [10.0**k for k in range(-(-low // step) * step, high + 1, step)]


def silent(points):
    """Range of the parameter in which there are no results."""
    found = []
    for before, p in zip([None, *points], points, strict=False):
        if p.error is None:
            if before is None or before.error is not None:
                found.append([p.x, p.x])
            found[-1][1] = p.x
    return found


def picture(measured):
    figure = plt.figure(figsize=(11, 14), layout="constrained")
    outer = figure.add_gridspec(4, 3, height_ratios=(1, 1, 1, 0.28))
    for k, (family, points) in enumerate(measured):
        inner = outer[k // 3, k % 3].subgridspec(
            2, 1, height_ratios=(2.2, 1), hspace=0.04
        )
        above = figure.add_subplot(inner[0])
        below = figure.add_subplot(inner[1])
        draw(family, points, above, below)
        if k % 3 == 0:
            above.set_ylabel("relative error of the time", fontsize=9)
            below.set_ylabel("impacts", fontsize=9)
    key = figure.add_subplot(outer[3, :])
    key.axis("off")
    key.plot([], [], **DOTS, label="standfast, proved")
    key.plot(
        [],
        [],
        **DOTS,
        markerfacecolor="white",
        label="standfast, says that it is not proved",
    )
    key.plot([], [], **USUALLY, label="the usual method named in the panel")
    key.fill_between(
        [],
        [],
        color=SHADE,
        label="conditioning limit: what roundings\nof the scene's numbers do to the truth",
    )
    key.axvspan(
        0, 0, color=OURS, alpha=0.15, label="what standfast tells instead of an answer"
    )
    key.legend(
        loc="center",
        fontsize=9,
        frameon=False,
        ncols=2,
        title="Difficulty grows to the right",
    )
    figure.savefig(PICTURE, dpi=100)


def main():
    with mp.workdps(DIGITS):
        picture([(family, list(family.points())) for family in FAMILIES])


if __name__ == "__main__":
    main()
