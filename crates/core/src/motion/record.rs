//! The record that the event loops hand over.

use crate::body::state::State;
use crate::collisions::log::{Center, Collision, Spin};
use crate::modes::{ContactProblem, Mode};
use crate::motion::any::GeneralRecord;
use crate::motion::frame::{Base, Frame, Snapshot};
use crate::outcome::{Cause, Method, Outcome};

/// Kinds of motion between two notes of the driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    /// Ballistic, with simple collisions in between.
    Flight,
    /// These contacts are held, in a model without a body.
    Held([bool; 2]),
    /// Each contact is in its mode; the rotation at which the geometry is frozen, if it is.
    Modes([Mode; 2], Option<Spin>),
    /// A summed tail; the frame is frozen.
    Tail(Tail),
    /// This stretch of a general run.
    Stretch(usize),
}

/// How a summed tail is looked into.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Tail {
    /// A contact bounces by itself.
    Bounce { contact: usize },
    /// Gaps of zero come again after every cycle, with all rates multiplied by `ratio`, for `duration`.
    Cycle { ratio: f64, duration: f64 },
    /// Collision by collision.
    Collisions,
}

/// From here on the motion is of this kind, until the next span.
#[derive(Debug, Clone)]
pub(crate) struct Span {
    pub(crate) raw: Snapshot,
    pub(crate) frame: usize,
    pub(crate) kind: Kind,
    pub(crate) mode: [u8; 2],
    pub(crate) cause: Option<Cause>,
    /// Index of the first collision after its start.
    pub(crate) first_collision: usize,
}

#[derive(Debug, Clone)]
pub(crate) struct ZenoRecord {
    pub(crate) closed: [bool; 2],
    pub(crate) method: Method,
    pub(crate) certified: bool,
    pub(crate) error: f64,
    pub(crate) first_summed: usize,
    pub(crate) state: State,
    pub(crate) at: Snapshot,
}

/// What the driver hands over.
#[derive(Debug, Clone)]
pub(crate) struct Record {
    pub(crate) outcome: Outcome,
    pub(crate) base: Base,
    pub(crate) frames: Vec<Frame>,
    pub(crate) spans: Vec<Span>,
    pub(crate) zeno: Vec<ZenoRecord>,
    pub(crate) warnings: Vec<String>,
    pub(crate) collisions: Vec<Collision>,
    pub(crate) bodies: Vec<(Center, Spin)>,
    pub(crate) hits: usize,
    pub(crate) end: Snapshot,
    pub(crate) state: State,
    pub(crate) acceleration: Option<[f64; 3]>,
    pub(crate) undecided: Option<Box<ContactProblem>>,
    /// The events of a run with any number of contacts and any law of impact; those above are then empty.
    pub(crate) general: Option<Box<GeneralRecord>>,
}

impl Record {
    /// The record of a run of this body with any number of contacts.
    pub(crate) fn of_general(base: Base, general: GeneralRecord) -> Self {
        let mut state = general.end.state();
        if general.outcome == Outcome::Rest {
            state.qdot.fill(0.0);
        }
        Self {
            outcome: general.outcome,
            base,
            frames: Vec::new(),
            spans: Vec::new(),
            zeno: Vec::new(),
            warnings: general.warnings.clone(),
            collisions: Vec::new(),
            bodies: Vec::new(),
            hits: general.hits,
            end: Snapshot { clock: general.clock, ..Snapshot::default() },
            state,
            acceleration: general.acceleration,
            undecided: general.undecided.clone().map(Box::new),
            general: Some(Box::new(general)),
        }
    }
}

impl Record {
    /// Leaves what a run that is not recorded keeps.
    pub(crate) fn forget(&mut self) {
        (self.frames, self.spans) = (Vec::new(), Vec::new());
        (self.collisions, self.bodies) = (Vec::new(), Vec::new());
    }
}
