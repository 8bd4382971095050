//! Intervals with outward rounding: every result contains all that its arguments allow.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::real::Ring;

/// All numbers from `lo` to `hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

/// An interval that contains everything between two computed bounds: each is rounded by half an ulp at most.
fn outward(lo: f64, hi: f64) -> Interval {
    Interval { lo: lo.next_down(), hi: hi.next_up() }
}

impl Interval {
    pub(crate) const ZERO: Self = Self { lo: 0.0, hi: 0.0 };
    pub(crate) const ONE: Self = Self { lo: 1.0, hi: 1.0 };

    pub(crate) fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi }
    }

    /// A number that is known to an ulp, such as a sine.
    pub(crate) fn near(x: f64) -> Self {
        outward(x, x)
    }

    pub(crate) fn middle(self) -> f64 {
        0.5 * self.lo + 0.5 * self.hi
    }

    pub(crate) fn is_positive(self) -> bool {
        self.lo > 0.0
    }

    pub(crate) fn is_negative(self) -> bool {
        self.hi < 0.0
    }

    pub(crate) fn contains_zero(self) -> bool {
        !(self.lo > 0.0 || self.hi < 0.0)
    }

    /// The sign, where it is certain; 0 for exactly zero.
    pub(crate) fn sign(self) -> Option<i8> {
        if self.is_positive() {
            Some(1)
        } else if self.is_negative() {
            Some(-1)
        } else if self == Self::ZERO {
            Some(0)
        } else {
            None
        }
    }

    pub(crate) fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// The part at or above zero; `None` if it is empty.
    pub(crate) fn non_negative(self) -> Option<Self> {
        (self.hi >= 0.0).then(|| Self { lo: self.lo.max(0.0), hi: self.hi })
    }

    pub(crate) fn square(self) -> Self {
        let (a, b) = (self.lo.abs(), self.hi.abs());
        let least = if self.contains_zero() { 0.0 } else { a.min(b) };
        Self { lo: (least * least).next_down().max(0.0), hi: (a.max(b) * a.max(b)).next_up() }
    }

    /// The square roots of its nonnegative numbers.
    pub(crate) fn sqrt(self) -> Self {
        let root = |x: f64| x.max(0.0).sqrt();
        Self { lo: root(self.lo).next_down().max(0.0), hi: root(self.hi).next_up() }
    }

    /// Natural logarithms of its positive numbers, with a margin of four ulps for the library function.
    pub(crate) fn ln(self) -> Self {
        let wide =
            |x: f64, side: f64| x + side * (4.0 * f64::EPSILON * x.abs() + f64::MIN_POSITIVE);
        Self { lo: wide(libm::log(self.lo), -1.0), hi: wide(libm::log(self.hi), 1.0) }
    }

    pub(crate) fn times(self, factor: f64) -> Self {
        self * Self::new(factor, factor)
    }
}

impl From<f64> for Interval {
    fn from(x: f64) -> Self {
        Self { lo: x, hi: x }
    }
}

impl Neg for Interval {
    type Output = Self;

    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Add for Interval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        if other == Self::ZERO {
            self
        } else if self == Self::ZERO {
            other
        } else {
            outward(self.lo + other.lo, self.hi + other.hi)
        }
    }
}

impl Ring for Interval {
    fn half(self) -> Self {
        outward(0.5 * self.lo, 0.5 * self.hi)
    }
}

impl Sub for Interval {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        if self == Self::ZERO || other == Self::ZERO {
            return Self::ZERO;
        }
        let p = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        outward(p[0].min(p[1]).min(p[2].min(p[3])), p[0].max(p[1]).max(p[2].max(p[3])))
    }
}

impl Div for Interval {
    type Output = Self;

    /// Everything, if the divisor may be zero.
    fn div(self, other: Self) -> Self {
        if other.contains_zero() {
            return Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
        }
        if self == Self::ZERO {
            return Self::ZERO;
        }
        let q = [self.lo / other.lo, self.lo / other.hi, self.hi / other.lo, self.hi / other.hi];
        outward(q[0].min(q[1]).min(q[2].min(q[3])), q[0].max(q[1]).max(q[2].max(q[3])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_contain_what_they_should() {
        let third = Interval::ONE / Interval::from(3.0);
        assert!(third.lo < third.hi && third.hi - third.lo < 2.0 * f64::EPSILON);
        let product = Interval::new(-1.0, 2.0) * Interval::new(-3.0, 1.0);
        assert!(product.lo <= -6.0 && product.hi >= 3.0 && product.hi < 3.0 + 1e-15);
        assert_eq!(Interval::new(-2.0, 1.0).square().lo, 0.0);
        assert!(Interval::from(2.0).sqrt().square().lo <= 2.0);
        assert_eq!((Interval::ONE / Interval::new(-1.0, 1.0)).hi, f64::INFINITY);
    }
}
