//! A linear programme with few entries in each row: max c·x subject to a·x = b, x ≥ 0; by the simplex method, with many rows by Clarabel.

use crate::math::Sparse;
use crate::math::simplex::{Polyhedron, maximise as by_pivots};
use crate::tolerance::UNBOUNDED_DIRECTION;

/// Largest number of rows of a dense tableau, which gives vertices to rounding. Clarabel is faster from some hundred rows on, to a lesser accuracy.
#[cfg(feature = "qp")]
const DENSE: usize = 130;

/// Why there is no solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Failure {
    /// No x satisfies the rows.
    Empty,
    /// The objective has no bound.
    Unbounded,
    /// The solver does not converge.
    Stuck,
}

/// The solution of the programme with these rows (a, b), or why there is none.
pub(crate) fn maximise(rows: &[(Sparse, f64)], objective: &[f64]) -> Result<Vec<f64>, Failure> {
    #[cfg(feature = "qp")]
    if rows.len() > DENSE {
        return interior(rows, objective);
    }
    let dense = |share: f64| -> Vec<(Vec<f64>, f64)> {
        let whole = |(entries, bound): &(Sparse, f64)| {
            let mut row = vec![0.0; objective.len()];
            entries.iter().for_each(|(column, value)| row[*column] += value);
            (row, share * bound)
        };
        rows.iter().map(whole).collect()
    };
    let mut points = Polyhedron::of(&dense(1.0), objective.len()).ok_or(Failure::Empty)?;
    if let Some(found) = points.maximise(objective) {
        return Ok(found);
    }
    let mut directions = dense(0.0);
    directions.push((vec![1.0; objective.len()], 1.0));
    let gain = |x: Vec<f64>| x.iter().zip(objective).map(|(x, c)| x * c).sum::<f64>();
    let rises = by_pivots(&directions, objective).is_some_and(|x| gain(x) > UNBOUNDED_DIRECTION);
    Err(if rises { Failure::Unbounded } else { Failure::Stuck })
}

#[cfg(feature = "qp")]
fn interior(rows: &[(Sparse, f64)], objective: &[f64]) -> Result<Vec<f64>, Failure> {
    use crate::math::sparse::{Programme, Status};
    use crate::tolerance::SPARSE_FINEST;

    let programme = Programme {
        squares: vec![0.0; objective.len()],
        costs: objective.iter().map(|value| -value).collect(),
        equal: rows.to_vec(),
        above: (0..objective.len()).map(|k| (vec![(k, 1.0)], 0.0)).collect(),
        accuracy: SPARSE_FINEST,
    };
    let solution = programme.minimise().ok_or(Failure::Stuck)?;
    match solution.status {
        Status::Converged => Ok(solution.x.iter().map(|value| value.max(0.0)).collect()),
        Status::Empty => Err(Failure::Empty),
        Status::Unbounded => Err(Failure::Unbounded),
        Status::Stuck => Err(Failure::Stuck),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounded_empty_and_unbounded_programmes() {
        let row = |a: f64, b: f64, right: f64| (vec![(0, a), (1, b)], right);
        assert_eq!(maximise(&[row(1.0, 1.0, 1.0)], &[1.0, 0.0]), Ok(vec![1.0, 0.0]));
        assert_eq!(maximise(&[row(1.0, 1.0, -1.0)], &[1.0, 0.0]), Err(Failure::Empty));
        assert_eq!(maximise(&[row(1.0, -1.0, 1.0)], &[1.0, 0.0]), Err(Failure::Unbounded));
    }

    /// Σ of pairs x_k + x_{k+1} = 1 over a long chain: the ends decide.
    #[cfg(feature = "qp")]
    #[test]
    fn a_long_chain_is_solved_alike() {
        let n = DENSE + 71;
        let mut rows: Vec<(Sparse, f64)> =
            (0..n).map(|k| (vec![(k, 1.0), (k + 1, 1.0)], 1.0)).collect();
        let mut objective = vec![0.0; n + 1];
        objective[0] = 1.0;
        let x = maximise(&rows, &objective).unwrap();
        assert!(x.iter().enumerate().all(|(k, x)| (x - f64::from(k % 2 == 0)).abs() < 1e-9));
        rows.push((vec![(0, 1.0)], 2.0));
        assert_eq!(maximise(&rows, &objective), Err(Failure::Empty));
    }
}
