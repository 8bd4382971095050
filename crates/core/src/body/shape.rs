//! The usual bodies: rods, boxes, discs and polygons, of uniform density unless their radius of gyration is given.
//!
//! ```text
//! A = ½ Σ p_k × p_{k+1},   x = (1/6A) Σ (p_k + p_{k+1}) (p_k × p_{k+1}),   ρ² = (1/12A) Σ (p_k² + p_k·p_{k+1} + p_{k+1}²) (p_k × p_{k+1})
//! ```
//!
//! p is relative to the first corner for A and x, and relative to x for ρ², so that no large terms cancel.

use nalgebra::Vector2;

use crate::body::contact::Contact;
use crate::body::fields::{GroundKind, PostureFields, Surface};
use crate::body::outline::{opened, uniform_polygon};
use crate::body::posture::{MAX_CONTACTS, Posture};
use crate::error::{Error, positive};

/// The properties of a body other than its shape: see [`Posture::rod`], [`block`](Posture::block), [`disc`](Posture::disc) and
/// [`polygon`](Posture::polygon). SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Lamina {
    /// Mass m > 0, in kg.
    pub mass: f64,
    /// Radius of gyration ρ > 0, in m; `None`: that of a body of uniform density.
    pub gyration_radius: Option<f64>,
    /// Coefficient of friction of all contacts.
    pub friction: f64,
    /// Coefficient of restitution of all contacts.
    pub restitution: f64,
    /// Tangential restitution of all contacts; only some laws of impact use it.
    pub tangential_restitution: f64,
    /// Gravity g ≥ 0, in m/s².
    pub gravity: f64,
    /// Vertices of the terrain, in m, as of [`PostureFields::terrain`]. None: one level line through the lowest contact; each end of a rod then
    /// meets its own level line y = 0, and a disc the line of its slope. On a terrain the slope of a disc is that of the piece at the
    /// origin.
    pub terrain: Vec<[f64; 2]>,
    /// What each piece of the terrain is made of, as of [`PostureFields::surfaces`].
    pub surfaces: Vec<Surface>,
}

impl Posture {
    /// A symmetric rod on level ground. Its contacts are its ends (∓L, 0), its centre of mass is the origin; L is `half_length`, in m. Without
    /// a terrain each end meets only its own level line. ρ² = L²/3 unless it is given.
    ///
    /// ```
    /// use standfast::{Lamina, Posture};
    ///
    /// // ψ = (L² − ρ²)/(L² + ρ²): 1/2 for a uniform rod, 0 with all mass at the ends.
    /// let uniform = Posture::rod(0.5, &Lamina::default())?;
    /// assert!((uniform.psi()?[0] - 0.5).abs() < 1e-15);
    /// let dumbbell = Posture::rod(0.5, &Lamina { gyration_radius: Some(0.5), ..Lamina::default() })?;
    /// assert_eq!(dumbbell.psi()?, [0.0, 0.0]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Posture::new`]; `half_length` must be finite and > 0.
    pub fn rod(half_length: f64, lamina: &Lamina) -> Result<Self, Error> {
        positive("half_length", half_length)?;
        let ends = [[-half_length, 0.0], [half_length, 0.0]];
        Self::new(PostureFields {
            ground: GroundKind::Own,
            ..lamina.fields([0.0; 2], half_length / 3.0_f64.sqrt(), &ends)
        })
    }

    /// A box that stands on its lower side. The origin is the middle of this side; the contacts are its corners, from the lower left one on
    /// counterclockwise. Its centre of mass is its centre; ρ² = (w² + h²)/12 unless it is given.
    ///
    /// ```
    /// use standfast::{Lamina, Posture};
    ///
    /// let block = Posture::block(1.0, 3.0, &Lamina { friction: 0.6, ..Lamina::default() })?;
    /// assert_eq!(block.fields().center_of_mass, [0.0, 1.5]);
    /// assert_eq!(block.contacts()[2].point, [0.5, 3.0]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Posture::new`]; `width` and `height` must be finite and > 0, in m.
    pub fn block(width: f64, height: f64, lamina: &Lamina) -> Result<Self, Error> {
        positive("width", width)?;
        positive("height", height)?;
        let half = 0.5 * width;
        let corners = [[-half, 0.0], [half, 0.0], [half, height], [-half, height]];
        let uniform = libm::hypot(width, height) / 12.0_f64.sqrt();
        Self::new(PostureFields {
            outline: corners.to_vec(),
            ..lamina.fields([0.0, 0.5 * height], uniform, &corners)
        })
    }

    /// A disc on ground of this slope (rad), with a contact that is the disc itself. The origin is the point at which it touches; its centre
    /// of mass is its centre. ρ² = R²/2 unless it is given. On a terrain the slope is that of the piece at the origin.
    ///
    /// ```
    /// use standfast::{Lamina, Posture};
    ///
    /// let disc = Posture::disc(0.1, 0.0, &Lamina { friction: 0.5, ..Lamina::default() })?;
    /// assert_eq!(disc.fields().center_of_mass, [0.0, 0.1]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Posture::new`]; `radius` must be finite and > 0, in m.
    pub fn disc(radius: f64, slope: f64, lamina: &Lamina) -> Result<Self, Error> {
        positive("radius", radius)?;
        let rim = lamina.contact([0.0; 2]).on_slope(slope).with_radius(radius);
        rim.validate("")?;
        let with_center = |center: [f64; 2]| {
            Self::new(PostureFields {
                contacts: vec![rim],
                ground: GroundKind::Own,
                ..lamina.fields(center, radius / 2.0_f64.sqrt(), &[])
            })
        };
        let placed = with_center(rim.center().into())?;
        match lamina.terrain.is_empty() {
            true => Ok(placed),
            // The terrain gives the slope, and with it the centre.
            false => with_center(placed.contacts()[0].center().into()),
        }
    }

    /// A polygon in its nominal posture. `vertices`: its corners in order, in m, in either direction; the first one may stand at the end again. The contacts are its convex corners in
    /// this order. Its centre of mass is that of a polygon of uniform density, and so is ρ unless it is given.
    ///
    /// ```
    /// use standfast::{Lamina, Posture};
    ///
    /// let wedge = Posture::polygon(&[[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]], &Lamina::default())?;
    /// assert_eq!(wedge.fields().center_of_mass, [1.0, 1.0]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Posture::new`]; fewer than three vertices, edges that meet, no area, more than [`MAX_CONTACTS`] convex corners.
    pub fn polygon(vertices: &[[f64; 2]], lamina: &Lamina) -> Result<Self, Error> {
        let unusable = |value: String, allowed: &str| Error::Unusable {
            field: "vertices".into(),
            value,
            allowed: allowed.into(),
        };
        let vertices = opened(vertices);
        let uniform = uniform_polygon("vertices", vertices)?;
        let (center, count) = (uniform.center, vertices.len());
        let points: Vec<Vector2<f64>> =
            vertices.iter().map(|vertex| Vector2::from(*vertex) - center).collect();
        let turns = |k: usize| {
            let [before, here, after] =
                [(k + count - 1) % count, k, (k + 1) % count].map(|k| points[k]);
            (here - before).perp(&(after - here)) * uniform.area.signum()
        };
        let convex: Vec<[f64; 2]> =
            (0..count).filter(|&k| turns(k) > 0.0).map(|k| vertices[k]).collect();
        if convex.len() > MAX_CONTACTS {
            let allowed = format!("at most {MAX_CONTACTS} convex corners");
            return Err(unusable(format!("[{} convex corners]", convex.len()), &allowed));
        }
        Self::new(PostureFields {
            outline: vertices.to_vec(),
            ..lamina.fields(center.into(), uniform.gyration_squared.sqrt(), &convex)
        })
    }
}

impl Default for Lamina {
    /// 1 kg of uniform density without friction and restitution on level ground, with g = 9.81 m/s².
    fn default() -> Self {
        Self {
            mass: 1.0,
            gyration_radius: None,
            friction: 0.0,
            restitution: 0.0,
            tangential_restitution: 0.0,
            gravity: 9.81,
            terrain: Vec::new(),
            surfaces: Vec::new(),
        }
    }
}

impl Lamina {
    fn contact(&self, [x, y]: [f64; 2]) -> Contact {
        Contact {
            friction: self.friction,
            tangential_restitution: self.tangential_restitution,
            ..Contact::at(x, y)
        }
    }

    /// The fields of a body with contacts at these points. `uniform`: its radius of gyration if its density is uniform. Without a terrain the
    /// contacts share one line.
    fn fields(&self, center: [f64; 2], uniform: f64, points: &[[f64; 2]]) -> PostureFields {
        let shared = self.terrain.is_empty();
        PostureFields {
            mass: self.mass,
            gyration_radius: self.gyration_radius.unwrap_or(uniform),
            center_of_mass: center,
            contacts: points.iter().map(|point| self.contact(*point)).collect(),
            restitution: self.restitution,
            gravity: self.gravity,
            terrain: self.terrain.clone(),
            surfaces: self.surfaces.clone(),
            ground: if shared { GroundKind::Shared } else { GroundKind::Own },
            outline: Vec::new(),
        }
    }
}
