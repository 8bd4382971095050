//! Errors in the input. If the physics has no solution or several, this is an [`Outcome`](crate::Outcome) and not an error.

use std::f64::consts::PI;
use std::fmt::{self, Display};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::sync::Arc;

use serde::{Serialize, Serializer};

/// A wrong input, with the field, the value found there and what is allowed.
///
/// [`source`](std::error::Error::source) is the error that caused it, if there is one: a [`std::io::Error`] or another [`Error`]. Serde
/// writes errors but does not read them, because an error of the system cannot be restored from its text.
///
/// ```
/// use standfast::{Error, Lamina, Posture};
///
/// let error = Posture::rod(0.5, &Lamina { restitution: 1.5, ..Lamina::default() }).unwrap_err();
/// assert!(error.to_string().starts_with("restitution = 1.5"));
/// assert!(matches!(error, Error::OutOfRange { field, .. } if field == "restitution"));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Error {
    /// A number lies outside its range.
    OutOfRange {
        /// Path of the field, such as `contacts.1.friction` (contacts count from 1).
        field: String,
        /// The value found.
        #[serde(with = "crate::serial::numbers::extended")]
        value: f64,
        /// The range allowed, in words.
        allowed: &'static str,
    },
    /// A field cannot be used as it is given, for another reason than a range of numbers.
    Unusable {
        /// Path of the field.
        field: String,
        /// The value found, as text.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// The start lies in the terrain.
    Penetrating {
        /// Contact number, from 1.
        contact: usize,
        /// Its gap, in m.
        gap: f64,
        /// The largest penetration that counts as touching, in m.
        touch: f64,
    },
    /// A numerical solver failed.
    Solver(String),
    /// A point of a sweep, or one of many runs, has an error.
    At {
        /// The parameters of the point, such as `mass = 2.0`, or the number of the run, from 0.
        place: String,
        /// What is wrong there.
        error: Box<Error>,
    },
    /// A file cannot be read or written.
    Io {
        /// The file.
        path: String,
        /// The message of the system.
        cause: IoCause,
    },
    /// A file does not contain a scene.
    File {
        /// The file.
        path: String,
        /// What is wrong, with line and column where there is one.
        problem: String,
        /// The value that is wrong, if the text could be read.
        error: Option<Box<Error>>,
    },
    /// The computation was stopped: its `cancel` has returned true.
    Cancelled,
}

impl Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { field, value, allowed } => {
                write!(f, "{field} = {value:?} is outside its range: {allowed}")
            }
            Self::Unusable { field, value, allowed } => {
                write!(f, "{} = {} cannot be used: {allowed}", shortened(field), shortened(value))
            }
            Self::Penetrating { contact, gap, touch } => write!(
                f,
                "q puts contact {contact} into the terrain: its gap {gap:?} m is below -{touch:?} m; allowed are gaps >= 0; touching({contact}, theta) of a posture has the q at which this contact touches"
            ),
            Self::Solver(problem) => write!(f, "the solver failed: {problem}"),
            Self::At { place, error } => write!(f, "{error} (at {place})"),
            Self::Io { path, cause } => write!(f, "{}: {cause}", quoted(Path::new(path))),
            Self::File { path, problem, .. } => write!(f, "{path}: {problem}"),
            Self::Cancelled => f.write_str("stopped"),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::At { error, .. } => Some(&**error),
            Self::Io { cause, .. } => Some(&*cause.0),
            Self::File { error, .. } => error.as_deref().map(|error| error as _),
            Self::OutOfRange { .. }
            | Self::Unusable { .. }
            | Self::Penetrating { .. }
            | Self::Solver(_)
            | Self::Cancelled => None,
        }
    }
}

/// The error of the system for a file that cannot be read or written: a [`std::io::Error`] that can be copied.
#[derive(Debug, Clone)]
pub struct IoCause(Arc<io::Error>);

impl IoCause {
    /// The kind of the error.
    #[must_use]
    pub fn kind(&self) -> ErrorKind {
        self.0.kind()
    }
}

/// The message of the system, without its number.
impl Display for IoCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let message = self.0.to_string();
        f.write_str(
            message.split_once(" (os error").map_or(message.as_str(), |(message, _)| message),
        )
    }
}

/// Two errors are equal if they have the same kind and message.
impl PartialEq for IoCause {
    fn eq(&self, other: &Self) -> bool {
        self.kind() == other.kind() && self.to_string() == other.to_string()
    }
}

impl Serialize for IoCause {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Error {
    /// The error for a file that cannot be read or written.
    pub(crate) fn io(path: &Path, error: io::Error) -> Self {
        Self::Io { path: path.display().to_string(), cause: IoCause(Arc::new(error)) }
    }

    /// This error, of one of many computations, with the place where it is.
    pub(crate) fn at(self, place: impl FnOnce() -> String) -> Self {
        match self {
            Self::Cancelled => self,
            error => Self::At { place: place(), error: error.into() },
        }
    }

    /// The same error with another name of its field, if it has a field.
    pub(crate) fn renamed(mut self, name: impl FnOnce(&str) -> String) -> Self {
        if let Self::OutOfRange { field, .. } | Self::Unusable { field, .. } = &mut self {
            *field = name(field);
        }
        self
    }
}

/// A path in a message.
pub(crate) fn quoted(path: &Path) -> String {
    if path.as_os_str().is_empty() { "\"\"".into() } else { path.display().to_string() }
}

/// Longest value that is quoted in full, in characters.
const QUOTED: usize = 60;

/// A value as it is quoted in a message: on one line, shortened if it is long.
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

/// The largest size of an angle for which the error asks whether degrees were meant.
const FULL_TURN: f64 = 360.0;

/// A direction, in rad.
pub(crate) fn angle(field: impl Display, value: f64, allowed: &'static str) -> Result<f64, Error> {
    if PI < value.abs() && value.abs() <= FULL_TURN {
        return Err(Error::Unusable {
            field: field.to_string(),
            value: format!("{value:?}"),
            allowed: format!(
                "{allowed}; did you mean math.radians({value}) = {:?}?",
                value.to_radians()
            ),
        });
    }
    in_range(field, value, -PI < value && value <= PI, allowed)
}

/// The coordinate of a joint or of the rotation of a chain, in rad: an angle that may exceed half a turn.
pub(crate) fn joint_angle(field: impl Display, value: f64) -> Result<f64, Error> {
    let allowed = "an angle in rad, from -2 pi to 2 pi";
    if 2.0 * PI < value.abs() && value.abs() <= FULL_TURN {
        return Err(Error::Unusable {
            field: field.to_string(),
            value: format!("{value:?}"),
            allowed: format!(
                "{allowed}; did you mean math.radians({value}) = {:?}?",
                value.to_radians()
            ),
        });
    }
    in_range(field, value, value.abs() <= 2.0 * PI, allowed)
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

/// Zero, or a number whose inverse is finite.
pub(crate) fn gravity(field: impl Display, value: f64) -> Result<f64, Error> {
    let holds = value == 0.0 || (1.0 / LARGEST..=LARGEST).contains(&value);
    in_range(field, value, holds, "finite and >= 0: 0, or from 1e-150 to 1e150")
}

/// As [`gravity`], of either sign: along the normal of a contact, gravity may point away from its ground.
pub(crate) fn effective_gravity(field: impl Display, value: f64) -> Result<f64, Error> {
    let holds = value == 0.0 || (1.0 / LARGEST..=LARGEST).contains(&value.abs());
    in_range(field, value, holds, "finite: 0, or from 1e-150 to 1e150 in size")
}

/// The largest coefficient of friction. In the sum of a normal row and μ times the tangential row, the normal row keeps four digits.
const ROUGHEST: f64 = 1e12;

pub(crate) fn friction(field: impl Display, value: f64) -> Result<f64, Error> {
    in_range(field, value, (0.0..=ROUGHEST).contains(&value), "finite and >= 0, at most 1e12")
}

/// The smallest coefficient of restitution above zero: the square of a speed after an impact does not underflow.
const DEADEST: f64 = 1e-60;

pub(crate) fn restitution(field: impl Display, value: f64) -> Result<f64, Error> {
    let holds = value == 0.0 || (DEADEST..=1.0).contains(&value);
    in_range(field, value, holds, "0 <= restitution <= 1: 0, or from 1e-60 on")
}

/// Largest speed of a surface, in m/s: as of the points of a body.
const FASTEST_SURFACE: f64 = 1e70;

pub(crate) fn surface_speed(field: impl Display, value: f64) -> Result<f64, Error> {
    in_range(field, value, value.abs() <= FASTEST_SURFACE, "from -1e70 to 1e70, in m/s")
}

/// Refuses contacts that return all of their speed. `values`: the restitution of each contact.
pub(crate) fn dissipative(
    values: impl IntoIterator<Item = f64>,
    allowed: &'static str,
) -> Result<(), Error> {
    for (i, value) in values.into_iter().enumerate() {
        in_range(format_args!("restitution of contact {}", i + 1), value, value < 1.0, allowed)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::error::Error as _;

    use super::*;

    /// The cause, which has to be of this type.
    fn cause<E: std::error::Error + 'static>(error: &Error) -> &E {
        error.source().and_then(|cause| cause.downcast_ref()).expect("a cause of this type")
    }

    #[test]
    fn the_source_of_an_error_is_its_cause() {
        let wrong = friction("friction", -1.0).unwrap_err();
        assert!(wrong.source().is_none());
        let at = Error::At { place: "run 3".into(), error: Box::new(wrong.clone()) };
        assert_eq!(cause::<Error>(&at), &wrong);
    }

    #[test]
    fn errors_are_written() {
        let json = |error: &Error| serde_json::to_string(error).unwrap();
        let wrong = finite("time", f64::INFINITY).unwrap_err();
        assert_eq!(
            json(&wrong),
            r#"{"out-of-range":{"field":"time","value":"inf","allowed":"finite, at most 1e150 in size"}}"#
        );
        let at =
            Error::At { place: "run 3".into(), error: Box::new(Error::Solver("stuck".into())) };
        assert_eq!(json(&at), r#"{"at":{"place":"run 3","error":{"solver":"stuck"}}}"#);
    }
}
