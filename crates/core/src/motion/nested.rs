//! Sums of infinitely many cycles. A cycle goes from one landing of a contact to its next landing, while the other contact is
//! held. The cycles repeat on a smaller and smaller scale.

use nalgebra::{SVector, Vector3};

use crate::body::terrain::Place;
use crate::collisions::log::Spin;
use crate::math::clock::Clock;
use crate::math::collocation::{doubt, places, steps};
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::outcome::{Outcome, ZenoMethod};
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{
    BOUNCE_CHANGE, CYCLE_RATIO_ROUNDINGS, NEXT_TERM, QUIET_LANDING, REACHED, REMAINDER_FACTOR,
    STILL,
};
use crate::zeno::Gaps;

/// The cycles of two contacts.
#[derive(Debug, Clone, Default)]
pub(crate) struct NestedSequence {
    /// For each contact: the last cycle that ended with its landing.
    last: [Option<Cycle>; 2],
    /// For each contact: since when it was held last while it slid to the left, stuck, and slid to the right.
    slides: [[Option<Clock>; 3]; 2],
    /// The largest sliding speed that counted as zero, in m/s.
    dropped: f64,
    /// For each contact: its landings since the sequence began.
    landings: [usize; 2],
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
struct Cycle {
    clock: Clock,
    q: Coordinates,
    qdot: Coordinates,
    /// Gap rate of the contact that lands, in m/s.
    rate: f64,
    places: [Place; 2],
    /// Ratio of the landing speeds of this cycle and the one before.
    ratio: f64,
    /// Change of q̇ in this cycle.
    change: Coordinates,
    /// In s.
    duration: f64,
}

/// The sum of all further cycles.
#[derive(Debug, Clone)]
struct CycleSum {
    /// Displacement until the limit.
    way: Coordinates,
    /// Velocity at the limit.
    velocity: Coordinates,
    /// Time until then, in s.
    duration: f64,
    /// r
    ratio: f64,
    /// Whether cycles repeat themselves; if not, the time left is so short that they need not.
    repeats: bool,
    /// Estimate of the error of that time, in s.
    error: f64,
    /// The end of the cycle before the last one, the duration of the last one in s, and r²/(1 − r²).
    before: Cycle,
    last: f64,
    rest: f64,
}

/// The limit of cycles.
#[derive(Debug, Clone)]
struct Limit {
    /// With both contacts on the ground.
    end: Moving,
    /// Time until then, in s.
    duration: f64,
    tail: Tail,
    /// Whether cycles repeat themselves; if not, the time left is so short that they need not.
    repeats: bool,
    certified: bool,
    /// Estimate of the error of that time, in s.
    error: f64,
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
        if let Some(slides) = self.slides.get_mut(i) {
            slides[(way + 1.0) as usize] = Some(clock);
        }
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
        (self.last, self.landings) = ([None, None], [0; 2]);
    }

    /// Contact `b` lands while the other is held. Cycles from one such landing to the next that shrink in one ratio r, with all
    /// times and all changes of velocity, are summed:
    ///
    /// ```text
    /// v_∞ = v + (v − v₀) r/(1 − r),   T = (t − t₀) r/(1 − r),   q_∞ = q + v_∞ T + (q − q₀ − v_∞ (t − t₀)) r²/(1 − r²)
    /// ```
    ///
    /// `now`: the state, and the size of a body in m; `fastest`: bound of the speeds so far; `left`: time to the end of the run; `alone`: whether the landing speed
    /// alone determines the motion after it, up to its scale, so that one cycle shows all.
    fn next(
        &mut self,
        b: usize,
        alone: bool,
        (now, size): (&Moving, f64),
        clock: Clock,
        fastest: f64,
        left: f64,
    ) -> Option<CycleSum> {
        let (q, qdot, rate) = (now.displacement(), now.velocity(), now.point(b).1);
        let start = Cycle {
            clock,
            q: q.clone(),
            qdot: qdot.clone(),
            rate,
            places: [0, 1].map(|i| now.place(i)),
            ratio: f64::NAN,
            change: Coordinates::zeros(q.len()),
            duration: f64::NAN,
        };
        self.landings[b] += 1;
        let last = self.last[b].replace(start)?;
        let (ratio, dt) = (rate / last.rate, clock.since(last.clock));
        let gained = qdot.plus(&last.qdot, -1.0);
        if let Some(cycle) = &mut self.last[b] {
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
        if !(0.0 < ratio && ratio < 1.0 && t <= left) || !(repeats || reached) {
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
            let [left, sticks, right] = self.slides[i].each_ref().map(in_cycle);
            now.slip(i) * slip < 0.0 && slip.abs() > tolerance
                || now.friction(i) > 0.0
                    && ((left || sticks) && slip > tolerance
                        || (right || sticks) && slip < -tolerance)
        };
        if !reached && (0..2).any(turns_back) {
            return None;
        }
        let missing = self.missing(now.gravity());
        let error = if repeats { change + (rounding * t + missing) / (1.0 - ratio) } else { t };
        Some(CycleSum {
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

    /// Whether to look for the limit of cycles that do not repeat themselves yet, after a landing of contact `b`.
    fn is_long(&self, b: usize) -> bool {
        let ratio = self.last[b].as_ref().map_or(0.0, |last| last.ratio);
        let count = self.landings[b];
        count >= FIRST_ATTEMPT && count.is_power_of_two() && ratio > SLOW && ratio < 1.0
    }
}

impl CycleSum {
    /// The body at the limit, on its ground; `None` if a point may come to an end of its piece before. `speed`: bound of the speeds of points at
    /// the start of the last cycle, in m/s.
    fn end(&self, body: &BodyState, speed: f64) -> Option<BodyState> {
        let Self { way, velocity, duration: t, before, last: dt, rest, .. } = self;
        let [way, v] = [way, velocity].map(|v| Vector3::of(3, v.iter()));
        let far = t * (speed + body.gravity * dt);
        let room =
            |p: &ContactState| p.place.sides.iter().all(|side| *side > REMAINDER_FACTOR * far);
        let stays = (0..2).all(|i| body.points[i].place.piece == before.places[i].piece);
        if !(stays && body.points.iter().all(room)) {
            return None;
        }
        let mut end = body.clone();
        (end.center.v, end.center.r) = (v.xy(), body.center.r + way.xy());
        end.spin = Spin { theta: body.spin.theta + way.z, omega: v.z };
        // The distances to the ends of the pieces have the same sums. Near an end they are known better than positions.
        for (i, old) in before.places.iter().enumerate() {
            let place = body.points[i].place;
            for side in (0..2).filter(|&side| place.sides[side] < f64::INFINITY) {
                let (now, rate) = (place.sides[side], end.side(i, side).u);
                let way = rate * t + (now - old.sides[side] - rate * dt) * rest;
                end.points[i].place.sides[side] = (now + way).max(0.0);
            }
        }
        let onward = Turn::by(way.z);
        for p in &mut end.points {
            (p.h, p.u) = (0.0, 0.0);
            (p.b, p.c) = p.turned(&onward);
        }
        Some(end)
    }
}

/// Degree of the polynomial.
const DEGREE: usize = 8;

/// Landings of a contact before the first attempt to sum cycles that do not repeat themselves.
const FIRST_ATTEMPT: usize = 4;

/// Ratio of the landing speeds of successive cycles above which there are so many that the attempt is worth its cost: that of about
/// [`DEGREE`] cycles.
const SLOW: f64 = 0.5;

/// The next landing of a contact while the other one is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lap {
    pub(super) contact: usize,
    /// Its speed, in m/s.
    pub(super) speed: Option<f64>,
}

impl Driver<'_> {
    /// Contact `b` lands while the other of two contacts is held. If all further cycles are known, moves to their limit.
    pub(super) fn sum_cycles(&mut self, b: usize) -> Option<Option<Outcome>> {
        let Limit { end, duration, tail, repeats, certified, error } =
            self.limit_of_cycles(b).or_else(|| self.limit_of_laps(b))?;
        if let (Some(posture), Some(body)) = (self.record.subject.posture(), end.turning())
            && self.edges.is_inside(posture, body)
        {
            return None; // it has entered in one of the cycles
        }
        self.cycles.forget();
        self.begin_sum(tail);
        (self.state, self.log.clock) = (end, self.log.clock.after(duration));
        let method = if repeats { ZenoMethod::Nested } else { ZenoMethod::Mixed };
        Some(self.settle(&[0, 1], Some(method), certified, error, 0.0))
    }

    fn limit_of_cycles(&mut self, b: usize) -> Option<Limit> {
        let (clock, left, fastest) = (self.log.clock, self.log.left(), self.fastest);
        // Without friction the gaps over constant rows move by themselves, and all their motions scale.
        let alone = match &self.state {
            Moving::Frozen(rows) if rows.rows.friction.iter().all(|mu| *mu == 0.0) => {
                rows.rows.gaps
            }
            _ => None,
        };
        let (state, size) = (&self.state, self.place);
        let sum = self.cycles.next(b, alone.is_some(), (state, size), clock, fastest, left)?;
        let (t, repeats, error) = (sum.duration, sum.repeats, sum.error);
        let certified = alone.is_some() && repeats;
        let (end, tail) = match (state, alone) {
            (Moving::Turning(body), _) => {
                let speed = state.speed_of(&sum.before.qdot, size);
                (Moving::Turning(Box::new(sum.end(body, speed)?)), Tail::Collisions)
            }
            (Moving::Frozen(rows), Some(model)) => {
                let end = rows.hit(t, &model.settle(&rows.gaps(), t), &Gaps::default());
                (Moving::Frozen(Box::new(end)), Tail::Cycle { ratio: sum.ratio, duration: t })
            }
            (Moving::Frozen(rows), None) => {
                let mut end = rows.clone();
                end.y.add_scaled(&sum.way, 1.0);
                end.v = sum.velocity;
                end.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
                (Moving::Frozen(end), Tail::Collisions)
            }
        };
        Some(Limit { end, duration: t, tail, repeats, certified, error })
    }

    /// The limit of all cycles from this landing of contact `b` on, in the full geometry. On parallel ground without friction a body that
    /// touches it with both contacts, one of them held, is in one position, and the landing speed alone determines the cycle that follows: its
    /// duration τ(u) and the next landing speed R(u), both analytic. The time left is the sum
    ///
    /// ```text
    /// T(u) = τ(u) + T(R(u)),   T(0) = 0
    /// ```
    ///
    /// which determines a polynomial Σ t_m s^m, u = s u(1), at the places s_j, by one cycle from each of these landing speeds. Along the
    /// ground the body moves as if it fell freely.
    fn limit_of_laps(&self, b: usize) -> Option<Limit> {
        let body = self.state.turning()?;
        let (one, two) = (&body.points[b], &body.points[1 - b]);
        let free = |p: &ContactState| p.friction == 0.0 && p.place.sides == [f64::INFINITY; 2];
        let parallel = one.normal == two.normal && one.b != two.b;
        if !(self.cycles.is_long(b) && free(one) && free(two) && parallel) {
            return None;
        }
        let (first, places) = (-one.u, places());
        let (mut ratios, mut times) = ([0.0; DEGREE], SVector::<f64, DEGREE>::zeros());
        for (j, s) in places.iter().enumerate() {
            let (speed, time) = self.lap(b, body, s * first)?;
            (ratios[j], times[j]) = (speed / (s * first), time);
        }
        if !ratios.iter().all(|ratio| *ratio > 0.0 && *ratio < 1.0) {
            return None;
        }
        let terms = steps::<DEGREE>(&places, &ratios).lu().solve(&-times)?;
        let sum = |s: f64| terms.iter().rev().fold(0.0, |sum, term| (sum + term) * s);
        let (t, now, least) =
            (sum(1.0), self.log.clock.hi, ratios.iter().fold(1.0, |a, r| f64::min(a, 1.0 - r)));
        let doubt = doubt(0.0, &places, places.map(sum), NEXT_TERM);
        // A rounding error of R changes what a cycle takes off by 1/(1 − r) times as much.
        let rounding = BOUNCE_CHANGE * f64::EPSILON * (now + t / least);
        if !(t > 0.0 && t <= self.log.left() && doubt <= rounding) {
            return None;
        }
        let along = one.tangent * one.tangent.dot(&body.center.v);
        let fall = one.tangent * one.tangent.dot(&body.fall);
        let mut end = body.clone();
        end.center.r += along * t + fall * (0.5 * t * t);
        (end.center.v, end.spin.omega) = (along + fall * t, 0.0);
        end.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
        Some(Limit {
            end: Moving::Turning(Box::new(end)),
            duration: t,
            tail: Tail::Collisions,
            repeats: true,
            certified: false,
            error: doubt + rounding,
        })
    }

    /// Speed (m/s) and time (s) of the next landing of contact `b` after one with this speed.
    fn lap(&self, b: usize, body: &BodyState, speed: f64) -> Option<(f64, f64)> {
        let posture = self.record.subject.posture()?;
        let mut start = body.clone();
        let (one, two) = (start.points[b], start.points[1 - b]);
        let along = one.tangent * one.tangent.dot(&start.center.v);
        start.spin.omega = -speed / (one.b - two.b);
        start.center.v = along - one.normal * (two.b * start.spin.omega);
        (start.points[b].h, start.points[b].u) = (0.0, -speed);
        (start.points[1 - b].h, start.points[1 - b].u) = (0.0, 0.0);
        let options = self.options.of_resimulated_tail(f64::INFINITY);
        let subject = self.record.subject.clone();
        let mut run = Driver::of_body(posture, start, subject, &options, Vec::new(), &|| false);
        run.resting[1 - b] = true;
        run.fastest = speed;
        run.lap = Some(Lap { contact: b, speed: None });
        run.motion();
        Some((run.lap?.speed?, run.log.clock.hi))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;
    use crate::body::contact::PerContact;
    use crate::collisions::log::Center;
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
                restitution,
                b,
                c,
                radius,
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
        BodyState { points, sides: Vec::new(), center, spin, rho2, fall, gravity }
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
            let sum = cycles.next(1, false, (&now, 1.0), clock, 10.0, f64::INFINITY)?;
            Some((sum.end(&body, now.speed_of(&sum.before.qdot, 1.0))?, sum))
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
