"""Any number of contacts, and impacts with friction."""

import math
import os

import numpy as np
import pytest
import standfast as sf
from bodies import FRICTION_LAWS, IN_TURN, with_defaults

G = 9.81
#: Random scenes for each law.
SCENES = int(os.environ.get("STANDFAST_SCENES", "150"))


resting = with_defaults(
    sf.Posture,
    mass=1.0,
    gyration_radius=0.5,
    center_of_mass=(0.0, 0.7),
    restitution=0.3,
    gravity=G,
)


def body(feet, **change):
    """A body with feet on level ground."""
    contacts = [sf.Contact(point=(x, 0.0), friction=0.5) for x in feet]
    return resting(**({"contacts": contacts} | change))


@pytest.mark.parametrize("model", ["full", "local"])
@pytest.mark.parametrize(("rho", "e"), [(0.2, 0.1), (0.5 / math.sqrt(3), 0.5)])
def test_two_ways_to_sum(model, rho, e):
    """Chatterjee and Ruina's law without friction equals Newton's law. With their law the bounces of one contact are
    summed from the changes of the state, and two contacts in turn are followed until their speeds are rounding errors;
    with Newton's law all sums are closed forms. Both pass through a Zeno point of Zeno points."""
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=rho, restitution=e)
    start = {"q": (0, 0.011, math.asin(0.002)), "qdot": (0, 0, 0), "model": model}
    summed = sf.simulate(rod, **start)
    followed = sf.simulate(
        rod, **start, impact="chatterjee-ruina", simultaneous=IN_TURN
    )
    assert summed.outcome == followed.outcome == "rest"
    assert followed.time == pytest.approx(summed.time, rel=4e-15)
    np.testing.assert_allclose(followed.q, summed.q, atol=1e-14)


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_a_ball_bounces(law):
    ball = body([0.0], restitution=0.7, center_of_mass=(0, 0.5))
    run = sf.simulate(ball, (0, 1, 0), (0, 0, 0), model="local", impact=law)
    assert run.outcome == "rest"
    assert run.time == pytest.approx(math.sqrt(2 / G) * 1.7 / 0.3, rel=1e-14)


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_a_spinning_ball_slips_and_then_rolls(law):
    """m = 1, R = .1, Θ = ⅖mR², μ = .2, e = 0, dropped from a height of 1 with ω = 50 and 10. A disc is exact in the local
    model: its contact stays under its centre."""
    radius, mu = 0.1, 0.2
    ball = body(
        [0.0],
        gyration_radius=radius * math.sqrt(0.4),
        center_of_mass=(0, radius),
        contacts=[sf.Contact(point=(0, 0), friction=mu)],
        restitution=0.0,
    )
    start = {"q": (0, 1 - radius, 0), "model": "local", "impact": law}
    fall = math.sqrt(2 * (1 - radius) / G)
    run = sf.simulate(ball, **start, qdot=(0, 0, 50))
    assert run.impacts["time"] == pytest.approx([fall], rel=1e-15)
    # The impact gives −μ g·fall to the velocity, sliding friction the rest of 10/7 of −R·50·2/7.
    slides, rolls = run.phases[1:]
    assert (slides.mode, rolls.mode) == ("R", "F")
    _, after = run.at(slides.start)
    assert after[0] == pytest.approx(-mu * G * fall, rel=1e-14)
    assert run.qdot == pytest.approx([-10 / 7, 0, 100 / 7], rel=1e-13)
    assert rolls.start == pytest.approx(
        fall + (10 / 7 + after[0]) / (mu * G), rel=1e-14
    )
    sticks = sf.simulate(ball, **start, qdot=(0, 0, 10))
    assert [phase.mode for phase in sticks.phases] == ["S", "F"]
    assert sticks.qdot == pytest.approx([-2 / 7, 0, 20 / 7], rel=1e-14)


@pytest.mark.parametrize("e", [0.05, 0.3, 0.6])
@pytest.mark.parametrize("tilt", [0.0, 0.05])
def test_a_table_on_three_legs_slides_and_rests(e, tilt):
    table = body([-1.0, 0.1, 1.0], restitution=e)
    run = sf.simulate(table, (0, 0.1, tilt), (0.3, 0, 0), impact="newton")
    assert run.outcome == "rest"
    assert run.phases[-1].mode == "FFF"
    assert run.phases[-2].mode == "RRR"
    np.testing.assert_allclose(run.gaps, 0.0)
    slide = run.phases[-2]
    _, before = run.at(slide.start)
    assert slide.end - slide.start == pytest.approx(before[0] / (0.5 * G), rel=1e-12)
    if tilt == 0.0:
        # All three land at once and bounce like a ball: T = t₁(1 + e)/(1 − e).
        zeno = run.zeno_points[-1]
        assert zeno.kind == "3-zeno"
        expected = math.sqrt(0.2 / G) * (1 + e) / (1 - e)
        assert zeno.time == pytest.approx(expected, rel=1e-12)
        assert any("same instant" in warning for warning in run.warnings)


def test_a_middle_leg_too_short_to_touch_changes_nothing():
    feet = [sf.Contact(point=(x, 0), friction=0.3) for x in (-0.5, 0.5)]
    idle = sf.Contact(point=(0, 0.4), slope=0.0, friction=0.3)
    two = body([], contacts=feet, restitution=0.2, center_of_mass=(0, 0.5))
    # Its ground is the line through its nominal position.
    three = body([], contacts=[*feet, idle], restitution=0.2, center_of_mass=(0, 0.5))
    start = ((0, 0.02, 0.01), (0.1, 0, 0))
    one, other = (sf.simulate(p, *start, stop="zeno") for p in (two, three))
    # The third leg, between the two others, is never the lowest of a tilted body, until all rest together.
    assert other.impacts["contact"][0] == one.impacts["contact"][0]
    assert other.impacts["time"][0] == one.impacts["time"][0]


@pytest.mark.parametrize("law", ["newton", "poisson", "stronge", "chatterjee-ruina"])
def test_energy_never_rises(law):
    rng = np.random.default_rng(7)
    ends = {}
    for _ in range(SCENES):
        contacts = [
            sf.Contact(
                point=(rng.uniform(-1, 1), rng.uniform(-0.2, 0.2)),
                slope=rng.uniform(-0.4, 0.4),
                friction=rng.uniform(0, 1.5),
            )
            for _ in range(1 if law in ("poisson", "stronge") else rng.integers(1, 5))
        ]
        posture = body(
            [],
            contacts=contacts,
            center_of_mass=(rng.uniform(-0.3, 0.3), rng.uniform(0.2, 0.8)),
            restitution=rng.uniform(0, 0.8),
        )
        q = np.array([0, 0, rng.uniform(-0.1, 0.1)])
        q[1] = 0.02 - min(posture.gaps(q)) / math.cos(0.4)
        if min(posture.gaps(q)) < 0:
            continue
        run = sf.simulate(
            posture,
            q,
            rng.normal(size=3) * 0.5,
            impact=law,
            simultaneous="newton" if law == "newton" else IN_TURN,
            event_limit=20_000,
            time_limit=10.0,
        )
        ends[run.outcome] = ends.get(run.outcome, 0) + 1
        times = np.unique([t for phase in run.phases for t in (phase.start, phase.end)])
        energy = run.energy(times[:2000])
        scale = np.abs(energy).max() + 1.0
        assert np.diff(energy).max(initial=0.0) <= 1e-12 * scale
    print(law, ends)
    assert sum(ends.values()) > SCENES / 2


def between_two_feet(*others, friction=0.5, restitution=0.3):
    """A slender body on two feet at one level, and on others."""
    feet = [sf.Contact(point=(x, 0), friction=friction) for x in (-0.8, 0.8)]
    return body(
        [],
        contacts=[*feet, *others],
        gyration_radius=0.2,
        center_of_mass=(0.1, 0.5),
        restitution=restitution,
    )


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_impacts_in_turn_at_a_corner_come_to_an_end(law):
    """Foot 1 rests, foot 2 lands at .8 m/s: slower and slower alternate impacts at one instant, after which both rest."""
    posture, turn = between_two_feet(), (0, -0.45, -0.5)
    assert posture.gap_rates((0, 0, 0), turn) == pytest.approx((0, -0.8), abs=1e-16)
    run = sf.simulate(
        posture,
        (0, 0, 0),
        turn,
        impact=law,
        simultaneous=IN_TURN,
        event_limit=20_000,
    )
    assert run.outcome == "rest"
    assert len(run.impacts) < 500


@pytest.mark.parametrize("gravity", [G, 0.0])
def test_a_slow_sequence_of_impacts_in_one_instant_is_summed(gravity):
    """ψ = .9999: its impacts lose 1e-4 of their speed each, so there would be 4e5 of them. The final velocity is the
    projection of the velocity on sliding along both feet."""
    feet = [sf.Contact(point=(x, 0), slope=0.0) for x in (-0.8, 0.8)]
    posture = body(
        [],
        contacts=feet,
        gyration_radius=0.8 * math.sqrt(5e-5),
        center_of_mass=(0, 0.5),
        restitution=0.18,
        gravity=gravity,
    )
    start = {"q": (0, 0, 0), "qdot": (0.3, -0.45, -0.5), "model": "local"}
    run = sf.simulate(
        posture, **start, impact="chatterjee-ruina", simultaneous=IN_TURN, stop="zeno"
    )
    assert (run.outcome, run.time, run.zeno_points[0].kind) == ("zeno", 0.0, "2-zeno")
    assert len(run.impacts) < 200
    assert run.qdot == pytest.approx([0.3, 0, 0], abs=1e-12)
    assert run.rates.tolist() == [0, 0]


def test_three_smooth_contacts_come_to_rest():
    """As the test before, but without friction, by Newton's law, and with a third contact."""
    posture = between_two_feet(sf.Contact(point=(-0.4, 0), slope=0.2), friction=0.0)
    run = sf.simulate(
        posture,
        (0, 0, 0),
        (0, -0.45, -0.5),
        model="local",
        event_limit=20_000,
        time_limit=2.0,
    )
    assert run.outcome != "event-limit"


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_a_plastic_impact_leaves_no_rate(law):
    """The gap rate after the impact is exactly zero. A rate of 1e-16 would cause a flight of 1e-17 s or another
    impact, and a separate Zeno point."""
    rng = np.random.default_rng(1)
    for _ in range(50):
        foot = sf.Contact(
            point=rng.uniform(-0.5, 0.5, 2), slope=rng.uniform(-0.4, 0.4), friction=0.4
        )
        posture = body([], contacts=[foot], restitution=0.0)
        run = sf.simulate(
            posture, (0, 0.1, 0), rng.normal(size=3), impact=law, time_limit=0.3
        )
        for impact in run.impacts:
            assert impact["rates_after"][0] == 0


def test_a_run_without_a_phase_can_be_looked_into():
    """Three feet of different friction slide: the distribution of the weight, and with it the deceleration, is undetermined."""
    feet = [
        sf.Contact(point=(x, 0.0), friction=mu)
        for x, mu in [(-1.0, 0.2), (0.1, 0.5), (1.0, 0.8)]
    ]
    run = sf.simulate(body([], contacts=feet), (0, 0, 0), (0.3, 0, 0))
    assert (run.outcome, run.time) == ("ambiguous", 0.0)
    q, qdot = run.at(0.0)
    assert q.tolist() == [0, 0, 0]
    assert qdot.tolist() == [0.3, 0, 0]
    assert run.energy(0.0) == pytest.approx(0.5 * 0.3**2)


@pytest.mark.parametrize("length", [1.0, 3.0, 0.1, 1 / 3, 1.7])
def test_two_feet_land_at_once_on_the_floor_of_the_third(length):
    """The body pivots about foot 3. In the local model, where all feet touch at θ = 0, the other two land together in any
    unit of length, and so do any two while it pivots about the third, in smaller and smaller rounds."""
    feet = [
        sf.Contact(point=(x * length, y * length), friction=0.5)
        for x, y in [(-0.7, 0.05), (-0.1, -0.1), (0.8, 0.0)]
    ]
    posture = body(
        [],
        contacts=feet,
        gyration_radius=0.6 * length,
        center_of_mass=(0.2 * length, 0.45 * length),
        restitution=0.15,
        gravity=G * length,
    )
    ends = {}
    for policy in (IN_TURN, "last-contact-first"):
        run = sf.simulate(
            posture,
            (0, 0, 0),
            (0.3 * length, 0.18 * length, -0.3),
            model="local",
            impact="chatterjee-ruina",
            simultaneous=policy,
        )
        assert any("same instant" in warning for warning in run.warnings)
        ends[policy] = run.time
    expected = {IN_TURN: 0.106411750879892, "last-contact-first": 0.113057822730814}
    assert ends == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("model", ["local", "full"])
def test_a_straight_drop_lands_on_all_slopes_at_once(model):
    """Every gap is h cos β: for any slopes and height the feet land together at √(2h/g)."""
    feet = [sf.Contact((-1, 0), slope=-0.3), sf.Contact((1.2, 0.2), slope=0.2)]
    posture = body([], contacts=feet, center_of_mass=(0.3, 0.5), restitution=0.4)
    for k in range(1, 101):
        height = k * 1e-9
        run = sf.simulate(posture, (0, height, 0), (0, 0, 0), model=model, stop="zeno")
        assert any("same instant" in warning for warning in run.warnings), k
        first, second = run.impacts[:2]
        assert first["time"] == second["time"]
        assert first["time"] == pytest.approx(math.sqrt(2 * height / G), rel=1e-15)
        assert {int(first["contact"]), int(second["contact"])} == {1, 2}
    free, full = (
        sf.simulate(posture, (0, 1e-9, 0), (0, 0, 0), model=m, stop="zeno")
        for m in ("auto", "full")
    )
    assert free.time == pytest.approx(full.time, rel=1e-4)


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("model", ["local", "full"])
def test_any_moment_is_the_end_of_a_shorter_run(model, count):
    """`run.at` equals the end of a shorter run at any moment, also when a body begins to rotate about a foot from
    rest, or has stopped for a moment."""
    random = np.random.default_rng(12)
    moved = 0
    for _ in range(25):
        feet = [
            sf.Contact(
                (x + random.uniform(-0.2, 0.2), random.uniform(-0.1, 0.1)),
                slope=random.uniform(-0.3, 0.3),
                friction=random.choice([0.0, 0.5, 2.0]),
            )
            for x in (-1, 0, 1)[:count]
        ]
        posture = body(
            [],
            contacts=feet,
            center_of_mass=(random.uniform(-1.5, 1.5), random.uniform(0.2, 1.0)),
            restitution=0.3,
        )
        begin = (0, 0, 0), random.normal(0, 0.3, 3) * random.choice([0, 1])
        if min(posture.gap_rates(*begin)) < 0:
            begin = (0, 0, 0), (0, 0, 0)
        options = {"model": model, "impact": "newton"}
        whole = sf.simulate(posture, *begin, time_limit=0.5, **options)
        for share in (0.03, 0.2, 0.7):
            t = share * whole.elapsed
            part = sf.simulate(posture, *begin, time_limit=t, **options)
            assert whole.at(t)[0] == pytest.approx(part.q, abs=1e-11)
            assert whole.at(t)[1] == pytest.approx(part.qdot, abs=1e-9)
            moved += bool(np.abs(part.q).max() > 1e-4)
    assert moved > 20


def test_a_body_begins_to_turn_about_its_foot():
    """From rest with its centre of mass beside the foot: θ = αt²/2 in the local model, α = −mgx/I about the foot."""
    inertia = 0.5**2 + 0.3**2 + 1.0
    foot = sf.Contact((0, 0), friction=2.0)
    posture = body([], contacts=[foot], center_of_mass=(0.3, 1.0), gyration_radius=0.5)
    run = sf.simulate(posture, (0, 0, 0), (0, 0, 0), model="local", time_limit=0.4)
    assert run.phases[0].mode == "F"
    t = np.linspace(0, 0.4, 9)
    assert run.at(t)[0][:, 2] == pytest.approx(-0.5 * G * 0.3 / inertia * t**2)


@pytest.mark.parametrize("never", [0, 1])
def test_one_that_never_lands_lands_with_nobody(never):
    """A contact without gravity into its terrain keeps its gap until the other contact lands. The impact of the
    other contact throws it off."""
    gravity, gaps = [10.0, 10.0], [1.0, 1.0]
    gravity[never], gaps[never] = 0.0, 0.3
    local = sf.LocalModel(gravity, psi=(-0.5, -0.5), phi=(0, 0), restitution=0.5)
    run = local.simulate(gaps, (0, 0), time_limit=1.0)
    assert run.warnings == []
    first, lands = run.impacts[0], 1 - never
    speed = math.sqrt(20)
    assert first["contact"] == lands + 1
    assert first["rates_before"][[lands, never]] == pytest.approx([-speed, 0])
    assert first["rates_after"][[lands, never]] == pytest.approx(
        [0.5 * speed, 0.5 * 1.5 * speed]
    )
    (at_impact,) = run.gaps_at([first["time"]])
    assert at_impact[[lands, never]] == pytest.approx([0.0, 0.3], abs=1e-15)


@pytest.mark.parametrize("law", ["poisson", "stronge", "chatterjee-ruina"])
def test_a_sum_of_rounds_leaves_both_feet_on_the_ground(law):
    """Between two slopes the body rotates a little in the rounds that are summed: it continues to slide from its position at
    the end."""
    feet = [
        sf.Contact((-0.8, 0), slope=-0.84, friction=0.2),
        sf.Contact((0.6, 0), slope=0.87, friction=0.2),
    ]
    posture = sf.Posture(1.0, 1.22, (0.15, 0.31), feet, 0.0)
    run = sf.simulate(
        posture,
        (0, 0.11, 0),
        (-1, 1.4, -0.5),
        impact=law,
        simultaneous=IN_TURN,
        model="full",
        time_limit=5,
    )
    (zeno,) = [point for point in run.zeno_points if point.method == "nested"]
    q, qdot = run.at(zeno.time)
    assert np.abs(qdot - zeno.qdot).max() <= 1e-15
    assert np.abs(posture.gap_rates(q, qdot)).max() <= 1e-15
    places = run.at(np.linspace(zeno.time, run.time, 100))[0]
    assert np.abs(posture.gaps(places)).max() <= 1e-14


def test_a_sum_of_rounds_can_be_looked_into():
    """Moreau's impacts of a body with frozen geometry. Speeds that count as zero in the run also count as zero when
    `run.at` evaluates the sum."""
    feet = [sf.Contact((x, 0), friction=1) for x in (-0.4, 0.4)]
    posture = sf.Posture(1.0, 0.15, (-0.12, 0.5), feet, 0.0)
    run = sf.simulate(
        posture,
        (0, 0.02, -0.024),
        (0, 0, 0),
        impact="moreau",
        simultaneous=IN_TURN,
        model="local",
    )
    assert (run.outcome, run.zeno_points[-1].method) == ("rest", "nested")
    times = run.sample(300)[0]
    since = times[times >= run.zeno_points[-2].time]
    assert len(since) > 10
    gaps = run.gaps_at(since)
    assert gaps.min() >= 0
    assert gaps.min(axis=1).max() <= 1e-15


@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.5, 0.7])
@pytest.mark.parametrize(
    "feet",
    [(-1, -0.75, -0.5, 0.1), (0.1, -0.5, -0.75, -1), (-1, -0.5, 0.1, 0.5, 0.8, 1)],
)
def test_feet_in_a_row_bounce_together_to_the_end(feet, restitution):
    """At any speed: t = sqrt(2h/g) (1 + e)/(1 - e)."""
    contacts = [sf.Contact((x, 0)) for x in feet]
    for height in (0.1, 0.2, 1.0, 3.0):
        body = sf.Posture(1.0, 0.5, (0.05, 0.5), contacts, restitution, 9.81)
        run = sf.simulate(body, (0, height, 0), (0, 0, 0))
        rest = np.sqrt(2 * height / 9.81) * (1 + restitution) / (1 - restitution)
        assert (run.outcome, run.elapsed) == ("rest", pytest.approx(rest, rel=1e-13))


def test_feet_in_one_line_land_together():
    """A body that has come to rest on one of three feet on one line pivots about it until the other two land at one instant,
    whose rounding error is that of the foot without impacts so far. With Newton's law for all of them at once only the outer
    one has an impulse, and 1e-14 m more of height change nothing."""
    feet = [sf.Contact((x, 0.0)) for x in (-0.2, 0.3, 0.8)]
    posture = body(
        [],
        contacts=feet,
        gyration_radius=0.5,
        center_of_mass=(0.4, 0.2),
        restitution=0.5,
        gravity=10.0,
    )
    ends = []
    for height in (0.2, 0.20000000000001):
        run = sf.simulate(posture, (0, height, -0.03), (0, 0, 0), model="full")
        assert run.outcome == "rest"
        late = run.impacts[run.impacts["time"] > 0.611]
        assert late["index"][0] == 2
        before, after = late["rates_before"][0], late["rates_after"][0]
        assert before[0] == 0
        assert before[2] == pytest.approx(2 * before[1], rel=1e-9)
        assert (after + 0.5 * before >= 0).all()
        ends.append(run.time)
    assert ends[0] == pytest.approx(ends[1], abs=1e-12)


@pytest.mark.parametrize("slide", [0.0, 1.0, 100.0])
@pytest.mark.parametrize("slow", [1e-3, 5e-10, 1e-11])
def test_impacts_of_one_instant_do_not_depend_on_the_slide(slide, slow):
    """Four feet on one line, e = (0, 0, ½, ½), hit with (0, ½, 5/4, 2) times a slow rate: P_3 = 0, and without friction the
    velocity along the ground has no effect. u⁺ + e u⁻ is (0, ¼, 0, 0)."""
    feet = [
        sf.Contact((x, 0), restitution=e)
        for x, e in zip((-1, -0.5, 0.25, 1), (0, 0, 0.5, 0.5), strict=True)
    ]
    posture = sf.Posture(1.0, 0.5, (0, 0.5), feet, 0.0, 10.0)
    run = sf.simulate(
        posture, (0, 0, 0), (slide, -slow, -slow), model="full", time_limit=1.0
    )
    first = run.impacts[run.impacts["time"] == 0.0][0]
    assert first["rates_before"] / slow == pytest.approx([0, -0.5, -1.25, -2])
    assert first["rates_after"] / slow == pytest.approx([0, 0.25, 0.625, 1], abs=1e-6)
    assert run.outcome == ("rest" if slide == 0.0 else "time-limit")
