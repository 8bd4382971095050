//! The point of a polyhedron that is nearest to the origin [Lawson & Hanson 1974, chapter 23].
//!
//! ```text
//! min |z|  subject to  G z ≥ g     ⟸     min |E u − e|  subject to  u ≥ 0,     E = [Gᵀ; gᵀ],  e = (0, …, 0, 1)
//! z = Gᵀu/(1 − g·u)
//! ```
//!
//! The problem on the right is solved by an active set: a row enters where it is violated most, and leaves where its weight would be
//! negative. At the end z is computed again as the nearest point on which all rows with a weight are equations.

use crate::math::orthonormal::{add_scaled, dot, factors, solve_lower, solve_upper};
use crate::tolerance::{CONE_SLACK, DEPENDENT_ROW};

/// Largest number of steps for each row. The method ends in exact arithmetic; with rounding it might not.
const STEPS: usize = 10;

/// The nearest point. `rows`: G; `bounds`: g. Rows of length zero, which no z changes, are left out.
///
/// `None` if no z satisfies all rows, or if rounding prevents convergence.
pub(crate) fn nearest(rows: &[Vec<f64>], bounds: &[f64]) -> Option<Vec<f64>> {
    let dimension = rows.first().map_or(0, Vec::len);
    let (rows, bounds): (Vec<Vec<f64>>, Vec<f64>) = rows
        .iter()
        .zip(bounds)
        .map(|(row, bound)| (row, bound, dot(row, row).sqrt()))
        .filter(|(_, _, length)| *length > DEPENDENT_ROW)
        .map(|(row, bound, length)| (row.iter().map(|x| x / length).collect(), bound / length))
        .unzip();
    // The distance of the farthest plane: |z| is at least as large.
    let scale = bounds.iter().copied().fold(0.0, f64::max);
    if scale == 0.0 {
        return Some(vec![0.0; dimension]);
    }
    let bounds: Vec<f64> = bounds.iter().map(|bound| bound / scale).collect();
    let columns: Vec<Vec<f64>> =
        rows.iter().zip(&bounds).map(|(row, g)| [&row[..], &[*g]].concat()).collect();
    let mut u = vec![0.0; rows.len()];
    let mut active: Vec<usize> = Vec::new();
    let mut z = vec![0.0; dimension];
    for _ in 0..STEPS * rows.len() {
        let violation = |k: usize| bounds[k] - dot(&rows[k], &z);
        let worst = (0..rows.len())
            .filter(|k| !active.contains(k))
            .max_by(|&i, &j| violation(i).total_cmp(&violation(j)));
        let Some(entering) = worst.filter(|&k| violation(k) > CONE_SLACK) else {
            return Some(z.into_iter().map(|x| x * scale).collect());
        };
        if active.len() > dimension {
            return None;
        }
        active.push(entering);
        // Weights on the active rows that leave the least residual; those that would be negative leave.
        loop {
            let solved = least_squares(&active, &columns);
            if solved.iter().any(|weight| !weight.is_finite()) {
                return None;
            }
            let share = |(&k, &s): (&usize, &f64)| (s <= 0.0).then(|| u[k] / (u[k] - s));
            let step = active.iter().zip(&solved).filter_map(share).fold(1.0, f64::min);
            let mut kept = Vec::new();
            for (&k, s) in active.iter().zip(&solved) {
                u[k] += step * (s - u[k]);
                let leaves = *s <= 0.0 && u[k] <= f64::EPSILON * (s.abs() + 1.0);
                if leaves { u[k] = 0.0 } else { kept.push(k) }
            }
            if kept.len() == active.len() {
                break;
            }
            active = kept;
        }
        z = on_all(&active, &rows, &bounds)?;
    }
    None
}

/// The weights x of min |Σ x_k c_k − e| over the active columns c, where e is the last unit vector.
fn least_squares(active: &[usize], columns: &[Vec<f64>]) -> Vec<f64> {
    let chosen: Vec<Vec<f64>> = active.iter().map(|&k| columns[k].clone()).collect();
    let (q, r) = factors(&chosen);
    let last: Vec<f64> = q.iter().map(|axis| axis[axis.len() - 1]).collect();
    solve_upper(&r, &last)
}

/// The nearest point with equality in all active rows; `None` if they depend on each other.
fn on_all(active: &[usize], rows: &[Vec<f64>], bounds: &[f64]) -> Option<Vec<f64>> {
    let chosen: Vec<Vec<f64>> = active.iter().map(|&k| rows[k].clone()).collect();
    let (q, r) = factors(&chosen);
    let mut z = vec![0.0; rows[0].len()];
    let bounds: Vec<f64> = active.iter().map(|&k| bounds[k]).collect();
    q.iter().zip(solve_lower(&r, &bounds)).for_each(|(axis, part)| add_scaled(&mut z, axis, part));
    z.iter().all(|x| x.is_finite()).then_some(z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_points_by_hand() {
        let (half, root) = (0.5_f64.sqrt(), 2.0_f64.sqrt());
        let rows = [vec![1.0, 0.0], vec![0.0, 1.0], vec![half, half]];
        let close = |bounds: [f64; 3], expected: [f64; 2]| {
            let z = nearest(&rows, &bounds).unwrap();
            assert!(z.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-14), "{z:?}");
        };
        close([-1.0, -2.0, 0.0], [0.0, 0.0]);
        close([-1.0, -2.0, root], [1.0, 1.0]);
        close([3.0, -2.0, root], [3.0, 0.0]);
        close([1.5, -2.0, root], [1.5, 0.5]);
        close([2.0, 5.0, 7.0 * half], [2.0, 5.0]);
        assert!(nearest(&[vec![1.0], vec![-1.0]], &[1.0, 1.0]).is_none());
    }
}
