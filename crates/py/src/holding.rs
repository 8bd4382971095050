//! The torques that hold a chain or a mechanism.

use numpy::{PyArray1, PyArrayDyn, ToPyArray};
use pyo3::prelude::*;
use pyo3::{IntoPyObjectExt, PyClass};
use standfast::body::{HoldingChoice, HoldingTorques};

use crate::convert::{array, call, word};
use crate::input;

/// The torques of joints and the forces of contacts that hold a chain or a mechanism at rest.
///
/// Attributes
/// ----------
/// torques, forces : ndarray
///     The solution chosen.
/// torque_interval, force_low, force_high : ndarray
///     The bounds of all solutions. Forces are (tangential, normal), N; torques N m.
///
/// Examples
/// --------
/// >>> import math
/// >>> import standfast as sf
/// >>> leg = sf.Link(mass=1, inertia=1/12, length=1)
/// >>> legs = sf.Chain(links=[leg, leg], joints=[sf.Joint("torque", at=0)], gravity=10,
/// ...                 feet=[sf.Foot(1, friction=0.5), sf.Foot(2, friction=0.5)])
/// >>> held = legs.holding_torques([0, 0, math.radians(-120), math.radians(60)])
/// >>> held.forces.round(9)[:, 1], held.freedom
/// (array([10., 10.]), 1)
/// >>> held.torque_interval.round(3)
/// array([[-6.83, ...
#[pyclass(frozen, name = "HoldingTorques", module = "standfast.results")]
pub(crate) struct PyHoldingTorques {
    held: HoldingTorques,
    choose: HoldingChoice,
    /// The chain or the mechanism.
    of: Py<PyAny>,
    /// The first argument of the question: q of a chain, the joints of a mechanism.
    first: Py<PyAny>,
}

impl PyHoldingTorques {
    pub(crate) fn new<'py, T: PyClass>(
        held: HoldingTorques,
        choose: HoldingChoice,
        of: &Bound<'py, T>,
        first: impl IntoPyObjectExt<'py>,
    ) -> PyResult<Self> {
        let first = first.into_py_any(of.py())?;
        Ok(Self { held, choose, of: of.clone().into_any().unbind(), first })
    }
}

#[pymethods]
impl PyHoldingTorques {
    /// The joints with a torque, in the order of the torques: their numbers in a chain, from 1; their coordinates in a mechanism, from 0.
    #[getter]
    fn joints(&self) -> Vec<usize> {
        self.held.joints.clone()
    }

    /// Numbers of the contacts that carry forces, from 1: the order of the forces.
    #[getter]
    fn contacts(&self) -> Vec<usize> {
        self.held.contacts.clone()
    }

    /// The torques chosen, (joints,).
    #[getter]
    fn torques<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.held.torques.to_pyarray(py)
    }

    /// The forces chosen, (contacts, 2).
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        pairs(py, &self.held.forces)
    }

    /// Least and largest torque of each joint, (joints, 2); ±inf where there is no bound.
    #[getter]
    fn torque_interval<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        pairs(py, &self.held.torque_interval)
    }

    /// Least force of each contact, (contacts, 2); −inf where there is no bound.
    #[getter]
    fn force_low<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        pairs(py, &self.held.force_low)
    }

    /// Largest force of each contact, (contacts, 2); inf where there is no bound.
    #[getter]
    fn force_high<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        pairs(py, &self.held.force_high)
    }

    /// Dimension of the family of torques and forces that satisfy the equations, whatever the cones.
    #[getter]
    fn freedom(&self) -> usize {
        self.held.freedom
    }

    /// The interval (low, high) of s in which free + s · internal lies in the cones, if freedom is 1; else None.
    #[getter]
    fn internal_force(&self) -> Option<(f64, f64)> {
        self.held.internal_force.map(Into::into)
    }

    /// The least torques without cones, (joints,).
    #[getter]
    fn free_torques<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.held.free_torques.to_pyarray(py)
    }

    /// Their least forces, (contacts, 2).
    #[getter]
    fn free_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        pairs(py, &self.held.free_forces)
    }

    /// Torques of the vector (torques, forces) in which the family extends, (joints,), if freedom is 1; else empty. The torques have the norm 1 N m, or
    /// the forces the norm 1 N if the torques are the same in all of the family. Its first component that is not zero is positive.
    #[getter]
    fn internal_torques<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.held.internal_torques.to_pyarray(py)
    }

    /// Forces of this vector, (contacts, 2) or empty.
    #[getter]
    fn internal_forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        pairs(py, &self.held.internal_forces)
    }

    fn __repr__(&self) -> String {
        let torques = shown(&self.held.torques);
        let forces: Vec<String> = self
            .held
            .forces
            .iter()
            .map(|[t, n]| format!("({}, {})", short(*t), short(*n)))
            .collect();
        let (forces, freedom) = (forces.join(", "), self.held.freedom);
        format!("<HoldingTorques: torques {torques} N m, forces [{forces}] N, freedom {freedom}>")
    }

    /// Whether torques, forces and bounds are the same.
    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().held == self.held)
    }

    /// Asking again gives the same answer to the last bit.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let again = self.of.bind(py).getattr("holding_torques")?;
        let arguments = (self.first.bind(py), self.contacts(), word(&self.choose));
        Ok((again, arguments.into_pyobject(py)?.into_any()))
    }
}

/// Six digits of a number.
fn short(value: f64) -> String {
    let text = format!("{value:.5e}");
    let size: i32 = text.split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0);
    if (-5..6).contains(&size) {
        let text = format!("{value:.*}", (5 - size).max(0) as usize);
        if text.contains('.') {
            return text.trim_end_matches('0').trim_end_matches('.').into();
        }
        return text;
    }
    text
}

fn shown(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|value| short(*value)).collect::<Vec<_>>().join(", "))
}

/// Reads "middle" or "least".
pub(crate) fn choice(value: &Bound<'_, PyAny>) -> PyResult<HoldingChoice> {
    call("choose", input::choose(value)?)
}

/// Reads the numbers of contacts, or None.
pub(crate) fn numbers(value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<usize>>> {
    if value.is_none() {
        return Ok(None);
    }
    input::sequence("contacts", value, |field, item| input::whole(field, item, 0..=usize::MAX))
        .map(Some)
}

/// Pairs as an array of shape (n, 2).
pub(crate) fn pairs<'py>(
    py: Python<'py>,
    of: &[[f64; 2]],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    array(py, of.as_flattened().to_vec(), &[of.len(), 2])
}
