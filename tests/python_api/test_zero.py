"""Zero has no sign in results: not in arrays, not in JSON, not in printed texts."""

import dataclasses
import math
import os
import re

import numpy as np
import standfast as sf
from bodies import order_for

SCENES = int(os.environ.get("STANDFAST_ZERO_SCENES", "120"))

# A signed zero that is a complete number, not the beginning of -0.5 or the end of 1e-0.
SIGNED = re.compile(r"(?<![\w.])-0(\.0*)?(?![\w.])")


def signed_zeros(found, where):
    """The places of signed zeros in numbers, arrays, texts, containers and objects of the package."""
    if isinstance(found, str):
        return [f"{where}: {found}"] if SIGNED.search(found) else []
    if isinstance(found, float | np.floating):
        return [where] if found == 0 and math.copysign(1, found) < 0 else []
    if isinstance(found, np.ndarray):
        if found.dtype.names:
            parts = {name: found[name] for name in found.dtype.names}
            return signed_zeros(parts, where)
        signed = found.dtype.kind == "f" and ((found == 0) & np.signbit(found)).any()
        return [where] if signed else []
    if isinstance(found, dict):
        return [z for k, v in found.items() for z in signed_zeros(v, f"{where}.{k}")]
    if isinstance(found, list | tuple):
        return [z for v in found for z in signed_zeros(v, where)]
    if type(found).__module__.startswith("standfast") and not isinstance(
        found, sf.Posture
    ):
        names = [name for name in dir(type(found)) if not name.startswith("_")]
        values = [(name, getattr(found, name)) for name in names]
        plain = {name: value for name, value in values if not callable(value)}
        return signed_zeros({**plain, "repr": repr(found), "str": str(found)}, where)
    return []


@dataclasses.dataclass
class Dice:
    random: np.random.Generator

    def pick(self, *choices):
        return choices[self.random.integers(len(choices))]

    def state(self):
        """A configuration and a velocity with many zeros of both signs."""
        q = (self.pick(0.0, -0.0, 0.1), self.pick(0.0, 0.5), self.pick(0.0, -0.0, 0.01))
        qdot = (
            self.pick(0.0, -0.0, 0.5, -0.5),
            self.pick(0.0, -0.0, -1.0),
            self.pick(-0.0, 0.3),
        )
        return q, qdot

    def posture(self):
        places = self.random.permutation([-1.0, -0.5, -0.0, 0.5, 1.0])[
            : self.pick(1, 2, 2, 3)
        ]
        friction = self.pick(0.0, 0.5, 2.0)
        return sf.Posture(
            mass=1.0,
            gyration_radius=self.pick(0.3, 1.0),
            center_of_mass=(self.pick(0.0, -0.0, 0.2), self.pick(0.0, 0.5, 1.0)),
            contacts=[
                sf.Contact((x, 0.0), slope=self.pick(0.0, -0.0, 0.3), friction=friction)
                for x in places
            ],
            restitution=self.pick(0.0, 0.1, 0.5),
            gravity=self.pick(0.0, 9.81, 9.81),
        )


def results(dice, posture, q, qdot):
    """All results of a motion and of a posture."""
    law = dice.pick(
        "newton", "newton", "poisson", "moreau", "stronge", "chatterjee-ruina"
    )
    options = {
        "model": dice.pick("auto", "local", "full"),
        "impact": law,
        "simultaneous": order_for(law),
        "time_limit": 5.0,
        "event_limit": 3000,
    }
    run = sf.simulate(posture, q, qdot, **options)
    told = run.to_dict()
    given = {key: told.pop(key) for key in ("posture", "options")}
    assert given["options"]["time"] == 0
    yield {"run": run, "json": told, "sample": run.sample(20)}
    times = run.sample(20)[0]
    yield {"energy": run.energy(times), "gaps_at": run.gaps_at(times)}
    yield {"gap_rates_at": run.gap_rates_at(times)}
    yield {"runs": sf.simulate_many(posture, q, qdot, **options)}
    yield {"gaps": posture.gaps(q), "rates": posture.gap_rates(q, qdot)}
    yield {
        "region": sf.equilibrium_region(posture),
        "forces": sf.static_forces(posture),
    }
    yield {"margin": sf.friction_margin(posture)}
    modes = sf.contact_modes(posture)
    yield {"modes": modes, **{word: modes[word] for word in modes}}
    if len(posture.contacts) == 2:
        yield {
            name: getattr(posture, name) for name in ("psi", "phi", "normal_gravity")
        }
        verdict = sf.stability(posture)
        yield {"verdict": verdict, "json": verdict.to_dict()}
        model = posture.local()
        run = model.simulate((-0.0, 0.1), (-0.0, -1.0), -0.0, -0.0, time_limit=5.0)
        yield {"model": model, "run": run, "gaps_at": run.gaps_at(run.sample(9)[0])}


def test_zero_has_no_sign():
    dice, signed, asked = Dice(np.random.default_rng(7)), [], 0
    for _ in range(SCENES):
        posture, (q, qdot) = dice.posture(), dice.state()
        if min(posture.gaps(q)) < -1e-12:
            continue
        for found in results(dice, posture, q, qdot):
            signed += signed_zeros(found, "")
            asked += 1
    assert asked > 3 * SCENES
    assert signed == []


def test_the_search_for_signed_zeros_finds_them():
    table = np.array([(1.0, (-0.0, 1.0))], dtype=[("a", "f8"), ("b", "f8", (2,))])
    assert signed_zeros({"x": [table, 0.0, "1e-0 -0.5 0.0"], "y": (-0.0,)}, "") == [
        ".x.b",
        ".y",
    ]
    assert signed_zeros("at (-0.0, 1)", "")
    assert signed_zeros("at -0 m", "")


def test_the_sign_of_a_zero_given_changes_nothing():
    rod = sf.Posture.rod(
        half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.3
    )
    for model in ("local", "full"):
        runs = [
            sf.simulate(
                rod, (zero, 0.1, zero), (zero, zero, 0.2), model=model
            ).to_dict()
            for zero in (0.0, -0.0)
        ]
        assert repr(runs[0]) == repr(runs[1])
