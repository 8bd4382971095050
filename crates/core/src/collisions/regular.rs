//! Regular motion of two contacts that are hit in turn, towards e = 1: the sum of all its flights.
//!
//! The motion is described right after an impact at the same contact a. Its size is s = E/E_0, with the energy E and E_0 its value now; its shape is
//! z = (u_a, u_b)/√E. Both determine the state up to the place along the ground. Two impacts later the shape is M(z, s), and √E has become f(z, s)√E.
//! The time until both contacts rest is √E S(z, s), with
//!
//! ```text
//! S(z, s) = τ(z, s) + f(z, s) S(M(z, s), f² s)
//! ```
//!
//! and τ√E the duration of these two flights. In the local model gravity and geometry are constant: τ, f, M and S do not depend on s.
//!
//! Near a fixed point of M that nothing leaves, the shape stays in a small disc about it in the coordinates ζ in which the
//! tangent map is a rotation and a contraction. There, S = A + B(ζ, s) with a constant A and a polynomial B, from the least squares of
//!
//! ```text
//! B(ζ, s) − f B(M(ζ, s), f² s) = τ − (1 − f) A
//! ```
//!
//! at points of the disc, for several s from 0 to 1. 1 − f is computed from the energy that the impacts take, so that no digit is lost.
//!
//! What is left of the equation, r(z, s), is an error Σ fⁿ r(z_n, s_n) of S along the motion. The sums P_n = r_0 + … + r_n are
//! followed for N cycles. They grow by a mean m = P_N/N, known up to C/N, and deviate from that by at most C: the error is
//! estimated as (|m| + C/N)/(1 − f) + C. This is the largest of several motions, because shapes come nearer to the fixed point and sizes
//! shrink. It is no proved bound.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use crate::tolerance::{
    REGULAR_DRIFT, REGULAR_ERROR, REGULAR_LOSS, REGULAR_PROMISING, REGULAR_RADIUS, REGULAR_TANGENT,
};
use crate::zeno::FrozenModel;

/// Number of collisions after which a sum of a regular motion is first tried; then after twice as many, and so on.
pub(crate) const REGULAR: usize = 1000;
/// Cycles that are followed to see how large the disc has to be.
const FOLLOWED: usize = 256;
/// Distances from the fixed point, in units of that of the start, from which motions test the sum, and their cycles.
const ORBITS: [f64; 4] = [1.0, 0.7, 0.4, 0.0];
const TESTED: usize = 500;
/// Radius of the disc in units of the largest distance of these shapes from the fixed point.
const MARGIN: f64 = 1.1;
/// Most steps to the fixed point.
const NEWTON: usize = 30;

/// (u_1, u_2, h_2) after an impact at contact 1.
type Landed = [f64; 3];

/// The sum of the flights of a regular motion, up to rest of both contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegularSum {
    pub(crate) duration: f64,
    pub(crate) error: f64,
}

/// A cycle of two impacts, from a shape and a size.
pub(crate) struct Cycle {
    pub(crate) z: Vector2<f64>,
    /// Duration of the two flights, in units of √E.
    pub(crate) tau: f64,
    /// 1 − f
    pub(crate) loss: f64,
}

impl Cycle {
    /// From the rates after it and the duration, in units of √E, and the energy that the impacts take, in units of E.
    pub(crate) fn new(rates: [f64; 2], tau: f64, taken: f64) -> Self {
        let root = (1.0 - taken).sqrt();
        Self { z: Vector2::from(rates) / root, tau, loss: taken / (1.0 + root) }
    }

    /// The size at its end.
    fn size(&self, before: f64) -> f64 {
        before * ((1.0 - self.loss) * (1.0 - self.loss))
    }
}

/// A motion on two contacts.
pub(crate) trait Regular {
    /// The polynomials that are tried, those with few terms first.
    const BASES: &'static [Basis];
    /// Sizes from which motions test the sum.
    const SIZES: &'static [f64];

    /// The next two impacts; `None`: they are not in turn.
    fn cycle(&self, z: &Vector2<f64>, size: f64) -> Option<Cycle>;
}

/// The constants of the local model. E = ½ u·D⁻¹u + D⁻¹g·h with D_11 = 1, D_12 = −ψ_1, D_22 = ψ_1/ψ_2.
struct Local<'m> {
    model: &'m FrozenModel,
    /// (D⁻¹)_11, (D⁻¹)_12, (D⁻¹)_22
    inverse: [f64; 3],
    /// D⁻¹g of contact 2.
    force: f64,
    /// Energy that an impact takes, per squared landing speed: (1 − e²)/(2 D_ii).
    taken: [f64; 2],
}

impl<'m> Local<'m> {
    /// `None`: the contacts are not coupled as those of a body that gravity presses to both.
    fn new(model: &'m FrozenModel) -> Option<Self> {
        let [psi, other] = model.psi;
        let (ratio, pressed) = (psi / other, model.solve_coupled(model.g));
        let determinant = ratio - psi * psi;
        let regular = psi > 0.0 && other > 0.0 && determinant > 0.0;
        if !(regular && model.g.iter().chain(&pressed).all(|g| *g > 0.0)) {
            return None;
        }
        let inverse = [ratio, psi, 1.0].map(|x| x / determinant);
        let force = inverse[1] * model.g[0] + inverse[2] * model.g[1];
        let share = |i: usize| 0.5 * (1.0 - model.e[i]) * (1.0 + model.e[i]);
        Some(Self { model, inverse, force, taken: [share(0), share(1) / ratio] })
    }

    fn of_speeds(&self, [one, two]: [f64; 2]) -> f64 {
        let [a, b, c] = self.inverse;
        0.5 * (a * one * one + c * two * two) + b * one * two
    }

    fn energy(&self, [one, two, gap]: Landed) -> f64 {
        self.of_speeds([one, two]) + self.force * gap
    }

    /// The state of this shape with the energy 1.
    fn state(&self, z: &Vector2<f64>) -> Landed {
        [z.x, z.y, (1.0 - self.of_speeds([z.x, z.y])) / self.force]
    }
}

impl Regular for Local<'_> {
    const BASES: &'static [Basis] = &[Basis { degree: 12, powers: 0 }];
    const SIZES: &'static [f64] = &[1.0];

    fn cycle(&self, z: &Vector2<f64>, _: f64) -> Option<Cycle> {
        let m = self.model;
        let mut now = self.state(z);
        let (mut tau, mut taken) = (0.0, 0.0);
        for a in 0..2 {
            let (b, [u_a, u_b, h_b]) = (1 - a, now);
            let s = (u_b * u_b + 2.0 * m.g[b] * h_b).sqrt();
            let dt = 2.0 * h_b / (s - u_b);
            let w = u_a - m.g[a] * dt;
            // The contact hit last is in the air until the other one lands.
            if !(h_b > 0.0 && u_b < 0.0 && u_a + w > 0.0) {
                return None;
            }
            now = [m.e[b] * s, w - m.kappa[b] * s, 0.5 * dt * (u_a + w)];
            tau += dt;
            taken += self.taken[b] * s * s;
        }
        Some(Cycle::new([now[0], now[1]], tau, taken))
    }
}

/// The fixed point of M of this size next to this shape, and the tangent map there.
fn fixed_point(
    motion: &impl Regular,
    mut z: Vector2<f64>,
    size: f64,
) -> Option<(Vector2<f64>, Matrix2<f64>)> {
    let mut last = f64::INFINITY;
    for _ in 0..NEWTON {
        let column = |d: Vector2<f64>| {
            let [up, down] = [z + d, z - d].map(|z| motion.cycle(&z, size));
            Some((up?.z - down?.z) / (2.0 * REGULAR_TANGENT))
        };
        let tangent = Matrix2::from_columns(&[
            column(Vector2::new(REGULAR_TANGENT, 0.0))?,
            column(Vector2::new(0.0, REGULAR_TANGENT))?,
        ]);
        let step = (Matrix2::identity() - tangent).lu().solve(&(motion.cycle(&z, size)?.z - z))?;
        z += step;
        if step.norm() >= last {
            return (last <= REGULAR_TANGENT * REGULAR_TANGENT).then_some((z, tangent));
        }
        last = step.norm();
    }
    None
}

/// Discs of shapes, one of each size.
struct Discs {
    /// The centre, a polynomial c_0 + (s − ¼)(c_1 + (s − ½)c_2): through the fixed points of the sizes ¼, ½ and 1.
    center: [Vector2<f64>; 3],
    /// Columns: ζ = 1 and ζ = i on the rim.
    axes: Matrix2<f64>,
    inverse: Matrix2<f64>,
}

impl Discs {
    /// About these fixed points, in the coordinates in which the tangent map rotates; `None` if it does not, or if shapes move away.
    fn new(center: [Vector2<f64>; 3], tangent: &Matrix2<f64>, loss: f64) -> Option<Self> {
        let half = 0.5 * tangent.trace();
        let beta = (tangent.determinant() - half * half).sqrt();
        // While the motion decays, shapes may move away by a small part of their distance only.
        if !(beta > 0.0 && tangent.determinant() <= 1.0 + REGULAR_DRIFT * loss) {
            return None;
        }
        let axes = Matrix2::new(tangent.m12, 0.0, half - tangent.m11, beta);
        let axes = axes / axes.determinant().abs().sqrt();
        Some(Self { center, axes, inverse: axes.try_inverse()? })
    }

    fn scaled(self, radius: f64) -> Self {
        Self { axes: self.axes * radius, inverse: self.inverse / radius, ..self }
    }

    fn center(&self, size: f64) -> Vector2<f64> {
        let [zero, one, two] = self.center;
        zero + (one + two * (size - 0.5)) * (size - 0.25)
    }

    fn zeta(&self, z: &Vector2<f64>, size: f64) -> Vector2<f64> {
        self.inverse * (z - self.center(size))
    }
}

/// The monomials of B: ζ of degree at most `degree` − k times (2s − 1)^k, for k ≤ `powers`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Basis {
    pub(crate) degree: usize,
    pub(crate) powers: usize,
}

impl Basis {
    fn of_degree(degree: usize) -> usize {
        (degree + 1) * (degree + 2) / 2
    }

    fn count(&self) -> usize {
        (0..=self.powers).map(|k| Self::of_degree(self.degree - k)).sum()
    }

    /// Their values.
    fn terms(&self, zeta: Vector2<f64>, size: f64, terms: &mut [f64]) {
        terms[0] = 1.0;
        let mut start = 0;
        for degree in 1..=self.degree {
            let next = start + degree;
            for i in 0..degree {
                terms[next + i] = terms[start + i] * zeta.x;
            }
            terms[next + degree] = terms[next - 1] * zeta.y;
            start = next;
        }
        let mut written = Self::of_degree(self.degree);
        let mut power = 1.0;
        for k in 1..=self.powers {
            power *= 2.0 * size - 1.0;
            let count = Self::of_degree(self.degree - k);
            for i in 0..count {
                terms[written + i] = terms[i] * power;
            }
            written += count;
        }
    }

    /// Shapes ζ and sizes at which the equation is solved.
    fn points(&self) -> impl Iterator<Item = (Vector2<f64>, f64)> {
        let (circles, on_circle) = (self.degree / 2 + 2, 2 * self.degree + 3);
        let sizes = if self.powers == 0 { 1 } else { self.powers + 2 };
        (0..sizes * circles * on_circle).map(move |n| {
            let (size, n) = (n / (circles * on_circle), n % (circles * on_circle));
            let radius = libm::sin(FRAC_PI_2 * (count(n / on_circle) + 0.5) / count(circles));
            let (y, x) = libm::sincos(TAU * count(n % on_circle) / count(on_circle));
            let size = 0.5 - 0.5 * libm::cos(PI * (count(size) + 0.5) / count(sizes));
            (Vector2::new(x, y) * radius, size)
        })
    }
}

/// S = A + B in the discs.
struct Solution<'d> {
    discs: &'d Discs,
    basis: Basis,
    whole: f64,
    coefficients: DVector<f64>,
}

impl<'d> Solution<'d> {
    fn new(motion: &impl Regular, discs: &'d Discs, basis: Basis, whole: f64) -> Option<Self> {
        let (unknowns, rows) = (basis.count(), basis.points().count());
        let mut matrix = DMatrix::zeros(rows, unknowns);
        let mut right = DVector::zeros(rows);
        let (mut own, mut next) = (vec![0.0; unknowns], vec![0.0; unknowns]);
        for (i, (zeta, size)) in basis.points().enumerate() {
            let cycle = motion.cycle(&(discs.center(size) + discs.axes * zeta), size)?;
            let after = cycle.size(size);
            basis.terms(zeta, size, &mut own);
            basis.terms(discs.zeta(&cycle.z, after), after, &mut next);
            for k in 0..unknowns {
                matrix[(i, k)] = own[k] - (1.0 - cycle.loss) * next[k];
            }
            right[i] = cycle.tau - cycle.loss * whole;
        }
        let factors = matrix.qr();
        factors.q_tr_mul(&mut right);
        let coefficients = factors.r().solve_upper_triangular(&right.rows(0, unknowns))?;
        Some(Self { discs, basis, whole, coefficients })
    }

    /// B
    fn rest(&self, z: &Vector2<f64>, size: f64, terms: &mut [f64]) -> f64 {
        self.basis.terms(self.discs.zeta(z, size), size, terms);
        terms.iter().zip(self.coefficients.iter()).map(|(a, b)| a * b).sum()
    }

    /// The error of S, from motions that begin at several sizes and at several distances from the fixed point, that of the start being `zeta`.
    fn error<M: Regular>(&self, motion: &M, zeta: Vector2<f64>) -> Option<f64> {
        let cycles = TESTED / M::SIZES.len();
        let mut terms = vec![0.0; self.basis.count()];
        let mut error = 0.0_f64;
        let mut sums = Vec::with_capacity(TESTED);
        for (from, share) in M::SIZES.iter().flat_map(|s| ORBITS.map(|share| (*s, share))) {
            let mut size = from;
            let mut z = self.discs.center(size) + self.discs.axes * (zeta * share);
            let (mut total, mut spread, mut least) = (0.0, 0.0_f64, 1.0_f64);
            let mut own = self.rest(&z, size, &mut terms);
            sums.clear();
            for _ in 0..cycles {
                let cycle = motion.cycle(&z, size)?;
                size = cycle.size(size);
                let next = self.rest(&cycle.z, size, &mut terms);
                let time = cycle.tau - cycle.loss * self.whole;
                total += own - (1.0 - cycle.loss) * next - time;
                sums.push(total);
                (own, z, least) = (next, cycle.z, least.min(cycle.loss));
            }
            let mean = total / count(cycles);
            for (n, sum) in sums.iter().enumerate() {
                spread = spread.max((sum - mean * count(n + 1)).abs());
            }
            error = error.max((mean.abs() + spread / count(cycles)) / least + spread);
        }
        Some(error)
    }
}

/// The sum of all flights of a motion of this shape with this root of its energy, if it is regular, ends within `left` (s) after this elapsed time
/// (s), and the error of the sum is small.
pub(crate) fn sum<M: Regular>(
    motion: &M,
    start: Vector2<f64>,
    root: f64,
    [elapsed, left]: [f64; 2],
) -> Option<RegularSum> {
    let mut followed = Vec::with_capacity(FOLLOWED);
    let (mut z, mut size) = (start, 1.0);
    for _ in 0..FOLLOWED {
        followed.push((z, size));
        let cycle = motion.cycle(&z, size)?;
        if !(cycle.loss <= REGULAR_LOSS) {
            return None;
        }
        (z, size) = (cycle.z, cycle.size(size));
    }
    let mean = followed.iter().map(|(z, _)| z).sum::<Vector2<f64>>() / count(FOLLOWED);
    let (one, tangent) = fixed_point(motion, mean, 1.0)?;
    let half = fixed_point(motion, one, 0.5)?.0;
    let quarter = fixed_point(motion, half, 0.25)?.0;
    let slopes = [(half - quarter) * 4.0, (one - half) * 2.0];
    let center = [quarter, slopes[0], (slopes[1] - slopes[0]) / 0.75];
    let middle = motion.cycle(&one, 1.0)?;
    let whole = middle.tau / middle.loss;
    if !(0.5 * root * whole <= left) {
        return None;
    }
    let discs = Discs::new(center, &tangent, middle.loss)?;
    let radius =
        followed.iter().map(|(z, size)| discs.zeta(z, *size).norm()).fold(REGULAR_RADIUS, f64::max);
    let discs = discs.scaled(MARGIN * radius);
    let zeta = discs.zeta(&start, 1.0);
    for basis in M::BASES {
        let solution = Solution::new(motion, &discs, *basis, whole)?;
        let duration = root * (whole + solution.rest(&start, 1.0, &mut vec![0.0; basis.count()]));
        let (error, most) =
            (root * solution.error(motion, zeta)?, REGULAR_ERROR * (elapsed + duration));
        if error <= most {
            return (duration <= left).then_some(RegularSum { duration, error });
        }
        if !(error <= REGULAR_PROMISING * most) {
            return None;
        }
    }
    None
}

/// The same of the local model, from this state after an impact at contact 1.
pub(crate) fn local_sum(m: &FrozenModel, state: Landed, time: [f64; 2]) -> Option<RegularSum> {
    let motion = Local::new(m)?;
    let root = motion.energy(state).sqrt();
    sum(&motion, Vector2::new(state[0], state[1]) / root, root, time)
}

fn count(of: usize) -> f64 {
    of as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::local_model::{LocalModel, LocalModelFields};
    use crate::math::clock::Clock;

    fn frozen(gravity: [f64; 2], psi: [f64; 2], restitution: [f64; 2]) -> FrozenModel {
        let fields = LocalModelFields { gravity, psi, phi: [0.0; 2], restitution };
        FrozenModel::new(&LocalModel::new(fields).expect("a local model"))
    }

    /// Cycle by cycle, the times added from the last one.
    fn followed(motion: &Local, start: Vector2<f64>) -> f64 {
        // The logarithm of √E in two parts: near the fixed point all roundings are alike, and would add up.
        let (mut z, mut log, mut times) = (start, Clock::default(), Vec::new());
        while log.hi < 44.0 {
            let cycle = motion.cycle(&z, 1.0).expect("impacts in turn");
            times.push(libm::exp(-log.hi) * cycle.tau);
            (z, log) = (cycle.z, log.after(-libm::log1p(-cycle.loss)));
        }
        times.iter().rev().sum()
    }

    /// A start beside the fixed point, at this distance.
    fn beside(motion: &Local, off: f64) -> Vector2<f64> {
        let turns = |tangent: &Matrix2<f64>| tangent.determinant() > 0.25 * tangent.trace().powi(2);
        let found = (0..9)
            .map(|k| Vector2::new(0.86, -0.7 + 0.05 * f64::from(k)))
            .filter_map(|near| fixed_point(motion, near, 1.0))
            .find(|(_, tangent)| turns(tangent));
        found.expect("a cycle").0 + Vector2::new(off, 0.3 * off)
    }

    #[test]
    fn the_sum_is_that_of_its_cycles() {
        for (gravity, psi, e, off) in [
            ([9.81; 2], [0.72; 2], [0.9999; 2], 0.05),
            ([9.81; 2], [0.72; 2], [0.9999; 2], 0.0),
            ([9.81; 2], [0.72; 2], [0.99995; 2], 0.02),
            ([9.81; 2], [0.5; 2], [0.9999; 2], 0.02),
            ([9.81; 2], [0.6; 2], [0.9999; 2], 0.02),
            ([9.81; 2], [0.8; 2], [0.9999; 2], 0.02),
            ([9.0, 11.0], [0.75, 0.7], [0.9999, 0.9998], 0.02),
        ] {
            let m = frozen(gravity, psi, e);
            let motion = Local::new(&m).expect("pressed contacts");
            let start = beside(&motion, off);
            let all = followed(&motion, start);
            let RegularSum { duration, error } =
                local_sum(&m, motion.state(&start), [all, f64::INFINITY]).expect("a sum");
            let wrong = (duration - all).abs();
            assert!(wrong <= 2.0 * error + 1e-14 * all, "{psi:?} {e:?} {wrong:e} {error:e}");
        }
    }

    /// Shapes that move away from the fixed point, a wide motion, and one with few impacts.
    #[test]
    fn what_is_not_regular_has_no_sum() {
        for (gravity, psi, e, off) in [
            ([9.0, 11.0], [0.5, 0.45], [0.9999, 0.9998], 0.002),
            ([9.81; 2], [0.5; 2], [0.9999; 2], 0.05),
            ([9.81; 2], [0.72; 2], [0.99; 2], 0.02),
        ] {
            let m = frozen(gravity, psi, e);
            let motion = Local::new(&m).expect("pressed contacts");
            let start = beside(&motion, off);
            assert_eq!(local_sum(&m, motion.state(&start), [1e3, f64::INFINITY]), None);
        }
    }
}
