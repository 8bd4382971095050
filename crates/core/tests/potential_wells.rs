//! Bodies in a potential well: stacks of boxes.

#[path = "../src/math/random.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests use a part of it")]
mod random;

use std::collections::BTreeMap;

use random::Random;
use standfast::body::{ContactRows, Mechanism, MechanismFields};
use standfast::modes::{MechanismProblem, Method, Mode, Status, contact_modes};
use standfast::simulate::simulate_mechanism;
use standfast::stability::{
    Argument, Evidence, NoMotion, Stability, StabilityOptions, Verdict, WhyUndecided,
    mechanism_stability,
};
use standfast::{Impact, Options, Outcome};

const G: f64 = 9.81;

/// A box by its width, height, middle, and mass.
#[derive(Debug, Clone, Copy)]
struct Block {
    w: f64,
    h: f64,
    x: f64,
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
    let (mut blocks, mut touches) = (Vec::<Block>::new(), Vec::new());
    for (b, &(w, h, x)) in boxes.iter().enumerate() {
        let (mut left, mut right) = (x - 0.5 * w, x + 0.5 * w);
        if let Some(below) = blocks.last() {
            left = left.max(below.x - 0.5 * below.w);
            right = right.min(below.x + 0.5 * below.w);
        }
        touches.extend([left, right].map(|at| (b, b.checked_sub(1), at, friction[b])));
        blocks.push(Block { w, h, x, mass: w * h });
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
                assert_eq!(word(&found), "potential-well", "{case}");
                continue;
            }
            assert_eq!(word(&found), "no-solution", "{case}");
            let Some(Evidence::NoMotion(start)) = &found.evidence else { panic!("{case}") };
            let run = simulate_mechanism(&mechanism, &start.q, &start.qdot, &Options::default());
            assert_eq!(run.unwrap().outcome(), Outcome::Inconsistent, "{case}");
        }
    }
}

/// A beam on two pillars.
fn bridge(beam: f64, friction: f64, e: f64) -> Mechanism {
    let box_of = |w: f64, h: f64, x: f64| Block { w, h, x, mass: w * h };
    let blocks = [box_of(0.4, 0.8, 0.0), box_of(0.5, 0.8, 1.1), box_of(1.5, 0.25, beam)];
    let at = |on, under, x| (on, under, x, friction);
    let ground = [at(0, None, -0.2), at(0, None, 0.2), at(1, None, 0.85), at(1, None, 1.35)];
    let left = beam - 0.75;
    let top = [(0, left), (0, 0.2), (1, 0.85), (1, beam + 0.75)].map(|(b, x)| at(2, Some(b), x));
    assembly(&blocks, &[ground, top].concat(), e)
}

#[test]
fn a_beam_on_two_pillars_stands() {
    let found = verdict(&bridge(0.6, 0.3, 0.3));
    assert_eq!(word(&found), "potential-well", "{found:?}");
    near(
        &largest(&found),
        &[
            3.179_053_125,
            3.968_784_782_608_7,
            4.721_062_5,
            3.801_375,
            1.839_375,
            2.399_184_782_608_7,
            2.759_062_5,
            1.839_375,
        ],
    );
}

#[test]
fn a_box_exactly_over_the_edge_turns_and_beyond_it_falls() {
    let overhang = |x| tower(&[(1.0, 0.5, 0.0), (1.0, 0.5, x)], &[0.4; 2], 0.3);
    let found = verdict(&overhang(0.5));
    assert_eq!((word(&found), found.delicate), ("boundary", true));
    let found = exact(&overhang(0.5));
    assert_eq!(word(&found), "accelerating-mode", "{found:?}");
    let Some(Evidence::Motion { velocity, word: letters }) = &found.evidence else { panic!() };
    assert_eq!(letters.to_string(), "FFSF");
    let kick: Vec<f64> = velocity.iter().map(|v| 0.01 * v).collect();
    let limit = Options { time_limit: Some(100.0), ..Options::default() };
    let run = simulate_mechanism(&overhang(0.5), &[0.0; 6], &kick, &limit).unwrap();
    assert_eq!(run.outcome(), Outcome::TimeLimit);
    assert_eq!(word(&verdict(&overhang(0.499))), "potential-well");
    assert_eq!(word(&verdict(&overhang(0.501))), "not-equilibrium");
    let three = tower(&[(1.0, 0.5, 0.0), (1.0, 0.5, 0.35), (1.0, 0.5, 0.7)], &[0.6; 3], 0.3);
    assert_eq!(word(&verdict(&three)), "not-equilibrium");
}

#[test]
fn a_level_without_friction_is_slid_along_for_ever() {
    for smooth in 0..2 {
        let mut friction = [0.4; 2];
        friction[smooth] = 0.0;
        let stack = tower(&[(1.0, 1.0, 0.0), (0.8, 0.7, 0.1)], &friction, 0.3);
        let found = verdict(&stack);
        assert_eq!(word(&found), "accelerating-mode", "{found:?}");
        let Some(Evidence::Motion { velocity, .. }) = &found.evidence else { panic!() };
        let limit = Options { time_limit: Some(100.0), ..Options::default() };
        let run = simulate_mechanism(&stack, &[0.0; 6], velocity, &limit).unwrap();
        assert_eq!(run.outcome(), Outcome::TimeLimit);
    }
    // One of two contacts with friction that always bears is enough.
    let mut fields = tower(&[(1.0, 1.0, 0.0), (0.8, 0.7, 0.1)], &[0.3; 2], 0.3).fields().clone();
    fields.contacts[0].friction = 0.0;
    let found = verdict(&Mechanism::new(fields.clone()).unwrap());
    assert_eq!(word(&found), "potential-well", "{found:?}");
    // Another law of impact, and different restitutions, are not proved.
    fields.contacts[1].tangential_restitution = 0.0;
    assert_eq!(word(&verdict(&Mechanism::new(fields).unwrap())), "law");
}

/// A kick of a stable assembly ends at rest unless the run ends first, and the energy bounds the gaps; under each law of the verdict. The number of runs that end at
/// rest.
fn comes_to_rest(
    mechanism: &Mechanism,
    found: &Verdict,
    random: &mut Random,
    events: usize,
    case: &str,
) -> usize {
    let mut ends = 0;
    let n = mechanism.dof();
    let bounds = largest(found);
    for &impact in &found.laws {
        let kick: Vec<f64> = (0..n).map(|_| 1e-3 * random.between(-1.0, 1.0)).collect();
        let energy = mechanism.energy(&vec![0.0; n], &kick);
        let options = Options { impact, event_limit: events, ..Options::default() };
        let run = simulate_mechanism(mechanism, &vec![0.0; n], &kick, &options).unwrap();
        let outcome = run.outcome();
        // Where several modes are consistent a run ends; the theorem is about all motions.
        let allowed = [Outcome::Rest, Outcome::EventLimit, Outcome::Ambiguous];
        assert!(allowed.contains(&outcome), "{case}: {outcome:?} {kick:?}");
        ends += usize::from(outcome == Outcome::Rest);
        let [q, qdot] = run.coordinates().unwrap();
        for (contact, bound) in mechanism.contacts().iter().zip(&bounds) {
            let gap: f64 = contact.normal.iter().zip(&q).map(|(a, b)| a * b).sum();
            assert!(gap * bound <= energy * (1.0 + 1e-9), "{case}: {gap} {bound} {energy}");
        }
        assert!(mechanism.energy(&q, &qdot) <= energy * (1.0 + 1e-9), "{case}");
    }
    ends
}

/// At the start of a jam the contacts that slide are closed, all others are open, and no mode is consistent.
fn jams(mechanism: &Mechanism, start: &NoMotion, case: &str) {
    let mut slides = vec![None; mechanism.contacts().len()];
    for (contact, mode) in start.contacts.iter().zip(start.slides.modes()) {
        slides[contact.index()] = Some(if mode == Mode::Right { 1 } else { -1 });
    }
    for (contact, slide) in mechanism.contacts().iter().zip(&slides) {
        let along = |row: &[f64], of: &[f64]| row.iter().zip(of).map(|(a, b)| a * b).sum::<f64>();
        let gap = along(&contact.normal, &start.q);
        if let Some(side) = slide {
            assert!(gap.abs() < 1e-18, "{case}: {gap}");
            assert!(along(&contact.normal, &start.qdot).abs() < 1e-15, "{case}");
            let slip = along(&contact.tangential, &start.qdot);
            assert!(slip * f64::from(*side) > 1e-6, "{case}: {slip}");
        } else {
            assert!(gap > 1e-9, "{case}: {gap}");
        }
    }
    let problem = MechanismProblem::new(mechanism, &slides).unwrap();
    let modes = contact_modes(&problem, Method::Enumerate).unwrap();
    assert_eq!(modes.status(), Status::None, "{case}");
}

/// What a verdict claims is seen; the number of runs that end at rest.
fn is_seen(
    mechanism: &Mechanism,
    found: &Verdict,
    random: &mut Random,
    events: usize,
    case: &str,
) -> usize {
    match (found.by, &found.evidence) {
        (Some(Argument::PotentialWell), _) => {
            return comes_to_rest(mechanism, found, random, events, case);
        }
        (Some(Argument::NoSolution), Some(Evidence::NoMotion(start))) => {
            jams(mechanism, start, case);
        }
        (Some(Argument::AcceleratingMode), Some(Evidence::Motion { velocity, .. })) => {
            let limit = Options { time_limit: Some(10.0), ..Options::default() };
            let still = vec![0.0; mechanism.dof()];
            let run = simulate_mechanism(mechanism, &still, velocity, &limit).unwrap();
            assert_eq!(run.outcome(), Outcome::TimeLimit, "{case}");
        }
        _ => {}
    }
    0
}

#[test]
fn random_towers() {
    let mut random = Random(1);
    let (mut counts, mut ends) = (BTreeMap::new(), 0);
    for case in 0..200 {
        let n = 2 + case % 2;
        let mut at = 0.0;
        let boxes: Vec<(f64, f64, f64)> = (0..n)
            .map(|_| {
                at += random.between(-0.25, 0.25);
                (random.between(0.4, 1.2), random.between(0.3, 1.0), at)
            })
            .collect();
        let friction: Vec<f64> = (0..n).map(|_| random.between(0.1, 0.9)).collect();
        let e = [0.0, 0.3, 0.7][case % 3];
        let stack = tower(&boxes, &friction, e);
        let found = verdict(&stack);
        let text = format!("{case} {boxes:?} {friction:?} {e} {:?}", found.evidence);
        let events = if case < 8 { 5000 } else { 50 };
        ends += is_seen(&stack, &found, &mut random, events, &text);
        *counts.entry(word(&found)).or_insert(0) += 1;
        // The bodies above an interface have their common centre of mass over it.
        let carried = (0..n).all(|k| {
            let weight = |b: usize| boxes[b].0 * boxes[b].1;
            let mass: f64 = (k..n).map(weight).sum();
            let center = (k..n).map(|b| weight(b) * boxes[b].2).sum::<f64>() / mass;
            let [low, high] = [0, 1].map(|side| {
                let row = &stack.contacts()[2 * k + side].normal;
                boxes[k].2 + row[3 * k + 2]
            });
            low < center && center < high
        });
        assert_eq!(found.equilibrium.holds, carried, "{text}");
        assert_eq!(word(&found) == "not-equilibrium", !carried, "{text}");
        if carried {
            assert!(found.frictional_stability != Stability::Undecided, "{text}");
        }
    }
    assert!(counts["potential-well"] > 100 && counts["no-solution"] > 10, "{counts:?}");
    assert!(ends > 3, "{ends}");
}

#[test]
fn random_bridges() {
    let mut random = Random(2);
    let (mut counts, mut ends) = (BTreeMap::new(), 0);
    for case in 0..20 {
        let e = [0.0, 0.3, 0.7][case % 3];
        let (beam, friction) = (random.between(0.3, 0.9), random.between(0.1, 0.9));
        let mechanism = bridge(beam, friction, e);
        let found = verdict(&mechanism);
        let text = format!("{case} {beam} {friction} {e} {:?}", found.evidence);
        ends += is_seen(&mechanism, &found, &mut random, 50, &text);
        *counts.entry(word(&found)).or_insert(0) += 1;
    }
    assert!(counts["potential-well"] >= 8 && counts["no-solution"] >= 5, "{counts:?} {ends}");
}

/// A mechanism with random rows, whose contacts carry the load without friction.
fn frozen(random: &mut Random, dof: usize, contacts: usize, level: usize, e: f64) -> Mechanism {
    let mut row = |from: usize| -> Vec<f64> {
        (0..dof).map(|k| if k < from { 0.0 } else { random.between(-1.0, 1.0) }).collect()
    };
    let rows: Vec<[Vec<f64>; 2]> = (0..contacts)
        .map(|i| {
            let (normal, mut tangential) = (row(level), row(level));
            if level > 0 {
                tangential[i % level] = 1.0;
            }
            [normal, tangential]
        })
        .collect();
    let mut load = vec![0.0; dof];
    for [normal, _] in &rows {
        let force = random.between(0.2, 2.0);
        load.iter_mut().zip(normal).for_each(|(sum, x)| *sum -= force * x);
    }
    let friction = random.between(0.05, 0.6);
    Mechanism::new(MechanismFields {
        mass_matrix: (0..dof)
            .map(|i| (0..dof).map(|j| if i == j { 1.0 + 0.3 * i as f64 } else { 0.1 }).collect())
            .collect(),
        load,
        contacts: rows
            .into_iter()
            .map(|[normal, tangential]| ContactRows {
                normal,
                tangential,
                friction,
                tangential_restitution: e,
                ..ContactRows::default()
            })
            .collect(),
        restitution: e,
        ..MechanismFields::default()
    })
    .unwrap()
}

#[test]
fn random_rows() {
    let mut random = Random(3);
    let (mut counts, mut ends) = (BTreeMap::new(), 0);
    for case in 0..300 {
        let e = [0.0, 0.3, 0.7][case % 3];
        let (dof, contacts, level) = [(4, 5, 0), (5, 6, 0), (5, 4, 1), (6, 5, 2)][case % 4];
        let mechanism = frozen(&mut random, dof, contacts, level, e);
        let found = verdict(&mechanism);
        let text = format!("{case} {:?}", found.evidence);
        ends += is_seen(&mechanism, &found, &mut random, 50, &text);
        *counts.entry((level, word(&found))).or_insert(0) += 1;
    }
    for (level, least) in [(0, 60), (1, 10), (2, 30)] {
        assert!(counts[&(level, "potential-well")] >= least, "{counts:?} {ends}");
    }
}
