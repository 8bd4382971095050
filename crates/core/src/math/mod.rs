//! Arithmetic without mechanics: roots, rotations, power series, intervals, and random numbers.

pub(crate) mod ball;
#[cfg(test)]
pub(crate) mod cases;
pub(crate) mod clock;
pub(crate) mod collocation;
pub(crate) mod interval;
pub(crate) mod least_distance;
pub(crate) mod mass_vector;
pub(crate) mod orientation;
pub(crate) mod orthonormal;
pub(crate) mod random;
pub(crate) mod real;
pub(crate) mod roots;
pub(crate) mod series;
pub(crate) mod simplex;
pub(crate) mod turn;
pub(crate) mod unsigned_zero;
