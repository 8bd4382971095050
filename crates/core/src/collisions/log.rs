//! The log of a run: clock, collisions, and limits of time and of events.

use nalgebra::Vector2;

use crate::body::contact::ContactLetters;
use crate::flight::parabola_touchdown;
use crate::math::clock::Clock;
use crate::modes::Mode;
use crate::options::Options;
use crate::tolerance::CHANGED_SPEED;
use crate::zeno::{Gaps, Impulses};

/// One simulated collision.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Collision {
    pub(crate) elapsed: Clock,
    pub(crate) contact: usize,
    pub(crate) before: [f64; 2],
    pub(crate) after: [f64; 2],
    /// Own-rate jump (1+e)|w| of the impact, in m/s: the change of the gap rate of the contact that is hit. w is this rate before the
    /// impact.
    pub(crate) jump: f64,
    /// Gap of the contact that is not hit, in m.
    pub(crate) other_gap: f64,
}

impl Collision {
    /// The own-rate jumps, and the gaps and rates after it.
    pub(crate) fn effects(&self) -> (Impulses, Gaps) {
        let (i, mut own) = (self.contact, Impulses::default());
        let mut gaps = Gaps { u: self.after, ..Gaps::default() };
        (own.jump[i], gaps.h[1 - i]) = (self.jump, self.other_gap);
        (own, gaps)
    }
}

/// Rotation right after a collision of the full model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Spin {
    pub(crate) theta: f64,
    pub(crate) omega: f64,
}

/// The centre of mass: its displacement (m) and velocity (m/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Center {
    pub(crate) r: Vector2<f64>,
    pub(crate) v: Vector2<f64>,
}

impl Default for Center {
    fn default() -> Self {
        Self { r: Vector2::zeros(), v: Vector2::zeros() }
    }
}

impl Center {
    /// Moves by a flight of `dt` under gravity `g`.
    #[inline]
    pub(crate) fn fly(&mut self, g: f64, dt: f64) {
        self.r += self.v * dt;
        self.r.y -= 0.5 * g * dt * dt;
        self.v.y -= g * dt;
    }

    /// Moves by a flight of `dt` with the acceleration of free fall `fall`.
    pub(crate) fn fall(&mut self, fall: Vector2<f64>, dt: f64) {
        self.r += self.v * dt;
        self.r += fall * 0.5 * dt * dt;
        self.v += fall * dt;
    }
}

/// Collisions between two checks of the limits and of the cancel flag.
pub(crate) const CHUNK: usize = 1024;

/// Largest number of steps that a run may make in excess of its events. Steps are steps of integration and of the loop over pieces of a
/// motion; events are collisions and changes of modes. So many steps take a second of computing time, and a quarter of a gigabyte if
/// recorded. A body that swings or rolls takes some ten steps per turn, a slender body some hundred.
pub(crate) const MOST_STEPS: usize = 250_000;

/// Clock, collisions and limits of one run.
pub(crate) struct Log<'a> {
    pub(crate) clock: Clock,
    pub(crate) collisions: Vec<Collision>,
    /// Centre of mass and rotation after each collision of a body that turns; empty for constant rows. They are recorded, because a replay that sums the impulses again would have other rounding errors.
    pub(crate) bodies: Vec<(Center, Spin)>,
    pub(crate) record: bool,
    /// Elapsed time at which the run ends, in s.
    pub(crate) end: f64,
    /// Collisions so far.
    pub(crate) hits: usize,
    /// Whether each contact of a pair has been hit.
    pub(crate) struck: [bool; 2],
    /// Changes of the contact modes so far.
    changes: usize,
    /// The current contact-mode word; empty before the first piece.
    pub(crate) word: ContactLetters<Mode>,
    /// Number of events at the last step, and number of steps since the last new event.
    seen: usize,
    steps: usize,
    /// Steps since the last check of the cancel flag.
    unasked: usize,
    pub(crate) event_limit: usize,
    pub(crate) cancelled: bool,
    /// Whether a flight was so long that rounding makes the position of the body unknown.
    pub(crate) phase_lost: bool,
    cancel: &'a dyn Fn() -> bool,
}

impl<'a> Log<'a> {
    /// The empty log of a body with `count` contacts.
    pub(crate) fn new(options: &Options, count: usize, cancel: &'a dyn Fn() -> bool) -> Self {
        Self {
            clock: Clock::default(),
            collisions: Vec::new(),
            bodies: Vec::new(),
            record: options.record,
            end: options.end(),
            hits: 0,
            struck: [false; 2],
            changes: 0,
            word: ContactLetters::new(),
            seen: 0,
            steps: 0,
            unasked: 0,
            event_limit: options.events(count),
            cancelled: false,
            phase_lost: false,
            cancel,
        }
    }

    /// Number of collisions before the next check of the limits; zero: the run is over.
    pub(crate) fn chunk(&mut self) -> usize {
        self.cancelled = self.cancelled || (self.cancel)();
        if self.cancelled { 0 } else { CHUNK.min(self.event_limit.saturating_sub(self.events())) }
    }

    /// Number of collisions and of changes of the contact modes so far.
    pub(crate) fn events(&self) -> usize {
        self.hits + self.changes
    }

    /// Sets the contact-mode word. If it differs from the last word, counts a change.
    pub(crate) fn enter(&mut self, word: &[Mode]) {
        if self.word.as_slice() != word {
            self.changes += usize::from(!self.word.is_empty());
            self.word = word.into();
        }
    }

    /// Counts a step, of integration or of the loop over the pieces of a motion. Returns whether the run may take it.
    pub(crate) fn step(&mut self) -> bool {
        let events = self.events();
        self.steps += usize::from(events == self.seen);
        self.seen = events;
        if events >= self.event_limit || self.steps >= MOST_STEPS + events {
            return false;
        }
        self.unasked += 1;
        if self.unasked == CHUNK {
            self.unasked = 0;
            self.cancelled = self.cancelled || (self.cancel)();
        }
        !self.cancelled
    }

    /// The limit that has ended the run, in words; `None` if neither the limit of events nor that of steps was reached.
    pub(crate) fn limit(&self) -> Option<String> {
        let steps = if self.events() >= self.event_limit {
            String::new()
        } else if self.steps >= MOST_STEPS + self.events() {
            format!("{} steps of integration and ", self.steps)
        } else {
            return None;
        };
        Some(format!(
            "ended after {steps}{}, {} and {} of the contact modes",
            counted(self.events(), "event"),
            counted(self.hits, "collision"),
            counted(self.changes, "change")
        ))
    }

    /// Time left before the limit, in s.
    pub(crate) fn left(&self) -> f64 {
        self.clock.until(self.end)
    }
}

/// Number of impacts in a block. The fastest impacts of two successive blocks are compared to see whether speeds decrease.
const STRETCH: usize = 1024;

/// A block of impacts: the highest speed in m/s, the time of the first impact, the contacts hit (one bit each).
#[derive(Debug, Clone, Copy, Default)]
struct Stretch {
    impacts: usize,
    fastest: f64,
    began: Clock,
    contacts: u128,
}

/// The last impacts of a run; they show why the run does not end.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LastImpacts {
    now: Stretch,
    before: Stretch,
    /// Changes of the contact modes before the last impact.
    changes: usize,
}

impl LastImpacts {
    /// Adds an impact of a contact (counted from 0) with this speed.
    pub(crate) fn follow(&mut self, contact: usize, speed: f64, log: &Log<'_>) {
        self.changes = log.changes;
        if self.now.impacts == STRETCH {
            (self.before, self.now) = (self.now, Stretch::default());
        }
        if self.now.impacts == 0 {
            self.now.began = log.clock;
        }
        self.now.impacts += 1;
        self.now.fastest = self.now.fastest.max(speed);
        self.now.contacts |= 1 << contact.min(127);
    }

    /// What the impacts before the end of a run have in common, in words.
    pub(crate) fn family(&self, log: &Log<'_>) -> String {
        let quiet = log.changes - self.changes;
        if quiet > STRETCH {
            return format!(
                "contacts stick, slip and lift off without an impact within the last {quiet} changes"
            );
        }
        let clock = log.clock;
        let (now, before) = (&self.now, &self.before);
        let hit = now.contacts | before.contacts;
        let contacts = names((0..128).filter(|i| hit >> i & 1 == 1));
        let count = before.impacts + now.impacts;
        let (speed, earlier) = (in_words(now.fastest), in_words(before.fastest));
        let ratio = now.fastest / before.fastest;
        if count == 0 {
            "without an impact".into()
        } else if before.impacts == 0 {
            format!("impacts of {contacts} at up to {speed}")
        } else if clock.since(before.began) == 0.0 {
            format!(
                "the last {count} impacts, of {contacts} at up to {speed}, happen at one instant: each causes the next one"
            )
        } else if ratio * CHANGED_SPEED < 1.0 {
            format!(
                "the impacts of {contacts} become slower, but slowly: from {earlier} to {speed} within the last {count}"
            )
        } else if ratio > CHANGED_SPEED {
            format!(
                "the impacts of {contacts} become faster: from {earlier} to {speed} within the last {count}"
            )
        } else {
            format!(
                "the impacts of {contacts}, at up to {speed}, become neither slower nor faster within the last {count}"
            )
        }
    }
}

/// "1 event", "2 events".
fn counted(number: usize, name: &str) -> String {
    format!("{number} {name}{}", if number == 1 { "" } else { "s" })
}

/// A speed (m/s) with three digits.
pub(crate) fn in_words(speed: f64) -> String {
    if (1e-3..1e4).contains(&speed) {
        let digits = (2.0 - libm::log10(speed).floor()).clamp(0.0, 5.0) as usize;
        format!("{speed:.digits$} m/s")
    } else {
        format!("{speed:.2e} m/s")
    }
}

/// "contact 1", "contacts 1 and 2", "contacts 1, 2 and 4", of contacts counted from 0.
pub(crate) fn names(contacts: impl Iterator<Item = usize>) -> String {
    let all: Vec<String> = contacts.map(|i| (i + 1).to_string()).collect();
    match all.as_slice() {
        [] => "no contact".into(),
        [one] => format!("contact {one}"),
        [most @ .., last] => format!("contacts {} and {last}", most.join(", ")),
    }
}

/// The contacts on the ground, or the next landing and its speed, in words, with this gravity into each of `count` contacts.
pub(crate) fn next_landing(count: usize, gaps: &Gaps, gravity: [f64; 2]) -> String {
    let stays = |&i: &usize| gaps.h[i] == 0.0 && gaps.u[i] == 0.0;
    if (0..count).any(|i| stays(&i)) {
        return format!("with {} on the ground", names((0..count).filter(stays)));
    }
    let after = |i: usize| {
        if i < count { parabola_touchdown(gaps.h[i], gaps.u[i], gravity[i]) } else { f64::INFINITY }
    };
    let first = usize::from(after(1) < after(0));
    if !after(first).is_finite() {
        return "no contact lands any more".into();
    }
    let (h, u) = (gaps.h[first], gaps.u[first]);
    let speed = (u * u + 2.0 * gravity[first] * h).max(0.0).sqrt();
    format!("{} lands next, at about {}", names(std::iter::once(first)), in_words(speed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_of_the_modes_is_an_event_and_their_first_choice_is_none() {
        let mut log = Log::new(&Options::default(), 2, &|| false);
        let (s, f) = (Mode::Separate, Mode::Fixed);
        let events = [[s, s], [s, s], [s, f], [s, f], [f, f], [s, f]].map(|word| {
            log.enter(&word);
            log.events()
        });
        assert_eq!(events, [0, 0, 1, 1, 2, 3]);
    }

    #[test]
    fn the_trend_of_the_last_impacts_follows_from_their_speeds() {
        for (ratio, dt, words) in [
            (0.999, 1.0, "contacts 1 and 2 become slower"),
            (1.001, 1.0, "contacts 1 and 2 become faster"),
            (1.0, 1.0, "neither slower nor faster"),
            (0.999, 0.0, "happen at one instant"),
        ] {
            let mut log = Log::new(&Options::default(), 2, &|| false);
            let mut last = LastImpacts::default();
            for k in 0..3000 {
                log.clock = log.clock.after(dt);
                last.follow(k % 2, libm::pow(ratio, k as f64), &log);
            }
            assert!(last.family(&log).contains(words), "{}", last.family(&log));
        }
    }
}
