//! Phases of the local run with contacts held on the terrain, followed in the full geometry.

use nalgebra::{Vector2, Vector3};

use crate::auto::arm::{Angle, Arm};
use crate::auto::{MODES, NoShadow, Shadow, TURNS};
use crate::modes::{Mode, Row};
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
    pub(super) fn slide(&mut self, word: &[Mode; 2], t: f64, until: Until) -> Result<(), NoShadow> {
        for i in 0..self.count() {
            let closed = word[i] != Mode::Separate;
            let fits = if closed {
                self.touching[i] && self.slides_alike(i)
            } else {
                !self.touching[i] || self.rate(i) > 0.0
            };
            fits.then_some(()).ok_or(MODES)?;
            self.touching[i] = closed;
        }
        self.measure();
        let (theta, omega) = (self.q.z + self.dq.z, self.qdot.z + self.dqdot.z);
        let Some(start) = self.acceleration(word, 0.0, 0.0)? else {
            self.dqdot = -self.qdot; // at rest
            return (until == Until::End && self.rests_in(word)).then_some(()).ok_or(MODES);
        };
        let mut end = Vector3::zeros();
        let (mut path, mut change) = (Vector3::zeros(), Vector3::zeros());
        for (node, weight) in BOOLE {
            let (at, turn) = (node * t, start.z);
            let angle = theta + at * (omega + 0.5 * turn * at);
            let full = self.acceleration(word, angle, omega + turn * at)?;
            end = full.ok_or(MODES)? - start;
            path += end * (weight * t * (t - at));
            change += end * (weight * t);
        }
        self.dq += self.dqdot * t + path;
        self.dqdot += change;
        self.advance(t, start);
        self.turn();
        self.measure();
        if (self.q.z + self.dq.z).abs() > SHADOW_TURN {
            return Err(TURNS);
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
                    .ok_or(MODES)?;
                let (k, c) = (&self.contacts[slowest], self.arms[slowest].c);
                let slows = k.tangent.dot(&acceleration.xy()) - c * acceleration.z;
                let dt = -self.slips(slowest)[1] / slows;
                (dt.abs() <= LANDING_SPEED_CHANGE * t).then_some(()).ok_or(MODES)?;
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

    /// Whether a body at rest, with the rotation of the shadow, has this word as its only contact-mode word.
    fn rests_in(&self, word: &[Mode; 2]) -> bool {
        let n = self.count();
        let rho = self.rho2.sqrt();
        let mut rows = [Row::ABSENT; 2];
        for (i, k) in self.contacts.iter().enumerate() {
            let arm = k.tangent * self.arms[i].b + k.normal * self.arms[i].c;
            let way = (word[i] != Mode::Separate).then_some(0);
            rows[i] = Row::new(k.tangent, arm / rho, [0.0; 2], k.friction, way);
        }
        only_mode_of(&mut rows[..n], Vector2::new(0.0, self.fall.y), rho)
            .is_some_and(|(letters, _)| letters[..n] == word[..n])
    }

    /// Whether a closed contact slides in the same direction in both motions, or sticks in both.
    pub(super) fn slides_alike(&self, i: usize) -> bool {
        let tolerance = STILL.sqrt() * (self.speed - self.fall.y * self.clock.hi);
        let [local, full] = self.slips(i);
        local.abs() <= tolerance && full.abs() <= tolerance || local * full > 0.0
    }

    /// q̈ in a contact-mode word at a rotation; `None` where the word has no degree of freedom left.
    pub(super) fn acceleration(
        &self,
        word: &[Mode; 2],
        theta: f64,
        omega: f64,
    ) -> Result<Option<Vector3<f64>>, NoShadow> {
        let angle = Angle::of(theta);
        // Constraint rows, the directions of their forces in q̈, and minus the row accelerations without these forces.
        let mut rows: [(Vector3<f64>, Vector3<f64>, f64); 2] = Default::default();
        let mut edge = [f64::NAN; 2];
        let mut n = 0;
        for i in 0..self.count() {
            let (k, friction) = (&self.contacts[i], self.posture.contacts()[i].friction);
            if word[i] == Mode::Separate {
                continue;
            }
            let Arm { b, c, .. } = Arm::of(k, angle);
            let fixed = word[i] == Mode::Fixed && friction > 0.0;
            if n + 1 + usize::from(fixed) > 2 {
                return Ok(None);
            }
            let slope = if fixed { 0.0 } else { -word[i].direction() * friction };
            let mut add = |row: Vector3<f64>, along: Vector2<f64>, lever: f64, centripetal: f64| {
                let push = Vector3::new(along.x, along.y, lever / self.rho2);
                rows[n] = (row, push, centripetal * omega * omega - row.dot(&self.fall));
                n += 1;
            };
            let (normal, tangent) = (k.normal, k.tangent);
            let row = Vector3::new(normal.x, normal.y, b);
            add(row, normal + tangent * slope, b - slope * c, c);
            if fixed {
                add(Vector3::new(tangent.x, tangent.y, -c), tangent, -c, b);
                edge[1] = friction;
            }
        }
        let entry = |i: usize, j: usize| rows[i].0.dot(&rows[j].1);
        let force = match n {
            1 => [rows[0].2 / entry(0, 0), 0.0],
            _ => {
                let determinant = entry(0, 0) * entry(1, 1) - entry(0, 1) * entry(1, 0);
                let cross = |i: usize, j: usize| rows[i].2 * entry(j, j) - rows[j].2 * entry(i, j);
                [cross(0, 1) / determinant, cross(1, 0) / determinant]
            }
        };
        // A normal force must be positive. A tangential force must be within the friction cone.
        let holds = force[0] > 0.0
            && (n < 2
                || if edge[1] >= 0.0 {
                    force[1].abs() < edge[1] * force[0]
                } else {
                    force[1] > 0.0
                });
        if !holds {
            return Err(MODES);
        }
        Ok(Some((0..n).fold(self.fall, |sum, l| sum + rows[l].1 * force[l])))
    }
}
