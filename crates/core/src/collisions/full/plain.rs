//! The plain collision of a body that turns slowly: the contact hit last is in the air, and the other one lands. Most
//! collisions are plain. The arithmetic is the same for one body and for the lanes of a vector register.

use fearless_simd::Simd;

use crate::body::geometry::ContactGeometry;
use crate::collisions::full::{FullState, PairBody, REFRESH};
use crate::flight::{GapArc, longest};
use crate::impact::newton;
use crate::math::clock::{Clock, renormalised, unnormalised_after};
use crate::math::lanes::{Columns, Lanes};
use crate::math::real::Real;
use crate::math::turn::Angle;
use crate::math::turn::Turn;
use crate::tolerance::{TAIL_TOO_LONG, TRY_TAIL};

/// Constants of one contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side<T> {
    gravity: T,
    restitution: T,
    normal: [T; 2],
    /// b and c at θ = 0.
    arm: [T; 2],
    /// (g/|d|)². If ω⁴ is below this, the gap is a concave function of time for all times.
    slow: T,
}

/// Constants of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullConstants<T> {
    sides: [Side<T>; 2],
    rho2: T,
    /// ρ² n_1·n_2
    cross: T,
    gravity: T,
    least_loss: T,
    /// The time limit, or the largest double if there is none.
    end: T,
    /// The longest flight from the ground after which the position of the body is still known in spite of rounding, in s.
    longest: T,
}

/// The state of a body, right after an impact, and the clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullLoopState<T> {
    h: [T; 2],
    u: [T; 2],
    b: [T; 2],
    c: [T; 2],
    r: [T; 2],
    v: [T; 2],
    theta: T,
    omega: T,
    hi: T,
    lo: T,
}

/// A candidate for a plain collision.
pub(crate) struct FullPlainCollision<T: Real> {
    pub(crate) after: FullLoopState<T>,
    pub(crate) plain: T::Mask,
    /// Whether one of the ends of [`Near`] is possible after the collision, or the contact just hit stays closed.
    pub(crate) may_end: T::Mask,
    /// Rates before the impact, and its own-rate jump.
    pub(crate) before: [T; 2],
    pub(crate) jump: T,
    /// Duration of the flight.
    pub(crate) dt: T,
}

/// Which ends of an accumulation are possible after an impact at contact a: bouncing at a, clattering, and rest of both contacts so soon
/// that the geometry may be frozen. The tests need no root and no division.
pub(crate) struct Near<T: Real> {
    pub(crate) bounce: T::Mask,
    pub(crate) clatter: T::Mask,
    pub(crate) freezes: T::Mask,
}

/// Whether the geometry may be frozen soon: the time to rest is at least 8 speed/(g(1−e)), and this may be below [`TAIL_TOO_LONG`] times
/// the time elapsed. `squares`: u² + 2gh of both contacts.
#[inline(always)]
pub(crate) fn may_freeze<T: Real>(squares: [T; 2], gravity: [T; 2], loss: T, now: T) -> T::Mask {
    let most = T::choose(gravity[0].below(gravity[1]), gravity[1], gravity[0]);
    let freezes = now * TAIL_TOO_LONG * most * loss;
    let bound = freezes * freezes;
    let quick = (squares[0] * 64.0).at_most(bound) & (squares[1] * 64.0).at_most(bound);
    now.like(0.0).below(freezes) & quick
}

impl<T: Angle> FullLoopState<T> {
    fn arc(&self, i: usize, constants: &FullConstants<T>) -> GapArc<T> {
        let (g, omega) = (constants.sides[i].gravity, self.omega);
        GapArc { h: self.h[i], u: self.u[i], g, b: self.b[i], c: self.c[i], omega }
    }

    /// −ψ_i (b_i² + ρ²)
    #[inline(always)]
    fn cross(&self, constants: &FullConstants<T>) -> T {
        self.b[0] * self.b[1] + constants.cross
    }

    /// g_i + c_iω²
    #[inline(always)]
    fn pull(&self, i: usize, constants: &FullConstants<T>) -> T {
        constants.sides[i].gravity + self.c[i] * self.omega * self.omega
    }

    /// The ends to test for after an impact at `A` that ended a flight of `tau`.
    #[inline(always)]
    pub(crate) fn near<const A: usize>(&self, constants: &FullConstants<T>, tau: T) -> Near<T> {
        let b = 1 - A;
        let (u_a, u_b, h_b, e) = (self.u[A], self.u[b], self.h[b], constants.sides[A].restitution);
        let gravity = [self.pull(0, constants), self.pull(1, constants)];
        let (cross, own) = (self.cross(constants), self.b[A] * self.b[A] + constants.rho2);
        let zero = u_a.like(0.0);

        // Bouncing at a, T = 2u/(g(1−e)): whether h_b(T) ≥ 0.
        let (scale, t) = (gravity[A] * (-e + 1.0), u_a * 2.0);
        let fall = gravity[b] * own - e * cross * gravity[A];
        let bounce = zero.below(gravity[A])
            & (t * 0.5 * t * fall).at_most((h_b * scale + t * u_b) * scale * own);

        let (drop, square) = (gravity[b] * 2.0 * h_b, u_b * u_b);
        let clatter = u_b.below(zero)
            & cross.below(zero)
            & (drop * drop * tau).at_most(self.hi * TRY_TAIL * (square * square));

        // h_a = 0
        let freezes =
            may_freeze([u_a * u_a, square + drop], gravity, constants.least_loss, self.hi);
        Near { bounce, clatter, freezes }
    }

    /// The arms computed from θ, and whether θ is small enough for this computation.
    #[inline(always)]
    pub(crate) fn arms(&self, constants: &FullConstants<T>) -> ([[T; 2]; 2], T::Mask) {
        let turn = Turn::small(self.theta);
        let small = self.theta.abs().at_most(self.theta.like(Turn::<T>::SMALL));
        // No closure: a function that is not inlined into the vector loop is compiled without vector instructions.
        let [one, two] = &constants.sides;
        ([turn.turned(one.arm), turn.turned(two.arm)], small)
    }

    /// The next collision. `A`: the contact hit last; the other one lands.
    #[inline(always)]
    pub(crate) fn plain_collision<const A: usize>(
        &self,
        constants: &FullConstants<T>,
    ) -> FullPlainCollision<T> {
        let b = 1 - A;
        let (omega, zero) = (self.omega, self.omega.like(0.0));
        let (arc_a, arc_b) = (self.arc(A, constants), self.arc(b, constants));
        let w4 = omega * omega * (omega * omega);
        let slow = w4.below(constants.sides[0].slow) & w4.below(constants.sides[1].slow);
        let (landing, found) = arc_b.concave_touchdown();
        let (dt, turn) = (landing.dt, &landing.turn);

        // A concave arc that starts on the ground is above it until it lands: the sign of the gap decides.
        let height = arc_a.gap_turned(dt, turn);
        let rates = [arc_a.rate_turned(dt, turn), arc_b.rate_turned(dt, turn)];
        let plain = slow
            & found
            & zero.below(height)
            & rates[1].below(zero)
            & (self.hi + dt).at_most(constants.end)
            & dt.at_most(constants.longest);

        let mut after = *self;
        (after.hi, after.lo) = renormalised(unnormalised_after(self.hi, self.lo, dt));
        after.theta = self.theta + omega * dt;
        after.r = [self.r[0] + self.v[0] * dt, self.r[1] + self.v[1] * dt];
        after.r[1] = after.r[1] - constants.gravity * 0.5 * dt * dt;
        after.v[1] = self.v[1] - constants.gravity * dt;
        for i in 0..2 {
            [after.b[i], after.c[i]] = turn.turned([self.b[i], self.c[i]]);
        }

        let (s, e, normal) = (-rates[1], constants.sides[b].restitution, constants.sides[b].normal);
        let (jump, per_own) = newton::own_jump(e, s, after.b[b] * after.b[b] + constants.rho2);
        let push = constants.rho2 * per_own;
        (after.h[A], after.h[b]) = (height, zero);
        after.u[b] = e * s;
        after.u[A] = rates[0] + after.cross(constants) * per_own;
        after.omega = omega + after.b[b] * per_own;
        after.v = [after.v[0] + normal[0] * push, after.v[1] + normal[1] * push];

        let near =
            if A == 0 { after.near::<1>(constants, dt) } else { after.near::<0>(constants, dt) };
        let may_end = near.bounce | near.clatter | near.freezes | after.u[b].at_most(zero);
        let before = if A == 0 { rates } else { [rates[1], rates[0]] };
        FullPlainCollision { after, plain, may_end, before, jump, dt }
    }
}

/// A body in its lane.
#[derive(Debug, Clone, Copy)]
struct LaneState<T> {
    fast: FullLoopState<T>,
    /// Number of collisions until the next check of the limits, and until the arms are next computed from θ.
    granted: T,
    fresh: T,
}

impl<T: Real> LaneState<T> {
    fn numbers(self) -> [T; 18] {
        let Self { fast, granted, fresh } = self;
        let FullLoopState { h, u, b, c, r, v, theta, omega, hi, lo } = fast;
        let [[h0, h1], [u0, u1], [b0, b1], [c0, c1], [r0, r1], [v0, v1]] = [h, u, b, c, r, v];
        [h0, h1, u0, u1, b0, b1, c0, c1, r0, r1, v0, v1, theta, omega, hi, lo, granted, fresh]
    }

    fn from_numbers(numbers: [T; 18]) -> Self {
        let [h0, h1, u0, u1, b0, b1, c0, c1, r0, r1, v0, v1, theta, omega, hi, lo, granted, fresh] =
            numbers;
        let (h, u, b, c) = ([h0, h1], [u0, u1], [b0, b1], [c0, c1]);
        let fast = FullLoopState { h, u, b, c, r: [r0, r1], v: [v0, v1], theta, omega, hi, lo };
        Self { fast, granted, fresh }
    }
}

impl<T: Angle> FullConstants<T> {
    fn numbers(self) -> [T; 20] {
        let side = |s: Side<T>| {
            let ([x, y], [b, c]) = (s.normal, s.arm);
            [s.gravity, s.restitution, x, y, b, c, s.slow]
        };
        let [[a, b, c, d, e, f, g], [h, i, j, k, l, m, n]] = self.sides.map(side);
        let Self { rho2, cross, gravity, least_loss, end, longest, .. } = self;
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, rho2, cross, gravity, least_loss, end, longest]
    }

    fn from_numbers(numbers: [T; 20]) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, rest @ ..] = numbers;
        let [rho2, cross, gravity, least_loss, end, longest] = rest;
        let side = |[gravity, restitution, x, y, b, c, slow]: [T; 7]| Side {
            gravity,
            restitution,
            normal: [x, y],
            arm: [b, c],
            slow,
        };
        let sides = [side([a, b, c, d, e, f, g]), side([h, i, j, k, l, m, n])];
        Self { sides, rho2, cross, gravity, least_loss, end, longest }
    }
}

/// Bodies in vector lanes. Each body is between two plain collisions, or has stopped.
#[derive(Debug, Default)]
pub(crate) struct Pool {
    constants: Columns<20>,
    /// The states, as [`LaneState::numbers`], for each of the [`STAGES`] at which bodies have stopped. Active bodies are at the last stage.
    stages: [Columns<18>; STAGES],
    /// Durations of the last flights, by stage.
    dt: [Columns<1>; STAGES],
    /// One bit for each body that has stopped, by stage.
    stopped: [u64; STAGES],
    /// One bit for each active body. The last impact of an active body was at contact 1.
    on: u64,
}

/// Number of places at which a body may stop in a pair of collisions: before the collision at contact 2 if that is not plain, after it if
/// an end is possible, and the same two at contact 1.
const STAGES: usize = 4;

pub(crate) struct Stopped {
    pub(crate) fast: FullLoopState<f64>,
    /// The contact hit last.
    pub(crate) a: usize,
    pub(crate) left: UntilCheck,
    /// The duration of the last flight, if an end is possible.
    pub(crate) may_end: Option<f64>,
}

/// Number of collisions until the next check of the limits, and until the arms are next computed from θ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UntilCheck {
    pub(crate) granted: usize,
    pub(crate) fresh: usize,
}

/// Bodies in the lanes of vector registers.
struct Vector<S: Simd> {
    constants: FullConstants<Lanes<S>>,
    lane: LaneState<Lanes<S>>,
    /// One bit for each active lane. The numbers in the other lanes are meaningless.
    on: u64,
}

impl<S: Simd> Vector<S> {
    #[inline(always)]
    fn stop(&mut self, lanes: u64, pool: &mut Pool, stage: usize, dt: Lanes<S>) {
        if lanes != 0 {
            pool.stages[stage].store(&self.lane.numbers());
            pool.dt[stage].store(&[dt]);
            pool.stopped[stage] |= lanes;
            self.on &= !lanes;
        }
    }

    /// Recomputes the arms in the lanes where this is due, except where θ is too large for it.
    #[cold]
    #[inline(always)]
    fn refresh(&mut self) {
        let LaneState { fast, fresh, .. } = &mut self.lane;
        let (arms, small) = fast.arms(&self.constants);
        let due = small & fresh.at_most(fresh.like(0.0));
        for i in 0..2 {
            fast.b[i] = Lanes::choose(due, arms[i][0], fast.b[i]);
            fast.c[i] = Lanes::choose(due, arms[i][1], fast.c[i]);
        }
        *fresh = Lanes::choose(due, fresh.like(REFRESH as f64), *fresh);
    }

    /// Simulates a collision after an impact at `A`. Lanes whose next collision is not plain stop before it. Lanes in which an end is
    /// possible stop after it.
    #[inline(always)]
    fn plain_collision<const A: usize>(&mut self, pool: &mut Pool) {
        let zero = self.lane.fresh.like(0.0);
        if self.on & Lanes::<S>::bits(self.lane.fresh.at_most(zero)) != 0 {
            self.refresh();
        }
        let LaneState { fast, granted, fresh, .. } = self.lane;
        let next = fast.plain_collision::<A>(&self.constants);
        let plain = next.plain & zero.below(granted) & zero.below(fresh);
        self.stop(self.on & !Lanes::<S>::bits(plain), pool, 2 * A, next.dt);
        let (granted, fresh) = (granted + -1.0, fresh + -1.0);
        self.lane = LaneState { fast: next.after, granted, fresh };
        self.stop(self.on & Lanes::<S>::bits(next.may_end), pool, 2 * A + 1, next.dt);
    }
}

impl Pool {
    /// Adds a body after an impact at contact 1.
    pub(crate) fn put(
        &mut self,
        run: usize,
        fast: FullLoopState<f64>,
        constants: FullConstants<f64>,
        left: UntilCheck,
    ) {
        let (granted, fresh) = (left.granted as f64, left.fresh as f64);
        self.constants.put(run, constants.numbers());
        let lane = LaneState { fast, granted, fresh };
        self.stages[STAGES - 1].put(run, lane.numbers());
        self.on |= 1 << run;
    }

    pub(crate) fn take(&mut self, run: usize) -> Stopped {
        let is_in = |stage: usize| self.stopped[stage] >> run & 1 == 1;
        let stage = (0..STAGES).find(|&stage| is_in(stage)).unwrap_or(STAGES - 1);
        self.stopped[stage] &= !(1 << run);
        let LaneState { fast, granted, fresh } =
            LaneState::from_numbers(self.stages[stage].get(run));
        Stopped {
            fast,
            a: usize::from(stage == 1 || stage == 2),
            left: UntilCheck { granted: granted as usize, fresh: fresh as usize },
            may_end: (stage % 2 == 1).then(|| self.dt[stage].get(run)[0]),
        }
    }

    pub(crate) fn on(&self) -> u64 {
        self.on
    }

    /// Simulates plain collisions until one of the bodies stops.
    #[inline(always)]
    pub(crate) fn alternate<S: Simd>(&mut self, simd: S) {
        let all = self.on;
        let mut vector = Vector {
            constants: FullConstants::from_numbers(self.constants.load(simd)),
            lane: LaneState::from_numbers(self.stages[STAGES - 1].load(simd)),
            on: all,
        };
        while vector.on == all {
            vector.plain_collision::<0>(self);
            vector.plain_collision::<1>(self);
        }
        self.on = vector.on;
        self.stages[STAGES - 1].store(&vector.lane.numbers());
    }
}

impl FullConstants<f64> {
    pub(crate) fn new(body: &PairBody, end: f64) -> Self {
        let side = |i: usize| {
            let k = &body.contacts[i];
            let (gravity, restitution) = (k.gravity, k.restitution);
            // Zero where gravity does not pull the contact to its ground: such arcs are never concave.
            let slow = gravity.max(0.0) * gravity / (k.b * k.b + k.c * k.c);
            Side { gravity, restitution, normal: k.normal.into(), arm: [k.b, k.c], slow }
        };
        let [one, two] = &body.contacts;
        let square = |k: &ContactGeometry| k.b * k.b + k.c * k.c;
        let size = square(one).max(square(two)).sqrt();
        Self {
            sides: [side(0), side(1)],
            rho2: body.rho2,
            cross: body.rho2 * body.n12,
            gravity: body.gravity,
            least_loss: body.least_loss,
            end: end.min(f64::MAX),
            longest: longest(size, one.gravity.max(two.gravity)),
        }
    }
}

impl FullLoopState<f64> {
    pub(crate) fn take_arms(&mut self, arms: [[f64; 2]; 2]) {
        (self.b, self.c) = (arms.map(|arm| arm[0]), arms.map(|arm| arm[1]));
    }

    pub(crate) fn of(state: &FullState, clock: Clock) -> Self {
        let (center, spin) = (&state.center, state.spin);
        Self {
            h: state.gaps.h,
            u: state.gaps.u,
            b: state.b,
            c: state.c,
            r: center.r.into(),
            v: center.v.into(),
            theta: spin.theta,
            omega: spin.omega,
            hi: clock.hi,
            lo: clock.lo,
        }
    }

    /// Returns the clock.
    pub(crate) fn put(&self, state: &mut FullState) -> Clock {
        (state.gaps.h, state.gaps.u) = (self.h, self.u);
        (state.b, state.c) = (self.b, self.c);
        (state.center.r, state.center.v) = (self.r.into(), self.v.into());
        (state.spin.theta, state.spin.omega) = (self.theta, self.omega);
        Clock { hi: self.hi, lo: self.lo }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::collisions::full::tests::state;
    use crate::math::cases::fixed;

    proptest! {
        #![proptest_config(fixed(5))]

        #[test]
        fn a_plain_collision_is_a_flight_and_an_impact(
            u in 0.5..2.0, rate in -1.0..-0.1, h in 0.001..0.1, omega in -1.0..1.0,
        ) {
            let mut state = state([0.0, 0.0, 0.1], [0.3, 0.2, omega]);
            (state.gaps.h, state.gaps.u) = ([0.0, h], [u, rate]);
            let constants = FullConstants::new(&state.body, f64::INFINITY);
            let next = FullLoopState::of(&state, Clock::default()).plain_collision::<0>(&constants);
            prop_assume!(next.plain);
            state.fly(next.dt, &Turn::by(omega * next.dt));
            prop_assert!(state.gaps.h[1].abs() < 1e-15);
            state.gaps.h[1] = 0.0;
            state.hit(1);
            let fast = FullLoopState::of(&state, Clock::default().after(next.dt));
            let [found, expected] = [next.after, fast].map(|fast| LaneState { fast, granted: 0.0, fresh: 0.0 });
            for (found, expected) in found.numbers().into_iter().zip(expected.numbers()) {
                prop_assert!((found - expected).abs() <= 1e-14, "{found} {expected}");
            }
        }
    }
}
