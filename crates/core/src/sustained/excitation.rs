//! The effects of a kick and of a motion of the ground on the state of a body.

use nalgebra::Vector2;

use crate::excitation::Kick;
use crate::sustained::BodyState;
use crate::tolerance::KICK_ROUNDINGS;

impl BodyState {
    /// Sets the acceleration of free fall.
    pub(crate) fn set_fall(&mut self, fall: Vector2<f64>) {
        (self.fall, self.gravity) = (fall, fall.norm());
    }

    /// q̇⁺ = q̇ + M⁻¹(J, a × J). `arm`: of its point in the nominal posture; `mass`: in kg.
    pub(crate) fn kick(&mut self, kick: &Kick, arm: Vector2<f64>, mass: f64) {
        let impulse = Vector2::from(kick.impulse) / mass;
        let (sin, cos) = if self.frozen { (0.0, 1.0) } else { libm::sincos(self.spin.theta) };
        let arm = Vector2::new(arm.x * cos - arm.y * sin, arm.x * sin + arm.y * cos);
        let spin = arm.perp(&impulse) / self.rho2;
        self.center.v += impulse;
        self.spin.omega += spin;
        for p in &mut self.points {
            let terms = [p.normal.x * impulse.x, p.normal.y * impulse.y, p.b * spin];
            let change: f64 = terms.iter().sum();
            let size = terms.iter().map(|term| term.abs()).sum::<f64>();
            // A kick along the ground does not lift a contact by its rounding error.
            let still =
                p.h == 0.0 && p.u == 0.0 && change.abs() <= KICK_ROUNDINGS * f64::EPSILON * size;
            p.u += if still { 0.0 } else { change };
            p.rounding.rate += f64::EPSILON * size;
        }
    }
}
