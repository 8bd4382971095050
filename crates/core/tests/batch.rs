//! Many runs at once: the same bits as one by one, whatever the machine lends.

use standfast::{
    Contact, End, Error, Fields, Model, Options, Posture, Resources, State, Stop, simulate,
    simulate_many, simulate_many_until,
};

/// Numbers in [0, 1): a Weyl sequence, good enough for scenes.
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

/// Scenes that clatter briefly, long, and without end.
fn scenes(count: usize) -> (Vec<Posture>, Vec<State>) {
    let mut w = Weyl(0.1);
    (0..count)
        .map(|k| {
            let e = if k % 3 == 0 { w.between(0.0, 0.6) } else { w.between(0.8, 0.998) };
            let slope = if k % 4 == 0 { 0.0 } else { 0.1 };
            let friction = if k % 2 == 0 { 0.0 } else { 0.4 };
            let foot =
                |x: f64, slope: f64| Contact { friction, ..Contact::at(x, 0.0) }.on_slope(slope);
            let posture = Posture::new(Fields {
                mass: 1.0,
                gyration_radius: w.between(0.1, 0.6),
                center_of_mass: [w.between(-0.1, 0.1), w.between(0.0, 0.2)],
                contacts: vec![foot(-0.5, -slope), foot(0.5, slope)],
                restitution: e,
                gravity: 9.81,
                terrain: Vec::new(),
            });
            let height = 10_f64.powf(w.between(-5.0, -1.0));
            let turn = w.between(-0.9, 0.9) * height;
            let spin = if k % 5 == 0 { w.between(-9.0, 9.0) } else { 0.0 };
            let state = State::new([0.0, height, turn], [0.0, 0.1 * height, spin * height]);
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
            let many = |threads, lanes| {
                let resources = Resources { threads, lanes };
                simulate_many_until(&postures, &states, &options, resources, &|| false)
            };
            let by_two = many(1, 2).unwrap().unwrap();
            for (threads, lanes) in [(1, 1), (2, 4), (3, 8), (7, 2)] {
                let ends = many(threads, lanes).unwrap().unwrap();
                for (one, other) in ends.iter().zip(&by_two) {
                    assert_eq!(bits(one), bits(other), "{threads} threads, {lanes} lanes");
                }
            }
            for (k, end) in by_two.iter().enumerate() {
                let run = simulate(&postures[k], &states[k], &options).unwrap();
                let zeno = run.zeno_points().into_iter().next();
                assert_eq!(run.outcome(), end.outcome, "{k}");
                assert_eq!(run.elapsed().to_bits(), end.elapsed.to_bits(), "{k}");
                assert_eq!(run.state(), &end.state, "{k}");
                assert_eq!(run.collisions(), end.collisions, "{k}");
                assert_eq!(zeno.as_ref().map(|z| z.elapsed), end.zeno.map(|z| z.elapsed), "{k}");
                assert_eq!(zeno.as_ref().map(|z| z.contacts.len()), end.zeno.map(|z| z.count));
                assert_eq!(!run.warnings().is_empty(), end.warned, "{k}");
                long += usize::from(end.collisions > 200);
                through += usize::from(end.zeno.is_some());
            }
        }
    }
    assert!(long > 200 && through > 600, "{long} {through}: scenes without lanes prove nothing");
}

#[test]
fn the_first_wrong_start_is_named() {
    let rod = Posture::rod(0.5, 0.2, 0.1, 0.0, 9.81).unwrap();
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
fn runs_are_stopped() {
    let rod = Posture::rod(0.5, 0.2, 0.999, 0.0, 9.81).unwrap();
    let states = vec![State::at_rest([0.0, 0.01, 0.001]); 100_000];
    let options = Options { model: Model::Full, ..Options::default() };
    let resources = Resources::default();
    let ends = simulate_many_until(&[rod], &states, &options, resources, &|| true);
    assert_eq!(ends.unwrap(), None);
}
