//! TOML and JSON texts, and the line and column of what is wrong in them.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::de::{DeserializeOwned, Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;
use serde_path_to_error::{Path, Segment};
use toml::de::{DeTable, DeValue};

use crate::error::{Error, shortened};
use crate::serial::values::Table;

/// How a text is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Format {
    /// TOML.
    Toml,
    /// JSON.
    Json,
}

impl Format {
    /// Reads the table of a text; [`Error::File`] has the line, column and field of the error.
    pub(crate) fn read<T: DeserializeOwned>(self, text: &str) -> Result<T, Error> {
        match self {
            Self::Toml => of_toml(text),
            Self::Json => of_json(self.begun(text)),
        }
    }

    /// Returns true if the table of a text has this key.
    pub(crate) fn has(self, text: &str, key: &str) -> bool {
        match self {
            Self::Toml => DeTable::parse(text).is_ok_and(|table| table.get_ref().contains_key(key)),
            Self::Json => serde_json::from_str::<BTreeMap<String, &RawValue>>(self.begun(text))
                .is_ok_and(|table| table.contains_key(key)),
        }
    }

    /// Returns true if this key of the table of a text has a list of tables.
    pub(crate) fn has_tables(self, text: &str, key: &str) -> bool {
        let is_table = |value: &DeValue<'_>| matches!(value, DeValue::Table(_));
        match self {
            Self::Toml => DeTable::parse(text).is_ok_and(|table| match table.get_ref().get(key) {
                Some(value) => match value.get_ref() {
                    DeValue::Array(all) => all.iter().all(|one| is_table(one.get_ref())),
                    _ => false,
                },
                None => false,
            }),
            Self::Json => {
                let table = serde_json::from_str::<BTreeMap<String, &RawValue>>(self.begun(text));
                let list = table.ok().and_then(|table| {
                    serde_json::from_str::<Vec<&RawValue>>(table.get(key)?.get()).ok()
                });
                list.is_some_and(|all| all.iter().all(|one| one.get().starts_with('{')))
            }
        }
    }

    /// The text after the byte-order mark with which some editors begin it; TOML has rules for it.
    fn begun(self, text: &str) -> &str {
        match self {
            Self::Toml => text,
            Self::Json => text.strip_prefix('\u{feff}').unwrap_or(text),
        }
    }

    /// An error that names a field, with the line and the column of its value.
    pub(crate) fn placed(self, text: &str, error: Error) -> Error {
        let (Error::OutOfRange { field, .. } | Error::Unusable { field, .. }) = &error else {
            return error;
        };
        let text = self.begun(text);
        let start = match self {
            Self::Toml => toml_start(text, field),
            Self::Json => json_start(text, field),
        };
        let (line, column) = place(text, start.unwrap_or(0));
        Error::File {
            path: "scene".into(),
            problem: format!("line {line}, column {column}: {error}"),
            error: Some(Box::new(error)),
        }
    }
}

fn of_toml<T: DeserializeOwned>(text: &str) -> Result<T, Error> {
    let read = || {
        let tree = toml::Deserializer::parse(text).map_err(|e| (String::new(), e))?;
        let table = serde_path_to_error::deserialize::<_, Table<T>>(tree);
        table.map_err(|e| (dotted(e.path()), e.into_inner()))
    };
    read().map(|table| table.0).map_err(|(field, error)| {
        let span = error.span().unwrap_or_default();
        let message = match error.message() {
            "duplicate key" => format!("duplicate key `{}`", &text[span.clone()]),
            message => message.to_owned(),
        };
        malformed(Format::Toml, place(text, span.start), &field, &message)
    })
}

fn of_json<T: DeserializeOwned>(text: &str) -> Result<T, Error> {
    let mut tree = serde_json::Deserializer::from_str(text);
    let table = serde_path_to_error::deserialize::<_, Table<T>>(&mut tree);
    let table = table.map_err(|e| (dotted(e.path()), e.into_inner()));
    let whole = table.and_then(|table| {
        tree.end().map_err(|e| (String::new(), e))?;
        Ok(table.0)
    });
    // A key given twice comes first: what else is wrong may follow from it.
    let twice = serde_json::from_str::<Unique>(text).err().filter(serde_json::Error::is_data);
    let whole = twice.map_or(whole, |error| Err((String::new(), error)));
    whole.map_err(|(field, error)| {
        let lines = text.split_inclusive('\n').take(error.line().saturating_sub(1));
        let reached = lines.map(str::len).sum::<usize>() + error.column().saturating_sub(1);
        let in_field = error.is_data() && !field.is_empty();
        let value = if in_field { json_start(text, &field) } else { None };
        let message = error.to_string();
        let message =
            message.rsplit_once(" at line ").map_or(message.as_str(), |(message, _)| message);
        let message = match message {
            "expected value" => "a value of JSON is needed: no NaN, no Infinity, no comment",
            "number out of range" => "a number within the range of doubles is needed",
            message => message,
        };
        malformed(Format::Json, place(text, value.unwrap_or(reached)), &field, message)
    })
}

/// Any value of JSON in which no table has a key twice. A reader of the file might see one of the values, and the program take the other.
struct Unique;

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Self)
    }
}

impl<'de> Visitor<'de> for Unique {
    type Value = Self;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_bool<E>(self, _: bool) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Self, A::Error> {
        while entries.next_element::<Self>()?.is_some() {}
        Ok(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self, A::Error> {
        let mut keys = BTreeSet::new();
        while let Some(key) = entries.next_key::<String>()? {
            if keys.contains(&key) {
                return Err(A::Error::custom(format_args!("duplicate key `{}`", shortened(&key))));
            }
            keys.insert(key);
            entries.next_value::<Self>()?;
        }
        Ok(self)
    }
}

/// Line and column, from 1, of a byte of a text.
fn place(text: &str, byte: usize) -> (usize, usize) {
    // A parser may stop within a character.
    let before = String::from_utf8_lossy(&text.as_bytes()[..byte.min(text.len())]);
    let before = before.trim_start_matches('\u{feff}');
    let line = before.rfind('\n').map_or(before, |end| &before[end + 1..]);
    (before.matches('\n').count() + 1, line.chars().count() + 1)
}

/// The path of a field as messages write it: entries of arrays count from 1.
fn dotted(path: &Path) -> String {
    let segments = path.iter().filter_map(|segment| match segment {
        Segment::Seq { index } => Some((index + 1).to_string()),
        Segment::Map { key } => Some(key.clone()),
        Segment::Enum { .. } | Segment::Unknown => None,
    });
    segments.collect::<Vec<_>>().join(".")
}

/// The index of an entry of an array, as messages write it.
fn entry(key: &str) -> Option<usize> {
    match key {
        "x" => Some(0),
        "y" => Some(1),
        "theta" => Some(2),
        number => number.parse::<usize>().ok()?.checked_sub(1),
    }
}

/// The position at which the value of a field begins, or else that of the value around it.
fn toml_start(text: &str, field: &str) -> Option<usize> {
    let root = DeTable::parse(text).ok()?;
    let mut start = root.span().start;
    let root = DeValue::Table(root.into_inner());
    let mut value = &root;
    for key in field.split('.') {
        let inner = match value {
            DeValue::Table(table) => table.get(key),
            DeValue::Array(array) => entry(key).and_then(|index| array.get(index)),
            _ => None,
        };
        let Some(inner) = inner else { break };
        (start, value) = (inner.span().start, inner.get_ref());
    }
    Some(start)
}

/// The position at which the value of a field begins, or else that of the value around it; `None`: the text is not JSON.
fn json_start(text: &str, field: &str) -> Option<usize> {
    let mut value: &RawValue = serde_json::from_str(text).ok()?;
    for key in field.split('.') {
        let inner = match entry(key) {
            Some(index) => serde_json::from_str::<Vec<&RawValue>>(value.get())
                .ok()
                .and_then(|array| array.get(index).copied()),
            None => serde_json::from_str::<BTreeMap<String, &RawValue>>(value.get())
                .ok()
                .and_then(|table| table.get(key).copied()),
        };
        let Some(inner) = inner else { break };
        value = inner;
    }
    Some(value.get().as_ptr().addr() - text.as_ptr().addr())
}

/// A parser's message, with the names of types as a reader of the file calls them.
fn malformed(format: Format, (line, column): (usize, usize), field: &str, message: &str) -> Error {
    let (found, expected) = match message.rsplit_once(", expected ") {
        Some((found, expected)) => {
            let meant = meant(format, found, expected);
            (found, format!(", expected {}{meant}", in_words(expected)))
        }
        None => (message, String::new()),
    };
    let found = match found.trim_end_matches(" as i128").trim_end_matches(" as u128") {
        "invalid type: map" => "invalid type: table".into(),
        "invalid type: sequence" => "invalid type: array".into(),
        found => shortened(found),
    };
    let field = if field.is_empty() { String::new() } else { format!(", {}", shortened(field)) };
    Error::File {
        path: "scene".into(),
        problem: format!("line {line}, column {column}{field}: {found}{expected}"),
        error: None,
    }
}

/// A question for the known field or word that is nearest to an unknown one; empty if none is near.
fn meant(format: Format, found: &str, expected: &str) -> String {
    let unknown = found.split_once('`').filter(|(start, _)| start.starts_with("unknown "));
    let Some((_, unknown)) = unknown else { return String::new() };
    let likeness = |known: &&str| strsim::jaro_winkler(unknown.trim_end_matches('`'), known);
    // Every second part is a name in backticks.
    let nearest = expected.split('`').skip(1).step_by(2);
    match nearest.max_by(|a, b| likeness(a).total_cmp(&likeness(b))) {
        Some(known) if likeness(&known) < ALIKE => String::new(),
        Some("contact") if format == Format::Toml => "; did you mean `[[contact]]`?".into(),
        Some(known) => format!("; did you mean `{known}`?"),
        None => String::new(),
    }
}

/// Least likeness (Jaro and Winkler's, from 0 to 1) of an unknown name to a known one that is suggested.
const ALIKE: f64 = 0.8;

/// The expectation of a parser, without the names of Rust.
fn in_words(expected: &str) -> &str {
    match expected {
        "f64" => "a number",
        "usize" => "an integer >= 0",
        "a boolean" => "true or false",
        "a sequence" => "an array",
        other => other,
    }
}
