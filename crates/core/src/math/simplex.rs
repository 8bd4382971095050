//! A linear programme of a few rows: max c·x subject to A x = b, x ≥ 0, by the simplex method on a dense tableau.
//!
//! The first column that improves the objective enters, as in Bland's rule, and the same programme gives the same bits.

use crate::tolerance::SIMPLEX_ZERO;

/// Largest number of pivots for each column. Bland's rule ends in exact arithmetic; with rounding it might not.
const PIVOTS: usize = 100;

/// The solution of the programme with these rows (a, b).
///
/// `None` if no x satisfies the rows, if the objective has no bound, or if rounding prevents convergence.
pub(crate) fn maximise(rows: &[(Vec<f64>, f64)], objective: &[f64]) -> Option<Vec<f64>> {
    Polyhedron::of(rows, objective.len())?.maximise(objective)
}

/// The x ≥ 0 with A x = b, at one of its vertices.
pub(crate) struct Polyhedron {
    /// One row for each x_j of the basis; the right-hand side last.
    tableau: Vec<Vec<f64>>,
    basis: Vec<usize>,
    count: usize,
}

impl Polyhedron {
    /// The polyhedron of these rows (a, b) in `count` unknowns; `None` if it is empty, or if rounding prevents convergence.
    pub(crate) fn of(rows: &[(Vec<f64>, f64)], count: usize) -> Option<Self> {
        let (m, n) = (rows.len(), count);
        // Columns: x, one artificial variable per row, right-hand side.
        let width = n + m + 1;
        let mut tableau: Vec<Vec<f64>> = rows
            .iter()
            .enumerate()
            .map(|(i, (a, b))| {
                let sign = if *b < 0.0 { -1.0 } else { 1.0 };
                let mut row: Vec<f64> = a.iter().map(|value| sign * value).collect();
                row.resize(width, 0.0);
                row[n + i] = 1.0;
                row[width - 1] = sign * b;
                row
            })
            .collect();
        let mut basis: Vec<usize> = (n..n + m).collect();
        let mut cost = vec![0.0; width];
        cost[n..n + m].fill(-1.0);
        climb(&mut tableau, &mut basis, &cost, n + m)?;
        let missed: f64 = (0..m).filter(|&i| basis[i] >= n).map(|i| tableau[i][width - 1]).sum();
        if missed > SIMPLEX_ZERO * width as f64 {
            return None;
        }
        for i in 0..m {
            if basis[i] >= n
                && let Some(column) = (0..n).find(|&j| tableau[i][j].abs() > SIMPLEX_ZERO)
            {
                pivot(&mut tableau, &mut basis, i, column);
            }
        }
        // Without the artificial variables, and the rows that depend on others.
        let rows = tableau.into_iter().zip(&basis).filter(|(_, column)| **column < n);
        let tableau = rows
            .map(|(mut row, _)| {
                row[n] = row[width - 1];
                row.truncate(n + 1);
                row
            })
            .collect();
        basis.retain(|column| *column < n);
        Some(Self { tableau, basis, count })
    }

    /// The vertex with the largest objective, from the vertex that was found last; `None` if there is no bound, or if rounding prevents
    /// convergence.
    pub(crate) fn maximise(&mut self, objective: &[f64]) -> Option<Vec<f64>> {
        let n = self.count;
        let mut cost = objective.to_vec();
        cost.push(0.0);
        climb(&mut self.tableau, &mut self.basis, &cost, n)?;
        let mut x = vec![0.0; n];
        for (row, &column) in self.tableau.iter().zip(&self.basis) {
            // Rounding may leave a right-hand side just below zero.
            x[column] = row[n].max(0.0);
        }
        Some(x)
    }
}

/// Pivots until no column below `columns` improves the objective; `None` if it has no bound.
fn climb(
    tableau: &mut [Vec<f64>],
    basis: &mut [usize],
    cost: &[f64],
    columns: usize,
) -> Option<()> {
    let mut inside = vec![false; cost.len()];
    basis.iter().for_each(|&b| inside[b] = true);
    for _ in 0..PIVOTS * cost.len() {
        // Most of the basis costs nothing.
        let costly: Vec<usize> = (0..basis.len()).filter(|&i| cost[basis[i]] != 0.0).collect();
        let paid = |j: usize| costly.iter().map(|&i| cost[basis[i]] * tableau[i][j]).sum::<f64>();
        let improves = |j: &usize| !inside[*j] && cost[*j] - paid(*j) > SIMPLEX_ZERO;
        let Some(column) = (0..columns).find(improves) else { return Some(()) };
        let leaving = leaving(tableau, basis, column)?;
        inside[basis[leaving]] = false;
        inside[column] = true;
        pivot(tableau, basis, leaving, column);
    }
    None
}

/// The row with the smallest ratio. Of rows whose ratios differ by rounding the one with the largest entry leaves: small entries spoil the
/// tableau. `None` if no entry is positive.
fn leaving(tableau: &[Vec<f64>], basis: &[usize], column: usize) -> Option<usize> {
    let last = tableau.first()?.len() - 1;
    let positive = || (0..tableau.len()).filter(|&i| tableau[i][column] > SIMPLEX_ZERO);
    let ratio = |i: usize| tableau[i][last] / tableau[i][column];
    // A right-hand side may be off by a rounding error: this bounds each ratio.
    let most = positive()
        .map(|i| (tableau[i][last].max(0.0) + SIMPLEX_ZERO) / tableau[i][column])
        .min_by(f64::total_cmp)?;
    positive().filter(|&i| ratio(i) <= most).max_by(|&i, &j| {
        tableau[i][column].total_cmp(&tableau[j][column]).then(basis[j].cmp(&basis[i]))
    })
}

fn pivot(tableau: &mut [Vec<f64>], basis: &mut [usize], row: usize, column: usize) {
    let factor = 1.0 / tableau[row][column];
    tableau[row].iter_mut().for_each(|value| *value *= factor);
    let pivot_row = tableau[row].clone();
    for (i, other) in tableau.iter_mut().enumerate() {
        let factor = other[column];
        if i != row && factor != 0.0 {
            other.iter_mut().zip(&pivot_row).for_each(|(value, p)| *value -= factor * p);
        }
    }
    basis[row] = column;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_programme_by_hand() {
        // max 3x + 2y, x + y + s = 4, x + 3y + t = 6, x + u = 3: at (3, 1).
        let rows = vec![
            (vec![1.0, 1.0, 1.0, 0.0, 0.0], 4.0),
            (vec![1.0, 3.0, 0.0, 1.0, 0.0], 6.0),
            (vec![1.0, 0.0, 0.0, 0.0, 1.0], 3.0),
        ];
        let x = maximise(&rows, &[3.0, 2.0, 0.0, 0.0, 0.0]).unwrap();
        assert_eq!(&x[..2], &[3.0, 1.0]);
        assert!(maximise(&[(vec![1.0, 1.0], -1.0)], &[1.0, 0.0]).is_none()); // infeasible
        assert!(maximise(&[(vec![1.0, -1.0], 1.0)], &[1.0, 0.0]).is_none()); // unbounded
        // A row twice over.
        let twice = vec![(vec![1.0, 1.0], 1.0), (vec![2.0, 2.0], 2.0)];
        assert_eq!(maximise(&twice, &[0.0, 1.0]).unwrap(), [0.0, 1.0]);
    }
}
