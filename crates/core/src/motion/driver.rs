//! The completed hybrid system, event by event: collisions, their accumulation, and on through the limit until the run ends. One loop
//! for any number of contacts, every law of impact and both geometries.
//!
//! ```text
//! flight ── collisions ──► accumulation (Zeno point) ──► some contacts held ──► another lands
//!   ▲                          │                              │                     │
//!   └── lift-off ◄─────────────┼──────────────────────────────┘◄────────────────────┘
//!                              └──► all held: at rest, or sliding without end
//! ```
//!
//! The loop is written over the [`Coordinates`] in which a body is computed: [`Pair`](super::pair::Pair) for one contact or two with
//! frictionless impacts on lines without ends, whose plain collisions have fast loops and whose accumulations have closed sums; and
//! [`AnyContacts`](super::any::AnyContacts) for everything else.

use crate::body::contact::ContactValues;
use crate::body::posture::Posture;
use crate::collisions::log::Log;
use crate::flight::LOST_PHASE;
use crate::math::clock::Clock;
use crate::modes::{ContactProblem, Mode};
use crate::motion::frame::{Base, Frame, Snapshot};
use crate::motion::ground_watch::GroundWatch;
use crate::motion::record::{ListedImpact, Moment, Motion, Record, Span, ZenoRecord};
use crate::motion::rounds::{Limit, Rounds};
use crate::options::{Options, Stop};
use crate::outcome::{Cause, ContactNumber, End, FirstZeno, Outcome};
use crate::sustained::BodyState;
use crate::sustained::phase::{ContactPhase, PhaseEnd};

/// A run under way.
pub(crate) struct Driver<'a, C> {
    pub(super) base: Base,
    pub(super) options: Options,
    pub(super) log: Log<'a>,
    /// The state of the body, in the coordinates in which it is computed.
    pub(super) body: C,
    /// Whether the geometry is that of the nominal posture in the whole run.
    pub(super) local: bool,
    /// Points that rest or slide, and whose coming to rest has been recorded.
    pub(super) resting: ContactValues<bool>,
    /// The last event; `None`: one that changes no mode.
    pub(super) cause: Option<Cause>,
    /// Whether nothing has happened yet.
    fresh: bool,
    pub(super) rounds: Rounds,
    pub(super) watch: GroundWatch,
    pub(super) frames: Vec<Frame>,
    pub(super) spans: Vec<Span>,
    pub(super) impacts: Vec<ListedImpact>,
    pub(super) zeno: Vec<ZenoRecord>,
    pub(super) warnings: Vec<String>,
    /// Contacts that have no mode to go on in, or several.
    pub(super) undecided: Option<Box<ContactProblem>>,
    acceleration: Option<[f64; 3]>,
}

/// What a motion does next.
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

/// The coordinates of a body, and what the loop asks of them.
pub(crate) trait Coordinates: Sized {
    /// Gap (m) and rate (m/s) of each point.
    fn points(&self) -> ContactValues<(f64, f64)>;

    /// Whether the body has left the neighbourhood that the run is about.
    fn has_left(driver: &mut Driver<'_, Self>) -> bool;

    /// The body now, as results give it.
    fn moment(driver: &Driver<'_, Self>) -> Moment;

    /// Watches the ground that the contacts are on.
    fn watch_ground(driver: &mut Driver<'_, Self>);

    /// The largest speed there can have been, roughly, in m/s.
    fn largest_speed(driver: &Driver<'_, Self>) -> f64;

    /// Sliding speed that counts as none, in m/s.
    fn sliding_tolerance(driver: &Driver<'_, Self>) -> f64;

    /// These points, at zero gap, approach the ground.
    fn impact(driver: &mut Driver<'_, Self>, coming: &[usize]) -> Option<Outcome>;

    /// Flight up to the next event that is not a plain collision.
    fn fly(driver: &mut Driver<'_, Self>) -> Option<Outcome>;

    /// These points have neither gap nor rate. `fresh`: at the start of the run.
    fn rest(driver: &mut Driver<'_, Self>, rests: ContactValues<bool>, fresh: bool) -> DriverStep;

    /// The body, for a phase of contact that these points take part in; an outcome: the run ends here.
    fn enter_contact(driver: &mut Driver<'_, Self>, rests: &[bool]) -> Result<BodyState, Outcome>;

    /// Records which of these points, closed in this state of the body, have come to rest just now.
    fn come_to_rest(
        driver: &mut Driver<'_, Self>,
        body: &BodyState,
        rests: &[bool],
        fresh: bool,
    ) -> Option<Outcome>;

    /// The body after a phase of contact.
    fn leave_contact(driver: &mut Driver<'_, Self>, body: BodyState);

    /// A phase of contact has ended with this outcome; `None`: the run goes on after all.
    fn end_contact(_: &mut Driver<'_, Self>, outcome: Outcome) -> Option<Outcome> {
        Some(outcome)
    }

    /// A point has come to the left (0) or right (1) end of the piece of terrain under it.
    fn cross_end(_: &mut Driver<'_, Self>, _point: usize, _side: usize) {}

    /// Point `b` lands while another is held, so slowly that the body comes to rest.
    fn stop_slowly(_: &mut Driver<'_, Self>, _b: usize, _body: &BodyState) -> Option<DriverStep> {
        None
    }

    /// Infinitely many rounds lead to this limit.
    fn sum_rounds(driver: &mut Driver<'_, Self>, body: BodyState, limit: Limit) -> Option<Outcome>;

    /// What the impacts before a limit of events have in common, in words.
    fn last_impacts(driver: &Driver<'_, Self>) -> String;

    /// What else there is to warn of at the end.
    fn last_warnings(driver: &mut Driver<'_, Self>);
}

impl<'a, C: Coordinates> Driver<'a, C> {
    pub(super) fn with(
        body: C,
        base: Base,
        local: bool,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let points = body.points().len();
        Self {
            log: Log::new(options, points, cancel),
            resting: ContactValues::from_elem(false, points),
            cause: Some(Cause::Start),
            fresh: true,
            rounds: Rounds::default(),
            watch: GroundWatch::new(base.posture.as_ref()),
            frames: Vec::new(),
            spans: Vec::new(),
            impacts: Vec::new(),
            zeno: Vec::new(),
            warnings,
            undecided: None,
            acceleration: None,
            base,
            options: *options,
            body,
            local,
        }
    }

    /// Runs to the outcome; `None` if cancelled.
    pub(super) fn run_on(mut self) -> Option<Box<Record>> {
        let outcome = self.motion();
        let end = self.arrive(outcome)?;
        Some(Box::new(Record {
            outcome,
            base: self.base,
            frames: self.frames,
            spans: self.spans,
            zeno: self.zeno,
            warnings: self.warnings,
            collisions: self.log.collisions,
            bodies: self.log.bodies,
            impacts: self.impacts,
            hits: self.log.hits,
            end,
            acceleration: self.acceleration,
            undecided: self.undecided,
        }))
    }

    /// The state at the end of its time, for the run of a summed tail; `None` if something else ends it.
    pub(super) fn run_tail(mut self) -> Option<Self> {
        (self.motion() == Outcome::TimeLimit && !self.log.cancelled).then_some(self)
    }

    /// The end of a run that recorded nothing; `None` if it was cancelled.
    pub(crate) fn finish(&mut self, outcome: Outcome) -> Option<End> {
        let end = self.arrive(outcome)?;
        let time = |clock: Clock| self.options.clock(clock);
        let zeno = self.zeno.first().map(|zeno| {
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
            zeno,
            collisions: self.log.hits,
            warned: !self.warnings.is_empty(),
        })
    }

    /// The end of a motion; `None` if it was cancelled.
    fn arrive(&mut self, outcome: Outcome) -> Option<Moment> {
        if self.log.cancelled {
            return None;
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock = Clock { hi: self.log.end, lo: 0.0 };
        }
        let mut end = match self.zeno.last() {
            Some(zeno) if outcome == Outcome::Zeno => zeno.at.clone(),
            _ => C::moment(self),
        };
        self.watch_moment(&end);
        C::last_warnings(self);
        if self.log.phase_lost {
            self.warnings.push(LOST_PHASE.into());
        } else if let Some(limit) = self.log.limit().filter(|_| outcome == Outcome::EventLimit) {
            self.warnings.push(format!("{limit}: {}", C::last_impacts(self)));
        }
        if outcome == Outcome::Rest {
            end.state.qdot.fill(0.0);
        }
        Some(end)
    }

    /// Watches the ground at this state of the body.
    pub(super) fn watch_moment(&mut self, now: &Moment) {
        let Self { watch, base, local, options, warnings, .. } = self;
        let Some(posture) = base.posture.as_ref().filter(|_| watch.is_on()) else { return };
        let touches = |i: usize| now.gaps[i] == 0.0;
        watch.look(posture, &now.state.q, *local, touches, || options.clock(now.clock), warnings);
    }

    /// Piece after piece until an outcome.
    fn motion(&mut self) -> Outcome {
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
        let points = self.body.points();
        if points.iter().any(|(h, _)| *h == 0.0) {
            C::watch_ground(self);
        }
        let comes = |&i: &usize| points[i].0 == 0.0 && points[i].1 < 0.0;
        let coming: ContactValues<usize> = (0..points.len()).filter(comes).collect();
        if !coming.is_empty() {
            return C::impact(self, &coming).into();
        }
        let rests: ContactValues<bool> = points.iter().map(|point| *point == (0.0, 0.0)).collect();
        if !rests.contains(&true) {
            return DriverStep::Flight;
        }
        C::rest(self, rests, fresh)
    }

    /// Goes on from points that rest on the terrain, in their modes.
    pub(super) fn contact_phase(
        &mut self,
        mut rests: ContactValues<bool>,
        fresh: bool,
    ) -> DriverStep {
        let body = match C::enter_contact(self, &rests) {
            Ok(body) => body,
            Err(outcome) => return DriverStep::End(outcome),
        };
        // A copy shares all that it holds.
        let Some(posture) = self.base.posture.clone() else {
            unreachable!("contact phases belong to a body");
        };
        let (options, still) = (self.options, C::sliding_tolerance(self));
        let brief = body.frozen.is_some() && !self.local;
        let mut phase = ContactPhase::new(&posture, body, still, brief, &options, self.cause);
        phase.close(&mut rests);
        self.rounds.drop(phase.dropped);
        if let Some(outcome) = C::come_to_rest(self, &phase.stance, &rests, fresh) {
            return DriverStep::End(outcome);
        }
        phase.cause = self.cause;
        let mut end = self.stretches(&mut phase, &posture);
        while end == PhaseEnd::Thaw {
            let full = Snapshot::of_stance(&phase.stance, self.log.clock);
            phase.brief = false;
            phase.stance = self.base.stance(&full, None).unwrap_or(phase.stance);
            phase.stance.thaw();
            end = self.stretches(&mut phase, &posture);
        }
        self.cause = phase.cause;
        self.warnings.extend(phase.warning.take());
        self.undecided = phase.undecided.take().map(Box::new);
        self.acceleration = phase.acceleration.take();
        let body = phase.stance;
        match end {
            PhaseEnd::Landing(i) => {
                C::leave_contact(self, body.clone());
                self.round(i, body)
            }
            end => {
                C::leave_contact(self, body);
                match end {
                    PhaseEnd::Outcome(outcome) => C::end_contact(self, outcome).into(),
                    PhaseEnd::Free => DriverStep::Flight,
                    PhaseEnd::Leave(i, side) => {
                        C::cross_end(self, i, side);
                        DriverStep::Piece
                    }
                    PhaseEnd::Landing(_) | PhaseEnd::Thaw => DriverStep::Piece,
                }
            }
        }
    }

    /// Mode after mode until something else happens.
    fn stretches(&mut self, phase: &mut ContactPhase<'_>, posture: &Posture) -> PhaseEnd {
        let Self { log, spans, rounds, watch, warnings, local, options, .. } = self;
        let (record, first_collision) = (log.record, log.collisions.len());
        let end = phase.run(log, &mut |body, word, clock, cause| {
            rounds.hold(word, clock);
            watch.look_at(posture, body, *local, || options.clock(clock), warnings);
            if record {
                let letters = body.letters(word, posture);
                let motion = Motion::Modes(body.clone(), word.into());
                spans.push(Span { clock, motion, letters, cause, first_collision });
            }
        });
        for (resting, mode) in self.resting.iter_mut().zip(&phase.word) {
            *resting = *mode != Mode::Separate;
        }
        end
    }

    /// Point `b` lands while another is held: a round is over, and where the body has these two only, what all rounds after it lead
    /// to may be known.
    fn round(&mut self, b: usize, body: BodyState) -> DriverStep {
        if body.points.len() != 2 {
            return DriverStep::Piece;
        }
        if let Some(step) = C::stop_slowly(self, b, &body) {
            return step;
        }
        let size = self.base.posture.as_ref().map_or(0.0, Posture::size);
        let (clock, left) = (self.log.clock, self.log.left());
        let fastest = C::largest_speed(self);
        let Some(limit) = self.rounds.land(b, &body, clock, size, fastest, left) else {
            return DriverStep::Piece;
        };
        C::sum_rounds(self, body, limit).into()
    }

    /// Begins a span of the record.
    pub(super) fn write(&mut self, motion: Motion, letters: impl IntoIterator<Item = u8>) {
        self.spans.push(Span {
            clock: self.log.clock,
            motion,
            letters: letters.into_iter().collect(),
            cause: self.cause,
            first_collision: self.log.collisions.len(),
        });
    }

    /// Records a Zeno point; an outcome: the run ends with it.
    pub(super) fn zeno_point(&mut self, zeno: ZenoRecord) -> Option<Outcome> {
        self.zeno.push(zeno);
        (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::state::State;
    use crate::motion::pair::Pair;
    use crate::options::Model;
    use crate::simulate::Start;

    fn fall(model: Model, record: bool) -> Driver<'static, Pair> {
        let rod = Posture::rod(0.5, 0.3, 0.6, 0.3, 9.81).expect("a rod");
        let state = State::new([0.0, 0.2, 0.1], [0.3, 0.0, -0.2]);
        let start = Start::new(&rod, &state, model).expect("above the ground");
        let options = Options { record, ..Options::default() };
        start.driver(&rod, &state, &options, &|| false)
    }

    #[test]
    fn a_run_piece_by_piece_ends_in_the_bits_of_a_recorded_one() {
        for model in [Model::Local, Model::Full] {
            let whole = fall(model, true).run().expect("a record");
            let mut pieces = fall(model, false);
            let mut outcome = None;
            while outcome.is_none() {
                outcome = match pieces.piece() {
                    DriverStep::Piece => None,
                    DriverStep::Flight => Pair::fly(&mut pieces),
                    DriverStep::End(outcome) => Some(outcome),
                };
            }
            let end = pieces.finish(outcome.expect("rest")).expect("an end");
            assert_eq!((end.outcome, end.state), (Outcome::Rest, whole.end.state));
            assert_eq!((end.elapsed, end.collisions), (whole.end.clock.hi, whole.hits));
        }
    }
}
