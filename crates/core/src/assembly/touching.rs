//! The contacts between polygons, and between polygons and the ground.
//!
//! Each body lies on the left of its sides, as the ground does of its own. Two sides are *flush* if their directions are opposite and the ends of
//! their overlap have the same place on both: the forces of a flush pair are those of two contacts, at the ends of the overlap. A corner that lies
//! within a side, and whose own sides are not flush with it, is one contact, with the normal of the side. Two corners that meet, and sides that
//! meet in a point only, have no normal in common, and are no contact.

use nalgebra::Vector2;

use crate::tolerance::TOUCHING_SIDES;

/// A side, with the body on its left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    from: Vector2<f64>,
    along: Vector2<f64>,
    length: f64,
}

/// A place where two polygons touch, and the unit normal there, into the first one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touch {
    pub(super) point: Vector2<f64>,
    pub(super) normal: Vector2<f64>,
}

/// Sides of a closed polygon, or of the open line of the ground.
#[derive(Debug, Clone)]
pub(super) struct Sides {
    sides: Vec<Side>,
    closed: bool,
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Side {
    /// Coordinates of a point along the side and into the body, in m.
    fn coordinates(&self, p: &Vector2<f64>) -> [f64; 2] {
        let from = p - self.from;
        [self.along.dot(&from), self.along.perp(&from)]
    }

    fn to(&self) -> Vector2<f64> {
        self.from + self.along * self.length
    }

    /// The ends of the overlap with a flush side of another body, in coordinates along this side.
    fn overlap(&self, other: &Self, slack: f64) -> Option<[f64; 2]> {
        // The other one begins where it is further along.
        let ([high, above], [low, below]) =
            (self.coordinates(&other.from), self.coordinates(&other.to()));
        let ends = [low.max(0.0), high.min(self.length)];
        let turned = self.along.dot(&other.along) < 0.0;
        if !turned || ends[1] - ends[0] <= slack {
            return None;
        }
        // Distance of the other side at both ends of the overlap.
        let at = |x: f64| below + (above - below) * (x - low) / (high - low);
        ends.iter().all(|x| at(*x).abs() <= slack).then_some(ends)
    }
}

impl Sides {
    /// Of corners in order, with the body on the left.
    pub(super) fn new(corners: &[[f64; 2]], closed: bool) -> Self {
        let count = corners.len();
        let point = |k: usize| Vector2::from(corners[k % count]);
        let sides = (0..if closed { count } else { count - 1 })
            .map(|k| {
                let (from, along) = (point(k), point(k + 1) - point(k));
                let length = along.norm();
                Side { from, along: along / length, length }
            })
            .collect();
        let bound = |pick: fn(f64, f64) -> f64| {
            corners.iter().map(|p| Vector2::from(*p)).reduce(|a, b| a.zip_map(&b, pick))
        };
        let [mut low, high] = [bound(f64::min), bound(f64::max)].map(Option::unwrap_or_default);
        if !closed {
            // The ground reaches down.
            low.y = f64::NEG_INFINITY;
        }
        Self { sides, closed, low, high }
    }

    /// Whether the boxes around both come closer than `slack`.
    fn near(&self, other: &Self, slack: f64) -> bool {
        let apart = |axis: usize| {
            self.low[axis] > other.high[axis] + slack || other.low[axis] > self.high[axis] + slack
        };
        !(apart(0) || apart(1))
    }

    /// Where this body touches another one, with the normals into this one. `size`: of the smaller body.
    pub(super) fn touches(&self, other: &Self, size: f64) -> Vec<Touch> {
        let slack = TOUCHING_SIDES * size;
        let mut found: Vec<Touch> = Vec::new();
        if !self.near(other, slack) {
            return found;
        }
        let mut add = |point: Vector2<f64>, normal: Vector2<f64>| {
            let same = |known: &Touch| {
                (known.point - point).norm() <= slack && known.normal.dot(&normal) > 0.5
            };
            if !found.iter().any(same) {
                found.push(Touch { point, normal });
            }
        };
        for side in &self.sides {
            // Into this body: to the left of its side.
            let normal = Vector2::new(-side.along.y, side.along.x);
            for facing in &other.sides {
                if let Some(ends) = side.overlap(facing, slack) {
                    // The tangent (n_y, −n_x) is the direction of the side: first its end on the left.
                    for x in ends {
                        add(side.from + side.along * x, normal);
                    }
                }
            }
        }
        for (sides, others, sign) in [(self, other, -1.0), (other, self, 1.0)] {
            for (point, side) in sides.corners_within(others, slack) {
                add(point, Vector2::new(-side.along.y, side.along.x) * sign);
            }
        }
        found
    }

    /// Corners of this polygon that lie within a side of another one, and are not at a flush side.
    fn corners_within(&self, other: &Self, slack: f64) -> Vec<(Vector2<f64>, Side)> {
        let count = self.sides.len();
        let first = usize::from(!self.closed);
        let mut found = Vec::new();
        for k in first..count {
            let (before, after) = (self.sides[(k + count - 1) % count], self.sides[k]);
            for side in &other.sides {
                let [x, y] = side.coordinates(&after.from);
                if x <= slack || x >= side.length - slack || y.abs() > slack {
                    continue;
                }
                let flush = [before, after].iter().any(|own| own.overlap(side, slack).is_some());
                // Both sides of the corner leave to the outside.
                let outside =
                    [before.from, after.to()].iter().all(|p| side.coordinates(p)[1] <= slack);
                if !flush && outside {
                    found.push((after.from, *side));
                }
            }
        }
        found
    }

    /// Returns true if this body overlaps another one. `size`: of the smaller one.
    pub(super) fn overlaps(&self, other: &Self, size: f64) -> bool {
        let slack = TOUCHING_SIDES * size;
        if !self.near(other, slack) {
            return false;
        }
        let crosses = |one: &Side, two: &Side| {
            let across = |side: &Side, of: &Side| {
                let [[a, s], [b, t]] = [of.from, of.to()].map(|p| side.coordinates(&p));
                // Where the other side passes this line, and whether it does so clearly.
                let x = a + (b - a) * s / (s - t);
                (s > slack && t < -slack || s < -slack && t > slack)
                    && x > slack
                    && x < side.length - slack
            };
            across(one, two) && across(two, one)
        };
        if self.sides.iter().any(|one| other.sides.iter().any(|two| crosses(one, two))) {
            return true;
        }
        let enters = |of: &Self, within: &Self| {
            let mut points = of.sides.iter().flat_map(|side| {
                // A point just inside the middle of a side: sides of two bodies may coincide.
                let inward = Vector2::new(-side.along.y, side.along.x);
                [side.from, side.from + side.along * (0.5 * side.length) + inward * (4.0 * slack)]
            });
            points.any(|p| within.depth(&p) > slack)
        };
        enters(self, other) || enters(other, self)
    }

    /// Depth of a point in the body: its distance from the boundary; zero outside.
    fn depth(&self, p: &Vector2<f64>) -> f64 {
        let mut inside = false;
        let mut least = f64::INFINITY;
        for side in &self.sides {
            let (from, to) = (side.from, side.to());
            // A ray upwards. Of the ground, whose line is open, what is below the line is inside.
            if (from.x > p.x) != (to.x > p.x) {
                let y = from.y + (to.y - from.y) * (p.x - from.x) / (to.x - from.x);
                inside ^= y > p.y;
            }
            let x = side.along.dot(&(p - from)).clamp(0.0, side.length);
            least = least.min((from + side.along * x - p).norm());
        }
        if inside { least } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64) -> Sides {
        Sides::new(&[[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]], true)
    }

    #[test]
    fn places_of_contacts() {
        let at = |touches: Vec<Touch>| {
            touches
                .iter()
                .map(|t| [t.point.x, t.point.y, t.normal.x, t.normal.y])
                .collect::<Vec<_>>()
        };
        // One on the other, shifted: two contacts, the left one first.
        let up = at(square(0.25, 1.0).touches(&square(0.0, 0.0), 1.0));
        assert_eq!(up, [[0.25, 1.0, 0.0, 1.0], [1.0, 1.0, 0.0, 1.0]]);
        // Side by side; corner to corner; apart.
        let beside = at(square(1.0, 0.0).touches(&square(0.0, 0.0), 1.0));
        assert_eq!(beside, [[1.0, 1.0, 1.0, 0.0], [1.0, 0.0, 1.0, 0.0]]);
        assert!(square(1.0, 1.0).touches(&square(0.0, 0.0), 1.0).is_empty());
        assert!(square(1.5, 0.0).touches(&square(0.0, 0.0), 1.0).is_empty());
        // On its corner: one contact, from both bodies.
        let diamond = Sides::new(&[[0.5, 1.0], [1.0, 1.5], [0.5, 2.0], [0.0, 1.5]], true);
        assert_eq!(at(diamond.touches(&square(0.0, 0.0), 1.0)), [[0.5, 1.0, 0.0, 1.0]]);
        assert_eq!(at(square(0.0, 0.0).touches(&diamond, 1.0)), [[0.5, 1.0, 0.0, -1.0]]);
        // On the ground, which lies on the left of its line from right to left.
        let ground = Sides::new(&[[5.0, 0.0], [-5.0, 0.0]], false);
        let stands = at(square(0.0, 0.0).touches(&ground, 1.0));
        assert_eq!(stands, [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
    }

    #[test]
    fn bodies_that_overlap() {
        let base = square(0.0, 0.0);
        assert!(!base.overlaps(&square(0.25, 1.0), 1.0));
        assert!(base.overlaps(&square(0.3, 0.4), 1.0));
        assert!(base.overlaps(&base, 1.0));
        let small = Sides::new(&[[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]], true);
        assert!(base.overlaps(&small, 0.2) && small.overlaps(&base, 0.2));
        let ground = Sides::new(&[[5.0, 0.25], [-5.0, 0.25]], false);
        assert!(base.overlaps(&ground, 1.0));
        assert!(!square(0.0, 0.25).overlaps(&ground, 1.0));
        assert!(square(0.0, -2.0).overlaps(&ground, 1.0));
    }
}
