//! The arithmetic in which formulas are written once: for doubles, balls and intervals.

use std::ops::{Add, Mul, Neg, Sub};

/// Sums, differences and products, of doubles, of balls or of intervals.
pub(crate) trait Ring:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// self/2
    fn half(self) -> Self;
}

/// Numbers that are known up to an error, in balls or in intervals. The result of an operation contains the results for all numbers in the
/// arguments, and a sign that is stated is the sign of all numbers.
pub(crate) trait Enclosed: Ring + From<f64> {
    const ZERO: Self;

    fn square(self) -> Self;
    /// self times a power of two
    fn scaled(self, power: f64) -> Self;
    /// self/y; `None` if y may be zero.
    fn over(self, y: Self) -> Option<Self>;
    /// The square root; `None` if a number may be negative.
    fn root(self) -> Option<Self>;
    fn max(self, other: Self) -> Self;
    /// Without negative numbers, where the arithmetic can leave them out: for a quantity that cannot be negative.
    fn not_below_zero(self) -> Self;
    fn is_positive(self) -> bool;
    /// Exactly zero.
    fn is_zero(self) -> bool;
    /// Two doubles between which all numbers lie.
    fn bounds(self) -> [f64; 2];

    fn is_negative(self) -> bool {
        (-self).is_positive()
    }

    fn is_not_negative(self) -> bool {
        self.is_zero() || self.is_positive()
    }
}

impl Ring for f64 {
    #[inline(always)]
    fn half(self) -> Self {
        0.5 * self
    }
}
