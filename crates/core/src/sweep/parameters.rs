//! The parameters of a posture and of a chain, by their paths.

use serde::{Deserialize, Serialize};

use crate::body::fields::PostureFields;
use crate::body::{
    Base, Chain, ChainFields, GroundKind, HoldingChoice, JointKind, MAX_CONTACTS, MAX_DOF, Posture,
};
use crate::error::Error;
use crate::sweep::unusable;

/// A number in [`PostureFields`], or in a chain and its configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Field {
    Mass,
    GyrationRadius,
    Gravity,
    Restitution,
    CenterOfMass(usize),
    /// Of all contacts.
    Friction,
    Contact(usize, OfContact),
    /// The angle of the base of a chain.
    BaseAngle,
    /// Of all joints.
    Armature,
    Joint(usize, OfJoint),
    Foot(usize, OfFoot),
}

/// A number of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfJoint {
    Angle,
    Torque,
    Armature,
}

/// A number of a foot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfFoot {
    Slope,
    Friction,
}

/// A number in a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfContact {
    Point(usize),
    Slope,
    Friction,
    Restitution,
    TangentialRestitution,
    Radius,
}

const FIELDS: [(&str, Field); 7] = [
    ("mass", Field::Mass),
    ("gyration_radius", Field::GyrationRadius),
    ("gravity", Field::Gravity),
    ("restitution", Field::Restitution),
    ("friction", Field::Friction),
    ("center_of_mass.x", Field::CenterOfMass(0)),
    ("center_of_mass.y", Field::CenterOfMass(1)),
];

const OF_CONTACT: [(&str, OfContact); 7] = [
    ("point.x", OfContact::Point(0)),
    ("point.y", OfContact::Point(1)),
    ("slope", OfContact::Slope),
    ("friction", OfContact::Friction),
    ("restitution", OfContact::Restitution),
    ("tangential_restitution", OfContact::TangentialRestitution),
    ("radius", OfContact::Radius),
];

const OF_CHAIN: [(&str, Field); 5] = [
    ("gravity", Field::Gravity),
    ("restitution", Field::Restitution),
    ("friction", Field::Friction),
    ("armature", Field::Armature),
    ("base.angle", Field::BaseAngle),
];

const OF_JOINT: [(&str, OfJoint); 3] =
    [("angle", OfJoint::Angle), ("torque", OfJoint::Torque), ("armature", OfJoint::Armature)];

const OF_FOOT: [(&str, OfFoot); 2] = [("slope", OfFoot::Slope), ("friction", OfFoot::Friction)];

/// A path has no larger number of a contact, a joint or a foot.
const MOST_PARTS: usize = if MAX_CONTACTS > MAX_DOF { MAX_CONTACTS } else { MAX_DOF };

/// The index and the rest of a path `prefix` number `.` rest, with a number from 1 to `count`.
fn numbered<'a>(path: &'a str, prefix: &str, count: usize) -> Option<(usize, &'a str)> {
    let (number, rest) = path.strip_prefix(prefix)?.split_once('.')?;
    let index = (1..=count).position(|known| known.to_string() == number)?;
    Some((index, rest))
}

fn named<T: Copy>(known: &[(&str, T)], name: &str) -> Option<T> {
    known.iter().find(|(known, _)| *known == name).map(|(_, field)| *field)
}

/// What has the parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Subject {
    Body(PostureFields),
    /// A chain in this configuration; the torques that its joints have instead of their own.
    Chain(ChainFields, Vec<f64>, Option<HoldingChoice>),
}

impl Subject {
    /// The subject whose parameters vary. Over a terrain slopes and segments follow from the places of the contacts.
    pub(super) fn of(posture: &Posture) -> Self {
        let mut fields = posture.fields().clone();
        if !fields.terrain.is_empty() {
            off_the_terrain(&mut fields);
        }
        Self::Body(fields)
    }

    pub(super) fn posture(self) -> Result<Posture, Error> {
        match self {
            Self::Body(fields) => Posture::new(fields),
            Self::Chain(..) => unreachable!("a subject that was made of a posture"),
        }
    }

    /// The parameter of this path.
    pub(super) fn parameter(&self, path: &str) -> Result<Field, Error> {
        let found = match self {
            Self::Body(fields) => Field::of_body(path, fields.contacts.len()),
            Self::Chain(fields, ..) => Field::of_chain(path, fields),
        };
        found.ok_or_else(|| unusable("over", &format!("{path:?}"), &self.allowed()))
    }

    fn allowed(&self) -> String {
        match self {
            Self::Body(fields) => {
                let own = OF_CONTACT.map(|(name, _)| format!("contacts.1.{name}")).join(", ");
                format!(
                    "the parameters are {}, {own}, contacts counting from 1 to {}",
                    FIELDS.map(|(name, _)| name).join(", "),
                    fields.contacts.len()
                )
            }
            Self::Chain(fields, ..) => format!(
                "the parameters of a chain are {}, {} (joints counting from 1 to {}), {} (feet from 1 to {})",
                OF_CHAIN.map(|(name, _)| name).join(", "),
                OF_JOINT.map(|(name, _)| format!("joint.1.{name}")).join(", "),
                fields.joints.len(),
                OF_FOOT.map(|(name, _)| format!("foot.1.{name}")).join(", "),
                fields.feet.len()
            ),
        }
    }

    /// Checks the values that do not depend on others. Over a terrain it depends on other parameters whether a point lies on it; this is
    /// checked later.
    pub(super) fn check(
        &self,
        field: Field,
        values: impl Iterator<Item = f64>,
    ) -> Result<(), Error> {
        let mut probe = self.clone();
        if let Self::Body(fields) = &mut probe {
            if !fields.terrain.is_empty() {
                off_the_terrain(fields);
                fields.terrain = Vec::new();
            }
            fields.ground = GroundKind::Own;
        }
        for value in values {
            field.set(&mut probe, value);
            match &probe {
                Self::Body(fields) => Posture::new(fields.clone()).map(drop)?,
                Self::Chain(fields, q, _) => {
                    Chain::new(fields.clone())?.points(q)?;
                }
            }
        }
        Ok(())
    }
}

/// Removes the slopes and segments of all contacts, so that they follow from the terrain again after a contact has been moved.
pub(super) fn off_the_terrain(fields: &mut PostureFields) {
    for contact in &mut fields.contacts {
        contact.slope = 0.0;
        contact.segment = [f64::NEG_INFINITY, f64::INFINITY];
    }
}

impl Field {
    pub(super) fn of_body(path: &str, contacts: usize) -> Option<Self> {
        named(&FIELDS, path).or_else(|| {
            let (index, rest) = numbered(path, "contacts.", contacts)?;
            Some(Self::Contact(index, named(&OF_CONTACT, rest)?))
        })
    }

    /// The parameter of this path in some body or chain.
    pub(super) fn of_any(path: &str) -> Option<Self> {
        let in_chain = |prefix| {
            let (index, rest) = numbered(path, prefix, MOST_PARTS)?;
            match prefix {
                "joint." => Some(Self::Joint(index, named(&OF_JOINT, rest)?)),
                _ => Some(Self::Foot(index, named(&OF_FOOT, rest)?)),
            }
        };
        Self::of_body(path, MOST_PARTS)
            .or_else(|| named(&OF_CHAIN, path))
            .or_else(|| in_chain("joint."))
            .or_else(|| in_chain("foot."))
    }

    fn of_chain(path: &str, fields: &ChainFields) -> Option<Self> {
        if let Some(found) = named(&OF_CHAIN, path) {
            return (found != Self::BaseAngle || fields.base == Base::Floating).then_some(found);
        }
        if let Some((index, rest)) = numbered(path, "joint.", fields.joints.len()) {
            let found = named(&OF_JOINT, rest)?;
            let free = fields.joints[index].kind == JointKind::Torque;
            return (free || found == OfJoint::Angle).then_some(Self::Joint(index, found));
        }
        let (index, rest) = numbered(path, "foot.", fields.feet.len())?;
        Some(Self::Foot(index, named(&OF_FOOT, rest)?))
    }

    /// Returns true if it is the torque of a joint.
    pub(super) fn is_torque(self) -> bool {
        matches!(self, Self::Joint(_, OfJoint::Torque))
    }

    pub(super) fn set(self, subject: &mut Subject, value: f64) {
        match subject {
            Subject::Body(fields) => self.set_in_body(fields, value),
            Subject::Chain(fields, q, _) => self.set_in_chain(fields, q, value),
        }
    }

    fn set_in_chain(self, fields: &mut ChainFields, q: &mut [f64], value: f64) {
        match self {
            Self::Gravity => fields.gravity = value,
            Self::Restitution => fields.restitution = value,
            Self::Friction => fields.feet.iter_mut().for_each(|foot| foot.friction = value),
            Self::Armature => {
                let free = fields.joints.iter_mut().filter(|joint| joint.kind == JointKind::Torque);
                free.for_each(|joint| joint.armature = value);
            }
            Self::BaseAngle => q[2] = value,
            Self::Joint(index, OfJoint::Angle) => {
                let first = q.len() - fields.joints.len();
                q[first + index] = value;
            }
            Self::Joint(index, OfJoint::Torque) => fields.joints[index].torque = value,
            Self::Joint(index, OfJoint::Armature) => fields.joints[index].armature = value,
            Self::Foot(index, OfFoot::Slope) => fields.feet[index].slope = value,
            Self::Foot(index, OfFoot::Friction) => fields.feet[index].friction = value,
            Self::Mass | Self::GyrationRadius | Self::CenterOfMass(_) | Self::Contact(..) => {
                unreachable!("a parameter of a body")
            }
        }
    }

    pub(super) fn set_in_body(self, fields: &mut PostureFields, value: f64) {
        match self {
            Self::Mass => fields.mass = value,
            Self::GyrationRadius => fields.gyration_radius = value,
            Self::Gravity => fields.gravity = value,
            Self::Restitution => fields.restitution = value,
            Self::CenterOfMass(k) => fields.center_of_mass[k] = value,
            Self::Friction => fields.contacts.iter_mut().for_each(|c| c.friction = value),
            Self::Contact(index, field) => {
                let contact = &mut fields.contacts[index];
                match field {
                    OfContact::Point(k) => contact.point[k] = value,
                    OfContact::Slope => contact.slope = value,
                    OfContact::Friction => contact.friction = value,
                    OfContact::Restitution => contact.restitution = Some(value),
                    OfContact::TangentialRestitution => contact.tangential_restitution = value,
                    OfContact::Radius => *contact = contact.with_radius(value),
                }
            }
            Self::BaseAngle | Self::Armature | Self::Joint(..) | Self::Foot(..) => {
                unreachable!("a parameter of a chain")
            }
        }
    }

    /// Returns true if both parameters set the same number, so that one of them would have no effect.
    pub(super) fn clashes(self, other: Self) -> bool {
        let part_of = |field: Self, all: Self| match all {
            Self::Friction => matches!(
                field,
                Self::Contact(_, OfContact::Friction) | Self::Foot(_, OfFoot::Friction)
            ),
            Self::Armature => matches!(field, Self::Joint(_, OfJoint::Armature)),
            _ => false,
        };
        self == other || part_of(self, other) || part_of(other, self)
    }
}
