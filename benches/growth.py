"""Growth of the cost with the work: number of runs, number of contacts, feet of a sole, vertices of the ground, restitution towards 1, and
closeness to the bound of clattering convergence. Runs whose end is not determined, because rounding errors have grown to the size of the
body, have open marks. `python benches/growth.py` writes docs/growth.png and docs/growth.csv; times are medians of calls from Python. With
`--draw` it draws the measured times again."""

import csv
import math
import statistics
import sys
import time
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import standfast as sf
from matplotlib.ticker import NullFormatter

DOCS = Path(__file__).parent.parent / "docs"
#: Okabe & Ito's blue, orange, green, vermilion, purple and sky blue.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9")
START = {"q": (0, 0.011, math.asin(0.002)), "qdot": (0, 0, 0)}


def seconds(call, *arguments, **options):
    """Median of several calls: at least three calls, and at least a tenth of a second in total."""
    times = []
    while len(times) < 3 or sum(times) < 0.1:
        start = time.perf_counter()
        call(*arguments, **options)
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def rod(restitution, radius=0.2):
    return sf.Posture.rod(
        half_length=0.5, gyration_radius=radius, restitution=restitution
    )


def runs():
    """Runs of one rod to rest from different starts: time per run."""
    for count in (1, 10, 100, 1000, 10_000, 100_000, 1_000_000):
        share = np.arange(count) / count
        q = np.zeros((count, 3))
        q[:, 1], q[:, 2] = 0.011, 0.002 * (0.2 + 0.8 * share)
        body = rod(0.1)
        for model in ("local", "full"):
            yield (
                model,
                count,
                seconds(sf.simulate_many, body, q, (0, 0, 0), model=model) / count,
            )
        if count <= 1000:
            yield "one by one", count, seconds(one_by_one, body, q) / count


def one_by_one(body, starts):
    return [sf.simulate(body, q, (0, 0, 0), model="full") for q in starts]


def contacts():
    """A body on n feet along an arc, dropped with a small tilt, until its first contact rests."""
    for count in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64):
        feet = [0.0] if count == 1 else np.linspace(-0.5, 0.5, count)
        body = sf.Posture(
            mass=1,
            gyration_radius=0.3,
            center_of_mass=(0, 0.4),
            contacts=[sf.Contact(point=(x, 0.0), slope=-0.3 * x) for x in feet],
            restitution=0.3,
        )

        options = {"stop": "zeno", "model": "full"}
        took = seconds(sf.simulate, body, (0, 0.01, 0.002), (0, 0, 0), **options)
        yield "first Zeno point", count, took


def feet():
    """A sole with n feet on one line, dropped with a tilt, to rest: time per impact."""
    for count in (2, 3, 4, 6, 8, 9, 12, 16, 24, 32, 48, 64):
        body = sf.Posture(
            mass=1,
            gyration_radius=0.3,
            center_of_mass=(0, 0.4),
            contacts=[
                sf.Contact(point=(x, 0.0), friction=0.3)
                for x in np.linspace(-0.5, 0.5, count)
            ],
            restitution=0.5,
        )
        start = {"q": (0, 0.5, 0.2), "qdot": (0.3, 0, 0.5), "record": False}
        impacts = sf.simulate(body, **start).collisions
        yield "feet on one line", count, seconds(sf.simulate, body, **start) / impacts


def stairs(count):
    """Level ground up to x = 20 m, and stairs down from there: `count` vertices."""
    down = [
        (20.0 + 0.1 * ((k + 1) // 2), -0.1 * ((k + 2) // 2)) for k in range(count - 2)
    ]
    return [(-50.0, 0.0), (20.0, 0.0), *down]


def hill(count):
    """A hill of `count` vertices, y = −x²/50, fine beside the body."""
    return [(x, -0.02 * x * x) for x in np.linspace(-5, 5, count)]


def vertices():
    """A box on ground with n vertices: beside stairs that it never reaches, and on a fine hill. Time per impact."""
    start = {"q": (0, 0.5, 0.2), "qdot": (0.3, 0, 0.5), "record": False}
    for name, ground in (("out of reach", stairs), ("under the body", hill)):
        for count in (4, 8, 16, 32, 64, 128, 256, 512, 1000):
            options = start | {"time_limit": 2.0 if ground is stairs else 0.8}
            body = sf.Posture.box(
                1, 0.6, restitution=0.5, friction=0.4, terrain=ground(count)
            )
            impacts = sf.simulate(body, **options).collisions
            yield name, count, seconds(sf.simulate, body, **options) / impacts


def restitutions():
    """A rod up to its first Zeno point, as a function of 1 − e."""
    for loss in 10.0 ** np.arange(-0.25, -3.6, -0.25):
        body = rod(1 - loss)
        for model in ("local", "full"):
            options = {
                "model": model,
                "stop": "zeno",
                "event_limit": 10**7,
            }
            until = sf.simulate(body, **START, **options).determined_until
            name = model if until is None else f"{model}, end not determined"
            yield (
                name,
                loss,
                seconds(sf.simulate, body, **START, record=False, **options),
            )

    # Beside the motion in which two impacts in turn repeat on a smaller scale.
    regular = {"q": (0, 0.0089, 0.0178), "qdot": (0, 0.118, -1.4765)}
    for loss in 10.0 ** np.arange(-2, -5.1, -0.25):
        for model in ("local", "full"):
            options = {"model": model, "stop": "zeno", "event_limit": 10**8}
            body = rod(1 - loss)
            if model == "local":
                run = sf.simulate(body, **regular, **options)
                assert run.determined_until is None
            took = seconds(sf.simulate, body, **regular, record=False, **options)
            yield f"{model}, regular", loss, took


def closeness():
    """A rod with e = 0.5, and ψ away from its bound by this share, on either side: L² − ρ² = ψ (L² + ρ²)."""
    bound = sf.theory.clattering_bound(0.5)
    for off in 10.0 ** np.arange(-1, -12.5, -0.5):
        for name, psi in (
            ("inside", bound * (1 + off * (1 / bound - 1))),
            ("outside", bound * (1 - off)),
        ):
            body = rod(0.5, 0.5 * math.sqrt((1 - psi) / (1 + psi)))

            options = {"model": "local", "stop": "zeno", "record": False}
            yield name, off, seconds(sf.simulate, body, **START, **options)


PANELS = [
    (runs, "runs at once, to rest", "runs", "time of one run, s"),
    (contacts, "contacts on an arc", "contacts", "time of a run, s"),
    (feet, "feet of a sole", "feet", "time of an impact, s"),
    (vertices, "vertices of the ground", "vertices", "time of an impact, s"),
    (restitutions, "restitution towards 1", "1 − e", "time of a run, s"),
    (
        closeness,
        "near the bound of clattering convergence",
        "distance of ψ from it, relative",
        "time of a run, s",
    ),
]


def measured():
    """[panel, line, parameter, seconds] of all panels."""
    return [
        [title, name, float(parameter), value]
        for measure, title, _, _ in PANELS
        for name, parameter, value in measure()
    ]


def draw(rows):
    matplotlib.use("agg")
    figure, axes = plt.subplots(2, 3, figsize=(14, 8.2), layout="constrained")
    for axis, (_, title, x, y) in zip(axes.ravel(), PANELS, strict=True):
        lines = {}
        for panel, name, parameter, value in rows:
            if panel == title:
                lines.setdefault(name, []).append((parameter, value))
        for (name, points), colour, marker in zip(
            lines.items(), COLOURS, "os^Dvx", strict=False
        ):
            open_marks = {"linestyle": "", "fillstyle": "none"} if "not" in name else {}
            axis.plot(
                *zip(*points, strict=False),
                color=colour,
                marker=marker,
                markersize=4,
                label=name,
                **open_marks,
            )
        axis.set(xscale="log", yscale="log", xlabel=x, ylabel=y)
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.set_title(title, fontsize=11)
        axis.grid(True, color="#ECECEC", linewidth=0.6)
        if len(lines) > 1:
            axis.legend(fontsize=9)
        if x.startswith(("1 − e", "distance")):
            axis.invert_xaxis()
    figure.savefig(DOCS / "growth.png", dpi=110)


def main():
    if "--draw" in sys.argv:
        with (DOCS / "growth.csv").open(newline="") as file:
            rows = [
                [panel, name, float(parameter), float(value)]
                for panel, name, parameter, value in list(csv.reader(file))[1:]
            ]
    else:
        rows = measured()
        with (DOCS / "growth.csv").open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["panel", "line", "parameter", "seconds"])
            writer.writerows(rows)
    draw(rows)


if __name__ == "__main__":
    main()
