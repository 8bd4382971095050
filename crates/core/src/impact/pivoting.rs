//! One solution of Moreau's law for many contacts, by Lemke's method [Cottle, Pang & Stone 1992, algorithm 4.4.5].
//!
//! With P_t = β⁺ − β⁻ the law is a linear complementarity problem of four unknowns for each contact [Stewart & Trinkle 1996]:
//!
//! ```text
//! 0 ≤ P_n ⊥ ξ_n ≥ 0      0 ≤ β⁺ ⊥ λ + ξ_t ≥ 0      0 ≤ β⁻ ⊥ λ − ξ_t ≥ 0      0 ≤ λ ⊥ μ P_n − β⁺ − β⁻ ≥ 0
//! ```
//!
//! Ties of the ratio test are broken lexicographically, so that the method does not cycle.

use crate::impact::friction::Party;
use crate::tolerance::PIVOT_ZERO;

/// Largest number of pivots for each unknown.
const PIVOTS: usize = 50;

/// Unknowns of a contact: P_n, β⁺, β⁻, λ.
const EACH: usize = 4;

/// Solutions for some covering vectors d of Lemke's method: from one of them the pivots may end in a ray.
pub(super) fn solutions(parties: &[Party], w: &[f64]) -> impl Iterator<Item = Vec<[f64; 2]>> {
    // All ones; then multiples of the golden ratio, which lie apart from each other.
    let covers = [0.0, 0.618_033_988_749_895, 0.381_966_011_250_105, 0.854_101_966_249_684];
    covers.into_iter().filter_map(|step| solution(parties, w, |i| 1.0 + (step * i as f64).fract()))
}

/// Impulses (tangential, normal), with the rounding errors of the pivots; `w`: the impact matrix, row by row.
fn solution(parties: &[Party], w: &[f64], cover: impl Fn(usize) -> f64) -> Option<Vec<[f64; 2]>> {
    let (count, n) = (parties.len(), EACH * parties.len());
    let speed = parties.iter().flat_map(Party::needs).fold(0.0_f64, |most, u| most.max(u.abs()));
    if speed == 0.0 {
        return Some(vec![[0.0; 2]; count]);
    }
    // Impulses in the unit in which each normal row has the length one.
    let length = |i: usize| w[(2 * i + 1) * 2 * count + 2 * i + 1].sqrt();
    let w = |k: usize, l: usize| w[k * 2 * count + l] / (length(k / 2) * length(l / 2));
    // w − M z − d z₀ = q, with the columns w, z, z₀, q.
    let width = 2 * n + 2;
    let mut tableau = vec![vec![0.0; width]; n];
    for (i, party) in parties.iter().enumerate() {
        let [t, normal] = party.needs().map(|u| u / (speed * length(i)));
        let signs = [0.0, 1.0, -1.0];
        for (part, right) in [normal, t, -t, 0.0].into_iter().enumerate() {
            let row = &mut tableau[EACH * i + part];
            row[EACH * i + part] = 1.0;
            (row[2 * n], row[2 * n + 1]) = (-cover(EACH * i + part), right);
            if part == 3 {
                row[n + EACH * i] = -party.material.friction;
                (row[n + EACH * i + 1], row[n + EACH * i + 2]) = (1.0, 1.0);
                continue;
            }
            // ξ_n or ±ξ_t by the impulses of all contacts.
            let (equation, side) = if part == 0 { (2 * i + 1, 1.0) } else { (2 * i, signs[part]) };
            for j in 0..count {
                let column = n + EACH * j;
                row[column] = -side * w(equation, 2 * j + 1);
                row[column + 1] = -side * w(equation, 2 * j);
                row[column + 2] = side * w(equation, 2 * j);
            }
            if part > 0 {
                row[n + EACH * i + 3] = -1.0;
            }
        }
    }
    let mut basis: Vec<usize> = (0..n).collect();
    let needs = |i: usize| tableau[i][width - 1] / -tableau[i][2 * n];
    let first = (0..n).min_by(|&a, &b| needs(a).total_cmp(&needs(b)))?;
    let mut entering = 2 * n;
    let mut leaving = first;
    if tableau[first][width - 1] < 0.0 {
        for _ in 0..PIVOTS * n {
            let left = pivot(&mut tableau, &mut basis, leaving, entering);
            if left == 2 * n {
                break;
            }
            entering = if left < n { left + n } else { left - n };
            leaving = ratio_test(&tableau, &basis, entering, n)?;
        }
        if basis.contains(&(2 * n)) {
            return None;
        }
    }
    let mut z = vec![0.0; n];
    for (row, &column) in tableau.iter().zip(&basis) {
        if (n..2 * n).contains(&column) {
            z[column - n] = row[width - 1].max(0.0);
        }
    }
    let of = |i: usize| {
        let [normal, right, left] = [0, 1, 2].map(|part| z[EACH * i + part]);
        [right - left, normal].map(|p| p * speed / length(i))
    };
    Some((0..count).map(of).collect())
}

/// Brings the column into the basis in this row; returns the column that leaves.
fn pivot(tableau: &mut [Vec<f64>], basis: &mut [usize], row: usize, column: usize) -> usize {
    let divisor = tableau[row][column];
    tableau[row].iter_mut().for_each(|entry| *entry /= divisor);
    let taken = tableau[row].clone();
    for (i, other) in tableau.iter_mut().enumerate() {
        let factor = other[column];
        if i != row && factor != 0.0 {
            other.iter_mut().zip(&taken).for_each(|(entry, part)| *entry -= factor * part);
        }
    }
    std::mem::replace(&mut basis[row], column)
}

/// The row that leaves when this column enters: the lexicographically smallest ratio; z₀ leaves as soon as it may.
fn ratio_test(tableau: &[Vec<f64>], basis: &[usize], column: usize, n: usize) -> Option<usize> {
    let last = 2 * n + 1;
    let eligible = (0..tableau.len()).filter(|&i| tableau[i][column] > PIVOT_ZERO);
    let ratio = |i: usize| tableau[i][last] / tableau[i][column];
    let least = eligible.clone().map(ratio).fold(f64::INFINITY, f64::min);
    let tied = |i: &usize| ratio(*i) <= least + PIVOT_ZERO;
    if let Some(out) = eligible.clone().filter(tied).find(|&i| basis[i] == 2 * n) {
        return Some(out);
    }
    eligible.filter(tied).min_by(|&a, &b| {
        let of = |i: usize, k: usize| tableau[i][k] / tableau[i][column];
        let differs = (0..n).map(|k| of(a, k) - of(b, k)).find(|d| d.abs() > PIVOT_ZERO);
        differs.unwrap_or(0.0).total_cmp(&0.0)
    })
}
