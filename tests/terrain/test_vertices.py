"""Contacts in concave vertices of their terrain: held while the force is in the hull of the friction cones of both pieces."""

import itertools
import math
import os
from collections import Counter

import numpy as np
import pytest
import standfast as sf
from bodies import valley
from scipy.integrate import solve_ivp
from scipy.optimize import nnls

#: Number of random starts in a vertex, and of random runs in a valley.
SCENES = int(os.environ.get("STANDFAST_VERTICES", "60"))
#: Number of random scenes that a fixed-step method simulates as well.
STEPPED = int(os.environ.get("STANDFAST_VERTICES_STEPPED", "4"))
G = 9.81
WIDE = 50.0


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def turned(theta, arm):
    c, s = math.cos(theta), math.sin(theta)
    return np.array([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])


@pytest.mark.parametrize(
    ("mu", "rho", "com", "omega", "left", "slope", "end"),
    [
        (1.0, 0.9, (0.887, -0.461), 3.55, 0.1, 0.12, 0.3),
        # The cones span more than half a turn: wedged, it could also stay.
        (2.0, 0.6, (0.47, 0.24), 5.9, 0.05, 1.19, 0.15),
    ],
)
def test_a_contact_leaves_the_vertex_at_the_edge_of_one_cone(
    mu, rho, com, omega, left, slope, end
):
    """A body swings about a contact in a vertex. By the balance of forces it slips and slides up the right piece."""
    com = np.array(com)
    posture = sf.Posture(
        1.0,
        rho,
        com,
        [sf.Contact((0, 0), friction=mu)],
        0.0,
        G,
        terrain=valley(math.tan(left), math.tan(slope), 10),
    )
    qdot = (-omega * com[1], omega * com[0], omega)
    run = sf.simulate(
        posture, (0, 0, 0), qdot, model="full", stop="time", time_limit=end
    )

    # About the fixed point, with z from it to the centre of mass: θ̈ = −g z_x/(ρ² + |z|²), F = r̈ + (0, g).
    n, t = (
        np.array([-math.sin(slope), math.cos(slope)]),
        np.array([math.cos(slope), math.sin(slope)]),
    )

    def swing(theta, omega):
        z = turned(theta, com)
        alpha = -G * z[0] / (rho**2 + z @ z)
        force = alpha * np.array([-z[1], z[0]]) - omega**2 * z + (0, G)
        return alpha, force

    def edge(
        _, y
    ):  # margin of the force to the edge at which the contact slides up, to the right
        force = swing(*y)[1]
        return mu * (force @ n) + force @ t

    edge.terminal = True
    tight = {"rtol": 1e-13, "atol": 1e-14, "method": "DOP853"}
    held = solve_ivp(
        lambda _, y: (y[1], swing(*y)[0]), (0, 1), (0, omega), events=edge, **tight
    )
    assert run.phases[1].start == pytest.approx(held.t[-1], abs=1e-12)
    assert (run.phases[1].mode, run.phases[1].cause) == ("R", "slip")

    # Then N n·(…): s along the piece, F = λ (n − μ t), and the contact stays on the piece.
    theta, omega = held.y[:, -1]

    def slide(_, y):
        _, theta, ds, omega = y
        z = turned(theta, com)  # from the contact to the centre of mass
        f = n - mu * t
        # r̈ = s̈ t + α z⊥ − ω² z;   n·r̈ = λ − g n_y,   ρ² α = (−z) × f λ
        turn = cross(-z, f) / rho**2
        perp = np.array([-z[1], z[0]])
        lam = (G * n[1] - omega**2 * (n @ z)) / (1 - turn * (n @ perp))
        alpha = turn * lam
        push = lam * f - (0, G)
        return ds, omega, t @ (push - alpha * perp + omega**2 * z), alpha

    start = (0.0, theta, 0.0, omega)
    after = solve_ivp(slide, (0, end - held.t[-1]), start, **tight).y[:, -1]
    place = after[0] * t + turned(after[1], com) - com
    assert run.q == pytest.approx([*place, after[1]], abs=1e-9)


def draw(rng, start):
    """One to three contacts in a valley, the first in its vertex or all above it."""
    left, right = rng.uniform(0.02, 1.3, 2)
    terrain = valley(math.tan(left), math.tan(right), WIDE)
    com = rng.uniform(-1, 1, 2)
    if rng.random() < 0.5:
        com[1] = abs(com[1])
    friction = rng.choice([0.0, rng.uniform(0, 1.2), rng.uniform(0, 1.2), 2.0])
    points = [(0.0, 0.0)]
    for _ in range(rng.integers(0, 3)):
        x = rng.uniform(-1.5, 1.5)
        ground = np.interp(x, *zip(*terrain, strict=True))
        points.append((x, ground + (rng.uniform(0, 1) if rng.random() < 0.7 else 0)))
    posture = sf.Posture(
        1.0,
        rng.uniform(0.2, 1.2),
        com,
        [sf.Contact(point, friction=friction) for point in points],
        rng.choice([0.0, 0.0, rng.uniform(0, 0.8)]),
        G,
        terrain=terrain,
    )
    if start == "vertex":
        omega = rng.choice([0.0, rng.uniform(-6, 6)])
        return posture, np.zeros(3), np.array([-omega * com[1], omega * com[0], omega])
    high = rng.uniform(0, 1) + 3 * math.tan(max(left, right))
    q = np.array([rng.uniform(-1, 1), high, rng.uniform(-0.5, 0.5)])
    return (
        posture,
        q,
        np.array([rng.uniform(-2, 2), rng.uniform(-1, 1), rng.uniform(-3, 3)]),
    )


def unbalanced(posture, run, points=100):
    """The largest part of the weight that forces in the cones of the touching contacts cannot balance. It is taken
    at 100 points of every phase with a fixed contact, or of the longest part of the phase without an impact.
    Accelerations are differences of velocities. Also the number of phases."""
    com, rho = np.array(posture.center_of_mass), posture.gyration_radius
    pieces = [np.array(pair) for pair in itertools.pairwise(posture.terrain)]
    impacts = run.impacts["time"]
    worst, phases = 0.0, 0
    for phase in run.phases:
        if "F" not in phase.mode:
            continue
        inside = [i for i in impacts if phase.start < i < phase.end]
        parts = itertools.pairwise([phase.start, *inside, phase.end])
        start, end = max(parts, key=lambda part: part[1] - part[0])
        long = end - start
        if long < 1e-6:
            continue
        phases += 1
        d = min(1e-4 / math.sqrt(G), long / 8)
        times = np.linspace(start + d, end - d, points)
        wide = (run.at(times + 0.998 * d)[1] - run.at(times - 0.998 * d)[1]) / (
            1.996 * d
        )
        narrow = (run.at(times + 0.499 * d)[1] - run.at(times - 0.499 * d)[1]) / (
            0.998 * d
        )
        for q, (ax, ay, alpha) in zip(
            run.at(times)[0], (4 * narrow - wide) / 3, strict=True
        ):
            generators = []
            for letter, contact in zip(phase.mode, posture.contacts, strict=True):
                arm = turned(q[2], np.array(contact.point) - com)
                place = com + q[:2] + arm
                for a, b in pieces if letter != "S" else []:
                    length = np.linalg.norm(b - a)
                    t = (b - a) / length
                    n = np.array([-t[1], t[0]])
                    along = (place - a) @ t
                    if abs((place - a) @ n) > 1e-8 or not -1e-8 < along < length + 1e-8:
                        continue
                    for side in {"F": (1, -1), "R": (-1,), "L": (1,)}[letter]:
                        f = n + side * contact.friction * t
                        generators.append([*f, cross(arm, f) / rho])
            need = np.array([ax, ay + G, rho * alpha])
            worst = max(worst, nnls(np.array(generators).T, need)[1] / G)
    return worst, phases


@pytest.mark.parametrize("start", ["vertex", "valley"])
def test_forces_in_a_vertex_lie_in_the_hull_of_both_cones(start):
    phases, outcomes = 0, Counter()
    for k in range(SCENES):
        posture, q, qdot = draw(np.random.default_rng([2, k]), start)
        try:
            run = sf.simulate(posture, q, qdot, model="full", time_limit=3.0)
        except ValueError:  # a contact below the ground
            outcomes["refused"] += 1
            continue
        outcomes[run.outcome] += 1
        worst, held = unbalanced(posture, run)
        phases += held
        assert worst < 1e-6, k
    print(start, dict(outcomes), phases, "phases with a fixed contact")
    assert phases > SCENES // 2
    assert outcomes["refused"] + outcomes["event-limit"] < 0.05 * SCENES + 1


def stepped(posture, q, qdot, time, dt):
    """Moreau's time stepping, plastic: at each step impulses in the cones of all pieces that the contacts touch or penetrate,
    by the method of Gauss and Seidel. Every piece of the valley is a line, because the valley is convex seen from above."""
    com, rho2 = np.array(posture.center_of_mass), posture.gyration_radius**2
    arms = [np.array(c.point) - com for c in posture.contacts]
    friction = posture.contacts[0].friction
    (lx, ly), _, (rx, ry) = posture.terrain
    tangents = [
        np.array([-lx, -ly]) / math.hypot(lx, ly),
        np.array([rx, ry]) / math.hypot(rx, ry),
    ]
    q, v = np.array(q, float), np.array(qdot, float)
    inverse = np.array([1.0, 1.0, 1.0 / rho2])
    impulses = {}
    for _ in range(round(time / dt)):
        half = q + 0.5 * dt * v
        v = v - (0, G * dt, 0)
        rows = []
        for i, arm in enumerate(arms):
            a = turned(half[2], arm)
            place = com + half[:2] + a
            for k, t in enumerate(tangents):
                n = np.array([-t[1], t[0]])
                if n @ place <= 0.0:
                    row_n, row_t = (
                        np.array([*n, cross(a, n)]),
                        np.array([*t, cross(a, t)]),
                    )
                    rows.append(((i, k), row_n, row_t))
        impulses = {key: impulses.get(key, (0.0, 0.0)) for key, *_ in rows}
        for key, row_n, row_t in rows:
            p_n, p_t = impulses[key]
            v = v + inverse * (row_n * p_n + row_t * p_t)
        for _ in range(200):
            change = 0.0
            for key, row_n, row_t in rows:
                p_n, p_t = impulses[key]
                new_n = max(0.0, p_n - (row_n @ v) / (row_n @ (inverse * row_n)))
                v = v + inverse * row_n * (new_n - p_n)
                aim = p_t - (row_t @ v) / (row_t @ (inverse * row_t))
                new_t = min(max(aim, -friction * new_n), friction * new_n)
                v = v + inverse * row_t * (new_t - p_t)
                change = max(change, abs(new_n - p_n), abs(new_t - p_t))
                impulses[key] = (new_n, new_t)
            if change < 1e-12:
                break
        q = half + 0.5 * dt * v
    return q


def test_a_fixed_step_method_converges_to_the_motion_in_a_vertex():
    """One contact that starts in a vertex and is held there: steps a quarter as long give a smaller, and small, error."""
    found, k, farther = 0, 0, 0
    while found < STEPPED:
        k += 1
        posture, q, qdot = draw(np.random.default_rng([3, k]), "vertex")
        if len(posture.contacts) > 1 or posture.restitution > 0.0:
            continue
        time = 0.2
        run = sf.simulate(posture, q, qdot, model="full", stop="time", time_limit=time)
        if run.outcome != "time-limit" or "F" not in run.phases[0].mode:
            continue
        found += 1
        coarse, fine = (
            np.abs(stepped(posture, q, qdot, time, dt) - run.q).max()
            for dt in (4e-4, 1e-4)
        )
        assert fine < 5e-3, (k, coarse, fine)
        farther += fine > 0.5 * coarse + 1e-6
    print(found, "scenes;", farther, "of them not nearer with shorter steps")
    assert farther <= 0.1 * found


def test_a_contact_that_rises_out_of_a_plateau_lands_on_it():
    """A point arrives from beside and below a plateau, rises through its surface at t₁ and lands on it at t₂."""
    table = sf.Posture(
        1.0, 0.1, (0, 0), [sf.Contact((0, 0), segment=(-1.0, 1.0))], 0.0, G
    )
    run = sf.simulate(
        table, (-1.05, -0.5, 0), (1.5, 6.0, 0), stop="time", time_limit=1.4
    )
    down = (6.0 + math.sqrt(36.0 - 2 * G * 0.5)) / G
    assert 0.05 / 1.5 < (6.0 - math.sqrt(36.0 - 2 * G * 0.5)) / G
    assert -1.05 + 1.5 * down < 1.0
    assert run.impacts["time"] == pytest.approx([down], rel=1e-14)
    assert run.at(down + 0.01)[0][1] == pytest.approx(0.0, abs=1e-15)


def test_contacts_that_rise_out_of_a_plateau_while_others_hold_land_on_it():
    """Random bodies near the ends of a plateau: no contact passes down through its surface, and some rise out of it."""
    risen = 0
    for k in range(200):
        rng = np.random.default_rng([9, k])
        points = [
            tuple(rng.uniform((-0.5, 0.05), (0.5, 0.8)))
            for _ in range(rng.integers(1, 4))
        ]
        contacts = [
            sf.Contact(point, friction=rng.choice([0.0, 0.5])) for point in points
        ]
        com = np.array([0.0, 0.5])
        body = sf.Posture(
            1.0, rng.uniform(0.2, 0.6), com, contacts, 0.3, G, terrain=[(-1, 0), (1, 0)]
        )
        side = rng.choice([-1, 1])
        q = (side * rng.uniform(1.2, 1.9), rng.uniform(-1.2, 0.2), 0.0)
        qdot = (-side * rng.uniform(0.5, 3), rng.uniform(0, 6), rng.uniform(-6, 6))
        try:
            run = sf.simulate(body, q, qdot, model="full", time_limit=2.0)
        except ValueError:  # a contact below the plateau
            continue
        states = run.at(np.linspace(0, run.time, 400))[0]
        for point in points:
            arms = [turned(theta, point - com) for theta in states[:, 2]]
            x, h = (com + states[:, :2] + arms).T
            over = (np.abs(x[:-1]) <= 1) & (np.abs(x[1:]) <= 1)
            assert not (over & (h[:-1] > 1e-9) & (h[1:] < -1e-9)).any(), k
            risen += (over & (h[:-1] < -1e-9) & (h[1:] > 1e-9)).sum()
    assert risen > 10


def narrow(seed, angle):
    """A contact thrown into a V with this angle (rad) between its pieces: the posture, q̇ and the tip."""
    rng = np.random.default_rng([11, seed])
    up, far = rng.uniform(0.1, math.pi - 0.1), 3.0
    tip = rng.uniform(-1, 1, 2)
    left, right, at = (
        tip + length * np.array([math.cos(up + turn), math.sin(up + turn)])
        for length, turn in (
            (far, angle / 2),
            (far, -angle / 2),
            (rng.uniform(0.2, 1), 0),
        )
    )
    posture = sf.Posture(
        1.0,
        rng.uniform(0.1, 1),
        at + rng.uniform(-1, 1, 2),
        [sf.Contact(at, friction=rng.choice([0, 0.1, 0.3, 1.0]))],
        rng.choice([0.0, 0.3]),
        G,
        terrain=[left, tip, right],
    )
    return posture, rng.normal(size=3), tip


@pytest.mark.parametrize("angle", [1e-1, 1e-2, 1e-3, 1e-4])
def test_impacts_in_a_narrow_vertex_end_at_rest_in_it(angle):
    """A contact that comes to the tip of a narrow V hits its two pieces in turn, infinitely often at one instant.

    All impulses act at the tip: the angular momentum about it is kept, and the contact has no velocity in the limit. Both
    together determine the velocity of the body.
    """
    ended, checked = Counter(), 0
    for seed in range(SCENES):
        posture, qdot, tip = narrow(seed, angle)
        law = ["newton", "poisson", "stronge", "chatterjee-ruina", "moreau"][seed % 5]
        run = sf.simulate(
            posture,
            (0, 0, 0),
            qdot,
            model="full",
            impact=law,
            time_limit=5,
            event_limit=20000,
        )
        ended[run.outcome] += 1
        at_once = Counter(run.impacts["elapsed"].tolist())
        for zeno in run.zeno_points:
            off = math.dist(run.points_at(zeno.elapsed)[0], tip)
            if at_once[zeno.elapsed] < 64 or off > 1e-9:
                continue
            moment = 1e-12 * zeno.elapsed
            _, before = run.at(zeno.elapsed - moment)
            com = zeno.q[:2] + posture.center_of_mass
            v, omega = zeno.qdot[:2], zeno.qdot[2]
            arm, inertia = com - tip, posture.gyration_radius**2
            momentum = cross(arm, before[:2]) + inertia * before[2]
            about_tip = arm @ arm + inertia
            expected = momentum / about_tip
            # In the last moment gravity acts, and the impulses act beside the tip.
            slack = 1e-9 * (1 + math.hypot(*before)) / about_tip
            assert omega == pytest.approx(expected, abs=slack)
            # A rate along the normals that is rounding error is a larger speed along the pieces; a sliding speed below 3e-14 of
            # the largest speed of the run counts as zero.
            speed = (1e-12 + 1e-14 / angle) * (1 + math.hypot(*before))
            assert v == pytest.approx(omega * np.array([-arm[1], arm[0]]), abs=speed)
            checked += 1
    assert ended["event-limit"] == 0
    assert checked >= SCENES // 10


def test_a_contact_that_slides_into_a_needle_of_the_ground_comes_to_rest_in_it():
    """Thousands of impacts at one instant, each slower by less than a hundredth; then the body swings about the tip."""
    posture = sf.Posture(
        mass=1.5978595575349932,
        gyration_radius=0.19445542544077957,
        center_of_mass=(1.2699567234159383, 0.3201767834308348),
        contacts=[
            sf.Contact(
                (1.5173018180889912, 0.01478158005252082), friction=0.310122773385175
            )
        ],
        restitution=0.29228147943510024,
        terrain=[
            (-59.76410899029395, -0.2661166111883893),
            (-3.440335984403789, 1.0507504129443828),
            (-2.78850394152986, 0.7776296915367831),
            (0.08997171234823313, 0.446706309292847),
            (0.22431724177377604, 0.25623779910049665),
            (1.3227664353674695, -0.3737499975146229),
            (1.0831019801278767, -0.5218464064371773),
            (3.4958948357177424, 0.9371629960340614),
            (59.76410899029395, -0.44408715298775386),
        ],
    )
    run = sf.simulate(posture, (0, 0, 0), (0, 0, 0), model="full", impact="poisson")
    assert run.outcome == "sliding"
    assert len(run.impacts) < 200
    assert (run.phases[-1].mode, run.phases[-1].cause) == ("F", "zeno")
    assert run.points_at(run.elapsed)[0] == pytest.approx(
        [1.0831019801278767, -0.5218464064371773], abs=1e-12
    )
