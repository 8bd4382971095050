//! Assemblies of bodies that stand on each other.

use std::path::PathBuf;

use numpy::{PyArray1, PyArrayDyn, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use standfast::Error;
use standfast::assembly::{
    Ground, Load, Rigid, System, SystemContact, SystemFields, SystemMode, body_called,
};
use standfast::modes::Mode;

use crate::convert::{array, counted, float, pair_text, question};
use crate::error::to_py;
use crate::input;
use crate::mechanism::PyMechanism;

/// A rigid body of a System, in its place.
///
/// Parameters
/// ----------
/// mass : float, kg
/// gyration_radius : float, m
/// center_of_mass : (2,) array_like, m
/// outline : (n, 2) array_like, m
///     Its corners in order: a polygon whose sides meet only at its corners.
/// friction : float or None, default None
///     Of its contacts; None: that of the System. Where two bodies have one, the smaller one
///     counts.
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.Rigid(2, 0.5, (0, 1), [(-1, 0), (1, 0), (0, 3)]).mass
/// 2.0
#[pyclass(frozen, eq, name = "Rigid", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyRigid(pub(crate) Rigid);

#[pymethods]
impl PyRigid {
    #[new]
    #[pyo3(signature = (mass, gyration_radius, center_of_mass, outline, friction=None))]
    fn new(
        #[pyo3(from_py_with = input::mass)] mass: f64,
        #[pyo3(from_py_with = input::gyration_radius)] gyration_radius: f64,
        #[pyo3(from_py_with = input::center_of_mass)] center_of_mass: [f64; 2],
        #[pyo3(from_py_with = input::outline)] outline: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::own_friction)] friction: Option<f64>,
    ) -> PyResult<Self> {
        let body = Rigid { mass, gyration_radius, center_of_mass, outline, friction };
        body.checked().map(Self).map_err(|e| to_py(&e))
    }

    /// A polygon of uniform density.
    ///
    /// Parameters
    /// ----------
    /// vertices : (n, 2) array_like, m
    ///     Its corners in order.
    /// density : float, kg/m², > 0, default 1.0
    /// friction : float or None, default None
    ///     Of its contacts; None: that of the System.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> sf.Rigid.polygon([(0, 0), (3, 0), (0, 3)]).center_of_mass
    /// array([1., 1.])
    #[staticmethod]
    #[pyo3(signature = (vertices, density=1.0, friction=None))]
    fn polygon(
        #[pyo3(from_py_with = input::vertices)] vertices: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::density)] density: f64,
        #[pyo3(from_py_with = input::own_friction)] friction: Option<f64>,
    ) -> PyResult<Self> {
        with_friction(Rigid::polygon(&vertices, density), friction)
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.0.mass
    }

    #[getter]
    fn gyration_radius(&self) -> f64 {
        self.0.gyration_radius
    }

    #[getter]
    fn center_of_mass<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.center_of_mass.to_pyarray(py)
    }

    /// The corners, counterclockwise, (n, 2).
    #[getter]
    fn outline<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.0.outline.concat(), &[self.0.outline.len(), 2])
    }

    #[getter]
    fn friction(&self) -> Option<f64> {
        self.0.friction
    }

    fn __repr__(&self) -> String {
        let corners: Vec<String> = self.0.outline.iter().copied().map(pair_text).collect();
        let friction =
            self.0.friction.map_or(String::new(), |mu| format!(", friction={}", float(mu)));
        format!(
            "Rigid({}, {}, {}, [{}]{friction})",
            float(self.0.mass),
            float(self.0.gyration_radius),
            pair_text(self.0.center_of_mass),
            corners.join(", ")
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let r = &self.0;
        let arguments =
            (r.mass, r.gyration_radius, r.center_of_mass, r.outline.clone(), r.friction);
        Ok((py.get_type::<Self>().into_any(), arguments.into_pyobject(py)?.into_any()))
    }
}

fn with_friction(made: Result<Rigid, Error>, friction: Option<f64>) -> PyResult<PyRigid> {
    made.and_then(|body| Rigid { friction, ..body }.checked()).map(PyRigid).map_err(|e| to_py(&e))
}

/// A rectangle of uniform density, a Rigid.
///
/// Parameters
/// ----------
/// width, height : float, m
/// at : (2,) array_like, m, default (0, 0)
///     The middle of its lower side.
/// turn : float, rad, default 0.0
///     Angle about this point, counterclockwise.
/// density : float, kg/m², default 1.0
/// friction : float or None, default None
///     Of its contacts; None: that of the System.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.Block(2, 1, at=(0, 3)).center_of_mass
/// array([0. , 3.5])
#[pyfunction]
#[pyo3(name = "Block", signature = (width, height, at=[0.0, 0.0], turn=0.0, density=1.0, friction=None), text_signature = "(width, height, at=(0, 0), turn=0.0, density=1.0, friction=None)")]
pub(crate) fn block(
    #[pyo3(from_py_with = input::width)] width: f64,
    #[pyo3(from_py_with = input::height)] height: f64,
    #[pyo3(from_py_with = input::place)] at: [f64; 2],
    #[pyo3(from_py_with = input::turn)] turn: f64,
    #[pyo3(from_py_with = input::density)] density: f64,
    #[pyo3(from_py_with = input::own_friction)] friction: Option<f64>,
) -> PyResult<PyRigid> {
    with_friction(Rigid::block(width, height, at, turn, density), friction)
}

/// A contact of a System, between two bodies or between a body and the ground.
///
/// Parameters
/// ----------
/// body : str or int
///     Name of the body that is pushed along the normal.
/// on : str, int or None
///     Name of the other body, or None for the ground.
/// point : (2,) array_like, m
/// slope : float, rad, default 0.0
///     Angle of the tangent (cos, sin); the normal is (−sin, cos), into `body`.
/// friction : float, default 0.0
///     Coefficient of friction μ.
#[pyclass(frozen, eq, name = "SystemContact", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PySystemContact {
    body: String,
    on: Option<String>,
    point: [f64; 2],
    slope: f64,
    friction: f64,
}

#[pymethods]
impl PySystemContact {
    #[new]
    #[pyo3(signature = (body, on, point, slope=0.0, friction=0.0))]
    fn new(
        body: &Bound<'_, PyAny>,
        on: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = input::point)] point: [f64; 2],
        #[pyo3(from_py_with = input::slope)] slope: f64,
        #[pyo3(from_py_with = input::friction)] friction: f64,
    ) -> PyResult<Self> {
        let on = if on.is_none() { None } else { Some(name("on", on)?) };
        Ok(Self { body: name("body", body)?, on, point, slope, friction })
    }

    /// Names of its two bodies: the one that is pushed along the normal, and the other one, None for the ground.
    #[getter]
    fn bodies(&self) -> (&str, Option<&str>) {
        (&self.body, self.on.as_deref())
    }

    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.point.to_pyarray(py)
    }

    #[getter]
    fn slope(&self) -> f64 {
        self.slope
    }

    /// The unit tangent, (2,).
    #[getter]
    fn tangent<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let Self { point, slope, friction, .. } = *self;
        SystemContact { body: 0, on: None, point, slope, friction }.tangent().to_pyarray(py)
    }

    #[getter]
    fn friction(&self) -> f64 {
        self.friction
    }

    fn __repr__(&self) -> String {
        let on = self.on.as_ref().map_or("None".to_owned(), |on| format!("{on:?}"));
        format!(
            "SystemContact({:?}, {on}, {}, {}, {})",
            self.body,
            pair_text(self.point),
            float(self.slope),
            float(self.friction)
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments = (&self.body, &self.on, self.point, self.slope, self.friction);
        Ok((py.get_type::<Self>().into_any(), arguments.into_pyobject(py)?.into_any()))
    }
}

/// A name of a body: a string, or its number from 1 where the bodies are a list.
pub(crate) fn name(field: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(text.to_string());
    }
    input::whole(field, value, 1..=usize::MAX).map(|number| number.to_string())
}

/// An assembly of rigid bodies in their places: bodies that stand on each other and on the ground.
///
/// `contact_modes`, `static_forces`, `friction_margin`, `stability` and `simulate` take it as the
/// Mechanism `system.mechanism`, with q = (x, y, θ) of the centre of mass of each body; 64 contacts at
/// most. `onset` and `load_factor` take it with hundreds of bodies. Small motions: the directions of
/// the contacts do not change.
///
/// Parameters
/// ----------
/// bodies : dict or sequence of Rigid
///     {name: Rigid or Block}, or a list, whose bodies are called "1", "2", ….
/// contacts : {"touching"} or sequence of SystemContact, default "touching"
///     "touching": found where the outlines touch, two for each pair of flush sides, at the ends of
///     their overlap, and one for a corner on a side; or SystemContact objects.
/// friction : float, default 0.5
///     Of contacts that are found, where no body has one.
/// ground : float, array_like or None, default 0.0
///     Height of level ground, m; or (n, 2) m, a line from left to right, with the ground below; or
///     None.
/// gravity : float, m/s², default 9.81
/// restitution : float, in [0, 1], default 0.0
/// tangential_restitution : float, in [0, 1), default 0.0
///     For impact laws that use it.
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and what is allowed; bodies that overlap are named.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> stack = sf.System({"low": sf.Block(1, 1), "high": sf.Block(1, 1, at=(0.3, 1))})
/// >>> stack.contact_names[2:]
/// ['high on low at (-0.2, 1)', 'high on low at (0.5, 1)']
/// >>> sf.contact_modes(stack).consistent
/// ['FFFF']
#[pyclass(frozen, eq, name = "System", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PySystem(pub(crate) System);

#[pymethods]
impl PySystem {
    #[new]
    #[pyo3(signature = (bodies, contacts=None, friction=0.5, ground=Some(Ground::default()), gravity=9.81, restitution=0.0, tangential_restitution=0.0, **unknown), text_signature = "(bodies, contacts=\"touching\", friction=0.5, ground=0.0, gravity=9.81, restitution=0.0, tangential_restitution=0.0)")]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    fn new(
        bodies: &Bound<'_, PyAny>,
        contacts: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = read_ground)] ground: Option<Ground>,
        #[pyo3(from_py_with = input::gravity)] gravity: f64,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        #[pyo3(from_py_with = input::tangential_restitution)] tangential_restitution: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("System", unknown)?;
        let bodies = named_bodies(bodies)?;
        let contacts = contacts.map_or(Ok(None), |given| read_contacts(given, &bodies))?;
        let fields = SystemFields {
            bodies,
            contacts,
            friction,
            ground,
            gravity,
            restitution,
            tangential_restitution,
        };
        System::new(fields).map(Self).map_err(|e| to_py(&e))
    }

    /// The bodies by name.
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (name, body) in &self.0.fields().bodies {
            all.set_item(name, PyRigid(body.clone()))?;
        }
        Ok(all)
    }

    /// The contacts, numbered from 1 in this order.
    #[getter]
    fn contacts(&self) -> Vec<PySystemContact> {
        let name = |k: usize| self.0.fields().bodies[k].0.clone();
        let contact = |c: &SystemContact| PySystemContact {
            body: name(c.body),
            on: c.on.map(name),
            point: c.point,
            slope: c.slope,
            friction: c.friction,
        };
        self.0.contacts().iter().map(contact).collect()
    }

    /// The contacts in words: which body on which, and where, in m.
    #[getter]
    fn contact_names(&self) -> Vec<String> {
        self.0.contact_names()
    }

    /// The coordinates in words: x, y and theta of each body.
    #[getter]
    fn coordinate_names(&self) -> Vec<String> {
        self.0.coordinate_names()
    }

    /// Height of the level ground, m; or the points of its line, (n, 2) m; or None.
    #[getter]
    fn ground<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        Ok(match &self.0.fields().ground {
            None => None,
            Some(Ground::Level(height)) => Some(height.into_pyobject(py)?.into_any()),
            Some(Ground::Line(points)) => {
                Some(array(py, points.concat(), &[points.len(), 2])?.into_any())
            }
        })
    }

    #[getter]
    fn friction(&self) -> f64 {
        self.0.fields().friction
    }

    #[getter]
    fn gravity(&self) -> f64 {
        self.0.fields().gravity
    }

    #[getter]
    fn restitution(&self) -> f64 {
        self.0.fields().restitution
    }

    #[getter]
    fn tangential_restitution(&self) -> f64 {
        self.0.fields().tangential_restitution
    }

    /// Number of coordinates: three for each body.
    #[getter]
    fn dof(&self) -> usize {
        3 * self.0.fields().bodies.len()
    }

    /// The assembly as a Mechanism with names.
    ///
    /// Raises ValueError with more than 64 contacts or 33 bodies.
    #[getter]
    pub(crate) fn mechanism(&self) -> PyResult<PyMechanism> {
        self.0.mechanism().map(PyMechanism).map_err(|e| to_py(&e))
    }

    /// Draws the bodies, the ground and the contacts; with forces also the force of each joint: a line
    /// along the force through the point where it acts, with a length that is its size. Of the two contacts
    /// of flush sides it is the sum. The points are joined within bodies that have two such joints: the
    /// line of thrust. Forces at the limit of friction have another colour.
    ///
    /// Parameters
    /// ----------
    /// forces : (contacts, 2) array_like or None, N, default None
    ///     Tangential and normal, such as `SystemMode.forces` and `LoadFactor.forces`.
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
    ///     Names the argument; for a suffix that is no picture format, and for both `path` and `ax`.
    /// TypeError
    ///     If `ax` is no axes.
    /// OSError
    ///     If the file cannot be written.
    /// ImportError
    ///     Without matplotlib (extra `plot`).
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> stack = sf.System([sf.Block(1, 0.5), sf.Block(1, 0.5, at=(0.3, 0.5))])
    /// >>> figure = stack.plot(forces=sf.onset(stack).forces)
    #[pyo3(signature = (path=None, *, forces=None, ax=None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        path: Option<PathBuf>,
        forces: Option<&Bound<'py, PyAny>>,
        ax: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let forces = forces.map(|given| {
            let forces = slf.get().own(input::contact_forces(given)?)?;
            array(py, forces.concat(), &[forces.len(), 2])
        });
        let arguments = (slf, path, ax, forces.transpose()?);
        py.import("standfast.system_plot")?.call_method1("plot_system", arguments)
    }

    /// The HTML that a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.notebook")?.call_method1("of_system", (slf,))
    }

    pub(crate) fn __repr__(&self) -> String {
        let bodies = self.0.fields().bodies.len();
        let bodies = if bodies == 1 { "1 body".into() } else { format!("{bodies} bodies") };
        format!("<System: {bodies}, {}>", counted(self.0.contacts().len(), "contact"))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let keywords = PyDict::new(py);
        keywords.set_item("bodies", self.bodies(py)?)?;
        if self.0.fields().contacts.is_some() {
            keywords.set_item("contacts", self.contacts())?;
        }
        keywords.set_item("friction", self.friction())?;
        keywords.set_item("ground", self.ground(py)?)?;
        keywords.set_item("gravity", self.gravity())?;
        keywords.set_item("restitution", self.restitution())?;
        keywords.set_item("tangential_restitution", self.tangential_restitution())?;
        Ok((question(py.get_type::<Self>().into_any(), &keywords)?, ()))
    }
}

impl PySystem {
    /// Finite forces with one pair for each contact.
    fn own(&self, forces: Vec<[f64; 2]>) -> PyResult<Vec<[f64; 2]>> {
        let contacts = self.0.contacts().len();
        if forces.len() != contacts {
            return Err(to_py(&Error::Unusable {
                field: "forces".into(),
                value: format!("[{} pairs]", forces.len()),
                allowed: format!("a pair for each of the {contacts} contacts"),
            }));
        }
        let wrong = |k: usize| !forces[k / 2][k % 2].is_finite();
        if let Some(k) = (0..2 * contacts).find(|k| wrong(*k)) {
            return Err(to_py(&Error::OutOfRange {
                field: format!("forces.{}.{}", k / 2 + 1, ["tangential", "normal"][k % 2]),
                value: forces[k / 2][k % 2],
                allowed: "finite",
            }));
        }
        Ok(forces)
    }
}

/// A Mechanism, or a System as one; `None` for anything else.
pub(crate) fn some_mechanism(value: &Bound<'_, PyAny>) -> PyResult<Option<PyMechanism>> {
    if let Ok(system) = value.cast::<PySystem>() {
        return system.get().mechanism().map(Some);
    }
    Ok(value.cast::<PyMechanism>().ok().map(|found| found.get().clone()))
}

const BODIES: &str = "a dict {name: Rigid}, or a list of Rigid, is needed";

fn named_bodies(value: &Bound<'_, PyAny>) -> PyResult<Vec<(String, Rigid)>> {
    let body = |field: &str, item: &Bound<'_, PyAny>| {
        let found = item.cast::<PyRigid>();
        let found = found.map(|body| body.get().0.clone());
        found.map_err(|_| input::wrong_type(field, item, "a Rigid, or a Block, is needed"))
    };
    if let Ok(all) = value.cast::<PyDict>() {
        return all
            .iter()
            .map(|(key, item)| {
                let name = name("bodies", &key)?;
                let body = body(&format!("bodies[{name:?}]"), &item)?;
                Ok((name, body))
            })
            .collect();
    }
    if value.is_instance_of::<PyString>() || value.cast::<PyRigid>().is_ok() {
        return Err(input::wrong_type("bodies", value, BODIES));
    }
    let all = input::sequence("bodies", value, body)?;
    Ok(all.into_iter().enumerate().map(|(k, body)| ((k + 1).to_string(), body)).collect())
}

fn number_of(bodies: &[(String, Rigid)], field: &str, called: &str) -> PyResult<usize> {
    body_called(bodies, field, called).map_err(|e| to_py(&e))
}

fn read_contacts(
    value: &Bound<'_, PyAny>,
    bodies: &[(String, Rigid)],
) -> PyResult<Option<Vec<SystemContact>>> {
    if value.is_none() || value.extract::<&str>().is_ok_and(|word| word == "touching") {
        return Ok(None);
    }
    let all = input::sequence("contacts", value, |field, item| {
        let needed = "a SystemContact is needed";
        let found = item.cast::<PySystemContact>();
        let c = found.map_err(|_| input::wrong_type(field, item, needed))?.get();
        let on = c.on.as_ref().map(|on| number_of(bodies, &format!("{field}.on"), on));
        Ok(SystemContact {
            body: number_of(bodies, &format!("{field}.body"), &c.body)?,
            on: on.transpose()?,
            point: c.point,
            slope: c.slope,
            friction: c.friction,
        })
    });
    all.map(Some)
}

fn read_ground(value: &Bound<'_, PyAny>) -> PyResult<Option<Ground>> {
    if value.is_none() {
        return Ok(None);
    }
    if value.len().is_ok() {
        return input::ground_line(value).map(|points| Some(Ground::Line(points)));
    }
    input::ground_height(value).map(|height| Some(Ground::Level(height)))
}

/// A load, or none.
fn read_load(
    system: &System,
    load: Option<&Bound<'_, PyDict>>,
    acceleration: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Load>> {
    match (load, acceleration) {
        (None, None) => Ok(None),
        (Some(load), None) => {
            let wrench = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
                let called = name("load", &key)?;
                let body = number_of(&system.fields().bodies, "load", &called)?;
                Ok((body, input::wrench(&value)?))
            };
            Ok(Some(Load::Wrenches(load.iter().map(wrench).collect::<PyResult<_>>()?)))
        }
        (None, Some(value)) => Ok(Some(Load::Acceleration(input::acceleration(value)?))),
        (Some(_), Some(_)) => Err(to_py(&Error::Unusable {
            field: "load".into(),
            value: "load and acceleration".into(),
            allowed: "either load or acceleration".into(),
        })),
    }
}

fn some_system<'a>(value: &'a Bound<'_, PyAny>) -> PyResult<&'a Bound<'a, PySystem>> {
    value.cast::<PySystem>().map_err(|_| input::wrong_type("system", value, "a System is needed"))
}

/// How much of a load a System holds: the largest multiple that contact forces can balance, and the
/// smallest at which a contact mode moves.
///
/// Parameters
/// ----------
/// system : System
/// load : dict or None, default None
///     {body: (fx, fy, moment)}, N and N m about its centre of mass.
/// acceleration : (2,) array_like or None, m/s², default None
///     In place of load: it acts like gravity on every body.
///
/// Returns
/// -------
/// LoadFactor or None
///     A LoadFactor; None if contact forces balance no multiple ≥ 0 of the load.
///
/// Raises
/// ------
/// ValueError
///     Names the argument.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> brick = sf.System([sf.Block(2, 1)], gravity=10)      # friction 1/2
/// >>> factor = sf.load_factor(brick, acceleration=(1, 0))
/// >>> round(factor.static, 9), round(factor.moves, 9), factor.mode.word
/// (5.0, 5.0, 'RR')
#[pyfunction]
#[pyo3(signature = (system, load=None, *, acceleration=None))]
pub(crate) fn load_factor(
    system: &Bound<'_, PyAny>,
    load: Option<&Bound<'_, PyDict>>,
    acceleration: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<PyLoadFactor>> {
    let owner = some_system(system)?;
    let Some(load) = read_load(&owner.get().0, load, acceleration)? else {
        return Err(to_py(&Error::Unusable {
            field: "load".into(),
            value: "None".into(),
            allowed: "either load or acceleration".into(),
        }));
    };
    let system = owner.get().clone();
    let found = owner.py().detach(|| system.0.load_factor(&load)).map_err(|e| to_py(&e))?;
    Ok(found.map(|found| PyLoadFactor {
        system: system.clone(),
        statics: found.statics,
        forces: found.forces,
        moves: found.moves,
        mode: found.mode.map(|mode| PySystemMode { system, mode }),
        complete: found.complete,
    }))
}

/// One contact mode of a System at rest, of any size: it holds, or this is how it begins to move.
///
/// Parameters
/// ----------
/// system : System
/// load : dict or None, default None
///     {body: (fx, fy, moment)}, N and N m about its centre of mass.
/// acceleration : (2,) array_like or None, m/s², default None
///     In place of load: it acts like gravity on every body.
/// factor : float, default 1.0
///     The multiple of the load that acts beside gravity.
///
/// Returns
/// -------
/// SystemMode or None
///     A SystemMode; None if none was found. Forces that hold the system come first; of several
///     other modes it is one. `contact_modes` finds all modes of up to six contacts.
///
/// Raises
/// ------
/// ValueError
///     Names the argument.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> bricks = sf.System([sf.Block(2, 1, at=(3 * k, 0)) for k in range(100)], gravity=10)      # a row of bricks, friction 1/2
/// >>> mode = sf.onset(bricks, acceleration=(10, 0), factor=0.7)      # all slide
/// >>> bool(abs(mode.acceleration[::3] - 2).max() < 1e-9)
/// True
#[pyfunction]
#[pyo3(signature = (system, load=None, *, acceleration=None, factor=1.0))]
pub(crate) fn onset(
    system: &Bound<'_, PyAny>,
    load: Option<&Bound<'_, PyDict>>,
    acceleration: Option<&Bound<'_, PyAny>>,
    #[pyo3(from_py_with = input::factor)] factor: f64,
) -> PyResult<Option<PySystemMode>> {
    let owner = some_system(system)?;
    let load = read_load(&owner.get().0, load, acceleration)?;
    let system = owner.get().clone();
    let found = owner.py().detach(|| system.0.onset(load.as_ref(), factor));
    Ok(found.map_err(|e| to_py(&e))?.map(|mode| PySystemMode { system, mode }))
}

/// A contact mode of a System at rest.
///
/// Parameters
/// ----------
/// system : System
/// word : str
///     a letter for each contact: S separate, F fixed, R or L sliding.
/// acceleration : (dof,) array_like, m/s² and rad/s²
///     x, y and theta of each body.
/// forces : (contacts, 2) array_like, N
///     Tangential and normal; where several are possible, one of them.
/// factor : float, default 1.0
///     The multiple of the load that acts beside gravity.
#[pyclass(frozen, eq, name = "SystemMode", module = "standfast.results")]
#[derive(Clone, PartialEq)]
pub(crate) struct PySystemMode {
    system: PySystem,
    mode: SystemMode,
}

#[pymethods]
impl PySystemMode {
    #[new]
    #[pyo3(signature = (system, word, acceleration, forces, factor=1.0))]
    fn new(
        system: &Bound<'_, PyAny>,
        word: &str,
        #[pyo3(from_py_with = input::coordinate_accelerations)] acceleration: Vec<f64>,
        #[pyo3(from_py_with = input::contact_forces)] forces: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::factor)] factor: f64,
    ) -> PyResult<Self> {
        let system = some_system(system)?.get().clone();
        let letter = |letter| Mode::ALL.into_iter().find(|mode| mode.letter() == letter);
        let letters: Option<Vec<Mode>> = word.chars().map(letter).collect();
        let contacts = system.0.contacts().len();
        let wrong = |field: &str, value: String, allowed: String| {
            Err(to_py(&Error::Unusable { field: field.into(), value, allowed }))
        };
        let Some(letters) = letters.filter(|letters| letters.len() == contacts) else {
            let allowed = format!("{contacts} of the letters S, F, R, L, one for each contact");
            return wrong("word", format!("{word:?}"), allowed);
        };
        if acceleration.len() != system.dof() {
            let allowed = format!("one entry for each of the {} coordinates", system.dof());
            return wrong("acceleration", format!("[{} entries]", acceleration.len()), allowed);
        }
        let forces = system.own(forces)?;
        Ok(Self { system, mode: SystemMode { word: letters, factor, acceleration, forces } })
    }

    #[getter]
    fn system(&self) -> PySystem {
        self.system.clone()
    }

    #[getter]
    fn word(&self) -> String {
        self.mode.word.iter().map(|mode| mode.letter()).collect()
    }

    #[getter]
    fn factor(&self) -> f64 {
        self.mode.factor
    }

    #[getter]
    fn acceleration<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.mode.acceleration.to_pyarray(py)
    }

    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.mode.forces.concat(), &[self.mode.forces.len(), 2])
    }

    /// How it begins to move, by the names of the contacts and the bodies.
    fn __str__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.table")?.call_method1("system_mode_table", (slf,))
    }

    /// Draws how the system begins to move: its bodies moved along their accelerations, with marks where
    /// contacts open, slide and are hinges; or, if it holds, the forces that hold it.
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
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> stack = sf.System([sf.Block(1, 0.5), sf.Block(1, 0.5, at=(0.6, 0.5))])
    /// >>> sf.onset(stack).plot().axes[0].get_title(loc="left")
    /// 'begins to move: 1 contact opens'
    #[pyo3(signature = (path=None, *, ax=None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        path: Option<PathBuf>,
        ax: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.system_plot")?.call_method1("plot_mode", (slf, path, ax))
    }

    /// The HTML that a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.notebook")?.call_method1("of_system_mode", (slf,))
    }

    fn __repr__(&self) -> String {
        let word = self.word();
        let short = if word.len() > 40 { format!("{}…", &word[..40]) } else { word };
        format!("<SystemMode: {short}>")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments =
            (self.system(), self.word(), self.acceleration(py), self.forces(py)?, self.factor());
        Ok((py.get_type::<Self>().into_any(), arguments.into_pyobject(py)?.into_any()))
    }
}

/// How much of a load a System holds.
///
/// Parameters
/// ----------
/// system : System
/// static : float
///     The largest multiple of the load that contact forces within the friction cones can balance;
///     inf if there is no bound.
/// forces : (contacts, 2) array_like, N
///     Tangential and normal forces that balance it (without the load if there is no bound).
/// moves : float
///     The least multiple at which a contact opens or slides in a contact mode; inf if none does.
///     It is less than `static` where forces can balance what need not stand.
/// mode : SystemMode or None
///     a SystemMode that moves, at a load just above; or None.
/// complete : bool
///     Whether `moves` is the least of all words; of systems of more than eight contacts only the
///     word just above the static factor is tried.
#[pyclass(frozen, eq, name = "LoadFactor", module = "standfast.results")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyLoadFactor {
    system: PySystem,
    statics: f64,
    forces: Vec<[f64; 2]>,
    moves: f64,
    mode: Option<PySystemMode>,
    complete: bool,
}

#[pymethods]
impl PyLoadFactor {
    #[new]
    fn new(
        system: &Bound<'_, PyAny>,
        r#static: f64,
        #[pyo3(from_py_with = input::contact_forces)] forces: Vec<[f64; 2]>,
        moves: f64,
        mode: Option<Bound<'_, PySystemMode>>,
        complete: bool,
    ) -> PyResult<Self> {
        let system = some_system(system)?.get().clone();
        let forces = system.own(forces)?;
        let mode = mode.map(|mode| mode.get().clone());
        Ok(Self { system, statics: r#static, forces, moves, mode, complete })
    }

    #[getter]
    fn system(&self) -> PySystem {
        self.system.clone()
    }

    #[getter]
    fn r#static(&self) -> f64 {
        self.statics
    }

    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.forces.concat(), &[self.forces.len(), 2])
    }

    #[getter]
    fn moves(&self) -> f64 {
        self.moves
    }

    #[getter]
    fn mode(&self) -> Option<PySystemMode> {
        self.mode.clone()
    }

    #[getter]
    fn complete(&self) -> bool {
        self.complete
    }

    /// Draws the forces at the static factor beside the mode that moves; into `ax` only the mode. Without a
    /// mode only the forces are drawn, and the title says so.
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
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> brick = sf.System([sf.Block(2, 1)], gravity=10)
    /// >>> figure = sf.load_factor(brick, acceleration=(1, 0)).plot()
    /// >>> [axes.get_title(loc="left") for axes in figure.axes]
    /// ['forces hold up to 5 times the load', 'moves from 5 times the load on: 2 contacts slide']
    #[pyo3(signature = (path=None, *, ax=None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        path: Option<PathBuf>,
        ax: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.system_plot")?.call_method1("plot_factor", (slf, path, ax))
    }

    /// The HTML that a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.notebook")?.call_method1("of_load_factor", (slf,))
    }

    fn __repr__(&self) -> String {
        format!("<LoadFactor: static {}, moves {}>", self.statics, self.moves)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let arguments =
            (self.system(), self.statics, self.forces(py)?, self.moves, self.mode(), self.complete);
        Ok((py.get_type::<Self>().into_any(), arguments.into_pyobject(py)?.into_any()))
    }
}
