//! Ballistic arcs of a gap, and the next touchdown, guaranteed to be the earliest.
//!
//! In flight the angular velocity ω is constant, and every gap obeys ḧ = −g − c ω² exactly, so that
//!
//! ```text
//! h(t) = h + u t − g t²/2 − (1 − cos ωt) c − (ωt − sin ωt) b
//! ```
//!
//! with b, c at t = 0. Without rotation this is a parabola. All quantities are gap coordinates, because near an accumulation of
//! impacts the gaps are far smaller than the positions of the body.

use std::f64::consts::{PI, TAU};

use crate::math::real::Ring;
use crate::math::roots::bracketed;
use crate::math::turn::{Turn, phase};
use crate::tolerance::{
    BRACKET_MARGIN, GAP_DIFFERENCE_ROUNDING, LAST_NEWTON_STEP, LOWEST_GAP_ROUNDING, MANY_TURNS,
    PHASE_LOST, PLACE_LOST, STAYS_OPEN,
};

/// First time > 0 at which the parabola h + u t − g t²/2 comes down to zero; ∞ if it never does. In s.
///
/// Requires `h ≥ 0` (m), and `u ≥ 0` (m/s) if `h = 0`. With s = √(u² + 2gh), the root is 2h/(s − u) for u < 0, because the textbook root (u
/// + s)/g would lose all digits.
#[inline]
pub(crate) fn parabola_touchdown(h: f64, u: f64, g: f64) -> f64 {
    let square = u * u + 2.0 * g * h;
    if square < 0.0 {
        return f64::INFINITY; // g < 0: the contact turns back before it lands
    }
    if u < 0.0 {
        2.0 * h / (square.sqrt() - u)
    } else if g > 0.0 {
        (u + square.sqrt()) / g
    } else {
        f64::INFINITY
    }
}

/// One gap in flight: constants of its arc at t = 0.
///
/// ```
/// use standfast::flight::GapArc;
///
/// // A point that falls 5 m at g = 10 m/s² lands after 1 s, at 10 m/s.
/// let arc = GapArc { h: 5.0, u: 0.0, g: 10.0, b: 0.0, c: 0.0, omega: 0.0 };
/// assert_eq!(arc.touchdown(), Some(1.0));
/// assert_eq!(arc.rate(1.0), -10.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapArc<T = f64> {
    /// Gap, in m.
    pub h: T,
    /// Gap rate, in m/s.
    pub u: T,
    /// Gravity into the terrain, in m/s².
    pub g: T,
    /// b = ∂h/∂θ, in m.
    pub b: T,
    /// c, in m; db/dθ = −c, dc/dθ = b.
    pub c: T,
    /// Angular velocity ω, in rad/s.
    pub omega: T,
}

/// A touchdown: its time, and the rotation of the body until then.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Touchdown<T = f64> {
    pub(crate) dt: T,
    pub(crate) turn: Turn<T>,
}

/// Number of steps of Chebyshev's method after which the bracketed solver is used instead.
const STEPS: usize = 8;

/// Largest number of Newton steps on a convex piece. The error decreases quadratically if the gap crosses zero, and by half per step if it
/// grazes zero.
const CONVEX_STEPS: usize = 128;

/// Number of turns that are examined after the angle has been reduced. If no touchdown is found in so many turns, the contact only grazes
/// the terrain.
const GRAZING_TURNS: usize = 32;

/// The warning of a run that ends because of [`is_lost`].
pub(crate) const LOST_PHASE: &str = "the next flight turns by more than 1e12 rad or goes farther than 1e12 times the size of the \
     body, so that at most four digits of the gaps at its end would be correct: the run ends here";

/// Returns true if rounding makes the position of the body unknown after a flight: `angle` is its rotation (rad), `way` the distance
/// covered (m), `square` the squared size of the body (m²).
pub(crate) fn is_lost(angle: f64, way: f64, square: f64) -> bool {
    angle.abs() > PHASE_LOST || way * way > PLACE_LOST * PLACE_LOST * square
}

/// The longest flight from the ground whose distance is known, for a body of this size (m) under this gravity (m/s²); in s.
pub(crate) fn longest(size: f64, gravity: f64) -> f64 {
    if gravity > 0.0 { (2.0 * PLACE_LOST * size / gravity).sqrt() } else { f64::INFINITY }
}

#[expect(private_bounds, reason = "doubles are public; balls are of this crate alone")]
impl<T: Ring> GapArc<T> {
    /// h(dt). `turn`: sine and cosine of the rotation ω dt.
    #[inline(always)]
    pub(crate) fn gap_turned(&self, dt: T, turn: &Turn<T>) -> T {
        self.h + dt * (self.u - self.g.half() * dt)
            - (turn.one_minus_cos * self.c + turn.x_minus_sin * self.b)
    }

    /// ḣ(dt). `turn`: sine and cosine of the rotation ω dt.
    #[inline(always)]
    pub(crate) fn rate_turned(&self, dt: T, turn: &Turn<T>) -> T {
        self.u - self.g * dt - self.omega * (turn.sin * self.c + turn.one_minus_cos * self.b)
    }
}

impl GapArc {
    /// The touchdown of a concave arc by Chebyshev's method, t − f/f′ − f″f²/(2f′³); `None` if the method has not converged. The first
    /// guess is the touchdown of a parabola with the effective gravity g + cω² of the start. The two differ only because the body turns
    /// during the flight.
    #[inline(always)]
    pub(crate) fn concave_touchdown(&self) -> Option<Touchdown> {
        let (omega, w2) = (self.omega, self.omega * self.omega);
        // As `parabola_touchdown`, with one division.
        let gravity = self.g + self.c * w2;
        let square = self.u * self.u + gravity * 2.0 * self.h;
        let (root, falls) = (square.sqrt(), self.u < 0.0);
        let top = if falls { self.h * 2.0 } else { self.u + root };
        let bottom = if falls { root - self.u } else { gravity };
        let mut dt = top / bottom;
        if !(0.0 <= square && (falls || 0.0 < gravity)) {
            return None;
        }
        for _ in 0..STEPS {
            let turn = Turn::by(omega * dt);
            let slope = 1.0 / self.rate_turned(dt, &turn);
            let acceleration =
                -self.g - w2 * (self.c * (1.0 - turn.one_minus_cos) + self.b * turn.sin);
            let newton = -self.gap_turned(dt, &turn) * slope;
            let step = newton * (1.0 - acceleration * 0.5 * slope * newton);
            if !((omega * dt).abs() <= Turn::LARGEST) {
                return None;
            }
            // Newton's step decides, because the other factor may vanish far from a root.
            let next = dt + step;
            if newton.abs() <= dt * LAST_NEWTON_STEP {
                return Some(Touchdown { dt: next, turn: turn.and(omega * step) });
            }
            if !(0.0 < next && next < f64::INFINITY) {
                return None;
            }
            dt = next;
        }
        None
    }

    /// g + c ω²: acceleration into the terrain now, in m/s².
    pub(crate) fn effective_gravity(&self) -> f64 {
        self.g + self.c * self.omega * self.omega
    }

    /// Returns true if the gap is certainly positive at all times from 0 (excluded) to `limit`, in s. With k = g + ω²(|b| + |c|) ≥ −ḧ the
    /// gap is at least h + t(u − kt/2): concave in t, not negative at the start, so that its value at the limit decides.
    pub(crate) fn stays_open(&self, limit: f64) -> bool {
        let k = self.g + self.omega * self.omega * (self.b.abs() + self.c.abs());
        let fall = 0.5 * k.max(0.0) * limit;
        let terms = self.h + limit * (self.u.abs() + fall);
        self.h + limit * (self.u - fall) > STAYS_OPEN * terms
    }

    /// Gap after `dt`, in m.
    #[must_use]
    pub fn gap(&self, dt: f64) -> f64 {
        self.gap_turned(dt, &Turn::by(self.omega * dt))
    }

    /// Gap rate after `dt`, in m/s.
    #[must_use]
    pub fn rate(&self, dt: f64) -> f64 {
        self.rate_turned(dt, &Turn::by(self.omega * dt))
    }

    /// Sum of the absolute values of the terms of the gap (m) and of its rate (m/s) after `dt`. Rounding errors of the gap and of the rate
    /// are relative to these sums.
    pub(crate) fn terms(&self, dt: f64, turn: &Turn) -> [f64; 2] {
        let fall = self.g.abs() * dt;
        let turned = (turn.one_minus_cos * self.c).abs() + (turn.x_minus_sin * self.b).abs();
        let spun = (turn.sin * self.c).abs() + (turn.one_minus_cos * self.b).abs();
        let gap = self.h + dt * (self.u.abs() + 0.5 * fall) + turned;
        [gap, self.u.abs() + fall + self.omega.abs() * spun]
    }

    /// Returns true if the arc is concave for ever: ω²|d| < g. (For g < −ω²|d| it is convex for ever.)
    #[inline]
    pub(crate) fn is_concave(&self) -> bool {
        let w2 = self.omega * self.omega;
        self.g > 0.0 && w2 * w2 * (self.b * self.b + self.c * self.c) < self.g * self.g
    }

    /// The earliest touchdown at a time > 0: gap zero, coming from above; `None` if there is none.
    ///
    /// Guaranteed for any spin. A concave arc has at most one root and is solved directly. Any other arc is split at its inflections, which
    /// are known in closed form. Requires `h ≥ 0`, and `u ≥ 0` if `h = 0`. If a gap touches zero within its rounding error without crossing
    /// it, that is not a touchdown.
    #[must_use]
    pub fn touchdown(&self) -> Option<f64> {
        self.find_touchdown().map(|found| found.dt)
    }

    #[inline(always)]
    pub(crate) fn find_touchdown(&self) -> Option<Touchdown> {
        if self.is_concave() {
            let touchdown = self.concave_touchdown();
            if touchdown.is_some() {
                return touchdown;
            }
        }
        if self.h == f64::INFINITY {
            return None;
        }
        self.any_touchdown(false)
    }

    /// The general case: the pieces between inflections, one after the other. `last`: the angle has been reduced, so that few turns are
    /// left. If a touchdown takes more turns, the contact grazes the terrain, and the lowest point of the next turn is the touchdown.
    #[cold]
    #[inline(never)]
    fn any_touchdown(&self, last: bool) -> Option<Touchdown> {
        let found = |dt: f64| Some(Touchdown { dt, turn: Turn::by(self.omega * dt) });
        let horizon = self.horizon();
        let spin = self.omega.abs();
        let arm = libm::hypot(self.b, self.c);
        let f = |t: f64| {
            let turn = Turn::by(self.omega * t);
            (self.gap_turned(t, &turn), self.rate_turned(t, &turn))
        };
        // ḧ = −g − ω²|d| cos(ωt − phase), with c = |d| cos(phase), b = |d| sin(phase):
        // convex where cos < −g/(ω²|d|), a window of half-width `half` around ωt − phase = π.
        let threshold = self.g / (spin * spin * arm);
        if threshold >= 1.0 || threshold.is_nan() {
            return self.concave_piece(0.0, horizon, &f).and_then(found);
        }
        if threshold <= -1.0 {
            // Convex for ever. From zero the gap first rises, or it falls at once.
            return if self.h > 0.0 {
                convex_piece(0.0, horizon, &f).and_then(found)
            } else {
                None
            };
        }
        let (mut middle, half) = self.convex_window(threshold);
        let mut start = 0.0;
        if self.h == 0.0 && self.u == 0.0 {
            // At lift-off the arc begins on the convex side, also where rounding puts the inflection elsewhere.
            start = ((middle + half) / spin).max(0.0);
            middle += TAU;
        }
        let (rise, fall) = self.aloft(arm);
        let mut turns_left = if last { GRAZING_TURNS } else { usize::MAX };
        while start < horizon {
            // While the mean of the gap is larger than |d| the contact cannot land: whole turns are skipped.
            if start >= rise && fall - start > 2.0 * TAU / spin {
                let turns = ((fall - start) * spin / TAU).floor() - 1.0;
                if TAU * turns > PHASE_LOST {
                    return found(fall); // the caller recognises this rotation as too large
                }
                if turns > MANY_TURNS && !last {
                    return self.after_turning(start + TAU / spin * turns);
                }
                middle += TAU * turns;
                start += TAU / spin * turns;
            }
            if turns_left == 0 {
                return found(middle / spin);
            }
            turns_left -= 1;
            let (open, close) = ((middle - half) / spin, (middle + half) / spin);
            if open > start {
                if let Some(root) = self.concave_piece(start, open.min(horizon), &f) {
                    return found(root);
                }
                start = open;
            }
            if start < horizon && close > start {
                if let Some(root) = convex_piece(start, close, &f) {
                    return found(root);
                }
                start = close;
            }
            middle += TAU;
        }
        None
    }

    /// The first convex piece of the arc that is not yet over: the angle turned (counted forwards) at its middle, and its half-width.
    /// `threshold` = g/(ω²|d|), between −1 and 1.
    fn convex_window(&self, threshold: f64) -> (f64, f64) {
        let half = libm::acos(threshold);
        let phase = libm::atan2(if self.omega < 0.0 { -self.b } else { self.b }, self.c);
        let middle = (phase + PI).rem_euclid(TAU);
        if middle - half > TAU - 2.0 * half { (middle - TAU, half) } else { (middle, half) }
    }

    /// The first touchdown before `limit` (s) of an arc with h > 0, by pieces between inflections. Gravity may point away from the
    /// terrain (g ≤ 0).
    pub(crate) fn touchdown_before(&self, limit: f64) -> Option<f64> {
        if self.omega == 0.0 {
            return Some(parabola_touchdown(self.h, self.u, self.g)).filter(|t| *t < limit);
        }
        let spin = self.omega.abs();
        let f = |t: f64| {
            let turn = Turn::by(self.omega * t);
            (self.gap_turned(t, &turn), self.rate_turned(t, &turn))
        };
        let threshold = self.g / (spin * spin * libm::hypot(self.b, self.c));
        if threshold >= 1.0 || threshold.is_nan() {
            return self.concave_piece(0.0, limit, &f);
        }
        if threshold <= -1.0 {
            return convex_piece(0.0, limit, &f);
        }
        let (mut middle, half) = self.convex_window(threshold);
        let mut start = 0.0;
        while start < limit {
            let [open, close] =
                [middle - half, middle + half].map(|angle| (angle / spin).min(limit));
            let concave = self.concave_piece(start, open, &f);
            let from = open.max(start);
            let root =
                concave.or_else(|| if close > from { convex_piece(from, close, &f) } else { None });
            if root.is_some() {
                return root;
            }
            start = close.max(from);
            middle += TAU;
        }
        None
    }

    /// The touchdown, computed from the arc that starts `dt` later; `dt` must be before the touchdown. Angles are counted from that later
    /// start.
    fn after_turning(&self, dt: f64) -> Option<Touchdown> {
        let before = phase(self.omega, dt);
        let turn = Turn::by(before);
        let turn = Turn { x_minus_sin: self.omega * dt - turn.sin, ..turn };
        let [b, c] = turn.turned([self.b, self.c]);
        let later = Self {
            h: self.gap_turned(dt, &turn).max(f64::MIN_POSITIVE),
            u: self.rate_turned(dt, &turn),
            b,
            c,
            ..*self
        };
        let landing = later.any_touchdown(true)?;
        let total = Turn::by(before + self.omega * landing.dt);
        let dt = dt + landing.dt;
        Some(Touchdown { dt, turn: Turn { x_minus_sin: self.omega * dt - total.sin, ..total } })
    }

    /// Two times between which h − c − |d| + (u − ωb)t − gt²/2, the lowest gap of a turn, is positive. There is no touchdown between them.
    fn aloft(&self, arm: f64) -> (f64, f64) {
        let (height, drift) = (self.h - self.c - arm, self.u - self.omega * self.b);
        // A graze within rounding does not count in any turn until the mean has decreased by more.
        let graze = LOWEST_GAP_ROUNDING * (self.h + self.c.abs() + arm);
        let height = if height.abs() <= graze { graze } else { height };
        let never = (f64::INFINITY, 0.0);
        if self.g == 0.0 {
            let falls = height > 0.0 && drift < 0.0;
            return if falls { (0.0, height / -drift * (1.0 - BRACKET_MARGIN)) } else { never };
        }
        let square = drift * drift + 2.0 * self.g * height;
        if square <= 0.0 || (height <= 0.0 && drift <= 0.0) {
            return never;
        }
        let root = square.sqrt();
        if self.g < 0.0 {
            // Gravity raises the mean: it is high until it has fallen, and again after the horizon.
            let falls = height > 0.0 && drift < 0.0;
            let fall = 2.0 * height / (root - drift) * (1.0 - BRACKET_MARGIN);
            return if falls { (0.0, fall) } else { never };
        }
        let rise = if height >= 0.0 { 0.0 } else { -2.0 * height / (drift + root) };
        let fall =
            if drift > 0.0 { (drift + root) / self.g } else { 2.0 * height / (root - drift) };
        (rise * (1.0 + BRACKET_MARGIN), fall * (1.0 - BRACKET_MARGIN))
    }

    /// A time after which the gap is certainly negative (g > 0), or after which the sign of the gap cannot change any more.
    fn horizon(&self) -> f64 {
        let arm = libm::hypot(self.b, self.c);
        // h(t) = [h − c + …] + (u − ωb) t − g t²/2 + |d|·(…): bounded by |d| around its mean. The two may cancel.
        let turning = self.omega * self.b;
        let drift = self.u - turning + GAP_DIFFERENCE_ROUNDING * (self.u.abs() + turning.abs());
        let over = if self.c > 0.0 { self.b * self.b / (arm + self.c) } else { arm - self.c };
        let height = self.h + over;
        if self.g > 0.0 {
            parabola_touchdown(height.max(0.0), drift, self.g) * (1.0 + BRACKET_MARGIN)
                + f64::MIN_POSITIVE
        } else if self.g < 0.0 {
            // The last time at which the mean is as low as −|d|, (√(drift² + 2 g lowest) − drift)/(−g), without cancellation.
            let lowest = self.h - self.c - arm;
            let square = drift * drift + 2.0 * self.g * lowest;
            let root = square.max(0.0).sqrt();
            let last =
                if drift > 0.0 { -2.0 * lowest / (root + drift) } else { (root - drift) / -self.g };
            let last = if square > 0.0 { last } else { 0.0 };
            last.max(0.0) * (1.0 + BRACKET_MARGIN) + f64::MIN_POSITIVE
        } else if self.omega == 0.0 {
            if drift < 0.0 { self.h / -drift * (1.0 + BRACKET_MARGIN) } else { 0.0 }
        } else {
            // Without gravity the oscillation repeats: its lowest point within a turn decides.
            let turns = TAU / self.omega.abs();
            let swing = 2.0 * arm;
            if drift < 0.0 { (self.h + swing) / -drift + turns } else { turns }
        }
    }

    /// The first root in a piece where the arc is concave and starts with h ≥ 0. There is a root iff h is negative at the end of the piece.
    fn concave_piece(&self, from: f64, to: f64, f: &impl Fn(f64) -> (f64, f64)) -> Option<f64> {
        if !(to > from && f(to).0 <= 0.0) {
            return None;
        }
        // At lift-off the search starts where the gap is largest, so that the zero at `from` is not found again.
        let mut start = from;
        if f(from).0 <= 0.0 {
            start = bracketed(from, to, |t| {
                let turn = Turn::by(self.omega * t);
                (
                    self.rate_turned(t, &turn),
                    -self.g
                        - self.omega
                            * self.omega
                            * (self.c * (1.0 - turn.one_minus_cos) + self.b * turn.sin),
                )
            });
            if f(start).0 <= 0.0 {
                return Some(from.max(f64::MIN_POSITIVE));
            }
        }
        Some(bracketed(start, to, f))
    }
}

/// The first root in a piece where the arc is convex and starts with h > 0. Newton's method from the left never passes the first root. If
/// it reaches a rate ≥ 0, there is no root.
fn convex_piece(from: f64, to: f64, f: &impl Fn(f64) -> (f64, f64)) -> Option<f64> {
    let mut t = from;
    for _ in 0..CONVEX_STEPS {
        let (h, rate) = f(t);
        if h <= 0.0 && t > from {
            return Some(t);
        }
        if rate >= 0.0 {
            return None;
        }
        let next = t - h / rate;
        if next >= to {
            return None;
        }
        if next <= t {
            return Some(t); // the root lies within rounding
        }
        t = next;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tiny_gap_is_not_lost() {
        // u = −1, h = 1e-20: the textbook root (u + s)/g is zero.
        let t = parabola_touchdown(1e-20, -1.0, 9.81);
        assert!((t / 1e-20 - 1.0).abs() < 1e-15);
        assert_eq!(parabola_touchdown(1.0, 1.0, 0.0), f64::INFINITY);
        assert_eq!(parabola_touchdown(1.0, -1.0, -1.0), f64::INFINITY);
    }

    #[test]
    fn at_a_wall_rounding_of_gravity_changes_no_touchdown() {
        let at = |g: f64| {
            let arcs = [(0.0, 0.3, 5.0, 0.05), (0.1, 0.3, 4.0, 0.5), (0.1, -0.2, 7.0, -0.3)];
            arcs.map(|(b, c, omega, u)| GapArc { h: 0.01, u, g, b, c, omega }.touchdown())
        };
        let wall = at(0.0);
        assert!(wall.iter().all(Option::is_some));
        for g in [1e-8, 1e-15, 1e-18, 1e-300, -1e-300, -1e-18, -1e-15, -1e-8] {
            for (one, other) in at(g).into_iter().zip(wall) {
                let (one, other) = (one.unwrap(), other.unwrap());
                assert!((one - other).abs() <= 1e-7 * other, "{g}: {one} {other}");
            }
        }
    }

    #[test]
    fn slow_spin_agrees_with_the_bracketed_root() {
        let arc = GapArc { h: 0.01, u: 0.3, g: 9.81, b: 0.5, c: -0.2, omega: 2.0 };
        assert!(arc.is_concave());
        let (fast, safe) =
            (arc.concave_touchdown().unwrap().dt, arc.any_touchdown(false).unwrap().dt);
        assert!((fast - safe).abs() < 4e-16 * fast, "{fast} {safe}");
        assert!(arc.gap(fast).abs() < 1e-16);
    }

    #[test]
    fn fast_spin_meets_the_first_dip() {
        // Without gravity, c = −1, h = 1.5 − … : the tip comes round after half a turn.
        let arc = GapArc { h: 1.5, u: 0.0, g: 0.0, b: 0.0, c: 1.0, omega: 300.0 };
        let t = arc.touchdown().unwrap(); // 1.5 − (1 − cos ωt) = 0
        assert!((t - libm::acos(-0.5) / 300.0).abs() < 1e-17, "{t}");
        let high = GapArc { h: 2.5, ..arc };
        assert_eq!(high.touchdown(), None);
    }

    #[test]
    fn a_foot_above_the_centre_lands_at_once() {
        // What bounds its gap is the gap itself, which is far less than the arm.
        for b in [0.0, 4e-16, -1e-9, 1e-6] {
            for h in [1e-4, 1e-9, 6.5e-13, 1e-30, 1e-200] {
                for (u, omega) in [(-0.2265, 5.97), (-1e-3, -40.0), (-3.0, 1e3)] {
                    let arc = GapArc { h, u, g: 9.81, b, c: 1.0, omega };
                    let t = arc.touchdown().unwrap();
                    let fall = parabola_touchdown(h, u, arc.effective_gravity());
                    assert!((t / fall - 1.0).abs() < 1e-4, "{arc:?}: {t} {fall}");
                }
            }
        }
    }

    #[test]
    fn leaving_the_ground_is_no_touchdown() {
        for omega in [0.0, 1.0, 50.0, 900.0] {
            for (b, c) in [(0.5, 0.1), (-0.5, 0.1), (0.3, -0.4), (-0.2, -0.6)] {
                let arc = GapArc { h: 0.0, u: 1e-3, g: 9.81, b, c, omega };
                let t = arc.touchdown().unwrap();
                assert!(t > 0.0 && arc.gap(0.5 * t) > 0.0, "{omega} {b} {c}: {t}");
                assert!(arc.gap(t).abs() < 1e-14 * (1.0 + t * t), "{}", arc.gap(t));
            }
        }
    }

    #[test]
    fn a_vanishing_step_is_no_root() {
        // Chebyshev's factor 1 − f f″/(2f′²) is all but zero on the way.
        let arc = GapArc {
            h: 2.8366763643190262e-8,
            u: 12.248098641606981,
            g: 2.6770884859217445,
            b: -0.020247840432107967,
            c: 0.19897149483452914,
            omega: -2.583956352623549,
        };
        let t = arc.touchdown().unwrap();
        assert!((arc.gap(t)).abs() < 1e-12, "gap {} at {t}", arc.gap(t));
    }
}
