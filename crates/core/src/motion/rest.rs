//! Contacts that come to rest, and motions that end at rest.

use crate::body::contact::{ContactLetters, ContactValues, PerContact};
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::modes::Mode;
use crate::motion::cycles::SlowLanding;
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::{Moment, Record, ZenoRecord};
use crate::options::Stop;
use crate::outcome::{Cause, Outcome, ZenoMethod};
use crate::tolerance::{LEFT_OF_ZERO, QUIET_CHATTER, REMAINDER_FACTOR};

/// Quiet landings of one of several contacts after which a motion counts as rounding. An accumulation whose speeds shrink by a tenth each time has fewer before it
/// ends.
const CHATTERS: usize = 200;

/// The warning of a run in which the contacts rest and other coordinates move on.
const HIDDEN: &str = "the contacts rest, but coordinates that they do not feel move on";

impl Driver<'_> {
    /// Records which of these points, closed in this state, have just come to rest. A contact that lifts off at once has not, nor, at the start,
    /// one that nothing presses to its ground.
    pub(super) fn come_to_rest(&mut self, rests: &[bool], fresh: bool) -> Option<Outcome> {
        let second = |i: usize| self.state.turning().and_then(|body| body.second(i));
        let held = |i: usize| self.resting[i] || second(i).is_some_and(|j| self.resting[j]);
        let smooth = (0..rests.len()).all(|i| self.state.friction(i) == 0.0);
        let pressed = self.plain_model().filter(|_| smooth);
        let pressed =
            pressed.map(|model| model.pressed([0, 1].map(|i| rests.get(i).is_some_and(|on| *on))));
        let stays = |i: usize| match (pressed, self.state.pull(i)) {
            (Some(pressed), _) => pressed[i],
            (None, 0.0) => !fresh,
            (None, pull) => pull > 0.0,
        };
        let new: ContactValues<usize> =
            (0..rests.len()).filter(|&i| rests[i] && !held(i) && stays(i)).collect();
        if new.is_empty() {
            return None;
        }
        let proved = self.proves_rest();
        let method =
            if fresh { Some(ZenoMethod::Rest) } else { proved.then_some(ZenoMethod::Bounce) };
        self.settle(&new, method, fresh || proved, 0.0, f64::INFINITY)
    }

    /// Returns true if a contact with zero gap and rate counts as proved to rest: over constant rows, and in a body on at most two contacts
    /// without friction in impacts.
    fn proves_rest(&self) -> bool {
        self.plain || self.state.turning().is_none()
    }

    /// Records that these points have come to rest; an outcome: the run ends with it. `method`: `None`: by single impacts; `hit`: speed of the
    /// impact that stopped them, in m/s; 0 if impacts were summed, infinite if there was no impact.
    pub(super) fn settle(
        &mut self,
        points: &[usize],
        method: Option<ZenoMethod>,
        certified: bool,
        error: f64,
        hit: f64,
    ) -> Option<Outcome> {
        let from_start = method == Some(ZenoMethod::Rest);
        let stops = points.iter().all(|&i| self.state.material(i).restitution == 0.0);
        let plastic = stops && !self.fades(hit) && !from_start;
        let closed = self.closed(points);
        points.iter().for_each(|&i| self.resting[i] = true);
        if !from_start {
            self.cause = Some(Cause::Zeno);
        }
        let (clock, at) = (self.log.clock, self.moment());
        let whole = method.filter(|_| points.len() > 1).unwrap_or(ZenoMethod::Mixed);
        let Record { subject, zeno, .. } = &mut *self.record;
        // The contacts of one accumulation come to rest one by one, within the rounding error of the clock.
        let last = zeno.last_mut().filter(|last| {
            !from_start && clock.since(last.at.clock) <= 2.0 * f64::EPSILON * clock.hi
        });
        if let Some(last) = last {
            last.closed.resize(closed.len(), false);
            last.closed.iter_mut().zip(closed).for_each(|(one, other)| *one |= other);
            last.at = Moment { clock: last.at.clock, ..at };
            last.error = last.error.max(error);
            last.plastic &= plastic;
            last.certified &= certified;
            if last.method == ZenoMethod::Bounce && subject.distinct(&last.closed) > 1 {
                last.method = whole;
            }
        } else {
            let one = subject.distinct(&closed) == 1;
            let single = if one { ZenoMethod::Bounce } else { ZenoMethod::Mixed };
            zeno.push(ZenoRecord {
                closed,
                method: method.unwrap_or(single),
                certified,
                plastic,
                error,
                first_summed: self.log.hits,
                at,
            });
        }
        (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno)
    }

    /// The contacts of these points: those of the subject, with all at the same points of the body, and those of corners of the ground on sides.
    fn closed(&self, points: &[usize]) -> PerContact<bool> {
        let (subject, sides) = (&self.record.subject, self.record.sides.len());
        let count = subject.count();
        let mut closed = PerContact::from_elem(false, count + sides);
        for &i in points {
            let contact = self.state.contact(i);
            closed[contact] = true;
            if let Some(posture) = subject.posture().filter(|_| contact < count) {
                let at = posture.point_of(contact);
                for (closed, point) in closed.iter_mut().zip(posture.per_contact(|k| k)) {
                    *closed |= point == at;
                }
            }
        }
        closed
    }

    /// The modes in which all contacts, which rest, stay at rest, if closed forms tell.
    pub(super) fn stands(&mut self) -> Option<ContactLetters<Mode>> {
        let tolerance = self.sliding_tolerance();
        let (word, dropped) = match &self.state {
            Moving::Turning(body) if self.plain && !body.fall_changes() => {
                body.stands(tolerance, self.place)?
            }
            Moving::Turning(_) => return None,
            Moving::Frozen(rows) => (rows.stands(tolerance)?, 0.0),
        };
        self.cycles.drop(dropped);
        Some(word)
    }

    /// Rests in these modes. The hidden motion of a mechanism, if it is accelerated, carries it away; if not, its speed stays.
    pub(super) fn stand(&mut self, mut word: ContactLetters<Mode>) -> Outcome {
        self.state.stand();
        for (i, mode) in word.iter_mut().enumerate().filter(|(_, mode)| **mode != Mode::Separate) {
            self.state.set_point(i, (0.0, 0.0));
            if self.state.friction(i) == 0.0 {
                *mode = Mode::Fixed; // forces do not change
            }
        }
        self.log.enter(&word);
        for (resting, mode) in self.resting.iter_mut().zip(&word) {
            *resting = *mode != Mode::Separate;
        }
        let still = match &self.state {
            Moving::Turning(_) => None,
            Moving::Frozen(rows) => Some(Coordinates::zeros(rows.v.len())),
        };
        self.write_modes(word, still.clone());
        let (mut falls, mut drifts) = (false, false);
        if let (Moving::Frozen(rows), Some(start)) = (&self.state, self.record.subject.mechanism())
        {
            let space = rows.space();
            falls = space.hidden().amax() > 0.0;
            let [_, velocity] = start.hidden_at(self.log.clock.hi);
            drifts = space.reach() * velocity.norm() > self.sliding_tolerance();
        }
        if falls || drifts {
            self.warn_once(HIDDEN.into());
        }
        if self.options.stop == Stop::Time {
            self.log.clock = self.log.clock.after(self.log.left().max(0.0));
            return Outcome::TimeLimit;
        }
        match (falls, drifts) {
            (true, _) => Outcome::Escape,
            (false, true) => {
                self.record.acceleration = still.and_then(|still| self.acceleration_of(&still));
                Outcome::Sliding
            }
            (false, false) => Outcome::Rest,
        }
    }

    /// q̈ of all coordinates, from ÿ of constant rows; a model without a body has none.
    pub(super) fn acceleration_of(&self, y: &Coordinates) -> Option<Vec<f64>> {
        match &self.state {
            Moving::Turning(_) => None,
            Moving::Frozen(rows) => Some(rows.space().acceleration(self.record.subject.dof()?, y)),
        }
    }

    /// One of two contacts lands with this speed (m/s) while the other is held. If all speeds are below their rounding error, everything comes to
    /// rest. If only the landing speed is, the contact that lands does.
    pub(super) fn stop_slowly(&mut self, landing: f64) -> Option<Option<Outcome>> {
        if !self.proves_rest() {
            return None;
        }
        let left = self.state.speed_of(&self.state.velocity(), self.place);
        let gravity = self.state.gravity();
        // As for the sliding speed that counts as zero: gravity times the rounding error of the clock is an error of each speed.
        let fastest = self.fastest.max(gravity * self.log.clock.hi);
        let SlowLanding { quiet, error } = SlowLanding::of(landing, left, fastest, gravity)?;
        (0..2).for_each(|i| self.state.set_point(i, (0.0, 0.0)));
        match &mut self.state {
            Moving::Turning(body) => body.close(&[true; 2]),
            Moving::Frozen(rows) => rows.project(&[Mode::Right; 2]),
        }
        if quiet {
            self.state.stand();
        }
        self.cycles.forget();
        Some(self.settle(&[0, 1], Some(ZenoMethod::Mixed), false, error, 0.0))
    }

    /// A contact of several over constant rows lands while others are held. Once [`CHATTERS`] such landings had speeds that may be what rounding leaves of nested
    /// accumulations, the contacts whose gaps are as little come to rest.
    pub(super) fn stop_chatter(&mut self) -> Option<Option<Outcome>> {
        let Moving::Frozen(rows) = &self.state else { return None };
        let (left, gravity) = (rows.speed(), self.state.gravity());
        let fastest = self.fastest.max(gravity * self.log.clock.hi);
        let quiet = gravity > 0.0 && left <= QUIET_CHATTER * fastest;
        if !quiet || rows.points.len() < 3 {
            self.quiet_landings = 0;
            return None;
        }
        self.quiet_landings += 1;
        if self.quiet_landings < CHATTERS {
            return None;
        }
        let fall = REMAINDER_FACTOR * left * left / gravity;
        let is_near = |&i: &usize| rows.points[i].h <= fall + rows.points[i].rounding.gap;
        let near: ContactValues<usize> = (0..rows.points.len()).filter(is_near).collect();
        near.iter().for_each(|&i| self.state.set_point(i, (0.0, 0.0)));
        self.state.stand();
        self.cycles.forget();
        let error = REMAINDER_FACTOR * left / gravity;
        Some(self.settle(&near, Some(ZenoMethod::Mixed), false, error, 0.0))
    }

    /// No mode is consistent, with speeds that are what impacts one after the other have left of zero: everything stands. At rest there is a
    /// mode. Returns whether it moved.
    pub(super) fn stands_at_last(&mut self) -> bool {
        let speed = self.speed_over_ground();
        let moves = speed > 0.0 && speed <= LEFT_OF_ZERO * self.fastest;
        if moves {
            self.state.stand();
            self.record.undecided = None;
        }
        moves
    }
}
