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
use crate::tolerance::{REACHED, SELF_SIMILAR, TAIL, TRY_TAIL};
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
/// Share of gravity 2gh/(u² + 2gh) in the coming flight above which a clattering tail is not thought of.
const SHARE: f64 = 1e-2;
/// After n looks for a sum in vain, n²/EAGER collisions go by before the next: close to the bounds of
/// clattering the filter lets all collisions pass long before there is a sum.
const EAGER: u32 = 16;
/// τ relative to the elapsed time below which the accumulation may be all but reached.
const SHORT: f64 = 1e-16;

/// Which contact lands next, when, and whether the other lands at the same instant.
fn next_landing(m: &Frozen, gaps: &Gaps) -> (usize, f64, bool) {
    let t = [0, 1].map(|i| parabola_touchdown(gaps.h[i], gaps.u[i], m.g[i]));
    let first = usize::from(t[1] < t[0]);
    (first, t[first], t[0] == t[1])
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
        collide::<true>(m, contact, tau, gaps, sum, log)
    } else {
        collide::<false>(m, contact, tau, gaps, sum, log)
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
    bounce: f64,
    fall: f64,
}

/// The state of the loop in roles: contact a was hit last, after a flight of `tau`.
struct Roles {
    u_a: f64,
    u_b: f64,
    h_b: f64,
    /// s² of the next landing of b.
    square: f64,
    tau: f64,
    clock: Clock,
    /// Since the loop began.
    since: f64,
    /// Own-rate jumps, and their sum weighted with the time, by contact.
    jump: [f64; 2],
    moment: [f64; 2],
    /// Collisions since the limits were last looked at, and allowed until then.
    done: usize,
    budget: usize,
    /// Looks for a clattering tail so far, and collisions until the next.
    looks: u32,
    wait: u32,
}

fn collide<const RECORD: bool>(
    m: &Frozen,
    contact: usize,
    tau: f64,
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
        bounce: m.bounce[i],
        fall: m.fall[i],
    });
    let (u_a, u_b, h_b) = (gaps.u[contact], gaps.u[1 - contact], gaps.h[1 - contact]);
    let mut r = Roles {
        u_a,
        u_b,
        h_b,
        square: u_b * u_b + sides[1 - contact].weight * h_b,
        tau,
        clock: log.clock,
        since: 0.0,
        jump: [0.0; 2],
        moment: [0.0; 2],
        done: 0,
        budget: log.chunk(),
        looks: 0,
        wait: 0,
    };

    // Written out for a = 1 and a = 2 in turn, so that no role is looked up in the loop.
    let mut stop = if contact == 1 { r.hop::<RECORD, 1>(m, &sides, log) } else { None };
    let (a, stop) = loop {
        if let Some(stop) = stop {
            break (1, stop);
        }
        if let Some(stop) = r.hop::<RECORD, 0>(m, &sides, log) {
            break (0, stop);
        }
        stop = r.hop::<RECORD, 1>(m, &sides, log);
    };

    log.hits += r.done;
    *gaps = in_roles(a, r.u_a, r.u_b, r.h_b);
    for i in 0..2 {
        sum.path[i] += sum.jump[i] * r.since + (r.jump[i] * r.since - r.moment[i]);
        sum.jump[i] += r.jump[i];
    }
    log.clock = r.clock;
    if stop == Halt::TimeLimit {
        rest_of_time(m, gaps, sum, log);
    }
    stop
}

impl Roles {
    /// From an impact at contact `A` to the next at the other one, over any number of bounces at `A`: the
    /// roles have changed then, unless the loop is left.
    #[inline(always)]
    fn hop<const RECORD: bool, const A: usize>(
        &mut self,
        m: &Frozen,
        sides: &[Side; 2],
        log: &mut Log,
    ) -> Option<Halt> {
        let (of_a, of_b) = (&sides[A], &sides[1 - A]);
        loop {
            // Does the motion from here on have a sum?
            let (u_a, u_b, h_b) = (self.u_a, self.u_b, self.h_b);
            let t = of_a.bounce * u_a;
            let drop = of_b.weight * h_b;
            let mut look = h_b + t * (u_b - t * of_a.fall) >= 0.0;
            if (drop <= SHARE * self.square || self.tau <= SHORT * self.clock.hi)
                && drop * drop * self.tau <= TRY_TAIL * self.clock.hi * (self.square * self.square)
            {
                look |= self.wait == 0;
                self.wait = if look {
                    self.looks.saturating_mul(self.looks) / EAGER
                } else {
                    self.wait - 1
                };
                self.looks += u32::from(look);
            }
            if look
                && let Some(stop) = accumulates(
                    m,
                    A,
                    &in_roles(A, u_a, u_b, h_b),
                    self.tau,
                    self.clock.hi,
                    log.end,
                    !RECORD,
                )
            {
                return Some(stop);
            }
            if self.done == self.budget {
                log.hits += self.done;
                (self.done, self.budget) = (0, log.chunk());
                if self.budget == 0 {
                    return Some(Halt::EventLimit);
                }
            }

            // The next landing of b. gain = 2K g_aτ: where u_b < 0 it has a division of its own, beside that
            // of τ, so that the next square root waits for one addition only.
            let s = self.square.sqrt();
            let (tau, gain);
            if u_b < 0.0 {
                let (twice, sum) = (2.0 * h_b, s - u_b);
                gain = of_b.lift * twice * s / sum;
                tau = twice / sum;
            } else {
                tau = if of_b.g > 0.0 { (u_b + s) / of_b.g } else { f64::INFINITY };
                gain = of_b.lift * s * tau;
            }
            let w = u_a - of_a.g * tau;
            let climb = u_a + w;
            if climb <= CLOSE * u_a {
                // a is back before b lands, or nearly: decide with care.
                let back = 2.0 * u_a / of_a.g;
                if back <= tau && of_a.g > 0.0 {
                    if self.clock.hi + back > log.end {
                        return Some(Halt::TimeLimit);
                    }
                    self.since += back;
                    self.clock = self.clock.after(back);
                    if back == tau {
                        (self.u_a, self.u_b, self.h_b) = (-u_a, -s, 0.0);
                        return Some(Halt::Tie);
                    }
                    let w = u_b - of_b.g * back;
                    let blow = (1.0 + of_a.e) * u_a;
                    let h = (h_b + 0.5 * back * (u_b + w)).max(0.0);
                    let (hit, other) = (of_a.e * u_a, w - of_a.kick * u_a);
                    self.jump[A] += blow;
                    self.moment[A] += blow * self.since;
                    self.done += 1;
                    if RECORD {
                        let clock = self.clock;
                        log.collisions.push(in_order(clock, A, [-u_a, w], [hit, other], blow, h));
                    }
                    (self.u_a, self.u_b, self.h_b, self.tau) = (hit, other, h, back);
                    self.square = other * other + of_b.weight * h;
                    continue;
                }
            }
            if self.clock.hi + tau > log.end {
                return Some(Halt::TimeLimit);
            }
            if tau == f64::INFINITY {
                return Some(Halt::Never);
            }

            // b lands.
            let kick = of_b.kick * s;
            let d = u_a - kick;
            let (hit, blow) = (of_b.e * s, s + of_b.e * s);
            self.square = d * d + gain;
            self.tau = tau;
            self.since += tau;
            self.clock = self.clock.after(tau);
            self.jump[1 - A] += blow;
            self.moment[1 - A] += blow * self.since;
            self.done += 1;
            (self.u_a, self.u_b, self.h_b) = (hit, w - kick, 0.5 * tau * climb);
            if RECORD {
                let after = [self.u_a, self.u_b];
                let (clock, h) = (self.clock, self.h_b);
                log.collisions.push(in_order(clock, 1 - A, [-s, w], after, blow, h));
            }
            return None;
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

fn in_roles(a: usize, u_a: f64, u_b: f64, h_b: f64) -> Gaps {
    let mut gaps = Gaps::default();
    (gaps.u[a], gaps.u[1 - a], gaps.h[1 - a]) = (u_a, u_b, h_b);
    gaps
}

/// How the motion from here on is summed, if it is: bouncing, clattering, or the end of the digits.
#[cold]
fn accumulates(
    m: &Frozen,
    a: usize,
    gaps: &Gaps,
    tau: f64,
    now: f64,
    end: f64,
    skip: bool,
) -> Option<Halt> {
    if let Some(duration) = m.bounce_tail(a, gaps) {
        if now + duration <= end {
            return Some(Halt::Bounce { contact: a, duration });
        }
        let several = end - now > duration * (1.0 - m.e[a] * m.e[a]);
        return (skip && several).then_some(Halt::Skip { contact: a });
    }
    if let Some(tail) = m.clatter_tail(a, gaps)
        && tail.error <= TAIL * now
        && now + tail.duration <= end
        && m.certainly_clatters(a, gaps)
    {
        return Some(Halt::Clatter(tail));
    }
    if tau > SHORT * now {
        return None;
    }
    let remaining = time_to_rest(m, gaps)?;
    (remaining <= REACHED * now)
        .then(|| Halt::Reached { remaining, self_similar: repeats(m, a, gaps) })
}

/// A time within which both contacts come to rest, by the energy argument, if they do at all: λ =
/// D⁻¹(g_1, g_2) > 0 and every impact loses energy. In s.
pub(crate) fn time_to_rest(m: &Frozen, gaps: &Gaps) -> Option<f64> {
    let force = m.share(m.g);
    if !(force[0] > 0.0 && force[1] > 0.0) {
        return None;
    }
    let speed = (0..2)
        .map(|i| (gaps.u[i] * gaps.u[i] + 2.0 * m.g[i] * gaps.h[i]).sqrt())
        .fold(0.0, f64::max);
    let least = m.g[0].min(m.g[1]) * (1.0 - m.e[0].max(m.e[1]));
    Some(8.0 * speed / least)
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
