//! Errors of the core as Python exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyValueError};
use pyo3::prelude::*;

create_exception!(standfast, SolverError, PyException, "A solver failed to find an answer.");

pub(crate) fn to_py(error: &standfast::Error) -> PyErr {
    match error {
        standfast::Error::Solver(_) => SolverError::new_err(error.to_string()),
        standfast::Error::At { error: inner, .. }
            if matches!(**inner, standfast::Error::Solver(_)) =>
        {
            SolverError::new_err(error.to_string())
        }
        _ => PyValueError::new_err(error.to_string()),
    }
}
