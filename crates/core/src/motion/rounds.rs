//! Sums of infinitely many rounds. A round goes from one landing of a contact to its next landing, while the other contact is held; the
//! rounds repeat on a smaller and smaller scale.

use nalgebra::Vector3;

use crate::body::contact::PerContact;
use crate::collisions::log::Spin;
use crate::math::clock::Clock;
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::frame::{Base, Snapshot};
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{REACHED, STILL};

/// Roundings in the ratio of two landing speeds.
pub(crate) const ROUNDINGS: f64 = 64.0;

/// Factor on the estimate of what is left, where speeds are taken for none.
pub(crate) const SEVERAL: f64 = 4.0;

/// The rounds of two contacts.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rounds {
    /// For each contact: the last round that ended with its landing.
    last: [Option<Round>; 2],
    /// For each contact: which way it slid when it was held last, and since when.
    slides: [(f64, Clock); 2],
    /// The largest sliding speed that was taken for none, in m/s.
    dropped: f64,
}

/// A round, at its end.
#[derive(Debug, Clone, Copy)]
struct Round {
    at: Snapshot,
    /// Ratio of the landing speeds of this round and the one before.
    ratio: f64,
    /// Change of q̇ in this round.
    change: Vector3<f64>,
    /// In s.
    duration: f64,
}

/// Where infinitely many rounds lead to.
#[derive(Debug, Clone)]
pub(crate) struct Limit {
    /// Both contacts on the ground.
    pub(crate) end: BodyState,
    /// Until then, in s.
    pub(crate) duration: f64,
    /// Whether rounds repeat themselves; if not, so little time is left that they need not.
    pub(crate) repeats: bool,
    /// Estimate of the error of that time, in s.
    pub(crate) error: f64,
}

impl Rounds {
    /// From now on the contacts are in these modes.
    pub(crate) fn hold(&mut self, word: &[Mode], clock: Clock) {
        for (way, mode) in self.slides.iter_mut().zip(word) {
            if *mode != Mode::Separate {
                *way = (mode.direction(), clock);
            }
        }
    }

    /// This sliding speed has been taken for none.
    pub(crate) fn drop(&mut self, speed: f64) {
        self.dropped = self.dropped.max(speed);
    }

    /// Error of the time of a rest, in s: a speed that was taken for none is missing in all rounds since, for about as long as
    /// gravity takes to undo it.
    pub(crate) fn missing(&self, gravity: f64) -> f64 {
        if self.dropped > 0.0 { SEVERAL * self.dropped / gravity } else { 0.0 }
    }

    pub(crate) fn forget(&mut self) {
        self.last = [None; 2];
    }

    /// Contact `b` lands while the other is held. Rounds from one such landing to the next that shrink in one ratio r, all
    /// times and all changes of velocity with it, are summed:
    ///
    /// ```text
    /// v_∞ = v + (v − v₀) r/(1 − r),   T = (t − t₀) r/(1 − r),   q_∞ = q + v_∞ T + (q − q₀ − v_∞ (t − t₀)) r²/(1 − r²)
    /// ```
    ///
    /// `size`: of the body; `fastest`: the largest speed there can have been; `left`: time to the end of the run.
    pub(crate) fn land(
        &mut self,
        b: usize,
        stance: &BodyState,
        clock: Clock,
        size: f64,
        fastest: f64,
        left: f64,
    ) -> Option<Limit> {
        let speed = |v: &Vector3<f64>| v.x.abs().max(v.y.abs()).max(size * v.z.abs());
        let now = Snapshot::of_stance(stance, clock);
        let start =
            Round { at: now, ratio: f64::NAN, change: Vector3::zeros(), duration: f64::NAN };
        let last = self.last[b].replace(start)?;
        let before = &last.at;
        let ratio = now.gaps.u[b] / before.gaps.u[b];
        let gained = Base::state(&now).qdot - Base::state(before).qdot;
        let dt = now.clock.since(before.clock);
        self.last[b] = Some(Round { at: now, ratio, change: gained, duration: dt });
        let sum = ratio / (1.0 - ratio);
        let t = dt * sum;
        // The geometry has to stay what it is, too: then times shrink in the same ratio. How far they do not is of the order
        // of the angle of the body, which shrinks with the rounds.
        let turned = if stance.frozen.is_some() {
            0.0
        } else {
            let angle = now.spin.omega.abs().max(before.spin.omega.abs()) * t;
            (angle * angle).max((dt / (ratio * last.duration) - 1.0).abs())
        };
        let change = t * ((ratio - last.ratio).abs() / (1.0 - ratio) + turned) / (1.0 - ratio);
        // And what a round does to the velocities has to repeat, too, as far as the sum adds it: a contact that slid in the
        // round before and sticks in this one may leave the ratio of the landing speeds as it is.
        let unlike = speed(&(gained - last.change * ratio)) * sum;
        let alike = unlike <= STILL * fastest;
        let repeats = alike && change <= f64::EPSILON * now.clock.hi;
        let reached = t <= REACHED * now.clock.hi;
        if !(0.0 < ratio && ratio < 1.0 && t <= left) || !(repeats || reached) {
            return None;
        }
        // No point may come to an end of its terrain on the way.
        let way = t * (speed(&Base::state(before).qdot) + stance.gravity * dt);
        let room = |p: &ContactState| p.place.sides.iter().all(|side| *side > SEVERAL * way);
        if !stance.points.iter().all(room) {
            return None;
        }
        let rest = ratio * ratio / (1.0 - ratio * ratio);
        let (state, old) = (Base::state(&now), Base::state(before));
        // At the end both contacts are on the ground, and so they are now: of a body whose geometry stays as it is, what a
        // velocity or a way has across the ground is rounding, and the time may be long.
        let along = |change: Vector3<f64>| {
            if stance.frozen.is_none() {
                return change;
            }
            let mut moved = stance.clone();
            (moved.center.v, moved.spin.omega) = (change.xy(), change.z);
            moved.close(&stance.points.iter().map(|_| true).collect::<PerContact<_>>());
            Vector3::new(moved.center.v.x, moved.center.v.y, moved.spin.omega)
        };
        let v = along(state.qdot + (state.qdot - old.qdot) * sum);
        let way = along(v * t + (state.q - old.q - v * dt) * rest);
        let mut end = stance.clone();
        (end.center.v, end.center.r) = (v.xy(), stance.center.r + way.xy());
        end.spin = Spin { theta: stance.spin.theta + way.z, omega: v.z };
        // A contact that slides in all rounds has to slide the same way at their end, and one that sticks has to stand still there:
        // up to the rounding of the sum, and to the speeds that count as none.
        let still = STILL * fastest + STILL.sqrt() * speed(&gained) * sum.max(1.0);
        let turns_back = |i: usize| {
            let ((way, when), slip) = (self.slides[i], end.slip(i));
            let held = when.since(before.clock) >= 0.0 && stance.points[i].friction > 0.0;
            stance.slip(i) * slip < 0.0 && slip.abs() > still
                || held && (way * slip < -still || way == 0.0 && slip.abs() > still)
        };
        if !reached && (0..end.points.len()).any(turns_back) {
            return None;
        }
        let onward = Turn::by(if end.frozen.is_some() { 0.0 } else { way.z });
        for p in &mut end.points {
            (p.h, p.u) = (0.0, 0.0);
            (p.b, p.c) = p.turned(&onward);
        }
        self.forget();
        let missing = self.missing(stance.gravity);
        let rounding = ROUNDINGS * f64::EPSILON * t;
        let error = if repeats { change + (rounding + missing) / (1.0 - ratio) } else { t };
        Some(Limit { end, duration: t, repeats, error })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::body::terrain::Place;
    use crate::collisions::log::Center;
    use crate::sustained::Rounding;

    /// A rod that slides at v on level ground without friction; contact 2 lands with this speed.
    fn landing(x: f64, v: f64, speed: f64) -> BodyState {
        let (normal, tangent) = (Vector2::y(), Vector2::x());
        let (rounding, held) = (Rounding::default(), None);
        let point = |contact: usize, b: f64, u: f64| {
            let place = Place::anywhere(contact);
            let (friction, c, h, depth) = (0.0, 0.0, 0.0, 0.0);
            ContactState { normal, tangent, friction, b, c, held, place, h, depth, u, rounding }
        };
        let points = PerContact::from([point(0, -1.0, 0.0), point(1, 1.0, -speed)]);
        let center = Center { r: Vector2::new(x, 0.0), v: Vector2::new(v, 0.0) };
        let (spin, rho2, gravity, frozen) = (Spin::default(), 0.25, 1.0, None);
        BodyState { points, center, spin, rho2, gravity, frozen }
    }

    /// Three landings, at these speeds and times. Round k begins at the speed v_∞ + d rᵏ along the ground and moves the body
    /// by v_∞ rᵏ + ½ r²ᵏ: all of it exact for powers of two. The place at the last landing, and the limit.
    fn limit(r: f64, [v, d]: [f64; 2], speeds: [f64; 3], dt: [f64; 2]) -> (f64, Option<Limit>) {
        let (mut rounds, mut x) = (Rounds::default(), 0.0);
        let mut land = |power: f64, speed: f64, time: f64, x: f64| {
            let (body, clock) = (landing(x, v + d * power, speed), Clock::default().after(time));
            rounds.land(1, &body, clock, 1.0, 10.0, f64::INFINITY)
        };
        for (power, speed, time) in [(1.0, speeds[0], 1.0), (r, speeds[1], 1.0 + dt[0])] {
            assert!(land(power, speed, time, x).is_none());
            x += v * power + 0.5 * power * power;
        }
        (x, land(r * r, speeds[2], 1.0 + dt[0] + dt[1], x))
    }

    #[test]
    fn the_sum_of_repeating_rounds_is_the_geometric_series() {
        for r in [0.5, 0.25, 0.125] {
            let (x, found) = limit(r, [2.0, 1.0], [1.0, r, r * r], [1.0, r]);
            let Limit { end, duration, repeats, .. } = found.expect("a limit");
            let sum = |r: f64| (2..200).map(|k| libm::pow(r, f64::from(k))).sum::<f64>();
            assert!(repeats && (duration - sum(r)).abs() < 1e-15, "{duration}");
            assert!((end.center.v.x - 2.0).abs() < 1e-15, "{}", end.center.v.x);
            let place = x + 2.0 * sum(r) + 0.5 * sum(r * r);
            assert!((end.center.r.x - place).abs() < 1e-15, "{} {place}", end.center.r.x);
        }
    }

    #[test]
    fn rounds_of_different_ratios_or_across_a_turn_of_the_slide_are_not_summed() {
        let is_summed = |v, speeds, dt| limit(0.5, v, speeds, dt).1.is_some();
        assert!(is_summed([2.0, 1.0], [1.0, 0.5, 0.25], [1.0, 0.5]));
        assert!(!is_summed([2.0, 1.0], [1.0, 0.5, 0.24], [1.0, 0.5]));
        assert!(!is_summed([2.0, 1.0], [1.0, 0.5, 0.25], [1.0, 0.6]));
        // From −1 + d/4 = 1 to −1 at the limit.
        assert!(!is_summed([-1.0, 8.0], [1.0, 0.5, 0.25], [1.0, 0.5]));
    }
}
