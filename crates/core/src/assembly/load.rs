//! How much of a load an assembly holds.
//!
//! A load grows from zero in proportion: gravity + α · load. The *static* factor is the largest α for which contact forces within the friction cones
//! balance it: one linear programme. Forces that balance a load need not be those that act.

use serde::Serialize;

use crate::assembly::system::System;
use crate::error::{Error, finite};
use crate::math::simplex::maximise;

/// A load on an assembly: wrenches on bodies, or an acceleration of all of them.
#[derive(Debug, Clone, PartialEq)]
pub enum Load {
    /// (body, from 0; force x, y in N; moment about its centre of mass in N m).
    Wrenches(Vec<(usize, [f64; 3])>),
    /// An acceleration that acts like gravity on every body, in m/s²: (1, 0) pushes to the right.
    Acceleration([f64; 2]),
}

/// The largest multiple of a load that contact forces can balance, and what they are.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadFactor {
    /// The factor; ∞ if there is no bound.
    #[serde(with = "crate::serial::numbers::extended")]
    pub statics: f64,
    /// Contact forces (tangential, normal) that balance the load at this factor, in N; those without the load if there is no bound.
    pub forces: Vec<[f64; 2]>,
}

impl System {
    /// The generalised load, (x, y, θ) of each body.
    ///
    /// # Errors
    ///
    /// A value that is not finite, a body that is not there, a load that is zero.
    pub fn generalised(&self, load: &Load) -> Result<Vec<f64>, Error> {
        let bodies = &self.fields().bodies;
        let mut all = vec![0.0; 3 * bodies.len()];
        match load {
            Load::Wrenches(wrenches) => {
                for (body, wrench) in wrenches {
                    let Some((name, _)) = bodies.get(*body) else {
                        return Err(Error::Unusable {
                            field: "load".into(),
                            value: format!("body {body}"),
                            allowed: format!("bodies from 0 to {}", bodies.len() - 1),
                        });
                    };
                    for (axis, value) in wrench.iter().enumerate() {
                        finite(format!("load.{name}.{axis}"), *value)?;
                        all[3 * body + axis] += value;
                    }
                }
            }
            Load::Acceleration(acceleration) => {
                for (axis, value) in acceleration.iter().enumerate() {
                    finite(format!("acceleration.{axis}"), *value)?;
                    for (k, (_, body)) in bodies.iter().enumerate() {
                        all[3 * k + axis] = body.mass * value;
                    }
                }
            }
        }
        if all.iter().all(|value| *value == 0.0) {
            return Err(Error::Unusable {
                field: "load".into(),
                value: "zero".into(),
                allowed: "a load that is not zero".into(),
            });
        }
        Ok(all)
    }

    /// The largest multiple of this load, beside gravity, that forces within the friction cones can balance; `None` if they balance no
    /// multiple α ≥ 0 of it.
    ///
    /// ```
    /// use standfast::assembly::{Load, Rigid, System, SystemFields};
    ///
    /// // A brick of 2 m by 1 m on friction 1/2 slides at half of gravity, and would tip at a/g = 2.
    /// let bodies = vec![("brick".into(), Rigid::block(2.0, 1.0, [0.0, 0.0], 0.0, 1.0)?)];
    /// let brick = System::new(SystemFields { bodies, gravity: 10.0, ..SystemFields::default() })?;
    /// let held = brick.load_factor(&Load::Acceleration([1.0, 0.0]))?.expect("it stands without a load");
    /// assert!((held.statics - 5.0).abs() < 1e-12);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`System::generalised`].
    pub fn load_factor(&self, load: &Load) -> Result<Option<LoadFactor>, Error> {
        let direction = self.generalised(load)?;
        let weights = self.weights();
        let edges: Vec<(usize, [f64; 2])> = self
            .contacts()
            .iter()
            .enumerate()
            .flat_map(|(k, joint)| {
                let sides: &[f64] = if joint.friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
                sides.iter().map(move |side| (k, [side * joint.friction, 1.0]))
            })
            .collect();
        let mut columns = vec![vec![0.0; edges.len() + 1]; weights.len()];
        for (at, (contact, [t, n])) in edges.iter().enumerate() {
            let [tangential, normal] = self.rows(&self.contacts()[*contact]);
            for (row, part) in [(tangential, t), (normal, n)] {
                for (body, values) in row {
                    for (axis, value) in values.into_iter().enumerate() {
                        columns[3 * body + axis][at] += part * value;
                    }
                }
            }
        }
        // Rows in units of the largest weight and of the sizes of the bodies; α in units in which the load is as large.
        let largest = |values: &[f64]| {
            values.iter().enumerate().map(|(k, v)| v.abs() / self.unit(k)).fold(0.0, f64::max)
        };
        let (weight, push) = (largest(&weights), largest(&direction));
        let force = if weight > 0.0 { weight } else { push };
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for (k, mut row) in columns.into_iter().enumerate() {
            row.iter_mut().for_each(|value| *value /= self.unit(k));
            row[edges.len()] = direction[k] / (push * self.unit(k));
            rows.push((row, -weights[k] / (force * self.unit(k))));
        }
        let mut objective = vec![0.0; edges.len()];
        objective.push(1.0);
        let Some(held) = maximise(&rows, &vec![0.0; edges.len() + 1]) else { return Ok(None) };
        let mut free: Vec<(Vec<f64>, f64)> =
            rows.iter().map(|(row, _)| (row.clone(), 0.0)).collect();
        free.push((vec![1.0; edges.len() + 1], 1.0));
        let unbounded = maximise(&free, &objective)
            .is_some_and(|x| x[edges.len()] > crate::tolerance::UNBOUNDED_DIRECTION);
        let most = if unbounded { None } else { maximise(&rows, &objective) };
        let (statics, weights) = match most {
            Some(found) => (found[edges.len()] * force / push, found),
            None => (f64::INFINITY, held),
        };
        let mut forces = vec![[0.0; 2]; self.contacts().len()];
        for ((contact, edge), part) in edges.iter().zip(&weights) {
            for axis in [0, 1] {
                forces[*contact][axis] += edge[axis] * part * force;
            }
        }
        Ok(Some(LoadFactor { statics, forces }))
    }

    /// Unit of a coordinate: 1, or the size of the body.
    fn unit(&self, coordinate: usize) -> f64 {
        if coordinate % 3 == 2 { self.fields().bodies[coordinate / 3].1.size() } else { 1.0 }
    }
}
