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

use crate::body::Mechanism;
use crate::body::posture::Posture;
use crate::math::mass_vector::Coordinates;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{Mode, Word};
use crate::outcome::ContactNumber;
use crate::stability::corner::CornerMap;
use crate::stability::jams::NoMotion;
use nalgebra::{Matrix3, RowVector3, Vector3};

/// Sliding speed of a start without a motion, in units of √(g · size). The square of this number is the gap at that start, in units of the
/// size. Any smaller value has no motion either.
const SMALL: f64 = 1.0 / 1024.0;

/// What stands on two contacts.
#[derive(Clone, Copy)]
pub(super) enum Standing<'a> {
    Body(&'a Posture),
    /// With three coordinates that are not locked.
    Mechanism(&'a Mechanism),
}

impl Standing<'_> {
    /// The unit of a displacement, in m: the size of the body, or 1 m for a mechanism; and of a speed, in m/s.
    fn units(&self) -> [f64; 2] {
        let (size, gravity) = match self {
            Self::Body(posture) => (posture.size(), posture.fields().gravity),
            Self::Mechanism(mechanism) => (1.0, mechanism.contact_space().largest_pull()),
        };
        [size, (gravity * size).sqrt()]
    }

    /// A displacement or velocity with these values of N_i, T_i and N_j, in all coordinates.
    pub(super) fn solve(&self, i: usize, j: usize, values: [f64; 3]) -> Option<Vec<f64>> {
        let values = Vector3::from(values);
        match self {
            Self::Body(posture) => {
                let [own, other] = [i, j].map(|k| posture.geometry()[k]);
                let rows = Matrix3::from_rows(&[
                    RowVector3::new(own.normal.x, own.normal.y, own.b),
                    RowVector3::new(own.tangent.x, own.tangent.y, -own.touching_c()),
                    RowVector3::new(other.normal.x, other.normal.y, other.b),
                ]);
                let found = rows.lu().solve(&values)?;
                Some(found.unsigned_zero().as_slice().to_vec())
            }
            Self::Mechanism(mechanism) => {
                let space = mechanism.contact_space();
                let rows = [space.normal_row(i), space.tangent(i), space.normal_row(j)];
                let rows = rows.map(|row| RowVector3::from_iterator(row.iter()));
                let found = Matrix3::from_rows(&rows).lu().solve(&values)?;
                Some(mechanism.coordinates(&Coordinates::from_iter(found.iter().copied())))
            }
        }
    }
}

/// The first of these starts: contact 1 slides to the right, to the left, contact 2 likewise, both slide.
pub(super) fn no_motion(map: &CornerMap, standing: Standing<'_>) -> Option<NoMotion> {
    let local = map.local();
    for contact in 0..2 {
        for direction in [1.0, -1.0] {
            if local.jams_alone(contact, direction) {
                let apart = above(standing, [0, 1], contact)?;
                let k = local.stiffness(contact, direction).middle();
                return start(standing, &[(contact, direction)], 1 - contact, Some(k), &apart);
            }
        }
    }
    let side = [1.0, -1.0].into_iter().find(|side| map.jams_together(*side))?;
    let directions = [0, 1].map(|i| (i, side * local.alpha[i].middle().signum()));
    start(standing, &directions, 1, None, &[])
}

/// A displacement that opens one contact of a pair by 1 m and keeps the other one, `pair[which]`, in its place.
pub(super) fn above(standing: Standing<'_>, pair: [usize; 2], which: usize) -> Option<Vec<f64>> {
    standing.solve(pair[which], pair[1 - which], [0.0, 0.0, 1.0])
}

/// The start at which these contacts (from 0) slide in these directions, and `other` keeps its gap. `open`: a displacement, per metre, that
/// opens all contacts that do not slide; empty: none.
pub(super) fn start(
    standing: Standing<'_>,
    slides: &[(usize, f64)],
    other: usize,
    stiffness: Option<f64>,
    open: &[f64],
) -> Option<NoMotion> {
    let (first, direction) = slides[0];
    let [size, speed] = standing.units();
    let mode = |way: f64| if way > 0.0 { Mode::Right } else { Mode::Left };
    let directions = slides.iter().enumerate();
    let qdot = standing.solve(first, other, [0.0, direction * SMALL * speed, 0.0])?;
    let lift = |k: usize| open.get(k).map_or(0.0, |part| part * (SMALL * SMALL * size));
    Some(NoMotion {
        contacts: slides.iter().map(|(i, _)| ContactNumber::of(*i)).collect(),
        slides: directions
            .fold(Word::separate(slides.len()), |word, (k, (_, way))| word.with(k, mode(*way))),
        stiffness,
        q: (0..qdot.len()).map(lift).collect::<Vec<f64>>().unsigned_zero(),
        qdot,
        jams: Vec::new(),
    })
}
