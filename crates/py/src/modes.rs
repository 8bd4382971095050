//! Contact modes.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict, PyIterator, PyList};
use standfast::modes::{
    ContactProblem, Jamming, Level, Margin, MechanismProblem, Method, ModeAnswer, Modes,
    ProblemFields,
};
use standfast::{Error, State};

use crate::assembly::some_mechanism;
use crate::convert::{array, call, float, pair_text, word};
use crate::error::to_py;
use crate::files::write_whole;
use crate::input;
use crate::lists::{self, Threads};
use crate::mechanism::PyMechanism;
use crate::posture::PyPosture;

/// Number of words that a message or a repr lists.
const LISTED: usize = 12;

/// The contacts of a rigid body at one instant, as plain data. Each list has one entry per contact.
///
/// Parameters
/// ----------
/// mass : float, kg
/// gyration_radius : float, m
/// arms : (n, 2) array_like, m
///     From the centre of mass to the contact points, world axes.
/// tangents : (n, 2) array_like
///     Unit vectors t; the normals are t turned by +90°.
/// friction : (n,) array_like, from 0 to 1e12
///     Coefficients of friction μ.
/// sliding : sequence of float or None
///     Sign of the sliding velocity, 1, −1 or 0, or None where the contact is separated (level
///     "impulse": 0 or None).
/// bias : (n, 2) array_like, m/s²
///     (tangential, normal), added to J q̈.
/// free_acceleration : (3,) array_like, m/s² and rad/s²
///     (ẍ, ÿ, θ̈) without contact forces.
/// level : {"acceleration", "impulse"}
///     At the level "impulse" bias is in m/s, and free_acceleration is
///     the velocity without contact impulses.
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> problem = sf.ContactProblem(mass=1, gyration_radius=0.5, arms=[(-1, -1), (1, -1)], tangents=[(1, 0), (1, 0)],
/// ...                             friction=[1.5, 1.5], sliding=[+1, +1], bias=[(0, 0), (0, 0)],
/// ...                             free_acceleration=(0, -1, 0))
/// >>> sf.contact_modes(problem).status        # Painlevé: no bounded force lets this body slide on
/// 'none'
#[pyclass(frozen, eq, name = "ContactProblem", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyContactProblem(pub(crate) ContactProblem);

#[pymethods]
impl PyContactProblem {
    #[new]
    #[pyo3(signature = (mass, gyration_radius, arms, tangents, friction, sliding, bias, free_acceleration, level="acceleration"))]
    #[allow(clippy::too_many_arguments, reason = "the fields of the face")]
    fn new(
        #[pyo3(from_py_with = input::mass)] mass: f64,
        #[pyo3(from_py_with = input::gyration_radius)] gyration_radius: f64,
        #[pyo3(from_py_with = input::arms)] arms: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::tangents)] tangents: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::frictions)] friction: Vec<f64>,
        #[pyo3(from_py_with = input::sliding)] sliding: Vec<Option<i8>>,
        #[pyo3(from_py_with = input::bias)] bias: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::free_acceleration)] free_acceleration: [f64; 3],
        #[pyo3(from_py_with = input::level)] level: &str,
    ) -> PyResult<Self> {
        ContactProblem::new(ProblemFields {
            mass,
            gyration_radius,
            arms,
            tangents,
            friction,
            sliding,
            bias,
            free_acceleration,
            level: call("level", level)?,
        })
        .map(Self)
        .map_err(|e| to_py(&e))
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.0.fields().mass
    }

    #[getter]
    fn gyration_radius(&self) -> f64 {
        self.0.fields().gyration_radius
    }

    #[getter]
    fn arms(&self) -> Vec<(f64, f64)> {
        tuples(&self.0.fields().arms)
    }

    #[getter]
    fn tangents(&self) -> Vec<(f64, f64)> {
        tuples(&self.0.fields().tangents)
    }

    #[getter]
    fn friction(&self) -> Vec<f64> {
        self.0.fields().friction.clone()
    }

    #[getter]
    fn sliding<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, &self.0.fields().sliding)
    }

    #[getter]
    fn bias(&self) -> Vec<(f64, f64)> {
        tuples(&self.0.fields().bias)
    }

    #[getter]
    fn free_acceleration(&self) -> (f64, f64, f64) {
        self.0.fields().free_acceleration.into()
    }

    #[getter]
    fn level(&self) -> String {
        word(&self.0.fields().level)
    }

    /// How close sliding contacts are to jamming (Painlevé): a list of (contact number, direction, margin,
    /// critical friction), for each closed contact and each direction, "R" or "L", in which it slides or
    /// may begin to slide. margin : P(μ)/P(0), which is 1 without friction and negative for a contact that
    /// jams; P = (1 + b(b + σμc)/ρ²)/m, b = t·d, c = n·d.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.ContactProblem(mass=1, gyration_radius=(1/3)**0.5, arms=[(-0.6, -0.8)], tangents=[(1, 0)],
    /// ...                         friction=[2], sliding=[-1], bias=[(0, 0)], free_acceleration=(0, -1, 0))
    /// >>> [(number, direction, margin, critical)] = rod.jamming
    /// >>> f"contact {number} sliding {direction}: margin {margin:.3f}, critical friction {critical:.3f}"
    /// 'contact 1 sliding L: margin -0.385, critical friction 1.444'
    #[getter]
    fn jamming(&self) -> Vec<(usize, char, f64, f64)> {
        jams(&self.0.jamming())
    }

    fn __repr__(&self) -> String {
        let f = self.0.fields();
        let pairs = |list: &[[f64; 2]]| listed(list, |pair| pair_text(*pair));
        let sign = |sign: &Option<i8>| sign.map_or("None".into(), |sign| sign.to_string());
        format!(
            "ContactProblem(mass={}, gyration_radius={}, arms={}, tangents={}, friction={}, sliding={}, bias={}, free_acceleration={}, level='{}')",
            float(f.mass),
            float(f.gyration_radius),
            pairs(&f.arms),
            pairs(&f.tangents),
            listed(&f.friction, |mu| float(*mu)),
            listed(&f.sliding, sign),
            pairs(&f.bias),
            listed(&f.free_acceleration, |part| float(*part)),
            self.level()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let names = [
            "mass",
            "gyration_radius",
            "arms",
            "tangents",
            "friction",
            "sliding",
            "bias",
            "free_acceleration",
            "level",
        ];
        let values: PyResult<Vec<_>> = names.iter().map(|name| slf.getattr(*name)).collect();
        Ok((slf.get_type().into_any(), PyList::new(slf.py(), values?)?.to_tuple().into_any()))
    }
}

fn tuples(pairs: &[[f64; 2]]) -> Vec<(f64, f64)> {
    pairs.iter().map(|pair| (*pair).into()).collect()
}

fn listed<T>(items: &[T], text: impl Fn(&T) -> String) -> String {
    format!("[{}]", items.iter().map(text).collect::<Vec<_>>().join(", "))
}

/// The solution for one word of contact modes.
///
/// Attributes
/// ----------
/// word : str
///     a letter for each contact: S separate, F fixed, R or L sliding right or left.
/// acceleration : (3,) ndarray, m/s² and rad/s²
///     (ẍ, ÿ, θ̈); of a mechanism (dof,).
/// forces : (n, 2) ndarray, N
///     By contact (tangential, normal). At the level "impulse" acceleration is the velocity
///     after the impact, m/s and rad/s, and forces are impulses, N s.
/// determined : {"unique", "family", "singular", "undetermined", "impossible"}
///     How the word determines its forces: "unique"; "family" (forces has the smallest of the
///     family), "singular" (friction matrix), "undetermined" (with sliding friction the motion
///     depends on how the contacts share their forces) or "impossible" (no forces give the motion
///     of the word).
/// force_interval : (float, float) or None, N
///     For two fixed contacts, the range of the internal force.
/// margins : list of (int, str, float)
///     (contact number, test, margin) for all tests; the margin is negative where the test fails, and relative to the load.
/// consistent : bool
///     Whether Coulomb's law holds.
/// violated : list of str
///     Names of the tests that fail.
/// near_degenerate : bool
///     Whether rounding may decide a test.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
/// >>> mode = sf.contact_modes(rod)["SF"]      # the left end lifts off, the right one holds
/// >>> mode.consistent, mode.violated
/// (False, ['contact 1: a_n > 0'])
#[pyclass(frozen, eq, name = "ContactMode", module = "standfast.results")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyContactMode(ModeAnswer, Arc<Asked>);

/// The contact-mode problem of a mechanism: contacts with these signs of sliding.
///
/// Parameters
/// ----------
/// mechanism : Mechanism or System
/// sliding : sequence of int or None, or None, default None
///     For each contact 1, −1 or 0, or None where it is separated; None: all contacts are at rest.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Mechanism.of_posture(sf.Posture.rod(half_length=0.5, gyration_radius=0.2, friction=0.5))
/// >>> sf.contact_modes(sf.MechanismProblem(rod, sliding=[1, None])).consistent      # the left end slides, the right one is in the air
/// ['RS']
#[pyclass(frozen, eq, name = "MechanismProblem", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyMechanismProblem(MechanismProblem);

#[pymethods]
impl PyMechanismProblem {
    #[new]
    #[pyo3(signature = (mechanism, sliding=None))]
    fn new(
        #[pyo3(from_py_with = mechanism)] mechanism: PyMechanism,
        sliding: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let Some(sliding) = sliding else {
            return Ok(Self(MechanismProblem::at_rest(&mechanism.0)));
        };
        let sliding = input::sliding(sliding)?;
        MechanismProblem::new(&mechanism.0, &sliding).map(Self).map_err(|e| to_py(&e))
    }

    #[getter]
    fn mechanism(&self) -> PyMechanism {
        PyMechanism(self.0.mechanism().clone())
    }

    #[getter]
    fn sliding(&self) -> Vec<Option<i8>> {
        self.0.sliding().to_vec()
    }

    /// As that of a `ContactProblem`; P = N M⁻¹(N − σμT)ᵀ.
    #[getter]
    fn jamming(&self) -> Vec<(usize, char, f64, f64)> {
        jams(&self.0.jamming())
    }

    fn __repr__(&self) -> String {
        let sliding = listed(self.0.sliding(), |sign| match sign {
            Some(sign) => sign.to_string(),
            None => "None".into(),
        });
        format!("MechanismProblem({}, sliding={sliding})", self.mechanism().__repr__())
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> (Bound<'py, PyAny>, (PyMechanism, Vec<Option<i8>>)) {
        let problem = slf.get();
        (slf.get_type().into_any(), (problem.mechanism(), problem.sliding()))
    }
}

fn jams(found: &[Jamming]) -> Vec<(usize, char, f64, f64)> {
    found
        .iter()
        .map(|j| (j.contact.number(), j.direction.letter(), j.margin, j.critical_friction))
        .collect()
}

/// Reads a mechanism.
pub(crate) fn mechanism(value: &Bound<'_, PyAny>) -> PyResult<PyMechanism> {
    some_mechanism(value)?
        .ok_or_else(|| input::wrong_type("mechanism", value, "a Mechanism is needed"))
}

/// The problem of a body or of a mechanism.
#[derive(Clone, PartialEq, IntoPyObject)]
pub(crate) enum PyProblem {
    Body(PyContactProblem),
    Mechanism(PyMechanismProblem),
}

impl PyProblem {
    pub(crate) fn of_body(problem: ContactProblem) -> Self {
        Self::Body(PyContactProblem(problem))
    }

    pub(crate) fn of_mechanism(problem: MechanismProblem) -> Self {
        Self::Mechanism(PyMechanismProblem(problem))
    }

    fn solve(&self, method: Method) -> Result<Modes, Error> {
        match self {
            Self::Body(problem) => standfast::modes::contact_modes(&problem.0, method),
            Self::Mechanism(problem) => standfast::modes::contact_modes(&problem.0, method),
        }
    }
}

/// The arguments of a call of `contact_modes`, which determine its result.
#[derive(PartialEq)]
struct Asked {
    problem: PyProblem,
    method: Method,
}

impl Asked {
    /// The call that repeats it.
    fn again<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let ask = py.import("standfast")?.getattr("contact_modes")?;
        let method = [("method", word(&self.method))].into_py_dict(py)?;
        py.import("functools")?.call_method("partial", (ask,), Some(&method))
    }
}

#[pymethods]
impl PyContactMode {
    #[getter]
    fn word(&self) -> String {
        self.0.word.to_string()
    }

    #[getter]
    fn acceleration<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.0.acceleration)
    }

    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let forces = &self.0.forces;
        array(py, forces.iter().flatten().copied().collect(), &[forces.len(), 2])
    }

    #[getter]
    fn determined(&self) -> String {
        word(&self.0.determined)
    }

    #[getter]
    fn force_interval(&self) -> Option<(f64, f64)> {
        self.0.force_interval.map(Into::into)
    }

    #[getter]
    fn margins(&self) -> Vec<(usize, String, f64)> {
        let margins = self.0.margins.iter();
        margins.map(|m| (m.contact.number(), m.condition.to_string(), m.value)).collect()
    }

    #[getter]
    fn consistent(&self) -> bool {
        self.0.consistent
    }

    #[getter]
    fn violated(&self) -> Vec<String> {
        let name = |m: &Margin| format!("contact {}: {}", m.contact, m.condition);
        self.0.violated().map(name).collect()
    }

    #[getter]
    fn near_degenerate(&self) -> bool {
        self.0.near_degenerate()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PyModes, String))> {
        let getitem = py.import("operator")?.getattr("getitem")?;
        let modes = self.1.problem.solve(self.1.method).map_err(|e| to_py(&e))?;
        let modes = PyModes { question: self.1.clone(), modes };
        Ok((getitem, (modes, self.word())))
    }

    fn __repr__(&self) -> String {
        let verdict = match self.violated().first() {
            _ if self.0.consistent => "consistent".into(),
            Some(test) => format!("fails at {test}"),
            None => "impossible".into(),
        };
        format!("<{}: {verdict}>", self.0.word)
    }
}

/// The words of the contacts with their solutions, by name.
///
/// `modes["FS"]` is a ContactMode; iterating gives the words. `print(modes)` shows a table.
///
/// Attributes
/// ----------
/// status : {"unique", "ambiguous", "none", "found", "not found"}
///     By the number of consistent words "unique", "ambiguous" or "none" ("ambiguous" also if the
///     only one is undetermined); after a search for one word "found" or "not found".
/// consistent : list of str
///     The consistent words.
/// problem : ContactProblem or MechanismProblem
///     The problem that was solved.
/// level : {"acceleration", "impulse"}
///     Its level.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> ball = sf.Posture(mass=2, gyration_radius=1, center_of_mass=(0, 1), contacts=[sf.Contact(point=(0, 0))],
/// ...                   restitution=0, gravity=10)
/// >>> modes = sf.contact_modes(ball)
/// >>> list(modes), modes.consistent, modes.status
/// (['S', 'F', 'R', 'L'], ['F'], 'unique')
/// >>> modes["F"].forces[0, 1]               # m g
/// np.float64(20.0)
#[pyclass(frozen, eq, mapping, name = "Modes", module = "standfast.results")]
#[derive(PartialEq)]
pub(crate) struct PyModes {
    question: Arc<Asked>,
    modes: Modes,
}

impl PyModes {
    fn new(problem: PyProblem, method: Method, modes: Modes) -> Self {
        Self { question: Arc::new(Asked { problem, method }), modes }
    }

    /// All words for up to two contacts, those that the method "auto" offers for more.
    pub(crate) fn solved(problem: PyProblem) -> PyResult<Self> {
        let count = match &problem {
            PyProblem::Body(problem) => problem.0.fields().arms.len(),
            PyProblem::Mechanism(problem) => problem.0.sliding().len(),
        };
        let method = if count <= 2 { Method::Enumerate } else { Method::Auto };
        let modes = problem.solve(method).map_err(|e| to_py(&e))?;
        Ok(Self::new(problem, method, modes))
    }

    fn get(&self, letters: &str) -> Option<&ModeAnswer> {
        letters.parse().ok().and_then(|word| self.modes.get(word))
    }
}

#[pymethods]
impl PyModes {
    #[getter]
    fn status(&self) -> &str {
        self.modes.status().as_str()
    }

    #[getter]
    fn consistent(&self) -> Vec<String> {
        self.modes.consistent().map(|mode| mode.word.to_string()).collect()
    }

    #[getter]
    fn problem(&self) -> PyProblem {
        self.question.problem.clone()
    }

    #[getter]
    fn level(&self) -> String {
        match &self.question.problem {
            PyProblem::Body(problem) => word(&problem.0.fields().level),
            PyProblem::Mechanism(_) => word(&Level::Acceleration),
        }
    }

    /// The status, the consistent words, and the words with their motion, forces and margins as plain
    /// dictionaries, lists and numbers.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.modes.to_json(),))
    }

    /// Writes the dictionary of `to_dict` as JSON.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file.
    fn to_json(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        write_whole(py, path, self.modes.to_json().into_bytes())
    }

    fn __len__(&self) -> usize {
        self.modes.answers().len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        let words = self.modes.answers().iter().map(|mode| mode.word.to_string());
        PyList::new(py, words.collect::<Vec<_>>())?.try_iter()
    }

    fn __contains__(&self, word: &Bound<'_, PyAny>) -> bool {
        input::letters(word).is_ok_and(|letters| self.get(letters).is_some())
    }

    fn __getitem__(
        &self,
        #[pyo3(from_py_with = input::letters)] word: &str,
    ) -> PyResult<PyContactMode> {
        let mode = |answer| PyContactMode(answer, self.question.clone());
        self.get(word).cloned().map(mode).ok_or_else(|| {
            let asked: String = word.chars().take(standfast::body::MAX_CONTACTS).collect();
            let words = self.modes.answers().iter();
            PyKeyError::new_err(format!("{asked}: the words are {}", some(words, self.__len__())))
        })
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (PyProblem,))> {
        Ok((self.question.again(py)?, (self.problem(),)))
    }

    fn __repr__(&self) -> String {
        let count = self.modes.consistent().count();
        let words = some(self.modes.consistent(), count);
        let colon = if count == 0 { "" } else { ": " };
        format!("<{}{colon}{words} ({} words)>", self.status(), self.__len__())
    }

    fn __str__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.table")?.call_method1("modes_table", (slf,))
    }

    /// The HTML that a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.notebook")?.call_method1("of_modes", (slf,))
    }
}

/// The first `count` words of a list, as text.
fn some<'a>(modes: impl Iterator<Item = &'a ModeAnswer>, count: usize) -> String {
    let words: Vec<_> = modes.take(LISTED).map(|mode| mode.word.to_string()).collect();
    let rest =
        if count > LISTED { format!(", and {} more", count - LISTED) } else { String::new() };
    words.join(", ") + &rest
}

/// The contact modes that Coulomb's law allows in a state: every word, with its motion and forces.
///
/// A sequence of them, or an array of objects, has a list of Modes, or an array, with None for None, as
/// for `stability`; the other arguments are the same for each.
///
/// A contact is closed if |gap| is within rounding.
///
/// Parameters
/// ----------
/// posture : Posture, ContactProblem, Mechanism, System or MechanismProblem, or a sequence or object array of them
///     A ContactProblem has its own state and load; a Mechanism is at rest in its posture.
/// q, qdot : (3,) array_like, m, m, rad and per second, default (0.0, 0.0, 0.0)
///     State of a posture.
/// method : {"auto", "enumerate", "qp"}
///     "enumerate" gives all words. "qp" searches for one consistent word by quadratic programmes,
///     and may fail to find one. "auto" takes the cheaper method: all words for up to six closed
///     contacts, one consistent word for more.
/// wrench : (3,) array_like, N, N, N m, default (0.0, 0.0, 0.0)
///     (f_x, f_y, torque about the centre of mass), added to gravity.
/// threads : int or None, default None
///     As for `stability`.
/// progress : bool or None, default None
///     As for `stability`.
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range. A closed contact that approaches its
///     ground is an error too, because an impact comes first.
///
/// Examples
/// --------
/// >>> import math
/// >>> import standfast as sf
/// >>> feet = [sf.Contact(point=(x, 0), slope=0, friction=1) for x in (-1, 1)]
/// >>> table = sf.Posture(mass=1, gyration_radius=0.5, center_of_mass=(0, 2), contacts=feet, restitution=0, gravity=10)
/// >>> sf.contact_modes(table).consistent
/// ['FF']
/// >>> sf.contact_modes(table, wrench=(6, 0, 0)).consistent      # pushed hard, it tips over the right foot
/// ['SF']
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the keywords of the function in Python")]
#[pyo3(signature = (posture, q=[0.0; 3], qdot=[0.0; 3], *, method="auto", wrench=[0.0; 3], threads=None, progress=None, **unknown), text_signature = "(posture, q=(0.0, 0.0, 0.0), qdot=(0.0, 0.0, 0.0), *, method=\"auto\", wrench=(0.0, 0.0, 0.0), threads=None, progress=None)")]
pub(crate) fn contact_modes<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = subjects)] posture: lists::Asked<Subject>,
    #[pyo3(from_py_with = input::q)] q: [f64; 3],
    #[pyo3(from_py_with = input::qdot)] qdot: [f64; 3],
    #[pyo3(from_py_with = input::method)] method: &str,
    #[pyo3(from_py_with = input::wrench)] wrench: [f64; 3],
    #[pyo3(from_py_with = input::threads)] threads: Option<usize>,
    #[pyo3(from_py_with = lists::progress)] progress: Option<bool>,
    unknown: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    input::no_keywords("contact_modes", unknown)?;
    let method = call("method", method)?;
    let solved = |of: &Subject, _: &dyn Fn() -> bool| {
        let problem = of.problem(q, qdot, wrench)?;
        let modes = problem.solve(method)?;
        Ok((problem, modes))
    };
    match posture {
        lists::Asked::One(of) => {
            let (problem, modes) =
                py.detach(|| solved(&of, &|| false)).map_err(|e: Error| to_py(&e))?;
            Ok(PyModes::new(problem, method, modes).into_pyobject(py)?.into_any())
        }
        lists::Asked::Many(list) => {
            let found = list.answers(py, Threads { count: threads, progress }, &solved)?;
            list.objects(py, found, |_, (problem, modes)| PyModes::new(problem, method, modes))
        }
    }
}

/// What has contact modes.
pub(crate) enum Subject {
    Posture(PyPosture),
    Problem(Box<PyProblem>),
    Mechanism(PyMechanism),
}

impl Subject {
    /// Its problem in a state and with a wrench, which only a posture can have.
    fn problem(&self, q: [f64; 3], qdot: [f64; 3], wrench: [f64; 3]) -> Result<PyProblem, Error> {
        let own = match self {
            Self::Posture(posture) => {
                let problem = ContactProblem::of_posture(&posture.0, &State::new(q, qdot), wrench);
                return problem.map(PyProblem::of_body);
            }
            Self::Problem(problem) => match **problem {
                PyProblem::Body(_) => "a ContactProblem has a state and load of its own",
                PyProblem::Mechanism(_) => "a MechanismProblem has signs of sliding of its own",
            },
            Self::Mechanism(_) => {
                "a Mechanism is given in its posture at rest; a MechanismProblem has signs of sliding"
            }
        };
        for (field, value) in [("q", q), ("qdot", qdot), ("wrench", wrench)] {
            if value != [0.0; 3] {
                return Err(input::refused(field, value, own));
            }
        }
        Ok(match self {
            Self::Mechanism(of) => PyProblem::of_mechanism(MechanismProblem::at_rest(&of.0)),
            Self::Problem(problem) => (**problem).clone(),
            Self::Posture(_) => unreachable!("a posture has been answered"),
        })
    }
}

/// Reads what has contact modes, or a list of such.
fn subjects(value: &Bound<'_, PyAny>) -> PyResult<lists::Asked<Subject>> {
    let read = |value: &Bound<'_, PyAny>| {
        Ok(if let Ok(posture) = value.cast::<PyPosture>() {
            Some(Subject::Posture(posture.get().clone()))
        } else if let Ok(problem) = value.cast::<PyContactProblem>() {
            Some(Subject::Problem(Box::new(PyProblem::Body(problem.get().clone()))))
        } else if let Ok(problem) = value.cast::<PyMechanismProblem>() {
            Some(Subject::Problem(Box::new(PyProblem::Mechanism(problem.get().clone()))))
        } else {
            some_mechanism(value)?.map(Subject::Mechanism)
        })
    };
    lists::Asked::read(value, read, input::no_body)
}
