//! The mechanism of a chain at a configuration, with the dynamics of its contacts.
//!
//! * `mechanism/contact_space/12_links`: mass matrix, load and contact rows of a floating chain of 12 links on two feet, and W and b from
//!   them, with all joints free.
//! * `mechanism/holding_torques/12_links`: the torques and forces that hold this chain, with their intervals.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use standfast::body::{Chain, ChainFields, Foot, Joint, Link};

/// Rounding error of an acceleration of a foot, in m/s². Without torques all points fall with the acceleration (0, −9.81).
const FALLS: f64 = 1e-11;

/// Twelve uniform links of 1 kg in an arch between two feet, each turned by the same angle from the one before; and its configuration.
fn arch() -> (Chain, Vec<f64>) {
    let (links, turn) = (12, -0.2);
    let mut fields = ChainFields {
        links: vec![Link::uniform(1.0, 0.3); links],
        joints: vec![Joint::torque(); links - 1],
        ..ChainFields::default()
    };
    fields.feet = vec![
        Foot { at: Some(0.0), friction: 0.8, ..Foot::of_link(1) },
        Foot { friction: 0.8, ..Foot::of_link(links) },
    ];
    let mut q = vec![0.0, 0.0, -0.5 * turn * (links - 1) as f64];
    q.resize(links + 2, turn);
    (Chain::new(fields).unwrap_or_else(|e| panic!("{e}")), q)
}

fn mechanism(c: &mut Criterion) {
    let mut group = c.benchmark_group("mechanism");
    let (chain, q) = arch();
    let made = chain.mechanism(&q).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(made.contact_space().rank(), 4);
    for (value, expected) in made.contact_space().b().iter().zip([0.0, -9.81, 0.0, -9.81]) {
        assert!((value - expected).abs() < FALLS, "{value} {expected}");
    }
    group.bench_function("contact_space/12_links", |b| {
        b.iter(|| black_box(&chain).mechanism(black_box(&q)));
    });
    let held = chain.holding_torques(&q, None).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(held.map(|held| held.freedom), Some(1));
    group.bench_function("holding_torques/12_links", |b| {
        b.iter(|| black_box(&chain).holding_torques(black_box(&q), None));
    });
    group.finish();
}

criterion_group!(benches, mechanism);
criterion_main!(benches);
