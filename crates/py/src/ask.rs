//! Questions and answers as JSON.

use std::cell::Cell;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use standfast::Error;

use crate::input;
use crate::interrupt::interruptible;

/// The answer to a question, both as JSON: the vocabulary of the pages. Questions are {"ask": "scene" |
/// "posture" | "motion" | "map", "scene": {...}, ...}, with a scene in the form of the scene files, or
/// as a text in TOML; the page of the crate lists them. Where there is no answer, it is {"error":
/// "..."}.
///
/// Parameters
/// ----------
/// question : str
///     As JSON.
/// seconds : float or None, s, > 0, default None
///     Time after which the answer is the error "stopped"; None: no limit.
///
/// Examples
/// --------
/// >>> import json, standfast as sf
/// >>> scene = """
/// ... gravity = 9.81
/// ... restitution = 0.1
/// ... contact = [{point = [-0.5, 0.0], friction = 0.5}, {point = [0.5, 0.0], friction = 0.5}]
/// ... body = {mass = 1.0, gyration_radius = 0.2, center_of_mass = [0.0, 0.0]}"""
/// >>> answer = json.loads(sf.ask(json.dumps({"ask": "posture", "scene": scene})))
/// >>> answer["verdict"]["frictional_stability"], answer["region"]
/// ('stable', [-0.5, 0.5])
/// >>> sf.ask("{}")
/// '{"error":"missing field `ask` at line 1 column 2"}'
#[pyfunction]
#[pyo3(signature = (question, *, seconds=None))]
pub(crate) fn ask(
    py: Python<'_>,
    question: &str,
    #[pyo3(from_py_with = input::seconds)] seconds: Option<f64>,
) -> PyResult<String> {
    // A time beyond the clock's range is no limit.
    let limit = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    let end = limit.and_then(|limit| Instant::now().checked_add(limit));
    let late = || end.is_some_and(|end| Instant::now() >= end);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    interruptible(py, |cancel| {
        let interrupted = Cell::new(false);
        let answer = standfast::ask::ask_until(question, threads, &|| {
            interrupted.set(interrupted.get() || cancel());
            interrupted.get() || late()
        });
        if interrupted.get() { Err(Error::Cancelled) } else { Ok(answer) }
    })
}
