//! The Taylor series of the motion where a contact has a normal that turns: a corner of the ground on a side, or on a disc.
//!
//! Every row and every force is a series. With e the rows and d the directions of the forces, and B and A their levers, the coefficients k are
//!
//! ```text
//! Σ_j e_j·a_{k−j} + B_j α_{k−j} = r_k,    a = γ + Σ_l d_l f_l,    ρ² α = Σ_l A_l f_l
//! normal rows:      r = c ω² (point of the body),    c ω² + 2 ω v_t (corner on a side),    c ω² + w Ω (corner on a disc)
//! tangential rows:  r = b ω²
//! ```
//!
//! Ω is the rate at which the axes turn: 0, ω, or −w/D; w is the speed of the centre of the disc about the corner.
//!
//! Only f_k is unknown; it has the same matrix at every order.

use nalgebra::{Matrix3, Vector2, Vector3};
use smallvec::SmallVec;

use crate::math::roots::ORDER;
use crate::math::series::{Series, ZERO, constant, determinant, product, radius, times};
use crate::modes::Mode;
use crate::sustained::rows::{Row, Unknown};
use crate::sustained::step::{Factors, Step, Track, TurningPoint, with_sign};
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::SINGULAR_FRICTION_MATRIX;

/// Longest step, in units of time: coefficients that are zero but for rounding errors do not matter within it. Range: 1 to 100.
const LONGEST: f64 = 8.0;

/// A vector as a series.
type Vectors = [Series; 2];

/// How the axes of a point turn.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Turns {
    Not,
    /// With the body: a corner of the ground on a side.
    WithBody,
    /// With the centre of a disc about a corner of the ground.
    About,
}

/// Axes and arm of a point as series.
struct Frame {
    turns: Turns,
    normal: Vectors,
    tangent: Vectors,
    b: Series,
    c: Series,
    radius: f64,
    /// w and Ω, of a disc about a corner.
    speed: Series,
    rate: Series,
}

impl Frame {
    fn new(p: &ContactState, is_side: bool) -> Self {
        let vectors = |v: Vector2<f64>| [constant(v.x), constant(v.y)];
        let (normal, tangent) = (vectors(p.normal), vectors(p.tangent));
        let turns = match (is_side, p.corner) {
            (true, _) => Turns::WithBody,
            (_, Some(_)) => Turns::About,
            _ => Turns::Not,
        };
        let [b, c] = [p.b, p.c].map(constant);
        Self { turns, normal, tangent, b, c, radius: p.radius, speed: ZERO, rate: ZERO }
    }

    /// −(c − R), the lever of the tangential row.
    fn down(&self) -> Series {
        let mut down = self.c.map(|c| -c);
        down[0] += self.radius;
        down
    }

    /// Coefficient k of w and Ω of a disc about a corner, with Ω D = −w. `v`, `omega`: those of the body.
    fn turn_about(&mut self, track: &Track, v: &Vectors, omega: &Series, k: usize) {
        if self.turns != Turns::About {
            return;
        }
        // Of a closed contact D = R, and v_t = w + R ω, which is zero where it rolls.
        self.speed[k] = match (track.mode, track.stuck) {
            (Mode::Separate, _) => dot(&self.tangent, v, k) - product(&self.c, omega, k),
            (_, true) => -self.radius * omega[k],
            (_, false) => track.slip[k] - self.radius * omega[k],
        };
        let (mut known, mut distance) = (self.speed[k], self.radius);
        if track.mode == Mode::Separate {
            known += (1..=k).map(|j| track.h[j] * self.rate[k - j]).sum::<f64>();
            distance += track.h[0];
        }
        self.rate[k] = -known / distance;
    }
}

/// Coefficient k of the scalar product of two vectors.
fn dot(one: &Vectors, other: &Vectors, k: usize) -> f64 {
    product(&one[0], &other[0], k) + product(&one[1], &other[1], k)
}

/// Coefficient k of a product, without its last term, the first coefficient of `a` times coefficient k of `b`.
fn rest(a: &Series, b: &Series, k: usize) -> f64 {
    (1..=k).map(|j| a[j] * b[k - j]).sum()
}

/// The direction of a force and its lever: normal forces with their friction, or tangential ones.
struct Force {
    slope: f64,
    unknown: Unknown,
}

impl Force {
    fn of(unknown: Unknown, points: &[ContactState], modes: &[Mode]) -> Self {
        let way = modes[unknown.contact].direction();
        let slope = if unknown.tangential { 0.0 } else { -way * points[unknown.contact].friction };
        Self { slope, unknown }
    }

    fn direction(&self, frame: &Frame) -> Vectors {
        if self.unknown.tangential {
            return frame.tangent;
        }
        [0, 1].map(|axis: usize| {
            std::array::from_fn(|k| frame.normal[axis][k] + self.slope * frame.tangent[axis][k])
        })
    }

    fn lever(&self, frame: &Frame) -> Series {
        let down = frame.down();
        if self.unknown.tangential {
            return down;
        }
        std::array::from_fn(|k| frame.b[k] + self.slope * down[k])
    }
}

fn axis(unknown: Unknown, frame: &Frame) -> &Vectors {
    if unknown.tangential { &frame.tangent } else { &frame.normal }
}

fn lever(unknown: Unknown, frame: &Frame) -> Series {
    if unknown.tangential { frame.down() } else { frame.b }
}

/// The motion of the body: its acceleration, the angular one, ω and ω².
struct BodySeries<'a> {
    a: &'a Vectors,
    alpha: &'a Series,
    omega: &'a Series,
    square: &'a Series,
}

impl Frame {
    /// What a row lacks at order k, but for the terms of the coefficients k of the accelerations.
    fn lacks(&self, u: Unknown, track: &Track, body: &BodySeries<'_>, k: usize) -> f64 {
        let axis = axis(u, self);
        let curved = match u.tangential {
            true => product(&self.b, body.square, k),
            false => product(&self.c, body.square, k),
        };
        let turning = match self.turns {
            _ if u.tangential => 0.0,
            Turns::Not => 0.0,
            Turns::WithBody => 2.0 * product(body.omega, &track.slip, k),
            Turns::About => product(&self.speed, &self.rate, k),
        };
        curved + turning
            - rest(&axis[0], &body.a[0], k)
            - rest(&axis[1], &body.a[1], k)
            - rest(&lever(u, self), body.alpha, k)
    }

    /// The first coefficients of a row.
    fn first(&self, u: Unknown) -> (Vector2<f64>, f64) {
        let axis = axis(u, self);
        (Vector2::new(axis[0][0], axis[1][0]), lever(u, self)[0])
    }

    /// Coefficients k + 1 of the motion of a point and of its axes; `e`: of (cos Δθ, sin Δθ). Rates and accelerations use the coefficients up
    /// to k.
    fn advance(
        &mut self,
        track: &mut Track,
        p: &ContactState,
        body: &BodySeries<'_>,
        [cos, sin]: [f64; 2],
        k: usize,
    ) {
        let next = 1.0 / (k + 1) as f64;
        let lift = dot(&self.normal, body.a, k) + product(&self.b, body.alpha, k)
            - product(&self.c, body.square, k);
        let slide = dot(&self.tangent, body.a, k) + product(&self.down(), body.alpha, k)
            - product(&self.b, body.square, k);
        let turning = match self.turns {
            Turns::Not => [0.0; 2],
            Turns::WithBody => {
                [-2.0 * product(body.omega, &track.slip, k), 2.0 * product(body.omega, &track.u, k)]
            }
            Turns::About => [-product(&self.speed, &self.rate, k), 0.0],
        };
        let is_side = self.turns == Turns::WithBody;
        let slips = !track.stuck && (is_side || track.mode != Mode::Separate);
        let (rate, slip) = (track.u[k], if slips { track.slip[k] } else { 0.0 });
        if track.mode == Mode::Separate && !track.pinned {
            track.h[k + 1] = rate * next;
            track.u[k + 1] = (lift + turning[0]) * next;
        }
        if slips {
            track.slip[k + 1] = (slide + turning[1]) * next;
        }
        match self.turns {
            Turns::Not => {
                self.b[k + 1] = p.b * cos - p.c * sin;
                self.c[k + 1] = p.c * cos + p.b * sin;
            }
            Turns::WithBody => {
                let closed = track.mode != Mode::Separate;
                self.b[k + 1] = -slip * next;
                self.c[k + 1] = if closed { 0.0 } else { -rate * next };
                for axis in 0..2 {
                    self.normal[axis][k + 1] = cos * p.normal[axis] - sin * p.tangent[axis];
                    self.tangent[axis][k + 1] = cos * p.tangent[axis] + sin * p.normal[axis];
                }
            }
            Turns::About => {
                // ṅ = −Ω t, ṫ = Ω n, and the arm turns with ω − Ω in these axes.
                let turn = |of: &Series, k: usize| {
                    (0..=k).map(|j| of[j] * (body.omega[k - j] - self.rate[k - j])).sum::<f64>()
                };
                let [b, c] = [-turn(&self.c, k) * next, turn(&self.b, k) * next];
                for axis in 0..2 {
                    let [n, t] = [
                        -product(&self.rate, &self.tangent[axis], k),
                        product(&self.rate, &self.normal[axis], k),
                    ];
                    (self.normal[axis][k + 1], self.tangent[axis][k + 1]) = (n * next, t * next);
                }
                (self.b[k + 1], self.c[k + 1]) = (b, c);
            }
        }
    }
}

/// The matrix of the unknown forces; `None` if it is singular beside the lengths of its columns before cancellation.
fn matrix_of(
    forces: &[Force],
    frames: &[Frame],
    points: &[ContactState],
    rho2: f64,
) -> Option<Matrix3<f64>> {
    let n = forces.len();
    let entry = |row: &Force, force: &Force| {
        let (frame, acting) = (&frames[row.unknown.contact], &frames[force.unknown.contact]);
        dot(axis(row.unknown, frame), &force.direction(acting), 0)
            + lever(row.unknown, frame)[0] * force.lever(acting)[0] / rho2
    };
    let matrix = Matrix3::from_fn(|i, j| match (i < n, j < n) {
        (true, true) => entry(&forces[i], &forces[j]),
        _ => f64::from(u8::from(i == j)),
    });
    let length = |force: &Force| {
        let (p, bent) = (&points[force.unknown.contact], force.slope.abs());
        let reach = match force.unknown.tangential {
            true => p.touching_c().abs(),
            false => p.b.abs() + bent * p.touching_c().abs(),
        };
        let square = |row: &Force| {
            let arm = lever(row.unknown, &frames[row.unknown.contact])[0].abs();
            let term = 1.0 + bent + arm * reach / rho2;
            term * term
        };
        forces.iter().map(square).sum::<f64>().sqrt()
    };
    let size: f64 = forces.iter().map(length).product();
    (matrix.determinant().abs() > SINGULAR_FRICTION_MATRIX * size).then_some(matrix)
}

/// The time, in units, up to which the series hold.
fn reach(tracks: &[Track], frames: &[Frame], omega: &Series, order: usize) -> f64 {
    let ends = |series: &Series| [0, 1, 2, order - 2, order - 1].map(|k| series[k]);
    let mut all: SmallVec<[[f64; 5]; 17]> = SmallVec::new();
    all.push(ends(omega));
    for (frame, track) in frames.iter().zip(tracks) {
        all.extend([ends(&frame.b), ends(&frame.c)]);
        if frame.turns != Turns::Not {
            // The turned axes, with unit size.
            let mut turned = ends(&frame.normal[0]);
            let other = ends(&frame.normal[1]);
            turned.iter_mut().zip(other).for_each(|(one, two)| *one = one.abs() + two.abs());
            all.push(turned);
            all.push(ends(&track.slip));
        }
        if track.mode != Mode::Separate {
            all.extend([ends(&track.normal), ends(&track.tangential)]);
        }
    }
    radius(&all, f64::EPSILON * 0.1, order).min(LONGEST)
}

/// The determinant of the matrix of the forces as a series that begins positive, and its sign at the start; 1 and 0 without sliding friction,
/// where it stays positive.
fn determinant_of(forces: &[Force], frames: &[Frame], rho2: f64, order: usize) -> (Series, f64) {
    if forces.iter().all(|force| force.slope == 0.0) {
        return (constant(1.0), 0.0);
    }
    let mut whole = [[ZERO; 3]; 3];
    for (i, row) in forces.iter().enumerate() {
        let frame = &frames[row.unknown.contact];
        for (j, force) in forces.iter().enumerate() {
            let acting = &frames[force.unknown.contact];
            let turned = times(&lever(row.unknown, frame), &force.lever(acting), order);
            let direction = force.direction(acting);
            for k in 0..order {
                whole[i][j][k] = dot(axis(row.unknown, frame), &direction, k) + turned[k] / rho2;
            }
        }
    }
    with_sign(determinant(&whole, forces.len(), order))
}

impl Step {
    /// As `in_units`, with normals that turn.
    pub(super) fn with_turning_normals(
        independent: &[Row],
        state: &BodyState,
        modes: &[Mode],
        order: usize,
        unit: f64,
        mut tracks: Vec<Track>,
    ) -> Option<Box<Self>> {
        let (points, rho2) = (&state.points, state.rho2);
        let fall = [state.fall * (unit * unit), state.fall_rate * (unit * unit * unit)];
        let mut frames: Vec<Frame> = (0..points.len())
            .map(|i| Frame::new(&points[i], state.side_contact(i).is_some()))
            .collect();
        let mut theta = constant(state.spin.theta);
        let mut omega = constant(state.spin.omega * unit);
        let mut r = [0, 1].map(|axis: usize| constant(state.center.r[axis]));
        let mut v = [0, 1].map(|axis: usize| constant(state.center.v[axis] * unit));
        let mut rotation = [[0.0; 2]; ORDER];
        rotation[0] = [1.0, 0.0];
        let (mut a, mut alpha, mut square) = ([ZERO; 2], ZERO, ZERO);
        let forces: SmallVec<[Force; 3]> =
            independent.iter().map(|row| Force::of(row.unknown, points, modes)).collect();
        let n = forces.len();
        let factors = Factors::of(matrix_of(&forces, &frames, points, rho2)?, n);
        let parallel = state.parallel(independent);
        let mut solved = [ZERO; 3];
        for k in 0..order {
            let next = 1.0 / (k + 1) as f64;
            square[k] = product(&omega, &omega, k);
            for (frame, track) in frames.iter_mut().zip(&tracks) {
                frame.turn_about(track, &v, &omega, k);
            }
            let directions: SmallVec<[(Vectors, Series); 3]> = forces
                .iter()
                .map(|force| {
                    let frame = &frames[force.unknown.contact];
                    (force.direction(frame), force.lever(frame))
                })
                .collect();
            // a_k and α_k without f_k.
            let mut push = fall.get(k).copied().unwrap_or_default();
            let mut turn = 0.0;
            for ((direction, arm), force) in directions.iter().zip(&solved) {
                push.x += rest(&direction[0], force, k);
                push.y += rest(&direction[1], force, k);
                turn += rest(arm, force, k) / rho2;
            }
            let body = BodySeries { a: &a, alpha: &alpha, omega: &omega, square: &square };
            let row = |u: Unknown| {
                let frame = &frames[u.contact];
                (frame.first(u), frame.lacks(u, &tracks[u.contact], &body, k))
            };
            let normals = parallel
                .map(|pair| pair.map(|contact| row(Unknown { contact, tangential: false })));
            let mut right = Vector3::zeros();
            for (m, force) in forces.iter().enumerate() {
                let ((axis, lever), lacking) = row(force.unknown);
                right[m] = lacking - axis.dot(&push) - lever * turn;
            }
            let force = factors.solve(&right)?;
            for (l, (direction, arm)) in directions.iter().enumerate() {
                solved[l][k] = force[l];
                push += Vector2::new(direction[0][0], direction[1][0]) * force[l];
                turn += arm[0] * force[l] / rho2;
                let (unknown, slope) = (forces[l].unknown, forces[l].slope);
                let track = &mut tracks[unknown.contact];
                if unknown.tangential {
                    track.tangential[k] = force[l];
                } else {
                    track.normal[k] = force[l];
                    track.tangential[k] += slope * force[l];
                }
            }
            if k + 1 == order {
                break;
            }
            if let Some([((n1, b1), lack), ((n2, b2), other)]) = normals {
                // The difference of the rows of two contacts on nearly parallel ground gives the rotation with more digits.
                turn = (lack - other - (n1 - n2).dot(&push)) / (b1 - b2);
                push += n1 * (lack - b1 * turn - n1.dot(&push));
            }
            (a[0][k], a[1][k], alpha[k]) = (push.x, push.y, turn);
            theta[k + 1] = omega[k] * next;
            omega[k + 1] = turn * next;
            for axis in 0..2 {
                r[axis][k + 1] = v[axis][k] * next;
                v[axis][k + 1] = a[axis][k] * next;
            }
            let spun = [0, 1]
                .map(|part: usize| (0..=k).map(|j| rotation[j][part] * omega[k - j]).sum::<f64>());
            rotation[k + 1] = [-spun[1] * next, spun[0] * next];
            let body = BodySeries { a: &a, alpha: &alpha, omega: &omega, square: &square };
            for ((track, frame), p) in tracks.iter_mut().zip(&mut frames).zip(points) {
                frame.advance(track, p, &body, rotation[k + 1], k);
            }
        }
        let reach = state.within_changing_load(reach(&tracks, &frames, &omega, order));
        let (determinant, side) = determinant_of(&forces, &frames, rho2, order);
        let turning = frames
            .into_iter()
            .enumerate()
            .filter(|(_, frame)| frame.turns != Turns::Not)
            .map(|(point, frame)| TurningPoint {
                point,
                side: state.side_contact(point).copied(),
                normal: frame.normal,
                b: frame.b,
                c: frame.c,
            })
            .collect();
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
            turning,
        }))
    }

    /// The turning normal of point `i`, if it has one.
    pub(super) fn turning(&self, i: usize) -> Option<&TurningPoint> {
        self.turning.iter().find(|turning| turning.point == i)
    }
}
