//! Proved bounds on the times of a run.

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use standfast::outcome::{Enclosure, Uncertain};

/// Intervals that are proved to contain the times of the collisions of a run, up to its first Zeno
/// point. The doubles of the body (or the LocalModel) and of the start are taken as exact, except that
/// a contact that starts in the terrain within rounding counts as touching. In the full model gaps must
/// be concave, and the intervals end after some dozens of collisions, because each collision widens the
/// next interval by a factor of about three. The Zeno point is enclosed in the local model only.
///
/// Attributes
/// ----------
/// impacts : ndarray
///     Structured array with the fields contact (from 1), index (from 0), low, high (s after the
///     start). It is also proved that these collisions happen, in this order.
/// zeno : (float, float) or None, s
///     (low, high) after the start, of the first Zeno point.
/// contacts : tuple of int
///     The contacts that come to rest there.
/// reason : str or None
///     Why nothing is proved after the last of the impacts.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
/// >>> run = sf.simulate(rod, q=(0, 0.011, 0.002), qdot=(0, 0, 0), model="local", stop="zeno", certify=True)
/// >>> low, high = run.enclosure.zeno
/// >>> low < run.elapsed < high, high - low < 1e-15 * run.elapsed, run.enclosure.contacts
/// (True, True, (1, 2))
#[pyclass(frozen, eq, name = "Enclosure", module = "standfast.results")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyEnclosure(Fields);

/// The pickled form, as a dictionary.
#[derive(Clone, PartialEq, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
struct Fields {
    /// Contact number, from 1, and bounds.
    impacts: Vec<(usize, f64, f64)>,
    zeno: Option<(f64, f64)>,
    contacts: Vec<usize>,
    reason: Option<String>,
}

impl From<&Enclosure> for PyEnclosure {
    fn from(enclosure: &Enclosure) -> Self {
        let impacts = enclosure.impacts.iter();
        let zeno = enclosure.zeno.as_ref();
        Self(Fields {
            impacts: impacts.map(|i| (i.contact.number(), i.elapsed.low, i.elapsed.high)).collect(),
            zeno: zeno.map(|zeno| (zeno.elapsed.low, zeno.elapsed.high)),
            contacts: zeno.iter().flat_map(|z| &z.contacts).map(|i| i.number()).collect(),
            reason: enclosure.reason.map(Uncertain::as_str).map(str::to_owned),
        })
    }
}

#[pymethods]
impl PyEnclosure {
    /// The collisions and the bounds of their times.
    #[getter]
    fn impacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let impacts = &self.0.impacts;
        let dtype = vec![("contact", "i8"), ("index", "i8"), ("low", "f8"), ("high", "f8")];
        let table = py.import("numpy")?.call_method1("empty", (impacts.len(), dtype))?;
        let contacts: Vec<i64> = impacts.iter().map(|i| i.0 as i64).collect();
        let indices: Vec<i64> = contacts.iter().map(|number| number - 1).collect();
        table.set_item("contact", contacts.into_pyarray(py))?;
        table.set_item("index", indices.into_pyarray(py))?;
        let times = |of: fn(&(usize, f64, f64)) -> f64| impacts.iter().map(of).collect::<Vec<_>>();
        table.set_item("low", times(|i| i.1).into_pyarray(py))?;
        table.set_item("high", times(|i| i.2).into_pyarray(py))?;
        Ok(table)
    }

    /// Bounds of the time of the first Zeno point, s after the start, or None.
    #[getter]
    fn zeno(&self) -> Option<(f64, f64)> {
        self.0.zeno
    }

    /// The contacts that come to rest at the Zeno point.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.0.contacts)
    }

    /// Why nothing is proved after the last of the impacts; None if there is a Zeno point.
    #[getter]
    fn reason(&self) -> Option<&str> {
        self.0.reason.as_deref()
    }

    #[staticmethod]
    fn _of(fields: Fields) -> Self {
        Self(fields)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Fields,))> {
        Ok((py.get_type::<Self>().getattr("_of")?, (self.0.clone(),)))
    }

    fn __repr__(&self) -> String {
        let Fields { impacts, zeno, reason, .. } = &self.0;
        let end = match (zeno, reason) {
            (Some((low, high)), _) => format!("Zeno point within [{low:?}, {high:?}] s"),
            (None, reason) => format!("then {}", reason.as_deref().unwrap_or("nothing")),
        };
        format!("<Enclosure: {}, {end}>", crate::convert::counted(impacts.len(), "impact"))
    }
}
