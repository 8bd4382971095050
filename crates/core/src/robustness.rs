//! How hard a posture may be kicked: the share of random kicks after which the body comes back to rest on the same contacts.
//!
//! A *kick* is a velocity given to the body at rest at q = 0. Its size is its norm in the metric of the mass,
//!
//! ```text
//! s = ‖q̇‖ = √(ẋ² + ẏ² + ρ²θ̇²) = √(2 · kinetic energy / m)     q̇ = s (d_1, d_2, d_3/ρ),   |d| = 1
//! ```
//!
//! and its direction d is uniform on the unit sphere. Contacts that the kick drives into the ground are hit at once, by the law of impact.
//!
//! The body *comes back* if it comes to rest, on no other contacts than those that touch at q = 0; if each of these touches the straight line
//! of ground on which it stood, or hovers over it at less than a tenth of the size of the body; and if the body has turned by less than a quarter
//! turn: feet on one line touch it after half a turn, too, with the body below it. (Three contacts on different lines touch together in isolated placements only. After a slide of any length one of them hovers.) So a body that has slid along a floor is back, unless its centre
//! of mass rests beyond the option `neighbourhood`; and a body that lies on another side, stands on a lower step or has turned a somersault is
//! not.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::Serialize;
use smallvec::SmallVec;

use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::side::TouchedSide;
use crate::body::state::State;
use crate::error::{Error, in_range};
use crate::excitation::Excitation;
use crate::math::random::Random;
use crate::math::turn::Turn;
use crate::options::{Edges, Impact, Model, Options, Stop};
use crate::outcome::{ContactNumber, End, Outcome};
use crate::simulate::batch::ends;
use crate::simulate::{Resources, Simulation, Start, solvable};
use crate::tolerance::{HOVERS, SAME_GROUND};

/// Largest number of kicks, of all sizes together: their results take 0.1 GB.
pub const MOST_KICKS: usize = 100_000_000;

/// Number of kicks between two reports of the progress. Results do not depend on it.
const CHUNK: usize = 16_384;

/// The quantile of the normal distribution for an interval of 95 %.
const QUANTILE: f64 = 1.959_963_984_540_054;

/// Largest number of events of a run, unless it is given. A kicked body that has not come to rest by then, such as one whose impacts at three
/// contacts go on without a sum, would take seconds.
const EVENTS: usize = 100_000;

/// Number and kind of the kicks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustnessOptions {
    /// Number of kicks of each size, at least 1.
    pub trials: usize,
    /// Seed of their directions.
    pub seed: u64,
    /// Options of the runs. `stop` must be [`Stop::Rest`]; nothing is recorded.
    pub run: Options,
}

impl Default for RobustnessOptions {
    /// 1000 kicks of each size, in the full model.
    fn default() -> Self {
        let run = Options {
            model: Model::Full,
            record: false,
            event_limit: EVENTS,
            ..Options::default()
        };
        Self { trials: 1000, seed: 0, run }
    }
}

/// What a posture withstands.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Robustness {
    /// Seed of the directions.
    pub seed: u64,
    /// Number of kicks of each size.
    pub trials: usize,
    /// The law of impact that acted.
    pub impact: Impact,
    /// The warnings of the first run that has any; the levels have the numbers of such runs.
    pub warnings: Vec<String>,
    /// The contacts that touch in the posture.
    pub contacts: Vec<ContactNumber>,
    /// Unit directions d of the kicks, the same for all sizes: q̇ = s (d_1, d_2, d_3/ρ).
    #[serde(skip)]
    pub kicks: Vec<[f64; 3]>,
    /// The results for each size, in the given order.
    pub levels: Vec<Level>,
}

/// What happens after kicks of one size.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Level {
    /// Size s of the kicks, in m/s.
    pub size: f64,
    /// s/√(g · size of the body), dimensionless; infinite without gravity.
    #[serde(with = "crate::serial::numbers::extended")]
    pub relative_size: f64,
    /// Share of the kicks from which the body comes back.
    pub share: f64,
    /// Interval of the share that contains the probability with a confidence of 95 %.
    pub interval: [f64; 2],
    /// Number of runs with each outcome that occurs. Of those with `rest`, some may rest elsewhere.
    pub outcomes: BTreeMap<Outcome, usize>,
    /// Largest displacement ‖(x, y, ρθ)‖ at rest of a body that has come back, in m; `None` if none has.
    pub largest_displacement: Option<f64>,
    /// Number of runs with warnings.
    pub warned: usize,
    /// For each kick whether the body comes back from it.
    #[serde(skip)]
    pub returned: Vec<bool>,
}

/// The share of random kicks of each of these `sizes` (m/s) from which `posture` comes back to rest. The directions are the same for all
/// sizes, so that shares can be compared.
///
/// ```
/// use standfast::robustness::RobustnessOptions;
/// use standfast::{Lamina, Posture, robustness};
///
/// let lamina = Lamina { gyration_radius: Some(0.2), restitution: 0.1, friction: 0.5, ..Lamina::default() };
/// let rod = Posture::rod(0.5, &lamina)?;
/// let found = robustness(&rod, &[0.01, 0.1], &RobustnessOptions::default())?;
/// assert!(found.levels.iter().all(|level| level.share == 1.0));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// No sizes, a size that is not finite and > 0, no trials, more than [`MOST_KICKS`] kicks; a posture in which no contact touches at q = 0;
/// options as of [`simulate`](crate::simulate()), `stop` or `certify`. [`Error::At`] for a kick that cannot be simulated.
pub fn robustness(
    posture: &Posture,
    sizes: &[f64],
    options: &RobustnessOptions,
) -> Result<Robustness, Error> {
    robustness_until(posture, sizes, options, Resources::default(), &|| false, &|_| {})
}

/// As [`robustness`], with these resources. `cancel` is called from time to time. `done` is
/// called from time to time with the number of kicks that have been simulated. Both are called on the thread that has called this function.
///
/// # Errors
///
/// As [`robustness`]; [`Error::Cancelled`] once `cancel` returns true.
pub fn robustness_until(
    posture: &Posture,
    sizes: &[f64],
    options: &RobustnessOptions,
    resources: Resources,
    cancel: &dyn Fn() -> bool,
    done: &dyn Fn(usize),
) -> Result<Robustness, Error> {
    let RobustnessOptions { trials, seed, run } = *options;
    let count = checked(sizes, trials, &run)?;
    let run = run.acting(posture.frictions())?;
    let stance = Stance::new(posture, &run)?;
    let kicks = directions(seed, trials);
    let rho = posture.fields().gyration_radius;
    let kick = |number: usize| {
        let (size, kick) = (sizes[number / trials], &kicks[number % trials]);
        State::new([0.0; 3], velocity(size, kick, rho))
    };
    let unit = (posture.fields().gravity * posture.size()).sqrt();
    let mut warnings = Vec::new();
    let mut levels: Vec<Level> = sizes.iter().map(|size| Level::new(*size, unit)).collect();
    for first in (0..count).step_by(CHUNK) {
        let numbers = first..(first + CHUNK).min(count);
        let states: Vec<State> = numbers.clone().map(kick).collect();
        let one = std::slice::from_ref(posture);
        let ends = ends(one, &states, &run, &[Excitation::default()], resources, cancel);
        let ends = ends.map_err(|(at, error)| {
            let (size, kick) = (sizes[(first + at) / trials], (first + at) % trials);
            error.at(|| format!("kick {kick} of {size:?} m/s"))
        })?;
        if warnings.is_empty()
            && let Some(k) = ends.iter().position(|end| end.warned)
        {
            let again = Simulation { cancel, ..Simulation::new(posture, states[k], run) };
            let again = again.run()?;
            warnings = again.warnings().to_vec();
        }
        for (number, end) in numbers.zip(&ends) {
            levels[number / trials].add(end, stance.came_back(end), rho);
        }
        done(ends.len());
    }
    levels.iter_mut().for_each(Level::summarize);
    let contacts = stance.feet.iter().map(Foot::contact).collect();
    Ok(Robustness { seed, trials, impact: run.impact, warnings, contacts, kicks, levels })
}

/// The number of kicks, of all sizes together.
fn checked(sizes: &[f64], trials: usize, run: &Options) -> Result<usize, Error> {
    if sizes.is_empty() {
        return Err(unusable("sizes", "[]".into(), "at least one size of a kick, in m/s"));
    }
    for (k, size) in sizes.iter().enumerate() {
        let right = *size > 0.0 && *size < f64::INFINITY;
        in_range(format_args!("sizes.{}", k + 1), *size, right, "finite and > 0 m/s")?;
    }
    let count = sizes.len().checked_mul(trials).filter(|count| (1..=MOST_KICKS).contains(count));
    let count = count.ok_or_else(|| {
        let allowed = format!("from 1 to {MOST_KICKS} kicks, of all sizes together");
        unusable("trials", trials.to_string(), &allowed)
    })?;
    run.validate()?;
    if run.stop != Stop::Rest {
        return Err(unusable(
            "stop",
            run.stop.to_string(),
            "rest, because a body that comes back is at rest",
        ));
    }
    if run.certify {
        return Err(unusable("certify", "true".into(), "false, because nothing is recorded"));
    }
    Ok(count)
}

fn unusable(field: &str, value: String, allowed: &str) -> Error {
    Error::Unusable { field: field.into(), value, allowed: allowed.into() }
}

/// Unit vectors, uniform on the sphere [Marsaglia 1972]. For u, v uniform in (−1, 1) with S = u² + v² < 1,
///
/// ```text
/// d = (2u√(1 − S), 2v√(1 − S), 1 − 2S)
/// ```
///
/// This needs no function whose last bit differs from machine to machine. More trials of one seed begin with the same directions.
fn directions(seed: u64, count: usize) -> Vec<[f64; 3]> {
    let mut random = Random(seed);
    let mut direction = || loop {
        let (u, v) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
        let sum = u * u + v * v;
        if sum < 1.0 {
            let root = 2.0 * (1.0 - sum).sqrt();
            return [u * root, v * root, 1.0 - 2.0 * sum];
        }
    };
    (0..count).map(|_| direction()).collect()
}

/// The velocity q̇ = s (d_1, d_2, d_3/ρ) of a kick of size s in the direction d.
fn velocity(size: f64, [x, y, turn]: &[f64; 3], rho: f64) -> [f64; 3] {
    [size * x, size * y, size * turn / rho]
}

impl Robustness {
    /// The velocities (m/s, m/s, rad/s) of the kicks of one of the sizes, by its index, for the posture that was kicked.
    ///
    /// # Panics
    ///
    /// If [`levels`](Self::levels) has no such index.
    pub fn velocities(&self, level: usize, posture: &Posture) -> impl Iterator<Item = [f64; 3]> {
        let (size, rho) = (self.levels[level].size, posture.fields().gyration_radius);
        self.kicks.iter().map(move |kick| velocity(size, kick, rho))
    }

    /// The result as JSON, without the single kicks.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self)
            .unwrap_or_else(|e| unreachable!("a plain tree of numbers and names: {e}"))
    }
}

/// A contact that touches at q = 0.
enum Foot {
    /// One of the body, with the lines of ground on which it stands there, two in a concave vertex.
    Own(ContactNumber, SmallVec<[ContactGeometry; 2]>),
    /// A side on a corner of the ground.
    Side(ContactNumber, TouchedSide),
}

impl Foot {
    fn contact(&self) -> ContactNumber {
        match self {
            Self::Own(contact, _) | Self::Side(contact, _) => *contact,
        }
    }

    /// Its gaps at `q`, in m. `frozen`: with the Jacobian rows of q = 0.
    fn gaps(&self, posture: &Posture, q: &Vector3<f64>, frozen: bool) -> SmallVec<[f64; 2]> {
        let turn = Turn::by(q.z);
        match self {
            Self::Own(_, lines) => {
                let gap = |line: &ContactGeometry| {
                    if frozen { line.local_gap(q) } else { line.gap(q, &turn) }
                };
                lines.iter().map(gap).collect()
            }
            Self::Side(_, on) => SmallVec::from_slice(&[posture.side_gap(on, q)]),
        }
    }
}

/// The body at rest at q = 0 on its feet, for runs with these options.
pub(crate) struct Stance<'a> {
    posture: &'a Posture,
    feet: Vec<Foot>,
    frozen: bool,
    neighbourhood: f64,
}

impl<'a> Stance<'a> {
    /// Errors: a posture in which no contact touches; what cannot be simulated with these options.
    pub(crate) fn new(posture: &'a Posture, run: &Options) -> Result<Self, Error> {
        solvable(posture, run)?;
        posture.at_its_place()?;
        let stance = Start::new(posture, &State::at_rest([0.0; 3]), run.model)?.touching();
        if stance.is_empty() && posture.side_contacts().is_empty() {
            return Err(unusable(
                "posture",
                "[no contact touches the ground at q = 0]".into(),
                "a posture in which at least one contact touches",
            ));
        }
        let origin = Vector3::zeros();
        let sides = posture.sides_touched(&origin);
        let sides = if run.edges == Edges::Contact { &sides[..] } else { &[] };
        let count_of_own = posture.contacts().len();
        let stance = stance.with((count_of_own..).take(sides.len()));
        let foot = |contact: ContactNumber| match contact.index().checked_sub(count_of_own) {
            Some(k) => Foot::Side(contact, sides[k]),
            None => Foot::Own(contact, posture.touched(contact.index(), &origin)),
        };
        Ok(Self {
            posture,
            feet: stance.iter().map(foot).collect(),
            frozen: run.model == Model::Local,
            neighbourhood: run.neighbourhood,
        })
    }

    /// Returns true if the body has come back to its feet: see the top of this file.
    pub(crate) fn came_back(&self, end: &End) -> bool {
        let (posture, feet, q) = (self.posture, &self.feet, &end.state.q);
        let moved = libm::hypot(q.x, q.y);
        let stands = |foot: &Foot| {
            let same = SAME_GROUND * (posture.size() + moved);
            let touches = end.touching.contains(foot.contact());
            let allowed = if touches { same } else { HOVERS * posture.size() };
            let gaps = foot.gaps(posture, q, self.frozen);
            gaps.iter().any(|gap| (-same..=allowed).contains(gap))
        };
        end.outcome == Outcome::Rest
            && q.z.abs() < std::f64::consts::FRAC_PI_2
            && moved <= self.neighbourhood
            && end.touching.iter().all(|contact| feet.iter().any(|foot| foot.contact() == contact))
            && feet.iter().all(stands)
    }
}

impl Level {
    fn new(size: f64, unit: f64) -> Self {
        Self {
            size,
            relative_size: size / unit,
            share: f64::NAN,
            interval: [f64::NAN; 2],
            outcomes: BTreeMap::new(),
            largest_displacement: None,
            warned: 0,
            returned: Vec::new(),
        }
    }

    fn add(&mut self, end: &End, returned: bool, rho: f64) {
        *self.outcomes.entry(end.outcome).or_default() += 1;
        self.warned += usize::from(end.warned);
        self.returned.push(returned);
        if returned {
            let q = &end.state.q;
            let displacement = Vector3::new(q.x, q.y, rho * q.z).norm();
            let known = self.largest_displacement.unwrap_or(0.0);
            self.largest_displacement = Some(known.max(displacement));
        }
    }

    fn summarize(&mut self) {
        let back = self.returned.iter().filter(|returned| **returned).count();
        self.share = back as f64 / self.returned.len() as f64;
        self.interval = wilson(back, self.returned.len());
    }

    /// Number of kicks after which the body is at rest, there or elsewhere.
    #[must_use]
    pub fn rest(&self) -> usize {
        self.outcomes.get(&Outcome::Rest).copied().unwrap_or(0)
    }
}

/// The interval of Wilson for a probability p that `count` of `trials` trials estimate as p̂, with z the quantile of 95 % [Wilson 1927]: the
/// p with |p̂ − p| ≤ z √(p(1 − p)/n),
///
/// ```text
/// (p̂ + z²/2n ± z √(p̂(1 − p̂)/n + z²/4n²)) / (1 + z²/n)
/// ```
///
/// Unlike p̂ ± z √(p̂(1 − p̂)/n) it is not empty where all trials agree.
fn wilson(count: usize, trials: usize) -> [f64; 2] {
    let (n, z2) = (trials as f64, QUANTILE * QUANTILE);
    let share = count as f64 / n;
    let half = QUANTILE * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    let middle = share + z2 / (2.0 * n);
    // Where all trials agree, an end is exactly 0 or 1.
    let low = if count == 0 { 0.0 } else { (middle - half) / (1.0 + z2 / n) };
    let high = if count == trials { 1.0 } else { (middle + half) / (1.0 + z2 / n) };
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Lamina;

    fn rod() -> Posture {
        let (gyration_radius, restitution, friction) = (Some(0.2), 0.1, 0.5);
        let lamina = Lamina { gyration_radius, restitution, friction, ..Lamina::default() };
        Posture::rod(0.5, &lamina).unwrap()
    }

    #[test]
    fn directions_are_unit_vectors_without_a_preferred_direction() {
        let count = 40_000;
        let kicks = directions(7, count);
        let mut sums = [[0.0; 3]; 2];
        for d in &kicks {
            let norm = Vector3::from(*d).norm();
            assert!((norm - 1.0).abs() < 1e-15, "{d:?}");
            (0..3).for_each(|k| {
                (sums[0][k], sums[1][k]) = (sums[0][k] + d[k], sums[1][k] + d[k] * d[k])
            });
        }
        // Each component is uniform in (−1, 1) [Archimedes]: mean 0, mean square 1/3. Five standard errors.
        let n = count as f64;
        let [mean, square] = [5.0 * (1.0 / 3.0 / n).sqrt(), 5.0 * (4.0 / 45.0 / n).sqrt()];
        for k in 0..3 {
            assert!((sums[0][k] / n).abs() < mean, "{k}");
            assert!((sums[1][k] / n - 1.0 / 3.0).abs() < square, "{k}");
        }
        assert_eq!(directions(7, 10), kicks[..10]);
    }

    /// The ends p of the interval solve (p̂ − p)² = z² p(1 − p)/n.
    #[test]
    fn the_ends_of_the_interval_solve_their_equation() {
        for (count, trials) in [(0, 10), (3, 10), (999, 1000), (1000, 1000), (1, 1)] {
            let (share, n) = (count as f64 / trials as f64, trials as f64);
            let [low, high] = wilson(count, trials);
            assert!(0.0 <= low && low <= share && share <= high && high <= 1.0);
            for p in [low, high] {
                let rest = (share - p) * (share - p) - QUANTILE * QUANTILE * p * (1.0 - p) / n;
                assert!(rest.abs() < 1e-15, "{count}/{trials}: {p}");
            }
        }
    }

    #[test]
    fn threads_chunks_and_trials_leave_no_trace() {
        let rod = rod();
        let options = RobustnessOptions { trials: 700, seed: 3, ..RobustnessOptions::default() };
        let with = |threads| {
            let resources = Resources { threads };
            let seen = std::cell::Cell::new(0);
            let done = |count| seen.set(seen.get() + count);
            let found = robustness_until(&rod, &[0.1, 3.0], &options, resources, &|| false, &done);
            assert_eq!(seen.get(), 1400);
            found.unwrap()
        };
        let one = with(1);
        assert_eq!(one, with(2));
        assert_eq!(one.levels[0].share, 1.0);
        let fewer = RobustnessOptions { trials: 50, ..options };
        let fewer = robustness(&rod, &[3.0], &fewer).unwrap();
        assert_eq!(fewer.levels[0].returned, one.levels[1].returned[..50]);
    }

    #[test]
    fn it_can_be_stopped() {
        let rod = rod();
        let options = RobustnessOptions { trials: 100_000, ..RobustnessOptions::default() };
        let resources = Resources { threads: 2 };
        let found = robustness_until(&rod, &[0.1], &options, resources, &|| true, &|_| {});
        assert_eq!(found, Err(Error::Cancelled));
    }

    #[test]
    fn wrong_questions_are_named() {
        let rod = rod();
        let ask = |sizes: &[f64], trials: usize, run: Options| {
            let options = RobustnessOptions { trials, seed: 0, run };
            robustness(&rod, sizes, &options).unwrap_err().to_string()
        };
        let run = RobustnessOptions::default().run;
        assert!(ask(&[], 10, run).starts_with("sizes = []"));
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = ask(&[0.1, wrong], 10, run);
            assert!(error.starts_with(&format!("sizes.2 = {wrong:?}")), "{error}");
        }
        assert!(ask(&[0.1], 0, run).starts_with("trials = 0"));
        assert!(ask(&[0.1; 2], MOST_KICKS, run).contains("100000000 kicks"));
        let error = ask(&[0.1], 10, Options { stop: Stop::Zeno, ..run });
        assert!(error.starts_with("stop = zeno"), "{error}");
        let error = ask(&[0.1, 1e-200], 10, run);
        assert!(error.ends_with("(at kick 0 of 1e-200 m/s)"), "{error}");
    }

    #[test]
    fn a_body_in_the_air_has_no_stance() {
        let feet = vec![crate::body::Contact::at(-1.0, 0.0), crate::body::Contact::at(1.0, 0.0)];
        let fields = crate::body::PostureFields {
            terrain: vec![[-2.0, -1.0], [2.0, -1.0]],
            contacts: feet,
            ..Posture::rod(
                1.0,
                &Lamina {
                    gyration_radius: Some(0.5),
                    restitution: 0.0,
                    friction: 0.5,
                    ..Lamina::default()
                },
            )
            .unwrap()
            .fields()
            .clone()
        };
        let error = Posture::new(fields)
            .and_then(|posture| robustness(&posture, &[0.1], &RobustnessOptions::default()))
            .unwrap_err();
        assert!(error.to_string().contains("touch"), "{error}");
    }
}
