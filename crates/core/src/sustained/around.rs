//! A disc on a corner of the ground. Its point of contact is fixed in the world; its normal points from the corner to the centre and turns
//! with it.
//!
//! ```text
//!   V corner, P centre of the disc, D = |P − V|, n = (P − V)/D, t = n turned by −90°, p = P − x the arm of P
//!
//!   h = D − R,   b = t·p,   c = n·p,   w = t·Ṗ = t·ẋ − c ω
//!   ṅ = (w/D) t,   ṫ = −(w/D) n,   ḃ = −c (ω + w/D),   ċ = b (ω + w/D)
//!   ḣ = n·ẋ + b ω,   v_t = t·ẋ − (c − R) ω
//!   ḧ = n·ẍ + b ω̇ − c ω² + w²/D,   v̇_t = t·ẍ − (c − R) ω̇ − b ω² − (w/D) ḣ
//! ```
//!
//! So its rows are those of a disc on a line along t; of the accelerations, only the terms with w/D differ.

use nalgebra::Vector2;

use crate::flight::GapArc;
use crate::math::turn::Turn;
use crate::sustained::side::{LONGEST_TURN, first_zero, stays_off};
use crate::sustained::{BodyState, ContactState};

impl ContactState {
    /// Distance of the centre from its corner, in m.
    pub(super) fn distance(&self) -> f64 {
        self.radius + self.h
    }

    /// Angle of the normal from the vertical, clockwise, in rad: the way of the centre about its corner, over the distance.
    pub(super) fn bearing(&self) -> f64 {
        libm::atan2(self.normal.x, self.normal.y)
    }

    /// How far a disc on its corner has come off it in a motion of the body: by rolling, and along the normal, in m. `moved`: way of the centre of
    /// mass, in m; `turned`: (cos − 1, sin) of the rotation, whose angle this is, in rad.
    pub(super) fn off_corner(&self, moved: Vector2<f64>, turned: [f64; 2], angle: f64) -> [f64; 2] {
        let ([less, sin], [b, c]) = (turned, [self.b, self.c]);
        let up = self.normal.dot(&moved) + b * sin + c * less;
        let along = self.tangent.dot(&moved) - c * sin + b * less;
        let over = self.radius + up;
        let rolled = self.radius * (libm::atan2(along, over) + angle);
        [rolled, up + along * along / (libm::hypot(over, along) + over)]
    }

    /// The same since it began to be held there: `held` are R (bearing + θ) and R.
    pub(super) fn drift_about(
        &self,
        corner: Vector2<f64>,
        r: Vector2<f64>,
        theta: f64,
        held: [f64; 2],
    ) -> [f64; 2] {
        let around = std::f64::consts::TAU * self.radius;
        let rolled = self.radius * (self.bearing() + theta) - held[0];
        let distance = (r + self.arm() - corner).norm();
        [rolled - around * (rolled / around).round(), distance - held[1]]
    }

    /// Sets the axes from the place of the centre, relative to the corner, and the arm, in m.
    fn set_axes(&mut self, from: Vector2<f64>, arm: Vector2<f64>) {
        if let Some(normal) = from.try_normalize(0.0) {
            (self.normal, self.tangent) = (normal, Vector2::new(normal.y, -normal.x));
        }
        (self.b, self.c) = (self.tangent.dot(&arm), self.normal.dot(&arm));
    }
}

/// How far a point moves in a flight, and how fast after it: along the normal and along the tangent.
struct Way {
    up: [f64; 2],
    along: [f64; 2],
}

impl BodyState {
    /// Returns true if the normal of a point turns.
    pub(crate) fn turns(&self) -> bool {
        !self.sides.is_empty() || self.points.iter().any(|p| p.corner.is_some())
    }

    /// Speed of a point of the body along a tangent, of the centre if it is round, in m/s.
    pub(super) fn along_of(&self, p: &ContactState) -> f64 {
        p.tangent.dot(&self.center.v) - p.c * self.spin.omega
    }

    /// −w²/D: the acceleration towards its corner of a centre that moves about it.
    pub(super) fn turns_about(&self, p: &ContactState) -> f64 {
        let w = self.along_of(p);
        -w * w / p.distance()
    }

    fn way(&self, p: &ContactState, dt: f64) -> Way {
        let (omega, turn) = (self.spin.omega, Turn::by(self.spin.omega * dt));
        let g = -self.fall.dot(&p.normal);
        let line = GapArc { h: 0.0, u: p.u, g, b: p.b, c: p.c, omega };
        let (push, less, sin) = (p.tangent.dot(&self.fall), turn.one_minus_cos, turn.sin);
        let v = p.tangent.dot(&self.center.v);
        Way {
            up: [line.gap_turned(dt, &turn), line.rate_turned(dt, &turn)],
            along: [
                dt * (v + 0.5 * push * dt) - p.c * sin - p.b * less,
                v + push * dt - omega * (p.c * (1.0 - less) + p.b * sin),
            ],
        }
    }

    /// Gap and rate of a disc over its corner after a flight of `dt`. Only the changes are computed, so that a small gap keeps its digits. With
    /// L and w the ways along n and t,
    ///
    /// ```text
    /// D = √((D₀ + L)² + w²),   h − h₀ = L + w²/(D + D₀ + L)
    /// ```
    pub(super) fn flown_about(&self, p: &ContactState, dt: f64) -> [f64; 2] {
        let Way { up: [up, rise], along: [along, speed] } = self.way(p, dt);
        let over = p.distance() + up;
        let distance = libm::hypot(over, along);
        if over <= 0.0 {
            return [distance - p.radius, (over * rise + along * speed) / distance];
        }
        let bent = along / (distance + over);
        [p.h + up + along * bent, rise + along / distance * (speed - bent * rise)]
    }

    /// After a flight of `dt` from the state `before` on, in which all else is computed.
    pub(super) fn fly_about(&mut self, before: &Self, dt: f64) {
        for (p, old) in self.points.iter_mut().zip(&before.points) {
            if old.corner.is_some() {
                let [h, u] = before.flown_about(old, dt);
                (p.h, p.u) = (h.max(0.0), u);
            }
        }
        self.place_about();
    }

    /// Computes the axes of discs over corners from the place of the body. Their arms are right in the axes that they have.
    pub(super) fn place_about(&mut self) {
        for p in &mut self.points {
            if let Some(corner) = p.corner {
                let arm = p.arm();
                p.set_axes(self.center.r + arm - corner, arm);
            }
        }
    }

    /// A time up to which a disc that has just lifted off its corner stays off: its gap and its rate are zero, and the first derivative of the gap
    /// that is not zero is positive.
    ///
    /// ```text
    /// D⃛ = n·P⃛ + 3 (w/D) t·P̈ where Ḋ = 0;   as long as D ≥ R, with s, a and j bounds of |Ṗ|, |P̈| and |P⃛|,
    /// |D⃛| ≤ j + 3 s a/R + 3 s³/R²,   |D⁗| ≤ |P⁗| + 4 s j/R + 3 a²/R + 18 s² a/R² + 15 s⁴/R³
    /// ```
    fn leaves_corner(&self, i: usize, longest: f64) -> f64 {
        let (p, omega, pull) = (&self.points[i], self.spin.omega, self.known_pull(i));
        let square = omega * omega;
        let jerk = 3.0 * self.along_of(p) / p.radius * (p.tangent.dot(&self.fall) - square * p.b)
            - omega * square * p.b;
        let (arm, r) = (p.arm().norm(), p.radius);
        let speed = self.center.v.norm() + self.gravity * longest + omega.abs() * arm;
        let (push, jolt) = (self.gravity + square * arm, omega.abs() * square * arm);
        let turning = speed / r;
        let third = jolt + 3.0 * turning * (push + turning * speed);
        let fourth = square * square * arm
            + 4.0 * turning * jolt
            + 3.0 * push * push / r
            + turning * turning * (18.0 * push + 15.0 * turning * speed);
        stays_off([pull, jerk], [third, fourth], longest)
    }

    /// When a disc in flight touches its corner, if before `limit` (s).
    pub(super) fn touches_corner(&self, i: usize, limit: f64) -> Option<f64> {
        let p = &self.points[i];
        let (omega, g, arm) = (self.spin.omega.abs(), self.gravity, p.arm().norm());
        let far = p.distance() + p.radius + 2.0 * arm;
        // From then on it is too far away.
        let v = self.center.v.norm();
        let last = match (g > 0.0, v > 0.0) {
            (true, _) => (v + (v * v + 2.0 * g * far).sqrt()) / g,
            (false, true) => far / v,
            (false, false) if omega > 0.0 => std::f64::consts::TAU / omega,
            _ => return None,
        };
        let limit = limit.min(last);
        let longest = if omega > 0.0 { LONGEST_TURN / omega } else { f64::INFINITY };
        // A step in which the centre moves by at most half its distance, and a bound of |ḧ| ≤ |P̈| + |Ṗ|²/D in it.
        let step = |t: f64, h: f64| {
            let (speed, distance) = (v + g * t + omega * arm, p.radius + h);
            let step = (0.5 * distance / (speed + (g * distance).sqrt())).min(longest);
            let (fast, near) = (speed + g * step, p.radius.max(0.5 * distance));
            (step, g + omega * omega * arm + fast * fast / near)
        };
        let (mut t, mut start) = (0.0, [p.h, p.u]);
        if p.h == 0.0 && p.u == 0.0 {
            t = self.leaves_corner(i, step(0.0, 0.0).0);
            start = self.flown_about(p, t);
        }
        first_zero((t, start), limit, |t| self.flown_about(p, t), step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::terrain::Place;
    use crate::collisions::log::{Center, Spin};
    use crate::math::random::Random;
    use crate::modes::Mode;
    use crate::sustained::{Rounding, Step};

    /// A body whose only contact is a disc of radius 0.3, `h` above a corner at (0.2, −0.1) from the nominal centre of mass.
    fn over_corner(random: &mut Random, h: f64) -> BodyState {
        let (corner, radius) = (Vector2::new(0.2, -0.1), 0.3);
        let angle = random.between(-3.1, 3.1);
        let normal = Vector2::new(angle.sin(), angle.cos());
        let arm = Vector2::new(random.between(-0.5, 0.5), random.between(-0.5, 0.5));
        let mut p = ContactState {
            normal,
            tangent: Vector2::new(normal.y, -normal.x),
            friction: 0.5,
            surface_speed: 0.0,
            restitution: [0.5, 0.0],
            b: 0.0,
            c: 0.0,
            radius,
            corner: Some(corner),
            held: None,
            place: Place::anywhere(0),
            h,
            depth: 0.0,
            u: 0.0,
            rounding: Rounding::default(),
        };
        p.set_axes(normal, arm);
        let v = Vector2::new(random.between(-2.0, 2.0), random.between(-2.0, 2.0));
        let omega = random.between(-9.0, 9.0);
        p.u = p.normal.dot(&v) + p.b * omega;
        BodyState {
            points: [p].into_iter().collect(),
            sides: Vec::new(),
            center: Center { r: corner + normal * (radius + h) - arm, v },
            spin: Spin { theta: 0.0, omega },
            rho2: 0.09,
            fall: Vector2::new(0.0, -9.81),
            fall_rate: Vector2::zeros(),
            gravity: 9.81,
        }
    }

    fn distance(state: &BodyState) -> f64 {
        let p = &state.points[0];
        (state.center.r + p.arm() - p.corner.unwrap()).norm()
    }

    /// The gap after a flight is that of the place of the body then, and its change over a short time has all its digits.
    #[test]
    fn gaps_in_flight() {
        let mut random = Random(5);
        for _ in 0..1000 {
            let state = over_corner(&mut random, 0.2);
            let after = state.flown(random.between(0.0, 0.5));
            let p = &after.points[0];
            let rate = p.normal.dot(&after.center.v) + p.b * after.spin.omega;
            let h = distance(&after) - 0.3;
            if h > 0.0 {
                assert!((p.h - h).abs() < 1e-14 && (p.u - rate).abs() < 1e-13, "{p:?} {h} {rate}");
            }
            // h − h₀ − u₀ t = ½ ḧ t², with ḧ of the head of this file.
            let (p, t) = (&state.points[0], 1e-9);
            let lift = -state.arc(0).effective_gravity();
            let near = ContactState { h: 0.0, radius: p.distance(), ..*p };
            let bent = state.flown_about(&near, t)[0] - p.u * t;
            assert!((bent / (0.5 * t * t) - lift).abs() < 1e-4 * (10.0 + lift.abs()), "{bent}");
        }
    }

    /// No gap is negative before the touchdown that is found, and it is zero there.
    #[test]
    fn the_first_touchdown() {
        let (mut random, mut found) = (Random(6), 0);
        for k in 0..2000 {
            let h = if k % 4 == 0 { 0.0 } else { random.between(0.0, 1.0) };
            let mut state = over_corner(&mut random, h);
            if h == 0.0 {
                let u = if k % 8 == 0 { 0.0 } else { state.points[0].u.abs() };
                let push = state.points[0].normal * (u - state.points[0].u);
                state.center.v += push;
                state.points[0].u = u;
                if u == 0.0 && state.known_pull(0) >= 0.0 {
                    continue;
                }
            }
            let limit = random.between(0.0, 2.0);
            let t = state.touches_corner(0, limit);
            let end = t.unwrap_or(limit);
            for j in 1..200 {
                let [h, _] = state.flown_about(&state.points[0], end * f64::from(j) / 200.0);
                assert!(h > 0.0, "{h} before {end}");
            }
            if let Some(t) = t {
                found += 1;
                let [h, u] = state.flown_about(&state.points[0], t);
                assert!(h.abs() < 1e-13 && u <= 1e-6, "{h} {u}");
            }
        }
        assert!(found > 300, "{found}");
    }

    /// While two discs are held, one on a corner and one on a slope, in all words, the series keep both on their ground.
    #[test]
    fn two_discs_stay_on_their_ground() {
        let mut random = Random(7);
        let mut words = 0;
        for k in 0..400 {
            let in_air = k % 4 == 3;
            let h = if in_air { random.between(0.0, 0.5) } else { 0.0 };
            let mut state = over_corner(&mut random, h);
            let slope = random.between(-1.0, 1.0);
            let mut other = ContactState { corner: None, radius: 0.2, ..state.points[0] };
            (other.normal, other.tangent) =
                (Vector2::new(-slope.sin(), slope.cos()), Vector2::new(slope.cos(), slope.sin()));
            let arm = Vector2::new(random.between(-0.5, 0.5), random.between(-0.5, 0.5));
            (other.b, other.c) = (other.tangent.dot(&arm), other.normal.dot(&arm));
            other.place = Place::anywhere(1);
            state.points.push(other);
            let word = [
                [Mode::Left, Mode::Right, Mode::Fixed, Mode::Separate][k % 4],
                [Mode::Right, Mode::Left, Mode::Fixed][k / 4 % 3],
            ];
            if state.is_fixed(&word) {
                continue;
            }
            state.hold(&word);
            state.project(&word);
            let p = &mut state.points[0];
            p.u = p.normal.dot(&state.center.v) + p.b * state.spin.omega;
            let Some(step) = Step::new(&state, &word, 21) else { continue };
            words += 1;
            let t = step.reach();
            for share in [0.1, 0.3, 1.0] {
                let after = step.at(&state, share * t);
                let p = &after.points[1];
                let moved = after.center.r - state.center.r;
                let off = p.normal.dot(&moved) + p.c - state.points[1].c;
                let size = 1.0 + moved.norm();
                assert!(off.abs() < 1e-13 * size, "{word:?} {off} {share} {:?}", after.center);
                let raw = |series: &[f64]| {
                    series.iter().rev().fold(0.0, |sum, c| sum * (share * t / step.unit) + c)
                };
                let r = Vector2::new(raw(&step.r[0]), raw(&step.r[1]));
                assert!(
                    (r - after.center.r).norm() < 1e-12 * size,
                    "{word:?} {} {}",
                    r,
                    after.center.r
                );
                let p = &after.points[0];
                let gap = distance(&after) - 0.3;
                if gap > 0.0 {
                    assert!((gap - p.h).abs() < 1e-13 * size, "{word:?} {gap} {}", p.h);
                }
            }
        }
        assert!(words > 200, "{words}");
    }
}
