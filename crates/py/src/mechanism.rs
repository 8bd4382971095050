//! Mechanisms and the dynamics of their contacts.

use numpy::{PyArray1, PyArrayDyn, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::Error;
use standfast::body::{ContactRows, HoldingChoice, MAX_DOF, Mechanism, MechanismFields};

use crate::convert::{array, counted, float, local_model, numbers_text, question};
use crate::error::to_py;
use crate::holding::{PyHoldingTorques, choice, numbers};
use crate::input;
use crate::posture::{PyPosture, posture};

/// The Jacobian rows of one contact of a mechanism, its friction and its restitution.
///
/// Parameters
/// ----------
/// normal, tangential : (dof,) array_like
///     N and T: rate of the gap and sliding velocity per unit velocity of each coordinate. With the
///     tangent t = (cos, sin) of the ground and its normal n = (−sin, cos), N = nᵀJ and T = tᵀJ, J
///     the Jacobian of the contact point.
/// friction : float, from 0 to 1e6, default 0.0
///     Coefficient of friction μ.
/// restitution : float or None, in [0, 1], default None
///     None: that of the mechanism.
/// tangential_restitution : float, in [0, 1), default 0.0
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.ContactRows([0, 1, -0.5], [1, 0, 0], friction=0.5)
/// ContactRows(normal=[0.0, 1.0, -0.5], tangential=[1.0, 0.0, 0.0], friction=0.5)
#[pyclass(frozen, eq, name = "ContactRows", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyContactRows(pub(crate) ContactRows);

#[pymethods]
impl PyContactRows {
    #[new]
    #[pyo3(signature = (normal, tangential, *, friction=0.0, restitution=None, tangential_restitution=0.0, **unknown), text_signature = "(normal, tangential, *, friction=0.0, restitution=None, tangential_restitution=0.0)")]
    fn new(
        #[pyo3(from_py_with = input::normal)] normal: Vec<f64>,
        #[pyo3(from_py_with = input::tangential)] tangential: Vec<f64>,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = input::own_restitution)] restitution: Option<f64>,
        #[pyo3(from_py_with = input::tangential_restitution)] tangential_restitution: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("ContactRows", unknown)?;
        Ok(Self(ContactRows { normal, tangential, friction, restitution, tangential_restitution }))
    }

    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.normal.to_pyarray(py)
    }

    #[getter]
    fn tangential<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.tangential.to_pyarray(py)
    }

    #[getter]
    fn friction(&self) -> f64 {
        self.0.friction
    }

    #[getter]
    fn restitution(&self) -> Option<f64> {
        self.0.restitution
    }

    #[getter]
    fn tangential_restitution(&self) -> f64 {
        self.0.tangential_restitution
    }

    fn __repr__(&self) -> String {
        let c = &self.0;
        let mut text = format!(
            "ContactRows(normal={}, tangential={}, friction={}",
            numbers_text(&c.normal),
            numbers_text(&c.tangential),
            float(c.friction)
        );
        if let Some(e) = c.restitution {
            text += &format!(", restitution={}", float(e));
        }
        if c.tangential_restitution != 0.0 {
            text += &format!(", tangential_restitution={}", float(c.tangential_restitution));
        }
        text + ")"
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let keywords = PyDict::new(py);
        keywords.set_item("normal", &self.0.normal)?;
        keywords.set_item("tangential", &self.0.tangential)?;
        keywords.set_item("friction", self.0.friction)?;
        keywords.set_item("restitution", self.0.restitution)?;
        keywords.set_item("tangential_restitution", self.0.tangential_restitution)?;
        Ok((question(py.get_type::<Self>().into_any(), &keywords)?, ()))
    }
}

/// A mechanism with frictional contacts in a posture, given by its matrices: with the displacement q of
/// its coordinates from the posture, in which all contacts touch, M q̈ = load + Σ (T_iᵀ f_t,i + N_iᵀ
/// f_n,i). A rigid body has q = (x, y, θ), M = diag(m, m, mρ²), load (0, −mg, 0).
///
/// Parameters
/// ----------
/// mass_matrix : (dof, dof) array_like
///     M, symmetric and positive definite in the coordinates that are not locked.
/// load : (dof,) array_like
///     Bτ − h: generalised forces of the joint torques less the bias; gravity acts downwards.
/// contacts : sequence of ContactRows
///     Numbered from 1.
/// restitution : float, in [0, 1], default 0.0
/// locked : sequence of int, default ()
///     Coordinates that do not move, from 0.
/// armature : (dof,) array_like or None, ≥ 0, default None
///     Added to the diagonal of M.
/// coordinate_names, contact_names : sequence of str, default ()
///     Names for reports, one for each or none.
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> feet = [sf.ContactRows([0, 1, b], [1, 0, 0], friction=0.5) for b in (-0.5, 0.5)]
/// >>> rod = sf.Mechanism([[2, 0, 0], [0, 2, 0], [0, 0, 0.5]], [0, -20, 0], feet)      # ρ = L: its ends do not feel each other
/// >>> rod.local().psi, rod.contact_space.rank
/// ((0.0, 0.0), 3)
/// >>> rod.contact_space.b
/// array([  0., -10.,   0., -10.])
#[pyclass(frozen, eq, name = "Mechanism", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyMechanism(pub(crate) Mechanism);

#[pymethods]
impl PyMechanism {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(signature = (mass_matrix, load, contacts, *, restitution=0.0, locked=Vec::new(), armature=None, coordinate_names=Vec::new(), contact_names=Vec::new(), **unknown), text_signature = "(mass_matrix, load, contacts, *, restitution=0.0, locked=(), armature=None, coordinate_names=(), contact_names=())")]
    fn new(
        #[pyo3(from_py_with = input::mass_matrix)] mass_matrix: Vec<Vec<f64>>,
        #[pyo3(from_py_with = input::load)] load: Vec<f64>,
        #[pyo3(from_py_with = contacts)] contacts: Vec<ContactRows>,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        #[pyo3(from_py_with = locked)] locked: Vec<usize>,
        #[pyo3(from_py_with = input::armature)] armature: Option<Vec<f64>>,
        #[pyo3(from_py_with = input::coordinate_names)] coordinate_names: Vec<String>,
        #[pyo3(from_py_with = input::contact_names)] contact_names: Vec<String>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Mechanism", unknown)?;
        if armature.as_ref().is_some_and(|armature| armature.len() != load.len()) {
            return Err(to_py(&Error::Unusable {
                field: "armature".into(),
                value: format!("array of shape [{}]", armature.map_or(0, |a| a.len())),
                allowed: format!("one entry for each of the {} coordinates, or None", load.len()),
            }));
        }
        Mechanism::new(MechanismFields {
            mass_matrix,
            load,
            contacts,
            restitution,
            locked,
            armature: armature.unwrap_or_default(),
            coordinate_names,
            contact_names,
        })
        .map(Self)
        .map_err(|e| to_py(&e))
    }

    /// A rigid body in its nominal posture, with q = (x, y, θ): its contacts that touch.
    ///
    /// Parameters
    /// ----------
    /// posture : Posture
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.5)
    /// >>> sf.Mechanism.of_posture(rod).mass_matrix.diagonal()
    /// array([1.  , 1.  , 0.25])
    #[staticmethod]
    fn of_posture(#[pyo3(from_py_with = posture)] posture: PyPosture) -> PyResult<Self> {
        Mechanism::of_posture(&posture.0).map(Self).map_err(|e| to_py(&e))
    }

    #[getter]
    fn mass_matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        array(py, self.0.fields().mass_matrix.concat(), &[self.0.dof(); 2])
    }

    #[getter]
    fn load<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.fields().load.to_pyarray(py)
    }

    #[getter]
    fn contacts(&self) -> Vec<PyContactRows> {
        self.0.contacts().iter().cloned().map(PyContactRows).collect()
    }

    #[getter]
    fn restitution(&self) -> f64 {
        self.0.fields().restitution
    }

    #[getter]
    fn locked(&self) -> Vec<usize> {
        self.0.fields().locked.clone()
    }

    #[getter]
    fn armature<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let armature = &self.0.fields().armature;
        (!armature.is_empty()).then(|| armature.to_pyarray(py))
    }

    /// Names of the coordinates; empty if they have none.
    #[getter]
    fn coordinate_names(&self) -> Vec<String> {
        self.0.fields().coordinate_names.clone()
    }

    /// Names of the contacts; empty if they have none.
    #[getter]
    fn contact_names(&self) -> Vec<String> {
        self.0.fields().contact_names.clone()
    }

    /// Number of coordinates, with those that are locked.
    #[getter]
    fn dof(&self) -> usize {
        self.0.dof()
    }

    /// The dynamics of the contacts, a ContactSpace.
    #[getter]
    fn contact_space(&self) -> PyContactSpace {
        PyContactSpace(self.clone())
    }

    /// The rigid body that the mechanism is with all joints locked, a Posture, with the point of which (x,
    /// y) are the coordinates at the origin. θ has to be counterclockwise in the plane of x and y. Its
    /// contacts are points: the rows do not have the radius of a round foot, which turns over its ground in
    /// motions by whole angles.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If the coordinates that are not locked are not those (x, y, θ) of a rigid body under
    ///     gravity.
    fn posture(&self) -> PyResult<PyPosture> {
        self.0.posture().map(PyPosture).map_err(|e| to_py(&e))
    }

    /// The torques of `joints` that hold the mechanism without motion, to be added to the load, and the
    /// contact forces, as HoldingTorques; None if there are none. With the load −h they are the torques τ
    /// of the joints.
    ///
    /// Parameters
    /// ----------
    /// joints : sequence of int
    ///     Coordinates with a torque, from 0; the other ones that are not locked have none, such as
    ///     those of a floating base.
    /// contacts : sequence of int or None, default None
    ///     Numbers of the contacts that carry forces, from 1; None: all.
    /// choose : {"middle", "least"}
    ///     "middle", the middle of `internal_force` if there is one internal force with a bounded
    ///     interval, otherwise as "least"; or "least", the least Σ τ² within the friction cones, and
    ///     with these torques the least forces. The least torques often put a contact on the border of
    ///     its cone. Where forces and moments are mixed among the joints, Σ τ² depends on the unit of
    ///     length.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Names `joints` or `contacts`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> foot = sf.ContactRows([0, 1, 0], [1, 0, 0], friction=0.5)             # coordinates x, y, and the height of a lift on the body
    /// >>> lift = sf.Mechanism([[3, 0, 0], [0, 3, 1], [0, 1, 1]], [0, -30, -10], [foot])
    /// >>> lift.holding_torques([2])
    /// <HoldingTorques: torques [10] N m, forces [(0, 30)] N, freedom 0>
    #[pyo3(signature = (joints, contacts=None, choose=HoldingChoice::Middle), text_signature = "($self, joints, contacts=None, choose=\"middle\")")]
    fn holding_torques(
        slf: &Bound<'_, Self>,
        joints: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = numbers)] contacts: Option<Vec<usize>>,
        #[pyo3(from_py_with = choice)] choose: HoldingChoice,
    ) -> PyResult<Option<PyHoldingTorques>> {
        let last = slf.get().0.dof() - 1;
        let joints =
            input::sequence("joints", joints, |field, item| input::whole(field, item, 0..=last))?;
        let held = slf.get().0.holding_torques(&joints, contacts.as_deref(), choose);
        let held = held.map_err(|e| to_py(&e))?;
        held.map(|held| PyHoldingTorques::new(held, choose, slf, joints)).transpose()
    }

    /// The frictionless local model of the two gaps, with phi = (0, 0). Two contacts only.
    fn local<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        local_model(py, &self.0.local().map_err(|e| to_py(&e))?)
    }

    pub(crate) fn __repr__(&self) -> String {
        let f = self.0.fields();
        let matrix: Vec<String> = f.mass_matrix.iter().map(|row| numbers_text(row)).collect();
        let contacts: Vec<String> = self.contacts().iter().map(PyContactRows::__repr__).collect();
        let mut text = format!(
            "Mechanism(mass_matrix=[{}], load={}, contacts=[{}]",
            matrix.join(", "),
            numbers_text(&f.load),
            contacts.join(", ")
        );
        if f.restitution != 0.0 {
            text += &format!(", restitution={}", float(f.restitution));
        }
        if !f.locked.is_empty() {
            text += &format!(", locked={:?}", f.locked);
        }
        if !f.armature.is_empty() {
            text += &format!(", armature={}", numbers_text(&f.armature));
        }
        let named =
            [("coordinate_names", &f.coordinate_names), ("contact_names", &f.contact_names)];
        for (name, names) in named.into_iter().filter(|(_, names)| !names.is_empty()) {
            text += &format!(", {name}={names:?}");
        }
        text + ")"
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let f = self.0.fields();
        let keywords = PyDict::new(py);
        keywords.set_item("mass_matrix", &f.mass_matrix)?;
        keywords.set_item("load", &f.load)?;
        keywords.set_item("contacts", self.contacts())?;
        keywords.set_item("restitution", f.restitution)?;
        keywords.set_item("locked", &f.locked)?;
        keywords.set_item("armature", (!f.armature.is_empty()).then_some(&f.armature))?;
        keywords.set_item("coordinate_names", &f.coordinate_names)?;
        keywords.set_item("contact_names", &f.contact_names)?;
        Ok((question(py.get_type::<Self>().into_any(), &keywords)?, ()))
    }
}

/// The dynamics of the contacts of a mechanism, whatever its number of coordinates: (v̇_t, ḧ) = b + W
/// f, and W P for the change of velocity by impulses P. Its rows are in the order of the contacts, each
/// (tangential, normal).
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Mechanism.of_posture(sf.Posture.rod(half_length=0.5, gyration_radius=0.5, gravity=10))
/// >>> rod.contact_space
/// <ContactSpace: 2 contacts, rank 3>
/// >>> rod.contact_space.W.diagonal()                  # 1/m along the ground, 1/m + L²/(mρ²) = 2/m into it
/// array([1., 2., 1., 2.])
#[pyclass(frozen, eq, name = "ContactSpace", module = "standfast.results")]
#[derive(PartialEq)]
pub(crate) struct PyContactSpace(PyMechanism);

#[pymethods]
impl PyContactSpace {
    /// W, (2n, 2n), symmetric and positive semidefinite, 1/kg.
    #[getter]
    #[pyo3(name = "W")]
    fn w<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let w = self.0.0.contact_space().w();
        array(py, w.iter().copied().collect(), &[w.nrows(); 2])
    }

    /// b, (2n,) m/s²: accelerations of the contacts without contact forces.
    #[getter]
    fn b<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.0.contact_space().b().as_slice().to_pyarray(py)
    }

    /// Rank of W: 3 for a rigid body on two contacts, up to 4 with free joints.
    #[getter]
    fn rank(&self) -> usize {
        self.0.0.contact_space().rank()
    }

    fn __repr__(&self) -> String {
        let count = counted(self.0.0.contacts().len(), "contact");
        format!("<ContactSpace: {count}, rank {}>", self.rank())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PyMechanism,))> {
        let get = py.import("operator")?.getattr("attrgetter")?.call1(("contact_space",))?;
        Ok((get, (self.0.clone(),)))
    }
}

/// Reads the contacts of a mechanism.
fn contacts(value: &Bound<'_, PyAny>) -> PyResult<Vec<ContactRows>> {
    input::per_contact("contacts", value, |field, item| {
        let rows = item.cast::<PyContactRows>();
        let rows = rows.map_err(|_| input::wrong_type(field, item, "ContactRows are needed"))?;
        Ok(rows.get().0.clone())
    })
}

/// Reads the locked coordinates.
fn locked(value: &Bound<'_, PyAny>) -> PyResult<Vec<usize>> {
    input::sequence("locked", value, |field, item| input::whole(field, item, 0..=MAX_DOF - 1))
}

/// Reads a posture, or a mechanism that is a rigid body.
pub(crate) fn body(value: &Bound<'_, PyAny>) -> PyResult<PyPosture> {
    if let Ok(mechanism) = value.cast::<PyMechanism>() {
        return mechanism.get().0.posture().map(PyPosture).map_err(|e| to_py(&e));
    }
    let posture = value.cast::<PyPosture>();
    posture.map(|found| found.get().clone()).map_err(|_| {
        input::wrong_type(
            "posture",
            value,
            "a Posture, or a Mechanism with all joints locked, is needed",
        )
    })
}
