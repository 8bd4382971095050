"""Assemblies of bodies: their rows anew, linear programmes of scipy, a solver of linear complementarity problems, and scenes."""

from itertools import pairwise, product

import numpy as np
import standfast as sf
from scipy.optimize import linprog

G = 9.81
#: A solution of a linear complementarity problem, relative to its largest constant: rounding of some hundred steps.
ACCURACY = 1e-10
#: An acceleration, relative to gravity, from which a letter moves: above the error of the linear programmes, below what random scenes meet.
TIE = 1e-7


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


def programme(system, push=None, cost=None, load=0):
    """Whether forces hold the assembly, with a load beside its weights; with a push, the largest multiple of it that they hold; with a cost (2k,), the forces of least cost."""
    columns, weights = equations(system)
    count = columns.shape[1] // 2
    cone = np.zeros((2 * count, 2 * count))
    for k, contact in enumerate(system.contacts):
        for row, side in ((2 * k, 1), (2 * k + 1, -1)):
            cone[row, 2 * k], cone[row, 2 * k + 1] = side, -contact.friction
    bounds = [(None, None), (0, None)] * count
    cost, equal = np.zeros(2 * count) if cost is None else cost, columns
    if push is not None:
        cost, equal = np.append(cost, -1), np.column_stack([columns, push])
        cone = np.column_stack([cone, np.zeros(2 * count)])
        bounds = [*bounds, (0, None)]
    return linprog(
        cost,
        A_ub=cone,
        b_ub=np.zeros(2 * count),
        A_eq=equal,
        b_eq=-(weights + load),
        bounds=bounds,
        method="highs-ds",
        options={
            "primal_feasibility_tolerance": 1e-10,
            "dual_feasibility_tolerance": 1e-10,
        },
    )


def extremes(system):
    """Least and largest (tangential, normal) force of each contact, (k, 2) each; ±inf where there is no bound."""
    ends = []
    for side in (1, -1):
        costs = side * np.eye(2 * len(system.contacts))
        found = [programme(system, cost=cost) for cost in costs]
        ends.append([side * (-np.inf if f.status == 3 else f.fun) for f in found])
    return [np.reshape(end, (-1, 2)) for end in ends]


def complementary(A, b, cover=None):
    """z ≥ 0 with A z + b ≥ 0 and z·(A z + b) = 0, by the method of Lemke with lexicographic ratios; None if it ends in a ray. With another cover, (n,)
    > 0, it may be another solution."""
    n = len(b)
    if (b >= 0).all():
        return np.zeros(n)
    cover = np.ones(n) if cover is None else cover
    # w − A z − d z0 = b.
    matrix = np.column_stack([np.eye(n), -A, -cover])
    tableau = np.column_stack([matrix, b])
    basis = list(range(n))
    entering = 2 * n
    for step in range(50 * n):
        column = tableau[:, entering]
        if step == 0:
            row = int(np.argmin(b / cover))
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
        others = np.delete(np.arange(n), row)
        tableau[others] -= np.outer(tableau[others, entering], tableau[row])
        basis[row] = entering
        if leaving == 2 * n:
            z = np.zeros(2 * n + 1)
            # Once more from the given numbers: a tableau gathers rounding.
            z[basis] = np.linalg.lstsq(matrix[:, basis], b, rcond=None)[0]
            return z[n : 2 * n]
        entering = leaving + n if leaving < n else leaving - n
    return None


def accelerations(system, push, cover=None):
    """One solution of the frictional contact problem at rest, (3n,): unknown f_n, the two sides of f_t, and |a_t|. None if none is found that obeys its
    laws to ACCURACY. cover : a positive number for each unknown, (4k,)."""
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
    z = complementary(A, b, cover)
    if z is None:
        return None
    slack = A @ z + b
    if max(-z.min(), -slack.min(), np.minimum(z, slack).max()) > ACCURACY * (1 + np.abs(b).max()):  # fmt: skip
        return None
    forces = np.zeros(2 * k)
    forces[1::2], forces[::2] = z[:k], z[k : 2 * k] - z[2 * k : 3 * k]
    return inverse * (weights + push + columns @ forces)


def words(system, push):
    """All words that Coulomb's law allows at rest, by a linear programme for each; those that move have accelerations above TIE · g."""
    columns, weights = equations(system)
    inverse = 1 / masses(system)
    free = inverse * (weights + push)
    found = []
    for word in map("".join, product("SFRL", repeat=len(system.contacts))):
        edges, equal, above = [], [], []
        for k, (letter, contact) in enumerate(zip(word, system.contacts, strict=True)):
            t, n, mu = columns[:, 2 * k], columns[:, 2 * k + 1], contact.friction
            sides = {"S": [], "F": [-1, 1], "R": [-1], "L": [1]}[letter]
            edges += [n + side * mu * t for side in sides]
            equal += {"S": [], "F": [n, t], "R": [n], "L": [n]}[letter]
            above += {"S": [n], "F": [], "R": [t], "L": [-t]}[letter]
        edges = np.array(edges).reshape(-1, len(free))
        to = lambda rows: np.array(rows).reshape(-1, len(free)) @ (inverse[:, None] * edges.T)  # noqa: E731, B023  # fmt: skip
        of = lambda rows: np.array(rows).reshape(-1, len(free)) @ free  # noqa: E731
        if not len(edges):
            possible = (of(above) > TIE * G).all()
        else:
            possible = linprog(
                np.zeros(len(edges)),
                A_ub=-to(above) if above else None,
                b_ub=of(above) - TIE * G if above else None,
                A_eq=to(equal) if equal else None,
                b_eq=-of(equal) if equal else None,
                method="highs-ds",
            ).status == 0  # fmt: skip
        if possible:
            found.append(word)
    return found


def breach(system, mode, push=0):
    """The largest breach of the equations of motion and of Coulomb's law by a mode under a push beside gravity, relative to gravity and the largest
    weight."""
    columns, weights = equations(system)
    load = weights + push
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


def tower(rng, least=2, most=6, angle=0.0):
    """Blocks on each other, on ground of this slope."""
    line = np.array([np.cos(angle), np.sin(angle)])
    ground = 0.0 if angle == 0 else [(-20 * line).tolist(), (20 * line).tolist()]
    bodies, x, y = [], 0.0, 0.0
    for _ in range(rng.integers(least, most + 1)):
        w, h = rng.uniform(0.4, 1.5), rng.uniform(0.2, 1.0)
        at = x * line + y * np.array([-line[1], line[0]])
        bodies.append(sf.Block(w, h, at=at, turn=angle, friction=rng.uniform(0.1, 0.9)))
        x, y = x + rng.uniform(-0.2, 0.2), y + h
    return bodies, ground


def bridge(rng):
    """One beam or two on pillars of one height, some with a block on them."""
    count, h = rng.integers(2, 4), rng.uniform(0.3, 1)
    bodies = [sf.Block(rng.uniform(0.3, 0.6), h, at=(k, 0)) for k in range(count)]
    width = count - rng.uniform(0.1, 0.8)
    middle = (count - 1) / 2 + rng.uniform(-0.3, 0.3)
    bodies.append(sf.Block(width, 0.25, at=(middle, h)))
    if rng.random() < 0.5:
        at = (middle + rng.uniform(-0.5, 0.5), h + 0.25)
        bodies.append(sf.Block(rng.uniform(0.2, 0.6), rng.uniform(0.2, 1), at=at))
    return bodies, 0.0


def pyramid(rng):
    """Each row has one brick less than the row below it."""
    base, h = rng.integers(2, 4), rng.uniform(0.2, 0.8)
    place = lambda row, k: (k + row / 2 + rng.uniform(-0.1, 0.1), row * h)  # noqa: E731
    return [
        sf.Block(rng.uniform(0.6, 0.8), h, at=place(row, k))
        for row in range(base)
        for k in range(base - row)
    ], 0.0


def bond(rng):
    """A wall in running bond."""
    system = wall(int(rng.integers(2, 4)), int(rng.integers(1, 4)), 0.5)
    return list(system.bodies.values()), 0.0


def vault(rng):
    """A round arch."""
    system = arch(int(rng.integers(3, 10)), rng.uniform(0.08, 0.3))
    return list(system.bodies.values()), 0.0


def keystone(rng):
    """A wedge between two blocks with slanted sides."""
    slant, half, h = rng.uniform(0.1, 0.6), rng.uniform(0.1, 0.3), rng.uniform(0.6, 1)
    low, high = rng.uniform(0.1, 0.4) * h, rng.uniform(0.8, 1.2) * h
    at = lambda y: half + slant * y  # noqa: E731
    bodies = []
    for side in (-1, 1):
        far = at(h) + rng.uniform(0.2, 0.8)
        corners = [(at(0), 0), (far, 0), (far, h), (at(h), h)]
        bodies.append(sf.Rigid.polygon([(side * x, y) for x, y in corners]))
    corners = [(-at(low), low), (at(low), low), (at(high), high), (-at(high), high)]
    return [*bodies, sf.Rigid.polygon(corners)], 0.0


def slope(rng):
    """A tower on sloped ground."""
    return tower(rng, 1, 4, rng.uniform(-0.5, 0.5))


KINDS = (tower, bridge, pyramid, bond, vault, keystone, slope)


def drawn(rng, kind, restitution=0.0):
    """A random assembly of this kind."""
    bodies, ground = kind(rng)
    return sf.System(
        bodies,
        friction=rng.uniform(0.1, 0.9),
        ground=ground,
        restitution=restitution,
        tangential_restitution=restitution,
    )


def pushed(system, rng):
    """A random push beside gravity, (3n,), N and N m, with the arguments of `load_factor` and `onset` for it: a wrench on a body, or level on all."""
    push = np.zeros(system.dof)
    if rng.random() < 0.5:
        name = str(rng.choice(list(system.bodies)))
        wrench = rng.normal(size=3) * system.bodies[name].mass * G / 2
        at = 3 * list(system.bodies).index(name)
        push[at : at + 3] = wrench
        return push, {"load": {name: wrench}}
    size = rng.uniform(-1, 1) * G
    push[0::3] = masses(system)[0::3] * size
    return push, {"acceleration": (size, 0)}
