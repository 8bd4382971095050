//! Collisions of the local model, one after the other, until they accumulate.
//!
//! The contact just hit is called a, the other b, as in [Or & Rimon 2008, (7)]. When b lands next, after
//! τ, with the speed s:
//!
//! ```text
//! s² = u_b² + 2g_b h_b,    τ = 2h_b/(s − u_b)    (u_b < 0)
//! u_a' = e_b s,   u_b' = w − K,   h_b' = τ(u_a + w)/2,   w = u_a − g_aτ,  K = (1+e_b)ψ_b s
//! s'² = (u_a − K)² + 2K g_aτ
//! ```
//!
//! with the primes in swapped roles. The last line is u_b'² + 2g_a h_b' multiplied out: it needs one
//! multiplication and one addition after τ, so that a collision costs little more than its square root
//! and its division.

use fearless_simd::Simd;

use crate::collisions::log::{Collision, Log};
use crate::flight::parabola_touchdown;
use crate::impact::newton;
use crate::math::clock::{Clock, unnormalised_after};
use crate::math::lanes::{Columns, Lanes};
use crate::math::real::Real;
use crate::tolerance::{REACHED, SELF_SIMILAR, SIMULTANEOUS, TAIL};
use crate::zeno::{ClatterTail, FrozenModel, Gaps, Impulses};

/// Why a sequence of collisions is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LoopExit {
    /// A bounce tail at this contact, of this duration.
    Bounce {
        contact: usize,
        duration: f64,
    },
    /// A certified clattering tail.
    Clatter(ClatterTail),
    /// Both contacts come to rest within `remaining`, which is below the rounding of the time.
    Reached {
        remaining: f64,
        self_similar: bool,
    },
    /// Both contacts arrive at the same instant: both gaps are zero, nothing has been hit yet.
    Tie,
    /// The full model only: what remains is so short that the geometry may be frozen.
    Freeze,
    TimeLimit,
    /// No event is left, or the run was cancelled.
    EventLimit,
    /// No contact ever lands again.
    Never,
}

/// Ratio of remaining flight (2u_a − g_aτ)/u_a below which the order of landing is decided with care.
const CLOSE: f64 = 1e-14;
/// After n collisions, the next look for a sum comes n/PATIENCE collisions later: it costs as much as a
/// collision, and at most that share of them is simulated in vain.
const PATIENCE: usize = 16;
/// Collisions for which a record makes room at a time, an even number: to ask at every collision whether the list has to grow
/// costs half as much as the collision.
const BLOCK: usize = 64;
/// τ relative to the elapsed time below which the accumulation may be all but reached.
const SHORT: f64 = 1e-16;

/// Which contact lands next, when, and whether the other lands at the same instant.
fn next_landing(m: &FrozenModel, gaps: &Gaps) -> (usize, f64, bool) {
    let t = [0, 1].map(|i| parabola_touchdown(gaps.h[i], gaps.u[i], m.g[i]));
    let first = usize::from(t[1] < t[0]);
    (first, t[first], are_one(t[0], t[1]))
}

/// Whether two contacts that start a flight land together, as far as rounding can tell: one that falls straight down has all
/// gaps in the ratio of the gravities into them, and the roundings of both must not decide which one lands first.
pub(crate) fn are_one(t: f64, other: f64) -> bool {
    (t - other).abs() <= SIMULTANEOUS * t.min(other)
}

/// Gaps and rates after a flight of `dt`.
pub(crate) fn fly_for(g: [f64; 2], gaps: &Gaps, dt: f64) -> Gaps {
    let mut after = *gaps;
    for i in 0..2 {
        after.h[i] = (gaps.h[i] + dt * (gaps.u[i] - 0.5 * g[i] * dt)).max(0.0);
        after.u[i] = gaps.u[i] - g[i] * dt;
    }
    after
}

/// What the loop needs of one contact, together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side<T> {
    g: T,
    e: T,
    kappa: T,
    /// 2(1+e)ψ g of the other contact.
    lift: T,
}

/// The state of the loop in roles: contact a was hit last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Roles<T> {
    u_a: T,
    u_b: T,
    h_b: T,
    /// s² of the next landing of b.
    square: T,
    /// The clock, not renormalised.
    hi: T,
    lo: T,
    /// Own-rate jumps of contact 1, and their sum weighted with the time since the loop began; those of
    /// contact 2 follow from its gap.
    jump: T,
    moment: T,
}

/// What does not change in the loop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course<T> {
    sides: [Side<T>; 2],
    /// Elapsed time at which the loop began, in s.
    from: T,
    /// The time limit, or the largest double: one comparison tells a flight beyond it and one without end.
    end: T,
}

/// A collision of the plain kind, if it is one.
struct Hop<T: Real> {
    after: Roles<T>,
    /// Whether b falls on the terrain before a is back, within the limits.
    plain: T::Mask,
    /// Speed of the landing, and rate of the other contact then.
    s: T,
    w: T,
}

impl<T: Real> Roles<T> {
    /// The next collision, at the contact that was not hit last. `A`: that was.
    #[inline(always)]
    fn hop<const A: usize>(&self, course: &Course<T>) -> Hop<T> {
        let (of_a, of_b) = (&course.sides[A], &course.sides[1 - A]);
        let (u_a, u_b, h_b) = (self.u_a, self.u_b, self.h_b);
        // 2K g_aτ has a division of its own, ahead of that of τ, so that the next square root waits for one
        // addition only; it adds to a square, and nothing cancels.
        let s = self.square.sqrt();
        let (twice, sum) = (h_b * 2.0, s - u_b);
        let gain = of_b.lift * twice * s / sum;
        let tau = twice / sum;
        let w = u_a - of_a.g * tau;
        let climb = u_a + w;
        let (hi, lo) = unnormalised_after(self.hi, self.lo, tau);
        let zero = u_b.like(0.0);
        let plain = u_b.below(zero)
            & zero.at_most(gain)
            & (u_a * CLOSE).below(climb)
            & hi.at_most(course.end);

        let [hit, other] = newton::rates_after(of_b.e, of_b.kappa, s, w);
        let d = u_a - of_b.kappa * s;
        let mut after = Self {
            u_a: hit,
            u_b: other,
            h_b: tau * 0.5 * climb,
            square: d * d + gain,
            hi,
            lo,
            ..*self
        };
        if A == 1 {
            let blow = s + hit;
            after.jump = self.jump + blow;
            after.moment = self.moment + blow * (hi - course.from);
        }
        Hop { after, plain, s, w }
    }
}

/// Collisions one after the other, under way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalCollisions {
    course: Course<f64>,
    /// The contact hit last.
    a: usize,
    r: Roles<f64>,
    /// Collisions until the next look at the limits and for a sum.
    left: usize,
    granted: usize,
    /// State, clock and number of collisions where the loop began.
    start: Gaps,
    clock: Clock,
    first: usize,
    /// How often each contact has been hit since, but for the plain collisions in turn.
    singly: [usize; 2],
}

impl LocalCollisions {
    /// The first landing, and the impact there; an error: something else.
    pub(crate) fn begin(
        m: &FrozenModel,
        gaps: &mut Gaps,
        sum: &mut Impulses,
        log: &mut Log,
    ) -> Result<Self, LoopExit> {
        let (contact, tau, tie) = next_landing(m, gaps);
        if log.clock.hi + tau > log.end {
            rest_of_time(m, gaps, sum, log);
            return Err(LoopExit::TimeLimit);
        }
        if tau == f64::INFINITY {
            return Err(LoopExit::Never);
        }
        let before = *gaps;
        *gaps = fly_for(m.g, gaps, tau);
        gaps.h[contact] = 0.0;
        gaps.u[contact] = -(before.u[contact] * before.u[contact]
            + 2.0 * m.g[contact] * before.h[contact])
            .sqrt();
        log.clock = log.clock.after(tau);
        advance(sum, tau);
        if tie {
            gaps.h = [0.0; 2];
            return Err(LoopExit::Tie);
        }
        if log.chunk() == 0 {
            return Err(LoopExit::EventLimit);
        }
        let rates = gaps.u;
        gaps.u = newton::newton(m, contact, rates);
        let jump = (1.0 + m.e[contact]) * -rates[contact];
        sum.jump[contact] += jump;
        log.hits += 1;
        log.struck[contact] = true;
        if log.record {
            log.collisions.push(Collision {
                elapsed: log.clock,
                contact,
                before: rates,
                after: gaps.u,
                jump,
                other_gap: gaps.h[1 - contact],
            });
        }
        let sides = [0, 1].map(|i| Side {
            g: m.g[i],
            e: m.e[i],
            kappa: m.kappa[i],
            lift: 2.0 * m.kappa[i] * m.g[1 - i],
        });
        let course = Course { sides, from: log.clock.hi, end: log.end.min(f64::MAX) };
        let (u_a, u_b, h_b) = (gaps.u[contact], gaps.u[1 - contact], gaps.h[1 - contact]);
        let square = u_b * u_b + 2.0 * m.g[1 - contact] * h_b;
        let Clock { hi, lo } = log.clock;
        let r = Roles { u_a, u_b, h_b, square, hi, lo, jump: 0.0, moment: 0.0 };
        let (left, granted) = (0, 0);
        let (start, clock, first) = (*gaps, log.clock, log.hits);
        let singly = [0; 2];
        Ok(Self { course, a: contact, r, left, granted, start, clock, first, singly })
    }

    /// After the loop: gaps, impulses and clock.
    pub(crate) fn end(
        self,
        halt: LoopExit,
        m: &FrozenModel,
        gaps: &mut Gaps,
        sum: &mut Impulses,
        log: &mut Log,
    ) -> LoopExit {
        log.hits += self.granted - self.left;
        let [one, two] = self.singly;
        // Collisions in turn begin after one at contact 1, with one at contact 2.
        let in_turn = log.hits - self.first > one + two;
        log.struck = [log.struck[0] || one > 0, log.struck[1] || two > 0 || in_turn];
        log.clock = Clock { hi: self.r.hi, lo: self.r.lo }.renormalised();
        let (start, t) = (self.start, log.clock.since(self.clock));
        *gaps = self.gaps();
        advance(sum, t);
        let path = self.r.jump * (self.r.hi - self.course.from) - self.r.moment;
        sum.jump[0] += self.r.jump;
        sum.path[0] += path;
        if gaps.h[1] < f64::INFINITY {
            let (g, h, u) = (m.g[1], start.h[1], start.u[1]);
            sum.jump[1] += gaps.u[1] - (u - g * t) + m.psi[0] * self.r.jump;
            sum.path[1] += gaps.h[1] - (h + t * (u - 0.5 * g * t)) + m.psi[0] * path;
        }
        if halt == LoopExit::TimeLimit {
            rest_of_time(m, gaps, sum, log);
        }
        halt
    }

    fn gaps(&self) -> Gaps {
        let mut gaps = Gaps::default();
        let (a, b) = (self.a, 1 - self.a);
        (gaps.u[a], gaps.u[b], gaps.h[b]) = (self.r.u_a, self.r.u_b, self.r.h_b);
        gaps
    }

    /// A look at the limits and for a sum, if one is due, and the next event, whatever it is.
    pub(crate) fn next(&mut self, m: &FrozenModel, log: &mut Log) -> Option<LoopExit> {
        if self.left == 0 {
            log.hits += self.granted;
            self.granted = 0;
            if let Some(halt) = accumulates(m, self, log.end) {
                return Some(halt);
            }
            self.granted = log.chunk().min(1 + (log.hits - self.first) / PATIENCE);
            self.left = self.granted;
            if self.granted == 0 {
                return Some(LoopExit::EventLimit);
            }
        }
        self.collide(m, log)
    }

    /// Whether plain collisions may be next: after one at contact 1.
    pub(crate) fn is_at_first(&self) -> bool {
        self.a == 0
    }

    /// Collisions in turn, as long as nothing else happens and no look is due, from an impact at contact 1 on.
    ///
    /// Written out for both roles, so that none is looked up.
    pub(crate) fn alternate(&mut self, log: &mut Log) {
        if self.a != 0 {
            return;
        }
        if log.record {
            self.hop_on::<true>(&mut log.collisions);
        } else {
            self.hop_on::<false>(&mut log.collisions);
        }
    }

    #[inline(never)]
    fn hop_on<const RECORD: bool>(&mut self, collisions: &mut Vec<Collision>) {
        let (mut r, mut left, course) = (self.r, self.left, self.course);
        let (first, most) = (collisions.len(), left);
        self.a = 'plain: loop {
            if left == 0 {
                break 0;
            }
            let block = left.min(BLOCK);
            let room: &mut [Collision] = if RECORD {
                let written = first + most - left;
                collisions.resize(written + block, Collision::default());
                &mut collisions[written..]
            } else {
                &mut []
            };
            let mut slots = room.iter_mut();
            for _ in 0..block / 2 {
                if !one_hop::<0>(&mut r, &course, slots.next()) {
                    break 'plain 0;
                }
                left -= 1;
                if !one_hop::<1>(&mut r, &course, slots.next()) {
                    break 'plain 1;
                }
                left -= 1;
            }
            if block % 2 == 1 {
                if !one_hop::<0>(&mut r, &course, slots.next()) {
                    break 0;
                }
                left -= 1;
                break 1;
            }
        };
        if RECORD {
            collisions.truncate(first + most - left);
        }
        (self.r, self.left) = (r, left);
    }

    /// The next event, whatever it is.
    #[inline(never)]
    fn collide(&mut self, m: &FrozenModel, log: &mut Log) -> Option<LoopExit> {
        let (a, b) = (self.a, 1 - self.a);
        let Roles { u_a, u_b, h_b, .. } = self.r;
        let (g_a, g_b) = (m.g[a], m.g[b]);
        let tau = parabola_touchdown(h_b, u_b, g_b);
        let s = self.r.square.max(0.0).sqrt();
        let w = u_a - g_a * tau;
        let climb = u_a + w;
        let back = 2.0 * u_a / g_a;
        if climb <= CLOSE * u_a && back <= tau && g_a > 0.0 {
            // a is back before b lands.
            if let Some(halt) = bounces(m, a, &self.gaps(), self.r.hi, log.end) {
                return Some(halt);
            }
            if self.r.hi + back > self.course.end {
                return Some(LoopExit::TimeLimit);
            }
            self.advance_clock(back);
            if back == tau {
                (self.r.u_a, self.r.u_b, self.r.h_b) = (-u_a, -s, 0.0);
                return Some(LoopExit::Tie);
            }
            let w = u_b - g_b * back;
            let blow = (1.0 + m.e[a]) * u_a;
            let h = (h_b + 0.5 * back * (u_b + w)).max(0.0);
            let [hit, other] = newton::rates_after(m.e[a], m.kappa[a], u_a, w);
            self.land(a, [-u_a, w], [hit, other], blow, h, log);
            self.r.square = other * other + 2.0 * m.g[b] * h;
            return None;
        }
        if self.r.hi + tau > self.course.end {
            let forever = log.end == f64::INFINITY;
            return Some(if forever { LoopExit::Never } else { LoopExit::TimeLimit });
        }
        self.advance_clock(tau);
        let [hit, other] = newton::rates_after(m.e[b], m.kappa[b], s, w);
        self.a = b;
        self.land(b, [-s, w], [hit, other], s + hit, 0.5 * tau * climb, log);
        self.r.square = self.r.u_b * self.r.u_b + 2.0 * m.g[a] * self.r.h_b;
        None
    }

    fn advance_clock(&mut self, dt: f64) {
        let clock = Clock { hi: self.r.hi, lo: self.r.lo }.after(dt);
        (self.r.hi, self.r.lo) = (clock.hi, clock.lo);
    }

    /// Puts down an impact at the contact `at`, rates given as (own, other).
    fn land(
        &mut self,
        at: usize,
        before: [f64; 2],
        after: [f64; 2],
        blow: f64,
        other_gap: f64,
        log: &mut Log,
    ) {
        (self.r.u_a, self.r.u_b, self.r.h_b) = (after[0], after[1], other_gap);
        if at == 0 {
            self.r.jump += blow;
            self.r.moment += blow * (self.r.hi - self.course.from);
        }
        self.left -= 1;
        self.singly[at] += 1;
        if log.record {
            let clock = Clock { hi: self.r.hi, lo: self.r.lo };
            log.collisions.push(in_order(clock, at, before, after, blow, other_gap));
        }
    }
}

/// Collisions by which it pays to go into a register: putting a run there and back costs about as much as a few.
const WORTH: usize = 16;

impl<T: Real> Roles<T> {
    /// As they stand in a pool, with the number of collisions that are left.
    fn numbers(self, left: T) -> [T; 9] {
        let Self { u_a, u_b, h_b, square, hi, lo, jump, moment } = self;
        [u_a, u_b, h_b, square, hi, lo, jump, moment, left]
    }

    fn of([u_a, u_b, h_b, square, hi, lo, jump, moment, left]: [T; 9]) -> (Self, T) {
        (Self { u_a, u_b, h_b, square, hi, lo, jump, moment }, left)
    }
}

impl<T: Real> Course<T> {
    fn numbers(self) -> [T; 10] {
        let side = |Side { g, e, kappa, lift }: Side<T>| [g, e, kappa, lift];
        let [one, two] = self.sides.map(side);
        let [[a, b, c, d], [e, f, g, h]] = [one, two];
        [a, b, c, d, e, f, g, h, self.from, self.end]
    }

    fn of([a, b, c, d, e, f, g, h, from, end]: [T; 10]) -> Self {
        let side = |[g, e, kappa, lift]: [T; 4]| Side { g, e, kappa, lift };
        Self { sides: [side([a, b, c, d]), side([e, f, g, h])], from, end }
    }
}

/// Runs side by side, each in the middle of plain collisions or stopped.
#[derive(Debug, Default)]
pub(crate) struct Pool {
    course: Columns<10>,
    /// The runs where some have stopped before the collision at contact 2, before that at contact 1, and where they go on: their
    /// roles, and how many collisions are left.
    stages: [Columns<9>; 3],
    /// A bit for each run that has stopped there.
    stopped: [u64; 2],
    /// A bit for each run that goes on, after an impact at contact 1.
    on: u64,
}

/// Runs in the lanes of registers.
struct Vector<S: Simd> {
    course: Course<Lanes<S>>,
    r: Roles<Lanes<S>>,
    left: Lanes<S>,
    /// Lanes that go on, a bit for each; the numbers in the others mean nothing.
    on: u64,
}

impl<S: Simd> Vector<S> {
    /// A collision after one at `A`; lanes for which it is not a plain one stop before it.
    #[inline(always)]
    fn hop<const A: usize>(&mut self, pool: &mut Pool) {
        let hop = self.r.hop::<A>(&self.course);
        let plain = Lanes::<S>::bits(hop.plain & self.left.like(0.0).below(self.left));
        let stop = self.on & !plain;
        if stop != 0 {
            pool.stages[A].store(&self.r.numbers(self.left));
            pool.stopped[A] |= stop;
            self.on &= plain;
        }
        self.r = hop.after;
        self.left = self.left + -1.0;
    }
}

impl Pool {
    /// Takes a run in whose loop plain collisions are next, if they may be and it is worth while.
    pub(crate) fn put(&mut self, run: usize, clatter: &LocalCollisions) -> bool {
        let suits = clatter.a == 0 && clatter.left >= WORTH;
        if suits {
            self.course.put(run, clatter.course.numbers());
            self.stages[2].put(run, clatter.r.numbers(clatter.left as f64));
            self.on |= 1 << run;
        }
        suits
    }

    /// Gives a run back that has stopped.
    pub(crate) fn take(&mut self, run: usize, clatter: &mut LocalCollisions) {
        let a = usize::from(self.stopped[1] >> run & 1 == 1);
        self.stopped[a] &= !(1 << run);
        let (r, left) = Roles::of(self.stages[a].get(run));
        (clatter.r, clatter.left, clatter.a) = (r, left as usize, a);
    }

    /// The runs that go on, a bit for each.
    pub(crate) fn on(&self) -> u64 {
        self.on
    }

    /// Plain collisions, until one of the runs has come to something else.
    #[inline(always)]
    pub(crate) fn alternate<S: Simd>(&mut self, simd: S) {
        let all = self.on;
        let course = Course::of(self.course.load(simd));
        let (r, left) = Roles::of(self.stages[2].load(simd));
        let mut vector = Vector { course, r, left, on: all };
        while vector.on == all {
            vector.hop::<0>(self);
            vector.hop::<1>(self);
        }
        self.on = vector.on;
        self.stages[2].store(&vector.r.numbers(vector.left));
    }
}

/// One collision of the plain kind; if the next is not, nothing changes.
#[inline(always)]
fn one_hop<const A: usize>(
    r: &mut Roles<f64>,
    course: &Course<f64>,
    slot: Option<&mut Collision>,
) -> bool {
    let hop = r.hop::<A>(course);
    if hop.plain {
        *r = hop.after;
        if let Some(slot) = slot {
            let clock = Clock { hi: r.hi, lo: r.lo }.renormalised();
            let after = [r.u_a, r.u_b];
            let blow = hop.s + r.u_a;
            *slot = in_order(clock, 1 - A, [-hop.s, hop.w], after, blow, r.h_b);
        }
    }
    hop.plain
}

/// A collision at `a`, its rates given as (own, other).
#[inline]
fn in_order(
    elapsed: Clock,
    a: usize,
    before: [f64; 2],
    after: [f64; 2],
    jump: f64,
    other_gap: f64,
) -> Collision {
    let turn = |pair: [f64; 2]| if a == 0 { pair } else { [pair[1], pair[0]] };
    Collision { elapsed, contact: a, before: turn(before), after: turn(after), jump, other_gap }
}

/// Flies on to the time limit.
fn rest_of_time(m: &FrozenModel, gaps: &mut Gaps, sum: &mut Impulses, log: &mut Log) {
    let left = log.left().max(0.0);
    *gaps = fly_for(m.g, gaps, left);
    advance(sum, left);
    log.clock = log.clock.after(left);
}

/// Impulses stay, their path grows.
pub(crate) fn advance(sum: &mut Impulses, dt: f64) {
    for i in 0..2 {
        sum.path[i] += sum.jump[i] * dt;
    }
}

/// The sum of the bounces at a, if the motion from here on consists of nothing else.
fn bounces(m: &FrozenModel, a: usize, gaps: &Gaps, now: f64, end: f64) -> Option<LoopExit> {
    let duration = m.bounce_tail(a, gaps)?;
    (now + duration <= end).then_some(LoopExit::Bounce { contact: a, duration })
}

/// How the motion from here on is summed, if it is: bouncing, clattering, or the end of the digits.
fn accumulates(m: &FrozenModel, at: &LocalCollisions, end: f64) -> Option<LoopExit> {
    let (a, gaps, now) = (at.a, &at.gaps(), at.r.hi);
    if let Some(halt) = bounces(m, a, gaps, now, end) {
        return Some(halt);
    }
    let tail = m.clatter_tail(a, gaps);
    let certain = || m.certainly_clatters(a, gaps);
    if let Some(tail) = tail
        && tail.error <= TAIL * now
        && now + tail.duration <= end
        && certain()
    {
        return Some(LoopExit::Clatter(tail));
    }
    if parabola_touchdown(at.r.h_b, at.r.u_b, m.g[1 - a]) > SHORT * now {
        return None;
    }
    let certain = tail.filter(|_| certain());
    let remaining = certain.map(|tail| tail.duration).or_else(|| time_to_rest(m, gaps))?;
    (remaining <= REACHED * now)
        .then(|| LoopExit::Reached { remaining, self_similar: repeats(m, a, gaps) })
}

/// A time within which both contacts come to rest, by the energy argument, if they do at all: λ =
/// D⁻¹(g_1, g_2) > 0 and every impact loses energy. The weakest pull decides: of a contact in the air, or of
/// one while the other is held. In s.
pub(crate) fn time_to_rest(m: &FrozenModel, gaps: &Gaps) -> Option<f64> {
    let force = m.share(m.g);
    if !(force[0] > 0.0 && force[1] > 0.0) {
        return None;
    }
    let speed = (0..2)
        .map(|i| (gaps.u[i] * gaps.u[i] + 2.0 * m.g[i].abs() * gaps.h[i]).sqrt())
        .fold(0.0, f64::max);
    let pulls = [m.g[0], m.g[1], m.held_gravity(0), m.held_gravity(1)];
    let weakest = pulls.into_iter().filter(|g| *g > 0.0).fold(f64::INFINITY, f64::min);
    Some(8.0 * speed / (weakest * (1.0 - m.e[0].max(m.e[1]))))
}

/// Whether two more collisions lead back to the same state on a smaller scale.
fn repeats(m: &FrozenModel, a: usize, gaps: &Gaps) -> bool {
    let shape = |gaps: &Gaps| {
        let (u_a, u_b) = (gaps.u[a], gaps.u[1 - a]);
        [u_a / u_b, m.g[1 - a] * gaps.h[1 - a] / (u_b * u_b)]
    };
    let mut later = *gaps;
    for _ in 0..2 {
        let (contact, tau, _) = next_landing(m, &later);
        later = fly_for(m.g, &later, tau);
        later.h[contact] = 0.0;
        if later.u[contact] >= 0.0 {
            return false;
        }
        later.u = newton::newton(m, contact, later.u);
    }
    let (before, after) = (shape(gaps), shape(&later));
    later.h[a] == 0.0
        && (0..2).all(|k| (after[k] - before[k]).abs() <= SELF_SIMILAR * before[k].abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::local_model::LocalModel;
    use crate::options::Options;

    /// The collisions up to the end of the loop.
    fn collisions(g: [f64; 2], psi: [f64; 2], e: [f64; 2], start: Gaps) -> Vec<Collision> {
        let m = &FrozenModel::new(&LocalModel::new(g, psi, [0.3, -0.2], e).expect("a local model"));
        let (mut gaps, mut sum) = (start, Impulses::default());
        let mut log = Log::new(&Options::default(), 2, &|| false);
        let begun = LocalCollisions::begin(m, &mut gaps, &mut sum, &mut log);
        let mut collisions = begun.expect("an impact");
        while collisions.next(m, &mut log).is_none() {
            collisions.alternate(&mut log);
        }
        log.collisions
    }

    /// z = u_a/|u_b| after an impact at a, p_i = (1+e_i)ψ_i. √(p_1p_2) is a little below √e_1 + √e_2: there are many impacts.
    #[test]
    fn without_gravity_the_ratio_z_of_the_speeds_becomes_e_over_p_minus_z() {
        let (psi, e) = ([0.84, 0.88], [0.3, 0.36]);
        let all = collisions([0.0; 2], psi, e, Gaps { h: [0.0, 1.0], u: [0.1, -1.0] });
        assert!(all.len() > 20);
        let z = |k: &Collision| k.after[k.contact] / -k.after[1 - k.contact];
        for pair in all.windows(2) {
            let b = pair[1].contact;
            let expected = e[b] / ((1.0 + e[b]) * psi[b] - z(&pair[0]));
            assert!((z(&pair[1]) / expected - 1.0).abs() < 1e-12, "{} {expected}", z(&pair[1]));
        }
    }

    /// E = ½ u·D⁻¹u + D⁻¹g·h with D_11 = 1, D_12 = −ψ_1, D_22 = ψ_1/ψ_2. An impact at i takes (1 − e_i²)w²/(2D_ii).
    #[test]
    fn energy_is_constant_in_flight_and_an_impact_takes_its_share() {
        let (g, psi, e, d) = ([1.0, 1.3], [0.6, 0.4], [0.9, 0.8], [1.0, 1.5]);
        let dual = |x: [f64; 2], y: [f64; 2]| {
            let mixed = psi[0] * (x[0] * y[1] + x[1] * y[0]);
            (d[1] * x[0] * y[0] + mixed + x[1] * y[1]) / (d[1] - psi[0] * psi[0])
        };
        let energy = |k: &Collision, u: [f64; 2]| {
            let h = if k.contact == 0 { [0.0, k.other_gap] } else { [k.other_gap, 0.0] };
            0.5 * dual(u, u) + dual(g, h)
        };
        let all = collisions(g, psi, e, Gaps { h: [0.3, 0.5], u: [0.2, -0.1] });
        assert!(all.len() > 20);
        for pair in all.windows(2) {
            let (k, i) = (&pair[1], pair[1].contact);
            let lost = (1.0 - e[i] * e[i]) * k.before[i] * k.before[i] / (2.0 * d[i]);
            let [start, end] = [energy(&pair[0], pair[0].after), energy(k, k.before)];
            assert!((end - start).abs() <= 1e-13 * start, "{start} {end}");
            assert!((end - energy(k, k.after) - lost).abs() <= 1e-13 * end);
        }
    }
}
