//! Scene files of mechanisms and of assemblies.

use std::path::PathBuf;

use numpy::{PyArray1, ToPyArray};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use standfast::Options;
use standfast::mechanism_scene::{MechanismScene, SceneOf};
use standfast::simulate::simulate_mechanism_until;

use crate::assembly::PySystem;
use crate::convert::numbers_text;
use crate::error::to_py;
use crate::input;
use crate::mechanism::PyMechanism;
use crate::modes::mechanism;
use crate::options::{get, set};
use crate::run::{PyRun, interruptible_run};

/// A mechanism or an assembly, its start, and the options of its run.
///
/// mechanism : Mechanism or System. q, qdot : (dof,), displacement of its coordinates and their velocities. options : keywords of `simulate`.
///
/// >>> import standfast as sf
/// >>> rod = sf.Mechanism.of_posture(sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1))
/// >>> scene = sf.MechanismScene(rod, q=(0, 0.01, 0), qdot=(0, 0, 0), options={"stop": "zeno"})
/// >>> scene.simulate(stop="rest").outcome, sf.MechanismScene.from_json(scene.to_json()) == scene
/// ('rest', True)
#[pyclass(frozen, eq, name = "MechanismScene", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyMechanismScene(pub(crate) MechanismScene);

#[pymethods]
impl PyMechanismScene {
    #[new]
    #[pyo3(signature = (mechanism, q, qdot, options=None))]
    fn new(
        #[pyo3(from_py_with = scene_of)] mechanism: SceneOf,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
        #[pyo3(from_py_with = input::coordinate_rates)] qdot: Vec<f64>,
        options: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut chosen = Options::default();
        if let Some(keywords) = options.map(input::options).transpose()?.flatten() {
            set(&mut chosen, keywords)?;
        }
        MechanismScene::new(mechanism, q, qdot, chosen).map(Self).map_err(|e| to_py(&e))
    }

    /// The Mechanism, also of a System. Raises ValueError for a System of more than 64 contacts or 33 bodies.
    #[getter]
    fn mechanism(&self) -> PyResult<PyMechanism> {
        let mechanism = self.0.of.mechanism().map_err(|e| to_py(&e))?;
        Ok(PyMechanism(mechanism.into_owned()))
    }

    /// The System, or None if the scene is of a Mechanism.
    #[getter]
    fn system(&self) -> Option<PySystem> {
        match &self.0.of {
            SceneOf::Mechanism(_) => None,
            SceneOf::System(system) => Some(PySystem(system.clone())),
        }
    }

    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.q.to_pyarray(py)
    }

    #[getter]
    fn qdot<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.qdot.to_pyarray(py)
    }

    #[getter]
    fn options<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        get(py, &self.0.options)
    }

    /// Runs the scene. Keywords of `standfast.simulate` replace the options of the scene.
    #[pyo3(signature = (**options))]
    fn simulate(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyRun> {
        let mut chosen = self.0.options;
        if let Some(keywords) = options {
            set(&mut chosen, keywords)?;
        }
        let MechanismScene { of, q, qdot, .. } = &self.0;
        let mechanism = of.mechanism().map_err(|e| to_py(&e))?;
        interruptible_run(py, |cancel| {
            simulate_mechanism_until(&mechanism, q, qdot, &chosen, cancel)
        })
    }

    /// Reads a scene from the text of `to_json`. Raises ValueError with the line and the error.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        MechanismScene::from_json(text).map(Self).map_err(|e| to_py(&e))
    }

    /// Reads a scene file: JSON if its name ends in .json, else TOML. At most 1 MiB. Raises as `standfast.load`.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| MechanismScene::load(path)).map(Self).map_err(|e| to_py(&e))
    }

    /// Writes the scene to a file: JSON if its name ends in .json, else TOML.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        self.0.save(path).map_err(|e| to_py(&e))
    }

    /// The scene as TOML text.
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    /// The scene as JSON text.
    fn to_json(&self) -> String {
        self.0.to_json()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!(
            "MechanismScene({}, q={}, qdot={}, options={})",
            match &self.0.of {
                SceneOf::Mechanism(mechanism) => PyMechanism(mechanism.clone()).__repr__(),
                SceneOf::System(system) => PySystem(system.clone()).__repr__(),
            },
            numbers_text(&self.0.q),
            numbers_text(&self.0.qdot),
            get(py, &self.0.options)?.repr()?
        ))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Py<PyAny>, Bound<'py, PyTuple>)> {
        let options = get(py, &self.0.options)?;
        let of = match &self.0.of {
            SceneOf::Mechanism(mechanism) => {
                PyMechanism(mechanism.clone()).into_bound_py_any(py)?
            }
            SceneOf::System(system) => PySystem(system.clone()).into_bound_py_any(py)?,
        };
        let arguments = (of, self.q(py), self.qdot(py), options);
        Ok((py.get_type::<Self>().into_any().unbind(), arguments.into_pyobject(py)?))
    }
}

/// Reads a mechanism or an assembly.
fn scene_of(value: &Bound<'_, PyAny>) -> PyResult<SceneOf> {
    match value.cast::<PySystem>() {
        Ok(system) => Ok(SceneOf::System(system.get().0.clone())),
        Err(_) => mechanism(value).map(|mechanism| SceneOf::Mechanism(mechanism.0)),
    }
}
