"""Errors of Zeno times, collision times and states, compared with arbitrary precision, by family of random scenes.

`python benches/accuracy.py` writes docs/accuracy.md and docs/accuracy.png. Errors of times are in ulps of the time.
Every error is also given in units of its conditioning c: the largest change of the exact result when one input
changes by one ulp. No computation in doubles can avoid an error of about c, because inputs that differ by less than
half an ulp are the same double.
"""

import argparse
import math
import sys
from concurrent.futures import ProcessPoolExecutor
from decimal import Decimal
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "tests" / "oracles"))

import oracle  # noqa: E402
import oracle_inputs  # noqa: E402

SEED = 20081101
#: Families: how a scene is drawn, how standfast runs it, and the number of scenes in percent of the option --scenes.
FAMILIES = {
    "local model, clattering": (
        oracle_inputs.draw_local,
        oracle_inputs.simulate_local,
        100,
    ),
    "full model, sloped ground": (
        oracle_inputs.draw_full,
        oracle_inputs.simulate_full,
        40,
    ),
    "full model, fast spin": (
        oracle_inputs.draw_spinning,
        oracle_inputs.simulate_full,
        20,
    ),
}
#: Okabe & Ito's blue, orange and green.
COLOURS = ["#0072B2", "#E69F00", "#009E73"]


def judge(task):
    """Errors of one scene; None where one ulp of an input changes the verdict."""
    family, inputs = task
    truth, change = oracle.orbit(inputs), oracle.sensitivity(inputs)
    if not change.verdict_stable:
        return None
    run = FAMILIES[family][1](inputs)
    found, zeno = run.zeno_points[0], truth.zeno
    exact = float(zeno.time)
    off = float(abs(Decimal(found.elapsed) - zeno.time))
    errors = {
        "Zeno time, ulp": off / math.ulp(exact),
        "Zeno time, c": off / change.largest("time"),
    }
    # A rate near zero still has the rounding errors of the speeds from which it is computed.
    speeds = [abs(float(u)) for c in truth.collisions for u in (*c.before, *c.after)]
    rounding = sys.float_info.epsilon * max(speeds, default=0.0)
    turning = (
        rounding / inputs["rho"] if "rho" in inputs else rounding * most_turning(inputs)
    )
    state = {"omega": (found.omega, turning)}
    state |= {f"u{i + 1}": (rate, rounding) for i, rate in enumerate(found.gap_rates)}
    parts = [
        float(abs(Decimal(float(value)) - zeno.state[name]))
        / max(change.largest(name), least)
        for name, (value, least) in state.items()
        if max(change.largest(name), least) > 0
    ]
    if parts:
        errors["velocities there, c"] = max(parts)
    times = run.impacts["elapsed"]
    offs = [
        float(abs(Decimal(float(mine)) - other.time)) / math.ulp(float(other.time))
        for mine, other in zip(times, truth.collisions, strict=False)
    ]
    if offs:
        errors["collision times, ulp"] = max(offs)
    return errors


def most_turning(inputs):
    """Angular velocity per speed of an impact, 1/m."""
    return max(abs(inputs["phi1"]), abs(inputs["phi2"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--scenes", type=int, default=1000, help="scenes of the first family"
    )
    asked = parser.parse_args()
    matplotlib.use("agg")
    names = [
        "Zeno time, ulp",
        "Zeno time, c",
        "velocities there, c",
        "collision times, ulp",
    ]
    figure, axes = plt.subplots(
        1, len(names), figsize=(15, 4.2), sharey=True, layout="constrained"
    )
    lines = [
        "# Accuracy",
        "",
        "`make accuracy` writes this page. It compares random scenes with solutions in arbitrary precision. One ulp is the spacing of doubles",
        "at the exact time. The conditioning c is the change that one ulp of one input causes; for velocities it is at least the rounding of",
        "the largest speed so far. For a scene with several collisions or numbers the largest error counts.",
        "",
        "| family | scenes | quantity | median | 90 % | 99 % | largest |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    with ProcessPoolExecutor() as pool:
        for (family, (draw, _, share)), colour in zip(
            FAMILIES.items(), COLOURS, strict=False
        ):
            rng = np.random.default_rng(SEED)
            count = max(1, asked.scenes * share // 100)
            tasks = [(family, draw(rng)) for _ in range(count)]
            found = [errors for errors in pool.map(judge, tasks, chunksize=4) if errors]
            for axis, name in zip(axes, names, strict=False):
                values = np.sort([errors[name] for errors in found if name in errors])
                if len(values) == 0:
                    continue
                shares = np.arange(1, len(values) + 1) / len(values)
                axis.step(
                    np.maximum(values, 1e-3),
                    shares,
                    color=colour,
                    label=family,
                    where="post",
                )
                axis.set(xscale="log", xlabel=f"error of the {name}", xlim=(1e-3, 1e4))
                middle = [*np.quantile(values, (0.5, 0.9, 0.99)), values[-1]]
                cells = [
                    family,
                    str(len(values)),
                    name,
                    *(f"{value:.2g}" for value in middle),
                ]
                lines.append("| " + " | ".join(cells) + " |")
            lost = count - len(found)
            lines.append(
                f"| {family} | {lost} | not judged: one ulp changes the verdict | | | | |"
            )
    for axis in axes:
        axis.axvline(1, color="#B0B0B0", linewidth=0.8, linestyle=":")
        axis.grid(True, color="#ECECEC", linewidth=0.6)
    axes[0].set(ylabel="share of scenes below", ylim=(0, 1.02))
    axes[1].legend(loc="lower right", fontsize=9)
    figure.suptitle(
        "Errors are of the order of what one ulp of an input does (c), however much the scene amplifies it"
    )
    figure.savefig(ROOT / "docs" / "accuracy.png", dpi=110)
    lines += [
        "",
        "In some scenes the last bit of an input changes which contact comes to rest first. Doubles cannot decide these scenes; they are counted",
        "as not judged. An error that is large in ulps and small in c comes from the scene, which amplifies the rounding of its inputs.",
    ]
    (ROOT / "docs" / "accuracy.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
