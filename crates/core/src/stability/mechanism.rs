//! Stability of a mechanism in its posture.
//!
//! With three coordinates that are not locked, or more of which the contacts feel three, the contacts move as those of a rigid body: every test
//! of two contacts applies to the contact space. If the three are (x, y, θ) of a rigid body, the verdict is that of this body, with any number of contacts.
//!
//! With more coordinates (joints with torques) both contacts may slide in any directions, and one may slide while the other one is fixed. That the
//! contacts nevertheless come to rest is proved by `joints.rs`. Three things make a posture unstable: the load is not held; a contact mode that moves is consistent
//! at rest; or no motion exists after some small kicks, see `jams.rs`. Any number of bodies and contacts may stand in a potential well: see `potential_well.rs`.

use crate::body::Mechanism;
use crate::body::rigid::RigidBody;
use crate::error::{Error, dissipative};
use crate::math::mass_vector::MassVector;
use crate::math::simplex::maximise;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{MechanismProblem, Method, Mode, ModeAnswer, contact_modes};
use crate::options::Jams;
use crate::stability::conditions::{self, Equilibrium, Pair};
use crate::stability::cones::{balance, edges, unit_edges};
use crate::stability::corner::CornerMap;
use crate::stability::existence::Standing;
use crate::stability::jams::{mechanism_jams, no_motion};
use crate::stability::joints;
use crate::stability::local::Local;
use crate::stability::potential_well::{self, Found};
use crate::stability::static_forces::{StaticForces, extremes, friction_margin, spare_friction};
use crate::stability::{
    Argument, Details, Evidence, Finding, LOSES, NoBound, Stability, StabilityOptions, Verdict,
    WhyUndecided, holding_pairs, judge, undecided,
};

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
    let mut verdict = judge_mechanism(mechanism, options)?;
    if let Some(Evidence::NoMotion(start)) = &mut verdict.evidence {
        start.jams = mechanism_jams(mechanism, options.width);
    }
    Ok(verdict)
}

/// The verdict on a mechanism without spectators.
fn judge_mechanism(mechanism: &Mechanism, options: StabilityOptions) -> Result<Verdict, Error> {
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
        let map = local.filter(|_| holds == Ok(true)).map(|l| CornerMap::of(l, self.after_jam));
        let standing = Standing::Mechanism(mechanism);
        let decided = self.judge_pair(found, map.as_ref(), holds, standing, || None);
        self.take_pair(decided, found, map.as_ref(), true);
        if self.by.is_none()
            && let Some(found) = self.in_well(mechanism).filter(Finding::decides)
        {
            self.take(found);
        }
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
        } else if self.after_jam == Jams::None
            && let Some(start) = no_motion(mechanism, self.width)
        {
            let evidence = Evidence::NoMotion(start);
            Finding::Decided(Stability::Unstable, Argument::NoSolution, evidence)
        } else if let Some(growth) = joints::shrinks(mechanism, self.width) {
            self.amplification = Err(NoBound::Joints);
            let by = Argument::BoundedCorners;
            Finding::Decided(Stability::Stable, by, Evidence::Shrinks { growth })
        } else {
            match self.in_well(mechanism) {
                Some(found) if found.decides() || !tie => found,
                _ if tie => undecided(WhyUndecided::Boundary),
                _ => undecided(WhyUndecided::Joints),
            }
        };
        self.take(found);
    }

    /// What a potential well decides; `None` if the width is too large for closed forms.
    fn in_well(&mut self, mechanism: &Mechanism) -> Option<Finding> {
        if !self.uses_closed_forms() || !self.equilibrium.holds {
            return None;
        }
        Some(match potential_well::decide(mechanism, self.options(), self.clear()) {
            Found::Stable(evidence, laws) => {
                self.laws = laws;
                // E never rises, and the load's part of it is not negative.
                self.amplification = Ok(1.0);
                Finding::Decided(Stability::Stable, Argument::PotentialWell, evidence)
            }
            Found::Unstable(by, evidence) => Finding::Decided(Stability::Unstable, by, evidence),
            Found::Open(reason) => undecided(reason),
        })
    }
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
