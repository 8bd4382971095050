//! Ranges of the quantities that can be simulated.

use crate::body::ROUGHEST_CONTACT;
use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::error::{Error, LARGEST, dissipative, in_range};
use crate::modes::LONGEST_ARM;
use crate::options::{Impact, Options, Stop};

/// Checks the landing speeds of several contacts, |u| + √(2gh). Collisions in turn compute products of three of them, which must
/// stay in the range of doubles until the speeds have shrunk by all digits of the time.
pub(super) fn clatters(starts: impl IntoIterator<Item = (f64, f64, f64)>) -> Result<(), Error> {
    let speed = |(h, u, g): (f64, f64, f64)| {
        u.abs() + if h < f64::INFINITY { (2.0 * g.abs()).sqrt() * h.sqrt() } else { 0.0 }
    };
    let fastest = starts.into_iter().map(speed).fold(0.0, f64::max);
    in_range(
        "largest speed of a first landing, |u| + sqrt(2 g h),",
        fastest,
        fastest == 0.0 || (1.0 / FASTEST_LANDING..=FASTEST_LANDING).contains(&fastest),
        "0, or from 1e-80 to 1e80 m/s with several contacts",
    )?;
    Ok(())
}

/// Checks that the way until gravity brings a body back is finite, and that the squares of its speeds do not underflow.
pub(super) fn returns(field: &str, speed: f64, gravity: f64) -> Result<(), Error> {
    in_range(
        field,
        speed,
        speed == 0.0 || speed >= 1.0 / LARGEST,
        "0, or at least 1e-150, so that its square does not underflow",
    )?;
    let near = gravity == 0.0 || (speed / LARGEST) * (speed / LARGEST) <= gravity;
    in_range(field, speed, near, "such that speed**2/gravity is at most 1e300 m")?;
    Ok(())
}

/// Checks that the ways until the time limit, of a fall and at the largest speed, are finite.
pub(super) fn reachable(gravity: f64, options: &Options) -> Result<(), Error> {
    let t = options.end();
    let limit = options.time_limit.unwrap_or(f64::INFINITY);
    let near =
        t == f64::INFINITY || t == 0.0 || t <= LARGEST && gravity * t <= LARGEST * LARGEST / t;
    in_range(
        "time_limit",
        limit,
        near,
        "inf, or at most 1e150 s with gravity * time_limit**2 at most 1e300 m",
    )?;
    Ok(())
}

/// What a certificate needs.
pub(super) const LOSES: &str = "below 1 in a certified run: with 1 no sequence of impacts ends";

/// Refuses runs without an end: with restitution 1 at a contact a time limit is needed. `values`: of each contact.
pub(super) fn ends(values: impl IntoIterator<Item = f64>, options: &Options) -> Result<(), Error> {
    let allowed = "below 1, or with a time_limit: with 1 a body bounces for ever";
    if options.end() < f64::INFINITY { Ok(()) } else { dissipative(values, allowed) }
}

/// Largest speed of a first landing, in m/s; its inverse is the smallest. Products of three stay in the range of doubles.
const FASTEST_LANDING: f64 = 1e80;

/// Largest body, in m, whose contacts may be held: near a jam the forces are products of four lengths.
const LARGEST_BODY: f64 = 1e75;

/// Longest arm, in radii of gyration, up to the first Zeno point: beyond, the fraction ρ²/(b² + ρ²) of an impulse that moves
/// the centre of mass is below 1e-32, and powers of the arm overflow.
const LONGEST_LEVER: f64 = 1e16;

/// Largest radius of gyration, in distances of the farthest contact. The speed that counts as zero is relative to those of the
/// body, ρω among them; beyond, real speeds of a contact would count as zero.
const HEAVIEST: f64 = 1e6;

/// Distance of two contacts in sizes of the body, or of their normals, from which on they count as two. How they share a force
/// depends on the square of their distance: four digits are left here. Rounding would decide the friction of nearer contacts.
const NEAREST: f64 = 1e-6;

/// Refuses motions that are not supported; the error names the field.
pub(crate) fn solvable(posture: &Posture, options: &Options) -> Result<(), Error> {
    reachable(posture.fields().gravity, options)?;
    ends(posture.restitutions(), options)?;
    if options.certify {
        dissipative(posture.restitutions(), LOSES)?;
    }
    if options.certify && !options.is_plain(posture) {
        return Err(Error::Unusable {
            field: "certify".into(),
            value: "true".into(),
            allowed: "false, except with one contact or two at different points, none of them round, impact = \"newton\" or no friction, and terrain without ends"
                .into(),
        });
    }
    let contacts = posture.contacts();
    let fields = posture.fields();
    let reach = posture.geometry().iter().map(ContactGeometry::reach).fold(0.0, f64::max);
    in_range(
        "gyration_radius / (distance of the farthest contact from center_of_mass)",
        fields.gyration_radius / reach,
        reach == 0.0 || fields.gyration_radius <= HEAVIEST * reach,
        "at most 1e6, or contacts at center_of_mass",
    )?;
    let flies = options.stop == Stop::Zeno && options.impact == Impact::Newton;
    in_range(
        "distance of the farthest contact from center_of_mass, or gyration_radius",
        posture.size(),
        flies || posture.size() <= LARGEST_BODY,
        "at most 1e75 m beyond the first Zeno point, or with friction in impacts",
    )?;
    let (most, allowed) = if flies {
        (LONGEST_LEVER, "at most 1e16")
    } else {
        (LONGEST_ARM, "at most 1e4 beyond the first Zeno point, or with friction in impacts")
    };
    for (i, friction) in posture.frictions().enumerate() {
        in_range(
            format_args!("contacts.{}.friction", i + 1),
            friction,
            friction <= ROUGHEST_CONTACT,
            "at most 1e6 for motion",
        )?;
    }
    for (j, other) in posture.geometry().iter().enumerate() {
        for (i, one) in posture.geometry()[..j].iter().enumerate() {
            let apart = one.apart(other, posture.size());
            in_range(
                format_args!(
                    "distance between contacts {} and {} in body sizes (or between their unit normals)",
                    i + 1,
                    j + 1
                ),
                apart,
                apart == 0.0 || apart >= NEAREST,
                "0, which makes them one contact, or at least 1e-6",
            )?;
            let surface = |k: usize| {
                let contact = contacts[k];
                let restitution = posture.geometry()[k].restitution;
                (
                    contact.friction,
                    restitution,
                    contact.tangential_restitution,
                    contact.segment,
                    contact.surface_speed,
                )
            };
            // The friction forces on two pieces of ground that meet are not unique.
            let rubs = contacts[i].friction > 0.0 || contacts[j].friction > 0.0;
            let corner = contacts[i].point == contacts[j].point && apart > 0.0 && rubs;
            if corner || apart == 0.0 && surface(i) != surface(j) {
                return Err(Error::Unusable {
                    field: format!("contacts.{}.point", j + 1),
                    value: format!("{:?}", contacts[j].point),
                    allowed: format!(
                        "contact {} is at the same point; place them apart, or give both the same slope, segment, friction and restitution (a corner of the ground needs terrain=)",
                        i + 1
                    ),
                });
            }
        }
    }
    if posture.size() > most * posture.fields().gyration_radius {
        for (i, k) in posture.geometry().iter().enumerate() {
            let arm = k.reach() / posture.fields().gyration_radius;
            in_range(
                format_args!(
                    "(distance of contacts.{}.point from center_of_mass) / gyration_radius",
                    i + 1
                ),
                arm,
                arm <= most,
                allowed,
            )?;
        }
    }
    Ok(())
}

/// Sets gaps down to −`touch` to zero, with a warning; deeper ones are errors.
pub(super) fn touch(gaps: &mut [f64], touch: f64) -> Result<Vec<String>, Error> {
    let mut warnings = Vec::new();
    for (i, height) in gaps.iter_mut().enumerate() {
        let gap = *height;
        if gap < -touch || gap.is_nan() {
            return Err(Error::Penetrating { contact: i + 1, gap, touch });
        }
        if gap < 0.0 {
            *height = 0.0;
            warnings.push(format!(
                "contact {} starts {:?} m below the terrain, which is as small as the rounding error of its position: it counts as touching",
                i + 1,
                -gap
            ));
        }
    }
    Ok(warnings)
}
