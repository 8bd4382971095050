//! Ends of the pieces of terrain: crossing them, coming to rest in a vertex, and leaving it.

use nalgebra::Vector2;

use crate::body::contact::ContactValues;
use crate::body::ground::MOST_IN_VERTICES;
use crate::body::terrain::Place;
use crate::modes::Mode;
use crate::motion::ground::OnGround;
use crate::outcome::{Cause, ContactNumber};
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::{
    BODY_STOPPED, LANDS_TOGETHER, OVER_VERTEX, PLACE, STEEPER_PIECE, TOUCH, WEDGED,
};

impl OnGround<'_, '_> {
    /// Contact `i` crosses the left (0) or right (1) end of the piece of terrain under it. The next piece is as high there, and
    /// the point continues over it; if there is none, the contact meets no terrain any more.
    pub(super) fn cross(&mut self, i: usize, side: usize) {
        let count = self.ground.contacts;
        let contact = self.state.points[i].place.contact;
        *self.cause = self.resting[i].then_some(Cause::LeftSegment(ContactNumber::of(contact)));
        if self.state.side_contact(i).is_some() {
            self.leave_side(i, side);
            return;
        }
        if let Some(twin) = (count..self.state.points.len())
            .find(|&k| self.state.points[k].place.contact == contact)
        {
            // At a vertex it had two pieces; the other one remains.
            if i < count {
                self.state.points[i] = self.state.points[twin];
                self.resting[i] = self.resting[twin];
            }
            self.state.points.remove(twin);
            self.resting.remove(twin);
            return;
        }
        if self.wedge(i, side) {
            return;
        }
        let (p, old) = (self.neighbour(i, side), self.state.points[i]);
        self.state.points[i] = p;
        self.resting[i] &= p.h == 0.0 && p.u == 0.0;
        let passed = self.ground.posture.piece(contact, old.place.piece).filter(|_| old.h == 0.0);
        if let Some(vertex) = passed.map(|piece| piece.ends[side].vertex) {
            self.go_on_along_side(i, vertex);
        }
    }

    /// The state of contact `i`, at an end of the piece of terrain under it, over the next piece.
    pub(super) fn neighbour(&self, i: usize, side: usize) -> ContactState {
        let old = self.state.points[i];
        let mut p = old;
        let Place { contact, piece, .. } = old.place;
        let step = if side == 0 { -1 } else { 1 };
        let (arm, at) = (old.arm(), self.state.position(i, &self.ground.posture));
        let Some(ground) = self.ground.posture.ground(contact) else { return old };
        p.place = ground.place(contact, piece + step, &at);
        // Where separating lines have crossed each other, the point has crossed several of them.
        while ground.has_walls
            && p.place.sides[side] < 0.0
            && self.ground.posture.piece(contact, p.place.piece).is_some()
        {
            p.place = ground.place(contact, p.place.piece + step, &at);
        }
        let is_next = p.place.piece == piece + step;
        let separated = ground.raised > 0.0 && p.place.across[1 - side] != old.place.across[side];
        // Beside an arc two lines separate the pieces: the distances from both are known up to the rounding error of the place.
        let error = self.state.position_error(i, &self.ground.posture);
        if separated && p.place.sides[1 - side] < 0.0 {
            // Under the joint, between the two lines, it touches neither.
            let under = p.place.sides[1 - side] < -error;
            p.place.sides[1 - side] = if under { f64::INFINITY } else { 0.0 };
        }
        if is_next && !separated {
            p.place.sides[1 - side] = 0.0;
        }
        let (piece, exists) = ground.nearest(p.place.piece);
        if !exists && piece.normal == old.normal {
            (p.h, p.depth) = (f64::INFINITY, 0.0);
            return p;
        }
        if !ground.has_walls {
            p.place.sides[side] = piece.ends[1].vertex.x - piece.ends[0].vertex.x;
        }
        let velocity = old.tangent * self.state.along(i) + old.normal * old.u;
        p.turns_to(&self.ground.posture, piece, &at);
        // The line along which an arc meets the piece beside it goes on behind the corner.
        let is_arc = old.corner.or(p.corner).is_some();
        let behind = is_arc && !separated && p.normal.dot(&old.normal) < 0.0;
        let smooth = is_next
            && !behind
            && usize::try_from(p.place.piece.max(old.place.piece))
                .is_ok_and(|start| ground.is_smooth(start));
        (p.b, p.c) = (p.tangent.dot(&arm), p.normal.dot(&arm));
        (p.held, p.depth) = (None, 0.0);
        if p.normal != old.normal && !smooth {
            p.u = p.normal.dot(&velocity);
        }
        if !exists {
            p.h = f64::INFINITY;
            return p;
        }
        let (height, touch) = (piece.height(&at), TOUCH * self.ground.posture.size());
        let known = old.h < f64::INFINITY && is_next && !behind;
        let at_joint = separated && old.h <= error && height.abs() <= error;
        if known && at_joint {
            (p.h, p.place.sides[1 - side]) = (0.0, 0.0);
            return p;
        }
        let known = known && !separated;
        if known && (smooth || old.place.across[side] != Vector2::x()) {
            p.h = old.h; // on the line between the two
            return p;
        }
        if known && !(height > touch && p.normal.y > STEEPER_PIECE * old.normal.y) {
            p.h = old.h * p.normal.y / old.normal.y; // same height above the vertex
            return p;
        }
        p.h = if height >= -touch { height.max(0.0) } else { f64::INFINITY };
        p.depth = if height >= -touch { 0.0 } else { -height };
        let terms = self.state.center.r.norm() + p.b.abs() + p.c.abs() + self.ground.posture.size();
        p.rounding = Rounding { gap: f64::EPSILON * terms, ..old.rounding };
        p
    }

    /// Puts a contact on both pieces of a vertex between rising pieces if it has come to rest. Returns whether it has.
    pub(super) fn wedge(&mut self, i: usize, side: usize) -> bool {
        let old = self.state.points[i];
        let posture = self.ground.posture.clone();
        let at = self.state.position(i, &posture);
        let Some((piece, rises)) = posture.beyond(&old.place, side, &at) else { return false };
        let along = self.state.along(i);
        let ahead = old.place.across[side].dot(&old.tangent);
        if ahead <= 0.0 {
            return false; // on an arc, more than a right angle away
        }
        let height = old.h + old.place.sides[side] / ahead;
        let square = along * along + old.u * old.u + 2.0 * self.state.gravity * height;
        let limit = self.wedged(i);
        // Without gravity a contact may be slow at any height.
        let near = height <= TOUCH * self.ground.posture.size();
        let slow = square <= limit * limit;
        // Beside an arc the distances from both pieces have the rounding error of the place. A fall through both errors, v² = 2 g h, is rounding
        // error, too.
        let by_place = match (old.corner, piece.corner()) {
            (None, None) => 0.0,
            _ => 2.0 * self.state.gravity * (2.0 * self.state.position_error(i, &posture)),
        };
        let next = piece.axes(&at)[1];
        if !(rises > 0.0 && near && (slow || square <= by_place || self.meets_both(i, side, &next)))
        {
            return false;
        }
        // A disc that rolls to and fro between the pieces comes to rest: its rolling is not zero by itself.
        let turns = old.radius > 0.0 && self.speed() <= limit * BODY_STOPPED;
        if turns {
            self.state.stand();
        } else if !slow {
            self.stop_in_vertex(i);
        }
        let old = self.state.points[i];
        let mut p = old;
        (p.h, p.u, p.place.sides[side]) = (0.0, 0.0, 0.0);
        let one = std::mem::replace(&mut self.state.points[i], p);
        let twin = ContactState { h: 0.0, u: 0.0, ..self.neighbour(i, side) };
        self.state.points.push(twin);
        // If a body in flight turns so fast that the contact is accelerated away from both pieces, the contact leaves at once.
        let leaves = |k: usize| self.state.known_pull(k) < 0.0;
        if !self.resting.contains(&true) && leaves(i) && leaves(self.state.points.len() - 1) {
            self.state.points.pop();
            self.state.points[i] = one;
            return false;
        }
        self.resting.push(true);
        true
    }

    /// Puts those of these points that have come to rest in vertices on both pieces; returns them, and the largest of their speeds that count as
    /// zero, in m/s.
    pub(super) fn wedge_all(&mut self, points: &[usize]) -> (ContactValues<usize>, f64) {
        if self.state.points.len() != self.ground.contacts {
            return (ContactValues::new(), 0.0);
        }
        let wedged: ContactValues<usize> =
            points.iter().copied().filter(|&i| self.wedge(i, 0) || self.wedge(i, 1)).collect();
        let slowest = wedged.iter().map(|&i| self.wedged(i)).fold(0.0, f64::max);
        (wedged, slowest)
    }

    /// Returns true if point `i`, in a vertex at this end of its piece, comes to its tip so slowly that the rates of the gaps to both
    /// pieces are rounding error; `other`: the normal of the next one. In a narrow vertex the speed along the pieces that remains is larger, by
    /// the inverse of the angle between them.
    fn meets_both(&self, i: usize, side: usize, other: &Vector2<f64>) -> bool {
        let (state, p) = (&self.state, &self.state.points[i]);
        let along = state.along(i);
        let inwards = if side == 0 { along < 0.0 } else { along > 0.0 };
        let speed = state.center.v.norm() + p.arm().norm() * state.spin.omega.abs();
        let least = OVER_VERTEX * f64::EPSILON * speed;
        let rate = other.dot(&(p.tangent * along + p.normal * p.u));
        p.h == 0.0 && p.place.sides[side] == 0.0 && inwards && p.u.abs().max(rate.abs()) <= least
    }

    /// Puts contacts that start at rest in vertices on both pieces.
    pub(super) fn rest_in_vertices(&mut self) {
        for i in 0..self.ground.contacts {
            let ContactState { h, u, place, .. } = self.state.points[i];
            let mut ends = (0..2).filter(|&side| place.sides[side] == 0.0);
            if (h, u) == (0.0, 0.0) && ends.any(|side| self.wedge(i, side)) {
                *self.resting.last_mut().unwrap_or(&mut false) = false; // its rest is not recorded yet
            }
        }
    }

    /// The end of its piece at which point `i`, on the ground, is in a convex vertex.
    pub(super) fn convex_end(&self, i: usize) -> Option<usize> {
        let p = &self.state.points[i];
        if p.h != 0.0 || p.place.sides == [f64::INFINITY; 2] || self.state.second(i).is_some() {
            return None;
        }
        let error = self.state.position_error(i, &self.ground.posture);
        // A gap that has come down with a larger error, in many bounces, ends so far from the vertex.
        let error = error.max(LANDS_TOGETHER * p.rounding.gap);
        let posture = &self.ground.posture;
        let at = self.state.position(i, posture);
        let falls = |side: &usize| {
            let next = posture.beyond(&p.place, *side, &at);
            p.place.sides[*side] <= error && next.is_some_and(|(_, rises)| rises < 0.0)
        };
        [0, 1].into_iter().find(falls)
    }

    /// Point `i`, which is in a convex vertex at this end of its piece, on the other piece of the vertex.
    pub(super) fn beyond_vertex(&self, i: usize, side: usize) -> ContactState {
        ContactState { h: 0.0, ..self.neighbour(i, side) }
    }

    /// Puts point `i`, if it moves on the ground in a convex vertex, onto one of the two pieces. This is the piece that faces up more,
    /// unless the point approaches this piece and moves away from the other one. A point that moves along the other one hits this piece,
    /// unless it is on the other one already, or a side of the body that ends at the point lies on the vertex: then it approaches neither.
    pub(super) fn choose_by_velocity(&mut self, i: usize) {
        let Some(side) = self.convex_end(i) else { return };
        let (p, other) = (self.state.points[i], self.beyond_vertex(i, side));
        let speed = p.u.abs() + self.state.along(i).abs();
        if speed <= self.sliding_speed() {
            return;
        }
        let fall = self.state.fall;
        let (up, down) =
            if other.normal.dot(&fall) < p.normal.dot(&fall) { (other, p) } else { (p, other) };
        let off_side = self.off_side(&p, &other);
        let leaves_side =
            || self.vertex(&p, side).is_some_and(|vertex| self.ends_side_on(i, vertex));
        let on_up = up.u >= 0.0 || p.u < 0.0 && down.u <= PLACE * speed;
        let chosen = match on_up {
            _ if off_side.u >= 0.0 && p.u < 0.0 && leaves_side() => off_side,
            true => up,
            false => down,
        };
        self.resting[i] &= chosen.normal == p.normal;
        self.state.points[i] = chosen;
    }

    /// The vertex at this end of the piece of a point.
    fn vertex(&self, p: &ContactState, side: usize) -> Option<Vector2<f64>> {
        let piece = self.ground.posture.piece(p.place.contact, p.place.piece)?;
        Some(piece.ends[side].vertex)
    }

    /// Puts point `i`, if it starts in a concave vertex and approaches both pieces, onto the piece that faces up more. The choice of the
    /// piece that is hit first thus does not depend on the order of the pieces.
    pub(super) fn choose_by_facing(&mut self, i: usize) {
        let p = self.state.points[i];
        let free = p.place.sides == [f64::INFINITY; 2];
        if free || p.h != 0.0 || p.u >= 0.0 || self.state.second(i).is_some() {
            return;
        }
        let fall = self.state.fall;
        let speed = p.u.abs() + self.state.along(i).abs();
        for side in (0..2).filter(|&side| p.place.sides[side] == 0.0) {
            let other = self.neighbour(i, side);
            let hit = other.h == 0.0 && other.u < -PLACE * speed;
            if hit && other.normal.dot(&fall) < p.normal.dot(&fall) {
                self.resting[i] = false;
                self.state.points[i] = other;
                return;
            }
        }
    }

    /// Point `i`, which comes to an end of its piece, lands at the same instant in a convex vertex. Returns whether it does.
    pub(super) fn lands_in_vertex(&mut self, i: usize) -> bool {
        let p = self.state.points[i];
        let error = self.state.position_error(i, &self.ground.posture);
        if !(p.u < 0.0 && p.h <= error) {
            return false;
        }
        self.state.points[i].h = 0.0;
        let lands = self.convex_end(i).is_some();
        if lands {
            self.choose_by_velocity(i);
        } else {
            self.state.points[i].h = p.h;
        }
        lands
    }

    /// Contacts that have come to rest in convex vertices are each on one of the two pieces. All combinations are tried. They are compared
    /// first by whether a consistent word holds all closed contacts fixed, then by the number of contacts that stay on their pieces. The
    /// first of the best ones is taken.
    pub(super) fn stay_in_vertices(&mut self) {
        let points = &self.state.points;
        let rests = |i: &usize| points[*i].h == 0.0 && points[*i].u == 0.0;
        let still = |i: usize| self.state.slip(i).abs() <= self.sliding_speed();
        let ends: Vec<(usize, usize)> = (0..self.ground.contacts)
            .filter(rests)
            .filter_map(|i| Some((i, self.convex_end(i).filter(|_| still(i))?)))
            .take(MOST_IN_VERTICES)
            .collect();
        if ends.is_empty() {
            return;
        }
        let way = |slip: f64| i8::from(slip > 0.0) - i8::from(slip < 0.0);
        let ways: Vec<Option<i8>> = (0..points.len())
            .map(|i| rests(&i).then(|| if still(i) { 0 } else { way(self.state.slip(i)) }))
            .collect();
        let mut best: Option<((bool, usize), BodyState)> = None;
        for choice in 0..1_usize << ends.len() {
            let (mut body, mut inwards) = (self.state.clone(), vec![None; points.len()]);
            for (bit, &(i, side)) in ends.iter().enumerate() {
                let moves = choice >> bit & 1 == 1;
                if moves {
                    body.points[i] = ContactState { u: 0.0, ..self.beyond_vertex(i, side) };
                }
                inwards[i] = Some(if (side == 1) == moves { Mode::Right } else { Mode::Left });
            }
            let Ok(problem) = body.problem(1.0, &ways) else { return };
            let holds = problem.holds(&inwards);
            if best.as_ref().is_none_or(|(most, _)| holds > *most) {
                best = Some((holds, body));
            }
        }
        if let Some((_, body)) = best {
            *self.state = body;
        }
    }

    /// Puts contacts that leave a vertex over the piece towards which they move.
    pub(super) fn leave_vertices(&mut self) {
        let count = self.ground.contacts;
        while let Some(twin) = self.state.points.pop() {
            if self.state.points.len() < count {
                self.state.points.push(twin);
                break;
            }
            let i = self.ground.posture.point_of(twin.place.contact);
            let twin_on_right = twin.place.piece > self.state.points[i].place.piece;
            let away = self.state.side(i, usize::from(twin_on_right)).u > 0.0; // from the vertex
            if !away {
                self.state.points[i] = twin;
            }
        }
        self.resting.truncate(count);
    }

    /// Speed of point `i` in a vertex that counts as zero, in m/s.
    pub(super) fn wedged(&self, i: usize) -> f64 {
        let rubs = self.state.points[i].friction > 0.0;
        if rubs { self.sliding_speed() } else { WEDGED * self.fastest }
    }
}
