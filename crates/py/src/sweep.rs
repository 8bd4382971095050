//! Sweeps over grids of parameters: ranges of points as arrays.

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use standfast::options::Jams;
use standfast::sweep::{Axis, Column, Quantity, Sweep, ValueKind, grid_size};
use standfast::{Options, State};

use crate::convert::{vector, word};
use crate::error::to_py;
use crate::input;
use crate::interrupt::interruptible;
use crate::options::{get, set};
use crate::posture::{PyPosture, posture};

/// The computation of `standfast.sweep`: quantities of a posture over a grid of its parameters.
///
/// over : pairs (path, values); the last one varies fastest. quantities : their names. q, qdot, options : start and options of
/// the runs for "fate" and "zeno_time".
///
/// >>> from standfast import Posture
/// >>> from standfast._core import Sweep
/// >>> rod = Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
/// >>> sweep = Sweep(rod, [("gyration_radius", [0.2, 0.5])], ["theorem_3"])
/// >>> sweep.run(0, sweep.size)
/// [array([ True, False])]
#[pyclass(frozen, name = "Sweep", module = "standfast._core")]
pub(crate) struct PySweep {
    posture: PyPosture,
    axes: Vec<Axis>,
    names: Vec<String>,
    quantities: Vec<Quantity>,
    start: Option<(State, Options)>,
    jams: Jams,
    sweep: Sweep,
}

#[pymethods]
impl PySweep {
    #[new]
    #[pyo3(signature = (posture, over, quantities, q=None, qdot=None, options=None, jams=None))]
    fn new(
        #[pyo3(from_py_with = posture)] posture: PyPosture,
        over: Vec<(String, Bound<'_, PyAny>)>,
        quantities: Vec<String>,
        q: Option<&Bound<'_, PyAny>>,
        qdot: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
        jams: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let jams = jams.map_or(Ok(Jams::None), crate::options::jams)?;
        let posture = posture.clone();
        // Checked before any values are copied.
        let lengths: Vec<usize> =
            over.iter().map(|(_, values)| values.len().unwrap_or(1)).collect();
        grid_size(&lengths).map_err(|e| to_py(&e))?;
        let axes = over.iter().map(|(path, values)| {
            let values = input::series(path, values)?;
            Axis::new(path, values, &posture.0).map_err(|e| to_py(&e))
        });
        let axes = axes.collect::<PyResult<Vec<_>>>()?;
        let parsed = quantities.iter().map(|name| Quantity::parse(name).map_err(|e| to_py(&e)));
        let asked = parsed.collect::<PyResult<Vec<_>>>()?;
        let mut sweep =
            Sweep::new(&posture.0, axes.clone(), asked.clone()).map_err(|e| to_py(&e))?;
        let mut chosen = Options::default();
        let given = match (q, qdot, options) {
            (Some(q), Some(qdot), options) => {
                if let Some(keywords) = options {
                    set(&mut chosen, keywords)?;
                }
                Some((State::new(input::q(q)?, input::qdot(qdot)?), chosen))
            }
            (None, None, None) => None,
            _ => return Err(input::incomplete_start()),
        };
        if sweep.needs_start() != given.is_some() {
            return Err(input::start_or_not(sweep.needs_start()));
        }
        if let Some((state, options)) = given {
            sweep = sweep.from_start(state, options).map_err(|e| to_py(&e))?;
        }
        sweep = sweep.with_jams(jams);
        Ok(Self { jams, posture, axes, names: quantities, quantities: asked, start: given, sweep })
    }

    /// Number of points.
    #[getter]
    fn size(&self) -> usize {
        self.sweep.size()
    }

    /// For each quantity the list of words that its codes stand for; None for flags and numbers.
    #[getter]
    fn words<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let words = self.quantities.iter().map(|quantity| match quantity.kind() {
            ValueKind::Word(words) => Some(words.to_vec()),
            ValueKind::Flag | ValueKind::Number => None,
        });
        PyList::new(py, words)
    }

    /// The quantities at the points from `start` up to `stop`, an array for each: bool, float64, or uint8 codes of words.
    /// threads : number of threads; None uses every core.
    #[pyo3(signature = (start, stop, threads=None))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = input::from_point)] start: usize,
        #[pyo3(from_py_with = input::to_point)] stop: usize,
        #[pyo3(from_py_with = input::threads)] threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyList>> {
        if start > stop || stop > self.sweep.size() {
            return Err(input::no_range(start, stop, self.sweep.size()));
        }
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let threads = threads.unwrap_or_else(cores);
        let columns = interruptible(py, |cancel| self.sweep.run(start..stop, threads, cancel))?;
        let arrays = columns.into_iter().map(|column| match column {
            Column::Flags(values) => values.into_pyarray(py).into_any(),
            Column::Numbers(values) => values.into_pyarray(py).into_any(),
            Column::Words { codes, .. } => codes.into_pyarray(py).into_any(),
        });
        PyList::new(py, arrays)
    }

    fn __repr__(&self) -> String {
        let axes: Vec<String> = self.axes.iter().map(ToString::to_string).collect();
        format!("<Sweep: {} over {}>", self.names.join(", "), axes.join(" and "))
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let over: Vec<_> = self
            .axes
            .iter()
            .map(|axis| (axis.path(), axis.values().to_vec().into_pyarray(py)))
            .collect();
        let (mut q, mut qdot, mut options) = (None, None, None);
        if let Some((state, chosen)) = &self.start {
            (q, qdot) = (Some(vector(py, &state.q)), Some(vector(py, &state.qdot)));
            options = Some(get(py, chosen)?);
        }
        let posture = self.posture.clone();
        let jams = word(&self.jams);
        let arguments =
            (posture, over, self.names.clone(), q, qdot, options, jams).into_pyobject(py)?;
        Ok((py.get_type::<Self>().into_any(), arguments))
    }
}
