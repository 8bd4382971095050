"""Parts of the body, other than its contacts, that come below the ground."""

import math
import re

import standfast as sf

REST = (0, 0, 0)
FEET = [sf.Contact((-0.1, 0), friction=0.8), sf.Contact((0.1, 0), friction=0.8)]
CORNERS = [(-0.1, 0), (0.1, 0), (0.1, 1), (-0.1, 1)]
PUSH = [sf.Kick(0.01 * k, (5.0, 0), (0, 0.8)) for k in range(1, 31)]


def robot(**other):
    fields = {"mass": 5, "gyration_radius": 0.25, "center_of_mass": (0, 0.5)}
    return sf.Posture(**{**fields, "contacts": FEET, "restitution": 0, **other})


def entered(run):
    """Time and part of the body of each warning."""
    pattern = r"body-in-ground: at t = (\S+) s or before, (.*) has come below the ground of contact \d"
    found = [re.match(pattern, warning) for warning in run.warnings]
    return [(float(m[1]), m[2]) for m in found if m]


def test_a_body_that_falls_over_onto_its_feet_alone_is_reported():
    run = sf.simulate(robot(), REST, REST, impact="moreau", kicks=PUSH, time_limit=60)
    assert abs(abs(run.theta) - math.pi) < 1e-9  # at rest, upside down
    ((time, part),) = entered(run)
    assert part == "the centre of mass"
    assert time <= run.time
    height = run.at(time)[0][1] + 0.5
    assert height < 0


def test_with_an_outline_its_corner_is_named():
    body = robot(outline=CORNERS)
    run = sf.simulate(body, REST, REST, impact="moreau", kicks=PUSH, time_limit=60)
    ((time, part),) = entered(run)
    assert part == "corner 3 of the outline"
    _x, y, theta = run.at(time)[0]
    corner = 0.5 + y + math.sin(theta) * 0.1 + math.cos(theta) * 0.5
    assert corner < 0


def test_a_body_all_of_whose_corners_are_contacts_is_not_reported():
    box = sf.Posture.box(0.2, 1, friction=0.8)
    run = sf.simulate(box, REST, REST, impact="moreau", kicks=PUSH, time_limit=60)
    assert run.outcome == "rest"
    assert run.warnings == []


def test_a_centre_of_mass_that_hangs_below_its_feet_is_not_reported():
    hanging = robot(center_of_mass=(0, -0.3))
    run = sf.simulate(hanging, REST, (0, 0, 0.5), impact="moreau", time_limit=5)
    assert entered(run) == []


def test_a_body_that_only_rocks_is_not_reported():
    run = sf.simulate(robot(), REST, (0, 0, 0.3), impact="moreau", time_limit=60)
    assert run.outcome == "rest"
    assert run.warnings == []


def test_ground_that_faces_down_is_reported():
    """A terrain from right to left has its ground above."""
    body = robot(contacts=[sf.Contact((-0.1, 0)), sf.Contact((0.1, 0))])
    turned = robot(
        contacts=[sf.Contact((-0.1, 0)), sf.Contact((0.1, 0))],
        terrain=[(3, 0), (-3, 0)],
    )
    assert sf.simulate(body, REST, REST).warnings == []
    run = sf.simulate(turned, REST, REST)
    assert run.outcome == "escape"
    assert "the ground of all contacts faces down" in run.warnings[0]
