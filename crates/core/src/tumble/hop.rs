//! The plain collision of a body that turns slowly: the contact hit last is in the air, the other one lands. It is what most
//! collisions are, and it is the same arithmetic whether the numbers are those of one body or of the lanes of a register.

use super::{Body, LONG};
use crate::clock::{Clock, renormalised, unnormalised_after};
use crate::flight::Arc;
use crate::lanes::Real;
use crate::tolerance::TRY_TAIL;
use crate::tumble::Tumble;

/// What does not change at one contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side<T> {
    gravity: T,
    restitution: T,
    normal: [T; 2],
    /// (g/|d|)²: an arc is concave for ever where ω⁴ is below.
    slow: T,
}

/// What does not change in a run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course<T> {
    sides: [Side<T>; 2],
    rho2: T,
    /// ρ² n_1·n_2
    cross: T,
    gravity: T,
    least_loss: T,
    /// The time limit, or the largest double.
    end: T,
}

/// The state of a body, right after an impact, and the clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment<T> {
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

/// A collision, if it is of the plain kind.
pub(crate) struct Hop<T: Real> {
    pub(crate) after: Moment<T>,
    pub(crate) plain: T::Mask,
    /// Whether what follows may be summed or frozen, or the contact just hit stays: a look is due.
    pub(crate) look: T::Mask,
    /// Rates before the impact, and its own-rate jump.
    pub(crate) before: [T; 2],
    pub(crate) jump: T,
    /// Duration of the flight.
    pub(crate) dt: T,
}

/// Which ends of an accumulation are worth a look, after an impact at contact a: bouncing at a, clattering, and both contacts
/// at rest so soon that the geometry may be frozen. Each is tested without a root or a division.
pub(crate) struct Near<T: Real> {
    pub(crate) bounce: T::Mask,
    pub(crate) clatter: T::Mask,
    pub(crate) brief: T::Mask,
}

/// Time to rest, relative to the time elapsed, above which freezing is not even considered: it is at least 8 speed/(g(1−e)).
#[inline(always)]
pub(crate) fn is_brief<T: Real>(h: [T; 2], u: [T; 2], gravity: [T; 2], loss: T, now: T) -> T::Mask {
    let most = T::choose(gravity[0].below(gravity[1]), gravity[1], gravity[0]);
    let brief = now * LONG * most * loss;
    let quick = |i: usize| {
        let speed = u[i] * u[i] + gravity[i] * 2.0 * h[i];
        (speed * 64.0).at_most(brief * brief)
    };
    now.like(0.0).below(brief) & quick(0) & quick(1)
}

impl<T: Real> Moment<T> {
    fn arc(&self, i: usize, course: &Course<T>) -> Arc<T> {
        let (g, omega) = (course.sides[i].gravity, self.omega);
        Arc { h: self.h[i], u: self.u[i], g, b: self.b[i], c: self.c[i], omega }
    }

    /// −ψ_i (b_i² + ρ²)
    #[inline(always)]
    fn cross(&self, course: &Course<T>) -> T {
        self.b[0] * self.b[1] + course.cross
    }

    /// g_i + c_iω²
    #[inline(always)]
    fn pull(&self, i: usize, course: &Course<T>) -> T {
        course.sides[i].gravity + self.c[i] * self.omega * self.omega
    }

    /// What to look at after an impact at `A` that ended a flight of `tau`.
    #[inline(always)]
    pub(crate) fn near<const A: usize>(&self, course: &Course<T>, tau: T) -> Near<T> {
        let b = 1 - A;
        let (u_a, u_b, h_b, e) = (self.u[A], self.u[b], self.h[b], course.sides[A].restitution);
        let gravity = [self.pull(0, course), self.pull(1, course)];
        let (cross, own) = (self.cross(course), self.b[A] * self.b[A] + course.rho2);
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

        let brief = is_brief(self.h, self.u, gravity, course.least_loss, self.hi);
        Near { bounce, clatter, brief }
    }

    /// The next collision, at the contact that was not hit last. `A`: that was.
    #[inline(always)]
    pub(crate) fn hop<const A: usize>(&self, course: &Course<T>) -> Hop<T> {
        let b = 1 - A;
        let (omega, zero) = (self.omega, self.omega.like(0.0));
        let (arc_a, arc_b) = (self.arc(A, course), self.arc(b, course));
        let w4 = omega * omega * (omega * omega);
        let slow = w4.below(course.sides[0].slow) & w4.below(course.sides[1].slow);
        let (landing, found) = arc_b.concave_touchdown();
        let (dt, turn) = (landing.dt, &landing.turn);

        // A concave arc from the ground is above it until it lands: its sign decides.
        let height = arc_a.gap_turned(dt, turn);
        let rates = [arc_a.rate_turned(dt, turn), arc_b.rate_turned(dt, turn)];
        let plain = slow
            & found
            & zero.below(height)
            & rates[1].below(zero)
            & (self.hi + dt).at_most(course.end);

        let mut after = *self;
        (after.hi, after.lo) = renormalised(unnormalised_after(self.hi, self.lo, dt));
        after.theta = self.theta + omega * dt;
        after.r = [self.r[0] + self.v[0] * dt, self.r[1] + self.v[1] * dt];
        after.r[1] = after.r[1] - course.gravity * 0.5 * dt * dt;
        after.v[1] = self.v[1] - course.gravity * dt;
        for i in 0..2 {
            let (b, c) = (self.b[i], self.c[i]);
            after.b[i] = b - (b * turn.versed + c * turn.sin);
            after.c[i] = c - (c * turn.versed - b * turn.sin);
        }

        let (s, e, normal) = (-rates[1], course.sides[b].restitution, course.sides[b].normal);
        let jump = (e + 1.0) * s;
        let per_own = jump / (after.b[b] * after.b[b] + course.rho2);
        let push = course.rho2 * per_own;
        (after.h[A], after.h[b]) = (height, zero);
        after.u[b] = e * s;
        after.u[A] = rates[0] + after.cross(course) * per_own;
        after.omega = omega + after.b[b] * per_own;
        after.v = [after.v[0] + normal[0] * push, after.v[1] + normal[1] * push];

        let near = if A == 0 { after.near::<1>(course, dt) } else { after.near::<0>(course, dt) };
        let look = near.bounce | near.clatter | near.brief | after.u[b].at_most(zero);
        let before = if A == 0 { rates } else { [rates[1], rates[0]] };
        Hop { after, plain, look, before, jump, dt }
    }

    /// `self` where the mask says so, else `other`.
    #[inline(always)]
    pub(crate) fn choose(mask: T::Mask, yes: &Self, no: &Self) -> Self {
        let one = |yes: T, no: T| T::choose(mask, yes, no);
        let two = |yes: [T; 2], no: [T; 2]| [one(yes[0], no[0]), one(yes[1], no[1])];
        Self {
            h: two(yes.h, no.h),
            u: two(yes.u, no.u),
            b: two(yes.b, no.b),
            c: two(yes.c, no.c),
            r: two(yes.r, no.r),
            v: two(yes.v, no.v),
            theta: one(yes.theta, no.theta),
            omega: one(yes.omega, no.omega),
            hi: one(yes.hi, no.hi),
            lo: one(yes.lo, no.lo),
        }
    }
}

impl Course<f64> {
    pub(crate) fn new(body: &Body, end: f64) -> Self {
        let side = |i: usize| {
            let k = &body.contacts[i];
            let (gravity, restitution) = (k.gravity, k.restitution);
            let slow = gravity * gravity / (k.b * k.b + k.c * k.c);
            Side { gravity, restitution, normal: k.normal.into(), slow }
        };
        Self {
            sides: [side(0), side(1)],
            rho2: body.rho2,
            cross: body.rho2 * body.n12,
            gravity: body.gravity,
            least_loss: body.least_loss,
            end: end.min(f64::MAX),
        }
    }
}

impl Moment<f64> {
    pub(crate) fn of(state: &Tumble, clock: Clock) -> Self {
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

    /// Puts the state back; returns the clock.
    pub(crate) fn put(&self, state: &mut Tumble) -> Clock {
        (state.gaps.h, state.gaps.u) = (self.h, self.u);
        (state.b, state.c) = (self.b, self.c);
        (state.center.r, state.center.v) = (self.r.into(), self.v.into());
        (state.spin.theta, state.spin.omega) = (self.theta, self.omega);
        Clock { hi: self.hi, lo: self.lo }
    }
}
