//! Many runs at once, on one thread: time of a collision in lanes, compared with a single run.
//!
//! `batch/{local,full}/collision/{1,2,4,8}`: the number is the largest number of runs per register: 1 without lanes, 2
//! on any x86-64, 4 with AVX2, 8 with AVX-512; registers that the machine does not have are not used. The time covers
//! whole runs of long clattering, divided by their collisions. `batch/{local,full}/rest`: different rods until rest,
//! divided by their number. Reference times are in `collision.rs`.

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use standfast::outcome::End;
use standfast::simulate::{Resources, simulate_many_until};
use standfast::{Model, Options, Posture, State, Stop};

const LANES: [usize; 4] = [1, 2, 4, 8];
const RODS: u32 = 4096;

fn rod(gyration_radius: f64, restitution: f64) -> Posture {
    Posture::rod(0.5, gyration_radius, restitution, 0.0, 9.81).unwrap_or_else(|e| panic!("{e}"))
}

fn many(postures: &[Posture], states: &[State], options: &Options, lanes: usize) -> Vec<End> {
    let resources = Resources { threads: 1, lanes };
    simulate_many_until(postures, black_box(states), options, resources, &|| false)
        .unwrap_or_else(|e| panic!("{e}"))
        .unwrap_or_default()
}

fn collisions(c: &mut Criterion) {
    let mut group = c.benchmark_group("batch");
    group.measurement_time(Duration::from_secs(4)).sample_size(20);
    // The full model runs up to the last moments, in which its geometry is frozen: those collisions are in the local model.
    for (model, name, restitution, runs, end) in
        [(Model::Local, "local", 0.999, 64, None), (Model::Full, "full", 0.99, 512, Some(0.9))]
    {
        let rod = [rod(0.1, restitution)];
        let starts: Vec<State> = (0..runs)
            .map(|k| State::at_rest([0.0, 0.011, 0.001 * (1.0 + 1e-5 * f64::from(k))]))
            .collect();
        let mut options = Options { model, stop: Stop::Zeno, ..Options::default() };
        if let Some(share) = end {
            let whole = many(&rod, &starts[..1], &options, 1)[0].elapsed;
            options.time_limit = Some(share * whole);
        }
        let alone = many(&rod, &starts, &options, 1);
        group.throughput(Throughput::Elements(alone.iter().map(|end| end.collisions as u64).sum()));
        for lanes in LANES {
            assert_eq!(many(&rod, &starts, &options, lanes), alone);
            let id = BenchmarkId::new(format!("{name}/collision"), lanes);
            group.bench_function(id, |b| b.iter(|| many(&rod, &starts, &options, lanes)));
        }
    }
    group.finish();
}

fn rests(c: &mut Criterion) {
    let mut group = c.benchmark_group("batch");
    group.throughput(Throughput::Elements(u64::from(RODS)));
    let share = |k: u32| f64::from(k) / f64::from(RODS);
    let rods: Vec<Posture> = (0..RODS)
        .map(|k| rod(0.15 + 0.1 * share(k), 0.05 + 0.1 * share(k * 7919 % RODS)))
        .collect();
    let starts: Vec<State> = (0..RODS)
        .map(|k| State::at_rest([0.0, 0.011, 0.002 * (0.2 + 0.8 * share(k * 3137 % RODS))]))
        .collect();
    for (model, name) in [(Model::Local, "local"), (Model::Full, "full")] {
        let options = Options { model, ..Options::default() };
        group.bench_function(format!("{name}/rest"), |b| {
            b.iter(|| many(&rods, &starts, &options, 8));
        });
    }
    group.finish();
}

criterion_group!(benches, collisions, rests);
criterion_main!(benches);
