//! Sums of infinitely many cycles. A cycle goes from one landing of a contact to its next landing, while the other contact is
//! held. The cycles repeat on a smaller and smaller scale.

use crate::math::mass_vector::MassVector;
use crate::motion::cycles::{Limit, Rocking};
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::outcome::{Outcome, ZenoMethod};
use crate::zeno::Gaps;

impl Driver<'_> {
    /// Point `b` lands while point `k` alone is held. If all further cycles are known, moves to their limit.
    pub(super) fn sum_cycles(&mut self, b: usize, k: usize) -> Option<Option<Outcome>> {
        let limit = self.limit_of_cycles(b, k)?;
        self.go_to_limit(&[b.min(k), b.max(k)], limit)
    }

    /// Moves to this limit, at which these points come to rest.
    pub(super) fn go_to_limit(
        &mut self,
        points: &[usize],
        limit: Limit,
    ) -> Option<Option<Outcome>> {
        let Limit { end, duration, tail, repeats, certified, error } = limit;
        if let (Some(posture), Some(body)) = (self.record.subject.posture(), end.turning())
            && self.edges.is_inside(posture, body)
        {
            return None; // it has entered in one of the cycles
        }
        self.cycles.forget();
        self.rocking = Rocking::default();
        self.begin_sum(tail);
        (self.state, self.log.clock) = (end, self.log.clock.after(duration));
        let method = if repeats { ZenoMethod::Nested } else { ZenoMethod::Mixed };
        Some(self.settle(points, Some(method), certified, error, 0.0))
    }

    fn limit_of_cycles(&mut self, b: usize, k: usize) -> Option<Limit> {
        let (clock, left, fastest) = (self.log.clock, self.log.left(), self.fastest);
        // Without friction the gaps over constant rows move by themselves, and all their motions scale.
        let alone = match &self.state {
            Moving::Frozen(rows) if rows.rows.friction.iter().all(|mu| *mu == 0.0) => {
                rows.rows.gaps
            }
            _ => None,
        };
        let (state, size) = (&self.state, self.place);
        let sum = self.cycles.next([b, k], alone.is_some(), (state, size), clock, fastest, left)?;
        let (t, repeats, error) = (sum.duration, sum.repeats, sum.error);
        let certified = alone.is_some() && repeats;
        let (end, tail) = match (state, alone) {
            (Moving::Turning(body), _) => {
                let (speed, posture) =
                    (state.speed_of(&sum.before.qdot, size), self.record.subject.posture()?);
                let third = |i: usize, far: f64| {
                    let p = &body.points[i];
                    p.depth > 0.0 || p.h <= far || !body.is_far_from_others(i, posture, far)
                };
                let end = sum.end(body, speed, third)?;
                (Moving::Turning(Box::new(end)), Tail::Collisions)
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
}
