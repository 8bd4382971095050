//! Instruction counts with caps, under valgrind: the largest allowed cost of a collision and of a choice of contact modes.
//!
//! `cargo bench -p standfast-benches --bench caps` (gungraun with its runner of the same version, and valgrind) counts
//! the instructions of each function and fails if one exceeds its cap in `caps/limits.rs`. Counts include the call
//! around the loop, so the caps of collisions are for many of them.

#[path = "caps/limits.rs"]
mod limits;

use std::hint::black_box;

use gungraun::prelude::*;
use gungraun::{Callgrind, EventKind};
use standfast::body::{LocalModel, LocalState};
use standfast::excitation::Excitation;
use standfast::modes::{ContactProblem, PairModes, ProblemFields};
use standfast::outcome::End;
use standfast::simulate::{Resources, simulate_local, simulate_many_until};
use standfast::{Lamina, Model, Options, Posture, State, Stop, Trajectory, simulate};
use standfast_benches::{rods, self_similar};

/// Ends the run by time instead of at the same collision by `event_limit`, because that outcome has a warning, which
/// costs as much as ten collisions.
fn until(time: f64, options: Options) -> Options {
    Options { time_limit: Some(time), event_limit: usize::MAX, ..options }
}

/// A self-similar orbit: contacts alternate, and no sum applies until the precision is exhausted.
fn orbit(record: bool) -> (LocalModel, [f64; 2], [f64; 2], Options) {
    let (model, gaps, rates) = self_similar(0.999, 0.99963);
    let options = Options {
        stop: Stop::Zeno,
        record,
        event_limit: limits::LOCAL_COLLISIONS,
        ..Options::default()
    };
    let run =
        simulate_local(&model, &LocalState { gaps, rates, ..LocalState::default() }, &options)
            .unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(run.collisions(), limits::LOCAL_COLLISIONS);
    (model, gaps, rates, until(run.time(), options))
}

/// A rod with many collisions before its geometry may be frozen.
fn rod(record: bool) -> (Posture, State, Options) {
    let rod = Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.1), restitution: 0.99, ..Lamina::default() },
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let options = Options {
        model: Model::Full,
        stop: Stop::Zeno,
        record,
        event_limit: limits::FULL_COLLISIONS,
        ..Options::default()
    };
    let start = State::at_rest([0.0, 0.011, 0.001]);
    let run = simulate(&rod, &start, &options).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((run.model(), run.collisions()), (Model::Full, limits::FULL_COLLISIONS));
    (rod, start, until(run.time(), options))
}

/// A leaning body at rest on two feet.
fn stance() -> ContactProblem {
    let arms = vec![[-1.0, -0.8], [1.2, -0.8]];
    ContactProblem::new(ProblemFields {
        mass: 1.0,
        gyration_radius: 0.7,
        tangents: vec![[1.0, 0.0], [0.8, 0.6]],
        friction: vec![0.3; 2],
        sliding: vec![Some(0); 2],
        bias: vec![[0.0; 2]; 2],
        free_acceleration: [0.4, -1.0, 0.3],
        arms,
        ..ProblemFields::default()
    })
    .unwrap_or_else(|e| panic!("{e}"))
}

/// Drops of rods in one call: of one rod, or of different ones.
type Batch = (Vec<Posture>, Vec<State>, Options);

fn batch(model: Model, different: bool) -> Batch {
    let (mut rods, starts) = rods(limits::RODS);
    rods.truncate(if different { rods.len() } else { 1 });
    (rods, starts, Options { model, ..Options::default() })
}

fn many((rods, starts, options): Batch) -> (Vec<End>, Batch) {
    let (nothing, resources) = ([Excitation::default()], Resources { threads: 1 });
    let ends =
        simulate_many_until(&rods, &starts, black_box(&options), &nothing, resources, &|| false);
    // The batch is returned so that dropping it is not counted.
    (ends.unwrap_or_else(|e| panic!("{e}")), (rods, starts, options))
}

fn capped(instructions: u64) -> LibraryBenchmarkConfig {
    let mut config = LibraryBenchmarkConfig::default();
    config.tool(Callgrind::default().hard_limits([(EventKind::Ir, instructions)]));
    config
}

#[library_benchmark(config = capped(limits::LOCAL))]
#[bench::plain(orbit(false))]
fn local((model, gaps, rates, options): (LocalModel, [f64; 2], [f64; 2], Options)) -> Trajectory {
    black_box(simulate_local(
        &model,
        &LocalState { gaps, rates, ..LocalState::default() },
        &options,
    ))
    .unwrap_or_else(|e| panic!("{e}"))
}

#[library_benchmark(config = capped(limits::LOCAL_RECORDED))]
#[bench::recorded(orbit(true))]
fn local_recorded(
    (model, gaps, rates, options): (LocalModel, [f64; 2], [f64; 2], Options),
) -> Trajectory {
    black_box(simulate_local(
        &model,
        &LocalState { gaps, rates, ..LocalState::default() },
        &options,
    ))
    .unwrap_or_else(|e| panic!("{e}"))
}

#[library_benchmark(config = capped(limits::FULL))]
#[bench::plain(rod(false))]
fn full((rod, start, options): (Posture, State, Options)) -> Trajectory {
    black_box(simulate(&rod, &start, &options)).unwrap_or_else(|e| panic!("{e}"))
}

#[library_benchmark(config = capped(limits::PAIR_MODES))]
#[bench::at_rest(stance())]
fn pair_modes(stance: ContactProblem) -> (Option<PairModes>, ContactProblem) {
    (black_box(&stance).pair_modes(), stance) // returned, so that dropping it is not counted
}

#[library_benchmark(config = capped(limits::ONE_ROD_LOCAL))]
#[bench::one_rod(batch(Model::Local, false))]
fn drops_local(all: Batch) -> (Vec<End>, Batch) {
    many(all)
}

#[library_benchmark(config = capped(limits::RODS_LOCAL))]
#[bench::different_rods(batch(Model::Local, true))]
fn rods_local(all: Batch) -> (Vec<End>, Batch) {
    many(all)
}

#[library_benchmark(config = capped(limits::ONE_ROD_FULL))]
#[bench::one_rod(batch(Model::Full, false))]
fn drops_full(all: Batch) -> (Vec<End>, Batch) {
    many(all)
}

#[library_benchmark(config = capped(limits::RODS_FULL))]
#[bench::different_rods(batch(Model::Full, true))]
fn rods_full(all: Batch) -> (Vec<End>, Batch) {
    many(all)
}

library_benchmark_group!(
    name = caps,
    benchmarks =
        [local, local_recorded, full, pair_modes, drops_local, rods_local, drops_full, rods_full]
);
main!(library_benchmark_groups = caps);
