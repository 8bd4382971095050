//! sin x, 1 − cos x and x − sin x, each with all its digits however small x is.

use std::f64::consts::FRAC_PI_4;

use nalgebra::Vector2;

use crate::math::real::Ring;

/// The three functions of an angle that a rotating arm needs, at one angle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Turn<T = f64> {
    /// sin x
    pub(crate) sin: T,
    /// 1 − cos x
    pub(crate) one_minus_cos: T,
    /// x − sin x
    pub(crate) x_minus_sin: T,
}

/// Taylor series of (x − sin x)/x³ and (1 − cos x − x²/2)/x⁴ in x²: (−1)ᵏ/(2k+3)! and −(−1)ᵏ/(2k+4)!.
/// On |x| ≤ π/4 the first omitted terms are below 1e-18.
const X_MINUS_SIN: [f64; 7] = [
    1.0 / 6.0,
    -1.0 / 120.0,
    1.0 / 5_040.0,
    -1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    -1.0 / 6_227_020_800.0,
    1.0 / 1_307_674_368_000.0,
];
const ONE_MINUS_COS: [f64; 7] = [
    -1.0 / 24.0,
    1.0 / 720.0,
    -1.0 / 40_320.0,
    1.0 / 3_628_800.0,
    -1.0 / 479_001_600.0,
    1.0 / 87_178_291_200.0,
    -1.0 / 20_922_789_888_000.0,
];

/// 2π, to three doubles.
const WHOLE: [f64; 3] =
    [std::f64::consts::TAU, 2.449_293_598_294_706_4e-16, -5.989_539_619_436_679e-33];

/// The angle ωt reduced by whole turns, in rad; up to 2⁵³ turns. The product ωt is taken exactly, because its rounding error may be many
/// degrees.
pub(crate) fn phase(omega: f64, t: f64) -> f64 {
    let product = omega * t;
    let rest = omega.mul_add(t, -product);
    let turns = (product / WHOLE[0]).round();
    let left = turns.mul_add(-WHOLE[0], product);
    left + (rest - turns * WHOLE[1] - turns * WHOLE[2])
}

/// A vector after this turn.
pub(crate) fn turned(turn: &Turn, v: Vector2<f64>) -> Vector2<f64> {
    v + Vector2::new(-v.y, v.x) * turn.sin - v * turn.one_minus_cos
}

impl Turn {
    /// Rotation during a flight, in rad, up to which the touchdown is solved for directly. The error of the last step grows with the
    /// rotation. Up to the same rotation, arms are computed from the rotation, because their rounding error grows in the same way.
    pub(crate) const LARGEST: f64 = 32.0;

    /// The three functions at `x` (rad), to within 2 ulp each.
    #[inline]
    pub(crate) fn by(x: f64) -> Self {
        if x.abs() <= FRAC_PI_4 {
            Self::small(x)
        } else {
            let (sin, half) = (libm::sin(x), libm::sin(0.5 * x));
            Self { sin, one_minus_cos: 2.0 * half * half, x_minus_sin: x - sin }
        }
    }
}

impl<T: Ring> Turn<T> {
    /// b and c after this turn: db/dθ = −c, dc/dθ = b.
    #[inline(always)]
    pub(crate) fn turned(&self, [b, c]: [T; 2]) -> [T; 2] {
        [b - (b * self.one_minus_cos + c * self.sin), c - (c * self.one_minus_cos - b * self.sin)]
    }
}

impl Turn {
    /// Largest |x| for [`Turn::small`], in rad.
    pub(crate) const SMALL: f64 = FRAC_PI_4;

    /// The three functions at |x| ≤ π/4.
    #[inline(always)]
    pub(crate) fn small(x: f64) -> Self {
        let y = x * x;
        let x_minus_sin = x * y * polynomial(&X_MINUS_SIN, y);
        Self {
            sin: x - x_minus_sin,
            one_minus_cos: y * 0.5 + y * y * polynomial(&ONE_MINUS_COS, y),
            x_minus_sin,
        }
    }

    /// The three functions at `x + dx` for |dx| ≪ |x|, with the first two Taylor terms.
    #[inline(always)]
    pub(crate) fn and(self, dx: f64) -> Self {
        let cos = -self.one_minus_cos + 1.0;
        let half = dx * 0.5;
        Self {
            sin: self.sin + dx * (cos - half * self.sin),
            one_minus_cos: self.one_minus_cos + dx * (self.sin + half * cos),
            x_minus_sin: self.x_minus_sin + dx * (self.one_minus_cos + half * self.sin),
        }
    }
}

#[inline(always)]
fn polynomial(coefficients: &[f64; 7], y: f64) -> f64 {
    let [k0, k1, k2, k3, k4, k5, k6] = *coefficients;
    // Two halves in y², so that the additions overlap.
    let z = y * y;
    let even = z * (z * (z * k6 + k4) + k2) + k0;
    let odd = z * (z * k5 + k3) + k1;
    even + y * odd
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compared with the angle reduction of the library, which is exact for a double: for the rounded product, and for the rounding error
    /// of the product.
    #[test]
    fn phases_of_many_turns_keep_their_digits() {
        for k in 1..1000 {
            let (omega, t) = (1e9 + 0.37 * f64::from(k), 1.7 * f64::from(k) + 0.1);
            let (product, rest) = (omega * t, omega.mul_add(t, -(omega * t)));
            let sin = libm::sin(product) * libm::cos(rest) + libm::cos(product) * libm::sin(rest);
            let angle = phase(omega, t);
            assert!(angle.abs() < 3.2 && (libm::sin(angle) - sin).abs() < 1e-15, "{omega} {t}");
        }
    }

    #[test]
    fn small_angles_keep_every_digit() {
        // Leading terms are exact to 1e-16 relative below 1e-8.
        for exponent in 8..100 {
            let x = 10f64.powi(-exponent);
            let turn = Turn::by(x);
            assert!((turn.one_minus_cos / (x * x / 2.0) - 1.0).abs() < 4e-16, "{x}");
            assert!((turn.x_minus_sin / (x * x * x / 6.0) - 1.0).abs() < 4e-16, "{x}");
            assert_eq!(turn.sin, x);
        }
    }

    #[test]
    fn both_branches_agree_with_the_library() {
        for k in -4000..=4000 {
            let x = f64::from(k) * 1e-3;
            let turn = Turn::by(x);
            assert!((turn.sin - libm::sin(x)).abs() <= 2.3e-16 * libm::sin(x).abs(), "sin {x}");
            let one_minus_cos = 2.0 * libm::sin(0.5 * x).powi(2);
            assert!(
                (turn.one_minus_cos - one_minus_cos).abs() <= 9e-16 * one_minus_cos,
                "1 - cos {x}"
            );
            assert!(
                (turn.x_minus_sin - (x - libm::sin(x))).abs() <= 3e-16 * x.abs().max(1.0),
                "x - sin {x}"
            );
            let near = Turn::by(x - 1e-9).and(1e-9);
            assert!(
                (near.sin - turn.sin).abs() < 3e-16
                    && (near.x_minus_sin - turn.x_minus_sin).abs() < 1e-15
            );
        }
    }
}
