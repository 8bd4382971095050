//! Sweeps as they are written: each is checked when it is read.

use serde::{Deserialize, Serialize};

use crate::body::{Chain, Posture, State};
use crate::error::Error;
use crate::options::Options;
use crate::serial::numbers::AnyNumber;
use crate::stability::StabilityOptions;
use crate::sweep::parameters::{Field, Subject};
use crate::sweep::{OfConditions, OfVerdict, Quantity, unusable};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Axis {
    path: String,
    values: Vec<f64>,
}

impl From<super::Axis> for Axis {
    fn from(axis: super::Axis) -> Self {
        Self { path: axis.path, values: axis.values }
    }
}

impl TryFrom<Axis> for super::Axis {
    type Error = Error;

    /// Whether the values are allowed depends on the posture or the chain, which [`super::Sweep`] has.
    fn try_from(axis: Axis) -> Result<Self, Error> {
        let Axis { path, values } = axis;
        let field = Field::of_any(&path);
        let field =
            field.ok_or_else(|| unusable("path", &format!("{path:?}"), "that of a parameter"))?;
        if values.is_empty() {
            return Err(unusable(&path, "[]", "at least one value"));
        }
        Ok(Self { path, field, values })
    }
}

impl From<Quantity> for &'static str {
    fn from(quantity: Quantity) -> Self {
        let named = Quantity::ALL.iter().find(|(_, known)| *known == quantity);
        named.map(|(name, _)| *name).expect("each quantity has a name")
    }
}

impl TryFrom<String> for Quantity {
    type Error = Error;

    fn try_from(name: String) -> Result<Self, Error> {
        Self::parse(&name)
    }
}

impl From<OfConditions> for Quantity {
    fn from(field: OfConditions) -> Self {
        Self::Condition(field)
    }
}

impl From<OfVerdict> for Quantity {
    fn from(field: OfVerdict) -> Self {
        Self::Verdict(field)
    }
}

impl TryFrom<Quantity> for OfConditions {
    type Error = Error;

    fn try_from(quantity: Quantity) -> Result<Self, Error> {
        match quantity {
            Quantity::Condition(field) => Ok(field),
            _ => Err(unusable("quantity", quantity.into(), "a field of the conditions")),
        }
    }
}

impl TryFrom<Quantity> for OfVerdict {
    type Error = Error;

    fn try_from(quantity: Quantity) -> Result<Self, Error> {
        match quantity {
            Quantity::Verdict(field) => Ok(field),
            _ => Err(unusable("quantity", quantity.into(), "a field that needs the whole verdict")),
        }
    }
}

/// The list of words of a quantity that has these.
fn known(words: &[String]) -> Result<&'static [&'static str], Error> {
    let lists = Quantity::ALL.iter().filter_map(|(_, quantity)| match quantity.kind() {
        super::ValueKind::Word(list) => Some(list),
        super::ValueKind::Flag | super::ValueKind::Number => None,
    });
    let found = lists.into_iter().find(|list| *list == words);
    found.ok_or_else(|| unusable("words", &format!("{words:?}"), "the words of a quantity"))
}

fn texts(words: &[&str]) -> Vec<String> {
    words.iter().map(ToString::to_string).collect()
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ValueKind {
    Flag,
    Number,
    Word(Vec<String>),
}

impl From<super::ValueKind> for ValueKind {
    fn from(kind: super::ValueKind) -> Self {
        match kind {
            super::ValueKind::Flag => Self::Flag,
            super::ValueKind::Number => Self::Number,
            super::ValueKind::Word(words) => Self::Word(texts(words)),
        }
    }
}

impl TryFrom<ValueKind> for super::ValueKind {
    type Error = Error;

    fn try_from(kind: ValueKind) -> Result<Self, Error> {
        Ok(match kind {
            ValueKind::Flag => Self::Flag,
            ValueKind::Number => Self::Number,
            ValueKind::Word(words) => Self::Word(known(&words)?),
        })
    }
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub(super) enum Column {
    Flags(Vec<bool>),
    Numbers(Vec<AnyNumber>),
    Words { words: Vec<String>, codes: Vec<u8> },
}

impl From<super::Column> for Column {
    fn from(column: super::Column) -> Self {
        match column {
            super::Column::Flags(values) => Self::Flags(values),
            super::Column::Numbers(values) => {
                Self::Numbers(values.into_iter().map(AnyNumber::from).collect())
            }
            super::Column::Words { words, codes } => Self::Words { words: texts(words), codes },
        }
    }
}

impl TryFrom<Column> for super::Column {
    type Error = Error;

    fn try_from(column: Column) -> Result<Self, Error> {
        Ok(match column {
            Column::Flags(values) => Self::Flags(values),
            Column::Numbers(values) => Self::Numbers(values.into_iter().map(f64::from).collect()),
            Column::Words { words, codes } => {
                let words = known(&words)?;
                if let Some(code) = codes.iter().find(|code| usize::from(**code) >= words.len()) {
                    let allowed = format!("less than {}", words.len());
                    return Err(unusable("codes", &code.to_string(), &allowed));
                }
                Self::Words { words, codes }
            }
        })
    }
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sweep {
    of: Subject,
    over: Vec<super::Axis>,
    quantities: Vec<Quantity>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start: Option<State>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    options: Option<Options>,
    #[serde(default)]
    verdicts: StabilityOptions,
}

impl From<super::Sweep> for Sweep {
    fn from(sweep: super::Sweep) -> Self {
        Self {
            of: sweep.subject,
            over: sweep.axes,
            quantities: sweep.quantities,
            start: sweep.run.map(|(start, _)| start),
            options: sweep.run.map(|(_, options)| options),
            verdicts: sweep.verdicts,
        }
    }
}

impl TryFrom<Sweep> for super::Sweep {
    type Error = Error;

    fn try_from(written: Sweep) -> Result<Self, Error> {
        let Sweep { of, over, quantities, start, options, verdicts } = written;
        let sweep = match of {
            Subject::Body(fields) => Self::new(&Posture::new(fields)?, over, quantities)?,
            Subject::Chain(fields, q, hold) => {
                Self::of_chain(&Chain::new(fields)?, &q, hold, over, quantities)?
            }
        };
        let sweep = match start {
            Some(start) => sweep.from_start(start, options.unwrap_or_default())?,
            None => sweep,
        };
        Ok(sweep.with_width(verdicts.width)?.with_jams(verdicts.jams))
    }
}
