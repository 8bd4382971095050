"""States without a consistent contact mode: an impact without collision, for the laws of impact that define one."""

import math
import os
from collections import Counter
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
import standfast as sf
from bodies import LAWS, jacobian, order_for, paper_vee
from decimals import cos_sin
from modes_oracle import Problem
from walls import flush_box

#: Number of boxes between a wall and a floor.
BOXES = int(os.environ.get("STANDFAST_JAM_BOXES", "800"))
HALF = Decimal(1) / 2


def painleve_rod(friction, restitution=0.0):
    """The rod of Painlevé with sides 3, 4, 5, on its lower end."""
    return sf.Posture(
        mass=2.0,
        gyration_radius=float(np.sqrt(1 / 3)),
        center_of_mass=(0.6, 0.8),
        contacts=[sf.Contact((0.0, 0.0), friction=friction)],
        restitution=restitution,
        gravity=1.0,
    )


@pytest.mark.parametrize("law", ["newton", "chatterjee-ruina", "moreau"])
def test_other_laws_have_no_answer(law):
    run = sf.simulate(painleve_rod(2), (0, 0, 0), (-1, 0, 0), impact=law)
    assert (run.outcome, run.time) == ("inconsistent", 0.0)
    assert sf.contact_modes(run.undecided).status == "none"


@pytest.mark.parametrize("restitution", [Fraction(0), Fraction(1, 2)])
def test_the_rod_of_painleve_jams(restitution):
    """Exact: sliding stops at p = 1/4.4 with v_n = −0.8 p, then the end sticks, and v_n grows by 2.08 − 1.44²/2.92 per p."""
    run = sf.simulate(
        painleve_rod(2, float(restitution)), (0, 0, 0), (-1, 0, 0), impact="poisson"
    )
    stop, rise = Fraction(10, 44), Fraction(208, 100) - Fraction(144**2, 29200)
    end = (stop + Fraction(8, 10) * stop / rise) * (1 + restitution)
    # Sticking from v_t = 0 on: P_t grows by −w_nt/w_tt = 1.44/2.92 per p; while sliding, by μ.
    along = 2 * stop + Fraction(144, 292) * (end - stop)
    first = run.impacts[0]
    assert (first["time"], first["contact"]) == (0.0, 1)
    assert first["impulse"] == pytest.approx([2 * float(along), 2 * float(end)])
    after = rise * (end - end / (1 + restitution))
    assert first["rates_after"][0] == pytest.approx(float(after), abs=1e-15)
    assert "impact without collision" in run.warnings[0]
    assert run.phases[0].cause == ("impact" if restitution else "zeno")
    assert run.undecided is None


def test_jams_lose_energy_and_runs_go_on():
    random = np.random.default_rng(3)
    jams = 0
    for _ in range(400):
        arm = random.normal(0, 1, 2)
        arm[1] = abs(arm[1])
        posture = sf.Posture(
            1.0,
            float(random.uniform(0.2, 0.8)),
            arm,
            [sf.Contact((0, 0), friction=float(random.uniform(1, 4)))],
            float(random.choice([0.0, 0.3, 0.7])),
        )
        qdot = [random.normal(0, 2), 0.0, random.normal(0, 1)]
        qdot[1] = (
            -qdot[2] * -arm[0]
        )  # the contact slides along: u = ẏ − (x − x_1)·ω = 0
        law = str(random.choice(["poisson", "stronge"]))
        run = sf.simulate(
            posture,
            (0, 0, 0),
            qdot,
            impact=law,
            model="full",
            time_limit=2.0,
            event_limit=50_000,
        )
        jams += any("without collision" in warning for warning in run.warnings)
        assert run.outcome != "inconsistent"
        times = np.sort(np.concatenate([run.sample(60)[0], run.impacts["time"]]))
        energy = run.energy(times[times <= run.time])
        assert np.max(np.diff(energy)) <= 1e-13 * (energy[0] + 9.81 * arm[1] + 1.0)
    assert jams > 20


@pytest.mark.parametrize("power", [20, 40, 60, 240])
def test_a_jam_of_any_size(power):
    """Lengths and gravity times a power of two: the same bits of the motion; the velocity after the jam up to its last bit."""

    def slide(size):
        body = sf.Posture(
            1.0,
            0.0743 * size,
            (0.308 * size, 1.026 * size),
            [sf.Contact((-0.62 * size, 0), friction=0.5)],
            0.3,
            9.81 * size,
        )
        run = sf.simulate(body, (0, 0, 0), (0, 0, 0), time_limit=0.8)
        starts = [phase.start for phase in run.phases]
        q, qdot = run.at(starts[-1])
        return starts, *(q / (size, size, 1)), qdot / (size, size, 1)

    *one, velocity = slide(1.0)
    assert len(one[0]) == 3
    *other, other_velocity = slide(2.0**power)
    assert other == one
    assert other_velocity == pytest.approx(velocity, rel=1e-15)


def slide_to_its_end(posture, q, qdot):
    """The slide of the only foot, on level ground, from this state until it stops: (time, θ, ω) there, in 60 digits.

    With w = [[w_tt, w_nt], [w_nt, w_nn]] and the free acceleration (a_t, a_n) of the foot f_n = −a_n/d with d = w_nn − σμ
    w_nt. In the stretched time τ with dt = d dτ nothing diverges at d = 0, which is reached at infinite τ; the foot stops
    before.
    """
    (contact,) = posture.contacts
    mu, rho2 = Decimal(contact.friction), Decimal(posture.gyration_radius) ** 2
    arm = [
        Decimal(x) - Decimal(c)
        for x, c in zip(contact.point, posture.center_of_mass, strict=True)
    ]
    g = Decimal(posture.gravity)

    def feet(theta):
        cos, sin = cos_sin(theta)
        b, c = cos * arm[0] - sin * arm[1], sin * arm[0] + cos * arm[1]
        return b, c, 1 + c * c / rho2, -b * c / rho2, 1 + b * b / rho2

    theta, omega = Decimal(float(q[2])), Decimal(float(qdot[2]))
    slip = Decimal(float(qdot[0])) - omega * feet(theta)[1]
    way = 1 if slip > 0 else -1

    def rates(state):
        _, theta, omega, _ = state
        b, c, tt, nt, nn = feet(theta)
        d, push = nn - way * mu * nt, g + c * omega**2
        turn = (b + way * mu * c) * push / rho2
        along = (nt - way * mu * tt) * push - b * omega**2 * d
        return [d, omega * d, turn, along]

    def after(state, h):
        def ahead(k, part):
            return [x + h * part * y for x, y in zip(state, k, strict=True)]

        one = rates(state)
        two = rates(ahead(one, HALF))
        three = rates(ahead(two, HALF))
        four = rates(ahead(three, 1))
        sums = zip(one, two, three, four, strict=True)
        return ahead([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in sums], 1)

    state, h = [Decimal(0), theta, omega, slip], Decimal("Infinity")
    while h > 0:
        _, turned, turn, along = rates(state)
        fast = abs(along / slip) + abs(turn / omega) + abs(turned * (1 + mu) / rho2)
        h = min(h, Decimal(2) ** -8 / fast)
        late = after(state, h)
        if late[3] * way > 0:
            state = late
        elif abs(state[3]) < Decimal(10) ** -12:
            break
        else:
            h /= 4
    return state[0], state[1], state[2]


def test_a_slide_to_a_singular_friction_matrix_stops_before_it():
    """The slide stops so close to the instant at which the friction matrix is singular that doubles cannot
    distinguish the two times. It stops by an impulse; no foot jams, and no foot passes the singular instant."""
    random = np.random.default_rng(5)
    seen = 0
    for _ in range(1500):
        mu = 10 ** random.uniform(-0.3, 3)
        rho, center = random.uniform(0.05, 0.5), random.uniform([-1, 0.3], [1, 1.2])
        posture = sf.Posture(
            1.0, rho, center, [sf.Contact((0, 0), friction=mu)], 0.0, 10.0
        )
        qdot = random.normal(size=3) * (1, 0, 1)
        qdot[1] = qdot[2] * center[0]  # it slides along
        run = sf.simulate(
            posture, (0, 0, 0), qdot, model="full", time_limit=1.0, event_limit=20_000
        )
        for before, phase in pairwise(run.phases):
            length = phase.start - before.start
            if phase.cause != "stop" or before.mode not in "RL" or length < 1e-4:
                continue
            q, qdot = run.at(phase.start)
            cos, sin = np.cos(q[2]), np.sin(q[2])
            b, c = (
                -cos * center[0] + sin * center[1],
                -sin * center[0] - cos * center[1],
            )
            way = {"R": 1, "L": -1}[before.mode]
            if abs(1 + (b * b + way * mu * b * c) / rho**2) > 1e-12 * (1 + mu) / rho**2:
                continue
            seen += 1
            start = phase.start - 1e-6
            with localcontext(prec=60):
                lasts, theta, omega = slide_to_its_end(posture, *run.at(start))
            assert float(lasts) == pytest.approx(1e-6, abs=1e-13)
            assert float(theta) == pytest.approx(q[2], abs=1e-12)
            assert float(omega) == pytest.approx(qdot[2], rel=1e-8)
            if seen == 8:
                return
    pytest.fail(f"only {seen} slides come so near")


def exact(row):
    return tuple(Fraction(float(x)) for x in row)


def corners_on_the_ground(run):
    """The exact contact-mode problem of the corners that touch a wall at x = 0 or a floor at y = 0 and do not leave it, from the final
    q and q̇ of a run. Speeds below 1e-10 m/s count as zero."""
    box, (x, y, theta), (vx, vy, omega) = run.posture, run.q, run.qdot
    theta = 0.0 if abs(theta) < 1e-12 else theta
    cos, sin = math.cos(theta), math.sin(theta)
    center = np.add(box.center_of_mass, (x, y))
    arms, tangents, ways, biases = [], [], [], []
    for contact in box.contacts:
        arm = np.subtract(contact.point, box.center_of_mass)
        arm = np.array([cos * arm[0] - sin * arm[1], sin * arm[0] + cos * arm[1]])
        velocity = np.array([vx - omega * arm[1], vy + omega * arm[0]])
        for tangent, normal in [((1, 0), (0, 1)), ((0, -1), (1, 0))]:
            if (center + arm) @ normal > 1e-12 or velocity @ normal > 1e-10:
                continue
            slip = velocity @ tangent
            arms.append(exact(arm))
            tangents.append(exact(tangent))
            ways.append(0 if abs(slip) < 1e-10 else int(np.sign(slip)))
            biases.append(
                exact([-(omega**2) * (arm @ tangent), -(omega**2) * (arm @ normal)])
            )
    return Problem(
        mass=Fraction(1),
        rho2=Fraction(box.gyration_radius) ** 2,
        arms=tuple(arms),
        tangents=tuple(tangents),
        friction=(Fraction(box.contacts[0].friction),) * len(arms),
        sliding=tuple(ways),
        bias=tuple(biases),
        free_acceleration=(Fraction(0), Fraction(-box.gravity), Fraction(0)),
    )


def test_boxes_at_a_wall_stop_without_an_answer_only_where_there_is_none_or_more_than_one():
    """In exact arithmetic. Newton's law has no friction in impacts, and so no impact without collision that ends a jam: a box that slides
    on its lower side, with a coefficient of friction near one, ends there if its mass is far enough from its leading corner."""
    ends = Counter()
    for seed in range(BOXES):
        for law in ("newton", LAWS[1 + seed % 4]):
            box, qdot = flush_box(np.random.default_rng([77, seed]))
            run = sf.simulate(
                box,
                np.zeros(3),
                qdot,
                model="full",
                impact=law,
                simultaneous=order_for(law),
                time_limit=4.0,
                event_limit=20_000,
                record=False,
            )
            if run.outcome in ("inconsistent", "ambiguous"):
                words = corners_on_the_ground(run).motions
                several = run.outcome == "ambiguous"
                assert len(words) > 1 if several else not words, (seed, law, run, words)
                ends[law == "newton", run.outcome] += 1
    assert ends[True, "inconsistent"] >= BOXES / 300
    print(dict(ends))


def scaled_velocity(posture, qdot):
    """(ẋ, ẏ, ρθ̇), of the length √(2 kinetic energy/m)."""
    return np.asarray(qdot) * [1, 1, posture.gyration_radius]


def plastic(posture, k, qdot):
    """q̇ after the impulse that only stops contact k, and that impulse (tangential, normal) over the mass."""
    normals, tangents = jacobian(posture)
    rows = np.array([tangents[k], normals[k]])
    inverse = np.diag([1, 1, posture.gyration_radius**-2.0])
    impulse = -np.linalg.solve(rows @ inverse @ rows.T, rows @ qdot)
    return qdot + inverse @ rows.T @ impulse, impulse


@pytest.mark.parametrize("law", ["newton", "moreau", "chatterjee-ruina"])
def test_a_plastic_impact_ends_a_jam(law):
    """Contact 1 slides to the left and jams, contact 2 is in the air. The impulse is in the friction cone and stops contact 1 only; the rate
    of contact 2 jumps; energy falls."""
    posture = paper_vee(0.5, 2.5)
    found = sf.stability(posture).evidence
    [number], q, qdot = found["contacts"], found["q"], np.array(found["qdot"])
    options = {"model": "local", "impact": law}
    assert sf.simulate(posture, q, qdot, **options).outcome == "inconsistent"
    run = sf.simulate(posture, q, qdot, jams="impact", **options)
    expected, (p_t, p_n) = plastic(posture, number - 1, qdot)
    assert abs(p_t) < 0.5 * p_n
    hit = run.impacts[0]
    assert (hit["contact"], hit["time"]) == (number, 0.0)
    assert hit["impulse"] == pytest.approx([p_t, p_n], rel=1e-12)
    after = hit["rates_after"][2 - number]
    normals, _ = jacobian(posture)
    assert after == pytest.approx(normals[2 - number] @ expected, rel=1e-12)
    assert hit["rates_after"][number - 1] == 0.0
    sizes = [np.linalg.norm(scaled_velocity(posture, v)) for v in (qdot, expected)]
    assert sizes[1] < sizes[0]
    assert "plastic impact without collision" in " ".join(run.warnings)
    assert run.outcome == "rest"


def test_both_contacts_stop_where_both_jam():
    """Both contacts slide along their common direction, and no word is consistent. Impulses in both cones bring the body to rest."""
    posture = paper_vee(0.8, 2.0)
    found = sf.stability(posture).evidence
    assert found["contacts"] == [1, 2]
    qdot = np.array(found["qdot"])
    run = sf.simulate(posture, found["q"], qdot, model="local", jams="impact")
    assert (run.outcome, run.elapsed) == ("rest", 0.0)
    assert [int(k) for k in run.impacts["contact"]] == [1, 2]
    normals, tangents = jacobian(posture)
    inverse = np.diag([1, 1, posture.gyration_radius**-2.0])
    change = np.zeros(3)
    for hit in run.impacts:
        p_t, p_n = hit["impulse"]
        assert abs(p_t) <= 0.5 * p_n * (1 + 1e-12)
        k = int(hit["contact"]) - 1
        change += inverse @ (normals[k] * p_n + tangents[k] * p_t)
    assert change == pytest.approx(-qdot, abs=1e-12 * np.abs(qdot).max())


def test_the_rod_of_painleve_goes_on_beyond_its_singular_point():
    """A rod that slides until sliding coefficient and load vanish together (Génot and Brogliato): at .81454966 s it points down at 45°. The
    state there is that of an integration by DOP853 with relative tolerance 1e-13."""
    angle = math.radians(31)
    foot = sf.Contact((0, 0), friction=5 / 3)
    rod = sf.Posture(
        1,
        math.sqrt(1 / 3),
        (-math.cos(angle), math.sin(angle)),
        [foot],
        0,
        10,
    )
    assert sf.simulate(rod, (0, 0, 0), (30, 0, 0)).outcome == "inconsistent"
    run = sf.simulate(rod, (0, 0, 0), (30, 0, 0), jams="impact", time_limit=1.0)
    hit = run.impacts[0]
    assert hit["time"] == pytest.approx(0.81454966, abs=2e-8)
    q, qdot = run.at(np.nextafter(hit["time"], 0))
    assert q == pytest.approx([18.58728236, 0.19206871, -0.24434610], abs=1e-6)
    assert qdot == pytest.approx([11.99226, 2.65915, -3.76060], abs=2e-4)
    for t, omega in zip(
        (0.2, 0.4, 0.6, 0.8),
        (-0.0106636793, -0.0523427100, -0.263934370, -2.44951002),
        strict=True,
    ):
        assert run.at(t)[1][2] == pytest.approx(omega, rel=1e-7)
    p_t, p_n = hit["impulse"]
    assert p_t / p_n == pytest.approx(-5 / 3, rel=1e-6)
    assert run.outcome == "time-limit"


def test_no_kick_of_a_body_that_jams_is_left_without_a_motion():
    """With jams="impact" small kicks are never inconsistent, and energy never rises."""
    rng, jammed = np.random.default_rng(9), 0
    for _ in range(30):
        feet = [
            sf.Contact((x, rng.uniform(-0.4, 0.4)), slope, friction=rng.uniform(0.3, 2))
            for x, slope in zip((-1, 1), rng.uniform(-1, 1, 2), strict=True)
        ]
        posture = sf.Posture(1, 0.4, rng.uniform((-0.9, 0.5), (0.9, 2.5)), feet, 0.3)
        qdot = rng.normal(0, 1e-3, (30, 3))
        options = {"model": "local", "neighbourhood": 1.0, "event_limit": 20_000}
        options["impact"] = "newton"
        runs = sf.simulate_many(posture, (0, 0, 0), qdot, **options)
        if "inconsistent" not in runs.outcome:
            continue
        jammed += 1
        for start in qdot[:10]:
            run = sf.simulate(posture, (0, 0, 0), start, jams="impact", **options)
            assert run.outcome != "inconsistent", (posture, start)
            t = run.sample(50)[0]
            energy = run.energy(t)
            assert np.all(np.diff(energy) <= 1e-12 * np.abs(energy).max())
    assert jammed >= 5
