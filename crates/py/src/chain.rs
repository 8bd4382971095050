//! Chains of links.

use numpy::{PyArray1, PyArrayDyn, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::body::{Chain, ChainFields, Foot, HoldingChoice, Joint, JointKind, Link, MAX_DOF};

use crate::convert::{array, call, float, question, word};
use crate::error::to_py;
use crate::holding::{PyHoldingTorques, choice, numbers, pairs};
use crate::input;
use crate::mechanism::PyMechanism;
use crate::posture::PyPosture;

/// A straight link of a chain. `Chain` checks the values.
///
/// Parameters
/// ----------
/// mass : float, kg, ≥ 0
/// inertia : float, kg m², ≥ 0
///     About its own centre of mass.
/// length : float, m, > 0
/// center : float or None, m, default None
///     Distance of its centre of mass from its near end along its axis; None: half the length.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.Link(mass=1.0, inertia=1/12, length=1.0)
/// Link(mass=1.0, inertia=0.08333333333333333, length=1.0)
#[pyclass(frozen, eq, name = "Link", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyLink(Link);

#[pymethods]
impl PyLink {
    #[new]
    #[pyo3(signature = (mass, inertia, length, center=None, **unknown), text_signature = "(mass, inertia, length, center=None)")]
    fn new(
        #[pyo3(from_py_with = input::mass)] mass: f64,
        #[pyo3(from_py_with = input::inertia)] inertia: f64,
        #[pyo3(from_py_with = input::length_of_link)] length: f64,
        #[pyo3(from_py_with = input::center)] center: Option<f64>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Link", unknown)?;
        Ok(Self(Link { mass, inertia, length, center }))
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.0.mass
    }

    #[getter]
    fn inertia(&self) -> f64 {
        self.0.inertia
    }

    #[getter]
    fn length(&self) -> f64 {
        self.0.length
    }

    #[getter]
    fn center(&self) -> Option<f64> {
        self.0.center
    }

    fn __repr__(&self) -> String {
        let Link { mass, inertia, length, center } = self.0;
        let center = center.map_or_else(String::new, |at| format!(", center={}", float(at)));
        let [mass, inertia, length] = [mass, inertia, length].map(float);
        format!("Link(mass={mass}, inertia={inertia}, length={length}{center})")
    }

    fn __reduce__(&self, py: Python<'_>) -> (Py<PyAny>, (f64, f64, f64, Option<f64>)) {
        let Link { mass, inertia, length, center } = self.0;
        (py.get_type::<Self>().into_any().unbind(), (mass, inertia, length, center))
    }
}

/// A hinge between a link and its parent, or between link 1 of a pinned chain and the world. `Chain`
/// checks the values.
///
/// Parameters
/// ----------
/// kind : {"locked", "torque"}
///     It does not turn, or it turns under a constant torque.
/// torque : float, N m, default 0.0
///     On the joint coordinate; a locked joint ignores it.
/// armature : float, kg m², ≥ 0, default 0.0
///     Inertia of a rotor reflected through its gear.
/// parent : int or None, default None
///     Number of the parent link, from 1; None: the link before.
/// at : float or None, m, default None
///     Where the joint is, along the parent from its near end; None: at its length.
/// angle : float, rad, in (−π, π], default 0.0
///     Angle of the link's axis from that of its parent (of link 1 of a pinned chain:
///     from +x) at joint coordinate 0.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.Joint("torque", torque=-3)
/// Joint('torque', torque=-3.0)
#[pyclass(frozen, eq, name = "Joint", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyJoint(Joint);

#[pymethods]
impl PyJoint {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(signature = (kind, *, torque=0.0, armature=0.0, parent=None, at=None, angle=0.0, **unknown), text_signature = "(kind, *, torque=0.0, armature=0.0, parent=None, at=None, angle=0.0)")]
    fn new(
        #[pyo3(from_py_with = input::kind)] kind: &str,
        #[pyo3(from_py_with = input::torque)] torque: f64,
        #[pyo3(from_py_with = input::armature_of_joint)] armature: f64,
        #[pyo3(from_py_with = parent)] parent: Option<usize>,
        #[pyo3(from_py_with = input::at)] at: Option<f64>,
        #[pyo3(from_py_with = input::angle)] angle: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Joint", unknown)?;
        let kind: JointKind = call("kind", kind)?;
        Ok(Self(Joint { kind, torque, armature, parent, at, angle }))
    }

    #[getter]
    fn kind(&self) -> String {
        word(&self.0.kind)
    }

    #[getter]
    fn torque(&self) -> f64 {
        self.0.torque
    }

    #[getter]
    fn armature(&self) -> f64 {
        self.0.armature
    }

    #[getter]
    fn parent(&self) -> Option<usize> {
        self.0.parent
    }

    #[getter]
    fn at(&self) -> Option<f64> {
        self.0.at
    }

    #[getter]
    fn angle(&self) -> f64 {
        self.0.angle
    }

    fn __repr__(&self) -> String {
        let j = &self.0;
        let mut text = format!("Joint('{}'", j.kind);
        text += &given("torque", j.torque);
        text += &given("armature", j.armature);
        if let Some(parent) = j.parent {
            text += &format!(", parent={parent}");
        }
        if let Some(at) = j.at {
            text += &format!(", at={}", float(at));
        }
        text + &given("angle", j.angle) + ")"
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let keywords = PyDict::new(py);
        keywords.set_item("kind", self.kind())?;
        keywords.set_item("torque", self.0.torque)?;
        keywords.set_item("armature", self.0.armature)?;
        keywords.set_item("parent", self.0.parent)?;
        keywords.set_item("at", self.0.at)?;
        keywords.set_item("angle", self.0.angle)?;
        Ok((question(py.get_type::<Self>().into_any(), &keywords)?, ()))
    }
}

/// A point of a link on its ground, a straight line of `slope`, or a disc about such a point. A flat
/// foot has two of them on its link. `Chain` checks the values.
///
/// Parameters
/// ----------
/// link : int
///     Number of the link, from 1.
/// at : float or None, m, default None
///     Along the link from its near end; None: its far end.
/// radius : float, m, ≥ 0, default 0.0
///     Of the disc; 0: a point.
/// slope : float, rad, in (−π, π], default 0.0
///     As of `Contact`.
/// friction : float, from 0 to 1e6, default 0.0
///     Coefficient of friction μ.
/// restitution : float or None, in [0, 1], default None
///     None: that of the chain.
/// tangential_restitution : float, in [0, 1), default 0.0
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.Foot(2, friction=0.5)
/// Foot(2, friction=0.5)
#[pyclass(frozen, eq, name = "Foot", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyFoot(Foot);

#[pymethods]
impl PyFoot {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(signature = (link, *, at=None, radius=0.0, slope=0.0, friction=0.0, restitution=None, tangential_restitution=0.0, **unknown), text_signature = "(link, *, at=None, radius=0.0, slope=0.0, friction=0.0, restitution=None, tangential_restitution=0.0)")]
    fn new(
        #[pyo3(from_py_with = link)] link: usize,
        #[pyo3(from_py_with = input::at)] at: Option<f64>,
        #[pyo3(from_py_with = input::radius)] radius: f64,
        #[pyo3(from_py_with = input::slope)] slope: f64,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = input::own_restitution)] restitution: Option<f64>,
        #[pyo3(from_py_with = input::tangential_restitution)] tangential_restitution: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Foot", unknown)?;
        Ok(Self(Foot { link, at, radius, slope, friction, restitution, tangential_restitution }))
    }

    #[getter]
    fn link(&self) -> usize {
        self.0.link
    }

    #[getter]
    fn at(&self) -> Option<f64> {
        self.0.at
    }

    #[getter]
    fn radius(&self) -> f64 {
        self.0.radius
    }

    #[getter]
    fn slope(&self) -> f64 {
        self.0.slope
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
        let f = &self.0;
        let mut text = format!("Foot({}", f.link);
        if let Some(at) = f.at {
            text += &format!(", at={}", float(at));
        }
        text += &given("radius", f.radius);
        text += &given("slope", f.slope);
        text += &given("friction", f.friction);
        if let Some(e) = f.restitution {
            text += &format!(", restitution={}", float(e));
        }
        text + &given("tangential_restitution", f.tangential_restitution) + ")"
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let keywords = PyDict::new(py);
        keywords.set_item("link", self.0.link)?;
        keywords.set_item("at", self.0.at)?;
        keywords.set_item("radius", self.0.radius)?;
        keywords.set_item("slope", self.0.slope)?;
        keywords.set_item("friction", self.0.friction)?;
        keywords.set_item("restitution", self.0.restitution)?;
        keywords.set_item("tangential_restitution", self.0.tangential_restitution)?;
        Ok((question(py.get_type::<Self>().into_any(), &keywords)?, ()))
    }
}

/// Ends of links, and points of feet.
type LinksAndFeet<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>);

/// A planar open chain (tree) of straight links on hinges: a robot with feet, or an arm. At a
/// configuration q it gives a Mechanism.
///
/// The angle of a link is that of its parent plus the angle of its joint plus the joint coordinate.
///
/// Parameters
/// ----------
/// base : {"floating", "pinned"}
///     "floating", q = (x, y, θ, joint coordinates) with the near end (x, y) of link 1 and the
///     angle θ of its axis from +x; or "pinned", q = joint coordinates, and the first joint hinges
///     link 1 at the origin.
/// links : sequence of Link, default ()
///     Numbered from 1, each after its parent.
/// joints : sequence of Joint, default ()
///     Joint k connects link k + 1 of a floating chain, link k of a pinned one.
/// feet : sequence of Foot, default ()
///     They all touch the ground.
/// gravity : float, m/s², ≥ 0, default 9.81
///     Downwards.
/// restitution : float, in [0, 1], default 0.0
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range.
///
/// Examples
/// --------
/// >>> import math
/// >>> import standfast as sf
/// >>> hip = sf.Joint("torque", parent=1, at=0, angle=-math.pi/2)
/// >>> leg = sf.Link(mass=1, inertia=1/12, length=1)
/// >>> biped = sf.Chain(links=[sf.Link(mass=10, inertia=0.4, length=1, center=0), leg, leg], joints=[hip, hip],
/// ...                  feet=[sf.Foot(2, friction=0.5), sf.Foot(3, friction=0.5)])
/// >>> biped.dof, biped.mechanism([0, 0, 0.1, -0.5, 0.5]).contact_space.rank
/// (5, 4)
#[pyclass(frozen, eq, name = "Chain", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyChain(pub(crate) Chain);

#[pymethods]
impl PyChain {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(signature = (base="floating", links=Vec::new(), joints=Vec::new(), feet=Vec::new(), *, gravity=9.81, restitution=0.0, **unknown), text_signature = "(base=\"floating\", links=(), joints=(), feet=(), *, gravity=9.81, restitution=0.0)")]
    fn new(
        #[pyo3(from_py_with = input::base)] base: &str,
        #[pyo3(from_py_with = links)] links: Vec<Link>,
        #[pyo3(from_py_with = joints)] joints: Vec<Joint>,
        #[pyo3(from_py_with = feet)] feet: Vec<Foot>,
        #[pyo3(from_py_with = input::gravity)] gravity: f64,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Chain", unknown)?;
        let base = call("base", base)?;
        Chain::new(ChainFields { base, links, joints, feet, gravity, restitution })
            .map(Self)
            .map_err(|e| to_py(&e))
    }

    #[getter]
    fn base(&self) -> String {
        word(&self.0.fields().base)
    }

    #[getter]
    fn links(&self) -> Vec<PyLink> {
        self.0.fields().links.iter().copied().map(PyLink).collect()
    }

    #[getter]
    fn joints(&self) -> Vec<PyJoint> {
        self.0.fields().joints.iter().copied().map(PyJoint).collect()
    }

    #[getter]
    fn feet(&self) -> Vec<PyFoot> {
        self.0.fields().feet.iter().copied().map(PyFoot).collect()
    }

    #[getter]
    fn gravity(&self) -> f64 {
        self.0.fields().gravity
    }

    #[getter]
    fn restitution(&self) -> f64 {
        self.0.fields().restitution
    }

    /// Number of coordinates, with those of locked joints.
    #[getter]
    fn dof(&self) -> usize {
        self.0.dof()
    }

    /// The Mechanism of this chain at q : (dof,) m, rad. Locked joints are its locked coordinates.
    ///
    /// Parameters
    /// ----------
    /// q : (dof,) array_like
    ///     The configuration.
    /// torques : {"holding", "least"}, array_like or None, default None
    ///     None, the joints have their own torques; "holding" or "least", those of `holding_torques`,
    ///     its choice or the least ones; or an array, N m, one for each joint of kind "torque". If no
    ///     torques hold the chain, "holding" and "least" are zero: the verdict on it is "unstable" by
    ///     "not-equilibrium".
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For a q that is not finite or has angles beyond ±2π, a mass matrix that is not positive
    ///     definite, or no feet.
    #[pyo3(signature = (q, torques=None))]
    fn mechanism(
        &self,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
        torques: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<PyMechanism> {
        let made = match torques.map(torques_of).transpose()? {
            None => self.0.mechanism(&q),
            Some(Torques::Given(torques)) => self.0.mechanism_under(&q, &torques),
            Some(Torques::Holding(choice)) => self.0.mechanism_held(&q, choice),
        };
        made.map(PyMechanism).map_err(|e| to_py(&e))
    }

    /// This chain at q : (dof,) with all joints locked, as a Posture: a rigid body that stands on its feet.
    ///
    /// Parameters
    /// ----------
    /// q : (dof,) array_like
    ///     The configuration.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `mechanism` does, and for a pinned chain, which does not move if its joints are locked.
    fn posture(
        &self,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
    ) -> PyResult<PyPosture> {
        self.0.posture(&q).map(PyPosture).map_err(|e| to_py(&e))
    }

    /// The joint torques and contact forces that hold the chain at q : (dof,) without motion, as
    /// HoldingTorques; None if there are none.
    ///
    /// Parameters
    /// ----------
    /// q : (dof,) array_like
    ///     The configuration.
    /// contacts : sequence of int or None, default None
    ///     Numbers of the feet that carry forces, from 1; None: all.
    /// choose : {"middle", "least"}
    ///     "middle", the middle of `internal_force` if there is one internal force with a bounded
    ///     interval, otherwise as "least"; or "least", the least Σ τ² within the friction cones, and
    ///     with these torques the least forces. The least torques often put a contact on the border of
    ///     its cone.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Link(mass=1, inertia=1/12, length=1)
    /// >>> arm = sf.Chain("pinned", [rod, rod], [sf.Joint("torque"), sf.Joint("torque")], gravity=10)
    /// >>> arm.holding_torques([0, 0]).torques         # stretched out: mg(1/2 + 3/2) and mg/2
    /// array([20.,  5.])
    #[pyo3(signature = (q, contacts=None, choose=HoldingChoice::Middle), text_signature = "($self, q, contacts=None, choose=\"middle\")")]
    fn holding_torques(
        slf: &Bound<'_, Self>,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
        #[pyo3(from_py_with = numbers)] contacts: Option<Vec<usize>>,
        #[pyo3(from_py_with = choice)] choose: HoldingChoice,
    ) -> PyResult<Option<PyHoldingTorques>> {
        let held = slf.get().0.holding_torques(&q, contacts.as_deref(), choose);
        let held = held.map_err(|e| to_py(&e))?;
        held.map(|held| PyHoldingTorques::new(held, choose, slf, q)).transpose()
    }

    /// Where the chain is at q : (dof,): near and far end of each link, (links, 2, 2) m, and the points of
    /// the feet, (feet, 2) m.
    ///
    /// Parameters
    /// ----------
    /// q : (dof,) array_like
    ///     The configuration.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Link(mass=1, inertia=1/12, length=1)
    /// >>> arm = sf.Chain("pinned", [rod, rod], [sf.Joint("torque"), sf.Joint("torque")], [sf.Foot(2)])
    /// >>> links, feet = arm.points([0, 0])
    /// >>> links.tolist(), feet.tolist()
    /// ([[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [2.0, 0.0]]], [[2.0, 0.0]])
    fn points<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
    ) -> PyResult<LinksAndFeet<'py>> {
        let points = self.0.points(&q).map_err(|e| to_py(&e))?;
        let links = points.links.as_flattened().as_flattened().to_vec();
        Ok((array(py, links, &[points.links.len(), 2, 2])?, pairs(py, &points.feet)?))
    }

    /// The bias h(q, 0), (dof,) N, N m: the generalised forces that hold the chain against gravity.
    ///
    /// Parameters
    /// ----------
    /// q : (dof,) array_like
    ///     The configuration.
    fn bias<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.0.bias(&q).map_err(|e| to_py(&e))?.to_pyarray(py))
    }

    /// The centre of mass (x, y) of all links at q : (dof,), m.
    ///
    /// Parameters
    /// ----------
    /// q : (dof,) array_like
    ///     The configuration.
    fn center_of_mass(
        &self,
        #[pyo3(from_py_with = input::coordinates)] q: Vec<f64>,
    ) -> PyResult<(f64, f64)> {
        self.0.center_of_mass(&q).map(Into::into).map_err(|e| to_py(&e))
    }

    fn __repr__(&self) -> String {
        let f = self.0.fields();
        let links: Vec<String> = self.links().iter().map(PyLink::__repr__).collect();
        let joints: Vec<String> = self.joints().iter().map(PyJoint::__repr__).collect();
        let feet: Vec<String> = self.feet().iter().map(PyFoot::__repr__).collect();
        format!(
            "Chain('{}', links=[{}], joints=[{}], feet=[{}], gravity={}{})",
            f.base,
            links.join(", "),
            joints.join(", "),
            feet.join(", "),
            float(f.gravity),
            given("restitution", f.restitution)
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, ())> {
        let keywords = PyDict::new(py);
        keywords.set_item("base", self.base())?;
        keywords.set_item("links", self.links())?;
        keywords.set_item("joints", self.joints())?;
        keywords.set_item("feet", self.feet())?;
        keywords.set_item("gravity", self.gravity())?;
        keywords.set_item("restitution", self.restitution())?;
        Ok((question(py.get_type::<Self>().into_any(), &keywords)?, ()))
    }
}

/// A keyword of a repr, unless its value is zero.
fn given(name: &str, value: f64) -> String {
    if value == 0.0 { String::new() } else { format!(", {name}={}", float(value)) }
}

/// Reads the number of a parent link, or None.
fn parent(value: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    if value.is_none() { Ok(None) } else { number_of_link("parent", value).map(Some) }
}

/// Reads the number of the link of a foot.
fn link(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    number_of_link("link", value)
}

fn number_of_link(field: &str, value: &Bound<'_, PyAny>) -> PyResult<usize> {
    input::whole(field, value, 1..=MAX_DOF)
}

/// The torques of a chain.
enum Torques {
    Given(Vec<f64>),
    Holding(HoldingChoice),
}

/// Reads "holding", "least" or an array.
fn torques_of(value: &Bound<'_, PyAny>) -> PyResult<Torques> {
    match value.extract::<String>().as_deref() {
        Ok("holding") => Ok(Torques::Holding(HoldingChoice::Middle)),
        Ok("least") => Ok(Torques::Holding(HoldingChoice::Least)),
        Ok(_) => Err(input::not_allowed(
            "torques",
            value,
            "None, 'holding', 'least' or an array is needed",
        )),
        Err(_) if value.cast::<PyHoldingTorques>().is_ok() => {
            Err(input::wrong_type("torques", value, "its array .torques is needed"))
        }
        Err(_) => input::torques(value).map(Torques::Given),
    }
}

fn links(value: &Bound<'_, PyAny>) -> PyResult<Vec<Link>> {
    input::sequence("links", value, |field, item| {
        let found = item.cast::<PyLink>();
        let found = found.map_err(|_| input::wrong_type(field, item, "a Link is needed"))?;
        Ok(found.get().0)
    })
}

fn joints(value: &Bound<'_, PyAny>) -> PyResult<Vec<Joint>> {
    input::sequence("joints", value, |field, item| {
        let found = item.cast::<PyJoint>();
        let found = found.map_err(|_| input::wrong_type(field, item, "a Joint is needed"))?;
        Ok(found.get().0)
    })
}

fn feet(value: &Bound<'_, PyAny>) -> PyResult<Vec<Foot>> {
    input::sequence("feet", value, |field, item| {
        let found = item.cast::<PyFoot>();
        let found = found.map_err(|_| input::wrong_type(field, item, "a Foot is needed"))?;
        Ok(found.get().0)
    })
}
