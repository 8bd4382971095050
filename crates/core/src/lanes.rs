//! Numbers, one by one or side by side: what a collision computes is written once and serves a single run as well as the
//! lanes of a vector register. Additions, multiplications, divisions and square roots are those of IEEE 754 in either, and
//! none is fused with another, so that a run has the same bits in a lane as by itself.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat, SimdMask};

use crate::trig::Turn;

/// A double, or one in each lane.
pub(crate) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// Yes or no, in each lane.
    type Mask: Copy
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;

    fn sqrt(self) -> Self;
    fn abs(self) -> Self;
    /// The same number in each lane of this one.
    fn like(self, value: f64) -> Self;
    /// self < other
    fn below(self, other: Self) -> Self::Mask;
    /// self ≤ other
    fn at_most(self, other: Self) -> Self::Mask;
    /// `yes` where the mask says so, else `no`.
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self;
    fn any(mask: Self::Mask) -> bool;
    /// The functions of a turn by this angle (rad), and where they are known.
    fn turn(self) -> (Turn<Self>, Self::Mask);
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

    #[inline(always)]
    fn turn(self) -> (Turn, bool) {
        (Turn::by(self), true)
    }
}

/// The lanes of one vector register.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lanes<S: Simd>(S::f64s);

/// Yes or no in each lane.
type MaskOf<S> = <S as Simd>::mask64s;

impl<S: Simd> Lanes<S> {
    /// Lanes of a register.
    pub(crate) const COUNT: usize = <S::f64s as SimdBase<S>>::LEN;

    #[inline(always)]
    fn lane(&self, index: usize) -> f64 {
        self.0[index]
    }

    /// A bit for each lane.
    #[inline(always)]
    pub(crate) fn bits(mask: MaskOf<S>) -> u64 {
        mask.to_bitmask()
    }
}

/// Runs side by side, at most: two registers of the widest kind.
pub(crate) const MOST: usize = 16;

/// N numbers of each run, kind by kind.
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

    /// The runs from this one on, as many as a register holds.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, from: usize) -> [Lanes<S>; N] {
        let to = from + Lanes::<S>::COUNT;
        std::array::from_fn(|n| Lanes(S::f64s::from_slice(simd, &self.0[n][from..to])))
    }

    #[inline(always)]
    pub(crate) fn store<S: Simd>(&mut self, from: usize, values: [Lanes<S>; N]) {
        let to = from + Lanes::<S>::COUNT;
        for (column, value) in self.0.iter_mut().zip(values) {
            value.0.store_slice(&mut column[from..to]);
        }
    }

    /// One of these lanes only. Of a copy, so that a loop need not keep its numbers where single lanes can be reached.
    #[cold]
    #[inline(never)]
    pub(crate) fn store_lanes<S: Simd>(&mut self, from: usize, lanes: u64, values: [Lanes<S>; N]) {
        for k in (0..Lanes::<S>::COUNT).filter(|k| lanes >> k & 1 == 1) {
            self.put(from + k, values.map(|value| value.lane(k)));
        }
    }
}

/// Lanes of a register.
#[inline(always)]
pub(crate) fn count<S: Simd>(_: S) -> usize {
    Lanes::<S>::COUNT
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = MaskOf<S>;

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self(S::f64s::splat(self.0.token(), value))
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        self.0.simd_lt(other.0)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Mask {
        self.0.simd_le(other.0)
    }

    #[inline(always)]
    fn choose(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(mask.select(yes.0, no.0))
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.any_true()
    }

    #[inline(always)]
    fn turn(self) -> (Turn<Self>, Self::Mask) {
        (Turn::small(self), self.abs().at_most(self.like(Turn::<Self>::SMALL)))
    }
}

macro_rules! lane_by_lane {
    ($($operation:ident $method:ident),*) => {
        $(
            impl<S: Simd> $operation for Lanes<S> {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self($operation::$method(self.0, other.0))
                }
            }
        )*
    };
}

lane_by_lane!(Add add, Sub sub, Mul mul, Div div);

impl<S: Simd> Add<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self(self.0 + other)
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        Self(self.0 * other)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}
