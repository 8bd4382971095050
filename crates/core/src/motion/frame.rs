//! Frames convert the coordinates in which a part of the motion is computed to q and q̇.

use nalgebra::Vector3;

use crate::body::state::State;
use crate::collisions::full::{FullState, PairBody};
use crate::collisions::local::{advance, fly_for};
use crate::collisions::log::{Center, Spin};
use crate::math::clock::Clock;
use crate::math::turn::Turn;
use crate::motion::subject::Subject;
use crate::sustained::BodyState;
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// The state at an instant: in a frozen frame, the gaps and the impulses since its start; in the full model, gaps, centre of mass
/// and rotation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Snapshot {
    pub(crate) clock: Clock,
    pub(crate) gaps: Gaps,
    pub(crate) impulses: Impulses,
    pub(crate) center: Center,
    pub(crate) spin: Spin,
}

impl Snapshot {
    pub(crate) fn of_full(state: &FullState, clock: Clock) -> Self {
        let FullState { gaps, center, spin, .. } = *state;
        Self { clock, gaps, impulses: Impulses::default(), center, spin }
    }

    /// Of a body with at most two contacts.
    pub(crate) fn of_body(body: &BodyState, clock: Clock) -> Self {
        let mut gaps = Gaps { h: [f64::INFINITY; 2], u: [0.0; 2] };
        for (i, p) in body.points.iter().enumerate() {
            (gaps.h[i], gaps.u[i]) = (p.h, p.u);
        }
        let BodyState { center, spin, .. } = *body;
        Self { clock, gaps, impulses: Impulses::default(), center, spin }
    }

    /// (q, q̇) from a snapshot of the full model. Without a body only θ and ω are defined.
    pub(crate) fn state(&self) -> State {
        let Self { center, spin, .. } = self;
        State {
            q: Vector3::new(center.r.x, center.r.y, spin.theta),
            qdot: Vector3::new(center.v.x, center.v.y, spin.omega),
        }
    }
}

/// A set of equations and the instant from which they are used.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    /// In the coordinates of the full model.
    pub(crate) start: Snapshot,
    /// Frozen geometry; `None`: the full model.
    pub(crate) frozen: Option<FrozenModel>,
    /// Rotation at which the geometry is frozen.
    pub(crate) spin: Spin,
    /// Translational impulse per unit mass, divided by the own-rate jump: ρ²/(b_i² + ρ²).
    fractions: [f64; 2],
}

/// Most corrections of a position: falls are up to 1e32 sizes of the body, each correction gains sixteen digits.
const AGREES: usize = 3;

impl Frame {
    pub(crate) fn full(start: Snapshot) -> Self {
        let spin = start.spin;
        Self { start, frozen: None, spin, fractions: [1.0; 2] }
    }

    /// A frame with the geometry of `at`, frozen.
    pub(crate) fn frozen(start: Snapshot, at: &FullState) -> Self {
        Self::with(start, at, FrozenModel::new(&at.frozen()))
    }

    pub(crate) fn with(start: Snapshot, at: &FullState, model: FrozenModel) -> Self {
        Self {
            start,
            frozen: Some(model),
            spin: at.spin,
            fractions: [at.translational_fraction(0), at.translational_fraction(1)],
        }
    }

    /// Translational impulse per unit mass at contact `i`, divided by the own-rate jump.
    pub(crate) fn translational_fraction(&self, i: usize) -> f64 {
        self.fractions[i]
    }

    /// A snapshot of this frame in the coordinates of the full model.
    pub(crate) fn to_full(&self, subject: &Subject, raw: &Snapshot) -> Snapshot {
        let Some(frozen) = &self.frozen else { return *raw };
        let (start, sum) = (&self.start, &raw.impulses);
        let dt = raw.clock.since(start.clock);
        let mut full = *raw;
        full.spin = Spin {
            theta: start.spin.theta + start.spin.omega * dt
                - (frozen.phi[0] * sum.path[0] + frozen.phi[1] * sum.path[1]),
            omega: start.spin.omega - (frozen.phi[0] * sum.jump[0] + frozen.phi[1] * sum.jump[1]),
        };
        full.center = start.center;
        if let Some(body) = subject.pair() {
            full.center.fly(body.gravity, dt);
            for i in 0..2 {
                let n = body.contacts[i].normal;
                full.center.r += n * (self.fractions[i] * sum.path[i]);
                full.center.v += n * (self.fractions[i] * sum.jump[i]);
            }
            self.agree(frozen, body, &mut full);
        }
        full
    }

    /// Corrects rounding errors of q, in which the sums of impulses and the fall nearly cancel. Gaps and rates have no such cancellation.
    /// The body is therefore moved by the shortest displacement after which q agrees with them; this is repeated if the displacement is
    /// longer than ρ. Only if gaps and rates are linear in the state, that is without spin at the start of the frame.
    fn agree(&self, frozen: &FrozenModel, body: &PairBody, full: &mut Snapshot) {
        let turn = Turn::by(self.spin.theta);
        let linear = (0..2).all(|i| frozen.g[i] == body.contacts[i].gravity);
        if !linear || self.spin.omega != 0.0 {
            return;
        }
        for _ in 0..AGREES {
            let path = self.correct(frozen, body, &turn, full);
            if path.iter().all(|way| way * way <= body.rho2) {
                break;
            }
        }
    }

    /// One correction; returns its own-rate paths.
    fn correct(
        &self,
        frozen: &FrozenModel,
        body: &PairBody,
        turn: &Turn,
        full: &mut Snapshot,
    ) -> [f64; 2] {
        let start = &self.start;
        let (mut gaps, mut rates) = ([0.0; 2], [0.0; 2]);
        for i in (0..2).filter(|&i| full.gaps.h[i].is_finite()) {
            let (n, (b, _)) = (body.contacts[i].normal, body.contacts[i].turned(turn));
            let moved =
                n.dot(&(full.center.r - start.center.r)) + b * (full.spin.theta - start.spin.theta);
            let sped =
                n.dot(&(full.center.v - start.center.v)) + b * (full.spin.omega - start.spin.omega);
            gaps[i] = full.gaps.h[i] - start.gaps.h[i] - moved;
            rates[i] = full.gaps.u[i] - start.gaps.u[i] - sped;
        }
        let single = full.gaps.h.iter().any(|h| h.is_infinite());
        let own = |y: [f64; 2]| if single { y } else { frozen.solve_coupled(y) };
        let (path, jump) = (own(gaps), own(rates));
        for i in 0..2 {
            let n = body.contacts[i].normal;
            full.center.r += n * (self.fractions[i] * path[i]);
            full.center.v += n * (self.fractions[i] * jump[i]);
            full.spin.theta -= frozen.phi[i] * path[i];
            full.spin.omega -= frozen.phi[i] * jump[i];
        }
        path
    }

    /// Converts own-rate jumps to translational impulses per unit mass; likewise their time integrals and their rates.
    pub(crate) fn translational(&self, own_rate: [f64; 2]) -> [f64; 2] {
        [self.fractions[0] * own_rate[0], self.fractions[1] * own_rate[1]]
    }

    /// The state `dt` after `raw` in flight.
    pub(crate) fn flown(&self, subject: &Subject, raw: &Snapshot, dt: f64) -> Snapshot {
        let mut after = *raw;
        after.clock = raw.clock.after(dt);
        let Some(frozen) = &self.frozen else {
            let Some(&body) = subject.pair() else { unreachable!("the full model has a body") };
            let state = FullState::new(body, raw.gaps, raw.center, raw.spin);
            let mut next = state;
            next.fly(dt, &Turn::by(raw.spin.omega * dt));
            return Snapshot::of_full(&next, after.clock);
        };
        after.gaps = fly_for(frozen.g, &raw.gaps, dt);
        advance(&mut after.impulses, dt);
        after
    }
}
