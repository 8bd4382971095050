"""The numbers of paper.md, computed anew: `make paper`. Prints each sentence that has one, and fails where the paper says something else."""

import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import standfast as sf

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "site"))
import beside_an_engine as throw  # noqa: E402


def thrown_box() -> Iterator[str]:
    box = sf.Posture.box(throw.WIDTH, throw.HEIGHT, friction=0.5, restitution=0.3)
    run = sf.simulate(box, throw.START, throw.VELOCITY)
    yield f"{run.collisions} times one by one"
    yield f"{len(run.zeno_points)} Zeno points"
    yield f"at rest after {run.time:.10f} s"
    yield f"up to {100 * throw.away(run, throw.FRAME)[0].max():.0f} cm away"
    yield f"comes to {100 * throw.away(run, 1e-4)[0].max():.1f} cm"


def body_in_a_v() -> Iterator[str]:
    legs = [
        sf.Contact((x, 8 / 15), slope=x * math.atan(8 / 15), friction=0.5)
        for x in (-1, 1)
    ]
    body = sf.Posture(1, 0.4, (0, 0), legs, restitution=0.1)
    places = {
        "center_of_mass.x": np.linspace(-1.3, 1.3, 60),
        "center_of_mass.y": np.linspace(-1, 3, 60),
    }
    grid = sf.sweep(body, over=places, quantity=["theorem_3", "stability"])
    words = grid["stability"].values
    yield f"stable for {100 * float(grid['theorem_3'].mean()):.0f} % of a grid"
    yield f"for {100 * (words == 'stable').mean():.0f} % by all arguments"
    yield f"{'none' if not (words == 'undecided').any() else 'some'} of which leaves a place undecided"


def pulses() -> Iterator[str]:
    block = sf.Posture.box(1.0, 4.0, friction=1.0)
    phase = np.linspace(0, 1, 49)
    motions = []
    for amplitude in np.linspace(0.5, 6.0, 24):
        sine = amplitude * 9.81 / 4 * np.sin(2 * np.pi * phase)
        sine[-1] = 0
        motions += [
            sf.GroundMotion.from_record((phase / frequency, sine))
            for frequency in np.linspace(0.2, 2.0, 24)
        ]
    ends = sf.simulate_many(block, (0, 0, 0), (0, 0, 0), ground_motion=motions)
    fallen = int((np.abs(ends.q[:, 2]) > 1).sum())
    yield f"Of {len(motions)} pulses of the ground, one cycle of a sine each, {fallen} overturn"


def dropped_phone() -> Iterator[str]:
    phone = sf.Posture.box(0.147, 0.008, mass=0.18, friction=0.3, restitution=0.5)
    corners = (
        np.array([contact.point for contact in phone.contacts]) - phone.center_of_mass
    )
    fastest = 0.0
    for angle in np.radians(np.arange(0, 360, 0.5)):
        lowest = min(corners @ [math.sin(angle), math.cos(angle)])
        height = 1 - lowest - phone.center_of_mass[1]
        hits = sf.simulate(phone, q=(0, height, angle)).impacts
        speeds = -hits["rates_before"][np.arange(len(hits)), hits["index"]]
        fastest = max(fastest, speeds.max())
    yield f"up to {fastest / math.sqrt(2 * 9.81):.3f} times the speed of the first"


if __name__ == "__main__":
    paper = re.sub(r"\s+", " ", (HERE / "paper.md").read_text(encoding="utf-8"))
    wrong = 0
    for part in (thrown_box, body_in_a_v, pulses, dropped_phone):
        for sentence in part():
            wrong += sentence not in paper
            print("ok    " if sentence in paper else "DIFFERS", sentence)
    sys.exit(wrong > 0)
