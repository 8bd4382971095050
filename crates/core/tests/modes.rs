//! Contact modes: known answers, symmetries, and tests of every word.

use proptest::prelude::*;
use proptest::test_runner::{Config as ProptestConfig, RngSeed, TestRunner};
use standfast::modes::{ContactProblem, Method, Modes, ProblemFields, Status, contact_modes};
use standfast::{Contact, Posture, PostureFields, State};

fn solve(fields: ProblemFields) -> Modes {
    contact_modes(&ContactProblem::new(fields).unwrap(), Method::Enumerate).unwrap()
}

fn words(modes: &Modes) -> Vec<String> {
    modes.consistent().map(|answer| answer.word.to_string()).collect()
}

fn offered(modes: &Modes) -> Vec<String> {
    modes.answers().iter().map(|answer| answer.word.to_string()).collect()
}

/// Unit mass and gravity.
fn on(rho2: f64, contacts: &[([f64; 2], [f64; 2])], friction: f64, sliding: i8) -> ProblemFields {
    let n = contacts.len();
    ProblemFields {
        mass: 1.0,
        gyration_radius: f64::sqrt(rho2),
        arms: contacts.iter().map(|c| c.0).collect(),
        tangents: contacts.iter().map(|c| c.1).collect(),
        friction: vec![friction; n],
        sliding: vec![Some(sliding); n],
        bias: vec![[0.0; 2]; n],
        free_acceleration: [0.0, -1.0, 0.0],
        ..ProblemFields::default()
    }
}

const FLAT: [f64; 2] = [1.0, 0.0];

#[test]
fn the_three_four_five_rod() {
    // Painlevé's rod. Below μ = 13/9 exactly one mode is consistent. With μ = 2 and v_t < 0 no mode is consistent at θ̇
    // = 0, and two are at θ̇² = 5/2.
    let rod = |friction, spin2: f64| {
        let mut fields = on(1.0 / 3.0, &[([-0.6, -0.8], FLAT)], friction, -1);
        fields.bias = vec![[0.6 * spin2, 0.8 * spin2]]; // −(b, c) θ̇²
        solve(fields)
    };
    assert_eq!(words(&rod(1.444, 0.0)), ["L"]);
    assert_eq!(rod(1.445, 0.0).status(), Status::None);
    assert_eq!(rod(2.0, 0.0).status(), Status::None);
    assert_eq!(words(&rod(2.0, 2.5)), ["S", "L"]);
}

#[test]
fn two_sliding_contacts_without_a_mode() {
    for sliding in [1, -1] {
        let fields = on(0.25, &[([-1.0, -1.0], FLAT), ([1.0, -1.0], FLAT)], 1.5, sliding);
        assert_eq!(solve(fields).status(), Status::None);
    }
}

#[test]
fn two_contacts_at_rest_with_three_modes() {
    let t = [0.8, -0.6];
    let modes = solve(on(0.5, &[([-1.0, -3.0], t), ([1.0, 0.0], t)], 1.0, 0));
    assert_eq!(words(&modes), ["SF", "FS", "FF"]);
    assert_eq!(modes.status(), Status::Ambiguous);
}

#[test]
fn two_contacts_in_general_position_offer_ten_words() {
    let level = solve(on(0.5, &[([-1.0, -1.0], FLAT), ([2.0, -1.0], FLAT)], 0.5, 0));
    let ten = ["SS", "SF", "SR", "SL", "FS", "FF", "RS", "RR", "LS", "LL"];
    assert_eq!(offered(&level), ten);
    // Two contacts on a convex corner, centre of mass low: the contacts slide towards each other or apart.
    let (left, right) = ([0.8, 0.6], [0.8, -0.6]);
    let wedge = solve(on(0.5, &[([-1.0, 1.0], left), ([2.0, 1.5], right)], 0.5, 0));
    assert_eq!(wedge.answers().len(), 10);
    let words = offered(&wedge);
    for never in ["RF", "FR", "LF", "FL"] {
        assert!(!words.contains(&never.to_string()), "{words:?}");
    }
}

#[test]
fn a_block_on_a_slope_rests_slides_or_tips() {
    let block = |slope: f64, friction: f64, height: f64| {
        let (sin, cos) = slope.sin_cos();
        let foot = |s: f64| Contact { friction, ..Contact::at(s * cos, s * sin).on_slope(slope) };
        let posture = Posture::new(PostureFields {
            mass: 2.0,
            gyration_radius: 0.6,
            center_of_mass: [-height * sin, height * cos],
            contacts: vec![foot(-0.5), foot(0.5)],
            restitution: 0.0,
            gravity: 9.81,
            ..PostureFields::default()
        })
        .unwrap();
        let problem =
            ContactProblem::of_posture(&posture, &State::at_rest([0.0; 3]), [0.0; 3]).unwrap();
        contact_modes(&problem, Method::Auto).unwrap()
    };
    assert_eq!(words(&block(0.3, 0.5, 0.4)), ["FF"]);
    assert_eq!(words(&block(0.6, 0.5, 0.4)), ["LL"]);
    assert_eq!(words(&block(0.6, 2.0, 1.0)), ["FS"]); // tips about its lower foot
    // Sliding down: g (sin − μ cos) along the slope, forces by the moments about the centre.
    let modes = block(0.6, 0.5, 0.4);
    let answer = modes.consistent().next().unwrap();
    let (sin, cos) = 0.6_f64.sin_cos();
    let along = -9.81 * (sin - 0.5 * cos);
    assert!((answer.acceleration[0] - along * cos).abs() < 1e-14);
    assert!((answer.acceleration[1] - along * sin).abs() < 1e-14);
    let weight = 2.0 * 9.81 * cos;
    let [one, two] = [answer.forces[0], answer.forces[1]];
    assert!((one[1] + two[1] - weight).abs() < 1e-13);
    assert!((0.5 * (two[1] - one[1]) + 0.4 * 0.5 * weight).abs() < 1e-13, "{one:?} {two:?}");
    assert!((one[0] - 0.5 * one[1]).abs() < 1e-13);
}

#[test]
fn a_level_table_on_many_legs() {
    for n in [3, 4, 10, 64] {
        let legs: Vec<_> =
            (0..n).map(|i| ([i as f64 / (n - 1) as f64 * 2.0 - 1.0, -1.0], FLAT)).collect();
        assert_eq!(words(&solve(on(0.5, &legs, 0.5, 0))), ["F".repeat(n)]);
        assert_eq!(words(&solve(on(0.5, &legs, 0.5, 1))), ["R".repeat(n)]);
        // With a larger push the body slides, with a still larger one it tips.
        let mut pushed = on(0.5, &legs, 0.5, 0);
        pushed.free_acceleration = [0.8, -1.0, 0.0];
        assert_eq!(words(&solve(pushed)), ["R".repeat(n)]);
    }
}

#[test]
fn contacts_at_one_point_share_their_force() {
    let twice = solve(on(0.5, &[([0.0, -1.0], FLAT), ([0.0, -1.0], FLAT)], 0.5, 0));
    assert_eq!(words(&twice), ["FF"]);
    let total: f64 = twice.consistent().next().unwrap().forces.iter().map(|f| f[1]).sum();
    assert!((total - 1.0).abs() < 1e-14);
    let many = vec![([0.3, -1.0], FLAT); 64];
    assert_eq!(words(&solve(on(0.5, &many, 5.0, 0))).len(), 1);
}

#[test]
fn a_wrong_problem_is_named() {
    let good = on(0.5, &[([-1.0, -1.0], FLAT), ([1.0, -1.0], FLAT)], 0.5, 0);
    let refused = |change: &dyn Fn(&mut ProblemFields), name: &str| {
        let mut fields = good.clone();
        change(&mut fields);
        let error = ContactProblem::new(fields).unwrap_err().to_string();
        assert!(error.starts_with(name), "{error}");
    };
    refused(&|f| f.friction[1] = -0.1, "friction.2 = -0.1");
    refused(&|f| f.friction[0] = f64::NAN, "friction.1 = NaN");
    refused(&|f| f.gyration_radius = 0.0, "gyration_radius = 0.0");
    refused(&|f| f.mass = f64::INFINITY, "mass = inf");
    refused(&|f| f.arms[0][1] = f64::NAN, "arms.1.y");
    refused(&|f| f.tangents[1] = [1.0, 1.0], "tangents.2 = (1.0, 1.0)");
    refused(&|f| f.sliding[0] = Some(2), "sliding.1 = 2");
    refused(&|f| f.bias[0] = [f64::INFINITY, 0.0], "bias.1.tangential");
    refused(&|f| f.arms.clear(), "arms");
    refused(&|f| f.friction.truncate(1), "friction");
    refused(&|f| f.free_acceleration[2] = f64::NAN, "free_acceleration.theta");
}

/// Random problems of one or two contacts: at rest, sliding, separated, with and without bias.
fn problems() -> impl Strategy<Value = ProblemFields> {
    let contact = (
        [-2.0..2.0, -2.0..0.5],
        prop_oneof![2 => Just(0.0), 1 => -1.2..1.2],
        prop_oneof![1 => Just(0.0), 3 => 0.0..1.0, 1 => 1.0..10.0],
        prop_oneof![4 => Just(Some(0)), 1 => Just(Some(1)), 1 => Just(Some(-1)), 1 => Just(None)],
        prop_oneof![2 => Just([0.0, 0.0]), 1 => [-1.0..1.0, -1.0..1.0]],
    );
    (
        proptest::collection::vec(contact, 1..=2),
        0.05..2.0,
        prop_oneof![2 => Just([0.0, -1.0, 0.0]), 1 => [-1.0..1.0, -2.0..1.0, -1.0..1.0]],
        0.1..10.0,
    )
        .prop_map(|(contacts, rho, free_acceleration, mass)| ProblemFields {
            mass,
            gyration_radius: rho,
            arms: contacts.iter().map(|c| c.0).collect(),
            tangents: contacts.iter().map(|c| [f64::cos(c.1), f64::sin(c.1)]).collect(),
            friction: contacts.iter().map(|c| c.2).collect(),
            sliding: contacts.iter().map(|c| c.3).collect(),
            bias: contacts.iter().map(|c| c.4).collect(),
            free_acceleration,
            ..ProblemFields::default()
        })
}

#[test]
fn closed_forms_agree_with_enumeration() {
    let config = ProptestConfig {
        cases: 20_000,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    };
    TestRunner::new(config)
        .run(&problems(), |fields| {
            let problem = ContactProblem::new(fields).unwrap();
            assert!(problem.pair_modes().is_some());
            let closed = contact_modes(&problem, Method::Auto).unwrap();
            let listed = contact_modes(&problem, Method::Enumerate).unwrap();
            assert_eq!(offered(&closed), offered(&listed));
            for (one, two) in closed.answers().iter().zip(listed.answers()) {
                let close = one.near_degenerate() || two.near_degenerate();
                assert!(one.consistent == two.consistent || close, "{one:?} {two:?}");
                let size = one.acceleration.iter().map(|a| a.abs()).fold(1.0, f64::max);
                for k in 0..3 {
                    let off = (one.acceleration[k] - two.acceleration[k]).abs();
                    assert!(off < 1e-9 * size || !two.consistent, "{one:?} {two:?}");
                }
            }
            Ok(())
        })
        .unwrap_or_else(|failure| panic!("{failure}"));
}

#[test]
#[cfg(feature = "qp")]
fn programmes_find_modes() {
    // How often the fixed-point iteration finds a mode if one exists, on the random problems above.
    let config = ProptestConfig {
        cases: 5_000,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(2),
        ..ProptestConfig::default()
    };
    let (found, solvable) = (std::cell::Cell::new(0), std::cell::Cell::new(0));
    TestRunner::new(config)
        .run(&problems(), |fields| {
            let problem = ContactProblem::new(fields).unwrap();
            let all = contact_modes(&problem, Method::Auto).unwrap();
            let qp = contact_modes(&problem, Method::Qp).unwrap();
            if all.status() != Status::None {
                solvable.set(solvable.get() + 1);
                found.set(found.get() + usize::from(qp.status() == Status::Found));
            }
            for answer in qp.answers() {
                let same = all.get(answer.word).unwrap();
                assert!(same.consistent || same.near_degenerate(), "{answer:?}");
            }
            Ok(())
        })
        .unwrap_or_else(|failure| panic!("{failure}"));
    println!("found {} of {}", found.get(), solvable.get());
    assert!(found.get() as f64 >= 0.999 * solvable.get() as f64, "{found:?} of {solvable:?}");
}

#[test]
fn many_legs_by_every_method() {
    for n in 3..=64 {
        let legs: Vec<_> =
            (0..n).map(|i| ([i as f64 / (n - 1) as f64 * 2.0 - 1.0, -1.0], FLAT)).collect();
        let mut fields = on(0.25, &legs, 0.5, 0);
        (fields.mass, fields.free_acceleration) = (2.0, [0.0, -10.0, 0.0]);
        assert_eq!(words(&solve(fields.clone())), ["F".repeat(n)], "{n}");
        #[cfg(feature = "qp")]
        {
            let problem = ContactProblem::new(fields).unwrap();
            let found = contact_modes(&problem, Method::Qp).unwrap();
            assert_eq!(words(&found), ["F".repeat(n)], "{n}");
        }
    }
}

#[test]
fn critical_friction_of_painleves_rod() {
    // 13/9 for the 3-4-5 rod; 4/3 for the uniform rod at tan = 2 that leans backward as it slides.
    let rod = |arm: [f64; 2], way: i8| {
        ContactProblem::new(on(1.0 / 3.0, &[(arm, FLAT)], 0.5, way)).unwrap().jamming()
    };
    let close = |x: f64, y: f64| (x - y).abs() < 4e-15;
    let [left] = rod([-0.6, -0.8], -1)[..] else { panic!() };
    assert!(close(left.critical_friction, 13.0 / 9.0) && close(left.margin, 1.0 - 4.5 / 13.0));
    let [right] = rod([-0.6, -0.8], 1)[..] else { panic!() };
    assert!(right.critical_friction == f64::INFINITY && right.margin > 1.0);
    let [steep] = rod([1.0 / 5f64.sqrt(), -2.0 / 5f64.sqrt()], 1)[..] else { panic!() };
    assert!(close(steep.critical_friction, 4.0 / 3.0));
    assert_eq!(rod([-0.6, -0.8], 0).len(), 2);
}

#[test]
fn without_its_feature_qp_is_an_error() {
    let fields = on(0.25, &[([-1.0, -1.0], FLAT), ([1.0, -1.0], FLAT)], 0.5, 0);
    let answer = contact_modes(&ContactProblem::new(fields).unwrap(), Method::Qp);
    if cfg!(feature = "qp") {
        assert_eq!(words(&answer.unwrap()), ["FF"]);
    } else {
        let said = answer.unwrap_err().to_string();
        assert!(said.contains("method = qp") && said.contains("cargo feature `qp`"), "{said}");
    }
}
