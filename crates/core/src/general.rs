//! The completed hybrid system for any number of contacts and every law of impact, event by event.
//!
//! The same loop as for two contacts without friction in their impacts, but without its closed sums: an accumulation is
//! followed until the speeds of its contacts are below the rounding of the speeds there have been, and ends there. Only
//! impacts in turn in one instant are summed.

use nalgebra::{Vector2, Vector3};

use crate::clock::Clock;
use crate::contact_motion::{Point, Rounding, Stance, Step};
use crate::contact_phase::{ContactPhase, PhaseEnd};
use crate::flight::{Arc, LOST_PHASE, PHASE_LOST, parabola_touchdown};
use crate::impact::Simultaneous;
use crate::impact_law::{self, Material, Matrix};
use crate::log::Log;
use crate::modes::{ContactProblem, Level, Method, Mode, ProblemFields, contact_modes};
use crate::posture::Posture;
use crate::simulate::{Impact, Options, Stop};
use crate::terrain::Place;
use crate::tolerance::{BEYOND, STILL, TOUCH};
use crate::trajectory::{Cause, ContactNumber, Outcome};
use crate::trig::Turn;

/// √(u² + 2gh) of a contact, relative to the largest speed there has been, below which it has come to rest: the rounding of
/// the speeds of the body.
const STOPPED: f64 = 1e-16;

/// How much faster than that a contact may be to be hit in turn with one that is below.
const IN_TURN: f64 = 1e3;

/// Speed of a contact in a vertex of its terrain where nothing rubs, relative to the largest there has been, below which it
/// has come to rest there: unlike a gap rate, it is a difference of the body's speeds, with a few of their roundings.
const WEDGED: f64 = 1e-14;

/// From a piece that is so much steeper than the next a gap loses more by that quotient than it has, in size, of roundings.
const STEEP: f64 = 8.0;
/// Gap of a contact that lands together with another one, in bounds of its rounding: these leave out what errors of the
/// body's own motion add to all gaps, a few times as much.
const SIMULTANEOUS: f64 = 16.0;

/// Impacts of one instant that are followed one by one before a limit of theirs is looked for.
const LISTED: usize = 64;

/// Roundings in the changes of velocity between two impacts of a contact in one instant.
const ROUNDINGS: f64 = 64.0;

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
    /// Time that their last bounces would still have taken, in s.
    pub(crate) error: f64,
    pub(crate) stance: Stance,
}

/// From here on the contacts are in this word; all S in flight.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) clock: Clock,
    pub(crate) stance: Stance,
    pub(crate) word: Vec<Mode>,
    /// `None`: the phase goes on.
    pub(crate) cause: Option<Cause>,
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

/// Time to the next zero of an arc.
fn next(arc: &Arc) -> Option<f64> {
    if arc.omega == 0.0 {
        let t = parabola_touchdown(arc.h, arc.u, arc.g);
        return (t < f64::INFINITY).then_some(t);
    }
    arc.touchdown()
}

impl Point {
    /// Whether its gap is zero within its rounding, and closing: at this instant it lands, as the first contact does.
    pub(crate) fn lands(&self) -> bool {
        self.u < 0.0 && self.h <= SIMULTANEOUS * self.rounding.gap && self.h < f64::INFINITY
    }
}

impl Rounding {
    /// At the start: of the terms of a gap and of its rate.
    pub(crate) fn new(gap: f64, rate: f64) -> Self {
        Self { gap: f64::EPSILON * gap, rate: f64::EPSILON * rate }
    }

    /// After an arc of `dt` from a gap `h` on, whose terms sum up to `gap`, and those of its rate to `rate`.
    pub(crate) fn after(self, dt: f64, h: f64, gap: f64, rate: f64) -> Self {
        if h == f64::INFINITY {
            return self; // over nothing
        }
        let before = if h == 0.0 { 0.0 } else { self.gap };
        let own = Self::new(gap, rate);
        Self { gap: before + self.rate * dt + own.gap, rate: self.rate + own.rate }
    }
}

impl Stance {
    /// Acceleration of the free body into the terrain of a contact, without rotation: g n_y, and c ω² where it is frozen.
    fn pull(&self, i: usize) -> f64 {
        let p = &self.points[i];
        self.gravity * p.normal.y + self.frozen.map_or(0.0, |square| p.c * square)
    }

    /// Distance of a point to the left (0) or right (1) end of the terrain under it, as an arc without gravity.
    fn side(&self, i: usize, side: usize) -> Arc {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let (p, spin) = (&self.points[i], self.spin.omega);
        let arm = p.arm();
        let u = sign * (self.center.v.x - arm.y * spin);
        let (b, c, omega) = match self.frozen {
            Some(_) => (0.0, 0.0, 0.0),
            None => (-sign * arm.y, sign * arm.x, spin),
        };
        Arc { h: p.place.sides[side], u, g: 0.0, b, c, omega }
    }

    /// When a point in flight comes to an end of the terrain under it, and which.
    fn crossing(&self, i: usize) -> Option<(f64, usize)> {
        let mut first: Option<(f64, usize)> = None;
        for side in 0..2 {
            let arc = self.side(i, side);
            if arc.h == f64::INFINITY {
                continue;
            }
            let outwards = arc.u < 0.0 || arc.u == 0.0 && arc.effective_gravity() > 0.0;
            let t = if arc.h == 0.0 && outwards { Some(0.0) } else { next(&arc) };
            if let Some(t) = t
                && first.is_none_or(|(earlier, _)| t < earlier)
            {
                first = Some((t, side));
            }
        }
        first
    }

    fn arc(&self, i: usize) -> Arc {
        let p = &self.points[i];
        let omega = if self.frozen.is_some() { 0.0 } else { self.spin.omega };
        Arc { h: p.h, u: p.u, g: self.pull(i), b: p.b, c: p.c, omega }
    }

    /// Time to the next touchdown of a contact in flight.
    fn touchdown(&self, i: usize) -> Option<f64> {
        next(&self.arc(i))
    }

    /// The state after a flight of `dt`.
    pub(crate) fn flown(&self, dt: f64) -> Self {
        let mut after = self.clone();
        let turn = Turn::by(if self.frozen.is_some() { 0.0 } else { self.spin.omega * dt });
        for (i, p) in after.points.iter_mut().enumerate() {
            let (arc, was) = (self.arc(i), &self.points[i]);
            let [gap, rate] = arc.terms(dt, &turn);
            p.rounding = was.rounding.after(dt, was.h, gap, rate);
            for side in 0..2 {
                if p.place.sides[side] < f64::INFINITY {
                    p.place.sides[side] = self.side(i, side).gap_turned(dt, &turn).max(0.0);
                }
            }
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
        let step = if self.is_fixed(word) { None } else { Step::new(self, word) };
        let Some(step) = step else { return self.clone() };
        // A body at rest stays so where nothing but rounding accelerates it.
        let still = self.center.v == Vector2::zeros() && self.spin.omega == 0.0;
        let [ax, ay, turn] = step.acceleration();
        let most = ax.abs().max(ay.abs()).max(self.rho2.sqrt() * turn.abs());
        if still && most <= STILL * self.gravity { self.clone() } else { step.at(self, dt) }
    }

    /// Impact matrix of a contact, per unit mass.
    fn impact_matrix(&self, i: usize) -> Matrix {
        let (p, rho2) = (&self.points[i], self.rho2);
        Matrix { nn: 1.0 + p.b * p.b / rho2, nt: -p.b * p.c / rho2, tt: 1.0 + p.c * p.c / rho2 }
    }

    /// An impulse (tangential, normal) per unit mass acts at contact `i`: returns the change of velocity.
    fn kick(&mut self, i: usize, [p_t, p_n]: [f64; 2]) -> Vector3<f64> {
        let hit = self.points[i];
        let force = hit.tangent * p_t + hit.normal * p_n;
        let turn = (hit.b * p_n - hit.c * p_t) / self.rho2;
        self.center.v += force;
        self.spin.omega += turn;
        for p in &mut self.points {
            let (push, twist) = (p.normal.dot(&force), p.b * turn);
            p.u += push + twist;
            p.rounding.rate += f64::EPSILON * (push.abs() + twist.abs());
        }
        Vector3::new(force.x, force.y, turn)
    }
}

/// Impacts in one instant, without a flight between them.
#[derive(Debug, Clone, Default)]
struct Sequence {
    clock: Clock,
    hits: usize,
    /// For each point: since it was hit last.
    rounds: Vec<Round>,
}

/// From one impact at a point to the next at the same, in one instant.
#[derive(Debug, Clone, Default)]
struct Round {
    /// Gap rates at its beginning; none before the first.
    rates: Vec<f64>,
    /// Change of velocity in this round, and in the one before.
    change: Vector3<f64>,
    before: Option<Vector3<f64>>,
}

/// Impacts that are all nearly slow enough to stop.
#[derive(Debug, Clone, Copy, Default)]
struct Ripple {
    impacts: usize,
    /// The largest speed of a slow contact in this stretch of them, and in the one before, in m/s.
    largest: f64,
    before: f64,
    /// Two stretches were alike.
    goes_on: bool,
}

impl Ripple {
    /// Impacts between two looks at whether they grow or shrink.
    const STRETCH: usize = 256;

    /// Factor between two stretches below which they do neither: contacts that lose a hundredth of their speed in each impact
    /// come down by more.
    const ALIKE: f64 = 8.0;

    /// After an impact with the speed `hit`, by which contacts of these speeds are left.
    fn follow(&mut self, hit: f64, speeds: &[f64], limit: f64) {
        if hit > limit {
            *self = Self::default();
            return;
        }
        let slow = speeds.iter().filter(|speed| **speed <= limit);
        self.largest = slow.fold(self.largest, |most, speed| most.max(*speed)).max(hit);
        self.impacts += 1;
        if self.impacts == Self::STRETCH {
            let (now, before) = (self.largest, self.before);
            let alike = now <= Self::ALIKE * before && before <= Self::ALIKE * now;
            *self = Self { before: now, goes_on: self.goes_on || alike, ..Self::default() };
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
    /// The last event; `None`: one that changes no mode.
    cause: Option<Cause>,
    /// The largest speed there has been, in m/s.
    fastest: f64,
    stretches: Vec<Stretch>,
    collisions: Vec<Struck>,
    zeno: Vec<Settled>,
    sequence: Sequence,
    /// Impacts for which a contact that is slow enough to stop has waited for others.
    waiting: usize,
    ripple: Ripple,
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
            cause: Some(Cause::Start),
            fastest: 0.0,
            stretches: Vec::new(),
            collisions: Vec::new(),
            zeno: Vec::new(),
            sequence: Sequence::default(),
            waiting: 0,
            ripple: Ripple::default(),
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
            let n = self.state.points.len(); // two for a contact in a vertex
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
            let (clock, stance, cause) = (self.log.clock, self.state.clone(), self.cause);
            self.stretches.push(Stretch { clock, stance, word, cause });
        }
    }

    /// Flight to the next touchdown, or to an end of a piece of terrain.
    fn fly(&mut self) -> Option<Outcome> {
        self.leave_vertices();
        let n = self.state.points.len();
        self.resting.fill(false);
        self.note(vec![Mode::Separate; n]);
        let lost = self.is_lost();
        let landings: Vec<Option<f64>> = (0..n).map(|i| self.state.touchdown(i)).collect();
        let first = landings.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let crossing = (0..n)
            .filter_map(|i| self.state.crossing(i).map(|(t, side)| (t, i, side)))
            .filter(|(t, ..)| !lost && *t < first)
            .min_by(|x, y| x.0.total_cmp(&y.0));
        let t = crossing.map_or(first, |(t, ..)| t);
        let left = self.log.left();
        if t > left || t == f64::INFINITY {
            if left == f64::INFINITY {
                return Some(Outcome::Escape);
            }
            self.state = self.state.flown(left.max(0.0));
            self.log.clock = self.log.clock.after(left.max(0.0));
            return Some(Outcome::TimeLimit);
        }
        let turns = self.state.frozen.is_none();
        if turns && (self.state.spin.omega * t).abs() > PHASE_LOST {
            self.warnings.push(LOST_PHASE.into());
            return Some(Outcome::EventLimit);
        }
        self.state = self.state.flown(t);
        self.log.clock = self.log.clock.after(t);
        if self.log.hits.is_multiple_of(REFRESH) && self.state.frozen.is_none() {
            let theta = self.state.spin.theta;
            let (sin, cos) = (libm::sin(theta), libm::cos(theta));
            for p in &mut self.state.points {
                let k = self.posture.on_nearest(&p.place);
                (p.b, p.c) = k.turned(sin, cos);
            }
        }
        if let Some((_, i, side)) = crossing {
            self.state.points[i].place.sides[side] = 0.0;
            self.cross(i, side);
            return None;
        }
        for (p, landing) in self.state.points.iter_mut().zip(landings) {
            if landing == Some(first) || p.lands() {
                (p.h, p.u) = (0.0, p.u.min(0.0));
            }
        }
        None
    }

    /// Whether the body has fallen below all of its terrain: nothing is ever met again.
    fn is_lost(&self) -> bool {
        let Stance { center, gravity, .. } = &self.state;
        let lowest = self.posture.lowest_ground();
        let rise = 0.5 * center.v.y.max(0.0) * center.v.y / gravity;
        let top = self.posture.fields().center_of_mass[1] + center.r.y + rise;
        lowest > f64::NEG_INFINITY && top + self.posture.size() < lowest
    }

    /// Contact `i` crosses the left (0) or right (1) end of the piece of terrain under it: the next piece is as high there,
    /// and the point moves on over it, or there is none, and it meets nothing any more.
    fn cross(&mut self, i: usize, side: usize) {
        let count = self.posture.contacts().len();
        let contact = self.state.points[i].place.contact;
        self.cause = self.resting[i].then_some(Cause::LeftSegment(ContactNumber::of(contact)));
        if let Some(twin) = (count..self.state.points.len())
            .find(|&k| self.state.points[k].place.contact == contact)
        {
            // At a vertex it had two pieces; the other one is left.
            if i < count {
                self.state.points[i] = self.state.points[twin];
                self.resting[i] = self.resting[twin];
            }
            self.state.points.remove(twin);
            self.resting.remove(twin);
            return;
        }
        if self.wedge(i, side) {
            return;
        }
        let p = self.neighbour(i, side);
        self.state.points[i] = p;
        self.resting[i] &= p.h == 0.0 && p.u == 0.0;
    }

    /// Contact `i` at an end of the piece of terrain under it, over the next one.
    fn neighbour(&self, i: usize, side: usize) -> Point {
        let old = self.state.points[i];
        let mut p = old;
        let Place { contact, piece, .. } = old.place;
        let next = if side == 0 { piece - 1 } else { piece + 1 };
        let width = self.posture.piece(contact, next).map_or(f64::INFINITY, |k| k.to - k.from);
        p.place = Place {
            contact,
            piece: next,
            sides: if side == 0 { [width, 0.0] } else { [0.0, width] },
        };
        let Some(piece) = self.posture.piece(contact, next) else {
            p.h = f64::INFINITY;
            return p;
        };
        let com = Vector2::from(self.posture.fields().center_of_mass);
        let arm = old.arm();
        let velocity = old.tangent * self.state.slip(i) + old.normal * old.u;
        (p.tangent, p.normal) = (piece.tangent, piece.normal);
        (p.b, p.c) = (p.tangent.dot(&arm), p.normal.dot(&arm));
        p.held = None;
        if p.normal != old.normal {
            p.u = p.normal.dot(&velocity);
        }
        let turn = if self.state.frozen.is_some() { self.state.spin.theta } else { 0.0 };
        let at = com + self.state.center.r + arm + Vector2::new(-arm.y, arm.x) * turn;
        let (height, touch) = (piece.height(&at), TOUCH * self.posture.size());
        if old.h < f64::INFINITY && !(height > touch && p.normal.y > STEEP * old.normal.y) {
            p.h = old.h * p.normal.y / old.normal.y; // as high above the vertex as before
            return p;
        }
        p.h = if height >= -touch { height.max(0.0) } else { f64::INFINITY };
        let terms = self.state.center.r.norm() + p.b.abs() + p.c.abs() + self.posture.size();
        p.rounding = Rounding { gap: f64::EPSILON * terms, ..old.rounding };
        p
    }

    /// Whether a contact has come to rest in a vertex between two rising pieces, on both of them.
    fn wedge(&mut self, i: usize, side: usize) -> bool {
        let old = self.state.points[i];
        let next = if side == 0 { old.place.piece - 1 } else { old.place.piece + 1 };
        let Some(piece) = self.posture.piece(old.place.contact, next) else { return false };
        let rises = old.tangent.perp(&piece.tangent) * if side == 0 { -1.0 } else { 1.0 };
        let slip = self.state.slip(i);
        let height = old.h + old.place.sides[side] / old.tangent.x;
        let square = slip * slip + old.u * old.u + 2.0 * self.state.gravity * height;
        let limit = self.wedged(i);
        // Without gravity a contact may come to rest anywhere.
        let near = height <= TOUCH * self.posture.size();
        if !(rises > 0.0 && near && square <= limit * limit) {
            return false;
        }
        let p = &mut self.state.points[i];
        (p.h, p.u, p.place.sides[side]) = (0.0, 0.0, 0.0);
        let twin = Point { h: 0.0, u: 0.0, ..self.neighbour(i, side) };
        self.state.points.push(twin);
        self.resting.push(true);
        true
    }

    /// Contacts that leave a vertex where they met two pieces: they are over the one that they move to.
    fn leave_vertices(&mut self) {
        let count = self.posture.contacts().len();
        while let Some(twin) = self.state.points.pop() {
            if self.state.points.len() < count {
                self.state.points.push(twin);
                break;
            }
            let i = twin.place.contact;
            let right = self.state.side(i, 0).u > 0.0;
            if right == (twin.place.piece > self.state.points[i].place.piece) {
                self.state.points[i] = twin;
            }
        }
        self.resting.truncate(count);
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
                return if self.sum_up(chosen[0]) { self.stop_slow(0.0) } else { self.together() };
            }
        }
        let last = self.options.simultaneous == Simultaneous::LastContactFirst;
        let i = if last { *chosen.last()? } else { chosen[0] };
        let owner = self.state.points[i].place.contact;
        let material = self.material(i);
        let restitution = material.restitution;
        let w = self.state.impact_matrix(i);
        let (rate, rounding) = (self.state.points[i].u, self.state.points[i].rounding);
        let law = self.options.impact;
        if self.sum_up(i) {
            return self.stop_slow(0.0);
        }
        let Some(impulse) = impact_law::impulse(law, &w, [self.state.slip(i), rate], &material)
        else {
            self.warnings.push(format!("the law of impact has no answer at contact {}", i + 1));
            return Some(Outcome::Inconsistent);
        };
        let before = self.rates();
        self.kick(i, impulse);
        if restitution == 0.0 || !matches!(law, Impact::Poisson | Impact::Stronge) {
            let p = &mut self.state.points[i];
            p.u = -restitution * rate; // the law itself, not its rounding
            p.rounding.rate = restitution * (rounding.rate + f64::EPSILON * rate.abs());
        }
        self.log.hits += 1;
        self.cause = Some(Cause::Impact(ContactNumber::of(owner)));
        self.write_down(owner, before, impulse);
        if self.state.points.len() == self.posture.contacts().len()
            && (self.wedge(i, 0) || self.wedge(i, 1))
        {
            let g = self.state.gravity;
            return self.settle(&[i], false, 2.0 * self.wedged(i) / g);
        }
        self.stop_slow(rate.abs())
    }

    /// No mode is consistent: where the law of impact has an answer, an impact without collision at a sliding contact.
    fn jam(&mut self) -> bool {
        let points = &self.state.points;
        let mut closed: Vec<usize> =
            (0..points.len()).filter(|&i| points[i].h == 0.0 && points[i].u == 0.0).collect();
        if self.options.simultaneous == Simultaneous::LastContactFirst {
            closed.reverse();
        }
        let law = self.options.impact;
        let found = closed.into_iter().find_map(|i| {
            let w = self.state.impact_matrix(i);
            let impulse = impact_law::jam(law, &w, self.state.slip(i), &self.material(i));
            impulse.map(|impulse| (i, impulse))
        });
        let Some((i, impulse)) = found else { return false };
        let contact = self.state.points[i].place.contact;
        let warning = format!(
            "contact {} jammed while it slid, where no contact mode is consistent: an impact without collision",
            contact + 1
        );
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
        let before = self.rates();
        self.kick(i, impulse);
        if self.material(i).restitution == 0.0 {
            self.state.points[i].u = 0.0; // the end of compression, not its rounding
        }
        self.resting[i] = false;
        self.undecided = None;
        self.log.hits += 1;
        self.cause = Some(Cause::Impact(ContactNumber::of(contact)));
        self.write_down(contact, before, impulse);
        true
    }

    /// What point `i` is made of.
    fn material(&self, i: usize) -> Material {
        let owner = self.state.points[i].place.contact;
        let contact = self.posture.contacts()[owner];
        Material {
            friction: contact.friction,
            restitution: self.posture.geometry()[owner].restitution,
            tangential_restitution: contact.tangential_restitution,
        }
    }

    /// Gap rates contact by contact: without the second points of contacts in vertices, which come after all first ones.
    fn rates(&self) -> Vec<f64> {
        let count = if self.log.record { self.posture.contacts().len() } else { 0 };
        self.state.points.iter().take(count).map(|p| p.u).collect()
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
        let restitution = |p: &Point| self.posture.geometry()[p.place.contact].restitution;
        let restitutions: Vec<f64> = state.points.iter().map(restitution).collect();
        let before: Vec<f64> = state.points.iter().map(|p| p.u).collect();
        let listed = self.rates();
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
            self.kick(i, [0.0, force[1]]);
        }
        for (i, force) in forces.iter().enumerate().filter(|(_, force)| force[1] > 0.0) {
            self.state.points[i].u = -restitutions[i] * before[i].min(0.0);
            self.log.hits += 1;
            let contact = self.state.points[i].place.contact;
            self.cause = Some(Cause::Impact(ContactNumber::of(contact)));
            self.write_down(contact, listed.clone(), [0.0, force[1]]);
        }
        self.stop_slow(before.iter().fold(0.0, |most, u| most.max(-u)))
    }

    /// An impulse (tangential, normal) per unit mass acts at point `i`.
    fn kick(&mut self, i: usize, impulse: [f64; 2]) {
        let change = self.state.kick(i, impulse);
        for round in &mut self.sequence.rounds {
            round.change += change;
        }
    }

    /// Point `i` is about to be hit, after others in the same instant. Where the rounds of impacts from one at `i` to the
    /// next shrink in one ratio r, with all changes of velocity, infinitely many of them are summed:
    ///
    /// ```text
    /// v_∞ = v + Δv r/(1 − r)
    /// ```
    ///
    /// Contacts whose rates come to zero with it are hit infinitely often; they come to rest.
    fn sum_up(&mut self, i: usize) -> bool {
        let rates: Vec<f64> = self.state.points.iter().map(|p| p.u).collect();
        let sequence = &mut self.sequence;
        if sequence.clock != self.log.clock || sequence.rounds.len() != rates.len() {
            let rounds = vec![Round::default(); rates.len()];
            *sequence = Sequence { clock: self.log.clock, hits: 0, rounds };
        }
        sequence.hits += 1;
        let round = &mut sequence.rounds[i];
        let before = (!round.rates.is_empty()).then_some(round.change);
        let next = Round { rates: rates.clone(), change: Vector3::zeros(), before };
        let Round { rates: start, change, before } = std::mem::replace(round, next);
        let Some(last) = before.filter(|_| sequence.hits > LISTED) else { return false };
        let ratio = rates[i] / start[i];
        if !(0.0 < ratio && ratio < 1.0) {
            return false;
        }
        let sum = ratio / (1.0 - ratio);
        let few = ROUNDINGS * f64::EPSILON;
        let gyration = self.state.rho2.sqrt();
        let size = |v: Vector3<f64>| Vector3::new(v.x, v.y, gyration * v.z).norm();
        if !(size(change - last * ratio) <= few * size(change)) {
            return false;
        }
        let mut end = self.state.clone();
        end.center.v += change.xy() * sum;
        end.spin.omega += change.z * sum;
        for (j, p) in end.points.iter_mut().enumerate() {
            if p.h > 0.0 {
                p.u += sum * (p.normal.dot(&change.xy()) + p.b * change.z);
                continue;
            }
            p.u += (rates[j] - start[j]) * sum;
            if p.u.abs() <= few * (1.0 + sum) * start[j].abs() {
                p.u = 0.0;
            } else if p.u < 0.0 && !(rates[j] < 0.0 && start[j] < 0.0) {
                return false; // it is hit before; one that waits for its turn has it after all of these
            }
        }
        // Who slides through all of it has to slide the same way at its end.
        let turns_back = |j: usize| {
            let (slip, after) = (self.state.slip(j), end.slip(j));
            end.points[j].u == 0.0 && slip * after < 0.0 && after.abs() > few * self.fastest
        };
        if (0..rates.len()).any(turns_back) {
            return false;
        }
        self.state = end;
        true
    }

    /// Contacts so slow and so near that all that is left of their motion is rounding have come to rest. Not so while
    /// another one is nearly as slow: the two may be hit in turn. What were taken from the one that leaves would be
    /// missing when the other is hit, and the impacts would go on for ever. Nor do they end where what is taken from them
    /// feeds them, or the roundings of faster motions do: impacts nearly as slow that neither grow nor shrink stop, too.
    /// `hit`: the speed of the impact.
    fn stop_slow(&mut self, hit: f64) -> Option<Outcome> {
        let limit = STOPPED * self.fastest;
        let pulls: Vec<f64> =
            (0..self.state.points.len()).map(|i| self.state.arc(i).effective_gravity()).collect();
        // Without gravity, or with next to none, a contact may be slow anywhere.
        let near = TOUCH * self.posture.size();
        let speed = |(p, pull): (&Point, &f64)| match (p.h, *pull > 0.0) {
            (0.0, _) => p.u.abs(),
            (h, true) if h <= near => (p.u * p.u + 2.0 * pull * h).sqrt(),
            _ => f64::INFINITY,
        };
        let speeds: Vec<f64> = self.state.points.iter().zip(&pulls).map(speed).collect();
        let in_turn = |one: f64, other: f64| {
            other > limit && other <= IN_TURN * limit && one > STOPPED * other
        };
        // In turn for ever at the edge of what counts: they stop together.
        let slow = speeds.iter().any(|&speed| speed <= limit);
        self.waiting = if slow { self.waiting + 1 } else { 0 };
        self.ripple.follow(hit, &speeds, IN_TURN * limit);
        let together = self.waiting > LISTED || self.ripple.goes_on;
        let (mut stopped, mut error) = (Vec::new(), 0.0_f64);
        for (i, &speed) in speeds.iter().enumerate() {
            let alone = speed <= limit && !speeds.iter().any(|&other| in_turn(speed, other));
            if !(alone || together && speed <= IN_TURN * limit) {
                continue;
            }
            let loss = 1.0 - self.material(i).restitution;
            let p = &mut self.state.points[i];
            (p.h, p.u) = (0.0, 0.0);
            if !self.resting[i] {
                if pulls[i] > 0.0 {
                    error = error.max(2.0 * speed / (pulls[i] * loss));
                }
                stopped.push(i);
            }
        }
        if stopped.is_empty() {
            return None;
        }
        self.waiting = 0;
        self.ripple.goes_on = false;
        for p in &mut self.state.points {
            p.rounding.rate = if p.u == 0.0 && p.h == 0.0 { 0.0 } else { p.rounding.rate + limit };
        }
        self.settle(&stopped, false, error)
    }

    /// Notes that these contacts have come to rest.
    fn settle(&mut self, points: &[usize], from_start: bool, error: f64) -> Option<Outcome> {
        let mut contacts = Vec::new();
        for &i in points {
            self.resting[i] = true;
            contacts.push(self.state.points[i].place.contact);
        }
        if !from_start {
            self.cause = Some(Cause::Zeno);
        }
        let clock = self.log.clock;
        match self.zeno.last_mut() {
            // One accumulation ends contact by contact, within the rounding of the clock.
            Some(last) if clock.since(last.clock) <= 2.0 * f64::EPSILON * clock.hi => {
                last.contacts.append(&mut contacts);
                last.contacts.sort_unstable();
                last.contacts.dedup();
                last.stance = self.state.clone();
                last.error = last.error.max(error);
            }
            _ => self.zeno.push(Settled {
                clock,
                contacts,
                hits: self.log.hits,
                from_start,
                error,
                stance: self.state.clone(),
            }),
        }
        (self.options.stop == Stop::Zeno).then_some(Outcome::Zeno)
    }

    /// Sliding speed that counts as none, in m/s.
    fn still(&self) -> f64 {
        STILL * self.fastest.max(self.posture.fields().gravity * self.log.clock.hi)
    }

    /// Speed of point `i` in a vertex that counts as none, in m/s.
    fn wedged(&self, i: usize) -> f64 {
        let rubs = self.state.points[i].friction > 0.0;
        if rubs { self.still() } else { WEDGED * self.fastest }
    }

    /// Contacts at rest on the terrain go on in their mode.
    fn rest(&mut self, fresh: bool) -> Option<Outcome> {
        let n = self.state.points.len();
        let mut rests: Vec<bool> =
            self.state.points.iter().map(|p| p.h == 0.0 && p.u == 0.0).collect();
        let (options, record) = (self.options, self.log.record);
        let still = self.still();
        let mut phase = ContactPhase::new(
            &self.posture,
            self.state.clone(),
            still,
            false,
            &options,
            self.cause,
        );
        phase.close(&mut rests);
        self.state = phase.stance.clone();
        // At the start only what gravity presses down has come to rest.
        let held =
            |i: usize| self.resting[i] || self.state.twin(i).is_some_and(|j| self.resting[j]);
        let new: Vec<usize> = (0..n)
            .filter(|&i| rests[i] && !held(i))
            .filter(|&i| !fresh || self.state.arc(i).effective_gravity() > 0.0)
            .collect();
        if !new.is_empty()
            && let Some(outcome) = self.settle(&new, fresh, 0.0)
        {
            return Some(outcome);
        }
        phase.cause = self.cause;
        let stretches = &mut self.stretches;
        let end = phase.run(&mut self.log, &mut |stance, word, clock, cause| {
            if record {
                let (stance, word) = (stance.clone(), word.to_vec());
                stretches.push(Stretch { clock, stance, word, cause });
            }
        });
        self.resting = phase.word.iter().map(|mode| *mode != Mode::Separate).collect();
        self.resting.resize(n, false);
        (self.state, self.cause) = (phase.stance, phase.cause);
        self.warnings.extend(phase.warning);
        (self.undecided, self.acceleration) = (phase.undecided, phase.acceleration);
        match end {
            PhaseEnd::Outcome(Outcome::Inconsistent) if self.jam() => self.stop_slow(0.0),
            PhaseEnd::Outcome(outcome) => Some(outcome),
            PhaseEnd::Free => self.fly(),
            PhaseEnd::Leave(i, side) => {
                self.cross(i, side);
                None
            }
            PhaseEnd::Landing(_) | PhaseEnd::Thaw => None,
        }
    }
}
