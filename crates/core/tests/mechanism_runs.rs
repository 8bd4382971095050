//! Runs of mechanisms: a rigid body as a mechanism moves as in its local model, and energy never rises.

#[path = "../src/math/random.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests use a part of it")]
mod random;

use random::Random;
use standfast::body::{ContactRows, Mechanism, MechanismFields};
use standfast::options::Stop;
use standfast::outcome::{ZenoMethod, ZenoPoint};
use standfast::simulate::simulate_mechanism;
use standfast::{
    Contact, Impact, Model, Options, Outcome, Posture, PostureFields, State, Trajectory, simulate,
};

fn posture(random: &mut Random, feet: usize) -> Posture {
    let contacts = (0..feet)
        .map(|k| {
            let x = -1.0 + 2.0 * k as f64 / (feet.max(2) - 1) as f64 + random.between(-0.2, 0.2);
            let slope = random.between(-0.4, 0.4);
            let contact = Contact::at(x, random.between(-0.2, 0.2)).on_slope(slope);
            Contact { friction: random.between(0.1, 1.0), ..contact }
        })
        .collect();
    Posture::new(PostureFields {
        mass: random.between(0.5, 5.0),
        gyration_radius: random.between(0.3, 1.5),
        center_of_mass: [random.between(-0.6, 0.6), random.between(0.3, 2.0)],
        contacts,
        restitution: random.between(0.0, 0.7),
        ..PostureFields::default()
    })
    .unwrap()
}

/// A start with all gaps positive.
fn start(posture: &Posture, random: &mut Random) -> State {
    loop {
        let mut part = |scale: f64| scale * random.between(-1.0, 1.0);
        let q = [part(1e-3), part(1e-3).abs() + 1e-3, part(1e-3)];
        let qdot = [part(0.1), part(0.1), part(0.1)];
        let rows = Mechanism::of_posture(posture).unwrap();
        let above = rows
            .contacts()
            .iter()
            .all(|contact| contact.normal.iter().zip(q).map(|(a, b)| a * b).sum::<f64>() > 0.0);
        if above {
            return State::new(q, qdot);
        }
    }
}

fn both(posture: &Posture, state: &State, options: &Options) -> [Trajectory; 2] {
    let mechanism = Mechanism::of_posture(posture).unwrap();
    let (q, qdot) = (state.q.as_slice(), state.qdot.as_slice());
    let one = simulate(posture, state, &Options { model: Model::Local, ..*options }).unwrap();
    [one, simulate_mechanism(&mechanism, q, qdot, options).unwrap()]
}

const LAWS: [Impact; 5] =
    [Impact::Newton, Impact::Poisson, Impact::Stronge, Impact::Moreau, Impact::ChatterjeeRuina];

/// Difference of the ends of two runs that come to rest: of their durations, relative, and of q. Zero if they do not.
fn apart(one: &Trajectory, two: &Trajectory) -> f64 {
    if one.outcome() != Outcome::Rest {
        return 0.0;
    }
    let ([q, _], [p, _]) = (one.coordinates().unwrap(), two.coordinates().unwrap());
    let far = q.iter().zip(&p).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    far.max((one.elapsed() - two.elapsed()).abs() / one.elapsed())
}

/// Runs of bodies on one to four feet, this many for each law. Most agree to 1e-14. In the others impacts amplify rounding errors: they differ
/// by no more than 1 000 times what a change of the start by 16 ulp can do, but for a few in which the end of all motion is a tie.
fn compare(each: usize) {
    let (mut runs, mut close, mut ties) = (0, 0, 0);
    for law in LAWS {
        for feet in [1, 2, 3, 4] {
            let mut random = Random(7 + feet as u64);
            for k in 0..each {
                let posture = posture(&mut random, feet);
                let state = start(&posture, &mut random);
                let options = Options { impact: law, event_limit: 20_000, ..Options::default() };
                let [one, two] = both(&posture, &state, &options);
                runs += 1;
                let off = apart(&one, &two);
                if one.outcome() == two.outcome() && off < 1e-14 {
                    close += 1;
                    continue;
                }
                let local = Options { model: Model::Local, ..options };
                let explains = |near: &Trajectory| {
                    near.outcome() != one.outcome() || off <= 1e3 * apart(&one, near)
                };
                let mut own = Random(k as u64);
                let known = (0..64).any(|_| {
                    let mut ulps = |x: f64| x * (1.0 + own.between(-16.0, 16.0) * f64::EPSILON);
                    let near = State { q: state.q.map(&mut ulps), qdot: state.qdot.map(&mut ulps) };
                    explains(&simulate(&posture, &near, &local).unwrap())
                });
                if !known {
                    assert!(
                        one.outcome() == two.outcome() && off < 1e-5,
                        "{law:?} {feet} {k}: {off:e}"
                    );
                    ties += 1;
                }
            }
        }
    }
    println!("{runs} runs: {close} to 1e-14, {ties} not explained by rounding errors of the start");
    assert!(close * 5 > runs * 4 && ties * 50 < runs, "{close} {ties} {runs}");
}

#[test]
fn a_rigid_body_moves_as_in_its_local_model() {
    compare(20);
}

#[test]
#[ignore = "takes a minute"]
fn two_thousand_rigid_bodies_move_as_in_their_local_models() {
    compare(100);
}

/// A mechanism with random inertia and rows, and a load that forces in the friction cones hold up to a part of it.
fn random_mechanism(random: &mut Random) -> Mechanism {
    let dof = 2 + (random.next() * 7.0) as usize;
    let count = 1 + (random.next() * 4.0) as usize;
    mechanism_of(random, dof, count)
}

fn mechanism_of(random: &mut Random, dof: usize, count: usize) -> Mechanism {
    let mut numbers = |n: usize| (0..n).map(|_| random.between(-1.0, 1.0)).collect::<Vec<f64>>();
    let parts: Vec<Vec<f64>> = (0..dof).map(|_| numbers(dof)).collect();
    let mass_matrix = (0..dof)
        .map(|i| {
            let dot = |j: usize| parts[i].iter().zip(&parts[j]).map(|(a, b)| a * b).sum::<f64>();
            (0..dof).map(|j| dot(j) + if i == j { 0.2 } else { 0.0 }).collect()
        })
        .collect();
    let rows: Vec<[Vec<f64>; 2]> = (0..count).map(|_| [numbers(dof), numbers(dof)]).collect();
    let mut load: Vec<f64> = numbers(dof).into_iter().map(|x| 0.3 * x).collect();
    let contacts = rows
        .into_iter()
        .map(|[normal, tangential]| {
            let (push, friction) = (random.between(0.5, 10.0), random.between(0.0, 1.2));
            let rub = friction * push * random.between(-1.0, 1.0);
            for k in 0..dof {
                load[k] -= push * normal[k] + rub * tangential[k];
            }
            let tangential_restitution = 0.0;
            let restitution = Some(random.between(0.0, 0.8));
            ContactRows { normal, tangential, friction, restitution, tangential_restitution }
        })
        .collect();
    Mechanism::new(MechanismFields { mass_matrix, load, contacts, ..MechanismFields::default() })
        .unwrap()
}

/// A displacement that opens all contacts, with a random velocity; `None` if one of a hundred random ones does not.
fn kicked(mechanism: &Mechanism, random: &mut Random) -> Option<[Vec<f64>; 2]> {
    let dof = mechanism.dof();
    (0..100).find_map(|_| {
        let mut numbers =
            |size: f64| (0..dof).map(|_| size * random.between(-1.0, 1.0)).collect::<Vec<f64>>();
        let (q, qdot) = (numbers(1e-3), numbers(0.1));
        let gap = |normal: &[f64]| normal.iter().zip(&q).map(|(a, b)| a * b).sum::<f64>();
        let opens = mechanism.contacts().iter().all(|contact| gap(&contact.normal) > 0.0);
        opens.then_some([q, qdot])
    })
}

/// The mechanism with one coefficient of restitution for all contacts and both directions.
fn with_one_restitution(mechanism: &Mechanism) -> Mechanism {
    let mut fields = mechanism.fields().clone();
    let e = fields.contacts[0].restitution.unwrap_or(fields.restitution);
    for contact in &mut fields.contacts {
        (contact.restitution, contact.tangential_restitution) = (Some(e), e);
    }
    Mechanism::new(fields).unwrap()
}

/// Runs of this number of mechanisms with every law: their energy never rises. With friction Moreau's law promises this for one coefficient of
/// restitution only. Returns the numbers of runs by outcome.
fn energies(count: usize) -> Vec<(Outcome, usize)> {
    let mut random = Random(3);
    let mut outcomes: Vec<(Outcome, usize)> = Vec::new();
    let mut runs = 0;
    while runs < count {
        let mechanism = random_mechanism(&mut random);
        let Some([q, qdot]) = kicked(&mechanism, &mut random) else { continue };
        for law in LAWS {
            if runs == count {
                break;
            }
            runs += 1;
            let one = with_one_restitution(&mechanism);
            let mechanism = if law == Impact::Moreau { &one } else { &mechanism };
            let options = Options { impact: law, event_limit: 2_000, ..Options::default() };
            let run = simulate_mechanism(mechanism, &q, &qdot, &options).unwrap();
            match outcomes.iter_mut().find(|(outcome, _)| *outcome == run.outcome()) {
                Some((_, number)) => *number += 1,
                None => outcomes.push((run.outcome(), 1)),
            }
            // The gaps are those of the coordinates. (Where a posture is unstable and the motion grows from 1 mm to 1e6 m, the estimated rounding
            // errors grow to the size of the gaps, which they may then set to zero: once in 10 000 runs.)
            let [end, _] = run.coordinates().unwrap();
            let size = end.iter().fold(1e-3_f64, |most, part| most.max(part.abs()));
            for (contact, gap) in mechanism.contacts().iter().zip(run.gaps()) {
                let of_q: f64 = contact.normal.iter().zip(&end).map(|(n, q)| n * q).sum();
                assert!(
                    size > 1e6 || (of_q - gap).abs() <= 1e-8 * size,
                    "{law:?} {runs}: {of_q} {gap}"
                );
            }
            let mut reader = run.reader();
            let mut before = f64::INFINITY;
            let first = mechanism.energy(&q, &qdot);
            let kinetic = |v: &[f64]| mechanism.energy(&vec![0.0; v.len()], v);
            let mut most = kinetic(&qdot);
            for t in run.sample_times(40).unwrap() {
                let Ok(energy) = reader.energy(t) else { continue };
                most = most.max(kinetic(&reader.coordinates(t).unwrap().unwrap()[1]));
                assert!(
                    energy <= before + 1e-9 * first.abs().max(before.abs().min(1e300)).max(1e-6),
                    "{law:?} {runs}: {before} {energy} at {t}"
                );
                before = energy;
            }
            // At rest no coordinate moves, but for speeds that count as zero.
            let left = kinetic(&run.coordinates().unwrap()[1]);
            assert!(
                run.outcome() != Outcome::Rest || left <= 1e-24 * most,
                "{law:?} {runs}: {left}"
            );
        }
    }
    outcomes
}

/// A ball that is dropped with two rotors inside it, which turn freely and which the contact does not feel.
#[test]
fn contacts_rest_and_joints_turn_for_ever() {
    let mut mass_matrix = vec![vec![0.0; 4]; 4];
    [2.0, 2.0, 0.5, 0.25].into_iter().enumerate().for_each(|(k, m)| mass_matrix[k][k] = m);
    let contact = ContactRows {
        normal: vec![0.0, 1.0, 0.0, 0.0],
        tangential: vec![1.0, 0.0, 0.0, 0.0],
        friction: 0.5,
        ..ContactRows::default()
    };
    let mechanism = Mechanism::new(MechanismFields {
        mass_matrix,
        load: vec![0.0, -20.0, 0.0, 0.0],
        contacts: vec![contact],
        restitution: 0.5,
        ..MechanismFields::default()
    })
    .unwrap();
    for (spin, outcome) in [(0.0, Outcome::Rest), (1e-20, Outcome::Rest), (0.01, Outcome::Sliding)]
    {
        let run = |options: &Options| {
            let (q, qdot) = ([0.0, 1.25, 0.0, 0.0], [0.0, 0.0, spin, 0.0]);
            simulate_mechanism(&mechanism, &q, &qdot, options).unwrap()
        };
        let first = run(&Options::default());
        assert_eq!((first.outcome(), first.touching().len()), (outcome, 1));
        let [q, qdot] = first.coordinates().unwrap();
        // It falls for 1/2 s and bounces for 2 · 1/2 s.
        let near = |value: f64, right: f64| (value - right).abs() <= 4.0 * f64::EPSILON * right;
        assert!(near(first.time(), 1.5) && near(q[2], 1.5 * spin) && near(qdot[2], spin));
        let moves = outcome == Outcome::Sliding;
        assert_eq!(first.acceleration(), moves.then(|| vec![0.0; 4]));
        assert_eq!(first.warnings().iter().any(|text| text.contains("do not feel")), moves);
        let limit = Some(101.5);
        let longer = run(&Options { stop: Stop::Time, time_limit: limit, ..Options::default() });
        assert_eq!(longer.outcome(), Outcome::TimeLimit);
        assert!(near(longer.coordinates().unwrap()[0][2], 101.5 * spin));
    }
}

#[test]
fn energy_never_rises() {
    println!("{:?}", energies(1_000));
}

#[test]
#[ignore = "takes a minute"]
fn energy_never_rises_in_ten_thousand_runs() {
    println!("{:?}", energies(10_000));
}

/// How many sums of cycles there are in some runs, and how many have tails with too many events to follow.
#[derive(Debug, Default, PartialEq)]
struct Sums {
    sums: usize,
    deep: usize,
}

/// The energy of a run does not rise. At each of its sums of cycles in which a contact lands while the other is held: the same run, followed
/// cycle by cycle until shortly before the limit of the sum, comes near this limit.
fn check_cycles(run: &Trajectory, what: &str, found: &mut Sums) {
    let mechanism = run.mechanism().unwrap();
    let [q, qdot] = run.mechanism_start().unwrap();
    let mut reader = run.reader();
    let mut before = f64::INFINITY;
    let load = &mechanism.fields().load;
    let first = mechanism.energy(q, qdot).abs();
    for t in run.sample_times(60).unwrap() {
        let (Ok(energy), Ok(Some([q, _]))) = (reader.energy(t), reader.coordinates(t)) else {
            continue;
        };
        let work: f64 = load.iter().zip(&q).map(|(f, q)| (f * q).abs()).sum();
        let allowed = 1e-11 * (first + work.min(1e300)); // rounding errors of the run and of the energy
        assert!(energy <= before + allowed, "{what}: {before} {energy} at {t}");
        before = energy;
    }
    let fastest = qdot.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let nested = |zeno: &&ZenoPoint| zeno.method == ZenoMethod::Nested;
    for zeno in run.zeno_points().iter().filter(nested) {
        let sum = run.phases().iter().find(|phase| phase.end == zeno.time).unwrap();
        let t = zeno.time - sum.start;
        found.sums += 1;
        // Largest difference of velocities, this part of the sum before its limit.
        let off = |part: f64| {
            let limit = Some(zeno.time - part * t);
            let options = Options { time_limit: limit, event_limit: 200_000, ..*run.options() };
            let run = simulate_mechanism(mechanism, q, qdot, &options).unwrap();
            let ([_, v], limit) = (run.coordinates().unwrap(), zeno.qdot.as_ref().unwrap());
            let far = v.iter().zip(limit).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            (run.outcome() == Outcome::TimeLimit).then_some(far)
        };
        let [Some(a), Some(b), Some(c), Some(last)] = [1.0, 0.6, 0.3, 1e-5].map(off) else {
            found.deep += 1;
            continue;
        };
        // Velocities differ in proportion to the time left, but for what a cycle adds to it, and for speeds that count as zero.
        let allowed = 1e-3 * a.max(b).max(c) + 1e-9 * fastest;
        assert!(last <= allowed, "{what}: {a:e} {b:e} {c:e} {last:e} at {}", zeno.time);
    }
}

/// Runs of this number of mechanisms of two contacts, of rigid bodies or with free joints.
fn cycles(count: usize, bodies: bool) -> Sums {
    let mut random = Random(17);
    let (mut found, mut runs) = (Sums::default(), 0);
    while runs < count {
        let dof = 3 + (random.next() * 4.0) as usize;
        let mechanism = match bodies {
            true => Mechanism::of_posture(&posture(&mut random, 2)).unwrap(),
            false => mechanism_of(&mut random, dof, 2),
        };
        let Some([q, qdot]) = kicked(&mechanism, &mut random) else { continue };
        let impact = LAWS[if runs % 2 == 0 { 0 } else { runs / 2 % 5 }];
        let one = with_one_restitution(&mechanism);
        let mechanism = if impact == Impact::Moreau { one } else { mechanism };
        runs += 1;
        let options =
            Options { impact, event_limit: 5_000, time_limit: Some(20.0), ..Options::default() };
        let run = simulate_mechanism(&mechanism, &q, &qdot, &options).unwrap();
        check_cycles(&run, &format!("{impact:?} {runs}"), &mut found);
    }
    found
}

fn compare_cycles(count: usize) {
    for bodies in [false, true] {
        let found = cycles(count, bodies);
        println!("{found:?}");
        assert!(2 * found.sums > count && 20 * found.deep < found.sums, "{found:?}");
    }
}

#[test]
fn sums_of_cycles_are_the_limits_of_cycles_followed_one_by_one() {
    compare_cycles(500);
}

#[test]
#[ignore = "takes three minutes"]
fn ten_thousand_runs_with_sums_of_cycles() {
    compare_cycles(10_000);
}

/// A contact that sticks in the cycles would slide at their limit: energy would rise.
#[test]
fn cycles_are_not_summed_across_a_turn_of_the_slide() {
    let mass_matrix = [
        [3.49, 2.31, -3.63, -2.92],
        [2.31, 4.19, -2.79, -1.84],
        [-3.63, -2.79, 5.72, 4.47],
        [-2.92, -1.84, 4.47, 4.08],
    ];
    let contact = |normal: [f64; 4], tangential: [f64; 4], friction: f64| ContactRows {
        normal: normal.to_vec(),
        tangential: tangential.to_vec(),
        friction,
        ..ContactRows::default()
    };
    let mechanism = Mechanism::new(MechanismFields {
        mass_matrix: mass_matrix.map(|row| row.to_vec()).to_vec(),
        load: vec![-3.99, -3.43, -10.15, 6.03],
        contacts: vec![
            contact([0.83, 0.38, 1.55, -0.75], [0.95, -1.6, -0.03, -1.93], 0.47),
            contact([0.64, 0.64, 1.77, -1.25], [-0.15, 0.47, 1.23, -0.41], 0.07),
        ],
        restitution: 0.7,
        ..MechanismFields::default()
    })
    .unwrap();
    let (q, qdot) = ([0.03, -0.01, 0.01, 0.02], [-0.81, 0.47, 0.07, 0.57]);
    let run = simulate_mechanism(&mechanism, &q, &qdot, &Options::default()).unwrap();
    check_cycles(&run, "four coordinates", &mut Sums::default());
}

/// 75 impacts at one instant, a sum of infinitely many of them, and more impacts at this instant.
#[test]
fn gaps_are_those_of_the_coordinates_after_sums_at_one_instant() {
    let mass_matrix = [
        [4.36, -2.48, -0.69, -0.22, 3.23],
        [-2.48, 2.72, -0.3, 0.91, -0.21],
        [-0.69, -0.3, 1.37, 0.78, -0.18],
        [-0.22, 0.91, 0.78, 4.45, 3.4],
        [3.23, -0.21, -0.18, 3.4, 7.41],
    ];
    let normals = [
        [-0.4, -0.6, -1.1, 1.0, -1.7],
        [-0.1, -0.7, -0.3, -0.1, 1.0],
        [0.7, 0.6, 0.0, -0.6, -0.5],
        [-0.7, 0.4, 1.0, -2.1, -0.2],
    ];
    let tangents = [
        [-1.3, 1.1, 1.4, 0.4, 1.7],
        [-0.9, 0.3, -1.4, 0.1, 0.1],
        [-0.8, 1.1, -0.2, 1.5, -2.1],
        [1.5, -0.2, -0.9, -0.1, 1.3],
    ];
    let contacts = normals.iter().zip(&tangents).map(|(normal, tangential)| ContactRows {
        normal: normal.to_vec(),
        tangential: tangential.to_vec(),
        ..ContactRows::default()
    });
    let mechanism = Mechanism::new(MechanismFields {
        mass_matrix: mass_matrix.map(|row| row.to_vec()).to_vec(),
        load: vec![0.5, 0.3, 0.4, 1.8, 1.4],
        contacts: contacts.collect(),
        ..MechanismFields::default()
    })
    .unwrap();
    let start = [0.0068, -0.0103, -0.0163, -0.0164, -0.003];
    for impact in LAWS {
        let options = Options { impact, ..Options::default() };
        let run = simulate_mechanism(&mechanism, &start, &[0.0; 5], &options).unwrap();
        assert_eq!(run.outcome(), Outcome::Rest);
        let [q, _] = run.coordinates().unwrap();
        for normal in &normals {
            let gap: f64 = normal.iter().zip(&q).map(|(n, q)| n * q).sum();
            assert!(gap.abs() < 1e-15, "{impact:?}: {gap}");
        }
    }
}
