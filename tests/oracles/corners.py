"""Corners by the simulator: one contact rests or slides on the terrain, and the other one lands."""

import math

import numpy as np
import standfast as sf
from bodies import jacobian


def rows_of(posture):
    """Rows N_i and T_i of both contacts at rest, and the direction in which both slide, of length one in the metric of the mass."""
    normals, tangents = jacobian(posture)
    both = np.cross(*normals)
    return (
        normals,
        tangents,
        both / np.linalg.norm(both * [1, 1, posture.gyration_radius]),
    )


def corner_kick(posture, lands, phi):
    """The velocity of a corner at which contact ``lands`` lands. φ = atan(ξ/y); y is the landing speed, and ξ the
    sliding velocity of the other contact, divided by the sliding velocity of that contact in the motion `both`."""
    normals, tangents, both = rows_of(posture)
    holds = 1 - lands
    slip = math.sin(phi) * (tangents[holds] @ both)
    system = [normals[holds], normals[lands], tangents[holds]]
    return np.linalg.solve(system, [0.0, -math.cos(phi), slip])


#: Landing speed below which rounding errors of the simulator decide which of two contacts comes to rest first. Unit: size of the first corner.
SLOWEST = 1e-12


def next_corner(posture, lands, phi, jams="none"):
    """From a corner to the next one by the simulator: (contact that lands, φ, ln G), or None where both contacts come to rest
    or slide before it."""
    _, tangents, both = rows_of(posture)
    qdot = corner_kick(posture, lands, phi)
    run = sf.simulate(
        posture, (0, 0, 0), qdot, model="local", time_limit=1e6, event_limit=5000, jams=jams, impact="newton"
    )  # fmt: skip
    for phase in run.phases:
        held = [k for k in (0, 1) if phase.mode[k] != "S"]
        if len(held) == 2 and phase.end > phase.start:
            return None
        hits = run.impacts[np.isclose(run.impacts["time"], phase.end, rtol=1e-14, atol=0)]  # fmt: skip
        if len(held) != 1 or phase.end <= phase.start or len(hits) == 0:
            continue
        (k,), length = held, phase.end - phase.start
        m = int(hits["contact"][0]) - 1
        if m == k or -hits["rates_before"][0][m] < SLOWEST:
            continue
        # Speeds are linear within a phase.
        slips = [
            tangents[k] @ run.at(phase.start + share * length)[1]
            for share in (0.25, 0.75)
        ]
        xi = slips[1] + 0.5 * (slips[1] - slips[0])
        xi /= tangents[k] @ both
        y = -hits["rates_before"][0][m]
        return m, math.atan2(xi, y), math.log(math.hypot(xi, y))
    return None
