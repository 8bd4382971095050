//! Balls: numbers of 106 bits with a bound of all that they are off.
//!
//! The centre is an unevaluated sum of two doubles, |lo| ≤ ½ ulp(hi). Its sums and products are off by at most 3u² and 5u² of
//! themselves, u = 2⁻⁵³ [Joldes, Muller & Popescu, ACM TOMS 44 (2017) 15, algorithms 6 and 11]; quotients and roots are judged
//! by what they leave over. Sums rely on gradual underflow, as the standard has it and every compiler by default.

use std::ops::{Add, Mul, Neg, Sub};

use crate::math::real::Ring;

/// A sum of two doubles, and how far it may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball {
    hi: f64,
    lo: f64,
    radius: f64,
}

/// Bound of the relative error of a sum or a product of centres: 8u².
const ROUNDING: f64 = 8.0 * (0.5 * f64::EPSILON) * (0.5 * f64::EPSILON);
/// More than the rounding error of numbers below the normal range.
const TINY: f64 = f64::MIN_POSITIVE;
/// More than the roundings of a radius, computed from a few positive terms.
const SLACK: f64 = 1.0 + 64.0 * f64::EPSILON;

fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// For |a| ≥ |b|.
fn fast_two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    (sum, b - (sum - a))
}

fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

impl Ball {
    pub(crate) const ZERO: Self = Self { hi: 0.0, lo: 0.0, radius: 0.0 };

    fn around((hi, lo): (f64, f64), radius: f64) -> Self {
        Self { hi, lo, radius: (radius + ROUNDING * hi.abs()) * SLACK }
    }

    /// The double nearest its centre.
    pub(crate) fn middle(self) -> f64 {
        self.hi
    }

    /// Its centre alone.
    pub(crate) fn center(self) -> Self {
        Self { radius: 0.0, ..self }
    }

    /// The ball enlarged by this radius.
    pub(crate) fn widened(self, by: f64) -> Self {
        Self { radius: (self.radius + by) * SLACK, ..self }
    }

    /// At least the distance of its farthest number from zero.
    pub(crate) fn size(self) -> f64 {
        (self.hi.abs() + self.radius) * SLACK
    }

    /// At most the distance of its nearest number from zero; 0 if that is not certain to be positive.
    pub(crate) fn clearance(self) -> f64 {
        ((self.hi.abs() / SLACK - self.radius) / SLACK).max(0.0)
    }

    pub(crate) fn is_positive(self) -> bool {
        self.hi > 0.0 && self.clearance() > 0.0
    }

    pub(crate) fn is_negative(self) -> bool {
        (-self).is_positive()
    }

    /// Exactly zero, or certainly positive.
    pub(crate) fn is_not_negative(self) -> bool {
        self.is_zero() || self.is_positive()
    }

    /// Exactly zero.
    pub(crate) fn is_zero(self) -> bool {
        self == Self::ZERO
    }

    /// The doubles around it: the lower and the upper one.
    pub(crate) fn bounds(self) -> [f64; 2] {
        if self.lo == 0.0 && self.radius == 0.0 {
            return [self.hi; 2];
        }
        let at = |side: f64| self.hi + (self.lo + side * (self.radius * SLACK));
        // The bracket is rounded by far less than an ulp of hi, or than the slack, the whole by half an ulp.
        [at(-1.0).next_down(), at(1.0).next_up()]
    }

    /// Times a power of two.
    pub(crate) fn scaled(self, power: f64) -> Self {
        if self.is_zero() {
            return self;
        }
        let hi = self.hi * power;
        let radius = if hi.is_finite() { self.radius * power + TINY } else { f64::INFINITY };
        Self { hi, lo: self.lo * power, radius: radius * SLACK }
    }

    pub(crate) fn square(self) -> Self {
        self * self
    }

    pub(crate) fn max(self, other: Self) -> Self {
        if (other - self).is_positive() {
            other
        } else if (self - other).is_positive() {
            self
        } else {
            // One that contains both.
            let middle = (self + other).scaled(0.5);
            let radius = (self - other).size() + self.radius.max(other.radius);
            Self { radius: (middle.radius + radius) * SLACK, ..middle }
        }
    }

    /// q ± |x − q y|/min |y| around any q; `None` if y may be zero.
    pub(crate) fn over(self, y: Self) -> Option<Self> {
        let least = y.clearance();
        if least == 0.0 || least.is_infinite() {
            return None;
        }
        if self.is_zero() {
            return Some(self);
        }
        let first = self.hi / y.hi;
        let rest = self - Self::from(first) * y;
        let (hi, lo) = fast_two_sum(first, rest.hi / y.hi);
        let quotient = Self { hi, lo, radius: 0.0 };
        let radius = (self - quotient * y).size() / least * SLACK + TINY;
        radius.is_finite().then_some(Self { radius, ..quotient })
    }

    /// s ± |x − s²|/(s + min √x) around any s > 0; `None` if x is not certain to be positive.
    pub(crate) fn sqrt(self) -> Option<Self> {
        if self.is_zero() {
            return Some(Self::ZERO);
        }
        if !self.is_positive() {
            return None;
        }
        let first = self.hi.sqrt();
        let rest = self - Self::from(first).square();
        let (hi, lo) = fast_two_sum(first, 0.5 * rest.hi / first);
        let root = Self { hi, lo, radius: 0.0 };
        let least = root.clearance() + self.clearance().sqrt() / SLACK;
        let radius = (self - root.square()).size() / least * (SLACK * SLACK);
        radius.is_finite().then_some(Self { radius, ..root })
    }
}

impl Ring for Ball {
    fn half(self) -> Self {
        self.scaled(0.5)
    }
}

impl From<f64> for Ball {
    fn from(x: f64) -> Self {
        Self { hi: x, lo: 0.0, radius: 0.0 }
    }
}

impl Neg for Ball {
    type Output = Self;

    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo, radius: self.radius }
    }
}

impl Add for Ball {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        let ((s, s_low), (t, t_low)) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let (v, v_low) = fast_two_sum(s, s_low + t);
        Self::around(fast_two_sum(v, t_low + v_low), self.radius + other.radius)
    }
}

impl Sub for Ball {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Ball {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            return Self::ZERO;
        }
        let (p, p_low) = two_product(self.hi, other.hi);
        let cross = self.lo.mul_add(other.hi, self.hi * other.lo);
        let radius = self.size() * other.radius + self.radius * other.size() + TINY;
        Self::around(fast_two_sum(p, p_low + cross), radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x·2^−k as an exact fraction is beyond doubles: identities are tried instead, whose two sides have to meet.
    #[test]
    fn balls_contain_what_they_should() {
        let x = Ball::from(0.1);
        for k in 1..200 {
            let y = Ball::from(f64::from(k) * 0.37);
            let quotient = x.over(y).unwrap();
            let left = quotient * y - x;
            assert!(!left.is_positive() && !left.is_negative(), "{k}: {left:?}");
            assert!(left.radius < 1e-31, "{k}: {left:?}");
            let root = y.sqrt().unwrap();
            let left = root.square() - y;
            assert!(!left.is_positive() && !left.is_negative(), "{k}: {left:?}");
            assert!(left.radius < 1e-30 * y.hi, "{k}: {left:?}");
        }
        let [low, high] = Ball::from(1.0).over(Ball::from(3.0)).unwrap().bounds();
        assert!(low < 1.0 / 3.0 && 1.0 / 3.0 < high && high - low < 1e-15);
        assert!(x.over(x - Ball::from(0.1)).is_none());
        let vast = Ball::from(1e308).scaled(2.0);
        assert!(x.over(vast).is_none() && !vast.is_positive());
        let tiny = Ball::from(1e-250).over(Ball::from(1e60)).unwrap();
        assert!(tiny.bounds()[0] < 1e-310 && tiny.bounds()[1] > 1e-310);
        let wide = Ball { radius: 0.2, ..x };
        assert!(wide.over(wide).is_none() && wide.sqrt().is_none());
        assert!(!wide.is_positive() && !wide.is_negative());
    }

    #[test]
    fn a_maximum_contains_both() {
        let (one, two) = (Ball { radius: 0.5, ..Ball::from(1.0) }, Ball::from(1.2));
        let [low, high] = one.max(two).bounds();
        assert!(low <= 1.2 && high >= 1.5);
        assert_eq!(two.max(Ball::from(3.0)), Ball::from(3.0));
    }
}
