"""Every example runs and shows the intended mechanics."""

import importlib.util
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import standfast as sf

EXAMPLES = Path(__file__).parents[2] / "examples"
SCENES = sorted(path.name for path in EXAMPLES.glob("*.toml"))


def run_of(name, **override):
    return sf.load(EXAMPLES / name).simulate(**override)


def test_every_scene_is_judged_here():
    here = Path(__file__).read_text(encoding="utf-8")
    for name in SCENES:
        assert f'run_of("{name}"' in here, name


def at_ends(posture, q):
    """Which contacts are above an end of a piece of the terrain, (times, contacts)."""
    points = np.array([contact.point for contact in posture.contacts])
    arms = points - posture.center_of_mass
    cos, sin = np.cos(q[:, 2:]), np.sin(q[:, 2:])
    x = posture.center_of_mass[0] + q[:, :1] + cos * arms[:, 0] - sin * arms[:, 1]
    ends = np.array([x for x, _ in posture.terrain or []])
    return (np.abs(x[:, :, None] - ends) < 1e-14).any(axis=2)


@pytest.mark.parametrize("name", SCENES)
def test_no_scene_gains_energy_or_enters_the_terrain(name):
    run = run_of(name)
    t, q, qdot = run.sample(2000)
    gaps, rates = run.gaps_at(t), run.gap_rates_at(t)
    assert gaps.min() >= 0.0
    # The gaps of the run must agree with those of the body; they would not after a missed impact. After 1400 rad θ is rounded
    # to 2e-13 rad, which gives 2e-11 m/s at 100 rad/s, and 1e-10 m after some seconds.
    # At an end of a piece of ground a rounding error decides which piece is meant.
    there = ~at_ends(run.posture, q)
    own_gaps, own_rates = run.posture.gaps(q), run.posture.gap_rates(q, qdot)
    np.testing.assert_allclose(own_gaps[there], gaps[there], rtol=0, atol=1e-10)
    np.testing.assert_allclose(own_rates[there], rates[there], rtol=0, atol=1e-8)
    energy = run.energy(t)
    # Rounding error of the largest term of the energy at the start.
    scale = abs(energy).max()
    assert np.diff(energy).max() <= 1e-12 * scale


def test_clattering_rod():
    run = run_of("clattering_rod.toml")
    assert run.outcome == "rest"
    (zeno,) = run.zeno_points
    assert (zeno.kind, zeno.contacts, zeno.certified) == ("2-zeno", (1, 2), True)
    assert abs(zeno.time - 0.04778480706422020) <= 2 * math.ulp(0.0477848)
    assert len(run.impacts) <= 10
    assert run.time == zeno.time
    np.testing.assert_allclose(run.q, 0.0, atol=1e-15)


def test_bouncing_ball():
    run = run_of("bouncing_ball.toml")
    assert (run.outcome, run.model) == ("rest", "local")
    (zeno,) = run.zeno_points
    assert (zeno.kind, zeno.contact, zeno.certified) == ("1-zeno", 1, True)
    end = math.sqrt(2 / 9.81) * 1.7 / 0.3
    assert abs(zeno.time - end) <= 4 * math.ulp(end)
    # Between the impacts k and k + 1 the speed is e^k times the first one.
    first = math.sqrt(2 / 9.81)
    speed = 9.81 * first
    time = first
    for k in range(1, 20):
        time += 2 * 0.7**k * speed / 9.81
        gaps = run.gaps_at(time - 0.7**k * speed / 9.81)
        # The top of each arc is e^2k times the first height; the time has a few rounding errors.
        assert float(np.ravel(gaps)[0]) == pytest.approx(0.49**k, rel=1e-10)


def test_rocking_block():
    run = run_of("rocking_block.toml")
    assert run.outcome == "rest"
    assert run.time < 10.0
    np.testing.assert_allclose(run.q[1:], 0.0, atol=1e-12)
    assert sf.stability(run.posture).frictional_stability == "stable"
    # The block starts on its left corner and rotates about it until the right one lands. By the energy, ½(ρ² + ¼ + 9/16) ω² = g r_y,
    # and the right corner lands with 1 m · ω.
    start = run.zeno_points[0]
    assert (start.method, start.contact, start.time) == ("rest", 1, 0.0)
    first = run.impacts[0]
    speed = math.sqrt(2 * 9.81 * 0.08438459877846183 / (3.25 / 12 + 0.25 + 0.75**2))
    assert first["contact"] == 2
    assert first["rates_before"] == pytest.approx([0.0, -speed], rel=1e-13)
    assert first["rates_after"][1] == pytest.approx(0.5 * speed, rel=1e-13)


def test_v_terrain():
    run = run_of("v_terrain.toml")
    zeno = run.zeno_points[0]
    assert (zeno.kind, zeno.method, zeno.certified) == ("2-zeno", "clatter", True)
    np.testing.assert_array_equal(zeno.gaps, 0.0)
    np.testing.assert_array_equal(zeno.gap_rates, 0.0)
    # The velocity there: the velocity of the fall, projected on the only motion that keeps both contacts.
    impact = run.impacts[-1]
    _, velocity = run.at(impact["time"])
    left = zeno.elapsed - impact["elapsed"]
    posture = run.posture
    rates = [posture.gap_rates(zeno.q, direction) for direction in np.eye(3)]
    slide = np.cross(*np.transpose(rates))
    mass = np.array([1.0, 1.0, posture.gyration_radius**2])
    falling = velocity - np.array([0.0, 9.81 * left, 0.0])
    expected = slide * (slide @ (mass * falling)) / (slide @ (mass * slide))
    np.testing.assert_allclose(zeno.qdot, expected, atol=1e-9)
    assert [phase.mode for phase in run.phases] == ["SS", "RR", "FF"]
    assert run.outcome == "rest"


def test_stairs():
    run = run_of("stairs.toml")
    # The box falls from the upper level of the stairs to the floor and rests on one of its sides: θ is a multiple of π/2.
    assert run.outcome == "rest"
    assert run.q[1] == pytest.approx(-1.2, abs=1e-12)
    turns = run.q[2] / (0.5 * math.pi)
    assert turns == pytest.approx(round(turns), abs=1e-12)
    sides = run.posture.center_of_mass[0] + run.q[0] + np.array([-0.25, 0.25])
    assert sides.min() > 1.601
    # The first corner beyond the edge: from −0.75 m at 3 m/s, decelerated by μg.
    first = run.phases[1]
    assert (first.cause, first.contact, first.mode) == ("left-segment", 2, "RSSS")
    pull = 0.3 * 9.81
    assert first.start == pytest.approx((3 - math.sqrt(9 - 1.5 * pull)) / pull)


def test_table_edge():
    run = run_of("table_edge.toml")
    side = run.contacts[4]
    assert (side.kind, side.index, side.corner) == ("side", 0, (0.0, 0.0))
    modes = [phase.mode for phase in run.phases[:3]]
    assert modes == ["SSSSF", "SSSSR", "SSSSS"]
    # It turns about the edge: a rotation keeps its energy, with the arm (0.01, 0.25) m of the centre of mass.
    arm = np.array([0.01, 0.25])
    for t in np.linspace(0.1, run.phases[0].end, 5):
        q, qdot = run.at(t)
        c, s = math.cos(q[2]), math.sin(q[2])
        assert q[:2] + arm == pytest.approx([[c, -s], [s, c]] @ arm, abs=1e-12)
        inertia = run.posture.gyration_radius**2 + arm @ arm
        assert 0.5 * inertia * qdot[2] ** 2 == pytest.approx(-9.81 * q[1], abs=1e-12)
    assert run.outcome == "rest"
    assert run.q[1:] == pytest.approx([-2.0, -math.pi], abs=1e-12)


def test_fast_spin():
    run = run_of("fast_spin.toml")
    first = run.impacts[0]["time"]
    # The first touchdown: before it no end is below the floor.
    t = np.linspace(0.0, first, 1_000_001)[:-1]
    end = 0.5 * np.sin(300.0 * t)
    height = 2.0 - 0.5 * 9.81 * t**2
    assert (height - abs(end)).min() > 0.0
    assert 2.0 - 0.5 * 9.81 * first**2 == pytest.approx(
        abs(0.5 * math.sin(300.0 * first)), abs=1e-12
    )
    # Only impacts reduce its energy: the first one takes (1−e²)w²/(2D).
    w = run.impacts[0]["rates_before"].min()
    b = 0.5 * math.cos(300.0 * first)
    lost = (1 - 0.1**2) * w**2 / (2 * (1 + b**2 / 0.2**2))
    before, after = run.energy(np.array([0.0, first]))
    assert before - after == pytest.approx(lost, rel=1e-9)
    assert run.outcome == "rest"


def test_python_example():
    done = subprocess.run(
        [sys.executable, EXAMPLES / "clattering_rod.py"],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    lines = done.stdout.splitlines()
    assert lines[-1] == "outcome: rest"
    assert lines[-2] == "0.047784807064220 s: contacts (1, 2) are at rest (2-zeno)"
    assert lines[0].endswith("contact 1 hits the floor")
    assert done.stderr == ""


def test_the_overturning_spectrum_is_that_of_scipy():
    """At eight points as Housner's block of scipy; it has safe islands: a harder pulse that does not overturn."""
    pytest.importorskip("scipy")
    pytest.importorskip("matplotlib")
    path = EXAMPLES / "overturning_spectrum.py"
    spec = importlib.util.spec_from_file_location("overturning_spectrum", path)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    pulses, overturned = example.spectrum()
    for k in np.random.default_rng(3).choice(overturned.size, 8, replace=False):
        assert example.overturns(pulses[k]) == overturned.flat[k], k
    # Along an amplitude: over the frequencies it overturns up to the edge, but for islands.
    islands = [row for row in overturned if (np.diff(row.astype(int)) == 1).any()]
    assert len(islands) >= 3
    assert not overturned[0].any()
