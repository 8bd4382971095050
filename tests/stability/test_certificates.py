"""Certificates of verdicts: all hold, and none holds for a claim that is false.

STANDFAST_CERTIFICATES sets the number of random postures (200)."""

import collections
import copy
import json
import math
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import standfast as sf
from bodies import paper_vee
from feet import draw_feet
from standfast.cli import main

POSTURES = int(os.environ.get("STANDFAST_CERTIFICATES", "200"))
ROOT = Path(__file__).parents[2]
CHECKER = ROOT / "python" / "standfast" / "certificate"

QUARTERS = (0, math.pi / 2, -math.pi / 2, math.pi)


def draw_pair(rng):
    """A body on two contacts: in a V, a steep V, on a roof, on any slopes, or between floors, walls and ceilings."""
    low, high = rng.uniform(-0.7, 0), rng.uniform(0, 0.7)
    slopes = [
        (low, high),
        (low - 0.6, high + 0.6),
        (high, low),
        rng.uniform(-1.3, 1.3, 2),
        rng.choice([*QUARTERS, 0.3, 2.4], 2),
    ][rng.integers(5)]
    feet = [
        sf.Contact((x + rng.uniform(-0.3, 0.3), rng.uniform(-0.4, 0.4)), slope=slope, friction=rng.uniform(0.05, 1.2))
        for x, slope in zip((-1, 1), slopes, strict=True)
    ]  # fmt: skip
    return sf.Posture(
        mass=rng.uniform(0.5, 2),
        gyration_radius=rng.uniform(0.2, 1.2),
        center_of_mass=(rng.uniform(-1.2, 1.2), rng.uniform(-0.5, 2.5)),
        contacts=feet,
        restitution=rng.choice([0, 0.05, 0.1, 0.3, 0.5, 0.8]),
    )


def draw_level(rng):
    """A body on level ground, or on two contacts that are mirror images, which may be neutral."""
    mu, e = rng.uniform(0.2, 1.5), rng.uniform(0, 0.9)
    if rng.integers(2):
        feet = [sf.Contact((x, 0), friction=mu) for x in (-1, rng.uniform(-0.9, 0.9), 1)]  # fmt: skip
        return sf.Posture(1, rng.uniform(0.3, 1), (rng.uniform(-0.9, 0.9), 1), feet, e)
    slope = rng.uniform(-1, 1)
    feet = [sf.Contact((x, 0), slope=x * slope, friction=mu) for x in (-1, 1)]
    return sf.Posture(1, rng.uniform(0.3, 1), (0, rng.uniform(-1, 2)), feet, e)


def posture_of(scene):
    """The posture of the scene of a certificate."""
    exact = float.fromhex
    feet = [
        sf.Contact(
            tuple(map(exact, contact["point"])),
            slope=exact(contact["slope"]),
            friction=exact(contact["friction"]),
            restitution=exact(contact["restitution"]),
        )
        for contact in scene["contacts"]
    ]
    return sf.Posture(
        exact(scene["mass"]),
        exact(scene["gyration_radius"]),
        tuple(map(exact, scene["center_of_mass"])),
        feet,
        0,
        gravity=exact(scene["gravity"]),
    )


def refused(certificate):
    with pytest.raises(ValueError, match=r"\w") as error:
        sf.certificate.check(certificate)
    return str(error.value)


def tampered(certificate, rng):
    """The same certificate with another claim, other rays, a changed number of its data, or a scene of which the claim is not proved."""
    claim = certificate["claim"]
    flipped = {"stable": "unstable", "unstable": "stable"}
    for key, value in (
        ("frictional_stability", flipped[claim["frictional_stability"]]),
        ("by", "well" if claim["by"] != "well" else "theorem-3"),
        ("contacts", claim["contacts"][1:]),
        ("jams", "impact"),
    ):
        other = copy.deepcopy(certificate)
        other["claim"][key] = value
        yield other
    for key, value in certificate["data"].items():
        other = copy.deepcopy(certificate)
        if key in ("rays", "pairs", "outer", "slides"):
            other["data"][key] = value[1:]
        elif key == "width":
            other["data"][key] = (float.fromhex(value) * 1.001).hex()
        elif key == "separates":
            other["data"][key][1] = (-float.fromhex(value[1])).hex()
        elif key == "potential":
            # The bounds of the core on ln G are too large by less than 1/2.
            largest = [max(map(float.fromhex, part)) for part in value]
            j = int(np.argmax(largest))
            k = value[j].index(largest[j].hex())
            other["data"][key][j][k] = (0.0 if largest[j] > 0.5 else -0.1).hex()
        elif key == "limits":
            other["data"][key] = [*value[:3], *value[4:]]
        elif key == "corners":
            other["data"][key][0]["slope"] = (float.fromhex(value[0]["slope"]) + 0.3).hex()  # fmt: skip
        elif key in ("velocity", "qdot"):
            other["data"][key] = [(-float.fromhex(part)).hex() for part in value]
        else:
            continue
        yield other
    tries = 0
    while tries < 20:
        tries += 1
        other = copy.deepcopy(certificate)
        scene = other["scene"]
        contact = scene["contacts"][rng.integers(len(scene["contacts"]))]
        match rng.integers(3):
            case 0:
                scene["center_of_mass"][rng.integers(2)] = rng.uniform(-2, 2).hex()
            case 1:
                contact["friction"] = rng.uniform(0, 1.5).hex()
            case 2:
                contact["restitution"] = rng.uniform(0, 0.99).hex()
        verdict = sf.stability(posture_of(scene))
        decided = {verdict.frictional_stability, claim["frictional_stability"]}
        if decided == {"stable", "unstable"} and not verdict.delicate:
            yield other
            return


def test_all_certificates_hold_and_no_false_one(record_property):
    rng = np.random.default_rng(7)
    found, times = collections.Counter(), collections.defaultdict(list)
    false = 0
    for n in range(POSTURES):
        draw = (draw_pair, lambda rng: draw_feet(rng, rng.integers(3, 7)), draw_level)
        posture = draw[(0, 1, 0, 1, 2)[n % 5]](rng)
        verdict = sf.stability(posture)
        if verdict.by is None or verdict.delicate:
            continue
        certificate = verdict.certificate()
        again = json.loads(json.dumps(certificate))
        assert again == certificate
        start = time.perf_counter()
        assert sf.certificate.check(again) is None
        times[verdict.by].append(1e3 * (time.perf_counter() - start))
        found[verdict.by] += 1
        for other in tampered(certificate, rng):
            refused(other)
            false += 1
    took = {by: f"{np.median(ms):.1f} ({max(ms):.1f})" for by, ms in times.items()}
    text = f"{POSTURES} postures: {dict(found)}; ms in the median (and at most): {took}; {false} false ones refused"
    print(f"\n{text}")
    record_property("certificates", text)
    expected = {"not-equilibrium", "no-solution", "well", "theorem-3-loose", "neutral", "corner-map", "descending-pair", "accelerating-mode"}  # fmt: skip
    assert expected <= set(found)
    assert false > 4 * sum(map(len, times.values()))


PROGRAM = f"""
import runpy, sys
sys.modules["standfast"] = sys.modules["standfast._core"] = sys.modules["numpy"] = None
sys.path.insert(0, {str(CHECKER.parent)!r})
runpy.run_module("certificate", run_name="__main__", alter_sys=True)
"""


def test_the_checker_runs_without_the_package(tmp_path):
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    certificate = sf.stability(paper_vee(0, 0.2)).certificate()
    good.write_text(json.dumps(certificate))
    certificate["scene"]["contacts"][0]["restitution"] = (0.9).hex()
    bad.write_text(json.dumps(certificate))
    command = [sys.executable, "-I", "-S", "-c", PROGRAM]
    run = subprocess.run([*command, str(good)], capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == f"{good}: stable by theorem-3-loose: every step holds\n"
    run = subprocess.run([*command, str(bad)], capture_output=True, text=True)
    assert run.returncode == 2
    assert run.stderr.startswith(f"{bad}: theorem-3-loose: ")


def test_the_checker_imports_the_standard_library_and_itself_only():
    files = list(CHECKER.glob("*.py"))
    assert len(files) > 5
    imported = {
        line.split()[1]
        for file in files
        for line in file.read_text(encoding="utf-8").splitlines()
        if line.lstrip().startswith(("import ", "from ")) and " " in line.strip()
    }
    own = {name for name in imported if name.startswith(".")}
    assert own <= {".", *(f".{file.stem}" for file in files)}
    assert {name.partition(".")[0] for name in imported - own} <= set(
        sys.stdlib_module_names
    )


def test_on_the_command_line(tmp_path, capsys):
    scene = ROOT / "examples" / "stairs.toml"
    path = tmp_path / "certificate.json"
    assert main(["stability", str(scene), "--certificate", str(path)]) == 0
    assert f"wrote {path}" in capsys.readouterr().out
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().out.endswith("every step holds\n")
    certificate = json.loads(path.read_text())
    certificate["claim"]["by"] = "well"
    path.write_text(json.dumps(certificate))
    assert main(["check", str(path)]) == 2
    problem = capsys.readouterr().err
    assert problem.startswith(f"standfast: {path}: well: ")
    assert problem.count("\n") == 1
    path.write_text('{\n"conventions": 1,\n}')
    assert main(["check", str(path)]) == 2
    assert f"{path}: line 3, column 1" in capsys.readouterr().err
    assert main(["check"]) == 2
    assert "check needs a certificate" in capsys.readouterr().err


def test_an_undecided_verdict_has_no_certificate():
    verdict = sf.stability(paper_vee(-0.2, 1.0))
    assert verdict.by is None
    with pytest.raises(ValueError, match="only a decided one has a certificate"):
        verdict.certificate()


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("conventions",), 2, "conventions 2"),
        (("scene", "gravity"), 9.81, "scene.gravity is not a hexadecimal number"),
        (("scene", "gravity"), "0x0p0", "scene.gravity is not positive"),
        (("scene", "contacts", 0, "restitution"), "0x1p0", "below 1"),
        (("scene", "contacts", 1, "slope"), "0x1p3", "slope"),
        (("scene", "contacts", 1, "number"), 1, "not in order"),
        (("scene", "contacts"), [], "contacts is empty"),
        (("claim", "by"), "faith", "no argument that can be checked"),
        (("claim",), None, "claim has no entry"),
    ],
)
def test_a_wrong_form_is_refused_by_name(path, value, words):
    certificate = sf.stability(paper_vee(0, 0.2)).certificate()
    place = certificate
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    assert words in refused(certificate)
