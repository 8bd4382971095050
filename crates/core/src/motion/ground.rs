//! A body that turns, over its ground: flights to the next touchdown or end of a piece of terrain, or over many of these ends at once.

use crate::body::contact::{ContactLetters, ContactValues};
use crate::body::posture::Posture;
use crate::collisions::log::Log;
use crate::flight::is_lost;
use crate::math::mass_vector::Coordinates;
use crate::modes::Mode;
use crate::motion::moving::{Moving, REFRESH};
use crate::motion::record::{Motion, Record};
use crate::motion::series::InstantImpacts;
use crate::options::Options;
use crate::outcome::{Cause, Outcome};
use crate::sustained::edges::{EdgeWatch, Path};
use crate::sustained::{BodyState, ContactState, still_speed};
use crate::tolerance::DEPARTED;

/// The ground of a body.
pub(crate) struct Ground {
    pub(super) posture: Posture,
    /// Number of contacts, of the body and of corners of the ground on sides. Each contact has one point, and a second point while it is in a
    /// vertex. The second points come after all first points.
    pub(super) contacts: usize,
}

impl Ground {
    pub(super) fn new(posture: &Posture, state: &BodyState) -> Self {
        Self {
            posture: posture.clone(), // it shares its data
            contacts: posture.distinct().count() + state.sides.len(),
        }
    }
}

/// What a run knows of a body over its ground.
pub(super) struct OnGround<'d, 'a> {
    pub(super) state: &'d mut BodyState,
    pub(super) ground: &'d mut Ground,
    pub(super) resting: &'d mut ContactValues<bool>,
    pub(super) edges: &'d mut EdgeWatch,
    pub(super) sequence: &'d mut InstantImpacts,
    pub(super) record: &'d mut Record,
    pub(super) log: &'d mut Log<'a>,
    pub(super) cause: &'d mut Option<Cause>,
    pub(super) options: &'d Options,
    /// The largest speed so far, in m/s.
    pub(super) fastest: f64,
}

impl OnGround<'_, '_> {
    /// Puts the contacts that start in vertices and on corners of the ground where they belong.
    pub(super) fn begin(&mut self) {
        (0..self.ground.contacts).for_each(|i| self.choose_by_facing(i));
        self.touch_corners();
    }

    /// Puts the contacts that rest in vertices where they stay. `fresh`: at the start of the run. Returns whether points may have changed.
    pub(super) fn rest(&mut self, fresh: bool) -> bool {
        if fresh {
            self.rest_in_vertices();
        }
        self.stay_in_vertices();
        self.drop_sides_at_corners() || fresh
    }

    /// Bound of the speeds of the points of the body, in m/s.
    pub(super) fn speed(&self) -> f64 {
        let BodyState { center, spin, .. } = &*self.state;
        center.v.norm() + self.ground.posture.size() * spin.omega.abs()
    }

    /// Sliding speed that counts as zero, in m/s.
    pub(super) fn sliding_speed(&self) -> f64 {
        still_speed(self.fastest, self.state.gravity, self.log.clock)
    }

    /// Applies an impulse (tangential, normal) per unit mass at the point on the normal of point `i` with this arm `c`.
    fn push(&mut self, i: usize, impulse: [f64; 2], c: f64) {
        let change = self.state.push(i, impulse, c);
        let change = Coordinates::of_three([change.x, change.y, change.z]);
        self.sequence.pushed(i, impulse[0], &change);
    }

    /// Point `i` hits the two pieces of a vertex in turn at one instant, for ever. In the limit its velocity w is zero; as the impulses of all
    /// these impacts act at this one point, their sum is P = −W⁻¹w. A disc hits them with two points: it is stopped by the normal impulses,
    /// which act at its centre.
    pub(super) fn stop_in_vertex(&mut self, i: usize) {
        let c = self.state.points[i].c;
        let (w, slip, rate) =
            (self.state.matrix_at(i, c), self.state.along(i), self.state.points[i].u);
        let determinant = w.tt * w.nn - w.nt * w.nt;
        let tangential = (w.nt * rate - w.nn * slip) / determinant;
        let normal = (w.nt * slip - w.tt * rate) / determinant;
        self.push(i, [tangential, normal], c);
        self.state.points[i].u = 0.0;
    }

    /// Flies on to the first corner of the ground that meets a side within `t` (s). Returns whether there is one.
    fn meets(&mut self, t: f64, passes: bool) -> bool {
        let Self { state, ground, log, edges, record, options, .. } = self;
        let at = |t| state.place_flown(t);
        let path = Path::new(&ground.posture, &state.sides, &at);
        let time = |t| options.clock(log.clock.after(t));
        let fall = Some(state.fall);
        let Some(entry) = edges.entry(path, t, fall, time, &mut record.warnings) else {
            return false;
        };
        self.fly(entry.t, passes);
        self.meet(entry);
        true
    }

    /// A flight of `dt` (s). `passes`: over ends of pieces of terrain.
    fn fly(&mut self, dt: f64, passes: bool) {
        *self.state = self.state.flown(dt);
        self.log.clock = self.log.clock.after(dt);
        if passes {
            self.state.look_below(&self.ground.posture);
            *self.cause = None;
        }
    }

    /// Returns true if a flight of this duration and distance is too long for the position to stay resolved. With one contact only the
    /// angle counts.
    fn loses_place(&self, dt: f64, way: f64) -> bool {
        let BodyState { points, spin, .. } = &self.state;
        let turned = points.len() > 1 && (spin.theta != 0.0 || spin.omega != 0.0);
        let size = self.ground.posture.size();
        is_lost(spin.omega * dt, if turned { way } else { 0.0 }, size * size)
    }

    /// Flight to the next touchdown or end of a piece of terrain.
    pub(super) fn next_event(&mut self) -> Option<Outcome> {
        self.leave_vertices();
        let n = self.state.points.len();
        self.resting.fill(false);
        let lost = self.log.left() > 0.0 && self.is_lost();
        if lost {
            // No contact has ground to meet any more, whichever piece it was over.
            self.state.points.iter_mut().for_each(|p| (p.h, p.depth) = (f64::INFINITY, 0.0));
        }
        let word = ContactLetters::from_elem(Mode::Separate, n);
        self.log.enter(&word);
        if self.log.record {
            let start = Moving::Turning(Box::new(self.state.clone()));
            let motion = Motion::Modes { start, word, acceleration: None };
            self.record.begin(self.log, motion, *self.cause);
        }
        let landings = self.state.touchdowns(|j| self.is_between(j));
        let first = landings.iter().flatten().copied().fold(f64::INFINITY, f64::min);
        let (mut t, mut crossing) = (first, None);
        for i in (0..n).filter(|_| !lost) {
            if let Some((earlier, side)) = self.state.crossing(i, t).filter(|(at, _)| *at < t) {
                (t, crossing) = (earlier, Some((i, side)));
            }
        }
        let left = self.log.left();
        let free = crossing.and_then(|_| self.state.free(&self.ground.posture, first.min(left)));
        if let Some(until) = free {
            (t, crossing) = (until, None);
        }
        let surfacing = (0..n)
            .filter(|_| !lost)
            .filter_map(|i| self.state.surfacing(i, t.min(left)).map(|t| (t, i)))
            .min_by(|x, y| x.0.total_cmp(&y.0));
        let t = surfacing.map_or(t, |(t, _)| t);
        let strike = (0..n)
            .filter(|_| !lost)
            .filter_map(|i| {
                self.state.strike(i, &self.ground.posture, t.min(left)).map(|hit| (hit, i))
            })
            .min_by(|x, y| x.0.0.total_cmp(&y.0.0));
        let t = strike.map_or(t, |((t, _), _)| t);
        // Events farther away than `DEPARTED` are never reached.
        let fall = |t: f64| t * (self.state.center.v.norm() + 0.5 * t * self.state.gravity);
        if t > left || t == f64::INFINITY || fall(t) > DEPARTED {
            let departs = left == f64::INFINITY || fall(left) > DEPARTED;
            if self.meets(left.max(0.0), free.is_some()) {
                return None;
            }
            if departs {
                return Some(Outcome::Escape);
            }
            self.fly(left.max(0.0), free.is_some());
            return Some(Outcome::TimeLimit);
        }
        if self.loses_place(t, fall(t)) {
            self.log.phase_lost = true;
            return Some(Outcome::EventLimit);
        }
        if self.meets(t, free.is_some()) {
            return None;
        }
        let pieces: ContactValues<isize> =
            self.state.points.iter().map(|p| p.place.piece).collect();
        self.fly(t, free.is_some());
        if self.log.hits.is_multiple_of(REFRESH) {
            self.refresh();
        }
        self.follow_outer();
        if let Some(((_, k), i)) = strike {
            self.state.put_on(i, &self.ground.posture, k);
            return None;
        }
        if let Some((_, i)) = surfacing {
            self.state.points[i].surfaces();
            return None;
        }
        if let Some((i, side)) = crossing {
            self.state.points[i].place.sides[side] = 0.0;
            if !self.lands_in_vertex(i) {
                self.cross(i, side);
            }
            return None;
        }
        for ((p, landing), piece) in self.state.points.iter_mut().zip(landings).zip(pieces) {
            if landing == Some(t) && p.place.piece == piece {
                (p.h, p.u) = (0.0, p.u.min(0.0));
            }
        }
        self.follow_outer();
        None
    }

    /// Corrects accumulated rounding errors: computes b, c from θ, and makes gaps and rates consistent with one rigid body.
    fn refresh(&mut self) {
        let theta = self.state.spin.theta;
        let count = self.ground.posture.contacts().len();
        let own = |p: &&mut ContactState| p.place.contact < count;
        let posture = &self.ground.posture;
        for p in self.state.points.iter_mut().filter(own) {
            let k = posture.along_axes(p.place.contact, [p.tangent, p.normal]);
            (p.b, p.c) = k.refreshed(theta, p.b, p.c);
        }
        self.state.reconcile(self.ground.posture.size());
    }

    /// Returns true if the body has fallen below all of its terrain, so that it meets nothing any more.
    fn is_lost(&self) -> bool {
        let BodyState { center, fall, .. } = &self.state;
        let rise = match (center.v.y.max(0.0), fall.y) {
            (0.0, ..=0.0) => 0.0,
            (up, ..0.0) => -0.5 * up * up / fall.y,
            _ => return false,
        };
        let lowest = self.ground.posture.lowest_ground();
        let top = self.ground.posture.fields().center_of_mass[1] + center.r.y + rise;
        lowest > f64::NEG_INFINITY && top + self.ground.posture.size() < lowest
    }
}
