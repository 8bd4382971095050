//! What a run writes down while it goes: the clock, the collisions, and the limits it must keep.

use nalgebra::Vector2;

use crate::clock::Clock;
use crate::simulate::Options;

/// One collision, as it was simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Collision {
    pub(crate) elapsed: Clock,
    pub(crate) contact: usize,
    pub(crate) before: [f64; 2],
    pub(crate) after: [f64; 2],
    /// Own-rate jump (1+e)|w| of the impact, in m/s.
    pub(crate) jump: f64,
    /// Gap of the contact that is not hit, in m.
    pub(crate) other_gap: f64,
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
    /// After a flight of `dt` under gravity `g`.
    #[inline]
    pub(crate) fn fly(&mut self, g: f64, dt: f64) {
        self.r += self.v * dt;
        self.r.y -= 0.5 * g * dt * dt;
        self.v.y -= g * dt;
    }
}

/// Collisions between two looks at the limits and at the cancel flag.
pub(crate) const CHUNK: usize = 1024;

/// Events that one step of a held contact counts for: it takes about as long as so many collisions.
const STEP: usize = 20;

/// Clock, collisions and limits of one run.
pub(crate) struct Log<'a> {
    pub(crate) clock: Clock,
    pub(crate) collisions: Vec<Collision>,
    /// The body after each collision of the full model; elsewhere default values. A replay that summed the impulses anew
    /// would round them anew.
    pub(crate) bodies: Vec<(Center, Spin)>,
    pub(crate) record: bool,
    /// Elapsed time at which the run ends, in s.
    pub(crate) end: f64,
    /// Collisions so far.
    pub(crate) hits: usize,
    /// Whether each contact of a pair has been hit.
    pub(crate) struck: [bool; 2],
    /// Other events so far.
    steps: usize,
    /// How often an event other than a collision was counted.
    asked: usize,
    pub(crate) event_limit: usize,
    pub(crate) cancelled: bool,
    /// Whether a flight turned so far that its rotation is not known any more.
    pub(crate) phase_lost: bool,
    cancel: &'a dyn Fn() -> bool,
}

impl<'a> Log<'a> {
    /// Of a body with `count` contacts.
    pub(crate) fn new(options: &Options, count: usize, cancel: &'a dyn Fn() -> bool) -> Self {
        Self {
            clock: Clock::default(),
            collisions: Vec::new(),
            bodies: Vec::new(),
            record: options.record,
            end: options.end(),
            hits: 0,
            struck: [false; 2],
            steps: 0,
            asked: 0,
            event_limit: options.events(count),
            cancelled: false,
            phase_lost: false,
            cancel,
        }
    }

    /// How many collisions may come before the next look at the limits; zero: the run is over.
    pub(crate) fn chunk(&mut self) -> usize {
        self.cancelled = self.cancelled || (self.cancel)();
        if self.cancelled {
            0
        } else {
            CHUNK.min(self.event_limit.saturating_sub(self.hits + self.steps))
        }
    }

    /// Counts one event that is no collision of a loop; false where no more is allowed.
    pub(crate) fn count(&mut self) -> bool {
        if self.hits + self.steps >= self.event_limit {
            return false;
        }
        self.steps += 1;
        self.asked += 1;
        !self.asked.is_multiple_of(CHUNK) || {
            self.cancelled = self.cancelled || (self.cancel)();
            !self.cancelled
        }
    }

    /// Counts a step of a held contact.
    pub(crate) fn count_step(&mut self) -> bool {
        self.steps += STEP - 1;
        self.count()
    }

    /// Time left before the limit, in s.
    pub(crate) fn left(&self) -> f64 {
        Clock { hi: self.end, lo: 0.0 }.since(self.clock)
    }
}
