//! Intervals with outward rounding: each result contains the results for all numbers in the arguments.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::math::real::{Enclosed, Ring};

/// All numbers from `lo` to `hi`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

/// An interval that contains everything between two computed ends, each of which has a rounding error of at most half an ulp.
fn outward(lo: f64, hi: f64) -> Interval {
    Interval { lo: lo.next_down(), hi: hi.next_up() }
}

impl Interval {
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

    /// All numbers that differ from one in the interval by at most `by`.
    pub(crate) fn widened(self, by: f64) -> Self {
        if by == 0.0 { self } else { outward(self.lo - by, self.hi + by) }
    }

    /// The largest absolute value.
    pub(crate) fn magnitude(self) -> Self {
        Self::from(self.lo.abs().max(self.hi.abs()))
    }

    pub(crate) fn contains_zero(self) -> bool {
        !(self.lo > 0.0 || self.hi < 0.0)
    }

    /// The sign of all numbers in the interval, if they have the same sign; 0 if the interval is exactly zero.
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

    /// The part of the interval at or above zero; `None` if it is empty.
    pub(crate) fn non_negative(self) -> Option<Self> {
        (self.hi >= 0.0).then(|| Self { lo: self.lo.max(0.0), hi: self.hi })
    }

    /// The square roots of the nonnegative numbers in the interval.
    pub(crate) fn sqrt(self) -> Self {
        let root = |x: f64| x.max(0.0).sqrt();
        Self { lo: root(self.lo).next_down().max(0.0), hi: root(self.hi).next_up() }
    }

    /// Natural logarithms of the positive numbers in the interval, widened by four ulps for the error of the library function.
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

impl Enclosed for Interval {
    const ZERO: Self = Self { lo: 0.0, hi: 0.0 };

    fn square(self) -> Self {
        let (a, b) = (self.lo.abs(), self.hi.abs());
        let least = if self.contains_zero() { 0.0 } else { a.min(b) };
        Self { lo: (least * least).next_down().max(0.0), hi: (a.max(b) * a.max(b)).next_up() }
    }

    fn scaled(self, power: f64) -> Self {
        self.times(power)
    }

    fn over(self, y: Self) -> Option<Self> {
        (!y.contains_zero()).then(|| self / y)
    }

    fn root(self) -> Option<Self> {
        (self.lo >= 0.0).then(|| self.sqrt())
    }

    fn max(self, other: Self) -> Self {
        Self { lo: self.lo.max(other.lo), hi: self.hi.max(other.hi) }
    }

    fn not_below_zero(self) -> Self {
        self.max(Self::ZERO)
    }

    fn is_positive(self) -> bool {
        self.lo > 0.0
    }

    fn is_zero(self) -> bool {
        self == Self::ZERO
    }

    fn bounds(self) -> [f64; 2] {
        [self.lo, self.hi]
    }

    fn is_negative(self) -> bool {
        self.hi < 0.0
    }

    fn is_not_negative(self) -> bool {
        self.lo >= 0.0
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

    /// The whole real line, if the divisor may be zero.
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
    use num_bigint::BigInt;
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::{Fraction as Q, any_double, exact, fixed, fraction};

    /// An interval, a point in most cases, with unbounded ends in some, and three of its numbers.
    fn any_interval() -> impl Strategy<Value = (Interval, [Q; 3])> {
        (any_double(), any_double(), 0..8_u8, 0..=97).prop_map(|(a, b, kind, share)| {
            let (lo, hi) = if kind < 3 { (a, a) } else { (a.min(b), a.max(b)) };
            let (low, high) = (exact(lo).unwrap(), exact(hi).unwrap());
            let between = &low + (&high - &low) * fraction(share, 97);
            let interval = Interval {
                lo: if kind == 3 { f64::NEG_INFINITY } else { lo },
                hi: if kind == 4 { f64::INFINITY } else { hi },
            };
            (interval, [low, high, between])
        })
    }

    fn contains(i: Interval, x: &Q) -> bool {
        let below = exact(i.lo).map_or(i.lo == f64::NEG_INFINITY, |lo| lo <= *x);
        let above = exact(i.hi).map_or(i.hi == f64::INFINITY, |hi| *x <= hi);
        below && above
    }

    /// Returns true if both ends are at most two doubles beyond the least and the largest of these numbers.
    fn is_tight(i: Interval, all: &[Q]) -> bool {
        let (Some(least), Some(most)) = (all.iter().min(), all.iter().max()) else { return false };
        // An end of which this is infinite is the largest or the least double: the values have overflowed.
        let low = exact(i.lo.next_up().next_up());
        let high = exact(i.hi.next_down().next_down());
        low.is_none_or(|low| low >= *least) && high.is_none_or(|high| high <= *most)
    }

    /// Checks that the result of an operation contains all its values, and no numbers far from them.
    fn check(
        (x, xs): &(Interval, [Q; 3]),
        (y, ys): &(Interval, [Q; 3]),
        result: Interval,
        of: impl Fn(&Q, &Q) -> Q,
    ) -> Result<(), TestCaseError> {
        let all: Vec<Q> =
            xs.iter().flat_map(|a| ys.iter().map(|b| of(a, b)).collect::<Vec<_>>()).collect();
        for value in &all {
            prop_assert!(contains(result, value), "{x:?} {y:?} {result:?}");
        }
        let bounded = |i: &Interval| i.lo.is_finite() && i.hi.is_finite();
        if bounded(x) && bounded(y) {
            prop_assert!(is_tight(result, &all), "{x:?} {y:?} {result:?}");
        }
        Ok(())
    }

    fn zero() -> Q {
        fraction(0, 1)
    }

    /// 2 artanh t for |t| ≤ 1/3 in units of 2⁻²⁵⁶, by its series.
    fn twice_artanh(t: &Q) -> BigInt {
        let one: BigInt = BigInt::from(1) << 256_u32;
        let mut power = (t * Q::from(one.clone())).to_integer();
        let square = (t * t * Q::from(one)).to_integer();
        let mut sum = BigInt::from(0);
        for n in 0..90 {
            sum += &power / (2 * n + 1);
            power = (&power * &square) >> 256_u32;
        }
        sum * 2
    }

    /// The natural logarithm to 2⁻²⁴⁰.
    fn ln(x: &Q) -> Q {
        let power = x.numer().bits() as i64 - x.denom().bits() as i64;
        let two = fraction(2, 1);
        let y = x / two.pow(power as i32);
        let one = fraction(1, 1);
        let (first, second) =
            (twice_artanh(&((&y - &one) / (&y + &one))), twice_artanh(&fraction(1, 3)));
        Q::new(first + second * power, BigInt::from(1) << 256_u32)
    }

    proptest! {
        #![proptest_config(fixed(21))]

        #[test]
        fn sums_products_and_quotients_contain_the_exact_ones(x in any_interval(), y in any_interval()) {
            let (a, b) = (x.0, y.0);
            check(&x, &y, a + b, |a, b| a + b)?;
            check(&x, &y, a - b, |a, b| a - b)?;
            check(&x, &y, a * b, |a, b| a * b)?;
            let hull = a.hull(b);
            prop_assert!([a.lo, b.lo].contains(&hull.lo) && [a.hi, b.hi].contains(&hull.hi));
            for z in x.1.iter().chain(&y.1) {
                prop_assert!(contains(hull, z), "{:?} {:?}", a, b);
            }
            if b.contains_zero() {
                prop_assert_eq!(a / b, Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY });
            } else {
                check(&x, &y, a / b, |a, b| a / b)?;
            }
            prop_assert_eq!(a.over(b), (!b.contains_zero()).then(|| a / b));
            for (x, y) in x.1.iter().flat_map(|x| y.1.iter().map(move |y| (x, y))) {
                prop_assert!(contains(a.max(b), x.max(y)), "{:?} {:?}", a, b);
            }
            let factor = if b.lo.is_finite() { b.lo } else { b.hi };
            let point = exact(factor).unwrap();
            let points = (Interval::from(factor), [point.clone(), point.clone(), point]);
            check(&x, &points, a.times(factor), |a, b| a * b)?;
        }

        #[test]
        fn operations_on_one_argument_contain_the_exact_values(x in any_interval()) {
            let (a, xs) = (x.0, &x.1);
            let bounded = a.lo.is_finite() && a.hi.is_finite();
            check(&x, &x, -a, |a, _| -a)?;
            check(&x, &x, a.half(), |a, _| a * fraction(1, 2))?;
            prop_assert!(contains(Interval::near(xs_double(&a)), &exact(xs_double(&a)).unwrap()));
            let squares: Vec<Q> = xs.iter().map(|x| x * x).collect();
            for square in &squares {
                prop_assert!(contains(a.square(), square), "{:?} {:?}", a, a.square());
            }
            let crosses = a.contains_zero();
            let ends = squares.iter().cloned().chain(crosses.then(zero)).collect::<Vec<_>>();
            prop_assert!(!bounded || is_tight(a.square(), &ends), "{:?} {:?}", a, a.square());
            prop_assert!(a.square().lo >= 0.0 && (!crosses || a.square().lo == 0.0));
            // √x is in [lo, hi] iff lo ≥ 0 and lo² ≤ x ≤ hi².
            let root = a.sqrt();
            prop_assert!(root.lo >= 0.0 && root.lo <= root.hi);
            for x in xs.iter().filter(|x| **x >= zero()) {
                let squared = |x: f64| exact(x).map(|x| &x * &x);
                prop_assert!(squared(root.lo).unwrap() <= *x, "{:?} {:?}", a, root);
                prop_assert!(squared(root.hi).is_none_or(|hi| *x <= hi), "{:?} {:?}", a, root);
                if a.lo == a.hi {
                    let low = squared(root.lo.next_up().next_up()).unwrap();
                    let high = squared(root.hi.next_down().next_down().max(0.0)).unwrap();
                    prop_assert!(low >= *x && high <= *x, "{:?} {:?}", a, root);
                }
            }
            prop_assert_eq!(a.root(), (a.lo >= 0.0).then_some(root));
            let part = a.non_negative();
            for x in xs.iter().filter(|x| **x >= zero()) {
                prop_assert!(part.is_some_and(|part| contains(part, x)));
            }
            prop_assert!(part.is_none_or(|part| part.lo >= 0.0 && (part.hi, part.lo) == (a.hi, a.lo.max(0.0))));
        }

        #[test]
        fn signs_are_those_of_all_numbers(x in any_interval()) {
            let (a, xs) = x;
            let unbounded = [a.lo == f64::NEG_INFINITY, a.hi == f64::INFINITY];
            let least = if unbounded[0] { fraction(-1, 1) } else { xs[0].clone() };
            let most = if unbounded[1] { fraction(1, 1) } else { xs[1].clone() };
            let (positive, negative) = (least > zero(), most < zero());
            prop_assert_eq!((a.is_positive(), a.is_negative(), a.contains_zero()), (positive, negative, !positive && !negative));
            let sign = match (positive, negative) {
                (true, _) => Some(1),
                (_, true) => Some(-1),
                _ if least == most => Some(0),
                _ => None,
            };
            prop_assert_eq!(a.sign(), sign);
            prop_assert_eq!((a.is_not_negative(), a.is_zero()), (least >= zero(), sign == Some(0)));
            if a.lo.is_finite() && a.hi.is_finite() {
                let slack = exact(f64::from_bits(2)).unwrap();
                let middle = exact(a.middle()).unwrap();
                prop_assert!(&middle + &slack >= least && middle <= most + slack);
            }
        }

        #[test]
        fn logarithms_contain_the_exact_ones(x in any_double(), y in any_double(), point in any::<bool>()) {
            let (a, b) = (x.abs(), if point { x.abs() } else { y.abs() });
            let i = Interval::new(a.min(b), a.max(b));
            prop_assume!(i.hi > 0.0);
            let log = i.ln();
            for x in [i.lo, i.hi].into_iter().filter(|x| *x > 0.0) {
                let slack = Q::new(BigInt::from(i32::from(x != 1.0)), BigInt::from(1) << 240_u32);
                let value = ln(&exact(x).unwrap());
                prop_assert!(contains(log, &(&value - &slack)) && contains(log, &(&value + &slack)), "{i:?} {log:?}");
            }
            if i.lo == i.hi {
                prop_assert!(log.hi - log.lo <= 10.0 * f64::EPSILON * log.lo.abs().max(f64::MIN_POSITIVE) + 2.0 * f64::MIN_POSITIVE, "{i:?} {log:?}");
            }
        }
    }

    /// A finite end.
    fn xs_double(a: &Interval) -> f64 {
        if a.lo.is_finite() { a.lo } else { a.hi }
    }

    #[test]
    fn a_value_known_to_an_ulp_lies_within() {
        let x = 0.1_f64;
        let near = Interval::near(x);
        assert_eq!((near.lo, near.hi), (x.next_down(), x.next_up()));
    }
}
