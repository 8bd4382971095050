//! Corners of the ground on sides of the body, in a given configuration.

use nalgebra::{Vector2, Vector3};

use crate::body::contact::Contact;
use crate::body::geometry::ContactGeometry;
use crate::body::outline::Side;
use crate::body::posture::Posture;
use crate::body::terrain::Piece;
use crate::error::Error;
use crate::math::extents::Extent;
use crate::math::turn::{Turn, turned};
use crate::tolerance::{PLACE, TOUCH};

/// A corner of the ground that touches a side between its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TouchedSide {
    /// The corner, world axes, in m.
    pub(crate) corner: Vector2<f64>,
    /// The number of the side, from 0.
    pub(crate) side: usize,
    /// Its axes and arm in this configuration: t along the side with the body on its left, n into the body. As long as nothing turns it is
    /// a contact point of the body on a line.
    pub(crate) geometry: ContactGeometry,
}

impl Posture {
    /// A corner of the ground and a side at `q`: axes and arm of their contact, its gap, and the distances along the side from both its ends to
    /// the corner, negative beyond them, in m.
    fn at_side(
        &self,
        corner: Vector2<f64>,
        side: &Side,
        q: &Vector3<f64>,
    ) -> (ContactGeometry, f64, [f64; 2]) {
        let fields = self.fields();
        let arm = corner - (Vector2::from(fields.center_of_mass) + q.xy());
        let tangent = turned(&Turn::by(q.z), side.along());
        let normal = Vector2::new(-tangent.y, tangent.x);
        let (b, c) = (tangent.dot(&arm), normal.dot(&arm));
        let [from, to] = side.ends().map(|end| side.along().dot(&end));
        let [friction, restitution, _] = self.on_corner(corner, side);
        let geometry = ContactGeometry {
            corner: None,
            tangent,
            normal,
            b,
            c,
            offset: 0.0,
            gravity: fields.gravity * normal.y,
            radius: 0.0,
            restitution,
            friction,
            surface_speed: 0.0,
        };
        let inwards = Vector2::new(-side.along().y, side.along().x);
        (geometry, inwards.dot(&side.ends()[0]) - c, [b - from, to - b])
    }

    /// Friction, restitution and tangential restitution of a side on a corner of the ground. At the end of a moving piece the corner stands for a
    /// pulley that turns with it: it has no friction.
    pub(crate) fn on_corner(&self, corner: Vector2<f64>, side: &Side) -> [f64; 3] {
        let [friction, restitution, tangential] = side.coefficients;
        let is_pulley = |piece: &Piece| {
            piece.surface.speed != 0.0 && piece.ends.iter().any(|end| end.vertex == corner)
        };
        let pulley = self.has_belts()
            && self.grounds().iter().flat_map(|ground| &ground.pieces).any(is_pulley);
        [if pulley { 0.0 } else { friction }, restitution, tangential]
    }

    /// The corners of the ground that touch a side at `q`, within the tolerance of touching and the rounding error of the place.
    pub(crate) fn sides_touched(&self, q: &Vector3<f64>) -> Vec<TouchedSide> {
        let Some(outline) = self.outline() else { return Vec::new() };
        let center = Vector2::from(self.fields().center_of_mass) + q.xy();
        let mut found = Vec::new();
        // The largest distance that counts as touching, of a corner that is so near.
        let far = outline.radius
            + TOUCH * outline.radius
            + 4.0 * PLACE * (center.norm() + outline.radius);
        let limits = Extent::of([center]).grown(far);
        let near = outline.near(center, &Turn::by(q.z), far - outline.radius);
        let corners = self.ground_corners();
        for &corner in corners.of_which(|place| limits.meets(place) && near(place)) {
            let place = center.norm() + corner.norm() + outline.radius;
            let touch = (TOUCH * outline.radius).max(PLACE * place);
            if (corner - center).norm() > outline.radius + touch {
                continue;
            }
            for side in outline.sides() {
                let (geometry, gap, from_ends) = self.at_side(corner, side, q);
                // In a concave corner of the body it touches both sides.
                let beyond = |end: usize| {
                    let way = from_ends[end];
                    if side.concave()[end] { way < -touch } else { way <= touch }
                };
                if gap.abs() <= touch && !beyond(0) && !beyond(1) {
                    found.push(TouchedSide { corner, side: side.index(), geometry });
                }
            }
        }
        found
    }

    /// The gap at `q` of a corner of the ground that touches a side in the nominal posture, in m; ∞ beyond the ends of the
    /// side.
    pub(crate) fn side_gap(&self, on: &TouchedSide, q: &Vector3<f64>) -> f64 {
        let side = self.outline().map(|outline| &outline.sides()[on.side]);
        match side {
            Some(side) => {
                let (_, gap, from_ends) = self.at_side(on.corner, side, q);
                if from_ends.iter().all(|way| *way >= 0.0) { gap } else { f64::INFINITY }
            }
            None => on.geometry.local_gap(q),
        }
    }

    /// The sides of the outline that touch corners of the ground in the nominal posture, each as a contact at the corner on a line along the
    /// side. Statics, contact modes at rest and stability count them after the contacts of the posture: their rows are equal, as long as
    /// nothing turns.
    #[must_use]
    pub fn side_contacts(&self) -> Vec<Contact> {
        let contact = |on: &TouchedSide| {
            let side = self.outline().map(|outline| outline.sides()[on.side]);
            let [friction, restitution, tangential_restitution] =
                side.map_or([0.0; 3], |side| self.on_corner(on.corner, &side));
            let tangent = on.geometry.tangent;
            Contact {
                slope: libm::atan2(tangent.y + 0.0, tangent.x),
                friction,
                restitution: Some(restitution),
                tangential_restitution,
                ..Contact::at(on.corner.x, on.corner.y)
            }
        };
        self.sides_touched(&Vector3::zeros()).iter().map(contact).collect()
    }

    /// Refuses a configuration in which a corner of the ground lies in the body.
    pub(crate) fn check_sides(&self, q: &Vector3<f64>) -> Result<(), Error> {
        let Some(outline) = self.outline() else { return Ok(()) };
        let refuse = |corner: Vector2<f64>, depth: f64| Error::Unusable {
            field: "q".into(),
            value: format!("({:?}, {:?}, {:?})", q.x, q.y, q.z),
            allowed: format!(
                "the ground outside the body; its point at ({:?}, {:?}) m lies {depth:?} m in the body (edges = \"ignore\" lets \
                 it pass)",
                corner.x, corner.y
            ),
        };
        let (center, turn) = (Vector2::from(self.fields().center_of_mass) + q.xy(), Turn::by(-q.z));
        let seen = |corner: Vector2<f64>| turned(&turn, corner - center);
        for &corner in self.ground_corners().near(&center, outline.radius) {
            let p = seen(corner);
            if outline.holds(&p) {
                return Err(refuse(corner, outline.nearest_side(&p).distance(&p)));
            }
        }
        // A narrow peak may pass right through the body.
        self.pierced(q, 0.0).map_or(Ok(()), |(at, depth)| Err(refuse(at, depth)))
    }

    /// A point of the ground of a polyline, world axes, in m, that lies more than `least` (m) deep in the body at `q`, and its depth, in m: between
    /// two places at which a piece crosses sides of the body.
    pub(crate) fn pierced(&self, q: &Vector3<f64>, least: f64) -> Option<(Vector2<f64>, f64)> {
        let outline = self.outline()?;
        let (center, turn) = (Vector2::from(self.fields().center_of_mass) + q.xy(), Turn::by(-q.z));
        let seen = |end: Vector2<f64>| turned(&turn, end - center);
        let shared = self.grounds().iter().filter(|ground| ground.is_polyline);
        let rounding = PLACE * (center.norm() + outline.radius);
        let limits = Extent::of([center]).grown(outline.radius + rounding);
        let near = outline.near(center, &Turn::by(q.z), rounding);
        let may = |place: &Extent| limits.meets(place) && near(place);
        let pieces =
            shared.flat_map(|ground| ground.places.of_which(may).map(|k| &ground.pieces[k]));
        let ends = pieces.map(|piece| piece.ends.map(|end| end.vertex));
        ends.filter(|ends| ends.iter().all(|end| end.amax() < f64::INFINITY))
            .filter_map(|ends| outline.pierced(ends.map(seen)))
            .map(|p| (center + turned(&Turn::by(q.z), p), outline.nearest_side(&p).distance(&p)))
            .find(|(_, depth)| *depth > least)
    }
}
