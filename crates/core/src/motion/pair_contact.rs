//! Contact phases of two contacts: from the coordinates of flight to those of a body, and back.

use nalgebra::Vector2;

use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::terrain::Place;
use crate::math::turn::Turn;
use crate::modes::{Mode, Row};
use crate::motion::driver::{Coordinates, Driver};
use crate::motion::frame::{Frame, Snapshot};
use crate::motion::nested::{Limit, SlowLanding};
use crate::motion::pair::{Pair, PairState};
use crate::motion::record::{Motion, Tail};
use crate::motion::subject::Subject;
use crate::options::Stop;
use crate::outcome::{Outcome, ZenoMethod};
use crate::sustained::phase::only_mode_of;
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::STILL;
use crate::zeno::Impulses;

impl Subject {
    /// The body of a snapshot of the full model.
    pub(crate) fn body_state(&self, at: &Snapshot) -> Option<BodyState> {
        let (body, posture) = (self.pair()?, self.posture()?);
        let turn = Turn::by(at.spin.theta);
        let points = (0..self.count()).map(|i| {
            let k = &body.contacts[i];
            let (b, c) = k.turned(&turn);
            let (normal, tangent) = (k.normal, k.tangent);
            let friction = posture.contacts()[i].friction;
            ContactState {
                normal,
                tangent,
                friction,
                b,
                c,
                radius: 0.0, // a pair has no round contacts
                held: None,
                place: Place::anywhere(i),
                h: at.gaps.h[i],
                depth: 0.0,
                u: at.gaps.u[i],
                rounding: Rounding::default(),
            }
        });
        Some(BodyState {
            points: points.collect(),
            sides: Vec::new(),
            center: at.center,
            spin: at.spin,
            rho2: body.rho2,
            fall: Vector2::new(0.0, -body.gravity),
            gravity: body.gravity,
            frozen: false,
        })
    }
}

impl Driver<'_, Pair> {
    /// The modes of a body that stays at rest: all contacts rest, and all speeds are rounding error. `None`: closed forms do not
    /// decide.
    pub(super) fn stands(&mut self, at: &Snapshot) -> Option<[Mode; 2]> {
        let (body, posture) = (self.record.subject.pair()?, self.record.subject.posture()?);
        let tolerance = STILL * Pair::largest_speed(self);
        let (v, omega) = (at.center.v, at.spin.omega);
        if !(v.x.abs().max(v.y.abs()).max(posture.size() * omega.abs()) <= tolerance) {
            return None;
        }
        let (rho, turn) = (body.rho2.sqrt(), Turn::by(at.spin.theta));
        let omega_squared = omega * omega;
        // The centre of mass is between two contacts on level ground without friction, λ_i = g b_j/(b_j − b_i): both forces
        // press, and no other motion is consistent. To test all words would cost a fifth of a short run.
        let level = |k: &ContactGeometry| k.friction == 0.0 && k.normal == Vector2::y();
        let lies = body.gravity > 0.0 && v.x == 0.0 && omega == 0.0;
        if lies && self.body.count == 2 && body.contacts.iter().all(level) {
            let [one, two] = body.contacts.map(|k| k.turned(&turn).0);
            if one * two < 0.0 {
                return Some([Mode::Fixed; 2]);
            }
        }
        let mut rows = [Row::ABSENT; 2];
        let mut fastest = 0.0_f64;
        for i in 0..self.body.count {
            let k = &body.contacts[i];
            let (b, c) = k.turned(&turn);
            let slip = (k.tangent.dot(&v) - c * omega).abs();
            if slip > if k.friction > 0.0 { tolerance } else { 0.0 } {
                return None;
            }
            fastest = fastest.max(slip);
            let arm = (k.tangent * b + k.normal * c) / rho;
            rows[i] = Row::new(
                k.tangent,
                arm,
                [-b * omega_squared, -c * omega_squared],
                k.friction,
                Some(0),
            );
        }
        let (mut modes, [ax, ay, turn]) =
            only_mode_of(&mut rows[..self.body.count], Vector2::new(0.0, -body.gravity), rho)?;
        let most = ax.abs().max(ay.abs()).max(posture.size() * turn.abs());
        if !(most <= STILL * body.gravity) {
            return None;
        }
        for (mode, k) in modes.iter_mut().zip(&body.contacts) {
            if *mode != Mode::Separate && k.friction == 0.0 {
                *mode = Mode::Fixed; // forces do not change
            }
        }
        self.nested.drop(fastest);
        Some(modes)
    }

    /// Stays at rest in these modes.
    pub(super) fn rest_in(&mut self, modes: [Mode; 2], mut full: Snapshot) -> Outcome {
        (full.center.v, full.spin.omega) = (Vector2::zeros(), 0.0);
        for i in 0..self.body.count {
            (full.gaps.h[i], full.gaps.u[i]) = (0.0, 0.0);
        }
        full.impulses = Impulses::default();
        if let Some(body) = self.record.subject.body_state(&full).filter(|_| self.log.record) {
            let modes = &modes[..self.body.count];
            self.write(Motion::Modes(Box::new(body), modes.into()));
        }
        let outcome = if self.options.stop == Stop::Time {
            self.log.clock = self.log.clock.after(self.log.left().max(0.0));
            full.clock = self.log.clock;
            Outcome::TimeLimit
        } else {
            Outcome::Rest
        };
        self.begin_frame(Frame::full(full));
        outcome
    }

    /// Contact `b` lands while another is held. If all speeds of the body are below their rounding error, the body comes to rest. If only
    /// the landing speed is, contact `b` comes to rest.
    pub(super) fn stop_slowly(&mut self, b: usize, body: &BodyState) -> Option<Option<Outcome>> {
        let size = self.record.subject.posture().map_or(0.0, Posture::size);
        let v = body.state().qdot;
        let left = v.x.abs().max(v.y.abs()).max(size * v.z.abs());
        let fastest = Pair::largest_speed(self);
        let SlowLanding { quiet, error } =
            SlowLanding::of(-body.points[b].u, left, fastest, body.gravity)?;
        let mut end = body.clone();
        end.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
        end.close(&[true; 2]);
        if quiet {
            (end.center.v, end.spin.omega) = (Vector2::zeros(), 0.0);
        }
        self.leave(&end);
        self.nested.forget();
        Some(self.come_to_rest([true; 2], ZenoMethod::Mixed, false, error))
    }

    /// Moves to the limit of infinitely many cycles.
    pub(super) fn sum_cycles(&mut self, before: &BodyState, limit: &Limit) -> Option<Outcome> {
        if limit.turns {
            self.begin_sum(before);
        } else {
            if let PairState::Full(state) = self.body.state {
                self.freeze(&state); // for states within the tail
            }
            self.note(|at| Motion::Tail(at, Tail::Collisions));
        }
        self.log.clock = self.log.clock.after(limit.duration);
        self.leave(&limit.end);
        if let PairState::Full(state) = &mut self.body.state {
            state.forget_rounding();
        }
        let method = if limit.repeats { ZenoMethod::Nested } else { ZenoMethod::Mixed };
        self.come_to_rest([true; 2], method, false, limit.error)
    }

    /// The state after a contact phase, in the coordinates of flight.
    pub(super) fn leave(&mut self, body: &BodyState) {
        self.begin_frame(Frame::full(Snapshot::of_body(body, self.log.clock)));
    }
}
