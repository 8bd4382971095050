//! One question about many bodies.

use numpy::{IntoPyArray, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyString};
use standfast::Error;
use standfast::simulate::{Answer, Resources, many};

use crate::input;
use crate::interrupt::interruptible;

/// A progress bar that Python chooses to show is shown after this time, s: short lists need none.
const DELAY: f64 = 1.0;

/// What a function is asked about.
pub(crate) enum Asked<T> {
    One(T),
    Many(List<T>),
}

/// A sequence, or an array of objects. None stays without an answer.
pub(crate) struct List<T> {
    items: Vec<Option<T>>,
    /// The shape of an array.
    shape: Option<Vec<usize>>,
}

/// The keywords of a list.
#[derive(Clone, Copy)]
pub(crate) struct Threads {
    pub(crate) count: Option<usize>,
    pub(crate) progress: Option<bool>,
}

impl<T> Asked<T> {
    /// One item or a list of them. `read` is `None` for what is no item; `wrong` is the error for such a value, by the name of its field.
    pub(crate) fn read(
        value: &Bound<'_, PyAny>,
        read: impl Fn(&Bound<'_, PyAny>) -> PyResult<Option<T>>,
        wrong: impl Fn(&str, &Bound<'_, PyAny>) -> PyErr,
    ) -> PyResult<Self> {
        if let Some(one) = read(value)? {
            return Ok(Self::One(one));
        }
        let text = value.is_instance_of::<PyString>() || value.is_instance_of::<PyBytes>();
        if text || value.is_instance_of::<PyDict>() {
            return Err(wrong("posture", value));
        }
        let (found, shape) = if value.hasattr("dtype")? {
            let array = value.py().import("numpy")?.call_method1("asarray", (value,))?;
            let shape: Vec<usize> = array.getattr("shape")?.extract()?;
            if shape.is_empty() {
                return Err(wrong("posture", value));
            }
            (array.getattr("flat")?, Some(shape))
        } else {
            (value.clone(), None)
        };
        let Ok(found) = found.try_iter() else { return Err(wrong("posture", value)) };
        let mut list = List { items: Vec::new(), shape };
        for item in found {
            let item = item?;
            let one = if item.is_none() { None } else { Some(read(&item)?) };
            if matches!(one, Some(None)) {
                return Err(wrong(&list.place(list.items.len()), &item));
            }
            list.items.push(one.flatten());
        }
        Ok(Self::Many(list))
    }
}

impl<T: Sync> List<T> {
    /// The answers in the order of the items, on all cores unless `threads` says otherwise.
    pub(crate) fn answers<A: Send>(
        &self,
        py: Python<'_>,
        threads: Threads,
        answer: &Answer<'_, T, A>,
    ) -> PyResult<Vec<Option<A>>> {
        let delay = if threads.progress.is_none() { DELAY } else { 0.0 };
        let asked = (self.items.len(), " bodies", threads.progress, delay);
        let bar = py.import("standfast.maps")?.call_method1("bar", asked)?;
        let bar = (!bar.is_none()).then(|| bar.unbind());
        let mut resources = Resources::default();
        resources.threads = threads.count.unwrap_or(resources.threads);
        // A progress bar that fails must not end the computation.
        let told = |py: Python<'_>, result: PyResult<Py<PyAny>>| {
            result.map_or_else(|e| e.write_unraisable(py, None), drop);
        };
        let done = |count: usize| {
            if let Some(bar) = &bar {
                Python::attach(|py| told(py, bar.call_method1(py, "update", (count,))));
            }
        };
        let each = |item: &Option<T>, stop: &dyn Fn() -> bool| {
            item.as_ref().map(|item| answer(item, stop)).transpose()
        };
        let found = interruptible(py, |cancel| {
            many(&self.items, resources, cancel, &done, &each).map_err(|(at, error)| match error {
                Error::Cancelled => Error::Cancelled,
                error => Error::At { place: self.place(at), error: Box::new(error) },
            })
        });
        if let Some(bar) = &bar {
            told(py, bar.call_method0(py, "close"));
        }
        found
    }
}

impl<T> List<T> {
    /// The name of an item, by its index in Python.
    fn place(&self, at: usize) -> String {
        let (mut rest, mut indices) = (at, Vec::new());
        let shape = self.shape.as_deref().unwrap_or(&[]);
        for length in shape.iter().skip(1).rev() {
            indices.push((rest % length).to_string());
            rest /= length;
        }
        indices.push(rest.to_string());
        indices.reverse();
        format!("posture[{}]", indices.join(", "))
    }

    /// A list of objects made from items and their answers, or an array of objects for an array; None where an item is None.
    pub(crate) fn objects<'py, A, O: IntoPyObject<'py>>(
        self,
        py: Python<'py>,
        answers: Vec<Option<A>>,
        object: impl Fn(T, A) -> O,
    ) -> PyResult<Bound<'py, PyAny>> {
        let made = self.items.into_iter().zip(answers).map(|(item, answer)| {
            let made = item.zip(answer).map(|(item, answer)| object(item, answer));
            made.into_pyobject(py).map_err(Into::into)
        });
        let Some(shape) = self.shape else {
            let made: PyResult<Vec<Bound<'py, PyAny>>> = made.collect();
            return Ok(PyList::new(py, made?)?.into_any());
        };
        let array = py.import("numpy")?.call_method1("empty", (made.len(), "O"))?;
        for (at, made) in made.enumerate() {
            array.set_item(at, made?)?;
        }
        array.call_method1("reshape", (shape,))
    }

    /// An array of numbers; nan where an item is None.
    pub(crate) fn numbers<'py>(
        &self,
        py: Python<'py>,
        answers: Vec<Option<f64>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let numbers: Vec<f64> = answers.into_iter().map(|n| n.unwrap_or(f64::NAN)).collect();
        let shape = self.shape.clone().unwrap_or_else(|| vec![numbers.len()]);
        let array: Bound<'py, PyArrayDyn<f64>> = numbers.into_pyarray(py).reshape(shape)?;
        Ok(array.into_any())
    }
}

/// Whether a progress bar is shown.
pub(crate) fn progress(value: &Bound<'_, PyAny>) -> PyResult<Option<bool>> {
    if value.is_none() {
        return Ok(None);
    }
    let flag = value.extract().map(Some);
    flag.map_err(|_| input::wrong_type("progress", value, "None, True or False is allowed"))
}
