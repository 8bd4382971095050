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
//! *The family* of forces that satisfy the equations of the base is f₀ + D y with orthonormal columns D; the torques follow, τ = τ₀ + E y.
//! A contact without friction has no f_t in it.
//!
//! *The choice.* If there is one internal force, with a bounded interval, its middle may be chosen. The least torques are those with the least
//! |τ|² within the cones, which are unique; the forces are then those with the least |f|². If all torques are moments, no unit of length has an effect on this choice. A shift of y to the nearest point of τ₀ + E y to zero, and a rotation that
//! separates the directions u of y which change the torques from the others v, leave the problem min |u|² subject to G (u, v) ≥ g. It is solved by
//! proximal steps, min |u|² + ε²|v − v_before|²: u converges by a factor ε² a step. Where many sides of cones meet in one point, as at a contact
//! without force, rounding may hide the least torques; those that are given then hold the mechanism, and are not the least.

use serde::{Deserialize, Serialize};

use crate::body::chain::{Chain, JointKind};
use crate::body::fields::ContactRows;
use crate::body::mechanism::Mechanism;
use crate::error::Error;
use crate::math::least_distance::{nearest, nearest_on};
use crate::math::orthonormal::{add_scaled, complement, dot, factors};
use crate::math::simplex::maximise;
use crate::math::unsigned_zero::UnsignedZero;
use crate::serial::shown_as_written;
use crate::tolerance::{
    CONE_MISS, CONE_SLACK, DEPENDENT_ROW, INTERNAL_COMPONENT, ROW_SHIFTS, UNBOUNDED_DIRECTION,
};

/// ε of the proximal steps. Any small number gives the same torques.
const PROXIMAL: f64 = 1.0 / 1024.0;

/// Largest number of proximal steps. Three are enough unless the joints are badly placed: the error of the torques is then about ε⁶ = 1e-18.
const PROXIMAL_STEPS: usize = 30;

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

/// An edge of a friction cone: the contact (its position in the choice), the unit force (tangential, normal), and its generalised force.
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
        let wrong =
            |(k, c): (usize, &usize)| *c >= dof || locked.contains(c) || joints[..k].contains(c);
        if joints.iter().enumerate().any(wrong) {
            return Err(Error::Unusable {
                field: "joints".into(),
                value: format!("{joints:?}"),
                allowed: format!(
                    "different coordinates that are not locked, from 0 to {}",
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

/// The solutions f₀ + D y and τ₀ + E y.
struct Family {
    /// (contact, 0 tangential or 1 normal) of each component of f.
    components: Vec<(usize, usize)>,
    /// f₀, the least Σ f² that satisfies the equations of the base.
    forces: Vec<f64>,
    /// The columns of D.
    directions: Vec<Vec<f64>>,
    /// The columns of E.
    torques: Vec<Vec<f64>>,
}

/// Rows G and bounds g of the friction cones in the coordinates y of a family: G y ≥ g.
struct Cones {
    rows: Vec<Vec<f64>>,
    bounds: Vec<f64>,
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
        // Equations of the base: Σ a_u column_u = h, and the same without load.
        let balance: Vec<(Vec<f64>, f64)> = self
            .base
            .iter()
            .map(|&c| {
                let unit = self.units[c];
                let row = edges.iter().map(|edge| edge.column[c] / unit).collect();
                (row, self.bias[c] / (unit * self.force))
            })
            .collect();
        let weights = maximise(&balance, &vec![0.0; edges.len()])?;
        let mut unloaded: Vec<(Vec<f64>, f64)> =
            balance.iter().map(|(row, _)| (row.clone(), 0.0)).collect();
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

        let mut start = vec![[0.0; 2]; self.rows.len()];
        for (edge, weight) in edges.iter().zip(&weights) {
            for axis in [0, 1] {
                start[edge.contact][axis] += edge.force[axis] * weight * self.force;
            }
        }
        let family = self.family(&start);
        let cones = self.cones(&family);
        let freedom = family.directions.len();
        let free = self.least(&family, &Cones { rows: Vec::new(), bounds: Vec::new() });
        let free_forces = family.at(&free);
        // Of one internal force: the line from the least solution without cones.
        let line = (freedom == 1).then(|| {
            let torque: Vec<f64> = family.torques[0].clone();
            let size = dot(&torque, &torque).sqrt();
            let unit = if size > INTERNAL_COMPONENT * self.longest() { size } else { 1.0 };
            let all = torque.iter().chain(&family.directions[0]);
            let first = all.map(|x| x / unit).find(|x| x.abs() > INTERNAL_COMPONENT);
            let along = if first.is_some_and(|x| x < 0.0) { -unit } else { unit };
            let [low, high] = cones.interval();
            let s = [low, high].map(|y| (y - free[0]) * along);
            (along, if along < 0.0 { [s[1], s[0]] } else { s })
        });
        let y = match line {
            Some(_) => {
                let [low, high] = cones.interval();
                let bounded = (high - low).is_finite();
                vec![if choice == HoldingChoice::Middle && bounded {
                    0.5 * (low + high)
                } else {
                    free[0].clamp(low, high)
                }]
            }
            None => {
                let least = self.least(&family, &cones);
                // Rounding may hide the least torques where many sides of cones meet. The forces found first hold the mechanism.
                if cones.contain(&least, self.force) { least } else { family.coordinates(&start) }
            }
        };
        let held = family.at(&y);
        let (internal_torques, internal_forces) = match line {
            Some((along, _)) => {
                let unit =
                    |column: &Vec<f64>| column.iter().map(|x| x / along).collect::<Vec<f64>>();
                let forces = unit(&family.directions[0]);
                (unit(&family.torques[0]).unsigned_zero(), self.paired(&family, &forces))
            }
            None => Default::default(),
        };
        Some(HoldingTorques {
            joints: self.joints.iter().map(|(name, _)| *name).collect(),
            contacts,
            torques: self.torques(&family, &held),
            forces: self.paired(&family, &held),
            torque_interval: torque_interval.collect::<Vec<_>>().unsigned_zero(),
            force_low: side(0),
            force_high: side(1),
            freedom,
            internal_force: line.map(|(_, interval)| interval).unsigned_zero(),
            free_torques: self.torques(&family, &free_forces),
            free_forces: self.paired(&family, &free_forces),
            internal_torques,
            internal_forces,
        })
    }

    /// The largest unit of a joint: a unit of torque per unit of force.
    fn longest(&self) -> f64 {
        self.joints.iter().map(|(_, c)| self.units[*c]).fold(0.0, f64::max)
    }

    fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (contact, row) in self.rows.iter().enumerate() {
            let sides: &[f64] = if row.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            for side in sides {
                let length = libm::hypot(row.friction, 1.0);
                let force = [side * row.friction / length, 1.0 / length];
                let mut column = vec![0.0; self.bias.len()];
                add_scaled(&mut column, &row.tangential, force[0]);
                add_scaled(&mut column, &row.normal, force[1]);
                edges.push(Edge { contact, force, column });
            }
        }
        edges
    }

    /// The family of solutions through these forces.
    fn family(&self, start: &[[f64; 2]]) -> Family {
        let components: Vec<(usize, usize)> = (0..self.rows.len())
            .flat_map(|contact| [(contact, 0), (contact, 1)])
            .filter(|&(contact, axis)| axis == 1 || self.rows[contact].friction > 0.0)
            .collect();
        let base: Vec<Vec<f64>> = self
            .base
            .iter()
            .map(|&c| components.iter().map(|of| self.entry(*of, c) / self.units[c]).collect())
            .collect();
        // Changes of the forces that the base does not feel, each with the torques that balance it.
        let directions = complement(&base, components.len());
        let torque = |f: &Vec<f64>| {
            self.joints.iter().map(|(_, c)| -self.moment(&components, f, *c)).collect()
        };
        let torques = directions.iter().map(torque).collect();
        let mut forces: Vec<f64> =
            components.iter().map(|&(contact, axis)| start[contact][axis]).collect();
        // f₀ is the least of all forces. Twice: the second time takes the rounding errors of the first away.
        for axis in directions.iter().chain(&directions) {
            let part = dot(axis, &forces);
            add_scaled(&mut forces, axis, -part);
        }
        Family { components, forces, directions, torques }
    }

    /// The y of the least |τ|² within the cones, and of these the one of the least |f|².
    fn least(&self, family: &Family, cones: &Cones) -> Vec<f64> {
        let count = family.directions.len();
        // y = U u + V v with orthonormal columns: the torques are those of u.
        let length = self.longest();
        let torque_rows: Vec<Vec<f64>> = (0..self.joints.len())
            .map(|k| family.torques.iter().map(|column| column[k] / length).collect::<Vec<f64>>())
            .map(|row| if dot(&row, &row).sqrt() > DEPENDENT_ROW { row } else { vec![0.0; count] })
            .collect();
        let v = complement(&torque_rows, count);
        let u = complement(&v, count);
        // τ/length = t₀ + Q R u: the least |τ| is that of the least R u + Qᵀt₀ = w.
        let changed: Vec<Vec<f64>> =
            u.iter().map(|axis| torque_rows.iter().map(|row| dot(row, axis)).collect()).collect();
        let (q, r) = factors(&changed);
        let first = self.torques(family, &family.forces);
        let first: Vec<f64> = first.iter().map(|x| x / length).collect();
        let shift: Vec<f64> = q.iter().map(|axis| dot(axis, &first)).collect();
        // Column k of the inverse of R, in y.
        let solve = |w: &[f64]| {
            let mut parts = w.to_vec();
            for k in (0..parts.len()).rev() {
                parts[k] /= r[k][k];
                let part = parts[k];
                for (i, above) in r[k][..k].iter().enumerate() {
                    parts[i] -= part * above;
                }
            }
            let mut y = vec![0.0; count];
            u.iter().zip(&parts).for_each(|(axis, part)| add_scaled(&mut y, axis, *part));
            y
        };
        let columns: Vec<Vec<f64>> = (0..u.len())
            .map(|k| {
                let mut unit = vec![0.0; u.len()];
                unit[k] = self.force;
                solve(&unit)
            })
            .collect();
        let opposite: Vec<f64> = shift.iter().map(|x| -x).collect();
        let origin = solve(&opposite);
        let place = |w: &[f64], z: &[f64]| {
            let mut y = origin.clone();
            columns.iter().zip(w).for_each(|(column, part)| add_scaled(&mut y, column, *part));
            v.iter().zip(z).for_each(|(axis, part)| add_scaled(&mut y, axis, *part));
            y
        };
        let mut z = vec![0.0; v.len()];
        let mut w = vec![0.0; u.len()];
        if cones.rows.is_empty() {
            return place(&w, &z);
        }
        let spare = |y: &[f64]| -> Vec<f64> {
            cones.rows.iter().zip(&cones.bounds).map(|(row, bound)| bound - dot(row, y)).collect()
        };
        let parts = |axes: &[Vec<f64>], scale: f64| -> Vec<Vec<f64>> {
            cones
                .rows
                .iter()
                .map(|row| axes.iter().map(|axis| dot(row, axis) * scale).collect())
                .collect()
        };
        let (felt, unfelt) = (parts(&columns, 1.0), parts(&v, self.force / PROXIMAL));
        let both: Vec<Vec<f64>> =
            felt.iter().zip(&unfelt).map(|(a, b)| [&a[..], &b[..]].concat()).collect();
        let none = vec![0.0; u.len()];
        // The rows that are equations at the least torques, whatever z is.
        let (mut on, mut before) = (Vec::new(), f64::INFINITY);
        for _ in 0..if u.is_empty() { 0 } else { PROXIMAL_STEPS } {
            let bounds = spare(&place(&none, &z));
            // Where more rows meet in a point than it has coordinates, small different shifts of the rows may separate them.
            let shifted = |part: f64| {
                let shift = |(k, bound): (usize, &f64)| {
                    bound - part * self.force * (1.0 + libm::sqrt(k as f64))
                };
                bounds.iter().enumerate().map(shift).collect::<Vec<f64>>()
            };
            let found = nearest_on(&both, &bounds)
                .or_else(|| ROW_SHIFTS.iter().find_map(|s| nearest_on(&both, &shifted(*s))));
            let Some((step, equations)) = found else { break };
            let (own, moved) = step.split_at(u.len());
            // The steps become smaller until rounding errors are all of them.
            let size = dot(moved, moved).sqrt();
            if size >= before {
                break;
            }
            before = size;
            on = equations;
            w = own.to_vec();
            for (part, step) in z.iter_mut().zip(moved) {
                *part += step * self.force / PROXIMAL;
            }
        }
        // z + (directions in which these rows do not change), as near to zero as the other rows allow.
        let unfelt = parts(&v, 1.0);
        let equations: Vec<Vec<f64>> = on.iter().map(|&k| unfelt[k].clone()).collect();
        let along = complement(&equations, v.len());
        let mut least = z.clone();
        for axis in along.iter().chain(&along) {
            let part = dot(axis, &least);
            add_scaled(&mut least, axis, -part);
        }
        let others = |k: &usize| !on.contains(k);
        let rows: Vec<Vec<f64>> = (0..unfelt.len())
            .filter(others)
            .map(|k| along.iter().map(|axis| dot(&unfelt[k], axis)).collect())
            .collect();
        let bounds = spare(&place(&w, &least));
        let bounds: Vec<f64> = (0..unfelt.len()).filter(others).map(|k| bounds[k]).collect();
        if let Some(moved) = nearest(&rows, &bounds) {
            along.iter().zip(&moved).for_each(|(axis, part)| add_scaled(&mut least, axis, *part));
            z = least;
        }
        // Forces that rounding errors have left outside of a cone go to its border.
        let mut y = place(&w, &z);
        let outside = spare(&y);
        if outside.iter().any(|miss| *miss > CONE_SLACK * self.force)
            && let Some(step) = nearest(&cones.rows, &outside)
        {
            add_scaled(&mut y, &step, 1.0);
        }
        y
    }

    /// The generalised force in a coordinate of a unit force.
    fn entry(&self, (contact, axis): (usize, usize), coordinate: usize) -> f64 {
        let row = self.rows[contact];
        if axis == 0 { row.tangential[coordinate] } else { row.normal[coordinate] }
    }

    /// The generalised force of these components of f in a coordinate.
    fn moment(&self, components: &[(usize, usize)], f: &[f64], coordinate: usize) -> f64 {
        components.iter().zip(f).map(|(of, value)| self.entry(*of, coordinate) * value).sum()
    }

    /// The torques that these forces need.
    fn torques(&self, family: &Family, f: &[f64]) -> Vec<f64> {
        let torque =
            |&(_, c): &(usize, usize)| self.bias[c] - self.moment(&family.components, f, c);
        self.joints.iter().map(torque).collect::<Vec<_>>().unsigned_zero()
    }

    /// Components of f as (tangential, normal) by contact.
    fn paired(&self, family: &Family, f: &[f64]) -> Vec<[f64; 2]> {
        let mut forces = vec![[0.0; 2]; self.rows.len()];
        for (&(contact, axis), value) in family.components.iter().zip(f) {
            forces[contact][axis] = *value;
        }
        forces.unsigned_zero()
    }

    fn cones(&self, family: &Family) -> Cones {
        let mut cones = Cones { rows: Vec::new(), bounds: Vec::new() };
        for (contact, row) in self.rows.iter().enumerate() {
            let sides: &[f64] = if row.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            for side in sides {
                let inward = [*side, if row.friction == 0.0 { 1.0 } else { row.friction }];
                let length = libm::hypot(inward[0], inward[1]);
                let inside = |f: &[f64]| {
                    let part = |(&(at, axis), value): (&(usize, usize), &f64)| {
                        if at == contact { inward[axis] * value } else { 0.0 }
                    };
                    family.components.iter().zip(f).map(part).sum::<f64>() / length
                };
                cones.rows.push(family.directions.iter().map(|d| inside(d)).collect());
                cones.bounds.push(-inside(&family.forces));
            }
        }
        cones
    }
}

impl Family {
    /// y of forces of the family.
    fn coordinates(&self, forces: &[[f64; 2]]) -> Vec<f64> {
        let moved: Vec<f64> = self
            .components
            .iter()
            .zip(&self.forces)
            .map(|(&(contact, axis), own)| forces[contact][axis] - own)
            .collect();
        self.directions.iter().map(|axis| dot(axis, &moved)).collect()
    }

    /// The forces f₀ + D y.
    fn at(&self, y: &[f64]) -> Vec<f64> {
        let mut f = self.forces.clone();
        for (axis, part) in self.directions.iter().zip(y) {
            add_scaled(&mut f, axis, *part);
        }
        f
    }
}

impl Cones {
    /// Returns true if forces are outside of no cone by more than rounding errors. `force`: the unit of force.
    fn contain(&self, y: &[f64], force: f64) -> bool {
        let size = force + dot(y, y).sqrt();
        let sides = self.rows.iter().zip(&self.bounds);
        y.iter().all(|part| part.is_finite())
            && sides.into_iter().all(|(row, bound)| bound - dot(row, y) <= CONE_MISS * size)
    }

    /// The interval of the one coordinate y. There is one, because some forces hold the chain; where it is a point, rounding may exchange its
    /// ends, and their mean is taken.
    fn interval(&self) -> [f64; 2] {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (row, bound) in self.rows.iter().zip(&self.bounds) {
            if row[0] > UNBOUNDED_DIRECTION {
                low = low.max(bound / row[0]);
            } else if row[0] < -UNBOUNDED_DIRECTION {
                high = high.min(bound / row[0]);
            }
        }
        if low <= high { [low, high] } else { [0.5 * (low + high); 2] }
    }
}
