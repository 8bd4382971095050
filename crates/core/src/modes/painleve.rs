//! Painlevé's paradox: friction that drives a sliding contact into the terrain.

use crate::math::mass_vector::MassVector;
use crate::modes::problem::ContactProblem;
use crate::modes::rows::Row;
use crate::modes::words::Mode;
use crate::outcome::ContactNumber;

/// How close a sliding contact is to jamming. It jams if its normal force, together with the friction that this force causes, does not
/// accelerate it away from the terrain.
///
/// With b = t·d, c = n·d and σ the direction of sliding, a unit normal force changes a_n by
///
/// ```text
/// P(μ) = (1/m)(1 + b(b + σμc)/ρ²)
/// ```
///
/// If P ≤ 0, a slide on this contact alone has no consistent normal force, or two. A motion may then not exist, or not be unique.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jamming {
    /// The contact.
    pub contact: ContactNumber,
    /// R or L.
    pub direction: Mode,
    /// P(μ)/P(0): 1 without friction, negative where the contact jams. Dimensionless.
    pub margin: f64,
    /// The coefficient of friction at which P is zero; ∞ if there is none.
    pub critical_friction: f64,
}

impl ContactProblem {
    /// One entry for each closed contact and each direction in which it slides or may begin to slide.
    ///
    /// ```
    /// use standfast::modes::{ContactProblem, ProblemFields};
    ///
    /// // A uniform rod of half-length 1 slides to the right on its lower end, leaning back by atan 2: from μ = 4/3 on it jams.
    /// let (sin, cos) = (2.0 / 5f64.sqrt(), 1.0 / 5f64.sqrt());
    /// let problem = ContactProblem::new(ProblemFields {
    ///     mass: 1.0,
    ///     gyration_radius: (1.0 / 3f64).sqrt(),
    ///     arms: vec![[cos, -sin]],
    ///     tangents: vec![[1.0, 0.0]],
    ///     friction: vec![0.5],
    ///     sliding: vec![Some(1)],
    ///     bias: vec![[0.0, 0.0]],
    ///     free_acceleration: [0.0, -9.81, 0.0],
    ///     ..ProblemFields::default()
    /// })?;
    /// assert!((problem.jamming()[0].critical_friction - 4.0 / 3.0).abs() < 1e-15);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn jamming(&self) -> Vec<Jamming> {
        jamming(self.rows())
    }
}

/// The same of these rows.
pub(super) fn jamming<V: MassVector>(rows: &[Row<V>]) -> Vec<Jamming> {
    let mut all = Vec::new();
    for (i, row) in rows.iter().enumerate() {
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
