//! Strict copositivity: is xᵀAx > 0 for all x ≥ 0 but x = 0?
//!
//! The simplex of all x ≥ 0 with Σx = 1 is divided into smaller ones [Bundfuss & Dür 2008]. On a simplex with corners v_k, x = Σ w_k v_k with w ≥ 0, so that
//! v_kᵀAv_l > 0 for all k and l decides for it. A corner with vᵀAv ≤ 0 decides against A. Otherwise the edge with the least product is halved;
//! corners are sums of powers of two, without rounding errors.

use crate::math::interval::Interval;
use crate::math::real::{Enclosed, Ring};

/// Largest number of simplices that are looked at: a margin of 1e-9 of four rows takes some hundred.
const SIMPLICES: usize = 4000;

/// Largest number of halvings of one edge, so that corners have no rounding errors.
const HALVINGS: u32 = 48;

/// Whether a matrix is strictly copositive; only its symmetric part counts. `None`: not decided.
pub(crate) fn is_strictly_copositive(a: &[Vec<Interval>]) -> Option<bool> {
    let n = a.len();
    let half: Vec<Vec<Interval>> =
        (0..n).map(|i| (0..n).map(|j| (a[i][j] + a[j][i]).half()).collect()).collect();
    let unit = |k: usize| (0..n).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
    let mut open = vec![((0..n).map(unit).collect::<Vec<_>>(), 0)];
    for _ in 0..SIMPLICES {
        let Some((corners, depth)) = open.pop() else { return Some(true) };
        let images: Vec<Vec<Interval>> =
            corners.iter().map(|v| half.iter().map(|row| weighed(row, v)).collect()).collect();
        let product = |k: usize, l: usize| weighed(&images[k], &corners[l]);
        let corner = |k: usize| product(k, k);
        if (0..n).any(|k| corner(k).hi <= 0.0) {
            return Some(false);
        }
        if (0..n).any(|k| !corner(k).is_positive()) {
            return None;
        }
        let edges = (0..n).flat_map(|k| (k + 1..n).map(move |l| (k, l)));
        let least = edges
            .map(|(k, l)| (product(k, l).lo, k, l))
            .filter(|(least, ..)| *least <= 0.0)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, k, l)) = least else { continue };
        if depth == HALVINGS {
            return None;
        }
        let middle: Vec<f64> =
            corners[k].iter().zip(&corners[l]).map(|(x, y)| 0.5 * (x + y)).collect();
        for side in [k, l] {
            let mut part = corners.clone();
            part[side].clone_from(&middle);
            open.push((part, depth + 1));
        }
    }
    None
}

fn weighed(row: &[Interval], weights: &[f64]) -> Interval {
    row.iter().zip(weights).fold(Interval::ZERO, |sum, (x, w)| sum + x.times(*w))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(rows: &[&[f64]]) -> Option<bool> {
        let all: Vec<Vec<Interval>> =
            rows.iter().map(|row| row.iter().map(|x| Interval::from(*x)).collect()).collect();
        is_strictly_copositive(&all)
    }

    #[test]
    fn matrices_by_hand() {
        assert_eq!(of(&[&[1.0, 5.0], &[3.0, 1.0]]), Some(true)); // not definite
        assert_eq!(of(&[&[0.0, 1.0], &[1.0, 1.0]]), Some(false)); // a corner
        // (x − y)² is copositive, but not strictly.
        assert_ne!(of(&[&[1.0, -1.0], &[-1.0, 1.0]]), Some(true));
        for margin in [1e-3, 1e-6, 1e-9] {
            assert_eq!(of(&[&[1.0, margin - 1.0], &[margin - 1.0, 1.0]]), Some(true));
            assert_eq!(of(&[&[1.0, -margin - 1.0], &[-margin - 1.0, 1.0]]), Some(false));
        }
        // Horn's matrix is copositive with zeros; it is no sum of a definite matrix and one without negative entries.
        let horn = |more: f64| {
            let sign = |i: usize, j: usize| match (i + 5 - j) % 5 {
                0 => 1.0 + more,
                1 | 4 => -1.0,
                _ => 1.0,
            };
            let rows: Vec<Vec<f64>> =
                (0..5).map(|i| (0..5).map(|j| sign(i, j)).collect()).collect();
            of(&rows.iter().map(Vec::as_slice).collect::<Vec<_>>())
        };
        assert_eq!(horn(1e-2), Some(true));
        assert_ne!(horn(0.0), Some(true));
        assert_eq!(horn(-1e-2), Some(false));
    }
}
