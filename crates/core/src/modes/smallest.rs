//! The smallest forces of a hyperstatic word, which allows many.
//!
//! ```text
//! min ½ Σ|f_i|²   subject to   Σ (T_iᵀ f_t,i + N_iᵀ f_n,i) = M(q̈ − a₀),   f_i in the cone that the word asks for
//! ```
//!
//! This programme is strictly convex: its solution is unique and depends continuously on the load. Clarabel finds the active edges of the
//! cones; with these, the forces follow from three linear equations.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};

use crate::math::mass_vector::MassVector;
use crate::modes::flats::Plane;
use crate::modes::rows::Row;
use crate::modes::words::{Mode, Word};
use crate::tolerance::{DEPENDENT_ROW, FORCE_BALANCE, QP_ACCURACIES, TIE};

/// Number of corrections of the smallest force. BBᵀ squares the condition of the wrenches, and a correction removes the rounding
/// error that this causes.
const REFINEMENTS: usize = 1;

/// Largest number of changes of the set of active edges, from the first guess to the set in which all multipliers are positive.
const CHANGES: usize = 16;

/// An unknown: a force (tangential, normal) of size one, per m times the scale of the problem, and its effect.
struct Unknown {
    contact: usize,
    force: [f64; 2],
    /// Its contribution to the planes.
    wrench: DVector<f64>,
}

/// An inequality edge·f ≥ 0 on the force of a contact.
struct Edge {
    contact: usize,
    edge: [f64; 2],
}

/// The smallest forces (tangential, normal), scaled, under which these planes vanish; `None` if neither the programme nor
/// the exact solution after it converges.
pub(super) fn smallest<V: MassVector>(
    rows: &[Row<V>],
    word: Word,
    planes: &[Plane<'_, V>],
    load: &V,
) -> Option<Vec<[f64; 2]>> {
    let closed: Vec<_> =
        word.modes().enumerate().filter(|(_, mode)| *mode != Mode::Separate).collect();
    let edges: Vec<_> = closed
        .iter()
        .flat_map(|&(contact, mode)| {
            let mu = rows[contact].friction;
            let cone: &[[f64; 2]] = if mode == Mode::Fixed && mu > 0.0 {
                &[[1.0, mu], [-1.0, mu]]
            } else {
                &[[0.0, 1.0]]
            };
            cone.iter().map(|&edge| Edge { contact, edge }).collect::<Vec<_>>()
        })
        .collect();
    // With zeros for planes that a body lacks, so that its forces are rounded alike for every number of planes.
    let padded = |parts: &mut dyn Iterator<Item = f64>| {
        DVector::from_iterator(planes.len().max(3), parts.chain([0.0; 3]).take(planes.len().max(3)))
    };
    let rest = padded(&mut planes.iter().map(|(row, bias)| -(row.dot(load) + bias)));
    let needs = |of: &V| padded(&mut planes.iter().map(|(row, _)| row.dot(of)));
    // The unknowns, if those edges are equations.
    let unknowns = |active: &[bool]| {
        let mut all = Vec::new();
        for &(contact, mode) in &closed {
            let (row, mu) = (&rows[contact], rows[contact].friction);
            let mut add = |t: f64, n: f64| {
                let length = libm::hypot(t, n);
                let force = [t / length, n / length];
                let push =
                    row.tangent.scaled(force[0]).plus(&row.normal, force[1]).scaled(row.stretch);
                all.push(Unknown { contact, force, wrench: needs(&push) });
            };
            let first = edges.iter().position(|e| e.contact == contact).unwrap_or(0);
            if mode == Mode::Fixed && mu > 0.0 {
                match (active[first], active[first + 1]) {
                    (false, false) => {
                        add(1.0, 0.0);
                        add(0.0, 1.0);
                    }
                    (true, false) => add(-mu, 1.0),
                    (false, true) => add(mu, 1.0),
                    (true, true) => {}
                }
            } else if !active[first] {
                add(-mode.direction() * mu, 1.0);
            }
        }
        all
    };
    let none = vec![false; edges.len()];
    let all = unknowns(&none);
    let guesses = QP_ACCURACIES.iter().map(|&accuracy| guess(&all, &edges, &rest, accuracy));
    for guess in [Some(none)].into_iter().chain(guesses) {
        let mut active = guess?;
        for _ in 0..CHANGES {
            let Some(found) = solve(rows.len(), &unknowns(&active), &rest) else { break };
            // The force of a contact without edges: λ by its own rows.
            let free = |contact: usize| {
                let row = &rows[contact];
                let mut lambda = V::zeros(load.len());
                planes
                    .iter()
                    .zip(&found.lambda)
                    .for_each(|((row, _), l)| lambda.add_scaled(row, *l));
                [row.tangent.dot(&lambda), row.normal.dot(&lambda)].map(|g| g * row.stretch)
            };
            let limit = TIE * found.size;
            let next: Vec<bool> = edges
                .iter()
                .enumerate()
                .map(|(k, Edge { contact, edge: [t, n] })| {
                    let ([f_t, f_n], [g_t, g_n]) = (found.forces[*contact], free(*contact));
                    let (mode, mu) = (word.mode(*contact), rows[*contact].friction);
                    if !active[k] {
                        return t * f_t + n * f_n < -limit * (1.0 + n);
                    }
                    // An edge is active if its multiplier is positive: f − g = Σ z·edge with z ≥ 0.
                    let z = if mode != Mode::Fixed || mu == 0.0 {
                        mode.direction() * mu * g_t - g_n
                    } else if edges.iter().zip(&active).all(|(e, on)| e.contact != *contact || *on)
                    {
                        -g_n - t * mu * g_t
                    } else {
                        t * (f_t - g_t) + n * (f_n - g_n)
                    };
                    z > -limit
                })
                .collect();
            if next == active {
                let forces = found.forces.iter().zip(rows);
                return Some(forces.map(|(f, row)| f.map(|f| f * row.stretch)).collect());
            }
            active = next;
        }
    }
    None
}

/// The smallest forces of some unknowns, whatever their signs.
struct Solved {
    forces: Vec<[f64; 2]>,
    /// The multipliers of the equations.
    lambda: DVector<f64>,
    /// The largest of the forces, at least one.
    size: f64,
}

fn solve(contacts: usize, unknowns: &[Unknown], rest: &DVector<f64>) -> Option<Solved> {
    // x = Bᵀλ with BBᵀλ = rest, B the wrenches of the unknowns.
    let n = rest.len();
    let mut gram = DMatrix::zeros(n, n);
    unknowns.iter().for_each(|u| gram.ger(1.0, &u.wrench, &u.wrench, 1.0));
    // BBᵀ = Σ w vvᵀ; for w = 0 the unknowns do not change along v.
    let eigen = gram.symmetric_eigen();
    let least = DEPENDENT_ROW * eigen.eigenvalues.amax();
    let inverse = |of: &DVector<f64>| {
        let mut sum = DVector::zeros(n);
        for k in (0..n).filter(|&k| eigen.eigenvalues[k] > least) {
            let v = eigen.eigenvectors.column(k);
            sum.axpy(v.dot(of) / eigen.eigenvalues[k], &v, 1.0);
        }
        sum
    };
    let mut forces = vec![[0.0; 2]; contacts];
    let (mut missing, mut lambda) = (rest.clone(), DVector::zeros(n));
    for _ in 0..=REFINEMENTS {
        let more = inverse(&missing);
        lambda += &more;
        for u in unknowns {
            let size = u.wrench.dot(&more);
            missing.axpy(-size, &u.wrench, 1.0);
            for k in 0..2 {
                forces[u.contact][k] += u.force[k] * size;
            }
        }
    }
    let size = forces.iter().flatten().fold(1.0_f64, |most, f| most.max(f.abs()));
    (missing.amax() <= FORCE_BALANCE * size).then_some(Solved { forces, lambda, size })
}

/// Which of the inequalities are equations at the optimum, by Clarabel.
fn guess(
    unknowns: &[Unknown],
    edges: &[Edge],
    rest: &DVector<f64>,
    accuracy: f64,
) -> Option<Vec<bool>> {
    let n = unknowns.len();
    let mut matrix: Vec<Vec<f64>> =
        (0..rest.len()).map(|k| unknowns.iter().map(|u| u.wrench[k]).collect()).collect();
    for Edge { contact, edge } in edges {
        let share = |u: &Unknown| {
            let acts = f64::from(u8::from(u.contact == *contact));
            -acts * (edge[0] * u.force[0] + edge[1] * u.force[1])
        };
        matrix.push(unknowns.iter().map(share).collect());
    }
    let mut bounds = rest.iter().copied().collect::<Vec<_>>();
    bounds.resize(rest.len() + edges.len(), 0.0);
    let settings = DefaultSettings {
        verbose: false,
        equilibrate_enable: false, // lengths are measured in ρ and rows are of order one
        tol_feas: accuracy,
        tol_gap_abs: accuracy,
        tol_gap_rel: accuracy,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(
        &CscMatrix::identity(n),
        &vec![0.0; n],
        &CscMatrix::from(&matrix),
        &bounds,
        &[SupportedConeT::ZeroConeT(rest.len()), SupportedConeT::NonnegativeConeT(edges.len())],
        settings,
    )
    .ok()?;
    solver.solve();
    let solution = &solver.solution;
    // Either the multiplier or the slack of an inequality vanishes.
    matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved).then(|| {
        solution.z[rest.len()..].iter().zip(&solution.s[rest.len()..]).map(|(z, s)| z > s).collect()
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::{ContactProblem, Method, ProblemFields, contact_modes};
    use super::*;

    fn at_rest(legs: &[([f64; 2], f64)], friction: f64, load: [f64; 3]) -> ContactProblem {
        let n = legs.len();
        ContactProblem::new(ProblemFields {
            mass: 1.0,
            gyration_radius: 0.5,
            arms: legs.iter().map(|leg| leg.0).collect(),
            tangents: legs.iter().map(|leg| [leg.1.cos(), leg.1.sin()]).collect(),
            friction: vec![friction; n],
            sliding: vec![Some(0); n],
            bias: vec![[0.0; 2]; n],
            free_acceleration: load,
            ..ProblemFields::default()
        })
        .unwrap()
    }

    /// No acceleration at all.
    const AXES: [Plane<'static, Vector3<f64>>; 3] = [
        (&Vector3::new(1.0, 0.0, 0.0), 0.0),
        (&Vector3::new(0.0, 1.0, 0.0), 0.0),
        (&Vector3::new(0.0, 0.0, 1.0), 0.0),
    ];

    #[test]
    fn two_fixed_contacts_have_the_closed_form() {
        let mut edges = 0;
        for k in 0..400 {
            let s = |i: i32| f64::from((k * 37 + i * 101) % 97) / 48.5 - 1.0;
            let legs =
                [([-1.0 + 0.3 * s(1), -1.0], 0.6 * s(2)), ([1.0, -0.8 + 0.3 * s(3)], 0.6 * s(4))];
            let problem = at_rest(&legs, 0.9 + 0.5 * s(5), [0.5 * s(6), -1.0, 0.5 * s(7)]);
            let closed = problem.pair_modes().unwrap();
            let Some(mode) =
                closed.iter().find(|m| m.consistent && m.letters() == [Mode::Fixed; 2])
            else {
                continue;
            };
            let word = "FF".parse().unwrap();
            let by_clarabel = smallest(problem.rows(), word, &AXES, &problem.load()).unwrap();
            for i in 0..2 {
                let (one, two) = (mode.force(&problem, i), problem.force(i, by_clarabel[i]));
                let off = (one[0] - two[0]).hypot(one[1] - two[1]);
                assert!(off <= 1e-12 * (1.0 + one[0].hypot(one[1])), "{k}: {one:?} {two:?}");
                let mu = problem.fields().friction[i];
                edges += i32::from((one[0].abs() - mu * one[1]).abs() < 1e-12);
            }
        }
        assert!(edges > 20, "{edges} forces on the edge of their cone");
    }

    #[test]
    fn a_level_table_shares_its_weight_linearly() {
        // Least squares under two equations: f_n is linear in the place of the leg while none is lifted; no leg pushes
        // along the floor.
        for n in [3, 5, 64] {
            let place = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 0.9;
            let legs: Vec<_> = (0..n).map(|i| ([place(i), -1.0], 0.0)).collect();
            let modes =
                contact_modes(&at_rest(&legs, 0.7, [0.0, -1.0, 0.0]), Method::Enumerate).unwrap();
            let answer = modes.get("F".repeat(n).parse().unwrap()).unwrap();
            let (count, sum) = (n as f64, (0..n).map(place).sum::<f64>());
            let squares: f64 = (0..n).map(|i| place(i).powi(2)).sum();
            let slope = -sum / (count * squares - sum * sum);
            for (i, f) in answer.forces.iter().enumerate() {
                let expected = (1.0 - slope * sum) / count + slope * place(i);
                assert!(expected > 0.0 && (f[1] - expected).abs() < 1e-13, "{n}: {f:?} {expected}");
                assert!(f[0].abs() < 1e-13, "{n}: {f:?}");
            }
        }
    }
}
