//! Regular motion of two contacts that are hit in turn, towards e = 1: the sum of all its flights.
//!
//! Gravity is constant in the local model. So the motion from a state with the energy E is that from a state of the same shape with the energy 1, with
//! times multiplied by √E and gaps by E. After an impact at contact 1 the shape is z = (u_1, u_2)/√E; the gap of contact 2 follows from the energy.
//! Two impacts later the shape is M(z), and √E has become f(z)√E. The time until both contacts rest is √E S(z), with
//!
//! ```text
//! S(z) = τ(z) + f(z) S(M(z)),
//! ```
//!
//! τ the duration of these two flights. Near a fixed point of M that nothing leaves, the shape stays in a small disc in the coordinates ζ in which the
//! tangent map is a rotation and a contraction. There, S = A + B(ζ) with a constant A and a polynomial B, from the least squares of
//!
//! ```text
//! B(ζ) − f B(M ζ) = τ − (1 − f) A
//! ```
//!
//! at points of the disc. 1 − f is computed from the energy that the impacts take, so that no digit is lost.
//!
//! What is left of the equation, r(z), is an error Σ fⁿ r(z_n) of S along the shapes z_n of the motion. Their sums P_n = r(z_0) + … + r(z_n) are
//! followed for N cycles. They grow by a mean m = P_N/N, known up to C/N, and deviate from that by at most C: the error is
//! estimated as (|m| + C/N)/(1 − f) + C. This is the largest of several motions, because shapes come nearer to the fixed point. It is no proved bound.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{DMatrix, DVector, Matrix2, Vector2};

use crate::tolerance::{
    REGULAR_DRIFT, REGULAR_ERROR, REGULAR_LOSS, REGULAR_RADIUS, REGULAR_TANGENT,
};
use crate::zeno::FrozenModel;

/// Degree of the polynomial B.
const DEGREE: usize = 12;
/// Number of coefficients of B.
const TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;
/// Circles, and points of each, at which the equation is solved.
const CIRCLES: usize = DEGREE / 2 + 2;
const ON_CIRCLE: usize = 2 * DEGREE + 3;
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

/// A cycle of two impacts from a shape with the energy 1.
struct Cycle {
    z: Vector2<f64>,
    /// Duration of the two flights.
    tau: f64,
    /// 1 − f
    loss: f64,
}

/// E = ½ u·D⁻¹u + D⁻¹g·h with D_11 = 1, D_12 = −ψ_1, D_22 = ψ_1/ψ_2.
struct Energy {
    /// (D⁻¹)_11, (D⁻¹)_12, (D⁻¹)_22
    inverse: [f64; 3],
    /// D⁻¹g of contact 2.
    force: f64,
    /// Energy that an impact takes, per squared landing speed: (1 − e²)/(2 D_ii).
    taken: [f64; 2],
}

impl Energy {
    /// `None`: the contacts are not coupled as those of a body that gravity presses to both.
    fn new(m: &FrozenModel) -> Option<Self> {
        let [psi, other] = m.psi;
        let (ratio, pressed) = (psi / other, m.solve_coupled(m.g));
        let determinant = ratio - psi * psi;
        let regular = psi > 0.0 && other > 0.0 && determinant > 0.0;
        if !(regular && m.g.iter().chain(&pressed).all(|g| *g > 0.0)) {
            return None;
        }
        let inverse = [ratio, psi, 1.0].map(|x| x / determinant);
        let force = inverse[1] * m.g[0] + inverse[2] * m.g[1];
        let share = |i: usize| 0.5 * (1.0 - m.e[i]) * (1.0 + m.e[i]);
        Some(Self { inverse, force, taken: [share(0), share(1) / ratio] })
    }

    fn of_speeds(&self, [one, two]: [f64; 2]) -> f64 {
        let [a, b, c] = self.inverse;
        0.5 * (a * one * one + c * two * two) + b * one * two
    }

    fn of(&self, [one, two, gap]: Landed) -> f64 {
        self.of_speeds([one, two]) + self.force * gap
    }

    /// The state of this shape with the energy 1.
    fn state(&self, z: &Vector2<f64>) -> Landed {
        [z.x, z.y, (1.0 - self.of_speeds([z.x, z.y])) / self.force]
    }

    /// `None`: the next two impacts are not in turn.
    fn cycle(&self, m: &FrozenModel, z: &Vector2<f64>) -> Option<Cycle> {
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
        let root = (1.0 - taken).sqrt();
        Some(Cycle { z: Vector2::new(now[0], now[1]) / root, tau, loss: taken / (1.0 + root) })
    }

    /// The fixed point of M next to this shape, and the tangent map there.
    fn fixed_point(
        &self,
        m: &FrozenModel,
        mut z: Vector2<f64>,
    ) -> Option<(Vector2<f64>, Matrix2<f64>)> {
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON {
            let column = |d: Vector2<f64>| {
                let [up, down] = [z + d, z - d].map(|z| self.cycle(m, &z));
                Some((up?.z - down?.z) / (2.0 * REGULAR_TANGENT))
            };
            let tangent = Matrix2::from_columns(&[
                column(Vector2::new(REGULAR_TANGENT, 0.0))?,
                column(Vector2::new(0.0, REGULAR_TANGENT))?,
            ]);
            let step = (Matrix2::identity() - tangent).lu().solve(&(self.cycle(m, &z)?.z - z))?;
            z += step;
            if step.norm() >= last {
                return (last <= REGULAR_TANGENT * REGULAR_TANGENT).then_some((z, tangent));
            }
            last = step.norm();
        }
        None
    }
}

/// A disc of shapes: centre, and the columns of ζ = 1 and ζ = i on its rim.
struct Disc {
    center: Vector2<f64>,
    axes: Matrix2<f64>,
    inverse: Matrix2<f64>,
}

impl Disc {
    /// About a fixed point, in the coordinates in which the tangent map rotates; `None` if it does not, or if shapes move away.
    fn new(center: Vector2<f64>, tangent: &Matrix2<f64>, loss: f64) -> Option<Self> {
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

    /// The monomials of B at a shape.
    fn terms(&self, z: &Vector2<f64>) -> [f64; TERMS] {
        let zeta = self.inverse * (z - self.center);
        let mut terms = [1.0; TERMS];
        let mut start = 0;
        for degree in 1..=DEGREE {
            let next = start + degree;
            for i in 0..degree {
                terms[next + i] = terms[start + i] * zeta.x;
            }
            terms[next + degree] = terms[next - 1] * zeta.y;
            start = next;
        }
        terms
    }

    /// Points at which the equation is solved.
    fn points(&self) -> impl Iterator<Item = Vector2<f64>> {
        (0..CIRCLES * ON_CIRCLE).map(|n| {
            let radius = FRAC_PI_2 * (count(n / ON_CIRCLE) + 0.5) / count(CIRCLES);
            let (y, x) = libm::sincos(TAU * count(n % ON_CIRCLE) / count(ON_CIRCLE));
            self.center + self.axes * (Vector2::new(x, y) * libm::sin(radius))
        })
    }
}

/// The sum of all flights of a motion from this state, after an impact at contact 1, at this elapsed time (s), if it is regular and the error of
/// the sum is small.
pub(crate) fn sum(m: &FrozenModel, state: Landed, elapsed: f64) -> Option<RegularSum> {
    let energy = Energy::new(m)?;
    let root = energy.of(state).sqrt();
    let start = Vector2::new(state[0], state[1]) / root;
    let mut followed = Vec::with_capacity(FOLLOWED);
    let mut z = start;
    for _ in 0..FOLLOWED {
        followed.push(z);
        let cycle = energy.cycle(m, &z)?;
        if !(cycle.loss <= REGULAR_LOSS) {
            return None;
        }
        z = cycle.z;
    }
    let mean = followed.iter().sum::<Vector2<f64>>() / count(FOLLOWED);
    let (center, tangent) = energy.fixed_point(m, mean)?;
    let middle = energy.cycle(m, &center)?;
    let disc = Disc::new(center, &tangent, middle.loss)?;
    let radius = followed
        .iter()
        .map(|z| (disc.inverse * (z - center)).norm())
        .fold(REGULAR_RADIUS, f64::max);
    let disc = disc.scaled(MARGIN * radius);
    let whole = middle.tau / middle.loss;
    let mut matrix = DMatrix::zeros(CIRCLES * ON_CIRCLE, TERMS);
    let mut right = DVector::zeros(CIRCLES * ON_CIRCLE);
    for (i, z) in disc.points().enumerate() {
        let cycle = energy.cycle(m, &z)?;
        let (own, next) = (disc.terms(&z), disc.terms(&cycle.z));
        for k in 0..TERMS {
            matrix[(i, k)] = own[k] - (1.0 - cycle.loss) * next[k];
        }
        right[i] = cycle.tau - cycle.loss * whole;
    }
    let factors = matrix.qr();
    factors.q_tr_mul(&mut right);
    let terms = factors.r().solve_upper_triangular(&right.rows(0, TERMS))?;
    let polynomial =
        |z: &Vector2<f64>| disc.terms(z).iter().zip(terms.iter()).map(|(a, b)| a * b).sum::<f64>();
    let size = start - center;
    let mut error = 0.0_f64;
    for share in ORBITS {
        let (mut z, mut total, mut spread, mut least) =
            (center + size * share, 0.0, 0.0_f64, 1.0_f64);
        let (mut sums, mut own) = ([0.0; TESTED], polynomial(&z));
        for sum in &mut sums {
            let cycle = energy.cycle(m, &z)?;
            let next = polynomial(&cycle.z);
            total += own - (1.0 - cycle.loss) * next - (cycle.tau - cycle.loss * whole);
            (*sum, own, z, least) = (total, next, cycle.z, least.min(cycle.loss));
        }
        let mean = total / count(TESTED);
        for (n, sum) in sums.iter().enumerate() {
            spread = spread.max((sum - mean * count(n + 1)).abs());
        }
        error = error.max((mean.abs() + spread / count(TESTED)) / least + spread);
    }
    let duration = root * (whole + polynomial(&start));
    let error = root * error;
    (error <= REGULAR_ERROR * (elapsed + duration)).then_some(RegularSum { duration, error })
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
    fn followed(energy: &Energy, m: &FrozenModel, start: Vector2<f64>) -> f64 {
        // The logarithm of √E in two parts: near the fixed point all roundings are alike, and would add up.
        let (mut z, mut log, mut times) = (start, Clock::default(), Vec::new());
        while log.hi < 44.0 {
            let cycle = energy.cycle(m, &z).expect("impacts in turn");
            times.push(libm::exp(-log.hi) * cycle.tau);
            (z, log) = (cycle.z, log.after(-libm::log1p(-cycle.loss)));
        }
        times.iter().rev().sum()
    }

    /// A start beside the fixed point, at this distance.
    fn beside(m: &FrozenModel, energy: &Energy, off: f64) -> Vector2<f64> {
        let turns = |tangent: &Matrix2<f64>| tangent.determinant() > 0.25 * tangent.trace().powi(2);
        let found = (0..9)
            .map(|k| Vector2::new(0.86, -0.7 + 0.05 * f64::from(k)))
            .filter_map(|near| energy.fixed_point(m, near))
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
            let energy = Energy::new(&m).expect("pressed contacts");
            let start = beside(&m, &energy, off);
            let all = followed(&energy, &m, start);
            let RegularSum { duration, error } = sum(&m, energy.state(&start), all).expect("a sum");
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
            let energy = Energy::new(&m).expect("pressed contacts");
            let start = beside(&m, &energy, off);
            assert_eq!(sum(&m, energy.state(&start), 1e3), None);
        }
    }
}
