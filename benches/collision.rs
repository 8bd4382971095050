//! Time of one collision, relative to a lower bound.
//!
//! The time covers a whole run to its Zeno point, divided by the number of its collisions. The reference computations
//! run in the same process: a chain of dependent square roots and divisions for the local model, a chain of sincos
//! (libm crate) and square root for the full one. Only ratios matter.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use standfast::body::LocalState;
use standfast::simulate::simulate_local;
use standfast::{Lamina, Options, Posture, State, Stop, simulate};
use standfast_benches::self_similar;

/// Length of a reference chain.
const LINKS: u64 = 1000;

fn options(record: bool) -> Options {
    Options { stop: Stop::Zeno, record, ..Options::default() }
}

fn collisions(c: &mut Criterion) {
    let mut group = c.benchmark_group("collision");
    group.measurement_time(Duration::from_secs(4)).sample_size(50);

    group.throughput(Throughput::Elements(LINKS));
    group.bench_function("yardstick/sqrt_div", |b| {
        b.iter(|| {
            let mut x = black_box(1.7_f64);
            for _ in 0..LINKS {
                x = 3.0 / x.sqrt();
            }
            x
        });
    });
    group.bench_function("yardstick/sincos_sqrt", |b| {
        b.iter(|| {
            let mut x = black_box(0.7_f64);
            for _ in 0..LINKS {
                let (sin, cos) = libm::sincos(x);
                x = (sin + cos).abs().sqrt();
            }
            x
        });
    });

    let (model, gaps, rates) = self_similar(0.999, 0.99963);
    let (rod, start, end) = falling_rod();
    for (record, name) in [(false, "plain"), (true, "recorded")] {
        let local = || {
            simulate_local(
                &model,
                &LocalState { gaps: black_box(gaps), rates, ..LocalState::default() },
                &options(record),
            )
        };
        let run = local().unwrap_or_else(|e| panic!("{e}"));
        assert!(run.collisions() > 100_000, "{}", run.collisions());
        group.throughput(Throughput::Elements(run.collisions() as u64));
        group.bench_function(BenchmarkId::new("local/clattering", name), |b| b.iter(local));

        let cut = Options { time_limit: Some(end), ..options(record) };
        let full = || simulate(&rod, black_box(&start), &cut);
        let run = full().unwrap_or_else(|e| panic!("{e}"));
        assert!(run.collisions() > 200, "{}", run.collisions());
        group.throughput(Throughput::Elements(run.collisions() as u64));
        group.bench_function(BenchmarkId::new("full/clattering", name), |b| b.iter(full));
    }
    group.finish();
}

/// A rod with hundreds of collisions, and the time of the 300th collision. Until then all are in the full model; later
/// ones have frozen geometry.
fn falling_rod() -> (Posture, State, f64) {
    let rod = Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.1), restitution: 0.9, ..Lamina::default() },
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let start = State::at_rest([0.0, 0.011, 0.001]);
    let run = simulate(&rod, &start, &options(true)).unwrap_or_else(|e| panic!("{e}"));
    let end = run.impacts()[300].time;
    (rod, start, end)
}

criterion_group!(benches, collisions);
criterion_main!(benches);
