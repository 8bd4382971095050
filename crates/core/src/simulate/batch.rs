//! Many runs at once.
//!
//! Runs are independent: each has the same result as a single run, to the bit. Threads take blocks of runs. Within a block,
//! collisions of several runs are computed together in the lanes of vector registers ([`crate::math::lanes`]); a run leaves its
//! lane for any other event.

use std::num::NonZero;
use std::ops::Range;
use std::thread::available_parallelism;

use fearless_simd::{Level, dispatch};

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::collisions::{full, local};
use crate::error::Error;
use crate::excitation::Excitation;
use crate::math::lanes;
use crate::math::unsigned_zero::UnsignedZero;
use crate::motion::{Driver, DriverStep, Flight, Pair, Resume};
use crate::options::{Model, Options};
use crate::outcome::{ContactSet, End, FirstZeno, Outcome};
use crate::simulate::parallel::{FailedAt, in_blocks};
use crate::simulate::trajectory::Trajectory;
use crate::simulate::{Start, simulate_excited_until, solvable};

/// Least number of runs that justifies the start of a thread.
const LEAST: usize = 16;

/// Resources of the machine that many runs may use. Results do not depend on them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Resources {
    /// Threads, at least 1.
    pub threads: usize,
    /// Most runs in a register: 1, 2, 4 or 8. Lanes that the machine does not have are not used.
    pub lanes: usize,
}

impl Default for Resources {
    /// All resources of the machine.
    fn default() -> Self {
        Self { threads: available_parallelism().map_or(1, NonZero::get), lanes: 8 }
    }
}

/// The ends of many runs: of one posture from each of the states, or of as many postures as states, each from its own state.
/// Nothing is recorded; [`simulate`](crate::simulate()) computes the same run, to the bit, with its events.
///
/// ```
/// use standfast::{Model, Options, Outcome, Posture, State, simulate_many};
///
/// let rod = Posture::rod(0.5, 0.2, 0.1, 0.0, 9.81)?;
/// let starts: Vec<State> = (1..100).map(|k| State::at_rest([0.0, 0.01, 1e-4 * f64::from(k)])).collect();
/// let ends = simulate_many(&[rod], &starts, &Options { model: Model::Local, ..Options::default() })?;
/// assert!(ends.iter().all(|end| end.outcome == Outcome::Rest));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Unusable`] unless there is one posture, or one for each state; [`Error::At`] with the number of the first run that
/// fails, from 0, and its error, as of [`simulate`](crate::simulate()).
pub fn simulate_many(
    postures: &[Posture],
    states: &[State],
    options: &Options,
) -> Result<Vec<End>, Error> {
    simulate_many_until(postures, states, options, Resources::default(), &|| false)
        .map(|ends| ends.unwrap_or_else(|| unreachable!("nothing cancels these runs")))
}

/// As [`simulate_many`], with these resources. `cancel` is called from time to time; once it returns true, the result is
/// `None`.
///
/// # Errors
///
/// As [`simulate_many`].
pub fn simulate_many_until(
    postures: &[Posture],
    states: &[State],
    options: &Options,
    resources: Resources,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Vec<End>>, Error> {
    simulate_many_excited_until(
        postures,
        states,
        options,
        &Excitation::default(),
        resources,
        cancel,
    )
}

/// As [`simulate_many_until`], with the same kicks and motion of the ground in each run.
///
/// # Errors
///
/// As [`simulate_many`]; a kick or a motion of the ground that is out of range.
pub fn simulate_many_excited_until(
    postures: &[Posture],
    states: &[State],
    options: &Options,
    excitation: &Excitation,
    resources: Resources,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Vec<End>>, Error> {
    options.validate()?;
    if let Some(posture) = postures.first() {
        excitation.validate(options.time, posture.fields().gravity)?;
    }
    if postures.len() != 1 && postures.len() != states.len() {
        return Err(Error::Unusable {
            field: "posture".into(),
            value: format!("[{} postures]", postures.len()),
            allowed: format!("one posture, or one for each of the {} states", states.len()),
        });
    }
    ends_until(postures, states, options, excitation, resources, cancel)
        .map_err(|(run, error)| Error::At { place: format!("run {run}"), error: error.into() })
}

/// As [`simulate_many_excited_until`], of valid options and excitation, with the number of the first run that fails.
pub(crate) fn ends_until(
    postures: &[Posture],
    states: &[State],
    options: &Options,
    excitation: &Excitation,
    resources: Resources,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Vec<End>>, FailedAt> {
    let options = Options { record: false, certify: false, ..*options };
    let level = level(resources.lanes);
    let work = |runs: Range<usize>, stop: &dyn Fn() -> bool| {
        // Each block has its own copy: a shared posture would be reference-counted by all threads.
        let own = (postures.len() == 1).then(|| postures[0].detached());
        let posture = |run: usize| own.as_ref().unwrap_or_else(|| &postures[run]);
        Block { posture: &posture, states, options: &options, excitation, level, stop }.run(runs)
    };
    let blocks = in_blocks(states.len(), LEAST, resources.threads, cancel, &work)?;
    Ok(blocks.map(|blocks| {
        let mut ends = Vec::with_capacity(states.len());
        blocks.into_iter().for_each(|block| ends.extend(block));
        ends
    }))
}

/// The instruction set for registers of at most `lanes` lanes; `None`: runs are computed one by one.
fn level(lanes: usize) -> Option<Level> {
    let level = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let level = match lanes {
        8.. => level,
        4..8 => level.as_avx2().map_or(level, Level::Avx2),
        _ => level.as_sse2().map_or(level, Level::Sse2),
    };
    (lanes > 1).then_some(level)
}

/// A block of runs, computed one by one or in lanes.
struct Block<'a> {
    posture: &'a dyn Fn(usize) -> &'a Posture,
    states: &'a [State],
    options: &'a Options,
    excitation: &'a Excitation,
    level: Option<Level>,
    stop: &'a dyn Fn() -> bool,
}

struct Run<'a> {
    number: usize,
    driver: Driver<'a, Pair>,
    flight: Option<Flight>,
}

/// The stage at which a run returns control.
enum Stage {
    /// Plain collisions are next, in its lane.
    Lane,
    Over(Outcome),
}

/// The lanes of one of the models. Runs are numbered from 0.
trait Lanes: Default {
    /// Adds a run if plain collisions are next and it may be added.
    fn put(&mut self, run: usize, driver: &Driver<'_, Pair>, flight: &Flight) -> bool;

    /// Simulates plain collisions of all active runs until one of them stops.
    fn alternate(&mut self, level: Level);

    fn on(&self) -> u64;

    fn take(&mut self, run: usize, driver: &mut Driver<'_, Pair>, flight: &mut Flight) -> Resume;
}

impl Lanes for local::Pool {
    fn put(&mut self, run: usize, _: &Driver<'_, Pair>, flight: &Flight) -> bool {
        matches!(flight, Flight::Local(_, collisions) if self.put(run, collisions))
    }

    fn alternate(&mut self, level: Level) {
        dispatch!(level, simd => self.alternate(simd));
    }

    fn on(&self) -> u64 {
        self.on()
    }

    fn take(&mut self, run: usize, _: &mut Driver<'_, Pair>, flight: &mut Flight) -> Resume {
        if let Flight::Local(_, collisions) = flight {
            self.take(run, collisions);
        }
        Resume::Any
    }
}

impl Lanes for full::Pool {
    fn put(&mut self, run: usize, driver: &Driver<'_, Pair>, flight: &Flight) -> bool {
        matches!(flight, Flight::Full(state, collisions) if driver.enter((state, collisions), self, run))
    }

    fn alternate(&mut self, level: Level) {
        dispatch!(level, simd => self.alternate(simd));
    }

    fn on(&self) -> u64 {
        self.on()
    }

    fn take(&mut self, run: usize, driver: &mut Driver<'_, Pair>, flight: &mut Flight) -> Resume {
        match flight {
            Flight::Full(state, collisions) => {
                Resume::after(driver.leave_lane((state, collisions), self, run))
            }
            Flight::Local(..) => Resume::Any,
        }
    }
}

impl<'a> Block<'a> {
    fn run(&self, runs: Range<usize>) -> Result<Option<Vec<End>>, FailedAt> {
        match self.options.model {
            _ if !self.excitation.is_none() => runs.map(|run| self.alone(run)).collect(),
            Model::Local => self.in_lanes::<local::Pool>(runs),
            Model::Full => self.in_lanes::<full::Pool>(runs),
            Model::Auto => runs.map(|run| self.alone(run)).collect(),
        }
    }

    /// Computes a run outside the lanes; `None` if it was cancelled.
    fn alone(&self, number: usize) -> Result<Option<End>, FailedAt> {
        let (posture, state) = ((self.posture)(number), &self.states[number]);
        simulate_excited_until(posture, state, self.options, self.excitation, self.stop)
            .map(|run| run.map(|run| end_of(&run)))
            .map_err(|error| (number, error))
    }

    /// The ends of these runs, computed in lanes where possible; `None` if they were cancelled.
    fn in_lanes<L: Lanes>(&self, mut numbers: Range<usize>) -> Result<Option<Vec<End>>, FailedAt> {
        let first = numbers.start;
        let mut ends: Vec<Option<End>> = vec![None; numbers.len()];
        let width = self.level.map_or(1, lanes_of);
        let mut pool = L::default();
        let mut runs: Vec<Option<Run>> = (0..width).map(|_| None).collect();
        loop {
            let on = pool.on();
            for (k, slot) in runs.iter_mut().enumerate().filter(|(k, _)| on >> k & 1 == 0) {
                let mut then = Resume::Any;
                if let Some(Run { driver, flight: Some(flight), .. }) = slot {
                    then = pool.take(k, driver, flight);
                }
                // Starts runs until one enters the lane.
                loop {
                    let Some(run) = slot else {
                        let Some(number) = numbers.next() else { break };
                        self.begin(number, slot).map_err(|error| (number, error))?;
                        if slot.is_none() {
                            let Some(end) = self.alone(number)? else { return Ok(None) };
                            ends[number - first] = Some(end);
                        }
                        continue;
                    };
                    let lanes = self.level.map(|_| (&mut pool, k));
                    match run.go_on(std::mem::replace(&mut then, Resume::Any), lanes) {
                        Stage::Lane => break,
                        Stage::Over(outcome) => {
                            let Some(end) = run.driver.finish(outcome) else { return Ok(None) };
                            ends[run.number - first] = Some(end);
                            *slot = None;
                        }
                    }
                }
            }
            match self.level {
                Some(level) if pool.on() != 0 => pool.alternate(level),
                _ => break,
            }
        }
        Ok(ends.into_iter().collect())
    }

    /// Creates a run at its start; leaves `place` empty if its model or options have no lanes.
    fn begin(&self, number: usize, place: &mut Option<Run<'a>>) -> Result<(), Error> {
        let (posture, state, options) =
            ((self.posture)(number), &self.states[number].unsigned_zero(), self.options);
        if Start::is_pair(posture, options) {
            solvable(posture, options)?;
            state.validate()?;
            let start = Start::new(posture, state, options.model)?;
            let driver = start.driver(posture, state, options, self.stop);
            *place = Some(Run { number, driver, flight: None });
        }
        Ok(())
    }
}

impl Run<'_> {
    /// Simulates a run until it enters its lane or ends.
    fn go_on<L: Lanes>(&mut self, mut then: Resume, mut lanes: Option<(&mut L, usize)>) -> Stage {
        loop {
            if let Some(flight) = &mut self.flight {
                let mut enter = |driver: &Driver<'_, Pair>, flight: &Flight| match &mut lanes {
                    Some((pool, k)) => pool.put(*k, driver, flight),
                    None => false,
                };
                match self.driver.fly(flight, then, &mut enter) {
                    None => return Stage::Lane,
                    Some(halt) => then = Resume::LoopExit(halt),
                }
                self.flight = None;
            }
            if let Resume::LoopExit(halt) = then
                && let Some(outcome) = self.driver.land(halt)
            {
                return Stage::Over(outcome);
            }
            then = Resume::Any;
            match self.driver.piece() {
                DriverStep::Piece => {}
                DriverStep::End(outcome) => return Stage::Over(outcome),
                DriverStep::Flight => match self.driver.begin_flight() {
                    Ok(flight) => self.flight = Some(flight),
                    Err(halt) => then = Resume::LoopExit(halt),
                },
            }
        }
    }
}

fn lanes_of(level: Level) -> usize {
    dispatch!(level, simd => lanes::count(simd))
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
        touching: ContactSet::of_gaps(&run.gaps()),
        zeno,
        collisions: run.collisions(),
        warned: !run.warnings().is_empty(),
    }
}
