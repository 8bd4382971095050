//! The frictionless motion after a corner, until the next Zeno point.
//!
//! At a *corner* one contact is on the ground and contact j lands, here with speed 1. Impacts at this instant follow. They go on without
//! end if p_1p_2 ≥ (√e_1 + √e_2)². Otherwise flights and impacts follow, until one contact bounces alone, or the impacts are those of a
//! self-similar cycle. (Clattering, the other way to two contacts at rest, needs the same bound.)

use crate::math::ball::Ball;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::outcome::Uncertain;
use crate::verified::shape::{Frame, Shape};
use crate::verified::similar::Recurrences;
use crate::verified::{Gap, Model, Motion, interval, one};

/// Largest number of impacts of one flight that are computed one by one: those at the instant of the corner; in intervals; and then, if the
/// end is not certain, in frames.
const AT_ONCE: usize = 256;
const PLAIN: usize = 256;
const FINE: usize = 768;

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

    /// The state after contact j has landed with speed 1, and after all impacts at this instant.
    fn corner(&self, j: usize) -> Option<(Motion<'_, T>, usize)> {
        let mut motion = Motion::new(self, [Gap::REST; 2]);
        motion.gaps[j].u = -one::<T>();
        let mut a = j;
        for _ in 0..AT_ONCE {
            motion.collide(a, -motion.gaps[a].u);
            let other = motion.gaps[1 - a].u;
            if other.is_not_negative() {
                return Some((motion, a));
            }
            if !other.is_negative() {
                return None;
            }
            a = 1 - a;
        }
        None
    }
}

impl Flight {
    /// The motion after contact j has landed with speed 1. `lets_go`: the contacts that certainly have no motion on the terrain.
    pub(crate) fn after_corner(model: &Model<Interval>, j: usize, lets_go: [bool; 2]) -> Self {
        if lets_go[1 - j] {
            return Self::Nowhere;
        }
        match model.chatters() {
            Some(true) => return Self::Two { t: Interval::ZERO },
            Some(false) => {}
            None => return Self::Unknown,
        }
        let Some((mut motion, mut a)) = model.corner(j) else { return Self::Unknown };
        let mut clock = Interval::ZERO;
        for _ in 0..PLAIN {
            if let Some(flight) = motion.ends(a, lets_go) {
                return flight.after(clock, Interval::ONE);
            }
            match motion.next(a) {
                Ok((hit, dt)) => (a, clock) = (hit, clock + dt),
                Err(Uncertain::Never) => return Self::Away,
                Err(_) => break,
            }
        }
        Self::Unknown
    }

    /// As [`Flight::after_corner`], more precisely and more slowly, for a corner that exists and at which impacts do not chatter. `fine`: the
    /// same model with more bits.
    pub(crate) fn after_corner_finely(
        model: &Model<Interval>,
        fine: &Model<Ball>,
        j: usize,
        lets_go: [bool; 2],
    ) -> Self {
        let start = fine.corner(j).and_then(|(motion, a)| {
            Some((Frame::new(Shape::of(motion.gaps, a)?), interval(motion.gaps[a].u)))
        });
        let Some((mut frame, mut size)) = start else { return Self::Unknown };
        let mut clock = Interval::ZERO;
        let mut recurrences = Recurrences::new();
        for _ in 0..FINE {
            let shape = frame.shapes();
            let motion = Motion::new(model, shape.gaps());
            if let Some(flight) = motion.ends(shape.contact, lets_go) {
                return flight.after(clock, size);
            }
            if let Some(period) = recurrences.period(&shape)
                && let Some(t) = model.self_similar(fine, shape, period)
            {
                return Self::Two { t }.after(clock, size);
            }
            let Some((factor, time)) = frame.step(fine, model) else { break };
            clock = clock + time * size;
            size = factor * size;
        }
        Self::Unknown
    }

    /// This end after an earlier time, all speeds being larger by a factor.
    fn after(self, clock: Interval, size: Interval) -> Self {
        let later = |t: Interval| clock + t * size;
        match self {
            Self::One { kept, h, u, t } => {
                Self::One { kept, h: h * size.square(), u: u * size, t: later(t) }
            }
            Self::Two { t } => Self::Two { t: later(t) },
            other => other,
        }
    }
}

impl Motion<'_, Interval> {
    /// The end of the flight, if one contact rests or bounces alone after an impact at `a`. `lets_go`: see [`Flight::after_corner`].
    fn ends(&self, a: usize, lets_go: [bool; 2]) -> Option<Flight> {
        let one_rests = |kept: usize, Gap { h, u }: Gap<Interval>, t: Interval| {
            Some(Flight::One { kept, h: h.not_below_zero(), u, t })
        };
        let rests = |i: &usize| self.gaps[*i].is_at_rest() && !lets_go[*i];
        if let Some(kept) = [a, 1 - a].into_iter().find(rests) {
            if !self.model.g[kept].is_not_negative() {
                return Some(Flight::Unknown); // it may jam
            }
            return one_rests(kept, self.gaps[1 - kept], Interval::ZERO);
        }
        let t = self.bounces(a)?;
        one_rests(a, self.after_bounces(a, t)?, t)
    }
}
