//! Collisions of the local model, computed one after the other until the rest of their infinite sequence can be summed.
//!
//! The contact just hit is called a, the other contact b, as in [Or & Rimon 2008, (7)]. If b lands next, after the time τ and with the
//! speed s:
//!
//! ```text
//! s² = u_b² + 2g_b h_b,    τ = 2h_b/(s − u_b)    (u_b < 0)
//! u_a' = e_b s,   u_b' = w − K,   h_b' = τ(u_a + w)/2,   w = u_a − g_aτ,  K = (1+e_b)ψ_b s
//! s'² = (u_a − K)² + 2K g_aτ
//! ```
//!
//! Primed values belong to the state after the impact at b, in which b has the role of a. The last line is s'² = u_b'² + 2g_a h_b'
//! multiplied out. After τ is known, it needs one multiplication and one addition, so that a collision costs little more than its square
//! root and its division.

use crate::collisions::log::{Collision, Log};
use crate::collisions::regular::{self, REGULAR, RegularSum};
use crate::flight::parabola_touchdown;
use crate::impact::newton;
use crate::math::clock::{Clock, unnormalised_after};
use crate::tolerance::{
    LANDING_ORDER_CLOSE, NEARLY_REACHED, REACHED, SELF_SIMILAR, SIMULTANEOUS, TAIL,
};
use crate::zeno::{ClatterTail, FrozenModel, Gaps, Impulses, TailBound};

/// Why the loop over collisions ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LoopExit {
    /// A bounce tail at this contact, of this duration.
    Bounce {
        contact: usize,
        duration: f64,
    },
    /// The full model only: all further bounces of this contact have been summed.
    Settled {
        contact: usize,
    },
    /// A certified clattering tail.
    Clatter(ClatterTail),
    /// The sum of a regular motion up to rest of both contacts.
    Regular(RegularSum),
    /// Both contacts come to rest within `remaining`, which is below the rounding error of the time.
    Reached {
        remaining: f64,
        self_similar: bool,
    },
    /// Both contacts land at the same instant, before any impact. In the full model also: after an impact the gap rate of the contact that
    /// is hit is zero.
    Tie,
    /// The full model only: the rest of the motion is so short that the geometry may be frozen.
    Freeze,
    TimeLimit,
    /// The event limit; or the run was cancelled; or (full model) a flight is so long that rounding makes the position of the body unknown.
    EventLimit,
    /// No contact lands any more.
    Never,
}

impl LoopExit {
    /// The time, in s, after which both contacts rest, if the loop ends with that. The bound of what remains where the end is nearly reached is
    /// crude, but below the rounding error of the time.
    pub(crate) fn time_to_rest(&self) -> Option<f64> {
        match self {
            Self::Clatter(tail) => Some(tail.duration),
            Self::Regular(sum) => Some(sum.duration),
            Self::Reached { remaining, .. } => Some(0.5 * remaining),
            _ => None,
        }
    }
}

/// After n collisions, the next test for a tail is made 1 + n/CHECKS collisions later. The test costs as much as a collision. So about
/// 1/CHECKS of the collisions is simulated although it could have been summed.
const CHECKS: usize = 16;
/// Number of first collisions after each of which a tail is tested for: in short runs, an attempt that comes late costs more than the test.
const WATCHED: usize = 64;
/// Number of collisions by which the record grows at a time; even. If every collision checked whether the list has to grow, the check would
/// cost half as much as the collision.
const BLOCK: usize = 64;

/// The contact that lands next, the time until then, and whether the other contact lands at the same instant.
fn next_landing(m: &FrozenModel, gaps: &Gaps) -> (usize, f64, bool) {
    let t = [0, 1].map(|i| parabola_touchdown(gaps.h[i], gaps.u[i], m.g[i]));
    let first = usize::from(t[1] < t[0]);
    (first, t[first], are_one(t[0], t[1]))
}

/// Returns true if two contacts land together: their times of flight differ by rounding errors only. For example, gaps in the ratio of the
/// components of gravity into the two grounds close at the same instant if the body falls from rest without turning. Rounding errors must
/// not decide which contact lands first.
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

/// Constants of one contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    g: f64,
    e: f64,
    kappa: f64,
    /// 2(1+e)ψ g of the other contact.
    lift: f64,
    /// 2/(g(1−e)), and half the fall of the other contact, see [`FrozenModel`].
    bounce: f64,
    fall: f64,
    clattering: TailBound,
}

/// The state of the loop. Contact a was hit last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalLoopState {
    u_a: f64,
    u_b: f64,
    h_b: f64,
    /// s² of the next landing of b.
    square: f64,
    /// The clock hi + lo. `lo` may exceed half an ulp of `hi`.
    hi: f64,
    lo: f64,
    /// Sum of the own-rate jumps (1+e)|w| of contact 1, and the same sum with each jump weighted by the time since the loop began. The sums
    /// of contact 2 follow from its gap.
    jump: f64,
    moment: f64,
}

/// Constants of the loop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalConstants {
    sides: [Side; 2],
    /// Elapsed time at which the loop began, in s.
    from: f64,
    /// The time limit, or the largest double if there is none. So one comparison detects both a flight beyond the limit and a flight
    /// without end.
    end: f64,
}

/// A candidate for a plain collision.
struct LocalPlainCollision {
    after: LocalLoopState,
    /// Whether the collision is plain: b lands before a does, and within the time limit.
    plain: bool,
    /// Landing speed of b, and the rate of a at that instant.
    s: f64,
    w: f64,
}

impl LocalLoopState {
    fn left(&self, end: f64) -> f64 {
        Clock { hi: self.hi, lo: self.lo }.until(end)
    }

    /// Whether a tail may end the loop after an impact at `a`, see [`accumulates`]: tests without root and division.
    #[inline(always)]
    fn nears_end(&self, a: usize, constants: &LocalConstants) -> bool {
        let (of_a, of_b) = (&constants.sides[a], &constants.sides[1 - a]);
        let Self { u_a, u_b, h_b, square, hi, .. } = *self;
        let t = of_a.bounce * u_a;
        let bounces = (of_a.g > 0.0) & (h_b + t * (u_b - t * of_a.fall) >= 0.0);
        // The next flight is τ = 2h_b/(s − u_b) ≥ √2 h_b/√(s² + u_b²).
        let (last, speed) = (NEARLY_REACHED * hi, u_b * u_b);
        let reached = 2.0 * h_b * h_b <= last * last * (square + speed);
        bounces || reached || of_b.clattering.may_be_summed(u_a, u_b, h_b, 2.0 * TAIL * hi)
    }

    /// The next collision. `A`: the contact hit last; the other one lands.
    #[inline(always)]
    fn plain_collision<const A: usize>(&self, constants: &LocalConstants) -> LocalPlainCollision {
        let (of_a, of_b) = (&constants.sides[A], &constants.sides[1 - A]);
        let (u_a, u_b, h_b) = (self.u_a, self.u_b, self.h_b);
        // 2K g_aτ is divided on its own, ahead of τ, so that the next square root waits for one addition only. It adds to a square:
        // nothing cancels.
        let s = self.square.sqrt();
        let (twice, sum) = (h_b * 2.0, s - u_b);
        let gain = of_b.lift * twice * s / sum;
        let tau = twice / sum;
        let w = u_a - of_a.g * tau;
        let climb = u_a + w;
        let (hi, lo) = unnormalised_after(self.hi, self.lo, tau);
        let plain = (u_b < 0.0)
            & (0.0 <= gain)
            & (u_a * LANDING_ORDER_CLOSE < climb)
            & (lo <= constants.end - hi);

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
            after.moment = self.moment + blow * (hi - constants.from);
        }
        LocalPlainCollision { after, plain, s, w }
    }
}

/// The loop over collisions in progress.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LocalCollisions {
    constants: LocalConstants,
    /// The contact hit last.
    a: usize,
    r: LocalLoopState,
    /// Number of collisions left until the limits are checked again and a tail is tested for; and the number that was left right after the
    /// last check.
    left: usize,
    granted: usize,
    /// Whether a tail may end the loop now.
    near: bool,
    /// Whether this is asked after each collision: the first ones.
    watched: bool,
    /// Number of collisions after which a sum of a regular motion is tried.
    regular: usize,
    /// State, clock and number of collisions where the loop began.
    start: Gaps,
    clock: Clock,
    first: usize,
    /// Number of impacts of each contact since the loop began, without the plain collisions.
    singly: [usize; 2],
}

impl LocalCollisions {
    /// Simulates the first touchdown and its impact. An error means that the loop ends before.
    pub(crate) fn begin(
        m: &FrozenModel,
        gaps: &mut Gaps,
        sum: &mut Impulses,
        log: &mut Log,
    ) -> Result<Self, LoopExit> {
        let (contact, tau, tie) = next_landing(m, gaps);
        if tau > log.left() {
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
            bounce: m.bounce[i],
            fall: m.fall[i],
            clattering: m.tail_bound(i),
        });
        let constants = LocalConstants { sides, from: log.clock.hi, end: log.end.min(f64::MAX) };
        let (u_a, u_b, h_b) = (gaps.u[contact], gaps.u[1 - contact], gaps.h[1 - contact]);
        let square = u_b * u_b + 2.0 * m.g[1 - contact] * h_b;
        let Clock { hi, lo } = log.clock;
        let r = LocalLoopState { u_a, u_b, h_b, square, hi, lo, jump: 0.0, moment: 0.0 };
        let (left, granted, near, watched) = (0, 0, false, true);
        let (start, clock, first) = (*gaps, log.clock, log.hits);
        let singly = [0; 2];
        Ok(Self {
            constants,
            a: contact,
            r,
            left,
            granted,
            near,
            watched,
            regular: REGULAR,
            start,
            clock,
            first,
            singly,
        })
    }

    /// Runs the loop, and updates gaps, impulses and clock.
    pub(crate) fn run(
        mut self,
        m: &FrozenModel,
        gaps: &mut Gaps,
        sum: &mut Impulses,
        log: &mut Log,
    ) -> LoopExit {
        let exit = loop {
            if let Some(exit) = self.next(m, log) {
                break exit;
            }
        };
        self.end(exit, m, gaps, sum, log)
    }

    /// Ends the loop: updates gaps, impulses and clock.
    fn end(
        self,
        halt: LoopExit,
        m: &FrozenModel,
        gaps: &mut Gaps,
        sum: &mut Impulses,
        log: &mut Log,
    ) -> LoopExit {
        log.hits += self.granted - self.left;
        let [one, two] = self.singly;
        // Plain collisions in turn begin at the contact that has not been hit last.
        let in_turn = log.hits - self.first > one + two;
        log.struck = [log.struck[0] || one > 0 || in_turn, log.struck[1] || two > 0 || in_turn];
        log.clock = Clock { hi: self.r.hi, lo: self.r.lo }.renormalised();
        let (start, t) = (self.start, log.clock.since(self.clock));
        *gaps = self.gaps();
        advance(sum, t);
        let path = self.r.jump * (self.r.hi - self.constants.from) - self.r.moment;
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

    /// Checks the limits and for a tail, if due; then simulates the plain collisions up to the next check or another event, and that event.
    fn next(&mut self, m: &FrozenModel, log: &mut Log) -> Option<LoopExit> {
        if self.left == 0 || self.near {
            log.hits += self.granted - self.left;
            (self.granted, self.left) = (0, 0);
            if self.r.nears_end(self.a, &self.constants)
                && let Some(halt) = accumulates(m, self, self.r.left(log.end))
            {
                return Some(halt);
            }
            self.near = false;
            let number = log.hits - self.first;
            if self.a == 0 && number >= self.regular {
                self.regular = 2 * number;
                let LocalLoopState { u_a, u_b, h_b, hi, .. } = self.r;
                let time = [hi, self.r.left(log.end)];
                if let Some(sum) = regular::local_sum(m, [u_a, u_b, h_b], time) {
                    return Some(LoopExit::Regular(sum));
                }
            }
            self.watched = number < WATCHED;
            let until_check = if self.watched { WATCHED } else { 1 + number / CHECKS };
            self.granted = log.chunk().min(until_check);
            self.left = self.granted;
            if self.granted == 0 {
                return Some(LoopExit::EventLimit);
            }
        }
        match (log.record, self.watched) {
            (true, true) => self.hop_on::<true, true>(&mut log.collisions),
            (true, false) => self.hop_on::<true, false>(&mut log.collisions),
            (false, true) => self.hop_on::<false, true>(&mut log.collisions),
            (false, false) => self.hop_on::<false, false>(&mut log.collisions),
        }
        if self.left == 0 || self.near { None } else { self.collide(m, log) }
    }

    /// Simulates plain collisions alternately at the two contacts, until another event or a check is due.
    ///
    /// The code of both contacts is written out, without indices.
    #[inline(never)]
    fn hop_on<const RECORD: bool, const WATCH: bool>(&mut self, collisions: &mut Vec<Collision>) {
        let (mut r, mut left, constants) = (self.r, self.left, &self.constants);
        let (first, most) = (collisions.len(), left);
        let mut near = false;
        if self.a == 1 {
            if RECORD {
                collisions.resize(first + 1, Collision::default());
            }
            let slot = if RECORD { collisions.last_mut() } else { None };
            match single_plain_collision::<1, WATCH>(&mut r, constants, slot) {
                None => {
                    collisions.truncate(first);
                    return;
                }
                Some(ends) => near = ends,
            }
            left -= 1;
        }
        self.a = 'plain: loop {
            if left == 0 || near {
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
                match single_plain_collision::<0, WATCH>(&mut r, constants, slots.next()) {
                    None => break 'plain 0,
                    Some(ends) => near = ends,
                }
                left -= 1;
                if WATCH && near {
                    break 'plain 1;
                }
                match single_plain_collision::<1, WATCH>(&mut r, constants, slots.next()) {
                    None => break 'plain 1,
                    Some(ends) => near = ends,
                }
                left -= 1;
                if WATCH && near {
                    break 'plain 0;
                }
            }
            if block % 2 == 1 {
                match single_plain_collision::<0, WATCH>(&mut r, constants, slots.next()) {
                    None => break 0,
                    Some(ends) => near = ends,
                }
                left -= 1;
                break 1;
            }
        };
        if RECORD {
            collisions.truncate(first + most - left);
        }
        (self.r, self.left, self.near) = (r, left, near);
    }

    #[inline(never)]
    fn collide(&mut self, m: &FrozenModel, log: &mut Log) -> Option<LoopExit> {
        let (a, b) = (self.a, 1 - self.a);
        let LocalLoopState { u_a, u_b, h_b, .. } = self.r;
        let (g_a, g_b) = (m.g[a], m.g[b]);
        let tau = parabola_touchdown(h_b, u_b, g_b);
        let s = self.r.square.max(0.0).sqrt();
        let w = u_a - g_a * tau;
        let climb = u_a + w;
        let back = 2.0 * u_a / g_a;
        if climb <= LANDING_ORDER_CLOSE * u_a && back <= tau && g_a > 0.0 {
            // Contact a lands before b does.
            if let Some(halt) = bounces(m, a, &self.gaps(), self.r.left(log.end)) {
                return Some(halt);
            }
            if back > self.r.left(self.constants.end) {
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
        if tau > self.r.left(self.constants.end) {
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

    /// Applies and records an impact at the contact `at`; rates are given as (own, other).
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
            self.r.moment += blow * (self.r.hi - self.constants.from);
        }
        self.left -= 1;
        self.singly[at] += 1;
        if log.record {
            let clock = Clock { hi: self.r.hi, lo: self.r.lo };
            log.collisions.push(in_order(clock, at, before, after, blow, other_gap));
        }
    }
}

/// Simulates the next collision if it is plain, and otherwise changes nothing. Whether a tail may end the loop after it, if that is watched;
/// `None`: it is not plain.
#[inline(always)]
fn single_plain_collision<const A: usize, const WATCH: bool>(
    r: &mut LocalLoopState,
    constants: &LocalConstants,
    slot: Option<&mut Collision>,
) -> Option<bool> {
    let next = r.plain_collision::<A>(constants);
    if !next.plain {
        return None;
    }
    *r = next.after;
    if let Some(slot) = slot {
        let clock = Clock { hi: r.hi, lo: r.lo }.renormalised();
        let after = [r.u_a, r.u_b];
        let blow = next.s + r.u_a;
        *slot = in_order(clock, 1 - A, [-next.s, next.w], after, blow, r.h_b);
    }
    Some(WATCH && r.nears_end(1 - A, constants))
}

/// A collision at `a`; rates are given as (own, other).
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

/// Simulates the flight up to the time limit.
fn rest_of_time(m: &FrozenModel, gaps: &mut Gaps, sum: &mut Impulses, log: &mut Log) {
    let left = log.left().max(0.0);
    *gaps = fly_for(m.g, gaps, left);
    advance(sum, left);
    log.clock = log.clock.after(left);
}

/// Adds a flight: impulses stay, their time integrals grow.
pub(crate) fn advance(sum: &mut Impulses, dt: f64) {
    for i in 0..2 {
        sum.path[i] += sum.jump[i] * dt;
    }
}

/// The bounce tail at a, if the motion consists of nothing else until its end.
fn bounces(m: &FrozenModel, a: usize, gaps: &Gaps, left: f64) -> Option<LoopExit> {
    let duration = m.bounce_tail(a, gaps)?;
    (duration <= left).then_some(LoopExit::Bounce { contact: a, duration })
}

/// The tail that ends the loop here, if there is one: bouncing, clattering, or a remaining time below the rounding error of the time.
fn accumulates(m: &FrozenModel, at: &LocalCollisions, left: f64) -> Option<LoopExit> {
    let (a, gaps, now) = (at.a, &at.gaps(), at.r.hi);
    if let Some(halt) = bounces(m, a, gaps, left) {
        return Some(halt);
    }
    let tail = m.clatter_tail(a, gaps);
    let certain = || m.certainly_clatters(a, gaps);
    if let Some(tail) = tail
        && tail.error <= TAIL * now
        && tail.duration <= left
        && certain()
    {
        return Some(LoopExit::Clatter(tail));
    }
    if parabola_touchdown(at.r.h_b, at.r.u_b, m.g[1 - a]) > NEARLY_REACHED * now {
        return None;
    }
    let certain = tail.filter(|_| certain());
    let remaining = certain.map(|tail| tail.duration).or_else(|| time_to_rest(m, gaps))?;
    (remaining <= REACHED * now)
        .then(|| LoopExit::Reached { remaining, self_similar: repeats(m, a, gaps) })
}

/// Upper bound of the time until both contacts rest, in s, from the energy: λ = D⁻¹(g_1, g_2) > 0, and every impact loses energy. It uses
/// the smallest acceleration into the ground: of a contact while both are in the air, or of one contact while the other is held.
pub(crate) fn time_to_rest(m: &FrozenModel, gaps: &Gaps) -> Option<f64> {
    let force = m.solve_coupled(m.g);
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

/// Returns true if the state after two more collisions is the present state on a smaller scale.
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
    use crate::body::local_model::{LocalModel, LocalModelFields};
    use crate::options::Options;

    /// The collisions up to the end of the loop.
    fn collisions(g: [f64; 2], psi: [f64; 2], e: [f64; 2], start: Gaps) -> Vec<Collision> {
        let m = &FrozenModel::new(
            &LocalModel::new(LocalModelFields {
                gravity: g,
                psi,
                phi: [0.3, -0.2],
                restitution: e,
            })
            .expect("a local model"),
        );
        let (mut gaps, mut sum) = (start, Impulses::default());
        let mut log = Log::new(&Options::default(), 2, &|| false);
        let begun = LocalCollisions::begin(m, &mut gaps, &mut sum, &mut log);
        let mut collisions = begun.expect("an impact");
        while collisions.next(m, &mut log).is_none() {}
        log.collisions
    }

    /// z = u_a/|u_b| after an impact at a, p_i = (1+e_i)ψ_i. √(p_1p_2) is a little below √e_1 + √e_2, so that there are many impacts.
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
