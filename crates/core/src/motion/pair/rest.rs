//! The two-contact driver and its phases of contact: to and from the coordinates of flight, and rounds that repeat.

use nalgebra::Vector2;

use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::terrain::Place;
use crate::collisions::full::FullState;
use crate::collisions::log::Spin;
use crate::math::turn::Turn;
use crate::modes::{Mode, Row};
use crate::motion::frame::{Base, Frame, Snapshot};
use crate::motion::pair::{Coordinates, Driver, DriverStep};
use crate::motion::record::{Motion, Span, Tail};
use crate::motion::rounds::SEVERAL;
use crate::options::Stop;
use crate::outcome::{Method, Outcome};
use crate::sustained::phase::{ContactPhase, PhaseEnd, only_mode_of};
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::STILL;
use crate::zeno::Impulses;

impl Base {
    /// The body of a snapshot of the full model. `frozen`: the rotation at which the geometry is frozen.
    pub(crate) fn stance(&self, at: &Snapshot, frozen: Option<Spin>) -> Option<BodyState> {
        let (body, posture) = (self.body.as_ref()?, self.posture.as_ref()?);
        let turned = frozen.unwrap_or(at.spin).theta;
        let turn = Turn::by(turned);
        let points = (0..self.count).map(|i| {
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
            center: at.center,
            spin: at.spin,
            rho2: body.rho2,
            gravity: body.gravity,
            frozen: frozen.map(|spin| spin.omega * spin.omega),
        })
    }
}

impl Driver<'_> {
    /// Goes on from contacts that rest on the terrain.
    pub(super) fn contact_phase(&mut self, mut rests: [bool; 2]) -> DriverStep {
        if rests == [true, true] {
            self.thaw();
        }
        let mut frozen = self.frame().frozen.is_some().then_some(self.frame().spin);
        let full = self.frame().to_full(&self.raw());
        if (0..self.base.count).all(|i| rests[i] && self.resting[i])
            && let Some(modes) = self.stands(&full, frozen)
        {
            return DriverStep::End(self.stay_in(modes, full, frozen));
        }
        // A copy shares all that it holds.
        let (Some(stance), Some(posture)) =
            (self.base.stance(&full, frozen), self.base.posture.clone())
        else {
            unreachable!("contact phases belong to a body");
        };
        let (options, record) = (self.options, self.log.record);
        let count = stance.points.len();
        let (still, brief) = (STILL * self.speed_scale(), frozen.is_some() && !self.local);
        let mut phase = ContactPhase::new(&posture, stance, still, brief, &options, self.cause);
        phase.close(&mut rests[..count]);
        self.rounds.drop(phase.dropped);
        // Rates can also come down to zero impact by impact, until there is no smaller number. What the rotation takes off the
        // ground has not come to rest.
        let pulled = |i: usize| !matches!(&self.state, Coordinates::Full(state) if state.effective_gravity(i) < 0.0);
        let new = [0, 1].map(|i| i < count && rests[i] && !self.resting[i] && pulled(i));
        if new != [false; 2] && self.zeno_here(new, Method::Bounce) {
            return DriverStep::End(Outcome::Zeno);
        }
        phase.cause = self.cause;
        loop {
            let spans = &mut self.spans;
            let first_collision = self.log.collisions.len();
            let rounds = &mut self.rounds;
            let (watch, warnings, local) = (&mut self.watch, &mut self.warnings, self.local);
            let end = phase.run(&mut self.log, &mut |stance, word, clock, cause| {
                rounds.hold(word, clock);
                watch.look_at(&posture, stance, local, || options.clock(clock), warnings);
                if record {
                    let letters = word.iter().map(|mode| mode.letter() as u8).collect();
                    let motion = Motion::Modes(stance.clone(), word.into());
                    spans.push(Span { clock, motion, letters, cause, first_collision });
                }
            });
            for (i, mode) in phase.word.iter().enumerate() {
                self.resting[i] = *mode != Mode::Separate;
            }
            if end == PhaseEnd::Thaw {
                let full = Snapshot::of_stance(&phase.stance, self.log.clock);
                frozen = None;
                phase.brief = false;
                phase.stance = self.base.stance(&full, None).unwrap_or(phase.stance);
                phase.stance.thaw();
                continue;
            }
            self.cause = phase.cause;
            self.leave(&phase.stance, frozen);
            self.warnings.extend(phase.warning.take());
            self.undecided = phase.undecided.take().map(Box::new);
            self.acceleration = phase.acceleration.take();
            return match end {
                PhaseEnd::Outcome(outcome) => DriverStep::End(outcome),
                PhaseEnd::Free => DriverStep::Flight,
                PhaseEnd::Landing(i) => {
                    self.round(i, &phase.stance).map_or(DriverStep::Piece, DriverStep::End)
                }
                PhaseEnd::Thaw | PhaseEnd::Leave(..) => DriverStep::Piece,
            };
        }
    }

    /// A body all of whose contacts rest, and that has no speed beyond rounding: the modes in which it stays, where closed
    /// forms find them. `None`: a phase of contact has to see.
    fn stands(&mut self, at: &Snapshot, frozen: Option<Spin>) -> Option<[Mode; 2]> {
        let (body, posture) = (self.base.body.as_ref()?, self.base.posture.as_ref()?);
        let still = STILL * self.speed_scale();
        let (v, omega) = (at.center.v, at.spin.omega);
        if !(v.x.abs().max(v.y.abs()).max(posture.size() * omega.abs()) <= still) {
            return None;
        }
        let (rho, turn) = (body.rho2.sqrt(), Turn::by(frozen.unwrap_or(at.spin).theta));
        let spin = frozen.map_or(omega, |spin| spin.omega);
        let bend = spin * spin;
        // The centre of mass between two feet on level ground, without friction, λ_i = g b_j/(b_j − b_i): both forces press,
        // and no other motion suits them. All words cost a fifth of a short run.
        let level = |k: &ContactGeometry| k.friction == 0.0 && k.normal == Vector2::y();
        let lies = body.gravity > 0.0 && v.x == 0.0 && spin == 0.0;
        if lies && self.base.count == 2 && body.contacts.iter().all(level) {
            let [one, two] = body.contacts.map(|k| k.turned(&turn).0);
            if one * two < 0.0 {
                return Some([Mode::Fixed; 2]);
            }
        }
        let mut rows = [Row::ABSENT; 2];
        let mut fastest = 0.0_f64;
        for i in 0..self.base.count {
            let k = &body.contacts[i];
            let (b, c) = k.turned(&turn);
            let slip = (k.tangent.dot(&v) - c * omega).abs();
            if slip > if k.friction > 0.0 { still } else { 0.0 } {
                return None;
            }
            fastest = fastest.max(slip);
            let arm = (k.tangent * b + k.normal * c) / rho;
            rows[i] = Row::new(k.tangent, arm, [-b * bend, -c * bend], k.friction, Some(0));
        }
        let (mut modes, [ax, ay, turn]) =
            only_mode_of(&mut rows[..self.base.count], body.gravity, rho)?;
        let most = ax.abs().max(ay.abs()).max(posture.size() * turn.abs());
        if !(most <= STILL * body.gravity) {
            return None;
        }
        for (mode, k) in modes.iter_mut().zip(&body.contacts) {
            if *mode != Mode::Separate && k.friction == 0.0 {
                *mode = Mode::Fixed; // the same forces
            }
        }
        self.rounds.drop(fastest);
        Some(modes)
    }

    /// At rest in these modes.
    fn stay_in(&mut self, modes: [Mode; 2], mut full: Snapshot, frozen: Option<Spin>) -> Outcome {
        (full.center.v, full.spin.omega) = (Vector2::zeros(), 0.0);
        for i in 0..self.base.count {
            (full.gaps.h[i], full.gaps.u[i]) = (0.0, 0.0);
        }
        full.impulses = Impulses::default();
        if let Some(stance) = self.base.stance(&full, frozen).filter(|_| self.log.record) {
            let modes = &modes[..self.base.count];
            self.spans.push(Span {
                clock: full.clock,
                letters: modes.iter().map(|mode| mode.letter() as u8).collect(),
                motion: Motion::Modes(stance, modes.into()),
                cause: self.cause,
                first_collision: self.log.collisions.len(),
            });
        }
        let outcome = if self.options.stop == Stop::Time {
            self.log.clock = self.log.clock.after(self.log.left().max(0.0));
            full.clock = self.log.clock;
            Outcome::TimeLimit
        } else {
            Outcome::Rest
        };
        self.go_on_from(full, frozen);
        outcome
    }

    /// Contact `b` lands while another is held: a round is over, and what all that come after it lead to may be known. A body
    /// as slow as the rounding of its speeds comes to rest, a contact that lands as slowly to rest on the ground.
    fn round(&mut self, b: usize, stance: &BodyState) -> Option<Outcome> {
        let size = self.base.posture.as_ref().map_or(0.0, Posture::size);
        let v = stance.state().qdot;
        let left = v.x.abs().max(v.y.abs()).max(size * v.z.abs());
        let fastest = self.speed_scale();
        let (quiet, slow) =
            (left <= QUIET * fastest, -stance.points[b].u <= f64::EPSILON * fastest);
        if stance.gravity > 0.0 && (quiet || slow) {
            let mut end = stance.clone();
            end.points.iter_mut().for_each(|p| (p.h, p.u) = (0.0, 0.0));
            end.close(&[true; 2]);
            if quiet {
                (end.center.v, end.spin.omega) = (Vector2::zeros(), 0.0);
            }
            self.leave(&end, self.local.then_some(self.frame().spin));
            self.rounds.forget();
            let error = SEVERAL * if quiet { left } else { -stance.points[b].u } / stance.gravity;
            return self
                .zeno_point([true; 2], Method::Mixed, false, error)
                .then_some(Outcome::Zeno);
        }
        let limit = self.rounds.land(b, stance, self.log.clock, size, fastest, self.log.left())?;
        if let Coordinates::Full(state) = self.state {
            self.freeze(&state); // for looks into the tail
        }
        self.note([false; 2], |at| Motion::Tail(at, Tail::Collisions));
        self.log.clock = self.log.clock.after(limit.duration);
        let frozen = self.local.then_some(self.frame().spin);
        self.leave(&limit.end, frozen);
        if let Coordinates::Full(state) = &mut self.state {
            state.forget_rounding();
        }
        let method = if limit.repeats { Method::Nested } else { Method::Mixed };
        self.zeno_point([true, true], method, false, limit.error).then_some(Outcome::Zeno)
    }

    /// The state after contacts were held, in the coordinates of flight.
    fn leave(&mut self, stance: &BodyState, frozen: Option<Spin>) {
        self.go_on_from(Snapshot::of_stance(stance, self.log.clock), frozen);
    }

    fn go_on_from(&mut self, full: Snapshot, frozen: Option<Spin>) {
        let Some(body) = self.base.body else { unreachable!("friction belongs to a body") };
        if !self.log.record {
            self.frames.clear();
        }
        self.begin_frame(match frozen {
            Some(spin) => {
                let geometry = FullState::new(body, full.gaps, full.center, spin);
                Frame::frozen(full, &geometry)
            }
            None => Frame::full(full),
        });
    }
}

/// Speed of the body where a contact lands, relative to the largest there was, at which all that is left is rounding: some
/// fifty of them.
const QUIET: f64 = 1e-14;
