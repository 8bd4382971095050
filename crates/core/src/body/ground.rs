//! The piece of terrain under a contact.

use nalgebra::{Vector2, Vector3};
use smallvec::SmallVec;

use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::terrain::{End, Ground, Piece, Place};
use crate::tolerance::TOUCH;

/// A contact on the piece of terrain under it.
pub(crate) struct Under {
    pub(crate) place: Place,
    /// Constants of the contact on this piece.
    pub(crate) geometry: ContactGeometry,
    /// Whether there is a piece under the contact; if not, the geometry is that of the nearest piece.
    pub(crate) exists: bool,
}

impl Posture {
    /// Contact `i` on the piece of terrain under it at `q`. `frozen`: with the Jacobian rows of q = 0.
    pub(crate) fn under(&self, i: usize, q: &Vector3<f64>, frozen: bool) -> Under {
        let nominal = self.geometry()[i];
        let Some(ground) = self.ground(i) else {
            return Under { place: Place::anywhere(i), geometry: nominal, exists: true };
        };
        let arm = nominal.tangent * nominal.b + nominal.normal * nominal.c;
        let turned = if frozen {
            Vector2::new(-arm.y, arm.x) * q.z
        } else {
            let (half, sin) = (libm::sin(0.5 * q.z), libm::sin(q.z));
            Vector2::new(
                -arm.y * sin - 2.0 * arm.x * half * half,
                arm.x * sin - 2.0 * arm.y * half * half,
            )
        };
        let at = Vector2::from(self.contacts()[i].point) + (q.xy() + turned);
        let piece = ground.find(&at);
        let (near, exists) = ground.nearest(piece);
        Under { place: ground.place(i, piece, &at), geometry: self.on_piece(i, near), exists }
    }

    /// Constants of contact `i` on the piece of terrain under it at `q`. If the contact is in a vertex, within [`TOUCH`] of the size of the
    /// body, also on the next piece where that rises from the vertex.
    pub(crate) fn touched(&self, i: usize, q: &Vector3<f64>) -> SmallVec<[ContactGeometry; 2]> {
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
        self.ground(contact)?.pieces.get(usize::try_from(k).ok()?)
    }

    /// Constants of a contact on the piece of terrain nearest to it.
    pub(crate) fn on_nearest(&self, place: &Place) -> ContactGeometry {
        let Some(ground) = self.ground(place.contact) else {
            return self.geometry()[place.contact];
        };
        self.on_piece(place.contact, ground.nearest(place.piece).0)
    }

    /// Height of the lowest vertex of the terrain; −∞ if a piece has no end.
    pub(crate) fn lowest_ground(&self) -> f64 {
        let count = self.contacts().len();
        let lowest = |ground: Option<&Ground>| {
            ground.map_or(f64::NEG_INFINITY, |ground| {
                let low =
                    |end: End| if end.is_endless() { f64::NEG_INFINITY } else { end.vertex.y };
                ground.pieces.iter().flat_map(|k| k.ends.map(low)).fold(f64::INFINITY, f64::min)
            })
        };
        (0..count).map(|i| lowest(self.ground(i))).fold(f64::INFINITY, f64::min)
    }

    /// Constants of contact `i` on a piece of terrain.
    pub(crate) fn on_piece(&self, i: usize, piece: &Piece) -> ContactGeometry {
        let point = Vector2::from(self.contacts()[i].point);
        let arm = point - Vector2::from(self.fields().center_of_mass);
        let offset = piece.height(&point);
        ContactGeometry {
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
