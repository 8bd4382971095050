"""Pictures, `repr` and the report describe a run correctly."""

import math
import re
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import standfast as sf
from drawn import approach_panels, body_panel, gaps_panel
from plastic_scenes import IN_TURN, block, body, drop, local, rod
from standfast import plot, scenery
from standfast.report import account
from standfast.table import is_infinite

EXAMPLES = Path(__file__).parents[2] / "examples"
#: Angle between the steepest slope and the vertical, rad.
LEAN = 1e-9


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def ladder(q=(0, 0, 0), friction=0.5, **options):
    """A ladder 3 m high on a floor and against a wall; the slope of the wall is close to -pi/2."""
    feet = [
        sf.Contact((1.0, 0.0), friction=friction),
        sf.Contact((0.0, 3.0), slope=LEAN - math.pi / 2, friction=friction),
    ]
    posture = sf.Posture(1.0, 1.0, (0.5, 1.5), feet, 0.0)
    return sf.simulate(posture, q, (0, 0, 0), **options)


#: A run; its headline, with t for its time; the title of the list in the report; its repr; whether one accumulation of
#: impacts over a time is its main event.
RUNS = {
    "one contact, plastic": (
        lambda: drop(body([0.0])),
        "Contact 1 lands in one impact without rebound (e = 0) at t = {t} s",
        "plastic landings (no rebound)",
        "; 1 collision, 1 plastic landing>",
        False,
    ),
    "one contact that bounces": (
        lambda: drop(body([0.0], 0.7)),
        "Infinitely many impacts on contact 1 end at t = {t} s",
        "Zeno points (infinitely many impacts end)",
        "; 1 collision, 1 Zeno point (1-zeno at 0.809",
        True,
    ),
    "both ends at once, plastic": (
        lambda: drop(rod(0.0)),
        "Contacts 1 and 2 land without rebound (e = 0) at t = {t} s",
        "plastic landings (no rebound)",
        "; 2 collisions, 1 plastic landing>",
        False,
    ),
    "both ends in turn, plastic, uncoupled": (
        lambda: drop(body([-0.5, 0.5], gyration_radius=0.5, height=0.0), 0.1),
        "Outcome: rest at t = {t} s; 2 impacts without rebound",
        "plastic landings (no rebound)",
        "; 2 collisions, 2 plastic landings>",
        False,
    ),
    "both ends in turn, plastic, coupled: in one instant in the end": (
        lambda: drop(rod(0.0), 0.1),
        "Outcome: rest at t = {t} s; 1 impact without rebound, 1 Zeno point",
        "Zeno points (infinitely many impacts end), plastic landings (no rebound)",
        "; 1 collision, 1 plastic landing, 1 Zeno point (2-zeno at 0.148",
        False,
    ),
    "a table, plastic": (
        lambda: drop(body([-0.6, -0.2, 0.2, 0.6], height=0.7), 0.05),
        "Outcome: rest at t = {t} s; 2 impacts without rebound",
        "plastic landings (no rebound)",
        "; 4 collisions, 2 plastic landings>",
        False,
    ),
    "at rest from the start": (
        lambda: sf.simulate(rod(0.1), (0, 0, 0), (0, 0, 0)),
        "Outcome: rest at t = {t} s; contacts 1 and 2 touch the ground from the start",
        "contacts on the ground from the start",
        "; 0 collisions, contacts 1 and 2 on the ground from the start>",
        False,
    ),
    "one contact at rest from the start": (
        lambda: sf.simulate(body([0.0]), (0, 0, 0), (0, 0, 0)),
        "Outcome: rest at t = {t} s; contact 1 touches the ground from the start",
        "contacts on the ground from the start",
        "; 0 collisions, contact 1 on the ground from the start>",
        False,
    ),
    "sliding from the start": (
        lambda: sf.simulate(body([-0.5, 0.5], 0.1, 0.1), (0, 0, 0), (1, 0, 0)),
        "Outcome: rest at t = {t} s; contacts 1 and 2 touch the ground from the start",
        "contacts on the ground from the start",
        "; 0 collisions, contacts 1 and 2 on the ground from the start>",
        False,
    ),
    "no contact ever": (
        lambda: drop(rod(0.1), height=1.0, time_limit=0.1),
        "Outcome: time-limit at t = {t} s",
        None,
        "; 0 collisions>",
        False,
    ),
    "clattering": (
        lambda: sf.load(EXAMPLES / "clattering_rod.toml").simulate(),
        "Infinitely many impacts on contacts 1 and 2 end at t = {t} s",
        "Zeno points (infinitely many impacts end)",
        "; 9 collisions, 1 Zeno point (2-zeno at 0.0477848070642202 s, clatter)>",
        True,
    ),
    "a rocking block": (
        lambda: sf.load(EXAMPLES / "rocking_block.toml").simulate(),
        "Outcome: rest at t = {t} s; 22 Zeno points",
        "Zeno points (infinitely many impacts end), contacts on the ground from the start",
        "; 70 collisions, 22 Zeno points, contact 1 on the ground from the start>",
        False,
    ),
    "a plastic rocking block: its landings accumulate": (
        block,
        "Outcome: rest at t = {t} s; 4 impacts without rebound, 1 Zeno point",
        "Zeno points (infinitely many impacts end), plastic landings (no rebound), contacts on"
        " the ground from the start",
        "; 4 collisions, 4 plastic landings, 1 Zeno point (2-zeno at 6.22",
        True,
    ),
    "chatter in one instant": (
        lambda: local((0.0, -1.9)),
        "Infinitely many impacts on contacts 1 and 2 in one instant, at t = {t} s",
        "Zeno points (infinitely many impacts end)",
        "; 0 collisions, 1 Zeno point (2-zeno at 0 s, chatter)>",
        False,
    ),
    "in one instant, by another law": (
        lambda: sf.simulate(
            rod(0.05, friction=0.3),
            (0, 0.5 * math.sin(0.1), 0.1),
            (0, 0, 0),
            impact="poisson",
            simultaneous=IN_TURN,
        ),
        "Infinitely many impacts on contacts 1 and 2 in one instant, at t = {t} s",
        "Zeno points (infinitely many impacts end), contacts on the ground from the start",
        "; 64 collisions, 1 Zeno point (2-zeno at 0.108",
        False,
    ),
    "a bounce that another law follows to its end": (
        lambda: drop(body([0.0], 0.5), impact="poisson"),
        "Infinitely many impacts on contact 1 end at t = {t} s",
        "Zeno points (infinitely many impacts end)",
        ", 1 Zeno point (1-zeno at 0.428",
        True,
    ),
    "an impact without collision": (
        lambda: sf.simulate(
            sf.Posture(
                2.0,
                math.sqrt(1 / 3),
                (0.6, 0.8),
                [sf.Contact((0, 0), friction=2.0)],
                0.0,
                1.0,
            ),
            (0, 0, 0),
            (-1, 0, 0),
            impact="poisson",
            time_limit=0.1,
        ),
        "Outcome: time-limit at t = {t} s; 1 impact",
        "contacts on the ground from the start",
        "; 1 collision, contact 1 on the ground from the start>",
        False,
    ),
}


@pytest.mark.parametrize("name", RUNS)
def test_a_run_is_called_what_it_is(name):
    make, headline, title, shown, accumulation = RUNS[name]
    run = make()
    figure = run.plot()
    headline = headline.format(t=f"{run.time:.12f}")
    assert figure.axes[0].get_title(loc="left").replace("\n", " ") == headline
    assert len(approach_panels(figure)) == accumulation
    assert shown.removesuffix(">") in repr(run)
    printed = account(run, name)
    assert (f"\n  {title}\n" if title else "\n  no Zeno point\n") in printed
    # Without infinitely many impacts no text mentions them or a Zeno point.
    infinite = any(is_infinite(p) for p in run.zeno_points)
    legends = [axes.get_legend() for axes in figure.axes if axes.get_legend()]
    texts = [text for legend in legends for text in legend.get_texts()]
    labels = " ".join(text.get_text() for text in texts)
    for text in (labels, repr(run), printed.replace("no Zeno point", "")):
        assert ("Zeno point" in text) == infinite, text
    assert ("nfinitely many" in printed) == infinite
    for text in (printed, repr(run), *map(repr, run.zeno_points), labels, headline):
        # Singular for one item, plural for several.
        assert not re.search(r"(?<![\d.])1 (impacts|collisions|landings|points)", text)
        assert not re.search(r"\bcontacts \d+ (?!and|to)|contact \d+ and", text), text


def test_the_report_sums_nothing_up_in_a_plastic_landing():
    printed = account(drop(body([0.0])), "ball")
    assert "  plastic  yes        no impact\n" in printed
    assert (
        "    F     0.14278431229270644  0.14278431229270644  plastic landing\n"
        in printed
    )
    assert "bounc" not in printed


def test_many_contacts_are_named_in_short():
    """A row of feet moves as its outer two, the first of which is hit once more when the last one lands; all are named."""
    contacts = tuple(range(1, 21))
    run = drop(body([x / 10 for x in range(-10, 10)]), 0.02)
    assert run.zeno_points[-1].contacts == contacts
    assert "  20-zeno  1 to 20   chatter" in account(run, "table")


def test_what_is_proved_of_a_plastic_landing():
    run = drop(body([0.0]), certify=True)
    printed = account(run, "ball")
    assert "proved, after the start: 1 impact within" in printed
    assert "first plastic landing, of contact 1: from" in printed
    assert "1 impact, " in repr(run.enclosure)


def test_a_run_that_takes_no_time_is_drawn():
    """Runs at rest, and sliding without end, from the start."""
    for speed, outcome in ((0.0, "rest"), (1.0, "sliding")):
        smooth = sf.simulate(rod(0.1), (0, 0, 0), (speed, 0, 0))
        assert (smooth.outcome, smooth.elapsed) == (outcome, 0.0)
        axes = gaps_panel(smooth.plot())
        (text,) = axes.texts
        assert text.get_text() == f"The run ends at its start: {outcome}"
        assert [line.get_xydata().tolist() for line in axes.lines] == [[[0, 0]]] * 2


# The legend.


@pytest.mark.parametrize("restitution", [0.0, 0.3])
@pytest.mark.parametrize("number", [1, 2, 3, 8, 14, 20, 64])
def test_the_legend_is_inside_the_figure(number, restitution):
    xs = [k / 10 - number / 20 for k in range(number)]
    posture = body(xs, restitution, 1.0, gyration_radius=2.0)
    figure = drop(posture, 0.001, event_limit=100).plot()
    figure.draw_without_rendering()
    over = gaps_panel(figure)
    for axes in (over, body_panel(figure)):
        box = axes.get_legend().get_window_extent()
        assert figure.bbox.x0 <= box.x0
        assert box.x1 <= figure.bbox.x1
        # No legend reaches into the next panel.
        assert axes.get_window_extent().y0 <= box.y0
        assert box.y1 <= figure.bbox.y1
    lines = [line for line in over.lines if line.get_linestyle() not in ("None", ":")]
    assert len(lines) == number
    drawn = [line for line in lines if line.get_color() != plot.ALOOF]
    looks = {(line.get_color(), str(line._dash_pattern)) for line in drawn}
    assert len(looks) == min(len(drawn), 16)
    # Where there are many contacts, those that never touch the ground are grey.
    assert len(drawn) == number or number > 4


# The body.


def spans(axes):
    """Extents of the view and of the last body drawn in it, both (2,), m."""
    view = np.abs([np.diff(axes.get_xlim()), np.diff(axes.get_ylim())]).ravel()
    markers = [
        line.get_xydata()[0] for line in axes.lines if line.get_marker() in "o^sD+"
    ]
    return view, np.ptp(np.array(markers), axis=0)


def surfaces(axes):
    """The lines of the ground, (2, 2), m."""
    return [x.get_xydata() for x in axes.lines if x.get_color() == plot.SURFACE]


@pytest.mark.parametrize(
    "run",
    [
        ladder,
        lambda: ladder((0.02, 0.05, 0)),
        lambda: ladder(friction=0.1, time_limit=0.5),
    ],
)
def test_a_ladder_fills_its_panel(run):
    figure = run().plot()
    figure.draw_without_rendering()
    axes = body_panel(figure)
    view, shown = spans(axes)
    assert shown[1] > 0.75 * view[1]
    box = axes.get_window_extent()
    assert box.width / box.height == pytest.approx(view[0] / view[1], rel=1e-6)
    wall, floor = sorted(surfaces(axes), key=lambda line: np.ptp(line[:, 0]))
    low, high = axes.get_ylim()
    assert np.ptp(wall[:, 0]) < 1e-6
    # The floor extends from the wall to the edge of the view, and the wall upwards from the floor.
    assert abs(wall[:, 0]).max() < 1e-6
    assert sorted(wall[:, 1]) == pytest.approx([0.0, high], abs=1e-6)
    assert sorted(floor[:, 0]) == pytest.approx([0.0, axes.get_xlim()[1]], abs=1e-6)
    np.testing.assert_allclose(floor[:, 1], 0.0, atol=1e-6)
    assert low < 0.0


def test_a_body_on_a_steep_slope_fills_its_panel():
    """In front of a slope of almost a right angle, without gravity: the body stays at its place."""
    slope = math.pi / 2 - LEAN
    foot = sf.Contact((0.0, 0.0), slope=slope, friction=1.0)
    posture = sf.Posture(1.0, 0.3, (-0.5, 0.0), [foot], 0.5, 0.0)
    run = sf.simulate(posture, (-0.01, 0, 0), (0.3, 0, 0), time_limit=0.1)
    axes = body_panel(run.plot())
    (wall,) = surfaces(axes)
    np.testing.assert_allclose(wall[:, 0], 0.0, atol=1e-6)
    assert sorted(wall[:, 1]) == pytest.approx(sorted(axes.get_ylim()))
    circle = next(line for line in axes.lines if line.get_color() == "0.0")
    across, up = np.ptp(circle.get_xydata(), axis=0)
    assert across == pytest.approx(up, rel=0.01)
    assert up > 0.6 * np.ptp(axes.get_ylim())


def test_stairs_are_drawn_with_their_risers():
    scene = sf.load(EXAMPLES / "stairs.toml")
    axes = body_panel(scene.simulate().plot())
    lines = surfaces(axes)
    vertices = np.array(scene.posture.terrain)
    inside = [
        all(
            low <= v <= high
            for v, (low, high) in zip(
                vertex, (axes.get_xlim(), axes.get_ylim()), strict=True
            )
        )
        for vertex in vertices
    ]
    assert sum(inside) >= 6
    for vertex in vertices[inside]:
        assert (
            sum(
                np.isclose(end, vertex, atol=1e-12).all()
                for line in lines
                for end in line
            )
            == 2
        )
    for before, after in pairwise(lines):
        np.testing.assert_allclose(before[1], after[0], atol=1e-12)


def test_ground_that_is_far_below_does_not_shrink_the_body():
    axes = body_panel(drop(rod(0.1), height=1e6, time_limit=0.1).plot())
    view, shown = spans(axes)
    assert shown[0] > 0.8 * view[0]


@pytest.mark.parametrize(
    ("direction", "expected"),
    [
        ((0.0, 1.0), (-2.0, 3.0)),  # a wall
        ((0.0, -1.0), (-3.0, 2.0)),
        ((-1.0, 0.0), (-1.0, 1.0)),  # a ceiling
        ((math.sqrt(0.5), math.sqrt(0.5)), (-math.sqrt(2), math.sqrt(2))),
    ],
)
def test_ground_of_any_direction_is_cut_at_the_view(direction, expected):
    piece = (np.zeros(2), np.array(direction), -math.inf, math.inf)
    box = np.array([-1.0, -2.0]), np.array([1.0, 3.0])
    assert scenery.clipped(piece, *box) == pytest.approx(expected)
    ends = (np.zeros(2), np.array(direction), 0.0, 0.5)
    assert scenery.clipped(ends, *box) == (0.0, 0.5)
    away = (np.array([5.0, 9.0]), np.array(direction), -1.0, 1.0)
    assert scenery.clipped(away, *box) is None


@pytest.mark.parametrize(
    ("points", "slopes", "between"),
    [
        (((-1, 0), (1, 0)), (-0.5, 0.5), (0.0, -math.tan(0.5))),  # a V
        (((-1, 0), (1, 0)), (0.5, -0.5), (0.0, math.tan(0.5))),  # a roof
        (((0, 0), (1, 0.25)), (0.0, 0.0), None),  # a step: both lines end halfway
        (((0, 0), (1, 0.25)), (0.0, -0.01), None),  # lines that meet far away
    ],
)
def test_lines_of_ground_end_where_they_meet(points, slopes, between):
    feet = [sf.Contact(p, slope=s) for p, s in zip(points, slopes, strict=True)]
    first, second = scenery.ground(sf.Posture(1.0, 0.5, (0.0, 1.0), feet, 0.0))
    end = first[0] + first[1] * first[3]
    begin = second[0] + second[1] * second[2]
    if between is None:
        assert (end[0], begin[0]) == pytest.approx((0.5, 0.5), abs=2e-3)
    else:
        np.testing.assert_allclose([end, begin], [between, between], atol=1e-12)
    assert (first[2], second[3]) == (-math.inf, math.inf)


def test_the_body_is_drawn_with_its_arms_and_its_hull():
    """For a square whose corners are listed crosswise, with one contact inside."""
    corners = [(0, 0), (1, 1), (1, 0), (0, 1), (0.4, 0.5)]
    feet = [sf.Contact(p, friction=0.5) for p in corners]
    posture = sf.Posture(1.0, 0.4, (0.5, 0.6), feet, 0.0, 0.0)
    run = sf.simulate(posture, (0, 1, 0), (0, 0, 0), time_limit=0.1)
    axes = body_panel(run.plot())
    black = [line.get_xydata() for line in axes.lines if line.get_color() == "0.0"]
    outline, arms, center = black
    up = np.array([0.0, 1.0])
    np.testing.assert_allclose(outline - up, [(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)])
    np.testing.assert_allclose(arms[1::3] - up, corners)
    np.testing.assert_allclose(arms[0::3] - center, np.zeros((5, 2)), atol=1e-15)


def test_impacts_at_one_instant_are_one_row_of_the_report():
    """A rod falls flat without rebound: both ends are hit at one instant, in turn."""
    flat = rod(0.0, friction=0.5)
    run = sf.simulate(flat, (0, 0.1, 0), (0, 0, 0), impact="poisson", model="full")
    table = account(run, "flat").split("impacts simulated")[1].split("\n\n")[0]
    rows = [line.split() for line in table.splitlines()[2:]]
    count = len(run.impacts)
    assert count > 1
    assert len(np.unique(run.impacts["elapsed"])) == len(rows) == 1
    number = f"1 to {count}".split()
    assert rows[0][:3] == number
    assert rows[0][4:7] == ["1", "and", "2"]
    assert float(rows[0][-1]) == run.impacts["rates_after"][-1][1]
