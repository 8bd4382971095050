//! Bodies with at most two contacts, from and to the state of the fast loops.

use crate::collisions::full::{FullState, PairBody};
use crate::collisions::log::{Center, Spin};
use crate::sustained::BodyState;
use crate::zeno::Gaps;

impl BodyState {
    /// Gaps of two contacts at most.
    pub(crate) fn gaps(&self) -> Gaps {
        let mut gaps = Gaps { h: [f64::INFINITY; 2], u: [0.0; 2] };
        for (i, p) in self.points.iter().take(2).enumerate() {
            (gaps.h[i], gaps.u[i]) = (p.h, p.u);
        }
        gaps
    }

    /// The state of the loops; `pair`: the constants of this body.
    pub(crate) fn full(&self, pair: &PairBody) -> FullState {
        FullState::new(*pair, self.gaps(), self.center, self.spin)
    }

    /// Moves to the state of the loops.
    pub(crate) fn follow(&mut self, state: &FullState) {
        (self.center, self.spin) = (state.center, state.spin);
        for (i, p) in self.points.iter_mut().enumerate() {
            (p.h, p.u) = (state.gaps.h[i], state.gaps.u[i]);
            (p.b, p.c, p.held) = (state.b[i], state.c[i], None);
        }
    }

    /// The body in flight with these gaps, centre of mass and rotation.
    pub(crate) fn moved(&self, pair: &PairBody, gaps: Gaps, center: Center, spin: Spin) -> Self {
        let mut moved = self.clone();
        moved.follow(&FullState::new(*pair, gaps, center, spin));
        moved
    }
}
