//! One or two contacts whose impacts have no friction: fast loops over their collisions, and sums in closed form.

use nalgebra::Vector2;

use crate::collisions::full::{FullCollisions, FullState, PairBody};
use crate::collisions::local::{LocalCollisions, LoopExit, are_one, fly_for};
use crate::collisions::log::Collision;
use crate::collisions::regular::RegularSum;
use crate::impact::newton::{self, Hit, SequenceEnd};
use crate::math::clock::Clock;
use crate::math::mass_vector::MassVector;
use crate::motion::bounces::Settled;
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::options::{Impact, Simultaneous};
use crate::outcome::{Cause, ContactNumber, Outcome, ZenoMethod};
use crate::tolerance::REACHED;
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// Impacts of one instant that are listed one by one.
const LISTED: usize = 64;

impl Driver<'_> {
    /// The constants of the fast loops of a body that turns, if these are exact.
    fn pair(&self) -> Option<PairBody> {
        let pair = self.record.subject.pair().filter(|_| self.plain)?;
        let body = self.state.turning()?;
        (!body.fall_changes() && body.fall == Vector2::new(0.0, -pair.gravity)).then_some(*pair)
    }

    /// The couplings of one or two contacts, and the gravity into them, in this geometry.
    pub(super) fn plain_model(&self) -> Option<FrozenModel> {
        match &self.state {
            Moving::Turning(body) => Some(body.full(&self.pair()?).model()),
            Moving::Frozen(rows) => rows.rows.gaps.filter(|_| self.plain),
        }
    }

    /// The impacts of this instant: of both contacts at once, in turn, or of one contact. An outcome: the run ends here.
    pub(super) fn plain_impact(
        &mut self,
        model: &FrozenModel,
        coming: &[usize],
    ) -> Option<Outcome> {
        let gaps = self.state.gaps();
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
                self.kick(jump, [0.0; 2], 0);
                return self.settle(&[0, 1], Some(ZenoMethod::Chatter), model.chatters(), 0.0, 0.0);
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
        let turned = self.turns();
        self.kick(jump, rates, count);
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
        self.write_bodies(None, model);
        self.note_flight();
        if in_step && let Some(end) = self.bounce_pair_in_step(turned) {
            return end;
        }
        // Repeated ties end when the remaining time is below the rounding error of the clock.
        if together && both_touch && model.g[0] > 0.0 && model.g[1] > 0.0 {
            let left = 0.5 * f64::max(model.bounce[0] * rates[0], model.bounce[1] * rates[1]);
            if 0.0 < left && left <= 0.5 * REACHED * self.log.clock.hi {
                self.both_rest(model, left, Tail::Collisions);
                return self.settle(&[0, 1], Some(ZenoMethod::Mixed), false, left, 0.0);
            }
        }
        None
    }

    /// Flight and collisions in the geometry of `model`, until they accumulate or another event comes.
    pub(super) fn clatter(&mut self, model: &FrozenModel) -> Option<Outcome> {
        let clock = self.log.clock;
        let start = (self.log.record || self.watch.is_on()).then(|| self.state.clone());
        let (mut gaps, mut sum) = (self.state.gaps(), Impulses::default());
        let begun = LocalCollisions::begin(model, &mut gaps, &mut sum, &mut self.log);
        let exit = match begun {
            Err(exit) => exit,
            Ok(collisions) => {
                if let Some(start) = start.as_ref().filter(|_| self.watch.is_on()) {
                    let dt = self.log.clock.since(clock);
                    self.hit(model, dt, &sum, &gaps);
                    self.watch_ground();
                    self.state.clone_from(start);
                }
                collisions.run(model, &mut gaps, &mut sum, &mut self.log)
            }
        };
        let dt = self.log.clock.since(clock);
        self.hit(model, dt, &sum, &gaps);
        if let Some(start) = &start {
            self.write_bodies(Some((start, clock)), model);
        }
        self.land(exit, model)
    }

    /// Processes the end of a loop over collisions in this geometry.
    pub(super) fn land(&mut self, exit: LoopExit, model: &FrozenModel) -> Option<Outcome> {
        match exit {
            LoopExit::Bounce { contact, duration } => {
                let (end, own) = model.end_bounce(contact, &self.state.gaps(), duration);
                self.skip(model, Tail::Bounce { contact }, duration, &own, &end);
                self.settle(&[contact], Some(ZenoMethod::Bounce), true, 0.0, f64::INFINITY)
            }
            LoopExit::Clatter(tail) => {
                self.both_rest(model, tail.duration, Tail::Collisions);
                self.settle(&[0, 1], Some(ZenoMethod::Clatter), tail.proved, tail.error, 0.0)
            }
            LoopExit::Regular(sum) => {
                self.both_rest(model, sum.duration, Tail::Collisions);
                self.settle(&[0, 1], Some(ZenoMethod::SelfSimilar), false, sum.error, 0.0)
            }
            LoopExit::Reached { self_similar, .. } => {
                let method = if self_similar { ZenoMethod::SelfSimilar } else { ZenoMethod::Mixed };
                let left = exit.time_to_rest()?;
                self.both_rest(model, left, Tail::Collisions);
                self.settle(&[0, 1], Some(method), false, left, 0.0)
            }
            LoopExit::Never if self.log.end == f64::INFINITY => Some(Outcome::Escape),
            LoopExit::Never => {
                let (left, gaps) = (self.log.left().max(0.0), self.state.gaps());
                let end = fly_for(model.g, &gaps, left);
                self.hit(model, left, &Impulses::default(), &end);
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
        let own = model.settle(&self.state.gaps(), t);
        self.skip(model, tail, t, &own, &Gaps::default());
    }

    /// Moves to the end of a tail of this duration.
    fn skip(&mut self, model: &FrozenModel, tail: Tail, t: f64, own: &Impulses, end: &Gaps) {
        self.begin_sum(tail);
        self.hit(model, t, own, end);
        self.log.clock = self.log.clock.after(t);
    }

    /// Moves to the state after `dt` in the geometry of `model`, see [`FullState::hit`].
    pub(super) fn hit(&mut self, model: &FrozenModel, dt: f64, own: &Impulses, gaps: &Gaps) {
        match (&mut self.state, self.record.subject.pair()) {
            (Moving::Turning(body), Some(pair)) => {
                let state = body.full(pair).hit(model, dt, own, gaps);
                body.follow(&state);
            }
            (Moving::Frozen(rows), _) => **rows = rows.hit(dt, own, gaps),
            (Moving::Turning(_), None) => {}
        }
    }

    /// Applies own-rate jumps of `count` impacts at this instant; `rates`: the exact rates after them.
    fn kick(&mut self, jump: [f64; 2], rates: [f64; 2], count: usize) {
        match (&mut self.state, self.record.subject.pair()) {
            (Moving::Turning(body), Some(pair)) => {
                let mut state = body.full(pair);
                state.apply_impulse(jump);
                state.gaps.u = rates;
                state.forget_rounding();
                if count > 1 {
                    state.follow([true, true]);
                }
                body.follow(&state);
            }
            (Moving::Frozen(rows), _) => {
                let gaps = Gaps { u: rates, ..rows.gaps() };
                **rows = rows.hit(0.0, &Impulses { jump, path: [0.0; 2] }, &gaps);
            }
            (Moving::Turning(_), None) => {}
        }
    }

    /// Records the body after each new collision: since this state and time in the geometry of `model`; `None`: those of this instant.
    fn write_bodies(&mut self, since: Option<(&Moving, Clock)>, model: &FrozenModel) {
        let Self { log, record, state: now, .. } = self;
        let (Some(pair), Moving::Turning(now)) = (record.subject.pair(), now) else { return };
        if !log.record {
            return;
        }
        let Some((Moving::Turning(start), mut clock)) = since else {
            log.bodies.resize(log.collisions.len(), (now.center, now.spin));
            return;
        };
        let mut state = start.full(pair);
        for c in &log.collisions[log.bodies.len()..] {
            let (own, gaps) = c.effects();
            state = state.hit(model, c.elapsed.since(clock), &own, &gaps);
            log.bodies.push((state.center, state.spin));
            clock = c.elapsed;
        }
    }

    /// Both contacts have just bounced in step: if they go on to do so for ever, moves to the limit. `turned`: whether the body turned before.
    fn bounce_pair_in_step(&mut self, turned: bool) -> Option<Option<Outcome>> {
        let Some(pair) = self.pair() else { return self.bounce_in_step() };
        let (state, turns) = (self.state.turning()?.full(&pair), turned || self.turns());
        let (model, rates) = (state.model(), state.gaps.u);
        let flight = [0, 1].map(|i| 2.0 * rates[i] / model.g[i]);
        let in_step = flight[0] > 0.0 && flight[0] < f64::INFINITY && are_one(flight[0], flight[1]);
        let t = model.bounce[0] * rates[0];
        let ends = in_step && model.e[0] == model.e[1] && t <= self.log.left();
        // A body that turns keeps them in step only if the time is short.
        if !ends || turns && !state.stays_synchronous(t, &self.log) {
            return None;
        }
        self.both_rest(&model, t, Tail::Cycle { ratio: model.e[0], duration: t });
        Some(self.settle(&[0, 1], Some(ZenoMethod::Bounce), true, 0.0, f64::INFINITY))
    }

    /// All contacts, over constant rows, have just bounced in step: if they go on to do so for ever, moves to the limit.
    pub(super) fn bounce_in_step(&mut self) -> Option<Option<Outcome>> {
        let Moving::Frozen(rows) = &self.state else { return None };
        let (space, points) = (rows.space(), &rows.points);
        let e = |i: usize| rows.rows.material[i].restitution;
        let flight = |i: usize| 2.0 * points[i].u / space.gravity(i);
        let alike = |i: usize| are_one(flight(i), flight(0)) && e(i) == e(0);
        let rises = |i: usize| points[i].h == 0.0 && points[i].u > 0.0;
        let slips = self.options.impact == Impact::Newton;
        let smooth = |i: usize| slips || rows.rows.friction[i] == 0.0;
        let count = points.len();
        let first = flight(0);
        if count < 2
            || !(first > 0.0 && first < f64::INFINITY)
            || !(0..count).all(|i| rises(i) && alike(i) && smooth(i))
        {
            return None;
        }
        let t = first / (1.0 - e(0));
        if !(t <= self.log.left()) {
            return None;
        }
        let mut end = rows.flown(t);
        // All impulses act along the normal rows, along which nothing has moved at the limit.
        let way = self.state.along(end.y.plus(&rows.y, -1.0));
        end.y = rows.y.plus(&way, 1.0);
        end.v = self.state.along(end.v);
        end.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
        self.begin_sum(Tail::Collisions);
        self.state = Moving::Frozen(Box::new(end));
        self.log.clock = self.log.clock.after(t);
        let all: Vec<usize> = (0..count).collect();
        Some(self.settle(&all, Some(ZenoMethod::Bounce), true, 0.0, f64::INFINITY))
    }

    /// Returns true if the geometry turns.
    fn turns(&self) -> bool {
        self.state.turning().is_some_and(|body| body.spin.omega != 0.0)
    }

    /// Flight and collisions of one or two contacts, until they accumulate or another event comes; `None` if they have no fast loop.
    pub(super) fn fly_plainly(&mut self) -> Option<Option<Outcome>> {
        if !self.plain {
            return None;
        }
        let pair = match &self.state {
            Moving::Turning(_) => Some(self.pair()?),
            Moving::Frozen(_) => None,
        };
        self.resting.fill(false);
        self.note_flight();
        Some(match pair {
            Some(pair) => self.fly_turning(&pair),
            None => self.clatter(&self.plain_model()?),
        })
    }

    /// The same for a body that turns. The geometry is frozen for the last moments of an accumulation.
    fn fly_turning(&mut self, pair: &PairBody) -> Option<Outcome> {
        let Moving::Turning(body) = &self.state else { return None };
        let (mut state, mut settled) = (body.full(pair), None);
        let exit = match state.may_freeze(&self.log) {
            true => LoopExit::Freeze,
            false => self.collide(&mut state, &mut settled),
        };
        if let Moving::Turning(body) = &mut self.state {
            body.follow(&state);
        }
        match exit {
            LoopExit::Freeze => self.clatter(&state.model()),
            LoopExit::Settled { contact } => self.settle_at(contact, settled?),
            exit => self.land_turning(exit, &state),
        }
    }

    /// Processes the end of the fast loop in the geometry that turns, in this state.
    pub(super) fn land_turning(&mut self, exit: LoopExit, state: &FullState) -> Option<Outcome> {
        let model = state.model();
        let (contact, duration) = match exit {
            LoopExit::Bounce { contact, duration } => (contact, duration),
            LoopExit::Regular(RegularSum { duration, error }) => {
                self.begin_sum(Tail::Collisions);
                if let Moving::Turning(body) = &mut self.state {
                    body.follow(&state.at_rest_after(duration));
                }
                self.log.clock = self.log.clock.after(duration);
                return self.settle(&[0, 1], Some(ZenoMethod::SelfSimilar), false, error, 0.0);
            }
            exit => return self.land(exit, &model),
        };
        let (end, own) = model.end_bounce(contact, &state.gaps, duration);
        self.skip(&model, Tail::Bounce { contact }, duration, &own, &end);
        // The other contact moves with the body: its rate in the frozen geometry neglects that the geometry changes.
        if let Moving::Turning(body) = &mut self.state
            && let Some(p) = body.points.get_mut(1 - contact)
        {
            p.u = p.normal.dot(&body.center.v) + p.b * body.spin.omega;
        }
        self.settle(&[contact], Some(ZenoMethod::Bounce), true, 0.0, f64::INFINITY)
    }

    /// The fast loop in the geometry that turns. `settled`: the limit of bounces that ends it.
    #[inline(never)] // keeps the registers free for the collisions
    fn collide(&mut self, state: &mut FullState, settled: &mut Option<Settled>) -> LoopExit {
        let mut collisions = FullCollisions::begin(&state.body, &mut self.log);
        let exit = loop {
            let mut exit = collisions.next(state, &mut self.log);
            if exit.is_none()
                && let Some(contact) = collisions.active()
            {
                *settled = self.settles(state, contact);
                exit = settled.is_some().then_some(LoopExit::Settled { contact });
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
        let posture = self.record.subject.posture();
        if posture.is_some_and(|posture| !self.watch.is_near(posture, &state.q())) {
            if let Moving::Turning(body) = &mut self.state {
                body.follow(state);
            }
            self.watch_ground();
        }
    }
}
