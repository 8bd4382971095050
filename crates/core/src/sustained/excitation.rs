//! The effects of a kick, a load and a motion of the ground on the state.

use std::sync::Arc;

use nalgebra::Vector2;

use crate::excitation::Kick;
use crate::math::mass_vector::MassVector;
use crate::sustained::BodyState;
use crate::sustained::frozen::Frozen;
use crate::tolerance::{CHANGING_LOAD_REACH, KICK_ROUNDINGS, STEADY_FALL};

impl BodyState {
    /// Sets the acceleration of free fall, in m/s², and its rate, in m/s³.
    pub(crate) fn set_fall(&mut self, fall: Vector2<f64>, rate: Vector2<f64>) {
        (self.fall, self.gravity, self.fall_rate) = (fall, fall.norm(), rate);
    }

    /// Whether the acceleration of free fall changes.
    pub(crate) fn fall_changes(&self) -> bool {
        self.fall_rate != Vector2::zeros()
    }

    /// Advances the acceleration of free fall by this time (s).
    pub(crate) fn advance_fall(&mut self, time: f64) {
        if self.fall_changes() {
            self.set_fall(self.fall + self.fall_rate * time, self.fall_rate);
        }
    }

    /// `reach` of a step, in units of time, at most that of a step under a load that changes.
    pub(crate) fn within_changing_load(&self, reach: f64) -> f64 {
        if self.fall_changes() { reach.min(CHANGING_LOAD_REACH) } else { reach }
    }

    /// Whether the acceleration of free fall is constant for this time (s), within its rounding error.
    pub(crate) fn falls_steadily(&self, time: f64) -> bool {
        self.fall_rate.norm() * time <= STEADY_FALL * f64::EPSILON * self.gravity
    }

    /// q̇⁺ = q̇ + M⁻¹(J, a × J). `arm`: of its point in the nominal posture; `mass`: in kg.
    pub(crate) fn kick(&mut self, kick: &Kick, arm: Vector2<f64>, mass: f64) {
        let impulse = Vector2::from(kick.impulse) / mass;
        let (sin, cos) = libm::sincos(self.spin.theta);
        let arm = Vector2::new(arm.x * cos - arm.y * sin, arm.x * sin + arm.y * cos);
        let spin = arm.perp(&impulse) / self.rho2;
        self.center.v += impulse;
        self.spin.omega += spin;
        for p in &mut self.points {
            let terms = [p.normal.x * impulse.x, p.normal.y * impulse.y, p.b * spin];
            let change: f64 = terms.iter().sum();
            let size = terms.iter().map(|term| term.abs()).sum::<f64>();
            p.u += kicked(p.h == 0.0 && p.u == 0.0, change, size);
            p.rounding.rate += f64::EPSILON * size;
        }
    }
}

/// The change of the gap rate of a contact, `rests` or not, by a kick, with this size of its terms: a kick along the ground does not lift a
/// contact by its rounding error.
fn kicked(rests: bool, change: f64, size: f64) -> f64 {
    if rests && change.abs() <= KICK_ROUNDINGS * f64::EPSILON * size { 0.0 } else { change }
}

impl Frozen {
    /// Sets the load, of all coordinates.
    pub(crate) fn set_load(&mut self, load: &[f64]) {
        self.rows = Arc::new(self.rows.loaded(load));
    }

    /// q̇⁺ = q̇ + M⁻¹ J with a generalised impulse J, of all coordinates.
    pub(crate) fn kick(&mut self, impulse: &[f64]) {
        let Self { rows, v, points, .. } = self;
        let (change, _) = rows.space.response(impulse);
        v.add_scaled(&change, 1.0);
        for (i, p) in points.iter_mut().enumerate() {
            let row = rows.space.normal_row(i);
            let size: f64 = row.iter().zip(change.iter()).map(|(a, b)| (a * b).abs()).sum();
            p.u += kicked(p.h == 0.0 && p.u == 0.0, row.dot(&change), size);
            p.rounding.rate += f64::EPSILON * size;
        }
    }
}
