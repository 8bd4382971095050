//! Contact modes of mechanisms: those of rigid bodies; those of a search through all words that knows only W and b; programmes for many
//! contacts; wrong input.

#[path = "../src/math/random.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests use a part of it")]
mod random;

use nalgebra::{DMatrix, DVector};
use random::Random;
use standfast::body::{ContactRows, Mechanism, MechanismFields};
use standfast::modes::{
    ContactProblem, Forces, MechanismProblem, Method, Mode, ModeAnswer, Status, Word, contact_modes,
};
use standfast::{Contact, Error, Posture, PostureFields, State};

fn below(random: &mut Random, count: usize) -> usize {
    (random.bits() % count as u64) as usize
}

fn close(value: f64, expected: f64, size: f64, case: usize) {
    let same = value == expected || (value - expected).abs() <= 1e-12 * (1.0 + size);
    assert!(same, "{case}: {value:?} {expected:?}");
}

#[test]
fn a_rigid_body_as_a_mechanism_has_the_same_modes() {
    let mut random = Random(1);
    let (mut families, mut decided) = (0, 0);
    for case in 0..2000 {
        let n = 1 + below(&mut random, 4);
        let contacts = (0..n).map(|i| {
            let x = -1.0 + 2.0 * (i as f64 + random.between(0.1, 0.9)) / n as f64;
            let point = Contact::at(x, random.between(-0.3, 0.3));
            let friction = random.between(0.0, 1.5);
            Contact { friction, ..point.on_slope(random.between(-1.0, 1.0)) }
        });
        let contacts = contacts.collect();
        let posture = Posture::new(PostureFields {
            mass: random.between(0.5, 3.0),
            gyration_radius: random.between(0.2, 1.0),
            center_of_mass: [random.between(-1.2, 1.2), random.between(0.4, 1.5)],
            contacts,
            ..PostureFields::default()
        })
        .unwrap();
        let body =
            ContactProblem::of_posture(&posture, &State::at_rest([0.0; 3]), [0.0; 3]).unwrap();
        let mechanism = MechanismProblem::at_rest(&Mechanism::of_posture(&posture).unwrap());
        for method in [Method::Auto, Method::Enumerate] {
            let [one, two] =
                [contact_modes(&body, method).unwrap(), contact_modes(&mechanism, method).unwrap()];
            assert_eq!(one.status(), two.status(), "{case}");
            decided += usize::from(one.status() == Status::Unique);
            let words = |answers: &[ModeAnswer]| answers.iter().map(|a| a.word).collect::<Vec<_>>();
            assert_eq!(words(one.answers()), words(two.answers()), "{case}");
            for (one, two) in one.answers().iter().zip(two.answers()) {
                assert_eq!((one.consistent, one.determined), (two.consistent, two.determined));
                // Nearly singular friction matrices give large forces, with errors that grow with their square.
                let size = one.forces.iter().flatten().fold(0.0_f64, |most, f| most.max(f.abs()));
                let size = size * (1.0 + size);
                if one.determined == Forces::Impossible {
                    assert!(two.acceleration.iter().all(|a| a.is_nan()) && two.margins.is_empty());
                    continue;
                }
                let pairs = |a: &ModeAnswer| a.forces.iter().flatten().copied().collect::<Vec<_>>();
                if one.determined == Forces::Unique || one.consistent && n > 1 {
                    for (f, g) in pairs(one).iter().zip(pairs(two)) {
                        close(*f, g, size, case);
                    }
                    for (a, b) in one.acceleration.iter().zip(&two.acceleration) {
                        close(*a, *b, size, case);
                    }
                }
                // Of other families any forces with large margins are shown.
                let finite = |interval: [f64; 2]| interval.iter().all(|end| end.is_finite());
                let same_margins =
                    one.determined == Forces::Unique || one.force_interval.is_some_and(finite);
                assert_eq!(one.margins.len(), two.margins.len(), "{case}");
                for (a, b) in one.margins.iter().zip(&two.margins) {
                    assert_eq!((a.contact, a.condition), (b.contact, b.condition));
                    if same_margins {
                        close(a.value, b.value, size, case);
                    }
                }
                assert_eq!(one.force_interval.is_some(), two.force_interval.is_some());
                if let (Some([a, b]), Some([c, d])) = (one.force_interval, two.force_interval) {
                    // e points either way.
                    let same = a == c || (a - c).abs() <= 1e-9 * (1.0 + size);
                    let [low, high] = if same { [c, d] } else { [-d, -c] };
                    close(a, low, size, case);
                    close(b, high, size, case);
                    families += 1;
                }
            }
        }
    }
    assert!(families > 500 && decided > 3000, "{families} families, {decided} decided");
}

/// A mechanism with so many coordinates and random rows, pulled towards its contacts.
fn random_mechanism(random: &mut Random, dof: usize, n: usize) -> Mechanism {
    loop {
        let g = DMatrix::from_fn(dof, dof, |_, _| random.between(-1.0, 1.0));
        let mass = &g * g.transpose() + DMatrix::identity(dof, dof) * 0.5;
        let mut row = || (0..dof).map(|_| random.between(-1.0, 1.0)).collect::<Vec<f64>>();
        let rows: Vec<[Vec<f64>; 2]> = (0..n).map(|_| [row(), row()]).collect();
        let mut load: Vec<f64> = row();
        for [normal, tangential] in &rows {
            let (down, along) = (random.between(0.0, 3.0), random.between(-0.7, 0.7));
            for k in 0..dof {
                load[k] -= down * (normal[k] + along * tangential[k]);
            }
        }
        let contacts = rows.into_iter().map(|[normal, tangential]| {
            let friction = random.between(0.05, 1.5);
            ContactRows { normal, tangential, friction, ..ContactRows::default() }
        });
        let contacts = contacts.collect();
        let mass_matrix = (0..dof).map(|i| (0..dof).map(|j| mass[(i, j)]).collect()).collect();
        let fields = MechanismFields { mass_matrix, load, contacts, ..MechanismFields::default() };
        if let Ok(mechanism) = Mechanism::new(fields) {
            return mechanism;
        }
    }
}

fn random_signs(random: &mut Random, n: usize) -> Vec<Option<i8>> {
    (0..n).map(|_| [Some(0), Some(0), Some(0), Some(1), Some(-1), None][below(random, 6)]).collect()
}

/// All words of so many letters.
fn all_words(n: usize) -> impl Iterator<Item = Word> {
    (0..1_usize << (2 * n)).map(move |k| {
        let text: String = (0..n).map(|i| Mode::ALL[(k >> (2 * i)) & 3].letter()).collect();
        text.parse().unwrap()
    })
}

/// W, b and friction, with normal rows of length one and the largest b equal to one.
struct Scaled {
    w: DMatrix<f64>,
    b: DVector<f64>,
    friction: Vec<f64>,
}

impl Scaled {
    fn of(mechanism: &Mechanism) -> Self {
        let space = mechanism.contact_space();
        let unit = |k: usize| 1.0 / space.w()[(k | 1, k | 1)].sqrt();
        let count = space.b().len();
        let b = DVector::from_fn(count, |k, _| space.b()[k] * unit(k));
        Self {
            w: DMatrix::from_fn(count, count, |i, j| space.w()[(i, j)] * unit(i) * unit(j)),
            b: &b / b.amax(),
            friction: mechanism.contacts().iter().map(|k| k.friction).collect(),
        }
    }

    /// Whether forces satisfy the equations and tests of the word. The weights of the edges of the cones are at least `least`, and the
    /// accelerations of the strict tests at least `open`.
    fn allows(&self, word: Word, sliding: &[Option<i8>], [least, open]: [f64; 2]) -> bool {
        // Unknowns: weights − least ≥ 0; accelerations − open ≥ 0.
        let mut edges: Vec<DVector<f64>> = Vec::new();
        let (mut equations, mut tests) = (Vec::new(), Vec::new());
        for (i, mode) in word.modes().enumerate() {
            let (t, n, mu) = (2 * i, 2 * i + 1, self.friction[i]);
            let mut edge = |side: f64| {
                let mut force = DVector::zeros(self.b.len());
                (force[t], force[n]) = (side * mu, 1.0);
                edges.push(force);
            };
            match (mode, sliding[i]) {
                (Mode::Separate, None) => {}
                (Mode::Separate, _) => tests.push((n, 1.0)),
                (Mode::Fixed, Some(0)) => {
                    edge(-1.0);
                    edge(1.0);
                    equations.extend([n, t]);
                }
                (Mode::Right, Some(0 | 1)) => {
                    edge(-1.0);
                    equations.push(n);
                }
                (Mode::Left, Some(0 | -1)) => {
                    edge(1.0);
                    equations.push(n);
                }
                _ => return false,
            }
            match (mode, sliding[i]) {
                (Mode::Right, Some(0)) => tests.push((t, 1.0)),
                (Mode::Left, Some(0)) => tests.push((t, -1.0)),
                _ => {}
            }
        }
        let columns = edges.len() + tests.len();
        let all = equations.iter().map(|&k| (k, 1.0, None));
        let all = all.chain(tests.iter().enumerate().map(|(k, &(row, sign))| (row, sign, Some(k))));
        let mut system: Vec<Vec<f64>> = Vec::new();
        for (k, sign, test) in all {
            let mut row: Vec<f64> =
                edges.iter().map(|edge| sign * self.w.row(k).transpose().dot(edge)).collect();
            let known = sign * self.b[k] + row.iter().sum::<f64>() * least;
            row.resize(columns, 0.0);
            if let Some(test) = test {
                row[edges.len() + test] = -1.0;
            }
            row.push(if test.is_some() { open - known } else { -known });
            system.push(row);
        }
        has_solution(system, columns)
    }
}

/// Whether rows [A | c] have a solution x ≥ 0 with A x = c: one with as many unknowns other than zero as A has independent rows.
fn has_solution(mut system: Vec<Vec<f64>>, columns: usize) -> bool {
    let mut rank = 0;
    let mut used = vec![false; columns];
    while rank < system.len() {
        let places = (rank..system.len()).flat_map(|i| (0..columns).map(move |j| (i, j)));
        let free = places.filter(|&(_, j)| !used[j]);
        let Some((i, j)) =
            free.max_by(|&(i, j), &(k, l)| system[i][j].abs().total_cmp(&system[k][l].abs()))
        else {
            break;
        };
        if system[i][j].abs() < 1e-9 {
            break;
        }
        system.swap(rank, i);
        used[j] = true;
        let pivot = system[rank].clone();
        for row in &mut system[rank + 1..] {
            let factor = row[j] / pivot[j];
            row.iter_mut().zip(&pivot).for_each(|(value, p)| *value -= factor * p);
        }
        rank += 1;
    }
    if system[rank..].iter().any(|row| row[columns].abs() > 1e-9) {
        return false;
    }
    if rank == 0 {
        return true;
    }
    system.truncate(rank);
    let c = DVector::from_fn(rank, |i, _| system[i][columns]);
    (0_u32..1 << columns).filter(|chosen| chosen.count_ones() as usize == rank).any(|chosen| {
        let places: Vec<usize> = (0..columns).filter(|j| chosen >> j & 1 == 1).collect();
        let a = DMatrix::from_fn(rank, rank, |i, j| system[i][places[j]]);
        let lu = a.lu();
        lu.solve(&c).is_some_and(|x| x.iter().all(|x| *x >= 0.0 && *x < 1e6))
    })
}

/// Compares the consistent words with those of the search through all words. Returns their number; `None` for a tie.
fn compared(mechanism: &Mechanism, sliding: &[Option<i8>], case: usize) -> Option<usize> {
    // A strict test may be zero for all forces of a word: then the word is wrong, and no tie.
    const CLEARLY: [f64; 2] = [1e-8, 1e-8];
    const NEARLY: [f64; 2] = [-1e-8, 1e-8];
    let scaled = Scaled::of(mechanism);
    let mut expected = Vec::new();
    for word in all_words(sliding.len()) {
        let [strict, loose] = [CLEARLY, NEARLY].map(|tie| scaled.allows(word, sliding, tie));
        if strict != loose {
            return None;
        }
        if strict {
            expected.push(word);
        }
    }
    expected.sort();
    let problem = MechanismProblem::new(mechanism, sliding).unwrap();
    for method in [Method::Enumerate, Method::Auto] {
        let modes = contact_modes(&problem, method).unwrap();
        let found: Vec<Word> = modes.consistent().map(|answer| answer.word).collect();
        let text = |words: &[Word]| words.iter().map(Word::to_string).collect::<Vec<_>>().join(" ");
        assert_eq!(
            text(&found),
            text(&expected),
            "case {case}: {sliding:?}, {:?}",
            mechanism.dof()
        );
    }
    for answer in contact_modes(&problem, Method::Enumerate).unwrap().consistent() {
        assert!(residual(&problem, answer) < 1e-9, "case {case}: {answer:?}");
    }
    Some(expected.len())
}

/// The largest violation of M q̈ = load + Σ rowᵀ f and of the equations and tests of a word, relative to load and forces.
fn residual(problem: &MechanismProblem, answer: &ModeAnswer) -> f64 {
    let fields = problem.mechanism().fields();
    let dof = fields.load.len();
    let size =
        answer.forces.iter().flatten().chain(&fields.load).fold(0.0_f64, |m, f| m.max(f.abs()));
    let mut worst = 0.0_f64;
    for k in 0..dof {
        let inertia: f64 =
            (0..dof).map(|j| fields.mass_matrix[k][j] * answer.acceleration[j]).sum();
        let push: f64 = answer
            .forces
            .iter()
            .zip(&fields.contacts)
            .map(|([t, n], contact)| contact.tangential[k] * t + contact.normal[k] * n)
            .sum();
        worst = worst.max((inertia - fields.load[k] - push).abs());
    }
    for (i, contact) in fields.contacts.iter().enumerate() {
        let ([t, n], mu) = (answer.forces[i], contact.friction);
        let along =
            |row: &[f64]| row.iter().zip(&answer.acceleration).map(|(r, a)| r * a).sum::<f64>();
        let (a_t, a_n) = (along(&contact.tangential), along(&contact.normal));
        let violations = match (answer.word.mode(i), problem.sliding()[i]) {
            (Mode::Separate, None) => vec![t.abs(), n.abs()],
            (Mode::Separate, _) => vec![t.abs(), n.abs(), -a_n],
            (Mode::Fixed, _) => vec![a_n.abs(), a_t.abs(), -n, t.abs() - mu * n],
            (mode, sliding) => {
                let sign = if mode == Mode::Right { 1.0 } else { -1.0 };
                let starts = if sliding == Some(0) { -sign * a_t } else { 0.0 };
                vec![a_n.abs(), (t + sign * mu * n).abs(), -n, starts]
            }
        };
        worst = violations.into_iter().fold(worst, f64::max);
    }
    worst / size
}

#[test]
fn two_contacts_against_all_words() {
    let mut random = Random(2);
    let mut counts = [0; 4];
    let mut ties = 0;
    for case in 0..2000 {
        let mechanism = random_mechanism(&mut random, 2 + random_rank(case), 2);
        let sliding = random_signs(&mut random, 2);
        match compared(&mechanism, &sliding, case) {
            Some(count) => counts[count.min(3)] += 1,
            None => ties += 1,
        }
    }
    assert!(ties < 20 && counts.iter().all(|count| *count > 0), "{ties} ties, {counts:?}");
}

/// Coordinates beyond two, by turns.
fn random_rank(case: usize) -> usize {
    [0, 1, 1, 2, 2, 4][case % 6]
}

#[test]
fn one_three_and_four_contacts_against_all_words() {
    let mut random = Random(3);
    let mut ties = 0;
    let mut ranks = [0; 9];
    for case in 0..900 {
        let n = [1, 3, 3, 4][case % 4];
        let dof = if n == 1 { 2 + below(&mut random, 3) } else { 3 + below(&mut random, 7) };
        let mechanism = random_mechanism(&mut random, dof, n);
        ranks[mechanism.contact_space().rank()] += 1;
        let sliding = random_signs(&mut random, n);
        ties += usize::from(compared(&mechanism, &sliding, case).is_none());
    }
    assert!(ties < 30 && ranks[2..].iter().all(|count| *count > 20), "{ties} ties, {ranks:?}");
}

#[test]
fn with_four_independent_rows_all_words_are_motions() {
    let mut random = Random(4);
    for case in 0..200 {
        let dof = 4 + below(&mut random, 3);
        let mechanism = random_mechanism(&mut random, dof, 2);
        assert_eq!(mechanism.contact_space().rank(), 4);
        let modes = contact_modes(&MechanismProblem::at_rest(&mechanism), Method::Auto).unwrap();
        assert_eq!(modes.answers().len(), 16, "{case}");
        let fixed = modes.get("FF".parse().unwrap()).unwrap();
        assert_eq!((fixed.determined, fixed.force_interval), (Forces::Unique, None));
        assert_eq!(fixed.acceleration.len(), dof);
    }
}

#[cfg(feature = "qp")]
#[test]
fn programmes_find_modes_of_many_contacts() {
    let mut random = Random(5);
    let mut found = 0;
    for case in 0..60 {
        let n = 8 + below(&mut random, 9);
        let dof = 6 + below(&mut random, 15);
        let mechanism = random_mechanism(&mut random, dof, n);
        let problem = MechanismProblem::at_rest(&mechanism);
        let modes = contact_modes(&problem, Method::Qp).unwrap();
        for answer in modes.consistent() {
            found += 1;
            assert!(residual(&problem, answer) < 1e-8, "{case}: {}", residual(&problem, answer));
        }
    }
    assert!(found >= 50, "{found} of 60");
}

#[test]
fn one_more_contact_does_not_change_two_fixed_ones() {
    // Two contacts whose four rows span three dimensions, and a third that moves on its own: their forces are a family with the same interval.
    let mut random = Random(6);
    let mut families = 0;
    for case in 0..300 {
        let body = random_mechanism(&mut random, 3, 2);
        let mut fields = body.fields().clone();
        let alone =
            |axis: usize| (0..5).map(|k| f64::from(u8::from(k == axis))).collect::<Vec<_>>();
        for (k, row) in fields.mass_matrix.iter_mut().enumerate() {
            assert!(k < 3 && row.len() == 3);
            row.extend([0.0; 2]);
        }
        fields.mass_matrix.extend([alone(3), alone(4)]);
        fields.load.extend([0.0, 1.0]);
        for contact in &mut fields.contacts {
            contact.normal.extend([0.0; 2]);
            contact.tangential.extend([0.0; 2]);
        }
        fields.contacts.push(ContactRows {
            normal: alone(4),
            tangential: alone(3),
            ..ContactRows::default()
        });
        let Ok(both) = Mechanism::new(fields) else { continue };
        let modes = |mechanism: &Mechanism| {
            contact_modes(&MechanismProblem::at_rest(mechanism), Method::Enumerate).unwrap()
        };
        let (one, two) = (modes(&body), modes(&both));
        let fixed = one.get("FF".parse().unwrap()).unwrap();
        let beside = two.get("FFS".parse().unwrap()).unwrap();
        assert_eq!((fixed.consistent, fixed.determined), (beside.consistent, beside.determined));
        let ([a, b], [c, d]) = (fixed.force_interval.unwrap(), beside.force_interval.unwrap());
        let size = fixed.forces.iter().flatten().fold(1.0_f64, |most, f| most.max(f.abs()));
        close(a, c, size, case);
        close(b, d, size, case);
        families += 1;
        for (f, g) in fixed.forces.iter().flatten().zip(beside.forces.iter().flatten()) {
            close(*f, *g, size, case);
        }
    }
    assert!(families > 100, "{families} families");
}

#[test]
fn too_many_words_are_refused() {
    let identity = |k: usize| (0..20).map(|j| f64::from(u8::from(j == k))).collect::<Vec<_>>();
    let mechanism = Mechanism::new(MechanismFields {
        mass_matrix: (0..20).map(identity).collect(),
        load: (0..20).map(|k| if k % 2 == 0 { 0.1 } else { -1.0 }).collect(),
        contacts: (0..10)
            .map(|k| ContactRows {
                tangential: identity(2 * k),
                normal: identity(2 * k + 1),
                friction: 0.5,
                ..ContactRows::default()
            })
            .collect(),
        ..MechanismFields::default()
    })
    .unwrap();
    let problem = MechanismProblem::at_rest(&mechanism);
    let error = contact_modes(&problem, Method::Enumerate).unwrap_err().to_string();
    assert!(error.contains("method") && error.contains("65536"), "{error}");
    #[cfg(feature = "qp")]
    {
        let modes = contact_modes(&problem, Method::Auto).unwrap();
        assert_eq!(modes.status(), Status::Found);
        assert_eq!(modes.consistent().next().unwrap().word.to_string(), "F".repeat(10));
    }
}

#[test]
fn wrong_signs() {
    let mechanism = random_mechanism(&mut Random(7), 4, 2);
    for (sliding, says) in [
        (&[Some(0)][..], "sliding = [1 entries]"),
        (&[Some(0), Some(2)], "sliding.2 = 2"),
        (&[Some(-3), None], "sliding.1 = -3"),
    ] {
        let error = MechanismProblem::new(&mechanism, sliding).unwrap_err();
        assert!(matches!(error, Error::Unusable { .. }));
        let text = error.to_string();
        assert!(text.starts_with(says), "{text}");
    }
}

#[test]
fn feet_press_against_slopes_without_bound() {
    // On level ground friction bounds the force between two feet by μ times the weight on one of them. Between steep slopes that rise
    // outwards nothing bounds it.
    let rod = |slope: f64, friction: f64| {
        let foot = |x: f64, slope: f64| Contact { friction, ..Contact::at(x, 0.0).on_slope(slope) };
        let posture = Posture::new(PostureFields {
            mass: 2.0,
            gyration_radius: 0.3,
            center_of_mass: [0.0, 0.4],
            contacts: vec![foot(-0.5, -slope), foot(0.5, slope)],
            gravity: 10.0,
            ..PostureFields::default()
        });
        let mechanism = Mechanism::of_posture(&posture.unwrap()).unwrap();
        let modes = contact_modes(&MechanismProblem::at_rest(&mechanism), Method::Auto).unwrap();
        modes.get("FF".parse().unwrap()).unwrap().force_interval.unwrap()
    };
    let [low, high] = rod(0.0, 0.5);
    assert!((low + 5.0).abs() < 1e-13 && (high - 5.0).abs() < 1e-13, "{low} {high}");
    // Positive for a push of foot 1 along its tangent: inwards.
    let [low, high] = rod(1.2, 0.5);
    assert!(low.is_finite() && high == f64::INFINITY, "{low} {high}");
}
