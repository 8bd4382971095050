//! Time of one collision, relative to a lower bound.
//!
//! `collision/{local,full}/clattering/{plain,recorded}`: the time of a whole run, divided by the number of its collisions. The run of the
//! local model goes to its Zeno point, that of the full model to its 300th collision. The reference computations
//! `collision/yardstick/…` run in the same process: a chain of dependent square roots and divisions for the local model, a chain of
//! sincos (libm crate) and square root for the full one. Only ratios matter.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use standfast::body::LocalState;
use standfast::simulate::simulate_local;
use standfast::{Lamina, Model, Options, Outcome, Posture, State, Stop, simulate};
use standfast_benches::self_similar;

/// Length of a reference chain.
const LINKS: u64 = 1000;
/// Number of collisions of a run of the full model.
const COLLISIONS: usize = 300;

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
        assert_eq!((run.model(), run.outcome()), (Model::Local, Outcome::Zeno));
        assert!(run.collisions() > 100_000, "{}", run.collisions());
        group.throughput(Throughput::Elements(run.collisions() as u64));
        group.bench_function(BenchmarkId::new("local/clattering", name), |b| b.iter(local));

        let cut = Options { model: Model::Full, time_limit: Some(end), ..options(record) };
        let full = || simulate(&rod, black_box(&start), &cut);
        let run = full().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((run.model(), run.outcome()), (Model::Full, Outcome::TimeLimit));
        assert!((COLLISIONS..=COLLISIONS + 1).contains(&run.collisions()), "{}", run.collisions());
        group.throughput(Throughput::Elements(run.collisions() as u64));
        group.bench_function(BenchmarkId::new("full/clattering", name), |b| b.iter(full));
    }
    group.finish();
}

/// A rod in the full model with hundreds of collisions, and the time of collision number [`COLLISIONS`]. Until then the body turns by
/// finite angles from one collision to the next; the frames of later ones are frozen.
fn falling_rod() -> (Posture, State, f64) {
    let rod = Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.1), restitution: 0.9, ..Lamina::default() },
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let start = State::at_rest([0.0, 0.011, 0.001]);
    let options = Options { model: Model::Full, ..options(true) };
    let run = simulate(&rod, &start, &options).unwrap_or_else(|e| panic!("{e}"));
    let end = run.impacts()[COLLISIONS].time;
    (rod, start, end)
}

criterion_group!(benches, collisions);
criterion_main!(benches);
