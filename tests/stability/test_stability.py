"""Stability of postures: known numbers, a linear program as second method, and the simulator."""

import collections
import json
import math
import os
import pickle

import numpy as np
import pytest
import standfast as sf
from bodies import draw_contacts, frame, lift, odd, stance, vee
from corners import next_corner, rows_of
from scipy.optimize import linprog

STANCES = int(os.environ.get("STANDFAST_STANCES", "500"))
POSTURES = int(os.environ.get("STANDFAST_STABILITY_POSTURES", "25"))
#: Number of stable postures with kicks, and number of kicks of each.
KICKED = int(os.environ.get("STANDFAST_KICKED_POSTURES", "20"))
KICKS = 50 if KICKED < 100 else 200


def third_figure(y, rho):
    """The V of tan β = 8/15 with friction ½, centre of mass over the middle."""
    return vee(math.atan(8 / 15), 0.5, (0.0, y), height=8 / 15, gyration_radius=rho)


# Equilibrium region


def by_linear_programme(posture):
    """Least and largest Σ a m_u over a ≥ 0 with Σ a u = e_y, by HiGHS."""
    directions, moments = [], []
    for contact in posture.contacts:
        t, n = frame(contact.slope)
        for side in (1, -1):
            u = n + side * contact.friction * t
            directions.append(u)
            moments.append(contact.point[0] * u[1] - contact.point[1] * u[0])
    ends = []
    for side in (1, -1):
        answer = linprog(
            side * np.array(moments),
            A_eq=np.transpose(directions),
            b_eq=[0, 1],
            bounds=(0, None),
        )
        if answer.status == 2:
            return None
        ends.append(-side * math.inf if answer.status == 3 else side * answer.fun)
    return tuple(ends)


def random_stance(random):
    count = int(random.integers(1, 6))
    steep = random.choice([0.6, 1.2, 1.5])
    contacts = draw_contacts(
        random,
        (random.uniform(-2, 2) for _ in range(count)),
        rise=2,
        steep=steep,
        friction=lambda: random.choice([0.0, 0.2, 0.7, 3.0]),
    )
    return stance(contacts, (0.0, 0.0))


def test_region_against_a_linear_programme():
    random = np.random.default_rng(5)
    kinds = collections.Counter()
    for _ in range(STANCES):
        posture = random_stance(random)
        mine, other = sf.equilibrium_region(posture), by_linear_programme(posture)
        if other is None or mine is None:
            assert mine == other
            kinds["empty"] += 1
            continue
        assert mine == pytest.approx(other, rel=1e-6, abs=1e-6)
        kinds[tuple(math.isfinite(end) for end in mine)] += 1
    print(f"{STANCES} stances: {dict(kinds)}")
    assert set(kinds) == {
        "empty",
        (True, True),
        (False, True),
        (True, False),
        (False, False),
    }
    assert min(kinds.values()) > STANCES / 100


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.8, 2.0])
@pytest.mark.parametrize("slope", [0.1, 0.5, 1.2])
def test_region_of_a_v(slope, friction):
    """|X| ≤ W if β ≤ α, W sin 2α/sin 2β above, all X from β + α > π/2 on."""
    alpha, width = math.atan(friction), 1.3
    expected = (
        math.inf
        if slope + alpha > math.pi / 2
        else width
        if slope <= alpha
        else width * math.sin(2 * alpha) / math.sin(2 * slope)
    )
    region = sf.equilibrium_region(vee(slope, friction, width=width))
    assert region == pytest.approx((-expected, expected))


def test_region_of_few_contacts():
    ball = stance([sf.Contact((0.3, 1.0))], (0, 2))
    assert sf.equilibrium_region(ball) == (0.3, 0.3)
    slope = stance([sf.Contact((0.3, 1.0), slope=0.4, friction=0.3)], (0, 2))
    assert sf.equilibrium_region(slope) is None
    held = stance([sf.Contact((0.3, 1.0), slope=0.4, friction=0.5)], (0, 2))
    assert sf.equilibrium_region(held) == pytest.approx((0.3, 0.3))
    same = stance([sf.Contact((0.3, 1.0))] * 2, (0, 2))
    assert sf.equilibrium_region(same) == (0.3, 0.3)
    weightless = stance([sf.Contact((0.3, 1.0))], (0, 2), gravity=0.0)
    assert sf.equilibrium_region(weightless) == (-math.inf, math.inf)


# Static forces


def forces_by_linear_programme(posture, contact, axis, sign):
    """The extreme of a component of a force, N: variables f_t, f_n of each contact; by HiGHS."""
    rows, cones, objective = [[], [], []], [], []
    com = np.array(posture.center_of_mass)
    count = len(posture.contacts)
    for k, c in enumerate(posture.contacts):
        t, n = frame(c.slope)
        arm = np.array(c.point) - com
        for direction in (t, n):
            rows[0].append(direction[0])
            rows[1].append(direction[1])
            rows[2].append(arm[0] * direction[1] - arm[1] * direction[0])
        for side in (1, -1):
            cone = np.zeros(2 * count)
            cone[2 * k : 2 * k + 2] = side, -c.friction
            cones.append(cone)
        objective += [0.0, 0.0]
    objective[2 * contact + axis] = -sign
    answer = linprog(
        objective,
        A_ub=cones,
        b_ub=np.zeros(len(cones)),
        A_eq=rows,
        b_eq=[0, posture.mass * posture.gravity, 0],
        bounds=[(None, None), (0, None)] * count,
    )
    if answer.status == 2:
        return None
    return sign * math.inf if answer.status in (3, 4) else -sign * answer.fun


def test_static_forces_against_a_linear_programme():
    random = np.random.default_rng(6)
    held = 0
    for _ in range(STANCES // 5):
        posture = random_stance(random)
        found = sf.static_forces(posture)
        region = sf.equilibrium_region(posture)
        assert (found is None) == (region is None or not region[0] <= 0 <= region[1])
        if found is None:
            assert forces_by_linear_programme(posture, 0, 0, 1) is None
            continue
        held += 1
        for values, sign in zip(found, (-1, 1), strict=True):
            for contact, axis in np.ndindex(values.shape):
                other = forces_by_linear_programme(posture, contact, axis, sign)
                assert values[contact, axis] == pytest.approx(other, abs=1e-6)
    assert held > STANCES / 40


def test_friction_margin():
    """The region at (1 − margin) times the friction ends at the centre of mass."""
    random = np.random.default_rng(7)
    kinds = collections.Counter()
    for _ in range(STANCES // 5):
        posture = random_stance(random)
        margin = sf.friction_margin(posture)
        # The linear program has its own tolerances.
        for share, inside in ((1 - 1e-4, False), (1 + 1e-4, True)):
            factor = share * (1 - margin)
            if not 0 < factor < 1e6:
                continue
            contacts = [
                sf.Contact(c.point, slope=c.slope, friction=factor * c.friction)
                for c in posture.contacts
            ]
            region = by_linear_programme(stance(contacts, (0.0, 0.0)))
            holds = region is not None and region[0] - 1e-9 <= 0 <= region[1] + 1e-9
            assert holds or not inside
            if not inside:
                # The region may be empty with less friction, or end near the centre of mass.
                assert not holds or region[0] > -1e-4 or region[1] < 1e-4
        kinds[margin == 1, margin >= 0, math.isfinite(margin)] += 1
    print(dict(kinds))
    assert len(kinds) == 4


def test_friction_margin_of_a_v():
    """|X| = W sin 2α/sin 2β at the edge: the required friction is known."""
    slope, friction, width = 0.6, 0.5, 1.0
    for x in (0.2, 0.7, 0.95):
        needed = math.tan(0.5 * math.asin(x / width * math.sin(2 * slope)))
        posture = vee(slope, friction, (x, 0.3))
        assert sf.friction_margin(posture) == pytest.approx(1 - needed / friction)


# Known numbers


def changes(property_of, low, high, steps=1400):
    """Where a property of a number changes, by bisection."""
    grid = np.linspace(low, high, steps)
    values = [property_of(x) for x in grid]
    found = []
    for a, b, before, after in zip(grid, grid[1:], values, values[1:], strict=False):
        if before == after:
            continue
        for _ in range(60):
            middle = (a + b) / 2
            if property_of(middle) == before:
                a = middle
            else:
                b = middle
        found.append(a)
    return found


@pytest.mark.parametrize(
    ("rho", "clattering", "strong"),
    [
        (0.8, [-0.572366, 5.389032], [2.426058]),
        (0.4, [0.917984, 3.898683], [1.402005, 2.249340, 2.412763]),
    ],
)
def test_third_figure(rho, clattering, strong):
    region = sf.equilibrium_region(third_figure(0.0, rho))
    assert region == pytest.approx((-289 / 300, 289 / 300), rel=1e-15)
    verdict = lambda y: sf.stability(third_figure(float(y), rho))  # noqa: E731
    found = changes(lambda y: verdict(y).clattering, -1, 6)
    assert found == pytest.approx(clattering, abs=1e-6)
    assert verdict(-1).clattering
    found = changes(lambda y: verdict(y).kinematic_strong, -1, 6)
    assert found == pytest.approx(strong, abs=1e-5)
    assert verdict(-1).kinematic_strong


def test_reference_point():
    posture = vee(math.radians(20), 0.5, (0.0, 0.2))
    verdict = sf.stability(posture)
    modes = verdict.modes
    normals = [posture.gap_rates((0, 0, 0), row) for row in np.eye(3)]

    def accelerations(word):
        return modes[word].acceleration @ np.array(normals)

    assert accelerations("SS") == pytest.approx([-0.93969262] * 2, abs=1e-8)
    assert accelerations("FS")[1] == pytest.approx(-1.45688778, abs=1e-8)
    assert modes["FS"].forces[0] == pytest.approx([0.06880053, 0.26427511], abs=1e-8)
    assert modes["RS"].forces[0, 1] == pytest.approx(0.18945152, abs=1e-8)
    assert accelerations("RS")[1] == pytest.approx(-1.48391690, abs=1e-8)
    assert modes["RR"].forces[:, 1] == pytest.approx([0.42195901, 0.69122032], abs=1e-8)
    assert verdict.kinematic_strong
    assert verdict.unambiguous
    assert verdict.frictional_stability == "stable"


def test_strong_and_yet_unstable():
    verdict = sf.stability(odd(0.26))
    assert (verdict.kinematic_strong, verdict.frictional_stability) == (
        True,
        "unstable",
    )
    assert verdict.by == "growing-cycle"
    cycle = {corner["contact"]: corner for corner in verdict.evidence}
    assert cycle[2]["phi"] == pytest.approx(-1.05991, abs=1e-5)
    assert cycle[1]["phi"] == pytest.approx(-1.28054, abs=1e-5)
    assert cycle[2]["growth"] == pytest.approx(1.391633, abs=1e-6)
    assert cycle[1]["growth"] == pytest.approx(-0.646799, abs=1e-6)
    mean = sum(corner["growth"] for corner in verdict.evidence) / 2
    assert mean == pytest.approx(0.3724, abs=1e-4)
    verdict = sf.stability(odd(0.05))
    assert (verdict.frictional_stability, verdict.by) == ("stable", "corner-map")


def test_verdicts_in_the_order_of_their_arguments():
    assert sf.stability(vee(0.5, 0.1, (0.9, 0.0))).by == "not-equilibrium"
    rod = sf.Posture.rod(0.5, 0.2, 0.1, friction=0.5)
    assert sf.stability(rod).by == "theorem-3"
    # Between Goyal's bound and (10), 0.575 < ψ < 0.618 at e = .1.
    square = 0.25 * (1 - 0.6) / (1 + 0.6)
    between = sf.Posture.rod(0.5, math.sqrt(square), 0.1, friction=0.5)
    verdict = sf.stability(between)
    assert verdict.coupling == pytest.approx(0.6)
    assert (verdict.clattering, verdict.chatter, verdict.by) == (False, True, "goyal")
    # The body leans beyond its right foot when that foot can slip: it moves away in a mode.
    tall = stance(
        [sf.Contact((-1, 0), friction=5.0), sf.Contact((1, 2.0), slope=1.4)],
        (-0.9, 3.0),
    )
    verdict = sf.stability(tall)
    if verdict.equilibrium and not verdict.unambiguous:
        assert verdict.by == "accelerating-mode"


def test_what_nothing_slows_down_does_not_come_back():
    """Level ground without friction, and no gravity: the conditions hold by a tie only, and after kicks the body
    moves away for ever."""
    smooth = stance([sf.Contact((-1, 0)), sf.Contact((1, 0))], (0.0, 0.2))
    rough = [sf.Contact((x, 0), friction=0.5) for x in (-1, 1)]
    weightless = stance(rough, (0.0, 0.2), gravity=0.0)
    for posture in (smooth, weightless):
        verdict = sf.stability(posture)
        assert verdict.kinematic_strong
        assert verdict.kinematic_margin == 0
        assert (verdict.frictional_stability, verdict.by) == (
            "unstable",
            "accelerating-mode",
        )
        assert not sf.sweep(posture, {"mass": [1.0]}, "theorem_3")["theorem_3"].item()
    assert kicks(smooth, 20, np.random.default_rng(1))["rest"] == 0


@pytest.mark.parametrize("friction", [0.0, 1e-300, 1e-17, 1e-12, 1.0, 1e12])
def test_region_of_any_friction_on_level_ground(friction):
    feet = [sf.Contact((x, 0), friction=friction) for x in (-1, 1)]
    region = sf.equilibrium_region(stance(feet, (0, 0.5)))
    assert region == pytest.approx((-1.0, 1.0), rel=1e-15)


@pytest.mark.parametrize(
    "terrain",
    [[(-0.5, 0), (0.5, 0)], [(-2, 0), (0.5, 0)], [(-2, 0), (0.5, 0), (2, -4)]],
)
def test_a_foot_at_an_end_of_its_terrain_is_refused(terrain):
    feet = [sf.Contact((x, 0), friction=0.5) for x in (-0.5, 0.5)]
    fields = 1.0, 0.1, (0.0, 0.05), feet, 0.1
    with pytest.raises(ValueError, match=r"contacts\.\d\.point"):
        sf.stability(sf.Posture(*fields, terrain=terrain))
    beyond = [(-2, 0), (0.5 + 1e-7, 0), (2, 1)]
    verdict = sf.stability(sf.Posture(*fields, terrain=beyond), trials=50)
    assert verdict.frictional_stability == "stable"
    assert verdict.trials["rest"] == 50


def test_a_contact_that_stays_while_the_other_slides():
    """The normal of contact 2 passes through contact 1: words with a fixed contact are motions, and no verdict is proved."""
    feet = [
        sf.Contact((-1, 0), slope=0.17, friction=0.1),
        sf.Contact((1, 1.5), slope=-math.atan(4 / 3), friction=1.2),
    ]
    verdict = sf.stability(stance(feet, (0.61, 2.47), 0.5, 0.05, 9.81))
    assert verdict.kinematic_strong
    assert (verdict.frictional_stability, verdict.reason) == ("undecided", "degenerate")


def test_several_modes_of_a_slide_are_not_stable():
    """Theorem 3 holds at rest, but while both contacts slide to the left, words with one of them are consistent, too."""
    feet = [
        sf.Contact(
            (-1, 0),
            slope=-0.8734459077678166,
            friction=2.662577761135372,
            restitution=0.01927435559713582,
        ),
        sf.Contact(
            (1, -0.11944180975482022),
            slope=-0.489411656250414,
            friction=1.7563994352796706,
            restitution=0.07997973648181117,
        ),
    ]
    posture = stance(feet, (-0.55136964737508, -0.20516071949863), 0.34594743682)
    verdict = sf.stability(posture, trials=300)
    assert verdict.kinematic_strong
    assert verdict.clattering
    assert verdict.frictional_stability == "undecided"
    assert verdict.trials["others"]["ambiguous"] > 0


@pytest.mark.parametrize("length", [1e-6, 1.0, 1e3])
def test_delicate_in_any_unit(length):
    feet = [sf.Contact((x * length, 0), friction=0.5) for x in (-0.5, 0.5)]
    for offset, delicate in ((1e-14, True), (1e-5, False)):
        com = ((0.5 - offset) * length, 0.1 * length)
        verdict = sf.stability(stance(feet, com, 0.3 * length))
        assert verdict.delicate == delicate
        assert verdict.reason == ("boundary" if delicate else None)
        exact = sf.stability(stance(feet, com, 0.3 * length), width=0)
        assert exact.frictional_stability == "stable"


def test_friction_margin_straight_over_a_contact():
    """On one contact the load is vertical: friction tan |slope| is required."""
    random = np.random.default_rng(8)
    for _ in range(200):
        x, y, slope, friction = random.uniform((-2, -2, -1, 0.1), (2, 2, 1, 2))
        posture = stance(
            [sf.Contact((x, y), slope=slope, friction=friction)], (x, y + 1)
        )
        needed = abs(math.tan(slope)) / friction
        assert sf.friction_margin(posture) == pytest.approx(1 - needed, abs=1e-9)


# Against the simulator


def kicks(posture, count, random, scale=1e-3):
    """Outcomes of small random kicks in the local model."""
    outcomes = collections.Counter()
    for _ in range(count):
        q, qdot = random.normal(0, 1, 3) * scale**2, random.normal(0, 1, 3) * scale
        q[1] += max(0.0, lift(posture, q, "local")) * (1 + 1e-9)
        run = sf.simulate(
            posture,
            q,
            qdot,
            model="local",
            record=False,
            neighbourhood=1e7 * scale**2,
            event_limit=200_000,
            impact="newton",
        )
        outcomes[run.outcome] += 1
    return outcomes


def two_feet(rise, slopes, frictions, restitutions=(None, None)):
    """Contacts 2 m apart, the right one higher by ``rise``."""
    each = zip((-1.0, 1.0), (0.0, rise), slopes, frictions, restitutions, strict=True)
    return [
        sf.Contact((x, y), slope=slope, friction=friction, restitution=e)
        for x, y, slope, friction, e in each
    ]


def test_corner_map_against_the_simulator():
    """Random kinematic-strong postures: no verdict is contradicted by kicks, and most postures that Theorem 3 does not decide
    are decided."""
    random = np.random.default_rng(2)
    verdicts = collections.Counter()
    found = 0
    while found < POSTURES:
        slopes, frictions = random.uniform(-0.9, 0.9, 2), random.uniform(0.1, 1.2, 2)
        contacts = two_feet(random.uniform(-0.4, 0.4), slopes, frictions)
        com = (float(random.uniform(-1.2, 1.2)), float(random.uniform(-1, 2)))
        rho = float(random.uniform(0.2, 1.2))
        if not sf.stability(stance(contacts, com, rho)).kinematic_strong:
            continue
        found += 1
        for restitution in (0.05, 0.3, 0.7):
            posture = stance(contacts, com, rho, restitution)
            verdict = sf.stability(posture)
            verdicts[verdict.frictional_stability, verdict.by] += 1
            if verdict.by in ("theorem-3", "theorem-3-loose"):
                continue
            count = 100
            outcomes = kicks(posture, count, random)
            if verdict.frictional_stability == "stable":
                assert outcomes == {"rest": count}, repr(posture)
            elif verdict.frictional_stability == "unstable":
                assert outcomes["rest"] < count, repr(posture)
    print(f"{found} postures: {dict(verdicts)}")
    silent = sum(
        n
        for (_, by), n in verdicts.items()
        if by not in ("theorem-3", "theorem-3-loose")
    )
    decided = silent - verdicts["undecided", None]
    print(f"decided of what Theorem 3 leaves open: {decided} of {silent}")
    assert decided >= silent / 2


def test_the_unstable_one_leaves():
    random = np.random.default_rng(3)
    assert kicks(odd(0.26), 30, random)["rest"] < 15
    assert kicks(odd(0.05), 30, random) == {"rest": 30}


def speeds(posture, run):
    """The largest ‖q̇‖ of a run, at the ends and in the middle of its phases and on both sides of every impact.

    At an impact ‖q̇‖² = s² + u·D⁻¹u: the speed s along the direction in which both contacts slide is not changed by it.
    """
    metric = np.array([1.0, 1.0, posture.gyration_radius**2])
    normals, _, both = rows_of(posture)
    inverse = np.linalg.inv(normals / metric @ np.transpose(normals))
    times = [
        time
        for phase in run.phases
        for time in (phase.start, 0.5 * (phase.start + phase.end), phase.end)
    ]
    _, qdot = run.at(np.array(times))
    squares = [(qdot**2 @ metric).max()]
    if len(run.impacts):
        _, qdot = run.at(run.impacts["time"])
        along = qdot * metric @ both
        for rates in (run.impacts["rates_before"], run.impacts["rates_after"]):
            kinetic = np.einsum("ki,ij,kj->k", rates, inverse, rates)
            squares.append((along**2 + kinetic).max())
    return math.sqrt(max(squares))


def random_kick(posture, random, kind, scale=1e-3):
    """q, q̇ and the size of a kick. The kinds of kicks: any velocity; a velocity that keeps a contact closed; one
    with which both contacts slide; any velocity, starting above the ground."""
    metric = np.array([1.0, 1.0, posture.gyration_radius**2])
    normals, _, both = rows_of(posture)
    q, qdot = np.zeros(3), random.normal(0, scale, 3) / np.sqrt(metric)
    if kind == 1:
        row = normals[random.integers(2)]
        qdot -= row / metric * (row @ qdot) / (row / metric @ row)
    elif kind == 2:
        qdot = both * scale * random.choice([-1, 1])
    elif kind == 3:
        q = random.normal(0, scale**2, 3)
        q[1] += max(0.0, lift(posture, q, "local")) * (1 + 1e-9)
    delassus = normals / metric @ normals.T
    weights = np.linalg.solve(delassus, posture.gravity * normals[:, 1])
    return q, qdot, math.sqrt(qdot**2 @ metric + 2 * weights @ (normals @ q))


def test_no_kick_exceeds_the_amplification():
    """Stable postures of all kinds, with equal and unequal contacts, and kicks of all kinds in the local model."""
    random = np.random.default_rng(23)
    found, bounds, shares, drifts = collections.Counter(), [], [], 0
    while len(bounds) < KICKED:
        slopes = random.uniform(-0.9, 0.9, 2) * random.choice([0, 1], p=[0.2, 0.8])
        if random.random() < 0.25:
            slopes[1] = -slopes[0]
        own = random.uniform(0, 0.9, 2) if random.random() < 0.25 else [None, None]
        rise, frictions = random.uniform(-0.4, 0.4), random.uniform(0.1, 1.2, 2)
        contacts = two_feet(rise, slopes, frictions, own)
        posture = stance(
            contacts,
            (random.uniform(-1, 1), random.uniform(-1, 2)),
            random.uniform(0.2, 1.5),
            float(random.choice([0.0, 0.05, 0.1, 0.3, 0.5, 0.7])),
        )
        verdict = sf.stability(posture)
        if verdict.frictional_stability != "stable":
            assert verdict.amplification is None
            assert verdict.amplification_reason == "not-stable"
            continue
        if verdict.amplification is None:
            # A drift ends every flight. Energy, which the bound needs, does not bound it.
            assert verdict.flight == "drift"
            assert verdict.amplification_reason == "energy"
            drifts += 1
            continue
        assert verdict.amplification_reason is None
        found[verdict.by] += 1
        bounds.append(verdict.amplification)
        largest = 0.0
        for k in range(KICKS):
            q, qdot, size = random_kick(posture, random, k % 4)
            run = sf.simulate(
                posture, q, qdot, model="local", neighbourhood=math.inf, impact="newton"
            )
            assert run.outcome == "rest", (posture, q, qdot)
            largest = max(largest, speeds(posture, run) / size)
        # The rounding errors of a run are below 1e-9 of its largest speed.
        assert largest <= verdict.amplification * (1 + 1e-9), posture
        shares.append(largest / verdict.amplification)
    print(f"{KICKED} postures x {KICKS} kicks: {dict(found)}")
    for text, values in (("bound", bounds), ("largest motion over bound", shares)):
        quartiles = np.quantile(values, (0, 0.25, 0.5, 0.75, 1))
        print(f"{text}, quartiles: {', '.join(f'{x:.3g}' for x in quartiles)}")
    print(f"bounds above 100: {np.mean(np.array(bounds) > 100):.1%}")
    assert drifts < 0.1 * KICKED + 1
    # Postures differ, and the bound is not too large: some kicks come near it.
    assert max(shares) > 0.3
    assert min(bounds) < 5 < max(bounds)


def test_the_amplification_tells_ordinary_postures_from_others():
    """A V with a low centre of mass, and a posture that becomes unstable at a slightly larger restitution."""
    low = sf.stability(vee(0.35, 0.5, (0.0, 0.2)))
    assert low.frictional_stability == "stable"
    assert 1.0 <= low.amplification < 10.0
    assert "amplification     at most" in str(low)
    assert "warning" not in str(low)
    wild = sf.stability(odd(0.05))
    assert wild.amplification > 100.0
    assert "warning: above 100" in str(wild)
    unstable = sf.stability(odd(0.26))
    assert unstable.amplification is None
    assert "no bound: the posture is not proved stable" in str(unstable)
    data = wild.to_dict()
    assert data["amplification"] == wild.amplification
    assert data["amplification_reason"] is None
    assert unstable.to_dict()["amplification_reason"] == "not-stable"


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_the_amplification_knows_no_units(unit):
    feet = [sf.Contact((x * unit, 0), friction=0.5) for x in (-0.5, 0.5)]
    here = [sf.Contact((x, 0), friction=0.5) for x in (-0.5, 0.5)]
    large = stance(feet, (0.1 * unit, 0.2 * unit), 0.4 * unit, 0.3, 9.81)
    small = stance(here, (0.1, 0.2), 0.4, 0.3, 1.0)
    expected = sf.stability(small).amplification
    assert sf.stability(large).amplification == pytest.approx(expected, rel=1e-9)


def test_trials_are_evidence():
    """Kicks of the posture that is stable at one restitution and unstable at another; the same for the same seed."""
    stays, leaves = (sf.stability(odd(e), trials=60, seed=4) for e in (0.05, 0.26))
    assert stays.trials == {"seed": 4, "kicks": 60, "rest": 60, "others": {}}
    assert leaves.trials["rest"] + sum(leaves.trials["others"].values()) == 60
    assert leaves.trials["rest"] < 50
    assert pickle.loads(pickle.dumps(leaves)).to_dict() == leaves.to_dict()
    assert leaves.to_dict()["trials"] == leaves.trials
    assert "60 random small kicks (seed 4)" in str(leaves)
    other = sf.stability(odd(0.26), trials=60, seed=5).trials
    assert other["rest"] != leaves.trials["rest"] or other != leaves.trials
    assert sf.stability(odd(0.26)).trials is None
    with pytest.raises(TypeError, match="trials"):
        sf.stability(odd(0.26), trials=0.5)
    with pytest.raises(ValueError, match="seed"):
        sf.stability(odd(0.26), seed=-1)


# The Python interface


def test_a_verdict_is_data(tmp_path):
    verdict = sf.stability(odd(0.26))
    path = tmp_path / "verdict.json"
    verdict.to_json(path)
    assert json.loads(path.read_text(encoding="utf-8")) == verdict.to_dict()
    assert verdict.to_dict()["by"] == "growing-cycle"
    again = pickle.loads(pickle.dumps(verdict))
    assert again.to_dict() == verdict.to_dict()
    assert repr(verdict) == "<Verdict: unstable by growing-cycle>"
    text = str(verdict)
    for word in ("growing-cycle", "kinematic-strong", "clattering", "FF", "region"):
        assert word in text


def test_a_certificate_holds_in_the_simulator():
    """V(cell) ≥ ln G + V(next) from corner to corner of simulated motions; and the cycle of an unstable posture repeats."""
    posture = odd(0.05)
    evidence = sf.stability(posture).evidence
    limits, potential = evidence["limits"], np.array(evidence["potential"])
    assert potential.shape == (2, len(limits) + 1)
    assert potential.min() >= 0.0
    assert (np.diff(limits) > 0).all()

    def value(contact, phi):
        return potential[contact, np.searchsorted(limits, math.tan(phi))]

    random = np.random.default_rng(9)
    checked = 0
    for _ in range(400):
        contact, phi = int(random.integers(2)), float(random.uniform(-1.5, 1.5))
        found = next_corner(posture, contact, phi)
        if found is None:
            continue
        later, angle, growth = found
        below, above = evidence["ends"][contact]
        end = below is not None and math.tan(phi) <= below
        if not end and (above is None or math.tan(phi) < above):
            checked += 1
            assert value(contact, phi) >= growth + value(later, angle)
    assert checked > 100
    posture = odd(0.26)
    _, tangents, both = rows_of(posture)
    for corner, following in zip(
        cycle := sf.stability(posture).evidence, cycle[::-1], strict=True
    ):
        # Here φ is that of the sliding velocity itself.
        alpha = {k: tangents[2 - k] @ both for k in (1, 2)}
        angle = lambda c: math.atan(math.tan(c["phi"]) / alpha[c["contact"]])  # noqa: E731, B023
        found = next_corner(posture, corner["contact"] - 1, angle(corner))
        assert found[0] == following["contact"] - 1
        assert found[1] == pytest.approx(angle(following), abs=1e-6)


def test_odd_stances():
    one_place = stance([sf.Contact((0.0, 0.0), friction=1.0)] * 2, (0.0, 1.0))
    assert sf.stability(one_place).frictional_stability != "stable"
    on_contact = stance(
        [sf.Contact((0.0, 0.0), friction=1.0), sf.Contact((1.0, 0.0), friction=1.0)],
        (0.0, 0.0),
    )
    verdict = sf.stability(on_contact)
    assert verdict.equilibrium
    assert verdict.equilibrium_margin == 0.0
    assert verdict.reason == "boundary"
    above = sf.Posture(
        1.0,
        0.5,
        (0.0, 1.0),
        [sf.Contact((-1.0, 0.0)), sf.Contact((1.0, 0.5))],
        0.1,
        terrain=[(-2, 0), (2, 0)],
    )
    verdict = sf.stability(above)
    assert (verdict.contacts, verdict.by) == ([1], "not-equilibrium")


STABLE_AND_SLOW = [
    (
        [((-0.4632230163368922, -0.08402464480497274), -0.9243133774365195, 1.4582901710179872), ((0.8328475190432763, 0.2368658655528847), 0.13375657651788586, 1.4582901710179872)],
        (-0.3842337896434158, -0.38153597669066897), 1.8529777787025563, 0.2736334406028906, 1.3680379323461123,
        (0.6167241631619179, 0.3852424502963321, 0.11644127419558212),
    ),
    (
        [((-0.46524653413940565, 0.06141253745629538), 0.3774253617542046, 0.7204969605992044), ((0.34612437250553346, 0.496152296880388), 0.3774253617542046, 1.4030394131419033)],
        (-0.44652588936611226, 1.0692637076500984), 0.6753674688163422, 0.6619934769232863, 1.0035989968788661,
        (0.23747917418430256, 0.19788606297391756, -0.11095024386306357),
    ),
]  # fmt: skip


@pytest.mark.parametrize(
    ("feet", "center", "rho", "e", "mass", "kick"), STABLE_AND_SLOW
)
def test_a_body_rests_in_the_local_model_at_the_time_of_small_kicks_of_the_full_one(
    feet, center, rho, e, mass, kick
):
    """Many accumulations in turn. Formerly the error of their sums sustained a slide of 1e-11 of the kick for ever."""
    contacts = [
        sf.Contact(point, slope=slope, friction=mu) for point, slope, mu in feet
    ]
    body = sf.Posture(mass, rho, center, contacts, e)
    local = sf.simulate(
        body, (0, 0, 0), kick, model="local", event_limit=20_000, impact="newton"
    )
    small = sf.simulate(
        body, (0, 0, 0), np.array(kick) * 1e-6, model="full", impact="newton"
    )
    assert local.outcome == small.outcome == "rest"
    assert local.time == pytest.approx(small.time * 1e6, rel=1e-8)
