"""Bodies on three and more contacts: rays, jams and the least rise, in numpy."""

import itertools
import math

import numpy as np
import standfast as sf
from bodies import jacobian


def draw_feet(rng, count, steep=1.2):
    """A body on this many contacts at random, its centre of mass over the equilibrium region."""
    while True:
        feet = [
            sf.Contact(
                (rng.uniform(-1, 1), rng.uniform(-0.6, 0.6)),
                slope=rng.uniform(-steep, steep),
                friction=rng.uniform(0.05, 1),
            )
            for _ in range(count)
        ]
        rho, e = rng.uniform(0.2, 1), rng.uniform(0, 0.9)
        height = rng.uniform(0.3, 1.6)
        at = sf.equilibrium_region(sf.Posture(1, rho, (0, height), feet, e))
        if at is None:
            continue
        low, high = max(at[0], -1.5), min(at[1], 1.5)
        if high - low > 1e-3:
            return sf.Posture(1, rho, (rng.uniform(low, high), height), feet, e)


def scaled_rows(posture):
    """N and T in the coordinates (x, y, ρθ), (n, 3) each."""
    rho = posture.gyration_radius
    normals, tangents = jacobian(posture)
    scale = np.array([1, 1, 1 / rho])
    return normals * scale, tangents * scale


def rays(posture):
    """(i, j, z): the directions of length 1 in which exactly these two contacts stay closed."""
    normals, _ = scaled_rows(posture)
    found = []
    for i, j in itertools.combinations(range(len(normals)), 2):
        z = np.cross(normals[i], normals[j])
        z /= np.linalg.norm(z)
        others = [k for k in range(len(normals)) if k not in (i, j)]
        for side in (1, -1):
            if np.all(normals[others] @ (side * z) > 0):
                found.append((i, j, side * z))
    return found


def stiffness(posture, i, sigma):
    """N_i (N_i − σμ_iT_i)ᵀ"""
    normals, tangents = scaled_rows(posture)
    mu = posture.contacts[i].friction
    return normals[i] @ (normals[i] - sigma * mu * tangents[i])


def slide_exists(posture, pair, z):
    """Whether some word continues the slide of both contacts of a pair with the velocity z."""
    normals, tangents = scaled_rows(posture)
    g = 9.81 * normals[list(pair), 1]
    rub = [
        math.copysign(posture.contacts[i].friction, tangents[i] @ z) * tangents[i]
        for i in pair
    ]
    a = np.array(
        [[normals[i] @ (normals[j] - rub[n]) for n, j in enumerate(pair)] for i in pair]
    )
    words = [np.all(np.linalg.solve(a, g) >= 0), bool(np.all(g < 0))]
    for k in range(2):
        m = 1 - k
        force = g[k] / a[k, k]
        words.append(force >= 0 and a[m, k] * force > g[m])
    return any(words)


def jams(posture, found):
    """The jams of exposed contacts, ((i,), direction), and of pairs on their rays, ((i, j), directions)."""
    normals, tangents = scaled_rows(posture)
    exposed = sorted({i for ray in found for i in ray[:2]})
    result = [
        ((i,), "R" if sigma > 0 else "L")
        for i in exposed
        for sigma in (1, -1)
        if stiffness(posture, i, sigma) < 0 and normals[i, 1] > 0
    ]
    for i, j, z in found:
        for side in (1, -1):
            if not slide_exists(posture, (i, j), side * z):
                ways = [side * (tangents[k] @ z) > 0 for k in (i, j)]
                result.append(((i, j), "".join("R" if w else "L" for w in ways)))
    return result


def width(found):
    """Least y/max(|x|, |y|, ρ|θ|) on the rays."""
    return min(z[1] / np.abs(z).max() for *_, z in found)
