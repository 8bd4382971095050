"""Certificates of verdicts: all hold, and none holds for a claim that is false.

STANDFAST_CERTIFICATES sets the number of random postures (60)."""

import collections
import copy
import json
import math
import os
import subprocess
import sys
import time
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
import standfast as sf
from bodies import paper_vee
from corners import next_corner
from feet import draw_feet
from feet import rays as all_rays
from standfast.certificate import intervals as numbers
from standfast.certificate.corners import Cell, Corners
from standfast.certificate.ends import Attracting, Fast, Repelling, fast_end
from standfast.certificate.feet import rays
from standfast.certificate.flights import Flights
from standfast.certificate.scene import body_of
from standfast.certificate_maker import scene
from standfast.cli import main

POSTURES = int(os.environ.get("STANDFAST_CERTIFICATES", "60"))
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
    """What is changed, and the same certificate with another claim, other rays, a changed number of its data, or a scene of which the claim is not proved."""
    claim = certificate["claim"]
    rule = claim["jams"]
    flipped = {"stable": "unstable", "unstable": "stable"}
    for key, value in (
        ("frictional_stability", flipped[claim["frictional_stability"]]),
        ("by", "well" if claim["by"] != "well" else "theorem-3"),
        ("contacts", claim["contacts"][1:]),
        ("jams", "unknown"),
    ):
        other = copy.deepcopy(certificate)
        other["claim"][key] = value
        yield key, other
    for key, value in certificate["data"].items():
        other = copy.deepcopy(certificate)
        if key in ("rays", "pairs", "outer", "slides"):
            other["data"][key] = value[1:]
        elif key == "width":
            other["data"][key] = (float.fromhex(value) * 1.001).hex()
        elif key == "separates":
            other["data"][key][1] = (-float.fromhex(value[1])).hex()
        elif key == "potential":
            # Where the core has no fast-slide ends, its bounds on ln G are too large by less than 1/2.
            no_ends = certificate["data"]["ends"] == [[None, None]] * 2
            largest = [max(map(float.fromhex, part)) for part in value]
            j = int(np.argmax(largest))
            k = value[j].index(largest[j].hex())
            other["data"][key][j][k] = (
                0.0 if largest[j] > 0.5 and no_ends else -0.1
            ).hex()
        elif key == "limits":
            other["data"][key] = [*value[:3], *value[4:]]
        elif key == "corners":
            for corner in other["data"][key]:
                corner["slope"] = (float.fromhex(corner["slope"]) + 0.3).hex()
        elif key in ("velocity", "qdot"):
            other["data"][key] = [(-float.fromhex(part)).hex() for part in value]
        else:
            continue
        yield key, other
    other = copy.deepcopy(certificate)
    other["claim"]["jams"] = {"none": "impact", "impact": "none"}[rule]
    verdict = sf.stability(posture_of(certificate["scene"]), jams=other["claim"]["jams"])  # fmt: skip
    decided = {verdict.frictional_stability, claim["frictional_stability"]}
    if decided == {"stable", "unstable"}:
        yield "the other rule for jams", other
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
        verdict = sf.stability(posture_of(scene), jams=rule)
        decided = {verdict.frictional_stability, claim["frictional_stability"]}
        if decided == {"stable", "unstable"} and not verdict.delicate:
            yield "scene", other
            return


@pytest.mark.parametrize("rule", ["none", "impact"])
def test_all_certificates_hold_and_no_false_one(record_property, rule):
    rng = np.random.default_rng(7)
    found, times = collections.Counter(), collections.defaultdict(list)
    false = collections.Counter()
    for n in range(POSTURES):
        draw = (draw_pair, lambda rng: draw_feet(rng, rng.integers(3, 7)), draw_level)
        posture = draw[(0, 1, 0, 1, 2)[n % 5]](rng)
        verdict = sf.stability(posture, jams=rule)
        if verdict.by is None or verdict.delicate:
            continue
        certificate = verdict.certificate()
        assert certificate["claim"]["jams"] == rule
        again = json.loads(json.dumps(certificate))
        assert again == certificate
        start = time.perf_counter()
        assert sf.certificate.check(again) is None
        times[verdict.by].append(1e3 * (time.perf_counter() - start))
        found[verdict.by] += 1
        for key, other in tampered(certificate, rng):
            refused(other)
            false[key] += 1
    took = {by: f"{np.median(ms):.1f} ({max(ms):.1f})" for by, ms in times.items()}
    text = f"{POSTURES} postures, jams={rule!r}: {dict(found)}; ms in the median (and at most): {took}; false ones refused: {dict(false)}"
    print(f"\n{text}")
    record_property("certificates", text)
    expected = {"not-equilibrium", "well", "theorem-3-loose", "neutral", "corner-map", "descending-pair", "accelerating-mode"}  # fmt: skip
    assert expected <= set(found)
    assert ("no-solution" in found) == (rule == "none")
    assert false["the other rule for jams"] > 0
    assert false.total() > 4 * sum(map(len, times.values()))


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
    assert run.stdout.startswith(f"{good}: stable by theorem-3-loose: every step holds\n  contacts 1, 2, jams = 'none'\n")  # fmt: skip
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
    shown = capsys.readouterr().out
    assert "every step holds\n" in shown
    assert main(["check", str(path), str(scene)]) == 0
    assert capsys.readouterr().out == f"{shown.rstrip()}\n  the scene of stairs.toml\n"
    other = ROOT / "examples" / "v_terrain.toml"
    assert main(["check", str(path), str(other)]) == 2
    assert f"{path}: scene." in capsys.readouterr().err
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


@pytest.mark.parametrize("rule", ["none", "impact"])
def test_the_corner_map_of_the_checker_is_that_of_the_simulator(rule):
    """Restitutions up to 0.3: with larger ones rounding errors of the simulator may grow from impact to impact. A corner that lands more slowly
    than 1e-2 of its size may be none for the simulator."""
    rng, found = np.random.default_rng(12), collections.Counter()
    while found["corner"] < POSTURES // 2:
        posture = draw_pair(rng)
        lands, phi = int(rng.integers(2)), rng.uniform(-1.5, 1.5)
        at = numbers.Interval.of(Fraction(math.tan(phi))).lo
        cell = Cell.between(at, at)
        try:
            body = replace(body_of(scene(posture, [1, 2])), resolves_jams=rule == "impact")  # fmt: skip
            corners = Corners(body)
            images = corners.images(lands, cell)
        except ValueError:
            continue  # a sign is not certain, or a contact jams
        if len(images) != 1 or posture.restitution > 0.3:
            continue
        [image] = images
        then = next_corner(posture, lands, phi, rule)
        if image in ("rest", "escape"):
            assert then is None, (posture, lands, phi, image, then)
            found[image] += 1
            continue
        angles = [math.atan(end / numbers.UNIT) for end in (image.low, image.high)]
        if abs(angles[0]) > math.atan(100):
            continue
        before = cell.xi.square() + cell.y.square()
        growth = math.log(image.square.hi / before.hi) / 2
        if then is None:
            found["a landing in a closed sum, without an impact in the log"] += 1
            continue
        courses = corners.course(lands)
        if len(courses) > 1:
            found["a flight that is cut"] += 1
            continue
        [start] = courses
        after = cell.xi + start.shift * cell.y
        jams = start.flight.kept in jamming(corners, after)
        if jams and start.flight.h.hi == 0:
            # Both contacts are closed: a corner of no duration may follow, which the phases do not show.
            found["a jam of closed contacts"] += 1
            continue
        assert then[0] == image.contact, (posture, lands, phi)
        # Rounding errors of the simulator.
        assert then[1:] == pytest.approx((angles[0], growth), abs=1e-6), (posture, lands, phi)  # fmt: skip
        assert angles[1] - angles[0] < 1e-12
        found["corner"] += 1
        found["corner after a jam"] += jams
    print(found)
    assert found["rest"] > 0
    assert found["escape"] > 0
    assert (found["corner after a jam"] > 0) == (rule == "impact")


def jamming(corners, xi):
    """The contacts that jam while they slide at ξ."""
    return [k for k in range(2) if corners.jumps[k].get(xi.sign()) is not None]


def test_a_self_similar_tail_lasts_as_long_as_its_impacts():
    """Flights that end with both contacts at rest, by impacts that repeat for ever: against the impacts one by one, with many digits."""
    rng, found = np.random.default_rng(21), 0
    mp.mp.prec = 2000
    while found < 6:
        posture, j = draw_pair(rng), int(rng.integers(2))
        try:
            flights = Flights(body_of(scene(posture, [1, 2])))
            [flight] = flights.flight(j)
        except ValueError:
            continue
        if flight.kept is not None or flight.away or flight.t.hi == 0:  # fmt: skip
            continue
        g, psi, e = (
            [mp.mpf(part.lo + part.hi) / (2 * numbers.UNIT) for part in parts]
            for parts in (flights.g, flights.psi, flights.e)
        )
        # Impact by impact.
        h, u, t, last = [mp.mpf(0)] * 2, [mp.mpf(0)] * 2, mp.mpf(0), j
        u[j] = mp.mpf(-1)
        impacts = 0
        while max(map(abs, u)) >= 1e-40:
            impacts += 1
            assert impacts < 3000
            v = u[last]
            u[last], u[1 - last] = -e[last] * v, u[1 - last] + (1 + e[last]) * psi[last] * v  # fmt: skip
            if h[1 - last] == 0 and u[1 - last] < 0:
                last = 1 - last
                continue
            lands = [(u[i] + mp.sqrt(u[i] ** 2 + 2 * g[i] * h[i])) / g[i] for i in (0, 1)]  # fmt: skip
            last = int(lands[1] < lands[0])
            dt = lands[last]
            h = [h[i] + u[i] * dt - g[i] * dt**2 / 2 for i in (0, 1)]
            h[last] = mp.mpf(0)
            u, t = [u[i] - g[i] * dt for i in (0, 1)], t + dt
        assert mp.mpf(flight.t.lo) / numbers.UNIT - 1e-38 <= t <= mp.mpf(flight.t.hi) / numbers.UNIT  # fmt: skip
        assert flight.t.hi - flight.t.lo < 0.01 * flight.t.hi
        found += 1


@pytest.mark.parametrize("rule", ["none", "impact"])
def test_a_self_similar_tail_beside_a_wall(rule):
    """Gravity does not pull contact 2 onto its wall, and the impacts of both contacts repeat for ever."""
    feet = [sf.Contact((-1, 0.055), slope=-0.1, friction=0.5, restitution=0.35), sf.Contact((1, -0.115), slope=math.pi / 2, friction=0.92, restitution=0.1)]  # fmt: skip
    posture = sf.Posture(1, 1.065, (-1.75, 2.457), feet, 0)
    [flight] = Flights(body_of(scene(posture, [1, 2]))).flight(0)
    assert (flight.kept, flight.away) == (None, False)
    verdict = sf.stability(posture, jams=rule)
    assert verdict.certificate()["claim"]["by"] == "corner-map"


def fast(shift, bend, factor):
    """A corner of a fast slide, which is followed by one like it."""
    a, b, k = (numbers.Interval.of(Fraction(part)) for part in (shift, bend, factor))
    return Fast(0, a, b, k)


@pytest.mark.parametrize(
    ("bend", "factor", "width"), [(0.5, 0.5, 0.5), (-0.2, 0.7, 1.0), (0.3, 1.5, 0.5), (-0.4, 1.2, 0.4)]
)  # fmt: skip
def test_a_fast_slide_end_contains_its_corners(bend, factor, width):
    """ξ' = ξ + B y, y' = K y, one by one."""
    corner = fast(0, bend, factor)
    at = numbers.Interval.of(Fraction(width)).lo
    end = fast_end(corner, corner, at, "the end")
    assert isinstance(end, Attracting if factor < 1 else Repelling)
    for w in np.linspace(0.01, 1, 20) * width:
        xi, y, most = 1.0, w, 0.0
        for _ in range(200):
            xi, y = xi + bend * y, factor * y
            if factor > 1 and y > width * xi:
                break
            most = max(most, math.log(math.hypot(xi, y) / math.hypot(1, w)))
        if factor < 1:
            speed = numbers.ONE + end.limit * numbers.Interval.of(Fraction(w))
            assert speed.lo / numbers.UNIT - 1e-12 <= xi <= speed.hi / numbers.UNIT + 1e-12  # fmt: skip
        else:
            assert most <= end.transit / numbers.UNIT


@pytest.mark.parametrize(
    ("corner", "words"),
    [
        (fast(-2, 0.1, 0.5), "at the start of a slide"),
        (fast(0, -2, 0.5), "at the end of a slide"),
        (fast(0, -0.75, 0.3), "speed of the slide of both contacts"),
        (fast(0, 0.9, 1.3), "1 - xw"),
    ],
)
def test_a_fast_slide_end_in_which_a_slide_turns_is_refused(corner, words):
    with pytest.raises(ValueError, match=words):
        fast_end(corner, corner, numbers.UNIT, "the end")


def test_a_certificate_does_not_hold_on_the_other_side_of_a_border():
    """Between restitutions of 0.075 and 0.11 this posture changes from stable to unstable."""
    feet = [sf.Contact((-1, 0), slope=-0.31, friction=0.89), sf.Contact((1, 0.25), slope=1.16, friction=0.89)]  # fmt: skip
    verdicts = {e: sf.stability(sf.Posture(1, 0.38, (0.58, 0.95), feet, e)) for e in (0.075, 0.11)}  # fmt: skip
    stable, unstable = (verdict.certificate() for verdict in verdicts.values())
    assert (stable["claim"]["by"], unstable["claim"]["by"]) == ("corner-map", "growing-cycle")  # fmt: skip
    stable["scene"], unstable["scene"] = unstable["scene"], stable["scene"]
    assert refused(stable).startswith("corner-map: the potential of cell ")
    assert refused(unstable).startswith("growing-cycle: ")


def test_a_growing_cycle_of_a_fast_slide():
    """Contact 1 and contact 2 land in turn while the body slides to the right; once around, all speeds are multiplied by κ."""
    feet = [sf.Contact((-1.2, -0.4), slope=-0.44, friction=0.18), sf.Contact((1.2, -0.25), slope=0.37, friction=0.5)]  # fmt: skip
    certificate = sf.stability(sf.Posture(1, 1.14, (-0.6, 2.5), feet, 0.5)).certificate()  # fmt: skip
    assert certificate["claim"]["by"] == "growing-cycle"
    corners = certificate["data"]["corners"]
    assert [corner["contact"] for corner in corners] == [1, 2]
    assert min(float.fromhex(corner["slope"]) for corner in corners) > 1
    corners[0]["slope"] = (0.5).hex()
    refused(certificate)


def places(value, path=()):
    """The paths of all parts of a JSON value."""
    yield path
    parts = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()  # fmt: skip
    for key, part in parts:
        yield from places(part, (*path, key))


JUNK = (None, True, 0, -1, 10**400, 0.5, "", "x", "nan", "inf", "0x1p1000", "-0x1p-1000", "0x1p99999", [], [[]], {}, ["0x1p0"])  # fmt: skip


def test_no_junk_is_more_than_refused():
    """Any value in any place: the certificate holds or is refused."""
    rng = np.random.default_rng(5)
    base: dict[str, dict[str, object]] = {}
    while len(base) < 7:
        posture = (draw_pair, draw_level, lambda rng: draw_feet(rng, 3))[rng.integers(3)](rng)  # fmt: skip
        verdict = sf.stability(posture)
        if verdict.by is not None and not verdict.delicate:
            base.setdefault(verdict.by, verdict.certificate())
    ends = collections.Counter()
    for _ in range(4 * POSTURES):
        certificate = copy.deepcopy(base[rng.choice(sorted(base))])
        path = list(places(certificate))
        path = path[rng.integers(1, len(path))]
        place = certificate
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = JUNK[rng.integers(len(JUNK))]
        try:
            sf.certificate.check(certificate)
            ends["holds"] += 1
        except ValueError:
            ends["refused"] += 1
    print(ends)
    assert ends["refused"] > 2 * POSTURES


SCENES = ROOT / "tests" / "atlas" / "scenes"


@pytest.mark.parametrize(
    ("posture", "by"),
    [
        # y·w of the separating vector is of order 1e-9.
        (sf.load(SCENES / "nearly_parallel_ground.toml").posture, "not-equilibrium"),
        # A force is outside its friction cone by 1e-17 of the load: the strict reading holds by a tie.
        (sf.load(SCENES / "sliding_to_a_stop.toml").posture, "theorem-3-loose"),
        # A slide without friction on level ground neither speeds up nor slows down.
        (sf.Posture.box(0.3, 0.5, friction=0, restitution=0.3), "accelerating-mode"),
        # Forces and moments only just separate: two walls without friction squeeze nothing.
        (sf.Posture(1, 0.4, (0, 0), [sf.Contact((x, 0), slope=x * math.pi / 2) for x in (-1, 1)], 0), "not-equilibrium"),
    ],
)  # fmt: skip
def test_near_ties(posture, by):
    certificate = sf.stability(posture).certificate()
    assert certificate["claim"]["by"] == by
    sf.certificate.check(certificate)


def test_numbers_are_enclosed():
    rng = np.random.default_rng(3)
    mp.mp.prec = 400

    def exact(x):
        return mp.mpf(x) / numbers.UNIT

    def encloses(interval, x, wide=1e-70):
        assert exact(interval.lo) <= x <= exact(interval.hi)
        assert interval.hi - interval.lo <= wide * numbers.UNIT

    for _ in range(200):
        angle = rng.uniform(-math.pi, math.pi)
        cosine, sine = numbers.cosine_and_sine(angle)
        encloses(cosine, mp.cos(angle))
        encloses(sine, mp.sin(angle))
        x, y = (float(part) for part in rng.normal(size=2) * 10.0 ** rng.uniform(-3, 3, 2))  # fmt: skip
        a, b = (numbers.Interval.of(Fraction(part)) for part in (x, y))
        encloses(a * b, mp.mpf(x) * y)
        encloses(a / b, mp.mpf(x) / y, 1e-60)
        encloses((a * a).sqrt(), abs(mp.mpf(x)))
        encloses(a.square() - b, mp.mpf(x) ** 2 - y)
        power = rng.uniform(-60, 60)
        below = exact(numbers.exponential(numbers.Interval.of(Fraction(power)).lo))
        assert 0 <= mp.exp(power) - below <= 1e-9 * mp.exp(power)
        x = 1 + abs(power) / rng.choice([60, 1e3, 1e9])
        above = exact(numbers.logarithm(numbers.Interval.of(Fraction(x)).hi))
        assert 0 <= above - mp.log(x) <= 1e-30


def test_a_quadratic_polynomial_is_not_negative():
    """(x − p)² + q, with one sign for the square, on an interval that may contain p."""
    rng = np.random.default_rng(4)
    found = collections.Counter()
    for _ in range(500):
        p, q, low, wide = rng.uniform(-1, 1, 4)
        sign = int(rng.choice([-1, 1]))
        low, high = Fraction(low), Fraction(low) + abs(Fraction(wide))
        p, q = Fraction(p), Fraction(q)
        least = min(sign * (x - p) ** 2 + q for x in (low, high, *((p,) if low < p < high else ())))  # fmt: skip
        a, b, c = (numbers.Interval.of(part) for part in (Fraction(sign), -2 * sign * p, sign * p * p + q))  # fmt: skip
        ends = [numbers.Interval.of(end).lo for end in (low, high)]
        found[bool(least >= 0)] += 1
        assert numbers.at_least_zero(a, b, c, *ends) == (least >= 0)
    assert min(found[True], found[False]) > 100


def test_an_undecided_verdict_has_no_certificate():
    """The normal of contact 2 passes through contact 1."""
    feet = [sf.Contact((-1, 0), slope=0.17, friction=0.1), sf.Contact((1, 1.5), slope=-math.atan(4 / 3), friction=1.2)]  # fmt: skip
    verdict = sf.stability(sf.Posture(1, 0.5, (0.61, 2.47), feet, 0.05))
    assert verdict.by is None
    with pytest.raises(ValueError, match="only a decided one has a certificate"):
        verdict.certificate()


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("conventions",), 2, "conventions 2"),
        (("scene", "gravity"), 9.81, "scene.gravity is not a finite double"),
        (("scene", "gravity"), (0.0).hex(), "scene.gravity is not positive"),
        (("scene", "mass"), "nan", "scene.mass is not a finite double"),
        (("scene", "mass"), (-1.0).hex(), "scene.mass is not positive"),
        (("scene", "mass"), "0.5", "as float.hex writes it: '0.5'"),
        (("scene", "contacts", 0, "restitution"), (1.0).hex(), "below 1"),
        (("scene", "contacts", 1, "slope"), (8.0).hex(), "slope"),
        (("scene", "contacts"), [None] * 1001, "at most 1000"),
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


def test_a_key_given_twice_and_a_file_without_end_are_refused(tmp_path):
    """A reader who sees the first claim must not be shown a proof of the second one."""
    path = tmp_path / "certificate.json"
    text = json.dumps(sf.stability(paper_vee(0, 0.2)).certificate())
    path.write_text(text.replace('"by": ', '"by": "well", "by": '))
    with pytest.raises(ValueError, match="the key 'by' is given twice"):
        sf.certificate.read(path)
    with pytest.raises(ValueError, match="more than 1000000 bytes"):
        sf.certificate.read(Path("/dev/zero"))


def test_every_value_that_a_check_names_is_shown(tmp_path, capsys):
    """The summary has the doubles of the scene: they are read back with the same bits."""
    posture = paper_vee(0.1, 0.2)
    certificate = sf.stability(posture).certificate()
    first, _, body, *feet = sf.certificate.summary(certificate).splitlines()
    assert first == "stable by theorem-3-loose: every step holds"
    assert f"mass = {posture.mass}, " in body
    assert f"center_of_mass = {posture.center_of_mass}" in body
    for foot, shown in zip(posture.contacts, feet, strict=True):
        assert f"point = {foot.point}, slope = {foot.slope}, friction = {foot.friction}" in shown  # fmt: skip


def test_the_rays_of_a_certificate_are_all_rays():
    """Against all pairs of contacts; with a ray less, another one or one twice they are refused."""
    rng = np.random.default_rng(9)
    for _ in range(30):
        posture = draw_feet(rng, int(rng.integers(3, 9)))
        body = body_of(scene(posture, range(1, len(posture.contacts) + 1)))
        pairs = [[i + 1, j + 1] for i, j, _ in all_rays(posture)]
        if not pairs:
            continue
        found = rays(body, {"rays": pairs})
        assert [[k + 1 for k in ray.pair] for ray in found] == pairs
        names = [foot.name for foot in body.feet]
        wrong = [
            pair for pair in map(list, combinations(names, 2)) if pair not in pairs
        ]
        false = [pairs[:k] + pairs[k + 1 :] for k in range(len(pairs))]
        for stated in (*false, *([*pairs, pair] for pair in wrong), pairs + pairs[:1]):
            with pytest.raises(ValueError, match=r"data\.rays|leave all others open"):
                rays(body, {"rays": stated})


def test_a_thousand_contacts_are_checked_in_seconds():
    """With tan(slope) = x² on the level below the centre of mass each contact has a ray with the next one, and the last one with the first."""
    zero, one = (0.0).hex(), (1.0).hex()
    feet = [
        {"number": k, "point": [x.hex(), (-1.0).hex()], "slope": math.atan(x * x).hex(), "friction": zero, "restitution": zero}
        for k, x in enumerate(np.linspace(-0.5, 0.5, 1000).tolist(), start=1)
    ]  # fmt: skip
    body = body_of({"mass": one, "gyration_radius": one, "center_of_mass": [zero] * 2, "gravity": one, "contacts": feet})  # fmt: skip
    start = time.perf_counter()
    rays(body, {"rays": [[1, 1000], *([k, k + 1] for k in range(1, 1000))]})
    # The check of all pairs took an hour.
    assert time.perf_counter() - start < 60
