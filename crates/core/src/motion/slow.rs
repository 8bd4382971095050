//! Ends of sequences of impacts: infinitely many at one instant, which are summed, and impacts whose speeds are rounding error.

use crate::body::contact::ContactValues;
use crate::math::mass_vector::Coordinates;
use crate::motion::driver::Driver;
use crate::motion::series::{FEW, GoesOn};
use crate::outcome::Outcome;
use crate::tolerance::{CONTACT_STOPPED, HIT_IN_TURN, TOUCH};

/// The gap rate of a touching point at the limit of shrinking cycles, from its rate now and at the start of the last cycle; `None`: it is
/// hit before the limit. Only a point that approached throughout may wait.
fn limit_of_rate(now: f64, start: f64, sum: f64) -> Option<f64> {
    let limit = now + (now - start) * sum;
    if limit.abs() <= FEW * (1.0 + sum) * start.abs() {
        return Some(0.0);
    }
    (limit >= 0.0 || now < 0.0 && start < 0.0).then_some(limit)
}

/// Returns true if the cycles change before the limit, at which the point rests: its slide reverses, or the impulses of friction (`rub`) do
/// not oppose it, as they do in an impact that is much slower than the slide.
fn turns_back(now: f64, limit: f64, rub: f64, fastest: f64) -> bool {
    limit.abs() > FEW * fastest && (now * limit < 0.0 || rub * limit > 0.0)
}

impl Driver<'_> {
    /// Point `i` is about to be hit, after others at the same instant. If the cycles from one impact at `i` to the next shrink in
    /// one ratio r, with all changes of velocity, infinitely many of them are summed:
    ///
    /// ```text
    /// v_∞ = v + Δv r/(1 − r)
    /// ```
    ///
    /// Contacts whose rates become zero in the limit are hit infinitely often; they come to rest. Returns whether it summed.
    pub(super) fn sum_up(&mut self, i: usize) -> bool {
        let (state, fastest, clock) = (&self.state, self.fastest, self.log.clock);
        let count = state.count();
        let rates: ContactValues<f64> = state.points().map(|(_, u)| u).collect();
        let pieces: ContactValues<isize> = (0..count).map(|j| state.place(j).piece).collect();
        let size = |change: &Coordinates| state.size(change);
        let (change, sum, start, rubs) =
            match self.sequence.next(i, clock, &rates, pieces, size, fastest) {
                GoesOn::Somehow => return false,
                GoesOn::InVertex => {
                    if let Some(mut ground) = self.on_ground() {
                        ground.stop_in_vertex(i);
                    }
                    return true;
                }
                GoesOn::Shrinking { change, sum, start, rubs } => (change, sum, start, rubs),
            };
        let mut end = state.clone();
        end.add(&change, sum);
        for j in 0..count {
            let (h, u) = state.point(j);
            let rate = match h > 0.0 {
                true => Some(u + sum * state.rate_of(j, &change)),
                false => limit_of_rate(u, start[j], sum),
            };
            let Some(rate) = rate else { return false };
            end.set_point(j, (h, rate));
        }
        // A contact that slides throughout has to slide in the same direction at the end.
        let turns_back = |j: usize| {
            let (now, limit) = (state.slip(j), end.slip(j));
            end.point(j).1 == 0.0 && turns_back(now, limit, rubs[j], fastest)
        };
        if (0..count).any(turns_back) {
            return false;
        }
        self.state = end;
        self.sequence.summed(&change, &rubs, sum);
        true
    }

    /// After an impact with the speed `hit` (m/s): sets those contacts to rest that are so slow and so near the ground that their remaining
    /// motion is below its rounding error. A slow contact waits while another contact is nearly as slow, because the two may be hit in
    /// turn. Impacts nearly as slow that become neither slower nor faster are ended too, because rounding errors of faster motions sustain
    /// them.
    pub(super) fn stop_slow(&mut self, hit: f64) -> Option<Outcome> {
        self.stop(hit, hit)
    }

    /// As `stop_slow`, after an impact without collision.
    pub(super) fn stop_after_jam(&mut self) -> Option<Outcome> {
        self.stop(0.0, f64::INFINITY)
    }

    /// Returns true if an impact with this speed (m/s) counts as one of an accumulation.
    pub(super) fn fades(&self, hit: f64) -> bool {
        hit <= HIT_IN_TURN * CONTACT_STOPPED * self.fastest
    }

    /// `hit`: the speed of the collision; `by`: the speed of the impact that brings contacts to rest, in m/s; infinite if no impact does.
    fn stop(&mut self, hit: f64, by: f64) -> Option<Outcome> {
        let limit = CONTACT_STOPPED * self.fastest;
        let count = self.state.count();
        let pulls: ContactValues<f64> = (0..count).map(|i| self.state.pull(i)).collect();
        // Without gravity, or with very little, a contact may be slow at any height.
        let near = TOUCH * self.place();
        let speed = |((h, u), pull): ((f64, f64), &f64)| match (h, *pull > 0.0) {
            (0.0, _) => u.abs(),
            (h, true) if h <= near => (u * u + 2.0 * pull * h).sqrt(),
            _ => f64::INFINITY,
        };
        let speeds: ContactValues<f64> = self.state.points().zip(&pulls).map(speed).collect();
        let (slow, watched) = self.slow.stopping(hit, &speeds, limit);
        let is_hit_in_turn = |i: usize| slow[i] && self.sequence.is_hit_in_turn(i, self.log.clock);
        let in_turn = (0..count).filter(|&i| is_hit_in_turn(i)).count() > 1;
        let (mut stopped, mut error) = (ContactValues::<usize>::new(), 0.0_f64);
        let mut stops: ContactValues<bool> =
            self.state.points().map(|point| point == (0.0, 0.0)).collect();
        for (i, &speed) in speeds.iter().enumerate().filter(|(i, _)| slow[*i]) {
            stops[i] = true;
            let loss = 1.0 - self.state.material(i).restitution;
            // A contact with upward effective gravity does not come to rest by itself. Contacts that are hit in turn stop each other.
            if in_turn && is_hit_in_turn(i) || !self.resting[i] && pulls[i] >= 0.0 {
                if pulls[i] > 0.0 {
                    // With restitution 1 the contact would bounce until the end of the run.
                    let bounces = 2.0 * speed / (pulls[i] * loss);
                    error = error.max(bounces.min(self.log.left()));
                }
                stopped.push(i);
            }
        }
        if slow.contains(&true) {
            let change = self.state.arrest(&stops);
            self.sequence.changes(&change);
            self.state.reconcile(self.place());
            // Where a rate follows from others, it is their rounding error.
            for i in (0..count).filter(|&i| stops[i]) {
                self.state.set_point(i, (0.0, 0.0));
            }
            if self.slow.chatters() && self.speed_over_ground() <= watched {
                self.state.stand();
            }
        }
        // Where another contact is about to be hit at this instant, the impacts go on.
        if stopped.is_empty() || self.state.points().any(|(h, u)| h == 0.0 && u < 0.0) {
            return None;
        }
        if self.slow.stopped() {
            self.stopped_chatter.0.extend(stopped.iter().map(|&i| self.state.contact(i)));
            self.stopped_chatter.1 = watched;
        }
        self.settle(&stopped, None, false, error + self.cycles.missing(self.state.gravity()), by)
    }
}
