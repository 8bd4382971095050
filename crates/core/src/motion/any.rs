//! Any number of contacts, every impact law, every terrain. The bounces of one contact are summed (`bounces`), and so are successive impacts at
//! one instant and cycles of two contacts on the ground (`nested`). Other accumulations end when the speeds of their contacts are below the
//! rounding error of the largest speed so far.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::body::contact::{ContactLetters, ContactValues};
use crate::body::posture::Posture;
use crate::collisions::log::LastImpacts;
use crate::flight::is_lost;
use crate::impact::friction::NO_FRICTION;
use crate::modes::Mode;
use crate::motion::bounces::{Bounces, Settled};
use crate::motion::driver::{Coordinates, Driver, DriverStep, Planar};
use crate::motion::lines::{Line, lines_of};
use crate::motion::nested::Limit;
use crate::motion::plain::{is_plain, next_landing, within};
use crate::motion::record::{Moment, Motion, Tail, ZenoRecord};
use crate::motion::slow::{InstantImpacts, SlowContacts};
use crate::motion::subject::Subject;
use crate::options::{Options, Stop};
use crate::outcome::{Cause, Outcome, ZenoMethod};
use crate::sustained::edges::{Entry, Path};
use crate::sustained::side::SideContact;
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{DEPARTED, LEFT_OF_ZERO, STILL};

/// Impacts between two computations of b, c from θ, and of dependent gaps and rates from independent ones.
const REFRESH: usize = 32;

/// The coordinates of a body with any number of contacts.
pub(crate) struct AnyContacts {
    pub(super) posture: Posture,
    pub(super) state: BodyState,
    /// Number of contacts, of the body and of corners of the ground on sides. Each contact has one point, and a second point while it is in a
    /// vertex. The second points come after all first points.
    pub(super) contacts: usize,
    /// The largest speed so far, in m/s.
    pub(super) fastest: f64,
    pub(super) sequence: InstantImpacts<Vector3<f64>>,
    pub(super) slow: SlowContacts,
    /// Contacts that were set to rest because they chattered, and the speed below which they did, in m/s.
    pub(super) stopped_chatter: (BTreeSet<usize>, f64),
    /// Whether the warning that friction does not act in impacts has been given.
    pub(super) friction_warned: bool,
    pub(super) last: LastImpacts,
    pub(super) bounces: Bounces,
    /// Contacts on one straight line of the body.
    pub(super) lines: Vec<Line>,
    /// Whether impacts have the fast loops and the closed sums of [`is_plain`].
    pub(super) plain: bool,
    /// The limit of the bounces in progress in a fast loop.
    pub(super) settled: Option<Box<Settled>>,
}

impl Coordinates for AnyContacts {
    fn begin(driver: &mut Driver<'_, Self>) -> Option<Outcome> {
        (0..driver.body.contacts).for_each(|i| driver.choose_by_facing(i));
        driver.touch_corners();
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
        let (speed, AnyContacts { state, fastest, .. }) = (driver.speed(), &mut driver.body);
        let left = state.center.r.norm() > driver.options.neighbourhood.min(DEPARTED);
        if !left {
            *fastest = fastest.max(speed);
        }
        left
    }

    fn moment(driver: &Driver<'_, Self>) -> Moment {
        let AnyContacts { posture, state, .. } = &driver.body;
        let (gaps, rates) = state.gaps_and_rates(posture);
        let closed = |side: &&SideContact| {
            state.points.iter().any(|p| p.place.contact == side.contact && p.h == 0.0)
        };
        let sides = state.sides.iter().filter(closed).map(|side| side.contact).collect();
        let (clock, mechanism) = (driver.log.clock, None);
        Moment { clock, state: state.state(), gaps, rates, sides, mechanism }
    }

    fn watch_ground(driver: &mut Driver<'_, Self>) {
        let Driver { body, record, options, watch, log, local, .. } = driver;
        let time = || options.clock(log.clock);
        watch.look_at(&body.posture, &body.state, *local, time, &mut record.warnings);
    }

    fn largest_speed(driver: &Driver<'_, Self>) -> f64 {
        let AnyContacts { state, fastest, plain, .. } = &driver.body;
        // The loops do not follow the speed.
        if *plain { fastest.max(state.gravity * driver.log.clock.hi) } else { *fastest }
    }

    fn sliding_tolerance(driver: &Driver<'_, Self>) -> f64 {
        driver.sliding_speed()
    }

    fn impact(driver: &mut Driver<'_, Self>, coming: &[usize]) -> Option<Outcome> {
        if let Some(end) = driver.impact_of_pair(coming) {
            return end;
        }
        if driver.drop_sides_passed() { None } else { driver.impact(coming) }
    }

    fn fly(driver: &mut Driver<'_, Self>) -> Option<Outcome> {
        match driver.fly_plainly() {
            Some(end) => end,
            None => driver.next_event(),
        }
    }

    fn rest(
        driver: &mut Driver<'_, Self>,
        mut rests: ContactValues<bool>,
        fresh: bool,
    ) -> DriverStep {
        if fresh {
            driver.rest_in_vertices();
        }
        driver.stay_in_vertices();
        if driver.drop_sides_at_corners() || fresh {
            let points = &driver.body.state.points;
            rests = points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        }
        driver.contact_phase(rests, fresh)
    }

    fn last_impacts(driver: &Driver<'_, Self>) -> String {
        let AnyContacts { state, plain, last, .. } = &driver.body;
        if *plain {
            let gravity =
                [0, 1].map(|i| if i < state.points.len() { state.known_pull(i) } else { 0.0 });
            return next_landing(state.points.len(), &state.gaps(), gravity);
        }
        last.family(&driver.log)
    }

    fn last_warnings(driver: &mut Driver<'_, Self>) {
        let mut contacts = driver.body.state.points.iter().zip(driver.log.struck);
        if contacts.any(|(p, struck)| struck && p.friction > 0.0) {
            driver.record.warnings.push(NO_FRICTION.into());
        }
        let chatter = driver.chatter_warning();
        driver.record.warnings.extend(chatter);
    }
}

impl Planar for AnyContacts {
    fn enter_contact(driver: &mut Driver<'_, Self>, rests: &[bool]) -> Result<BodyState, Outcome> {
        if driver.body.plain
            && rests.iter().zip(&driver.resting).all(|(rests, known)| *rests && *known)
            && let Some(modes) = driver.stands()
        {
            return Err(driver.stand(modes));
        }
        Ok(driver.body.state.clone())
    }

    fn come_to_rest(
        driver: &mut Driver<'_, Self>,
        body: &BodyState,
        rests: &[bool],
        fresh: bool,
    ) -> Option<Outcome> {
        driver.body.state = body.clone();
        // A contact with upward effective gravity does not come to rest, nor, at the start, one with none.
        let resting = &driver.resting;
        let held = |i: usize| resting[i] || body.second(i).is_some_and(|j| resting[j]);
        let new: ContactValues<usize> = (0..rests.len())
            .filter(|&i| rests[i] && !held(i))
            .filter(|&i| match body.known_pull(i) {
                0.0 => !fresh,
                pull => pull > 0.0,
            })
            .collect();
        if new.is_empty() {
            return None;
        }
        let method = match (fresh, driver.body.plain) {
            (true, _) => Some(ZenoMethod::Rest),
            (_, true) => Some(ZenoMethod::Bounce),
            _ => None,
        };
        driver.settle(&new, method, fresh || driver.body.plain, 0.0, f64::INFINITY)
    }

    fn leave_contact(driver: &mut Driver<'_, Self>, body: BodyState) {
        driver.body.state = body;
    }

    fn end_contact(driver: &mut Driver<'_, Self>, outcome: Outcome) -> Option<Outcome> {
        match outcome {
            Outcome::Inconsistent if driver.jam() => driver.stop_after_jam(),
            Outcome::Inconsistent if driver.stands_at_last() => None,
            outcome => Some(outcome),
        }
    }

    fn meet_corner(driver: &mut Driver<'_, Self>, entry: Entry) {
        driver.meet(entry);
    }

    fn cross_end(driver: &mut Driver<'_, Self>, point: usize, side: usize) {
        driver.leave_together(point, side);
    }

    fn stop_slowly(
        driver: &mut Driver<'_, Self>,
        b: usize,
        body: &BodyState,
    ) -> Option<DriverStep> {
        if driver.body.plain { driver.stop_slowly(b, body).map(DriverStep::from) } else { None }
    }

    fn sum_cycles(driver: &mut Driver<'_, Self>, limit: Limit) -> Option<Outcome> {
        driver.sum_cycles(limit)
    }
}

impl<'a> Driver<'a, AnyContacts> {
    pub(crate) fn of_any(
        posture: &Posture,
        state: BodyState,
        subject: Subject,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let local = state.frozen;
        let plain = !local && is_plain(posture, options);
        let body = AnyContacts {
            posture: posture.clone(),
            contacts: posture.distinct().count() + state.sides.len(),
            state,
            fastest: 0.0,
            sequence: InstantImpacts::none(Vector3::zeros()),
            slow: SlowContacts::default(),
            stopped_chatter: (BTreeSet::new(), 0.0),
            friction_warned: false,
            last: LastImpacts::default(),
            bounces: Bounces::default(),
            lines: if plain { Vec::new() } else { lines_of(posture) },
            plain,
            settled: None,
        };
        Self::with(body, subject, local, options, warnings, cancel)
    }

    /// Flies on to the first corner of the ground that meets a side within `t` (s). Returns whether there is one.
    fn meets(&mut self, t: f64) -> bool {
        let Self { body, log, edges, record, options, .. } = self;
        let at = |t| body.state.flown(t);
        let path = Path::new(&body.posture, &at);
        let time = |t| options.clock(log.clock.after(t));
        let fall = Some(body.state.fall);
        let Some(entry) = edges.entry(path, t, fall, time, &mut record.warnings) else {
            return false;
        };
        (body.state, log.clock) = (body.state.flown(entry.t), log.clock.after(entry.t));
        self.meet(entry);
        true
    }

    /// The state and the modes at time `dt` within a sum of impacts that starts in this state; `None` if too many events come before that time.
    /// `options`: of the run.
    pub(crate) fn resimulate_cycles(
        posture: &Posture,
        start: &BodyState,
        fastest: f64,
        tail: Tail,
        subject: &Subject,
        options: &Options,
        dt: f64,
    ) -> Option<(BodyState, ContactLetters<Mode>)> {
        let (mut state, mut left) = (start.clone(), dt);
        if tail != Tail::Collisions
            && let Some(pair) = subject.pair()
        {
            let full = start.full(pair);
            let model = full.model();
            let (t, gaps, own) = within(tail, &model, &full.gaps, dt);
            state.follow(&full.hit(&model, t, &own, &gaps));
            left = (dt - t).max(0.0);
            if matches!(tail, Tail::Bounce { .. }) {
                let word = ContactLetters::from_elem(Mode::Separate, state.points.len());
                return Some((state.flown(left), word));
            }
        }
        let options = options.of_resimulated_tail(left);
        let resting = state.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        let mut run =
            Driver::of_any(posture, state, subject.clone(), &options, Vec::new(), &|| false);
        run.resting = resting;
        run.body.fastest = fastest;
        run.run_tail().map(|run| (run.body.state, run.log.word))
    }

    /// No mode is consistent, with speeds that are what impacts one after the other have left of zero: the body stands. At rest there is a mode.
    /// Returns whether it moved.
    fn stands_at_last(&mut self) -> bool {
        let speed = self.speed();
        let state = &mut self.body.state;
        let moves = speed > 0.0 && speed <= LEFT_OF_ZERO * self.body.fastest;
        if moves {
            state.stand();
            self.record.undecided = None;
        }
        moves
    }

    /// Bound of the speeds of the points of the body, in m/s.
    pub(super) fn speed(&self) -> f64 {
        let BodyState { center, spin, .. } = &self.body.state;
        center.v.norm() + self.body.posture.size() * spin.omega.abs()
    }

    pub(super) fn note_flight(&mut self) {
        self.log.enter(&ContactValues::from_elem(Mode::Separate, self.body.state.points.len()));
        self.write_flight();
    }

    /// Begins the record of a sum of impacts.
    pub(super) fn begin_sum(&mut self, tail: Tail) {
        let state = &self.body.state;
        self.log.enter(&ContactLetters::from_elem(Mode::Separate, state.points.len()));
        if self.log.record {
            let (start, fastest) = (Box::new(state.clone()), AnyContacts::largest_speed(self));
            self.write(Motion::Cycles { start, fastest, tail });
        }
    }

    pub(super) fn write_flight(&mut self) {
        if self.log.record {
            let word = ContactLetters::from_elem(Mode::Separate, self.body.state.points.len());
            self.write(Motion::Modes(Box::new(self.body.state.clone()), word));
        }
    }

    /// Sliding speed that counts as zero, in m/s.
    pub(super) fn sliding_speed(&self) -> f64 {
        STILL * self.body.fastest.max(self.body.state.gravity * self.log.clock.hi)
    }

    /// Moves to the limit of infinitely many cycles.
    fn sum_cycles(&mut self, limit: Limit) -> Option<Outcome> {
        self.begin_sum(Tail::Collisions);
        self.log.clock = self.log.clock.after(limit.duration);
        self.body.state = limit.end;
        let method = if limit.repeats { ZenoMethod::Nested } else { ZenoMethod::Mixed };
        self.settle(&[0, 1], Some(method), false, limit.error, 0.0)
    }

    /// Records that these contacts have come to rest. `method`: `None`: by single impacts; `hit`: speed of the impact that stopped them, in m/s;
    /// 0 if impacts were summed, infinite if there was no impact.
    pub(super) fn settle(
        &mut self,
        points: &[usize],
        method: Option<ZenoMethod>,
        certified: bool,
        error: f64,
        hit: f64,
    ) -> Option<Outcome> {
        let from_start = method == Some(ZenoMethod::Rest);
        let stops = points.iter().all(|&i| self.material(i).restitution == 0.0);
        let plastic = stops && !self.fades(hit);
        let mut closed: ContactValues<bool> = self.body.posture.per_contact(|_| false).collect();
        let count = closed.len();
        closed.resize(count + self.record.sides.len(), false);
        for &i in points {
            self.resting[i] = true;
            let contact = self.body.state.points[i].place.contact;
            if contact >= count {
                closed[contact] = true;
                continue;
            }
            let at = self.body.posture.point_of(contact);
            for (closed, point) in closed.iter_mut().zip(self.body.posture.per_contact(|k| k)) {
                *closed |= point == at;
            }
        }
        if !from_start {
            self.cause = Some(Cause::Zeno);
        }
        let (clock, at) = (self.log.clock, AnyContacts::moment(self));
        let distinct = |closed: &[bool]| {
            let own = self.body.posture.distinct().filter(|&i| closed[i]).count();
            own + closed[count..].iter().filter(|&&closed| closed).count()
        };
        match self.record.zeno.last_mut() {
            // The contacts of one accumulation come to rest one by one, within the rounding error of the clock.
            Some(last) if clock.since(last.at.clock) <= 2.0 * f64::EPSILON * clock.hi => {
                last.closed.resize(closed.len(), false);
                last.closed.iter_mut().zip(closed).for_each(|(one, other)| *one |= other);
                last.at = Moment { clock: last.at.clock, ..at };
                last.error = last.error.max(error);
                last.plastic &= plastic;
                last.certified &= certified;
                if last.method == ZenoMethod::Bounce && distinct(&last.closed) > 1 {
                    let whole = method.filter(|_| points.len() > 1);
                    last.method = whole.unwrap_or(ZenoMethod::Mixed);
                }
            }
            _ => {
                let single =
                    if distinct(&closed) == 1 { ZenoMethod::Bounce } else { ZenoMethod::Mixed };
                return self.zeno_point(ZenoRecord {
                    closed: closed.into_iter().collect(),
                    method: method.unwrap_or(single),
                    certified,
                    plastic: plastic && !from_start,
                    error,
                    first_summed: self.log.hits,
                    at,
                });
            }
        }
        (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno)
    }

    /// Whether a flight of this duration and distance is too long for the position to stay resolved. With one contact only the
    /// angle counts.
    fn loses_place(&self, dt: f64, way: f64) -> bool {
        let BodyState { points, spin, .. } = &self.body.state;
        let turned = points.len() > 1 && (spin.theta != 0.0 || spin.omega != 0.0);
        let size = self.body.posture.size();
        is_lost(spin.omega * dt, if turned { way } else { 0.0 }, size * size)
    }

    /// Flight to the next touchdown or end of a piece of terrain.
    fn next_event(&mut self) -> Option<Outcome> {
        self.leave_vertices();
        let n = self.body.state.points.len();
        self.resting.fill(false);
        let lost = self.is_lost();
        if lost {
            // No contact has ground to meet any more, whichever piece it was over.
            self.body.state.points.iter_mut().for_each(|p| (p.h, p.depth) = (f64::INFINITY, 0.0));
        }
        self.note_flight();
        let landings = self.body.state.touchdowns(|j| self.is_between(j));
        let first = landings.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let crossing = (0..n)
            .filter_map(|i| self.body.state.crossing(i, first).map(|(t, side)| (t, i, side)))
            .filter(|(t, ..)| !lost && *t < first)
            .min_by(|x, y| x.0.total_cmp(&y.0));
        let t = crossing.map_or(first, |(t, ..)| t);
        let left = self.log.left();
        let surfacing = (0..n)
            .filter(|_| !lost)
            .filter_map(|i| self.body.state.surfacing(i, t.min(left)).map(|t| (t, i)))
            .min_by(|x, y| x.0.total_cmp(&y.0));
        let t = surfacing.map_or(t, |(t, _)| t);
        let strike = (0..n)
            .filter(|_| !lost)
            .filter_map(|i| {
                self.body.state.strike(i, &self.body.posture, t.min(left)).map(|hit| (hit, i))
            })
            .min_by(|x, y| x.0.0.total_cmp(&y.0.0));
        let t = strike.map_or(t, |((t, _), _)| t);
        // Events farther away than `DEPARTED` are never reached.
        let fall =
            |t: f64| t * (self.body.state.center.v.norm() + 0.5 * t * self.body.state.gravity);
        if t > left || t == f64::INFINITY || fall(t) > DEPARTED {
            let departs = left == f64::INFINITY || fall(left) > DEPARTED;
            if self.meets(left.max(0.0)) {
                return None;
            }
            if departs {
                return Some(Outcome::Escape);
            }
            self.body.state = self.body.state.flown(left.max(0.0));
            self.log.clock = self.log.clock.after(left.max(0.0));
            return Some(Outcome::TimeLimit);
        }
        if !self.body.state.frozen && self.loses_place(t, fall(t)) {
            self.log.phase_lost = true;
            return Some(Outcome::EventLimit);
        }
        if self.meets(t) {
            return None;
        }
        self.body.state = self.body.state.flown(t);
        self.log.clock = self.log.clock.after(t);
        if self.log.hits.is_multiple_of(REFRESH) {
            self.refresh();
        }
        self.follow_outer();
        if let Some(((_, k), i)) = strike {
            self.body.state.put_on(i, &self.body.posture, k);
            return None;
        }
        if let Some((_, i)) = surfacing {
            self.body.state.points[i].surfaces();
            return None;
        }
        if let Some((_, i, side)) = crossing {
            self.body.state.points[i].place.sides[side] = 0.0;
            if !self.lands_in_vertex(i) {
                self.cross(i, side);
            }
            return None;
        }
        for (p, landing) in self.body.state.points.iter_mut().zip(landings) {
            if landing == Some(first) {
                (p.h, p.u) = (0.0, p.u.min(0.0));
            }
        }
        self.follow_outer();
        None
    }

    /// Corrects accumulated rounding errors: computes b, c from θ, and makes gaps and rates consistent with one rigid body.
    fn refresh(&mut self) {
        if !self.body.state.frozen {
            let theta = self.body.state.spin.theta;
            let count = self.body.posture.contacts().len();
            let own = |p: &&mut ContactState| p.place.contact < count;
            for p in self.body.state.points.iter_mut().filter(own) {
                (p.b, p.c) = self.body.posture.on_nearest(&p.place).refreshed(theta, p.b, p.c);
            }
        }
        self.body.state.reconcile(self.body.posture.size());
    }

    /// Whether the body has fallen below all of its terrain, so that it meets nothing any more. In the local model a contact moves away
    /// from the centre of mass without bound.
    fn is_lost(&self) -> bool {
        let BodyState { center, fall, frozen, .. } = &self.body.state;
        if *frozen {
            return false;
        }
        let rise = match (center.v.y.max(0.0), fall.y) {
            (0.0, ..=0.0) => 0.0,
            (up, ..0.0) => -0.5 * up * up / fall.y,
            _ => return false,
        };
        let lowest = self.body.posture.lowest_ground();
        let top = self.body.posture.fields().center_of_mass[1] + center.r.y + rise;
        lowest > f64::NEG_INFINITY && top + self.body.posture.size() < lowest
    }
}
