//! Whether the ground that the contacts have without a terrain can be meant, while a run goes on.

use nalgebra::{Vector2, Vector3};

use crate::body::posture::Posture;
use crate::math::turn::Turn;

/// Looks at the ground while a run goes on, until there is something to say of it: once a run.
#[derive(Debug, Clone)]
pub(crate) struct Watch {
    posture: Posture,
    /// Where the body was at the last look, and how far its contacts may move from there before anything can be wrong, in m.
    at: Vector3<f64>,
    room: f64,
}

impl Watch {
    /// `None`: of most postures there is nothing to be looked at.
    pub(crate) fn new(posture: &Posture) -> Option<Box<Self>> {
        let room = posture.own_ground()?.room;
        Some(Box::new(Self { posture: posture.clone(), at: Vector3::zeros(), room }))
    }

    /// Looks at a moment of a run, at this q: whether there is more to be looked at. `local`: in the local model. `touches`: whether
    /// a contact is on its own line. `time`: in s.
    pub(crate) fn look(
        &mut self,
        q: &Vector3<f64>,
        local: bool,
        touches: impl Fn(usize) -> bool,
        time: impl Fn() -> f64,
        warnings: &mut Vec<String>,
    ) -> bool {
        let way = q - self.at;
        if way.x.abs() + way.y.abs() + self.posture.size() * way.z.abs() < self.room {
            return true;
        }
        let Some(own) = self.posture.own_ground() else { return false };
        let (contacts, lines) = (self.posture.contacts(), self.posture.geometry());
        let turn = if local { Turn { sin: q.z, ..Turn::default() } } else { Turn::by(q.z) };
        let center = Vector2::from(self.posture.fields().center_of_mass);
        let moved = |i: usize| {
            let arm = Vector2::from(contacts[i].point) - center;
            q.xy() + Vector2::new(-arm.y, arm.x) * turn.sin - arm * turn.one_minus_cos
        };
        match own.room(contacts, lines, self.posture.size(), moved, touches, time) {
            Ok(room) => {
                (self.at, self.room) = (*q, room);
                true
            }
            Err(warning) => {
                warnings.push(warning);
                false
            }
        }
    }
}
