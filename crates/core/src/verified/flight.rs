//! The frictionless motion after a corner, until the next Zeno point.
//!
//! At a *corner* one contact is on the ground and contact j lands, here with speed 1. Impacts at this instant follow, then flights and
//! impacts.

use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::outcome::Uncertain;
use crate::tolerance::CORNER_TAIL;
use crate::verified::similar::Recurrences;
use crate::verified::{Gap, Model, Motion, interval, one};

/// How the motion after a corner ends. `t`: duration of the flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Flight {
    /// Contact `kept` rests. The other contact has this gap and gap rate.
    One {
        kept: usize,
        h: Interval,
        u: Interval,
        t: Interval,
    },
    /// Both contacts rest.
    Two {
        t: Interval,
    },
    /// Neither contact lands again.
    Away,
    /// There is no such corner: the other contact does not stay on the terrain.
    Nowhere,
    Unknown,
}

impl<T: Enclosed> Model<T> {
    /// Whether impacts at two closed contacts alternate without end: p_1p_2 ≥ (√e_1 + √e_2)². `None` if this is not certain.
    fn chatters(&self) -> Option<bool> {
        if (-self.psi[0]).is_not_negative() {
            return Some(false);
        }
        let bound = (self.e[0].root()? + self.e[1].root()?).square();
        let more = self.kappa[0] * self.kappa[1] - bound;
        match (self.psi[0].is_positive(), more.is_not_negative(), more.is_negative()) {
            (true, true, _) => Some(true),
            (true, _, true) => Some(false),
            _ => None,
        }
    }

    /// The motion after contact j has landed with speed 1, with at most this number of impacts one by one. `lets_go`: the contacts that
    /// certainly have no motion on the terrain.
    pub(crate) fn flight(&self, j: usize, lets_go: [bool; 2], impacts: usize) -> Flight {
        if lets_go[1 - j] {
            return Flight::Nowhere;
        }
        match self.chatters() {
            Some(true) => return Flight::Two { t: Interval::ZERO },
            Some(false) => {}
            None => return Flight::Unknown,
        }
        let mut motion = Motion::new(self, [Gap::REST; 2]);
        motion.gaps[j].u = -one::<T>();
        let Some((a, count)) = motion.hit_together(j, impacts) else { return Flight::Unknown };
        motion.until_zeno(a, lets_go, impacts - count)
    }
}

impl<T: Enclosed> Motion<'_, T> {
    /// Impacts while both gaps are zero, at contact j first, until no contact approaches: the last contact that is hit, and the number of
    /// impacts.
    fn hit_together(&mut self, j: usize, impacts: usize) -> Option<(usize, usize)> {
        let mut a = j;
        for count in 1..=impacts {
            self.collide(a, -self.gaps[a].u);
            let other = self.gaps[1 - a].u;
            if other.is_not_negative() {
                return Some((a, count));
            }
            if !other.is_negative() {
                return None;
            }
            a = 1 - a;
        }
        None
    }

    /// From an impact at `a` to the next Zeno point.
    fn until_zeno(&mut self, mut a: usize, lets_go: [bool; 2], impacts: usize) -> Flight {
        let mut clock = T::ZERO;
        let one_rests = |kept: usize, other: Gap<T>, t: T| {
            let [h, u, t] = [other.h, other.u, t].map(interval);
            Flight::One { kept, h: h.not_below_zero(), u, t }
        };
        // Between which times both contacts come to rest.
        let mut found: Option<Interval> = None;
        let mut recurrences = Recurrences::new();
        for _ in 0..impacts {
            let rests = |i: &usize| self.gaps[*i].is_at_rest() && !lets_go[*i];
            if let Some(kept) = [a, 1 - a].into_iter().find(rests) {
                if !self.model.g[kept].is_not_negative() {
                    return Flight::Unknown; // it may jam
                }
                return one_rests(kept, self.gaps[1 - kept], clock);
            }
            if let Some(t) = self.bounces(a)
                && let Some(other) = self.after_bounces(a, t)
            {
                return one_rests(a, other, clock + t);
            }
            if let Some(rest) = self.clatters(a) {
                let [least, most] = rest.map(|rest| interval(clock + rest));
                let end = Interval::new(least.lo, most.hi);
                found = Some(end);
                if end.hi - end.lo <= CORNER_TAIL * end.lo {
                    break;
                }
            }
            if let Some(period) = recurrences.period(a, &self.gaps)
                && let Some(t) = self.self_similar(a, period)
            {
                return Flight::Two { t: interval(clock) + t };
            }
            match self.next(a) {
                Ok((hit, dt)) => (a, clock) = (hit, clock + dt),
                Err(Uncertain::Never) => return Flight::Away,
                Err(_) => break,
            }
        }
        found.map_or(Flight::Unknown, |t| Flight::Two { t })
    }

    /// The time until both contacts rest, if the last `period` impacts certainly repeat for ever.
    fn self_similar(&self, a: usize, period: usize) -> Option<Interval> {
        let Model { g, psi, e, count, .. } = self.model;
        let model = Model::new(g.map(interval), psi.map(interval), e.map(interval), *count);
        let gaps =
            self.gaps.map(|Gap { h, u }| Gap { h: interval(h).not_below_zero(), u: interval(u) });
        model.self_similar(a, gaps, period)
    }
}
