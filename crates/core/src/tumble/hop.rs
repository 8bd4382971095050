//! The plain collision of a body that turns slowly: the contact hit last is in the air, the other one lands. It is what most
//! collisions are, and it is the same arithmetic whether the numbers are those of one body or of the lanes of a register.

use fearless_simd::Simd;

use super::{Body, LONG};
use crate::clock::{Clock, renormalised, unnormalised_after};
use crate::flight::Arc;
use crate::lanes::{Lanes, MaskOf, Real};
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

/// A body on its way through a lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lane {
    pub(crate) moment: Moment<f64>,
    pub(crate) course: Course<f64>,
    /// The contact hit last.
    pub(crate) a: usize,
    /// Collisions that it may still make.
    pub(crate) left: usize,
    /// Where a look is due: the duration of the flight before.
    pub(crate) look: Option<f64>,
    /// Whether it is still in the middle of plain collisions.
    pub(crate) goes_on: bool,
}

#[inline(always)]
fn two<S: Simd>(simd: S, lanes: &[Lane], pair: impl Fn(&Lane) -> [f64; 2]) -> [Lanes<S>; 2] {
    [
        Lanes::gather(simd, lanes, |lane| pair(lane)[0]),
        Lanes::gather(simd, lanes, |lane| pair(lane)[1]),
    ]
}

/// Bodies in the lanes of a vector.
struct Vector<S: Simd> {
    course: Course<Lanes<S>>,
    moment: Moment<Lanes<S>>,
    left: Lanes<S>,
    dt: Lanes<S>,
    /// Lanes that go on, those that have stopped after an impact at contact 2, and those that have stopped for a look.
    on: MaskOf<S>,
    second: MaskOf<S>,
    look: MaskOf<S>,
}

impl<S: Simd> Vector<S> {
    #[inline(always)]
    fn load(simd: S, lanes: &[Lane]) -> Self {
        let side = |i: usize| Side {
            gravity: Lanes::gather(simd, lanes, |lane| lane.course.sides[i].gravity),
            restitution: Lanes::gather(simd, lanes, |lane| lane.course.sides[i].restitution),
            normal: two(simd, lanes, |lane| lane.course.sides[i].normal),
            slow: Lanes::gather(simd, lanes, |lane| lane.course.sides[i].slow),
        };
        let none = Lanes::<S>::mask(simd, 0);
        Self {
            course: Course {
                sides: [side(0), side(1)],
                rho2: Lanes::gather(simd, lanes, |lane| lane.course.rho2),
                cross: Lanes::gather(simd, lanes, |lane| lane.course.cross),
                gravity: Lanes::gather(simd, lanes, |lane| lane.course.gravity),
                least_loss: Lanes::gather(simd, lanes, |lane| lane.course.least_loss),
                end: Lanes::gather(simd, lanes, |lane| lane.course.end),
            },
            moment: Moment {
                h: two(simd, lanes, |lane| lane.moment.h),
                u: two(simd, lanes, |lane| lane.moment.u),
                b: two(simd, lanes, |lane| lane.moment.b),
                c: two(simd, lanes, |lane| lane.moment.c),
                r: two(simd, lanes, |lane| lane.moment.r),
                v: two(simd, lanes, |lane| lane.moment.v),
                theta: Lanes::gather(simd, lanes, |lane| lane.moment.theta),
                omega: Lanes::gather(simd, lanes, |lane| lane.moment.omega),
                hi: Lanes::gather(simd, lanes, |lane| lane.moment.hi),
                lo: Lanes::gather(simd, lanes, |lane| lane.moment.lo),
            },
            left: Lanes::gather(simd, lanes, |lane| lane.left as f64),
            dt: Lanes::gather(simd, lanes, |_| 0.0),
            on: Lanes::<S>::mask(simd, (1 << lanes.len()) - 1),
            second: none,
            look: none,
        }
    }

    #[inline(always)]
    fn store(&self, lanes: &mut [Lane]) {
        let (second, look) = (Lanes::<S>::bits(self.second), Lanes::<S>::bits(self.look));
        let on = Lanes::<S>::bits(self.on);
        let m = &self.moment;
        for (k, lane) in lanes.iter_mut().enumerate() {
            let two = |pair: [Lanes<S>; 2]| pair.map(|value| value.lane(k));
            lane.moment = Moment {
                h: two(m.h),
                u: two(m.u),
                b: two(m.b),
                c: two(m.c),
                r: two(m.r),
                v: two(m.v),
                theta: m.theta.lane(k),
                omega: m.omega.lane(k),
                hi: m.hi.lane(k),
                lo: m.lo.lane(k),
            };
            lane.left = self.left.lane(k) as usize;
            lane.a = (second >> k & 1) as usize;
            lane.look = (look >> k & 1 == 1).then(|| self.dt.lane(k));
            lane.goes_on = on >> k & 1 == 1;
        }
    }

    /// A collision of these lanes after one at `A`; those for which it is a plain one, without a look after it.
    #[inline(always)]
    fn hop<const A: usize>(&mut self, on: MaskOf<S>) -> MaskOf<S> {
        let hop = self.moment.hop::<A>(&self.course);
        let plain = on & hop.plain & self.left.like(0.0).below(self.left);
        self.moment = Moment::choose(plain, &hop.after, &self.moment);
        self.left = Lanes::choose(plain, self.left + -1.0, self.left);
        let look = plain & hop.look;
        self.dt = Lanes::choose(look, hop.dt, self.dt);
        self.look = self.look | look;
        // Who stops before the collision was hit at A last, who stops for a look after it at the other.
        let at_second = if A == 0 { look } else { on & !plain };
        self.second = self.second | at_second;
        plain & !look
    }
}

/// Plain collisions of bodies side by side, until half of them have come to something else. Each stands after an impact at
/// contact 1.
#[inline(always)]
pub(crate) fn alternate_in_lanes<S: Simd>(simd: S, lanes: &mut [Lane]) {
    let mut vector = Vector::load(simd, lanes);
    let enough = lanes.len().div_ceil(2) as u32;
    while Lanes::<S>::bits(vector.on).count_ones() >= enough {
        let one = vector.hop::<0>(vector.on);
        vector.on = vector.hop::<1>(one);
    }
    vector.store(lanes);
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
