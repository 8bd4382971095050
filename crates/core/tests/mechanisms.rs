//! Mechanisms: the contact dynamics of a biped against values computed with other programs, and wrong input.

use standfast::body::{ContactRows, Mechanism, MechanismFields};

/// A trunk of 10 kg with I = 0.4 about its centre, the hip; two legs of length 1, 1 kg, I = 1/12, with their centres in the middle.
/// q = (x, y, θ, a, b): the legs hang down at the angles θ + a and θ + b. g = 9.81.
fn biped(theta: f64, legs: [f64; 2], slopes: [f64; 2], friction: f64) -> MechanismFields {
    let (trunk, inertia, leg, own, middle, g) = (10.0, 0.4, 1.0, 1.0 / 12.0, 0.5, 9.81);
    let mut m = vec![vec![0.0; 5]; 5];
    let mut load = vec![0.0; 5];
    m[0][0] = trunk;
    m[1][1] = trunk;
    m[2][2] = inertia;
    load[1] = -trunk * g;
    let mut contacts = Vec::new();
    for (k, angle) in legs.into_iter().enumerate() {
        let (sin, cos) = (theta + angle).sin_cos();
        // Columns x, y, θ and the leg's own angle of a point at this distance along the leg.
        let columns = |d: f64| {
            let mut x = vec![0.0; 5];
            let mut y = vec![0.0; 5];
            (x[0], y[1]) = (1.0, 1.0);
            for at in [2, 3 + k] {
                (x[at], y[at]) = (d * cos, d * sin);
            }
            [x, y]
        };
        let [x, y] = columns(middle);
        for i in 0..5 {
            for j in 0..5 {
                let turn = |at: usize| f64::from(u8::from(at == 2 || at == 3 + k));
                m[i][j] += leg * (x[i] * x[j] + y[i] * y[j]) + own * turn(i) * turn(j);
            }
            load[i] -= leg * g * y[i];
        }
        let ([x, y], (s, c)) = (columns(1.0), slopes[k].sin_cos());
        let along = |a: f64, b: f64| (0..5).map(|i| a * x[i] + b * y[i]).collect();
        contacts.push(ContactRows {
            normal: along(-s, c),
            tangential: along(c, s),
            friction,
            ..ContactRows::default()
        });
    }
    MechanismFields { mass_matrix: m, load, contacts, ..MechanismFields::default() }
}

/// Index of N_1, N_2, T_1, T_2 in an order contact by contact (tangential, normal).
const ORDER: [usize; 4] = [1, 3, 0, 2];

fn close(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-9, "{value} {expected}");
}

#[test]
fn contact_space_of_a_biped() {
    let fields = biped(0.1, [-0.5, 0.6], [0.3, -0.25], 0.5);
    let at = |mechanism: &Mechanism, i: usize, j: usize| {
        mechanism.contact_space().w()[(ORDER[i - 1], ORDER[j - 1])]
    };
    let b = |mechanism: &Mechanism| ORDER.map(|k| mechanism.contact_space().b()[k]);

    let locked = Mechanism::new(MechanismFields { locked: vec![3, 4], ..fields.clone() }).unwrap();
    assert_eq!(locked.contact_space().rank(), 3);
    for (i, j, value) in [
        (1, 1, 0.482349558),
        (1, 2, -0.423789611),
        (1, 3, -0.437428509),
        (2, 2, 0.696992631),
        (3, 3, 0.562871981),
    ] {
        close(at(&locked, i, j), value);
    }
    for (value, expected) in
        b(&locked).iter().zip([-9.371850958, -9.505030857, -2.899053227, 2.42703284])
    {
        close(*value, expected);
    }
    let [one, two] = locked.local().unwrap().psi();
    close(one, 0.8785943811);
    close(two, 0.6080259568);

    let mut held = fields.clone();
    held.load[3] += 16.148336405;
    held.load[4] -= 16.148336405;
    let torque = Mechanism::new(held).unwrap();
    assert_eq!(torque.contact_space().rank(), 4);
    for (i, j, value) in [(1, 1, 1.306920593), (1, 2, -0.02840302), (3, 3, 1.803376937)] {
        close(at(&torque, i, j), value);
    }
    let signs = [-39.524256935, -48.291975487, 35.790319262, -27.599756133];
    for (value, expected) in b(&torque).iter().zip(signs) {
        assert!((value - expected).abs() < 2e-8, "{value} {expected}"); // the torque has nine decimals
    }
    let [one, two] = torque.local().unwrap().psi();
    close(one, 0.0217327815);
    close(two, 0.0139869638);

    let armature = vec![0.0, 0.0, 0.0, 1.0, 1.0];
    let geared = Mechanism::new(MechanismFields { armature, ..fields }).unwrap();
    let [one, two] = geared.local().unwrap().psi();
    close(one, 0.4372888897);
    close(two, 0.2928251793);
}

/// Rows of a point that one joint moves: multiples of each other but for rounding errors.
#[test]
fn a_point_that_moves_along_a_line_is_no_contact() {
    for k in 0..200 {
        let (sin, cos) = (0.1 + 0.007 * f64::from(k)).sin_cos();
        let contact =
            ContactRows { normal: vec![cos], tangential: vec![sin], ..ContactRows::default() };
        let error = Mechanism::new(MechanismFields {
            mass_matrix: vec![vec![0.7]],
            load: vec![-1.0],
            contacts: vec![contact],
            ..MechanismFields::default()
        });
        let error = error.unwrap_err().to_string();
        assert!(
            error.starts_with("contacts.1.tangential = [a multiple of the normal row"),
            "{error}"
        );
    }
    // Two joints with a small angle between the rows are enough.
    let rows = |angle: f64| ContactRows {
        normal: vec![1.0, 0.0],
        tangential: vec![1.0, angle],
        ..ContactRows::default()
    };
    let of = |angle: f64| {
        Mechanism::new(MechanismFields {
            mass_matrix: vec![vec![1.0, 0.0], vec![0.0, 1.0]],
            load: vec![-1.0, 0.0],
            contacts: vec![rows(angle)],
            ..MechanismFields::default()
        })
    };
    assert!(of(1e-9).is_ok() && of(1e-11).is_err());
}
