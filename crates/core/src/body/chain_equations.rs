//! The equations of motion of a chain at a configuration, by composite bodies.
//!
//! The links beyond a joint, its *branch*, turn about the near end p_l of its link. With mass m, first moment s and inertia I of a branch
//! about p_l, c the centre of a link and × turned by a right angle,
//!
//! ```text
//! m_l = m + Σ m_k,   s_l = m (c − p_l) + Σ (s_k + m_k d),   I_l = I + m |c − p_l|² + Σ (I_k + 2 d·s_k + m_k |d|²),   d = p_k − p_l
//! M(l, k) = I_k + (p_k − p_l)·s_k  for k in the branch of l,  else 0
//! M(x, x) = M(y, y) = m_1,   M(x, l) = −s_l,y,   M(y, l) = s_l,x
//! h(l) = g s_l,x,   h(y) = g m_1
//! J(l) = e_z × (x − p_l)  for a point x of the branch of l,  else 0
//! ```
//!
//! The sums run over the children k of l. Each link is turned by one coordinate: that of its joint, or θ.

use nalgebra::Vector2;

use crate::body::chain::{Base, Chain, JointKind};
use crate::body::contact::direction;
use crate::body::fields::{ContactRows, MechanismFields};
use crate::body::holding::HoldingChoice;
use crate::body::mechanism::Mechanism;
use crate::error::{Error, finite};
use crate::math::unsigned_zero::UnsignedZero;

/// Where the links and feet of a chain are, for pictures. World axes, in m.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainPoints {
    /// The near and the far end of each link.
    pub links: Vec<[[f64; 2]; 2]>,
    /// The points in which the feet touch the ground.
    pub feet: Vec<[f64; 2]>,
}

/// A link in its place, and its branch.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    parent: Option<usize>,
    /// The near end p_l.
    pub(super) near: Vector2<f64>,
    /// The unit vector of its axis.
    axis: Vector2<f64>,
    pub(super) mass: f64,
    pub(super) moment: Vector2<f64>,
    pub(super) inertia: f64,
}

impl Chain {
    /// The mechanism of this chain at a configuration: M, the load Bτ − h and the rows of the feet. Locked joints are its locked
    /// coordinates; armature is in [`MechanismFields::armature`].
    ///
    /// ```
    /// use standfast::body::{Base, Chain, ChainFields, Foot, Joint, Link};
    ///
    /// // A uniform rod of 3 kg and 2 m on a hinge, horizontal: M = mL²/3, h = mgL/2.
    /// let arm = Chain::new(ChainFields {
    ///     base: Base::Pinned,
    ///     links: vec![Link::uniform(3.0, 2.0)],
    ///     joints: vec![Joint { torque: 1.0, ..Joint::torque() }],
    ///     feet: vec![Foot { slope: 0.3, ..Foot::of_link(1) }],
    ///     gravity: 10.0,
    ///     ..ChainFields::default()
    /// })?;
    /// // One hinge cannot move its end along and into the ground independently: this is no mechanism for contacts.
    /// assert!(arm.mechanism(&[0.0]).is_err());
    /// assert_eq!(arm.bias(&[0.0])?, [30.0]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// `q` of another length than [`Chain::dof`], not finite, or with angles beyond ±2π; the errors of [`Mechanism::new`], such as a mass
    /// matrix that is not positive definite; no feet.
    pub fn mechanism(&self, q: &[f64]) -> Result<Mechanism, Error> {
        let given = self.torque_joints().map(|k| self.fields().joints[k].torque);
        self.mechanism_under(q, &given.collect::<Vec<_>>())
    }

    /// As [`mechanism`](Self::mechanism), with torques of [`holding_torques`](Self::holding_torques) on all feet. If no torques hold the chain, they are zero, and the
    /// mechanism is not in equilibrium.
    ///
    /// # Errors
    ///
    /// As [`mechanism`](Self::mechanism).
    pub fn mechanism_held(&self, q: &[f64], choice: HoldingChoice) -> Result<Mechanism, Error> {
        let held = self.holding_torques(q, None, choice)?;
        let torques = held.map_or_else(|| vec![0.0; self.torque_joints().count()], |h| h.torques);
        self.mechanism_under(q, &torques)
    }

    /// As [`mechanism`](Self::mechanism), with these torques of the joints of kind [`JointKind::Torque`], in their order, in N m, instead of their own.
    ///
    /// # Errors
    ///
    /// As [`mechanism`](Self::mechanism), and another number of torques.
    pub fn mechanism_under(&self, q: &[f64], torques: &[f64]) -> Result<Mechanism, Error> {
        let count = self.torque_joints().count();
        if torques.len() != count {
            return Err(Error::Unusable {
                field: "torques".into(),
                value: format!("[{} entries]", torques.len()),
                allowed: format!("one entry for each of the {count} joints with a torque"),
            });
        }
        for (k, value) in torques.iter().enumerate() {
            finite(format_args!("torques.{k}"), *value)?;
        }
        let placed = self.placed(q)?;
        if self.fields().feet.is_empty() {
            return Err(Error::Unusable {
                field: "feet".into(),
                value: "[0 feet]".into(),
                allowed: "at least one foot for a mechanism with contacts".into(),
            });
        }
        let mut load: Vec<f64> = self.bias_of(&placed).iter().map(|h| -h).collect();
        let (mut locked, mut armature) = (Vec::new(), Vec::new());
        for (k, torque) in self.torque_joints().zip(torques) {
            load[self.coordinate(k)] += torque;
        }
        for (k, joint) in self.fields().joints.iter().enumerate() {
            if joint.kind == JointKind::Locked {
                locked.push(self.coordinate(k));
            }
            if joint.armature != 0.0 {
                armature.resize(self.dof(), 0.0);
                armature[self.coordinate(k)] = joint.armature;
            }
        }
        let contacts = self.rows(&placed);
        Mechanism::new(MechanismFields {
            mass_matrix: self.mass_matrix(&placed),
            load,
            contacts,
            restitution: self.fields().restitution,
            locked,
            armature,
            ..MechanismFields::default()
        })
    }

    /// The bias h(q, 0) (dof): the generalised forces that hold the chain against gravity, in N or N m. They are the gradient of its
    /// potential energy.
    ///
    /// # Errors
    ///
    /// Those of [`Chain::mechanism`] about `q`; values that overflow.
    pub fn bias(&self, q: &[f64]) -> Result<Vec<f64>, Error> {
        let bias = self.bias_of(&self.placed(q)?);
        for (k, value) in bias.iter().enumerate() {
            finite(format_args!("bias.{k}"), *value)?;
        }
        Ok(bias.unsigned_zero())
    }

    /// The ends of the links and the points of the feet.
    ///
    /// # Errors
    ///
    /// Those of [`Chain::mechanism`] about `q`.
    pub fn points(&self, q: &[f64]) -> Result<ChainPoints, Error> {
        let placed = self.placed(q)?;
        let end = |at: &Placed, length: f64| -> [f64; 2] {
            <[f64; 2]>::from(at.near + at.axis * length).unsigned_zero()
        };
        let links = placed.iter().zip(&self.fields().links);
        let feet = (0..self.fields().feet.len()).map(|foot| self.foot(&placed, foot));
        Ok(ChainPoints {
            links: links
                .map(|(at, link)| [0.0, link.length].map(|length| end(at, length)))
                .collect(),
            feet: feet.map(|point| <[f64; 2]>::from(point).unsigned_zero()).collect(),
        })
    }

    /// The centre of mass of all links, in m.
    ///
    /// # Errors
    ///
    /// Those of [`Chain::mechanism`] about `q`.
    pub fn center_of_mass(&self, q: &[f64]) -> Result<[f64; 2], Error> {
        let placed = self.placed(q)?;
        Ok(<[f64; 2]>::from(placed[0].near + placed[0].moment / placed[0].mass).unsigned_zero())
    }

    /// The links in their places, with their branches.
    pub(super) fn placed(&self, q: &[f64]) -> Result<Vec<Placed>, Error> {
        self.check(q)?;
        let fields = self.fields();
        let first = self.first_angle();
        let mut placed: Vec<Placed> = Vec::with_capacity(fields.links.len());
        let mut angles: Vec<f64> = Vec::with_capacity(fields.links.len());
        for (l, link) in fields.links.iter().enumerate() {
            let joint = self.joint_of(l);
            let parent = self.parent_of(l);
            let (near, before) = match (parent, fields.base) {
                (Some(k), _) => {
                    let at = joint.and_then(|joint| joint.at).unwrap_or(fields.links[k].length);
                    (placed[k].near + placed[k].axis * at, angles[k])
                }
                (None, Base::Floating) => (Vector2::new(q[0], q[1]), 0.0),
                (None, Base::Pinned) => (Vector2::zeros(), 0.0),
            };
            let angle = before + joint.map_or(0.0, |joint| joint.angle) + q[first + l];
            let axis = direction(angle);
            let moment = axis * (link.mass * link.center());
            let inertia = link.inertia + link.mass * link.center() * link.center();
            angles.push(angle);
            placed.push(Placed { parent, near, axis, mass: link.mass, moment, inertia });
        }
        // From the leaves: a link comes after its parent.
        for k in (1..placed.len()).rev() {
            let branch = placed[k];
            let Some(l) = branch.parent else { continue };
            let d = branch.near - placed[l].near;
            placed[l].mass += branch.mass;
            placed[l].moment += branch.moment + d * branch.mass;
            placed[l].inertia +=
                branch.inertia + 2.0 * d.dot(&branch.moment) + branch.mass * d.norm_squared();
        }
        Ok(placed)
    }

    fn mass_matrix(&self, placed: &[Placed]) -> Vec<Vec<f64>> {
        let first = self.first_angle();
        let mut m = vec![vec![0.0; self.dof()]; self.dof()];
        if self.fields().base == Base::Floating {
            (m[0][0], m[1][1]) = (placed[0].mass, placed[0].mass);
            for (l, branch) in placed.iter().enumerate() {
                for (axis, value) in [(0, -branch.moment.y), (1, branch.moment.x)] {
                    (m[axis][first + l], m[first + l][axis]) = (value, value);
                }
            }
        }
        for (k, branch) in placed.iter().enumerate() {
            let mut above = Some(k);
            while let Some(l) = above {
                let value = branch.inertia + (branch.near - placed[l].near).dot(&branch.moment);
                (m[first + l][first + k], m[first + k][first + l]) = (value, value);
                above = placed[l].parent;
            }
        }
        m
    }

    /// h(q, 0).
    pub(super) fn bias_of(&self, placed: &[Placed]) -> Vec<f64> {
        let g = self.fields().gravity;
        let translation = match self.fields().base {
            Base::Floating => vec![0.0, g * placed[0].mass],
            Base::Pinned => Vec::new(),
        };
        translation.into_iter().chain(placed.iter().map(|branch| g * branch.moment.x)).collect()
    }

    /// Where a foot, counted from 0, touches the ground: its point, or the point of the disc about it that is lowest over the ground.
    pub(super) fn foot(&self, placed: &[Placed], foot: usize) -> Vector2<f64> {
        let foot = &self.fields().feet[foot];
        let (at, link) = (&placed[foot.link - 1], &self.fields().links[foot.link - 1]);
        let center = at.near + at.axis * foot.at.unwrap_or(link.length);
        if foot.radius == 0.0 {
            return center;
        }
        let tangent = direction(foot.slope);
        center - Vector2::new(-tangent.y, tangent.x) * foot.radius
    }

    /// N = nᵀJ and T = tᵀJ of the feet.
    pub(super) fn rows(&self, placed: &[Placed]) -> Vec<ContactRows> {
        let first = self.first_angle();
        let row = |(k, foot): (usize, &super::Foot)| {
            let point = self.foot(placed, k);
            let tangent = direction(foot.slope);
            let normal = Vector2::new(-tangent.y, tangent.x);
            let along = |axis: Vector2<f64>| {
                let mut row = vec![0.0; self.dof()];
                if self.fields().base == Base::Floating {
                    (row[0], row[1]) = (axis.x, axis.y);
                }
                let mut above = Some(foot.link - 1);
                while let Some(l) = above {
                    // axis·(e_z × (x − p_l)) = (x − p_l) × axis
                    row[first + l] = (point - placed[l].near).perp(&axis);
                    above = placed[l].parent;
                }
                row
            };
            ContactRows {
                normal: along(normal),
                tangential: along(tangent),
                friction: foot.friction,
                restitution: foot.restitution,
                tangential_restitution: foot.tangential_restitution,
            }
        };
        self.fields().feet.iter().enumerate().map(row).collect()
    }
}
