//! Polynomials through values at Chebyshev's points of [0, 1], for functions of the scale s of an accumulation.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{SMatrix, SVector};

/// Degree of the polynomials.
pub(crate) const DEGREE: usize = 8;

/// One value for each place but s = 0.
pub(crate) type Values = SVector<f64, DEGREE>;
pub(crate) type Square = SMatrix<f64, DEGREE, DEGREE>;

/// The places s_j = sin²(πj/2M), j = 1, …, M; the last one is 1.
pub(crate) fn places() -> [f64; DEGREE] {
    std::array::from_fn(|j| {
        let sin = libm::sin(FRAC_PI_2 * (j + 1) as f64 / DEGREE as f64);
        sin * sin
    })
}

/// The matrix s_j^{m+shift} (r_j^{m+loss} − 1), m = 1, …, M: what one step from s_j to r_j s_j changes a power of s by.
pub(crate) fn steps(places: &[f64; DEGREE], ratios: &[f64; DEGREE], shift: usize) -> Square {
    let logs = ratios.map(libm::log);
    Square::from_fn(|j, m| {
        let power = (m + 1) as f64;
        libm::pow(places[j], power + shift as f64) * libm::expm1(power * logs[j])
    })
}

/// Estimate of the error of the polynomial with these values and this one at 0: its last coefficients in Chebyshev's polynomials. `next`: the
/// weight of the coefficient before the last one, as either may vanish by chance.
pub(crate) fn doubt(zero: f64, values: impl Iterator<Item = f64>, next: f64) -> f64 {
    let degree = DEGREE as f64;
    let [mut top, mut below] = [0.5 * zero; 2];
    for (j, value) in values.enumerate() {
        let weight = if j + 1 == DEGREE { 0.5 } else { 1.0 };
        let sign = if j % 2 == 0 { -1.0 } else { 1.0 };
        top += sign * weight * value;
        below += weight * value * libm::cos(PI * ((j + 1) * (DEGREE - 1)) as f64 / degree);
    }
    top.abs() / degree + below.abs() * 2.0 * next / degree
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_coefficients_vanish_for_polynomials_of_lower_degree_only() {
        let power = |m: i32| doubt(0.0, places().into_iter().map(|s| s.powi(m)), 1.0);
        for m in 1..DEGREE as i32 - 1 {
            assert!(power(m) < 1e-15, "{m}");
        }
        // The coefficient of T_M(1 − 2s) in s^M is 2^(1−2M).
        assert!((power(DEGREE as i32) / 2.0_f64.powi(1 - 2 * DEGREE as i32) - 1.0).abs() < 20.0);
        assert!(power(DEGREE as i32) > 1e-6);
    }
}
