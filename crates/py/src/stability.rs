//! Stability of postures.

use std::path::PathBuf;

use pyo3::prelude::*;
use standfast::{Posture, State, Verdict};

use crate::error::to_py;
use crate::modes::PyModes;
use crate::posture::PyPosture;

/// What is said of a posture on two contacts: whether the body comes back to rest after any small kick.
///
/// frictional_stability : "stable", "unstable" or "undecided"; by : the argument; evidence : its data. `print(verdict)` shows
/// a table of every mode.
///
/// >>> import standfast as sf
/// >>> feet = [sf.Contact(point=(x, 0), friction=0.5) for x in (-1, 1)]
/// >>> box = sf.Posture(mass=1, gyration_radius=0.4, center_of_mass=(0, 0.2), contacts=feet, restitution=0.1)
/// >>> verdict = sf.stability(box)
/// >>> verdict.frictional_stability, verdict.by, verdict.kinematic_strong
/// ('stable', 'theorem-3-loose', True)
#[pyclass(frozen, name = "Verdict", module = "standfast")]
pub(crate) struct PyVerdict {
    posture: Posture,
    verdict: Verdict,
}

#[pymethods]
impl PyVerdict {
    /// Whether friction and normal forces can hold the body.
    #[getter]
    fn equilibrium(&self) -> bool {
        self.verdict.equilibrium
    }

    /// Distance of the centre of mass to the nearer end of the equilibrium region, m; negative outside.
    #[getter]
    fn equilibrium_margin(&self) -> f64 {
        self.verdict.equilibrium_margin
    }

    /// Abscissas (low, high) of the centre of mass at which there is equilibrium, m; None if there are none.
    #[getter]
    fn equilibrium_region(&self) -> Option<(f64, f64)> {
        self.verdict.region.map(Into::into)
    }

    /// Whether every word but FF fails by kinematics alone, while its forces fit (f_n ≥ 0).
    #[getter]
    fn kinematic_strong(&self) -> bool {
        self.verdict.kinematic_strong
    }

    /// The same with the friction cone required of the forces of fixed contacts, too.
    #[getter]
    fn kinematic_strong_strict(&self) -> bool {
        self.verdict.kinematic_strong_strict
    }

    /// How far the nearest condition of `kinematic_strong` is from changing it, relative to the load.
    #[getter]
    fn kinematic_margin(&self) -> f64 {
        self.verdict.kinematic_margin
    }

    /// Whether FF is the only consistent word at rest.
    #[getter]
    fn unambiguous(&self) -> bool {
        self.verdict.unambiguous
    }

    /// ψ = sign(ψ_1)√(ψ_1ψ_2)
    #[getter]
    fn coupling(&self) -> f64 {
        self.verdict.coupling
    }

    /// Whether clattering converges: the paper's (10).
    #[getter]
    fn clattering(&self) -> bool {
        self.verdict.clattering
    }

    /// ψ less the bound of (10).
    #[getter]
    fn clattering_margin(&self) -> f64 {
        self.verdict.clattering_margin
    }

    /// Whether Goyal's bound holds: alternate impacts without gravity never end.
    #[getter]
    fn chatter(&self) -> bool {
        self.verdict.chatter
    }

    /// ψ less Goyal's bound.
    #[getter]
    fn chatter_margin(&self) -> f64 {
        self.verdict.chatter_margin
    }

    /// Whether every frictionless motion comes to rest on the contacts: λ = D⁻¹(g_1, g_2) > 0.
    #[getter]
    fn energy(&self) -> bool {
        self.verdict.energy
    }

    /// "stable", "unstable" or "undecided".
    #[getter]
    fn frictional_stability(&self) -> &str {
        self.verdict.frictional_stability.as_str()
    }

    /// The argument: "not-equilibrium", "theorem-3", "theorem-3-loose", "goyal", "corner-map", "growing-cycle",
    /// "accelerating-mode", or None.
    #[getter]
    fn by(&self) -> Option<&str> {
        self.verdict.by.map(standfast::By::as_str)
    }

    /// The argument's data: None where the margins are all of it; of "corner-map" the potentials of the cells; of
    /// "growing-cycle" its corners (contact, phi, growth); of "accelerating-mode" the word or the corner that leads away; of
    /// an undecided posture the cells left over.
    #[getter]
    fn evidence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = self.verdict.evidence_json();
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Whether rounding may decide: a margin that counts is below 1e-10.
    #[getter]
    fn delicate(&self) -> bool {
        self.verdict.delicate
    }

    /// Every word at rest, with its motion, forces and margins: Modes.
    #[getter]
    fn modes(&self) -> PyResult<PyModes> {
        let problem = self.posture.contact_problem(&State::at_rest([0.0; 3]), [0.0; 3]);
        PyModes::enumerated(problem.map_err(|e| to_py(&e))?)
    }

    /// The posture.
    #[getter]
    fn posture(&self) -> PyPosture {
        PyPosture(self.posture.clone())
    }

    /// The verdict and its evidence as plain dictionaries, lists and numbers.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.verdict.to_json(),))
    }

    /// Writes the verdict and its evidence as JSON.
    fn to_json(&self, path: PathBuf) -> PyResult<()> {
        self.verdict.save(path).map_err(|e| to_py(&e))
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (PyPosture,))> {
        Ok((py.import("standfast")?.getattr("stability")?.unbind(), (self.posture(),)))
    }

    fn __repr__(&self) -> String {
        let by = self.by().map_or(String::new(), |by| format!(" by {by}"));
        format!("<Verdict: {}{by}>", self.frictional_stability())
    }

    fn __str__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.table")?.call_method1("verdict_table", (slf,))
    }
}

/// Whether a posture with two contacts is stable: after any small kick the body comes back to rest near it.
///
/// Small motions are looked at, to first order, with frictionless impacts (the paper's local model). Raises ValueError naming
/// `contacts` unless there are two that touch.
///
/// >>> import standfast as sf
/// >>> sf.stability(sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)).by
/// 'theorem-3'
#[pyfunction]
pub(crate) fn stability(posture: PyRef<'_, PyPosture>) -> PyResult<PyVerdict> {
    let posture = posture.0.clone();
    let verdict = standfast::stability(&posture).map_err(|e| to_py(&e))?;
    Ok(PyVerdict { posture, verdict })
}

/// Abscissas (low, high) of the centre of mass, m, at which friction and normal forces at the contacts can hold the body
/// against gravity; ±inf where there is no bound, None if there are none. Any number of contacts.
///
/// >>> import standfast as sf
/// >>> sf.equilibrium_region(sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1))
/// (-0.5, 0.5)
#[pyfunction]
pub(crate) fn equilibrium_region(posture: PyRef<'_, PyPosture>) -> Option<(f64, f64)> {
    standfast::equilibrium_region(&posture.0).map(Into::into)
}
