//! Sums of the bounces of one contact while all others are in the air.
//!
//! Let y be the state after an impact of this contact: time t, rotation θ, spin ω, place and speed along the ground, and the speed u at which
//! it takes off. The rest follows: the gap is zero, and the normal velocity is u − bω. Near rest one bounce is an analytic map y → y + F(y)
//! that multiplies u by r, up to terms of higher order, and moves everything else by an amount of order u. So the states of successive
//! impacts are values of one analytic function at s, r s, r² s, …,
//!
//! ```text
//! y(r s) = y(s) + F(y(s)),   y(s) = y(0) + Σ_m c_m s^m
//! ```
//!
//! with y(1) the present state and y(0) the limit, however many bounces there are. A polynomial of degree M is determined by the equation at M
//! places s_j; F at each of them is one bounce from a state that the body does not pass through. With the values of F from the last iterate,
//! the coefficients follow from linear equations,
//!
//! ```text
//! Σ_m (r^m − 1) s_j^m c_m = F_j,    Σ_{m>1} (r^m − r) s_j^m a_m = u'_j − r u_j  for u = Σ_m a_m s^m, Σ_m a_m = u(1)
//! ```
//!
//! The iteration converges as that of Picard for a differential equation does. Without rotation only c_1 and c_2 differ from zero, and the
//! first iterate is exact. The last coefficients in Chebyshev's polynomials estimate the
//! error.
//!
//! If the contact slides in one direction through all impacts, their impulses are (−σμ, 1) P, and every law returns e: r = e. The ratio of the
//! sliding speed v_k to the landing speed u_k is v_∞/u_k plus a constant: it grows once v_k has the sign of its limit, so a contact that
//! slides now goes on to slide. One that sticks now goes on to stick only if v_∞ = 0. Then its sliding speed before an impact is that of one
//! flight, a_t τ = 2a_t u/g, in proportion to u; Moreau's law returns e, Poisson's and Stronge's another fraction of u. The bounces are followed
//! one by one where an impact neither stops the slide nor keeps it: as Moreau's law with tangential restitution and Chatterjee and Ruina's law do, and where
//! the slide turns back in each impact.

use nalgebra::{SVector, Vector2};

use crate::body::contact::ContactLetters;
use crate::body::posture::Posture;
use crate::collisions::full::FullState;
use crate::flight::{GapArc, parabola_touchdown};
use crate::impact::friction::{self, Material, Matrix};
use crate::math::collocation::{changes as changes_of_powers, coefficients, doubt, places};
use crate::math::mass_vector::MassVector;
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::motion::series::{Bounces, Retry};
use crate::options::Impact;
use crate::outcome::{Outcome, ZenoMethod};
use crate::sustained::BodyState;
use crate::sustained::edges::EdgeWatch;
use crate::sustained::frozen::Frozen;
use crate::tolerance::{BOUNCE_CHANGE, BOUNCE_SUM, NEXT_TERM, REMAINDER_FACTOR, STILL};

/// Number of impacts of the contact before the first attempt to sum its bounces.
const FIRST_ATTEMPT: usize = 2;

/// The same under Newton's law with two contacts, where an attempt costs as much as several hundred bounces.
pub(super) const MANY_BOUNCES: usize = 64;

/// Degree of the polynomials. Half of it serves where the body hardly turns, and tells how large the error of the whole will be.
const DEGREE: usize = 8;

/// Error beyond which a polynomial is given up before the iteration has converged, in those that are allowed.
const HOPELESS: f64 = 4.0;

/// Of the error of a polynomial, the square of that with half the degree is so many times as large.
const SQUARE: f64 = 300.0;

/// Change in the last iteration, relative to the error of the polynomial, at which this error is known.
const KNOWN: f64 = 0.1;

/// Rotation until the limit, in rad, up to which a sum is tried: the iteration converges fast. It has no effect on the result.
const MOST_TURN: f64 = 0.02;

/// Negative gap at the limit, in constant geometry, beyond which a sum is not tried, because another contact lands before. Unit: the terms of
/// this gap. It has no effect on the result.
const LANDS_BEFORE: f64 = 0.1;

/// Most iterations.
const ITERATIONS: usize = 20;

/// Intervals of s in which the gaps of other contacts are bounded: few first, and more where these do not decide.
const INTERVALS: [usize; 2] = [4, 32];

/// t, way along the ground, θ, speed along the ground, ω; relative to the present state.
type Change = SVector<f64, 5>;

/// What friction does in an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Grip {
    Sticks,
    /// The direction of the slide; 0 without friction.
    Slides(f64),
}

impl Grip {
    fn of([t, n]: [f64; 2], friction: f64) -> Self {
        if t.abs() < (1.0 - STILL) * friction * n {
            Self::Sticks
        } else {
            Self::Slides(if t == 0.0 { 0.0 } else { -t.signum() })
        }
    }

    /// Returns true if the next impact does the same: at this sliding speed, with this impulse (tangential, normal). A contact that sticks
    /// takes off without a slide; with tangential restitution it may not.
    fn goes_on(self, w: &Matrix, slip: f64, [t, n]: [f64; 2], friction: f64) -> bool {
        let terms = [slip, w.tt * t, w.nt * n];
        let after: f64 = terms.iter().sum();
        let stops = after.abs() <= STILL * terms.iter().map(|term| term.abs()).sum::<f64>();
        self == Self::of([t, n], friction) && (stops || self != Self::Sticks)
    }
}

/// All further bounces of a contact, as a function of s.
struct Sum<const M: usize> {
    /// The coefficients c_m, m = 1, …, M, and a_m, m = 2, …, M + 1.
    terms: [[f64; 6]; M],
    /// The speed u.
    speed: f64,
    /// Estimate of the error of the time, in s.
    error: f64,
}

impl<const M: usize> Sum<M> {
    /// The change up to s, and the speed u there.
    fn at(&self, s: f64) -> (Change, f64) {
        let (mut power, mut change, mut speed) = (1.0, Change::zeros(), self.speed * s);
        for terms in &self.terms {
            power *= s;
            for k in 0..5 {
                change[k] += terms[k] * (power - 1.0);
            }
            speed += terms[5] * (power * s - s);
        }
        (change, speed)
    }
}

/// A polynomial that is not accurate enough: what its error is, and what that of the polynomial with twice the degree will be, in those that are
/// allowed. `None`: there is no polynomial.
type Failed = Option<[f64; 2]>;

/// One contact, on the ground after an impact.
struct Bouncing<'a> {
    body: &'a BodyState,
    i: usize,
    law: Impact,
    material: Material,
    grip: Grip,
}

impl Bouncing<'_> {
    /// Way and velocity of the centre of mass for this change of state, which turns the body by `turn`, with the contact on the ground and the
    /// speed `u` at which it takes off.
    fn center(&self, change: &Change, u: f64, turn: &Turn) -> [Vector2<f64>; 2] {
        let p = &self.body.points[self.i];
        let (b, c) = p.turned(turn);
        let omega = self.body.spin.omega + change[4];
        let along = match self.grip {
            Grip::Sticks => (c - p.radius) * omega + p.surface_speed,
            Grip::Slides(_) => p.tangent.dot(&self.body.center.v) + change[3],
        };
        [
            p.tangent * change[1] - p.normal * p.lift(turn),
            p.tangent * along + p.normal * (u - b * omega),
        ]
    }

    /// The body after this change of state.
    fn moved(&self, change: &Change, u: f64) -> BodyState {
        let mut after = self.body.clone();
        let turn = Turn::by(change[2]);
        let [way, v] = self.center(change, u, &turn);
        after.center.v = v;
        after.spin.theta += change[2];
        after.spin.omega += change[4];
        after.displace(&way, &turn);
        let omega = after.spin.omega;
        after.points.iter_mut().for_each(|p| p.u = p.normal.dot(&v) + p.b * omega);
        (after.points[self.i].h, after.points[self.i].u) = (0.0, u);
        after
    }

    /// F from this state, and u' − r u. `None`: the contact does not come down, or friction does something else in the impact.
    fn bounce(&self, from: &Change, u: f64, ratio: f64) -> Option<(Change, f64)> {
        let (p, rho2) = (&self.body.points[self.i], self.body.rho2);
        let (g, along) = (self.body.pull(self.i), p.tangent.dot(&self.body.fall));
        let [b, c] = p.turned(&Turn::by(from[2])).into();
        let omega = self.body.spin.omega + from[4];
        let v = match self.grip {
            Grip::Sticks => (c - p.radius) * omega + p.surface_speed,
            Grip::Slides(_) => p.tangent.dot(&self.body.center.v) + from[3],
        };
        // The landing speed is u − d.
        let (dt, turn, d) = if omega == 0.0 {
            (parabola_touchdown(0.0, u, g), Turn::default(), 0.0)
        } else {
            let end = GapArc { h: 0.0, u, g, b, c, omega }.find_touchdown()?;
            let (x, Turn { sin, one_minus_cos, x_minus_sin }) = (omega * end.dt, end.turn);
            let [of_c, of_b] =
                [2.0 * one_minus_cos / x - sin, 2.0 * x_minus_sin / x - one_minus_cos];
            (end.dt, end.turn, omega * (c * of_c + b * of_b))
        };
        let landing = u - d;
        if !(dt < f64::INFINITY && landing > 0.0) {
            return None;
        }
        let bent = b * turn.sin - c * turn.one_minus_cos;
        let slip = match self.grip {
            Grip::Sticks => 0.0,
            Grip::Slides(_) => v - (c - p.radius) * omega - p.surface_speed,
        };
        let slip = slip + along * dt - omega * bent;
        let [b, c] = turn.turned([b, c]);
        let c = c - p.radius; // of the touching point
        let w = Matrix { nn: 1.0 + b * b / rho2, nt: -b * c / rho2, tt: 1.0 + c * c / rho2 };
        let [t, n] = friction::impulse(self.law, &w, [slip, -landing], &self.material)?;
        if !self.grip.goes_on(&w, slip, [t, n], self.material.friction) {
            return None;
        }
        let gain =
            [dt, dt * (v + 0.5 * along * dt), omega * dt, along * dt + t, (b * n - c * t) / rho2];
        let excess = if self.returns_restitution() {
            -self.material.restitution * d
        } else {
            w.nt * t + w.nn * n - landing - ratio * u
        };
        Some((gain.into(), excess))
    }

    fn returns_restitution(&self) -> bool {
        self.grip != Grip::Sticks || !matches!(self.law, Impact::Poisson | Impact::Stronge)
    }

    /// The fraction of its speed that the contact keeps near the limit of these bounces; at the start, from here.
    fn ratio(&self, limit: &Change) -> Option<f64> {
        if self.returns_restitution() {
            return Some(self.material.restitution);
        }
        let small = f64::EPSILON * self.body.points[self.i].u;
        let ratio = self.bounce(limit, small, 0.0)?.1 / small;
        (0.0 < ratio && ratio < 1.0).then_some(ratio)
    }

    /// All further bounces, if the polynomial is accurate to `unit` beside the rounding error of the changes.
    fn sum<const M: usize>(&self, unit: &Change) -> Result<Sum<M>, Failed> {
        let u = self.body.points[self.i].u;
        let places: [f64; M] = places();
        let (mut changes, mut speeds) = ([Change::zeros(); M], places.map(|s| s * u));
        let mut last = Change::zeros();
        for k in 0..ITERATIONS {
            let ratio = self.ratio(&last).ok_or(None)?;
            // Both equations are s_j^m x_m = y_j, the second one after a division by s_j r.
            let mut terms = [[0.0; 6]; M];
            for j in 0..M {
                let (gain, more) = self.bounce(&changes[j], speeds[j], ratio).ok_or(None)?;
                terms[j][..5].copy_from_slice(gain.as_slice());
                terms[j][5] = more / (places[j] * ratio);
            }
            coefficients(&places, &mut terms);
            for (row, change) in terms.iter_mut().zip(changes_of_powers::<M>(ratio)) {
                row.iter_mut().for_each(|term| *term /= change);
            }
            let mut sum = Sum { terms, speed: u, error: 0.0 };
            let (limit, _) = sum.at(0.0);
            let allowed = unit + limit.abs() * (BOUNCE_CHANGE * f64::EPSILON);
            for j in 0..M {
                (changes[j], speeds[j]) = sum.at(places[j]);
            }
            if speeds.iter().any(|speed| !(*speed > 0.0)) {
                return Err(None);
            }
            let step = (limit - last).abs();
            let converged = (0..5).all(|k| step[k] <= allowed[k]);
            if k > 0 {
                let doubt = Change::from_fn(|k, _| {
                    doubt(limit[k], &places, changes.map(|change| change[k]), NEXT_TERM)
                });
                let most = doubt.component_div(&allowed).amax();
                let known = (0..5).all(|k| step[k] <= KNOWN * doubt[k] || step[k] <= allowed[k]);
                if most > 1.0 && converged || most > HOPELESS && known {
                    let twice = (0..5)
                        .map(|k| doubt[k] / allowed[k] * (doubt[k] / (SQUARE * limit[k])).abs());
                    return Err(Some([most, twice.filter(|x| x.is_finite()).fold(0.0, f64::max)]));
                }
                if converged {
                    sum.error = doubt[0] + unit[0] + rounding(limit[0], ratio);
                    return Ok(sum);
                }
            }
            last = limit;
        }
        Err(None)
    }
}

impl Bouncing<'_> {
    /// Time until the limit in constant geometry, in s.
    fn duration(&self) -> Option<f64> {
        let g = self.body.arc(self.i).effective_gravity();
        let duration = 2.0 * self.body.points[self.i].u / (g * (1.0 - self.material.restitution));
        (g > 0.0).then_some(duration)
    }

    /// Returns true if in constant geometry no other contact would land before the limit, or none may come near: a quick look before the
    /// work. If the contact slides, the impulses P (−σμ, 1) stop its fall: Σ P w_nn' = g T + u, and they act, on average, at eT/(1 + e).
    fn may_be_alone(&self, duration: f64) -> bool {
        let (body, p, rho2) = (self.body, &self.body.points[self.i], self.body.rho2);
        let (g, e) = (body.arc(self.i).effective_gravity(), self.material.restitution);
        let friction = match self.grip {
            Grip::Slides(way) => -way * self.material.friction,
            Grip::Sticks => p.b * p.touching_c() / (rho2 + p.touching_c() * p.touching_c()),
        };
        let force = p.normal + p.tangent * friction;
        let turn = (p.b - p.touching_c() * friction) / rho2;
        let own = p.normal.dot(&force) + p.b * turn;
        (0..body.points.len()).filter(|&j| j != self.i).all(|j| {
            let q = &body.points[j];
            let ratio = (q.normal.dot(&force) + q.b * turn) / own;
            // The impulses of later impacts, e (g T) in all, act as an upward acceleration e g of the point.
            let pull = body.arc(j).effective_gravity() - e * ratio * g;
            let end = q.h + duration * (q.u - 0.5 * pull * duration);
            end > -LANDS_BEFORE * (q.h + duration * (q.u.abs() + pull.abs() * duration))
        })
    }

    /// Returns true if no other contact lands, no corner of the ground meets a side, no end of the ground is passed and no other piece of
    /// it is met before the limit.
    fn is_alone<const M: usize>(&self, sum: &Sum<M>, posture: &Posture, edges: &EdgeWatch) -> bool {
        let (body, p) = (self.body, &self.body.points[self.i]);
        let (duration, size) = (sum.at(0.0).0[0], posture.size());
        let at = |k: usize, intervals: usize| sum.at(1.0 - k as f64 / intervals as f64);
        // |ω| = |ω(1) + Σ c_m (s^m − 1)|
        let omega = body.spin.omega.abs() + sum.terms.iter().map(|c| c[4].abs()).sum::<f64>();
        // The sum of all normal impulses stops the fall of the contact.
        let fall = duration * (body.gravity + size * omega * omega);
        let push = REMAINDER_FACTOR * (fall + p.u) * (1.0 + self.material.friction);
        let turning = omega + push * size / body.rho2;
        let moved_at = |speed: f64, arm: f64| duration * (speed + fall + push + arm * turning);
        let moved = |arm: f64| moved_at(body.center.v.norm(), arm);
        let way = |j: usize| moved(body.points[j].arm().norm());
        if !edges.stay_off(posture, body, moved) {
            return false;
        }
        let near = |j: usize| {
            let q = &body.points[j];
            let speed = q.normal.dot(&body.center.v).abs();
            j != self.i && q.h <= moved_at(speed, q.arm().norm())
        };
        let within_ground = (0..body.points.len()).all(|j| {
            let q = &body.points[j];
            q.depth == 0.0
                && q.place.sides.iter().all(|side| *side > way(j))
                && body.is_far_from_others(j, posture, way(j))
        });
        if !within_ground || !(0..body.points.len()).any(near) {
            return within_ground;
        }
        // The gap and the rate of point j after an impact.
        let gap = |j: usize, change: &Change, u: f64| {
            let (q, turn) = (&body.points[j], Turn::by(change[2]));
            let [way, v] = self.center(change, u, &turn);
            let (b, _) = q.turned(&turn);
            let omega = body.spin.omega + change[4];
            (q.h + q.normal.dot(&way) + q.lift(&turn), q.normal.dot(&v) + b * omega)
        };
        let weakest = body.pull(self.i) - p.arm().norm() * omega * omega;
        // During a bounce a point leaves the curve through its states after impacts by no more than this time allows.
        let flight = if weakest > 0.0 { 2.0 * p.u / weakest } else { f64::INFINITY };
        (0..body.points.len()).filter(|&j| near(j)).all(|j| {
            let q = &body.points[j];
            let pull = (body.pull(j).abs() + q.arm().norm() * omega * omega) * flight;
            INTERVALS.iter().any(|&intervals| {
                let (mut time, mut before) = (0.0, (q.h, q.u));
                (1..=intervals).all(|k| {
                    let (change, u) = at(k, intervals);
                    let after = gap(j, &change, u);
                    let speed =
                        REMAINDER_FACTOR.sqrt() * (before.1.abs().max(after.1.abs()) + pull);
                    let stays = before.0 + after.0 > speed * (change[0] - time);
                    (time, before) = (change[0], after);
                    stays
                })
            })
        })
    }
}

/// Rounding error of the time until the limit, t = 2u/(g(1 − r)) in constant geometry: one of r changes 1 − r by 1/(1 − r) times as much.
fn rounding(t: f64, ratio: f64) -> f64 {
    BOUNCE_CHANGE * f64::EPSILON * t / (1.0 - ratio)
}

/// The end of a sum of bounces.
#[derive(Debug, Clone)]
pub(super) struct Settled {
    pub(super) state: Moving,
    /// Time until then, and the estimate of its error, in s.
    pub(super) duration: f64,
    pub(super) error: f64,
}

impl Driver<'_> {
    /// All bounces of point `i` that follow an impact with this impulse (tangential, normal) per unit mass, if their limit is known and
    /// nothing else happens before it.
    pub(super) fn limit_of_bounces(
        &self,
        body: &BodyState,
        i: usize,
        impulse: [f64; 2],
        mut material: Material,
        fastest: f64,
    ) -> Result<Settled, Retry> {
        let Some(posture) = self.record.subject.posture() else { return Err(Retry::Later) };
        let (size, clock, law) = (posture.size(), self.log.clock, self.options.impact);
        if law == Impact::Newton {
            material.friction = 0.0;
        }
        let grip = Grip::of(impulse, material.friction);
        let speed = body.center.v.norm() + size * body.spin.omega.abs();
        let still = body.slip(i).abs() <= STILL * speed;
        if body.turns()
            || material.restitution == 0.0
            || grip == Grip::Sticks && !still
            || body.points[i].u <= 0.0
        {
            return Err(Retry::Later);
        }
        // Errors of the place are relative to the smallest gap, which they change.
        let others = (0..body.points.len()).filter(|&j| j != i).map(|j| body.points[j].h);
        let gap = others.fold(size, f64::min);
        let [time, way, speed] =
            [clock.hi, gap, fastest].map(|unit| BOUNCE_SUM * f64::EPSILON * unit);
        let unit = Change::from([time, way, way / size, speed, speed / size]);
        let bouncing = Bouncing { body, i, law, material, grip };
        let duration = bouncing.duration().ok_or(Retry::Later)?;
        if !bouncing.may_be_alone(duration) {
            return Err(Retry::Later);
        }
        let turn = body.spin.omega.abs() * duration;
        if turn > MOST_TURN {
            return Err(Retry::Smaller(turn / MOST_TURN));
        }
        match bouncing.sum::<{ DEGREE / 2 }>(&unit) {
            Ok(sum) => self.at_limit(&bouncing, &sum, fastest),
            Err(Some([_, twice])) if twice <= HOPELESS => match bouncing.sum::<DEGREE>(&unit) {
                Ok(sum) => self.at_limit(&bouncing, &sum, fastest),
                Err(failed) => Err(failed.map_or(Retry::Later, |[most, _]| Retry::Smaller(most))),
            },
            Err(failed) => Err(failed.map_or(Retry::Later, |[_, twice]| Retry::Smaller(twice))),
        }
    }

    /// The limit of this sum, if nothing else happens before it.
    fn at_limit<const M: usize>(
        &self,
        bouncing: &Bouncing<'_>,
        sum: &Sum<M>,
        fastest: f64,
    ) -> Result<Settled, Retry> {
        let Bouncing { body, i, grip, .. } = *bouncing;
        let Some(posture) = self.record.subject.posture() else { return Err(Retry::Later) };
        let limit = sum.at(0.0).0;
        let duration = limit[0];
        // Looked at last: a change that comes after the limit does not decide at which impacts a sum is tried.
        if !(duration > 0.0 && duration <= self.log.left() && body.falls_steadily(duration)) {
            return Err(Retry::Later);
        }
        let end = bouncing.moved(&limit, 0.0);
        if let Grip::Slides(way) = grip {
            let turns = |body: &BodyState| body.slip(i) * way < -STILL * fastest;
            if turns(body) || turns(&end) {
                return Err(Retry::Later);
            }
        }
        if !bouncing.is_alone(sum, posture, &self.edges) {
            return Err(Retry::Later);
        }
        Ok(Settled { state: Moving::Turning(Box::new(end)), duration, error: sum.error })
    }
}

impl Driver<'_> {
    /// Point `i` alone has been hit by this impulse (tangential, normal), per unit mass of a body. If all its further bounces are known, moves to
    /// their limit, where it rests; an outcome: the run ends there.
    pub(super) fn bounced(&mut self, i: usize, impulse: [f64; 2]) -> Option<Option<Outcome>> {
        let due = self.bounces.follow(i, self.log.hits, FIRST_ATTEMPT);
        self.bounces.fastest = self.bounces.fastest.max(self.speed());
        if !due {
            return None;
        }
        let (material, fastest) = (self.state.material(i), self.bounces.fastest);
        let found = match &self.state {
            Moving::Turning(body) => self.limit_of_bounces(body, i, impulse, material, fastest),
            Moving::Frozen(rows) => {
                Ok(self.limit_over_rows(rows, i, impulse, material)?) // an attempt costs little
            }
        };
        match found {
            Ok(end) => Some(self.settle_at(i, end)),
            Err(retry) => {
                self.bounces.wait(retry, material.restitution, DEGREE - 1);
                None
            }
        }
    }

    /// The limit of further bounces after an impact at contact `i` in the fast loop of a body, if an attempt is due.
    pub(super) fn settles(&mut self, state: &FullState, i: usize) -> Option<Settled> {
        if !self.bounces.follow(i, self.log.hits, MANY_BOUNCES) {
            return None;
        }
        let mut body = self.state.turning()?.clone();
        body.follow(state);
        let fastest = body.center.v.norm() + self.place * body.spin.omega.abs();
        let restitution = state.body.contacts[i].restitution;
        let material = Material { friction: 0.0, restitution, tangential_restitution: 0.0 };
        match self.limit_of_bounces(&body, i, [0.0, 1.0], material, fastest) {
            Ok(end) => Some(end),
            Err(retry) => {
                self.bounces.wait(retry, restitution, DEGREE - 1);
                None
            }
        }
    }

    /// Moves to this limit.
    pub(super) fn settle_at(&mut self, i: usize, end: Settled) -> Option<Outcome> {
        self.bounces = Bounces::default();
        self.begin_sum(Tail::Collisions);
        (self.state, self.log.clock) = (end.state, self.log.clock.after(end.duration));
        self.settle(&[i], Some(ZenoMethod::Bounce), false, end.error, 0.0)
    }

    /// The limit of all further bounces of contact `i` over constant rows, in flight at the speed u after an impact with this impulse, while all
    /// others are in the air. Each bounce multiplies u by r. With π the impulse per unit landing speed,
    ///
    /// ```text
    /// T = 2u/(g(1 − r)),   J = π u/(1 − r),   ẏ_∞ = ẏ + pull T + J
    /// ```
    ///
    /// and the impulses, in proportion to the time that is left, act as a constant force J/T with a correction that the gap of the contact shows.
    fn limit_over_rows(
        &self,
        state: &Frozen,
        i: usize,
        impulse: [f64; 2],
        mut material: Material,
    ) -> Option<Settled> {
        let (space, law) = (state.space(), self.options.impact);
        if law == Impact::Newton {
            material.friction = 0.0;
        }
        let (g, u) = (space.gravity(i), state.points[i].u);
        let alone = state.points.iter().enumerate().all(|(j, p)| j == i || p.h > 0.0);
        if !(alone && g > 0.0 && u > 0.0) {
            return None;
        }
        let (slip, pulled) = (state.slip(i), space.b()[2 * i]);
        let still = slip.abs() <= STILL * self.fastest;
        let grip = Grip::of(impulse, material.friction);
        let sticks = grip == Grip::Sticks;
        if sticks && !still {
            return None;
        }
        // The next impact: a contact that sticks lands with the sliding speed of one flight.
        let next = if sticks { 0.0 } else { slip } + 2.0 * pulled * u / g;
        let w = state.impact_matrix(i);
        let [p_t, p_n] = friction::impulse(law, &w, [next, -u], &material)?;
        let r = (w.nt * p_t + w.nn * p_n - u) / u;
        if !(r > 0.0 && r < 1.0 && grip.goes_on(&w, next, [p_t, p_n], material.friction)) {
            return None;
        }
        let t = 2.0 * u / (g * (1.0 - r));
        if !(t <= self.log.left()) {
            return None;
        }
        let push = space.normal_row(i).scaled(p_n).plus(space.tangent(i), p_t);
        let total = push.scaled(1.0 / (1.0 - r));
        let mut end = state.flown(t);
        // Σ_k π u rᵏ (T − t_k) with T − t_k = T r^(k + 1): the way of these impulses.
        let way = push.scaled(t * r / (1.0 - r * r));
        end.v.add_scaled(&total, 1.0);
        end.y.add_scaled(&way, 1.0);
        // Another contact j after the k-th of these impacts, with s = rᵏ, τ s the duration of the next flight:
        //
        // u_j(s) = u_∞ + (u − u_∞) s,   h_j(r s) − h_j(s) = τ s u_j(s) − ½ g_j τ² s²   ⇒   h_j(s) = h_∞ + a s + b s²
        //
        // A contact that gravity pulls down is lowest at one of the impacts, and there not below the minimum of this parabola.
        let tau = 2.0 * u / g;
        for (j, p) in end.points.iter_mut().enumerate() {
            let (was, row) = (state.points[j], space.normal_row(j));
            let (thrown, moved, pull) = (row.dot(&total), row.dot(&way), space.gravity(j));
            (p.h, p.u) = (was.h + t * (was.u - 0.5 * pull * t) + moved, p.u + thrown);
            if j == i {
                continue;
            }
            let most = t * (was.u.abs() + t * pull.abs() + thrown.abs());
            let a = -tau * p.u / (1.0 - r);
            let b = tau * (0.5 * pull * tau - (was.u - p.u)) / (1.0 - r * r);
            let lowest =
                if a < 0.0 && -a < 2.0 * b { p.h - 0.25 * a * a / b } else { p.h.min(was.h) };
            // Beside the rounding error of its terms; one that is pulled up may come down between two impacts.
            let known = if pull >= 0.0 { STILL * (was.h + most) } else { REMAINDER_FACTOR * most };
            if lowest.min(was.h) <= known {
                return None;
            }
        }
        // At the limit the contact rests on its ground, or does not slide either; what is left of these speeds is rounding error.
        let mode = |j: usize| match j == i {
            true if sticks => Mode::Fixed,
            true => Mode::Right,
            false => Mode::Separate,
        };
        let word: ContactLetters<Mode> = (0..state.points.len()).map(mode).collect();
        end.hold(&word);
        if let Grip::Slides(way) = grip {
            let turns = |slip: f64| slip * way < -STILL * self.fastest;
            if turns(slip) || turns(end.slip(i)) {
                return None;
            }
        }
        Some(Settled { state: Moving::Frozen(Box::new(end)), duration: t, error: rounding(t, r) })
    }
}
