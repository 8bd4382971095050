"""Reference trajectories to 25 digits, through the Python interface.

Data: tests/data/reference_local.json and reference_full.json. A tolerance is 50 times the change of the result when every input
changes by one ulp, plus 4 ulp of its largest term. The rounding error of the geometry counts as a change too, and a time also
has the error bound of the reference.
"""

import json
import math
from fractions import Fraction
from pathlib import Path

import oracle
import pytest
from oracle_inputs import simulate_full, simulate_local

DATA = Path(__file__).parents[1] / "data"
ULPS = 4
CONDITION_FACTOR = 50


def load(name):
    """The cases of one file."""
    return json.loads((DATA / name).read_text(encoding="utf-8"))["cases"]


LOCAL = load("reference_local.json")
FULL = load("reference_full.json")


def inputs_of(case):
    """The exact doubles of a case."""
    return {k: float.fromhex(v["hex"]) for k, v in case["inputs"].items()}


def distance(value, reference):
    """|value − reference|, the difference of a double and a decimal taken exactly."""
    return float(abs(Fraction(float(value)) - Fraction(reference)))


def floor_of(case):
    """Change of the time by rounding the geometry itself, in s."""
    return case["conditioning"]["geometry_floor_abs"] or 0.0


def time_tolerance(case):
    """50 · (change of the Zeno time by one ulp) + bound of the reference's own error + 4 ulp."""
    zeno, condition = case["expected"]["zeno"], case["conditioning"]
    change = max(
        condition["zeno_time_abs_per_ulp"],
        condition["ulp_trials_max_time_change"],
        floor_of(case),
    )
    return (
        CONDITION_FACTOR * change
        + float(zeno["time_error_bound"])
        + ULPS * math.ulp(float(zeno["time"]))
    )


def judge_verdict_and_time(case, run):
    expected = case["expected"]["zeno"]
    point = run.zeno_points[0]
    assert run.outcome == "zeno"
    assert point.kind == expected["kind"]
    assert point.contact == expected["contact"]
    assert tuple(point.contacts) == (
        (expected["contact"],) if expected["contact"] else (1, 2)
    )
    error, tolerance = distance(point.time, expected["time"]), time_tolerance(case)
    assert error <= tolerance, f"time off by {error:.3g} s, tolerance {tolerance:.3g} s"
    return point


def judge_collisions(case, run, point):
    """Checks order, times and rates of all collisions that were simulated and not summed."""
    expected = case["expected"]["collisions"]
    count = min(point.first_summed, len(run.impacts), len(expected))
    if case["expected"]["zeno"]["method"] != "rest":
        assert len(run.impacts) >= 1
    sensitivity = (0.0, 0.0)
    for k, (impact, collision) in enumerate(
        zip(run.impacts[:count], expected[:count], strict=True)
    ):
        # Later collisions vary less; where s is not given, the last one is used.
        sensitivity = collision.get("s", sensitivity)
        assert impact["contact"] == collision["contact"], f"collision {k}"
        assert impact["index"] == collision["contact"] - 1, f"collision {k}"
        error = distance(impact["time"], collision["t"])
        tolerance = CONDITION_FACTOR * max(sensitivity[0], floor_of(case))
        tolerance += ULPS * math.ulp(float(collision["t"]))
        assert error <= tolerance, (
            f"collision {k}: time off by {error:.3g} s, tolerance {tolerance:.3g} s"
        )
        for field, name in (("rates_before", "v_pre"), ("rates_after", "v_post")):
            scale = max(abs(float(v)) for v in (*collision["v_pre"], *collision[name]))
            tolerance = CONDITION_FACTOR * sensitivity[1] + ULPS * math.ulp(scale)
            for i in (0, 1):
                error = distance(impact[field][i], collision[name][i])
                assert error <= tolerance, (
                    f"collision {k}: {field}[{i}] off by {error:.3g} m/s, "
                    f"tolerance {tolerance:.3g} m/s"
                )


def judge_state(case, found):
    """Checks the state at the Zeno point.

    Tolerance: 50 · (change by one ulp of every input, from the oracle) + 50 · (error of the time from the rounding error of the
    geometry) · rate +
    4 ulp(scale). Rates: the largest speed and angular velocity in the run, and gravity for velocities. Scale: the largest
    term in the sum of the entry.
    """
    inputs, expected = inputs_of(case), case["expected"]["zeno"]
    sensitivity, floor = oracle.sensitivity(inputs), floor_of(case)
    T, g = float(expected["time"]), max(inputs.get("g", 0.0), inputs.get("g1", 0.0))
    g = max(g, inputs.get("g2", 0.0))
    speed = max(
        (abs(float(v)) for c in case["expected"]["collisions"] for v in c["v_pre"]),
        default=0.0,
    )
    speed = max(
        speed, *(abs(inputs.get(k, 0.0)) for k in ("u1", "u2", "v_x", "v_y")), g * T
    )
    lever = (
        1 / inputs["rho"]
        if "rho" in inputs
        else max(abs(inputs["phi1"]), abs(inputs["phi2"]))
    )
    spin = max(abs(inputs["omega"]), 2 * lever * speed)
    rates = {"theta": spin, "omega": g * lever}
    rates |= dict.fromkeys(("h1", "h2", "r_x", "r_y"), speed)
    rates |= dict.fromkeys(("u1", "u2", "v_x", "v_y"), g)
    scales = {name: rate * T for name, rate in rates.items()}
    scales |= dict.fromkeys(("u1", "u2", "v_x", "v_y"), speed) | {"omega": spin}
    for name, value in found.items():
        reference = expected["state"][name]
        scale = max(scales[name], abs(inputs.get(name, 0.0)), abs(float(reference)))
        tolerance = (
            CONDITION_FACTOR * (sensitivity.total(name) + floor * rates[name])
            + float(expected["time_error_bound"]) * rates[name]
            + ULPS * math.ulp(scale)
        )
        error = distance(value, reference)
        assert error <= tolerance, (
            f"{name} off by {error:.3g}, tolerance {tolerance:.3g}"
        )


def judge_contact(point):
    """Checks that the contacts that came to rest have gap and rate exactly zero."""
    for contact in point.contacts:
        assert point.gaps[contact - 1] == 0.0
        assert point.gap_rates[contact - 1] == 0.0


def test_every_reference_case_is_here():
    ids = {case["id"] for case in LOCAL + FULL}
    assert len(LOCAL) == 14
    assert len(FULL) == 12
    assert len(ids) == 26
    for case in LOCAL + FULL:
        # Each verdict is the same after every change by one ulp, so each may be checked.
        assert case["conditioning"]["ulp_trials_with_other_verdict"] == 0


@pytest.mark.parametrize("case", LOCAL, ids=lambda c: f"{c['id']}-{c['family']}")
def test_local_reference(case):
    run = simulate_local(inputs_of(case))
    point = judge_verdict_and_time(case, run)
    judge_collisions(case, run, point)
    judge_contact(point)
    names = ("h1", "h2", "theta", "u1", "u2", "omega")
    judge_state(
        case,
        dict(zip(names, (*run.gaps, run.theta, *run.rates, run.omega), strict=True)),
    )
    assert run.q is None
    assert run.qdot is None


@pytest.mark.parametrize("case", FULL, ids=lambda c: f"{c['id']}-{c['family']}")
def test_full_reference(case):
    run = simulate_full(inputs_of(case))
    point = judge_verdict_and_time(case, run)
    judge_collisions(case, run, point)
    judge_contact(point)
    names = (*("r_x", "r_y", "theta"), *("v_x", "v_y", "omega"), "h1", "h2", "u1", "u2")
    values = (*point.q, *point.qdot, *point.gaps, *point.gap_rates)
    judge_state(case, dict(zip(names, values, strict=True)))
