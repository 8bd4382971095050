//! Conditions in closed form: equilibrium, the contact-mode words at rest, and the bounds on the coupling.

use serde::{Deserialize, Serialize};

use crate::body::contact::Contact;
use crate::body::fields::{GroundKind, PostureFields};
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::Error;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{
    Condition, ContactProblem, Margin, Method, Mode, ModeAnswer, TIE, Word, contact_modes,
};
use crate::stability::clattering::{chatter_bound, clattering_bound, coupling};
use crate::stability::region::equilibrium_region;

/// Whether the contacts can hold the body, for any number of contacts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Equilibrium {
    /// Whether the centre of mass lies over the equilibrium region.
    #[serde(rename = "equilibrium")]
    pub holds: bool,
    /// Distance of the centre of mass from the nearer end of the region, in m; negative outside, −∞ if there is no region.
    #[serde(rename = "equilibrium_margin", with = "crate::serial::numbers::extended")]
    pub margin: f64,
    /// The region, see [`equilibrium_region`].
    #[serde(rename = "equilibrium_region", with = "ends")]
    pub region: Option<[f64; 2]>,
}

impl Equilibrium {
    /// That of the nominal posture.
    pub(crate) fn of(posture: &Posture) -> Self {
        let (region, x) = (equilibrium_region(posture), posture.fields().center_of_mass[0]);
        let margin = region.map_or(f64::NEG_INFINITY, |[low, high]| (x - low).min(high - x));
        Self { holds: margin >= 0.0, margin: margin.unsigned_zero(), region }
    }
}

/// The part of a [`Verdict`](super::Verdict) on two contacts that has a closed form: the conditions of Theorem 3 of the paper [Or & Rimon
/// 2008] and their margins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// No word other than the static one is possible: each other word whose forces are admissible (f_n ≥ 0) violates a strict kinematic
    /// inequality.
    pub kinematic_strong: bool,
    /// The same, but a word has admissible forces only if the forces of its fixed contacts also lie in their friction cones.
    pub kinematic_strong_strict: bool,
    /// FF is the only consistent word.
    pub unambiguous: bool,
    /// Least margin of the kinematic-strong test, dimensionless: how far the nearest condition is from changing its result.
    #[serde(with = "crate::serial::numbers::extended")]
    pub kinematic_margin: f64,
    /// ψ.
    pub coupling: f64,
    /// Whether (10) holds and the forces of the contacts without friction, D⁻¹(g_1, g_2), are positive. They always are for ψ > 0 on
    /// ground that faces up.
    pub clattering: bool,
    /// ψ less the bound of (10).
    pub clattering_margin: f64,
    /// Whether Goyal's bound holds and these forces are positive.
    pub chatter: bool,
    /// ψ less Goyal's bound.
    pub chatter_margin: f64,
}

/// Serde for the ends of the region: infinite ones as the strings "inf" and "-inf".
mod ends {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::serial::numbers::Extended;

    #[allow(clippy::ref_option, reason = "serde passes references")]
    pub(super) fn serialize<S: Serializer>(
        region: &Option<[f64; 2]>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        region.map(|ends| ends.map(Extended::from)).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Option<[f64; 2]>, D::Error> {
        Ok(<Option<[Extended; 2]>>::deserialize(deserializer)?.map(|ends| ends.map(f64::from)))
    }
}

impl Conditions {
    /// Returns true if the posture is a kinematic-strong equilibrium in which clattering converges [Or & Rimon 2008, Theorem 3].
    #[must_use]
    pub fn theorem_3(&self) -> bool {
        self.certainly_strong() && self.clattering
    }

    /// Kinematic-strong with a margin above that of a tie. A body without friction on level ground, or without gravity, is a tie: such a
    /// body slides without acceleration and does not return.
    pub(super) fn certainly_strong(&self) -> bool {
        self.kinematic_strong && self.kinematic_margin > TIE
    }
}

/// The conditions of Theorem 3 for a posture on two contacts, in its nominal configuration q = 0. The values are equal, bit by bit, to
/// those of [`stability`](super::stability). They take a hundredth of the time if `stability` needs the corner map.
///
/// ```
/// use standfast::stability::conditions;
/// use standfast::{Lamina, Posture};
///
/// // A uniform rod: ψ = (L² − ρ²)/(L² + ρ²) = 1/2. Without rebound clattering converges for every ψ > 0.
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// let found = conditions(&rod)?;
/// assert!(found.theorem_3());
/// assert!((found.clattering_margin - 0.5).abs() < 1e-15);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Unusable`] naming `contacts` unless two touch.
pub fn conditions(posture: &Posture) -> Result<Conditions, Error> {
    if let Some((standing, _)) = of_those_that_touch(posture)? {
        return conditions(&standing);
    }
    if posture.contacts().len() != 2 {
        return Err(Error::Unusable {
            field: "contacts".into(),
            value: format!("[{} contacts touch]", posture.contacts().len()),
            allowed: "exactly 2 contacts that touch, for the conditions of Theorem 3".into(),
        });
    }
    let pair = Pair::of(posture)?;
    let problem = ContactProblem::of_posture(posture, &State::at_rest([0.0; 3]), [0.0; 3])?;
    let mut words = Words::default();
    match problem.pair_modes() {
        // If no word is consistent, ties may make one consistent; the general solver treats them.
        Some(all) if all.consistent().next().is_some() => {
            for mode in all.iter() {
                let judged = mode.judged(&problem);
                words.add(judged.word, judged.consistent, judged.margins());
            }
        }
        _ => contact_modes(&problem, Method::Auto)?.answers().iter().for_each(|a| words.take(a)),
    }
    Ok(words.conditions(&pair, Equilibrium::of(posture).holds))
}

/// The constants of two contacts that the conditions need.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    pub(super) psi: [f64; 2],
    pub(super) restitution: [f64; 2],
    /// Gravity into the ground of each contact, in any unit.
    pub(super) pull: [f64; 2],
}

impl Pair {
    /// Of a posture on two contacts.
    pub(super) fn of(posture: &Posture) -> Result<Self, Error> {
        let each = |of: &dyn Fn(usize) -> f64| [of(0), of(1)];
        Ok(Self {
            psi: posture.psi()?,
            restitution: each(&|i| posture.geometry()[i].restitution),
            pull: each(&|i| posture.geometry()[i].normal.y),
        })
    }
}

/// The same conditions from words that are already solved.
pub(super) fn of_words(pair: &Pair, equilibrium: bool, answers: &[ModeAnswer]) -> Conditions {
    let mut words = Words::default();
    answers.iter().for_each(|answer| words.take(answer));
    words.conditions(pair, equilibrium)
}

/// The places, from 0, of the contacts that touch their ground in the nominal posture, and of the sides that touch corners of the ground.
pub(super) fn touching(posture: &Posture) -> Vec<usize> {
    let geometry = posture.geometry();
    let own = (0..geometry.len()).filter(|&i| geometry[i].offset == 0.0);
    own.chain((geometry.len()..).take(posture.side_contacts().len())).collect()
}

/// The posture with these of its contacts only, by their places from 0, each on its own straight ground. After the contacts of the posture
/// come its sides on corners of the ground.
///
/// ```
/// use standfast::stability::with_contacts;
/// use standfast::{Lamina, Posture};
///
/// let block = Posture::block(1.0, 3.0, &Lamina::default())?;
/// assert_eq!(with_contacts(&block, &[0, 1])?.contacts().len(), 2); // its lower corners
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`Posture::new`].
///
/// # Panics
///
/// If there is no contact at a place.
pub fn with_contacts(posture: &Posture, places: &[usize]) -> Result<Posture, Error> {
    let posture = &posture.at_its_place()?;
    let all = [posture.contacts(), &posture.side_contacts()].concat();
    Posture::new(PostureFields {
        contacts: places.iter().map(|&k| straight(&all[k])).collect(),
        terrain: Vec::new(),
        ground: GroundKind::Own,
        outline: Vec::new(),
        ..posture.fields().clone()
    })
}

/// A contact with its piece of ground. That of a round contact has no ends.
fn straight(contact: &Contact) -> Contact {
    let endless = [f64::NEG_INFINITY, f64::INFINITY];
    if contact.is_round() { Contact { segment: endless, ..*contact } } else { *contact }
}

/// The posture without the contacts that do not touch, and the places of the others in the list of all contacts; `None` if all touch ground that
/// has no material of its own.
/// Small motions do not bring the contacts that are left out to the ground.
///
/// # Errors
///
/// [`Error::Unusable`] if no contact touches, or if one that touches is at an end of its piece of terrain.
pub(super) fn of_those_that_touch(
    posture: &Posture,
) -> Result<Option<(Posture, Vec<usize>)>, Error> {
    let places = touching(posture);
    for (i, contact) in posture.contacts().iter().enumerate().filter(|(i, _)| places.contains(i)) {
        let in_vertex =
            contact.is_round() && posture.touched(i, &nalgebra::Vector3::zeros()).len() > 1;
        if contact.segment.contains(&0.0) || in_vertex {
            return Err(Error::Unusable {
                field: format!("contacts.{}.point", i + 1),
                value: format!("{:?}", contact.point),
                allowed: "between the ends of the piece of terrain under it, not at one of them: \
                          stability is defined for small motions to both sides"
                    .into(),
            });
        }
    }
    if places.is_empty() {
        let count = posture.contacts().len();
        return Err(Error::Unusable {
            field: "contacts".into(),
            value: format!("[{count} contacts, none of them touches its ground at q = 0]"),
            allowed: "at least one contact that touches its ground at q = 0: stability is defined for a posture that stands".into(),
        });
    }
    let all_touch = places.len() == posture.contacts().len() && posture.side_contacts().is_empty();
    if all_touch && posture.has_bare_ground() {
        return Ok(None);
    }
    Ok(Some((with_contacts(posture, &places)?, places)))
}

/// Returns true if a word is a motion: not FF, and not a word with a fixed and a sliding contact, which allows no motion.
pub(super) fn moves(word: Word) -> bool {
    let (mut fixed, mut slides, mut all) = (false, false, true);
    for mode in word.modes() {
        fixed |= mode == Mode::Fixed;
        slides |= mode.direction() != 0.0;
        all &= mode == Mode::Fixed;
    }
    !(all || fixed && slides)
}

/// Whether a word is excluded by kinematics although its forces are admissible, and the margin of this: the least margin of the forces or
/// the size of the largest kinematic violation, whichever is smaller.
fn excluded(margins: &[Margin], strict: bool) -> (bool, f64) {
    let mut forces = f64::INFINITY;
    let mut kinematics = f64::INFINITY;
    for margin in margins {
        match margin.condition {
            Condition::Presses => forces = forces.min(margin.value),
            Condition::InCone if strict => forces = forces.min(margin.value),
            condition if condition.is_strict() => kinematics = kinematics.min(margin.value),
            _ => {}
        }
    }
    let fits = forces >= -TIE;
    let fails = kinematics <= TIE;
    (fits && fails, forces.min(-kinematics))
}

/// Results of the words at rest, combined.
struct Words {
    strong: bool,
    strict: bool,
    margin: f64,
    /// Whether a static word is consistent, and whether a moving word is.
    holds: bool,
    leaves: bool,
}

impl Default for Words {
    fn default() -> Self {
        Self { strong: true, strict: true, margin: f64::INFINITY, holds: false, leaves: false }
    }
}

impl Words {
    fn take(&mut self, answer: &ModeAnswer) {
        self.add(answer.word, answer.consistent, &answer.margins);
    }

    fn add(&mut self, word: Word, consistent: bool, margins: &[Margin]) {
        if moves(word) {
            let (excluded_by_kinematics, margin) = excluded(margins, false);
            self.strong &= excluded_by_kinematics;
            self.strict &= excluded(margins, true).0;
            self.margin = self.margin.min(margin);
            self.leaves |= consistent;
        } else {
            self.holds |= consistent;
        }
    }

    fn conditions(&self, pair: &Pair, equilibrium: bool) -> Conditions {
        let Pair { psi, restitution: e, pull: [one, two] } = *pair;
        let coupling = coupling(psi);
        let pressed = one.min(two) >= 0.0 && one.max(two) > 0.0
            || two + psi[0] * one > 0.0 && one + psi[1] * two > 0.0;
        let clattering_margin = coupling - clattering_bound(e);
        let chatter_margin = coupling - chatter_bound(e);
        Conditions {
            kinematic_strong: equilibrium && self.strong,
            kinematic_strong_strict: equilibrium && self.strict,
            unambiguous: equilibrium && self.holds && !self.leaves,
            kinematic_margin: self.margin.unsigned_zero(),
            coupling: coupling.unsigned_zero(),
            clattering: clattering_margin > 0.0 && pressed,
            clattering_margin,
            chatter: coupling > 0.0 && chatter_margin >= 0.0 && pressed,
            chatter_margin,
        }
    }
}
