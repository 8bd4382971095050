//! The grounds of the contacts of a posture: a terrain, one straight line, or a line for each contact; raised for discs. And the place of each
//! contact on them.

use nalgebra::Vector2;

use crate::body::contact::Contact;
use crate::body::fields::PostureFields;
use crate::body::terrain::{Ground, Piece, place_error, slope_of};
use crate::error::Error;
use crate::tolerance::DISC_POINT;

/// Sets the slope and the segment of a contact from the terrain. If the user gave them, they must be equal to these. `raised`: the same terrain
/// for the centre of the contact, if it is a disc.
pub(crate) fn place_on(
    ground: &Ground,
    raised: &Ground,
    contact: &mut Contact,
    at: &str,
) -> Result<(), Error> {
    let center = contact.center.map(Vector2::from);
    let over = center.map(|center| raised.nearest(raised.find(&center)).0);
    // A disc over a corner touches there.
    if let (Some(center), Some(arc)) = (center, over.filter(|piece| piece.corner().is_some())) {
        let [tangent, normal] = arc.axes(&center);
        contact.turn_to(&normal);
        return set_line(contact, slope_of(&tangent), [f64::NEG_INFINITY, f64::INFINITY], at);
    }
    let (name, [x, y]) = match contact.center {
        Some(center) => ("center", center),
        None => ("point", contact.point),
    };
    let (pieces, point) = (&ground.pieces, Vector2::new(x, y));
    let found = usize::try_from(ground.find_up(&point, place_error(&point))).unwrap_or(usize::MAX);
    let is_below = |line: &Piece, low: &Piece| {
        low.normal == line.normal && low.origin + low.normal * raised.raised == line.origin
    };
    let below = over.and_then(|line| pieces.iter().find(|low| is_below(line, low)));
    let Some(piece) = below.or_else(|| pieces.get(found)) else {
        let (low, high) = (pieces[0].ends[0].vertex.x, pieces[pieces.len() - 1].ends[1].vertex.x);
        let (field, value, allowed) = if ground.has_walls {
            (
                name.into(),
                format!("({x:?}, {y:?})"),
                "only a point between the ends of the terrain, whose ground is on the right of its vertices in their order, is allowed".into(),
            )
        } else {
            let allowed = format!("from {low:?} to {high:?}, over the terrain");
            (format!("{name}.x"), format!("{x:?}"), allowed)
        };
        return Err(Error::Unusable { field: format!("{at}{field}"), value, allowed });
    };
    contact.turn_to(&piece.normal);
    let away = piece.height(&point).abs();
    let touches = away <= DISC_POINT * (x.abs() + y.abs() + contact.radius);
    if contact.is_round() && contact.center.is_none() && !touches {
        return Err(Error::Unusable {
            field: format!("{at}point"),
            value: format!("({x:?}, {y:?})"),
            allowed: format!(
                "on its ground, which is {away:?} m away: only a disc with a center need not touch in the nominal posture"
            ),
        });
    }
    let end = |side: usize| {
        if piece.faces_up() {
            (piece.ends[side].vertex.x - x) / piece.tangent.x
        } else if side == 0 {
            -piece.along(&point)[0]
        } else {
            piece.along(&point)[1]
        }
    };
    // Where there are walls, the nearest point of the piece may be its end.
    set_line(contact, piece.slope, [end(0).min(0.0), end(1).max(0.0)], at)
}

/// Sets the slope and the segment of a contact, as far as the user left them out.
fn set_line(contact: &mut Contact, slope: f64, segment: [f64; 2], at: &str) -> Result<(), Error> {
    let [x, y] = contact.point;
    let plain = Contact::at(x, y);
    for (field, given, left_out, own) in [
        ("slope", vec![contact.slope], vec![plain.slope], vec![slope]),
        ("segment", contact.segment.to_vec(), plain.segment.to_vec(), segment.to_vec()),
    ] {
        if given != left_out && given != own {
            return Err(Error::Unusable {
                field: format!("{at}{field}"),
                value: format!("{given:?}"),
                allowed: "left out, because the terrain of the posture determines it".into(),
            });
        }
    }
    (contact.slope, contact.segment) = (slope, segment);
    Ok(())
}

/// Checks what a posture with round contacts must not have.
///
/// # Errors
///
/// A radius out of range, an outline.
pub(crate) fn suits_rounds(fields: &PostureFields) -> Result<(), Error> {
    for (i, contact) in fields.contacts.iter().enumerate() {
        contact.validate_radius(&format!("contacts.{}.", i + 1))?;
        if !contact.is_round() {
            continue;
        }
        if !fields.outline.is_empty() {
            return Err(Error::Unusable {
                field: "outline".into(),
                value: format!("[{} vertices]", fields.outline.len()),
                allowed: format!(
                    "left out, because contacts.{}.radius = {:?} > 0: a body with round contacts has no outline",
                    i + 1,
                    contact.radius
                ),
            });
        }
    }
    Ok(())
}

/// The ground of each contact on this terrain, raised by its radius.
///
/// # Errors
///
/// A disc that does not fit.
pub(crate) fn raised(ground: &Ground, contacts: &[Contact]) -> Result<Vec<Ground>, Error> {
    let mut all: Vec<Ground> = Vec::with_capacity(contacts.len());
    for (i, contact) in contacts.iter().enumerate() {
        let at = format!("contacts.{}.", i + 1);
        contact.validate_radius(&at)?;
        let same = contacts[..i].iter().position(|other| other.radius == contact.radius);
        let raised = match same {
            Some(j) => all[j].clone(),
            None if !contact.is_round() => ground.clone(),
            None => ground.raised_by(contact.radius).map_err(|allowed| Error::Unusable {
                field: format!("{at}radius"),
                value: format!("{:?}", contact.radius),
                allowed,
            })?,
        };
        all.push(raised);
    }
    Ok(all)
}

/// The ground shared by all contacts, the line with their slope through the lowest contact; for each contact, if one is round.
pub(crate) fn shared(fields: &PostureFields) -> Result<Vec<Ground>, Error> {
    let unusable = |field: String, value: String, allowed: &str| Error::Unusable {
        field,
        value,
        allowed: allowed.into(),
    };
    if !fields.terrain.is_empty() {
        let value = "shared".into();
        return Err(unusable(
            "ground".into(),
            value,
            "left out where there is a terrain, which is shared anyway",
        ));
    }
    let first = &fields.contacts[0];
    let normal = first.normal();
    let mut lowest = first;
    for (i, contact) in fields.contacts.iter().enumerate() {
        let at = |field: &str| format!("contacts.{}.{field}", i + 1);
        if contact.slope != first.slope {
            let value = format!("{:?}", contact.slope);
            return Err(unusable(
                at("slope"),
                value,
                "the slope of contacts.1, because the ground is shared",
            ));
        }
        if contact.segment != [f64::NEG_INFINITY, f64::INFINITY] {
            let value = format!("{:?}", contact.segment);
            return Err(unusable(
                at("segment"),
                value,
                "left out, because the ground is shared and has no ends",
            ));
        }
        if contact.surface_speed != first.surface_speed {
            let value = format!("{:?}", contact.surface_speed);
            return Err(unusable(
                at("surface_speed"),
                value,
                "the surface_speed of contacts.1, because the ground is shared",
            ));
        }
        if normal.dot(&(Vector2::from(contact.point) - Vector2::from(lowest.point))) < 0.0 {
            lowest = contact;
        }
    }
    let under =
        |contact: &Contact| of_line(&Contact { radius: contact.radius, center: None, ..*lowest });
    Ok(match fields.contacts.iter().any(Contact::is_round) {
        true => fields.contacts.iter().map(under).collect(),
        false => vec![of_line(lowest)],
    })
}

/// The line of a contact, raised by its radius.
fn of_line(contact: &Contact) -> Ground {
    Ground { raised: contact.radius, ..Ground::new(vec![Piece::of_contact(contact)], false) }
}

/// The corners of these grounds that a side of a body can meet, in a fixed order, each once.
pub(crate) fn corners_of(grounds: &[Ground]) -> Vec<Vector2<f64>> {
    let mut corners: Vec<_> = grounds.iter().flat_map(Ground::corners).collect();
    corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    corners.dedup();
    corners
}

/// The terrain of each contact, for a disc with arcs about its ends. The list is empty if no piece has ends.
///
/// # Errors
///
/// Ends of the ground of a disc that are at one place, up to rounding.
pub(crate) fn own(contacts: &[Contact]) -> Result<Vec<Ground>, Error> {
    let is_endless = |contact: &Contact| contact.segment == [f64::NEG_INFINITY, f64::INFINITY];
    if contacts.iter().all(is_endless) {
        return Ok(Vec::new());
    }
    let of = |(i, contact): (usize, &Contact)| {
        if !contact.is_round() || is_endless(contact) {
            return Ok(of_line(contact));
        }
        let low = of_line(&Contact { radius: 0.0, center: None, ..*contact });
        low.raised_by(contact.radius).map_err(|_| Error::Unusable {
            field: format!("contacts.{}.segment", i + 1),
            value: format!("{:?}", contact.segment),
            allowed: "ends that rounding keeps apart at this place".into(),
        })
    };
    contacts.iter().enumerate().map(of).collect()
}
