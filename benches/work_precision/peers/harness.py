"""Functions that the peers share: the scenes, the timing, the rule for the time of rest, and the output. Standard library only."""

import itertools
import json
import math
import statistics
import sys
import time
from functools import partial

#: Acceleration of gravity, along -y.
GRAVITY = 9.81
#: Speeds in m/s below it are none.
STILL = 1e-6
#: A small version of the chart, within a minute: runs that last for milliseconds, timed once.
QUICK = "--quick" in sys.argv
#: No setting is tried of which one run would take longer, in seconds.
PATIENCE = 0.03 if QUICK else 2.0
#: The steps in s of those that have a fixed one.
STEPS = [m * 10.0**-k for k in range(2, 9) for m in (1, 0.3)]
#: The step for which most engines are made, one frame, in s.
FRAME = 1 / 60
#: Bodies that turn over. Engines that have no points get discs of this radius, in m, around the contact points, and ground that is lower by
#: it: the gaps and the levers of the normal forces are then exact at any angle, those of friction up to the radius.
TURNING, RADIUS = ("thrown", "octagon", "stairs", "feet"), 1e-4
#: Depth of the blocks that stand for treads, in m.
DEEP = 1.0


def scenes(path):
    """The scenes of scenes.json by name, with the exact answers as floats."""
    with open(path) as file:
        found = json.load(file)["scenes"]
    for scene in found.values():
        for task, key in (("rest", "q"), ("before", "values")):
            if task in scene:
                scene[task]["time"] = float(scene[task]["time"])
                scene[task][key] = [float(x) for x in scene[task][key]]
    return found


def treads(scene):
    """The level pieces of a terrain: (from x, to x, height)."""
    corners = scene["terrain"]
    pairs = itertools.pairwise(corners)
    return [(x, end, y) for (x, y), (end, to) in pairs if y == to]


def report(**record):
    """One line of JSON: tool, scene, task, setting, parameter, seconds, values, time, q."""
    print(json.dumps({"values": None, "time": None, "q": None, **record}), flush=True)


def median_time(run, prepare=tuple):
    """Wall time in seconds of run(*prepare()), the median of several calls, and the return value of the last call. prepare sets up
    a run and is not timed."""
    seconds = []
    while True:
        ready = prepare()
        start = time.perf_counter()
        result = run(*ready)
        seconds.append(time.perf_counter() - start)
        enough = 1 if seconds[0] > 5 else 3 if seconds[0] > 1 else 5
        if QUICK and sum(seconds) > 0.003:
            return statistics.median(seconds), result
        if len(seconds) >= enough and (sum(seconds) > 0.1 or len(seconds) >= 25):
            return statistics.median(seconds), result


def timed(prepare, run, task, end):
    """Seconds and result of `run(*prepare(end), end)` -> (q, time of rest). For the task "rest" a first run finds the time of rest,
    and a second run up to that time is timed."""
    found = run(*prepare(end), end)
    if task == "rest" and found[1] is not None:
        end = found[1]
    seconds, _ = median_time(lambda *ready: run(*ready, end), lambda: prepare(end))
    return seconds, found


def settled(times, speeds):
    """The first time from which all speeds stay below STILL; None if the last speed does not. A speed is the largest of
    |vx|, |vy|, |omega| * gyration_radius after the step that ends at this time."""
    since = None
    for at, speed in zip(reversed(times), reversed(speeds), strict=True):
        if not speed < STILL:
            break
        since = at
    return since


def answer(name, scene, task, q, time):
    """The reported part of a state (x, y, theta): the heights of the contact points, with friction also x (for the block its position);
    or the time of rest and the state."""
    if task == "rest":
        return {"time": time, "q": q}
    if name == "block":
        return {"values": q[:2]}
    sin, cos = math.sin(q[2]), math.cos(q[2])
    heights = [q[1] + sin * a + cos * b for a, b in scene["body"]["arms"]]
    return {"values": [q[0], *heights] if scene["body"]["friction"] else heights}


def fixed_step(tool, path, prepare, simulate, default=None, terrain=True):
    """Runs with shorter and shorter steps until a run takes too long. prepare(name, scene, task, dt, end) returns a
    tuple; simulate(*tuple, scene, task, dt, end) returns q and the time. default : the step of the engine unless told otherwise, in s,
    which is one of the steps. terrain : whether the tool has ground other than one floor."""
    every = sorted({*STEPS, *([default] if default else [])}, reverse=True)
    for name, scene in scenes(path).items():
        if "terrain" in scene and not terrain:
            continue
        for task in ("before", "rest"):
            if task not in scene:
                continue
            end = scene[task]["time"] * (1.5 if task == "rest" else 1.0)
            seconds, last = 0.0, 1.0
            for dt in every:
                if seconds * last / dt > PATIENCE:
                    break
                ready = partial(prepare, name, scene, task, dt)

                def run(*arguments, scene=scene, task=task, dt=dt):
                    *made, end = arguments
                    return simulate(*made, scene, task, dt, end)

                seconds, (q, time) = timed(ready, run, task, end)
                last = dt
                report(
                    tool=tool,
                    scene=name,
                    task=task,
                    setting="dt = 1/60" if dt == FRAME else f"dt = {dt:g}",
                    default=dt == default,
                    parameter=dt,
                    seconds=seconds,
                    **answer(name, scene, task, q, time),
                )
