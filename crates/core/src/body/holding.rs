//! The torques and contact forces that can hold a chain at rest.
//!
//! In the coordinates that are not locked
//!
//! ```text
//! B τ + Σ_i (T_iᵀ f_t,i + N_iᵀ f_n,i) = h,     |f_t,i| ≤ μ_i f_n,i
//! ```
//!
//! Each free joint has a torque, which its own equation gives: τ_k = h_k − Σ_i (T_i,k f_t,i + N_i,k f_n,i). The equations without a torque
//! are those of the floating base. With forces f = Σ a_u u on the edges u = (±μ, 1) of the cones, a ≥ 0, the extremes of each torque and
//! force are linear programmes.
//!
//! *The family* of (τ, f) that satisfy the equations is w₀ + D y with orthonormal columns D, where w₀ has the least norm:
//! |w|² = |w₀|² + |y|². So the least norm within the cones belongs to the y nearest to zero. A contact without friction has no f_t in it.

use serde::Serialize;

use crate::body::chain::{Chain, JointKind};
use crate::body::fields::ContactRows;
use crate::error::Error;
use crate::math::least_distance::nearest;
use crate::math::orthonormal::{add_scaled, complement, dot, factors};
use crate::math::simplex::maximise;
use crate::math::unsigned_zero::UnsignedZero;
use crate::tolerance::{INTERNAL_COMPONENT, UNBOUNDED_DIRECTION};

/// The torques of the free joints and the forces of contacts that hold a chain at rest. Forces are (tangential, normal), in N; torques in N m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HoldingTorques {
    /// Numbers of the joints with a torque, from 1: the order of all torques here.
    pub joints: Vec<usize>,
    /// Numbers of the contacts that carry forces, from 1: the order of all forces here.
    pub contacts: Vec<usize>,
    /// The torques of the solution with the least |τ|² + |f|² within the friction cones.
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
    /// τ₀: the torques of the solution with the least |τ|² + |f|² without cones.
    pub free_torques: Vec<f64>,
    /// f₀: its forces.
    pub free_forces: Vec<[f64; 2]>,
    /// τ₁ of the unit vector (τ₁, f₁) in which such a family extends; the first component of (τ₁, f₁) that is not zero is positive. Empty
    /// unless the dimension is one.
    pub internal_torques: Vec<f64>,
    /// f₁ of this unit vector.
    pub internal_forces: Vec<[f64; 2]>,
}

/// An edge of a friction cone: the contact (its position in the choice), the unit force (tangential, normal), and its generalised force.
struct Edge {
    contact: usize,
    force: [f64; 2],
    column: Vec<f64>,
}

impl Chain {
    /// The torques and forces that hold the chain at a configuration without motion; `None` if there are none. `contacts`: numbers of the
    /// feet that carry forces, from 1; `None`: all.
    ///
    /// ```
    /// use standfast::body::{Base, Chain, ChainFields, Joint, Link};
    ///
    /// // An arm of two uniform rods of 1 m and 1 kg, stretched out: the joints hold mg(1/2 + 3/2) and mg/2.
    /// let arm = Chain::new(ChainFields {
    ///     base: Base::Pinned,
    ///     links: vec![Link::uniform(1.0, 1.0); 2],
    ///     joints: vec![Joint::torque(); 2],
    ///     gravity: 10.0,
    ///     ..ChainFields::default()
    /// })?;
    /// let held = arm.holding_torques(&[0.0, 0.0], None)?.expect("an arm can be held");
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
    ) -> Result<Option<HoldingTorques>, Error> {
        let bias = self.bias(q)?;
        let placed = self.placed(q)?;
        let chosen = self.chosen(contacts)?;
        let all = self.rows(&placed);
        let rows: Vec<&ContactRows> = chosen.iter().map(|number| &all[number - 1]).collect();
        // Units of force and length, so that the programmes have numbers of order one.
        let weight =
            self.fields().gravity * self.fields().links.iter().map(|link| link.mass).sum::<f64>();
        let arms =
            chosen.iter().map(|number| (self.foot(&placed, number - 1) - placed[0].near).norm());
        let lengths = self.fields().links.iter().map(|link| link.length);
        let question = Question {
            joints: self.free_joints(),
            coordinates: self.dof(),
            base: self.dof() - self.fields().joints.len(),
            bias,
            rows,
            force: if weight > 0.0 { weight } else { 1.0 },
            length: arms.chain(lengths).fold(0.0, f64::max),
        };
        Ok(question.answer(chosen))
    }

    /// The feet chosen, from 1.
    fn chosen(&self, contacts: Option<&[usize]>) -> Result<Vec<usize>, Error> {
        let count = self.fields().feet.len();
        let Some(chosen) = contacts else { return Ok((1..=count).collect()) };
        let wrong = |(k, number): (usize, &usize)| {
            !(1..=count).contains(number) || chosen[..k].contains(number)
        };
        if chosen.iter().enumerate().any(wrong) {
            return Err(Error::Unusable {
                field: "contacts".into(),
                value: format!("{chosen:?}"),
                allowed: match count {
                    0 => "none, because the chain has no feet".into(),
                    _ => format!("different feet, from 1 to {count}"),
                },
            });
        }
        Ok(chosen.to_vec())
    }

    /// The joints with a torque, and their coordinates, both from 0.
    fn free_joints(&self) -> Vec<(usize, usize)> {
        let joints = self.fields().joints.iter().enumerate();
        joints
            .filter(|(_, joint)| joint.kind == JointKind::Torque)
            .map(|(k, _)| (k, self.coordinate(k)))
            .collect()
    }
}

/// The equations, with the units of the programmes.
struct Question<'a> {
    /// The joints with a torque and their coordinates.
    joints: Vec<(usize, usize)>,
    coordinates: usize,
    /// Number of coordinates of the floating base, which have no torque.
    base: usize,
    bias: Vec<f64>,
    rows: Vec<&'a ContactRows>,
    force: f64,
    length: f64,
}

/// The solutions w₀ + D y of the equations, w = (τ, f) with the components of f in the order of `components`.
struct Family {
    /// (contact, 0 tangential or 1 normal) of each component of f.
    components: Vec<(usize, usize)>,
    /// w₀, the solution of least norm.
    least: Vec<f64>,
    /// D.
    directions: Vec<Vec<f64>>,
}

/// Rows G and bounds g of the friction cones in the coordinates y of a family: G y ≥ g.
struct Cones {
    rows: Vec<Vec<f64>>,
    bounds: Vec<f64>,
}

impl Question<'_> {
    fn answer(&self, contacts: Vec<usize>) -> Option<HoldingTorques> {
        let edges = self.edges();
        // Equations of the base: Σ a_u column_u = h, and the same without load.
        let balance: Vec<(Vec<f64>, f64)> = (0..self.base)
            .map(|i| {
                let unit = self.unit(i);
                let row = edges.iter().map(|edge| edge.column[i] / unit).collect();
                (row, self.bias[i] / (unit * self.force))
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
            [-most(&opposite), most(&values)]
        };
        let torque_interval = self.joints.iter().map(|&(_, c)| {
            let [low, high] =
                range(edges.iter().map(|edge| -edge.column[c] / self.length).collect());
            [low, high].map(|value| self.bias[c] + self.length * value)
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
        let (freedom, least) = (family.directions.len(), &family.least);
        let interval = (freedom == 1).then(|| cones.interval());
        let held = match interval {
            Some([low, high]) => family.at(&[0.0_f64.clamp(low, high)]),
            // Where rounding hides the nearest point, the forces found first hold the chain.
            None => nearest(&cones.rows, &cones.bounds)
                .map_or_else(|| self.whole(&family, &start), |y| family.at(&y)),
        };
        let (torques, forces) = self.parts(&family, &held);
        let (free_torques, free_forces) = self.parts(&family, least);
        let (internal_torques, internal_forces) = match &family.directions[..] {
            [only] => self.parts(&family, only),
            _ => Default::default(),
        };
        Some(HoldingTorques {
            joints: self.joints.iter().map(|(k, _)| k + 1).collect(),
            contacts,
            torques,
            forces,
            torque_interval: torque_interval.collect::<Vec<_>>().unsigned_zero(),
            force_low: side(0),
            force_high: side(1),
            freedom,
            internal_force: interval.unsigned_zero(),
            free_torques,
            free_forces,
            internal_torques,
            internal_forces,
        })
    }

    /// The unit of a row of the floating base: forces, and a moment.
    fn unit(&self, coordinate: usize) -> f64 {
        if coordinate == 2 { self.length } else { 1.0 }
    }

    fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (contact, row) in self.rows.iter().enumerate() {
            let sides: &[f64] = if row.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            for side in sides {
                let length = libm::hypot(row.friction, 1.0);
                let force = [side * row.friction / length, 1.0 / length];
                let mut column = vec![0.0; self.coordinates];
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
        let base: Vec<Vec<f64>> = (0..self.base)
            .map(|i| components.iter().map(|of| self.entry(*of, i) / self.unit(i)).collect())
            .collect();
        let mut family = Family { components, least: Vec::new(), directions: Vec::new() };
        // Changes of the forces that the base does not feel, each with the torques that balance it.
        let free = complement(&base, family.components.len());
        let whole: Vec<Vec<f64>> = free
            .iter()
            .map(|f| {
                let torque = |&(_, c): &(usize, usize)| -self.moment(&family.components, f, c);
                self.joints.iter().map(torque).chain(f.iter().copied()).collect()
            })
            .collect();
        family.directions = factors(&whole).0;
        family.least = self.whole(&family, start);
        // Twice: the second time takes the rounding errors of the first away.
        for axis in family.directions.iter().chain(&family.directions) {
            let part = dot(axis, &family.least);
            add_scaled(&mut family.least, axis, -part);
        }
        if let [only] = &mut family.directions[..] {
            let first = only.iter().find(|x| x.abs() > INTERNAL_COMPONENT);
            if first.is_some_and(|x| *x < 0.0) {
                only.iter_mut().for_each(|x| *x = -*x);
            }
        }
        family
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

    /// w = (τ, f) of these forces.
    fn whole(&self, family: &Family, forces: &[[f64; 2]]) -> Vec<f64> {
        let f: Vec<f64> =
            family.components.iter().map(|&(contact, axis)| forces[contact][axis]).collect();
        let torque =
            |&(_, c): &(usize, usize)| self.bias[c] - self.moment(&family.components, &f, c);
        self.joints.iter().map(torque).chain(f.iter().copied()).collect()
    }

    /// The torques and the forces of w.
    fn parts(&self, family: &Family, w: &[f64]) -> (Vec<f64>, Vec<[f64; 2]>) {
        let (torques, f) = w.split_at(self.joints.len());
        let mut forces = vec![[0.0; 2]; self.rows.len()];
        for (&(contact, axis), value) in family.components.iter().zip(f) {
            forces[contact][axis] = *value;
        }
        (torques.to_vec().unsigned_zero(), forces.unsigned_zero())
    }

    fn cones(&self, family: &Family) -> Cones {
        let mut cones = Cones { rows: Vec::new(), bounds: Vec::new() };
        for (contact, row) in self.rows.iter().enumerate() {
            let sides: &[f64] = if row.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            for side in sides {
                let inward = [*side, if row.friction == 0.0 { 1.0 } else { row.friction }];
                let length = libm::hypot(inward[0], inward[1]);
                // (±f_t + μ f_n)/√(1 + μ²), or f_n
                let inside = |w: &[f64]| {
                    let f = &w[self.joints.len()..];
                    let part = |(&(at, axis), value): (&(usize, usize), &f64)| {
                        if at == contact { inward[axis] * value } else { 0.0 }
                    };
                    family.components.iter().zip(f).map(part).sum::<f64>() / length
                };
                cones.rows.push(family.directions.iter().map(|d| inside(d)).collect());
                cones.bounds.push(-inside(&family.least));
            }
        }
        cones
    }
}

impl Family {
    fn at(&self, y: &[f64]) -> Vec<f64> {
        let mut w = self.least.clone();
        for (axis, part) in self.directions.iter().zip(y) {
            add_scaled(&mut w, axis, *part);
        }
        w
    }
}

impl Cones {
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
