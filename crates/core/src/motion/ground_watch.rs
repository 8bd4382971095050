//! Checks, during a run without a terrain, for contacts on ground lines that the user can hardly have intended.

use nalgebra::{Vector2, Vector3};

use crate::body::posture::Posture;
use crate::math::turn::Turn;
use crate::sustained::BodyState;

/// Checks the ground during a run, until there is one warning.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroundWatch {
    /// q of the body at the last check.
    at: Vector3<f64>,
    /// Distance in m by which its contacts may move from there without need of a check; ∞: no checks.
    room: f64,
}

impl GroundWatch {
    /// A new watch; most postures need no checks.
    pub(crate) fn new(posture: Option<&Posture>) -> Self {
        let own = posture.and_then(Posture::own_ground);
        Self { at: Vector3::zeros(), room: own.map_or(f64::INFINITY, |own| own.room) }
    }

    /// Whether checks are needed.
    pub(crate) fn is_on(&self) -> bool {
        self.room < f64::INFINITY
    }

    /// Whether a body at this q is so near to the position of the last check that none is needed.
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
        let Some(own) = posture.own_ground() else { return };
        let (contacts, lines) = (posture.contacts(), posture.geometry());
        let turn = if local { Turn { sin: q.z, ..Turn::default() } } else { Turn::by(q.z) };
        let center = Vector2::from(posture.fields().center_of_mass);
        let moved = |i: usize| {
            let arm = Vector2::from(contacts[i].point) - center;
            q.xy() + Vector2::new(-arm.y, arm.x) * turn.sin - arm * turn.one_minus_cos
        };
        let room = own.room(contacts, lines, posture.size(), moved, touches, time);
        self.at = *q;
        self.room = room.unwrap_or_else(|warning| {
            warnings.push(warning);
            f64::INFINITY
        });
    }

    /// As `look`, for this state of the body.
    pub(crate) fn look_at(
        &mut self,
        posture: &Posture,
        body: &BodyState,
        local: bool,
        time: impl Fn() -> f64,
        warnings: &mut Vec<String>,
    ) {
        if self.is_on() {
            let touches = |i: usize| body.points[posture.point_of(i)].h == 0.0;
            self.look(posture, &body.state().q, local, touches, time, warnings);
        }
    }
}
