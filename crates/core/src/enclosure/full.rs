//! Enclosures of the collisions of the full model.
//!
//! Flights are those of `flight.rs`, h(t) = h + ut − gt²/2 − (1 − cos ωt) c − (ωt − sin ωt) b. Impacts are those of
//! `collisions/full/mod.rs`. Both are computed in balls. If g > ω²√(b² + c²), a gap is concave. It then has one root at which it decreases,
//! which an interval Newton step proves; and any other concave gap that is positive at that time has been positive since the start. If a
//! gap is not concave, nothing is certain.

use crate::body::contact::quarter_turns;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::enclosure::{Claims, NOTHING, ball};
use crate::flight::GapArc;
use crate::math::ball::Ball;
use crate::math::real::Enclosed;
use crate::math::turn::Turn;
use crate::options::Options;
use crate::outcome::{Bounds, ContactNumber, EnclosedZeno, Enclosure, Uncertain};
use crate::tolerance::FLIGHT_UNRESOLVED;
use crate::verified::{Gap, Model};

/// Number of terms of the series of sine and cosine. The truncated rest is below `LEFT_OUT` up to an angle of one.
const TERMS: usize = 15;
const LEFT_OUT: f64 = 1e-35;
/// Largest angle for which the functions are evaluated, in rad. Each doubling of the angle costs one or two bits.
const FARTHEST: f64 = 1e12;

/// sin x, 1 − cos x and x − sin x by their series.
struct Sine {
    /// (−1)ⁿ/(2n + 3)! and (−1)ⁿ/(2n + 2)!
    x_minus_sin: [Ball; TERMS],
    one_minus_cos: [Ball; TERMS],
}

impl Sine {
    fn new() -> Option<Self> {
        let (mut x_minus_sin, mut one_minus_cos) = ([Ball::ZERO; TERMS], [Ball::ZERO; TERMS]);
        let mut last = ball(1.0);
        for n in 0..TERMS {
            let k = 2.0 * n as f64;
            one_minus_cos[n] = last.over(ball(k + 2.0))?;
            x_minus_sin[n] = one_minus_cos[n].over(ball(k + 3.0))?;
            last = -x_minus_sin[n];
        }
        Some(Self { x_minus_sin, one_minus_cos })
    }

    fn of(&self, x: Ball) -> Turn<Ball> {
        if x.is_zero() {
            return Turn { sin: Ball::ZERO, one_minus_cos: Ball::ZERO, x_minus_sin: Ball::ZERO };
        }
        if x.size() > FARTHEST {
            let any = |middle: f64| ball(middle).widened(1.0);
            return Turn { sin: any(0.0), one_minus_cos: any(1.0), x_minus_sin: x.widened(1.0) };
        }
        if x.size() > 1.0 {
            // sin 2x = 2 sin x cos x, 1 − cos 2x = 2 sin²x
            let half = self.of(x.scaled(0.5));
            let sin = (half.sin * (ball(1.0) - half.one_minus_cos)).scaled(2.0);
            return Turn {
                sin,
                one_minus_cos: half.sin.square().scaled(2.0),
                x_minus_sin: x - sin,
            };
        }
        let y = x.square();
        let sum = |terms: &[Ball; TERMS]| {
            let whole = terms.iter().rev().fold(Ball::ZERO, |sum, term| sum * y + *term);
            whole.widened(LEFT_OUT)
        };
        let x_minus_sin = x * y * sum(&self.x_minus_sin);
        Turn { sin: x - x_minus_sin, one_minus_cos: y * sum(&self.one_minus_cos), x_minus_sin }
    }
}

/// One contact.
#[derive(Clone, Copy)]
struct Foot {
    h: Ball,
    u: Ball,
    b: Ball,
    c: Ball,
    g: Ball,
    e: Ball,
}

impl Foot {
    fn arc(&self, omega: Ball) -> GapArc<Ball> {
        let Self { h, u, b, c, g, .. } = *self;
        GapArc { h, u, g, b, c, omega }
    }

    /// Largest centripetal term of the rotation, to be compared with gravity: ω²√(b² + c²).
    fn lift(&self, omega: Ball) -> Option<Ball> {
        Some(omega.square() * (self.b.square() + self.c.square()).root()?)
    }

    /// Returns true if the contact certainly does not enter the terrain at once.
    fn starts(&self) -> bool {
        self.h.is_positive() || self.h.is_zero() && self.u.is_not_negative()
    }

    /// The time of touchdown, computed in doubles.
    fn guess(&self, omega: Ball) -> f64 {
        let [h, u, b, c, g, omega] =
            [self.h, self.u, self.b, self.c, self.g, omega].map(Ball::middle);
        let arc = GapArc { h: h.max(0.0), u: if h > 0.0 { u } else { u.max(0.0) }, g, b, c, omega };
        if h == 0.0 && u < 0.0 { 0.0 } else { arc.touchdown().unwrap_or(f64::INFINITY) }
    }
}

/// The end of a flight.
struct Landing {
    contact: usize,
    dt: Ball,
    turn: Turn<Ball>,
    /// Normal speed at touchdown.
    s: Ball,
}

/// The state of the enclosure of a motion.
struct FullEnclosure<'a> {
    sine: Sine,
    feet: Vec<Foot>,
    omega: Ball,
    rho2: Ball,
    n12: Ball,
    claims: Claims<'a>,
}

const SHORT_ONES: usize = 8;
/// Factor that covers the rounding errors of a few products.
const ROUNDED: f64 = 1.0 + 64.0 * f64::EPSILON;

/// The contacts of a body at its start, and n_1·n_2. `local`: in the geometry of the local model. A contact slightly below the terrain, by
/// no more than is allowed for a start, counts as touching.
fn feet_of(sine: &Sine, posture: &Posture, state: &State, local: bool) -> (Vec<Foot>, Ball) {
    let fields = posture.fields();
    let [x, y, theta] = [state.q.x, state.q.y, state.q.z].map(ball);
    let [vx, vy, omega] = [state.qdot.x, state.qdot.y, state.qdot.z].map(ball);
    let spin = sine.of(if local { Ball::ZERO } else { theta });
    let dot = |a: [Ball; 2], b: [Ball; 2]| a[0] * b[0] + a[1] * b[1];
    let contacts = posture.contacts().iter().zip(posture.geometry());
    let (feet, normals): (Vec<Foot>, Vec<[Ball; 2]>) = contacts
        .map(|(contact, geometry)| {
            let slope = sine.of(ball(contact.slope));
            let [cos, sin] = match quarter_turns(contact.slope) {
                Some(exact) => exact.map(ball),
                None => [ball(1.0) - slope.one_minus_cos, slope.sin],
            };
            let (tangent, normal) = ([cos, sin], [-sin, cos]);
            let d = [0, 1].map(|k| ball(contact.point[k]) - ball(fields.center_of_mass[k]));
            // R(θ)d − d
            let moved = [
                -(spin.one_minus_cos * d[0] + spin.sin * d[1]),
                spin.sin * d[0] - spin.one_minus_cos * d[1],
            ];
            let arm = [d[0] + moved[0], d[1] + moved[1]];
            let (b, c) = (dot(tangent, arm), dot(normal, arm));
            let turned = if local { b * theta } else { Ball::ZERO };
            let h = dot(normal, [x + moved[0], y + moved[1]]) + turned;
            let foot = Foot {
                h: if h.is_negative() { Ball::ZERO } else { h },
                u: dot(normal, [vx, vy]) + b * omega,
                b,
                c,
                g: ball(fields.gravity) * cos,
                e: ball(geometry.restitution),
            };
            (foot, normal)
        })
        .unzip();
    let n12 = match normals[..] {
        [one, two] => dot(one, two),
        _ => Ball::ZERO,
    };
    (feet, n12)
}

/// The local model of a body, and its start.
pub(super) fn local_of(posture: &Posture, state: &State) -> Option<(Model<Ball>, [Gap<Ball>; 2])> {
    let (feet, n12) = feet_of(&Sine::new()?, posture, state, true);
    let rho2 = ball(posture.fields().gyration_radius).square();
    let gap = |i: usize| feet.get(i).map_or(Gap::REST, |foot| Gap { h: foot.h, u: foot.u });
    let each = |of: fn(&Foot) -> Ball| [0, 1].map(|i| feet.get(i).map_or(Ball::ZERO, of));
    let psi = match feet[..] {
        [one, two] => {
            let cross = one.b * two.b + rho2 * n12;
            [(-cross).over(one.b.square() + rho2)?, (-cross).over(two.b.square() + rho2)?]
        }
        _ => [Ball::ZERO; 2],
    };
    let model = Model::new(each(|foot| foot.g), psi, each(|foot| foot.e), feet.len());
    Some((model, [gap(0), gap(1)]))
}

impl<'a> FullEnclosure<'a> {
    fn new(
        posture: &Posture,
        state: &State,
        options: &Options,
        cancel: &'a dyn Fn() -> bool,
    ) -> Option<Self> {
        let sine = Sine::new()?;
        let (feet, n12) = feet_of(&sine, posture, state, false);
        Some(Self {
            sine,
            omega: ball(state.qdot.z),
            rho2: ball(posture.fields().gyration_radius).square(),
            n12,
            claims: Claims::new(feet.len(), options, cancel),
            feet,
        })
    }

    /// The touchdown of contact i near the time `guess`. The other contact is not considered.
    fn landing(&self, i: usize, guess: f64) -> Option<Landing> {
        let (foot, omega) = (&self.feet[i], self.omega);
        let arc = foot.arc(omega);
        if foot.h.is_zero() && foot.u.is_negative() {
            let turn = self.sine.of(Ball::ZERO);
            return Some(Landing { contact: i, dt: Ball::ZERO, turn, s: -foot.u });
        }
        let lift = foot.lift(omega)?;
        if !(foot.g - lift).is_positive() || !foot.starts() || !guess.is_finite() {
            return None;
        }
        // Two Newton steps in balls refine the guess; an interval Newton step then proves the root.
        let mut t = ball(guess);
        for _ in 0..2 {
            let turn = self.sine.of(omega * t);
            let step = arc.gap_turned(t, &turn).over(arc.rate_turned(t, &turn))?;
            t = (t - step).center();
        }
        let turn = self.sine.of(omega * t);
        let rest = arc.gap_turned(t, &turn).size();
        let slope = arc.rate_turned(t, &turn);
        if !slope.is_negative() {
            return None;
        }
        let reach = 4.0 * rest / slope.clearance();
        let least = slope.clearance() - 2.0 * (foot.g + lift).size() * reach;
        // The Newton step must be at most half the radius of the interval over which the slope was bounded.
        if !(least > 0.0 && 2.0 * rest <= least * reach && t.widened(reach).is_positive()) {
            return None;
        }
        let off = rest / least * ROUNDED;
        let dt = t.widened(off);
        let turned = 2.0 * omega.size() * off * ROUNDED;
        let wide = |x: Ball| x.widened(turned);
        let turn = Turn {
            sin: wide(turn.sin),
            one_minus_cos: wide(turn.one_minus_cos),
            x_minus_sin: wide(turn.x_minus_sin),
        };
        Some(Landing { contact: i, s: -arc.rate_turned(dt, &turn), dt, turn })
    }

    /// The first touchdown.
    fn first(&self) -> Result<Landing, Uncertain> {
        let guesses: Vec<f64> = self.feet.iter().map(|foot| foot.guess(self.omega)).collect();
        let order: &[usize] = if guesses.len() == 1 {
            &[0]
        } else if guesses[1] < guesses[0] {
            &[1, 0]
        } else {
            &[0, 1]
        };
        // A concave gap that is positive at that time has been positive since the start.
        let concave =
            |foot: &Foot| foot.lift(self.omega).is_some_and(|lift| (foot.g - lift).is_positive());
        let clear = |i: usize, landing: &Landing| {
            let foot = &self.feet[i];
            let later = || {
                concave(foot)
                    && foot.arc(self.omega).gap_turned(landing.dt, &landing.turn).is_positive()
            };
            foot.starts() && (landing.dt.is_zero() || later())
        };
        for &i in order {
            if let Some(landing) = self.landing(i, guesses[i])
                && order.iter().all(|&j| j == i || clear(j, &landing))
            {
                return Ok(landing);
            }
        }
        let spins = !self.feet.iter().all(concave);
        Err(if spins { Uncertain::Spin } else { Uncertain::Order })
    }

    fn collide(&mut self) -> Result<Ball, Uncertain> {
        let Landing { contact: i, dt, turn, s } = self.first()?;
        if !s.is_positive() {
            return Err(Uncertain::Order);
        }
        self.claims.collide(i, dt)?;
        for (j, foot) in self.feet.iter_mut().enumerate() {
            let arc = foot.arc(self.omega);
            let (h, u) = (arc.gap_turned(dt, &turn), arc.rate_turned(dt, &turn));
            [foot.b, foot.c] = turn.turned([foot.b, foot.c]);
            (foot.h, foot.u) = if j == i { (Ball::ZERO, -s) } else { (h, u) };
        }
        let Foot { b, e, .. } = self.feet[i];
        let blow = ((ball(1.0) + e) * s).over(b.square() + self.rho2).ok_or(Uncertain::Order)?;
        self.feet[i].u = e * s;
        if let Some(other) = self.feet.get_mut(1 - i) {
            other.u = other.u + (b * other.b + self.rho2 * self.n12) * blow;
        }
        self.omega = self.omega + b * blow;
        Ok(dt)
    }

    /// Contacts that rest from the start under gravity.
    fn resting(&self) -> Vec<usize> {
        let rests = |foot: &Foot| foot.h.is_zero() && foot.u.is_zero() && foot.g.is_positive();
        let all: Vec<usize> = (0..self.feet.len()).filter(|&i| rests(&self.feet[i])).collect();
        let apart =
            |i: usize| self.feet.iter().enumerate().all(|(j, f)| j == i || f.h.is_positive());
        match all[..] {
            _ if !self.omega.is_zero() => Vec::new(),
            [i] if apart(i) => all,
            [_, _] => {
                let cross = self.feet[0].b * self.feet[1].b + self.rho2 * self.n12;
                if cross.is_negative() || cross.is_zero() { all } else { Vec::new() }
            }
            _ => Vec::new(),
        }
    }

    fn run(&mut self) -> Result<EnclosedZeno, Uncertain> {
        let resting = self.resting();
        if !resting.is_empty() {
            let contacts = resting.into_iter().map(ContactNumber::of).collect();
            return Ok(EnclosedZeno { contacts, elapsed: Bounds { low: 0.0, high: 0.0 } });
        }
        let mut short = 0;
        loop {
            let dt = self.collide()?;
            let brief = dt.size() <= FLIGHT_UNRESOLVED * self.claims.clock.middle();
            short = if brief { short + 1 } else { 0 };
            if short == SHORT_ONES {
                return Err(Uncertain::Rest);
            }
        }
    }
}

/// Encloses the collisions of the full model; `None` if cancelled.
pub(crate) fn enclose_full(
    posture: &Posture,
    state: &State,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Enclosure> {
    let Some(mut course) = FullEnclosure::new(posture, state, options, cancel) else {
        return Some(NOTHING);
    };
    let end = course.run();
    course.claims.end(end)
}
