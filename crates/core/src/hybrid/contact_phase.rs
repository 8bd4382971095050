//! Contacts with friction at rest on the terrain: which mode they go on in, and until when.
//!
//! The word is chosen by the contact-mode problem where contacts come to rest and where a sliding speed comes down to
//! zero. Where a force does (a contact lifts off, or breaks loose) the word follows from which one it is: at that
//! instant the accelerations of both words agree, and a new choice could not tell them apart.

use nalgebra::Vector2;

use super::{Driver, ROUNDINGS};
use crate::clock::Clock;
use crate::contact_motion::{Point, Stance, Step, StepEnd};
use crate::error::Error;
use crate::frame::{Base, Frame, Snapshot};
use crate::log::{Center, Spin};
use crate::modes::{ContactProblem, Method, Mode, ProblemFields, Status, contact_modes};
use crate::simulate::Stop;
use crate::tolerance::{REACHED, STILL};
use crate::trajectory::{Kind, Method as Argument, Outcome, Span, Tail};
use crate::tumble::Tumble;
use crate::zeno::{Gaps, Impulses};

impl Base {
    /// The body of a snapshot of the full model. `frozen`: the rotation at which the geometry is frozen.
    pub(crate) fn stance(&self, at: &Snapshot, frozen: Option<Spin>) -> Option<Stance> {
        let (body, posture) = (self.body.as_ref()?, self.posture.as_ref()?);
        let turned = frozen.unwrap_or(at.spin).theta;
        let (sin, cos) = (libm::sin(turned), libm::cos(turned));
        let points = (0..self.count).map(|i| {
            let k = &body.contacts[i];
            let (b, c) = k.turned(sin, cos);
            let (normal, tangent) = (k.normal, k.tangent);
            let friction = posture.contacts()[i].friction;
            Point { normal, tangent, friction, b, c, h: at.gaps.h[i], u: at.gaps.u[i] }
        });
        Some(Stance {
            points: points.collect(),
            center: at.center,
            spin: at.spin,
            rho2: body.rho2,
            gravity: body.gravity,
            frozen: frozen.map(|spin| spin.omega * spin.omega),
        })
    }
}

impl Base {
    /// The state `dt` after a snapshot of the full model, with each contact in its mode.
    pub(crate) fn in_modes(
        &self,
        at: &Snapshot,
        modes: [Mode; 2],
        frozen: Option<Spin>,
        dt: f64,
    ) -> Snapshot {
        let clock = at.clock.after(dt);
        let after = self.stance(at, frozen).and_then(|stance| {
            let rests = stance.center.v == Vector2::zeros() && stance.spin.omega == 0.0;
            let modes = &modes[..stance.points.len()];
            if rests && !modes.iter().any(|mode| mode.direction() != 0.0) {
                return Some(stance.snapshot(clock));
            }
            Step::new(&stance, modes).map(|step| step.at(&stance, dt).snapshot(clock))
        });
        after.unwrap_or(Snapshot { clock, ..*at })
    }
}

impl Stance {
    /// Which modes the contacts may go on in. `ways`: their signs of sliding, `None` where a contact is off.
    fn problem(&self, mass: f64, ways: &[Option<i8>]) -> Result<ContactProblem, Error> {
        let bend = self.frozen.unwrap_or(self.spin.omega * self.spin.omega);
        ContactProblem::new(ProblemFields {
            mass,
            gyration_radius: self.rho2.sqrt(),
            arms: self.points.iter().map(|p| (p.tangent * p.b + p.normal * p.c).into()).collect(),
            tangents: self.points.iter().map(|p| p.tangent.into()).collect(),
            friction: self.points.iter().map(|p| p.friction).collect(),
            sliding: ways.to_vec(),
            bias: self.points.iter().map(|p| [-p.b * bend, -p.c * bend]).collect(),
            free_acceleration: [0.0, -self.gravity, 0.0],
            ..ProblemFields::default()
        })
    }

    pub(crate) fn snapshot(&self, clock: Clock) -> Snapshot {
        let mut gaps = Gaps { h: [f64::INFINITY; 2], u: [0.0; 2] };
        for (i, p) in self.points.iter().enumerate() {
            (gaps.h[i], gaps.u[i]) = (p.h, p.u);
        }
        let impulses = Impulses::default();
        Snapshot { clock, gaps, impulses, center: self.center, spin: self.spin }
    }

    /// A point that slid has come to a stop: with the other closed contacts as they are, so have all speeds that depend
    /// on its own.
    fn stop(&mut self, i: usize, modes: &[Mode]) {
        let closed = modes.iter().filter(|&&mode| mode != Mode::Separate).count();
        if closed > 1 {
            (self.center.v, self.spin.omega) = (nalgebra::Vector2::zeros(), 0.0);
        } else {
            let p = &self.points[i];
            self.center.v =
                p.tangent * (p.c * self.spin.omega) - p.normal * (p.b * self.spin.omega);
        }
    }
}

impl Driver<'_> {
    /// Goes on from contacts that rest on the terrain.
    pub(super) fn contact_phase(&mut self, rests: [bool; 2]) -> Option<Outcome> {
        if rests == [true, true] {
            self.thaw();
        }
        let mut frozen = self.frame().frozen.is_some().then_some(self.frame().spin);
        let full = self.frame().to_full(&self.raw());
        let Some((mut stance, mass)) = self
            .base
            .stance(&full, frozen)
            .zip(self.base.posture.as_ref().map(|p| p.fields().mass))
        else {
            unreachable!("friction belongs to a body");
        };
        let mut rests = rests;
        for i in 0..stance.points.len() {
            // Contacts at one point rest together.
            let with = |p: &Point| p.b == stance.points[i].b && p.normal == stance.points[i].normal;
            if (0..i).chain(i + 1..stance.points.len()).any(|k| rests[k] && with(&stance.points[k]))
            {
                rests[i] = true;
            }
        }
        for (p, rests) in stance.points.iter_mut().zip(rests) {
            if rests {
                (p.h, p.u) = (0.0, 0.0);
            }
        }
        // Rates can also come down to zero impact by impact, until there is no smaller number.
        let new = [0, 1].map(|i| rests[i] && !self.resting[i]);
        if new != [false; 2] && self.zeno_here(new, Argument::Bounce) {
            return Some(Outcome::Zeno);
        }
        let still = STILL * self.speed_scale();
        let mut ways: Vec<Option<i8>> = (0..stance.points.len())
            .map(|i| {
                let speed = stance.slip(i);
                rests[i].then(|| i8::from(speed > still) - i8::from(speed < -still))
            })
            .collect();
        loop {
            let solved = stance.problem(mass, &ways).and_then(|problem| {
                contact_modes(&problem, Method::Enumerate).map(|modes| (problem, modes))
            });
            let (problem, modes) = match solved {
                Ok(solved) => solved,
                Err(error) => {
                    self.warnings.push(format!("the contact modes could not be solved: {error}"));
                    return Some(Outcome::EventLimit);
                }
            };
            let answer = match (modes.status(), modes.consistent().next()) {
                (Status::Unique, Some(answer)) => answer,
                (status, _) => {
                    self.leave(&stance, frozen);
                    self.undecided = Some(problem);
                    let none = status == Status::None;
                    return Some(if none { Outcome::Inconsistent } else { Outcome::Ambiguous });
                }
            };
            let word: Vec<Mode> = answer.word.modes().collect();
            for (i, mode) in word.iter().enumerate() {
                self.resting[i] = *mode != Mode::Separate;
            }
            if word.iter().all(|&mode| mode == Mode::Separate) {
                self.leave(&stance, frozen);
                return self.fly();
            }
            match self.hold_in(&mut stance, &word, answer.acceleration, frozen) {
                Next::Outcome(outcome) => {
                    self.leave(&stance, frozen);
                    if outcome == Outcome::Inconsistent {
                        self.undecided = Some(problem);
                    }
                    return Some(outcome);
                }
                Next::Landing(i) => {
                    stance.points[i].h = 0.0;
                    stance.points[i].u = stance.points[i].u.min(0.0);
                    self.leave(&stance, frozen);
                    return frozen.and_then(|_| self.round(i, &stance));
                }
                Next::Thaw => {
                    let full = stance.snapshot(self.log.clock);
                    frozen = None;
                    stance = self.base.stance(&full, None).unwrap_or(stance);
                }
                Next::LiftOff(i) => ways[i] = None,
                Next::Stop(i) => {
                    stance.stop(i, &word);
                    for (way, mode) in ways.iter_mut().zip(&word) {
                        *way = way.filter(|_| *mode != Mode::Separate).map(|_| 0);
                    }
                }
                Next::Slip(i, mode) => ways[i] = Some(mode.direction() as i8),
            }
        }
    }

    /// Holds the contacts in this word until something happens.
    fn hold_in(
        &mut self,
        stance: &mut Stance,
        word: &[Mode],
        acceleration: [f64; 3],
        frozen: Option<Spin>,
    ) -> Next {
        let size = self.base.posture.as_ref().map_or(0.0, crate::Posture::size);
        let most = |v: [f64; 3]| v[0].abs().max(v[1].abs()).max(size * v[2].abs());
        let velocity = [stance.center.v.x, stance.center.v.y, stance.spin.omega];
        let rests = most(velocity) <= STILL * self.speed_scale()
            && most(acceleration) <= STILL * stance.gravity;
        if rests {
            (stance.center.v, stance.spin.omega) = (Vector2::zeros(), 0.0);
        }
        let mut cycle = Cycle::new(stance, word);
        loop {
            self.note_contact(stance, word, frozen);
            if rests {
                if self.options.stop != Stop::Time {
                    return Next::Outcome(Outcome::Rest);
                }
                self.log.clock = self.log.clock.after(self.log.left().max(0.0));
                return Next::Outcome(Outcome::TimeLimit);
            }
            let Some(step) = Step::new(stance, word) else {
                return Next::Outcome(Outcome::Inconsistent);
            };
            let (t, end) = step.first_event(self.log.left());
            if t == f64::INFINITY || cycle.is_complete(stance) && self.log.end == f64::INFINITY {
                self.acceleration = Some(step.acceleration());
                // What flies while nothing ever happens flies away, if it does not turn around with the rest.
                let sliding = cycle.turns > 0 || word.iter().all(|&mode| mode != Mode::Separate);
                return Next::Outcome(if sliding { Outcome::Sliding } else { Outcome::Escape });
            }
            if frozen.is_some() && !self.local && t > LONG * self.log.clock.hi {
                return Next::Thaw;
            }
            *stance = step.at(stance, t);
            self.log.clock = self.log.clock.after(t);
            let counted = self.log.count_step();
            match end {
                StepEnd::Landing(i) => return Next::Landing(i),
                StepEnd::LiftOff(i) => return Next::LiftOff(i),
                StepEnd::Stop(i) => return Next::Stop(i),
                StepEnd::Slip(i, mode) => return Next::Slip(i, mode),
                StepEnd::Reach if self.log.left() <= 0.0 => {
                    return Next::Outcome(Outcome::TimeLimit);
                }
                StepEnd::Reach if !counted => return Next::Outcome(Outcome::EventLimit),
                StepEnd::Reach => {
                    let far = libm::hypot(stance.center.r.x, stance.center.r.y);
                    if far > self.options.neighbourhood {
                        return Next::Outcome(Outcome::Escape);
                    }
                }
            }
        }
    }

    /// Contact `b` lands in a frozen geometry. Rounds from one such landing to the next that shrink in one ratio r, all
    /// times and all changes of velocity with it, are summed:
    ///
    /// ```text
    /// v_∞ = v + (v − v₀) r/(1 − r),   T = (t − t₀) r/(1 − r),   q_∞ = q + v_∞ T + (q − q₀ − v_∞ (t − t₀)) r²/(1 − r²)
    /// ```
    fn round(&mut self, b: usize, stance: &Stance) -> Option<Outcome> {
        let now = stance.snapshot(self.log.clock);
        let last = self.rounds[b].replace(Round { at: now, ratio: f64::NAN })?;
        let before = &last.at;
        let ratio = now.gaps.u[b] / before.gaps.u[b];
        self.rounds[b] = Some(Round { at: now, ratio });
        let (dt, sum) = (now.clock.since(before.clock), ratio / (1.0 - ratio));
        let t = dt * sum;
        let change = t * (ratio - last.ratio).abs() / ((1.0 - ratio) * (1.0 - ratio));
        let repeats = change <= f64::EPSILON * now.clock.hi;
        let reached = t <= REACHED * now.clock.hi;
        if !(0.0 < ratio && ratio < 1.0 && now.clock.hi + t <= self.log.end)
            || !(repeats || reached)
        {
            return None;
        }
        let left = ratio * ratio / (1.0 - ratio * ratio);
        let limit = |v: f64, v0: f64| v + (v - v0) * sum;
        let place = |q: f64, q0: f64, v: f64| q + v * t + (q - q0 - v * dt) * left;
        let mut end = stance.clone();
        for axis in 0..2 {
            let v = limit(now.center.v[axis], before.center.v[axis]);
            end.center.v[axis] = v;
            end.center.r[axis] = place(now.center.r[axis], before.center.r[axis], v);
        }
        let omega = limit(now.spin.omega, before.spin.omega);
        let theta = place(now.spin.theta, before.spin.theta, omega);
        end.spin = Spin { theta, omega };
        for (i, p) in end.points.iter_mut().enumerate() {
            // Who slides through all of it has to slide the same way at its end.
            if stance.slip(i) * end_slip(stance, &end.center, omega, i) < 0.0 && !reached {
                return None;
            }
            (p.h, p.u) = (0.0, 0.0);
        }
        self.note(Kind::Tail(Tail::Collisions));
        self.log.clock = self.log.clock.after(t);
        let frozen = self.local.then_some(self.frame().spin);
        self.leave(&end, frozen);
        if let Some(state) = &mut self.tumble {
            state.forget_rounding();
        }
        self.rounds = [None; 2];
        let method = if repeats { Argument::Nested } else { Argument::Mixed };
        let error = if repeats { change + ROUNDINGS * f64::EPSILON * t / (1.0 - ratio) } else { t };
        self.zeno_point([true, true], method, false, error).then_some(Outcome::Zeno)
    }

    /// From here on the contacts are held in this word: the coordinates are those of the full model.
    fn note_contact(&mut self, stance: &Stance, word: &[Mode], frozen: Option<Spin>) {
        if !self.log.record {
            return;
        }
        let raw = stance.snapshot(self.log.clock);
        let mut modes = [Mode::Separate; 2];
        modes[..word.len()].copy_from_slice(word);
        self.frames.push(Frame::full(raw));
        self.spans.push(Span {
            raw,
            frame: self.frames.len() - 1,
            kind: Kind::Modes(modes, frozen),
            mode: modes.map(|mode| mode.letter() as u8),
            first_collision: self.log.collisions.len(),
        });
    }

    /// The state after contacts were held, in the coordinates of flight.
    fn leave(&mut self, stance: &Stance, frozen: Option<Spin>) {
        let full = stance.snapshot(self.log.clock);
        let Some(body) = self.base.body else { unreachable!("friction belongs to a body") };
        if !self.log.record {
            self.frames.clear();
        }
        if let Some(spin) = frozen {
            let geometry = Tumble::new(body, full.gaps, full.center, spin);
            self.frames.push(Frame::frozen(full, &geometry));
            (self.gaps, self.sum) = (full.gaps, Impulses::default());
            self.tumble = None;
        } else {
            self.frames.push(Frame::full(full));
            self.tumble = Some(Tumble::new(body, full.gaps, full.center, full.spin));
        }
    }
}

/// What follows a stretch in one mode.
enum Next {
    Outcome(Outcome),
    /// Another contact has landed: an impact.
    Landing(usize),
    LiftOff(usize),
    Stop(usize),
    Slip(usize, Mode),
    /// Nothing for so long that the geometry may not be frozen any more.
    Thaw,
}

/// The end of a round that may repeat itself on a smaller scale: contact `b` lands while the other is held.
#[derive(Debug, Clone, Copy)]
pub(super) struct Round {
    at: Snapshot,
    /// Ratio of the landing speeds of this round and the one before.
    ratio: f64,
}

/// Motion of one degree of freedom that keeps its energy, from its start: θ and ω determine each other.
struct Cycle {
    /// Whether nothing rubs.
    smooth: bool,
    theta: f64,
    omega: f64,
    /// How often ω has changed its sign.
    turns: usize,
}

impl Cycle {
    fn new(stance: &Stance, word: &[Mode]) -> Self {
        let rubs = |(p, mode): (&Point, &Mode)| mode.direction() * p.friction != 0.0;
        let smooth = !stance.points.iter().zip(word).any(rubs);
        Self { smooth, theta: stance.spin.theta, omega: stance.spin.omega, turns: 0 }
    }

    /// Whether all positions that it ever comes to have been passed: between two turning points to and fro, or once
    /// around. As nothing happened on the way, nothing ever will.
    fn is_complete(&mut self, stance: &Stance) -> bool {
        let Spin { theta, omega } = stance.spin;
        self.turns += usize::from(self.omega * omega < 0.0);
        self.omega = omega;
        let around = (theta - self.theta).abs() > std::f64::consts::TAU;
        self.smooth && stance.frozen.is_none() && (self.turns > 2 || around)
    }
}

/// v_t of a contact with another velocity.
fn end_slip(stance: &Stance, center: &Center, omega: f64, i: usize) -> f64 {
    let p = &stance.points[i];
    p.tangent.dot(&center.v) - p.c * omega
}

/// Share of the time elapsed up to which a frozen geometry may be held in one mode.
const LONG: f64 = 1e-3;
