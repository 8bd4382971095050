//! Configuration and velocity of a body.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::error::{Error, LARGEST, finite};
use crate::math::unsigned_zero::UnsignedZero;

/// Configuration and velocity of a body.
///
/// ```
/// use standfast::State;
///
/// assert_eq!(State::at_rest([0.0, 0.01, 0.0]), State::new([0.0, 0.01, 0.0], [0.0; 3]));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// q = (r_x, r_y, θ), in m, m, rad.
    pub q: Vector3<f64>,
    /// q̇, in m/s, m/s, rad/s.
    pub qdot: Vector3<f64>,
}

impl State {
    /// A state from plain arrays.
    #[must_use]
    pub fn new(q: [f64; 3], qdot: [f64; 3]) -> Self {
        Self { q: q.into(), qdot: qdot.into() }
    }

    /// Checks that every component is finite.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`], naming the component.
    pub fn validate(&self) -> Result<(), Error> {
        if self.q.iter().chain(&self.qdot).all(|value| value.abs() <= LARGEST) {
            return Ok(()); // names are made only for an error, because they cost more than the check
        }
        for (name, value) in ["x", "y", "theta"].into_iter().zip(self.q.iter()) {
            finite(format_args!("q.{name}"), *value)?;
        }
        for (name, value) in ["x", "y", "theta"].into_iter().zip(self.qdot.iter()) {
            finite(format_args!("qdot.{name}"), *value)?;
        }
        Ok(())
    }

    /// At rest in configuration `q`.
    #[must_use]
    pub fn at_rest(q: [f64; 3]) -> Self {
        Self::new(q, [0.0; 3])
    }
}

impl UnsignedZero for State {
    fn unsigned_zero(self) -> Self {
        Self { q: self.q.unsigned_zero(), qdot: self.qdot.unsigned_zero() }
    }
}
