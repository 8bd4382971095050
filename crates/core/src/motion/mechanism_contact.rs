//! Contact phases of a mechanism: contacts at rest or sliding. Forces are constant in a word, so that it ends only where a contact lands or
//! stops sliding.

use crate::body::contact::{ContactLetters, ContactValues};
use crate::math::mass_vector::{self, MassVector};
use crate::modes::{MechanismProblem, Mode, Onward, onward};
use crate::motion::driver::{Driver, DriverStep};
use crate::motion::mechanism::Jointed;
use crate::motion::subject::Subject;
use crate::options::Stop;
use crate::outcome::{Cause, ContactNumber, Outcome, ZenoMethod};
use crate::sustained::frozen::{Frozen, ModeEnd};
use crate::tolerance::{BODY_STOPPED, DEPARTED, SLOWER_SLIDE, STILL, TOUCH};

/// The warning of a run in which the contacts rest and other coordinates move on.
const HIDDEN: &str = "the contacts rest, but coordinates that they do not feel move on";

/// Signs of sliding of all contacts; `None`: separate.
type Ways = ContactLetters<Option<i8>>;

impl Driver<'_, Jointed> {
    /// A contact phase from these contacts at rest on.
    pub(super) fn mechanism_phase(
        &mut self,
        mut rests: ContactValues<bool>,
        fresh: bool,
    ) -> DriverStep {
        if rests.iter().zip(&self.resting).all(|(rests, known)| *rests && *known)
            && let Some(word) = self.stands()
        {
            return DriverStep::End(self.stand(word));
        }
        let (count, touch) = (rests.len(), TOUCH * self.body.place());
        for i in 0..count {
            let touches = !rests[i] && self.body.state.points[i].h <= touch;
            rests[i] |= touches && self.body.state.depends(i, &rests);
            if rests[i] {
                (self.body.state.points[i].h, self.body.state.points[i].u) = (0.0, 0.0);
            }
        }
        let word: ContactLetters<Mode> =
            rests.iter().map(|on| if *on { Mode::Right } else { Mode::Separate }).collect();
        self.body.state.project(&word);
        // A contact that lifts off at once has not come to rest.
        let rows = &self.body.state.rows;
        let pressed = rows
            .gaps
            .filter(|_| rows.friction.iter().all(|mu| *mu == 0.0))
            .map(|model| model.pressed([0, 1].map(|i| rests.get(i).is_some_and(|on| *on))));
        let stays = |i: usize| match (pressed, self.body.space().gravity(i)) {
            (Some(pressed), _) => pressed[i],
            (None, 0.0) => !fresh,
            (None, pull) => pull > 0.0,
        };
        let new: Vec<usize> =
            (0..count).filter(|&i| rests[i] && !self.resting[i] && stays(i)).collect();
        if !new.is_empty() {
            let method = if fresh { ZenoMethod::Rest } else { ZenoMethod::Bounce };
            if let Some(outcome) = self.settle(&new, method, true, 0.0) {
                return DriverStep::End(outcome);
            }
        }
        let slide = self.slowest_known_slide(self.body.space().largest_pull());
        let mut ways = self.ways(&rests, slide);
        loop {
            let chosen = match self.choose(&ways) {
                Ok(chosen) => chosen,
                Err(Outcome::Inconsistent) if self.jam() => return self.stop_slow(0.0).into(),
                Err(outcome) => return DriverStep::End(outcome),
            };
            let word = chosen.word.clone();
            for (way, mode) in ways.iter_mut().zip(&word) {
                *way = (*mode != Mode::Separate).then_some(mode.direction() as i8);
            }
            if word.iter().all(|&mode| mode == Mode::Separate) {
                return DriverStep::Flight;
            }
            if self.is_at_rest(&chosen) {
                return DriverStep::End(self.stand(word));
            }
            self.body.state.hold(&word);
            self.enter(&word);
            self.write_modes(word.clone(), chosen.acceleration.clone());
            match self.hold_on(&word, &chosen) {
                Ok(i) => {
                    self.cause = Some(Cause::Stop(ContactNumber::of(i)));
                    self.stopped(i, &word, &mut ways);
                }
                Err(step) => return step,
            }
            if !self.log.step() {
                return DriverStep::End(Outcome::EventLimit);
            }
        }
    }

    fn enter(&mut self, word: &[Mode]) {
        self.log.enter(word);
        self.body.laps.hold(word, self.log.clock);
        for (resting, mode) in self.resting.iter_mut().zip(word) {
            *resting = *mode != Mode::Separate;
        }
    }

    /// The modes in which the mechanism, with all contacts closed, stays at rest: all speeds are rounding errors, and nothing is accelerated.
    /// `None`: more has to be known.
    fn stands(&self) -> Option<ContactLetters<Mode>> {
        let (state, space) = (&self.body.state, self.body.space());
        let rows = &state.rows;
        if !(state.speed() <= Self::still_slide(self)) {
            return None;
        }
        let count = rows.friction.len();
        let still =
            |a: &mass_vector::Coordinates| space.reach() * a.norm() <= STILL * space.largest_pull();
        // Two contacts without friction, both pressed to the ground: no other mode is consistent.
        if let Some(model) = &rows.gaps
            && rows.friction.iter().all(|mu| *mu == 0.0)
        {
            let own = model.solve_coupled(model.g);
            if own[..count].iter().all(|push| *push > 0.0) {
                let mut a = space.pull().clone();
                for (i, push) in own[..count].iter().enumerate() {
                    a.add_scaled(space.normal_row(i), push / space.normal(i, i));
                }
                return still(&a).then(|| ContactLetters::from_elem(Mode::Fixed, count));
            }
        }
        let ways = Ways::from_elem(Some(0), count);
        let mut found = onward(space, &rows.friction, &ways).ok()?;
        let one = found.pop().filter(|one| found.is_empty() && !one.undetermined)?;
        still(&one.acceleration).then_some(one.word)
    }

    /// Rests in these modes.
    fn stand(&mut self, mut word: ContactLetters<Mode>) -> Outcome {
        let Frozen { rows, v, points, .. } = &mut self.body.state;
        v.clear();
        points.iter_mut().for_each(|p| p.u = 0.0);
        for (mode, mu) in word.iter_mut().zip(&rows.friction) {
            if *mode != Mode::Separate && *mu == 0.0 {
                *mode = Mode::Fixed; // forces do not change
            }
        }
        let still = mass_vector::Coordinates::zeros(v.len());
        self.enter(&word);
        self.write_modes(word, still);
        self.stay()
    }

    /// The signs of sliding of these closed contacts: 0 where the speed counts as zero. `tolerance`: this speed, in m/s.
    fn ways(&mut self, closed: &[bool], tolerance: f64) -> Ways {
        let state = &self.body.state;
        let limit = |i: usize| if state.rows.friction[i] > 0.0 { tolerance } else { 0.0 };
        let slips: ContactValues<f64> = (0..closed.len()).map(|i| state.slip(i)).collect();
        let on = || (0..closed.len()).filter(|&i| closed[i]);
        let fastest = on().map(|i| slips[i].abs()).fold(0.0, f64::max);
        let most = on().map(limit).fold(0.0, f64::max);
        let together = state.leaves_one_motion(closed);
        let none = |i: usize| match together {
            true if fastest > most => slips[i].abs() <= SLOWER_SLIDE * fastest,
            true => true,
            false => slips[i].abs() <= limit(i),
        };
        let sign = |slip: f64| i8::from(slip > 0.0) - i8::from(slip < 0.0);
        let ways = (0..closed.len())
            .map(|i| closed[i].then(|| if none(i) { 0 } else { sign(slips[i]) }))
            .collect();
        let dropped = on().filter(|&i| none(i)).map(|i| slips[i].abs()).fold(0.0, f64::max);
        self.body.laps.drop(dropped);
        ways
    }

    /// The only word in which the motion continues; an error: the outcome if there is none or more than one.
    fn choose(&mut self, ways: &[Option<i8>]) -> Result<Onward, Outcome> {
        let rows = &self.body.state.rows;
        let mut found = match onward(&rows.space, &rows.friction, ways) {
            Ok(found) => found,
            Err(error) => {
                let warning = format!("the contact modes could not be solved: {error}");
                self.record.warnings.push(warning);
                return Err(Outcome::EventLimit);
            }
        };
        let none = found.is_empty();
        match found.pop() {
            Some(one) if found.is_empty() && !one.undetermined => Ok(one),
            _ => {
                match &self.record.subject {
                    Subject::Body(body) => {
                        let problem = body.problem(self.body.space().pull(), ways);
                        self.record.undecided = problem.ok().map(Box::new);
                    }
                    Subject::Mechanism(start) => {
                        let problem = MechanismProblem::new(&start.mechanism, ways);
                        self.record.undecided_mechanism = problem.ok().map(Box::new);
                    }
                    Subject::Local(_) => {}
                }
                Err(if none { Outcome::Inconsistent } else { Outcome::Ambiguous })
            }
        }
    }

    /// Whether nothing moves that the contacts feel: a fixed word leaves no motion, or all speeds and accelerations are rounding error.
    fn is_at_rest(&self, chosen: &Onward) -> bool {
        let (space, state) = (self.body.space(), &self.body.state);
        let fixed = state.is_fixed(&chosen.word);
        let slow = state.speed() <= Self::still_slide(self);
        fixed || slow && space.reach() * chosen.acceleration.norm() <= STILL * space.largest_pull()
    }

    /// Stays with all contacts at rest. The hidden motion, if it is accelerated, carries the mechanism away; if not, its speed stays.
    fn stay(&mut self) -> Outcome {
        let space = self.body.space();
        let falls = space.hidden().amax() > 0.0;
        let start = self.record.subject.mechanism();
        let drift = start.map_or(0.0, |start| space.reach() * start.hidden_velocity.norm());
        let drifts = drift > Self::still_slide(self);
        if (falls || drifts) && !self.record.warnings.iter().any(|warning| warning == HIDDEN) {
            self.record.warnings.push(HIDDEN.into());
        }
        if self.options.stop == Stop::Time {
            self.log.clock = self.log.clock.after(self.log.left().max(0.0));
            return Outcome::TimeLimit;
        }
        match (falls, drifts) {
            (true, _) => Outcome::Escape,
            (false, true) => {
                let still = mass_vector::Coordinates::zeros(space.pull().len());
                self.record.acceleration = self.acceleration(&still);
                Outcome::Sliding
            }
            (false, false) => Outcome::Rest,
        }
    }

    /// q̈ of all coordinates, from ÿ; a model without a body has none.
    fn acceleration(&self, y: &mass_vector::Coordinates) -> Option<Vec<f64>> {
        let dof = match &self.record.subject {
            Subject::Body(_) => 3,
            Subject::Mechanism(start) => start.mechanism.dof(),
            Subject::Local(_) => return None,
        };
        Some(self.body.space().acceleration(dof, y))
    }

    /// Holds the contacts in these modes: up to the contact that stops sliding, or to another end of the phase.
    fn hold_on(&mut self, word: &[Mode], chosen: &Onward) -> Result<usize, DriverStep> {
        let (state, a) = (&self.body.state, &chosen.acceleration);
        let (space, (t, end)) = (state.space(), state.first_event(word, a));
        let way = t * (state.speed() + t * space.reach() * a.norm());
        let left = self.log.left();
        let endless = t == f64::INFINITY || way > DEPARTED;
        if endless && left == f64::INFINITY {
            let closed = word.iter().all(|&mode| mode != Mode::Separate);
            self.record.acceleration = self.acceleration(a);
            return Err(DriverStep::End(if closed { Outcome::Sliding } else { Outcome::Escape }));
        }
        if endless || t > left {
            self.body.state = state.after(word, a, left.max(0.0));
            self.log.clock = self.log.clock.after(left.max(0.0));
            return Err(DriverStep::End(Outcome::TimeLimit));
        }
        self.body.state = state.after(word, a, t);
        self.log.clock = self.log.clock.after(t);
        match end {
            ModeEnd::Landing(i) => {
                let p = &mut self.body.state.points[i];
                (p.h, p.u) = (0.0, p.u.min(0.0));
                Err(self.land_again(i))
            }
            ModeEnd::Stop(i) => Ok(i),
            ModeEnd::Never => Err(DriverStep::Piece),
        }
    }

    /// The sliding speed of contact `i` has decreased to zero: all motion has, or all slides, or those of this contact and of all others whose
    /// sliding speed now counts as zero. Contacts with one tangential row stop at one instant, which has a rounding error.
    fn stopped(&mut self, i: usize, word: &[Mode], ways: &mut Ways) {
        let closed: ContactValues<bool> = word.iter().map(|mode| *mode != Mode::Separate).collect();
        let count = closed.iter().filter(|on| **on).count();
        let still = Self::still_slide(self);
        let slow = self.body.state.speed() <= still * BODY_STOPPED;
        if count > 1 && slow {
            self.body.state.v.clear();
        }
        let all = count == 1 || slow || self.body.state.leaves_one_motion(&closed);
        for (j, way) in ways.iter_mut().enumerate() {
            if all || j == i || self.body.state.slip(j).abs() <= still {
                *way = way.map(|_| 0);
            }
        }
    }
}
