//! One or two contacts with frictionless impacts on lines without ends, in gaps and impulses: with nominal geometry, with geometry
//! frozen for the last moments of an accumulation, or with finite rotation.

use nalgebra::Vector3;

use crate::body::contact::{ContactLetters, ContactValues, PerContact};
use crate::collisions::full::FullState;
use crate::collisions::local::are_one;
use crate::collisions::log::Collision;
use crate::impact::friction::NO_FRICTION;
use crate::impact::newton;
use crate::impact::newton::{Hit, SequenceEnd};
use crate::math::clock::Clock;
use crate::modes::Mode;
use crate::motion::bounces::{Bounces, Settled};
use crate::motion::driver::{Coordinates, Driver, DriverStep, Planar};
use crate::motion::frame::{Frame, Snapshot};
use crate::motion::nested::Limit;
use crate::motion::pair_flight::next_landing;
use crate::motion::record::{InFrame, Moment, Motion, Tail, ZenoRecord};
use crate::motion::subject::Subject;
use crate::options::{Options, Simultaneous};
use crate::outcome::{Cause, ContactNumber, Outcome, ZenoMethod};
use crate::sustained::BodyState;
use crate::tolerance::{DEPARTED, DEPARTS_AFTER, REACHED, STILL};
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// Gaps in a frozen geometry, and the impulses since its frame began.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrozenState {
    pub(super) model: FrozenModel,
    pub(super) gaps: Gaps,
    pub(super) sum: Impulses,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum PairState {
    Frozen(FrozenState),
    Full(FullState),
}

/// The coordinates of a body with two contacts at most.
pub(crate) struct Pair {
    pub(super) count: usize,
    pub(super) state: PairState,
    /// The equations that the state belongs to.
    pub(super) frame: Frame,
    /// The limit of the bounces in progress.
    pub(super) settled: Option<Box<Settled>>,
    pub(super) bounces: Bounces,
}

impl Pair {
    pub(super) fn gaps(&self) -> Gaps {
        match &self.state {
            PairState::Full(state) => state.gaps,
            PairState::Frozen(state) => state.gaps,
        }
    }
}

impl FrozenState {
    fn at(&self, clock: Clock) -> Snapshot {
        Snapshot { clock, gaps: self.gaps, impulses: self.sum, ..Snapshot::default() }
    }
}

impl Frame {
    /// The state of a run from a snapshot of this frame.
    pub(super) fn state(&self, subject: &Subject, raw: &Snapshot) -> PairState {
        match (&self.frozen, subject.pair()) {
            (Some(model), _) => {
                PairState::Frozen(FrozenState { model: *model, gaps: raw.gaps, sum: raw.impulses })
            }
            (None, Some(body)) => {
                PairState::Full(FullState::new(*body, raw.gaps, raw.center, raw.spin))
            }
            (None, None) => unreachable!("the full model has a body"),
        }
    }
}

impl Coordinates for Pair {
    fn begin(driver: &mut Driver<'_, Self>) -> Option<Outcome> {
        if driver.log.record {
            driver.record.frames.push(driver.body.frame.clone());
        }
        driver.begin_span(Motion::Flight); // impacts of the first instant need a span
        None
    }

    fn count(&self) -> usize {
        self.count
    }

    fn point(&self, i: usize) -> (f64, f64) {
        let Gaps { h, u } = self.gaps();
        (h[i], u[i])
    }

    fn has_left(driver: &mut Driver<'_, Self>) -> bool {
        let limit = driver.options.neighbourhood.min(DEPARTED);
        // Without a neighbourhood this takes longer than the age of the universe.
        let may = driver.options.neighbourhood.is_finite() || driver.log.clock.hi > DEPARTS_AFTER;
        may && {
            let q = driver.full().state().q;
            libm::hypot(q.x, q.y) > limit
        }
    }

    fn moment(driver: &Driver<'_, Self>) -> Moment {
        Moment::of_snapshot(&driver.full(), driver.body.count)
    }

    fn watch_ground(driver: &mut Driver<'_, Self>) {
        if driver.watch.is_on() {
            driver.watch_from_here();
        }
    }

    fn largest_speed(driver: &Driver<'_, Self>) -> f64 {
        let start = &driver.record.subject.start();
        let Some(posture) = driver.record.subject.posture() else { return 0.0 };
        libm::hypot(start.qdot.x, start.qdot.y)
            + posture.size() * start.qdot.z.abs()
            + posture.fields().gravity * driver.log.clock.hi
    }

    fn sliding_tolerance(driver: &Driver<'_, Self>) -> f64 {
        STILL * Self::largest_speed(driver)
    }

    fn impact(driver: &mut Driver<'_, Self>, coming: &[usize]) -> Option<Outcome> {
        driver.impact([0, 1].map(|i| coming.contains(&i)))
    }

    fn fly(driver: &mut Driver<'_, Self>) -> Option<Outcome> {
        let exit = match driver.begin_flight() {
            Ok(mut flight) => driver.collide(&mut flight),
            Err(exit) => exit,
        };
        driver.land(exit)
    }

    fn rest(driver: &mut Driver<'_, Self>, rests: ContactValues<bool>, fresh: bool) -> DriverStep {
        if fresh {
            let gaps = driver.body.gaps();
            let resting = [0, 1].map(|i| gaps.h[i] == 0.0 && gaps.u[i] == 0.0);
            let held = driver.model().pressed(resting);
            if held != [false; 2]
                && let Some(outcome) = driver.zeno_here(held, ZenoMethod::Rest)
            {
                return DriverStep::End(outcome);
            }
            driver.resting.clone_from(&rests); // at rest from the start: no event
        }
        driver.contact_phase(rests, fresh)
    }

    fn last_impacts(driver: &Driver<'_, Self>) -> String {
        next_landing(driver.body.count, &driver.body.gaps(), driver.model().g)
    }

    /// Impacts in these coordinates are frictionless.
    fn last_warnings(driver: &mut Driver<'_, Self>) {
        let Some(posture) = driver.record.subject.posture() else { return };
        let mut contacts = posture.contacts().iter().zip(driver.log.struck);
        if contacts.any(|(contact, struck)| struck && contact.friction > 0.0) {
            driver.record.warnings.push(NO_FRICTION.into());
        }
    }
}

impl Planar for Pair {
    fn enter_contact(driver: &mut Driver<'_, Self>, rests: &[bool]) -> Result<BodyState, Outcome> {
        let was_frozen = driver.is_brief();
        driver.unfreeze();
        let full = driver.full();
        let all = (0..driver.body.count).all(|i| rests[i] && driver.resting[i]);
        if all && let Some(modes) = driver.stands(&full) {
            return Err(driver.rest_in(modes, full));
        }
        let body = driver.record.subject.body_state(&full);
        let mut body = body.unwrap_or_else(|| unreachable!("contact phases belong to a body"));
        if was_frozen {
            body.unfreeze();
        }
        Ok(body)
    }

    fn come_to_rest(
        driver: &mut Driver<'_, Self>,
        _: &BodyState,
        rests: &[bool],
        _: bool,
    ) -> Option<Outcome> {
        // Rates can also underflow to zero, impact by impact. A contact with upward effective gravity has not come to rest.
        let pulled = |i: usize| !matches!(&driver.body.state, PairState::Full(state) if state.effective_gravity(i) < 0.0);
        let new = driver.not_yet([0, 1].map(|i| i < rests.len() && rests[i] && pulled(i)));
        if new == [false; 2] { None } else { driver.zeno_here(new, ZenoMethod::Bounce) }
    }

    fn leave_contact(driver: &mut Driver<'_, Self>, body: BodyState) {
        driver.leave(&body);
    }

    fn stop_slowly(
        driver: &mut Driver<'_, Self>,
        b: usize,
        body: &BodyState,
    ) -> Option<DriverStep> {
        driver.stop_slowly(b, body).map(DriverStep::from)
    }

    fn sum_cycles(
        driver: &mut Driver<'_, Self>,
        before: BodyState,
        limit: Limit,
    ) -> Option<Outcome> {
        driver.sum_cycles(&before, &limit)
    }
}

impl<'a> Driver<'a, Pair> {
    pub(crate) fn new(
        first: Frame,
        subject: Subject,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        let state = first.state(&subject, &first.start);
        let body = Pair {
            count: subject.count(),
            state,
            frame: first,
            settled: None,
            bounces: Bounces::default(),
        };
        Self::with(body, subject, false, options, warnings, cancel)
    }

    /// The state at time `dt` of a summed tail that begins at `raw`, in the coordinates of the full model, and the modes of the
    /// contacts; `None` if too many collisions come before. `options`: of the run.
    pub(crate) fn resimulate_tail(
        frame: &Frame,
        subject: &Subject,
        options: &Options,
        raw: &Snapshot,
        tail: Tail,
        dt: f64,
    ) -> Option<(Snapshot, ContactLetters<Mode>)> {
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
                let full = frame.to_full(subject, &frame.flown(subject, &near, rest));
                return Some((full, ContactLetters::from_elem(Mode::Separate, subject.count())));
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
        // The replay has its own clock: the tail may be shorter than the rounding error of the time at which it begins.
        let mut own = frame.clone();
        own.start.clock = Clock::default().after(-near.clock.since(frame.start.clock));
        let mut driver = Driver::<Pair>::new(own, subject.clone(), &options, Vec::new(), &never);
        driver.body.state = driver.body.frame.state(&driver.record.subject, &near);
        let driver = driver.run_tail()?;
        let full = Snapshot { clock: raw.clock.after(dt), ..driver.full() };
        Some((full, driver.log.word))
    }

    /// Begins a flight, or a sum of impacts.
    pub(super) fn note(&mut self, motion: impl FnOnce(InFrame) -> Motion) {
        self.log.enter(&[Mode::Separate; 2][..self.body.count]);
        self.begin_span(motion);
    }

    /// Begins a span of the record, in the frame that was recorded last.
    fn begin_span(&mut self, motion: impl FnOnce(InFrame) -> Motion) {
        if self.log.record {
            let motion = motion(InFrame { frame: self.record.frames.len() - 1, raw: self.raw() });
            self.write(motion);
        }
    }

    /// Sets and records the frame; the state is not changed.
    fn set_frame(&mut self, frame: Frame) {
        if self.log.record {
            self.record.frames.push(frame.clone());
        }
        self.body.frame = frame;
    }

    /// Checks the ground at the current state.
    #[inline(never)] // keeps the registers free for the collisions
    fn watch_from_here(&mut self) {
        let now = Pair::moment(self);
        if self.has_moved(&now.state.q) {
            self.watch_moment(&now);
        }
    }

    /// As `watch_from_here`, at this state of a flight.
    #[inline(never)]
    pub(super) fn watch_flight(&mut self, state: &FullState) {
        if self.has_moved(&state.q()) {
            self.body.state = PairState::Full(*state);
            self.watch_moment(&Pair::moment(self));
        }
    }

    /// Whether the body at this q is so far from the last check of the ground that another one is needed.
    fn has_moved(&self, q: &Vector3<f64>) -> bool {
        let posture = self.record.subject.posture();
        posture.is_some_and(|posture| !self.watch.is_near(posture, q))
    }

    /// The state in the coordinates of the full model.
    pub(super) fn full(&self) -> Snapshot {
        self.body.frame.to_full(&self.record.subject, &self.raw())
    }

    /// Whether the full model is frozen for the last moments of an accumulation.
    fn is_brief(&self) -> bool {
        self.body.frame.frozen.is_some()
    }

    /// The state in the coordinates of the current frame.
    pub(super) fn raw(&self) -> Snapshot {
        let clock = self.log.clock;
        match &self.body.state {
            PairState::Full(state) => Snapshot::of_full(state, clock),
            PairState::Frozen(state) => state.at(clock),
        }
    }

    /// The coupling of the contacts and the gravity into them in the current geometry.
    pub(super) fn model(&self) -> FrozenModel {
        match &self.body.state {
            PairState::Full(state) => FrozenModel::new(&state.frozen()),
            PairState::Frozen(state) => state.model,
        }
    }

    /// Applies the impacts of this instant.
    fn impact(&mut self, coming: [bool; 2]) -> Option<Outcome> {
        let model = self.model();
        let gaps = self.body.gaps();
        let mut rates = gaps.u;
        let mut hits: Vec<Hit> = Vec::new();
        let both_touch = gaps.h == [0.0, 0.0];
        let mut end = SequenceEnd::Finite;
        let (mut together, mut in_step) = (false, false);
        if coming == [true, true] {
            self.warn_of_tie();
            together = self.options.policy() == Simultaneous::Together;
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
                after = [0, 1].map(|i| -model.e[i] * rates[i]); // exact by the law, without rounding error
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
            // One impact on each contact may also leave zero rates: without restitution and without coupling.
            if end == SequenceEnd::Infinite || count > 2 && rates == [0.0; 2] {
                end = SequenceEnd::Infinite; // or so many impacts that the speeds underflow
                jump = model.solve_coupled([-gaps.u[0], -gaps.u[1]]);
                rates = [0.0; 2];
                hits.clear();
            } else if count > 1 {
                // The jumps of many impacts cancel: their sum is computed from the rates at the end.
                jump = model.solve_coupled([0, 1].map(|i| rates[i] - gaps.u[i]));
            }
        } else {
            rates = newton::newton(&model, first, rates);
            jump[first] = rates[first] - gaps.u[first];
            hits.push(Hit { contact: first, before: gaps.u, after: rates });
        }
        for hit in &hits {
            self.log.struck[hit.contact] = true;
        }
        if end == SequenceEnd::Infinite {
            self.log.struck = [true; 2];
            // Both gaps are zero and stay zero.
            self.apply_impulses(jump, rates);
            let certified = model.chatters();
            return self.come_to_rest([true, true], ZenoMethod::Chatter, certified, 0.0);
        }
        let before = gaps;
        let mut turns = self.turns();
        self.apply_impulses(jump, rates);
        turns |= self.turns();
        if count > 1
            && let PairState::Full(state) = &mut self.body.state
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
        self.note(Motion::Flight);
        if in_step && let Some(t) = self.bounce_together(rates, turns) {
            let tail = Tail::Cycle { ratio: self.model().e[0], duration: t };
            return self.settle(t, ZenoMethod::Bounce, true, 0.0, tail);
        }
        // Repeated ties end when the remaining time is below the rounding error of the clock.
        if together && both_touch && model.g[0] > 0.0 && model.g[1] > 0.0 {
            let left = [0, 1].map(|i| model.bounce[i] * rates[i]);
            let left = 0.5 * left[0].max(left[1]);
            if 0.0 < left && left <= 0.5 * REACHED * self.log.clock.hi {
                return self.settle(left, ZenoMethod::Mixed, false, left, Tail::Collisions);
            }
        }
        self.freeze_if_brief();
        None
    }

    /// Applies own-rate jumps; `rates`: the exact rates after them.
    fn apply_impulses(&mut self, jump: [f64; 2], rates: [f64; 2]) {
        match &mut self.body.state {
            PairState::Full(state) => {
                state.apply_impulse(jump);
                state.gaps.u = rates;
                state.forget_rounding();
            }
            PairState::Frozen(state) => {
                state.gaps.u = rates;
                state.sum.jump[0] += jump[0];
                state.sum.jump[1] += jump[1];
            }
        }
    }

    /// Adds a body for each collision.
    pub(super) fn align_bodies(&mut self) {
        let body = match &self.body.state {
            PairState::Full(state) => (state.center, state.spin),
            PairState::Frozen(_) => Default::default(),
        };
        self.log.bodies.resize(self.log.collisions.len(), body);
    }

    fn warn_of_tie(&mut self) {
        const TIE: &str = "contacts 1 and 2 collided at the same instant; the outcome depends on \
                           the policy `simultaneous`";
        if !self.record.warnings.iter().any(|warning| warning == TIE) {
            self.record.warnings.push(TIE.into());
        }
    }

    /// Whether the geometry changes with time.
    fn turns(&self) -> bool {
        matches!(&self.body.state, PairState::Full(state) if state.spin.omega != 0.0)
    }

    /// Time until two contacts that bounce in step rest, T = 2u/(g(1−e)) for both, if they do. `turns`: the body turns before or
    /// after the impact; they then keep in step only if T is short.
    fn bounce_together(&self, rates: [f64; 2], turns: bool) -> Option<f64> {
        let model = self.model();
        let flight = [0, 1].map(|i| 2.0 * rates[i] / model.g[i]);
        let in_step = flight[0] > 0.0 && flight[0] < f64::INFINITY && are_one(flight[0], flight[1]);
        let t = model.bounce[0] * rates[0];
        if !in_step
            || model.e[0] != model.e[1]
            || !(t <= self.log.left())
            || turns
                && matches!(&self.body.state, PairState::Full(state) if !state.stays_synchronous(t, &self.log))
        {
            return None;
        }
        Some(t)
    }

    /// Moves to the limit of an accumulation, where both contacts come to rest after `t`.
    pub(super) fn settle(
        &mut self,
        t: f64,
        method: ZenoMethod,
        certified: bool,
        error: f64,
        tail: Tail,
    ) -> Option<Outcome> {
        let raw = self.raw();
        let model = self.model();
        let impulses = model.settle(&raw.gaps, t);
        self.tail(&model, t, impulses, Gaps::default(), [true, true], tail);
        self.come_to_rest([true, true], method, certified, error)
    }

    /// Moves to the end of a tail of duration `t` with these own-rate impulses and final gaps, where these contacts have come to
    /// rest. `model`: the geometry at its start.
    pub(super) fn tail(
        &mut self,
        model: &FrozenModel,
        t: f64,
        own: Impulses,
        end: Gaps,
        closed: [bool; 2],
        tail: Tail,
    ) {
        // A tail of the full model is summed in the geometry frozen at its start.
        if let PairState::Full(state) = self.body.state {
            let start = Snapshot::of_full(&state, self.log.clock);
            let frame = Frame::with(start, &state, *model);
            let clock = self.log.clock.after(t);
            if self.log.record {
                self.record.frames.push(frame.clone());
                self.begin_span(|at| Motion::Tail(at, tail));
            }
            let raw = Snapshot { clock, gaps: end, impulses: own, ..Snapshot::default() };
            let full = frame.to_full(&self.record.subject, &raw);
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
                // The other contact moves with the body: its rate in the frozen geometry neglects that the geometry changes.
                let (i, k) = (1 - contact, &after.body.contacts[1 - contact]);
                if after.gaps.h[i].is_finite() {
                    after.gaps.u[i] = k.normal.dot(&after.center.v) + after.b[i] * after.spin.omega;
                }
            }
            let full = Snapshot::of_full(&after, clock);
            self.body.state = PairState::Full(after);
            self.set_frame(Frame::full(full));
        } else {
            self.note(|at| Motion::Tail(at, tail));
            if let PairState::Frozen(state) = &mut self.body.state {
                for i in 0..2 {
                    state.sum.path[i] += state.sum.jump[i] * t + own.path[i];
                    state.sum.jump[i] += own.jump[i];
                }
                state.gaps = end;
            }
            self.log.clock = self.log.clock.after(t);
        }
    }

    /// The contacts among these whose rest has not been recorded yet.
    fn not_yet(&self, rests: [bool; 2]) -> [bool; 2] {
        [0, 1].map(|i| rests[i] && !self.resting[i])
    }

    /// Records a Zeno point at this instant that needed no sum.
    fn zeno_here(&mut self, closed: [bool; 2], method: ZenoMethod) -> Option<Outcome> {
        self.come_to_rest(closed, method, true, 0.0)
    }

    /// Records a Zeno point at this instant; an outcome: the run ends with it.
    pub(super) fn come_to_rest(
        &mut self,
        closed: [bool; 2],
        method: ZenoMethod,
        certified: bool,
        error: f64,
    ) -> Option<Outcome> {
        let e = self.model().e;
        let stops = (0..2).all(|i| !closed[i] || e[i] == 0.0);
        for (resting, closed) in self.resting.iter_mut().zip(closed) {
            *resting |= closed;
        }
        if method != ZenoMethod::Rest {
            self.cause = Some(Cause::Zeno);
        }
        self.zeno_point(ZenoRecord {
            closed: PerContact::from_slice(&closed[..self.body.count]),
            method,
            certified,
            plastic: method == ZenoMethod::Bounce && stops,
            error,
            first_summed: self.log.hits,
            at: Pair::moment(self),
        })
    }

    /// Freezes the full model's geometry if the rest of the motion is too short to change it.
    fn freeze_if_brief(&mut self) {
        if let PairState::Full(state) = self.body.state
            && state.may_freeze(&self.log)
        {
            self.freeze(&state);
        }
    }

    pub(super) fn freeze(&mut self, state: &FullState) {
        self.begin_frame(Frame::frozen(Snapshot::of_full(state, self.log.clock), state));
    }

    pub(super) fn unfreeze(&mut self) {
        if self.is_brief() {
            self.begin_frame(Frame::full(self.full()));
        }
    }

    /// Sets the frame, and the state at its start.
    pub(super) fn begin_frame(&mut self, frame: Frame) {
        let raw = Snapshot { impulses: Impulses::default(), ..frame.start };
        self.body.state = frame.state(&self.record.subject, &raw);
        self.set_frame(frame);
    }
}

/// Impacts of one instant that are listed one by one.
const LISTED: usize = 64;
