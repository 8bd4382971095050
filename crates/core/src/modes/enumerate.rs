//! Every consistent mode, by enumeration. This is the reference solver.
//!
//! An acceleration belongs to at most one word, because the signs of its components at the contacts determine each letter.
//! The candidates are therefore not all 4ⁿ words but the cells of the flats of the arrangement of contact rows. A flat is a subspace
//! on which up to three rows vanish, and with them each row that depends on these. Each contact that stays closed on a flat and may
//! slide in both directions divides it in two, and each cell is one word. In the plane this gives O(n³) words; two contacts at rest
//! in general position have ten.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::modes::answer::{Condition, Forces, Margin, ModeAnswer};
use crate::modes::flats::{Flat, Plane, normal, tangent};
use crate::modes::judge::judge;
use crate::modes::problem::{ContactProblem, Row};
use crate::modes::words::{Mode, Word};
use crate::modes::{hyperstatic, pair};
use crate::outcome::ContactNumber;
use crate::tolerance::{DEPENDENT_ROW, FIXED_ACCELERATION};

/// All words that the state of the contacts allows, each solved.
pub(super) fn enumerate(problem: &ContactProblem) -> Vec<ModeAnswer> {
    let rows = problem.rows();
    let mut words = BTreeSet::new();
    let mut still = false;
    let mut visit = |flat: &Flat| {
        // Without bias all flats that are points are equal.
        let is_origin = flat.rank == 3 && flat.point == Vector3::zeros();
        if !(is_origin && still) {
            flat.words(rows, &mut words);
        }
        still |= is_origin;
    };
    let flat = Flat::everything();
    visit(&flat);
    for i in (0..rows.len()).filter(|&i| rows[i].sliding.is_some()) {
        let Some(one) = flat.with(normal(&rows[i])) else { continue };
        visit(&one);
        let fixed = |flat: &Flat, k: usize| {
            (rows[k].sliding == Some(0)).then(|| flat.with(tangent(&rows[k]))).flatten()
        };
        if let Some(two) = fixed(&one, i) {
            visit(&two);
            for j in (0..rows.len()).filter(|&j| j != i && rows[j].sliding.is_some()) {
                if let Some(three) = two.with(normal(&rows[j])) {
                    visit(&three);
                }
                if one.holds(&rows[j])
                    && let Some(three) = fixed(&two, j)
                {
                    visit(&three);
                }
            }
        }
        for j in (i + 1..rows.len()).filter(|&j| rows[j].sliding.is_some()) {
            let Some(two) = one.with(normal(&rows[j])) else { continue };
            visit(&two);
            for k in (0..rows.len()).filter(|&k| rows[k].sliding.is_some()) {
                if k > j
                    && let Some(three) = two.with(normal(&rows[k]))
                {
                    visit(&three);
                }
                if k != i
                    && k != j
                    && two.holds(&rows[k])
                    && let Some(three) = fixed(&two, k)
                {
                    visit(&three);
                }
            }
        }
    }
    words.into_iter().map(|word| solve(problem, word)).collect()
}

/// The equations of a word and the forces that act: one row per unknown force.
struct Equations {
    /// Row and bias that vanish, for each unknown.
    planes: Vec<Plane>,
    /// Direction of the unknown force.
    directions: Vec<Vector3<f64>>,
    /// Contact of the unknown, and whether the unknown is a tangential force independent of the normal force.
    owner: Vec<(usize, bool)>,
}

impl Equations {
    fn of(rows: &[Row], word: Word) -> Self {
        let unknowns = word.modes().map(|mode| match mode {
            Mode::Separate => 0,
            Mode::Fixed => 2,
            Mode::Right | Mode::Left => 1,
        });
        let n = unknowns.sum();
        let mut all = Self {
            planes: Vec::with_capacity(n),
            directions: Vec::with_capacity(n),
            owner: Vec::with_capacity(n),
        };
        for (i, mode) in word.modes().enumerate() {
            if mode == Mode::Separate {
                continue;
            }
            let row = &rows[i];
            all.planes.push(normal(row));
            all.directions.push(row.normal - row.tangent * (mode.direction() * row.friction));
            all.owner.push((i, false));
            if mode == Mode::Fixed {
                all.planes.push(tangent(row));
                all.directions.push(row.tangent);
                all.owner.push((i, true));
            }
        }
        all
    }
}

/// Solves the word in its own system.
pub(super) fn solve(problem: &ContactProblem, word: Word) -> ModeAnswer {
    let (rows, load) = (problem.rows(), problem.load());
    let equations = Equations::of(rows, word);
    let n = equations.planes.len();
    let mut flat = Flat::everything();
    let mut dependent = Vec::new();
    for (plane, owner) in equations.planes.iter().zip(&equations.owner) {
        if let Some(cut) = flat.with(*plane) {
            flat = cut;
        } else {
            dependent.push((*plane, *owner));
        }
    }
    let square = n == flat.rank;
    if square && let Some(unknown) = isostatic(&equations, &load) {
        let (y, forces) = act(rows, &load, &equations, word, &unknown[..n]);
        return judge(problem, word, &y, &forces, Forces::Unique);
    }
    let ties: Vec<Margin> = dependent
        .into_iter()
        .map(|((row, bias), (i, tangential))| Margin {
            contact: ContactNumber::of(i),
            condition: if tangential { Condition::Sticks } else { Condition::Touches },
            value: -(row.dot(&flat.point) + bias).abs(),
        })
        .filter(|margin| margin.value < -FIXED_ACCELERATION)
        .collect();
    let mut answer = match equations.owner[..] {
        [(i, false), (_, true), (j, false), (_, true)]
            if flat.rank == 3 && ties.iter().all(Margin::holds) =>
        {
            pair::both_fixed(problem, word, &flat.point, [i, j])
        }
        _ => hyperstatic::solve(problem, word, &equations.planes, &flat.planes()),
    };
    answer.singular = square; // a regular square system has been solved above
    if answer.determined != Forces::Impossible && !ties.is_empty() {
        answer.margins.extend(ties);
        answer.margins.sort_by_key(|margin| margin.contact);
        answer.consistent = answer.margins.iter().all(Margin::holds);
    }
    answer
}

/// As many unknown forces as independent rows: Gaussian elimination with pivoting; `None` where the friction
/// matrix row_k·direction_l is singular.
fn isostatic(equations: &Equations, load: &Vector3<f64>) -> Option<[f64; 3]> {
    let n = equations.planes.len();
    let mut m = [[0.0; 4]; 3];
    for (k, (row, bias)) in equations.planes.iter().enumerate() {
        for (l, direction) in equations.directions.iter().enumerate() {
            m[k][l] = row.dot(direction);
        }
        m[k][3] = -(row.dot(load) + bias);
    }
    let size = equations.directions.iter().map(|d| d.amax()).fold(1.0, f64::max);
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| m[i][k].abs().total_cmp(&m[j][k].abs()))?;
        if m[pivot][k].abs() <= DEPENDENT_ROW * size {
            return None;
        }
        m.swap(k, pivot);
        for i in k + 1..n {
            let factor = m[i][k] / m[k][k];
            for l in k..4 {
                m[i][l] -= factor * m[k][l];
            }
        }
    }
    let mut x = [0.0; 3];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|l| m[k][l] * x[l]).sum();
        x[k] = (m[k][3] - known) / m[k][k];
    }
    Some(x)
}

/// The acceleration, and the forces by contact, of these unknowns.
fn act(
    rows: &[Row],
    load: &Vector3<f64>,
    equations: &Equations,
    word: Word,
    unknown: &[f64],
) -> (Vector3<f64>, Vec<[f64; 2]>) {
    let mut y = *load;
    let mut forces = vec![[0.0; 2]; rows.len()];
    for ((&(i, tangential), direction), &f) in
        equations.owner.iter().zip(&equations.directions).zip(unknown)
    {
        y += direction * f;
        if tangential {
            forces[i][0] = f;
        } else {
            forces[i][1] = f;
            forces[i][0] = -word.mode(i).direction() * rows[i].friction * f;
        }
    }
    (y, forces)
}
