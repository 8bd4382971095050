//! Contacts that arrive at one instant.
//!
//! In exact arithmetic the corners of a box that slides flush into a wall arrive together; computed times differ by rounding errors. One
//! rule holds for flights and contact phases: a contact arrives with another one if its gap, or its distance along the ground from the
//! next piece, is closing and below the rounding error of its own terms. A corner of the ground arrives with them if it touches a side.

use crate::body::contact::{ContactValues, PerContact};
use crate::math::clock::Clock;
use crate::motion::ground::OnGround;
use crate::sustained::ContactState;
use crate::sustained::rows::Between;

impl OnGround<'_, '_> {
    /// The points that are hit: these, and all that arrive with them, whose gaps are set to zero. A contact that approaches because of an
    /// impact at this instant arrives later.
    pub(super) fn arriving(&mut self, coming: &[usize]) -> ContactValues<usize> {
        if self.sequence.goes_on(self.log.clock) {
            return ContactValues::from_slice(coming);
        }
        self.arriving_before(coming, self.log.clock)
    }

    /// As `arriving`, with all contacts that arrive up to the time `end`, which is a few ulp of the clock later.
    pub(super) fn arriving_before(&mut self, coming: &[usize], end: Clock) -> ContactValues<usize> {
        let firsts: PerContact<ContactState> =
            coming.iter().map(|&i| self.state.points[i]).collect();
        self.meet_together();
        (0..self.ground.contacts).for_each(|i| self.choose_by_velocity(i));
        let (clock, options) = (self.log.clock, *self.options);
        // Times are compared as they are recorded.
        let is_due = |gap: f64, rate: f64| {
            gap >= 0.0
                && rate < 0.0
                && options.clock(clock.after(-gap / rate)) <= options.clock(end)
        };
        let later = end != clock;
        for j in 0..self.state.points.len() {
            let held_off = self.is_between(j);
            let p = &mut self.state.points[j];
            let together = firsts.iter().any(|first| p.lands_with(first));
            if p.h > 0.0 && !held_off && (together || later && is_due(p.h, p.u)) {
                p.h = 0.0;
            }
            let p = self.state.points[j];
            if p.h == 0.0 && p.u < 0.0 || self.state.second(j).is_some() {
                continue;
            }
            let (body, posture) = (&self.state, &self.ground.posture);
            let error = body.position_error(j, posture);
            // Up to a later time, what has not been reached is compared by its time.
            let reached = if later { 0.0 } else { error };
            let comes = |gap: f64, rate: f64| {
                let now = gap <= reached || later && is_due(gap, rate);
                rate < 0.0 && gap >= -error && now
            };
            if let Some(side) = body.end_reached(j, comes) {
                let distance = std::mem::take(&mut self.state.points[j].place.sides[side]);
                if self.rises(j, side) {
                    self.cross(j, side);
                } else {
                    self.state.points[j].place.sides[side] = distance;
                }
            } else if let Some(piece) = body.struck(j, posture, comes) {
                self.state.put_on(j, &self.ground.posture, piece);
            }
        }
        self.land_between();
        self.drop_sides_passed();
        self.approaching()
    }

    /// Points that approach the ground they are on.
    fn approaching(&self) -> ContactValues<usize> {
        let points = &self.state.points;
        (0..points.len()).filter(|&i| points[i].h == 0.0 && points[i].u < 0.0).collect()
    }

    /// Contact `i` crosses an end, and with it all closed contacts that come to an end of their pieces at this instant.
    pub(super) fn leave_together(&mut self, i: usize, side: usize) {
        let contact = |p: &ContactState| p.place.contact;
        let first = contact(&self.state.points[i]);
        let contacts = self.state.points.iter().take(self.ground.contacts).map(contact);
        let others: ContactValues<usize> = contacts.filter(|&other| other != first).collect();
        self.cross(i, side);
        for other in others {
            // The end of a side removes its point.
            let points = &self.state.points;
            let Some(j) = points.iter().position(|p| contact(p) == other) else { continue };
            if points[j].h > 0.0 || self.state.second(j).is_some() {
                continue;
            }
            let body = &self.state;
            let error = body.position_error(j, &self.ground.posture);
            if let Some(side) = body.end_reached(j, |gap, rate| gap <= error && rate < 0.0) {
                self.state.points[j].place.sides[side] = 0.0;
                self.cross(j, side);
            }
        }
    }

    /// Returns true if the next piece rises in the way of point `j`, which is at an end of its piece.
    fn rises(&self, j: usize, side: usize) -> bool {
        let next = self.neighbour(j, side);
        next.h == 0.0 && next.u < 0.0
    }
}

impl OnGround<'_, '_> {
    /// The outermost contacts over the piece of ground of a contact that is between two others there.
    fn outer(&self, j: usize) -> Option<Between> {
        let points = &self.state.points;
        let alike = |k: usize| {
            let (one, other) = (&points[j], &points[k]);
            let is_over = |p: &ContactState| p.h < f64::INFINITY && p.depth == 0.0;
            one.normal == other.normal
                && one.place.piece == other.place.piece
                && is_over(one)
                && is_over(other)
        };
        self.ground.posture.lines().iter().find_map(|line| {
            let at = line.iter().position(|(k, _)| *k == j)?;
            let (i, from) = *line[..at].iter().find(|(k, _)| alike(*k))?;
            let (k, to) = *line[at + 1..].iter().rfind(|(k, _)| alike(*k))?;
            Some(Between { outer: [i, k], weight: (to - line[at].1) / (to - from) })
        })
    }

    /// Returns true if a contact is between two others over its piece of ground: it does not land before they do.
    pub(super) fn is_between(&self, j: usize) -> bool {
        self.outer(j).is_some()
    }

    /// Which points are between two others. Empty: none.
    pub(super) fn followers(&self) -> ContactValues<bool> {
        let count = if self.ground.posture.lines().is_empty() { 0 } else { self.ground.contacts };
        (0..count).map(|j| self.is_between(j)).collect()
    }

    /// Closes the contacts between two others that are closed.
    pub(super) fn land_between(&mut self) {
        if self.ground.posture.lines().is_empty() {
            return;
        }
        for j in 0..self.ground.contacts {
            let points = &self.state.points;
            let closed = |outer: [usize; 2]| outer.into_iter().all(|k| points[k].h == 0.0);
            if self.outer(j).is_some_and(|between| closed(between.outer)) {
                self.state.points[j].h = 0.0;
            }
        }
    }

    /// Sets the gaps and rates of contacts between others to the weighted means.
    pub(super) fn follow_outer(&mut self) {
        if self.ground.posture.lines().is_empty() {
            return;
        }
        for j in 0..self.ground.contacts {
            let Some(between) = self.outer(j) else { continue };
            let points = &mut self.state.points;
            let of = between.outer.map(|k| (points[k].h, points[k].u, points[k].rounding));
            let p = &mut points[j];
            (p.h, p.u, p.rounding) = between.mean(of);
        }
    }
}
