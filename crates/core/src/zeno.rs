//! Zeno points: infinitely many impacts in finite time, recognised, certified and summed.
//!
//! All formulas are exact for frozen geometry (the local model). The full model uses them with its geometry frozen once the
//! time left is so short that the geometry does not change.

use crate::body::local_model::LocalModel;
use crate::flight::parabola_touchdown as parabola;
use crate::tolerance::{GRAVITY_NEGLIGIBLE, PARALLEL_GAP_ROWS};

/// Gap coordinates of two contacts: gaps h (m) and gap rates u (m/s).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Gaps {
    pub(crate) h: [f64; 2],
    pub(crate) u: [f64; 2],
}

/// Effect of impacts and contact forces on the gaps: for each contact its own-rate jump
/// Σ(1+e)|w| (m/s) and the time integral of that sum (m).
///
/// ḣ_i(t) = ḣ_i(0) − g_i t + J_i − ψ_j J_j and θ̇(t) = θ̇(0) − φ_1 J_1 − φ_2 J_2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Impulses {
    pub(crate) jump: [f64; 2],
    pub(crate) path: [f64; 2],
}

/// A local model with the constants that several formulas use.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FrozenModel {
    pub(crate) g: [f64; 2],
    pub(crate) psi: [f64; 2],
    pub(crate) phi: [f64; 2],
    pub(crate) e: [f64; 2],
    /// (1+e_i)ψ_i
    pub(crate) kappa: [f64; 2],
    /// 2/(g_i(1−e_i)): duration of a bounce tail divided by its take-off speed.
    pub(crate) bounce: [f64; 2],
    /// (g_j + e_iψ_i g_i)/2: decrease of the other gap divided by the squared duration of a bounce tail at i.
    pub(crate) fall: [f64; 2],
    clatter: Option<ClatteringConstants>,
}

/// Constants of a clattering tail. Index: the contact b that is hit next; the other contact, a, was hit last.
#[derive(Debug, Clone, Copy)]
struct ClatteringConstants {
    /// Weight c_i of u_a relative to |u_b| in the sum: y/((1+e)ψ_i). 1/c_i = λ₊, without scaling, is the edge of the cone of infinite
    /// clattering.
    c: [f64; 2],
    /// S
    gravity: [f64; 2],
    /// r = e c_1c_2 = λ₋/λ₊
    r: f64,
    /// g̃_i = √ψ_i g_i
    reduced_gravity: [f64; 2],
    /// Limit of u_a/|u_b|: λ₋, without scaling.
    limit: [f64; 2],
    /// |g_1| + |g_2| if the sum leaves gravity out.
    left_out: f64,
}

/// Constants of a lower bound of the error of a clattering tail. Index b of [`ClatteringConstants`].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TailBound {
    /// 0: the model has no clattering tails.
    c: f64,
    gravity: f64,
    r: f64,
    limit: f64,
    /// (|g_1| + |g_2|) times the relative change of the tail per relative change of ψ, if the sum leaves gravity out.
    pull: f64,
}

impl TailBound {
    /// Whether the error of the tail, see [`FrozenModel::clatter_tail`], may be below `most`, in s. To lowest order in gravity the tail lasts for
    /// T = h/d, and T0 − T1 is S h²/(2d³). The test has no root and no division.
    #[inline(always)]
    pub(crate) fn may_be_summed(&self, u_a: f64, u_b: f64, h_b: f64, most: f64) -> bool {
        let d = -u_b - self.c * u_a;
        let (square, gap) = (d * d, self.gravity * h_b * h_b);
        if !(gap * gap <= 4.0 * most * (square * square * d) * h_b && self.c > 0.0) {
            return false; // d < 0, too
        }
        let end = self.limit * -u_b;
        let by_shape = gap * self.r * (u_a - end).abs() <= 2.0 * most * (square * d) * (u_a + end);
        by_shape && self.pull * h_b * h_b <= most * square * -u_b
    }
}

/// A clattering tail: the time at which both contacts come to rest, and its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ClatterTail {
    pub(crate) duration: f64,
    pub(crate) error: f64,
    /// Whether it is proved that impacts alternate for ever. There is no proof if the sum leaves gravity out.
    pub(crate) proved: bool,
}

/// Solves x_1 − ψ_2 x_2 = y_1, x_2 − ψ_1 x_1 = y_2 by elimination with a multiplier of at most one. The solution then satisfies the
/// equations within their rounding errors even if they are nearly parallel.
pub(crate) fn solve_coupled(psi: [f64; 2], y: [f64; 2]) -> [f64; 2] {
    if is_parallel(psi) {
        return [y[0], 0.0];
    }
    let determinant = 1.0 - psi[0] * psi[1];
    let (i, j) = if psi[0].abs() <= psi[1].abs() { (0, 1) } else { (1, 0) };
    let mut x = [0.0; 2];
    x[j] = (y[j] + psi[i] * y[i]) / determinant;
    x[i] = y[i] + psi[j] * x[j];
    x
}

/// Whether the rows of two contacts are equal within their rounding errors.
fn is_parallel(psi: [f64; 2]) -> bool {
    1.0 - psi[0] * psi[1] <= PARALLEL_GAP_ROWS
}

impl FrozenModel {
    pub(crate) fn new(model: &LocalModel) -> Self {
        let (g, psi, phi, e) = (model.gravity(), model.psi(), model.phi(), model.restitution());
        let each = |f: &dyn Fn(usize) -> f64| [f(0), f(1)];
        Self {
            g,
            psi,
            phi,
            e,
            kappa: each(&|i| (1.0 + e[i]) * psi[i]),
            bounce: each(&|i| 2.0 / (g[i] * (1.0 - e[i]))),
            fall: each(&|i| 0.5 * (g[1 - i] + e[i] * psi[i] * g[i])),
            clatter: ClatteringConstants::new(g, psi, e),
        }
    }

    /// Duration of the bounce tail at `a` after an impact there left it with rate `u` [closed form:
    /// T = 2u/(g(1−e))], if contact b stays above the terrain during the tail.
    ///
    /// For ψ_a ≥ 0 and g_b ≥ 0 it is enough to test the gap of b at the end. For ψ_a < 0 the gap of b is tested at the impacts; these
    /// values lie on a quadratic in y = 1 − eʲ.
    #[inline]
    pub(crate) fn bounce_tail(&self, a: usize, gaps: &Gaps) -> Option<f64> {
        let b = 1 - a;
        let t = self.bounce[a] * gaps.u[a];
        let end = gaps.h[b] + t * (gaps.u[b] - t * self.fall[a]);
        let clear = || {
            (self.psi[a] >= 0.0 || self.clear_of_bounces(a, gaps, t))
                && (self.g[b] >= 0.0 || self.clear_of_dips(a, gaps, t))
        };
        (self.g[a] > 0.0 && end >= 0.0 && clear()).then_some(t)
    }

    /// The case g_b < 0: the gap of b is convex between the impacts at a. Whether it stays positive there, too. After an impact its rate is
    /// u_b + y (|g_b|T − ψ_a J), with J the sum of all jumps.
    #[cold]
    fn clear_of_dips(&self, a: usize, gaps: &Gaps, t: f64) -> bool {
        let (b, e) = (1 - a, self.e[a]);
        let rise = -self.g[b] * t;
        let kicks = self.psi[a] * gaps.u[a] * (1.0 + e) / (1.0 - e);
        let u = gaps.u[b];
        let rises = u >= 0.0 && u + rise - kicks >= 0.0;
        let falls = u + rise - kicks.min(0.0) <= 0.0;
        rises || falls || gaps.h[b] + t * (u.min(0.0) - kicks.max(0.0)) >= 0.0
    }

    /// ψ_a < 0: whether the gap of b is positive at every impact of the bounce tail at a.
    #[cold]
    fn clear_of_bounces(&self, a: usize, gaps: &Gaps, t: f64) -> bool {
        let (b, e) = (1 - a, self.e[a]);
        // h_b at the j-th impact from now is h + p y − q y², y = 1 − eʲ in (0, 1); limit y = 1.
        let lift = self.kappa[a] * gaps.u[a] * t / (1.0 - e);
        let p = gaps.u[b] * t + lift * (1.0 - e) / (1.0 + e);
        let q = 0.5 * self.g[b] * t * t + lift / (1.0 + e);
        let h = gaps.h[b];
        let square = p * p + 4.0 * q * h;
        if q >= 0.0 || p >= 0.0 || square <= 0.0 || e == 0.0 {
            return true; // concave, or rising, or without roots: positive between its positive ends
        }
        // The convex quadratic is negative between its roots y1 < y2; test for an impact between them.
        let root = square.sqrt();
        let (y1, y2) = (2.0 * h / (root - p), (p - root) / (2.0 * q));
        let (y1, y2) = (y1.min(y2), y1.max(y2));
        if y1 >= 1.0 {
            return true;
        }
        let first = (libm::log1p(-y1) / libm::log(e)).ceil().max(1.0);
        libm::exp(first * libm::log(e)) < 1.0 - y2.min(1.0)
    }

    /// A bounce tail at `a` lasts longer than `left`: the state after the last impact within `left`. With x = eʲ after j impacts, the time
    /// is t = T(1 − x) and the sum of jumps J = (1+e)u(1 − x)/(1 − e).
    pub(crate) fn skip_bounces(&self, a: usize, gaps: &Gaps, left: f64) -> (f64, Gaps, Impulses) {
        let (b, e, u) = (1 - a, self.e[a], gaps.u[a]);
        let t_end = self.bounce[a] * u;
        if left >= t_end {
            let (end, sum) = self.end_bounce(a, gaps, t_end);
            return (t_end, end, sum);
        }
        let count = (libm::log1p(-left / t_end) / libm::log(e)).floor().max(0.0);
        let rest = libm::expm1(count * libm::log(e)); // x − 1
        let t = -t_end * rest;
        let mut sum = Impulses::default();
        sum.jump[a] = -(1.0 + e) * u * rest / (1.0 - e);
        sum.path[a] = t * (0.5 * self.g[a] * t - u);
        let mut after = Gaps::default();
        after.u[a] = u * (1.0 + rest);
        after.u[b] = gaps.u[b] - self.g[b] * t - self.psi[a] * sum.jump[a];
        after.h[b] = (gaps.h[b] + t * (gaps.u[b] - 0.5 * self.g[b] * t)
            - self.psi[a] * sum.path[a])
            .max(0.0);
        (t, after, sum)
    }

    /// The limit of a bounce tail of duration `t` at `a`: gaps, rates and impulses.
    pub(crate) fn end_bounce(&self, a: usize, gaps: &Gaps, t: f64) -> (Gaps, Impulses) {
        let b = 1 - a;
        let mut sum = Impulses::default();
        sum.jump[a] = gaps.u[a] * (1.0 + self.e[a]) / (1.0 - self.e[a]);
        sum.path[a] = 0.5 * self.e[a] * self.g[a] * t * t;
        let mut end = Gaps::default();
        end.h[b] = (gaps.h[b] + t * (gaps.u[b] - t * self.fall[a])).max(0.0);
        end.u[b] = gaps.u[b] - self.g[b] * t - self.psi[a] * sum.jump[a];
        (end, sum)
    }

    /// Impulses that bring both contacts to rest on the terrain within `t`.
    ///
    /// They satisfy 0 = u_i − g_i t + J_i − ψ_j J_j, and the time integral of this equation. Two contacts whose rows are parallel have only
    /// a common impulse, which is assigned to the first contact.
    pub(crate) fn settle(&self, gaps: &Gaps, t: f64) -> Impulses {
        self.lead_to([0.0; 2], gaps, t)
    }

    /// Those of the contacts at rest that gravity presses into the ground, without friction: 0 ≤ λ ⊥ acceleration ≥ 0.
    pub(crate) fn pressed(&self, rests: [bool; 2]) -> [bool; 2] {
        if rests != [true, true] {
            return [0, 1].map(|i| rests[i] && self.g[i] > 0.0);
        }
        let force = self.solve_coupled(self.g);
        if force[0] > 0.0 && force[1] >= 0.0 || force[0] >= 0.0 && force[1] > 0.0 {
            return [true, true];
        }
        [0, 1].map(|i| self.g[i] > 0.0 && -self.g[1 - i] - self.psi[i] * self.g[i] >= 0.0)
    }

    /// Own-rate accelerations that keep the gaps of held contacts zero.
    pub(crate) fn hold(&self, held: [bool; 2]) -> [f64; 2] {
        match held {
            [true, true] => self.solve_coupled(self.g),
            [true, false] => [self.g[0], 0.0],
            [false, true] => [0.0, self.g[1]],
            [false, false] => [0.0, 0.0],
        }
    }

    /// Impulses that bring both gaps to zero, with these rates, within `t`.
    pub(crate) fn lead_to(&self, rates: [f64; 2], gaps: &Gaps, t: f64) -> Impulses {
        let fall = |i: usize| gaps.u[i] - self.g[i] * t - rates[i];
        let sink = |i: usize| gaps.h[i] + t * (gaps.u[i] - 0.5 * self.g[i] * t);
        Impulses {
            jump: self.solve_coupled([-fall(0), -fall(1)]),
            path: self.solve_coupled([-sink(0), -sink(1)]),
        }
    }

    /// Gravity g_i + ψ_jg_j into the terrain i while the other contact is held, in m/s².
    pub(crate) fn held_gravity(&self, i: usize) -> f64 {
        self.g[i] + self.psi[1 - i] * self.g[1 - i]
    }

    /// Returns true if the rows of the contacts are equal within their rounding errors.
    pub(crate) fn is_parallel(&self) -> bool {
        is_parallel(self.psi)
    }

    /// [`solve_coupled`] with the couplings of this model.
    pub(crate) fn solve_coupled(&self, y: [f64; 2]) -> [f64; 2] {
        solve_coupled(self.psi, y)
    }

    /// The bound of the error of [`Self::clatter_tail`] where contact `b` is hit next.
    pub(crate) fn tail_bound(&self, b: usize) -> TailBound {
        self.clatter.as_ref().map_or(TailBound::default(), |k| TailBound {
            c: k.c[b],
            gravity: k.gravity[b],
            r: k.r,
            limit: k.limit[b],
            pull: k.left_out * self.sensitivity(),
        })
    }

    /// The clattering tail after an impact at `a`: T1 of the closed form with its error estimate. `None` unless this state clatters for
    /// ever without gravity, and gravity is a small correction.
    pub(crate) fn clatter_tail(&self, a: usize, gaps: &Gaps) -> Option<ClatterTail> {
        let k = self.clatter.as_ref()?;
        let b = 1 - a;
        let (u_a, u_b, h_b) = (gaps.u[a], gaps.u[b], gaps.h[b]);
        let d = -u_b - k.c[b] * u_a; // > 0: inside the cone
        if !(u_b < 0.0 && d > 0.0) {
            return None;
        }
        let zero_gravity = h_b / d; // T0, an upper bound
        let duration = 2.0 * h_b / (d + (d * d + 2.0 * k.gravity[b] * h_b).sqrt());
        let gap = zero_gravity - duration;
        let (z, limit) = (u_a / -u_b, k.limit[b]);
        let shape = if z + limit > 0.0 { k.r * (z - limit).abs() / (z + limit) } else { 0.0 };
        let pull = k.left_out * duration / -u_b * self.sensitivity();
        let error =
            if duration > 0.0 { gap * (gap / duration + shape) + pull * duration } else { 0.0 };
        Some(ClatterTail { duration, error, proved: k.left_out == 0.0 })
    }

    /// Returns true if impacts provably alternate for ever and end in a 2-Zeno, after an impact at `a`: ϱ ≤ λ₊, κ = max(ϱ, λ₋)³/e² < 1, η <
    /// 1 and (g̃_b/g̃_a) κη(1−η) < 1, with ϱ = √ψ_a u_a/(√ψ_b|u_b|) and η = g_aτ/(2u_a), τ the coming flight.
    pub(crate) fn certainly_clatters(&self, a: usize, gaps: &Gaps) -> bool {
        let Some(k) = &self.clatter else { return false };
        let (b, e) = (1 - a, self.e[0]);
        let (u_a, u_b, h_b) = (gaps.u[a], gaps.u[b], gaps.h[b]);
        if u_b >= 0.0 {
            return false;
        }
        let d = -u_b - k.c[b] * u_a;
        if d < 0.0 {
            return false; // outside the cone ϱ ≤ λ₊
        }
        if self.g == [0.0, 0.0] {
            return true;
        }
        if k.left_out > 0.0 {
            // Gravity into the terrain increases d: d_a' = (d_b + (g_b + c_bg_a)τ)/c_b. But it may move the state out of the
            // cone, or return a contact to the terrain before the other lands.
            let far = GRAVITY_NEGLIGIBLE * self.sensitivity() * h_b;
            let leaves = [(a, u_a), (b, -self.e[b] * u_b)];
            return d * d >= far * k.left_out
                && leaves.iter().all(|&(i, u)| self.g[i] <= 0.0 || d * u >= far * self.g[i]);
        }
        let scale = (self.psi[a] / self.psi[b]).sqrt();
        let ratio = scale * (u_a / -u_b).max(k.limit[b]);
        let factor = ratio * ratio * ratio / (e * e);
        let eta = self.g[a] * parabola(h_b, u_b, self.g[b]) / (2.0 * u_a);
        factor < 1.0
            && eta < 1.0
            && k.reduced_gravity[b] * factor * eta * (1.0 - eta) < k.reduced_gravity[a]
    }

    /// Relative change of the tail per relative change of ψ: 1/√(1 − 4e/P²).
    pub(crate) fn sensitivity(&self) -> f64 {
        self.clatter.as_ref().map_or(1.0, |k| (1.0 + k.r) / (1.0 - k.r).max(f64::EPSILON))
    }

    /// Both gaps are zero and contact b approaches: whether impacts alternate for ever. The rate of the other contact must be inside the
    /// cone of infinite clattering.
    pub(crate) fn chatters_from(&self, b: usize, u: [f64; 2]) -> bool {
        let inside = |k: &ClatteringConstants| k.c[b] * u[1 - b] <= -u[b];
        self.chatters() && self.clatter.as_ref().is_none_or(inside)
    }

    /// Returns true if contact impacts without gravity alternate for ever: ψ > 0 and p_1p_2 ≥ (√e_1 + √e_2)², p_i = (1+e_i)ψ_i (Goyal's
    /// bound, for unequal restitutions).
    pub(crate) fn chatters(&self) -> bool {
        let bound = self.e[0].sqrt() + self.e[1].sqrt();
        self.psi[0] > 0.0 && self.kappa[0] * self.kappa[1] >= bound * bound
    }
}

impl ClatteringConstants {
    fn new(g: [f64; 2], psi: [f64; 2], e: [f64; 2]) -> Option<Self> {
        let e = match e {
            [one, two] if one == two && g[0] >= 0.0 && g[1] >= 0.0 => one,
            _ => return Self::weightless(g, psi, e),
        };
        let p = (1.0 + e) * (psi[0] * psi[1]).sqrt();
        if !(psi[0] > 0.0 && psi[1] > 0.0 && p >= 2.0 * e.sqrt()) {
            return None;
        }
        let y = 2.0 / (1.0 + (1.0 - 4.0 * e / (p * p)).max(0.0).sqrt());
        let c = [y / ((1.0 + e) * psi[0]), y / ((1.0 + e) * psi[1])];
        let r = e * c[0] * c[1];
        let closing = |b: usize| {
            let a = 1 - b;
            let (r2, r4) = (r * r, r * r * r * r);
            (1.0 - r2) * ((g[b] + c[b] * g[a]) + (g[a] + c[a] * g[b]) * c[b] * r2)
                / (1.0 - r4 * c[0] * c[1])
        };
        Some(Self {
            c,
            gravity: [closing(0), closing(1)],
            r,
            reduced_gravity: [psi[0].sqrt() * g[0], psi[1].sqrt() * g[1]],
            limit: [e * c[1], e * c[0]],
            left_out: 0.0,
        })
    }

    /// For any two restitutions; gravity is left out. At each impact z = u_a/|u_b| becomes e_b/(p_b − z), with p_i = (1+e_i)ψ_i. The time
    /// left is T0 = h_b/(|u_b| − c_b u_a), and 1/c_b is the repelling fixed point of two impacts:
    ///
    /// ```text
    /// p_a z² − (p_a p_b + e_a − e_b) z + e_a p_b = 0.
    /// ```
    fn weightless(g: [f64; 2], psi: [f64; 2], e: [f64; 2]) -> Option<Self> {
        let p = [(1.0 + e[0]) * psi[0], (1.0 + e[1]) * psi[1]];
        let bound = e[0].sqrt() + e[1].sqrt();
        if !(psi[0] > 0.0 && psi[1] > 0.0 && p[0] * p[1] >= bound * bound) {
            return None;
        }
        let c = [1, 0].map(|a| {
            let b = 1 - a;
            let sum = p[a] * p[b] + e[a] - e[b];
            let root = (sum * sum - 4.0 * e[a] * p[a] * p[b]).max(0.0).sqrt();
            2.0 * p[a] / (sum + root)
        });
        // Two impacts multiply d by their other root over this one, r.
        let limit = [e[1] * p[0] * c[0] / p[1], e[0] * p[1] * c[1] / p[0]];
        Some(Self {
            c,
            gravity: [0.0; 2],
            r: limit[1] * c[1],
            reduced_gravity: [0.0; 2],
            limit,
            left_out: g[0].abs() + g[1].abs(),
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::body::local_model::LocalModelFields;
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::fixed;

    /// Number of impacts that are followed one by one. What is left of a tail after them is below the rounding error of its sum.
    const MANY: usize = 4000;

    fn frozen(gravity: [f64; 2], psi: [f64; 2], e: [f64; 2]) -> FrozenModel {
        FrozenModel::new(
            &LocalModel::new(LocalModelFields { gravity, psi, phi: [0.3, -0.2], restitution: e })
                .expect("a local model"),
        )
    }

    /// Gaps after a flight of `dt` and then an impact at contact `i`: u_i⁺ = −e_i u_i, u_j⁺ = u_j + (1 + e_i) ψ_i u_i.
    fn after_impact(m: &FrozenModel, at: &Gaps, dt: f64, i: usize) -> Gaps {
        let mut next = *at;
        for k in 0..2 {
            next.h[k] = at.h[k] + dt * (at.u[k] - 0.5 * m.g[k] * dt);
            next.u[k] = at.u[k] - m.g[k] * dt;
        }
        let hit = next.u[i];
        next.h[i] = 0.0;
        next.u[i] = -m.e[i] * hit;
        next.u[1 - i] += (1.0 + m.e[i]) * m.psi[i] * hit;
        next
    }

    proptest! {
        #![proptest_config(fixed(2008))]

        /// A contact that bounces by itself, impact by impact, against the closed form of the sum.
        #[test]
        fn a_bounce_tail_is_the_sum_of_its_bounces(
            e in 0.05..0.9, g in 1.0..10.0, other in 1.0..10.0, u in 0.01..1.0, psi in 0.0..0.9, rate in -0.1..1.0,
        ) {
            let m = frozen([g, other], [psi, psi], [e, e]);
            let start = Gaps { h: [0.0, 1e4], u: [u, rate] };
            let (mut at, mut t) = (start, 0.0);
            for _ in 0..MANY {
                let dt = 2.0 * at.u[0] / g;
                at = after_impact(&m, &at, dt, 0);
                t += dt;
            }
            let sum = m.bounce_tail(0, &start).expect("contact 2 is far from the ground");
            prop_assert!((sum - t).abs() <= 1e-13 * t, "{sum} {t}");
            let (end, impulses) = m.end_bounce(0, &start, sum);
            prop_assert!((end.h[1] - at.h[1]).abs() <= 1e-14 * 1e4);
            prop_assert!((end.u[1] - at.u[1]).abs() <= 1e-12 * (rate.abs() + u + other * t));
            // The whole own-rate jump: Σ (1 + e) eʲ u.
            prop_assert!((impulses.jump[0] - u * (1.0 + e) / (1.0 - e)).abs() <= 1e-14 * u / (1.0 - e));
        }

        /// Contacts hit in turn, impact by impact, against the sum and the bound of its error.
        #[test]
        fn a_clattering_tail_is_the_sum_of_its_flights(
            e in 0.02..0.3, psi in 0.95..0.99, weight in 0.0..1e-3, height in 0.1..1.0,
        ) {
            let m = frozen([weight; 2], [psi; 2], [e; 2]);
            prop_assume!(m.chatters());
            let start = Gaps { h: [0.0, height], u: [0.05, -1.0] };
            let tail = m.clatter_tail(0, &start).expect("inside the cone");
            prop_assert!(m.certainly_clatters(0, &start));
            let (mut at, mut t, mut next) = (start, 0.0, 1);
            for _ in 0..MANY {
                // h + u dt − g dt²/2 = 0, the root that is one without gravity, too
                let (h, u) = (at.h[next], at.u[next]);
                let dt = 2.0 * h / (-u + (u * u + 2.0 * weight * h).sqrt());
                if !(h > 0.0 && u < 0.0) {
                    break;
                }
                at = after_impact(&m, &at, dt, next);
                t += dt;
                next = 1 - next;
            }
            // The estimate of the error can be 9 times low.
            let allowed = 9.0 * tail.error + 1e-13 * t;
            prop_assert!((tail.duration - t).abs() <= allowed, "{} {t} {}", tail.duration, tail.error);
        }

        /// Impulses that bring both contacts to rest satisfy the equations of motion and the time integrals of these equations.
        #[test]
        fn impulses_to_rest_fulfil_the_equations_of_motion(
            g in 0.0..10.0, psi in -0.9..0.9_f64, more in 0.1..1.0, h in 0.0..1.0, u in -1.0..1.0, t in 0.1..2.0,
        ) {
            let psi = [psi, psi * more];
            let m = frozen([g, 2.0 * g], psi, [0.4, 0.6]);
            let start = Gaps { h: [h, 0.5 * h], u: [u, -2.0 * u] };
            let Impulses { jump, path } = m.settle(&start, t);
            for i in 0..2 {
                let j = 1 - i;
                let rate = start.u[i] - m.g[i] * t + jump[i] - psi[j] * jump[j];
                let gap = start.h[i] + t * (start.u[i] - 0.5 * m.g[i] * t) + path[i] - psi[j] * path[j];
                let size = 1.0 + start.u[i].abs() + m.g[i] * (t + t * t) + jump[i].abs() + path[i].abs();
                prop_assert!(rate.abs() <= 1e-13 * size / more, "{rate}");
                prop_assert!(gap.abs() <= 1e-13 * size / more, "{gap}");
            }
        }
    }
}
