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

use crate::clock::Clock;
use crate::flight::parabola_touchdown;
use crate::impact;
use crate::log::{Collision, Log};
use crate::tolerance::{REACHED, SELF_SIMILAR, SIMULTANEOUS, TAIL};
use crate::zeno::{ClatterTail, Frozen, Gaps, Impulses};

/// Why a sequence of collisions is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Halt {
    /// A bounce tail at this contact, of this duration.
    Bounce {
        contact: usize,
        duration: f64,
    },
    /// A certified clattering tail.
    Clatter(ClatterTail),
    /// A bounce tail at this contact that the time limit cuts, where nothing is recorded: its bounces may be
    /// skipped.
    Skip {
        contact: usize,
    },
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
/// τ relative to the elapsed time below which the accumulation may be all but reached.
const SHORT: f64 = 1e-16;

/// Which contact lands next, when, and whether the other lands at the same instant.
fn next_landing(m: &Frozen, gaps: &Gaps) -> (usize, f64, bool) {
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

/// Flies and collides until something other than a simple collision happens. Both contacts start in the
/// air or leaving it (u ≥ 0 where h = 0).
pub(crate) fn fly(m: &Frozen, gaps: &mut Gaps, sum: &mut Impulses, log: &mut Log) -> Halt {
    let (contact, tau, tie) = next_landing(m, gaps);
    if log.clock.hi + tau > log.end {
        rest_of_time(m, gaps, sum, log);
        return Halt::TimeLimit;
    }
    if tau == f64::INFINITY {
        return Halt::Never;
    }
    let before = *gaps;
    *gaps = fly_for(m.g, gaps, tau);
    gaps.h[contact] = 0.0;
    gaps.u[contact] =
        -(before.u[contact] * before.u[contact] + 2.0 * m.g[contact] * before.h[contact]).sqrt();
    log.clock = log.clock.after(tau);
    advance(sum, tau);
    if tie {
        gaps.h = [0.0; 2];
        return Halt::Tie;
    }
    if log.chunk() == 0 {
        return Halt::EventLimit;
    }
    let rates = gaps.u;
    gaps.u = impact::newton(m, contact, rates);
    let jump = (1.0 + m.e[contact]) * -rates[contact];
    sum.jump[contact] += jump;
    log.hits += 1;
    if log.record {
        log.collisions.push(Collision {
            elapsed: log.clock,
            contact,
            before: rates,
            after: gaps.u,
            jump,
            other_gap: gaps.h[1 - contact],
        });
        collide::<true>(m, contact, gaps, sum, log)
    } else {
        collide::<false>(m, contact, gaps, sum, log)
    }
}

/// What the loop needs of one contact, together.
#[derive(Clone, Copy)]
struct Side {
    g: f64,
    e: f64,
    kick: f64,
    /// 2g
    weight: f64,
    /// 2(1+e)ψ g of the other contact.
    lift: f64,
}

/// The state of the loop in roles: contact a was hit last.
#[derive(Clone, Copy)]
struct Roles {
    a: usize,
    u_a: f64,
    u_b: f64,
    h_b: f64,
    /// s² of the next landing of b.
    square: f64,
    clock: Clock,
    /// Own-rate jumps of contact 1, and their sum weighted with the time since the loop began; those of
    /// contact 2 follow from its gap.
    jump: f64,
    moment: f64,
    /// Collisions until the next look at the limits and for a sum.
    left: usize,
}

/// What does not change in the loop.
struct Course {
    sides: [Side; 2],
    /// Elapsed time at which the loop began, in s.
    from: f64,
    /// The time limit, or the largest double: one comparison tells a flight beyond it and one without end.
    end: f64,
}

fn collide<const RECORD: bool>(
    m: &Frozen,
    contact: usize,
    gaps: &mut Gaps,
    sum: &mut Impulses,
    log: &mut Log,
) -> Halt {
    let sides = [0, 1].map(|i| Side {
        g: m.g[i],
        e: m.e[i],
        kick: m.kick[i],
        weight: 2.0 * m.g[i],
        lift: 2.0 * m.kick[i] * m.g[1 - i],
    });
    let course = Course { sides, from: log.clock.hi, end: log.end.min(f64::MAX) };
    let (u_a, u_b, h_b) = (gaps.u[contact], gaps.u[1 - contact], gaps.h[1 - contact]);
    let square = u_b * u_b + sides[1 - contact].weight * h_b;
    let (clock, left) = (log.clock, 0);
    let mut r = Roles { a: contact, u_a, u_b, h_b, square, clock, jump: 0.0, moment: 0.0, left };
    let (first, mut granted) = (log.hits, 0);
    let stop = loop {
        if r.left == 0 {
            log.hits += granted;
            granted = 0;
            if let Some(halt) = accumulates(m, &r, log.end, !RECORD) {
                break halt;
            }
            granted = log.chunk().min(1 + (log.hits - first) / PATIENCE);
            r.left = granted;
            if granted == 0 {
                break Halt::EventLimit;
            }
        }
        if let Some(halt) = r.next::<RECORD>(m, &course, log) {
            break halt;
        }
        if r.a == 0 {
            course.alternate::<RECORD>(&mut r, &mut log.collisions);
        }
    };

    log.hits += granted - r.left;
    log.clock = r.clock.renormalised();
    let (start, t) = (*gaps, log.clock.since(clock));
    *gaps = r.gaps();
    advance(sum, t);
    let path = r.jump * (r.clock.hi - course.from) - r.moment;
    sum.jump[0] += r.jump;
    sum.path[0] += path;
    if gaps.h[1] < f64::INFINITY {
        let (g, h, u) = (m.g[1], start.h[1], start.u[1]);
        sum.jump[1] += gaps.u[1] - (u - g * t) + m.psi[0] * r.jump;
        sum.path[1] += gaps.h[1] - (h + t * (u - 0.5 * g * t)) + m.psi[0] * path;
    }
    if stop == Halt::TimeLimit {
        rest_of_time(m, gaps, sum, log);
    }
    stop
}

impl Course {
    /// Collisions in turn, as long as nothing else happens and no look is due. Starts and ends after an
    /// impact; the first is at contact 1.
    ///
    /// Written out for both roles, so that none is looked up.
    #[inline(never)]
    fn alternate<const RECORD: bool>(&self, roles: &mut Roles, collisions: &mut Vec<Collision>) {
        let mut r = *roles;
        let a = loop {
            if !r.hop::<RECORD, 0>(self, collisions) {
                break 0;
            }
            if !r.hop::<RECORD, 1>(self, collisions) {
                break 1;
            }
        };
        r.a = a;
        *roles = r;
    }
}

impl Roles {
    fn gaps(&self) -> Gaps {
        let mut gaps = Gaps::default();
        let (a, b) = (self.a, 1 - self.a);
        (gaps.u[a], gaps.u[b], gaps.h[b]) = (self.u_a, self.u_b, self.h_b);
        gaps
    }

    /// The next collision, if it is of the plain kind: b falls on the terrain before a is back, within the
    /// limits. Otherwise nothing changes.
    #[inline(always)]
    fn hop<const RECORD: bool, const A: usize>(
        &mut self,
        course: &Course,
        collisions: &mut Vec<Collision>,
    ) -> bool {
        let (of_a, of_b) = (&course.sides[A], &course.sides[1 - A]);
        let (u_a, u_b, h_b) = (self.u_a, self.u_b, self.h_b);
        if u_b >= 0.0 || self.left == 0 {
            return false;
        }
        // 2K g_aτ has a division of its own, ahead of that of τ, so that the next square root waits for one
        // addition only; it adds to a square, and nothing cancels.
        let s = self.square.sqrt();
        let (twice, sum) = (2.0 * h_b, s - u_b);
        let gain = of_b.lift * twice * s / sum;
        if !(gain >= 0.0) {
            return false;
        }
        let tau = twice / sum;
        let w = u_a - of_a.g * tau;
        let climb = u_a + w;
        if climb <= CLOSE * u_a {
            return false;
        }
        let clock = self.clock.unnormalised_after(tau);
        if !(clock.hi <= course.end) {
            return false;
        }
        let kick = of_b.kick * s;
        let d = u_a - kick;
        let hit = of_b.e * s;
        self.square = d * d + gain;
        self.clock = clock;
        if A == 1 {
            let blow = s + hit;
            self.jump += blow;
            self.moment += blow * (clock.hi - course.from);
        }
        self.left -= 1;
        (self.u_a, self.u_b, self.h_b) = (hit, w - kick, 0.5 * tau * climb);
        if RECORD {
            let (after, h) = ([self.u_a, self.u_b], self.h_b);
            collisions.push(in_order(clock.renormalised(), 1 - A, [-s, w], after, s + hit, h));
        }
        true
    }

    /// The next event, whatever it is.
    #[inline(never)]
    fn next<const RECORD: bool>(
        &mut self,
        m: &Frozen,
        course: &Course,
        log: &mut Log,
    ) -> Option<Halt> {
        let (a, b) = (self.a, 1 - self.a);
        let (u_a, u_b, h_b) = (self.u_a, self.u_b, self.h_b);
        let (g_a, g_b) = (m.g[a], m.g[b]);
        let tau = parabola_touchdown(h_b, u_b, g_b);
        let s = self.square.max(0.0).sqrt();
        let w = u_a - g_a * tau;
        let climb = u_a + w;
        let back = 2.0 * u_a / g_a;
        if climb <= CLOSE * u_a && back <= tau && g_a > 0.0 {
            // a is back before b lands.
            if let Some(halt) = bounces(m, a, &self.gaps(), self.clock.hi, log.end, !RECORD) {
                return Some(halt);
            }
            if self.clock.hi + back > course.end {
                return Some(Halt::TimeLimit);
            }
            self.clock = self.clock.after(back);
            if back == tau {
                (self.u_a, self.u_b, self.h_b) = (-u_a, -s, 0.0);
                return Some(Halt::Tie);
            }
            let w = u_b - g_b * back;
            let blow = (1.0 + m.e[a]) * u_a;
            let h = (h_b + 0.5 * back * (u_b + w)).max(0.0);
            let (hit, other) = (m.e[a] * u_a, w - m.kick[a] * u_a);
            self.land::<RECORD>(a, [-u_a, w], [hit, other], blow, h, course, log);
            self.square = other * other + course.sides[b].weight * h;
            return None;
        }
        if self.clock.hi + tau > course.end {
            let forever = log.end == f64::INFINITY;
            return Some(if forever { Halt::Never } else { Halt::TimeLimit });
        }
        self.clock = self.clock.after(tau);
        let (kick, hit) = (m.kick[b] * s, m.e[b] * s);
        self.a = b;
        self.land::<RECORD>(b, [-s, w], [hit, w - kick], s + hit, 0.5 * tau * climb, course, log);
        self.square = self.u_b * self.u_b + course.sides[a].weight * self.h_b;
        None
    }

    /// Puts down an impact at the contact `at`, rates given as (own, other).
    #[expect(clippy::too_many_arguments, reason = "an impact has so many sides")]
    fn land<const RECORD: bool>(
        &mut self,
        at: usize,
        before: [f64; 2],
        after: [f64; 2],
        blow: f64,
        other_gap: f64,
        course: &Course,
        log: &mut Log,
    ) {
        (self.u_a, self.u_b, self.h_b) = (after[0], after[1], other_gap);
        if at == 0 {
            self.jump += blow;
            self.moment += blow * (self.clock.hi - course.from);
        }
        self.left -= 1;
        if RECORD {
            log.collisions.push(in_order(self.clock, at, before, after, blow, other_gap));
        }
    }
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
fn rest_of_time(m: &Frozen, gaps: &mut Gaps, sum: &mut Impulses, log: &mut Log) {
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
fn bounces(m: &Frozen, a: usize, gaps: &Gaps, now: f64, end: f64, skip: bool) -> Option<Halt> {
    let duration = m.bounce_tail(a, gaps)?;
    if now + duration <= end {
        return Some(Halt::Bounce { contact: a, duration });
    }
    let several = end - now > duration * (1.0 - m.e[a] * m.e[a]);
    (skip && several).then_some(Halt::Skip { contact: a })
}

/// How the motion from here on is summed, if it is: bouncing, clattering, or the end of the digits.
fn accumulates(m: &Frozen, r: &Roles, end: f64, skip: bool) -> Option<Halt> {
    let (a, gaps, now) = (r.a, &r.gaps(), r.clock.hi);
    if let Some(halt) = bounces(m, a, gaps, now, end, skip) {
        return Some(halt);
    }
    let tail = m.clatter_tail(a, gaps);
    let certain = || m.certainly_clatters(a, gaps);
    if let Some(tail) = tail
        && tail.error <= TAIL * now
        && now + tail.duration <= end
        && certain()
    {
        return Some(Halt::Clatter(tail));
    }
    if parabola_touchdown(r.h_b, r.u_b, m.g[1 - a]) > SHORT * now {
        return None;
    }
    let certain = tail.filter(|_| certain());
    let remaining = certain.map(|tail| tail.duration).or_else(|| time_to_rest(m, gaps))?;
    (remaining <= REACHED * now)
        .then(|| Halt::Reached { remaining, self_similar: repeats(m, a, gaps) })
}

/// A time within which both contacts come to rest, by the energy argument, if they do at all: λ =
/// D⁻¹(g_1, g_2) > 0 and every impact loses energy. The weakest pull decides: of a contact in the air, or of
/// one while the other is held. In s.
pub(crate) fn time_to_rest(m: &Frozen, gaps: &Gaps) -> Option<f64> {
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
fn repeats(m: &Frozen, a: usize, gaps: &Gaps) -> bool {
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
        later.u = impact::newton(m, contact, later.u);
    }
    let (before, after) = (shape(gaps), shape(&later));
    later.h[a] == 0.0
        && (0..2).all(|k| (after[k] - before[k]).abs() <= SELF_SIMILAR * before[k].abs())
}
