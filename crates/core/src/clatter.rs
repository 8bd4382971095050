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

use crate::flight::parabola_touchdown;
use crate::impact;
use crate::log::{Collision, Log};
use crate::tolerance::{GRAVITY_SHARE, REACHED, SELF_SIMILAR, TAIL};
use crate::zeno::{ClatterTail, Frozen, Gaps, Impulses};

/// Why a sequence of collisions is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Halt {
    /// A bounce tail at this contact, of this duration.
    Bounce {
        contact: usize,
        duration: f64,
    },
    /// A clattering tail, and whether it is certified.
    Clatter {
        tail: ClatterTail,
        certified: bool,
    },
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
    if log.record {
        collide::<true>(m, gaps, sum, log)
    } else {
        collide::<false>(m, gaps, sum, log)
    }
}

fn collide<const RECORD: bool>(
    m: &Frozen,
    gaps: &mut Gaps,
    sum: &mut Impulses,
    log: &mut Log,
) -> Halt {
    let share = if m.may_clatter() { GRAVITY_SHARE } else { -1.0 };
    let (mut since, mut jump, mut moment) = (0.0_f64, [0.0_f64; 2], [0.0_f64; 2]);
    let mut clock = log.clock;

    // The first landing. Its contact is the first "b".
    let (b, tau, tie) = next_landing(m, gaps);
    if clock.hi + tau > log.end {
        let left = log.left().max(0.0);
        *gaps = fly_for(m.g, gaps, left);
        advance(sum, left);
        log.clock = log.clock.after(left);
        return Halt::TimeLimit;
    }
    if tau == f64::INFINITY {
        return Halt::Never;
    }
    let mut budget = log.chunk();
    let mut a = 1 - b;
    let (mut u_a, mut u_b, mut h_b) = (gaps.u[a], gaps.u[b], gaps.h[b]);
    let mut square = u_b * u_b + 2.0 * m.g[b] * h_b;
    let mut h_a = gaps.h[a]; // zero from the second collision on

    let stop = if tie {
        let landing = fly_for(m.g, gaps, tau);
        (u_a, u_b, h_a, h_b) = (landing.u[a], landing.u[b], 0.0, 0.0);
        since = tau;
        clock = clock.after(tau);
        Halt::Tie
    } else {
        loop {
            if budget == 0 {
                budget = log.chunk();
                if budget == 0 {
                    break Halt::EventLimit;
                }
            }
            let b = 1 - a;
            let s = square.sqrt();
            let tau = if u_b < 0.0 {
                2.0 * h_b / (s - u_b)
            } else if m.g[b] > 0.0 {
                (u_b + s) / m.g[b]
            } else {
                f64::INFINITY
            };
            let w = u_a - m.g[a] * tau;
            // `a` is back before b lands, or nearly: decide with care. (In the first flight b is first.)
            if h_a == 0.0 && u_a + w <= CLOSE * u_a && m.g[a] > 0.0 {
                let back = 2.0 * u_a / m.g[a];
                if back == tau {
                    if clock.hi + tau > log.end {
                        break Halt::TimeLimit;
                    }
                    (u_a, u_b, h_b) = (-u_a, -s, 0.0);
                    since += tau;
                    clock = clock.after(tau);
                    break Halt::Tie;
                }
                if back < tau {
                    // The same contact again.
                    if clock.hi + back > log.end {
                        break Halt::TimeLimit;
                    }
                    let (h, u) =
                        ((h_b + back * (u_b - 0.5 * m.g[b] * back)).max(0.0), u_b - m.g[b] * back);
                    since += back;
                    clock = clock.after(back);
                    let blow = (1.0 + m.e[a]) * u_a;
                    jump[a] += blow;
                    moment[a] += blow * since;
                    let after = (m.e[a] * u_a, u - m.kick[a] * u_a);
                    if RECORD {
                        let (mut before, mut rates) = ([0.0; 2], [0.0; 2]);
                        (before[a], before[b], rates[a], rates[b]) = (-u_a, u, after.0, after.1);
                        log.collisions.push(Collision {
                            elapsed: clock,
                            contact: a,
                            before,
                            after: rates,
                            jump: blow,
                            other_gap: h,
                        });
                    }
                    log.hits += 1;
                    budget -= 1;
                    (u_a, u_b, h_b) = (after.0, after.1, h);
                    square = u_b * u_b + 2.0 * m.g[b] * h_b;
                    if let Some(stop) =
                        accumulates(m, a, u_a, u_b, h_b, back, &clock, log.end, !RECORD)
                    {
                        break stop;
                    }
                    continue;
                }
            }
            if clock.hi + tau > log.end {
                break Halt::TimeLimit;
            }
            if tau == f64::INFINITY {
                break Halt::Never;
            }
            // b lands.
            let kick = m.kick[b] * s;
            let blow = (1.0 + m.e[b]) * s;
            let h = if h_a == 0.0 {
                let d = u_a - kick;
                square = d * d + 2.0 * kick * m.g[a] * tau;
                0.5 * tau * (u_a + w)
            } else {
                let h = (h_a + tau * (u_a - 0.5 * m.g[a] * tau)).max(0.0);
                h_a = 0.0;
                square = (w - kick) * (w - kick) + 2.0 * m.g[a] * h;
                h
            };
            since += tau;
            clock = clock.after(tau);
            jump[b] += blow;
            moment[b] += blow * since;
            let (hit, after) = (m.e[b] * s, w - kick);
            if RECORD {
                let (mut before, mut rates) = ([0.0; 2], [0.0; 2]);
                (before[b], before[a], rates[b], rates[a]) = (-s, w, hit, after);
                log.collisions.push(Collision {
                    elapsed: clock,
                    contact: b,
                    before,
                    after: rates,
                    jump: blow,
                    other_gap: h,
                });
            }
            log.hits += 1;
            budget -= 1;
            (u_a, u_b, h_b, a) = (hit, after, h, b);
            // A bounce tail?
            let b = 1 - a;
            let t = m.bounce[a] * u_a;
            if h_b + t * (u_b - t * m.fall[a]) >= 0.0
                && let Some(stop) = bounces(m, a, u_a, u_b, h_b, &clock, log.end, !RECORD)
            {
                break stop;
            }
            // A clattering tail, or the end of the digits?
            if (2.0 * m.g[b] * h_b <= share * square || tau <= SHORT * clock.hi)
                && let Some(stop) = accumulates(m, a, u_a, u_b, h_b, tau, &clock, log.end, !RECORD)
            {
                break stop;
            }
        }
    };

    // Back from roles to contacts.
    let b = 1 - a;
    (gaps.h[a], gaps.u[a]) = (h_a, u_a);
    (gaps.h[b], gaps.u[b]) = (h_b, u_b);
    for i in 0..2 {
        sum.path[i] += sum.jump[i] * since + (jump[i] * since - moment[i]);
        sum.jump[i] += jump[i];
    }
    log.clock = clock;
    if stop == Halt::TimeLimit {
        let left = log.left().max(0.0);
        *gaps = fly_for(m.g, gaps, left);
        advance(sum, left);
        log.clock = log.clock.after(left);
    }
    stop
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

#[cold]
#[allow(clippy::too_many_arguments, reason = "the state of the loop, in registers")]
fn bounces(
    m: &Frozen,
    a: usize,
    u_a: f64,
    u_b: f64,
    h_b: f64,
    clock: &crate::clock::Clock,
    end: f64,
    skip: bool,
) -> Option<Halt> {
    let duration = m.bounce_tail(a, &in_roles(a, u_a, u_b, h_b))?;
    if clock.hi + duration <= end {
        return Some(Halt::Bounce { contact: a, duration });
    }
    let left = end - clock.hi;
    let several = left > duration * (1.0 - m.e[a] * m.e[a]);
    (skip && several).then_some(Halt::Skip { contact: a })
}

/// Tails that need more than a glance: bouncing, clattering, and the end of the digits.
#[cold]
#[allow(clippy::too_many_arguments, reason = "the state of the loop, in registers")]
fn accumulates(
    m: &Frozen,
    a: usize,
    u_a: f64,
    u_b: f64,
    h_b: f64,
    tau: f64,
    clock: &crate::clock::Clock,
    end: f64,
    skip: bool,
) -> Option<Halt> {
    if let Some(stop) = bounces(m, a, u_a, u_b, h_b, clock, end, skip) {
        return Some(stop);
    }
    let gaps = in_roles(a, u_a, u_b, h_b);
    if let Some(tail) = m.clatter_tail(a, &gaps)
        && tail.error <= TAIL * clock.hi
        && clock.hi + tail.duration <= end
    {
        let certified = m.certainly_clatters(a, &gaps);
        if certified {
            return Some(Halt::Clatter { tail, certified });
        }
    }
    if tau > SHORT * clock.hi {
        return None;
    }
    let remaining = time_to_rest(m, &gaps)?;
    (remaining <= REACHED * clock.hi)
        .then(|| Halt::Reached { remaining, self_similar: repeats(m, a, &gaps) })
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
