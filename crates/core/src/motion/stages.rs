//! Runs in stages: something acts on the body, or the ground changes its motion, and the run continues.

use nalgebra::Vector2;

use crate::excitation::{Change, Kick, missed_kicks};
use crate::motion::any::AnyContacts;
use crate::motion::driver::{Coordinates, Driver};
use crate::motion::mechanism::Jointed;
use crate::options::{Options, Stop};
use crate::outcome::{Cause, Outcome};

impl<'a, C: Coordinates> Driver<'a, C> {
    /// Moves up to the time `end` (s since the start), through states of rest, or to an earlier outcome; `None` if cancelled.
    fn stage(&mut self, end: f64) -> Option<Outcome> {
        if self.options.stop == Stop::Rest {
            self.options.stop = Stop::Time;
        }
        self.log.end = end;
        let outcome = self.motion();
        if self.log.cancelled {
            return None;
        }
        if outcome == Outcome::TimeLimit {
            self.log.clock.hi = end;
            self.log.clock.lo = 0.0;
        }
        Some(outcome)
    }
}

impl<C: Staged> Driver<'_, C> {
    /// Runs through all changes to the outcome; `None` if cancelled. `options`: of the whole run.
    pub(crate) fn run_stages(&mut self, changes: &[Change], options: &Options) -> Option<()> {
        if let Some(outcome) = C::begin(self) {
            self.record.warnings.extend(missed_kicks(changes));
            return self.close(outcome);
        }
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
}

/// Coordinates on which something acts during the run.
pub(crate) trait Staged: Coordinates {
    /// Sets the acceleration of free fall, in m/s².
    fn set_fall(driver: &mut Driver<'_, Self>, fall: Vector2<f64>);

    /// The impacts whose recorded time is `end` (s since the start). An outcome: the run ends here.
    fn impacts_at(driver: &mut Driver<'_, Self>, end: f64) -> Option<Outcome>;

    /// A kick with this arm of its point in the nominal posture, in m, on a body of this mass (kg) and radius of gyration (m).
    fn kick(driver: &mut Driver<'_, Self>, kick: &Kick, arm: Vector2<f64>, body: [f64; 2]);

    /// Begins a span of the record, after all changes of an instant.
    fn go_on(driver: &mut Driver<'_, Self>);
}

impl Staged for AnyContacts {
    fn set_fall(driver: &mut Driver<'_, Self>, fall: Vector2<f64>) {
        driver.body.state.set_fall(fall);
    }

    fn impacts_at(driver: &mut Driver<'_, Self>, end: f64) -> Option<Outcome> {
        driver.impacts_at(end)
    }

    fn kick(driver: &mut Driver<'_, Self>, kick: &Kick, arm: Vector2<f64>, [mass, _]: [f64; 2]) {
        driver.body.state.kick(kick, arm, mass);
    }

    fn go_on(driver: &mut Driver<'_, Self>) {
        driver.write_flight();
    }
}

impl Staged for Jointed {
    fn set_fall(driver: &mut Driver<'_, Self>, fall: Vector2<f64>) {
        driver.body.state.set_fall(fall);
    }

    fn impacts_at(driver: &mut Driver<'_, Self>, end: f64) -> Option<Outcome> {
        driver.impacts_at(end)
    }

    fn kick(driver: &mut Driver<'_, Self>, kick: &Kick, arm: Vector2<f64>, [mass, rho]: [f64; 2]) {
        driver.body.state.kick(kick, arm, mass, rho);
    }

    fn go_on(driver: &mut Driver<'_, Self>) {
        // The cycle in progress is no image of the one before.
        driver.body.laps.forget();
        driver.write_flight();
    }
}

impl<C: Staged> Driver<'_, C> {
    /// Applies the changes at this time in the order: acceleration of the ground, which changes no velocity; impacts; kicks. An outcome: the
    /// run ends here.
    fn change(&mut self, change: &Change) -> Option<Outcome> {
        if let Some(fall) = change.fall {
            C::set_fall(self, fall);
        }
        if let Some(outcome) = C::impacts_at(self, change.elapsed) {
            return Some(outcome);
        }
        if change.fall.is_some() {
            self.cause = Some(Cause::GroundMotion);
        }
        if let Some(posture) = self.record.subject.posture().cloned() {
            let f = posture.fields();
            for kick in &change.kicks {
                let point = kick.point.unwrap_or(f.center_of_mass);
                let arm = Vector2::from(point) - Vector2::from(f.center_of_mass);
                C::kick(self, kick, arm, [f.mass, f.gyration_radius]);
                self.cause = Some(Cause::Kick);
            }
        }
        for i in 0..self.body.count() {
            self.resting[i] &= self.body.point(i) == (0.0, 0.0);
        }
        // A span of its own, so that its cause is recorded also where an impact follows at once.
        C::go_on(self);
        None
    }
}
