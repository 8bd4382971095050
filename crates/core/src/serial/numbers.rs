//! Numbers that may be infinite, as files write them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number that may be infinite: JSON has no infinities, so they are the strings "inf" and "-inf".
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy)]
#[serde(untagged, expecting = "a number, \"inf\" or \"-inf\" is needed")]
pub(crate) enum Extended {
    /// A finite number.
    Number(f64),
    /// "inf" or "-inf".
    Infinite(#[serde(deserialize_with = "crate::serial::values::word")] Infinity),
}

#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy)]
pub(crate) enum Infinity {
    #[serde(rename = "inf")]
    Positive,
    #[serde(rename = "-inf")]
    Negative,
}

impl From<f64> for Extended {
    fn from(value: f64) -> Self {
        if value == f64::INFINITY {
            Self::Infinite(Infinity::Positive)
        } else if value == f64::NEG_INFINITY {
            Self::Infinite(Infinity::Negative)
        } else {
            Self::Number(value)
        }
    }
}

impl From<Extended> for f64 {
    fn from(value: Extended) -> Self {
        match value {
            Extended::Number(value) => value,
            Extended::Infinite(Infinity::Positive) => f64::INFINITY,
            Extended::Infinite(Infinity::Negative) => f64::NEG_INFINITY,
        }
    }
}

/// A number that may be infinite, or NaN, which is written as null.
#[derive(Serialize, Deserialize, Clone, Copy)]
#[serde(transparent)]
pub(crate) struct AnyNumber(Option<Extended>);

impl From<f64> for AnyNumber {
    fn from(value: f64) -> Self {
        Self((!value.is_nan()).then(|| value.into()))
    }
}

impl From<AnyNumber> for f64 {
    fn from(number: AnyNumber) -> Self {
        number.0.map_or(f64::NAN, f64::from)
    }
}

/// Serde for one extended number.
pub(crate) mod extended {
    use super::Extended;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    pub(crate) fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        Extended::from(*value).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Extended::deserialize(deserializer).map(f64::from)
    }
}

/// Serde for an extended number that may be absent.
pub(crate) mod extended_option {
    use super::Extended;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[allow(clippy::ref_option, reason = "serde passes references")]
    pub(crate) fn serialize<S: Serializer>(
        value: &Option<f64>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        value.map(Extended::from).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<f64>, D::Error> {
        Ok(Option::<Extended>::deserialize(deserializer)?.map(f64::from))
    }
}

/// Serde for a pair of extended numbers.
pub(crate) mod extended_pair {
    use super::Extended;
    use serde::{Deserializer, Serialize, Serializer};

    pub(crate) fn serialize<S: Serializer>(
        value: &[f64; 2],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        value.map(Extended::from).serialize(serializer)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<[f64; 2], D::Error> {
        crate::serial::values::exactly(deserializer).map(|pair: [Extended; 2]| pair.map(f64::from))
    }
}
