//! Scene files of mechanisms and of assemblies.

use std::path::PathBuf;

use numpy::{PyArray1, ToPyArray};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::Options;
use standfast::assembly::{System, SystemExcitation};
use standfast::mechanism_scene::{MechanismScene, SceneOf};

use crate::assembly::PySystem;
use crate::convert::{numbers_text, question};
use crate::error::to_py;
use crate::excitation::{PyForce, PyGroundMotion, PyKick, of_system};
use crate::input;
use crate::mechanism::PyMechanism;
use crate::modes::mechanism;
use crate::options::{get, set};
use crate::run::{PyRun, interruptible_run};

/// A mechanism or an assembly, its start, and the options of its run.
///
/// Parameters
/// ----------
/// mechanism : Mechanism or System
/// q, qdot : (dof,) array_like, m or rad and per second
///     Displacement of its coordinates and their velocities.
/// options : dict or None, default None
///     Keywords of `simulate`.
/// kicks, forces, ground_motion : see simulate
///     Of a System, as for `simulate`.
///
/// Examples
/// --------
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
    #[pyo3(signature = (mechanism, q, qdot, options=None, *, kicks=None, forces=None, ground_motion=None))]
    fn new(
        #[pyo3(from_py_with = scene_of)] mechanism: SceneOf,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
        #[pyo3(from_py_with = input::coordinate_rates)] qdot: Vec<f64>,
        options: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::given)] kicks: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::given)] forces: Option<Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::given)] ground_motion: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (mut mechanism, given) = (mechanism, [kicks, forces, ground_motion]);
        match &mut mechanism {
            SceneOf::System(system, excitation) => *excitation = of_system(system, &given)?,
            SceneOf::Mechanism(_) => {
                if let Some(value) = given.iter().flatten().next() {
                    let allowed = "none with a Mechanism: only a scene of a System has them";
                    return Err(input::wrong_type("kicks, forces, ground_motion", value, allowed));
                }
            }
        }
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
            SceneOf::System(system, _) => Some(PySystem(System::clone(system))),
        }
    }

    /// The kicks by the names of the bodies of a System.
    #[getter]
    fn kicks<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_body(py, |excitation| &excitation.kicks, PyKick)
    }

    /// The forces by the names of the bodies of a System.
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.by_body(py, |excitation| &excitation.forces, PyForce)
    }

    /// The motion of the ground of a System, or None.
    #[getter]
    fn ground_motion(&self) -> Option<PyGroundMotion> {
        match &self.0.of {
            SceneOf::Mechanism(_) => None,
            SceneOf::System(_, excitation) => excitation.ground_motion.clone().map(PyGroundMotion),
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

    /// Runs the scene.
    ///
    /// Parameters
    /// ----------
    /// **options : keyword of simulate
    ///     They replace the options of the scene.
    ///
    /// Returns
    /// -------
    /// Run
    #[pyo3(signature = (**options))]
    fn simulate(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyRun> {
        let mut chosen = self.0.options;
        if let Some(keywords) = options {
            set(&mut chosen, keywords)?;
        }
        let MechanismScene { of, q, qdot, .. } = &self.0;
        interruptible_run(py, |cancel| of.simulate_until(q, qdot, &chosen, cancel))
    }

    /// Reads a scene from the text of `to_json`.
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     With the line and the error.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        MechanismScene::from_json(text).map(Self).map_err(|e| to_py(&e))
    }

    /// Reads a scene file: JSON if its name ends in .json, else TOML. At most 1 MiB.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `standfast.load`.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| MechanismScene::load(path)).map(Self).map_err(|e| to_py(&e))
    }

    /// Writes the scene to a file: JSON if its name ends in .json, else TOML.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file.
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
                SceneOf::System(system, _) => PySystem(System::clone(system)).__repr__(),
            },
            numbers_text(&self.0.q),
            numbers_text(&self.0.qdot),
            get(py, &self.0.options)?.repr()?
        ))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let options = get(py, &self.0.options)?;
        let of = match &self.0.of {
            SceneOf::Mechanism(mechanism) => {
                PyMechanism(mechanism.clone()).into_bound_py_any(py)?
            }
            SceneOf::System(system, _) => PySystem(System::clone(system)).into_bound_py_any(py)?,
        };
        let arguments = PyDict::new(py);
        arguments.set_item("mechanism", of)?;
        arguments.set_item("q", self.q(py))?;
        arguments.set_item("qdot", self.qdot(py))?;
        arguments.set_item("options", options)?;
        if let SceneOf::System(..) = &self.0.of {
            arguments.set_item("kicks", self.kicks(py)?)?;
            arguments.set_item("forces", self.forces(py)?)?;
            arguments.set_item("ground_motion", self.ground_motion())?;
        }
        Ok((question(py.get_type::<Self>().into_any(), &arguments)?, ()))
    }
}

impl PyMechanismScene {
    /// What acts on the bodies of a System, lists by their names.
    fn by_body<'py, T: Copy, P: for<'a> IntoPyObject<'a>>(
        &self,
        py: Python<'py>,
        of: impl Fn(&SystemExcitation) -> &Vec<(usize, T)>,
        shown: impl Fn(T) -> P,
    ) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let SceneOf::System(system, excitation) = &self.0.of else { return Ok(all) };
        for (k, (name, _)) in system.fields().bodies.iter().enumerate() {
            let own = of(excitation).iter().filter(|(body, _)| *body == k);
            let own: Vec<P> = own.map(|(_, one)| shown(*one)).collect();
            if !own.is_empty() {
                all.set_item(name, own)?;
            }
        }
        Ok(all)
    }
}

/// Reads a mechanism or an assembly.
fn scene_of(value: &Bound<'_, PyAny>) -> PyResult<SceneOf> {
    match value.cast::<PySystem>() {
        Ok(system) => {
            Ok(SceneOf::System(Box::new(system.get().0.clone()), SystemExcitation::default()))
        }
        Err(_) => mechanism(value).map(|mechanism| SceneOf::Mechanism(mechanism.0)),
    }
}
