"""Speed against accuracy: runs every installed tool on the scenes, and draws the time of each run against its error.

`python chart.py` writes into docs/: work_precision.png and .svg, work_precision.csv (every point) and work_precision.md (the
table, and every point that standfast does not dominate). Points of tools that ran before are kept in target/work_precision;
`--again TOOL …` runs those anew, `--draw` runs nothing."""

import argparse
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
KEPT = ROOT / "target" / "work_precision"
SCENES = HERE / "scenes.json"
#: Errors below it are drawn here: a double rounds its results by about as much.
FLOOR = 1e-17
ROUNDING = 2**-53
#: Errors up to this are alike, for a double cannot be asked for less: one ulp of each input of the block, μ, α, g and v, moves
#: its time of rest v/(g(μ cos α + sin α)) by (4.0 + 2.2 + 1.6 + 1.0) roundings together.
ALIKE = 9 * ROUNDING

CARGO = ["cargo", "run", "--release", "--quiet"]
#: Name, colour [Okabe & Ito 2008], marker and command of each tool, in the order of the legend.
TOOLS = {
    "standfast": ("#D55E00", "*", [sys.executable, "peers/standfast_run.py"]),
    "standfast, in Rust": (
        "#D55E00",
        "+",
        [*CARGO, "-p", "standfast-benches", "--bin", "standfast-run", "--"],
    ),
    "Moreau–Jean, ours": (
        "#000000",
        "x",
        [*CARGO, "-p", "standfast-benches", "--bin", "moreau-jean", "--"],
    ),
    "scipy solve_ivp": ("#0072B2", "o", [sys.executable, "peers/solve_ivp.py"]),
    "Siconos": ("#009E73", "s", ["/usr/bin/python3", "peers/siconos_model.py"]),
    "Box2D": ("#E69F00", "^", [sys.executable, "peers/box2d_world.py"]),
    "pymunk": ("#56B4E9", "v", [sys.executable, "peers/pymunk_space.py"]),
    "MuJoCo": ("#CC79A7", "D", [sys.executable, "peers/mujoco_model.py"]),
    "rapier": ("#8A8A8A", "P", [*CARGO, "--manifest-path", "rapier/Cargo.toml", "--"]),
}
OURS = ("standfast", "standfast, in Rust", "Moreau–Jean, ours")
#: Error at which standfast is set beside fixed steps.
COARSE = 1e-3
TASKS = {"before": "state before the impacts accumulate", "rest": "time of rest"}


def kept(tool):
    return KEPT / (tool.replace(" ", "_").replace(",", "") + ".jsonl")


def measure(tool, command):
    """Run a tool and store its points; skip it if it is missing."""
    if shutil.which(command[0]) is None:
        print(f"{tool}: {command[0]} is missing: skipped", file=sys.stderr)
        return
    print(f"{tool} …", file=sys.stderr)
    done = subprocess.run(
        [*command, str(SCENES)], cwd=HERE, stdout=subprocess.PIPE, text=True
    )
    if done.returncode != 0:
        print(f"{tool}: failed, its points are left out", file=sys.stderr)
        return
    kept(tool).write_text(done.stdout)


def points(scenes):
    """Every point with its error. Errors of positions are relative to `length`, errors of times to the exact time.
    The error is None if a tool never comes to rest."""
    found = []
    for tool in TOOLS:
        if not kept(tool).exists():
            continue
        for line in kept(tool).read_text().splitlines():
            point = json.loads(line)
            point["family"] = tool
            scene = scenes[point["scene"]]
            exact = scene[point["task"]]
            place = [float(x) for x in scene["rest"]["q"]]
            if point["task"] == "before":
                errors = [
                    abs(a - float(b))
                    for a, b in zip(point["values"], exact["values"], strict=False)
                ]
                point["error"] = max(errors) / length(scene)
            elif point["time"] is None:
                point["error"] = None
            else:
                point["error"] = abs(point["time"] - float(exact["time"])) / float(
                    exact["time"]
                )
            if point["q"] is not None:
                off = [abs(a - b) for a, b in zip(point["q"], place, strict=False)]
                point["place_error"] = max(off[:2]) / length(scene)
            found.append(point)
    return found


def length(scene):
    """The length to which errors of positions are relative: the distance from the start to rest; for rocking, the width."""
    start, end = scene["start"]["q"], [float(x) for x in scene["rest"]["q"]]
    way = max(abs(a - b) for a, b in zip(start[:2], end[:2], strict=False))
    return way or 2 * abs(scene["body"]["arms"][0][0])


def draw(scenes, found):
    columns = {name: ("before" in scene) for name, scene in scenes.items()}
    figure, axes = plt.subplots(
        2, len(columns), figsize=(17, 8.2), sharey=True, layout="constrained"
    )
    for column, (name, scene) in enumerate(scenes.items()):
        for row, task in enumerate(TASKS):
            axis = axes[row][column]
            if task not in scene:
                axis.axis("off")
                continue
            panel(axis, [p for p in found if (p["scene"], p["task"]) == (name, task)])
            axis.set_title(
                scene["title"] if row == 0 or not columns[name] else "", fontsize=11
            )
            if row == 1 or name == list(scenes)[-1]:
                axis.set_xlabel("time of a run, s")
    for row, what in enumerate(TASKS.values()):
        axes[row][0].set_ylabel(f"relative error: {what}")
    handles = {}
    for axis in figure.axes:
        handles.update(
            dict(zip(*reversed(axis.get_legend_handles_labels()), strict=False))
        )
    ordered = [tool for tool in TOOLS if tool in handles]
    figure.legend(
        [handles[tool] for tool in ordered],
        ordered,
        loc="outside lower center",
        ncols=len(ordered),
        fontsize=11,
        frameon=False,
    )
    figure.suptitle(
        "Lower left is better: standfast is exact to the rounding of a double, mostly in microseconds",
        fontsize=14,
    )
    for suffix in ("png", "svg"):
        figure.savefig(ROOT / "docs" / f"work_precision.{suffix}", dpi=110)


def panel(axis, here):
    axis.set(xscale="log", yscale="log", ylim=(FLOOR / 3, 30), xlim=(3e-7, 30))
    axis.axhline(ROUNDING, color="#B0B0B0", linewidth=0.8, linestyle=":")
    axis.grid(True, color="#ECECEC", linewidth=0.6)
    for tool, (colour, marker, _) in TOOLS.items():
        mine = sorted(
            (p for p in here if p["family"] == tool), key=lambda p: p["seconds"]
        )
        reached = [p for p in mine if p["error"] is not None]
        size = {"standfast": 150, "standfast, in Rust": 60}.get(tool, 26)
        axis.scatter(
            [p["seconds"] for p in reached],
            [min(max(p["error"], FLOOR), 10) for p in reached],
            s=size,
            color=colour,
            marker=marker,
            linewidths=0.8,
            label=tool,
            zorder=3 if tool == "standfast" else 2,
        )
        never = [p["seconds"] for p in mine if p["error"] is None]
        if never:
            axis.scatter(
                never, [14] * len(never), s=18, color=colour, marker=marker, alpha=0.45
            )
    if any(p["error"] is None for p in here):
        axis.text(
            0.98,
            0.965,
            "never at rest",
            transform=axis.transAxes,
            ha="right",
            va="top",
            fontsize=8,
        )


def dominated(here, ours, others):
    """Points of these families for which no single call of `ours` has at most their time and at most their error."""
    mine = [p for p in here if p["family"] == ours and "at once" not in p["setting"]]
    for point in here:
        if point["family"] not in others:
            continue
        error = float("inf") if point["error"] is None else max(point["error"], ALIKE)
        if not any(
            p["seconds"] <= point["seconds"] and p["error"] <= error for p in mine
        ):
            yield point


def against_steps(scenes, found):
    """A line for each scene and task."""
    for name, scene in scenes.items():
        for task, what in TASKS.items():
            here = [p for p in found if (p["scene"], p["task"]) == (name, task)]
            steps = [
                p
                for p in here
                if p["family"] == "Moreau–Jean, ours" and p["error"] is not None
            ]
            ours = [
                p
                for p in here
                if p["family"] == "standfast, in Rust" and p["setting"] == "full"
            ]
            if not (steps and ours):
                continue
            best = [p for p in steps if p["error"] <= COARSE] or [
                min(steps, key=lambda p: p["error"])
            ]
            chosen = min(best, key=lambda p: p["seconds"])
            cells = [scene["title"], what, chosen["setting"].removeprefix("dt = ")]
            cells += [number(chosen["error"])]
            cells += [f"{p['seconds']:.1e}" for p in (chosen, ours[0])]
            cells += [f"{chosen['seconds'] / ours[0]['seconds']:.0f}"]
            yield "| " + " | ".join(cells) + " |"


def bullets(scenes, left):
    return [
        f"* {p['tool']}, {p['setting']}: {scenes[p['scene']]['title']}, {TASKS[p['task']]}, "
        f"{p['seconds']:.1e} s, error {number(p['error'])}"
        for p in left
    ] or ["None."]


def number(value):
    return "never" if value is None else f"{value:.1e}"


def table(scenes, found):
    lines = [
        "# Speed against accuracy",
        "",
        "`make chart` writes this page: the time of a run as a user calls it, with its state read, and the error of the result.",
        "`benches/work_precision/scenes.py` has the scenes and their exact answers. A script in `peers` beside it sets them up for each",
        "tool. Set-up of bodies and worlds is excluded from the timing of every tool. A run with a fixed step to rest is timed up to the",
        'time of rest that an earlier run found. "10000 at once" means 10 000 equal runs in one call of `simulate_many` on all cores; the',
        "time is divided by their number.",
        "The table has the fastest setting and the most accurate setting of each tool.",
        "",
        "| scene | task | tool | setting | time, s | relative error |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    left, bare = [], []
    for name, scene in scenes.items():
        for task in TASKS:
            here = [p for p in found if (p["scene"], p["task"]) == (name, task)]
            for tool in TOOLS:
                mine = [p for p in here if p["family"] == tool]
                if not mine:
                    continue

                def infinite(p):
                    return float("inf") if p["error"] is None else p["error"]

                chosen = [
                    min(mine, key=lambda p: p["seconds"]),
                    min(mine, key=infinite),
                ]
                for p in chosen if chosen[0] is not chosen[1] else chosen[:1]:
                    cells = [scene["title"], TASKS[task], p["tool"], p["setting"]]
                    cells += [f"{p['seconds']:.1e}", number(p["error"])]
                    lines.append("| " + " | ".join(cells) + " |")
            others = [tool for tool in TOOLS if tool not in OURS]
            left += list(dominated(here, "standfast", others))
            bare += list(
                dominated(here, "standfast, in Rust", ["Moreau–Jean, ours", "rapier"])
            )
    lines += [
        "",
        "## Against fixed steps",
        "",
        f"The largest step of Moreau–Jean with an error of at most {COARSE:.0e} (or, if there is none, its most accurate step), compared with",
        "the full model of standfast. Both are in Rust, without recording.",
        "",
        "| scene | task | step, s | relative error | time, s | standfast, s | ratio |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        *against_steps(scenes, found),
        "",
        "## Points that no single call of standfast from Python beats in both time and error",
        "",
        "The points of all other engines are compared. Errors of up to nine roundings of a double, 1.0e-15, count as equal: the time at",
        "which the sliding block stops changes by this much if each of its inputs is changed by one rounding.",
        "",
        *bullets(scenes, left),
        "",
        "## Points in Rust that no single call of standfast in Rust beats in both time and error",
        "",
        "The points of rapier and of Moreau–Jean are compared.",
        "",
        *bullets(scenes, bare),
    ]
    (ROOT / "docs" / "work_precision.md").write_text("\n".join(lines) + "\n")
    return left, bare


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--again", nargs="*", default=[], metavar="TOOL")
    parser.add_argument("--draw", action="store_true")
    asked = parser.parse_args()
    matplotlib.use("agg")
    KEPT.mkdir(parents=True, exist_ok=True)
    for tool, (_, _, command) in TOOLS.items():
        wanted = any(tool.lower().startswith(name.lower()) for name in asked.again)
        if not asked.draw and (wanted or not kept(tool).exists()):
            measure(tool, command)
    scenes = json.loads(SCENES.read_text())["scenes"]
    found = points(scenes)
    with (ROOT / "docs" / "work_precision.csv").open("w", newline="") as file:
        fields = ["scene", "task", "tool", "setting", "seconds", "error", "place_error"]
        writer = csv.DictWriter(file, fields, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(found)
    draw(scenes, found)
    left, bare = table(scenes, found)
    print(f"{len(found)} points; not dominated: {len(left)}, in Rust {len(bare)}")


if __name__ == "__main__":
    main()
