//! Keywords of `simulate`, and the call itself.

use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::value::{Error as NoSuchVariant, StrDeserializer};
use serde::de::{Deserialize, IntoDeserializer};
use standfast::{Error, Options, Trajectory};

use crate::error::to_py;
use crate::input;
use crate::run::PyRun;

/// An option that is one of a few words.
pub(crate) fn call<'a, T: Deserialize<'a>>(field: &str, word: &'a str) -> PyResult<T> {
    let words: StrDeserializer<'a, NoSuchVariant> = word.into_deserializer();
    T::deserialize(words).map_err(|e| {
        let text = e.to_string();
        let allowed = text.split_once(", expected ").map_or(text.as_str(), |(_, allowed)| allowed);
        to_py(&Error::Unusable {
            field: field.into(),
            value: format!("{word:?}"),
            allowed: allowed.into(),
        })
    })
}

/// As [`call`], where None leaves it to the core.
pub(crate) fn call_some<'a, T: Deserialize<'a>>(
    field: &str,
    word: Option<&'a str>,
) -> PyResult<Option<T>> {
    word.map(|word| call(field, word)).transpose()
}

/// Runs without the GIL; Ctrl-C ends the run.
pub(crate) fn stopped(
    py: Python<'_>,
    run: impl Send + FnOnce(&dyn Fn() -> bool) -> Result<Option<Trajectory>, Error>,
) -> PyResult<PyRun> {
    interruptible(py, run).map(PyRun)
}

/// Computes without the GIL; Ctrl-C ends it.
pub(crate) fn interruptible<T: Send>(
    py: Python<'_>,
    run: impl Send + FnOnce(&dyn Fn() -> bool) -> Result<Option<T>, Error>,
) -> PyResult<T> {
    let raised = Mutex::new(None);
    // A signal is told once, the answer is asked for by every run.
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

/// Sets options by name.
pub(crate) fn set(options: &mut Options, keywords: &Bound<'_, PyDict>) -> PyResult<()> {
    for (key, value) in keywords {
        let field = key.to_string();
        match field.as_str() {
            "model" => options.model = call("model", input::model(&value)?)?,
            "impact" => options.impact = call("impact", input::impact(&value)?)?,
            "simultaneous" => {
                options.simultaneous = call_some("simultaneous", input::simultaneous(&value)?)?
            }
            "stop" => options.stop = call("stop", input::stop(&value)?)?,
            "time" => options.time = input::time(&value)?,
            "time_limit" => options.time_limit = input::time_limit(&value)?,
            "event_limit" => options.event_limit = input::event_limit(&value)?,
            "neighbourhood" => options.neighbourhood = input::neighbourhood(&value)?,
            "tolerance" => options.tolerance = input::tolerance(&value)?,
            "record" => options.record = input::record(&value)?,
            "certify" => options.certify = input::certify(&value)?,
            _ => return Err(input::no_option(&field, &value)),
        }
    }
    options.validate().map_err(|e| to_py(&e))
}

/// Options by name.
pub(crate) fn get<'py>(py: Python<'py>, options: &Options) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("model", word(&options.model))?;
    dict.set_item("impact", word(&options.impact))?;
    dict.set_item("simultaneous", options.simultaneous.as_ref().map(word))?;
    dict.set_item("stop", word(&options.stop))?;
    dict.set_item("time", options.time)?;
    dict.set_item("time_limit", options.time_limit)?;
    dict.set_item("event_limit", options.event_limit)?;
    dict.set_item("neighbourhood", options.neighbourhood)?;
    dict.set_item("tolerance", options.tolerance)?;
    dict.set_item("record", options.record)?;
    dict.set_item("certify", options.certify)?;
    Ok(dict)
}

/// `KebabCase` variants as the face spells them.
pub(crate) fn word(value: &impl std::fmt::Debug) -> String {
    let mut text = String::new();
    for letter in format!("{value:?}").chars() {
        if letter.is_uppercase() && !text.is_empty() {
            text.push('-');
        }
        text.extend(letter.to_lowercase());
    }
    text
}

/// A double as Python writes it; zero without its sign.
pub(crate) fn float(value: f64) -> String {
    let value = value + 0.0;
    if value.is_finite() { format!("{value:?}") } else { format!("float('{value}')") }
}

pub(crate) fn pair_text(pair: [f64; 2]) -> String {
    format!("({}, {})", float(pair[0]), float(pair[1]))
}
