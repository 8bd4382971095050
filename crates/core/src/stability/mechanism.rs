//! Stability of a mechanism in its posture.
//!
//! With three coordinates that are not locked, or more of which the contacts feel three, the contacts move as those of a rigid body: every test
//! of two contacts applies to the contact space. If the three are (x, y, θ) of a rigid body, the verdict is that of this body, with any number of contacts.
//!
//! With more coordinates (joints with torques) both contacts may slide in any directions, and one may slide while the other one is fixed. That the
//! contacts nevertheless come to rest is proved by `joints.rs`. Three things make a posture unstable: the load is not held; a contact mode that moves is consistent
//! at rest; or no motion exists after some small kicks. For two contacts that both slide in the directions σ_i, which are free here, no motion
//! exists if all of these fail, with A_ij = N_iM⁻¹(N_j − σ_jμ_jT_j)ᵀ: both slide (A⁻¹g ≥ 0); i slides and j lifts (g_i/A_ii ≥ 0 and
//! A_ji g_i/A_ii > g_j); both lift (g < 0).

use crate::body::Mechanism;
use crate::body::fields::ContactRows;
use crate::body::rigid::RigidBody;
use crate::error::{Error, dissipative};
use crate::math::interval::Interval;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::math::real::Enclosed;
use crate::math::simplex::maximise;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{MechanismProblem, Method, Mode, ModeAnswer, Word, contact_modes};
use crate::options::Jams;
use crate::outcome::ContactNumber;
use crate::stability::conditions::{self, Equilibrium, Pair};
use crate::stability::corner::CornerMap;
use crate::stability::existence::{NoMotion, Standing};
use crate::stability::joints;
use crate::stability::local::Local;
use crate::stability::static_forces::{StaticForces, extremes, friction_margin, spare_friction};
use crate::stability::{
    Argument, Details, Evidence, Finding, LOSES, NoBound, Stability, StabilityOptions, Verdict,
    WhyUndecided, holding_pairs, judge, undecided,
};
use crate::verified::rows::{EnclosedRows, dot};

type I = Interval;

/// Speed of a start without a motion, in m/s; the square of this number is the gap there, in m. Any smaller value has no motion either.
const SMALL: f64 = 1.0 / 1024.0;

/// The verdict on a mechanism in its posture q = 0, in which all contacts touch.
///
/// ```
/// use standfast::body::Mechanism;
/// use standfast::stability::{Stability, StabilityOptions, mechanism_stability};
/// use standfast::{Lamina, Posture};
///
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// let verdict = mechanism_stability(&Mechanism::of_posture(&rod)?, &StabilityOptions::default())?;
/// assert_eq!(verdict.frictional_stability, Stability::Stable);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Solver`] if the contact modes cannot be solved.
pub fn mechanism_stability(
    mechanism: &Mechanism,
    options: &StabilityOptions,
) -> Result<Verdict, Error> {
    let options = options.checked()?;
    if let Some((fewer, count)) = without_spectators(mechanism)? {
        let mut verdict = mechanism_stability(&fewer, &options)?;
        verdict.free_motion += count;
        return Ok(verdict);
    }
    if let Some(body) = RigidBody::of(mechanism) {
        let mut verdict = judge(&body.posture, options, Details::ALL)?;
        verdict.safe_speed = None;
        translate(&body, mechanism, &mut verdict);
        return Ok(verdict);
    }
    let count = mechanism.contacts().len();
    dissipative((0..count).map(|i| mechanism.restitution(i)), LOSES)?;
    let mut verdict = judge_rows(mechanism, options)?;
    if verdict.by.is_none() && options.width > 0.0 {
        let exact = StabilityOptions { width: 0.0, ..options };
        verdict.delicate = judge_rows(mechanism, exact)?.by.is_some();
    }
    Ok(verdict)
}

/// The mechanism with those coordinates locked that no contact and no other coordinate feels, and that have no load; and their number. `None` if
/// there are none.
fn without_spectators(mechanism: &Mechanism) -> Result<Option<(Mechanism, usize)>, Error> {
    let (fields, space) = (mechanism.fields(), mechanism.contact_space());
    let contacts = &fields.contacts;
    let unfelt = |place: usize, k: usize| {
        let apart =
            space.mass().row(place).iter().enumerate().all(|(j, m)| j == place || *m == 0.0);
        apart
            && fields.load[k] == 0.0
            && contacts.iter().all(|c| c.normal[k] == 0.0 && c.tangential[k] == 0.0)
    };
    let free = space.free().iter().enumerate();
    let spectators: Vec<usize> =
        free.filter(|(place, k)| unfelt(*place, **k)).map(|(_, k)| *k).collect();
    if spectators.is_empty() {
        return Ok(None);
    }
    let mut fewer = fields.clone();
    fewer.locked.extend(&spectators);
    fewer.locked.sort_unstable();
    Ok(Some((Mechanism::new(fewer)?, spectators.len())))
}

/// The verdict on a mechanism that is no rigid body. Whether it is delicate is not decided yet.
fn judge_rows(mechanism: &Mechanism, options: StabilityOptions) -> Result<Verdict, Error> {
    let count = mechanism.contacts().len();
    let mut verdict = Verdict::open(count, equilibrium(mechanism), options);
    let space = mechanism.contact_space();
    if space.free().len() > 3 {
        verdict.free_motion = space.free().len() - space.rank();
    }
    let problem = MechanismProblem::at_rest(mechanism);
    let modes = contact_modes(&problem, Method::Auto)?;
    let drifts = space.hidden().amax() > 0.0;
    let three = [space.free().len(), space.rank()].contains(&3) && !drifts;
    if three && count == 2 {
        verdict.modes = modes.answers().to_vec();
        verdict.decide_two(mechanism)?;
    } else {
        verdict.modes = modes.consistent().cloned().collect();
        verdict.decide_jointed(mechanism);
    }
    Ok(verdict)
}

/// The verdicts on pairs of contacts that can hold a rigid body alone, as [`holding_pairs`](crate::stability::holding_pairs); none for other
/// mechanisms.
///
/// ```
/// use standfast::body::Mechanism;
/// use standfast::stability::{StabilityOptions, mechanism_pairs};
/// use standfast::{Contact, Posture, PostureFields};
///
/// let foot = |x, slope| Contact { friction: 0.5, ..Contact::at(x, 0.0).on_slope(slope) };
/// let posture = Posture::new(PostureFields {
///     gyration_radius: 0.5,
///     center_of_mass: [0.0, 0.5],
///     contacts: vec![foot(-0.5, 0.1), foot(0.1, 0.0), foot(0.5, -0.2)],
///     ..PostureFields::default()
/// })?;
/// let pairs = mechanism_pairs(&Mechanism::of_posture(&posture)?, &StabilityOptions::default())?;
/// assert_eq!(pairs.len(), 2);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`mechanism_stability`].
pub fn mechanism_pairs(
    mechanism: &Mechanism,
    options: &StabilityOptions,
) -> Result<Vec<Verdict>, Error> {
    if let Some((fewer, _)) = without_spectators(mechanism)? {
        return mechanism_pairs(&fewer, options);
    }
    let Some(body) = RigidBody::of(mechanism) else { return Ok(Vec::new()) };
    let mut pairs = holding_pairs(&body.posture, options)?;
    pairs.iter_mut().for_each(|pair| translate(&body, mechanism, pair));
    Ok(pairs)
}

impl Verdict {
    /// Two contacts that feel three coordinates.
    fn decide_two(&mut self, mechanism: &Mechanism) -> Result<(), Error> {
        let space = mechanism.contact_space();
        let pair = Pair {
            psi: mechanism.local()?.psi(),
            restitution: [0, 1].map(|i| mechanism.restitution(i)),
            pull: [0, 1].map(|i| space.gravity(i)),
        };
        let found = conditions::of_words(&pair, self.equilibrium.holds, &self.modes);
        let local = Local::of_mechanism(mechanism, self.width);
        let holds = self.holds(local.as_ref(), self.equilibrium.margin);
        let map = local.filter(|_| holds == Ok(true)).map(|l| CornerMap::of(l, self.jams));
        let standing = Standing::Mechanism(mechanism);
        let decided = self.judge_pair(found, map.as_ref(), holds, standing, || None);
        self.take_pair(decided, found, map.as_ref(), true);
        Ok(())
    }

    /// Any number of contacts and coordinates.
    fn decide_jointed(&mut self, mechanism: &Mechanism) {
        let leaves = |answer: &&ModeAnswer| {
            answer.word.modes().any(|mode| mode != Mode::Fixed) && !answer.near_degenerate()
        };
        let tie = self.width > 0.0 && self.equilibrium.margin.abs() <= self.clear();
        let found = if !self.equilibrium.holds && !tie {
            self.not_in_equilibrium()
        } else if let Some(answer) =
            self.modes.iter().find(leaves).filter(|_| self.uses_closed_forms())
        {
            let word = Evidence::Word(answer.word);
            Finding::Decided(Stability::Unstable, Argument::AcceleratingMode, word)
        } else if self.jams == Jams::None
            && let Some(start) = no_motion(mechanism, self.width)
        {
            let evidence = Evidence::NoMotion(start);
            Finding::Decided(Stability::Unstable, Argument::NoSolution, evidence)
        } else if let Some(growth) = joints::shrinks(mechanism, self.width) {
            self.amplification = Err(NoBound::Joints);
            let by = Argument::BoundedCorners;
            Finding::Decided(Stability::Stable, by, Evidence::Shrinks { growth })
        } else if tie {
            undecided(WhyUndecided::Boundary)
        } else {
            undecided(WhyUndecided::Joints)
        };
        self.take(found);
    }
}

/// Edges N ± μT of the friction cones, with all friction times `factor`: the contact, the force (tangential, normal) and the row.
fn edges(mechanism: &Mechanism, factor: f64) -> Vec<(usize, [f64; 2], Coordinates)> {
    let space = mechanism.contact_space();
    let contacts = mechanism.contacts().iter().enumerate();
    contacts
        .flat_map(|(i, ContactRows { friction, .. })| {
            let friction = factor * friction;
            let sides: &[f64] = if friction == 0.0 { &[0.0] } else { &[1.0, -1.0] };
            sides.iter().map(move |side| (i, [side * friction, 1.0]))
        })
        .map(|(i, [t, n])| (i, [t, n], space.normal_row(i).plus(space.tangent(i), t)))
        .collect()
}

/// As [`edges`], of unit length.
fn unit_edges(mechanism: &Mechanism, factor: f64) -> Vec<(usize, [f64; 2], Coordinates)> {
    let of_length = |(contact, force, row): (usize, [f64; 2], Coordinates)| {
        let length = row.norm();
        (contact, force.map(|part: f64| part / length), row.divided(length))
    };
    edges(mechanism, factor).into_iter().map(of_length).collect()
}

/// The balance of forces, one row for each coordinate: Σ a_u A_u = −pull, in units of the pull.
fn balance(
    mechanism: &Mechanism,
    edges: &[(usize, [f64; 2], Coordinates)],
) -> Vec<(Vec<f64>, f64)> {
    let pull = mechanism.contact_space().pull();
    let weight = pull.norm();
    let unit = if weight > 0.0 { weight } else { 1.0 };
    (0..pull.len())
        .zip(pull.iter())
        .map(|(k, load)| {
            let along = |row: &Coordinates| row.iter().nth(k).unwrap_or(0.0);
            (edges.iter().map(|(.., row)| along(row)).collect(), -load / unit)
        })
        .collect()
}

/// Whether forces at the contacts hold the load. The margin of a mechanism is the largest weight that all edges of the friction cones can have
/// at once, of edges of unit length and in units of the load; −∞ if the load is not held. A mechanism has no region of a centre of mass.
fn equilibrium(mechanism: &Mechanism) -> Equilibrium {
    let edges = unit_edges(mechanism, 1.0);
    let held = balance(mechanism, &edges);
    let none = vec![0.0; edges.len()];
    let hidden = mechanism.contact_space().hidden().amax() > 0.0;
    if hidden || maximise(&held, &none).is_none() {
        return Equilibrium { holds: false, margin: f64::NEG_INFINITY, region: None };
    }
    // Weights a' + t with a' ≥ 0.
    let shared: Vec<(Vec<f64>, f64)> = held
        .into_iter()
        .map(|(mut row, load)| {
            row.push(row.iter().sum());
            (row, load)
        })
        .collect();
    let mut objective = none;
    objective.push(1.0);
    let most = maximise(&shared, &objective);
    let margin = most.and_then(|x| x.last().copied()).unwrap_or(f64::INFINITY);
    Equilibrium { holds: true, margin: margin.unsigned_zero(), region: None }
}

/// The forces that hold a mechanism in its posture; `None` if there are none.
///
/// ```
/// use standfast::body::Mechanism;
/// use standfast::stability::mechanism_forces;
/// use standfast::{Lamina, Posture};
///
/// let rod = Posture::rod(0.5, &Lamina { gravity: 10.0, ..Lamina::default() })?;
/// let forces = mechanism_forces(&Mechanism::of_posture(&rod)?).expect("the rod stands");
/// assert!(forces.low.iter().zip(&forces.high).all(|(low, high)| (low[1] - 5.0).abs().max((high[1] - 5.0).abs()) < 1e-14));
/// # Ok::<(), standfast::Error>(())
/// ```
#[must_use]
pub fn mechanism_forces(mechanism: &Mechanism) -> Option<StaticForces> {
    if mechanism.contact_space().hidden().amax() > 0.0 {
        return None;
    }
    let edges = edges(mechanism, 1.0);
    let held = balance(mechanism, &edges);
    let forces: Vec<(usize, [f64; 2])> = edges.iter().map(|(i, force, _)| (*i, *force)).collect();
    extremes(&held, &forces, mechanism.contacts().len(), mechanism.contact_space().pull().norm())
}

/// As [`friction_margin`](crate::stability::friction_margin) of a body: the friction that a mechanism at rest has to spare under its load, 1 − κ with
/// the least factor κ on all coefficients of friction with which forces at the contacts hold the load; −∞ if no factor is sufficient.
///
/// ```
/// use standfast::body::Mechanism;
/// use standfast::stability::{friction_margin, mechanism_friction_margin};
/// use standfast::{Contact, Posture, PostureFields};
///
/// let foot = |x, slope| Contact { friction: 0.5, ..Contact::at(x, 0.0).on_slope(slope) };
/// let vee = Posture::new(PostureFields {
///     gyration_radius: 0.5,
///     center_of_mass: [0.1, 0.5],
///     contacts: vec![foot(-0.5, 0.1), foot(0.5, 0.2)],
///     ..PostureFields::default()
/// })?;
/// let margin = mechanism_friction_margin(&Mechanism::of_posture(&vee)?);
/// assert!((margin - friction_margin(&vee)).abs() < 1e-12);
/// # Ok::<(), standfast::Error>(())
/// ```
#[must_use]
pub fn mechanism_friction_margin(mechanism: &Mechanism) -> f64 {
    if let Some(body) = RigidBody::of(mechanism) {
        return friction_margin(&body.posture);
    }
    if mechanism.contact_space().hidden().amax() > 0.0 {
        return f64::NEG_INFINITY;
    }
    spare_friction(|factor| {
        let edges = unit_edges(mechanism, factor);
        maximise(&balance(mechanism, &edges), &vec![0.0; edges.len()]).is_some()
    })
}

/// A start from which no motion exists, for any number of coordinates: one contact that slides jams while all others are in the air, or both of
/// two contacts.
fn no_motion(mechanism: &Mechanism, width: f64) -> Option<NoMotion> {
    let rows = EnclosedRows::<I>::of(mechanism)?.widened(width);
    let count = mechanism.contacts().len();
    let friction = |i: usize| {
        let friction = mechanism.contacts()[i].friction;
        I::from(friction).widened(width * friction)
    };
    // N_i M⁻¹ (N_j − σ_j μ_j T_j)ᵀ
    let stiffness = |i: usize, j: usize, side: f64| {
        let n = &rows.normals[i];
        dot(n, &rows.normals[j]) - friction(j).times(side) * dot(n, &rows.tangents[j])
    };
    for i in 0..count {
        for side in [1.0, -1.0] {
            let k = stiffness(i, i, side);
            if k.is_negative() && rows.gravity(i).is_positive() {
                let space = mechanism.contact_space();
                let k = space.normal(i, i)
                    - side * mechanism.contacts()[i].friction * space.w()[(2 * i + 1, 2 * i)];
                if let Some(found) = start(mechanism, &[(i, side)], Some(k)) {
                    return Some(found);
                }
            }
        }
    }
    if count != 2 || mechanism.contact_space().rank() < 4 {
        return None;
    }
    let g = [0, 1].map(|i| rows.gravity(i));
    if !g.iter().any(|g| g.is_positive()) {
        return None;
    }
    for sides in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        let a = |i: usize, j: usize| stiffness(i, j, sides[j]);
        let det = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
        let force = [g[0] * a(1, 1) - g[1] * a(0, 1), g[1] * a(0, 0) - g[0] * a(1, 0)];
        let stays = match det.sign() {
            Some(1) => force.iter().any(|f| f.is_negative()),
            Some(-1) => force.iter().any(|f| f.is_positive()),
            _ => false,
        };
        // Contact i cannot slide alone: its force g_i/A_ii is negative, or the other one does not lift, A_ji g_i/A_ii < g_j.
        let lifts_not = |i: usize| {
            let lift = a(1 - i, i) * g[i] - g[1 - i] * a(i, i);
            match a(i, i).sign() {
                Some(1) => g[i].is_negative() || lift.is_negative(),
                Some(-1) => g[i].is_positive() || lift.is_positive(),
                _ => false,
            }
        };
        if stays && lifts_not(0) && lifts_not(1) {
            let found = start(mechanism, &[(0, sides[0]), (1, sides[1])], None);
            if found.is_some() {
                return found;
            }
        }
    }
    None
}

/// A start at which these contacts slide in these directions on their ground, and all others are above theirs; `None` if the others cannot be.
fn start(
    mechanism: &Mechanism,
    slides: &[(usize, f64)],
    stiffness: Option<f64>,
) -> Option<NoMotion> {
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
    let placed = mechanism.coordinates(&Coordinates::from_iter(placed));
    let (mut rows, mut speeds) = (Vec::new(), Vec::new());
    for (i, side) in slides {
        rows.extend([space.normal_row(*i), space.tangent(*i)]);
        speeds.extend([0.0, side * SMALL]);
    }
    let moved = mechanism.coordinates(&crate::math::mass_vector::with_products(&rows, &speeds)?);
    let mode = |way: f64| if way > 0.0 { Mode::Right } else { Mode::Left };
    let letters = slides.iter().enumerate();
    Some(NoMotion {
        contacts: slides.iter().map(|(i, _)| ContactNumber::of(*i)).collect(),
        slides: letters
            .fold(Word::separate(slides.len()), |word, (k, (_, way))| word.with(k, mode(*way))),
        stiffness,
        q: placed,
        qdot: moved,
    })
}

/// Writes motions of the body as those of the coordinates of the mechanism.
fn translate(body: &RigidBody, mechanism: &Mechanism, verdict: &mut Verdict) {
    let [cx, cy] = body.center;
    let all = |motion: &mut Vec<f64>| {
        let [x, y, turn] = motion[..] else { return };
        let mut values = vec![0.0; mechanism.dof()];
        let own = [x + turn * cy, y - turn * cx, turn];
        mechanism
            .contact_space()
            .free()
            .iter()
            .zip(own)
            .for_each(|(&k, v)| values[k] = v.unsigned_zero());
        *motion = values;
    };
    match &mut verdict.evidence {
        Some(Evidence::NoMotion(start)) => {
            all(&mut start.q);
            all(&mut start.qdot);
        }
        Some(Evidence::Motion { velocity, .. }) => all(velocity),
        _ => {}
    }
    for answer in &mut verdict.modes {
        all(&mut answer.acceleration);
    }
}
