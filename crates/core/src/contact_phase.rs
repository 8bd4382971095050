//! Contacts at rest on the terrain, or sliding along it: which mode they go on in, and until when.
//!
//! The word is chosen by the contact-mode problem where contacts come to rest and where a sliding speed comes down to
//! zero. Where a force does (a contact lifts off, or breaks loose) the word follows from which one it is: at that
//! instant the accelerations of both words agree, and a new choice could not tell them apart.

use nalgebra::Vector2;

use crate::clock::Clock;
use crate::contact_motion::{Point, Stance, Step, StepEnd};
use crate::error::Error;
use crate::log::{Log, Spin};
use crate::modes::{ContactProblem, Method, Mode, ProblemFields, Status, contact_modes};
use crate::posture::Posture;
use crate::simulate::{Options, Stop};
use crate::tolerance::{STILL, TOUCH};
use crate::trajectory::{Cause, ContactNumber, Outcome};

impl Stance {
    /// The body and its contacts as a contact-mode problem takes them, without state or load.
    pub(crate) fn fields(&self, mass: f64) -> ProblemFields {
        ProblemFields {
            mass,
            gyration_radius: self.rho2.sqrt(),
            arms: self.points.iter().map(|p| (p.tangent * p.b + p.normal * p.c).into()).collect(),
            tangents: self.points.iter().map(|p| p.tangent.into()).collect(),
            friction: self.points.iter().map(|p| p.friction).collect(),
            ..ProblemFields::default()
        }
    }

    /// Which modes the contacts may go on in. `ways`: their signs of sliding, `None` where a contact is off.
    fn problem(&self, mass: f64, ways: &[Option<i8>]) -> Result<ContactProblem, Error> {
        let bend = self.frozen.unwrap_or(self.spin.omega * self.spin.omega);
        ContactProblem::new(ProblemFields {
            sliding: ways.to_vec(),
            bias: self.points.iter().map(|p| [-p.b * bend, -p.c * bend]).collect(),
            free_acceleration: [0.0, -self.gravity, 0.0],
            ..self.fields(mass)
        })
    }

    /// Takes the sliding that counts as none from a body that holds on to one point only, and from the rates of the
    /// contacts in the air what that means for them.
    fn conform(&mut self, word: &[Mode]) {
        let closed: Vec<usize> = (0..word.len()).filter(|&i| word[i] != Mode::Separate).collect();
        let change = match closed[..] {
            [i] if word[i] == Mode::Fixed => self.points[i].tangent * -self.slip(i),
            [i, j] if self.twin(i) == Some(j) => {
                let (arm, spin) = (self.points[i].arm(), self.spin.omega);
                Vector2::new(arm.y, -arm.x) * spin - self.center.v // both hold on to the vertex
            }
            _ => return,
        };
        self.center.v += change;
        for (p, mode) in self.points.iter_mut().zip(word) {
            if *mode == Mode::Separate {
                p.u += p.normal.dot(&change);
            }
        }
    }

    /// Point `i` has lifted off one of the two pieces that a contact touches in a vertex: the other point of the contact,
    /// if nothing rubs there, and the way in which it then slides up its piece.
    fn up_from_vertex(&self, i: usize) -> Option<(usize, i8)> {
        let left = &self.points[i];
        let j = self.twin(i).filter(|&j| self.points[j].friction == 0.0)?;
        let p = &self.points[j];
        Some((j, if p.place.piece > left.place.piece { 1 } else { -1 }))
    }

    /// The sliding speed of contact `i` has come down to zero. If it is the only one held, the body may turn about it;
    /// if it is one of several, either all of the body has stopped, or just this point of it where it is: returns
    /// whether that is so.
    fn stop(&mut self, i: usize, modes: &[Mode], slow: bool) -> bool {
        let closed = modes.iter().filter(|&&mode| mode != Mode::Separate).count();
        if closed == 1 {
            let change = self.points[i].tangent * -self.slip(i);
            self.center.v += change;
        } else if slow {
            (self.center.v, self.spin.omega) = (Vector2::zeros(), 0.0);
        } else {
            return true;
        }
        false
    }
}

/// Contacts that rest or slide, and what they do.
pub(crate) struct ContactPhase<'a> {
    pub(crate) stance: Stance,
    /// Signs of sliding; `None` where a contact is off.
    ways: Vec<Option<i8>>,
    mass: f64,
    /// Largest arm or ρ, in m.
    size: f64,
    /// Speed that counts as none, in m/s.
    still: f64,
    /// Whether the geometry is frozen for the last moments of an accumulation only.
    pub(crate) brief: bool,
    options: &'a Options,
    /// The word that the contacts are in.
    pub(crate) word: Vec<Mode>,
    /// What has no answer, or several.
    pub(crate) undecided: Option<ContactProblem>,
    /// q̈ of an endless slide.
    pub(crate) acceleration: Option<[f64; 3]>,
    pub(crate) warning: Option<String>,
    /// Why it is in this word.
    pub(crate) cause: Option<Cause>,
}

/// What hears of every stretch that begins: its start, its word, and why it begins.
pub(crate) type Note<'n> = dyn FnMut(&Stance, &[Mode], Clock, Option<Cause>) + 'n;

/// How a phase of contact ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PhaseEnd {
    Outcome(Outcome),
    /// Another contact has landed: an impact.
    Landing(usize),
    /// This contact has come to the left (0) or right (1) end of the piece of terrain under it.
    Leave(usize, usize),
    /// All contacts have left.
    Free,
    /// Nothing for so long that the geometry may not be frozen any more.
    Thaw,
}

/// What ends a stretch in one mode.
#[derive(Debug, Clone, Copy)]
enum Next {
    End(PhaseEnd),
    LiftOff(usize),
    Stop(usize),
    Slip(usize, Mode),
}

/// Speed of the body, in units of those that count as none, below which it has stopped with one of its points: its speeds
/// have come down together, to the rounding of the time at which they do.
const STOPPED: f64 = 1e3;

/// Share of the time elapsed up to which a geometry frozen for the last moments may be held in one mode.
const LONG: f64 = 1e-3;

impl<'a> ContactPhase<'a> {
    /// A body none of whose contacts is closed yet. `still`: the speed that counts as none, in m/s.
    pub(crate) fn new(
        posture: &Posture,
        stance: Stance,
        still: f64,
        brief: bool,
        options: &'a Options,
        cause: Option<Cause>,
    ) -> Self {
        Self {
            stance,
            ways: Vec::new(),
            mass: posture.fields().mass,
            size: posture.size(),
            still,
            brief,
            options,
            word: Vec::new(),
            undecided: None,
            acceleration: None,
            warning: None,
            cause,
        }
    }

    /// Contacts at rest become part of the phase, each with the sign of its sliding; and with them those that touch and
    /// whose gaps follow from theirs (at one point, or the third of three on one straight floor).
    pub(crate) fn close(&mut self, rests: &mut [bool]) {
        for i in 0..rests.len() {
            let touches = self.stance.points[i].h <= TOUCH * self.size;
            rests[i] |= touches && self.stance.depends(i, rests);
            if rests[i] {
                (self.stance.points[i].h, self.stance.points[i].u) = (0.0, 0.0);
            }
        }
        self.ways = (0..rests.len())
            .map(|i| {
                let speed = self.stance.slip(i);
                rests[i].then(|| i8::from(speed > self.still) - i8::from(speed < -self.still))
            })
            .collect();
    }

    /// The largest of the speeds of the body, in m/s.
    fn speed(&self) -> f64 {
        let Stance { center, spin, .. } = &self.stance;
        center.v.x.abs().max(center.v.y.abs()).max(self.size * spin.omega.abs())
    }

    /// Mode after mode until something else happens. `note` hears of every stretch that begins.
    pub(crate) fn run(&mut self, log: &mut Log<'_>, note: &mut Note<'_>) -> PhaseEnd {
        let mut last = None;
        loop {
            let solved = self.stance.problem(self.mass, &self.ways).and_then(|problem| {
                contact_modes(&problem, Method::Enumerate).map(|modes| (problem, modes))
            });
            let (problem, modes) = match solved {
                Ok(solved) => solved,
                Err(error) => {
                    self.warning = Some(format!("the contact modes could not be solved: {error}"));
                    return PhaseEnd::Outcome(Outcome::EventLimit);
                }
            };
            let answer = match (modes.status(), modes.consistent().next()) {
                (Status::Unique, Some(answer)) => answer,
                (status, _) => {
                    self.undecided = Some(problem);
                    let none = status == Status::None;
                    return PhaseEnd::Outcome(if none {
                        Outcome::Inconsistent
                    } else {
                        Outcome::Ambiguous
                    });
                }
            };
            self.word = answer.word.modes().collect();
            for (way, mode) in self.ways.iter_mut().zip(&self.word) {
                *way = (*mode != Mode::Separate).then_some(mode.direction() as i8);
            }
            if self.word.iter().all(|&mode| mode == Mode::Separate) {
                return PhaseEnd::Free;
            }
            let next = self.hold(answer.acceleration, last, log, note);
            match next {
                Next::End(end) => {
                    if end == PhaseEnd::Outcome(Outcome::Inconsistent) {
                        self.undecided = Some(problem);
                    }
                    return end;
                }
                Next::LiftOff(i) => {
                    self.ways[i] = None;
                    if let Some((j, way)) = self.stance.up_from_vertex(i)
                        && self.ways[j] == Some(0)
                    {
                        self.ways[j] = Some(way);
                    }
                }
                Next::Stop(i) => {
                    let slow = self.speed() <= self.still * STOPPED;
                    if self.stance.stop(i, &self.word, slow) {
                        self.ways[i] = Some(0);
                    } else {
                        self.ways.iter_mut().for_each(|way| *way = way.map(|_| 0));
                    }
                }
                Next::Slip(i, mode) => self.ways[i] = Some(mode.direction() as i8),
            }
            let contact = |i: usize| ContactNumber::of(self.stance.points[i].place.contact);
            self.cause = match next {
                Next::LiftOff(i) => Some(Cause::LiftOff(contact(i))),
                Next::Stop(i) => Some(Cause::Stop(contact(i))),
                Next::Slip(i, _) => Some(Cause::Slip(contact(i))),
                Next::End(_) => self.cause,
            };
            last = Some(next);
        }
    }

    /// Holds the contacts in their word until something happens. `last`: what ended the word before.
    fn hold(
        &mut self,
        acceleration: [f64; 3],
        mut last: Option<Next>,
        log: &mut Log<'_>,
        note: &mut Note<'_>,
    ) -> Next {
        let outcome = |outcome| Next::End(PhaseEnd::Outcome(outcome));
        let [ax, ay, turn] = acceleration;
        let most = ax.abs().max(ay.abs()).max(self.size * turn.abs());
        // Rows that leave no motion leave no velocity either: what there is of it is rounding.
        let rests = self.stance.is_fixed(&self.word)
            || self.speed() <= self.still && most <= STILL * self.stance.gravity;
        let stance = &mut self.stance;
        if rests {
            (stance.center.v, stance.spin.omega) = (Vector2::zeros(), 0.0);
        } else if stance.frozen.is_none() {
            stance.conform(&self.word);
        }
        let mut cycle = Cycle::new(stance, &self.word);
        loop {
            note(stance, &self.word, log.clock, self.cause);
            if rests {
                if self.options.stop != Stop::Time {
                    return outcome(Outcome::Rest);
                }
                log.clock = log.clock.after(log.left().max(0.0));
                return outcome(Outcome::TimeLimit);
            }
            let Some(mut step) = Step::new(stance, &self.word) else {
                return outcome(Outcome::Inconsistent);
            };
            match last.take() {
                Some(Next::LiftOff(i)) if self.word[i] == Mode::Separate => {
                    step.lifts_off(i);
                    if let Some((j, _)) = stance.up_from_vertex(i) {
                        step.breaks_loose(j);
                    }
                }
                Some(Next::Slip(i, mode)) if self.word[i] == mode && !step.breaks_loose(i) => {
                    return outcome(Outcome::Inconsistent);
                }
                _ => {}
            }
            let (t, end) = step.first_event(stance, log.left());
            if t == f64::INFINITY || cycle.is_complete(stance) && log.end == f64::INFINITY {
                self.acceleration = Some(step.acceleration());
                // What flies while nothing ever happens flies away, if it does not turn around with the rest.
                let closed = self.word.iter().all(|&mode| mode != Mode::Separate);
                return outcome(if closed || cycle.turns > 0 {
                    Outcome::Sliding
                } else {
                    Outcome::Escape
                });
            }
            if self.brief && t > LONG * log.clock.hi {
                return Next::End(PhaseEnd::Thaw);
            }
            *stance = step.at(stance, t);
            log.clock = log.clock.after(t);
            let counted = log.count_step();
            match end {
                StepEnd::Landing(i) => {
                    for (j, p) in stance.points.iter_mut().enumerate() {
                        if j == i || self.word[j] == Mode::Separate && p.lands() {
                            (p.h, p.u) = (0.0, p.u.min(0.0));
                        }
                    }
                    return Next::End(PhaseEnd::Landing(i));
                }
                StepEnd::Leave(i, side) => {
                    stance.points[i].place.sides[side] = 0.0;
                    return Next::End(PhaseEnd::Leave(i, side));
                }
                StepEnd::LiftOff(i) => return Next::LiftOff(i),
                StepEnd::Stop(i) => return Next::Stop(i),
                StepEnd::Slip(i, mode) => return Next::Slip(i, mode),
                StepEnd::Jam => return outcome(Outcome::Inconsistent),
                StepEnd::Reach if log.left() <= 0.0 => return outcome(Outcome::TimeLimit),
                StepEnd::Reach if !counted => return outcome(Outcome::EventLimit),
                StepEnd::Reach => {
                    if stance.center.r.norm() > self.options.neighbourhood {
                        return outcome(Outcome::Escape);
                    }
                }
            }
        }
    }
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
