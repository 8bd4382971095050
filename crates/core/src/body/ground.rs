//! The piece of terrain under a contact.

use nalgebra::{Vector2, Vector3};
use smallvec::SmallVec;

use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::body::terrain::{Ground, Piece, Place, Under, place_error};
use crate::math::turn::Turn;
use crate::tolerance::{FINAL_GAP_ROUNDINGS, PLACE, TOUCH};

/// A choice of the pieces of ground that carry the contacts: for each contact the constants on these pieces.
pub(crate) type Stance = Vec<SmallVec<[ContactGeometry; 2]>>;

/// Largest number of contacts in convex vertices for which both pieces are tried. Further contacts stay on the piece that faces up more.
pub(crate) const MOST_IN_VERTICES: usize = 8;

impl Posture {
    /// Contact `i` on the piece of terrain under it at `q`. In a convex vertex this is the piece that faces up more.
    pub(crate) fn under(&self, i: usize, q: &Vector3<f64>) -> Under {
        let Some(ground) = self.ground(i) else {
            return Under { place: Place::anywhere(i), geometry: self.geometry()[i], exists: true };
        };
        let at = self.position(i, q);
        self.over(i, ground.find_up(&at, self.vertex_error(&at, q)), &at)
    }

    /// As `under`, for a body that moves. A contact in a convex vertex is on the piece that faces up less in two cases: it lifts off the
    /// line of that piece and moves over that piece, along the ground; or it lifts off the line of that piece and moves into the other
    /// piece.
    pub(crate) fn under_moving(&self, i: usize, state: &State) -> Under {
        let under = self.under(i, &state.q);
        let Some([left, right]) = self.convex_vertex(i, &state.q) else { return under };
        let (at, qdot) = (self.position(i, &state.q), state.qdot);
        let turn = Turn::by(state.q.z);
        let known = PLACE * (qdot.xy().norm() + self.size() * qdot.z.abs());
        let is_left = under.place.piece == left;
        let other = self.over(i, if is_left { right } else { left }, &at);
        let k = &under.geometry;
        let along = k.tangent.dot(&qdot.xy()) - k.turned(&turn).1 * qdot.z;
        let beyond = if is_left { along } else { -along };
        let leaves = other.geometry.gap_rate(&qdot, &turn) > known;
        if leaves && (beyond > known || k.gap_rate(&qdot, &turn) < 0.0) { other } else { under }
    }

    /// Contact `i`, at a point, over a piece of its ground.
    fn over(&self, i: usize, piece: isize, at: &Vector2<f64>) -> Under {
        let Some(ground) = self.ground(i) else {
            return Under { place: Place::anywhere(i), geometry: self.geometry()[i], exists: true };
        };
        let (near, exists) = ground.nearest(piece);
        let mut place = ground.place(i, piece, at);
        place.sides = place.sides.map(|side| side.max(0.0));
        Under { place, geometry: self.on_piece(i, near, at), exists }
    }

    /// Rounding error of the distance of a contact at `q` from a vertex, in m.
    fn vertex_error(&self, at: &Vector2<f64>, q: &Vector3<f64>) -> f64 {
        let moved = if *q == Vector3::zeros() { 0.0 } else { self.size() + q.x.abs() + q.y.abs() };
        place_error(at) + PLACE * moved
    }

    /// The pieces on both sides of the convex vertex in which contact `i` is at `q`.
    pub(crate) fn convex_vertex(&self, i: usize, q: &Vector3<f64>) -> Option<[isize; 2]> {
        let ground = self.ground(i)?;
        let at = self.position(i, q);
        ground.convex_vertex(&at, self.vertex_error(&at, q))
    }

    /// The ways in which the contacts that touch at `q` can be on their ground: for each contact the constants of the pieces that carry it.
    /// A contact in a convex vertex is on one of its two pieces; the first way has all of them on the piece that faces up more.
    pub(crate) fn stances(&self, q: &Vector3<f64>) -> Vec<Stance> {
        let count = self.contacts().len();
        let first: Stance = (0..count).map(|i| self.touched(i, q)).collect();
        let mut all = vec![first];
        let at_vertex =
            (0..count).filter_map(|i| self.convex_vertex(i, q).map(|pieces| (i, pieces)));
        for (i, pieces) in at_vertex.take(MOST_IN_VERTICES) {
            let at = self.position(i, q);
            let on = pieces.map(|k| self.over(i, k, &at).geometry);
            let Some(other) = on.into_iter().find(|on| on.normal != all[0][i][0].normal) else {
                continue;
            };
            for k in 0..all.len() {
                let mut stance = all[k].clone();
                stance[i] = SmallVec::from_slice(&[other]);
                all.push(stance);
            }
        }
        all
    }

    /// World position of contact `i` at `q`, of its centre if it is round, in m.
    pub(crate) fn position(&self, i: usize, q: &Vector3<f64>) -> Vector2<f64> {
        let nominal = self.geometry()[i];
        let arm = nominal.tangent * nominal.b + nominal.normal * nominal.c;
        let (half, sin) = (libm::sin(0.5 * q.z), libm::sin(q.z));
        let turned = Vector2::new(
            -arm.y * sin - 2.0 * arm.x * half * half,
            arm.x * sin - 2.0 * arm.y * half * half,
        );
        self.contacts()[i].center() + (q.xy() + turned)
    }

    /// Rounding error of the position of contact `i` at `q`, relative to the ground under it, in m.
    pub(crate) fn place_rounding(&self, i: usize, q: &Vector3<f64>) -> f64 {
        if *q == Vector3::zeros() {
            return 0.0;
        }
        let at = self.position(i, q);
        let reach = self.ground(i).filter(|ground| ground.is_polyline).map_or(0.0, |ground| {
            let ends = ground.nearest(ground.find(&at)).0.ends;
            ends.iter().map(|end| (at - end.vertex).amax()).fold(0.0, f64::max)
        });
        let [x, y] = self.contacts()[i].point;
        let terms = x.abs() + y.abs() + q.x.abs() + q.y.abs() + self.size() + reach;
        FINAL_GAP_ROUNDINGS * f64::EPSILON * terms
    }

    /// Gap of contact `i` within which it touches its ground in the nominal posture, in m: far from the origin the rounding error of its place.
    pub(crate) fn touch(&self, i: usize) -> f64 {
        let [x, y] = self.contacts()[i].point;
        (TOUCH * self.size()).max(FINAL_GAP_ROUNDINGS * f64::EPSILON * (x.abs() + y.abs()))
    }

    /// A gap of contact `i` at `q` whose sign shows whether the contact is in its ground. `gap`: the gap over the piece under the contact.
    /// This gap alone does not show it: near a vertex a point may be nearer to the line of that piece than to the ground, and the gap over
    /// a long piece has the rounding errors of distant coordinates.
    pub(crate) fn signed_gap(&self, i: usize, q: &Vector3<f64>, gap: f64) -> f64 {
        let Some(ground) = self.ground(i).filter(|ground| ground.is_polyline) else { return gap };
        let at = self.position(i, q);
        let depth = ground.depth(&at);
        let touch = self.touch(i);
        if gap < -touch || depth > touch.max(self.place_rounding(i, q)) { -depth } else { gap }
    }

    /// Constants of contact `i` on the piece of terrain under it at `q`. If the contact is in a vertex, within [`TOUCH`] of the size of the
    /// body, the result also has the constants on the next piece, provided that this piece rises from the vertex.
    pub(crate) fn touched(&self, i: usize, q: &Vector3<f64>) -> SmallVec<[ContactGeometry; 2]> {
        let Under { place, geometry, exists } = self.under(i, q);
        let mut all = SmallVec::from_slice(&[geometry]);
        let at = self.position(i, q);
        for side in 0..2 {
            let near = exists && place.sides[side] <= TOUCH * self.size();
            if let Some((piece, bend)) = self.beyond(&place, side, &at).filter(|_| near)
                && bend > 0.0
            {
                all.push(self.on_piece(i, piece, &at));
            }
        }
        all
    }

    /// The piece beyond the start (0) or the end (1) of the piece of a place, and the sine of the angle by which it rises from there; 0 where
    /// the two have one normal. `at`: a point near their joint.
    pub(crate) fn beyond(
        &self,
        place: &Place,
        side: usize,
        at: &Vector2<f64>,
    ) -> Option<(&Piece, f64)> {
        let (to, sign) = if side == 0 { (-1, -1.0) } else { (1, 1.0) };
        let [here, next] = [0, to].map(|to| self.piece(place.contact, place.piece + to));
        let (here, next) = (here?, next?);
        let start = usize::try_from(place.piece.max(place.piece + to)).ok()?;
        let smooth = self.ground(place.contact)?.is_smooth(start);
        let bend = here.axes(at)[0].perp(&next.axes(at)[0]) * sign;
        Some((next, if smooth { 0.0 } else { bend }))
    }

    /// Piece `k` of the terrain of a contact.
    pub(crate) fn piece(&self, contact: usize, k: isize) -> Option<&Piece> {
        self.ground(contact)?.pieces.get(usize::try_from(k).ok()?)
    }

    /// Height of the lowest vertex of the terrain; −∞ if a piece has no end.
    pub(crate) fn lowest_ground(&self) -> f64 {
        let count = self.contacts().len();
        let lowest = |ground: Option<&Ground>| {
            ground
                .map_or(f64::NEG_INFINITY, |ground| ground.low.as_deref().unwrap_or(ground).lowest)
        };
        (0..count).map(|i| lowest(self.ground(i))).fold(f64::INFINITY, f64::min)
    }

    /// Friction, restitution and surface speed (m/s) of contact `i` on a piece of terrain: those of the piece where it has some, otherwise those
    /// of the contact. Without friction nothing feels the speed.
    pub(crate) fn material_on(&self, i: usize, piece: &Piece) -> [f64; 3] {
        let (contact, surface) = (&self.contacts()[i], &piece.surface);
        let friction = surface.friction.unwrap_or(contact.friction);
        let own = contact.restitution.unwrap_or(self.fields().restitution);
        let speed = if friction > 0.0 { surface.speed } else { 0.0 };
        [friction, surface.restitution.unwrap_or(own), speed]
    }

    /// Contact `i` with the arm of its centre along these axes, tangent and normal.
    pub(crate) fn along_axes(
        &self,
        i: usize,
        [tangent, normal]: [Vector2<f64>; 2],
    ) -> ContactGeometry {
        let (b, c) = self.contacts()[i].arms(&self.center(), &tangent, &normal);
        ContactGeometry { tangent, normal, b, c, ..self.geometry()[i] }
    }

    /// Constants of contact `i` on a piece of terrain. On an arc the axes are those at this place of its centre, and so are the gap and its rate.
    pub(crate) fn on_piece(&self, i: usize, piece: &Piece, at: &Vector2<f64>) -> ContactGeometry {
        let contact = &self.contacts()[i];
        let [friction, restitution, surface_speed] = self.material_on(i, piece);
        let ContactGeometry { tangent, normal, b, c, .. } = self.along_axes(i, piece.axes(at));
        let center = contact.center();
        let offset = match piece.corner() {
            Some(_) => piece.height(at) - normal.dot(&(at - center)),
            None => piece.height(&center),
        };
        ContactGeometry {
            tangent,
            normal,
            b,
            c,
            // Zero if it touches within its rounding error.
            offset: if offset.abs() <= self.touch(i) { 0.0 } else { offset },
            gravity: self.fields().gravity * normal.y,
            restitution,
            friction,
            surface_speed,
            radius: contact.radius,
            corner: piece.corner(),
        }
    }
}
