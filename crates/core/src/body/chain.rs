//! Planar open chains (trees) of straight links on hinges: a robot with feet, or an arm.
//!
//! ```text
//!  floating                              pinned
//!    (x, y) o======o   link 1              o======o======o   links 1, 2
//!          / \                             ^ joint 1 at the origin, joint 2
//!         /   \        links 2, 3
//!       ---   ---      feet
//! q = (x, y, θ, joint coordinates)       q = (joint coordinates)
//! ```
//!
//! (x, y) is the near end of link 1 and θ the angle of its axis from +x, counterclockwise. A joint turns a link about its near end:
//!
//! ```text
//! angle of a link = angle of its parent + angle of its joint + joint coordinate
//! ```
//!
//! Joint k connects link k + 1 of a floating chain, link k of a pinned one. Links, joints and feet are numbered from 1, coordinates from 0.
//! The equations of motion are in `chain_equations.rs`.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::body::mechanism::MAX_DOF;
use crate::body::posture::MAX_CONTACTS;
use crate::error::{
    self, Error, angle, finite, friction, in_range, joint_angle, non_negative, positive,
    restitution,
};
use crate::serial::shown_as_written;
use crate::serial::values::is_zero;

/// How a chain begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Base {
    /// Link 1 moves freely: three coordinates before those of the joints.
    #[default]
    Floating,
    /// The first joint hinges link 1 at the origin of the world.
    Pinned,
}

/// What a joint does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// It does not turn.
    Locked,
    /// It turns under a constant torque, which may be zero.
    Torque,
}

shown_as_written!(Base, JointKind);

/// A straight link.
///
/// ```
/// use standfast::body::Link;
///
/// let rod = Link::uniform(2.0, 0.5);
/// assert_eq!((rod.inertia, rod.center), (2.0 * 0.25 / 12.0, None));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Link {
    /// Mass ≥ 0, in kg. A link without mass or inertia must be carried by others: the mass matrix has to be positive definite.
    pub mass: f64,
    /// Inertia ≥ 0 about its own centre of mass, in kg m².
    pub inertia: f64,
    /// Length > 0, in m.
    pub length: f64,
    /// Distance of its centre of mass from its near end along its axis, in m; `None`: half the length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<f64>,
}

impl Link {
    /// A uniform rod: its centre is its middle, its inertia mL²/12.
    #[must_use]
    pub fn uniform(mass: f64, length: f64) -> Self {
        Self { mass, inertia: mass * length * length / 12.0, length, center: None }
    }

    pub(super) fn center(&self) -> f64 {
        self.center.unwrap_or(0.5 * self.length)
    }
}

/// A hinge between a link and its parent, or between link 1 and the world.
///
/// ```
/// use standfast::body::Joint;
///
/// let knee = Joint { torque: -3.0, ..Joint::torque() };
/// assert_eq!(knee.kind.to_string(), "torque");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// Whether it turns.
    pub kind: JointKind,
    /// Constant torque τ on the joint coordinate, in N m; a locked joint ignores it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub torque: f64,
    /// Inertia ≥ 0 of a rotor, reflected through its gear, in kg m²; added to the diagonal of the mass matrix.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub armature: f64,
    /// Number of the parent link, from 1; `None`: the link before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<usize>,
    /// Where the joint is: distance along the parent from its near end, in m; `None`: the parent's length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// Angle of the link's axis from that of its parent (of link 1 of a pinned chain: from +x) at joint coordinate 0, in (−π, π], in rad.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub angle: f64,
}

impl Joint {
    /// A joint that does not turn, at the end of the link before.
    #[must_use]
    pub fn locked() -> Self {
        let kind = JointKind::Locked;
        Self { kind, torque: 0.0, armature: 0.0, parent: None, at: None, angle: 0.0 }
    }

    /// A joint without torque, at the end of the link before.
    #[must_use]
    pub fn torque() -> Self {
        Self { kind: JointKind::Torque, ..Self::locked() }
    }
}

/// A point of a link on the ground, or a disc about one: the ground is a straight line of `slope`. A flat foot has two of them on its link.
///
/// ```
/// use standfast::body::Foot;
///
/// let heel = Foot { at: Some(0.9), friction: 0.5, ..Foot::of_link(3) };
/// assert_eq!((heel.link, heel.slope), (3, 0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Foot {
    /// Number of its link, from 1.
    pub link: usize,
    /// Distance along the link from its near end, in m; `None`: the length of the link.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// Radius ≥ 0 of a disc about this point, in m, with which the link touches the ground; 0: the point touches it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub radius: f64,
    /// Slope angle of the ground, −π < slope ≤ π, in rad, as of a [`Contact`](crate::Contact): t = (cos, sin), n = (−sin, cos).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub slope: f64,
    /// Coefficient of friction μ, from 0 to 1e6, dimensionless.
    #[serde(default)]
    pub friction: f64,
    /// Coefficient of restitution in [0, 1], dimensionless; `None` takes the chain's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Tangential restitution in [0, 1), dimensionless. Only some impact laws use it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tangential_restitution: f64,
}

impl Foot {
    /// The far end of a link, numbered from 1, on level ground without friction.
    #[must_use]
    pub fn of_link(link: usize) -> Self {
        let (radius, slope, friction, tangential_restitution) = (0.0, 0.0, 0.0, 0.0);
        Self { link, at: None, radius, slope, friction, restitution: None, tangential_restitution }
    }
}

/// The fields of a chain, before validation. SI units, angles in rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainFields {
    /// How it begins.
    #[serde(default)]
    pub base: Base,
    /// The links; each comes after its parent.
    pub links: Vec<Link>,
    /// The joints: one for each link of a pinned chain, one less of a floating one.
    pub joints: Vec<Joint>,
    /// The feet, at most [`MAX_CONTACTS`]. All of them touch the ground.
    #[serde(default)]
    pub feet: Vec<Foot>,
    /// Gravity g ≥ 0, in m/s², downwards.
    #[serde(default = "earth")]
    pub gravity: f64,
    /// Coefficient of restitution e in [0, 1], dimensionless.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub restitution: f64,
}

fn earth() -> f64 {
    9.81
}

impl Default for ChainFields {
    /// A floating chain without links, with g = 9.81 m/s²: links have to be added.
    fn default() -> Self {
        let (base, gravity, restitution) = (Base::Floating, earth(), 0.0);
        Self { base, links: vec![], joints: vec![], feet: vec![], gravity, restitution }
    }
}

/// A planar open chain of links. Every field is validated once.
///
/// ```
/// use standfast::body::{Chain, ChainFields, Foot, Joint, Link};
///
/// // Two legs of 1 m on a hip of 10 kg that is the near end of the trunk; they make angles of ±0.5 rad with the vertical.
/// let hip = |angle: f64| Joint { parent: Some(1), at: Some(0.0), angle, ..Joint::locked() };
/// let down = -0.5 * std::f64::consts::PI;
/// let biped = Chain::new(ChainFields {
///     links: vec![
///         Link { mass: 10.0, inertia: 0.4, length: 1.0, center: Some(0.0) },
///         Link::uniform(1.0, 1.0),
///         Link::uniform(1.0, 1.0),
///     ],
///     joints: vec![hip(down), hip(down)],
///     feet: vec![Foot { friction: 0.8, ..Foot::of_link(2) }, Foot { friction: 0.8, ..Foot::of_link(3) }],
///     ..ChainFields::default()
/// })?;
/// let q = [0.0, 0.0, 0.0, -0.5, 0.5];
/// let [left, right] = biped.points(&q)?.feet[..] else { unreachable!() };
/// assert!((left[0] + 0.5_f64.sin()).abs() < 1e-15 && (right[1] + 0.5_f64.cos()).abs() < 1e-15);
/// assert_eq!(biped.mechanism(&q)?.contact_space().rank(), 3);     // with its joints locked it is a rigid body
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ChainFields", into = "ChainFields")]
pub struct Chain(Arc<ChainFields>);

impl TryFrom<ChainFields> for Chain {
    type Error = Error;

    fn try_from(fields: ChainFields) -> Result<Self, Error> {
        Self::new(fields)
    }
}

impl From<Chain> for ChainFields {
    fn from(chain: Chain) -> Self {
        Arc::unwrap_or_clone(chain.0)
    }
}

impl Chain {
    /// Validates `fields`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field, its value and what is allowed, such as `joints.2.parent`: a number
    /// outside its range, another number of joints than the links need, a parent that does not come before its link, a foot on no link.
    pub fn new(fields: ChainFields) -> Result<Self, Error> {
        links(&fields)?;
        joints(&fields)?;
        feet(&fields)?;
        error::gravity("gravity", fields.gravity)?;
        restitution("restitution", fields.restitution)?;
        Ok(Self(Arc::new(fields)))
    }

    /// The validated fields.
    #[must_use]
    pub fn fields(&self) -> &ChainFields {
        &self.0
    }

    /// Number of coordinates, with those of locked joints: of a floating chain two more than its links, of a pinned chain as many.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.first_angle() + self.0.links.len()
    }

    /// The coordinate that turns link 1; those of the other links follow it, link by link.
    pub(super) fn first_angle(&self) -> usize {
        match self.0.base {
            Base::Floating => 2,
            Base::Pinned => 0,
        }
    }

    /// The coordinate of a joint, both from 0.
    pub(super) fn coordinate(&self, joint: usize) -> usize {
        self.dof() - self.0.joints.len() + joint
    }

    /// The joint that carries a link, from 0; `None` for link 1 of a floating chain.
    pub(super) fn joint_of(&self, link: usize) -> Option<&Joint> {
        let without = self.0.links.len() - self.0.joints.len();
        self.0.joints.get(link.checked_sub(without)?)
    }

    /// The parent of a link, both from 0; `None` for link 1.
    pub(super) fn parent_of(&self, link: usize) -> Option<usize> {
        let before = link.checked_sub(1)?;
        Some(self.joint_of(link).and_then(|joint| joint.parent).map_or(before, |parent| parent - 1))
    }

    /// Checks a configuration.
    pub(super) fn check(&self, q: &[f64]) -> Result<(), Error> {
        let dof = self.dof();
        if q.len() != dof {
            return Err(Error::Unusable {
                field: "q".into(),
                value: format!("[{} entries]", q.len()),
                allowed: format!("one entry for each of the {dof} coordinates"),
            });
        }
        for (k, value) in q.iter().enumerate() {
            if k < self.first_angle() {
                finite(format_args!("q.{k}"), *value)?;
            } else {
                joint_angle(format_args!("q.{k}"), *value)?;
            }
        }
        Ok(())
    }
}

fn links(fields: &ChainFields) -> Result<(), Error> {
    let count = fields.links.len();
    let most = match fields.base {
        Base::Floating => MAX_DOF - 2,
        Base::Pinned => MAX_DOF,
    };
    if !(1..=most).contains(&count) {
        return Err(Error::Unusable {
            field: "links".into(),
            value: format!("[{count} links]"),
            allowed: format!("1 to {most} links"),
        });
    }
    for (k, link) in fields.links.iter().enumerate() {
        let at = format!("links.{}", k + 1);
        non_negative(format_args!("{at}.mass"), link.mass)?;
        non_negative(format_args!("{at}.inertia"), link.inertia)?;
        positive(format_args!("{at}.length"), link.length)?;
        finite(format_args!("{at}.center"), link.center())?;
    }
    if fields.links.iter().all(|link| link.mass == 0.0) {
        return Err(Error::Unusable {
            field: "links".into(),
            value: "[no link with mass]".into(),
            allowed: "at least one link with a mass > 0".into(),
        });
    }
    Ok(())
}

fn joints(fields: &ChainFields) -> Result<(), Error> {
    let (links, count) = (fields.links.len(), fields.joints.len());
    let (base, needed) = match fields.base {
        Base::Floating => ("floating", links - 1),
        Base::Pinned => ("pinned", links),
    };
    if count != needed {
        return Err(Error::Unusable {
            field: "joints".into(),
            value: format!("[{count} joints]"),
            allowed: format!("{needed} joints, because a {base} chain has {links} links"),
        });
    }
    for (k, joint) in fields.joints.iter().enumerate() {
        let at = format!("joints.{}", k + 1);
        finite(format_args!("{at}.torque"), joint.torque)?;
        non_negative(format_args!("{at}.armature"), joint.armature)?;
        angle(format_args!("{at}.angle"), joint.angle, "-pi < angle <= pi, in rad")?;
        let link = 1 + k + links - count;
        let unusable = |field: &str, value: String, allowed: String| {
            Err(Error::Unusable { field: format!("{at}.{field}"), value, allowed })
        };
        let pin = "left out, because joint 1 of a pinned chain is at the origin of the world";
        match (joint.parent, joint.at) {
            (Some(parent), _) if link == 1 => unusable("parent", parent.to_string(), pin.into())?,
            (_, Some(place)) if link == 1 => unusable("at", format!("{place:?}"), pin.into())?,
            (Some(parent), _) if !(1..link).contains(&parent) => unusable(
                "parent",
                parent.to_string(),
                format!("a link before link {link}, which it carries, from 1"),
            )?,
            (_, Some(place)) => {
                finite(format_args!("{at}.at"), place)?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn feet(fields: &ChainFields) -> Result<(), Error> {
    let (links, count) = (fields.links.len(), fields.feet.len());
    if count > MAX_CONTACTS {
        return Err(Error::Unusable {
            field: "feet".into(),
            value: format!("[{count} feet]"),
            allowed: format!("at most {MAX_CONTACTS} feet"),
        });
    }
    for (k, foot) in fields.feet.iter().enumerate() {
        let at = format!("feet.{}", k + 1);
        if !(1..=links).contains(&foot.link) {
            return Err(Error::Unusable {
                field: format!("{at}.link"),
                value: foot.link.to_string(),
                allowed: format!("a link, from 1 to {links}"),
            });
        }
        if let Some(place) = foot.at {
            finite(format_args!("{at}.at"), place)?;
        }
        non_negative(format_args!("{at}.radius"), foot.radius)?;
        angle(format_args!("{at}.slope"), foot.slope, "-pi < slope <= pi, in rad")?;
        friction(format_args!("{at}.friction"), foot.friction)?;
        if let Some(value) = foot.restitution {
            restitution(format_args!("{at}.restitution"), value)?;
        }
        in_range(
            format_args!("{at}.tangential_restitution"),
            foot.tangential_restitution,
            (0.0..1.0).contains(&foot.tangential_restitution),
            "0 <= tangential_restitution < 1",
        )?;
    }
    Ok(())
}
