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
//! The iteration converges as that of Picard for a differential equation does. In constant geometry only c_1 and c_2 differ from zero, and the
//! first iterate is exact. Terms of higher order are the effect of the rotation. The last coefficients in Chebyshev's polynomials estimate the
//! error.
//!
//! If the contact slides in one direction through all impacts, their impulses are (−σμ, 1) P, and every law returns e: r = e. The ratio of the
//! sliding speed v_k to the landing speed u_k is v_∞/u_k plus a constant: it grows once v_k has the sign of its limit, so a contact that
//! slides now goes on to slide. One that sticks now goes on to stick only if v_∞ = 0. Then its sliding speed before an impact is that of one
//! flight, a_t τ = 2a_t u/g, in proportion to u; Moreau's law returns e, Poisson's and Stronge's another fraction of u. Where an impact neither stops it nor slides throughout, its bounces are followed one by one: with tangential restitution, with
//! Chatterjee and Ruina's law, and where the slide turns back in each impact.

use nalgebra::{SMatrix, SVector, Vector2};

use crate::body::contact::PerContact;
use crate::body::posture::Posture;
use crate::collisions::full::FullState;
use crate::flight::{GapArc, parabola_touchdown};
use crate::impact::friction::{self, Material, Matrix};
use crate::math::collocation::{DEGREE, doubt, places, steps};
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::any::AnyContacts;
use crate::motion::driver::{Coordinates, Driver};
use crate::motion::frame::Snapshot;
use crate::motion::pair::Pair;
use crate::motion::record::Motion;
use crate::options::Impact;
use crate::outcome::{Method, Outcome};
use crate::sustained::BodyState;
use crate::tolerance::{BOUNCE_CHANGE, BOUNCE_SUM, NEXT_TERM, REMAINDER_FACTOR, STILL};

/// Number of impacts of the contact before the first attempt to sum its bounces.
const FIRST_ATTEMPT: usize = 2;

/// Most iterations.
const ITERATIONS: usize = 20;

/// Intervals of s in which the gaps of other contacts are bounded.
const INTERVALS: usize = 32;

/// t, way along the ground, θ, speed along the ground, ω; relative to the present state.
type Change = SVector<f64, 5>;
type Changes = SMatrix<f64, DEGREE, 5>;

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
}

/// All further bounces of a contact, as a function of s.
struct Sum {
    /// The coefficients c_m, m = 1, 2, …
    terms: Changes,
    /// The coefficients a_m of the speed u, m = 1, 2, …
    speeds: SVector<f64, { DEGREE + 1 }>,
    /// Estimate of the error of the time, in s.
    error: f64,
}

impl Sum {
    /// The change up to s, and the speed u there.
    fn at(&self, s: f64) -> (Change, f64) {
        let (mut power, mut change, mut speed) = (1.0, Change::zeros(), 0.0);
        for m in 0..=DEGREE {
            power *= s;
            speed += self.speeds[m] * power;
            if m < DEGREE {
                change += self.terms.row(m).transpose() * (power - 1.0);
            }
        }
        (change, speed)
    }
}

/// One contact, on the ground after an impact.
struct Bouncing<'a> {
    body: &'a BodyState,
    i: usize,
    law: Impact,
    material: Material,
    grip: Grip,
}

impl Bouncing<'_> {
    /// The body after this change of state, with the contact on the ground and the speed `u` at which it takes off.
    fn moved(&self, change: &Change, u: f64) -> BodyState {
        let mut after = self.body.clone();
        let [_, way, angle, speed, spin] = (*change).into();
        let (p, frozen) = (self.body.points[self.i], self.body.frozen.is_some());
        let turn = Turn::by(angle);
        let (b, c) = if frozen { (p.b, p.c) } else { p.turned(&turn) };
        let rise = if frozen { -p.b * angle } else { p.c * turn.one_minus_cos - p.b * turn.sin };
        let way = p.tangent * way + p.normal * rise;
        after.center.r += way;
        after.spin.theta += angle;
        after.spin.omega += spin;
        let omega = after.spin.omega;
        let along = match self.grip {
            Grip::Sticks => c * omega,
            Grip::Slides(_) => p.tangent.dot(&after.center.v) + speed,
        };
        after.center.v = p.tangent * along + p.normal * (u - b * omega);
        for q in &mut after.points {
            let arm = q.arm();
            let side = Vector2::new(-arm.y, arm.x);
            let turned =
                if frozen { side * angle } else { side * turn.sin - arm * turn.one_minus_cos };
            let moved = way + turned;
            q.h += q.normal.dot(&moved);
            for (k, side) in q.place.sides.iter_mut().enumerate() {
                let axis = q.place.across[k] * if k == 0 { 1.0 } else { -1.0 };
                if *side < f64::INFINITY {
                    *side = (*side + axis.dot(&moved)).max(0.0);
                }
            }
            if !frozen {
                (q.b, q.c) = q.turned(&turn);
            }
            q.u = q.normal.dot(&after.center.v) + q.b * omega;
        }
        (after.points[self.i].h, after.points[self.i].u) = (0.0, u);
        after
    }

    /// F from this state, and u' − r u. `None`: the contact does not come down, or friction does something else in the impact.
    fn bounce(&self, from: &Change, u: f64, ratio: f64) -> Option<(Change, f64)> {
        let (p, rho2) = (&self.body.points[self.i], self.body.rho2);
        let (g, along) = (self.body.pull(self.i), p.tangent.dot(&self.body.fall));
        let frozen = self.body.frozen.is_some();
        let [b, c] = if frozen { [p.b, p.c] } else { p.turned(&Turn::by(from[2])).into() };
        let omega = self.body.spin.omega + from[4];
        let v = match self.grip {
            Grip::Sticks => c * omega,
            Grip::Slides(_) => p.tangent.dot(&self.body.center.v) + from[3],
        };
        // The landing speed is u − d.
        let (dt, turn, d) = if frozen || omega == 0.0 {
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
        let slip = if self.grip == Grip::Sticks { 0.0 } else { v - c * omega };
        let slip = slip + along * dt - omega * bent;
        let [b, c] = turn.turned([b, c]);
        let w = Matrix { nn: 1.0 + b * b / rho2, nt: -b * c / rho2, tt: 1.0 + c * c / rho2 };
        let [t, n] = friction::impulse(self.law, &w, [slip, -landing], &self.material)?;
        if self.grip != Grip::of([t, n], self.material.friction) {
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

    /// All further bounces; `None` if this polynomial is less accurate than `unit`, beside the rounding error of the changes.
    fn sum(&self, unit: &Change) -> Option<Sum> {
        let u = self.body.points[self.i].u;
        let places = places();
        let (mut ratio, mut matrices) = (f64::NAN, None);
        let (mut changes, mut speeds) = ([Change::zeros(); DEGREE], places.map(|s| s * u));
        let mut last = Change::zeros();
        for k in 0..ITERATIONS {
            let now = self.ratio(&last)?;
            if now != ratio {
                (ratio, matrices) = (now, None);
            }
            let (mut gains, mut excess) = (Changes::zeros(), SVector::<f64, DEGREE>::zeros());
            for j in 0..DEGREE {
                let (gain, more) = self.bounce(&changes[j], speeds[j], ratio)?;
                gains.set_row(j, &gain.transpose());
                excess[j] = more;
            }
            let (one, other) = matrices.get_or_insert_with(|| {
                let step = |shift| steps(&places, &[ratio; DEGREE], shift);
                (step(0).lu(), (step(1) * ratio).lu())
            });
            let (terms, high) = (one.solve(&gains)?, other.solve(&excess)?);
            let mut speed = SVector::<f64, { DEGREE + 1 }>::zeros();
            speed[0] = u - high.sum();
            speed.fixed_rows_mut::<DEGREE>(1).copy_from(&high);
            let mut sum = Sum { terms, speeds: speed, error: 0.0 };
            let (limit, _) = sum.at(0.0);
            let allowed = unit + limit.abs() * (BOUNCE_CHANGE * f64::EPSILON);
            let within = |change: Change| (0..5).all(|k| change[k].abs() <= allowed[k]);
            for j in 0..DEGREE {
                (changes[j], speeds[j]) = sum.at(places[j]);
            }
            if speeds.iter().any(|speed| !(*speed > 0.0)) {
                return None;
            }
            if k > 0 && within(limit - last) {
                let doubt = Change::from_fn(|k, _| {
                    doubt(limit[k], changes.iter().map(|change| change[k]), NEXT_TERM)
                });
                sum.error = doubt[0] + allowed[0];
                return within(doubt).then_some(sum);
            }
            last = limit;
        }
        None
    }
}

impl Bouncing<'_> {
    /// Whether no other contact lands, no end of the ground is passed and no other piece of it is met before the limit.
    fn is_alone(&self, sum: &Sum, posture: &Posture) -> bool {
        let (body, p) = (self.body, &self.body.points[self.i]);
        let (duration, size) = (sum.at(0.0).0[0], posture.size());
        let at = |k: usize| sum.at(1.0 - k as f64 / INTERVALS as f64);
        let spin = |k: usize| (body.spin.omega + at(k).0[4]).abs();
        let omega = (0..=INTERVALS).map(spin).fold(0.0, f64::max);
        // The sum of all normal impulses stops the fall of the contact.
        let fall = duration * (body.gravity + size * omega * omega);
        let push = REMAINDER_FACTOR * (fall + p.u) * (1.0 + self.material.friction);
        let drift = body.center.v.norm() + fall + push;
        let way = |j: usize| {
            let arm = body.points[j].arm().norm();
            duration * (drift + arm * (omega + push * size / body.rho2))
        };
        let near = |j: usize| j != self.i && body.points[j].h <= way(j);
        let within_ground = (0..body.points.len()).all(|j| {
            let q = &body.points[j];
            q.depth == 0.0
                && q.place.sides.iter().all(|side| *side > way(j))
                && body.is_far_from_others(j, posture, way(j))
        });
        if !within_ground || !(0..body.points.len()).any(near) {
            return within_ground;
        }
        let (mut time, mut flight) = (0.0, 0.0);
        let mut from = body.clone();
        (1..=INTERVALS).all(|k| {
            let (change, u) = at(k);
            let to = self.moved(&change, u);
            // During a bounce a point leaves the curve through its states after impacts by no more than this time allows.
            flight = f64::max(flight, 2.0 * p.u / from.arc(self.i).effective_gravity());
            let stays = (0..body.points.len()).filter(|&j| near(j)).all(|j| {
                let (a, b) = (&from.points[j], &to.points[j]);
                let pull = body.pull(j).abs() + a.arm().norm() * omega * omega;
                let speed = REMAINDER_FACTOR.sqrt() * (a.u.abs().max(b.u.abs()) + pull * flight);
                a.h + b.h > speed * (change[0] - time)
            });
            time = change[0];
            from = to;
            stays
        })
    }
}

/// Impacts of one contact, one after the other.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Bounces {
    point: usize,
    hits: usize,
    /// The largest speed of the body after these impacts, in m/s.
    fastest: f64,
}

impl Bounces {
    /// `speed`: of the body after the impact, in m/s.
    fn follow(&mut self, point: usize, speed: f64) {
        if point != self.point {
            *self = Self { point, ..Self::default() };
        }
        self.hits += 1;
        self.fastest = self.fastest.max(speed);
    }
}

/// The end of a sum of bounces.
#[derive(Debug, Clone)]
pub(super) struct Settled {
    pub(super) body: BodyState,
    /// Time until then, and the estimate of its error, in s.
    pub(super) duration: f64,
    pub(super) error: f64,
}

impl<C> Driver<'_, C> {
    /// All bounces of point `i` that follow an impact with this impulse (tangential, normal) per unit mass, if their limit is known and
    /// nothing else happens before it. `fastest`: the largest speed that the errors are compared with, in m/s.
    pub(super) fn limit_of_bounces(
        &self,
        body: &BodyState,
        i: usize,
        impulse: [f64; 2],
        mut material: Material,
        fastest: f64,
    ) -> Option<Settled> {
        let posture = self.record.base.posture.as_ref()?;
        let (size, clock, law) = (posture.size(), self.log.clock, self.options.impact);
        if law == Impact::Newton {
            material.friction = 0.0;
        }
        let grip = Grip::of(impulse, material.friction);
        let speed = body.center.v.norm() + size * body.spin.omega.abs();
        let still = body.slip(i).abs() <= STILL * speed;
        if material.restitution == 0.0
            || grip == Grip::Sticks && !still
            || body.points[i].u <= 0.0
            || body.frozen.is_some_and(|square| square > 0.0)
        {
            return None;
        }
        // Errors of the place are relative to the smallest gap, which they change.
        let others = (0..body.points.len()).filter(|&j| j != i).map(|j| body.points[j].h);
        let gap = others.fold(size, f64::min);
        let [time, way, speed] =
            [clock.hi, gap, fastest].map(|unit| BOUNCE_SUM * f64::EPSILON * unit);
        let unit = Change::from([time, way, way / size, speed, speed / size]);
        let bouncing = Bouncing { body, i, law, material, grip };
        let sum = bouncing.sum(&unit)?;
        let limit = sum.at(0.0).0;
        let duration = limit[0];
        if !(duration > 0.0 && clock.hi + duration <= self.log.end) {
            return None;
        }
        let end = bouncing.moved(&limit, 0.0);
        if let Grip::Slides(way) = grip {
            let turns = |body: &BodyState| body.slip(i) * way < -STILL * fastest;
            if turns(body) || turns(&end) {
                return None;
            }
        }
        if !bouncing.is_alone(&sum, posture) || self.edges.is_inside(posture, &end) {
            return None;
        }
        Some(Settled { body: end, duration, error: sum.error })
    }
}

impl Driver<'_, AnyContacts> {
    /// Point `i` alone has been hit by this impulse (tangential, normal) per unit mass. If all its further bounces are known, moves to their
    /// limit, where it rests; an outcome: the run ends there.
    pub(super) fn bounced(&mut self, i: usize, impulse: [f64; 2]) -> Option<Option<Outcome>> {
        let state = &self.body.state;
        let speed = state.center.v.norm() + self.body.posture.size() * state.spin.omega.abs();
        self.body.bounces.follow(i, speed);
        let Bounces { hits, fastest, .. } = self.body.bounces;
        // Each attempt costs about as much as the bounces between two of them.
        if !(hits >= FIRST_ATTEMPT && hits.is_power_of_two()) {
            return None;
        }
        let end = self.limit_of_bounces(state, i, impulse, self.material(i), fastest)?;
        self.log.enter(&PerContact::from_elem(Mode::Separate, end.body.points.len()));
        if self.log.record {
            let (start, fastest) = (Box::new(self.body.state.clone()), self.body.fastest);
            self.write(Motion::Cycles { start, fastest });
        }
        self.log.clock = self.log.clock.after(end.duration);
        self.body.state = end.body;
        self.body.bounces = Bounces::default();
        Some(self.settle(&[i], false, end.error, 0.0))
    }
}

impl Driver<'_, Pair> {
    /// As [`Driver::bounced`], after an impact at contact `i` in the full model.
    pub(super) fn settles(&self, state: &FullState, i: usize) -> Option<Box<Settled>> {
        let now = Snapshot::of_full(state, self.log.clock);
        let body = self.record.base.body_state(&now, None)?;
        let posture = self.record.base.posture.as_ref()?;
        let speed = body.center.v.norm() + posture.size() * body.spin.omega.abs();
        let restitution = state.body.contacts[i].restitution;
        let material = Material { friction: 0.0, restitution, tangential_restitution: 0.0 };
        self.limit_of_bounces(&body, i, [0.0, 1.0], material, speed).map(Box::new)
    }

    /// Moves to this limit.
    pub(super) fn settle_at(&mut self, i: usize, end: &Settled) -> Option<Outcome> {
        self.log.enter(&[Mode::Separate; 2][..self.body.count]);
        let now = self.full();
        let fastest = Pair::largest_speed(self);
        let start = self.record.base.body_state(&now, None).filter(|_| self.log.record);
        if let Some(start) = start {
            self.write(Motion::Cycles { start: Box::new(start), fastest });
        }
        self.log.clock = self.log.clock.after(end.duration);
        self.leave(&end.body, None);
        self.come_to_rest([i == 0, i == 1], Method::Bounce, false, end.error)
    }
}
