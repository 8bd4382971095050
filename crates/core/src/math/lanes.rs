//! Doubles in the lanes of a vector register. The arithmetic of a collision is written once, for one double and for lanes of them.
//! Both use the additions, multiplications, divisions and square roots of IEEE 754, and never fuse two of them. So a run has the
//! same bits in a lane as by itself.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::math::real::{Real, Ring};

/// The lanes of two vector registers side by side: one register computes while the other one waits for its root or quotient.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<S: Simd>(S::f64s, S::f64s);

/// A truth value in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Masks<S: Simd>(S::mask64s, S::mask64s);

impl<S: Simd> Lanes<S> {
    /// Lanes of one register.
    const HALF: usize = <S::f64s as SimdBase<S>>::LEN;
    pub(crate) const COUNT: usize = 2 * Self::HALF;

    /// A bit for each lane.
    #[inline(always)]
    pub(crate) fn bits(mask: Masks<S>) -> u64 {
        mask.0.to_bitmask() | mask.1.to_bitmask() << Self::HALF
    }
}

/// Largest number of runs side by side: two registers of the widest kind.
pub(crate) const MOST: usize = 16;

/// N numbers of each run. All runs' first numbers come first, then all second ones, and so on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns<const N: usize>([[f64; MOST]; N]);

impl<const N: usize> Default for Columns<N> {
    fn default() -> Self {
        Self([[0.0; MOST]; N])
    }
}

impl<const N: usize> Columns<N> {
    pub(crate) fn put(&mut self, run: usize, values: [f64; N]) {
        for (column, value) in self.0.iter_mut().zip(values) {
            column[run] = value;
        }
    }

    pub(crate) fn get(&self, run: usize) -> [f64; N] {
        std::array::from_fn(|n| self.0[n][run])
    }

    /// Loads the numbers of the first runs, as many runs as there are lanes.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> [Lanes<S>; N] {
        std::array::from_fn(|n| {
            let (one, two) = self.0[n].split_at(Lanes::<S>::HALF);
            let two = &two[..Lanes::<S>::HALF];
            Lanes(S::f64s::from_slice(simd, one), S::f64s::from_slice(simd, two))
        })
    }

    #[inline(always)]
    pub(crate) fn store<S: Simd>(&mut self, values: &[Lanes<S>; N]) {
        for n in 0..N {
            let (one, two) = self.0[n].split_at_mut(Lanes::<S>::HALF);
            values[n].0.store_slice(one);
            values[n].1.store_slice(&mut two[..Lanes::<S>::HALF]);
        }
    }
}

/// Number of runs side by side in the lanes of this kind.
#[inline(always)]
pub(crate) fn count<S: Simd>(_: S) -> usize {
    Lanes::<S>::COUNT
}

impl<S: Simd> Ring for Lanes<S> {
    #[inline(always)]
    fn half(self) -> Self {
        self * 0.5
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = Masks<S>;

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        let all = S::f64s::splat(self.0.token(), value);
        Self(all, all)
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        Masks(self.0.simd_lt(other.0), self.1.simd_lt(other.1))
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Mask {
        Masks(self.0.simd_le(other.0), self.1.simd_le(other.1))
    }

    #[inline(always)]
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(mask.0.select(yes.0, no.0), mask.1.select(yes.1, no.1))
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        (mask.0 | mask.1).any_true()
    }
}

macro_rules! lane_by_lane {
    ($of:ident: $($operation:ident $method:ident),*) => {
        $(
            impl<S: Simd> $operation for $of<S> {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self($operation::$method(self.0, other.0), $operation::$method(self.1, other.1))
                }
            }
        )*
    };
}

lane_by_lane!(Lanes: Add add, Sub sub, Mul mul, Div div);
lane_by_lane!(Masks: BitAnd bitand, BitOr bitor);

impl<S: Simd> Not for Masks<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0, !self.1)
    }
}

impl<S: Simd> Add<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self(self.0 + other, self.1 + other)
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        Self(self.0 * other, self.1 * other)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}
