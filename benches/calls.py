"""Cost of calls from Python: one run of a clattering rod to rest, a million runs in one call, and what the explorer asks while something is
dragged. `python benches/calls.py` prints the best of several rounds, for the explorer the median."""

import json
import math
import statistics
import time
from pathlib import Path

import numpy as np
import standfast as sf

CALLS = 2000
COUNT = 1_000_000
ROUNDS = 5
#: Places of the centre of mass in a drag.
DRAGGED = 200


def best(call, repeats=1):
    """Seconds of a call."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for _ in range(repeats):
            call()
        times.append(time.perf_counter() - start)
    return min(times) / repeats


def rod(radius=0.2, restitution=0.1):
    return sf.Posture.rod(
        half_length=0.5, gyration_radius=radius, restitution=restitution
    )


def one():
    """Seconds of one run, by model."""
    body, q, qdot = rod(), (0, 0.011, math.asin(0.002)), (0, 0, 0)
    took = {}
    for model in ("local", "full", "auto"):
        took[model] = best(lambda m=model: sf.simulate(body, q, qdot, model=m), CALLS)
        print(f"one run, {model}: {1e6 * took[model]:.1f} µs")
    return took


def many(single):
    """`single`: seconds of one run by itself, by model."""
    number = np.arange(COUNT)
    share = number / COUNT
    other = number * 7919 % COUNT / COUNT
    q = np.zeros((COUNT, 3))
    q[:, 1], q[:, 2] = 0.011, 0.002 * (0.2 + 0.8 * (number * 31337 % COUNT / COUNT))
    rods = [
        rod(radius, restitution)
        for radius, restitution in zip(
            0.15 + 0.1 * share, 0.05 + 0.1 * other, strict=True
        )
    ]
    for model in ("local", "full"):
        for what, bodies in (("different rods", rods), ("starts of one rod", rod())):

            def call(bodies=bodies, model=model):
                runs = sf.simulate_many(bodies, q, (0, 0, 0), model=model)
                return runs.time, runs.q

            each = best(call) / COUNT
            print(
                f"a million {what}, {model}: {1e-6 / each:.2f} million runs a second, a run in {each / single[model]:.3f} of one by itself"
            )


def page():
    """The posture at each of many places of the centre of mass, as in a drag, and the coarse map of 60 x 60 places."""
    for path in sorted(Path(__file__).parents[1].glob("examples/*.toml")):
        asked = {"ask": "scene", "scene": path.read_text(encoding="utf-8")}
        scene = json.loads(sf.ask(json.dumps(asked)))["scene"]
        (x, y), took = scene["body"]["center_of_mass"], []
        for k in range(DRAGGED):
            scene["body"]["center_of_mass"] = (x + 0.6 * k / DRAGGED - 0.3, y + 0.1)
            asked = json.dumps({"ask": "posture", "scene": scene})
            start = time.perf_counter()
            sf.ask(asked)
            took.append(time.perf_counter() - start)
        over = [
            {"path": path, "values": list(np.linspace(at - 1, at + 1, 60))}
            for path, at in (("center_of_mass.y", y), ("center_of_mass.x", x))
        ]
        asked = {"ask": "map", "scene": scene, "over": over, "quantity": ["by"]}
        asked = json.dumps(asked)
        drawn = best(lambda asked=asked: sf.ask(asked))
        print(
            f"explorer, {path.stem}: verdict {1e3 * statistics.median(took):.2f} ms (longest {1e3 * max(took):.1f}), map {1e3 * drawn:.0f} ms"
        )


if __name__ == "__main__":
    many(one())
    page()
