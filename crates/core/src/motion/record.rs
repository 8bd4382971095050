//! The record of a run: the pieces of its motion, its collisions and its Zeno points.

use nalgebra::Vector2;

use crate::body::contact::{ContactLetters, PerContact};
use crate::body::lines::Feet;
use crate::body::state::State;
use crate::collisions::log::{Center, Collision, Log, Spin};
use crate::math::clock::Clock;
use crate::math::mass_vector::Coordinates;
use crate::modes::{ContactProblem, MechanismProblem, Mode};
use crate::motion::moving::Moving;
use crate::motion::subject::Subject;
use crate::outcome::{Cause, ContactSet, Instant, Outcome, ZenoMethod};
use crate::sustained::frozen::Frozen;

/// How the body moves during a span.
#[derive(Debug, Clone)]
pub(crate) enum Motion {
    /// Each contact is in its mode; in flight all are separate, with plain collisions in between. `acceleration`: the constant one of constant
    /// rows.
    Modes { start: Moving, word: ContactLetters<Mode>, acceleration: Option<Coordinates> },
    /// The sum of infinitely many impacts. `fastest`: bound of the speeds of the run until then.
    Sum { start: Moving, fastest: f64, tail: Tail },
}

impl Motion {
    pub(crate) fn start(&self) -> &Moving {
        match self {
            Self::Modes { start, .. } | Self::Sum { start, .. } => start,
        }
    }

    /// The mode of each contact.
    pub(crate) fn letters(&self, subject: &Subject) -> String {
        match (self, subject.posture()) {
            (Self::Modes { start: Moving::Turning(body), word, .. }, Some(posture)) => {
                body.letters(word, posture)
            }
            (Self::Modes { word, .. }, _) => subject.per_contact(|i| word[i].letter()).collect(),
            (Self::Sum { .. }, _) => "S".repeat(subject.count()),
        }
    }
}

/// How a state within a sum of impacts is computed: in the geometry at its start, or event by event.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Tail {
    /// One contact bounces.
    Bounce { contact: usize },
    /// After every cycle both gaps are zero again and all rates are multiplied by `ratio`; the cycles last for `duration`.
    Cycle { ratio: f64, duration: f64 },
    /// Collision by collision.
    Collisions,
}

/// A piece of the run: the body moves in this way until the next span.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    pub(crate) clock: Clock,
    pub(crate) motion: Motion,
    /// `None`: the phase of the previous span continues.
    pub(crate) cause: Option<Cause>,
    /// Index of the first plain collision after its start.
    pub(crate) first_collision: usize,
}

/// The body at an instant in the form of the results. Without a body only θ and ω are defined.
#[derive(Debug)]
pub(crate) struct Moment {
    pub(crate) clock: Clock,
    pub(crate) state: State,
    pub(crate) gaps: PerContact<f64>,
    pub(crate) rates: PerContact<f64>,
    /// The contacts of corners of the ground with sides, from 0, that touch.
    pub(crate) sides: PerContact<usize>,
    /// The state of a mechanism; that of a body has no meaning then.
    pub(crate) mechanism: Option<Box<Frozen>>,
}

/// Written by hand: the derived `clone` copies the numbers one by one.
impl Clone for Moment {
    fn clone(&self) -> Self {
        let [gaps, rates] = [&self.gaps, &self.rates].map(|values| PerContact::from_slice(values));
        let sides = PerContact::from_slice(&self.sides);
        let mechanism = self.mechanism.clone();
        Self { clock: self.clock, state: self.state, gaps, rates, sides, mechanism }
    }
}

impl Moment {
    /// The start of a run.
    pub(crate) fn of(subject: &Subject) -> Self {
        let (clock, state, mechanism) = (Clock::default(), subject.start(), None);
        let (gaps, rates, sides) = (PerContact::new(), PerContact::new(), PerContact::new());
        Self { clock, state, gaps, rates, sides, mechanism }
    }

    /// `feet`: all contacts of the body.
    pub(crate) fn instant(&self, feet: &Feet) -> Instant {
        let [gaps, rates] = [&self.gaps, &self.rates].map(|values| feet.means(values));
        Instant { state: self.state, gaps, rates }
    }

    /// The contacts that touch. `feet`: all contacts of the body.
    pub(crate) fn touching(&self, feet: &Feet) -> ContactSet {
        let gaps: PerContact<f64> = feet.means(&self.gaps);
        ContactSet::of_gaps(&gaps).with(self.sides.iter().copied())
    }
}

#[derive(Debug, Clone)]
pub(crate) struct ZenoRecord {
    /// The contacts that come to rest.
    pub(crate) closed: PerContact<bool>,
    pub(crate) method: ZenoMethod,
    pub(crate) certified: bool,
    /// Whether each of them comes to rest in an impact without rebound.
    pub(crate) plastic: bool,
    /// Error of its time, in s.
    pub(crate) error: f64,
    /// Number of collisions before it.
    pub(crate) first_summed: usize,
    pub(crate) at: Moment,
}

impl ZenoRecord {
    /// The contacts that come to rest, from 0. `feet`: all contacts of the body. Of the feet of a row the inner ones rest with the second of the
    /// outer ones.
    pub(crate) fn contacts(&self, feet: &Feet) -> impl Iterator<Item = usize> {
        let own = |i: usize| (self.closed[i], self.at.gaps.get(i).is_some_and(|gap| *gap == 0.0));
        let between = |[one, other]: [(bool, bool); 2], _| {
            let rest = one.1 && other.1;
            ((one.0 || other.0) && rest, rest)
        };
        let all = feet.all(self.closed.len(), own, between).enumerate();
        all.filter(|(_, (closed, _))| *closed).map(|(i, _)| i)
    }
}

/// A collision that was simulated outside the loops over plain collisions.
#[derive(Debug, Clone)]
pub(crate) struct ListedImpact {
    pub(crate) clock: Clock,
    /// Number of plain collisions before it.
    pub(crate) collisions: usize,
    pub(crate) contact: usize,
    /// Gap rates point by point, in m/s.
    pub(crate) before: Vec<f64>,
    pub(crate) after: Vec<f64>,
    /// (tangential, normal), per unit mass, in m/s.
    pub(crate) impulse: [f64; 2],
}

#[derive(Debug, Clone)]
pub(crate) struct Record {
    pub(crate) outcome: Outcome,
    pub(crate) subject: Subject,
    pub(crate) spans: Vec<Span>,
    pub(crate) zeno: Vec<ZenoRecord>,
    pub(crate) warnings: Vec<String>,
    /// Plain collisions of two contacts, and the body after each of them.
    pub(crate) collisions: Vec<Collision>,
    pub(crate) bodies: Vec<(Center, Spin)>,
    /// The corners of the ground and the sides, from 0, that have met each other, in the order of their contact numbers.
    pub(crate) sides: Vec<(Vector2<f64>, usize)>,
    /// All other collisions.
    pub(crate) impacts: Vec<ListedImpact>,
    pub(crate) hits: usize,
    pub(crate) end: Moment,
    pub(crate) acceleration: Option<Vec<f64>>,
    pub(crate) undecided: Option<Box<ContactProblem>>,
    pub(crate) undecided_mechanism: Option<Box<MechanismProblem>>,
}

impl Record {
    /// Of a run from this start on; the run sets the fields of its end.
    pub(crate) fn new(subject: Subject, warnings: Vec<String>) -> Self {
        let end = Moment::of(&subject);
        Self {
            outcome: Outcome::EventLimit,
            subject,
            spans: Vec::new(),
            zeno: Vec::new(),
            warnings,
            collisions: Vec::new(),
            bodies: Vec::new(),
            sides: Vec::new(),
            impacts: Vec::new(),
            hits: 0,
            end,
            acceleration: None,
            undecided: None,
            undecided_mechanism: None,
        }
    }

    /// Begins a span.
    pub(crate) fn begin(&mut self, log: &Log<'_>, motion: Motion, cause: Option<Cause>) {
        let (clock, first_collision) = (log.clock, log.collisions.len());
        self.spans.push(Span { clock, motion, cause, first_collision });
    }

    /// Records the problem of a word that constant rows do not determine. `ways`: signs of sliding; `None`: separate.
    pub(crate) fn write_undecided(&mut self, state: &Frozen, ways: &[Option<i8>]) {
        match &self.subject {
            Subject::Body(body) => {
                self.undecided = body.problem(state.space().pull(), ways).ok().map(Box::new);
            }
            Subject::Mechanism(start) => {
                let mechanism = start.mechanism.in_space(&state.rows.space);
                let problem = MechanismProblem::new(&mechanism, ways);
                self.undecided_mechanism = problem.ok().map(Box::new);
            }
            Subject::Local(_) => {}
        }
    }
}
