//! A quantity over a grid of parameters.
//!
//! The points of the grid are numbered like the entries of an array, the last axis fastest. The values at a point are computed from the
//! posture with the parameters of this point, independently of all other points. So they depend neither on the number of threads nor on the
//! division of the grid into ranges.

mod parameters;
mod written;

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::body::{Chain, ChainFields, HoldingChoice, Mechanism};
use crate::error::Error;
use crate::options::{Jams, Options};
use crate::outcome::Outcome;
use crate::simulate::Simulation;
use crate::simulate::parallel::in_blocks;
use crate::stability::{
    Argument, Conditions, Details, Equilibrium, Stability, StabilityOptions, Verdict, WhyUndecided,
    conditions, judge, mechanism_stability,
};
use parameters::{Field, OfContact, Subject};

/// Largest number of points of a grid, and of its values for all quantities together: 0.8 GB.
pub const MOST_POINTS: usize = 100_000_000;

/// Points of a grid of this shape.
///
/// ```
/// assert_eq!(standfast::sweep::grid_size(&[2, 3])?, 6);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// More than [`MOST_POINTS`].
pub fn grid_size(lengths: &[usize]) -> Result<usize, Error> {
    let size = lengths.iter().copied().try_fold(1_usize, usize::checked_mul);
    size.filter(|size| *size <= MOST_POINTS).ok_or_else(|| {
        let shape = format!("a grid of shape {lengths:?}");
        unusable("over", &shape, &format!("at most {MOST_POINTS} points"))
    })
}

/// A parameter of a posture and the values that it takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "written::Axis", into = "written::Axis")]
pub struct Axis {
    path: String,
    field: Field,
    values: Vec<f64>,
}

/// A quantity that is computed at each point. It is written as its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "String", into = "&'static str")]
pub enum Quantity {
    /// [`Equilibrium::holds`]
    Equilibrium,
    /// [`Equilibrium::margin`]
    EquilibriumMargin,
    /// A field of [`Conditions`], or [`Conditions::theorem_3`].
    Condition(OfConditions),
    /// A field of [`Verdict`] that takes the whole of [`stability`](crate::stability()).
    Verdict(OfVerdict),
    /// The outcome of a run from the given start.
    Fate,
    /// The time of the first Zeno point of a run from the given start, in s; NaN if there is none.
    ZenoTime,
}

/// A field of [`Conditions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "Quantity", into = "Quantity")]
pub enum OfConditions {
    /// [`Conditions::theorem_3`]: a kinematic-strong equilibrium in which clattering converges.
    Theorem3,
    /// [`Conditions::kinematic_strong`]: no word other than the static one is possible.
    KinematicStrong,
    /// [`Conditions::kinematic_strong_strict`]: the same, with fixed contacts in their friction cones.
    KinematicStrongStrict,
    /// [`Conditions::kinematic_margin`]: the least margin of this test, dimensionless.
    KinematicMargin,
    /// [`Conditions::unambiguous`]: FF is the only consistent word.
    Unambiguous,
    /// [`Conditions::coupling`]: ψ, dimensionless.
    Coupling,
    /// [`Conditions::clattering`]: the bound (10) holds.
    Clattering,
    /// [`Conditions::clattering_margin`]: ψ less the bound of (10).
    ClatteringMargin,
    /// [`Conditions::chatter`]: Goyal's bound holds.
    Chatter,
    /// [`Conditions::chatter_margin`]: ψ less Goyal's bound.
    ChatterMargin,
}

/// A field of a verdict that needs the whole verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "Quantity", into = "Quantity")]
pub enum OfVerdict {
    /// `frictional_stability`: stable, unstable or undecided.
    Stability,
    /// `by`: the argument that decides.
    Argument,
    /// [`reason`](crate::stability::Verdict::reason): why the verdict is undecided.
    Reason,
    /// `energy`: every frictionless motion comes to rest on the contacts. False where it is `None`.
    Energy,
    /// Whether the body stands in a well: `well` is not `None`.
    Stays,
    /// `delicate`: undecided only because of the width of the numbers.
    Delicate,
    /// `amplification`: the bound of the growth of a motion after a kick; NaN where there is none.
    Amplification,
}

/// The kind of the values of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(try_from = "written::ValueKind", into = "written::ValueKind")]
pub enum ValueKind {
    /// Yes or no.
    Flag,
    /// Numbers.
    Number,
    /// One of these words.
    Word(&'static [&'static str]),
}

const STABILITIES: [Stability; 3] = [Stability::Stable, Stability::Unstable, Stability::Undecided];
const STABILITY_WORDS: [&str; 3] =
    [STABILITIES[0].as_str(), STABILITIES[1].as_str(), STABILITIES[2].as_str()];

/// The names of all arguments, reasons or outcomes, followed by the word for none of them.
macro_rules! words {
    ($known:expr, $none:expr) => {{
        let mut words = [$none; $known.len() + 1];
        let mut k = 0;
        while k < $known.len() {
            words[k] = $known[k].as_str();
            k += 1;
        }
        words
    }};
}

const ARGUMENTS: [Argument; Argument::ALL.len()] = Argument::ALL;
const ARGUMENT_WORDS: [&str; ARGUMENTS.len() + 1] = words!(ARGUMENTS, "undecided");

const REASONS: [WhyUndecided; WhyUndecided::ALL.len()] = WhyUndecided::ALL;
const REASON_WORDS: [&str; REASONS.len() + 1] = words!(REASONS, "decided");

const OUTCOMES: [Outcome; 9] = Outcome::ALL;
const OUTCOME_WORDS: [&str; 8] = [
    OUTCOMES[0].as_str(),
    OUTCOMES[1].as_str(),
    OUTCOMES[2].as_str(),
    OUTCOMES[3].as_str(),
    OUTCOMES[4].as_str(),
    OUTCOMES[5].as_str(),
    OUTCOMES[6].as_str(),
    OUTCOMES[7].as_str(),
];

/// The place of a word in a list that contains it.
fn code<T: PartialEq>(known: &[T], value: &T) -> f64 {
    known.iter().position(|k| k == value).unwrap_or(known.len()) as f64
}

impl Quantity {
    /// All of them, by name.
    pub const ALL: [(&str, Self); 22] = [
        ("stability", Self::Verdict(OfVerdict::Stability)),
        ("frictional_stability", Self::Verdict(OfVerdict::Stability)),
        ("by", Self::Verdict(OfVerdict::Argument)),
        ("reason", Self::Verdict(OfVerdict::Reason)),
        ("stays", Self::Verdict(OfVerdict::Stays)),
        ("theorem_3", Self::Condition(OfConditions::Theorem3)),
        ("equilibrium", Self::Equilibrium),
        ("equilibrium_margin", Self::EquilibriumMargin),
        ("kinematic_strong", Self::Condition(OfConditions::KinematicStrong)),
        ("kinematic_strong_strict", Self::Condition(OfConditions::KinematicStrongStrict)),
        ("kinematic_margin", Self::Condition(OfConditions::KinematicMargin)),
        ("unambiguous", Self::Condition(OfConditions::Unambiguous)),
        ("coupling", Self::Condition(OfConditions::Coupling)),
        ("clattering", Self::Condition(OfConditions::Clattering)),
        ("clattering_margin", Self::Condition(OfConditions::ClatteringMargin)),
        ("chatter", Self::Condition(OfConditions::Chatter)),
        ("chatter_margin", Self::Condition(OfConditions::ChatterMargin)),
        ("energy", Self::Verdict(OfVerdict::Energy)),
        ("delicate", Self::Verdict(OfVerdict::Delicate)),
        ("amplification", Self::Verdict(OfVerdict::Amplification)),
        ("fate", Self::Fate),
        ("zeno_time", Self::ZenoTime),
    ];

    /// The quantity of this name.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if there is none.
    pub fn parse(name: &str) -> Result<Self, Error> {
        let known = Self::ALL.iter().find(|(known, _)| *known == name);
        known.map(|(_, quantity)| *quantity).ok_or_else(|| Error::Unusable {
            field: "quantity".into(),
            value: format!("{name:?}"),
            allowed: format!("one of {}", Self::ALL.map(|(known, _)| known).join(", ")),
        })
    }

    /// The kind of its values.
    #[must_use]
    pub fn kind(self) -> ValueKind {
        match self {
            Self::Verdict(OfVerdict::Stability) => ValueKind::Word(&STABILITY_WORDS),
            Self::Verdict(OfVerdict::Argument) => ValueKind::Word(&ARGUMENT_WORDS),
            Self::Verdict(OfVerdict::Reason) => ValueKind::Word(&REASON_WORDS),
            Self::Fate => ValueKind::Word(&OUTCOME_WORDS),
            Self::ZenoTime
            | Self::EquilibriumMargin
            | Self::Verdict(OfVerdict::Amplification)
            | Self::Condition(
                OfConditions::KinematicMargin
                | OfConditions::Coupling
                | OfConditions::ClatteringMargin
                | OfConditions::ChatterMargin,
            ) => ValueKind::Number,
            Self::Equilibrium | Self::Condition(_) | Self::Verdict(_) => ValueKind::Flag,
        }
    }

    fn needs_run(self) -> bool {
        matches!(self, Self::Fate | Self::ZenoTime)
    }

    /// Its value in a verdict.
    fn of(self, verdict: &Verdict) -> f64 {
        match self {
            Self::Equilibrium => flag(verdict.equilibrium.holds),
            Self::EquilibriumMargin => verdict.equilibrium.margin,
            Self::Condition(field) => match (&verdict.conditions, self.kind()) {
                (Some(found), _) => field.of(found),
                (None, ValueKind::Number) => f64::NAN,
                (None, _) => flag(false),
            },
            Self::Verdict(field) => field.of(verdict),
            Self::Fate | Self::ZenoTime => f64::NAN,
        }
    }
}

/// The mechanism of a chain; `hold`: with torques that hold it.
fn standing(
    fields: ChainFields,
    q: &[f64],
    hold: Option<HoldingChoice>,
) -> Result<Mechanism, Error> {
    let chain = Chain::new(fields)?;
    match hold {
        Some(choice) => chain.mechanism_held(q, choice),
        None => chain.mechanism(q),
    }
}

impl OfVerdict {
    fn of(self, verdict: &Verdict) -> f64 {
        match self {
            Self::Stability => code(&STABILITIES, &verdict.frictional_stability),
            Self::Argument => code(&ARGUMENTS.map(Some), &verdict.by),
            Self::Reason => code(&REASONS.map(Some), &verdict.reason()),
            Self::Energy => flag(verdict.energy == Some(true)),
            Self::Stays => flag(verdict.well.is_some()),
            Self::Delicate => flag(verdict.delicate),
            Self::Amplification => verdict.amplification.unwrap_or(f64::NAN),
        }
    }
}

fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}

impl OfConditions {
    fn of(self, found: &Conditions) -> f64 {
        match self {
            Self::Theorem3 => flag(found.theorem_3()),
            Self::KinematicStrong => flag(found.kinematic_strong),
            Self::KinematicStrongStrict => flag(found.kinematic_strong_strict),
            Self::KinematicMargin => found.kinematic_margin,
            Self::Unambiguous => flag(found.unambiguous),
            Self::Coupling => found.coupling,
            Self::Clattering => flag(found.clattering),
            Self::ClatteringMargin => found.clattering_margin,
            Self::Chatter => flag(found.chatter),
            Self::ChatterMargin => found.chatter_margin,
        }
    }
}

/// Values of a quantity, point by point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "written::Column", into = "written::Column")]
pub enum Column {
    /// Yes or no.
    Flags(Vec<bool>),
    /// Numbers.
    Numbers(Vec<f64>),
    /// Words, each by its place in the list.
    Words {
        /// The list.
        words: &'static [&'static str],
        /// Places in it.
        codes: Vec<u8>,
    },
}

/// Quantities of a posture, or of a chain, over a grid of its parameters.
///
/// ```
/// use standfast::{Lamina, Posture};
/// use standfast::sweep::{Axis, Column, Quantity, Sweep};
///
/// // Clattering of a rod converges if its mass is near the middle: ψ = (L² − ρ²)/(L² + ρ²).
/// let lamina = Lamina { gyration_radius: Some(0.2), restitution: 0.1, friction: 0.5, ..Lamina::default() };
/// let rod = Posture::rod(0.5, &lamina)?;
/// let radii = Axis::new("gyration_radius", vec![0.2, 0.5], &rod)?;
/// let sweep = Sweep::new(&rod, vec![radii], vec![Quantity::parse("theorem_3")?])?;
/// assert_eq!(sweep.run(0..2, 1, &|| false)?, vec![Column::Flags(vec![true, false])]);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "written::Sweep", into = "written::Sweep")]
pub struct Sweep {
    subject: Subject,
    axes: Vec<Axis>,
    quantities: Vec<Quantity>,
    run: Option<(State, Options)>,
    verdicts: StabilityOptions,
    size: usize,
}

/// A posture with other values of parameters, by their paths.
///
/// ```
/// use standfast::sweep::replaced;
/// use standfast::{Lamina, Posture};
///
/// let rod = Posture::rod(0.5, &Lamina::default())?;
/// let rough = replaced(&rod, &[("contacts.2.friction".into(), 0.4)])?;
/// assert_eq!(rough.contacts()[1].friction, 0.4);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// [`Error::Unusable`] if there is no such parameter; the errors of [`Posture::new`] for a value.
pub fn replaced(posture: &Posture, values: &[(String, f64)]) -> Result<Posture, Error> {
    let mut subject = Subject::of(posture);
    for (path, value) in values {
        subject.parameter(path)?.set(&mut subject, *value);
    }
    subject.posture()
}

impl Axis {
    /// The values of a parameter of `posture`, by its path: `mass`, `center_of_mass.x`, `contacts.1.slope`, ….
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if there is no such parameter, or no value; the errors of [`Posture::new`] for a value.
    pub fn new(path: &str, values: Vec<f64>, posture: &Posture) -> Result<Self, Error> {
        let subject = Subject::Body(posture.fields().clone());
        let axis = Self::of(path, values, &subject)?;
        let on_terrain = !posture.fields().terrain.is_empty();
        if on_terrain && matches!(axis.field, Field::Contact(_, OfContact::Slope)) {
            let allowed = "left out, because the terrain of the posture determines it";
            return Err(unusable(path, "[...]", allowed));
        }
        axis.check(&subject)?;
        Ok(axis)
    }

    /// The values of a parameter of a chain in the configuration `q`: `friction`, `armature`, `base.angle`, `joint.1.angle`,
    /// `joint.1.torque`, `foot.1.slope`, ….
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if there is no such parameter, or no value; the errors of [`Chain::new`] and [`Chain::mechanism`] for a value.
    pub fn of_chain(path: &str, values: Vec<f64>, chain: &Chain, q: &[f64]) -> Result<Self, Error> {
        chain.points(q)?;
        let subject = Subject::Chain(chain.fields().clone(), q.to_vec(), None);
        let axis = Self::of(path, values, &subject)?;
        axis.check(&subject)?;
        Ok(axis)
    }

    fn of(path: &str, values: Vec<f64>, subject: &Subject) -> Result<Self, Error> {
        let field = subject.parameter(path)?;
        if values.is_empty() {
            return Err(unusable(path, "[]", "at least one value"));
        }
        Ok(Self { path: path.into(), field, values })
    }

    /// The allowed values are an interval, so its ends are checked.
    fn check(&self, subject: &Subject) -> Result<(), Error> {
        let values = &self.values;
        let ends = [
            values.iter().copied().fold(values[0], f64::min),
            values.iter().copied().fold(values[0], f64::max),
        ];
        let undefined = values.iter().copied().find(|value| value.is_nan());
        subject.check(self.field, undefined.into_iter().chain(ends))
    }

    /// The parameter.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Its values.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

fn unusable(field: &str, value: &str, allowed: &str) -> Error {
    Error::Unusable { field: field.into(), value: value.into(), allowed: allowed.into() }
}

impl Sweep {
    /// The `quantities` of `posture` over the grid of `axes`, the last one fastest.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] where axes set the same number, the grid is too large, no quantity is given, or one that needs a start:
    /// see [`from_start`](Self::from_start).
    pub fn new(
        posture: &Posture,
        axes: Vec<Axis>,
        quantities: Vec<Quantity>,
    ) -> Result<Self, Error> {
        Self::of(Subject::of(posture), axes, quantities)
    }

    /// As [`new`](Self::new), for a chain in the configuration `q`, without the parameters that vary. `hold`: the joints have these torques of
    /// [`Chain::holding_torques`] instead of their own. A flag is no, and a number NaN, where the
    /// verdict does not have it.
    ///
    /// ```
    /// use standfast::body::{Chain, ChainFields, Foot, HoldingChoice, Joint, Link};
    /// use standfast::sweep::{Axis, Column, Quantity, Sweep};
    ///
    /// let leg = Link::uniform(1.0, 1.0);
    /// let hip = Joint { parent: Some(1), at: Some(0.0), ..Joint::locked() };
    /// let biped = Chain::new(ChainFields {
    ///     links: vec![Link { center: Some(0.0), ..Link::uniform(10.0, 1.0) }, leg, leg],
    ///     joints: vec![hip, hip],
    ///     feet: [2, 3].map(|link| Foot { friction: 0.8, ..Foot::of_link(link) }).to_vec(),
    ///     ..ChainFields::default()
    /// })?;
    /// let q = [0.0, 0.0, -1.5, -0.5, 0.5];
    /// let axis = Axis::of_chain("base.angle", vec![-1.6, -0.9], &biped, &q)?;
    /// let sweep = Sweep::of_chain(&biped, &q, Some(HoldingChoice::Least), vec![axis], vec![Quantity::parse("equilibrium")?])?;
    /// assert_eq!(sweep.run(0..2, 1, &|| false)?, vec![Column::Flags(vec![true, false])]);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new); where `hold` is not `None` and an axis is the torque of a joint; and quantities that need a start.
    pub fn of_chain(
        chain: &Chain,
        q: &[f64],
        hold: Option<HoldingChoice>,
        axes: Vec<Axis>,
        quantities: Vec<Quantity>,
    ) -> Result<Self, Error> {
        if let Some(axis) = axes.iter().find(|axis| hold.is_some() && axis.field.is_torque()) {
            let allowed = "a parameter that is no torque, because all joints have the torques that hold the chain";
            return Err(unusable("over", &format!("{:?}", axis.path), allowed));
        }
        if quantities.iter().any(|quantity| quantity.needs_run()) {
            let allowed = "a quantity of a verdict: a chain is moved to other configurations, and its runs start in one of them";
            return Err(unusable("quantity", "fate or zeno_time", allowed));
        }
        Self::of(Subject::Chain(chain.fields().clone(), q.to_vec(), hold), axes, quantities)
    }

    fn of(subject: Subject, axes: Vec<Axis>, quantities: Vec<Quantity>) -> Result<Self, Error> {
        if axes.is_empty() {
            return Err(unusable("over", "{}", "at least one parameter with its values"));
        }
        if quantities.is_empty() {
            return Err(unusable("quantity", "[]", "at least one quantity"));
        }
        for (k, axis) in axes.iter().enumerate() {
            // An axis may be that of another posture.
            subject.parameter(&axis.path)?;
            if let Some(other) = axes[..k].iter().find(|other| other.field.clashes(axis.field)) {
                let both = format!("{:?} and {:?}", other.path, axis.path);
                return Err(unusable("over", &both, "parameters that set different numbers"));
            }
        }
        let lengths: Vec<usize> = axes.iter().map(|axis| axis.values.len()).collect();
        let size = grid_size(&lengths)?;
        let count = quantities.len();
        if size * count > MOST_POINTS {
            let asked = format!("a grid of shape {lengths:?} of {count} quantities");
            return Err(unusable("over", &asked, &format!("at most {MOST_POINTS} values")));
        }
        Ok(Self {
            subject,
            axes,
            quantities,
            run: None,
            verdicts: StabilityOptions::default(),
            size,
        })
    }

    /// The start and the options of the runs that [`Quantity::Fate`] and [`Quantity::ZenoTime`] need; nothing of them is
    /// recorded.
    ///
    /// # Errors
    ///
    /// A state that is not finite, options that contradict each other, [`Options::certify`].
    pub fn from_start(mut self, state: State, options: Options) -> Result<Self, Error> {
        state.validate()?;
        options.validate()?;
        if options.certify {
            return Err(unusable("certify", "true", "false, because a map has no proved bounds"));
        }
        self.run = Some((state, Options { record: false, ..options }));
        self.verdicts.jams = options.jams;
        Ok(self)
    }

    /// The width of the verdicts, see [`StabilityOptions::width`].
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] for a width that is out of its range.
    pub fn with_width(mut self, width: f64) -> Result<Self, Error> {
        self.verdicts = StabilityOptions { width, ..self.verdicts }.checked()?;
        Ok(self)
    }

    /// What happens where a contact jams, in verdicts and in runs.
    #[must_use]
    pub fn with_jams(mut self, jams: Jams) -> Self {
        self.verdicts.jams = jams;
        if let Some((_, options)) = &mut self.run {
            options.jams = jams;
        }
        self
    }

    /// Returns true if one of the quantities is a result of a run.
    #[must_use]
    pub fn needs_start(&self) -> bool {
        self.quantities.iter().any(|quantity| quantity.needs_run())
    }

    /// Number of points.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// The posture or the chain of a point.
    fn subject(&self, point: usize) -> Subject {
        let mut subject = self.subject.clone();
        for (axis, value) in self.parameters(point) {
            axis.field.set(&mut subject, value);
        }
        subject
    }

    /// The parameters of a point, the last axis first.
    fn parameters(&self, point: usize) -> impl Iterator<Item = (&Axis, f64)> {
        let mut rest = point;
        self.axes.iter().rev().map(move |axis| {
            let value = axis.values[rest % axis.values.len()];
            rest /= axis.values.len();
            (axis, value)
        })
    }

    /// Writes the values at a point into `row`.
    fn answer(&self, point: usize, row: &mut [f64], stop: &dyn Fn() -> bool) -> Result<(), Error> {
        let posture = match self.subject(point) {
            Subject::Body(fields) => Posture::new(fields)?,
            Subject::Chain(fields, q, hold) => {
                let verdict = mechanism_stability(&standing(fields, &q, hold)?, &self.verdicts)?;
                for (value, quantity) in row.iter_mut().zip(&self.quantities) {
                    *value = quantity.of(&verdict);
                }
                return Ok(());
            }
        };
        let asks = |test: &dyn Fn(&Quantity) -> bool| self.quantities.iter().any(test);
        let verdict = if asks(&|q| matches!(q, Quantity::Verdict(_))) {
            let of = |field| asks(&|q| matches!(q, Quantity::Verdict(own) if *own == field));
            let details = Details {
                amplification: of(OfVerdict::Amplification),
                delicate: of(OfVerdict::Delicate),
            };
            Some(judge(&posture, self.verdicts, details)?)
        } else {
            None
        };
        let equilibrium = match &verdict {
            Some(verdict) => Some(verdict.equilibrium),
            None => asks(&|q| matches!(q, Quantity::Equilibrium | Quantity::EquilibriumMargin))
                .then(|| Equilibrium::of(&posture)),
        };
        let found = if asks(&|q| matches!(q, Quantity::Condition(_))) {
            match verdict.as_ref().and_then(|verdict| verdict.conditions) {
                Some(found) => Some(found),
                None => Some(conditions(&posture)?),
            }
        } else {
            None
        };
        let run = if asks(&|q| q.needs_run()) {
            let Some((state, options)) = &self.run else {
                let allowed = "q and qdot, where the runs of fate and zeno_time start";
                return Err(unusable("q", "None", allowed));
            };
            let run = Simulation { cancel: stop, ..Simulation::new(&posture, *state, *options) };
            Some(run.run()?)
        } else {
            None
        };
        for (value, quantity) in row.iter_mut().zip(&self.quantities) {
            *value = match (quantity, &found, &verdict, &run) {
                (Quantity::Equilibrium, ..) => flag(equilibrium.is_some_and(|found| found.holds)),
                (Quantity::EquilibriumMargin, ..) => {
                    equilibrium.map_or(f64::NAN, |found| found.margin)
                }
                (Quantity::Condition(field), Some(found), _, _) => field.of(found),
                (Quantity::Verdict(field), _, Some(verdict), _) => field.of(verdict),
                (Quantity::Fate, _, _, Some(run)) => code(&OUTCOMES, &run.outcome()),
                (Quantity::ZenoTime, _, _, Some(run)) => {
                    run.zeno_points().first().map_or(f64::NAN, |point| point.time)
                }
                _ => unreachable!("what a quantity needs has been computed"),
            };
        }
        Ok(())
    }

    /// The quantities at the points of a range, on `threads` threads. `cancel` is called every few milliseconds, on the thread that has
    /// called this function.
    ///
    /// # Errors
    ///
    /// [`Error::At`] of the first point that has no answer, such as a start in the terrain; [`Error::Cancelled`] once `cancel` returns true.
    ///
    /// # Panics
    ///
    /// If the range is not one of points.
    pub fn run(
        &self,
        range: Range<usize>,
        threads: usize,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Vec<Column>, Error> {
        assert!(range.start <= range.end && range.end <= self.size, "a range of points");
        let (count, width) = (range.len(), self.quantities.len());
        let work = |points: Range<usize>, stop: &dyn Fn() -> bool| {
            let mut block = vec![0.0; points.len() * width];
            for (row, k) in block.chunks_exact_mut(width).zip(points) {
                let point = range.start + k;
                if stop() {
                    return Err((point, Error::Cancelled));
                }
                self.answer(point, row, stop).map_err(|error| (point, error))?;
            }
            Ok(block)
        };
        let blocks = in_blocks(count, 1, threads, cancel, &work)
            .map_err(|(point, error)| error.at(|| self.place(point)))?;
        let values = |k: usize| {
            blocks.iter().flat_map(move |block| block.iter().skip(k).step_by(width).copied())
        };
        let column = |(k, quantity): (usize, &Quantity)| match quantity.kind() {
            ValueKind::Flag => Column::Flags(values(k).map(|value| value != 0.0).collect()),
            ValueKind::Number => Column::Numbers(values(k).collect()),
            ValueKind::Word(words) => {
                Column::Words { words, codes: values(k).map(|value| value as u8).collect() }
            }
        };
        Ok(self.quantities.iter().enumerate().map(column).collect())
    }

    /// The parameters of a point as a text for a message.
    fn place(&self, point: usize) -> String {
        let mut parameters: Vec<_> = self
            .parameters(point)
            .map(|(axis, value)| format!("{} = {value:?}", axis.path))
            .collect();
        parameters.reverse();
        parameters.join(", ")
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} values", self.path, self.values.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Lamina;

    fn rod() -> Posture {
        Posture::rod(
            0.5,
            &Lamina {
                gyration_radius: Some(0.2),
                restitution: 0.1,
                friction: 0.5,
                ..Lamina::default()
            },
        )
        .unwrap()
    }

    #[test]
    fn axes_of_another_subject_are_refused() {
        let chain = Chain::new(ChainFields {
            links: vec![crate::body::Link::uniform(1.0, 1.0)],
            feet: [0.0, 1.0]
                .map(|at| crate::body::Foot { at: Some(at), ..crate::body::Foot::of_link(1) })
                .to_vec(),
            ..ChainFields::default()
        })
        .unwrap();
        let q = [0.0; 3];
        let of_chain = Axis::of_chain("base.angle", vec![0.0], &chain, &q).unwrap();
        let of_rod = Axis::new("contacts.2.slope", vec![0.0], &rod()).unwrap();
        let asked = || vec![Quantity::parse("stability").unwrap()];
        let error = Sweep::new(&rod(), vec![of_chain], asked()).unwrap_err().to_string();
        assert!(error.starts_with("over = \"base.angle\" cannot be used"), "{error}");
        let error = Sweep::of_chain(&chain, &q, Some(HoldingChoice::Least), vec![of_rod], asked())
            .unwrap_err();
        assert!(error.to_string().starts_with("over = \"contacts.2.slope\""), "{error}");
    }

    fn grid(quantity: &str) -> Sweep {
        let rod = rod();
        let x = Axis::new("center_of_mass.x", vec![-1.0, -0.2, 0.0, 0.3], &rod).unwrap();
        let rho = Axis::new("gyration_radius", vec![0.1, 0.2, 0.4], &rod).unwrap();
        Sweep::new(&rod, vec![x, rho], vec![Quantity::parse(quantity).unwrap()]).unwrap()
    }

    #[test]
    fn points_are_numbered_like_an_array() {
        let sweep = grid("coupling");
        let columns = sweep.run(0..12, 1, &|| false).unwrap();
        let [Column::Numbers(found)] = columns.as_slice() else { panic!() };
        for (i, x) in [-1.0, -0.2, 0.0, 0.3].into_iter().enumerate() {
            for (j, rho) in [0.1, 0.2, 0.4].into_iter().enumerate() {
                let mut fields = rod().fields().clone();
                fields.center_of_mass[0] = x;
                fields.gyration_radius = rho;
                let posture = Posture::new(fields).unwrap();
                assert_eq!(found[3 * i + j], conditions(&posture).unwrap().coupling);
            }
        }
    }

    #[test]
    fn threads_and_ranges_leave_no_trace() {
        let sweep = grid("stability");
        let whole = sweep.run(0..12, 1, &|| false).unwrap();
        for threads in [2, 5, 100] {
            assert_eq!(sweep.run(0..12, threads, &|| false).unwrap(), whole);
        }
        let [Column::Words { words, codes }] = whole.as_slice() else { panic!() };
        let part = sweep.run(5..9, 2, &|| false).unwrap();
        assert_eq!(part, [Column::Words { words, codes: codes[5..9].to_vec() }]);
        assert_eq!(sweep.run(4..4, 2, &|| false).unwrap().len(), 1);
    }

    #[test]
    fn the_first_error_is_reported_whatever_the_threads() {
        let rod = rod();
        let y: Vec<f64> = (0..400).map(|k| 1e-3 * f64::from(k)).collect();
        let axis = Axis::new("contacts.1.point.y", y, &rod).unwrap();
        // Lowered by .1 m every start lies in the terrain.
        let state = State::at_rest([0.0, -0.1, 0.0]);
        for threads in [1, 3] {
            let sweep = Sweep::new(&rod, vec![axis.clone()], vec![Quantity::Fate]).unwrap();
            let sweep = sweep.from_start(state, Options::default()).unwrap();
            let error = sweep.run(7..400, threads, &|| false).unwrap_err().to_string();
            assert!(error.contains("(at contacts.1.point.y = 0.007)"), "{error}");
        }
    }

    #[test]
    fn a_sweep_can_be_stopped() {
        let rod = Posture::rod(
            0.5,
            &Lamina {
                gyration_radius: Some(0.45),
                restitution: 0.9,
                friction: 0.5,
                ..Lamina::default()
            },
        )
        .unwrap();
        let axis = Axis::new("restitution", (0..4000).map(|k| 2e-4 * f64::from(k)).collect(), &rod);
        let sweep = Sweep::new(&rod, vec![axis.unwrap()], vec![Quantity::Fate]).unwrap();
        let options = Options {
            stop: crate::options::Stop::Time,
            time_limit: Some(1e9),
            event_limit: usize::MAX,
            ..Options::default()
        };
        let start = State::new([0.0, 1.0, 0.3], [0.0, 0.0, 3.0]);
        let sweep = sweep.from_start(start, options).unwrap();
        assert_eq!(sweep.run(0..4000, 2, &|| true), Err(Error::Cancelled));
    }

    #[test]
    fn wrong_questions_are_named() {
        let rod = rod();
        let message =
            |path: &str, value: f64| Axis::new(path, vec![value], &rod).unwrap_err().to_string();
        assert!(message("colour", 1.0).contains("over = \"colour\""));
        assert!(message("contacts.3.slope", 0.0).contains("from 1 to 2"));
        assert!(message("contacts.01.slope", 0.0).contains("from 1 to 2"));
        assert!(message("mass", -1.0).contains("mass = -1.0"));
        for wrong in [0.0, f64::NAN, f64::INFINITY] {
            let error = Axis::new("mass", vec![1.0, wrong, 2.0], &rod).unwrap_err().to_string();
            assert!(error.contains(&format!("mass = {wrong:?}")), "{error}");
        }
        assert!(message("contacts.2.slope", 4.0).contains("contacts.2.slope = 4.0"));
        assert!(message("center_of_mass.x", f64::NAN).contains("center_of_mass.x = NaN"));
        let axis = |path: &str| Axis::new(path, vec![0.5], &rod).unwrap();
        for (one, two) in [
            ("mass", "mass"),
            ("friction", "contacts.1.friction"),
            ("contacts.2.friction", "friction"),
        ] {
            let asked = vec![axis(one), axis(two)];
            let error = Sweep::new(&rod, asked, vec![Quantity::Fate]).unwrap_err().to_string();
            assert!(error.contains(one) && error.contains(two), "{error}");
        }
        assert!(Quantity::parse("beauty").unwrap_err().to_string().contains("theorem_3"));
    }
}
