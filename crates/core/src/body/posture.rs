//! The body and its contacts.
//!
//! A planar rigid body of mass m and radius of gyration ρ stands in its *nominal posture*: centre of
//! mass at x, contact point i at x_i on terrain with normal n_i. A configuration q = (r_x, r_y, θ) is
//! the displacement r of the centre of mass from x and the rotation θ, counterclockwise, so that q = 0
//! is the nominal posture. The arm of contact i is d_i = x_i − x.
//!
//! ```text
//!            x (centre of mass)             h_i = n_i·(r + R(θ)d_i − d_i)        gap
//!           / \                             b_i = t_i·R(θ)d_i = ∂h_i/∂θ
//!      d_1 /   \ d_2                        c_i = n_i·R(θ)d_i,  db/dθ = −c,  dc/dθ = b
//!         /     \
//!   ____x_1_____x_2____                     gravity g points down, −e_y
//! ```

use std::sync::{Arc, OnceLock};

use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

use crate::body::contact::{Contact, PerContact};
use crate::body::contact_space::ContactSpace;
use crate::body::fields::{GroundKind, PostureFields};
use crate::body::geometry::{ContactGeometry, couplings};
use crate::body::lines::{Feet, LONGEST_HIT, Line, lines_of, without_inner_feet};
use crate::body::local_model::{LocalModel, LocalModelFields};
use crate::body::outline::{self, Outline};
use crate::body::own_ground::OwnGround;
use crate::body::placing;
use crate::body::state::State;
use crate::body::terrain::{self, Ground, Piece, Under};
use crate::error;
use crate::error::{Error, finite, in_range, positive, restitution};
use crate::math::extents::{Extent, ExtentTree};
use crate::math::turn::Turn;
use crate::math::unsigned_zero::UnsignedZero;
use crate::serial::shown_as_written;
use crate::tolerance::{PLACE, STEEPEST_REACHED, TOUCH};

shown_as_written!(GroundKind);

/// Number of corrections of a vertical displacement that brings a contact to the ground. On steep ground the displacement may be a million
/// times the gap, and the first one has the rounding error of such a length.
const CORRECTIONS: usize = 3;

/// The largest number of contacts a posture may have.
pub const MAX_CONTACTS: usize = 64;

/// A planar rigid body and the frictional contacts it may stand on. Every field is validated once.
///
/// Each contact touches only its own straight ground, unless [`PostureFields::terrain`] is given as the ground of all contacts: see
/// [`Contact`]. [`Posture::rod`], [`block`](Posture::block), [`disc`](Posture::disc) and [`polygon`](Posture::polygon) are the usual
/// bodies; [`Posture::new`] takes any other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "PostureFields", into = "PostureFields")]
pub struct Posture(Arc<Parts>);

/// The data of a posture. All copies of a posture share them, because every run keeps a copy.
#[derive(Debug, Clone, PartialEq)]
struct Parts {
    fields: PostureFields,
    geometry: PerContact<ContactGeometry>,
    /// Pieces of terrain with ends: no list, one list for all contacts, or one for each contact.
    grounds: Vec<Ground>,
    /// See [`Posture::point_of`].
    points: PerContact<usize>,
    /// The longest arm or ρ, in m.
    size: f64,
    /// The check of the straight grounds of the contacts, if there is no terrain.
    own_ground: Option<OwnGround>,
    /// The polygon of the body, if it is known.
    outline: Option<Outline>,
    /// See [`Posture::ground_corners`].
    corners: Arc<Corners>,
    /// See [`Posture::contact_space`].
    space: Cached<Arc<ContactSpace>>,
    /// See [`Posture::lines`].
    lines: Cached<Vec<Line>>,
    /// See [`Posture::outer_feet`].
    outer: Cached<Option<Posture>>,
    /// See [`Posture::feet`].
    feet: Feet,
}

/// Corners of the ground, world axes, in m.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Corners {
    pub(crate) all: Vec<Vector2<f64>>,
    pub(crate) places: ExtentTree,
}

impl Corners {
    pub(crate) fn new(all: Vec<Vector2<f64>>) -> Self {
        let places = ExtentTree::new(all.iter().map(|corner| Extent::of([*corner])));
        Self { all, places }
    }

    /// Those within a box, in order.
    pub(crate) fn within(&self, limits: Extent) -> impl Iterator<Item = &Vector2<f64>> {
        self.places.meeting(limits).map(|k| &self.all[k])
    }

    /// Those that may have a property that all boxes around them share, in order.
    pub(crate) fn of_which<F: Fn(&Extent) -> bool>(
        &self,
        may: F,
    ) -> impl Iterator<Item = &Vector2<f64>> {
        self.places.of_which(may).map(|k| &self.all[k])
    }

    /// Those that may be nearer to a point than this, in m: also some a little farther away.
    pub(crate) fn near(&self, at: &Vector2<f64>, way: f64) -> impl Iterator<Item = &Vector2<f64>> {
        let rounding = PLACE * (at.norm() + way);
        self.within(Extent::of([*at]).grown(way + rounding))
    }
}

/// A quantity that follows from the others. It is computed when it is first asked for, and has no part in comparisons.
#[derive(Debug, Clone)]
struct Cached<T>(OnceLock<T>);

impl<T> Default for Cached<T> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<T> PartialEq for Cached<T> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl TryFrom<PostureFields> for Posture {
    type Error = Error;

    fn try_from(fields: PostureFields) -> Result<Self, Error> {
        Self::new(fields)
    }
}

impl From<Posture> for PostureFields {
    fn from(posture: Posture) -> Self {
        Arc::unwrap_or_clone(posture.0).fields
    }
}

/// The longest arm or ρ, in m.
fn size(geometry: &[ContactGeometry], gyration_radius: f64) -> f64 {
    geometry.iter().map(ContactGeometry::reach).fold(gyration_radius, f64::max)
}

/// The constants of a contact on its line in the nominal posture. `at`: its place in error messages.
fn constants(
    fields: &PostureFields,
    contact: &Contact,
    at: &str,
) -> Result<ContactGeometry, Error> {
    contact.validate(at)?;
    let (tangent, normal) = (contact.tangent(), contact.normal());
    let center_of_mass = Vector2::from(fields.center_of_mass);
    let arm = Vector2::from(contact.point) - center_of_mass;
    let (b, c) = contact.arms(&center_of_mass, &tangent, &normal);
    // The impact matrix contains b²/ρ², which must not overflow.
    let reach = arm.norm() / fields.gyration_radius;
    in_range(
        format_args!("{at}point"),
        reach,
        reach < 1e150,
        "distance from the centre of mass over gyration_radius < 1e150",
    )?;
    let reach = contact.radius / fields.gyration_radius;
    in_range(
        format_args!("{at}radius"),
        reach,
        reach < 1e150,
        "radius over gyration_radius < 1e150",
    )?;
    Ok(ContactGeometry {
        tangent,
        normal,
        b,
        c,
        radius: contact.radius,
        corner: None,
        offset: 0.0,
        gravity: fields.gravity * normal.y,
        restitution: contact.restitution.unwrap_or(fields.restitution),
        friction: contact.friction,
        surface_speed: if contact.friction > 0.0 { contact.surface_speed } else { 0.0 },
    })
}

/// The number of the point of each contact, see [`Posture::point_of`].
fn points(contacts: &[Contact], geometry: &[ContactGeometry]) -> PerContact<usize> {
    let mut points = PerContact::new();
    for i in 0..contacts.len() {
        let as_one = |&j: &usize| {
            geometry[i] == geometry[j]
                && contacts[i].segment == contacts[j].segment
                && contacts[i].tangential_restitution == contacts[j].tangential_restitution
        };
        let new = points.iter().map(|k| k + 1).max().unwrap_or(0);
        let point = (0..i).find(as_one).map_or(new, |j| points[j]);
        points.push(point);
    }
    points
}

impl Posture {
    /// Validates `fields`.
    ///
    /// ```
    /// use standfast::{Contact, Posture, PostureFields};
    ///
    /// // A table: its feet are 1 m apart, its centre of mass is 0.7 m above the middle.
    /// let foot = |x| Contact { friction: 0.5, ..Contact::at(x, 0.0) };
    /// let table = Posture::new(PostureFields {
    ///     mass: 20.0,
    ///     gyration_radius: 0.5,
    ///     center_of_mass: [0.0, 0.7],
    ///     contacts: vec![foot(-0.5), foot(0.5)],
    ///     ..PostureFields::default()
    /// })?;
    /// assert_eq!(table.psi()?, [0.0, 0.0]); // ρ = half the distance: an impact at one foot does not move the other
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field, its value and what is allowed.
    pub fn new(mut fields: PostureFields) -> Result<Self, Error> {
        positive("mass", fields.mass)?;
        positive("gyration_radius", fields.gyration_radius)?;
        finite("center_of_mass.x", fields.center_of_mass[0])?;
        finite("center_of_mass.y", fields.center_of_mass[1])?;
        restitution("restitution", fields.restitution)?;
        error::gravity("gravity", fields.gravity)?;
        let count = fields.contacts.len();
        if count == 0 || count > MAX_CONTACTS {
            return Err(Error::Unusable {
                field: "contacts".into(),
                value: format!("[{count} contacts]"),
                allowed: format!("1 to {MAX_CONTACTS} contacts"),
            });
        }
        // Before the point of a disc whose centre is given follows from its ground.
        for (index, contact) in fields.contacts.iter_mut().enumerate() {
            if contact.center.is_some() {
                contact.validate(&format!("contacts.{}.", index + 1))?;
                contact.turn_to(&contact.normal());
            }
        }
        if fields.terrain.is_empty() && !fields.surfaces.is_empty() {
            return Err(Error::Unusable {
                field: "surfaces".into(),
                value: format!("[{} entries]", fields.surfaces.len()),
                allowed: "none without a terrain".into(),
            });
        }
        let mut grounds = Vec::new();
        let has_rounds = fields.contacts.iter().any(Contact::is_round);
        if has_rounds {
            placing::suits_rounds(&fields)?;
        }
        if !fields.terrain.is_empty() {
            let ground = terrain::polyline(&fields.terrain, &fields.surfaces)?;
            if has_rounds {
                grounds = placing::raised(&ground, &fields.contacts)?;
            }
            for (index, contact) in fields.contacts.iter_mut().enumerate() {
                let at = format!("contacts.{}.", index + 1);
                if contact.surface_speed != 0.0 {
                    return Err(Error::Unusable {
                        field: format!("{at}surface_speed"),
                        value: format!("{:?}", contact.surface_speed),
                        allowed: "0 on a terrain, whose pieces have speeds of their own".into(),
                    });
                }
                let raised = grounds.get(index).unwrap_or(&ground);
                placing::place_on(&ground, raised, contact, &at)?;
            }
            if !has_rounds {
                grounds.push(ground);
            }
        }
        if fields.ground == GroundKind::Shared {
            grounds = placing::shared(&fields)?;
        }
        let mut geometry = PerContact::with_capacity(count);
        for (index, contact) in fields.contacts.iter().enumerate() {
            let at = format!("contacts.{}.", index + 1);
            geometry.push(constants(&fields, contact, &at)?);
        }
        if grounds.is_empty() {
            grounds = placing::own(&fields.contacts)?;
        }
        let longest = size(&geometry, fields.gyration_radius);
        let on_polyline = !fields.terrain.is_empty() || fields.ground == GroundKind::Shared;
        let own_ground =
            (!on_polyline).then(|| OwnGround::of(&fields.contacts, &geometry, longest)).flatten();
        let corners = outline::opened(&fields.outline).len();
        fields.outline.truncate(corners);
        let outline = Outline::new(&fields)?;
        let corners = if outline.is_some() { placing::corners_of(&grounds) } else { Vec::new() };
        let corners = Arc::new(Corners::new(corners));
        let parts = Parts {
            fields,
            geometry,
            grounds,
            points: PerContact::new(),
            size: longest,
            own_ground,
            outline,
            corners,
            space: Cached::default(),
            lines: Cached::default(),
            outer: Cached::default(),
            feet: Feet::default(),
        };
        let mut posture = Self(Arc::new(parts));
        for i in 0..if on_polyline { count } else { 0 } {
            let geometry = posture.under(i, &Vector3::zeros()).geometry;
            Arc::make_mut(&mut posture.0).geometry[i] = geometry;
            posture.check_in_front(i, geometry.offset)?;
        }
        let parts = Arc::make_mut(&mut posture.0);
        parts.size = size(&parts.geometry, parts.fields.gyration_radius);
        parts.points = points(&parts.fields.contacts, &parts.geometry);
        Ok(posture)
    }

    /// Refuses contact `i` in its ground, over whose line its gap (m) is this in the nominal posture.
    fn check_in_front(&self, i: usize, gap: f64) -> Result<(), Error> {
        let gap = self.signed_gap(i, &Vector3::zeros(), gap);
        if gap >= -self.touch(i) {
            return Ok(());
        }
        let who = if self.contacts()[i].is_round() { "its disc reaches" } else { "it lies" };
        Err(Error::Unusable {
            field: format!("contacts.{}.point", i + 1),
            value: format!("{:?}", self.contacts()[i].point),
            allowed: format!(
                "on the terrain or in front of it, on the left of its polyline; {who} {:?} m in the ground",
                -gap
            ),
        })
    }

    /// The number of the point of a contact, from 0 in the order of the contacts. Contacts at one point of the body with the same terrain
    /// and the same coefficients have the same number: they move as one contact.
    pub(crate) fn point_of(&self, contact: usize) -> usize {
        self.0.points[contact]
    }

    /// The values of all contacts, from the values of the distinct contact points.
    pub(crate) fn per_contact<T>(&self, of: impl Fn(usize) -> T) -> impl Iterator<Item = T> {
        self.0.points.iter().map(move |&k| of(k))
    }

    /// The first contact at each point.
    pub(crate) fn distinct(&self) -> impl Iterator<Item = usize> + '_ {
        let points = &self.0.points;
        (0..points.len()).filter(|&i| !points[..i].contains(&points[i]))
    }

    /// The lines of the body with at least three contact points. Points of discs are on none.
    pub(crate) fn lines(&self) -> &[Line] {
        let contacts = self.contacts();
        let place = |k: usize| (self.point_of(k), Vector2::from(contacts[k].point));
        let points = || self.distinct().filter(|&k| !contacts[k].is_round()).map(place);
        self.0.lines.0.get_or_init(|| lines_of(&points().collect::<Vec<_>>(), self.size()))
    }

    /// The same body without the inner feet of long rows; `None` if there are none. Over one piece of ground it moves as the whole body.
    pub(crate) fn outer_feet(&self) -> Option<&Self> {
        self.0.outer.0.get_or_init(|| self.without_inner_feet()).as_ref()
    }

    fn without_inner_feet(&self) -> Option<Self> {
        let (all, fields) = (self.contacts(), self.fields());
        // Without walls a row is over one piece of ground where its outer feet are.
        let is_one = self.0.grounds.len() <= 1
            && self.own_ground().is_none()
            && self.ground(0).is_none_or(|ground| !ground.has_walls)
            && !self.has_belts();
        if all.len() <= LONGEST_HIT || !is_one || self.distinct().count() < all.len() {
            return None;
        }
        let (kept, feet) = without_inner_feet(self.lines(), all, self.geometry())?;
        let contacts = kept.iter().map(|&k| all[k]).collect();
        let mut outer = Self::new(PostureFields { contacts, ..fields.clone() }).ok()?;
        let same = kept.iter().zip(outer.geometry()).all(|(&k, own)| self.geometry()[k] == *own)
            && outer.0.grounds == self.0.grounds;
        Arc::make_mut(&mut outer.0).feet = feet;
        same.then_some(outer)
    }

    /// The contacts of the body with all its feet.
    pub(crate) fn feet(&self) -> &Feet {
        &self.0.feet
    }

    /// Returns true if every contact is on a straight line without ends, whose surface does not move: in the local model its row is constant.
    pub(crate) fn has_constant_rows(&self) -> bool {
        let is_line = |ground: &Ground| {
            ground.pieces.len() == 1 && ground.pieces[0].ends.iter().all(|end| end.is_endless())
        };
        (0..self.contacts().len()).all(|i| self.ground(i).is_none_or(is_line)) && !self.has_belts()
    }

    /// The largest of the values of each contact: of its own, given its geometry, and of those on the pieces of its ground.
    fn largest(
        &self,
        own: impl Fn(&ContactGeometry) -> f64,
        on: impl Fn(usize, &Piece) -> f64,
    ) -> impl ExactSizeIterator<Item = f64> {
        self.geometry().iter().enumerate().map(move |(i, k)| {
            let pieces = self.ground(i).map_or(&[][..], |ground| &ground.pieces);
            pieces.iter().map(|piece| on(i, piece)).fold(own(k), f64::max)
        })
    }

    /// The largest coefficient of friction of each contact, on any piece of its ground.
    pub(crate) fn frictions(&self) -> impl ExactSizeIterator<Item = f64> {
        self.largest(|k| k.friction, |i, piece| self.material_on(i, piece)[0])
    }

    /// The largest coefficient of restitution of each contact, on any piece of its ground.
    pub(crate) fn restitutions(&self) -> impl ExactSizeIterator<Item = f64> {
        self.largest(|k| k.restitution, |i, piece| self.material_on(i, piece)[1])
    }

    /// The first surface that moves: its name and its speed, in m/s.
    fn first_belt(&self) -> Option<(String, f64)> {
        let own = self.geometry().iter().map(|k| k.surface_speed).enumerate();
        let own = own.map(|(i, speed)| (format!("contacts.{}.surface_speed", i + 1), speed));
        let pieces = self.fields().surfaces.iter().map(|surface| surface.speed).enumerate();
        let pieces = pieces.map(|(k, speed)| (format!("surfaces.{}.speed", k + 1), speed));
        pieces.chain(own).find(|(_, speed)| *speed != 0.0)
    }

    /// Whether a surface of the ground moves.
    pub(crate) fn has_belts(&self) -> bool {
        self.geometry().iter().any(|k| k.surface_speed != 0.0)
            || self.fields().surfaces.iter().any(|surface| surface.speed != 0.0)
    }

    /// Whether the ground has no material of its own and is at rest.
    pub(crate) fn has_bare_ground(&self) -> bool {
        self.fields().surfaces.is_empty() && !self.has_belts()
    }

    /// The same posture on ground without materials: its contacts have the coefficients of the pieces they are on in the nominal posture.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if a surface moves.
    pub(crate) fn at_its_place(&self) -> Result<Self, Error> {
        if let Some((field, speed)) = self.first_belt() {
            let allowed = "0 for statics, verdicts and mechanisms: on a surface that moves nothing is at rest";
            return Err(Error::Unusable {
                field,
                value: format!("{speed:?}"),
                allowed: allowed.into(),
            });
        }
        if self.fields().surfaces.is_empty() {
            return Ok(self.clone());
        }
        let of = |(k, contact): (&ContactGeometry, &Contact)| Contact {
            friction: k.friction,
            restitution: Some(k.restitution),
            tangential_restitution: contact.tangential_restitution,
            center: contact.center,
            ..Contact::at(contact.point[0], contact.point[1]).with_radius(contact.radius)
        };
        let contacts = self.geometry().iter().zip(self.contacts()).map(of).collect();
        Self::new(PostureFields { contacts, surfaces: Vec::new(), ..self.fields().clone() })
    }

    /// The centre of mass in the nominal posture, in m.
    pub(crate) fn center(&self) -> Vector2<f64> {
        self.fields().center_of_mass.into()
    }

    /// Returns true if a contact is a disc.
    pub(crate) fn has_rounds(&self) -> bool {
        self.contacts().iter().any(Contact::is_round)
    }

    /// Positions of the contact points at `q`; of a disc, the point of it that is nearest to its ground. `local`: with the Jacobian rows of
    /// q = 0.
    pub(crate) fn points(&self, q: &Vector3<f64>, local: bool) -> Vec<[f64; 2]> {
        let turn = Turn::by(q.z);
        let (sin, less) = if local { (q.z, 0.0) } else { (turn.sin, turn.one_minus_cos) };
        let [cx, cy] = self.fields().center_of_mass;
        let point = |contact: &Contact| {
            let [x, y] = contact.point;
            let (dx, dy) = (x - cx, y - cy);
            [x + (q.x - dy * sin - dx * less), y + (q.y + dx * sin - dy * less)]
        };
        let place = |(i, contact): (usize, &Contact)| match (contact.is_round(), local) {
            (false, _) => point(contact),
            (true, false) => {
                let below = self.under(i, q).geometry.normal * contact.radius;
                (self.position(i, q) - below).into()
            }
            (true, true) => {
                let below = self.geometry()[i].normal * contact.radius;
                let [x, y] = point(contact);
                [x - below.x, y - below.y]
            }
        };
        self.contacts().iter().enumerate().map(place).collect::<Vec<_>>().unsigned_zero()
    }

    /// The check of the straight grounds of the contacts; `None`: no check is needed.
    pub(crate) fn own_ground(&self) -> Option<&OwnGround> {
        self.0.own_ground.as_ref()
    }

    /// The corners of the ground that a side of the body can meet; none without an outline.
    pub(crate) fn ground_corners(&self) -> &Arc<Corners> {
        &self.0.corners
    }

    /// The polygon of the body, if it is known.
    pub(crate) fn outline(&self) -> Option<&Outline> {
        self.0.outline.as_ref()
    }

    /// The terrain with ends: one list for all contacts, or one list for each contact; no list if each contact has one piece without ends.
    pub(crate) fn grounds(&self) -> &[Ground] {
        &self.0.grounds
    }

    /// The terrain that contact `i` may touch; `None`: a single piece without ends, or a corner of the ground on a side of the body.
    pub(crate) fn ground(&self, i: usize) -> Option<&Ground> {
        if i >= self.0.geometry.len() {
            return None;
        }
        self.0.grounds.get(i.min(self.0.grounds.len().saturating_sub(1)))
    }

    /// A copy that shares no data with this posture.
    pub(crate) fn detached(&self) -> Self {
        Self(Arc::new(Parts { outer: Cached::default(), ..Parts::clone(&self.0) }))
    }

    /// The validated fields.
    #[must_use]
    pub fn fields(&self) -> &PostureFields {
        &self.0.fields
    }

    /// The contacts, in order.
    #[must_use]
    pub fn contacts(&self) -> &[Contact] {
        &self.0.fields.contacts
    }

    pub(crate) fn geometry(&self) -> &[ContactGeometry] {
        &self.0.geometry
    }

    /// ρ², in m².
    pub(crate) fn gyration_squared(&self) -> f64 {
        self.0.fields.gyration_radius * self.0.fields.gyration_radius
    }

    /// Size of the body: the longest arm or ρ, in m.
    #[must_use]
    pub fn size(&self) -> f64 {
        self.0.size
    }

    /// Gaps h_i = n_i·(r + R(θ)d_i − d_i) at configuration `q`, in m [Or & Rimon 2008, (1)].
    ///
    /// Evaluated as n·r + b₀ sin θ − c₀ (1 − cos θ) with a compensated sum, so that a gap far smaller than the displacements keeps its
    /// digits. On terrain with ends: the gap over the piece under the point; ∞ if there is no piece under it.
    ///
    /// ```
    /// use standfast::{Lamina, Posture, State};
    ///
    /// let rod = Posture::rod(0.5, &Lamina::default())?;
    /// assert_eq!(rod.gaps(&State::at_rest([0.0, 0.25, 0.0]).q), [0.25, 0.25]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn gaps(&self, q: &Vector3<f64>) -> Vec<f64> {
        let turn = Turn::by(q.z);
        (0..self.0.geometry.len())
            .map(|i| {
                let under = self.under(i, q);
                if under.exists {
                    under.geometry.gap(q, &turn).unsigned_zero()
                } else {
                    f64::INFINITY
                }
            })
            .collect()
    }

    /// The configuration in which contact `number` (from 1) is on its ground and the body is turned by `theta`. The body is moved
    /// vertically from the nominal posture, by the smallest displacement for which no other contact is in the ground.
    ///
    /// ```
    /// use standfast::{Lamina, Posture};
    ///
    /// // A rod of half length L that stands on its left end, turned by θ: its middle is at L sin θ, its right end at 2 L sin θ.
    /// let rod = Posture::rod(0.5, &Lamina::default())?;
    /// let q = rod.touching(1, 0.1)?;
    /// assert!((q.y - 0.5 * 0.1_f64.sin()).abs() < 1e-16);
    /// assert!((rod.gaps(&q)[1] - 0.1_f64.sin()).abs() < 1e-16);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// No such contact; no ground above or below it, or only a wall; another contact in the ground.
    pub fn touching(&self, number: usize, theta: f64) -> Result<Vector3<f64>, Error> {
        let unusable = |value: String, allowed: String| {
            Err(Error::Unusable { field: "contact".into(), value, allowed })
        };
        finite("theta", theta)?;
        let count = self.contacts().len();
        if !(1..=count).contains(&number) {
            return unusable(format!("{number}"), format!("a number from 1 to {count}"));
        }
        let i = number - 1;
        let mut found: Vec<_> = self.vertically(i, theta).collect();
        found.sort_by(|one, other| one.y.abs().total_cmp(&other.y.abs()));
        found.retain(|q| self.touches(i, q));
        let in_ground = |q: &Vector3<f64>| {
            let gaps = self.gaps(q).into_iter().enumerate();
            let mut gaps = gaps.map(|(k, gap)| (k, self.signed_gap(k, q, gap)));
            gaps.find(|(k, gap)| *k != i && *gap < -TOUCH * self.size())
        };
        let Some(first) = found.first() else {
            let allowed = format!(
                "turned by this theta, contact {number} has no ground above or below it, or only a wall"
            );
            return unusable(format!("{number}"), allowed);
        };
        if let Some(q) = found.iter().find(|q| in_ground(q).is_none()) {
            return Ok(*q);
        }
        let (k, gap) = in_ground(first).unwrap_or((i, 0.0));
        let allowed = format!(
            "with contact {number} on the ground and the body turned by this theta, contact {} lies {:?} m in the ground",
            k + 1,
            -gap
        );
        unusable(format!("{number}"), allowed)
    }

    /// The configurations in which contact `i` is on the line of a piece of its ground above or below it, and the body is turned by
    /// `theta`.
    fn vertically(&self, i: usize, theta: f64) -> impl Iterator<Item = Vector3<f64>> {
        let (turned, turn) = (Vector3::new(0.0, 0.0, theta), Turn::by(theta));
        let at = self.position(i, &turned);
        let ground = self.ground(i);
        let pieces = ground.map_or(&[][..], |ground| &ground.pieces);
        // The places on arcs over or under the centre.
        let on_arcs = pieces.iter().filter_map(move |piece| piece.above(at.x)).flatten();
        let on_arcs = on_arcs.map(move |y| Vector3::new(0.0, y - at.y, theta));
        let straight = pieces.iter().filter(|piece| piece.corner().is_none());
        let over = straight.filter(move |piece| piece.is_at_x(at.x));
        let line = ground.is_none().then(|| self.geometry()[i]);
        // The pieces of a polyline have ends, so that no displacement to them is large.
        let steepest = if pieces.len() > 1 { 0.0 } else { STEEPEST_REACHED };
        let lines = line.into_iter().chain(over.map(move |piece| self.on_piece(i, piece, &at)));
        on_arcs.chain(lines.filter_map(move |k| {
            let mut q = turned;
            // A wall is touched where it is now, or at a vertex.
            if !(k.normal.y.abs() > steepest) {
                return self.touches(i, &q).then_some(q);
            }
            for _ in 0..CORRECTIONS {
                q.y -= k.gap(&q, &turn) / k.normal.y;
            }
            Some(q)
        }))
    }

    /// Returns true if a contact is on its ground at `q`, within its rounding error.
    fn touches(&self, i: usize, q: &Vector3<f64>) -> bool {
        let Under { geometry, exists, .. } = self.under(i, q);
        let known = self.place_rounding(i, q).max(TOUCH * self.size());
        exists && geometry.gap(q, &Turn::by(q.z)).abs() <= known
    }

    /// Gap rates dh_i/dt = n_i·ṙ + b_i(θ) θ̇, in m/s. If there is no piece under a point, the rate is that over the nearest piece.
    #[must_use]
    pub fn gap_rates(&self, q: &Vector3<f64>, qdot: &Vector3<f64>) -> Vec<f64> {
        let (turn, state) = (Turn::by(q.z), State { q: *q, qdot: *qdot });
        let on = |i: usize| self.under_moving(i, &state).geometry;
        (0..self.0.geometry.len()).map(|i| on(i).gap_rate(qdot, &turn).unsigned_zero()).collect()
    }

    /// Energy ½m(|ṙ|² + ρ²θ̇²) + m g r_y, in J; zero at rest in the nominal posture.
    ///
    /// ```
    /// use standfast::{Lamina, Posture, State};
    ///
    /// // ½ · 2 kg · (3 m/s)² + 2 kg · 10 m/s² · 0.5 m
    /// let rod = Posture::rod(0.5, &Lamina { mass: 2.0, gravity: 10.0, ..Lamina::default() })?;
    /// let State { q, qdot } = State::new([0.0, 0.5, 0.0], [3.0, 0.0, 0.0]);
    /// assert_eq!(rod.energy(&q, &qdot), 19.0);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn energy(&self, q: &Vector3<f64>, qdot: &Vector3<f64>) -> f64 {
        let f = &self.0.fields;
        let kinetic = qdot.x * qdot.x + qdot.y * qdot.y + self.gyration_squared() * qdot.z * qdot.z;
        (f.mass * (0.5 * kinetic + f.gravity * q.y)).unsigned_zero()
    }

    /// The two contacts of a two-contact posture.
    fn pair(&self) -> Result<[ContactGeometry; 2], Error> {
        <[ContactGeometry; 2]>::try_from(self.0.geometry.as_slice()).map_err(|_| Error::Unusable {
            field: "contacts".into(),
            value: format!("[{} contacts]", self.0.geometry.len()),
            allowed: "exactly 2 contacts for this question".into(),
        })
    }

    /// Couplings (ψ_1, ψ_2) at q = 0, dimensionless [Or & Rimon 2008, (6)]; see [`LocalModel`].
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `contacts` unless there are two.
    pub fn psi(&self) -> Result<[f64; 2], Error> {
        Ok(self.local(0.0)?.psi())
    }

    /// Couplings (φ_1, φ_2) at q = 0, in 1/m [Or & Rimon 2008, (6)]; see [`LocalModel`].
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `contacts` unless there are two.
    pub fn phi(&self) -> Result<[f64; 2], Error> {
        Ok(self.local(0.0)?.phi())
    }

    /// Gravity (g_1, g_2) into the terrain, g_i = g n_i·e_y, in m/s².
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `contacts` unless there are two.
    pub fn normal_gravity(&self) -> Result<[f64; 2], Error> {
        Ok(self.pair()?.map(|k| k.gravity.unsigned_zero()))
    }

    /// The rows of the contact points in the local model, see [`ContactSpace::of_body`].
    pub(crate) fn contact_space(&self) -> Arc<ContactSpace> {
        Arc::clone(self.0.space.0.get_or_init(|| {
            let (rho2, gravity) = (self.gyration_squared(), self.fields().gravity);
            let points: Vec<ContactGeometry> =
                self.distinct().map(|i| self.geometry()[i]).collect();
            Arc::new(ContactSpace::of_body(&points, rho2, gravity))
        }))
    }

    /// The local model at rotation `theta` (rad): all Jacobian rows frozen there.
    ///
    /// ```
    /// use standfast::{Lamina, Posture};
    ///
    /// let dumbbell = Posture::rod(0.5, &Lamina { gyration_radius: Some(0.5), ..Lamina::default() })?;
    /// let model = dumbbell.local(0.0)?;
    /// assert_eq!((model.gravity(), model.psi()), ([9.81, 9.81], [0.0, 0.0]));
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `contacts` unless there are two.
    pub fn local(&self, theta: f64) -> Result<LocalModel, Error> {
        let pair = self.pair()?;
        let arms = pair.map(|k| k.turned(&Turn::by(theta)));
        let n12 = pair[0].normal.dot(&pair[1].normal);
        let (psi, phi) = couplings(arms[0].0, arms[1].0, n12, self.gyration_squared());
        let gravity = pair.map(|k| k.gravity.unsigned_zero());
        let (psi, phi) = (psi.unsigned_zero(), phi.unsigned_zero());
        LocalModel::new(LocalModelFields {
            gravity,
            psi,
            phi,
            restitution: pair.map(|k| k.restitution),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Lamina;

    #[test]
    fn rod_couplings_by_hand() {
        // ψ = (L² − ρ²)/(L² + ρ²): ½ for the uniform rod, ρ² = L²/3.
        let rod = Posture::rod(
            0.5,
            &Lamina {
                gyration_radius: Some(0.5 / 3f64.sqrt()),
                restitution: 0.1,
                ..Lamina::default()
            },
        )
        .unwrap();
        let [psi1, psi2] = rod.psi().unwrap();
        assert!((psi1 - 0.5).abs() < 1e-15 && (psi2 - 0.5).abs() < 1e-15);
        let [phi1, phi2] = rod.phi().unwrap();
        assert!((phi1 - 1.5).abs() < 1e-15 && (phi2 + 1.5).abs() < 1e-15);
        assert_eq!(rod.normal_gravity().unwrap(), [9.81, 9.81]);
    }

    #[test]
    fn a_small_gap_keeps_its_digits() {
        // Ends at .01 and .012: r_y = .011, sin θ = .002.
        let rod = Posture::rod(
            0.5,
            &Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() },
        )
        .unwrap();
        let gaps = rod.gaps(&Vector3::new(0.0, 0.011, 0.002f64.asin()));
        assert!((gaps[0] - 0.01).abs() < 2e-18 && (gaps[1] - 0.012).abs() < 2e-18, "{gaps:?}");
    }

    #[test]
    fn rates_are_derivatives_of_gaps() {
        let fields = PostureFields {
            mass: 2.0,
            gyration_radius: 0.4,
            center_of_mass: [0.1, 0.7],
            contacts: vec![
                Contact::at(-1.0, 0.1).on_slope(-0.4),
                Contact::at(0.8, 0.3).on_slope(0.7),
            ],
            restitution: 0.3,
            gravity: 9.81,
            ..PostureFields::default()
        };
        let posture = Posture::new(fields).unwrap();
        let (q, v) = (Vector3::new(0.3, -0.2, 1.1), Vector3::new(0.5, -1.5, 2.0));
        let dt = 1e-5;
        let (later, before) = (posture.gaps(&(q + v * dt)), posture.gaps(&(q - v * dt)));
        for (i, rate) in posture.gap_rates(&q, &v).into_iter().enumerate() {
            let difference = (later[i] - before[i]) / (2.0 * dt);
            assert!((rate - difference).abs() < 1e-8, "contact {i}: {rate} {difference}");
        }
    }

    #[test]
    fn wrong_fields_are_named() {
        let rod = |e: f64, rho: f64| {
            Posture::rod(
                0.5,
                &Lamina { gyration_radius: Some(rho), restitution: e, ..Lamina::default() },
            )
            .unwrap_err()
            .to_string()
        };
        assert!(rod(1.5, 0.2).starts_with("restitution = 1.5"), "{}", rod(1.5, 0.2));
        assert!(rod(0.1, 0.0).starts_with("gyration_radius = 0.0"));
        assert!(rod(f64::NAN, 0.2).starts_with("restitution = NaN"));
        assert!(rod(0.1, f64::INFINITY).starts_with("gyration_radius = inf"));
    }
}
