//! A linear complementarity problem: z ≥ 0, A z + b ≥ 0 and z·(A z + b) = 0, by the method of Lemke [Cottle, Pang & Stone 1992, section 4.4].
//!
//! An artificial unknown z₀ makes w = A z + z₀ (1, …, 1) + b ≥ 0. Each pivot lets the complement of what left enter; the method ends when z₀ leaves.
//! Of several rows that would leave at once, the lexicographically smallest one does: the method does not go round in circles.

use crate::tolerance::LEMKE_ZERO;

/// Largest number of pivots for each unknown. The method ends in exact arithmetic; with rounding it might not.
const PIVOTS: usize = 50;

/// A solution z; `None` if the method ends in a ray, as where there is no solution. `rows`: of A, with coefficients of order one.
pub(crate) fn complementary(rows: &[Vec<f64>], b: &[f64]) -> Option<Vec<f64>> {
    let n = b.len();
    if b.iter().all(|value| *value >= 0.0) {
        return Some(vec![0.0; n]);
    }
    // Columns: w, z, z₀, right-hand side of w − A z − z₀ = b.
    let (artificial, last) = (2 * n, 2 * n + 1);
    let mut tableau: Vec<Vec<f64>> = rows
        .iter()
        .zip(b)
        .enumerate()
        .map(|(i, (row, b))| {
            let mut all = vec![0.0; n];
            all[i] = 1.0;
            all.extend(row.iter().map(|value| -value));
            all.extend([-1.0, *b]);
            all
        })
        .collect();
    let mut basis: Vec<usize> = (0..n).collect();
    let mut entering = artificial;
    let mut leaving = (0..n).min_by(|&i, &j| b[i].total_cmp(&b[j]))?;
    for _ in 0..PIVOTS * n {
        let left = basis[leaving];
        pivot(&mut tableau, leaving, entering);
        basis[leaving] = entering;
        if left == artificial {
            let mut z = vec![0.0; n];
            for (row, &column) in tableau.iter().zip(&basis) {
                if (n..artificial).contains(&column) {
                    z[column - n] = row[last].max(0.0);
                }
            }
            return Some(z);
        }
        entering = if left < n { left + n } else { left - n };
        leaving = smallest_ratio(&tableau, &basis, entering)?;
    }
    None
}

/// The row that leaves: that of z₀ where it may, else the lexicographically smallest one.
fn smallest_ratio(tableau: &[Vec<f64>], basis: &[usize], entering: usize) -> Option<usize> {
    let n = tableau.len();
    let (artificial, last) = (2 * n, 2 * n + 1);
    let mut rows: Vec<usize> = (0..n).filter(|&i| tableau[i][entering] > LEMKE_ZERO).collect();
    // The right-hand side first, then the columns of w.
    for (step, column) in std::iter::once(last).chain(0..n).enumerate() {
        let ratio = |i: &usize| tableau[*i][column] / tableau[*i][entering];
        let least = rows.iter().map(ratio).min_by(f64::total_cmp)?;
        rows.retain(|i| ratio(i) <= least + LEMKE_ZERO * (1.0 + least.abs()));
        if step == 0
            && let Some(own) = rows.iter().find(|i| basis[**i] == artificial)
        {
            return Some(*own);
        }
        if rows.len() == 1 {
            break;
        }
    }
    rows.first().copied()
}

fn pivot(tableau: &mut [Vec<f64>], row: usize, column: usize) {
    let factor = 1.0 / tableau[row][column];
    tableau[row].iter_mut().for_each(|value| *value *= factor);
    let pivot_row = std::mem::take(&mut tableau[row]);
    for other in tableau.iter_mut().filter(|other| !other.is_empty()) {
        let factor = other[column];
        if factor != 0.0 {
            other.iter_mut().zip(&pivot_row).for_each(|(value, p)| *value -= factor * p);
        }
    }
    tableau[row] = pivot_row;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    #[test]
    fn solutions_are_complementary() {
        let mut random = Random(7);
        for case in 0..500_usize {
            let n = 1 + case % 12;
            // A positive definite matrix has one solution for every b; a rank that is lower gives ties.
            let rank = if case % 3 == 0 { n.div_ceil(2) } else { n };
            let half: Vec<Vec<f64>> =
                (0..n).map(|_| (0..rank).map(|_| random.between(-1.0, 1.0)).collect()).collect();
            let rows: Vec<Vec<f64>> = half
                .iter()
                .map(|a| half.iter().map(|b| a.iter().zip(b).map(|(x, y)| x * y).sum()).collect())
                .collect();
            // In the range of the matrix, less something: then there is a solution.
            let push: Vec<f64> = (0..rank).map(|_| random.between(-1.0, 1.0)).collect();
            let b: Vec<f64> =
                half.iter().map(|a| a.iter().zip(&push).map(|(x, y)| x * y).sum()).collect();
            let z = complementary(&rows, &b).expect("there is a solution");
            for (row, (b, z_i)) in rows.iter().zip(b.iter().zip(&z)) {
                let w = row.iter().zip(&z).map(|(a, z)| a * z).sum::<f64>() + b;
                assert!(*z_i >= 0.0 && w > -1e-10 && (w * z_i).abs() < 1e-9, "{case}: {w} {z_i}");
            }
        }
    }

    #[test]
    fn no_solution_ends_in_a_ray() {
        assert_eq!(complementary(&[vec![-1.0]], &[-1.0]), None);
        assert_eq!(complementary(&[vec![2.0]], &[-1.0]), Some(vec![0.5]));
        assert_eq!(complementary(&[vec![-1.0]], &[1.0]), Some(vec![0.0]));
    }
}
