//! Modes by convex quadratic programmes, with Clarabel.
//!
//! Coulomb's law written as one linear complementarity problem is not convex once μ > 0, and a solver for convex programmes fails on it
//! (`tests/mode_qp.rs` measures how often). De Saxcé's change of variable turns the law into a fixed point of convex programmes: for given
//! s_i ≥ 0 the acceleration y is the point nearest to the load w that satisfies, for every generator γ = N_i + σT_i of a cone,
//!
//! ```text
//! γ·y + bias_n,i + σ bias_t,i + s_i ≥ 0     σ = ±μ_i at rest, −μ_i sliding right, +μ_i sliding left
//! ```
//!
//! the multipliers are the forces along γ, and at a solution s_i = μ_i|a_t,i| at rest, −σ a_t,i where it slides.
//! After each programme the word of its solution is solved exactly, and the exact solution decides whether the word is consistent. If no
//! such word is, the problem is solved by pivoting; if the word of this solution is not consistent, either, the letters with the worst margins are changed, then any single letter. The method can find a mode; it cannot show that
//! there is no mode, or no other one.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::error::Error;
use crate::math::mass_vector::MassVector;
use crate::modes::answer::{Condition, ModeAnswer};
use crate::modes::enumerate::solve;
use crate::modes::pivoting::{Pivoted, by_pivoting};
use crate::modes::scaled::Problem;
use crate::modes::words::{Mode, Word};
use crate::tolerance::{PIVOTED_ZERO, QP_ZERO};

/// Sliding accelerations, relative to the load, from which the search starts. It may cycle from one of them and converge from
/// another.
const STARTS: [f64; 3] = [0.0, 1.0, 10.0];
/// Largest number of programmes from each start.
const ROUNDS: usize = 20;
/// Largest number of words that are solved. One takes 0.1 ms, also for 64 contacts.
const WORDS: usize = 2000;

/// One generator of a friction cone.
struct Generator {
    contact: usize,
    sigma: f64,
}

/// The first consistent word that the search finds, if any.
///
/// # Errors
///
/// [`Error::Solver`] if Clarabel refuses the programme.
pub(super) fn search<P: Problem>(problem: &P) -> Result<Option<ModeAnswer>, Error> {
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
    let mut tried = Tried { problem, failed: Vec::new() };
    let all_apart = tried.try_out(Word::separate(rows.len()));
    if generators.is_empty() || all_apart.is_some() {
        return Ok(all_apart);
    }
    if let Some((y, forces)) = pivoted(problem) {
        for blur in PIVOTED_ZERO {
            if let Some(answer) = tried.try_out(read(problem, &y, &forces, blur)) {
                return Ok(Some(answer));
            }
        }
        // The static word of a tie fails by more than a tie: the other word is taken.
        if let Some(mut answer) = tried.failed.iter().find(|a| a.holds_but_for_ties()).cloned() {
            answer.consistent = true;
            return Ok(Some(answer));
        }
    }

    let columns: Vec<Vec<f64>> = generators
        .iter()
        .map(|g| rows[g.contact].normal.plus(&rows[g.contact].tangent, g.sigma))
        .map(|direction| direction.components().map(|part| -part).collect())
        .collect();
    let matrix = CscMatrix::from(&columns);
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
        &CscMatrix::identity(load.len()),
        &load.components().map(|part| -part).collect::<Vec<_>>(),
        &matrix,
        &bound(&shift),
        &[SupportedConeT::NonnegativeConeT(generators.len())],
        settings,
    )
    .map_err(|problem| Error::Solver(problem.to_string()))?;

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
                break; // no acceleration satisfies all bounds
            }
            let y = P::V::of(load.len(), solver.solution.x.iter().copied());
            let mut forces = vec![[0.0; 2]; rows.len()];
            for (generator, z) in generators.iter().zip(&solver.solution.z) {
                forces[generator.contact][0] += generator.sigma * z;
                forces[generator.contact][1] += z;
            }
            for blur in QP_ZERO {
                if let Some(answer) = tried.try_out(read(problem, &y, &forces, blur)) {
                    return Ok(Some(answer));
                }
            }
            for (i, row) in rows.iter().enumerate() {
                let along = row.tangential(&y);
                shift[i] = match row.sliding {
                    None => 0.0,
                    Some(0) => row.friction * along.abs(),
                    Some(sign) => row.friction * f64::from(sign) * along,
                };
            }
        }
    }
    // Solving a word costs far less than a programme. The words found are repaired, and the repaired words again.
    let mut next = 0;
    while next < tried.failed.len() {
        let word = mended(problem, &tried.failed[next]);
        if let Some(answer) = word.and_then(|word| tried.try_out(word)) {
            return Ok(Some(answer));
        }
        next += 1;
    }
    // Then those that differ from one of them in a single letter.
    for k in 0..tried.failed.len() {
        for (i, row) in rows.iter().enumerate().filter(|(_, row)| row.sliding.is_some()) {
            for mode in Mode::ALL {
                let allowed = match (mode, row.sliding) {
                    (Mode::Separate, _) | (_, Some(0)) => true,
                    (Mode::Right, Some(sign)) => sign > 0,
                    (Mode::Left, Some(sign)) => sign < 0,
                    _ => false,
                };
                let word = tried.failed[k].word.with(i, mode);
                if allowed && let Some(answer) = tried.try_out(word) {
                    return Ok(Some(answer));
                }
            }
        }
    }
    Ok(None)
}

/// Acceleration and forces by [`pivoting`](crate::modes::pivoting).
fn pivoted<P: Problem>(problem: &P) -> Option<(P::V, Vec<[f64; 2]>)> {
    let (rows, load) = (problem.rows(), problem.load());
    let contacts = rows.iter().map(|row| {
        let axes = [&row.tangent, &row.normal];
        let effect = |other: usize| {
            axes.map(|own| [&rows[other].tangent, &rows[other].normal].map(|axis| own.dot(axis)))
        };
        let [tangential, normal] = axes.map(|axis| axis.dot(load));
        Pivoted {
            friction: row.friction,
            sliding: row.sliding,
            pull: [tangential + row.bias[0], normal + row.bias[1]],
            effects: (0..rows.len()).map(effect).collect(),
        }
    });
    let forces = by_pivoting(&contacts.collect::<Vec<_>>())?;
    let mut y = load.clone();
    for (row, [t, n]) in rows.iter().zip(&forces) {
        y = y.plus(&row.tangent, *t).plus(&row.normal, *n);
    }
    Some((y, forces))
}

/// Words solved so far, none of them consistent.
struct Tried<'a, P> {
    problem: &'a P,
    failed: Vec<ModeAnswer>,
}

impl<P: Problem> Tried<'_, P> {
    /// The answer for this word, if it is consistent and new.
    fn try_out(&mut self, word: Word) -> Option<ModeAnswer> {
        if self.failed.len() >= WORDS || self.failed.iter().any(|answer| answer.word == word) {
            return None;
        }
        let answer = solve(self.problem, word);
        if answer.consistent {
            return Some(answer);
        }
        self.failed.push(answer);
        None
    }
}

/// The word after a change of one letter: the letter whose test has the worst margin.
fn mended(problem: &impl Problem, answer: &ModeAnswer) -> Option<Word> {
    let worst = answer.violated().min_by(|a, b| a.value.total_cmp(&b.value))?;
    let i = worst.contact.index();
    let mode = match (worst.condition, problem.rows()[i].sliding) {
        (Condition::Presses, _) => Mode::Separate,
        (Condition::Opens, Some(1)) => Mode::Right,
        (Condition::Opens, Some(-1)) => Mode::Left,
        (Condition::InCone, _) if answer.forces[i][0] > 0.0 => Mode::Left,
        (Condition::InCone, _) => Mode::Right,
        (Condition::Opens | Condition::SlidesRight | Condition::SlidesLeft, _) => Mode::Fixed,
        (Condition::Touches | Condition::Sticks, _) => return None, // no force changes it
    };
    Some(answer.word.with(i, mode))
}

/// The word of an approximate solution. If one of two quantities must vanish, the smaller one is set to zero. An acceleration below
/// `blur` counts as zero.
fn read<P: Problem>(problem: &P, y: &P::V, forces: &[[f64; 2]], blur: f64) -> Word {
    let rows = problem.rows();
    rows.iter().enumerate().fold(Word::separate(rows.len()), |word, (i, row)| {
        let [f_t, f_n] = forces[i];
        let opens = row.opening(y);
        if row.sliding.is_none() || opens > f_n.max(blur) {
            return word;
        }
        let along = row.tangential(y);
        let mode = match row.sliding {
            Some(0) if along.abs() <= blur.max(row.friction * f_n - f_t.abs()) => Mode::Fixed,
            Some(0) if along > 0.0 => Mode::Right,
            Some(1) => Mode::Right,
            _ => Mode::Left,
        };
        word.with(i, mode)
    })
}
