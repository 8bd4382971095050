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
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use nalgebra::Vector2;

use crate::body::contact::{Contact, direction};
use crate::body::fields::{PostureFields, Surface};
use crate::body::geometry::ContactGeometry;
use crate::error::{Error, finite};
use crate::math::orientation::{along, area, precise_area};
use crate::tolerance::{DISC_POINT, SAME_VERTEX, STRAIGHT_VERTEX};

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

/// The slope of a tangent, −π < slope ≤ π, in rad.
pub(super) fn slope_of(tangent: &Vector2<f64>) -> f64 {
    let quarter = [(Vector2::x(), 0.0), (Vector2::y(), FRAC_PI_2), (-Vector2::y(), -FRAC_PI_2)];
    let exact = quarter.into_iter().find_map(|(axis, angle)| (*tangent == axis).then_some(angle));
    let slope = exact.unwrap_or_else(|| libm::atan2(tangent.y, tangent.x));
    if slope == -PI { PI } else { slope }
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
    fn of_contact(contact: &Contact) -> Self {
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
        let angle = libm::atan2(b[1] - a[1] + 0.0, b[0] - a[0]);
        // A ceiling that falls by less than rounding.
        let slope = if angle == -PI { PI } else { angle };
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

    fn faces_up(&self) -> bool {
        self.tangent.x > 0.0
    }
}

impl Ground {
    fn new(pieces: Vec<Piece>, is_polyline: bool) -> Self {
        let has_walls = !pieces.iter().all(Piece::faces_up);
        let mut ground = Self { pieces, has_walls, is_polyline, raised: 0.0, low: None };
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
        let most =
            pieces.iter().map(known).map(|(d, error)| d + error).fold(f64::INFINITY, f64::min);
        let may_be_nearest = |&k: &usize| {
            let (d, error) = known(&pieces[k]);
            d - error <= most
        };
        let candidates = || (0..pieces.len()).rev().filter(may_be_nearest);
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

/// Sets the slope and the segment of a contact from the terrain. If the user gave them, they must be equal to these. `raised`: the same terrain
/// for the centre of the contact, if it is a disc.
pub(crate) fn place_on(
    ground: &Ground,
    raised: &Ground,
    contact: &mut Contact,
    at: &str,
) -> Result<(), Error> {
    let center = contact.center.map(Vector2::from);
    let over = center.map(|center| raised.nearest(raised.find(&center)).0);
    // A disc over a corner touches there.
    if let (Some(center), Some(arc)) = (center, over.filter(|piece| piece.corner().is_some())) {
        let [tangent, normal] = arc.axes(&center);
        contact.turn_to(&normal);
        return set_line(contact, slope_of(&tangent), [f64::NEG_INFINITY, f64::INFINITY], at);
    }
    let (name, [x, y]) = match contact.center {
        Some(center) => ("center", center),
        None => ("point", contact.point),
    };
    let (pieces, point) = (&ground.pieces, Vector2::new(x, y));
    let found = usize::try_from(ground.find_up(&point, place_error(&point))).unwrap_or(usize::MAX);
    let is_below = |line: &Piece, low: &Piece| {
        low.normal == line.normal && low.origin + low.normal * raised.raised == line.origin
    };
    let below = over.and_then(|line| pieces.iter().find(|low| is_below(line, low)));
    let Some(piece) = below.or_else(|| pieces.get(found)) else {
        let (low, high) = (pieces[0].ends[0].vertex.x, pieces[pieces.len() - 1].ends[1].vertex.x);
        let (field, value, allowed) = if ground.has_walls {
            (
                name.into(),
                format!("({x:?}, {y:?})"),
                "a point between the ends of the terrain".into(),
            )
        } else {
            let allowed = format!("from {low:?} to {high:?}, over the terrain");
            (format!("{name}.x"), format!("{x:?}"), allowed)
        };
        return Err(Error::Unusable { field: format!("{at}{field}"), value, allowed });
    };
    contact.turn_to(&piece.normal);
    let away = piece.height(&point).abs();
    let touches = away <= DISC_POINT * (x.abs() + y.abs() + contact.radius);
    if contact.is_round() && contact.center.is_none() && !touches {
        return Err(Error::Unusable {
            field: format!("{at}point"),
            value: format!("({x:?}, {y:?})"),
            allowed: format!(
                "on its ground, which is {away:?} m away: only a disc with a center need not touch in the nominal posture"
            ),
        });
    }
    let end = |side: usize| {
        if piece.faces_up() {
            (piece.ends[side].vertex.x - x) / piece.tangent.x
        } else if side == 0 {
            -piece.along(&point)[0]
        } else {
            piece.along(&point)[1]
        }
    };
    // Where there are walls, the nearest point of the piece may be its end.
    set_line(contact, piece.slope, [end(0).min(0.0), end(1).max(0.0)], at)
}

/// Sets the slope and the segment of a contact, as far as the user left them out.
fn set_line(contact: &mut Contact, slope: f64, segment: [f64; 2], at: &str) -> Result<(), Error> {
    let [x, y] = contact.point;
    let plain = Contact::at(x, y);
    for (field, given, left_out, own) in [
        ("slope", vec![contact.slope], vec![plain.slope], vec![slope]),
        ("segment", contact.segment.to_vec(), plain.segment.to_vec(), segment.to_vec()),
    ] {
        if given != left_out && given != own {
            return Err(Error::Unusable {
                field: format!("{at}{field}"),
                value: format!("{given:?}"),
                allowed: "left out, because the terrain of the posture determines it".into(),
            });
        }
    }
    (contact.slope, contact.segment) = (slope, segment);
    Ok(())
}

/// Checks what a posture with round contacts must not have.
///
/// # Errors
///
/// A radius out of range, an outline.
pub(crate) fn suits_rounds(fields: &PostureFields) -> Result<(), Error> {
    for (i, contact) in fields.contacts.iter().enumerate() {
        contact.validate_radius(&format!("contacts.{}.", i + 1))?;
        if !contact.is_round() {
            continue;
        }
        if !fields.outline.is_empty() {
            return Err(Error::Unusable {
                field: "outline".into(),
                value: format!("[{} vertices]", fields.outline.len()),
                allowed: format!(
                    "left out, because contacts.{}.radius = {:?} > 0: a body with round contacts has no outline",
                    i + 1,
                    contact.radius
                ),
            });
        }
    }
    Ok(())
}

/// The ground of each contact on this terrain, raised by its radius.
///
/// # Errors
///
/// A disc that does not fit.
pub(crate) fn raised(ground: &Ground, contacts: &[Contact]) -> Result<Vec<Ground>, Error> {
    let mut all: Vec<Ground> = Vec::with_capacity(contacts.len());
    for (i, contact) in contacts.iter().enumerate() {
        let at = format!("contacts.{}.", i + 1);
        contact.validate_radius(&at)?;
        let same = contacts[..i].iter().position(|other| other.radius == contact.radius);
        let raised = match same {
            Some(j) => all[j].clone(),
            None if !contact.is_round() => ground.clone(),
            None => ground.raised_by(contact.radius).map_err(|allowed| Error::Unusable {
                field: format!("{at}radius"),
                value: format!("{:?}", contact.radius),
                allowed,
            })?,
        };
        all.push(raised);
    }
    Ok(all)
}

/// The ground shared by all contacts, the line with their slope through the lowest contact; for each contact, if one is round.
pub(crate) fn shared(fields: &PostureFields) -> Result<Vec<Ground>, Error> {
    let unusable = |field: String, value: String, allowed: &str| Error::Unusable {
        field,
        value,
        allowed: allowed.into(),
    };
    if !fields.terrain.is_empty() {
        let value = "shared".into();
        return Err(unusable(
            "ground".into(),
            value,
            "left out where there is a terrain, which is shared anyway",
        ));
    }
    let first = &fields.contacts[0];
    let normal = first.normal();
    let mut lowest = first;
    for (i, contact) in fields.contacts.iter().enumerate() {
        let at = |field: &str| format!("contacts.{}.{field}", i + 1);
        if contact.slope != first.slope {
            let value = format!("{:?}", contact.slope);
            return Err(unusable(
                at("slope"),
                value,
                "the slope of contacts.1, because the ground is shared",
            ));
        }
        if contact.segment != [f64::NEG_INFINITY, f64::INFINITY] {
            let value = format!("{:?}", contact.segment);
            return Err(unusable(
                at("segment"),
                value,
                "left out, because the ground is shared and has no ends",
            ));
        }
        if contact.surface_speed != first.surface_speed {
            let value = format!("{:?}", contact.surface_speed);
            return Err(unusable(
                at("surface_speed"),
                value,
                "the surface_speed of contacts.1, because the ground is shared",
            ));
        }
        if normal.dot(&(Vector2::from(contact.point) - Vector2::from(lowest.point))) < 0.0 {
            lowest = contact;
        }
    }
    let under =
        |contact: &Contact| of_line(&Contact { radius: contact.radius, center: None, ..*lowest });
    Ok(match fields.contacts.iter().any(Contact::is_round) {
        true => fields.contacts.iter().map(under).collect(),
        false => vec![of_line(lowest)],
    })
}

/// The line of a contact, raised by its radius.
fn of_line(contact: &Contact) -> Ground {
    Ground { raised: contact.radius, ..Ground::new(vec![Piece::of_contact(contact)], false) }
}

/// The corners of these grounds that a side of a body can meet, in a fixed order, each once.
pub(crate) fn corners_of(grounds: &[Ground]) -> Vec<Vector2<f64>> {
    let mut corners: Vec<_> = grounds.iter().flat_map(Ground::corners).collect();
    corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    corners.dedup();
    corners
}

/// The terrain of each contact, for a disc with arcs about its ends. The list is empty if no piece has ends.
///
/// # Errors
///
/// Ends of the ground of a disc that are at one place, up to rounding.
pub(crate) fn own(contacts: &[Contact]) -> Result<Vec<Ground>, Error> {
    let is_endless = |contact: &Contact| contact.segment == [f64::NEG_INFINITY, f64::INFINITY];
    if contacts.iter().all(is_endless) {
        return Ok(Vec::new());
    }
    let of = |(i, contact): (usize, &Contact)| {
        if !contact.is_round() || is_endless(contact) {
            return Ok(of_line(contact));
        }
        let low = of_line(&Contact { radius: 0.0, center: None, ..*contact });
        low.raised_by(contact.radius).map_err(|_| Error::Unusable {
            field: format!("contacts.{}.segment", i + 1),
            value: format!("{:?}", contact.segment),
            allowed: "ends that rounding keeps apart at this place".into(),
        })
    };
    contacts.iter().enumerate().map(of).collect()
}
