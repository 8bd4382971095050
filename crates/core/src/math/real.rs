//! The arithmetic in which formulas are written once: for doubles, lanes of several doubles, balls and intervals.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Sums, differences and products, of doubles, of doubles in lanes, of balls or of intervals.
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

/// A double, or a double in each lane.
pub(crate) trait Real:
    Ring + Div<Output = Self> + Add<f64, Output = Self> + Mul<f64, Output = Self>
{
    /// A truth value, or one in each lane.
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// `value` in each lane.
    fn like(self, value: f64) -> Self;
    /// self < other
    fn below(self, other: Self) -> Self::Mask;
    /// self ≤ other
    fn at_most(self, other: Self) -> Self::Mask;
    /// In each lane `yes` if the mask is true, and else `no`.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;
    fn any(mask: Self::Mask) -> bool;
}

impl Real for f64 {
    type Mask = bool;

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn below(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn choose(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
}
