//! Collisions of the full model: finite rotation, impacts at the configuration of the moment.
//!
//! The state is kept in gap coordinates (h, u) with b_i, c_i of the rotated arms; positions of the body
//! follow from the impulses. Where what remains of an accumulation is so short that the geometry cannot
//! change any more, the frozen model sums it.

mod hop;

use nalgebra::{Vector2, Vector3};

use crate::body::geometry::{ContactGeometry, couplings};
use crate::body::local_model::LocalModel;
use crate::collisions::local::{LoopExit, are_one, time_to_rest};
use crate::collisions::log::{Center, Collision, Log, Spin};
use crate::flight::{GapArc, Touchdown, is_lost};
use crate::impact::newton;
use crate::math::turn::Turn;
use crate::tolerance::TAIL;
use crate::zeno::{FrozenModel, Gaps, share};
pub(crate) use hop::Pool;
use hop::{Course, Left, Moment, Stopped};

/// Constants of a body on two contacts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body {
    pub(crate) contacts: [ContactGeometry; 2],
    /// ρ²
    pub(crate) rho2: f64,
    /// n_1·n_2
    pub(crate) n12: f64,
    /// g
    pub(crate) gravity: f64,
    /// 1 − e of the more elastic contact
    least_loss: f64,
}

/// State of the full model: gap coordinates, centre of mass and rotation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullState {
    pub(crate) body: Body,
    pub(crate) gaps: Gaps,
    pub(crate) center: Center,
    pub(crate) spin: Spin,
    /// b_i, c_i at θ.
    pub(crate) b: [f64; 2],
    pub(crate) c: [f64; 2],
}

/// Collisions between two computations of b, c from θ itself: in between they are turned step by step and
/// collect a rounding each.
const REFRESH: usize = 32;

/// Time to rest, relative to the time elapsed, above which freezing is not even considered.
const LONG: f64 = 1e-3;

/// Safety factor on the change of the frozen geometry within a tail.
const MARGIN: f64 = 4.0;

/// Distance of two contacts, relative to √(b² + ρ²), from which on equal rates say that nothing turns: of what is nearer they
/// would, by their rounding, even where it does.
const APART: f64 = 1e-3;

impl FullState {
    pub(crate) fn new(body: Body, gaps: Gaps, center: Center, spin: Spin) -> Self {
        let turn = Turn::by(spin.theta);
        let arms = body.contacts.map(|k| k.turned(&turn));
        let (b, c) = (arms.map(|arm| arm.0), arms.map(|arm| arm.1));
        Self { body, gaps, center, spin, b, c }
    }

    /// Arms that were turned step by step, anew.
    pub(crate) fn refresh(&mut self) {
        for i in 0..2 {
            (self.b[i], self.c[i]) =
                self.body.contacts[i].refreshed(self.spin.theta, self.b[i], self.c[i]);
        }
    }

    pub(crate) fn arc(&self, i: usize) -> GapArc {
        GapArc {
            h: self.gaps.h[i],
            u: self.gaps.u[i],
            g: self.body.contacts[i].gravity,
            b: self.b[i],
            c: self.c[i],
            omega: self.spin.omega,
        }
    }

    /// Displacement of the centre of mass (m) and rotation.
    pub(crate) fn q(&self) -> Vector3<f64> {
        Vector3::new(self.center.r.x, self.center.r.y, self.spin.theta)
    }

    /// g_i + c_iω²: acceleration into terrain i.
    pub(crate) fn effective_gravity(&self, i: usize) -> f64 {
        self.body.contacts[i].gravity + self.c[i] * self.spin.omega * self.spin.omega
    }

    /// b_i² + ρ²
    fn own(&self, i: usize) -> f64 {
        self.b[i] * self.b[i] + self.body.rho2
    }

    /// ρ²/(b_i² + ρ²): translational impulse per unit mass and own-rate jump.
    pub(crate) fn share(&self, i: usize) -> f64 {
        self.body.rho2 / self.own(i)
    }

    /// (ψ, φ) of this moment.
    fn couplings(&self) -> ([f64; 2], [f64; 2]) {
        couplings(self.b[0], self.b[1], self.body.n12, self.body.rho2)
    }

    /// The local model with the geometry and the effective gravity of this moment.
    pub(crate) fn frozen(&self) -> LocalModel {
        let (psi, phi) = self.couplings();
        let e = [0, 1].map(|i| self.body.contacts[i].restitution);
        LocalModel::frozen([0, 1].map(|i| self.effective_gravity(i)), psi, phi, e)
    }

    /// Whether a flight to the next landing loses the place of the body: of one that lies flat and does not turn, or has one
    /// contact, there is nothing but the rotation to lose.
    #[inline]
    fn is_lost(&self, contact: usize, dt: f64) -> bool {
        let (u, omega) = (self.gaps.u[contact], self.spin.omega);
        let g = self.body.contacts[contact].gravity;
        let turned = self.spin.theta != 0.0 || omega != 0.0;
        let way = if turned && self.gaps.h[1 - contact] < f64::INFINITY {
            dt * (u.abs() + 0.5 * g.abs() * dt)
        } else {
            0.0
        };
        let square = |i: usize| self.b[i] * self.b[i] + self.c[i] * self.c[i];
        is_lost(omega * dt, way, square(0).max(square(1)).max(self.body.rho2))
    }

    /// Moves on by a flight.
    #[inline]
    pub(crate) fn fly(&mut self, dt: f64, turn: &Turn) {
        for i in 0..2 {
            let arc = self.arc(i);
            self.gaps.h[i] = arc.gap_turned(dt, turn).max(0.0);
            self.gaps.u[i] = arc.rate_turned(dt, turn);
            [self.b[i], self.c[i]] = turn.turned([self.b[i], self.c[i]]);
        }
        self.spin.theta += self.spin.omega * dt;
        self.center.fly(self.body.gravity, dt);
    }

    /// Applies own-rate jumps at the contacts to gaps, spin and impulses.
    pub(crate) fn kick(&mut self, jump: [f64; 2]) {
        let cross = self.b[0] * self.b[1] + self.body.rho2 * self.body.n12;
        for i in 0..2 {
            let per_own = jump[i] / self.own(i);
            self.gaps.u[i] += jump[i];
            self.gaps.u[1 - i] += cross * per_own; // −ψ_i J_i
            self.spin.omega += self.b[i] * per_own; // −φ_i J_i
            self.center.v += self.body.contacts[i].normal * (self.body.rho2 * per_own);
        }
    }

    /// First-order effect of the rotation during a tail of duration `t` that began at `start` and was summed
    /// there: an impulse P at time τ acts on the arm b − c ωτ, so that
    /// Δω = −Σ c_i ω Σ P τ/ρ², and Σ P τ = (Σ P) t − ∫(Σ P).
    ///
    /// Speeds shrink more slowly than times on the way to a 2-Zeno: this matters where the times do not.
    pub(crate) fn turn_tail(&mut self, start: &Self, t: f64, jump: [f64; 2], path: [f64; 2]) {
        let omega = 0.5 * (start.spin.omega + self.spin.omega);
        let moment: f64 = (0..2).map(|i| start.c[i] * (jump[i] * t - path[i])).sum();
        self.spin.omega -= omega * moment / self.body.rho2;
    }

    /// Gives the body the velocity that its gap rates say of these contacts: after a tail that was summed in the geometry of its
    /// start, whose arms have turned a little since, or after so many impacts that their jumps cancel.
    pub(crate) fn follow(&mut self, closed: [bool; 2]) {
        if closed == [true, true] {
            self.forget_rounding();
        }
        let left = |i: usize| {
            let n = self.body.contacts[i].normal;
            self.gaps.u[i] - (n.dot(&self.center.v) + self.b[i] * self.spin.omega)
        };
        let jump = match closed {
            [true, true] => share(self.couplings().0, [left(0), left(1)]),
            _ => [0, 1].map(|i| if closed[i] { left(i) } else { 0.0 }),
        };
        let rates = self.gaps.u;
        self.kick(jump);
        self.gaps.u = rates;
        if closed == [true, true] {
            self.forget_rounding();
        }
    }

    /// Two gaps over parallel ground that change at the same rate leave no rotation at all: what the impulses
    /// say of it is rounding.
    pub(crate) fn forget_rounding(&mut self) {
        let [one, two] = self.body.contacts;
        let same = self.gaps.u[0] == self.gaps.u[1];
        let apart = (self.b[0] - self.b[1]).abs() > APART * self.own(0).max(self.own(1)).sqrt();
        if same && one.normal == two.normal && apart {
            self.spin.omega = 0.0;
        }
    }

    /// Frictionless Newton impact at `i` [Or & Rimon 2008, (4)]; returns its own-rate jump.
    fn hit(&mut self, i: usize) -> f64 {
        let (s, e) = (-self.gaps.u[i], self.body.contacts[i].restitution);
        let (jump, per_own) = newton::own_jump(e, s, self.own(i));
        let cross = self.b[0] * self.b[1] + self.body.rho2 * self.body.n12;
        self.gaps.u[i] = e * s;
        self.gaps.u[1 - i] += cross * per_own;
        self.spin.omega += self.b[i] * per_own;
        self.center.v += self.body.contacts[i].normal * (self.body.rho2 * per_own);
        jump
    }

    /// Writes down an impact that has just happened.
    fn write_down(&self, contact: usize, before: [f64; 2], jump: f64, log: &mut Log) {
        log.collisions.push(Collision {
            elapsed: log.clock,
            contact,
            before,
            after: self.gaps.u,
            jump,
            other_gap: self.gaps.h[1 - contact],
        });
        log.bodies.push((self.center, self.spin));
    }

    /// Which contact lands next: the contact, its touchdown, and whether both land at once. `active`: the
    /// contact just hit.
    fn next_landing(&self, active: Option<usize>) -> Option<(usize, Touchdown, bool)> {
        let arcs = [self.arc(0), self.arc(1)];
        if let Some(a) = active
            && arcs[a].is_concave()
            && let Some(landing) = arcs[1 - a].find_touchdown()
        {
            // A concave arc from the ground is above it until it lands: its sign decides.
            let height = arcs[a].gap_turned(landing.dt, &landing.turn);
            if height > 0.0 {
                return Some((1 - a, landing, false));
            }
            let back = arcs[a].find_touchdown()?;
            return Some(if back.dt < landing.dt {
                (a, back, false)
            } else {
                (1 - a, landing, back.dt == landing.dt)
            });
        }
        match (arcs[0].find_touchdown(), arcs[1].find_touchdown()) {
            (Some(one), Some(two)) => {
                let tie = are_one(one.dt, two.dt);
                Some(if two.dt < one.dt { (1, two, tie) } else { (0, one, tie) })
            }
            (Some(one), None) => Some((0, one, false)),
            (None, Some(two)) => Some((1, two, false)),
            (None, None) => None,
        }
    }

    /// How the flights after an impact at `a` end here, if they do: whether the tail may be summed with frozen geometry.
    fn accumulates(&self, a: usize, tau: f64, course: &Course<f64>, log: &Log) -> Option<LoopExit> {
        let moment = Moment::of(self, log.clock);
        let near =
            if a == 0 { moment.near::<0>(course, tau) } else { moment.near::<1>(course, tau) };
        let gravity = [self.effective_gravity(0), self.effective_gravity(1)];
        let now = log.clock.hi;
        if near.bounce
            && let Some(halt) = self.bounces(a, gravity, log)
        {
            return Some(halt);
        }
        if near.clatter {
            let frozen = FrozenModel::new(&self.frozen());
            if let Some(tail) = frozen.clatter_tail(a, &self.gaps)
                && now + tail.duration <= log.end
            {
                let (b, t) = (1 - a, tail.duration);
                let sum = frozen.settle(&self.gaps, t);
                let drift = self.drift(t, sum.jump[a].abs(), sum.jump[b].abs());
                let pull = drift.gravity[0] + drift.gravity[1];
                let geometry =
                    drift.psi / frozen.psi[a] * frozen.sensitivity() + pull * t / -self.gaps.u[b];
                if tail.error + MARGIN * t * geometry <= TAIL * now
                    && self.is_turn_lost(t, sum.jump)
                    && frozen.certainly_clatters(a, &self.gaps)
                {
                    return Some(LoopExit::Clatter(tail));
                }
            }
        }
        if near.brief && self.is_brief(gravity, log) {
            return Some(LoopExit::Freeze);
        }
        // Drawn off the ground or not, a contact that the impact stops is not in flight: its mode is to be found.
        (self.gaps.u[a] == 0.0).then_some(LoopExit::Tie)
    }

    /// Whether the rotation during a tail of duration `t` with these own-rate jumps changes the speeds at its end by less
    /// than their rounding: [`FullState::turn_tail`] knows its effect, Δω ≤ Σ |c_i| ωt J_i/(b_i² + ρ²), only roughly, for ω does
    /// not change uniformly. On parallel ground the contacts at rest leave no speed that it could change.
    fn is_turn_lost(&self, t: f64, jump: [f64; 2]) -> bool {
        let per_own = [0, 1].map(|i| jump[i].abs() / self.own(i));
        let omega =
            self.spin.omega.abs() + (0..2).map(|i| self.b[i].abs() * per_own[i]).sum::<f64>();
        let change = omega * t * (0..2).map(|i| self.c[i].abs() * per_own[i]).sum::<f64>();
        let rho = self.body.rho2.sqrt();
        let speed = self.center.v.x.abs() + self.center.v.y.abs() + rho * self.spin.omega.abs();
        self.body.n12.abs() >= 1.0 || rho * change <= f64::EPSILON * speed
    }

    /// Whether the bounce tail at `a` may be summed with frozen geometry.
    #[cold]
    fn bounces(&self, a: usize, gravity: [f64; 2], log: &Log) -> Option<LoopExit> {
        let (b, e) = (1 - a, self.body.contacts[a].restitution);
        let (u_a, u_b, h_b) = (self.gaps.u[a], self.gaps.u[b], self.gaps.h[b]);
        let now = log.clock.hi;
        let frozen = FrozenModel::new(&self.frozen());
        let psi_a = frozen.psi[a];
        let t = 2.0 * u_a / (gravity[a] * (1.0 - e));
        let end = h_b + t * (u_b - 0.5 * t * (gravity[b] + e * psi_a * gravity[a]));
        if !(end >= 0.0 && now + t <= log.end) {
            return None;
        }
        let drift = self.drift(t, u_a * (1.0 + e) / (1.0 - e), 0.0);
        let miss = t * t * (drift.gravity[b] + drift.psi * gravity[a]);
        if !drift.is_little() {
            return None;
        }
        let clear = if gravity[b] >= 0.0 {
            let mut gaps = self.gaps;
            gaps.h[a] = 0.0;
            (end > miss || miss == 0.0) && frozen.bounce_tail(a, &gaps).is_some()
        } else {
            // Flung upwards, b moves on a convex arc: out of reach of everything that can act on it.
            let kicks = 2.0 * psi_a.abs() * u_a * t / (1.0 - e);
            h_b >= miss + u_b.abs() * t + gravity[b].abs() * t * t + kicks
        };
        (clear && t * drift.gravity[a] <= TAIL * (now + t) * gravity[a])
            .then_some(LoopExit::Bounce { contact: a, duration: t })
    }

    /// Whether both contacts, bouncing in step until they rest after `t`, go on landing together while the body turns.
    pub(crate) fn keeps_step(&self, t: f64, log: &Log) -> bool {
        let [one, two] = FrozenModel::new(&self.frozen()).settle(&self.gaps, t).jump;
        let drift = self.drift(t, one.abs(), two.abs());
        let late = |i: usize| t * drift.gravity[i] / self.effective_gravity(i);
        drift.is_little() && late(0).max(late(1)) <= TAIL * (log.clock.hi + t)
    }

    /// Whether both contacts come to rest so soon that the geometry cannot change any more until then.
    pub(crate) fn may_freeze(&self, log: &Log) -> bool {
        let gravity = [self.effective_gravity(0), self.effective_gravity(1)];
        let (Gaps { h, u }, loss) = (self.gaps, self.body.least_loss);
        let squares = [0, 1].map(|i| u[i] * u[i] + 2.0 * gravity[i] * h[i]);
        hop::is_brief(squares, gravity, loss, log.clock.hi) && self.is_brief(gravity, log)
    }

    #[cold]
    fn is_brief(&self, gravity: [f64; 2], log: &Log) -> bool {
        let now = log.clock.hi;
        let frozen = FrozenModel::new(&self.frozen());
        let Some(t) = time_to_rest(&frozen, &self.gaps) else { return false };
        if t > LONG * now || now + t > log.end {
            return false;
        }
        let most = gravity[0].abs().max(gravity[1].abs()) * t;
        let drift = self.drift(t, most, most);
        let geometry = drift.psi / frozen.psi[0].abs().min(frozen.psi[1].abs()).max(f64::EPSILON)
            * frozen.sensitivity()
            + (0..2)
                .map(|i| {
                    let j = 1 - i;
                    let change = drift.gravity[i]
                        + frozen.psi[j].abs() * drift.gravity[j]
                        + drift.psi * gravity[j].abs();
                    drift.gravity[i] / gravity[i].abs() + change / frozen.held_gravity(i)
                })
                .sum::<f64>();
        drift.is_little() && t * geometry <= TAIL * now
    }

    /// Bounds on how far g_i + c_iω² and ψ change within `t` while own-rate jumps of these sizes act at
    /// the two contacts (order: any).
    fn drift(&self, t: f64, jump_a: f64, jump_b: f64) -> Drift {
        let (b, c, rho2) = (self.b, self.c, self.body.rho2);
        let lever = [0, 1].map(|i| b[i].abs() / self.own(i));
        let kick = (jump_a + jump_b) * lever[0].max(lever[1]);
        let omega = self.spin.omega.abs() + kick;
        let angle = omega * t;
        let gravity = [0, 1].map(|i| {
            2.0 * c[i].abs() * omega * kick
                + omega * omega * angle * (b[i].abs() + c[i].abs() * angle)
        });
        let cross = b[0] * b[1] + rho2 * self.body.n12;
        let slope = [0, 1].map(|i| {
            let own = self.own(i);
            ((c[0] * b[1] + b[0] * c[1]) / own + cross / (own * own) * -2.0 * b[i] * c[i]).abs()
        });
        let bend = (b[0] * b[1]).abs().max(c[0].abs() * c[1].abs()) / self.own(0).min(self.own(1));
        Drift { angle, gravity, psi: slope[0].max(slope[1]) * angle + 4.0 * bend * angle * angle }
    }
}

/// Collisions one after the other, under way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullCollisions {
    course: Course<f64>,
    /// The contact hit last, if it is in the air.
    active: Option<usize>,
    left: Left,
}

/// Collisions by which it pays to go into a register.
const WORTH: usize = 4;
/// Collisions before which it is not worth while where each takes all energy: most motions that can be summed are by then. The
/// less one takes, the longer they last.
const YOUNG: f64 = 16.0;

impl FullCollisions {
    /// Puts the body into a lane, where plain collisions are next, if they may be and it is worth while.
    pub(crate) fn enter(&self, state: &FullState, log: &Log, pool: &mut Pool, run: usize) -> bool {
        let lasts = log.hits as f64 >= YOUNG * state.body.least_loss;
        let suits = self.active == Some(0) && self.left.granted >= WORTH && lasts;
        if suits {
            pool.put(run, Moment::of(state, log.clock), self.course, self.left);
        }
        suits
    }

    /// Comes back from a lane: whether plain collisions may still be next, or the end.
    pub(crate) fn leave(
        &mut self,
        stopped: &Stopped,
        state: &mut FullState,
        log: &mut Log,
    ) -> Option<Option<LoopExit>> {
        log.clock = stopped.moment.put(state);
        log.hits += self.left.granted - stopped.left.granted;
        self.left = stopped.left;
        self.active = Some(stopped.a);
        let Some(dt) = stopped.look else { return Some(None) };
        self.look_after(stopped.a, dt, state, log)
    }

    /// A look after a collision at `a`: `None`: plain collisions may be next, else an end or none.
    fn look_after(
        &mut self,
        a: usize,
        dt: f64,
        state: &FullState,
        log: &Log,
    ) -> Option<Option<LoopExit>> {
        self.active = (state.gaps.u[a] > 0.0).then_some(a);
        let halt = state.accumulates(a, dt, &self.course, log);
        (halt.is_some() || self.active.is_none()).then_some(halt)
    }

    /// Plain collisions up to one at contact 1: from there on they come in turn. Anything else stops the loop.
    pub(crate) fn come_to_first(
        &mut self,
        state: &mut FullState,
        log: &mut Log,
    ) -> Option<Option<LoopExit>> {
        match self.active {
            None => Some(None),
            Some(0) => None,
            Some(_) => {
                let mut moment = Moment::of(state, log.clock);
                let stop = self.hop::<1>(&mut moment, state, log);
                if stop.is_none() {
                    log.clock = moment.put(state);
                    self.active = Some(0);
                }
                stop
            }
        }
    }

    pub(crate) fn begin(body: &Body, log: &mut Log) -> Self {
        let left = Left { granted: log.chunk(), fresh: REFRESH };
        Self { course: Course::new(body, log.end), active: None, left }
    }

    fn count(&mut self) {
        self.left.granted -= 1;
        self.left.fresh -= 1;
    }

    /// After the loop: what is left of the time.
    pub(crate) fn end(self, halt: LoopExit, state: &mut FullState, log: &mut Log) -> LoopExit {
        if halt == LoopExit::TimeLimit || halt == LoopExit::Never && log.end.is_finite() {
            let left = log.left().max(0.0);
            state.fly(left, &Turn::by(state.spin.omega * left));
            log.clock = log.clock.after(left);
            return LoopExit::TimeLimit;
        }
        halt
    }

    /// The next collision, whatever it is.
    pub(crate) fn next(&mut self, state: &mut FullState, log: &mut Log) -> Option<LoopExit> {
        if self.left.granted == 0 {
            self.left.granted = log.chunk();
            if self.left.granted == 0 {
                return Some(LoopExit::EventLimit);
            }
        }
        if self.left.fresh == 0 {
            state.refresh();
            self.left.fresh = REFRESH;
        }
        let Some((contact, landing, tie)) = state.next_landing(self.active) else {
            return Some(LoopExit::Never);
        };
        if log.clock.hi + landing.dt > log.end {
            return Some(LoopExit::TimeLimit);
        }
        if state.is_lost(contact, landing.dt) {
            log.phase_lost = true;
            return Some(LoopExit::EventLimit);
        }
        state.fly(landing.dt, &landing.turn);
        log.clock = log.clock.after(landing.dt);
        state.gaps.h[contact] = 0.0;
        state.gaps.u[contact] = state.gaps.u[contact].min(0.0);
        if tie {
            state.gaps.h[1 - contact] = 0.0;
            return Some(LoopExit::Tie);
        }
        let before = state.gaps.u;
        let jump = state.hit(contact);
        log.hits += 1;
        log.struck[contact] = true;
        self.count();
        if log.record {
            state.write_down(contact, before, jump, log);
        }
        self.active = (state.gaps.u[contact] > 0.0).then_some(contact);
        state.accumulates(contact, landing.dt, &self.course, log)
    }

    /// Plain collisions in turn, as long as nothing else happens.
    ///
    /// Written out for both contacts, so that none is looked up.
    /// `None`: after `most` pairs of them nothing else has.
    pub(crate) fn alternate(
        &mut self,
        most: usize,
        state: &mut FullState,
        log: &mut Log,
    ) -> Option<Option<LoopExit>> {
        if let Some(stop) = self.come_to_first(state, log) {
            return Some(stop);
        }
        let mut moment = Moment::of(state, log.clock);
        for _ in 0..most {
            if let Some(stop) = self.hop::<0>(&mut moment, state, log) {
                return Some(stop);
            }
            if let Some(stop) = self.hop::<1>(&mut moment, state, log) {
                return Some(stop);
            }
        }
        log.clock = moment.put(state);
        self.active = Some(0);
        None
    }

    /// A plain collision; `A` was hit last. Anything else stops the loop, and may be the end of it.
    #[inline(always)]
    fn hop<const A: usize>(
        &mut self,
        moment: &mut Moment<f64>,
        state: &mut FullState,
        log: &mut Log,
    ) -> Option<Option<LoopExit>> {
        let mut small = true;
        if self.left.fresh == 0 {
            let (arms, known) = moment.arms(&self.course);
            if known {
                moment.take_arms(arms);
                self.left.fresh = REFRESH;
            }
            small = known;
        }
        let hop = moment.hop::<A>(&self.course);
        if !small || self.left.granted == 0 || !hop.plain {
            log.clock = moment.put(state);
            self.active = Some(A);
            return Some(None);
        }
        *moment = hop.after;
        self.count();
        log.hits += 1;
        if log.record {
            log.clock = moment.put(state);
            state.write_down(1 - A, hop.before, hop.jump, log);
        }
        if hop.look {
            log.clock = moment.put(state);
            return self.look_after(1 - A, hop.dt, state, log);
        }
        None
    }
}

struct Drift {
    /// In rad.
    angle: f64,
    gravity: [f64; 2],
    psi: f64,
}

impl Drift {
    /// Whether the body turns so little that velocities of frozen geometry, right to the first order, are right to the last
    /// digit. A time below all rounding does not say so of a body that spins as fast.
    fn is_little(&self) -> bool {
        self.angle * self.angle <= f64::EPSILON
    }
}

impl Body {
    /// The pair of contacts of a posture; a single contact gets an absent partner.
    pub(crate) fn new(geometry: &[ContactGeometry], rho2: f64, gravity: f64) -> Self {
        let contacts = [geometry[0], geometry.get(1).copied().unwrap_or(ContactGeometry::ABSENT)];
        let n: [Vector2<f64>; 2] = contacts.map(|k| k.normal);
        let least_loss = 1.0 - contacts[0].restitution.max(contacts[1].restitution);
        Self { contacts, rho2, n12: n[0].dot(&n[1]), gravity, least_loss }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::body::posture::Posture;
    use crate::math::cases::fixed;

    pub(super) fn rod() -> Posture {
        Posture::rod(0.5, 0.25, 0.7, 0.0, 9.81).expect("a rod")
    }

    pub(super) fn state(q: [f64; 3], qdot: [f64; 3]) -> FullState {
        let (q, v) = (Vector3::from(q), Vector3::from(qdot));
        let body = Body::new(rod().geometry(), rod().gyration_squared(), 9.81);
        let pair = |values: Vec<f64>| [values[0], values[1]];
        let gaps = Gaps { h: pair(rod().gaps(&q)), u: pair(rod().gap_rates(&q, &v)) };
        let center = Center { r: q.xy(), v: v.xy() };
        FullState::new(body, gaps, center, Spin { theta: q.z, omega: v.z })
    }

    proptest! {
        #![proptest_config(fixed(4))]

        /// It has no part along the tangent, and its moment is that of a force at the contact. It takes (1 − e²)w²/(2D_ii),
        /// D_ii = 1 + b_i²/ρ². The rates remain those of the body.
        #[test]
        fn an_impact_is_an_impulse_along_the_normal_of_the_contact(
            i in 0..2_usize, theta in -1.0..1.0, v in prop::array::uniform3(-2.0..2.0_f64),
        ) {
            let before = state([0.0, 1.0, theta], v);
            prop_assume!(before.gaps.u[i] < 0.0);
            let (mut after, rho2, q) = (before, 0.25 * 0.25, before.q());
            after.hit(i);
            let [old, new] = [before, after].map(|s| s.center.v.push(s.spin.omega));
            let lost = 0.51 * before.gaps.u[i].powi(2) / (2.0 + 2.0 * before.b[i].powi(2) / rho2);
            prop_assert_eq!(new.x, old.x);
            prop_assert!((rho2 * (new.z - old.z) - before.b[i] * (new.y - old.y)).abs() < 1e-14);
            prop_assert!((rod().energy(&q, &old) - rod().energy(&q, &new) - lost).abs() < 1e-13);
            for (rate, u) in rod().gap_rates(&q, &new).into_iter().zip(after.gaps.u) {
                prop_assert!((rate - u).abs() < 1e-13, "{rate} {u}");
            }
        }
    }
}
