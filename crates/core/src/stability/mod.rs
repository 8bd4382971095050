//! Stability of a posture that touches its ground with frictional contacts: after any sufficiently small kick, does the body come back to
//! rest near the posture?
//!
//! The verdict follows the paper [Or & Rimon 2008] and extends it. These conditions are tested in order:
//!
//! 1. equilibrium: the centre of mass lies over the equilibrium region;
//! 2. kinematic-strong equilibrium: no word other than FF satisfies the kinematic and the force conditions;
//! 3. clattering convergence, condition (10) of the paper: with 2. it gives Theorem 3, frictional stability;
//! 4. if these do not decide: Goyal's bound instead of (10), the energy where both contacts can only slide on a level, and the corner map,
//!    in intervals.
//!
//! With three and more contacts the energy decides most postures: see [`Well`] and [`Evidence`].
//!
//! [`static_forces`] and [`friction_margin`] give the forces at rest and the reserve of friction.
//!
//! All results hold for the local model: small motions, to first order.

mod amplification;
mod barrier;
mod cells;
mod certify;
mod clattering;
mod conditions;
mod cones;
mod corner;
mod existence;
mod faces;
mod fate;
mod feet;
mod jams;
mod joints;
mod local;
mod mechanism;
mod potential_well;
mod reduced;
mod region;
mod settling;
mod static_forces;
mod trap;
mod trials;

pub use amplification::NoBound;
pub use clattering::{
    SelfSimilar, chatter_bound, chatter_restitution, clattering_bound, clattering_restitution,
    coupling, neimark_sacker, self_similar,
};
pub use conditions::{Conditions, Equilibrium, conditions, with_contacts};
pub use fate::{Fate, FateKind};
pub use feet::{PairVerdict, Ray, Well};
pub use jams::{Jam, NoMotion, jams, mechanism_jams};
pub use local::FlightsEnd;
pub use mechanism::{
    mechanism_forces, mechanism_friction_margin, mechanism_pairs, mechanism_stability,
};
pub use reduced::{BATCHES, Exponents, Orbit, OrbitEnd, ReducedMap, ReducedStep, Shape};
pub use region::equilibrium_region;
pub use static_forces::{StaticForces, friction_margin, static_forces};
pub use trials::{MOST_TRIALS, Trials, mechanism_trials, trials};

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::body::Mechanism;
use crate::body::contact::Contact;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::{Error, dissipative, in_range};
use crate::math::interval::Interval;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{ContactProblem, Method, Mode, ModeAnswer, Word, contact_modes};
use crate::options::{Impact, Jams};
use crate::outcome::ContactNumber;
use crate::serial::shown_as_str;
pub use certify::{Potential, WhyUndecided};

use crate::tolerance::DELICATE_MARGIN;
use certify::Decision;
use conditions::{Pair, moves};
use corner::{Away, CornerMap};
use existence::Standing;
use feet::Carried;
use jams::no_motion;
use local::Local;
use trap::TrapCell;

shown_as_str!(Stability, Argument, WhyUndecided, NoBound, FateKind);

/// Whether a body comes back to rest after any small kick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stability {
    /// The body comes back to rest after any sufficiently small kick.
    Stable,
    /// The body moves away after some kicks, however small.
    Unstable,
    /// No argument decides.
    Undecided,
}

impl Stability {
    /// Its name in files.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Undecided => "undecided",
        }
    }
}

/// The argument behind a verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Argument {
    /// The contacts cannot hold the body.
    NotEquilibrium,
    /// Kinematic-strong with the friction cone required of fixed contacts, and condition (10): Theorem 3.
    #[serde(rename = "theorem-3")]
    Theorem3,
    /// Kinematic-strong, and condition (10): Theorem 3.
    #[serde(rename = "theorem-3-loose")]
    Theorem3Loose,
    /// Kinematic-strong, and Goyal's bound.
    Goyal,
    /// Every sequence of corners shrinks.
    CornerMap,
    /// A cycle of corners grows.
    GrowingCycle,
    /// Corners repeat, larger every time, whichever of several outcomes follow them.
    GrowingTrap,
    /// The body moves away in a mode and does not come back.
    AcceleratingMode,
    /// After some kicks, however small, no motion exists: no mode is consistent, and no impact is due.
    NoSolution,
    /// Every motion of the body raises its centre of mass, and a motion always exists.
    Well,
    /// The body can descend only on one pair of contacts, and this pair is stable; or no pair on which it descends can hold it, or the only
    /// one is unstable.
    DescendingPair,
    /// Every motion raises the centre of mass but a slide on a level, which friction ends.
    Neutral,
    /// The body stands on one contact, and nothing resists a turn about it.
    SingleSupport,
    /// Two contacts that slide independently: over every cycle of landings the landing speed falls, and friction ends the slides.
    BoundedCorners,
    /// Without friction the contacts hold the load, a motion always exists, and friction ends every slide on a level.
    PotentialWell,
}

impl Argument {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::NotEquilibrium,
        Self::Theorem3,
        Self::Theorem3Loose,
        Self::Goyal,
        Self::CornerMap,
        Self::GrowingCycle,
        Self::GrowingTrap,
        Self::AcceleratingMode,
        Self::NoSolution,
        Self::Well,
        Self::DescendingPair,
        Self::Neutral,
        Self::SingleSupport,
        Self::BoundedCorners,
        Self::PotentialWell,
    ];

    /// Its name in files.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::NotEquilibrium => "not-equilibrium",
            Self::Theorem3 => "theorem-3",
            Self::Theorem3Loose => "theorem-3-loose",
            Self::Goyal => "goyal",
            Self::CornerMap => "corner-map",
            Self::GrowingCycle => "growing-cycle",
            Self::GrowingTrap => "growing-trap",
            Self::AcceleratingMode => "accelerating-mode",
            Self::NoSolution => "no-solution",
            Self::Well => "well",
            Self::DescendingPair => "descending-pair",
            Self::Neutral => "neutral",
            Self::SingleSupport => "single-support",
            Self::BoundedCorners => "bounded-corners",
            Self::PotentialWell => "potential-well",
        }
    }

    /// The same in words, as reports and pages have it.
    #[must_use]
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::NotEquilibrium => "no forces at the contacts hold the body",
            Self::Theorem3 => {
                "kinematic-strong (strict reading) and clattering converges: Theorem 3 of Or and Rimon"
            }
            Self::Theorem3Loose => {
                "kinematic-strong and clattering converges: Theorem 3 of Or and Rimon"
            }
            Self::Goyal => {
                "kinematic-strong, and impacts alternate for ever without gravity (Goyal's bound)"
            }
            Self::CornerMap => "every sequence of corners shrinks, or ends at rest",
            Self::GrowingCycle => "a cycle of corners repeats, larger every time",
            Self::GrowingTrap => {
                "corners follow each other without end, and every sequence of them grows"
            }
            Self::AcceleratingMode => {
                "a contact mode leads away from the posture and does not return"
            }
            Self::NoSolution => {
                "after some kicks, however small, no motion exists (Painlevé); nothing grows, but the definition asks for a motion; with jams=\"impact\" it goes on after an impact without collision"
            }
            Self::Well => {
                "every motion raises the centre of mass: the body stands in a well, and a motion always exists"
            }
            Self::DescendingPair => {
                "the body descends on no more than one pair of contacts, which decides"
            }
            Self::Neutral => {
                "no small motion lowers the centre of mass, and friction stops a slide at the same height"
            }
            Self::SingleSupport => {
                "the body stands on one contact: nothing resists a turn about it"
            }
            Self::BoundedCorners => {
                "over every cycle of landings the landing speed falls, and friction ends the slides"
            }
            Self::PotentialWell => {
                "the contacts hold the load without friction, so that energy bounds every gap; a motion always exists, and friction ends every slide on a level"
            }
        }
    }
}

/// A corner: one contact on the terrain, the other one lands.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CornerStep {
    /// The contact that lands.
    pub contact: ContactNumber,
    /// φ, in rad. The landing speed is −u_j = r cos φ, and the other contact slides at v_t,i = r sin φ.
    pub phi: f64,
    /// ln r′/r to the next corner. The sum over a growing cycle is a lower bound that is proved.
    pub growth: f64,
}

/// Corners of a trap: all images of the corners in a range of φ lie in ranges of the trap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrapRange {
    /// The contact that lands.
    pub contact: ContactNumber,
    /// Limits of ξ/y = v_t,i/(α_i y): see [`Potential`].
    #[serde(with = "crate::serial::numbers::extended_pair")]
    pub slope: [f64; 2],
    /// A number W: W ≤ ln G + W(next) − 1e-9 for all next ranges, with G = r'/r the growth to the next corner, r² = ξ² + y².
    pub weight: f64,
    /// A lower bound of ln G.
    pub growth: f64,
}

/// The data of an argument, or why there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Evidence {
    /// The centre of mass is not over the equilibrium region.
    Region {
        /// [`Equilibrium::margin`], negative.
        #[serde(with = "crate::serial::numbers::extended")]
        equilibrium_margin: f64,
    },
    /// Kinematic-strong, and a bound on the coupling holds.
    Margins {
        /// [`Conditions::kinematic_margin`]
        #[serde(with = "crate::serial::numbers::extended")]
        kinematic_margin: f64,
        /// ψ less the bound of the argument: the bound (10) or Goyal's bound.
        coupling_margin: f64,
    },
    /// No sequence of corners grows for ever.
    Potential(Potential),
    /// A cycle of corners that grows with every repetition.
    Cycle(Vec<CornerStep>),
    /// Corners that no motion leaves, and in which all motions grow.
    Trap(Vec<TrapRange>),
    /// A word that is consistent at rest and in which the body moves away.
    Word(Word),
    /// A corner after which the body moves away.
    Away(CornerStep),
    /// A motion in which the body moves away.
    Motion {
        /// Its word.
        word: Word,
        /// The velocity (ẋ, ẏ, θ̇) at q = 0 with which the motion starts, in m/s and rad/s; of a mechanism that of all coordinates. The contact on the terrain slides at 1 m/s or
        /// is at rest; if the other contact leaves the terrain with a gap rate, that rate is 1 m/s.
        velocity: Vec<f64>,
    },
    /// A start from which no motion exists.
    NoMotion(NoMotion),
    /// The rays of a well.
    Well {
        /// [`Well::width`]
        width: f64,
        /// All rays: they ascend.
        rays: Vec<Ray>,
    },
    /// The rays, and the verdicts on the pairs of those that do not ascend. Of a body on one line of ground the verdict on its outer contacts.
    DescendingPairs {
        /// All rays; none on one line of ground.
        rays: Vec<Ray>,
        /// The pairs.
        pairs: Vec<PairVerdict>,
    },
    /// The contacts that bear the body while it slides on a level.
    Neutral {
        /// The outer contacts.
        outer: [ContactNumber; 2],
        /// k = N M⁻¹ (N − σμT)ᵀ of each of them, per unit mass, while it slides to the right (σ = 1) and to the left: positive
        /// unless jams end by impacts.
        stiffness: [[f64; 2]; 2],
    },
    /// Why the corner map does not decide, and the undecided cells.
    Left {
        /// The reason.
        reason: WhyUndecided,
        /// Cells per contact.
        cells: usize,
        /// The undecided cells: (contact, [from, to]) in atan(ξ/y).
        left: Vec<(ContactNumber, [f64; 2])>,
    },
    /// What bounds the motions of a mechanism in a potential well.
    PotentialWell {
        /// Λ of each contact: the largest normal force, in N (N m over the unit of the gap), with which the contacts hold the load without friction. Gaps are at
        /// most E/Λ for ever, with E the energy of [`Mechanism::energy`].
        largest: Vec<f64>,
        /// Number of independent slides on a level, which friction ends.
        level: usize,
    },
    /// Landings at two contacts that slide independently, which become slower.
    Shrinks {
        /// An upper bound, below 1, of the mean growth of the landing speed over a cycle of landings.
        growth: f64,
    },
}

/// What a verdict assumes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StabilityOptions {
    /// Whether a motion ends where a contact jams, or goes on after the plastic impact that stops the contact. With [`Jams::Impact`] a posture
    /// is not unstable because of missing motions.
    pub jams: Jams,
    /// The verdict holds for all scenes whose numbers differ from those given by at most this share: both coordinates of the arm from the
    /// centre of mass to a contact by this share of its length; slope, restitution, friction and radius of gyration by this share of themselves.
    /// Slopes that are multiples of a right angle are exact. From 0 to 0.1.
    pub width: f64,
}

/// The width of a verdict, unless another one is given: more than the rounding errors of numbers that were converted from decimals or moved
/// by up to a thousand times their size.
pub const DEFAULT_WIDTH: f64 = 1e-12;

/// The largest width.
const LARGEST_WIDTH: f64 = 0.1;

/// The change of a dimensionless margin of a closed form by the width, divided by the width, is taken to be at most this number. It is larger only
/// where contacts nearly depend on each other.
const CONDITION: f64 = 100.0;

impl Default for StabilityOptions {
    fn default() -> Self {
        Self { jams: Jams::None, width: DEFAULT_WIDTH }
    }
}

impl StabilityOptions {
    pub(crate) fn checked(&self) -> Result<Self, Error> {
        let holds = (0.0..=LARGEST_WIDTH).contains(&self.width);
        in_range("width", self.width, holds, "0 <= width <= 0.1")?;
        Ok(*self)
    }
}

/// What the arguments find.
enum Finding {
    Decided(Stability, Argument, Evidence),
    Undecided(Option<Evidence>),
}

impl Finding {
    fn decides(&self) -> bool {
        matches!(self, Self::Decided(..))
    }
}

/// Verdict on the stability of a posture.
///
/// This is not a certificate. Certificates are made and checked by the Python package and its command line: `standfast stability SCENE
/// --certificate FILE`, with a scene that [`Scene::save`](crate::Scene::save) has written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The contacts that touch. Words have a letter for each of them.
    pub contacts: Vec<ContactNumber>,
    /// The verdict.
    pub frictional_stability: Stability,
    /// What happens where a contact jams.
    #[serde(default)]
    pub after_jam: Jams,
    /// See [`StabilityOptions::width`].
    #[serde(default)]
    pub width: f64,
    /// The argument that decides; `None` if the verdict is undecided.
    pub by: Option<Argument>,
    /// Whether the contacts can hold the body.
    #[serde(flatten)]
    pub equilibrium: Equilibrium,
    /// The conditions in closed form: Theorem 3 and its margins. `None` unless exactly two contacts touch.
    #[serde(flatten)]
    pub conditions: Option<Conditions>,
    /// Whether λ = D⁻¹(g_1, g_2) > 0: every frictionless motion comes to rest on the contacts. `None` unless exactly two touch.
    pub energy: Option<bool>,
    /// Why every frictionless flight ends, if that is certain, on two contacts.
    pub flight: Option<FlightsEnd>,
    /// The well in which the body stands, if it does: see [`Well::radius`].
    pub well: Option<Well>,
    /// A speed, in m/s: after every kick (a velocity at rest in the posture) with √(ẋ² + ẏ² + ρ²θ̇²) below it the body comes back to rest in the full
    /// model, with [`laws`](Self::laws) of impact. All contacts then touch, or hover at less than a tenth of the size of the body. It is a lower bound, and proved.
    /// `None` unless the body stands in a [`Well`] or on level ground, on straight lines of ground of its contacts, which all have friction and are below the centre of mass, and no contact jams nearby.
    #[serde(default)]
    pub safe_speed: Option<f64>,
    /// Number of independent motions that no contact feels, of a mechanism with more than three coordinates that are not locked: after a kick
    /// they go on for ever, whatever the contacts do. A verdict on such a mechanism is about its contacts only.
    #[serde(default)]
    pub free_motion: usize,
    /// The laws of impact for which the verdict is proved.
    pub laws: Vec<Impact>,
    /// Whether the verdict is undecided only because of the width: with the numbers exactly as given it is decided.
    pub delicate: bool,
    /// Bound of the growth of a motion after a kick. The kick is a velocity given to the body at rest in its posture. In the local model
    /// ‖q̇‖ = √(ẋ² + ẏ² + ρ²θ̇²) of any later motion is at most this number times ‖q̇‖ of the kick. The bound is at least 1.
    #[serde(flatten, with = "bound_or_reason")]
    pub amplification: Result<f64, NoBound>,
    /// Results of random kicks, if requested: evidence, no proof; see [`trials`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trials: Option<Trials>,
    /// The argument's data, or why the corner map does not decide. `None` only for an undecided posture: several words are consistent at
    /// rest, or there is no corner map.
    pub evidence: Option<Evidence>,
    /// Every word at rest with its motion, forces and margins, for two contacts. Otherwise the consistent words, if they were needed.
    pub modes: Vec<ModeAnswer>,
}

/// The verdict with its argument, or its reason.
///
/// ```
/// use standfast::{Lamina, Posture, stability};
///
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// assert_eq!(stability(&rod)?.to_string(), "stable by theorem-3");
/// # Ok::<(), standfast::Error>(())
/// ```
impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.frictional_stability.as_str())?;
        match (self.by, self.reason()) {
            (Some(by), _) => write!(f, " by {}", by.as_str()),
            (None, Some(reason)) => write!(f, ", reason {}", reason.as_str()),
            (None, None) => Ok(()),
        }
    }
}

/// The verdict on a posture in its nominal configuration q = 0. Contacts in the air have no effect on small motions.
///
/// ```
/// use standfast::stability::{Argument, Stability};
/// use standfast::{Lamina, Posture, PostureFields, stability};
///
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// assert_eq!(stability(&rod)?.frictional_stability, Stability::Stable);
/// // With the centre of mass beside its feet it falls over.
/// let beside = Posture::new(PostureFields { center_of_mass: [0.6, 0.2], ..rod.fields().clone() })?;
/// assert_eq!(stability(&beside)?.by, Some(Argument::NotEquilibrium));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Unusable`] naming `contacts` if none touches, or if one that touches is at an end of its piece of terrain; [`Error::OutOfRange`] if
/// one that touches has restitution 1.
pub fn stability(posture: &Posture) -> Result<Verdict, Error> {
    stability_with(posture, &StabilityOptions::default())
}

/// As [`stability()`], with options.
///
/// # Errors
///
/// As [`stability()`], and [`Error::OutOfRange`] for a width that is out of its range.
pub fn stability_with(posture: &Posture, options: &StabilityOptions) -> Result<Verdict, Error> {
    judge(posture, options.checked()?, Details::ALL)
}

/// The verdicts on pairs of contacts that can hold the body alone, for a body on three and more contacts: one for each pair that the body
/// can keep closed while it opens all others. Each is the verdict on the body with these two contacts only.
///
/// ```
/// use std::f64::consts::FRAC_PI_2;
///
/// use standfast::stability::{StabilityOptions, holding_pairs};
/// use standfast::{Contact, Posture, PostureFields};
///
/// // Of a body in the corner of a room its feet on the floor can hold it alone.
/// let foot = |x| Contact { friction: 0.5, ..Contact::at(x, 0.0) };
/// let at_wall = Contact { friction: 0.5, ..Contact::at(0.6, 0.4).on_slope(FRAC_PI_2) };
/// let posture = Posture::new(PostureFields {
///     gyration_radius: 0.3,
///     center_of_mass: [0.0, 0.3],
///     contacts: vec![foot(-0.5), foot(0.5), at_wall],
///     ..PostureFields::default()
/// })?;
/// let pairs = holding_pairs(&posture, &StabilityOptions::default())?;
/// assert_eq!(pairs.len(), 1);
/// assert!(pairs[0].contacts.iter().map(|contact| contact.number()).eq([1, 2]));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`stability_with()`].
pub fn holding_pairs(posture: &Posture, options: &StabilityOptions) -> Result<Vec<Verdict>, Error> {
    let options = options.checked()?;
    let Some((standing, places)) = conditions::of_those_that_touch(posture)? else {
        dissipative(posture.geometry().iter().map(|k| k.restitution), LOSES)?;
        return feet::holding_pairs(posture, options);
    };
    let mut pairs = feet::holding_pairs(&standing, options)?;
    pairs.iter_mut().for_each(|pair| pair.renumber(&places));
    Ok(pairs)
}

/// What a verdict needs.
const LOSES: &str = "below 1 for a verdict: with 1 a body bounces for ever";

/// Fields of a verdict that may take most of the time, and are left out if no one asks for them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Details {
    pub(crate) amplification: bool,
    pub(crate) delicate: bool,
}

impl Details {
    pub(crate) const ALL: Self = Self { amplification: true, delicate: true };
    pub(crate) const NONE: Self = Self { amplification: false, delicate: false };
}

/// As [`stability_with`].
pub(crate) fn judge(
    posture: &Posture,
    options: StabilityOptions,
    details: Details,
) -> Result<Verdict, Error> {
    let touching = conditions::of_those_that_touch(posture)?;
    let standing = touching.as_ref().map_or(posture, |(standing, _)| standing);
    let mut verdict = judge_standing(standing, options, details)?;
    if details.amplification
        && verdict.frictional_stability == Stability::Stable
        && (verdict.by == Some(Argument::Well) || feet::is_level(standing, options))
    {
        let all = (0..posture.contacts().len()).collect();
        let places = touching.as_ref().map_or(&all, |(_, places)| places);
        verdict.safe_speed = barrier::safe_speed(posture, standing, places, options.width);
    }
    if let Some(Evidence::NoMotion(start)) = &mut verdict.evidence
        && details.delicate
    {
        start.jams = jams(standing, options.width)?;
    }
    if let Some((_, places)) = &touching {
        verdict.renumber(places);
    }
    Ok(verdict)
}

/// The verdict on a posture all of whose contacts touch.
fn judge_standing(
    posture: &Posture,
    options: StabilityOptions,
    details: Details,
) -> Result<Verdict, Error> {
    let mut verdict = judge_exactly_these(posture, options, details.amplification)?;
    // The enclosed rows of a mechanism are those of a body up to rounding errors, which only a width covers. Pairs are left out: certificates
    // do not decide all of them.
    if verdict.by.is_none()
        && options.width > 0.0
        && options.jams == Jams::None
        && verdict.equilibrium.margin > verdict.clear()
        && let Ok(mechanism) = Mechanism::of_posture(posture)
        && let Some(start) = no_motion(&mechanism, options.width)
        && start.contacts.len() == 1
    {
        let evidence = Evidence::NoMotion(start);
        verdict.take(Finding::Decided(Stability::Unstable, Argument::NoSolution, evidence));
    }
    if details.delicate && verdict.by.is_none() && options.width > 0.0 {
        let exact = StabilityOptions { width: 0.0, ..options };
        verdict.delicate = judge_exactly_these(posture, exact, false)?.by.is_some();
    }
    Ok(verdict)
}

/// The verdict on a posture all of whose contacts touch. Whether it is delicate is not decided yet.
fn judge_exactly_these(
    posture: &Posture,
    options: StabilityOptions,
    amplification: bool,
) -> Result<Verdict, Error> {
    dissipative(posture.geometry().iter().map(|k| k.restitution), LOSES)?;
    let count = posture.contacts().len();
    let mut verdict = Verdict::open(count, Equilibrium::of(posture), options);
    if count == 2 {
        verdict.decide_pair(posture, &[], amplification)?;
    } else {
        verdict.decide_feet(posture)?;
    }
    if verdict.frictional_stability == Stability::Stable
        && matches!(verdict.by, Some(Argument::Well | Argument::Neutral))
    {
        // E never rises, and gravity's part of it is not negative.
        verdict.amplification = Ok(1.0);
        verdict.laws = feet::laws(posture);
    }
    Ok(verdict)
}

/// The verdict on a posture of two contacts that carry others between them, at these places.
fn judge_carrying(
    pair: &Posture,
    between: &[Interval],
    options: StabilityOptions,
) -> Result<Verdict, Error> {
    let mut verdict = Verdict::open(2, Equilibrium::of(pair), options);
    verdict.decide_pair(pair, between, false)?;
    Ok(verdict)
}

/// Serde for the bound on the amplification: `amplification`, or null with the reason in `amplification_reason`.
mod bound_or_reason {
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

    use super::NoBound;

    #[derive(Serialize, Deserialize)]
    struct BoundFields {
        amplification: Option<f64>,
        amplification_reason: Option<NoBound>,
    }

    pub(super) fn serialize<S: Serializer>(
        bound: &Result<f64, NoBound>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        BoundFields { amplification: bound.ok(), amplification_reason: bound.err() }
            .serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Result<f64, NoBound>, D::Error> {
        let BoundFields { amplification, amplification_reason } =
            BoundFields::deserialize(deserializer)?;
        match (amplification, amplification_reason) {
            (Some(bound), None) => Ok(Ok(bound)),
            (None, Some(reason)) => Ok(Err(reason)),
            _ => Err(D::Error::custom("amplification or amplification_reason has to be null")),
        }
    }
}

impl Verdict {
    /// Nothing is decided yet about this number of contacts.
    fn open(count: usize, equilibrium: Equilibrium, options: StabilityOptions) -> Self {
        Self {
            contacts: (0..count).map(ContactNumber::of).collect(),
            equilibrium,
            conditions: None,
            energy: None,
            flight: None,
            well: None,
            safe_speed: None,
            free_motion: 0,
            laws: vec![Impact::Newton],
            after_jam: options.jams,
            width: options.width,
            frictional_stability: Stability::Undecided,
            by: None,
            evidence: None,
            delicate: false,
            amplification: Err(NoBound::NotStable),
            trials: None,
            modes: Vec::new(),
        }
    }

    /// The verdict as JSON; infinities as the strings "inf" and "-inf", undefined numbers as null.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self)
            .unwrap_or_else(|e| unreachable!("a verdict is JSON: {e}"))
    }

    /// Writes [`to_json`](Self::to_json) to a file, complete or not at all.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be written.
    pub fn save(&self, path: impl AsRef<std::path::Path>) -> Result<(), Error> {
        crate::file::write::write_whole(path.as_ref(), self.to_json().as_bytes())
    }

    /// Why it is undecided; `None` if it is decided.
    #[must_use]
    pub fn reason(&self) -> Option<WhyUndecided> {
        match (&self.evidence, self.by) {
            (_, Some(_)) => None,
            (Some(Evidence::Left { reason, .. }), _) => Some(*reason),
            _ if self.conditions.is_some_and(|found| !found.unambiguous) => {
                Some(WhyUndecided::Ambiguous)
            }
            _ => Some(WhyUndecided::Degenerate),
        }
    }

    /// The argument that decides, or why the verdict is undecided, in words.
    #[must_use]
    pub fn in_words(&self) -> &'static str {
        let reason = || self.reason().map_or("", WhyUndecided::in_words);
        self.by.map_or_else(reason, Argument::in_words)
    }

    /// The evidence as JSON. This is not a certificate: see [`Verdict`].
    #[must_use]
    pub fn evidence_json(&self) -> String {
        serde_json::to_string(&self.evidence).unwrap_or_else(|e| unreachable!("it is JSON: {e}"))
    }

    /// Renumbers the contacts with their places in the list of contacts of the posture.
    fn renumber(&mut self, places: &[usize]) {
        let rename =
            |number: &mut ContactNumber| *number = ContactNumber::of(places[number.index()]);
        self.contacts.iter_mut().for_each(rename);
        if let Some(evidence) = &mut self.evidence {
            evidence.renumber(&rename);
        }
    }

    fn take(&mut self, found: Finding) {
        match found {
            Finding::Decided(stability, by, evidence) => {
                (self.frictional_stability, self.by) = (stability, Some(by));
                self.evidence = Some(evidence);
            }
            Finding::Undecided(evidence) => self.evidence = evidence,
        }
    }

    fn not_in_equilibrium(&self) -> Finding {
        let evidence = Evidence::Region { equilibrium_margin: self.equilibrium.margin };
        Finding::Decided(Stability::Unstable, Argument::NotEquilibrium, evidence)
    }

    fn options(&self) -> StabilityOptions {
        StabilityOptions { jams: self.after_jam, width: self.width }
    }

    /// The margin beyond which a closed form is certain for all scenes within the width.
    fn clear(&self) -> f64 {
        DELICATE_MARGIN.max(CONDITION * self.width)
    }

    /// The verdict on one contact, or on three and more.
    fn decide_feet(&mut self, posture: &Posture) -> Result<(), Error> {
        let margin = self.equilibrium.margin / posture.size();
        let found = if let [contact] = posture.contacts()
            && margin >= -self.clear()
            && !rocks(posture, contact)
        {
            single_support(posture, contact)
        } else if self.width > 0.0 && margin.abs() <= self.clear() {
            undecided(WhyUndecided::Boundary)
        } else if self.equilibrium.holds {
            let leaves = |answer: &&ModeAnswer| {
                answer.consistent && moves(answer.word) && !answer.near_degenerate()
            };
            let (options, closed) = (self.options(), self.uses_closed_forms());
            let consistent = |posture: &Posture| -> Result<Vec<ModeAnswer>, Error> {
                let problem =
                    ContactProblem::of_posture(posture, &State::at_rest([0.0; 3]), [0.0; 3])?;
                let answers = contact_modes(&problem, Method::Auto)?;
                Ok(answers.answers().iter().filter(|a| a.consistent).cloned().collect())
            };
            let moving = |modes: &[ModeAnswer]| {
                modes.iter().find(leaves).filter(|_| closed).map(|answer| answer.word)
            };
            let neutral = feet::neutral(posture, options);
            let carried = if neutral.is_none() { Carried::of(posture, self.width) } else { None };
            match (neutral, carried) {
                (Some(found), _) => found,
                (None, Some(carried)) => {
                    let others = with_contacts(posture, &carried.others)?;
                    let moves = || Ok(moving(&consistent(&others)?));
                    let (found, well) = feet::decide(&others, Some(&carried), options, moves)?;
                    self.well = well;
                    carried.put_back(found)
                }
                (None, None) => {
                    let modes = &mut self.modes;
                    let (found, well) = feet::decide(posture, None, options, || {
                        *modes = consistent(posture)?;
                        Ok(moving(modes))
                    })?;
                    self.well = well;
                    found
                }
            }
        } else {
            self.not_in_equilibrium()
        };
        self.take(found);
        if self.by == Some(Argument::DescendingPair)
            && self.frictional_stability == Stability::Stable
        {
            self.amplification = Err(NoBound::Pairs);
        }
        Ok(())
    }

    /// `between`: see [`Local::between`].
    fn decide_pair(
        &mut self,
        posture: &Posture,
        between: &[Interval],
        amplification: bool,
    ) -> Result<(), Error> {
        let problem = ContactProblem::of_posture(posture, &State::at_rest([0.0; 3]), [0.0; 3])?;
        self.modes = contact_modes(&problem, Method::Auto)?.answers().to_vec();
        let equilibrium = self.equilibrium.holds;
        let found = conditions::of_words(&Pair::of(posture)?, equilibrium, &self.modes);
        let local = Local::new(posture, self.width).map(|local| local.carrying(between));
        let holds = self.holds(local.as_ref(), self.equilibrium.margin / posture.size());
        let map = local.filter(|_| holds == Ok(true)).map(|l| CornerMap::of(l, self.after_jam));
        let neutral = || feet::neutral(posture, self.options());
        let standing = Standing::Body(posture);
        let decided = self.judge_pair(found, map.as_ref(), holds, standing, neutral);
        self.take_pair(decided, found, map.as_ref(), amplification);
        Ok(())
    }

    /// Whether two contacts hold the body in all scenes within the width, or why this is not certain. `margin`: of the equilibrium, dimensionless.
    fn holds(&self, local: Option<&Local>, margin: f64) -> Result<bool, WhyUndecided> {
        if self.width == 0.0 {
            return Ok(self.equilibrium.holds);
        }
        let clear = margin.abs() > self.clear();
        let closed = (clear && self.uses_closed_forms()).then_some(self.equilibrium.holds);
        let why = if clear { WhyUndecided::Degenerate } else { WhyUndecided::Boundary };
        local.and_then(Local::holds).or(closed).ok_or(why)
    }

    /// Returns true if closed forms in doubles count, with a clear margin. With a larger width only tests in intervals do.
    fn uses_closed_forms(&self) -> bool {
        self.width <= DEFAULT_WIDTH
    }

    /// The finding for two contacts. `holds`: see [`Verdict::holds`].
    fn judge_pair(
        &self,
        found: Conditions,
        map: Option<&CornerMap>,
        holds: Result<bool, WhyUndecided>,
        standing: Standing<'_>,
        neutral: impl FnOnce() -> Option<Finding>,
    ) -> Finding {
        let strongly = |by, coupling_margin| {
            let kinematic_margin = found.kinematic_margin;
            let evidence = Evidence::Margins { kinematic_margin, coupling_margin };
            Finding::Decided(Stability::Stable, by, evidence)
        };
        // If the direction in which both contacts slide does not move one of them, words with a fixed contact are motions,
        // too. And when both contacts slide, exactly one word must be consistent.
        // A bound on the coupling is one for two contacts alone.
        let known = map.is_some_and(|map| map.slides_known() && map.local().between.is_empty());
        let strong = known && self.uses_closed_forms() && found.certainly_strong();
        let clear = |margin: f64| self.width == 0.0 || margin > self.clear();
        let clatters = found.clattering && clear(found.clattering_margin);
        if let Err(reason) = holds {
            undecided(reason)
        } else if holds == Ok(false) {
            self.not_in_equilibrium()
        } else if clatters && strong && found.kinematic_strong_strict {
            strongly(Argument::Theorem3, found.clattering_margin)
        } else if clatters && strong {
            strongly(Argument::Theorem3Loose, found.clattering_margin)
        } else if found.chatter && clear(found.chatter_margin) && strong {
            strongly(Argument::Goyal, found.chatter_margin)
        } else if let Some(neutral) = neutral() {
            neutral
        } else {
            self.apply_sharper_tests(found, map, standing)
        }
    }

    /// Takes over the finding for two contacts.
    fn take_pair(
        &mut self,
        decided: Finding,
        found: Conditions,
        map: Option<&CornerMap>,
        amplification: bool,
    ) {
        self.conditions = Some(found);
        self.flight = map.and_then(|map| map.local().flights_end());
        self.energy = Some(self.flight == Some(FlightsEnd::Energy));
        self.take(decided);
        if amplification && self.frictional_stability == Stability::Stable {
            self.amplification = map.map_or(Err(NoBound::Modes), amplification::bound);
        }
    }

    fn apply_sharper_tests(
        &self,
        conditions: Conditions,
        map: Option<&CornerMap>,
        standing: Standing<'_>,
    ) -> Finding {
        let (stable, unstable) = (Stability::Stable, Stability::Unstable);
        let leaves = |answer: &&ModeAnswer| {
            let clear = self.width == 0.0 || !answer.near_degenerate();
            self.uses_closed_forms() && answer.consistent && moves(answer.word) && clear
        };
        if let Some(answer) = self.modes.iter().find(leaves) {
            let word = Evidence::Word(answer.word);
            return Finding::Decided(unstable, Argument::AcceleratingMode, word);
        }
        let Some(map) = map else { return Finding::Undecided(None) };
        let lacks =
            if self.after_jam == Jams::None { existence::no_motion(map, standing) } else { None };
        let open = |left| match lacks.clone() {
            Some(start) => {
                Finding::Decided(unstable, Argument::NoSolution, Evidence::NoMotion(start))
            }
            None => Finding::Undecided(left),
        };
        if !conditions.unambiguous && self.uses_closed_forms() {
            return open(None);
        }
        let step = |corner: &certify::Corner| {
            let alpha = map.local().alpha[1 - corner.contact].middle();
            CornerStep {
                contact: ContactNumber::of(corner.contact),
                phi: libm::atan(alpha * libm::tan(corner.phi)).unsigned_zero(),
                growth: corner.growth.unsigned_zero(),
            }
        };
        let decision = match certify::decide(map) {
            Decision::Undecided { reason, cells, left } => {
                // Flights that end in a self-similar cycle of impacts are better followed.
                let undecided = Decision::Undecided { reason, cells, left };
                let followed = map.followed().map(|map| certify::decide(&map));
                let decided = followed.filter(|found| !matches!(found, Decision::Undecided { .. }));
                decided.unwrap_or(undecided)
            }
            decided => decided,
        };
        match decision {
            Decision::Stable(potential) => {
                Finding::Decided(stable, Argument::CornerMap, Evidence::Potential(potential))
            }
            Decision::Grows(cycle) => {
                let cycle = rescaled(cycle.iter().map(step).collect(), map);
                Finding::Decided(unstable, Argument::GrowingCycle, Evidence::Cycle(cycle))
            }
            Decision::Trap(trap) => {
                let range = |cell: &TrapCell| TrapRange {
                    contact: ContactNumber::of(cell.contact),
                    slope: cell.phi.map(|phi| {
                        let half = std::f64::consts::FRAC_PI_2;
                        if phi.abs() < half { libm::tan(phi) } else { f64::INFINITY.copysign(phi) }
                    }),
                    weight: cell.weight,
                    growth: cell.growth,
                };
                let ranges = trap.iter().map(range).collect();
                Finding::Decided(unstable, Argument::GrowingTrap, Evidence::Trap(ranges))
            }
            Decision::Escapes(corner) => Finding::Decided(
                unstable,
                Argument::AcceleratingMode,
                Evidence::Away(step(&corner)),
            ),
            Decision::Leaves(away) => match motion(away, map, standing) {
                Some(motion) => Finding::Decided(unstable, Argument::AcceleratingMode, motion),
                None => Finding::Undecided(None),
            },
            Decision::Undecided { reason, cells, left } => {
                let number = |(contact, phi)| (ContactNumber::of(contact), phi);
                let left = left.into_iter().map(number).collect();
                open(Some(Evidence::Left { reason, cells, left }))
            }
        }
    }
}

impl Evidence {
    /// Applies `rename` to the number of each contact.
    fn renumber(&mut self, rename: &impl Fn(&mut ContactNumber)) {
        let of_rays = |rays: &mut Vec<Ray>| {
            rays.iter_mut().flat_map(|ray| &mut ray.contacts).for_each(rename);
        };
        match self {
            Self::Cycle(cycle) => cycle.iter_mut().for_each(|corner| rename(&mut corner.contact)),
            Self::Trap(ranges) => ranges.iter_mut().for_each(|range| rename(&mut range.contact)),
            Self::Away(corner) => rename(&mut corner.contact),
            Self::NoMotion(start) => {
                start.contacts.iter_mut().for_each(rename);
                start.jams.iter_mut().flat_map(|jam| &mut jam.contacts).for_each(rename);
            }
            Self::Left { left, .. } => left.iter_mut().for_each(|(contact, _)| rename(contact)),
            Self::Well { rays, .. } => of_rays(rays),
            Self::DescendingPairs { rays, pairs } => {
                of_rays(rays);
                for pair in pairs {
                    pair.contacts.iter_mut().for_each(rename);
                    if let Some(evidence) = &mut pair.evidence {
                        evidence.renumber(rename);
                    }
                }
            }
            Self::Neutral { outer, .. } => outer.iter_mut().for_each(rename),
            Self::Region { .. }
            | Self::Shrinks { .. }
            | Self::PotentialWell { .. }
            | Self::Margins { .. }
            | Self::Potential(_)
            | Self::Word(_)
            | Self::Motion { .. } => {}
        }
    }
}

/// Returns true if a body on one contact may rock about it: its centre of mass is below the centre of a disc, or below a point that it hangs from.
fn rocks(posture: &Posture, contact: &Contact) -> bool {
    let center = contact.point[1] + contact.radius * libm::cos(contact.slope);
    posture.fields().center_of_mass[1] < center
}

/// A body on one contact, straight under its centre of mass. From any turn about the contact, however slow, it does not come back: its speed stays
/// the same to first order.
fn single_support(posture: &Posture, contact: &Contact) -> Finding {
    let center = posture.fields().center_of_mass;
    let arm = [0, 1].map(|k| contact.point[k] - center[k]);
    let velocity = vec![arm[1], -arm[0], 1.0].unsigned_zero();
    let word = Word::separate(1).with(0, Mode::Fixed);
    let motion = Evidence::Motion { word, velocity };
    Finding::Decided(Stability::Unstable, Argument::SingleSupport, motion)
}

/// Nothing is decided, without cells.
fn undecided(reason: WhyUndecided) -> Finding {
    Finding::Undecided(Some(Evidence::Left { reason, cells: 0, left: Vec::new() }))
}

/// The word of a motion with contacts on the terrain, and the velocity with which it starts.
fn motion(away: Away, map: &CornerMap, standing: Standing<'_>) -> Option<Evidence> {
    // Contact k slides with this sign of ξ, the other one leaves the terrain with this speed.
    let (k, side, lift) = match away {
        Away::Alone(k, side) => (k, side, 1.0),
        Away::Together(side) => (0, side, 0.0),
        Away::Lifts(k, side) => (k, side, 0.0),
    };
    let slip = |i: usize| f64::from(side) * map.local().alpha[i].middle().signum();
    let letter = |i: usize| match away {
        Away::Alone(k, _) | Away::Lifts(k, _) if i != k => Mode::Separate,
        _ if side == 0 => Mode::Fixed,
        _ if slip(i) > 0.0 => Mode::Right,
        _ => Mode::Left,
    };
    let slip = if side == 0 { 0.0 } else { slip(k) };
    let velocity = standing.solve(k, 1 - k, [0.0, slip, lift])?;
    let word = Word::separate(2).with(0, letter(0)).with(1, letter(1));
    Some(Evidence::Motion { word, velocity })
}

/// Converts the growths of a cycle from ξ² + y² to r² = v_t² + y². Their sum over the cycle is the same.
fn rescaled(mut cycle: Vec<CornerStep>, map: &CornerMap) -> Vec<CornerStep> {
    // Logarithm of the ratio of new to old r at each corner.
    let ratio = |corner: &CornerStep| {
        let alpha = map.local().alpha[1 - corner.contact.index()].middle();
        let t = libm::tan(corner.phi);
        0.5 * (libm::log1p(t * t) - libm::log1p((t / alpha) * (t / alpha)))
    };
    let ratios: Vec<f64> = cycle.iter().map(ratio).collect();
    let n = cycle.len();
    for (k, corner) in cycle.iter_mut().enumerate() {
        corner.growth += ratios[(k + 1) % n] - ratios[k];
    }
    cycle
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::fields::PostureFields;

    /// Kinematic-strong, but unstable at e = 0.26; stable at e = 0.05.
    pub(super) fn odd(restitution: f64) -> Posture {
        let contact =
            |x, y, slope: f64| Contact { friction: 0.89, ..Contact::at(x, y).on_slope(slope) };
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.38,
            center_of_mass: [0.58, 0.95],
            contacts: vec![contact(-1.0, 0.0, -0.31), contact(1.0, 0.25, 1.16)],
            restitution,
            gravity: 1.0,
            ..PostureFields::default()
        })
        .unwrap()
    }

    #[test]
    fn a_growing_cycle_is_enclosed() {
        let verdict = stability(&odd(0.26)).unwrap();
        assert!(verdict.conditions.unwrap().kinematic_strong);
        assert_eq!(verdict.by, Some(Argument::GrowingCycle), "{:?}", verdict.evidence);
        let Some(Evidence::Cycle(cycle)) = &verdict.evidence else { panic!() };
        let total: f64 = cycle.iter().map(|corner| corner.growth).sum();
        assert!((total - 0.744834).abs() < 2e-6, "{cycle:?}");
        let verdict = stability(&odd(0.05)).unwrap();
        assert_eq!(verdict.frictional_stability, Stability::Stable, "{verdict:?}");
    }
}
