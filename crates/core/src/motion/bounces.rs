//! Sums of the bounces of one contact while all others are in the air.
//!
//! Let y be the state after an impact of this contact, (t, x, y, θ) and their velocities. Near rest each bounce is an analytic map of the
//! landing speed, and the speeds shrink by the restitution e. So the states of successive impacts have an expansion in powers of e,
//!
//! ```text
//! y_k = y_∞ + c_1 e^k + c_2 e^{2k} + …
//! ```
//!
//! In constant geometry only c_1 and c_2 differ from zero (velocities and times; positions). In the full model the terms of higher order
//! are the effect of the rotation. Richardson's rule with known ratios removes one term after the other,
//!
//! ```text
//! L_0(k) = y_k,   L_m(k) = (L_{m−1}(k) − e^m L_{m−1}(k−1))/(1 − e^m)
//! ```
//!
//! It is applied to the remainders R_m(k) = L_m(k) − y_k, so that their errors are relative to what is left and not to the state:
//!
//! ```text
//! R_m(k) = (R_{m−1}(k) + e^m (d_k − R_{m−1}(k−1)))/(1 − e^m),   d_k = y_k − y_{k−1}
//! ```
//!
//! The law of impact has to return the same fraction r of the landing speed each time, which takes the place of e above. Newton's,
//! Chatterjee and Ruina's and Moreau's laws return e. Poisson's and Stronge's laws return e if the contact slides in one direction through
//! all impacts. If it sticks in each impact, its sliding speed before the next one is that of one flight, a_t τ = 2a_t u/g, in proportion
//! to the landing speed u, and these laws return another fraction, computed at the limit. Where the fraction changes, the terms do not
//! have these ratios, the remainders of successive orders differ, and the bounces are followed one by one.

use nalgebra::{SVector, Vector2, Vector3};

use crate::body::contact::PerContact;
use crate::impact::friction;
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::any::AnyContacts;
use crate::motion::driver::Driver;
use crate::motion::record::Motion;
use crate::options::Impact;
use crate::outcome::Outcome;
use crate::sustained::BodyState;
use crate::tolerance::{
    BOUNCE_SUM, BOUNCE_TERMS_SHRINK, REMAINDER_FACTOR, STILL,
};

/// Most terms that are removed.
const ORDERS: usize = 6;

/// Change of t, x, y, θ, ẋ, ẏ, θ̇.
type Change = SVector<f64, 7>;

/// Bounces of one contact, one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Bounces {
    /// The point that bounces, and the piece of ground under it.
    point: usize,
    piece: isize,
    /// Number of impacts in sequence; 0: none is followed.
    hits: usize,
    /// Change since the last impact.
    change: Change,
    /// Changes d_k from impact to impact: the last one is number (hits − 2) modulo [`ORDERS`].
    changes: [Change; ORDERS],
    /// Change of velocity by the last impact.
    kick: Vector3<f64>,
}

impl Bounces {
    pub(super) fn forget(&mut self) {
        self.hits = 0;
    }

    /// Adds a flight of `dt` from this state on.
    pub(super) fn fly(&mut self, from: &BodyState, dt: f64) {
        if self.hits > 0 {
            let (way, speed) = (from.center.v * dt + from.fall * (0.5 * dt * dt), from.fall * dt);
            let angle = from.spin.omega * dt;
            self.change += Change::from([dt, way.x, way.y, angle, speed.x, speed.y, 0.0]);
        }
    }

    /// Adds the change of velocity by an impact.
    pub(super) fn jump(&mut self, change: Vector3<f64>) {
        if self.hits > 0 {
            self.change += Change::from([0.0, 0.0, 0.0, 0.0, change.x, change.y, change.z]);
            self.kick = change;
        }
    }

    /// The point has been hit, after one flight or as the first.
    fn follow(&mut self, point: usize, piece: isize) {
        if self.hits == 0 || (point, piece) != (self.point, self.piece) {
            (self.point, self.piece, self.hits) = (point, piece, 1);
        } else {
            self.changes[(self.hits - 1) % ORDERS] = self.change;
            self.hits += 1;
        }
        self.change = Change::zeros();
    }

    /// The remainder for this ratio, and the estimate of its error, in units of `unit`.
    fn limit(&self, ratio: f64, unit: &Change) -> (Change, f64) {
        let size = |change: &Change| change.component_div(unit).amax();
        let count = ORDERS.min(self.hits - 1);
        // R_m of the impact before, and of this one.
        let mut left = [Change::zeros(); ORDERS + 1];
        let mut best = (Change::zeros(), f64::INFINITY);
        for k in 0..count {
            let d = &self.changes[(self.hits - 1 - count + k) % ORDERS];
            let (mut power, mut gain, mut before) = (1.0, 1.0, f64::INFINITY);
            let (mut above, mut below) = (Change::zeros(), left[0]);
            for m in 1..=k + 1 {
                power *= ratio;
                let next = (above + (d - below) * power) / (1.0 - power);
                if k + 1 == count {
                    gain *= (1.0 + power) / (1.0 - power);
                    let step = size(&(next - above));
                    // What the next order would add, and the rounding errors of the changes.
                    let error = step * (step / before) + gain * f64::EPSILON * size(d);
                    if m > 2 && step <= BOUNCE_TERMS_SHRINK * before && error < best.1 {
                        best = (next, error);
                    }
                    before = step;
                }
                below = std::mem::replace(&mut left[m], next);
                above = next;
            }
        }
        best
    }
}

impl BodyState {
    /// Moves a body in flight by this displacement and to this velocity.
    fn displaced(&self, change: &Change) -> Self {
        let mut after = self.clone();
        let (way, angle) = (Vector2::new(change[1], change[2]), change[3]);
        after.center.r += way;
        after.spin.theta += angle;
        after.center.v += Vector2::new(change[4], change[5]);
        after.spin.omega += change[6];
        let turn = Turn::by(angle);
        for p in &mut after.points {
            let arm = p.arm();
            let side = Vector2::new(-arm.y, arm.x);
            let turned = match self.frozen {
                Some(_) => side * angle,
                None => side * turn.sin - arm * turn.one_minus_cos,
            };
            let moved = way + turned;
            p.h = (p.h + p.normal.dot(&moved)).max(0.0);
            for (k, side) in p.place.sides.iter_mut().enumerate() {
                let axis = p.place.across[k] * if k == 0 { 1.0 } else { -1.0 };
                if *side < f64::INFINITY {
                    *side = (*side + axis.dot(&moved)).max(0.0);
                }
            }
            if self.frozen.is_none() {
                (p.b, p.c) = p.turned(&turn);
            }
            p.u = p.normal.dot(&after.center.v) + p.b * after.spin.omega;
        }
        after
    }
}

impl Driver<'_, AnyContacts> {
    /// Point `i` alone has been hit. If it has bounced before without another event, and the rest of its bounces is known, moves to their
    /// limit, where it rests; an outcome: the run ends there.
    pub(super) fn bounced(&mut self, i: usize) -> Option<Option<Outcome>> {
        let (piece, restitution) =
            (self.body.state.points[i].place.piece, self.material(i).restitution);
        self.body.bounces.follow(i, piece);
        if !(self.body.bounces.hits > 3 && restitution > 0.0) {
            return None;
        }
        let (size, clock) = (self.body.posture.size(), self.log.clock);
        let [time, way, speed] =
            [clock.hi, size, self.body.fastest].map(|unit| BOUNCE_SUM * f64::EPSILON * unit);
        let spin = speed / size;
        let unit = Change::from([time, way, way, BOUNCE_SUM * f64::EPSILON, speed, speed, spin]);
        let slides = self.body.state.slip(i).abs() > STILL * self.body.fastest;
        let same = slides || !matches!(self.options.impact, Impact::Poisson | Impact::Stronge);
        let mut ratio = if same { restitution } else { self.sticking_ratio(i, &self.body.state)? };
        let (mut change, mut doubt) = self.body.bounces.limit(ratio, &unit);
        if !same && doubt < f64::INFINITY {
            ratio = self.sticking_ratio(i, &self.body.state.displaced(&change))?;
            (change, doubt) = self.body.bounces.limit(ratio, &unit);
        }
        if !(doubt <= 1.0) {
            return None;
        }
        let duration = change[0];
        if !(duration > 0.0 && clock.hi + duration <= self.log.end && self.is_clear(i, ratio, duration)) {
            return None;
        }
        let mut end = self.body.state.displaced(&change);
        (end.points[i].h, end.points[i].u) = (0.0, 0.0);
        let mut rests = PerContact::from_elem(false, end.points.len());
        rests[i] = true;
        end.close(&rests);
        // A contact with friction that slides has to slide in the same direction at the limit.
        let (slip, after) = (self.body.state.slip(i), end.slip(i));
        let rubs = !self.options.is_frictionless() && end.points[i].friction > 0.0;
        let turns_back =
            rubs && slip * after < 0.0 && after.abs() > STILL * self.body.fastest;
        if turns_back || self.edges.is_inside(&self.body.posture, &end) {
            return None;
        }
        self.log.enter(&PerContact::from_elem(Mode::Separate, end.points.len()));
        if self.log.record {
            let (start, fastest) = (Box::new(self.body.state.clone()), self.body.fastest);
            self.write(Motion::Cycles { start, fastest });
        }
        self.log.clock = clock.after(duration);
        self.body.state = end;
        self.body.bounces.forget();
        Some(self.settle(&[i], false, doubt * time, 0.0))
    }

    /// The fraction of its landing speed that point `i` keeps, if it sticks in each impact and the body is in this state at the limit; `None`
    /// if it slides after an impact.
    fn sticking_ratio(&self, i: usize, body: &BodyState) -> Option<f64> {
        let (p, spin) = (&body.points[i], body.spin.omega);
        let turned = if body.frozen.is_some() { 0.0 } else { p.b * spin * spin };
        let gain = p.tangent.dot(&body.fall) - turned;
        let before = [2.0 * gain / body.arc(i).effective_gravity(), -1.0];
        let w = body.impact_matrix(i);
        let [t, n] = friction::impulse(self.options.impact, &w, before, &self.material(i))?;
        let [slip, rate] = [before[0] + w.tt * t + w.nt * n, before[1] + w.nt * t + w.nn * n];
        (slip.abs() <= STILL && rate > 0.0 && rate < 1.0).then_some(rate)
    }

    /// Whether no other contact, no end of the ground and no other piece of it is within the way that the points can move during the rest
    /// of the bounces of point `i`, of this duration (s).
    ///
    /// The sum of all further impulses is P r/(1 − r), P the last one, up to the rotation in this time.
    fn is_clear(&self, i: usize, ratio: f64, duration: f64) -> bool {
        let (state, bounces) = (&self.body.state, &self.body.bounces);
        let left = REMAINDER_FACTOR * ratio / (1.0 - ratio);
        let speed = state.center.v.norm() + bounces.kick.xy().norm() * left + state.gravity * duration;
        let spin = state.spin.omega.abs() + bounces.kick.z.abs() * left;
        let clear = |j: usize, arm: f64| {
            let (p, way) = (&state.points[j], duration * (speed + arm * spin));
            (j == i || p.h > way)
                && p.depth == 0.0
                && p.place.sides.iter().all(|side| *side > way)
                && state.is_far_from_others(j, &self.body.posture, way)
        };
        (0..state.points.len()).all(|j| clear(j, state.points[j].arm().norm()))
    }
}
