//! Sums of infinitely many cycles. A cycle goes from one landing of a contact to its next landing, while the other contact is
//! held. The cycles repeat on a smaller and smaller scale.

use nalgebra::SVector;

use crate::math::collocation::{doubt, places, steps};
use crate::math::mass_vector::MassVector;
use crate::motion::cycles::{Lap, Limit};
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::outcome::{Outcome, ZenoMethod};
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{BOUNCE_CHANGE, NEXT_TERM};
use crate::zeno::Gaps;

/// Degree of the polynomial.
const DEGREE: usize = 8;

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
        if !(t > 0.0 && t <= self.log.left() && body.falls_steadily(t) && doubt <= rounding) {
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
