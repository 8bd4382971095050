//! Many runs at once give the same bits as single runs, with any number of threads.

use std::sync::atomic::{AtomicUsize, Ordering};

use standfast::body::Lamina;
use standfast::excitation::Excitation;
use standfast::options::Impact;
use standfast::outcome::End;
use standfast::simulate::{Resources, simulate_many_until};
use standfast::{
    Contact, Error, Model, Options, Posture, PostureFields, State, Stop, Trajectory, simulate,
    simulate_many,
};

/// Numbers in [0, 1): a Weyl sequence.
struct Weyl(f64);

impl Weyl {
    fn next(&mut self) -> f64 {
        self.0 = (self.0 + 0.618_033_988_749_894_9) % 1.0;
        self.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Scenes with short, long and endless clattering.
fn scenes(count: usize) -> (Vec<Posture>, Vec<State>) {
    let mut w = Weyl(0.1);
    (0..count)
        .map(|k| {
            let e = if k % 3 == 0 { w.between(0.0, 0.6) } else { w.between(0.8, 0.998) };
            let slope = if k % 4 == 0 { 0.0 } else { 0.1 };
            let friction = if k % 2 == 0 { 0.0 } else { 0.4 };
            let foot =
                |x: f64, slope: f64| Contact { friction, ..Contact::at(x, 0.0) }.on_slope(slope);
            let posture = Posture::new(PostureFields {
                mass: 1.0,
                gyration_radius: w.between(0.1, 0.6),
                center_of_mass: [w.between(-0.1, 0.1), w.between(0.0, 0.2)],
                contacts: vec![foot(-0.5, -slope), foot(0.5, slope)],
                restitution: e,
                gravity: 9.81,
                ..PostureFields::default()
            });
            let height = 10_f64.powf(w.between(-5.0, -1.0));
            let turn = w.between(-0.9, 0.9) * height;
            let spin = if k % 5 == 0 { w.between(-9.0, 9.0) } else { 0.0 };
            let state = State::new([0.0, height, turn], [0.0, 0.1 * height, spin * height]);
            (posture.unwrap(), state)
        })
        .unzip()
}

/// Boxes, and bodies with a concave corner, that fall on stairs and on a pin: corners of the ground meet their sides.
fn scenes_with_sides(count: usize) -> (Vec<Posture>, Vec<State>) {
    let mut w = Weyl(0.3);
    let stairs: Vec<[f64; 2]> = [[-200.0, 0.0], [0.0, 0.0], [0.0, -0.3], [0.5, -0.3]]
        .into_iter()
        .chain([[0.5, -0.6], [1.0, -0.6], [1.0, -0.9], [200.0, -0.9]])
        .collect();
    let pin = vec![[-200.0, -1.0], [-0.01, -1.0], [0.0, 0.0], [0.01, -1.0], [200.0, -1.0]];
    (0..count)
        .map(|k| {
            let (a, b) = (w.between(0.2, 1.0), w.between(0.2, 1.0));
            let shape = match k % 2 {
                0 => vec![[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]],
                _ => vec![
                    [0.0, 0.0],
                    [0.3 * a, 0.0],
                    [0.3 * a, 0.5 * b],
                    [a, 0.5 * b],
                    [a, b],
                    [0.0, b],
                ],
            };
            let vertices: Vec<[f64; 2]> = shape.iter().map(|[x, y]| [*x, y + 2.0]).collect();
            let posture = Posture::polygon(
                &vertices,
                &Lamina {
                    friction: w.between(0.0, 0.8),
                    restitution: w.between(0.0, 0.6),
                    terrain: if k % 3 == 0 { pin.clone() } else { stairs.clone() },
                    ..Lamina::default()
                },
            );
            let (x, turn) = (w.between(-0.8, 0.8), w.between(-3.0, 3.0));
            let q = [x, w.between(0.0, 0.5), turn];
            (posture.unwrap(), State::new(q, [w.between(-1.0, 1.0), 0.0, w.between(-5.0, 5.0)]))
        })
        .unzip()
}

/// Discs alone and beside each other, on level ground and in a groove.
fn scenes_with_discs(count: usize) -> (Vec<Posture>, Vec<State>) {
    let mut w = Weyl(0.7);
    (0..count)
        .map(|k| {
            let disc = |w: &mut Weyl, x: f64| {
                let (y, radius) = (if k % 3 == 0 { 3.0 } else { 0.0 }, w.between(0.05, 0.3));
                let friction = if k % 2 == 0 { 0.0 } else { 0.4 };
                Contact { friction, ..Contact::around([x, y + radius], radius) }
            };
            let contacts = match k % 4 {
                0 => vec![disc(&mut w, 0.0)],
                _ => vec![disc(&mut w, -0.5), disc(&mut w, 0.5)],
            };
            let height = if k % 3 == 0 { 3.0 } else { 0.0 };
            let groove = vec![[-9.0, 2.0], [0.0, 0.0], [9.0, 2.0]];
            let posture = Posture::new(PostureFields {
                mass: 1.0,
                gyration_radius: w.between(0.4, 0.8),
                center_of_mass: [w.between(-0.2, 0.2), height + w.between(0.2, 0.4)],
                contacts,
                restitution: w.between(0.0, 0.8),
                gravity: 9.81,
                terrain: if k % 3 == 0 { groove } else { Vec::new() },
                ..PostureFields::default()
            });
            let state = State::new(
                [0.0, w.between(0.05, 0.15), w.between(-0.03, 0.03)],
                [w.between(-1.0, 1.0), 0.0, w.between(-3.0, 3.0)],
            );
            (posture.unwrap(), state)
        })
        .unzip()
}

fn bits(end: &End) -> Vec<u64> {
    let zeno = end.zeno.map_or(vec![], |zeno| vec![zeno.time, zeno.elapsed, zeno.count as f64]);
    let state = end.state.q.iter().chain(&end.state.qdot).copied();
    let numbers = [end.time, end.elapsed, end.collisions as f64].into_iter().chain(state);
    numbers.chain(zeno).map(f64::to_bits).collect()
}

/// The ends of runs that nothing kicks or stops, on this number of threads.
fn ends(postures: &[Posture], states: &[State], options: &Options, threads: usize) -> Vec<End> {
    let (nothing, resources) = ([Excitation::default()], Resources { threads });
    simulate_many_until(postures, states, options, &nothing, resources, &|| false).unwrap()
}

#[test]
fn a_run_is_the_same_in_any_company() {
    let (postures, states) = scenes(300);
    let (mut long, mut through) = (0, 0);
    for model in [Model::Local, Model::Full, Model::Auto] {
        for stop in [Stop::Rest, Stop::Zeno] {
            let options = Options {
                model,
                stop,
                event_limit: 20_000,
                time_limit: Some(3.0),
                ..Options::default()
            };
            let many = |threads| ends(&postures, &states, &options, threads);
            let by_one = many(1);
            for threads in [2, 3, 7] {
                let ends = many(threads);
                for (one, other) in ends.iter().zip(&by_one) {
                    assert_eq!(bits(one), bits(other), "{threads} threads");
                }
            }
            for (k, end) in by_one.iter().enumerate() {
                let run = simulate(&postures[k], &states[k], &options).unwrap();
                let zeno = run.zeno_points().first();
                assert_eq!(run.outcome(), end.outcome, "{k}");
                assert_eq!(run.elapsed().to_bits(), end.elapsed.to_bits(), "{k}");
                assert_eq!(run.state(), &end.state, "{k}");
                assert_eq!(run.collisions(), end.collisions, "{k}");
                assert_eq!(zeno.map(|z| z.elapsed), end.zeno.map(|z| z.elapsed), "{k}");
                assert_eq!(zeno.map(|z| z.contacts.len()), end.zeno.map(|z| z.count));
                // Without a record a run does not know how much its end depends on its start.
                let bare = Options { record: false, ..options };
                let bare = simulate(&postures[k], &states[k], &bare).unwrap();
                assert_eq!(!bare.warnings().is_empty(), end.warned, "{k}");
                let closed = run.gaps().into_iter().enumerate().filter(|(_, gap)| *gap == 0.0);
                let touching = end.touching.iter().map(|contact| contact.index());
                assert!(touching.eq(closed.map(|(i, _)| i)), "{k}");
                long += usize::from(end.collisions > 200);
                through += usize::from(end.zeno.is_some());
            }
        }
    }
    assert!(long > 200 && through > 600, "{long} {through}: too few long runs or sums");
}

#[test]
fn sides_and_discs_are_the_same_in_any_company() {
    for (postures, states) in [scenes_with_sides(60), scenes_with_discs(60)] {
        let mut sides = 0;
        for impact in [Impact::Newton, Impact::Poisson, Impact::Moreau] {
            let options = Options {
                model: Model::Full,
                impact,
                event_limit: 5_000,
                time_limit: Some(1.5),
                ..Options::default()
            };
            let many = |threads| ends(&postures, &states, &options, threads);
            let by_one = many(1);
            for threads in [2, 5] {
                for (one, other) in many(threads).iter().zip(&by_one) {
                    assert_eq!(bits(one), bits(other), "{threads} threads");
                    assert_eq!(one.touching, other.touching);
                }
            }
            for (k, end) in by_one.iter().enumerate() {
                for record in [true, false] {
                    let options = Options { record, ..options };
                    let run = simulate(&postures[k], &states[k], &options).unwrap();
                    assert_eq!(run.outcome(), end.outcome, "{k}");
                    assert_eq!(run.elapsed().to_bits(), end.elapsed.to_bits(), "{k}");
                    assert_eq!(run.state(), &end.state, "{k}");
                    assert_eq!(run.collisions(), end.collisions, "{k}");
                    sides += usize::from(run.contacts().len() > postures[k].contacts().len());
                }
            }
        }
        let round = postures[0].contacts()[0].radius > 0.0;
        assert!(round || sides > 60, "{sides}: too few runs with sides");
    }
}

#[test]
fn the_first_wrong_start_is_named() {
    let rod = Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() },
    )
    .unwrap();
    let mut states = vec![State::at_rest([0.0, 0.01, 0.0]); 3000];
    states[2000].q.y = -1.0;
    states[1234].q.x = f64::NAN;
    for model in [Model::Local, Model::Full, Model::Auto] {
        let options = Options { model, ..Options::default() };
        let error = simulate_many(std::slice::from_ref(&rod), &states, &options).unwrap_err();
        let Error::At { place, error } = error else { panic!("{error}") };
        assert_eq!(place, "run 1234");
        assert!(error.to_string().starts_with("q.x = NaN"), "{error}");
    }
    let two = [rod.clone(), rod];
    let error = simulate_many(&two, &states, &Options::default()).unwrap_err().to_string();
    assert!(error.contains("one for each of the 3000 states"), "{error}");
    assert_eq!(simulate_many(&two[..1], &[], &Options::default()).unwrap(), vec![]);
}

#[test]
fn runs_are_stopped_at_once() {
    let rod = [Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.2), restitution: 0.999, ..Lamina::default() },
    )
    .unwrap()];
    let states = vec![State::at_rest([0.0, 0.01, 0.001]); 10_000];
    for model in [Model::Local, Model::Full, Model::Auto] {
        let options = Options { model, ..Options::default() };
        let asked = AtomicUsize::new(0);
        let cancel = || asked.fetch_add(1, Ordering::Relaxed) == 2;
        for threads in [1, 2] {
            asked.store(0, Ordering::Relaxed);
            let resources = Resources { threads };
            let ends = simulate_many_until(
                &rod,
                &states,
                &options,
                &[Excitation::default()],
                resources,
                &cancel,
            );
            assert_eq!(ends, Err(Error::Cancelled), "{model:?}");
            // A single thread does not call `cancel` again after it has returned true.
            assert!(threads > 1 || asked.load(Ordering::Relaxed) == 3, "{model:?} {asked:?}");
        }
    }
}

#[test]
fn nothing_depends_on_the_record() {
    // Limits that cut the bounces of one contact at a random part of the time until its rest.
    let mut weyl = Weyl(0.1);
    let mut share = || weyl.next();
    for case in 0..400 {
        let slope = if case % 2 == 0 { 0.0 } else { 0.4 * share() };
        let feet = [Contact { slope, ..Contact::at(0.0, 0.0) }, Contact::at(1.0, 0.0)];
        let posture = Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.2 + 0.3 * share(),
            center_of_mass: [0.3 * share(), 0.3],
            contacts: feet[..1 + case % 3 / 2].to_vec(),
            restitution: 0.5 + 0.45 * share(),
            gravity: 9.81,
            ..PostureFields::default()
        })
        .unwrap();
        let state = State::new([0.0, 0.02 * share(), 0.0], [0.0, -share(), 0.0]);
        for model in [Model::Local, Model::Full, Model::Auto] {
            let end = 0.6 * share();
            let limits = [(Some(end), 1_000_000), (None, (9.0 * share()) as usize)];
            for (time_limit, event_limit) in limits {
                let options = Options { model, time_limit, event_limit, ..Options::default() };
                let one = simulate(&posture, &state, &options).unwrap();
                let two =
                    simulate(&posture, &state, &Options { record: false, ..options }).unwrap();
                let facts = |run: &Trajectory| {
                    (run.outcome(), run.elapsed(), *run.state(), run.collisions())
                };
                assert_eq!(facts(&one), facts(&two), "{case} {model:?} {time_limit:?}");
            }
        }
    }
}
