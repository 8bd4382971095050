//! Many runs at once, on one thread: `batch/{local,full,auto}/rest`, different rods dropped nearly level until they rest, divided by
//! their number.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use standfast::excitation::Excitation;
use standfast::outcome::End;
use standfast::simulate::{Resources, simulate_many_until};
use standfast::{Model, Options, Outcome, Posture, State};
use standfast_benches::rods;

const RODS: u32 = 4096;

fn many(postures: &[Posture], states: &[State], options: &Options) -> Vec<End> {
    let resources = Resources { threads: 1 };
    let nothing = [Excitation::default()];
    simulate_many_until(postures, black_box(states), options, &nothing, resources, &|| false)
        .unwrap_or_else(|e| panic!("{e}"))
}

fn rests(c: &mut Criterion) {
    let mut group = c.benchmark_group("batch");
    group.throughput(Throughput::Elements(u64::from(RODS)));
    let (rods, starts) = rods(RODS);
    for (model, name) in [(Model::Local, "local"), (Model::Full, "full"), (Model::Auto, "auto")] {
        let options = Options { model, ..Options::default() };
        assert!(many(&rods, &starts, &options).iter().all(|end| end.outcome == Outcome::Rest));
        group.bench_function(format!("{name}/rest"), |b| {
            b.iter(|| many(&rods, &starts, &options));
        });
    }
    group.finish();
}

criterion_group!(benches, rests);
criterion_main!(benches);
