"""Films of runs, read back from their files and checked by the objects drawn."""

import json
import math
import os
import re
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import standfast as sf
from matplotlib.animation import FFMpegWriter
from PIL import Image
from standfast import film
from standfast.cli import main
from standfast.film import Film, impacts, readable

#: Number of the scenes that are written as .mp4, which takes a second each.
FILMS = int(os.environ.get("STANDFAST_FILMS", "2"))
EXAMPLES = Path(__file__).parents[2] / "examples"
BOX = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
REST = ((0, 0, 0), (0, 0, 0))


def example(name):
    return sf.load(EXAMPLES / f"{name}.toml").simulate()


def ball(**options):
    """It falls for 1 s; its impacts are 2, 1, 1/2, ... s before its Zeno point at 3 s."""
    foot = sf.Contact((0, 0))
    posture = sf.Posture(1, 0.4, (0, 0), [foot], restitution=0.5, gravity=10)
    return sf.simulate(posture, (0, 5, 0), (0, 0, 0), **options)


def kicked():
    kick = sf.Kick(0.2, (0.6, 0.3), (0, 0.5))
    return sf.simulate(BOX, *REST, kicks=[kick], impact="moreau")


def moved(**motion):
    ground = sf.GroundMotion(**motion)
    limits = {"stop": "time", "time_limit": 1.0}
    return sf.simulate(BOX, *REST, ground_motion=ground, impact="moreau", **limits)


def shaken():
    return moved(times=[0, 0.5], acceleration=[(8, 0), (-8, 0)])


def tilted():
    return moved(times=[0.2, 0.6], tilt=[0.3, 0.6])


def three_feet():
    feet = [sf.Contact((x, 0), friction=0.4) for x in (-0.5, 0.1, 0.6)]
    posture = sf.Posture(1, 0.3, (0, 0.5), feet, 0.3)
    return sf.simulate(posture, (0, 0.2, 0.1), (0.5, 0, 0), impact="moreau")


def local():
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    return sf.simulate(rod, (0, 0.01, 0.002), (0, 0, 0), model="local")


def sliding():
    feet = [
        sf.Contact((x, x * math.tan(0.5)), slope=0.5, friction=0.3) for x in (-0.3, 0.3)
    ]
    posture = sf.Posture(1, 0.3, (0, 0.4), feet, 0.2)
    return sf.simulate(posture, *REST, stop="time", time_limit=1.0)


def far():
    posture = sf.Posture(1, 0.1, (0, 0), [sf.Contact((0, 0), friction=0.2)], 0.5)
    return sf.simulate(posture, (0, 3, 0), (30, 0, 5), impact="moreau")


SCENES = {
    "rod": lambda: example("clattering_rod"),
    "stairs": lambda: example("stairs"),
    "rocking": lambda: example("rocking_block"),
    "ball": ball,
    "kicked": kicked,
    "shaken": shaken,
    "tilted": tilted,
    "three feet": three_feet,
    "local": local,
    "sliding": sliding,
    "far": far,
}


def lengths(path):
    """The durations of the frames of a GIF, in ms."""
    with Image.open(path) as picture:
        found = []
        for k in range(picture.n_frames):
            picture.seek(k)
            found.append(picture.info["duration"])
    return found


@pytest.mark.parametrize("clock", ["real", "zeno"])
@pytest.mark.parametrize("name", SCENES)
def test_a_film_has_the_frames_of_its_clock(tmp_path, name, clock):
    run = SCENES[name]()
    whole = float(run.film_time(run.time, clock=clock))
    speed = whole / 1.1  # a film of 1.1 s
    path = tmp_path / "film.gif"
    assert run.animate(path, 3, speed, clock) is None
    assert len(run.frame_times(3, speed, clock)) == 5
    # In hundredths of a second the ends of the frames are 33, 67, 100, 133 and 167.
    assert lengths(path) == [330, 340, 330, 330, 340]
    assert [entry.name for entry in tmp_path.iterdir()] == ["film.gif"]


@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="needs ffmpeg")
@pytest.mark.parametrize("name", list(SCENES)[:FILMS])
def test_an_mp4_is_written(tmp_path, name):
    run = SCENES[name]()
    path = tmp_path / "film.MP4"
    run.animate(str(path), fps=2, speed=max(run.elapsed, 1e-3))  # in a second
    content = path.read_bytes()
    assert content[4:8] == b"ftyp"
    assert b"avc1" in content


@pytest.mark.parametrize("name", SCENES)
def test_a_page_holds_the_film(tmp_path, name):
    run = SCENES[name]()
    path = tmp_path / "film.html"
    run.animate(path, clock="zeno", speed=2.0)
    content = path.read_text(encoding="utf-8")
    (line,) = [line for line in content.splitlines() if line.startswith("play(root, ")]
    film, end = json.JSONDecoder().raw_decode(line.removeprefix("play(root, "))
    assert film == run.film()
    assert '"clock": "zeno", "speed": 2.0' in line[end:]
    # Nothing is loaded from elsewhere.
    assert not re.search(r"""(src|href)=["']?(?!data:)[a-z]+:|@import|url\(""", content)


def test_frame_times_of_a_ball():
    run = ball()
    np.testing.assert_allclose(
        run.frame_times(2), [0, 0.5, 1, 1.5, 2, 2.5, 3], atol=1e-15
    )
    np.testing.assert_allclose(run.frame_times(1, speed=1.5), [0, 1.5, 3], atol=1e-15)
    left = 3 - run.frame_times(fps=4, speed=2, clock="zeno")
    # Half a decade from frame to frame; the touch is 1e-12 of 0.4 m, and its fall takes sqrt(8e-14) s.
    frames = math.ceil(2 * math.log10(3 / math.sqrt(8e-14)))
    assert len(left) == frames + 1
    assert left[-1] == 0.0
    # Rounding of 3 s relative to the time left.
    ideal = 3 * 10 ** (-0.5 * np.arange(frames))
    np.testing.assert_allclose(left[:-1], ideal, atol=1e-15 * 3)
    before = run.film_time([1, 2, 2.5, 2.75], clock="zeno")
    np.testing.assert_allclose(np.diff(before), math.log10(2), rtol=1e-12)
    np.testing.assert_allclose(run.film_time(2.0, speed=4.0), 0.5, rtol=1e-15)


def test_the_gap_curve_and_the_picture_agree():
    run = ball()
    shown = Film(run, 10, 1.0, "zeno")
    (line,) = (x for x in shown.curves.lines if len(x.get_xdata()) > 100)
    x, gap = line.get_data()
    for k in (3, 17, 40, 52):
        shown.update(k)
        (at,), (height,) = shown.dots[0].get_data()
        assert at == pytest.approx(k / 10, abs=1e-6)
        assert list(shown.cursor.get_xdata()) == [at, at]
        (_, y) = shown.feet[0].get_data()
        assert height == run.gaps_at(shown.t[k])[0]
        assert y[0] == pytest.approx(height, rel=1e-12, abs=1e-15)  # rounding of 5 m
        near = np.interp(at, x, gap)  # between neighbouring samples of the curve
        assert near == pytest.approx(height, rel=0.05)
        left = 3.0 - shown.t[k]
        assert (
            shown.left.get_text() == f"{left:#.2g} s before the Zeno point of contact 1"
        )
    shown.update(len(shown.t) - 1)
    assert shown.left.get_text() == "at the Zeno point of contact 1"
    assert shown.curves.get_yscale() == "log"
    assert Film(run, 2, 1.0, "real").curves.get_yscale() == "linear"


def test_summed_impacts_flash():
    run = ball()
    assert len(run.impacts) < 5  # the others are summed
    shown = Film(run, 30, 1.0, "zeno")
    times, _ = shown.hits[0]
    expected = run.film_time(3 - 2.0 ** (1 - np.arange(15)), clock="zeno")
    for time in expected:
        assert abs(times - time).min() < 1e-4
    shown.update(math.ceil(30 * expected[9]))
    assert shown.rings[0].get_visible()
    first = Film(run, 30, 1.0, "real")
    first.update(10)  # still falling
    assert not first.rings[0].get_visible()


def test_forces_are_in_their_cones_and_modes_at_their_contacts():
    run = sliding()
    shown = Film(run, 10, 1.0, "real")
    shown.update(5)
    for arrow, cone, letter, force in zip(
        shown.arrows, shown.cones, shown.letters, shown.forces[5], strict=True
    ):
        assert letter.get_text() == "L"
        tail, head = np.array(arrow._posA_posB)
        size = math.hypot(*(head - tail)) / shown.reach
        assert size == pytest.approx(math.hypot(*force) / 9.81)  # of the weight
        assert cone.r == shown.reach
        turn = math.degrees(math.atan2(*(head - tail)[::-1]))
        # It slides down: the force is on an edge of the cone.
        assert turn == pytest.approx(cone.theta1, abs=1e-6)
        half = math.degrees(math.atan(0.3))
        assert cone.theta2 - cone.theta1 == pytest.approx(2 * half)


def test_the_weight_is_well_visible_and_longer_forces_are_cut_off():
    """A kick that presses on the ground for a short time would make all other arrows too short to be seen."""
    push = sf.Force(0.1, 0.12, (0, -1000))
    run = sf.simulate(BOX, *REST, forces=[push], stop="time", time_limit=0.3)
    shown = Film(run, 100, 1.0, "real")
    side = min(shown.view.high - shown.view.low)
    assert shown.reach >= 0.16 * side
    assert shown.largest > 400.0
    lengths = {0.045: 0.5, 0.105: 3.0}  # in lengths of the weight; both feet carry half
    for time, expected in lengths.items():
        k = int(np.searchsorted(shown.t, time))
        shown.update(k)
        tail, head = np.array(shown.arrows[0]._posA_posB)
        assert math.hypot(*(head - tail)) == pytest.approx(expected * shown.reach)
    assert any("cut off at 29.4 N" in label for label in shown.entries)


def test_the_magnified_rod_moves_as_its_gaps_do():
    run = example("clattering_rod")
    shown = Film(run, 12, 1.0, "zeno")
    seen = []
    for k in range(10, 50):
        shown.update(k)
        assert shown.ghost[0].get_visible()
        outline, feet = (line.get_xydata() for line in shown.ghost)
        assert outline[:, 1].min() >= -1e-12
        _, factor = shown._magnified(k, shown.view.poses[k].center)
        assert "times as large" in shown.caption.get_text()
        gaps = shown.gaps[k]
        np.testing.assert_allclose(feet[:, 1], factor * gaps, rtol=1e-6, atol=1e-12)
        seen.append(feet[:, 1] / shown.size)
    # Each end comes up so far that it can be seen, and down to the ground.
    assert (np.max(seen, axis=0) > 0.4 * film.LIFTED).all()
    assert np.max(seen) <= film.LIFTED * (1 + 1e-9)
    assert (np.min(seen, axis=0) < 0.02).all()
    real = Film(run, 12, 0.01, "real")
    assert not real.ghost[0].get_visible()


def test_a_panel_with_nothing_to_show_is_left_out(tmp_path):
    disc = sf.Posture.disc(0.1, friction=0.3)
    rolls = {"stop": "time", "time_limit": 1.2}
    for height, panels in ((0.0, 1), (0.1, 2)):
        run = sf.simulate(disc, (0, height, 0), (1.0, 0, 40), **rolls)
        shown = Film(run, 3, 1.0, "real")
        assert len(shown.figure.axes) == panels
        assert (shown.curves is None) == (panels == 1)
        run.animate(tmp_path / "film.gif", fps=3)
        labels = [axes.get_ylabel() for axes in run.plot().axes]
        assert ("gap / m" in labels) == (panels == 2)
        assert labels[-1] == "force / N"


def test_a_force_in_flight_is_not_drawn():
    shown = Film(ball(), 2, 1.0, "real")
    shown.update(1)
    assert not shown.arrows[0].get_visible()
    assert shown.letters[0].get_text() == ""


def test_kicks_and_the_motion_of_the_ground_are_shown():
    shown = Film(kicked(), 20, 1.0, "real")
    seen = []
    for k in range(20):
        shown.update(k)
        seen.append(shown.kicked[0][2].get_visible())
    assert seen == [0.2 <= k / 20 < 0.7 for k in range(20)]
    for run, words in (
        (shaken(), "acceleration of the ground 8 m/s²"),
        (tilted(), "gravity, the ground tilted by 0.3 rad"),
    ):
        shown = Film(run, 10, 1.0, "real")
        shown.update(4)
        assert shown.shaking.get_text() == words
        assert shown.shaken.get_visible()


@pytest.mark.parametrize("name", SCENES)
def test_the_body_stays_in_the_picture(name):
    run = SCENES[name]()
    shown = Film(run, 10, float(run.film_time(run.time)), "real")
    for k in range(len(shown.t)):
        shown.update(k)
        corners = shown.outline.get_xydata()
        for axis, (low, high) in enumerate(
            (shown.body.get_xlim(), shown.body.get_ylim())
        ):
            assert low < corners[:, axis].min()
            assert corners[:, axis].max() < high
    assert shown.follows == (name == "far")


def test_times_too_close_to_a_zeno_point_show_the_last_that_can_be_read():
    class Deep:
        """A run that cannot be read less than 0.25 s before its Zeno points at 1 s and 2 s."""

        zeno_points = tuple(
            SimpleNamespace(time=t, method="bounce", plastic=False) for t in (1.0, 2.0)
        )

        def at(self, times):
            if (np.ravel(times) % 1 > 0.75).any():
                raise ValueError("t = ... cannot be used")

    times = np.array([0, 0.5, 0.7, 0.8, 0.9, 1.0, 1.5, 1.9, 2.0, 2.3])
    expected = [0, 0.5, 0.7, 0.7, 0.7, 1.0, 1.5, 1.5, 2.0, 2.3]
    np.testing.assert_array_equal(readable(Deep(), times), expected)
    run = ball()
    times = run.frame_times(10, clock="zeno")
    np.testing.assert_array_equal(readable(run, times), times)


def test_impacts_without_flight_are_not_found():
    run = sliding()
    times = np.linspace(0, 1, 50)
    assert [len(found) for found in impacts(run, times, run.gaps_at(times))] == [0, 0]


@pytest.mark.parametrize("name", ["film.avi", "film.htm", "film"])
def test_another_suffix_is_refused(tmp_path, name):
    path = str(tmp_path / name)
    with pytest.raises(
        ValueError, match=r"ends in \.gif, \.mp4 or \.html is allowed"
    ) as caught:
        ball().animate(path)
    assert str(caught.value).startswith(f"path = {path!r} cannot be used")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"clock": "slow"}, 'clock = "slow" cannot be used: `real` or `zeno`'),
        ({"fps": 0}, "fps = 0.0 is outside its range: finite and > 0, at most 1000"),
        ({"fps": 51}, "fps = 51.0 cannot be used: at most 50 for a .gif; .mp4 takes more"),
        (
            {"speed": 1e-4},
            "speed = 0.0001 cannot be used: at most 20000 frames, and this film would have 900001; raise speed",
        ),
    ],
)  # fmt: skip
def test_a_wrong_argument_is_named(tmp_path, arguments, message):
    with pytest.raises(ValueError, match=r"is outside|cannot be used") as caught:
        ball().animate(tmp_path / "film.gif", **arguments)
    assert str(caught.value) == message
    assert not list(tmp_path.iterdir())


def test_a_run_that_cannot_be_shown_is_refused(tmp_path):
    path = tmp_path / "film.gif"
    with pytest.raises(ValueError, match="record = false cannot be used"):
        ball(record=False).animate(path)
    model = sf.LocalModel((10, 10), (0.1, 0.1), (0, 0), 0.5)
    with pytest.raises(ValueError, match="a LocalModel, which has no posture"):
        model.simulate((1, 1), (0, 0)).animate(path)
    with pytest.raises(OSError, match="no_folder"):
        ball().animate(tmp_path / "no_folder" / "film.gif", fps=1)
    assert not list(tmp_path.iterdir())


def test_without_ffmpeg_an_mp4_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(film.FFMpegWriter, "isAvailable", lambda: False)
    with pytest.raises(ValueError, match="needs the program ffmpeg"):
        ball().animate(tmp_path / "film.mp4")


def test_a_film_from_the_command_line(tmp_path, capsys):
    scene, out = str(EXAMPLES / "bouncing_ball.toml"), str(tmp_path / "film.gif")
    assert main(["animate", scene, out, "--fps", "1", "--clock", "zeno"]) == 0
    assert capsys.readouterr().out == f"wrote {out}\n"
    assert sum(lengths(out)) == 9000
    for arguments, message in (
        ([out, "--fps", "0"], "--fps: fps = 0.0"),
        ([out, "--clock", "slow"], '--clock: clock = "slow"'),
        ([str(tmp_path / "film.avi")], "must end in .gif, .mp4 or .html"),
        ([], "animate needs a file for the film"),
    ):
        assert main(["animate", scene, *arguments]) == 2
        assert message in capsys.readouterr().err


def test_without_a_terminal_there_is_no_progress_bar(tmp_path, capsys):
    assert not sys.stderr.isatty()
    ball().animate(tmp_path / "film.gif", fps=1)
    assert capsys.readouterr().err == ""
