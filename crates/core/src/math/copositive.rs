//! Strict copositivity: is xᵀAx > 0 for all x ≥ 0 but x = 0?
//!
//! A definite matrix is strictly copositive. Otherwise let x have the least xᵀAx with x ≥ 0 and Σx = 1, and S be the numbers with x_k > 0. Then A_SS x_S = t 1
//! with t = xᵀAx. Some y ≥ 0 with A_SS y > 0 shows that t > 0, because t Σy = yᵀA_SS x_S > 0. So a y for every S proves that A is
//! strictly copositive; if there is none for one S, A is not, by Gordan's theorem.

use crate::math::interval::Interval;
use crate::math::real::{Enclosed, Ring};
use crate::math::simplex::maximise;

/// Largest number of rows whose sets are all tried.
const MOST_ROWS: usize = 10;

/// Whether a matrix is certainly strictly copositive; only its symmetric part counts.
pub(crate) fn is_strictly_copositive(a: &[Vec<Interval>]) -> bool {
    let n = a.len();
    let half: Vec<Vec<Interval>> =
        (0..n).map(|i| (0..n).map(|j| (a[i][j] + a[j][i]).half()).collect()).collect();
    if (0..n).any(|k| !half[k][k].is_positive()) {
        return false;
    }
    is_definite(&half)
        || n <= MOST_ROWS
            && (1_usize..1 << n).all(|set| {
                let those: Vec<usize> = (0..n).filter(|k| set >> k & 1 == 1).collect();
                has_positive_image(&half, &those)
            })
}

/// Whether a symmetric matrix is certainly positive definite, by Cholesky.
fn is_definite(a: &[Vec<Interval>]) -> bool {
    let mut factor: Vec<Vec<Interval>> = Vec::new();
    for (i, row) in a.iter().enumerate() {
        let mut own: Vec<Interval> = Vec::new();
        for j in 0..=i {
            let before = if j < i { &factor[j] } else { &own };
            let taken = own.iter().zip(before).take(j);
            let left = taken.fold(row[j], |left, (x, y)| left - *x * *y);
            let entry = if j < i {
                left.over(factor[j][j])
            } else {
                left.root().filter(|root| root.is_positive())
            };
            let Some(entry) = entry else { return false };
            own.push(entry);
        }
        factor.push(own);
    }
    true
}

/// Whether some y ≥ 0 certainly has A y > 0, with A of these rows and columns.
fn has_positive_image(a: &[Vec<Interval>], those: &[usize]) -> bool {
    let n = those.len();
    let works = |y: &[f64]| {
        those.iter().all(|i| {
            let terms = those.iter().zip(y);
            terms.fold(Interval::ZERO, |sum, (j, y)| sum + a[*i][*j].times(*y)).is_positive()
        })
    };
    if works(&vec![1.0; n]) {
        return true;
    }
    // The largest t with A y ≥ t and Σy = 1.
    let mut rows: Vec<(Vec<f64>, f64)> = those
        .iter()
        .enumerate()
        .map(|(place, i)| {
            let slacks = (0..n).map(|k| if k == place { -1.0 } else { 0.0 });
            let own = those.iter().map(|j| a[*i][*j].middle());
            (own.chain(slacks).chain([-1.0]).collect(), 0.0)
        })
        .collect();
    rows.push(((0..=2 * n).map(|k| if k < n { 1.0 } else { 0.0 }).collect(), 1.0));
    let mut objective = vec![0.0; 2 * n + 1];
    objective[2 * n] = 1.0;
    maximise(&rows, &objective).is_some_and(|x| works(&x[..n]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: &[&[f64]]) -> bool {
        let all: Vec<Vec<Interval>> =
            rows.iter().map(|row| row.iter().map(|x| Interval::from(*x)).collect()).collect();
        is_strictly_copositive(&all)
    }

    #[test]
    fn matrices_by_hand() {
        assert!(of(&[&[1.0, 5.0], &[3.0, 1.0]])); // not definite
        assert!(!of(&[&[0.0, 1.0], &[1.0, 1.0]]));
        assert!(!of(&[&[1.0, -1.0], &[-1.0, 1.0]])); // copositive, but not strictly
        for margin in [1e-3, 1e-6, 1e-9] {
            assert!(of(&[&[1.0, margin - 1.0], &[margin - 1.0, 1.0]]));
            assert!(!of(&[&[1.0, -margin - 1.0], &[-margin - 1.0, 1.0]]));
        }
        // Horn's matrix is copositive with zeros; it is no sum of a definite matrix and one without negative entries.
        let horn = |more: f64| {
            let entry = |i: usize, j: usize| match (i + 5 - j) % 5 {
                0 => 1.0 + more,
                1 | 4 => -1.0,
                _ => 1.0,
            };
            let rows: Vec<Vec<f64>> =
                (0..5).map(|i| (0..5).map(|j| entry(i, j)).collect()).collect();
            of(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>())
        };
        assert!(horn(1e-6));
        assert!(!horn(0.0));
        assert!(!horn(-1e-6));
    }
}
