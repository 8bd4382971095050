//! One collision, in the units of what it must cost at the least.
//!
//! The clock covers whole runs to the Zeno point of scenes with many collisions; divided by their number
//! (the throughput) it gives the time of one collision. The yardsticks run in the same process: a chain of
//! dependent square roots and divisions, and a chain of sincos (libm crate) and square root.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use standfast::{LocalModel, Options, Posture, State, Stop, simulate};

fn options(record: bool) -> Options {
    Options { stop: Stop::Zeno, record, ..Options::default() }
}

/// A local model just below Goyal's bound and the paper's: hundreds of collisions before the sum.
fn long_local() -> (LocalModel, [f64; 2], [f64; 2]) {
    let model = LocalModel::new([1.0; 2], [0.999; 2], [0.0; 2], [0.93; 2]);
    (model.unwrap_or_else(|e| panic!("{e}")), [0.0, 0.1], [0.1, -1.0])
}

fn chain(c: &mut Criterion) {
    let mut group = c.benchmark_group("collision");
    group.measurement_time(Duration::from_secs(3));

    const LINKS: u64 = 1000;
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

    let (model, gaps, rates) = long_local();
    for record in [false, true] {
        let run = model.simulate(gaps, rates, 0.0, 0.0, &options(record));
        let collisions = run.unwrap_or_else(|e| panic!("{e}")).collisions();
        assert!(collisions > 200, "{collisions}");
        group.throughput(Throughput::Elements(collisions as u64));
        let name = if record { "recorded" } else { "plain" };
        group.bench_function(BenchmarkId::new("local/clattering", name), |b| {
            b.iter(|| model.simulate(black_box(gaps), rates, 0.0, 0.0, &options(record)));
        });
    }

    // A rod that clatters long before it settles: full model.
    let rod = Posture::rod(0.5, 0.02, 0.9, 0.0, 9.81).unwrap_or_else(|e| panic!("{e}"));
    let start = State::at_rest([0.0, 0.011, 0.002]);
    for record in [false, true] {
        let run = simulate(&rod, &start, &options(record)).unwrap_or_else(|e| panic!("{e}"));
        assert!(run.collisions() > 50, "{}", run.collisions());
        group.throughput(Throughput::Elements(run.collisions() as u64));
        let name = if record { "recorded" } else { "plain" };
        group.bench_function(BenchmarkId::new("full/clattering", name), |b| {
            b.iter(|| simulate(&rod, black_box(&start), &options(record)));
        });
    }
    group.finish();
}

criterion_group!(benches, chain);
criterion_main!(benches);
