//! Conversion between values of Rust and of Python: words, numbers, arrays, and the pickled form of results.

use std::fmt::{self, Display, Formatter};

use numpy::{IntoPyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::value::{Error as NoSuchVariant, StrDeserializer};
use serde::de::{DeserializeOwned, IntoDeserializer};
use serde::ser::Serialize;
use standfast::Error;
use standfast::body::LocalModel;

use crate::error::to_py;

/// Reads an option that is one of a few words.
pub(crate) fn call<T: DeserializeOwned>(field: &str, word: &str) -> PyResult<T> {
    let read = |word: &str| {
        let words: StrDeserializer<'_, NoSuchVariant> = word.into_deserializer();
        T::deserialize(words)
    };
    read(word).map_err(|e| {
        let text = e.to_string();
        let allowed = text.split_once(", expected ").map_or(text.as_str(), |(_, allowed)| allowed);
        let written = word.to_lowercase().replace(['_', ' '], "-");
        let meant = match read(&written) {
            Ok(_) => format!("; did you mean {written:?}?"),
            Err(_) => String::new(),
        };
        to_py(&Error::Unusable {
            field: field.into(),
            value: format!("{word:?}"),
            allowed: format!("{allowed}{meant}"),
        })
    })
}

/// As [`call`]; None leaves the choice to the core.
pub(crate) fn call_some<T: DeserializeOwned>(
    field: &str,
    word: Option<&str>,
) -> PyResult<Option<T>> {
    word.map(|word| call(field, word)).transpose()
}

/// The name of a variant of an enumeration in Python and in files.
pub(crate) fn word(value: &impl Serialize) -> String {
    struct Name<'v, T>(&'v T);

    impl<T: Serialize> Display for Name<'_, T> {
        fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
            self.0.serialize(to)
        }
    }

    Name(value).to_string()
}

/// A double as Python writes it, without the sign of zero.
pub(crate) fn float(value: f64) -> String {
    let value = value + 0.0;
    if value.is_finite() { format!("{value:?}") } else { format!("float('{value}')") }
}

pub(crate) fn pair_text(pair: [f64; 2]) -> String {
    format!("({}, {})", float(pair[0]), float(pair[1]))
}

/// Numbers as a list.
pub(crate) fn numbers_text(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().copied().map(float).collect();
    format!("[{}]", texts.join(", "))
}

/// The first words of a text, up to some forty characters.
pub(crate) fn first_words(text: &str) -> String {
    const LENGTH: usize = 40;
    let end = text.char_indices().find(|(at, c)| *at >= LENGTH && *c == ' ').map(|(at, _)| at);
    end.map_or_else(|| text.to_owned(), |end| format!("{} …", &text[..end]))
}

/// A count with its noun.
pub(crate) fn counted(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// Values in row-major order as an array.
pub(crate) fn array<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    Ok(values.into_pyarray(py).reshape(shape.to_vec())?.to_dyn().clone())
}

pub(crate) fn vector<'py>(py: Python<'py>, v: &standfast::Vector3) -> Bound<'py, PyArray1<f64>> {
    vec![v.x, v.y, v.z].into_pyarray(py)
}

/// A function or a class of the package with its keywords: the pickled form of an object, and of one or many runs together with the
/// arguments. Repeating a run gives the same result to the last bit.
pub(crate) fn question<'py>(
    function: Bound<'py, PyAny>,
    keywords: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    function.py().import("functools")?.getattr("partial")?.call((function,), Some(keywords))
}

/// A Python `LocalModel`, created by its name in the package.
pub(crate) fn local_model<'py>(py: Python<'py>, model: &LocalModel) -> PyResult<Bound<'py, PyAny>> {
    let class = py.import("standfast")?.getattr("LocalModel")?;
    class.call1((model.gravity(), model.psi(), model.phi(), model.restitution()))
}
