//! The faces of K = {y : N_i y ≥ 0}, the displacements that contacts allow: which contacts can be closed while all others are open?
//!
//! Let R be the rank of N. In the span of its rows every extreme ray of K closes R − 1 independent contacts, which determine its direction. Every
//! face but the apex is spanned by its rays; the contacts closed on it are those closed on all of them.

use std::collections::BTreeSet;

use crate::body::ContactSpace;
use crate::math::mass_vector::{Coordinates, MassVector, independent};
use crate::math::orthonormal::{complement, dot};
use crate::tolerance::{DEPENDENT_ROW, FIRM_RANK};

/// Largest number of sets of contacts that are tried as those closed on a ray. A tower of six boxes has 12 of them.
const MOST_TRIED: usize = 5000;

/// Contacts, as bits.
pub(super) type Set = u64;

/// Why faces are not known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unknown {
    /// Too many contacts.
    Many,
    /// A gap along a ray may be zero or not.
    Unsure,
}

/// All of these contacts.
pub(super) fn whole(count: usize) -> Set {
    if count >= Set::BITS as usize { Set::MAX } else { (1 << count) - 1 }
}

/// The contacts in a set, in order.
pub(super) fn members(set: Set) -> impl Iterator<Item = usize> {
    (0..Set::BITS as usize).filter(move |i| set >> i & 1 == 1)
}

/// The contacts that are closed on the extreme rays of K, one set for each ray: these are the largest sets of contacts that can stay closed while
/// another one opens.
pub(super) fn rays(space: &ContactSpace) -> Result<BTreeSet<Set>, Unknown> {
    let count = space.count();
    let rows: Vec<&Coordinates> = (0..count).map(|i| space.normal_row(i)).collect();
    let axes = independent(&rows, DEPENDENT_ROW);
    let rank = axes.len();
    // Unit rows, along the axes of their span.
    let unit: Vec<Vec<f64>> = rows
        .iter()
        .map(|row| axes.iter().map(|(_, axis)| axis.dot(row) / row.norm()).collect())
        .collect();
    if independent(&rows, FIRM_RANK).len() < rank {
        return Err(Unknown::Unsure);
    }
    let mut found = BTreeSet::new();
    let mut chosen: Vec<usize> = (0..rank - 1).collect();
    for _ in 0..MOST_TRIED {
        let closed: Vec<Vec<f64>> = chosen.iter().map(|i| unit[*i].clone()).collect();
        if let [along] = &complement(&closed, rank)[..] {
            found.extend(closed_on(&unit, along)?);
        }
        if !next(&mut chosen, count) {
            return Ok(found);
        }
    }
    Err(Unknown::Many)
}

/// The contacts with no gap along a direction, if none of the others enters the ground there, or if all do so.
fn closed_on(unit: &[Vec<f64>], along: &[f64]) -> Result<Option<Set>, Unknown> {
    let (mut closed, mut opens, mut enters) = (0, false, false);
    for (i, row) in unit.iter().enumerate() {
        let gap = dot(row, along);
        if gap.abs() <= DEPENDENT_ROW {
            closed |= 1 << i;
        } else if gap.abs() <= FIRM_RANK {
            return Err(Unknown::Unsure);
        } else {
            *(if gap > 0.0 { &mut opens } else { &mut enters }) = true;
        }
    }
    Ok((opens != enters).then_some(closed))
}

/// The next choice of numbers below `count`, in rising order; false after the last one.
fn next(chosen: &mut [usize], count: usize) -> bool {
    let n = chosen.len();
    let Some(k) = (0..n).rev().find(|&k| chosen[k] < count - n + k) else { return false };
    chosen[k] += 1;
    (k + 1..n).for_each(|l| chosen[l] = chosen[l - 1] + 1);
    true
}

/// The sets of contacts that are closed on the faces of K, the apex among them; `None` if there are more than `most`.
pub(super) fn faces(rays: &BTreeSet<Set>, count: usize, most: usize) -> Option<BTreeSet<Set>> {
    let mut all = rays.clone();
    let mut fresh: Vec<Set> = rays.iter().copied().collect();
    while let Some(face) = fresh.pop() {
        for ray in rays {
            if all.insert(face & ray) {
                fresh.push(face & ray);
            }
        }
        if all.len() > most {
            return None;
        }
    }
    all.insert(whole(count));
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{ContactRows, Mechanism, MechanismFields};

    #[test]
    fn a_beam_on_three_supports_rests_on_the_outer_ones() {
        let support = |b: f64| ContactRows {
            normal: vec![0.0, 1.0, b],
            tangential: vec![1.0, 0.0, 0.0],
            ..ContactRows::default()
        };
        let beam = Mechanism::new(MechanismFields {
            mass_matrix: vec![vec![1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0], vec![0.0, 0.0, 0.3]],
            load: vec![0.0, -9.81, 0.0],
            contacts: vec![support(-1.0), support(0.2), support(1.0)],
            ..MechanismFields::default()
        })
        .unwrap();
        let rays = rays(beam.contact_space()).unwrap();
        assert_eq!(rays.iter().copied().collect::<Vec<_>>(), [0b001, 0b100]);
        let faces = faces(&rays, 3, 10).unwrap();
        assert_eq!(faces.into_iter().collect::<Vec<_>>(), [0, 0b001, 0b100, 0b111]);
    }
}
