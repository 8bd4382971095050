//! Contact modes: the motions of a body in contact that Coulomb's law allows [Or & Rimon 2008, Table I].
//!
//! A *mode* of the body is a word with one letter for each contact. One word may be consistent with the law, or several, or none
//! (Painlevé). Each of these is a result.

mod answer;
mod enumerate;
mod flats;
mod hyperstatic;
mod judge;
mod mechanism;
mod painleve;
mod pair;
#[cfg(feature = "qp")]
mod pivoting;
mod problem;
#[cfg(feature = "qp")]
mod qp;
mod rows;
mod scaled;
#[cfg(feature = "qp")]
mod smallest;
mod squeeze;
mod words;

pub use crate::tolerance::TIE;
pub use answer::{Condition, Forces, Margin, ModeAnswer};
pub use mechanism::MechanismProblem;
pub(crate) use mechanism::{Onward, forces as mechanism_forces, onward};
pub use painleve::Jamming;
pub(crate) use pair::only_mode;
pub use pair::{PairMode, PairModes};
#[cfg(feature = "qp")]
pub(crate) use pivoting::{Pivoted, by_pivoting};
pub(crate) use problem::LONGEST_ARM;
pub use problem::{ContactProblem, Level, ProblemFields};
pub(crate) use rows::{Row, scale};

pub use words::{Mode, Word};

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::scaled::Problem;
use crate::serial::shown_as_str;

shown_as_str!(Status);

/// How contact modes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The cheapest method: closed forms for one and two contacts; enumeration for up to [`MAX_ENUMERATED`] closed contacts; for more
    /// contacts one consistent mode by convex programmes, and enumeration if they find none.
    #[default]
    Auto,
    /// Enumeration of all words.
    Enumerate,
    /// The first consistent word that a sequence of convex quadratic programmes finds; meant for many contacts. It may find none
    /// although there is one. Needs the cargo feature `qp` (on by default); without it [`contact_modes`] returns an error.
    Qp,
}

/// Number of closed contacts up to which enumeration costs no more than programmes (27 µs and 43 µs for 6 contacts, 68 µs and 44 µs for 7;
/// measured by the benchmark `modes/one_answer`).
pub const MAX_ENUMERATED: usize = 6;

/// The number of consistent words, as a status.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Status {
    /// Exactly one.
    Unique,
    /// Several, or one whose motion is not determined ([`Forces::Undetermined`]).
    Ambiguous,
    /// None: no motion with bounded forces satisfies the law.
    None,
    /// At least one; a search that stops at the first has found it.
    Found,
    /// The search has found none; there may be some.
    NotFound,
}

impl Status {
    /// Its name in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Unique => "unique",
            Self::Ambiguous => "ambiguous",
            Self::None => "none",
            Self::Found => "found",
            Self::NotFound => "not found",
        }
    }
}

/// The solved words of a problem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    answers: Vec<ModeAnswer>,
    /// Whether these are all words.
    complete: bool,
}

impl Modes {
    fn of(mut answers: Vec<ModeAnswer>, complete: bool) -> Self {
        for answer in &mut answers {
            for part in &mut answer.acceleration {
                *part = part.unsigned_zero();
            }
            for force in &mut answer.forces {
                *force = force.unsigned_zero();
            }
            answer.force_interval = answer.force_interval.unsigned_zero();
            for margin in &mut answer.margins {
                margin.value = margin.value.unsigned_zero();
            }
        }
        Self { answers, complete }
    }

    /// The words, in the order S, F, R, L of their letters.
    #[must_use]
    pub fn answers(&self) -> &[ModeAnswer] {
        &self.answers
    }

    /// The consistent ones.
    pub fn consistent(&self) -> impl Iterator<Item = &ModeAnswer> {
        self.answers.iter().filter(|answer| answer.consistent)
    }

    /// The status: how many words are consistent.
    #[must_use]
    pub fn status(&self) -> Status {
        let undetermined = |answer: &ModeAnswer| answer.determined == Forces::Undetermined;
        match (self.consistent().count(), self.complete) {
            (0, true) => Status::None,
            (1, true) if !self.consistent().any(undetermined) => Status::Unique,
            (_, true) => Status::Ambiguous,
            (0, false) => Status::NotFound,
            (_, false) => Status::Found,
        }
    }

    /// The modes as JSON: the status, the consistent words, and the words with their motion, forces and margins. Infinities are the
    /// strings "inf" and "-inf", undefined numbers null.
    #[must_use]
    pub fn to_json(&self) -> String {
        #[derive(Serialize)]
        struct Written<'a> {
            status: &'a str,
            consistent: Vec<Word>,
            modes: &'a [ModeAnswer],
        }
        let written = Written {
            status: self.status().as_str(),
            consistent: self.consistent().map(|mode| mode.word).collect(),
            modes: &self.answers,
        };
        serde_json::to_string_pretty(&written)
            .unwrap_or_else(|e| unreachable!("modes are JSON: {e}"))
    }

    /// The solution of one word, if the state of the contacts allows it.
    #[must_use]
    pub fn get(&self, word: Word) -> Option<&ModeAnswer> {
        self.answers.iter().find(|answer| answer.word == word)
    }
}

/// The forces (tangential, normal) of the contacts in this word, in N, whatever the tests of the word say: the smallest where the equations
/// allow several. `None`: no forces cause the motion of the word.
pub(crate) fn forces(problem: &ContactProblem, word: Word) -> Option<Vec<[f64; 2]>> {
    let answer = enumerate::solve(problem, word);
    (answer.determined != Forces::Impossible).then_some(answer.forces)
}

/// A problem of contact modes: a [`ContactProblem`] or a [`MechanismProblem`].
pub trait ModeProblem: sealed::Solved {}

impl ModeProblem for ContactProblem {}
impl ModeProblem for MechanismProblem {}

mod sealed {
    use super::{Error, Method, Modes};

    pub trait Solved {
        fn modes(&self, method: Method) -> Result<Modes, Error>;
    }
}

impl sealed::Solved for ContactProblem {
    fn modes(&self, method: Method) -> Result<Modes, Error> {
        solved(self, method, pair::answers)
    }
}

/// Every contact mode that the state of the contacts allows, with its motion, forces and margins. By programmes ([`Method::Qp`], and
/// [`Method::Auto`] above [`MAX_ENUMERATED`] contacts) only one consistent mode.
///
/// ```
/// use standfast::modes::{ContactProblem, Method, Status, contact_modes};
/// use standfast::{Lamina, Posture, State};
///
/// // A rod at rest: both ends are fixed, and each carries half of the weight of 10 N.
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, gravity: 10.0, ..Lamina::default() })?;
/// let problem = ContactProblem::of_posture(&rod, &State::at_rest([0.0; 3]), [0.0; 3])?;
/// let modes = contact_modes(&problem, Method::Auto)?;
/// assert_eq!(modes.status(), Status::Unique);
/// let mode = modes.consistent().next().expect("one mode");
/// assert_eq!(mode.word.to_string(), "FF");
/// assert!(mode.forces.iter().all(|[_, normal]| (normal - 5.0).abs() < 1e-14));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Solver`] if Clarabel refuses a programme; [`Error::Unusable`] for [`Method::Qp`] in a build without the cargo
/// feature `qp`, and for [`Method::Enumerate`] if a mechanism may have more than 65 536 words.
pub fn contact_modes<P: ModeProblem + ?Sized>(problem: &P, method: Method) -> Result<Modes, Error> {
    problem.modes(method)
}

/// The modes of a problem. `closed_form`: its words, if they have closed forms.
fn solved<P: Problem>(
    problem: &P,
    method: Method,
    closed_form: impl FnOnce(&P) -> Option<Vec<ModeAnswer>>,
) -> Result<Modes, Error> {
    let refused = |allowed: &str| {
        let value = if method == Method::Qp { "qp" } else { "enumerate" };
        Error::Unusable { field: "method".into(), value: value.into(), allowed: allowed.into() }
    };
    #[cfg(not(feature = "qp"))]
    if method == Method::Qp {
        return Err(refused(
            "auto or enumerate, because this build is without the cargo feature `qp`",
        ));
    }
    #[cfg(feature = "qp")]
    {
        let closed = problem.rows().iter().filter(|row| row.sliding.is_some()).count();
        if method == Method::Qp || method == Method::Auto && closed > MAX_ENUMERATED {
            let answers: Vec<_> = qp::search(problem)?.into_iter().collect();
            if method == Method::Qp || !answers.is_empty() {
                return Ok(Modes::of(answers, false));
            }
        }
    }
    let pair = if method == Method::Auto { closed_form(problem) } else { None };
    let Some(mut answers) = pair.or_else(|| enumerate::enumerate(problem)) else {
        return if method == Method::Auto {
            Ok(Modes::of(Vec::new(), false))
        } else {
            Err(refused("qp or auto, because the contacts may have more than 65536 words"))
        };
    };
    if !answers.iter().any(|answer| answer.consistent) {
        // The static word of a tie fails by more than a tie: the other word is taken.
        for answer in &mut answers {
            answer.consistent = answer.holds_but_for_ties();
        }
    }
    answers.sort_by_key(|answer| answer.word);
    Ok(Modes::of(answers, true))
}
