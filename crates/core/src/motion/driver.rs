//! The completed hybrid system, event by event: collisions, their accumulation, and the motion after it until the run ends. One
//! loop covers any number of contacts, every impact law, and a Jacobian that turns with the body or is constant.
//!
//! ```text
//! flight ── collisions ──► accumulation (Zeno point) ──► some contacts held ──► another lands
//!   ▲                          │                              │                     │
//!   └── lift-off ◄─────────────┼──────────────────────────────┘◄────────────────────┘
//!                              └──► all held: at rest, or sliding without end
//! ```
//!
//! The state, [`Moving`], is that of a body that turns, or of contacts with constant rows. One contact, or two at different points, each on its own line
//! without ends, whose impacts have no friction, have fast loops over their collisions and sums in closed form, see [`plain`](super::plain).

use std::collections::BTreeSet;

use crate::body::contact::{ContactLetters, ContactValues, PerContact};
use crate::body::posture::Posture;
use crate::collisions::log::{LastImpacts, Log, names, next_landing};
use crate::error::Error;
use crate::flight::LOST_PHASE;
use crate::impact::friction::NO_FRICTION;
use crate::math::clock::Clock;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::modes::{Jamming, Mode};
use crate::motion::cycles::{Lap, NestedSequence, Rocking, only_held};
use crate::motion::ground::{Ground, OnGround};
use crate::motion::ground_watch::GroundWatch;
use crate::motion::moving::{Moving, REFRESH};
use crate::motion::record::{Moment, Motion, Record, Span, Tail};
use crate::motion::series::{Bounces, InstantImpacts, SlowContacts, chatter_warning};
use crate::motion::subject::Subject;
use crate::options::{Edges, Options};
use crate::outcome::{Cause, ContactNumber, End, FirstZeno, Outcome};
use crate::sustained::edges::EdgeWatch;
use crate::sustained::frozen::Frozen;
use crate::sustained::phase::{ContactPhase, PhaseEnd};
use crate::sustained::rows_phase::RowsPhase;
use crate::sustained::{BodyState, ContactState, still_speed};
use crate::tolerance::{DEPARTED, DEPARTS_AFTER, SLOWEST_KNOWN, TOUCH};

/// The warning of a run in which nothing is hit because the body falls off its ground.
const FACES_DOWN: &str = "no contact is hit, because the ground of all contacts faces down; the ground lies on the right-hand side of a \
                          terrain: list its vertices from left to right; slopes are in rad";

/// Number of times that a contact may leave its piece of ground at one instant before it goes to and fro between two pieces.
const TO_AND_FRO: usize = 16;

/// Most contact phases in a row for which the errors of sums count.
const MOST_VAGUE: usize = 256;

pub(crate) struct Driver<'a> {
    pub(crate) record: Box<Record>,
    pub(super) options: Options,
    pub(super) log: Log<'a>,
    pub(super) state: Moving,
    /// The ground of a body that turns.
    pub(super) ground: Option<Ground>,
    /// Whether impacts have the fast loops and the closed sums of [`plain`](super::plain).
    pub(super) plain: bool,
    /// Size of the displacements at the start, in m; for a body, its size.
    pub(super) place: f64,
    /// The largest speed so far, in m/s.
    pub(super) fastest: f64,
    /// Points that rest or slide, and whose Zeno point has been recorded.
    pub(super) resting: ContactValues<bool>,
    /// The last event; `None`: it changes no mode.
    pub(super) cause: Option<Cause>,
    /// Whether no event has occurred yet.
    pub(super) fresh: bool,
    pub(super) sequence: InstantImpacts,
    pub(super) bounces: Bounces,
    pub(super) cycles: NestedSequence,
    pub(super) rocking: Rocking,
    /// Successive landings of one of several contacts with speeds that may be rounding.
    pub(super) quiet_landings: usize,
    pub(super) slow: SlowContacts,
    /// Contacts that were set to rest because they chattered, and the speed below which they did, in m/s.
    pub(super) stopped_chatter: (BTreeSet<usize>, f64),
    /// The contacts of the last warning of a tie.
    tied: ContactValues<usize>,
    /// Whether the warning that friction does not act in impacts has been given.
    pub(super) friction_warned: bool,
    pub(super) last: LastImpacts,
    pub(super) watch: GroundWatch,
    pub(super) edges: EdgeWatch,
    /// The last instant at which a sliding contact left its piece of ground, and how often it has at this instant.
    crossings: (Clock, usize),
    /// Contact phases in a row just after sums whose errors made a larger sliding speed count as zero.
    vague: usize,
    /// The landing at which this run ends.
    pub(super) lap: Option<Lap>,
}

pub(crate) enum DriverStep {
    /// Another piece.
    Piece,
    /// Flight and collisions.
    Flight,
    End(Outcome),
}

impl From<Option<Outcome>> for DriverStep {
    fn from(end: Option<Outcome>) -> Self {
        end.map_or(Self::Piece, Self::End)
    }
}

impl<'a> Driver<'a> {
    /// A run of a body that turns.
    pub(crate) fn of_body(
        posture: &Posture,
        state: BodyState,
        subject: Subject,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let plain = options.is_plain(posture);
        let ground = Ground::new(posture, &state);
        let mut run =
            Self::new(Moving::Turning(Box::new(state)), subject, options, warnings, cancel);
        (run.ground, run.plain, run.place) = (Some(ground), plain, posture.size());
        run
    }

    /// A run with constant rows. `place`: size of the displacements at the start, in m.
    pub(crate) fn of_rows(
        state: Frozen,
        place: f64,
        subject: Subject,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let frictionless = options.is_frictionless(state.rows.friction.iter().copied());
        let (plain, fastest) = (frictionless && state.rows.gaps.is_some(), state.speed());
        let mut run =
            Self::new(Moving::Frozen(Box::new(state)), subject, options, warnings, cancel);
        (run.plain, run.place, run.fastest) = (plain, place, fastest);
        run
    }

    fn new(
        state: Moving,
        subject: Subject,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let local = state.turning().is_none();
        Self {
            log: Log::new(options, state.count(), cancel),
            resting: ContactValues::from_elem(false, state.count()),
            cause: Some(Cause::Start),
            fresh: true,
            sequence: InstantImpacts::none(state.velocity().len()),
            bounces: Bounces::default(),
            cycles: NestedSequence::default(),
            rocking: Rocking::default(),
            quiet_landings: 0,
            slow: SlowContacts::default(),
            stopped_chatter: (BTreeSet::new(), 0.0),
            tied: ContactValues::new(),
            friction_warned: false,
            last: LastImpacts::default(),
            watch: GroundWatch::new(subject.posture(), options.edges == Edges::Contact && !local),
            edges: EdgeWatch::new(subject.posture(), options),
            record: Box::new(Record::new(subject, warnings)),
            options: *options,
            state,
            ground: None,
            plain: false,
            place: 0.0,
            fastest: 0.0,
            crossings: (Clock::default(), 0),
            vague: 0,
            lap: None,
        }
    }

    /// The body over its ground; `None` for constant rows.
    pub(super) fn on_ground(&mut self) -> Option<OnGround<'_, 'a>> {
        let Self { state, ground, resting, edges, sequence, record, log, cause, options, .. } =
            self;
        let Moving::Turning(state) = state else { return None };
        let (ground, fastest) = (ground.as_mut()?, self.fastest);
        Some(OnGround {
            state,
            ground,
            resting,
            edges,
            sequence,
            record,
            log,
            cause,
            options,
            fastest,
        })
    }

    /// Runs from the start to the outcome.
    pub(crate) fn run(&mut self) -> Result<(), Error> {
        self.begin();
        self.run_on()
    }

    /// The end of an unrecorded run.
    pub(crate) fn end(&mut self) -> Result<End, Error> {
        self.begin();
        let outcome = self.motion();
        self.finish(outcome)
    }

    /// Runs to the outcome.
    pub(super) fn run_on(&mut self) -> Result<(), Error> {
        let outcome = self.motion();
        self.close(outcome)
    }

    /// Completes the record of a run with this outcome.
    pub(crate) fn close(&mut self, outcome: Outcome) -> Result<(), Error> {
        self.record.end = self.arrive(outcome)?;
        self.record.outcome = outcome;
        self.record.hits = self.log.hits;
        self.record.collisions = std::mem::take(&mut self.log.collisions);
        self.record.bodies = std::mem::take(&mut self.log.bodies);
        Ok(())
    }

    /// The record up to the time limit, for the run of a summed tail; `None` if another outcome ends it.
    pub(super) fn run_tail(mut self) -> Option<Box<Record>> {
        let outcome = self.motion();
        self.close(outcome).ok()?;
        (outcome == Outcome::TimeLimit).then_some(self.record)
    }

    /// The state at the time limit, for the run of a summed tail; `None` if another outcome ends it.
    pub(super) fn state_after_tail(mut self) -> Option<Moving> {
        (self.motion() == Outcome::TimeLimit).then_some(self.state)
    }

    /// The end of an unrecorded run.
    pub(super) fn finish(&mut self, outcome: Outcome) -> Result<End, Error> {
        let end = self.arrive(outcome)?;
        let time = |clock: Clock| self.options.clock(clock);
        let feet = self.record.subject.feet();
        let zeno = self.record.zeno.first().map(|zeno| {
            let mut closed = zeno.contacts(feet);
            let count = zeno.contacts(feet).count();
            FirstZeno {
                count,
                contact: closed.next().filter(|_| count == 1).map(ContactNumber::of),
                time: time(zeno.at.clock),
                elapsed: zeno.at.clock.hi,
            }
        });
        Ok(End {
            outcome,
            time: time(end.clock),
            elapsed: end.clock.hi,
            state: end.state,
            touching: end.touching(feet),
            zeno,
            collisions: self.log.hits,
            warned: !self.record.warnings.is_empty(),
        })
    }

    /// The state at the end of a motion.
    fn arrive(&mut self, outcome: Outcome) -> Result<Moment, Error> {
        if self.log.cancelled {
            return Err(Error::Cancelled);
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock = Clock { hi: self.log.end, lo: 0.0 };
        }
        let mut end = match self.record.zeno.last() {
            Some(zeno) if outcome == Outcome::Zeno => zeno.at.clone(),
            _ => self.moment(),
        };
        self.watch_moment(&end);
        self.last_warnings();
        let faces_down = |posture: &Posture| posture.geometry().iter().all(|k| k.normal.y < 0.0);
        if matches!(outcome, Outcome::Escape | Outcome::TimeLimit)
            && self.log.hits == 0
            && self.record.subject.posture().is_some_and(faces_down)
        {
            self.record.warnings.push(FACES_DOWN.into());
        }
        let problems = (&self.record.undecided, &self.record.undecided_mechanism);
        let jamming = match problems {
            (Some(problem), _) => Some(problem.jamming()),
            (_, Some(problem)) => Some(problem.jamming()),
            _ => None,
        };
        self.record.warnings.extend(jamming.and_then(|jams| undecided(outcome, jams)));
        // At a time limit it has left if all of it is beyond one end and does not come back.
        let gone = |posture: &Posture, left: f64, right: f64| {
            let (points, speed) =
                (posture.points(&end.state.q, self.state.turning().is_none()), end.state.qdot[0]);
            end.sides.is_empty()
                && (speed >= 0.0 && points.iter().all(|[x, _]| *x > right)
                    || speed <= 0.0 && points.iter().all(|[x, _]| *x < left))
        };
        if matches!(outcome, Outcome::Escape | Outcome::TimeLimit)
            && let Some(posture) = self.record.subject.posture()
            && posture.fields().gravity > 0.0
            && let [[first, _], others @ ..] = &posture.fields().terrain[..]
            && let (left, right) = others
                .iter()
                .fold((*first, *first), |(left, right), [x, _]| (left.min(*x), right.max(*x)))
            && let x = posture.fields().center_of_mass[0] + end.state.q[0]
            && !(left..right).contains(&x)
            && (outcome == Outcome::Escape || gone(posture, left, right))
        {
            self.record.warnings.push(format!(
                "the body has left the terrain, which ends at x = {left:?} m and x = {right:?} m: there is no ground beyond"
            ));
        }
        if self.log.phase_lost {
            self.record.warnings.push(LOST_PHASE.into());
        } else if outcome == Outcome::EventLimit
            && let Some(limit) = self.log.limit()
        {
            self.record.warnings.push(format!("{limit}: {}", self.last_impacts()));
        }
        if outcome == Outcome::Rest {
            end.state.qdot.fill(0.0);
        }
        Ok(end)
    }

    /// Checks the ground at this state of the body.
    pub(super) fn watch_moment(&mut self, now: &Moment) {
        let local = self.state.turning().is_none();
        let Self { watch, record, options, .. } = self;
        let Record { subject, warnings, .. } = &mut **record;
        let Some(posture) = subject.posture().filter(|_| watch.is_on()) else { return };
        let touches = |i: usize| now.gaps[i] == 0.0;
        watch.look(posture, &now.state.q, local, touches, || options.clock(now.clock), warnings);
    }

    pub(super) fn motion(&mut self) -> Outcome {
        loop {
            let end = match self.piece() {
                DriverStep::Piece => None,
                DriverStep::Flight => self.fly(),
                DriverStep::End(outcome) => Some(outcome),
            };
            if self.rows_part() {
                return Outcome::EventLimit;
            }
            if let Some(outcome) = end {
                return outcome;
            }
        }
    }

    /// Whether this is a run of outer feet, and the ground under a row may be no single piece any more: the inner feet no longer follow.
    fn rows_part(&self) -> bool {
        let Record { subject, sides, .. } = &*self.record;
        let Some(body) = self.state.turning().filter(|_| !subject.feet().is_empty()) else {
            return false;
        };
        let parts = |pair: &[ContactState]| pair[0].place.piece != pair[1].place.piece;
        !sides.is_empty() || body.points.windows(2).any(parts)
    }

    /// The next piece, up to the flight after it.
    pub(crate) fn piece(&mut self) -> DriverStep {
        if !self.log.step() {
            return DriverStep::End(Outcome::EventLimit);
        }
        if self.has_left() {
            return DriverStep::End(Outcome::Escape);
        }
        let fresh = std::mem::take(&mut self.fresh);
        let (mut touches, mut rests, mut coming) = (false, false, ContactValues::<usize>::new());
        for i in 0..self.state.count() {
            let (h, u) = self.state.point(i);
            touches |= h == 0.0;
            rests |= (h, u) == (0.0, 0.0);
            if h == 0.0 && u < 0.0 {
                coming.push(i);
            }
        }
        if touches {
            self.watch_ground();
        }
        if !coming.is_empty() {
            return self.impact(&coming).into();
        }
        if !rests {
            return DriverStep::Flight;
        }
        let rests = (0..self.state.count()).map(|i| self.state.point(i) == (0.0, 0.0)).collect();
        self.rest(rests, fresh)
    }

    /// Writes the first span, also if the run ends at once.
    pub(super) fn begin(&mut self) {
        if !self.plain
            && let Some(mut ground) = self.on_ground()
        {
            ground.begin();
        }
        self.write_flight();
    }

    /// Returns true if the motion has left the neighbourhood of the run; if not, the largest speed follows.
    pub(super) fn has_left(&mut self) -> bool {
        let (near, late) = (self.options.neighbourhood, self.log.clock.hi > DEPARTS_AFTER);
        let limit = near.min(DEPARTED);
        // Constant rows without a neighbourhood take longer to leave it than the age of the universe.
        let left = match &self.state {
            Moving::Turning(body) => body.center.r.norm() > limit,
            Moving::Frozen(rows) if near < f64::INFINITY || late => {
                match self.record.subject.posture() {
                    Some(_) => self.record.subject.state(rows).q.xy().norm() > limit,
                    None => rows.reach_of_contacts() > limit,
                }
            }
            Moving::Frozen(_) => false,
        };
        if !left {
            self.fastest = self.fastest.max(self.speed());
        }
        left
    }

    /// Bound of the speeds of the contacts, in m/s.
    pub(super) fn speed(&self) -> f64 {
        match &self.state {
            Moving::Turning(body) => body.center.v.norm() + self.place * body.spin.omega.abs(),
            Moving::Frozen(rows) => rows.speed(),
        }
    }

    /// Bound of the speeds of the contacts over the ground that the body touches, in m/s.
    pub(super) fn speed_over_ground(&self) -> f64 {
        match &self.state {
            Moving::Turning(body) => {
                body.velocity_over_ground().norm() + self.place * body.spin.omega.abs()
            }
            Moving::Frozen(rows) => rows.speed(),
        }
    }

    /// Sliding speed that counts as zero, in m/s.
    pub(super) fn sliding_tolerance(&self) -> f64 {
        still_speed(self.fastest, self.state.gravity(), self.log.clock)
    }

    /// Size of the displacements so far, in m.
    pub(super) fn place(&self) -> f64 {
        match &self.state {
            Moving::Turning(_) => self.place,
            Moving::Frozen(rows) => {
                let pull = rows.space().largest_pull();
                self.place + if pull > 0.0 { self.fastest * self.fastest / pull } else { 0.0 }
            }
        }
    }

    /// The current state, in the form of the results.
    pub(super) fn moment(&self) -> Moment {
        let (clock, subject) = (self.log.clock, &self.record.subject);
        match (&self.state, subject.posture()) {
            (Moving::Turning(body), Some(posture)) => {
                let (gaps, rates) = body.gaps_and_rates(posture);
                let closed = |contact: usize| {
                    body.points.iter().any(|p| p.place.contact == contact && p.h == 0.0)
                };
                let sides = body.sides.iter().map(|side| side.contact).filter(|k| closed(*k));
                let (state, sides) = (body.state(), sides.collect());
                Moment { clock, state, gaps, rates, sides, mechanism: None }
            }
            (Moving::Frozen(rows), _) => Moment {
                clock,
                state: subject.state(rows),
                gaps: subject.per_contact(|i| rows.points[i].h + 0.0).collect(),
                rates: subject.per_contact(|i| rows.points[i].u + 0.0).collect(),
                sides: PerContact::new(),
                mechanism: subject.mechanism().map(|_| rows.clone()),
            },
            (Moving::Turning(_), None) => Moment::of(subject),
        }
    }

    /// Checks the ground that the contacts are on.
    pub(super) fn watch_ground(&mut self) {
        let Self { watch, record, options, log, state, .. } = self;
        let Record { subject, warnings, .. } = &mut **record;
        match (state, subject.posture()) {
            (Moving::Turning(body), Some(posture)) => {
                watch.look_at(posture, body, || options.clock(log.clock), warnings);
            }
            _ if watch.is_on() => {
                let now = self.moment();
                self.watch_moment(&now);
            }
            _ => {}
        }
    }

    /// Flight up to the next event that is not a plain collision.
    fn fly(&mut self) -> Option<Outcome> {
        if let Some(end) = self.fly_plainly() {
            return end;
        }
        if let Moving::Turning(body) = &self.state
            && body.fall_changes()
        {
            return self.fly_by_series();
        }
        if let Some(mut ground) = self.on_ground() {
            return ground.next_event();
        }
        self.resting.fill(false);
        self.note_flight();
        self.next_touchdown()
    }

    /// Flight while the acceleration of free fall changes: the paths are no parabolas, and their Taylor series serve.
    fn fly_by_series(&mut self) -> Option<Outcome> {
        if let Some(mut ground) = self.on_ground() {
            ground.leave_vertices();
        }
        self.resting.fill(false);
        let body = BodyState::clone(self.state.turning()?);
        let mut none = ContactValues::from_elem(false, body.points.len());
        match self.phase_of_body(body, self.sliding_tolerance(), &mut none, false) {
            DriverStep::End(outcome) => Some(outcome),
            DriverStep::Piece | DriverStep::Flight => None,
        }
    }

    /// Continues from these points with zero gap and rate. `fresh`: at the start of the run.
    fn rest(&mut self, mut rests: ContactValues<bool>, fresh: bool) -> DriverStep {
        if !self.plain
            && let Some(mut ground) = self.on_ground()
            && ground.rest(fresh)
        {
            rests = self.state.points().map(|point| point == (0.0, 0.0)).collect();
        }
        self.contact_phase(rests, fresh)
    }

    /// What the impacts before the event limit have in common, in words.
    fn last_impacts(&self) -> String {
        let count = self.state.count();
        if self.plain {
            let gravity = [0, 1].map(|i| if i < count { self.state.pull(i) } else { 0.0 });
            return next_landing(count, &self.state.gaps(), gravity);
        }
        self.last.family(&self.log)
    }

    /// Adds the warnings at the end of the run.
    fn last_warnings(&mut self) {
        let rubs = |(i, struck): (usize, bool)| struck && self.state.friction(i) > 0.0;
        if self.log.struck.into_iter().take(self.state.count()).enumerate().any(rubs) {
            self.record.warnings.push(NO_FRICTION.into());
        }
        let (contacts, limit) = &self.stopped_chatter;
        if !contacts.is_empty() {
            let contacts: ContactValues<usize> = contacts.iter().copied().collect();
            let who = self.record.subject.names(&contacts);
            self.record.warnings.push(chatter_warning(&who, *limit, self.fastest));
        }
    }

    pub(super) fn note_flight(&mut self) {
        self.log.enter(&ContactLetters::from_elem(Mode::Separate, self.state.count()));
        self.write_flight();
    }

    pub(super) fn write_flight(&mut self) {
        if self.log.record {
            let word = ContactLetters::from_elem(Mode::Separate, self.state.count());
            let acceleration = match &self.state {
                Moving::Turning(_) => None,
                Moving::Frozen(rows) => Some(rows.space().pull().clone()),
            };
            self.write_modes(word, acceleration);
        }
    }

    /// Begins a span in these modes with this constant acceleration, if it is constant.
    pub(super) fn write_modes(
        &mut self,
        word: ContactLetters<Mode>,
        acceleration: Option<Coordinates>,
    ) {
        if self.log.record {
            let start = self.state.clone();
            self.write(Motion::Modes { start, word, acceleration });
        }
    }

    /// Begins the record of a sum of impacts.
    pub(super) fn begin_sum(&mut self, tail: Tail) {
        self.log.enter(&ContactLetters::from_elem(Mode::Separate, self.state.count()));
        if self.log.record {
            let (start, fastest) = (self.state.clone(), self.fastest);
            self.write(Motion::Sum { start, fastest, tail });
        }
    }

    /// Flight of constant rows to the next touchdown.
    fn next_touchdown(&mut self) -> Option<Outcome> {
        let Moving::Frozen(rows) = &mut self.state else { return None };
        let times = rows.touchdowns();
        let first = times.iter().copied().fold(f64::INFINITY, f64::min);
        let left = self.log.left();
        if first > left || first == f64::INFINITY {
            if left == f64::INFINITY {
                return Some(Outcome::Escape);
            }
            **rows = rows.flown(left.max(0.0));
            self.log.clock = self.log.clock.after(left.max(0.0));
            return Some(Outcome::TimeLimit);
        }
        **rows = rows.flown(first);
        self.log.clock = self.log.clock.after(first);
        if self.log.hits.is_multiple_of(REFRESH) {
            let place = self.place;
            rows.reconcile(place);
        }
        rows.follow_outer();
        for (p, t) in rows.points.iter_mut().zip(&times) {
            if *t == first {
                (p.h, p.u) = (0.0, p.u.min(0.0));
            }
        }
        rows.follow_outer();
        None
    }

    /// The sliding speed that counts as zero where a contact phase begins, in m/s; `gravity`: in m/s².
    ///
    /// After a sum whose time is known up to an error, velocities are known up to the change by gravity in this time. Where a contact is
    /// hardly pressed to its ground that error is large, and tells nothing about the other contacts.
    pub(super) fn slowest_known_slide(&mut self, gravity: f64) -> f64 {
        let last = self.record.zeno.last().filter(|last| last.at.clock == self.log.clock);
        let unknown = last.map_or(0.0, |last| last.error * gravity);
        let tolerance = self.sliding_tolerance();
        // A cycle of such sums has speeds of its own, such as that of a corner of the body that slides while a side comes to lie on its piece.
        self.vague = if unknown > tolerance { self.vague + 1 } else { 0 };
        let known = if self.vague > MOST_VAGUE { 1.0 } else { SLOWEST_KNOWN };
        tolerance.max(unknown.min(known * tolerance))
    }

    /// Begins a span of the record.
    fn write(&mut self, motion: Motion) {
        self.record.begin(&self.log, motion, self.cause);
    }

    /// Adds a warning that the run has not given yet.
    pub(super) fn warn_once(&mut self, warning: String) {
        if !self.record.warnings.contains(&warning) {
            self.record.warnings.push(warning);
        }
    }

    /// Warns of contacts, counted from 0, that collide at one instant.
    pub(super) fn warn_of_tie(&mut self, contacts: &[usize]) {
        if *self.tied == *contacts {
            return;
        }
        self.tied = contacts.into();
        self.warn_once(format!(
            "{} collided at the same instant; the outcome depends on the policy `simultaneous`",
            self.record.subject.names(contacts)
        ));
    }

    /// A contact phase from these points at rest on.
    fn contact_phase(&mut self, mut rests: ContactValues<bool>, fresh: bool) -> DriverStep {
        if rests.iter().zip(&self.resting).all(|(rests, known)| *rests && *known)
            && let Some(word) = self.stands()
        {
            return DriverStep::End(self.stand(word));
        }
        let slide = self.slowest_known_slide(self.state.gravity());
        match &self.state {
            Moving::Turning(body) => {
                self.phase_of_body(BodyState::clone(body), slide, &mut rests, fresh)
            }
            Moving::Frozen(rows) => {
                self.phase_of_rows(Frozen::clone(rows), slide, &mut rests, fresh)
            }
        }
    }

    fn phase_of_body(
        &mut self,
        body: BodyState,
        slide: f64,
        rests: &mut [bool],
        fresh: bool,
    ) -> DriverStep {
        // A clone of a posture is cheap: it shares its data.
        let Some(posture) = self.record.subject.posture().cloned() else {
            return DriverStep::Flight; // a body has a posture
        };
        let options = self.options;
        let mut phase = ContactPhase::new(&posture, body, slide, &options, self.cause);
        phase.close(rests);
        self.cycles.drop(phase.dropped);
        self.state.set_body(phase.body.clone());
        if let Some(ground) = self.on_ground() {
            phase.follows = ground.followers();
        }
        if let Some(outcome) = self.come_to_rest(rests, fresh) {
            return DriverStep::End(outcome);
        }
        phase.cause = self.cause;
        let Self { log, record, cycles, watch, edges, .. } = self;
        let (recorded, first_collision) = (log.record, log.collisions.len());
        let Record { spans, warnings, .. } = &mut **record;
        let end = phase.run(log, edges, &mut |body, word, clock, cause| {
            cycles.hold(word, clock);
            watch.look_at(&posture, body, || options.clock(clock), warnings);
            if recorded {
                let start = Moving::Turning(Box::new(body.clone()));
                let motion = Motion::Modes { start, word: word.into(), acceleration: None };
                spans.push(Span { clock, motion, cause, first_collision });
            }
        });
        self.cause = phase.cause;
        self.record.warnings.append(&mut phase.warnings);
        self.record.undecided = phase.undecided.take().map(Box::new);
        self.record.acceleration = phase.acceleration.take().map(Vec::from);
        let mut body = phase.body;
        if let PhaseEnd::Leave(i, side) = end {
            let now = self.log.clock;
            self.crossings = (now, if self.crossings.0 == now { self.crossings.1 + 1 } else { 1 });
            if self.crossings.1 > TO_AND_FRO {
                body.stop_before_end(i, side, slide);
            }
        }
        self.state.set_body(body);
        self.end_phase(&phase.word, end)
    }

    fn phase_of_rows(
        &mut self,
        rows: Frozen,
        slide: f64,
        rests: &mut [bool],
        fresh: bool,
    ) -> DriverStep {
        let mut phase = RowsPhase::new(rows, slide, self.fastest, self.cause);
        phase.close(rests, TOUCH * self.place());
        self.cycles.drop(phase.dropped);
        self.state.set_rows(phase.state.clone());
        if let Some(outcome) = self.come_to_rest(rests, fresh) {
            return DriverStep::End(outcome);
        }
        phase.cause = self.cause;
        let Self { log, record, cycles, .. } = self;
        let (recorded, first_collision) = (log.record, log.collisions.len());
        let Record { spans, .. } = &mut **record;
        let end = phase.run(log, &mut |state, word, acceleration, clock, cause| {
            cycles.hold(word, clock);
            if recorded {
                let start = Moving::Frozen(Box::new(state.clone()));
                let (word, acceleration) = (word.into(), Some(acceleration.clone()));
                spans.push(Span {
                    clock,
                    motion: Motion::Modes { start, word, acceleration },
                    cause,
                    first_collision,
                });
            }
        });
        self.cause = phase.cause;
        self.record.warnings.append(&mut phase.warnings);
        if let Some(ways) = phase.undecided.take() {
            self.record.write_undecided(&phase.state, &ways);
        }
        if let Some(acceleration) = phase.acceleration.take() {
            self.record.acceleration = self.acceleration_of(&acceleration);
        }
        self.state.set_rows(phase.state);
        self.end_phase(&phase.word, end)
    }

    /// Continues after a contact phase that ended in this word.
    fn end_phase(&mut self, word: &[Mode], end: PhaseEnd) -> DriverStep {
        for (resting, mode) in self.resting.iter_mut().zip(word) {
            *resting = *mode != Mode::Separate;
        }
        match end {
            PhaseEnd::Landing(_) if word.iter().all(|mode| *mode == Mode::Separate) => {
                DriverStep::Piece
            }
            PhaseEnd::Landing(i) => self.round(i, word),
            PhaseEnd::Stands => DriverStep::End(self.stand(word.into())),
            PhaseEnd::Free => DriverStep::Flight,
            PhaseEnd::Outcome(Outcome::Inconsistent) if self.jam() => self.stop_after_jam().into(),
            PhaseEnd::Outcome(Outcome::Inconsistent) if self.stands_at_last() => DriverStep::Piece,
            PhaseEnd::Outcome(outcome) => DriverStep::End(outcome),
            PhaseEnd::Corner(entry) => {
                if let Some(mut ground) = self.on_ground() {
                    ground.meet(entry);
                }
                DriverStep::Piece
            }
            PhaseEnd::Leave(i, side) => {
                if let Some(mut ground) = self.on_ground() {
                    ground.leave_together(i, side);
                }
                DriverStep::Piece
            }
        }
    }

    /// Point `b` lands while others are held in this word: a cycle ends. The limit of all further cycles may be known.
    fn round(&mut self, b: usize, word: &[Mode]) -> DriverStep {
        if let Some(end) = self.ends_lap(b, word) {
            return DriverStep::End(end);
        }
        if self.state.count() == 2
            && let Some(end) = self.stop_slowly(-self.state.point(b).1)
        {
            return end.into();
        }
        if let Some(end) = self.stop_chatter() {
            return end.into();
        }
        let Some(k) = only_held(word).filter(|_| self.lap.is_none()) else {
            return DriverStep::Piece;
        };
        if (self.state.count() == 2 || self.state.turning().is_some())
            && let Some(end) = self.sum_cycles(b, k)
        {
            return end.into();
        }
        self.sum_rocking([b, k], word[k]).map_or(DriverStep::Piece, DriverStep::from)
    }
}

/// What to know about the contact modes at the end of a run that has none to go on with, or several.
fn undecided(outcome: Outcome, jamming: Vec<Jamming>) -> Option<String> {
    match outcome {
        Outcome::Ambiguous => Some(
            "several contact modes are consistent, and the laws of rigid bodies do not choose: undecided has the problem, contact_modes lists them"
                .into(),
        ),
        Outcome::Inconsistent => {
            let jams: Vec<Jamming> =
                jamming.into_iter().filter(|jam| jam.margin < 0.0).collect();
            let contacts: BTreeSet<usize> = jams.iter().map(|jam| jam.contact.index()).collect();
            let least = jams.iter().map(|jam| jam.critical_friction).fold(f64::INFINITY, f64::min);
            (!jams.is_empty()).then(|| {
                format!(
                    "{} can jam (Painlevé), which needs friction above {least:?}, and no contact mode is consistent; with jams=\"impact\", or with Poisson's or Stronge's law, a run can go on",
                    names(contacts.into_iter())
                )
            })
        }
        _ => None,
    }
}
