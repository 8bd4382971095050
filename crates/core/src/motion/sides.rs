//! Corners of the ground on sides of the body: where they meet, and where a corner of the body takes over at the end of a side.
//!
//! ```text
//!     side of the body slides over V ──► its end, a corner P of the body, comes to V ──► P goes on over the piece that it moves to
//!     a corner P slides off a convex vertex V ──► V goes on along the side behind P
//! ```
//!
//! At both instants the gaps of P and of V are zero.

use nalgebra::Vector2;

use crate::body::outline::Side;
use crate::body::terrain::Piece;
use crate::math::extents::Extent;
use crate::motion::ground::OnGround;
use crate::options::Edges;
use crate::sustained::ContactState;
use crate::sustained::edges::Entry;
use crate::sustained::side::SideContact;
use crate::tolerance::{OVER_VERTEX, PLACE, TOUCH};

impl OnGround<'_, '_> {
    /// The number of the contact of a corner of the ground with a side, from 0: a new one where they meet for the first time.
    fn side_number(&mut self, corner: Vector2<f64>, side: usize) -> usize {
        let sides = &mut self.record.sides;
        let known = sides.iter().position(|on| *on == (corner, side));
        let number = known.unwrap_or_else(|| {
            sides.push((corner, side));
            sides.len() - 1
        });
        self.ground.posture.contacts().len() + number
    }

    fn side(&self, side: usize) -> Option<Side> {
        self.ground.posture.outline().map(|outline| outline.sides()[side])
    }

    /// Adds the contact of a corner of the ground with a side of the body, and the open ones with the sides beside it that it may come to in
    /// concave corners of the body; returns the point of the first.
    fn add_side(&mut self, corner: Vector2<f64>, index: usize) -> Option<usize> {
        let posture = self.ground.posture.clone();
        let outline = posture.outline()?;
        let first = self.add_one_side(corner, &outline.sides()[index])?;
        let mut next = vec![index];
        while let Some(index) = next.pop() {
            for side in outline.beside(&outline.sides()[index]) {
                let count = self.ground.contacts;
                if let Some(i) = self.add_one_side(corner, side)
                    && self.ground.contacts > count
                {
                    if self.state.points[i].h < -TOUCH * posture.size() {
                        self.remove_side(i); // behind the line of a side farther away
                        continue;
                    }
                    self.state.points[i].h = self.state.points[i].h.max(0.0);
                    next.push(side.index());
                }
            }
        }
        Some(first)
    }

    /// Adds the contact of a corner of the ground with a side of the body, unless it exists; returns its point.
    fn add_one_side(&mut self, corner: Vector2<f64>, side: &Side) -> Option<usize> {
        let index = side.index();
        let contact = self.side_number(corner, index);
        if self.state.sides.iter().any(|on| on.contact == contact) {
            let points = &self.state.points;
            return points.iter().position(|p| p.place.contact == contact);
        }
        let on = SideContact::new(&self.ground.posture, contact, corner, side);
        let point = on.point(self.state, self.ground.posture.size());
        let at = self.ground.contacts;
        self.state.sides.push(on);
        self.state.points.insert(at, point);
        self.resting.insert(at, false);
        self.ground.contacts += 1;
        Some(at)
    }

    /// Removes the point of a corner of the ground.
    fn remove_side(&mut self, i: usize) {
        let contact = self.state.points[i].place.contact;
        self.state.sides.retain(|side| side.contact != contact);
        self.state.points.remove(i);
        self.resting.remove(i);
        self.ground.contacts -= 1;
    }

    /// A corner of the ground meets a side of the body.
    pub(super) fn meet(&mut self, entry: Entry) {
        if entry.inside {
            let time = self.options.clock(self.log.clock);
            let [x, y] = [entry.corner.x, entry.corner.y];
            self.record.warnings.push(format!(
                "at t = {time:?} s the corner of the ground at ({x:?}, {y:?}) m was in the body, beyond side {}: put on this side",
                entry.side + 1
            ));
        }
        if let Some(i) = self.add_side(entry.corner, entry.side) {
            self.state.points[i].h = 0.0;
        }
    }

    /// Adds the corners of the ground that touch a side at the start, between its ends.
    pub(super) fn touch_corners(&mut self) {
        if self.options.edges == Edges::Ignore {
            return;
        }
        let q = self.state.state().q;
        let touch = TOUCH * self.ground.posture.size();
        for on in self.ground.posture.sides_touched(&q) {
            if let Some(i) = self.add_side(on.corner, on.side) {
                let p = &mut self.state.points[i];
                let known = |rounding: f64| rounding * PLACE / f64::EPSILON;
                let touches = p.h <= touch.max(known(p.rounding.gap));
                if touches {
                    let still = p.u.abs() <= known(p.rounding.rate);
                    (p.h, p.u) = (0.0, if still { 0.0 } else { p.u });
                }
            }
        }
    }

    /// Adds the corners of the ground that meet a side of the body at this instant.
    pub(super) fn meet_together(&mut self) {
        if !self.edges.has_contacts() {
            return;
        }
        let q = self.state.state().q;
        for on in self.ground.posture.sides_touched(&q) {
            let count = self.ground.contacts;
            let Some(i) =
                self.add_side(on.corner, on.side).filter(|_| self.ground.contacts > count)
            else {
                continue;
            };
            if self.state.points[i].u < 0.0 {
                self.state.points[i].h = 0.0;
            } else {
                self.remove_side(i);
            }
        }
    }

    /// Removes corners of the ground that have come to the line of their side beyond its end, or at its end without approaching the next side:
    /// they pass the corner of the body there. Returns whether there are any.
    pub(super) fn drop_sides_passed(&mut self) -> bool {
        if self.state.sides.is_empty() {
            return false;
        }
        let before = self.ground.contacts;
        (0..before).for_each(|i| self.choose_by_velocity(i));
        for i in (0..before).rev() {
            if self.state.points[i].h == 0.0 && self.passes_corner(i) {
                self.remove_side(i);
            }
        }
        self.ground.contacts < before
    }

    /// Returns true if point `i`, a corner of the ground on the line of its side, is beyond an end of the side, or approaches only this one
    /// of the two sides that meet at that end.
    fn passes_corner(&self, i: usize) -> bool {
        let (state, posture) = (&self.state, &self.ground.posture);
        let (Some(on), Some(outline)) = (state.side_contact(i), posture.outline()) else {
            return false;
        };
        let (size, p) = (posture.size(), &state.points[i]);
        let (ways, touch) = (on.distances_from_ends(p.b), TOUCH * size);
        if ways.iter().any(|way| *way < -touch) {
            return true;
        }
        let corner = on.corner + Vector2::from(posture.fields().center_of_mass);
        let convex = |end: &usize| ways[*end] <= touch && !outline.sides()[on.side].concave()[*end];
        let mut next = (0..2).filter(convex).filter_map(|end| outline.next(on.side, end));
        let rate = |side: &Side| SideContact::new(posture, 0, corner, side).point(state, size).u;
        p.u < 0.0 && next.any(|side| rate(side) >= 0.0)
    }

    /// Returns true if a side of the body that ends at point `i` lies on this vertex of the ground.
    pub(super) fn ends_side_on(&self, i: usize, vertex: Vector2<f64>) -> bool {
        let (state, posture) = (&self.state, &self.ground.posture);
        let center = Vector2::from(posture.fields().center_of_mass);
        let here = |end: Vector2<f64>| self.corner_at(end + center) == Some(i);
        state.points.iter().any(|p| {
            let on = state.sides.iter().find(|on| on.contact == p.place.contact);
            let on = on.filter(|on| p.h == 0.0 && on.corner + center == vertex);
            on.and_then(|on| self.side(on.side))
                .is_some_and(|side| side.ends().into_iter().any(here))
        })
    }

    /// The point of the contact at this place of the body in its nominal posture.
    fn corner_at(&self, place: Vector2<f64>) -> Option<usize> {
        let posture = &self.ground.posture;
        let touch = TOUCH * posture.size();
        let is_at =
            |k: &usize| (Vector2::from(posture.contacts()[*k].point) - place).norm() <= touch;
        posture.distinct().find(is_at).map(|k| posture.point_of(k))
    }

    /// Removes corners of the ground that move out of their sides, with a corner of the body on the ground at the same place. Returns whether
    /// there are any.
    pub(super) fn drop_sides_at_corners(&mut self) -> bool {
        let (count, touch) = (self.ground.contacts, TOUCH * self.ground.posture.size());
        let center = Vector2::from(self.ground.posture.fields().center_of_mass);
        for i in (0..count).rev() {
            let state = &self.state;
            let (Some(on), p) = (state.side_contact(i), &state.points[i]) else { continue };
            let (Some(side), slip) = (self.side(on.side), state.slip(i)) else { continue };
            let stands = |end: usize| {
                let outwards = if end == 0 { slip > 0.0 } else { slip < 0.0 };
                outwards
                    && p.h == 0.0
                    && p.place.sides[end] <= touch
                    && self
                        .corner_at(side.ends()[end] + center)
                        .is_some_and(|j| state.points[j].h == 0.0)
            };
            if (0..2).any(stands) {
                self.remove_side(i);
            }
        }
        self.ground.contacts < count
    }

    /// Point `i`, a corner of the ground, comes to the start (0) or the end (1) of its side: the corner of the body there takes over.
    pub(super) fn leave_side(&mut self, i: usize, end: usize) {
        let Some(on) = self.state.side_contact(i).copied() else { return };
        let closed = self.state.points[i].h == 0.0;
        self.remove_side(i);
        let Some(side) = self.side(on.side) else { return };
        let center = Vector2::from(self.ground.posture.fields().center_of_mass);
        let Some(j) = self.corner_at(side.ends()[end] + center).filter(|_| closed) else {
            return;
        };
        self.put_in_vertex(j, on.corner + center);
    }

    /// Puts point `j`, a corner of the body that comes to a vertex of its ground from the end of a side, onto the piece that it moves to. It
    /// moves along the side, which does not enter the ground: it approaches at most one of the two pieces, and leaves the other one or moves
    /// along it.
    fn put_in_vertex(&mut self, j: usize, vertex: Vector2<f64>) {
        let contact = self.state.points[j].place.contact;
        let posture = self.ground.posture.clone();
        let Some(ground) = posture.ground(contact) else { return };
        let at_end = |piece: &Piece| (0..2).find(|&end| piece.ends[end].vertex == vertex);
        let here = Extent::of([vertex]).grown(TOUCH * posture.size());
        let mut near = ground.places.meeting(here);
        let found = near.find_map(|k| Some((k, at_end(&ground.pieces[k])?)));
        let Some((k, end)) = found else { return };
        if self.state.points[j].h == 0.0 && self.state.points[j].u == 0.0 {
            return; // it touches already
        }
        self.state.put_on(j, &self.ground.posture, k as isize);
        self.state.points[j].place.sides[end] = 0.0;
        self.resting[j] = false;
        let slip = self.state.slip(j);
        let beyond = self.ground.posture.piece(contact, k as isize + if end == 0 { -1 } else { 1 });
        let outwards = if end == 0 { slip < 0.0 } else { slip > 0.0 };
        if beyond.is_none() && outwards {
            self.cross(j, end);
            return;
        }
        let mut p = self.state.points[j];
        let other = if beyond.is_some() { self.beyond_vertex(j, end) } else { p };
        p = self.off_side(&p, &other);
        if p.u < 0.0 && beyond.is_none() {
            (p.h, p.depth) = (f64::INFINITY, f64::MIN_POSITIVE); // under the piece, from beyond its end
        }
        self.state.points[j] = p;
    }

    /// A corner of the body that comes to a convex vertex of the ground from the end of a side, on one piece of the vertex or on the other: on
    /// the one that it does not approach.
    pub(super) fn off_side(&self, one: &ContactState, other: &ContactState) -> ContactState {
        let (v, omega) = (self.state.center.v, self.state.spin.omega);
        let known = PLACE * (v.norm() + one.arm().norm() * omega.abs());
        let rate = |p: &ContactState| p.normal.dot(&v) + p.b * omega;
        let p = if rate(other) > rate(one) { other } else { one };
        ContactState { u: if rate(p).abs() <= known { 0.0 } else { rate(p) }, ..*p }
    }

    /// Point `i`, a corner of the body on the ground, passes a convex vertex: the vertex goes on along the side behind the corner. It moves away
    /// from the line of neither side of the corner, and along one of them towards its other end.
    pub(super) fn go_on_along_side(&mut self, i: usize, vertex: Vector2<f64>) {
        if !self.edges.may_touch(&vertex) {
            return;
        }
        let posture = self.ground.posture.clone();
        let (Some(outline), state) = (posture.outline(), &self.state) else { return };
        let center = Vector2::from(posture.fields().center_of_mass);
        let corner =
            Vector2::from(posture.contacts()[state.points[i].place.contact].point) - center;
        let touch = TOUCH * posture.size();
        let (v, omega) = (state.center.v, state.spin.omega);
        let mut found: Option<(f64, usize, usize)> = None;
        for (index, side) in outline.sides().iter().enumerate() {
            for end in (0..2).filter(|&end| (side.ends()[end] - corner).norm() <= touch) {
                let p = SideContact::new(&posture, 0, vertex, side).point(state, posture.size());
                let slip = p.tangent.dot(&v) - p.c * omega;
                let speed = v.norm() + p.arm().norm() * omega.abs();
                let still = p.u.abs() <= OVER_VERTEX * f64::EPSILON * speed;
                let rate = if still { 0.0 } else { p.u };
                if rate > 0.0 {
                    return; // in front of this side
                }
                // ḃ = −v_t: from the start of the side towards its end, or back.
                let inwards = if end == 0 { slip < 0.0 } else { slip > 0.0 };
                if inwards && found.is_none_or(|(most, ..)| rate > most) {
                    found = Some((rate, index, end));
                }
            }
        }
        let Some((rate, index, end)) = found else { return };
        if state.sides.iter().any(|on| on.side == index && on.corner == vertex - center) {
            return;
        }
        if let Some(k) = self.add_side(vertex, index) {
            let p = &mut self.state.points[k];
            (p.h, p.u) = (0.0, rate);
            p.place.sides[end] = 0.0;
            self.resting[k] = rate == 0.0;
        }
    }
}
