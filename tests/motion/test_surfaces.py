"""Ground of several materials, and surfaces that move along their tangent as belts do."""

import json
import math
import os
import pickle

import numpy as np
import pytest
import standfast as sf

G = 9.81
SCENES = int(os.environ.get("STANDFAST_BELTS", "300"))
LAWS = ("newton", "moreau", "poisson", "stronge")


def body(rng, speed):
    """A body on one to four points or discs over one line, whose surface may move with `speed`; and the tangent of the line."""
    count = int(rng.integers(1, 5))
    slope = float(rng.choice([0, 0, 0.1, -0.3]))
    tangent = np.array([math.cos(slope), math.sin(slope)])
    normal = np.array([-tangent[1], tangent[0]])
    places, heights = np.sort(rng.uniform(-0.5, 0.5, count)), rng.uniform(0, 0.3, count)
    # Two feet may lie flat; three would be hit in an order that rounding decides.
    if count == 2 and rng.random() < 0.5:
        heights[:] = 0
    friction, round_ones = rng.choice([0.2, 0.5, 1.0], count), rng.random(count) < 0.2
    fields = {
        "mass": 1.0,
        "gyration_radius": rng.uniform(0.2, 0.5),
        "center_of_mass": (rng.normal(0, 0.15), rng.uniform(0.1, 0.6)),
        "restitution": float(rng.choice([0, 0.3, 0.6])),
        "ground": "shared",
    }

    def posture(speed):
        contacts = [
            sf.Contact(
                tuple(tangent * x + normal * (h - heights.min())),
                slope=slope,
                friction=mu,
                radius=0.05 if is_round else 0.0,
                surface_speed=speed,
            )
            for x, h, mu, is_round in zip(
                places, heights, friction, round_ones, strict=True
            )
        ]
        return sf.Posture(contacts=contacts, **fields)

    return posture(0.0), posture(speed), np.array([*(tangent * speed), 0.0])


def at_the_end(run, velocity, end):
    """Displacement and velocity at the time `end` in a frame that moves with `velocity`. A body that rests stays there."""
    return np.r_[run.q - velocity * end, run.qdot - velocity]


def test_a_belt_is_a_world_that_moves():
    """Over a surface that moves a body moves as over one at rest, seen from the surface: all laws, sums, rest and rolling."""
    rng = np.random.default_rng(2)
    clear = rode = 0
    for k in range(SCENES):
        still, belt, velocity = body(rng, float(rng.choice([-2, 0.5, 1, 3])))
        q = np.array([0, rng.choice([0, 0.2]), 0])
        qdot = rng.normal(0, 1, 3) * rng.choice([0, 0.1, 1])
        end = rng.uniform(0.5, 5)
        options = {
            "impact": str(rng.choice(LAWS)),
            "model": "full",
            "time_limit": end,
            "event_limit": 20_000,
        }
        run = sf.simulate(still, q, qdot, **options)
        if run.outcome not in ("rest", "time-limit"):
            continue
        if len(run.phases) > 50:
            continue  # it rocks from foot to foot at speeds far below the rounding of the speed of the belt
        # What a rounding of the larger velocities on the belt may do.
        size = 2.3e-16 * np.abs(velocity).max()
        others = [
            sf.simulate(still, q, qdot + np.array(change) * size, **options)
            for change in ((1, 0.3, 0.5), (-0.7, 1, -1), (0.2, -1, 1))
        ]
        expected = at_the_end(run, 0 * velocity, end)
        spread = max(
            np.abs(at_the_end(other, 0 * velocity, end) - expected).max()
            for other in others
        )
        if spread > 1e-13:
            continue
        clear += 1
        moved = sf.simulate(belt, q, qdot + velocity, **options)
        assert moved.outcome == "time-limit", k
        np.testing.assert_allclose(
            at_the_end(moved, velocity, end),
            expected,
            rtol=0,
            atol=1e-12 * max(1, np.abs(velocity).max()),
            err_msg=str(k),
        )
        rode += run.outcome == "rest"
    assert clear > 0.6 * SCENES
    assert rode > 0.1 * SCENES


def test_a_block_is_carried_off():
    """From rest it slides back over the belt for σ/(μg) and then rides."""
    speed, mu = 3.0, 0.4
    feet = [sf.Contact((x, 0), friction=mu, surface_speed=speed) for x in (-0.5, 0.5)]
    block = sf.Posture(1.0, 0.3, (0, 0.1), feet, 0.2, gravity=G)
    run = sf.simulate(block)
    time = speed / (mu * G)
    assert run.outcome == "sliding"
    assert [phase.mode for phase in run.phases] == ["LL", "FF"]
    assert abs(run.phases[1].start - time) < 1e-15
    np.testing.assert_allclose(run.qdot, [speed, 0, 0], rtol=0, atol=1e-15)
    later = sf.simulate(block, time_limit=10.0)
    np.testing.assert_allclose(
        later.q, [speed * (10 - time / 2), 0, 0], rtol=1e-14, atol=1e-14
    )
    np.testing.assert_allclose(
        later.at(5.0)[0], [speed * (5 - time / 2), 0, 0], rtol=1e-14, atol=1e-14
    )


def test_a_disc_is_spun_up():
    """A solid disc slips until 3 μ g t = σ. Then it rolls on the belt at v = σ/3, with R ω = −2σ/3."""
    speed, mu, radius = 2.0, 0.3, 0.25
    wheel = sf.Contact((0, 0), friction=mu, radius=radius, surface_speed=speed)
    disc = sf.Posture(1.0, radius / math.sqrt(2), (0, radius), [wheel], 0.0, gravity=G)
    run = sf.simulate(disc, time_limit=20.0)
    assert [phase.mode for phase in run.phases] == ["L", "F"]
    time = speed / (3 * mu * G)
    assert abs(run.phases[1].start - time) < 1e-15
    # ω is counterclockwise: the belt drags the lowest point to the right.
    np.testing.assert_allclose(
        run.qdot, [speed / 3, 0, 2 * speed / (3 * radius)], rtol=1e-14, atol=1e-15
    )
    np.testing.assert_allclose(
        run.q[0], mu * G * time**2 / 2 + speed / 3 * (20 - time), rtol=1e-14
    )


def test_a_foot_on_the_floor_holds_the_other_on_a_belt():
    """The belt under the right foot pulls with μ' N; the left foot on the floor holds it: the body is at rest and rubs."""
    terrain = [(-5, 0), (0, 0), (5, 0)]
    feet = [sf.Contact((-0.5, 0), friction=0.8), sf.Contact((0.5, 0), friction=0.2)]
    block = sf.Posture(
        2.0,
        0.4,
        (0, 0.3),
        feet,
        0.0,
        gravity=G,
        terrain=terrain,
        terrain_speed=[None, 1.5],
    )
    run = sf.simulate(block)
    assert run.outcome == "rest"
    assert run.phases[-1].mode == "FL"
    # Moments about the left foot: N₂ w = m g w/2 + 0, horizontal forces act along the ground.
    forces = run.forces_at(0.0)
    np.testing.assert_allclose(forces[1], [0.2 * G, G], rtol=1e-14)
    np.testing.assert_allclose(forces[0], [-0.2 * G, G], rtol=1e-14)


def test_the_hold_on_the_floor_ends_under_a_growing_load():
    """The same block while the ground accelerates as j t, to the right: the left foot slips where
    a − μ₂ (g/2 − a h/w) = μ₁ (g/2 + a h/w)."""
    jerk, lever = 5.0, 0.3
    limit = (0.8 + 0.2) * G / 2 / (1 + (0.2 - 0.8) * lever)
    feet = [sf.Contact((-0.5, 0), friction=0.8), sf.Contact((0.5, 0), friction=0.2)]
    terrain = [(-50, 0), (0, 0), (50, 0)]
    block = sf.Posture(
        2.0,
        0.4,
        (0, lever),
        feet,
        0.0,
        gravity=G,
        terrain=terrain,
        terrain_speed=[None, 1.5],
    )
    shake = sf.GroundMotion([0, 2], [0.0, 2 * jerk], interpolation="linear")
    run = sf.simulate(block, ground_motion=shake, time_limit=limit / jerk + 0.1)
    phases = [phase for phase in run.phases if phase.end > phase.start]
    assert [phase.mode for phase in phases] == ["FL", "LL"]
    assert abs(phases[1].start - limit / jerk) < 1e-14
    # Both feet slide to the left over their grounds: x'' = −j (t − t*).
    np.testing.assert_allclose(
        run.q, [-jerk * 0.1**3 / 6, 0, 0], rtol=1e-11, atol=1e-14
    )
    # The ground goes back: the left foot stops and then slides to the right, while the right one slides to the left over its belt. As with steps.
    times, values = np.array([0, 2, 2.3, 2.6, 3]), np.array([0.0, 8.0, 0.0, -6.0, 0.0])
    fine = np.linspace(0, 3, 6401)
    exact = np.interp(fine, times, values)
    means = [*(exact[:-1] + exact[1:]) / 2, 0.0]
    linear = sf.GroundMotion(times, values, interpolation="linear")
    runs = [
        sf.simulate(block, ground_motion=motion, time_limit=2.7)
        for motion in (linear, sf.GroundMotion(fine, means))
    ]
    for found in runs:
        words = [phase.mode for phase in found.phases if phase.end > phase.start]
        assert [word for k, word in enumerate(words) if word not in words[:k]] == [
            "FL",
            "LL",
            "RL",
        ]
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-6)


def test_a_block_that_rides_slips_where_one_at_rest_does():
    """A record is a motion of the whole world: the belt carries the block as the floor does, until the same instant."""
    shake = sf.GroundMotion([0, 2, 4], [0.0, 8.0, -8.0], interpolation="linear")
    ends = []
    for speed in (0.0, 1.5):
        feet = [
            sf.Contact((x, 0), friction=0.4, surface_speed=speed) for x in (-0.5, 0.5)
        ]
        block = sf.Posture(1.0, 0.3, (0, 0.1), feet, 0.2, gravity=G)
        run = sf.simulate(
            block, qdot=(speed, 0, 0), ground_motion=shake, time_limit=3.0
        )
        phases = [phase for phase in run.phases if phase.end > phase.start]
        assert phases[0].mode == "FF"
        assert abs(phases[1].start - 0.4 * G / 4) < 1e-14
        np.testing.assert_allclose(
            run.at(0.5)[0], [speed * 0.5, 0, 0], rtol=0, atol=1e-15
        )
        ends.append(run.q - [3 * speed, 0, 0])
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=1e-12)


def test_a_box_falls_from_the_end_of_a_belt():
    """It rides to the end of the belt, over the pulley, and tips over; before, each foot is where the belt has carried it."""
    belt = {"terrain": [(-3, 0), (0, 0), (0, -4)], "terrain_speed": [0.5, None]}
    box = sf.Posture.polygon(
        [(-1.2, 0), (-0.8, 0), (-0.8, 0.3), (-1.2, 0.3)],
        friction=0.6,
        gravity=G,
        **belt,
    )
    run = sf.simulate(box, (0, 0, 0), (0.5, 0, 0), time_limit=2.2)
    rides, _ = run.at(1.5)
    np.testing.assert_allclose(rides, [0.75, 0, 0], rtol=1e-15, atol=1e-15)
    assert run.at(2.2)[0][1] < -1e-6  # the centre of mass passes the edge after 2 s


def slab(friction, *, mirrored=False):
    """A slab on two feet at the height of its centre of mass, so that each foot carries half: on ice, then on rubber from x = 0 on."""
    ice, rubber = friction
    pieces = [ice, rubber]
    feet = [sf.Contact((x, 0.0)) for x in (-2.0, -1.0)]
    fields = {"terrain": [(-50, 0), (0, 0), (50, 0)], "terrain_friction": pieces}
    center = (-1.5, 0.0)
    if mirrored:
        feet = [sf.Contact((-contact.point[0], 0.0)) for contact in feet]
        fields["terrain_friction"] = pieces[::-1]
        center = (1.5, 0.0)
    return sf.Posture(1.0, 0.5, center, feet, 0.0, gravity=G, **fields)


@pytest.mark.parametrize("mirrored", [False, True])
def test_from_ice_to_rubber(mirrored):
    """v² falls by 2 μ g times the way, with the mean of both μ while the feet are on different ground."""
    ice, rubber, speed = 0.02, 0.6, 4.0
    way = -1.0 if mirrored else 1.0
    run = sf.simulate(
        slab((ice, rubber), mirrored=mirrored), (0, 0, 0), (way * speed, 0, 0)
    )
    square, time, v = speed**2, 0.0, speed
    # One metre on ice, one on both, the rest on rubber.
    for mu, length in ((ice, 1.0), ((ice + rubber) / 2, 1.0)):
        square -= 2 * mu * G * length
        time, v = time + (v - math.sqrt(square)) / (mu * G), math.sqrt(square)
    assert run.outcome == "rest"
    assert abs(run.q[0] - way * (2 + square / (2 * rubber * G))) < 1e-14
    assert abs(run.time - (time + v / (rubber * G))) < 1e-14


def test_each_piece_returns_its_share():
    """A ball flies from dead ground to lively ground: e of the piece where it has one, of the contact otherwise."""
    terrain, restitution = [(-9, 0), (0, 0), (9, 0)], [0.25, None]
    ball = sf.Posture(
        1.0,
        1.0,
        (-0.5, 0),
        [sf.Contact((-0.5, 0), restitution=0.75)],
        0.0,
        gravity=10.0,
        terrain=terrain,
        terrain_restitution=restitution,
    )
    run = sf.simulate(ball, (0, 5.0, 0), (1.0, 0, 0), time_limit=3.9)
    rates = run.impacts["rates_after"][:, 0] / -run.impacts["rates_before"][:, 0]
    # It lands after 1 s at x = 1/2, beyond the joint.
    np.testing.assert_allclose(rates, 0.75)
    left = sf.simulate(ball, (0, 5.0, 0), (0.1, 0, 0), time_limit=1.1)
    np.testing.assert_allclose(left.impacts["rates_after"][0], 2.5)


def test_discs_roll_over_a_joint():
    """A disc that slides on ice is caught by rubber, and rolls there."""
    disc = sf.Posture.disc(
        0.1, terrain=[(-50, 0), (1, 0), (50, 0)], terrain_friction=[0.0, 0.5], gravity=G
    )
    run = sf.simulate(disc, (0, 0, 0), (2.0, 0, 0), time_limit=10.0)
    assert run.phases[-1].mode == "F"
    np.testing.assert_allclose(
        run.qdot, [4 / 3, 0, -4 / 3 / 0.1], rtol=1e-13, atol=1e-15
    )


def test_a_joint_without_a_change_changes_nothing():
    """Two materials that are one, over a slope, and a piece that says what the contacts say."""
    slope = [(-3.0, 0.9), (0.0, 0.0), (3.0, -0.9)]
    feet = [sf.Contact((x, -0.3 * x), friction=0.2) for x in (-0.6, -0.2)]
    fields = {
        "mass": 1.0,
        "gyration_radius": 0.3,
        "center_of_mass": (-0.4, 0.4),
        "contacts": feet,
        "restitution": 0.3,
    }
    plain = sf.Posture(**fields, terrain=slope)
    parts = sf.Posture(**fields, terrain=slope, terrain_friction=[0.2, None])
    runs = [
        sf.simulate(body, (0, 0.1, 0.05), time_limit=1.5) for body in (plain, parts)
    ]
    np.testing.assert_allclose(runs[1].q, runs[0].q, rtol=0, atol=1e-13)


def test_verdicts_take_the_ground_and_refuse_belts():
    terrain = [(-5, 0), (0, 0), (5, 0)]
    feet = [sf.Contact((x, 0.0)) for x in (-0.5, 0.5)]
    fields = {
        "mass": 1.0,
        "gyration_radius": 0.4,
        "center_of_mass": (0, 0.2),
        "contacts": feet,
        "restitution": 0.1,
    }
    on_rubber = sf.Posture(**fields, terrain=terrain, terrain_friction=[0.5, 0.6])
    rough = [
        sf.Contact((-0.5, 0.0), friction=0.5),
        sf.Contact((0.5, 0.0), friction=0.6),
    ]
    same = sf.Posture(**{**fields, "contacts": rough}, terrain=terrain)
    verdicts = [sf.stability(body) for body in (on_rubber, same)]
    assert [v.frictional_stability for v in verdicts] == ["stable"] * 2
    assert verdicts[0].by == verdicts[1].by
    assert (
        sf.stability(sf.Posture(**fields, terrain=terrain)).frictional_stability
        != "stable"
    )
    assert sf.friction_margin(on_rubber) == sf.friction_margin(same)
    belt = sf.Posture(
        **fields, terrain=terrain, terrain_friction=[0.5, 0.6], terrain_speed=[0, 1]
    )
    for question in (
        sf.stability,
        sf.Mechanism.of_posture,
        lambda body: sf.smallest_push(body),
    ):
        with pytest.raises(
            ValueError, match=r"terrain_speed\.2 = 1\.0 cannot be used: 0 for statics"
        ):
            question(belt)
    assert sf.equilibrium_region(belt) is None
    assert list(sf.contact_modes(belt).consistent) == [
        "RL"
    ]  # the belt pulls with 3/10 m g, the other holds 1/4


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        (
            {"terrain_friction": [0.5]},
            r"terrain_friction = \[1 entries\] .* one for each of the 2 pieces",
        ),
        ({"terrain_friction": [0.5, -1]}, "terrain_friction.2 = -1.0 is outside"),
        ({"terrain_restitution": [0.5, 2]}, "terrain_restitution.2 = 2.0 is outside"),
        ({"terrain_speed": [math.inf, 0]}, "terrain_speed.1 = inf is outside"),
        (
            {"terrain": None, "terrain_speed": [1]},
            r"terrain_speed = \[1 entries\] .* None without a terrain",
        ),
        (
            {"terrain": [(-5, 1), (0, 0), (5, 0)], "terrain_speed": [0, 1]},
            "terrain_speed.2 = 1.0 .* 0 beside the concave vertex 2",
        ),
    ],
)
def test_wrong_surfaces_are_named(fields, text):
    whole = {"terrain": [(-5, 0), (0, 0), (5, 0)], **fields}
    with pytest.raises(ValueError, match=text):
        sf.Posture(1.0, 0.4, (0, 0.5), [sf.Contact((1, 0), friction=0.5)], 0.0, **whole)


def test_a_contact_has_no_speed_of_its_own_on_a_terrain():
    foot = sf.Contact((1, 0), friction=0.5, surface_speed=1.0)
    with pytest.raises(
        ValueError, match=r"contacts.1.surface_speed = 1.0 .* 0 on a terrain"
    ):
        sf.Posture(1.0, 0.4, (0, 0.5), [foot], 0.0, terrain=[(-5, 0), (5, 0)])
    with pytest.raises(ValueError, match=r"contacts.2.surface_speed = 0\.0"):
        sf.Posture(1.0, 0.4, (0, 0.5), [foot, sf.Contact((0, 0))], 0.0, ground="shared")
    own = sf.Posture(1.0, 0.4, (0, 0.5), [foot], 0.0)
    with pytest.raises(ValueError, match="surface_speed"):
        sf.simulate(own, model="local")


def test_surfaces_survive_files_and_pickles(tmp_path):
    fields = {
        "terrain": [(-5, 0), (0, 0), (5, 0)],
        "terrain_friction": [0.5, None],
        "terrain_speed": [None, 2.0],
    }
    body = sf.Posture(
        1.0, 0.4, (0, 0.5), [sf.Contact((1, 0), friction=0.5)], 0.0, **fields
    )
    assert pickle.loads(pickle.dumps(body)) == body
    assert eval(repr(body), {"Posture": sf.Posture, "Contact": sf.Contact}) == body
    foot = sf.Contact((0, 0), friction=1.0, surface_speed=-1.5)
    assert pickle.loads(pickle.dumps(foot)) == foot
    assert eval(repr(foot), {"Contact": sf.Contact}) == foot
    for suffix in ("toml", "json"):
        path = tmp_path / f"belt.{suffix}"
        sf.Scene(body, q=(0, 0.1, 0)).save(path)
        assert sf.load(path).posture == body
    written = json.loads((tmp_path / "belt.json").read_text())
    assert written["surfaces"] == [{"friction": 0.5}, {"speed": 2.0}]
    assert body.terrain_friction == [0.5, None]
    assert body.terrain_restitution is None
    assert body.terrain_speed == [None, 2.0]
