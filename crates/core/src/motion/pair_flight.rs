//! Flights of two contacts. Plain collisions have loops of their own, up to any other event.

use crate::collisions::full::FullState;
use crate::collisions::local::LoopExit;
use crate::collisions::log::{in_words, names};
use crate::collisions::{full, local};
use crate::flight::parabola_touchdown;
use crate::motion::driver::{Coordinates, Driver};
use crate::motion::pair::{FrozenState, Pair, PairState};
use crate::motion::record::{Motion, Tail};
use crate::outcome::{Outcome, ZenoMethod};
use crate::zeno::Gaps;

/// Collisions in progress. The flight owns the state of the run while it lasts and returns it at its end.
pub(super) enum Flight {
    Local(FrozenState, local::LocalCollisions),
    Full(FullState, full::FullCollisions),
}

impl Driver<'_, Pair> {
    /// The first collision of a flight (local model only); an error: the flight ends before.
    pub(super) fn begin_flight(&mut self) -> Result<Flight, LoopExit> {
        self.note(Motion::Flight);
        let state = match &mut self.body.state {
            PairState::Full(state) => {
                let collisions = full::FullCollisions::begin(&state.body, &mut self.log);
                return Ok(Flight::Full(*state, collisions));
            }
            PairState::Frozen(state) => state,
        };
        let FrozenState { model, gaps, sum } = state;
        let collisions = local::LocalCollisions::begin(model, gaps, sum, &mut self.log)?;
        let flight = Flight::Local(*state, collisions);
        Pair::watch_ground(self);
        Ok(flight)
    }

    /// Flight and collisions until the loop ends.
    #[inline(never)] // keeps the registers free for the collisions
    pub(super) fn collide(&mut self, flight: &mut Flight) -> LoopExit {
        let exit = loop {
            let mut exit = self.next_collision(flight);
            if let Flight::Full(state, collisions) = flight
                && exit.is_none()
                && let Some(contact) = collisions.active()
            {
                exit = self.settles(state, contact);
            }
            if let Flight::Full(state, _) = flight
                && self.watch.is_on()
            {
                self.watch_flight(state);
            }
            if let Some(exit) = exit.or_else(|| self.alternate(flight)) {
                break exit;
            }
        };
        self.end_flight(flight, exit)
    }

    fn next_collision(&mut self, flight: &mut Flight) -> Option<LoopExit> {
        match flight {
            Flight::Local(state, collisions) => collisions.next(&state.model, &mut self.log),
            Flight::Full(state, collisions) => collisions.next(state, &mut self.log),
        }
    }

    /// Plain collisions in turn, until another event is next or the loop ends.
    fn alternate(&mut self, flight: &mut Flight) -> Option<LoopExit> {
        match flight {
            Flight::Full(state, collisions) => collisions.alternate(state, &mut self.log),
            Flight::Local(_, collisions) => {
                collisions.alternate(&mut self.log);
                None
            }
        }
    }

    fn end_flight(&mut self, flight: &mut Flight, halt: LoopExit) -> LoopExit {
        match flight {
            Flight::Full(state, collisions) => {
                let halt = collisions.end(halt, state, &mut self.log);
                self.body.state = PairState::Full(*state);
                halt
            }
            Flight::Local(state, collisions) => {
                let FrozenState { model, gaps, sum } = state;
                let halt = collisions.end(halt, model, gaps, sum, &mut self.log);
                self.body.state = PairState::Frozen(*state);
                halt
            }
        }
    }

    /// Processes the exit of a flight.
    pub(super) fn land(&mut self, halt: LoopExit) -> Option<Outcome> {
        self.align_bodies();
        match halt {
            LoopExit::Bounce { contact, duration } => {
                let model = self.model();
                let (end, own) = model.end_bounce(contact, &self.body.gaps(), duration);
                let closed = [contact == 0, contact == 1];
                self.tail(&model, duration, own, end, closed, Tail::Bounce { contact });
                self.come_to_rest(closed, ZenoMethod::Bounce, true, 0.0)
            }
            LoopExit::Settled { contact } => {
                let end = self.body.settled.take()?;
                self.settle_at(contact, &end)
            }
            LoopExit::Clatter(tail) => self.settle(
                tail.duration,
                ZenoMethod::Clatter,
                tail.proved,
                tail.error,
                Tail::Collisions,
            ),
            LoopExit::Reached { remaining, self_similar } => {
                let method = if self_similar { ZenoMethod::SelfSimilar } else { ZenoMethod::Mixed };
                // The bound is crude, but below the rounding error of the time.
                self.settle(0.5 * remaining, method, false, 0.5 * remaining, Tail::Collisions)
            }
            LoopExit::Freeze => {
                if let PairState::Full(state) = self.body.state {
                    self.freeze(&state);
                }
                None
            }
            LoopExit::Tie => None,
            LoopExit::TimeLimit => Some(Outcome::TimeLimit),
            LoopExit::EventLimit => Some(Outcome::EventLimit),
            LoopExit::Never => Some(self.never(Outcome::Escape)),
        }
    }

    /// The outcome of a motion without further events.
    fn never(&mut self, outcome: Outcome) -> Outcome {
        if self.log.end == f64::INFINITY {
            return outcome;
        }
        let left = self.log.left().max(0.0);
        self.fly_on(left);
        Outcome::TimeLimit
    }

    fn fly_on(&mut self, dt: f64) {
        let after = self.body.frame.flown(&self.record.subject, &self.raw(), dt);
        self.log.clock = after.clock;
        self.body.state = self.body.frame.state(&self.record.subject, &after);
    }
}

/// The contacts on the ground, or the next landing and its speed, in words, with this gravity into each of `count` contacts.
pub(super) fn next_landing(count: usize, gaps: &Gaps, gravity: [f64; 2]) -> String {
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
