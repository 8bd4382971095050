//! Contacts on one straight line of the body. Over one straight piece of ground their gaps are weighted means:
//!
//! ```text
//! p_j = w p_i + (1 − w) p_k,  0 < w < 1    ⇒    h_j = w h_i + (1 − w) h_k
//! ```
//!
//! A body with a row of feet on a level floor therefore moves as one with the two outer feet of the row, and the inner ones follow.

use nalgebra::Vector2;

use crate::body::contact::Contact;
use crate::body::geometry::ContactGeometry;
use crate::tolerance::ON_A_LINE;

/// The longest row whose feet are all hit: each has its share of an impulse. Of longer ones the outer two are hit.
pub(super) const LONGEST_HIT: usize = 8;

/// The points on a straight line of the body, in order along it: at least three. Each with its place on the line, in m.
pub(crate) type Line = Vec<(usize, f64)>;

/// The lines of at least three of these points of a body of this `size`, in m.
pub(super) fn lines_of(points: &[(usize, Vector2<f64>)], size: f64) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (n, (i, from)) in points.iter().enumerate() {
        for (j, to) in &points[n + 1..] {
            let has = |line: &Line, point: &usize| line.iter().any(|(on, _)| on == point);
            if lines.iter().any(|line| has(line, i) && has(line, j)) {
                continue;
            }
            let way = (to - from).normalize();
            let is_on =
                |(_, p): &&(usize, Vector2<f64>)| way.perp(&(p - from)).abs() <= ON_A_LINE * size;
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

/// A contact of a body, in terms of those of its outer feet: one of them, twice, or one between these two, with the weight w of the first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Foot {
    outer: [usize; 2],
    weight: f64,
}

/// The contacts of a body with all its feet, in the posture of its outer feet. Empty: the posture has all.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Feet(Vec<Foot>);

impl Feet {
    pub(crate) const ALL: &'static Self = &Self(Vec::new());

    /// The values of all contacts, from those of the `count` contacts of the posture. `between`: that of a foot between two others, from their
    /// values and the weight of the first.
    pub(crate) fn all<T>(
        &self,
        count: usize,
        of: impl Fn(usize) -> T,
        between: impl Fn([T; 2], f64) -> T,
    ) -> impl Iterator<Item = T> {
        let count = if self.is_empty() { count } else { self.0.len() };
        (0..count).map(move |i| match self.0.get(i) {
            None => of(i),
            Some(Foot { outer: [one, other], .. }) if one == other => of(*one),
            Some(foot) => between(foot.outer.map(&of), foot.weight),
        })
    }

    /// Gaps or rates of all contacts.
    pub(crate) fn means<T: FromIterator<f64>>(&self, values: &[f64]) -> T {
        let mean = |[one, other]: [f64; 2], w: f64| w * one + (1.0 - w) * other;
        self.all(values.len(), |i| values[i], mean).collect()
    }

    /// Modes or their letters of all contacts, from those of the contacts of the posture: an inner foot is closed where both outer ones are.
    pub(crate) fn modes<T: Copy + PartialEq>(
        &self,
        of: &[T],
        separate: T,
    ) -> impl Iterator<Item = T> {
        let between = move |[one, other]: [T; 2], _| if other == separate { separate } else { one };
        self.all(of.len(), |i| of[i], between)
    }

    /// The numbers of these contacts of the posture, and of the feet between them, from 0.
    pub(crate) fn numbers(&self, contacts: &[usize]) -> Vec<usize> {
        if self.is_empty() {
            return contacts.to_vec();
        }
        let all = self.all(0, |i| contacts.contains(&i), |[one, other], _| one && other);
        all.enumerate().filter(|(_, is_in)| *is_in).map(|(i, _)| i).collect()
    }

    /// The number of a contact of the posture, from 0.
    pub(crate) fn number(&self, contact: usize) -> usize {
        self.0.iter().position(|foot| foot.outer == [contact; 2]).unwrap_or(contact)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The contacts without the inner feet of long rows on these lines of the body, and how all follow from them; `None`: there are no such rows.
/// The contacts are at different points and have one ground.
pub(super) fn without_inner_feet(
    lines: &[Line],
    contacts: &[Contact],
    geometry: &[ContactGeometry],
) -> Option<(Vec<usize>, Feet)> {
    let alike = |i: usize, j: usize| {
        let ground = |k: usize| ContactGeometry { b: 0.0, c: 0.0, ..geometry[k] };
        let returned = |k: usize| contacts[k].tangential_restitution;
        ground(i) == ground(j) && returned(i) == returned(j)
    };
    let mut inner: Vec<Option<Foot>> = vec![None; contacts.len()];
    for line in lines {
        for &(j, place) in line {
            let row = || line.iter().filter(|(k, _)| alike(*k, j));
            let [Some(&(i, from)), Some(&(k, to))] = [row().next(), row().next_back()] else {
                continue;
            };
            if from < place && place < to && row().count() > LONGEST_HIT {
                inner[j] = Some(Foot { outer: [i, k], weight: (to - place) / (to - from) });
            }
        }
    }
    let lies = |foot: &Foot| foot.outer.iter().all(|&k| inner[k].is_none());
    let inner: Vec<Option<Foot>> = inner.iter().map(|foot| foot.filter(lies)).collect();
    let kept: Vec<usize> = (0..contacts.len()).filter(|&k| inner[k].is_none()).collect();
    if kept.len() == contacts.len() {
        return None;
    }
    let place = |k: usize| kept.partition_point(|&other| other < k);
    let foot = |(k, foot): (usize, &Option<Foot>)| match foot {
        Some(Foot { outer, weight }) => Foot { outer: outer.map(place), weight: *weight },
        None => Foot { outer: [place(k); 2], weight: 1.0 },
    };
    let feet = Feet(inner.iter().enumerate().map(foot).collect());
    Some((kept, feet))
}
