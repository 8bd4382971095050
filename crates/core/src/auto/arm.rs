//! The change of a contact arm by a rotation: linearised, and exact.

use crate::body::geometry::ContactGeometry;
use crate::math::turn::Turn;

/// The arm of a contact at a rotation.
#[derive(Clone, Copy)]
pub(super) struct Arm {
    pub(super) b: f64,
    /// b − b₀, computed without cancellation.
    pub(super) change: f64,
    pub(super) c: f64,
    /// h − N·q: the part of the gap that is not linear in the rotation, −b₀(θ − sin θ) − c₀(1 − cos θ).
    pub(super) sag: f64,
}

impl Arm {
    #[inline]
    pub(super) fn of(k: &ContactGeometry, turn: &Turn) -> Self {
        let change = -(k.b * turn.one_minus_cos + k.c * turn.sin);
        let (_, c) = k.turned(turn);
        let sag = -k.b * turn.x_minus_sin - k.c * turn.one_minus_cos;
        Self { b: k.b + change, change, c, sag }
    }

    pub(super) fn nominal(k: &ContactGeometry) -> Self {
        Self { b: k.b, change: 0.0, c: k.c, sag: 0.0 }
    }
}
