//! One or two contacts whose impacts have no friction: fast loops over their collisions, and sums in closed form.

use nalgebra::Vector2;

use crate::body::contact::{ContactLetters, ContactValues};
use crate::body::posture::Posture;
use crate::collisions::full::{FullCollisions, FullState, PairBody};
use crate::collisions::local::{LocalCollisions, LoopExit, are_one, fly_for};
use crate::collisions::log::{Collision, in_words, names};
use crate::flight::parabola_touchdown;
use crate::impact::newton::{self, Hit, SequenceEnd};
use crate::math::clock::Clock;
use crate::modes::Mode;
use crate::motion::any::AnyContacts;
use crate::motion::driver::{Coordinates, Driver};
use crate::motion::mechanism::Jointed;
use crate::motion::nested::SlowLanding;
use crate::motion::record::{Motion, Tail};
use crate::options::{Options, Simultaneous, Stop};
use crate::outcome::{Cause, ContactNumber, Outcome, ZenoMethod};
use crate::sustained::frozen::Frozen;
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{REACHED, STILL};
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// Impacts of one instant that are listed one by one.
const LISTED: usize = 64;

/// Whether a motion has at most two contacts, which are points, impacts without friction and terrain without ends. Two contacts at one
/// point (ψ = 1) are excluded: no impact separates them.
pub(crate) fn is_plain(posture: &Posture, options: &Options) -> bool {
    let apart = match posture.geometry() {
        [one, two] => one.apart(two, 1.0) > 0.0,
        few => few.len() <= 1,
    };
    apart
        && options.is_frictionless(posture)
        && posture.ground(0).is_none()
        && !posture.has_rounds()
}

/// The contacts on the ground, or the next landing and its speed, in words, with this gravity into each of `count` contacts.
pub(super) fn next_landing(count: usize, gaps: &Gaps, gravity: [f64; 2]) -> String {
    let stays = |&i: &usize| gaps.h[i] == 0.0 && gaps.u[i] == 0.0;
    if (0..count).any(|i| stays(&i)) {
        return format!("with {} on the ground", names((0..count).filter(stays)));
    }
    let after = |i: usize| {
        if i < count { parabola_touchdown(gaps.h[i], gaps.u[i], gravity[i]) } else { f64::INFINITY }
    };
    let first = usize::from(after(1) < after(0));
    if !after(first).is_finite() {
        return "no contact lands any more".into();
    }
    let (h, u) = (gaps.h[first], gaps.u[first]);
    let speed = (u * u + 2.0 * gravity[first] * h).max(0.0).sqrt();
    format!("{} lands next, at about {}", names(std::iter::once(first)), in_words(speed))
}

/// A tail of this duration up to the time `t` in it, as far as closed forms go: this time, the gaps then, and the effects of the impacts.
pub(super) fn within(
    tail: Tail,
    model: &FrozenModel,
    gaps: &Gaps,
    t: f64,
) -> (f64, Gaps, Impulses) {
    match tail {
        Tail::Bounce { contact } => model.skip_bounces(contact, gaps, t),
        Tail::Cycle { ratio, duration } => {
            let cycles = (libm::log1p(-t / duration) / libm::log(ratio)).floor();
            let scale = libm::pow(ratio, cycles);
            let t = duration * (1.0 - scale);
            let rates = gaps.u.map(|u| u * scale);
            (t, Gaps { h: [0.0; 2], u: rates }, model.lead_to(rates, gaps, t))
        }
        Tail::Collisions => (0.0, *gaps, Impulses::default()),
    }
}

/// Coordinates in which the collisions of two contacts have fast loops.
pub(crate) trait Plain: Coordinates {
    type State: Clone;

    fn state(&mut self) -> &mut Self::State;

    /// Gaps of two contacts at most.
    fn gaps(&self) -> Gaps;

    /// Moves to the state after `dt` in the geometry of `model`, see [`FullState::hit`].
    fn hit(
        driver: &mut Driver<'_, Self>,
        model: &FrozenModel,
        dt: f64,
        own: &Impulses,
        gaps: &Gaps,
    );

    /// Applies own-rate jumps of `count` impacts at this instant; `rates`: the exact rates after them.
    fn push(driver: &mut Driver<'_, Self>, jump: [f64; 2], rates: [f64; 2], count: usize);

    /// Completes the record of new collisions: those since this state and time in the geometry of `model`; `None`: those of this instant.
    fn collided(
        driver: &mut Driver<'_, Self>,
        since: Option<(&Self::State, Clock)>,
        model: &FrozenModel,
    );

    fn note_flight(driver: &mut Driver<'_, Self>);

    /// Begins the record of a sum of impacts.
    fn write_sum(driver: &mut Driver<'_, Self>, tail: Tail);

    /// Records that these contacts have come to rest.
    fn settle(
        driver: &mut Driver<'_, Self>,
        contacts: &[usize],
        method: ZenoMethod,
        certified: bool,
        error: f64,
    ) -> Option<Outcome>;

    /// Both contacts have just bounced in step: if they go on to do so for ever, moves to the limit. `turned`: whether the body turned before.
    fn bounce_in_step(driver: &mut Driver<'_, Self>, turned: bool) -> Option<Option<Outcome>>;

    /// Whether the body turns.
    fn turns(&self) -> bool;
}

impl<C: Plain> Driver<'_, C> {
    /// The impacts of this instant: of both contacts at once, in turn, or of one contact. An outcome: the run ends here.
    pub(super) fn plain_impact(
        &mut self,
        model: &FrozenModel,
        coming: &[usize],
    ) -> Option<Outcome> {
        let gaps = self.body.gaps();
        let (before, both_touch) = (gaps.u, gaps.h == [0.0; 2]);
        let (tie, policy) = (coming.len() > 1, self.options.policy());
        if tie {
            self.warn_of_tie(coming);
        }
        let first = match coming {
            [first, _] if policy != Simultaneous::LastContactFirst => *first,
            [.., last] => *last,
            [] => return None,
        };
        let together = tie && policy == Simultaneous::Together;
        let (mut rates, mut jump, mut count) = (before, [0.0; 2], 0);
        let mut hits: Vec<Hit> = Vec::new();
        let mut in_step = false;
        if together {
            (jump, in_step) = newton::newton_together(model, before);
            rates = if in_step {
                [0, 1].map(|i| -model.e[i] * before[i]) // exact by the law, without rounding error
            } else {
                newton::kicked(model, before, jump)
            };
            let hit = |contact| Hit { contact, before, after: rates };
            hits.extend((0..2).filter(|&i| jump[i] > 0.0).map(hit));
        } else if both_touch {
            let end = newton::in_zero_time(model, first, &mut rates, |hit| {
                count += 1;
                jump[hit.contact] += hit.after[hit.contact] - hit.before[hit.contact];
                if hits.len() < LISTED {
                    hits.push(*hit);
                }
            });
            // So many impacts that the speeds underflow count as infinitely many. One impact on each contact may also leave zero rates.
            if end == SequenceEnd::Infinite || count > 2 && rates == [0.0; 2] {
                self.log.struck = [true; 2];
                let jump = model.solve_coupled(before.map(|u| -u));
                C::push(self, jump, [0.0; 2], 0);
                return C::settle(self, &[0, 1], ZenoMethod::Chatter, model.chatters(), 0.0);
            }
            if count > 1 {
                // The jumps of many impacts cancel: their sum is computed from the rates at the end.
                jump = model.solve_coupled([0, 1].map(|i| rates[i] - before[i]));
            }
        } else {
            rates = newton::newton(model, first, before);
            jump[first] = rates[first] - before[first];
            hits.push(Hit { contact: first, before, after: rates });
        }
        let turned = self.body.turns();
        C::push(self, jump, rates, count);
        self.log.hits += count.max(hits.len());
        let last = hits.last().map_or(first, |hit| hit.contact);
        self.cause = Some(Cause::Impact(ContactNumber::of(last)));
        for hit in &hits {
            let contact = hit.contact;
            self.log.struck[contact] = true;
            if self.log.record {
                let own = hit.after[contact] - hit.before[contact];
                self.log.collisions.push(Collision {
                    elapsed: self.log.clock,
                    contact,
                    before: hit.before,
                    after: hit.after,
                    jump: if together { jump[contact] } else { own },
                    other_gap: gaps.h[1 - contact],
                });
            }
        }
        C::collided(self, None, model);
        C::note_flight(self);
        if in_step && let Some(end) = C::bounce_in_step(self, turned) {
            return end;
        }
        // Repeated ties end when the remaining time is below the rounding error of the clock.
        if together && both_touch && model.g[0] > 0.0 && model.g[1] > 0.0 {
            let left = 0.5 * f64::max(model.bounce[0] * rates[0], model.bounce[1] * rates[1]);
            if 0.0 < left && left <= 0.5 * REACHED * self.log.clock.hi {
                self.both_rest(model, left, Tail::Collisions);
                return C::settle(self, &[0, 1], ZenoMethod::Mixed, false, left);
            }
        }
        None
    }

    /// Flight and collisions in the geometry of `model`, until they accumulate or another event comes.
    pub(super) fn clatter(&mut self, model: &FrozenModel) -> Option<Outcome> {
        let clock = self.log.clock;
        let start = (self.log.record || self.watch.is_on()).then(|| self.body.state().clone());
        let (mut gaps, mut sum) = (self.body.gaps(), Impulses::default());
        let begun = LocalCollisions::begin(model, &mut gaps, &mut sum, &mut self.log);
        let exit = match begun {
            Err(exit) => exit,
            Ok(mut collisions) => {
                if let Some(start) = start.as_ref().filter(|_| self.watch.is_on()) {
                    let dt = self.log.clock.since(clock);
                    C::hit(self, model, dt, &sum, &gaps);
                    C::watch_ground(self);
                    self.body.state().clone_from(start);
                }
                let exit = loop {
                    if let Some(exit) = collisions.next(model, &mut self.log) {
                        break exit;
                    }
                    collisions.alternate(&mut self.log);
                };
                collisions.end(exit, model, &mut gaps, &mut sum, &mut self.log)
            }
        };
        let dt = self.log.clock.since(clock);
        C::hit(self, model, dt, &sum, &gaps);
        if let Some(start) = &start {
            C::collided(self, Some((start, clock)), model);
        }
        self.land(exit, model)
    }

    /// Processes the end of a loop over collisions in this geometry.
    fn land(&mut self, exit: LoopExit, model: &FrozenModel) -> Option<Outcome> {
        match exit {
            LoopExit::Bounce { contact, duration } => {
                let (end, own) = model.end_bounce(contact, &self.body.gaps(), duration);
                self.skip(model, Tail::Bounce { contact }, duration, &own, &end);
                C::settle(self, &[contact], ZenoMethod::Bounce, true, 0.0)
            }
            LoopExit::Clatter(tail) => {
                self.both_rest(model, tail.duration, Tail::Collisions);
                C::settle(self, &[0, 1], ZenoMethod::Clatter, tail.proved, tail.error)
            }
            LoopExit::Reached { remaining, self_similar } => {
                let method = if self_similar { ZenoMethod::SelfSimilar } else { ZenoMethod::Mixed };
                // The bound is crude, but below the rounding error of the time.
                self.both_rest(model, 0.5 * remaining, Tail::Collisions);
                C::settle(self, &[0, 1], method, false, 0.5 * remaining)
            }
            LoopExit::Never if self.log.end == f64::INFINITY => Some(Outcome::Escape),
            LoopExit::Never => {
                let (left, gaps) = (self.log.left().max(0.0), self.body.gaps());
                let end = fly_for(model.g, &gaps, left);
                C::hit(self, model, left, &Impulses::default(), &end);
                self.log.clock = self.log.clock.after(left);
                Some(Outcome::TimeLimit)
            }
            LoopExit::TimeLimit => Some(Outcome::TimeLimit),
            LoopExit::EventLimit => Some(Outcome::EventLimit),
            LoopExit::Tie | LoopExit::Settled { .. } | LoopExit::Freeze => None,
        }
    }

    /// Moves to the instant, after `t`, at which two contacts rest.
    pub(super) fn both_rest(&mut self, model: &FrozenModel, t: f64, tail: Tail) {
        let own = model.settle(&self.body.gaps(), t);
        self.skip(model, tail, t, &own, &Gaps::default());
    }

    /// Moves to the end of a tail of this duration.
    fn skip(&mut self, model: &FrozenModel, tail: Tail, t: f64, own: &Impulses, end: &Gaps) {
        C::write_sum(self, tail);
        C::hit(self, model, t, own, end);
        self.log.clock = self.log.clock.after(t);
    }
}

impl AnyContacts {
    /// The constants of the fast loops, if these are exact.
    fn pair(driver: &Driver<'_, Self>) -> Option<PairBody> {
        let pair = driver.record.subject.pair().filter(|_| driver.body.plain)?;
        (driver.body.state.fall == Vector2::new(0.0, -pair.gravity)).then_some(*pair)
    }
}

impl Plain for AnyContacts {
    type State = BodyState;

    fn state(&mut self) -> &mut BodyState {
        &mut self.state
    }

    fn gaps(&self) -> Gaps {
        self.state.gaps()
    }

    fn hit(
        driver: &mut Driver<'_, Self>,
        model: &FrozenModel,
        dt: f64,
        own: &Impulses,
        gaps: &Gaps,
    ) {
        if let Some(pair) = driver.record.subject.pair() {
            let state = driver.body.state.full(pair).hit(model, dt, own, gaps);
            driver.body.state.follow(&state);
        }
    }

    fn push(driver: &mut Driver<'_, Self>, jump: [f64; 2], rates: [f64; 2], count: usize) {
        let Some(pair) = driver.record.subject.pair() else { return };
        let mut state = driver.body.state.full(pair);
        state.apply_impulse(jump);
        state.gaps.u = rates;
        state.forget_rounding();
        if count > 1 {
            state.follow([true, true]);
        }
        driver.body.state.follow(&state);
    }

    fn collided(
        driver: &mut Driver<'_, Self>,
        since: Option<(&BodyState, Clock)>,
        model: &FrozenModel,
    ) {
        let Driver { log, record, body, .. } = driver;
        let Some(pair) = record.subject.pair().filter(|_| log.record) else { return };
        let Some((start, mut clock)) = since else {
            log.bodies.resize(log.collisions.len(), (body.state.center, body.state.spin));
            return;
        };
        let mut state = start.full(pair);
        for c in &log.collisions[log.bodies.len()..] {
            let (i, mut own, mut gaps) =
                (c.contact, Impulses::default(), Gaps { u: c.after, ..Gaps::default() });
            (own.jump[i], gaps.h[1 - i]) = (c.jump, c.other_gap);
            state = state.hit(model, c.elapsed.since(clock), &own, &gaps);
            log.bodies.push((state.center, state.spin));
            clock = c.elapsed;
        }
    }

    fn note_flight(driver: &mut Driver<'_, Self>) {
        driver.note_flight();
    }

    fn write_sum(driver: &mut Driver<'_, Self>, tail: Tail) {
        driver.begin_sum(tail);
    }

    fn settle(
        driver: &mut Driver<'_, Self>,
        contacts: &[usize],
        method: ZenoMethod,
        certified: bool,
        error: f64,
    ) -> Option<Outcome> {
        let hit = if method == ZenoMethod::Bounce { f64::INFINITY } else { 0.0 };
        driver.settle(contacts, Some(method), certified, error, hit)
    }

    fn bounce_in_step(driver: &mut Driver<'_, Self>, turned: bool) -> Option<Option<Outcome>> {
        let state = driver.body.state.full(&AnyContacts::pair(driver)?);
        let (model, rates, turns) = (state.model(), state.gaps.u, turned || driver.body.turns());
        let flight = [0, 1].map(|i| 2.0 * rates[i] / model.g[i]);
        let in_step = flight[0] > 0.0 && flight[0] < f64::INFINITY && are_one(flight[0], flight[1]);
        let t = model.bounce[0] * rates[0];
        let ends = in_step && model.e[0] == model.e[1] && t <= driver.log.left();
        // A body that turns keeps them in step only if the time is short.
        if !ends || turns && !state.stays_synchronous(t, &driver.log) {
            return None;
        }
        driver.both_rest(&model, t, Tail::Cycle { ratio: model.e[0], duration: t });
        Some(Self::settle(driver, &[0, 1], ZenoMethod::Bounce, true, 0.0))
    }

    fn turns(&self) -> bool {
        self.state.spin.omega != 0.0
    }
}

impl Driver<'_, AnyContacts> {
    /// The impacts of this instant of a body with at most two contacts; see [`is_plain`].
    pub(super) fn impact_of_pair(&mut self, coming: &[usize]) -> Option<Option<Outcome>> {
        let pair = AnyContacts::pair(self)?;
        let model = self.body.state.full(&pair).model();
        Some(self.plain_impact(&model, coming))
    }

    /// Flight and collisions of a body with at most two contacts, until they accumulate or another event comes.
    pub(super) fn fly_plainly(&mut self) -> Option<Option<Outcome>> {
        let pair = AnyContacts::pair(self)?;
        let mut state = self.body.state.full(&pair);
        self.resting.fill(false);
        self.note_flight();
        let exit =
            if state.may_freeze(&self.log) { LoopExit::Freeze } else { self.collide(&mut state) };
        self.body.state.follow(&state);
        Some(match exit {
            LoopExit::Freeze => self.clatter(&state.model()),
            LoopExit::Settled { contact } => {
                let end = self.body.settled.take()?;
                self.settle_at(contact, *end)
            }
            LoopExit::Bounce { contact, duration } => {
                let model = state.model();
                let (end, own) = model.end_bounce(contact, &state.gaps, duration);
                self.skip(&model, Tail::Bounce { contact }, duration, &own, &end);
                // The other contact moves with the body: its rate in the frozen geometry neglects that the geometry changes.
                let BodyState { points, center, spin, .. } = &mut self.body.state;
                if let Some(p) = points.get_mut(1 - contact) {
                    p.u = p.normal.dot(&center.v) + p.b * spin.omega;
                }
                <AnyContacts as Plain>::settle(self, &[contact], ZenoMethod::Bounce, true, 0.0)
            }
            exit => self.land(exit, &state.model()),
        })
    }

    /// The fast loop in the geometry that turns.
    #[inline(never)] // keeps the registers free for the collisions
    fn collide(&mut self, state: &mut FullState) -> LoopExit {
        let mut collisions = FullCollisions::begin(&state.body, &mut self.log);
        let exit = loop {
            let mut exit = collisions.next(state, &mut self.log);
            if exit.is_none()
                && let Some(contact) = collisions.active()
            {
                exit = self.settles(state, contact);
            }
            if self.watch.is_on() {
                self.watch_flight(state);
            }
            if let Some(exit) = exit.or_else(|| collisions.alternate(state, &mut self.log)) {
                break exit;
            }
        };
        collisions.end(exit, state, &mut self.log)
    }

    /// Checks the ground at this state of a flight.
    #[inline(never)]
    fn watch_flight(&mut self, state: &FullState) {
        if !self.watch.is_near(&self.body.posture, &state.q()) {
            self.body.state.follow(state);
            AnyContacts::watch_ground(self);
        }
    }

    /// The modes of a body that stays at rest: all contacts rest, and all speeds are rounding errors. `None`: closed forms do not decide.
    pub(super) fn stands(&mut self) -> Option<ContactLetters<Mode>> {
        let AnyContacts { posture, state, .. } = &self.body;
        let BodyState { points, center, spin, fall, gravity, .. } = state;
        let (tolerance, size) = (AnyContacts::sliding_tolerance(self), posture.size());
        let most = |v: [f64; 3]| v[0].abs().max(v[1].abs()).max(size * v[2].abs());
        if !(most([center.v.x, center.v.y, spin.omega]) <= tolerance) {
            return None;
        }
        // The centre of mass is between two contacts on level ground without friction, λ_i = g b_j/(b_j − b_i): both forces
        // press, and no other motion is consistent. To test all words would cost a fifth of a short run.
        let level = |p: &ContactState| p.friction == 0.0 && p.normal == -fall / *gravity;
        let lies = *gravity > 0.0 && fall.perp(&center.v) == 0.0 && spin.omega == 0.0;
        if lies && points.len() == 2 && points.iter().all(level) && points[0].b * points[1].b < 0.0
        {
            return Some(ContactLetters::from_elem(Mode::Fixed, 2));
        }
        let slips: ContactValues<f64> = (0..points.len()).map(|i| state.slip(i).abs()).collect();
        let limit = |p: &ContactState| if p.friction > 0.0 { tolerance } else { 0.0 };
        if points.iter().zip(&slips).any(|(p, slip)| *slip > limit(p)) {
            return None;
        }
        let (mut modes, acceleration) =
            state.only_mode(&ContactLetters::from_elem(Some(0), points.len()))?;
        if !(most(acceleration) <= STILL * gravity) {
            return None;
        }
        for (mode, p) in modes.iter_mut().zip(points) {
            if *mode != Mode::Separate && p.friction == 0.0 {
                *mode = Mode::Fixed; // forces do not change
            }
        }
        self.nested.drop(slips.into_iter().fold(0.0, f64::max));
        Some(modes)
    }

    /// Rests in these modes.
    pub(super) fn stand(&mut self, modes: ContactLetters<Mode>) -> Outcome {
        self.body.state.stand();
        self.body.state.points.iter_mut().for_each(|p| p.h = 0.0);
        if self.log.record {
            self.write(Motion::Modes(Box::new(self.body.state.clone()), modes));
        }
        if self.options.stop != Stop::Time {
            return Outcome::Rest;
        }
        self.log.clock = self.log.clock.after(self.log.left().max(0.0));
        Outcome::TimeLimit
    }

    /// Contact `b` lands while another is held. If all speeds of the body are below their rounding error, the body comes to rest. If only
    /// the landing speed is, contact `b` comes to rest.
    pub(super) fn stop_slowly(&mut self, b: usize, body: &BodyState) -> Option<Option<Outcome>> {
        let v = body.state().qdot;
        let left = v.x.abs().max(v.y.abs()).max(self.body.posture.size() * v.z.abs());
        let fastest = AnyContacts::largest_speed(self);
        let SlowLanding { quiet, error } =
            SlowLanding::of(-body.points[b].u, left, fastest, body.gravity)?;
        let end = &mut self.body.state;
        end.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
        end.close(&[true; 2]);
        if quiet {
            end.stand();
        }
        self.nested.forget();
        Some(self.settle(&[0, 1], Some(ZenoMethod::Mixed), false, error, 0.0))
    }
}

impl Plain for Jointed {
    type State = Frozen;

    fn state(&mut self) -> &mut Frozen {
        &mut self.state
    }

    fn gaps(&self) -> Gaps {
        self.state.gaps()
    }

    fn hit(driver: &mut Driver<'_, Self>, _: &FrozenModel, dt: f64, own: &Impulses, gaps: &Gaps) {
        driver.body.state = driver.body.state.hit(dt, own, gaps);
    }

    fn push(driver: &mut Driver<'_, Self>, jump: [f64; 2], rates: [f64; 2], _: usize) {
        let mut gaps = driver.body.state.gaps();
        gaps.u = rates;
        driver.body.state = driver.body.state.hit(0.0, &Impulses { jump, path: [0.0; 2] }, &gaps);
    }

    fn collided(_: &mut Driver<'_, Self>, _: Option<(&Frozen, Clock)>, _: &FrozenModel) {}

    fn note_flight(driver: &mut Driver<'_, Self>) {
        driver.note_flight();
    }

    fn write_sum(driver: &mut Driver<'_, Self>, tail: Tail) {
        driver.write_sum(tail);
    }

    fn settle(
        driver: &mut Driver<'_, Self>,
        contacts: &[usize],
        method: ZenoMethod,
        certified: bool,
        error: f64,
    ) -> Option<Outcome> {
        driver.settle(contacts, method, certified, error)
    }

    fn bounce_in_step(driver: &mut Driver<'_, Self>, _: bool) -> Option<Option<Outcome>> {
        driver.bounce_in_step()
    }

    fn turns(&self) -> bool {
        false
    }
}
