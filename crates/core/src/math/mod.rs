//! Arithmetic without mechanics: roots, rotations, power series, intervals, and random numbers.

pub(crate) mod active_set;
pub(crate) mod ball;
#[cfg(test)]
pub(crate) mod cases;
pub(crate) mod clock;
pub(crate) mod collocation;
pub(crate) mod copositive;
pub(crate) mod extents;
pub(crate) mod interval;
pub(crate) mod least_distance;
#[cfg(feature = "qp")]
pub(crate) mod lemke;
pub(crate) mod linear;
pub(crate) mod mass_vector;
pub(crate) mod orientation;
pub(crate) mod orthonormal;
pub(crate) mod random;
pub(crate) mod real;
pub(crate) mod roots;
pub(crate) mod series;
pub(crate) mod simplex;
#[cfg(feature = "qp")]
pub(crate) mod sparse;
pub(crate) mod turn;
pub(crate) mod unsigned_zero;

/// The entries of a row that are not zero, by column.
pub(crate) type Sparse = Vec<(usize, f64)>;

/// Σ a b as if computed with twice the number of digits and rounded at the end [Ogita, Rump & Oishi 2005, Dot2].
#[inline]
pub(crate) fn compensated_sum(products: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let (mut sum, mut rest) = (0.0_f64, 0.0_f64);
    for (a, b) in products {
        let product = a * b;
        let product_error = a.mul_add(b, -product);
        let total = sum + product;
        let part = total - sum;
        rest += (sum - (total - part)) + (product - part) + product_error;
        sum = total;
    }
    sum + rest
}
