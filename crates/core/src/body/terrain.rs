//! Terrain with ends: straight pieces side by side, and the one under a point of the body.
//!
//! ```text
//!          _____           from ≤ x < to: the piece under a point at x
//!    \    /     \          a point meets the piece under it, from above;
//!     \__/       \         where there is none it meets nothing
//! ```
//!
//! The ground is a function of x: it has no vertical faces and no overhangs. What has come under it from beside an end
//! meets nothing until it has left the piece again or has risen out of it.

use nalgebra::{Vector2, Vector3};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use smallvec::SmallVec;

use crate::body::contact::Contact;
use crate::body::posture::{Geometry, Posture};
use crate::error::{Error, finite};
use crate::tolerance::TOUCH;

/// Largest number of vertices of a terrain.
pub const MAX_VERTICES: usize = 1024;

/// A straight piece of ground between two verticals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// x of its ends, in m.
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// A point on it.
    pub(crate) origin: Vector2<f64>,
    pub(crate) tangent: Vector2<f64>,
    pub(crate) normal: Vector2<f64>,
    slope: f64,
}

/// Where a point is over its terrain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// The contact that this point is.
    pub(crate) contact: usize,
    /// The piece under it: −1 left of the first one, their number right of the last one.
    pub(crate) piece: isize,
    /// Horizontal distances to the ends on the left and on the right, in m.
    pub(crate) sides: [f64; 2],
}

impl Place {
    /// On terrain without ends.
    pub(crate) fn anywhere(contact: usize) -> Self {
        Self { contact, piece: 0, sides: [f64::INFINITY; 2] }
    }
}

impl Piece {
    /// The whole piece of a contact's own terrain.
    fn of_contact(contact: &Contact) -> Self {
        let (tangent, normal) = (contact.tangent(), contact.normal());
        let origin = Vector2::from(contact.point);
        let end = |along: f64| origin.x + along * tangent.x;
        let [from, to] = contact.segment.map(end);
        Self { from, to, origin, tangent, normal, slope: contact.slope }
    }

    /// From one vertex to the next.
    fn between(a: [f64; 2], b: [f64; 2]) -> Self {
        let slope = libm::atan2(b[1] - a[1], b[0] - a[0]);
        let (sin, cos) = (libm::sin(slope), libm::cos(slope));
        Self {
            from: a[0],
            to: b[0],
            origin: a.into(),
            tangent: Vector2::new(cos, sin),
            normal: Vector2::new(-sin, cos),
            slope,
        }
    }

    /// Height of a point at `at` over the line, n·(at − origin), in m.
    pub(crate) fn height(&self, at: &Vector2<f64>) -> f64 {
        self.normal.dot(&(at - self.origin))
    }
}

/// Vertices that are given: none at all is a terrain that was left out by mistake.
///
/// # Errors
///
/// An empty list.
pub(crate) fn deserialize_some<'de, D, V>(deserializer: D) -> Result<Vec<V>, D::Error>
where
    D: Deserializer<'de>,
    V: Deserialize<'de>,
{
    let vertices = Vec::deserialize(deserializer)?;
    if vertices.is_empty() {
        return Err(D::Error::invalid_length(0, &format!("2 to {MAX_VERTICES} vertices").as_str()));
    }
    Ok(vertices)
}

/// Checks the vertices (x increasing) and returns the pieces between them.
pub(crate) fn polyline(vertices: &[[f64; 2]]) -> Result<Vec<Piece>, Error> {
    let unusable = |field: String, value: String, allowed: &str| Error::Unusable {
        field,
        value,
        allowed: allowed.into(),
    };
    if vertices.len() < 2 || vertices.len() > MAX_VERTICES {
        let value = format!("[{} vertices]", vertices.len());
        let allowed = format!("2 to {MAX_VERTICES} vertices");
        return Err(unusable("terrain".into(), value, &allowed));
    }
    for (k, [x, y]) in vertices.iter().enumerate() {
        finite(format!("terrain.{}.x", k + 1), *x)?;
        finite(format!("terrain.{}.y", k + 1), *y)?;
    }
    vertices
        .windows(2)
        .enumerate()
        .map(|(k, pair)| {
            let piece = Piece::between(pair[0], pair[1]);
            let beyond = |axis: usize| format!("{:?} after {:?}", pair[1][axis], pair[0][axis]);
            if !(pair[1][0] > pair[0][0]) {
                let allowed = "x increasing from vertex to vertex: no walls, no overhangs";
                return Err(unusable(format!("terrain.{}.x", k + 2), beyond(0), allowed));
            }
            if !(piece.slope.abs() < std::f64::consts::FRAC_PI_2) {
                let allowed = "terrain that is not as steep as a wall, to the last bit";
                return Err(unusable(format!("terrain.{}.y", k + 2), beyond(1), allowed));
            }
            Ok(piece)
        })
        .collect()
}

/// What the terrain makes of a contact: its slope and segment. They may have been given, if they are these.
pub(crate) fn place_on(pieces: &[Piece], contact: &mut Contact, at: &str) -> Result<(), Error> {
    let [x, y] = contact.point;
    let Some(piece) = pieces.get(usize::try_from(find(pieces, x)).unwrap_or(usize::MAX)) else {
        let (low, high) = (pieces[0].from, pieces[pieces.len() - 1].to);
        return Err(Error::Unusable {
            field: format!("{at}point.x"),
            value: format!("{x:?}"),
            allowed: format!("from {low:?} to {high:?}, over the terrain"),
        });
    };
    let end = |end: f64| (end - x) / piece.tangent.x;
    let (slope, segment) = (piece.slope, [end(piece.from), end(piece.to)]);
    let plain = Contact::at(x, y);
    for (field, given, left_out, own) in [
        ("slope", vec![contact.slope], vec![plain.slope], vec![slope]),
        ("segment", contact.segment.to_vec(), plain.segment.to_vec(), segment.to_vec()),
    ] {
        if given != left_out && given != own {
            return Err(Error::Unusable {
                field: format!("{at}{field}"),
                value: format!("{given:?}"),
                allowed: "left out where the posture has a terrain: it follows from that".into(),
            });
        }
    }
    (contact.slope, contact.segment) = (slope, segment);
    Ok(())
}

/// The pieces of each contact's own terrain; none if all are endless.
pub(crate) fn own(contacts: &[Contact]) -> Vec<Vec<Piece>> {
    if contacts.iter().all(|contact| contact.segment == [f64::NEG_INFINITY, f64::INFINITY]) {
        return Vec::new();
    }
    contacts.iter().map(|contact| vec![Piece::of_contact(contact)]).collect()
}

/// The piece under x: a vertex belongs to the piece on its right, the last one to the last piece.
fn find(pieces: &[Piece], x: f64) -> isize {
    let after = pieces.partition_point(|piece| piece.from <= x);
    let last = pieces[pieces.len() - 1].to;
    if x > last { pieces.len() as isize } else { after as isize - 1 }
}

/// Distances from x to the ends of piece `k`.
fn sides(pieces: &[Piece], k: isize, x: f64) -> [f64; 2] {
    let first = &pieces[0];
    let last = &pieces[pieces.len() - 1];
    match usize::try_from(k).ok().map(|k| pieces.get(k)) {
        Some(Some(piece)) => [x - piece.from, piece.to - x],
        Some(None) => [x - last.to, f64::INFINITY],
        None => [f64::INFINITY, first.from - x],
    }
}

/// A contact on the piece of terrain under it.
pub(crate) struct Under {
    pub(crate) place: Place,
    /// Constants of the contact on this piece.
    pub(crate) geometry: Geometry,
    /// Whether there is a piece; if not, the geometry is that of the nearest.
    pub(crate) exists: bool,
}

impl Posture {
    /// Contact `i` on the piece of terrain under it at `q`. `frozen`: with the Jacobian rows of q = 0.
    pub(crate) fn under(&self, i: usize, q: &Vector3<f64>, frozen: bool) -> Under {
        let nominal = self.geometry()[i];
        let Some(pieces) = self.ground(i) else {
            return Under { place: Place::anywhere(i), geometry: nominal, exists: true };
        };
        let arm = nominal.tangent * nominal.b + nominal.normal * nominal.c;
        let turned = if frozen {
            -arm.y * q.z
        } else {
            let half = libm::sin(0.5 * q.z);
            -arm.y * libm::sin(q.z) - 2.0 * arm.x * half * half
        };
        let x = self.contacts()[i].point[0] + (q.x + turned);
        let piece = find(pieces, x);
        let near = piece.clamp(0, pieces.len() as isize - 1);
        Under {
            place: Place { contact: i, piece, sides: sides(pieces, piece, x) },
            geometry: self.on_piece(i, &pieces[near as usize]),
            exists: piece == near,
        }
    }

    /// Constants of contact `i` on the piece of terrain under it at `q`, and on the one beside it where that rises from a vertex in
    /// which the contact is, within [`TOUCH`] of the size of the body.
    pub(crate) fn touched(&self, i: usize, q: &Vector3<f64>) -> SmallVec<[Geometry; 2]> {
        let Under { place, geometry, exists } = self.under(i, q, false);
        let mut all = SmallVec::from_slice(&[geometry]);
        for (side, to) in [(0, -1), (1, 1)] {
            let near = exists && place.sides[side] <= TOUCH * self.size();
            if let Some(piece) = self.piece(i, place.piece + to).filter(|_| near)
                && geometry.tangent.perp(&piece.tangent) * to as f64 > 0.0
            {
                all.push(self.on_piece(i, piece));
            }
        }
        all
    }

    /// Piece `k` of the terrain of a contact.
    pub(crate) fn piece(&self, contact: usize, k: isize) -> Option<&Piece> {
        self.ground(contact)?.get(usize::try_from(k).ok()?)
    }

    /// Constants of a contact on the piece of terrain nearest to it.
    pub(crate) fn on_nearest(&self, place: &Place) -> Geometry {
        let Some(pieces) = self.ground(place.contact) else {
            return self.geometry()[place.contact];
        };
        let near = place.piece.clamp(0, pieces.len() as isize - 1);
        self.on_piece(place.contact, &pieces[near as usize])
    }

    /// Height of the lowest vertex of all terrain; −∞ if any of it has no end.
    pub(crate) fn lowest_ground(&self) -> f64 {
        let count = self.contacts().len();
        let pieces = (0..count).map(|i| self.ground(i));
        let lowest = |pieces: Option<&[Piece]>| {
            let end = |k: &Piece, x: f64| k.origin.y + (x - k.origin.x) * k.tangent.y / k.tangent.x;
            pieces.map_or(f64::NEG_INFINITY, |pieces| {
                let ends = pieces.iter().flat_map(|k| [end(k, k.from), end(k, k.to)]);
                ends.fold(
                    f64::INFINITY,
                    |low, y| if y.is_nan() { f64::NEG_INFINITY } else { low.min(y) },
                )
            })
        };
        pieces.map(lowest).fold(f64::INFINITY, f64::min)
    }

    /// Constants of contact `i` on a piece of terrain.
    pub(crate) fn on_piece(&self, i: usize, piece: &Piece) -> Geometry {
        let point = Vector2::from(self.contacts()[i].point);
        let arm = point - Vector2::from(self.fields().center_of_mass);
        let offset = piece.height(&point);
        Geometry {
            tangent: piece.tangent,
            normal: piece.normal,
            b: piece.tangent.dot(&arm),
            c: piece.normal.dot(&arm),
            // Zero where it touches within rounding.
            offset: if offset.abs() <= TOUCH * self.size() { 0.0 } else { offset },
            gravity: self.fields().gravity * piece.normal.y,
            ..self.geometry()[i]
        }
    }
}
