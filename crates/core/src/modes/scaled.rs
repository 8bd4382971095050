//! What the solvers of contact modes ask of a problem.

use crate::math::mass_vector::MassVector;
use crate::modes::rows::Row;
use crate::modes::squeeze::Squeeze;

/// What the solvers ask of a problem. All values are scaled unless a function says otherwise.
pub(super) trait Problem {
    /// Accelerations, in coordinates in which the mass is the identity.
    type V: MassVector;

    fn rows(&self) -> &[Row<Self::V>];

    /// Acceleration without contact forces.
    fn load(&self) -> &Self::V;

    /// Number of coordinates of an acceleration that is not scaled.
    fn coordinates(&self) -> usize;

    /// Acceleration from its scaled form, in m/s² and rad/s².
    fn acceleration(&self, y: &Self::V) -> Vec<f64>;

    /// Force (tangential, normal) at a contact from its scaled form, in N.
    fn force(&self, index: usize, scaled: [f64; 2]) -> [f64; 2];

    /// Internal force of two fixed contacts from its scaled form, in N.
    fn internal_force(&self, scaled: f64) -> f64;

    /// The forces of two fixed contacts that cause this change of the acceleration.
    fn squeeze(&self, closed: [usize; 2], rest: &Self::V) -> Squeeze;
}
