//! The rows of contacts in the metric of the mass, of a body (three coordinates) or of a mechanism (any number).

use nalgebra::{Vector2, Vector3};

use crate::math::mass_vector::MassVector;

/// One contact in the mass metric. A body has the coordinates (x, y, ρθ) and rows divided by ν = √(1 + (d×n)²/ρ²), so that the normal row
/// has length one; accelerations are divided by ν and by the scale of the problem. The mass cancels. The rows of a mechanism are divided by
/// the length ν of the normal row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row<V: MassVector = Vector3<f64>> {
    pub(crate) normal: V,
    pub(crate) tangent: V,
    /// d/ρ, world axes; `None` for a mechanism.
    pub(crate) arm: Option<Vector2<f64>>,
    /// (tangential, normal)
    pub(crate) bias: [f64; 2],
    pub(crate) friction: f64,
    pub(crate) sliding: Option<i8>,
    /// ν
    pub(crate) stretch: f64,
}

impl<V: MassVector> Row<V> {
    /// Scaled acceleration along the tangent, and along the normal.
    #[inline(always)]
    pub(super) fn tangential(&self, y: &V) -> f64 {
        self.tangent.dot(y) + self.bias[0]
    }

    #[inline(always)]
    pub(super) fn opening(&self, y: &V) -> f64 {
        self.normal.dot(y) + self.bias[1]
    }

    /// The acceleration `y` and that of this force.
    #[inline(always)]
    pub(super) fn pushed(&self, y: &V, [f_t, f_n]: [f64; 2]) -> V {
        y.plus(&self.tangent, f_t).plus(&self.normal, f_n)
    }
}

impl Row {
    /// An absent contact.
    pub(crate) const ABSENT: Self = Self {
        normal: Vector3::new(0.0, 0.0, 0.0),
        tangent: Vector3::new(0.0, 0.0, 0.0),
        arm: None,
        bias: [0.0; 2],
        friction: 0.0,
        sliding: None,
        stretch: 1.0,
    };

    /// A contact with the unit tangent t and the arm d/ρ; its bias (tangential, normal) is not scaled yet.
    #[inline]
    pub(crate) fn new(
        tangent: Vector2<f64>,
        arm: Vector2<f64>,
        bias: [f64; 2],
        friction: f64,
        sliding: Option<i8>,
    ) -> Self {
        let normal = Vector2::new(-tangent.y, tangent.x);
        // d × n = t·d = b and d × t = −n·d = −c.
        let (b, c) = (tangent.dot(&arm), normal.dot(&arm));
        let stretch = (1.0 + b * b).sqrt();
        Self {
            normal: Vector3::new(normal.x, normal.y, b) / stretch,
            tangent: Vector3::new(tangent.x, tangent.y, -c) / stretch,
            arm: Some(arm),
            bias: bias.map(|value| value / stretch),
            friction,
            sliding,
            stretch,
        }
    }

    /// The scaled force (tangential, normal) that is the vector `force` in world axes, per m times the scale.
    pub(crate) fn turn(&self, force: Vector2<f64>) -> [f64; 2] {
        [self.tangent, self.normal].map(|row| row.xy().dot(&force) * self.stretch * self.stretch)
    }
}

/// The largest of the load, of this size, and the biases, by which the biases are then divided.
pub(crate) fn scale<V: MassVector>(rows: &mut [Row<V>], load: f64) -> f64 {
    let biases = rows
        .iter()
        .filter(|row| row.sliding.is_some())
        .flat_map(|row| row.bias)
        .fold(0.0_f64, |most, bias| most.max(bias.abs()));
    let largest = load.max(biases);
    let scale = if largest > 0.0 { largest } else { 1.0 };
    for row in rows {
        row.bias = row.bias.map(|bias| bias / scale);
    }
    scale
}
