"""Verdicts on bodies with more contacts, two of which touch the ground: a box on its side."""

import numpy as np
import pytest
import standfast as sf


def pair(posture, i, j):
    """The posture with two of the contacts, numbered from 0."""
    feet = [posture.contacts[k] for k in (i, j)]
    return sf.Posture(
        posture.mass,
        posture.gyration_radius,
        posture.center_of_mass,
        feet,
        posture.restitution,
        posture.gravity,
    )


def polygon(corners, first, **options):
    """The corners in turn, from this one on: it changes their numbers."""
    return sf.Posture.polygon([*corners[first:], *corners[:first]], **options)


CORNERS = [(-0.2, 0.0), (0.3, 0.0), (0.4, 0.5), (-0.1, 0.9)]


@pytest.mark.parametrize("friction", [0.2, 0.9, 3.0])
@pytest.mark.parametrize("first", range(4))
def test_the_verdict_is_that_of_the_two_corners_that_touch(first, friction):
    body = polygon(CORNERS, first, friction=friction, restitution=0.2)
    i, j = sorted(((0 - first) % 4, (1 - first) % 4))
    verdict, alone = sf.stability(body), sf.stability(pair(body, i, j))
    assert verdict.contacts == [i + 1, j + 1]
    assert alone.contacts == [1, 2]
    for name in (
        "frictional_stability",
        "by",
        "reason",
        "equilibrium_margin",
        "kinematic_margin",
        "coupling",
        "amplification",
        "flight",
    ):
        assert getattr(verdict, name) == getattr(alone, name), name
    assert list(verdict.modes) == list(alone.modes)
    places = {1: i + 1, 2: j + 1}
    if verdict.by == "no-solution":
        expected = [places[number] for number in alone.evidence["contacts"]]
        jams = [
            {**jam, "contacts": [places[number] for number in jam["contacts"]]}
            for jam in alone.jams
        ]
        assert verdict.jams == jams
        evidence = {**alone.evidence, "contacts": expected, "jams": jams}
        assert verdict.evidence == evidence
    assert f"{i + 1} and {j + 1} touch" in str(verdict)
    assert "touch" not in str(alone)


def test_a_box_stands_unless_a_corner_jams():
    """A corner jams if ρ² + b² < μ b c, with b = w/2, c = h/2: μ > (4/3)(w/h) + (1/3)(h/w). A box that does not jam is not unstable."""
    rng, found = np.random.default_rng(3), set()
    for _ in range(200):
        w, h, friction = [*rng.uniform(0.2, 2, 2).tolist(), rng.uniform(0.1, 4)]
        box = sf.Posture.box(w, h, friction=friction, restitution=rng.choice([0, 0.3]))
        verdict = sf.stability(box)
        jams = friction > 4 / 3 * w / h + h / w / 3
        assert verdict.contacts == [1, 2]
        assert (verdict.by == "no-solution") == jams
        assert jams == (verdict.frictional_stability == "unstable")
        found.add(verdict.frictional_stability)
    assert {"stable", "unstable"} <= found


def test_kicked_boxes_on_edge_and_flat_come_to_rest_where_they_are_stable():
    rng = np.random.default_rng(4)
    for _ in range(10):
        w, h = rng.uniform(0.3, 1.5, 2)
        box = sf.Posture.box(w, h, friction=rng.uniform(0.2, 0.8), restitution=0.1)
        if sf.stability(box).frictional_stability != "stable":
            continue
        trials = sf.stability(box, trials=40).trials
        assert trials["rest"] == 40, (w, h)
