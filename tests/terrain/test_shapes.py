"""Bodies of uniform density, ground that all contacts share, and postures made from others."""

import math
import os
from collections import Counter

import mpmath
import numpy as np
import pytest
import standfast as sf

REST = (0, 0, 0)
#: Number of random throws; `make long` has more.
THROWS = int(os.environ.get("STANDFAST_THROWS", "200"))


def test_a_rocking_block_in_three_lines():
    """Housner's factor of the angular velocity with ρ² = (w² + h²)/12 is 1 − (3/2) sin² α, tan α = w/h: 0.85."""
    block = sf.Posture.box(1, 3, friction=0.6)
    run = sf.simulate(block, block.touching(2, -0.1), REST, impact="moreau")
    rates = [run.at(i["time"] + 1e-9)[1][2] for i in run.impacts[:3]]
    before = [run.at(i["time"] - 1e-9)[1][2] for i in run.impacts[:3]]
    for after, was in zip(rates, before, strict=True):
        assert after / was == pytest.approx(0.85, abs=1e-7)
    assert run.outcome == "rest"
    assert run.q[1:] == pytest.approx((0, 0), abs=1e-9)


def quarter(top, rate):
    """Time and final ω of a block, 1 m wide and 3 m high, that turns on a corner from rest at the angle ``top`` to 0; or, without
    ``top``, the time from 0 with ω = ``rate`` to rest. (4/3) R² θ̈ = −g R sin(α − θ), tan α = 1/3, so that
    ω² = (3g/2R) (cos(α − top) − cos(α − θ))."""
    radius, alpha = mpmath.sqrt(10) / 2, mpmath.atan(mpmath.mpf(1) / 3)
    stiff = 3 * mpmath.mpf("9.81") / (2 * radius)
    if not top:
        top = alpha - mpmath.acos(mpmath.cos(alpha) + rate**2 / stiff)

    # θ = top (1 − s²): ω/s is smooth where the speed is zero.
    def speed_over_s(s):
        middle = alpha - top * (1 - s * s / 2)
        return mpmath.sqrt(
            2 * stiff * mpmath.sin(middle) * mpmath.sin(top * s * s / 2) / s**2
        )

    time = mpmath.quad(lambda s: 2 * top / speed_over_s(s), [0, 1])
    return time, speed_over_s(mpmath.mpf(1))


def test_the_block_of_housner_comes_to_rest():
    """From 5 degrees: after each impact it keeps 0.85 of ω, and swings up and down."""
    with mpmath.workdps(50):
        time, rate = quarter(mpmath.mpf(math.radians(5)), 0)
        for _ in range(160):
            rate *= mpmath.mpf("0.85")
            time += 2 * quarter(0, rate)[0]
        rest = float(time)
    assert rest == pytest.approx(4.209, abs=5e-4)
    block = sf.Posture.box(1, 3, friction=0.6)
    run = sf.simulate(block, block.touching(1, math.radians(5)), REST, impact="moreau")
    assert run.outcome == "rest"
    assert run.time == pytest.approx(rest, rel=1e-9)


def test_moments_of_polygons():
    right = sf.Posture.polygon([(0, 0), (3, 0), (0, 3)])
    assert right.center_of_mass == pytest.approx((1, 1))
    assert right.gyration_radius**2 == pytest.approx((3**2 + 3**2) / 18)
    box = sf.Posture.box(2, 5)
    far = [(1e8 + x, 1e8 + y) for x, y in ((-1, 0), (-1, 5), (1, 5), (1, 0))]
    same = sf.Posture.polygon(far)
    assert same.gyration_radius == pytest.approx(box.gyration_radius, rel=1e-15)
    assert np.subtract(same.center_of_mass, 1e8) == pytest.approx((0, 2.5), abs=1e-7)
    corner = sf.Posture.polygon([(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)])
    # Two rectangles: 2 × 1 at (1, 0.5) and 1 × 2 at (0.5, 2).
    x, y = (2 * 1 + 2 * 0.5) / 4, (2 * 0.5 + 2 * 2) / 4
    parts = ((1, 0.5, 2, 1), (0.5, 2, 1, 2))
    square = sum(
        w * h * ((w**2 + h**2) / 12 + (cx - x) ** 2 + (cy - y) ** 2)
        for cx, cy, w, h in parts
    )
    assert corner.center_of_mass == pytest.approx((x, y))
    assert corner.gyration_radius**2 == pytest.approx(square / 4)
    assert (1, 1) not in [k.point for k in corner.contacts]
    assert len(corner.contacts) == 5


@pytest.mark.parametrize(
    ("vertices", "text"),
    [
        ([(0, 0), (1, 0)], "vertices = .2 vertices."),
        ([(0, 0), (1, 0), (2, 0)], "meet"),
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "edges 1 and 3 meet"),
        ([(0, 0), (1, math.nan), (1, 0)], "vertices.2.y"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "meet"),
    ],
)
def test_a_wrong_polygon_is_named(vertices, text):
    with pytest.raises(ValueError, match=text):
        sf.Posture.polygon(vertices)


def test_thrown_boxes_end_on_a_side():
    """On one of four sides, at rest, with no corner below the ground."""
    rng = np.random.default_rng(1)
    outcomes = Counter()
    for _ in range(THROWS):
        box = sf.Posture.box(
            *rng.uniform(0.3, 2, 2),
            friction=rng.uniform(0.2, 1),
            restitution=rng.choice([0, rng.uniform(0, 0.7)]),
        )
        q = (0, 5, rng.uniform(-3, 3))
        qdot = rng.normal(size=3) * (2, 2, 4)
        law = str(rng.choice(["newton", "moreau", "poisson", "stronge"]))
        run = sf.simulate(box, q, qdot, impact=law, record=False)
        case = f"{box!r}, {q}, {qdot.tolist()}, {law}: {run}"
        assert run.outcome == "rest", case
        assert min(run.gaps) > -1e-12, case
        assert sum(gap < 1e-12 for gap in run.gaps) == 2, case
        side = run.q[2] / (math.pi / 2)
        assert side == pytest.approx(round(side), abs=1e-9), case
        outcomes[round(side) % 4] += 1
    print(outcomes)
    assert len(outcomes) == 4


def body(points, **options):
    contacts = [sf.Contact(p, slope=options.pop("slope", 0.0)) for p in points]
    return sf.Posture(
        mass=1,
        gyration_radius=1,
        center_of_mass=(0, 1),
        contacts=contacts,
        restitution=0,
        **options,
    )


def test_shared_ground():
    posture = body([(-1, 0), (1, 0.25), (0, 3)], ground="shared")
    assert posture.gaps(REST) == pytest.approx((0, 0.25, 3))
    assert posture.ground == "shared"
    assert "ground='shared'" in repr(posture)
    run = sf.simulate(posture, REST, REST)
    assert run.gaps[:2] == pytest.approx((0, 0), abs=1e-12)
    slanted = sf.Posture(
        mass=1,
        gyration_radius=1,
        center_of_mass=(0, 1),
        contacts=[sf.Contact((x, 0.5 * x), slope=math.atan(0.5)) for x in (-1, 1)],
        restitution=0,
        ground="shared",
    )
    assert slanted.gaps(REST) == pytest.approx((0, 0), abs=1e-15)


def test_shared_ground_in_files(tmp_path):
    scene = sf.Scene(sf.Posture.box(1, 2, friction=0.5), (0, 1, 0.3), REST)
    for name in ("box.toml", "box.json"):
        scene.save(tmp_path / name)
        assert sf.load(tmp_path / name) == scene


def test_wrong_shared_ground():
    with pytest.raises(
        ValueError, match=r"contacts\.2\.slope = 0\.1 .*because the ground is"
    ):
        sf.Posture(
            mass=1,
            gyration_radius=1,
            center_of_mass=(0, 1),
            contacts=[sf.Contact((0, 0)), sf.Contact((1, 0), slope=0.1)],
            restitution=0,
            ground="shared",
        )
    with pytest.raises(ValueError, match="ground"):
        body([(0, 0)], ground="mine")
    with pytest.raises(ValueError, match="left out where there is a terrain"):
        body([(0, 0)], ground="shared", terrain=[(-1, 0), (1, 0)])


def test_replace():
    posture = sf.Posture.box(1, 2, friction=0.5)
    other = posture.replace(
        restitution=0.25, **{"contacts.1.friction": 0.75, "mass": 3}
    )
    assert (other.restitution, other.mass) == (0.25, 3)
    assert [k.friction for k in other.contacts] == [0.75, 0.5, 0.5, 0.5]
    assert posture.restitution == 0
    with pytest.raises(ValueError, match="colour"):
        posture.replace(colour=1)
    with pytest.raises(ValueError, match="mass"):
        posture.replace(mass=-1)


def test_touching():
    block = sf.Posture.box(1, 3)
    for contact, theta in ((2, -0.1), (1, 0.4), (4, 3.0), (3, -3.0)):
        q = block.touching(contact, theta)
        assert (q[0], q[2]) == (0, theta)
        gaps = block.gaps(q)
        assert gaps[contact - 1] == pytest.approx(0, abs=1e-12)
        assert min(gaps) > -1e-12
    with pytest.raises(ValueError, match="contact 2 lies"):
        block.touching(1, -0.1)
    with pytest.raises(ValueError, match="from 1 to 4"):
        block.touching(5, 0)
    hill = sf.Posture.polygon(
        [(-1, 1), (1, 1), (0, 2)], terrain=[(-5, 0), (0, 1), (5, 0)]
    )
    q = hill.touching(1, 0.0)
    assert hill.gaps(q)[0] == pytest.approx(0, abs=1e-12)
