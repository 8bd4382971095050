//! Contact modes: closed forms, enumeration and Clarabel's programs on the same problems.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use standfast::modes::{ContactProblem, Method, ProblemFields, Status, contact_modes};

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

fn modes(c: &mut Criterion) {
    let mut group = c.benchmark_group("modes");
    for n in [1, 2, 3, 4, 5, 6, 7, 8, 10, 16, 32] {
        let problem = valley(n);
        if n <= 2 {
            assert!(problem.pair_modes().is_some());
            group.bench_function(BenchmarkId::new("closed", n), |b| {
                b.iter(|| black_box(&problem).pair_modes());
            });
        }
        for (method, name) in [(Method::Enumerate, "enumerate"), (Method::Qp, "qp")] {
            let solve = || contact_modes(black_box(&problem), method);
            let status = solve().map(|modes| modes.status());
            assert!(
                !matches!(status, Err(_) | Ok(Status::None | Status::NotFound)),
                "{n}: {status:?}"
            );
            group.bench_function(BenchmarkId::new(name, n), |b| b.iter(solve));
        }
    }
    group.finish();
}

criterion_group!(benches, modes);
criterion_main!(benches);
