//! Verdicts on mechanisms: those of a rigid body, in any coordinates; and postures that free joints make unstable.

#[path = "../src/math/random.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests use a part of it")]
mod random;

use nalgebra::{DMatrix, DVector};
use random::Random;
use standfast::body::{ContactRows, Mechanism, MechanismFields};
use standfast::modes::{MechanismProblem, Method, contact_modes};
use standfast::simulate::simulate_mechanism;
use standfast::stability::{
    Argument, Evidence, StabilityOptions, Verdict, WhyUndecided, mechanism_forces,
    mechanism_stability, stability, static_forces,
};
use standfast::{Contact, Options, Outcome, Posture, PostureFields};

fn posture(random: &mut Random, feet: usize) -> Posture {
    let contacts = (0..feet)
        .map(|k| {
            let x = -1.0 + 2.0 * k as f64 / (feet.max(2) - 1) as f64 + random.between(-0.2, 0.2);
            let slope = random.between(-0.6, 0.6);
            let contact = Contact::at(x, random.between(-0.2, 0.2)).on_slope(slope);
            Contact { friction: random.between(0.1, 1.2), ..contact }
        })
        .collect();
    Posture::new(PostureFields {
        mass: random.between(0.5, 5.0),
        gyration_radius: random.between(0.2, 1.5),
        center_of_mass: [random.between(-0.6, 0.6), random.between(0.1, 2.0)],
        contacts,
        restitution: random.between(0.0, 0.7),
        ..PostureFields::default()
    })
    .unwrap()
}

/// The numbers of a verdict that do not depend on coordinates.
fn numbers(verdict: &Verdict) -> Vec<f64> {
    let mut values = Vec::new();
    if let Some(found) = verdict.conditions {
        values.extend([found.kinematic_margin, found.coupling]);
        values.extend([found.clattering_margin, found.chatter_margin]);
    }
    values
}

/// The numbers that do not depend on coordinates, to 1e-12.
fn same(one: &Verdict, two: &Verdict, case: usize) {
    assert_eq!(one.delicate, two.delicate, "{case}");
    let flags = |verdict: &Verdict| {
        verdict.conditions.map(|found| {
            let strong = (found.kinematic_strong, found.kinematic_strong_strict);
            (strong, found.unambiguous, found.clattering, found.chatter)
        })
    };
    assert_eq!(flags(one), flags(two), "{case}");
    assert_eq!(one.flight, two.flight, "{case}");
    let [a, b] = [one, two].map(numbers);
    assert_eq!(a.len(), b.len(), "{case}");
    for (a, b) in a.iter().zip(&b) {
        assert!(a == b || (a - b).abs() <= 1e-12 * a.abs().max(1.0), "{case}: {a} {b}");
    }
}

#[test]
fn the_verdict_on_a_rigid_body_is_that_on_its_posture() {
    let mut random = Random(11);
    let mut counts = std::collections::BTreeMap::new();
    for case in 0..2000 {
        let feet = [2, 2, 2, 1, 3, 4][case % 6];
        let posture = posture(&mut random, feet);
        let verdict = stability(&posture).unwrap();
        let mechanism = Mechanism::of_posture(&posture).unwrap();
        let other = mechanism_stability(&mechanism, &StabilityOptions::default()).unwrap();
        assert_eq!(verdict.frictional_stability, other.frictional_stability, "{case}");
        assert_eq!(verdict.by, other.by, "{case}");
        // The bound is found on pieces that depend on rounding.
        match (verdict.amplification, other.amplification) {
            (Ok(a), Ok(b)) => assert!((a - b).abs() <= 0.01 * a, "{case}: {a} {b}"),
            (a, b) => assert_eq!(a, b, "{case}"),
        }
        same(&verdict, &other, case);
        let (a, b) = (verdict.equilibrium.margin, other.equilibrium.margin);
        assert!(a == b || (a - b).abs() <= 1e-12 * a.abs().max(1.0), "{case}: {a} {b}");
        *counts.entry(verdict.by.map_or("undecided", Argument::as_str)).or_insert(0) += 1;
    }
    assert!(counts.len() >= 8, "{counts:?}");
}

/// The mechanism with the coordinates p, q = S p.
fn changed(mechanism: &Mechanism, s: &DMatrix<f64>) -> Mechanism {
    let fields = mechanism.fields();
    let n = mechanism.dof();
    let m = DMatrix::from_fn(n, n, |i, j| fields.mass_matrix[i][j]);
    let m = s.transpose() * m * s;
    let row = |values: &[f64]| {
        let row: Vec<f64> =
            (s.transpose() * DVector::from_column_slice(values)).as_slice().to_vec();
        row
    };
    Mechanism::new(MechanismFields {
        mass_matrix: (0..n)
            .map(|i| (0..n).map(|j| 0.5 * (m[(i, j)] + m[(j, i)])).collect())
            .collect(),
        load: row(&fields.load),
        contacts: fields
            .contacts
            .iter()
            .map(|c| ContactRows {
                normal: row(&c.normal),
                tangential: row(&c.tangential),
                ..c.clone()
            })
            .collect(),
        ..fields.clone()
    })
    .unwrap()
}

#[test]
fn the_verdict_on_two_contacts_does_not_depend_on_the_coordinates() {
    let mut random = Random(12);
    let mut apart = 0;
    let mut counts = std::collections::BTreeMap::new();
    for case in 0..2000 {
        let posture = posture(&mut random, 2);
        let verdict = stability(&posture).unwrap();
        let s =
            DMatrix::from_fn(3, 3, |i, j| f64::from(u8::from(i == j)) + random.between(-0.3, 0.3));
        let mechanism = changed(&Mechanism::of_posture(&posture).unwrap(), &s);
        let other = mechanism_stability(&mechanism, &StabilityOptions::default()).unwrap();
        same(&verdict, &other, case);
        // The search on the circle of corners starts with pieces that depend on the unit of mass: it may end without a result for one of the
        // two. Whatever is proved is the same.
        if verdict.by != other.by {
            let by = [verdict.by, other.by].into_iter().flatten().collect::<Vec<_>>();
            assert_eq!(by, [Argument::CornerMap], "{case}");
            apart += 1;
        }
        let (a, b) = (static_forces(&posture), mechanism_forces(&mechanism));
        assert_eq!(a.is_some(), b.is_some(), "{case}");
        if let (Some(a), Some(b)) = (a, b) {
            for (x, y) in a.low.iter().chain(&a.high).zip(b.low.iter().chain(&b.high)) {
                for (x, y) in x.iter().zip(y) {
                    assert!((x - y).abs() <= 1e-10 * x.abs().max(1.0), "{case}: {x} {y}");
                }
            }
        }
        *counts.entry(verdict.by.map_or("undecided", Argument::as_str)).or_insert(0) += 1;
    }
    assert!(counts.len() >= 7, "{counts:?}");
    assert!(apart <= 20, "{apart}");
}

/// Both contacts slide, or one does and the other one is open.
const SLIDES: [[Option<i8>; 2]; 8] = [
    [Some(1), Some(1)],
    [Some(1), Some(-1)],
    [Some(-1), Some(1)],
    [Some(-1), Some(-1)],
    [Some(1), None],
    [Some(-1), None],
    [None, Some(1)],
    [None, Some(-1)],
];

#[test]
fn verdicts_on_joints_with_torques_have_witnesses() {
    let mut random = Random(13);
    let mut counts = std::collections::BTreeMap::new();
    for case in 0..2000 {
        let posture = posture(&mut random, 2);
        let rigid = Mechanism::of_posture(&posture).unwrap();
        let mechanism = with_joints(&rigid, 1 + case % 3, &mut random);
        let verdict = mechanism_stability(&mechanism, &StabilityOptions::default()).unwrap();
        *counts.entry(verdict.by.map_or("undecided", Argument::as_str)).or_insert(0) += 1;
        match (verdict.by, &verdict.evidence) {
            (Some(Argument::NotEquilibrium), _) => {
                assert_eq!(mechanism_forces(&mechanism), None, "{case}")
            }
            (Some(Argument::AcceleratingMode), Some(Evidence::Word(word))) => {
                // The word is a motion with the load alone: a second solver finds it, too.
                let problem = MechanismProblem::at_rest(&mechanism);
                let all = contact_modes(&problem, Method::Enumerate).unwrap();
                assert!(all.consistent().any(|answer| answer.word == *word), "{case}");
            }
            (Some(Argument::NoSolution), Some(Evidence::NoMotion(start))) => {
                let run =
                    simulate_mechanism(&mechanism, &start.q, &start.qdot, &Options::default());
                assert_eq!(run.unwrap().outcome(), Outcome::Inconsistent, "{case}");
            }
            (None | Some(Argument::BoundedCorners), _) => {
                let open = verdict.reason();
                assert!(matches!(open, None | Some(WhyUndecided::Joints)), "{case}: {open:?}");
                // Wherever one or both contacts slide, a mode goes on.
                for sliding in SLIDES {
                    let problem = MechanismProblem::new(&mechanism, &sliding).unwrap();
                    let modes = contact_modes(&problem, Method::Enumerate).unwrap();
                    let tie = modes.answers().iter().any(|answer| answer.near_degenerate());
                    assert!(modes.consistent().count() > 0 || tie, "{case}: {sliding:?}");
                }
            }
            (by, evidence) => panic!("{case}: {by:?} {evidence:?}"),
        }
    }
    let expected =
        ["accelerating-mode", "bounded-corners", "no-solution", "not-equilibrium", "undecided"];
    assert_eq!(counts.keys().copied().collect::<Vec<_>>(), expected, "{counts:?}");
}

/// The body with joints: coordinates with random entries in M and in the rows, and no load.
fn with_joints(rigid: &Mechanism, joints: usize, random: &mut Random) -> Mechanism {
    let mut fields = rigid.fields().clone();
    let n = 3 + joints;
    let mut part = |_: usize| random.between(-0.6, 0.6);
    // M = BᵀB with the rows of a square root of the rigid part above.
    let m = DMatrix::from_fn(3, 3, |i, j| fields.mass_matrix[i][j]);
    let root = m.cholesky().unwrap().l().transpose();
    let mut b = DMatrix::zeros(n, n);
    b.view_mut((0, 0), (3, 3)).copy_from(&root);
    for k in 3..n {
        (0..n).for_each(|i| b[(i, k)] = part(i));
        b[(k, k)] += 0.5;
    }
    let m = b.transpose() * &b;
    fields.mass_matrix =
        (0..n).map(|i| (0..n).map(|j| 0.5 * (m[(i, j)] + m[(j, i)])).collect()).collect();
    for k in 3..n {
        fields.load.push(0.0);
        for contact in &mut fields.contacts {
            contact.normal.push(part(k));
            contact.tangential.push(part(k));
        }
    }
    // The load that holds the body with the same forces: −Σ JᵀF.
    if let Some(forces) = mechanism_forces(rigid) {
        for k in 3..n {
            fields.load[k] = -fields
                .contacts
                .iter()
                .zip(forces.low.iter().zip(&forces.high))
                .map(|(c, (low, high))| {
                    // The forces are those on a segment: this is its middle.
                    c.tangential[k] * 0.5 * (low[0] + high[0])
                        + c.normal[k] * 0.5 * (low[1] + high[1])
                })
                .sum::<f64>();
        }
    }
    Mechanism::new(fields).unwrap()
}

#[test]
fn a_jam_of_one_of_three_feet_is_found_in_any_coordinates() {
    let contacts = [-0.5, 0.1, 0.5].map(|x| Contact { friction: 2.5, ..Contact::at(x, 0.0) });
    let posture = Posture::new(PostureFields {
        gyration_radius: 0.3,
        center_of_mass: [0.0, 0.5],
        contacts: contacts.to_vec(),
        ..PostureFields::default()
    })
    .unwrap();
    let s = DMatrix::from_row_slice(3, 3, &[1.0, 0.5, 0.0, 0.0, 1.0, 0.3, 0.2, 0.0, 1.0]);
    let mechanism = changed(&Mechanism::of_posture(&posture).unwrap(), &s);
    let verdict = mechanism_stability(&mechanism, &StabilityOptions::default()).unwrap();
    assert_eq!(verdict.by, Some(Argument::NoSolution));
    let Some(Evidence::NoMotion(start)) = verdict.evidence else { panic!("{verdict:?}") };
    let run = simulate_mechanism(&mechanism, &start.q, &start.qdot, &Options::default()).unwrap();
    assert_eq!(run.outcome(), Outcome::Inconsistent);
}
