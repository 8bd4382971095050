//! Terrain with ends: adjacent straight pieces, and the choice of the piece under a point of the body.
//!
//! ```text
//!          _____           from ≤ x < to: the piece under a point at x
//!    \    /     \          a point touches the piece under it, from above;
//!     \__/       \         beyond the ends it touches nothing
//! ```
//!
//! The ground is a function of x: it has no vertical faces and no overhangs. A point that has come under a piece from beyond its end does
//! not touch it until it has left the piece or has risen above it.

use nalgebra::Vector2;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use crate::body::contact::Contact;
use crate::error::{Error, finite};

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

/// The position of a point relative to the pieces of its terrain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// The contact of this point.
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

/// Checks that a terrain that is given has vertices: an empty list is a mistake.
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

/// Sets slope and segment of a contact from the terrain. If they are given, they must be equal to these.
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

/// The pieces of each contact's own terrain; an empty list if no piece has ends.
pub(crate) fn own(contacts: &[Contact]) -> Vec<Vec<Piece>> {
    if contacts.iter().all(|contact| contact.segment == [f64::NEG_INFINITY, f64::INFINITY]) {
        return Vec::new();
    }
    contacts.iter().map(|contact| vec![Piece::of_contact(contact)]).collect()
}

/// The piece under x: a vertex belongs to the piece on its right, the last one to the last piece.
pub(super) fn find(pieces: &[Piece], x: f64) -> isize {
    let after = pieces.partition_point(|piece| piece.from <= x);
    let last = pieces[pieces.len() - 1].to;
    if x > last { pieces.len() as isize } else { after as isize - 1 }
}

/// Distances from x to the ends of piece `k`.
pub(super) fn sides(pieces: &[Piece], k: isize, x: f64) -> [f64; 2] {
    let first = &pieces[0];
    let last = &pieces[pieces.len() - 1];
    match usize::try_from(k).ok().map(|k| pieces.get(k)) {
        Some(Some(piece)) => [x - piece.from, piece.to - x],
        Some(None) => [x - last.to, f64::INFINITY],
        None => [f64::INFINITY, first.from - x],
    }
}
