//! Series of impacts: those of one instant, those of slow contacts, and the bounces of one contact.

use crate::body::contact::ContactValues;
use crate::collisions::log::in_words;
use crate::math::clock::Clock;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::tolerance::{
    CONTACT_STOPPED, HIT_IN_TURN, RUNS_AWAY, SELF_SIMILAR, SEQUENCE_RATIO_ROUNDINGS,
    SLOWER_STRETCH, SUMMED_VELOCITY,
};

/// Impacts of one instant that are simulated one by one before a limit is searched for.
pub(super) const LISTED: usize = 64;

/// Impacts in one instant, without a flight between them.
#[derive(Debug, Clone)]
pub(super) struct InstantImpacts {
    clock: Clock,
    hits: usize,
    /// The largest speed before them, in m/s.
    began: f64,
    /// Number of points of the body.
    count: usize,
    /// One cycle for each point and piece of ground that have hit each other at this instant, since their last impact. A contact in a
    /// narrow vertex hits the two pieces in turn.
    cycles: Vec<SinceLastHit>,
    /// No change of velocity.
    zero: Coordinates,
}

/// How impacts of one instant go on.
#[expect(clippy::large_enum_variant, reason = "it is read at once; a box would cost an allocation")]
pub(super) enum GoesOn {
    /// No rule is known.
    Somehow,
    /// One contact hits the two pieces of a vertex in turn, for ever.
    InVertex,
    /// In cycles that shrink in one ratio r.
    Shrinking {
        /// Change of velocity in the last cycle.
        change: Coordinates,
        /// r/(1 − r)
        sum: f64,
        /// Gap rates at the start of the last cycle.
        start: ContactValues<f64>,
        /// The tangential impulses at all points in the last cycle.
        rubs: ContactValues<f64>,
    },
}

/// Relative rounding error of a cycle of impacts of one instant.
pub(super) const FEW: f64 = SEQUENCE_RATIO_ROUNDINGS * f64::EPSILON;

impl InstantImpacts {
    /// None so far; `dimensions`: of a change of velocity.
    pub(super) fn none(dimensions: usize) -> Self {
        let zero = Coordinates::zeros(dimensions);
        Self { clock: Clock::default(), hits: 0, began: 0.0, count: 0, cycles: Vec::new(), zero }
    }

    /// Returns true if there has been an impact at this instant.
    pub(super) fn goes_on(&self, clock: Clock) -> bool {
        self.hits > 0 && self.clock == clock
    }

    /// Returns true if point `i` has been hit more than once at this instant.
    pub(super) fn is_hit_in_turn(&self, i: usize, clock: Clock) -> bool {
        let again = |cycle: &SinceLastHit| cycle.point == i && cycle.before.is_some();
        self.clock == clock && self.cycles.iter().any(again)
    }

    /// Returns true if the impacts of this instant have become so much faster that nothing stops them.
    pub(super) fn runs_away(&self, clock: Clock, fastest: f64) -> bool {
        self.clock == clock && self.hits > LISTED && fastest > RUNS_AWAY * self.began
    }

    /// Adds a change of velocity.
    pub(super) fn changes(&mut self, change: &Coordinates) {
        self.cycles.iter_mut().for_each(|cycle| cycle.change.add_scaled(change, 1.0));
    }

    /// Adds the change of velocity of an impulse with this tangential part at point `i`.
    pub(super) fn pushed(&mut self, i: usize, tangential: f64, change: &Coordinates) {
        for cycle in &mut self.cycles {
            cycle.change.add_scaled(change, 1.0);
            // A point that has been added since the cycle began ends it (see `next`).
            cycle.rubs.get_mut(i).into_iter().for_each(|rub| *rub += tangential);
        }
    }

    /// Adds the sum of infinitely many cycles: `sum` times this change of velocity, with tangential impulses `rubs` at all points.
    pub(super) fn summed(&mut self, change: &Coordinates, rubs: &[f64], sum: f64) {
        for cycle in &mut self.cycles {
            cycle.change.add_scaled(change, sum);
            for (all, rub) in cycle.rubs.iter_mut().zip(rubs) {
                *all += sum * rub;
            }
        }
    }

    /// Point `i` is about to be hit, after others at the same instant; `rates`, `pieces`: gap rates and pieces of ground of all points;
    /// `size`: the size of a change; `fastest`: the largest speed so far.
    pub(super) fn next(
        &mut self,
        i: usize,
        clock: Clock,
        rates: &[f64],
        pieces: ContactValues<isize>,
        size: impl Fn(&Coordinates) -> f64,
        fastest: f64,
    ) -> GoesOn {
        if self.clock != clock || self.count != rates.len() {
            if self.clock != clock || self.hits == 0 {
                self.began = fastest;
            }
            (self.clock, self.hits, self.count) = (clock, 0, rates.len());
            self.cycles.clear();
        }
        self.hits += 1;
        let mut next = SinceLastHit {
            point: i,
            pieces,
            rates: ContactValues::from_slice(rates),
            change: self.zero.clone(),
            rubs: ContactValues::from_elem(0.0, rates.len()),
            before: None,
        };
        let same = |cycle: &&mut SinceLastHit| cycle.point == i && cycle.pieces == next.pieces;
        let Some(cycle) = self.cycles.iter_mut().find(same) else {
            self.cycles.push(next);
            return GoesOn::Somehow;
        };
        let ratio = rates[i] / cycle.rates[i];
        next.before = Some((cycle.change.clone(), ratio));
        let SinceLastHit { rates: start, change, rubs, before, .. } =
            std::mem::replace(cycle, next);
        let Some((last, before)) = before.filter(|_| self.hits > LISTED) else {
            return GoesOn::Somehow;
        };
        if !(0.0 < ratio && ratio < 1.0) {
            return GoesOn::Somehow;
        }
        let alone = self.cycles.iter().all(|cycle| cycle.point == i);
        if alone && self.cycles.len() > 1 && (ratio - before).abs() <= SELF_SIMILAR * (1.0 - ratio)
        {
            return GoesOn::InVertex;
        }
        let sum = ratio / (1.0 - ratio);
        if !(size(&change.plus(&last, -ratio)) <= FEW * size(&change)) {
            return GoesOn::Somehow;
        }
        // Cycles that are only rounding error do not shrink, and their sum would be arbitrary.
        if !(FEW * (1.0 + sum) * sum * size(&change) <= SUMMED_VELOCITY * fastest) {
            return GoesOn::Somehow;
        }
        GoesOn::Shrinking { change, sum, start, rubs }
    }
}

/// The cycle from one impact at a point and a piece of ground to the next one there, at one instant.
#[derive(Debug, Clone)]
struct SinceLastHit {
    /// At the start of the cycle: the point that is hit, the pieces under all points, and the gap rates of all points.
    point: usize,
    pieces: ContactValues<isize>,
    rates: ContactValues<f64>,
    /// Change of velocity in this cycle, and the tangential impulses at all points.
    change: Coordinates,
    rubs: ContactValues<f64>,
    /// Of the previous cycle: its change of velocity, and the ratio of the gap rates of the point that is hit at its end and its start.
    before: Option<(Coordinates, f64)>,
}

/// Warning about contacts that were set to rest although they did not become slower; with the speed (m/s) below which they bounced, and the
/// largest speed of the run.
pub(super) fn chatter_warning(who: &str, limit: f64, fastest: f64) -> String {
    let [slow, fast] = [limit, fastest].map(in_words);
    format!(
        "{who} bounced below {slow} without becoming slower; beside speeds of up to {fast} these are rounding errors: set to rest"
    )
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

/// Contacts that are slow enough to stop, but may be hit in turn with others that are nearly as slow.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SlowContacts {
    /// Number of impacts for which a contact slow enough to stop has waited for others.
    waiting: usize,
    pub(super) chatter: ChatterMonitor,
}

impl SlowContacts {
    /// After an impact with the speed `hit` that leaves contacts with these speeds: which of them stop, and the speed below which chatter is
    /// watched. `limit`: the speed that counts as zero. A slow contact waits while another one is nearly as slow, because the two may be hit
    /// in turn; impacts that become neither slower nor faster are ended together.
    pub(super) fn stopping(
        &mut self,
        hit: f64,
        speeds: &[f64],
        limit: f64,
    ) -> (ContactValues<bool>, f64) {
        let in_turn = |one: f64, other: f64| {
            other > limit && other <= HIT_IN_TURN * limit && one > CONTACT_STOPPED * other
        };
        // Contacts hit in turn for ever at the limit of what counts as zero stop together.
        let slow = speeds.iter().any(|&speed| speed <= limit);
        self.waiting = if slow { self.waiting + 1 } else { 0 };
        let watched = self.chatter.limit(limit);
        self.chatter.follow(hit, speeds, watched);
        // The speed below which contacts hit in turn stop.
        let together = if self.chatter.persistent {
            watched
        } else if self.waiting > LISTED {
            HIT_IN_TURN * limit
        } else {
            0.0
        };
        let stops = |&speed: &f64| {
            let alone = speed <= limit && !speeds.iter().any(|&other| in_turn(speed, other));
            alone || speed <= together
        };
        (speeds.iter().map(stops).collect(), watched)
    }

    /// Returns true if impacts chatter.
    pub(super) fn chatters(&self) -> bool {
        self.chatter.persistent
    }

    /// Contacts have been set to rest. Returns whether they chattered.
    pub(super) fn stopped(&mut self) -> bool {
        let chattered = std::mem::take(&mut self.chatter.persistent);
        self.chatter.ends += i32::from(chattered);
        self.waiting = 0;
        chattered
    }
}

/// Impacts of one contact, one after the other.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bounces {
    point: usize,
    /// Number of the last of them among all impacts of the run.
    last: usize,
    hits: usize,
    /// Number of them at which to try to sum.
    next: usize,
    /// The largest speed of the body after them, in m/s.
    pub(super) fastest: f64,
}

/// When to try again to sum.
#[derive(Debug, Clone, Copy)]
pub(super) enum Retry {
    /// Once the error of the polynomial, which is this many times too large, has become small enough.
    Smaller(f64),
    /// Something else stands against it now.
    Later,
}

impl Bounces {
    /// Adds the impact with this number. Whether to try to sum now; for the first time after `first` impacts in succession.
    pub(super) fn follow(&mut self, point: usize, number: usize, first: usize) -> bool {
        if !(self.hits > 0 && point == self.point && number == self.last + 1) {
            *self = Self { point, next: first, ..Self::default() };
        }
        self.last = number;
        self.hits += 1;
        self.hits >= self.next
    }

    /// Waits for another attempt. Each bounce divides the error by e to the `degree` of the polynomial, or less.
    pub(super) fn wait(&mut self, retry: Retry, restitution: f64, degree: usize) {
        let wait = match retry {
            Retry::Smaller(error) => {
                let loss = -libm::log(restitution) * degree as f64;
                ((libm::log(error) / loss) as usize).saturating_add(1)
            }
            Retry::Later => self.hits,
        };
        self.next = self.hits.saturating_add(wait);
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

    /// Point 1 is added to point 0 after the first impact, as the second point of a contact in a vertex is. The cycles of point 0 end with it.
    #[test]
    fn a_point_is_added_within_a_series_of_impacts() {
        let (mut impacts, change) = (InstantImpacts::none(1), Coordinates::from_iter([1.0]));
        let now = Clock { hi: 1.0, lo: 0.0 };
        let hit = |impacts: &mut InstantImpacts, rates: &[f64]| {
            let pieces = rates.iter().map(|_| 0).collect();
            let next = impacts.next(0, now, rates, pieces, |v| v.norm(), 1.0);
            assert!(matches!(next, GoesOn::Somehow));
        };
        hit(&mut impacts, &[-1.0]);
        impacts.pushed(1, 0.5, &change);
        hit(&mut impacts, &[-0.5, 0.0]);
        impacts.pushed(1, 0.5, &change);
        assert_eq!(impacts.cycles.len(), 1);
        assert_eq!(impacts.cycles[0].rubs[..], [0.0, 0.5]);
    }
}
