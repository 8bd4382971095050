"""What a newcomer sees: help pages, one-line summaries, and what messages say to do next."""

import pickle
import pydoc
import subprocess
import sys

import numpy as np
import pytest
import standfast as sf
from bodies import paper_vee
from standfast.cli import main

NAMES = [name for name in sf.__all__ if not name.startswith("__")]


@pytest.mark.parametrize(
    ("holder", "name"),
    [
        (holder, name)
        for holder in (sf, sf.results, sf.theory)
        for name in holder.__all__
        if not name.startswith("__")
    ],
)
def test_help_opens_for_every_public_name(holder, name):
    text = pydoc.render_doc(getattr(holder, name))
    assert name in text
    assert "r#" not in text


def test_help_of_the_package_names_everything():
    text = pydoc.render_doc(sf, renderer=pydoc.plaintext)
    assert all(name in text for name in NAMES)


@pytest.mark.parametrize(
    ("at", "reason"),
    [
        ((-0.78, 2.6, 0.8, 0.9), "cells"),
        ((0.08, 2.7, 0.8, 0.9), "flight"),
    ],
)
def test_an_undecided_verdict_says_why_and_what_to_try(at, reason):
    verdict = sf.stability(paper_vee(*at))
    assert (verdict.frictional_stability, verdict.by) == ("undecided", None)
    assert verdict.reason == reason
    assert repr(verdict) == f"<Verdict: undecided, reason {reason}>"
    assert verdict.in_words in str(verdict)
    assert "trials=1000" in str(verdict)
    tried = sf.stability(paper_vee(*at), trials=10)
    assert "trials=1000" not in str(tried)


def test_a_decided_verdict_has_no_reason():
    verdict = sf.stability(paper_vee(0, 0.2))
    assert verdict.frictional_stability == "stable"
    assert verdict.reason is None


def test_several_words_at_rest_are_the_reason_ambiguous():
    """A body can be jammed at rest: a contact on a slope is held or slides, each with forces of its own."""
    found = {}
    for x in np.linspace(-1, 1, 41):
        for mu in (1.5, 3.0):
            feet = [sf.Contact((-1, 0), friction=mu), sf.Contact((1, 0), -1.2, mu)]
            verdict = sf.stability(sf.Posture(1, 0.3, (x, 1.5), feet, 0.1))
            found.setdefault((verdict.by, verdict.reason), verdict)
    words = {key: verdict.unambiguous for key, verdict in found.items()}
    assert all(
        reason == "ambiguous"
        for (by, reason), alone in words.items()
        if by is None and not alone
    )
    assert all(reason != "ambiguous" for (_, reason), alone in words.items() if alone)


def test_the_summary_of_a_run_counts_its_warnings_and_begins_the_first():
    box = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
    run = sf.simulate(box, (0, 0.1, 0.1), (0, 0, 0), impact="newton")
    count, first = len(run.warnings), run.warnings[0]
    noun = "warning" if count == 1 else "warnings"
    start = repr(run).split(f"; {count} {noun}: ")[1].removesuffix(" …>")
    assert first.startswith(start)
    assert len(start) > 30
    rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    quiet = sf.simulate(rod, (0, 0.1, 0.01), (0, 0, 0))
    assert not quiet.warnings
    assert "warning" not in repr(quiet)


def table():
    """A body on three feet on level ground."""
    feet = [sf.Contact((x, 0), friction=0.5) for x in (-0.2, 0.1, 0.2)]
    return sf.Posture(1, 0.3, (0, 0.5), feet, 0)


def test_a_map_has_the_equilibrium_of_any_number_of_contacts():
    box = table()
    values = [-0.25, -0.15, 0.0, 0.15, 0.25]
    grid = sf.sweep(
        box, {"center_of_mass.x": values}, ["equilibrium", "equilibrium_margin"]
    )
    # The corners are at ±0.2 m.
    assert grid["equilibrium"].values.tolist() == [abs(x) <= 0.2 for x in values]
    margins = grid["equilibrium_margin"].values
    assert margins == pytest.approx([0.2 - abs(x) for x in values], abs=1e-15)
    with pytest.raises(ValueError, match="exactly 2 contacts"):
        sf.sweep(box, {"center_of_mass.x": values}, ["theorem_3"])


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["run"], "run needs a scene file, TOML or JSON"),
        (["modes"], "modes needs a scene file, TOML or JSON"),
        (["map", "a.toml"], "map needs --over PATH=LOW:HIGH:COUNT"),
    ],
)
def test_a_command_without_its_argument_says_what_it_needs(command, words, capsys):
    assert main(command) == 2
    assert words in capsys.readouterr().err


def test_an_acceleration_that_lasts_for_ever_is_said_once():
    box = sf.Posture.box(0.4, 1.0, friction=0.5)

    def said(**motion):
        run = sf.simulate(
            box,
            (0, 0, 0),
            (0, 0, 0),
            impact="moreau",
            ground_motion=sf.GroundMotion(**motion),
            time_limit=1,
        )
        return [text for text in run.warnings if "for ever" in text]

    assert len(said(times=[0, 0.1], acceleration=[(1, 0), (-1, 0)])) == 1
    assert not said(times=[0, 0.1], acceleration=[(1, 0), (0, 0)])
    assert not said(times=[0, 0.1], tilt=[0.01, 0.02])  # a floor that stays tilted


def test_many_runs_with_kicks_are_the_single_runs():
    box = sf.Posture.box(0.4, 1.0, friction=0.5, restitution=0.2)
    acts = {
        "kicks": [sf.Kick(0.1, (0.4, 0), (0, 1))],
        "ground_motion": sf.GroundMotion([0.2, 0.3], [(3, 0), (0, 0)]),
    }
    starts = [(0, 0, 0), (0, 0.05, 0.02), (0.1, 0.1, -0.3)]
    options = {"impact": "moreau", "time_limit": 1.0, **acts}
    runs = sf.simulate_many(box, starts, (0, 0, 0), **options)
    again = pickle.loads(pickle.dumps(runs))
    for k, q in enumerate(starts):
        one = sf.simulate(box, q, (0, 0, 0), **options)
        assert (runs.outcome[k], runs.time[k]) == (one.outcome, one.time)
        assert (runs.q[k] == one.q).all()
        assert (again.q[k] == one.q).all()
        assert runs[k].kicks == acts["kicks"]
        assert (runs[k].impacts == one.impacts).all()
    still = sf.simulate_many(box, starts, (0, 0, 0), impact="moreau", time_limit=1.0)
    assert not (still.q == runs.q).all(axis=1).any()
    with pytest.raises(ValueError, match=r"kicks\.1\.time = -1"):
        sf.simulate_many(box, starts, (0, 0, 0), kicks=[sf.Kick(-1, (0, 0))])


def test_what_an_import_leaves_for_later():
    """`import standfast` does not import the checker of certificates and robots, and finds them when they are used; robots do not import their
    libraries."""
    program = """
import sys
import standfast as sf
assert "standfast.certificate" not in sys.modules
assert "certificate" in dir(sf)
assert sf.certificate.check.__module__.startswith("standfast.certificate")
assert "standfast.robots" not in sys.modules
assert "robots" in dir(sf)
assert sf.robots.sagittal.__module__ == "standfast.robots"
assert not {"pinocchio", "mujoco"} & set(sys.modules)
try:
    sf.certificates
except AttributeError as error:
    print(error)
"""
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stdout == "module 'standfast' has no attribute 'certificates'\n"
