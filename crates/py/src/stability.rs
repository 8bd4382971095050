//! Stability of postures.

use std::path::PathBuf;

use numpy::PyArray2;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use standfast::State;
use standfast::modes::{ContactProblem, MechanismProblem};
use standfast::options::Jams;
use standfast::stability::{
    DEFAULT_WIDTH, StabilityOptions, StaticForces, Verdict, holding_pairs, mechanism_forces,
    mechanism_friction_margin, mechanism_pairs, mechanism_stability,
};

use crate::assembly::some_mechanism;
use crate::chain::PyChain;
use crate::convert::word;
use crate::error::to_py;
use crate::files::write_whole;
use crate::input;
use crate::interrupt::interruptible;
use crate::lists::{self, Asked, Threads};
use crate::mechanism::{PyMechanism, body};
use crate::modes::{PyModes, PyProblem};
use crate::posture::PyPosture;

/// The verdict on a posture: whether the body returns to rest after every small kick. Fields that apply
/// to bodies on two contacts only, such as kinematic_strong, are None for other bodies. `print(verdict)` shows all with a table of the modes.
///
/// Attributes
/// ----------
/// frictional_stability : {"stable", "unstable", "undecided"}
///     The verdict; `by` is the argument, `evidence` its data.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> feet = [sf.Contact(point=(x, 0), friction=0.5) for x in (-1, 1)]
/// >>> box = sf.Posture(mass=1, gyration_radius=0.4, center_of_mass=(0, 0.2), contacts=feet, restitution=0.1)
/// >>> verdict = sf.stability(box)
/// >>> verdict.frictional_stability, verdict.by, verdict.kinematic_strong
/// ('stable', 'theorem-3-loose', True)
#[pyclass(frozen, name = "Verdict", module = "standfast")]
pub(crate) struct PyVerdict {
    on: Standing,
    verdict: Verdict,
}

/// What a verdict is about.
#[derive(Clone, PartialEq, IntoPyObject)]
pub(crate) enum Standing {
    Body(PyPosture),
    Mechanism(PyMechanism),
}

/// A posture, a mechanism or a system; `None` for anything else.
fn some_standing(value: &Bound<'_, PyAny>) -> PyResult<Option<Standing>> {
    if let Ok(posture) = value.cast::<PyPosture>() {
        return Ok(Some(Standing::Body(posture.get().clone())));
    }
    Ok(some_mechanism(value)?.map(Standing::Mechanism))
}

/// Reads a posture or a mechanism.
pub(crate) fn standing(value: &Bound<'_, PyAny>) -> PyResult<Standing> {
    some_standing(value)?.ok_or_else(|| {
        let list = value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>();
        let needed = if value.is_instance_of::<PyChain>() {
            OF_CHAIN
        } else if list {
            "one Posture or one Mechanism is needed: simulate_many follows many bodies, each by itself; bodies that touch each other are one Mechanism"
        } else {
            "a Posture or a Mechanism is needed"
        };
        input::wrong_type("posture", value, needed)
    })
}

const OF_CHAIN: &str = "a Posture or a Mechanism is needed, such as chain.mechanism(q)";

/// Reads a posture, a mechanism, or a list of them.
pub(crate) fn standings(value: &Bound<'_, PyAny>) -> PyResult<Asked<Standing>> {
    Asked::read(value, some_standing, |field, value| {
        let needed = if value.is_instance_of::<PyChain>() {
            OF_CHAIN
        } else if field == "posture" {
            "a Posture, a Mechanism or a sequence of them is needed"
        } else {
            "a Posture, a Mechanism or None is needed"
        };
        input::wrong_type(field, value, needed)
    })
}

#[pymethods]
impl PyVerdict {
    /// The numbers of the contacts that touch. Words have a letter for each of them.
    #[getter]
    fn contacts(&self) -> Vec<usize> {
        self.verdict.contacts.iter().map(|contact| contact.number()).collect()
    }

    /// Whether friction and normal forces can hold the body.
    #[getter]
    fn equilibrium(&self) -> bool {
        self.verdict.equilibrium.holds
    }

    /// Distance of the centre of mass to the nearer end of the equilibrium region, m; negative outside. Of a mechanism that is not a rigid
    /// body: the largest weight that all edges of the friction cones can have at once, relative to the load; −inf if the load is not held.
    #[getter]
    fn equilibrium_margin(&self) -> f64 {
        self.verdict.equilibrium.margin
    }

    /// Interval (low, high) of abscissas of the centre of mass with equilibrium, m; None if it is empty.
    #[getter]
    fn equilibrium_region(&self) -> Option<(f64, f64)> {
        self.verdict.equilibrium.region.map(Into::into)
    }

    /// Whether every word that moves fails a kinematic test although its forces satisfy theirs (f_n ≥ 0).
    #[getter]
    fn kinematic_strong(&self) -> Option<bool> {
        self.verdict.conditions.map(|found| found.kinematic_strong)
    }

    /// The same with the friction cone required of the forces of fixed contacts, too.
    #[getter]
    fn kinematic_strong_strict(&self) -> Option<bool> {
        self.verdict.conditions.map(|found| found.kinematic_strong_strict)
    }

    /// Least distance of a condition from a change of `kinematic_strong`, relative to the load.
    #[getter]
    fn kinematic_margin(&self) -> Option<f64> {
        self.verdict.conditions.map(|found| found.kinematic_margin)
    }

    /// Whether FF is the only consistent word at rest.
    #[getter]
    fn unambiguous(&self) -> Option<bool> {
        self.verdict.conditions.map(|found| found.unambiguous)
    }

    /// ψ = sign(ψ_1)√(ψ_1ψ_2)
    #[getter]
    fn coupling(&self) -> Option<f64> {
        self.verdict.conditions.map(|found| found.coupling)
    }

    /// Whether clattering converges: the paper's (10).
    #[getter]
    fn clattering(&self) -> Option<bool> {
        self.verdict.conditions.map(|found| found.clattering)
    }

    /// ψ minus the bound of (10).
    #[getter]
    fn clattering_margin(&self) -> Option<f64> {
        self.verdict.conditions.map(|found| found.clattering_margin)
    }

    /// Whether Goyal's bound holds: alternate impacts without gravity never end.
    #[getter]
    fn chatter(&self) -> Option<bool> {
        self.verdict.conditions.map(|found| found.chatter)
    }

    /// ψ minus Goyal's bound.
    #[getter]
    fn chatter_margin(&self) -> Option<f64> {
        self.verdict.conditions.map(|found| found.chatter_margin)
    }

    /// Whether every frictionless motion comes to rest on the contacts: λ = D⁻¹(g_1, g_2) > 0.
    #[getter]
    fn energy(&self) -> Option<bool> {
        self.verdict.energy
    }

    /// Why every frictionless flight ends at a Zeno point: "energy" (λ > 0), "drift" (λ_j < 0, ψ_1, ψ_2 ≤ 0 and g > 0 at the other contact:
    /// contact j is not hit any more after a time of the size of the kick), or None.
    #[getter]
    fn flight(&self) -> Option<String> {
        self.verdict.flight.as_ref().map(word)
    }

    /// "stable": after every small kick the body comes back to rest; of a mechanism whose joints move, all its contacts are at rest from some time
    /// on. "unstable": not after some kicks, however small. Or "undecided".
    #[getter]
    fn frictional_stability(&self) -> &str {
        self.verdict.frictional_stability.as_str()
    }

    /// The argument: "not-equilibrium", "theorem-3", "theorem-3-loose", "goyal", "corner-map", "growing-cycle", "growing-trap", "single-support",
    /// "accelerating-mode", "no-solution", "well", "descending-pair", "neutral", "bounded-corners", "potential-well", or None.
    #[getter]
    fn by(&self) -> Option<&str> {
        self.verdict.by.map(standfast::stability::Argument::as_str)
    }

    /// What happens where a contact jams, as given to `stability` as `jams`: "none" or "impact".
    #[getter]
    fn after_jam(&self) -> String {
        word(&self.verdict.after_jam)
    }

    /// Every contact that jams while it slides (Painlevé), and every two contacts that jam only together: a
    /// list of dicts {"contacts", "slides", "friction"}. contacts : their numbers. slides : their
    /// directions, a letter "R" or "L" for each. friction : the coefficient of each from which up to the
    /// given one they jam; of two contacts both are multiplied by the same factor. One contact jams with
    /// any larger one, too. Certain for all numbers within the width.
    ///
    /// Examples
    /// --------
    /// >>> import math
    /// >>> import standfast as sf
    /// >>> angle, foot = math.radians(60), sf.Contact(point=(0, 0), friction=2)          # a uniform rod of 2 m: Painlevé's
    /// >>> rod = sf.Posture(mass=1, gyration_radius=3**-0.5, center_of_mass=(math.cos(angle), math.sin(angle)), contacts=[foot], restitution=0)
    /// >>> sf.stability(rod).jams
    /// [{'contacts': [1], 'slides': 'L', 'friction': [1.3471506281091266]}]
    #[getter]
    fn jams<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let width = self.verdict.width;
        let found = match &self.on {
            Standing::Body(posture) => {
                standfast::stability::jams(&posture.0, width).map_err(|e| to_py(&e))?
            }
            Standing::Mechanism(of) => standfast::stability::mechanism_jams(&of.0, width),
        };
        let list = PyList::empty(py);
        for jam in found {
            let entry = PyDict::new(py);
            let contacts: Vec<usize> = jam.contacts.iter().map(|c| c.number()).collect();
            entry.set_item("contacts", contacts)?;
            entry.set_item("slides", jam.slides.to_string())?;
            entry.set_item("friction", jam.friction)?;
            list.append(entry)?;
        }
        Ok(list.into_any())
    }

    /// The width of the numbers for which the verdict holds: see `stability`.
    #[getter]
    fn width(&self) -> f64 {
        self.verdict.width
    }

    /// Why the verdict is "undecided", in one word: "boundary" (on the border of the equilibria, up to the width), "ambiguous" (several words are consistent at rest), "jam" (a contact that
    /// slides jams, or may jam: no word is consistent), "modes" (after a slide or a landing several words are consistent, or rounding decides), "energy"
    /// (frictionless motion need not come to rest: neither energy nor drift), "flight" (the impacts after a corner cannot be followed to their end with
    /// certainty), "cells" (some directions of motion remain open), "degenerate" (the contacts depend on each other, or nearly so, or
    /// the signs that decide are not certain), "pairs" (three and more contacts: several pairs let the body descend, or the only one is
    /// undecided itself), "joints" (no theorem decides about the mechanism: it is no rigid body, and without friction its contacts do not hold the load). Also of mechanisms whose
    /// contacts hold the load without friction: "slides" (the load may shift to contacts that do not resist a slide on a level), "held" (friction may hold it
    /// above its posture), "law" (it slides on a level, and rest is proved for Moreau's law with one restitution, also in tangential direction), "many" (too many contacts to try all slides). None if
    /// the verdict is decided. `print(verdict)` says it in words, and what to try.
    #[getter]
    fn reason(&self) -> Option<&str> {
        self.verdict.reason().map(standfast::stability::WhyUndecided::as_str)
    }

    /// The argument that decides, or why the verdict is undecided, in words.
    #[getter]
    fn in_words(&self) -> &str {
        self.verdict.in_words()
    }

    /// The data of the argument. For "not-equilibrium" {"equilibrium_margin"}; for "theorem-3", "theorem-3-loose" and "goyal"
    /// {"kinematic_margin", "coupling_margin"}, with the bound of the argument on ψ. For "corner-map" {"limits", "potential", "ends"}:
    /// limits between cells of the ratio ξ/y, a potential for each contact that lands and each cell, and the ratios below and
    /// above which V holds from entry to exit, not from corner to corner (see the theory page). For "growing-cycle" its corners
    /// (contact, phi, growth); the sum of their growths is a lower bound that is proved. For "growing-trap" its ranges (contact, slope, weight,
    /// growth): the limits of ξ/y, W ≤ growth + W(next), and a proved lower bound of ln r'/r. For "single-support" a motion {"word", "velocity"}: a turn
    /// about the contact. For "accelerating-mode" how the body moves away: a word at rest, a corner, or a motion {"word",
    /// "velocity"} that starts at q = 0 with this velocity. For "no-solution" {"contacts", "slides", "stiffness", "q", "qdot", "jams"}: a start in the
    /// local model at which these contacts slide ("R", "L"), no word is consistent and no impact is due; the same holds with qdot times f and q
    /// times f², 0 < f < 1; and all contacts that jam, as in `jams`. For "well" {"width", "rays"}: w as in `radius`, and the directions (x, y, θ), of length 1 in √(x² + y² + ρ²θ²), in
    /// which exactly two contacts stay closed. For "descending-pair" {"rays", "pairs"}, with the verdict on the pair of each ray that does not
    /// ascend; on one line of ground no rays, and the verdict on the outer contacts. For "neutral" {"outer", "stiffness"}: the outer contacts, and N M⁻¹ (N − σμT)ᵀ of each while it slides to the right and to the
    /// left, per unit mass. For "bounded-corners" {"growth"}: an upper bound, below 1, of the mean growth of the landing speed over a cycle of
    /// landings. For "potential-well" {"largest", "level"}: the largest normal force of each contact, in N, with which the contacts hold the load without
    /// friction: a gap is at most the energy of the kick over this force, for ever; and the number of independent slides on a level, which friction
    /// ends. For an undecided posture {"reason", "cells", "left"}: the reason, the
    /// number of cells of the corner map, and the undecided cells (None if several words are consistent at rest, or no map was
    /// computed).
    #[getter]
    fn evidence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = self.verdict.evidence_json();
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Whether the body stays near the posture because every motion raises its centre of mass: it stands in a well. It may still jam, see `by`.
    #[getter]
    fn stays(&self) -> bool {
        self.verdict.well.is_some()
    }

    /// Bound of max(|x|, |y|, ρ|θ|), in m, for all motions with at most this energy E = ½m(ẋ² + ẏ² + ρ²θ̇²)
    /// + m g y, in J, in the local model: E/(m g w), w the least y/max(|x|, |y|, ρ|θ|) over all
    /// displacements that the contacts allow. None unless the body `stays`.
    ///
    /// Parameters
    /// ----------
    /// energy : float, J, ≥ 0
    ///     E.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Unless energy >= 0.
    fn radius(&self, #[pyo3(from_py_with = input::energy)] energy: f64) -> PyResult<Option<f64>> {
        self.verdict.well.map(|well| well.radius(energy)).transpose().map_err(|e| to_py(&e))
    }

    /// The pairs of contacts that can hold the body alone, for a body on three and more contacts, each with its own verdict: a Verdict for
    /// each pair that can stay closed while all other contacts open. Empty for other bodies.
    #[getter]
    fn pairs(&self) -> PyResult<Vec<Self>> {
        let options = StabilityOptions { jams: self.verdict.after_jam, width: self.verdict.width };
        let found = match &self.on {
            Standing::Body(posture) => holding_pairs(&posture.0, &options),
            Standing::Mechanism(mechanism) => mechanism_pairs(&mechanism.0, &options),
        };
        let found = found.map_err(|e| to_py(&e))?;
        Ok(found.into_iter().map(|verdict| Self { on: self.on.clone(), verdict }).collect())
    }

    /// The number of independent motions that no contact feels, of a mechanism with more than three coordinates that are not locked: after a kick
    /// they go on for ever, whatever the contacts do. A verdict on such a mechanism is about its contacts only. 0 for a body.
    #[getter]
    fn free_motion(&self) -> usize {
        self.verdict.free_motion
    }

    /// The laws of impact for which the verdict is proved, by their names in `simulate`.
    #[getter]
    fn laws(&self) -> Vec<String> {
        self.verdict.laws.iter().map(word).collect()
    }

    /// Whether the verdict is undecided only because of its width: with the numbers exactly as given it is decided.
    #[getter]
    fn delicate(&self) -> bool {
        self.verdict.delicate
    }

    /// Bound on the ratio of the motion after a kick to the kick. A kick is a velocity given to the body at rest in its posture. In
    /// the local model ‖q̇‖ = √(ẋ² + ẏ² + ρ²θ̇²) of any later motion is at most this times that of the kick. The bound is proved, is
    /// at least 1, and is not the least bound. None if there is no bound: see amplification_reason.
    #[getter]
    fn amplification(&self) -> Option<f64> {
        self.verdict.amplification.ok()
    }

    /// A speed, in m/s: after every kick (a velocity at rest in the posture) with √(ẋ² + ẏ² + ρ²θ̇²) below it the body comes back to rest in the
    /// full model, with the laws of impact in `laws`. All contacts then touch, or hover at less than a tenth of the size of the body. It is proved, and a
    /// lower bound: some faster kicks may come back, too. None unless the body stands in a well (`stays`) or on level ground, on straight lines, with friction at all
    /// contacts, all of them below the centre of mass, and no contact jams nearby: see the theory page.
    #[getter]
    fn safe_speed(&self) -> Option<f64> {
        self.verdict.safe_speed
    }

    /// Why amplification is None: "not-stable" (the verdict is not "stable"), "energy" (energy does not bound the frictionless
    /// motion), "falls" (gravity does not pull onto the terrain of a contact), "modes" (the motion after a slide or a landing is not
    /// certain), "cells" (the corner map does not bound the growth), "rounding" (above 1e300), "pairs" (the bound of a pair
    /// of contacts does not hold for the whole body), "joints" (contacts that slide independently: only their rest is proved); None if there is a bound.
    #[getter]
    fn amplification_reason(&self) -> Option<&str> {
        self.verdict.amplification.err().map(standfast::stability::NoBound::as_str)
    }

    /// Results of the random kicks (keyword trials): {"seed", "kicks", "rest", "others"}, or None. They are evidence, not proof.
    #[getter]
    fn trials<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(trials) = &self.verdict.trials else { return Ok(None) };
        let (found, others) = (PyDict::new(py), PyDict::new(py));
        for (outcome, count) in &trials.others {
            others.set_item(outcome.as_str(), count)?;
        }
        found.set_item("seed", trials.seed)?;
        found.set_item("kicks", trials.kicks)?;
        found.set_item("rest", trials.rest)?;
        found.set_item("others", others)?;
        Ok(Some(found))
    }

    /// The contact modes at rest, with motion, forces and margins: Modes. Words have a letter for each of `contacts`.
    #[getter]
    fn modes(&self) -> PyResult<PyModes> {
        let posture = match &self.on {
            Standing::Body(posture) => posture,
            Standing::Mechanism(mechanism) => {
                return PyModes::solved(PyProblem::of_mechanism(MechanismProblem::at_rest(
                    &mechanism.0,
                )));
            }
        };
        let places = self.verdict.contacts.iter().map(|contact| contact.index());
        let posture = standfast::stability::with_contacts(&posture.0, &places.collect::<Vec<_>>());
        let posture = posture.map_err(|e| to_py(&e))?;
        let problem = ContactProblem::of_posture(&posture, &State::at_rest([0.0; 3]), [0.0; 3]);
        PyModes::solved(PyProblem::of_body(problem.map_err(|e| to_py(&e))?))
    }

    /// The posture; None for a mechanism.
    #[getter]
    fn posture(&self) -> Option<PyPosture> {
        match &self.on {
            Standing::Body(posture) => Some(posture.clone()),
            Standing::Mechanism(_) => None,
        }
    }

    /// The mechanism; None for a posture.
    #[getter]
    fn mechanism(&self) -> Option<PyMechanism> {
        match &self.on {
            Standing::Body(_) => None,
            Standing::Mechanism(mechanism) => Some(mechanism.clone()),
        }
    }

    /// The verdict, its evidence and the modes at rest as plain dictionaries, lists and numbers.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.verdict.to_json(),))
    }

    /// Writes the verdict, its evidence and the modes at rest as JSON.
    ///
    /// Parameters
    /// ----------
    /// path : path_like
    ///     The file.
    fn to_json(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        write_whole(py, path, self.verdict.to_json().into_bytes())
    }

    /// A certificate of the verdict, ready for JSON: the scene as exact doubles, the claim, and what a
    /// checker needs. `sf.certificate.check` proves the claim again from the scene, in Python with the
    /// standard library alone. The page on certificates of the documentation has its form.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     If the verdict is undecided, or if there is no certificate of its argument.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
    /// >>> certificate = sf.stability(rod).certificate()
    /// >>> certificate["claim"]
    /// {'frictional_stability': 'stable', 'by': 'theorem-3', 'contacts': [1, 2], 'jams': 'none'}
    /// >>> sf.certificate.check(certificate)
    fn certificate<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.certificate_maker")?.call_method1("make", (slf,))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Standing,))> {
        let mut again = py.import("standfast")?.getattr("stability")?;
        let keywords = PyDict::new(py);
        if self.verdict.after_jam != Jams::None {
            keywords.set_item("jams", self.after_jam())?;
        }
        if self.verdict.width != DEFAULT_WIDTH {
            keywords.set_item("width", self.verdict.width)?;
        }
        if let Some(trials) = &self.verdict.trials {
            keywords.set_item("trials", trials.kicks)?;
            keywords.set_item("seed", trials.seed)?;
        }
        if !keywords.is_empty() {
            again = py.import("functools")?.getattr("partial")?.call((again,), Some(&keywords))?;
        }
        Ok((again, (self.on.clone(),)))
    }

    /// Whether posture and kicks are the same: they determine the rest.
    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| {
            let other = other.get();
            self.on == other.on
                && self.verdict.after_jam == other.verdict.after_jam
                && self.verdict.width == other.verdict.width
                && self.verdict.trials == other.verdict.trials
        })
    }

    fn __repr__(&self) -> String {
        format!("<Verdict: {}>", self.verdict)
    }

    fn __str__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.table")?.call_method1("verdict_table", (slf,))
    }

    /// The HTML that a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.notebook")?.call_method1("of_verdict", (slf,))
    }
}

/// Whether a posture is stable: after every small kick the body returns to rest near it.
///
/// The verdict is for small motions, to first order, with frictionless impacts (the paper's local
/// model). Contacts in the air have no effect on small motions: a box on its side touches with two.
///
/// With three coordinates that are not locked a mechanism has the tests of a rigid body. With more
/// (joints with torques) it is "unstable" by "not-equilibrium", "accelerating-mode" or "no-solution",
/// "stable" by "bounded-corners" or "potential-well", or "undecided". Several bodies are one mechanism,
/// with the coordinates of all.
///
/// Parameters
/// ----------
/// jams : {"none", "impact"}
///     What happens where a contact slides and no contact mode is consistent (Painlevé): "none" (no
///     motion exists, and the verdict is "unstable" by "no-solution") or "impact" (the plastic
///     impact of `simulate(..., jams="impact")` follows).
/// width : float, from 0 to 0.1, default 1e-12
///     The verdict holds for all scenes whose numbers differ from those given by at most this
///     share: both coordinates of the arm from the centre of mass to a contact by this share of its
///     length; slope, restitution, friction and radius of gyration by this share of themselves;
///     1e-3, say, for a body that was measured. Slopes that are multiples of a right angle are
///     exact.
/// trials : int, default 0
///     Number of random small kicks to simulate as well.
/// seed : int, default 0
///     Seed of their random numbers. verdict.trials has their results, which are evidence and never
///     change the verdict.
/// posture : Posture, Mechanism or System, or a sequence or object array of them
///     Of a sequence the result is a list of Verdicts in the same order, computed on all cores, each the
///     same to the last bit as by itself; of an array of objects it is an array of its shape. None in it
///     has the answer None: a foothold out of reach, say.
/// threads : int or None, default None
///     Number of threads for a sequence; None uses every core.
/// progress : bool or None, default None
///     Whether a progress bar is shown for a sequence; None shows it on a terminal after a second
///     if tqdm is installed.
///
/// Returns
/// -------
/// Verdict, or a list or an array of them
///
/// Raises
/// ------
/// ValueError
///     Names `contacts` if no contact touches its ground, or if one touches it at an end of its
///     piece; for a sequence with the first item that has an error, as `posture[17]`, from 0.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, friction=0.5)
/// >>> sf.stability(rod).by
/// 'theorem-3'
/// >>> sf.stability([rod, None, sf.Posture.box(1, 1, friction=0.5)])
/// [<Verdict: stable by theorem-3>, None, <Verdict: stable by theorem-3-loose>]
/// >>> sf.stability(rod, trials=100).trials
/// {'seed': 0, 'kicks': 100, 'rest': 100, 'others': {}}
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the keywords of the function in Python")]
#[pyo3(signature = (posture, *, jams=None, width=DEFAULT_WIDTH, trials=0, seed=0, threads=None, progress=None, **unknown), text_signature = "(posture, *, jams=\"none\", width=1e-12, trials=0, seed=0, threads=None, progress=None)")]
pub(crate) fn stability<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = standings)] posture: Asked<Standing>,
    jams: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = input::width)] width: f64,
    #[pyo3(from_py_with = input::trials)] trials: usize,
    #[pyo3(from_py_with = input::seed)] seed: usize,
    #[pyo3(from_py_with = input::threads)] threads: Option<usize>,
    #[pyo3(from_py_with = lists::progress)] progress: Option<bool>,
    unknown: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    input::no_keywords("stability", unknown)?;
    let jams = jams.map_or(Ok(Jams::None), crate::options::jams)?;
    let (options, seed) = (StabilityOptions { jams, width }, seed as u64);
    let without_kicks = |on: &Standing| match on {
        Standing::Body(posture) => standfast::stability::stability_with(&posture.0, &options),
        Standing::Mechanism(of) => mechanism_stability(&of.0, &options),
    };
    let with_kicks = |on: &Standing, cancel: &dyn Fn() -> bool| {
        let mut verdict = without_kicks(on)?;
        if trials > 0 {
            let found = match on {
                Standing::Body(posture) => {
                    standfast::stability::trials(&posture.0, trials, seed, jams, cancel)
                }
                Standing::Mechanism(of) => {
                    standfast::stability::mechanism_trials(&of.0, trials, seed, jams, cancel)
                }
            };
            verdict.trials = Some(found?);
        }
        Ok(verdict)
    };
    match posture {
        Asked::One(on) => {
            let verdict = match trials {
                0 => without_kicks(&on).map_err(|e| to_py(&e))?,
                _ => interruptible(py, |cancel| with_kicks(&on, cancel))?,
            };
            Ok(PyVerdict { on, verdict }.into_pyobject(py)?.into_any())
        }
        Asked::Many(list) => {
            let found = list.answers(py, Threads { count: threads, progress }, &with_kicks)?;
            list.objects(py, found, |on, verdict| PyVerdict { on, verdict })
        }
    }
}

/// Least and largest (tangential, normal) force of each contact.
type Extremes<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// The forces that can hold a body, or a mechanism, at rest in its posture.
///
/// Parameters
/// ----------
/// posture : Posture or Mechanism or System
///
/// Returns
/// -------
/// (ndarray, ndarray) or None, N
///     The least and the largest (tangential, normal) force of each contact over all forces that
///     friction allows, (n, 2) each; ±inf where contacts can squeeze the body without bound.
///     None if no forces hold the body. Any number of contacts. For a contact at a vertex
///     of the terrain the force is the sum over both pieces, along and across the piece with the
///     slope of the contact.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1, gravity=10, friction=0.5)
/// >>> low, high = sf.static_forces(rod)
/// >>> low.tolist(), high.tolist()                  # 5 N on each end, and up to half of it along the ground
/// ([[-2.5, 5.0], [-2.5, 5.0]], [[2.5, 5.0], [2.5, 5.0]])
#[pyfunction]
pub(crate) fn static_forces<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = standing)] posture: Standing,
) -> PyResult<Option<Extremes<'py>>> {
    let found = match &posture {
        Standing::Body(posture) => standfast::stability::static_forces(&posture.0),
        Standing::Mechanism(mechanism) => mechanism_forces(&mechanism.0),
    };
    let Some(StaticForces { low, high }) = found else { return Ok(None) };
    let array = |rows: Vec<[f64; 2]>| {
        let rows: Vec<Vec<f64>> = rows.into_iter().map(Into::into).collect();
        PyArray2::from_vec2(py, &rows).map_err(|e| PyValueError::new_err(e.to_string()))
    };
    Ok(Some((array(low)?, array(high)?)))
}

/// The friction that a body at rest has to spare: 1 − κ, where κ is the least factor on all
/// coefficients of friction with which the contacts still hold the body. 1: the body stands without
/// friction. Negative: there is too little friction. −inf: no factor is sufficient. Any number of
/// contacts. Forces may be outside of their cones by 1e-12 of the load, so the margin has an error of
/// this order.
///
/// A sequence, or an array of objects, has an array of margins; nan for None.
///
/// Parameters
/// ----------
/// posture : Posture, Mechanism or System, or a sequence or object array of them
///     A mechanism has its load with all factors: that of a robot under torques is the friction that
///     these torques leave.
/// threads : int or None, default None
///     As for `stability`.
/// progress : bool or None, default None
///     As for `stability`.
///
/// Examples
/// --------
/// >>> import math
/// >>> import standfast as sf
/// >>> foot = sf.Contact(point=(0, 0), slope=math.atan(0.2), friction=0.5)
/// >>> point = sf.Posture(mass=1, gyration_radius=1, center_of_mass=(0, 0), contacts=[foot], restitution=0)
/// >>> round(sf.friction_margin(point), 12)           # on a slope of 0.2, with friction 0.5
/// 0.6
#[pyfunction]
#[pyo3(signature = (posture, *, threads=None, progress=None))]
pub(crate) fn friction_margin<'py>(
    py: Python<'py>,
    #[pyo3(from_py_with = standings)] posture: Asked<Standing>,
    #[pyo3(from_py_with = input::threads)] threads: Option<usize>,
    #[pyo3(from_py_with = lists::progress)] progress: Option<bool>,
) -> PyResult<Bound<'py, PyAny>> {
    let margin = |on: &Standing| match on {
        Standing::Body(posture) => standfast::stability::friction_margin(&posture.0),
        Standing::Mechanism(mechanism) => mechanism_friction_margin(&mechanism.0),
    };
    match posture {
        Asked::One(on) => Ok(margin(&on).into_pyobject(py)?.into_any()),
        Asked::Many(list) => {
            let threads = Threads { count: threads, progress };
            let found = list.answers(py, threads, &|on, _| Ok(margin(on)))?;
            list.numbers(py, found)
        }
    }
}

/// Interval (low, high) of abscissas of the centre of mass, m, at which friction and normal forces at
/// the contacts can hold the body against gravity; ±inf where there is no bound, None if the interval
/// is empty. Any number of contacts.
///
/// Parameters
/// ----------
/// posture : Posture or Mechanism
///     A Mechanism with all joints locked; its abscissas are those from the point of which (x, y) are
///     the coordinates.
///
/// Raises
/// ------
/// ValueError
///     For other mechanisms.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.equilibrium_region(sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1))
/// (-0.5, 0.5)
#[pyfunction]
pub(crate) fn equilibrium_region(
    #[pyo3(from_py_with = body)] posture: PyPosture,
) -> Option<(f64, f64)> {
    standfast::stability::equilibrium_region(&posture.0).map(Into::into)
}
