//! The completed hybrid system of two contacts and frictionless impacts: collisions, their accumulation, and on through
//! the limit. What contacts at rest do, with friction or without, is in `rest.rs`.
//!
//! ```text
//! flight ── collisions ──► accumulation (Zeno point) ──► one contact held ──► the other lands (corner)
//!   ▲                          │                              │                     │
//!   └── lift-off ◄─────────────┼──────────────────────────────┘◄────────────────────┘
//!                              └──► both held: at rest, or sliding without end
//! ```

mod rest;

use crate::body::contact::PerContact;
use crate::collisions::full::FullState;
use crate::collisions::local::{LoopExit, are_one};
use crate::collisions::log::{Collision, Log, in_words, names};
use crate::collisions::{full, local};
use crate::flight::{LOST_PHASE, parabola_touchdown};
use crate::impact::friction::NO_FRICTION;
use crate::impact::newton;
use crate::impact::newton::{Hit, Sequence};
use crate::math::clock::Clock;
use crate::modes::{ContactProblem, Mode};
use crate::motion::frame::{Base, Frame, Snapshot};
use crate::motion::ground_watch::GroundWatch;
use crate::motion::record::{InFrame, Moment, Motion, Record, Span, Tail, ZenoRecord};
use crate::motion::rounds::{ROUNDINGS, Rounds};
use crate::options::{Options, Simultaneous, Stop};
use crate::outcome::{Cause, ContactNumber, End, FirstZeno, Method, Outcome};
use crate::tolerance::{BEYOND, REACHED};
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// The loop over the pieces of a motion.
pub(crate) struct Driver<'a> {
    base: Base,
    frames: Vec<Frame>,
    spans: Vec<Span>,
    zeno: Vec<ZenoRecord>,
    warnings: Vec<String>,
    log: Log<'a>,
    options: Options,
    state: Coordinates,
    /// For each held contact: speed and time of the last landing of the other in this frame.
    landings: [Option<(f64, Clock)>; 2],
    acceleration: Option<[f64; 3]>,
    /// Whether all rows are those of the nominal posture, in the whole run.
    local: bool,
    /// Rounds on the ground.
    rounds: Rounds,
    /// Whether the ground of the contacts can be meant.
    watch: GroundWatch,
    /// Contacts whose coming to rest has been noted, and that have not left since.
    resting: [bool; 2],
    /// Contacts that have no mode to go on in, or several.
    undecided: Option<Box<ContactProblem>>,
    /// The last event.
    cause: Option<Cause>,
    /// Whether nothing has happened yet.
    fresh: bool,
}

/// Gaps in a frozen geometry, and the impulses since its frame began.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrozenState {
    model: FrozenModel,
    gaps: Gaps,
    sum: Impulses,
}

/// The state of a run, in the coordinates in which it is computed.
#[derive(Debug, Clone, Copy)]
enum Coordinates {
    Frozen(FrozenState),
    Full(FullState),
}

/// Collisions under way. The flight has the state of the run while it lasts, and gives it back at its end.
pub(crate) enum Flight {
    Local(FrozenState, local::LocalCollisions),
    Full(FullState, full::FullCollisions),
}

impl FrozenState {
    fn at(&self, clock: Clock) -> Snapshot {
        Snapshot { clock, gaps: self.gaps, impulses: self.sum, ..Snapshot::default() }
    }
}

impl Frame {
    /// A snapshot of this frame, in its coordinates.
    fn coordinates(&self, base: &Base, raw: &Snapshot) -> Coordinates {
        match (&self.frozen, base.body) {
            (Some(model), _) => Coordinates::Frozen(FrozenState {
                model: *model,
                gaps: raw.gaps,
                sum: raw.impulses,
            }),
            (None, Some(body)) => {
                Coordinates::Full(FullState::new(body, raw.gaps, raw.center, raw.spin))
            }
            (None, None) => unreachable!("the full model has a body"),
        }
    }
}

/// What a flight does next.
pub(crate) enum Resume {
    /// A collision of any kind.
    Any,
    /// Plain collisions, if they are.
    Plain,
    LoopExit(LoopExit),
}

impl Resume {
    /// As the loops of plain collisions say it.
    pub(crate) fn after(stop: Option<Option<LoopExit>>) -> Self {
        stop.map_or(Self::Plain, |halt| halt.map_or(Self::Any, Self::LoopExit))
    }
}

/// What a motion does next.
pub(crate) enum DriverStep {
    /// Another piece.
    Piece,
    /// Flight and collisions.
    Flight,
    End(Outcome),
}

impl<'a> Driver<'a> {
    pub(crate) fn new(
        first: Frame,
        base: Base,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let state = first.coordinates(&base, &first.start);
        let log = Log::new(options, base.count, cancel);
        Self {
            state,
            local: first.frozen.is_some(),
            undecided: None,
            cause: Some(Cause::Start),
            rounds: Rounds::default(),
            watch: GroundWatch::new(base.posture.as_ref()),
            resting: [false; 2],
            frames: vec![first],
            base,
            spans: Vec::new(),
            zeno: Vec::new(),
            warnings,
            log,
            options: *options,
            landings: [None; 2],
            acceleration: None,
            fresh: true,
        }
    }

    /// The state `dt` into a summed tail that begins at `raw`, in the coordinates of the full model; `None` if too many
    /// collisions come before. `options`: of the run.
    pub(crate) fn resimulate_tail(
        frame: &Frame,
        base: &Base,
        options: &Options,
        raw: &Snapshot,
        tail: Tail,
        dt: f64,
    ) -> Option<Snapshot> {
        let frozen = frame.frozen.as_ref()?;
        let mut near = *raw;
        let mut skip = |t: f64, gaps: Gaps, own: Impulses| {
            for i in 0..2 {
                near.impulses.path[i] += near.impulses.jump[i] * t + own.path[i];
                near.impulses.jump[i] += own.jump[i];
            }
            (near.gaps, near.clock) = (gaps, raw.clock.after(t));
            dt - t
        };
        let rest = match tail {
            Tail::Bounce { contact } => {
                let (t, gaps, own) = frozen.skip_bounces(contact, &raw.gaps, dt);
                let rest = skip(t, gaps, own).max(0.0);
                return Some(frame.to_full(&frame.smooth(base, &near, [false; 2], rest)));
            }
            Tail::Cycle { ratio, duration } => {
                let cycles = (libm::log1p(-dt / duration) / libm::log(ratio)).floor();
                let scale = libm::pow(ratio, cycles);
                let t = duration * (1.0 - scale);
                let rates = raw.gaps.u.map(|u| u * scale);
                let own = frozen.lead_to(rates, &raw.gaps, t);
                skip(t, Gaps { h: [0.0; 2], u: rates }, own).max(0.0)
            }
            Tail::Collisions => dt,
        };
        let options = options.of_resimulated_tail(rest);
        let never = || false;
        // A clock of its own: the tail may be shorter than the rounding of the time at which it begins.
        let mut own = frame.clone();
        own.start.clock = Clock::default().after(-near.clock.since(frame.start.clock));
        let mut driver = Driver::new(own, base.clone(), &options, Vec::new(), &never);
        driver.state = driver.frame().coordinates(&driver.base, &near);
        let outcome = driver.motion();
        let full = driver.frame().to_full(&driver.raw());
        let clock = raw.clock.after(dt);
        (outcome == Outcome::TimeLimit).then_some(Snapshot { clock, ..full })
    }

    /// Runs to the outcome; `None` if cancelled.
    pub(crate) fn run(mut self) -> Option<Box<Record>> {
        self.write([false; 2], Motion::Flight); // impacts of the first instant belong to a span, too
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
            impacts: Vec::new(),
            hits: self.log.hits,
            end,
            acceleration: self.acceleration,
            undecided: self.undecided,
        }))
    }

    /// The end of a motion; `None` if it was cancelled.
    fn arrive(&mut self, outcome: Outcome) -> Option<Moment> {
        if self.log.cancelled {
            return None;
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock = Clock { hi: self.log.end, lo: 0.0 };
        }
        if self.log.phase_lost {
            self.warnings.push(LOST_PHASE.into());
        } else if let Some(limit) = self.log.limit().filter(|_| outcome == Outcome::EventLimit) {
            self.warnings.push(format!("{limit}: {}", self.next_landing()));
        }
        let mut end = match self.zeno.last() {
            Some(zeno) if outcome == Outcome::Zeno => zeno.at.clone(),
            _ => self.moment(),
        };
        self.look_at(&end);
        self.warn_of_friction();
        if outcome == Outcome::Rest {
            end.state.qdot.fill(0.0);
        }
        Some(end)
    }

    /// Which contacts are on the ground, or which one lands next, and how fast, in words: by the gravity into the contacts as it is
    /// now.
    fn next_landing(&self) -> String {
        let (gaps, gravity) = (self.gaps(), self.model().g);
        let stays = |&i: &usize| gaps.h[i] == 0.0 && gaps.u[i] == 0.0;
        if (0..self.base.count).any(|i| stays(&i)) {
            return format!("with {} on the ground", names((0..self.base.count).filter(stays)));
        }
        let after = |i: usize| {
            if i < self.base.count {
                parabola_touchdown(gaps.h[i], gaps.u[i], gravity[i])
            } else {
                f64::INFINITY
            }
        };
        let first = usize::from(after(1) < after(0));
        if !after(first).is_finite() {
            return "no contact lands any more".into();
        }
        let (h, u) = (gaps.h[first], gaps.u[first]);
        let speed = (u * u + 2.0 * gravity[first] * h).max(0.0).sqrt();
        format!("{} lands next, at about {}", names(std::iter::once(first)), in_words(speed))
    }

    /// Looks whether the ground of the contacts can be meant. Plain collisions in turn are not looked at one by one.
    fn look(&mut self) {
        if self.watch.is_on() {
            self.look_from_here();
        }
    }

    #[inline(never)] // the collisions have the registers to themselves
    fn look_from_here(&mut self) {
        let Some(posture) = &self.base.posture else { return };
        let place = match &self.state {
            Coordinates::Full(state) => state.q(),
            Coordinates::Frozen(state) => {
                self.frame().place(&state.model, self.log.clock, state.sum.path)
            }
        };
        if !self.watch.is_near(posture, &place) {
            self.look_at(&self.moment());
        }
    }

    /// As `look`, at this state of the body.
    fn look_at(&mut self, now: &Moment) {
        let Self { watch, base, local, options, warnings, .. } = self;
        let Some(posture) = base.posture.as_ref().filter(|_| watch.is_on()) else { return };
        let touches = |i: usize| now.gaps[i] == 0.0;
        watch.look(posture, &now.state.q, *local, touches, || options.clock(now.clock), warnings);
    }

    /// The impacts of this loop are frictionless.
    fn warn_of_friction(&mut self) {
        let Some(posture) = &self.base.posture else { return };
        let mut contacts = posture.contacts().iter().zip(self.log.struck);
        if contacts.any(|(contact, struck)| struck && contact.friction > 0.0) {
            self.warnings.push(NO_FRICTION.into());
        }
    }

    fn frame(&self) -> &Frame {
        &self.frames[self.frames.len() - 1]
    }

    /// Whether the full model is frozen for the last moments of an accumulation.
    fn is_brief(&self) -> bool {
        !self.local && self.frame().frozen.is_some()
    }

    /// The state in the coordinates of the current frame.
    fn raw(&self) -> Snapshot {
        let clock = self.log.clock;
        match &self.state {
            Coordinates::Full(state) => Snapshot::of_full(state, clock),
            Coordinates::Frozen(state) => state.at(clock),
        }
    }

    /// From now on these contacts are held, and the body moves in this way.
    fn note(&mut self, held: [bool; 2], motion: impl FnOnce(InFrame) -> Motion) {
        let word = held.map(|held| if held { Mode::Fixed } else { Mode::Separate });
        self.log.enter(&word[..self.base.count]);
        self.write(held, motion);
    }

    /// Begins a span of the record.
    fn write(&mut self, held: [bool; 2], motion: impl FnOnce(InFrame) -> Motion) {
        if self.log.record {
            let motion = motion(InFrame { frame: self.frames.len() - 1, raw: self.raw() });
            // Without a body nothing is known of motion along the terrain: a held contact reads F.
            let letters =
                held[..self.base.count].iter().map(|held| if *held { b'F' } else { b'S' });
            self.spans.push(Span {
                clock: self.log.clock,
                motion,
                letters: letters.collect(),
                cause: self.cause,
                first_collision: self.log.collisions.len(),
            });
        }
    }

    /// The body now, as results give it.
    fn moment(&self) -> Moment {
        Moment::of_snapshot(&self.frame().to_full(&self.raw()), self.base.count)
    }

    /// The largest speed there can have been, roughly, in m/s.
    fn speed_scale(&self) -> f64 {
        let start = &self.base.start;
        let Some(posture) = &self.base.posture else { return 0.0 };
        libm::hypot(start.qdot.x, start.qdot.y)
            + posture.size() * start.qdot.z.abs()
            + posture.fields().gravity * self.log.clock.hi
    }

    /// The coupling of the contacts and the gravity into them at this moment.
    fn model(&self) -> FrozenModel {
        match &self.state {
            Coordinates::Full(state) => FrozenModel::new(&state.frozen()),
            Coordinates::Frozen(state) => state.model,
        }
    }

    fn gaps(&self) -> Gaps {
        match &self.state {
            Coordinates::Full(state) => state.gaps,
            Coordinates::Frozen(state) => state.gaps,
        }
    }

    fn set_gaps(&mut self, gaps: Gaps) {
        match &mut self.state {
            Coordinates::Full(state) => state.gaps = gaps,
            Coordinates::Frozen(state) => state.gaps = gaps,
        }
    }

    /// Piece after piece until an outcome.
    fn motion(&mut self) -> Outcome {
        loop {
            let end = match self.piece() {
                DriverStep::Piece => None,
                DriverStep::Flight => {
                    let halt = match self.begin_flight() {
                        Ok(mut flight) => self.fly(&mut flight, Resume::Any, &mut |_, _| false),
                        Err(halt) => Some(halt),
                    };
                    halt.and_then(|halt| self.land(halt))
                }
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
        if self.is_far() {
            return DriverStep::End(Outcome::Escape);
        }
        let fresh = std::mem::take(&mut self.fresh);
        let gaps = self.gaps();
        if gaps.h.contains(&0.0) {
            self.look();
        }
        let coming = [0, 1].map(|i| gaps.h[i] == 0.0 && gaps.u[i] < 0.0);
        if coming != [false, false] {
            return self.impact(coming).map_or(DriverStep::Piece, DriverStep::End);
        }
        // A body's contacts at rest are asked for more than gravity: their modes.
        let asked = fresh || self.base.body.is_none();
        let held = if asked { self.pressed(&gaps) } else { [false; 2] };
        if fresh && held != [false, false] && self.zeno_here(held, Method::Rest) {
            return DriverStep::End(Outcome::Zeno);
        }
        let rests = [0, 1].map(|i| gaps.h[i] == 0.0 && gaps.u[i] == 0.0);
        if fresh {
            self.resting = rests; // they have been: nothing brought them there
        }
        // One impact without rebound is all the accumulation there is.
        let stopped = [0, 1].map(|i| held[i] && !self.resting[i]);
        if stopped != [false, false] && self.zeno_here(stopped, Method::Bounce) {
            return DriverStep::End(Outcome::Zeno);
        }
        match held {
            _ if self.base.body.is_some() && rests != [false, false] => self.contact_phase(rests),
            [false, false] => DriverStep::Flight,
            [true, true] => DriverStep::End(self.stay(held)),
            _ => self.hold(held).map_or(DriverStep::Piece, DriverStep::End),
        }
    }

    fn is_far(&self) -> bool {
        let limit = self.options.neighbourhood.min(BEYOND);
        // Nobody comes that far in the age of the universe.
        let may = self.options.neighbourhood.is_finite() || self.log.clock.hi > EARLY;
        may && self.base.body.is_some() && {
            let q = Base::state(&self.frame().to_full(&self.raw())).q;
            libm::hypot(q.x, q.y) > limit
        }
    }

    /// Which resting contacts gravity presses into the terrain: 0 ≤ λ ⊥ acceleration ≥ 0.
    fn pressed(&self, gaps: &Gaps) -> [bool; 2] {
        let model = self.model();
        let rests = [0, 1].map(|i| gaps.h[i] == 0.0 && gaps.u[i] == 0.0);
        match rests {
            [true, true] => {
                let force = model.share(model.g);
                if force[0] > 0.0 && force[1] >= 0.0 || force[0] >= 0.0 && force[1] > 0.0 {
                    [true, true]
                } else {
                    [0, 1].map(|i| {
                        let other = -model.g[1 - i] - model.psi[i] * model.g[i];
                        model.g[i] > 0.0 && other >= 0.0
                    })
                }
            }
            _ => [0, 1].map(|i| rests[i] && model.g[i] > 0.0),
        }
    }

    /// Contacts with zero gap approach: the impacts of this instant.
    fn impact(&mut self, coming: [bool; 2]) -> Option<Outcome> {
        let model = self.model();
        let gaps = self.gaps();
        let mut rates = gaps.u;
        let mut hits: Vec<Hit> = Vec::new();
        let both_touch = gaps.h == [0.0, 0.0];
        let mut end = Sequence::Finite;
        let (mut together, mut in_step) = (false, false);
        if coming == [true, true] {
            self.warn_of_tie();
            together = self.options.policy() == Simultaneous::Newton;
        }
        let first = match (coming, self.options.policy()) {
            ([true, true], Simultaneous::LastContactFirst) | ([false, true], _) => 1,
            _ => 0,
        };
        let (mut jump, mut count) = ([0.0; 2], 0);
        if together {
            (jump, in_step) = newton::newton_together(&model, rates);
            let mut after = newton::kicked(&model, rates, jump);
            if in_step {
                after = [0, 1].map(|i| -model.e[i] * rates[i]); // the law itself, not its rounding
            }
            for contact in (0..2).filter(|&i| jump[i] > 0.0) {
                hits.push(Hit { contact, before: rates, after });
            }
            rates = after;
        } else if both_touch {
            end = newton::in_zero_time(&model, first, &mut rates, |hit| {
                count += 1;
                jump[hit.contact] += hit.after[hit.contact] - hit.before[hit.contact];
                if hits.len() < LISTED {
                    hits.push(*hit);
                }
            });
            // One impact on each may leave no speed: without restitution and without coupling.
            if end == Sequence::Infinite || count > 2 && rates == [0.0; 2] {
                end = Sequence::Infinite; // or so long that its speeds are below any double
                jump = model.share([-gaps.u[0], -gaps.u[1]]);
                rates = [0.0; 2];
                hits.clear();
            } else if count > 1 {
                // The jumps of many impacts cancel; what they leave says what they come to.
                jump = model.share([0, 1].map(|i| rates[i] - gaps.u[i]));
            }
        } else {
            rates = newton::newton(&model, first, rates);
            jump[first] = rates[first] - gaps.u[first];
            hits.push(Hit { contact: first, before: gaps.u, after: rates });
        }
        for hit in &hits {
            self.log.struck[hit.contact] = true;
        }
        if end == Sequence::Infinite {
            self.log.struck = [true; 2];
            // Both gaps are zero and stay so.
            self.kick(jump, rates);
            self.landings = [None; 2];
            let certified = model.chatters();
            return self
                .zeno_point([true, true], Method::Chatter, certified, 0.0)
                .then_some(Outcome::Zeno);
        }
        let before = gaps;
        let mut turns = self.turns();
        self.kick(jump, rates);
        turns |= self.turns();
        if count > 1
            && let Coordinates::Full(state) = &mut self.state
        {
            state.follow([true, true]);
        }
        self.log.hits += count.max(hits.len());
        let last = hits.last().map_or(first, |hit| hit.contact);
        self.cause = Some(Cause::Impact(ContactNumber::of(last)));
        for hit in &hits {
            if self.log.record {
                self.log.collisions.push(Collision {
                    elapsed: self.log.clock,
                    contact: hit.contact,
                    before: hit.before,
                    after: hit.after,
                    jump: if together {
                        jump[hit.contact]
                    } else {
                        hit.after[hit.contact] - hit.before[hit.contact]
                    },
                    other_gap: before.h[1 - hit.contact],
                });
            }
        }
        self.align_bodies();
        self.note([false; 2], Motion::Flight);
        if in_step && let Some(t) = self.bounce_together(rates, turns) {
            let tail = Tail::Cycle { ratio: self.model().e[0], duration: t };
            return self.settle(t, Method::Bounce, true, 0.0, tail);
        }
        // Ties without end, one after the other, until what is left of them is below the rounding of the clock.
        if together && both_touch && model.g[0] > 0.0 && model.g[1] > 0.0 {
            let left = [0, 1].map(|i| model.bounce[i] * rates[i]);
            let left = 0.5 * left[0].max(left[1]);
            if 0.0 < left && left <= 0.5 * REACHED * self.log.clock.hi {
                return self.settle(left, Method::Mixed, false, left, Tail::Collisions);
            }
        }
        self.freeze_if_brief();
        None
    }

    /// Own-rate jumps act; the rates they lead to are given exactly.
    fn kick(&mut self, jump: [f64; 2], rates: [f64; 2]) {
        match &mut self.state {
            Coordinates::Full(state) => {
                state.kick(jump);
                state.gaps.u = rates;
                state.forget_rounding();
            }
            Coordinates::Frozen(state) => {
                state.gaps.u = rates;
                state.sum.jump[0] += jump[0];
                state.sum.jump[1] += jump[1];
            }
        }
    }

    /// One body beside each collision, except in the local model, where none is asked for.
    fn align_bodies(&mut self) {
        let body = match &self.state {
            Coordinates::Full(state) => (state.center, state.spin),
            Coordinates::Frozen(_) if self.local => return,
            Coordinates::Frozen(_) => Default::default(),
        };
        self.log.bodies.resize(self.log.collisions.len(), body);
    }

    fn warn_of_tie(&mut self) {
        const TIE: &str = "contacts 1 and 2 collided at the same instant; the outcome depends on \
                           the policy `simultaneous`";
        if !self.warnings.iter().any(|warning| warning == TIE) {
            self.warnings.push(TIE.into());
        }
    }

    /// Whether the geometry changes with time.
    fn turns(&self) -> bool {
        matches!(&self.state, Coordinates::Full(state) if state.spin.omega != 0.0)
    }

    /// Two contacts that bounce in step do so for ever: T = 2u/(g(1−e)) for both. `turns`: the body did before the impact or does
    /// after it, so that they keep step only if what is left is short.
    fn bounce_together(&self, rates: [f64; 2], turns: bool) -> Option<f64> {
        let model = self.model();
        let flight = [0, 1].map(|i| 2.0 * rates[i] / model.g[i]);
        let in_step = flight[0] > 0.0 && flight[0] < f64::INFINITY && are_one(flight[0], flight[1]);
        let t = model.bounce[0] * rates[0];
        if !in_step
            || model.e[0] != model.e[1]
            || !(self.log.clock.hi + t <= self.log.end)
            || turns
                && matches!(&self.state, Coordinates::Full(state) if !state.keeps_step(t, &self.log))
        {
            return None;
        }
        Some(t)
    }

    /// Both contacts come to rest after `t`: the limit of an accumulation.
    fn settle(
        &mut self,
        t: f64,
        method: Method,
        certified: bool,
        error: f64,
        tail: Tail,
    ) -> Option<Outcome> {
        let raw = self.raw();
        let model = self.model();
        let impulses = model.settle(&raw.gaps, t);
        self.tail(&model, t, impulses, Gaps::default(), [true, true], tail);
        self.zeno_point([true, true], method, certified, error).then_some(Outcome::Zeno)
    }

    /// Jumps over a tail of duration `t` with these own-rate impulses and the state at its end, where these
    /// contacts have come to rest. `model`: the geometry at its start.
    fn tail(
        &mut self,
        model: &FrozenModel,
        t: f64,
        own: Impulses,
        end: Gaps,
        closed: [bool; 2],
        tail: Tail,
    ) {
        // A tail of the full model is evaluated in the geometry frozen at its start.
        if let Coordinates::Full(state) = self.state {
            let start = Snapshot::of_full(&state, self.log.clock);
            let frame = Frame::with(start, &state, *model);
            let clock = self.log.clock.after(t);
            if self.log.record {
                self.frames.push(frame.clone());
                self.spans.push(Span {
                    clock: start.clock,
                    motion: Motion::Tail(
                        InFrame { frame: self.frames.len() - 1, raw: start },
                        tail,
                    ),
                    letters: PerContact::from_elem(b'S', self.base.count),
                    cause: self.cause,
                    first_collision: self.log.collisions.len(),
                });
            }
            let raw = Snapshot { clock, gaps: end, impulses: own, ..Snapshot::default() };
            let full = frame.to_full(&raw);
            self.log.clock = clock;
            let mut after = FullState::new(state.body, full.gaps, full.center, full.spin);
            after.turn_tail(
                &state,
                t,
                frame.translational(own.jump),
                frame.translational(own.path),
            );
            after.follow(closed);
            if let Tail::Bounce { contact } = tail {
                // The other one, out of reach, moves as the body does: its rate in the frozen geometry misses that.
                let (i, k) = (1 - contact, &after.body.contacts[1 - contact]);
                if after.gaps.h[i].is_finite() {
                    after.gaps.u[i] = k.normal.dot(&after.center.v) + after.b[i] * after.spin.omega;
                }
            }
            let full = Snapshot::of_full(&after, clock);
            self.state = Coordinates::Full(after);
            if self.log.record {
                self.frames.push(Frame::full(full));
            }
        } else {
            self.note([false; 2], |at| Motion::Tail(at, tail));
            if let Coordinates::Frozen(state) = &mut self.state {
                for i in 0..2 {
                    state.sum.path[i] += state.sum.jump[i] * t + own.path[i];
                    state.sum.jump[i] += own.jump[i];
                }
                state.gaps = end;
            }
            self.log.clock = self.log.clock.after(t);
        }
    }

    /// A Zeno point at this instant that needed no sum.
    fn zeno_here(&mut self, closed: [bool; 2], method: Method) -> bool {
        self.zeno_point(closed, method, true, 0.0)
    }

    /// Notes the Zeno point at this instant; true if the run ends here.
    fn zeno_point(
        &mut self,
        closed: [bool; 2],
        method: Method,
        certified: bool,
        error: f64,
    ) -> bool {
        let e = self.model().e;
        let stops = (0..2).all(|i| !closed[i] || e[i] == 0.0);
        for i in (0..2).filter(|&i| closed[i]) {
            self.resting[i] = true;
        }
        if method != Method::Rest {
            self.cause = Some(Cause::Zeno);
        }
        self.zeno.push(ZenoRecord {
            closed: closed[..self.base.count].into(),
            method,
            certified,
            plastic: method == Method::Bounce && stops,
            error,
            first_summed: self.log.hits,
            at: self.moment(),
        });
        self.options.stop == Stop::Zeno
    }

    /// Freezes the full model's geometry if what remains is too short to change it.
    fn freeze_if_brief(&mut self) {
        if let Coordinates::Full(state) = self.state
            && state.may_freeze(&self.log)
        {
            self.freeze(&state);
        }
    }

    fn freeze(&mut self, state: &FullState) {
        self.begin_frame(Frame::frozen(Snapshot::of_full(state, self.log.clock), state));
        self.landings = [None; 2];
    }

    /// Back to the full model.
    fn thaw(&mut self) {
        if self.is_brief() {
            self.begin_frame(Frame::full(self.frame().to_full(&self.raw())));
        }
    }

    /// From now on the motion is computed in this frame.
    fn begin_frame(&mut self, frame: Frame) {
        let raw = Snapshot { impulses: Impulses::default(), ..frame.start };
        self.state = frame.coordinates(&self.base, &raw);
        self.frames.push(frame);
    }

    /// The first collision of a flight; an error: something else came before.
    pub(crate) fn begin_flight(&mut self) -> Result<Flight, LoopExit> {
        self.note([false; 2], Motion::Flight);
        let state = match &mut self.state {
            Coordinates::Full(state) => {
                let collisions = full::FullCollisions::begin(&state.body, &mut self.log);
                return Ok(Flight::Full(*state, collisions));
            }
            Coordinates::Frozen(state) => state,
        };
        let FrozenState { model, gaps, sum } = state;
        let collisions = local::LocalCollisions::begin(model, gaps, sum, &mut self.log)?;
        let flight = Flight::Local(*state, collisions);
        self.look();
        Ok(flight)
    }

    /// Flies and collides until something other than a simple collision happens, or until a lane takes the body: `None`.
    #[inline(never)] // the collisions have the registers to themselves
    pub(crate) fn fly(
        &mut self,
        flight: &mut Flight,
        mut then: Resume,
        enter: &mut impl FnMut(&Self, &Flight) -> bool,
    ) -> Option<LoopExit> {
        let halt = loop {
            match then {
                Resume::Plain => {}
                Resume::Any => {
                    let halt = self.next_collision(flight);
                    if let Flight::Full(state, _) = flight
                        && self.watch.is_on()
                    {
                        self.state = Coordinates::Full(*state);
                        self.look();
                    }
                    if let Some(halt) = halt {
                        break halt;
                    }
                }
                Resume::LoopExit(halt) => break halt,
            }
            let stop = match self.come_to_first(flight) {
                None if enter(self, flight) => return None,
                None => self.alternate(flight),
                stop => stop,
            };
            then = Resume::after(stop);
        };
        Some(self.end_flight(flight, halt))
    }

    /// The next collision, whatever it is.
    fn next_collision(&mut self, flight: &mut Flight) -> Option<LoopExit> {
        match flight {
            Flight::Local(state, collisions) => collisions.next(&state.model, &mut self.log),
            Flight::Full(state, collisions) => collisions.next(state, &mut self.log),
        }
    }

    /// Plain collisions up to one at contact 1; `None`: from there on they come in turn, else an end or none.
    fn come_to_first(&mut self, flight: &mut Flight) -> Option<Option<LoopExit>> {
        match flight {
            Flight::Full(state, collisions) => {
                let hits = self.log.hits;
                let stop = collisions.come_to_first(state, &mut self.log);
                self.log.struck[0] |= self.log.hits > hits;
                stop
            }
            Flight::Local(_, collisions) => (!collisions.is_at_first()).then_some(None),
        }
    }

    /// Plain collisions after that; `None`: many, and nothing else.
    fn alternate(&mut self, flight: &mut Flight) -> Option<Option<LoopExit>> {
        match flight {
            Flight::Full(state, collisions) => {
                let hits = self.log.hits;
                let stop = collisions.alternate(MANY, state, &mut self.log);
                self.log.struck[1] |= self.log.hits > hits; // the first of them
                stop
            }
            Flight::Local(_, collisions) => {
                collisions.alternate(&mut self.log);
                Some(None)
            }
        }
    }

    fn end_flight(&mut self, flight: &mut Flight, halt: LoopExit) -> LoopExit {
        match flight {
            Flight::Full(state, collisions) => {
                let halt = collisions.end(halt, state, &mut self.log);
                self.state = Coordinates::Full(*state);
                halt
            }
            Flight::Local(state, collisions) => {
                let FrozenState { model, gaps, sum } = state;
                let halt = collisions.end(halt, model, gaps, sum, &mut self.log);
                self.state = Coordinates::Frozen(*state);
                halt
            }
        }
    }

    /// As [`full::FullCollisions::enter`].
    pub(crate) fn enter(
        &self,
        (state, collisions): (&FullState, &full::FullCollisions),
        pool: &mut full::Pool,
        run: usize,
    ) -> bool {
        collisions.enter(state, &self.log, pool, run)
    }

    /// As [`full::FullCollisions::leave`].
    pub(crate) fn leave_lane(
        &mut self,
        (state, collisions): (&mut FullState, &mut full::FullCollisions),
        pool: &mut full::Pool,
        run: usize,
    ) -> Option<Option<LoopExit>> {
        let hits = self.log.hits;
        let stop = collisions.leave(&pool.take(run), state, &mut self.log);
        self.log.struck[1] |= self.log.hits > hits; // the first of them
        stop
    }

    /// The end of a run that recorded nothing; `None` if it was cancelled.
    pub(crate) fn finish(&mut self, outcome: Outcome) -> Option<End> {
        let end = self.arrive(outcome)?;
        let time = |clock: Clock| self.options.clock(clock);
        let zeno = self.zeno.first().map(|zeno| FirstZeno {
            count: zeno.closed.iter().filter(|closed| **closed).count(),
            contact: match zeno.closed[..] {
                [true, false] | [true] => Some(ContactNumber::of(0)),
                [false, true] => Some(ContactNumber::of(1)),
                _ => None,
            },
            time: time(zeno.at.clock),
            elapsed: zeno.at.clock.hi,
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

    /// What a flight and its collisions have come to.
    pub(crate) fn land(&mut self, halt: LoopExit) -> Option<Outcome> {
        self.align_bodies();
        match halt {
            LoopExit::Bounce { contact, duration } => {
                let model = self.model();
                let (end, own) = model.end_bounce(contact, &self.gaps(), duration);
                let closed = [contact == 0, contact == 1];
                self.tail(&model, duration, own, end, closed, Tail::Bounce { contact });
                self.zeno_point(closed, Method::Bounce, true, 0.0).then_some(Outcome::Zeno)
            }
            LoopExit::Clatter(tail) => self.settle(
                tail.duration,
                Method::Clatter,
                tail.proved,
                tail.error,
                Tail::Collisions,
            ),
            LoopExit::Reached { remaining, self_similar } => {
                let method = if self_similar { Method::SelfSimilar } else { Method::Mixed };
                // The bound is crude, but below the rounding of the time.
                self.settle(0.5 * remaining, method, false, 0.5 * remaining, Tail::Collisions)
            }
            LoopExit::Freeze => {
                if let Coordinates::Full(state) = self.state {
                    self.freeze(&state);
                }
                None
            }
            LoopExit::Tie => None,
            LoopExit::TimeLimit => Some(Outcome::TimeLimit),
            LoopExit::EventLimit => Some(Outcome::EventLimit),
            LoopExit::Never => Some(self.never(Outcome::Escape)),
        }
    }

    /// Nothing ends this motion any more.
    fn never(&mut self, outcome: Outcome) -> Outcome {
        if self.log.end == f64::INFINITY {
            return outcome;
        }
        let left = self.log.left().max(0.0);
        let held = match self.spans.last() {
            Some(Span { motion: Motion::Held(_, held), .. }) => *held,
            _ => [false, false],
        };
        self.move_smoothly(held, left);
        Outcome::TimeLimit
    }

    fn move_smoothly(&mut self, held: [bool; 2], dt: f64) {
        let after = self.frame().smooth(&self.base, &self.raw(), held, dt);
        self.log.clock = after.clock;
        self.state = self.frame().coordinates(&self.base, &after);
    }

    /// One contact is held, the other is in the air, until it lands or the held one lifts off.
    fn hold(&mut self, held: [bool; 2]) -> Option<Outcome> {
        self.note(held, |at| Motion::Held(at, held));
        let (a, b) = if held[0] { (0, 1) } else { (1, 0) };
        let model = self.model();
        let gaps = self.gaps();
        let gravity = model.held_gravity(b);
        let resting = gaps.h[b] == 0.0 && gaps.u[b] == 0.0;
        let t =
            if resting { f64::INFINITY } else { parabola_touchdown(gaps.h[b], gaps.u[b], gravity) };
        if self.log.clock.hi + t > self.log.end {
            let left = self.log.left().max(0.0);
            self.move_smoothly(held, left);
            return Some(Outcome::TimeLimit);
        }
        if t == f64::INFINITY {
            return Some(Outcome::Escape);
        }
        self.move_smoothly(held, t);
        let speed = (gaps.u[b] * gaps.u[b] + 2.0 * gravity * gaps.h[b]).max(0.0).sqrt();
        let mut landed = Gaps::default();
        landed.u[b] = -speed;
        self.set_gaps(landed);
        self.nested(a, speed)
    }

    /// A landing while `a` is held: everything after it is determined by its speed, up to scale. If the
    /// same landing came before at a higher speed, the motion in between repeats on a smaller and smaller
    /// scale, with all times and speeds multiplied by `ratio`: a Zeno point of Zeno points.
    fn nested(&mut self, a: usize, speed: f64) -> Option<Outcome> {
        let now = self.log.clock;
        let last = self.landings[a].replace((speed, now));
        let (before, then) = last?;
        let ratio = speed / before;
        if !(ratio < 1.0) {
            return None;
        }
        let t = now.since(then) * ratio / (1.0 - ratio);
        if !(now.hi + t <= self.log.end) {
            return None;
        }
        // Rounding of the ratio is amplified by the sum.
        let error = ROUNDINGS * f64::EPSILON * t / (1.0 - ratio);
        self.settle(t, Method::Nested, true, error, Tail::Cycle { ratio, duration: t })
    }

    /// Both contacts are held, and nothing is known of any motion along the terrain: at rest.
    fn stay(&mut self, held: [bool; 2]) -> Outcome {
        self.note(held, |at| Motion::Held(at, held));
        if self.options.stop != Stop::Time {
            return Outcome::Rest;
        }
        let left = self.log.left().max(0.0);
        self.move_smoothly(held, left);
        Outcome::TimeLimit
    }
}

/// Pairs of plain collisions after which a run that goes on by itself is looked at again.
const MANY: usize = 8;
/// Time, in s, before which no body is looked for beyond all bounds.
const EARLY: f64 = 1e18;
/// Impacts of one instant that are listed one by one.
const LISTED: usize = 64;
