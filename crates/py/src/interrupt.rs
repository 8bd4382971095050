//! Computation without the GIL, interruptible by Ctrl-C.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use standfast::Error;

use crate::error::to_py;

/// Time between two looks for a signal. A look takes the GIL, which costs as much as some impacts; a person notices no delay.
const LOOK: Duration = Duration::from_millis(20);

/// Computes without the GIL; Ctrl-C ends it.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    run: impl Send + FnOnce(&dyn Fn() -> bool) -> Result<T, Error>,
) -> PyResult<T> {
    let state = Mutex::new((None, Instant::now()));
    // Python reports a signal once, but every run must see it.
    let cancel = || {
        let mut state = state.lock().unwrap_or_else(PoisonError::into_inner);
        let (raised, looked) = &mut *state;
        if raised.is_none() && looked.elapsed() >= LOOK {
            *raised = Python::attach(|py| py.check_signals()).err();
            *looked = Instant::now();
        }
        raised.is_some()
    };
    py.detach(|| run(&cancel)).map_err(|error| match error {
        Error::Cancelled => {
            let raised = state.into_inner().ok().and_then(|state| state.0);
            raised.unwrap_or_else(|| PyKeyboardInterrupt::new_err(()))
        }
        error => to_py(&error),
    })
}
