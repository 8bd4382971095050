//! Values written and read back by serde, and the parts of a run that are returned without being computed again.

use std::collections::BTreeSet;

use random::Random;
use serde::Serialize;
use serde::de::DeserializeOwned;
use standfast::body::{
    Chain, ChainFields, Foot, HoldingChoice, Joint, Link, LocalModel, LocalModelFields, LocalState,
};
use standfast::excitation::{Excitation, Force, GroundMotion, Kick};
use standfast::modes::{ContactProblem, Method, Modes, ProblemFields, contact_modes};
use standfast::options::{Impact, Jams, Simultaneous};
use standfast::outcome::ContactNumber;
use standfast::simulate::simulate_local;
use standfast::stability::{Argument, Evidence, Stability, Verdict, trials};
use standfast::sweep::{Axis, Column, OfConditions, OfVerdict, Quantity, Sweep, ValueKind};
use standfast::{
    Contact, Lamina, Model, Options, Outcome, Posture, PostureFields, Scene, State, Stop,
    Trajectory, simulate, stability,
};

#[path = "../src/math/random.rs"]
mod random;

fn json<T: Serialize>(value: &T) -> String {
    serde_json::to_string_pretty(value).unwrap()
}

/// The value read from a text.
fn read<T: DeserializeOwned>(text: &str) -> T {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

fn back<T: Serialize + DeserializeOwned>(value: &T) -> T {
    read(&json(value))
}

impl Random {
    /// A body on `count` contacts, each with its own slope.
    fn posture(&mut self, count: usize) -> Posture {
        let friction = self.between(0.0, 1.5);
        let contacts = (0..count).map(|i| Contact {
            friction,
            ..Contact::at(2.0 * i as f64 - 1.0, self.between(-0.5, 0.5))
                .on_slope(self.between(-1.3, 1.3))
        });
        Posture::new(PostureFields {
            mass: 2.0,
            contacts: contacts.collect(),
            gyration_radius: self.between(0.2, 1.5),
            center_of_mass: [self.between(-1.2, 1.2), self.between(-0.5, 2.0)],
            restitution: self.between(0.0, 0.5),
            gravity: 10.0,
            ..PostureFields::default()
        })
        .unwrap()
    }
}

/// Runs in both kinds of coordinates and all models, with few and with many steps.
fn runs() -> Vec<Trajectory> {
    let rod = Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() },
    )
    .unwrap();
    let tilted = State::at_rest([0.0, 0.011, 0.002]);
    let options = Options::default();
    let mut runs: Vec<_> = [
        options,
        Options { model: Model::Full, certify: true, ..options },
        Options { model: Model::Local, time: 3.0, time_limit: Some(3.04), ..options },
        Options { stop: Stop::Zeno, record: false, neighbourhood: 7.0, ..options },
    ]
    .iter()
    .map(|options| simulate(&rod, &tilted, options).unwrap())
    .collect();
    let law = Options {
        impact: Impact::Poisson,
        simultaneous: Some(Simultaneous::FirstContactFirst),
        event_limit: 2000,
        ..options
    };
    let mut random = Random(5);
    for count in [1, 2, 3] {
        let start = State::new([0.0, 2.0, 0.1], [0.3, 0.0, 0.2]);
        runs.push(simulate(&random.posture(count), &start, &law).unwrap());
    }
    let model = LocalModel::new(LocalModelFields {
        gravity: [1.0, 1.0],
        psi: [0.9, 0.9],
        phi: [0.5, -0.5],
        restitution: [0.1, 0.1],
    })
    .unwrap();
    let gaps = Options { certify: true, ..options };
    runs.push(
        simulate_local(
            &model,
            &LocalState { gaps: [0.0, 0.1], rates: [0.1, -1.9], theta: 0.2, omega: 0.3 },
            &gaps,
        )
        .unwrap(),
    );
    runs
}

#[test]
fn a_contact_has_one_number() {
    let run = &runs()[0];
    let contact = run.impacts()[0].contact;
    assert_eq!((contact.index(), contact.number()), (0, 1));
    assert_eq!(format!("{contact} {contact:?} {}", json(&contact)), "1 1 1");
    assert_eq!(back(&contact), contact);
    assert!(serde_json::from_str::<ContactNumber>("0").is_err());
    assert_eq!(format!("{:?}", standfast::outcome::Cause::Impact(contact)), "Impact(1)");
}

#[test]
fn words_are_written_as_they_are_spelled() {
    for outcome in Outcome::ALL {
        assert_eq!(json(&outcome), format!("\"{}\"", outcome.as_str()));
        assert_eq!(back(&outcome), outcome);
    }
    for by in Argument::ALL {
        assert_eq!(json(&by), format!("\"{}\"", by.as_str()));
        assert_eq!(back(&by), by);
    }
    for stability in [Stability::Stable, Stability::Unstable, Stability::Undecided] {
        assert_eq!(json(&stability), format!("\"{}\"", stability.as_str()));
    }
}

#[test]
fn options_are_printed_as_they_are_written() {
    for impact in [Impact::Newton, Impact::ChatterjeeRuina, Impact::Moreau] {
        assert_eq!(format!("\"{impact}\""), json(&impact));
    }
    assert_eq!(Simultaneous::FirstContactFirst.to_string(), "first-contact-first");
    assert_eq!(format!("{:>6}|{}|{}", Stop::Rest, Jams::None, Model::Auto), "  rest|none|auto");
}

#[test]
fn contacts_are_counted_from_one() {
    let run = &runs()[0];
    let touching = run.touching();
    let numbers: Vec<usize> = touching.into_iter().map(ContactNumber::number).collect();
    assert_eq!(touching.len(), numbers.len());
    for number in 1..=200 {
        let contact = ContactNumber::try_from(number).unwrap();
        assert_eq!((contact.number(), contact.index()), (number, number - 1));
        assert_eq!(touching.contains(contact), numbers.contains(&number));
    }
    let error = ContactNumber::try_from(0).unwrap_err().to_string();
    assert_eq!(error, "contact = 0 cannot be used: a number from 1 on");
}

#[test]
fn times_end_at_the_end() {
    for run in runs().iter().filter(|run| run.options().record) {
        let (start, end) = (run.options().time, run.time());
        for count in 2..60 {
            let times: Vec<f64> = run.times(count).collect();
            assert_eq!((times.len(), times[0], times[count - 1]), (count, start, end));
            assert!(times.is_sorted());
        }
        assert!(run.times(0).next().is_none() && run.times(1).eq([start]));
        for count in [0, 1, 1 << 60] {
            let error = run.sample_times(count).unwrap_err().to_string();
            assert_eq!(error, format!("n = {count} cannot be used: from 2 to 10000000"));
        }
    }
}

#[test]
fn a_scene_is_written_as_its_file() {
    let scene = Scene {
        posture: Random(1).posture(3),
        start: State::new([0.0, 2.0, -0.0], [0.1, 0.2, 1e-300]),
        options: Options { time_limit: Some(3.0), neighbourhood: 4.0, ..Options::default() },
        excitation: Excitation {
            kicks: vec![Kick { time: 0.5, impulse: [0.1, 0.3], point: None }],
            forces: vec![Force { start: 0.25, end: 0.75, force: [1.0, 0.0] }],
            ground_motion: Some(GroundMotion {
                times: vec![0.0, 0.1],
                tilt: vec![0.01, 0.02],
                ..GroundMotion::default()
            }),
        },
    };
    assert_eq!(json(&scene), scene.to_json());
    assert_eq!(back(&scene).to_toml(), scene.to_toml());
    // An error has the name of the field in the file.
    let wrong = scene.to_json().replace("\"mass\": 2.0", "\"mass\": -2.0");
    let said = serde_json::from_str::<Scene>(&wrong).unwrap_err().to_string();
    assert!(said.starts_with("body.mass = -2.0 is outside its range"), "{said}");
}

#[test]
fn a_run_is_read_as_it_was_written() {
    for run in runs() {
        let text = json(&run);
        assert_eq!(text, run.to_json());
        let same: Trajectory = read(&text);
        assert_eq!(same.to_json(), text);
        if run.options().record {
            let t = 0.3 * run.options().time + 0.7 * run.time();
            let bits = |run: &Trajectory| {
                run.at(t).unwrap().gaps.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            assert_eq!(bits(&same), bits(&run));
        }
    }
}

#[test]
fn a_run_that_was_changed_is_refused() {
    let text = runs()[0].to_json();
    for (old, new) in [
        ("\"outcome\": \"rest\"", "\"outcome\": \"zeno\""),
        ("\"collisions\": 9", "\"collisions\": 8"),
        ("\"mass\": 1.0", "\"mass\": 2.0, \"mas\": 1.0"),
        ("0.002", "0.003"),
        ("\"posture\": {", "\"attitude\": {"),
    ] {
        assert!(text.contains(old), "{old} in {text}");
        let changed = text.replace(old, new);
        assert!(serde_json::from_str::<Trajectory>(&changed).is_err(), "{old}");
        let error = Trajectory::from_json(&changed).unwrap_err().to_string();
        assert!(error.starts_with("run: "), "{error}");
    }
}

#[test]
fn modes_are_read_as_they_were_written() {
    let same = |modes: &Modes| assert_eq!(json(&back(modes)), json(modes));
    let mut random = Random(2);
    for k in 0..200 {
        let posture = random.posture(1 + k % 5);
        let problem =
            ContactProblem::of_posture(&posture, &State::at_rest([0.0; 3]), [0.0; 3]).unwrap();
        for method in [Method::Auto, Method::Enumerate] {
            same(&contact_modes(&problem, method).unwrap());
        }
    }
    // Between two walls friction can hold any force.
    let problem = ContactProblem::new(ProblemFields {
        mass: 1.0,
        gyration_radius: 0.5,
        arms: vec![[-1.0, 0.0], [1.0, 0.0]],
        tangents: vec![[0.0, -1.0], [0.0, 1.0]],
        friction: vec![0.5; 2],
        sliding: vec![Some(0); 2],
        bias: vec![[0.0, 0.0]; 2],
        free_acceleration: [0.0, -1.0, 0.0],
        ..ProblemFields::default()
    });
    let held = contact_modes(&problem.unwrap(), Method::Auto).unwrap();
    let ends = |modes: &Modes| modes.get("FF".parse().unwrap()).unwrap().force_interval;
    assert_eq!((ends(&held), ends(&back(&held))), (Some([1.0, f64::INFINITY]), ends(&held)));
    same(&held);
    // The numbers of a word without a motion are NaN.
    let text = json(held.answers().first().unwrap()).replace("-1.0", "null");
    let nothing: standfast::modes::ModeAnswer = read(&text);
    assert!(nothing.acceleration[1].is_nan());
    assert_eq!(json(&nothing), text);
}

#[test]
fn a_verdict_is_read_as_it_was_written() {
    let mut random = Random(3);
    let mut kinds = BTreeSet::new();
    let neutral = Posture::rod(
        0.5,
        &Lamina {
            gyration_radius: Some(0.45),
            restitution: 0.6,
            friction: 0.5,
            ..Lamina::default()
        },
    )
    .unwrap();
    let drawn: Vec<Posture> =
        (0..600).map(|k| random.posture(2 + usize::from(k % 3 == 0))).collect();
    for posture in drawn.into_iter().chain([neutral]) {
        let mut verdict = stability(&posture).unwrap();
        kinds.insert(match &verdict.evidence {
            Some(Evidence::Region { .. }) => "region",
            Some(Evidence::Margins { .. }) => "margins",
            Some(Evidence::Potential(_)) => "potential",
            Some(Evidence::Cycle(_)) => "cycle",
            Some(Evidence::Trap(_)) => "trap",
            Some(Evidence::Word(_)) => "word",
            Some(Evidence::Away(_)) => "away",
            Some(Evidence::Motion { .. }) => "motion",
            Some(Evidence::NoMotion(_)) => "no-motion",
            Some(Evidence::Left { .. }) => "left",
            Some(Evidence::Well { .. }) => "well",
            Some(Evidence::DescendingPairs { .. }) => "pairs",
            Some(Evidence::Neutral { .. }) => "neutral",
            Some(Evidence::Shrinks { .. }) => "shrinks",
            Some(Evidence::PotentialWell { .. }) => "potential-well",
            None => "nothing",
        });
        if kinds.len() == 3 {
            // Some of them with random kicks.
            verdict.trials = Some(trials(&posture, 3, 1, Jams::None, &|| false).unwrap());
        }
        let text = json(&verdict);
        let same: Verdict = read(&text);
        assert_eq!((json(&same), verdict.to_json()), (text.clone(), text));
        assert_eq!((&same.evidence, &same.conditions), (&verdict.evidence, &verdict.conditions));
    }
    assert_eq!(
        kinds,
        [
            "cycle",
            "left",
            "margins",
            "neutral",
            "no-motion",
            "pairs",
            "potential",
            "region",
            "well",
            "word",
        ]
        .into()
    );
    let corner = r#"{"contact":2,"phi":0.5,"growth":0.25}"#;
    let away: Evidence = read(corner);
    assert!(matches!(away, Evidence::Away(step) if step.contact.number() == 2));
    assert_eq!(serde_json::to_string(&away).unwrap(), corner);
    // Of mechanisms only.
    let shrinks: Evidence = read(r#"{"growth":0.25}"#);
    assert_eq!(shrinks, Evidence::Shrinks { growth: 0.25 });
}

#[test]
fn what_a_run_tells_is_made_once() {
    for run in runs() {
        assert!(std::ptr::eq(run.impacts(), run.impacts()));
        assert!(std::ptr::eq(run.zeno_points(), run.zeno_points()));
        assert!(std::ptr::eq(run.phases(), run.phases()));
    }
}

#[test]
fn phases_carry_on_through_the_impacts_inside_them() {
    let rod = Posture::rod(
        0.5,
        &Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() },
    )
    .unwrap();
    let phases = |q: [f64; 3]| {
        let options = Options { model: Model::Full, ..Options::default() };
        let run = simulate(&rod, &State::at_rest(q), &options).unwrap();
        let told = run.phases().iter().map(|phase| (phase.mode.clone(), phase.impacts));
        (run.impacts().len(), told.collect::<Vec<_>>())
    };
    // Nine impacts one by one, then the sum of the others.
    let clatter = phases([0.0, 0.011, 0.002_f64.asin()]);
    assert_eq!(clatter, (9, vec![("SS".into(), 9), ("FF".into(), 0)]));
    let mut fields = rod.fields().clone();
    fields.contacts.truncate(1);
    // A ball with one impact during the run.
    fields.center_of_mass = fields.contacts[0].point;
    let ball = Posture::new(fields).unwrap();
    let options = Options {
        stop: Stop::Time,
        time_limit: Some(1.05),
        model: Model::Local,
        ..Options::default()
    };
    let run = simulate(&ball, &State::at_rest([0.0, 4.9, 0.0]), &options).unwrap();
    assert_eq!((run.phases().len(), run.phases()[0].impacts, run.impacts().len()), (1, 1, 1));
}

fn quantities(names: &[&str]) -> Vec<Quantity> {
    names.iter().map(|name| Quantity::parse(name).unwrap()).collect()
}

/// Of a body on level ground with runs, of one on a terrain, and of a chain.
fn sweeps() -> Vec<Sweep> {
    let lamina =
        Lamina { gyration_radius: Some(0.2), restitution: 0.1, friction: 0.5, ..Lamina::default() };
    let rod = Posture::rod(0.5, &lamina).unwrap();
    let radii = Axis::new("gyration_radius", vec![0.2, 0.5], &rod).unwrap();
    let places = Axis::new("contacts.2.point.x", vec![0.4, 0.6], &rod).unwrap();
    let start = State::new([0.0, 0.011, 0.002], [0.0; 3]);
    let options = Options { stop: Stop::Zeno, ..Options::default() };
    let runs = Sweep::new(&rod, vec![radii, places], quantities(&["fate", "zeno_time", "by"]))
        .and_then(|sweep| sweep.from_start(start, options)?.with_width(1e-6))
        .unwrap()
        .with_jams(Jams::Impact);
    let terrain = vec![[-2.0, 0.0], [0.0, -0.5], [2.0, 0.0]];
    let vee = Posture::block(1.0, 1.0, &Lamina { terrain, ..lamina }).unwrap();
    let friction = Axis::new("friction", vec![0.2, 0.9], &vee).unwrap();
    let on_terrain =
        Sweep::new(&vee, vec![friction], quantities(&["equilibrium_margin", "equilibrium"]));
    let leg = Link::uniform(1.0, 1.0);
    let hip = Joint { parent: Some(1), at: Some(0.0), ..Joint::locked() };
    let biped = Chain::new(ChainFields {
        links: vec![Link { center: Some(0.0), ..Link::uniform(10.0, 1.0) }, leg, leg],
        joints: vec![hip, hip],
        feet: [2, 3].map(|link| Foot { friction: 0.8, ..Foot::of_link(link) }).to_vec(),
        ..ChainFields::default()
    });
    let (biped, q) = (biped.unwrap(), [0.0, 0.0, -1.5, -0.5, 0.5]);
    let angles = Axis::of_chain("base.angle", vec![-1.6, -0.9], &biped, &q).unwrap();
    let feet = Axis::of_chain("foot.2.friction", vec![0.1, 0.8], &biped, &q).unwrap();
    let asked = quantities(&["equilibrium", "stability"]);
    let held = Some(HoldingChoice::Least);
    let of_chain = Sweep::of_chain(&biped, &q, held, vec![angles, feet], asked);
    vec![runs, on_terrain.unwrap(), of_chain.unwrap()]
}

#[test]
fn sweeps_and_their_columns_are_read_back() {
    for sweep in sweeps() {
        let again: Sweep = back(&sweep);
        assert_eq!(again, sweep);
        let columns = sweep.run(0..sweep.size(), 1, &|| false).unwrap();
        let same = again.run(0..again.size(), 1, &|| false).unwrap();
        assert_eq!(format!("{same:?}"), format!("{columns:?}"));
        let read: Vec<Column> = back(&columns);
        assert_eq!(format!("{read:?}"), format!("{columns:?}"));
    }
    let numbers = Column::Numbers(vec![0.1, f64::NAN, f64::NEG_INFINITY]);
    assert_eq!(json(&back(&numbers)), json(&numbers));
}

#[test]
fn quantities_are_written_as_their_names() {
    for (name, quantity) in Quantity::ALL {
        assert_eq!(back(&quantity), quantity);
        assert_eq!(back(&quantity.kind()), quantity.kind());
        match quantity {
            Quantity::Condition(field) => assert_eq!(read::<OfConditions>(&json(&name)), field),
            Quantity::Verdict(field) => assert_eq!(read::<OfVerdict>(&json(&name)), field),
            _ => assert!(serde_json::from_str::<OfVerdict>(&json(&name)).is_err(), "{name}"),
        }
    }
    assert_eq!(json(&OfConditions::Theorem3), "\"theorem_3\"");
}

#[test]
fn what_is_no_sweep_is_an_error() {
    let written = json(&sweeps()[0]);
    for (right, wrong, said) in [
        ("gyration_radius", "gyration", "gyration"),
        ("contacts.2.point.x", "contacts.3.point.x", "contacts counting from 1 to 2"),
        ("\"zeno_time\"", "\"zeno\"", "one of stability"),
        ("\"width\": 1e-6", "\"width\": 1.0", "width"),
    ] {
        let text = written.replace(right, wrong);
        assert_ne!(text, written, "{right}");
        let error = serde_json::from_str::<Sweep>(&text).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    for text in [
        r#"{"path": "mass", "values": []}"#,
        r#"{"path": "contacts.0.slope", "values": [1.0]}"#,
        r#"{"path": "mass", "values": [1.0], "unit": "kg"}"#,
    ] {
        assert!(serde_json::from_str::<Axis>(text).is_err(), "{text}");
    }
    for text in [
        r#"{"words": {"words": ["stable", "unstable"], "codes": [0]}}"#,
        r#"{"words": {"words": ["stable", "unstable", "undecided"], "codes": [3]}}"#,
    ] {
        assert!(serde_json::from_str::<Column>(text).is_err(), "{text}");
    }
    assert!(serde_json::from_str::<ValueKind>(r#"{"word": ["yes"]}"#).is_err());
}
