//! Errors of the core as Python exceptions.

use std::io::ErrorKind;

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyOSError, PyValueError};
use pyo3::prelude::*;
use standfast::Error;

create_exception!(standfast, SolverError, PyException, "A solver failed to find an answer.");

pub(crate) fn to_py(error: &Error) -> PyErr {
    match error {
        Error::Solver(_) => SolverError::new_err(error.to_string()),
        Error::At { error: inner, .. } if matches!(**inner, Error::Solver(_)) => {
            SolverError::new_err(error.to_string())
        }
        // Python chooses the subclass, such as FileNotFoundError, by this number.
        Error::Io { path, cause } => {
            PyOSError::new_err((number(cause.kind()), cause.to_string(), path.clone()))
        }
        _ => PyValueError::new_err(in_words(error)),
    }
}

/// The message, which names a value of a piece of terrain as the arguments of a posture do: `terrain_friction.2` for `surfaces.2.friction`.
/// Errors of scene files, which have `surfaces`, have their place around them.
fn in_words(error: &Error) -> String {
    let mut error = error.clone();
    if let Error::OutOfRange { field, .. } | Error::Unusable { field, .. } = &mut error
        && let Some((piece, name)) =
            field.strip_prefix("surfaces.").and_then(|rest| rest.split_once('.'))
    {
        *field = format!("terrain_{name}.{piece}");
    }
    error.to_string()
}

/// The error number, the same on all systems (Python module `errno`).
fn number(kind: ErrorKind) -> i32 {
    match kind {
        ErrorKind::NotFound => 2,
        ErrorKind::PermissionDenied => 13,
        ErrorKind::NotADirectory => 20,
        ErrorKind::IsADirectory => 21,
        ErrorKind::StorageFull => 28,
        _ => 5, // input or output
    }
}
