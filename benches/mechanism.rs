//! The mechanism of a chain at a configuration, with the dynamics of its contacts.
//!
//! * `mechanism/contact_space/12_links`: mass matrix, load and contact rows of a floating chain of 12 links on two feet, and W and b from
//!   them, with all joints free.
//! * `mechanism/holding_torques/12_links`: the torques and forces that hold this chain, with their intervals.
//! * `mechanism/run/…/{posture,mechanism}`: the same run of a body on two feet in its local model and as a mechanism, to rest.
//! * `mechanism/run/biped`: a run of a biped with five coordinates under the torques that hold it.
//! * `mechanism/stability/{posture,mechanism,biped}`: verdicts.

use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use standfast::body::{Chain, ChainFields, Foot, HoldingChoice, Joint, Link, Mechanism};
use standfast::simulate::simulate_mechanism;
use standfast::stability::{StabilityOptions, WhyUndecided, mechanism_stability};
use standfast::{
    Contact, Impact, Model, Options, Outcome, Posture, PostureFields, State, simulate, stability,
};

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
    let held =
        chain.holding_torques(&q, None, HoldingChoice::Least).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(held.map(|held| held.freedom), Some(1));
    group.bench_function("holding_torques/12_links", |b| {
        b.iter(|| black_box(&chain).holding_torques(black_box(&q), None, HoldingChoice::Least));
    });
    group.finish();
    runs(c);
}

/// A body on two sloped feet.
fn body() -> Posture {
    let foot = |x, slope| Contact { friction: 0.5, ..Contact::at(x, 0.0).on_slope(slope) };
    Posture::new(PostureFields {
        mass: 2.0,
        gyration_radius: 0.4,
        center_of_mass: [0.05, 0.4],
        contacts: vec![foot(-0.5, 0.1), foot(0.5, -0.2)],
        restitution: 0.4,
        ..PostureFields::default()
    })
    .unwrap_or_else(|e| panic!("{e}"))
}

/// A trunk of 10 kg on two legs under the torques that hold it.
fn biped() -> Mechanism {
    let leg = Link::uniform(1.0, 1.0);
    let hip = Joint { parent: Some(1), at: Some(0.0), angle: -FRAC_PI_2, ..Joint::torque() };
    let foot = |link, slope| Foot { slope, friction: 0.6, ..Foot::of_link(link) };
    let mut fields = ChainFields {
        links: vec![Link { center: Some(0.0), ..Link::uniform(10.0, 1.0) }, leg, leg],
        joints: vec![hip; 2],
        feet: vec![foot(2, 0.3), foot(3, -0.25)],
        restitution: 0.4,
        ..ChainFields::default()
    };
    let q = [0.0, 0.0, 0.1, -0.5, 0.6];
    let chain = Chain::new(fields.clone()).unwrap_or_else(|e| panic!("{e}"));
    let held =
        chain.holding_torques(&q, None, HoldingChoice::Least).unwrap_or_else(|e| panic!("{e}"));
    for (joint, torque) in fields.joints.iter_mut().zip(held.iter().flat_map(|held| &held.torques))
    {
        joint.torque = *torque;
    }
    let chain = Chain::new(fields).unwrap_or_else(|e| panic!("{e}"));
    chain.mechanism(&q).unwrap_or_else(|e| panic!("{e}"))
}

fn runs(c: &mut Criterion) {
    let mut group = c.benchmark_group("mechanism");
    let posture = body();
    let mechanism = Mechanism::of_posture(&posture).unwrap_or_else(|e| panic!("{e}"));
    let start = State::new([0.0, 0.01, 0.003], [0.1, 0.0, 0.2]);
    for (name, impact) in [("newton", Impact::Newton), ("poisson", Impact::Poisson)] {
        let options = Options { model: Model::Local, impact, record: false, ..Options::default() };
        let one = || simulate(black_box(&posture), &start, &options);
        let two = || {
            let (q, qdot) = (start.q.as_slice(), start.qdot.as_slice());
            simulate_mechanism(black_box(&mechanism), q, qdot, &options)
        };
        let ended = [one(), two()].map(|run| run.unwrap_or_else(|e| panic!("{e}")));
        assert!(ended.iter().all(|run| run.outcome() == Outcome::Rest), "{name}");
        assert!((ended[0].time() - ended[1].time()).abs() < 1e-12, "{name}");
        group.bench_function(format!("run/{name}/posture"), |b| b.iter(one));
        group.bench_function(format!("run/{name}/mechanism"), |b| b.iter(two));
    }
    let biped = biped();
    let options = Options { impact: Impact::Poisson, record: false, ..Options::default() };
    let run = || {
        simulate_mechanism(black_box(&biped), &[0.0, 0.01, 0.0, 0.001, 0.0], &[0.0; 5], &options)
    };
    let ended = run().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(ended.outcome(), Outcome::Rest);
    group.bench_function("run/biped", |b| b.iter(run));

    let verdict = || mechanism_stability(black_box(&biped), &StabilityOptions::default());
    let found = verdict().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(found.reason(), Some(WhyUndecided::Joints));
    group.bench_function("stability/biped", |b| b.iter(verdict));
    group.bench_function("stability/posture", |b| b.iter(|| stability(black_box(&posture))));
    group.bench_function("stability/mechanism", |b| {
        b.iter(|| mechanism_stability(black_box(&mechanism), &StabilityOptions::default()));
    });
    group.finish();
}

criterion_group!(benches, mechanism);
criterion_main!(benches);
