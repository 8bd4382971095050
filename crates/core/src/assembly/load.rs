//! How much of a load an assembly holds.
//!
//! A load grows from zero in proportion: gravity + α · load. The *static* factor is the largest α for which contact forces within the friction cones
//! balance it: one linear programme. Forces that balance a load need not be those that act: the least α at which a contact mode *moves* may be smaller.

use serde::Serialize;

use crate::assembly::least::least;
use crate::assembly::onset::SystemMode;
use crate::assembly::scaled::Scaled;
use crate::assembly::system::{Load, System};
use crate::error::{Error, finite};
use crate::math::Sparse;
use crate::math::linear::{Failure, maximise};
use crate::tolerance::{ABOVE_LARGE, JUST_ABOVE};

/// The largest multiple of a load that contact forces can balance, and what they are.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LoadFactor {
    /// The factor; ∞ if there is no bound.
    #[serde(with = "crate::serial::numbers::extended")]
    pub statics: f64,
    /// Contact forces (tangential, normal) that balance the load at this factor, in N; if there is no bound, the least that balance some multiple.
    pub forces: Vec<[f64; 2]>,
    /// The least multiple at which a contact mode opens a contact or slides, of the words that were tried; ∞ if none of them moves. It may be less than the static factor:
    /// forces can balance what need not stand.
    #[serde(with = "crate::serial::numbers::extended")]
    pub moves: f64,
    /// A mode that moves, at a load just above that.
    pub mode: Option<SystemMode>,
    /// Whether all words were tried, so that `moves` is the least multiple. Of assemblies with many contacts only the word just above the static factor is tried.
    pub complete: bool,
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

    /// Distance above the static factor at which a mode is asked: modes of large assemblies are known to fewer digits.
    fn just_above(&self) -> f64 {
        if self.is_large() { ABOVE_LARGE } else { JUST_ABOVE }
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
    /// As [`System::onset`]; [`Error::Solver`] if the linear programme of the forces does not converge.
    pub fn load_factor(&self, load: &Load) -> Result<Option<LoadFactor>, Error> {
        let direction = self.generalised(load)?;
        let scaled = Scaled::new(self, &direction);
        let (multiple, forces) = match statics(&scaled) {
            Statics::None => return Ok(None),
            Statics::Stuck => {
                return Err(Error::Solver("the linear programme of the forces".into()));
            }
            Statics::Bound(multiple, forces) => (multiple, forces),
            Statics::NoBound(forces) => (f64::INFINITY, forces),
        };
        let statics = multiple * scaled.unit;
        // What holds no more has to move: a mode just above.
        let above = multiple + self.just_above();
        let known =
            if statics.is_finite() { self.begins(&direction, above * scaled.unit)? } else { None };
        let y = known.as_ref().map(|mode| scaled.y(&mode.acceleration));
        let pair = known.as_ref().zip(y.as_ref());
        let least = least(&scaled, pair.map(|(mode, y)| (&mode.word[..], &y[..], above)));
        let mode = if self.is_large() && least.multiple.is_finite() {
            known
        } else {
            least.mode.map(|mode| scaled.mode(mode.word, mode.multiple * scaled.unit, &mode.forces))
        };
        Ok(Some(LoadFactor {
            statics,
            forces: scaled.forces(&forces),
            moves: least.multiple * scaled.unit,
            mode,
            complete: least.complete,
        }))
    }
}

/// Multiple of the load, in its unit, that may act backwards where rounding prevents the answer without.
const BACKWARDS: f64 = 1.0;

/// The largest multiple that forces balance.
enum Statics {
    /// No multiple ≥ 0.
    None,
    /// The multiple, and forces that balance it.
    Bound(f64, Vec<[f64; 2]>),
    /// Every multiple, and the least forces that balance some multiple.
    NoBound(Vec<[f64; 2]>),
    /// Rounding prevents the answer.
    Stuck,
}

/// The rows of gravity + α load + forces = 0: entries of the weights of the edges, then of α − `least`; and the right-hand sides.
fn balance(scaled: &Scaled, edges: &[(usize, [f64; 2])], least: f64) -> Vec<(Sparse, f64)> {
    let pulls = scaled.gravity.iter().zip(&scaled.load);
    let mut rows: Vec<(Sparse, f64)> =
        pulls.map(|(pull, load)| (Vec::new(), -pull - least * load)).collect();
    for (at, (contact, edge)) in edges.iter().enumerate() {
        scaled.pushed(*contact, *edge).iter().for_each(|(k, value)| rows[*k].0.push((at, *value)));
    }
    for (k, value) in scaled.load.iter().enumerate().filter(|(_, value)| **value != 0.0) {
        rows[k].0.push((edges.len(), *value));
    }
    rows
}

fn statics(scaled: &Scaled) -> Statics {
    let edges = scaled.edges();
    let rows = balance(scaled, &edges, 0.0);
    let mut objective = vec![0.0; edges.len() + 1];
    objective[edges.len()] = 1.0;
    match maximise(&rows, &objective) {
        Ok(found) => Statics::Bound(found[edges.len()], scaled.sum(&edges, &found)),
        Err(Failure::Empty) => Statics::None,
        // Where the assembly just falls without the load, or just stands, multiples below zero are allowed: then it does not matter that few forces balance it.
        Err(Failure::Stuck) => match maximise(&balance(scaled, &edges, -BACKWARDS), &objective) {
            Ok(found) if found[edges.len()] >= BACKWARDS => {
                let multiple = found[edges.len()] - BACKWARDS;
                Statics::Bound(multiple, scaled.sum(&edges, &found))
            }
            Ok(_) | Err(Failure::Empty) => Statics::None,
            Err(Failure::Stuck | Failure::Unbounded) => Statics::Stuck,
        },
        Err(Failure::Unbounded) => {
            let least: Vec<f64> = vec![-1.0; edges.len() + 1];
            maximise(&rows, &least)
                .map_or(Statics::Stuck, |found| Statics::NoBound(scaled.sum(&edges, &found)))
        }
    }
}
