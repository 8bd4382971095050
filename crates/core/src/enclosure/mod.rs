//! Verified enclosures of a motion: intervals that contain the time of each collision and, in the local model, the time of the
//! Zeno point at which the collisions accumulate.
//!
//! This file has the local model, `full.rs` the full model. Flights and impacts are those of `collisions/local.rs`, in balls of 106 bits.
//! If the balls of two touchdown times are disjoint, they show which contact lands first; otherwise the enclosure ends with a reason. Two
//! theorems enclose the infinitely many impacts that remain (`verified/`). The parameters are taken to be exactly the given doubles.

use crate::body::local_model::LocalModel;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::collisions::log::CHUNK;
use crate::math::ball::Ball;
use crate::math::real::Enclosed;
use crate::options::Options;
use crate::outcome::{Bounds, ContactNumber, EnclosedImpact, EnclosedZeno, Enclosure, Uncertain};
use crate::tolerance::NARROW_ENOUGH;
use crate::verified::{Gap, Model, Motion};

mod full;

pub(crate) use full::enclose_full;

/// The enclosures proved so far.
struct Claims<'a> {
    /// Time elapsed.
    clock: Ball,
    impacts: Vec<EnclosedImpact>,
    event_limit: usize,
    /// Longest time, in s.
    time: f64,
    cancel: &'a dyn Fn() -> bool,
    cancelled: bool,
}

impl<'a> Claims<'a> {
    /// For a body with `count` contacts. The event limit is that of a recorded run, because the enclosures are always stored.
    fn new(count: usize, options: &Options, cancel: &'a dyn Fn() -> bool) -> Self {
        Self {
            clock: Ball::ZERO,
            impacts: Vec::new(),
            event_limit: Options { record: true, ..*options }.events(count),
            time: options.end(),
            cancel,
            cancelled: false,
        }
    }

    /// The time elapsed after a further `dt` ≥ 0. Its lower bound is at least that of the last impact.
    fn after(&self, dt: Ball) -> Bounds {
        let [low, high] = (self.clock + dt).bounds();
        let last = self.impacts.last().map_or(0.0, |impact| impact.elapsed.low);
        Bounds { low: low.max(last), high }
    }

    /// Stores a collision of contact i after a further `dt`.
    fn collide(&mut self, i: usize, dt: Ball) -> Result<(), Uncertain> {
        let elapsed = self.after(dt);
        self.cancelled = self.impacts.len().is_multiple_of(CHUNK) && (self.cancel)();
        if self.cancelled || self.impacts.len() >= self.event_limit || elapsed.high > self.time {
            return Err(Uncertain::Limit);
        }
        if !(elapsed.low <= elapsed.high && elapsed.high.is_finite()) {
            return Err(Uncertain::Order);
        }
        self.clock = self.clock + dt;
        self.impacts.push(EnclosedImpact { contact: ContactNumber::of(i), elapsed });
        Ok(())
    }

    /// All enclosures, and how they end; `None` if cancelled.
    fn end(self, end: Result<EnclosedZeno, Uncertain>) -> Option<Enclosure> {
        if self.cancelled {
            return None;
        }
        let (zeno, reason) = match end {
            Ok(zeno) if zeno.elapsed.high <= self.time => (Some(zeno), None),
            Ok(_) => (None, Some(Uncertain::Limit)),
            Err(reason) => (None, Some(reason)),
        };
        Some(Enclosure { impacts: self.impacts, zeno, reason })
    }
}

/// The enclosure of a motion of which nothing is certain, not even at the start.
const NOTHING: Enclosure =
    Enclosure { impacts: Vec::new(), zeno: None, reason: Some(Uncertain::Order) };

fn ball(x: f64) -> Ball {
    Ball::from(x)
}

/// The state of the enclosure of a motion.
struct LocalEnclosure<'a> {
    motion: Motion<'a, Ball>,
    claims: Claims<'a>,
}

impl LocalEnclosure<'_> {
    fn zeno(&self, contacts: &[usize], rest: [Ball; 2]) -> EnclosedZeno {
        let [least, most] = rest.map(|t| self.claims.after(t));
        let contacts = contacts.iter().map(|&i| ContactNumber::of(i)).collect();
        EnclosedZeno { contacts, elapsed: Bounds { low: least.low, high: most.high } }
    }

    /// Encloses collisions one by one until the Zeno time is enclosed and further collisions no longer narrow its interval.
    fn run(&mut self) -> Result<EnclosedZeno, Uncertain> {
        let (gaps, model) = (self.motion.gaps, self.motion.model);
        if !gaps.iter().all(|gap| gap.h.is_not_negative()) {
            return Err(Uncertain::Order);
        }
        let rests = |i: &usize| gaps[*i].is_at_rest() && model.g[*i].is_positive();
        let all = 0..model.count;
        if model.count == 2 && all.clone().all(|i| rests(&i)) && model.presses() {
            return Ok(self.zeno(&[0, 1], [Ball::ZERO; 2]));
        }
        let mut a = match all.clone().find(rests) {
            Some(i) => i,
            None => {
                let (hit, dt) = self.motion.first()?;
                self.claims.collide(hit, dt)?;
                hit
            }
        };
        let mut found: Option<EnclosedZeno> = None;
        loop {
            if let Some(t) = self.motion.bounces(a) {
                return Ok(self.zeno(&[a], [t, t]));
            }
            if let Some(rest) = self.motion.clatters(a) {
                let zeno = self.zeno(&[0, 1], rest);
                let before = found.as_ref().map_or(f64::INFINITY, |found| found.elapsed.width());
                let elapsed =
                    found.as_ref().map_or(zeno.elapsed, |found| found.elapsed.and(zeno.elapsed));
                let tight = (rest[1] - rest[0]).bounds()[1] <= NARROW_ENOUGH * elapsed.high;
                let narrower = elapsed.width() < before;
                found = Some(EnclosedZeno { elapsed, ..zeno });
                if tight || !narrower {
                    break;
                }
            }
            let next = self.motion.next(a);
            match next.and_then(|(hit, dt)| self.claims.collide(hit, dt).map(|()| hit)) {
                Ok(hit) => a = hit,
                Err(_) if found.is_some() => break,
                Err(uncertain) => return Err(uncertain),
            }
        }
        found.ok_or(Uncertain::Order)
    }
}

/// Encloses the motion of a model in balls; `None` if cancelled.
fn enclose(
    model: &Model<Ball>,
    gaps: [Gap<Ball>; 2],
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Enclosure> {
    let claims = Claims::new(model.count, options, cancel);
    let mut course = LocalEnclosure { motion: Motion::new(model, gaps), claims };
    let end = course.run();
    course.claims.end(end)
}

/// Encloses the motion of a body in its local model; `None` if cancelled.
pub(crate) fn enclose_local(
    posture: &Posture,
    state: &State,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Enclosure> {
    let Some((model, gaps)) = full::local_of(posture, state) else {
        return Some(NOTHING);
    };
    enclose(&model, gaps, options, cancel)
}

/// Encloses the motion of a model that is given by its parameters.
pub(crate) fn enclose_given(
    model: &LocalModel,
    gaps: [f64; 2],
    rates: [f64; 2],
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Enclosure> {
    let [g, psi, e] = [model.gravity(), model.psi(), model.restitution()].map(|x| x.map(ball));
    let gaps = [0, 1].map(|i| Gap { h: ball(gaps[i]), u: ball(rates[i]) });
    enclose(&Model::new(g, psi, e, 2), gaps, options, cancel)
}
