//! Contacts that share one tangential row: blocks on a plank, and bipeds with flat feet. They slide together and stop together.

#[path = "../src/math/random.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests use a part of it")]
mod random;

use std::f64::consts::FRAC_PI_2;

use random::Random;
use standfast::body::{
    Chain, ChainFields, ContactRows, Foot, HoldingChoice, Joint, Link, Mechanism, MechanismFields,
};
use standfast::options::Stop;
use standfast::outcome::{Cause, Phase};
use standfast::simulate::simulate_mechanism;
use standfast::{Impact, Options, Outcome, Trajectory};

const G: f64 = 9.81;

/// Blocks of 1 m on a plank of 8 m on smooth ground, each on two contacts with these friction coefficients; mass and place (x) of each. The
/// plank is 1 kg and is pulled with this force. Coordinates: x, y, θ of the plank, then of each block.
fn plank(force: f64, blocks: &[(f64, f64, f64)]) -> Mechanism {
    let dof = 3 + 3 * blocks.len();
    let mut fields = MechanismFields {
        mass_matrix: vec![vec![0.0; dof]; dof],
        load: vec![0.0; dof],
        restitution: 0.0,
        ..MechanismFields::default()
    };
    let mut inertia = |first: usize, mass: f64, turn: f64| {
        for (k, part) in [mass, mass, turn].into_iter().enumerate() {
            fields.mass_matrix[first + k][first + k] = part;
        }
        fields.load[first + 1] = -mass * G;
    };
    inertia(0, 1.0, 64.25 / 12.0);
    // The rows of a point at (x, y) from the centre of a body.
    let rows = |first: usize, sign: f64, x: f64, y: f64, contact: &mut ContactRows| {
        contact.normal[first + 1] += sign;
        contact.normal[first + 2] += sign * x;
        contact.tangential[first] += sign;
        contact.tangential[first + 2] -= sign * y;
    };
    let none = |friction: f64| ContactRows {
        normal: vec![0.0; dof],
        tangential: vec![0.0; dof],
        friction,
        ..ContactRows::default()
    };
    for x in [-4.0, 4.0] {
        let mut contact = none(0.0);
        rows(0, 1.0, x, -0.25, &mut contact);
        fields.contacts.push(contact);
    }
    for (k, (mass, x, friction)) in blocks.iter().enumerate() {
        inertia(3 + 3 * k, *mass, mass / 6.0);
        for side in [-0.5, 0.5] {
            let mut contact = none(*friction);
            rows(3 + 3 * k, 1.0, side, -0.5, &mut contact);
            rows(0, -1.0, x + side, 0.25, &mut contact);
            fields.contacts.push(contact);
        }
    }
    fields.load[0] = force;
    Mechanism::new(fields).unwrap()
}

/// Speeds of the plank and of the blocks after the time t. The force is so large that no block ever sticks, so that every acceleration is
/// constant up to the next instant at which a block has the speed of the plank.
fn speeds(force: f64, blocks: &[(f64, f64, f64)], start: &[f64], t: f64) -> Vec<f64> {
    let (mut v, mut left) = (start.to_vec(), t);
    let mut behind: Vec<bool> = v[1..].iter().map(|speed| *speed <= v[0]).collect();
    loop {
        let mut a = vec![force];
        for (&(mass, _, friction), &behind) in blocks.iter().zip(&behind) {
            let pull = friction * G * if behind { 1.0 } else { -1.0 };
            a[0] -= mass * pull;
            a.push(pull);
        }
        let stop = |k: usize| (v[k + 1] - v[0]) / (a[0] - a[k + 1]);
        let next =
            (0..blocks.len()).filter(|&k| !behind[k]).min_by(|j, k| stop(*j).total_cmp(&stop(*k)));
        let dt = next.map_or(left, |k| stop(k).min(left));
        v.iter_mut().zip(&a).for_each(|(v, a)| *v += a * dt);
        left -= dt;
        match next {
            Some(k) if left > 0.0 => behind[k] = true,
            _ => return v,
        }
    }
}

fn closed(options: Options, mechanism: &Mechanism, qdot: &[f64]) -> Trajectory {
    simulate_mechanism(mechanism, &vec![0.0; mechanism.dof()], qdot, &options).unwrap()
}

/// Contacts with equal tangential rows have one letter; friction does no work.
fn check(run: &Trajectory, what: &str) {
    let mechanism = run.mechanism().unwrap();
    let contacts = mechanism.contacts();
    let mut reader = run.reader();
    let mut fastest = 0.0;
    for phase in run.phases() {
        let word: Vec<char> = phase.mode.chars().collect();
        for i in 0..word.len() {
            for j in 0..i {
                let opposite = matches!((word[i], word[j]), ('R', 'L') | ('L', 'R'));
                assert!(
                    !(opposite && contacts[i].tangential == contacts[j].tangential),
                    "{what}: {} at {}",
                    phase.mode,
                    phase.start
                );
            }
        }
        let t = 0.5 * (phase.start + phase.end);
        let (Ok(Some([_, qdot])), Ok(forces)) = (reader.coordinates(t), reader.forces(t)) else {
            continue;
        };
        // Slips are differences of speeds, with rounding errors.
        let most = |all: f64, x: &f64| all.max(x.abs());
        let rounding = 1e-12 * forces.as_flattened().iter().fold(0.0, most);
        fastest = qdot.iter().fold(fastest, most);
        for (i, contact) in contacts.iter().enumerate() {
            let slip: f64 = contact.tangential.iter().zip(&qdot).map(|(t, v)| t * v).sum();
            let power = forces[i][0] * slip;
            assert!(!(power > rounding * fastest), "{what}: {power} in {} at {t}", phase.mode);
        }
    }
    let first = reader.energy(run.phases()[0].start).unwrap();
    let mut before = f64::INFINITY;
    for t in run.sample_times(60).unwrap() {
        let (Ok(energy), Ok(Some([q, _]))) = (reader.energy(t), reader.coordinates(t)) else {
            continue;
        };
        // Rounding errors of the sum of the run and of its work.
        let work = mechanism.fields().load.iter().zip(&q).map(|(f, q)| (f * q).abs()).sum::<f64>();
        let allowed = 1e-12 * (first.abs() + work);
        assert!(energy <= before + allowed, "{what}: {before} {energy} at {t}");
        before = energy;
    }
}

/// Where the slide of one block ends, the plank pulls it on in the other direction, or the two go on together.
#[test]
fn two_contacts_of_one_block_stop_sliding_together() {
    for v0 in [1.0, 0.7, 1.0 / 3.0, -1.0, 0.123] {
        for mass in [1.0, 3.0] {
            let friction = 0.5;
            for force in [20.0 * mass, 2.0 * mass, 0.5] {
                let (run, mut start) = (plank(force, &[(mass, 0.0, friction)]), vec![0.0; 6]);
                start[3] = v0;
                let (end, grip) = (1.0, friction * G);
                let options =
                    Options { impact: Impact::Moreau, time_limit: Some(end), ..Options::default() };
                let run = closed(options, &run, &start);
                // Relative speed v0 decreases at the rate `slows` up to t1; afterwards both accelerate together, or the block is left behind.
                let way = v0.signum();
                let slows = (force + mass * grip * way) * way + grip;
                let t1 = (v0.abs() / slows).min(end);
                let together = force / (1.0 + mass);
                let pull = if together <= grip { together } else { grip };
                let right = if slows <= 0.0 {
                    v0 - way * grip * end
                } else {
                    v0 - way * grip * t1 + pull * (end - t1)
                };
                let block = run.coordinates().unwrap()[1][3];
                assert!((block - right).abs() < 1e-9, "{v0} {mass} {force}: {block} {right}");
                check(&run, "a block");
            }
        }
    }
}

#[test]
fn blocks_on_one_plank_stop_each_at_its_own_instant() {
    let mut random = Random(5);
    for k in 0..40 {
        let count = 1 + k % 3;
        let blocks: Vec<(f64, f64, f64)> = (0..count)
            .map(|n| (random.between(0.5, 2.0), 2.0 * n as f64 - 2.0, random.between(0.1, 0.6)))
            .collect();
        let force = 40.0;
        let mut start = vec![0.0; 3 + 3 * count];
        let mut scalar = vec![0.0; 1 + count];
        for n in 0..count {
            // Some blocks stop at one instant.
            let speed = if k % 4 == 0 && n > 0 { scalar[1] } else { random.between(-1.0, 3.0) };
            (start[3 + 3 * n], scalar[1 + n]) = (speed, speed);
        }
        let options =
            Options { impact: Impact::Moreau, time_limit: Some(0.5), ..Options::default() };
        let run = closed(options, &plank(force, &blocks), &start);
        let right = speeds(force, &blocks, &scalar, 0.5);
        let [_, qdot] = run.coordinates().unwrap();
        for n in 0..=count {
            assert!((qdot[3 * n] - right[n]).abs() < 1e-9, "{k}: {} {}", qdot[3 * n], right[n]);
        }
        check(&run, "blocks");
    }
}

/// A biped of a trunk, two legs and two feet that lie flat on level ground, on heel and toe each, under torques that hold it; `None` if no
/// torques do.
fn flat_footed(random: &mut Random) -> Option<Mechanism> {
    let friction = random.between(0.2, 1.0);
    let e = random.between(-0.6, 0.6).max(0.0);
    let legs = [random.between(-0.6, 0.1), random.between(-0.1, 0.6)];
    let turn = random.between(-0.2, 0.2);
    let hip = Joint { parent: Some(1), at: Some(0.0), angle: -FRAC_PI_2, ..Joint::torque() };
    let ankle = |leg: usize| Joint { parent: Some(leg), angle: FRAC_PI_2, ..Joint::torque() };
    let foot = |link: usize, at: f64| Foot { at: Some(at), friction, ..Foot::of_link(link) };
    let mut fields = ChainFields {
        links: vec![
            Link { mass: 10.0, inertia: 0.4, length: 1.0, center: Some(0.0) },
            Link::uniform(1.0, 1.0),
            Link::uniform(1.0, 1.0),
            Link::uniform(0.5, 0.3),
            Link::uniform(0.5, 0.3),
        ],
        joints: vec![hip, hip, ankle(2), ankle(3)],
        feet: vec![foot(4, 0.0), foot(4, 0.3), foot(5, 0.0), foot(5, 0.3)],
        restitution: e,
        ..ChainFields::default()
    };
    let [a, b] = legs;
    let q = [0.0, 0.0, turn, a, b, -turn - a, -turn - b];
    let held = Chain::new(fields.clone())
        .unwrap()
        .holding_torques(&q, None, HoldingChoice::Least)
        .unwrap()?;
    for (joint, torque) in fields.joints.iter_mut().zip(&held.free_torques) {
        joint.torque = *torque;
    }
    let made = Chain::new(fields).unwrap().mechanism(&q).unwrap();
    // One coefficient for all contacts and directions: only then Moreau's law never adds energy.
    let mut fields = made.fields().clone();
    for pair in [[0, 1], [2, 3]] {
        let row = fields.contacts[pair[0]].tangential.clone();
        let other = std::mem::replace(&mut fields.contacts[pair[1]].tangential, row.clone());
        assert!(row.iter().zip(&other).all(|(x, y)| (x - y).abs() < 1e-15), "{row:?} {other:?}");
    }
    fields.contacts.iter_mut().for_each(|contact| contact.tangential_restitution = e);
    Some(Mechanism::new(fields).unwrap())
}

/// The numbers of runs by outcome of this number of kicked bipeds.
fn bipeds(count: usize) -> (Vec<(Outcome, usize)>, usize) {
    let mut random = Random(11);
    let mut outcomes: Vec<(Outcome, usize)> = Vec::new();
    let (mut runs, mut slides) = (0, 0);
    while runs < count {
        let Some(biped) = flat_footed(&mut random) else { continue };
        let size = [0.01, 0.1, 1.0][runs % 3];
        // Pushed along the ground; half of them are kicked as well.
        let kick = if runs % 2 == 0 { 0.0 } else { 0.1 };
        let mut qdot: Vec<f64> = (0..7).map(|_| kick * size * random.between(-1.0, 1.0)).collect();
        qdot[0] += size * random.between(-1.0, 1.0);
        let impact = [Impact::Moreau, Impact::Newton, Impact::Poisson][runs / 3 % 3];
        runs += 1;
        let options = Options {
            impact,
            event_limit: 1_000,
            time_limit: Some(2.0),
            stop: Stop::Rest,
            ..Options::default()
        };
        let run = closed(options, &biped, &qdot);
        check(&run, &format!("biped {runs}, {impact:?}"));
        let stops = |phase: &&Phase| matches!(phase.cause, Cause::Stop(_));
        slides += usize::from(run.phases().iter().any(|phase| stops(&phase)));
        match outcomes.iter_mut().find(|(outcome, _)| *outcome == run.outcome()) {
            Some((_, number)) => *number += 1,
            None => outcomes.push((run.outcome(), 1)),
        }
    }
    (outcomes, slides)
}

#[test]
fn flat_feet_slide_as_one() {
    let (outcomes, slides) = bipeds(400);
    println!("{outcomes:?}; in {slides} a foot stops sliding");
}
