//! Contacts that jam (Painlevé): from some starts, however small, no motion exists while they slide.
//!
//! With A_ij = N_iM⁻¹(N_j − σ_jμ_jT_j)ᵀ, σ = ±1 the direction in which a contact slides, and g_i > 0 the acceleration of the load into its ground:
//!
//! * Contact i jams *alone* if A_ii < 0 and g_i > 0: with all others in the air, neither its force g_i/A_ii nor its acceleration −g_i is allowed.
//!   It jams from the friction μ = N_iM⁻¹N_iᵀ/(σ N_iM⁻¹T_iᵀ) on.
//! * Two contacts that slide jam *together* if all of these fail: both slide (A⁻¹g ≥ 0); i slides and j lifts (g_i/A_ii ≥ 0 and
//!   A_ji g_i/A_ii > g_j); both lift (g < 0). With both coefficients of friction times κ the signs that decide are those of polynomials in κ of
//!   degree one (A_ii, and A_ji g_i − g_j A_ii, which are also the forces times det A) and two (det A). The jam starts at one of their roots.
//!
//! All signs are certain (intervals); a sign that is not certain decides nothing.

use serde::{Deserialize, Serialize};

use crate::body::{Mechanism, Posture, PostureFields, ROUGHEST_CONTACT};
use crate::error::Error;
use crate::math::interval::Interval;
use crate::math::mass_vector::{Coordinates, MassVector, independent, with_products};
use crate::math::real::Enclosed;
use crate::math::simplex::maximise;
use crate::modes::{Mode, Word};
use crate::outcome::ContactNumber;
use crate::tolerance::{DEPENDENT_ROW, ROWS_ALIKE, SAME_ROOT};
use crate::verified::rows::{EnclosedRows, dot};

type I = Interval;

/// Speed of a start without a motion, in m/s; the square of this number is the gap there, in m. Any smaller value has no motion either.
const SMALL: f64 = 1.0 / 1024.0;

/// A contact that jams in one direction, or two contacts that jam only together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Jam {
    /// The contacts.
    pub contacts: Vec<ContactNumber>,
    /// Their directions of sliding: R or L.
    pub slides: Word,
    /// Coefficients of friction of these contacts from which up to those given they jam, dimensionless. Of two contacts both are multiplied by the same
    /// factor. One contact jams with any larger one, too.
    pub friction: Vec<f64>,
}

/// A start from which no motion exists in the local model. At `q` and `qdot` these contacts touch and slide. The start may be as small
/// as one likes: with `qdot` times any factor 0 < f < 1, and `q` times f², there is no motion either.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NoMotion {
    /// The contacts that slide.
    pub contacts: Vec<ContactNumber>,
    /// Their directions: R or L.
    pub slides: Word,
    /// k = N M⁻¹ (N − σμT)ᵀ of a contact that slides alone: negative. Of a body per unit mass, of a mechanism in 1/kg.
    pub stiffness: Option<f64>,
    /// (x, y, θ) of a body in m, m, rad; all coordinates of a mechanism.
    pub q: Vec<f64>,
    /// q̇.
    pub qdot: Vec<f64>,
    /// All contacts that jam, and pairs that jam only together.
    #[serde(default)]
    pub jams: Vec<Jam>,
}

/// All contacts of a posture that jam, and pairs of which neither jams alone in its direction. Contacts in the air have no part in it.
/// Coefficients of friction above 1e6 count as 1e6.
///
/// ```
/// use standfast::stability::jams;
/// use standfast::{Contact, Posture, PostureFields};
///
/// // Painlevé's rod at 60 degrees, ρ² = L²/3: it jams sliding to the left, while its centre of mass is to the right of its foot, from μ = (1 + 3c²)/(3 s c) on.
/// let (s, c) = 60_f64.to_radians().sin_cos();
/// let rod = Posture::new(PostureFields {
///     gyration_radius: (1.0_f64 / 3.0).sqrt(),
///     center_of_mass: [c, s],
///     contacts: vec![Contact { friction: 2.0, ..Contact::at(0.0, 0.0) }],
///     ..PostureFields::default()
/// })?;
/// let found = jams(&rod, 0.0)?;
/// assert_eq!((found.len(), found[0].slides.to_string()), (1, "L".into()));
/// assert!((found[0].friction[0] - (1.0 + 3.0 * c * c) / (3.0 * s * c)).abs() < 1e-14);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// No contact touches; a surface moves.
pub fn jams(posture: &Posture, width: f64) -> Result<Vec<Jam>, Error> {
    let mut fields = PostureFields::clone(posture.at_its_place()?.fields());
    for contact in &mut fields.contacts {
        contact.friction = contact.friction.min(ROUGHEST_CONTACT);
    }
    let mut found = mechanism_jams(&Mechanism::of_posture(&Posture::new(fields)?)?, width);
    let geometry = posture.geometry().iter().enumerate();
    let places: Vec<usize> = geometry.filter(|(_, k)| k.offset == 0.0).map(|(i, _)| i).collect();
    for contact in found.iter_mut().flat_map(|jam| &mut jam.contacts) {
        *contact = ContactNumber::of(places[contact.index()]);
    }
    Ok(found)
}

/// As [`jams`], of a mechanism.
#[must_use]
pub fn mechanism_jams(mechanism: &Mechanism, width: f64) -> Vec<Jam> {
    let Some(sliding) = Sliding::of(mechanism, width) else { return Vec::new() };
    let jam = |slides: Vec<(usize, f64)>| Jam {
        friction: sliding.starts_at(&slides),
        contacts: slides.iter().map(|(i, _)| ContactNumber::of(*i)).collect(),
        slides: letters(&slides),
    };
    sliding.all().map(|(slides, _)| jam(slides)).collect()
}

/// A start from which no motion exists.
pub(super) fn no_motion(mechanism: &Mechanism, width: f64) -> Option<NoMotion> {
    Sliding::of(mechanism, width)?.all().next().map(|(_, start)| start)
}

/// A start at which these contacts slide in these directions (those with friction), and all others are in the air; `None` if there is none.
pub(super) fn no_motion_of(mechanism: &Mechanism, slides: &[(usize, f64)]) -> Option<NoMotion> {
    let mut start = Sliding::of(mechanism, 0.0)?.start(slides)?;
    // What is rounding error beside the largest coordinate would count as a rate of a contact.
    for values in [&mut start.q, &mut start.qdot] {
        let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let small = |x: &&mut f64| x.abs() <= ROWS_ALIKE * largest;
        values.iter_mut().filter(small).for_each(|x| *x = 0.0);
    }
    Some(start)
}

fn letters(slides: &[(usize, f64)]) -> Word {
    let mode = |way: f64| if way > 0.0 { Mode::Right } else { Mode::Left };
    let letters = slides.iter().enumerate();
    letters.fold(Word::separate(slides.len()), |word, (k, (_, way))| word.with(k, mode(*way)))
}

/// A mechanism whose contacts slide.
struct Sliding<'a> {
    mechanism: &'a Mechanism,
    rows: EnclosedRows<I>,
    friction: Vec<I>,
    /// g.
    pressed: Vec<I>,
}

impl<'a> Sliding<'a> {
    fn of(mechanism: &'a Mechanism, width: f64) -> Option<Self> {
        let rows = EnclosedRows::<I>::of(mechanism)?.widened(width);
        let friction =
            mechanism.contacts().iter().map(|c| I::from(c.friction).widened(width * c.friction));
        let pressed = (0..mechanism.contacts().len()).map(|i| rows.gravity(i)).collect();
        Some(Self { mechanism, friction: friction.collect(), pressed, rows })
    }

    /// All that jam, with a start for each: contacts alone, then pairs of which neither jams alone.
    fn all(&self) -> impl Iterator<Item = (Vec<(usize, f64)>, NoMotion)> {
        let count = self.friction.len();
        let ways = [1.0, -1.0];
        let alone = (0..count)
            .flat_map(move |i| ways.map(|side| vec![(i, side)]))
            .filter(|slides| self.alone(slides[0]));
        let pairs = (0..count)
            .flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
            .flat_map(move |(i, j)| ways.map(|a| ways.map(|b| [(i, a), (j, b)])).concat())
            .filter(|[a, b]| !self.alone(*a) && !self.alone(*b) && self.together([*a, *b]))
            .map(|slides| slides.to_vec());
        alone.chain(pairs).filter_map(|slides| self.start(&slides).map(|start| (slides, start)))
    }

    /// A_ij, with contact j sliding in the direction `side`.
    fn stiffness(&self, i: usize, j: usize, side: f64) -> I {
        let n = &self.rows.normals[i];
        dot(n, &self.rows.normals[j])
            - self.friction[j].times(side) * dot(n, &self.rows.tangents[j])
    }

    fn alone(&self, (i, side): (usize, f64)) -> bool {
        self.pressed[i].is_positive() && self.stiffness(i, i, side).is_negative()
    }

    fn together(&self, slides: [(usize, f64); 2]) -> bool {
        let g = slides.map(|(i, _)| self.pressed[i]);
        let a = |i: usize, j: usize| self.stiffness(slides[i].0, slides[j].0, slides[j].1);
        let a = [[a(0, 0), a(0, 1)], [a(1, 0), a(1, 1)]];
        g.iter().any(|g| g.is_positive()) && jam_together(&a, &g, |x: &I| x.sign().unwrap_or(0))
    }

    /// The coefficients of friction from which on contacts that jam do so.
    fn starts_at(&self, slides: &[(usize, f64)]) -> Vec<f64> {
        let space = self.mechanism.contact_space();
        let friction = |i: usize| self.mechanism.contacts()[i].friction;
        let slip = |i: usize, j: usize| space.w()[(2 * i + 1, 2 * j)];
        match *slides {
            [(i, side)] => vec![space.normal(i, i) / (side * slip(i, i))],
            [one, two] => {
                let pair = [one, two];
                let g = pair.map(|(i, _)| space.gravity(i));
                // A(κ) = fixed − κ moved
                let fixed = pair.map(|(i, _)| pair.map(|(j, _)| space.normal(i, j)));
                let moved =
                    pair.map(|(i, _)| pair.map(|(j, side)| side * friction(j) * slip(i, j)));
                let factor = starting_factor(&fixed, &moved, &g);
                pair.map(|(i, _)| factor * friction(i)).to_vec()
            }
            _ => Vec::new(),
        }
    }

    /// A start at which these contacts slide in these directions on their ground, and all others are above theirs; `None` if the others cannot be.
    fn start(&self, slides: &[(usize, f64)]) -> Option<NoMotion> {
        let mechanism = self.mechanism;
        let space = mechanism.contact_space();
        let on = |i: usize| slides.iter().find(|(k, _)| *k == i);
        let count = mechanism.contacts().len();
        // N_i q = 0 of those that slide, N_j q ≥ 1 of the others, with q as the difference of two vectors, and the rest of N_j q as a slack.
        let apart: Vec<(Vec<f64>, f64)> = (0..count)
            .map(|i| {
                let row = || space.normal_row(i).iter();
                let mut all: Vec<f64> = row().chain(row().map(|part| -part)).collect();
                all.extend((0..count).map(|j| if j == i && on(i).is_none() { -1.0 } else { 0.0 }));
                (all, f64::from(u8::from(on(i).is_none())))
            })
            .collect();
        let found = maximise(&apart, &vec![0.0; apart[0].0.len()])?;
        let r = space.normal_row(0).len();
        let placed = (0..r).map(|k| SMALL * SMALL * (found[k] - found[r + k]));
        let mut placed = Coordinates::from_iter(placed);
        if count > 2 {
            placed = self.without_gaps(slides, placed);
        }
        let placed = mechanism.coordinates(&placed);
        let stiffness = match slides {
            [(i, side)] => Some(
                space.normal(*i, *i)
                    - side * mechanism.contacts()[*i].friction * space.w()[(2 * i + 1, 2 * i)],
            ),
            _ => None,
        };
        Some(NoMotion {
            contacts: slides.iter().map(|(i, _)| ContactNumber::of(*i)).collect(),
            slides: letters(slides),
            stiffness,
            q: placed,
            qdot: mechanism.coordinates(&self.moved(slides)?),
            jams: Vec::new(),
        })
    }

    /// A velocity with which these contacts slide in these directions. Of two contacts of a rigid body one slide determines the other; of more
    /// contacts those without friction may slide as they like.
    fn moved(&self, slides: &[(usize, f64)]) -> Option<Coordinates> {
        let space = self.mechanism.contact_space();
        let rows: Vec<&Coordinates> = slides
            .iter()
            .map(|(i, _)| space.normal_row(*i))
            .chain(slides.iter().map(|(i, _)| space.tangent(*i)))
            .collect();
        let mut speeds = vec![0.0; slides.len()];
        speeds.extend(slides.iter().map(|(_, side)| side * SMALL));
        if let Some(moved) = with_products(&rows, &speeds) {
            return Some(moved);
        }
        if slides.len() > 2 {
            return self.moved_somehow(slides);
        }
        let all = rows.len();
        let moved = with_products(&rows[..all - 1], &speeds[..all - 1])?;
        let (other, side) = slides.last()?;
        (space.tangent(*other).dot(&moved) * side > 0.0).then_some(moved)
    }

    /// The same with slides of at least this speed, by a linear programme: the velocity as the difference of two vectors, and the rest of each slide as
    /// a slack.
    fn moved_somehow(&self, slides: &[(usize, f64)]) -> Option<Coordinates> {
        let space = self.mechanism.contact_space();
        let rubs = slides.iter().filter(|(i, _)| self.mechanism.contacts()[*i].friction > 0.0);
        let rubs: Vec<&(usize, f64)> = rubs.collect();
        let row = |row: &Coordinates, side: f64, slack: Option<usize>| -> Vec<f64> {
            let own = row.iter().map(|x| side * x);
            let slacks = (0..rubs.len()).map(|j| if slack == Some(j) { -1.0 } else { 0.0 });
            own.chain(row.iter().map(|x| -side * x)).chain(slacks).collect()
        };
        let closed = slides.iter().map(|(i, _)| (row(space.normal_row(*i), 1.0, None), 0.0));
        let slips = rubs.iter().enumerate();
        let slips = slips.map(|(j, (i, side))| (row(space.tangent(*i), *side, Some(j)), 1.0));
        let rows: Vec<(Vec<f64>, f64)> = closed.chain(slips).collect();
        let found = maximise(&rows, &vec![0.0; rows[0].0.len()])?;
        let r = space.pull().len();
        let moved = Coordinates::from_iter((0..r).map(|k| SMALL * (found[k] - found[r + k])));
        Some(self.without_gaps(slides, moved))
    }

    /// Without the rounding errors of the gaps, or rates, of contacts that are closed.
    fn without_gaps(&self, slides: &[(usize, f64)], mut along: Coordinates) -> Coordinates {
        let space = self.mechanism.contact_space();
        let rows: Vec<&Coordinates> = slides.iter().map(|(i, _)| space.normal_row(*i)).collect();
        for (k, axis) in &independent(&rows, DEPENDENT_ROW) {
            along.add_scaled(axis, -rows[*k].dot(&along) / rows[*k].dot(axis));
        }
        along
    }
}

/// Returns true if neither both slide, nor one slides while the other one lifts. `sign`: 1, −1, or 0 if it is not certain.
fn jam_together<T: Copy + std::ops::Mul<Output = T> + std::ops::Sub<Output = T>>(
    a: &[[T; 2]; 2],
    g: &[T; 2],
    sign: impl Fn(&T) -> i8,
) -> bool {
    let det = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    let force = [g[0] * a[1][1] - g[1] * a[0][1], g[1] * a[0][0] - g[0] * a[1][0]];
    let wrong = |side: i8| force.iter().any(|f| sign(f) == -side);
    let apart = match sign(&det) {
        0 => false,
        side => wrong(side),
    };
    // Contact i cannot slide alone: its force g_i/A_ii is negative, or the other one does not lift, A_ji g_i/A_ii < g_j.
    let lifts_not = |i: usize| {
        let lift = a[1 - i][i] * g[i] - g[1 - i] * a[i][i];
        match sign(&a[i][i]) {
            0 => false,
            side => sign(&g[i]) == -side || sign(&lift) == -side,
        }
    };
    apart && lifts_not(0) && lifts_not(1)
}

/// The factor κ < 1 on the friction from which on two contacts jam together, with A = fixed − κ moved; they jam with κ = 1.
fn starting_factor(fixed: &[[f64; 2]; 2], moved: &[[f64; 2]; 2], g: &[f64; 2]) -> f64 {
    let mut roots = Vec::new();
    let mut line = |constant: f64, slope: f64| roots.push(constant / slope);
    for i in [0, 1] {
        let j = 1 - i;
        line(fixed[i][i], moved[i][i]);
        line(fixed[j][i] * g[i] - g[j] * fixed[i][i], moved[j][i] * g[i] - g[j] * moved[i][i]);
    }
    // det A = c − b κ + a κ²
    let mixed = |x: &[[f64; 2]; 2], y: &[[f64; 2]; 2]| x[0][0] * y[1][1] - x[0][1] * y[1][0];
    let (a, c) = (mixed(moved, moved), mixed(fixed, fixed));
    let b = mixed(fixed, moved) + mixed(moved, fixed);
    let q = 0.5 * (b + (b * b - 4.0 * a * c).max(0.0).sqrt().copysign(b));
    roots.extend([q / a, c / q]);
    roots.retain(|root| *root > 0.0 && *root < 1.0);
    roots.sort_by(|x, y| y.total_cmp(x));
    // Equal up to rounding: between them there is no sign to ask for.
    roots.dedup_by(|next, root| *root - *next <= SAME_ROOT * *root);
    let jams = |factor: f64| {
        let a = [0, 1].map(|i| [0, 1].map(|j| fixed[i][j] - factor * moved[i][j]));
        let sign = |x: &f64| if *x > 0.0 { 1 } else { -i8::from(*x < 0.0) };
        jam_together(&a, g, sign)
    };
    let below = roots.iter().skip(1).copied().chain([0.0]);
    let start = roots.iter().zip(below).find(|(root, next)| !jams(0.5 * (*root + next)));
    start.map_or(0.0, |(root, _)| *root)
}
