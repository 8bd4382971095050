//! Runs: the trajectory and its events as numpy arrays.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use standfast::body::Mechanism;
use standfast::outcome::{ContactNumber, Phase, RunContact, ZenoMethod, ZenoPoint};
use standfast::simulate::{FilmClock, Reader};
use standfast::{Error, State, Trajectory};

use crate::convert::{array, call, counted, first_words, local_model, question, word};
use crate::enclosure::PyEnclosure;
use crate::error::to_py;
use crate::excitation::{PyForce, PyGroundMotion, PyKick};
use crate::files::write_whole;
use crate::input::{self, MOST_SAMPLES, doubles, whole};
use crate::interrupt::interruptible;
use crate::mechanism::PyMechanism;
use crate::modes::PyProblem;
use crate::options;
use crate::posture::PyPosture;

/// An interval of time with one contact mode. An impact does not end the phase if the mode is the same
/// after it: a body that bounces is in one phase S.
///
/// Attributes
/// ----------
/// mode : str
///     One letter for each contact: S separate, F fixed, R or L sliding right or left at the start
///     of the phase. A LocalModel has no tangential motion and always has F.
/// start, end : float, s
/// cause : {"start", "impact", "zeno", "lift-off", "stop", "slip", "left-segment", "kick", "ground-motion"}
///     The event at its start: "start", "impact", "zeno", "lift-off" (a normal force became zero),
///     "stop" (a sliding speed became zero), "slip" (a force reached the edge of its cone) or
///     "left-segment" (a contact reached the end of a piece of its terrain), "kick" or
///     "ground-motion" (the motion of the ground changed).
/// contact : int or None
///     The number of the contact of this event.
/// impacts : int
///     The number of `run.impacts` strictly between start and end; impacts that are summed in a
///     Zeno point are not counted.
#[pyclass(frozen, eq, name = "Phase", module = "standfast.results")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyPhase(PhaseFields);

/// The pickled form, as a dictionary.
#[derive(Clone, PartialEq, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
struct PhaseFields {
    mode: String,
    start: f64,
    end: f64,
    cause: String,
    contact: Option<usize>,
    impacts: usize,
}

impl From<Phase> for PyPhase {
    fn from(phase: Phase) -> Self {
        let Phase { mode, start, end, cause, impacts } = phase;
        let contact = cause.contact().map(ContactNumber::number);
        Self(PhaseFields { mode, start, end, cause: cause.as_str().into(), contact, impacts })
    }
}

#[pymethods]
impl PyPhase {
    #[getter]
    fn mode(&self) -> &str {
        &self.0.mode
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
    fn cause(&self) -> &str {
        &self.0.cause
    }

    #[getter]
    fn contact(&self) -> Option<usize> {
        self.0.contact
    }

    #[getter]
    fn impacts(&self) -> usize {
        self.0.impacts
    }

    #[staticmethod]
    fn _of(fields: PhaseFields) -> Self {
        Self(fields)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PhaseFields,))> {
        Ok((py.get_type::<Self>().getattr("_of")?, (self.0.clone(),)))
    }

    fn __repr__(&self) -> String {
        let PhaseFields { mode, start, end, cause, contact, impacts } = &self.0;
        let contact = contact.map_or(String::new(), |i| format!(", contact={i}"));
        format!(
            "Phase(mode='{mode}', start={start:?}, end={end:?}, cause='{cause}'{contact}, impacts={impacts})"
        )
    }
}

/// An instant at which contacts come to rest. Infinitely many impacts accumulate there; or the contacts
/// land without rebound (plastic); or they rest from the start (method "rest").
///
/// Attributes
/// ----------
/// kind : str
///     "1-zeno", "2-zeno", … (the number of contacts that come to rest).
/// contacts : tuple of int
///     Their numbers.
/// contact : int or None
///     The number, if there is only one.
/// time, elapsed : float, s
///     On the clock, and since the start.
/// time_error : float, s
///     Estimated error of the sum, of the clock, and, if the run is recorded, of what rounding
///     errors have grown to until then, as of `run.time_error`. It does not include the error of
///     the local model.
/// q, qdot : (3,) ndarray or None
///     Configuration and velocity; of a mechanism (dof,), None without a body.
/// gaps, gap_rates : (n,) ndarray, m and m/s
/// theta, omega : float, rad and rad/s
///     Rotation and angular velocity.
/// method : {"bounce", "clatter", "chatter", "rest", "self-similar", "mixed", "nested"}
///     How the impacts were summed.
/// certified : bool
///     Whether the sum is proved.
/// plastic : bool
///     Whether these contacts, all of restitution 0, come to rest in one impact without rebound, so
///     that no impacts accumulate.
/// first_summed : int
///     Index of the first collision that was summed and not simulated.
#[pyclass(frozen, eq, name = "ZenoPoint", module = "standfast.results")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyZenoPoint(ZenoFields);

/// The pickled form, as a dictionary.
#[derive(Clone, PartialEq, IntoPyObject, FromPyObject)]
#[pyo3(from_item_all)]
struct ZenoFields {
    kind: String,
    contacts: Vec<usize>,
    time: f64,
    elapsed: f64,
    time_error: f64,
    q: Option<Vec<f64>>,
    qdot: Option<Vec<f64>>,
    rotation: [f64; 2],
    gaps: Vec<f64>,
    gap_rates: Vec<f64>,
    certified: bool,
    method: String,
    plastic: bool,
    first_summed: usize,
}

impl From<ZenoPoint> for PyZenoPoint {
    fn from(z: ZenoPoint) -> Self {
        Self(ZenoFields {
            kind: z.kind.to_string(),
            contacts: z.contacts.iter().map(|contact| contact.number()).collect(),
            time: z.time,
            elapsed: z.elapsed,
            time_error: z.time_error,
            q: z.q,
            qdot: z.qdot,
            rotation: z.rotation,
            gaps: z.gaps,
            gap_rates: z.gap_rates,
            certified: z.certified,
            method: z.method.as_str().into(),
            plastic: z.plastic,
            first_summed: z.first_summed,
        })
    }
}

#[pymethods]
impl PyZenoPoint {
    #[getter]
    fn kind(&self) -> &str {
        &self.0.kind
    }

    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.0.contacts)
    }

    #[getter]
    fn contact(&self) -> Option<usize> {
        match self.0.contacts.as_slice() {
            [only] => Some(*only),
            _ => None,
        }
    }

    #[getter]
    fn time(&self) -> f64 {
        self.0.time
    }

    #[getter]
    fn elapsed(&self) -> f64 {
        self.0.elapsed
    }

    #[getter]
    fn time_error(&self) -> f64 {
        self.0.time_error
    }

    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.q.clone().map(|q| q.into_pyarray(py))
    }

    #[getter]
    fn qdot<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.qdot.clone().map(|qdot| qdot.into_pyarray(py))
    }

    #[getter]
    fn theta(&self) -> f64 {
        self.0.rotation[0]
    }

    #[getter]
    fn omega(&self) -> f64 {
        self.0.rotation[1]
    }

    #[getter]
    fn gaps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.gaps.clone().into_pyarray(py)
    }

    #[getter]
    fn gap_rates<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.gap_rates.clone().into_pyarray(py)
    }

    #[getter]
    fn certified(&self) -> bool {
        self.0.certified
    }

    #[getter]
    fn method(&self) -> &str {
        &self.0.method
    }

    #[getter]
    fn plastic(&self) -> bool {
        self.0.plastic
    }

    #[getter]
    fn first_summed(&self) -> usize {
        self.0.first_summed
    }

    #[staticmethod]
    fn _of(fields: ZenoFields) -> Self {
        Self(fields)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (ZenoFields,))> {
        Ok((py.get_type::<Self>().getattr("_of")?, (self.0.clone(),)))
    }

    fn __repr__(&self) -> String {
        let z = &self.0;
        format!(
            "<{} of {} at {} s ± {:.1e} s, {}{}{}>",
            z.kind,
            contacts(&z.contacts),
            z.time,
            z.time_error,
            z.method,
            if z.plastic { " without rebound" } else { "" },
            if z.certified { ", certified" } else { "" }
        )
    }
}

/// A contact of a run, see `Run.contacts`.
#[pyclass(frozen, eq, name = "RunContact", module = "standfast.results")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyRunContact(RunContact);

#[pymethods]
impl PyRunContact {
    /// Its number, from 1: that of `run.impacts`, `run.phases` and `run.zeno_points`.
    #[getter]
    fn number(&self) -> usize {
        self.0.number.number()
    }

    /// What touches the ground: "corner" or "round" (a point of the body or a disc about it, one of the contacts of its posture), or "side" (a
    /// side of its outline).
    #[getter]
    fn kind(&self) -> String {
        word(&self.0.kind)
    }

    /// Index, from 0, of the contact in posture.contacts, or of the side: side k goes from corner k of posture.outline to the next one.
    #[getter]
    fn index(&self) -> usize {
        self.0.index
    }

    /// The corner of the ground (x, y) on the side, m; None for a corner of the body.
    #[getter]
    fn corner(&self) -> Option<(f64, f64)> {
        self.0.corner.map(Into::into)
    }

    /// Unit vector (x, y) along the side in the nominal posture, with the body on its left; None for a corner of the body.
    #[getter]
    fn along(&self) -> Option<(f64, f64)> {
        self.0.along.map(Into::into)
    }

    /// Coefficient of friction; of a side, the smallest one of the contacts at its ends, or of all contacts if none is there.
    #[getter]
    fn friction(&self) -> f64 {
        self.0.friction
    }

    fn __repr__(&self) -> String {
        let RunContact { number, index, corner, .. } = &self.0;
        let corner = corner.map(|[x, y]| format!(", corner=({x:?}, {y:?})")).unwrap_or_default();
        format!("<RunContact {number}: {} {index}{corner}>", self.kind())
    }
}

/// A run: its outcome, its events, and the motion at any time.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
/// >>> run = sf.simulate(rod, q=(0, 0.011, 0.002), qdot=(0, 0, 0))
/// >>> run.outcome, run.zeno_points[0].kind, [phase.mode for phase in run.phases]
/// ('rest', '2-zeno', ['SS', 'FF'])
/// >>> q, qdot = run.at(0.01)          # still falling: ṙ_y = −g t
/// >>> float(qdot[1])
/// -0.0981
#[pyclass(frozen, name = "Run", module = "standfast")]
pub(crate) struct PyRun(pub(crate) Trajectory);

#[pymethods]
impl PyRun {
    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (run, keywords) = (&self.0, options::get(py, self.0.options())?);
        if let Some((model, start)) = run.local_start() {
            for name in ["model", "impact", "neighbourhood", "edges", "jams"] {
                keywords.del_item(name)?;
            }
            let model = local_model(py, model)?;
            let arguments =
                (start.gaps, start.rates, start.theta, start.omega).into_pyobject(py)?;
            return Ok((question(model.getattr("simulate")?, &keywords)?, arguments));
        }
        if let (Some(mechanism), Some([q, qdot])) = (self.mechanism(), run.mechanism_start()) {
            let simulate = py.import("standfast")?.getattr("simulate")?;
            if let Some(excitation) = run.mechanism_excitation() {
                keywords.set_item("kicks", &excitation.kicks)?;
                keywords.set_item("forces", &excitation.loads)?;
            }
            let arguments = (mechanism, q.to_vec(), qdot.to_vec()).into_pyobject(py)?;
            return Ok((question(simulate, &keywords)?, arguments));
        }
        let posture = run.posture().cloned().map(PyPosture);
        let start = run.start();
        let (q, qdot): ([f64; 3], [f64; 3]) = (start.q.into(), start.qdot.into());
        let simulate = py.import("standfast")?.getattr("simulate")?;
        if !run.excitation().is_none() {
            keywords.set_item("kicks", self.kicks())?;
            keywords.set_item("forces", self.forces())?;
            keywords.set_item("ground_motion", self.ground_motion())?;
        }
        Ok((question(simulate, &keywords)?, (posture, q, qdot).into_pyobject(py)?))
    }

    /// How the run ended: "rest"; "sliding" (the last motion never ends: a slide, a swing, joints that the contacts do not feel); "escape" (the body flies or slides away for ever,
    /// or beyond the end of its terrain); "inconsistent" (no contact mode is consistent); "ambiguous" (several are); "zeno" (`stop="zeno"`);
    /// "time-limit"; "event-limit"; "sensitivity-limit". `run.warnings` may say more.
    #[getter]
    fn outcome(&self) -> &str {
        self.0.outcome().as_str()
    }

    /// The model that was solved, "local" or "full".
    #[getter]
    fn model(&self) -> String {
        word(&self.0.model())
    }

    /// The law of impact: with impact="auto" the one that acted, "newton" or "moreau".
    #[getter]
    fn impact(&self) -> String {
        word(&self.0.options().impact)
    }

    /// The reason for this model.
    #[getter]
    fn model_reason(&self) -> &str {
        self.0.model_reason().as_str()
    }

    /// Time on the clock when the outcome was reached, s.
    #[getter]
    fn time(&self) -> f64 {
        self.0.time()
    }

    /// Time from the start to the outcome, s, not rounded to the clock.
    #[getter]
    fn elapsed(&self) -> f64 {
        self.0.elapsed()
    }

    /// Final configuration, (3,) m, m, rad; of a mechanism (dof,) m or rad; None without a body.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.coordinates().map(|[q, _]| q.into_pyarray(py))
    }

    /// Final velocity, (3,) m/s, m/s, rad/s; of a mechanism (dof,); None without a body.
    #[getter]
    fn qdot<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.coordinates().map(|[_, qdot]| qdot.into_pyarray(py))
    }

    /// Final gaps, (n,) m.
    #[getter]
    fn gaps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.gaps().into_pyarray(py)
    }

    /// Final gap rates, (n,) m/s.
    #[getter]
    fn rates<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.rates().into_pyarray(py)
    }

    /// Final rotation, rad; 0 for a mechanism, which has no single rotation.
    #[getter]
    fn theta(&self) -> f64 {
        self.0.state().q.z
    }

    /// Final angular velocity, rad/s.
    #[getter]
    fn omega(&self) -> f64 {
        self.0.state().qdot.z
    }

    /// Acceleration at the start of an endless slide, (3,) m/s², m/s², rad/s², of a mechanism (dof,); None otherwise.
    #[getter]
    fn acceleration<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.0.acceleration().map(|a| a.into_pyarray(py))
    }

    /// The contacts at the end of an inconsistent or ambiguous run, for `contact_modes`; None otherwise.
    #[getter]
    fn undecided(&self) -> Option<PyProblem> {
        let of_mechanism = || self.0.undecided_mechanism().cloned().map(PyProblem::of_mechanism);
        self.0.undecided().cloned().map(PyProblem::of_body).or_else(of_mechanism)
    }

    /// Number of collisions simulated one by one, recorded or not.
    #[getter]
    fn collisions(&self) -> usize {
        self.0.collisions()
    }

    /// The kicks of the run of a body. Those of a mechanism are in `to_dict()`.
    #[getter]
    fn kicks(&self) -> Vec<PyKick> {
        self.0.excitation().kicks.iter().map(|kick| PyKick(*kick)).collect()
    }

    /// The forces for a time of the run of a body. Those of a mechanism are in `to_dict()`.
    #[getter]
    fn forces(&self) -> Vec<PyForce> {
        self.0.excitation().forces.iter().copied().map(PyForce).collect()
    }

    /// The motion of the ground of the run of a body, or None.
    #[getter]
    fn ground_motion(&self) -> Option<PyGroundMotion> {
        self.0.excitation().ground_motion.clone().map(PyGroundMotion)
    }

    /// The contacts of the run, list of RunContact: those of the posture, then the sides of the body that corners of the ground have touched,
    /// in the order of their first touches, with the sides beside them at concave corners of the body. The letters of a contact mode, and the arrays of `forces_at` and `points_at`, are in this order.
    #[getter]
    fn contacts(&self) -> Vec<PyRunContact> {
        self.0.contacts().into_iter().map(PyRunContact).collect()
    }

    /// The mechanism; None for a run of a posture or of a LocalModel.
    #[getter]
    fn mechanism(&self) -> Option<PyMechanism> {
        self.0.mechanism().cloned().map(PyMechanism)
    }

    /// The posture; None for a run of a mechanism or of a LocalModel given by parameters.
    #[getter]
    fn posture(&self) -> Option<PyPosture> {
        self.0.posture().cloned().map(PyPosture)
    }

    /// The collisions simulated one by one: structured array with the fields time, elapsed (s), contact
    /// (from 1), index (from 0), rates_before, rates_after ((n,) m/s, of the contacts of the posture), impulse ((2,) N s, tangential and
    /// normal; NaN without a mass). The contact is one of `run.contacts`. Empty unless recorded.
    #[getter]
    fn impacts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let impacts = self.0.impacts();
        let n = self.0.gaps().len();
        let numpy = py.import("numpy")?;
        let dtype = PyList::empty(py);
        for name in ["time", "elapsed"] {
            dtype.append((name, "f8"))?;
        }
        for name in ["contact", "index"] {
            dtype.append((name, "i8"))?;
        }
        for (name, width) in [("rates_before", n), ("rates_after", n), ("impulse", 2)] {
            dtype.append((name, "f8", (width,)))?;
        }
        let table = numpy.call_method1("empty", (impacts.len(), dtype))?;
        let column = |name: &str, values: Vec<f64>, width: usize| -> PyResult<()> {
            let shape = if width == 0 { vec![impacts.len()] } else { vec![impacts.len(), width] };
            table.set_item(name, array(py, values, &shape)?)
        };
        column("time", impacts.iter().map(|i| i.time).collect(), 0)?;
        column("elapsed", impacts.iter().map(|i| i.elapsed).collect(), 0)?;
        let numbers: Vec<i64> = impacts.iter().map(|i| i.contact.number() as i64).collect();
        let indices: Vec<i64> = impacts.iter().map(|i| i.contact.index() as i64).collect();
        table.set_item("contact", numbers.into_pyarray(py))?;
        table.set_item("index", indices.into_pyarray(py))?;
        column("rates_before", impacts.iter().flat_map(|i| i.rates_before.clone()).collect(), n)?;
        column("rates_after", impacts.iter().flat_map(|i| i.rates_after.clone()).collect(), n)?;
        column("impulse", impacts.iter().flat_map(|i| i.impulse).collect(), 2)?;
        Ok(table)
    }

    /// The Zeno points in order.
    #[getter]
    fn zeno_points(&self) -> Vec<PyZenoPoint> {
        self.0.zeno_points().iter().cloned().map(Into::into).collect()
    }

    /// Intervals that are proved to contain the times of the collisions and of the first Zeno point; None without `certify`.
    #[getter]
    fn enclosure(&self) -> Option<PyEnclosure> {
        self.0.enclosure().map(PyEnclosure::from)
    }

    /// The contact modes in order; empty unless recorded.
    #[getter]
    fn phases(&self) -> Vec<PyPhase> {
        self.0.phases().iter().cloned().map(Into::into).collect()
    }

    /// Warnings: simultaneous impacts, a start that counts as touching, grounds that contradict each other (see Contact), impacts
    /// with impact="newton" at contacts with friction.
    #[getter]
    pub(crate) fn warnings(&self) -> Vec<String> {
        self.0.warnings().to_vec()
    }

    /// Growth of a small change of the start up to the end of the run, dimensionless: |change at the end| over |change at the start|. Lengths
    /// are over the size of the body, speeds over sqrt(g * size), turns are times the gyration radius; if the run ends at rest, the shift of
    /// the time of rest over sqrt(size / g) is part of the change. The change has equal parts in all coordinates and their speeds, with
    /// the sign of the arm of the first contact along the ground and of the turn; growth turns it into the direction that
    /// grows fastest. inf where it is above 1e100. None unless recorded, or where a state within a sum of impacts cannot be computed.
    ///
    /// It is computed from the record when it is first asked for: the derivative of the motion along the run, with the shift of the time of
    /// each impact (saltation).
    #[getter]
    fn sensitivity(&self) -> Option<f64> {
        self.0.sensitivity()
    }

    /// Time on the clock from which not one digit of the state is determined, because rounding errors have grown to the size of the body, s.
    /// None: there is none, or nothing was recorded.
    #[getter]
    fn determined_until(&self) -> Option<f64> {
        self.0.determined_until()
    }

    /// Estimated error of time, s: that of the sums of impacts and of the clock, and 2.2e-16 times the sum of the growths from each event to
    /// the end, times sqrt(size / g); at most the whole time. Without a record it does not include the growth.
    #[getter]
    fn time_error(&self) -> f64 {
        self.0.time_error()
    }

    /// (q, qdot), each (..., 3), of a mechanism (..., dof), at times t; exact within a phase. At the time of an impact it is the state after the impact; after the outcome "rest", the
    /// state of rest.
    ///
    /// Parameters
    /// ----------
    /// t : (...) array_like, s
    ///     Times of the run.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If t is outside the run, if the run was not recorded, or if t is so close to the end of a
    ///     sum of impacts that more than 100 000 events of the sum (20 million of two contacts in the
    ///     local model) are before t.
    fn at<'py>(&self, py: Python<'py>, t: &Bound<'py, PyAny>) -> PyResult<Pair<'py>> {
        let dof = self.0.mechanism().map_or(3, Mechanism::dof);
        let t = doubles("t", t)?;
        let states = self.at_each(&t, 2 * dof, |run, t| {
            Ok(match run.coordinates(t)? {
                Some(all) => all.concat(),
                // Without a body only the rotation is known.
                None => {
                    let State { q, qdot } = run.state(t)?;
                    [[f64::NAN, f64::NAN, q.z], [f64::NAN, f64::NAN, qdot.z]].concat()
                }
            })
        })?;
        let shape = [t.as_array().shape(), &[dof]].concat();
        let half = |from: usize| {
            let values = states.chunks_exact(2 * dof).flat_map(|state| &state[from..from + dof]);
            array(py, values.copied().collect(), &shape)
        };
        Ok((half(0)?, half(dof)?))
    }

    /// Gaps of the contacts of the posture, (..., n) m, at times t. See `at`.
    ///
    /// Parameters
    /// ----------
    /// t : (...) array_like, s
    ///     Times of the run.
    fn gaps_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.at_times(py, t, &[self.0.gaps().len()], |run, t| Ok(run.at(t)?.gaps))
    }

    /// Gap rates of the contacts of the posture, (..., n) m/s, at times t. See `at`.
    ///
    /// Parameters
    /// ----------
    /// t : (...) array_like, s
    ///     Times of the run.
    fn gap_rates_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.at_times(py, t, &[self.0.gaps().len()], |run, t| Ok(run.at(t)?.rates))
    }

    /// World positions (x, y) of the contact points of `run.contacts`, (..., k, 2) m, at times t.
    /// In the full model x_i + r + (R(θ) − 1) d_i with the arm d_i = x_i − center_of_mass, in
    /// the local model x_i + r + θ (−d_y, d_x); of a side, the corner of the ground. NaN without a body,
    /// and for a mechanism. See `at`.
    ///
    /// Parameters
    /// ----------
    /// t : (...) array_like, s
    ///     Times of the run.
    fn points_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = [self.0.contacts().len(), 2];
        self.at_times(py, t, &shape, |run, t| Ok(run.points(t)?.into_iter().flatten()))
    }

    /// Contact forces of the smooth motion on the contacts of `run.contacts`, (..., k, 2) N, (tangential,
    /// normal), at times t. Each pair is in the axes of the piece of terrain, or of
    /// the side of the body, that touches. The forces satisfy M q̈ = (0, −m g, 0) + Σ_i (T_iᵀ f_t,i + N_iᵀ
    /// f_n,i), with M = diag(m, m, mρ²) and the rows N_i = (n_i, b_i), T_i = (t_i, −c_i), which the local
    /// model takes at q = 0.
    ///
    /// They are zero in flight. Impacts have impulses instead (`run.impacts`). At the time of an impact or
    /// of a change of the contact modes, the forces are those after it. Where this equation allows several
    /// forces, these are the ones with the smallest Σ|f|² in the friction cones. (A real body chooses by
    /// its elasticity.) In a vertex of the terrain a contact touches two pieces: it has the sum of their
    /// forces, in the axes of the first piece. A disc touches them with two points of its rim: the sum has
    /// their force and not their moment, and the equation above does not hold for it.
    ///
    /// NaN without a body, where no force causes the motion (at the singularity of a jam), and at the end
    /// of a run that does not determine what follows: at the Zeno point of stop="zeno", and where it is
    /// inconsistent or ambiguous.
    ///
    /// Parameters
    /// ----------
    /// t : (...) array_like, s
    ///     Times of the run.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `at`.
    ///
    /// Examples
    /// --------
    /// >>> import math
    /// >>> import standfast as sf
    /// >>> block = sf.Posture(mass=2, gyration_radius=1, center_of_mass=(0, 1), gravity=10, restitution=0,
    /// ...                    contacts=[sf.Contact(point=(-1, 0), friction=0.5), sf.Contact(point=(3, 0), friction=0.5)])
    /// >>> run = sf.simulate(block, q=(0, 0, 0), qdot=(0, 0, 0), stop="time", time_limit=1.0)
    /// >>> run.forces_at(0.5)[:, 1]      # lever rule: 3/4 and 1/4 of 20 N
    /// array([15.,  5.])
    fn forces_at<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let shape = [self.0.contacts().len(), 2];
        self.at_times(py, t, &shape, |run, t| Ok(run.forces(t)?.into_iter().flatten()))
    }

    /// The trajectory at n times, 2 ≤ n ≤ 10⁷, denser where there are many events: t (n,), q (n, 3), qdot
    /// (n, 3).
    ///
    /// Parameters
    /// ----------
    /// n : int, from 2 to 10⁷
    ///     Number of times.
    fn sample<'py>(&self, py: Python<'py>, n: &Bound<'py, PyAny>) -> PyResult<Sample<'py>> {
        let n = whole("n", n, 2..=MOST_SAMPLES)?;
        let t = self.0.sample_times(n).map_err(|e| to_py(&e))?.into_pyarray(py);
        let (q, qdot) = self.at(py, t.as_any())?;
        Ok((t, q, qdot))
    }

    /// Energy ½m(|ṙ|² + ρ²θ̇²) + m g r_y, of a mechanism ½ q̇ᵀM q̇ − loadᵀq, J, at times t; NaN without a body.
    ///
    /// Parameters
    /// ----------
    /// t : (...) array_like, s
    ///     Times of the run.
    fn energy<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        self.at_times(py, t, &[], |run, t| Ok([run.energy(t)?]))
    }

    /// Draw the run. Without `ax`: a new figure with at most five panels. If the run has a posture, the
    /// first and largest shows the body on its ground at some instants, to scale, with the times, the path
    /// of the centre of mass and arrows for kicks; of a long journey only the end. Below are, each if there
    /// is something to see, the gaps over time with the impacts that can be told apart, the angle, the
    /// contact forces (see `forces_at`) and the motion of the ground; vertical lines are kicks. If one
    /// accumulation of impacts is the main event, the last panel shows the gaps against the time left until
    /// its end.
    ///
    /// Parameters
    /// ----------
    /// path : path_like or None, default None
    ///     File of the new figure; the suffix determines the format.
    /// ax : matplotlib Axes or None, default None
    ///     Matplotlib axes; for a window use `fig, ax = plt.subplots(); run.plot(ax=ax); plt.show()`.
    ///
    /// Returns
    /// -------
    /// matplotlib Figure or Axes
    ///     The matplotlib.figure.Figure, which a notebook shows once: it is not left open in pyplot, so
    ///     that `plt.show()` does not show it. With `ax`: the gaps over time in these axes, without a
    ///     title; a figure that has no layout of its own gets one in which no label is cut off.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For a run without record (record=False), for a suffix that is no picture format, and for
    ///     both `path` and `ax`.
    /// TypeError
    ///     If `ax` is no axes.
    /// OSError
    ///     If the file cannot be written.
    /// ImportError
    ///     Without matplotlib (extra `plot`).
    #[pyo3(signature = (path=None, *, ax=None))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        path: Option<PathBuf>,
        ax: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.plot")?.call_method1("plot", (slf, path, ax))
    }

    /// Write a film of the run: the body on its ground, to scale, above the gaps over the time of the film,
    /// if any contact opens.
    ///
    /// Letters at the closed contacts are their modes (F fixed, R or L sliding). Arrows in the friction
    /// cones are contact forces: that of the weight is as long as the cone, and that of a force above three
    /// weights is cut off there. A ring is an impact, an orange arrow a kick, and an arrow in the ground its
    /// acceleration. Where the body moves far, the picture follows it.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     File, .gif, .mp4 or .html: a page of one file that plays, scrubs and steps from event to
    ///     event by both clocks.
    /// fps : float, at most 1000, default 30
    ///     Frames per second (a GIF has a whole number of hundredths of a second for each
    ///     frame; a page has as many as the screen).
    /// speed : float, > 0, default 1.0
    ///     How fast the film is, see `clock`.
    /// clock : {"real", "zeno"}
    ///     "real": in one second of the film, `speed` seconds of the run. "zeno": in one second of the
    ///     film the time left to the next Zeno point decreases by `speed` decades, so that the impacts
    ///     before it do not become too fast to be seen, the gaps have a logarithmic axis, and the body is
    ///     shown once more with its gaps magnified; after the last Zeno point, and in a run without any,
    ///     as "real". See `frame_times`.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For another suffix, for a run of a LocalModel without a body, for a run without record
    ///     (record=False), for more than 20 000 frames, and for .mp4 without the program ffmpeg.
    /// OSError
    ///     If the file cannot be written.
    /// ImportError
    ///     For .gif and .mp4, without matplotlib (extra `plot`).
    #[pyo3(signature = (path, fps=None, speed=None, clock=None), text_signature = "($self, path, fps=30, speed=1.0, clock='real')")]
    fn animate<'py>(
        slf: &Bound<'py, Self>,
        path: PathBuf,
        fps: Option<&Bound<'py, PyAny>>,
        speed: Option<&Bound<'py, PyAny>>,
        clock: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<()> {
        let film = Film::read(fps, speed, clock)?;
        let clock = word(&film.clock);
        slf.py()
            .import("standfast.animation")?
            .call_method1("animate", (slf, path, film.fps, film.speed, clock))?;
        Ok(())
    }

    /// A player of the run for a cell of a notebook: the moving body above its gaps and its angle over time,
    /// in a frame that loads nothing from elsewhere. It scrubs, steps from event to event, and changes
    /// between both clocks. The saved notebook grows by about a megabyte.
    ///
    /// Parameters
    /// ----------
    /// height : int, px, from 100 to 10 000, default 640
    ///     Of the frame.
    /// speed : float or None, default None
    ///     At the beginning, as in `animate`; None: the film takes some seconds.
    /// clock : {"real", "zeno"}
    ///     At the beginning, as in `animate`.
    ///
    /// Returns
    /// -------
    /// Player
    ///     An object that a notebook shows.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `film`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    /// >>> sf.simulate(rod, q=(0, 0.011, 0.002), qdot=(0, 0, 0)).show(clock="zeno")     # in a notebook: the player
    /// <Player of a run: rest at 0.0477848068... s>
    #[pyo3(signature = (height=640, speed=None, clock=None), text_signature = "($self, height=640, speed=None, clock='real')")]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        #[pyo3(from_py_with = input::frame_height)] height: usize,
        speed: Option<&Bound<'py, PyAny>>,
        clock: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let film = Film::read(None, speed, clock)?;
        let arguments = (slf, height, speed.map(|_| film.speed), word(&film.clock));
        slf.py().import("standfast.notebook")?.call_method1("show", arguments)
    }

    /// What a player shows of the run, as a dict that JSON can hold: {"drawing", "frames", "phases",
    /// "impacts", "zeno_points", ...}. "frames" has columns with an entry for each frame: t (s on the clock
    /// of the run), zeno (the other clock, see `film_time`), q, gaps (m) and forces (N, (tangential,
    /// normal) of each contact).
    ///
    /// Parameters
    /// ----------
    /// frames : int, at least 2, default 2000
    ///     Their number; some more are at the events.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For a run of a LocalModel without a body, and for a run without record (record=False).
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    /// >>> film = sf.simulate(rod, q=(0, 0.011, 0.002), qdot=(0, 0, 0)).film(frames=100)
    /// >>> film["outcome"], film["frames"]["q"][0]
    /// ('rest', [0.0, 0.011, 0.002])
    #[pyo3(signature = (frames=2000))]
    fn film<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = input::frames)] frames: usize,
    ) -> PyResult<Bound<'py, PyAny>> {
        let film = interruptible(py, |cancel| standfast::ask::Film::of(&self.0, frames, cancel))?;
        py.import("json")?.call_method1("loads", (film.to_json(),))
    }

    /// Times (k,) of the frames of a film with `fps` frames per second, s on the clock of the run. The
    /// first is the start, the last the end.
    ///
    /// Parameters
    /// ----------
    /// fps : float, at most 1000, default 30
    ///     Frames per second.
    /// speed : float, > 0, default 1.0
    ///     How fast the film is, see `clock`.
    /// clock : {"real", "zeno"}
    ///     "real": `speed` seconds of the run in one second of the film. "zeno": towards the next Zeno
    ///     point with infinitely many impacts the time left decreases by `speed` decades in one second
    ///     of the film: impacts whose flights become shorter by the factor e are evenly spaced, by
    ///     log10(1/e) at speed 1. This ends where a fall in the time left could not lift a contact
    ///     above a gap that counts as closed; the next frame shows the Zeno point itself. After the
    ///     last one, and in a run without any: as "real".
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For values out of range, for more than 20 000 frames, and for a run without record
    ///     (record=False).
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> ball = sf.Posture(mass=1, gyration_radius=0.4, center_of_mass=(0, 0), contacts=[sf.Contact(point=(0, 0))],
    /// ...                   restitution=0.5, gravity=10)
    /// >>> run = sf.simulate(ball, q=(0, 5, 0), qdot=(0, 0, 0))      # impacts 2, 1, 1/2, ... s before a Zeno point at 3 s
    /// >>> 3 - run.frame_times(fps=1, clock="zeno")[:4]             # time left
    /// array([3.   , 0.3  , 0.03 , 0.003])
    #[pyo3(signature = (fps=None, speed=None, clock=None), text_signature = "($self, fps=30, speed=1.0, clock='real')")]
    fn frame_times<'py>(
        &self,
        py: Python<'py>,
        fps: Option<&Bound<'py, PyAny>>,
        speed: Option<&Bound<'py, PyAny>>,
        clock: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let film = Film::read(fps, speed, clock)?;
        let times = self.0.frame_times(film.fps, film.speed, film.clock);
        Ok(times.map_err(|e| to_py(&e))?.into_pyarray(py))
    }

    /// Times (...) of a film, s, at which it shows the times t : (...) s on the clock of the run. Times outside the run count as its start or its end.
    ///
    /// Parameters
    /// ----------
    /// t : (...) array_like, s
    ///     On the clock of the run.
    /// speed : float, > 0, default 1.0
    /// clock : {"real", "zeno"}
    ///     As in `frame_times`.
    #[pyo3(signature = (t, speed=None, clock=None), text_signature = "($self, t, speed=1.0, clock='real')")]
    fn film_time<'py>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        speed: Option<&Bound<'py, PyAny>>,
        clock: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (t, film) = (doubles("t", t)?, Film::read(None, speed, clock)?);
        let t = t.as_array();
        let shown = t.iter().map(|&t| self.0.film_time(t, film.clock) / film.speed);
        array(py, shown.collect(), t.shape())
    }

    /// The run as plain dictionaries, lists and numbers.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.0.to_json(),))
    }

    /// The collisions of `run.impacts` as one-dimensional columns, a dict for
    /// pandas.DataFrame(run.impact_table()). Empty columns unless recorded.
    ///
    /// The infinitely many impacts that are summed are not listed: see `run.zeno_points`. The rates of the
    /// other contacts are in `run.impacts`.
    ///
    /// Returns
    /// -------
    /// dict
    ///     * time, elapsed: s.
    ///     * contact: its number, from 1.
    ///     * x, y: the point that is hit, m (runs of a posture).
    ///     * rate_before, rate_after: gap rate of the contact that is hit, m/s; NaN for a side, which has no gap.
    ///     * impulse_tangential, impulse_normal: N s, NaN without a mass.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> ball = sf.Posture(mass=2, gyration_radius=1, center_of_mass=(0, 0),
    /// ...                   contacts=[sf.Contact(point=(0, 0))], restitution=0.5, gravity=10)
    /// >>> run = sf.simulate(ball, q=(0, 5, 0), qdot=(0, 0, 0), stop="time", time_limit=2.25)
    /// >>> run.impact_table()["impulse_normal"]        # m (1 + e) times the speed, 10 m/s and 5 m/s
    /// array([30., 15.])
    fn impact_table<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.series")?.call_method1("impact_table", (slf,))
    }

    /// The motion over time as an xarray.Dataset.
    ///
    /// Variables over time: q, qdot (coordinate: x, y, theta), gaps, rates and mode (contact, from 1; mode
    /// is the letter of `phases`), points (contact, axis: x, y), forces (contact, direction: tangential,
    /// normal). The contacts are those of `run.contacts`; sides have no gaps and rates (NaN). Attributes:
    /// units and long_name of each variable; outcome, model, model_reason, posture and the version of
    /// standfast of the dataset. NaN as in `at`, `points_at` and `forces_at`. Needs xarray: the extra
    /// `map`.
    ///
    /// Parameters
    /// ----------
    /// t : (k,) array_like or None, s, default None
    ///     Times of the run. None: a thousand times as those of `sample`, the times of all impacts, and the
    ///     starts and ends of all phases. At the time of an event the values are those after it.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `at`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    /// >>> run = sf.simulate(rod, q=(0, 0.011, 0.002), qdot=(0, 0, 0))
    /// >>> run.to_xarray([0.0, run.time]).forces.sel(direction="normal").values
    /// array([[0.   , 0.   ],
    ///        [4.905, 4.905]])
    #[pyo3(signature = (t=None))]
    fn to_xarray<'py>(
        slf: &Bound<'py, Self>,
        t: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.series")?.call_method1("to_xarray", (slf, t))
    }

    /// Writes the run to a file that `load` reads: JSON, as `to_json`.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.to_json(py, path)
    }

    /// Reads a file of `save` or `to_json`: simulates the run again, with the start and the options of the
    /// file, and compares the result with every number of the file, to the last bit.
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
    ///     Names the file and what is wrong in it, or the first value in which the run differs from it.
    ///     Another version of standfast may compute other last digits.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        interruptible_run(py, |cancel| Trajectory::load_until(path, cancel))
    }

    /// Writes the run as JSON.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file.
    fn to_json(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        write_whole(py, path, self.0.to_json().into_bytes())
    }

    /// The HTML that a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.notebook")?.call_method1("of_run", (slf,))
    }

    fn __repr__(&self) -> String {
        let points = self.0.zeno_points();
        let (rest, moving): (Vec<_>, Vec<_>) =
            points.iter().partition(|z| z.method == ZenoMethod::Rest);
        let (plastic, zeno): (Vec<_>, Vec<_>) = moving.into_iter().partition(|z| z.plastic);
        let mut events = vec![counted(self.0.collisions(), "collision")];
        if !plastic.is_empty() {
            events.push(counted(plastic.len(), "plastic landing"));
        }
        let only = match zeno.as_slice() {
            [z] => format!(" ({} at {} s, {})", z.kind, z.time, z.method),
            _ => String::new(),
        };
        if !zeno.is_empty() {
            events.push(counted(zeno.len(), "Zeno point") + &only);
        }
        if let [z, ..] = rest.as_slice() {
            let numbers: Vec<_> = z.contacts.iter().map(|contact| contact.number()).collect();
            events.push(format!("{} on the ground from the start", contacts(&numbers)));
        }
        let warnings = match self.0.warnings() {
            [] => String::new(),
            all => format!("; {}: {}", counted(all.len(), "warning"), first_words(&all[0])),
        };
        format!(
            "<Run: {} at {} s; {} model; {}{warnings}>",
            self.outcome(),
            self.0.time(),
            self.model(),
            events.join(", ")
        )
    }
}

/// How a film shows a run.
struct Film {
    fps: f64,
    speed: f64,
    clock: FilmClock,
}

impl Film {
    fn read(
        fps: Option<&Bound<'_, PyAny>>,
        speed: Option<&Bound<'_, PyAny>>,
        clock: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut film = Self { fps: 30.0, speed: 1.0, clock: FilmClock::Real };
        if let Some(fps) = fps {
            film.fps = input::fps(fps)?;
        }
        if let Some(speed) = speed {
            film.speed = input::speed(speed)?;
        }
        if let Some(clock) = clock {
            film.clock = call("clock", input::clock(clock)?)?;
        }
        Ok(film)
    }
}

/// Contacts by their numbers: "contact 2", "contacts 1, 2 and 3".
fn contacts(numbers: &[usize]) -> String {
    let names: Vec<String> = numbers.iter().map(ToString::to_string).collect();
    match names.as_slice() {
        [] => String::from("no contact"),
        [only] => format!("contact {only}"),
        [others @ .., last] => format!("contacts {} and {last}", others.join(", ")),
    }
}

type Pair<'py> = (Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>);
type Sample<'py> =
    (Bound<'py, PyArray1<f64>>, Bound<'py, PyArrayDyn<f64>>, Bound<'py, PyArrayDyn<f64>>);

impl PyRun {
    /// Numbers of this shape at each time, (..., *shape).
    fn at_times<'py, V: IntoIterator<Item = f64>>(
        &self,
        py: Python<'py>,
        t: &Bound<'py, PyAny>,
        shape: &[usize],
        of: impl Fn(&mut Reader<'_>, f64) -> Result<V, Error>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let t = doubles("t", t)?;
        let values = self.at_each(&t, shape.iter().product(), of)?;
        array(py, values, &[t.as_array().shape(), shape].concat())
    }

    /// `width` numbers at each time. They are computed in the order of time, in which each piece of the motion is prepared once.
    fn at_each<V: IntoIterator<Item = f64>>(
        &self,
        t: &PyReadonlyArrayDyn<'_, f64>,
        width: usize,
        of: impl Fn(&mut Reader<'_>, f64) -> Result<V, Error>,
    ) -> PyResult<Vec<f64>> {
        let times: Vec<f64> = t.as_array().iter().copied().collect();
        let mut order: Vec<usize> = (0..times.len()).collect();
        if !times.is_sorted() {
            order.sort_by(|&one, &other| times[one].total_cmp(&times[other]));
        }
        let (mut reader, mut values) = (self.0.reader(), vec![0.0; width * times.len()]);
        for k in order {
            let Ok(found) = of(&mut reader, times[k]) else {
                // The error is that of the first time in the order of the array.
                let mut errors = times.iter().filter_map(|&t| of(&mut reader, t).err());
                return Err(errors
                    .next()
                    .map_or_else(|| unreachable!("it fails again"), |e| to_py(&e)));
            };
            for (to, value) in values[k * width..].iter_mut().zip(found) {
                *to = value;
            }
        }
        Ok(values)
    }
}

/// Simulates a run without the GIL; Ctrl-C ends it.
pub(crate) fn interruptible_run(
    py: Python<'_>,
    run: impl Send + FnOnce(&dyn Fn() -> bool) -> Result<Trajectory, Error>,
) -> PyResult<PyRun> {
    interruptible(py, run).map(PyRun)
}
