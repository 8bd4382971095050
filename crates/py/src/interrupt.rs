//! Computation without the GIL, interruptible by Ctrl-C.

use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use standfast::Error;

use crate::error::to_py;

/// Computes without the GIL; Ctrl-C ends it.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    run: impl Send + FnOnce(&dyn Fn() -> bool) -> Result<Option<T>, Error>,
) -> PyResult<T> {
    let raised = Mutex::new(None);
    // Python reports a signal once, but every run must see it.
    let cancel = || {
        let mut slot = raised.lock().unwrap_or_else(PoisonError::into_inner);
        if slot.is_none() {
            *slot = Python::attach(|py| py.check_signals()).err();
        }
        slot.is_some()
    };
    py.detach(|| run(&cancel)).map_err(|e| to_py(&e))?.ok_or_else(|| {
        let error = raised.into_inner().ok().flatten();
        error.unwrap_or_else(|| PyKeyboardInterrupt::new_err(()))
    })
}
