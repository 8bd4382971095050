//! Words whose forces are not unique: more unknown forces than independent rows, or a singular friction matrix.
//!
//! Forces are sums of the generators of the friction cones with weights ≥ 0: N ± μT of a fixed contact, N ∓ μT of
//! a sliding one. A small linear programme finds the largest t such that all weights and all margins of strict tests are at least
//! t; the word is consistent if this t is large enough. For a consistent word the smallest force is reported.

use crate::math::mass_vector::MassVector;
use crate::math::simplex::maximise;
use crate::modes::answer::{Forces, ModeAnswer};
use crate::modes::flats::{Flat, Plane};
use crate::modes::judge::judge;
use crate::modes::rows::Row;
use crate::modes::scaled::Problem;
use crate::modes::words::{Mode, Word};
use crate::tolerance::{DEPENDENT_ROW, TIE};

/// A generator of the friction cone of a contact: its direction, and the force (tangential, normal) of weight one.
struct Generator<V> {
    contact: usize,
    direction: V,
    force: [f64; 2],
}

/// The generators of the friction cones that a word allows.
fn generators<V: MassVector>(rows: &[Row<V>], word: Word) -> Vec<Generator<V>> {
    let of = |(contact, mode): (usize, Mode)| {
        let row = &rows[contact];
        let edges: &[f64] = match mode {
            Mode::Separate => &[],
            Mode::Fixed => &[-1.0, 1.0],
            Mode::Right => &[-1.0],
            Mode::Left => &[1.0],
        };
        // Both edges together have the weight of the one edge of a sliding contact.
        let share = 1.0 / edges.len().max(1) as f64;
        edges.iter().map(move |side| {
            let force = [side * row.friction * share, share];
            let direction = row.tangent.scaled(force[0]).plus(&row.normal, force[1]);
            Generator { contact, direction, force }
        })
    };
    word.modes().enumerate().flat_map(of).collect()
}

/// The rows and biases of the accelerations that a word needs to be positive.
fn strict_tests<V: MassVector>(rows: &[Row<V>], word: Word) -> Vec<(V, f64)> {
    let test = |(i, mode): (usize, Mode)| match (mode, rows[i].sliding) {
        (_, None) => None,
        (Mode::Separate, _) => Some((rows[i].normal.clone(), rows[i].bias[1])),
        (Mode::Right, Some(0)) => Some((rows[i].tangent.clone(), rows[i].bias[0])),
        (Mode::Left, Some(0)) => Some((rows[i].tangent.scaled(-1.0), -rows[i].bias[0])),
        _ => None,
    };
    word.modes().enumerate().filter_map(test).collect()
}

/// Solves a word. `planes`: the rows that the word keeps at zero; `independent`: an orthonormal basis of them. If there are as many rows as
/// basis vectors, the rows are independent, and only friction can make the system singular.
pub(super) fn solve<P: Problem>(
    problem: &P,
    word: Word,
    planes: &[Plane<'_, P::V>],
    independent: &[Plane<'_, P::V>],
) -> ModeAnswer {
    let (rows, load) = (problem.rows(), problem.load());
    let generators = generators(rows, word);
    // Variables: weights above t, t as the difference of two, one slack per strict test and one for t ≤ 1.
    let n = generators.len();
    let strict = strict_tests(rows, word);
    let width = n + 2 + strict.len() + 1;
    let weights_of = |row: &P::V| {
        let mut a: Vec<f64> = generators.iter().map(|g| row.dot(&g.direction)).collect();
        let all = a.iter().sum::<f64>();
        a.resize(width, 0.0);
        (a[n], a[n + 1]) = (all, -all);
        a
    };
    let mut programme = Vec::new();
    for (row, bias) in independent {
        programme.push((weights_of(row), -(row.dot(load) + bias)));
    }
    for (k, (row, bias)) in strict.iter().enumerate() {
        let mut a = weights_of(row);
        a[n] -= 1.0;
        a[n + 1] += 1.0;
        a[n + 2 + k] = -1.0;
        programme.push((a, 2.0 * TIE - (row.dot(load) + bias)));
    }
    let mut cap = vec![0.0; width];
    (cap[n], cap[n + 1], cap[width - 1]) = (1.0, -1.0, 1.0);
    programme.push((cap, 1.0));
    let mut objective = vec![0.0; width];
    (objective[n], objective[n + 1]) = (1.0, -1.0);

    let determined =
        if independent.len() == planes.len() { Forces::Singular } else { Forces::Family };
    let Some(x) = maximise(&programme, &objective) else {
        let none = vec![[0.0; 2]; rows.len()];
        return judge(problem, word, load, &none, Forces::Impossible);
    };
    let t = x[n] - x[n + 1];
    let (mut y, mut forces) = (load.clone(), vec![[0.0; 2]; rows.len()]);
    for (generator, weight) in generators.iter().zip(&x) {
        let weight = weight + t;
        y.add_scaled(&generator.direction, weight);
        for k in 0..2 {
            forces[generator.contact][k] += generator.force[k] * weight;
        }
    }
    let missed = planes.iter().map(|(row, bias)| (row.dot(&y) + bias).abs()).fold(0.0, f64::max);
    let size = forces.iter().flatten().fold(1.0_f64, |most, f| most.max(f.abs()));
    let determined = if missed <= DEPENDENT_ROW * size { determined } else { Forces::Impossible };
    // Forces may be large and cancel. The acceleration is computed without their rounding errors.
    for (row, bias) in independent {
        let off = row.dot(&y) + bias;
        y.add_scaled(row, -off);
    }
    // The motion depends on the choice of forces if some change of them keeps each plane and changes the motion. A weight that is zero
    // for every choice does not change.
    let changes = t > TIE || determined == Forces::Impossible;
    let sum: f64 = x[..n].iter().map(|weight| weight + t).sum();
    let directions: Vec<P::V> = (0..n)
        .filter(|&k| changes || can_press(&generators, independent, load, sum, k))
        .map(|k| &generators[k].direction)
        .map(|direction| direction.divided(direction.norm())) // their lengths grow with μ
        .collect();
    let kept = |direction: &P::V| {
        let mut sum = P::V::zeros(load.len());
        independent.iter().for_each(|(row, _)| sum.add_scaled(row, row.dot(direction)));
        sum
    };
    let determined = if determined != Forces::Impossible
        && rank(&directions) > rank(&directions.iter().map(kept).collect::<Vec<_>>())
    {
        Forces::Undetermined
    } else {
        determined
    };
    let answer = judge(problem, word, &y, &forces, determined);
    #[cfg(feature = "qp")]
    if answer.consistent
        && let Some(scaled) = super::smallest::smallest(rows, word, independent, load)
    {
        let pushed =
            scaled.iter().zip(rows).fold(load.clone(), |y, (force, row)| row.pushed(&y, *force));
        let y = if determined == Forces::Undetermined { pushed } else { y };
        let of_smallest = judge(problem, word, &y, &scaled, determined);
        if of_smallest.consistent {
            let (acceleration, forces) = (of_smallest.acceleration, of_smallest.forces);
            return ModeAnswer { acceleration, forces, ..answer };
        }
    }
    answer
}

/// Returns true if the weight of a generator is positive for some choice of the forces. `sum`: of the weights of one choice.
fn can_press<V: MassVector>(
    generators: &[Generator<V>],
    independent: &[Plane<'_, V>],
    load: &V,
    sum: f64,
    at: usize,
) -> bool {
    let n = generators.len();
    // Variables: weights, and one slack that bounds them.
    let mut programme: Vec<(Vec<f64>, f64)> = independent
        .iter()
        .map(|(row, bias)| {
            let weights = generators.iter().map(|g| row.dot(&g.direction));
            (weights.chain([0.0]).collect(), -(row.dot(load) + bias))
        })
        .collect();
    programme.push((vec![1.0; n + 1], sum.max(0.0) + 1.0));
    let mut objective = vec![0.0; n + 1];
    objective[at] = 1.0;
    // Without an answer, as if it could.
    maximise(&programme, &objective).is_none_or(|x| x[at] > TIE)
}

/// Number of independent directions.
fn rank<V: MassVector>(directions: &[V]) -> usize {
    let Some(first) = directions.first() else { return 0 };
    let mut flat = Flat::everything(first.len());
    for direction in directions {
        if let Some(cut) = flat.with((direction, 0.0)) {
            flat = cut;
        }
    }
    flat.rank()
}
