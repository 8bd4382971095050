"""Speed against accuracy: runs every installed tool on the scenes, and draws the time of each run against its error.

`python chart.py` writes into docs/: work_precision.csv (every point), work_precision.md (the page: some panels, the table, and every point
that standfast does not dominate), work_precision.png and .svg (all panels), and a picture for each of the panels on the page. Points of tools that
ran before are kept in target/work_precision; `--again TOOL …` runs those anew. `--draw` runs nothing: it makes the page and the pictures
from docs/work_precision.csv. `--quick` is a small version within a minute, once all programs are built: every run only for milliseconds; it
reads and writes target/work_precision_quick and leaves docs/ alone."""

import argparse
import csv
import json
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
from matplotlib.ticker import EngFormatter, FixedLocator

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
TARGET = ROOT / "target"
SCENES = HERE / "scenes.json"
#: Errors below it are drawn here: a double rounds its results by about as much.
FLOOR = 1e-17
ROUNDING = 2**-53
#: Errors up to this are alike, for a double cannot be asked for less: one ulp of each input of the block, μ, α, g and v, moves
#: its time of rest v/(g(μ cos α + sin α)) by (4.0 + 2.2 + 1.6 + 1.0) roundings together.
ALIKE = 9 * ROUNDING

CARGO = ["cargo", "run", "--profile", "bench", "--quiet"]
#: Name, colour [Okabe & Ito 2008], marker, law of impact and command of each tool, in the order of the legend.
TOOLS = {
    "standfast": (
        "#D55E00",
        "*",
        "the law of the scene",
        [sys.executable, "peers/standfast_run.py"],
    ),
    "standfast, in Rust": (
        "#D55E00",
        "+",
        "the law of the scene",
        [*CARGO, "-p", "standfast-benches", "--bin", "standfast-run", "--"],
    ),
    "Moreau–Jean, ours": (
        "#000000",
        "x",
        "Moreau's law",
        [*CARGO, "-p", "standfast-benches", "--bin", "moreau-jean", "--"],
    ),
    "scipy solve_ivp": (
        "#0072B2",
        "o",
        "Newton's law, by hand",
        [sys.executable, "peers/solve_ivp.py"],
    ),
    "Siconos": (
        "#009E73",
        "s",
        "Moreau's law",
        ["/usr/bin/python3", "peers/siconos_model.py"],
    ),
    "Box2D": (
        "#E69F00",
        "^",
        "Moreau's law, contact by contact",
        [sys.executable, "peers/box2d_world.py"],
    ),
    "Box2D 3": (
        "#882255",
        "<",
        "Moreau's law, contact by contact",
        [*CARGO, "--manifest-path", "engines/Cargo.toml", "--", "box2d"],
    ),
    "pymunk": (
        "#56B4E9",
        "v",
        "Moreau's law, contact by contact",
        [sys.executable, "peers/pymunk_space.py"],
    ),
    "MuJoCo": (
        "#CC79A7",
        "D",
        "spring and damper",
        [sys.executable, "peers/mujoco_model.py"],
    ),
    "rapier": (
        "#8A8A8A",
        "P",
        "friction first, then rebound",
        [*CARGO, "--manifest-path", "engines/Cargo.toml", "--", "rapier"],
    ),
}
OURS = ("standfast", "standfast, in Rust", "Moreau–Jean, ours")
#: Error at which standfast is set beside fixed steps.
COARSE = 1e-3
TASKS = {"before": "state before the impacts accumulate", "rest": "time of rest"}
#: The panels that the page shows, each as a picture of its own.
SHOWN = (("rod", "rest"), ("thrown", "before"), ("ball", "rest"))
#: Times of a run on the axis: s.
SHORTEST, LONGEST = 3e-7, 30
#: The columns of the file of points. `default`: at the default step of an engine; `truth`: the exact answer that it is compared with.
FIELDS = ("scene", "task", "family", "tool", "setting", "default", "truth", "seconds", "error", "place_error")  # fmt: skip
#: Of a point that is not beaten: its error is at most this many times ours.
NEAR = 10


def kept(folder, tool):
    return folder / (tool.replace(" ", "_").replace(",", "") + ".jsonl")


def measure(folder, tool, command, quick):
    """Run a tool and store its points; skip it if it is missing."""
    if shutil.which(command[0]) is None:
        print(f"{tool}: {command[0]} is missing: skipped", file=sys.stderr)
        return
    print(f"{tool} …", file=sys.stderr)
    arguments = [str(SCENES), *(["--quick"] if quick else [])]
    done = subprocess.run(
        [*command, *arguments], cwd=HERE, stdout=subprocess.PIPE, text=True
    )
    if done.returncode != 0:
        print(f"{tool}: failed, its points are left out", file=sys.stderr)
        return
    kept(folder, tool).write_text(done.stdout)


def points(scenes, folder):
    """Every point with its error. Errors of positions are relative to `length`, errors of times to the exact time.
    The error is None if a tool never comes to rest."""
    found = []
    for tool in TOOLS:
        if not kept(folder, tool).exists():
            continue
        for line in kept(folder, tool).read_text().splitlines():
            point = json.loads(line)
            point["family"] = tool
            scene = scenes[point["scene"]]
            exact = scene[point["task"]]
            # Tools that do not have the law of the scene are compared with the answer by their own.
            law = point.get("law") or ("late" if tool == "rapier" else "moreau")
            point["truth"] = law if law in exact else "values"
            if point["task"] == "before":
                errors = [
                    abs(a - float(b))
                    for a, b in zip(point["values"], exact[point["truth"]], strict=True)
                ]
                point["error"] = max(errors) / length(scene)
            elif point["time"] is None:
                point["error"] = None
            else:
                point["error"] = abs(point["time"] - float(exact["time"])) / float(
                    exact["time"]
                )
            if point["q"] is not None:
                place = [float(x) for x in scene["rest"]["q"]]
                off = [abs(a - b) for a, b in zip(point["q"], place, strict=True)]
                point["place_error"] = max(off[:2]) / length(scene)
            found.append(point)
    return found


def length(scene):
    """The length to which errors of positions are relative: the distance from the start to rest, or to the state that is compared; for
    a body that comes to rest where it started, its width."""
    start, arms = scene["start"]["q"], scene["body"]["arms"]
    if "rest" in scene:
        end = [float(x) for x in scene["rest"]["q"]]
        way = max(abs(a - b) for a, b in zip(start[:2], end[:2], strict=True))
        turned = scene["body"].get("rocks")
        return 2 * abs(arms[0][0]) if turned else way
    if scene["body"]["friction"]:
        return abs(float(scene["before"]["values"][0]) - start[0])
    return start[1]


def panels(scenes):
    """(scene, task) of each panel."""
    tasks = [(name, task) for task in TASKS for name in scenes if task in scenes[name]]
    return sorted(tasks, key=lambda panel: list(TASKS).index(panel[1]))


def write(found, path):
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, extrasaction="ignore")
        writer.writeheader()
        writer.writerows(p | {"default": int(bool(p.get("default")))} for p in found)


def read(path):
    """The points that `write` has written."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row["seconds"] = float(row["seconds"])
        row["default"] = row["default"] == "1"
        row["error"] = float(row["error"]) if row["error"] else None
    return rows


def of_panel(found, name, task):
    return [p for p in found if (p["scene"], p["task"]) == (name, task)]


def legend(axis, axes, **where):
    """The tools of these axes, and the ring."""
    handles = {}
    for drawn in axes:
        handles |= dict(zip(*reversed(drawn.get_legend_handles_labels()), strict=True))
    ordered = [tool for tool in TOOLS if tool in handles]
    ring = plt.Line2D(
        [], [], marker="o", linestyle="", markersize=10, **RING, label="ring"
    )
    axis.legend(
        [*(handles[tool] for tool in ordered), ring],
        [*(f"{tool}: {TOOLS[tool][2]}" for tool in ordered), "step by default"],
        frameon=False,
        title="tool: its law of impact",
        alignment="left",
        handletextpad=0.2,
        **where,
    )


def draw(scenes, found, folder):
    """All panels."""
    shown, columns = panels(scenes), 5
    rows = -(-(len(shown) + 1) // columns)
    figure, axes = plt.subplots(
        rows,
        columns,
        figsize=(17, 4 * rows),
        sharex=True,
        sharey=True,
        layout="constrained",
    )
    for axis, (name, task) in zip(axes.flat, shown, strict=False):
        panel(axis, of_panel(found, name, task), every=3)
        what = "time of rest" if task == "rest" else "state at a time"
        axis.set_title(f"{scenes[name]['title']}\n{what}", fontsize=10.5)
    for axis in axes[:, 0]:
        axis.set_ylabel("relative error")
    for k, axis in enumerate(axes.flat):
        if len(shown) - columns <= k < len(shown):
            axis.set_xlabel("time of a run")
            axis.tick_params(labelbottom=True)
    for axis in axes.flat[len(shown) :]:
        axis.axis("off")
    legend(
        axes.flat[len(shown)],
        axes.flat,
        loc="center left",
        fontsize=9.5,
        borderaxespad=0,
    )
    figure.suptitle(
        "Lower left is better: standfast is exact to the rounding of a double, mostly in microseconds",
        fontsize=14,
    )
    for suffix in ("png", "svg"):
        figure.savefig(folder / f"work_precision.{suffix}", dpi=110)
    plt.close(figure)


def picture(name):
    return f"work_precision_{name}.png"


def draw_one(scenes, found, name, task, folder):
    """A panel as a picture that can be read on a phone."""
    figure = plt.figure(figsize=(4.6, 6.2), layout="constrained")
    axis, below = figure.subplots(2, height_ratios=(4, 2.4))
    panel(axis, of_panel(found, name, task), every=1)
    axis.set(xlabel="time of a run", ylabel="relative error")
    axis.tick_params(axis="x", labelsize=8)
    axis.set_title(f"{scenes[name]['title']}\n{TASKS[task]}", fontsize=10.5)
    below.axis("off")
    legend(below, [axis], loc="upper left", fontsize=9, borderaxespad=0)
    figure.savefig(folder / picture(name), dpi=150)
    plt.close(figure)


#: The mark of the default step of an engine.
RING = {
    "markerfacecolor": "none",
    "markeredgecolor": "#333333",
    "markeredgewidth": 1.0,
}


def drawn(error):
    return min(max(error, FLOOR), 10)


def panel(axis, here, every):
    """The points of a scene and a task. every: how many decades are between the times at the axis."""
    axis.set(
        xscale="log", yscale="log", ylim=(FLOOR / 3, 5e3), xlim=(SHORTEST, LONGEST)
    )
    axis.xaxis.set_major_locator(
        FixedLocator([10.0**k for k in range(-6, 2) if k % every == 0])
    )
    axis.xaxis.set_minor_locator(FixedLocator([10.0**k for k in range(-6, 2)]))
    axis.xaxis.set_major_formatter(EngFormatter("s"))
    axis.xaxis.set_minor_formatter("")
    axis.axhline(ROUNDING, color="#B0B0B0", linewidth=0.8, linestyle=":")
    axis.grid(True, color="#ECECEC", linewidth=0.6)
    for tool, (colour, marker, _, _) in TOOLS.items():
        mine = sorted(
            (p for p in here if p["family"] == tool), key=lambda p: p["seconds"]
        )
        if not mine:
            continue
        reached = [p for p in mine if p["error"] is not None]
        size = {"standfast": 150, "standfast, in Rust": 60}.get(tool, 26)
        axis.scatter(
            [p["seconds"] for p in reached],
            [drawn(p["error"]) for p in reached],
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
                never,
                [NEVER] * len(never),
                s=18,
                color=colour,
                marker=marker,
                alpha=0.45,
            )
    default = [p for p in here if p.get("default")]
    axis.plot(
        [p["seconds"] for p in default],
        [NEVER if p["error"] is None else drawn(p["error"]) for p in default],
        "o",
        markersize=10,
        zorder=4,
        **RING,
    )
    if any(p["error"] is None for p in here):
        axis.annotate(
            "never at rest",
            (1, NEVER),
            (-3, 11),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            ha="right",
            va="center",
            fontsize=8,
        )


#: Height at which the points are drawn that never come to rest.
NEVER = 20


def dominated(here, ours, others):
    """Points of these families for which no single call of `ours` has at most their time and at most their error."""
    ours = [p for p in here if p["family"] == ours and "at once" not in p["setting"]]
    for point in here:
        if point["family"] not in others:
            continue
        # By the same law, if ours have it.
        mine = [p for p in ours if p["truth"] == point["truth"]] or ours
        error = float("inf") if point["error"] is None else max(point["error"], ALIKE)
        if not any(
            p["seconds"] <= point["seconds"] and p["error"] <= error for p in mine
        ):
            best = min(mine, key=lambda p: (p["error"], p["seconds"]))
            near = error <= NEAR * max(best["error"], ALIKE)
            faster = point["seconds"] < best["seconds"]
            yield point | {"unbeaten": near and faster, "best": best}


def against_steps(scenes, found):
    """A line for each scene and task."""
    for name, scene in scenes.items():
        for task, what in TASKS.items():
            points = of_panel(found, name, task)
            steps = [
                p
                for p in points
                if p["family"] == "Moreau–Jean, ours" and p["error"] is not None
            ]
            ours = [
                p
                for p in points
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
        f"{p['seconds']:.1e} s, error {number(p['error'])}; standfast {p['best']['seconds']:.1e} s, error {number(p['best']['error'])}"
        for p in left
    ] or ["None."]


def number(value):
    return "never" if value is None else f"{value:.1e}"


def table(scenes, found, folder):
    lines = [
        "# Speed against accuracy",
        "",
        "The time of a run as a user calls it, with its state read, against the error of the result: standfast and other engines, each with several",
        "settings. Lower left is better. A ring marks the step of an engine unless told otherwise: 1/60 s for Box2D, pymunk and rapier (one frame),",
        "2 ms for MuJoCo.",
        "",
    ]
    for name, task in SHOWN:
        title = f"{scenes[name]['title']}: {TASKS[task]}"
        lines += [f'![{title}]({picture(name)}){{ width="560" }}', ""]
    lines += [
        f"[All {len(panels(scenes))} panels](work_precision.png), also [as SVG](work_precision.svg), and [every point](work_precision.csv).",
        "",
        "`make chart` measures, and writes this page. `benches/work_precision/scenes.py` has the scenes and their exact answers. A script in `peers`",
        "beside it sets them up for each tool. Set-up of bodies and worlds is excluded from the timing of every tool. A run with a fixed step to rest is",
        'timed up to the time of rest that an earlier run found. "10000 at once" means 10 000 equal runs in one call of `simulate_many` on all cores; the',
        "time is divided by their number.",
        "",
        "| tool | law of impact |",
        "| --- | --- |",
        *(f"| {tool} | {law} |" for tool, (_, _, law, _) in TOOLS.items()),
        "",
        "Moreau's law is Newton's restitution with Coulomb's friction on the velocity after the impact. \"Contact by contact\": several contacts are",
        "solved in turn, a few times in each step. rapier applies Moreau's law without rebound, and then the rebound without friction. Without friction",
        "these are Newton's law. Each tool is compared with the exact answer by its own law; MuJoCo, whose law has no exact answer, with that by",
        "Moreau's. The law of the thrown box is Poisson's; standfast runs it with Moreau's law, too, and is compared with the tools of that law.",
        "",
        "The ball falls from 1 m. Box2D 2.3 drops the restitution below 1 m/s. Here its lengths are scaled so that this speed becomes small (`box2d_world.py`);",
        "as shipped, in metres, the ball bounces seven times and is at rest 18.6 % too early, however small the step. Rest means that all speeds stay below 1e-6 m/s.",
        "",
        "**Where an engine is faster.** Up to rest, tumbling bodies have hundreds of events. From Rust, standfast takes 1.2 to 2.3 times as long as Box2D 3 with",
        "steps of 1/60 s on a thrown box, an octagon and a box on stairs, and .5 to .6 times as long on a block that rocks and a body on eight feet (`make frames`). The engine's bodies are then",
        ".4 mm to .8 m from where the exact ones rest: see [whole runs](benchmarks.md#whole-runs-beside-one-frame-a-step).",
        "",
        "<details markdown>",
        "<summary>The fastest and the most accurate setting of each tool, as a table</summary>",
        "",
        "| scene | task | tool | setting | time, s | relative error |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    left, bare = [], []
    for name, scene in scenes.items():
        for task in TASKS:
            points = of_panel(found, name, task)
            for tool in TOOLS:
                mine = [p for p in points if p["family"] == tool]
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
            left += list(dominated(points, "standfast", others))
            bare += list(
                dominated(points, "standfast, in Rust", ["Moreau–Jean, ours", "rapier"])
            )
    lines += [
        "",
        "</details>",
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
        "## Points that standfast from Python does not beat",
        "",
        f"These are faster than its most accurate call, with an error of at most {NEAR} times that of the call:",
        "",
        *bullets(scenes, [p for p in left if p["unbeaten"]]),
        "",
        "And no single call of it beats these in both time and error:",
        "",
        *bullets(scenes, [p for p in left if not p["unbeaten"]]),
        "",
        "The points of all other engines are compared. Errors of up to nine roundings of a double, 1.0e-15, count as equal: the time at",
        "which the sliding block stops changes by this much if each of its inputs is changed by one rounding.",
        "",
        "## Points in Rust that no single call of standfast in Rust beats in both time and error",
        "",
        "The points of rapier and of Moreau–Jean are compared.",
        "",
        *bullets(scenes, bare),
    ]
    (folder / "work_precision.md").write_text("\n".join(lines) + "\n")
    return left, bare


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--again", nargs="*", default=[], metavar="TOOL")
    parser.add_argument("--draw", action="store_true")
    parser.add_argument("--quick", action="store_true")
    asked = parser.parse_args()
    matplotlib.use("agg")
    folder = TARGET / ("work_precision_quick" if asked.quick else "work_precision")
    pages = folder if asked.quick else ROOT / "docs"
    folder.mkdir(parents=True, exist_ok=True)
    scenes = json.loads(SCENES.read_text())["scenes"]
    points_file = pages / "work_precision.csv"
    if not asked.draw:
        for tool, (_, _, _, command) in TOOLS.items():
            wanted = any(tool.lower().startswith(name.lower()) for name in asked.again)
            if wanted or asked.quick or not kept(folder, tool).exists():
                measure(folder, tool, command, asked.quick)
        write(points(scenes, folder), points_file)
    found = read(points_file)
    draw(scenes, found, pages)
    for name, task in SHOWN:
        draw_one(scenes, found, name, task, pages)
    left, bare = table(scenes, found, pages)
    unbeaten = sum(p["unbeaten"] for p in left)
    print(
        f"{len(found)} points; not dominated: {len(left)}, of these not beaten: {unbeaten}; in Rust {len(bare)}"
    )


if __name__ == "__main__":
    main()
