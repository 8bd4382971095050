//! The change of a contact arm by a rotation: linearised, and exact.

use crate::body::geometry::ContactGeometry;

/// The functions of a small rotation that change every arm.
#[derive(Clone, Copy)]
pub(super) struct Angle {
    pub(super) sin: f64,
    /// 1 − cos θ
    pub(super) one_minus_cos: f64,
    /// θ − sin θ
    pub(super) x_minus_sin: f64,
}

impl Angle {
    /// For |θ| ≤ [`SHADOW_TURN`]. The error is below θ⁶/20160.
    #[inline]
    pub(super) fn of(theta: f64) -> Self {
        let y = theta * theta;
        let x_minus_sin = theta * y * (1.0 / 6.0 - y * (1.0 / 120.0 - y * (1.0 / 5040.0)));
        let one_minus_cos = y * (0.5 - y * (1.0 / 24.0 - y * (1.0 / 720.0)));
        Self { sin: theta - x_minus_sin, one_minus_cos, x_minus_sin }
    }
}

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
    pub(super) fn of(k: &ContactGeometry, angle: Angle) -> Self {
        let Angle { sin, one_minus_cos, x_minus_sin } = angle;
        let change = -(k.b * one_minus_cos + k.c * sin);
        Self {
            b: k.b + change,
            change,
            c: k.c - (k.c * one_minus_cos - k.b * sin),
            sag: -k.b * x_minus_sin - k.c * one_minus_cos,
        }
    }

    pub(super) fn nominal(k: &ContactGeometry) -> Self {
        Self { b: k.b, change: 0.0, c: k.c, sag: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tolerance::SHADOW_TURN;

    #[test]
    fn an_angle_keeps_its_digits() {
        for theta in [1e-9, -3e-4, 0.05, SHADOW_TURN] {
            let Angle { sin, one_minus_cos, x_minus_sin } = Angle::of(theta);
            let exact = crate::math::turn::Turn::by(theta);
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
            assert!(
                close(sin, exact.sin)
                    && close(one_minus_cos, exact.one_minus_cos)
                    && close(x_minus_sin, exact.x_minus_sin)
            );
        }
    }
}
