//! Kick, Force and GroundMotion.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use standfast::Error;
use standfast::assembly::{System, SystemExcitation, body_called};
use standfast::excitation::{
    Excitation, Force, GroundMotion, Interpolation, Kick, MechanismExcitation,
};

use crate::convert::{call, float, pair_text, word};
use crate::error::to_py;
use crate::input;

/// Reads the kicks of a run.
pub(crate) fn kicks(value: &Bound<'_, PyAny>) -> PyResult<Vec<Kick>> {
    input::sequence("kicks", value, |field, item| {
        let kick = item.cast::<PyKick>();
        Ok(kick.map_err(|_| input::wrong_type(field, item, "a Kick is needed"))?.get().0)
    })
}

/// Reads kicks or forces: a list; of a System a dict of lists, or of single ones, by the names of its bodies.
fn by_body<T>(
    field: &str,
    value: &Bound<'_, PyAny>,
    system: &System,
    read: impl Fn(&Bound<'_, PyAny>) -> PyResult<Vec<T>>,
    is_one: impl Fn(&Bound<'_, PyAny>) -> bool,
) -> PyResult<Vec<(usize, T)>> {
    let Ok(all) = value.cast::<PyDict>() else {
        if value.is_none() || value.len().is_ok_and(|length| length == 0) {
            return Ok(Vec::new());
        }
        let allowed = "with a System a dict {name of a body: one or a list of them} is needed";
        return Err(input::wrong_type(field, value, allowed));
    };
    let mut found = Vec::new();
    for (key, item) in all.iter() {
        let name = crate::assembly::name(field, &key)?;
        let body = body_called(&system.fields().bodies, field, &name).map_err(|e| to_py(&e))?;
        let list = if is_one(&item) { PyList::new(value.py(), [item])?.into_any() } else { item };
        found.extend(read(&list)?.into_iter().map(|one| (body, one)));
    }
    Ok(found)
}

/// Reads what acts on a body.
pub(crate) fn of_body(given: &[Option<Bound<'_, PyAny>>; 3]) -> PyResult<Excitation> {
    let [first, second, motion] = given;
    Ok(Excitation {
        kicks: first.as_ref().map_or(Ok(Vec::new()), kicks)?,
        forces: second.as_ref().map_or(Ok(Vec::new()), forces)?,
        ground_motion: motion.as_ref().map_or(Ok(None), ground_motion)?,
    })
}

/// Reads what acts on the bodies of a System.
pub(crate) fn of_system(
    system: &System,
    given: &[Option<Bound<'_, PyAny>>; 3],
) -> PyResult<SystemExcitation> {
    let [first, second, motion] = given;
    let kick = |one: &Bound<'_, PyAny>| one.cast::<PyKick>().is_ok();
    let force = |one: &Bound<'_, PyAny>| one.cast::<PyForce>().is_ok();
    let (first, second) = (first.as_ref(), second.as_ref());
    let of_kicks = first.map(|value| by_body("kicks", value, system, kicks, kick));
    let of_forces = second.map(|value| by_body("forces", value, system, forces, force));
    Ok(SystemExcitation {
        kicks: of_kicks.transpose()?.unwrap_or_default(),
        forces: of_forces.transpose()?.unwrap_or_default(),
        ground_motion: motion.as_ref().map_or(Ok(None), ground_motion)?,
    })
}

/// Reads what acts on a Mechanism: kicks (time, impulse) and forces (time, load), in all its coordinates.
pub(crate) fn of_mechanism(given: &[Option<Bound<'_, PyAny>>; 3]) -> PyResult<MechanismExcitation> {
    let [first, second, motion] = given;
    if let Some(motion) = motion.as_ref().filter(|motion| !motion.is_none()) {
        let allowed = "with a Mechanism none: its forces (time, -M a) do the same, with the acceleration a of its coordinates by the ground";
        return Err(input::wrong_type("ground_motion", motion, allowed));
    }
    let pairs = |field: &'static str, value: &Option<Bound<'_, PyAny>>| {
        let Some(value) = value else { return Ok(Vec::new()) };
        input::sequence(field, value, |at, item| {
            let needed = "with a Mechanism a pair (time, values of all its coordinates) is needed";
            let pair = item.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>();
            let (time, values) = pair.map_err(|_| input::wrong_type(at, item, needed))?;
            Ok((input::parameter(&format!("{at}.time"), &time)?, input::series(at, &values)?))
        })
    };
    Ok(MechanismExcitation { kicks: pairs("kicks", first)?, loads: pairs("forces", second)? })
}

/// Reads the forces of a run.
pub(crate) fn forces(value: &Bound<'_, PyAny>) -> PyResult<Vec<Force>> {
    input::sequence("forces", value, |field, item| {
        let force = item.cast::<PyForce>();
        Ok(force.map_err(|_| input::wrong_type(field, item, "a Force is needed"))?.get().0)
    })
}

/// Reads the motion of the ground of a run, or None.
pub(crate) fn ground_motion(value: &Bound<'_, PyAny>) -> PyResult<Option<GroundMotion>> {
    if value.is_none() {
        return Ok(None);
    }
    let motion = value.cast::<PyGroundMotion>();
    let allowed = "None or a GroundMotion is needed";
    let motion = motion.map_err(|_| input::wrong_type("ground_motion", value, allowed))?;
    Ok(Some(motion.get().0.clone()))
}

/// Reads the motions of the ground of many runs: one for all of them, or one for each.
pub(crate) fn ground_motions(value: &Bound<'_, PyAny>) -> PyResult<Vec<Option<GroundMotion>>> {
    if value.is_none() || value.cast::<PyGroundMotion>().is_ok() {
        return Ok(vec![ground_motion(value)?]);
    }
    input::sequence("ground_motion", value, |field, item| {
        ground_motion(item)
            .map_err(|_| input::wrong_type(field, item, "None or a GroundMotion is needed"))
    })
}

/// An impulse on the body at an instant of a run. A contact that it drives into the ground is hit at
/// the same instant, and rebounds with its restitution: a foot that should stay on the ground while the
/// body is pushed needs restitution 0.
///
/// Parameters
/// ----------
/// time : float, s
///     On the clock of the run.
/// impulse : (2,) array_like, N s
/// point : (2,) array_like or None, m, default None
///     The point that the impulse acts on, fixed to the body, at its place in the nominal posture (outside
///     of the body: as by a lever); None: the centre of mass.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.25, restitution=0.5)
/// >>> lift = sf.Kick(time=1.0, impulse=(0.0, 1.0))
/// >>> run = sf.simulate(rod, q=(0, 0, 0), qdot=(0, 0, 0), kicks=[lift])
/// >>> round(run.time - 1.0, 9)                         # 2v/(g(1 − e)) after the kick
/// 0.407747197
#[pyclass(frozen, eq, name = "Kick", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyKick(pub(crate) Kick);

#[pymethods]
impl PyKick {
    #[new]
    #[pyo3(signature = (time, impulse, point=None))]
    fn new(
        #[pyo3(from_py_with = input::time)] time: f64,
        #[pyo3(from_py_with = input::impulse)] impulse: [f64; 2],
        #[pyo3(from_py_with = input::some_point)] point: Option<[f64; 2]>,
    ) -> Self {
        Self(Kick { time, impulse, point })
    }

    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    #[getter]
    fn impulse(&self) -> (f64, f64) {
        self.0.impulse.into()
    }

    #[getter]
    fn point(&self) -> Option<(f64, f64)> {
        self.0.point.map(Into::into)
    }

    fn __repr__(&self) -> String {
        let Kick { time, impulse, point } = self.0;
        let at = point.map_or(String::new(), |point| format!(", point={}", pair_text(point)));
        format!("Kick(time={}, impulse={}{at})", float(time), pair_text(impulse))
    }

    #[allow(clippy::type_complexity, reason = "the arguments of the constructor")]
    fn __reduce__(&self, py: Python<'_>) -> (Py<PyAny>, (f64, [f64; 2], Option<[f64; 2]>)) {
        let Kick { time, impulse, point } = self.0;
        (py.get_type::<Self>().into_any().unbind(), (time, impulse, point))
    }
}

/// A constant force through the centre of mass of the body, for a time. Several at one time add up.
///
/// A force at another point, or a torque, is no acceleration of free fall: ValueError says what to do
/// instead.
///
/// Parameters
/// ----------
/// start, end : float, s
///     On the clock of the run; end after start.
/// force : (2,) array_like, N
///     (x, y), in the frame of the ground.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> feet = [sf.Contact(point=(x, 0), friction=.5) for x in (-1, 1)]
/// >>> box = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, .5), contacts=feet, restitution=0, gravity=10)
/// >>> push = sf.Force(start=0, end=1, force=(6, 0))    # 1 N above the friction: it slides .5 m, and stops in .2 s
/// >>> run = sf.simulate(box, (0, 0, 0), (0, 0, 0), forces=[push])
/// >>> round(run.time, 9), round(float(run.q[0]), 9)
/// (1.2, 0.6)
#[pyclass(frozen, eq, name = "Force", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyForce(pub(crate) Force);

#[pymethods]
impl PyForce {
    #[new]
    #[pyo3(signature = (start, end, force, *, point=None, torque=None), text_signature = "(start, end, force)")]
    fn new(
        #[pyo3(from_py_with = input::start)] start: f64,
        #[pyo3(from_py_with = input::end)] end: f64,
        #[pyo3(from_py_with = input::force)] force: [f64; 2],
        point: Option<&Bound<'_, PyAny>>,
        torque: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        for (field, value) in [("point", point), ("torque", torque)] {
            if let Some(value) = value {
                return Err(to_py(&Error::Unusable {
                    field: field.into(),
                    value: value.repr()?.to_string(),
                    allowed: "not given: a force acts through the centre of mass, where it is an acceleration of free fall; for a push at another \
                              point take kicks=[sf.Kick(time, impulse, point)], one or several after each other".into(),
                }));
            }
        }
        let force = Force { start, end, force };
        force.validate().map_err(|e| to_py(&e))?;
        Ok(Self(force))
    }

    #[getter]
    fn start(&self) -> f64 {
        self.0.start
    }

    #[getter]
    fn end(&self) -> f64 {
        self.0.end
    }

    #[getter]
    fn force(&self) -> (f64, f64) {
        self.0.force.into()
    }

    fn __repr__(&self) -> String {
        let Force { start, end, force } = self.0;
        format!("Force(start={}, end={}, force={})", float(start), float(end), pair_text(force))
    }

    fn __reduce__(&self, py: Python<'_>) -> (Py<PyAny>, (f64, f64, [f64; 2])) {
        let Force { start, end, force } = self.0;
        (py.get_type::<Self>().into_any().unbind(), (start, end, force))
    }
}

/// A motion of the ground. An entry of `acceleration` or `tilt` holds from its time to the next one;
/// before the first time the ground is at rest and level, and the last entry holds for ever. All
/// positions and velocities of the run are relative to the ground.
///
/// Parameters
/// ----------
/// times : (k,) array_like, s
///     Increasing.
/// acceleration : (k, 2) or (k,) array_like or None, m/s², default None
///     (x, y), or horizontal.
/// tilt : (k,) array_like or None, rad, default None
///     Counterclockwise, instead of acceleration; the steps of the angle are so slow that only the
///     direction of gravity changes.
/// interpolation : {"steps", "linear"}
///     Of the acceleration between the times: in steps, or "linear": at a constant rate from each
///     entry to the next, as a record of an earthquake is usually read. Both are exact.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> feet = [sf.Contact(point=(x, 0), friction=1) for x in (-1, 1)]
/// >>> block = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, 2), contacts=feet, restitution=0, gravity=10)
/// >>> shake = sf.GroundMotion(times=[0, 1], acceleration=[(4, 0), (0, 0)])     # less than g b/h = 5: it does not rock
/// >>> [phase.mode for phase in sf.simulate(block, (0, 0, 0), (0, 0, 0), ground_motion=shake).phases]
/// ['FF', 'FF']
#[pyclass(frozen, eq, name = "GroundMotion", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyGroundMotion(pub(crate) GroundMotion);

#[pymethods]
impl PyGroundMotion {
    #[new]
    #[pyo3(signature = (times, acceleration=None, tilt=None, interpolation="steps"))]
    fn new(
        #[pyo3(from_py_with = input::times)] times: Vec<f64>,
        #[pyo3(from_py_with = input::accelerations)] acceleration: Option<Vec<[f64; 2]>>,
        #[pyo3(from_py_with = input::tilt)] tilt: Option<Vec<f64>>,
        #[pyo3(from_py_with = input::interpolation)] interpolation: &str,
    ) -> PyResult<Self> {
        let both_or_none = acceleration.is_some() == tilt.is_some();
        if both_or_none {
            return Err(to_py(&Error::Unusable {
                field: "acceleration, tilt".into(),
                value: if tilt.is_some() { "both" } else { "none" }.into(),
                allowed: "exactly one of them is needed".into(),
            }));
        }
        let (acceleration, tilt) = (acceleration.unwrap_or_default(), tilt.unwrap_or_default());
        let interpolation = call("interpolation", interpolation)?;
        let motion = GroundMotion { times, acceleration, interpolation, tilt };
        motion.validate(0.0).map_err(|e| to_py(&e))?;
        Ok(Self(motion))
    }

    /// The motion of a record: linear between its samples, and at rest before the first one. If the last
    /// acceleration is not zero, it becomes zero within one more interval.
    ///
    /// Parameters
    /// ----------
    /// record : path_like or (array_like, array_like)
    ///     Path of a file that `read_record` reads, or (times, acceleration) in s and m/s².
    /// scale : float, default 1.0
    ///     Factor on the acceleration.
    ///
    /// Raises
    /// ------
    /// OSError, ValueError
    ///     As `read_record`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> sf.GroundMotion.from_record(([0, 0.1, 0.2], [0, 2, 0]), scale=0.5).acceleration
    /// [(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)]
    #[staticmethod]
    #[pyo3(signature = (record, scale=1.0))]
    fn from_record(
        record: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = input::scale)] scale: f64,
    ) -> PyResult<Self> {
        let pair = record.cast::<PyTuple>().cloned().or_else(|_| {
            let read =
                record.py().import("standfast.records")?.call_method1("read_record", (record,))?;
            Ok::<_, PyErr>(read.cast_into::<PyTuple>()?)
        })?;
        let allowed = "a path, or a pair (times, acceleration)";
        if pair.len() != 2 {
            return Err(input::wrong_type("record", record, allowed));
        }
        let mut times = input::times(&pair.get_item(0)?)?;
        let acceleration = input::accelerations(&pair.get_item(1)?)?.unwrap_or_default();
        let mut acceleration: Vec<[f64; 2]> =
            acceleration.into_iter().map(|pair| pair.map(|a| scale * a)).collect();
        // The ground comes to rest where the record ends.
        if let (&[.., before, last], Some(end)) = (&times[..], acceleration.last())
            && *end != [0.0; 2]
        {
            times.push(last + (last - before));
            acceleration.push([0.0; 2]);
        }
        let interpolation = Interpolation::Linear;
        let motion = GroundMotion { times, acceleration, interpolation, tilt: Vec::new() };
        motion.validate(0.0).map_err(|e| to_py(&e))?;
        Ok(Self(motion))
    }

    #[getter]
    fn interpolation(&self) -> String {
        word(&self.0.interpolation)
    }

    #[getter]
    fn times(&self) -> Vec<f64> {
        self.0.times.clone()
    }

    #[getter]
    fn acceleration(&self) -> Option<Vec<(f64, f64)>> {
        let entries = &self.0.acceleration;
        (!entries.is_empty()).then(|| entries.iter().map(|&pair| pair.into()).collect())
    }

    #[getter]
    fn tilt(&self) -> Option<Vec<f64>> {
        (!self.0.tilt.is_empty()).then(|| self.0.tilt.clone())
    }

    fn __repr__(&self) -> String {
        let what = if self.0.tilt.is_empty() { "acceleration" } else { "tilt" };
        let count = self.0.times.len();
        match self.0.interpolation {
            Interpolation::Steps => format!("<GroundMotion: {what} in {count} steps>"),
            Interpolation::Linear => format!("<GroundMotion: {what} linear between {count} times>"),
        }
    }

    #[allow(clippy::type_complexity, reason = "the arguments of the constructor")]
    fn __reduce__(
        &self,
        py: Python<'_>,
    ) -> (Py<PyAny>, (Vec<f64>, Option<Vec<(f64, f64)>>, Option<Vec<f64>>, String)) {
        (
            py.get_type::<Self>().into_any().unbind(),
            (self.times(), self.acceleration(), self.tilt(), self.interpolation()),
        )
    }
}
