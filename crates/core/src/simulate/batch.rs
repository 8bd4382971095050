//! Many runs at once.
//!
//! Runs are independent: each has the same result as a single run, to the bit. Threads take blocks of runs.

use std::ops::Range;

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::Error;
use crate::excitation::Excitation;
use crate::motion::drops::Drops;
use crate::options::Options;
use crate::outcome::End;
use crate::simulate::limits::solvable;
use crate::simulate::parallel::{FailedAt, Resources, in_blocks};
use crate::simulate::simulation::Simulation;

/// Least number of runs that justifies the start of a thread.
const LEAST: usize = 16;

/// The ends of many runs: of one posture from each of the states, or of as many postures as states, each from its own state.
/// Nothing is recorded; [`simulate`](crate::simulate()) computes the same run, to the bit, with its events.
///
/// ```
/// use standfast::{Lamina, Model, Options, Outcome, Posture, State, simulate_many};
///
/// let lamina = Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() };
/// let rod = Posture::rod(0.5, &lamina)?;
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
    let (nothing, resources) = ([Excitation::default()], Resources::default());
    simulate_many_until(postures, states, options, &nothing, resources, &|| false)
}

/// As [`simulate_many`], with kicks, forces and a motion of the ground, the same in each run or one excitation for each, and with these resources. `cancel` is called from time to
/// time, always on the thread that has called this function; once it returns true, the result is [`Error::Cancelled`].
///
/// ```
/// use standfast::excitation::Excitation;
/// use standfast::simulate::{Resources, simulate_many_until};
/// use standfast::{Error, Lamina, Options, Posture, State};
///
/// let rod = [Posture::rod(0.5, &Lamina::default())?];
/// let (starts, options) = ([State::at_rest([0.0, 0.01, 0.001])], Options::default());
/// let (nothing, resources) = ([Excitation::default()], Resources { threads: 1 });
/// let run = |cancel: &dyn Fn() -> bool| simulate_many_until(&rod, &starts, &options, &nothing, resources, cancel);
/// assert_eq!(run(&|| false)?.len(), 1);
/// assert_eq!(run(&|| true), Err(Error::Cancelled));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`simulate_many`]; a kick or a motion of the ground that is out of range.
pub fn simulate_many_until(
    postures: &[Posture],
    states: &[State],
    options: &Options,
    excitations: &[Excitation],
    resources: Resources,
    cancel: &dyn Fn() -> bool,
) -> Result<Vec<End>, Error> {
    options.validate()?;
    if let ([posture, ..], [excitation]) = (postures, excitations) {
        excitation.validate(options.time, posture.fields().mass, posture.fields().gravity)?;
    }
    for (field, one, many, count) in [
        ("posture", "posture", "postures", postures.len()),
        ("ground_motion", "motion of the ground", "motions", excitations.len()),
    ] {
        if count != 1 && count != states.len() {
            return Err(Error::Unusable {
                field: field.into(),
                value: format!("[{count} {many}]"),
                allowed: format!("one {one}, or one for each of the {} states", states.len()),
            });
        }
    }
    ends(postures, states, options, excitations, resources, cancel)
        .map_err(|(run, error)| error.at(|| format!("run {run}")))
}

/// As [`simulate_many_until`], of valid options and excitation, with the number of the first run that fails.
pub(crate) fn ends(
    postures: &[Posture],
    states: &[State],
    options: &Options,
    excitations: &[Excitation],
    resources: Resources,
    cancel: &dyn Fn() -> bool,
) -> Result<Vec<End>, FailedAt> {
    let options = Options { record: false, certify: false, ..*options };
    let work = |runs: Range<usize>, stop: &dyn Fn() -> bool| {
        // Each block has its own copy: a shared posture would be reference-counted by all threads.
        let own = (postures.len() == 1).then(|| postures[0].detached());
        let drops = |posture: &Posture| {
            let options = options.acting(posture.frictions()).ok()?;
            solvable(posture, &options).ok()?;
            Drops::new(posture, options)
        };
        let known = own.as_ref().map(drops);
        let end = |run: usize| {
            // A run asks only after a thousand steps.
            if stop() {
                return Err((run, Error::Cancelled));
            }
            let posture = own.as_ref().unwrap_or_else(|| &postures[run]);
            let start = states[run];
            let excitation = excitations.get(run).unwrap_or(&excitations[0]);
            let one = Simulation { posture, start, options, excitation, cancel: stop };
            let own = if known.is_none() { drops(posture) } else { None };
            let drops = known.as_ref().map_or(own.as_ref(), Option::as_ref);
            one.end(drops.filter(|_| excitation.is_none())).map_err(|error| (run, error))
        };
        runs.map(end).collect::<Result<Vec<End>, FailedAt>>()
    };
    let blocks = in_blocks(states.len(), LEAST, resources.threads, cancel, &work)?;
    let mut ends = Vec::with_capacity(states.len());
    blocks.into_iter().for_each(|block| ends.extend(block));
    Ok(ends)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::body::Lamina;
    use crate::options::Impact;

    #[test]
    fn short_runs_are_stopped_too() {
        let asked = Cell::new(0);
        let cancel = || {
            asked.set(asked.get() + 1);
            asked.get() > 3
        };
        let block = Posture::block(0.3, 0.5, &Lamina { friction: 0.5, ..Lamina::default() });
        let blocks = [block.unwrap_or_else(|e| panic!("{e}"))];
        let starts = [State::at_rest([0.0, 0.1, 0.2]); 100];
        let options = Options { impact: Impact::Moreau, ..Options::default() };
        let resources = Resources { threads: 1 };
        let nothing = [Excitation::default()];
        let ends = simulate_many_until(&blocks, &starts, &options, &nothing, resources, &cancel);
        assert_eq!(ends, Err(Error::Cancelled));
        assert_eq!(asked.get(), 4);
    }
}
