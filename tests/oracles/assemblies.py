"""Assemblies of bodies: their rows anew, linear programmes of scipy, a solver of linear complementarity problems, and scenes."""

from itertools import pairwise

import numpy as np
import standfast as sf
from scipy.optimize import linprog

G = 9.81


# Rows of an assembly, anew: its bodies and contacts are read, the rest is done here.


def equations(system):
    """Columns of the wrenches on all bodies (3n, 2k) of unit forces (tangential, normal), and the weights (3n,)."""
    bodies = list(system.bodies)
    columns = np.zeros((3 * len(bodies), 2 * len(system.contacts)))
    for k, contact in enumerate(system.contacts):
        t = contact.tangent
        n = np.array([-t[1], t[0]])
        for name, sign in zip(contact.bodies, (1, -1), strict=True):
            if name is None:
                continue
            at = 3 * bodies.index(name)
            arm = contact.point - system.bodies[name].center_of_mass
            for column, direction in ((2 * k, t), (2 * k + 1, n)):
                moment = arm[0] * direction[1] - arm[1] * direction[0]
                columns[at : at + 3, column] += sign * np.array([*direction, moment])
    weights = np.zeros(3 * len(bodies))
    weights[1::3] = [-system.gravity * body.mass for body in system.bodies.values()]
    return columns, weights


def masses(system):
    each = [[b.mass, b.mass, b.mass * b.gyration_radius**2] for b in system.bodies.values()]  # fmt: skip
    return np.concatenate(each)


def programme(system, push=None):
    """Whether forces hold the assembly; with a push, the largest multiple of it that they hold."""
    columns, weights = equations(system)
    count = columns.shape[1] // 2
    cone = np.zeros((2 * count, 2 * count))
    for k, contact in enumerate(system.contacts):
        for row, side in ((2 * k, 1), (2 * k + 1, -1)):
            cone[row, 2 * k], cone[row, 2 * k + 1] = side, -contact.friction
    bounds = [(None, None), (0, None)] * count
    cost, equal = np.zeros(2 * count), columns
    if push is not None:
        cost, equal = np.append(cost, -1), np.column_stack([columns, push])
        cone = np.column_stack([cone, np.zeros(2 * count)])
        bounds = [*bounds, (0, None)]
    return linprog(
        cost,
        A_ub=cone,
        b_ub=np.zeros(2 * count),
        A_eq=equal,
        b_eq=-weights,
        bounds=bounds,
        method="highs-ds",
        options={
            "primal_feasibility_tolerance": 1e-10,
            "dual_feasibility_tolerance": 1e-10,
        },
    )


def complementary(A, b):
    """z ≥ 0 with A z + b ≥ 0 and z·(A z + b) = 0, by the method of Lemke with lexicographic ratios; None if it ends in a ray."""
    n = len(b)
    if (b >= 0).all():
        return np.zeros(n)
    # w − A z − d z0 = b.
    tableau = np.column_stack([np.eye(n), -A, -np.ones(n), b]).astype(float)
    basis = list(range(n))
    entering = 2 * n
    for step in range(50 * n):
        column = tableau[:, entering]
        if step == 0:
            row = int(np.argmin(b))
        else:
            rows = np.flatnonzero(column > 1e-11)
            if not len(rows):
                return None
            keys = np.column_stack([tableau[rows, -1], tableau[rows, :n]]) / column[rows, None]  # fmt: skip
            keys = np.round(keys / (1e-11 + np.abs(keys).max(axis=0)), 10)
            order = np.lexsort(keys.T[::-1])
            tied = [r for r in rows[order] if abs(tableau[r, -1] / column[r] - tableau[rows[order[0]], -1] / column[rows[order[0]]]) < 1e-11]  # fmt: skip
            row = next((r for r in tied if basis[r] == 2 * n), rows[order[0]])
        leaving = basis[row]
        tableau[row] /= tableau[row, entering]
        for other in range(n):
            if other != row:
                tableau[other] -= tableau[other, entering] * tableau[row]
        basis[row] = entering
        if leaving == 2 * n:
            z = np.zeros(2 * n + 1)
            z[basis] = tableau[:, -1]
            return z[n : 2 * n]
        entering = leaving + n if leaving < n else leaving - n
    return None


def accelerations(system, push):
    """One solution of the frictional contact problem at rest, (3n,): unknown f_n, the two sides of f_t, and |a_t|."""
    columns, weights = equations(system)
    inverse = 1 / masses(system)
    T, N = columns[:, ::2].T, columns[:, 1::2].T
    W = columns.T @ (inverse[:, None] * columns)
    free = inverse * (weights + push)
    k = len(N)
    mu = np.diag([contact.friction for contact in system.contacts])
    Wn, Wt, Wnt = W[1::2, 1::2], W[::2, ::2], W[1::2, ::2]
    one, zero = np.eye(k), np.zeros((k, k))
    A = np.block(
        [
            [Wn, Wnt, -Wnt, zero],
            [Wnt.T, Wt, -Wt, one],
            [-Wnt.T, -Wt, Wt, one],
            [mu, -one, -one, zero],
        ]
    )
    b = np.concatenate([N @ free, T @ free, -T @ free, np.zeros(k)])
    z = complementary(A, b)
    if z is None:
        return None
    forces = np.zeros(2 * k)
    forces[1::2], forces[::2] = z[:k], z[k : 2 * k] - z[2 * k : 3 * k]
    return inverse * (weights + push + columns @ forces)


def breach(system, mode, push=None):
    """The largest breach of the equations of motion and of Coulomb's law by a mode, relative to gravity and the largest weight."""
    columns, weights = equations(system)
    load = weights if push is None else weights + mode.factor * push
    inertia = masses(system) * mode.acceleration - load - columns @ mode.forces.ravel()
    along, normal = (columns.T @ mode.acceleration).reshape(-1, 2).T
    tangential, pressing = mode.forces.T
    limit = np.array([contact.friction for contact in system.contacts]) * pressing
    weight = np.abs(weights).max()
    worst = [np.abs(inertia).max() / weight]
    for k, letter in enumerate(mode.word):
        force, motion = {
            "S": ([abs(tangential[k]), abs(pressing[k])], [-normal[k]]),
            "F": ([abs(tangential[k]) - limit[k]], [abs(normal[k]), abs(along[k])]),
            "R": ([abs(tangential[k] + limit[k])], [abs(normal[k]), -along[k]]),
            "L": ([abs(tangential[k] - limit[k])], [abs(normal[k]), along[k]]),
        }[letter]
        worst += [*np.array([*force, -pressing[k]]) / weight, *np.array(motion) / G]
    return max(worst)


# Scenes.


def stack(rng):
    """A tower, two towers with a beam, or a running bond."""
    kind = rng.integers(3)
    if kind == 0:
        bodies, y = [], 0.0
        for _ in range(rng.integers(1, 5)):
            w, h = rng.uniform(0.4, 1.5), rng.uniform(0.2, 1.0)
            bodies.append(sf.Block(w, h, at=(rng.uniform(-0.4, 0.4), y)))
            y += h
    elif kind == 1:
        h = rng.uniform(0.3, 1)
        bodies = [sf.Block(0.4, h, at=(0, 0)), sf.Block(0.5, h, at=(1.1, 0))]
        bodies.append(sf.Block(1.5, 0.25, at=(rng.uniform(0.4, 0.8), h)))
        if rng.random() < 0.5:
            bodies.append(sf.Block(0.3, 0.4, at=(rng.uniform(0.2, 1), h + 0.25)))
    else:
        bodies = [sf.Block(1, 0.4, at=(0.5 + k, 0)) for k in range(2)]
        shift = rng.uniform(0.2, 0.8)
        bodies += [sf.Block(1, 0.4, at=(k + shift, 0.4)) for k in range(2)]  # fmt: skip
    return sf.System(bodies, friction=rng.uniform(0.1, 0.9))


def arch(n, thickness, friction=0.9):
    """A round arch of n voussoirs, its middle line of radius 1 m."""
    angles = np.linspace(0, np.pi, n + 1)
    low, high = 1 - thickness / 2, 1 + thickness / 2
    at = lambda r, a: (r * np.cos(a), r * np.sin(a))  # noqa: E731
    return sf.System(
        [
            sf.Rigid.polygon([at(low, a), at(high, a), at(high, b), at(low, b)])
            for a, b in pairwise(angles)
        ],
        friction=friction,
    )


def wall(rows, columns, friction):
    """Bricks of 2 by 1 m in running bond."""
    bricks = []
    for row in range(rows):
        ends = np.arange(columns + 1) * 2.0
        if row % 2:
            ends = np.array([0, *(ends[:-1] + 1), ends[-1]])
        bricks += [sf.Block(b - a, 1, at=((a + b) / 2, row)) for a, b in pairwise(ends)]
    return sf.System(bricks, friction=friction)
