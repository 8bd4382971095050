//! The frame and the arm of a contact, its gap and its gap rate.

use nalgebra::{Vector2, Vector3};

use crate::math::compensated_sum;
use crate::math::turn::Turn;
use crate::tolerance::FINAL_GAP_ROUNDINGS;

/// Constants of one contact: its frame and arm in the nominal posture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ContactGeometry {
    /// t_i
    pub(crate) tangent: Vector2<f64>,
    /// n_i
    pub(crate) normal: Vector2<f64>,
    /// b_i at θ = 0, in m.
    pub(crate) b: f64,
    /// c_i at θ = 0, in m: of the centre of a round contact.
    pub(crate) c: f64,
    /// Radius of the disc, in m; 0 for a point.
    pub(crate) radius: f64,
    /// The corner of the ground that a disc is over, world axes, in m. The other constants then hold at one place of the disc.
    pub(crate) corner: Option<Vector2<f64>>,
    /// Gap in the nominal posture, in m. The offset is zero unless the terrain has several pieces.
    pub(crate) offset: f64,
    /// g_i = g n_i·e_y, in m/s².
    pub(crate) gravity: f64,
    /// e_i
    pub(crate) restitution: f64,
    /// μ_i
    pub(crate) friction: f64,
    /// Speed of the ground along t_i, in m/s; 0 without friction, which alone feels it.
    pub(crate) surface_speed: f64,
}

impl ContactGeometry {
    /// Corrects b and c, to which each step of the rotation has added a rounding error: computes them from the rotation `theta`. If `theta`
    /// is so large that its own rounding error is larger, only restores the length √(b² + c²).
    pub(crate) fn refreshed(&self, theta: f64, b: f64, c: f64) -> (f64, f64) {
        if theta.abs() <= Turn::<f64>::LARGEST {
            return self.turned(&Turn::by(theta));
        }
        let length = libm::hypot(b, c);
        let scale = if length > 0.0 { libm::hypot(self.b, self.c) / length } else { 1.0 };
        (b * scale, c * scale)
    }

    /// Difference of two contacts: the largest component of the difference of the arms (in units of `size`) and of the normals. It is 0 if
    /// the contacts are equal.
    pub(crate) fn apart(&self, other: &Self, size: f64) -> f64 {
        let off = (self.b - other.b).abs().max((self.c - other.c).abs());
        let off = off.max((self.radius - other.radius).abs()) / size;
        off.max((self.normal - other.normal).amax())
    }
}

impl ContactGeometry {
    /// An absent contact: no normal, no arm, no gravity. Its gap is infinite, so that it never touches.
    pub(crate) const ABSENT: Self = Self {
        tangent: Vector2::new(1.0, 0.0),
        normal: Vector2::new(0.0, 0.0),
        b: 0.0,
        c: 0.0,
        radius: 0.0,
        corner: None,
        offset: 0.0,
        gravity: 0.0,
        restitution: 0.0,
        friction: 0.0,
        surface_speed: 0.0,
    };

    /// (b, c) after a turn.
    pub(crate) fn turned(&self, turn: &Turn) -> (f64, f64) {
        turn.turned([self.b, self.c]).into()
    }

    /// Arm of the touching point along the normal at θ = 0, in m: c − R.
    pub(crate) fn touching_c(&self) -> f64 {
        self.c - self.radius
    }

    /// The longer one of the arms of the centre and of the touching point at θ = 0, in m.
    pub(crate) fn reach(&self) -> f64 {
        libm::hypot(self.b, self.c).max(libm::hypot(self.b, self.touching_c()))
    }

    /// Gap at `q`. `turn`: sine and cosine of the rotation of `q`.
    pub(crate) fn gap(&self, q: &Vector3<f64>, turn: &Turn) -> f64 {
        compensated_sum([
            (self.normal.x, q.x),
            (self.normal.y, q.y),
            (self.b, turn.sin),
            (self.c, -turn.one_minus_cos),
            (self.offset, 1.0),
        ])
    }

    /// Rounding errors of the gap and of the gap rate of a closed contact in a state with these q and q̇. `turn`: sine and cosine of the
    /// rotation of q; in the local model those of no rotation.
    pub(crate) fn roundings(
        &self,
        q: &Vector3<f64>,
        qdot: &Vector3<f64>,
        turn: Option<&Turn>,
    ) -> [f64; 2] {
        let arm = self.b.abs() + self.c.abs();
        let angle = turn.map_or(q.z.abs(), |turn| turn.sin.abs() + turn.one_minus_cos);
        let moved = q.x.abs() + q.y.abs() + arm * angle + self.offset.abs();
        let speed = qdot.x.abs() + qdot.y.abs() + arm * qdot.z.abs();
        [moved, speed].map(|size| FINAL_GAP_ROUNDINGS * f64::EPSILON * size)
    }

    /// Gap of the local model, N_i·q with the rows frozen at q = 0.
    pub(crate) fn local_gap(&self, q: &Vector3<f64>) -> f64 {
        compensated_sum([
            (self.normal.x, q.x),
            (self.normal.y, q.y),
            (self.b, q.z),
            (self.offset, 1.0),
        ])
    }

    /// Gap rate of the local model, N_i·q̇.
    pub(crate) fn local_rate(&self, qdot: &Vector3<f64>) -> f64 {
        compensated_sum([(self.normal.x, qdot.x), (self.normal.y, qdot.y), (self.b, qdot.z)])
    }

    pub(crate) fn gap_rate(&self, qdot: &Vector3<f64>, turn: &Turn) -> f64 {
        let (b, _) = self.turned(turn);
        compensated_sum([(self.normal.x, qdot.x), (self.normal.y, qdot.y), (b, qdot.z)])
    }
}

/// (ψ, φ) of a pair: ψ_i = −(b_1b_2 + ρ² n_1·n_2)/(b_i² + ρ²), φ_i = −b_i/(b_i² + ρ²).
pub(crate) fn couplings(b1: f64, b2: f64, n12: f64, rho2: f64) -> ([f64; 2], [f64; 2]) {
    let cross = b1 * b2 + rho2 * n12;
    let (own1, own2) = (b1 * b1 + rho2, b2 * b2 + rho2);
    ([-cross / own1, -cross / own2], [-b1 / own1, -b2 / own2])
}
