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

use crate::body::posture::Posture;
use crate::math::unsigned_zero::UnsignedZero;
use crate::outcome::ContactNumber;
use crate::stability::Evidence;
use crate::stability::corner::Local;

/// Sliding speed of a start without a motion, in units of √(g · size). The square of this number is the gap at that start, in units of the
/// size. Any smaller value has no motion either.
const SMALL: f64 = 1.0 / 1024.0;

/// Kicks after which there is no motion.
pub(super) enum Lack {
    /// This contact slides alone; the first number is its direction, the second one its k.
    Alone(usize, f64, f64),
    /// Both contacts slide along z times this sign.
    Together(f64),
}

/// The first of these kicks after which there is no motion: contact 1 slides to the right or to the left, contact 2 likewise, both slide.
pub(super) fn lack(local: &Local) -> Option<Lack> {
    for contact in 0..2 {
        for direction in [1.0, -1.0] {
            let k = local.stiffness(contact, direction);
            if k.is_negative() && local.g[contact].is_positive() {
                return Some(Lack::Alone(contact, direction, k.middle()));
            }
        }
    }
    [1.0, -1.0].into_iter().find(|side| local.no_slide_together(*side)).map(Lack::Together)
}

/// The evidence: a start in the local model at which no mode is consistent and no impact is due.
pub(super) fn evidence(lack: &Lack, local: &Local, posture: &Posture) -> Option<Evidence> {
    let geometry = posture.geometry();
    let (first, direction) = match lack {
        Lack::Alone(contact, direction, _) => (*contact, *direction),
        Lack::Together(side) => (0, side * local.alpha[0].middle().signum()),
    };
    let [own, other] = [first, 1 - first].map(|i| geometry[i]);
    let rows = Matrix3::from_rows(&[
        RowVector3::new(own.normal.x, own.normal.y, own.b),
        RowVector3::new(own.tangent.x, own.tangent.y, -own.c),
        RowVector3::new(other.normal.x, other.normal.y, other.b),
    ])
    .lu();
    let size = posture.size();
    let speed = SMALL * (posture.fields().gravity * size).sqrt();
    let qdot = rows.solve(&Vector3::new(0.0, direction * speed, 0.0))?;
    let (contacts, gap, stiffness) = match lack {
        Lack::Alone(contact, _, k) => (vec![*contact], SMALL * SMALL * size, Some(*k)),
        Lack::Together(_) => (vec![0, 1], 0.0, None),
    };
    let q = rows.solve(&Vector3::new(0.0, 0.0, gap))?;
    let slides = |i: &usize| {
        let way = match lack {
            Lack::Alone(_, direction, _) => *direction,
            Lack::Together(side) => side * local.alpha[*i].middle().signum(),
        };
        if way > 0.0 { 'R' } else { 'L' }
    };
    Some(Evidence::NoMotion {
        slides: contacts.iter().map(slides).collect(),
        contacts: contacts.into_iter().map(ContactNumber::of).collect(),
        stiffness,
        q: q.unsigned_zero().into(),
        qdot: qdot.unsigned_zero().into(),
    })
}
