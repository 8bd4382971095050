//! A local model without a body: gravity decides whether contacts are held, and motion along the terrain is not modelled.

use crate::flight::parabola_touchdown;
use crate::motion::driver::Driver;
use crate::motion::pair::Pair;
use crate::motion::record::{Motion, Tail};
use crate::options::Stop;
use crate::outcome::{Outcome, ZenoMethod};
use crate::tolerance::CYCLE_RATIO_ROUNDINGS;
use crate::zeno::Gaps;

impl Driver<'_, Pair> {
    /// The resting contacts that gravity presses into the terrain: 0 ≤ λ ⊥ acceleration ≥ 0.
    pub(super) fn pressed(&self) -> [bool; 2] {
        let (model, gaps) = (self.model(), self.body.gaps());
        let rests = [0, 1].map(|i| gaps.h[i] == 0.0 && gaps.u[i] == 0.0);
        match rests {
            [true, true] => {
                let force = model.solve_coupled(model.g);
                if force[0] > 0.0 && force[1] >= 0.0 || force[0] >= 0.0 && force[1] > 0.0 {
                    [true, true]
                } else {
                    [0, 1].map(|i| {
                        let other = -model.g[1 - i] - model.psi[i] * model.g[i];
                        model.g[i] > 0.0 && other >= 0.0
                    })
                }
            }
            _ => [0, 1].map(|i| rests[i] && model.g[i] > 0.0),
        }
    }

    /// Simulates one held contact with the other in the air, until that one lands or the held one lifts off.
    pub(super) fn hold(&mut self, held: [bool; 2]) -> Option<Outcome> {
        self.note(held, |at| Motion::Held(at, held));
        let (a, b) = if held[0] { (0, 1) } else { (1, 0) };
        let model = self.model();
        let gaps = self.body.gaps();
        let gravity = model.held_gravity(b);
        let resting = gaps.h[b] == 0.0 && gaps.u[b] == 0.0;
        let t =
            if resting { f64::INFINITY } else { parabola_touchdown(gaps.h[b], gaps.u[b], gravity) };
        if t > self.log.left() {
            let left = self.log.left().max(0.0);
            self.move_smoothly(held, left);
            return Some(Outcome::TimeLimit);
        }
        if t == f64::INFINITY {
            return Some(Outcome::Escape);
        }
        self.move_smoothly(held, t);
        let speed = (gaps.u[b] * gaps.u[b] + 2.0 * gravity * gaps.h[b]).max(0.0).sqrt();
        let mut landed = Gaps::default();
        landed.u[b] = -speed;
        self.set_gaps(landed);
        self.nested(a, speed)
    }

    /// A landing while `a` is held. Its speed determines the motion after it, up to scale. If the same landing came before at a
    /// higher speed, the motion in between repeats on a smaller and smaller scale, with all times and speeds multiplied by
    /// `ratio`: a Zeno point of Zeno points.
    fn nested(&mut self, a: usize, speed: f64) -> Option<Outcome> {
        let now = self.log.clock;
        let last = self.body.landings[a].replace((speed, now));
        let (before, then) = last?;
        let ratio = speed / before;
        if !(ratio < 1.0) {
            return None;
        }
        let t = now.since(then) * ratio / (1.0 - ratio);
        if !(t <= self.log.left()) {
            return None;
        }
        // The sum amplifies the rounding error of the ratio.
        let error = CYCLE_RATIO_ROUNDINGS * f64::EPSILON * t / (1.0 - ratio);
        self.settle(t, ZenoMethod::Nested, true, error, Tail::Cycle { ratio, duration: t })
    }

    /// Both contacts are held. Motion along the terrain is not modelled, so this is rest.
    pub(super) fn stay(&mut self, held: [bool; 2]) -> Outcome {
        self.note(held, |at| Motion::Held(at, held));
        if self.options.stop != Stop::Time {
            return Outcome::Rest;
        }
        let left = self.log.left().max(0.0);
        self.move_smoothly(held, left);
        Outcome::TimeLimit
    }
}
