//! Contact modes by convex programs: how often the fixed-point iteration of De Saxcé finds one, and how accurately; and
//! why Coulomb's law cannot be solved as a single program.
#![cfg(feature = "qp")]

use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Mutex;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};
use random::Random;
use standfast::modes::{
    ContactProblem, Level, Method, Mode, ModeAnswer, ProblemFields, Status, Word, contact_modes,
};

#[path = "../src/math/random.rs"]
mod random;

/// Number of problems of each class in an ordinary run, and in the run that gives the numbers of the documentation.
const FEW: usize = 1000;
const MANY: usize = 10_000;
/// Largest residual of a word solved exactly, see [`residual`]: rounding error times the condition of its system.
const POLISHED: f64 = 1e-12;

/// Locked while a table is printed.
static TABLE: Mutex<()> = Mutex::new(());

impl Random {
    fn real(&mut self, range: Range<f64>) -> f64 {
        self.between(range.start, range.end)
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.bits() as usize % from.len()]
    }

    fn chance(&mut self, p: f64) -> bool {
        self.real(0.0..1.0) < p
    }

    /// A body at rest on `n` contacts below its centre of mass, under gravity and in half of the cases a more general load.
    fn body(&mut self, n: usize, friction: Range<f64>) -> ProblemFields {
        let angles: Vec<f64> =
            (0..n).map(|_| if self.chance(0.25) { 0.0 } else { self.real(-1.2..1.2) }).collect();
        ProblemFields {
            mass: self.real(0.1..10.0),
            gyration_radius: self.real(0.1..2.0),
            arms: (0..n).map(|_| [self.real(-2.0..2.0), self.real(-2.0..-0.2)]).collect(),
            tangents: angles.iter().map(|angle| [angle.cos(), angle.sin()]).collect(),
            friction: (0..n).map(|_| self.real(friction.clone())).collect(),
            sliding: vec![Some(0); n],
            bias: vec![[0.0; 2]; n],
            free_acceleration: if self.chance(0.5) {
                [0.0, -1.0, 0.0]
            } else {
                [self.real(-1.0..1.0), self.real(-2.0..0.5), self.real(-2.0..2.0)]
            },
            level: Level::Acceleration,
        }
    }

    /// The same body, rotating at a rate up to 1.5: bias −(b, c) θ̇² of its contacts.
    fn spun(&mut self, mut fields: ProblemFields) -> ProblemFields {
        let spin2 = self.real(0.0..1.5).powi(2);
        for i in 0..fields.arms.len() {
            let (d, [x, y]) = (fields.arms[i], fields.tangents[i]);
            fields.bias[i] = [-(x * d[0] + y * d[1]) * spin2, -(x * d[1] - y * d[0]) * spin2];
        }
        fields
    }
}

const LOW: Range<f64> = 0.0..0.3;
const HIGH: Range<f64> = 0.5..3.0;

/// Numbers of contacts.
const TWO: [usize; 1] = [2];
const MORE: [usize; 8] = [3, 4, 5, 6, 7, 8, 9, 10];

fn two_at_rest_low(draw: &mut Random) -> ProblemFields {
    draw.body(2, LOW)
}

fn two_at_rest_high(draw: &mut Random) -> ProblemFields {
    draw.body(2, HIGH)
}

fn many_at_rest_low(draw: &mut Random) -> ProblemFields {
    let n = draw.pick(&MORE);
    draw.body(n, LOW)
}

fn many_at_rest_high(draw: &mut Random) -> ProblemFields {
    let n = draw.pick(&MORE);
    draw.body(n, HIGH)
}

/// Sliding, resting and separated contacts in any mixture, on walls and ceilings too.
fn mixed_sliding(draw: &mut Random) -> ProblemFields {
    let n = draw.pick(&[1, 2, 3, 4, 5, 6]);
    let mut fields = draw.body(n, 0.0..2.0);
    for i in 0..n {
        fields.sliding[i] = draw.pick(&[Some(0), Some(0), Some(1), Some(-1), None]);
        if draw.chance(0.2) {
            let (sin, cos) = draw.real(-PI..PI).sin_cos();
            fields.tangents[i] = [cos, sin];
        }
    }
    draw.spun(fields)
}

/// Small ρ, long arms, high friction, and contacts that slide towards the side on which they are: near Painlevé's paradox.
fn slender_sliding(draw: &mut Random) -> ProblemFields {
    let n = draw.pick(&[1, 2, 3]);
    let mut fields = draw.body(n, 1.0..3.0);
    fields.gyration_radius = draw.real(0.2..0.8);
    fields.free_acceleration = [0.0, -1.0, 0.0];
    for i in 0..n {
        fields.arms[i] = [draw.real(-2.0..2.0), draw.real(-3.0..-1.0)];
        fields.sliding[i] = Some(if fields.arms[i][0] > 0.0 { 1 } else { -1 });
        if draw.chance(0.2) {
            fields.sliding[i] = draw.pick(&[Some(0), Some(1), Some(-1)]);
        }
    }
    if draw.chance(0.7) { draw.spun(fields) } else { fields }
}

/// Two to six contacts on one flat floor: at rest, all sliding one way, or in any mixture.
fn flat_floor(draw: &mut Random) -> ProblemFields {
    let n = draw.pick(&[2, 3, 4, 5, 6]);
    let mut fields = draw.body(n, 0.0..2.0);
    let (height, tangent) = (draw.real(-2.0..-0.2), fields.tangents[0]);
    let (one, way) = (fields.friction[0], draw.pick(&[-1, 0, 0, 1, 2]));
    let same = draw.chance(0.7);
    for i in 0..n {
        let along = draw.real(-2.0..2.0);
        fields.tangents[i] = tangent;
        fields.arms[i] =
            [along * tangent[0] - height * tangent[1], along * tangent[1] + height * tangent[0]];
        if same {
            fields.friction[i] = one;
        }
        fields.sliding[i] =
            if way == 2 { draw.pick(&[Some(0), Some(1), Some(-1), None]) } else { Some(way) };
    }
    fields
}

/// One to four contacts at rest whose required forces are within 1e-12 to 1e-5 of the edges or apices of their friction
/// cones.
fn near_degenerate(draw: &mut Random) -> ProblemFields {
    let n = draw.pick(&[1, 2, 3, 4]);
    let mut fields = draw.body(n, 0.0..2.0);
    let one_way = draw.chance(0.5).then(|| draw.pick(&[-1.0, 1.0]));
    let (m, rho) = (fields.mass, fields.gyration_radius);
    fields.free_acceleration = [0.0; 3];
    for i in 0..n {
        let mut off = || draw.pick(&[-1.0, 1.0]) * 10f64.powf(draw.real(-12.0..-5.0));
        let (a, b) = (off(), off());
        let normal = if draw.chance(0.3) { a } else { draw.real(0.1..1.0) + a };
        let side = one_way.unwrap_or_else(|| draw.pick(&[-1.0, 1.0]));
        let push = [side * fields.friction[i] * normal + b, normal];
        let rows = rows(&fields, i);
        for k in 0..3 {
            let inertia = if k < 2 { m } else { m * rho * rho };
            fields.free_acceleration[k] -=
                (rows[0][k] * push[0] + rows[1][k] * push[1]) * m / inertia;
        }
    }
    fields
}

/// An impact on one to three contacts, by Newton's law with a restitution between half of `e` and `e`.
fn impact(draw: &mut Random, e: f64) -> ProblemFields {
    let n = draw.pick(&[1, 2, 3]);
    loop {
        let mut fields = draw.body(n, 0.0..2.0);
        fields.level = Level::Impulse;
        fields.free_acceleration =
            [draw.real(-2.0..2.0), draw.real(-2.0..1.0), draw.real(-2.0..2.0)];
        let e = draw.real(0.5 * e..e);
        let rates: Vec<f64> =
            (0..n).map(|i| dot(&rows(&fields, i)[1], &fields.free_acceleration)).collect();
        for i in 0..n {
            fields.bias[i][1] = e * rates[i];
            fields.sliding[i] = (rates[i] <= 0.0).then_some(0);
        }
        if rates.iter().any(|rate| *rate < 0.0) {
            return fields;
        }
    }
}

fn inelastic_impact(draw: &mut Random) -> ProblemFields {
    impact(draw, 0.0)
}

fn newton_impact(draw: &mut Random) -> ProblemFields {
    impact(draw, 0.9)
}

/// A class of problems, and the least part of the solvable ones in which a mode must be found.
struct Class {
    name: &'static str,
    make: fn(&mut Random) -> ProblemFields,
    least: f64,
}

const CLASSES: [Class; 10] = [
    Class { name: "two at rest, low friction", make: two_at_rest_low, least: 0.999 },
    Class { name: "two at rest, high friction", make: two_at_rest_high, least: 0.999 },
    Class { name: "three to ten at rest, low", make: many_at_rest_low, least: 0.99 },
    Class { name: "three to ten at rest, high", make: many_at_rest_high, least: 0.99 },
    Class { name: "mixed sliding", make: mixed_sliding, least: 0.99 },
    Class { name: "slender, sliding", make: slender_sliding, least: 0.99 },
    Class { name: "flat floor", make: flat_floor, least: 0.99 },
    Class { name: "near a cone's edge", make: near_degenerate, least: 0.99 },
    Class { name: "impact, inelastic", make: inelastic_impact, least: 0.99 },
    Class { name: "impact, Newton", make: newton_impact, least: 0.99 },
];

/// T_i and N_i in coordinates (x, y, ρθ).
fn metric_rows(fields: &ProblemFields, i: usize) -> [[f64; 3]; 2] {
    rows(fields, i).map(|[x, y, turn]| [x, y, turn / fields.gyration_radius])
}

/// T_i and N_i.
fn rows(fields: &ProblemFields, i: usize) -> [[f64; 3]; 2] {
    let ([x, y], [t_x, t_y]) = (fields.arms[i], fields.tangents[i]);
    [[t_x, t_y, x * t_y - y * t_x], [-t_y, t_x, x * t_x + y * t_y]]
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The largest violation of Newton's law q̈ = a₀ + M⁻¹Jᵀf and of the equations of the word, in coordinates (x, y, ρθ)
/// with normal rows of length one, relative to the largest of the load, the biases and the accelerations that single
/// forces give.
fn residual(fields: &ProblemFields, answer: &ModeAnswer) -> f64 {
    let metric = |a: [f64; 3]| [a[0], a[1], a[2] * fields.gyration_radius];
    let (load, y) =
        (metric(fields.free_acceleration), metric(answer.acceleration[..].try_into().unwrap()));
    let mut newton = [0, 1, 2].map(|k| y[k] - load[k]);
    let mut scale = load.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let mut worst = 0.0_f64;
    for i in (0..fields.arms.len()).filter(|&i| fields.sliding[i].is_some()) {
        let [t, n] = metric_rows(fields, i);
        let stretch = dot(&n, &n).sqrt();
        let [f_t, f_n] = answer.forces[i].map(|f| f / fields.mass);
        for k in 0..3 {
            newton[k] -= t[k] * f_t + n[k] * f_n;
        }
        let bias = fields.bias[i].map(|bias| bias / stretch);
        let a_t = (dot(&t, &y) / stretch + bias[0]).abs();
        let a_n = (dot(&n, &y) / stretch + bias[1]).abs();
        let friction = |side: f64| (f_t - side * fields.friction[i] * f_n).abs() * stretch;
        worst = worst.max(match answer.word.mode(i) {
            Mode::Separate => f_t.hypot(f_n) * stretch,
            Mode::Fixed => a_t.max(a_n),
            Mode::Right => a_n.max(friction(-1.0)),
            Mode::Left => a_n.max(friction(1.0)),
        });
        scale = scale.max(bias[0].abs()).max(bias[1].abs()).max(f_t.hypot(f_n) * stretch);
    }
    newton.iter().fold(worst, |most, a| most.max(a.abs())) / scale
}

#[derive(Default)]
struct Count {
    solvable: usize,
    found: usize,
    wrong: usize,
    residual: f64,
}

fn campaign(make: fn(&mut Random) -> ProblemFields, problems: usize, seed: u64) -> Count {
    let mut draw = Random(seed);
    let mut count = Count::default();
    for _ in 0..problems {
        let fields = make(&mut draw);
        let problem = ContactProblem::new(fields.clone()).unwrap();
        let all = contact_modes(&problem, Method::Enumerate).unwrap();
        let searched = contact_modes(&problem, Method::Qp).unwrap();
        assert_ne!(searched.status(), Status::None);
        count.solvable += usize::from(all.consistent().next().is_some());
        for answer in searched.answers() {
            count.found += 1;
            count.wrong += usize::from(!all.get(answer.word).is_some_and(|same| same.consistent));
            count.residual = count.residual.max(residual(&fields, answer));
        }
    }
    count
}

fn fixed_point(problems: usize) {
    let _table = TABLE.lock();
    println!("class                       problems  solvable     found       %  residual  wrong");
    for (class, seed) in CLASSES.iter().zip(1..) {
        let Count { solvable, found, wrong, residual } = campaign(class.make, problems, seed);
        let part = found as f64 / solvable as f64;
        println!(
            "{:27}{problems:9}{solvable:10}{found:10}{:8.2}{residual:10.1e}{wrong:7}",
            class.name,
            100.0 * part
        );
        assert_eq!(wrong, 0, "{}", class.name);
        assert!(part >= class.least, "{}: found {found} of {solvable}", class.name);
        assert!(residual <= POLISHED, "{}: residual {residual:e}", class.name);
    }
}

#[test]
fn the_fixed_point_finds_modes() {
    fixed_point(FEW);
}

#[test]
#[ignore = "half a minute"]
fn the_fixed_point_finds_modes_in_ten_thousand_problems_of_a_class() {
    fixed_point(MANY);
}

/// Coulomb's law at rest as one linear complementarity problem 0 ≤ z ⊥ Mz + q ≥ 0 [Stewart & Trinkle 1996; Anitescu &
/// Potra 1997], z = (f_n; f_t⁺, f_t⁻; λ), forces per unit mass, coordinates (x, y, ρθ), D = (T, −T):
///
/// ```text
///     ⎡ NNᵀ  NDᵀ  0 ⎤       ⎡ N a₀ ⎤      a_n ≥ 0                   ⊥ f_n ≥ 0
/// M = ⎢ DNᵀ  DDᵀ  E ⎥   q = ⎢ D a₀ ⎥      ±a_t + λ ≥ 0              ⊥ f_t^± ≥ 0
///     ⎣ μ    −Eᵀ  0 ⎦       ⎣ 0    ⎦      μ f_n − f_t⁺ − f_t⁻ ≥ 0   ⊥ λ ≥ 0
/// ```
fn complementarity(fields: &ProblemFields) -> (DMatrix<f64>, DVector<f64>) {
    let n = fields.arms.len();
    let pushes = DMatrix::from_fn(3, 3 * n, |k, j| {
        let [t, normal] = metric_rows(fields, j % n);
        [normal[k], t[k], -t[k]][j / n]
    });
    let [x, y, turn] = fields.free_acceleration;
    let load = DVector::from_vec(vec![x, y, turn * fields.gyration_radius]);
    let mut m = DMatrix::zeros(4 * n, 4 * n);
    let mut q = DVector::zeros(4 * n);
    m.view_mut((0, 0), (3 * n, 3 * n)).copy_from(&(pushes.transpose() * &pushes));
    q.rows_mut(0, 3 * n).copy_from(&(pushes.transpose() * load));
    for i in 0..n {
        m[(3 * n + i, i)] = fields.friction[i];
        for side in [n + i, 2 * n + i] {
            (m[(side, 3 * n + i)], m[(3 * n + i, side)]) = (1.0, -1.0);
        }
    }
    (m, q)
}

/// Clarabel on min zᵀ(Mz + q) subject to z ≥ 0, Mz + q ≥ 0; `None` unless it reports the problem as solved.
fn as_one_programme(m: &DMatrix<f64>, q: &DVector<f64>) -> Option<DVector<f64>> {
    let size = q.len();
    let matrix = |rows: usize, entry: &dyn Fn(usize, usize) -> f64| {
        let row = |i| (0..size).map(|j| entry(i, j)).collect::<Vec<_>>();
        CscMatrix::from(&(0..rows).map(row).collect::<Vec<_>>())
    };
    let quadratic = matrix(size, &|i, j| if i <= j { m[(i, j)] + m[(j, i)] } else { 0.0 });
    let constraints = matrix(2 * size, &|i, j| {
        if i < size { -m[(i, j)] } else { -f64::from(u8::from(i - size == j)) }
    });
    let mut bounds = q.as_slice().to_vec();
    bounds.resize(2 * size, 0.0);
    let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    let cones = [SupportedConeT::NonnegativeConeT(2 * size)];
    let mut solver =
        DefaultSolver::new(&quadratic, q.as_slice(), &constraints, &bounds, &cones, settings)
            .unwrap();
    solver.solve();
    matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved)
        .then(|| DVector::from_column_slice(&solver.solution.x))
}

/// The word of a solution: of two complementary quantities the smaller one counts as zero. Values below `blur` count as
/// zero in favour of a static word.
fn read(fields: &ProblemFields, z: &DVector<f64>, w: &DVector<f64>, blur: f64) -> Word {
    let n = fields.arms.len();
    let letter = |i: usize| {
        let (right, left) = (n + i, 2 * n + i);
        let along = 0.5 * (w[right] - w[left]);
        let room = fields.friction[i] * z[i] - (z[right] - z[left]).abs();
        match along {
            _ if w[i] > z[i].max(blur) => 'S',
            _ if along.abs() <= room.max(blur) => 'F',
            0.0.. => 'R',
            _ => 'L',
        }
    };
    (0..n).map(letter).collect::<String>().parse().unwrap()
}

/// Largest rounding error of a zero eigenvalue of matrices of order one.
const ZERO: f64 = 1e-14;
/// Largest zᵀ(Mz + q) that counts as complementary, for loads of order one: far above Clarabel's gap of 1e-8.
const COMPLEMENTARY: f64 = 1e-5;
/// Values below which a quantity may count as zero in the solution of a convex program. The words read with each of
/// them count.
const BLURS: [f64; 4] = [0.0, 1e-6, 1e-4, 1e-3];

/// Number of solvable problems of `n` contacts at rest in which Clarabel reports the single program as solved, its
/// solution is complementary, and a word read from it is consistent; and in which the fixed point finds a mode.
#[derive(Debug, Default)]
struct Outcome {
    solvable: usize,
    solved: usize,
    complementary: usize,
    consistent: usize,
    fixed_point: usize,
}

fn one_programme(n: &[usize], friction: &Range<f64>, problems: usize, seed: u64) -> Outcome {
    let mut draw = Random(seed);
    let mut count = Outcome::default();
    for _ in 0..problems {
        let n = draw.pick(n);
        let fields = draw.body(n, friction.clone());
        let problem = ContactProblem::new(fields.clone()).unwrap();
        let all = contact_modes(&problem, Method::Enumerate).unwrap();
        if all.status() == Status::None {
            continue;
        }
        count.solvable += 1;
        let (m, q) = complementarity(&fields);
        if let Some(z) = as_one_programme(&m, &q) {
            let w = &m * &z + &q;
            count.solved += 1;
            count.complementary += usize::from(z.dot(&w).abs() <= COMPLEMENTARY);
            count.consistent += usize::from(BLURS.into_iter().any(|blur| {
                all.get(read(&fields, &z, &w, blur)).is_some_and(|answer| answer.consistent)
            }));
        }
        let searched = contact_modes(&problem, Method::Qp).unwrap();
        count.fixed_point += usize::from(searched.status() == Status::Found);
    }
    count
}

fn one_programme_against_the_fixed_point(problems: usize) {
    let _table = TABLE.lock();
    println!(
        "contacts at rest           solvable    solved  complementary  consistent  fixed point"
    );
    for (number, n) in [("two", &TWO[..]), ("three to ten", &MORE)] {
        for (name, friction) in
            [("no friction", 0.0..0.0), ("low friction", LOW), ("high friction", HIGH)]
        {
            let Outcome { solvable, solved, complementary, consistent, fixed_point } =
                one_programme(n, &friction, problems, 11);
            let name = format!("{number}, {name}");
            println!(
                "{name:27}{solvable:8}{solved:10}{complementary:15}{consistent:12}{fixed_point:13}"
            );
            let least = if n == TWO { 0.999 } else { 0.99 };
            assert!(fixed_point as f64 >= least * solvable as f64, "{name}");
            if friction.end == 0.0 {
                assert!(consistent as f64 >= 0.99 * solvable as f64, "{name}");
            } else {
                assert!(consistent < solvable / 2, "{name}");
            }
        }
    }
}

#[test]
fn the_complementarity_problem_is_no_convex_programme() {
    // A block on two feet. zᵀMz is |Jᵀf|² + Σ μ f_n λ: indefinite as soon as μ > 0.
    let least = |mu: f64| {
        let block = ProblemFields {
            mass: 1.0,
            gyration_radius: 0.5,
            arms: vec![[-1.0, -1.0], [1.0, -1.0]],
            tangents: vec![[1.0, 0.0]; 2],
            friction: vec![mu; 2],
            sliding: vec![Some(0); 2],
            bias: vec![[0.0; 2]; 2],
            free_acceleration: [0.0, -1.0, 0.0],
            level: Level::Acceleration,
        };
        let m = complementarity(&block).0;
        (&m + m.transpose()).symmetric_eigenvalues().min() / 2.0
    };
    assert!(least(0.0).abs() <= ZERO);
    let some = [0.01, 0.1, 0.5, 1.0].map(least);
    println!("least eigenvalues for friction 0.01, 0.1, 0.5, 1: {some:.5?}");
    assert!(some.is_sorted_by(|a, b| a > b) && some[0] < -ZERO);
    one_programme_against_the_fixed_point(FEW);
}

#[test]
#[ignore = "half a minute"]
fn the_complementarity_problem_as_one_programme_in_ten_thousand_problems_of_a_class() {
    one_programme_against_the_fixed_point(MANY);
}
