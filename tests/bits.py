"""The bits of all results on 11 000 seeded scenes, to compare two states of the program.

`python tests/bits.py` computes them and names the blocks of scenes that differ from those of `data/bits.txt`; `--write`
replaces the file. Texts of warnings are not compared, so they may be reworded. Inputs are multiples of powers of two,
computed without functions that differ between platforms.
"""

import argparse
import hashlib
import struct
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise
from pathlib import Path

import numpy as np
import standfast as sf

FILE = Path(__file__).parent / "data" / "bits.txt"
#: Number of scenes per line of the file.
BLOCK = 20
EVENTS = 3000
MODELS = ["auto", "local", "full"]
LAWS = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"]
GROUNDS = ["lines", "level", "segments", "polyline"]
STRAIGHT = GROUNDS[:2]
ORDERS = ["first-contact-first", "last-contact-first"]


class Draw:
    """Random dyadic numbers and choices for one scene."""

    def __init__(self, family: int, k: int):
        self.rng = np.random.default_rng([20, family, k])

    def number(self, low: float, high: float) -> float:
        return low + (high - low) * int(self.rng.integers(0, 1025)) / 1024

    def numbers(self, low: float, high: float, count: int = 3) -> np.ndarray:
        return np.array([self.number(low, high) for _ in range(count)])

    def of(self, choices):
        return choices[int(self.rng.integers(0, len(choices)))]

    def chance(self, share: float) -> bool:
        return self.number(0, 1) < share


def posture(draw: Draw, count: int, ground: str) -> sf.Posture:
    friction, e = (
        draw.of([0.0, 0.25, 0.75, 1.5]),
        draw.of([0.0, 0.125, 0.5, 0.75, 0.875]),
    )
    mixed, tangential = draw.chance(0.25), draw.of([0.0, 0.0, 0.5])
    terrain = None
    if ground == "polyline":
        xs = np.cumsum([draw.number(0.25, 1.5) for _ in range(draw.of([2, 3, 5]))])
        xs = [-40.0, *(xs - 2.0), 40.0]
        terrain = [(float(x), draw.number(-0.5, 0.5)) for x in xs]
    contacts = []
    for i in range(count):
        x = -1.0 + 2.0 * i / max(count - 1, 1) + draw.number(-0.125, 0.125)
        options = {
            "friction": draw.number(0, 1.5) if mixed else friction,
            "tangential_restitution": tangential,
        }
        if mixed and draw.chance(0.5):
            options["restitution"] = draw.number(0, 0.875)
        y = 0.0
        if terrain:
            (x0, y0), (x1, y1) = next(
                (a, b) for a, b in pairwise(terrain) if a[0] <= x <= b[0]
            )
            y = y0 + (y1 - y0) * ((x - x0) / (x1 - x0))
        elif ground == "lines":
            y, options["slope"] = draw.number(-0.25, 0.25), draw.number(-0.5, 0.5)
        elif ground == "segments":
            y, options["segment"] = (
                draw.number(-0.25, 0.25),
                (-draw.number(0.25, 2), draw.number(0.25, 2)),
            )
        contacts.append(sf.Contact((x, y), **options))
    centre = (draw.number(-0.5, 0.5), draw.number(-0.25, 1.0))
    return sf.Posture(
        draw.of([0.5, 1.0, 2.0]),
        draw.number(0.25, 1.25),
        centre,
        contacts,
        e,
        9.8125,
        terrain=terrain,
    )


def state(draw: Draw, body: sf.Posture) -> tuple[np.ndarray, np.ndarray]:
    """A start at rest, with a small velocity, or thrown; never in the ground."""
    how = draw.of(["rest", "kick", "throw", "throw"])
    if how == "rest":
        return np.zeros(3), np.zeros(3)
    if how == "kick":
        qdot = draw.numbers(-0.5, 0.5)
        for _ in range(8):
            if min(body.gap_rates((0, 0, 0), qdot)) >= 0:
                break
            qdot[1] += 0.5
        return np.zeros(3), qdot
    q = draw.numbers(-0.25, 0.25)
    q[1] = 0.0
    for _ in range(16):
        if min(body.gaps(q)) > 0:
            break
        q[1] += 0.125
    return q, draw.numbers(-1, 1) * draw.of([0.0, 1.0, 4.0])


def of_run(run: sf.Run) -> Iterator[object]:
    yield from (run.outcome, run.model, run.time, run.elapsed, run.collisions)
    yield from (run.q, run.qdot, run.gaps, run.rates, run.theta, run.omega)
    yield from (run.acceleration, run.impacts, len(run.warnings))
    for p in run.phases:
        yield from (p.mode, p.start, p.end, p.cause, p.contact, p.impacts)
    for z in run.zeno_points:
        yield from (z.kind, z.contacts, z.time, z.elapsed, z.time_error, z.q, z.qdot)
        yield from (z.theta, z.omega, z.gaps, z.gap_rates)
        yield from (z.certified, z.method, z.plastic, z.first_summed)
    times = run.time - run.elapsed * np.arange(1, 8) / 8
    yield run.gaps_at(times)
    yield run.gap_rates_at(times)
    if run.q is not None:
        yield from run.at(times)
    if run.enclosure is not None:
        box = run.enclosure
        yield from (box.impacts, box.zeno, box.contacts, box.reason is None)
    if run.undecided is not None:
        yield from of_modes(sf.contact_modes(run.undecided))


def of_modes(modes: sf.results.Modes) -> Iterator[object]:
    yield from (modes.status, modes.level, tuple(modes.consistent))
    for word in modes:
        mode = modes[word]
        yield from (word, mode.acceleration, mode.forces, mode.determined)
        yield from (mode.force_interval, mode.consistent, mode.near_degenerate)
        yield from (value for *_, value in mode.margins)


def of_verdict(v: sf.Verdict) -> Iterator[object]:
    yield from (v.equilibrium, v.equilibrium_margin, v.equilibrium_region)
    yield from (v.kinematic_strong, v.kinematic_strong_strict, v.kinematic_margin)
    yield from (v.unambiguous, v.coupling, v.clattering, v.clattering_margin)
    yield from (v.chatter, v.chatter_margin, v.energy, v.frictional_stability)
    yield from (v.by, v.delicate, v.amplification, v.amplification_reason)
    if v.trials is not None:
        yield repr(v.trials)


def one_run(k: int) -> Iterator[object]:
    draw = Draw(0, k)
    law = LAWS[k // 3 % 5]
    count, ground = 1 + k // 15 % 6, GROUNDS[k // 90 % 4]
    model = MODELS[k % 3] if ground in STRAIGHT else "full"
    body = posture(draw, count, ground)
    q, qdot = state(draw, body)
    options = {
        "model": model,
        "impact": law,
        "event_limit": EVENTS,
        "stop": draw.of(["rest", "rest", "zeno", "time"]),
        "time_limit": draw.of([1.0, 4.0]),
    }
    if law == "newton" and draw.chance(0.5):
        options["simultaneous"] = draw.of(["newton", *ORDERS])
    elif count > 1 and draw.chance(0.5):
        options["simultaneous"] = draw.of(ORDERS)
    yield from of_run(sf.simulate(body, q, qdot, **options))


def one_pair(k: int) -> Iterator[object]:
    """Two feet without friction in impacts: summed tails, certified runs, and the local model alone."""
    draw = Draw(1, k)
    body = posture(draw, 2, GROUNDS[k % 2])
    if draw.chance(0.5):
        rest, rub = draw.of([0.0625, 0.125, 0.25, 0.5, 0.875]), draw.of([0.0, 0.5])
        body = sf.Posture.rod(0.5, draw.number(0.0625, 0.75), rest, rub, 9.8125)
    q, qdot = state(draw, body)
    if draw.chance(0.5):
        q, qdot = q / 64, qdot / 64
    options = {"event_limit": EVENTS, "certify": draw.chance(0.5)}
    law = {"impact": "newton"}
    if k % 3:
        options["model"] = MODELS[k % 3]
        options["stop"] = "zeno" if options["certify"] else "rest"
        options["time_limit"] = None if draw.chance(0.5) else 2.0
        yield from of_run(sf.simulate(body, q, qdot, **law, **options))
    else:
        local = body.local()
        gaps, rates = draw.numbers(0.125, 1, 2), draw.numbers(-1, 1, 2)
        yield from of_run(local.simulate(gaps, rates, **options))
        orbit = local.orbit(gaps, rates, 100)
        yield from (orbit.contacts, orbit.shapes, orbit.log_sizes, orbit.end)
        fate = local.fate(gaps, rates)
        yield from (fate.kind, fate.contact, fate.certified, fate.hits, fate.sigma)


def one_batch(k: int) -> Iterator[object]:
    draw = Draw(2, k)
    ground = GROUNDS[k // 3 % 4]
    body = posture(draw, 1 + k % 3, ground)
    starts = [state(draw, body) for _ in range(24)]
    q, qdot = (np.array(column) for column in zip(*starts, strict=True))
    model = draw.of(MODELS)
    options = {
        "model": model if ground in STRAIGHT else "full",
        "event_limit": EVENTS,
        "time_limit": 2.0,
    }
    if k % 5 == 0:
        options["impact"] = draw.of(LAWS[1:])
    else:
        options |= {"impact": "newton", "stop": draw.of(["rest", "zeno"])}
    runs = sf.simulate_many(body, q, qdot, **options)
    yield from (runs.outcome.tolist(), runs.time, runs.elapsed, runs.q, runs.qdot)
    yield from (runs.collisions, runs.zeno_kind.tolist(), runs.zeno_contact)
    yield from (runs.zeno_time, runs.zeno_elapsed, runs.warned)


def one_verdict(k: int) -> Iterator[object]:
    draw = Draw(3, k)
    body = posture(draw, 2, draw.of(["lines", "level"]))
    yield from of_verdict(sf.stability(body, trials=4 if k % 10 == 0 else 0, seed=k))
    yield from (sf.equilibrium_region(body), sf.friction_margin(body))
    yield from sf.static_forces(body) or ()


def one_problem(k: int) -> Iterator[object]:
    draw = Draw(4, k)
    body = posture(draw, 1 + k % 4, draw.of(["lines", "level", "polyline"]))
    moving = np.zeros(3) if draw.chance(0.5) else draw.numbers(-0.5, 0.5)
    method = "qp" if k % 7 == 0 else "enumerate"
    wrench = draw.numbers(-4, 4) if draw.chance(0.5) else np.zeros(3)
    yield from of_modes(
        sf.contact_modes(body, (0, 0, 0), moving, method=method, wrench=wrench)
    )


FAMILIES: dict[str, tuple[Callable[[int], Iterator[object]], int]] = {
    "runs": (one_run, 7200),
    "pairs": (one_pair, 1200),
    "batches": (one_batch, 200),
    "verdicts": (one_verdict, 1200),
    "problems": (one_problem, 1200),
}


def bits(value: object) -> bytes:
    match value:
        case np.ndarray():
            return value.tobytes()
        case float():
            return struct.pack("<d", value)
        case tuple() | list():
            return b"(" + b",".join(map(bits, value)) + b")"
        case _:
            return repr(value).encode()


def block(family: str, numbers: range) -> str:
    answers = FAMILIES[family][0]
    digest = hashlib.sha256()
    for k in numbers:
        try:
            for value in answers(k):
                digest.update(bits(value) + b";")
        except (ValueError, sf.SolverError) as error:
            digest.update(type(error).__name__.encode())
    return digest.hexdigest()[:16]


def lines() -> Iterator[str]:
    """One line per block, in order: family, first scene, digest."""
    with ProcessPoolExecutor() as pool:
        for family, (_, count) in FAMILIES.items():
            blocks = [range(k, min(k + BLOCK, count)) for k in range(0, count, BLOCK)]
            digests = pool.map(block, [family] * len(blocks), blocks, chunksize=4)
            for numbers, digest in zip(blocks, digests, strict=True):
                yield f"{family} {numbers[0]} {digest}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="replace the file")
    found = list(lines())
    if parser.parse_args().write:
        FILE.write_text("\n".join(found) + "\n", encoding="utf-8")
        return 0
    known = set(FILE.read_text(encoding="utf-8").split("\n"))
    other = [line for line in found if line not in known]
    for line in other:
        print(f"differs: {line}, scenes from there on")
    print(f"{len(found) - len(other)} of {len(found)} blocks as before")
    return 1 if other else 0


if __name__ == "__main__":
    sys.exit(main())
