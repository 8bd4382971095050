//! Contact modes of `n` contacts at rest in a valley, under an inclined load. Routes in one group answer the same question about the same
//! problem, and their answers are compared before they are timed.
//!
//! * `modes/one_answer/{enumerate,qp}/n`: one consistent mode with its motion, forces and margins. Enumeration solves all words to find it;
//!   the convex programmes stop at the first.
//! * `modes/all_answers/{closed,enumerate}/n`: every word with its motion, forces and margins, for one and two contacts.
//! * `modes/inner/closed/n`: the same closed forms as the event loop uses them, without margins and without allocation.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use standfast::modes::{ContactProblem, Method, ModeAnswer, Modes, ProblemFields, contact_modes};

/// Largest difference of accelerations, in m/s² and rad/s², and of forces, in N, between two routes. The load is 1 N. The routes solve
/// the same equations in another order: the differences are rounding errors, which grow with the number of contacts.
const AGREES: f64 = 1e-12;

/// Contacts at rest on the arc of a valley, under an inclined load.
fn valley(n: usize) -> ContactProblem {
    let angle = |i: usize| if n == 1 { 0.0 } else { i as f64 / (n - 1) as f64 * 1.6 - 0.8 };
    ContactProblem::new(ProblemFields {
        mass: 1.0,
        gyration_radius: 0.7,
        arms: (0..n).map(|i| [1.3 * angle(i).sin() + 0.1, -0.9 * angle(i).cos()]).collect(),
        tangents: (0..n).map(|i| [angle(i).cos(), angle(i).sin()]).collect(),
        friction: vec![0.3; n],
        sliding: vec![Some(0); n],
        bias: vec![[0.0; 2]; n],
        free_acceleration: [0.4, -1.0, 0.3],
        ..ProblemFields::default()
    })
    .unwrap_or_else(|e| panic!("{e}"))
}

fn solved(problem: &ContactProblem, method: Method) -> Modes {
    contact_modes(problem, method).unwrap_or_else(|e| panic!("{e}"))
}

/// Panics unless the second route has this word with the same motion and forces.
fn assert_has(modes: &Modes, answer: &ModeAnswer) {
    let word = answer.word;
    let Some(other) = modes.get(word) else { panic!("{word} is missing") };
    assert_eq!(answer.consistent, other.consistent, "{word}");
    let [one, two] = [answer, other].map(|a| a.acceleration.iter().copied().chain(forces(a)));
    let off = one.zip(two).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    assert!(off <= AGREES, "{word}: {off:e}");
}

fn forces(answer: &ModeAnswer) -> impl Iterator<Item = f64> {
    answer.forces.iter().flatten().copied()
}

fn modes(c: &mut Criterion) {
    let mut group = c.benchmark_group("modes");
    for n in [1, 2, 3, 4, 5, 6, 7, 8, 10, 16, 32] {
        let problem = valley(n);
        let every = solved(&problem, Method::Enumerate);
        let first = solved(&problem, Method::Qp);
        let first = first.consistent().next().unwrap_or_else(|| panic!("{n}: no mode found"));
        assert_has(&every, first);
        for (method, name) in [(Method::Enumerate, "enumerate"), (Method::Qp, "qp")] {
            group.bench_function(BenchmarkId::new(format!("one_answer/{name}"), n), |b| {
                b.iter(|| contact_modes(black_box(&problem), method));
            });
        }
        if n > 2 {
            continue;
        }
        // For one and two contacts the automatic choice is the closed forms, unless rows depend on each other.
        assert!(problem.pair_modes().is_some(), "{n}: closed forms");
        let closed = solved(&problem, Method::Auto);
        assert_eq!(closed.answers().len(), every.answers().len(), "{n}");
        closed.answers().iter().for_each(|answer| assert_has(&every, answer));
        for (method, name) in [(Method::Auto, "closed"), (Method::Enumerate, "enumerate")] {
            group.bench_function(BenchmarkId::new(format!("all_answers/{name}"), n), |b| {
                b.iter(|| contact_modes(black_box(&problem), method));
            });
        }
        group.bench_function(BenchmarkId::new("inner/closed", n), |b| {
            b.iter(|| black_box(&problem).pair_modes());
        });
    }
    group.finish();
}

criterion_group!(benches, modes);
criterion_main!(benches);
