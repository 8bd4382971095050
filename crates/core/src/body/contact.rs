//! A contact: a point of the body that can touch a straight piece of terrain. If the posture has a terrain, all contacts share the pieces
//! of this terrain. Otherwise each contact has its own piece: the straight line with the slope of the contact through its point.
//!
//! ```text
//!        n  (out of the terrain)
//!        |
//!        |    t  (to the right: n turned by -90 degrees)
//!        +-----> t = (cos slope, sin slope), n = (-sin slope, cos slope)
//!   ////////////
//! ```
//!
//! A contact with a radius R is a disc about a point of the body. Its centre C = point + R n is fixed in the body, unless it is given. The disc
//! touches the ground with the point below its centre, which is another point of the body once the body has turned:
//!
//! ```text
//!    .--.
//!   ( C  )   the gap is that of the centre over the ground raised by R;
//! ___`--'___ force and sliding speed are those of the touching point C − R n
//! ```
//!
//! Angles count counterclockwise, in rad. Pairs of forces and velocities are (tangential, normal), points (x, y).

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Vector2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{Error, angle, finite, friction, in_range, restitution, surface_speed};
use crate::serial::values::is_zero;
use crate::tolerance::{DISC_CENTER, DISC_POINT};

/// An entry for each contact, without allocation for up to two contacts.
pub(crate) type PerContact<T> = smallvec::SmallVec<[T; 2]>;

/// A letter or a flag for each contact, without allocation for up to sixteen contacts.
pub(crate) type ContactLetters<T> = smallvec::SmallVec<[T; 16]>;

/// A number or a word for each contact, without allocation for up to eight contacts.
pub(crate) type ContactValues<T> = smallvec::SmallVec<[T; 8]>;

/// Largest radius of a contact, in m: that of the largest body.
const LARGEST_RADIUS: f64 = 1e75;

/// A frictional contact: a point of the body, or a disc about one, and its ground.
///
/// Unless the posture has a `terrain` or shared ground, only this point can touch its ground, the straight line of `slope` through `point`. It has no ends unless `segment`
/// gives them. The point passes through the ground of other contacts; a run has a warning where this can hardly be intended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// The point in the nominal posture, world axes, in m. Its own line goes through it; terrain or shared ground may be below it.
    #[serde(deserialize_with = "crate::serial::values::exactly")]
    pub point: [f64; 2],
    /// Slope angle of the terrain, −π < slope ≤ π, in rad: 0 is level ground, π/2 a wall on the right of the body, −π/2 one on its left,
    /// π a ceiling. The doubles nearest to these angles stand for the angles themselves.
    #[serde(default)]
    pub slope: f64,
    /// Coulomb friction coefficient μ, from 0 to 1e12, dimensionless.
    #[serde(default)]
    pub friction: f64,
    /// Coefficient of restitution in [0, 1], dimensionless; `None` takes the posture's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Tangential restitution in [0, 1), dimensionless. Only some impact laws use it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub tangential_restitution: f64,
    /// Radius R of the disc that touches the ground at `point`, in m: 0 is a point of the body. The centre of the disc is R away from
    /// `point`, along the normal of the ground.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub radius: f64,
    /// The centre of a disc in the nominal posture, world axes, in m. With it the disc need not touch its ground there: `point` is the point
    /// of the disc that is nearest to the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<[f64; 2]>,
    /// Speed of the surface of its ground along `t`, in m/s, as of a belt: it slides with v_t less this speed. The ground stays in its place.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub surface_speed: f64,
    /// Extent of the terrain along `t` from `point`, in m; `(-∞, ∞)` unless given.
    #[serde(default = "everywhere", skip_serializing_if = "is_everywhere")]
    #[serde(with = "crate::serial::numbers::extended_pair")]
    #[schemars(with = "[crate::serial::numbers::Extended; 2]")]
    pub segment: [f64; 2],
}

fn everywhere() -> [f64; 2] {
    [f64::NEG_INFINITY, f64::INFINITY]
}

fn is_everywhere(segment: &[f64; 2]) -> bool {
    *segment == everywhere()
}

/// (cos, sin) of a slope, exact for multiples of a right angle. With a rounded cosine a wall would not be exactly vertical: two walls
/// without friction could then hold a body between them by the tiny vertical parts of enormous forces.
pub(crate) fn direction(slope: f64) -> Vector2<f64> {
    match quarter_turns(slope) {
        Some([cos, sin]) => Vector2::new(cos, sin),
        None => Vector2::new(libm::cos(slope), libm::sin(slope)),
    }
}

/// (cos, sin) of the slopes 0, π/2, −π/2 and π.
pub(crate) fn quarter_turns(slope: f64) -> Option<[f64; 2]> {
    [(0.0, [1.0, 0.0]), (FRAC_PI_2, [0.0, 1.0]), (-FRAC_PI_2, [0.0, -1.0]), (PI, [-1.0, 0.0])]
        .into_iter()
        .find_map(|(angle, parts)| (slope == angle).then_some(parts))
}

impl Contact {
    /// A frictionless contact on level ground at `point`.
    #[must_use]
    pub fn at(x: f64, y: f64) -> Self {
        Self {
            point: [x, y],
            slope: 0.0,
            friction: 0.0,
            restitution: None,
            tangential_restitution: 0.0,
            radius: 0.0,
            center: None,
            surface_speed: 0.0,
            segment: everywhere(),
        }
    }

    /// The disc of this radius (m) about this point of the body, without friction, which need not touch its ground.
    ///
    /// ```
    /// use standfast::Contact;
    ///
    /// let ball = Contact::around([0.0, 1.0], 0.25);
    /// assert_eq!(ball.point, [0.0, 0.75]);
    /// ```
    #[must_use]
    pub fn around(center: [f64; 2], radius: f64) -> Self {
        Self { radius, center: Some(center), ..Self::at(center[0], center[1] - radius) }
    }

    /// The same contact on terrain of another slope, in rad.
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_2;
    ///
    /// use standfast::Contact;
    ///
    /// // A wall on the right of the body: its normal points to the left.
    /// let wall = Contact { friction: 0.5, ..Contact::at(1.0, 0.0).on_slope(FRAC_PI_2) };
    /// assert_eq!((wall.normal().x, wall.normal().y), (-1.0, 0.0));
    /// ```
    #[must_use]
    pub fn on_slope(self, slope: f64) -> Self {
        let mut contact = Self { slope, ..self };
        contact.turn_to(&contact.normal());
        contact
    }

    /// The same contact as a disc of this radius, in m: about the same centre if it is given, otherwise touching at the same point.
    #[must_use]
    pub fn with_radius(self, radius: f64) -> Self {
        let mut contact = Self { radius, ..self };
        contact.turn_to(&contact.normal());
        contact
    }

    /// Returns true if the contact is a disc, not a point.
    pub(crate) fn is_round(&self) -> bool {
        self.radius > 0.0
    }

    /// The centre of the disc in the nominal posture, in m; the point itself for a point.
    pub(crate) fn center(&self) -> Vector2<f64> {
        let point = Vector2::from(self.point);
        match self.center {
            Some(center) => center.into(),
            None if self.is_round() => point + self.normal() * self.radius,
            None => point,
        }
    }

    /// Puts `point` where a disc whose centre is given is nearest to ground with this normal.
    pub(crate) fn turn_to(&mut self, normal: &Vector2<f64>) {
        if let Some(center) = self.center {
            self.point = (Vector2::from(center) - normal * self.radius).into();
        }
    }

    /// Arm of the centre from `origin` along a tangent and a normal, in m; 0 within its rounding error, so that a disc about the centre of
    /// mass is not turned by its normal force.
    pub(crate) fn arms(
        &self,
        origin: &Vector2<f64>,
        tangent: &Vector2<f64>,
        normal: &Vector2<f64>,
    ) -> (f64, f64) {
        let point = Vector2::from(self.center.unwrap_or(self.point));
        let arm = point - origin;
        let (b, c) = (tangent.dot(&arm), normal.dot(&arm));
        if !self.is_round() {
            return (b, c);
        }
        let own = self.normal();
        let up = match self.center {
            Some(_) => [0.0, 0.0],
            None if own == *normal => [0.0, 1.0],
            None => [tangent.dot(&own), normal.dot(&own)],
        };
        let terms = point.amax() + origin.amax() + self.radius;
        let known = |x: f64| {
            if x.abs() <= DISC_CENTER * f64::EPSILON * terms { 0.0 } else { x }
        };
        (known(b + self.radius * up[0]), known(c + self.radius * up[1]))
    }

    /// Unit tangent `t = (cos, sin)` of the terrain.
    #[must_use]
    pub fn tangent(&self) -> Vector2<f64> {
        direction(self.slope)
    }

    /// Unit normal `n = (−sin, cos)`, out of the terrain.
    #[must_use]
    pub fn normal(&self) -> Vector2<f64> {
        let tangent = self.tangent();
        Vector2::new(-tangent.y, tangent.x)
    }

    /// Checks the radius.
    pub(crate) fn validate_radius(&self, at: &str) -> Result<(), Error> {
        in_range(
            format_args!("{at}radius"),
            self.radius,
            (0.0..=LARGEST_RADIUS).contains(&self.radius),
            "0 <= radius <= 1e75, in m",
        )?;
        Ok(())
    }

    /// Checks the centre.
    fn validate_center(&self, at: &str) -> Result<(), Error> {
        let Some([x, y]) = self.center else { return Ok(()) };
        finite(format_args!("{at}center.x"), x)?;
        finite(format_args!("{at}center.y"), y)?;
        let distance = (Vector2::from(self.point) - Vector2::new(x, y)).norm();
        let terms = self.radius + self.point[0].abs().max(self.point[1].abs());
        if !self.is_round() || (distance - self.radius).abs() > DISC_POINT * terms {
            return Err(Error::Unusable {
                field: format!("{at}center"),
                value: format!("({x:?}, {y:?})"),
                allowed: format!(
                    "a point at the distance {at}radius = {:?} m > 0 from {at}point, which is {distance:?} m away; or left out",
                    self.radius
                ),
            });
        }
        Ok(())
    }

    /// Checks every field; `at` is the path written in front of a field's name in an error.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field.
    pub fn validate(&self, at: &str) -> Result<(), Error> {
        finite(format_args!("{at}point.x"), self.point[0])?;
        finite(format_args!("{at}point.y"), self.point[1])?;
        let allowed = match self.slope == -PI {
            true => "-pi < slope <= pi, in rad; a ceiling has slope = math.pi",
            false => "-pi < slope <= pi, in rad",
        };
        angle(format_args!("{at}slope"), self.slope, allowed)?;
        friction(format_args!("{at}friction"), self.friction)?;
        if let Some(value) = self.restitution {
            restitution(format_args!("{at}restitution"), value)?;
        }
        in_range(
            format_args!("{at}tangential_restitution"),
            self.tangential_restitution,
            (0.0..1.0).contains(&self.tangential_restitution),
            "0 <= tangential_restitution < 1",
        )?;
        surface_speed(format_args!("{at}surface_speed"), self.surface_speed)?;
        self.validate_radius(at)?;
        self.validate_center(at)?;
        let [low, high] = self.segment;
        if !(low <= 0.0 && high >= 0.0 && low < high) {
            return Err(Error::Unusable {
                field: format!("{at}segment"),
                value: format!("({low:?}, {high:?})"),
                allowed: "low <= 0 <= high with low < high".into(),
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_is_the_tangent_turned_left() {
        let c = Contact::at(0.0, 0.0).on_slope(0.3);
        let (t, n) = (c.tangent(), c.normal());
        assert_eq!((n.x, n.y), (-t.y, t.x));
    }

    #[test]
    fn arms_of_a_disc_are_those_of_its_centre() {
        let disc = Contact::at(1.0, 2.0).on_slope(0.3).with_radius(0.5);
        let (t, n) = (disc.tangent(), disc.normal());
        let origin = Vector2::new(0.2, 2.4);
        let arm = disc.center() - origin;
        let (b, c) = disc.arms(&origin, &t, &n);
        assert!((b - t.dot(&arm)).abs() < 1e-15 && (c - n.dot(&arm)).abs() < 1e-15);
        // On another piece of ground, and about the centre itself.
        let (b, c) = disc.arms(&origin, &Vector2::x(), &Vector2::y());
        assert!((b - arm.x).abs() < 1e-15 && (c - arm.y).abs() < 1e-15);
        assert_eq!(disc.arms(&disc.center(), &t, &n), (0.0, 0.0));
        assert_eq!(disc.with_radius(0.0).center(), Vector2::new(1.0, 2.0));
    }

    #[test]
    fn slopes_reach_around_the_circle() {
        let wall = Contact::at(0.0, 0.0).on_slope(FRAC_PI_2);
        assert_eq!((wall.normal(), wall.on_slope(PI).normal().y), (Vector2::new(-1.0, 0.0), -1.0));
        assert!(
            [wall, wall.on_slope(PI), wall.on_slope(-3.1)].iter().all(|k| k.validate("").is_ok())
        );
        for slope in [-PI, 3.2, f64::NAN] {
            let error = wall.on_slope(slope).validate("contacts.1.").unwrap_err().to_string();
            assert!(error.contains("contacts.1.slope") && error.contains("pi"), "{error}");
        }
        assert!(Contact { segment: [0.0, 0.0], ..wall }.validate("").is_err());
        for radius in [f64::NAN, -0.1, 2e75, f64::INFINITY] {
            let error = wall.with_radius(radius).validate("contacts.1.").unwrap_err().to_string();
            assert!(error.starts_with("contacts.1.radius = "), "{error}");
        }
        for friction in [f64::NAN, -0.1, 2e12] {
            assert!(Contact { friction, ..wall.on_slope(0.0) }.validate("").is_err());
        }
    }
}
