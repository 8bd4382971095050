//! The plain collision of a body that turns slowly: the contact hit last is in the air, the other one lands. It is what most
//! collisions are, and it is the same arithmetic whether the numbers are those of one body or of the lanes of a register.

use fearless_simd::Simd;

use super::{Body, LONG, REFRESH};
use crate::clock::{Clock, renormalised, unnormalised_after};
use crate::flight::Arc;
use crate::lanes::{Columns, Lanes, Real};
use crate::tolerance::TRY_TAIL;
use crate::trig::Turn;
use crate::tumble::Tumble;

/// What does not change at one contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side<T> {
    gravity: T,
    restitution: T,
    normal: [T; 2],
    /// b and c at θ = 0.
    arm: [T; 2],
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

    /// The arms by the rotation itself, and whether it is small enough.
    #[inline(always)]
    pub(crate) fn arms(&self, course: &Course<T>) -> ([[T; 2]; 2], T::Mask) {
        let turn = Turn::small(self.theta);
        let small = self.theta.abs().at_most(self.theta.like(Turn::<T>::SMALL));
        let arms = course.sides.map(|side| {
            let [b, c] = side.arm;
            [b - (b * turn.versed + c * turn.sin), c - (c * turn.versed - b * turn.sin)]
        });
        (arms, small)
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
}

impl<T: Real> Moment<T> {
    fn numbers(self) -> [T; 16] {
        let Self { h, u, b, c, r, v, theta, omega, hi, lo } = self;
        let [[h0, h1], [u0, u1], [b0, b1], [c0, c1], [r0, r1], [v0, v1]] = [h, u, b, c, r, v];
        [h0, h1, u0, u1, b0, b1, c0, c1, r0, r1, v0, v1, theta, omega, hi, lo]
    }

    fn from_numbers(numbers: [T; 16]) -> Self {
        let [h0, h1, u0, u1, b0, b1, c0, c1, r0, r1, v0, v1, theta, omega, hi, lo] = numbers;
        let (h, u, b) = ([h0, h1], [u0, u1], [b0, b1]);
        Self { h, u, b, c: [c0, c1], r: [r0, r1], v: [v0, v1], theta, omega, hi, lo }
    }
}

impl<T: Real> Course<T> {
    fn numbers(self) -> [T; 19] {
        let side = |s: Side<T>| {
            let ([x, y], [b, c]) = (s.normal, s.arm);
            [s.gravity, s.restitution, x, y, b, c, s.slow]
        };
        let [[a, b, c, d, e, f, g], [h, i, j, k, l, m, n]] = self.sides.map(side);
        let Self { rho2, cross, gravity, least_loss, end, .. } = self;
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, rho2, cross, gravity, least_loss, end]
    }

    fn from_numbers(numbers: [T; 19]) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, rho2, cross, gravity, least_loss, end] =
            numbers;
        let side = |[gravity, restitution, x, y, b, c, slow]: [T; 7]| Side {
            gravity,
            restitution,
            normal: [x, y],
            arm: [b, c],
            slow,
        };
        let sides = [side([a, b, c, d, e, f, g]), side([h, i, j, k, l, m, n])];
        Self { sides, rho2, cross, gravity, least_loss, end }
    }
}

/// Bodies side by side, each in the middle of plain collisions or stopped.
#[derive(Debug, Default)]
pub(crate) struct Pool {
    course: Columns<19>,
    moment: Columns<16>,
    left: Columns<2>,
    /// Where bodies have stopped; and the duration of the flight before a look.
    stopped: Columns<16>,
    unused: Columns<2>,
    dt: Columns<1>,
    /// A bit for each body that goes on, after an impact at contact 1.
    on: u64,
    /// Of the others, those that have stopped after an impact at contact 2, and those in which a look is due.
    second: u64,
    look: u64,
}

/// Where a body has stopped.
pub(crate) struct Stopped {
    pub(crate) moment: Moment<f64>,
    /// The contact hit last.
    pub(crate) a: usize,
    pub(crate) left: Left,
    /// Where a look is due: the duration of the flight before.
    pub(crate) look: Option<f64>,
}

/// Collisions until the next look at the limits, and until the arms are next computed from the rotation itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Left {
    pub(crate) granted: usize,
    pub(crate) fresh: usize,
}

/// Bodies in the lanes of a register.
struct Vector<S: Simd> {
    course: Course<Lanes<S>>,
    moment: Moment<Lanes<S>>,
    granted: Lanes<S>,
    fresh: Lanes<S>,
    /// Lanes that go on, a bit for each; the numbers in the others mean nothing.
    on: u64,
}

impl<S: Simd> Vector<S> {
    fn put_back(&self, lanes: u64, pool: &mut Pool) {
        pool.stopped.store_lanes(0, lanes, self.moment.numbers());
        pool.unused.store_lanes(0, lanes, [self.granted, self.fresh]);
    }

    /// Computes arms that are due; lanes that have turned too far for it stop.
    #[cold]
    #[inline(always)]
    fn refresh(&mut self, pool: &mut Pool, a: usize) {
        let (arms, small) = self.moment.arms(&self.course);
        let due = self.fresh.at_most(self.fresh.like(0.0));
        let stop = self.on & Lanes::<S>::bits(due) & !Lanes::<S>::bits(small);
        if stop != 0 {
            self.put_back(stop, pool);
            pool.second |= a as u64 * stop;
            self.on &= !stop;
        }
        for i in 0..2 {
            self.moment.b[i] = Lanes::choose(due, arms[i][0], self.moment.b[i]);
            self.moment.c[i] = Lanes::choose(due, arms[i][1], self.moment.c[i]);
        }
        self.fresh = Lanes::choose(due, self.fresh.like(REFRESH as f64), self.fresh);
    }

    /// A collision after one at `A`; lanes for which it is not a plain one stop before it, lanes in which a look is due
    /// behind it.
    #[inline(always)]
    fn hop<const A: usize>(&mut self, pool: &mut Pool) {
        let zero = self.fresh.like(0.0);
        let due = self.on & Lanes::<S>::bits(self.fresh.at_most(zero));
        if due != 0 {
            self.refresh(pool, A);
        }
        let hop = self.moment.hop::<A>(&self.course);
        let plain = Lanes::<S>::bits(hop.plain & zero.below(self.granted));
        let stop = self.on & !plain;
        if stop != 0 {
            self.put_back(stop, pool);
            pool.second |= A as u64 * stop;
            self.on &= plain;
        }
        self.moment = hop.after;
        (self.granted, self.fresh) = (self.granted + -1.0, self.fresh + -1.0);
        let look = self.on & Lanes::<S>::bits(hop.look);
        if look != 0 {
            self.put_back(look, pool);
            pool.dt.store_lanes(0, look, [hop.dt]);
            pool.second |= (1 - A as u64) * look;
            pool.look |= look;
            self.on &= !look;
        }
    }
}

impl Pool {
    pub(crate) const VECTORS: usize = 1;

    /// Takes a body in whose loop plain collisions are next, after an impact at contact 1.
    pub(crate) fn put(&mut self, run: usize, moment: Moment<f64>, course: Course<f64>, left: Left) {
        self.course.put(run, course.numbers());
        self.moment.put(run, moment.numbers());
        self.left.put(run, [left.granted as f64, left.fresh as f64]);
        self.on |= 1 << run;
        self.second &= !(1 << run);
        self.look &= !(1 << run);
    }

    /// Where a body has stopped.
    pub(crate) fn take(&self, run: usize) -> Stopped {
        let has = |bits: u64| bits >> run & 1 == 1;
        Stopped {
            moment: Moment::from_numbers(self.stopped.get(run)),
            a: usize::from(has(self.second)),
            left: {
                let [granted, fresh] = self.unused.get(run);
                Left { granted: granted as usize, fresh: fresh as usize }
            },
            look: has(self.look).then(|| self.dt.get(run)[0]),
        }
    }

    /// The bodies that go on, a bit for each.
    pub(crate) fn on(&self) -> u64 {
        self.on
    }

    /// Plain collisions, until half of the bodies have come to something else.
    #[inline(always)]
    pub(crate) fn alternate<S: Simd>(&mut self, simd: S) {
        let enough = self.on.count_ones();
        let [granted, fresh] = self.left.load(simd, 0);
        let mut vector = Vector {
            course: Course::from_numbers(self.course.load(simd, 0)),
            moment: Moment::from_numbers(self.moment.load(simd, 0)),
            granted,
            fresh,
            on: self.on,
        };
        while vector.on.count_ones() >= enough {
            vector.hop::<0>(self);
            vector.hop::<1>(self);
        }
        self.on = vector.on;
        self.moment.store(0, vector.moment.numbers());
        self.left.store(0, [vector.granted, vector.fresh]);
    }
}

impl Course<f64> {
    pub(crate) fn new(body: &Body, end: f64) -> Self {
        let side = |i: usize| {
            let k = &body.contacts[i];
            let (gravity, restitution) = (k.gravity, k.restitution);
            let slow = gravity * gravity / (k.b * k.b + k.c * k.c);
            Side { gravity, restitution, normal: k.normal.into(), arm: [k.b, k.c], slow }
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
    pub(crate) fn take_arms(&mut self, arms: [[f64; 2]; 2]) {
        (self.b, self.c) = (arms.map(|arm| arm[0]), arms.map(|arm| arm[1]));
    }

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
