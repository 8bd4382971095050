//! Verified enclosures of a motion: intervals that contain the time of each collision and, in the local model, the time of the
//! Zeno point at which the collisions accumulate.
//!
//! This file has the local model, `full.rs` the full model. Flights and impacts are those of `collisions/local.rs`, in balls of 106 bits.
//! If the balls of two touchdown times are disjoint, they show which contact lands first; otherwise the enclosure ends with a reason. Two
//! theorems enclose the infinitely many impacts that remain. The parameters are taken to be exactly the given doubles.
//!
//! Gravity may press a contact to its ground (g_i > 0), pull it off (g_i < 0), or neither. The enclosure also ends if the sign of g_i
//! matters and the ball of g_i contains both signs.
//!
//! **Bouncing** at a, after an impact there, for g_a > 0 [docs/theory.md, "Zeno points"]: the duration is T = 2u_a/(g_a(1 − e_a)), provided
//! that the gap of b stays positive.
//!
//! **Clattering**, provided that no g_i is negative. After an impact at a, let b be the contact that is hit next. Let k_i = (1 + e_i)ψ_i;
//! let c_b = 1/(k_b − e_b c_a) and likewise c_a, the smaller solution of these two equations; let r_i = e_i c_1c_2 < 1; and
//!
//! ```text
//! d = −u_b − c_b u_a,   T0 = h_b/d,   w = c_b u_a/|u_b|,   ν = h_b/(2u_a|u_b|),   G = g_b + c_b g_a.
//! ```
//!
//! A flight of duration τ and the impact at b, with s = −u_b + g_bτ, give *exactly* d' = (d + Gτ)/c_b, and
//!
//! ```text
//! w' ≤ r_b/(1 + r_b − w),   ν' ≤ ν w²w'/(c_b²c_a e_b²),   0 ≤ T0 − τ − T0' ≤ G T0²/(2d),   T0' ≤ w T0.
//! ```
//!
//! Once d is known, u_b = −(d + c_b u_a). Then only the gravity terms cancel from impact to impact, and relative errors add up instead of
//! multiplying.
//!
//! The bound of w over two impacts has the fixed points 1 and W* = r_a(1 + r_b)/(1 + r_a). Suppose that d > 0 and w < 1, and let W_b =
//! max(w, W*) < 1 and W_a = r_b/(1 + r_b − W_b). Then all later w are at most W_b before impacts at b, and at most W_a before impacts at a.
//! The next impact is at the other contact if g_aν < 1 (b lands before a). The contacts alternate for ever if g_aν < 1, g_b ν f_b < 1 and
//! f_1f_2 < 1, with f_b = W_b²W_a/(c_b²c_a e_b²). The remaining time is then between T0 − L and T0,
//!
//! ```text
//! L = T0²/(2d) · (G_b + c_b W_b² G_a)/(1 − c_1c_2 W_1²W_2²).
//! ```

use crate::body::local_model::LocalModel;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::collisions::log::CHUNK;
use crate::impact::newton;
use crate::math::ball::Ball;
use crate::math::real::Enclosed;
use crate::options::Options;
use crate::outcome::{Bounds, ContactNumber, EnclosedImpact, EnclosedZeno, Enclosure, Uncertain};
use crate::tolerance::NARROW_ENOUGH;

mod full;

pub(crate) use full::enclose_full;

/// The enclosures proved so far.
struct Claims<'a> {
    /// Time elapsed.
    clock: Ball,
    impacts: Vec<EnclosedImpact>,
    event_limit: usize,
    /// Longest time, in s.
    time: f64,
    cancel: &'a dyn Fn() -> bool,
    cancelled: bool,
}

impl<'a> Claims<'a> {
    /// For a body with `count` contacts. The event limit is that of a recorded run, because the enclosures are always stored.
    fn new(count: usize, options: &Options, cancel: &'a dyn Fn() -> bool) -> Self {
        Self {
            clock: Ball::ZERO,
            impacts: Vec::new(),
            event_limit: Options { record: true, ..*options }.events(count),
            time: options.end(),
            cancel,
            cancelled: false,
        }
    }

    /// The time elapsed after a further `dt` ≥ 0. Its lower bound is at least that of the last impact.
    fn after(&self, dt: Ball) -> Bounds {
        let [low, high] = (self.clock + dt).bounds();
        let last = self.impacts.last().map_or(0.0, |impact| impact.elapsed.low);
        Bounds { low: low.max(last), high }
    }

    /// Stores a collision of contact i after a further `dt`.
    fn collide(&mut self, i: usize, dt: Ball) -> Result<(), Uncertain> {
        let elapsed = self.after(dt);
        self.cancelled = self.impacts.len().is_multiple_of(CHUNK) && (self.cancel)();
        if self.cancelled || self.impacts.len() >= self.event_limit || elapsed.high > self.time {
            return Err(Uncertain::Limit);
        }
        if !(elapsed.low <= elapsed.high && elapsed.high.is_finite()) {
            return Err(Uncertain::Order);
        }
        self.clock = self.clock + dt;
        self.impacts.push(EnclosedImpact { contact: ContactNumber::of(i), elapsed });
        Ok(())
    }

    /// All enclosures, and how they end; `None` if cancelled.
    fn end(self, end: Result<EnclosedZeno, Uncertain>) -> Option<Enclosure> {
        if self.cancelled {
            return None;
        }
        let (zeno, reason) = match end {
            Ok(zeno) if zeno.elapsed.high <= self.time => (Some(zeno), None),
            Ok(_) => (None, Some(Uncertain::Limit)),
            Err(reason) => (None, Some(reason)),
        };
        Some(Enclosure { impacts: self.impacts, zeno, reason })
    }
}

/// The enclosure of a motion of which nothing is certain, not even at the start.
const NOTHING: Enclosure =
    Enclosure { impacts: Vec::new(), zeno: None, reason: Some(Uncertain::Order) };

/// Gap and gap rate of a contact.
#[derive(Debug, Clone, Copy)]
struct Gap {
    h: Ball,
    u: Ball,
}

/// The next touchdown of a contact.
enum Landing {
    /// The contact lands after this time, with this speed.
    In(Ball, Ball),
    Never,
    Unknown,
}

/// A local model in balls.
struct Model {
    g: [Ball; 2],
    e: [Ball; 2],
    /// k_i = (1 + e_i)ψ_i
    kappa: [Ball; 2],
    psi: [Ball; 2],
    /// Number of contacts. Contacts beyond it never land.
    count: usize,
    clatter: Option<BallConstants>,
}

/// Constants of a clattering tail; index: the contact that is hit next.
struct BallConstants {
    c: [Ball; 2],
    /// r_i
    r: [Ball; 2],
    /// W*
    limit: [Ball; 2],
    /// G_b
    gravity: [Ball; 2],
}

fn ball(x: f64) -> Ball {
    Ball::from(x)
}

impl BallConstants {
    /// 1/c_b is the larger root of k_a z² − (k_ak_b + e_a − e_b) z + e_a k_b = 0, the repelling direction of two impacts
    /// without gravity.
    fn new(g: [Ball; 2], kappa: [Ball; 2], e: [Ball; 2]) -> Option<Self> {
        let product = kappa[0] * kappa[1];
        let c = |a: usize| {
            let b = 1 - a;
            let sum = product + e[a] - e[b];
            let root = (sum.square() - (e[a] * product).scaled(4.0)).root()?;
            kappa[a].scaled(2.0).over(sum + root)
        };
        let c = [c(1)?, c(0)?];
        let r = e.map(|e| e * c[0] * c[1]);
        let one = ball(1.0);
        let limit = |b: usize| (r[1 - b] * (one + r[b])).over(one + r[1 - b]);
        let limit = [limit(0)?, limit(1)?];
        let positive = |x: Ball| x.is_positive();
        let usable = positive(kappa[0]) && c.into_iter().chain(r.map(|r| one - r)).all(positive);
        let gravity = [0, 1].map(|b| g[b] + c[b] * g[1 - b]);
        usable.then_some(Self { c, r, limit, gravity })
    }

    /// d after an impact at `a`, if it is positive.
    fn inside(&self, a: usize, u_a: Ball, next: Gap) -> Option<Ball> {
        let d = -next.u - self.c[1 - a] * u_a;
        d.is_positive().then_some(d)
    }

    /// d' after an impact at `b` that ends a flight of `dt`.
    fn after(&self, b: usize, d: Ball, dt: Ball) -> Option<Ball> {
        (d + self.gravity[b] * dt).over(self.c[b])
    }

    /// The remaining time after an impact at `a`, as T0 − L and T0, if impacts alternate for ever.
    fn rest(&self, m: &Model, a: usize, u_a: Ball, next: Gap, d: Ball) -> Option<[Ball; 2]> {
        if !m.g.iter().all(|g| g.is_not_negative()) {
            return None;
        }
        let b = 1 - a;
        let speed = -next.u;
        let most = next.h.over(d)?;
        let one = ball(1.0);
        let w = (self.c[b] * u_a).over(speed)?.max(self.limit[b]);
        let after = self.r[b].over(one + self.r[b] - w)?;
        let contraction = one - self.c[0] * self.c[1] * (w * after).square();
        if !((one - w).is_positive() && (one - after).is_positive() && contraction.is_positive()) {
            return None;
        }
        if !next.h.is_zero() {
            let nu = next.h.over((u_a * speed).scaled(2.0))?;
            let factor = |b: usize, w: Ball, after: Ball| {
                let cube = w.square() * after;
                cube.over(self.c[b].square() * self.c[1 - b] * m.e[b].square())
            };
            let (one_more, two_more) = (factor(b, w, after)?, factor(a, after, w)?);
            let lands = |bound: Ball| (one - bound).is_positive();
            let alternates =
                lands(m.g[a] * nu) && lands(m.g[b] * nu * one_more) && lands(one_more * two_more);
            if !alternates {
                return None;
            }
        }
        let pull = self.gravity[b] + self.c[b] * w.square() * self.gravity[a];
        let loss = (most.square() * pull).over((d * contraction).scaled(2.0))?;
        Some([most - loss, most])
    }
}

impl Model {
    fn of(g: [Ball; 2], psi: [Ball; 2], e: [Ball; 2], count: usize) -> Self {
        let kappa = [0, 1].map(|i| (ball(1.0) + e[i]) * psi[i]);
        let clatter = if count == 2 { BallConstants::new(g, kappa, e) } else { None };
        Self { g, e, kappa, psi, count, clatter }
    }

    /// Whether gravity presses both contacts down, and an impact at either contact presses the other down.
    fn presses(&self) -> bool {
        self.g.iter().all(|g| g.is_positive()) && self.psi[0].is_not_negative()
    }

    /// The next landing of contact i from a gap h ≥ 0. The speed is given by s² = u² + 2gh. If the contact approaches the ground, the time
    /// is 2h/(s − u), for any sign of g. Otherwise gravity must bring it back, and the time is (u + s)/g.
    fn landing(&self, i: usize, Gap { h, u }: Gap) -> Landing {
        let g = self.g[i];
        if i >= self.count {
            return Landing::Never;
        }
        if h.is_zero() && u.is_negative() {
            return Landing::In(Ball::ZERO, -u);
        }
        let square = u.square() + (g * h).scaled(2.0);
        if square.is_negative() || u.is_not_negative() && (-g).is_not_negative() {
            return Landing::Never;
        }
        let time = |s: Ball| {
            if u.is_negative() {
                h.scaled(2.0).over(s - u)
            } else if g.is_positive() {
                (u + s).over(g)
            } else {
                None
            }
        };
        let landing = square.root().and_then(|s| Some(Landing::In(time(s)?, s)));
        landing.unwrap_or(Landing::Unknown)
    }

    /// Duration of the bouncing at a, if the gap of b is certainly positive throughout. At the impacts at a, which change the rate of b,
    /// the gap of b is h + py − qy² with y = 1 − eʲ. Between impacts this gap is concave, unless gravity pulls b off the ground, which only
    /// enlarges the gap.
    fn bounces(&self, a: usize, u_a: Ball, other: Gap) -> Option<Ball> {
        let (one, e) = (ball(1.0), self.e[a]);
        if !self.g[a].is_positive() {
            return None;
        }
        let left = one - e;
        let t = u_a.scaled(2.0).over(self.g[a] * left)?;
        if t.is_zero() && (other.h.is_positive() || other.u.is_positive()) {
            return Some(t); // a rests already
        }
        if self.count == 1 {
            return Some(t);
        }
        let g_b = self.g[1 - a].max(Ball::ZERO);
        let fall = (g_b + e * self.psi[a] * self.g[a]).scaled(0.5);
        let end = other.h + t * (other.u - t * fall);
        // Velocity jumps that press b down leave its gap concave: then its values at both ends decide.
        let pressed = self.psi[a].is_not_negative();
        let clear = || {
            let lift = (self.kappa[a] * u_a * t).over(left)?;
            let p = other.u * t + (lift * left).over(one + e)?;
            let q = (g_b * t.square()).scaled(0.5) + lift.over(one + e)?;
            let turns = p.square() + (q * other.h).scaled(4.0);
            let falls = (p - q.scaled(2.0)).is_negative(); // decreases at y = 1
            let clear = q.is_positive() || p.is_positive() || falls || turns.is_negative();
            clear.then_some(())
        };
        (end.is_positive() && (pressed || clear().is_some())).then_some(t)
    }
}

/// The state of the enclosure of a motion.
struct LocalEnclosure<'a> {
    model: Model,
    gaps: [Gap; 2],
    /// d after the last impact, where it is positive.
    inside: Option<Ball>,
    claims: Claims<'a>,
}

impl LocalEnclosure<'_> {
    /// All contacts fly for `dt`.
    fn fly(&mut self, dt: Ball) {
        for (gap, g) in self.gaps.iter_mut().zip(self.model.g).take(self.model.count) {
            let u = gap.u - g * dt;
            gap.h = gap.h + (dt * (gap.u + u)).scaled(0.5);
            gap.u = u;
        }
    }

    /// Flies to the landing of contact i, after `dt` and with the speed s, and collides.
    fn land(&mut self, i: usize, dt: Ball, s: Ball) -> Result<(), Uncertain> {
        self.claims.collide(i, dt)?;
        self.fly(dt);
        let Model { e, kappa, .. } = &self.model;
        let [hit, other] = newton::rates_after(e[i], kappa[i], s, self.gaps[1 - i].u);
        self.gaps[i] = Gap { h: Ball::ZERO, u: hit };
        self.gaps[1 - i].u = other;
        self.inside = None;
        Ok(())
    }

    /// The first contact to land. At the start no contact has just been hit.
    fn begin(&mut self) -> Result<usize, Uncertain> {
        let landings = [0, 1].map(|i| self.model.landing(i, self.gaps[i]));
        let (i, dt, s) = match landings {
            [Landing::Unknown, _] | [_, Landing::Unknown] => return Err(Uncertain::Order),
            [Landing::Never, Landing::Never] => return Err(Uncertain::Never),
            [Landing::In(t, s), Landing::Never] => (0, t, s),
            [Landing::Never, Landing::In(t, s)] => (1, t, s),
            [Landing::In(t, s), Landing::In(other, _)] if (other - t).is_positive() => (0, t, s),
            [Landing::In(other, _), Landing::In(t, s)] if (other - t).is_positive() => (1, t, s),
            _ => return Err(Uncertain::Order),
        };
        if s.is_zero() {
            return Err(Uncertain::Order); // a contact at rest has no impact
        }
        self.land(i, dt, s)?;
        Ok(i)
    }

    /// The next collision after one at `a`.
    fn next(&mut self, a: usize) -> Result<usize, Uncertain> {
        let b = 1 - a;
        let (u_a, g_a) = (self.gaps[a].u, self.model.g[a]);
        let back = if g_a.is_positive() { u_a.scaled(2.0).over(g_a) } else { None };
        match self.model.landing(b, self.gaps[b]) {
            Landing::Unknown => return Err(Uncertain::Order),
            // A contact at rest has no impact.
            Landing::In(_, s) if s.is_zero() => return Err(Uncertain::Order),
            Landing::In(dt, s) => {
                // u_a + u_a − g_aτ > 0: a is still in the air. If a rests, it cannot be the contact that is hit.
                let rests = u_a.is_zero() && dt.is_zero() && self.gaps[b].u.is_negative();
                if rests || (u_a.scaled(2.0) - g_a * dt).is_positive() {
                    let inside = self.inside;
                    self.land(b, dt, s)?;
                    if let (Some(clatter), Some(d)) = (&self.model.clatter, inside)
                        && let Some(d) = clatter.after(b, d, dt)
                    {
                        self.gaps[a].u = -(d + clatter.c[a] * self.gaps[b].u);
                        self.inside = Some(d);
                    }
                    return Ok(b);
                }
                if !back.is_some_and(|back| (dt - back).is_positive()) {
                    return Err(Uncertain::Order);
                }
            }
            Landing::Never if (-g_a).is_not_negative() => return Err(Uncertain::Never),
            Landing::Never => {}
        }
        if u_a.is_zero() {
            return Err(Uncertain::Order); // a contact at rest has no impact
        }
        let back = back.ok_or(Uncertain::Order)?;
        self.land(a, back, u_a)?;
        Ok(a)
    }

    fn zeno(&self, contacts: &[usize], rest: [Ball; 2]) -> EnclosedZeno {
        let [least, most] = rest.map(|t| self.claims.after(t));
        let contacts = contacts.iter().map(|&i| ContactNumber::of(i)).collect();
        EnclosedZeno { contacts, elapsed: Bounds { low: least.low, high: most.high } }
    }

    /// Encloses collisions one by one until the Zeno time is enclosed and further collisions no longer narrow its interval.
    fn run(&mut self) -> Result<EnclosedZeno, Uncertain> {
        let (gaps, g) = (self.gaps, self.model.g);
        if !gaps.iter().all(|gap| gap.h.is_not_negative()) {
            return Err(Uncertain::Order);
        }
        let rests = |i: &usize| gaps[*i].h.is_zero() && gaps[*i].u.is_zero() && g[*i].is_positive();
        let all = 0..self.model.count;
        if self.model.count == 2 && all.clone().all(|i| rests(&i)) && self.model.presses() {
            return Ok(self.zeno(&[0, 1], [Ball::ZERO; 2]));
        }
        let mut a = match all.clone().find(rests) {
            Some(i) => i,
            None => self.begin()?,
        };
        let mut found: Option<EnclosedZeno> = None;
        loop {
            let (u_a, other) = (self.gaps[a].u, self.gaps[1 - a]);
            if let Some(t) = self.model.bounces(a, u_a, other) {
                return Ok(self.zeno(&[a], [t, t]));
            }
            let tail = self.model.clatter.as_ref();
            self.inside = self.inside.or_else(|| tail?.inside(a, u_a, other));
            let rest = self.inside.and_then(|d| tail?.rest(&self.model, a, u_a, other, d));
            if let Some(rest) = rest {
                let zeno = self.zeno(&[0, 1], rest);
                let before = found.as_ref().map_or(f64::INFINITY, |found| found.elapsed.width());
                let elapsed =
                    found.as_ref().map_or(zeno.elapsed, |found| found.elapsed.and(zeno.elapsed));
                let tight = (rest[1] - rest[0]).bounds()[1] <= NARROW_ENOUGH * elapsed.high;
                let narrower = elapsed.width() < before;
                found = Some(EnclosedZeno { elapsed, ..zeno });
                if tight || !narrower {
                    break;
                }
            }
            match self.next(a) {
                Ok(hit) => a = hit,
                Err(_) if found.is_some() => break,
                Err(uncertain) => return Err(uncertain),
            }
        }
        found.ok_or(Uncertain::Order)
    }
}

/// Encloses the motion of a model in balls; `None` if cancelled.
fn enclose(
    model: Model,
    gaps: [Gap; 2],
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Enclosure> {
    let claims = Claims::new(model.count, options, cancel);
    let mut course = LocalEnclosure { model, gaps, inside: None, claims };
    let end = course.run();
    course.claims.end(end)
}

/// Encloses the motion of a body in its local model; `None` if cancelled.
pub(crate) fn enclose_local(
    posture: &Posture,
    state: &State,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Enclosure> {
    let Some((model, gaps)) = full::local_of(posture, state) else {
        return Some(NOTHING);
    };
    enclose(model, gaps, options, cancel)
}

/// Encloses the motion of a model that is given by its parameters.
pub(crate) fn enclose_given(
    model: &LocalModel,
    gaps: [f64; 2],
    rates: [f64; 2],
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Enclosure> {
    let [g, psi, e] = [model.gravity(), model.psi(), model.restitution()].map(|x| x.map(ball));
    let gaps = [0, 1].map(|i| Gap { h: ball(gaps[i]), u: ball(rates[i]) });
    enclose(Model::of(g, psi, e, 2), gaps, options, cancel)
}
