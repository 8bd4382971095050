//! Mechanisms that are rigid bodies: of which all joints are locked.

use crate::body::chain::{Base, Chain};
use crate::body::contact::Contact;
use crate::body::fields::{ContactRows, PostureFields};
use crate::body::mechanism::Mechanism;
use crate::body::posture::Posture;
use crate::error::Error;
use crate::tolerance::RIGID_ROWS;

/// A mechanism whose three coordinates that are not locked are those (x, y, θ) of a rigid body about some point of it.
pub(crate) struct RigidBody {
    pub(crate) posture: Posture,
    /// The centre of mass, from that point.
    pub(crate) center: [f64; 2],
}

impl RigidBody {
    /// M = [m, 0, −m c_y; 0, m, m c_x; −m c_y, m c_x, I], N = (n, n⊥·x), T likewise with the tangent, load = (0, −w, −w c_x).
    pub(crate) fn of(mechanism: &Mechanism) -> Option<Self> {
        let space = mechanism.contact_space();
        if space.free().len() != 3 {
            return None;
        }
        let (m, load) = (space.mass(), space.load());
        let (mass, inertia, weight) = (m[(0, 0)], m[(2, 2)], -load[1]);
        let center = [m[(1, 2)] / mass, -m[(0, 2)] / mass];
        let near = |x: f64, y: f64, size: f64| (x - y).abs() <= RIGID_ROWS * size;
        let rho2 = inertia / mass - center[0] * center[0] - center[1] * center[1];
        let arm = libm::hypot(center[0], center[1]).max(rho2.max(0.0).sqrt());
        let rigid = near(m[(0, 1)], 0.0, mass)
            && near(m[(1, 1)], mass, mass)
            && rho2 > 0.0
            && weight >= 0.0
            && near(load[0], 0.0, weight)
            && near(load[2], -weight * center[0], weight * arm);
        if !rigid {
            return None;
        }
        let part = |row: &[f64]| [0, 1, 2].map(|k| row[space.free()[k]]);
        let contact = |rows: &ContactRows| -> Option<Contact> {
            let ([nx, ny, b], [tx, ty, c]) = (part(&rows.normal), part(&rows.tangential));
            let square =
                near(libm::hypot(tx, ty), 1.0, 1.0) && near(nx, -ty, 1.0) && near(ny, tx, 1.0);
            // N = (n, t·x) and T = (t, −n·x).
            let point = [tx * b - nx * c, ty * b - ny * c];
            square.then(|| Contact {
                friction: rows.friction,
                restitution: rows.restitution,
                tangential_restitution: rows.tangential_restitution,
                ..Contact::at(point[0], point[1]).on_slope(libm::atan2(ty, tx))
            })
        };
        let contacts = mechanism.contacts().iter().map(contact).collect::<Option<Vec<_>>>()?;
        let posture = Posture::new(PostureFields {
            mass,
            gyration_radius: rho2.sqrt(),
            center_of_mass: center,
            contacts,
            restitution: mechanism.fields().restitution,
            gravity: weight / mass,
            ..PostureFields::default()
        });
        Some(Self { posture: posture.ok()?, center })
    }
}

impl Mechanism {
    /// The rigid body that this mechanism is with its joints locked, with the point of which (x, y) are the coordinates at the origin. θ has to be
    /// counterclockwise in the plane of x and y, which the equations of the contacts do not show: with the opposite sign W and b are the same.
    ///
    /// ```
    /// use standfast::body::Mechanism;
    /// use standfast::{Lamina, Posture};
    ///
    /// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
    /// assert_eq!(Mechanism::of_posture(&rod)?.posture()?.contacts()[1].point, [0.5, 0.0]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `mechanism` if its coordinates that are not locked are not those (x, y, θ) of a rigid body under gravity.
    pub fn posture(&self) -> Result<Posture, Error> {
        RigidBody::of(self).map(|body| body.posture).ok_or_else(|| {
            let free = self.contact_space().free().len();
            Error::Unusable {
                field: "mechanism".into(),
                value: match free {
                    1 => "[1 coordinate that is not locked]".into(),
                    _ => format!("[{free} coordinates that are not locked]"),
                },
                allowed: "a rigid body: all joints locked, so that three coordinates (x, y, θ) are left, under gravity alone".into(),
            }
        })
    }
}

impl Chain {
    /// The chain at a configuration with all joints locked: a rigid body that stands on its feet.
    ///
    /// ```
    /// use standfast::body::{Chain, ChainFields, Foot, Joint, Link};
    ///
    /// // Two uniform legs that make a right angle, their feet on level ground 1 m apart.
    /// let length = 0.5_f64.sqrt();
    /// let legs = Chain::new(ChainFields {
    ///     links: vec![Link::uniform(1.0, length); 2],
    ///     joints: vec![Joint { at: Some(0.0), ..Joint::torque() }],
    ///     feet: vec![Foot::of_link(1), Foot::of_link(2)],
    ///     ..ChainFields::default()
    /// })?;
    /// let right = std::f64::consts::FRAC_PI_2;
    /// let body = legs.posture(&[0.0, 0.0, -1.5 * right, right])?;
    /// assert!((body.contacts()[0].point[0] + 0.5).abs() < 1e-15 && (body.fields().center_of_mass[1] + 0.25).abs() < 1e-15);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Chain::mechanism`] about `q`; a pinned chain; no feet; links without inertia.
    pub fn posture(&self, q: &[f64]) -> Result<Posture, Error> {
        let fields = self.fields();
        if fields.base == Base::Pinned {
            return Err(Error::Unusable {
                field: "base".into(),
                value: Base::Pinned.to_string(),
                allowed: "floating: with its joints locked a pinned chain does not move".into(),
            });
        }
        let placed = self.placed(q)?;
        let whole = &placed[0];
        let arm = whole.moment / whole.mass;
        let feet = fields.feet.iter().enumerate();
        let contacts = feet.map(|(k, foot)| {
            let point = self.foot(&placed, k);
            Contact {
                radius: foot.radius,
                friction: foot.friction,
                restitution: foot.restitution,
                tangential_restitution: foot.tangential_restitution,
                ..Contact::at(point.x, point.y).on_slope(foot.slope)
            }
        });
        Posture::new(PostureFields {
            mass: whole.mass,
            gyration_radius: (whole.inertia / whole.mass - arm.norm_squared()).max(0.0).sqrt(),
            center_of_mass: (whole.near + arm).into(),
            contacts: contacts.collect(),
            restitution: fields.restitution,
            gravity: fields.gravity,
            ..PostureFields::default()
        })
    }
}
