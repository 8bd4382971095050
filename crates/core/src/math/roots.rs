//! Roots of functions of one variable. The first root is found with certainty.

/// Steps after which a bracket cannot shrink any more: the exponent range plus the fraction bits.
const STEPS: usize = 2200;

/// A sign change of `f` in [a, b] with f(a) > 0 ≥ f(b), located to the last bit. `f` returns its value and slope.
///
/// Newton's method safeguarded by bisection (Dekker's scheme). The bracket is halved instead if a Newton step leaves the bracket, or if it
/// is more than half as long as the step before the last one.
pub(crate) fn bracketed(mut a: f64, mut b: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let mut x = b;
    let (mut step, mut before) = (b - a, b - a);
    for _ in 0..STEPS {
        let (value, slope) = f(x);
        if value > 0.0 {
            a = x;
        } else {
            b = x;
        }
        let newton = -value / slope;
        let next = x + newton;
        let short = newton.abs() < 0.5 * before.abs();
        before = step;
        (step, x) = if next == x {
            return x;
        } else if short && next > a && next < b {
            (newton, next)
        } else {
            let middle = a + 0.5 * (b - a);
            if middle <= a || middle >= b {
                return b;
            }
            (middle - x, middle)
        };
    }
    b
}

/// Largest number of coefficients of a polynomial here.
pub(crate) const ORDER: usize = 21;

/// First root in (0, end] of Σ cₖ tᵏ at which the polynomial goes from positive to negative. A root at t = 0 itself does not count.
///
/// Descartes' rule in the Bernstein basis: without a sign change of the coefficients there is no root; with one sign change there is
/// exactly one root. Otherwise the interval is halved (de Casteljau), and the earlier half is examined first. A double root, at which the
/// polynomial touches zero without crossing, can be missed because of rounding errors; it is not a collision.
///
/// `count`: the number of coefficients; the further entries are zero.
pub(crate) fn first_root(coefficients: &[f64; ORDER], count: usize, end: f64) -> Option<f64> {
    // Divide out the root at zero.
    let zeros = coefficients[..count].iter().position(|c| *c != 0.0)?;
    // Powers of a large `end` beyond the last coefficient may overflow.
    let degree = coefficients[..count].iter().rposition(|c| *c != 0.0)?;
    let count = degree + 1 - zeros;
    let mut scaled = [0.0; ORDER];
    let mut power = 1.0;
    for k in 0..count {
        scaled[k] = coefficients[k + zeros] * power;
        power *= end;
    }
    if scaled[0] < 0.0 {
        return None; // negative from the start: not a crossing
    }
    if scaled[0] > scaled[1..count].iter().map(|c| c.abs()).sum() {
        return None; // all Bernstein coefficients are positive
    }
    let value = |x: f64| {
        let (mut p, mut dp) = (0.0, 0.0);
        for c in scaled[..count].iter().rev() {
            dp = dp * x + p;
            p = p * x + c;
        }
        (p, dp)
    };
    first_crossing(&bernstein(&scaled[..count])[..count], 0.0, 1.0, 0, &value).map(|x| x * end)
}

/// Bernstein coefficients on [0, 1]: βᵢ = Σ_{j≤i} C(i,j) aⱼ/C(n,j), by the rule of Pascal's triangle.
fn bernstein(a: &[f64]) -> [f64; ORDER] {
    let n = a.len() - 1;
    let mut beta = [0.0; ORDER];
    let mut binomial = 1.0; // C(n,j)
    for (j, (value, coefficient)) in beta.iter_mut().zip(a).enumerate() {
        *value = coefficient / binomial;
        binomial = binomial * (n - j) as f64 / (j + 1) as f64;
    }
    for level in 1..=n {
        for i in (level..=n).rev() {
            beta[i] += beta[i - 1];
        }
    }
    beta
}

/// Largest number of halvings in a row. After so many, an interval is a few ulp wide.
const DEEPEST: usize = 48;

fn first_crossing(
    beta: &[f64],
    from: f64,
    to: f64,
    depth: usize,
    value: &impl Fn(f64) -> (f64, f64),
) -> Option<f64> {
    let changes = beta.windows(2).filter(|w| (w[0] > 0.0) != (w[1] > 0.0)).count();
    if changes == 0 {
        return None;
    }
    if changes == 1 || depth == DEEPEST {
        return (value(from).0 > 0.0 && value(to).0 <= 0.0).then(|| bracketed(from, to, value));
    }
    let count = beta.len();
    let (mut left, mut right) = ([0.0; ORDER], [0.0; ORDER]);
    left[..count].copy_from_slice(beta);
    right[count - 1] = left[count - 1];
    for level in 1..count {
        for k in (level..count).rev() {
            left[k] = 0.5 * (left[k - 1] + left[k]);
        }
        right[count - 1 - level] = left[count - 1];
    }
    let middle = 0.5 * (from + to);
    first_crossing(&left[..count], from, middle, depth + 1, value)
        .or_else(|| first_crossing(&right[..count], middle, to, depth + 1, value))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::fixed;

    fn poly(roots: &[f64]) -> [f64; ORDER] {
        let mut c = [0.0; ORDER];
        c[0] = 1.0;
        for (degree, root) in roots.iter().enumerate() {
            for k in (0..=degree + 1).rev() {
                c[k] -= if k > 0 { c[k - 1] / root } else { 0.0 };
            }
        }
        c
    }

    #[test]
    fn the_first_of_many_roots() {
        let c = poly(&[0.7, 0.3, 0.31, 2.0, -1.0]);
        let root = first_root(&c, ORDER, 1.0).unwrap();
        assert!((root - 0.3).abs() < 1e-14, "{root}");
        assert_eq!(first_root(&c, ORDER, 0.29), None);
        assert_eq!(first_root(&poly(&[2.0, -0.5]), ORDER, 1.9), None);
    }

    #[test]
    fn a_root_far_before_the_end() {
        let mut c = [0.0; ORDER];
        (c[0], c[1]) = (0.3, -2.7);
        for end in [1.0, 1e12, 1e16, 1e18, 1e25, 1e150] {
            for count in [2, 5, 8, ORDER] {
                let root = first_root(&c, count, end).unwrap();
                assert!((root * 9.0 - 1.0).abs() < 1e-15, "{end}, {count}: {root}");
            }
        }
    }

    #[test]
    fn leaving_zero_is_no_root() {
        let mut c = [0.0; ORDER];
        (c[1], c[2]) = (1e-9, -1.0); // t (1e-9 − t)
        let root = first_root(&c, ORDER, 1.0).unwrap();
        assert!((root - 1e-9).abs() < 1e-23, "{root}");
        c[2] = 0.0;
        assert_eq!(first_root(&c, ORDER, 1.0), None);
    }

    #[test]
    fn brackets_shrink_to_the_last_bit() {
        let root = bracketed(0.0, 2.0, |x| (2.0 - x * x, -2.0 * x));
        assert!((root - 2f64.sqrt()).abs() <= 2.3e-16);
        let cubic = bracketed(0.0, 1.0, |x: f64| (1e-30 - x.powi(3), -3.0 * x * x));
        assert!((cubic - 1e-10).abs() < 1e-25, "{cubic}");
    }
    proptest! {
        #![proptest_config(fixed(7))]

        /// Polynomials with given real roots within [0, 1], before and behind it, and pairs of complex roots. The first crossing must be
        /// the smallest of the roots within. The allowed error is proportional to the condition number of this root, 1 / Π |1 −
        /// root/other|.
        #[test]
        fn the_planted_root_is_found(
            mut within in prop::collection::vec(0.05..0.95_f64, 0..5),
            outside in prop::collection::vec(prop_oneof![-3.0..-0.2_f64, 1.2..4.0_f64], 0..4),
            pairs in prop::collection::vec((-1.0..1.0_f64, 0.3..1.0_f64), 0..3),
            at_zero in 0..3_usize,
        ) {
            within.sort_by(f64::total_cmp);
            prop_assume!(within.windows(2).all(|w| w[1] - w[0] > 0.02));
            let real: Vec<f64> = within.iter().chain(&outside).copied().collect();
            let mut c = poly(&real);
            for &(re, im) in &pairs {
                // times 1 − 2 re t/|z|² + t²/|z|²
                let square = re * re + im * im;
                for k in (0..ORDER).rev() {
                    let of = |back: usize| if k >= back { c[k - back] } else { 0.0 };
                    c[k] += (of(2) - 2.0 * re * of(1)) / square;
                }
            }
            c.rotate_right(at_zero); // times t to that power: a root at zero is none
            let found = first_root(&c, ORDER, 1.0);
            match (within.first(), found) {
                (Some(&root), Some(found)) => {
                    let distance = |other: &f64| (1.0 - root / other).abs();
                    let complex = |&(re, im): &(f64, f64)| {
                        ((re - root) * (re - root) + im * im) / (re * re + im * im)
                    };
                    let apart: f64 = real.iter().filter(|r| **r != root).map(distance).product::<f64>()
                        * pairs.iter().map(complex).product::<f64>();
                    let size: f64 = c.iter().map(|c| c.abs()).sum();
                    prop_assert!((found - root).abs() <= 16.0 * f64::EPSILON * size / apart, "{found} {root}");
                }
                (expected, found) => prop_assert_eq!(expected.copied(), found),
            }
        }
    }
}
