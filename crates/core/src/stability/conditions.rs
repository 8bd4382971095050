//! Conditions in closed form: equilibrium, the words at rest, and the bounds on the coupling.

use serde::{Deserialize, Serialize};

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::Error;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{
    Condition, ContactProblem, Margin, Method, Mode, ModeAnswer, TIE, Word, contact_modes,
};
use crate::stability::clattering::{chatter_bound, clattering_bound, coupling};
use crate::stability::region::equilibrium_region;

/// The part of a [`Verdict`](super::Verdict) that needs no corner map: Theorem 3 and its margins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// Whether the centre of mass lies over the equilibrium region.
    pub equilibrium: bool,
    /// Its distance to the nearer end of the region, in m; negative outside, −∞ if there is none.
    #[serde(with = "crate::serial::numbers::extended")]
    pub equilibrium_margin: f64,
    /// The region, see [`equilibrium_region`].
    #[serde(rename = "equilibrium_region", with = "ends")]
    pub region: Option<[f64; 2]>,
    /// No word other than the static one fits: its forces do (f_n ≥ 0), but a strict kinematic inequality fails.
    pub kinematic_strong: bool,
    /// The same, with the friction cone required of fixed contacts, too.
    pub kinematic_strong_strict: bool,
    /// FF is the only consistent word.
    pub unambiguous: bool,
    /// Least margin of the kinematic-strong test, dimensionless: how far the nearest condition is from failing or holding.
    #[serde(with = "crate::serial::numbers::extended")]
    pub kinematic_margin: f64,
    /// ψ.
    pub coupling: f64,
    /// Whether (10) holds.
    pub clattering: bool,
    /// ψ less the bound of (10).
    pub clattering_margin: f64,
    /// Whether Goyal's bound holds.
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
    /// Whether the posture is a kinematic-strong equilibrium in which clattering converges [Or & Rimon 2008, Theorem 3].
    #[must_use]
    pub fn theorem_3(&self) -> bool {
        self.certainly_strong() && self.clattering
    }

    /// Kinematic-strong, and by more than a tie: a body without friction on level ground, or without gravity, does not return
    /// from a slide that nothing speeds up.
    pub(super) fn certainly_strong(&self) -> bool {
        self.kinematic_strong && self.kinematic_margin > TIE
    }
}

/// The conditions of Theorem 3 for a posture with two contacts, in its nominal configuration q = 0: those of
/// [`stability`](super::stability) to the bit, in a hundredth of the time where that one has to look further.
///
/// # Errors
///
/// [`Error::Unusable`] naming `contacts` unless there are two, or where one does not touch.
pub fn conditions(posture: &Posture) -> Result<Conditions, Error> {
    let psi = on_two_feet(posture)?;
    let problem = ContactProblem::of_posture(posture, &State::at_rest([0.0; 3]), [0.0; 3])?;
    let mut words = Words::default();
    match problem.pair_modes() {
        // Where no word is consistent, ties may make one.
        Some(pair) if pair.consistent().next().is_some() => {
            for mode in pair.iter() {
                let judged = mode.judged(&problem);
                words.add(judged.word, judged.consistent, judged.margins());
            }
        }
        _ => contact_modes(&problem, Method::Auto)?.answers().iter().for_each(|a| words.take(a)),
    }
    Ok(words.conditions(posture, psi))
}

/// The same from the words solved already.
pub(super) fn of_words(posture: &Posture, psi: [f64; 2], answers: &[ModeAnswer]) -> Conditions {
    let mut words = Words::default();
    answers.iter().for_each(|answer| words.take(answer));
    words.conditions(posture, psi)
}

/// ψ of a posture that stands on both of its contacts.
pub(super) fn on_two_feet(posture: &Posture) -> Result<[f64; 2], Error> {
    let psi = posture.psi()?;
    for (i, k) in posture.geometry().iter().enumerate() {
        if k.offset != 0.0 {
            return Err(Error::Unusable {
                field: format!("contacts.{}.point", i + 1),
                value: format!("{:?}", posture.contacts()[i].point),
                allowed: "on the terrain: stability is asked of a posture that touches".into(),
            });
        }
        let contact = &posture.contacts()[i];
        if contact.segment.contains(&0.0) {
            return Err(Error::Unusable {
                field: format!("contacts.{}.point", i + 1),
                value: format!("{:?}", contact.point),
                allowed: "between the ends of the piece of terrain under it, not at one of them: \
                          stability is asked of small motions to both sides"
                    .into(),
            });
        }
    }
    Ok(psi)
}

/// Whether a word may be looked at: not FF, and not one with a fixed and a sliding contact, whose motion is none.
pub(super) fn moves(word: Word) -> bool {
    let (mut fixed, mut slides, mut all) = (false, false, true);
    for mode in word.modes() {
        fixed |= mode == Mode::Fixed;
        slides |= mode.direction() != 0.0;
        all &= mode == Mode::Fixed;
    }
    !(all || fixed && slides)
}

/// Whether a word is excluded by kinematics although its forces fit, and by how much: the forces' least margin or the largest
/// violation, whichever is nearer to failing.
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

/// What the words at rest say together.
struct Words {
    strong: bool,
    strict: bool,
    margin: f64,
    /// A static word is consistent; a moving one is.
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

    fn conditions(&self, posture: &Posture, psi: [f64; 2]) -> Conditions {
        let region = equilibrium_region(posture);
        let x = posture.fields().center_of_mass[0];
        let equilibrium_margin =
            region.map_or(f64::NEG_INFINITY, |[low, high]| (x - low).min(high - x));
        let equilibrium = equilibrium_margin >= 0.0;
        let e = [0, 1].map(|i| posture.geometry()[i].restitution);
        let coupling = coupling(psi);
        let clattering_margin = coupling - clattering_bound(e);
        let chatter_margin = coupling - chatter_bound(e);
        Conditions {
            equilibrium,
            equilibrium_margin: equilibrium_margin.unsigned_zero(),
            region,
            kinematic_strong: equilibrium && self.strong,
            kinematic_strong_strict: equilibrium && self.strict,
            unambiguous: equilibrium && self.holds && !self.leaves,
            kinematic_margin: self.margin.unsigned_zero(),
            coupling: coupling.unsigned_zero(),
            clattering: clattering_margin > 0.0,
            clattering_margin,
            chatter: coupling > 0.0 && chatter_margin >= 0.0,
            chatter_margin,
        }
    }
}
