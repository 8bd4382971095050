//! Balls: numbers of 106 bits, each with a bound of its error.
//!
//! The centre is an unevaluated sum of two doubles hi + lo, |lo| ≤ ½ ulp(hi). The relative errors of sums and products are at most 3u² and
//! 5u², u = 2⁻⁵³ [Joldes, Muller & Popescu, ACM TOMS 44 (2017) 15, algorithms 6 and 11]. The errors of quotients and roots are computed
//! from the residuals. Sums need gradual underflow, which IEEE 754 prescribes and every compiler has by default.

use std::ops::{Add, Mul, Neg, Sub};

use crate::math::real::{Enclosed, Ring};

/// A sum of two doubles, and the largest possible error of this sum.
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
/// More than the rounding errors of a radius that is computed from a few positive terms.
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
    fn around((hi, lo): (f64, f64), radius: f64) -> Self {
        Self { hi, lo, radius: (radius + ROUNDING * hi.abs()) * SLACK }
    }

    /// A ball that contains an interval.
    pub(crate) fn containing([lo, hi]: [f64; 2]) -> Self {
        let middle = 0.5 * lo + 0.5 * hi;
        let radius = (hi - middle).max(middle - lo).next_up();
        Self { hi: middle, lo: 0.0, radius: if lo == hi { 0.0 } else { radius } }
    }

    /// The double nearest the centre.
    pub(crate) fn middle(self) -> f64 {
        self.hi
    }

    /// The centre alone, as a ball of radius zero.
    pub(crate) fn center(self) -> Self {
        Self { radius: 0.0, ..self }
    }

    /// The ball enlarged by this radius.
    pub(crate) fn widened(self, by: f64) -> Self {
        Self { radius: (self.radius + by) * SLACK, ..self }
    }

    /// An upper bound of the absolute values of the numbers in the ball.
    pub(crate) fn size(self) -> f64 {
        (self.hi.abs() + self.radius) * SLACK
    }

    /// A lower bound of the absolute values of the numbers in the ball; 0 if the ball may contain zero.
    pub(crate) fn clearance(self) -> f64 {
        ((self.hi.abs() / SLACK - self.radius) / SLACK).max(0.0)
    }
}

impl Ring for Ball {
    fn half(self) -> Self {
        self.scaled(0.5)
    }
}

impl Enclosed for Ball {
    const ZERO: Self = Self { hi: 0.0, lo: 0.0, radius: 0.0 };

    fn square(self) -> Self {
        self * self
    }

    fn scaled(self, power: f64) -> Self {
        if self.is_zero() {
            return self;
        }
        let hi = self.hi * power;
        let radius = if hi.is_finite() { self.radius * power + TINY } else { f64::INFINITY };
        Self { hi, lo: self.lo * power, radius: radius * SLACK }
    }

    /// The quotient x/y. Its ball is q ± |x − q y|/min |y|, with any q near the quotient; `None` if y may be zero.
    fn over(self, y: Self) -> Option<Self> {
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

    /// The square root of x. Its ball is s ± |x − s²|/(s + min √x), with any s > 0 near the root; `None` unless x is
    /// exactly zero or certainly positive.
    fn root(self) -> Option<Self> {
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

    fn max(self, other: Self) -> Self {
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

    fn not_below_zero(self) -> Self {
        self
    }

    fn is_positive(self) -> bool {
        self.hi > 0.0 && self.clearance() > 0.0
    }

    fn is_zero(self) -> bool {
        self == Self::ZERO
    }

    fn bounds(self) -> [f64; 2] {
        if self.lo == 0.0 && self.radius == 0.0 {
            return [self.hi; 2];
        }
        let at = |side: f64| self.hi + (self.lo + side * (self.radius * SLACK));
        // The bracket is rounded by far less than an ulp of hi, or than the slack, the whole by half an ulp.
        [at(-1.0).next_down(), at(1.0).next_up()]
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
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::{Fraction as Q, any_double, exact, fixed, fraction};

    /// A ball and five numbers in it, among them the ends and the centre.
    fn any_ball() -> impl Strategy<Value = (Ball, [Q; 5])> {
        (any_double(), -0.5..0.5, 0..4_u8, -40.0..1.0).prop_map(|(hi, part, kind, width)| {
            let lo: f64 = part * (hi.next_up() - hi);
            let lo = if kind == 0 || hi + lo != hi || !lo.is_finite() { 0.0 } else { lo };
            let radius = match kind {
                2 => hi.abs() * f64::exp2(4.0 * width),
                3 => hi.abs() * f64::exp2(1.0 + 0.1 * width), // about as wide as large
                _ => 0.0,
            };
            let ball = Ball { hi, lo, radius: if radius.is_finite() { radius } else { 0.0 } };
            (
                ball,
                [-7, -3, 0, 4, 7]
                    .map(|k| center(ball) + exact(ball.radius).unwrap() * fraction(k, 7)),
            )
        })
    }

    fn center(x: Ball) -> Q {
        exact(x.hi).unwrap() + exact(x.lo).unwrap()
    }

    /// Returns true if a number is in a ball. A ball that has overflowed contains every number, and must not claim a sign.
    fn contains(ball: Ball, x: &Q) -> bool {
        let Ball { hi, lo, radius } = ball;
        if let (Some(hi), Some(lo), Some(radius)) = (exact(hi), exact(lo), exact(radius)) {
            let off = x - (hi + lo);
            off <= radius && -off <= radius
        } else {
            !ball.is_positive() && !ball.is_negative() && ball.clearance() == 0.0
        }
    }

    /// Bound of the radius that an operation may add: a dozen rounding errors of numbers with 106 bits, relative to `value`, plus an
    /// absolute one.
    fn rounding(value: &Q) -> Q {
        let size = if *value < zero() { -value } else { value.clone() };
        size * exact(16.0 * ROUNDING).unwrap() + exact(8.0 * TINY).unwrap()
    }

    fn zero() -> Q {
        fraction(0, 1)
    }

    fn size(x: &Q) -> Q {
        if *x < zero() { -x } else { x.clone() }
    }

    /// Returns true if all balls are far from overflow and from underflow, so that results must be narrow.
    fn ordinary(balls: &[Ball]) -> bool {
        balls.iter().all(|x| x.hi == 0.0 || (1e-60..1e60).contains(&x.hi.abs()))
    }

    /// Checks that the result contains all values and, for ordinary arguments, that its radius is at most that of the exact set of values,
    /// plus the rounding errors and one hundredth.
    fn check(
        arguments: &[Ball],
        result: Ball,
        values: &[Q],
        scale: &Q,
    ) -> Result<(), TestCaseError> {
        for value in values {
            prop_assert!(contains(result, value), "{arguments:?} {result:?}");
        }
        if let (true, Some(least), Some(most)) =
            (ordinary(arguments), values.iter().min(), values.iter().max())
        {
            let half = (most - least) * fraction(1, 2);
            let radius = exact(result.radius).unwrap();
            prop_assert!(
                radius <= half * fraction(101, 100) + rounding(scale),
                "{arguments:?} {result:?}"
            );
        }
        Ok(())
    }

    fn each(xs: &[Q], ys: &[Q], of: impl Fn(&Q, &Q) -> Q) -> Vec<Q> {
        xs.iter().flat_map(|x| ys.iter().map(|y| of(x, y)).collect::<Vec<_>>()).collect()
    }

    proptest! {
        #![proptest_config(fixed(22))]

        #[test]
        fn sums_and_products_contain_the_exact_ones((a, xs) in any_ball(), (b, ys) in any_ball()) {
            let sum = size(&center(a)) + size(&center(b));
            check(&[a, b], a + b, &each(&xs, &ys, |x, y| x + y), &sum)?;
            check(&[a, b], a - b, &each(&xs, &ys, |x, y| x - y), &sum)?;
            let product = each(&xs, &ys, |x, y| x * y);
            // r_a r_b is counted twice: |xy| is at most the largest product.
            let twice = exact(a.radius).unwrap() * exact(b.radius).unwrap() * fraction(2, 1);
            for value in &product {
                prop_assert!(contains(a * b, value), "{a:?} {b:?} {:?}", a * b);
            }
            if ordinary(&[a, b]) {
                let most = size(&center(a)) * exact(b.radius).unwrap() + size(&center(b)) * exact(a.radius).unwrap() + twice;
                let radius = exact((a * b).radius).unwrap();
                prop_assert!(radius <= most * fraction(101, 100) + rounding(&(center(a) * center(b))), "{a:?} {b:?} {:?}", a * b);
            }
        }

        #[test]
        fn quotients_contain_the_exact_ones((a, xs) in any_ball(), (b, ys) in any_ball()) {
            let crosses = ys.iter().min().is_some_and(|y| *y <= zero()) && ys.iter().max().is_some_and(|y| *y >= zero());
            let quotient = a.over(b);
            prop_assert!(!(crosses && quotient.is_some()), "{a:?} {b:?}");
            if let Some(quotient) = quotient {
                for value in each(&xs, &ys, |x, y| x / y) {
                    prop_assert!(contains(quotient, &value), "{a:?} {b:?} {quotient:?}");
                }
            }
            let narrow = b.radius <= 0.01 * b.hi.abs() && b.hi != 0.0;
            if ordinary(&[a, b]) && narrow {
                let (x, y) = (center(a), size(&center(b)));
                let most = (exact(a.radius).unwrap() + exact(b.radius).unwrap() * size(&x) / &y) / &y;
                let radius = exact(quotient.unwrap().radius).unwrap();
                prop_assert!(radius <= most * fraction(11, 10) + rounding(&(x / y)), "{a:?} {b:?} {quotient:?}");
            }
        }

        /// Checks that each x lies in the square of the ball of its root. This comparison needs no exact root.
        #[test]
        fn roots_contain_the_exact_ones((a, xs) in any_ball()) {
            let least = xs.iter().min().unwrap();
            let Some(root) = a.root() else {
                let sure = ordinary(&[a]) && a.hi > 0.0 && a.radius <= 0.99 * a.hi;
                prop_assert!(!sure, "{a:?}");
                return Ok(());
            };
            prop_assert!(*least >= zero());
            let (middle, radius) = (center(root), exact(root.radius).unwrap());
            let (low, high) = (&middle - &radius, &middle + &radius);
            for x in &xs {
                prop_assert!(*x <= &high * &high && (low <= zero() || &low * &low <= *x), "{a:?} {root:?}");
            }
            if ordinary(&[a]) && a.hi > 0.0 {
                // √(m + r) − √(m − r) is at most 2r/√m.
                let m = center(a);
                let most = exact(a.radius).unwrap() * fraction(101, 100) + rounding(&m);
                prop_assert!(&radius * &radius * &m <= &most * &most, "{a:?} {root:?}");
            }
        }

        #[test]
        fn other_operations_contain_the_exact_values((a, xs) in any_ball(), (b, ys) in any_ball(), power in -60..60) {
            check(&[a], -a, &xs.clone().map(|x| -x), &zero())?;
            let factor = f64::from(power).exp2();
            let scaled = xs.clone().map(|x| x * exact(factor).unwrap());
            check(&[a], a.scaled(factor), &scaled, &zero())?;
            check(&[a], a.half(), &xs.clone().map(|x| x * fraction(1, 2)), &zero())?;
            for (k, x) in xs.iter().enumerate() {
                prop_assert!(contains(a.square(), &(x * x)));
                prop_assert!(contains(a.widened(b.hi.abs()), &(x + exact(b.hi).unwrap() * fraction(k as i32 - 2, 2))));
            }
            for value in each(&xs, &ys, |x, y| x.max(y).clone()) {
                prop_assert!(contains(a.max(b), &value), "{a:?} {b:?} {:?}", a.max(b));
            }
            if ordinary(&[a, b]) {
                let most = |k: usize| size(&xs[k]).max(size(&ys[k]));
                let limit = (most(0).max(most(4))) * fraction(4, 1);
                prop_assert!(exact(a.max(b).radius).unwrap() <= limit);
            }
            prop_assert!(contains(a.center(), &center(a)) && a.center().radius == 0.0);
            prop_assert!(contains(Ball::from(a.hi), &exact(a.hi).unwrap()));
            prop_assert_eq!(a.middle(), a.hi);
        }

        #[test]
        fn signs_and_bounds_hold_for_all_numbers((a, xs) in any_ball()) {
            let (least, most) = (xs.iter().min().unwrap(), xs.iter().max().unwrap());
            prop_assert!(!a.is_positive() || *least > zero(), "{a:?}");
            prop_assert!(!a.is_negative() || *most < zero(), "{a:?}");
            prop_assert!(!a.is_not_negative() || *least >= zero(), "{a:?}");
            prop_assert_eq!(a.is_zero(), *least == zero() && *most == zero());
            let (least_size, most_size) = (exact(a.clearance()).unwrap(), exact(a.size()));
            for x in &xs {
                prop_assert!(least_size <= size(x), "{a:?}");
                prop_assert!(most_size.as_ref().is_none_or(|most| size(x) <= *most), "{a:?}");
            }
            let [low, high] = a.bounds();
            prop_assert!(exact(low).map_or(low == f64::NEG_INFINITY, |low| low <= *least), "{a:?} {low:?}");
            prop_assert!(exact(high).map_or(high == f64::INFINITY, |high| high >= *most), "{a:?} {high:?}");
            if ordinary(&[a]) && a.hi != 0.0 && a.radius <= 0.9 * a.hi.abs() {
                prop_assert!(a.is_positive() == (a.hi > 0.0) && a.is_negative() == (a.hi < 0.0), "{a:?}");
                let slack = exact(1e-13 * a.hi.abs()).unwrap();
                prop_assert!(size(&center(a)) - exact(a.radius).unwrap() <= least_size + &slack);
                prop_assert!(most_size.unwrap() <= size(&center(a)) + exact(a.radius).unwrap() + &slack);
                // Three doubles around an end.
                let ulps = exact(3.0 * (a.hi.abs().next_up() - a.hi.abs()) + 1e-13 * a.radius).unwrap();
                prop_assert!(exact(high).unwrap() - most <= ulps && least - exact(low).unwrap() <= ulps, "{a:?}");
            }
        }
    }

    #[test]
    fn what_is_not_certain_is_not_claimed() {
        let x = Ball::from(0.1);
        assert!(x.over(x - Ball::from(0.1)).is_none());
        let vast = Ball::from(1e308).scaled(2.0);
        assert!(x.over(vast).is_none() && !vast.is_positive());
        let wide = Ball { radius: 0.2, ..x };
        assert!(wide.over(wide).is_none() && wide.root().is_none());
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
