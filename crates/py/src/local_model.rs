//! The local model, given by its parameters.

use numpy::PyReadonlyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::body::{LocalModel, LocalModelFields, LocalState};
use standfast::simulate::simulate_local_until;
use standfast::stability::ReducedMap;
use standfast::{Error, Options};

use crate::convert::pair_text;
use crate::error::to_py;
use crate::input;
use crate::interrupt::interruptible;
use crate::options::of_call;
use crate::reduced::{Asked, PyExponents, PyFate, PyOrbit, fate_table};
use crate::run::{PyRun, interruptible_run};

/// Largest number of impacts of an orbit that is not stored: years of computing. Sums of such numbers stay in range.
const MOST_IMPACTS: usize = 1 << 52;
/// Default number of impacts that `fate` follows.
const FATE_IMPACTS: usize = 10_000;
/// Options of `simulate` that a local model does not take.
const OF_A_BODY: [&str; 5] = ["model", "impact", "neighbourhood", "edges", "jams"];
/// Number of states between two checks for Ctrl-C.
const STATES: usize = 256;

/// The motion of two gaps with a constant Jacobian and without friction (Or & Rimon 2008), given by its
/// parameters.
///
/// Parameters
/// ----------
/// gravity : (2,) array_like, m/s²
///     (g_1, g_2), negative where gravity points away from the ground.
/// psi : (2,) array_like
///     (ψ_1, ψ_2), coupling of the gap rates in an impact: both zero, or of one sign, with ψ_1ψ_2 ≤ 1.
/// phi : (2,) array_like, 1/m
///     (φ_1, φ_2), coupling of an impact to the rotation.
/// restitution : float or (2,) array_like, in [0, 1]
///     e, or (e_1, e_2).
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> local = sf.LocalModel(gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.1)
/// >>> run = local.simulate(gaps=(0.0, 0.1), rates=(0.1, -1.9), stop="zeno")
/// >>> run.zeno_points[0].kind
/// '2-zeno'
#[pyclass(frozen, eq, name = "LocalModel", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyLocalModel(pub(crate) LocalModel);

#[pymethods]
impl PyLocalModel {
    #[new]
    fn new(
        #[pyo3(from_py_with = input::gravities)] gravity: [f64; 2],
        #[pyo3(from_py_with = input::psi)] psi: [f64; 2],
        #[pyo3(from_py_with = input::phi)] phi: [f64; 2],
        #[pyo3(from_py_with = input::restitutions)] restitution: [f64; 2],
    ) -> PyResult<Self> {
        LocalModel::new(LocalModelFields { gravity, psi, phi, restitution })
            .map(Self)
            .map_err(|e| to_py(&e))
    }

    #[getter]
    fn gravity(&self) -> (f64, f64) {
        self.0.gravity().into()
    }

    #[getter]
    fn psi(&self) -> (f64, f64) {
        self.0.psi().into()
    }

    #[getter]
    fn phi(&self) -> (f64, f64) {
        self.0.phi().into()
    }

    #[getter]
    fn restitution(&self) -> (f64, f64) {
        self.0.restitution().into()
    }

    /// Simulates the gaps and the rotation from a start:
    ///
    /// The run has no q; it has gaps, rates, theta and omega. With psi[0] *
    /// psi[1] = 1 the two gaps cannot move by themselves: a ValueError.
    ///
    /// Parameters
    /// ----------
    /// gaps : (2,) array_like, m
    /// rates : (2,) array_like, m/s
    /// theta : float, rad, default 0.0
    /// omega : float, rad/s, default 0.0
    /// simultaneous, stop, time, time_limit, event_limit, sensitivity_limit, record, certify : see simulate
    ///     As for `simulate`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> local = sf.LocalModel(gravity=(10, 10), psi=(0, 0), phi=(0, 0), restitution=0.5)
    /// >>> local.simulate(gaps=(5, 20), rates=(0, 0), stop="zeno").time    # contact 1: √(2h/g)(1+e)/(1−e)
    /// 3.0
    #[pyo3(signature = (gaps, rates, theta=0.0, omega=0.0, **options), text_signature = "($self, gaps, rates, theta=0.0, omega=0.0, *, simultaneous=None, stop=\"rest\", time=0.0, time_limit=None, event_limit=1_000_000, sensitivity_limit=None, record=True, certify=False)")]
    fn simulate(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = input::gaps)] gaps: [f64; 2],
        #[pyo3(from_py_with = input::rates)] rates: [f64; 2],
        #[pyo3(from_py_with = input::theta)] theta: f64,
        #[pyo3(from_py_with = input::omega)] omega: f64,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyRun> {
        let options = of_call("LocalModel.simulate", Options::default(), &OF_A_BODY, options)?;
        if let Some(i) = gaps.iter().position(|&gap| gap < 0.0) {
            return Err(to_py(&Error::OutOfRange {
                field: format!("gaps.{}", i + 1),
                value: gaps[i],
                allowed: "finite and >= 0",
            }));
        }
        interruptible_run(py, |cancel| {
            simulate_local_until(
                &self.0,
                &LocalState { gaps, rates, theta, omega },
                &options,
                cancel,
            )
        })
    }

    /// The first n impacts as an Orbit: the shape of the state after each (gap and rate of the other
    /// contact over the take-off speed), and the logarithm of its size. There are fewer if one contact
    /// bounces alone from some impact on, or if both land at one instant.
    ///
    /// Parameters
    /// ----------
    /// gaps : (2,) array_like, m
    /// rates : (2,) array_like, m/s
    /// n : int, from 1 to 10⁷
    ///     If the state is right after an impact (one gap is zero and its rate is positive),
    ///     it is row 0. Any other state is advanced to its first impact, which is row 0. An orbit of
    ///     any length neither underflows nor overflows, because only the logarithm of its size is
    ///     stored.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Names `gravity.i`, `restitution.i`, `gaps.i` or `rates.i`: gravity must be positive at both
    ///     contacts, restitution at least 1e-12, and gravity.1 / gravity.2 * sqrt(psi.1 / psi.2)
    ///     between 1e-50 and 1e50.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> local = sf.LocalModel(gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.5)
    /// >>> c = sf.theory.self_similar(0.5, 0.9)        # every impact multiplies all speeds by c
    /// >>> orbit = local.orbit(gaps=(0, c.gap), rates=(1, c.rate), n=4)
    /// >>> orbit.contacts, orbit.log_sizes - orbit.log_sizes[0]
    /// (array([1, 2, 1, 2]), array([ 0.        , ...
    fn orbit(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = input::gaps)] gaps: [f64; 2],
        #[pyo3(from_py_with = input::rates)] rates: [f64; 2],
        n: &Bound<'_, PyAny>,
    ) -> PyResult<PyOrbit> {
        let n = input::whole("n", n, 1..=input::MOST_SAMPLES)?;
        let map = ReducedMap::new(&self.0).map_err(|e| to_py(&e))?;
        let orbit = py.detach(|| map.orbit(gaps, rates, n)).map_err(|e| to_py(&e))?;
        let asked = Asked { model: self.0, method: "orbit", gaps, rates, counts: vec![n] };
        Ok(PyOrbit { map, orbit, asked })
    }

    /// Mean logarithms of the growth per impact of speeds and of differences in shape (see `orbit`), as
    /// Exponents.
    ///
    /// See `orbit` for errors.
    ///
    /// Parameters
    /// ----------
    /// gaps : (2,) array_like, m
    /// rates : (2,) array_like, m/s
    /// n : int, from 1 to 10⁷, default 100_000
    ///     Number of impacts of the means.
    /// transient : int, default 1000
    ///     Number of impacts before them that are not counted.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> local = sf.LocalModel(gravity=(1, 1), psi=(0.22, 0.22), phi=(0, 0), restitution=0.9)
    /// >>> chaos = local.exponents(gaps=(0, 0.3), rates=(1, -1), n=1_000_000)
    /// >>> round(chaos.sigma, 3), round(chaos.lyapunov[0], 2)
    /// (-0.038, 0.2)
    #[pyo3(signature = (gaps, rates, n=None, transient=None), text_signature = "($self, gaps, rates, n=100_000, transient=1000)")]
    fn exponents(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = input::gaps)] gaps: [f64; 2],
        #[pyo3(from_py_with = input::rates)] rates: [f64; 2],
        n: Option<&Bound<'_, PyAny>>,
        transient: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyExponents> {
        let n = n.map_or(Ok(100_000), |n| input::whole("n", n, 1..=MOST_IMPACTS))?;
        let transient =
            transient.map_or(Ok(1000), |n| input::whole("transient", n, 0..=MOST_IMPACTS))?;
        let counts = vec![n, transient];
        let asked = Asked { model: self.0, method: "exponents", gaps, rates, counts };
        interruptible(py, |cancel| {
            ReducedMap::new(&self.0)?.exponents(gaps, rates, n, transient, cancel)
        })
        .map(|exponents| PyExponents { exponents, asked })
    }

    /// How a motion ends, as a Fate: its kind is "1-zeno", "clattering", "self-similar", "other" or "none".
    /// See `orbit` for gaps, rates and errors.
    ///
    /// Parameters
    /// ----------
    /// gaps : (2,) array_like, m
    /// rates : (2,) array_like, m/s
    /// n : int, from 1 to 10⁷, default 10_000
    ///     Largest number of impacts that are followed.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> local = sf.LocalModel(gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.1)
    /// >>> local.fate(gaps=(0, 0.1), rates=(0.1, -1.9))
    /// <Fate: clattering, certified, known after 0 impacts>
    /// >>> local.fate(gaps=(0, 1), rates=(0.1, 0)).kind
    /// '1-zeno'
    #[pyo3(signature = (gaps, rates, n=None), text_signature = "($self, gaps, rates, n=10_000)")]
    fn fate(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = input::gaps)] gaps: [f64; 2],
        #[pyo3(from_py_with = input::rates)] rates: [f64; 2],
        n: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyFate> {
        let n = n.map_or(Ok(FATE_IMPACTS), |n| input::whole("n", n, 1..=MOST_IMPACTS))?;
        let asked = Asked { model: self.0, method: "fate", gaps, rates, counts: vec![n] };
        interruptible(py, |cancel| ReducedMap::new(&self.0)?.fate(gaps, rates, n, cancel))
            .map(|fate| PyFate { fate, asked })
    }

    /// The fates of many motions.
    ///
    /// Parameters
    /// ----------
    /// gaps : (..., 2) array_like, m
    /// rates : (..., 2) array_like, m/s
    /// n : int, from 1 to 10⁷, default 10_000
    ///     Largest number of impacts that are followed.
    ///
    /// Returns
    /// -------
    /// ndarray
    ///     A structured array of shape (...) with the fields of Fate, 0 where its contact or period is
    ///     None, and NaN where its sigma is.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import standfast as sf
    /// >>> local = sf.LocalModel(gravity=(1, 1), psi=(0.9, 0.9), phi=(0, 0), restitution=0.1)
    /// >>> rates = [[0.1, u] for u in (-2, -1, 0)]
    /// >>> local.fates(gaps=np.broadcast_to((0, 0.1), (3, 2)), rates=rates)["kind"]
    /// array(['clattering', 'clattering', '1-zeno'], dtype='<U12')
    #[pyo3(signature = (gaps, rates, n=None), text_signature = "($self, gaps, rates, n=10_000)")]
    fn fates<'py>(
        &self,
        py: Python<'py>,
        gaps: &Bound<'py, PyAny>,
        rates: &Bound<'py, PyAny>,
        n: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let n = n.map_or(Ok(FATE_IMPACTS), |n| input::whole("n", n, 1..=MOST_IMPACTS))?;
        let (gaps, rates) = (input::tuples("gaps", gaps, 2)?, input::tuples("rates", rates, 2)?);
        let shape = gaps.as_array().shape().to_vec();
        if rates.as_array().shape() != shape {
            return Err(to_py(&Error::Unusable {
                field: "rates".into(),
                value: format!("array of shape {:?}", rates.as_array().shape()),
                allowed: format!("the shape of gaps, {shape:?}"),
            }));
        }
        let pairs = |array: &PyReadonlyArrayDyn<'py, f64>| -> Vec<[f64; 2]> {
            array.as_array().rows().into_iter().map(|row| [row[0], row[1]]).collect()
        };
        let (gaps, rates) = (pairs(&gaps), pairs(&rates));
        let fates = interruptible(py, |cancel| {
            let map = ReducedMap::new(&self.0)?;
            let mut fates = Vec::with_capacity(gaps.len());
            for (k, (gaps, rates)) in gaps.iter().zip(&rates).enumerate() {
                if k % STATES == STATES - 1 && cancel() {
                    return Err(Error::Cancelled);
                }
                fates.push(map.fate(*gaps, *rates, n, cancel)?);
            }
            Ok(fates)
        })?;
        fate_table(py, &fates, &shape[..shape.len() - 1])
    }

    fn __repr__(&self) -> String {
        let m = &self.0;
        format!(
            "LocalModel(gravity={}, psi={}, phi={}, restitution={})",
            pair_text(m.gravity()),
            pair_text(m.psi()),
            pair_text(m.phi()),
            pair_text(m.restitution())
        )
    }

    #[allow(clippy::type_complexity, reason = "the arguments of the constructor")]
    fn __reduce__(&self, py: Python<'_>) -> (Py<PyAny>, ([f64; 2], [f64; 2], [f64; 2], [f64; 2])) {
        let m = &self.0;
        let arguments = (m.gravity(), m.psi(), m.phi(), m.restitution());
        (py.get_type::<Self>().into_any().unbind(), arguments)
    }
}
