//! Runs with kicks, or on ground that moves.

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::Error;
use crate::excitation::{Change, Excitation, lasting, missed_kicks};
use crate::math::unsigned_zero::UnsignedZero;
use crate::motion::Driver;
use crate::options::{Model, Options};
use crate::simulate::{Run, Start, Trajectory, simulate_until, solvable};

const EXCITED: &str =
    "the body is kicked or the ground moves: the error of the local model is not known";

/// The motion of `posture` from `state` on, with kicks and a motion of the ground. Up to the first kick the run is, to the last bit, the
/// run without kicks. There is one exception: if the kick falls into bounces that are summed in the run without kicks, these bounces are
/// followed one by one, and the states between them differ by rounding errors. A run that is not stopped earlier by its options lasts at
/// least until the last kick and the last change of the motion of the ground.
///
/// # Errors
///
/// As [`simulate`](super::simulate); a kick or a motion of the ground that is out of range; `certify`.
pub fn simulate_excited(
    posture: &Posture,
    state: &State,
    options: &Options,
    excitation: &Excitation,
) -> Result<Trajectory, Error> {
    simulate_excited_until(posture, state, options, excitation, &|| false)
        .map(|run| run.unwrap_or_else(|| unreachable!("nothing cancels this run")))
}

/// As [`simulate_excited`]. `cancel` is called from time to time; once it returns true, the result is `None`.
///
/// # Errors
///
/// As [`simulate_excited`].
pub fn simulate_excited_until(
    posture: &Posture,
    state: &State,
    options: &Options,
    excitation: &Excitation,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Trajectory>, Error> {
    if excitation.is_none() {
        return simulate_until(posture, state, options, cancel);
    }
    options.validate()?;
    solvable(posture, options)?;
    state.validate()?;
    let gravity = posture.fields().gravity;
    excitation.validate(options.time, gravity)?;
    if options.certify {
        return Err(Error::Unusable {
            field: "certify".into(),
            value: "true".into(),
            allowed: "false, because the run has kicks or a ground_motion".into(),
        });
    }
    let (model, reason) = match options.model {
        Model::Auto => (Model::Full, EXCITED),
        model => (model, "set by the option"),
    };
    let state = &state.unsigned_zero();
    let start = Start::new(posture, state, model)?;
    let changes = excitation.changes(options.time, gravity);
    let mut record = start.run_excited(posture, state, options, &changes, cancel);
    if let Some(record) = &mut record {
        record.warnings.extend(lasting(excitation.ground_motion.as_ref()));
    }
    let run = |record| Run { model, record }.into_trajectory(reason, *options);
    Ok(record.map(|record| run(record).excited_by(excitation.clone())))
}

impl Start {
    fn run_excited(
        self,
        posture: &Posture,
        state: &State,
        options: &Options,
        changes: &[Change],
        cancel: &dyn Fn() -> bool,
    ) -> Option<Box<crate::motion::record::Record>> {
        let local = self.model == Model::Local;
        // The first stage is computed as the run without kicks.
        let first = changes.first().filter(|change| change.elapsed > 0.0);
        if let Some(first) = first.filter(|_| Self::is_pair(posture, options)) {
            let mut pair = self.driver(posture, state, options, cancel);
            if first.elapsed >= options.end() {
                pair.record.warnings.extend(missed_kicks(changes));
                pair.run()?;
                return Some(pair.record);
            }
            let end = match pair.first_stage(first.elapsed)? {
                Ok(end) => end,
                Err(outcome) => {
                    pair.record.warnings.extend(missed_kicks(changes));
                    pair.close(outcome)?;
                    return Some(pair.record);
                }
            };
            let base = pair.record.base.clone();
            let body = Self::body_state(posture, &end.state, &end.gaps, &end.rates, local);
            let driver = Driver::of_any(posture, body, base, options, Vec::new(), cancel);
            let mut driver = driver.after_pair(pair);
            driver.run_stages(changes, options)?;
            return Some(driver.record);
        }
        let mut driver = self.any_driver(posture, state, options, cancel);
        driver.run_stages(changes, options)?;
        Some(driver.record)
    }
}
