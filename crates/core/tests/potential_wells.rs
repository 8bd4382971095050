//! Bodies in a potential well: stacks of boxes.

use standfast::body::{ContactRows, Mechanism, MechanismFields};
use standfast::simulate::simulate_mechanism;
use standfast::stability::{
    Argument, Evidence, Stability, StabilityOptions, Verdict, WhyUndecided, mechanism_stability,
};
use standfast::{Impact, Options, Outcome};

const G: f64 = 9.81;

/// A box by its width, height, middle, bottom, and mass.
#[derive(Debug, Clone, Copy)]
struct Block {
    w: f64,
    h: f64,
    x: f64,
    y: f64,
    mass: f64,
}

/// A contact between a box and the box below it, or the ground; at x, with its friction.
type Touch = (usize, Option<usize>, f64, f64);

/// Boxes with q = (x, y, θ) of each, about their centres.
fn assembly(blocks: &[Block], touches: &[Touch], e: f64) -> Mechanism {
    let n = 3 * blocks.len();
    let mut mass = vec![vec![0.0; n]; n];
    let mut load = vec![0.0; n];
    for (b, block) in blocks.iter().enumerate() {
        let inertia = block.mass * (block.w * block.w + block.h * block.h) / 12.0;
        for (k, value) in [block.mass, block.mass, inertia].into_iter().enumerate() {
            mass[3 * b + k][3 * b + k] = value;
        }
        load[3 * b + 1] = -block.mass * G;
    }
    let contact = |&(on, under, x, friction): &Touch| {
        let (mut normal, mut tangential) = (vec![0.0; n], vec![0.0; n]);
        // The velocity of a point at the arm (a, c) from the centre: (ẋ − c θ̇, ẏ + a θ̇).
        let mut add = |b: usize, sign: f64, c: f64| {
            tangential[3 * b] = sign;
            tangential[3 * b + 2] = -sign * c;
            normal[3 * b + 1] = sign;
            normal[3 * b + 2] = sign * (x - blocks[b].x);
        };
        add(on, 1.0, -0.5 * blocks[on].h);
        if let Some(under) = under {
            add(under, -1.0, 0.5 * blocks[under].h);
        }
        ContactRows {
            normal,
            tangential,
            friction,
            tangential_restitution: e,
            ..ContactRows::default()
        }
    };
    Mechanism::new(MechanismFields {
        mass_matrix: mass,
        load,
        contacts: touches.iter().map(contact).collect(),
        restitution: e,
        ..MechanismFields::default()
    })
    .unwrap()
}

/// A tower of boxes (w, h, middle) of density 1, with the friction of each interface.
fn tower(boxes: &[(f64, f64, f64)], friction: &[f64], e: f64) -> Mechanism {
    let (mut blocks, mut touches, mut y) = (Vec::<Block>::new(), Vec::new(), 0.0);
    for (b, &(w, h, x)) in boxes.iter().enumerate() {
        let (mut left, mut right) = (x - 0.5 * w, x + 0.5 * w);
        if let Some(below) = blocks.last() {
            left = left.max(below.x - 0.5 * below.w);
            right = right.min(below.x + 0.5 * below.w);
        }
        touches.extend([left, right].map(|at| (b, b.checked_sub(1), at, friction[b])));
        blocks.push(Block { w, h, x, y, mass: w * h });
        y += h;
    }
    assembly(&blocks, &touches, e)
}

fn equal(n: usize, ratio: f64, friction: f64) -> Mechanism {
    tower(&vec![(ratio, 1.0, 0.0); n], &vec![friction; n], 0.3)
}

fn verdict(mechanism: &Mechanism) -> Verdict {
    mechanism_stability(mechanism, &StabilityOptions::default()).unwrap()
}

fn exact(mechanism: &Mechanism) -> Verdict {
    mechanism_stability(mechanism, &StabilityOptions { width: 0.0, ..StabilityOptions::default() })
        .unwrap()
}

fn word(verdict: &Verdict) -> &'static str {
    verdict
        .by
        .map(Argument::as_str)
        .or(verdict.reason().map(WhyUndecided::as_str))
        .unwrap_or_default()
}

fn largest(verdict: &Verdict) -> Vec<f64> {
    let Some(Evidence::PotentialWell { largest, .. }) = &verdict.evidence else {
        panic!("{verdict:?}")
    };
    largest.clone()
}

fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{found:?} {expected:?}");
    }
}

#[test]
fn two_equal_boxes_stand() {
    let found = verdict(&equal(2, 1.0, 0.5));
    assert_eq!((found.frictional_stability, word(&found)), (Stability::Stable, "potential-well"));
    near(&largest(&found), &[9.81, 9.81, 4.905, 4.905]);
    assert_eq!(found.laws, [Impact::Moreau]);
    assert_eq!(found.amplification, Ok(1.0));
    // The bound of copositivity, from elsewhere; between it and 5/6 the states of contact are tried one by one; then the stack jams.
    for friction in [0.676_407, 0.676_408, 0.83] {
        let found = verdict(&equal(2, 1.0, friction));
        assert_eq!(word(&found), "potential-well", "{friction}");
    }
}

#[test]
fn a_tower_of_equal_boxes_jams_from_the_friction_of_the_closed_form_on() {
    for (n, ratio, friction) in
        [(2, 1.0, 5.0 / 6.0), (3, 0.5, 4.0 / 9.0), (3, 1.0, 5.0 / 9.0), (3, 2.0, 17.0 / 18.0)]
    {
        for side in [-1.0, 1.0] {
            let mechanism = equal(n, ratio, friction + side * 1e-3);
            let found = verdict(&mechanism);
            let case = format!("{n} {ratio} {side} {:?}", found.evidence);
            if side < 0.0 {
                assert!(["potential-well", "jam", "many"].contains(&word(&found)), "{case}");
                println!("{n} {ratio} {}", word(&found));
                continue;
            }
            assert_eq!(word(&found), "no-solution", "{case}");
            let Some(Evidence::NoMotion(start)) = &found.evidence else { panic!("{case}") };
            let run = simulate_mechanism(&mechanism, &start.q, &start.qdot, &Options::default());
            assert_eq!(run.unwrap().outcome(), Outcome::Inconsistent, "{case}");
        }
    }
}
