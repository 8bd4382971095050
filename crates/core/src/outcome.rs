//! Results of a run: how it ends, its impacts, Zeno points and phases.

use std::cmp::Ordering;
use std::fmt;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::body::posture::MAX_CONTACTS;
use crate::body::state::State;
use crate::error::Error;
use crate::serial::{shown_as_str, shown_as_written};

shown_as_str!(Outcome, ZenoMethod, Cause, ModelReason, Uncertain);
shown_as_written!(ContactKind);

/// The number of a contact, counted from 1 as in the paper; [`index`](Self::index) counts from 0. `Debug`, `Display` and serde
/// all give the number from 1.
///
/// ```
/// use standfast::{Lamina, Options, Posture, State, simulate};
///
/// // A rod falls on its left end first.
/// let rod = Posture::rod(0.5, &Lamina::default())?;
/// let run = simulate(&rod, &State::at_rest([0.0, 0.2, 0.1]), &Options::default())?;
/// let hit = run.impacts()[0].contact;
/// assert_eq!((hit.number(), hit.index(), hit.to_string()), (1, 0, "1".into()));
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ContactNumber(usize);

impl ContactNumber {
    pub(crate) const fn of(index: usize) -> Self {
        Self(index)
    }

    /// From 0.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }

    /// From 1.
    #[must_use]
    pub fn number(self) -> usize {
        self.0 + 1
    }
}

/// From the number of a contact, counted from 1.
impl TryFrom<usize> for ContactNumber {
    type Error = Error;

    fn try_from(number: usize) -> Result<Self, Error> {
        number.checked_sub(1).map(Self).ok_or_else(|| Error::Unusable {
            field: "contact".into(),
            value: number.to_string(),
            allowed: "a number from 1 on".into(),
        })
    }
}

/// A set of contacts of one run, written `{1, 3}`.
///
/// ```
/// use standfast::{Lamina, Options, Posture, State, simulate};
///
/// // A box falls flat: it rests on its lower corners.
/// let block = Posture::block(1.0, 0.5, &Lamina::default())?;
/// let run = simulate(&block, &State::at_rest([0.0, 0.1, 0.0]), &Options::default())?;
/// let touching = run.touching();
/// assert_eq!((touching.to_string(), touching.len()), ("{1, 2}".into(), 2));
/// assert!(touching.contains(2.try_into()?) && !touching.contains(3.try_into()?));
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ContactSet(u128);

/// The contacts of a [`ContactSet`], in order.
#[derive(Debug, Clone)]
pub struct ContactSetIter(u128);

/// Contacts of a run that a set can hold: those of the body, and as many sides on corners of the ground.
const MOST_CONTACTS: usize = 2 * MAX_CONTACTS;

// Each contact has a bit.
const _: () = assert!(MOST_CONTACTS <= u128::BITS as usize);

impl ContactSet {
    /// The contacts with gap zero: where a contact touches, the motion keeps its gap at exactly zero.
    pub(crate) fn of_gaps(gaps: &[f64]) -> Self {
        let bits = gaps.iter().enumerate().map(|(i, gap)| u128::from(*gap == 0.0) << i);
        Self(bits.fold(0, |set, bit| set | bit))
    }

    /// The same with these contacts, counted from 0. A run with more than [`MOST_CONTACTS`] has the first ones only.
    pub(crate) fn with(self, contacts: impl IntoIterator<Item = usize>) -> Self {
        let known = contacts.into_iter().filter(|&i| i < MOST_CONTACTS);
        Self(known.fold(self.0, |set, i| set | 1 << i))
    }

    /// Its contacts, in order.
    #[must_use]
    pub fn iter(self) -> ContactSetIter {
        ContactSetIter(self.0)
    }

    /// Returns true if it has this contact.
    #[must_use]
    pub fn contains(self, contact: ContactNumber) -> bool {
        contact.0 < MOST_CONTACTS && self.0 >> contact.0 & 1 == 1
    }

    /// Number of its contacts.
    #[must_use]
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Returns true if it has no contacts.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl Iterator for ContactSetIter {
    type Item = ContactNumber;

    fn next(&mut self) -> Option<ContactNumber> {
        let index = (self.0 != 0).then(|| self.0.trailing_zeros())?;
        self.0 &= self.0 - 1;
        Some(ContactNumber(index as usize))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let count = self.0.count_ones() as usize;
        (count, Some(count))
    }
}

impl ExactSizeIterator for ContactSetIter {}

impl IntoIterator for ContactSet {
    type Item = ContactNumber;
    type IntoIter = ContactSetIter;

    fn into_iter(self) -> ContactSetIter {
        self.iter()
    }
}

impl fmt::Debug for ContactSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

impl fmt::Display for ContactSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl fmt::Display for ContactNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.number().fmt(f)
    }
}

impl fmt::Debug for ContactNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Serialize for ContactNumber {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.number().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ContactNumber {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let index = usize::deserialize(deserializer)?.checked_sub(1);
        index.map(Self).ok_or_else(|| D::Error::custom("contacts are numbered from 1"))
    }
}

/// How a run ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Outcome {
    /// All motion has ceased.
    Rest,
    /// The run ended at the first Zeno point, as its options ask.
    Zeno,
    /// The body moves away for ever, or its centre of mass has moved farther than the option `neighbourhood`.
    Escape,
    /// The body slides on its contacts without end; or the contacts of a mechanism rest, and coordinates that they do not feel move on for ever.
    Sliding,
    /// No contact mode is consistent: no motion with bounded forces obeys Coulomb's law (Painlevé).
    Inconsistent,
    /// Several contact modes are consistent: Coulomb's law does not determine the motion.
    Ambiguous,
    /// The run reached the time limit.
    TimeLimit,
    /// The run reached the event limit.
    EventLimit,
    /// A small change of the start had grown by more than the option `sensitivity_limit`.
    SensitivityLimit,
}

impl Outcome {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Rest,
        Self::Zeno,
        Self::Escape,
        Self::Sliding,
        Self::Inconsistent,
        Self::Ambiguous,
        Self::TimeLimit,
        Self::EventLimit,
        Self::SensitivityLimit,
    ];

    /// The name of the outcome in files.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Zeno => "zeno",
            Self::Escape => "escape",
            Self::Sliding => "sliding",
            Self::Inconsistent => "inconsistent",
            Self::Ambiguous => "ambiguous",
            Self::TimeLimit => "time-limit",
            Self::EventLimit => "event-limit",
            Self::SensitivityLimit => "sensitivity-limit",
        }
    }
}

/// By name.
impl Ord for Outcome {
    fn cmp(&self, other: &Self) -> Ordering {
        self.as_str().cmp(other.as_str())
    }
}

impl PartialOrd for Outcome {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Why a run has its [`model`](crate::Trajectory::model). Serde writes it as the sentence of [`as_str`](Self::as_str).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(into = "&'static str")]
#[non_exhaustive]
pub enum ModelReason {
    /// The option `model` sets it.
    Set,
    /// The run is one of a local model that is given by its parameters.
    Given,
    /// Local: a mechanism is given by its rows in one posture.
    Mechanism,
    /// Local: exact, because the body does not turn.
    Exact,
    /// Full: the body may turn.
    Turns,
    /// Full: the body is kicked or the ground moves.
    Excited,
    /// Full: not each contact is on a straight line without ends.
    Ground,
}

impl ModelReason {
    /// The reason as a sentence.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Set => "set by the option",
            Self::Given => "given by its parameters",
            Self::Mechanism => "a mechanism is given by its rows in one posture",
            Self::Exact => "exact here: the body does not turn",
            Self::Turns => "the body may turn",
            Self::Excited => "the body is kicked or the ground moves",
            Self::Ground => "the ground is not a straight line without ends for each contact",
        }
    }
}

impl From<ModelReason> for &'static str {
    fn from(reason: ModelReason) -> Self {
        reason.as_str()
    }
}

/// One collision that was simulated by itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ImpactRecord {
    /// Time on the clock, in s.
    pub time: f64,
    /// Time since the start, in s.
    pub elapsed: f64,
    /// The contact that is hit.
    pub contact: ContactNumber,
    /// Gap rates before, of the contacts of the posture, in m/s; a side of the body has no gap.
    pub rates_before: Vec<f64>,
    /// Gap rates after, of the contacts of the posture, in m/s.
    pub rates_after: Vec<f64>,
    /// Impulse (tangential, normal), in N s; NaN for a model without a mass.
    pub impulse: [f64; 2],
}

/// A point in time at which contacts come to rest: where infinitely many impacts accumulate, in an impact without rebound
/// ([`ZenoPoint::plastic`]), or because they rest from the start ([`ZenoMethod::Rest`]).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ZenoPoint {
    /// How many contacts come to rest.
    pub kind: ZenoKind,
    /// The contacts that come to rest.
    pub contacts: Vec<ContactNumber>,
    /// Time on the clock, in s.
    pub time: f64,
    /// Time since the start, in s.
    pub elapsed: f64,
    /// Estimated error of `elapsed`, in s, from the sum of the tail, from the rounding of the clock and, if the run is recorded, from what
    /// rounding errors have grown to until then, see [`Trajectory::time_error`](crate::Trajectory::time_error). It does not include the error of
    /// the local model.
    pub time_error: f64,
    /// Configuration there: (r_x, r_y, θ) of a body in m, m, rad, or the coordinates of a mechanism; `None` for a model without a body.
    pub q: Option<Vec<f64>>,
    /// Velocity there.
    pub qdot: Option<Vec<f64>>,
    /// Rotation θ (rad) and angular velocity ω (rad/s) there.
    pub rotation: [f64; 2],
    /// Gaps there, of the contacts of the posture, in m; a side of the body has no gap.
    pub gaps: Vec<f64>,
    /// Gap rates there, of the contacts of the posture, in m/s.
    pub gap_rates: Vec<f64>,
    /// Whether the sum is proved (except for rounding errors) and not estimated.
    pub certified: bool,
    /// How the impacts were summed.
    pub method: ZenoMethod,
    /// Whether these contacts, all of restitution 0, come to rest in one impact without rebound, so that no impacts accumulate. The method
    /// is then [`ZenoMethod::Bounce`], or [`ZenoMethod::Mixed`] if there are several contacts.
    pub plastic: bool,
    /// Index of the first collision that was summed instead of simulated.
    pub first_summed: usize,
}

impl ZenoPoint {
    /// Returns true if infinitely many impacts end at this point. They do not where contacts rest from the start or land without rebound.
    #[must_use]
    pub fn is_infinite(&self) -> bool {
        self.method != ZenoMethod::Rest && !self.plastic
    }
}

/// The argument by which a Zeno point was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ZenoMethod {
    /// The bounces of one contact are a geometric series; or contacts land without rebound.
    Bounce,
    /// Impacts of two contacts in turn: a sum in closed form.
    Clatter,
    /// Infinitely many impacts of two contacts in one instant.
    Chatter,
    /// The contacts rest from the start.
    Rest,
    /// Impacts that repeat on a smaller and smaller scale, followed until the rest is below the rounding error of the time; or a regular motion
    /// towards e = 1 near to such a one, whose time is summed.
    SelfSimilar,
    /// Other impacts that are followed so far, or several sums.
    Mixed,
    /// An accumulation of accumulations.
    Nested,
}

impl ZenoMethod {
    /// Its name in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Bounce => "bounce",
            Self::Clatter => "clatter",
            Self::Chatter => "chatter",
            Self::Rest => "rest",
            Self::SelfSimilar => "self-similar",
            Self::Mixed => "mixed",
            Self::Nested => "nested",
        }
    }
}

/// The number of contacts that come to rest, written "1-zeno", "2-zeno", ….
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ZenoKind(pub usize);

impl fmt::Display for ZenoKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-zeno", self.0)
    }
}

impl Serialize for ZenoKind {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A period of time with one contact mode. An impact after which the mode is the same again does not end the phase: a body that bounces is
/// in one phase S.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Phase {
    /// One letter a contact: S separate, F fixed, R or L sliding right or left (at the start of the phase).
    pub mode: String,
    /// On the clock, in s.
    pub start: f64,
    /// On the clock, in s.
    pub end: f64,
    /// The event at its start.
    pub cause: Cause,
    /// Number of [`Trajectory::impacts`](crate::Trajectory::impacts) strictly between the start and the end of the phase. The infinitely
    /// many impacts that are summed to a Zeno point are not counted.
    pub impacts: usize,
}

/// What touches the ground at a contact of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ContactKind {
    /// A point of the body, one of the contacts of its posture.
    Corner,
    /// A disc about a point of the body, one of the contacts of its posture.
    Round,
    /// A side of the outline of the body, on a corner of the ground.
    Side,
}

/// A contact of a run: those of the posture, then the sides of the body that corners of the ground have touched, in the order of their first
/// touches, each with the sides beside it at concave corners of the body, which may not have been touched.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RunContact {
    /// Its number in the run.
    pub number: ContactNumber,
    /// What touches.
    pub kind: ContactKind,
    /// Index, from 0, of the contact of the posture, or of the side of its outline: side k goes from corner k to the next one.
    pub index: usize,
    /// The corner of the ground on the side, world axes, in m.
    pub corner: Option<[f64; 2]>,
    /// Unit vector along the side in the nominal posture, with the body on its left.
    pub along: Option<[f64; 2]>,
    /// Coefficient of friction; of a side, the smallest one of the contacts at its ends, or of all contacts if none is there.
    pub friction: f64,
}

/// Why a phase begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Cause {
    /// The run starts.
    Start,
    /// A collision of this contact, or several.
    Impact(ContactNumber),
    /// Contacts have come to rest: see the Zeno points.
    Zeno,
    /// The normal force of this contact has decreased to zero.
    LiftOff(ContactNumber),
    /// This contact has stopped sliding.
    Stop(ContactNumber),
    /// The force of this contact has reached the edge of its friction cone: it begins to slide.
    Slip(ContactNumber),
    /// This contact has reached the end of a piece of its terrain.
    LeftSegment(ContactNumber),
    /// A kick of the body.
    Kick,
    /// The acceleration or the tilt of the ground has changed.
    GroundMotion,
}

impl Cause {
    /// The name of the cause in files.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::Impact(_) => "impact",
            Self::Zeno => "zeno",
            Self::LiftOff(_) => "lift-off",
            Self::Stop(_) => "stop",
            Self::Slip(_) => "slip",
            Self::LeftSegment(_) => "left-segment",
            Self::Kick => "kick",
            Self::GroundMotion => "ground-motion",
        }
    }

    /// The same with the numbers, from 0, that `of` gives contacts.
    pub(crate) fn renumbered(self, of: impl Fn(usize) -> usize) -> Self {
        let of = |contact: ContactNumber| ContactNumber(of(contact.0));
        match self {
            Self::Start | Self::Zeno | Self::Kick | Self::GroundMotion => self,
            Self::Impact(contact) => Self::Impact(of(contact)),
            Self::LiftOff(contact) => Self::LiftOff(of(contact)),
            Self::Stop(contact) => Self::Stop(of(contact)),
            Self::Slip(contact) => Self::Slip(of(contact)),
            Self::LeftSegment(contact) => Self::LeftSegment(of(contact)),
        }
    }

    /// The contact of the event, if there is exactly one.
    #[must_use]
    pub fn contact(self) -> Option<ContactNumber> {
        match self {
            Self::Start | Self::Zeno | Self::Kick | Self::GroundMotion => None,
            Self::Impact(contact)
            | Self::LiftOff(contact)
            | Self::Stop(contact)
            | Self::Slip(contact)
            | Self::LeftSegment(contact) => Some(contact),
        }
    }
}

impl Serialize for Cause {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.as_str().serialize(serializer)
    }
}

/// The motion at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Instant {
    /// q and q̇; without a body only θ and ω are defined.
    pub state: State,
    /// Gaps of the contacts of the posture, in m; a side of the body has no gap.
    pub gaps: Vec<f64>,
    /// Gap rates of the contacts of the posture, in m/s.
    pub rates: Vec<f64>,
}

/// The end of one of many runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// How it ended.
    pub outcome: Outcome,
    /// Time on the clock when the outcome was reached, in s.
    pub time: f64,
    /// Time from the start to the outcome, in s. It has more digits than the difference of the clock times.
    pub elapsed: f64,
    /// Final state.
    pub state: State,
    /// The contacts that touch the ground in it.
    pub touching: ContactSet,
    /// The first Zeno point.
    pub zeno: Option<FirstZeno>,
    /// Number of collisions simulated one by one.
    pub collisions: usize,
    /// Whether the run has warnings; [`simulate`](crate::simulate()) returns their text.
    pub warned: bool,
}

/// The first Zeno point of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstZeno {
    /// How many contacts come to rest.
    pub count: usize,
    /// The contact that comes to rest, if it is only one.
    pub contact: Option<ContactNumber>,
    /// Time on the clock, in s.
    pub time: f64,
    /// Time since the start, in s.
    pub elapsed: f64,
}

/// An interval of time, in s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bounds {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Bounds {
    /// Its width, in s.
    #[must_use]
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// The intersection of two intervals that contain the same number.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }
}

/// A collision, and bounds of its time after the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EnclosedImpact {
    /// The contact that is hit.
    pub contact: ContactNumber,
    /// Contains the time elapsed, in s.
    pub elapsed: Bounds,
}

/// A Zeno point, and bounds of its time after the start.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnclosedZeno {
    /// The contacts at which infinitely many impacts accumulate, or that are at rest from the start.
    pub contacts: Vec<ContactNumber>,
    /// Contains the time elapsed, in s.
    pub elapsed: Bounds,
}

/// Why an enclosure ends before a Zeno point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(into = "&'static str")]
pub enum Uncertain {
    /// The intervals do not decide which contact lands next, or whether one lands: contacts land at almost the same time, a contact grazes
    /// the ground, or rounding errors have grown.
    Order,
    /// The body spins so fast that the gap of a contact may not be a concave function of time: ω²√(b² + c²) ≥ g (full model only).
    Spin,
    /// The time limit, or the event limit.
    Limit,
    /// It is certain that no contact lands again.
    Never,
    /// The rest of the motion is shorter than the rounding error of the time, and its end is not enclosed (full model only).
    Rest,
}

impl Uncertain {
    /// In words.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Order => "which contact lands next is not certain",
            Self::Spin => {
                "the body spins fast: where ω² times the distance of a contact from the centre of mass exceeds gravity, nothing is certain"
            }
            Self::Limit => "a limit of the run is reached",
            Self::Never => "no contact lands again",
            Self::Rest => {
                "all further flights are shorter than the rounding error of the time: only the local model encloses their end"
            }
        }
    }
}

impl From<Uncertain> for &'static str {
    fn from(uncertain: Uncertain) -> Self {
        uncertain.as_str()
    }
}

/// Collisions up to the first Zeno point, each with an interval that is proved to contain its time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Enclosure {
    /// The collisions in order. It is also proved that they happen, and at these contacts.
    pub impacts: Vec<EnclosedImpact>,
    /// The point at which all later collisions accumulate.
    pub zeno: Option<EnclosedZeno>,
    /// If there is no such point: the reason why the enclosure ends after the last of the collisions.
    pub reason: Option<Uncertain>,
}
