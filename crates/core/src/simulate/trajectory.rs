//! The trajectory that a run returns: events, phases, and the motion at any time.

use std::path::Path;
use std::sync::OnceLock;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use crate::body::Mechanism;
use crate::body::lines::Feet;
use crate::body::local_model::{LocalModel, LocalState};
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::{Error, quoted};
use crate::excitation::{Excitation, Force, GroundMotion, Kick, MechanismExcitation};
use crate::file::read::{in_file, read_whole};
use crate::file::text::Format;
use crate::flight::LOST_PHASE;
use crate::math::clock::Clock;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{ContactProblem, MechanismProblem, Mode};
use crate::motion::record::{Moment, Motion, Record, ZenoRecord};
use crate::options::{Model, Options};
use crate::outcome::{
    Cause, ContactKind, ContactNumber, ContactSet, Enclosure, ImpactRecord, Instant, ModelReason,
    Outcome, Phase, RunContact, ZenoKind, ZenoPoint,
};
use crate::simulate::{Simulation, simulate_local_until, simulate_mechanism_until};
use crate::sustained::BodyState;
use crate::sustained::frozen::Frozen;
use crate::tolerance::OUTSIDE_PROVED_BOUNDS;

/// Largest number of times of [`Trajectory::sample_times`]: the motion at them takes 0.6 GB.
pub const MOST_SAMPLES: usize = 10_000_000;

/// A piece of smooth motion: between two collisions, or a whole span.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub(super) clock: Clock,
    pub(super) span: usize,
    /// The flight after a collision of the span; `None`: the motion with which the span begins.
    pub(super) flight: Option<Flight>,
}

/// The state at the start of a flight.
#[derive(Debug, Clone)]
pub(super) enum Flight {
    /// Of a body, after the plain collision with this number.
    Body(usize),
    /// Over constant rows.
    Rows(Box<Frozen>),
}

/// How much the end of a run depends on its start, from [`Trajectory::sensitivity`](crate::Trajectory::sensitivity).
#[derive(Debug, Clone, Default)]
pub(super) struct Sensitivity {
    /// Growth from the start to the end.
    pub(super) growth: f64,
    /// The sum of the growths from all events to the end, in the units of the motion.
    pub(super) error: f64,
    /// The shift of the time of rest by errors of size 1 at all events, in s; and that of each Zeno point.
    pub(super) late: f64,
    pub(super) zeno: Vec<f64>,
    /// √(size/g), in s: the unit of time.
    pub(super) unit: f64,
    /// Elapsed time from which nothing is determined.
    pub(super) lost: Option<Clock>,
    /// Elapsed time at which the growth since the start first exceeds the limit.
    pub(super) passed: Option<Clock>,
}

/// The pieces of a run, and for each collision the normal impulse per unit mass divided by the own-rate jump.
#[derive(Debug, Clone, Default)]
struct Expanded {
    pieces: Vec<Piece>,
    fractions: Vec<f64>,
}

/// A run: its outcome, its events, and the motion at any time of it.
///
/// Serde writes it in the form of [`to_json`](Self::to_json). To read it, the run is simulated again from the same start, which
/// gives the same run to the last bit. Every number of the file is compared with it; a file from another version of this crate may
/// therefore be refused. Only self-describing formats such as JSON can hold it.
///
/// ```
/// use standfast::{Lamina, Options, Posture, State, simulate};
///
/// // A ball of 2 kg and restitution 1/2 falls 5 m at g = 10 m/s².
/// let lamina = Lamina { mass: 2.0, restitution: 0.5, gravity: 10.0, ..Lamina::default() };
/// let ball = Posture::disc(0.1, 0.0, &lamina)?;
/// let run = simulate(&ball, &State::at_rest([0.0, 5.0, 0.0]), &Options::default())?;
///
/// let first = &run.impacts()[0]; // the others are summed to the Zeno point
/// assert_eq!((first.time, first.rates_before[0], first.rates_after[0]), (1.0, -10.0, 5.0));
/// assert_eq!(first.impulse, [0.0, 30.0]);
/// assert_eq!(run.zeno_points()[0].time, 3.0);
/// let modes: Vec<&str> = run.phases().iter().map(|phase| &*phase.mode).collect();
/// assert_eq!(modes, ["S", "F"]);
/// assert_eq!(run.at(0.5)?.gaps, [3.75]); // h − ½ g t²
/// assert_eq!(run.forces(3.0)?, [[0.0, 20.0]]); // at rest: the weight
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Trajectory {
    pub(super) record: Box<Record>,
    /// The posture with all feet, where the record has the outer feet only.
    whole: Option<Posture>,
    options: Options,
    model: Model,
    model_reason: ModelReason,
    enclosure: Option<Box<Enclosure>>,
    excitation: Excitation,
    // Computed at the first access.
    expanded: OnceLock<Expanded>,
    impacts: OnceLock<Vec<ImpactRecord>>,
    zeno_points: OnceLock<Vec<ZenoPoint>>,
    phases: OnceLock<Vec<Phase>>,
    pub(super) sensitivity: OnceLock<Option<Sensitivity>>,
    warnings: OnceLock<Vec<String>>,
}

/// The written form of a run.
#[derive(Serialize)]
struct Written<'a> {
    outcome: Outcome,
    model: Model,
    model_reason: ModelReason,
    time: f64,
    elapsed: f64,
    q: Option<Vec<f64>>,
    qdot: Option<Vec<f64>>,
    theta: f64,
    omega: f64,
    gaps: Vec<f64>,
    rates: Vec<f64>,
    acceleration: Option<Vec<f64>>,
    collisions: usize,
    impacts: &'a [ImpactRecord],
    zeno_points: &'a [ZenoPoint],
    phases: &'a [Phase],
    /// The contacts after those of the posture.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sides: Vec<RunContact>,
    #[serde(skip_serializing_if = "Option::is_none")]
    enclosure: Option<&'a Enclosure>,
    warnings: &'a [String],
    options: &'a Options,
    #[serde(flatten)]
    excitation: &'a Excitation,
    #[serde(skip_serializing_if = "Option::is_none")]
    mechanism_excitation: Option<&'a MechanismExcitation>,
    posture: Option<&'a Posture>,
    #[serde(skip_serializing_if = "Option::is_none")]
    local_model: Option<&'a LocalModel>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mechanism: Option<&'a Mechanism>,
    start: WrittenStart,
}

/// The start of a run, with a body and without.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum WrittenStart {
    Body(State),
    Gaps(LocalState),
    Coordinates { q: Vec<f64>, qdot: Vec<f64> },
}

/// The fields of a run that are read: those that define it, and the others, which are compared.
#[derive(Deserialize)]
struct Question {
    posture: Option<Posture>,
    local_model: Option<LocalModel>,
    mechanism: Option<Mechanism>,
    start: WrittenStart,
    options: Options,
    #[serde(default)]
    kicks: Vec<Kick>,
    #[serde(default)]
    forces: Vec<Force>,
    #[serde(default)]
    ground_motion: Option<GroundMotion>,
    #[serde(default)]
    mechanism_excitation: MechanismExcitation,
    #[serde(flatten)]
    results: serde_json::Map<String, Value>,
}

/// Results that are sentences. They may be worded differently in another version.
const SENTENCES: [&str; 2] = ["model_reason", "warnings"];

impl Question {
    /// Simulates the run again and compares it with what the file says.
    fn answer(self, cancel: &dyn Fn() -> bool) -> Result<Trajectory, Error> {
        let run = match (&self.posture, &self.local_model, &self.mechanism, self.start) {
            (None, None, Some(mechanism), start) => {
                let [q, qdot] = match start {
                    WrittenStart::Coordinates { q, qdot } => [q, qdot],
                    // Three coordinates are read as those of a body.
                    WrittenStart::Body(State { q, qdot }) => {
                        [q, qdot].map(|v| v.as_slice().to_vec())
                    }
                    WrittenStart::Gaps(_) => [Vec::new(), Vec::new()],
                };
                let excitation = &self.mechanism_excitation;
                simulate_mechanism_until(mechanism, &q, &qdot, &self.options, excitation, cancel)?
            }
            (Some(posture), None, None, WrittenStart::Body(start)) => {
                let excitation = &Excitation {
                    kicks: self.kicks,
                    forces: self.forces,
                    ground_motion: self.ground_motion,
                };
                let options = self.options;
                Simulation { posture, start, options, excitation, cancel }.run()?
            }
            (None, Some(model), None, WrittenStart::Gaps(start)) => {
                simulate_local_until(model, &start, &self.options, cancel)?
            }
            _ => {
                return Err(Error::Unusable {
                    field: "start".into(),
                    value: "given".into(),
                    allowed: "q and qdot with a posture or a mechanism, or gaps, rates, theta and omega with a local_model".into(),
                });
            }
        };
        let made = serde_json::to_value(run.written());
        let made = made.unwrap_or_else(|e| unreachable!("a run is JSON: {e}"));
        let numbers =
            self.results.into_iter().filter(|(key, _)| !SENTENCES.contains(&key.as_str()));
        match difference(&made, &Value::Object(numbers.collect()), "") {
            Some((field, made, read)) => Err(Error::Unusable {
                field,
                value: read,
                allowed: format!(
                    "the run from this start has {made}; the file was changed, or written by another version"
                ),
            }),
            None => Ok(run),
        }
    }
}

/// The first value of a file that differs from the run: its path, the value of the run, and that of the file.
fn difference(made: &Value, read: &Value, path: &str) -> Option<(String, String, String)> {
    let at = |key: &str| if path.is_empty() { key.into() } else { format!("{path}.{key}") };
    match (made, read) {
        (Value::Object(made), Value::Object(read)) => read.iter().find_map(|(key, value)| {
            difference(made.get(key).unwrap_or(&Value::Null), value, &at(key))
        }),
        (Value::Array(made), Value::Array(read)) => {
            let mut pairs = made.iter().zip(read).enumerate();
            pairs
                .find_map(|(k, (made, read))| difference(made, read, &at(&(k + 1).to_string())))
                .or_else(|| {
                    let entries = |list: &[Value]| format!("{} entries", list.len());
                    (made.len() != read.len()).then(|| (path.into(), entries(made), entries(read)))
                })
        }
        _ => (made != read).then(|| (path.into(), made.to_string(), read.to_string())),
    }
}

impl Trajectory {
    pub(crate) fn new(
        mut record: Box<Record>,
        model: Model,
        model_reason: ModelReason,
        options: Options,
    ) -> Self {
        record.acceleration = record.acceleration.take().unsigned_zero();
        let options = Options { simultaneous: Some(options.policy()), ..options };
        let most = options.events(record.subject.count());
        let lost = record.warnings.iter().any(|warning| warning == LOST_PHASE);
        if record.outcome == Outcome::EventLimit && most < options.event_limit && !lost {
            record.warnings.push(format!(
                "the record is full after {most} events; with record = false the run continues to event_limit"
            ));
        }
        Self {
            record,
            whole: None,
            options,
            model,
            model_reason,
            enclosure: None,
            excitation: Excitation::default(),
            expanded: OnceLock::new(),
            impacts: OnceLock::new(),
            zeno_points: OnceLock::new(),
            phases: OnceLock::new(),
            sensitivity: OnceLock::new(),
            warnings: OnceLock::new(),
        }
    }

    /// With one more warning.
    pub(crate) fn warned(mut self, warning: String) -> Self {
        self.record.warnings.push(warning);
        self.warnings = OnceLock::new();
        self
    }

    pub(crate) fn excited_by(self, excitation: Excitation) -> Self {
        Self { excitation, ..self }
    }

    /// The run of a posture, from that of its outer feet.
    pub(super) fn of_all_feet(self, posture: &Posture) -> Self {
        Self { whole: Some(posture.clone()), ..self } // it shares its data
    }

    /// The contacts of the posture, in terms of those of the record.
    pub(super) fn feet(&self) -> &Feet {
        self.record.subject.feet()
    }

    /// The run with the options that the user gave.
    pub(super) fn with_options(self, options: &Options) -> Self {
        let simultaneous = self.options.simultaneous;
        Self { options: Options { simultaneous, ..*options }, ..self }
    }

    /// The same, ended by [`Options::sensitivity_limit`].
    pub(super) fn ended_by_growth(mut self, options: &Options) -> Self {
        if self.record.outcome == Outcome::TimeLimit {
            self.record.outcome = Outcome::SensitivityLimit;
        }
        self.with_options(options)
    }

    /// Adds proved bounds of its times, and a warning if rounding errors have grown so far that the run is outside them.
    pub(crate) fn with(mut self, enclosure: Enclosure) -> Self {
        if let (Some(zeno), Some(own)) = (&enclosure.zeno, self.record.zeno.first()) {
            let (t, bounds) = (own.at.clock.hi, zeno.elapsed);
            let off = (bounds.low - t).max(t - bounds.high);
            if off > OUTSIDE_PROVED_BOUNDS * t {
                self.record.warnings.push(format!(
                    "the first Zeno point is {off:.1e} s outside its proved bounds: rounding errors have grown before it"
                ));
            }
        }
        Self { enclosure: Some(Box::new(enclosure)), ..self }
    }

    /// How the run ended.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        self.record.outcome
    }

    /// The model that was solved: `Local` or `Full`.
    #[must_use]
    pub fn model(&self) -> Model {
        self.model
    }

    /// The reason for this model.
    #[must_use]
    pub fn model_reason(&self) -> ModelReason {
        self.model_reason
    }

    /// The kicks, the forces and the motion of the ground of the run.
    #[must_use]
    pub fn excitation(&self) -> &Excitation {
        &self.excitation
    }

    /// The options of the run, with the policy that it used for simultaneous touchdowns in [`Options::simultaneous`].
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The posture; `None` for a run of a [`LocalModel`](crate::body::LocalModel) given by parameters.
    #[must_use]
    pub fn posture(&self) -> Option<&Posture> {
        self.whole.as_ref().or(self.record.subject.posture())
    }

    /// The state at the start; for a model without a body only θ and ω are defined.
    #[must_use]
    pub fn start(&self) -> State {
        self.record.subject.start()
    }

    /// The model without a body, if the run has one, with its start.
    #[must_use]
    pub fn local_start(&self) -> Option<&(LocalModel, LocalState)> {
        self.record.subject.local()
    }

    /// Time on the clock when the outcome was reached, in s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock(self.record.end.clock)
    }

    /// Time from the start to the outcome, in s, not rounded to the clock.
    #[must_use]
    pub fn elapsed(&self) -> f64 {
        self.record.end.clock.hi
    }

    /// The final state. Without a body only θ and ω are defined.
    #[must_use]
    pub fn state(&self) -> &State {
        &self.record.end.state
    }

    /// Final gaps of the contacts of the posture, in m; a side of the body has no gap.
    #[must_use]
    pub fn gaps(&self) -> Vec<f64> {
        self.feet().means(&self.record.end.gaps)
    }

    /// The contacts of [`contacts`](Self::contacts) that touch at the end.
    #[must_use]
    pub fn touching(&self) -> ContactSet {
        self.record.end.touching(self.feet())
    }

    /// Final gap rates of the contacts of the posture, in m/s; a side of the body has none.
    #[must_use]
    pub fn rates(&self) -> Vec<f64> {
        self.feet().means(&self.record.end.rates)
    }

    /// Warnings: corners of the ground that pass through the body (see [`Edges`](crate::options::Edges)), ties, a start with a small penetration
    /// that counts as touching, ground that was probably not intended (see [`Contact`](crate::Contact)), friction that
    /// [`Impact::Newton`](crate::options::Impact::Newton) ignores.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        self.warnings.get_or_init(|| {
            let mut all = self.record.warnings.clone();
            all.extend(self.depends_on_start());
            all
        })
    }

    /// Acceleration q̈ at the start of an endless slide, in m/s², m/s², rad/s²; of a mechanism, of all coordinates.
    #[must_use]
    pub fn acceleration(&self) -> Option<Vec<f64>> {
        self.record.acceleration.clone()
    }

    /// The contact-mode problem at the end of a run that is inconsistent or ambiguous, for
    /// [`contact_modes`](crate::modes::contact_modes).
    #[must_use]
    pub fn undecided(&self) -> Option<&ContactProblem> {
        self.record.undecided.as_deref()
    }

    /// The same for a run of a mechanism.
    #[must_use]
    pub fn undecided_mechanism(&self) -> Option<&MechanismProblem> {
        self.record.undecided_mechanism.as_deref()
    }

    /// Number of collisions simulated one by one, recorded or not.
    #[must_use]
    pub fn collisions(&self) -> usize {
        self.record.hits
    }

    /// What touches at contact `i` of the posture.
    fn kind(&self, i: usize) -> ContactKind {
        match self.posture().map(|posture| posture.contacts()[i].radius) {
            Some(radius) if radius > 0.0 => ContactKind::Round,
            _ => ContactKind::Corner,
        }
    }

    /// The contacts of the run: those of the posture, and the sides of the body that corners of the ground have touched, with the sides beside
    /// them at concave corners of the body.
    #[must_use]
    pub fn contacts(&self) -> Vec<RunContact> {
        let count = self.count();
        let number = ContactNumber::of;
        let own = (0..count).map(|i| RunContact {
            number: number(i),
            kind: self.kind(i),
            index: i,
            corner: None,
            along: None,
            friction: self.posture().map_or(0.0, |posture| posture.geometry()[i].friction),
        });
        let sides = self.record.sides.iter().enumerate().map(|(k, (corner, index))| {
            let side = self.posture().and_then(Posture::outline).map(|all| all.sides()[*index]);
            RunContact {
                number: number(count + k),
                kind: ContactKind::Side,
                index: *index,
                corner: Some([corner.x, corner.y]),
                along: side.map(|side| side.along().into()),
                friction: side.map_or(0.0, |side| side.coefficients[0]),
            }
        });
        own.chain(sides).collect()
    }

    /// The collisions simulated one by one, in order; empty unless recorded.
    #[must_use]
    pub fn impacts(&self) -> &[ImpactRecord] {
        self.impacts.get_or_init(|| self.make_impacts())
    }

    fn make_impacts(&self) -> Vec<ImpactRecord> {
        // The impulses of a mechanism are not per unit mass.
        let of_body = self.posture().map_or(f64::NAN, |p| p.fields().mass);
        let mass = if self.mechanism().is_some() { 1.0 } else { of_body };
        let record =
            |clock: Clock, contact: usize, before, after, impulse: [f64; 2]| ImpactRecord {
                time: self.clock(clock),
                elapsed: clock.hi,
                contact: ContactNumber::of(self.feet().number(contact)),
                rates_before: before,
                rates_after: after,
                impulse: impulse.map(|part| (mass * part).unsigned_zero()),
            };
        let collisions = self.record.collisions.iter().zip(&self.expanded().fractions);
        let mut plain = collisions.map(|(c, fraction)| {
            let [before, after] = [c.before, c.after].map(|rates| self.each(rates));
            record(c.elapsed, c.contact, before, after, [0.0, fraction * c.jump])
        });
        let mut all = Vec::with_capacity(self.record.hits);
        for (k, c) in self.record.impacts.iter().enumerate() {
            let each = |rates: &[f64]| {
                let all: Vec<f64> = self.record.subject.per_contact(|k| rates[k]).collect();
                self.feet().means::<Vec<f64>>(&all).unsigned_zero()
            };
            all.extend(plain.by_ref().take(c.collisions + k - all.len()));
            all.push(record(c.clock, c.contact, each(&c.before), each(&c.after), c.impulse));
        }
        all.extend(plain);
        all
    }

    /// The Zeno points, in order.
    #[must_use]
    pub fn zeno_points(&self) -> &[ZenoPoint] {
        self.zeno_points.get_or_init(|| self.make_zeno_points())
    }

    fn make_zeno_points(&self) -> Vec<ZenoPoint> {
        let grown = |k: usize| self.found_sensitivity().map(|found| found.zeno[k]);
        let points = self.record.zeno.iter().enumerate();
        points.map(|(k, zeno)| self.zeno_point(zeno, grown(k))).collect()
    }

    fn zeno_point(&self, zeno: &ZenoRecord, grown: Option<f64>) -> ZenoPoint {
        let feet = self.feet();
        let contacts: Vec<_> = zeno.contacts(feet).map(ContactNumber::of).collect();
        let Moment { clock, state, gaps, rates, .. } = &zeno.at;
        let (q, qdot) = self.values(&zeno.at).unzip();
        ZenoPoint {
            kind: ZenoKind(contacts.len()),
            contacts,
            time: self.clock(*clock),
            elapsed: clock.hi,
            time_error: self.error_of(*clock, zeno.error, grown),
            q,
            qdot,
            rotation: [state.q.z, state.qdot.z],
            gaps: feet.means(gaps),
            gap_rates: feet.means(rates),
            certified: zeno.certified,
            method: zeno.method,
            plastic: zeno.plastic,
            first_summed: zeno.first_summed,
        }
    }

    /// q and q̇ of a body or a mechanism at this moment.
    fn values(&self, at: &Moment) -> Option<(Vec<f64>, Vec<f64>)> {
        match (self.record.subject.mechanism(), &at.mechanism) {
            (Some(start), Some(state)) => Some(start.coordinates(state, at.clock.hi).into()),
            _ => self
                .posture()
                .map(|_| [at.state.q, at.state.qdot].map(|v| v.as_slice().to_vec()).into()),
        }
    }

    /// The mechanism of the run, if it is not that of a body.
    #[must_use]
    pub fn mechanism(&self) -> Option<&Mechanism> {
        self.record.subject.mechanism().map(|start| &start.mechanism)
    }

    /// The kicks and the loads of a run of a mechanism.
    #[must_use]
    pub fn mechanism_excitation(&self) -> Option<&MechanismExcitation> {
        self.record.subject.mechanism().map(|start| &start.excitation)
    }

    /// q and q̇ at the end, in m or rad and per s: of a body three, of a mechanism one value for each coordinate; `None` for a model without a
    /// body.
    #[must_use]
    pub fn coordinates(&self) -> Option<[Vec<f64>; 2]> {
        self.values(&self.record.end).map(<[Vec<f64>; 2]>::from)
    }

    /// q and q̇ at the start, of a mechanism.
    #[must_use]
    pub fn mechanism_start(&self) -> Option<[&[f64]; 2]> {
        self.record.subject.mechanism().map(|start| [&*start.q, &*start.qdot])
    }

    /// The contact modes in order; empty unless recorded.
    #[must_use]
    pub fn phases(&self) -> &[Phase] {
        self.phases.get_or_init(|| self.make_phases())
    }

    fn make_phases(&self) -> Vec<Phase> {
        let mut phases: Vec<Phase> = Vec::new();
        // The start of each phase, more precise than the time on the clock.
        let mut starts: Vec<Clock> = Vec::new();
        for span in &self.record.spans {
            let number = |contact| self.feet().number(contact);
            let (clock, cause) = (span.clock, span.cause.map(|cause| cause.renumbered(number)));
            let letters: Vec<char> = span.motion.letters(&self.record.subject).chars().collect();
            let mut mode: String = self.feet().modes(&letters, 'S').collect();
            let known = self.count() + self.record.sides.len();
            mode.extend(std::iter::repeat_n('S', known.saturating_sub(mode.len())));
            let start = self.clock(clock);
            let held = mode.contains(|letter| letter != 'S');
            let leaves = held && matches!(cause, Some(Cause::LeftSegment(_)));
            match phases.last_mut() {
                Some(last) if last.mode == mode && last.start < start && !leaves => {}
                Some(last) if last.start == start => {
                    (last.mode, last.cause) = (mode, cause.unwrap_or(last.cause));
                }
                last => {
                    let mut begin = Cause::Start;
                    if let Some(last) = last {
                        (last.end, begin) = (start, last.cause);
                    }
                    let cause = cause.unwrap_or(begin);
                    phases.push(Phase { mode, start, end: start, cause, impacts: 0 });
                    starts.push(clock);
                }
            }
        }
        for k in 0..phases.len() {
            let end = starts.get(k + 1).map_or(self.record.end.clock, |next| *next);
            let before_end = self.impacts_while(|t| t.since(end) < 0.0);
            let up_to_start = self.impacts_while(|t| t.since(starts[k]) <= 0.0);
            phases[k].impacts = before_end.saturating_sub(up_to_start);
        }
        if let Some(last) = phases.last_mut() {
            last.end = self.time();
        }
        phases
    }

    /// Number of recorded collisions whose elapsed time satisfies `early`.
    fn impacts_while(&self, early: impl Fn(Clock) -> bool) -> usize {
        self.record.collisions.partition_point(|collision| early(collision.elapsed))
            + self.record.impacts.partition_point(|impact| early(impact.clock))
    }

    /// The motion at time `t`: see [`Reader::at`](crate::simulate::Reader::at).
    ///
    /// # Errors
    ///
    /// As [`Reader::at`](crate::simulate::Reader::at).
    pub fn at(&self, t: f64) -> Result<Instant, Error> {
        self.reader().at(t)
    }

    /// The contact forces at time `t`: see [`Reader::forces`](crate::simulate::Reader::forces).
    ///
    /// # Errors
    ///
    /// As [`Reader::at`](crate::simulate::Reader::at).
    pub fn forces(&self, t: f64) -> Result<Vec<[f64; 2]>, Error> {
        self.reader().forces(t)
    }

    /// The positions of the contact points at time `t`: see [`Reader::points`](crate::simulate::Reader::points).
    ///
    /// # Errors
    ///
    /// As [`Reader::at`](crate::simulate::Reader::at).
    pub fn points(&self, t: f64) -> Result<Vec<[f64; 2]>, Error> {
        self.reader().points(t)
    }

    /// The energy at time `t`: see [`Reader::energy`](crate::simulate::Reader::energy).
    ///
    /// # Errors
    ///
    /// As [`Reader::at`](crate::simulate::Reader::at).
    pub fn energy(&self, t: f64) -> Result<f64, Error> {
        self.reader().energy(t)
    }

    /// `count` equally spaced times on the clock, in s: the first is the start of the run, the last its end, exactly. A single one is the
    /// start. See also [`sample_times`](Self::sample_times).
    ///
    /// ```
    /// use standfast::{Lamina, Options, Posture, State, simulate};
    ///
    /// let lamina = Lamina { restitution: 0.5, gravity: 10.0, ..Lamina::default() };
    /// let ball = Posture::disc(0.1, 0.0, &lamina)?;
    /// let run = simulate(&ball, &State::at_rest([0.0, 5.0, 0.0]), &Options::default())?;
    /// assert!(run.times(4).eq([0.0, 1.0, 2.0, 3.0]));
    /// # Ok::<(), standfast::Error>(())
    /// ```
    pub fn times(&self, count: usize) -> impl ExactSizeIterator<Item = f64> + use<> {
        let (start, end, last) = (self.options.time, self.time(), count.saturating_sub(1));
        (0..count).map(move |k| {
            if k > 0 && k == last {
                return end;
            }
            (start + (end - start) * (k as f64 / last.max(1) as f64)).clamp(start, end)
        })
    }

    /// `count` times to plot the run, from 2 to [`MOST_SAMPLES`] of them: half of them spread over its pieces, so that they are dense where
    /// events are dense, the others evenly spaced.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if nothing was recorded, or for another `count`.
    pub fn sample_times(&self, count: usize) -> Result<Vec<f64>, Error> {
        let pieces = self.pieces()?;
        if !(2..=MOST_SAMPLES).contains(&count) {
            return Err(Error::Unusable {
                field: "n".into(),
                value: count.to_string(),
                allowed: format!("from 2 to {MOST_SAMPLES}"),
            });
        }
        let (start, end) = (self.options.time, self.time());
        // Without a phase the run ends at its start.
        let even = if pieces.is_empty() { count } else { count.div_ceil(2) };
        let busy = count - even;
        let at = |k: usize, n: usize| k as f64 / n as f64;
        let mut times: Vec<f64> =
            (0..even).map(|k| start + (end - start) * at(k, (even - 1).max(1))).collect();
        for k in 0..busy {
            // Evenly over the pieces: x is a position in the list of pieces, with its fraction within a piece.
            let x = (k as f64 + 0.5) / busy as f64 * pieces.len() as f64;
            let index = (x as usize).min(pieces.len() - 1);
            let from = self.clock(pieces[index].clock);
            let to = pieces.get(index + 1).map_or(end, |next| self.clock(next.clock));
            times.push(from + (to - from) * (x - index as f64));
        }
        for t in &mut times {
            *t = t.clamp(start, end);
        }
        times.sort_by(f64::total_cmp);
        Ok(times)
    }

    /// The whole run as JSON: outcome, final state, impacts, Zeno points, phases, warnings, options, the posture and the start.
    /// Undefined numbers (the impulses of a model without a mass) are null.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_else(|e| unreachable!("a run is JSON: {e}"))
    }

    /// Reads the text of [`to_json`](Self::to_json), as [`load`](Self::load) reads a file.
    ///
    /// ```
    /// use standfast::{Lamina, Options, Posture, State, Trajectory, simulate};
    ///
    /// let rod = Posture::rod(0.5, &Lamina::default())?;
    /// let run = simulate(&rod, &State::at_rest([0.0, 0.2, 0.1]), &Options::default())?;
    /// assert_eq!(Trajectory::from_json(&run.to_json())?.to_json(), run.to_json());
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::File`], as of [`load`](Self::load).
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let run = Format::Json.read::<Question>(text).and_then(|run| run.answer(&|| false));
        run.map_err(|e| in_file(Path::new("run"), "", e))
    }

    fn written(&self) -> Written<'_> {
        let (q, qdot) = self.values(&self.record.end).unzip();
        let local = self.local_start();
        Written {
            outcome: self.outcome(),
            model: self.model,
            model_reason: self.model_reason,
            time: self.time(),
            elapsed: self.elapsed(),
            q,
            qdot,
            theta: self.state().q.z,
            omega: self.state().qdot.z,
            gaps: self.gaps(),
            rates: self.rates(),
            acceleration: self.acceleration(),
            collisions: self.collisions(),
            impacts: self.impacts(),
            zeno_points: self.zeno_points(),
            phases: self.phases(),
            sides: self.contacts().split_off(self.count()),
            enclosure: self.enclosure(),
            warnings: self.warnings(),
            options: &self.options,
            excitation: &self.excitation,
            mechanism_excitation: self.mechanism_excitation().filter(|given| !given.is_none()),
            posture: self.posture(),
            local_model: local.map(|(model, _)| model),
            mechanism: self.mechanism(),
            start: match (local, self.record.subject.mechanism()) {
                (Some((_, start)), _) => WrittenStart::Gaps(*start),
                (_, Some(start)) => {
                    WrittenStart::Coordinates { q: start.q.clone(), qdot: start.qdot.clone() }
                }
                _ => WrittenStart::Body(self.start()),
            },
        }
    }

    /// Intervals that are proved to contain the times of the collisions and of the first Zeno point; `None` unless
    /// [`Options::certify`] asks for them.
    #[must_use]
    pub fn enclosure(&self) -> Option<&Enclosure> {
        self.enclosure.as_deref()
    }

    /// Writes [`to_json`](Self::to_json) to a file, completely or not at all.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be written.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        crate::file::write::write_whole(path.as_ref(), self.to_json().as_bytes())
    }

    /// Reads a file of [`save`](Self::save) and simulates the run again, with the same start and options. Every number of the file is
    /// compared with the run, to the last bit.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the file cannot be read; [`Error::File`] if it does not hold a run, or if the run differs from it: the error names
    /// the first value that does. A file of another version of this crate may differ.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Self::load_until(path, &|| false)
    }

    /// As [`load`](Self::load). `cancel` is called from time to time.
    ///
    /// # Errors
    ///
    /// As [`load`](Self::load); [`Error::Cancelled`] once `cancel` returns true.
    pub fn load_until(path: impl AsRef<Path>, cancel: &dyn Fn() -> bool) -> Result<Self, Error> {
        let path = path.as_ref();
        let problem = |problem: String| Error::File { path: quoted(path), problem, error: None };
        let bytes = read_whole(path, "file of a run", None)?;
        let text = String::from_utf8(bytes);
        let text = text.map_err(|e| problem(format!("is no UTF-8 text: {}", e.utf8_error())))?;
        let question = Format::Json.read::<Question>(&text);
        let question = question.map_err(|e| in_file(path, "holds no run: ", e))?;
        question.answer(cancel).map_err(|e| in_file(path, "", e))
    }

    /// Number of contacts of the posture.
    pub(super) fn count(&self) -> usize {
        self.posture().map_or(self.record.subject.count(), |posture| posture.contacts().len())
    }

    fn each(&self, pair: [f64; 2]) -> Vec<f64> {
        self.feet().means::<Vec<f64>>(&pair[..self.record.subject.count()]).unsigned_zero()
    }

    pub(super) fn clock(&self, elapsed: Clock) -> f64 {
        self.options.clock(elapsed).unsigned_zero()
    }

    pub(super) fn pieces(&self) -> Result<&[Piece], Error> {
        if !self.options.record {
            return Err(Error::Unusable {
                field: "record".into(),
                value: "false".into(),
                allowed: "record = true, so that the trajectory is kept".into(),
            });
        }
        Ok(&self.expanded().pieces)
    }

    fn expanded(&self) -> &Expanded {
        self.expanded.get_or_init(|| self.expand())
    }

    /// Replays the collisions of each span into pieces of smooth motion.
    fn expand(&self) -> Expanded {
        let record = &self.record;
        let mut expanded = Expanded::default();
        for (k, span) in record.spans.iter().enumerate() {
            expanded.pieces.push(Piece { clock: span.clock, span: k, flight: None });
            let last = record
                .spans
                .get(k + 1)
                .map_or(record.collisions.len(), |next| next.first_collision);
            // An impact that ends a contact phase is followed by a span of its own.
            let flies = matches!(&span.motion, Motion::Modes { word, .. } if word.iter().all(|&mode| mode == Mode::Separate));
            let (mut rows, mut clock) = (span.motion.start().frozen().cloned(), span.clock);
            for index in span.first_collision..last {
                let c = &record.collisions[index];
                let flight = if let Some(rows) = &mut rows {
                    let (own, gaps) = c.effects();
                    *rows = rows.hit(c.elapsed.since(clock), &own, &gaps);
                    clock = c.elapsed;
                    expanded.fractions.push(1.0 / rows.space().normal(c.contact, c.contact));
                    Flight::Rows(Box::new(rows.clone()))
                } else {
                    let theta = record.bodies.get(index).map_or(0.0, |(_, spin)| spin.theta);
                    let fraction = record.subject.translational_fraction(c.contact, theta);
                    expanded.fractions.push(fraction);
                    Flight::Body(index)
                };
                if flies {
                    let flight = Some(flight);
                    expanded.pieces.push(Piece { clock: c.elapsed, span: k, flight });
                }
            }
        }
        expanded
    }

    /// The body after this plain collision of a flight that begins at `start`.
    pub(super) fn after_collision(&self, start: &BodyState, index: usize) -> Option<BodyState> {
        let record = &self.record;
        let (_, gaps) = record.collisions.get(index)?.effects();
        let &(center, spin) = record.bodies.get(index)?;
        Some(start.moved(record.subject.pair()?, gaps, center, spin))
    }
}

impl Serialize for Trajectory {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.written().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Trajectory {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Question::deserialize(deserializer)?.answer(&|| false).map_err(D::Error::custom)
    }
}
