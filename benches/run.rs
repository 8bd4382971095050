//! Whole runs, from the posture to the outcome, and verdicts. Each answer is checked before it is timed.
//!
//! The time includes dropping the trajectory. Alternatives share a parent: `run/rod/rest/{local,full,auto}`. Rods
//! inside the bound of clattering convergence come to rest by a closed sum; between the bounds and below them a growing
//! part of the accumulation is simulated. `tail/bounce/closed` is a whole run of a local model with a closed sum; `tail/bounce/plain` is
//! the bare loop that adds the flights of its bounces. `certify/…/{plain,proved}` are the same run without and with proved bounds.
//! `stability/{conditions,verdict}` are questions about one posture.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use standfast::body::{LocalModel, LocalModelFields, LocalState};
use standfast::simulate::simulate_local;
use standfast::stability::{Argument, Stability, conditions};
use standfast::{
    Contact, Impact, Lamina, Model, Options, Outcome, Posture, PostureFields, State, Stop,
    simulate, stability,
};

const MODELS: [(Model, &str); 3] =
    [(Model::Local, "local"), (Model::Full, "full"), (Model::Auto, "auto")];

fn rod(gyration_radius: f64, restitution: f64, friction: f64) -> Posture {
    Posture::rod(
        0.5,
        &Lamina {
            gyration_radius: Some(gyration_radius),
            restitution,
            friction,
            ..Lamina::default()
        },
    )
    .unwrap_or_else(|e| panic!("{e}"))
}

/// Both ends above the floor, one higher than the other.
fn dropped() -> State {
    State::at_rest([0.0, 0.011, 0.002_f64.asin()])
}

fn runs(c: &mut Criterion) {
    let mut group = c.benchmark_group("run");
    let scenes = [
        ("ball", ball(), State::at_rest([0.0, 1.0, 0.0])),
        ("rod", rod(0.2, 0.1, 0.0), dropped()),
        ("rod_between", rod(0.2, 0.7, 0.0), dropped()),
        ("rod_below", rod(0.2, 0.95, 0.0), dropped()),
        ("nested", rod(0.5 / 3_f64.sqrt(), 0.5, 0.0), dropped()),
        ("sliding", rod(0.2, 0.1, 0.5), State::new([0.0; 3], [1.0, 0.0, 0.0])),
    ];
    for (name, posture, start) in &scenes {
        for stop in [Stop::Zeno, Stop::Rest] {
            for (model, of) in MODELS {
                let impact = Impact::Newton;
                let options = Options { model, impact, stop, record: false, ..Options::default() };
                let run = || simulate(black_box(posture), start, &options);
                let ended = run().unwrap_or_else(|e| panic!("{e}"));
                let due = if stop == Stop::Zeno { Outcome::Zeno } else { Outcome::Rest };
                assert_eq!(ended.outcome(), due, "{name} {of}");
                assert!(model == Model::Auto || ended.model() == model, "{name} {of}");
                let path = format!("{name}/{}", if stop == Stop::Zeno { "zeno" } else { "rest" });
                group.bench_function(BenchmarkId::new(path, of), |b| b.iter(run));
            }
        }
    }
    let recorded = Options { model: Model::Full, ..Options::default() };
    let run = || simulate(black_box(&scenes[1].1), &scenes[1].2, &recorded);
    let ended = run().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((ended.outcome(), ended.model()), (Outcome::Rest, Model::Full));
    assert!(!ended.impacts().is_empty());
    group.bench_function(BenchmarkId::new("rod/rest", "full_recorded"), |b| b.iter(run));
    group.finish();
}

fn ball() -> Posture {
    Posture::new(PostureFields {
        mass: 1.0,
        gyration_radius: 0.4,
        center_of_mass: [0.0, 0.1],
        contacts: vec![Contact::at(0.0, 0.0)],
        restitution: 0.8,
        gravity: 9.81,
        ..PostureFields::default()
    })
    .unwrap_or_else(|e| panic!("{e}"))
}

/// Largest difference of the two sums of a tail, in s: about a hundred additions of times below 1 s, each rounded to 1e-16 s.
const SUM_ROUNDING: f64 = 1e-14;

/// Bounces of one contact, summed in closed form and one by one until they are below the rounding of the time.
fn tails(c: &mut Criterion) {
    let mut group = c.benchmark_group("tail");
    let (g, e) = (9.81, 0.8);
    let model = LocalModel::new(LocalModelFields {
        gravity: [g; 2],
        psi: [0.3; 2],
        restitution: [e; 2],
        ..LocalModelFields::default()
    });
    let model = model.unwrap_or_else(|e| panic!("{e}"));
    let options = Options { stop: Stop::Zeno, record: false, ..Options::default() };
    let closed = || {
        simulate_local(
            &model,
            &LocalState {
                gaps: black_box([0.0, 10.0]),
                rates: [1.0, 0.0],
                ..LocalState::default()
            },
            &options,
        )
    };
    let plain = || {
        let (mut t, mut u) = (0.0, black_box(1.0));
        while u > f64::EPSILON * g {
            t += 2.0 * u / g;
            u *= e;
        }
        t
    };
    let exact = closed().unwrap_or_else(|e| panic!("{e}")).elapsed();
    assert!((exact - plain()).abs() < SUM_ROUNDING, "{exact} {}", plain());
    group.bench_function("bounce/closed", |b| b.iter(closed));
    group.bench_function("bounce/plain", |b| b.iter(plain));
    group.finish();
}

/// The same runs up to their Zeno points, without and with proved bounds of all times.
fn enclosures(c: &mut Criterion) {
    let mut group = c.benchmark_group("certify");
    for (name, gyration_radius, restitution) in
        [("rod", 0.2, 0.1), ("near_the_bound", 0.2, 0.16), ("bouncy", 0.05, 0.6)]
    {
        let rod = rod(gyration_radius, restitution, 0.0);
        for (certify, of) in [(false, "plain"), (true, "proved")] {
            let (model, stop, record) = (Model::Local, Stop::Zeno, false);
            let options = Options { model, stop, record, certify, ..Options::default() };
            let run = || simulate(black_box(&rod), &dropped(), &options);
            let ended = run().unwrap_or_else(|e| panic!("{e}"));
            assert_eq!((ended.outcome(), ended.model()), (Outcome::Zeno, Model::Local), "{name}");
            let proved = ended.enclosure().and_then(|enclosure| enclosure.zeno.as_ref());
            assert_eq!(proved.is_some(), certify, "{name}");
            if let Some(zeno) = proved {
                let (t, bounds) = (ended.elapsed(), zeno.elapsed);
                assert!(bounds.low <= t && t <= bounds.high, "{name}: {t} {bounds:?}");
            }
            group.bench_function(BenchmarkId::new(name, of), |b| b.iter(run));
        }
    }
    group.finish();
}

/// Two feet on steep slopes, for which only the corner map decides.
fn steep_feet() -> Posture {
    let foot = |x, y, slope| Contact { friction: 0.89, ..Contact::at(x, y).on_slope(slope) };
    Posture::new(PostureFields {
        gyration_radius: 0.38,
        center_of_mass: [0.58, 0.95],
        contacts: vec![foot(-1.0, 0.0, -0.31), foot(1.0, 0.25, 1.16)],
        restitution: 0.05,
        ..PostureFields::default()
    })
    .unwrap_or_else(|e| panic!("{e}"))
}

/// `stability/{conditions,verdict}/…`: the conditions in closed form, and the whole verdict with its bound of the amplification, for
/// postures that are stable by different arguments.
fn verdicts(c: &mut Criterion) {
    let mut group = c.benchmark_group("stability");
    for (name, posture, by) in [
        ("rod", rod(0.2, 0.1, 0.5), Argument::Theorem3),
        ("nested", rod(0.28, 0.5, 0.5), Argument::Neutral),
        ("steep_feet", steep_feet(), Argument::CornerMap),
    ] {
        let found = conditions(&posture).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(found.theorem_3(), by == Argument::Theorem3, "{name}");
        let verdict = stability(&posture).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((verdict.frictional_stability, verdict.by), (Stability::Stable, Some(by)));
        assert_eq!(verdict.conditions, Some(found), "{name}");
        group.bench_function(BenchmarkId::new("conditions", name), |b| {
            b.iter(|| conditions(black_box(&posture)));
        });
        group.bench_function(BenchmarkId::new("verdict", name), |b| {
            b.iter(|| stability(black_box(&posture)));
        });
    }
    group.finish();
}

criterion_group!(benches, runs, tails, enclosures, verdicts);
criterion_main!(benches);
