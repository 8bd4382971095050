//! Strict reading of values: the kind of each value and the length of each array are checked.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Error as _, IntoDeserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// Whether a file leaves this value out.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
pub(crate) fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// A table. Without this type serde would also accept an array of its values.
#[derive(Deserialize)]
#[serde(transparent, bound = "T: Deserialize<'de>")]
pub(crate) struct Table<T>(#[serde(deserialize_with = "table")] pub(crate) T);

/// Serde for a table.
pub(crate) fn table<'de, D, T>(deserializer: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct Reader<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Reader<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a table")
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
            T::deserialize(MapAccessDeserializer::new(map))
        }
    }

    deserializer.deserialize_map(Reader(PhantomData))
}

/// Serde for the contacts of a file.
pub(crate) fn contacts<'de, D, T>(deserializer: D) -> Result<Vec<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct Reader<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Reader<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("an array of tables, each under [[contact]] in TOML")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Vec<T>, A::Error> {
            let mut values = Vec::new();
            while let Some(Table(value)) = entries.next_element()? {
                values.push(value);
            }
            Ok(values)
        }
    }

    deserializer.deserialize_seq(Reader(PhantomData))
}

/// Serde for one of a few words. Without this function serde would also read an enumeration from a table.
pub(crate) fn word<'de, D, T>(deserializer: D) -> Result<T, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct Reader<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Reader<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a string")
        }

        fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<T, E> {
            let text: StrDeserializer<'_, E> = text.into_deserializer();
            T::deserialize(text)
        }
    }

    deserializer.deserialize_str(Reader(PhantomData))
}

/// Serde for a word that may be left out.
pub(crate) fn some_word<'de, D, T>(deserializer: D) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    word(deserializer).map(Some)
}

/// Serde for an array of N values. Without this function a longer TOML array would lose its other values.
pub(crate) fn exactly<'de, D, T, const N: usize>(deserializer: D) -> Result<[T; N], D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    <Vec<T>>::deserialize(deserializer)?.try_into().map_err(|values: Vec<T>| {
        let expected = format!("an array of length {N}");
        D::Error::invalid_length(values.len(), &expected.as_str())
    })
}

/// Serde for a list of pairs.
pub(crate) fn pairs<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<[f64; 2]>, D::Error> {
    #[derive(Deserialize)]
    struct Pair(#[serde(deserialize_with = "exactly")] [f64; 2]);

    Ok(Vec::<Pair>::deserialize(deserializer)?.into_iter().map(|pair| pair.0).collect())
}

/// Reads a list of vertices. An empty list is an error: ground without vertices is written by leaving the list out.
///
/// # Errors
///
/// An empty list.
pub(crate) fn vertices<'de, D, V>(deserializer: D) -> Result<Vec<V>, D::Error>
where
    D: Deserializer<'de>,
    V: Deserialize<'de>,
{
    let all = Vec::deserialize(deserializer)?;
    if all.is_empty() {
        return Err(D::Error::invalid_length(0, &"vertices; leave an empty list out"));
    }
    Ok(all)
}
