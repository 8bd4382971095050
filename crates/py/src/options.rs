//! Options by name.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use standfast::Options;
use standfast::options::Jams;

use crate::convert::{call, call_some, word};
use crate::error::to_py;
use crate::input;

/// Sets one option; false if there is no option of this name.
fn assign(options: &mut Options, name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    match name {
        "model" => options.model = call("model", input::model(value)?)?,
        "impact" => options.impact = call("impact", input::impact(value)?)?,
        "simultaneous" => {
            options.simultaneous = call_some("simultaneous", input::simultaneous(value)?)?
        }
        "stop" => options.stop = call("stop", input::stop(value)?)?,
        "time" => options.time = input::time(value)?,
        "time_limit" => options.time_limit = input::time_limit(value)?,
        "event_limit" => options.event_limit = input::event_limit(value)?,
        "sensitivity_limit" => options.sensitivity_limit = input::sensitivity_limit(value)?,
        "neighbourhood" => options.neighbourhood = input::neighbourhood(value)?,
        "edges" => options.edges = call("edges", input::edges(value)?)?,
        "jams" => options.jams = jams(value)?,
        "record" => options.record = input::record(value)?,
        "certify" => options.certify = input::certify(value)?,
        _ => return Ok(false),
    }
    Ok(true)
}

/// What happens where a contact jams.
pub(crate) fn jams(value: &Bound<'_, PyAny>) -> PyResult<Jams> {
    call("jams", input::jams(value)?)
}

/// Sets options by name and checks them.
pub(crate) fn set(options: &mut Options, keywords: &Bound<'_, PyDict>) -> PyResult<()> {
    for (key, value) in keywords {
        let name = key.to_string();
        if !assign(options, &name, &value)? {
            return Err(input::no_option(&name, &value));
        }
    }
    options.validate().map_err(|e| to_py(&e))
}

/// The options changed by the keywords of a call. `without`: options that the function of this name does not have.
pub(crate) fn of_call(
    function: &str,
    mut options: Options,
    without: &[&str],
    keywords: Option<&Bound<'_, PyDict>>,
) -> PyResult<Options> {
    for (key, value) in keywords.into_iter().flatten() {
        let name = key.cast::<PyString>()?.to_string_lossy();
        if without.contains(&&*name) || !assign(&mut options, &name, &value)? {
            return Err(input::no_keyword(key.py(), function, &name));
        }
    }
    Ok(options)
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
    dict.set_item("sensitivity_limit", options.sensitivity_limit)?;
    dict.set_item("neighbourhood", options.neighbourhood)?;
    dict.set_item("edges", word(&options.edges))?;
    dict.set_item("jams", word(&options.jams))?;
    dict.set_item("record", options.record)?;
    dict.set_item("certify", options.certify)?;
    Ok(dict)
}
