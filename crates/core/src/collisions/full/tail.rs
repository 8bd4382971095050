//! The motion of the full model with its geometry frozen: within a time so short that the geometry does not change.

use crate::collisions::full::FullState;
use crate::tolerance::CONTACTS_APART;
use crate::zeno::{FrozenModel, Gaps, Impulses, solve_coupled};

/// Most corrections of a position: falls are up to 1e32 sizes of the body, each correction gains sixteen digits.
const AGREES: usize = 3;

impl FullState {
    /// The state after `dt` in the geometry of this state, `model`. `own`: the effects of the impacts until then, as own-rate jumps of both
    /// contacts; `gaps`: the gaps and rates at the end.
    pub(crate) fn hit(&self, model: &FrozenModel, dt: f64, own: &Impulses, gaps: &Gaps) -> Self {
        let shares = [0, 1].map(|i| self.translational_fraction(i));
        let translational = |of: [f64; 2]| [0, 1].map(|i| shares[i] * of[i]);
        let [jump, path] = [own.jump, own.path].map(translational);
        let (mut center, mut spin) = (self.center, self.spin);
        spin.theta +=
            self.spin.omega * dt - (model.phi[0] * own.path[0] + model.phi[1] * own.path[1]);
        spin.omega -= model.phi[0] * own.jump[0] + model.phi[1] * own.jump[1];
        center.fly(self.body.gravity, dt);
        for (k, (jump, path)) in self.body.contacts.iter().zip(jump.into_iter().zip(path)) {
            center.r += k.normal * path;
            center.v += k.normal * jump;
        }
        let mut after = Self { gaps: *gaps, center, spin, ..*self };
        after.agree(self, model);
        let mut after = Self::new(self.body, after.gaps, after.center, after.spin);
        after.turn_tail(self, dt, jump, path);
        after.follow([0, 1].map(|i| gaps.h[i] == 0.0 && gaps.u[i] == 0.0));
        after
    }

    /// Corrects rounding errors of q since `start`, in which the sums of impulses and the fall nearly cancel. Gaps and rates have no such
    /// cancellation. The body is therefore moved by the shortest displacement after which q agrees with them; this is repeated if the
    /// displacement is longer than ρ. Only if gaps and rates are linear in the state, that is if `start` has no spin.
    fn agree(&mut self, start: &Self, model: &FrozenModel) {
        let linear = (0..2).all(|i| model.g[i] == self.body.contacts[i].gravity);
        if !linear || start.spin.omega != 0.0 {
            return;
        }
        for _ in 0..AGREES {
            let path = self.correct(start, model);
            if path.iter().all(|way| way * way <= self.body.rho2) {
                break;
            }
        }
    }

    /// One correction; returns its own-rate paths.
    fn correct(&mut self, start: &Self, model: &FrozenModel) -> [f64; 2] {
        let (mut gaps, mut rates) = ([0.0; 2], [0.0; 2]);
        for i in (0..2).filter(|&i| self.gaps.h[i].is_finite()) {
            let (n, b) = (self.body.contacts[i].normal, start.b[i]);
            let moved =
                n.dot(&(self.center.r - start.center.r)) + b * (self.spin.theta - start.spin.theta);
            let sped =
                n.dot(&(self.center.v - start.center.v)) + b * (self.spin.omega - start.spin.omega);
            gaps[i] = self.gaps.h[i] - start.gaps.h[i] - moved;
            rates[i] = self.gaps.u[i] - start.gaps.u[i] - sped;
        }
        let single = self.gaps.h.iter().any(|h| h.is_infinite());
        let own = |y: [f64; 2]| if single { y } else { model.solve_coupled(y) };
        let (path, jump) = (own(gaps), own(rates));
        for i in 0..2 {
            let (n, share) = (self.body.contacts[i].normal, start.translational_fraction(i));
            self.center.r += n * (share * path[i]);
            self.center.v += n * (share * jump[i]);
            self.spin.theta -= model.phi[i] * path[i];
            self.spin.omega -= model.phi[i] * jump[i];
        }
        path
    }

    /// Adds the first-order effect of the rotation on ω during a tail. The tail has the duration `t`, began at `start`, and was summed in
    /// the geometry of `start`. An impulse P at time τ acts on the arm b − c ωτ, so that Δω = −Σ c_i ω Σ P τ/ρ², and Σ P τ = (Σ P) t − ∫(Σ
    /// P).
    ///
    /// Towards a 2-Zeno point the speeds decrease more slowly than the times of flight. So the effect can be negligible for the times, but
    /// not for the speeds.
    fn turn_tail(&mut self, start: &Self, t: f64, jump: [f64; 2], path: [f64; 2]) {
        let omega = 0.5 * (start.spin.omega + self.spin.omega);
        let fast: f64 = (0..2).map(|i| start.c[i] * (jump[i] * t - path[i])).sum();
        self.spin.omega -= omega * fast / self.body.rho2;
    }

    /// Computes the velocity of the body from the gap rates of closed contacts. This is needed after a tail summed in the geometry of its
    /// start, during which the arms have turned a little, and after so many impacts that the sum of their jumps has lost its digits.
    pub(crate) fn follow(&mut self, closed: [bool; 2]) {
        if closed == [true, true] {
            self.forget_rounding();
        }
        let left = |i: usize| {
            let n = self.body.contacts[i].normal;
            self.gaps.u[i] - (n.dot(&self.center.v) + self.b[i] * self.spin.omega)
        };
        let jump = match closed {
            [true, true] => solve_coupled(self.couplings().0, [left(0), left(1)]),
            _ => [0, 1].map(|i| if closed[i] { left(i) } else { 0.0 }),
        };
        let rates = self.gaps.u;
        self.apply_impulse(jump);
        self.gaps.u = rates;
        if closed == [true, true] {
            self.forget_rounding();
        }
    }

    /// Sets the spin to zero if two gaps over parallel ground change at the same rate: the spin that follows from the impulses is
    /// rounding error.
    pub(crate) fn forget_rounding(&mut self) {
        let [one, two] = self.body.contacts;
        let same = self.gaps.u[0] == self.gaps.u[1];
        let apart =
            (self.b[0] - self.b[1]).abs() > CONTACTS_APART * self.own(0).max(self.own(1)).sqrt();
        if same && one.normal == two.normal && apart {
            self.spin.omega = 0.0;
        }
    }
}
