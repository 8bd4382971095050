//! Painlevé's paradox: friction that drives a sliding contact into the terrain.

use crate::modes::problem::ContactProblem;
use crate::modes::words::Mode;
use crate::outcome::ContactNumber;

/// How close a contact is to jamming while it slides: a normal force then no longer lifts it.
///
/// With b = t·d, c = n·d and σ the direction of sliding, a unit normal force changes a_n by
///
/// ```text
/// P(μ) = (1/m)(1 + b(b + σμc)/ρ²)
/// ```
///
/// where P ≤ 0, sliding alone has no force or two, and motions may not exist or not be unique.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jamming {
    /// The contact.
    pub contact: ContactNumber,
    /// R or L.
    pub direction: Mode,
    /// P(μ)/P(0): one without friction, negative where the contact jams. Dimensionless.
    pub margin: f64,
    /// The friction at which it is zero; ∞ if it never is.
    pub critical_friction: f64,
}

impl ContactProblem {
    /// For each closed contact, each direction in which it slides or may begin to.
    #[must_use]
    pub fn jamming(&self) -> Vec<Jamming> {
        let mut all = Vec::new();
        for (i, row) in self.rows().iter().enumerate() {
            for direction in [Mode::Right, Mode::Left] {
                let sign = direction.direction();
                if row.sliding.is_none_or(|way| f64::from(way) * sign < 0.0) {
                    continue;
                }
                let drag = sign * row.normal.dot(&row.tangent);
                all.push(Jamming {
                    contact: ContactNumber::of(i),
                    direction,
                    margin: 1.0 - row.friction * drag,
                    critical_friction: if drag > 0.0 { 1.0 / drag } else { f64::INFINITY },
                });
            }
        }
        all
    }
}
