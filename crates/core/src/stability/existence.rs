//! Existence: whether arbitrarily small kicks lead where no contact mode is consistent and no impact is due (Painlevé).
//!
//! Frictional stability asks that after every small kick a motion exists. It does not if one of these holds, with σ = ±1 the direction of
//! sliding, N_i and T_i the normal and tangential row of contact i, and g_i gravity into its ground:
//!
//! * Contact i slides, the other one is in the air: k = N_i M⁻¹ (N_i − σ μ_i T_i)ᵀ < 0 and g_i > 0. Separation fails, since −g_i < 0 presses the
//!   contact onto the ground; sliding would need the force g_i/k < 0; it does not stick, because it slides.
//! * Both slide, q̇ = s z with N z = 0, σ_i = sign(T_i q̇), A_ij = N_i M⁻¹ (N_j − σ_j μ_j T_j)ᵀ, g > 0. All fail: both slide (A⁻¹g ≥ 0); i slides
//!   and j lifts (A_ii > 0 and A_ji g_i/A_ii > g_j); both lift (g < 0).
//!
//! All signs are certain (intervals); a sign that is not certain decides nothing.

use nalgebra::{Matrix3, RowVector3, Vector3};
use serde::{Deserialize, Serialize};

use crate::body::posture::Posture;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{Mode, Word};
use crate::outcome::ContactNumber;
use crate::stability::corner::CornerMap;

/// Sliding speed of a start without a motion, in units of √(g · size). The square of this number is the gap at that start, in units of the
/// size. Any smaller value has no motion either.
const SMALL: f64 = 1.0 / 1024.0;

/// A start from which no motion exists in the local model. At `q` and `qdot` these contacts touch and slide. The start may be as small
/// as one likes: with `qdot` times any factor 0 < f < 1, and `q` times f², there is no motion either.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoMotion {
    /// The contacts that slide.
    pub contacts: Vec<ContactNumber>,
    /// Their directions: R or L.
    pub slides: Word,
    /// k = N M⁻¹ (N − σμT)ᵀ of a contact that slides alone, per unit mass: negative.
    pub stiffness: Option<f64>,
    /// m, m, rad
    pub q: [f64; 3],
    /// m/s, m/s, rad/s
    pub qdot: [f64; 3],
}

/// The first of these starts: contact 1 slides to the right, to the left, contact 2 likewise, both slide.
pub(super) fn no_motion(map: &CornerMap, posture: &Posture) -> Option<NoMotion> {
    let local = map.local();
    for contact in 0..2 {
        for direction in [1.0, -1.0] {
            if local.jams_alone(contact, direction) {
                let apart = above(posture, [0, 1], contact)?;
                let k = local.stiffness(contact, direction).middle();
                return start(posture, &[(contact, direction)], 1 - contact, Some(k), apart);
            }
        }
    }
    let side = [1.0, -1.0].into_iter().find(|side| map.jams_together(*side))?;
    let directions = [0, 1].map(|i| (i, side * local.alpha[i].middle().signum()));
    start(posture, &directions, 1, None, Vector3::zeros())
}

/// Rows N_i, T_i and N_j.
fn rows(posture: &Posture, i: usize, j: usize) -> Matrix3<f64> {
    let [own, other] = [i, j].map(|k| posture.geometry()[k]);
    Matrix3::from_rows(&[
        RowVector3::new(own.normal.x, own.normal.y, own.b),
        RowVector3::new(own.tangent.x, own.tangent.y, -own.touching_c()),
        RowVector3::new(other.normal.x, other.normal.y, other.b),
    ])
}

/// A displacement that opens one contact of a pair by 1 m and keeps the other one, `pair[which]`, in its place.
pub(super) fn above(posture: &Posture, pair: [usize; 2], which: usize) -> Option<Vector3<f64>> {
    rows(posture, pair[which], pair[1 - which]).lu().solve(&Vector3::new(0.0, 0.0, 1.0))
}

/// The start at which these contacts (from 0) slide in these directions, and `other` keeps its gap. `open`: a displacement, per metre, that
/// opens all contacts that do not slide.
pub(super) fn start(
    posture: &Posture,
    slides: &[(usize, f64)],
    other: usize,
    stiffness: Option<f64>,
    open: Vector3<f64>,
) -> Option<NoMotion> {
    let (first, direction) = slides[0];
    let size = posture.size();
    let speed = SMALL * (posture.fields().gravity * size).sqrt();
    let mode = |way: f64| if way > 0.0 { Mode::Right } else { Mode::Left };
    let directions = slides.iter().enumerate();
    let slip = Vector3::new(0.0, direction * speed, 0.0);
    Some(NoMotion {
        contacts: slides.iter().map(|(i, _)| ContactNumber::of(*i)).collect(),
        slides: directions
            .fold(Word::separate(slides.len()), |word, (k, (_, way))| word.with(k, mode(*way))),
        stiffness,
        q: (open * (SMALL * SMALL * size)).unsigned_zero().into(),
        qdot: rows(posture, first, other).lu().solve(&slip)?.unsigned_zero().into(),
    })
}
