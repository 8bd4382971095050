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
//! The loop is generic over the [`Coordinates`]: of a body that turns, or constant rows. One contact, or two at different points, each on its
//! own line without ends, whose impacts have no friction, have fast loops over their collisions and sums in closed form, see
//! [`plain`](super::plain).

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::body::contact::ContactValues;
use crate::body::posture::Posture;
use crate::collisions::log::{Log, names};
use crate::flight::LOST_PHASE;
use crate::math::clock::Clock;
use crate::modes::{Jamming, Mode};
use crate::motion::ground_watch::GroundWatch;
use crate::motion::nested::{Lap, Limit, NestedSequence};
use crate::motion::record::{Moment, Motion, Record, Span, ZenoRecord};
use crate::motion::subject::Subject;
use crate::options::{Edges, Options, Stop};
use crate::outcome::{Cause, ContactNumber, ContactSet, End, FirstZeno, Outcome};
use crate::sustained::BodyState;
use crate::sustained::edges::{EdgeWatch, Entry};
use crate::sustained::phase::{ContactPhase, PhaseEnd};
use crate::tolerance::SLOWEST_KNOWN;

/// The warning of a run in which nothing is hit because the body falls off its ground.
const FACES_DOWN: &str = "no contact is hit, because the ground of all contacts faces down; the ground lies on the right-hand side of a \
                          terrain: list its vertices from left to right; slopes are in rad";

/// Number of times that a contact may leave its piece of ground at one instant before it goes to and fro between two pieces.
const TO_AND_FRO: usize = 16;

/// Most contact phases in a row for which the errors of sums count.
const MOST_VAGUE: usize = 256;

pub(crate) struct Driver<'a, C> {
    pub(crate) record: Box<Record>,
    pub(super) options: Options,
    pub(super) log: Log<'a>,
    /// The state of the body, in the coordinates in which it is computed.
    pub(super) body: C,
    /// Whether the geometry is that of the nominal posture in the whole run.
    pub(super) local: bool,
    /// Points that rest or slide, and whose Zeno point has been recorded.
    pub(super) resting: ContactValues<bool>,
    /// The last event; `None`: it changes no mode.
    pub(super) cause: Option<Cause>,
    /// Whether no event has occurred yet.
    pub(super) fresh: bool,
    pub(super) nested: NestedSequence<Vector3<f64>>,
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

/// The coordinates of a body, and what the loop needs of them.
pub(crate) trait Coordinates: Sized {
    /// Writes the first span, also if the run ends at once. Returns an outcome if the run ends here.
    fn begin(driver: &mut Driver<'_, Self>) -> Option<Outcome>;

    /// Number of points: one per contact, and a second one while it is in a vertex.
    fn count(&self) -> usize;

    /// Gap (m) and rate (m/s) of a point.
    fn point(&self, i: usize) -> (f64, f64);

    /// Whether the body has left the neighbourhood of the run.
    fn has_left(driver: &mut Driver<'_, Self>) -> bool;

    /// The current state, in the form of the results.
    fn moment(driver: &Driver<'_, Self>) -> Moment;

    /// Checks the ground that the contacts are on.
    fn watch_ground(driver: &mut Driver<'_, Self>);

    /// Rough bound of all speeds so far, in m/s.
    fn largest_speed(driver: &Driver<'_, Self>) -> f64;

    /// Sliding speed that counts as zero, in m/s.
    fn sliding_tolerance(driver: &Driver<'_, Self>) -> f64;

    /// The impact of these points, at zero gap.
    fn impact(driver: &mut Driver<'_, Self>, coming: &[usize]) -> Option<Outcome>;

    /// Flight up to the next event that is not a plain collision.
    fn fly(driver: &mut Driver<'_, Self>) -> Option<Outcome>;

    /// Continues from these points with zero gap and rate. `fresh`: at the start of the run.
    fn rest(driver: &mut Driver<'_, Self>, rests: ContactValues<bool>, fresh: bool) -> DriverStep;

    /// What the impacts before the event limit have in common, in words.
    fn last_impacts(driver: &Driver<'_, Self>) -> String;

    /// Adds the warnings at the end of the run.
    fn last_warnings(driver: &mut Driver<'_, Self>);
}

/// The coordinates of a rigid body, and what its contact phases need of them.
pub(crate) trait Planar: Coordinates {
    /// The body for a contact phase of these points; an outcome: the run ends here.
    fn enter_contact(driver: &mut Driver<'_, Self>, rests: &[bool]) -> Result<BodyState, Outcome>;

    /// Records which of these points, closed in this state of the body, have just come to rest.
    fn come_to_rest(
        driver: &mut Driver<'_, Self>,
        body: &BodyState,
        rests: &[bool],
        fresh: bool,
    ) -> Option<Outcome>;

    /// Takes over the body after a contact phase.
    fn leave_contact(driver: &mut Driver<'_, Self>, body: BodyState);

    /// The outcome after a contact phase with this outcome; `None`: the run continues.
    fn end_contact(_: &mut Driver<'_, Self>, outcome: Outcome) -> Option<Outcome> {
        Some(outcome)
    }

    /// A corner of the ground meets a side of the body.
    fn meet_corner(_: &mut Driver<'_, Self>, _: Entry) {}

    /// A point has come to the left (0) or right (1) end of the piece of terrain under it.
    fn cross_end(_: &mut Driver<'_, Self>, _point: usize, _side: usize) {}

    /// Point `b` lands while another point is held: the step after this landing, if it is so slow that the body comes to rest.
    fn stop_slowly(_: &mut Driver<'_, Self>, _b: usize, _body: &BodyState) -> Option<DriverStep> {
        None
    }

    /// Moves to the limit of infinitely many cycles.
    fn sum_cycles(driver: &mut Driver<'_, Self>, limit: Limit) -> Option<Outcome>;
}

impl<'a, C: Coordinates> Driver<'a, C> {
    pub(super) fn with(
        body: C,
        subject: Subject,
        local: bool,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let points = body.count();
        Self {
            log: Log::new(options, points, cancel),
            resting: ContactValues::from_elem(false, points),
            cause: Some(Cause::Start),
            fresh: true,
            nested: NestedSequence::default(),
            watch: GroundWatch::new(subject.posture(), options.edges == Edges::Contact && !local),
            edges: EdgeWatch::new(subject.posture(), options, local),
            record: Box::new(Record::new(subject, warnings)),
            options: *options,
            body,
            local,
            crossings: (Clock::default(), 0),
            vague: 0,
            lap: None,
        }
    }

    /// Runs from the start to the outcome; `None` if cancelled.
    pub(crate) fn run(&mut self) -> Option<()> {
        match C::begin(self) {
            Some(outcome) => self.close(outcome),
            None => self.run_on(),
        }
    }

    /// The end of an unrecorded run; `None` if cancelled.
    pub(crate) fn end(&mut self) -> Option<End> {
        let outcome = C::begin(self).unwrap_or_else(|| self.motion());
        self.finish(outcome)
    }

    /// Runs to the outcome; `None` if cancelled.
    pub(super) fn run_on(&mut self) -> Option<()> {
        let outcome = self.motion();
        self.close(outcome)
    }

    /// Completes the record of a run with this outcome; `None` if cancelled.
    pub(crate) fn close(&mut self, outcome: Outcome) -> Option<()> {
        self.record.end = self.arrive(outcome)?;
        self.record.outcome = outcome;
        self.record.hits = self.log.hits;
        self.record.collisions = std::mem::take(&mut self.log.collisions);
        self.record.bodies = std::mem::take(&mut self.log.bodies);
        Some(())
    }

    /// The state at the time limit, for the run of a summed tail; `None` if another outcome ends it.
    pub(super) fn run_tail(mut self) -> Option<Self> {
        (self.motion() == Outcome::TimeLimit && !self.log.cancelled).then_some(self)
    }

    /// The end of an unrecorded run; `None` if it was cancelled.
    fn finish(&mut self, outcome: Outcome) -> Option<End> {
        let end = self.arrive(outcome)?;
        let time = |clock: Clock| self.options.clock(clock);
        let zeno = self.record.zeno.first().map(|zeno| {
            let mut closed = (0..zeno.closed.len()).filter(|&i| zeno.closed[i]);
            let count = closed.clone().count();
            FirstZeno {
                count,
                contact: closed.next().filter(|_| count == 1).map(ContactNumber::of),
                time: time(zeno.at.clock),
                elapsed: zeno.at.clock.hi,
            }
        });
        Some(End {
            outcome,
            time: time(end.clock),
            elapsed: end.clock.hi,
            state: end.state,
            touching: ContactSet::of_gaps(&end.gaps).with(end.sides.iter().copied()),
            zeno,
            collisions: self.log.hits,
            warned: !self.record.warnings.is_empty(),
        })
    }

    /// The state at the end of a motion; `None` if it was cancelled.
    fn arrive(&mut self, outcome: Outcome) -> Option<Moment> {
        if self.log.cancelled {
            return None;
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock = Clock { hi: self.log.end, lo: 0.0 };
        }
        let mut end = match self.record.zeno.last() {
            Some(zeno) if outcome == Outcome::Zeno => zeno.at.clone(),
            _ => C::moment(self),
        };
        self.watch_moment(&end);
        C::last_warnings(self);
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
            let (points, speed) = (posture.points(&end.state.q, self.local), end.state.qdot[0]);
            end.sides.is_empty()
                && (speed >= 0.0 && points.iter().all(|[x, _]| *x > right)
                    || speed <= 0.0 && points.iter().all(|[x, _]| *x < left))
        };
        if matches!(outcome, Outcome::Escape | Outcome::TimeLimit)
            && let Some(posture) = self.record.subject.posture()
            && posture.fields().gravity > 0.0
            && let [[left, _], .., [right, _]] = posture.fields().terrain[..]
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
            self.record.warnings.push(format!("{limit}: {}", C::last_impacts(self)));
        }
        if outcome == Outcome::Rest {
            end.state.qdot.fill(0.0);
        }
        Some(end)
    }

    /// Checks the ground at this state of the body.
    pub(super) fn watch_moment(&mut self, now: &Moment) {
        let Self { watch, record, local, options, .. } = self;
        let Record { subject, warnings, .. } = &mut **record;
        let Some(posture) = subject.posture().filter(|_| watch.is_on()) else { return };
        let touches = |i: usize| now.gaps[i] == 0.0;
        watch.look(posture, &now.state.q, *local, touches, || options.clock(now.clock), warnings);
    }

    pub(super) fn motion(&mut self) -> Outcome {
        loop {
            let end = match self.piece() {
                DriverStep::Piece => None,
                DriverStep::Flight => C::fly(self),
                DriverStep::End(outcome) => Some(outcome),
            };
            if let Some(outcome) = end {
                return outcome;
            }
        }
    }

    /// The next piece, up to the flight after it.
    pub(crate) fn piece(&mut self) -> DriverStep {
        if !self.log.step() {
            return DriverStep::End(Outcome::EventLimit);
        }
        if C::has_left(self) {
            return DriverStep::End(Outcome::Escape);
        }
        let fresh = std::mem::take(&mut self.fresh);
        let (mut touches, mut rests, mut coming) = (false, false, ContactValues::<usize>::new());
        for i in 0..self.body.count() {
            let (h, u) = self.body.point(i);
            touches |= h == 0.0;
            rests |= (h, u) == (0.0, 0.0);
            if h == 0.0 && u < 0.0 {
                coming.push(i);
            }
        }
        if touches {
            C::watch_ground(self);
        }
        if !coming.is_empty() {
            return C::impact(self, &coming).into();
        }
        if !rests {
            return DriverStep::Flight;
        }
        let rests = (0..self.body.count()).map(|i| self.body.point(i) == (0.0, 0.0)).collect();
        C::rest(self, rests, fresh)
    }

    /// The sliding speed that counts as zero where a contact phase begins, in m/s; `gravity`: in m/s².
    ///
    /// After a sum whose time is known up to an error, velocities are known up to the change by gravity in this time. Where a contact is
    /// hardly pressed to its ground that error is large, and tells nothing about the other contacts.
    pub(super) fn slowest_known_slide(&mut self, gravity: f64) -> f64 {
        let last = self.record.zeno.last().filter(|last| last.at.clock == self.log.clock);
        let unknown = last.map_or(0.0, |last| last.error * gravity);
        let tolerance = C::sliding_tolerance(self);
        // A cycle of such sums has speeds of its own, such as that of a corner of the body that slides while a side comes to lie on its piece.
        self.vague = if unknown > tolerance { self.vague + 1 } else { 0 };
        let known = if self.vague > MOST_VAGUE { 1.0 } else { SLOWEST_KNOWN };
        tolerance.max(unknown.min(known * tolerance))
    }

    /// Begins a span of the record.
    pub(super) fn write(&mut self, motion: Motion) {
        self.record.spans.push(Span {
            clock: self.log.clock,
            motion,
            cause: self.cause,
            first_collision: self.log.collisions.len(),
        });
    }

    /// Adds a warning that the run has not given yet.
    pub(super) fn warn_once(&mut self, warning: String) {
        if !self.record.warnings.contains(&warning) {
            self.record.warnings.push(warning);
        }
    }

    /// Warns of contacts, counted from 0, that collide at one instant.
    pub(super) fn warn_of_tie(&mut self, contacts: &[usize]) {
        self.warn_once(format!(
            "{} collided at the same instant; the outcome depends on the policy `simultaneous`",
            names(contacts.iter().copied())
        ));
    }

    /// Records a Zeno point; an outcome: the run ends with it.
    pub(super) fn zeno_point(&mut self, zeno: ZenoRecord) -> Option<Outcome> {
        self.record.zeno.push(zeno);
        (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno)
    }
}

impl<C: Planar> Driver<'_, C> {
    /// A contact phase from these points at rest on.
    pub(super) fn contact_phase(
        &mut self,
        mut rests: ContactValues<bool>,
        fresh: bool,
    ) -> DriverStep {
        let body = match C::enter_contact(self, &rests) {
            Ok(body) => body,
            Err(outcome) => return DriverStep::End(outcome),
        };
        // A clone of a posture is cheap: it shares its data.
        let Some(posture) = self.record.subject.posture().cloned() else {
            unreachable!("contact phases belong to a body");
        };
        let (options, tolerance) = (self.options, self.slowest_known_slide(body.gravity));
        let mut phase = ContactPhase::new(&posture, body, tolerance, &options, self.cause);
        phase.close(&mut rests);
        self.nested.drop(phase.dropped);
        if let Some(outcome) = C::come_to_rest(self, &phase.body, &rests, fresh) {
            return DriverStep::End(outcome);
        }
        phase.cause = self.cause;
        let end = self.stretches(&mut phase, &posture);
        self.cause = phase.cause;
        self.record.warnings.append(&mut phase.warnings);
        self.record.undecided = phase.undecided.take().map(Box::new);
        self.record.acceleration = phase.acceleration.take().map(Vec::from);
        let mut body = phase.body;
        if let PhaseEnd::Leave(i, side) = end {
            let now = self.log.clock;
            self.crossings = (now, if self.crossings.0 == now { self.crossings.1 + 1 } else { 1 });
            if self.crossings.1 > TO_AND_FRO {
                body.stop_before_end(i, side, tolerance);
            }
        }
        match end {
            PhaseEnd::Landing(i) => {
                C::leave_contact(self, body.clone());
                self.round(i, body)
            }
            end => {
                C::leave_contact(self, body);
                match end {
                    PhaseEnd::Outcome(outcome) => C::end_contact(self, outcome).into(),
                    PhaseEnd::Corner(entry) => {
                        C::meet_corner(self, entry);
                        DriverStep::Piece
                    }
                    PhaseEnd::Free => DriverStep::Flight,
                    PhaseEnd::Leave(i, side) => {
                        C::cross_end(self, i, side);
                        DriverStep::Piece
                    }
                    PhaseEnd::Landing(_) => DriverStep::Piece,
                }
            }
        }
    }

    fn stretches(&mut self, phase: &mut ContactPhase<'_>, posture: &Posture) -> PhaseEnd {
        let Self { log, record, nested, watch, edges, local, options, .. } = self;
        let (recorded, first_collision) = (log.record, log.collisions.len());
        let Record { spans, warnings, .. } = &mut **record;
        let end = phase.run(log, edges, &mut |body, word, clock, cause| {
            nested.hold(word, clock);
            watch.look_at(posture, body, *local, || options.clock(clock), warnings);
            if recorded {
                let motion = Motion::Modes(Box::new(body.clone()), word.into());
                spans.push(Span { clock, motion, cause, first_collision });
            }
        });
        for (resting, mode) in self.resting.iter_mut().zip(&phase.word) {
            *resting = *mode != Mode::Separate;
        }
        end
    }

    /// Point `b` lands while another is held: a cycle ends. If the body has only these two points, the limit of all further cycles may be
    /// known.
    fn round(&mut self, b: usize, body: BodyState) -> DriverStep {
        if body.points.len() != 2 {
            return DriverStep::Piece;
        }
        if let Some(lap) = self.lap.as_mut().filter(|lap| lap.contact == b) {
            lap.speed = Some(-body.points[b].u);
            return DriverStep::End(Outcome::TimeLimit);
        }
        if let Some(step) = C::stop_slowly(self, b, &body) {
            return step;
        }
        let size = self.record.subject.posture().map_or(0.0, Posture::size);
        let (clock, left) = (self.log.clock, self.log.left());
        let fastest = C::largest_speed(self);
        let near = self.nested.land(b, &body, clock, size, fastest, left);
        let Some(limit) = near.or_else(|| self.limit_of_laps(b, &body)) else {
            return DriverStep::Piece;
        };
        let posture = self.record.subject.posture();
        if posture.is_some_and(|posture| self.edges.is_inside(posture, &limit.end)) {
            return DriverStep::Piece; // it has entered in one of the cycles
        }
        C::sum_cycles(self, limit).into()
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
