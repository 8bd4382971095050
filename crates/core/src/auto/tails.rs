//! The summed tails of the local run, summed in the geometry of the local model and in that of the full model.

use nalgebra::Vector3;

use crate::auto::{Shadow, along};
use crate::body::geometry::ContactGeometry;
use crate::motion::record::{Tail, ZenoRecord};
use crate::outcome::{ModelReason, ZenoMethod};
use crate::tolerance::UNFOLLOWED_FACTOR;
use crate::zeno::{FrozenModel, Gaps, Impulses};

impl Shadow<'_> {
    /// Follows a summed tail of duration `t` that begins with these gaps.
    pub(super) fn sum(
        &mut self,
        tail: Tail,
        point: &ZenoRecord,
        gaps: &Gaps,
        t: f64,
        last: bool,
    ) -> Result<(), ModelReason> {
        match tail {
            Tail::Bounce { contact } => self.bounce(contact, t, last),
            Tail::Cycle { .. } => {
                // Two contacts that bounce in step: the body does not rotate in either motion, and both motions are the
                // same.
                if !(self.agrees() && self.qdot.z == 0.0) {
                    return Err(ModelReason::OtherOrder);
                }
                let (local, _) = self.both_frozen();
                let own = local.settle(gaps, t);
                self.close((t, own), (t, own), [true, true])
            }
            Tail::Collisions => self.clatter(point, gaps, t),
        }
    }

    /// Contact a bounces until it rests, for a duration `t` in the local run.
    pub(super) fn bounce(&mut self, a: usize, mut t: f64, last: bool) -> Result<(), ModelReason> {
        let ContactGeometry { restitution: e, gravity: g, .. } = self.contacts[a];
        let k = &self.contacts[a];
        // T = 2u/(g(1−e)): the next flight takes the part 1 − e of it. The closed sum is used once the change of the
        // geometry in the remaining time is negligible: c ω² relative to g, and the change of the arms, which affects
        // times only if other events follow.
        while t > 0.0 {
            let omega = (self.qdot.z + self.dqdot.z).abs();
            let change = k.b.abs() * g * t / (k.b * k.b + self.rho2);
            let angle = (omega + change) * t;
            let turned = angle * (k.c.abs() + k.b.abs() * angle);
            let pull = k.c.abs() * change * (2.0 * omega + change)
                + (omega + change) * (omega + change) * k.b.abs() * angle;
            let later = if last { 0.0 } else { t * turned * self.lever / self.rho2.sqrt() };
            let place = turned * g * t * t / self.rho2;
            let change = t * pull / g + later;
            if change <= self.small && place <= self.small / self.whole {
                self.slack += change;
                self.loose += place;
                break;
            }
            let dt = (1.0 - e) * t;
            let speed = 0.5 * g * dt;
            self.fly(dt)?;
            self.u[a] = -speed;
            self.land(a, self.fall)?;
            self.clears_now(1 - a)?;
            self.hit(a, (1.0 + e) * speed)?;
            self.u[a] = e * speed;
            t *= e;
        }
        let (local, full) = self.both_frozen();
        let end = |frozen: &FrozenModel, u: f64| {
            let t = frozen.bounce[a] * u;
            let mut gaps = Gaps::default();
            gaps.u[a] = u;
            (t, frozen.end_bounce(a, &gaps, t).1)
        };
        let (short, long) = (end(&local, 0.5 * g * (1.0 - e) * t), end(&full, self.rate(a)));
        if let Some(other) = self.contacts.get(1 - a) {
            let mut near = Gaps::default();
            self.u[1 - a] = along(other, &self.qdot);
            near.h[1 - a] = along(other, &self.q) + self.gap_off(1 - a);
            near.u = [self.rate(0), self.rate(1)];
            full.bounce_tail(a, &near).ok_or(ModelReason::OtherOrder)?;
        }
        self.close(short, long, [a == 0, a == 1])
    }

    /// Checks that contact i is above the terrain in the shadow, at its current gap in the local run.
    pub(super) fn clears_now(&self, i: usize) -> Result<(), ModelReason> {
        let gap = self.contacts.get(i).map_or(0.0, |k| along(k, &self.q));
        self.clears(i, gap)
    }

    /// Both contacts come to rest within a duration `t` of the local run.
    pub(super) fn clatter(
        &mut self,
        point: &ZenoRecord,
        gaps: &Gaps,
        t: f64,
    ) -> Result<(), ModelReason> {
        let (local, full) = self.both_frozen();
        let mut near = *gaps;
        for i in 0..2 {
            near.h[i] += if self.touching[i] { 0.0 } else { self.gap_off(i) };
            near.u[i] = self.rate(i);
        }
        if point.method == ZenoMethod::Clatter {
            let a = usize::from(gaps.h[1] == 0.0);
            let tail = full.clatter_tail(a, &near).filter(|_| full.certainly_clatters(a, &near));
            let t_full = tail.ok_or(ModelReason::OtherOrder)?.duration;
            let (short, long) = (local.settle(gaps, t), full.settle(&near, t_full));
            return self.close((t, short), (t_full, long), [true, true]);
        }
        // This tail is not followed. Its error is estimated from the differences in speed and geometry at its start,
        // times a safety factor.
        let fastest = gaps.u[0].abs().max(gaps.u[1].abs());
        let off = (0..2).map(|i| (near.u[i] - gaps.u[i]).abs()).fold(0.0, f64::max) / fastest;
        let angle = (self.q.z + self.dq.z).abs() + (self.qdot.z.abs() + self.dqdot.z.abs()) * t;
        self.slack += UNFOLLOWED_FACTOR * t * (off + angle * self.lever);
        self.arrive(point);
        Ok(())
    }

    /// Moves the local run to its Zeno point, with both contacts at rest. The differences in q and in time stay unchanged.
    pub(super) fn arrive(&mut self, point: &ZenoRecord) {
        (self.q, self.qdot) = (point.at.state.q, point.at.state.qdot);
        self.clock = point.at.clock;
        self.touching = [true, true];
        self.measure();
        self.turn();
        self.stop([true, true]);
    }

    /// Ends a tail, given the durations and impulses of the tail in the local run and in its shadow.
    pub(super) fn close(
        &mut self,
        (t, local): (f64, Impulses),
        (t_full, full): (f64, Impulses),
        closed: [bool; 2],
    ) -> Result<(), ModelReason> {
        let (v, nominal) = (self.velocity(), self.nominal());
        let place = |v: Vector3<f64>, t: f64| (v + self.fall * (0.5 * t)) * t;
        let path = place(self.qdot, t) + self.velocity_changes(&nominal, local.path);
        let path_full = place(v, t_full) + self.velocity_changes(&self.arms, full.path);
        let change = self.fall * t + self.velocity_changes(&nominal, local.jump);
        let change_full = self.fall * t_full + self.velocity_changes(&self.arms, full.jump);
        self.q += path;
        self.qdot += change;
        self.dq += path_full - path;
        self.dqdot += change_full - change;
        self.late += t_full - t;
        self.turn();
        self.measure();
        for i in 0..2 {
            self.touching[i] |= closed[i];
        }
        self.stop(closed);
        Ok(())
    }

    /// Removes from the shadow the velocity that changes the gaps of the closed contacts.
    pub(super) fn stop(&mut self, closed: [bool; 2]) {
        let left = |i: usize| if i < self.count() && closed[i] { -self.rate(i) } else { 0.0 };
        let mut jumps = [left(0), left(1)];
        if closed == [true, true] && self.count() == 2 {
            jumps = self.frozen(&self.arms, 0.0).solve_coupled(jumps);
        }
        self.dqdot += self.velocity_changes(&self.arms, jumps);
    }

    /// One contact rests, the other lands, and both stop at that instant after infinitely many impacts.
    pub(super) fn chatter(&mut self) -> Result<(), ModelReason> {
        let (local, full) = self.both_frozen();
        if !(local.chatters() && full.chatters()) {
            return Err(ModelReason::OtherOrder);
        }
        let change =
            self.velocity_changes(&self.nominal(), local.solve_coupled(self.u.map(|u| -u)));
        self.qdot += change;
        self.dqdot -= change;
        self.u = [0.0; 2];
        self.touching = [true, true];
        self.stop([true, true]);
        Ok(())
    }
}
