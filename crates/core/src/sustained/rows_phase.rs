//! Contacts at rest or sliding, with constant rows. Forces are constant in a word, so that it ends only where a contact lands or stops sliding.

use crate::body::contact::{ContactLetters, ContactValues};
use crate::collisions::log::Log;
use crate::math::clock::Clock;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::modes::{Mode, Onward, onward};
use crate::outcome::{Cause, ContactNumber, Outcome};
use crate::sustained::frozen::{Frozen, ModeEnd};
use crate::sustained::phase::PhaseEnd;
use crate::sustained::still_speed;
use crate::tolerance::{BODY_STOPPED, DEPARTED, DEPENDENT_ROW, SLOWER_SLIDE, STILL};

/// Signs of sliding of all contacts; `None`: separate.
type Ways = ContactLetters<Option<i8>>;

/// A function that records the motion: the state at the start of a word, the word, the acceleration, the time and the cause.
pub(crate) type NoteRows<'n> = dyn FnMut(&Frozen, &[Mode], &Coordinates, Clock, Option<Cause>) + 'n;

pub(crate) struct RowsPhase {
    pub(crate) state: Frozen,
    ways: Ways,
    /// Sliding speed that counts as zero at the start, in m/s.
    slide: f64,
    /// The largest speed so far, in m/s.
    fastest: f64,
    /// The largest sliding speed that counted as zero, in m/s.
    pub(crate) dropped: f64,
    pub(crate) word: ContactLetters<Mode>,
    /// The signs of sliding without a consistent word, or with several.
    pub(crate) undecided: Option<Ways>,
    /// ÿ of an endless motion.
    pub(crate) acceleration: Option<Coordinates>,
    pub(crate) warnings: Vec<String>,
    /// The cause of this word.
    pub(crate) cause: Option<Cause>,
}

impl RowsPhase {
    /// Without closed contacts. `slide`: the sliding speed that counts as zero at the start; `fastest`: the largest speed so far; in m/s.
    pub(crate) fn new(state: Frozen, slide: f64, fastest: f64, cause: Option<Cause>) -> Self {
        Self {
            state,
            ways: Ways::new(),
            slide,
            fastest,
            dropped: 0.0,
            word: ContactLetters::new(),
            undecided: None,
            acceleration: None,
            warnings: Vec::new(),
            cause,
        }
    }

    /// Sliding speed that counts as zero at this time, in m/s.
    fn still(&self, clock: Clock) -> f64 {
        still_speed(self.fastest, self.state.space().largest_pull(), clock)
    }

    /// Closes the contacts at rest, with those nearer to their ground than `touch` (m) whose gaps follow from these, and sets the signs of their
    /// sliding: 0 where the speed counts as zero.
    pub(crate) fn close(&mut self, rests: &mut [bool], touch: f64) {
        let state = &mut self.state;
        for i in 0..rests.len() {
            let touches = !rests[i] && state.points[i].h <= touch;
            rests[i] |= touches && state.depends(i, rests);
            if rests[i] {
                (state.points[i].h, state.points[i].u) = (0.0, 0.0);
            }
        }
        let mode = |on: &bool| if *on { Mode::Right } else { Mode::Separate };
        state.project(&rests.iter().map(mode).collect::<ContactLetters<_>>());
        let limit = |i: usize| if state.rows.friction[i] > 0.0 { self.slide } else { 0.0 };
        let slips: ContactValues<f64> = (0..rests.len()).map(|i| state.slip(i)).collect();
        let on = || (0..rests.len()).filter(|&i| rests[i]);
        let fastest = on().map(|i| slips[i].abs()).fold(0.0, f64::max);
        let most = on().map(limit).fold(0.0, f64::max);
        let together = state.leaves_one_motion(rests);
        let none = |i: usize| match together {
            true if fastest > most => slips[i].abs() <= SLOWER_SLIDE * fastest,
            true => true,
            false => slips[i].abs() <= limit(i),
        };
        let sign = |slip: f64| i8::from(slip > 0.0) - i8::from(slip < 0.0);
        self.ways = (0..rests.len())
            .map(|i| rests[i].then(|| if none(i) { 0 } else { sign(slips[i]) }))
            .collect();
        self.dropped = on().filter(|&i| none(i)).map(|i| slips[i].abs()).fold(0.0, f64::max);
    }

    /// Simulates word after word until the phase ends. `note` is called at the start of every word.
    pub(crate) fn run(&mut self, log: &mut Log<'_>, note: &mut NoteRows<'_>) -> PhaseEnd {
        loop {
            let mut chosen = match self.choose() {
                Ok(chosen) => chosen,
                Err(outcome) => return PhaseEnd::Outcome(outcome),
            };
            for (way, mode) in self.ways.iter_mut().zip(&chosen.word) {
                *way = (*mode != Mode::Separate).then_some(mode.direction() as i8);
            }
            self.word.clone_from(&chosen.word);
            if self.word.iter().all(|&mode| mode == Mode::Separate) {
                return PhaseEnd::Free;
            }
            self.state.rows.project(&chosen.word, DEPENDENT_ROW, &mut chosen.acceleration);
            if self.is_at_rest(&chosen, self.still(log.clock)) {
                return PhaseEnd::Stands;
            }
            self.state.hold(&self.word);
            log.enter(&self.word);
            note(&self.state, &self.word, &chosen.acceleration, log.clock, self.cause);
            match self.hold_on(&chosen.acceleration, log) {
                Ok(i) => {
                    self.cause = Some(Cause::Stop(ContactNumber::of(i)));
                    self.stopped(i, self.still(log.clock));
                }
                Err(end) => return end,
            }
            if !log.step() {
                return PhaseEnd::Outcome(Outcome::EventLimit);
            }
        }
    }

    /// The only word in which the motion continues; an error: the outcome if there is none or more than one.
    fn choose(&mut self) -> Result<Onward, Outcome> {
        let rows = &self.state.rows;
        let mut found = onward(&rows.space, &rows.friction, &self.ways).map_err(|error| {
            self.warnings.push(format!("the contact modes could not be solved: {error}"));
            Outcome::EventLimit
        })?;
        let none = found.is_empty();
        match found.pop() {
            Some(one) if found.is_empty() && !one.undetermined => Ok(one),
            _ => {
                self.undecided = Some(self.ways.clone());
                Err(if none { Outcome::Inconsistent } else { Outcome::Ambiguous })
            }
        }
    }

    /// Returns true if nothing moves that the contacts feel: a fixed word leaves no motion, or all speeds and accelerations are rounding
    /// error.
    fn is_at_rest(&self, chosen: &Onward, still: f64) -> bool {
        let (space, state) = (self.state.space(), &self.state);
        let slow = state.speed() <= still;
        state.is_fixed(&chosen.word)
            || slow && space.reach() * chosen.acceleration.norm() <= STILL * space.largest_pull()
    }

    /// Holds the contacts in their word with this acceleration: up to the contact that stops sliding, or to another end of the phase.
    fn hold_on(&mut self, a: &Coordinates, log: &mut Log<'_>) -> Result<usize, PhaseEnd> {
        let (state, word) = (&mut self.state, &self.word);
        let (speed, push) = (state.speed(), state.space().reach() * a.norm());
        // Events farther away than `DEPARTED` are never reached.
        let next = state.first_event(word, a).filter(|(t, _)| t * (speed + t * push) <= DEPARTED);
        let left = log.left();
        let (t, end) = match next {
            Some((t, end)) if t <= left => (t, Some(end)),
            None if left == f64::INFINITY => {
                let closed = word.iter().all(|&mode| mode != Mode::Separate);
                self.acceleration = Some(a.clone());
                let outcome = if closed { Outcome::Sliding } else { Outcome::Escape };
                return Err(PhaseEnd::Outcome(outcome));
            }
            _ => (left.max(0.0), None),
        };
        *state = state.after(word, a, t);
        log.clock = log.clock.after(t);
        match end {
            Some(ModeEnd::Stop(i)) => Ok(i),
            Some(ModeEnd::Landing(i)) => {
                let p = &mut state.points[i];
                (p.h, p.u) = (0.0, p.u.min(0.0));
                Err(PhaseEnd::Landing(i))
            }
            None => Err(PhaseEnd::Outcome(Outcome::TimeLimit)),
        }
    }

    /// The sliding speed of contact `i` has decreased to zero: all motion has, or all slides, or those of this contact and of all others whose
    /// sliding speed now counts as zero. Contacts with one tangential row stop at one instant, which has a rounding error.
    fn stopped(&mut self, i: usize, still: f64) {
        let closed: ContactValues<bool> =
            self.word.iter().map(|mode| *mode != Mode::Separate).collect();
        let count = closed.iter().filter(|on| **on).count();
        let slow = self.state.speed() <= still * BODY_STOPPED;
        if count > 1 && slow {
            self.state.v.clear();
        }
        let all = count == 1 || slow || self.state.leaves_one_motion(&closed);
        for (j, way) in self.ways.iter_mut().enumerate() {
            if all || j == i || self.state.slip(j).abs() <= still {
                *way = way.map(|_| 0);
            }
        }
    }
}
