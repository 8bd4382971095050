//! Sweeps over grids of parameters: ranges of points as arrays.

use numpy::{IntoPyArray, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use standfast::body::HoldingChoice;
use standfast::options::Jams;
use standfast::stability::DEFAULT_WIDTH;
use standfast::sweep::{Axis, Column, Quantity, Sweep, ValueKind, grid_size};
use standfast::{Error, Options, State};

use crate::chain::PyChain;
use crate::convert::{vector, word};
use crate::error::to_py;
use crate::holding::choice;
use crate::input;
use crate::interrupt::interruptible;
use crate::options::{get, set};
use crate::posture::{PyPosture, posture};

/// What has the parameters; a chain with its configuration, and the torques that its joints have instead of their own.
enum Subject {
    Body(PyPosture),
    Chain(PyChain, Vec<f64>, Option<HoldingChoice>),
}

impl Subject {
    fn axis(&self, path: &str, values: Vec<f64>) -> Result<Axis, Error> {
        match self {
            Self::Body(of) => Axis::new(path, values, &of.0),
            Self::Chain(of, q, _) => Axis::of_chain(path, values, &of.0, q),
        }
    }

    fn sweep(&self, axes: Vec<Axis>, asked: Vec<Quantity>) -> Result<Sweep, Error> {
        match self {
            Self::Body(of) => Sweep::new(&of.0, axes, asked),
            Self::Chain(of, q, hold) => Sweep::of_chain(&of.0, q, *hold, axes, asked),
        }
    }
}

/// The computation of `standfast.sweep`: quantities of a posture over a grid of its parameters, or of a
/// chain in the configuration q; hold : its joints have these torques of holding_torques, "middle" or
/// "least"; None: their own.
///
/// Parameters
/// ----------
/// over : sequence of (str, array_like)
///     Pairs (path, values); the last one varies fastest.
/// quantities : sequence of str
///     Their names.
/// q, qdot, options : array_like or None, default None
///     Start and options of the runs for "fate" and "zeno_time".
///
/// Examples
/// --------
/// >>> from standfast import Posture
/// >>> from standfast._core import Sweep
/// >>> rod = Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
/// >>> sweep = Sweep(rod, [("gyration_radius", [0.2, 0.5])], ["theorem_3"])
/// >>> sweep.run(0, sweep.size)
/// [array([ True, False])]
#[pyclass(frozen, name = "Sweep", module = "standfast._core")]
pub(crate) struct PySweep {
    of: Subject,
    axes: Vec<Axis>,
    names: Vec<String>,
    quantities: Vec<Quantity>,
    start: Option<(State, Options)>,
    jams: Jams,
    width: f64,
    sweep: Sweep,
}

#[pymethods]
impl PySweep {
    #[new]
    #[pyo3(signature = (posture, over, quantities, q=None, qdot=None, options=None, jams=None, hold=None, width=DEFAULT_WIDTH), text_signature = "(posture, over, quantities, q=None, qdot=None, options=None, jams=None, hold=None, width=1e-12)")]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    fn new(
        posture: &Bound<'_, PyAny>,
        over: Vec<(String, Bound<'_, PyAny>)>,
        quantities: Vec<String>,
        q: Option<&Bound<'_, PyAny>>,
        qdot: Option<&Bound<'_, PyAny>>,
        options: Option<&Bound<'_, PyDict>>,
        jams: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = choice_or_none)] hold: Option<HoldingChoice>,
        #[pyo3(from_py_with = input::width)] width: f64,
    ) -> PyResult<Self> {
        let jams = jams.map_or(Ok(Jams::None), crate::options::jams)?;
        let of = match posture.cast::<PyChain>() {
            Ok(chain) => {
                let Some(q) = q else { return Err(input::no_configuration()) };
                Subject::Chain(chain.get().clone(), input::coordinates(q)?, hold)
            }
            Err(_) => {
                let body = self::posture(posture);
                let needed = |_: PyErr| {
                    input::wrong_type("posture", posture, "a Posture or a Chain is needed")
                };
                Subject::Body(body.map_err(needed)?)
            }
        };
        if matches!(of, Subject::Chain(..)) && (qdot.is_some() || options.is_some()) {
            return Err(input::no_runs_of_chains());
        }
        let q = if matches!(of, Subject::Body(_)) { q } else { None };
        // Checked before any values are copied.
        let lengths: Vec<usize> =
            over.iter().map(|(_, values)| values.len().unwrap_or(1)).collect();
        grid_size(&lengths).map_err(|e| to_py(&e))?;
        let axes = over.iter().map(|(path, values)| {
            let values = input::series(path, values)?;
            of.axis(path, values).map_err(|e| to_py(&e))
        });
        let axes = axes.collect::<PyResult<Vec<_>>>()?;
        let parsed = quantities.iter().map(|name| Quantity::parse(name).map_err(|e| to_py(&e)));
        let asked = parsed.collect::<PyResult<Vec<_>>>()?;
        let mut sweep = of.sweep(axes.clone(), asked.clone()).map_err(|e| to_py(&e))?;
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
        sweep = sweep.with_jams(jams).with_width(width).map_err(|e| to_py(&e))?;
        Ok(Self {
            jams,
            width,
            of,
            axes,
            names: quantities,
            quantities: asked,
            start: given,
            sweep,
        })
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

    /// The quantities at the points from `start` up to `stop`, an array for each: bool, float64, or uint8
    /// codes of words.
    ///
    /// Parameters
    /// ----------
    /// threads : int or None, default None
    ///     Number of threads; None uses every core.
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
            q = Some(vector(py, &state.q).into_any());
            qdot = Some(vector(py, &state.qdot));
            options = Some(get(py, chosen)?);
        }
        let (of, hold) = match &self.of {
            Subject::Body(posture) => (posture.clone().into_pyobject(py)?.into_any(), None),
            Subject::Chain(chain, configuration, hold) => {
                q = Some(configuration.to_pyarray(py).into_any());
                (chain.clone().into_pyobject(py)?.into_any(), hold.as_ref().map(word))
            }
        };
        let (names, jams) = (self.names.clone(), word(&self.jams));
        let arguments =
            (of, over, names, q, qdot, options, jams, hold, self.width).into_pyobject(py)?;
        Ok((py.get_type::<Self>().into_any(), arguments))
    }
}

/// Reads "middle", "least" or None.
fn choice_or_none(value: &Bound<'_, PyAny>) -> PyResult<Option<HoldingChoice>> {
    if value.is_none() { Ok(None) } else { choice(value).map(Some) }
}
