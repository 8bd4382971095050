"""Contact forces along runs: they cause the motion, lie in the friction cones, and have the known values in simple scenes.

The accelerations are not taken from the package. They are derivatives of the polynomials through q̇ at Chebyshev points of intervals
without an event.
"""

import itertools
import math
import os
from functools import partial

import numpy as np
import pytest
import standfast as sf
from bodies import LAWS, draw_contacts, frame, lift, order_for, size
from numpy.polynomial import chebyshev
from scipy.optimize import nnls
from walls import nearest_piece, random_scene

#: Number of random runs.
RUNS = int(os.environ.get("STANDFAST_FORCES_RUNS", "80"))
#: Largest error of the equation of motion and largest excess over a friction cone, relative to the weight.
BALANCE = 1e-9
#: Numbers of Chebyshev points of an interval. A derivative from few has less rounding error, which counts in a short interval.
NODES = (14, 7, 4)
#: Duration of an interval, in s, below which rounding leaves no derivative.
SHORT = 1e-5
#: Part of the other intervals in which the forces may be left unchecked.
UNCHECKED = 0.05


def draw(rng):
    """A body of about a metre on a level floor, on slopes of its own or on a polyline, and its start and options."""
    kind = rng.choice(["floor", "slopes", "polyline"])
    law = str(rng.choice(LAWS))
    count = rng.integers(1, 6 if kind == "floor" else 4)
    places = np.sort(rng.uniform(-1, 1, count))
    contacts = draw_contacts(
        rng,
        places,
        rise=0.3 if kind == "slopes" else 0,
        steep=0.7 if kind == "slopes" else 0,
        friction=lambda: rng.uniform(0, 1.5) if rng.random() < 0.8 else 0.0,
    )
    terrain = None
    if kind == "floor":
        friction = rng.uniform(0, 1.5)
        contacts = [sf.Contact(point=c.point, friction=friction) for c in contacts]
    if kind == "polyline":
        x = np.sort(rng.uniform(-3, 3, rng.integers(1, 4)))
        vertices = [-20.0, *x, 20.0]
        terrain = [(x, -0.3 + 0.3 * rng.uniform(-1, 1)) for x in vertices]
    posture = sf.Posture(
        mass=math.exp(rng.uniform(-2, 2)),
        gyration_radius=math.exp(rng.uniform(math.log(0.2), math.log(1.5))),
        center_of_mass=(rng.uniform(-0.5, 0.5), rng.uniform(0.1, 1.0)),
        contacts=contacts,
        restitution=rng.uniform(0, 0.6) if rng.random() < 0.5 else 0.0,
        gravity=9.81,
        terrain=terrain,
    )
    flat = kind == "floor" and rng.random() < 0.5
    q = np.array([0.0, 0.0, 0.0 if flat else rng.uniform(-0.3, 0.3)])
    model = "full" if rng.random() < 0.7 or kind == "polyline" else "local"
    if kind == "polyline":
        q[1] = 1.0
    else:
        drop = 10 ** rng.uniform(-3, -1) if rng.random() < 0.5 else 0.0
        q[1] = lift(posture, q, model) + drop
    qdot = rng.normal(size=3) * rng.choice([0.0, 0.3, 2.0])
    options = {
        "model": model,
        "impact": law,
        "simultaneous": order_for(law),
        "stop": "time" if rng.random() < 0.5 else "rest",
        "time_limit": 3.0,
        "event_limit": 5000,
    }
    return posture, q, qdot, options


def axes(posture, points):
    """Unit tangent of the terrain at each contact point: of the nearest piece."""
    if posture.terrain is None:
        return np.array([frame(contact.slope)[0] for contact in posture.contacts])
    ways = np.diff(posture.terrain, axis=0)[nearest_piece(posture.terrain, points)]
    return ways / np.hypot(*ways.T)[:, None]


def wrench(posture, q, points, tangents, forces, model):
    """Sum of contact forces and of their moments about the centre of mass, Newton and Euler."""
    normals = np.stack([-tangents[:, 1], tangents[:, 0]], axis=1)
    pushes = tangents * forces[:, :1] + normals * forces[:, 1:]
    nominal = np.array([contact.point for contact in posture.contacts])
    arms = (
        nominal - posture.center_of_mass
        if model == "local"
        else points - posture.center_of_mass - q[:2]
    )
    moment = arms[:, 0] * pushes[:, 1] - arms[:, 1] * pushes[:, 0]
    return np.array([*pushes.sum(axis=0), moment.sum()])


def at_vertex(posture, points):
    """Whether a point is so close to a vertex of the terrain that it may be on either piece."""
    if posture.terrain is None:
        return False
    ways = points[:, None] - np.array(posture.terrain)
    return bool((np.abs(ways).max(axis=2) < 1e-9).any())


def smooth_intervals(run):
    """Intervals between events, without the sums of infinitely many impacts."""
    struck = run.impacts["time"]
    bounds = {run.time, *struck, *(phase.start for phase in run.phases)}
    sums = [zeno.time for zeno in run.zeno_points if zeno.method != "rest"]
    bounds = np.array(sorted({*bounds, *sums}))
    return [(low, high) for low, high in itertools.pairwise(bounds) if high not in sums]


def acceleration(run, low, high):
    """q̈ in the middle of an interval, from q̇ at Chebyshev points about it, and the error of this derivative."""
    middle = 0.5 * (low + high)
    omega = abs(run.at(middle)[1][2])
    best = None
    # A long part has less rounding error, a short one less of the higher orders of the motion.
    for part, nodes in itertools.product((0.02, 0.005, 0.001), NODES):
        half = min(0.45 * (high - low), part / max(1.0, omega))
        points = chebyshev.chebpts1(nodes)
        _, qdot = run.at(middle + half * points)
        coefficients = chebyshev.chebfit(points, qdot, nodes - 1)
        rounding = 1e-16 * (1.0 + np.abs(qdot).max())
        # In the middle |T_k'| <= k, and 0 for even k: of the rounding errors, and of the coefficients that were left out.
        last = np.abs(coefficients[-2:]).max()
        error = (nodes**2 / 4 * rounding + 2 * nodes * last) / half
        if best is None or error < best[1]:
            slopes = chebyshev.chebder(coefficients) / half
            best = chebyshev.chebval(0.0, slopes), error
    return middle, *best


def check(run, found):
    """The equation of motion and the cones, in up to forty intervals of a run."""
    posture = run.posture
    weight = posture.mass * posture.gravity
    inertia = posture.mass * posture.gyration_radius**2
    friction = np.array([contact.friction for contact in posture.contacts])
    intervals = smooth_intervals(run)
    # Contacts are in the air in most intervals of a bouncing body; the later ones have forces.
    for low, high in intervals[-40:]:
        if high - low < SHORT:
            found["short"] += 1
            continue
        t, qddot, error = acceleration(run, low, high)
        q, forces, points = run.at(t)[0], run.forces_at(t), run.points_at(t)
        tangents = axes(posture, points)
        pushed = wrench(posture, q, points, tangents, forces, run.model)
        reach = size(posture)
        needed = np.array([qddot[0], qddot[1] + posture.gravity, qddot[2]])
        needed *= posture.mass, posture.mass, inertia
        scale = weight + np.abs(forces).max()
        off = np.abs(needed - pushed) / (1.0, 1.0, reach)
        if posture.mass * error > 0.1 * BALANCE * scale:
            found["unresolved"] += 1
            continue  # next to a jam, where forces grow without bounds, or in a very short interval
        if at_vertex(posture, points):
            found["vertex"] += 1
            continue  # the axes are those of one piece, the cones those of both
        assert (off <= BALANCE * scale).all(), (t, off / weight)
        outside = np.abs(forces[:, 0]) - friction * forces[:, 1]
        assert (forces[:, 1] >= -BALANCE * scale).all(), (t, forces)
        assert (outside <= BALANCE * scale).all(), (t, forces)
        (mode,) = [p.mode for p in run.phases if p.start <= t < p.end] or [None]
        assert mode is None or all(
            (forces[i] == 0).all() for i, letter in enumerate(mode) if letter == "S"
        ), (t, mode, forces)
        pressed = int((forces[:, 1] > 0).sum())
        found["checked"] += 1
        found[pressed] = found.get(pressed, 0) + 1
        found["largest"] = max(found["largest"], (off / scale).max())


def test_forces_cause_the_motion_and_lie_in_the_cones():
    found = {"checked": 0, "short": 0, "vertex": 0, "unresolved": 0, "largest": 0.0}
    for seed in range(RUNS):
        rng = np.random.default_rng([1788, seed])
        if seed % 3 == 2:
            _, posture, qdot, options = random_scene(rng)
            q = np.zeros(3)
        else:
            posture, q, qdot, options = draw(rng)
        run = sf.simulate(posture, q, qdot, **options)
        try:
            check(run, found)
        except AssertionError as error:
            raise AssertionError(
                f"seed {seed}: {posture!r}, {list(q)}, {list(qdot)}, {options}"
            ) from error
    print(found)
    unchecked = found["vertex"] + found["unresolved"]
    assert found["checked"] >= 3 * RUNS
    assert unchecked <= UNCHECKED * (found["checked"] + unchecked)


def rows(posture, q, points, tangents, model):
    """Wrenches of the edges of the friction cones, (3, edges), and the contact and the force of each edge."""
    wrenches, owners, forces = [], [], []
    for i, contact in enumerate(posture.contacts):
        sides = (0.0,) if contact.friction == 0 else (-1.0, 1.0)
        for side in sides:
            one = np.zeros((len(points), 2))
            one[i] = side * contact.friction, 1.0
            wrenches.append(wrench(posture, q, points, tangents, one, model))
            owners.append(i)
            forces.append(one[i])
    return np.array(wrenches).T, owners, np.array(forces).T


def test_forces_of_bodies_at_rest_are_the_smallest():
    """min Σ|f|² under the balance of forces, by non-negative least squares on the edges of the cones."""
    checked = 0
    for seed in range(max(RUNS // 3, 20)):
        rng = np.random.default_rng([1829, seed])
        count = rng.integers(2, 7)
        level = rng.random() < 0.5
        contacts = draw_contacts(
            rng,
            np.sort(rng.uniform(-1, 1, count)),
            rise=0 if level else 0.3,
            steep=0 if level else 0.5,
            friction=partial(rng.uniform, 0.3, 1.5),
        )
        posture = sf.Posture(
            mass=2.0,
            gyration_radius=0.5,
            center_of_mass=(rng.uniform(-0.5, 0.5), rng.uniform(0.1, 1.0)),
            contacts=contacts,
            restitution=0.0,
            gravity=9.81,
        )
        run = sf.simulate(posture, np.zeros(3), np.zeros(3))
        if not (run.outcome == "rest" and set(run.phases[-1].mode) == {"F"}):
            continue
        forces, points = run.forces_at(run.time), run.points_at(run.time)
        tangents = axes(posture, points)
        sums, owners, edges = rows(posture, run.q, points, tangents, "full")
        weight = posture.mass * posture.gravity
        stiff = 1e5
        spread = np.zeros((2 * count, edges.shape[1]))
        for k, i in enumerate(owners):
            spread[2 * i : 2 * i + 2, k] = edges[:, k]
        load = np.concatenate([stiff * np.array([0, 1, 0]), np.zeros(2 * count)])
        share, _ = nnls(np.vstack([stiff * sums, spread]), load)
        least = weight * np.linalg.norm(spread @ share)
        pushed = wrench(posture, run.q, points, tangents, forces, "full")
        np.testing.assert_allclose(pushed, [0, weight, 0], atol=BALANCE * weight)
        # The penalty of the balance changes the norm by 1/stiff² of it, the squares of the solution by some rounding errors.
        assert np.linalg.norm(forces) <= least * (1 + 1e-6), seed
        assert np.linalg.norm(forces) >= least * (1 - 1e-6), seed
        checked += 1
    assert checked >= RUNS // 15


def feet(*places, friction, height=0.5, **fields):
    return sf.Posture(
        mass=2.0,
        gyration_radius=0.4,
        center_of_mass=(0.0, height),
        contacts=[sf.Contact(point=(x, 0.0), friction=friction) for x in places],
        gravity=10.0,
        **{"restitution": 0.0} | fields,
    )


def test_two_feet_share_the_weight_by_the_lever_rule():
    run = sf.simulate(feet(-0.2, 0.6, friction=0.5), np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(
        run.forces_at(run.time), [[0, 15.0], [0, 5.0]], rtol=0, atol=1e-13
    )


def test_three_equal_feet_share_the_weight_linearly():
    """Least squares: f_n is linear in the place of the foot, and no foot pushes along the floor."""
    for places, expected in [((-0.3, 0.0, 0.3), [1 / 3] * 3), ((-0.3, 0.0, 0.6), None)]:
        run = sf.simulate(feet(*places, friction=0.5), np.zeros(3), np.zeros(3))
        forces = run.forces_at(run.time)
        if expected is None:
            x = np.array(places)
            expected = np.linalg.pinv([np.ones(3), x]) @ (1, 0)
        np.testing.assert_allclose(forces[:, 1], 20 * np.array(expected), atol=1e-13)
        np.testing.assert_allclose(forces[:, 0], 0, atol=1e-13)
        np.testing.assert_array_equal(run.points_at(run.time)[:, 0], places)


def test_contacts_at_one_point_share_its_force():
    run = sf.simulate(feet(-0.3, -0.3, 0.3, friction=0.5), np.zeros(3), np.zeros(3))
    forces = run.forces_at(run.time)[:, 1]
    np.testing.assert_allclose(forces, [5, 5, 10], atol=1e-13)


@pytest.mark.parametrize("model", ["full", "local"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_block_slides_down_a_slope(model, friction):
    """Σ f_n = m g cos β, f_t = −σμ f_n, and Σ (b_i f_n,i − c_i f_t,i) = 0 with b = ∓a, c = −H: the lower foot has more."""
    slope, half, height, mass, g = 0.6, 0.5, 0.4, 2.0, 10.0
    t, n = frame(slope)
    contacts = [
        sf.Contact(point=s * half * t, slope=slope, friction=friction) for s in (-1, 1)
    ]
    block = sf.Posture(mass, 0.4, height * n, contacts, 0.0, g)
    run = sf.simulate(
        block, np.zeros(3), np.zeros(3), model=model, stop="time", time_limit=1.0
    )
    assert [phase.mode for phase in run.phases] in (["LL"], ["RR"])
    total = mass * g * math.cos(slope)
    more = friction * total * height / half
    expected = np.array([total + more, total - more]) / 2
    forces = run.forces_at([0.0, 0.3, 1.0])
    np.testing.assert_allclose(
        forces[..., 1], [expected] * 3, rtol=0, atol=1e-12 * total
    )
    np.testing.assert_allclose(
        forces[..., 0], friction * forces[..., 1], rtol=0, atol=1e-12 * total
    )
    way = 0.5 * g * (math.sin(slope) - friction * math.cos(slope)) * 0.3**2
    expected = [contact.point - way * t for contact in contacts]
    np.testing.assert_allclose(run.points_at(0.3), expected, rtol=0, atol=1e-14)


def test_a_body_released_on_one_foot_turns_about_it():
    """Released from rest: θ̈ = −g x/(ρ² + x² + y²) with the centre of mass at (x, y) from the foot, f = m (g + θ̈ × arm)."""
    x, y, rho, mass, g = -0.3, 0.4, 0.4, 2.0, 10.0
    body = sf.Posture(mass, rho, (x, y), [sf.Contact((0, 0), friction=5.0)], 0.0, g)
    run = sf.simulate(
        body, np.zeros(3), np.zeros(3), stop="time", time_limit=0.01, model="full"
    )
    turn = -g * x / (rho**2 + x**2 + y**2)
    np.testing.assert_allclose(
        run.forces_at(0.0), [[-mass * turn * y, mass * (g + turn * x)]], rtol=1e-14
    )


def test_a_contact_in_a_valley_has_the_sum_of_both_forces():
    """At rest in a vertex: the weight in the axes of the piece on the left."""
    slope = math.atan(0.5)
    body = sf.Posture(
        mass=2.0,
        gyration_radius=0.4,
        center_of_mass=(0.0, -0.2),
        contacts=[sf.Contact(point=(0.0, 0.0), friction=0.1)],
        restitution=0.0,
        gravity=10.0,
        terrain=[(-2, 1), (0, 0), (2, 1)],
    )
    run = sf.simulate(body, np.zeros(3), np.zeros(3))
    assert (run.outcome, run.phases[-1].mode) == ("rest", "F")
    weight = 20 * np.array([[-math.sin(slope), math.cos(slope)]])
    np.testing.assert_allclose(run.forces_at(run.time), weight, rtol=1e-13)


@pytest.mark.parametrize(("law", "friction"), [("newton", 0.0), ("poisson", 2.0)])
def test_a_rocking_body_stands_on_one_foot_within_a_sum_of_cycles(law, friction):
    """The smaller the swings, the closer the force of the foot on the ground is to the force in a body that is
    released upright on this foot."""
    half, height, rho2, mass, g = 0.25, 1.0, 0.16, 2.0, 10.0
    block = feet(-half, half, friction=friction, height=height)
    q = np.array([0, 0, 0.001])
    q[1] = lift(block, q)
    run = sf.simulate(block, q, (0, 0, 0), impact=law, model="full")
    (zeno,) = [z for z in run.zeno_points if z.method == "nested"]
    last = run.impacts["time"][-1]
    times = zeno.time - (zeno.time - last) * np.geomspace(0.1, 0.001, 20)
    fixed = friction > 0
    turn = g * half / (rho2 + half**2 + fixed * height**2)
    forces = run.forces_at(times)
    stands = forces[:, :, 1] > 0
    assert (stands.sum(axis=1) == 1).all()
    assert stands.any(axis=0).all()
    np.testing.assert_allclose(
        forces[stands][:, 1], mass * (g - turn * half), rtol=1e-4
    )
    along = np.abs(forces[stands][:, 0])
    np.testing.assert_allclose(along, fixed * mass * turn * height, rtol=1e-3)
    np.testing.assert_allclose(run.forces_at(run.time)[:, 1], 10, rtol=1e-12)


def test_forces_that_nothing_determines_are_nan():
    ball = sf.Posture(1.0, 0.4, (0, 0), [sf.Contact((0, 0))], 0.5, 10.0)
    run = sf.simulate(ball, (0, 1, 0), (0, 0, 0), stop="zeno")
    assert np.isnan(run.forces_at(run.time)).all()
    assert (run.forces_at([0.0, 0.5 * run.time]) == 0).all()
    # Painleve's rod: no mode is consistent.
    sin, cos = 2 / math.sqrt(5), 1 / math.sqrt(5)
    rod = sf.Posture(
        1.0, math.sqrt(1 / 3), (-cos, sin), [sf.Contact((0, 0), friction=1.4)], 0.0
    )
    run = sf.simulate(rod, (0, 0, 0), (1, 0, 0))
    assert run.outcome == "inconsistent"
    assert np.isnan(run.forces_at(run.time)).all()
    local = sf.LocalModel((10, 10), (0, 0), (0, 0), 0.5)
    run = local.simulate(gaps=(5, 20), rates=(0, 0))
    assert np.isnan(run.forces_at([0.0, run.time])).all()
    assert run.points_at([[0.0], [run.time]]).shape == (2, 1, 2, 2)
    assert np.isnan(run.points_at(0.0)).all()


def test_forces_are_those_after_an_event():
    """A foot without rebound lands and stays; the other one lifts off later or never."""
    run = sf.simulate(feet(-0.2, 0.6, friction=0.5), (0, 0.1, 0), (0, 0, 0))
    landing = run.phases[-1].start
    assert (run.forces_at(np.nextafter(landing, 0)) == 0).all()
    np.testing.assert_allclose(run.forces_at(landing)[:, 1], [15, 5], rtol=1e-13)
    with pytest.raises(ValueError, match=r"t = .*from 0\.0 on"):
        run.forces_at(-1.0)
    bare = sf.simulate(run.posture, (0, 0.1, 0), (0, 0, 0), record=False)
    for ask in (bare.forces_at, bare.points_at):
        with pytest.raises(ValueError, match="record"):
            ask(0.0)
