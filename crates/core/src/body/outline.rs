//! The outline of a body: the polygon that its corners bound.

use nalgebra::Vector2;
use smallvec::SmallVec;

use crate::body::contact::Contact;
use crate::body::fields::PostureFields;
use crate::body::terrain::{MAX_VERTICES, meeting};
use crate::error::{Error, finite};
use crate::math::extents::Extent;
use crate::math::turn::{Turn, turned};
use crate::tolerance::{EDGE_DEPTH, SAME_VERTEX};

/// The polygon of a body in its nominal posture. Coordinates are relative to the centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Outline {
    sides: Vec<Side>,
    /// The largest distance of a corner from the centre of mass, in m.
    pub(crate) radius: f64,
    /// Depth in the body up to which a point counts as on its boundary, in m.
    pub(crate) depth: f64,
    /// Whether all corners are convex.
    pub(crate) is_convex: bool,
}

/// A side of the polygon, with the body on its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Side {
    from: Vector2<f64>,
    to: Vector2<f64>,
    along: Vector2<f64>,
    length: f64,
    /// Whether the corner of the body at its start, or its end, is concave: a corner of the ground comes there to another side.
    concave: [bool; 2],
    /// The number of the side, from 0: its place in the order of the given corners.
    index: usize,
    /// The coefficients of friction, restitution and tangential restitution of a corner of the ground on this side.
    pub(crate) coefficients: [f64; 3],
}

impl Side {
    /// Unit vector along the side, with the body on its left.
    pub(crate) fn along(&self) -> Vector2<f64> {
        self.along
    }

    /// Its two ends, in m.
    pub(crate) fn ends(&self) -> [Vector2<f64>; 2] {
        [self.from, self.to]
    }

    /// Whether the corners of the body at its two ends are concave.
    pub(crate) fn concave(&self) -> [bool; 2] {
        self.concave
    }

    /// Coordinates of a point along the side and into the body, in m.
    fn coordinates(&self, p: &Vector2<f64>) -> [f64; 2] {
        let from = p - self.from;
        [self.along.dot(&from), self.along.perp(&from)]
    }

    /// Depth of a moving point in the body below the side, in m, and the rate of this depth, in m/s: the smallest of the distances from the
    /// side and from the perpendiculars to the side at its two ends.
    pub(crate) fn depth(&self, p: &Vector2<f64>, v: &Vector2<f64>) -> [f64; 2] {
        let ([x, y], rate) = (self.coordinates(p), self.along.dot(v));
        let ends = [[y, self.along.perp(v)], [x, rate], [self.length - x, -rate]];
        ends.into_iter()
            .fold([f64::INFINITY; 2], |least, end| if end[0] < least[0] { end } else { least })
    }

    /// Whether a point that moves along a cubic with these control points, up to an error (m), never comes out at this side, and does not pass
    /// the perpendiculars at its ends.
    ///
    /// The derivative of the cubic has the control points 3 (yₖ₊₁ − yₖ) per duration. Its error is at most 3.1 times that of the cubic, per
    /// duration: differences above two errors leave the true rate positive.
    pub(crate) fn is_only_entered(&self, hull: &[Vector2<f64>; 4], error: f64) -> bool {
        let at = hull.map(|p| self.coordinates(&p));
        at.windows(2).all(|pair| pair[1][1] - pair[0][1] > 2.0 * error)
            && at.iter().all(|[x, _]| *x > error && *x < self.length - error)
    }

    /// The number of the side, from 0: the side begins or ends at the corner of this number.
    pub(crate) fn index(&self) -> usize {
        self.index
    }

    /// Distance of a point from the nearest point of the side, in m.
    pub(crate) fn distance(&self, p: &Vector2<f64>) -> f64 {
        self.square_of_distance(p).sqrt()
    }

    fn square_of_distance(&self, p: &Vector2<f64>) -> f64 {
        let [x, y] = self.coordinates(p);
        let beside = x - x.clamp(0.0, self.length);
        beside * beside + y * y
    }
}

impl Outline {
    /// The outline of a posture; `None` if the posture has no outline.
    pub(crate) fn new(fields: &PostureFields) -> Result<Option<Self>, Error> {
        let corners = &fields.outline;
        if corners.is_empty() {
            return Ok(None);
        }
        let double_area = checked_polygon("outline", corners)?;
        if corners.len() > MAX_VERTICES {
            return Err(Error::Unusable {
                field: "outline".into(),
                value: format!("[{} vertices]", corners.len()),
                allowed: format!("at most {MAX_VERTICES} vertices"),
            });
        }
        let center = Vector2::from(fields.center_of_mass);
        let count = corners.len();
        let point = |k: usize| Vector2::from(corners[k % count]) - center;
        let turn = |k: usize| (point(k + 1) - point(k)).perp(&(point(k + 2) - point(k + 1)));
        let side = |k: usize| {
            let mut concave = [k + count - 1, k].map(|k| turn(k) * double_area < 0.0);
            let (mut from, mut to) = (point(k), point(k + 1));
            if double_area <= 0.0 {
                (from, to) = (to, from);
                concave.reverse();
            }
            let (way, length) = (to - from, libm::hypot(to.x - from.x, to.y - from.y));
            let coefficients = coefficients(fields, [corners[k], corners[(k + 1) % count]]);
            Side { from, to, along: way / length, length, concave, index: k, coefficients }
        };
        let radius = (0..count).map(|k| point(k).norm()).fold(0.0, f64::max);
        let sides: Vec<Side> = (0..count).map(side).collect();
        let is_convex = (0..count).all(|k| turn(k) * double_area >= 0.0);
        Ok(Some(Self { sides, radius, depth: EDGE_DEPTH * radius, is_convex }))
    }

    /// Whether a thing in a box may be nearer than `way` (m) to the body, turned, with its centre of mass at `center`. It is not if the line of a
    /// side of a convex body separates them by more.
    pub(crate) fn near(
        &self,
        center: Vector2<f64>,
        turn: &Turn,
        way: f64,
    ) -> impl Fn(&Extent) -> bool + use<> {
        let known = self.is_convex && way < self.radius;
        let lines: SmallVec<[[Vector2<f64>; 2]; 8]> = self
            .sides
            .iter()
            .filter(|_| known)
            .map(|side| {
                let along = turned(turn, side.along);
                [Vector2::new(-along.y, along.x), center + turned(turn, side.from)]
            })
            .collect();
        move |place| lines.iter().all(|[inwards, at]| !(place.farthest(inwards, at) < -way))
    }

    /// Returns true if a point lies deeper in the body than the tolerance.
    pub(crate) fn holds(&self, p: &Vector2<f64>) -> bool {
        // The boundary is crossed an odd number of times on the way from p to infinity along x. Sides that meet have the same corner to the
        // bit, so that a way through a corner crosses both or neither.
        let crosses = |Side { from, to, .. }: &Side| {
            (from.y > p.y) != (to.y > p.y) && {
                let share = (p.y - from.y) / (to.y - from.y);
                p.x < from.x + share * (to.x - from.x)
            }
        };
        p.norm() < self.radius
            && self.sides.iter().filter(|side| crosses(side)).count() % 2 == 1
            && self.sides.iter().all(|side| side.distance(p) > self.depth)
    }

    /// The sides that the convex hull of these points may meet after each side is moved into the body by the tolerance. Each point is known
    /// up to `error` (m).
    pub(crate) fn met(
        &self,
        hull: &[Vector2<f64>; 4],
        error: f64,
    ) -> impl Iterator<Item = &Side> + use<'_> {
        let (hull, margin) = (*hull, error + self.depth);
        self.sides.iter().filter(move |side| {
            let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
            for p in &hull {
                for (axis, x) in side.coordinates(p).into_iter().enumerate() {
                    (low[axis], high[axis]) = (low[axis].min(x), high[axis].max(x));
                }
            }
            !(high[0] < -margin
                || low[0] > side.length + margin
                || high[1] < self.depth - error
                || low[1] > self.depth + error)
        })
    }

    /// Its sides.
    pub(crate) fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// The sides that meet this one in its concave corners.
    pub(crate) fn beside(&self, side: &Side) -> impl Iterator<Item = &Side> {
        let corners = (0..2).filter(|&end| side.concave[end]).map(|end| side.ends()[end]);
        let corners: Vec<_> = corners.collect();
        let (index, sides) = (side.index, self.sides.iter());
        sides.filter(move |other| {
            other.index != index && other.ends().iter().any(|end| corners.contains(end))
        })
    }

    /// The side that meets the side of this number at its start (0) or its end (1).
    pub(crate) fn next(&self, index: usize, end: usize) -> Option<&Side> {
        let corner = self.sides[index].ends()[end];
        self.sides.iter().find(|other| other.index != index && other.ends()[1 - end] == corner)
    }

    /// A point of this segment that lies deeper in the body than the tolerance: the middle between two of the places at which the segment
    /// crosses the lines of sides, or ends.
    pub(crate) fn pierced(&self, [from, to]: [Vector2<f64>; 2]) -> Option<Vector2<f64>> {
        let way = to - from;
        let nearest = (-from.dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        if (from + way * nearest).norm() >= self.radius {
            return None;
        }
        let crossing = |side: &Side| {
            let [[_, y], [_, z]] = [from, to].map(|p| side.coordinates(&p));
            ((y > 0.0) != (z > 0.0)).then(|| y / (y - z))
        };
        let mut places: Vec<f64> = self.sides.iter().filter_map(crossing).collect();
        places.extend([0.0, 1.0]);
        places.sort_by(f64::total_cmp);
        let mut middles = places.windows(2).map(|pair| from + way * (0.5 * (pair[0] + pair[1])));
        middles.find(|p| self.holds(p))
    }

    /// The side that is nearest to a point.
    pub(crate) fn nearest_side(&self, p: &Vector2<f64>) -> &Side {
        let all = self.sides.iter().map(|side| (side.square_of_distance(p), side));
        let nearest = all.min_by(|one, other| one.0.total_cmp(&other.0));
        nearest.unwrap_or_else(|| unreachable!("a polygon has sides")).1
    }
}

/// The smallest coefficients of the contacts at the two ends of a side, or of all contacts if there are none at its ends.
fn coefficients(fields: &PostureFields, ends: [[f64; 2]; 2]) -> [f64; 3] {
    let is_at = |[x, y]: &[f64; 2], [u, v]: [f64; 2]| {
        libm::hypot(x - u, y - v) <= SAME_VERTEX * (x.abs() + y.abs())
    };
    let at_end = |contact: &&Contact| ends.iter().any(|end| is_at(end, contact.point));
    let of = |contact: &Contact| {
        let restitution = contact.restitution.unwrap_or(fields.restitution);
        [contact.friction, restitution, contact.tangential_restitution]
    };
    let least = |one: [f64; 3], other: [f64; 3]| std::array::from_fn(|k| one[k].min(other[k]));
    let all = || fields.contacts.iter();
    let found = all().filter(at_end).map(of).reduce(least);
    found.or_else(|| all().map(of).reduce(least)).unwrap_or_default()
}

/// The vertices of a polygon without the last one where this is the first one again, as other programs close a ring.
pub(crate) fn opened(vertices: &[[f64; 2]]) -> &[[f64; 2]] {
    match vertices {
        [first, .., last] if vertices.len() > 3 && first == last => &vertices[..vertices.len() - 1],
        _ => vertices,
    }
}

/// Twice the area of a polygon, in m²: positive if its vertices are in counterclockwise order.
///
/// # Errors
///
/// Fewer than three vertices, one that is not finite, or edges that meet.
pub(crate) fn checked_polygon(field: &str, vertices: &[[f64; 2]]) -> Result<f64, Error> {
    let unusable = |value: String, allowed: &str| Error::Unusable {
        field: field.into(),
        value,
        allowed: allowed.into(),
    };
    for (k, [x, y]) in vertices.iter().enumerate() {
        finite(format!("{field}.{}.x", k + 1), *x)?;
        finite(format!("{field}.{}.y", k + 1), *y)?;
    }
    let count = vertices.len();
    if count < 3 {
        return Err(unusable(format!("[{count} vertices]"), "3 or more vertices"));
    }
    if let Some((i, j)) = meeting(vertices, true) {
        let allowed = "a polygon whose edges meet only at its vertices; edge k goes from vertex k to the next one";
        return Err(unusable(format!("[edges {} and {} meet]", i + 1, j + 1), allowed));
    }
    let from = Vector2::from(vertices[0]);
    let point = |k: usize| Vector2::from(vertices[k % count]) - from;
    Ok((0..count).map(|k| point(k).perp(&point(k + 1))).sum())
}

/// A polygon of uniform density.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UniformPolygon {
    /// Its area, in m²: positive if its vertices are in counterclockwise order.
    pub(crate) area: f64,
    /// Its centre of mass, in m.
    pub(crate) center: Vector2<f64>,
    /// Square of the radius of gyration about it, in m².
    pub(crate) gyration_squared: f64,
}

/// The centre of mass and the radius of gyration of a polygon of uniform density.
///
/// # Errors
///
/// As [`checked_polygon`]; no area.
pub(crate) fn uniform_polygon(field: &str, vertices: &[[f64; 2]]) -> Result<UniformPolygon, Error> {
    let (double_area, count) = (checked_polygon(field, vertices)?, vertices.len());
    let relative = |to: Vector2<f64>| -> Vec<Vector2<f64>> {
        vertices.iter().map(|vertex| Vector2::from(*vertex) - to).collect()
    };
    let sum = |points: &[Vector2<f64>], term: &dyn Fn(&Vector2<f64>, &Vector2<f64>) -> f64| {
        (0..count).map(|k| term(&points[k], &points[(k + 1) % count])).sum::<f64>()
    };
    let from = Vector2::from(vertices[0]);
    let points = relative(from);
    let moment = |axis: usize| sum(&points, &|p, q| (p[axis] + q[axis]) * p.perp(q));
    let center = from + Vector2::new(moment(0), moment(1)) / (3.0 * double_area);
    let points = relative(center);
    let gyration_squared =
        sum(&points, &|p, q| (p.dot(p) + p.dot(q) + q.dot(q)) * p.perp(q)) / (6.0 * double_area);
    let area = 0.5 * double_area;
    if gyration_squared > 0.0 && gyration_squared.is_finite() {
        return Ok(UniformPolygon { area, center, gyration_squared });
    }
    Err(Error::Unusable {
        field: field.into(),
        value: format!("[area {area:?}]"),
        allowed: "a polygon with an area".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::fields::GroundKind;
    use crate::math::random::Random;

    /// An L of two unit squares on the right of and above a third one, its corner at the origin.
    fn shape() -> Outline {
        of(vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]])
    }

    fn of(outline: Vec<[f64; 2]>) -> Outline {
        let fields = PostureFields {
            mass: 1.0,
            gyration_radius: 1.0,
            center_of_mass: [0.0, 0.0],
            contacts: vec![Contact::at(0.0, 0.0)],
            restitution: 0.0,
            gravity: 9.81,
            terrain: Vec::new(),
            surfaces: Vec::new(),
            ground: GroundKind::Own,
            outline,
        };
        Outline::new(&fields).unwrap().unwrap()
    }

    #[test]
    fn points_in_the_body_and_beside_it() {
        let shape = shape();
        for ([x, y], inside) in [
            ([0.5, 0.5], true),
            ([1.5, 0.5], true),
            ([0.5, 1.5], true),
            ([1.5, 1.5], false),
            ([-0.5, 0.5], false),
            ([1.0 + 1e-12, 1.5], false),
            ([1.0 - 1e-12, 1.5], false), // on the boundary, within the tolerance
            ([1.0 - 1e-6, 1.5], true),
        ] {
            assert_eq!(shape.holds(&Vector2::new(x, y)), inside, "{x} {y}");
        }
    }

    /// Points whose height equals that of a corner up to rounding errors, beside turned shapes. For comparison, the sum of the angles of
    /// the sides around a point shows whether the point is inside.
    #[test]
    fn a_point_at_the_height_of_a_corner() {
        let mut random = Random(7);
        let at_rest = shape();
        for _ in 0..2000 {
            let small = random.between(-1.0, 1.0) * f64::EPSILON;
            let angle = [small, random.between(-3.2, 3.2)][usize::from(random.bits() & 1 == 1)];
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let turned = |p: &Vector2<f64>| [cos * p.x - sin * p.y, sin * p.x + cos * p.y];
            let shape = of(at_rest.sides.iter().map(|side| turned(&side.from)).collect());
            for corner in &shape.sides {
                let y = corner.from.y + f64::EPSILON * random.between(-1.0, 1.0);
                let p = Vector2::new(random.between(-2.0, 2.0), y);
                let around = |Side { from, to, .. }: &Side| {
                    let (a, b) = (from - p, to - p);
                    libm::atan2(a.perp(&b), a.dot(&b))
                };
                let inside = shape.sides.iter().map(around).sum::<f64>() > 1.0;
                let off = shape.sides.iter().all(|side| side.distance(&p) > 1e-6);
                assert!(!off || shape.holds(&p) == inside, "{angle} {p}");
            }
        }
    }

    #[test]
    fn a_hull_that_crosses_a_side_is_seen() {
        let shape = shape();
        let met = |from: [f64; 2], to: [f64; 2]| {
            let [from, to] = [from, to].map(Vector2::from);
            let sides = shape.met(&[from, from, to, to], 0.0).map(Side::index);
            sides.collect::<Vec<_>>()
        };
        assert!(met([1.2, 1.2], [3.0, 1.2]).is_empty());
        assert!(met([1.0, 1.1], [1.0, 1.9]).is_empty(), "along a side");
        assert_eq!(met([1.5, 1.5], [1.5, 0.5]), [2]);
        assert_eq!(met([-1.0, 0.5], [3.0, 0.5]), [1, 5], "right through");
        assert_eq!(shape.nearest_side(&Vector2::new(1.5, 0.9)).index(), 2);
    }
}
