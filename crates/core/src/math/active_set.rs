//! Least squares under constraints: min |C x − d|² subject to A x = b and x ≥ 0, from an x that satisfies them, by an active set.
//!
//! The x_j of a *free* set change; the others are zero. A step goes to the least square of the free set, or as far as x ≥ 0 allows: the x_j that
//! stops it leaves the set. At the least square of the set, Aᵀλ = Cᵀ(C x − d) in its columns; another x_j with (Cᵀ(C x − d) − Aᵀλ)_j < 0 enters.
//! The first of several enters or leaves, as in Bland's rule for linear programmes: steps without length do not go round in circles. The
//! columns of A of the free set keep the rank of A, because a step p with A p = 0 and p_j ≠ 0 shows that column j depends on the others.

use crate::math::orthonormal::{add_scaled, basis, complement, dot, factors, independent};
use crate::math::orthonormal::{solve_lower, solve_upper};
use crate::tolerance::{REDUCED_GRADIENT, SIMPLEX_ZERO, SQUARE_ROUNDING};

/// Largest number of steps for each x_j. The method ends in exact arithmetic; with rounding it might not.
const STEPS: usize = 20;

/// A row of A or C, and its entry of b or d.
pub(crate) type Row = (Vec<f64>, f64);

/// Which x are allowed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sign {
    Any,
    NotNegative,
}

/// The x with the least square; one of them if there are several. `rows`: of (A, b); `squares`: of (C, d); `start` satisfies the constraints.
pub(crate) fn least_square(rows: &[Row], squares: &[Row], start: &[f64], sign: Sign) -> Vec<f64> {
    let all: Vec<Vec<f64>> = rows.iter().map(|(row, _)| row.clone()).collect();
    let rows: Vec<&Row> = independent(&all).into_iter().map(|k| &rows[k]).collect();
    let mut x = start.to_vec();
    let mut free = free_columns(&rows, &x, sign);
    let bounded = sign == Sign::NotNegative;
    for _ in 0..STEPS * x.len() {
        let step = towards_least(&rows, squares, &free, &x);
        let largest = step.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
        let limit = |(&j, p): (&usize, &f64)| {
            if bounded && *p < -SIMPLEX_ZERO * largest { x[j] / -p } else { f64::INFINITY }
        };
        let limits: Vec<f64> = free.iter().zip(&step).map(limit).collect();
        let length = limits.iter().copied().fold(1.0, f64::min);
        for (&j, p) in free.iter().zip(&step) {
            x[j] += length * p;
            if bounded {
                x[j] = x[j].max(0.0);
            }
        }
        if length < 1.0 {
            let leaving = limits.iter().position(|limit| *limit <= length).unwrap_or_default();
            x[free.remove(leaving)] = 0.0;
        } else if let Some(entering) = entering(&rows, squares, &free, &x) {
            free.insert(free.partition_point(|j| *j < entering), entering);
        } else {
            break;
        }
    }
    // The rounding errors of all steps in A x = b.
    let part = columns(&rows, &free);
    let (q, r) = factors(&part);
    let missing: Vec<f64> = rows.iter().map(|(row, b)| b - dot(row, &x)).collect();
    for (axis, along) in q.iter().zip(solve_lower(&r, &missing)) {
        free.iter().zip(axis).for_each(|(&j, value)| x[j] += along * value);
    }
    if bounded {
        x.iter_mut().for_each(|value| *value = value.max(0.0));
    }
    x
}

/// The columns that are not zero, in order, with others that complete their rank.
fn free_columns(rows: &[&Row], x: &[f64], sign: Sign) -> Vec<usize> {
    let all = 0..x.len();
    if sign == Sign::Any {
        return all.collect();
    }
    let (mut free, zero): (Vec<usize>, Vec<usize>) = all.partition(|&j| x[j] > 0.0);
    let order = [&free[..], &zero[..]].concat();
    let column = |j: &usize| rows.iter().map(|(row, _)| row[*j]).collect();
    let spanning = independent(&order.iter().map(column).collect::<Vec<_>>());
    free.extend(spanning.into_iter().map(|k| order[k]).filter(|j| zero.contains(j)));
    free.sort_unstable();
    free
}

/// The rows of A in these columns.
fn columns(rows: &[&Row], free: &[usize]) -> Vec<Vec<f64>> {
    rows.iter().map(|(row, _)| free.iter().map(|&j| row[j]).collect()).collect()
}

/// The size of the terms of C x − d in each row.
fn sizes<'a>(squares: &'a [Row], x: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    let terms = move |row: &[f64]| row.iter().zip(x).map(|(c, x)| (c * x).abs()).sum::<f64>();
    squares.iter().map(move |(row, d)| terms(row) + d.abs())
}

/// The step of the free x_j, with A p = 0, to their least square.
fn towards_least(rows: &[&Row], squares: &[Row], free: &[usize], x: &[f64]) -> Vec<f64> {
    let moves = complement(&columns(rows, free), free.len());
    // C in these moves; the moves that change no square are left out.
    let felt: Vec<Vec<f64>> = squares
        .iter()
        .map(|(row, _)| {
            let own: Vec<f64> = free.iter().map(|&j| row[j]).collect();
            let noise = SIMPLEX_ZERO * dot(&own, &own).sqrt();
            let parts = moves.iter().map(|axis| dot(&own, axis));
            parts.map(|part| if part.abs() > noise { part } else { 0.0 }).collect()
        })
        .collect();
    let mut graded = felt.clone();
    graded.sort_by(|a, b| dot(b, b).total_cmp(&dot(a, a)));
    let axes = basis(&graded, moves.len());
    let changes: Vec<Vec<f64>> =
        axes.iter().map(|axis| felt.iter().map(|row| dot(row, axis)).collect()).collect();
    let (q, r) = factors(&changes);
    let rest: Vec<f64> = squares.iter().map(|(row, d)| d - dot(row, x)).collect();
    let noise = SQUARE_ROUNDING * sizes(squares, x).map(|s| s * s).sum::<f64>().sqrt();
    let along = |axis: &Vec<f64>| {
        let part = dot(axis, &rest);
        if part.abs() > noise { part } else { 0.0 }
    };
    let parts = solve_upper(&r, &q.iter().map(along).collect::<Vec<_>>());
    let mut step = vec![0.0; free.len()];
    for (axis, part) in axes.iter().zip(&parts) {
        for (own, direction) in axis.iter().zip(&moves) {
            add_scaled(&mut step, direction, own * part);
        }
    }
    step
}

/// The first x_j outside of the free set which, increased, makes the square less.
fn entering(rows: &[&Row], squares: &[Row], free: &[usize], x: &[f64]) -> Option<usize> {
    let rest: Vec<f64> = squares.iter().map(|(row, d)| dot(row, x) - d).collect();
    let sizes: Vec<f64> = sizes(squares, x).collect();
    let gradient =
        |j: usize| squares.iter().zip(&rest).map(|((row, _), r)| row[j] * r).sum::<f64>();
    let (q, r) = factors(&columns(rows, free));
    let own: Vec<f64> = free.iter().map(|&j| gradient(j)).collect();
    let parts: Vec<f64> = q.iter().map(|axis| dot(axis, &own)).collect();
    let lambda = solve_upper(&r, &parts);
    (0..x.len()).filter(|j| free.binary_search(j).is_err()).find(|&j| {
        let held = rows.iter().zip(&lambda).map(|((row, _), l)| row[j] * l);
        let (sum, held_size) = held.fold((0.0, 0.0), |(s, size), t: f64| (s + t, size + t.abs()));
        let size = squares.iter().zip(&sizes).map(|((row, _), s)| row[j].abs() * s).sum::<f64>();
        gradient(j) - sum < -REDUCED_GRADIENT * (size + held_size)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn least(rows: &[Row], squares: &[Row], start: &[f64]) -> Vec<f64> {
        least_square(rows, squares, start, Sign::NotNegative)
    }

    #[test]
    fn least_squares_by_hand() {
        // |x|² with x₁ + x₂ = 1, with and without x₁ + x₃ = 1.
        let one = (vec![1.0, 1.0, 0.0], 1.0);
        let other = (vec![1.0, 0.0, 1.0], 1.0);
        let squares: Vec<Row> = (0..3)
            .map(|k| (0..3).map(|j| if j == k { 1.0 } else { 0.0 }).collect())
            .map(|row| (row, 0.0))
            .collect();
        let close = |x: Vec<f64>, expected: [f64; 3]| {
            assert!(x.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-15), "{x:?}");
        };
        close(least(std::slice::from_ref(&one), &squares, &[1.0, 0.0, 0.0]), [0.5, 0.5, 0.0]);
        let both = [one, other];
        close(least(&both, &squares, &[1.0, 0.0, 0.0]), [2.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0]);
        // (x₁ + 1)² + (x₂ − 3)² with x₁ + x₂ − x₃ = 1: at (0, 3, 2); of any sign at (−1, 3, 1).
        let row = [(vec![1.0, 1.0, -1.0], 1.0)];
        let squares = [(vec![1.0, 0.0, 0.0], -1.0), (vec![0.0, 1.0, 0.0], 3.0)];
        close(least(&row, &squares, &[1.0, 0.0, 0.0]), [0.0, 3.0, 2.0]);
        close(least_square(&row, &squares, &[1.0, 0.0, 0.0], Sign::Any), [-1.0, 3.0, 1.0]);
    }

    #[test]
    fn a_step_without_length_goes_on() {
        // x₁ = x₂ + x₃ and x₁ + x₂ = x₄, from zero: nothing stops (x₁ − 1)² + (x₃ − 1)².
        let rows = [(vec![1.0, -1.0, -1.0, 0.0], 0.0), (vec![1.0, 1.0, 0.0, -1.0], 0.0)];
        let squares = [(vec![1.0, 0.0, 0.0, 0.0], 1.0), (vec![0.0, 0.0, 1.0, 0.0], 1.0)];
        let x = least(&rows, &squares, &[0.0; 4]);
        assert!(x.iter().zip([1.0, 0.0, 1.0, 1.0]).all(|(x, y)| (x - y).abs() < 1e-15), "{x:?}");
    }
}
