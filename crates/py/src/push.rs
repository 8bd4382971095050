//! The smallest push from which a body does not come back.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::excitation::GroundMotion;
use standfast::push::{Push, PushOptions, SmallestPush, smallest_push_until};
use standfast::simulate::Resources;
use standfast::{Error, Outcome, Posture};

use crate::convert::float;
use crate::error::to_py;
use crate::input;
use crate::interrupt::interruptible;
use crate::mechanism::body;
use crate::options;
use crate::posture::PyPosture;

/// The pushes from which a body does not come back. `standfast.smallest_push` returns it. k is the
/// number of intervals.
///
/// Sizes are in `unit`: N s of kicks, N of forces that last, 1 of the scale of a motion of the ground.
/// `result.plot()` draws them.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> box = sf.Posture.box(1, 2, friction=2)
/// >>> sf.smallest_push(box, point=(0, 2))
/// <SmallestPush: from 0.98231 N s on the body does not come back; tried up to 13.24714 N s>
#[pyclass(frozen, name = "SmallestPush", module = "standfast.results")]
pub(crate) struct PySmallestPush {
    posture: Posture,
    push: Push,
    found: SmallestPush,
}

impl PySmallestPush {
    fn smallest(&self) -> Option<f64> {
        self.found.intervals.first().map(|interval| interval[0])
    }
}

#[pymethods]
impl PySmallestPush {
    /// The smallest kick from which the body does not come back, in N s; None if there is none up to `at_most`, or if no kick was asked for.
    #[getter]
    fn impulse(&self) -> Option<f64> {
        self.smallest().filter(|_| matches!(self.push, Push::Kick { .. }))
    }

    /// The smallest force that lasts, in N; None as for `impulse`.
    #[getter]
    fn force(&self) -> Option<f64> {
        self.smallest().filter(|_| matches!(self.push, Push::Force { .. }))
    }

    /// The smallest factor of the motion of the ground; None as for `impulse`.
    #[getter]
    fn scale(&self) -> Option<f64> {
        self.smallest().filter(|_| matches!(self.push, Push::Record(_)))
    }

    /// (k, 2): intervals of sizes from which the body does not come back. Beyond an end that is `at_most` nothing is known.
    #[getter]
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows: Vec<Vec<f64>> = self.found.intervals.iter().map(|ends| ends.to_vec()).collect();
        if rows.is_empty() {
            return Ok(PyArray2::zeros(py, [0, 2], false));
        }
        Ok(PyArray2::from_vec2(py, &rows)?)
    }

    /// The largest size that was tried.
    #[getter]
    fn at_most(&self) -> f64 {
        self.found.at_most
    }

    /// The unit of sizes: "N s", "N" or "".
    #[getter]
    fn unit(&self) -> &'static str {
        match self.push {
            Push::Kick { .. } => "N s",
            Push::Force { .. } => "N",
            Push::Record(_) => "",
        }
    }

    /// The sizes of the scan, (n,).
    #[getter]
    fn sizes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.found.sizes.clone().into_pyarray(py)
    }

    /// (n,) bool: whether the body comes back from each of these.
    #[getter]
    fn came_back<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.found.came_back.clone().into_pyarray(py)
    }

    /// How the run with the smallest push ends, a word as `run.outcome`: "rest", elsewhere; "inconsistent", if no motion exists because a
    /// contact jams. None if the body comes back from all.
    #[getter]
    fn outcome(&self) -> Option<String> {
        self.found.outcome.map(|outcome| outcome.to_string())
    }

    /// The posture that was pushed.
    #[getter]
    fn posture(&self) -> PyPosture {
        PyPosture(self.posture.clone())
    }

    /// Draws the sizes from which the body does not come back.
    ///
    /// Parameters
    /// ----------
    /// path : path_like or None, default None
    ///     File of the new figure; the suffix determines the format.
    /// ax : matplotlib Axes or None, default None
    ///
    /// Returns
    /// -------
    /// matplotlib Figure or Axes
    ///     The matplotlib.figure.Figure, or `ax` if it is given.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For a suffix that is no picture format, and for both `path` and `ax`.
    /// TypeError
    ///     If `ax` is no axes.
    /// OSError
    ///     If the file cannot be written.
    /// ImportError
    ///     Without matplotlib (extra `plot`).
    #[pyo3(signature = (path=None, *, ax=None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        path: Option<PathBuf>,
        ax: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.kicks_plot")?.call_method1("plot", (slf, path, ax))
    }

    fn __repr__(&self) -> String {
        let unit = match self.unit() {
            "" => " times the record".into(),
            unit => format!(" {unit}"),
        };
        let most = float((self.found.at_most * 1e5).round() / 1e5);
        match self.smallest() {
            Some(size) => {
                let end = match self.found.outcome {
                    Some(Outcome::Rest) | None => String::new(),
                    Some(outcome) => format!(" (the run is {outcome})"),
                };
                format!(
                    "<SmallestPush: from {size:.5}{unit} on the body does not come back{end}; tried up to {most}{unit}>"
                )
            }
            None => format!("<SmallestPush: the body comes back from all up to {most}{unit}>"),
        }
    }
}

/// Options of a run that a push leaves no choice of.
const NO_OPTIONS: [&str; 4] = ["stop", "sensitivity_limit", "record", "certify"];

/// The smallest push from which a body does not come back, by a scan and by bisection, on all cores.
///
/// The push acts on the body at rest in its posture. What comes back means is said at `robustness`: it
/// comes to rest on the same contacts. Larger pushes may be harmless again, because the body lands on
/// its feet: `intervals` has all that the scan finds.
///
/// Parameters
/// ----------
/// posture : Posture or Mechanism
///     At least one contact touches; all joints of a Mechanism are locked.
/// direction : (2,) array_like, default (1, 0)
///     Of any length.
/// point : (2,) array_like or None, m, default None
///     The point of the body that a kick acts on; None: the centre of mass.
/// duration : float or None, s, default None
///     If it is given, the push is a force through the centre of mass that lasts so long, and sizes are in N.
/// ground_motion : GroundMotion or None, default None
///     By accelerations. If it is given, it is multiplied by the size, and sizes are factors.
/// at_most : float or None, default None
///     The largest size that is tried; None: a kick that gives the velocity 4√(g · size of the
///     body), 4 times the weight and the force with this impulse, 4 times the record.
/// rtol : float, default 1e-9
///     Relative error of the ends.
/// scan : int, default 256
///     Number of sizes, equally spaced; a shorter interval may be missed.
/// threads : int or None, default None
///     None uses every core.
/// model, impact, simultaneous, time, time_limit, event_limit, neighbourhood, edges, jams : see simulate
///     As for `simulate`.
///
/// Returns
/// -------
/// SmallestPush
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range.
///
/// Examples
/// --------
/// >>> import math, standfast as sf
/// >>> box = sf.Posture.box(1, 2, friction=2)             # pushed at its top it turns about a corner, I = 5/3 kg m²
/// >>> exact = math.sqrt(2 * 9.81 * (math.sqrt(1.25) - 1) * 5 / 3) / 2
/// >>> abs(sf.smallest_push(box, point=(0, 2)).impulse / exact - 1) < 2e-9
/// True
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the keywords of the function in Python")]
#[pyo3(signature = (posture, direction=[1.0, 0.0], point=None, *, duration=None, ground_motion=None, at_most=None, rtol=1e-9, scan=256, threads=None, **options), text_signature = "(posture, direction=(1, 0), point=None, *, duration=None, ground_motion=None, at_most=None, rtol=1e-09, scan=256, threads=None, model=\"full\", impact=\"auto\", simultaneous=None, time=0.0, time_limit=None, event_limit=1_000_000, neighbourhood=1e999, edges=\"contact\", jams=\"none\")")]
pub(crate) fn smallest_push(
    py: Python<'_>,
    #[pyo3(from_py_with = body)] posture: PyPosture,
    #[pyo3(from_py_with = input::direction)] direction: [f64; 2],
    #[pyo3(from_py_with = input::some_point)] point: Option<[f64; 2]>,
    #[pyo3(from_py_with = input::duration)] duration: Option<f64>,
    #[pyo3(from_py_with = crate::excitation::ground_motion)] ground_motion: Option<GroundMotion>,
    #[pyo3(from_py_with = input::at_most)] at_most: Option<f64>,
    #[pyo3(from_py_with = input::rtol)] rtol: f64,
    #[pyo3(from_py_with = input::scan)] scan: usize,
    #[pyo3(from_py_with = input::threads)] threads: Option<usize>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PySmallestPush> {
    let run = PushOptions::default().run;
    let run = options::of_call("smallest_push", run, &NO_OPTIONS, options)?;
    let push = match (point, duration, ground_motion) {
        (point, None, None) => Push::Kick { direction, point },
        (None, Some(duration), None) => Push::Force { direction, duration },
        (None, None, Some(motion)) => Push::Record(motion),
        _ => {
            return Err(to_py(&Error::Unusable {
                field: "point, duration, ground_motion".into(),
                value: "more than one".into(),
                allowed: "at most one: a kick at a point, a force through the centre of mass that lasts, or a motion of the ground".into(),
            }));
        }
    };
    let options = PushOptions { at_most, scan, rtol, run };
    let mut resources = Resources::default();
    resources.threads = threads.unwrap_or(resources.threads);
    let posture = posture.0;
    let found = interruptible(py, |cancel| {
        smallest_push_until(&posture, &push, &options, resources, cancel)
    })?;
    Ok(PySmallestPush { posture, push, found })
}
