//! What the caller got wrong. What physics answers, however unwelcome, is an [`Outcome`](crate::Outcome).

use std::fmt::Display;
use std::io::ErrorKind;
use std::path::Path;

use thiserror::Error;

/// A wrong input, with the field, the value found there and what is allowed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A number lies outside its range.
    #[error("{field} = {value:?} is outside its range: {allowed}")]
    OutOfRange {
        /// Path of the field, such as `contacts.1.friction` (contacts count from 1).
        field: String,
        /// The value found.
        value: f64,
        /// The range allowed, in words.
        allowed: &'static str,
    },
    /// A field cannot be used as it is given, for a reason that is not a range of numbers.
    #[error("{} = {} cannot be used: {allowed}", shortened(field), shortened(value))]
    Unusable {
        /// Path of the field.
        field: String,
        /// The value found, as text.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// The start lies in the terrain.
    #[error(
        "q puts contact {contact} into the terrain: its gap {gap:?} m is below -{touch:?} m; allowed are gaps >= 0"
    )]
    Penetrating {
        /// Contact number, from 1.
        contact: usize,
        /// Its gap, in m.
        gap: f64,
        /// The largest penetration that is taken for touching, in m.
        touch: f64,
    },
    /// A numerical solver failed.
    #[error("the solver failed: {0}")]
    Solver(String),
    /// A point of a sweep has no answer.
    #[error("{error} (at {place})")]
    At {
        /// The parameters of the point, such as `mass = 2.0`.
        place: String,
        /// What is wrong there.
        error: Box<Error>,
    },
    /// A file cannot be read or written.
    #[error("{}: {problem}", quoted(Path::new(path)))]
    Io {
        /// The file.
        path: String,
        /// What kind of obstacle there is.
        kind: ErrorKind,
        /// What the system says.
        problem: String,
    },
    /// A file holds no scene.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: String,
        /// What is wrong, with line and column where there is one.
        problem: String,
    },
}

impl Error {
    /// What keeps a file from being read or written.
    pub(crate) fn io(path: &Path, error: &std::io::Error) -> Self {
        let said = error.to_string();
        let problem = said.split_once(" (os error").map_or(said.as_str(), |(said, _)| said);
        Self::Io { path: path.display().to_string(), kind: error.kind(), problem: problem.into() }
    }

    /// The same with another name of its field, if it has one.
    pub(crate) fn renamed(mut self, name: impl FnOnce(&str) -> String) -> Self {
        if let Self::OutOfRange { field, .. } | Self::Unusable { field, .. } = &mut self {
            *field = name(field);
        }
        self
    }
}

/// A path as messages name it.
pub(crate) fn quoted(path: &Path) -> String {
    if path.as_os_str().is_empty() { "\"\"".into() } else { path.display().to_string() }
}

/// Longest value that is quoted in full, in characters.
const QUOTED: usize = 60;

/// A value as it is quoted in a message: on one line, and no longer than needed to recognise it.
pub(crate) fn shortened(value: &str) -> String {
    let text: String = value.split_whitespace().collect::<Vec<_>>().join(" ");
    let printable = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    if text.chars().count() <= QUOTED {
        text.chars().map(printable).collect()
    } else {
        text.chars().take(QUOTED).map(printable).chain(['\u{2026}']).collect()
    }
}

/// `value` if it lies in the range that `holds` describes. `field` is written out only if it does not.
pub(crate) fn in_range(
    field: impl Display,
    value: f64,
    holds: bool,
    allowed: &'static str,
) -> Result<f64, Error> {
    if holds {
        Ok(value)
    } else {
        Err(Error::OutOfRange { field: field.to_string(), value, allowed })
    }
}

/// The largest size of a length, a speed or any other number given: its square does not overflow, and the
/// square of its inverse does not vanish.
pub(crate) const LARGEST: f64 = 1e150;

pub(crate) fn finite(field: impl Display, value: f64) -> Result<f64, Error> {
    in_range(field, value, value.abs() <= LARGEST, "finite, at most 1e150 in size")
}

pub(crate) fn positive(field: impl Display, value: f64) -> Result<f64, Error> {
    let holds = (1.0 / LARGEST..=LARGEST).contains(&value);
    in_range(field, value, holds, "finite and > 0, from 1e-150 to 1e150")
}

pub(crate) fn non_negative(field: impl Display, value: f64) -> Result<f64, Error> {
    in_range(field, value, (0.0..=LARGEST).contains(&value), "finite and >= 0, at most 1e150")
}

/// None, or one whose inverse is a number, too.
pub(crate) fn gravity(field: impl Display, value: f64) -> Result<f64, Error> {
    let holds = value == 0.0 || (1.0 / LARGEST..=LARGEST).contains(&value);
    in_range(field, value, holds, "finite and >= 0: 0, or from 1e-150 to 1e150")
}

/// The largest coefficient of friction: of a normal row beside μ times its tangential one four digits are left.
const ROUGHEST: f64 = 1e12;

pub(crate) fn friction(field: impl Display, value: f64) -> Result<f64, Error> {
    in_range(field, value, (0.0..=ROUGHEST).contains(&value), "finite and >= 0, at most 1e12")
}

/// The smallest coefficient of restitution but none: of a speed it leaves one whose square is a number.
const DEADEST: f64 = 1e-60;

pub(crate) fn restitution(field: impl Display, value: f64) -> Result<f64, Error> {
    let holds = value == 0.0 || (DEADEST..1.0).contains(&value);
    in_range(field, value, holds, "0 <= restitution < 1: 0, or from 1e-60 on")
}
