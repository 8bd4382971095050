//! Results have no negative zeros.
//!
//! −0.0 equals 0.0 and means the same, but it is printed with its sign. Results are handed out as x + 0.0: that is 0.0 for both
//! zeros, and x for every other number.

use nalgebra::Vector3;

/// Numbers, with +0.0 for −0.0.
pub(crate) trait UnsignedZero {
    /// The same numbers, with +0.0 for −0.0.
    fn unsigned_zero(self) -> Self;
}

impl UnsignedZero for f64 {
    #[inline]
    fn unsigned_zero(self) -> Self {
        self + 0.0
    }
}

impl<T: UnsignedZero, const N: usize> UnsignedZero for [T; N] {
    #[inline]
    fn unsigned_zero(self) -> Self {
        self.map(T::unsigned_zero)
    }
}

impl<T: UnsignedZero> UnsignedZero for Vec<T> {
    fn unsigned_zero(self) -> Self {
        self.into_iter().map(T::unsigned_zero).collect()
    }
}

impl<T: UnsignedZero> UnsignedZero for Option<T> {
    fn unsigned_zero(self) -> Self {
        self.map(T::unsigned_zero)
    }
}

impl UnsignedZero for Vector3<f64> {
    fn unsigned_zero(self) -> Self {
        self.map(f64::unsigned_zero)
    }
}
