//! Scene files.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use standfast::excitation::{Excitation, Force, GroundMotion, Kick};
use standfast::mechanism_scene::AnyScene;
use standfast::{Options, Scene, Simulation, State};

use crate::convert::{float, vector};
use crate::error::to_py;
use crate::excitation::{PyForce, PyGroundMotion, PyKick};
use crate::input;
use crate::mechanism_scene::PyMechanismScene;
use crate::options::{get, set};
use crate::posture::{PyPosture, posture};
use crate::run::{PyRun, interruptible_run};

/// A posture, its start, and the options of its run.
///
/// Parameters
/// ----------
/// posture : Posture
/// q, qdot : (3,) array_like, m, m, rad and per second, default (0, 0, 0)
///     The start.
/// options : dict or None, default None
///     Keywords of `simulate`, except those that follow.
/// kicks : sequence of Kick, default ()
/// ground_motion : GroundMotion or None, default None
/// forces : sequence of Force, default ()
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
/// >>> scene = sf.Scene(rod, q=(0, 0.01, 0), qdot=(0, 0, 0), options={"stop": "zeno"})
/// >>> scene.simulate(stop="rest").outcome
/// 'rest'
#[pyclass(frozen, eq, name = "Scene", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyScene(pub(crate) Scene);

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(signature = (posture, q=[0.0; 3], qdot=[0.0; 3], options=None, kicks=Vec::new(), ground_motion=None, forces=Vec::new()), text_signature = "(posture, q=(0, 0, 0), qdot=(0, 0, 0), options=None, kicks=(), ground_motion=None, forces=())")]
    fn new(
        #[pyo3(from_py_with = posture)] posture: PyPosture,
        #[pyo3(from_py_with = input::q)] q: [f64; 3],
        #[pyo3(from_py_with = input::qdot)] qdot: [f64; 3],
        options: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = crate::excitation::kicks)] kicks: Vec<Kick>,
        #[pyo3(from_py_with = crate::excitation::ground_motion)] ground_motion: Option<
            GroundMotion,
        >,
        #[pyo3(from_py_with = crate::excitation::forces)] forces: Vec<Force>,
    ) -> PyResult<Self> {
        let mut chosen = Options::default();
        if let Some(keywords) = options.map(input::options).transpose()?.flatten() {
            set(&mut chosen, keywords)?;
        }
        let start = State::new(q, qdot);
        start.validate().map_err(|e| to_py(&e))?;
        let excitation = Excitation { kicks, forces, ground_motion };
        let fields = posture.0.fields();
        excitation.validate(chosen.time, fields.mass, fields.gravity).map_err(|e| to_py(&e))?;
        Ok(Self(Scene { posture: posture.0.clone(), start, options: chosen, excitation }))
    }

    #[getter]
    fn posture(&self) -> PyPosture {
        PyPosture(self.0.posture.clone())
    }

    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, numpy::PyArray1<f64>> {
        vector(py, &self.0.start.q)
    }

    #[getter]
    fn qdot<'py>(&self, py: Python<'py>) -> Bound<'py, numpy::PyArray1<f64>> {
        vector(py, &self.0.start.qdot)
    }

    #[getter]
    fn options<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        get(py, &self.0.options)
    }

    /// The kicks of the run.
    #[getter]
    fn kicks(&self) -> Vec<PyKick> {
        self.0.excitation.kicks.iter().map(|kick| PyKick(*kick)).collect()
    }

    /// The forces for a time of the run.
    #[getter]
    fn forces(&self) -> Vec<PyForce> {
        self.0.excitation.forces.iter().copied().map(PyForce).collect()
    }

    /// The motion of the ground, or None.
    #[getter]
    fn ground_motion(&self) -> Option<PyGroundMotion> {
        self.0.excitation.ground_motion.clone().map(PyGroundMotion)
    }

    /// (3,) N, N, N m: the force on the body that replaces the motion of the ground at the start, in the frame of the ground. It is the
    /// `wrench` of `contact_modes` for the modes at the start.
    #[getter]
    fn wrench<'py>(&self, py: Python<'py>) -> Bound<'py, numpy::PyArray1<f64>> {
        let Scene { posture, options, excitation, .. } = &self.0;
        let fields = posture.fields();
        vector(py, &excitation.wrench(options.time, fields.mass, fields.gravity).into())
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
        let keywords = options;
        let mut options = self.0.options;
        if let Some(keywords) = keywords {
            set(&mut options, keywords)?;
        }
        let scene = &self.0;
        interruptible_run(py, |cancel| Simulation { options, cancel, ..scene.simulation() }.run())
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
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> scene = sf.Scene(sf.Posture.box(0.3, 0.5), q=(0, 0, 0), qdot=(0, 0, 0))
    /// >>> sf.Scene.from_json(scene.to_json()) == scene
    /// True
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Scene::from_json(text).map(Self).map_err(|e| to_py(&e))
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
        let triple = |v: [f64; 3]| format!("({})", v.map(float).join(", "));
        Ok(format!(
            "Scene({}, q={}, qdot={}, options={}{}{}{})",
            self.posture().into_pyobject(py)?.repr()?,
            triple(self.0.start.q.into()),
            triple(self.0.start.qdot.into()),
            get(py, &self.0.options)?.repr()?,
            match self.kicks() {
                none if none.is_empty() => String::new(),
                kicks => format!(", kicks={}", kicks.into_pyobject(py)?.repr()?),
            },
            match self.ground_motion() {
                None => String::new(),
                Some(motion) => format!(", ground_motion={}", motion.into_pyobject(py)?.repr()?),
            },
            match self.forces() {
                none if none.is_empty() => String::new(),
                forces => format!(", forces={}", forces.into_pyobject(py)?.repr()?),
            }
        ))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Py<PyAny>, Bound<'py, PyTuple>)> {
        let start = &self.0.start;
        let options = get(py, &self.0.options)?;
        let (q, qdot): ([f64; 3], [f64; 3]) = (start.q.into(), start.qdot.into());
        let arguments =
            (self.posture(), q, qdot, options, self.kicks(), self.ground_motion(), self.forces());
        Ok((py.get_type::<Self>().into_any().unbind(), arguments.into_pyobject(py)?))
    }
}

/// Reads a scene file: JSON if its name ends in .json, else TOML. At most 1 MiB. `MechanismScene.load`
/// reads those of mechanisms and assemblies.
///
/// Parameters
/// ----------
/// path : path_like
///     The file.
///
/// Raises
/// ------
/// OSError
///     If the file cannot be read.
/// ValueError
///     Names the file, the place and the error. If the file is not a scene but a result, a map, a
///     picture or the schema, the error names this kind.
#[pyfunction]
pub(crate) fn load(py: Python<'_>, path: PathBuf) -> PyResult<PyScene> {
    py.detach(|| Scene::load(path)).map(PyScene).map_err(|e| to_py(&e))
}

/// As `load`, for all scenes: a MechanismScene if the file has a mass_matrix or a list of bodies, else
/// a Scene.
///
/// Parameters
/// ----------
/// path : path_like
///     The file.
#[pyfunction]
pub(crate) fn load_any(py: Python<'_>, path: PathBuf) -> PyResult<Loaded> {
    let found = py.detach(|| AnyScene::load(path)).map_err(|e| to_py(&e))?;
    Ok(match found {
        AnyScene::Body(scene) => Loaded::Body(PyScene(scene)),
        AnyScene::Mechanism(scene) => Loaded::Mechanism(PyMechanismScene(scene)),
    })
}

/// What a scene file has.
#[derive(IntoPyObject)]
pub(crate) enum Loaded {
    Body(PyScene),
    Mechanism(PyMechanismScene),
}

/// JSON Schema of the scene files of bodies, as text.
#[pyfunction]
pub(crate) fn schema() -> String {
    Scene::schema()
}
