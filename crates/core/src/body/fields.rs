//! What a posture and a mechanism are made of, before validation.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::body::contact::Contact;
use crate::error::{self, Error};
use crate::serial::values::is_zero;

/// The fields of a posture, before validation. SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PostureFields {
    /// Mass m > 0, in kg.
    pub mass: f64,
    /// Radius of gyration ρ > 0, in m.
    pub gyration_radius: f64,
    /// Nominal centre of mass x, world axes, in m.
    pub center_of_mass: [f64; 2],
    /// The contacts, numbered from 1.
    pub contacts: Vec<Contact>,
    /// Coefficient of restitution e in [0, 1], dimensionless.
    pub restitution: f64,
    /// Gravity g ≥ 0, downwards, in m/s².
    pub gravity: f64,
    /// Vertices of the terrain, world axes, in m: a polyline that does not meet itself, with the ground on its right. With x increasing it is
    /// a ground without walls. Each contact touches the piece under it or, where there are walls, the nearest one; `slope` and `segment` of
    /// the contacts follow from the terrain. If there are no vertices, each contact touches only its own line, see [`Contact`].
    #[serde(
        default,
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "crate::serial::values::vertices"
    )]
    pub terrain: Vec<[f64; 2]>,
    /// What each piece of the terrain is made of, from vertex k to vertex k + 1; none: as the contacts say.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<Surface>,
    /// Without a terrain: whether each contact has its own line, or all share one.
    #[serde(
        default,
        skip_serializing_if = "GroundKind::is_own",
        deserialize_with = "crate::serial::values::word"
    )]
    pub ground: GroundKind,
    /// Corners of the polygon of the body in its nominal posture, in order, in m; none: nothing but the contacts is known of its shape. A
    /// corner of the body meets the ground only if it is a contact. Where a corner of the ground meets a side of the polygon, the option
    /// [`Edges`](crate::options::Edges) says what happens: by default the side is a contact of the run.
    #[serde(
        default,
        skip_serializing_if = "Vec::is_empty",
        deserialize_with = "crate::serial::values::vertices"
    )]
    pub outline: Vec<[f64; 2]>,
}

/// What a piece of ground is made of. A contact on it has the friction and the restitution of the piece where the piece gives them, and its own
/// where not.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Surface {
    /// Coulomb friction coefficient μ, from 0 to 1e12; `None`: that of the contact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Coefficient of restitution e, from 0 to 1; `None`: that of the contact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Speed of the surface along its tangent, in m/s, as of a belt. The piece stays in its place.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub speed: f64,
}

impl Surface {
    /// Checks every field; `at` is the path written in front of a field's name in an error.
    pub(crate) fn validate(&self, at: &str) -> Result<(), Error> {
        if let Some(value) = self.friction {
            error::friction(format_args!("{at}friction"), value)?;
        }
        if let Some(value) = self.restitution {
            error::restitution(format_args!("{at}restitution"), value)?;
        }
        error::surface_speed(format_args!("{at}speed"), self.speed)?;
        Ok(())
    }
}

impl Default for PostureFields {
    /// 1 kg on level ground without restitution, with g = 9.81 m/s². `gyration_radius` and `contacts` have no default:
    /// [`Posture::new`](crate::Posture::new) refuses the zero and the empty list that stand for them.
    fn default() -> Self {
        Self {
            mass: 1.0,
            gyration_radius: 0.0,
            center_of_mass: [0.0; 2],
            contacts: Vec::new(),
            restitution: 0.0,
            gravity: 9.81,
            terrain: Vec::new(),
            surfaces: Vec::new(),
            ground: GroundKind::default(),
            outline: Vec::new(),
        }
    }
}

/// The ground of a posture without a terrain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GroundKind {
    /// Each contact meets only the line of its own slope through its own point.
    #[default]
    Own,
    /// All contacts meet one straight line without ends. It has their slope, which must be one, and goes through the lowest contact.
    Shared,
}

impl GroundKind {
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    pub(crate) fn is_own(&self) -> bool {
        *self == Self::Own
    }
}

/// The Jacobian rows of one contact, its friction and its restitution.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactRows {
    /// N (dof): rate of the gap per unit velocity of each coordinate, in m/s over the unit of the velocity.
    pub normal: Vec<f64>,
    /// T (dof): sliding velocity per unit velocity of each coordinate, likewise. With the tangent t = (cos, sin) of the ground, to the right,
    /// and its normal n = (−sin, cos), N = nᵀJ and T = tᵀJ, where J is the Jacobian of the contact point.
    pub tangential: Vec<f64>,
    /// Coefficient of friction μ, from 0 to 1e6, dimensionless.
    #[serde(default)]
    pub friction: f64,
    /// Coefficient of restitution in [0, 1], dimensionless; `None` takes the mechanism's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Tangential restitution in [0, 1), dimensionless. Only some impact laws use it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tangential_restitution: f64,
}

/// The fields of a mechanism, before validation. SI units: kg, m, s, rad; the units of row and column of a coordinate follow from its own, m
/// or rad.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MechanismFields {
    /// M (dof, dof), symmetric; positive definite in the coordinates that are not locked.
    pub mass_matrix: Vec<Vec<f64>>,
    /// Bτ − h (dof): the generalised forces without those of the contacts, at rest, in N or N m. Gravity acts downwards: in the coordinate
    /// of the height of a floating base its part is −m g.
    pub load: Vec<f64>,
    /// The contacts, numbered from 1. All of them touch at q = 0.
    pub contacts: Vec<ContactRows>,
    /// Coefficient of restitution e in [0, 1], dimensionless.
    #[serde(default)]
    pub restitution: f64,
    /// Coordinates that do not move, counted from 0.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub locked: Vec<usize>,
    /// Inertia (dof) added to the diagonal of M, in kg m² or kg; empty: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub armature: Vec<f64>,
    /// Names of the coordinates (dof), for reports; empty: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coordinate_names: Vec<String>,
    /// Names of the contacts, for reports; empty: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contact_names: Vec<String>,
}
