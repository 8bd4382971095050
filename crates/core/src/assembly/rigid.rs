//! A rigid body of an assembly, in its place.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::body::outline::uniform_polygon;
use crate::error::{Error, finite, friction, positive};

/// A rigid body in its place. SI units: kg, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rigid {
    /// Mass, in kg.
    pub mass: f64,
    /// Radius of gyration about the centre of mass, in m: the moment of inertia is mass · gyration_radius².
    pub gyration_radius: f64,
    /// Centre of mass, in m.
    pub center_of_mass: [f64; 2],
    /// Corners of the body in order, counterclockwise, in m: a polygon whose sides meet only at its corners.
    pub outline: Vec<[f64; 2]>,
    /// Coefficient of friction of its contacts; `None` takes that of the system. Where two bodies have one, the smaller one counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
}

impl Rigid {
    /// Checks the values, and turns a clockwise outline round.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`] naming the field.
    pub fn checked(mut self) -> Result<Self, Error> {
        positive("mass", self.mass)?;
        positive("gyration_radius", self.gyration_radius)?;
        for (axis, value) in ["x", "y"].iter().zip(self.center_of_mass) {
            finite(format!("center_of_mass.{axis}"), value)?;
        }
        if let Some(value) = self.friction {
            friction("friction", value)?;
        }
        if uniform_polygon("outline", &self.outline)?.area < 0.0 {
            self.outline.reverse();
        }
        Ok(self)
    }

    /// A rectangle of uniform density. `at`: the middle of its lower side, in m. `turn`: its angle about this point, counterclockwise, in rad.
    /// `density`: mass per area, in kg/m².
    ///
    /// ```
    /// use standfast::assembly::Rigid;
    ///
    /// let brick = Rigid::block(2.0, 1.0, [0.0, 3.0], 0.0, 5.0)?;
    /// assert_eq!((brick.mass, brick.center_of_mass), (10.0, [0.0, 3.5]));
    /// assert_eq!(brick.outline[2], [1.0, 4.0]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Rigid::checked`], naming `width`, `height`, `at`, `turn` or `density`.
    pub fn block(
        width: f64,
        height: f64,
        at: [f64; 2],
        turn: f64,
        density: f64,
    ) -> Result<Self, Error> {
        positive("width", width)?;
        positive("height", height)?;
        positive("density", density)?;
        finite("turn", turn)?;
        for (axis, value) in ["x", "y"].iter().zip(at) {
            finite(format!("at.{axis}"), value)?;
        }
        let (sine, cosine) = libm::sincos(turn);
        let placed =
            |x: f64, y: f64| [at[0] + cosine * x - sine * y, at[1] + sine * x + cosine * y];
        let half = 0.5 * width;
        Self {
            mass: density * width * height,
            gyration_radius: libm::sqrt((width * width + height * height) / 12.0),
            center_of_mass: placed(0.0, 0.5 * height),
            outline: vec![
                placed(-half, 0.0),
                placed(half, 0.0),
                placed(half, height),
                placed(-half, height),
            ],
            friction: None,
        }
        .checked()
    }

    /// A polygon of uniform density, in kg/m². `vertices`: its corners in order, in either direction, in m.
    ///
    /// # Errors
    ///
    /// As [`Rigid::checked`], naming `vertices` or `density`.
    pub fn polygon(vertices: &[[f64; 2]], density: f64) -> Result<Self, Error> {
        positive("density", density)?;
        let uniform = uniform_polygon("vertices", vertices)?;
        Self {
            mass: density * uniform.area.abs(),
            gyration_radius: libm::sqrt(uniform.gyration_squared),
            center_of_mass: uniform.center.into(),
            outline: vertices.to_vec(),
            friction: None,
        }
        .checked()
    }

    /// The largest distance of a corner from the centre of mass, in m.
    pub(crate) fn size(&self) -> f64 {
        let center = Vector2::from(self.center_of_mass);
        let corners = self.outline.iter().map(|corner| (Vector2::from(*corner) - center).norm());
        corners.fold(0.0, f64::max)
    }
}
