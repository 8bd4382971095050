//! The frictionless motion after a corner, until the next Zeno point.
//!
//! At a *corner* one contact is on the ground and contact j lands, here with speed 1. Impacts at this instant follow. They go on without
//! end if p_1p_2 ≥ (√e_1 + √e_2)². Otherwise flights and impacts follow, until one contact bounces alone, or the impacts are those of a
//! self-similar cycle. (Clattering, the other way to two contacts at rest, needs the same bound.)

use crate::math::ball::Ball;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::outcome::Uncertain;
use crate::tolerance::CUT_ENERGY;
use crate::verified::shape::{Frame, Shape};
use crate::verified::similar::Recurrences;
use crate::verified::{Gap, Model, Motion, interval, one};

/// Largest number of impacts of one flight that are computed one by one: those at the instant of the corner; in intervals; and then, if the
/// end is not certain, in frames.
const AT_ONCE: usize = 256;
const PLAIN: usize = 256;
const FINE: usize = 768;

/// How the motion after a corner ends. `t`: duration of the flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Flight {
    /// Contact `kept` rests. The other contact has this gap and gap rate.
    One {
        kept: usize,
        h: Interval,
        u: Interval,
        t: Interval,
    },
    /// Both contacts rest.
    Two {
        t: Interval,
    },
    /// The flight is followed until 2E is at most `energy` and the time `t` has passed, but no further. E = ½u·D⁻¹u + λ·h never rises
    /// again.
    Cut {
        energy: f64,
        t: Interval,
    },
    /// Neither contact lands again.
    Away,
    /// There is no such corner: the other contact does not stay on the terrain.
    Nowhere,
    Unknown,
}

/// The energy E = ½u·D⁻¹u + λ·h of a frictionless motion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Energy {
    /// D⁻¹ and λ
    pub(crate) inverse: [[Interval; 2]; 2],
    pub(crate) weights: [Interval; 2],
    /// (1 − e²)/(e² D_jj): what 2E loses in an impact, over the square of the speed after it. Zero for e = 0.
    pub(crate) lost: [Interval; 2],
}

impl Energy {
    /// 2E
    fn twice(&self, [one, two]: &[Gap<Interval>; 2]) -> Interval {
        let [[a, b], [_, c]] = self.inverse;
        let kinetic = a * one.u.square() + (b * one.u * two.u).times(2.0) + c * two.u.square();
        kinetic + (self.weights[0] * one.h + self.weights[1] * two.h).times(2.0)
    }
}

/// Where a flight is best cut, up to now.
struct Cut<'e> {
    energy: Option<&'e Energy>,
    /// A bound of 2E.
    left: f64,
    best: Flight,
}

impl<'e> Cut<'e> {
    fn new(energy: Option<&'e Energy>) -> Self {
        Self { energy, left: f64::INFINITY, best: Flight::Unknown }
    }

    /// The flight may be cut here, at gaps of this size after the time t.
    fn take(&mut self, gaps: &[Gap<Interval>; 2], size: Interval, t: Interval) {
        let Some(energy) = self.energy else { return };
        self.left = self.left.min((energy.twice(gaps) * size.square()).hi);
        if self.left < self.best.energy_left() {
            self.best = Flight::Cut { energy: self.left, t };
        }
    }

    /// An impact at contact j, after which it has this speed.
    fn lose(&mut self, j: usize, speed: Interval) {
        let Some(energy) = self.energy else { return };
        self.left = (Interval::from(self.left) - energy.lost[j] * speed.square()).hi;
    }
}

impl<T: Enclosed> Model<T> {
    /// Whether impacts at two closed contacts alternate without end: p_1p_2 ≥ (√e_1 + √e_2)². `None` if this is not certain. With contacts
    /// between them impacts are followed one by one.
    fn chatters(&self) -> Option<bool> {
        if (-self.psi[0]).is_not_negative() || !self.between.is_empty() {
            return Some(false);
        }
        let bound = (self.e[0].root()? + self.e[1].root()?).square();
        let more = self.kappa[0] * self.kappa[1] - bound;
        match (self.psi[0].is_positive(), more.is_not_negative(), more.is_negative()) {
            (true, true, _) => Some(true),
            (true, _, true) => Some(false),
            _ => None,
        }
    }

    /// The state after contact j has landed with speed 1, and after all impacts at this instant. If these are not certain: the state after
    /// those that are.
    fn corner(&self, j: usize) -> Result<(Motion<'_, T>, usize), Motion<'_, T>> {
        let mut motion = Motion::new(self, [Gap::REST; 2]);
        motion.gaps[j].u = -one::<T>();
        let mut a = j;
        for _ in 0..AT_ONCE {
            if !self.hits_line(&mut motion, a) {
                break;
            }
            let other = motion.gaps[1 - a].u;
            if other.is_not_negative() {
                return Ok((motion, a));
            }
            if !other.is_negative() {
                break;
            }
            a = 1 - a;
        }
        Err(motion)
    }
}

impl<T: Enclosed> Model<T> {
    /// The impact of contact a, which approaches the ground with the speed s, while the other one, z, is on the ground too and does not approach; and of
    /// those contacts between them that approach. False if the intervals do not decide.
    ///
    /// Newton's law for all contacts that approach together: ξ = u⁺ + eu⁻ ≥ 0 ⊥ P ≥ 0. On a line ξ is affine. So at most two contacts have an impulse: a, and p,
    /// the one nearest to z that approaches. With w the place of p from z to a, and q = ws − (1 − w)u_z its speed, the solution is unique:
    ///
    /// * only a, if D_pa s ≥ D_aa q;
    /// * only p, if D_pa q ≥ D_pp s;
    /// * both otherwise; then ξ = 0 on the whole line, and all rates become −e times themselves.
    fn hits_line(&self, motion: &mut Motion<'_, T>, a: usize) -> bool {
        let z = 1 - a;
        let (s, u_z) = (-motion.gaps[a].u, motion.gaps[z].u);
        let only_a = |motion: &mut Motion<'_, T>| {
            motion.collide(a, s);
            true
        };
        if self.between.is_empty() || (-self.psi[a]).is_not_negative() {
            return only_a(motion);
        }
        if !self.psi[a].is_positive() {
            return false;
        }
        let mut nearest: Option<(T, T)> = None;
        for place in &self.between {
            let w = if z == 0 { *place } else { one::<T>() - *place };
            let q = w * s - (one::<T>() - w) * u_z;
            if q.is_positive() {
                match nearest {
                    Some((other, _)) if (w - other).is_not_negative() => {}
                    Some((other, _)) if !(other - w).is_positive() => return false,
                    _ => nearest = Some((w, q)),
                }
            } else if !(-q).is_not_negative() {
                return false;
            }
        }
        let Some((w, q)) = nearest else { return only_a(motion) };
        // D over D_zz: D_za = −ψ_z, D_aa = ψ_z/ψ_a.
        let v = one::<T>() - w;
        let (za, Some(aa)) = (-self.psi[z], self.psi[z].over(self.psi[a])) else { return false };
        let (zp, pa) = (v + w * za, v * za + w * aa);
        let pp = v * zp + w * pa;
        if (pa * s - aa * q).is_not_negative() {
            return only_a(motion);
        }
        let e = self.e[a];
        if (pa * q - pp * s).is_not_negative() {
            let Some(impulse) = ((one::<T>() + e) * q).over(pp) else { return false };
            motion.gaps[a].u = motion.gaps[a].u + pa * impulse;
            motion.gaps[z].u = u_z + zp * impulse;
        } else if (aa * q - pa * s).is_positive() && (pp * s - pa * q).is_positive() {
            motion.gaps[a].u = e * s;
            motion.gaps[z].u = -(e * u_z);
        } else {
            return false;
        }
        true
    }
}

impl Flight {
    /// The motion after contact j has landed with speed 1. `lets_go`: the contacts that certainly have no motion on the terrain. `energy`: given if
    /// it bounds the motion; the flight is cut where little of it is left, or where the course of the flight is not certain any more.
    pub(crate) fn after_corner(
        model: &Model<Interval>,
        j: usize,
        lets_go: [bool; 2],
        energy: Option<&Energy>,
    ) -> Self {
        if lets_go[1 - j] {
            return Self::Nowhere;
        }
        if model.chatters() == Some(true) {
            return Self::Two { t: Interval::ZERO };
        }
        let mut cut = Cut::new(energy);
        let (mut motion, mut a) = match model.corner(j) {
            Ok(start) => start,
            Err(motion) => {
                cut.take(&motion.gaps, Interval::ONE, Interval::ZERO);
                return cut.best;
            }
        };
        let mut clock = Interval::ZERO;
        for _ in 0..PLAIN {
            if let Some(flight) = motion.ends(a, lets_go) {
                return flight.after(clock, Interval::ONE);
            }
            cut.take(&motion.gaps, Interval::ONE, clock);
            if cut.best.energy_left() <= CUT_ENERGY {
                break;
            }
            match motion.next(a) {
                Ok((hit, dt)) => (a, clock) = (hit, clock + dt),
                Err(Uncertain::Never) => return Self::Away,
                Err(_) => break,
            }
            cut.lose(a, motion.gaps[a].u);
        }
        cut.best
    }

    /// As [`Flight::after_corner`], more precisely and more slowly, for a corner that exists and at which impacts do not chatter. `fine`: the
    /// same model with more bits.
    pub(crate) fn after_corner_finely(
        model: &Model<Interval>,
        fine: &Model<Ball>,
        j: usize,
        lets_go: [bool; 2],
        energy: Option<&Energy>,
    ) -> Self {
        let start = fine.corner(j).ok().and_then(|(motion, a)| {
            Some((Frame::new(Shape::of(motion.gaps, a)?), interval(motion.gaps[a].u)))
        });
        let Some((mut frame, mut size)) = start else { return Self::Unknown };
        let (mut clock, mut cut) = (Interval::ZERO, Cut::new(energy));
        let mut recurrences = Recurrences::new();
        for _ in 0..FINE {
            let shape = frame.shapes();
            let motion = Motion::new(model, shape.gaps());
            if let Some(flight) = motion.ends(shape.contact, lets_go) {
                return flight.after(clock, size);
            }
            if let Some(period) = recurrences.period(&shape)
                && let Some(t) = model.self_similar(fine, shape, period)
            {
                return Self::Two { t }.after(clock, size);
            }
            cut.take(&motion.gaps, size, clock);
            if cut.best.energy_left() <= CUT_ENERGY {
                break;
            }
            let Some((factor, time)) = frame.step(fine, model) else { break };
            clock = clock + time * size;
            size = factor * size;
            cut.lose(frame.shapes().contact, size);
        }
        cut.best
    }

    /// The energy of a flight that is cut; infinite if the end is not known, and zero for other ends.
    pub(crate) fn energy_left(&self) -> f64 {
        match self {
            Self::Unknown => f64::INFINITY,
            Self::Cut { energy, .. } => *energy,
            _ => 0.0,
        }
    }

    /// The width of the speeds at an end at which one contact rests, and of the time; zero for other ends.
    pub(crate) fn width(&self) -> f64 {
        match self {
            Self::One { h, u, t, .. } => {
                let wide = |x: &Interval| x.hi - x.lo;
                (h.hi.sqrt() - h.lo.max(0.0).sqrt()).max(wide(u)).max(wide(t))
            }
            _ => 0.0,
        }
    }

    /// Returns true if both contacts may rest at the end.
    pub(crate) fn may_rest_both(&self) -> bool {
        matches!(self, Self::Two { .. } | Self::Cut { .. })
    }

    /// This end after an earlier time, all speeds being larger by a factor.
    fn after(self, clock: Interval, size: Interval) -> Self {
        let later = |t: Interval| clock + t * size;
        match self {
            Self::One { kept, h, u, t } => {
                Self::One { kept, h: h * size.square(), u: u * size, t: later(t) }
            }
            Self::Two { t } => Self::Two { t: later(t) },
            Self::Cut { .. } | Self::Away | Self::Nowhere | Self::Unknown => self,
        }
    }
}

impl Motion<'_, Interval> {
    /// The end of the flight, if one contact rests or bounces alone after an impact at `a`. `lets_go`: see [`Flight::after_corner`].
    fn ends(&self, a: usize, lets_go: [bool; 2]) -> Option<Flight> {
        let one_rests = |kept: usize, Gap { h, u }: Gap<Interval>, t: Interval| {
            Some(Flight::One { kept, h: h.not_below_zero(), u, t })
        };
        let rests = |i: &usize| self.gaps[*i].is_at_rest() && !lets_go[*i];
        if let Some(kept) = [a, 1 - a].into_iter().find(rests) {
            if !self.model.g[kept].is_not_negative() {
                return Some(Flight::Unknown); // it may jam
            }
            return one_rests(kept, self.gaps[1 - kept], Interval::ZERO);
        }
        let t = self.bounces(a)?;
        one_rests(a, self.after_bounces(a, t)?, t)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::cases::fixed;

    proptest! {
        #![proptest_config(fixed(31))]

        /// Both ways of computation enclose the same end, for equal and unequal restitutions, couplings of either sign, and gravity that pulls
        /// a contact off.
        #[test]
        fn the_finer_flight_lies_in_the_plain_one(
            g in 0.2..2.0, other in -0.5..2.0, psi in -0.9..0.9, ratio in 0.2..5.0_f64, e in 0.05..0.8, share in 0.2..1.0, j in 0..2_usize,
        ) {
            let (g, psi, e): ([f64; 2], [f64; 2], [f64; 2]) = ([g, other], [psi * ratio.min(1.0), psi / ratio.max(1.0)], [e, e * share]);
            let rough = Model::new(g.map(Interval::from), psi.map(Interval::from), e.map(Interval::from), 2);
            let fine = Model::new(g.map(Ball::from), psi.map(Ball::from), e.map(Ball::from), 2);
            let plain = Flight::after_corner(&rough, j, [false; 2], None);
            prop_assume!(!matches!(plain, Flight::Unknown | Flight::Away) && rough.chatters() == Some(false));
            let finer = Flight::after_corner_finely(&rough, &fine, j, [false; 2], None);
            let (Flight::One { kept, h, u, t }, Flight::One { kept: also, h: h2, u: u2, t: t2 }) = (plain, finer) else {
                return Err(TestCaseError::fail(format!("{plain:?} {finer:?}")));
            };
            prop_assert_eq!(kept, also);
            for (x, y) in [(h, h2), (u, u2), (t, t2)] {
                prop_assert!(x.lo <= y.hi && y.lo <= x.hi, "{:?} {:?}", x, y);
            }
        }

        /// Doubles, impact by impact, lie in the enclosure up to their rounding errors.
        #[test]
        fn a_flight_in_doubles_ends_alike(g in 0.2..2.0, other in 0.2..2.0, psi in -0.9..0.5, e in 0.05..0.6, j in 0..2_usize) {
            let (g, psi, e): ([f64; 2], [f64; 2], [f64; 2]) = ([g, other], [psi; 2], [e; 2]);
            let model = Model::new(g.map(Interval::from), psi.map(Interval::from), e.map(Interval::from), 2);
            let Flight::One { kept, h, t, .. } = Flight::after_corner(&model, j, [false; 2], None) else { return Ok(()) };
            let (mut gaps, mut rates, mut time, mut last) = ([0.0; 2], [0.0; 2], 0.0, j);
            rates[j] = -1.0;
            for _ in 0..2000 {
                let w = rates[last];
                rates[last] = -e[last] * w;
                rates[1 - last] += (1.0 + e[last]) * psi[last] * w;
                let flight = |i: usize| {
                    let (h, u): (f64, f64) = (gaps[i], rates[i]);
                    if i == last { 2.0 * u / g[i] } else { ((u * u + 2.0 * g[i] * h).sqrt() + u) / g[i] }
                };
                let both = [flight(0), flight(1)];
                let next = if gaps[1 - last] == 0.0 && rates[1 - last] < 0.0 { 1 - last } else { usize::from(both[1] < both[0]) };
                let dt = if gaps[next] == 0.0 && rates[next] < 0.0 { 0.0 } else { both[next] };
                for i in 0..2 {
                    gaps[i] += dt * (rates[i] - 0.5 * g[i] * dt);
                    rates[i] -= g[i] * dt;
                }
                gaps[next] = 0.0;
                (time, last) = (time + dt, next);
                if rates[next].abs() < 1e-13 {
                    break;
                }
            }
            // The rounding errors of a flight grow from impact to impact.
                let slack = 1e-9;
                let near = |x: Interval, y: f64| x.lo - slack <= y && y <= x.hi + slack;
            prop_assert!(near(t, time) && near(h, gaps[1 - kept]), "{t:?} {time} {h:?} {gaps:?}");
        }
    }
}
