//! The ground of the centre of a disc: each piece of the ground moved along its normal by the radius R, and an arc of this radius about each
//! convex vertex and each end. Parts nearer than R to another piece are cut off.
//!
//! ```text
//!         ____                  V convex vertex, about which the disc turns: its centre is on an arc
//!       ,'    `.                J concave joint, in which it touches twice
//!      /   V----\----
//!  ___J    |
//! ---------'
//! ```
//!
//! A piece and the arc beside it have one normal where they meet. The ray from V along this normal separates the points over the one from
//! those over the other.

use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::Vector2;

use crate::body::fields::Surface;
use crate::body::terrain::{End, Ground, Piece, bisector, places_of, slope_of};
use crate::math::orientation::area;
use crate::tolerance::{PLACE_ON_PART, SAME_JOINT, SHORT_PART};

/// A part of the raised ground before anything is cut off: a line, or an arc about a corner, with its axes at the start.
#[derive(Debug, Clone, Copy)]
struct Part {
    /// A point of the line, R away from the ground; the centre of the arc.
    origin: Vector2<f64>,
    tangent: Vector2<f64>,
    normal: Vector2<f64>,
    /// In m; of an arc, its angle in rad.
    length: f64,
    /// The piece of the ground, or the piece before the corner, −1 at its start.
    piece: isize,
    is_arc: bool,
    surface: Surface,
}

/// An interval of a part that is kept.
#[derive(Debug, Clone, Copy)]
struct Kept {
    part: usize,
    from: f64,
    to: f64,
}

impl Part {
    /// Tangent and normal there; `s` as the length.
    fn axes(&self, s: f64) -> [Vector2<f64>; 2] {
        if !self.is_arc {
            return [self.tangent, self.normal];
        }
        if s == self.length && s == PI {
            return [-self.tangent, -self.normal];
        }
        let (sin, cos) = libm::sincos(s);
        [self.tangent * cos - self.normal * sin, self.normal * cos + self.tangent * sin]
    }

    fn at(&self, s: f64, radius: f64) -> Vector2<f64> {
        match self.is_arc {
            true => self.origin + self.axes(s)[1] * radius,
            false => self.origin + self.tangent * s,
        }
    }

    /// Whether a segment of the ground is farther away than the radius, by the boxes around both.
    fn is_far_from(&self, segment: &Piece, radius: f64) -> bool {
        let [p, q] = segment.ends.map(|end| end.vertex);
        let (from, to, room) = match self.is_arc {
            true => (self.origin, self.origin, 2.0 * radius),
            false => (self.origin, self.at(self.length, radius), radius),
        };
        (0..2).any(|axis| {
            let [low, high] = [p[axis].min(q[axis]), p[axis].max(q[axis])];
            low - from[axis].max(to[axis]) > room || from[axis].min(to[axis]) - high > room
        })
    }

    /// Whether no point of this segment of the ground is nearer than the radius, because it is on the other side of the line, or of the corner.
    fn is_clear_of(&self, line: Option<[Vector2<f64>; 2]>, segment: &Piece) -> bool {
        let [p, q] = segment.ends.map(|end| end.vertex);
        match line {
            Some([from, to]) => {
                segment.normal == self.normal
                    || [p, q].iter().all(|point| area(&from, &to, point) <= 0.0)
            }
            None => {
                let last = self.axes(self.length)[1];
                let behind = |point: &Vector2<f64>| {
                    let way = point - self.origin;
                    self.normal.dot(&way) <= 0.0 && last.dot(&way) <= 0.0
                };
                self.length < PI && behind(&p) && behind(&q)
            }
        }
    }

    /// Where this part may come nearer to a segment of the ground than the radius: where it crosses the circles about its ends, or the lines
    /// beside it.
    fn crossings(&self, segment: &Piece, radius: f64) -> Vec<f64> {
        let mut found = Vec::with_capacity(8);
        let m = segment.normal;
        for end in segment.ends {
            if self.is_arc {
                let way = end.vertex - self.origin;
                let distance = way.norm();
                if distance < 2.0 * radius {
                    let middle = libm::atan2(self.tangent.dot(&way), self.normal.dot(&way));
                    let half = libm::acos(distance / (2.0 * radius));
                    found.extend([middle - half, middle + half]);
                }
            } else {
                // On the line, the ground of the line is R below.
                let way = end.vertex - (self.origin - self.normal * radius);
                let (s, height) = (self.tangent.dot(&way), self.normal.dot(&way));
                let square = height * (2.0 * radius - height);
                if square > 0.0 {
                    found.extend([s - square.sqrt(), s + square.sqrt()]);
                }
            }
        }
        let from = segment.ends[0].vertex;
        for side in [1.0, -1.0] {
            if self.is_arc {
                let off = side - m.dot(&(self.origin - from)) / radius;
                if off.abs() <= 1.0 {
                    let middle = libm::atan2(m.dot(&self.tangent), m.dot(&self.normal));
                    found.extend([middle - libm::acos(off), middle + libm::acos(off)]);
                }
            } else {
                let slope = m.dot(&self.tangent);
                let low = self.origin - self.normal * radius - from;
                let off = radius * (side - m.dot(&self.normal)) - m.dot(&low);
                if slope != 0.0 {
                    found.push(off / slope);
                }
            }
        }
        if self.is_arc {
            found.iter_mut().for_each(|s| *s = s.rem_euclid(TAU));
        }
        found.retain(|s| 0.0 < *s && *s < self.length);
        found.sort_by(f64::total_cmp);
        found
    }

    /// The intervals of this part that are nearer than the radius to a segment of the ground.
    fn hidden_by(&self, segment: &Piece, radius: f64) -> impl Iterator<Item = [f64; 2]> {
        let mut places = self.crossings(segment, radius);
        places.insert(0, 0.0);
        places.push(self.length);
        let (part, segment) = (*self, *segment);
        let is_near = move |[from, to]: &[f64; 2]| {
            to > from && segment.precise_distance(&part.at(0.5 * (from + to), radius)) < radius
        };
        let pairs: Vec<[f64; 2]> = places.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        pairs.into_iter().filter(is_near)
    }
}

/// What is left of the interval from 0 to `length` without these.
fn left_of(length: f64, mut hidden: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    hidden.sort_by(|one, other| one[0].total_cmp(&other[0]));
    let (mut left, mut from) = (Vec::new(), 0.0_f64);
    for [start, end] in hidden {
        if start > from {
            left.push([from, start]);
        }
        from = from.max(end);
    }
    if length > from {
        left.push([from, length]);
    }
    left
}

/// The material of a corner: that of the pieces beside it if they have the same, otherwise that of the contact. Beside a piece that moves it
/// has no friction.
fn of_corner(beside: &[&Piece]) -> Surface {
    let first = beside[0].surface;
    let same = |of: fn(&Surface) -> Option<f64>| {
        of(&first).filter(|_| beside.iter().all(|piece| of(&piece.surface) == of(&first)))
    };
    let moves = beside.iter().any(|piece| piece.surface.speed != 0.0);
    Surface {
        friction: if moves { Some(0.0) } else { same(|surface| surface.friction) },
        restitution: same(|surface| surface.restitution),
        speed: 0.0,
    }
}

impl Ground {
    /// The lines and the arcs, from the start to the end of the ground.
    fn parts(&self, radius: f64) -> Vec<Part> {
        let count = self.pieces.len();
        let mut parts = Vec::with_capacity(2 * count + 1);
        for k in 0..=count {
            let before = k.checked_sub(1).map(|k| &self.pieces[k]);
            let after = self.pieces.get(k);
            let (vertex, tangent, normal, length) = match (before, after) {
                (None, Some(piece)) => (piece.ends[0].vertex, -piece.tangent, -piece.normal, PI),
                (Some(piece), None) => (piece.ends[1].vertex, piece.tangent, piece.normal, PI),
                (Some(one), Some(two)) => {
                    let bend = -one.tangent.perp(&two.tangent);
                    let is_convex = one.normal != two.normal && self.turn(k) == Ordering::Less;
                    let angle = libm::atan2(bend, one.tangent.dot(&two.tangent));
                    let length = if is_convex { angle } else { 0.0 };
                    (two.ends[0].vertex, one.tangent, one.normal, length)
                }
                (None, None) => continue,
            };
            if length > 0.0 && vertex.amax() < f64::INFINITY {
                let beside: Vec<&Piece> = before.into_iter().chain(after).collect();
                parts.push(Part {
                    origin: vertex,
                    tangent,
                    normal,
                    length,
                    piece: k as isize - 1,
                    is_arc: true,
                    surface: of_corner(&beside),
                });
            }
            if let Some(piece) = after {
                let [from, to] = piece.ends.map(|end| end.vertex);
                let has_start = from.amax() < f64::INFINITY;
                let start = if has_start { from } else { piece.origin };
                parts.push(Part {
                    origin: start + piece.normal * radius,
                    tangent: piece.tangent,
                    normal: piece.normal,
                    length: (to - from).norm(),
                    piece: k as isize,
                    is_arc: false,
                    surface: piece.surface,
                });
            }
        }
        parts
    }

    /// The intervals of the parts on which the disc touches nothing else, in their order.
    fn kept(&self, parts: &[Part], radius: f64) -> Vec<Kept> {
        let mut all = Vec::new();
        for (index, part) in parts.iter().enumerate() {
            let own = |k: isize| k == part.piece || part.is_arc && k == part.piece + 1;
            let line =
                (!part.is_arc).then(|| self.pieces[part.piece as usize].ends.map(|end| end.vertex));
            let others = self.pieces.iter().enumerate();
            let others = others.filter(|(k, piece)| {
                !own(*k as isize)
                    && !part.is_far_from(piece, radius)
                    && !part.is_clear_of(line, piece)
            });
            let hidden = others.flat_map(|(_, piece)| part.hidden_by(piece, radius)).collect();
            let unit = if part.is_arc { 1.0 } else { radius };
            for [from, to] in left_of(part.length, hidden) {
                if to - from > SHORT_PART * unit || [from, to] == [0.0, part.length] {
                    all.push(Kept { part: index, from, to });
                }
            }
        }
        all
    }

    /// The intervals that follow each other: those of a hollow that the disc cannot leave are left out.
    ///
    /// # Errors
    ///
    /// An interval that no other one follows, in words.
    fn in_turn(parts: &[Part], all: &[Kept], radius: f64) -> Result<Vec<Kept>, String> {
        if all.is_empty() {
            return Err("another one: it touches no piece of the terrain".into());
        }
        let (mut chain, mut next) = (Vec::with_capacity(all.len()), 0);
        loop {
            let now = all[next];
            chain.push(now);
            if next + 1 == all.len() {
                return Ok(chain);
            }
            let end = parts[now.part].at(now.to, radius);
            let away = |j: &usize| (parts[all[*j].part].at(all[*j].from, radius) - end).norm();
            let long = |part: usize| if parts[part].is_arc { 0.0 } else { parts[part].length };
            let follows = |j: &usize| {
                let rounding = f64::EPSILON * (long(now.part) + long(all[*j].part));
                away(j) <= SAME_JOINT * (radius + end.amax()) + PLACE_ON_PART * rounding
            };
            next = (next + 1..all.len()).find(follows).ok_or_else(|| {
                format!(
                    "another one: its centre has no way on from ({:?}, {:?}) m, where it touches the ground twice",
                    end.x, end.y
                )
            })?;
        }
    }

    /// The ground over which the centre of a disc of this radius (m) moves as a point.
    ///
    /// # Errors
    ///
    /// Why the disc does not fit, in words.
    pub(super) fn raised_by(&self, radius: f64) -> Result<Self, String> {
        let parts = self.parts(radius);
        let chain = if self.is_polyline {
            Self::in_turn(&parts, &self.kept(&parts, radius), radius)?
        } else {
            let whole = |(part, of): (usize, &Part)| Kept { part, from: 0.0, to: of.length };
            parts.iter().enumerate().map(whole).collect()
        };
        let mut pieces: Vec<Piece> =
            chain.iter().map(|kept| self.piece_of(&parts[kept.part], kept, radius)).collect();
        for k in 1..pieces.len() {
            let ends = self.joint([&chain[k - 1], &chain[k]], &parts, radius);
            [pieces[k - 1].ends[1], pieces[k].ends[0]] = ends;
        }
        for piece in pieces.iter().filter(|piece| piece.corner().is_none()) {
            let [from, to] = piece.ends.map(|end| end.vertex);
            if !(piece.tangent.dot(&(to - from)) > 0.0) {
                let [x, y] = [from.x, from.y];
                return Err(format!(
                    "another one: the disc touches a piece of the terrain only at ({x:?}, {y:?}) m, up to rounding"
                ));
            }
        }
        Ok(Self {
            places: places_of(&pieces),
            lowest: self.lowest + radius,
            pieces,
            has_walls: self.has_walls || parts.iter().any(|part| part.is_arc),
            is_polyline: self.is_polyline,
            raised: radius,
            concave: Vec::new(),
            low: self.is_polyline.then(|| Arc::new(self.clone())),
        })
    }

    /// A kept interval as a piece; its ends are still to be set where it meets others.
    fn piece_of(&self, part: &Part, kept: &Kept, radius: f64) -> Piece {
        if !part.is_arc {
            let low = self.pieces[part.piece as usize];
            let up = low.normal * radius;
            let ends = low.ends.map(|end| End { vertex: end.vertex + up, ..end });
            return Piece { ends, origin: low.origin + up, ..low };
        }
        let [tangent, normal] = part.axes(0.5 * (kept.from + kept.to));
        let end = |s: f64, at: f64| End { vertex: part.at(s, radius), across: part.axes(s)[0], at };
        Piece {
            ends: [end(kept.from, f64::NEG_INFINITY), end(kept.to, f64::INFINITY)],
            origin: part.origin,
            tangent,
            normal,
            slope: slope_of(&tangent),
            surface: part.surface,
            radius,
        }
    }

    /// The end of the first of two intervals and the start of the second, where they meet.
    fn joint(&self, [one, two]: [&Kept; 2], parts: &[Part], radius: f64) -> [End; 2] {
        let [before, after] = [&parts[one.part], &parts[two.part]];
        if !(before.is_arc || after.is_arc) {
            let [n, m] = [before.normal, after.normal];
            let vertex = match after.piece == before.piece + 1 {
                true => {
                    let low = self.pieces[after.piece as usize].ends[0].vertex;
                    low + (n + m) / (1.0 + n.dot(&m)) * radius
                }
                false => before.at(one.to, radius),
            };
            return [End::new(vertex, bisector(before.tangent, after.tangent, 1.0)); 2];
        }
        let meets = two.part == one.part + 1 && one.to == before.length && two.from == 0.0;
        let vertex = if before.is_arc && meets { after.origin } else { before.at(one.to, radius) };
        let end = |part: &Part, s: f64| {
            let (across, from) = (part.axes(s)[0], if part.is_arc { part.origin } else { vertex });
            End { vertex, across, at: across.dot(&from) }
        };
        if !meets {
            return [end(before, one.to), end(after, two.from)];
        }
        // A line and the arc beside it have one normal here.
        let [line, arc] = if before.is_arc { [after, before] } else { [before, after] };
        [End { vertex, across: line.tangent, at: line.tangent.dot(&arc.origin) }; 2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::terrain::polyline;
    use crate::math::random::Random;

    #[test]
    fn between_floor_and_wall_the_centre_is_exactly_one_radius_away_from_both() {
        let low = polyline(&[[-3.0, 4.0], [-1.0, 0.0], [2.0, 0.0], [2.0, 3.0]], &[]).unwrap();
        let high = low.raised_by(0.25).unwrap();
        assert_eq!(high.pieces.len(), 5);
        assert_eq!(high.pieces[2].ends[1].vertex, Vector2::new(1.75, 0.25));
        for (one, other) in low.pieces.iter().zip(&high.pieces[1..]) {
            assert_eq!((one.tangent, one.slope), (other.tangent, other.slope));
            let at = Vector2::new(0.3, 0.7);
            assert!((one.height(&at) - other.height(&at) - 0.25).abs() < 1e-15);
        }
    }

    /// Every point of the raised ground is one radius away from the ground, its pieces meet, and all free points of this distance are on it.
    #[test]
    fn the_raised_ground_of_a_disc_keeps_its_distance() {
        let mut random = Random(8);
        let (mut hidden, mut arcs) = (0, 0);
        for run in 0..300 {
            let count = 2 + run % 9;
            let mut x = 0.0;
            let vertices: Vec<[f64; 2]> = (0..=count)
                .map(|_| {
                    x += random.between(0.0, 1.0) + if run % 3 == 0 { 0.0 } else { 1e-3 };
                    [x, random.between(-0.5, 0.5)]
                })
                .collect();
            let low = polyline(&vertices, &[]).unwrap();
            let radius = random.between(0.01, 0.8);
            let high = low.raised_by(radius).unwrap();
            hidden += 2 * low.pieces.len() + 1 - high.pieces.len().min(2 * low.pieces.len() + 1);
            arcs += high.pieces.iter().filter(|piece| piece.corner().is_some()).count();
            let near = |at: &Vector2<f64>| {
                low.pieces
                    .iter()
                    .map(|piece| piece.precise_distance(at))
                    .fold(f64::INFINITY, f64::min)
            };
            for piece in &high.pieces {
                let [from, to] = piece.ends.map(|end| end.vertex);
                let middle = match piece.corner() {
                    Some(corner) => corner + piece.normal * radius,
                    None => (from + to) * 0.5,
                };
                for at in [from, middle, to] {
                    assert!((near(&at) - radius).abs() < 1e-9, "{vertices:?} {radius} {at}");
                }
            }
            for pair in high.pieces.windows(2) {
                assert!((pair[0].ends[1].vertex - pair[1].ends[0].vertex).amax() < 1e-12);
            }
            for _ in 0..20 {
                let at = Vector2::new(random.between(vertices[0][0], x), random.between(-0.5, 2.0));
                let off = high.pieces.iter().map(|piece| piece.precise_distance(&at));
                let off = off.fold(f64::INFINITY, f64::min);
                if low.depth(&at) == 0.0 && near(&at) > radius {
                    assert!(
                        (near(&at) - radius - off).abs() < 1e-9,
                        "{vertices:?} {radius} {at} {off}"
                    );
                }
            }
        }
        assert!(hidden > 300 && arcs > 300, "{hidden} {arcs}");
    }

    #[test]
    fn a_kerb_hides_its_own_side() {
        // The floor ends where the corner of the kerb is one radius away: x = −√(h (2R − h)).
        for h in [1e-12, 0.3, 0.99] {
            let low = polyline(&[[-5.0, 0.0], [0.0, 0.0], [0.0, h], [5.0, h]], &[]).unwrap();
            let high = low.raised_by(1.0).unwrap();
            let corners: Vec<_> = high.pieces.iter().map(Piece::corner).collect();
            assert_eq!(corners.iter().flatten().count(), 3);
            assert_eq!(corners[2], Some(Vector2::new(0.0, h)));
            let joint = high.pieces[1].ends[1].vertex;
            let exact = -(h * (2.0 - h)).sqrt();
            assert!((joint.x - exact).abs() < 1e-15 && joint.y == 1.0, "{joint}");
            assert!(high.is_smooth(1) && !high.is_smooth(2) && high.is_smooth(3));
            assert_eq!(high.depth(&Vector2::new(-3.0, 0.75)), 0.25);
            assert_eq!(high.depth(&Vector2::new(-3.0, -0.5)), 1.5);
        }
    }
}
