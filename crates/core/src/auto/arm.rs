//! What a rotation, small and exactly, does to the arm of a contact.

use crate::body::geometry::Geometry;

/// What a small rotation does to every arm.
#[derive(Clone, Copy)]
pub(super) struct Angle {
    pub(super) sin: f64,
    /// 1 − cos θ
    pub(super) versed: f64,
    /// θ − sin θ
    pub(super) lag: f64,
}

impl Angle {
    /// For |θ| ≤ [`LARGEST_TURN`], to within θ⁶/20160.
    #[inline]
    pub(super) fn of(theta: f64) -> Self {
        let y = theta * theta;
        let lag = theta * y * (1.0 / 6.0 - y * (1.0 / 120.0 - y * (1.0 / 5040.0)));
        let versed = y * (0.5 - y * (1.0 / 24.0 - y * (1.0 / 720.0)));
        Self { sin: theta - lag, versed, lag }
    }
}

/// The arm of a contact at a rotation.
#[derive(Clone, Copy)]
pub(super) struct Arm {
    pub(super) b: f64,
    /// b − b₀, with all its digits.
    pub(super) change: f64,
    pub(super) c: f64,
    /// h − N·q: what finite rotation adds to the gap, −b₀(θ − sin θ) − c₀(1 − cos θ).
    pub(super) sag: f64,
}

impl Arm {
    #[inline]
    pub(super) fn of(k: &Geometry, angle: Angle) -> Self {
        let Angle { sin, versed, lag } = angle;
        let change = -(k.b * versed + k.c * sin);
        Self {
            b: k.b + change,
            change,
            c: k.c - (k.c * versed - k.b * sin),
            sag: -k.b * lag - k.c * versed,
        }
    }

    pub(super) fn nominal(k: &Geometry) -> Self {
        Self { b: k.b, change: 0.0, c: k.c, sag: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::LARGEST_TURN;
    use super::*;

    #[test]
    fn an_angle_keeps_its_digits() {
        for theta in [1e-9, -3e-4, 0.05, LARGEST_TURN] {
            let Angle { sin, versed, lag } = Angle::of(theta);
            let exact = crate::math::turn::Turn::by(theta);
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
            assert!(close(sin, exact.sin) && close(versed, exact.versed) && close(lag, exact.lag));
        }
    }
}
