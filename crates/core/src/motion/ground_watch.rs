//! Checks, during a run, for motions that the ground of the whole body would not allow: contacts on ground lines that the user can hardly
//! have intended, parts of the body, other than its contacts, in the ground, and sides of the body that pieces of the ground cross.

use nalgebra::{Vector2, Vector3};
use smallvec::SmallVec;

use crate::body::posture::Posture;
use crate::math::turn::Turn;
use crate::sustained::BodyState;
use crate::tolerance::SAME_GROUND;

/// A point of the body that is not a contact.
#[derive(Debug, Clone, Copy)]
struct BodyPoint {
    /// Its number among the corners of the outline, from 1; 0: the centre of mass.
    corner: usize,
    /// In the nominal posture, world axes, in m.
    at: Vector2<f64>,
}

/// Checks the ground during a run. Each of its checks ends with its first warning.
#[derive(Debug, Clone)]
pub(crate) struct GroundWatch {
    /// Whether the lines of contacts without a terrain are checked.
    lines: bool,
    /// The points that are over the ground in the nominal posture, and are checked.
    points: SmallVec<[BodyPoint; 1]>,
    /// Whether sides of the body are checked, which pieces of the ground do not cross.
    sides: bool,
    /// q of the body at the last check.
    at: Vector3<f64>,
    /// Distance in m by which its points may move from there without need of a check; ∞: no checks.
    room: f64,
}

/// Height of a point over the ground of contact `i`, and a lower bound of its distance from this ground, in m. `None`: no piece of the
/// ground is under it.
fn height(posture: &Posture, i: usize, at: &Vector2<f64>) -> (Option<f64>, f64) {
    let Some(ground) = posture.ground(i) else {
        let height =
            posture.geometry()[i].normal.dot(&(at - Vector2::from(posture.contacts()[i].point)));
        return (Some(height), height.abs());
    };
    let (piece, exists) = ground.nearest(ground.find(at));
    (exists.then(|| piece.height(at) + ground.raised), ground.distance(at))
}

impl GroundWatch {
    /// A new watch; some postures need no checks. `sides`: whether corners of the ground are contacts on sides of the
    /// body.
    pub(crate) fn new(posture: Option<&Posture>, sides: bool) -> Self {
        let at = Vector3::zeros();
        let Some(posture) = posture else {
            let points = SmallVec::new();
            return Self { lines: false, points, sides: false, at, room: f64::INFINITY };
        };
        let own = posture.own_ground();
        let fields = posture.fields();
        let center = BodyPoint { corner: 0, at: fields.center_of_mass.into() };
        let is_contact = |corner: &[f64; 2]| fields.contacts.iter().any(|c| c.point == *corner);
        let corners = fields.outline.iter().enumerate();
        let mut points: SmallVec<[BodyPoint; 1]> = corners
            .filter(|(_, corner)| !is_contact(corner))
            .map(|(k, corner)| BodyPoint { corner: k + 1, at: Vector2::from(*corner) })
            .collect();
        // A body all of whose corners are contacts needs no check.
        if fields.outline.is_empty() || !points.is_empty() {
            points.push(center);
        }
        let mut room = own.map_or(f64::INFINITY, |own| own.room);
        let least = SAME_GROUND * posture.size();
        points.retain(|point| {
            let mut over = true;
            for i in posture.distinct() {
                let (height, distance) = height(posture, i, &point.at);
                over &= height.is_none_or(|height| height > least);
                if over {
                    room = room.min(distance);
                }
            }
            over
        });
        let sides = sides && !posture.ground_corners().all.is_empty();
        if sides {
            room = room.min(least);
        }
        Self { lines: own.is_some(), points, sides, at, room }
    }

    /// Returns true if checks are needed.
    pub(crate) fn is_on(&self) -> bool {
        self.room < f64::INFINITY
    }

    /// Returns true if a body at this q is so near to the position of the last check that none is needed.
    pub(crate) fn is_near(&self, posture: &Posture, q: &Vector3<f64>) -> bool {
        let way = q - self.at;
        way.x.abs() + way.y.abs() + posture.size() * way.z.abs() < self.room
    }

    /// Checks the ground at this q in a run of this posture. `local`: in the local model. `touches`: whether a contact is on
    /// its own line. `time`: in s.
    pub(crate) fn look(
        &mut self,
        posture: &Posture,
        q: &Vector3<f64>,
        local: bool,
        touches: impl Fn(usize) -> bool,
        time: impl Fn() -> f64,
        warnings: &mut Vec<String>,
    ) {
        if self.is_near(posture, q) {
            return;
        }
        self.at = *q;
        self.room = f64::INFINITY;
        let (contacts, lines) = (posture.contacts(), posture.geometry());
        let turn = if local { Turn { sin: q.z, ..Turn::default() } } else { Turn::by(q.z) };
        let center = Vector2::from(posture.fields().center_of_mass);
        let moved = |at: Vector2<f64>| {
            let arm = at - center;
            q.xy() + Vector2::new(-arm.y, arm.x) * turn.sin - arm * turn.one_minus_cos
        };
        if let Some(own) = posture.own_ground().filter(|_| self.lines) {
            let moved = |i: usize| moved(contacts[i].center());
            match own.room(contacts, lines, posture.size(), moved, &touches, &time) {
                Ok(room) => self.room = room,
                Err(warning) => {
                    warnings.push(warning);
                    self.lines = false;
                }
            }
        }
        let touched: SmallVec<[usize; 2]> = posture.distinct().filter(|&i| touches(i)).collect();
        let mut entered = None;
        if self.sides {
            let least = SAME_GROUND * posture.size();
            self.room = self.room.min(least);
            if let Some((place, depth)) = posture.pierced(q, least) {
                self.sides = false;
                warnings.push(format!(
                    "body-in-ground: at t = {:?} s or before, a side of the body has come through the ground, {depth:?} m deep at ({:?}, {:?}) m",
                    time(),
                    place.x,
                    place.y
                ));
            }
        }
        for point in &self.points {
            let at = point.at + moved(point.at);
            let least = -SAME_GROUND * (posture.size() + (at - point.at).norm());
            let is_in = |&i: &usize| height(posture, i, &at).0.is_some_and(|h| h < least);
            if !touched.is_empty() && touched.iter().all(is_in) {
                entered = entered.or(Some(*point));
            }
            for i in posture.distinct() {
                self.room = self.room.min(height(posture, i, &at).1);
            }
        }
        if let Some(BodyPoint { corner, .. }) = entered {
            let what = match corner {
                0 => "the centre of mass".into(),
                corner => format!("corner {corner} of the outline"),
            };
            warnings.push(format!(
                "body-in-ground: at t = {:?} s or before, {what} has come below the ground of contact {}; only contacts meet the ground: put contacts on all parts of the body that can fall on it",
                time(),
                posture.feet().number(touched[0]) + 1,
            ));
            self.points.clear();
        }
    }

    /// As `look`, for this state of the body.
    pub(crate) fn look_at(
        &mut self,
        posture: &Posture,
        body: &BodyState,
        time: impl Fn() -> f64,
        warnings: &mut Vec<String>,
    ) {
        if self.is_on() {
            let touches = |i: usize| body.points[posture.point_of(i)].h == 0.0;
            self.look(posture, &body.state().q, false, touches, time, warnings);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::contact::Contact;
    use crate::body::fields::{GroundKind, PostureFields};

    /// A box beside the ridge of a roof of 45 degrees, over it, and with one of its corners below a piece.
    #[test]
    fn a_side_that_a_piece_crosses_is_told_once() {
        let outline = vec![[-0.5, 0.0], [0.5, 0.0], [0.5, 1.0], [-0.5, 1.0]];
        let posture = Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.4,
            center_of_mass: [0.0, 0.5],
            contacts: outline.iter().map(|[x, y]| Contact::at(*x, *y)).collect(),
            restitution: 0.0,
            gravity: 9.81,
            terrain: vec![[-9.0, -9.0], [0.0, 0.0], [9.0, -9.0]],
            surfaces: Vec::new(),
            ground: GroundKind::Own,
            outline,
        })
        .unwrap();
        for (sides, count) in [(true, 1), (false, 0)] {
            let (mut watch, mut warnings) = (GroundWatch::new(Some(&posture), sides), Vec::new());
            for q in [[0.1, 0.0, 0.0], [1.0, -0.4, 0.0], [1.0, -0.9, 0.0], [1.0, -0.8, 0.0]] {
                watch.look(&posture, &q.into(), false, |_| false, || 0.0, &mut warnings);
                let deep = q[1] == -0.9 || q[1] == -0.8;
                assert_eq!(warnings.len(), if deep { count } else { 0 }, "{q:?} {warnings:?}");
            }
        }
    }
}
