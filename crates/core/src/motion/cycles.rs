//! Cycles of two contacts: from one landing of a contact to its next one, while the other contact is held.

use nalgebra::Vector3;

use crate::body::contact::{ContactValues, PerContact};
use crate::body::terrain::Place;
use crate::math::clock::Clock;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::motion::series::Retry;
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{CYCLE_RATIO_ROUNDINGS, QUIET_LANDING, REACHED, REMAINDER_FACTOR, STILL};

/// Landings of a point before the first attempt to sum.
const FIRST_ATTEMPT: usize = 2;

/// Ratio of the landing speeds of successive laps above which there are so many that an attempt is worth its cost.
const SLOW: f64 = 0.3;

/// The cycles of two points.
#[derive(Debug, Clone, Default)]
pub(crate) struct NestedSequence {
    /// The two points, and for each of them the last cycle that ended with its landing.
    pair: [usize; 2],
    last: [Option<Cycle>; 2],
    /// For each point: since when it was held last while it slid to the left, stuck, and slid to the right.
    slides: ContactValues<[Option<Clock>; 3]>,
    /// The largest sliding speed that counted as zero, in m/s.
    dropped: f64,
}

/// A landing, while another contact is held, with a speed that counts as zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlowLanding {
    /// Whether all speeds count as zero, so that everything comes to rest; if not, only the contact that lands does.
    pub(super) quiet: bool,
    /// Error of the time of rest, in s.
    pub(super) error: f64,
}

impl SlowLanding {
    /// `landing`: speed of the landing; `left`: the largest of all speeds; `fastest`: of those of the run, in m/s; `gravity`: in m/s².
    pub(super) fn of(landing: f64, left: f64, fastest: f64, gravity: f64) -> Option<Self> {
        let (quiet, slow) = (left <= QUIET_LANDING * fastest, landing <= f64::EPSILON * fastest);
        let speed = if quiet { left } else { landing };
        (gravity > 0.0 && (quiet || slow))
            .then(|| Self { quiet, error: REMAINDER_FACTOR * speed / gravity })
    }
}

/// A cycle, at its end.
#[derive(Debug, Clone)]
pub(super) struct Cycle {
    pub(super) clock: Clock,
    pub(super) q: Coordinates,
    pub(super) qdot: Coordinates,
    /// Gap rate of the contact that lands, in m/s.
    pub(super) rate: f64,
    pub(super) places: [Place; 2],
    /// Ratio of the landing speeds of this cycle and the one before.
    pub(super) ratio: f64,
    /// Change of q̇ in this cycle.
    pub(super) change: Coordinates,
    /// In s.
    pub(super) duration: f64,
}

/// The sum of all further cycles.
#[derive(Debug, Clone)]
pub(super) struct CycleSum {
    /// The two points.
    pub(super) pair: [usize; 2],
    /// Displacement until the limit.
    pub(super) way: Coordinates,
    /// Velocity at the limit.
    pub(super) velocity: Coordinates,
    /// Time until then, in s.
    pub(super) duration: f64,
    /// r
    pub(super) ratio: f64,
    /// Whether cycles repeat themselves; if not, the time left is so short that they need not.
    pub(super) repeats: bool,
    /// Estimate of the error of that time, in s.
    pub(super) error: f64,
    /// The end of the cycle before the last one, the duration of the last one in s, and r²/(1 − r²).
    pub(super) before: Cycle,
    pub(super) last: f64,
    pub(super) rest: f64,
}

/// The limit of cycles.
#[derive(Debug, Clone)]
pub(super) struct Limit {
    /// With both contacts on the ground.
    pub(super) end: Moving,
    /// Time until then, in s.
    pub(super) duration: f64,
    pub(super) tail: Tail,
    /// Whether cycles repeat themselves; if not, the time left is so short that they need not.
    pub(super) repeats: bool,
    pub(super) certified: bool,
    /// Estimate of the error of that time, in s.
    pub(super) error: f64,
}

impl NestedSequence {
    /// Records the modes in which contacts are held from this time on.
    pub(crate) fn hold(&mut self, word: &[Mode], clock: Clock) {
        for (i, mode) in word.iter().enumerate().filter(|(_, mode)| **mode != Mode::Separate) {
            self.rubs(i, mode.direction(), clock);
        }
    }

    /// Records that friction acts at contact `i` from this time on, which slides in this direction, or sticks (0).
    pub(crate) fn rubs(&mut self, i: usize, way: f64, clock: Clock) {
        if self.slides.len() <= i {
            self.slides.resize(i + 1, [None; 3]);
        }
        self.slides[i][(way + 1.0) as usize] = Some(clock);
    }

    pub(crate) fn drop(&mut self, speed: f64) {
        self.dropped = self.dropped.max(speed);
    }

    /// Error of the time at which the body comes to rest, in s. A speed v that was set to zero is missing in all later cycles. This changes
    /// the time by about v/g, in which gravity compensates the speed.
    pub(crate) fn missing(&self, gravity: f64) -> f64 {
        if self.dropped > 0.0 { REMAINDER_FACTOR * self.dropped / gravity } else { 0.0 }
    }

    pub(crate) fn forget(&mut self) {
        self.last = [None, None];
    }

    /// Point `b` lands while point `k` alone is held. Cycles from one such landing to the next that shrink in one ratio r, with all
    /// times and all changes of velocity, are summed:
    ///
    /// ```text
    /// v_∞ = v + (v − v₀) r/(1 − r),   T = (t − t₀) r/(1 − r),   q_∞ = q + v_∞ T + (q − q₀ − v_∞ (t − t₀)) r²/(1 − r²)
    /// ```
    ///
    /// `now`: the state, and the size of a body in m; `fastest`: bound of the speeds so far; `left`: time to the end of the run; `alone`: whether the landing speed
    /// alone determines the motion after it, up to its scale, so that one cycle shows all.
    pub(super) fn next(
        &mut self,
        [b, k]: [usize; 2],
        alone: bool,
        (now, size): (&Moving, f64),
        clock: Clock,
        fastest: f64,
        left: f64,
    ) -> Option<CycleSum> {
        let (q, qdot, rate) = (now.displacement(), now.velocity(), now.point(b).1);
        let pair = [b.min(k), b.max(k)];
        if pair != self.pair {
            self.forget();
            self.pair = pair;
        }
        let own = usize::from(b > k);
        let start = Cycle {
            clock,
            q: q.clone(),
            qdot: qdot.clone(),
            rate,
            places: pair.map(|i| now.place(i)),
            ratio: f64::NAN,
            change: Coordinates::zeros(q.len()),
            duration: f64::NAN,
        };
        let last = self.last[own].replace(start)?;
        let (ratio, dt) = (rate / last.rate, clock.since(last.clock));
        let gained = qdot.plus(&last.qdot, -1.0);
        if let Some(cycle) = &mut self.last[own] {
            (cycle.ratio, cycle.change, cycle.duration) = (ratio, gained.clone(), dt);
        }
        let sum = ratio / (1.0 - ratio);
        let t = dt * sum;
        // The geometry has to stay the same, too: then times shrink in the same ratio. The deviation from it is of the order of
        // the angle of the body, which shrinks with the cycles.
        let turned = now.turned(&last.qdot, t, (dt / (ratio * last.duration) - 1.0).abs());
        // Ratios that differ by their rounding errors are one ratio.
        let rounding = CYCLE_RATIO_ROUNDINGS * f64::EPSILON;
        let other = (ratio - last.ratio).abs();
        let other = if other <= rounding * ratio { 0.0 } else { other };
        let change = if alone { 0.0 } else { t * (other / (1.0 - ratio) + turned) / (1.0 - ratio) };
        // The change of velocity in a cycle also has to repeat, to the accuracy with which the sum adds it: a contact that slid
        // in the previous cycle and sticks in this one may leave the ratio of the landing speeds unchanged.
        let unlike = now.speed_of(&gained.plus(&last.change, -ratio), size) * sum;
        let alike = alone || unlike <= STILL * fastest;
        let repeats = alike && change <= f64::EPSILON * clock.hi;
        let reached = t <= REACHED * clock.hi;
        let steady = now.turning().is_none_or(|body| body.falls_steadily(t));
        if !(0.0 < ratio && ratio < 1.0 && t <= left && steady) || !(repeats || reached) {
            return None;
        }
        let rest = ratio * ratio / (1.0 - ratio * ratio);
        let v = now.along(qdot.plus(&gained, sum));
        let repeated = q.plus(&last.q, -1.0).plus(&v.scaled(dt), -1.0);
        let way = now.along(v.scaled(t).plus(&repeated, rest));
        // A contact that slides in all cycles has to slide in the same direction at the limit, and one that sticks has to have
        // no sliding speed there: up to the rounding error of the sum, and to the speeds that count as zero.
        let tolerance = STILL * fastest + STILL.sqrt() * now.speed_of(&gained, size) * sum.max(1.0);
        let limit = now.moving(&v);
        let turns_back = |i: usize| {
            let slip = limit.slip(i);
            let in_cycle = |when: &Option<Clock>| when.is_some_and(|t| t.since(last.clock) >= 0.0);
            let slides = self.slides.get(i).unwrap_or(&[None; 3]);
            let [left, sticks, right] = slides.each_ref().map(in_cycle);
            now.slip(i) * slip < 0.0 && slip.abs() > tolerance
                || now.friction(i) > 0.0
                    && ((left || sticks) && slip > tolerance
                        || (right || sticks) && slip < -tolerance)
        };
        if !reached && pair.into_iter().any(turns_back) {
            return None;
        }
        let missing = self.missing(now.gravity());
        let error = if repeats { change + (rounding * t + missing) / (1.0 - ratio) } else { t };
        Some(CycleSum {
            pair,
            way,
            velocity: v,
            duration: t,
            ratio,
            repeats,
            error,
            before: last,
            last: dt,
            rest,
        })
    }
}

impl CycleSum {
    /// The body at the limit, on its ground. `None`: a point may come to an end of its piece before, or a third one to the ground. `speed`: bound
    /// of the speeds of points at the start of the last cycle, in m/s; `third`: whether a point is at most so far from the ground, in m.
    pub(super) fn end(
        &self,
        body: &BodyState,
        speed: f64,
        third: impl Fn(usize, f64) -> bool,
    ) -> Option<BodyState> {
        let Self { pair, way, velocity, duration: t, before, last: dt, rest, .. } = self;
        let [way, v] = [way, velocity].map(|v| Vector3::of(3, v.iter()));
        let far = REMAINDER_FACTOR * t * (speed + body.gravity * dt);
        let room = |p: &ContactState| p.place.sides.iter().all(|side| *side > far);
        let stays = pair
            .iter()
            .zip(&before.places)
            .all(|(&i, old)| body.points[i].place.piece == old.piece);
        let lands = (0..body.points.len()).any(|i| !pair.contains(&i) && third(i, far));
        if !stays || lands || body.turns() || !body.points.iter().all(room) {
            return None;
        }
        let mut end = body.clone();
        (end.center.v, end.spin.omega) = (v.xy(), v.z);
        // The distances to the ends of the pieces have the same sums. Near an end they are known better than positions.
        let known = pair.iter().zip(&before.places).map(|(&i, old)| {
            let now = body.points[i].place.sides;
            [0, 1].map(|side| {
                if now[side] == f64::INFINITY {
                    return f64::INFINITY;
                }
                let rate = end.side(i, side).u;
                let way = rate * t + (now[side] - old.sides[side] - rate * dt) * rest;
                (now[side] + way).max(0.0)
            })
        });
        let known: PerContact<[f64; 2]> = known.collect();
        end.spin.theta += way.z;
        end.displace(&way.xy(), &Turn::by(way.z));
        let BodyState { points, center, spin, .. } = &mut end;
        points.iter_mut().for_each(|p| p.u = p.normal.dot(&center.v) + p.b * spin.omega);
        for (&i, sides) in pair.iter().zip(known) {
            (points[i].h, points[i].u, points[i].place.sides) = (0.0, 0.0, sides);
        }
        Some(end)
    }
}

/// The point that alone is held in this word.
pub(super) fn only_held(word: &[Mode]) -> Option<usize> {
    let mut held = (0..word.len()).filter(|&i| word[i] != Mode::Separate);
    held.next().filter(|_| held.next().is_none())
}

/// The laps of two points.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Rocking {
    lands: usize,
    held: usize,
    /// Landing speed, in m/s.
    speed: f64,
    /// Ratio of the landing speeds of the last two laps.
    ratio: f64,
    /// Landings so far, and number of them at which to try to sum.
    landings: usize,
    next: usize,
}

impl Rocking {
    /// Point `b` lands at this speed while point `k` alone is held. Whether to try to sum.
    pub(super) fn follow(&mut self, b: usize, k: usize, speed: f64) -> bool {
        if self.landings > 0 && [b, k] == [self.held, self.lands] {
            return false;
        }
        if self.landings == 0 || [b, k] != [self.lands, self.held] {
            *self = Self { lands: b, held: k, next: FIRST_ATTEMPT, ..Self::default() };
        }
        (self.ratio, self.speed) = (speed / self.speed, speed);
        self.landings += 1;
        self.landings >= self.next && SLOW < self.ratio && self.ratio < 1.0
    }

    /// Waits for another attempt. Each lap divides the error of the polynomial by the ratio to the `degree`.
    pub(super) fn wait(&mut self, retry: Retry, degree: usize) {
        let wait = match retry {
            Retry::Smaller(error) => {
                let loss = -libm::log(self.ratio) * degree as f64;
                ((libm::log(error) / loss) as usize).saturating_add(1)
            }
            Retry::Later => self.landings,
        };
        self.next = self.landings.saturating_add(wait);
    }
}

/// The next landing of a point while the other one is held.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lap {
    pub(super) lands: usize,
    pub(super) held: usize,
    /// Whether the point that is held sticks.
    pub(super) sticks: bool,
    /// Landing speed, in m/s.
    pub(super) speed: Option<f64>,
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::collisions::log::{Center, Spin};
    use crate::sustained::Rounding;

    /// A rod that slides at v on level ground without friction; contact 2 lands with this speed.
    fn landing(x: f64, v: f64, speed: f64) -> BodyState {
        let (normal, tangent) = (Vector2::y(), Vector2::x());
        let (rounding, held) = (Rounding::default(), None);
        let point = |contact: usize, b: f64, u: f64| {
            let place = Place::anywhere(contact);
            let (friction, restitution, c, radius, h, depth) = (0.0, [0.0; 2], 0.0, 0.0, 0.0, 0.0);
            ContactState {
                normal,
                tangent,
                friction,
                surface_speed: 0.0,
                restitution,
                b,
                c,
                radius,
                corner: None,
                held,
                place,
                h,
                depth,
                u,
                rounding,
            }
        };
        let points = PerContact::from([point(0, -1.0, 0.0), point(1, 1.0, -speed)]);
        let center = Center { r: Vector2::new(x, 0.0), v: Vector2::new(v, 0.0) };
        let (spin, rho2, gravity) = (Spin::default(), 0.25, 1.0);
        let fall = Vector2::new(0.0, -gravity);
        BodyState {
            points,
            sides: Vec::new(),
            center,
            spin,
            rho2,
            fall,
            gravity,
            fall_rate: Vector2::zeros(),
        }
    }

    /// Three landings, at these speeds and times. Cycle k begins at the speed v_∞ + d rᵏ along the ground and moves the body
    /// by v_∞ rᵏ + ½ r²ᵏ: all of it exact for powers of two. The place at the last landing, and the limit.
    fn limit(
        r: f64,
        [v, d]: [f64; 2],
        speeds: [f64; 3],
        dt: [f64; 2],
    ) -> (f64, Option<(BodyState, CycleSum)>) {
        let (mut cycles, mut x) = (NestedSequence::default(), 0.0);
        let mut land = |power: f64, speed: f64, time: f64, x: f64| {
            let (body, clock) = (landing(x, v + d * power, speed), Clock::default().after(time));
            let now = Moving::Turning(Box::new(body.clone()));
            let sum = cycles.next([1, 0], false, (&now, 1.0), clock, 10.0, f64::INFINITY)?;
            Some((sum.end(&body, now.speed_of(&sum.before.qdot, 1.0), |_, _| true)?, sum))
        };
        for (power, speed, time) in [(1.0, speeds[0], 1.0), (r, speeds[1], 1.0 + dt[0])] {
            assert!(land(power, speed, time, x).is_none());
            x += v * power + 0.5 * power * power;
        }
        (x, land(r * r, speeds[2], 1.0 + dt[0] + dt[1], x))
    }

    #[test]
    fn the_sum_of_repeating_cycles_is_the_geometric_series() {
        for r in [0.5, 0.25, 0.125] {
            let (x, found) = limit(r, [2.0, 1.0], [1.0, r, r * r], [1.0, r]);
            let (end, CycleSum { duration, repeats, .. }) = found.expect("a limit");
            let sum = |r: f64| (2..200).map(|k| libm::pow(r, f64::from(k))).sum::<f64>();
            assert!(repeats && (duration - sum(r)).abs() < 1e-15, "{duration}");
            assert!((end.center.v.x - 2.0).abs() < 1e-15, "{}", end.center.v.x);
            let place = x + 2.0 * sum(r) + 0.5 * sum(r * r);
            assert!((end.center.r.x - place).abs() < 1e-15, "{} {place}", end.center.r.x);
        }
    }

    #[test]
    fn cycles_of_different_ratios_or_across_a_turn_of_the_slide_are_not_summed() {
        let is_summed = |v, speeds, dt| limit(0.5, v, speeds, dt).1.is_some();
        assert!(is_summed([2.0, 1.0], [1.0, 0.5, 0.25], [1.0, 0.5]));
        assert!(!is_summed([2.0, 1.0], [1.0, 0.5, 0.24], [1.0, 0.5]));
        assert!(!is_summed([2.0, 1.0], [1.0, 0.5, 0.25], [1.0, 0.6]));
        // From −1 + d/4 = 1 to −1 at the limit.
        assert!(!is_summed([-1.0, 8.0], [1.0, 0.5, 0.25], [1.0, 0.5]));
    }
}
