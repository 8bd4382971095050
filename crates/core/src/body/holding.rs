//! The torques and contact forces that can hold a mechanism, or a chain, at rest.
//!
//! In the coordinates that are not locked
//!
//! ```text
//! B τ + Σ_i (T_iᵀ f_t,i + N_iᵀ f_n,i) = h,     |f_t,i| ≤ μ_i f_n,i
//! ```
//!
//! Each joint with a torque has one equation, which gives its torque: τ_k = h_k − Σ_i (T_i,k f_t,i + N_i,k f_n,i). The other equations
//! are those of the *base*. With forces f = Σ a_u u on the edges u = (±μ, 1) of the cones, a ≥ 0, the extremes of each torque and
//! force are linear programmes.
//!
//! *The family* of (τ, f) that satisfy the equations, whatever the cones, has the dimension of the f that the base does not feel.
//! A contact without friction has no f_t in it.
//!
//! *The choice.* If there is one internal force, with a bounded interval, its middle may be chosen. The least torques are those with the least
//! |τ|² within the cones, which are unique; the forces are then those with the least |f|² of all that need these torques. Both are least
//! squares in the a ≥ 0. If all torques are moments, no unit of length has an effect on this choice.

use serde::{Deserialize, Serialize};

use crate::body::chain::{Chain, JointKind};
use crate::body::fields::ContactRows;
use crate::body::mechanism::Mechanism;
use crate::error::Error;
use crate::math::active_set::{Row, Sign, least_square};
use crate::math::orthonormal::{add_scaled, complement, dot};
use crate::math::simplex::maximise;
use crate::math::unsigned_zero::UnsignedZero;
use crate::serial::shown_as_written;
use crate::tolerance::{INTERNAL_COMPONENT, UNBOUNDED_DIRECTION};

/// Which of the torques that hold a mechanism are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HoldingChoice {
    /// The middle of the interval of the internal force, if there is one internal force and its interval is bounded; otherwise as [`Least`](Self::Least).
    #[default]
    Middle,
    /// The least Σ τ² within the friction cones, and with them the forces with the least Σ f². They often put a contact on the border of
    /// its cone.
    Least,
}

shown_as_written!(HoldingChoice);

/// The torques of joints and the forces of contacts that hold a mechanism at rest. Forces are (tangential, normal), in N; torques in N m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HoldingTorques {
    /// The joints with a torque, in the order of all torques here: of a chain their numbers, from 1; of a mechanism their coordinates, from 0.
    pub joints: Vec<usize>,
    /// Numbers of the contacts that carry forces, from 1: the order of all forces here.
    pub contacts: Vec<usize>,
    /// The torques chosen.
    pub torques: Vec<f64>,
    /// The forces of this solution.
    pub forces: Vec<[f64; 2]>,
    /// Least and largest torque of each joint within the cones; −∞ and ∞ where there is no bound.
    pub torque_interval: Vec<[f64; 2]>,
    /// Least force of each contact within the cones; −∞ where there is no bound.
    pub force_low: Vec<[f64; 2]>,
    /// Largest force of each contact within the cones; ∞ where there is no bound.
    pub force_high: Vec<[f64; 2]>,
    /// Dimension of the family of (τ, f) that satisfy the equations, whatever the cones. A contact without friction has a normal force only.
    pub freedom: usize,
    /// If this dimension is one: the interval of the s for which (τ₀, f₀) + s·(τ₁, f₁) lies in the cones; −∞ and ∞ where there is no
    /// bound.
    pub internal_force: Option<[f64; 2]>,
    /// τ₀: the least torques without cones.
    pub free_torques: Vec<f64>,
    /// f₀: their least forces.
    pub free_forces: Vec<[f64; 2]>,
    /// τ₁ of the vector (τ₁, f₁) in which such a family extends, with |τ₁| = 1, or with |f₁| = 1 if the torques are the same in all of the family. Its
    /// first component that is not zero is positive. Empty unless the dimension is one.
    pub internal_torques: Vec<f64>,
    /// f₁ of this vector.
    pub internal_forces: Vec<[f64; 2]>,
}

/// An edge of a friction cone, or an axis of the force: the contact (its position in the choice), the unit force (tangential, normal), and its
/// generalised force.
struct Edge {
    contact: usize,
    force: [f64; 2],
    column: Vec<f64>,
}

impl Mechanism {
    /// The torques of `joints`, coordinates from 0, to be added to the load, and the forces that hold the mechanism without motion; `None` if there are
    /// none. With the load −h these are the torques τ of the joints. The other coordinates that are not locked have no torques. `contacts`: numbers of
    /// the contacts that carry forces, from 1; `None`: all.
    ///
    /// ```
    /// use standfast::body::{ContactRows, HoldingChoice, Mechanism, MechanismFields};
    ///
    /// // A body of 2 kg on its foot, without rotation, and a lift of 1 kg on it that a motor holds: the weight is 30 N, that of the lift 10 N.
    /// let foot = ContactRows { normal: vec![0.0, 1.0, 0.0], tangential: vec![1.0, 0.0, 0.0], ..ContactRows::default() };
    /// let lift = Mechanism::new(MechanismFields {
    ///     mass_matrix: vec![vec![3.0, 0.0, 0.0], vec![0.0, 3.0, 1.0], vec![0.0, 1.0, 1.0]],
    ///     load: vec![0.0, -30.0, -10.0],
    ///     contacts: vec![foot],
    ///     ..MechanismFields::default()
    /// })?;
    /// let held = lift.holding_torques(&[2], None, HoldingChoice::Least)?.expect("it is held");
    /// assert_eq!((held.torques, held.forces), (vec![10.0], vec![[0.0, 30.0]]));
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `joints` (no coordinate, locked, or twice the same) or `contacts` (no contact, or twice the same).
    pub fn holding_torques(
        &self,
        joints: &[usize],
        contacts: Option<&[usize]>,
        choice: HoldingChoice,
    ) -> Result<Option<HoldingTorques>, Error> {
        let locked = &self.fields().locked;
        let dof = self.dof();
        let wrong = |(k, c): (usize, &usize)| {
            let why = if *c >= dof {
                "there is no coordinate"
            } else if locked.contains(c) {
                "locked is coordinate"
            } else if joints[..k].contains(c) {
                "twice there is coordinate"
            } else {
                return None;
            };
            Some(format!("{why} {c}"))
        };
        if let Some(why) = joints.iter().enumerate().find_map(wrong) {
            return Err(Error::Unusable {
                field: "joints".into(),
                value: format!("{joints:?}"),
                allowed: format!(
                    "different coordinates that are not locked, from 0 to {}; {why}",
                    dof - 1
                ),
            });
        }
        let chosen = chosen("contacts", contacts, self.contacts().len())?;
        let rows = chosen.iter().map(|number| &self.contacts()[number - 1]).collect();
        let base = (0..dof).filter(|c| !locked.contains(c) && !joints.contains(c)).collect();
        let bias = self.fields().load.iter().map(|load| -load).collect();
        let joints = joints.iter().map(|&c| (c, c)).collect();
        Ok(Question::new(joints, base, bias, rows).answer(chosen, choice))
    }
}

impl Chain {
    /// The torques and forces that hold the chain at a configuration without motion; `None` if there are none. `contacts`: numbers of the
    /// feet that carry forces, from 1; `None`: all.
    ///
    /// ```
    /// use standfast::body::{Base, Chain, ChainFields, HoldingChoice, Joint, Link};
    ///
    /// // An arm of two uniform rods of 1 m and 1 kg, stretched out: the joints hold mg(1/2 + 3/2) and mg/2.
    /// let arm = Chain::new(ChainFields {
    ///     base: Base::Pinned,
    ///     links: vec![Link::uniform(1.0, 1.0); 2],
    ///     joints: vec![Joint::torque(); 2],
    ///     gravity: 10.0,
    ///     ..ChainFields::default()
    /// })?;
    /// let held = arm.holding_torques(&[0.0, 0.0], None, HoldingChoice::Least)?.expect("an arm can be held");
    /// assert_eq!((held.torques, held.freedom), (vec![20.0, 5.0], 0));
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Those of [`Chain::bias`]; a contact that is no foot, or twice the same.
    pub fn holding_torques(
        &self,
        q: &[f64],
        contacts: Option<&[usize]>,
        choice: HoldingChoice,
    ) -> Result<Option<HoldingTorques>, Error> {
        let bias = self.bias(q)?;
        let chosen = chosen("feet", contacts, self.fields().feet.len())?;
        let all = self.rows(&self.placed(q)?);
        let rows = chosen.iter().map(|number| &all[number - 1]).collect();
        let joints = self.torque_joints().map(|k| (k + 1, self.coordinate(k))).collect();
        let base = (0..self.dof() - self.fields().joints.len()).collect();
        Ok(Question::new(joints, base, bias, rows).answer(chosen, choice))
    }

    /// The joints with a torque, from 0.
    pub(super) fn torque_joints(&self) -> impl Iterator<Item = usize> {
        let joints = self.fields().joints.iter().enumerate();
        joints.filter(|(_, joint)| joint.kind == JointKind::Torque).map(|(k, _)| k)
    }
}

/// The contacts chosen, from 1, of this number of contacts that are called so.
fn chosen(called: &str, contacts: Option<&[usize]>, count: usize) -> Result<Vec<usize>, Error> {
    let Some(chosen) = contacts else { return Ok((1..=count).collect()) };
    let wrong = |(k, number): (usize, &usize)| {
        !(1..=count).contains(number) || chosen[..k].contains(number)
    };
    if chosen.iter().enumerate().any(wrong) {
        return Err(Error::Unusable {
            field: "contacts".into(),
            value: format!("{chosen:?}"),
            allowed: match count {
                0 => format!("none, because there are no {called}"),
                _ => format!("different {called}, from 1 to {count}"),
            },
        });
    }
    Ok(chosen.to_vec())
}

/// The equations, with the units of the programmes.
struct Question<'a> {
    /// The joints with a torque: their names in the answer, and their coordinates.
    joints: Vec<(usize, usize)>,
    /// The coordinates without a torque.
    base: Vec<usize>,
    bias: Vec<f64>,
    rows: Vec<&'a ContactRows>,
    /// A unit of the velocity of a contact per unit of each coordinate: 1 or a length.
    units: Vec<f64>,
    /// A unit of force.
    force: f64,
}

impl<'a> Question<'a> {
    fn new(
        joints: Vec<(usize, usize)>,
        base: Vec<usize>,
        bias: Vec<f64>,
        rows: Vec<&'a ContactRows>,
    ) -> Self {
        let largest = |c: usize| {
            let entries = rows.iter().flat_map(|row| [row.normal[c], row.tangential[c]]);
            entries.map(f64::abs).fold(0.0, f64::max)
        };
        let or_one = |value: f64| if value > 0.0 { value } else { 1.0 };
        let units: Vec<f64> = (0..bias.len()).map(|c| or_one(largest(c))).collect();
        let felt = base.iter().copied().chain(joints.iter().map(|(_, c)| *c));
        let force = or_one(felt.map(|c| (bias[c] / units[c]).abs()).fold(0.0, f64::max));
        Self { joints, base, bias, rows, units, force }
    }

    fn answer(&self, contacts: Vec<usize>, choice: HoldingChoice) -> Option<HoldingTorques> {
        let edges = self.edges();
        let balance = self.equations(&self.base, &edges);
        let weights = maximise(&balance, &vec![0.0; edges.len()])?;
        let mut unloaded: Vec<Row> = balance.iter().map(|(row, _)| (row.clone(), 0.0)).collect();
        unloaded.push((vec![1.0; edges.len()], 1.0));
        // The largest sum of a_u times these values, in units of force.
        let most = |values: &[f64]| {
            if maximise(&unloaded, values).is_some_and(|a| dot(&a, values) > UNBOUNDED_DIRECTION) {
                return f64::INFINITY;
            }
            maximise(&balance, values).map_or(f64::NAN, |a| dot(&a, values) * self.force)
        };
        let range = |values: Vec<f64>| {
            let opposite: Vec<f64> = values.iter().map(|value| -value).collect();
            let [low, high] = [-most(&opposite), most(&values)];
            // Rounding may exchange the ends of an interval that is a point.
            if low <= high { [low, high] } else { [high, low] }
        };
        let torque_interval = self.joints.iter().map(|&(_, c)| {
            let unit = self.units[c];
            let [low, high] = range(edges.iter().map(|edge| -edge.column[c] / unit).collect());
            [low, high].map(|value| self.bias[c] + unit * value)
        });
        let force = |contact: usize, axis: usize| {
            range(
                edges
                    .iter()
                    .map(|e| if e.contact == contact { e.force[axis] } else { 0.0 })
                    .collect(),
            )
        };
        let forces: Vec<[[f64; 2]; 2]> =
            (0..self.rows.len()).map(|contact| [force(contact, 0), force(contact, 1)]).collect();
        let side =
            |k: usize| forces.iter().map(|[t, n]| [t[k], n[k]]).collect::<Vec<_>>().unsigned_zero();

        let axes = self.axes();
        let found = self.sum(&edges, &weights);
        let start: Vec<f64> = axes.iter().map(|axis| axis.part(&found)).collect();
        let free_forces = self.least(&axes, &start, Sign::Any);
        let base: Vec<Vec<f64>> =
            self.equations(&self.base, &axes).into_iter().map(|(row, _)| row).collect();
        let internal = complement(&base, axes.len());
        // Of one internal force: its unit vector, and the interval within the cones.
        let line = match &internal[..] {
            [direction] => Some(self.line(&self.sum(&axes, direction), &free_forces)),
            _ => None,
        };
        let middle = match &line {
            Some(([low, high], line)) if choice == HoldingChoice::Middle => {
                let middle = 0.5 * (low + high);
                let at =
                    |k: usize| [0, 1].map(|axis| free_forces[k][axis] + middle * line[k][axis]);
                middle.is_finite().then(|| (0..line.len()).map(at).collect())
            }
            _ => None,
        };
        let held = middle.unwrap_or_else(|| self.least(&edges, &weights, Sign::NotNegative));
        let (internal_force, internal_forces) = line.unzip();
        let internal_forces = internal_forces.unwrap_or_default();
        let internal_torques: Vec<f64> = match internal_force {
            Some(_) => self.moments(&internal_forces).iter().map(|moment| -moment).collect(),
            None => Vec::new(),
        };
        Some(HoldingTorques {
            joints: self.joints.iter().map(|(name, _)| *name).collect(),
            contacts,
            torques: self.torques(&held),
            forces: held.unsigned_zero(),
            torque_interval: torque_interval.collect::<Vec<_>>().unsigned_zero(),
            force_low: side(0),
            force_high: side(1),
            freedom: internal.len(),
            internal_force: internal_force.unsigned_zero(),
            free_torques: self.torques(&free_forces),
            free_forces: free_forces.unsigned_zero(),
            internal_torques: internal_torques.unsigned_zero(),
            internal_forces: internal_forces.unsigned_zero(),
        })
    }

    /// The one internal force with these forces, as [`HoldingTorques::internal_forces`] has it, and its interval from the least forces without
    /// cones.
    fn line(&self, direction: &[[f64; 2]], free: &[[f64; 2]]) -> ([f64; 2], Vec<[f64; 2]>) {
        let moments = self.moments(direction);
        let size = dot(&moments, &moments).sqrt();
        let unit = if size > INTERNAL_COMPONENT * self.longest() { size } else { 1.0 };
        let all = moments.iter().map(|moment| -moment).chain(direction.iter().flatten().copied());
        let first = all.map(|x| x / unit).find(|x| x.abs() > INTERNAL_COMPONENT);
        let along = if first.is_some_and(|x| x < 0.0) { -unit } else { unit };
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for ((row, force), change) in self.rows.iter().zip(free).zip(direction) {
            for side in sides(row) {
                let inward = [*side, if row.friction == 0.0 { 1.0 } else { row.friction }];
                let length = libm::hypot(inward[0], inward[1]);
                let [bound, slope] = [force, change].map(|f| dot(&inward, f) / length);
                if slope > UNBOUNDED_DIRECTION {
                    low = low.max(-bound / slope);
                } else if slope < -UNBOUNDED_DIRECTION {
                    high = high.min(-bound / slope);
                }
            }
        }
        // Some forces hold the mechanism: rounding has exchanged the ends of an interval that is a point.
        if low > high {
            [low, high] = [0.5 * (low + high); 2];
        }
        let interval = [low * along, high * along];
        let interval = if along < 0.0 { [interval[1], interval[0]] } else { interval };
        (interval, direction.iter().map(|force| force.map(|part| part / along)).collect())
    }

    /// The largest unit of a joint: a unit of torque per unit of force.
    fn longest(&self) -> f64 {
        self.joints.iter().map(|(_, c)| self.units[*c]).fold(0.0, f64::max)
    }

    fn edge(&self, contact: usize, force: [f64; 2]) -> Edge {
        let mut column = vec![0.0; self.bias.len()];
        add_scaled(&mut column, &self.rows[contact].tangential, force[0]);
        add_scaled(&mut column, &self.rows[contact].normal, force[1]);
        Edge { contact, force, column }
    }

    /// The edges of all cones.
    fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (contact, row) in self.rows.iter().enumerate() {
            for side in sides(row) {
                let length = libm::hypot(row.friction, 1.0);
                edges.push(self.edge(contact, [side * row.friction / length, 1.0 / length]));
            }
        }
        edges
    }

    /// The axes of all forces: tangential, if there is friction, and normal.
    fn axes(&self) -> Vec<Edge> {
        let mut axes = Vec::new();
        for (contact, row) in self.rows.iter().enumerate() {
            if row.friction > 0.0 {
                axes.push(self.edge(contact, [1.0, 0.0]));
            }
            axes.push(self.edge(contact, [0.0, 1.0]));
        }
        axes
    }

    /// The equations of these coordinates without torques, Σ a_u column_u = h, in units of force.
    fn equations(&self, coordinates: &[usize], edges: &[Edge]) -> Vec<Row> {
        let equation = |&c: &usize| {
            let unit = self.units[c];
            let row = edges.iter().map(|edge| edge.column[c] / unit).collect();
            (row, self.bias[c] / (unit * self.force))
        };
        coordinates.iter().map(equation).collect()
    }

    /// The forces of the least |τ|², and of these the ones of the least |f|². `start`: multiples of the edges, in units of force, that hold the
    /// mechanism.
    fn least(&self, edges: &[Edge], start: &[f64], sign: Sign) -> Vec<[f64; 2]> {
        let mut rows = self.equations(&self.base, edges);
        let joints: Vec<usize> = self.joints.iter().map(|(_, c)| *c).collect();
        let mut torques = self.equations(&joints, edges);
        let longest = self.longest();
        let weighted = torques.iter().zip(&joints).map(|((row, bias), c)| {
            let weight = self.units[*c] / longest;
            (row.iter().map(|value| value * weight).collect(), bias * weight)
        });
        let least = least_square(&rows, &weighted.collect::<Vec<_>>(), start, sign);
        torques.iter_mut().for_each(|(row, bias)| *bias = dot(row, &least));
        rows.extend(torques);
        let forces: Vec<Row> = (0..self.rows.len())
            .flat_map(|contact| [(contact, 0), (contact, 1)])
            .map(|(contact, axis)| {
                let part =
                    |edge: &Edge| if edge.contact == contact { edge.force[axis] } else { 0.0 };
                (edges.iter().map(part).collect(), 0.0)
            })
            .collect();
        let least = least_square(&rows, &forces, &least, sign);
        let scaled: Vec<f64> = least.iter().map(|part| part * self.force).collect();
        self.sum(edges, &scaled)
    }

    /// The forces of these multiples of edges.
    fn sum(&self, edges: &[Edge], parts: &[f64]) -> Vec<[f64; 2]> {
        let mut forces = vec![[0.0; 2]; self.rows.len()];
        for (edge, part) in edges.iter().zip(parts) {
            for axis in [0, 1] {
                forces[edge.contact][axis] += edge.force[axis] * part;
            }
        }
        forces
    }

    /// The generalised forces of these forces in the coordinates of the joints.
    fn moments(&self, forces: &[[f64; 2]]) -> Vec<f64> {
        let moment = |c: usize| {
            let parts = self.rows.iter().zip(forces);
            parts.map(|(row, [t, n])| row.tangential[c] * t + row.normal[c] * n).sum()
        };
        self.joints.iter().map(|&(_, c)| moment(c)).collect()
    }

    /// The torques that these forces need.
    fn torques(&self, forces: &[[f64; 2]]) -> Vec<f64> {
        let moments = self.moments(forces);
        let torque = |(&(_, c), moment): (&(usize, usize), &f64)| self.bias[c] - moment;
        self.joints.iter().zip(&moments).map(torque).collect::<Vec<_>>().unsigned_zero()
    }
}

impl Edge {
    /// The part of an axis in forces.
    fn part(&self, forces: &[[f64; 2]]) -> f64 {
        dot(&self.force, &forces[self.contact])
    }
}

/// The signs of f_t on the edges of a cone.
fn sides(row: &ContactRows) -> &'static [f64] {
    if row.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] }
}
