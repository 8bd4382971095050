//! Contacts on one straight line of the body. Over one straight piece of ground their gaps are weighted means:
//!
//! ```text
//! p_j = w p_i + (1 − w) p_k,  0 < w < 1    ⇒    h_j = w h_i + (1 − w) h_k
//! ```

use nalgebra::Vector2;

use crate::body::posture::Posture;
use crate::tolerance::ON_A_LINE;

/// The points on a straight line of the body, in order along it: at least three. Each with its place on the line, in m.
pub(super) type Line = Vec<(usize, f64)>;

/// The lines of at least three contact points. Points of discs are on none.
pub(super) fn lines_of(posture: &Posture) -> Vec<Line> {
    let contacts = posture.contacts();
    let points: Vec<(usize, Vector2<f64>)> = posture
        .distinct()
        .filter(|&k| !contacts[k].is_round())
        .map(|k| (posture.point_of(k), Vector2::from(contacts[k].point)))
        .collect();
    let mut lines: Vec<Line> = Vec::new();
    for (n, (i, from)) in points.iter().enumerate() {
        for (j, to) in &points[n + 1..] {
            let has = |line: &Line, point: &usize| line.iter().any(|(on, _)| on == point);
            if lines.iter().any(|line| has(line, i) && has(line, j)) {
                continue;
            }
            let way = (to - from).normalize();
            let is_on = |(_, p): &&(usize, Vector2<f64>)| {
                way.perp(&(p - from)).abs() <= ON_A_LINE * posture.size()
            };
            let place = |(k, p): &(usize, Vector2<f64>)| (*k, way.dot(&(p - from)));
            let mut line: Line = points.iter().filter(is_on).map(place).collect();
            if line.len() > 2 {
                line.sort_by(|one, other| one.1.total_cmp(&other.1));
                lines.push(line);
            }
        }
    }
    lines
}
