//! Collisions of the full model: the rotation is finite, and each impact uses the current configuration.
//!
//! The state is kept in gap coordinates (h, u), with b_i, c_i of the rotated arms. Positions of the body follow from the impulses. When the
//! rest of an accumulation is so short that the geometry does not change, the frozen model sums it.

mod plain;
mod regular;
mod tail;

use nalgebra::{Vector2, Vector3};

use crate::body::geometry::{ContactGeometry, couplings};
use crate::body::local_model::{LocalModel, LocalModelFields};
use crate::collisions::local::{LoopExit, are_one, time_to_rest};
use crate::collisions::log::{Center, Collision, Log, Spin};
use crate::collisions::regular::{REGULAR, RegularSum};
use crate::flight::{GapArc, Touchdown, is_lost};
use crate::impact::newton;
use crate::math::turn::Turn;
use crate::tolerance::{FROZEN_CHANGE_MARGIN, TAIL, TAIL_TOO_LONG};
use crate::zeno::{FrozenModel, Gaps};
use plain::{FullConstants, FullLoopState, UntilCheck};

/// Constants of a body on two contacts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PairBody {
    pub(crate) contacts: [ContactGeometry; 2],
    /// ρ²
    pub(crate) rho2: f64,
    /// n_1·n_2
    pub(crate) n12: f64,
    /// g
    pub(crate) gravity: f64,
    /// 1 − e, with e the larger of the two restitutions.
    least_loss: f64,
}

/// State of the full model: gap coordinates, centre of mass and rotation.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullState {
    pub(crate) body: PairBody,
    pub(crate) gaps: Gaps,
    pub(crate) center: Center,
    pub(crate) spin: Spin,
    /// b_i, c_i at θ.
    pub(crate) b: [f64; 2],
    pub(crate) c: [f64; 2],
}

/// Number of collisions between two computations of b and c from θ. In between, b and c are turned step by step, and each step adds a
/// rounding error.
const REFRESH: usize = 32;

impl FullState {
    pub(crate) fn new(body: PairBody, gaps: Gaps, center: Center, spin: Spin) -> Self {
        let turn = Turn::by(spin.theta);
        let arms = body.contacts.map(|k| k.turned(&turn));
        let (b, c) = (arms.map(|arm| arm.0), arms.map(|arm| arm.1));
        Self { body, gaps, center, spin, b, c }
    }

    /// The same state with the arms computed from θ.
    pub(crate) fn renewed(&self) -> Self {
        Self::new(self.body, self.gaps, self.center, self.spin)
    }

    /// Recomputes the arms from θ after many small turns.
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

    /// ρ²/(b_i² + ρ²): translational impulse per unit mass, divided by the own-rate jump.
    pub(crate) fn translational_fraction(&self, i: usize) -> f64 {
        self.body.rho2 / self.own(i)
    }

    /// (ψ, φ) of this configuration.
    fn couplings(&self) -> ([f64; 2], [f64; 2]) {
        couplings(self.b[0], self.b[1], self.body.n12, self.body.rho2)
    }

    /// The couplings of the contacts, and the effective gravity into them, of this configuration.
    pub(crate) fn model(&self) -> FrozenModel {
        let (psi, phi) = self.couplings();
        FrozenModel::new(&LocalModel::frozen(LocalModelFields {
            gravity: [0, 1].map(|i| self.effective_gravity(i)),
            psi,
            phi,
            restitution: self.body.contacts.map(|k| k.restitution),
        }))
    }

    /// Returns true if the flight to the next touchdown is so long that rounding makes the position of the body unknown. For a single
    /// contact, and for a body that lies flat and does not turn, only the angle of rotation matters.
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

    /// Moves the state by a flight.
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

    /// Applies impulses, given as own-rate jumps at the contacts, to the gap rates, the spin and the sums of impulses.
    pub(crate) fn apply_impulse(&mut self, jump: [f64; 2]) {
        let cross = self.b[0] * self.b[1] + self.body.rho2 * self.body.n12;
        for i in 0..2 {
            let per_own = jump[i] / self.own(i);
            self.gaps.u[i] += jump[i];
            self.gaps.u[1 - i] += cross * per_own; // −ψ_i J_i
            self.spin.omega += self.b[i] * per_own; // −φ_i J_i
            self.center.v += self.body.contacts[i].normal * (self.body.rho2 * per_own);
        }
    }

    /// Frictionless Newton impact at `i` [Or & Rimon 2008, (4)]. Returns the own-rate jump (1+e)|w|, the change of the gap rate of contact
    /// i.
    fn impact(&mut self, i: usize) -> f64 {
        let (s, e) = (-self.gaps.u[i], self.body.contacts[i].restitution);
        let (jump, per_own) = newton::own_jump(e, s, self.own(i));
        let cross = self.b[0] * self.b[1] + self.body.rho2 * self.body.n12;
        self.gaps.u[i] = e * s;
        self.gaps.u[1 - i] += cross * per_own;
        self.spin.omega += self.b[i] * per_own;
        self.center.v += self.body.contacts[i].normal * (self.body.rho2 * per_own);
        jump
    }

    /// Records an impact that has just been applied.
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

    /// The contact that lands next, its touchdown, and whether both contacts land at once. `active`: the contact just hit.
    fn next_landing(&self, active: Option<usize>) -> Option<(usize, Touchdown, bool)> {
        let arcs = [self.arc(0), self.arc(1)];
        if let Some(a) = active
            && arcs[a].is_concave()
            && let Some(landing) = arcs[1 - a].find_touchdown()
        {
            // A concave arc that starts on the ground is above it until it lands: the sign of the gap decides.
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

    /// The reason to end the loop after an impact at `a`, if any: a tail to sum with frozen geometry, or a contact that stops.
    fn accumulates(
        &self,
        a: usize,
        tau: f64,
        constants: &FullConstants,
        log: &Log,
    ) -> Option<LoopExit> {
        let fast = FullLoopState::of(self, log.clock);
        let near =
            if a == 0 { fast.near::<0>(constants, tau) } else { fast.near::<1>(constants, tau) };
        let gravity = [self.effective_gravity(0), self.effective_gravity(1)];
        let now = log.clock.hi;
        if near.bounce
            && let Some(halt) = self.bounces(a, gravity, log)
        {
            return Some(halt);
        }
        if near.clatter {
            let frozen = self.model();
            if let Some(tail) = frozen.clatter_tail(a, &self.gaps)
                && tail.duration <= log.left()
            {
                let (b, t) = (1 - a, tail.duration);
                let sum = frozen.settle(&self.gaps, t);
                let drift = self.drift(t, sum.jump[a].abs(), sum.jump[b].abs());
                let pull = drift.gravity[0] + drift.gravity[1];
                let geometry =
                    drift.psi / frozen.psi[a] * frozen.sensitivity() + pull * t / -self.gaps.u[b];
                if tail.error + FROZEN_CHANGE_MARGIN * t * geometry <= TAIL * now
                    && self.is_turn_lost(t, sum.jump)
                    && frozen.certainly_clatters(a, &self.gaps)
                {
                    return Some(LoopExit::Clatter(tail));
                }
            }
        }
        if near.freezes && self.can_freeze(gravity, log) {
            return Some(LoopExit::Freeze);
        }
        // A contact with zero rate after its impact is not in flight, whatever its acceleration: its mode has to be found.
        (self.gaps.u[a] == 0.0).then_some(LoopExit::Tie)
    }

    /// Whether the rotation during a tail of duration `t` with these own-rate jumps changes the speeds at the end of the tail by less than
    /// their rounding error. [`FullState::turn_tail`] adds only an approximation of the change, Δω ≤ Σ |c_i| ωt J_i/(b_i² + ρ²), because ω
    /// does not change uniformly. On parallel ground, if both contacts come to rest, no speed is left that could change.
    fn is_turn_lost(&self, t: f64, jump: [f64; 2]) -> bool {
        let per_own = [0, 1].map(|i| jump[i].abs() / self.own(i));
        let omega =
            self.spin.omega.abs() + (0..2).map(|i| self.b[i].abs() * per_own[i]).sum::<f64>();
        let change = omega * t * (0..2).map(|i| self.c[i].abs() * per_own[i]).sum::<f64>();
        let rho = self.body.rho2.sqrt();
        let speed = self.center.v.x.abs() + self.center.v.y.abs() + rho * self.spin.omega.abs();
        self.body.n12.abs() >= 1.0 || rho * change <= f64::EPSILON * speed
    }

    /// The bounce tail at `a`, if it may be summed with frozen geometry.
    #[cold]
    fn bounces(&self, a: usize, gravity: [f64; 2], log: &Log) -> Option<LoopExit> {
        let (b, e) = (1 - a, self.body.contacts[a].restitution);
        let (u_a, u_b, h_b) = (self.gaps.u[a], self.gaps.u[b], self.gaps.h[b]);
        let now = log.clock.hi;
        let frozen = self.model();
        let psi_a = frozen.psi[a];
        let t = 2.0 * u_a / (gravity[a] * (1.0 - e));
        let end = h_b + t * (u_b - 0.5 * t * (gravity[b] + e * psi_a * gravity[a]));
        if !(end >= 0.0 && t <= log.left()) {
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
            // Accelerated upwards, b moves on a convex arc: its gap has to exceed all changes of it that are possible.
            let kicks = 2.0 * psi_a.abs() * u_a * t / (1.0 - e);
            h_b >= miss + u_b.abs() * t + gravity[b].abs() * t * t + kicks
        };
        (clear && t * drift.gravity[a] <= TAIL * (now + t) * gravity[a])
            .then_some(LoopExit::Bounce { contact: a, duration: t })
    }

    /// Both contacts bounce in step until they rest after the time `t`: whether they keep landing together although the body turns.
    pub(crate) fn stays_synchronous(&self, t: f64, log: &Log) -> bool {
        let [one, two] = self.model().settle(&self.gaps, t).jump;
        let drift = self.drift(t, one.abs(), two.abs());
        let late = |i: usize| t * drift.gravity[i] / self.effective_gravity(i);
        drift.is_little() && late(0).max(late(1)) <= TAIL * (log.clock.hi + t)
    }

    /// Returns true if both contacts come to rest so soon that the geometry cannot change until then.
    pub(crate) fn may_freeze(&self, log: &Log) -> bool {
        let gravity = [self.effective_gravity(0), self.effective_gravity(1)];
        let (Gaps { h, u }, loss) = (self.gaps, self.body.least_loss);
        let squares = [0, 1].map(|i| u[i] * u[i] + 2.0 * gravity[i] * h[i]);
        plain::may_freeze(squares, gravity, loss, log.clock.hi) && self.can_freeze(gravity, log)
    }

    #[cold]
    fn can_freeze(&self, gravity: [f64; 2], log: &Log) -> bool {
        let now = log.clock.hi;
        let frozen = self.model();
        let Some(t) = time_to_rest(&frozen, &self.gaps) else { return false };
        if t > TAIL_TOO_LONG * now {
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

    /// Bounds of the changes of g_i + c_iω² and ψ within `t` while own-rate jumps of these sizes act at the two contacts, in
    /// any order.
    fn drift(&self, t: f64, jump_a: f64, jump_b: f64) -> Drift {
        let (b, c, rho2) = (self.b, self.c, self.body.rho2);
        let lever = [0, 1].map(|i| b[i].abs() / self.own(i));
        let twist = (jump_a + jump_b) * lever[0].max(lever[1]);
        let omega = self.spin.omega.abs() + twist;
        let angle = omega * t;
        let gravity = [0, 1].map(|i| {
            2.0 * c[i].abs() * omega * twist
                + omega * omega * angle * (b[i].abs() + c[i].abs() * angle)
        });
        let cross = b[0] * b[1] + rho2 * self.body.n12;
        let slope = [0, 1].map(|i| {
            let own = self.own(i);
            ((c[0] * b[1] + b[0] * c[1]) / own + cross / (own * own) * -2.0 * b[i] * c[i]).abs()
        });
        let curvature =
            (b[0] * b[1]).abs().max(c[0].abs() * c[1].abs()) / self.own(0).min(self.own(1));
        Drift {
            angle,
            gravity,
            psi: slope[0].max(slope[1]) * angle + 4.0 * curvature * angle * angle,
        }
    }
}

/// The loop over collisions in progress.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FullCollisions {
    constants: FullConstants,
    /// The contact hit last, if it is in the air.
    active: Option<usize>,
    left: UntilCheck,
    /// Number of collisions after those of `left` until the limits are checked.
    chunk: usize,
    /// Number of collisions when the loop began, and number at which a sum of a regular motion is tried.
    first: usize,
    regular: usize,
}

impl FullCollisions {
    /// Tests for an end after a collision at `a`. `None`: plain collisions may be next. `Some(None)`: another event is next.
    fn end_after(
        &mut self,
        a: usize,
        dt: f64,
        state: &FullState,
        log: &Log,
    ) -> Option<Option<LoopExit>> {
        self.active = (state.gaps.u[a] > 0.0).then_some(a);
        let halt = state.accumulates(a, dt, &self.constants, log);
        (halt.is_some() || self.active.is_none()).then_some(halt)
    }

    pub(crate) fn begin(body: &PairBody, log: &mut Log) -> Self {
        let left = UntilCheck { granted: 0, fresh: REFRESH };
        let (chunk, first) = (log.chunk(), log.hits);
        let constants = FullConstants::new(body, log.end);
        let mut begun =
            Self { constants, active: None, left, chunk, first, regular: first + REGULAR };
        begun.grant(log.hits);
        begun
    }

    /// Grants collisions of the chunk, up to the next trial of a sum.
    fn grant(&mut self, hits: usize) {
        let until = self.regular.checked_sub(hits).filter(|left| *left > 0);
        self.left.granted = self.chunk.min(until.unwrap_or(usize::MAX));
        self.chunk -= self.left.granted;
    }

    /// The contact that was hit last and has taken off.
    pub(crate) fn active(&self) -> Option<usize> {
        self.active
    }

    fn count(&mut self) {
        self.left.granted -= 1;
        self.left.fresh -= 1;
    }

    /// Ends the loop. If no collision precedes the time limit, first simulates the flight up to it.
    pub(crate) fn end(self, halt: LoopExit, state: &mut FullState, log: &mut Log) -> LoopExit {
        if halt == LoopExit::TimeLimit || halt == LoopExit::Never && log.end.is_finite() {
            let left = log.left().max(0.0);
            state.fly(left, &Turn::by(state.spin.omega * left));
            log.clock = log.clock.after(left);
            return LoopExit::TimeLimit;
        }
        halt
    }

    pub(crate) fn next(&mut self, state: &mut FullState, log: &mut Log) -> Option<LoopExit> {
        if self.left.granted == 0 {
            if self.chunk == 0 {
                self.chunk = log.chunk();
            }
            self.grant(log.hits);
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
        if landing.dt > log.left() {
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
        let jump = state.impact(contact);
        log.hits += 1;
        log.struck[contact] = true;
        self.count();
        if log.record {
            state.write_down(contact, before, jump, log);
        }
        self.active = (state.gaps.u[contact] > 0.0).then_some(contact);
        state.accumulates(contact, landing.dt, &self.constants, log)
    }

    /// Simulates plain collisions alternately at the two contacts, until another event is next (`None`) or the loop ends.
    #[inline(always)] // into loops that do nothing else: their registers are free for the collisions
    pub(crate) fn alternate(&mut self, state: &mut FullState, log: &mut Log) -> Option<LoopExit> {
        let (first, hits) = (self.active?, log.hits);
        let exit = loop {
            let Some(a) = self.active else { break None };
            if log.hits >= self.regular
                && let Some(sum) = self.regular_sum(a, state, log)
            {
                break Some(LoopExit::Regular(sum));
            }
            let exit = self.in_turn(a, state, log);
            if exit.is_some() || self.left.granted > 0 || self.chunk == 0 {
                break exit;
            }
            self.grant(log.hits);
        };
        // Later collisions are at this contact, or at `first`, which has been hit before.
        log.struck[1 - first] |= log.hits > hits;
        exit
    }

    /// The code of both contacts is written out, without indices.
    #[inline(always)]
    fn in_turn(&mut self, first: usize, state: &mut FullState, log: &mut Log) -> Option<LoopExit> {
        let mut fast = FullLoopState::of(state, log.clock);
        if first == 1
            && let Some(stop) = self.plain_collision::<1>(&mut fast, state, log)
        {
            return stop;
        }
        loop {
            if let Some(stop) = self.plain_collision::<0>(&mut fast, state, log) {
                return stop;
            }
            if let Some(stop) = self.plain_collision::<1>(&mut fast, state, log) {
                return stop;
            }
        }
    }

    /// The sum of the rest of the motion after an impact at `a`, if it is regular.
    #[cold]
    fn regular_sum(&mut self, a: usize, state: &FullState, log: &Log) -> Option<RegularSum> {
        self.regular = self.first + 2 * (log.hits - self.first);
        state.regular_sum(a, [log.clock.hi, log.left()])
    }

    /// The next collision, if it is plain. `A`: the contact hit last. Result: as of [`Self::end_after`].
    #[inline(always)]
    fn plain_collision<const A: usize>(
        &mut self,
        fast: &mut FullLoopState,
        state: &mut FullState,
        log: &mut Log,
    ) -> Option<Option<LoopExit>> {
        if self.left.fresh == 0 && fast.refresh(&self.constants) {
            self.left.fresh = REFRESH;
        }
        let go_on = self.left.fresh > 0 && self.left.granted > 0;
        let next = if go_on { fast.plain_collision::<A>(&self.constants) } else { None };
        let Some(next) = next else {
            log.clock = fast.put(state);
            self.active = Some(A);
            return Some(None);
        };
        *fast = next.after;
        self.count();
        log.hits += 1;
        if log.record {
            log.clock = fast.put(state);
            state.write_down(1 - A, next.before, next.jump, log);
        }
        if next.may_end {
            log.clock = fast.put(state);
            return self.end_after(1 - A, next.dt, state, log);
        }
        None
    }
}

struct Drift {
    /// Bound of the rotation, in rad.
    angle: f64,
    gravity: [f64; 2],
    psi: f64,
}

impl Drift {
    /// Returns true if the body turns so little that velocities from the frozen geometry, corrected to first order, are right to the last
    /// digit. A short time alone does not ensure this, because the body may spin fast.
    fn is_little(&self) -> bool {
        self.angle * self.angle <= f64::EPSILON
    }
}

impl PairBody {
    /// The pair of contacts of a posture. A single contact is paired with an absent one.
    pub(crate) fn new(geometry: &[ContactGeometry], rho2: f64, gravity: f64) -> Self {
        let contacts = [geometry[0], geometry.get(1).copied().unwrap_or(ContactGeometry::ABSENT)];
        let n: [Vector2<f64>; 2] = contacts.map(|k| k.normal);
        let least_loss = 1.0 - contacts[0].restitution.max(contacts[1].restitution);
        Self { contacts, rho2, n12: n[0].dot(&n[1]), gravity, least_loss }
    }
}

#[cfg(test)]
mod tests {
    use crate::body::Lamina;
    use proptest::prelude::*;

    use super::*;
    use crate::body::posture::Posture;
    use crate::math::cases::fixed;

    pub(super) fn rod() -> Posture {
        Posture::rod(
            0.5,
            &Lamina { gyration_radius: Some(0.25), restitution: 0.7, ..Lamina::default() },
        )
        .expect("a rod")
    }

    pub(super) fn state(q: [f64; 3], qdot: [f64; 3]) -> FullState {
        let (q, v) = (Vector3::from(q), Vector3::from(qdot));
        let body = PairBody::new(rod().geometry(), rod().gyration_squared(), 9.81);
        let pair = |values: Vec<f64>| [values[0], values[1]];
        let gaps = Gaps { h: pair(rod().gaps(&q)), u: pair(rod().gap_rates(&q, &v)) };
        let center = Center { r: q.xy(), v: v.xy() };
        FullState::new(body, gaps, center, Spin { theta: q.z, omega: v.z })
    }

    proptest! {
        #![proptest_config(fixed(4))]

        /// The impulse has no part along the tangent, and its moment is that of a force at the contact. The impact dissipates (1 −
        /// e²)w²/(2D_ii), with D_ii = 1 + b_i²/ρ² per unit mass. The gap rates remain those that follow from the velocity of the body.
        #[test]
        fn an_impact_is_an_impulse_along_the_normal_of_the_contact(
            i in 0..2_usize, theta in -1.0..1.0, v in prop::array::uniform3(-2.0..2.0_f64),
        ) {
            let before = state([0.0, 1.0, theta], v);
            prop_assume!(before.gaps.u[i] < 0.0);
            let (mut after, rho2, q) = (before, 0.25 * 0.25, before.q());
            after.impact(i);
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
