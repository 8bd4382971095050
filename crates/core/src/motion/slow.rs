//! Ends of sequences of impacts: infinitely many at one instant, which are summed, and impacts whose speeds are rounding error.

use nalgebra::Vector3;

use crate::body::contact::ContactValues;
use crate::collisions::log::{in_words, names};
use crate::math::clock::Clock;
use crate::motion::any::AnyContacts;
use crate::motion::driver::Driver;
use crate::outcome::Outcome;
use crate::sustained::ContactState;
use crate::tolerance::{
    CONTACT_STOPPED, HIT_IN_TURN, SELF_SIMILAR, SEQUENCE_RATIO_ROUNDINGS, SLOWER_STRETCH,
    SUMMED_VELOCITY, TOUCH,
};

/// Impacts of one instant that are simulated one by one before a limit is searched for.
const LISTED: usize = 64;

/// Impacts in one instant, without a flight between them.
#[derive(Debug, Clone, Default)]
pub(super) struct InstantImpacts {
    clock: Clock,
    hits: usize,
    /// Number of points of the body.
    count: usize,
    /// One cycle for each point and piece of ground that have hit each other at this instant, since their last impact. A contact in a
    /// narrow vertex hits the two pieces in turn.
    pub(super) cycles: Vec<SinceLastHit>,
}

impl InstantImpacts {
    /// Whether there has been an impact at this instant.
    pub(super) fn goes_on(&self, clock: Clock) -> bool {
        self.hits > 0 && self.clock == clock
    }
}

/// The cycle from one impact at a point and a piece of ground to the next one there, at one instant.
#[derive(Debug, Clone, Default)]
pub(super) struct SinceLastHit {
    /// At the start of the cycle: the point that is hit, the pieces under all points, and the gap rates of all points.
    point: usize,
    pieces: ContactValues<isize>,
    rates: ContactValues<f64>,
    /// Change of velocity in this cycle.
    pub(super) change: Vector3<f64>,
    /// Of the previous cycle: its change of velocity, and the ratio of the gap rates of the point that is hit at its end and its start.
    before: Option<(Vector3<f64>, f64)>,
}

/// Monitor of impacts that are all nearly slow enough to stop.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ChatterMonitor {
    impacts: usize,
    /// The largest speed of a slow contact in this block of impacts, and in the previous block, in m/s.
    largest: f64,
    before: f64,
    /// Whether two successive blocks had similar speeds.
    persistent: bool,
    /// Number of times that contacts have been set to rest for this reason.
    ends: i32,
}

impl ChatterMonitor {
    /// Impacts between two comparisons of their speeds.
    const STRETCH: usize = 256;

    /// Most doublings of the monitored speed: one each time that contacts have been set to rest.
    const DOUBLINGS: i32 = 10;

    /// The speed below which impacts are monitored, in m/s. `stopped`: the speed below which contacts stop.
    fn limit(&self, stopped: f64) -> f64 {
        HIT_IN_TURN * stopped * f64::from(1 << self.ends.min(Self::DOUBLINGS))
    }

    /// Adds an impact with the speed `hit` that leaves contacts with these speeds.
    fn follow(&mut self, hit: f64, speeds: &[f64], limit: f64) {
        if hit > limit {
            *self = Self { ends: self.ends, ..Self::default() };
            return;
        }
        let slow = speeds.iter().filter(|speed| **speed <= limit);
        self.largest = slow.fold(self.largest, |most, speed| most.max(*speed)).max(hit);
        self.impacts += 1;
        if self.impacts == Self::STRETCH {
            let (now, before) = (self.largest, self.before);
            let alike = now <= SLOWER_STRETCH * before && before <= SLOWER_STRETCH * now;
            *self = Self {
                before: now,
                persistent: self.persistent || alike,
                ends: self.ends,
                ..Self::default()
            };
        }
    }
}

impl Driver<'_, AnyContacts> {
    /// Point `i` is about to be hit, after others at the same instant. If the cycles from one impact at `i` to the next shrink in
    /// one ratio r, with all changes of velocity, infinitely many of them are summed:
    ///
    /// ```text
    /// v_∞ = v + Δv r/(1 − r)
    /// ```
    ///
    /// Contacts whose rates become zero in the limit are hit infinitely often; they come to rest. Returns whether it summed.
    pub(super) fn sum_up(&mut self, i: usize) -> bool {
        let rates: ContactValues<f64> = self.body.state.points.iter().map(|p| p.u).collect();
        let pieces: ContactValues<isize> =
            self.body.state.points.iter().map(|p| p.place.piece).collect();
        let sequence = &mut self.body.sequence;
        if sequence.clock != self.log.clock || sequence.count != rates.len() {
            (sequence.clock, sequence.hits, sequence.count) = (self.log.clock, 0, rates.len());
            sequence.cycles.clear();
        }
        sequence.hits += 1;
        let mut next = SinceLastHit {
            point: i,
            pieces,
            rates: ContactValues::from_slice(&rates),
            ..SinceLastHit::default()
        };
        let same = |cycle: &&mut SinceLastHit| cycle.point == i && cycle.pieces == next.pieces;
        let Some(cycle) = sequence.cycles.iter_mut().find(same) else {
            sequence.cycles.push(next);
            return false;
        };
        let ratio = rates[i] / cycle.rates[i];
        next.before = Some((cycle.change, ratio));
        let SinceLastHit { rates: start, change, before, .. } = std::mem::replace(cycle, next);
        let Some((last, before)) = before.filter(|_| sequence.hits > LISTED) else { return false };
        if !(0.0 < ratio && ratio < 1.0) {
            return false;
        }
        let alone = sequence.cycles.iter().all(|cycle| cycle.point == i);
        if alone
            && sequence.cycles.len() > 1
            && (ratio - before).abs() <= SELF_SIMILAR * (1.0 - ratio)
        {
            self.stop_in_vertex(i);
            return true;
        }
        let sum = ratio / (1.0 - ratio);
        let few = SEQUENCE_RATIO_ROUNDINGS * f64::EPSILON;
        let gyration = self.body.state.rho2.sqrt();
        let size = |v: Vector3<f64>| Vector3::new(v.x, v.y, gyration * v.z).norm();
        if !(size(change - last * ratio) <= few * size(change)) {
            return false;
        }
        // Cycles that are only rounding error do not shrink, and their sum would be arbitrary.
        if !(few * (1.0 + sum) * sum * size(change) <= SUMMED_VELOCITY * self.body.fastest) {
            return false;
        }
        let mut end = self.body.state.clone();
        end.center.v += change.xy() * sum;
        end.spin.omega += change.z * sum;
        for (j, p) in end.points.iter_mut().enumerate() {
            if p.h > 0.0 {
                p.u += sum * (p.normal.dot(&change.xy()) + p.b * change.z);
                continue;
            }
            p.u += (rates[j] - start[j]) * sum;
            if p.u.abs() <= few * (1.0 + sum) * start[j].abs() {
                p.u = 0.0;
            } else if p.u < 0.0 && !(rates[j] < 0.0 && start[j] < 0.0) {
                return false; // it is hit before the limit; only one that approached throughout may wait
            }
        }
        // A contact that slides throughout has to slide in the same direction at the end.
        let turns_back = |j: usize| {
            let (slip, after) = (self.body.state.slip(j), end.slip(j));
            end.points[j].u == 0.0 && slip * after < 0.0 && after.abs() > few * self.body.fastest
        };
        if (0..rates.len()).any(turns_back) {
            return false;
        }
        self.body.state = end;
        true
    }

    /// Point `i` hits the two pieces of a vertex in turn at one instant, for ever. In the limit its velocity w is zero; as the impulses of all
    /// these impacts act at this one point, their sum is P = −W⁻¹w. A disc hits them with two points: it is stopped by the normal impulses,
    /// which act at its centre.
    pub(super) fn stop_in_vertex(&mut self, i: usize) {
        let c = self.body.state.points[i].c;
        let (w, slip, rate) = (
            self.body.state.matrix_at(i, c),
            self.body.state.along(i),
            self.body.state.points[i].u,
        );
        let determinant = w.tt * w.nn - w.nt * w.nt;
        let tangential = (w.nt * rate - w.nn * slip) / determinant;
        let normal = (w.nt * slip - w.tt * rate) / determinant;
        self.push(i, [tangential, normal], c);
        self.body.state.points[i].u = 0.0;
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

    /// Whether an impact with this speed (m/s) counts as one of an accumulation.
    pub(super) fn fades(&self, hit: f64) -> bool {
        hit <= HIT_IN_TURN * CONTACT_STOPPED * self.body.fastest
    }

    /// Warning about contacts that were set to rest although they did not become slower.
    pub(super) fn chatter_warning(&self) -> Option<String> {
        let (contacts, limit) = &self.body.stopped_chatter;
        let who = names(contacts.iter().copied());
        let [slow, fast] = [*limit, self.body.fastest].map(in_words);
        (!contacts.is_empty()).then(|| {
            format!(
                "{who} bounced below {slow} without becoming slower; beside speeds of up to {fast} these are rounding errors: set to rest"
            )
        })
    }

    /// `hit`: the speed of the collision; `by`: the speed of the impact that brings contacts to rest, in m/s; infinite if no impact does.
    fn stop(&mut self, hit: f64, by: f64) -> Option<Outcome> {
        let limit = CONTACT_STOPPED * self.body.fastest;
        let pulls: ContactValues<f64> =
            (0..self.body.state.points.len()).map(|i| self.body.state.known_pull(i)).collect();
        // Without gravity, or with very little, a contact may be slow at any height.
        let near = TOUCH * self.body.posture.size();
        let speed = |(p, pull): (&ContactState, &f64)| match (p.h, *pull > 0.0) {
            (0.0, _) => p.u.abs(),
            (h, true) if h <= near => (p.u * p.u + 2.0 * pull * h).sqrt(),
            _ => f64::INFINITY,
        };
        let speeds: ContactValues<f64> =
            self.body.state.points.iter().zip(&pulls).map(speed).collect();
        let in_turn = |one: f64, other: f64| {
            other > limit && other <= HIT_IN_TURN * limit && one > CONTACT_STOPPED * other
        };
        // Contacts hit in turn for ever at the limit of what counts as zero stop together.
        let slow = speeds.iter().any(|&speed| speed <= limit);
        self.body.waiting = if slow { self.body.waiting + 1 } else { 0 };
        let watched = self.body.chatter.limit(limit);
        self.body.chatter.follow(hit, &speeds, watched);
        // The speed below which contacts hit in turn stop.
        let together = if self.body.chatter.persistent {
            watched
        } else if self.body.waiting > LISTED {
            HIT_IN_TURN * limit
        } else {
            0.0
        };
        let (mut stopped, mut error, mut found) = (ContactValues::new(), 0.0_f64, false);
        let mut stops: ContactValues<bool> =
            self.body.state.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        for (i, &speed) in speeds.iter().enumerate() {
            let alone = speed <= limit && !speeds.iter().any(|&other| in_turn(speed, other));
            if !(alone || speed <= together) {
                continue;
            }
            (stops[i], found) = (true, true);
            let loss = 1.0 - self.material(i).restitution;
            // A contact with upward effective gravity does not come to rest.
            if !self.resting[i] && pulls[i] >= 0.0 {
                if pulls[i] > 0.0 {
                    error = error.max(2.0 * speed / (pulls[i] * loss));
                }
                stopped.push(i);
            }
        }
        if found {
            self.arrest(&stops);
            self.body.state.reconcile(self.body.posture.size());
            // Where a rate follows from others, it is their rounding error.
            for (p, _) in self.body.state.points.iter_mut().zip(&stops).filter(|(_, stops)| **stops)
            {
                (p.h, p.u) = (0.0, 0.0);
            }
            let (v, omega) = (self.body.state.center.v.norm(), self.body.state.spin.omega);
            if self.body.chatter.persistent && v + self.body.posture.size() * omega.abs() <= watched
            {
                self.body.state.stand();
            }
        }
        if stopped.is_empty() {
            return None;
        }
        if self.body.chatter.persistent {
            self.body.chatter.ends += 1;
            self.body
                .stopped_chatter
                .0
                .extend(stopped.iter().map(|&i| self.body.state.points[i].place.contact));
            self.body.stopped_chatter.1 = watched;
        }
        self.body.waiting = 0;
        self.body.chatter.persistent = false;
        self.settle(&stopped, false, error + self.nested.missing(self.body.state.gravity), by)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impacts_of_constant_speed_go_on_and_those_that_shrink_do_not() {
        for (ratio, persistent) in [(1.0, true), (0.999, true), (0.99, false)] {
            let mut monitor = ChatterMonitor::default();
            for k in 0..4 * ChatterMonitor::STRETCH {
                let speed = libm::pow(ratio, k as f64);
                monitor.follow(speed, &[speed, 3.0], 2.0); // 3: too fast to be watched
            }
            assert_eq!(monitor.persistent, persistent, "{ratio}");
        }
    }
}
