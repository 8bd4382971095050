//! Smooth motion while contacts are held in a mode, up to the event that ends it.
//!
//! A closed contact keeps a_n = 0 by a normal force λ ≥ 0. A fixed one also keeps a_t = 0 by a tangential force τ; where it
//! slides, τ = −σμλ with σ = sign v_t (all per unit mass):
//!
//! ```text
//! n_i·v̇ + b_i ω̇ = c_i ω²,   t_i·v̇ − (c_i − R_i) ω̇ = b_i ω²
//! v̇ = (0, −g) + Σ_j (n_j λ_j + t_j τ_j),   ρ² ω̇ = Σ_j (b_j λ_j − (c_j − R_j) τ_j)
//! ḃ_i = −c_i ω,   ċ_i = b_i ω
//! ```
//!
//! b and c are the arms of the centre of a round contact, R is its radius, and c − R is the arm of the point with which it touches; for a
//! point R = 0. A fixed round contact rolls: the touching point is at rest, the centre moves with −R ω along the ground.
//!
//! Every right-hand side is a product or a quotient, so the Taylor coefficients of the motion follow from each other exactly,
//! to any order. A step is a polynomial, and its events are roots of polynomials.

mod around;
pub(crate) mod edges;
mod endless;
mod excitation;
mod facing;
pub(crate) mod flight;
mod forces;
pub(crate) mod jam;
pub(crate) mod frozen;
pub(crate) mod next_order;
mod pair;
pub(crate) mod phase;
pub(crate) mod rows;
pub(crate) mod rows_phase;
pub(crate) mod side;
mod step;
mod turning;

use nalgebra::{Vector2, Vector3};

use crate::body::contact::{ContactLetters, ContactValues, PerContact};
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::body::terrain::{Piece, Place};
use crate::collisions::log::{Center, Spin};
use crate::impact::friction::{Material, Matrix};
use crate::math::clock::Clock;
use crate::math::mass_vector::Coordinates;
use crate::math::turn::Turn;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::Mode;
use crate::sustained::side::SideContact;
pub(crate) use crate::sustained::step::{ORDERS, Step, StepEnd};
use crate::tolerance::STILL;

/// Sliding speed that counts as zero at this time in m/s, in a motion with this largest speed (m/s) and gravity (m/s²).
pub(crate) fn still_speed(fastest: f64, gravity: f64, clock: Clock) -> f64 {
    STILL * fastest.max(gravity * clock.hi)
}

/// Whether a body at rest on two contacts stays at rest: they are on level ground without friction, and the centre of mass is between them,
/// λ_i = g b_j/(b_j − b_i). Both forces press, and no other motion is consistent. To test all words would cost a fifth of a short run.
/// `contacts`: friction, normal and b of each.
pub(crate) fn lies_level(
    fall: Vector2<f64>,
    gravity: f64,
    contacts: [(f64, Vector2<f64>, f64); 2],
    v: &Vector2<f64>,
    omega: f64,
) -> bool {
    let level = |(friction, normal, _)| friction == 0.0 && normal == -fall / gravity;
    let lies = gravity > 0.0 && fall.perp(v) == 0.0 && omega == 0.0;
    lies && contacts.into_iter().all(level) && contacts[0].2 * contacts[1].2 < 0.0
}

/// Bounds of the rounding errors of a gap, since it was last exactly zero (in m), and of its rate (in m/s). In an accumulation
/// of impacts they shrink with the gaps and the rates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rounding {
    pub(crate) gap: f64,
    pub(crate) rate: f64,
}

/// A contact at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactState {
    pub(crate) normal: Vector2<f64>,
    pub(crate) tangent: Vector2<f64>,
    pub(crate) friction: f64,
    /// Speed of the ground along the tangent, in m/s.
    pub(crate) surface_speed: f64,
    /// Coefficients of restitution along the normal, and of tangential restitution.
    pub(crate) restitution: [f64; 2],
    pub(crate) b: f64,
    /// Of the centre, if it is round.
    pub(crate) c: f64,
    /// R; 0 for a point.
    pub(crate) radius: f64,
    /// The corner of the ground that the disc is over, relative to the nominal centre of mass, in m; `None` over a straight piece.
    pub(crate) corner: Option<Vector2<f64>>,
    /// (t·r + b + R θ, n·r + c) when it began to be held, if it is held: its position up to a constant.
    pub(crate) held: Option<[f64; 2]>,
    pub(crate) place: Place,
    /// Gap; ∞ where there is no terrain to meet.
    pub(crate) h: f64,
    /// Depth below the piece of terrain over the point, in m, if the point came under it from the side. The gap is ∞ until the
    /// point has risen out of this piece. Otherwise zero.
    pub(crate) depth: f64,
    pub(crate) u: f64,
    pub(crate) rounding: Rounding,
}

impl ContactState {
    /// Gives the contact, at this place, the axes and the material of this piece of its ground. Gap, arm and rate are as before.
    pub(crate) fn turns_to(&mut self, posture: &Posture, piece: &Piece, at: &Vector2<f64>) {
        [self.tangent, self.normal] = piece.axes(at);
        self.corner = piece.corner().map(|corner| corner - posture.center());
        [self.friction, self.restitution[0], self.surface_speed] =
            posture.material_on(self.place.contact, piece);
    }

    pub(crate) fn material(&self) -> Material {
        let [restitution, tangential_restitution] = self.restitution;
        Material { friction: self.friction, restitution, tangential_restitution }
    }

    /// Arm from the centre of mass, of the centre of a round contact, world axes, in m.
    pub(crate) fn arm(&self) -> Vector2<f64> {
        self.tangent * self.b + self.normal * self.c
    }

    /// Arm of the touching point along the normal: c − R.
    pub(crate) fn touching_c(&self) -> f64 {
        self.c - self.radius
    }

    /// Arm of the touching point, where the forces act, world axes, in m.
    pub(crate) fn touching_arm(&self) -> Vector2<f64> {
        self.tangent * self.b + self.normal * self.touching_c()
    }

    /// b and c after a turn.
    pub(crate) fn turned(&self, turn: &Turn) -> (f64, f64) {
        turn.turned([self.b, self.c]).into()
    }

    /// Change of the gap by a turn about the centre of mass, in m.
    pub(crate) fn lift(&self, turn: &Turn) -> f64 {
        self.b * turn.sin - self.c * turn.one_minus_cos
    }
}

/// A body at an instant.
#[derive(Debug, PartialEq)]
pub(crate) struct BodyState {
    pub(crate) points: PerContact<ContactState>,
    /// The corners of the ground on sides of the body. Each is one of the points, after those of the body.
    pub(crate) sides: Vec<SideContact>,
    pub(crate) center: Center,
    pub(crate) spin: Spin,
    /// ρ²
    pub(crate) rho2: f64,
    /// Acceleration of free fall in the frame of the ground, in m/s², and its size.
    pub(crate) fall: Vector2<f64>,
    pub(crate) gravity: f64,
    /// Rate of the acceleration of free fall, in m/s³: zero, unless the acceleration of the ground is linear in time.
    pub(crate) fall_rate: Vector2<f64>,
}

/// Written by hand: the derived `clone` copies the points one by one.
impl Clone for BodyState {
    fn clone(&self) -> Self {
        let Self { center, spin, rho2, fall, gravity, fall_rate, .. } = *self;
        let points = PerContact::from_slice(&self.points);
        let sides = self.sides.clone();
        Self { points, sides, center, spin, rho2, fall, gravity, fall_rate }
    }
}

impl BodyState {
    /// Tangential speed v_t = t·v − (c − R) ω − σ of a contact point over its ground, whose surface moves with σ.
    pub(crate) fn slip(&self, i: usize) -> f64 {
        let p = &self.points[i];
        p.tangent.dot(&self.center.v) - p.touching_c() * self.spin.omega - p.surface_speed
    }

    /// Speed of a contact along its ground, in m/s: of the centre, if it is round.
    pub(crate) fn along(&self, i: usize) -> f64 {
        self.along_of(&self.points[i])
    }

    /// √(2T) for unit mass, in m/s, in the frame of the ground under these points; ∞ if their grounds do not move alike.
    pub(crate) fn total_speed(&self, points: &[usize]) -> f64 {
        let ground = self.velocity_of_ground(|_, i| points.contains(&i));
        ground.map_or(f64::INFINITY, |ground| (2.0 * self.kinetic(self.center.v - ground)).sqrt())
    }

    /// Kinetic energy per unit mass with this velocity of the centre of mass.
    fn kinetic(&self, v: Vector2<f64>) -> f64 {
        0.5 * (v.norm_squared() + self.rho2 * self.spin.omega * self.spin.omega)
    }

    /// The other point of a contact in a vertex of its terrain, if they are one point of the body: a disc touches the two pieces with two.
    #[inline]
    pub(crate) fn twin(&self, i: usize) -> Option<usize> {
        if self.points[i].radius > 0.0 { None } else { self.second(i) }
    }

    /// The other point of a contact in a vertex of its terrain, or of a corner of the ground in a concave corner of the body.
    #[inline]
    pub(crate) fn second(&self, i: usize) -> Option<usize> {
        if !self.sides.is_empty() && self.side_contact(i).is_some() {
            return self.second_side(i);
        }
        if self.points[i].place.sides == [f64::INFINITY; 2] {
            return None; // a piece without ends has no vertex
        }
        let contact = |j: usize| self.points[j].place.contact;
        (0..self.points.len()).find(|&j| j != i && contact(j) == contact(i))
    }

    /// Of the two points of a contact in a vertex, whether point `i` is the one on the left piece, which the body leaves to the left.
    pub(crate) fn is_left_of(&self, i: usize, j: usize) -> bool {
        let (one, other) = (&self.points[i], &self.points[j]);
        if self.side_contact(i).is_some() {
            return one.tangent.perp(&other.tangent) > 0.0;
        }
        one.place.piece < other.place.piece
    }

    /// Returns true if point `i` is fixed by friction or in a vertex.
    fn sticks(&self, i: usize, modes: &[Mode]) -> bool {
        modes[i] == Mode::Fixed && (self.points[i].friction > 0.0 || self.twin(i).is_some())
    }

    /// The other of two fixed points that hold a contact in a vertex. The contact is held while the sum of their forces lies in
    /// the hull of their friction cones. The share of each force has no consequence, so the rows of the first point represent
    /// both.
    fn partner(&self, i: usize, modes: &[Mode]) -> Option<usize> {
        let fixed = |j: usize| modes[j] == Mode::Fixed;
        fixed(i).then(|| self.twin(i)).flatten().filter(|&j| fixed(j))
    }

    /// ω² in the accelerations of the contacts, in 1/s².
    fn square_of_turn(&self) -> f64 {
        self.spin.omega * self.spin.omega
    }
}

impl BodyState {
    /// Moves the centre of mass by `way` (m) and turns the points with the body, over the same pieces of ground.
    pub(crate) fn displace(&mut self, way: &Vector2<f64>, turn: &Turn) {
        self.center.r += way;
        for p in &mut self.points {
            let arm = p.arm();
            let side = Vector2::new(-arm.y, arm.x);
            let turned = side * turn.sin - arm * turn.one_minus_cos;
            p.h += p.normal.dot(way) + p.lift(turn);
            for (k, side) in p.place.sides.iter_mut().enumerate() {
                let axis = p.place.across[k] * if k == 0 { 1.0 } else { -1.0 };
                if *side < f64::INFINITY {
                    *side = (*side + axis.dot(&(way + turned))).max(0.0);
                }
            }
            (p.b, p.c) = p.turned(turn);
        }
    }
}

/// q and q̇ of this centre of mass and this rotation.
pub(crate) fn state_at((Center { r, v }, spin): (Center, Spin)) -> State {
    State::new([r.x, r.y, spin.theta], [v.x, v.y, spin.omega]).unsigned_zero()
}

impl BodyState {
    pub(crate) fn state(&self) -> State {
        state_at(self.place())
    }

    /// Gaps (m) and rates (m/s) of the contacts.
    pub(crate) fn gaps_and_rates<T: FromIterator<f64> + Default + Extend<f64>>(
        &self,
        posture: &Posture,
    ) -> (T, T) {
        let points: ContactValues<(f64, f64)> =
            self.points.iter().map(|p| self.gap_and_rate(p, posture)).collect();
        posture
            .per_contact(|k| points[k])
            .map(|(h, u)| (h.unsigned_zero(), u.unsigned_zero()))
            .unzip()
    }

    /// Gap and rate of a point. With walls, the piece between whose separating lines the point moves may differ from the nearest piece; the
    /// gap is the gap to the nearest piece. A point with an infinite gap is beyond an end of its ground, or has come behind pieces from there:
    /// it meets the nearest piece only at its front.
    fn gap_and_rate(&self, p: &ContactState, posture: &Posture) -> (f64, f64) {
        let i = p.place.contact;
        if p.h > 0.0 && posture.ground(i).is_some_and(|ground| ground.has_walls) {
            let State { q, qdot } = self.state();
            let under = posture.under(i, &q);
            if under.place.piece != p.place.piece {
                let (k, turn) = (under.geometry, Turn::by(q.z));
                let (h, u) = (k.gap(&q, &turn), k.gap_rate(&qdot, &turn));
                let is_behind = p.h == f64::INFINITY && h < 0.0;
                return (if under.exists && !is_behind { h } else { f64::INFINITY }, u);
            }
        }
        (p.h, p.u)
    }

    /// One letter per contact; those of corners of the ground on sides come last, up to the last one that is near. In a vertex a contact has a second point, listed after all first ones: the letter is that of the
    /// piece it is on, F if it is on both.
    pub(crate) fn letters(&self, word: &[Mode], posture: &Posture) -> String {
        let mut modes: ContactLetters<Mode> = word.into();
        let (count, mut sides) = (posture.contacts().len(), ContactLetters::<char>::new());
        for (p, mode) in self.points.iter().zip(word).skip(posture.distinct().count()) {
            if let Some(number) = p.place.contact.checked_sub(count) {
                let known = sides.len().max(number + 1);
                sides.resize(known, Mode::Separate.letter());
                sides[number] = mode.letter();
                continue;
            }
            let first = &mut modes[posture.point_of(p.place.contact)];
            if *first == Mode::Separate {
                *first = *mode;
            } else if *mode != Mode::Separate {
                *first = Mode::Fixed;
            }
        }
        posture.per_contact(|k| modes[k].letter()).chain(sides).collect()
    }
}

impl BodyState {
    /// Row of the sliding speed (`tangential`) or of the gap rate of a contact, in the metric of the mass.
    pub(crate) fn row(&self, i: usize, tangential: bool) -> Coordinates {
        let p = &self.points[i];
        let (along, turn) = if tangential { (p.tangent, -p.touching_c()) } else { (p.normal, p.b) };
        Coordinates::of_three([along.x, along.y, turn / self.rho2.sqrt()])
    }

    /// Impact matrix of a contact, per unit mass.
    pub(crate) fn impact_matrix(&self, i: usize) -> Matrix {
        self.matrix_at(i, self.points[i].touching_c())
    }

    /// The same at the point on the normal of contact `i` with this arm `c`.
    pub(crate) fn matrix_at(&self, i: usize, c: f64) -> Matrix {
        let (p, rho2) = (&self.points[i], self.rho2);
        Matrix { nn: 1.0 + p.b * p.b / rho2, nt: -p.b * c / rho2, tt: 1.0 + c * c / rho2 }
    }

    /// Applies an impulse (tangential, normal) per unit mass at contact `i`; returns the change of velocity.
    pub(crate) fn apply_impulse(&mut self, i: usize, impulse: [f64; 2]) -> Vector3<f64> {
        self.push(i, impulse, self.points[i].touching_c())
    }

    /// The same at the point on the normal of contact `i` with this arm `c`.
    pub(crate) fn push(&mut self, i: usize, [p_t, p_n]: [f64; 2], c: f64) -> Vector3<f64> {
        let hit = self.points[i];
        let force = hit.tangent * p_t + hit.normal * p_n;
        let turn = (hit.b * p_n - c * p_t) / self.rho2;
        self.center.v += force;
        self.spin.omega += turn;
        for p in &mut self.points {
            let (push, twist) = (p.normal.dot(&force), p.b * turn);
            p.u += push + twist;
            p.rounding.rate += f64::EPSILON * (push.abs() + twist.abs());
        }
        Vector3::new(force.x, force.y, turn)
    }
}
