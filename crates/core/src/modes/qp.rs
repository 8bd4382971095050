//! Modes by convex quadratic programmes, with Clarabel.
//!
//! Coulomb's law written as one linear complementarity problem is not convex once μ > 0, and a solver for convex
//! programmes fails on it. De Saxcé's change of variable makes it a fixed point of convex ones: for given s_i ≥ 0 the
//! acceleration y is the point nearest to the load w that satisfies, for every generator γ = N_i + σT_i of a cone,
//!
//! ```text
//! γ·y + bias_n,i + σ bias_t,i + s_i ≥ 0     σ = ±μ_i at rest, −μ_i sliding right, +μ_i sliding left
//! ```
//!
//! the multipliers are the forces along γ, and at a solution s_i = μ_i|a_t,i| at rest, −σ a_t,i where it slides.
//! After each programme the word is read off and solved exactly: only that says whether it is consistent. The method
//! finds a mode; it can never say that there is none, or no other.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::Vector3;

use super::FEW;
use super::answer::ModeAnswer;
use super::enumerate::solve;
use super::problem::ContactProblem;
use super::words::{Mode, Word};
use crate::error::Error;

/// Sliding accelerations, relative to the load, that the search starts from: it may run in circles from one of them
/// and not from the next.
const STARTS: [f64; 3] = [0.0, 1.0, 10.0];
/// Accelerations that vanish in earnest come out of a programme no larger than this, relative to the load.
const BLUR: f64 = 1e-6;
/// Programmes from each start.
const ROUNDS: usize = 20;

/// One generator of a friction cone.
struct Generator {
    contact: usize,
    sigma: f64,
}

/// The first consistent word met, if any.
///
/// # Errors
///
/// [`Error::Solver`] if Clarabel refuses the programme.
pub(super) fn search(problem: &ContactProblem) -> Result<Option<ModeAnswer>, Error> {
    let (rows, load) = (problem.rows(), problem.load());
    let mut generators = Vec::new();
    for (contact, row) in rows.iter().enumerate() {
        let mu = row.friction;
        let sides: &[f64] = match row.sliding {
            None => &[],
            Some(0) if mu == 0.0 => &[0.0],
            Some(0) => &[-1.0, 1.0],
            Some(1) => &[-1.0],
            Some(_) => &[1.0],
        };
        generators.extend(sides.iter().map(|side| Generator { contact, sigma: side * mu }));
    }
    let all_apart = solve(problem, Word::separate(rows.len()));
    if generators.is_empty() || all_apart.consistent {
        return Ok(all_apart.consistent.then_some(all_apart));
    }

    let directions: Vec<Vector3<f64>> = generators
        .iter()
        .map(|g| rows[g.contact].normal + rows[g.contact].tangent * g.sigma)
        .collect();
    let columns: Vec<Vec<f64>> =
        directions.iter().map(|d| (-d).iter().copied().collect()).collect();
    let matrix =
        CscMatrix::from(&columns.iter().map(|row| [row[0], row[1], row[2]]).collect::<Vec<_>>());
    let bound = |shift: &[f64]| -> Vec<f64> {
        generators
            .iter()
            .map(|g| {
                let [tangential, normal] = rows[g.contact].bias;
                normal + g.sigma * tangential + shift[g.contact]
            })
            .collect()
    };
    let settings = DefaultSettings {
        verbose: false,
        presolve_enable: false,
        max_iter: 100,
        ..DefaultSettings::default()
    };
    let mut shift = vec![0.0; rows.len()];
    let mut solver = DefaultSolver::new(
        &CscMatrix::identity(3),
        &[-load.x, -load.y, -load.z],
        &matrix,
        &bound(&shift),
        &[SupportedConeT::NonnegativeConeT(generators.len())],
        settings,
    )
    .map_err(|problem| Error::Solver(problem.to_string()))?;

    let mut tried = Tried { problem, words: Vec::new(), tied: None };
    for start in STARTS {
        for (shift, row) in shift.iter_mut().zip(rows) {
            *shift = start * row.friction;
        }
        for _ in 0..ROUNDS {
            solver
                .update_b(&bound(&shift))
                .map_err(|problem| Error::Solver(problem.to_string()))?;
            solver.solve();
            if !matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved)
            {
                break; // no acceleration meets all bounds
            }
            let y = Vector3::from_column_slice(&solver.solution.x);
            let mut forces = vec![[0.0; 2]; rows.len()];
            for (generator, z) in generators.iter().zip(&solver.solution.z) {
                forces[generator.contact][0] += generator.sigma * z;
                forces[generator.contact][1] += z;
            }
            for blur in [0.0, BLUR] {
                if let Some(answer) = tried.try_out(read(problem, &y, &forces, blur)) {
                    return Ok(Some(answer));
                }
            }
            for (i, row) in rows.iter().enumerate() {
                let along = row.tangent.dot(&y) + row.bias[0];
                shift[i] = match row.sliding {
                    None => 0.0,
                    Some(0) => row.friction * along.abs(),
                    Some(sign) => row.friction * f64::from(sign) * along,
                };
            }
        }
    }
    // A word solved costs far less than a programme: those that differ from one met in a letter, too; of few contacts
    // also in two.
    for _ in 0..if rows.len() <= FEW { 2 } else { 1 } {
        for word in tried.words.clone() {
            for (i, row) in rows.iter().enumerate() {
                for mode in Mode::ALL {
                    let allowed = match (mode, row.sliding) {
                        (_, None) => false,
                        (Mode::Separate, _) | (_, Some(0)) => true,
                        (Mode::Right, Some(sign)) => sign > 0,
                        (Mode::Left, Some(sign)) => sign < 0,
                        _ => false,
                    };
                    if allowed && let Some(answer) = tried.try_out(word.with(i, mode)) {
                        return Ok(Some(answer));
                    }
                }
            }
        }
    }
    Ok(tried.tied)
}

/// Words met so far, none of them consistent.
struct Tried<'a> {
    problem: &'a ContactProblem,
    words: Vec<Word>,
    /// The first one against which only ties stand.
    tied: Option<ModeAnswer>,
}

impl Tried<'_> {
    fn try_out(&mut self, word: Word) -> Option<ModeAnswer> {
        if self.words.contains(&word) {
            return None;
        }
        self.words.push(word);
        let mut answer = solve(self.problem, word);
        if !answer.consistent && self.tied.is_none() && answer.holds_but_for_ties() {
            answer.consistent = true;
            self.tied = Some(answer);
            return None;
        }
        answer.consistent.then_some(answer)
    }
}

/// The word of an approximate solution: of two quantities of which one has to vanish, the smaller is taken to. What
/// vanishes to within `blur` makes a static word.
fn read(problem: &ContactProblem, y: &Vector3<f64>, forces: &[[f64; 2]], blur: f64) -> Word {
    let rows = problem.rows();
    rows.iter().enumerate().fold(Word::separate(rows.len()), |word, (i, row)| {
        let [f_t, f_n] = forces[i];
        let opens = row.normal.dot(y) + row.bias[1];
        if row.sliding.is_none() || opens > f_n.max(blur) {
            return word;
        }
        let along = row.tangent.dot(y) + row.bias[0];
        let mode = match row.sliding {
            Some(0) if along.abs() <= blur.max(row.friction * f_n - f_t.abs()) => Mode::Fixed,
            Some(0) if along > 0.0 => Mode::Right,
            Some(1) => Mode::Right,
            _ => Mode::Left,
        };
        word.with(i, mode)
    })
}
