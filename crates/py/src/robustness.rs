//! How hard a posture may be kicked.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::robustness::{Level, Robustness, RobustnessOptions, robustness_until};
use standfast::simulate::Resources;
use standfast::{Options, Posture};

use crate::convert::{array, question};
use crate::files::write_whole;
use crate::input;
use crate::interrupt::interruptible;
use crate::mechanism::body;
use crate::options;
use crate::posture::PyPosture;

/// What a posture withstands: the share of random kicks of each size from which the body comes back.
/// `standfast.robustness` returns it and says what comes back means. k is the number of sizes.
///
/// `print(result)` shows a table, `result.plot()` a picture.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> box = sf.Posture.box(0.3, 0.5, friction=0.5, restitution=0.3)
/// >>> result = sf.robustness(box, [0.1, 1.0], trials=200)
/// >>> result
/// <Robustness: 200 kicks of each size; back from 200 at 0.1 m/s, 182 at 1.0 m/s; 110 with warnings>
/// >>> runs = sf.simulate_many(box, (0, 0, 0), result.qdot[1], **result.options)
/// >>> bool((runs.outcome == "rest").sum() == result.rest[1])
/// True
#[pyclass(frozen, name = "Robustness", module = "standfast.results")]
pub(crate) struct PyRobustness {
    posture: Posture,
    options: RobustnessOptions,
    found: Robustness,
}

impl PyRobustness {
    fn numbers<'py>(
        &self,
        py: Python<'py>,
        number: impl Fn(&Level) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        self.found.levels.iter().map(number).collect::<Vec<_>>().into_pyarray(py)
    }

    fn counts<'py>(
        &self,
        py: Python<'py>,
        count: impl Fn(&Level) -> usize,
    ) -> Bound<'py, PyArray1<i64>> {
        let counts = self.found.levels.iter().map(|level| count(level) as i64);
        counts.collect::<Vec<_>>().into_pyarray(py)
    }
}

#[pymethods]
impl PyRobustness {
    /// Sizes of the kicks, (k,) m/s.
    #[getter]
    fn sizes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |level| level.size)
    }

    /// Sizes over √(gravity · size of the body), (k,). The size of the body is the distance of its farthest contact from the centre of mass,
    /// or the radius of gyration if this is larger. inf without gravity.
    #[getter]
    fn relative_sizes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |level| level.relative_size)
    }

    /// Share of the kicks of each size from which the body comes back, (k,).
    #[getter]
    fn share<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |level| level.share)
    }

    /// Low and high end of an interval for the probability that the body comes back, with a confidence of 95 % (Wilson 1927), (k, 2).
    #[getter]
    fn interval<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let ends = self.found.levels.iter().flat_map(|level| level.interval).collect();
        array(py, ends, &[self.found.levels.len(), 2])
    }

    /// Number of kicks of each size after which the body comes to rest, back in its stance or elsewhere, (k,).
    #[getter]
    fn rest<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.counts(py, Level::rest)
    }

    /// Number of runs with each outcome of `Run.outcome` that occurs, by its name: arrays (k,).
    #[getter]
    fn outcomes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let found = PyDict::new(py);
        for outcome in standfast::Outcome::ALL {
            let count = |level: &Level| level.outcomes.get(&outcome).copied().unwrap_or(0);
            if self.found.levels.iter().any(|level| count(level) > 0) {
                found.set_item(outcome.as_str(), self.counts(py, count))?;
            }
        }
        Ok(found)
    }

    /// Number of runs with warnings, by size, (k,).
    #[getter]
    fn warned<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.counts(py, |level| level.warned)
    }

    /// The warnings of the first run that has any.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.found.warnings.clone()
    }

    /// Largest displacement √(x² + y² + ρ²θ²) at rest of a body that has come back from a kick of this size, (k,) m; nan if none has.
    #[getter]
    fn largest_displacement<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |level| level.largest_displacement.unwrap_or(f64::NAN))
    }

    /// Whether the body comes back from each kick of each size, (k, trials).
    #[getter]
    fn returned<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<bool>>> {
        let all = self.found.levels.iter().flat_map(|level| level.returned.iter().copied());
        let shape = [self.found.levels.len(), self.found.trials];
        Ok(all.collect::<Vec<_>>().into_pyarray(py).reshape(shape)?.to_dyn().clone())
    }

    /// Directions of the kicks, the same for all sizes: unit vectors of (ẋ, ẏ, ρθ̇), (trials, 3).
    #[getter]
    fn kicks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let all = self.found.kicks.iter().flatten().copied().collect();
        array(py, all, &[self.found.trials, 3])
    }

    /// The kicks as velocities (ẋ, ẏ, θ̇), (k, trials, 3) m/s and rad/s: size times kick, the third component over the radius of gyration.
    #[getter]
    fn qdot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let states =
            (0..self.found.levels.len()).flat_map(|k| self.found.velocities(k, &self.posture));
        array(py, states.flatten().collect(), &[self.found.levels.len(), self.found.trials, 3])
    }

    /// Number of kicks of each size.
    #[getter]
    fn trials(&self) -> usize {
        self.found.trials
    }

    /// Seed of the directions.
    #[getter]
    fn seed(&self) -> u64 {
        self.found.seed
    }

    /// The contacts that touch in the posture, by their numbers from 1.
    #[getter]
    fn contacts(&self) -> Vec<usize> {
        self.found.contacts.iter().map(|contact| contact.number()).collect()
    }

    /// The posture.
    #[getter]
    fn posture(&self) -> PyPosture {
        PyPosture(self.posture.clone())
    }

    /// The options of the runs: keywords of `simulate`; impact is the law that acted.
    #[getter]
    fn options<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        options::get(py, &Options { impact: self.found.impact, ..self.options.run })
    }

    /// Draws the share over the size of the kicks, with its interval.
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

    /// The result as plain dictionaries, lists and numbers, without the single kicks, which follow from
    /// seed and trials.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.found.to_json(),))
    }

    /// Writes the result as JSON.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file.
    fn to_json(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        write_whole(py, path, self.found.to_json().into_bytes())
    }

    #[allow(clippy::type_complexity, reason = "a function and its arguments")]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (PyPosture, Bound<'py, PyArray1<f64>>))> {
        let keywords = self.options(py)?;
        for fixed in NO_OPTIONS {
            keywords.del_item(fixed)?;
        }
        keywords.set_item("trials", self.found.trials)?;
        keywords.set_item("seed", self.found.seed)?;
        let again = question(py.import("standfast")?.getattr("robustness")?, &keywords)?;
        Ok((again, (self.posture(), self.sizes(py))))
    }

    /// Whether postures and results are the same.
    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| {
            let other = other.get();
            self.posture == other.posture && self.found == other.found
        })
    }

    fn __repr__(&self) -> String {
        let levels = &self.found.levels;
        let said = |level: &Level| {
            let back = level.returned.iter().filter(|returned| **returned).count();
            format!("{back} at {:?} m/s", level.size)
        };
        let of = match levels.as_slice() {
            [one] => format!("; back from {}", said(one)),
            [first, .., last] => {
                format!(" of each size; back from {}, {}", said(first), said(last))
            }
            [] => unreachable!("there is at least one size"),
        };
        let warned: usize = levels.iter().map(|level| level.warned).sum();
        let warned = if warned == 0 { String::new() } else { format!("; {warned} with warnings") };
        format!("<Robustness: {} kicks{of}{warned}>", self.found.trials)
    }

    fn __str__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.table")?.call_method1("robustness_table", (slf,))
    }
}

/// Options of a run that the kicks leave no choice of.
const NO_OPTIONS: [&str; 5] = ["stop", "time", "sensitivity_limit", "record", "certify"];

/// The computation of `standfast.robustness` at one posture.
///
/// Parameters
/// ----------
/// threads : int or None, default None
///     Number of threads; None uses every core.
/// done : callable or None, default None
///     None, or a function that is called from time to time with the number of kicks that have been
///     simulated since. The other arguments are those of `standfast.robustness`.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the keywords of the function in Python")]
#[pyo3(signature = (posture, sizes, *, trials=1000, seed=0, threads=None, done=None, **options), text_signature = "(posture, sizes, *, trials=1000, seed=0, threads=None, done=None, model=\"full\", impact=\"auto\", simultaneous=None, time_limit=None, event_limit=100_000, neighbourhood=1e999, edges=\"contact\", jams=\"none\")")]
pub(crate) fn robustness(
    py: Python<'_>,
    #[pyo3(from_py_with = body)] posture: PyPosture,
    #[pyo3(from_py_with = input::sizes)] sizes: Vec<f64>,
    #[pyo3(from_py_with = input::trials)] trials: usize,
    #[pyo3(from_py_with = input::seed)] seed: usize,
    #[pyo3(from_py_with = input::threads)] threads: Option<usize>,
    done: Option<Py<PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyRobustness> {
    let default = RobustnessOptions::default().run;
    let run = options::of_call("robustness", default, &NO_OPTIONS, options)?;
    let options = RobustnessOptions { trials, seed: seed as u64, run };
    let mut resources = Resources::default();
    resources.threads = threads.unwrap_or(resources.threads);
    let posture = posture.0.clone();
    // A progress bar that fails must not end the computation.
    let report = |count: usize| {
        if let Some(done) = &done {
            Python::attach(|py| {
                done.call1(py, (count,)).map_or_else(|e| e.write_unraisable(py, None), drop);
            });
        }
    };
    let found = interruptible(py, |cancel| {
        robustness_until(&posture, &sizes, &options, resources, cancel, &report)
    })?;
    Ok(PyRobustness { posture, options, found })
}
