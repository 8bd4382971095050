//! Clattering up to scale: how the shape and the size of the motion change from impact to impact.
//!
//! The local model has no intrinsic scale: (h, u, t) → (s²h, su, st) maps motions to motions. Let a be the contact just hit, and b the
//! other contact. The state right after the impact is given by two numbers, its *shape*, and by its size:
//!
//! ```text
//! rate v = u_b/u_a     gap y = h_b/u_a²     size u_a > 0
//! ```
//!
//! The units are such that the coupling is symmetric and gravity is one. Rates are k_i u_i and gaps k_i h_i with k_1 = (ψ_1/ψ_2)^¼ = 1/k_2,
//! so the coupling of both contacts is ψ = ±√(ψ_1ψ_2). Times are in units of u/ĝ, ĝ = √(g_1g_2), so gravity is G_i = k_i g_i/ĝ with G_1G_2
//! = 1. The only parameters are the restitutions, ψ and G_1. (For ψ_1 = ψ_2 the size is the take-off rate in m/s.)
//!
//! One step leads from impact to impact and is exact [Or & Rimon 2008, (7)]. If a falls back before b lands (τ_a = 2/G_a):
//!
//! ```text
//! v' = (v − G_b τ_a − (1+e_a)ψ)/e_a     y' = (y + vτ_a − ½G_b τ_a²)/e_a²     f = e_a
//! ```
//!
//! Otherwise b lands first. The roles are exchanged; s is the speed at which b lands after the time τ, and w is the rate of a at that time:
//!
//! ```text
//! s² = v² + 2G_b y     τ = (v + s)/G_b     w = 1 − G_a τ
//! v' = w/(e_b s) − (1+e_b)ψ/e_b     y' = ½τ(1 + w)/(e_b s)²     f = e_b s
//! ```
//!
//! f is the factor of the size. The measure u_a du_a du_b dh_b is the same after a flight, and e² times as large after an
//! impact. The tangent map therefore has the determinant e²/f⁵ in both cases. With the Lyapunov exponents Λ_1 ≥ Λ_2 of the
//! shape, per impact,
//!
//! ```text
//! Λ_1 + Λ_2 = 2⟨ln e⟩ − 5σ,     σ = ⟨ln f⟩
//! ```
//!
//! on every infinite orbit. An orbit ends when one contact bounces alone.

use crate::body::local_model::{LocalModel, LocalModelFields};
use crate::error::{Error, finite, in_range, non_negative};
use crate::flight::parabola_touchdown;
use crate::outcome::ContactNumber;
use crate::stability::clattering::coupling;
use crate::tolerance::SHAPE_AT_REST;
use crate::zeno::{FrozenModel, Gaps};

/// The least restitution for which the reduced map is defined. Below it the take-off speed of an impact is less than the rounding error of
/// the other speeds. (The unit of the shape is the take-off speed, which is zero after a plastic impact.)
const LEAST_RESTITUTION: f64 = 1e-12;
/// Limits of the ratio k_1g_1/(k_2g_2): this number and its inverse. Products of four such numbers are still doubles.
const RATIO: f64 = 1e50;
/// Number of impacts between two calls of `cancel`: some milliseconds.
pub(crate) const CANCEL_INTERVAL: usize = 1 << 16;

/// The state right after an impact, up to scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// The contact that was hit.
    pub contact: ContactNumber,
    /// Gap rate of the other contact, divided by the gap rate of this contact.
    pub rate: f64,
    /// Gap of the other contact, divided by the square of the gap rate of this contact, at unit gravity.
    pub gap: f64,
}

/// A step of the reduced map, from an impact to the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReducedStep {
    /// The shape after the impact.
    pub shape: Shape,
    /// f: the size after the step divided by the size before it.
    pub factor: f64,
    /// Time since the previous impact, in units of the size after that impact.
    pub flight: f64,
    /// Derivative of (rate, gap) with respect to (rate, gap) before the step; its determinant is e²/f⁵.
    pub tangent: [[f64; 2]; 2],
}

/// Why there is no further impact in an orbit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum OrbitEnd {
    /// From now on this contact bounces alone until it rests.
    OneZeno(ContactNumber),
    /// Both contacts land at the same instant.
    Tie,
}

/// The local model up to scale.
///
/// ```
/// use standfast::body::{LocalModel, LocalModelFields};
/// use standfast::stability::{ReducedMap, self_similar};
///
/// // The self-similar orbit is a fixed point: every impact takes the same share of all speeds.
/// let (e, psi) = (0.5, 0.9);
/// let orbit = self_similar(e, psi).unwrap();
/// let (gravity, psi, restitution) = ([1.0; 2], [psi; 2], [e; 2]);
/// let model = LocalModel::new(LocalModelFields { gravity, psi, restitution, ..LocalModelFields::default() })?;
/// let map = ReducedMap::new(&model)?;
/// let shape = map.shape(0, orbit.rate, orbit.gap)?;
/// let step = map.step(&shape).unwrap();
/// assert!((step.factor / orbit.factor - 1.0).abs() < 1e-14);
/// assert!((step.shape.gap / orbit.gap - 1.0).abs() < 1e-13);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct ReducedMap {
    pub(crate) frozen: FrozenModel,
    /// ψ
    pub(crate) psi: f64,
    /// 2/G_i, the time of a bounce that starts with rate 1.
    back: [f64; 2],
    /// k_i
    weights: [f64; 2],
    /// ĝ, in m/s².
    gravity: f64,
}

impl ReducedMap {
    /// The map of a local model.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] unless gravity presses on both contacts, with a ratio from 1e-50 to 1e50, and both restitutions
    /// are at least 1e-12.
    pub fn new(model: &LocalModel) -> Result<Self, Error> {
        let (g, psi, e) = (model.gravity(), model.psi(), model.restitution());
        for i in 0..2 {
            let number = i + 1;
            let allowed = "> 0 in the reduced map";
            in_range(format!("gravity.{number}"), g[i], g[i] > 0.0, allowed)?;
            let allowed = "1e-12 <= restitution < 1 in the reduced map";
            let holds = (LEAST_RESTITUTION..1.0).contains(&e[i]);
            in_range(format!("restitution.{number}"), e[i], holds, allowed)?;
        }
        let coupled = psi[0] != 0.0 && psi[1] != 0.0;
        let weight = if coupled { (psi[0] / psi[1]).sqrt().sqrt() } else { 1.0 };
        let weights = [weight, 1.0 / weight];
        let ratio = weight * weight * (g[0] / g[1]);
        let holds = (1.0 / RATIO..=RATIO).contains(&ratio);
        let field = "gravity.1 / gravity.2 * sqrt(psi.1 / psi.2)";
        in_range(field, ratio, holds, "from 1e-50 to 1e50 in the reduced map")?;
        let reduced = [ratio.sqrt(), 1.0 / ratio.sqrt()];
        let psi = coupling(psi);
        Ok(Self {
            frozen: FrozenModel::new(&LocalModel::frozen(LocalModelFields {
                gravity: reduced,
                psi: [psi, psi],
                restitution: e,
                ..LocalModelFields::default()
            })),
            psi,
            back: reduced.map(|g| 2.0 / g),
            weights,
            gravity: g[0].sqrt() * g[1].sqrt(),
        })
    }

    /// (k_1, k_2): the unit of rates and of gaps at contact i is 1/k_i.
    #[must_use]
    pub fn weights(&self) -> [f64; 2] {
        self.weights
    }

    /// ĝ = √(g_1g_2), in m/s²: the unit of times is the size over ĝ.
    #[must_use]
    pub fn gravity(&self) -> f64 {
        self.gravity
    }

    /// A shape after an impact at contact `index` (from 0).
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] unless `rate` is finite and `gap` is finite and not negative; `index` is 0 or 1.
    pub fn shape(&self, index: usize, rate: f64, gap: f64) -> Result<Shape, Error> {
        in_range("index", index as f64, index < 2, "0 or 1")?;
        finite("rate", rate)?;
        non_negative("gap", gap)?;
        Ok(Shape { contact: ContactNumber::of(index), rate, gap })
    }

    /// Gaps and rates of a shape, at size 1.
    pub(crate) fn gaps(&self, shape: &Shape) -> Gaps {
        let a = shape.contact.index();
        let mut gaps = Gaps::default();
        (gaps.u[a], gaps.u[1 - a], gaps.h[1 - a]) = (1.0, shape.rate, shape.gap);
        gaps
    }

    /// The next impact, if there is one.
    ///
    /// # Errors
    ///
    /// [`OrbitEnd`] if one contact bounces alone from now on, or both land at the same instant.
    #[inline]
    pub fn step(&self, shape: &Shape) -> Result<ReducedStep, OrbitEnd> {
        let a = shape.contact.index();
        let b = 1 - a;
        let (v, y) = (shape.rate, shape.gap);
        let (g_a, g_b) = (self.frozen.g[a], self.frozen.g[b]);
        if self.frozen.bounce_tail(a, &self.gaps(shape)).is_some() {
            return Err(OrbitEnd::OneZeno(shape.contact));
        }
        let s = (v * v + 2.0 * g_b * y).sqrt();
        if s <= SHAPE_AT_REST {
            return Err(OrbitEnd::OneZeno(ContactNumber::of(b)));
        }
        let (tau, back) = (parabola_touchdown(y, v, g_b), self.back[a]);
        if tau == back {
            return Err(OrbitEnd::Tie);
        }
        if back < tau {
            let e = self.frozen.e[a];
            let rate = (v - g_b * back - (1.0 + e) * self.psi) / e;
            let gap = (y + back * (v - 0.5 * g_b * back)).max(0.0) / (e * e);
            return Ok(ReducedStep {
                shape: Shape { contact: shape.contact, rate, gap },
                factor: e,
                flight: back,
                tangent: [[1.0 / e, 0.0], [back / (e * e), 1.0 / (e * e)]],
            });
        }
        let e = self.frozen.e[b];
        let (w, f) = (1.0 - g_a * tau, e * s);
        let rate = w / f - (1.0 + e) * self.psi / e;
        // 1 + w is G_a times the time from the landing of b to that of a: never negative.
        let gap = 0.5 * tau * g_a * (back - tau) / (f * f);
        // Derivatives of s and τ with respect to (v, y); then those of v' and y' by the chain rule.
        let (of_s, of_tau) = ([v / s, g_b / s], [tau / s, 1.0 / s]);
        let row = |by_s: f64, by_tau: f64| [0, 1].map(|k| by_s * of_s[k] + by_tau * of_tau[k]);
        Ok(ReducedStep {
            shape: Shape { contact: ContactNumber::of(b), rate, gap },
            factor: f,
            flight: tau,
            tangent: [row(-w / (f * s), -g_a / f), row(-2.0 * gap / s, w / (f * f))],
        })
    }

    /// The first shape of a motion, with the logarithm of its size and the time until this shape.
    ///
    /// A state right after an impact, with one gap zero and its rate positive, is that shape itself. Any other state is
    /// advanced to its first impact.
    pub(crate) fn start(&self, gaps: [f64; 2], rates: [f64; 2]) -> Result<Start, Error> {
        for i in 0..2 {
            non_negative(format!("gaps.{}", i + 1), gaps[i])?;
            finite(format!("rates.{}", i + 1), rates[i])?;
        }
        // Rates in units of the largest speed, and gaps likewise, without squares that could overflow.
        let rate = |i: usize| self.weights[i] * rates[i];
        let height = |i: usize| (self.weights[i] * gaps[i]).sqrt() * self.gravity.sqrt();
        let size = (0..2).map(|i| rate(i).abs().max(height(i))).fold(0.0, f64::max);
        if size == 0.0 {
            return Ok(Start {
                first: Err(OrbitEnd::Tie),
                log_size: f64::NEG_INFINITY,
                flight: 0.0,
            });
        }
        let u = [0, 1].map(|i| rate(i) / size);
        let h = [0, 1].map(|i| (height(i) / size) * (height(i) / size));
        let g = self.frozen.g;
        let seen = |a: usize, u_a: f64, u_b: f64, h_b: f64, flight: f64| {
            let contact = ContactNumber::of(a);
            let first = Ok(Shape { contact, rate: u_b / u_a, gap: h_b / u_a / u_a });
            Start { first, log_size: libm::log(size) + libm::log(u_a), flight: flight * size }
        };
        if let Some(a) = (0..2).find(|&i| gaps[i] == 0.0 && rates[i] > 0.0) {
            let allowed = "0, or at least 1e-100 of the largest speed in the motion";
            in_range(format!("rates.{}", a + 1), rates[a], u[a] >= SHAPE_AT_REST, allowed)?;
            return Ok(seen(a, u[a], u[1 - a], h[1 - a], 0.0));
        }
        let t = [0, 1].map(|i| parabola_touchdown(h[i], u[i], g[i]));
        if t[0] == t[1] {
            return Ok(Start {
                first: Err(OrbitEnd::Tie),
                log_size: libm::log(size),
                flight: t[0] * size,
            });
        }
        let a = usize::from(t[1] < t[0]);
        let (b, tau) = (1 - a, t[a]);
        let s = (u[a] * u[a] + 2.0 * g[a] * h[a]).sqrt();
        let other = (h[b] + tau * (u[b] - 0.5 * g[b] * tau)).max(0.0);
        if s <= SHAPE_AT_REST {
            let first = Err(OrbitEnd::OneZeno(ContactNumber::of(a)));
            return Ok(Start { first, log_size: libm::log(size), flight: tau * size });
        }
        let e = self.frozen.e[a];
        let after = u[b] - g[b] * tau - (1.0 + e) * self.psi * s;
        Ok(seen(a, e * s, after, other, tau))
    }
}

/// The first shape of a motion, or why there is none.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) first: Result<Shape, OrbitEnd>,
    /// ln u_a
    pub(crate) log_size: f64,
    /// Time until this shape, in units of 1/ĝ.
    pub(crate) flight: f64,
}

/// The impacts of a motion, one by one: shapes, sizes and times of flight, at any scale.
///
/// For impact k at contact a, with k_i the weights and ĝ the gravity of the [`ReducedMap`] and U the exponential of `log_sizes[k]`:
///
/// ```text
/// u_a = U/k_a     u_b = rate U/k_b     h_b = gap U²/(ĝ k_b)     time since impact k − 1: flights[k] U_{k−1}/ĝ
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Orbit {
    /// Shape after each impact.
    pub shapes: Vec<Shape>,
    /// Natural logarithm of the size k_a u_a, in ln(m/s).
    pub log_sizes: Vec<f64>,
    /// Time since the previous impact, in units of the size after that impact over ĝ. The first entry is the time since the start, in units
    /// of 1/ĝ.
    pub flights: Vec<f64>,
    /// Why no impact follows; `None` if the requested number was found.
    pub end: Option<OrbitEnd>,
}

/// Mean growth per impact along an orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exponents {
    /// σ: mean logarithm of the factor of all speeds.
    pub sigma: f64,
    /// Λ_1 ≥ Λ_2: Lyapunov exponents of the shape.
    pub lyapunov: [f64; 2],
    /// Standard error of σ, from the scatter of the means over [`BATCHES`] parts of the orbit.
    pub sigma_error: f64,
    /// Standard error of each Lyapunov exponent.
    pub lyapunov_error: [f64; 2],
    /// Number of impacts in the means: as many as requested, or fewer if the orbit ends.
    pub hits: usize,
    /// Why the orbit ends, if it does.
    pub end: Option<OrbitEnd>,
}

/// Number of parts of an orbit whose means give the standard error.
pub const BATCHES: usize = 32;

impl ReducedMap {
    /// The first `n` impacts of a motion, up to scale; fewer if one contact bounces alone or both land at the same instant.
    ///
    /// Row 0 is the given state if that is right after an impact (one gap is zero and its rate positive). Otherwise row 0 is the state
    /// after the first impact.
    ///
    /// # Errors
    ///
    /// A state that is not finite or lies in the terrain.
    pub fn orbit(&self, gaps: [f64; 2], rates: [f64; 2], n: usize) -> Result<Orbit, Error> {
        let start = self.start(gaps, rates)?;
        let mut orbit =
            Orbit { shapes: Vec::new(), log_sizes: Vec::new(), flights: Vec::new(), end: None };
        let mut put = |shape: Shape, log_size: f64, flight: f64| {
            orbit.shapes.push(shape);
            orbit.log_sizes.push(log_size);
            orbit.flights.push(flight);
        };
        let (mut log_size, mut flight) = (start.log_size, start.flight);
        let mut next = start.first;
        for _ in 0..n {
            let Ok(shape) = next else { break };
            put(shape, log_size, flight);
            next = self.step(&shape).map(|step| {
                log_size += libm::log(step.factor);
                flight = step.flight;
                step.shape
            });
        }
        orbit.end = next.err().filter(|_| orbit.shapes.len() < n);
        Ok(orbit)
    }

    /// Mean growth of size and shape over `n` impacts, after `transient` others.
    ///
    /// # Errors
    ///
    /// As [`ReducedMap::orbit`]; [`Error::Cancelled`] once `cancel`, which is called from time to time, returns true.
    pub fn exponents(
        &self,
        gaps: [f64; 2],
        rates: [f64; 2],
        n: usize,
        transient: usize,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Exponents, Error> {
        let mut next = self.start(gaps, rates)?.first;
        let mut frame = [1.0, 0.0];
        let mut means = Means::new(n);
        for k in 0..transient.saturating_add(n) {
            let Ok(shape) = next else { break };
            if k % CANCEL_INTERVAL == CANCEL_INTERVAL - 1 && cancel() {
                return Err(Error::Cancelled);
            }
            next = self.step(&shape).map(|step| {
                let stretch = stretched(&mut frame, &step.tangent);
                if k >= transient {
                    means.add([step.factor, stretch[0], stretch[1]].map(libm::log));
                }
                step.shape
            });
        }
        let end = next.err().filter(|_| means.hits < n);
        Ok(means.exponents(end))
    }
}

/// Multiplies the orthonormal matrix Q by the tangent map A and factorises A Q = Q' R, with R triangular. `frame` is the first column of Q,
/// and then of Q'. Returns the diagonal of R: the stretching factors along `frame` and across it.
fn stretched(frame: &mut [f64; 2], a: &[[f64; 2]; 2]) -> [f64; 2] {
    let image = |x: [f64; 2]| [0, 1].map(|i| a[i][0] * x[0] + a[i][1] * x[1]);
    let (along, across) = (image(*frame), image([-frame[1], frame[0]]));
    let length = libm::hypot(along[0], along[1]);
    *frame = along.map(|x| x / length);
    [length, (frame[0] * across[1] - frame[1] * across[0]).abs()]
}

/// Sums of three quantities over the parts of an orbit.
struct Means {
    sums: [[f64; 3]; BATCHES],
    counts: [usize; BATCHES],
    hits: usize,
    /// Number of impacts in a part.
    length: usize,
}

impl Means {
    fn new(n: usize) -> Self {
        let length = n.div_ceil(BATCHES).max(1);
        Self { sums: [[0.0; 3]; BATCHES], counts: [0; BATCHES], hits: 0, length }
    }

    fn add(&mut self, values: [f64; 3]) {
        let part = self.hits / self.length;
        for (sum, value) in self.sums[part].iter_mut().zip(values) {
            *sum += value;
        }
        self.counts[part] += 1;
        self.hits += 1;
    }

    /// The mean, and its standard error from the full parts.
    fn of(&self, k: usize) -> (f64, f64) {
        let mean = self.sums.iter().map(|sum| sum[k]).sum::<f64>() / self.hits as f64;
        let full = (0..BATCHES).filter(|&part| self.counts[part] == self.length);
        let parts = full.clone().count() as f64;
        let length = self.length as f64;
        let scatter: f64 = full
            .map(|part| {
                let off = self.sums[part][k] / length - mean;
                off * off
            })
            .sum();
        (mean, (scatter / (parts * (parts - 1.0))).sqrt())
    }

    fn exponents(&self, end: Option<OrbitEnd>) -> Exponents {
        let [(sigma, sigma_error), first, second] = [0, 1, 2].map(|k| self.of(k));
        Exponents {
            sigma,
            lyapunov: [first.0, second.0],
            sigma_error,
            lyapunov_error: [first.1, second.1],
            hits: self.hits,
            end,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(e: [f64; 2], psi: f64, gravity: [f64; 2]) -> ReducedMap {
        ReducedMap::new(
            &LocalModel::new(LocalModelFields {
                gravity,
                psi: [psi, psi],
                restitution: e,
                ..LocalModelFields::default()
            })
            .unwrap(),
        )
        .unwrap()
    }

    /// Shapes followed by an impact at the same contact or at the other one, with unequal contacts and both signs of ψ.
    fn cases() -> impl Iterator<Item = (ReducedMap, Shape, ReducedStep)> {
        let models = [
            ([0.9, 0.9], 0.22, [1.0, 1.0]),
            ([0.6, 0.8], 0.5, [1.0, 3.0]),
            ([0.7, 0.5], -0.4, [2.0, 1.0]),
        ];
        models.into_iter().flat_map(|(e, psi, g)| {
            let map = map(e, psi, g);
            (0..200).filter_map(move |k| {
                let (v, y) = (
                    2.0 * (f64::from(k) * 0.618).fract() - 1.2,
                    (f64::from(k) * 0.414).fract() * 2.0 + 0.01,
                );
                let shape = map.shape((k % 2) as usize, v, y).unwrap();
                map.step(&shape).ok().map(|step| (map, shape, step))
            })
        })
    }

    #[test]
    fn the_tangent_is_the_difference_quotient() {
        // Central differences: error h²f‴/6 plus rounding 1e-16/h, below 1e-8 of the entries here.
        const H: f64 = 1e-5;
        let mut kinds = [0; 2];
        for (map, shape, step) in cases() {
            let near = |dv: f64, dy: f64| {
                map.step(&Shape { rate: shape.rate + dv, gap: shape.gap + dy, ..shape })
                    .ok()
                    .filter(|near| near.shape.contact == step.shape.contact)
                    .map(|near| [near.shape.rate, near.shape.gap])
            };
            let all = (near(H, 0.0), near(-H, 0.0), near(0.0, H), near(0.0, -H));
            let (Some(v1), Some(v0), Some(y1), Some(y0)) = all else { continue };
            let scale = step.tangent.iter().flatten().fold(1.0, |m: f64, x| m.max(x.abs()));
            for i in 0..2 {
                for (k, d) in [v1[i] - v0[i], y1[i] - y0[i]].into_iter().enumerate() {
                    let error = d / (2.0 * H) - step.tangent[i][k];
                    assert!(error.abs() < 1e-5 * scale, "{shape:?}: {error} of {:?}", step.tangent);
                }
            }
            kinds[usize::from(step.shape.contact == shape.contact)] += 1;
        }
        assert!(kinds[0] > 50 && kinds[1] > 50, "{kinds:?}");
    }

    #[test]
    fn the_determinant_is_the_share_of_the_measure() {
        for (map, shape, step) in cases() {
            let [[p, q], [r, s]] = step.tangent;
            let e = map.frozen.e[step.shape.contact.index()];
            let expected = e * e / step.factor.powi(5);
            let scale = (p * s).abs() + (q * r).abs();
            assert!((p * s - q * r - expected).abs() < 1e-14 * scale, "{shape:?}");
        }
    }

    #[test]
    fn what_cannot_be_reduced_is_named() {
        let model = |g, e| {
            LocalModel::new(LocalModelFields {
                gravity: g,
                psi: [0.5, 0.5],
                restitution: e,
                ..LocalModelFields::default()
            })
            .unwrap()
        };
        for (model, words) in [
            (model([0.0, 1.0], [0.5, 0.5]), "gravity.1 = 0.0"),
            (model([1.0, 1.0], [0.5, 0.0]), "restitution.2 = 0.0"),
            (model([1e60, 1.0], [0.5, 0.5]), "gravity.1 / gravity.2 * sqrt(psi.1 / psi.2) = 1e60"),
        ] {
            let error = ReducedMap::new(&model).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
