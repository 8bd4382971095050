//! Chains of links: bipeds against values computed with other programs; random trees against rigid bodies, against sums over their links and
//! against brute force; wrong input.

#[path = "../src/math/random.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests use a part of it")]
mod random;

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{DMatrix, DVector, Vector2};
use random::Random;
use standfast::body::{
    Base, Chain, ChainFields, Foot, GroundKind, HoldingChoice, HoldingTorques, Joint, JointKind,
    Link, Mechanism, MechanismFields,
};
use standfast::{Contact, Posture, PostureFields};

/// A trunk of 10 kg with I = 0.4 about the hip, and two uniform legs of 1 m and 1 kg on the hip. q = (x, y, θ, a, b): θ is the angle of the
/// trunk, whose axis lies along +x at θ = 0; the legs make the angles θ + a and θ + b with the direction straight down.
fn biped(joint: Joint, slopes: [f64; 2], friction: f64) -> ChainFields {
    let hip = Joint { parent: Some(1), at: Some(0.0), angle: -FRAC_PI_2, ..joint };
    let foot = |k: usize| Foot { slope: slopes[k], friction, ..Foot::of_link(k + 2) };
    ChainFields {
        links: vec![
            Link { mass: 10.0, inertia: 0.4, length: 1.0, center: Some(0.0) },
            Link::uniform(1.0, 1.0),
            Link::uniform(1.0, 1.0),
        ],
        joints: vec![hip; 2],
        feet: vec![foot(0), foot(1)],
        ..ChainFields::default()
    }
}

fn chain(fields: ChainFields) -> Chain {
    Chain::new(fields).unwrap_or_else(|e| panic!("{e}"))
}

/// Index of N_1, N_2, T_1, T_2 in an order contact by contact (tangential, normal).
const ORDER: [usize; 4] = [1, 3, 0, 2];

fn w(mechanism: &Mechanism, i: usize, j: usize) -> f64 {
    mechanism.contact_space().w()[(ORDER[i - 1], ORDER[j - 1])]
}

const LEAST: HoldingChoice = HoldingChoice::Least;

fn close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} {expected}");
}

#[test]
fn a_biped() {
    let q = [0.0, 0.0, 0.1, -0.5, 0.6];
    let with = |joint: Joint| chain(biped(joint, [0.3, -0.25], 0.5));
    let locked = with(Joint::locked()).mechanism(&q).unwrap();
    assert_eq!((locked.contact_space().rank(), &locked.fields().locked), (3, &vec![3, 4]));
    for (i, j, value) in [
        (1, 1, 0.482349558),
        (1, 2, -0.423789611),
        (1, 3, -0.437428509),
        (2, 2, 0.696992631),
        (3, 3, 0.562871981),
    ] {
        close(w(&locked, i, j), value, 1e-9);
    }
    let b = |mechanism: &Mechanism| ORDER.map(|k| mechanism.contact_space().b()[k]);
    let expected = [-9.371850958, -9.505030857, -2.899053227, 2.42703284];
    b(&locked).iter().zip(expected).for_each(|(value, expected)| close(*value, expected, 1e-9));
    let [one, two] = locked.local().unwrap().psi();
    close(one, 0.8785943811, 1e-9);
    close(two, 0.6080259568, 1e-9);

    // The torques of the least |τ|² + |f|² without cones.
    let torqued = with(Joint::torque());
    let (e, h) = equations(&torqued, &q);
    let least = e.svd(true, true).solve(&h, 1e-12).unwrap();
    close(least[0], 16.148336405, 1e-9);
    close(least[1], -16.148336405, 1e-9);
    let torqued = torqued.mechanism_under(&q, &[least[0], least[1]]).unwrap();
    assert_eq!(torqued.contact_space().rank(), 4);
    for (i, j, value) in [(1, 1, 1.306920593), (1, 2, -0.02840302), (3, 3, 1.803376937)] {
        close(w(&torqued, i, j), value, 1e-9);
    }
    let expected = [-39.524256935, -48.291975487, 35.790319262, -27.599756133];
    b(&torqued).iter().zip(expected).for_each(|(value, expected)| close(*value, expected, 1e-8));
    let [one, two] = torqued.local().unwrap().psi();
    close(one, 0.0217327815, 1e-9);
    close(two, 0.0139869638, 1e-9);

    let geared = with(Joint { armature: 1.0, ..Joint::torque() }).mechanism(&q).unwrap();
    let [one, two] = geared.local().unwrap().psi();
    close(one, 0.4372888897, 1e-9);
    close(two, 0.2928251793, 1e-9);
}

/// k_i^σ = N_i M⁻¹(N_i − σμT_i)ᵀ; σ = −1 for a slide to the left.
fn k(mechanism: &Mechanism, i: usize, sign: f64) -> f64 {
    let (w, mu) = (mechanism.contact_space().w(), mechanism.contacts()[i].friction);
    w[(2 * i + 1, 2 * i + 1)] - sign * mu * w[(2 * i + 1, 2 * i)]
}

#[test]
fn a_biped_that_jams_without_its_gears() {
    let q = [0.0, 0.0, -0.166, -0.325, 0.841];
    let of = |joint: Joint| {
        k(&chain(biped(joint, [-0.066, -0.091], 0.667)).mechanism(&q).unwrap(), 0, -1.0)
    };
    let geared = |armature: f64| of(Joint { armature, ..Joint::torque() });
    close(of(Joint::locked()), 0.02518, 5e-6);
    close(geared(10.0), 0.020531, 5e-7);
    close(geared(1.0), -0.011704, 5e-7);
    close(of(Joint::torque()), -0.147986, 5e-7);
    close(geared(1.602467664252), 0.0, 1e-12);
    assert!(geared(1.6024676642) < 0.0 && geared(1.6024676643) > 0.0);
}

#[test]
fn free_joints_make_bipeds_jam_and_never_the_reverse() {
    let mut random = Random(20_260_101);
    let mut counts = [0.0; 4]; // fine/fine, fine/jam, jam/jam, jam/fine (locked/torque)
    for _ in 0..2000 {
        let q = [
            0.0,
            0.0,
            random.between(-0.3, 0.3),
            random.between(-0.9, -0.1),
            random.between(0.1, 0.9),
        ];
        let slopes = [0, 1].map(|_| random.between(-0.4, 0.4));
        let friction = random.between(0.3, 0.9);
        let jams = |joint: Joint| {
            let mechanism = chain(biped(joint, slopes, friction)).mechanism(&q).unwrap();
            [0, 1].iter().any(|&i| [1.0, -1.0].iter().any(|sign| k(&mechanism, i, *sign) < 0.0))
        };
        counts[match (jams(Joint::locked()), jams(Joint::torque())) {
            (false, false) => 0,
            (false, true) => 1,
            (true, true) => 2,
            (true, false) => 3,
        }] += 1.0;
    }
    println!("fine/fine, fine/jam, jam/jam, jam/fine: {counts:?}");
    for (count, expected) in counts.into_iter().zip([774.0, 800.0, 426.0, 0.0]) {
        // Both counts are samples of 2000.
        let deviation = (2.0 * expected * (1.0 - expected / 2000.0_f64)).sqrt();
        assert!((count - expected).abs() <= 4.0 * deviation, "{counts:?}");
    }
}

/// A random floating tree of 1 to 8 links with these joints and one to four feet, and a random configuration.
fn tree(random: &mut Random, joint: &dyn Fn(&mut Random) -> Joint) -> (ChainFields, Vec<f64>) {
    let whole = |random: &mut Random, low: usize, high: usize| {
        low + (random.bits() % (high - low + 1) as u64) as usize
    };
    let maybe = |random: &mut Random, value: f64| (random.next() < 0.5).then_some(value);
    let count = whole(random, 1, 8);
    let links: Vec<Link> = (0..count)
        .map(|_| {
            let (mass, length) = (random.between(0.1, 3.0), random.between(0.2, 1.5));
            let (inertia, center) = (mass * random.between(0.01, 0.3), random.between(0.0, length));
            Link { mass, inertia, length, center: maybe(random, center) }
        })
        .collect();
    let joints = (1..count)
        .map(|link| {
            let (parent, at) = (whole(random, 1, link), random.between(0.0, 1.0));
            let parent = (random.next() < 0.7).then_some(parent);
            let angle = random.between(-PI, PI);
            Joint { parent, at: maybe(random, at), angle, ..joint(random) }
        })
        .collect();
    let feet = (0..whole(random, 1, 4))
        .map(|_| {
            let (at, slope) = (random.between(0.0, 1.2), random.between(-0.6, 0.6));
            let friction = if random.next() < 0.2 { 0.0 } else { random.between(0.2, 1.0) };
            Foot {
                at: maybe(random, at),
                slope,
                friction,
                ..Foot::of_link(whole(random, 1, count))
            }
        })
        .collect();
    let q = (0..count + 2).map(|_| random.between(-2.0, 2.0)).collect();
    (ChainFields { links, joints, feet, ..ChainFields::default() }, q)
}

/// Of a link: its number of the parent from 0, the angle, the near end and the centre; and their rates at the velocity q̇.
struct Moving {
    angle: f64,
    rate: f64,
    near: Vector2<f64>,
    velocity: Vector2<f64>,
}

/// The motion of the links, by recursion along the chain.
fn moving(fields: &ChainFields, q: &[f64], qdot: &[f64]) -> Vec<Moving> {
    let first = if fields.base == Base::Floating { 2 } else { 0 };
    let mut all: Vec<Moving> = Vec::new();
    for l in 0..fields.links.len() {
        let (turn, turning) = (q[first + l], qdot[first + l]);
        let joint =
            (l + fields.joints.len()).checked_sub(fields.links.len()).map(|k| &fields.joints[k]);
        all.push(if l == 0 {
            let place =
                |of: &[f64]| if first == 2 { Vector2::new(of[0], of[1]) } else { Vector2::zeros() };
            let angle = joint.map_or(0.0, |joint| joint.angle);
            Moving { angle: angle + turn, rate: turning, near: place(q), velocity: place(qdot) }
        } else {
            let joint = joint.unwrap();
            let parent = joint.parent.map_or(l - 1, |parent| parent - 1);
            let before = &all[parent];
            let (near, velocity) = point(before, joint.at.unwrap_or(fields.links[parent].length));
            let (angle, rate) = (before.angle + joint.angle + turn, before.rate + turning);
            Moving { angle, rate, near, velocity }
        });
    }
    all
}

/// Position and velocity of a point at this distance along a link.
fn point(link: &Moving, at: f64) -> (Vector2<f64>, Vector2<f64>) {
    let (sin, cos) = link.angle.sin_cos();
    (
        link.near + at * Vector2::new(cos, sin),
        link.velocity + at * link.rate * Vector2::new(-sin, cos),
    )
}

fn center(link: &Link) -> f64 {
    link.center.unwrap_or(0.5 * link.length)
}

#[test]
fn a_chain_with_locked_joints_is_a_rigid_body() {
    let mut random = Random(11);
    let mut worst: f64 = 0.0;
    for case in 0..2000 {
        let (fields, q) = tree(&mut random, &|_| Joint::locked());
        let still = vec![0.0; q.len()];
        let links = moving(&fields, &q, &still);
        let parts = || links.iter().zip(&fields.links);
        let mass: f64 = fields.links.iter().map(|link| link.mass).sum();
        let center_of_mass =
            parts().map(|(at, link)| point(at, center(link)).0 * link.mass).sum::<Vector2<f64>>()
                / mass;
        let inertia: f64 = parts()
            .map(|(at, link)| {
                let arm = point(at, center(link)).0 - center_of_mass;
                link.inertia + link.mass * arm.norm_squared()
            })
            .sum();
        let contacts = fields.feet.iter().map(|foot| {
            let at = foot.at.unwrap_or(fields.links[foot.link - 1].length);
            let point = point(&links[foot.link - 1], at).0;
            Contact {
                friction: foot.friction,
                ..Contact::at(point.x, point.y).on_slope(foot.slope)
            }
        });
        let body = Posture::new(PostureFields {
            mass,
            gyration_radius: (inertia / mass).sqrt(),
            center_of_mass: center_of_mass.into(),
            contacts: contacts.collect(),
            ground: GroundKind::Own,
            ..PostureFields::default()
        })
        .unwrap_or_else(|e| panic!("{case}: {e}"));
        let body = Mechanism::of_posture(&body).unwrap_or_else(|e| panic!("{case}: {e}"));
        let locked = chain(fields.clone());
        let own = locked.center_of_mass(&q).unwrap();
        assert!((Vector2::from(own) - center_of_mass).norm() < 1e-14);
        let locked = locked.mechanism(&q).unwrap_or_else(|e| panic!("{case}: {e}"));
        let [one, other] = [&locked, &body].map(Mechanism::contact_space);
        assert_eq!(one.rank(), other.rank(), "{case}");
        let off = (one.w() - other.w()).amax() / other.w().amax();
        let off = off.max((one.b() - other.b()).amax() / other.b().amax());
        assert!(off < 1e-13, "{case}: {off:e}");
        worst = worst.max(off);
    }
    println!("largest relative difference: {worst:e}");
}

#[test]
fn freer_joints_move_more() {
    let mut random = Random(12);
    let mut least = f64::INFINITY;
    for case in 0..500 {
        let (mut fields, q) = tree(&mut random, &|random| Joint {
            armature: random.between(0.1, 2.0),
            ..Joint::locked()
        });
        let space = |fields: &ChainFields| {
            let mechanism =
                chain(fields.clone()).mechanism(&q).unwrap_or_else(|e| panic!("{case}: {e}"));
            mechanism.contact_space().w().clone()
        };
        let locked = space(&fields);
        fields.joints.iter_mut().for_each(|joint| joint.kind = JointKind::Torque);
        let geared = space(&fields);
        fields.joints.iter_mut().for_each(|joint| joint.armature = 0.0);
        let free = space(&fields);
        for difference in [&geared - &locked, &free - &geared] {
            let size = free.amax().max(1.0);
            let smallest = difference.symmetric_eigenvalues().min() / size;
            assert!(smallest >= -1e-12, "{case}: {smallest:e}");
            least = least.min(smallest);
        }
    }
    println!("least eigenvalue of a difference: {least:e}");
}

#[test]
fn energies_and_rows_are_sums_over_the_links() {
    let mut random = Random(13);
    for case in 0..500 {
        let (mut fields, mut q) = tree(&mut random, &|_| Joint::torque());
        if case % 2 == 1 {
            fields.base = Base::Pinned;
            fields.joints.insert(0, Joint { angle: 0.3, ..Joint::torque() });
            q.truncate(fields.links.len());
        }
        let qdot: Vec<f64> = q.iter().map(|_| random.between(-2.0, 2.0)).collect();
        let whole = chain(fields.clone());
        let links = moving(&fields, &q, &qdot);
        let kinetic: f64 = links
            .iter()
            .zip(&fields.links)
            .map(|(at, link)| {
                let velocity = point(at, center(link)).1;
                0.5 * (link.mass * velocity.norm_squared() + link.inertia * at.rate * at.rate)
            })
            .sum();
        // A foot that one joint moves is no contact of a mechanism.
        if let Ok(mechanism) = whole.mechanism(&q) {
            let v = DVector::from_row_slice(&qdot);
            let rows = &mechanism.fields().mass_matrix;
            let m = DMatrix::from_fn(q.len(), q.len(), |i, j| rows[i][j]);
            close(0.5 * v.dot(&(&m * &v)), kinetic, 1e-12 * kinetic);
            assert_eq!(m, m.transpose());
            for (foot, contact) in fields.feet.iter().zip(mechanism.contacts()) {
                let at = foot.at.unwrap_or(fields.links[foot.link - 1].length);
                let velocity = point(&links[foot.link - 1], at).1;
                let (sin, cos) = foot.slope.sin_cos();
                let along = |row: &[f64]| v.dot(&DVector::from_row_slice(row));
                close(
                    along(&contact.tangential),
                    velocity.dot(&Vector2::new(cos, sin)),
                    1e-13 * (1.0 + velocity.norm()) * 8.0,
                );
                close(
                    along(&contact.normal),
                    velocity.dot(&Vector2::new(-sin, cos)),
                    1e-13 * (1.0 + velocity.norm()) * 8.0,
                );
            }
        } else {
            let on_first = fields.feet.iter().any(|foot| foot.link == 1);
            assert!(fields.base == Base::Pinned && on_first, "{case}");
        }
        // h is the gradient of the potential energy: a difference quotient of fourth order.
        let mass: f64 = fields.links.iter().map(|link| link.mass).sum();
        let potential = |k: usize, by: f64| {
            let mut moved = q.clone();
            moved[k] += by;
            mass * 9.81 * whole.center_of_mass(&moved).unwrap()[1]
        };
        let bias = whole.bias(&q).unwrap();
        for (k, value) in bias.iter().enumerate() {
            let slope = |by: f64| (potential(k, by) - potential(k, -by)) / (2.0 * by);
            let quotient = (4.0 * slope(1e-3) - slope(2e-3)) / 3.0;
            close(
                *value,
                quotient,
                1e-9 * (1.0 + bias.iter().fold(0.0, |most: f64, h| most.max(h.abs()))),
            );
        }
        for (place, foot) in whole.points(&q).unwrap().feet.iter().zip(&fields.feet) {
            let at = foot.at.unwrap_or(fields.links[foot.link - 1].length);
            assert!((point(&links[foot.link - 1], at).0 - Vector2::from(*place)).norm() < 1e-13);
        }
    }
}

/// The equations of (τ, f) in the coordinates that are not locked, and h there: columns of the torques, then (t, n) of each foot.
fn equations(chain: &Chain, q: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let mechanism = chain.mechanism(q).unwrap();
    let free: Vec<usize> =
        (0..chain.dof()).filter(|k| !mechanism.fields().locked.contains(k)).collect();
    let bias = chain.bias(q).unwrap();
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for coordinate in free.iter().filter(|k| **k >= 3) {
        columns.push(DVector::from_iterator(
            free.len(),
            free.iter().map(|k| f64::from(u8::from(k == coordinate))),
        ));
    }
    for contact in mechanism.contacts() {
        for row in [&contact.tangential, &contact.normal] {
            columns.push(DVector::from_iterator(free.len(), free.iter().map(|k| row[*k])));
        }
    }
    (
        DMatrix::from_columns(&columns),
        DVector::from_iterator(free.len(), free.iter().map(|k| bias[*k])),
    )
}

/// (τ, f) as one vector.
fn stacked(torques: &[f64], forces: &[[f64; 2]]) -> DVector<f64> {
    DVector::from_iterator(
        torques.len() + 2 * forces.len(),
        torques.iter().copied().chain(forces.iter().flatten().copied()),
    )
}

/// Inward rows of the friction cones in the coordinates (τ, f), and rows that are zero without friction.
fn cone_rows(chain: &Chain, torques: usize) -> (Vec<DVector<f64>>, Vec<DVector<f64>>) {
    let feet = &chain.fields().feet;
    let unit = |at: usize, t: f64, n: f64| {
        let mut row = DVector::zeros(torques + 2 * feet.len());
        (row[torques + 2 * at], row[torques + 2 * at + 1]) = (t, n);
        row
    };
    let (mut inward, mut zero) = (Vec::new(), Vec::new());
    for (k, foot) in feet.iter().enumerate() {
        if foot.friction == 0.0 {
            inward.push(unit(k, 0.0, 1.0));
            zero.push(unit(k, 1.0, 0.0));
        } else {
            inward.extend([1.0, -1.0].map(|side| unit(k, side, foot.friction)));
        }
    }
    (inward, zero)
}

/// Extremes of every component of (τ, f) over the vertices of the polyhedron, where three edges of cones at most carry load.
fn vertices(chain: &Chain, q: &[f64], torques: usize) -> Option<(DVector<f64>, DVector<f64>)> {
    let (e, h) = equations(chain, q);
    let feet = &chain.fields().feet;
    let edges: Vec<(usize, f64)> = feet
        .iter()
        .enumerate()
        .flat_map(|(k, foot)| match foot.friction {
            0.0 => vec![(k, 0.0)],
            mu => vec![(k, mu), (k, -mu)],
        })
        .collect();
    let column =
        |&(k, t): &(usize, f64)| e.column(torques + 2 * k) * t + e.column(torques + 2 * k + 1);
    let mut found: Option<(DVector<f64>, DVector<f64>)> = None;
    let n = edges.len();
    for (i, j, k) in
        (0..n).flat_map(|i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| (i, j, k))))
    {
        let base =
            DMatrix::from_columns(&[i, j, k].map(|at| column(&edges[at]).rows(0, 3).into_owned()));
        let Some(inverse) =
            base.clone().try_inverse().filter(|inverse| (inverse.amax() * base.amax()) < 1e9)
        else {
            continue;
        };
        let a = inverse * h.rows(0, 3);
        if a.iter().any(|x| *x < -1e-9 * a.amax()) {
            continue;
        }
        let mut point = DVector::zeros(e.ncols());
        for (weight, at) in a.iter().zip([i, j, k]) {
            let (foot, t) = edges[at];
            point[torques + 2 * foot] += weight * t;
            point[torques + 2 * foot + 1] += weight;
        }
        let rest = &h - &e * &point;
        (0..torques).for_each(|k| point[k] = rest[3 + k]);
        found = Some(match found {
            None => (point.clone(), point),
            Some((low, high)) => (low.inf(&point), high.sup(&point)),
        });
    }
    found
}

/// Distance of `target` from the set of all Σ ν_i e_i + Σ λ_k a_k with λ ≥ 0: e_i are taken out by projection, λ by an active set
/// [Lawson & Hanson 1974, chapter 23].
fn distance(target: &DVector<f64>, equations: &[DVector<f64>], active: &[DVector<f64>]) -> f64 {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for row in equations {
        let mut rest = row / row.norm().max(1e-300);
        for _ in 0..2 {
            basis.iter().for_each(|axis| rest -= axis * axis.dot(&rest));
        }
        if rest.norm() > 1e-10 {
            basis.push(rest.normalize());
        }
    }
    let projected = |vector: &DVector<f64>| {
        let mut rest = vector.clone();
        for _ in 0..2 {
            basis.iter().for_each(|axis| rest -= axis * axis.dot(&rest));
        }
        rest
    };
    let columns: Vec<DVector<f64>> = active.iter().map(projected).collect();
    let target = projected(target);
    let solved = |chosen: &[usize]| {
        if chosen.is_empty() {
            return DVector::zeros(0);
        }
        let matrix =
            DMatrix::from_columns(&chosen.iter().map(|&k| columns[k].clone()).collect::<Vec<_>>());
        matrix.svd(true, true).solve(&target, 1e-13).unwrap()
    };
    let mut weights = vec![0.0_f64; columns.len()];
    let mut chosen: Vec<usize> = Vec::new();
    let mut residual = target.clone();
    for _ in 0..10 * columns.len() {
        let gain = |k: usize| columns[k].dot(&residual) / columns[k].norm().max(1e-10);
        let best = (0..columns.len())
            .filter(|k| !chosen.contains(k))
            .max_by(|&i, &j| gain(i).total_cmp(&gain(j)));
        let Some(next) = best.filter(|&k| gain(k) > 1e-12 * target.norm()) else { break };
        chosen.push(next);
        loop {
            let wanted = solved(&chosen);
            let step = chosen
                .iter()
                .zip(wanted.iter())
                .filter(|(_, want)| **want <= 0.0)
                .map(|(&k, want)| weights[k] / (weights[k] - want))
                .fold(1.0, f64::min);
            for (&k, want) in chosen.iter().zip(wanted.iter()) {
                weights[k] += step * (want - weights[k]);
            }
            if step == 1.0 {
                break;
            }
            chosen.retain(|&k| weights[k] > 1e-14);
        }
        residual = target.clone();
        (0..columns.len()).for_each(|k| residual -= &columns[k] * weights[k]);
    }
    residual.norm()
}

/// Checks the least |τ|², and of these the least |f|², by the conditions of Karush, Kuhn and Tucker: (τ, 0) = Eᵀν + Gᵀλ with λ ≥ 0 on the
/// active rows of the cones, and f = E_fᵀν + G_fᵀλ.
fn is_least(chain: &Chain, q: &[f64], held: &HoldingTorques, case: usize) {
    let (e, h) = equations(chain, q);
    let w = stacked(&held.torques, &held.forces);
    let torques = held.torques.len();
    let size = w.amax().max(1.0);
    assert!((&e * &w - &h).amax() < 1e-11 * size, "{case}: {:e}", (&e * &w - &h).amax());
    let (inward, zero) = cone_rows(chain, torques);
    assert!(inward.iter().all(|row| row.dot(&w) > -1e-11 * size), "{case}");
    assert!(zero.iter().all(|row| row.dot(&w) == 0.0), "{case}");
    let active: Vec<DVector<f64>> =
        inward.into_iter().filter(|row| row.dot(&w) < 1e-9 * size).collect();
    let mut rows: Vec<DVector<f64>> = e.row_iter().map(|row| row.transpose()).collect();
    rows.extend(zero);
    let mut gradient = w.clone();
    gradient.rows_mut(torques, w.len() - torques).fill(0.0);
    let miss = distance(&gradient, &rows, &active);
    assert!(miss < 1e-7 * size, "{case}: least torques {miss:e} of {size}");
    let forces = |rows: &[DVector<f64>]| -> Vec<DVector<f64>> {
        rows.iter().map(|row| row.rows(torques, w.len() - torques).into_owned()).collect()
    };
    let own = w.rows(torques, w.len() - torques).into_owned();
    let miss = distance(&own, &forces(&rows), &forces(&active));
    assert!(miss < 1e-7 * size, "{case}: least forces {miss:e} of {size}");
}

#[test]
fn holding_torques_of_random_chains() {
    let mut random = Random(14);
    let mut seen = [0; 9]; // by freedom
    let (mut none, mut bounded) = (0, 0);
    for case in 0..3000 {
        let (fields, q) = tree(&mut random, &|random| match random.next() < 0.5 {
            true => Joint::torque(),
            false => Joint::locked(),
        });
        let whole = chain(fields.clone());
        let held = whole.holding_torques(&q, None, LEAST).unwrap();
        let torques = fields.joints.iter().filter(|joint| joint.kind == JointKind::Torque).count();
        let corners = vertices(&whole, &q, torques);
        let Some(held) = held else {
            assert!(corners.is_none(), "{case}");
            none += 1;
            continue;
        };
        seen[held.freedom] += 1;
        is_least(&whole, &q, &held, case);
        let w = stacked(&held.torques, &held.forces);
        let ends = |side: usize, forces: &[[f64; 2]]| {
            let torques: Vec<f64> =
                held.torque_interval.iter().map(|interval| interval[side]).collect();
            stacked(&torques, forces)
        };
        let (low, high) = (ends(0, &held.force_low), ends(1, &held.force_high));
        let size = w.amax().max(1.0);
        for k in 0..w.len() {
            assert!(low[k] - 1e-9 * size <= w[k] && w[k] <= high[k] + 1e-9 * size, "{case}");
        }
        if let Some((least, most)) = corners {
            for k in 0..w.len() {
                let slack = 1e-8 * (least.amax() + most.amax());
                if low[k].is_finite() {
                    assert!((low[k] - least[k]).abs() <= slack, "{case}: {} {}", low[k], least[k]);
                    bounded += 1;
                }
                if high[k].is_finite() {
                    assert!((high[k] - most[k]).abs() <= slack, "{case}: {} {}", high[k], most[k]);
                    bounded += 1;
                }
            }
        }
        let free = stacked(&held.free_torques, &held.free_forces);
        let (e, h) = equations(&whole, &q);
        assert!((&e * &free - &h).amax() < 1e-11 * size, "{case}");
        let norm = |torques: &[f64]| torques.iter().map(|x| x * x).sum::<f64>();
        assert!(norm(&held.free_torques) <= norm(&held.torques) + 1e-12 * size * size, "{case}");
        assert_eq!(held.internal_force.is_some(), held.freedom == 1);
        let middle =
            whole.holding_torques(&q, None, HoldingChoice::Middle).unwrap().expect("it is held");
        if let Some([s_low, s_high]) = held.internal_force {
            let unit = stacked(&held.internal_torques, &held.internal_forces);
            let (own, all) = (norm(&held.internal_torques), unit.norm_squared());
            close(if own < 1e-12 * all { all } else { own }, 1.0, 1e-12);
            assert!((&e * &unit).amax() < 1e-11 * unit.amax(), "{case}");
            let first = unit.iter().find(|x| x.abs() > 1e-9).unwrap();
            assert!(*first > 0.0, "{case}");
            let s = (&w - &free).dot(&unit) / all;
            close(s, 0.0_f64.clamp(s_low, s_high), 1e-9 * size);
            let at = |s: f64, k: usize| {
                if unit[k].abs() < 1e-9 { free[k] } else { free[k] + s * unit[k] }
            };
            let slack = 1e-8 * size;
            for k in 0..w.len() {
                let (one, two) = (at(s_low, k), at(s_high, k));
                let same =
                    |x: f64, y: f64| x == y || (x - y).abs() <= slack * (1.0 + x.abs() / size);
                assert!(same(low[k], one.min(two)) && same(high[k], one.max(two)), "{case}");
            }
            let half = 0.5 * (s_low + s_high);
            if half.is_finite() {
                let found = stacked(&middle.torques, &middle.forces);
                (0..w.len()).for_each(|k| close(found[k], at(half, k), slack));
            } else {
                assert_eq!(middle, held);
            }
        } else {
            assert_eq!(middle, held);
        }
        // Feet, links and gravity in other units of length: the torques are those of the new unit.
        if case % 10 == 0 {
            let scale = 1000.0;
            let mut fields = fields.clone();
            fields.gravity *= scale;
            for link in &mut fields.links {
                link.length *= scale;
                link.center = link.center.map(|at| at * scale);
                link.inertia *= scale * scale;
            }
            fields.joints.iter_mut().for_each(|joint| joint.at = joint.at.map(|at| at * scale));
            fields.feet.iter_mut().for_each(|foot| foot.at = foot.at.map(|at| at * scale));
            let mut q = q.clone();
            (0..fields.links.len() + 2 - fields.links.len()).for_each(|k| q[k] *= scale);
            let other =
                chain(fields).holding_torques(&q, None, LEAST).unwrap().expect("it is held");
            let factor = scale * scale;
            let largest = held.torques.iter().fold(size, |a, b| a.max(b.abs()));
            for (one, two) in held.torques.iter().zip(&other.torques) {
                close(one * factor, *two, 1e-9 * largest * factor);
            }
        }
    }
    println!("no forces: {none}; by freedom: {seen:?}; bounds compared: {bounded}");
    assert!(none > 500 && seen[1] > 100 && seen[3] > 50 && seen[5] > 20 && bounded > 1000);
}

#[test]
fn forces_of_some_feet() {
    let q = [0.0, 0.0, 0.05, -0.4, 0.5];
    let whole = chain(biped(Joint::torque(), [0.1, -0.2], 0.9));
    let both = whole.holding_torques(&q, None, LEAST).unwrap().expect("it stands");
    assert_eq!(whole.holding_torques(&q, Some(&[1, 2]), LEAST).unwrap(), Some(both));
    let turned = whole.holding_torques(&q, Some(&[2, 1]), LEAST).unwrap().expect("it stands");
    assert_eq!(turned.contacts, [2, 1]);
    assert_eq!(whole.holding_torques(&q, Some(&[1]), LEAST).unwrap(), None);
    // One foot under the centre of mass carries the weight of 120 N.
    let upright = [0.0, 0.0, 0.0, 0.0, 0.0];
    let whole = chain(ChainFields { gravity: 10.0, ..biped(Joint::torque(), [0.0, 0.0], 0.5) });
    let held =
        whole.holding_torques(&upright, Some(&[2]), LEAST).unwrap().expect("it stands on one foot");
    assert_eq!((held.forces[0][0], held.freedom), (0.0, 0));
    close(held.forces[0][1], 120.0, 1e-12);
    assert_eq!(held.torques, [0.0, 0.0]);
    for wrong in [&[3][..], &[1, 1], &[0]] {
        let error = whole.holding_torques(&upright, Some(wrong), LEAST).unwrap_err();
        assert!(error.to_string().contains("different feet, from 1 to 2"), "{error}");
    }
}

#[test]
fn wrong_input_names_the_field() {
    let fields = || biped(Joint::torque(), [0.0, 0.0], 0.5);
    let message = |change: &dyn Fn(&mut ChainFields)| {
        let mut wrong = fields();
        change(&mut wrong);
        Chain::new(wrong).unwrap_err().to_string()
    };
    let starts = |text: String, start: &str| assert!(text.starts_with(start), "{text}");
    starts(
        message(&|f| f.joints[0].parent = Some(2)),
        "joints.1.parent = 2 cannot be used: a link before link 2",
    );
    starts(message(&|f| f.joints[1].parent = Some(0)), "joints.2.parent = 0 cannot");
    starts(message(&|f| f.feet[0].link = 4), "feet.1.link = 4 cannot be used: a link, from 1 to 3");
    starts(
        message(&|f| f.feet[1].slope = 30.0),
        "feet.2.slope = 30.0 cannot be used: -pi < slope <= pi, in rad; did you mean math.radians(30)",
    );
    starts(message(&|f| f.joints[0].angle = -90.0), "joints.1.angle = -90.0 cannot");
    starts(message(&|f| f.links[1].mass = -1.0), "links.2.mass = -1.0 is outside");
    starts(message(&|f| f.links[1].length = 0.0), "links.2.length = 0.0 is outside");
    starts(message(&|f| f.links[2].inertia = f64::NAN), "links.3.inertia = NaN is outside");
    starts(message(&|f| f.joints[0].armature = -1.0), "joints.1.armature = -1.0 is outside");
    starts(message(&|f| f.joints.truncate(1)), "joints = [1 joints] cannot be used: 2 joints");
    starts(message(&|f| f.base = Base::Pinned), "joints = [2 joints] cannot be used: 3 joints");
    starts(message(&|f| f.links.clear()), "links = [0 links]");
    starts(
        message(&|f| f.links.iter_mut().for_each(|link| link.mass = 0.0)),
        "links = [no link with mass]",
    );
    starts(message(&|f| f.restitution = 1.5), "restitution = 1.5 is outside");
    starts(message(&|f| f.gravity = -9.81), "gravity = -9.81 is outside");
    let pin = |f: &mut ChainFields, joint: Joint| {
        f.base = Base::Pinned;
        f.joints.insert(0, joint);
    };
    starts(
        message(&|f| pin(f, Joint { parent: Some(1), ..Joint::torque() })),
        "joints.1.parent = 1 cannot be used: left out",
    );
    starts(
        message(&|f| pin(f, Joint { at: Some(0.5), ..Joint::torque() })),
        "joints.1.at = 0.5 cannot be used: left out",
    );

    let biped = chain(fields());
    let at = |q: &[f64]| biped.mechanism(q).unwrap_err().to_string();
    starts(
        at(&[0.0; 3]),
        "q = [3 entries] cannot be used: one entry for each of the 5 coordinates",
    );
    starts(
        at(&[0.0, 0.0, 0.0, 30.0, 0.0]),
        "q.3 = 30.0 cannot be used: an angle in rad, from -2 pi to 2 pi; did you mean math.radians(30)",
    );
    starts(at(&[0.0, f64::NAN, 0.0, 0.0, 0.0]), "q.1 = NaN is outside");
    assert!(biped.mechanism(&[100.0, 0.0, 6.0, -0.5, 0.5]).is_ok());
    let mut light = fields();
    light.links[2] = Link { mass: 0.0, inertia: 0.0, length: 1.0, center: None };
    let indefinite = chain(light.clone()).mechanism(&[0.0; 5]).unwrap_err().to_string();
    starts(indefinite, "mass_matrix = ");
    light.joints[1].armature = 0.1; // a rotor is enough
    assert!(chain(light).mechanism(&[0.0, 0.0, 0.0, -0.5, 0.5]).is_ok());
    let bare = chain(ChainFields { feet: vec![], ..fields() });
    starts(bare.mechanism(&[0.0; 5]).unwrap_err().to_string(), "feet = [0 feet]");
}

#[test]
fn chains_are_written_and_read() {
    let whole = chain(biped(Joint { armature: 0.5, ..Joint::torque() }, [0.3, -0.25], 0.5));
    let text = serde_json::to_string(&whole).unwrap();
    assert!(text.contains(r#""base":"floating""#) && text.contains(r#""kind":"torque""#), "{text}");
    assert_eq!(serde_json::from_str::<Chain>(&text).unwrap(), whole);
    let least = r#"{"base":"pinned","links":[{"mass":1,"inertia":0.1,"length":1}],"joints":[{"kind":"locked"}]}"#;
    let read: Chain = serde_json::from_str(least).unwrap();
    assert_eq!((read.fields().gravity, read.dof()), (9.81, 1));
    let wrong = least.replace("0.1", "-0.1");
    let error = serde_json::from_str::<Chain>(&wrong).unwrap_err().to_string();
    assert!(error.starts_with("links.1.inertia = -0.1"), "{error}");
}

#[test]
fn torques_that_lift_the_feet_are_no_wrong_sign() {
    let mut fields = biped(Joint::torque(), [0.0; 2], 0.5);
    fields.joints[0].torque = -40.0;
    fields.joints[1].torque = 40.0;
    let mechanism = chain(fields).mechanism(&[0.0, 0.0, 0.0, -0.5, 0.5]).unwrap();
    let b = mechanism.contact_space().b();
    assert!(b[1] > 0.0 && b[3] > 0.0, "{b}");
    // The same with gravity upwards and the torques of the other sign: that is one.
    let own = mechanism.fields();
    let load = own.load.iter().map(|part| -part).collect();
    let turned = MechanismFields { load, ..own.clone() };
    assert!(Mechanism::new(turned.clone()).is_ok(), "it presses the feet down");
    let rises = MechanismFields {
        load: own
            .load
            .iter()
            .enumerate()
            .map(|(k, part)| if k < 3 { -part } else { 0.0 })
            .collect(),
        ..turned
    };
    let error = Mechanism::new(rises).unwrap_err().to_string();
    assert!(error.contains("did you mean -load"), "{error}");
}
