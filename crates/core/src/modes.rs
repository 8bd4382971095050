//! Contact modes: what every contact may do next, by Coulomb's law [Or & Rimon 2008, Table I].
//!
//! A body in contact goes on in a *mode*, a word with a letter per contact. More than one word may be consistent
//! with the law, or none (Painlevé): both are answers.

mod answer;
mod enumerate;
mod hyperstatic;
mod pair;
mod problem;
mod simplex;
mod words;

pub use answer::{Condition, Forces, Margin, ModeAnswer, TIE};
pub use pair::{PairMode, PairModes};
pub use problem::{ContactProblem, Level, ProblemFields};
pub use words::{Mode, Word};

use serde::{Deserialize, Serialize};

use crate::error::Error;

/// How contact modes are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// The cheapest that answers in full.
    #[default]
    Auto,
    /// Every word, one by one.
    Enumerate,
}

/// How many words are consistent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Exactly one.
    Unique,
    /// Several: the law does not say which.
    Ambiguous,
    /// None: no motion with bounded forces obeys the law.
    None,
}

impl Status {
    /// Its name in the Python face.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Unique => "unique",
            Self::Ambiguous => "ambiguous",
            Self::None => "none",
        }
    }
}

/// All modes a problem offers, solved.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes {
    answers: Vec<ModeAnswer>,
}

impl Modes {
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
        match self.consistent().count() {
            0 => Status::None,
            1 => Status::Unique,
            _ => Status::Ambiguous,
        }
    }

    /// The answer for one word, if it is offered.
    #[must_use]
    pub fn get(&self, word: Word) -> Option<&ModeAnswer> {
        self.answers.iter().find(|answer| answer.word == word)
    }
}

/// Every contact mode the problem offers, with its motion, forces and margins.
///
/// # Errors
///
/// None with these methods.
pub fn contact_modes(problem: &ContactProblem, method: Method) -> Result<Modes, Error> {
    let pair = if method == Method::Auto { problem.pair_modes() } else { None };
    let mut answers: Vec<_> = match pair {
        Some(pair) => pair.iter().map(|mode| mode.answer(problem)).collect(),
        None => enumerate::enumerate(problem),
    };
    answers.sort_by(|a, b| a.word.modes().cmp(b.word.modes()));
    Ok(Modes { answers })
}
