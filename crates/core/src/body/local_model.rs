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
/// | symbol | meaning | unit |
/// | --- | --- | --- |
/// | g_i | gravity into terrain i | m/s² |
/// | ψ_i | coupling of the gap rates: an impact at i changes the rate of the other contact by −ψ_i times its own change | 1 |
/// | φ_i | coupling to the rotation | 1/m |
/// | e_i | restitution | 1 |
///
/// ```
/// use standfast::{Options, Stop};
/// use standfast::body::LocalModel;
/// use standfast::simulate::simulate_local;
///
/// // Inside the bound of clattering convergence: both contacts come to rest together.
/// let model = LocalModel::new([1.0, 1.0], [0.9, 0.9], [0.0, 0.0], [0.1, 0.1])?;
/// let run = simulate_local(&model, [0.0, 0.1], [0.1, -1.9], 0.0, 0.0, &Options { stop: Stop::Zeno, ..Options::default() })?;
/// assert_eq!(run.zeno_points()[0].kind, "2-zeno");
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "LocalModelFields", into = "LocalModelFields")]
pub struct LocalModel {
    gravity: [f64; 2],
    psi: [f64; 2],
    phi: [f64; 2],
    restitution: [f64; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LocalModelFields {
    gravity: [f64; 2],
    psi: [f64; 2],
    phi: [f64; 2],
    restitution: [f64; 2],
}

impl TryFrom<LocalModelFields> for LocalModel {
    type Error = Error;

    fn try_from(f: LocalModelFields) -> Result<Self, Error> {
        Self::new(f.gravity, f.psi, f.phi, f.restitution)
    }
}

impl From<LocalModel> for LocalModelFields {
    fn from(m: LocalModel) -> Self {
        Self { gravity: m.gravity, psi: m.psi, phi: m.phi, restitution: m.restitution }
    }
}

impl LocalModel {
    /// Validates the parameters.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] naming the parameter: gravity finite, ψ_1 and ψ_2 of one sign with
    /// ψ_1ψ_2 ≤ 1 (the impact matrix is positive semidefinite), φ finite, restitution in [0, 1).
    pub fn new(
        gravity: [f64; 2],
        psi: [f64; 2],
        phi: [f64; 2],
        restitution: [f64; 2],
    ) -> Result<Self, Error> {
        for i in 0..2 {
            let number = i + 1;
            error::effective_gravity(format!("gravity.{number}"), gravity[i])?;
            finite(format!("psi.{number}"), psi[i])?;
            finite(format!("phi.{number}"), phi[i])?;
            self::restitution(format!("restitution.{number}"), restitution[i])?;
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
        Ok(Self { gravity, psi, phi, restitution })
    }

    /// A model from values that are known to be valid.
    pub(crate) fn frozen(
        gravity: [f64; 2],
        psi: [f64; 2],
        phi: [f64; 2],
        restitution: [f64; 2],
    ) -> Self {
        Self { gravity, psi, phi, restitution }
    }

    /// (g_1, g_2), in m/s².
    #[must_use]
    pub fn gravity(&self) -> [f64; 2] {
        self.gravity
    }

    /// (ψ_1, ψ_2), dimensionless.
    #[must_use]
    pub fn psi(&self) -> [f64; 2] {
        self.psi
    }

    /// (φ_1, φ_2), in 1/m.
    #[must_use]
    pub fn phi(&self) -> [f64; 2] {
        self.phi
    }

    /// (e_1, e_2), dimensionless.
    #[must_use]
    pub fn restitution(&self) -> [f64; 2] {
        self.restitution
    }
}
