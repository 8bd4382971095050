//! Writing of files, interruptible by Ctrl-C.

use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

use crate::error::to_py;

/// Time between two checks for Ctrl-C.
const CHECK_INTERVAL: Duration = Duration::from_millis(10);

/// Writes a file under another name and renames it: complete or not at all. Special files, such as
/// pipes, are written directly.
#[pyfunction]
pub(crate) fn write_whole(py: Python<'_>, path: PathBuf, data: Vec<u8>) -> PyResult<()> {
    if !std::fs::metadata(&path).is_ok_and(|found| !found.is_file()) {
        return standfast::write_whole(&path, &data).map_err(|e| to_py(&e));
    }
    // Writing to a pipe waits for a reader.
    let writing = thread::spawn(move || standfast::write_whole(&path, &data));
    while !writing.is_finished() {
        py.check_signals()?;
        py.detach(|| thread::sleep(CHECK_INTERVAL));
    }
    let written = writing.join().unwrap_or_else(|_| unreachable!("writing does not panic"));
    written.map_err(|e| to_py(&e))
}
