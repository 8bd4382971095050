//! The local model: the paper's reduced, frictionless linearisation of a two-contact posture.
//!
//! All Jacobian rows are frozen, so every flight is an exact parabola in each gap:
//!
//! ```text
//! ḧ_i = −g_i                                                      between impacts
//! ḣ_i⁺ = −e_i w,  ḣ_j⁺ = ḣ_j⁻ + (1+e_i)ψ_i w,  θ̇⁺ = θ̇⁻ + (1+e_i)φ_i w    impact at i, w = ḣ_i⁻ < 0
//! ```
//!
//! [Or & Rimon 2008, (5), (6)]. The rotation θ has no effect on the gaps.

use serde::{Deserialize, Serialize};

use crate::error;
use crate::error::{Error, finite, in_range, restitution};
use crate::tolerance::COUPLING_ROUNDING;

/// The local model of a two-contact posture, given by its parameters.
///
/// ```
/// use standfast::body::{LocalModel, LocalModelFields, LocalState};
/// use standfast::simulate::simulate_local;
/// use standfast::{Options, Stop};
///
/// // Inside the bound of clattering convergence: both contacts come to rest together.
/// let model = LocalModel::new(LocalModelFields {
///     gravity: [1.0, 1.0],
///     psi: [0.9, 0.9],
///     restitution: [0.1, 0.1],
///     ..LocalModelFields::default()
/// })?;
/// let start = LocalState { gaps: [0.0, 0.1], rates: [0.1, -1.9], ..LocalState::default() };
/// let run = simulate_local(&model, &start, &Options { stop: Stop::Zeno, ..Options::default() })?;
/// assert_eq!(run.zeno_points()[0].contacts.len(), 2);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "LocalModelFields", into = "LocalModelFields")]
pub struct LocalModel(LocalModelFields);

/// The parameters of a local model, before validation; contact 1 first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalModelFields {
    /// g_i: gravity into terrain i, in m/s².
    pub gravity: [f64; 2],
    /// ψ_i: an impact at i changes the gap rate of the other contact by −ψ_i times its own change, dimensionless.
    pub psi: [f64; 2],
    /// φ_i: coupling to the rotation, in 1/m.
    pub phi: [f64; 2],
    /// e_i: restitution in [0, 1], dimensionless.
    pub restitution: [f64; 2],
}

impl Default for LocalModelFields {
    /// Level ground with g = 9.81 m/s², no coupling, no restitution.
    fn default() -> Self {
        Self { gravity: [9.81; 2], psi: [0.0; 2], phi: [0.0; 2], restitution: [0.0; 2] }
    }
}

/// The start of a run of a local model; contact 1 first.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct LocalState {
    /// Gaps, in m.
    pub gaps: [f64; 2],
    /// Gap rates, in m/s.
    pub rates: [f64; 2],
    /// Rotation θ, in rad.
    pub theta: f64,
    /// Angular velocity ω, in rad/s.
    pub omega: f64,
}

impl TryFrom<LocalModelFields> for LocalModel {
    type Error = Error;

    fn try_from(fields: LocalModelFields) -> Result<Self, Error> {
        Self::new(fields)
    }
}

impl From<LocalModel> for LocalModelFields {
    fn from(model: LocalModel) -> Self {
        model.0
    }
}

impl LocalModel {
    /// Validates the parameters.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] naming the parameter: gravity finite, ψ_1 and ψ_2 of one sign with
    /// ψ_1ψ_2 ≤ 1 (the impact matrix is positive semidefinite), φ finite, restitution in [0, 1].
    pub fn new(fields: LocalModelFields) -> Result<Self, Error> {
        let LocalModelFields { gravity, psi, phi, restitution } = fields;
        for i in 0..2 {
            let number = i + 1;
            error::effective_gravity(format_args!("gravity.{number}"), gravity[i])?;
            finite(format_args!("psi.{number}"), psi[i])?;
            finite(format_args!("phi.{number}"), phi[i])?;
            self::restitution(format_args!("restitution.{number}"), restitution[i])?;
        }
        let product = psi[0] * psi[1];
        in_range(
            "psi.1 * psi.2",
            product,
            (0.0..=1.0 + COUPLING_ROUNDING).contains(&product),
            "between 0 and 1 (psi.1 and psi.2 of one sign)",
        )?;
        in_range(
            "psi.2",
            psi[1],
            (psi[0] == 0.0) == (psi[1] == 0.0) || product == 0.0 && psi[0] != 0.0 && psi[1] != 0.0,
            "zero exactly where psi.1 is",
        )?;
        Ok(Self(fields))
    }

    /// A model from values that are known to be valid.
    pub(crate) fn frozen(fields: LocalModelFields) -> Self {
        Self(fields)
    }

    /// (g_1, g_2), in m/s².
    #[must_use]
    pub fn gravity(&self) -> [f64; 2] {
        self.0.gravity
    }

    /// (ψ_1, ψ_2), dimensionless.
    #[must_use]
    pub fn psi(&self) -> [f64; 2] {
        self.0.psi
    }

    /// (φ_1, φ_2), in 1/m.
    #[must_use]
    pub fn phi(&self) -> [f64; 2] {
        self.0.phi
    }

    /// (e_1, e_2), dimensionless.
    #[must_use]
    pub fn restitution(&self) -> [f64; 2] {
        self.0.restitution
    }
}
