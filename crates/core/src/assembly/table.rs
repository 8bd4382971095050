//! The tables of the bodies, the contacts and the ground of an assembly in a scene file.

use serde::{Deserialize, Deserializer, Serialize};

use crate::assembly::rigid::Rigid;
use crate::assembly::system::{Ground, SystemContact, SystemFields, body_called};
use crate::error::Error;
use crate::excitation::{Force, Kick};
use crate::serial::values;

/// A body: a `block`, a `polygon`, or its mass, radius of gyration, centre of mass and outline.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct BodyTable {
    /// Its name; empty: its number.
    name: String,
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_table")]
    block: Option<BlockTable>,
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_table")]
    polygon: Option<PolygonTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mass: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    gyration_radius: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_pair")]
    center_of_mass: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none", deserialize_with = "some_pairs")]
    outline: Option<Vec<[f64; 2]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<f64>,
}

/// A rectangle, see [`Rigid::block`].
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BlockTable {
    width: f64,
    height: f64,
    #[serde(default, deserialize_with = "values::exactly")]
    at: [f64; 2],
    #[serde(default)]
    turn: f64,
    #[serde(default = "one")]
    density: f64,
}

/// A polygon of uniform density.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PolygonTable {
    #[serde(deserialize_with = "values::pairs")]
    vertices: Vec<[f64; 2]>,
    #[serde(default = "one")]
    density: f64,
}

/// A contact, its bodies by name.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContactTable {
    body: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    on: Option<String>,
    #[serde(deserialize_with = "values::exactly")]
    point: [f64; 2],
    #[serde(default)]
    slope: f64,
    #[serde(default)]
    friction: f64,
}

/// A kick on a body.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KickTable {
    body: String,
    time: f64,
    #[serde(deserialize_with = "values::exactly")]
    impulse: [f64; 2],
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "some_pair")]
    point: Option<[f64; 2]>,
}

/// A force through the centre of mass of a body, for a time.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ForceTable {
    body: String,
    start: f64,
    end: f64,
    #[serde(deserialize_with = "values::exactly")]
    force: [f64; 2],
}

/// The ground: as [`Ground`], or a word for none.
#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged, expecting = "a height, the points of a line, or \"none\"")]
pub(crate) enum GroundTable {
    Some(Ground),
    None(NoGround),
}

/// The word for no ground.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum NoGround {
    None,
}

fn one() -> f64 {
    1.0
}

fn some_table<'de, D, T>(deserializer: D) -> Result<Option<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    values::table(deserializer).map(Some)
}

fn some_pair<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 2]>, D::Error> {
    values::exactly(deserializer).map(Some)
}

fn some_pairs<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Vec<[f64; 2]>>, D::Error> {
    values::pairs(deserializer).map(Some)
}

impl BodyTable {
    /// The name and the body; `number`: its number, from 1. Errors name the fields of this table.
    pub(crate) fn read(self, number: usize) -> Result<(String, Rigid), Error> {
        let name = if self.name.is_empty() { number.to_string() } else { self.name };
        let plain = (self.mass, self.gyration_radius, self.center_of_mass, self.outline);
        let body = match (self.block, self.polygon, plain) {
            (
                Some(BlockTable { width, height, at, turn, density }),
                None,
                (None, None, None, None),
            ) => Rigid::block(width, height, at, turn, density)
                .map_err(|e| e.renamed(|field| format!("block.{field}"))),
            (None, Some(PolygonTable { vertices, density }), (None, None, None, None)) => {
                Rigid::polygon(&vertices, density)
                    .map_err(|e| e.renamed(|field| format!("polygon.{field}")))
            }
            (
                None,
                None,
                (Some(mass), Some(gyration_radius), Some(center_of_mass), Some(outline)),
            ) => Rigid { mass, gyration_radius, center_of_mass, outline, friction: None }.checked(),
            _ => Err(Error::Unusable {
                field: "block".into(),
                value: format!("[fields of {name:?}]"),
                allowed:
                    "either block, or polygon, or mass, gyration_radius, center_of_mass and outline"
                        .into(),
            }),
        }?;
        Ok((name, Rigid { friction: self.friction, ..body }))
    }

    pub(crate) fn of((name, body): &(String, Rigid)) -> Self {
        Self {
            name: name.clone(),
            mass: Some(body.mass),
            gyration_radius: Some(body.gyration_radius),
            center_of_mass: Some(body.center_of_mass),
            outline: Some(body.outline.clone()),
            friction: body.friction,
            ..Self::default()
        }
    }
}

impl ContactTable {
    /// The contact between two of these bodies.
    pub(crate) fn read(self, bodies: &[(String, Rigid)]) -> Result<SystemContact, Error> {
        let Self { body, on, point, slope, friction } = self;
        let number = |field: &str, name: &str| body_called(bodies, field, name);
        let on = on.map(|on| number("on", &on)).transpose()?;
        Ok(SystemContact { body: number("body", &body)?, on, point, slope, friction })
    }

    pub(crate) fn of(contact: &SystemContact, bodies: &[(String, Rigid)]) -> Self {
        let name = |k: usize| bodies[k].0.clone();
        let SystemContact { body, on, point, slope, friction } = *contact;
        Self { body: name(body), on: on.map(name), point, slope, friction }
    }
}

impl KickTable {
    pub(crate) fn read(self, bodies: &[(String, Rigid)]) -> Result<(usize, Kick), Error> {
        let Self { body, time, impulse, point } = self;
        Ok((body_called(bodies, "body", &body)?, Kick { time, impulse, point }))
    }

    pub(crate) fn of(&(body, kick): &(usize, Kick), bodies: &[(String, Rigid)]) -> Self {
        let Kick { time, impulse, point } = kick;
        Self { body: bodies[body].0.clone(), time, impulse, point }
    }
}

impl ForceTable {
    pub(crate) fn read(self, bodies: &[(String, Rigid)]) -> Result<(usize, Force), Error> {
        let Self { body, start, end, force } = self;
        Ok((body_called(bodies, "body", &body)?, Force { start, end, force }))
    }

    pub(crate) fn of(&(body, force): &(usize, Force), bodies: &[(String, Rigid)]) -> Self {
        let Force { start, end, force } = force;
        Self { body: bodies[body].0.clone(), start, end, force }
    }
}

impl GroundTable {
    pub(crate) fn read(self) -> Option<Ground> {
        match self {
            Self::Some(ground) => Some(ground),
            Self::None(NoGround::None) => None,
        }
    }

    pub(crate) fn of(ground: Option<&Ground>) -> Self {
        ground.cloned().map_or(Self::None(NoGround::None), Self::Some)
    }
}

/// A field of an assembly as the file names it: `body.2.mass`, `contact.1.point.x`.
pub(crate) fn of_system(fields: &SystemFields, field: &str) -> String {
    let body = |rest: &str| {
        let (k, name) = fields
            .bodies
            .iter()
            .enumerate()
            .find_map(|(k, (name, _))| Some((k, rest.strip_prefix(&format!("{name}."))?)))?;
        Some(format!("body.{}.{name}", k + 1))
    };
    let of = |prefix: &str| field.strip_prefix(prefix);
    if let Some(found) = of("bodies.").and_then(body) {
        return found;
    }
    match of("contacts.") {
        Some(rest) => format!("contact.{rest}"),
        None if field == "bodies" => "body".into(),
        None if field == "contacts" => "contact".into(),
        None => field.into(),
    }
}
