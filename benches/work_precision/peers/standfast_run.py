"""standfast itself, called as any user would call it: models local, full and auto, one run at a time with its record, and many
runs at once (`simulate_many`, time per run).

The posture is nominal where its points touch the floor, so that the start is a displacement from there. The law of impact is
that of the scene."""

import sys
import time

import harness
import standfast as sf

#: Number of runs in one call.
MANY = 100 if harness.QUICK else 10_000
#: Centre of mass in the nominal posture, where that is not the start.
NOMINAL = {"ball": (0.0, 0.1)} | dict.fromkeys(("rod", "nested", "elastic"), (0.0, 0.0))


def posture(name, scene):
    body, start = scene["body"], scene["start"]
    x, y = NOMINAL.get(name, start["q"][:2])
    if (
        name in harness.TURNING
    ):  # unturned, with the lowest point on the floor y = 0, which all points meet
        y = -min(dy for _, dy in body["arms"])
    contacts = [
        sf.Contact(
            point=(x + dx, y + dy), slope=body["slope"], friction=body["friction"]
        )
        for dx, dy in body["arms"]
    ]
    q = (start["q"][0] - x, start["q"][1] - y, start["q"][2])
    made = sf.Posture(
        mass=body["mass"],
        gyration_radius=body["gyration_radius"],
        center_of_mass=(x, y),
        contacts=contacts,
        restitution=body["restitution"],
        terrain=scene.get("terrain"),
        ground="shared"
        if name in harness.TURNING and "terrain" not in scene
        else "own",
    )
    return made, q, tuple(start["v"])


def options(scene):
    return {} if scene["law"] == "newton" else {"impact": scene["law"]}


def watched(name, scene, body, end):
    """The values of the task "before"."""
    x, y = body.center_of_mass
    if name == "block":
        return [x + end[0], y + end[1]]
    if "terrain" not in scene and not scene["body"]["friction"]:
        return list(body.gaps(end))
    place = [x + end[0], y + end[1], end[2]]
    return harness.answer(name, scene, "before", place, None)["values"]


def main(path):
    for name, scene in harness.scenes(path).items():
        body, q, v = posture(name, scene)
        law = options(scene)
        # The local model is that of small rotations.
        models = ("full", "auto") + (() if name in harness.TURNING else ("local",))
        for model in models:
            one(name, scene, body, q, v, {"model": model, **law}, model)
        if scene["law"] == "poisson":  # as the engines that do not have this law
            law = {"impact": "moreau"}
            one(name, scene, body, q, v, {"model": "full", **law}, "full, Moreau's law")
        if "rest" in scene:
            many(name, scene, body, q, v, {"model": "full", **law})


def one(name, scene, body, q, v, options, setting):
    x, y = body.center_of_mass
    record = {"tool": f"standfast {sf.__version__}", "scene": name, "setting": setting}
    record["law"] = options.get("impact", "newton")
    if "before" in scene:
        limit = scene["before"]["time"]

        def before():
            return sf.simulate(body, q, v, time_limit=limit, **options).q

        seconds, end = harness.median_time(before)
        values = watched(name, scene, body, end)
        harness.report(**record, task="before", seconds=seconds, values=values)
    if "rest" not in scene:
        return

    def rest():
        run = sf.simulate(body, q, v, **options)
        return run.time, run.q

    seconds, (settled, end) = harness.median_time(rest)
    place = [x + end[0], y + end[1], end[2]]
    harness.report(**record, task="rest", seconds=seconds, time=settled, q=place)


def many(name, scene, body, q, v, options):
    start = time.perf_counter()
    runs = sf.simulate_many([body] * MANY, q, v, **options)
    settled, end = runs.time, runs.q
    seconds = (time.perf_counter() - start) / MANY
    x, y = body.center_of_mass
    place = [x + end[0, 0], y + end[0, 1], end[0, 2]]
    record = {
        "tool": f"standfast {sf.__version__}",
        "scene": name,
        "setting": f"{MANY} at once",
        "law": scene["law"],
    }
    harness.report(**record, task="rest", seconds=seconds, time=settled[0], q=place)


if __name__ == "__main__":
    main(sys.argv[1])
