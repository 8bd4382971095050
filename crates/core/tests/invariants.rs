//! Invariants that hold for all parameters, on seeded random bodies and states at scales 1e-6 … 1e6 in length and time.
//!
//! Every tolerance is a number of rounding errors of the largest quantity involved: see [`Yardstick`].

use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use standfast::body::{LocalModel, LocalModelFields, LocalState};
use standfast::options::Simultaneous;
use standfast::outcome::ZenoPoint;
use standfast::simulate::simulate_local;
use standfast::{
    Contact, Error, Lamina, Model, Options, Outcome, Posture, PostureFields, State, Stop,
    Trajectory, simulate,
};

const EPS: f64 = f64::EPSILON;

/// Number of random cases of the ordinary run; the long campaign has [`CAMPAIGN`] times as many.
const CASES: u32 = 1000;
const CAMPAIGN: u32 = 100;

/// Runs `check` on `cases` seeded random values of `strategy`; a failure is shrunk and printed.
fn always<S: Strategy>(seed: u64, cases: u32, strategy: S, check: impl Fn(&S::Value)) {
    let config = ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed),
        max_shrink_iters: 4000,
        ..ProptestConfig::default()
    };
    let checked = TestRunner::new(config).run(&strategy, |value| {
        check(&value);
        Ok(())
    });
    if let Err(failure) = checked {
        panic!("{failure}");
    }
}

/// A body, its start and the options of its run.
#[derive(Debug, Clone)]
struct Scene {
    fields: PostureFields,
    state: State,
    options: Options,
}

impl Scene {
    fn posture(&self) -> Posture {
        Posture::new(self.fields.clone()).unwrap()
    }

    fn run(&self) -> Trajectory {
        self.run_with(&self.options)
    }

    fn run_with(&self, options: &Options) -> Trajectory {
        simulate(&self.posture(), &self.state, options).unwrap()
    }

    /// All lengths times `length`, all times times `time`.
    fn in_units(&self, length: f64, time: f64) -> Self {
        let mut scene = self.clone();
        let f = &mut scene.fields;
        f.gyration_radius *= length;
        f.gravity *= length / time / time;
        for x in &mut f.center_of_mass {
            *x *= length;
        }
        for contact in &mut f.contacts {
            contact.point = contact.point.map(|x| x * length);
        }
        let (q, v) = (&mut scene.state.q, &mut scene.state.qdot);
        (q.x, q.y) = (q.x * length, q.y * length);
        (v.x, v.y, v.z) = (v.x * length / time, v.y * length / time, v.z / time);
        let o = &mut scene.options;
        o.time *= time;
        o.time_limit = o.time_limit.map(|limit| limit * time);
        scene
    }

    fn mirrored(&self) -> Self {
        let mut scene = self.clone();
        scene.fields.center_of_mass[0] *= -1.0;
        for contact in &mut scene.fields.contacts {
            contact.point[0] *= -1.0;
            contact.slope *= -1.0;
        }
        for v in [&mut scene.state.q, &mut scene.state.qdot] {
            (v.x, v.z) = (-v.x, -v.z);
        }
        scene
    }
}

/// Relative change of the couplings over the last moments of an accumulation, in which the full model freezes its
/// geometry. It affects the last rates, not the *time*.
const FROZEN: f64 = 1e-6;

/// Restitution, including values near both ends of its range.
fn restitution() -> impl Strategy<Value = f64> {
    prop_oneof![
        1 => Just(0.0),
        6 => 0.0..0.95,
        1 => (-6.0..-1.0).prop_map(|x: f64| 1.0 - 10f64.powf(x)),
        1 => (-12.0..-1.0).prop_map(|x: f64| 10f64.powf(x)),
    ]
}

fn contact() -> impl Strategy<Value = Contact> {
    (
        [-1.0..1.0, -1.0..1.0],
        prop_oneof![1 => Just(0.0), 2 => -1.2..1.2],
        prop_oneof![2 => Just(None), 1 => restitution().prop_map(Some)],
    )
        .prop_map(|([x, y], slope, restitution)| Contact {
            restitution,
            ..Contact::at(x, y).on_slope(slope)
        })
}

/// Radius of gyration. Impacts of slimmer bodies amplify every rounding error by (size/ρ)², so their gaps and q lose
/// agreement.
fn gyration() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.1..1.5, 1 => (-1.3..3.0).prop_map(|x: f64| 10f64.powf(x))]
}

fn body() -> impl Strategy<Value = PostureFields> {
    (
        (-3.0..3.0).prop_map(|x: f64| 10f64.powf(x)),
        gyration(),
        [-0.5..0.5, -0.5..1.5],
        prop_oneof![
            1 => proptest::collection::vec(contact(), 1),
            8 => proptest::collection::vec(contact(), 2),
        ],
        restitution(),
        prop_oneof![1 => Just(0.0), 6 => 0.3..3.0],
    )
        .prop_map(|(mass, gyration_radius, center_of_mass, contacts, restitution, gravity)| {
            PostureFields {
                mass,
                gyration_radius,
                center_of_mass,
                contacts,
                restitution,
                gravity,
                ..PostureFields::default()
            }
        })
}

/// Bodies of size 1 under gravity 1, starting above the terrain or touching it.
fn scene() -> impl Strategy<Value = Scene> {
    let spin = prop_oneof![2 => Just(0.0), 5 => -3.0..3.0, 1 => -60.0..60.0];
    let lift = prop_oneof![
        1 => Just(0.0),
        1 => (-8.0..0.0).prop_map(|x: f64| 10f64.powf(x)),
        2 => 0.0..1.0
    ];
    (
        body(),
        (-0.5..0.5, prop_oneof![1 => Just(0.0), 3 => -0.6..0.6, 1 => -3.0..3.0], lift),
        prop_oneof![1 => Just([0.0; 2]), 3 => [-2.0..2.0, -2.0..2.0]],
        spin,
        prop_oneof![Just(Model::Auto), Just(Model::Local), Just(Model::Full)],
        prop_oneof![3 => Just(Simultaneous::Together), 1 => Just(Simultaneous::FirstContactFirst),
            1 => Just(Simultaneous::LastContactFirst)],
        prop_oneof![Just(None), (0.0..8.0).prop_map(Some)],
    )
        .prop_map(|(fields, (x, theta, lift), [vx, vy], omega, model, simultaneous, limit)| {
            let stop = if limit.is_some() { Stop::Time } else { Stop::Rest };
            let options = Options {
                model,
                simultaneous: Some(simultaneous),
                stop,
                time_limit: limit,
                event_limit: 1000,
                ..Options::default()
            };
            let state = start(&fields, model, [x, theta], lift, [vx, vy, omega]);
            Scene { fields, state, options }
        })
}

/// The start at this position and rotation, raised by `lift` from the height at which the first contact touches.
fn start(
    fields: &PostureFields,
    model: Model,
    [x, theta]: [f64; 2],
    lift: f64,
    v: [f64; 3],
) -> State {
    let posture = Posture::new(fields.clone()).unwrap();
    let q = State::new([x, 0.0, theta], v);
    let gaps = match model {
        Model::Local => local_gaps(&posture, &q),
        _ => posture.gaps(&q.q),
    };
    let y = gaps
        .iter()
        .zip(posture.contacts())
        .map(|(gap, contact)| -gap / contact.normal().y)
        .fold(f64::NEG_INFINITY, f64::max);
    State::new([x, y + lift, theta], v)
}

/// Gaps N·q of the local model, with rows frozen at q = 0.
fn local_gaps(posture: &Posture, state: &State) -> Vec<f64> {
    let zero = standfast::Vector3::new(0.0, 0.0, 0.0);
    posture.gap_rates(&zero, &state.q)
}

/// The same bodies in other units.
fn scaled_scene() -> impl Strategy<Value = Scene> {
    let scale = || (-6.0..6.0).prop_map(|x: f64| 10f64.powf(x));
    (scene(), scale(), scale()).prop_map(|(scene, length, time)| scene.in_units(length, time))
}

fn model_gaps(run: &Trajectory, state: &State) -> Vec<f64> {
    let posture = run.posture().unwrap();
    match run.model() {
        Model::Local => local_gaps(posture, state),
        _ => posture.gaps(&state.q),
    }
}

/// The largest quantities of a run; rounding errors are `EPS` times these.
///
/// Positions are sums of q̇₀t, gt²/2 and the paths of the impulses, so their rounding error is that of the largest of
/// these, at most once per collision.
struct Yardstick {
    speed: f64,
    length: f64,
    energy: f64,
    roundings: f64,
}

/// What the error says about a time in a summed tail with too many collisions before it.
const REFUSED: &str = "fewer collisions of a summed tail";

impl Yardstick {
    /// `None`: the collisions of a summed tail are too many to be followed to a time in it, which `at` says.
    fn of(run: &Trajectory, start: &State) -> Option<Self> {
        let posture = run.posture().unwrap();
        let (f, t, size) = (posture.fields(), run.elapsed(), posture.size());
        let v = &start.qdot;
        let impulses: f64 = run.impacts().iter().map(|i| i.impulse[1].abs() / f.mass).sum();
        let mut spin = v.z.abs();
        let zeno =
            run.zeno_points().iter().map(|point| point.time.next_down().max(run.options().time));
        for t in run.sample_times(120).unwrap().into_iter().chain(zeno) {
            match run.at(t) {
                Ok(now) => spin = spin.max(now.state.qdot.z.abs()),
                Err(error) => {
                    assert!(error.to_string().contains(REFUSED));
                    return None;
                }
            }
        }
        let gravity = f.gravity + size * spin * spin;
        let speed = v.x.hypot(v.y)
            + size * spin
            + f.gravity * t
            + (2.0 * f.gravity * size).sqrt()
            + impulses;
        let q = &start.q;
        // The angle ωt is rounded. An impact turns this error into a rate error of ω|d| times it, and so into a
        // displacement. A change of ω by one ulp has the same effect.
        let turned = size * (spin * t).powi(2);
        let length = size * (1.0 + q.z.abs()) + q.x.hypot(q.y) + speed * t + turned;
        let slim = (size / f.gyration_radius).powi(2).max(1.0);
        // A flywheel: its gaps fall almost equally, and their small difference has a large relative error.
        let apart = |p: &[f64; 2], q: &[f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
        let points = || f.contacts.iter().map(|contact| contact.point);
        let lever = points().flat_map(|p| points().map(move |q| apart(&p, &q))).fold(0.0, f64::max);
        let heavy = if lever > 0.0 { (f.gyration_radius / lever).powi(2).max(1.0) } else { 1.0 };
        Some(Self {
            speed,
            length,
            energy: f.mass * (speed * speed + gravity * length),
            roundings: EPS
                * slim.min(1e4)
                * heavy.min(1e12)
                * (64.0 + 8.0 * run.impacts().len() as f64),
        })
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|x| x.to_bits()).collect()
}

/// All results of a run other than its record, as bits.
fn digest(run: &Trajectory) -> (Outcome, Vec<u64>, usize) {
    let mut all = vec![run.time(), run.elapsed()];
    all.extend(run.state().q.iter());
    all.extend(run.state().qdot.iter());
    all.extend(run.gaps());
    all.extend(run.rates());
    for zeno in run.zeno_points() {
        // Without a record, the error of a time does not include what rounding errors have grown to.
        all.extend([zeno.time, zeno.elapsed, zeno.contacts.len() as f64]);
        all.extend(zeno.q.iter().flatten());
        all.extend(zeno.qdot.iter().flatten());
        all.extend(&zeno.gaps);
        all.extend(&zeno.gap_rates);
    }
    (run.outcome(), bits(&all), run.zeno_points().len())
}

fn check_limits(run: &Trajectory) {
    let o = run.options();
    assert!(run.elapsed() >= 0.0 && run.time() >= o.time);
    if let Some(limit) = o.time_limit {
        assert!(run.time() <= limit + 4.0 * EPS * limit, "{} > {limit}", run.time());
        if run.outcome() == Outcome::TimeLimit {
            let offset = (run.time() - limit).abs();
            assert!(offset <= 2.0 * EPS * limit.abs(), "{} != {limit}", run.time());
        }
    }
    // The event limit does not interrupt a sequence of impacts at one instant.
    assert!(run.collisions() <= o.event_limit + 64 * 64 || run.zeno_points().len() > 60);
}

/// The error of the time of a Zeno point is at most this share of the time.
fn check_error(zeno: &ZenoPoint, share: f64) {
    let ZenoPoint { time_error, elapsed, .. } = *zeno;
    let small = time_error >= 0.0 && time_error < share * elapsed.max(1e-300);
    assert!(small || elapsed == 0.0, "{time_error} of {elapsed}");
}

fn check_times(run: &Trajectory) {
    let mut last = 0.0;
    for impact in run.impacts() {
        assert!(impact.elapsed >= last, "{} after {last}", impact.elapsed);
        last = impact.elapsed;
    }
    assert!(last <= run.elapsed());
    let mut last = 0.0;
    for zeno in run.zeno_points() {
        assert!(zeno.elapsed >= last && zeno.elapsed <= run.elapsed());
        check_error(zeno, 2.0);
        last = zeno.elapsed;
    }
    let mut last = run.options().time;
    for phase in run.phases() {
        assert!(phase.start == last && phase.end >= phase.start, "{phase:?} after {last}");
        // Impacts whose rounded time equals an end of the phase may lie on either side of it by the more accurate clock
        // of the run.
        let among = |inside: &dyn Fn(f64) -> bool| {
            run.impacts().iter().filter(|impact| inside(impact.time)).count()
        };
        let inside = among(&|t| phase.start < t && t < phase.end);
        let at_its_ends = among(&|t| t == phase.start || t == phase.end);
        assert!((inside..=inside + at_its_ends).contains(&phase.impacts), "{phase:?} {inside}");
        last = phase.end;
    }
    assert_eq!(last, run.time());
}

fn check_impacts(run: &Trajectory, yard: &Yardstick) {
    let posture = run.posture().unwrap();
    let impacts = run.impacts();
    assert!(
        impacts.len() == run.collisions() || impacts.len() >= 64,
        "{} listed of {}",
        impacts.len(),
        run.collisions()
    );
    for (k, impact) in impacts.iter().enumerate() {
        let i = impact.contact.index();
        let (before, after) = (&impact.rates_before, &impact.rates_after);
        let e = posture.contacts()[i].restitution.unwrap_or(posture.fields().restitution);
        let w = before[i];
        assert!(w <= 0.0, "{impact:?}");
        assert!((after[i] + e * w).abs() <= 16.0 * EPS * w.abs(), "Newton: {impact:?}");
        let twin = |other: Option<&standfast::outcome::ImpactRecord>| {
            other.is_some_and(|o| o.elapsed == impact.elapsed && o.contact != impact.contact)
        };
        let together = run.options().policy() == Simultaneous::Together
            && (twin(impacts.get(k + 1)) || k > 0 && twin(impacts.get(k - 1)));
        let denormal = w > -1e-290;
        if posture.contacts().len() < 2 || together || denormal {
            continue;
        }
        let j = 1 - i;
        let theta = match run.model() {
            Model::Local => 0.0,
            _ => run.at(impact.time).unwrap().state.q.z,
        };
        let psi = posture.local(theta).unwrap().psi()[i];
        let expected = before[j] + (1.0 + e) * psi * w;
        // ψ at the rotation at that time, which has a relative error of a few roundings.
        let rho = posture.fields().gyration_radius;
        let steep = (posture.size() / rho).max(1.0) * (1.0 + psi.abs());
        let frozen = if run.model() == Model::Local { 0.0 } else { FROZEN };
        let rounding = frozen + yard.roundings * steep * (1.0 + theta.abs());
        assert!(
            (after[j] - expected).abs()
                <= rounding * (before[j].abs() + w.abs() * (1.0 + psi.abs())),
            "coupling: {impact:?}, expected {expected:e}, off {:e}, allowed {:e}, e {e} psi {psi} theta {theta} n {}",
            after[j] - expected,
            rounding * (before[j].abs() + w.abs() * (1.0 + psi.abs())),
            impacts.len()
        );
    }
}

fn check_motion(run: &Trajectory, yard: &Yardstick) {
    let posture = run.posture().unwrap();
    let times = run.sample_times(120).unwrap();
    let mut energy = f64::INFINITY;
    for &t in &times {
        let now = run.at(t).unwrap();
        let e = run.energy(t).unwrap();
        assert!(
            e <= energy + yard.roundings * yard.energy,
            "energy {e} > {energy} at {t}, allowed {}",
            yard.roundings * yard.energy
        );
        energy = e;
        assert!(now.gaps.iter().all(|h| *h >= 0.0), "gaps {:?} at {t}", now.gaps);
        let true_gaps = model_gaps(run, &now.state);
        for (h, gap) in now.gaps.iter().zip(&true_gaps) {
            assert!(
                (h - gap).abs() <= yard.roundings * yard.length,
                "gap {h:e} but {gap:e} from q at {t}; allowed {:e}",
                yard.roundings * yard.length
            );
        }
        let rates = match run.model() {
            Model::Local => local_gaps(posture, &State { q: now.state.qdot, qdot: now.state.qdot }),
            _ => posture.gap_rates(&now.state.q, &now.state.qdot),
        };
        for (u, rate) in now.rates.iter().zip(&rates) {
            let at_impact = run.impacts().iter().any(|i| i.time == t);
            assert!(
                at_impact
                    || (u - rate).abs()
                        <= 64.0
                            * yard.roundings
                            * (yard.speed + yard.length * now.state.qdot.z.abs()),
                "rate {u} but {rate} at {t}"
            );
        }
    }
}

/// Positions before and after every event differ by no more than one rounding of the time causes.
fn check_continuity(run: &Trajectory, yard: &Yardstick) {
    let start = run.options().time;
    let events = run
        .impacts()
        .iter()
        .map(|i| i.time)
        .chain(run.zeno_points().iter().map(|z| z.time))
        .chain(run.phases().iter().map(|p| p.end))
        .collect::<Vec<_>>();
    for t in events.into_iter().filter(|t| *t > start).take(200) {
        let before = run.at(t.next_down()).unwrap().state.q;
        let after = run.at(t).unwrap().state.q;
        let step = t - t.next_down();
        let allowed = yard.roundings * yard.length + 4.0 * yard.speed * step;
        let size = run.posture().unwrap().size();
        let jump =
            (after.x - before.x).hypot(after.y - before.y) + size * (after.z - before.z).abs();
        assert!(jump <= allowed, "q jumps by {jump} > {allowed} at {t}: {before:?} {after:?}");
    }
}

fn check_outcome(run: &Trajectory, yard: &Yardstick) {
    let stop = run.options().stop;
    match run.outcome() {
        Outcome::Rest => {
            assert_eq!(run.state().qdot.z, 0.0);
            assert!(run.state().qdot.norm() == 0.0);
            // Without gravity a body also rests on one contact.
            let (gaps, floats) = (run.gaps(), run.posture().unwrap().fields().gravity == 0.0);
            let touches = |h: &f64| *h == 0.0;
            assert!(gaps.iter().all(touches) || floats && gaps.iter().any(touches), "{gaps:?}");
        }
        Outcome::Zeno => {
            assert_eq!(stop, Stop::Zeno);
            let zeno = &run.zeno_points()[0];
            assert_eq!(zeno.elapsed, run.elapsed());
            for contact in &zeno.contacts {
                assert_eq!(run.gaps()[contact.index()], 0.0);
                assert!(run.rates()[contact.index()].abs() <= yard.roundings * yard.speed);
            }
        }
        Outcome::TimeLimit => assert!(run.options().time_limit.is_some()),
        Outcome::Sliding => assert!(run.acceleration().is_some()),
        _ => {}
    }
}

fn check_scene(scene: &Scene) {
    let run = scene.run();
    let Some(yard) = Yardstick::of(&run, &scene.state) else { return };
    check_limits(&run);
    check_times(&run);
    check_impacts(&run, &yard);
    check_motion(&run, &yard);
    check_continuity(&run, &yard);
    check_outcome(&run, &yard);
}

/// The same bits with and without a record, from call to call, and with another initial time.
fn check_bits(scene: &Scene) {
    let run = scene.run();
    assert_eq!(digest(&run), digest(&scene.run()), "another call");
    if scene.options.time_limit.is_none() {
        let late = scene.run_with(&Options { time: 1000.0, ..scene.options });
        assert_eq!(bits(&[run.elapsed()]), bits(&[late.elapsed()]), "another clock");
        for (one, other) in run.zeno_points().iter().zip(late.zeno_points()) {
            assert_eq!(bits(&[one.elapsed]), bits(&[other.elapsed]));
        }
        let times = |run: &Trajectory| run.impacts().iter().map(|i| i.elapsed).collect::<Vec<_>>();
        assert_eq!(times(&run), times(&late));
        // Complete tails are summed identically. Tails cut by a limit may be skipped without a record.
        let unseen = scene.run_with(&Options { record: false, ..scene.options });
        assert_eq!(digest(&run), digest(&unseen), "record");
        unseen.zeno_points().iter().for_each(|zeno| check_error(zeno, 1e-6)); // of the sums alone
        assert!(unseen.at(0.0).is_err() && unseen.impacts().is_empty());
    }
}

/// The motion of a mirrored scene is the mirrored motion, bit for bit.
fn check_mirror(scene: &Scene) {
    let (run, other) = (scene.run(), scene.mirrored().run());
    let signs = [-1.0, 1.0, -1.0];
    for k in 0..3 {
        let (x, y) = (run.state(), other.state());
        assert_eq!(x.q[k], signs[k] * y.q[k]);
        assert_eq!(x.qdot[k], signs[k] * y.qdot[k]);
    }
    assert_eq!(run.outcome(), other.outcome());
    assert_eq!(bits(&[run.elapsed()]), bits(&[other.elapsed()]));
    assert_eq!(run.gaps(), other.gaps());
    assert_eq!(run.rates(), other.rates());
    assert_eq!(run.collisions(), other.collisions());
}

/// Scaling by powers of two has no rounding error: every run has the same bits.
fn check_units(scene: &Scene) {
    let run = scene.run();
    let (length, time) = (2f64.powi(-13), 2f64.powi(9));
    let other = scene.in_units(length, time).run();
    // Runs with speeds whose squares underflow, or with a smaller displacement, are left out, because the underflow depends on the units.
    let tiny = |values: &[f64]| values.iter().any(|x| *x != 0.0 && x.abs() < 1e-140);
    let fade = |run: &Trajectory| {
        let faint = run.impacts().iter().any(|i| tiny(&i.rates_after));
        let State { q, qdot } = run.state();
        faint
            || [q, qdot].iter().any(|v| tiny(v.as_slice()))
            || tiny(&run.gaps())
            || tiny(&run.rates())
    };
    if fade(&run) || fade(&other) {
        return;
    }
    assert_eq!(run.outcome(), other.outcome());
    assert_eq!(bits(&[run.elapsed() * time]), bits(&[other.elapsed()]));
    let scaled = |values: Vec<f64>, unit: f64| values.iter().map(|x| x * unit).collect::<Vec<_>>();
    assert_eq!(scaled(run.gaps(), length), other.gaps());
    assert_eq!(scaled(run.rates(), length / time), other.rates());
    assert_eq!(run.state().q.x * length, other.state().q.x);
    assert_eq!(run.state().qdot.z / time, other.state().qdot.z);
    assert_eq!(run.collisions(), other.collisions());
}

/// Results do not depend on the origin: on a dyadic grid the arms have the same bits.
fn check_origin(scene: &Scene) {
    let mut here = scene.clone();
    let grid = |x: f64| (x * 1024.0).round() / 1024.0;
    let place = |fields: &mut PostureFields, by: [f64; 2]| {
        for k in 0..2 {
            fields.center_of_mass[k] = grid(fields.center_of_mass[k]) + by[k];
            for contact in &mut fields.contacts {
                contact.point[k] = grid(contact.point[k]) + by[k];
            }
        }
    };
    place(&mut here.fields, [0.0; 2]);
    here.state.q.y += 0.25; // clear of the terrain after rounding to the grid
    let mut there = here.clone();
    place(&mut there.fields, [4096.0, -1000.0]);
    assert_eq!(digest(&here.run()), digest(&there.run()));
}

/// Results do not depend on the order of the contacts, unless they land simultaneously.
fn check_numbers(scene: &Scene) {
    if scene.fields.contacts.len() < 2 {
        return;
    }
    let mut other = scene.clone();
    other.fields.contacts.reverse();
    let (run, other) = (scene.run(), other.run());
    let ended =
        |run: &Trajectory| run.outcome() == Outcome::EventLimit || !run.warnings().is_empty();
    if ended(&run) || ended(&other) || run.collisions() > 40 {
        return; // more collisions amplify the rounding of sums in another order
    }
    let Some(yard) = Yardstick::of(&run, &scene.state) else { return };
    assert_eq!(run.outcome(), other.outcome());
    let swapped = |mut values: Vec<f64>| {
        values.reverse();
        values
    };
    let close = |x: f64, y: f64, size: f64| (x - y).abs() <= 1e-6 * size;
    assert!(close(run.elapsed(), other.elapsed(), run.elapsed()));
    for (x, y) in run.gaps().iter().zip(swapped(other.gaps())) {
        assert!(close(*x, y, yard.length), "{x} {y}");
    }
}

/// A run that is stopped by a time limit before its rest, with or without a record, has the state of the whole run at
/// that time.
fn check_cut((scene, share): &(Scene, f64)) {
    let options = Options { stop: Stop::Rest, time_limit: None, ..scene.options };
    let whole = scene.run_with(&options);
    if whole.elapsed() == 0.0 || whole.collisions() > 60 || whole.outcome() == Outcome::EventLimit {
        return;
    }
    let Some(yard) = Yardstick::of(&whole, &scene.state) else { return };
    let limit = share * whole.elapsed();
    let there = match whole.at(limit) {
        Ok(there) => there,
        Err(error) => return assert!(error.to_string().contains(REFUSED)),
    };
    for record in [true, false] {
        let cut = scene.run_with(&Options {
            stop: Stop::Time,
            time_limit: Some(limit),
            record,
            ..options
        });
        if cut.outcome() == Outcome::EventLimit {
            continue; // a recorded run lists every bounce of a cut tail
        }
        assert_eq!(cut.outcome(), Outcome::TimeLimit);
        assert!((cut.time() - limit).abs() <= 2.0 * EPS * limit, "{} {limit}", cut.time());
        for i in 0..cut.gaps().len() {
            assert!(cut.gaps()[i] >= 0.0);
            let off = (cut.gaps()[i] - there.gaps[i]).abs();
            assert!(
                off <= 1e-7 * yard.length,
                "record {record}: {:?} {:?}",
                cut.gaps(),
                there.gaps
            );
        }
        let off = cut.state().q - there.state.q;
        assert!(
            off.x.hypot(off.y) <= 1e-7 * yard.length,
            "record {record}: {:?} {:?}",
            cut.state(),
            there.state
        );
    }
}

fn cut_scene() -> impl Strategy<Value = (Scene, f64)> {
    (
        scaled_scene(),
        prop_oneof![3 => 0.0..1.0, 1 => (-9.0..-1.0).prop_map(|x: f64| 1.0 - 10f64.powf(x))],
    )
}

/// A local model given by its parameters, with a state.
#[derive(Debug, Clone)]
struct Reduced {
    model: LocalModel,
    gaps: [f64; 2],
    rates: [f64; 2],
    options: Options,
}

fn reduced() -> impl Strategy<Value = Reduced> {
    let psi = prop_oneof![
        1 => Just([0.0; 2]),
        6 => (-1.0..1.0, 0.2..5.0).prop_filter_map("ψ = 0 is a case of its own", |(x, r): (f64, f64)| {
            (x != 0.0).then_some([x * r, x / r])
        }),
        1 => (-12.0..-3.0).prop_map(|x: f64| [1.0 - 10f64.powf(x); 2]),
    ];
    let gap = || prop_oneof![1 => Just(0.0), 3 => 0.0..1.0, 1 => (-12.0..0.0).prop_map(|x: f64| 10f64.powf(x))];
    let gravity = || prop_oneof![1 => Just(0.0), 6 => 0.2..5.0];
    let scale = || (-6.0..6.0).prop_map(|x: f64| 10f64.powf(x));
    (
        [gravity(), gravity()],
        psi,
        prop_oneof![restitution().prop_map(|e| [e, e]), [restitution(), restitution()]],
        [gap(), gap()],
        [-2.0..2.0, -2.0..2.0],
        (scale(), scale()),
    )
        .prop_filter_map(
            "ψ_1ψ_2 beyond 1 by rounding",
            |(g, psi, e, h, u, (length, time))| {
                Some(Reduced {
                    model: LocalModel::new(LocalModelFields {
                        gravity: g.map(|g| g * length / time / time),
                        psi,
                        restitution: e,
                        ..LocalModelFields::default()
                    })
                    .ok()?,
                    gaps: h.map(|h| h * length),
                    rates: u.map(|u: f64| u * length / time),
                    options: Options { event_limit: 4000, ..Options::default() },
                })
            },
        )
}

/// Energy ½u·D⁻¹u + λ·h, λ = D⁻¹g, of the gaps alone, up to a constant factor, and the sum of the absolute values of
/// its terms, which is the scale of its rounding error.
fn gap_energy(m: &LocalModel, h: &[f64], u: &[f64]) -> (f64, f64) {
    let (psi, g) = (m.psi(), m.gravity());
    // D ∝ [[w_1, −s], [−s, w_2]] with s = ψ_1w_1 = ψ_2w_2.
    let (w1, w2) = if psi[0] == 0.0 { (1.0, 1.0) } else { (psi[1].abs(), psi[0].abs()) };
    let s = psi[0] * w1;
    let det = w1 * w2 - s * s;
    let inverse = [[w2 / det, s / det], [s / det, w1 / det]];
    let (mut energy, mut size) = (0.0, 0.0);
    for i in 0..2 {
        for j in 0..2 {
            for term in [0.5 * u[i] * inverse[i][j] * u[j], h[i] * inverse[i][j] * g[j]] {
                energy += term;
                size += term.abs();
            }
        }
    }
    (energy, size)
}

fn check_reduced(case: &Reduced) {
    let m = &case.model;
    let run = simulate_local(
        m,
        &LocalState { gaps: case.gaps, rates: case.rates, ..LocalState::default() },
        &case.options,
    )
    .unwrap();
    let quiet = Options { record: false, ..case.options };
    let unseen = simulate_local(
        m,
        &LocalState { gaps: case.gaps, rates: case.rates, ..LocalState::default() },
        &quiet,
    )
    .unwrap();
    assert_eq!(digest(&run).0, digest(&unseen).0);
    assert_eq!(bits(&[run.elapsed()]), bits(&[unseen.elapsed()]));
    assert_eq!(bits(&run.gaps()), bits(&unseen.gaps()));
    assert_eq!(bits(&run.rates()), bits(&unseen.rates()));
    assert!(run.gaps().iter().all(|h| *h >= 0.0));
    for impact in run.impacts() {
        let (i, j) = (impact.contact.index(), 1 - impact.contact.index());
        let (before, after, e) = (&impact.rates_before, &impact.rates_after, m.restitution());
        let w = before[i];
        let together = before.iter().all(|w| *w < 0.0)
            && (run.impacts().iter())
                .any(|o| o.elapsed == impact.elapsed && o.contact != impact.contact);
        assert!(w <= 0.0);
        // Simultaneous impacts solve a system of this condition.
        let fair = 16.0 * EPS * (w.abs() * (1.0 + m.psi()[i].abs()) + before[j].abs());
        assert!(together || (after[i] + e[i] * w).abs() <= fair, "{impact:?}");
        assert!(
            together || (after[j] - before[j] - (1.0 + e[i]) * m.psi()[i] * w).abs() <= fair,
            "{impact:?}"
        );
    }
    // Energy, from sample to sample. D is nearly singular near ψ_1ψ_2 = 1: its inverse amplifies rounding errors.
    let condition = 1.0 / (1.0 - m.psi()[0] * m.psi()[1]).max(1e-300);
    if condition < 1e6 && run.outcome() != Outcome::Escape {
        let times = run.sample_times(80).unwrap();
        let (mut last, mut most) = (f64::INFINITY, 0.0_f64);
        for t in times {
            let now = run.at(t).unwrap();
            let (energy, size) = gap_energy(m, &now.gaps, &now.rates);
            let (_, fallen) = gap_energy(m, &[0.0; 2], &m.gravity().map(|g| g * run.elapsed()));
            most = most.max(condition * (size + fallen));
            let allowed = EPS * most * (64.0 + 8.0 * run.impacts().len() as f64);
            assert!(
                energy <= last + allowed,
                "energy {energy:e} > {last:e} at {t:e} of {:e}, allowed {allowed:e}",
                run.elapsed()
            );
            last = energy;
        }
    }
}

/// A test of one invariant over ordinary cases, and one over a long campaign.
macro_rules! laws {
    ($($name:ident, $long:ident, $share:expr, $strategy:expr, $check:expr;)*) => {$(
        #[test]
        fn $name() {
            always(1, CASES / $share, $strategy, $check);
        }

        #[test]
        #[ignore = "long campaign: make long"]
        fn $long() {
            for seed in 2..2 + CAMPAIGN {
                always(u64::from(seed), CASES / $share, $strategy, $check);
            }
        }
    )*};
}

laws! {
    bodies_obey_the_laws, bodies_obey_the_laws_at_length, 1, scaled_scene(), check_scene;
    nothing_depends_on_bookkeeping, nothing_depends_on_bookkeeping_at_length, 2, scene(), check_bits;
    mirrored_worlds_move_mirrored, mirrored_worlds_move_mirrored_at_length, 2, scene(), check_mirror;
    units_do_not_matter, units_do_not_matter_at_length, 2, scene(), check_units;
    the_origin_does_not_matter, the_origin_does_not_matter_at_length, 2, scene(), check_origin;
    contact_numbers_do_not_matter, contact_numbers_do_not_matter_at_length, 2, scene(), check_numbers;
    a_cut_run_is_a_part_of_the_whole, a_cut_run_is_a_part_of_the_whole_at_length, 2, cut_scene(), check_cut;
    parameters_obey_the_laws, parameters_obey_the_laws_at_length, 1, reduced(), check_reduced;
}

#[test]
fn what_no_double_can_say_is_refused_by_name() {
    let rod = Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() },
    )
    .unwrap();
    let start = State::at_rest([0.0, 0.01, 0.001]);
    for model in [Model::Local, Model::Full, Model::Auto] {
        for (limit, fine) in [(1e149, true), (f64::INFINITY, true), (1e150, false), (1e300, false)]
        {
            let options = Options { model, time_limit: Some(limit), ..Options::default() };
            let run = simulate(&rod, &start, &options);
            assert_eq!(run.is_ok(), fine, "{limit}");
            let text = run.err().map_or_else(String::new, |error| error.to_string());
            assert_eq!(text.contains("time_limit = 1"), !fine, "{text}");
        }
        let options = Options { model, ..Options::default() };
        let turned = State::at_rest([0.0, 1.0, 2e12]);
        let run = simulate(&rod, &turned, &options);
        let refused = matches!(&run, Err(Error::OutOfRange { field, .. }) if field == "q.theta");
        assert_eq!(refused, model != Model::Local, "{run:?}");
    }
}
