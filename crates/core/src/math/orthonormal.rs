//! Orthonormal bases by the method of Gram and Schmidt, each vector orthogonalised twice: the result is orthogonal to rounding error.

use crate::tolerance::DEPENDENT_ROW;

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Adds `b` times `factor` to `a`.
pub(crate) fn add_scaled(a: &mut [f64], b: &[f64], factor: f64) {
    a.iter_mut().zip(b).for_each(|(x, y)| *x += y * factor);
}

/// Takes the components along these orthonormal vectors away and gives them.
fn reduce(vector: &mut [f64], basis: &[Vec<f64>]) -> Vec<f64> {
    let mut parts = vec![0.0; basis.len()];
    for _ in 0..2 {
        for (axis, sum) in basis.iter().zip(&mut parts) {
            let part = dot(axis, vector);
            add_scaled(vector, axis, -part);
            *sum += part;
        }
    }
    parts
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

fn normalised(mut vector: Vec<f64>) -> Vec<f64> {
    let length = norm(&vector);
    vector.iter_mut().for_each(|x| *x /= length);
    vector
}

/// The factors Q (columns) and R (columns of growing length) of these vectors in their order: v_k = Σ_i R_ik q_i. A vector that depends on
/// those before it gets a last entry of about zero; the vectors must not be more than their dimension.
pub(crate) fn factors(vectors: &[Vec<f64>]) -> (Vec<Vec<f64>>, Vec<Vec<f64>>) {
    let (mut q, mut r) = (Vec::new(), Vec::new());
    for vector in vectors {
        let mut rest = vector.clone();
        let mut column = reduce(&mut rest, &q);
        column.push(norm(&rest));
        q.push(normalised(rest));
        r.push(column);
    }
    (q, r)
}

/// The x of Σ_i R_ik x_i = b_k for the columns R_k of an upper triangle, in the order of k.
pub(crate) fn solve_lower(r: &[Vec<f64>], b: &[f64]) -> Vec<f64> {
    let mut x: Vec<f64> = Vec::new();
    for (column, b) in r.iter().zip(b) {
        x.push((b - dot(&x, column)) / column[x.len()]);
    }
    x
}

/// The x of Σ_k R_ik x_k = b_i.
pub(crate) fn solve_upper(r: &[Vec<f64>], b: &[f64]) -> Vec<f64> {
    let mut x = b.to_vec();
    for (k, column) in r.iter().enumerate().rev() {
        let (above, own) = x.split_at_mut(k);
        own[0] /= column[k];
        add_scaled(above, column, -own[0]);
    }
    x
}

/// An orthonormal basis of these rows of this dimension, in their order; with the numbers of the rows that added to it.
fn spanning(rows: &[Vec<f64>], dimension: usize) -> (Vec<Vec<f64>>, Vec<usize>) {
    let (mut basis, mut numbers): (Vec<Vec<f64>>, Vec<usize>) = (Vec::new(), Vec::new());
    for (k, row) in rows.iter().enumerate() {
        let (length, mut rest) = (norm(row), row.clone());
        reduce(&mut rest, &basis);
        if basis.len() < dimension && norm(&rest) > DEPENDENT_ROW * length {
            basis.push(normalised(rest));
            numbers.push(k);
        }
    }
    (basis, numbers)
}

/// An orthonormal basis of the sums of multiples of these rows.
pub(crate) fn basis(rows: &[Vec<f64>], dimension: usize) -> Vec<Vec<f64>> {
    spanning(rows, dimension).0
}

/// The numbers of the rows that do not depend on those before them.
pub(crate) fn independent(rows: &[Vec<f64>]) -> Vec<usize> {
    spanning(rows, rows.first().map_or(0, Vec::len)).1
}

/// An orthonormal basis of the vectors of this dimension that are orthogonal to all `rows`.
pub(crate) fn complement(rows: &[Vec<f64>], dimension: usize) -> Vec<Vec<f64>> {
    let mut basis = basis(rows, dimension);
    let rank = basis.len();
    // The unit vectors, each reduced by the basis so far; the longest rest gives the next direction.
    while basis.len() < dimension {
        let rest = |axis: usize| {
            let mut unit = vec![0.0; dimension];
            unit[axis] = 1.0;
            reduce(&mut unit, &basis);
            unit
        };
        let longest = (0..dimension).map(rest).max_by(|a, b| norm(a).total_cmp(&norm(b)));
        basis.push(normalised(longest.unwrap_or_default()));
    }
    basis.split_off(rank)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_complement_is_orthonormal() {
        let rows = [vec![1.0, 1.0, 0.0, 2.0], vec![0.0, 1.0, 3.0, 0.0], vec![1.0, 2.0, 3.0, 2.0]];
        let basis = complement(&rows, 4); // the third row is the sum of the others
        assert_eq!(basis.len(), 2);
        for (i, axis) in basis.iter().enumerate() {
            assert!(rows.iter().all(|row| dot(row, axis).abs() < 1e-15));
            for (j, other) in basis.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((dot(axis, other) - expected).abs() < 1e-15);
            }
        }
        assert_eq!(complement(&[], 2), [[0.0, 1.0], [1.0, 0.0]]);
        assert!(complement(&[vec![2.0]], 1).is_empty());
    }
}
