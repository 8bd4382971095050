//! What a picture of a posture shows: the outline of the body and the pieces of its ground.

use nalgebra::Vector2;
use serde::Serialize;

use crate::body::contact::Contact;
use crate::body::fields::GroundKind;
use crate::body::posture::Posture;
use crate::math::turn::Turn;
use crate::serial::numbers::extended_pair;
use crate::tolerance::SAME_LINE;

/// A straight piece of ground, with the air on the left of its direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GroundPiece {
    /// A point of its line, in m.
    pub point: [f64; 2],
    /// Its direction, a unit vector.
    pub direction: [f64; 2],
    /// Where it begins and ends, from the point along the direction, in m; infinite where it has no end.
    #[serde(with = "extended_pair")]
    pub ends: [f64; 2],
}

/// A line: a point and a direction.
type Line = (Vector2<f64>, Vector2<f64>);

impl GroundPiece {
    fn line(&self) -> Line {
        (self.point.into(), self.direction.into())
    }
}

/// Number of corners of the polygon that stands for a disc.
const RIM: usize = 64;

/// The point of a contact, or points of the rim of its disc.
fn rim(contact: &Contact) -> Vec<[f64; 2]> {
    if !contact.is_round() {
        return vec![contact.point];
    }
    let center = contact.center();
    let below = Vector2::from(contact.point) - center;
    let point = |k: usize| {
        let turn = Turn::by(std::f64::consts::TAU * k as f64 / RIM as f64);
        let across = Vector2::new(-below.y, below.x);
        (center + below * (1.0 - turn.one_minus_cos) + across * turn.sin).into()
    };
    (0..RIM).map(point).collect()
}

/// Returns true if two lines are the same for a body of this size (m).
fn same_line(one: Line, other: Line, size: f64) -> bool {
    let side = one.1.perp(&(other.0 - one.0)) / size;
    side.abs().max(one.1.perp(&other.1).abs()) < SAME_LINE
}

impl Posture {
    /// The corners of the body in its nominal posture as a picture shows them, in order, in m: its outline; without one, the convex hull of
    /// the contacts, counterclockwise, in which a polygon stands for a disc. A body on one contact that is a point has no corners.
    ///
    /// ```
    /// use standfast::{Contact, Lamina, Posture};
    ///
    /// let lamina = Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() };
    /// let rod = Posture::rod(0.5, &lamina)?;
    /// assert_eq!(rod.drawn_corners(), [[-0.5, 0.0], [0.5, 0.0]]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn drawn_corners(&self) -> Vec<[f64; 2]> {
        let fields = self.fields();
        match (fields.outline.is_empty(), fields.contacts.len()) {
            (false, _) => fields.outline.clone(),
            (true, 1) if !self.has_rounds() => Vec::new(),
            (true, _) => hull(fields.contacts.iter().flat_map(rim).collect()),
        }
    }

    /// The ground as straight pieces: those of the terrain, or the line that all contacts share, or the lines of the contacts. The line of a
    /// contact ends where it meets the line of another contact between both. If they do not meet there, it ends halfway to the other contact.
    /// Pieces on one line that overlap are one piece.
    ///
    /// ```
    /// use standfast::{Lamina, Posture};
    ///
    /// let lamina = Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() };
    /// let rod = Posture::rod(0.5, &lamina)?;
    /// let ground = rod.drawn_ground();
    /// assert_eq!(ground.len(), 1); // both ends on one line
    /// assert_eq!(ground[0].ends, [f64::NEG_INFINITY, f64::INFINITY]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn drawn_ground(&self) -> Vec<GroundPiece> {
        let fields = self.fields();
        if !fields.terrain.is_empty() {
            let piece = |ends: &[[f64; 2]]| {
                let [from, to] = [ends[0], ends[1]].map(Vector2::from);
                let (way, length) = (to - from, (to - from).norm());
                GroundPiece {
                    point: from.into(),
                    direction: (way / length).into(),
                    ends: [0.0, length],
                }
            };
            return fields.terrain.windows(2).map(piece).collect();
        }
        let lines: Vec<Line> = (fields.contacts.iter().zip(self.geometry()))
            .map(|(contact, geometry)| (contact.point.into(), geometry.tangent))
            .collect();
        if fields.ground == GroundKind::Shared {
            let height = |line: &&Line| line.1.perp(&line.0);
            let lowest = lines.iter().min_by(|a, b| height(a).total_cmp(&height(b)));
            let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
            let piece = |(point, direction): &Line| GroundPiece {
                point: (*point).into(),
                direction: (*direction).into(),
                ends: everywhere,
            };
            return lowest.map(piece).into_iter().collect();
        }
        self.joined((0..lines.len()).map(|i| self.own_piece(&lines, i)))
    }

    /// The line of contact `i`, up to the lines of the others.
    fn own_piece(&self, lines: &[Line], i: usize) -> GroundPiece {
        let size = self.size();
        let (point, direction) = lines[i];
        let [mut low, mut high] = self.contacts()[i].segment;
        for other in lines.iter().filter(|other| !same_line(lines[i], **other, size)) {
            let to = other.0 - point;
            let turn = direction.perp(&other.1);
            let (along, back) = (to.dot(&direction), -to.dot(&other.1));
            if along.abs() < SAME_LINE * size && turn.abs() < SAME_LINE {
                continue; // one right above the other
            }
            // Where the lines meet, from this contact and from the other.
            let (here, there) = (to.perp(&other.1) / turn, to.perp(&direction) / turn);
            let meet = turn != 0.0 && here * along > 0.0 && there * back > 0.0;
            let end = if meet { here } else { along / 2.0 };
            if end > 0.0 {
                high = high.min(end);
            } else if end < 0.0 {
                low = low.max(end);
            }
        }
        GroundPiece { point: point.into(), direction: direction.into(), ends: [low, high] }
    }

    /// The pieces, with one piece for those that overlap on the same side of the same line.
    fn joined(&self, pieces: impl Iterator<Item = GroundPiece>) -> Vec<GroundPiece> {
        let mut kept: Vec<GroundPiece> = Vec::new();
        for mut piece in pieces {
            let (point, direction) = piece.line();
            kept.retain(|other| {
                let along = (other.line().0 - point).dot(&direction);
                let [begin, end] = other.ends.map(|end| along + end);
                let overlaps = same_line(piece.line(), other.line(), self.size())
                    && direction.dot(&other.line().1) > 0.0
                    && begin <= piece.ends[1]
                    && piece.ends[0] <= end;
                if overlaps {
                    piece.ends = [piece.ends[0].min(begin), piece.ends[1].max(end)];
                }
                !overlaps
            });
            kept.push(piece);
        }
        kept
    }
}

/// Convex hull of points, counterclockwise from the leftmost (Andrew's monotone chain).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let turns_left = |chain: &[[f64; 2]], to: [f64; 2]| {
        let [a, b] = [chain[chain.len() - 2], chain[chain.len() - 1]].map(Vector2::from);
        (b - a).perp(&(Vector2::from(to) - b)) > 0.0
    };
    let mut chain: Vec<[f64; 2]> = Vec::new();
    for upper in [false, true] {
        let begin = chain.len();
        for k in 0..points.len() {
            let point = points[if upper { points.len() - 1 - k } else { k }];
            while chain.len() >= begin + 2 && !turns_left(&chain, point) {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop(); // the first of the other half
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_has_no_inner_points_and_no_points_on_its_sides() {
        let points = vec![[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [1.0, 1.0], [1.0, 0.0], [2.0, 0.0]];
        assert_eq!(hull(points), [[0.0, 0.0], [2.0, 0.0], [1.0, 1.0]]);
        assert_eq!(hull(vec![[1.0, 0.0], [0.0, 0.0], [2.0, 0.0]]), [[0.0, 0.0], [2.0, 0.0]]);
    }
}
