//! A convex quadratic programme with few entries in each row, by Clarabel:
//!
//! ```text
//! min ½ Σ_k d_k x_k² + c·x   subject to   a·x = b (rows `equal`),   a·x ≥ b (rows `above`)
//! ```

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::math::Sparse;
use crate::tolerance::SPARSE_REDUCED;

/// Largest number of steps of the solver. It takes 10 to 30; where the programme has no solution it may take more.
const STEPS: u32 = 80;

/// A programme in x.
#[derive(Debug, Default)]
pub(crate) struct Programme {
    /// d, one for each unknown.
    pub(crate) squares: Vec<f64>,
    /// c, one for each unknown.
    pub(crate) costs: Vec<f64>,
    pub(crate) equal: Vec<(Sparse, f64)>,
    pub(crate) above: Vec<(Sparse, f64)>,
    /// Relative accuracy.
    pub(crate) accuracy: f64,
}

/// How far the solver came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Status {
    /// To the accuracy asked for, or to [`SPARSE_REDUCED`] where rounding prevents more.
    Converged,
    /// No x satisfies the rows.
    Empty,
    /// The objective has no bound.
    Unbounded,
    /// Not so far.
    Stuck,
}

/// The last point.
pub(crate) struct Solution {
    pub(crate) status: Status,
    pub(crate) x: Vec<f64>,
    /// The multipliers ≥ 0 of the rows `above`.
    pub(crate) multipliers: Vec<f64>,
}

impl Programme {
    /// The last point of the solver; `None` if it refuses the programme.
    pub(crate) fn minimise(&self) -> Option<Solution> {
        let n = self.costs.len();
        let diagonal = (0..n).filter(|&k| self.squares[k] != 0.0);
        let diagonal: (Vec<usize>, Vec<f64>) = diagonal.map(|k| (k, self.squares[k])).unzip();
        let squares =
            CscMatrix::new_from_triplets(n, n, diagonal.0.clone(), diagonal.0, diagonal.1);
        // Clarabel: A x + s = b with s = 0, then s ≥ 0.
        let (mut i, mut j, mut values, mut right) = (vec![], vec![], vec![], vec![]);
        let rows = self.equal.iter().map(|row| (1.0, row));
        for (sign, (entries, bound)) in rows.chain(self.above.iter().map(|row| (-1.0, row))) {
            for (column, value) in entries {
                i.push(right.len());
                j.push(*column);
                values.push(sign * value);
            }
            right.push(sign * bound);
        }
        let matrix = CscMatrix::new_from_triplets(right.len(), n, i, j, values);
        let cones = [
            SupportedConeT::ZeroConeT(self.equal.len()),
            SupportedConeT::NonnegativeConeT(self.above.len()),
        ];
        let settings = DefaultSettings {
            verbose: false,
            presolve_enable: false,
            max_iter: STEPS,
            tol_gap_abs: self.accuracy,
            tol_gap_rel: self.accuracy,
            tol_feas: self.accuracy,
            reduced_tol_gap_abs: SPARSE_REDUCED,
            reduced_tol_gap_rel: SPARSE_REDUCED,
            reduced_tol_feas: SPARSE_REDUCED,
            ..DefaultSettings::default()
        };
        let mut solver =
            DefaultSolver::new(&squares, &self.costs, &matrix, &right, &cones, settings).ok()?;
        solver.solve();
        let found = &mut solver.solution;
        let status = match found.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => Status::Converged,
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Status::Empty,
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => Status::Unbounded,
            _ => Status::Stuck,
        };
        let multipliers = found.z.split_off(self.equal.len());
        Some(Solution { status, x: std::mem::take(&mut found.x), multipliers })
    }
}
