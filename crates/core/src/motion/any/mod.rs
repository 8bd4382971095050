//! The completed hybrid system for any number of contacts and every law of impact, event by event.
//!
//! The same loop as for two contacts without friction in their impacts, but without its closed sums of bounces and clatter: an
//! accumulation is followed until the speeds of its contacts are below the rounding of the speeds there have been, and ends
//! there. Impacts in turn in one instant are summed, and rounds of two contacts on the ground that repeat themselves.

mod impacts;
mod slow;
mod vertices;

use std::collections::BTreeSet;

use slow::{ChatterMonitor, Sequence};

use crate::body::contact::{ContactValues, PerContact};
use crate::body::posture::Posture;
use crate::collisions::log::{LastImpacts, Log};
use crate::flight::{LOST_PHASE, is_lost};
use crate::math::clock::Clock;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{ContactProblem, Mode};
use crate::motion::frame::Base;
use crate::motion::ground_watch::GroundWatch;
use crate::motion::record::{ListedImpact, Moment, Motion, Record, Span, ZenoRecord};
use crate::motion::rounds::Rounds;
use crate::options::{Options, Stop};
use crate::outcome::{Cause, Method, Outcome};
use crate::sustained::phase::{ContactPhase, PhaseEnd};
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{BEYOND, STILL};

/// Impacts between two computations of b, c from θ itself, and of gaps and rates that depend on others from those.
const REFRESH: usize = 32;

/// The loop.
pub(crate) struct General<'a> {
    posture: Posture,
    /// Number of contacts that differ: each has a point, and a second one behind them all while it is in a vertex.
    contacts: usize,
    options: Options,
    log: Log<'a>,
    state: BodyState,
    /// Contacts that rest or slide.
    resting: ContactValues<bool>,
    /// The last event; `None`: one that changes no mode.
    cause: Option<Cause>,
    /// The largest speed there has been, in m/s.
    fastest: f64,
    spans: Vec<Span>,
    impacts: Vec<ListedImpact>,
    zeno: Vec<ZenoRecord>,
    sequence: Sequence,
    /// Rounds on the ground, of a body with two contacts.
    rounds: Rounds,
    /// Impacts for which a contact that is slow enough to stop has waited for others.
    waiting: usize,
    ripple: ChatterMonitor,
    /// Contacts that were taken to rest as they rattled, and below which speed, in m/s.
    rattled: (BTreeSet<usize>, f64),
    /// Whether it has been said that friction acts between impacts only.
    told_of_friction: bool,
    /// Whether the ground of the contacts can be meant.
    watch: GroundWatch,
    last: LastImpacts,
    warnings: Vec<String>,
    undecided: Option<ContactProblem>,
    acceleration: Option<[f64; 3]>,
}

impl<'a> General<'a> {
    pub(crate) fn new(
        posture: &Posture,
        state: BodyState,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        Self {
            resting: ContactValues::from_elem(false, state.points.len()),
            posture: posture.clone(),
            contacts: posture.distinct().count(),
            options: *options,
            log: Log::new(options, state.points.len(), cancel),
            state,
            cause: Some(Cause::Start),
            fastest: 0.0,
            spans: Vec::new(),
            impacts: Vec::new(),
            zeno: Vec::new(),
            sequence: Sequence::default(),
            rounds: Rounds::default(),
            waiting: 0,
            ripple: ChatterMonitor::default(),
            rattled: (BTreeSet::new(), 0.0),
            told_of_friction: false,
            watch: GroundWatch::new(Some(posture)),
            last: LastImpacts::default(),
            warnings,
            undecided: None,
            acceleration: None,
        }
    }

    /// Runs to the outcome; `None` if cancelled.
    pub(crate) fn run(mut self, base: Base) -> Option<Record> {
        self.write(&ContactValues::from_elem(Mode::Separate, self.state.points.len()), false); // a run that ends at once has one, too
        let outcome = self.finish()?;
        let mut end = self.moment();
        if outcome == Outcome::Rest {
            end.state.qdot.fill(0.0);
        }
        Some(Record {
            outcome,
            base,
            frames: Vec::new(),
            spans: self.spans,
            zeno: self.zeno,
            warnings: self.warnings,
            collisions: Vec::new(),
            bodies: Vec::new(),
            impacts: self.impacts,
            hits: self.log.hits,
            end,
            acceleration: self.acceleration,
            undecided: self.undecided.map(Box::new),
        })
    }

    fn finish(&mut self) -> Option<Outcome> {
        let outcome = self.motion();
        if self.log.cancelled {
            return None;
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock = Clock { hi: self.log.end, lo: 0.0 };
        }
        self.look();
        let rattle = self.rattle();
        self.warnings.extend(rattle);
        if let Some(limit) = self.log.limit().filter(|_| outcome == Outcome::EventLimit) {
            self.warnings.push(format!("{limit}: {}", self.last.family(&self.log)));
        }
        Some(outcome)
    }

    /// The body now, as results give it.
    fn moment(&self) -> Moment {
        let (posture, points) = (&self.posture, &self.state.points);
        Moment {
            clock: self.log.clock,
            state: self.state.state(),
            gaps: posture.per_contact(|k| points[k].h.unsigned_zero()).collect(),
            rates: posture.per_contact(|k| points[k].u.unsigned_zero()).collect(),
        }
    }

    fn motion(&mut self) -> Outcome {
        let mut fresh = true;
        loop {
            if !self.log.step() {
                return Outcome::EventLimit;
            }
            if self.state.center.r.norm() > self.options.neighbourhood.min(BEYOND) {
                return Outcome::Escape;
            }
            let speed =
                self.state.center.v.norm() + self.posture.size() * self.state.spin.omega.abs();
            self.fastest = self.fastest.max(speed);
            if self.state.points.iter().any(|p| p.h == 0.0) {
                self.look();
            }
            let n = self.state.points.len(); // two for a contact in a vertex
            let touching = |i: usize| self.state.points[i].h == 0.0;
            let coming: ContactValues<usize> =
                (0..n).filter(|&i| touching(i) && self.state.points[i].u < 0.0).collect();
            let end = if !coming.is_empty() {
                self.impact(&coming)
            } else if (0..n).any(|i| touching(i) && self.state.points[i].u == 0.0) {
                self.rest(fresh)
            } else {
                self.fly()
            };
            fresh = false;
            if let Some(outcome) = end {
                return outcome;
            }
        }
    }

    /// Looks whether the ground of the contacts can be meant.
    fn look(&mut self) {
        let Self { posture, options, state, watch, warnings, log, .. } = self;
        let time = || options.clock(log.clock);
        watch.look_at(posture, state, state.frozen.is_some(), time, warnings);
    }

    fn note(&mut self, word: &[Mode], summed: bool) {
        self.log.enter(word);
        self.write(word, summed);
    }

    /// Begins a stretch of the record.
    fn write(&mut self, word: &[Mode], summed: bool) {
        if self.log.record {
            let (clock, state, cause) = (self.log.clock, self.state.clone(), self.cause);
            let letters = state.letters(word, &self.posture);
            let motion =
                if summed { Motion::Rounds(state) } else { Motion::Modes(state, word.into()) };
            self.spans.push(Span { clock, motion, letters, cause, first_collision: 0 });
        }
    }

    /// Whether a flight of a duration and over a way loses the place of the body: of one contact there is only the rotation.
    fn loses_place(&self, dt: f64, way: f64) -> bool {
        let BodyState { points, spin, .. } = &self.state;
        let turned = points.len() > 1 && (spin.theta != 0.0 || spin.omega != 0.0);
        let size = self.posture.size();
        is_lost(spin.omega * dt, if turned { way } else { 0.0 }, size * size)
    }

    /// Flight to the next touchdown, or to an end of a piece of terrain.
    fn fly(&mut self) -> Option<Outcome> {
        self.leave_vertices();
        let n = self.state.points.len();
        self.resting.fill(false);
        self.note(&ContactValues::from_elem(Mode::Separate, n), false);
        let lost = self.is_lost();
        let landings: ContactValues<Option<f64>> =
            (0..n).map(|i| self.state.touchdown(i)).collect();
        let first = landings.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let crossing = (0..n)
            .filter_map(|i| self.state.crossing(i).map(|(t, side)| (t, i, side)))
            .filter(|(t, ..)| !lost && *t < first)
            .min_by(|x, y| x.0.total_cmp(&y.0));
        let t = crossing.map_or(first, |(t, ..)| t);
        let left = self.log.left();
        let surfacing = (0..n)
            .filter(|_| !lost)
            .filter_map(|i| self.state.surfacing(i, t.min(left)).map(|t| (t, i)))
            .min_by(|x, y| x.0.total_cmp(&y.0));
        let t = surfacing.map_or(t, |(t, _)| t);
        // What lies beyond all bounds is never come to.
        let fall = |t: f64| t * (self.state.center.v.norm() + 0.5 * t * self.state.gravity);
        if t > left || t == f64::INFINITY || fall(t) > BEYOND {
            if left == f64::INFINITY || fall(left) > BEYOND {
                return Some(Outcome::Escape);
            }
            self.state = self.state.flown(left.max(0.0));
            self.log.clock = self.log.clock.after(left.max(0.0));
            return Some(Outcome::TimeLimit);
        }
        if self.state.frozen.is_none() && self.loses_place(t, fall(t)) {
            self.warnings.push(LOST_PHASE.into());
            return Some(Outcome::EventLimit);
        }
        self.state = self.state.flown(t);
        self.log.clock = self.log.clock.after(t);
        if self.log.hits.is_multiple_of(REFRESH) {
            self.refresh();
        }
        if let Some((_, i)) = surfacing {
            self.state.points[i].surfaces();
            return None;
        }
        if let Some((_, i, side)) = crossing {
            self.state.points[i].place.sides[side] = 0.0;
            self.cross(i, side);
            return None;
        }
        let now =
            |(p, landing): (&ContactState, &Option<f64>)| (*landing == Some(first)).then_some(*p);
        let firsts: PerContact<ContactState> =
            self.state.points.iter().zip(&landings).filter_map(now).collect();
        for (p, landing) in self.state.points.iter_mut().zip(landings) {
            if landing == Some(first) || firsts.iter().any(|first| p.lands_with(first)) {
                (p.h, p.u) = (0.0, p.u.min(0.0));
            }
        }
        None
    }

    /// Takes back what roundings have added up to: b, c from θ itself, and gaps and their rates of one rigid body.
    fn refresh(&mut self) {
        if self.state.frozen.is_none() {
            let theta = self.state.spin.theta;
            for p in &mut self.state.points {
                (p.b, p.c) = self.posture.on_nearest(&p.place).refreshed(theta, p.b, p.c);
            }
        }
        self.state.reconcile(self.posture.size());
    }

    /// Whether the body has fallen below all of its terrain: nothing is ever met again.
    fn is_lost(&self) -> bool {
        let BodyState { center, gravity, .. } = &self.state;
        let lowest = self.posture.lowest_ground();
        let rise = 0.5 * center.v.y.max(0.0) * center.v.y / gravity;
        let top = self.posture.fields().center_of_mass[1] + center.r.y + rise;
        lowest > f64::NEG_INFINITY && top + self.posture.size() < lowest
    }

    /// Notes that these contacts have come to rest, by an impact with the speed `hit` (m/s): 0 where impacts were summed, infinite
    /// where none was needed.
    fn settle(
        &mut self,
        points: &[usize],
        from_start: bool,
        error: f64,
        hit: f64,
    ) -> Option<Outcome> {
        let stops = points.iter().all(|&i| self.material(i).restitution == 0.0);
        let plastic = stops && !self.fades(hit);
        let mut closed: ContactValues<bool> = self.posture.per_contact(|_| false).collect();
        for &i in points {
            self.resting[i] = true;
            let at = self.posture.point_of(self.state.points[i].place.contact);
            for (closed, point) in closed.iter_mut().zip(self.posture.per_contact(|k| k)) {
                *closed |= point == at;
            }
        }
        if !from_start {
            self.cause = Some(Cause::Zeno);
        }
        let (clock, at) = (self.log.clock, self.moment());
        let distinct = |closed: &[bool]| self.posture.distinct().filter(|&i| closed[i]).count();
        match self.zeno.last_mut() {
            // One accumulation ends contact by contact, within the rounding of the clock.
            Some(last) if clock.since(last.at.clock) <= 2.0 * f64::EPSILON * clock.hi => {
                last.closed.iter_mut().zip(closed).for_each(|(one, other)| *one |= other);
                last.at = Moment { clock: last.at.clock, ..at };
                last.error = last.error.max(error);
                last.plastic &= plastic;
                if last.method == Method::Bounce && distinct(&last.closed) > 1 {
                    last.method = Method::Mixed;
                }
            }
            _ => self.zeno.push(ZenoRecord {
                method: match distinct(&closed) {
                    _ if from_start => Method::Rest,
                    1 => Method::Bounce,
                    _ => Method::Mixed,
                },
                closed: closed.into_iter().collect(),
                certified: from_start,
                plastic: plastic && !from_start,
                error,
                first_summed: self.log.hits,
                at,
            }),
        }
        (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno)
    }

    /// Sliding speed that counts as none, in m/s.
    fn still(&self) -> f64 {
        STILL * self.fastest.max(self.posture.fields().gravity * self.log.clock.hi)
    }

    /// Contacts at rest on the terrain go on in their mode.
    fn rest(&mut self, fresh: bool) -> Option<Outcome> {
        if fresh {
            self.rest_in_vertices();
        }
        let n = self.state.points.len();
        let mut rests: ContactValues<bool> =
            self.state.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        let (options, record) = (self.options, self.log.record);
        let still = self.still();
        let mut phase = ContactPhase::new(
            &self.posture,
            self.state.clone(),
            still,
            false,
            &options,
            self.cause,
        );
        phase.close(&mut rests);
        self.state = phase.stance.clone();
        // What the rotation takes off the ground has not come to rest, nor at the start what gravity does not press down.
        let held =
            |i: usize| self.resting[i] || self.state.twin(i).is_some_and(|j| self.resting[j]);
        let new: ContactValues<usize> = (0..n)
            .filter(|&i| rests[i] && !held(i))
            .filter(|&i| match self.state.arc(i).effective_gravity() {
                0.0 => !fresh,
                pull => pull > 0.0,
            })
            .collect();
        if !new.is_empty()
            && let Some(outcome) = self.settle(&new, fresh, 0.0, f64::INFINITY)
        {
            return Some(outcome);
        }
        phase.cause = self.cause;
        let (spans, rounds) = (&mut self.spans, &mut self.rounds);
        let (posture, watch, warnings) = (&self.posture, &mut self.watch, &mut self.warnings);
        rounds.drop(phase.dropped);
        let end = phase.run(&mut self.log, &mut |stance, word, clock, cause| {
            rounds.hold(word, clock);
            watch.look_at(
                posture,
                stance,
                stance.frozen.is_some(),
                || options.clock(clock),
                warnings,
            );
            if record {
                let letters = stance.letters(word, posture);
                let motion = Motion::Modes(stance.clone(), word.into());
                spans.push(Span { clock, motion, letters, cause, first_collision: 0 });
            }
        });
        self.resting = phase.word.iter().map(|mode| *mode != Mode::Separate).collect();
        self.resting.resize(n, false);
        (self.state, self.cause) = (phase.stance, phase.cause);
        self.warnings.extend(phase.warning);
        (self.undecided, self.acceleration) = (phase.undecided, phase.acceleration);
        match end {
            PhaseEnd::Outcome(Outcome::Inconsistent) if self.jam() => self.stop_after_jam(),
            PhaseEnd::Outcome(outcome) => Some(outcome),
            PhaseEnd::Free => self.fly(),
            PhaseEnd::Leave(i, side) => {
                self.cross_together(i, side);
                None
            }
            PhaseEnd::Landing(b) => self.round(b),
            PhaseEnd::Thaw => None,
        }
    }

    /// Contact `b` lands while another is held: where there are these two only, what all rounds that come after this one lead
    /// to may be known.
    fn round(&mut self, b: usize) -> Option<Outcome> {
        if self.state.points.len() != 2 {
            return None;
        }
        let (size, fastest) = (self.posture.size(), self.fastest);
        let clock = self.log.clock;
        let limit = self.rounds.land(b, &self.state, clock, size, fastest, self.log.left())?;
        self.note(&[Mode::Separate; 2], true);
        self.log.clock = clock.after(limit.duration);
        let before = std::mem::replace(&mut self.state, limit.end);
        // Each stays on its piece; how far along it has come, not where its rounded place lies.
        for (p, old) in self.state.points.iter_mut().zip(&before.points) {
            let turn = self.state.spin.theta - before.spin.theta;
            let way = self.state.center.r.x - before.center.r.x - old.arm().y * turn;
            let [left, right] = old.place.sides;
            p.place.sides = [left + way, right - way].map(|side| side.max(0.0));
        }
        let outcome = self.settle(&[0, 1], false, limit.error, 0.0);
        if let Some(last) = self.zeno.last_mut().filter(|last| last.method == Method::Mixed) {
            last.method = if limit.repeats { Method::Nested } else { Method::Mixed };
        }
        outcome
    }

    /// The state `dt` into a sum of rounds, round by round; `None` if too many events come before. `options`: of the run.
    pub(crate) fn resimulate_tail(
        posture: &Posture,
        start: &BodyState,
        clock: Clock,
        options: &Options,
        dt: f64,
    ) -> Option<BodyState> {
        let options = options.of_resimulated_tail(dt);
        let never = || false;
        let resting = start.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        // What counts as no speed is what did in the run.
        let fastest = start.gravity * clock.hi;
        let run = General::new(posture, start.clone(), &options, Vec::new(), &never);
        let mut run = General { resting, fastest, ..run };
        (run.finish()? == Outcome::TimeLimit).then_some(run.state)
    }
}
