//! Mechanisms in their posture: all accelerations in one contact mode are constant. Two contacts with frictionless impacts use the loops and
//! the closed sums of the local model; everything else is simulated event by event, with sums of bounces and of impacts at one instant.

use std::collections::BTreeSet;

use crate::body::ContactSpace;
use crate::body::contact::{ContactLetters, ContactValues, PerContact};
use crate::collisions::local::are_one;
use crate::collisions::log::LastImpacts;
use crate::impact::friction::NO_FRICTION;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::modes::Mode;
use crate::motion::bounces::Bounces;
use crate::motion::driver::{self, Coordinates as _, Driver, DriverStep};
use crate::motion::nested::{Landed, NestedSequence};
use crate::motion::plain::{next_landing, within};
use crate::motion::record::{Moment, Motion, Tail, ZenoRecord};
use crate::motion::slow::{InstantImpacts, SlowContacts, chatter_warning};
use crate::motion::subject::Subject;
use crate::options::{Impact, Jams, Options, Stop};
use crate::outcome::{Cause, Outcome, ZenoMethod};
use crate::sustained::frozen::Frozen;
use crate::tolerance::{DEPARTED, DEPARTS_AFTER, STILL};
use crate::zeno::FrozenModel;

/// The coordinates of a mechanism.
pub(crate) struct Jointed {
    pub(super) state: Frozen,
    /// The largest speed of a contact so far, in m/s.
    pub(super) fastest: f64,
    /// Size of the gaps at the start, in m.
    pub(super) place: f64,
    /// Whether impacts are frictionless.
    pub(super) frictionless: bool,
    pub(super) sequence: InstantImpacts<Coordinates>,
    pub(super) slow: SlowContacts,
    /// Contacts that were set to rest because they chattered, and the speed below which they did, in m/s.
    pub(super) stopped_chatter: (BTreeSet<usize>, f64),
    /// Whether the warning that friction does not act in impacts has been given.
    pub(super) friction_warned: bool,
    pub(super) last: LastImpacts,
    pub(super) bounces: Bounces,
    /// The cycles of two contacts.
    pub(super) laps: NestedSequence<Coordinates>,
}

impl Jointed {
    pub(super) fn space(&self) -> &ContactSpace {
        self.state.space()
    }

    /// The model of the gaps of one or two contacts, if impacts are frictionless.
    pub(super) fn plain(&self) -> Option<FrozenModel> {
        self.state.rows.gaps.filter(|_| self.frictionless)
    }

    /// Size of the displacements so far, in m: of the gaps at the start, and of a throw at the largest speed.
    pub(super) fn place(&self) -> f64 {
        let pull = self.space().largest_pull();
        let thrown = if pull > 0.0 { self.fastest * self.fastest / pull } else { 0.0 };
        self.place + thrown
    }
}

impl driver::Coordinates for Jointed {
    fn begin(driver: &mut Driver<'_, Self>) -> Option<Outcome> {
        driver.write_flight();
        None
    }

    fn count(&self) -> usize {
        self.state.points.len()
    }

    fn point(&self, i: usize) -> (f64, f64) {
        (self.state.points[i].h, self.state.points[i].u)
    }

    fn has_left(driver: &mut Driver<'_, Self>) -> bool {
        let Jointed { state, fastest, .. } = &mut driver.body;
        *fastest = fastest.max(state.speed());
        let near = driver.options.neighbourhood;
        // Without a neighbourhood this takes longer than the age of the universe.
        if near == f64::INFINITY && driver.log.clock.hi <= DEPARTS_AFTER {
            return false;
        }
        let limit = near.min(DEPARTED);
        if driver.record.subject.posture().is_some() {
            return driver.record.subject.state(state).q.xy().norm() > limit;
        }
        let (space, y) = (state.space(), &state.y);
        let way = |row: &Coordinates| row.dot(y).abs();
        (0..space.count()).any(|i| way(space.tangent(i)).max(way(space.normal_row(i))) > limit)
    }

    fn moment(driver: &Driver<'_, Self>) -> Moment {
        let (state, subject) = (&driver.body.state, &driver.record.subject);
        Moment {
            clock: driver.log.clock,
            state: subject.state(state),
            gaps: state.points.iter().map(|p| p.h + 0.0).collect(),
            rates: state.points.iter().map(|p| p.u + 0.0).collect(),
            sides: PerContact::new(),
            mechanism: subject.mechanism().map(|_| Box::new(state.clone())),
        }
    }

    fn watch_ground(driver: &mut Driver<'_, Self>) {
        if driver.watch.is_on() {
            driver.watch_moment(&Jointed::moment(driver));
        }
    }

    fn largest_speed(driver: &Driver<'_, Self>) -> f64 {
        driver.body.fastest
    }

    fn sliding_tolerance(driver: &Driver<'_, Self>) -> f64 {
        let pull = driver.body.space().largest_pull();
        STILL * driver.body.fastest.max(pull * driver.log.clock.hi)
    }

    fn impact(driver: &mut Driver<'_, Self>, coming: &[usize]) -> Option<Outcome> {
        driver.impact(coming)
    }

    fn fly(driver: &mut Driver<'_, Self>) -> Option<Outcome> {
        driver.resting.fill(false);
        driver.note_flight();
        match driver.body.plain() {
            Some(model) => driver.clatter(&model),
            None => driver.next_touchdown(),
        }
    }

    fn rest(driver: &mut Driver<'_, Self>, rests: ContactValues<bool>, fresh: bool) -> DriverStep {
        driver.mechanism_phase(rests, fresh)
    }

    fn last_impacts(driver: &Driver<'_, Self>) -> String {
        match driver.body.plain() {
            Some(model) => {
                let state = &driver.body.state;
                next_landing(state.points.len(), &state.gaps(), model.g)
            }
            None => driver.body.last.family(&driver.log),
        }
    }

    fn last_warnings(driver: &mut Driver<'_, Self>) {
        let mut contacts = driver.body.state.rows.friction.iter().zip(driver.log.struck);
        if contacts.any(|(friction, struck)| struck && *friction > 0.0) {
            driver.record.warnings.push(NO_FRICTION.into());
        }
        let warning = chatter_warning(&driver.body.stopped_chatter, driver.body.fastest);
        driver.record.warnings.extend(warning);
    }
}

impl<'a> Driver<'a, Jointed> {
    /// `place`: size of the displacements at the start, in m.
    pub(crate) fn of_rows(
        state: Frozen,
        place: f64,
        subject: Subject,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let body = Jointed {
            frictionless: options.impact == Impact::Newton && options.jams == Jams::None
                || state.rows.friction.iter().all(|mu| *mu == 0.0),
            fastest: state.speed(),
            sequence: InstantImpacts::none(Coordinates::zeros(state.v.len())),
            state,
            place,
            slow: SlowContacts::default(),
            stopped_chatter: (BTreeSet::new(), 0.0),
            friction_warned: false,
            last: LastImpacts::default(),
            bounces: Bounces::default(),
            laps: NestedSequence::default(),
        };
        Self::with(body, subject, true, options, warnings, cancel)
    }

    pub(super) fn note_flight(&mut self) {
        self.log.enter(&ContactValues::from_elem(Mode::Separate, self.body.state.points.len()));
        self.write_flight();
    }

    pub(super) fn write_flight(&mut self) {
        if self.log.record {
            let word = ContactLetters::from_elem(Mode::Separate, self.body.state.points.len());
            self.write_modes(word, self.body.space().pull().clone());
        }
    }

    /// Begins a span in these modes with this acceleration.
    pub(super) fn write_modes(&mut self, word: ContactLetters<Mode>, acceleration: Coordinates) {
        if self.log.record {
            let start = Box::new(self.body.state.clone());
            self.write(Motion::Jointed { start, word, acceleration });
        }
    }

    /// Begins the record of a sum of impacts.
    pub(super) fn write_sum(&mut self, tail: Tail) {
        self.log.enter(&ContactValues::from_elem(Mode::Separate, self.body.state.points.len()));
        if self.log.record {
            let start = Box::new(self.body.state.clone());
            self.write(Motion::JointedTail { start, fastest: self.body.fastest, tail });
        }
    }

    /// Flight to the next touchdown.
    fn next_touchdown(&mut self) -> Option<Outcome> {
        let times = self.body.state.touchdowns();
        let first = times.iter().copied().fold(f64::INFINITY, f64::min);
        if let Some(outcome) = self.ends_before(first) {
            return Some(outcome);
        }
        self.body.state = self.body.state.flown(first);
        self.log.clock = self.log.clock.after(first);
        for (p, t) in self.body.state.points.iter_mut().zip(&times) {
            if *t == first {
                (p.h, p.u) = (0.0, p.u.min(0.0));
            }
        }
        None
    }

    /// Whether the flight ends at the time limit, or has no end, before this time; then moves there.
    fn ends_before(&mut self, t: f64) -> Option<Outcome> {
        let left = self.log.left();
        if t <= left && t < f64::INFINITY {
            return None;
        }
        if left == f64::INFINITY {
            return Some(Outcome::Escape);
        }
        self.body.state = self.body.state.flown(left.max(0.0));
        self.log.clock = self.log.clock.after(left.max(0.0));
        Some(Outcome::TimeLimit)
    }

    /// Records that these contacts have come to rest, and have lost all other motion across their ground.
    pub(super) fn settle(
        &mut self,
        contacts: &[usize],
        method: ZenoMethod,
        certified: bool,
        error: f64,
    ) -> Option<Outcome> {
        let count = self.body.state.points.len();
        let mut closed: PerContact<bool> = PerContact::from_elem(false, count);
        for &i in contacts {
            (self.resting[i], closed[i]) = (true, true);
        }
        if method != ZenoMethod::Rest {
            self.cause = Some(Cause::Zeno);
        }
        let stops = contacts.iter().all(|&i| self.body.state.rows.material[i].restitution == 0.0);
        let (clock, at) = (self.log.clock, Jointed::moment(self));
        if let Some(last) = self.record.zeno.last_mut()
            && method != ZenoMethod::Rest
            && clock.since(last.at.clock) <= 2.0 * f64::EPSILON * clock.hi
        {
            // The contacts of one accumulation come to rest one by one, within the rounding error of the clock.
            last.closed.iter_mut().zip(closed).for_each(|(one, other)| *one |= other);
            last.at = Moment { clock: last.at.clock, ..at };
            last.error = last.error.max(error);
            last.plastic &= stops;
            last.certified &= certified;
            if last.method == ZenoMethod::Bounce && last.closed.iter().filter(|on| **on).count() > 1
            {
                last.method = if contacts.len() > 1 { method } else { ZenoMethod::Mixed };
            }
            return (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno);
        }
        self.zeno_point(ZenoRecord {
            closed,
            method,
            certified,
            plastic: method == ZenoMethod::Bounce && stops,
            error,
            first_summed: self.log.hits,
            at,
        })
    }

    /// All contacts have just bounced in step, with gaps zero: if they go on to do so for ever, moves to the limit.
    pub(super) fn bounce_in_step(&mut self) -> Option<Option<Outcome>> {
        let (space, state) = (self.body.space(), &self.body.state);
        let e = |i: usize| self.body.state.rows.material[i].restitution;
        let flight = |i: usize| 2.0 * state.points[i].u / space.gravity(i);
        let alike = |i: usize| are_one(flight(i), flight(0)) && e(i) == e(0);
        let rises = |i: usize| state.points[i].h == 0.0 && state.points[i].u > 0.0;
        let count = state.points.len();
        let first = flight(0);
        if count < 2
            || !(first > 0.0 && first < f64::INFINITY)
            || !(0..count).all(|i| rises(i) && alike(i))
        {
            return None;
        }
        let t = first / (1.0 - e(0));
        if !(t <= self.log.left()) {
            return None;
        }
        self.write_sum(Tail::Collisions);
        let mut end = self.body.state.flown(t);
        // All impulses act along the normal rows, along which nothing has moved at the limit.
        let way = self.body.along(end.y.plus(&self.body.state.y, -1.0));
        end.y = self.body.state.y.plus(&way, 1.0);
        end.v = self.body.along(end.v);
        end.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
        self.body.state = end;
        self.log.clock = self.log.clock.after(t);
        let all: Vec<usize> = (0..count).collect();
        Some(self.settle(&all, ZenoMethod::Bounce, true, 0.0))
    }

    /// The state and the modes at time `dt` within a sum of impacts; `None` if too many events come before that time. `options`: of the run.
    pub(crate) fn resimulate_sum(
        start: &Frozen,
        fastest: f64,
        tail: Tail,
        subject: &Subject,
        options: &Options,
        dt: f64,
    ) -> Option<(Frozen, ContactLetters<Mode>)> {
        let (mut state, mut left) = (start.clone(), dt);
        if let Some(model) = &start.rows.gaps {
            let (t, gaps, own) = within(tail, model, &start.gaps(), dt);
            if t > 0.0 {
                (state, left) = (start.hit(t, &own, &gaps), (dt - t).max(0.0));
            }
            if matches!(tail, Tail::Bounce { .. }) {
                let word = ContactLetters::from_elem(Mode::Separate, state.points.len());
                return Some((state.flown(left), word));
            }
        }
        let options = options.of_resimulated_tail(left);
        let resting = state.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        let mut run = Driver::of_rows(state, 0.0, subject.clone(), &options, Vec::new(), &|| false);
        run.resting = resting;
        run.body.fastest = fastest;
        run.run_tail().map(|run| (run.body.state, run.log.word))
    }
}
