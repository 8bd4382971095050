//! One run of a body: its checks, the choice of the model, and the call of the event loop.

use std::fmt;

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::enclosure;
use crate::error::Error;
use crate::excitation::{Change, Excitation, lasting};
use crate::math::unsigned_zero::UnsignedZero;
use crate::motion::Driver;
use crate::motion::drops::{Dropped, Drops};
use crate::motion::record::Record;
use crate::options::{Edges, Model, Options, Simultaneous};
use crate::outcome::{End, FirstZeno, ModelReason, Outcome};
use crate::simulate::limits::solvable;
use crate::simulate::sensitivity::limited;
use crate::simulate::start::{Start, never_turns};
use crate::simulate::trajectory::Trajectory;

/// A run with kicks or a motion of the ground, or one that can be stopped. Without these, [`simulate`](crate::simulate()) is shorter.
///
/// Up to the first kick the run is, to the last bit, the run without kicks. There is one exception: if the kick falls into bounces that are
/// summed in the run without kicks, these bounces are followed one by one, and the states between them differ by rounding errors. A run
/// that is not stopped earlier by its options lasts at least until the last kick and the last change of the motion of the ground.
///
/// ```
/// use standfast::excitation::{Excitation, Kick};
/// use standfast::{Lamina, Options, Posture, Simulation, State};
///
/// // A block of 2 kg at rest is kicked to v = 3 m/s; friction stops it after v²/(2 μ g) = 0.9 m.
/// let block = Posture::block(1.0, 0.2, &Lamina { mass: 2.0, friction: 0.5, gravity: 10.0, ..Lamina::default() })?;
/// let kick = Kick { time: 1.0, impulse: [6.0, 0.0], ..Kick::default() };
/// let excitation = Excitation { kicks: vec![kick], ..Excitation::default() };
/// let start = State::at_rest([0.0; 3]);
/// let run = Simulation { excitation: &excitation, ..Simulation::new(&block, start, Options::default()) }.run()?;
/// assert!((run.state().q.x - 0.9).abs() < 1e-15);
/// # Ok::<(), standfast::Error>(())
/// ```
#[must_use = "nothing is computed until `run` is called"]
#[derive(Clone, Copy)]
pub struct Simulation<'a> {
    /// The body and its contacts.
    pub posture: &'a Posture,
    /// Where it starts.
    pub start: State,
    /// How the run is made.
    pub options: Options,
    /// The kicks and the motion of the ground.
    pub excitation: &'a Excitation,
    /// Called from time to time, on the thread of the run; once it returns true, the result is [`Error::Cancelled`].
    pub cancel: &'a dyn Fn() -> bool,
}

impl fmt::Debug for Simulation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { posture, start, options, excitation, cancel: _ } = self;
        f.debug_struct("Simulation")
            .field("posture", posture)
            .field("start", start)
            .field("options", options)
            .field("excitation", excitation)
            .finish_non_exhaustive()
    }
}

static NOTHING: Excitation =
    Excitation { kicks: Vec::new(), forces: Vec::new(), ground_motion: None };

impl<'a> Simulation<'a> {
    /// A run without kicks and with the ground at rest, which nothing stops.
    pub fn new(posture: &'a Posture, start: State, options: Options) -> Self {
        Self { posture, start, options, excitation: &NOTHING, cancel: &|| false }
    }

    /// The whole motion.
    ///
    /// # Errors
    ///
    /// As [`simulate`](crate::simulate()); [`Error::Cancelled`]; a kick or a motion of the ground that is out of range; [`Options::certify`] with them.
    pub fn run(&self) -> Result<Trajectory, Error> {
        self.options.validate()?;
        self.checked()?.motion()
    }

    /// The same with checked start and excitation. `options` have been checked.
    fn checked(&self) -> Result<Self, Error> {
        let Self { posture, start, ref options, excitation, .. } = *self;
        let options = &options.acting(posture.frictions())?;
        solvable(posture, options)?;
        if options.model == Model::Local && !posture.has_constant_rows() {
            return Err(Error::Unusable {
                field: "model".into(),
                value: "\"local\"".into(),
                allowed: "\"full\" or \"auto\" with a terrain, a segment or a surface_speed: the local model has straight lines at rest without ends".into(),
            });
        }
        if options.model == Model::Local && excitation.is_linear() {
            return Err(Error::Unusable {
                field: "model".into(),
                value: "\"local\"".into(),
                allowed: "\"full\" or \"auto\" with a linear ground_motion".into(),
            });
        }
        start.validate()?;
        if options.edges == Edges::Contact {
            posture.check_sides(&start.q)?;
        }
        if !excitation.is_none() {
            excitation.validate(options.time, posture.fields().mass, posture.fields().gravity)?;
            if options.certify {
                return Err(Error::Unusable {
                    field: "certify".into(),
                    value: "true".into(),
                    allowed: "false, because the run has kicks, forces or a ground_motion".into(),
                });
            }
        }
        Ok(Self { start: start.unsigned_zero(), options: *options, ..*self })
    }

    /// The model that is solved, with the reason.
    fn choose(&self) -> (Model, ModelReason) {
        match self.options.model {
            Model::Auto if !self.excitation.is_none() => (Model::Full, ModelReason::Excited),
            Model::Auto if !self.posture.has_constant_rows() => (Model::Full, ModelReason::Ground),
            Model::Auto if never_turns(self.posture, &self.start) => {
                (Model::Local, ModelReason::Exact)
            }
            Model::Auto => (Model::Full, ModelReason::Turns),
            model => (model, ModelReason::Set),
        }
    }

    /// The same run of the outer feet of the body, where the inner ones only follow: they have no impulses where all feet are hit at once.
    fn of_outer_feet(&self) -> Option<Self> {
        let at_once = self.options.policy() == Simultaneous::Together && !self.options.certify;
        Some(Self { posture: self.posture.outer_feet().filter(|_| at_once)?, ..*self })
    }

    fn motion(&self) -> Result<Trajectory, Error> {
        limited(&self.options, |options| Self { options: *options, ..*self }.unlimited())
    }

    /// The motion without a limit of the sensitivity.
    fn unlimited(&self) -> Result<Trajectory, Error> {
        let Self { posture, ref options, excitation, .. } = *self;
        if let Some(outer) = self.of_outer_feet()
            && let Ok(run) = outer.unlimited()
            && is_told(run.outcome())
        {
            return Ok(run.of_all_feet(posture));
        }
        let (model, reason) = self.choose();
        let start = Start::new(posture, &self.start, model)?;
        if excitation.is_none() {
            let record = self.record(start, &[])?;
            return self.enclosed(Trajectory::new(record, model, reason, *options));
        }
        let changes =
            excitation.changes(options.time, posture.fields().mass, posture.fields().gravity);
        let mut record = self.record(start, &changes)?;
        record.warnings.extend(lasting(excitation.ground_motion.as_ref()));
        let run = Trajectory::new(record, model, reason, *options);
        Ok(run.excited_by(excitation.clone()))
    }

    /// The end of the motion alone, for options that have been checked. Nothing is recorded. `drops`: of this posture with these options, for a run without excitation.
    pub(super) fn end(&self, drops: Option<&Drops>) -> Result<End, Error> {
        if let Some(drops) = drops {
            let run = Self { start: self.start.unsigned_zero(), options: drops.options, ..*self };
            match drops.follow(self.posture, run.choose().0, &run.start, self.cancel) {
                Dropped::Rests(end) => return Ok(end),
                Dropped::Flies(flight) => {
                    return run.driver(|mut driver| driver.end_after(*flight));
                }
                Dropped::Other => {}
            }
        }
        self.checked()?.end_of_motion()
    }

    /// What a driver of this run finds.
    fn driver<T>(&self, of: impl FnOnce(Driver<'a>) -> Result<T, Error>) -> Result<T, Error> {
        let Self { posture, ref options, cancel, .. } = *self;
        let start = Start::new(posture, &self.start, self.choose().0)?;
        of(start.driver(posture, &self.start, options, cancel))
    }

    fn end_of_motion(&self) -> Result<End, Error> {
        if !self.excitation.is_none() || self.options.sensitivity_limit.is_some() {
            return Ok(end_of(&self.motion()?));
        }
        if let Some(outer) = self.of_outer_feet()
            && let Ok(end) = outer.end_of_motion()
            && is_told(end.outcome)
        {
            return Ok(end);
        }
        self.driver(|mut driver| driver.end())
    }

    /// The record of a run with these changes.
    fn record(&self, start: Start, changes: &[Change]) -> Result<Box<Record>, Error> {
        let Self { posture, ref options, cancel, .. } = *self;
        let mut driver = start.driver(posture, &self.start, options, cancel);
        driver.run_stages(changes, options)?;
        Ok(driver.record)
    }

    /// The run with proved bounds of its times, if the options ask for them.
    fn enclosed(&self, run: Trajectory) -> Result<Trajectory, Error> {
        let Self { posture, ref options, cancel, .. } = *self;
        if !options.certify {
            return Ok(run);
        }
        let enclosure = match run.model() {
            Model::Local => enclosure::enclose_local(posture, &self.start, options, cancel),
            _ => enclosure::enclose_full(posture, &self.start, options, cancel),
        };
        Ok(run.with(enclosure.ok_or(Error::Cancelled)?))
    }
}

/// Whether a run of outer feet with this outcome is that of all feet. Without an end, or with an open one, it would tell of the outer feet alone;
/// and it has no end where the ground parts the rows.
fn is_told(outcome: Outcome) -> bool {
    !matches!(outcome, Outcome::EventLimit | Outcome::Inconsistent | Outcome::Ambiguous)
}

fn end_of(run: &Trajectory) -> End {
    let zeno = run.zeno_points().first().map(|zeno| FirstZeno {
        count: zeno.contacts.len(),
        contact: match zeno.contacts.as_slice() {
            [only] => Some(*only),
            _ => None,
        },
        time: zeno.time,
        elapsed: zeno.elapsed,
    });
    End {
        outcome: run.outcome(),
        time: run.time(),
        elapsed: run.elapsed(),
        state: *run.state(),
        touching: run.touching(),
        zeno,
        collisions: run.collisions(),
        warned: !run.record.warnings.is_empty(),
    }
}
