//! Sums of rocking: two points land in turn, each while the other one is held.
//!
//! When a point lands while another one is held, the body is in the one position in which it touches its ground with both. If the point that is
//! held does not slide, or if friction acts nowhere, the landing speed u alone determines the lap up to the next such landing: its duration
//! τ(u), its way ξ(u) along the ground, and the next landing speed R(u). Between changes of the modes within a lap all three are analytic. What
//! is left of the motion is
//!
//! ```text
//! T(u) = τ(u) + T(R(u)),   X(u) = ξ(u) + X(R(u)),   T(0) = X(0) = 0
//! ```
//!
//! which determines polynomials Σ t_m s^m and Σ x_m s^m, u = s u(1), at the places s_j, by one lap from each of these landing speeds: any law
//! of impact, any number of points, whatever happens within a lap. Without friction the body moves along the ground as if it fell freely, and X
//! is not needed.

use nalgebra::{Const, DimMin, SMatrix, ToTypenum, Vector2};

use crate::body::posture::Posture;
use crate::math::collocation::{doubt, places, steps};
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::cycles::{Lap, Limit, only_held};
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::motion::record::Tail;
use crate::motion::series::Retry;
use crate::motion::subject::Subject;
use crate::options::Options;
use crate::outcome::Outcome;
use crate::sustained::BodyState;
use crate::tolerance::{BOUNCE_CHANGE, NEXT_TERM, REMAINDER_FACTOR, TOUCH};

/// The largest degree of the polynomials. The places of half the degree are every second one of them.
const DEGREE: usize = 16;

/// Most events of a lap that is followed.
const LAP_EVENTS: usize = 256;

/// A lap: the ratio of the landing speeds, the duration in s, and the way along the ground in m.
#[derive(Debug, Clone, Copy)]
struct Lapped {
    ratio: f64,
    time: f64,
    way: f64,
}

/// T and X at s = 1, in s and m, the estimates of their errors, and the smallest 1 − R(u)/u.
struct Sum {
    time: f64,
    way: f64,
    doubt: [f64; 2],
    least: f64,
}

impl Sum {
    /// With polynomials of degree M, from the laps at every (16/M)-th place; `None`: one of them is missing.
    fn of<const M: usize>(laps: &[Option<Lapped>; DEGREE], places: &[f64; DEGREE]) -> Option<Self>
    where
        Const<M>: ToTypenum + DimMin<Const<M>, Output = Const<M>>,
    {
        let at = |j: usize| (j + 1) * (DEGREE / M) - 1;
        let places: [f64; M] = std::array::from_fn(|j| places[at(j)]);
        let (mut ratios, mut sides) = ([0.0; M], SMatrix::<f64, M, 2>::zeros());
        for (j, ratio) in ratios.iter_mut().enumerate() {
            let lap = laps[at(j)]?;
            (*ratio, sides[(j, 0)], sides[(j, 1)]) = (lap.ratio, -lap.time, -lap.way);
        }
        let terms = steps::<M>(&places, &ratios).lu().solve(&sides)?;
        let at = |k: usize, s: f64| (0..M).rev().fold(0.0, |sum, m| (sum + terms[(m, k)]) * s);
        let [time, way] = [0, 1].map(|k| at(k, 1.0));
        let doubt = [0, 1].map(|k| doubt(0.0, &places, places.map(|s| at(k, s)), NEXT_TERM));
        let least = ratios.iter().fold(1.0, |least, ratio| f64::min(least, 1.0 - ratio));
        Some(Self { time, way, doubt, least })
    }
}

/// Point `b` of a body has landed while point `k` alone is held.
struct Seesaw<'a> {
    body: &'a BodyState,
    posture: &'a Posture,
    b: usize,
    k: usize,
    /// Whether point `k` sticks; if not, friction acts nowhere.
    sticks: bool,
}

impl<'a> Seesaw<'a> {
    /// `None`: the landing speed alone does not determine what follows.
    fn of(
        body: &'a BodyState,
        posture: &'a Posture,
        b: usize,
        k: usize,
        mode: Mode,
    ) -> Option<Self> {
        let (one, two) = (&body.points[b], &body.points[k]);
        let touches = |i: &usize| body.points[*i].h <= TOUCH * posture.size();
        let free = (0..body.points.len()).filter(touches).all(|i| body.points[i].friction == 0.0);
        let sticks = mode == Mode::Fixed && two.friction > 0.0;
        let level = one.normal == two.normal
            && one.b != two.b
            && one.surface_speed == two.surface_speed
            && !body.turns();
        (level && (sticks || free)).then_some(Self { body, posture, b, k, sticks })
    }

    /// The velocity of the centre of mass while it turns at this spin about point `k`.
    fn velocity(&self, omega: f64) -> Vector2<f64> {
        let p = &self.body.points[self.k];
        let along = match self.sticks {
            true => p.touching_c() * omega + p.surface_speed,
            false => p.tangent.dot(&self.body.center.v),
        };
        p.tangent * along - p.normal * (p.b * omega)
    }

    /// The lap that begins with this landing speed, in m/s.
    fn lap(&self, options: &Options, subject: &Subject, speed: f64) -> Option<Lapped> {
        let Self { body, posture, b, k, sticks } = *self;
        let mut start = body.clone();
        let omega = -speed / (body.points[b].b - body.points[k].b);
        (start.spin.omega, start.center.v) = (omega, self.velocity(omega));
        let v = start.center.v;
        start.points.iter_mut().for_each(|p| p.u = p.normal.dot(&v) + p.b * omega);
        (start.points[b].h, start.points[b].u) = (0.0, -speed);
        (start.points[k].h, start.points[k].u) = (0.0, 0.0);
        let mut run =
            Driver::of_body(posture, start, subject.clone(), options, Vec::new(), &|| false);
        (run.resting[k], run.fastest) = (true, speed);
        run.lap = Some(Lap { lands: b, held: k, sticks, speed: None });
        run.motion();
        let (ratio, end) = (run.lap?.speed? / speed, run.state.turning()?);
        let way = end.center.r - body.center.r;
        let is_there = |i: usize| end.points[i].place.piece == body.points[i].place.piece;
        let tangent = body.points[k].tangent;
        let off =
            tangent.perp(&way).abs().max((end.spin.theta - body.spin.theta).abs() * posture.size());
        let lapped = Lapped { ratio, time: run.log.clock.hi, way: tangent.dot(&way) };
        (off <= TOUCH * posture.size() && is_there(b) && is_there(k) && ratio > 0.0 && ratio < 1.0)
            .then_some(lapped)
    }

    /// Returns true if the ground is the same all along this way of the body, in m.
    fn stays(&self, far: f64) -> bool {
        let normal = self.body.points[self.k].normal;
        (0..self.body.points.len()).all(|i| {
            let p = &self.body.points[i];
            let alike = p.normal == normal || p.h > far;
            p.depth == 0.0
                && alike
                && p.place.sides.iter().all(|side| *side > far)
                && self.body.is_far_from_others(i, self.posture, far)
        })
    }

    /// The body at the limit.
    fn end(&self, time: f64, way: f64) -> BodyState {
        let mut end = self.body.clone();
        let p = &self.body.points[self.k];
        let (along, fall) = (p.tangent.dot(&self.body.center.v), p.tangent.dot(&self.body.fall));
        let (way, speed) = match self.sticks {
            true => (way, p.surface_speed),
            false => ((along + 0.5 * fall * time) * time, along + fall * time),
        };
        (end.center.v, end.spin.omega) = (p.tangent * speed, 0.0);
        end.displace(&(p.tangent * way), &Turn::default());
        let v = end.center.v;
        end.points.iter_mut().for_each(|p| p.u = p.normal.dot(&v));
        for i in [self.b, self.k] {
            (end.points[i].h, end.points[i].u) = (0.0, 0.0);
        }
        end
    }
}

impl Driver<'_> {
    /// The outcome of the run of a lap if it ends with this landing.
    pub(super) fn ends_lap(&mut self, b: usize, word: &[Mode]) -> Option<Outcome> {
        let speed = -self.state.point(b).1;
        let lap = self.lap.as_mut()?;
        let ends = lap.lands == b
            && only_held(word) == Some(lap.held)
            && (!lap.sticks || word[lap.held] == Mode::Fixed);
        ends.then(|| {
            lap.speed = Some(speed);
            Outcome::TimeLimit
        })
    }

    /// Point `b` lands while point `k` alone is held in this mode. If the limit of all that follows is known, moves to it.
    pub(super) fn sum_rocking(
        &mut self,
        [b, k]: [usize; 2],
        mode: Mode,
    ) -> Option<Option<Outcome>> {
        if !self.rocking.follow(b, k, -self.state.point(b).1) {
            return None;
        }
        match self.limit_of_rocking(b, k, mode) {
            Ok(limit) => {
                let end = self.go_to_limit(&[b, k], limit);
                if end.is_none() {
                    self.rocking.wait(Retry::Later, DEGREE);
                }
                end
            }
            Err(retry) => {
                self.rocking.wait(retry, DEGREE);
                None
            }
        }
    }

    fn limit_of_rocking(&self, b: usize, k: usize, mode: Mode) -> Result<Limit, Retry> {
        let (subject, log) = (&self.record.subject, &self.log);
        let (Some(posture), Some(body)) = (subject.posture(), self.state.turning()) else {
            return Err(Retry::Later);
        };
        let seesaw = Seesaw::of(body, posture, b, k, mode).ok_or(Retry::Later)?;
        // A lap that outlasts the present load has no sum; on ground that accelerates ever more it would not end.
        let options =
            Options { event_limit: LAP_EVENTS, ..self.options.of_resimulated_tail(log.left()) };
        let places: [f64; DEGREE] = places();
        let mut laps = [None; DEGREE];
        let first = -body.points[b].u;
        let allowed = |sum: &Sum| {
            // A rounding error of R changes what a lap takes off by 1/(1 − r) times as much.
            let rounding = BOUNCE_CHANGE * f64::EPSILON;
            [
                rounding * (log.clock.hi + sum.time / sum.least),
                rounding * (posture.size() + sum.way.abs() / sum.least),
            ]
        };
        // How many times the error is larger than allowed, and the share of it in the sums.
        let mut error = |degree: usize| -> Result<(Sum, f64, f64), Retry> {
            let stride = DEGREE / degree;
            for j in (stride - 1..DEGREE).step_by(stride).rev() {
                if laps[j].is_none() {
                    let lap = seesaw.lap(&options, subject, places[j] * first);
                    laps[j] = Some(lap.ok_or(Retry::Later)?);
                }
            }
            let sum = match degree {
                4 => Sum::of::<4>(&laps, &places),
                8 => Sum::of::<8>(&laps, &places),
                _ => Sum::of::<DEGREE>(&laps, &places),
            };
            let sum = sum.ok_or(Retry::Later)?;
            let allowed = allowed(&sum);
            let most = (sum.doubt[0] / allowed[0]).max(sum.doubt[1] / allowed[1]);
            let whole = sum.time.max(f64::MIN_POSITIVE);
            let share = (sum.doubt[0] / whole).max(sum.doubt[1] / posture.size());
            Ok((sum, most, share))
        };
        let mut degree = 4;
        let sum = loop {
            let (sum, most, share) = error(degree)?;
            if most <= 1.0 {
                break sum;
            }
            // Twice the degree squares the share of the error.
            let last = (1..DEGREE / degree).fold(most, |last, _| last * share);
            if degree == DEGREE || last > 1.0 {
                return Err(Retry::Smaller(last));
            }
            degree *= 2;
        };
        let (t, v) = (sum.time, REMAINDER_FACTOR * first);
        if !(t > 0.0 && t <= log.left() && body.falls_steadily(t)) {
            return Err(Retry::Later);
        }
        let size = posture.size();
        let omega = (first / (body.points[b].b - body.points[k].b)).abs();
        let along = body.points[k].tangent.dot(&body.center.v).abs();
        let fall = body.points[k].tangent.dot(&body.fall).abs();
        let far = t * (v + REMAINDER_FACTOR * size * omega + along + fall * t);
        let moves = !seesaw.sticks || sum.way.abs() > TOUCH * size;
        if moves && !(seesaw.stays(far) && self.edges.stay_off(posture, body, |_| far)) {
            return Err(Retry::Later);
        }
        Ok(Limit {
            end: Moving::Turning(Box::new(seesaw.end(t, sum.way))),
            duration: t,
            tail: Tail::Collisions,
            repeats: true,
            certified: false,
            error: sum.doubt[0] + allowed(&sum)[0],
        })
    }
}
