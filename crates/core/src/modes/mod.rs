//! Contact modes: what every contact may do next, by Coulomb's law [Or & Rimon 2008, Table I].
//!
//! A body in contact goes on in a *mode*, a word with a letter per contact. More than one word may be consistent
//! with the law, or none (Painlevé): both are answers.

mod answer;
mod enumerate;
mod flats;
mod hyperstatic;
mod judge;
mod painleve;
mod pair;
mod problem;
#[cfg(feature = "qp")]
mod qp;
#[cfg(feature = "qp")]
mod smallest;
mod words;

pub use crate::tolerance::TIE;
pub use answer::{Condition, Forces, Margin, ModeAnswer};
pub use painleve::Jamming;
pub(crate) use pair::only_mode;
pub use pair::{PairMode, PairModes};
pub use problem::{ContactProblem, Level, ProblemFields};
pub(crate) use problem::{LONGEST_ARM, Row, scale};

pub use words::{Mode, Word};

use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::math::unsigned_zero::UnsignedZero;

/// How contact modes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The cheapest: closed forms for one and two contacts, enumeration for up to [`MAX_ENUMERATED`] closed ones, for more a
    /// consistent mode by programmes, and enumeration should they find none.
    #[default]
    Auto,
    /// Every word, one by one.
    Enumerate,
    /// The first consistent word that a sequence of convex quadratic programmes leads to: for many contacts. It may
    /// find none where there is one. Needs the cargo feature `qp` (on by default); without it [`contact_modes`] returns an error.
    Qp,
}

/// Closed contacts up to which enumeration costs no more than programmes (`cargo bench -p standfast-benches --bench
/// modes`: 31 µs and 41 µs for 6 contacts, 60 µs and 46 µs for 7).
pub const MAX_ENUMERATED: usize = 6;

/// How many words are consistent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Exactly one.
    Unique,
    /// Several, or one that leaves the motion open ([`Forces::Undetermined`]): the law does not say which.
    Ambiguous,
    /// None: no motion with bounded forces obeys the law.
    None,
    /// At least one: it was searched for, and found.
    Found,
    /// The search ended without one; there may be some.
    NotFound,
}

impl Status {
    /// Its name in the Python face.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unique => "unique",
            Self::Ambiguous => "ambiguous",
            Self::None => "none",
            Self::Found => "found",
            Self::NotFound => "not found",
        }
    }
}

/// All modes a problem offers, solved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    answers: Vec<ModeAnswer>,
    /// Whether these are all there are.
    complete: bool,
}

impl Modes {
    fn of(mut answers: Vec<ModeAnswer>, complete: bool) -> Self {
        for answer in &mut answers {
            answer.acceleration = answer.acceleration.unsigned_zero();
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

    /// Every word offered, in the order S, F, R, L of its letters.
    #[must_use]
    pub fn answers(&self) -> &[ModeAnswer] {
        &self.answers
    }

    /// The consistent ones.
    pub fn consistent(&self) -> impl Iterator<Item = &ModeAnswer> {
        self.answers.iter().filter(|answer| answer.consistent)
    }

    /// How many are consistent.
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

    /// The answer for one word, if it is offered.
    #[must_use]
    pub fn get(&self, word: Word) -> Option<&ModeAnswer> {
        self.answers.iter().find(|answer| answer.word == word)
    }
}

/// Every contact mode the problem offers, with its motion, forces and margins; by programmes ([`Method::Qp`], and
/// [`Method::Auto`] beyond [`MAX_ENUMERATED`] contacts) one consistent mode.
///
/// # Errors
///
/// [`Error::Solver`] if Clarabel refuses a programme; [`Error::Unusable`] for [`Method::Qp`] in a build without the cargo
/// feature `qp`.
pub fn contact_modes(problem: &ContactProblem, method: Method) -> Result<Modes, Error> {
    #[cfg(not(feature = "qp"))]
    if method == Method::Qp {
        return Err(Error::Unusable {
            field: "method".into(),
            value: "qp".into(),
            allowed: "auto or enumerate, because this build is without the cargo feature `qp`"
                .into(),
        });
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
    let pair = if method == Method::Auto { problem.pair_modes() } else { None };
    let mut answers: Vec<_> = match pair {
        Some(pair) => pair.iter().map(|mode| mode.answer(problem)).collect(),
        None => enumerate::enumerate(problem),
    };
    if !answers.iter().any(|answer| answer.consistent) {
        // The static word of a tie fails by more than a tie: the other one is the answer.
        for answer in &mut answers {
            answer.consistent = answer.holds_but_for_ties();
        }
    }
    answers.sort_by_key(|answer| answer.word);
    Ok(Modes::of(answers, true))
}
