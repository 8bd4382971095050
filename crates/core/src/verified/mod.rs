//! Frictionless motion of two contacts in their local model, proved: flights, impacts, and the two theorems on infinitely many impacts.
//!
//! The formulas are written once, for intervals (53 bits) and for balls (106 bits); see [`Enclosed`]. Each answer holds for all numbers in
//! the arguments, or there is none.
//!
//! Gravity may press a contact to its ground (g_i > 0), pull it off (g_i < 0), or neither. There is no answer if the sign of g_i matters
//! and g_i contains both signs.
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

use crate::impact::newton;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::outcome::Uncertain;

mod flight;
pub(crate) mod rows;
mod shape;
mod similar;

pub(crate) use flight::{Energy, Flight};

/// Gap and gap rate of a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gap<T> {
    pub(crate) h: T,
    pub(crate) u: T,
}

impl<T: Enclosed> Gap<T> {
    /// On the ground, at rest.
    pub(crate) const REST: Self = Self { h: T::ZERO, u: T::ZERO };

    pub(crate) fn is_at_rest(&self) -> bool {
        self.h.is_zero() && self.u.is_zero()
    }

    /// The next landing under gravity g, from a gap h ≥ 0. The speed is given by s² = u² + 2gh. If the contact approaches the ground, the
    /// time is 2h/(s − u), for any sign of g. Otherwise gravity must bring it back, and the time is (u + s)/g.
    pub(crate) fn landing(&self, g: T) -> Landing<T> {
        let Self { h, u } = *self;
        if h.is_zero() && u.is_negative() {
            return Landing::In(T::ZERO, -u);
        }
        let square = u.square() + (g * h).scaled(2.0);
        if square.is_negative() || u.is_not_negative() && (-g).is_not_negative() {
            return Landing::Never;
        }
        let square = if g.is_positive() { square.not_below_zero() } else { square };
        let time = |s: T| {
            if u.is_negative() {
                h.scaled(2.0).over(s - u)
            } else if g.is_positive() {
                (u + s).over(g)
            } else {
                None
            }
        };
        let landing = square.root().and_then(|s| Some(Landing::In(time(s)?.not_below_zero(), s)));
        landing.unwrap_or(Landing::Unknown)
    }
}

/// The next touchdown of a contact.
pub(crate) enum Landing<T> {
    /// The contact lands after this time, with this speed.
    In(T, T),
    Never,
    Unknown,
}

/// A local model.
#[derive(Debug, Clone)]
pub(crate) struct Model<T> {
    pub(crate) g: [T; 2],
    pub(crate) e: [T; 2],
    psi: [T; 2],
    /// k_i = (1 + e_i)ψ_i
    kappa: [T; 2],
    /// Number of contacts. Contacts beyond it never land.
    pub(crate) count: usize,
    /// Places of further contacts on the line from contact 1 (0) to contact 2 (1), strictly between them, with equal normals and equal restitutions.
    pub(crate) between: Vec<T>,
    clattering: Option<Clattering<T>>,
}

/// Constants of a clattering tail; index: the contact that is hit next.
#[derive(Debug, Clone)]
struct Clattering<T> {
    c: [T; 2],
    /// r_i
    r: [T; 2],
    /// W*
    limit: [T; 2],
    /// G_b
    gravity: [T; 2],
}

fn one<T: Enclosed>() -> T {
    T::from(1.0)
}

fn interval<T: Enclosed>(x: T) -> Interval {
    let [lo, hi] = x.bounds();
    Interval::new(lo, hi)
}

impl<T: Enclosed> Clattering<T> {
    /// 1/c_b is the larger root of k_a z² − (k_ak_b + e_a − e_b) z + e_a k_b = 0, the repelling direction of two impacts
    /// without gravity.
    fn new(g: [T; 2], kappa: [T; 2], e: [T; 2]) -> Option<Self> {
        let product = kappa[0] * kappa[1];
        let c = |a: usize| {
            let b = 1 - a;
            let sum = product + e[a] - e[b];
            let root = (sum.square() - (e[a] * product).scaled(4.0)).root()?;
            kappa[a].scaled(2.0).over(sum + root)
        };
        let c = [c(1)?, c(0)?];
        let r = e.map(|e| e * c[0] * c[1]);
        let limit = |b: usize| (r[1 - b] * (one::<T>() + r[b])).over(one::<T>() + r[1 - b]);
        let limit = [limit(0)?, limit(1)?];
        let positive = |x: T| x.is_positive();
        let usable =
            positive(kappa[0]) && c.into_iter().chain(r.map(|r| one::<T>() - r)).all(positive);
        let gravity = [0, 1].map(|b| g[b] + c[b] * g[1 - b]);
        usable.then_some(Self { c, r, limit, gravity })
    }

    /// d after an impact at `a`, if it is positive.
    fn inside(&self, a: usize, u_a: T, next: Gap<T>) -> Option<T> {
        let d = -next.u - self.c[1 - a] * u_a;
        d.is_positive().then_some(d)
    }

    /// d' after an impact at `b` that ends a flight of `dt`.
    fn after(&self, b: usize, d: T, dt: T) -> Option<T> {
        (d + self.gravity[b] * dt).over(self.c[b])
    }
}

impl<T: Enclosed> Model<T> {
    pub(crate) fn new(g: [T; 2], psi: [T; 2], e: [T; 2], count: usize) -> Self {
        let kappa = [0, 1].map(|i| (one::<T>() + e[i]) * psi[i]);
        let clattering = if count == 2 { Clattering::new(g, kappa, e) } else { None };
        Self { g, e, psi, kappa, count, between: Vec::new(), clattering }
    }

    /// Returns true if gravity presses both contacts down, and an impact at either contact presses the other down.
    pub(crate) fn presses(&self) -> bool {
        self.g.iter().all(|g| g.is_positive()) && self.psi[0].is_not_negative()
    }

    fn landing(&self, i: usize, gap: Gap<T>) -> Landing<T> {
        if i < self.count { gap.landing(self.g[i]) } else { Landing::Never }
    }

    /// Duration of the bouncing at a, if the gap of b is certainly positive throughout. At the impacts at a, which change the rate of b,
    /// the gap of b is h + py − qy² with y = 1 − eʲ. Between impacts this gap is concave, unless gravity pulls b off the ground, which only
    /// enlarges the gap.
    fn bounces(&self, a: usize, u_a: T, other: Gap<T>) -> Option<T> {
        let e = self.e[a];
        if !self.g[a].is_positive() {
            return None;
        }
        let left = one::<T>() - e;
        let t = u_a.scaled(2.0).over(self.g[a] * left)?;
        if t.is_zero() && (other.h.is_positive() || other.u.is_positive()) {
            return Some(t); // a rests already
        }
        if self.count == 1 {
            return Some(t);
        }
        let g_b = self.g[1 - a].max(T::ZERO);
        let end = self.gap_after_bounces(a, other, t, g_b);
        // Velocity jumps that press b down leave its gap concave: then its values at both ends decide.
        let pressed = self.psi[a].is_not_negative();
        let clear = || {
            let lift = (self.kappa[a] * u_a * t).over(left)?;
            let p = other.u * t + (lift * left).over(one::<T>() + e)?;
            let q = (g_b * t.square()).scaled(0.5) + lift.over(one::<T>() + e)?;
            let turns = p.square() + (q * other.h).scaled(4.0);
            let falls = (p - q.scaled(2.0)).is_negative(); // decreases at y = 1
            let clear = q.is_positive() || p.is_positive() || falls || turns.is_negative();
            clear.then_some(())
        };
        (end.is_positive() && (pressed || clear().is_some())).then_some(t)
    }

    /// The gap of the other contact after the bouncing at a, with gravity g_b.
    fn gap_after_bounces(&self, a: usize, other: Gap<T>, t: T, g_b: T) -> T {
        let fall = (g_b + self.e[a] * self.psi[a] * self.g[a]).scaled(0.5);
        other.h + t * (other.u - t * fall)
    }
}

/// A motion from impact to impact.
#[derive(Debug)]
pub(crate) struct Motion<'m, T> {
    pub(crate) model: &'m Model<T>,
    pub(crate) gaps: [Gap<T>; 2],
    /// d after the last impact, where it is positive.
    inside: Option<T>,
}

impl<'m, T: Enclosed> Motion<'m, T> {
    pub(crate) fn new(model: &'m Model<T>, gaps: [Gap<T>; 2]) -> Self {
        Self { model, gaps, inside: None }
    }

    /// All contacts fly for `dt`.
    fn fly(&mut self, dt: T) {
        for (gap, g) in self.gaps.iter_mut().zip(self.model.g).take(self.model.count) {
            let u = gap.u - g * dt;
            gap.h = (gap.h + (dt * (gap.u + u)).scaled(0.5)).not_below_zero();
            gap.u = u;
        }
    }

    /// An impact at contact i with the speed s.
    fn collide(&mut self, i: usize, s: T) {
        let Model { e, kappa, .. } = self.model;
        let [hit, other] = newton::rates_after(e[i], kappa[i], s, self.gaps[1 - i].u);
        self.gaps[i] = Gap { h: T::ZERO, u: hit };
        self.gaps[1 - i].u = other;
        self.inside = None;
    }

    /// The first collision: the contact that is hit, and the time until then. At the start no contact has just been hit.
    pub(crate) fn first(&mut self) -> Result<(usize, T), Uncertain> {
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
        self.fly(dt);
        self.collide(i, s);
        Ok((i, dt))
    }

    /// The next collision after one at `a`: the contact that is hit, and the time until then.
    pub(crate) fn next(&mut self, a: usize) -> Result<(usize, T), Uncertain> {
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
                    self.fly(dt);
                    self.collide(b, s);
                    if let (Some(tail), Some(d)) = (&self.model.clattering, inside)
                        && let Some(d) = tail.after(b, d, dt)
                    {
                        self.gaps[a].u = -(d + tail.c[a] * self.gaps[b].u);
                        self.inside = Some(d);
                    }
                    return Ok((b, dt));
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
        self.fly(back);
        self.collide(a, u_a);
        Ok((a, back))
    }

    /// After an impact at `a`: the duration of its bouncing, if the other contact certainly stays in the air.
    pub(crate) fn bounces(&self, a: usize) -> Option<T> {
        self.model.bounces(a, self.gaps[a].u, self.gaps[1 - a])
    }

    /// Gap and gap rate of the other contact at the end of the bouncing at `a`, after the time t.
    fn after_bounces(&self, a: usize, t: T) -> Option<Gap<T>> {
        let (m, other) = (self.model, self.gaps[1 - a]);
        let g_b = m.g[1 - a];
        let jumps = (m.kappa[a] * self.gaps[a].u).over(one::<T>() - m.e[a])?;
        let h = m.gap_after_bounces(a, other, t, g_b);
        Some(Gap { h, u: other.u - g_b * t - jumps })
    }

    /// The remaining time after an impact at `a`, as T0 − L and T0, if impacts certainly alternate for ever.
    pub(crate) fn clatters(&mut self, a: usize) -> Option<[T; 2]> {
        let (m, tail) = (self.model, self.model.clattering.as_ref()?);
        let (b, one) = (1 - a, one::<T>());
        let (u_a, next) = (self.gaps[a].u, self.gaps[b]);
        self.inside = self.inside.or_else(|| tail.inside(a, u_a, next));
        let d = self.inside?;
        if !m.g.iter().all(|g| g.is_not_negative()) {
            return None;
        }
        let speed = -next.u;
        let most = next.h.over(d)?;
        let w = (tail.c[b] * u_a).over(speed)?.max(tail.limit[b]);
        let after = tail.r[b].over(one + tail.r[b] - w)?;
        let contraction = one - tail.c[0] * tail.c[1] * (w * after).square();
        if !((one - w).is_positive() && (one - after).is_positive() && contraction.is_positive()) {
            return None;
        }
        if !next.h.is_zero() {
            let nu = next.h.over((u_a * speed).scaled(2.0))?;
            let factor = |b: usize, w: T, after: T| {
                let cube = w.square() * after;
                cube.over(tail.c[b].square() * tail.c[1 - b] * m.e[b].square())
            };
            let (one_more, two_more) = (factor(b, w, after)?, factor(a, after, w)?);
            let lands = |bound: T| (one - bound).is_positive();
            let alternates =
                lands(m.g[a] * nu) && lands(m.g[b] * nu * one_more) && lands(one_more * two_more);
            if !alternates {
                return None;
            }
        }
        let pull = tail.gravity[b] + tail.c[b] * w.square() * tail.gravity[a];
        let loss = (most.square() * pull).over((d * contraction).scaled(2.0))?;
        Some([most - loss, most])
    }
}
