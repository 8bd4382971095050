//! Reading of arguments from Python, with errors that name the field.

use std::ops::RangeInclusive;

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyBytes, PyDict, PyFloat, PyInt, PyList, PySequence, PyString, PyTuple};
use standfast::Error;
use standfast::body::{MAX_CONTACTS, MAX_VERTICES, Surface};

use crate::convert::array;
use crate::error::to_py;

pub(crate) use standfast::simulate::MOST_SAMPLES;

/// The error for a value of a field.
fn unusable(field: &str, value: &Bound<'_, PyAny>, allowed: impl Into<String>) -> Error {
    // An integer of more than 4300 digits has no repr.
    let text =
        value.repr().map_or_else(|_| format!("<{}>", value.get_type()), |text| text.to_string());
    Error::Unusable { field: field.into(), value: text, allowed: allowed.into() }
}

/// A value of the right type that is not allowed.
pub(crate) fn not_allowed(field: &str, value: &Bound<'_, PyAny>, allowed: &str) -> PyErr {
    to_py(&unusable(field, value, allowed))
}

pub(crate) fn wrong_type(
    field: &str,
    value: &Bound<'_, PyAny>,
    allowed: impl Into<String>,
) -> PyErr {
    PyTypeError::new_err(unusable(field, value, allowed).to_string())
}

/// A real number; infinite if it is too large for a double.
fn real(field: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    number(value).map_err(|_| wrong_type(field, value, "a number is needed"))
}

fn number(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    // Nearly every number is a float. Looking for an attribute that it does not have would cost more than the rest of a call.
    if let Ok(float) = value.cast::<PyFloat>() {
        return Ok(float.value());
    }
    if value.is_exact_instance_of::<PyInt>()
        && let Ok(whole) = value.extract::<f64>()
    {
        return Ok(whole);
    }
    // Numpy also converts booleans, strings and the real parts of complex numbers to floats.
    let real = match value.getattr("dtype") {
        Ok(dtype) => is_real(&dtype)? && value.getattr("ndim")?.eq(0)?,
        Err(_) => !value.is_instance_of::<PyBool>(),
    };
    if !real {
        return Err(PyTypeError::new_err("not a real number"));
    }
    match value.extract::<f64>() {
        Err(e) if e.is_instance_of::<PyOverflowError>(value.py()) => {
            Ok(if value.lt(0)? { f64::NEG_INFINITY } else { f64::INFINITY })
        }
        other => other,
    }
}

/// A real number or None.
fn optional(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    if value.is_none() { Ok(None) } else { real(field, value).map(Some) }
}

fn is_real(dtype: &Bound<'_, PyAny>) -> PyResult<bool> {
    Ok(matches!(dtype.getattr("kind")?.extract::<String>()?.as_str(), "f" | "i" | "u"))
}

/// N real numbers: a sequence or an array.
fn reals<const N: usize>(field: &str, value: &Bound<'_, PyAny>) -> PyResult<[f64; N]> {
    if let Some(numbers) = tuple_of_numbers(value) {
        return Ok(numbers);
    }
    let allowed = format!("{N} numbers are needed");
    let Some(length) = length(value)? else { return Err(wrong_type(field, value, allowed)) };
    if length != N {
        return Err(to_py(&unusable(field, value, format!("{allowed}, not {length}"))));
    }
    let numbers: PyResult<Vec<f64>> = value.try_iter()?.map(|item| number(&item?)).collect();
    let numbers = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| wrong_type(field, value, allowed))
}

/// The numbers of a tuple of this length; `None` if the value is anything else.
fn tuple_of_numbers<const N: usize>(value: &Bound<'_, PyAny>) -> Option<[f64; N]> {
    let tuple = value.cast_exact::<PyTuple>().ok().filter(|tuple| tuple.len() == N)?;
    let mut numbers = [0.0; N];
    for (to, item) in numbers.iter_mut().zip(tuple.iter_borrowed()) {
        *to = number(&item).ok()?;
    }
    Some(numbers)
}

/// The number of entries of a sequence or an array.
fn length(value: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    if let Ok(tuple) = value.cast_exact::<PyTuple>() {
        return Ok(Some(tuple.len()));
    }
    if let Ok(list) = value.cast_exact::<PyList>() {
        return Ok(Some(list.len()));
    }
    let text = value.is_instance_of::<PyString>() || value.is_instance_of::<PyBytes>();
    let items = !text && (value.cast::<PySequence>().is_ok() || value.hasattr("dtype")?);
    Ok(if items { value.len().ok() } else { None })
}

/// A sequence or an array with an entry for each contact. `read` gets the names `field.1`, `field.2`, ….
pub(crate) fn per_contact<T>(
    field: &str,
    value: &Bound<'_, PyAny>,
    read: impl Fn(&str, &Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<T>> {
    let allowed = "a sequence with an entry for each contact is needed";
    let Some(length) = length(value)? else { return Err(wrong_type(field, value, allowed)) };
    if length > MAX_CONTACTS {
        let allowed = format!("at most {MAX_CONTACTS} contacts, not {length}");
        return Err(to_py(&unusable(field, value, allowed)));
    }
    let items = value.try_iter()?.enumerate();
    items.map(|(i, item)| read(&format!("{field}.{}", i + 1), &item?)).collect()
}

/// What each piece of a terrain has, None where the contacts' own holds; empty for None.
fn per_piece(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Option<f64>>> {
    if value.is_none() {
        return Ok(Vec::new());
    }
    sequence(field, value, optional)
}

/// The materials of the pieces of a terrain.
pub(crate) fn surfaces(
    terrain: &[[f64; 2]],
    friction: Vec<Option<f64>>,
    restitution: Vec<Option<f64>>,
    speed: Vec<Option<f64>>,
) -> PyResult<Vec<Surface>> {
    let pieces = terrain.len().saturating_sub(1);
    let given = [
        ("terrain_friction", friction.len()),
        ("terrain_restitution", restitution.len()),
        ("terrain_speed", speed.len()),
    ];
    for (field, count) in given.into_iter().filter(|(_, count)| *count > 0) {
        if count != pieces {
            return Err(to_py(&Error::Unusable {
                field: field.into(),
                value: format!("[{count} entries]"),
                allowed: match pieces {
                    0 => "None without a terrain".into(),
                    _ => format!("one for each of the {pieces} pieces of the terrain"),
                },
            }));
        }
    }
    if given.iter().all(|(_, count)| *count == 0) {
        return Ok(Vec::new());
    }
    let at = |values: &[Option<f64>], k: usize| values.get(k).copied().flatten();
    let surface = |k: usize| Surface {
        friction: at(&friction, k),
        restitution: at(&restitution, k),
        speed: at(&speed, k).unwrap_or(0.0),
    };
    Ok((0..pieces).map(surface).collect())
}

/// The vertices of a terrain; empty for None.
pub(crate) fn terrain(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    polyline("terrain", 2, value)
}

/// The corners of the outline of a body; empty for None.
pub(crate) fn outline(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    polyline("outline", 3, value)
}

fn polyline(field: &str, least: usize, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    if value.is_none() {
        return Ok(Vec::new());
    }
    let allowed = format!("None, or a sequence of {least} to {MAX_VERTICES} vertices (x, y)");
    match length(value)? {
        None => Err(wrong_type(field, value, allowed)),
        Some(length) if (least..=MAX_VERTICES).contains(&length) => {
            let items = value.try_iter()?.enumerate();
            items.map(|(k, item)| reals(&format!("{field}.{}", k + 1), &item?)).collect()
        }
        Some(_) => Err(to_py(&unusable(field, value, allowed))),
    }
}

fn pairs(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    per_contact(field, value, reals)
}

/// Signs of sliding velocities; None where a contact is separated.
fn signs(field: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Option<i8>>> {
    let allowed = "1, -1, 0, or None where the contact is separated";
    per_contact(field, value, |field, item| {
        if item.is_none() {
            return Ok(None);
        }
        let sign = number(item).map_err(|_| wrong_type(field, item, allowed))?;
        let found = [-1, 0, 1].into_iter().find(|&known| f64::from(known) == sign);
        found.map(Some).ok_or_else(|| to_py(&unusable(field, item, allowed)))
    })
}

/// An integer in a range.
pub(crate) fn whole(
    field: &str,
    value: &Bound<'_, PyAny>,
    range: RangeInclusive<usize>,
) -> PyResult<usize> {
    let allowed = format!("an integer from {} to {} is needed", range.start(), range.end());
    if value.is_instance_of::<PyBool>() {
        return Err(wrong_type(field, value, allowed));
    }
    match value.extract::<usize>() {
        Ok(number) if range.contains(&number) => Ok(number),
        Err(e) if !e.is_instance_of::<PyOverflowError>(value.py()) => {
            Err(wrong_type(field, value, allowed))
        }
        _ => Err(to_py(&unusable(field, value, allowed))),
    }
}

/// A nonnegative integer up to the largest `usize`.
fn count(field: &str, value: &Bound<'_, PyAny>) -> PyResult<usize> {
    whole(field, value, 0..=usize::MAX)
}

fn word<'a>(field: &str, value: &'a Bound<'_, PyAny>) -> PyResult<&'a str> {
    value.extract().map_err(|_| wrong_type(field, value, "a string is needed"))
}

/// A word or None.
fn some_word<'a>(field: &str, value: &'a Bound<'_, PyAny>) -> PyResult<Option<&'a str>> {
    if value.is_none() { Ok(None) } else { word(field, value).map(Some) }
}

fn flag(field: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    value.extract().map_err(|_| wrong_type(field, value, "True or False is needed"))
}

/// Defines for each argument a function of its name that reads it.
macro_rules! arguments {
    ($($read:ident -> $kind:ty: $($field:ident),+;)+) => {$($(
        #[allow(clippy::needless_lifetimes, reason = "a word borrows from its value")]
        pub(crate) fn $field<'a>(value: &'a Bound<'_, PyAny>) -> PyResult<$kind> {
            $read(stringify!($field), value)
        }
    )+)+};
}

arguments! {
    real -> f64: width, height, radius, mass, gyration_radius, restitution, gravity, half_length, slope, friction;
    real -> f64: tangential_restitution, theta, omega, time, neighbourhood, energy, fps, speed, start, end, rtol;
    real -> f64: inertia, torque, angle, surface_speed, scale, turn, density, factor;
    per_piece -> Vec<Option<f64>>: terrain_friction, terrain_restitution, terrain_speed;
    optional -> Option<f64>: time_limit, sensitivity_limit, center, at, duration, at_most;
    series -> Vec<f64>: normal, tangential, load, torques;
    reals -> [f64; 2]: acceleration, impulse, force, direction, point, segment, center_of_mass, psi, phi, gaps, rates;
    reals -> [f64; 3]: q, qdot, wrench, free_acceleration;
    pairs -> Vec<[f64; 2]>: arms, tangents, bias;
    signs -> Vec<Option<i8>>: sliding;
    count -> usize: contact, event_limit, seed, scan;
    word -> &'a str: base, kind, ground, interpolation, model, impact, stop, edges, jams, method, level, clock, choose;
    some_word -> Option<&'a str>: simultaneous;
    flag -> bool: record, certify;
}

/// An argument that may be left out; it is read once its shape is known.
#[allow(clippy::unnecessary_wraps, reason = "the type of a reader of an argument")]
pub(crate) fn given<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(Some(value.clone()))
}

/// Rates of all coordinates of a mechanism.
pub(crate) fn coordinate_rates(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    series("qdot", value)
}

/// Accelerations of all coordinates of a system.
pub(crate) fn coordinate_accelerations(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    series("acceleration", value)
}

/// A force (tangential, normal) for each contact.
pub(crate) fn contact_forces(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    sequence("forces", value, reals)
}

/// The centre of a disc, or None.
pub(crate) fn disc_center(value: &Bound<'_, PyAny>) -> PyResult<Option<[f64; 2]>> {
    if value.is_none() { Ok(None) } else { reals("center", value).map(Some) }
}

/// A point, or None.
pub(crate) fn some_point(value: &Bound<'_, PyAny>) -> PyResult<Option<[f64; 2]>> {
    if value.is_none() { Ok(None) } else { point(value).map(Some) }
}

/// A sequence of any length.
pub(crate) fn sequence<T>(
    field: &str,
    value: &Bound<'_, PyAny>,
    read: impl Fn(&str, &Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<T>> {
    if length(value)?.is_none() {
        return Err(wrong_type(field, value, "a sequence is needed"));
    }
    let items = value.try_iter()?.enumerate();
    items.map(|(i, item)| read(&format!("{field}.{}", i + 1), &item?)).collect()
}

/// The times of a motion of the ground.
pub(crate) fn times(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    sequence("times", value, real)
}

/// The accelerations of the ground, or None.
pub(crate) fn accelerations(value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<[f64; 2]>>> {
    if value.is_none() {
        return Ok(None);
    }
    // A number alone is horizontal.
    let entry = |field: &str, item: &Bound<'_, PyAny>| match item.extract::<f64>() {
        Ok(_) => real(field, item).map(|x| [x, 0.0]),
        Err(_) => reals(field, item),
    };
    sequence("acceleration", value, entry).map(Some)
}

/// The corners of a polygon.
pub(crate) fn vertices(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    sequence("vertices", value, reals)
}

/// A parameter of a posture, by its path.
pub(crate) fn parameter(path: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    real(path, value)
}

/// The tilts of the ground, or None.
pub(crate) fn tilt(value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<f64>>> {
    if value.is_none() { Ok(None) } else { sequence("tilt", value, real).map(Some) }
}

/// The radius of gyration of a disc, or None.
pub(crate) fn own_gyration_radius(value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    optional("gyration_radius", value)
}

/// Names of coordinates.
pub(crate) fn coordinate_names(value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    sequence("coordinate_names", value, text)
}

/// Names of contacts.
pub(crate) fn contact_names(value: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    sequence("contact_names", value, text)
}

fn text(field: &str, value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.extract().map_err(|_| wrong_type(field, value, "a string is needed"))
}

/// The friction of a body; None for that of its system.
pub(crate) fn own_friction(value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    optional("friction", value)
}

/// Points of the ground of an assembly.
pub(crate) fn ground_line(value: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    sequence("ground", value, reals)
}

/// Height of the ground of an assembly.
pub(crate) fn ground_height(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    real("ground", value)
}

/// The place of a body.
pub(crate) fn place(value: &Bound<'_, PyAny>) -> PyResult<[f64; 2]> {
    reals("at", value)
}

/// The restitution of a contact; None for that of the posture.
pub(crate) fn own_restitution(value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    optional("restitution", value)
}

/// One restitution for both contacts, or one for each.
pub(crate) fn restitutions(value: &Bound<'_, PyAny>) -> PyResult<[f64; 2]> {
    number(value).map(|e| [e, e]).or_else(|_| reals("restitution", value)).map_err(|error| {
        if error.is_instance_of::<PyTypeError>(value.py()) {
            wrong_type("restitution", value, "a number is needed, or one for each contact")
        } else {
            error
        }
    })
}

/// The reduced coupling of two contacts, a single number.
pub(crate) fn coupling(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    real("psi", value)
}

/// The friction of each contact.
pub(crate) fn frictions(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    per_contact("friction", value, real)
}

/// A word of contact modes.
pub(crate) fn letters<'a>(value: &'a Bound<'_, PyAny>) -> PyResult<&'a str> {
    word("word", value)
}

/// The error for a keyword that the body already determines.
pub(crate) fn refused(field: &str, given: [f64; 3], allowed: &str) -> Error {
    let value = format!("{given:?}");
    Error::Unusable { field: field.into(), value, allowed: allowed.into() }
}

/// The options of a scene.
pub(crate) fn options<'a, 'py>(
    value: &'a Bound<'py, PyAny>,
) -> PyResult<Option<&'a Bound<'py, PyDict>>> {
    if value.is_none() {
        return Ok(None);
    }
    let dict = value.cast::<PyDict>();
    dict.map(Some).map_err(|_| wrong_type("options", value, "None or a dict is needed"))
}

/// The error for an unknown option, with the nearest known one.
pub(crate) fn no_option(name: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let suggest = value.py().import("standfast.suggest");
    let allowed = suggest.and_then(|m| m.call_method1("no_option", (name,))?.extract::<String>());
    allowed.map_or_else(|error| error, |allowed| wrong_type(name, value, allowed))
}

/// The error for a keyword that a function of the package does not have, with the nearest one that it has.
pub(crate) fn no_keyword(py: Python<'_>, function: &str, name: &str) -> PyErr {
    let suggest = py.import("standfast.suggest");
    let message =
        suggest.and_then(|m| m.call_method1("unexpected", (function, name))?.extract::<String>());
    message.map_or_else(|error| error, PyTypeError::new_err)
}

/// The error for the first keyword that a function of the package does not have, if there is one.
pub(crate) fn no_keywords(function: &str, unknown: Option<&Bound<'_, PyDict>>) -> PyResult<()> {
    match unknown.into_iter().flatten().next() {
        Some((name, _)) => Err(no_keyword(name.py(), function, &name.to_string())),
        None => Ok(()),
    }
}

/// The index of one of `count` runs; a negative one counts from the end.
pub(crate) fn run_index(value: &Bound<'_, PyAny>, count: usize) -> PyResult<usize> {
    let wrong = || wrong_type("index", value, "an integer is needed");
    if value.is_instance_of::<PyBool>() {
        return Err(wrong());
    }
    let index = match value.extract::<isize>() {
        Err(e) if !e.is_instance_of::<PyOverflowError>(value.py()) => return Err(wrong()),
        index => index.ok(),
    };
    let found = index.map(|i| if i < 0 { i + count as isize } else { i });
    found.and_then(|i| usize::try_from(i).ok()).filter(|&i| i < count).ok_or_else(|| {
        let allowed = format!("there are {count} runs, from 0");
        PyIndexError::new_err(unusable("index", value, allowed).to_string())
    })
}

/// The error for a value that is neither a posture nor a sequence.
pub(crate) fn no_posture(value: &Bound<'_, PyAny>) -> PyErr {
    wrong_type("posture", value, "a Posture or a sequence of Postures is needed")
}

/// The error for an item of the sequence that is not a posture.
pub(crate) fn wrong_item(index: usize, value: &Bound<'_, PyAny>) -> PyErr {
    wrong_type(&format!("posture[{index}]"), value, "a Posture is needed")
}

/// The error for a value that has no contact modes, by the name of its field.
pub(crate) fn no_body(field: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let needed = match field {
        "posture" => {
            "a Posture, a ContactProblem, a Mechanism, a MechanismProblem or a sequence of them is needed"
        }
        _ => "a Posture, a ContactProblem, a Mechanism, a MechanismProblem or None is needed",
    };
    wrong_type(field, value, needed)
}

/// Gravity into the terrain of each of two contacts.
pub(crate) fn gravities(value: &Bound<'_, PyAny>) -> PyResult<[f64; 2]> {
    reals("gravity", value)
}

/// Anything that numpy converts to an array of real numbers.
pub(crate) fn doubles<'py>(
    field: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let py = value.py();
    if let Ok(float) = value.cast::<PyFloat>() {
        return Ok(array(py, vec![float.value()], &[])?.readonly());
    }
    // Nearly every array is one of doubles. What follows would cost ten times as much as reading a row of a mechanism.
    if let Ok(numbers) = value.cast_exact::<PyArrayDyn<f64>>()
        && is_aligned(numbers)
    {
        return Ok(numbers.readonly());
    }
    let wrong = || wrong_type(field, value, "a number or an array of numbers is needed");
    // numpy.asarray would drop the mask.
    if value.hasattr("mask")?
        && py.import("numpy.ma")?.call_method1("is_masked", (value,))?.is_truthy()?
    {
        return Err(wrong_type(field, value, "an array without masked entries is needed"));
    }
    let asarray = py.import("numpy")?.getattr("asarray")?;
    let found = asarray.call1((value,)).map_err(|_| wrong())?;
    let dtype = found.getattr("dtype")?;
    let numbers = if is_real(&dtype)? {
        let numbers = asarray.call1((found, "float64"))?;
        // Rust must not read an unaligned array, such as one in a pickle's buffer.
        let aligned = numbers.getattr("flags")?.getattr("aligned")?.is_truthy()?;
        let numbers = if aligned { numbers } else { numbers.call_method0("copy")? };
        numbers.cast_into::<PyArrayDyn<f64>>()?
    } else if dtype.getattr("kind")?.eq("O")? {
        let items = found.getattr("flat")?.try_iter()?;
        let numbers: PyResult<Vec<f64>> = items.map(|item| number(&item?)).collect();
        array(py, numbers.map_err(|_| wrong())?, &found.getattr("shape")?.extract::<Vec<_>>()?)?
    } else {
        return Err(wrong());
    };
    Ok(numbers.readonly())
}

/// Whether Rust may read the entries where they are; not in a pickle's buffer, for example.
fn is_aligned(numbers: &Bound<'_, PyArrayDyn<f64>>) -> bool {
    let size = align_of::<f64>().cast_signed();
    numbers.data().is_aligned() && numbers.strides().iter().all(|stride| stride % size == 0)
}

/// An array of shape (..., 3).
pub(crate) fn triples<'py>(
    field: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    tuples(field, value, 3)
}

/// An array of shape (..., n).
pub(crate) fn tuples<'py>(
    field: &str,
    value: &Bound<'py, PyAny>,
    n: usize,
) -> PyResult<PyReadonlyArrayDyn<'py, f64>> {
    let array = doubles(field, value)?;
    if array.as_array().shape().last() != Some(&n) {
        return Err(to_py(&Error::Unusable {
            field: field.into(),
            value: format!("array of shape {:?}", array.as_array().shape()),
            allowed: format!("an array of shape (..., {n})"),
        }));
    }
    Ok(array)
}

/// The values of a parameter: a one-dimensional array of at least one number.
pub(crate) fn series(path: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let values = doubles(path, value)?;
    let array = values.as_array();
    if array.ndim() != 1 {
        let value = format!("array of shape {:?}", array.shape());
        let allowed = "a one-dimensional array of values".into();
        return Err(to_py(&Error::Unusable { field: path.into(), value, allowed }));
    }
    Ok(array.iter().copied().collect())
}

/// The coordinates of a chain.
pub(crate) fn coordinates(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    series("q", value)
}

/// Inertia added to the diagonal of a mass matrix, or None.
pub(crate) fn armature(value: &Bound<'_, PyAny>) -> PyResult<Option<Vec<f64>>> {
    if value.is_none() { Ok(None) } else { series("armature", value).map(Some) }
}

/// The armature of one joint.
pub(crate) fn armature_of_joint(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    real("armature", value)
}

/// The length of a link.
pub(crate) fn length_of_link(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    real("length", value)
}

/// A mass matrix.
pub(crate) fn mass_matrix(value: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<f64>>> {
    let values = doubles("mass_matrix", value)?;
    let array = values.as_array();
    if array.ndim() != 2 {
        let value = format!("array of shape {:?}", array.shape());
        let allowed = "an array of shape (dof, dof)".into();
        return Err(to_py(&Error::Unusable { field: "mass_matrix".into(), value, allowed }));
    }
    Ok(array.rows().into_iter().map(|row| row.to_vec()).collect())
}

/// Sizes of kicks.
pub(crate) fn sizes(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    series("sizes", value)
}

/// Number of threads; None: all cores.
pub(crate) fn threads(value: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    if value.is_none() { Ok(None) } else { whole("threads", value, 1..=MOST_THREADS).map(Some) }
}

/// Number of random kicks.
pub(crate) fn trials(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    whole("trials", value, 0..=standfast::stability::MOST_TRIALS)
}

/// The number of frames of a film.
pub(crate) fn frames(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    whole("frames", value, 2..=standfast::ask::MOST_FRAMES)
}

/// Height of a frame in a notebook, in px.
pub(crate) fn frame_height(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    whole("height", value, 100..=10_000)
}

/// A time limit, in s; None: no limit.
pub(crate) fn seconds(value: &Bound<'_, PyAny>) -> PyResult<Option<f64>> {
    match optional("seconds", value)? {
        Some(limit) if limit.is_nan() || limit <= 0.0 => {
            Err(to_py(&unusable("seconds", value, "a time > 0, in s, or None")))
        }
        limit => Ok(limit),
    }
}

/// Largest number of threads, above the number of cores of any machine.
const MOST_THREADS: usize = 4096;

pub(crate) fn from_point(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    count("start", value)
}

pub(crate) fn to_point(value: &Bound<'_, PyAny>) -> PyResult<usize> {
    count("stop", value)
}

/// The error for a range outside the points.
pub(crate) fn no_range(start: usize, stop: usize, size: usize) -> PyErr {
    let value = format!("{start}..{stop}");
    let allowed = format!("0 <= start <= stop <= {size}");
    to_py(&Error::Unusable { field: "start, stop".into(), value, allowed })
}

/// The error for q without qdot or the reverse, or for options without a start.
pub(crate) fn incomplete_start() -> PyErr {
    let allowed = "q and qdot together, and options of simulate only with them".into();
    to_py(&Error::Unusable { field: "q, qdot".into(), value: "only one of them".into(), allowed })
}

/// The error for a sweep of a chain without a configuration.
pub(crate) fn no_configuration() -> PyErr {
    let allowed = "the configuration of the chain: a value for each coordinate".into();
    to_py(&Error::Unusable { field: "q".into(), value: "None".into(), allowed })
}

/// The error for a sweep of a chain with what only runs need.
pub(crate) fn no_runs_of_chains() -> PyErr {
    let (value, allowed) =
        ("given".into(), "left out: only runs need them, and a chain has none".into());
    to_py(&Error::Unusable { field: "qdot or options of simulate".into(), value, allowed })
}

/// The error for a start that is missing or not used.
pub(crate) fn start_or_not(needed: bool) -> PyErr {
    let (value, allowed) = if needed {
        ("None", "the start of the runs that \"fate\" and \"zeno_time\" need")
    } else {
        ("a start", "left out: only \"fate\" and \"zeno_time\" need a start")
    };
    let (field, value, allowed) = ("q, qdot".into(), value.into(), allowed.into());
    to_py(&Error::Unusable { field, value, allowed })
}
