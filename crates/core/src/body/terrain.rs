//! Terrain: adjacent straight pieces, and the choice of the piece that a point of the body may touch.
//!
//! ```text
//!          _____              the ground lies on the right of the polyline, the normal n points to its left
//!    \    /     \   |          between pieces that face up, a vertical through their vertex separates
//!     \__/       \__|          the points over the one from those over the other; elsewhere the bisector
//! ```
//!
//! On the bisector of two pieces a point has the same distance to both lines. So its gap does not jump when the piece changes. Beyond the
//! ends of the terrain a point touches nothing. A point may get below the line of a piece from beyond the end of that piece. Such a point
//! does not touch the piece until it has left the piece or has come to its front.
//!
//! Whether a point is free or in the ground follows from its nearest piece: from the side of that piece on which the point lies. If the
//! nearest place is a vertex, the point is free where the ground is convex, and in the ground where the ground is concave. The signs that
//! decide this are exact.

use std::cmp::Ordering;
use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::Vector2;
use smallvec::SmallVec;

use crate::body::contact::{Contact, direction};
use crate::body::fields::Surface;
use crate::body::geometry::ContactGeometry;
use crate::error::{Error, finite};
use crate::math::extents::{Extent, ExtentTree};
use crate::math::orientation::{along, area, precise_area};
use crate::tolerance::{SAME_VERTEX, STRAIGHT_VERTEX};

/// Rounding error of a distance from a piece. Unit: machine epsilon times the distance from the more distant vertex of the piece; for a
/// precise distance, machine epsilon times the distance itself.
const DISTANCE_ROUNDINGS: f64 = 8.0;

/// Largest number of vertices of a terrain.
pub const MAX_VERTICES: usize = 1024;

/// An end of a piece. A line through it separates the points that may touch this piece from those that may touch the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct End {
    pub(crate) vertex: Vector2<f64>,
    /// Unit normal of the separating line, towards the next piece.
    pub(crate) across: Vector2<f64>,
    /// across·vertex
    pub(super) at: f64,
}

/// Unit normal of the bisector of two pieces with these tangents, along the ground. `turn`: −1 where the ground is convex, otherwise 1.
pub(super) fn bisector(one: Vector2<f64>, two: Vector2<f64>, turn: f64) -> Vector2<f64> {
    if one.dot(&two) > 0.0 {
        return (one + two).normalize();
    }
    // At a sharp vertex the sum would consist of rounding errors. The difference is perpendicular to it.
    let half = (one - two).normalize();
    Vector2::new(-half.y, half.x) * turn
}

/// The slope of a direction, −π < slope ≤ π, in rad.
pub(super) fn slope_of(way: &Vector2<f64>) -> f64 {
    let angle = libm::atan2(way.y + 0.0, way.x);
    // A ceiling that falls by less than rounding.
    if angle == -PI { PI } else { angle }
}

impl End {
    pub(super) fn new(vertex: Vector2<f64>, across: Vector2<f64>) -> Self {
        // A piece without an end has it at ±∞, where a product with zero would be undefined.
        let at = if across == Vector2::x() { vertex.x } else { across.dot(&vertex) };
        Self { vertex, across, at }
    }

    /// Returns true if there is no end on this side.
    pub(crate) fn is_endless(&self) -> bool {
        self.at.is_infinite()
    }

    /// Signed distance of a point beyond the separating line of this end.
    fn beyond(&self, point: &Vector2<f64>) -> f64 {
        if self.across == Vector2::x() {
            point.x - self.at
        } else {
            self.across.dot(point) - self.at
        }
    }
}

/// A piece of ground: straight, or, for the centre of a disc, an arc about a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// Its start and its end.
    pub(crate) ends: [End; 2],
    /// A point on it; of an arc, its centre.
    pub(super) origin: Vector2<f64>,
    /// Its axes; of an arc, those in its middle.
    pub(crate) tangent: Vector2<f64>,
    pub(crate) normal: Vector2<f64>,
    pub(super) slope: f64,
    pub(crate) surface: Surface,
    /// Of an arc, in m; 0: it is straight.
    pub(super) radius: f64,
}

/// The adjacent pieces that a contact may touch.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ground {
    pub(crate) pieces: Vec<Piece>,
    /// Whether a piece does not face up, or is an arc. Then the nearest piece is the one under a point, and pieces may face each other.
    pub(crate) has_walls: bool,
    /// Whether the ground is a polyline. Then the vertices of its pieces are exact.
    pub(crate) is_polyline: bool,
    /// Height, in m, by which it is raised along its normals for the centre of a round contact; 0 for a point.
    pub(crate) raised: f64,
    /// The polyline that was raised.
    pub(crate) low: Option<Arc<Ground>>,
    /// Where its pieces are.
    pub(crate) places: ExtentTree,
    /// Height of the lowest vertex, in m; −∞ if a piece has no end.
    pub(crate) lowest: f64,
    /// The x of its concave vertices, in their order, in m; none of a raised ground.
    pub(super) concave: Vec<f64>,
}

/// The position of a point relative to the pieces of its terrain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// The contact of this point.
    pub(crate) contact: usize,
    /// Index of the piece that the point may touch, from 0. Before the first piece it is −1, beyond the last piece it is the number of
    /// pieces.
    pub(crate) piece: isize,
    /// Distances to the separating lines at the start and at the end of this piece, in m.
    pub(crate) sides: [f64; 2],
    /// Unit normals of these lines, along the terrain.
    pub(crate) across: [Vector2<f64>; 2],
}

impl Place {
    /// On terrain without ends.
    pub(crate) fn anywhere(contact: usize) -> Self {
        Self { contact, piece: 0, sides: [f64::INFINITY; 2], across: [Vector2::x(); 2] }
    }
}

impl Piece {
    /// The single piece of a contact's own terrain.
    pub(super) fn of_contact(contact: &Contact) -> Self {
        let (tangent, normal) = (contact.tangent(), contact.normal());
        let origin = contact.center();
        let across = if tangent.x > 0.0 { Vector2::x() } else { tangent };
        let ends = contact.segment.map(|along| match along.is_finite() {
            true => End::new(origin + tangent * along, across),
            false => {
                let far =
                    |axis: usize| if tangent[axis] == 0.0 { 0.0 } else { tangent[axis] * along };
                End { vertex: origin + Vector2::new(far(0), far(1)), across, at: along }
            }
        });
        let surface = Surface { speed: contact.surface_speed, ..Surface::default() };
        Self { ends, origin, tangent, normal, slope: contact.slope, surface, radius: 0.0 }
    }

    /// The piece from vertex `a` to vertex `b`.
    fn between(a: [f64; 2], b: [f64; 2]) -> Self {
        let slope = slope_of(&(Vector2::from(b) - Vector2::from(a)));
        let tangent = direction(slope);
        let end = |vertex: [f64; 2]| {
            End::new(vertex.into(), if tangent.x > 0.0 { Vector2::x() } else { tangent })
        };
        Self {
            ends: [end(a), end(b)],
            origin: a.into(),
            tangent,
            normal: Vector2::new(-tangent.y, tangent.x),
            slope,
            surface: Surface::default(),
            radius: 0.0,
        }
    }

    /// The part of this line between two points on it.
    fn part(&self, ends: [Vector2<f64>; 2]) -> Self {
        Self { ends: ends.map(|end| End::new(end, self.ends_across())), ..*self }
    }

    fn extent(&self) -> Extent {
        match self.corner() {
            Some(corner) => Extent::of([corner]).grown(self.radius),
            None => Extent::of(self.ends.map(|end| end.vertex)),
        }
    }

    /// The corner of the ground about which a disc turns on this piece, if it is an arc.
    pub(crate) fn corner(&self) -> Option<Vector2<f64>> {
        (self.radius > 0.0).then_some(self.origin)
    }

    /// Tangent and normal at the point that is nearest to this one.
    pub(crate) fn axes(&self, at: &Vector2<f64>) -> [Vector2<f64>; 2] {
        match self.corner().and_then(|corner| (at - corner).try_normalize(0.0)) {
            Some(normal) => [Vector2::new(normal.y, -normal.x), normal],
            None => [self.tangent, self.normal],
        }
    }

    /// Height of a point at `at` over the line, n·(at − origin), or its distance from the arc, in m.
    pub(crate) fn height(&self, at: &Vector2<f64>) -> f64 {
        match self.corner() {
            Some(corner) => libm::hypot(at.x - corner.x, at.y - corner.y) - self.radius,
            None => self.normal.dot(&(at - self.origin)),
        }
    }

    /// Distances of a point from the separating lines at both ends, in m.
    pub(crate) fn sides(&self, at: &Vector2<f64>) -> [f64; 2] {
        [self.ends[0].beyond(at), -self.ends[1].beyond(at)]
    }

    /// Distances of a point along the piece from its two vertices, in m; on an arc, from the rays to them.
    pub(crate) fn along(&self, at: &Vector2<f64>) -> [f64; 2] {
        if self.radius > 0.0 {
            return self.sides(at);
        }
        let [from, to] = self.ends.map(|end| self.tangent.dot(&(at - end.vertex)));
        [from, -to]
    }

    /// Distance of a point from the nearest point of the piece, in m, with an error of a few ε times its distance from the nearest vertex
    /// of the piece.
    fn distance(&self, at: &Vector2<f64>) -> f64 {
        if self.radius > 0.0 {
            return self.distance_from_arc(at);
        }
        let [before, after] = self.along(at).map(|side| (-side).max(0.0));
        libm::hypot(self.height(at), before.max(after))
    }

    fn distance_from_arc(&self, at: &Vector2<f64>) -> f64 {
        let from = |end: &End| libm::hypot(at.x - end.vertex.x, at.y - end.vertex.y);
        match self.sides(at).iter().all(|side| *side >= 0.0) {
            true => self.height(at).abs(),
            false => self.ends.iter().map(from).fold(f64::INFINITY, f64::min),
        }
    }

    /// As `distance`, with an error of a few ε times its value. The vertices of a straight piece must be exact.
    pub(super) fn precise_distance(&self, at: &Vector2<f64>) -> f64 {
        if self.radius > 0.0 {
            return self.distance_from_arc(at);
        }
        let [from, to] = self.ends.map(|end| end.vertex);
        for (near, far) in [(from, to), (to, from)] {
            if along(&near, &far, at) <= 0.0 {
                return libm::hypot(at.x - near.x, at.y - near.y);
            }
        }
        precise_area(&from, &to, at).abs() / libm::hypot(to.x - from.x, to.y - from.y)
    }

    /// Where a vertical at `x` meets the circle of an arc: the heights, in m.
    pub(crate) fn above(&self, x: f64) -> Option<[f64; 2]> {
        let corner = self.corner()?;
        let off = x - corner.x;
        let square = (self.radius - off) * (self.radius + off);
        (square >= 0.0).then(|| [1.0, -1.0].map(|side| corner.y + side * square.sqrt()))
    }

    /// Returns true if a vertical at `x` meets a straight piece.
    pub(crate) fn is_at_x(&self, x: f64) -> bool {
        let [from, to] = self.ends.map(|end| end.vertex.x);
        from.min(to) <= x && x <= from.max(to)
    }

    /// Normal of the separating lines at its ends, unless a bisector replaces it.
    fn ends_across(&self) -> Vector2<f64> {
        if self.tangent.x > 0.0 { Vector2::x() } else { self.tangent }
    }

    pub(super) fn faces_up(&self) -> bool {
        self.tangent.x > 0.0
    }
}

/// The boxes of these pieces.
pub(super) fn places_of(pieces: &[Piece]) -> ExtentTree {
    ExtentTree::new(pieces.iter().map(Piece::extent))
}

impl Ground {
    pub(super) fn new(pieces: Vec<Piece>, is_polyline: bool) -> Self {
        let has_walls = !pieces.iter().all(Piece::faces_up);
        let places = places_of(&pieces);
        let low = |end: End| if end.is_endless() { f64::NEG_INFINITY } else { end.vertex.y };
        let ends = pieces.iter().flat_map(|piece| piece.ends.map(low));
        let lowest = ends.fold(f64::INFINITY, f64::min);
        let (raised, low, concave) = (0.0, None, Vec::new());
        let mut ground =
            Self { pieces, has_walls, is_polyline, raised, low, places, lowest, concave };
        let bends = (1..ground.pieces.len()).filter(|k| ground.turn(*k) == Ordering::Greater);
        ground.concave = bends.map(|k| ground.pieces[k].ends[0].vertex.x).collect();
        for k in 1..ground.pieces.len() {
            let [one, two] = [ground.pieces[k - 1], ground.pieces[k]];
            if !(one.faces_up() && two.faces_up()) {
                let end = End::new(two.ends[0].vertex, ground.bisector(k));
                (ground.pieces[k - 1].ends[1], ground.pieces[k].ends[0]) = (end, end);
            }
        }
        ground
    }

    /// Unit normal of the bisector at the start of piece `k` > 0, along the terrain.
    fn bisector(&self, k: usize) -> Vector2<f64> {
        let [one, two] = [&self.pieces[k - 1], &self.pieces[k]].map(|piece| piece.tangent);
        bisector(one, two, if self.turn(k) == Ordering::Less { -1.0 } else { 1.0 })
    }

    /// The index of the piece that a point may touch: the piece under the point or, if there are walls, the nearest piece. A vertex belongs
    /// to the piece that follows; the last vertex belongs to the last piece.
    pub(crate) fn find(&self, at: &Vector2<f64>) -> isize {
        let pieces = &self.pieces;
        let last = pieces.len() - 1;
        let k = if self.has_walls {
            self.nearest_piece(at)
        } else {
            let after = pieces.partition_point(|piece| piece.ends[0].beyond(at) >= 0.0);
            after.max(1) - 1
        };
        let [from, to] = pieces[k].sides(at);
        if k == 0 && from < 0.0 {
            -1
        } else if k == last && to < 0.0 {
            last as isize + 1
        } else {
            k as isize
        }
    }

    /// Height above the line of a piece of the highest end of the pieces between these x, all in m; 0 if none is higher than `least`. One of
    /// these pieces is this piece, and all face up: beyond it, the ground comes above its line only behind a concave vertex.
    pub(crate) fn rise(&self, piece: &Piece, between: [f64; 2], least: f64) -> f64 {
        let next = self.concave.partition_point(|x| *x < between[0]);
        if self.concave.get(next).is_none_or(|x| *x > between[1]) {
            return 0.0;
        }
        let strip = Extent::of(between.map(|x| Vector2::new(x, 0.0)));
        let may = |place: &Extent| {
            place.is_over(&strip) && place.farthest(&piece.normal, &piece.origin) > least
        };
        let ends = self.places.of_which(may).flat_map(|k| self.pieces[k].ends);
        ends.map(|end| piece.height(&end.vertex)).filter(|rise| *rise > least).fold(0.0, f64::max)
    }

    /// The pieces on both sides of a convex vertex at this point, which is known up to `error` (m).
    pub(crate) fn convex_vertex(&self, at: &Vector2<f64>, error: f64) -> Option<[isize; 2]> {
        let near = usize::try_from(self.find(at)).ok()?.min(self.pieces.len() - 1);
        let is_here = |&k: &usize| {
            (1..self.pieces.len()).contains(&k)
                && (at - self.pieces[k].ends[0].vertex).amax() <= error
                && self.turn(k) == Ordering::Less
        };
        [near, near + 1].into_iter().find(is_here).map(|k| [k as isize - 1, k as isize])
    }

    /// As `find`, except in a convex vertex: there the result is the piece that faces up more, or the left one if both face up equally.
    pub(crate) fn find_up(&self, at: &Vector2<f64>, error: f64) -> isize {
        match self.convex_vertex(at, error) {
            Some([left, right]) => {
                let [one, other] = [left, right].map(|k| self.nearest(k).0.normal.y);
                if one >= other { left } else { right }
            }
            None => self.find(at),
        }
    }

    /// The nearest piece. If two adjacent pieces are equally near, the line that separates them decides: the piece on the side of the
    /// point.
    fn nearest_piece(&self, at: &Vector2<f64>) -> usize {
        let pieces = &self.pieces;
        if pieces.len() == 1 {
            return 0;
        }
        // `distance` has these rounding errors.
        let known = |piece: &Piece| {
            let [from, to] = piece.ends.map(|end| (at - end.vertex).amax());
            (piece.distance(at), DISTANCE_ROUNDINGS * f64::EPSILON * from.max(to))
        };
        let most = self.places.least(at, |k| {
            let (d, error) = known(&pieces[k]);
            d + error
        });
        let may_be_nearest = |&k: &usize| {
            let (d, error) = known(&pieces[k]);
            d - error <= most
        };
        let error = 2.0 * DISTANCE_ROUNDINGS * f64::EPSILON * (self.places.reach(at) + most);
        let near = Extent::of([*at]).grown(most + error);
        let near: SmallVec<[usize; 8]> = self.places.meeting(near).filter(may_be_nearest).collect();
        let candidates = || near.iter().rev().copied();
        let mut found = candidates();
        let Some(only) = found.next() else { return 0 };
        if found.next().is_none() {
            return only;
        }
        let precise = |k: usize| pieces[k].precise_distance(at);
        let least = candidates().map(precise).fold(f64::INFINITY, f64::min);
        let most = least * (1.0 + DISTANCE_ROUNDINGS * f64::EPSILON);
        let is_nearest = |k: &usize| precise(*k) <= most;
        let mut k = candidates().find(is_nearest).unwrap_or(only);
        while k > 0 && pieces[k].ends[0].beyond(at) < 0.0 && is_nearest(&(k - 1)) {
            k -= 1;
        }
        k
    }

    /// Whether a point is free (`Greater`), on the ground (`Equal`) or in it (`Less`). A point beyond the ends of the terrain is free.
    fn side(&self, at: &Vector2<f64>) -> Ordering {
        let Some(k) = usize::try_from(self.find(at)).ok().filter(|&k| k < self.pieces.len()) else {
            return Ordering::Greater;
        };
        let of_line = |k: usize| {
            let [from, to] = self.pieces[k].ends.map(|end| end.vertex);
            area(&from, &to, at).total_cmp(&0.0)
        };
        // The sides of two pieces that meet decide about all points near their vertex.
        let near = |j: &usize| {
            let [one, two] = [*j, k].map(|k| self.pieces[k].precise_distance(at));
            (one - two).abs() <= DISTANCE_ROUNDINGS * f64::EPSILON * one.max(two)
        };
        let neighbours = [k.checked_sub(1), Some(k + 1).filter(|&j| j < self.pieces.len())];
        let Some(j) = neighbours.into_iter().flatten().filter(|_| self.has_walls).find(near) else {
            return of_line(k);
        };
        let sides = [of_line(j), of_line(k)];
        match self.turn(j.max(k)) {
            Ordering::Less => sides[0].max(sides[1]),
            Ordering::Equal => sides[1],
            Ordering::Greater => sides[0].min(sides[1]),
        }
    }

    /// Whether an arc and the line beside it meet at the start of piece `k`, with one normal.
    pub(crate) fn is_smooth(&self, k: usize) -> bool {
        let before = k.checked_sub(1).and_then(|before| self.pieces.get(before));
        let (Some(before), Some(after)) = (before, self.pieces.get(k)) else { return false };
        before.radius.max(after.radius) > 0.0 && before.ends[1] == after.ends[0]
    }

    /// Whether the ground is convex (`Less`), straight or concave (`Greater`) at the start of piece `k` > 0.
    pub(super) fn turn(&self, k: usize) -> Ordering {
        if self.is_smooth(k) {
            return Ordering::Equal;
        }
        if self.raised > 0.0 {
            return Ordering::Greater; // every other vertex of a raised ground
        }
        let [before, after] = [self.pieces[k - 1].ends, self.pieces[k].ends];
        area(&before[0].vertex, &after[0].vertex, &after[1].vertex).total_cmp(&0.0)
    }

    /// Depth of a point in the ground of a polyline, in m: its distance from the nearest free point; if the ground is raised, how far the disc
    /// about this point reaches into the ground. Zero: it is free or on the ground.
    pub(crate) fn depth(&self, at: &Vector2<f64>) -> f64 {
        if let Some(low) = &self.low {
            let depth = low.depth(at);
            return if depth > 0.0 {
                self.raised + depth
            } else {
                (self.raised - low.nearest_distance(at)).max(0.0)
            };
        }
        if self.side(at) != Ordering::Less {
            return 0.0;
        }
        self.nearest_distance(at)
    }

    /// Distance of a point from the nearest point of a polyline, in m.
    fn nearest_distance(&self, at: &Vector2<f64>) -> f64 {
        self.pieces.iter().map(|piece| piece.precise_distance(at)).fold(f64::INFINITY, f64::min)
    }

    /// Distance of a point from the nearest point of the ground, in m; over a raised line without vertices, a lower bound of the distance from
    /// the line below it.
    pub(crate) fn distance(&self, at: &Vector2<f64>) -> f64 {
        if let Some(low) = &self.low {
            return low.distance(at);
        }
        let from = |piece: &Piece| match self.raised {
            0.0 => piece.distance(at),
            up => (piece.height(at) + up).abs(),
        };
        self.pieces.iter().map(from).fold(f64::INFINITY, f64::min)
    }

    /// Its convex vertices and its ends: the corners that a side of the body can meet.
    pub(crate) fn corners(&self) -> impl Iterator<Item = Vector2<f64>> {
        let count = self.pieces.len();
        let is_corner = move |k: usize| {
            k == 0 || k == count || self.pieces[k - 1].tangent.perp(&self.pieces[k].tangent) < 0.0
        };
        let end = move |k: usize| match k {
            0 => self.pieces[0].ends[0],
            k => self.pieces[k - 1].ends[1],
        };
        let all = (0..=count).filter(move |&k| is_corner(k)).map(end);
        all.filter(|end| !end.is_endless()).map(|end| end.vertex)
    }

    /// Piece `k`, or the last piece at that end if `k` lies beyond the end; and whether the result is piece `k`.
    pub(crate) fn nearest(&self, k: isize) -> (&Piece, bool) {
        let near = k.clamp(0, self.pieces.len() as isize - 1);
        (&self.pieces[near as usize], near == k)
    }

    /// The piece between whose separating lines a point lies; the search starts at piece `k`. This need not be the nearest piece, because a
    /// separating line is longer than the pieces that it separates.
    pub(crate) fn between_lines(&self, mut k: isize, at: &Vector2<f64>) -> isize {
        while self.place(0, k, at).sides[0] < 0.0 {
            k -= 1;
        }
        while self.place(0, k, at).sides[1] < 0.0 {
            k += 1;
        }
        k
    }

    /// Place of a point relative to piece `k`.
    pub(crate) fn place(&self, contact: usize, k: isize, at: &Vector2<f64>) -> Place {
        let ends = [&self.pieces[0], &self.pieces[self.pieces.len() - 1]];
        let (sides, across) = match usize::try_from(k).ok().map(|k| self.pieces.get(k)) {
            Some(Some(piece)) => (piece.sides(at), piece.ends.map(|end| end.across)),
            Some(None) => {
                ([ends[1].ends[1].beyond(at), f64::INFINITY], [ends[1].ends[1].across; 2])
            }
            None => ([f64::INFINITY, -ends[0].ends[0].beyond(at)], [ends[0].ends[0].across; 2]),
        };
        Place { contact, piece: k, sides, across }
    }
}

/// A contact on the piece of terrain under it.
pub(crate) struct Under {
    pub(crate) place: Place,
    /// Constants of the contact on this piece.
    pub(crate) geometry: ContactGeometry,
    /// Whether there is a piece under the contact. If there is none, the geometry is that of the nearest piece.
    pub(crate) exists: bool,
}

/// Checks the vertices and returns the pieces between the corners. A straight line of several materials has a piece for each of them.
/// `surfaces`: of each piece between two vertices, or none.
pub(crate) fn polyline(vertices: &[[f64; 2]], surfaces: &[Surface]) -> Result<Ground, Error> {
    let unusable = |field: String, value: String, allowed: &str| Error::Unusable {
        field,
        value,
        allowed: allowed.into(),
    };
    if vertices.len() < 2 || vertices.len() > MAX_VERTICES {
        let value = format!("[{} vertices]", vertices.len());
        let allowed = format!("2 to {MAX_VERTICES} vertices");
        return Err(unusable("terrain".into(), value, &allowed));
    }
    for (k, [x, y]) in vertices.iter().enumerate() {
        finite(format!("terrain.{}.x", k + 1), *x)?;
        finite(format!("terrain.{}.y", k + 1), *y)?;
    }
    if let Some(k) = vertices.windows(2).position(|pair| pair[0] == pair[1]) {
        let value = format!("{:?} twice", vertices[k]);
        return Err(unusable(
            format!("terrain.{}", k + 2),
            value,
            "a vertex must differ from the one before it",
        ));
    }
    if let Some((i, j)) = meeting(vertices, false) {
        let value = format!("[pieces {} and {} meet]", i + 1, j + 1);
        return Err(unusable(
            "terrain".into(),
            value,
            "a terrain must not meet itself; piece k goes from vertex k to vertex k + 1",
        ));
    }
    if !(surfaces.is_empty() || surfaces.len() + 1 == vertices.len()) {
        let value = format!("[{} entries]", surfaces.len());
        let allowed = format!("one for each of the {} pieces of the terrain", vertices.len() - 1);
        return Err(unusable("surfaces".into(), value, &allowed));
    }
    for (k, surface) in surfaces.iter().enumerate() {
        surface.validate(&format!("surfaces.{}.", k + 1))?;
    }
    let surface = |k: usize| surfaces.get(k).copied().unwrap_or_default();
    let corners = corners(vertices);
    for &k in corners.iter().skip(1).take(corners.len() - 2) {
        let [before, at, after] = [k - 1, k, k + 1].map(|k| Vector2::from(vertices[k]));
        let moving = [k - 1, k].into_iter().find(|&piece| surface(piece).speed != 0.0);
        if let Some(piece) = moving.filter(|_| area(&before, &at, &after) > 0.0) {
            let allowed = format!(
                "0 beside the concave vertex {}: give the contacts grounds of their own there, with a surface_speed",
                k + 1
            );
            let value = format!("{:?}", surface(piece).speed);
            return Err(unusable(format!("surfaces.{}.speed", piece + 1), value, &allowed));
        }
    }
    let mut pieces = Vec::new();
    for ends in corners.windows(2) {
        let line = Piece::between(vertices[ends[0]], vertices[ends[1]]);
        let mut from = ends[0];
        for to in ends[0] + 1..=ends[1] {
            if to == ends[1] || surface(to) != surface(from) {
                let part = line.part([from, to].map(|k| vertices[k].into()));
                pieces.push(Piece { surface: surface(from), ..part });
                from = to;
            }
        }
    }
    Ok(Ground::new(pieces, true))
}

/// The numbers of the vertices of a polyline without those on straight lines. Such a vertex changes no geometry: the two parts of the straight
/// line are on one line.
fn corners(vertices: &[[f64; 2]]) -> Vec<usize> {
    let (mut kept, mut from) = (vec![0], 0);
    for k in 1..vertices.len() {
        let on_line = |next: &[f64; 2]| {
            vertices[from + 1..=k].iter().all(|v| is_between(&vertices[from], next, v))
        };
        if !vertices.get(k + 1).is_some_and(on_line) {
            kept.push(k);
            from = k;
        }
    }
    kept
}

/// Whether a vertex lies on the straight line between two others, up to rounding errors.
fn is_between(a: &[f64; 2], b: &[f64; 2], vertex: &[f64; 2]) -> bool {
    let [a, b, v] = [a, b, vertex].map(|p| Vector2::from(*p));
    let (line, [before, after]) = (b - a, [v - a, b - v]);
    let [one, two] = [before, after].map(|side| line.dot(&side) / line.norm_squared());
    let nearer = if one < two { before } else { after };
    let known = v.amax() + two * a.amax() + one * b.amax();
    let off = (line / line.norm()).perp(&nearer).abs();
    one > 0.0 && two > 0.0 && off <= STRAIGHT_VERTEX * f64::EPSILON * known
}

/// The first two pieces of a polyline that meet elsewhere than at the common vertex of neighbours. `closed`: with a piece from the last
/// vertex to the first one.
pub(crate) fn meeting(vertices: &[[f64; 2]], closed: bool) -> Option<(usize, usize)> {
    if !closed && vertices.windows(2).all(|pair| pair[1][0] > pair[0][0]) {
        return None;
    }
    let total = vertices.len();
    let point = |k: usize| Vector2::from(vertices[k % total]);
    let area = |a: usize, b: usize, c: usize| area(&point(a), &point(b), &point(c));
    let apart = |one: [f64; 2], other: [f64; 2]| {
        let [[a, b], [c, d]] = [one, other].map(|[p, q]| [p.min(q), p.max(q)]);
        b < c || d < a
    };
    let turns_back = |i: usize, j: usize| {
        area(i, j, j + 1) == 0.0 && along(&point(j), &point(i), &point(j + 1)) >= 0.0
    };
    let count = if closed { total } else { total - 1 };
    (0..count).flat_map(|j| (0..j).map(move |i| (i, j))).find(|&(i, j)| {
        if i + 1 == j {
            return turns_back(i, j);
        }
        if closed && i == 0 && j + 1 == count {
            return turns_back(j, count);
        }
        let far = |axis: usize| {
            apart([point(i)[axis], point(i + 1)[axis]], [point(j)[axis], point(j + 1)[axis]])
        };
        let same_side = |a: usize, b: usize| {
            let [one, two] = [b, b + 1].map(|c| area(a, a + 1, c));
            (one > 0.0 && two > 0.0) || (one < 0.0 && two < 0.0)
        };
        !(far(0) || far(1) || same_side(i, j) || same_side(j, i))
    })
}

/// Rounding error of a point in its nominal position beside a vertex, in m.
pub(crate) fn place_error(at: &Vector2<f64>) -> f64 {
    SAME_VERTEX * (at.x.abs() + at.y.abs())
}
