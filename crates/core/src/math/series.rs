//! Power series in the time since the start of a step.

use crate::math::roots::ORDER;

pub(crate) type Series = [f64; ORDER];
pub(crate) const ZERO: Series = [0.0; ORDER];

/// Two series.
pub(crate) type Pair = [[f64; 2]; ORDER];

/// Coefficient k of the product of two series.
pub(crate) fn product(a: &Series, b: &Series, k: usize) -> f64 {
    (0..=k).map(|j| a[j] * b[k - j]).sum()
}

/// The last coefficient of the products of each of two series with a third one, all with the same number of coefficients.
#[inline]
pub(crate) fn products(pair: &[[f64; 2]], other: &[f64]) -> [f64; 2] {
    let terms = pair.iter().zip(other.iter().rev());
    terms.fold([0.0; 2], |sum, (a, b)| [sum[0] + a[0] * b, sum[1] + a[1] * b])
}

/// The last coefficient of the sum of the products of two series and two others, all with the same number of coefficients.
#[inline]
pub(crate) fn dot_product(one: &[[f64; 2]], other: &[[f64; 2]]) -> f64 {
    let terms = one.iter().zip(other.iter().rev());
    let [x, y] = terms.fold([0.0; 2], |sum, (a, b)| [sum[0] + a[0] * b[0], sum[1] + a[1] * b[1]]);
    x + y
}

pub(crate) fn times(a: &Series, b: &Series, order: usize) -> Series {
    let mut series = ZERO;
    for (k, c) in series[..order].iter_mut().enumerate() {
        *c = product(a, b, k);
    }
    series
}

/// Determinant of the first n rows and columns.
pub(crate) fn determinant(m: &[[Series; 3]; 3], n: usize, order: usize) -> Series {
    let minor = |i: usize, j: usize, k: usize, l: usize| {
        let (one, two) = (times(&m[i][k], &m[j][l], order), times(&m[i][l], &m[j][k], order));
        std::array::from_fn(|k| one[k] - two[k])
    };
    match n {
        0 => constant(1.0),
        1 => m[0][0],
        2 => minor(0, 1, 0, 1),
        _ => {
            let parts = [
                times(&m[0][0], &minor(1, 2, 1, 2), order),
                times(&m[0][1], &minor(1, 2, 0, 2), order),
                times(&m[0][2], &minor(1, 2, 0, 1), order),
            ];
            std::array::from_fn(|k| parts[0][k] - parts[1][k] + parts[2][k])
        }
    }
}

/// The series about another time, Σ cₖ (t + by)ᵏ, by repeated synthetic division.
pub(crate) fn shifted(series: &Series, by: f64) -> Series {
    let mut shifted = *series;
    for k in 0..ORDER {
        for j in (k..ORDER - 1).rev() {
            shifted[j] += by * shifted[j + 1];
        }
    }
    shifted
}

/// The constant series.
pub(crate) fn constant(value: f64) -> Series {
    let mut series = ZERO;
    series[0] = value;
    series
}

/// Time up to which the last two terms of each series stay below `share` of the size of the quantity. The size is taken from the first
/// three terms, so that it does not vanish if the quantity passes through zero. In general these three terms count in full, in a unit of
/// time in which the body turns by about a radian. If forces soon grow without bound, each of the three terms counts only with its value at
/// the time in question. `all`: the first three and the last two coefficients of each series.
pub(crate) fn radius(all: &[[f64; 5]], share: f64, order: usize) -> f64 {
    let mut time = 1.0_f64;
    // The size enters by a root so high that each round gains a digit.
    for _ in 0..3 {
        let t = time.min(1.0);
        let (mut last, mut before) = (0.0_f64, 0.0_f64);
        for series in all {
            let size = series[0].abs().max(t * series[1].abs()).max(t * t * series[2].abs());
            if size > 0.0 {
                last = last.max(series[4].abs() / size);
                before = before.max(series[3].abs() / size);
            }
        }
        let reach = |term: f64, power: usize| {
            if term == 0.0 { f64::INFINITY } else { libm::pow(share / term, 1.0 / power as f64) }
        };
        time = reach(last, order - 1).min(reach(before, order - 2));
        if time.min(1.0) == t {
            break;
        }
    }
    time
}
