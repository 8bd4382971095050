"""A side of the body on a corner of the ground has its letter, its force, its cone and its impacts at that corner, in all pictures and texts."""

import json
import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
import standfast as sf
from drawn import approach_panels, body_panel, gaps_panel
from standfast import notebook, plot
from standfast.film import FLASH, Film
from standfast.report import account

TABLE = [(-5, 0), (0, 0), (0, -2), (5, -2)]
STAIRS = [(-3, 0), (0.6, 0), (0.6, -0.4), (1.4, -0.4), (1.4, -0.8), (2.2, -0.8), (2.2, -1.2), (6, -1.2)]  # fmt: skip
#: The number of the first side of a box.
SIDE = 5


@pytest.fixture(autouse=True)
def _close():
    yield
    plt.close("all")


def over_the_edge(**options):
    """A box that turns about the edge of a table, slides, and falls."""
    box = sf.Posture.box(1.0, 0.5, friction=0.5, restitution=0.2, terrain=TABLE)
    return sf.simulate(box, (0.01, 0, 0), (0, 0, 0), impact="moreau", **options)


def thrown():
    """Two sides of this box bounce on two stairs."""
    box = sf.Posture.box(0.9, 0.3, friction=0.4, restitution=0.2, terrain=STAIRS)
    return sf.simulate(box, (-0.6, 0.5, 0.3), (2.5, 1, -4), impact="moreau")


def tilted_along(run, index, t):
    """Unit vector along the side of contact `index` at t, with the body on its left."""
    contact = run.contacts[index]
    corners = np.array(run.posture.outline)
    way = corners[(contact.index + 1) % 4] - corners[contact.index]
    c, s = math.cos(run.at(t)[0][2]), math.sin(run.at(t)[0][2])
    return np.array([[c, -s], [s, c]]) @ way / math.hypot(*way)


def test_a_contact_of_a_run_knows_its_side():
    box = sf.Posture.box(1.0, 0.5, friction=0.5, terrain=TABLE)
    first, second, *others = box.contacts
    contacts = [first, sf.Contact(second.point, friction=0.3), *others]
    box = sf.Posture(
        box.mass, box.gyration_radius, box.center_of_mass, contacts, 0.2,
        terrain=TABLE, outline=box.outline,
    )  # fmt: skip
    run = sf.simulate(box, (0.01, 0, 0), (0, 0, 0), impact="moreau")
    side = run.contacts[SIDE - 1]
    assert (side.kind, side.along, side.friction) == ("side", (1.0, 0.0), 0.3)
    own = run.contacts[0]
    assert (own.kind, own.along, own.friction) == ("corner", None, 0.5)


def test_a_film_shows_the_side_at_the_corner():
    run = over_the_edge(stop="time", time_limit=1.2)
    shown = Film(run, 20, 1.0, "real")
    seen = set()
    for k, t in enumerate(shown.t):
        shown.update(k)
        letter = shown.letters[4].get_text()
        seen.add(letter)
        mode = next(p.mode for p in reversed(run.phases) if p.start <= t)
        assert letter == mode[4].replace("S", "")
        assert shown.feet[4].get_visible() == bool(letter)
        assert shown.cones[4].get_visible() == shown.arrows[4].get_visible()
        assert shown.arrows[4].get_visible() == bool(letter)
        if not letter:
            continue
        along = tilted_along(run, 4, t)
        normal = np.array([-along[1], along[0]])
        assert shown.feet[4].get_xydata() == pytest.approx(np.zeros((1, 2)))
        assert shown.cones[4].center == (0.0, 0.0)
        middle = 0.5 * (shown.cones[4].theta1 + shown.cones[4].theta2)
        assert np.radians(middle) == pytest.approx(math.atan2(normal[1], normal[0]))
        pull, push = run.forces_at(t)[4]
        tail, tip = shown.arrows[4]._posA_posB
        assert tail == (0.0, 0.0)
        force = pull * along + push * normal
        assert tip[0] * force[1] == pytest.approx(tip[1] * force[0], abs=1e-9)
        assert np.dot(tip, force) > 0.0
        # The letter is in the ground, below the side.
        assert np.dot(shown.letters[4].get_position(), normal) < 0.0
    assert seen == {"F", "R", ""}


def test_rings_flash_at_the_corners():
    run = thrown()
    shown = Film(run, 30, 1.0, "real")
    sides = [c for c in run.contacts if c.kind == "side"]
    assert len(sides) == 2
    for contact in sides:
        index = contact.number - 1
        times, places = shown.hits[index]
        hits = run.impacts["time"][run.impacts["contact"] == contact.number]
        assert len(hits) > 1
        assert times == pytest.approx(np.unique(hits))
        assert (places == contact.corner).all()
        shown._flash(index, float(times[0]) + 0.1 * FLASH)
        assert shown.rings[index].get_visible()
        ring = shown.rings[index].get_xydata()
        assert ring == pytest.approx(np.array([contact.corner]))


def test_a_picture_marks_the_corner_with_its_number():
    run = thrown()
    figure = run.plot()
    body, gaps = body_panel(figure), gaps_panel(figure)
    marks = [tuple(line.get_xydata()[0]) for line in body.lines if len(line.get_xydata()) == 1]  # fmt: skip
    for contact in run.contacts[4:]:
        assert contact.corner in marks
        [text] = [t for t in body.texts if t.get_text() == str(contact.number)]
        assert np.subtract(text.get_position(), contact.corner) == pytest.approx(0, abs=0.2)  # fmt: skip
    labels = [text.get_text() for text in gaps.get_legend().get_texts()]
    assert {"contact 5 (side), impacts", "contact 6 (side), impacts"} <= set(labels)
    times, values = plot.forces(run)
    assert values.shape == (len(times), 6, 2)
    assert np.nanmax(values[:, 5, 1]) > 0.0


def test_bounces_of_a_side_have_no_panel_of_gaps():
    """The gaps of the corners do not show them."""
    peak = [(-1, -9), (0, 0), (1, -9)]
    box = sf.Posture.box(1, 0.5, restitution=0.5, terrain=peak)
    run = sf.simulate(box, (0, 0.2, 0), (0, 0, 0), impact="moreau")
    assert [point.contacts for point in run.zeno_points] == [(SIDE,)]
    figure = run.plot()
    assert approach_panels(figure) == []
    [label] = [t.get_text() for t in gaps_panel(figure).get_legend().get_texts() if "side" in t.get_text()]  # fmt: skip
    assert label == "contact 5 (side), impacts"
    film = Film(run, 10, 2.0, "zeno")
    assert len(film.hits[4][0]) == len(np.unique(run.impacts["time"]))


def test_a_page_has_the_sides():
    run = over_the_edge()
    drawing = run.film(100)["drawing"]
    side = {"corner": [0.0, 0.0], "along": [1.0, 0.0], "friction": 0.5}
    assert drawing["sides"] == [side]
    standing = sf.Posture.box(1, 0.5, friction=0.5, terrain=[(-9, 0), (0.2, 0), (0.2, -1)])  # fmt: skip
    question = {
        "ask": "posture",
        "scene": json.loads(sf.Scene(standing, (0, 0, 0), (0, 0, 0)).to_json()),
    }
    told = json.loads(sf.ask(json.dumps(question)))
    assert told["drawing"]["sides"] == [side | {"corner": [0.2, 0.0]}]
    assert told["verdict"]["contacts"] == [1, SIDE]


def test_texts_and_tables_name_the_side():
    run = thrown()
    text = account(run, "thrown")
    assert "contact 5   side 2 on the corner of the ground at (0.6, 0) m, friction 0.4" in text  # fmt: skip
    assert "a side has no gap" in text
    table = run.impact_table()
    on_side = table["contact"] > 4
    assert np.isnan(table["rate_before"][on_side]).all()
    assert (table["rate_before"][~on_side] < 0.0).all()
    assert (table["impulse_normal"][on_side] > 0.0).all()
    html = notebook.of_run(run)
    assert ">6</text>" in html
    assert "5 (side)" in notebook.of_posture(over_the_edge().posture.replace())


def test_a_verdict_names_the_side():
    """Forces have the numbers of the contacts: 0.5 of 0.7 of the weight are on the edge, 0.7 m from the other support."""
    ground = [(-9, 0), (0.2, 0), (0.2, -1)]
    box = sf.Posture.box(1, 0.5, friction=0.5, gravity=7.0, terrain=ground)
    text = str(sf.stability(box))
    assert "1 and 5 touch; the others" in text
    assert "contact 5         is a side of the body on the corner of the ground at (0.2, 0) m" in text  # fmt: skip
    assert "1: (0, 2)  5: (0, 5)" in text
    assert sf.static_forces(box) is not None


def test_a_dataset_has_sides_without_gaps():
    pytest.importorskip("xarray")
    run = over_the_edge(stop="time", time_limit=0.5)
    data = run.to_xarray([0.0, 0.5])
    assert list(data.contact.values) == [1, 2, 3, 4, 5]
    assert np.isnan(data.gaps.sel(contact=SIDE)).all()
    assert not np.isnan(data.gaps.sel(contact=1)).any()
    assert list(data["mode"].sel(contact=SIDE).values) == ["F", "F"]
    force = data.forces.sel(contact=SIDE, direction="normal").values
    assert (force > 0.0).all()


def test_many_sides_are_one_entry_of_the_legend():
    """A board that slides down stairs touches many edges."""
    stairs = [(-9.0, 0.0), (0.0, 0.0)]
    for k in range(12):
        stairs += [(0.15 * k, -0.1 * (k + 1)), (0.15 * (k + 1), -0.1 * (k + 1))]
    board = sf.Posture.box(1.0, 0.2, friction=0.1, terrain=stairs)
    slope = -math.atan2(0.1, 0.15)
    normal = np.array([-math.sin(slope), math.cos(slope)])
    middle = 0.6 * np.array([math.cos(slope), math.sin(slope)]) + 0.1 * normal
    q = (*(middle - board.center_of_mass), slope)
    run = sf.simulate(board, q, (0, 0, 0), impact="moreau", stop="time", time_limit=0.2)
    sides = [c for c in run.contacts if c.kind == "side"]
    assert len(sides) > plot.FEW
    run.plot()
    shown = Film(run, 20, 1.0, "real")
    assert f"contacts 5 to {4 + len(sides)} (sides)" in shown.entries
    shown.update(2)
    assert any(letter.get_text() == "R" for letter in shown.letters[4:])
    assert f"contact {4 + len(sides)}" in account(run, "board")
