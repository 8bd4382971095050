//! Polynomials through values at Chebyshev's points of [0, 1], for functions of the scale s of an accumulation.

use std::f64::consts::FRAC_PI_2;

use nalgebra::SMatrix;

/// The places s_j = sin²(πj/2M), j = 1, …, M, for polynomials of degree M; the last one is 1.
pub(crate) fn places<const M: usize>() -> [f64; M] {
    std::array::from_fn(|j| {
        let sin = libm::sin(FRAC_PI_2 * (j + 1) as f64 / M as f64);
        sin * sin
    })
}

/// The matrix s_j^m (r_j^m − 1), m = 1, …, M: what one step from s_j to r_j s_j changes a power of s by.
pub(crate) fn steps<const M: usize>(places: &[f64; M], ratios: &[f64; M]) -> SMatrix<f64, M, M> {
    let mut found = powers(places);
    for (j, ratio) in ratios.iter().enumerate() {
        for (m, change) in changes::<M>(*ratio).iter().enumerate() {
            found[(j, m)] *= change;
        }
    }
    found
}

/// The matrix s_j^m, m = 1, …, M.
pub(crate) fn powers<const M: usize>(places: &[f64; M]) -> SMatrix<f64, M, M> {
    let mut found = SMatrix::zeros();
    for (j, s) in places.iter().enumerate() {
        let mut power = 1.0;
        for m in 0..M {
            power *= s;
            found[(j, m)] = power;
        }
    }
    found
}

/// The coefficients x_m, m = 1, …, M, of K polynomials Σ_m x_m s^m with these values at these places, in ascending order, by Newton's divided
/// differences [Björck & Pereyra 1970]: small coefficients have small errors, which an inverse matrix would not give.
pub(crate) fn coefficients<const M: usize, const K: usize>(
    places: &[f64; M],
    values: &mut [[f64; K]; M],
) {
    for (row, s) in values.iter_mut().zip(places) {
        row.iter_mut().for_each(|x| *x /= s);
    }
    for k in 1..M {
        for i in (k..M).rev() {
            let (below, own) = values.split_at_mut(i);
            let step = 1.0 / (places[i] - places[i - k]);
            for (x, before) in own[0].iter_mut().zip(&below[i - 1]) {
                *x = (*x - before) * step;
            }
        }
    }
    for k in (0..M - 1).rev() {
        for i in k..M - 1 {
            let (own, above) = values.split_at_mut(i + 1);
            for (x, next) in own[i].iter_mut().zip(&above[0]) {
                *x -= places[k] * next;
            }
        }
    }
}

/// r^m − 1, m = 1, …, M, by r^m − 1 = r (r^{m−1} − 1) + (r − 1), without cancellation.
pub(crate) fn changes<const M: usize>(ratio: f64) -> [f64; M] {
    let mut change = 0.0;
    std::array::from_fn(|_| {
        change = ratio * change + (ratio - 1.0);
        change
    })
}

/// Estimate of the error of the polynomial with these values at these places and `zero` at 0: its last coefficients in Chebyshev's polynomials
/// T_m(1 − 2s). `next`: the weight of the coefficient before the last one, as either may vanish by chance.
pub(crate) fn doubt<const M: usize>(
    zero: f64,
    places: &[f64; M],
    values: [f64; M],
    next: f64,
) -> f64 {
    let [mut top, mut below] = [0.5 * zero; 2];
    for (j, (s, value)) in places.iter().zip(values).enumerate() {
        let weight = if j + 1 == M { 0.5 } else { 1.0 };
        let sign = if j % 2 == 0 { -1.0 } else { 1.0 };
        // T_M = ±1 at the places, and T_{M−1} = ±T_1.
        top += sign * weight * value;
        below += sign * weight * value * (1.0 - 2.0 * s);
    }
    (top.abs() + 2.0 * next * below.abs()) / M as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The condition of the coefficients is about 1e4; the polynomials have the values to a few units in the last place of their terms.
    #[test]
    fn polynomials_have_the_values_of_which_they_are_made() {
        let places = places::<6>();
        let known = [[1.0, -2.0], [3.0, 0.0], [-0.5, 1e-9], [0.0, 2.0], [1e-12, 0.0], [7.0, 1e-6]];
        let at = |terms: &[[f64; 2]; 6], k: usize, s: f64| {
            terms.iter().rev().fold(0.0, |sum, term| (sum + term[k]) * s)
        };
        let values = places.map(|s| [0, 1].map(|k| at(&known, k, s)));
        let mut found = values;
        coefficients(&places, &mut found);
        for (s, values) in places.iter().zip(values) {
            for (k, value) in values.iter().enumerate() {
                let size = at(&found.map(|term| term.map(f64::abs)), k, *s);
                assert!((at(&found, k, *s) - value).abs() < 8.0 * f64::EPSILON * size, "{s}");
            }
        }
        for (term, known) in found.iter().flatten().zip(known.iter().flatten()) {
            assert!((term - known).abs() < 1e-11, "{term} {known}");
        }
    }

    #[test]
    fn the_last_coefficients_vanish_for_polynomials_of_lower_degree_only() {
        let power = |m: i32| doubt(0.0, &places::<8>(), places::<8>().map(|s| s.powi(m)), 0.0);
        for m in 1..8 {
            assert!(power(m) < 1e-15, "{m}");
        }
        // T_8(1 − 2s) = 2¹⁵ s⁸ + …
        assert!((power(8) * 2.0_f64.powi(15) - 1.0).abs() < 1e-12, "{}", power(8));
        let before = doubt(0.0, &places::<8>(), places::<8>().map(|s| s.powi(7)), 1.0);
        assert!((before * 2.0_f64.powi(13) - 1.0).abs() < 1e-12, "{before}");
    }
}
