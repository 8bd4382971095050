//! The motion in a contact-mode word as Taylor series, and its first event.

use nalgebra::{Const, LU, Matrix3, Vector2, Vector3};
use smallvec::SmallVec;

use crate::body::contact::ContactLetters;
use crate::collisions::log::Spin;
use crate::flight::parabola_touchdown;
use crate::math::roots::{ORDER, first_root};
use crate::math::series::{
    Pair, Series, ZERO, constant, determinant, dot_product, product, products, radius,
};
use crate::modes::Mode;
use crate::sustained::rows::{AGREES, Row, Unknown};
use crate::sustained::side::SideContact;
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::{
    DRIFT, DRIFT_ENERGY, HULL_EDGE, OVER_VERTEX, SINGULAR_FRICTION_MATRIX, TOUCH,
};

#[derive(Debug, Clone)]
pub(super) struct Track {
    pub(super) mode: Mode,
    /// Fixed by friction or in a vertex.
    pub(super) stuck: bool,
    /// The other of two fixed points that hold a contact in a vertex.
    pub(super) partner: Option<usize>,
    /// Separate, but at the position of the other point of its contact, which is fixed.
    pub(super) pinned: bool,
    pub(super) friction: f64,
    /// b and c at the start, of the centre of a round contact, and its radius R.
    arm: [f64; 2],
    radius: f64,
    /// A round contact that touches both pieces of a vertex: its centre does not move.
    centered: bool,
    /// It has been so up to now: its other point has just lifted off, and speed and acceleration of the centre are zero.
    leaves_corner: bool,
    /// Gap and rate, of separate contacts.
    pub(super) h: Series,
    pub(super) u: Series,
    /// v_t of contacts that may slide.
    pub(super) slip: Series,
    /// λ, τ
    pub(super) normal: Series,
    pub(super) tangential: Series,
}

/// The motion as Taylor series in the time since the start of a step, with `unit` as the unit of time.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    pub(super) theta: Series,
    pub(super) omega: Series,
    /// cos Δθ and sin Δθ of the rotation since the start, which turns all arms: b = b₀ cos Δθ − c₀ sin Δθ, c = c₀ cos Δθ + b₀ sin Δθ.
    pub(super) rotation: Pair,
    /// Displacement and velocity of the centre of mass, (x, y).
    pub(super) r: [Series; 2],
    pub(super) v: [Series; 2],
    pub(super) tracks: Vec<Track>,
    /// Determinant of the friction matrix, made positive at the start.
    pub(super) determinant: Series,
    /// Sign of the determinant before this change; zero where it cannot vanish.
    pub(crate) side: f64,
    /// A power of two, in s. Coefficients then stay in range on any time scale, and scaling is exact.
    pub(super) unit: f64,
    /// Time up to which the series are accurate to the last digit, in units.
    pub(super) reach: f64,
    pub(super) order: usize,
    /// The points whose normals turn.
    pub(super) turning: Vec<TurningPoint>,
}

/// Numbers of coefficients to try, and the time, in units, up to which each is expected to be accurate: most steps are short and
/// need few. A longer motion takes several steps with the last number.
pub(crate) const ORDERS: [(usize, f64); 3] = [(8, 0.003), (13, 0.06), (ORDER, f64::INFINITY)];

/// Factor of the unit of time when coefficients overflow. Its inverse: time, in units, up to which a rotation is followed, because
/// coefficients that matter later may have underflowed. Limits of the units, so that squares of accelerations stay in range.
const SHORTER: f64 = 1.0 / LATE;
const LATE: f64 = 4_294_967_296.0;
const SHORTEST_UNIT: f64 = 1e-100;
const LONGEST_UNIT: f64 = 1e50;
/// Binary exponent of the longest unit of time at the start; its square stays in range.
const SQUARED: i32 = 500;

/// Number of Taylor coefficients where nothing turns. Forces are constant there, so that only the first three coefficients differ from zero.
/// The last two are zero, from which `radius` finds that the series hold for any time.
const CONSTANT: usize = 5;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum StepEnd {
    /// No event: another step follows.
    Reach,
    /// This contact lands.
    Landing(usize),
    /// This contact, which came under its terrain from the side, rises out of it.
    Surface(usize),
    /// The normal force of this contact has decreased to zero: it lifts off.
    LiftOff(usize),
    /// The sliding speed of this contact has decreased to zero.
    Stop(usize),
    /// The force of this fixed contact has reached the edge of its cone: it begins to slide in this direction.
    Slip(usize, Mode),
    /// The friction matrix becomes singular: forces grow without bounds (dynamic jam).
    Jam,
    /// This contact hits a piece of terrain that does not adjoin its own.
    Strike(usize, isize),
    /// This contact comes to an end of the piece of terrain under it: the left (0) or the right (1) one.
    Leave(usize, usize),
}

/// A regular friction matrix, factorised.
pub(super) enum Factors {
    None,
    /// Its only entry.
    One(f64),
    /// Whether its rows are exchanged, the factor of the first row in the second one, and the first row and the last pivot.
    Two(bool, f64, [f64; 3]),
    Three(LU<f64, Const<3>, Const<3>>),
}

impl Factors {
    /// Of the first n rows and columns.
    pub(super) fn of(m: Matrix3<f64>, n: usize) -> Self {
        match n {
            0 => Self::None,
            1 => Self::One(m[(0, 0)]),
            2 => {
                let exchanged = m[(1, 0)].abs() > m[(0, 0)].abs();
                let (one, two) = if exchanged { (1, 0) } else { (0, 1) };
                let factor = m[(two, 0)] / m[(one, 0)];
                let pivot = m[(two, 1)] - factor * m[(one, 1)];
                Self::Two(exchanged, factor, [m[(one, 0)], m[(one, 1)], pivot])
            }
            _ => Self::Three(m.lu()),
        }
    }

    pub(super) fn solve(&self, right: &Vector3<f64>) -> Option<Vector3<f64>> {
        match self {
            Self::None => Some(Vector3::zeros()),
            Self::One(entry) => Some(Vector3::new(right.x / entry, 0.0, 0.0)),
            Self::Two(exchanged, factor, [first, beside, pivot]) => {
                let (one, two) = if *exchanged { (right.y, right.x) } else { (right.x, right.y) };
                let y = (two - factor * one) / pivot;
                Some(Vector3::new((one - beside * y) / first, y, 0.0))
            }
            Self::Three(lu) => lu.solve(right),
        }
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl BodyState {
    /// The largest power of two below the time in which the body turns by about a radian, in s: 1/ω, or √(size/g) if shorter; its
    /// square stays in range.
    fn unit_of_time(&self) -> f64 {
        let arm = self.points.iter().map(|p| libm::hypot(p.b, p.c)).fold(0.0, f64::max);
        let size = arm + self.rho2.sqrt();
        let rate = self.spin.omega.abs().max((self.gravity / size).sqrt());
        if rate > 0.0 { libm::ldexp(1.0, SQUARED.min(-libm::ilogb(rate))) } else { 1.0 }
    }

    /// Estimated time until a contact lands or stops sliding, in units, at this acceleration.
    pub(crate) fn soon(&self, modes: &[Mode], [ax, ay, turn]: [f64; 3]) -> f64 {
        let a = Vector2::new(ax, ay);
        let event = |(i, mode): (usize, &Mode)| {
            let p = &self.points[i];
            match mode {
                Mode::Separate => {
                    let fall = p.c * self.spin.omega * self.spin.omega - p.normal.dot(&a);
                    parabola_touchdown(p.h, p.u, fall - p.b * turn)
                }
                Mode::Fixed => f64::INFINITY,
                _ => {
                    let t = -self.slip(i) / (p.tangent.dot(&a) - p.touching_c() * turn);
                    if t > 0.0 { t } else { f64::INFINITY }
                }
            }
        };
        modes.iter().enumerate().map(event).fold(f64::INFINITY, f64::min) / self.unit_of_time()
    }
}

/// A corner of the ground on a side or on a disc, as series.
#[derive(Debug, Clone)]
pub(super) struct TurningPoint {
    /// The point.
    pub(super) point: usize,
    /// `None`: it is on a disc.
    pub(super) side: Option<SideContact>,
    pub(super) normal: [Series; 2],
    pub(super) b: Series,
    pub(super) c: Series,
}

impl TurningPoint {
    pub(super) fn tangent(&self) -> [Series; 2] {
        [self.normal[1], self.normal[0].map(|n| -n)]
    }
}

impl Track {
    /// Of point `i` at the start, in this unit of time (s).
    #[inline]
    fn new(state: &BodyState, modes: &[Mode], i: usize, unit: f64) -> Self {
        let p = &state.points[i];
        let is_held = |j: usize| modes[j] != Mode::Separate;
        Self {
            mode: modes[i],
            stuck: state.sticks(i, modes),
            partner: state.partner(i, modes),
            pinned: modes[i] == Mode::Separate
                && state.twin(i).is_some_and(|j| modes[j] == Mode::Fixed),
            friction: p.friction,
            arm: [p.b, p.c],
            radius: p.radius,
            leaves_corner: false,
            centered: p.radius > 0.0
                && [Some(i), state.second(i)].iter().all(|j| j.is_some_and(is_held)),
            h: constant(if p.depth > 0.0 { -p.depth } else { p.h }),
            u: constant(p.u * unit),
            slip: constant(state.slip(i) * unit),
            normal: ZERO,
            tangential: ZERO,
        }
    }
}

impl Track {
    /// Coefficient k + 1 of the sliding speed from coefficient k of v̇ and of ω̇, with c ω̇ + b ω² = (c₀, b₀)·a:
    ///
    /// ```text
    /// v̇_t = t·v̇ − c ω̇ − b ω²
    /// ```
    #[inline]
    fn slide(&mut self, p: &ContactState, push: &Vector2<f64>, turn: f64, a: [f64; 2], k: usize) {
        let mut slip = p.tangent.dot(push) - dot([p.c, p.b], a);
        if p.radius > 0.0 {
            slip += p.radius * turn;
        }
        self.slip[k + 1] = slip / (k + 1) as f64;
    }

    /// The gap and its rate of a point in the air, from v and from the derivative `spun` of (sin Δθ, −cos Δθ):
    ///
    /// ```text
    /// u = n·v + (b₀, −c₀)·spun
    /// ```
    #[inline]
    fn fly(&mut self, p: &ContactState, v: &[Series; 2], spun: &Pair, order: usize) {
        for k in 1..order {
            let turned = p.b * spun[k][0] - p.c * spun[k][1];
            self.u[k] = p.normal.x * v[0][k] + p.normal.y * v[1][k] + turned;
            self.h[k] = self.u[k - 1] / k as f64;
        }
    }
}

/// The unknown forces, at the start. Force l acts along n + slope t, or t, and turns the body by its arm; row m stays zero. A lever b is
/// (b₀, −c₀)·e, and c is (c₀, b₀)·e, with e = (cos Δθ, sin Δθ).
struct Unknowns {
    unknowns: SmallVec<[Unknown; 3]>,
    row: [Vector2<f64>; 3],
    slope: [f64; 3],
    along: [Vector2<f64>; 3],
    lever: [[f64; 2]; 3],
    arm: [[f64; 2]; 3],
    centripetal: [[f64; 2]; 3],
    /// The constant parts of levers and arms of round contacts: R in −(c − R), slope R in b − slope (c − R).
    still_lever: [f64; 3],
    still_arm: [f64; 3],
    levers: [f64; 3],
    matrix: Matrix3<f64>,
}

impl Unknowns {
    /// `None` if their matrix is singular.
    #[inline]
    fn new(independent: &[Row], state: &BodyState, modes: &[Mode]) -> Option<Self> {
        let unknowns: SmallVec<[Unknown; 3]> = independent.iter().map(|row| row.unknown).collect();
        let n = unknowns.len();
        let mut row = [Vector2::zeros(); 3];
        let (mut slope, mut along) = ([0.0; 3], [Vector2::zeros(); 3]);
        let (mut lever, mut arm, mut centripetal) = ([[0.0; 2]; 3], [[0.0; 2]; 3], [[0.0; 2]; 3]);
        let (mut still_lever, mut still_arm) = ([0.0; 3], [0.0; 3]);
        for (l, &u) in unknowns.iter().enumerate() {
            let p = &state.points[u.contact];
            if u.tangential {
                (row[l], along[l]) = (p.tangent, p.tangent);
                (lever[l], centripetal[l]) = ([-p.c, -p.b], [p.b, -p.c]);
            } else {
                slope[l] = -modes[u.contact].direction() * p.friction;
                (row[l], along[l]) = (p.normal, p.normal + p.tangent * slope[l]);
                (lever[l], centripetal[l]) = ([p.b, -p.c], [p.c, p.b]);
            }
            if p.radius > 0.0 {
                let part = if u.tangential { p.radius } else { 0.0 };
                (still_lever[l], still_arm[l]) = (part, part + slope[l] * p.radius);
            }
            arm[l] = [lever[l][0] - slope[l] * p.c, lever[l][1] - slope[l] * p.b];
        }
        let levers: [f64; 3] = std::array::from_fn(|m| lever[m][0] + still_lever[m]);
        let arms: [f64; 3] = std::array::from_fn(|l| arm[l][0] + still_arm[l]);
        let matrix = Matrix3::from_fn(|i, j| match (i < n, j < n) {
            (true, true) => levers[i] * arms[j] / state.rho2 + row[i].dot(&along[j]),
            _ => f64::from(u8::from(i == j)),
        });
        // Lengths of the columns before cancellation: a single contact that jams has no other scale.
        let size: f64 = (0..n)
            .map(|l| {
                let (p, bent) = (&state.points[unknowns[l].contact], slope[l].abs());
                let side = p.tangent * bent;
                let reach = levers[l].abs() + bent * p.touching_c().abs();
                let square = |m: usize| {
                    let push = row[m].dot(&row[l]).abs() + row[m].dot(&side).abs();
                    let turn = levers[m].abs() * reach / state.rho2;
                    (push + turn) * (push + turn)
                };
                (0..n).map(square).sum::<f64>().sqrt()
            })
            .product();
        (matrix.determinant().abs() > SINGULAR_FRICTION_MATRIX * size).then_some(Self {
            unknowns,
            row,
            slope,
            along,
            lever,
            arm,
            centripetal,
            still_lever,
            still_arm,
            levers,
            matrix,
        })
    }

    /// The determinant of their matrix as a series that begins positive, and its sign at the start. Without sliding friction it is that of the
    /// Gram matrix of independent rows, which stays positive: 1 and 0 stand for it.
    #[inline]
    fn determinant(&self, rotation: &[[f64; 2]; ORDER], rho2: f64, order: usize) -> (Series, f64) {
        let n = self.unknowns.len();
        if self.slope[..n].iter().all(|slope| *slope == 0.0) {
            return (constant(1.0), 0.0);
        }
        let series = |lever: [f64; 2]| rotation.map(|e| dot(lever, e));
        let (mut levers, mut arms) = (self.lever.map(series), self.arm.map(series));
        for l in 0..n {
            levers[l][0] += self.still_lever[l];
            arms[l][0] += self.still_arm[l];
        }
        let mut whole = [[ZERO; 3]; 3];
        for (i, row) in whole[..n].iter_mut().enumerate() {
            for (j, entry) in row[..n].iter_mut().enumerate() {
                for k in 0..order {
                    entry[k] = product(&levers[i], &arms[j], k) / rho2;
                }
                entry[0] = self.matrix[(i, j)];
            }
        }
        with_sign(determinant(&whole, n, order))
    }
}

/// A series that begins positive, and the sign that this one begins with.
pub(super) fn with_sign(determinant: Series) -> (Series, f64) {
    let side = determinant[0].signum();
    (if side < 0.0 { determinant.map(|c| -c) } else { determinant }, side)
}

/// The time, in units, up to which the series hold.
#[inline]
fn reach(tracks: &[Track], rotation: &[[f64; 2]; ORDER], omega: &Series, order: usize) -> f64 {
    let ends = |series: &Series| [0, 1, 2, order - 2, order - 1].map(|k| series[k]);
    let arms = |lever: [f64; 2]| [0, 1, 2, order - 2, order - 1].map(|k| dot(lever, rotation[k]));
    let mut all: SmallVec<[[f64; 5]; 17]> = SmallVec::new();
    all.push(ends(omega));
    let square = |track: &Track| dot(track.arm, track.arm);
    let longest = tracks.iter().map(square).fold(0.0, f64::max);
    for track in tracks {
        let Track { arm: [b, c], normal, tangential, .. } = track;
        let held = track.mode != Mode::Separate;
        // The arms of points in the air are known as well as the longest one.
        if held || square(track) == longest {
            all.extend([arms([*b, -c]), arms([*c, *b])]);
        }
        if held {
            all.extend([ends(normal), ends(tangential)]);
        }
    }
    let reach = radius(&all, f64::EPSILON * 0.1, order);
    let varies = |series: &Series| series[1..order].iter().any(|c| *c != 0.0);
    let has_arm = tracks.iter().any(|track| track.arm != [0.0; 2]);
    let is_turned = has_arm && rotation[1..order].iter().any(|e| *e != [0.0; 2]);
    let forces = |track: &Track| varies(&track.normal) || varies(&track.tangential);
    // Nothing turns a disc about the centre of mass out of a constant angular acceleration.
    let turned = is_turned || has_arm && varies(omega);
    if turned || tracks.iter().any(forces) { reach.min(LATE) } else { reach }
}

impl Step {
    /// The Taylor series of the motion from this state on, with a mode for each contact; `None` if the friction matrix is singular.
    /// `order`: the number of coefficients, at most [`ORDER`].
    pub(crate) fn new(state: &BodyState, modes: &[Mode], order: usize) -> Option<Box<Self>> {
        let rows = state.independent(modes);
        Self::on(&rows, state, modes, order).or_else(|| {
            // If these forces cannot keep their own rows at zero, those of dependent rows may.
            rows.iter().find_map(|row| {
                let others = state.independent_but(row.unknown, modes);
                let same = others.len() == rows.len();
                same.then(|| Self::on(&others, state, modes, order)).flatten()
            })
        })
    }

    fn on(rows: &[Row], state: &BodyState, modes: &[Mode], order: usize) -> Option<Box<Self>> {
        let mut unit = state.unit_of_time();
        let mut step = Self::in_units(rows, state, modes, order, unit)?;
        while !step.is_finite() && unit >= SHORTEST_UNIT {
            unit *= SHORTER;
            step = Self::in_units(rows, state, modes, order, unit)?;
        }
        Some(step)
    }

    /// The same step in a longer unit of time, for late events: coefficients of a slow rotation that matter by then may have
    /// underflowed. `None` if it is not needed.
    pub(crate) fn longer(&self, state: &BodyState, modes: &[Mode], t: f64) -> Option<Box<Self>> {
        let late = t >= LATE * self.unit && self.reach == LATE && self.unit <= LONGEST_UNIT;
        let rows = || state.independent(modes);
        let step =
            late.then(|| Self::in_units(&rows(), state, modes, self.order, LATE * self.unit));
        step.flatten().filter(|step| step.is_finite())
    }

    /// Returns true if its last coefficients are finite: near a jam they grow like powers of the inverse of the time to it.
    fn is_finite(&self) -> bool {
        let last = |series: &Series| series[self.order - 1].is_finite();
        let forces = |track: &Track| last(&track.normal) && last(&track.tangential);
        last(&self.omega) && self.v.iter().all(last) && self.tracks.iter().all(forces)
    }

    fn in_units(
        independent: &[Row],
        state: &BodyState,
        modes: &[Mode],
        order: usize,
        unit: f64,
    ) -> Option<Box<Self>> {
        // Its coefficients 0 and 1.
        let pull = [state.fall * unit * unit, state.fall_rate * unit * unit * unit];
        let pull = |k: usize| pull.get(k).copied().unwrap_or_default();
        let mut tracks: Vec<Track> =
            (0..state.points.len()).map(|i| Track::new(state, modes, i, unit)).collect();
        if state.turns() {
            return Self::with_turning_normals(independent, state, modes, order, unit, tracks);
        }
        let parallel = state.parallel(independent);
        let level = parallel.is_some_and(|pair| state.is_level(pair));
        let turns = !level;
        let order = if turns { order } else { order.min(CONSTANT) };
        let spin = if level { 0.0 } else { state.spin.omega };
        let (mut theta, mut omega) = (constant(state.spin.theta), constant(spin * unit));
        let mut r = [0, 1].map(|axis: usize| constant(state.center.r[axis]));
        let mut v = [0, 1].map(|axis: usize| constant(state.center.v[axis] * unit));
        // e = (cos Δθ, sin Δθ), e ω, and e ω² as far as it curves the paths of the contact points.
        let (mut rotation, mut spun) = ([[0.0; 2]; ORDER], [[0.0; 2]; ORDER]);
        rotation[0] = [1.0, 0.0];
        let mut spin_rate = ZERO; // ω̇
        let forces = Unknowns::new(independent, state, modes)?;
        let n = forces.unknowns.len();
        let first = Factors::of(forces.matrix, n);
        let slides = |i: &usize| modes[*i] != Mode::Separate && !tracks[*i].stuck;
        let sliding: SmallVec<[usize; 4]> = (0..tracks.len()).filter(slides).collect();
        let mut torque = [[0.0; 2]; ORDER]; // Σ arm f, of the forces f and their arms at the start
        for k in 0..order {
            let next = 1.0 / (k + 1) as f64;
            let curved = if turns {
                spun[k] = products(&rotation[..=k], &omega[..=k]);
                products(&spun[..=k], &omega[..=k])
            } else {
                [0.0; 2]
            };
            // The terms of e ω̇ and of Σ arm f without the coefficients k of ω̇ and of the forces, which are still unknown.
            let turned = products(&rotation[1..=k], &spin_rate[..k]);
            let twisted = dot_product(&rotation[1..=k], &torque[..k]) / state.rho2;
            let mut right = Vector3::zeros();
            for m in 0..n {
                right[m] = dot(forces.centripetal[m], curved)
                    - dot(forces.lever[m], turned)
                    - forces.levers[m] * twisted;
                if k < 2 {
                    right[m] -= forces.row[m].dot(&pull(k));
                }
            }
            let solved = first.solve(&right)?;
            let mut push = pull(k);
            let mut rolling = 0.0; // moment of the forces with their constant arms
            for (l, &u) in forces.unknowns.iter().enumerate() {
                let (force, arm) = (solved[l], forces.arm[l]);
                push += forces.along[l] * force;
                rolling += forces.still_arm[l] * force;
                torque[k] = [torque[k][0] + arm[0] * force, torque[k][1] + arm[1] * force];
                let track = &mut tracks[u.contact];
                if u.tangential {
                    track.tangential[k] = force;
                } else {
                    track.normal[k] = force;
                    track.tangential[k] += forces.slope[l] * force;
                }
            }
            if k + 1 == order {
                break;
            }
            let mut turn = (torque[k][0] + rolling) / state.rho2 + twisted;
            if let Some([i, j]) = parallel {
                // (b_i − b_j) ω̇ = (c_i − c_j) ω² − (n_i − n_j)·v̇, and n_i·v̇ = c_i ω² − b_i ω̇
                let (one, two) = (&state.points[i], &state.points[j]);
                let (b, c) = (one.b - two.b, one.c - two.c);
                let curved = if level { [0.0; 2] } else { curved };
                turn = (dot([c, b], curved)
                    - (one.normal - two.normal).dot(&push)
                    - dot([b, -c], turned))
                    / b;
                let off = dot([one.c, one.b], curved) - one.b * turn - dot([one.b, -one.c], turned);
                push += one.normal * (off - one.normal.dot(&push));
            }
            spin_rate[k] = turn;
            theta[k + 1] = omega[k] * next;
            omega[k + 1] = turn * next;
            for axis in 0..2 {
                r[axis][k + 1] = v[axis][k] * next;
                v[axis][k + 1] = push[axis] * next;
            }
            rotation[k + 1] = [-spun[k][1] * next, spun[k][0] * next];
            // The second derivative of (sin Δθ, −cos Δθ).
            let a = [turned[0] + turn - curved[1], turned[1] + curved[0]];
            for &i in &sliding {
                tracks[i].slide(&state.points[i], &push, turn, a, k);
            }
        }
        for (track, p) in tracks.iter_mut().zip(&state.points) {
            if track.mode == Mode::Separate && !track.pinned {
                track.fly(p, &v, &spun, order);
            }
        }
        let reach = state.within_changing_load(reach(&tracks, &rotation, &omega, order));
        let (determinant, side) = forces.determinant(&rotation, state.rho2, order);
        Some(Box::new(Self {
            theta,
            omega,
            rotation,
            r,
            v,
            tracks,
            determinant,
            side,
            unit,
            reach,
            order,
            turning: Vec::new(),
        }))
    }

    /// b and c of a contact.
    pub(super) fn arm(&self, i: usize) -> [Series; 2] {
        if let Some(turning) = self.turning(i) {
            return [turning.b, turning.c];
        }
        let [b, c] = self.tracks[i].arm;
        [[b, -c], [c, b]].map(|lever| self.rotation.map(|e| dot(lever, e)))
    }

    /// Contact `i` has just lifted off: its gap, rate and acceleration are zero, up to rounding error.
    pub(crate) fn lifts_off(&mut self, i: usize) {
        let track = &mut self.tracks[i];
        track.h[..3].fill(0.0);
        track.u[..2].fill(0.0);
    }

    /// The other point of the round contact `i`, which touches both pieces of a vertex, has just lifted off.
    pub(crate) fn leaves_corner(&mut self, i: usize) {
        self.tracks[i].leaves_corner = self.tracks[i].radius > 0.0;
    }

    /// Contact `i` begins to slide from rest: a speed in the opposite direction is rounding error.
    pub(crate) fn starts(&mut self, i: usize) {
        let track = &mut self.tracks[i];
        if track.slip[0] * track.mode.direction() < 0.0 {
            track.slip[0] = 0.0;
        }
    }

    /// Contact `i` has just broken loose: its sliding speed and acceleration are zero. Returns whether it then slides in the
    /// direction of its mode; where it jams it does not.
    pub(crate) fn breaks_loose(&mut self, i: usize) -> bool {
        let track = &mut self.tracks[i];
        track.slip[..2].fill(0.0);
        let first = track.slip.iter().find(|c| **c != 0.0);
        first.is_none_or(|c| c * track.mode.direction() > 0.0)
    }

    /// Displacement of a point in a direction since the start, of the centre of a round contact. A sliding point moves along its terrain; a
    /// fixed one does not move, unless it is round and rolls.
    pub(super) fn way(&self, i: usize, state: &BodyState, across: Vector2<f64>) -> Series {
        let (track, p) = (&self.tracks[i], &state.points[i]);
        let [t, n] = [p.tangent, p.normal].map(|axis| across.dot(&axis));
        let mut way = ZERO;
        let about = |_: &&TurningPoint| p.radius > 0.0 && !track.centered;
        if let Some(TurningPoint { normal, .. }) = self.turning(i).filter(about) {
            // The centre is at D n from its corner.
            for (k, way) in way.iter_mut().enumerate().skip(1) {
                let n = |k: usize| across.x * normal[0][k] + across.y * normal[1][k];
                *way = p.radius * n(k);
                if track.mode == Mode::Separate {
                    *way += (0..=k).map(|j| track.h[j] * n(k - j)).sum::<f64>();
                }
            }
            if track.leaves_corner {
                way[..3].fill(0.0);
            }
            return way;
        }
        match track.mode {
            Mode::Fixed if track.stuck && track.radius == 0.0 => {
                way[1] = t * p.surface_speed * self.unit;
            }
            _ if track.centered => {}
            Mode::Separate => {
                let [b, c] = self.arm(i);
                for (k, way) in way.iter_mut().enumerate().skip(1) {
                    let turned = t * b[k] + n * c[k];
                    *way = across.x * self.r[0][k] + across.y * self.r[1][k] + turned;
                }
            }
            _ => {
                for k in 1..ORDER {
                    let slip = if track.stuck { 0.0 } else { track.slip[k - 1] };
                    let speed = match track.radius {
                        0.0 => slip,
                        // The speed of the centre at the start may be zero by cancellation, in a vertex.
                        radius => {
                            let spin = radius * self.omega[k - 1];
                            let terms = slip.abs() + spin.abs();
                            let known = OVER_VERTEX * f64::EPSILON * terms;
                            if k == 1 && (slip - spin).abs() <= known { 0.0 } else { slip - spin }
                        }
                    };
                    way[k] = t * speed / k as f64;
                }
                way[1] += t * p.surface_speed * self.unit;
                if track.leaves_corner {
                    way[..3].fill(0.0);
                }
            }
        }
        way
    }

    /// Distances of a point from the separating lines at the start and at the end of its piece of terrain.
    fn sides(&self, i: usize, state: &BodyState) -> [Series; 2] {
        let place = &state.points[i].place;
        if let Some(TurningPoint { b, side: Some(_), .. }) = self.turning(i) {
            let mut sides = [*b, b.map(|b| -b)];
            (sides[0][0], sides[1][0]) = (place.sides[0], place.sides[1]);
            return sides;
        }
        let [one, two] = place.across.map(|across| self.way(i, state, across));
        let mut sides = [one, two.map(|k| -k)];
        (sides[0][0], sides[1][0]) = (place.sides[0], place.sides[1]);
        sides
    }

    /// Margins of the force on a contact that is held in a vertex to the two edges of the hull of its friction cones, and the event
    /// on each edge. With l, r the pieces on the left and on the right of the vertex, the edges are
    ///
    /// ```text
    /// e_l = n_l + μ_l t_l: the contact slides up the left piece,    e_r = n_r − μ_r t_r: up the right piece
    /// ```
    ///
    /// The force F is inside while e_l × F ≥ 0 and F × e_r ≥ 0. Where the hull spans half a turn or more, the pieces could hold any
    /// force by wedging, but the contact could slide up a piece as well. It then slides: it is held while one of the conditions
    /// holds, with F in one of the cones or between the normals. Both points of the contact have these edges; the first one reports
    /// them.
    pub(super) fn vertex_edges(
        &self,
        state: &BodyState,
        i: usize,
    ) -> SmallVec<[(Series, StepEnd); 2]> {
        let Some(j) = self.tracks[i].partner.filter(|&j| i < j) else { return SmallVec::new() };
        let points = &state.points;
        let (l, r) = if state.is_left_of(i, j) { (i, j) } else { (j, i) };
        let edge = |k: usize, side: f64| {
            points[k].normal + points[k].tangent * (side * points[k].friction)
        };
        let (e_l, e_r) = (edge(l, 1.0), edge(r, -1.0));
        let mut inside = [ZERO; 2];
        for k in [i, j] {
            let (p, track) = (&points[k], &self.tracks[k]);
            let [n, t] = [p.normal, p.tangent].map(|axis| [e_l.perp(&axis), axis.perp(&e_r)]);
            for (side, series) in inside.iter_mut().enumerate() {
                for (order, value) in series.iter_mut().enumerate() {
                    *value += n[side] * track.normal[order] + t[side] * track.tangential[order];
                }
            }
        }
        let events = [StepEnd::Slip(l, Mode::Left), StepEnd::Slip(r, Mode::Right)];
        if e_l.perp(&e_r) > 0.0 {
            return inside.into_iter().zip(events).collect();
        }
        let force =
            [i, j].map(|k| libm::hypot(self.tracks[k].normal[0], self.tracks[k].tangential[0]));
        let rounding = HULL_EDGE * (force[0] + force[1]) * (e_l.norm() + e_r.norm());
        let [left, right] = [0, 1].map(|side| inside[side][0]);
        if left.min(right) > rounding {
            // The first one to become negative has no consequence; then only the other one decides.
            inside.into_iter().map(|series| (series, StepEnd::Reach)).collect()
        } else {
            let side = usize::from(right > left);
            SmallVec::from_slice(&[(inside[side], events[side])])
        }
    }

    /// The first event within the step, and its time in s. `follows`: the contacts between two others, which land with these.
    pub(crate) fn first_event(&self, state: &BodyState, follows: &[bool]) -> (f64, StepEnd) {
        let end = self.reach;
        let mut first = (end, StepEnd::Reach);
        if end < f64::INFINITY
            && let Some(t) = first_root(&self.determinant, self.order, end)
        {
            first = (t, StepEnd::Jam);
        }
        for (i, track) in self.tracks.iter().enumerate() {
            let edge = |side: f64| {
                let mut series = ZERO;
                for k in 0..ORDER {
                    series[k] = track.friction * track.normal[k] + side * track.tangential[k];
                }
                series
            };
            let mut falls = |series: &Series, event: StepEnd| {
                // If the previous step ended on the event, it occurs now, unless the negative value is rounding error.
                let mut series = *series;
                let trend = series[1..].iter().find(|c| **c != 0.0).map_or(0.0, |c| *c);
                if series[0] <= 0.0 && trend < 0.0 {
                    first = (0.0, event);
                    return;
                }
                series[0] = series[0].max(0.0);
                let t = if first.0 < f64::INFINITY {
                    first_root(&series, self.order, first.0)
                } else {
                    // Nothing turns: gaps are parabolas, speeds linear, forces constant.
                    Some(parabola_touchdown(series[0], series[1], -2.0 * series[2]))
                };
                if let Some(t) = t
                    && t < first.0
                {
                    first = (t, event);
                }
            };
            let place = &state.points[i].place;
            // Off one piece of a vertex and sliding up the other: it leaves once the distance exceeds its rounding error.
            let closed = |j: usize| self.tracks[j].mode != Mode::Separate;
            let slides = track.mode == Mode::Separate && state.second(i).is_some_and(closed);
            let slack = if slides { TOUCH * state.points[i].arm().norm() } else { 0.0 };
            for (side, distance) in place.sides.into_iter().enumerate() {
                if distance < f64::INFINITY {
                    let mut series = self.sides(i, state)[side];
                    series[0] += slack;
                    falls(&series, StepEnd::Leave(i, side));
                }
            }
            match track.mode {
                Mode::Separate if track.pinned || track.h[0] == f64::INFINITY => {}
                Mode::Separate if follows.get(i) == Some(&true) => {}
                Mode::Separate if state.points[i].depth > 0.0 => {
                    falls(&track.h.map(|c| -c), StepEnd::Surface(i));
                }
                Mode::Separate => falls(&track.h, StepEnd::Landing(i)),
                Mode::Fixed if track.partner.is_some() => {
                    for (series, event) in self.vertex_edges(state, i) {
                        falls(&series, event);
                    }
                }
                Mode::Fixed => {
                    falls(&track.normal, StepEnd::LiftOff(i));
                    falls(&edge(1.0), StepEnd::Slip(i, Mode::Right));
                    falls(&edge(-1.0), StepEnd::Slip(i, Mode::Left));
                }
                mode => {
                    falls(&track.normal, StepEnd::LiftOff(i));
                    if track.friction > 0.0 {
                        let speed = track.slip.map(|speed| mode.direction() * speed);
                        falls(&speed, StepEnd::Stop(i));
                    }
                }
            }
        }
        (first.0 * self.unit, first.1)
    }

    /// Acceleration of the gap of a contact after `t` (s), in m/s².
    pub(crate) fn lift(&self, i: usize, t: f64) -> f64 {
        let (t, u) = (t / self.unit, &self.tracks[i].u);
        let slope = (1..self.order).rev().fold(0.0, |sum, k| sum * t + k as f64 * u[k]);
        slope / (self.unit * self.unit)
    }

    /// Time up to which the series are accurate to the last digit, in s.
    pub(crate) fn reach(&self) -> f64 {
        self.reach * self.unit
    }

    /// q̈ at the start, in m/s² and rad/s².
    pub(crate) fn acceleration(&self) -> [f64; 3] {
        let square = self.unit * self.unit;
        [self.v[0][1], self.v[1][1], self.omega[1]].map(|a| a / square)
    }

    /// The state after `t` (s), which is within reach.
    pub(crate) fn at(&self, state: &BodyState, t: f64) -> BodyState {
        let t = t / self.unit;
        let order = self.order;
        let value = |series: &Series| series[..order].iter().rev().fold(0.0, |sum, c| sum * t + c);
        let rate = |series: &Series| value(series) / self.unit;
        // Without its first term, so that a small change keeps all its digits.
        let change =
            |series: &Series| series[1..order].iter().rev().fold(0.0, |sum, c| sum * t + c) * t;
        let mut after = state.clone();
        after.spin = Spin { theta: value(&self.theta), omega: rate(&self.omega) };
        after.center.v = Vector2::new(rate(&self.v[0]), rate(&self.v[1]));
        after.advance_fall(t * self.unit);
        // e − (1, 0), without its first term either.
        let turned = self.rotation[1..order]
            .iter()
            .rev()
            .fold([0.0; 2], |sum, e| [sum[0] * t + e[0], sum[1] * t + e[1]])
            .map(|sum| sum * t);
        for (i, (p, track)) in after.points.iter_mut().zip(&self.tracks).enumerate() {
            let [b, c] = track.arm;
            (p.b, p.c) = (b + dot([b, -c], turned), c + dot([c, b], turned));
            if let Some(turning) = self.turning(i) {
                let [nx, ny] = turning.normal.each_ref().map(&value);
                (p.normal, p.tangent) = (Vector2::new(nx, ny), Vector2::new(ny, -nx));
                (p.b, p.c) = (value(&turning.b), value(&turning.c));
            }
            if track.pinned {
                (p.h, p.u) = (0.0, 0.0);
            } else if p.depth > 0.0 {
                (p.depth, p.u) = ((-value(&track.h)).max(f64::MIN_POSITIVE), rate(&track.u));
            } else if track.stuck && p.surface_speed != 0.0 {
                let way = p.surface_speed * t * self.unit;
                p.held = p.held.map(|[along, height]| [along + way, height]);
            } else if track.mode == Mode::Separate {
                let terms = |series: &Series| {
                    series[..order].iter().rev().fold(0.0, |sum, c| sum * t + c.abs())
                };
                let (gap, speed) = (terms(&track.h), terms(&track.u) / self.unit);
                p.rounding = p.rounding.after(t * self.unit, p.h, gap, speed);
                (p.h, p.u) = (value(&track.h).max(0.0), rate(&track.u));
            }
        }
        for (i, p) in after.points.iter_mut().enumerate() {
            if p.place.sides != [f64::INFINITY; 2] {
                p.place.sides = self.sides(i, state).map(|side| value(&side).max(0.0));
            }
        }
        let mut moved = Vector2::new(change(&self.r[0]), change(&self.r[1]));
        let modes: ContactLetters<Mode> = self.tracks.iter().map(|track| track.mode).collect();
        let projected = after.project(&modes);
        // Held points stay where they are, n·r + c and t·r + b: a computed displacement is rounding error, corrected along the
        // shortest way.
        let angle = change(&self.theta);
        let lever = |contact: usize, tangential: bool| {
            let (p, [b, c]) = (&after.points[contact], self.tracks[contact].arm);
            if self.turning(contact).is_some() {
                // (n₀ − n)·a or (t₀ − t)·a with the arm a at the start.
                let [less, sin] = turned;
                return if tangential { -less * b - sin * c } else { sin * b - less * c };
            }
            match tangential {
                false => dot([c, b], turned),
                true if p.radius > 0.0 => dot([b, -c], turned) + p.radius * angle,
                true => dot([b, -c], turned),
            }
        };
        let in_vertex = (0..modes.len()).any(|i| after.twin(i).is_some());
        let rows = if in_vertex { after.independent(&modes) } else { projected };
        let mut back = Vector3::<f64>::zeros();
        for _ in 0..AGREES {
            for row in &rows {
                let Unknown { contact, tangential } = row.unknown;
                let p = &after.points[contact];
                let axis = if tangential { p.tangent } else { p.normal };
                // A fixed contact moves with its ground.
                let way = if tangential { p.surface_speed * t * self.unit } else { 0.0 };
                let mut off = match p.corner {
                    Some(_) => state.points[contact].off_corner(moved, turned, angle)
                        [usize::from(!tangential)],
                    None => axis.dot(&moved) + lever(contact, tangential) - way,
                };
                if let Some(place) = p.held {
                    // Rounding errors add up over steps: a larger drift is corrected by the position itself.
                    let r = state.center.r + moved;
                    let (at, mut arm) = if tangential { (0, p.b) } else { (1, p.c) };
                    let mut size = r.norm() + libm::hypot(p.b, p.c);
                    if tangential && p.radius > 0.0 {
                        let rolled = p.radius * (after.spin.theta);
                        (arm, size) = (arm + rolled, size + rolled.abs());
                    }
                    let side = self.turning(contact).and_then(|turning| turning.side);
                    let drift = match (p.corner, side) {
                        (Some(corner), _) => p.drift_about(corner, r, after.spin.theta, place)[at],
                        (_, Some(side)) => side.drift(p, r, place[0])[at],
                        _ => axis.dot(&r) + arm - place[at],
                    };
                    let light =
                        state.gravity * drift.abs() <= DRIFT_ENERGY * after.kinetic(after.center.v);
                    if drift.abs() > DRIFT * size && light {
                        off = drift;
                    }
                }
                off += row.whole.dot(&back);
                back -= row.direction * (off / row.whole.dot(&row.direction));
            }
            moved += back.xy();
            // Beside a load that is 1e16 times all that moves, the correction has rounding errors itself.
            if back.xy().norm_squared() <= state.rho2 {
                break;
            }
            back = Vector3::new(0.0, 0.0, back.z);
        }
        let apart = |[i, j]: [usize; 2]| after.points[i].b - after.points[j].b;
        let about = |k: usize| {
            let off = |_| state.points[k].off_corner(moved, turned, angle)[1];
            after.points[k].corner.map(off)
        };
        let off = |k: usize| {
            let straight = || after.points[k].normal.dot(&moved) + lever(k, false);
            about(k).unwrap_or_else(straight)
        };
        let turn = match after.parallel(&rows) {
            Some([i, j]) if about(i).or(about(j)).is_some() => (off(j) - off(i)) / apart([i, j]),
            Some([i, j]) => {
                after.turned_by([i, j], moved) - (lever(i, false) - lever(j, false)) / apart([i, j])
            }
            None => back.z / state.rho2.sqrt(),
        };
        after.spin.theta += turn;
        for p in &mut after.points {
            (p.b, p.c) = (p.b - p.c * turn, p.c + p.b * turn);
        }
        after.center.r += moved;
        after.place_sides();
        after.place_about();
        after
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ContactState, Rounding};
    use super::*;
    use crate::body::terrain::Place;
    use crate::collisions::log::Center;

    fn tall(friction: f64, theta: f64) -> BodyState {
        let (sin, cos) = theta.sin_cos();
        let point = |i: usize, x: f64| ContactState {
            normal: Vector2::new(0.0, 1.0),
            tangent: Vector2::new(1.0, 0.0),
            friction,
            surface_speed: 0.0,
            restitution: [0.0; 2],
            b: x * cos + 0.75 * sin,
            c: x * sin - 0.75 * cos,
            radius: 0.0,
            corner: None,
            held: None,
            place: Place::anywhere(i),
            h: 0.0,
            depth: 0.0,
            u: 0.0,
            rounding: Rounding::default(),
        };
        let mut points = crate::body::contact::PerContact::from([point(0, -0.5), point(1, 0.5)]);
        points[0].h = points[0].c - points[1].c;
        BodyState {
            points,
            sides: Vec::new(),
            center: Center::default(),
            spin: Spin { theta, omega: 0.0 },
            rho2: 0.16,
            fall: Vector2::new(0.0, -9.81),
            fall_rate: Vector2::zeros(),
            gravity: 9.81,
        }
    }

    /// Motion on one contact until the other lands. Without friction, ½ω²(b² + ρ²) + g y is constant, with y = −c the height of
    /// the centre of mass; about a fixed contact, ½ω²(b² + c² + ρ²) + g y is.
    #[test]
    fn energy_of_a_held_contact_is_kept() {
        for (mode, friction) in [(Mode::Right, 0.0), (Mode::Fixed, 1.0)] {
            let mut state = tall(friction, -0.2);
            let energy = |s: &BodyState| {
                let (p, w) = (&s.points[1], s.spin.omega);
                let along = if mode == Mode::Fixed { p.c * p.c } else { 0.0 };
                0.5 * w * w * (p.b * p.b + along + 0.16) - 9.81 * p.c
            };
            let (before, mut time) = (energy(&state), 0.0);
            loop {
                let step = Step::new(&state, &[Mode::Separate, mode], ORDER).unwrap();
                let (t, end) = step.first_event(&state, &[]);
                state = step.at(&state, t);
                time += t;
                assert!((energy(&state) - before).abs() < 4e-15 * before.abs());
                if end == StepEnd::Landing(0) {
                    break;
                }
                assert_eq!(end, StepEnd::Reach);
            }
            assert!(state.spin.theta.abs() < 1e-15, "{}", state.spin.theta);
            assert!(time > 0.1 && time < 1.0, "{time}");
        }
    }
}
