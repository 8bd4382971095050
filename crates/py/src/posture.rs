//! Contact, Posture and LocalModel.

use numpy::{PyArrayDyn, PyReadonlyArrayDyn};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use standfast::body::{Lamina, Surface};
use standfast::{Contact, Error, Posture, PostureFields, State};

use crate::convert::{array, call, float, local_model, pair_text, vector, word};
use crate::error::to_py;
use crate::input;

/// A point of the body, or a disc about one, and its ground. The ground is the straight line of `slope`
/// through `point`, with ends if `segment` is given; no other contact touches it. The point passes
/// through the ground of other contacts; a run warns where these grounds contradict each other. For one
/// ground for all contacts use Posture(terrain=...), which gives slope and segment.
///
/// Parameters
/// ----------
/// point : (2,) array_like or None, m, default None
///     Position in the nominal posture; there it touches its line (or is above its terrain of
///     several pieces).
/// slope : float, rad, −π < slope ≤ π, default 0.0
///     Angle of the ground: 0 level ground, π/2 a wall on the right of the body, −π/2 on its left, π a ceiling. The
///     terrain has tangent t = (cos, sin) and normal n = (−sin, cos).
/// friction : float, from 0 to 1e12, default 0.0
///     Coefficient of friction μ.
/// restitution : float or None, in [0, 1], default None
///     Coefficient of restitution; None: that of the posture.
/// tangential_restitution : float, in [0, 1), default 0.0
///     For impact laws that use it.
/// segment : (2,) array_like, m, default (-inf, inf)
///     Ends of the terrain along t.
/// radius : float, m, ≥ 0, default 0.0
///     Radius of the disc that touches at `point` in the nominal posture: its centre is at point + radius
///     · n; the disc turns with the body and rolls. 0: a point of the body.
/// center : (2,) array_like or None, m, default None
///     Centre of a disc, instead of `point`: the disc then need not touch its ground in the nominal
///     posture, and `point` is its point nearest to the ground.
/// surface_speed : float, m/s, default 0.0
///     Speed of the surface of its ground along t, as of a belt; the ground stays in its place.
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.Contact(point=(-0.5, 0.0), friction=0.5)
/// Contact(point=(-0.5, 0.0), slope=0.0, friction=0.5)
#[pyclass(frozen, eq, name = "Contact", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyContact(pub(crate) Contact);

#[pymethods]
impl PyContact {
    #[new]
    #[pyo3(signature = (point=None, slope=0.0, friction=0.0, restitution=None, tangential_restitution=0.0, segment=[f64::NEG_INFINITY, f64::INFINITY], radius=0.0, center=None, surface_speed=0.0, **unknown), text_signature = "(point=None, slope=0.0, friction=0.0, restitution=None, tangential_restitution=0.0, segment=(-1e999, 1e999), radius=0.0, center=None, surface_speed=0.0)")]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    fn new(
        #[pyo3(from_py_with = input::some_point)] point: Option<[f64; 2]>,
        #[pyo3(from_py_with = input::slope)] slope: f64,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = input::own_restitution)] restitution: Option<f64>,
        #[pyo3(from_py_with = input::tangential_restitution)] tangential_restitution: f64,
        #[pyo3(from_py_with = input::segment)] segment: [f64; 2],
        #[pyo3(from_py_with = input::radius)] radius: f64,
        #[pyo3(from_py_with = input::disc_center)] center: Option<[f64; 2]>,
        #[pyo3(from_py_with = input::surface_speed)] surface_speed: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Contact", unknown)?;
        let (Some(at), is_given) = (point.or(center), point.is_some()) else {
            return Err(PyTypeError::new_err("Contact() needs `point`, or `center` for a disc"));
        };
        let mut contact = Contact {
            point: at,
            slope,
            friction,
            restitution,
            tangential_restitution,
            radius,
            center,
            surface_speed,
            segment,
        };
        if !is_given {
            contact = contact.on_slope(slope);
        }
        contact.validate("").map_err(|e| to_py(&e))?;
        Ok(Self(contact))
    }

    #[getter]
    fn point(&self) -> (f64, f64) {
        self.0.point.into()
    }

    #[getter]
    fn slope(&self) -> f64 {
        self.0.slope
    }

    #[getter]
    fn friction(&self) -> f64 {
        self.0.friction
    }

    #[getter]
    fn restitution(&self) -> Option<f64> {
        self.0.restitution
    }

    #[getter]
    fn tangential_restitution(&self) -> f64 {
        self.0.tangential_restitution
    }

    #[getter]
    fn segment(&self) -> (f64, f64) {
        self.0.segment.into()
    }

    #[getter]
    fn radius(&self) -> f64 {
        self.0.radius
    }

    /// Of its ground along the tangent, m/s.
    #[getter]
    fn surface_speed(&self) -> f64 {
        self.0.surface_speed
    }

    /// (2,) m, if it was given.
    #[getter]
    fn center(&self) -> Option<(f64, f64)> {
        self.0.center.map(Into::into)
    }

    fn __repr__(&self) -> String {
        let c = &self.0;
        let mut text = format!(
            "Contact(point={}, slope={}, friction={}",
            pair_text(c.point),
            float(c.slope),
            float(c.friction)
        );
        if let Some(e) = c.restitution {
            text += &format!(", restitution={}", float(e));
        }
        if c.tangential_restitution != 0.0 {
            text += &format!(", tangential_restitution={}", float(c.tangential_restitution));
        }
        if c.segment != [f64::NEG_INFINITY, f64::INFINITY] {
            text += &format!(", segment={}", pair_text(c.segment));
        }
        if c.radius != 0.0 {
            text += &format!(", radius={}", float(c.radius));
        }
        if let Some(center) = c.center {
            text += &format!(", center={}", pair_text(center));
        }
        if c.surface_speed != 0.0 {
            text += &format!(", surface_speed={}", float(c.surface_speed));
        }
        text + ")"
    }

    #[allow(clippy::type_complexity, reason = "the arguments of the constructor")]
    fn __reduce__(
        &self,
        py: Python<'_>,
    ) -> (Py<PyAny>, ([f64; 2], f64, f64, Option<f64>, f64, (f64, f64), f64, Option<[f64; 2]>, f64))
    {
        let c = &self.0;
        let arguments = (
            c.point,
            c.slope,
            c.friction,
            c.restitution,
            c.tangential_restitution,
            c.segment.into(),
            c.radius,
            c.center,
            c.surface_speed,
        );
        (py.get_type::<Self>().into_any().unbind(), arguments)
    }
}

/// A planar rigid body and its contacts. Without `terrain` each contact meets only a straight ground of
/// its own, the line of its slope through its point. With `terrain` all contacts meet one ground. A
/// body that may turn over, or reach the ground of another contact, needs a terrain (or segments); a
/// run warns where the grounds of its contacts contradict each other.
///
/// A configuration q = (r_x, r_y, θ) is the displacement of the centre of mass (m) and the rotation
/// (rad, counterclockwise).
///
/// Parameters
/// ----------
/// mass : float, kg, > 0
/// gyration_radius : float, m, > 0
/// center_of_mass : (2,) array_like, m
///     In the nominal posture q = 0.
/// contacts : sequence of Contact
///     Numbered from 1.
/// restitution : float, in [0, 1]
///     Of the contacts that have none of their own.
/// gravity : float, m/s², ≥ 0, default 9.81
///     Downwards.
/// terrain : (n, 2) array_like or None, m, default None
///     Vertices (x, y) of a polyline with the ground on its right: x increases where there are
///     no walls. Each contact meets the straight piece under it (with walls: the nearest one), and
///     no ground beyond the ends; its slope and segment are computed. None: each contact has the
///     line of its own slope and segment.
/// ground : {"own", "shared"}
///     Without terrain: "own", each contact has its own line; or "shared", one line without ends for all contacts, of their slope, through the
///     lowest of them.
/// outline : (n, 2) array_like or None, m, default None
///     Corners (x, y) of the polygon of the body in its nominal posture, in order. Its sides
///     meet the corners of the terrain; with edges="ignore" these pass through, with a warning.
/// terrain_friction, terrain_restitution, terrain_speed : sequence of float or None, default None
///     Of each piece of the terrain, from vertex k to vertex k + 1: its μ, its e, and the speed of
///     its surface along it, m/s, as of a belt; None for a piece: μ and e of the contact, at rest.
///     A corner of the terrain under a side of the body has the μ and e of the side, but no
///     friction at the end of a moving piece: there it stands for a pulley.
///
/// Raises
/// ------
/// ValueError
///     Names the field, its value and the allowed range.
///
/// Examples
/// --------
/// >>> import standfast as sf
/// >>> sf.Posture(mass=1.0, gyration_radius=0.2, center_of_mass=(0.0, 0.3),
/// ...            contacts=[sf.Contact(point=(-0.5, 0.0)), sf.Contact(point=(0.5, 0.0))],
/// ...            restitution=0.1, gravity=9.81).normal_gravity
/// (9.81, 9.81)
#[pyclass(frozen, eq, name = "Posture", module = "standfast")]
#[derive(Clone, PartialEq)]
pub(crate) struct PyPosture(pub(crate) Posture);

/// A straight piece of ground: point, direction, and where it begins and ends.
type DrawnPiece = ((f64, f64), (f64, f64), f64, f64);

#[pymethods]
impl PyPosture {
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(signature = (mass, gyration_radius, center_of_mass, contacts, restitution, gravity=9.81, terrain=Vec::new(), ground="own", outline=Vec::new(), terrain_friction=Vec::new(), terrain_restitution=Vec::new(), terrain_speed=Vec::new(), **unknown), text_signature = "(mass, gyration_radius, center_of_mass, contacts, restitution, gravity=9.81, terrain=None, ground=\"own\", outline=None, terrain_friction=None, terrain_restitution=None, terrain_speed=None)")]
    fn new(
        #[pyo3(from_py_with = input::mass)] mass: f64,
        #[pyo3(from_py_with = input::gyration_radius)] gyration_radius: f64,
        #[pyo3(from_py_with = input::center_of_mass)] center_of_mass: [f64; 2],
        #[pyo3(from_py_with = contacts)] contacts: Vec<Contact>,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        #[pyo3(from_py_with = input::gravity)] gravity: f64,
        #[pyo3(from_py_with = input::terrain)] terrain: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::ground)] ground: &str,
        #[pyo3(from_py_with = input::outline)] outline: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::terrain_friction)] terrain_friction: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_restitution)] terrain_restitution: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_speed)] terrain_speed: Vec<Option<f64>>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Posture", unknown)?;
        let surfaces =
            input::surfaces(&terrain, terrain_friction, terrain_restitution, terrain_speed)?;
        Posture::new(PostureFields {
            mass,
            gyration_radius,
            center_of_mass,
            contacts,
            restitution,
            gravity,
            terrain,
            surfaces,
            ground: call("ground", ground)?,
            outline,
        })
        .map(Self)
        .map_err(|e| to_py(&e))
    }

    /// The symmetric rod of mass 1 on level ground: ends at (∓half_length, 0), centre at 0.
    ///
    /// Parameters
    /// ----------
    /// half_length : float, m, > 0
    /// gyration_radius : float or None, m, > 0, default None
    ///     None: of uniform density, half_length/√3.
    /// restitution, friction : float, default 0.0
    ///     Of both ends.
    /// gravity : float, m/s², ≥ 0, default 9.81
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> sf.Posture.rod(half_length=0.5, gyration_radius=0.5, restitution=0.1).psi
    /// (0.0, 0.0)
    ///
    /// A uniform rod, turned by 0.2 rad, its left end 0.1 m above the ground:
    ///
    /// >>> rod = sf.Posture.rod(half_length=0.5, restitution=0.5)
    /// >>> q = rod.touching(contact=1, theta=0.2) + [0, 0.1, 0]
    #[staticmethod]
    #[pyo3(signature = (half_length, gyration_radius=None, restitution=0.0, friction=0.0, gravity=9.81, **unknown), text_signature = "(half_length, gyration_radius=None, restitution=0.0, friction=0.0, gravity=9.81)")]
    fn rod(
        #[pyo3(from_py_with = input::half_length)] half_length: f64,
        #[pyo3(from_py_with = input::own_gyration_radius)] gyration_radius: Option<f64>,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = input::gravity)] gravity: f64,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        input::no_keywords("Posture.rod", unknown)?;
        let lamina =
            Lamina { gyration_radius, restitution, friction, gravity, ..Lamina::default() };
        Posture::rod(half_length, &lamina).map(Self).map_err(|e| to_py(&e))
    }

    /// A box of uniform density that stands on its lower side. The origin is the middle of this side. The
    /// contacts are its corners, from the lower left one on counterclockwise; gyration_radius² = (width² +
    /// height²)/12.
    ///
    /// Parameters
    /// ----------
    /// width, height : float, m, > 0
    /// mass : float, kg, > 0, default 1.0
    /// friction, restitution, tangential_restitution : float, default 0.0
    ///     Of all corners.
    /// gravity : float, m/s², ≥ 0, default 9.81
    /// terrain : (n, 2) array_like or None, m, default None
    ///     As of `Posture`; None: one level ground, y = 0.
    /// terrain_friction, terrain_restitution, terrain_speed : sequence of float or None, default None
    ///     For each piece of the terrain, as of `Posture`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> crate = sf.Posture.box(width=1.0, height=3.0)
    /// >>> [contact.point for contact in crate.contacts]
    /// [(-0.5, 0.0), (0.5, 0.0), (0.5, 3.0), (-0.5, 3.0)]
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(name = "box", signature = (width, height, mass=1.0, friction=0.0, restitution=0.0, gravity=9.81, tangential_restitution=0.0, terrain=Vec::new(), terrain_friction=Vec::new(), terrain_restitution=Vec::new(), terrain_speed=Vec::new(), **unknown), text_signature = "(width, height, mass=1.0, friction=0.0, restitution=0.0, gravity=9.81, tangential_restitution=0.0, terrain=None, terrain_friction=None, terrain_restitution=None, terrain_speed=None)")]
    fn block(
        #[pyo3(from_py_with = input::width)] width: f64,
        #[pyo3(from_py_with = input::height)] height: f64,
        #[pyo3(from_py_with = input::mass)] mass: f64,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        #[pyo3(from_py_with = input::gravity)] gravity: f64,
        #[pyo3(from_py_with = input::tangential_restitution)] tangential_restitution: f64,
        #[pyo3(from_py_with = input::terrain)] terrain: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::terrain_friction)] terrain_friction: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_restitution)] terrain_restitution: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_speed)] terrain_speed: Vec<Option<f64>>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let surfaces =
            input::surfaces(&terrain, terrain_friction, terrain_restitution, terrain_speed)?;
        let lamina = Lamina {
            mass,
            gyration_radius: None,
            friction,
            restitution,
            tangential_restitution,
            gravity,
            terrain,
            surfaces,
        };
        input::no_keywords("Posture.box", unknown)?;
        Posture::block(width, height, &lamina).map(Self).map_err(|e| to_py(&e))
    }

    /// A disc on level ground that rolls and slides; the origin is the point at which it touches, its
    /// centre is (0, radius).
    ///
    /// Parameters
    /// ----------
    /// radius : float, m, > 0
    /// mass : float, kg, > 0, default 1.0
    /// gyration_radius : float or None, m, default None
    ///     None: that of a solid disc, radius/√2.
    /// friction : float, from 0 to 1e12, default 0.0
    ///     μ of all contacts.
    /// restitution : float, in [0, 1], default 0.0
    /// gravity : float, m/s², ≥ 0, default 9.81
    /// tangential_restitution : float, in [0, 1), default 0.0
    ///     Of all contacts.
    /// slope : float, rad, default 0.0
    ///     Of its ground; the centre is then at radius · (−sin slope, cos slope).
    /// terrain : (n, 2) array_like or None, m, default None
    ///     As of `Posture`; the disc touches it at the origin. None: one line of `slope`.
    /// terrain_friction, terrain_restitution, terrain_speed : sequence of float or None, default None
    ///     For each piece of the terrain, as of `Posture`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> wheel = sf.Posture.disc(radius=0.1, friction=0.5)
    /// >>> wheel.center_of_mass, wheel.contacts[0].radius
    /// ((0.0, 0.1), 0.1)
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(signature = (radius, mass=1.0, gyration_radius=None, friction=0.0, restitution=0.0, gravity=9.81, tangential_restitution=0.0, slope=0.0, terrain=Vec::new(), terrain_friction=Vec::new(), terrain_restitution=Vec::new(), terrain_speed=Vec::new(), **unknown), text_signature = "(radius, mass=1.0, gyration_radius=None, friction=0.0, restitution=0.0, gravity=9.81, tangential_restitution=0.0, slope=0.0, terrain=None, terrain_friction=None, terrain_restitution=None, terrain_speed=None)")]
    fn disc(
        #[pyo3(from_py_with = input::radius)] radius: f64,
        #[pyo3(from_py_with = input::mass)] mass: f64,
        #[pyo3(from_py_with = input::own_gyration_radius)] gyration_radius: Option<f64>,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        #[pyo3(from_py_with = input::gravity)] gravity: f64,
        #[pyo3(from_py_with = input::tangential_restitution)] tangential_restitution: f64,
        #[pyo3(from_py_with = input::slope)] slope: f64,
        #[pyo3(from_py_with = input::terrain)] terrain: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::terrain_friction)] terrain_friction: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_restitution)] terrain_restitution: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_speed)] terrain_speed: Vec<Option<f64>>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let surfaces =
            input::surfaces(&terrain, terrain_friction, terrain_restitution, terrain_speed)?;
        let lamina = Lamina {
            mass,
            gyration_radius,
            friction,
            restitution,
            tangential_restitution,
            gravity,
            terrain,
            surfaces,
        };
        input::no_keywords("Posture.disc", unknown)?;
        Posture::disc(radius, slope, &lamina).map(Self).map_err(|e| to_py(&e))
    }

    /// A polygon of uniform density: its area, centre of mass and radius of gyration are computed. The
    /// contacts are its convex corners, in the order given.
    ///
    /// Parameters
    /// ----------
    /// vertices : (k, 2) array_like, m
    ///     Corners in the nominal posture, in either direction; the first may stand at the end again.
    /// mass : float, kg, > 0, default 1.0
    /// friction : float, from 0 to 1e12, default 0.0
    ///     μ of all contacts.
    /// restitution : float, in [0, 1], default 0.0
    /// gravity : float, m/s², ≥ 0, default 9.81
    /// tangential_restitution : float, in [0, 1), default 0.0
    ///     Of all contacts.
    /// terrain : (n, 2) array_like or None, m, default None
    ///     As of `Posture`; None: all corners meet one level ground through
    ///     the lowest one.
    /// terrain_friction, terrain_restitution, terrain_speed : sequence of float or None, default None
    ///     For each piece of the terrain, as of `Posture`.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> wedge = sf.Posture.polygon([(0, 0), (3, 0), (0, 3)])
    /// >>> wedge.center_of_mass, len(wedge.contacts)
    /// ((1.0, 1.0), 3)
    #[staticmethod]
    #[allow(clippy::too_many_arguments, reason = "the arguments of the constructor")]
    #[pyo3(signature = (vertices, mass=1.0, friction=0.0, restitution=0.0, gravity=9.81, tangential_restitution=0.0, terrain=Vec::new(), terrain_friction=Vec::new(), terrain_restitution=Vec::new(), terrain_speed=Vec::new(), **unknown), text_signature = "(vertices, mass=1.0, friction=0.0, restitution=0.0, gravity=9.81, tangential_restitution=0.0, terrain=None, terrain_friction=None, terrain_restitution=None, terrain_speed=None)")]
    fn polygon(
        #[pyo3(from_py_with = input::vertices)] vertices: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::mass)] mass: f64,
        #[pyo3(from_py_with = input::friction)] friction: f64,
        #[pyo3(from_py_with = input::restitution)] restitution: f64,
        #[pyo3(from_py_with = input::gravity)] gravity: f64,
        #[pyo3(from_py_with = input::tangential_restitution)] tangential_restitution: f64,
        #[pyo3(from_py_with = input::terrain)] terrain: Vec<[f64; 2]>,
        #[pyo3(from_py_with = input::terrain_friction)] terrain_friction: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_restitution)] terrain_restitution: Vec<Option<f64>>,
        #[pyo3(from_py_with = input::terrain_speed)] terrain_speed: Vec<Option<f64>>,
        unknown: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let surfaces =
            input::surfaces(&terrain, terrain_friction, terrain_restitution, terrain_speed)?;
        let lamina = Lamina {
            mass,
            gyration_radius: None,
            friction,
            restitution,
            tangential_restitution,
            gravity,
            terrain,
            surfaces,
        };
        input::no_keywords("Posture.polygon", unknown)?;
        Posture::polygon(&vertices, &lamina).map(Self).map_err(|e| to_py(&e))
    }

    #[getter]
    fn mass(&self) -> f64 {
        self.0.fields().mass
    }

    #[getter]
    fn gyration_radius(&self) -> f64 {
        self.0.fields().gyration_radius
    }

    #[getter]
    fn center_of_mass(&self) -> (f64, f64) {
        self.0.fields().center_of_mass.into()
    }

    #[getter]
    fn contacts(&self) -> Vec<PyContact> {
        self.0.contacts().iter().copied().map(PyContact).collect()
    }

    /// The sides of the outline that touch corners of the ground in the nominal posture, list of Contact: each at the corner, on a line along the
    /// side. The contact modes at rest, the static forces and the verdict of the posture have them after its contacts.
    #[getter]
    fn side_contacts(&self) -> Vec<PyContact> {
        self.0.side_contacts().into_iter().map(PyContact).collect()
    }

    #[getter]
    fn restitution(&self) -> f64 {
        self.0.fields().restitution
    }

    #[getter]
    fn gravity(&self) -> f64 {
        self.0.fields().gravity
    }

    /// Vertices (x, y) of the terrain, m; None if each contact has its own.
    #[getter]
    fn terrain(&self) -> Option<Vec<(f64, f64)>> {
        let vertices = &self.0.fields().terrain;
        (!vertices.is_empty()).then(|| vertices.iter().map(|&vertex| vertex.into()).collect())
    }

    /// Coefficient of friction of each piece of the terrain, None where that of the contact holds; None if no piece has one.
    #[getter]
    fn terrain_friction(&self) -> Option<Vec<Option<f64>>> {
        self.of_pieces(|surface| surface.friction)
    }

    /// Coefficient of restitution of each piece of the terrain, likewise.
    #[getter]
    fn terrain_restitution(&self) -> Option<Vec<Option<f64>>> {
        self.of_pieces(|surface| surface.restitution)
    }

    /// Speed of the surface of each piece of the terrain along its tangent, m/s; None if all are at rest.
    #[getter]
    fn terrain_speed(&self) -> Option<Vec<Option<f64>>> {
        self.of_pieces(|surface| Some(surface.speed).filter(|speed| *speed != 0.0))
    }

    /// Corners (x, y) of the polygon of the body in its nominal posture, m; None if only its contacts are known.
    #[getter]
    fn outline(&self) -> Option<Vec<(f64, f64)>> {
        let corners = &self.0.fields().outline;
        (!corners.is_empty()).then(|| corners.iter().map(|&corner| corner.into()).collect())
    }

    /// "own": without terrain each contact has its own line; "shared": all contacts meet one line.
    #[getter]
    fn ground(&self) -> String {
        word(&self.0.fields().ground)
    }

    /// A copy with other parameters, by their paths as in `sweep`: {"restitution": 0.2,
    /// "contacts.1.friction": 0.4}.
    ///
    /// Parameters
    /// ----------
    /// **parameters : float
    ///     Their values, by their paths.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    /// >>> rod.replace(mass=2.0, **{"contacts.2.point.x": 0.6}).contacts[1].point
    /// (0.6, 0.0)
    #[pyo3(signature = (**parameters))]
    fn replace(&self, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut values = Vec::new();
        for (path, value) in parameters.into_iter().flatten() {
            let path = path.to_string();
            let value = input::parameter(&path, &value)?;
            values.push((path, value));
        }
        standfast::sweep::replaced(&self.0, &values).map(Self).map_err(|e| to_py(&e))
    }

    /// The configuration q, (3,), in which contact number `contact` is on its ground with the body turned
    /// by theta (rad): a vertical displacement from the nominal posture, the least one with no other
    /// contact in the ground.
    ///
    /// Parameters
    /// ----------
    /// contact : int
    ///     Its number, from 1.
    /// theta : float, rad
    ///     Turn of the body.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Where there is none.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> crate = sf.Posture.box(width=1.0, height=3.0)
    /// >>> crate.touching(contact=2, theta=-0.1).round(4).tolist()
    /// [0.0, 0.0424, -0.1]
    fn touching<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = input::contact)] contact: usize,
        #[pyo3(from_py_with = input::theta)] theta: f64,
    ) -> PyResult<Bound<'py, numpy::PyArray1<f64>>> {
        self.0.touching(contact, theta).map(|q| vector(py, &q)).map_err(|e| to_py(&e))
    }

    /// The corners (k, 2) of the body in its nominal posture as pictures show them, in order, m: its outline; without one, the convex hull of the
    /// contacts, with a polygon for each disc. A body on one contact that is a point has none.
    #[getter]
    fn drawn_corners(&self) -> Vec<(f64, f64)> {
        self.0.drawn_corners().into_iter().map(Into::into).collect()
    }

    /// The ground as pictures show it: straight pieces (point, direction, low, high), with the air on the
    /// left of the direction, which is a unit vector; low and high: where the piece begins and ends, m from
    /// the point along the direction. Lines of contacts end where they meet.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> sf.Posture.rod(half_length=0.5, gyration_radius=0.5, restitution=0.1).drawn_ground
    /// [((0.5, 0.0), (1.0, 0.0), -inf, inf)]
    #[getter]
    fn drawn_ground(&self) -> Vec<DrawnPiece> {
        let pieces = self.0.drawn_ground().into_iter();
        pieces.map(|p| (p.point.into(), p.direction.into(), p.ends[0], p.ends[1])).collect()
    }

    /// Couplings (ψ_1, ψ_2) of the gap rates at q = 0, dimensionless. Two contacts only.
    #[getter]
    fn psi(&self) -> PyResult<(f64, f64)> {
        self.0.psi().map(Into::into).map_err(|e| to_py(&e))
    }

    /// Couplings (φ_1, φ_2) to the rotation at q = 0, 1/m. Two contacts only.
    #[getter]
    fn phi(&self) -> PyResult<(f64, f64)> {
        self.0.phi().map(Into::into).map_err(|e| to_py(&e))
    }

    /// Gravity (g_1, g_2) into the terrain, m/s². Two contacts only.
    #[getter]
    fn normal_gravity(&self) -> PyResult<(f64, f64)> {
        self.0.normal_gravity().map(Into::into).map_err(|e| to_py(&e))
    }

    /// Gaps of n contacts, (..., n) m, at configurations; inf where there is no ground under a
    /// contact.
    ///
    /// Parameters
    /// ----------
    /// q : (..., 3) array_like, m, m, rad
    ///     Configurations.
    ///
    /// Examples
    /// --------
    /// >>> import standfast as sf
    /// >>> rod = sf.Posture.rod(half_length=0.5, gyration_radius=0.2, restitution=0.1)
    /// >>> rod.gaps([[0, 0, 0], [0, 0.25, 0]])
    /// array([[0.  , 0.  ],
    ///        [0.25, 0.25]])
    fn gaps<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let q = input::triples("q", q)?;
        let values = rows(&q).flat_map(|row| self.0.gaps(&row.into())).collect();
        shaped(py, values, q.as_array().shape(), self.0.contacts().len())
    }

    /// Gap rates of n contacts, (..., n) m/s.
    ///
    /// Parameters
    /// ----------
    /// q, qdot : (..., 3) array_like
    ///     Configurations, m, m, rad, and velocities, of the same shape.
    fn gap_rates<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        qdot: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let (q, qdot) = (input::triples("q", q)?, input::triples("qdot", qdot)?);
        if q.as_array().shape() != qdot.as_array().shape() {
            return Err(to_py(&Error::Unusable {
                field: "qdot".into(),
                value: format!("array of shape {:?}", qdot.as_array().shape()),
                allowed: format!("the shape of q, {:?}", q.as_array().shape()),
            }));
        }
        let values = rows(&q)
            .zip(rows(&qdot))
            .flat_map(|(q, qdot)| self.0.gap_rates(&q.into(), &qdot.into()))
            .collect();
        shaped(py, values, q.as_array().shape(), self.0.contacts().len())
    }

    /// The local model: all Jacobian rows frozen at one rotation. Two contacts only.
    ///
    /// Parameters
    /// ----------
    /// q : (3,) array_like, m, m, rad, default (0.0, 0.0, 0.0)
    ///     The configuration with this rotation.
    #[pyo3(signature = (q=[0.0, 0.0, 0.0]), text_signature = "($self, q=(0.0, 0.0, 0.0))")]
    fn local<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = input::q)] q: [f64; 3],
    ) -> PyResult<Bound<'py, PyAny>> {
        State::at_rest(q).validate().map_err(|e| to_py(&e))?;
        local_model(py, &self.0.local(q[2]).map_err(|e| to_py(&e))?)
    }

    fn __repr__(&self) -> String {
        let f = self.0.fields();
        let contacts: Vec<String> =
            f.contacts.iter().map(|contact| PyContact(*contact).__repr__()).collect();
        let points = |name: &str, points: &[[f64; 2]]| match points {
            [] => String::new(),
            points => {
                let texts: Vec<String> = points.iter().map(|&point| pair_text(point)).collect();
                format!(", {name}=[{}]", texts.join(", "))
            }
        };
        let (terrain, outline) = (points("terrain", &f.terrain), points("outline", &f.outline));
        let of_pieces = |(name, values): (&str, Option<Vec<Option<f64>>>)| {
            let entry = |value: &Option<f64>| value.map_or_else(|| "None".into(), float);
            let texts = values?.iter().map(entry).collect::<Vec<String>>();
            Some(format!(", {name}=[{}]", texts.join(", ")))
        };
        let materials: String = [
            ("terrain_friction", self.terrain_friction()),
            ("terrain_restitution", self.terrain_restitution()),
            ("terrain_speed", self.terrain_speed()),
        ]
        .into_iter()
        .filter_map(of_pieces)
        .collect();
        let ground = match self.ground().as_str() {
            "own" => String::new(),
            ground => format!(", ground='{ground}'"),
        };
        format!(
            "Posture(mass={}, gyration_radius={}, center_of_mass={}, contacts=[{}], restitution={}, gravity={}{terrain}{ground}{outline}{materials})",
            float(f.mass),
            float(f.gyration_radius),
            pair_text(f.center_of_mass),
            contacts.join(", "),
            float(f.restitution),
            float(f.gravity)
        )
    }

    /// The HTML that a notebook shows.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("standfast.notebook")?.call_method1("of_posture", (slf,))
    }

    #[allow(clippy::type_complexity, reason = "the arguments of the constructor")]
    fn __reduce__(
        &self,
        py: Python<'_>,
    ) -> (
        Py<PyAny>,
        (
            f64,
            f64,
            [f64; 2],
            Vec<PyContact>,
            f64,
            f64,
            Points,
            String,
            Points,
            PerPiece,
            PerPiece,
            PerPiece,
        ),
    ) {
        let f = self.0.fields();
        let arguments = (
            f.mass,
            f.gyration_radius,
            f.center_of_mass,
            self.contacts(),
            f.restitution,
            f.gravity,
            self.terrain(),
            self.ground(),
            self.outline(),
            self.terrain_friction(),
            self.terrain_restitution(),
            self.terrain_speed(),
        );
        (py.get_type::<Self>().into_any().unbind(), arguments)
    }
}

impl PyPosture {
    /// A value of each piece of the terrain; None if no piece has one.
    fn of_pieces(&self, of: impl Fn(&Surface) -> Option<f64>) -> Option<Vec<Option<f64>>> {
        let values: Vec<Option<f64>> = self.0.fields().surfaces.iter().map(of).collect();
        values.iter().any(Option::is_some).then_some(values)
    }
}

/// A value of each piece of a terrain, if there are any.
type PerPiece = Option<Vec<Option<f64>>>;

/// Points (x, y), if there are any.
type Points = Option<Vec<(f64, f64)>>;

/// Reads the contacts of a posture.
fn contacts(value: &Bound<'_, PyAny>) -> PyResult<Vec<Contact>> {
    input::per_contact("contacts", value, |field, item| {
        let contact = item.cast::<PyContact>();
        let contact = contact.map_err(|_| input::wrong_type(field, item, "a Contact is needed"))?;
        Ok(contact.get().0)
    })
}

/// Reads a posture.
pub(crate) fn posture(value: &Bound<'_, PyAny>) -> PyResult<PyPosture> {
    let posture = value.cast::<PyPosture>();
    posture
        .map(|found| found.get().clone())
        .map_err(|_| input::wrong_type("posture", value, "a Posture is needed"))
}

fn rows<'a>(array: &'a PyReadonlyArrayDyn<'_, f64>) -> impl Iterator<Item = [f64; 3]> + use<'a> {
    array
        .as_array()
        .rows()
        .into_iter()
        .map(|row| [row[0], row[1], row[2]])
        .collect::<Vec<_>>()
        .into_iter()
}

/// Values as an array whose last axis, of length 3 before, has length `last`.
fn shaped<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    shape: &[usize],
    last: usize,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let mut shape = shape.to_vec();
    if let Some(axis) = shape.last_mut() {
        *axis = last;
    }
    array(py, values, &shape)
}
