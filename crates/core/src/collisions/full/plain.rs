//! The plain collision of a body that turns slowly: the contact hit last is in the air, and the other one lands. Most
//! collisions are plain.

use crate::body::geometry::ContactGeometry;
use crate::collisions::full::{FullState, PairBody};
use crate::flight::{GapArc, longest};
use crate::impact::newton;
use crate::math::clock::{Clock, renormalised, unnormalised_after};
use crate::math::turn::Turn;
use crate::tolerance::{TAIL_TOO_LONG, TRY_TAIL};

/// Constants of one contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    gravity: f64,
    restitution: f64,
    normal: [f64; 2],
    /// b and c at θ = 0.
    arm: [f64; 2],
    /// (g/|d|)². If ω⁴ is below this, the gap is a concave function of time for all times.
    slow: f64,
}

/// Constants of a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullConstants {
    sides: [Side; 2],
    rho2: f64,
    /// ρ² n_1·n_2
    cross: f64,
    gravity: f64,
    least_loss: f64,
    /// The time limit, or the largest double if there is none.
    end: f64,
    /// The longest flight from the ground after which the position of the body is still known in spite of rounding, in s.
    longest: f64,
}

/// The state of a body, right after an impact, and the clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullLoopState {
    h: [f64; 2],
    u: [f64; 2],
    b: [f64; 2],
    c: [f64; 2],
    r: [f64; 2],
    v: [f64; 2],
    theta: f64,
    omega: f64,
    hi: f64,
    lo: f64,
}

/// A plain collision.
pub(crate) struct FullPlainCollision {
    pub(crate) after: FullLoopState,
    /// Whether one of the ends of [`Near`] is possible after the collision, or the contact just hit stays closed.
    pub(crate) may_end: bool,
    /// Rates before the impact, and its own-rate jump.
    pub(crate) before: [f64; 2],
    pub(crate) jump: f64,
    /// Duration of the flight.
    pub(crate) dt: f64,
}

/// Which ends of an accumulation are possible after an impact at contact a: bouncing at a, clattering, and rest of both contacts so soon
/// that the geometry may be frozen. The tests need no root and no division.
pub(crate) struct Near {
    pub(crate) bounce: bool,
    pub(crate) clatter: bool,
    pub(crate) freezes: bool,
}

/// Whether the geometry may be frozen soon: the time to rest is at least 8 speed/(g(1−e)), and this may be below [`TAIL_TOO_LONG`] times
/// the time elapsed. `squares`: u² + 2gh of both contacts.
#[inline(always)]
pub(crate) fn may_freeze(squares: [f64; 2], gravity: [f64; 2], loss: f64, now: f64) -> bool {
    let most = if gravity[0] < gravity[1] { gravity[1] } else { gravity[0] };
    let freezes = now * TAIL_TOO_LONG * most * loss;
    let bound = freezes * freezes;
    (0.0 < freezes) & (squares[0] * 64.0 <= bound) & (squares[1] * 64.0 <= bound)
}

impl FullLoopState {
    fn arc(&self, i: usize, constants: &FullConstants) -> GapArc {
        let (g, omega) = (constants.sides[i].gravity, self.omega);
        GapArc { h: self.h[i], u: self.u[i], g, b: self.b[i], c: self.c[i], omega }
    }

    /// −ψ_i (b_i² + ρ²)
    #[inline(always)]
    fn cross(&self, constants: &FullConstants) -> f64 {
        self.b[0] * self.b[1] + constants.cross
    }

    /// g_i + c_iω²
    #[inline(always)]
    fn pull(&self, i: usize, constants: &FullConstants) -> f64 {
        constants.sides[i].gravity + self.c[i] * self.omega * self.omega
    }

    /// The ends to test for after an impact at `A` that ended a flight of `tau`.
    #[inline(always)]
    pub(crate) fn near<const A: usize>(&self, constants: &FullConstants, tau: f64) -> Near {
        let b = 1 - A;
        let (u_a, u_b, h_b, e) = (self.u[A], self.u[b], self.h[b], constants.sides[A].restitution);
        let gravity = [self.pull(0, constants), self.pull(1, constants)];
        let (cross, own) = (self.cross(constants), self.b[A] * self.b[A] + constants.rho2);

        // Bouncing at a, T = 2u/(g(1−e)): whether h_b(T) ≥ 0.
        let (scale, t) = (gravity[A] * (1.0 - e), u_a * 2.0);
        let fall = gravity[b] * own - e * cross * gravity[A];
        let bounce =
            (0.0 < gravity[A]) & (t * 0.5 * t * fall <= (h_b * scale + t * u_b) * scale * own);

        let (drop, square) = (gravity[b] * 2.0 * h_b, u_b * u_b);
        let clatter = (u_b < 0.0)
            & (cross < 0.0)
            & (drop * drop * tau <= self.hi * TRY_TAIL * (square * square));

        // h_a = 0
        let freezes =
            may_freeze([u_a * u_a, square + drop], gravity, constants.least_loss, self.hi);
        Near { bounce, clatter, freezes }
    }

    /// Computes the arms from θ if θ is small enough for this; returns whether it is.
    pub(crate) fn refresh(&mut self, constants: &FullConstants) -> bool {
        let small = self.theta.abs() <= Turn::SMALL;
        if small {
            let turn = Turn::small(self.theta);
            for (i, side) in constants.sides.iter().enumerate() {
                [self.b[i], self.c[i]] = turn.turned(side.arm);
            }
        }
        small
    }

    /// The next collision, if it is plain. `A`: the contact hit last; the other one lands.
    #[inline(always)]
    pub(crate) fn plain_collision<const A: usize>(
        &self,
        constants: &FullConstants,
    ) -> Option<FullPlainCollision> {
        let b = 1 - A;
        let omega = self.omega;
        let (arc_a, arc_b) = (self.arc(A, constants), self.arc(b, constants));
        let w4 = omega * omega * (omega * omega);
        if !(w4 < constants.sides[0].slow && w4 < constants.sides[1].slow) {
            return None;
        }
        let landing = arc_b.concave_touchdown()?;
        let (dt, turn) = (landing.dt, &landing.turn);

        // A concave arc that starts on the ground is above it until it lands: the sign of the gap decides.
        let height = arc_a.gap_turned(dt, turn);
        let rates = [arc_a.rate_turned(dt, turn), arc_b.rate_turned(dt, turn)];
        let (hi, lo) = renormalised(unnormalised_after(self.hi, self.lo, dt));
        let plain =
            (0.0 < height) & (rates[1] < 0.0) & (hi <= constants.end) & (dt <= constants.longest);
        if !plain {
            return None;
        }

        let mut after = *self;
        (after.hi, after.lo) = (hi, lo);
        after.theta = self.theta + omega * dt;
        after.r = [self.r[0] + self.v[0] * dt, self.r[1] + self.v[1] * dt];
        after.r[1] -= constants.gravity * 0.5 * dt * dt;
        after.v[1] = self.v[1] - constants.gravity * dt;
        for i in 0..2 {
            [after.b[i], after.c[i]] = turn.turned([self.b[i], self.c[i]]);
        }

        let (s, e, normal) = (-rates[1], constants.sides[b].restitution, constants.sides[b].normal);
        let (jump, per_own) = newton::own_jump(e, s, after.b[b] * after.b[b] + constants.rho2);
        let push = constants.rho2 * per_own;
        (after.h[A], after.h[b]) = (height, 0.0);
        after.u[b] = e * s;
        after.u[A] = rates[0] + after.cross(constants) * per_own;
        after.omega = omega + after.b[b] * per_own;
        after.v = [after.v[0] + normal[0] * push, after.v[1] + normal[1] * push];

        let near =
            if A == 0 { after.near::<1>(constants, dt) } else { after.near::<0>(constants, dt) };
        let may_end = near.bounce | near.clatter | near.freezes | (after.u[b] <= 0.0);
        let before = if A == 0 { rates } else { [rates[1], rates[0]] };
        Some(FullPlainCollision { after, may_end, before, jump, dt })
    }
}

/// Number of collisions until the next check of the limits, and until the arms are next computed from θ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UntilCheck {
    pub(crate) granted: usize,
    pub(crate) fresh: usize,
}

impl FullConstants {
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

impl FullLoopState {
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
            prop_assume!(next.is_some());
            let next = next.expect("a plain collision");
            state.fly(next.dt, &Turn::by(omega * next.dt));
            prop_assert!(state.gaps.h[1].abs() < 1e-15);
            state.gaps.h[1] = 0.0;
            state.impact(1);
            let fast = FullLoopState::of(&state, Clock::default().after(next.dt));
            let numbers = |fast: FullLoopState| {
                let FullLoopState { h, u, b, c, r, v, theta, omega, hi, lo } = fast;
                [h, u, b, c, r, v, [theta, omega], [hi, lo]].concat()
            };
            for (found, expected) in numbers(next.after).into_iter().zip(numbers(fast)) {
                prop_assert!((found - expected).abs() <= 1e-14, "{found} {expected}");
            }
        }
    }
}
