"""Runs as tables: the motion over time as an xarray.Dataset, and the impacts as columns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from standfast import _core
from standfast._core import Run

if TYPE_CHECKING:
    import xarray

#: Names of the coordinates of a body, and their units.
BODY = ["x", "y", "theta"]
#: Number of times of a dataset besides the events.
SAMPLES = 1000


def impact_table(run: Run) -> dict[str, npt.NDArray[Any]]:
    """The impacts of a run as one-dimensional columns; see `Run.impact_table`."""
    hits = run.impacts
    columns = {name: hits[name] for name in ("time", "elapsed", "contact")}
    hit = np.arange(len(hits)), hits["index"]
    if run.posture is not None:
        points = run.points_at(hits["time"])[hit]
        columns |= {"x": points[:, 0], "y": points[:, 1]}
    for when in ("before", "after"):
        columns[f"rate_{when}"] = _with_sides(run, hits[f"rates_{when}"])[hit]
    for k, name in enumerate(("tangential", "normal")):
        columns[f"impulse_{name}"] = hits["impulse"][:, k]
    return {name: column.copy() for name, column in columns.items()}


def _with_sides(run: Run, values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Values (k, n) of the contacts of the posture as those of all contacts of the run: NaN of sides, which have no gaps."""
    more = np.full((len(values), len(run.contacts) - len(run.gaps)), np.nan)
    return np.hstack([values, more])


def _times(run: Run) -> npt.NDArray[np.float64]:
    bounds = [t for phase in run.phases for t in (phase.start, phase.end)]
    return np.unique(
        np.concatenate([run.sample(SAMPLES)[0], run.impacts["time"], bounds])
    )


def to_xarray(run: Run, t: npt.ArrayLike | None = None) -> xarray.Dataset:
    """The motion of a run over time; see `Run.to_xarray`."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError("to_xarray needs xarray: pip install xarray") from error
    times = np.asanyarray(_times(run) if t is None else t)
    if times.ndim != 1:
        raise ValueError(
            f"t = array of shape {times.shape} cannot be used: times in one dimension are allowed"
        )
    q, qdot = run.at(times)
    gaps = _with_sides(run, run.gaps_at(times))
    rates = _with_sides(run, run.gap_rates_at(times))
    starts = [phase.start for phase in run.phases]
    letters = np.array([list(phase.mode) for phase in run.phases])
    mode = letters[np.searchsorted(starts, times, side="right") - 1]
    jointed = run.mechanism is not None
    variables = {
        "q": (
            "coordinate",
            q,
            "displacement of the coordinates"
            if jointed
            else "displacement of the centre of mass, rotation",
            None if jointed else "m, m, rad",
        ),
        "qdot": (
            "coordinate",
            qdot,
            "velocity",
            None if jointed else "m/s, m/s, rad/s",
        ),
        "gaps": ("contact", gaps, "gap", "m"),
        "rates": ("contact", rates, "gap rate", "m/s"),
        "points": (
            "contact axis",
            run.points_at(times),
            "position of the contact point",
            "m",
        ),
        "forces": ("contact direction", run.forces_at(times), "contact force", "N"),
        "mode": (
            "contact",
            mode,
            "contact mode: S separate, F fixed, R or L sliding right or left",
            None,
        ),
    }
    about = {
        "outcome": run.outcome,
        "model": run.model,
        "model_reason": run.model_reason,
        "standfast": _core.__version__,
    }
    if run.posture is not None:
        about["posture"] = repr(run.posture)
    if jointed:
        about["mechanism"] = repr(run.mechanism)
    return xarray.Dataset(
        {
            name: (["time", *dimensions.split()], values, _attributes(text, unit))
            for name, (dimensions, values, text, unit) in variables.items()
        },
        {
            "time": ("time", times, _attributes("time on the clock", "s")),
            "coordinate": np.arange(q.shape[1]) if jointed else BODY,
            "contact": np.arange(1, gaps.shape[1] + 1),
            "axis": ["x", "y"],
            "direction": ["tangential", "normal"],
        },
        about,
    )


def _attributes(text: str, unit: str | None) -> dict[str, str]:
    return {"long_name": text} | ({"units": unit} if unit else {})
