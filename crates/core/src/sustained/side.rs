//! A corner of the ground on a side of the body. The point of contact is fixed in the world; its normal turns with the body.
//!
//! ```text
//!   V fixed corner, x + r centre of mass, t unit vector along the side (body on its left), n = t turned by 90°: into the body
//!
//!   a = V − x − r,   b = t·a,   c = n·a,   h = −c − d        d: distance of the side from the centre of mass
//!   ṫ = ω n,   ṅ = −ω t,   ȧ = −ṙ
//!   ḣ = n·ṙ + b ω,   v_t = t·ṙ − c ω,   ḃ = −v_t,   ċ = −ḣ
//!   ḧ = n·r̈ + b ω̇ − c ω² − 2 ω v_t,   v̇_t = t·r̈ − c ω̇ − b ω² + 2 ω ḣ
//! ```
//!
//! So its rows are N = (n, b) and T = (t, −c), as those of a contact point; of the accelerations, only the terms with 2 ω differ.

use nalgebra::Vector2;

use crate::body::outline::Side;
use crate::body::posture::Posture;
use crate::body::terrain::Place;
use crate::flight::parabola_touchdown;
use crate::math::roots::bracketed;
use crate::math::turn::{Turn, turned};
use crate::sustained::{BodyState, ContactState, Rounding};

/// Most steps in the search for a touchdown. A touchdown after so many is found when the corner enters the body.
const MOST_STEPS: usize = 65_536;

/// Rotation of the body in one step of this search, in rad. Only the cost depends on it.
pub(super) const LONGEST_TURN: f64 = 0.125;

/// A corner of the ground and the side of the body that it may touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SideContact {
    /// The number of the contact, from 0; those of the posture come first.
    pub(crate) contact: usize,
    /// The corner, relative to the nominal centre of mass, world axes, in m.
    pub(crate) corner: Vector2<f64>,
    /// The number of the side, from 0.
    pub(crate) side: usize,
    /// t in the nominal posture.
    along: Vector2<f64>,
    /// d, in m.
    distance: f64,
    /// b at the start and at the end of the side, in m.
    ends: [f64; 2],
    /// Whether the corner of the body there is concave. The corner of the ground then lands on the next side, and does not leave this one.
    concave: [bool; 2],
    /// Of friction, restitution and tangential restitution.
    coefficients: [f64; 3],
}

fn turned_left(v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}

impl SideContact {
    /// `corner`: world axes, in m.
    pub(crate) fn new(
        posture: &Posture,
        contact: usize,
        corner: Vector2<f64>,
        side: &Side,
    ) -> Self {
        let (along, ends) = (side.along(), side.ends());
        Self {
            contact,
            corner: corner - Vector2::from(posture.fields().center_of_mass),
            side: side.index(),
            along,
            distance: -turned_left(along).dot(&ends[0]),
            ends: ends.map(|end| along.dot(&end)),
            concave: side.concave(),
            coefficients: posture.on_corner(corner, side),
        }
    }

    /// The point of contact in this state of the body, with the gap and the rate that follow from the state.
    pub(crate) fn point(&self, state: &BodyState, size: f64) -> ContactState {
        let mut point = ContactState {
            normal: Vector2::zeros(),
            tangent: Vector2::zeros(),
            friction: self.coefficients[0],
            surface_speed: 0.0,
            restitution: [self.coefficients[1], self.coefficients[2]],
            b: 0.0,
            c: 0.0,
            held: None,
            place: Place::anywhere(self.contact),
            h: 0.0,
            depth: 0.0,
            u: 0.0,
            rounding: Rounding::default(),
            radius: 0.0,
            corner: None,
        };
        self.set_place(&mut point, state.center.r, state.spin.theta);
        let (v, omega) = (state.center.v, state.spin.omega);
        (point.h, point.u) = (-point.c - self.distance, point.normal.dot(&v) + point.b * omega);
        let place = state.center.r.norm() + self.corner.norm() + size;
        point.rounding = Rounding::new(place, v.norm() + (point.b * omega).abs());
        point
    }

    /// Sets the axes, the arm and the distances from the ends of the side for this place of the body.
    fn set_place(&self, p: &mut ContactState, r: Vector2<f64>, theta: f64) {
        let (along, arm) = (turned(&Turn::by(theta), self.along), self.corner - r);
        (p.tangent, p.normal) = (along, turned_left(along));
        (p.b, p.c) = (p.tangent.dot(&arm), p.normal.dot(&arm));
        let ways = self.distances_from_ends(p.b);
        p.place.sides =
            std::array::from_fn(
                |end| {
                    if self.concave[end] { f64::INFINITY } else { ways[end].max(0.0) }
                },
            );
        p.place.across = [along; 2];
    }

    /// Distances along the side from its start and to its end, in m; negative beyond them. `b`: of the contact.
    pub(crate) fn distances_from_ends(&self, b: f64) -> [f64; 2] {
        [b - self.ends[0], self.ends[1] - b]
    }

    /// Depth of the corner below the side for the place of the body, in m, and the distance along the side from where it was held: the errors
    /// of a closed contact and of a fixed one. `held`: b when it began to be held.
    pub(super) fn drift(&self, p: &ContactState, r: Vector2<f64>, held: f64) -> [f64; 2] {
        let arm = self.corner - r;
        [held - p.tangent.dot(&arm), -p.normal.dot(&arm) - self.distance]
    }
}

impl BodyState {
    /// The corner of the ground that point `i` is, if it is one.
    #[inline]
    pub(crate) fn side_contact(&self, i: usize) -> Option<&SideContact> {
        if self.sides.is_empty() {
            return None;
        }
        let contact = self.points[i].place.contact;
        self.sides.iter().find(|side| side.contact == contact)
    }

    /// The other point of the corner of the ground that point `i` is, if both touch: it is in a concave corner of the body.
    pub(super) fn second_side(&self, i: usize) -> Option<usize> {
        let corner = self.side_contact(i)?.corner;
        let touches = |j: usize| self.points[j].h == 0.0;
        let others = (0..self.points.len()).filter(|&j| j != i && touches(i) && touches(j));
        let mut others =
            others.filter(|&j| self.side_contact(j).is_some_and(|on| on.corner == corner));
        others.next()
    }

    /// The acceleration of point `i` into its ground because its normal turns: 2 ω v_t of a corner of the ground on a side, −w²/D of a disc over
    /// a corner, otherwise zero.
    pub(super) fn coriolis(&self, i: usize) -> f64 {
        match (self.points[i].corner, self.side_contact(i)) {
            (Some(_), _) => self.turns_about(&self.points[i]),
            (_, Some(_)) => 2.0 * self.spin.omega * self.slip(i),
            _ => 0.0,
        }
    }

    /// Computes axes and arms of all corners of the ground from the place of the body.
    pub(super) fn place_sides(&mut self) {
        if self.sides.is_empty() {
            return;
        }
        for i in 0..self.points.len() {
            if let Some(side) = self.side_contact(i).copied() {
                let (r, theta) = (self.center.r, self.spin.theta);
                side.set_place(&mut self.points[i], r, theta);
            }
        }
    }

    /// Gap and rate of point `i`, a corner of the ground, after a flight of `dt`. Only the changes are computed, so that a small gap keeps its
    /// digits:
    ///
    /// ```text
    /// h − h₀ = u₀ t + ½ n₀·γ t² + c₀ (1 − cos φ) − b₀ (φ − sin φ) − (n₀ (1 − cos φ) + t₀ sin φ)·w
    /// w = v t + ½ γ t²,   φ = ω t
    /// ```
    fn side_flown(&self, i: usize, dt: f64) -> [f64; 2] {
        let (p, v, omega, fall) = (&self.points[i], self.center.v, self.spin.omega, self.fall);
        let turn = Turn::by(omega * dt);
        let way = v * dt + fall * (0.5 * dt * dt);
        let (sin, less) = (turn.sin, turn.one_minus_cos);
        let (n, t) = (p.normal, p.tangent);
        // n₀ − n and t − t₀
        let (bent, along) = (n * less + t * sin, n * sin - t * less);
        let h = p.h + dt * (p.u + 0.5 * dt * n.dot(&fall)) + p.c * less
            - p.b * turn.x_minus_sin
            - bent.dot(&way);
        let moved = p.c * sin - p.b * less - (along + t).dot(&way); // b − b₀
        let u = p.u + dt * n.dot(&fall) - bent.dot(&(v + fall * dt)) + omega * moved;
        [h, u]
    }

    /// After a flight of `dt` from the state `before` on, in which all else is computed.
    pub(super) fn fly_sides(&mut self, before: &Self, dt: f64) {
        for i in 0..self.points.len() {
            if before.side_contact(i).is_some() {
                let [h, u] = before.side_flown(i, dt);
                (self.points[i].h, self.points[i].u) = (h.max(0.0), u);
            }
        }
        self.place_sides();
    }

    /// Bounds of the second, third and fourth derivative of the gap of point `i` in flight up to time `t`. In the axes of the body the corner
    /// is the product of a rotation and of the arm a(t):
    ///
    /// ```text
    /// |h⁽ᵏ⁾| ≤ |ω|ᵏ|a| + k |ω|ᵏ⁻¹|ȧ| + ½k(k − 1) |ω|ᵏ⁻²|γ|
    /// ```
    fn gap_bounds(&self, i: usize, t: f64) -> [f64; 3] {
        let (omega, g) = (self.spin.omega.abs(), self.gravity);
        let speed = self.center.v.norm() + g * t;
        let arm = self.points[i].arm().norm() + speed * t;
        [
            g + omega * (2.0 * speed + omega * arm),
            omega * (3.0 * g + omega * (3.0 * speed + omega * arm)),
            omega * omega * (6.0 * g + omega * (4.0 * speed + omega * arm)),
        ]
    }

    /// A time up to which point `i`, a corner of the ground that has just lifted off a side, stays in front of it: its gap and its rate are zero,
    /// and the first derivative of the gap that is not zero is positive.
    fn leaves_side(&self, i: usize, longest: f64) -> f64 {
        let (p, omega, fall) = (&self.points[i], self.spin.omega, self.fall);
        let pull = self.known_pull(i);
        let jerk = -3.0 * omega * p.tangent.dot(&fall) + 2.0 * p.b * omega * omega * omega;
        let [_, third, fourth] = self.gap_bounds(i, longest);
        stays_off([pull, jerk], [third, fourth], longest)
    }

    /// When the gap of point `i`, a corner of the ground, falls to zero in flight, if before `limit` (s).
    pub(super) fn side_touchdown(&self, i: usize, limit: f64) -> Option<f64> {
        let (p, omega) = (&self.points[i], self.spin.omega.abs());
        let longest = if omega > 0.0 { LONGEST_TURN / omega } else { f64::INFINITY };
        let (mut t, [mut h, mut u]) = (0.0, [p.h, p.u]);
        if h == 0.0 && u == 0.0 && omega > 0.0 {
            t = self.leaves_side(i, longest);
            [h, u] = self.side_flown(i, t);
        }
        if longest == f64::INFINITY && t < limit {
            // Without rotation the gap is a parabola.
            let dt = parabola_touchdown(h, u, -p.normal.dot(&self.fall));
            return (dt < f64::INFINITY).then_some(t + dt);
        }
        let step = |t: f64, _| (longest, self.gap_bounds(i, t + longest.min(limit - t))[0]);
        first_zero((t, [h, u]), limit, |t| self.side_flown(i, t), step)
    }
}

/// Half the time up to which a gap stays open that is zero with its rate, at most half of `longest` (s). Its acceleration is −`pull`, and `jerk` its
/// third derivative if that is zero; `third`, `fourth`: bounds of its third and fourth derivative. 0: it does not open.
pub(super) fn stays_off([pull, jerk]: [f64; 2], [third, fourth]: [f64; 2], longest: f64) -> f64 {
    let free = match pull {
        0.0 if jerk > 0.0 => 4.0 * jerk / fourth,
        pull if pull < 0.0 => -3.0 * pull / third,
        _ => 0.0,
    };
    0.5 * free.min(longest)
}

/// When a gap that is open at the start, or opens there, falls to zero, if before `limit` (s). `start`: a time, with the gap and the rate then.
/// `step`: from a time and a gap, how long to go at most (s), and a bound K of |ḧ| so long. A gap h + u s − ½ K s² > 0 stays open, and a rate
/// u + K s < 0 keeps its sign.
pub(super) fn first_zero(
    (mut t, [mut h, mut u]): (f64, [f64; 2]),
    limit: f64,
    flown: impl Fn(f64) -> [f64; 2],
    step: impl Fn(f64, f64) -> (f64, f64),
) -> Option<f64> {
    for _ in 0..MOST_STEPS {
        let left = limit - t;
        if !(left > 0.0) {
            return None;
        }
        let (longest, k) = step(t, h);
        let mut step = longest.min(left);
        // The first time at which h + u s − ½ K s² is zero.
        let free = (u + (u * u + 2.0 * k * h).sqrt()) / k;
        if u < 0.0 {
            // Within this time the rate stays negative.
            let falls = step.min(-u / k * 0.5);
            let [end, _] = flown(t + falls);
            if end <= 0.0 {
                let at = |s: f64| {
                    let [h, u] = flown(s);
                    (h, u)
                };
                return Some(bracketed(t, t + falls, at));
            }
        }
        step = step.min(free.max(f64::EPSILON * t).max(f64::MIN_POSITIVE));
        t += step;
        [h, u] = flown(t);
        if h <= 0.0 {
            if u <= 0.0 {
                return Some(t);
            }
            h = 0.0;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::contact::Contact;
    use crate::body::fields::{GroundKind, PostureFields};
    use crate::collisions::log::{Center, Spin};
    use crate::math::random::Random;

    /// A box over a peak at the origin.
    fn posture() -> Posture {
        let outline = [[-0.5, 0.0], [0.5, 0.0], [0.5, 0.6], [-0.5, 0.6]];
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.3,
            center_of_mass: [0.1, 0.2],
            contacts: outline.iter().map(|[x, y]| Contact::at(*x, *y)).collect(),
            restitution: 0.5,
            gravity: 9.81,
            terrain: vec![[-9.0, -9.0], [0.0, 0.0], [9.0, -9.0]],
            surfaces: Vec::new(),
            ground: GroundKind::Own,
            outline: outline.to_vec(),
        })
        .unwrap()
    }

    /// A body with the peak as its only contact, on a side that is `h` above it.
    fn over_peak(random: &mut Random, posture: &Posture, h: f64) -> BodyState {
        let theta = random.between(-3.1, 3.1);
        let side = posture.outline().unwrap().sides()[0];
        let on = SideContact::new(posture, 4, Vector2::zeros(), &side);
        let t = turned(&Turn::by(theta), on.along);
        let arm = t * random.between(-0.4, 0.4) - turned_left(t) * (on.distance + h);
        let mut state = BodyState {
            points: [].into_iter().collect(),
            sides: vec![on],
            center: Center {
                r: on.corner - arm,
                v: Vector2::new(random.between(-2.0, 2.0), random.between(-2.0, 2.0)),
            },
            spin: Spin { theta, omega: random.between(-9.0, 9.0) },
            rho2: 0.09,
            fall: Vector2::new(0.0, -9.81),
            fall_rate: Vector2::zeros(),
            gravity: 9.81,
        };
        let mut point = on.point(&state, 1.0);
        point.h = h;
        state.points.push(point);
        state
    }

    /// The gap after a flight is that of the place of the body then, and its change over a short time has all its digits.
    #[test]
    fn gaps_in_flight() {
        let (posture, mut random) = (posture(), Random(5));
        for _ in 0..1000 {
            let state = over_peak(&mut random, &posture, 0.3);
            let dt = random.between(0.0, 0.5);
            let after = state.flown(dt);
            let again = after.sides[0].point(&after, 1.0);
            let [h, u] = state.side_flown(0, dt);
            assert!((h - again.h).abs() < 1e-14 && (u - again.u).abs() < 1e-13, "{h} {}", again.h);
            // h − h₀ − u₀ t = ½ ḧ t², with ḧ of the head of this file.
            let closed = BodyState {
                points: [ContactState { h: 0.0, ..state.points[0] }].into_iter().collect(),
                ..state.clone()
            };
            let p = &closed.points[0];
            let lift = -closed.pull(0) - p.c * state.spin.omega * state.spin.omega;
            let t = 1e-9;
            let bent = closed.side_flown(0, t)[0] - p.u * t;
            assert!(
                (bent / (0.5 * t * t) - lift).abs() < 1e-4 * (10.0 + lift.abs()),
                "{bent} {lift}"
            );
        }
    }

    /// No gap is negative before the touchdown that is found, and it is zero there.
    #[test]
    fn the_first_touchdown() {
        let (posture, mut random) = (posture(), Random(6));
        let mut found = 0;
        for k in 0..2000 {
            let h = if k % 4 == 0 { 0.0 } else { random.between(0.0, 1.0) };
            let mut state = over_peak(&mut random, &posture, h);
            if h == 0.0 {
                state.points[0].u = state.points[0].u.abs();
                let p = &state.points[0];
                let rate = p.normal.dot(&state.center.v) + p.b * state.spin.omega;
                state.center.v += p.normal * (p.u - rate);
            }
            let limit = random.between(0.0, 2.0);
            let t = state.side_touchdown(0, limit);
            let end = t.unwrap_or(limit);
            for j in 1..200 {
                let [h, _] = state.side_flown(0, end * f64::from(j) / 200.0);
                assert!(h > 0.0, "{h} before {end}");
            }
            if let Some(t) = t {
                found += 1;
                let [h, u] = state.side_flown(0, t);
                assert!(h.abs() < 1e-13 && u <= 1e-6, "{h} {u}");
            }
        }
        assert!(found > 500, "{found}");
    }

    /// Seen from the body the corner is a point that moves relative to a line, with Euler's, Coriolis's and the centrifugal acceleration.
    #[test]
    fn the_acceleration_of_the_gap_in_the_axes_of_the_body() {
        let (posture, mut random) = (posture(), Random(7));
        for _ in 0..1000 {
            let mut state = over_peak(&mut random, &posture, 0.0);
            let p = state.points[0];
            // On the side: ḣ = 0.
            let rate = p.normal.dot(&state.center.v) + p.b * state.spin.omega;
            state.center.v -= p.normal * rate;
            let [push, turn] = [random.between(-5.0, 5.0), random.between(-5.0, 5.0)];
            let a = Vector2::new(push, 1.0 - push);
            let omega = state.spin.omega;
            let ways = [Some(1_i8)];
            let [_, bias] = state.bias(0, ways[0], omega * omega);
            let lift = p.normal.dot(&a) + p.b * turn + bias;
            // A = R(−θ)a: Ä = −R(−θ)r̈ − ω̇ × A − 2 ω × Ȧ + ω² A, all in the axes of the body, and h = −n·A − d.
            let arm = p.arm();
            let relative = -state.center.v - turned_left(arm) * omega;
            let second = -a - turned_left(arm) * turn - turned_left(relative) * (2.0 * omega)
                + arm * (omega * omega);
            assert!((lift + p.normal.dot(&second)).abs() < 1e-12 * (1.0 + lift.abs()), "{lift}");
        }
    }
}
