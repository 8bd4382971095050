"""How hard a posture may be kicked: closed forms, single runs, the same bits everywhere, and messages."""

import json
import math
import pickle
import re
import signal
import threading
import time

import matplotlib as mpl
import numpy as np
import pytest
import standfast as sf
from matplotlib import pyplot as plt
from standfast.cli import main

mpl.use("agg")

FEET = [sf.Contact((x, 0), friction=0.5) for x in (-1, 1)]
STANDING = sf.Posture(1, 0.4, (0.1, 0.2), FEET, 0.1)
BOX = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)


def test_small_kicks_leave_a_stable_posture_standing():
    assert sf.stability(STANDING).frictional_stability == "stable"
    sizes = [1e-4, 1e-3, 1e-2]
    result = sf.robustness(STANDING, sizes, trials=300)
    assert result.share.tolist() == [1, 1, 1]
    assert result.rest.tolist() == [300, 300, 300]
    assert result.contacts == [1, 2]
    # Displacements of small kicks grow with the square of their size.
    ratios = result.largest_displacement[1:] / result.largest_displacement[:-1]
    assert ratios == pytest.approx([100, 100], rel=0.1)


def test_without_friction_nothing_stops_a_body_on_a_floor():
    skate = STANDING.replace(friction=0.0)
    result = sf.robustness(skate, [0.1], trials=100)
    assert result.share.tolist() == [0]
    assert {name: n.tolist() for name, n in result.outcomes.items()} == {
        "sliding": [100]
    }
    assert math.isnan(result.largest_displacement[0])
    assert result.interval[0, 0] == 0


class Block:
    """A slender block without rebound: each corner that is hit sticks, so that the block turns about it.

    A corner at the arm r from the centre of mass keeps the angular momentum about it, ω⁺ = (ρ²ω + r × v)/(ρ² + r²), and the block
    topples over it if its energy then lifts the centre of mass over the corner (Housner 1963).
    """

    b, h, g, friction = 0.25, 0.75, 9.81, 2.0

    def __init__(self):
        self.posture = sf.Posture.box(2 * self.b, 2 * self.h, friction=self.friction)
        self.r2 = self.b**2 + self.h**2
        self.rho2 = self.r2 / 3
        #: The least spin about a corner that topples the block.
        lift = self.g * (math.sqrt(self.r2) - self.h)
        self.topples = math.sqrt(2 * lift / (self.rho2 + self.r2))

    def hit(self, x, v, omega):
        """Velocities after an impact of the corner at (x, 0) that sticks, below the centre of mass; None if it slips."""
        r = np.array([-x, self.h])
        spin = (self.rho2 * omega + r[0] * v[1] - r[1] * v[0]) / (self.rho2 + self.r2)
        after = np.array([-spin * r[1], spin * r[0]])
        impulse = after - v
        sticks = abs(impulse[0]) < self.friction * impulse[1]
        return (after, spin) if sticks else None

    def spin(self, direction):
        """The spin about the corner on which a kick of size 1 in this direction leaves the block; None if the block flies or slips."""
        v, omega = direction[:2], direction[2] / math.sqrt(self.rho2)
        corners, on = (-self.b, self.b), None
        for _ in range(4):
            coming = [x for x in corners if v[1] + omega * x < -1e-12]
            if not coming:
                return None if on is None else omega
            on = coming[0]
            after = self.hit(on, v, omega)
            if after is None:
                return None
            v, omega = after
        return None


def test_a_block_topples_where_its_energy_lifts_it_over_a_corner():
    block = Block()
    sizes = [0.2, 0.5, 0.8, 1.2, 2.0]
    laws = {"impact": "moreau", "simultaneous": "first-contact-first"}
    result = sf.robustness(block.posture, sizes, trials=200, **laws)
    spins = [block.spin(kick) for kick in result.kicks]
    known = [k for k, spin in enumerate(spins) if spin is not None]
    assert len(known) > 60
    stays = [[abs(s * spins[k]) < block.topples for k in known] for s in sizes]
    assert result.returned[:, known].tolist() == stays
    # Some sizes are near no threshold; all others have blocks of both kinds.
    shares = np.mean(stays, axis=1)
    assert shares[0] == 1
    assert 0.1 < shares[-1] < shares[-2] < 1


@pytest.mark.parametrize("seed", range(12))
def test_the_size_that_topples_a_block_has_a_closed_form(seed):
    block = Block()
    laws = {"impact": "moreau", "simultaneous": "first-contact-first"}
    (kick,) = sf.robustness(block.posture, [0.1], 1, seed, **laws).kicks
    spin = block.spin(kick)
    least = 1.0 if spin is None else block.topples / abs(spin)
    # Below and above by a thousandth. Kicks of more than 5 m/s hurl the block up.
    sizes = [0.999 * least, 1.001 * least]
    result = sf.robustness(block.posture, sizes, 1, seed, **laws)
    if spin is not None and least < 5:
        assert result.share.tolist() == [1, 0]


def came_back(run, stance, neighbourhood=math.inf):
    """The definition, from a single run."""
    return (
        run.outcome == "rest"
        and [k for k, gap in enumerate(run.gaps) if gap == 0] == stance
        and abs(run.theta) < math.pi
        and math.hypot(*run.q[:2]) <= neighbourhood
    )


@pytest.mark.parametrize(
    ("posture", "options"),
    [
        (STANDING, {}),
        (STANDING, {"model": "local"}),
        (STANDING, {"model": "auto"}),
        (BOX, {"impact": "moreau"}),
        (BOX, {"impact": "moreau", "neighbourhood": 0.2, "event_limit": 200}),
        (BOX, {"impact": "poisson", "time_limit": 0.5}),
    ],
)
def test_each_kick_is_a_run(posture, options):
    sizes = [0.3, 2.0]
    result = sf.robustness(posture, sizes, 25, 5, **options)
    weights = np.array([1, 1, posture.gyration_radius])
    for k, size in enumerate(sizes):
        moved, ends = [], []
        for j, kick in enumerate(result.kicks):
            assert (result.qdot[k, j] == size * kick / weights).all()
            keywords = {"model": "full", **options}
            run = sf.simulate(posture, (0, 0, 0), size * kick / weights, **keywords)
            ends.append(run.outcome)
            back = came_back(run, [0, 1], options.get("neighbourhood", math.inf))
            assert result.returned[k, j] == back
            if back:
                moved.append(np.linalg.norm(run.q * weights))
        assert result.share[k] == result.returned[k].mean()
        assert result.rest[k] == ends.count("rest")
        counts = {name: n[k] for name, n in result.outcomes.items() if n[k]}
        assert counts == {name: ends.count(name) for name in set(ends)}
        # The norm is a sum of three squares, rounded in another order.
        assert result.largest_displacement[k] == pytest.approx(
            max(moved, default=math.nan), rel=1e-14, nan_ok=True
        )


def test_a_start_with_the_velocity_is_a_kick_at_time_zero():
    """A kick as an impulse: of the velocity, at a point beside the centre of mass that gives the spin."""
    result = sf.robustness(BOX, [1.0], 20, impact="moreau")
    rho2 = BOX.gyration_radius**2
    for v, back in zip(result.qdot[0], result.returned[0], strict=True):
        along = v[:2] / (v[:2] @ v[:2])
        x, y = BOX.center_of_mass + rho2 * v[2] * np.array([along[1], -along[0]])
        kick = sf.Kick(0, BOX.mass * v[:2], (x, y))
        run = sf.simulate(
            BOX, (0, 0, 0), (0, 0, 0), model="full", impact="moreau", kicks=[kick]
        )
        assert came_back(run, [0, 1]) == back


def test_a_lower_step_and_a_somersault_are_not_back():
    step = [(-9, 0), (0.16, 0), (0.16, -0.02), (9, -0.02)]
    box = sf.Posture.box(0.3, 0.2, friction=0.8, terrain=step)
    result = sf.robustness(box, [2.0, 6.0], 300, impact="moreau")
    lower = turned = 0
    for k in range(2):
        runs = sf.simulate_many(
            box, (0, 0, 0), result.qdot[k], **{**result.options, "model": "full"}
        )
        x, y, theta = runs.q.T
        upright = (runs.outcome == "rest") & (np.abs(np.sin(theta / 2)) < 1e-9)
        below = upright & (np.abs(theta) < 1) & (y < -0.01)
        # Farther to the right it stands on the edge of the step, and no more on its right corner.
        whole = x <= 0.16 - 0.15
        above = upright & (np.abs(theta) < 1) & (np.abs(y) < 1e-9) & whole
        around = upright & (np.abs(theta) > 1)
        lower, turned = lower + below.sum(), turned + around.sum()
        assert not result.returned[k][below | around].any()
        assert result.returned[k][above].all()
        assert (result.returned[k] <= above).all()
    assert lower > 0
    assert turned > 0


def test_three_feet_on_uneven_ground_need_not_touch_together_again():
    """Three lines touch three feet in one placement only. Friction stops the body beside it, on two feet."""
    feet = [(-0.5, 0, -0.3), (0, 0.1, 0.1), (0.5, 0.05, 0.4)]
    contacts = [sf.Contact((x, y), slope, friction=0.6) for x, y, slope in feet]
    crab = sf.Posture(5, 0.4, (0, 0.3), contacts, 0.2)
    result = sf.robustness(crab, [0.01, 0.1, 3.0], 100)
    assert result.share[:2].tolist() == [1, 1]
    assert 0 < result.largest_displacement[0] < 1e-3
    size = max(math.hypot(x, y - 0.3) for x, y, _ in feet)
    hovering = 0
    for k in range(3):
        runs = sf.simulate_many(crab, (0, 0, 0), result.qdot[k], **result.options)
        gaps = crab.gaps(runs.q)
        near = (runs.outcome == "rest") & (gaps < 0.1 * size).all(axis=1)
        near &= np.abs(runs.q[:, 2]) < math.pi
        assert (result.returned[k] == near).all()
        hovering += (gaps[near].max(axis=1) > 1e-9).sum()
    assert hovering > 100


def test_the_same_kicks_for_every_size_and_on_every_machine():
    few = sf.robustness(STANDING, [0.5], 10, 1)
    many = sf.robustness(STANDING, [0.1, 0.5], 40, 1)
    assert (few.kicks == many.kicks[:10]).all()
    assert (few.returned[0] == many.returned[1][:10]).all()
    assert np.linalg.norm(many.kicks, axis=1) == pytest.approx(1, abs=1e-15)
    assert not (sf.robustness(STANDING, [0.5], 10, 2).kicks == few.kicks).any()


def marsaglia(seed, count):
    """Directions by SplitMix64 and the method of Marsaglia (1972), with integers of any length."""
    mask, found = 2**64 - 1, []

    def uniform():
        nonlocal seed
        seed = (seed + 0x9E3779B97F4A7C15) & mask
        z = seed
        z = ((z ^ z >> 30) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ z >> 27) * 0x94D049BB133111EB) & mask
        return 2 * ((z ^ z >> 31) >> 11) / 2**53 - 1

    while len(found) < count:
        u, v = uniform(), uniform()
        s = u * u + v * v
        if s < 1:
            root = 2 * math.sqrt(1 - s)
            found.append([u * root, v * root, 1 - 2 * s])
    return found


def test_the_directions_follow_from_the_seed():
    kicks = sf.robustness(STANDING, [0.1], 50, 2024).kicks
    # −1 + 2x is rounded where 2x − 1 is: both are sums of the same terms.
    assert kicks.tolist() == marsaglia(2024, 50)


def test_threads_leave_no_trace():
    one, two, seven = (
        sf.robustness(BOX, [0.9, 1.5], 150, impact="moreau", threads=threads)
        for threads in (1, 2, 7)
    )
    assert one == two == seven
    assert one.largest_displacement.tobytes() == two.largest_displacement.tobytes()
    assert one.share.tobytes() == seven.share.tobytes()
    assert one != sf.robustness(BOX, [0.9, 1.5], 150, 1, impact="moreau")


def test_a_result_can_be_pickled_and_written(tmp_path):
    result = sf.robustness(BOX, [0.9, 1.5], 30, 4, impact="moreau", time_limit=5)
    again = pickle.loads(pickle.dumps(result))
    assert again == result
    assert again.options == result.options
    written = result.to_dict()
    assert [level["share"] for level in written["levels"]] == result.share.tolist()
    assert (written["trials"], written["seed"]) == (30, 4)
    result.to_json(tmp_path / "robustness.json")
    text = (tmp_path / "robustness.json").read_text(encoding="utf-8")
    assert json.loads(text) == written
    weightless = STANDING.replace(gravity=0.0)
    nothing = sf.robustness(weightless, [0.1], 3).to_dict()["levels"][0]
    assert nothing["relative_size"] == "inf"


def test_relative_sizes():
    result = sf.robustness(BOX, [0.1, 0.2], 1)
    size = math.hypot(0.15, 0.25)
    assert result.relative_sizes == pytest.approx(result.sizes / math.sqrt(9.81 * size))


def test_the_interval_is_that_of_wilson():
    """Its ends p solve (p̂ − p)² = z² p(1 − p)/n."""
    result = sf.robustness(BOX, [0.1, 1.2, 3.0], 60, impact="moreau")
    assert result.share[0] == 1
    assert 0 < result.share[1] < 1
    for share, ends in zip(result.share, result.interval, strict=True):
        assert ends[0] <= share <= ends[1]
        for p in ends:
            assert (share - p) ** 2 == pytest.approx(
                1.959963984540054**2 * p * (1 - p) / 60, abs=1e-14
            )


def test_a_map_has_the_shares_of_single_postures():
    over = {"friction": [0.2, 0.6], "restitution": [0.0, 0.4, 0.5]}
    sizes, options = [0.8, 1.5], {"impact": "moreau", "seed": 3}
    grid = sf.robustness(BOX, sizes, 20, over=over, **options)
    assert dict(grid.sizes) == {"friction": 2, "restitution": 3, "size": 2}
    for mu in over["friction"]:
        for e in over["restitution"]:
            here = grid.sel(friction=mu, restitution=e)
            posture = BOX.replace(friction=mu, restitution=e)
            one = sf.robustness(posture, sizes, 20, **options)
            assert (here["share"].values == one.share).all()
            moved = here["largest_displacement"].values
            assert np.array_equal(moved, one.largest_displacement, equal_nan=True)
    assert grid.attrs["trials"] == 20
    assert grid["size"].attrs["units"] == "m/s"
    figure = sf.plot_map(grid[["share"]].isel(restitution=0))
    assert "size of the kick / m/s" in {ax.get_ylabel() for ax in figure.axes}


def test_progress_counts_the_kicks(capsys):
    sf.robustness(STANDING, [0.1, 0.2], 50, progress=True)
    assert "100/100" in capsys.readouterr().err
    sf.robustness(STANDING, [0.1], 10, over={"mass": [1.0, 2.0]}, progress=True)
    assert "20.0/20.0" in capsys.readouterr().err
    sf.robustness(STANDING, [0.1], 10, progress=False)
    assert not capsys.readouterr().err


def test_a_picture(tmp_path):
    result = sf.robustness(BOX, [3.0, 0.1, 1.0], 40, impact="moreau")
    figure = result.plot(tmp_path / "robustness.png")
    (axes,) = figure.axes
    assert axes.get_xscale() == "log"
    assert "m/s" in axes.get_xlabel()
    line = axes.lines[0].get_xydata()
    assert line[:, 0].tolist() == [0.1, 1.0, 3.0]
    assert line[:, 1].tolist() == sorted(result.share.tolist(), reverse=True)
    assert (tmp_path / "robustness.png").read_bytes().startswith(b"\x89PNG")
    mine, ax = plt.subplots()
    assert result.plot(ax=ax) is ax
    plt.close(mine)
    with pytest.raises(ValueError, match=r"path = 'x\.png' cannot be used"):
        result.plot("x.png", ax=ax)


def test_texts():
    result = sf.robustness(BOX, [0.1, 3.0], 40, impact="moreau", time_limit=2)
    assert repr(result).startswith("<Robustness: 40 kicks of each size; back from 40")
    assert "contacts 1 and 2" in str(result)
    assert len(str(result).splitlines()) == 5
    assert repr(sf.robustness(STANDING, 0.1 * np.ones(1), 3)) == (
        "<Robustness: 3 kicks; back from 3 at 0.1 m/s>"
    )


@pytest.mark.parametrize(
    ("keywords", "kind", "message"),
    [
        ({"sizes": []}, ValueError, "sizes = [] cannot be used: at least one size"),
        ({"sizes": [1, -0.5]}, ValueError, "sizes.2 = -0.5 is outside its range"),
        (
            {"sizes": [0]},
            ValueError,
            "sizes.1 = 0.0 is outside its range: finite and >",
        ),
        ({"sizes": [math.nan]}, ValueError, "sizes.1 = NaN is outside its range"),
        ({"sizes": [math.inf]}, ValueError, "sizes.1 = inf is outside its range"),
        ({"sizes": [[1]]}, ValueError, "sizes = array of shape [1, 1] cannot be used"),
        ({"sizes": "x"}, TypeError, "sizes = 'x' cannot be used"),
        ({"trials": 0}, ValueError, "trials = 0 cannot be used: from 1 to 100000000"),
        ({"trials": -1}, ValueError, "trials = -1 cannot be used"),
        ({"trials": 2.5}, TypeError, "trials = 2.5 cannot be used"),
        (
            {"trials": 10**9},
            ValueError,
            "trials = 1000000000 cannot be used: an integer from 0 to 100000000",
        ),
        ({"seed": -1}, ValueError, "seed = -1 cannot be used"),
        ({"model": "exact"}, ValueError, "model = "),
        ({"threads": 0}, ValueError, "threads = 0 cannot be used"),
        ({"progress": 1}, TypeError, "progress = 1 cannot be used"),
        ({"impakt": "moreau"}, TypeError, "did you mean 'impact'?"),
        ({"stop": "zeno"}, TypeError, "unexpected keyword argument 'stop'"),
        ({"neighbourhood": 0}, ValueError, "neighbourhood = 0.0 is outside its range"),
        ({"sizes": [1e-200]}, ValueError, "(at kick 0 of 1e-200 m/s)"),
        ({"over": 3}, TypeError, "over = 3 cannot be used"),
        ({"over": {}}, ValueError, "over = {} cannot be used"),
        ({"over": {"colour": [1]}}, ValueError, "the parameters are mass"),
        ({"over": {"mass": [1, -2]}}, ValueError, "mass = -2.0 is outside its range"),
    ],
)
def test_wrong_questions_are_named(keywords, kind, message):
    asked = {"sizes": [0.1], "trials": 3, **keywords}
    with pytest.raises(kind, match=re.escape(message)):
        sf.robustness(STANDING, **asked)


def test_a_point_of_a_map_without_an_answer_is_named():
    with pytest.raises(ValueError, match=r"\(at gyration_radius = 1e-05\)"):
        sf.robustness(STANDING, [0.1], 3, over={"gyration_radius": [0.4, 1e-5]})


def test_a_body_in_the_air_has_no_stance():
    air = sf.Posture.box(1, 1, terrain=[(-2, -1), (2, -1)])
    with pytest.raises(ValueError, match="no contact touches the ground at q = 0"):
        sf.robustness(air, [0.1])


def test_a_body_that_rests_beyond_the_neighbourhood_is_not_back():
    free = sf.robustness(STANDING, [1.0], 60)
    far = free.largest_displacement[0]
    assert free.share[0] == 1
    near = sf.robustness(STANDING, [1.0], 60, neighbourhood=far / 3)
    assert 0 < near.share[0] < 1
    assert near.largest_displacement[0] <= far / 3 + STANDING.gyration_radius * math.pi


def test_a_long_computation_can_be_interrupted():
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        sf.robustness(BOX, [1.0], 1_000_000, impact="moreau")
    assert time.monotonic() - start < 30
    timer.join()


SCENE = """
gravity = 9.81
restitution = 0.1
[body]
mass = 1.0
gyration_radius = 0.4
center_of_mass = [0.1, 0.2]
[[contact]]
point = [-1.0, 0.0]
friction = 0.5
[[contact]]
point = [1.0, 0.0]
friction = 0.5
[start]
q = [0.0, 1.0, 0.0]
qdot = [0.0, 0.0, 0.0]
[run]
impact = "moreau"
"""


def test_the_command_prints_writes_and_draws(tmp_path, capsys):
    scene = tmp_path / "standing.toml"
    scene.write_text(SCENE, encoding="utf-8")
    out, picture = tmp_path / "out.json", tmp_path / "out.png"
    words = ["robustness", str(scene), "--sizes", "0.1,2", "--trials", "30"]
    written = ["--seed", "2", "--json", str(out), "--plot", str(picture)]
    assert main([*words, *written]) == 0
    result = sf.robustness(STANDING, [0.1, 2.0], 30, 2, impact="moreau")
    said = capsys.readouterr().out
    assert str(result) in said
    assert json.loads(out.read_text(encoding="utf-8")) == result.to_dict()
    assert picture.read_bytes().startswith(b"\x89PNG")
    for wrong, problem in (
        (["--sizes", "0.1", "--trials", "0"], "--trials: trials = 0 cannot be used"),
        (["--sizes", "0.1,-1"], "--sizes: sizes.2 = -1.0 is outside its range"),
        (["--sizes", "fast"], "'fast' is not a number"),
        ([], "robustness needs --sizes SIZE,SIZE"),
    ):
        assert main(["robustness", str(scene), *wrong]) == 2
        assert problem in capsys.readouterr().err
