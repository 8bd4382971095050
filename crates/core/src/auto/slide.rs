//! Phases of the local run with contacts held on the terrain, followed in the full geometry.

use nalgebra::Vector3;

use crate::auto::Shadow;
use crate::math::turn::Turn;
use crate::modes::{Mode, Row};
use crate::outcome::ModelReason;
use crate::sustained::phase::only_mode_of;
use crate::tolerance::{LANDING_SPEED_CHANGE, SHADOW_TURN, STILL};

/// Nodes and weights of Boole's rule, which is exact up to the fifth degree. The integrand here is the square of a row that rotates at
/// constant angular acceleration; its leading terms have the fourth degree in time.
const BOOLE: [(f64, f64); 5] = [
    (0.0, 7.0 / 90.0),
    (0.25, 32.0 / 90.0),
    (0.5, 12.0 / 90.0),
    (0.75, 32.0 / 90.0),
    (1.0, 7.0 / 90.0),
];

/// The event that ends a phase.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Until {
    /// The end of the run.
    End,
    /// A contact comes to rest along the terrain.
    Stop,
    Landing(usize),
}

impl Shadow<'_> {
    /// A phase of duration `t` in a contact-mode word.
    pub(super) fn slide(
        &mut self,
        word: &[Mode; 2],
        t: f64,
        until: Until,
    ) -> Result<(), ModelReason> {
        for i in 0..self.count() {
            let closed = word[i] != Mode::Separate;
            let fits = if closed {
                self.touching[i] && self.slides_alike(i)
            } else {
                !self.touching[i] || self.rate(i) > 0.0
            };
            fits.then_some(()).ok_or(ModelReason::OtherModes)?;
            self.touching[i] = closed;
        }
        self.measure();
        let (theta, omega) = (self.q.z + self.dq.z, self.qdot.z + self.dqdot.z);
        let Some(start) = self.acceleration(word, 0.0, 0.0)? else {
            self.dqdot = -self.qdot; // at rest
            let rests = until == Until::End && self.acceleration(word, theta, 0.0).is_ok();
            return rests.then_some(()).ok_or(ModelReason::OtherModes);
        };
        let mut end = Vector3::zeros();
        let (mut path, mut change) = (Vector3::zeros(), Vector3::zeros());
        for (node, weight) in BOOLE {
            let (at, turn) = (node * t, start.z);
            let angle = theta + at * (omega + 0.5 * turn * at);
            let full = self.acceleration(word, angle, omega + turn * at)?;
            end = full.ok_or(ModelReason::OtherModes)? - start;
            path += end * (weight * t * (t - at));
            change += end * (weight * t);
        }
        self.dq += self.dqdot * t + path;
        self.dqdot += change;
        self.advance(t, start);
        self.turn();
        self.measure();
        if (self.q.z + self.dq.z).abs() > SHADOW_TURN {
            return Err(ModelReason::Turns);
        }
        let acceleration = start + end;
        let closed = word.map(|mode| mode != Mode::Separate);
        self.stop(closed); // removes the error of the quadrature
        match until {
            Until::End => Ok(()),
            Until::Landing(j) => self.land(j, acceleration),
            Until::Stop => {
                // The sliding contact with the lowest speed has stopped.
                let slides = |i: &usize| word[*i].direction() != 0.0;
                let slow = |i: &usize| self.slips(*i)[0].abs();
                let slowest = (0..self.count())
                    .filter(slides)
                    .min_by(|i, j| slow(i).total_cmp(&slow(j)))
                    .ok_or(ModelReason::OtherModes)?;
                let (k, c) = (&self.contacts[slowest], self.arms[slowest].c);
                let slows = k.tangent.dot(&acceleration.xy()) - c * acceleration.z;
                let dt = -self.slips(slowest)[1] / slows;
                (dt.abs() <= LANDING_SPEED_CHANGE * t)
                    .then_some(())
                    .ok_or(ModelReason::OtherModes)?;
                self.shift(dt, acceleration);
                self.stop(closed);
                if !(closed[0] && closed[1]) {
                    // The body may rotate about the point that has stopped.
                    let left = k.tangent * self.slips(slowest)[1];
                    self.dqdot -= Vector3::new(left.x, left.y, 0.0);
                }
                Ok(())
            }
        }
    }

    /// Whether a closed contact slides in the same direction in both motions, or sticks in both.
    pub(super) fn slides_alike(&self, i: usize) -> bool {
        let tolerance = STILL.sqrt() * (self.speed - self.fall.y * self.clock.hi);
        let [local, full] = self.slips(i);
        local.abs() <= tolerance && full.abs() <= tolerance || local * full > 0.0
    }

    /// q̈ at this rotation and angular velocity, where the word is the only consistent one; `None` where it holds the body fast.
    fn acceleration(
        &self,
        word: &[Mode; 2],
        theta: f64,
        omega: f64,
    ) -> Result<Option<Vector3<f64>>, ModelReason> {
        let (turn, rho, square) = (Turn::by(theta), self.rho2.sqrt(), omega * omega);
        let mut rows = [Row::ABSENT; 2];
        let mut held = 0;
        for (i, k) in self.contacts.iter().enumerate() {
            let (b, c) = k.turned(&turn);
            let arm = (k.tangent * b + k.normal * c) / rho;
            let closed = word[i] != Mode::Separate;
            let way = closed.then(|| word[i].direction() as i8);
            rows[i] = Row::new(k.tangent, arm, [-b * square, -c * square], k.friction, way);
            held += match word[i] {
                Mode::Fixed if k.friction > 0.0 => 2,
                _ => usize::from(closed),
            };
        }
        let rows = &mut rows[..self.count()];
        let (letters, [x, y, turn]) =
            only_mode_of(rows, self.fall.xy(), rho).ok_or(ModelReason::OtherModes)?;
        // Without friction the direction of sliding has no effect.
        let alike = |i: usize| match word[i] {
            Mode::Separate => letters[i] == Mode::Separate,
            _ if self.contacts[i].friction == 0.0 => letters[i] != Mode::Separate,
            mode => letters[i] == mode,
        };
        if !(0..self.count()).all(alike) {
            return Err(ModelReason::OtherModes);
        }
        Ok((held <= 2).then(|| Vector3::new(x, y, turn)))
    }
}
