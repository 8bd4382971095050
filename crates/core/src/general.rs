//! The completed hybrid system for any number of contacts and every law of impact, event by event.
//!
//! The same loop as for two contacts without friction in their impacts, but without its closed sums: an accumulation is
//! followed until the speeds of its contacts are below the rounding of the speeds there have been, and ends there.

use crate::clock::Clock;
use crate::contact_motion::{Stance, Step};
use crate::contact_phase::{ContactPhase, PhaseEnd};
use crate::flight::{Arc, parabola_touchdown};
use crate::impact::Simultaneous;
use crate::impact_law::{self, Material, Matrix};
use crate::log::Log;
use crate::modes::{ContactProblem, Level, Method, Mode, ProblemFields, contact_modes};
use crate::posture::Posture;
use crate::simulate::{Impact, Options, Stop};
use crate::tolerance::{BEYOND, STILL};
use crate::trajectory::Outcome;
use crate::trig::Turn;

/// √(u² + 2gh) of a contact, relative to the largest speed there has been, below which it has come to rest: the rounding of
/// the speeds of the body.
const STOPPED: f64 = 1e-16;

/// Speed of a contact, in units of [`STOPPED`], at which it comes to rest together with one that does: in an accumulation
/// of several their speeds differ by as much.
const TOGETHER: f64 = 1e2;

/// Flights between two computations of b, c from θ itself.
const REFRESH: usize = 32;

/// One collision.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Struck {
    pub(crate) clock: Clock,
    pub(crate) contact: usize,
    pub(crate) before: Vec<f64>,
    pub(crate) after: Vec<f64>,
    /// (tangential, normal), per unit mass.
    pub(crate) impulse: [f64; 2],
}

/// Contacts that come to rest at one instant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settled {
    pub(crate) clock: Clock,
    pub(crate) contacts: Vec<usize>,
    /// Collisions before it.
    pub(crate) hits: usize,
    /// Whether they were at rest from the start of the run.
    pub(crate) from_start: bool,
    pub(crate) stance: Stance,
}

/// From here on the contacts are in this word; all S in flight.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) clock: Clock,
    pub(crate) stance: Stance,
    pub(crate) word: Vec<Mode>,
}

/// What a run hands over.
#[derive(Debug, Clone)]
pub(crate) struct GeneralRecord {
    pub(crate) stretches: Vec<Stretch>,
    pub(crate) collisions: Vec<Struck>,
    pub(crate) zeno: Vec<Settled>,
    pub(crate) end: Stance,
    pub(crate) clock: Clock,
    pub(crate) hits: usize,
    pub(crate) outcome: Outcome,
    pub(crate) warnings: Vec<String>,
    pub(crate) undecided: Option<ContactProblem>,
    pub(crate) acceleration: Option<[f64; 3]>,
}

impl Stance {
    /// Acceleration of the free body into the terrain of a contact, without rotation: g n_y, and c ω² where it is frozen.
    fn pull(&self, i: usize) -> f64 {
        let p = &self.points[i];
        self.gravity * p.normal.y + self.frozen.map_or(0.0, |square| p.c * square)
    }

    fn arc(&self, i: usize) -> Arc {
        let p = &self.points[i];
        let omega = if self.frozen.is_some() { 0.0 } else { self.spin.omega };
        Arc { h: p.h, u: p.u, g: self.pull(i), b: p.b, c: p.c, omega }
    }

    /// Time to the next touchdown of a contact in flight.
    fn touchdown(&self, i: usize) -> Option<f64> {
        let arc = self.arc(i);
        if arc.omega == 0.0 {
            let t = parabola_touchdown(arc.h, arc.u, arc.g);
            return (t < f64::INFINITY).then_some(t);
        }
        arc.touchdown()
    }

    /// The state after a flight of `dt`.
    pub(crate) fn flown(&self, dt: f64) -> Self {
        let mut after = self.clone();
        let turn = Turn::by(self.spin.omega * dt);
        for (i, p) in after.points.iter_mut().enumerate() {
            let arc = self.arc(i);
            if self.frozen.is_some() {
                p.h = (arc.h + dt * (arc.u - 0.5 * arc.g * dt)).max(0.0);
                p.u = arc.u - arc.g * dt;
            } else {
                p.h = arc.gap_turned(dt, &turn).max(0.0);
                p.u = arc.rate_turned(dt, &turn);
                (p.b, p.c) = (
                    arc.b - (arc.b * turn.versed + arc.c * turn.sin),
                    arc.c - (arc.c * turn.versed - arc.b * turn.sin),
                );
            }
        }
        after.spin.theta += self.spin.omega * dt;
        after.center.fly(self.gravity, dt);
        after
    }

    /// The state `dt` into a stretch in this word.
    pub(crate) fn moved(&self, word: &[Mode], dt: f64) -> Self {
        if word.iter().all(|&mode| mode == Mode::Separate) {
            return self.flown(dt);
        }
        let rests = self.center.v == nalgebra::Vector2::zeros() && self.spin.omega == 0.0;
        if rests && word.iter().all(|mode| mode.direction() == 0.0) {
            return self.clone();
        }
        Step::new(self, word).map_or_else(|| self.clone(), |step| step.at(self, dt))
    }

    /// Impact matrix of a contact, per unit mass.
    fn impact_matrix(&self, i: usize) -> Matrix {
        let (p, rho2) = (&self.points[i], self.rho2);
        Matrix { nn: 1.0 + p.b * p.b / rho2, nt: -p.b * p.c / rho2, tt: 1.0 + p.c * p.c / rho2 }
    }

    /// An impulse (tangential, normal) per unit mass acts at contact `i`.
    fn kick(&mut self, i: usize, [p_t, p_n]: [f64; 2]) {
        let hit = self.points[i];
        let force = hit.tangent * p_t + hit.normal * p_n;
        let turn = (hit.b * p_n - hit.c * p_t) / self.rho2;
        self.center.v += force;
        self.spin.omega += turn;
        for p in &mut self.points {
            p.u += p.normal.dot(&force) + p.b * turn;
        }
    }
}

/// The loop.
pub(crate) struct General<'a> {
    posture: Posture,
    options: Options,
    log: Log<'a>,
    state: Stance,
    /// Contacts that rest or slide.
    resting: Vec<bool>,
    /// The largest speed there has been, in m/s.
    fastest: f64,
    stretches: Vec<Stretch>,
    collisions: Vec<Struck>,
    zeno: Vec<Settled>,
    warnings: Vec<String>,
    undecided: Option<ContactProblem>,
    acceleration: Option<[f64; 3]>,
}

impl<'a> General<'a> {
    pub(crate) fn new(
        posture: &Posture,
        state: Stance,
        options: &Options,
        warnings: Vec<String>,
        cancel: &'a dyn Fn() -> bool,
    ) -> Self {
        Self {
            resting: vec![false; state.points.len()],
            posture: posture.clone(),
            options: *options,
            log: Log::new(options.record, options.end(), options.event_limit, cancel),
            state,
            fastest: 0.0,
            stretches: Vec::new(),
            collisions: Vec::new(),
            zeno: Vec::new(),
            warnings,
            undecided: None,
            acceleration: None,
        }
    }

    /// Runs to the outcome; `None` if cancelled.
    pub(crate) fn run(mut self) -> Option<GeneralRecord> {
        self.note(vec![Mode::Separate; self.state.points.len()]); // a run that ends at once has one, too
        let outcome = self.motion();
        if self.log.cancelled {
            return None;
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock = Clock { hi: self.log.end, lo: 0.0 };
        }
        Some(GeneralRecord {
            stretches: self.stretches,
            collisions: self.collisions,
            zeno: self.zeno,
            end: self.state,
            clock: self.log.clock,
            hits: self.log.hits,
            outcome,
            warnings: self.warnings,
            undecided: self.undecided,
            acceleration: self.acceleration,
        })
    }

    fn motion(&mut self) -> Outcome {
        let n = self.state.points.len();
        let mut fresh = true;
        loop {
            if !self.log.count() {
                return Outcome::EventLimit;
            }
            if self.state.center.r.norm() > self.options.neighbourhood.min(BEYOND) {
                return Outcome::Escape;
            }
            let speed =
                self.state.center.v.norm() + self.posture.size() * self.state.spin.omega.abs();
            self.fastest = self.fastest.max(speed);
            let touching = |i: usize| self.state.points[i].h == 0.0;
            let coming: Vec<usize> =
                (0..n).filter(|&i| touching(i) && self.state.points[i].u < 0.0).collect();
            let end = if !coming.is_empty() {
                self.impact(&coming)
            } else if (0..n).any(|i| touching(i) && self.state.points[i].u == 0.0) {
                self.rest(fresh)
            } else {
                self.fly()
            };
            fresh = false;
            if let Some(outcome) = end {
                return outcome;
            }
        }
    }

    fn note(&mut self, word: Vec<Mode>) {
        if self.log.record {
            let (clock, stance) = (self.log.clock, self.state.clone());
            self.stretches.push(Stretch { clock, stance, word });
        }
    }

    /// Flight to the next touchdown.
    fn fly(&mut self) -> Option<Outcome> {
        let n = self.state.points.len();
        self.resting.fill(false);
        self.note(vec![Mode::Separate; n]);
        let landings: Vec<Option<f64>> = (0..n).map(|i| self.state.touchdown(i)).collect();
        let first = landings.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let left = self.log.left();
        if first > left || first == f64::INFINITY {
            if left == f64::INFINITY {
                return Some(Outcome::Escape);
            }
            self.state = self.state.flown(left.max(0.0));
            self.log.clock = self.log.clock.after(left.max(0.0));
            return Some(Outcome::TimeLimit);
        }
        self.state = self.state.flown(first);
        self.log.clock = self.log.clock.after(first);
        if self.log.hits.is_multiple_of(REFRESH) && self.state.frozen.is_none() {
            let theta = self.state.spin.theta;
            let (sin, cos) = (libm::sin(theta), libm::cos(theta));
            for (p, k) in self.state.points.iter_mut().zip(self.posture.geometry()) {
                (p.b, p.c) = k.turned(sin, cos);
            }
        }
        for (p, landing) in self.state.points.iter_mut().zip(landings) {
            if landing == Some(first) {
                (p.h, p.u) = (0.0, p.u.min(0.0));
            }
        }
        None
    }

    /// Contacts with zero gap approach: one impact, or several at once.
    fn impact(&mut self, coming: &[usize]) -> Option<Outcome> {
        let arriving: Vec<usize> = coming.iter().copied().filter(|&i| !self.resting[i]).collect();
        let chosen = if arriving.is_empty() { coming } else { &arriving };
        if arriving.len() > 1 {
            let names: Vec<String> = arriving.iter().map(|i| (i + 1).to_string()).collect();
            let tie = format!(
                "contacts {} collided at the same instant; the outcome depends on the policy `simultaneous`",
                names.join(", ")
            );
            if !self.warnings.contains(&tie) {
                self.warnings.push(tie);
            }
            if self.options.simultaneous == Simultaneous::Newton {
                return self.together();
            }
        }
        let last = self.options.simultaneous == Simultaneous::LastContactFirst;
        let i = if last { *chosen.last()? } else { chosen[0] };
        let contact = self.posture.contacts()[i];
        let restitution = self.posture.geometry()[i].restitution;
        let material = Material {
            friction: contact.friction,
            restitution,
            tangential_restitution: contact.tangential_restitution,
        };
        let w = self.state.impact_matrix(i);
        let rate = self.state.points[i].u;
        let law = self.options.impact;
        let Some(impulse) = impact_law::impulse(law, &w, [self.state.slip(i), rate], &material)
        else {
            self.warnings.push(format!("the law of impact has no answer at contact {}", i + 1));
            return Some(Outcome::Inconsistent);
        };
        let before = self.rates();
        self.state.kick(i, impulse);
        if law != Impact::Poisson && law != Impact::Stronge {
            self.state.points[i].u = -restitution * rate; // the law itself, not its rounding
        }
        self.log.hits += 1;
        self.write_down(i, before, impulse);
        self.stop_slow()
    }

    fn rates(&self) -> Vec<f64> {
        if self.log.record { self.state.points.iter().map(|p| p.u).collect() } else { Vec::new() }
    }

    fn write_down(&mut self, contact: usize, before: Vec<f64>, impulse: [f64; 2]) {
        if self.log.record {
            let (clock, after) = (self.log.clock, self.rates());
            self.collisions.push(Struck { clock, contact, before, after, impulse });
        }
    }

    /// Newton's frictionless law for all of them: u⁺ + e u⁻ ≥ 0 ⊥ P ≥ 0, a contact-mode problem without friction.
    fn together(&mut self) -> Option<Outcome> {
        let (n, state) = (self.state.points.len(), &self.state);
        let restitutions: Vec<f64> =
            self.posture.geometry().iter().map(|k| k.restitution).collect();
        let before: Vec<f64> = state.points.iter().map(|p| p.u).collect();
        let problem = ContactProblem::new(ProblemFields {
            friction: vec![0.0; n],
            // Without friction the sign of sliding is of no matter; one that is not zero spares the search.
            sliding: (0..n).map(|i| (state.points[i].h == 0.0).then_some(1)).collect(),
            bias: (0..n).map(|i| [0.0, restitutions[i] * before[i].min(0.0)]).collect(),
            free_acceleration: [state.center.v.x, state.center.v.y, state.spin.omega],
            level: Level::Impulse,
            ..state.fields(1.0) // impulses per unit mass
        });
        let modes = problem.and_then(|problem| contact_modes(&problem, Method::Enumerate)).ok();
        let answer = modes.as_ref().and_then(|modes| modes.consistent().next());
        let Some(forces) = answer.map(|answer| answer.forces.clone()) else {
            self.warnings.push("the impacts of one instant could not be solved".into());
            return Some(Outcome::Inconsistent);
        };
        for (i, force) in forces.iter().enumerate().filter(|(_, force)| force[1] > 0.0) {
            self.state.kick(i, [0.0, force[1]]);
        }
        for (i, force) in forces.iter().enumerate().filter(|(_, force)| force[1] > 0.0) {
            self.state.points[i].u = -restitutions[i] * before[i].min(0.0);
            self.log.hits += 1;
            self.write_down(i, before.clone(), [0.0, force[1]]);
        }
        self.stop_slow()
    }

    /// Contacts so slow and so near that all that is left of their motion is rounding have come to rest, and with the
    /// first of them those that are about to: one that stops by itself in a common accumulation would change the course
    /// of the others, whose impacts then might go on for ever at the edge of what counts.
    fn stop_slow(&mut self) -> Option<Outcome> {
        let slow = |state: &Stance, i: usize, limit: f64| {
            let (p, pull) = (&state.points[i], state.arc(i).effective_gravity());
            pull > 0.0 && p.u * p.u + 2.0 * pull * p.h <= limit * limit
        };
        let (n, limit) = (self.state.points.len(), STOPPED * self.fastest);
        for i in 0..n {
            // A contact that the spin of the body lifts has no bounces to come to rest from.
            let lifted = self.state.arc(i).effective_gravity() <= 0.0;
            let p = &mut self.state.points[i];
            if lifted && p.h == 0.0 && p.u.abs() <= limit {
                p.u = 0.0;
            }
        }
        if !(0..n).any(|i| slow(&self.state, i, limit)) {
            return None;
        }
        let mut stopped = Vec::new();
        for i in 0..n {
            if slow(&self.state, i, TOGETHER * limit) {
                let p = &mut self.state.points[i];
                (p.h, p.u) = (0.0, 0.0);
                if !self.resting[i] {
                    stopped.push(i);
                }
            }
        }
        if stopped.is_empty() { None } else { self.settle(&stopped, false) }
    }

    /// Notes that these contacts have come to rest.
    fn settle(&mut self, contacts: &[usize], from_start: bool) -> Option<Outcome> {
        for &i in contacts {
            self.resting[i] = true;
        }
        let clock = self.log.clock;
        match self.zeno.last_mut() {
            // One accumulation ends contact by contact, within the rounding of the clock.
            Some(last) if clock.since(last.clock) <= 2.0 * f64::EPSILON * clock.hi => {
                last.contacts.extend_from_slice(contacts);
                last.contacts.sort_unstable();
                last.contacts.dedup();
                last.stance = self.state.clone();
            }
            _ => self.zeno.push(Settled {
                clock,
                contacts: contacts.to_vec(),
                hits: self.log.hits,
                from_start,
                stance: self.state.clone(),
            }),
        }
        (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno)
    }

    /// Contacts at rest on the terrain go on in their mode.
    fn rest(&mut self, fresh: bool) -> Option<Outcome> {
        let n = self.state.points.len();
        let mut rests: Vec<bool> =
            self.state.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        let (options, record) = (self.options, self.log.record);
        let still = STILL * self.fastest.max(self.posture.fields().gravity * self.log.clock.hi);
        let mut phase =
            ContactPhase::new(&self.posture, self.state.clone(), still, false, &options);
        phase.close(&mut rests);
        self.state = phase.stance.clone();
        // At the start only what gravity presses down has come to rest.
        let new: Vec<usize> = (0..n)
            .filter(|&i| rests[i] && !self.resting[i])
            .filter(|&i| !fresh || self.state.arc(i).effective_gravity() > 0.0)
            .collect();
        if !new.is_empty()
            && let Some(outcome) = self.settle(&new, fresh)
        {
            return Some(outcome);
        }
        let stretches = &mut self.stretches;
        let end = phase.run(&mut self.log, &mut |stance, word, clock| {
            if record {
                stretches.push(Stretch { clock, stance: stance.clone(), word: word.to_vec() });
            }
        });
        self.resting = phase.word.iter().map(|mode| *mode != Mode::Separate).collect();
        self.resting.resize(n, false);
        self.state = phase.stance;
        self.warnings.extend(phase.warning);
        (self.undecided, self.acceleration) = (phase.undecided, phase.acceleration);
        match end {
            PhaseEnd::Outcome(outcome) => Some(outcome),
            PhaseEnd::Free => self.fly(),
            PhaseEnd::Landing(_) | PhaseEnd::Thaw => None,
        }
    }
}
