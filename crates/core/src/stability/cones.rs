//! The balance of a load by contact forces in their friction cones, as a linear programme.

use crate::body::Mechanism;
use crate::body::fields::ContactRows;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::math::simplex::maximise;

/// An edge of a friction cone: the contact, the force (tangential, normal) and the row.
pub(super) type Edge = (usize, [f64; 2], Coordinates);

/// Edges N ± μT of the friction cones, with all friction times `factor`.
pub(super) fn edges(mechanism: &Mechanism, factor: f64) -> Vec<Edge> {
    let space = mechanism.contact_space();
    let contacts = mechanism.contacts().iter().enumerate();
    contacts
        .flat_map(|(i, ContactRows { friction, .. })| {
            let friction = factor * friction;
            let sides: &[f64] = if friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            sides.iter().map(move |side| (i, [side * friction, 1.0]))
        })
        .map(|(i, [t, n])| (i, [t, n], space.normal_row(i).plus(space.tangent(i), t)))
        .collect()
}

/// As [`edges`], of unit length.
pub(super) fn unit_edges(mechanism: &Mechanism, factor: f64) -> Vec<Edge> {
    let of_length = |(contact, force, row): Edge| {
        let length = row.norm();
        (contact, force.map(|part: f64| part / length), row.divided(length))
    };
    edges(mechanism, factor).into_iter().map(of_length).collect()
}

/// The balance of forces, one row for each coordinate: Σ a_u A_u = −pull, in units of the pull.
pub(super) fn balance(mechanism: &Mechanism, edges: &[Edge]) -> Vec<(Vec<f64>, f64)> {
    let pull = mechanism.contact_space().pull();
    let weight = pull.norm();
    let unit = if weight > 0.0 { weight } else { 1.0 };
    (0..pull.len())
        .zip(pull.iter())
        .map(|(k, load)| {
            let along = |row: &Coordinates| row.iter().nth(k).unwrap_or(0.0);
            (edges.iter().map(|(.., row)| along(row)).collect(), -load / unit)
        })
        .collect()
}

/// The least Σ|A x − b| over all x ≥ 0: how far these rows are from having a solution.
pub(super) fn least_rest(rows: &[(Vec<f64>, f64)]) -> f64 {
    let m = rows.len();
    let n = rows.first().map_or(0, |(row, _)| row.len());
    let with_rest: Vec<(Vec<f64>, f64)> = rows
        .iter()
        .enumerate()
        .map(|(k, (row, b))| {
            let mut all = row.clone();
            all.resize(n + 2 * m, 0.0);
            (all[n + k], all[n + m + k]) = (1.0, -1.0);
            (all, *b)
        })
        .collect();
    let mut objective = vec![0.0; n + 2 * m];
    objective[n..].fill(-1.0);
    maximise(&with_rest, &objective).map_or(0.0, |x| x[n..].iter().sum())
}
