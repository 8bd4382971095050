//! Contacts on one straight line of the body. Over one straight piece of ground their gaps are weighted means:
//!
//! ```text
//! p_j = w p_i + (1 − w) p_k,  0 < w < 1    ⇒    h_j = w h_i + (1 − w) h_k
//! ```

use nalgebra::Vector2;

use crate::body::posture::Posture;
use crate::motion::ground::OnGround;
use crate::sustained::ContactState;
use crate::sustained::rows::Between;
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

impl OnGround<'_, '_> {
    /// The outermost contacts over the piece of ground of a contact that is between two others there.
    fn outer(&self, j: usize) -> Option<Between> {
        let points = &self.state.points;
        let alike = |k: usize| {
            let (one, other) = (&points[j], &points[k]);
            let is_over = |p: &ContactState| p.h < f64::INFINITY && p.depth == 0.0;
            one.normal == other.normal
                && one.place.piece == other.place.piece
                && is_over(one)
                && is_over(other)
        };
        self.ground.lines.iter().find_map(|line| {
            let at = line.iter().position(|(k, _)| *k == j)?;
            let (i, from) = *line[..at].iter().find(|(k, _)| alike(*k))?;
            let (k, to) = *line[at + 1..].iter().rfind(|(k, _)| alike(*k))?;
            Some(Between { outer: [i, k], weight: (to - line[at].1) / (to - from) })
        })
    }

    /// Returns true if a contact is between two others over its piece of ground: it does not land before they do.
    pub(super) fn is_between(&self, j: usize) -> bool {
        self.outer(j).is_some()
    }

    /// Closes the contacts between two others that are closed.
    pub(super) fn land_between(&mut self) {
        if self.ground.lines.is_empty() {
            return;
        }
        for j in 0..self.ground.contacts {
            let points = &self.state.points;
            let closed = |outer: [usize; 2]| outer.into_iter().all(|k| points[k].h == 0.0);
            if self.outer(j).is_some_and(|between| closed(between.outer)) {
                self.state.points[j].h = 0.0;
            }
        }
    }

    /// Sets the gaps and rates of contacts between others to the weighted means.
    pub(super) fn follow_outer(&mut self) {
        if self.ground.lines.is_empty() {
            return;
        }
        for j in 0..self.ground.contacts {
            let Some(between) = self.outer(j) else { continue };
            let points = &mut self.state.points;
            let of = between.outer.map(|k| (points[k].h, points[k].u, points[k].rounding));
            let p = &mut points[j];
            (p.h, p.u, p.rounding) = between.mean(of);
        }
    }
}
