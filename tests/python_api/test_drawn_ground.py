"""The ground in a picture of a run is the ground of the run: every drawn piece lies on it, and all that is in view is drawn."""

import math
from itertools import pairwise

import numpy as np
import pytest
import standfast as sf
from standfast import plot

BOX = {"friction": 0.5, "restitution": 0.3}
SHAFT = [(-1.0, 1.0), (-0.6, 1.0), (-0.6, 0.0), (0.5, 0.0), (0.5, 1.0), (1.0, 1.0)]


def box(q=(0, 0.6, 0.4), qdot=(1.5, 0.5, -3), terrain=None, **options):
    posture = sf.Posture.box(0.3, 0.5, terrain=terrain, **BOX)
    return sf.simulate(posture, q, qdot, impact="moreau", time_limit=2.0, **options)


def ladder():
    feet = [
        sf.Contact((0, 0), friction=0.2),
        sf.Contact((1.7, 3.6), slope=math.pi / 2, friction=0.2),
    ]
    posture = sf.Posture(10, 1.15, (0.85, 1.8), feet, 0)
    return sf.simulate(posture, (0, 0, 0), (0, 0, 0), time_limit=0.6)


def on_one_line():
    """Three contacts, one of them above the others, on one sloping line."""
    slope = 0.3
    c, s = math.cos(slope), math.sin(slope)
    points = [(-0.5 * c, -0.5 * s), (-0.9 * s, 0.9 * c), (0.5 * c, 0.5 * s)]
    feet = [sf.Contact(p, slope=slope, friction=0.2) for p in points]
    posture = sf.Posture(1, 0.4, (-0.4 * s, 0.4 * c), feet, 0.2, ground="shared")
    return sf.simulate(posture, (0, 0.3, 0), (1, 0, -3), impact="moreau", time_limit=1)


def own(points, slopes, segments=None, **fields):
    """Contacts with lines of their own, from a small height."""
    everywhere = [(-math.inf, math.inf)] * len(points)
    feet = [
        sf.Contact(p, slope=s, friction=0.4, segment=ends)
        for p, s, ends in zip(points, slopes, segments or everywhere, strict=True)
    ]
    posture = sf.Posture(1, 0.6, (0, 0.8), feet, 0.2, **fields)
    return sf.simulate(posture, (0, 0.1, 0), (0, 0, 0), time_limit=0.3, impact="moreau")


#: Runs, and the number of pieces of their ground.
RUNS = {
    "a box": (box, 1),
    "a box on a polyline": (lambda: box(terrain=[(-5, 0), (5, 0)]), 1),
    "a ladder": (ladder, 2),
    "shared ground": (on_one_line, 1),
    "a shaft": (lambda: box(terrain=SHAFT), 5),
    "a kick": (
        lambda: box((0, 0, 0), (0, 0, 0), kicks=[sf.Kick(0.1, (0.8, 0), (0, 0.5))]),
        1,
    ),
    "a quake": (
        lambda: box(
            (0, 0, 0),
            (0, 0, 0),
            ground_motion=sf.GroundMotion([0.1, 0.4, 0.6], [(9, 0), (-9, 0), (0, 0)]),
        ),
        1,
    ),
    "a table on its own lines, which are one": (
        lambda: own([(x, 0) for x in (-1, -0.4, 0.4, 1)], [0] * 4),
        1,
    ),
    "a trough": (
        lambda: own([(-1, 0.3), (-0.4, 0), (0.4, 0), (1, 0.3)], [-0.5, 0, 0, 0.5]),
        3,
    ),
    "two separate pieces of one line": (
        lambda: own([(-1, 0), (1, 0)], [0, 0], [(-0.2, 0.3), (-0.5, 0.4)]),
        2,
    ),
    "one line of which both pieces overlap": (
        lambda: own([(-1, 0), (1, 0)], [0, 0], [(-0.2, 1.3), (-1.5, 0.4)]),
        1,
    ),
}


@pytest.fixture(scope="module", params=RUNS, ids=str)
def drawn(request):
    """A posture, the lines of its ground in the picture of a run, and the corners of the view."""
    make, number = RUNS[request.param]
    run = make()
    (axes,) = [axes for axes in run.plot().axes if axes.get_aspect() == 1.0]
    lines = [x.get_xydata() for x in axes.lines if x.get_color() == plot.SURFACE]
    assert len(lines) == number
    view = np.array([axes.get_xlim(), axes.get_ylim()]).T
    return run.posture, lines, view


def signed_gaps(posture, place):
    """The gap of each contact, all of them at this place."""
    moves = np.array(place) - [contact.point for contact in posture.contacts]
    return np.array([posture.gaps((*move, 0))[i] for i, move in enumerate(moves)])


def away(place, segments):
    """Distance of a place from the nearest of some segments, m."""
    distances = []
    for begin, end in segments:
        way = np.subtract(end, begin)
        share = np.clip((place - begin) @ way / (way @ way), 0.0, 1.0)
        distances.append(np.hypot(*(place - begin - share * way)))
    return min(distances)


def test_every_drawn_piece_is_ground(drawn):
    posture, lines, view = drawn
    for line in lines:
        for share in np.linspace(0.0, 1.0, 41):
            place = line[0] + share * (line[1] - line[0])
            assert (view[0] - 1e-9 <= place).all()
            assert (place <= view[1] + 1e-9).all()
            if posture.terrain is not None:
                assert away(place, pairwise(np.array(posture.terrain))) < 1e-9
                continue
            gaps = signed_gaps(posture, place)
            # On the line of a contact, and not in the ground of another one.
            assert gaps.min() == pytest.approx(0.0, abs=1e-9)
            if posture.ground == "shared":
                assert gaps.max() == pytest.approx(0.0, abs=1e-9)


def test_all_ground_in_view_is_drawn(drawn):
    posture, lines, view = drawn
    reach = np.linspace(-1.0, 1.0, 801) * np.hypot(*(view[1] - view[0]))
    places = []
    if posture.terrain is not None:
        for begin, end in pairwise(np.array(posture.terrain)):
            places += list(begin + np.linspace(0, 1, 201)[:, None] * (end - begin))
    else:
        for index, contact in enumerate(posture.contacts):
            tangent = np.array([math.cos(contact.slope), math.sin(contact.slope)])
            normal = np.array([-tangent[1], tangent[0]])
            foot = contact.point - posture.gaps((0, 0, 0))[index] * normal
            low, high = contact.segment
            along = reach[(low <= reach) & (reach <= high)]
            line = foot + along[:, None] * tangent
            places += [p for p in line if signed_gaps(posture, p).min() > -1e-9]
    seen = [p for p in places if (view[0] <= p).all() and (p <= view[1]).all()]
    assert len(seen) > 20
    for place in seen:
        assert away(place, lines) < 1e-9


def test_the_floor_reaches_from_edge_to_edge(drawn):
    """Where one line is the whole ground."""
    posture, lines, view = drawn
    if posture.ground == "shared" and posture.contacts[0].slope == 0.0:
        (line,) = lines
        assert sorted(line[:, 0]) == pytest.approx(list(view[:, 0]), abs=1e-9)
        np.testing.assert_allclose(line[:, 1], 0.0, atol=1e-12)
