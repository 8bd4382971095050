//! Many runs: arrays in, arrays out.

use numpy::{IntoPyArray, PyArray1, PyArrayDyn};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::excitation::{Excitation, Force, GroundMotion, Kick};
use standfast::outcome::{End, FirstZeno};
use standfast::simulate::{Resources, simulate_many_until};
use standfast::{Error, Options, Posture, Simulation, State};

use crate::convert::{array, question};
use crate::error::to_py;
use crate::excitation::{PyForce, PyGroundMotion, PyKick};
use crate::input;
use crate::interrupt::interruptible;
use crate::options;
use crate::posture::PyPosture;
use crate::run::{PyRun, interruptible_run};

/// The results of many runs, as arrays with one entry for each run. `runs[i]` repeats run i, with all
/// its events.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
/// >>> runs = sf.simulate_many(rod, q=[(0, 0.01, 0.001), (0, 0.01, 0.002)], qdot=(0, 0, 0))
/// >>> runs.outcome, runs.zeno_kind
/// (array(['rest', 'rest'], dtype='<U17'), array(['2-zeno', '2-zeno'], dtype='<U6'))
/// >>> bool(runs.time[1] == runs[1].time)
/// True
#[pyclass(frozen, name = "Runs", module = "standfast.results")]
pub(crate) struct PyRuns {
    postures: Vec<Posture>,
    states: Vec<State>,
    options: Options,
    /// One for all runs, or one for each.
    excitations: Vec<Excitation>,
    ends: Vec<End>,
}

impl PyRuns {
    fn numbers<'py>(
        &self,
        py: Python<'py>,
        number: impl Fn(&End) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        self.ends.iter().map(number).collect::<Vec<_>>().into_pyarray(py)
    }

    fn vectors<'py>(
        &self,
        py: Python<'py>,
        vector: impl Fn(&End) -> standfast::Vector3,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let values = self.ends.iter().flat_map(|end| <[f64; 3]>::from(vector(end))).collect();
        array(py, values, &[self.ends.len(), 3])
    }

    /// An array of words from their indices in a list.
    fn words<'py>(
        &self,
        py: Python<'py>,
        words: Vec<String>,
        place: impl Fn(&End) -> usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let places: Vec<i64> = self.ends.iter().map(|end| place(end) as i64).collect();
        let words = py.import("numpy")?.call_method1("array", (words,))?;
        words.call_method1("take", (places.into_pyarray(py),))
    }

    fn run(&self, py: Python<'_>, i: usize) -> PyResult<PyRun> {
        let posture = self.postures.get(i).unwrap_or(&self.postures[0]);
        let options = Options { record: true, ..self.options };
        interruptible_run(py, |cancel| {
            let excitation = self.excitations.get(i).unwrap_or(&self.excitations[0]);
            let start = self.states[i];
            Simulation { posture, start, options, excitation, cancel }.run()
        })
    }

    fn zeno(end: &End, number: impl Fn(&FirstZeno) -> f64) -> f64 {
        end.zeno.as_ref().map_or(f64::NAN, number)
    }
}

#[pymethods]
impl PyRuns {
    #[allow(clippy::type_complexity, reason = "a function and its arguments")]
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyAny>, Vec<[f64; 3]>, Vec<[f64; 3]>))> {
        let simulate = py.import("standfast")?.getattr("simulate_many")?;
        let keywords = options::get(py, &self.options)?;
        if !self.excitations.iter().all(Excitation::is_none) {
            let [first, ..] = &self.excitations[..] else { unreachable!("there is at least one") };
            let kicks: Vec<_> = first.kicks.iter().map(|kick| PyKick(*kick)).collect();
            keywords.set_item("kicks", kicks)?;
            let forces: Vec<_> = first.forces.iter().copied().map(PyForce).collect();
            keywords.set_item("forces", forces)?;
            let motion = |of: &Excitation| of.ground_motion.clone().map(PyGroundMotion);
            match &self.excitations[..] {
                [one] => keywords.set_item("ground_motion", motion(one))?,
                all => keywords
                    .set_item("ground_motion", all.iter().map(motion).collect::<Vec<_>>())?,
            }
        }
        let many = question(simulate, &keywords)?;
        let postures: Vec<_> = self.postures.iter().cloned().map(PyPosture).collect();
        let postures = match <[PyPosture; 1]>::try_from(postures) {
            Ok([posture]) => posture.into_pyobject(py)?.into_any(),
            Err(postures) => postures.into_pyobject(py)?,
        };
        let rows = |of: fn(&State) -> [f64; 3]| self.states.iter().map(of).collect();
        let (q, qdot) = (rows(|state| state.q.into()), rows(|state| state.qdot.into()));
        Ok((many, (postures, q, qdot)))
    }

    fn __len__(&self) -> usize {
        self.ends.len()
    }

    /// Repeats run i, recorded; the result is the same to the last bit.
    fn __getitem__(&self, py: Python<'_>, index: &Bound<'_, PyAny>) -> PyResult<PyRun> {
        self.run(py, input::run_index(index, self.ends.len())?)
    }

    /// How the runs ended, as in `Run.outcome`.
    #[getter]
    fn outcome<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let words = standfast::Outcome::ALL.map(|outcome| outcome.as_str().to_owned());
        let place = |end: &End| standfast::Outcome::ALL.iter().position(|one| *one == end.outcome);
        self.words(py, words.to_vec(), |end| place(end).unwrap_or(0))
    }

    /// Time on the clock when the outcome was reached, s.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |end| end.time)
    }

    /// Time from the start to the outcome, s, not rounded to the clock.
    #[getter]
    fn elapsed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |end| end.elapsed)
    }

    /// Final configurations, (N, 3) m, m, rad.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.vectors(py, |end| end.state.q)
    }

    /// Final velocities, (N, 3) m/s, m/s, rad/s.
    #[getter]
    fn qdot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.vectors(py, |end| end.state.qdot)
    }

    /// Numbers of collisions simulated one by one.
    #[getter]
    fn collisions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ends.iter().map(|end| end.collisions as i64).collect::<Vec<_>>().into_pyarray(py)
    }

    /// Kinds of the first Zeno points, "1-zeno", "2-zeno", …; "" where there is none.
    #[getter]
    fn zeno_kind<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let count = |end: &End| end.zeno.map_or(0, |zeno| zeno.count);
        let most = self.ends.iter().map(count).max().unwrap_or(0);
        let kinds = (1..=most).map(|count| format!("{count}-zeno"));
        self.words(py, std::iter::once(String::new()).chain(kinds).collect(), count)
    }

    /// The contact that comes to rest at the first Zeno point, from 1; 0 if several contacts do, or if there is no Zeno point.
    #[getter]
    fn zeno_contact<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let contact = |end: &End| end.zeno.and_then(|zeno| zeno.contact);
        let numbers = self.ends.iter().map(|end| contact(end).map_or(0, |i| i.number() as i64));
        numbers.collect::<Vec<_>>().into_pyarray(py)
    }

    /// Times of the first Zeno points on the clock, s; NaN where there is none.
    #[getter]
    fn zeno_time<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |end| Self::zeno(end, |zeno| zeno.time))
    }

    /// Times of the first Zeno points since the start, s, not rounded to the clock.
    #[getter]
    fn zeno_elapsed<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |end| Self::zeno(end, |zeno| zeno.elapsed))
    }

    /// Whether each run has warnings; `runs[i].warnings` has their texts.
    #[getter]
    fn warned<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        self.ends.iter().map(|end| end.warned).collect::<Vec<_>>().into_pyarray(py)
    }

    /// The warnings of the first run that has any.
    #[getter]
    fn warnings(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        match self.ends.iter().position(|end| end.warned) {
            Some(first) => Ok(self.run(py, first)?.warnings()),
            None => Ok(Vec::new()),
        }
    }

    /// The law of impact of each run, (N,): with impact="auto" the one that acted.
    #[getter]
    fn impact<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let law = |posture: &Posture| crate::convert::word(&self.options.law(posture));
        let laws: Vec<String> = self.postures.iter().map(law).collect();
        let each = (0..self.ends.len()).map(|i| laws.get(i).unwrap_or(&laws[0]).as_str());
        py.import("numpy")?.call_method1("array", (each.collect::<Vec<_>>(),))
    }

    fn __repr__(&self) -> String {
        let warned = self.ends.iter().filter(|end| end.warned).count();
        let warned = if warned == 0 { String::new() } else { format!(", {warned} with warnings") };
        format!("<Runs: {}{warned}>", self.ends.len())
    }
}

/// Bytes per run: its start as given and as used, its end, and its results.
const RUN: usize = 512;

/// `count` states: one per row, or one for all.
fn rows(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 3]>> {
    let array = input::triples(field, value)?;
    let array = array.as_array();
    if array.ndim() > 2 {
        return Err(to_py(&Error::Unusable {
            field: field.into(),
            value: format!("array of shape {:?}", array.shape()),
            allowed: "an array of shape (N, 3), or (3,) for the same in each run".into(),
        }));
    }
    // A failing allocation later would end the process.
    let runs = array.len() / 3;
    if Vec::<[u8; RUN]>::new().try_reserve_exact(runs).is_err() {
        return Err(PyMemoryError::new_err(format!("{runs} runs take {RUN} bytes each")));
    }
    let row = |row: &[f64]| [row[0], row[1], row[2]];
    Ok(match array.as_slice() {
        Some(numbers) => numbers.chunks_exact(3).map(row).collect(),
        None => array.iter().copied().collect::<Vec<_>>().chunks_exact(3).map(row).collect(),
    })
}

/// The postures of an argument: one, or a sequence.
fn postures(value: &Bound<'_, PyAny>) -> PyResult<Vec<Posture>> {
    if let Ok(posture) = value.cast::<PyPosture>() {
        return Ok(vec![posture.get().0.clone()]);
    }
    let items = value.try_iter().map_err(|_| input::no_posture(value))?;
    items
        .enumerate()
        .map(|(i, item)| {
            let item = item?;
            let posture = item.cast::<PyPosture>().map_err(|_| input::wrong_item(i, &item))?;
            Ok(posture.get().0.clone())
        })
        .collect()
}

/// Repeats a single value for all runs, and checks the number of values.
fn spread<T: Copy>(field: &str, values: Vec<T>, count: usize) -> PyResult<Vec<T>> {
    match values.len() {
        length if length == count => Ok(values),
        1 => Ok(vec![values[0]; count]),
        length => Err(to_py(&Error::Unusable {
            field: field.into(),
            value: format!("[{length} rows]"),
            allowed: format!("one for each of {count} runs, or one for all"),
        })),
    }
}

/// The motions of many postures, or of one posture from many states.
///
/// Each run has the same result, to the last bit, as a call of `simulate`, with any number of threads.
///
/// Parameters
/// ----------
/// posture : Posture or sequence of N Postures
/// q, qdot : (N, 3) or (3,) array_like
///     Start of each run, or the same in each run: m, m, rad and per second.
/// kicks, forces : sequence of Kick, of Force, default ()
///     As for `simulate`, the same in each run.
/// ground_motion : GroundMotion, sequence of GroundMotion or None, default None
///     The same in each run, or a sequence of N of them.
/// model, impact, simultaneous, stop, time, time_limit, event_limit, sensitivity_limit, neighbourhood, edges, jams : see simulate
///     As for `simulate`.
/// record, certify : bool, default False
///     They have no effect here: use runs[i], which repeats run i with all its events.
/// threads : int or None, default None
///     Number of threads; None uses every core, with at least 16 runs for each.
///
/// Returns
/// -------
/// Runs
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range, and the first run with a wrong value, from
///     0.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the keywords of the function in Python")]
#[pyo3(signature = (posture, q, qdot, *, kicks=Vec::new(), forces=Vec::new(), ground_motion=vec![None], threads=None, **options), text_signature = "(posture, q, qdot, *, kicks=(), forces=(), ground_motion=None, model=\"auto\", impact=\"auto\", simultaneous=None, stop=\"rest\", time=0.0, time_limit=None, event_limit=1_000_000, sensitivity_limit=None, neighbourhood=1e999, edges=\"contact\", jams=\"none\", record=False, certify=False, threads=None)")]
pub(crate) fn simulate_many(
    py: Python<'_>,
    posture: &Bound<'_, PyAny>,
    q: &Bound<'_, PyAny>,
    qdot: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = crate::excitation::kicks)] kicks: Vec<Kick>,
    #[pyo3(from_py_with = crate::excitation::forces)] forces: Vec<Force>,
    #[pyo3(from_py_with = crate::excitation::ground_motions)] ground_motion: Vec<
        Option<GroundMotion>,
    >,
    #[pyo3(from_py_with = input::threads)] threads: Option<usize>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyRuns> {
    let unrecorded = Options { record: false, ..Options::default() };
    let options = options::of_call("simulate_many", unrecorded, &[], options)?;
    if options.certify {
        return Err(to_py(&Error::Unusable {
            field: "certify".into(),
            value: "True".into(),
            allowed: "False: runs[i] computes run i again, with all its events".into(),
        }));
    }
    let one = posture.cast::<PyPosture>().is_ok();
    let postures = postures(posture)?;
    let (q, qdot) = (rows("q", q)?, rows("qdot", qdot)?);
    // The first of these that has not one entry for all runs tells their number.
    let counts = [q.len(), qdot.len(), ground_motion.len()];
    let count = if one {
        counts.into_iter().find(|count| *count != 1).unwrap_or(1)
    } else {
        postures.len()
    };
    let (q, qdot) = (spread("q", q, count)?, spread("qdot", qdot, count)?);
    let states: Vec<State> = q.iter().zip(&qdot).map(|(q, v)| State::new(*q, *v)).collect();
    drop((q, qdot));
    let mut resources = Resources::default();
    resources.threads = threads.unwrap_or(resources.threads);
    let excited = |ground_motion| {
        let (kicks, forces) = (kicks.clone(), forces.clone());
        Excitation { kicks, forces, ground_motion }
    };
    let excitations: Vec<Excitation> = ground_motion.into_iter().map(excited).collect();
    let ends = interruptible(py, |cancel| {
        simulate_many_until(&postures, &states, &options, &excitations, resources, cancel)
    })?;
    Ok(PyRuns { postures, states, options, excitations, ends })
}
