//! The contacts of an assembly at rest, in coordinates in which the mass is the identity, with the entries of rows that are not zero.
//!
//! With y = M^½ q̈ and rows of length one along the normal,
//!
//! ```text
//! y = p + α l + Σ_j (t_j f_t,j + n_j f_n,j)        a_t,i = t_i·y        a_n,i = n_i·y
//! ```
//!
//! p and l are gravity and the load, divided by the largest component of p (of l where there is no gravity).

use crate::assembly::rigid::Rigid;
use crate::assembly::system::System;
use crate::math::Sparse;

pub(super) struct Scaled {
    /// (tangential, normal) by contact.
    pub(super) rows: Vec<[Sparse; 2]>,
    pub(super) friction: Vec<f64>,
    pub(super) gravity: Vec<f64>,
    pub(super) load: Vec<f64>,
    /// For each contact those with a body of it, and what their unit forces do: [own axis][axis of the force].
    near: Vec<Vec<(usize, [[f64; 2]; 2])>>,
    roots: Vec<f64>,
    stretch: Vec<f64>,
    size: f64,
    /// Unit of α, as a multiple of the load.
    pub(super) unit: f64,
}

fn product(one: &Sparse, other: &Sparse) -> f64 {
    one.iter()
        .flat_map(|(j, a)| other.iter().filter(move |(k, _)| k == j).map(move |(_, b)| a * b))
        .sum()
}

impl Scaled {
    /// `load`: the generalised load whose multiple α acts beside gravity.
    pub(super) fn new(system: &System, load: &[f64]) -> Self {
        let bodies = &system.fields().bodies;
        let inertia = |(_, body): &(String, Rigid)| {
            [body.mass, body.mass, body.mass * body.gyration_radius * body.gyration_radius]
        };
        let roots: Vec<f64> = bodies.iter().flat_map(inertia).map(f64::sqrt).collect();
        let divided = |of: &[f64]| of.iter().zip(&roots).map(|(v, r)| v / r).collect::<Vec<_>>();
        let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let (mut gravity, mut load) = (divided(&system.weights()), divided(load));
        let (weight, push) = (largest(&gravity), largest(&load));
        let size = [weight, push, 1.0].into_iter().find(|size| *size > 0.0).unwrap_or(1.0);
        let unit = if push > 0.0 { size / push } else { 1.0 };
        gravity.iter_mut().for_each(|value| *value /= size);
        load.iter_mut().for_each(|value| *value *= unit / size);
        let mut stretch = Vec::new();
        let mut rows = Vec::new();
        let mut touching: Vec<Vec<usize>> = vec![Vec::new(); bodies.len()];
        for (i, joint) in system.contacts().iter().enumerate() {
            let sparse = |row: [(usize, [f64; 3]); 2]| -> Sparse {
                let entries = row.into_iter().flat_map(|(body, parts)| {
                    parts.into_iter().enumerate().map(move |(axis, part)| (3 * body + axis, part))
                });
                let entries = entries.filter(|(_, part)| *part != 0.0);
                entries.map(|(k, part)| (k, part / roots[k])).collect()
            };
            let [tangential, normal] = system.rows(joint).map(sparse);
            let length = product(&normal, &normal).sqrt();
            let unit = |row: Sparse| row.into_iter().map(|(k, v)| (k, v / length)).collect();
            rows.push([tangential, normal].map(unit));
            stretch.push(length);
            for body in [Some(joint.body), joint.on].into_iter().flatten() {
                touching[body].push(i);
            }
        }
        let near = system.contacts().iter().zip(&rows).map(|(joint, own)| {
            let mut others: Vec<usize> = [Some(joint.body), joint.on]
                .into_iter()
                .flatten()
                .flat_map(|b| touching[b].clone())
                .collect();
            others.sort_unstable();
            others.dedup();
            let effect = |j: usize| {
                (j, [0, 1].map(|axis| [0, 1].map(|other| product(&own[axis], &rows[j][other]))))
            };
            others.into_iter().map(effect).collect()
        });
        let near = near.collect();
        let friction = system.contacts().iter().map(|joint| joint.friction).collect();
        Self { near, rows, friction, gravity, load, roots, stretch, size, unit }
    }

    pub(super) fn count(&self) -> usize {
        self.rows.len()
    }

    /// What unit forces do to the acceleration of contact `i` along an axis (0: tangential, 1: normal): the contact, and the parts of its forces
    /// (tangential, normal).
    pub(super) fn effects(
        &self,
        i: usize,
        axis: usize,
    ) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        self.near[i].iter().map(move |(j, effect)| (*j, effect[axis]))
    }

    /// What gravity and the load do to it.
    pub(super) fn pulls(&self, i: usize, axis: usize) -> [f64; 2] {
        [&self.gravity, &self.load].map(|pull| self.along(i, axis, pull))
    }

    /// Acceleration (0: tangential, 1: normal) of contact `i`.
    pub(super) fn along(&self, i: usize, axis: usize, y: &[f64]) -> f64 {
        self.rows[i][axis].iter().map(|(k, part)| part * y[*k]).sum()
    }

    /// What a force (tangential, normal) of contact `i` does, by coordinate.
    pub(super) fn pushed(&self, i: usize, force: [f64; 2]) -> Sparse {
        let mut all: Sparse = Vec::new();
        for (row, part) in self.rows[i].iter().zip(force).filter(|(_, part)| *part != 0.0) {
            for (k, value) in row {
                match all.iter_mut().find(|(column, _)| column == k) {
                    Some(entry) => entry.1 += part * value,
                    None => all.push((*k, part * value)),
                }
            }
        }
        all
    }

    /// The edges of the friction cones: contact, and force (tangential, normal).
    pub(super) fn edges(&self) -> Vec<(usize, [f64; 2])> {
        let of = |(k, mu): (usize, &f64)| {
            let sides: &[f64] = if *mu == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            sides.iter().map(move |side| (k, [side * mu, 1.0])).collect::<Vec<_>>()
        };
        self.friction.iter().enumerate().flat_map(of).collect()
    }

    /// The forces by contact of these weights of forces.
    pub(super) fn sum(&self, edges: &[(usize, [f64; 2])], weights: &[f64]) -> Vec<[f64; 2]> {
        let mut forces = vec![[0.0; 2]; self.count()];
        for ((contact, edge), weight) in edges.iter().zip(weights) {
            for axis in [0, 1] {
                forces[*contact][axis] += edge[axis] * weight;
            }
        }
        forces
    }

    /// y for this multiple of the load and these forces.
    pub(super) fn motion(&self, multiple: f64, forces: &[[f64; 2]]) -> Vec<f64> {
        let pull = self.gravity.iter().zip(&self.load);
        let mut y: Vec<f64> = pull.map(|(p, l)| p + multiple * l).collect();
        for (rows, force) in self.rows.iter().zip(forces) {
            for (row, part) in rows.iter().zip(force) {
                row.iter().for_each(|(k, value)| y[*k] += part * value);
            }
        }
        y
    }

    /// q̈ from y, in m/s² and rad/s².
    pub(super) fn acceleration(&self, y: &[f64]) -> Vec<f64> {
        y.iter().zip(&self.roots).map(|(part, root)| part * self.size / root).collect()
    }

    /// y from q̈.
    pub(super) fn y(&self, acceleration: &[f64]) -> Vec<f64> {
        acceleration.iter().zip(&self.roots).map(|(part, root)| part * root / self.size).collect()
    }

    /// Forces in N.
    pub(super) fn forces(&self, scaled: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let each = scaled.iter().zip(&self.stretch);
        each.map(|(force, stretch)| force.map(|part| part * self.size / stretch)).collect()
    }
}
