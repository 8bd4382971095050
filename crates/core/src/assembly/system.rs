//! An assembly of rigid bodies, as a mechanism with names.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::assembly::rigid::Rigid;
use crate::assembly::touching::Sides;
use crate::body::contact::direction;
use crate::body::{ContactRows, MAX_CONTACTS, MAX_DOF, Mechanism, MechanismFields};
use crate::error::{Error, finite, friction, gravity, in_range, restitution};
use crate::tolerance::UPRIGHT_NORMAL;

/// The ground of an assembly.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Ground {
    /// A level line at this height, in m.
    Level(f64),
    /// A line through these points, in m, with the ground on its right: from left to right, what is below.
    Line(Vec<[f64; 2]>),
}

impl Default for Ground {
    fn default() -> Self {
        Self::Level(0.0)
    }
}

/// A contact between two bodies of an assembly, or between a body and the ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SystemContact {
    /// The body that is pushed along the normal, from 0.
    pub body: usize,
    /// The body that is pushed against it, from 0; `None`: the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub on: Option<usize>,
    /// The place of the contact, in m.
    pub point: [f64; 2],
    /// Angle of the tangent t = (cos, sin), in rad. The normal is (−sin, cos), into `body`.
    #[serde(default)]
    pub slope: f64,
    /// Coefficient of friction, dimensionless.
    #[serde(default)]
    pub friction: f64,
}

/// A load on an assembly: wrenches on bodies, or an acceleration of all of them.
#[derive(Debug, Clone, PartialEq)]
pub enum Load {
    /// (body, from 0; force x, y in N; moment about its centre of mass in N m).
    Wrenches(Vec<(usize, [f64; 3])>),
    /// An acceleration that acts like gravity on every body, in m/s²: (1, 0) pushes to the right.
    Acceleration([f64; 2]),
}

/// The fields of an assembly, before validation. SI units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SystemFields {
    /// The bodies, each with its name.
    pub bodies: Vec<(String, Rigid)>,
    /// The contacts; `None`: found where the outlines touch.
    pub contacts: Option<Vec<SystemContact>>,
    /// Coefficient of friction of contacts that are found, where no body has one, dimensionless.
    pub friction: f64,
    /// The ground; `None`: there is none.
    pub ground: Option<Ground>,
    /// Acceleration of gravity, downwards, in m/s².
    pub gravity: f64,
    /// Coefficient of restitution of all contacts, in [0, 1], dimensionless.
    pub restitution: f64,
    /// Tangential restitution of all contacts, in [0, 1), dimensionless. Only some impact laws use it.
    pub tangential_restitution: f64,
}

impl Default for SystemFields {
    /// No bodies; friction 1/2 on level ground, g = 9.81 m/s², restitution 0.
    fn default() -> Self {
        Self {
            bodies: Vec::new(),
            contacts: None,
            friction: 0.5,
            ground: Some(Ground::default()),
            gravity: 9.81,
            restitution: 0.0,
            tangential_restitution: 0.0,
        }
    }
}

/// An assembly of rigid bodies in their places.
///
/// ```
/// use standfast::assembly::{Rigid, System, SystemFields};
/// use standfast::stability::mechanism_forces;
///
/// // Two bricks of 1 kg: each corner of the lower one carries half of the weight of both.
/// let brick = |y| Rigid::block(1.0, 1.0, [0.0, y], 0.0, 1.0);
/// let bodies = vec![("low".into(), brick(0.0)?), ("high".into(), brick(1.0)?)];
/// let stack = System::new(SystemFields { bodies, gravity: 10.0, ..SystemFields::default() })?;
/// assert_eq!(stack.contact_names()[2], "high on low at (-0.5, 1)");
/// let forces = mechanism_forces(&stack.mechanism()?).expect("the stack stands");
/// assert!((forces.low[0][1] - 10.0).abs() < 1e-12);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "SystemFields", into = "SystemFields")]
pub struct System {
    fields: SystemFields,
    contacts: Vec<SystemContact>,
}

impl TryFrom<SystemFields> for System {
    type Error = Error;

    fn try_from(fields: SystemFields) -> Result<Self, Error> {
        Self::new(fields)
    }
}

impl From<System> for SystemFields {
    fn from(system: System) -> Self {
        system.fields
    }
}

impl SystemContact {
    /// The unit tangent (cos, sin), exact for right angles.
    #[must_use]
    pub fn tangent(&self) -> [f64; 2] {
        direction(self.slope).into()
    }
}

fn unusable<T>(field: String, value: String, allowed: impl Into<String>) -> Result<T, Error> {
    Err(Error::Unusable { field, value, allowed: allowed.into() })
}

/// The number, from 0, of the body of this name.
///
/// ```
/// use standfast::assembly::{Rigid, body_called};
///
/// let bodies = ["low", "high"].map(|name| (name.into(), Rigid::block(1.0, 1.0, [0.0, 0.0], 0.0, 1.0).unwrap()));
/// assert_eq!(body_called(&bodies, "body", "high"), Ok(1));
/// ```
///
/// # Errors
///
/// [`Error::Unusable`] naming `field`, with the names of the bodies.
pub fn body_called(bodies: &[(String, Rigid)], field: &str, called: &str) -> Result<usize, Error> {
    bodies.iter().position(|(name, _)| name == called).ok_or_else(|| {
        let names: Vec<&str> = bodies.iter().map(|(name, _)| name.as_str()).collect();
        Error::Unusable {
            field: field.into(),
            value: format!("{called:?}"),
            allowed: format!("a body of the system: {}", names.join(", ")),
        }
    })
}

impl System {
    /// Validates `fields` and finds the contacts.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`] naming the field: no body, a name twice, bodies that overlap each other or the ground, contacts of bodies
    /// that are not there.
    pub fn new(mut fields: SystemFields) -> Result<Self, Error> {
        friction("friction", fields.friction)?;
        gravity("gravity", fields.gravity)?;
        restitution("restitution", fields.restitution)?;
        in_range(
            "tangential_restitution",
            fields.tangential_restitution,
            (0.0..1.0).contains(&fields.tangential_restitution),
            "0 <= tangential_restitution < 1",
        )?;
        if fields.bodies.is_empty() {
            return unusable("bodies".into(), "[]".into(), "one or more bodies");
        }
        for k in 0..fields.bodies.len() {
            let (name, body) = fields.bodies[k].clone();
            if fields.bodies[..k].iter().any(|(other, _)| *other == name) {
                return unusable("bodies".into(), format!("{name:?} twice"), "different names");
            }
            let checked = body.checked();
            fields.bodies[k].1 =
                checked.map_err(|e| e.renamed(|field| format!("bodies.{name}.{field}")))?;
        }
        let ground = ground_sides(&fields)?;
        let contacts = match &fields.contacts {
            Some(given) => {
                for (k, joint) in given.iter().enumerate() {
                    check_joint(&format!("contacts.{}", k + 1), joint, fields.bodies.len())?;
                }
                given.clone()
            }
            None => touching(&fields, ground.as_ref())?,
        };
        Ok(Self { fields, contacts })
    }

    /// The validated fields.
    #[must_use]
    pub fn fields(&self) -> &SystemFields {
        &self.fields
    }

    /// The contacts: for each body in its order those with bodies before it, then those with the ground.
    #[must_use]
    pub fn contacts(&self) -> &[SystemContact] {
        &self.contacts
    }

    /// The contacts in words: which body on which, and where, in m.
    #[must_use]
    pub fn contact_names(&self) -> Vec<String> {
        let name = |k: usize| self.fields.bodies[k].0.as_str();
        let words = |joint: &SystemContact| {
            let [x, y] = joint.point.map(short);
            format!("{} on {} at ({x}, {y})", name(joint.body), joint.on.map_or("the ground", name))
        };
        self.contacts.iter().map(words).collect()
    }

    /// The coordinates in words: of each body x, y and θ.
    #[must_use]
    pub fn coordinate_names(&self) -> Vec<String> {
        let of =
            |(name, _): &(String, Rigid)| ["x", "y", "theta"].map(|axis| format!("{name}.{axis}"));
        self.fields.bodies.iter().flat_map(of).collect()
    }

    /// The Jacobian rows (tangential, normal) of a contact: entries (x, y, θ) for each of its bodies.
    pub(crate) fn rows(&self, joint: &SystemContact) -> [[(usize, [f64; 3]); 2]; 2] {
        let [cosine, sine] = joint.tangent();
        let point = Vector2::from(joint.point);
        let of = |direction: Vector2<f64>, body: usize, sign: f64| {
            let arm = point - Vector2::from(self.fields.bodies[body].1.center_of_mass);
            (body, [sign * direction.x, sign * direction.y, sign * arm.perp(&direction)])
        };
        let row = |direction: Vector2<f64>| {
            let other = joint.on.map_or((joint.body, [0.0; 3]), |on| of(direction, on, -1.0));
            [of(direction, joint.body, 1.0), other]
        };
        [row(Vector2::new(cosine, sine)), row(Vector2::new(-sine, cosine))]
    }

    /// The generalised load of gravity.
    pub(crate) fn weights(&self) -> Vec<f64> {
        let weight = |(_, body): &(String, Rigid)| [0.0, -body.mass * self.fields.gravity, 0.0];
        self.fields.bodies.iter().flat_map(weight).collect()
    }

    /// The assembly as a mechanism with names.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `contacts` or `bodies` if there are no contacts, more than [`MAX_CONTACTS`], or more than [`MAX_DOF`] coordinates.
    pub fn mechanism(&self) -> Result<Mechanism, Error> {
        let dof = 3 * self.fields.bodies.len();
        let count = self.contacts.len();
        if !(1..=MAX_CONTACTS).contains(&count) {
            let allowed = format!("1 to {MAX_CONTACTS} contacts for this question");
            return unusable("contacts".into(), format!("[{count} contacts]"), allowed);
        }
        if dof > MAX_DOF {
            let allowed = format!("at most {} bodies for this question", MAX_DOF / 3);
            return unusable("bodies".into(), format!("[{} bodies]", dof / 3), allowed);
        }
        let mut mass_matrix = vec![vec![0.0; dof]; dof];
        for (k, (_, body)) in self.fields.bodies.iter().enumerate() {
            let inertia = body.mass * body.gyration_radius * body.gyration_radius;
            for (axis, value) in [body.mass, body.mass, inertia].into_iter().enumerate() {
                mass_matrix[3 * k + axis][3 * k + axis] = value;
            }
        }
        let contacts = self.contacts.iter().map(|joint| {
            let whole = |row: [(usize, [f64; 3]); 2]| {
                let mut all = vec![0.0; dof];
                for (body, parts) in row {
                    for (axis, part) in parts.into_iter().enumerate() {
                        all[3 * body + axis] += part;
                    }
                }
                all
            };
            let [tangential, normal] = self.rows(joint).map(whole);
            ContactRows {
                normal,
                tangential,
                friction: joint.friction,
                restitution: None,
                tangential_restitution: self.fields.tangential_restitution,
            }
        });
        Mechanism::new(MechanismFields {
            mass_matrix,
            load: self.weights(),
            contacts: contacts.collect(),
            restitution: self.fields.restitution,
            coordinate_names: self.coordinate_names(),
            contact_names: self.contact_names(),
            ..MechanismFields::default()
        })
    }
}

/// Four digits of a coordinate.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn check_joint(at: &str, joint: &SystemContact, bodies: usize) -> Result<(), Error> {
    for (name, body) in [("body", Some(joint.body)), ("on", joint.on)] {
        if let Some(body) = body.filter(|body| *body >= bodies) {
            let allowed = format!("a body, from 0 to {}", bodies - 1);
            return unusable(format!("{at}.{name}"), body.to_string(), allowed);
        }
    }
    if joint.on == Some(joint.body) {
        return unusable(format!("{at}.on"), joint.body.to_string(), "another body, or the ground");
    }
    for (axis, value) in ["x", "y"].iter().zip(joint.point) {
        finite(format!("{at}.point.{axis}"), value)?;
    }
    finite(format!("{at}.slope"), joint.slope)?;
    friction(format!("{at}.friction"), joint.friction).map(|_| ())
}

/// The line of the ground, from right to left: the ground is on its left.
fn ground_sides(fields: &SystemFields) -> Result<Option<Sides>, Error> {
    let Some(ground) = &fields.ground else { return Ok(None) };
    let mut points = match ground {
        Ground::Level(height) => {
            finite("ground", *height)?;
            let corners = || fields.bodies.iter().flat_map(|(_, body)| &body.outline);
            let low = corners().map(|p| p[0]).fold(f64::INFINITY, f64::min);
            let high = corners().map(|p| p[0]).fold(f64::NEG_INFINITY, f64::max);
            let beside = high - low;
            vec![[low - beside, *height], [high + beside, *height]]
        }
        Ground::Line(points) => {
            for (k, [x, y]) in points.iter().enumerate() {
                finite(format!("ground.{}.x", k + 1), *x)?;
                finite(format!("ground.{}.y", k + 1), *y)?;
            }
            if points.len() < 2 || points.windows(2).any(|pair| pair[0] == pair[1]) {
                let value = format!("[{} points]", points.len());
                return unusable(
                    "ground".into(),
                    value,
                    "two or more points, each other than the one before",
                );
            }
            points.clone()
        }
    };
    points.reverse();
    Ok(Some(Sides::new(&points, false)))
}

/// The contacts where outlines touch.
fn touching(fields: &SystemFields, ground: Option<&Sides>) -> Result<Vec<SystemContact>, Error> {
    let all: Vec<Sides> =
        fields.bodies.iter().map(|(_, body)| Sides::new(&body.outline, true)).collect();
    let size = |k: usize| fields.bodies[k].1.size();
    let name = |k: Option<usize>| k.map_or("the ground", |k| fields.bodies[k].0.as_str());
    let mut contacts = Vec::new();
    for (k, body) in all.iter().enumerate() {
        let others = (0..k).map(|j| (Some(j), &all[j], size(k).min(size(j))));
        for (on, other, size) in others.chain(ground.map(|ground| (None, ground, size(k)))) {
            if body.overlaps(other, size) {
                let value = format!("[{:?} overlaps {:?}]", name(Some(k)), name(on));
                return unusable("bodies".into(), value, "bodies that do not overlap");
            }
            let own = fields.bodies[k].1.friction;
            let others = on.and_then(|on| fields.bodies[on].1.friction);
            let friction = match (own, others) {
                (Some(one), Some(other)) => one.min(other),
                (one, other) => one.or(other).unwrap_or(fields.friction),
            };
            let mut found = body.touches(other, size);
            // The upper body is the one that is pushed along the normal.
            let up = found.iter().all(|touch| touch.normal.y >= -UPRIGHT_NORMAL) || on.is_none();
            if !up {
                found.iter_mut().for_each(|touch| touch.normal = -touch.normal);
            }
            let (body, on) = match (up, on) {
                (false, Some(j)) => (j, Some(k)),
                _ => (k, on),
            };
            contacts.extend(found.into_iter().map(|touch| SystemContact {
                body,
                on,
                point: touch.point.into(),
                slope: libm::atan2(-touch.normal.x, touch.normal.y),
                friction,
            }));
        }
    }
    Ok(contacts)
}
