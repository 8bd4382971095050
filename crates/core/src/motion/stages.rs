//! Runs in stages: something acts on the body, or the ground changes its motion, and the run continues.

use nalgebra::Vector2;

use crate::error::Error;
use crate::excitation::{Change, NewLoad, missed_kicks};
use crate::math::clock::Clock;
use crate::motion::driver::Driver;
use crate::motion::moving::Moving;
use crate::options::{Options, Stop};
use crate::outcome::{Cause, Outcome};

impl Driver<'_> {
    /// Runs through all changes to the outcome. `options`: of the whole run.
    pub(crate) fn run_stages(
        &mut self,
        changes: &[Change],
        options: &Options,
    ) -> Result<(), Error> {
        self.begin();
        for (k, change) in changes.iter().enumerate() {
            if change.elapsed >= options.end() {
                self.record.warnings.extend(missed_kicks(&changes[k..]));
                break;
            }
            if change.elapsed > self.log.clock.hi {
                let outcome = self.stage(change.elapsed)?;
                if outcome != Outcome::TimeLimit {
                    self.record.warnings.extend(missed_kicks(&changes[k..]));
                    return self.close(outcome);
                }
            }
            if let Some(outcome) = self.change(change) {
                self.record.warnings.extend(missed_kicks(&changes[k..]));
                return self.close(outcome);
            }
        }
        (self.options.stop, self.log.end) = (options.stop, options.end());
        self.run_on()
    }

    /// Moves up to the time `end` (s since the start), through states of rest, or to an earlier outcome.
    fn stage(&mut self, end: f64) -> Result<Outcome, Error> {
        if self.options.stop == Stop::Rest {
            self.options.stop = Stop::Time;
        }
        self.log.end = end;
        let outcome = self.motion();
        if self.log.cancelled {
            return Err(Error::Cancelled);
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock = Clock { hi: end, lo: 0.0 };
        }
        Ok(outcome)
    }

    /// Applies the changes at this time in the order: acceleration of the ground, which changes no velocity; impacts; kicks. An outcome: the
    /// run ends here.
    fn change(&mut self, change: &Change) -> Option<Outcome> {
        match (&change.load, &mut self.state) {
            (Some(NewLoad::Fall([fall, rate])), Moving::Turning(body)) => {
                body.set_fall(*fall, *rate);
            }
            // Of a body of unit mass.
            (Some(NewLoad::Fall([fall, _])), Moving::Frozen(rows)) => {
                rows.set_load(&[fall.x, fall.y, 0.0]);
            }
            (Some(NewLoad::Load(load)), Moving::Frozen(rows)) => rows.set_load(load),
            _ => {}
        }
        if let Some(outcome) = self.impacts_at(change.elapsed) {
            return Some(outcome);
        }
        if change.load.is_some() {
            self.cause = Some(Cause::GroundMotion);
        }
        if let Some(posture) = self.record.subject.posture().cloned() {
            let f = posture.fields();
            for kick in &change.kicks {
                let point = kick.point.unwrap_or(f.center_of_mass);
                let arm = Vector2::from(point) - Vector2::from(f.center_of_mass);
                match &mut self.state {
                    Moving::Turning(body) => body.kick(kick, arm, f.mass),
                    Moving::Frozen(rows) => {
                        let impulse = Vector2::from(kick.impulse) / f.mass;
                        rows.kick(&[impulse.x, impulse.y, arm.perp(&impulse)]);
                    }
                }
                self.cause = Some(Cause::Kick);
            }
        }
        if let Moving::Frozen(rows) = &mut self.state {
            for (_, impulse) in &change.impulses {
                rows.kick(impulse);
                self.cause = Some(Cause::Kick);
            }
        }
        for (resting, point) in self.resting.iter_mut().zip(self.state.points()) {
            *resting &= point == (0.0, 0.0);
        }
        // The cycle in progress is no image of the one before.
        self.cycles.forget();
        // A span of its own, so that its cause is recorded also where an impact follows at once.
        self.write_flight();
        None
    }
}
