//! The smallest push from which a body does not come back: by a scan of sizes, and bisection between neighbours that end differently.
//!
//! What comes back means is said in [`robustness`](mod@crate::robustness). Larger pushes than the smallest one may be harmless again: a body
//! that is thrown on may land on its feet. So the result is a list of intervals. An interval between two neighbours of the scan may be missed.

use serde::Serialize;

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::{Error, in_range};
use crate::excitation::{Excitation, Force, GroundMotion, Kick};
use crate::options::{Model, Options, Stop};
use crate::outcome::{End, Outcome};
use crate::robustness::Stance;
use crate::simulate::Resources;
use crate::simulate::batch::ends;
use crate::tolerance::{NO_PUSH, PUSH};

/// Largest number of sizes of a scan.
pub const MOST_SIZES: usize = 1_000_000;

/// What pushes the body, per unit of its size.
#[derive(Debug, Clone, PartialEq)]
pub enum Push {
    /// An impulse; the size is in N s.
    Kick {
        /// Its direction, of any length > 0.
        direction: [f64; 2],
        /// The point of the body that it acts on, at its place in the nominal posture, in m; `None`: the centre of mass.
        point: Option<[f64; 2]>,
    },
    /// A force through the centre of mass for a time; the size is in N.
    Force {
        /// Its direction, of any length > 0.
        direction: [f64; 2],
        /// How long it acts, in s.
        duration: f64,
    },
    /// A motion of the ground by accelerations, multiplied by the size.
    Record(GroundMotion),
}

/// Range and accuracy of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PushOptions {
    /// The largest size that is tried; `None`: a kick that gives the velocity 4 √(g · size of the body); four times the weight and the
    /// force whose impulse is that of this kick; four times the record.
    pub at_most: Option<f64>,
    /// Number of sizes of the scan, equally spaced.
    pub scan: usize,
    /// Relative error of the ends of intervals.
    pub rtol: f64,
    /// Options of the runs. `stop` must be [`Stop::Rest`]; nothing is recorded.
    pub run: Options,
}

impl Default for PushOptions {
    /// 256 sizes, ends to 1e-9, in the full model.
    fn default() -> Self {
        let run = Options { model: Model::Full, record: false, ..Options::default() };
        Self { at_most: None, scan: 256, rtol: PUSH, run }
    }
}

/// The pushes from which a body does not come back.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SmallestPush {
    /// The largest size that was tried.
    pub at_most: f64,
    /// Intervals of sizes from which the body does not come back. The lower end of the first one is the smallest push. From an end that is
    /// [`at_most`](Self::at_most) on nothing is known.
    pub intervals: Vec<[f64; 2]>,
    /// The sizes of the scan.
    pub sizes: Vec<f64>,
    /// For each of them whether the body comes back.
    pub came_back: Vec<bool>,
    /// How the run with the smallest push ends: it is at rest elsewhere, or, as [`Inconsistent`](Outcome::Inconsistent), has no motion. `None`
    /// where the body comes back from all.
    pub outcome: Option<Outcome>,
}

impl Push {
    fn validate(&self) -> Result<(), Error> {
        let (Self::Kick { direction, .. } | Self::Force { direction, .. }) = self else {
            return match self {
                Self::Record(motion) if motion.acceleration.is_empty() => Err(Error::Unusable {
                    field: "ground_motion".into(),
                    value: "tilt".into(),
                    allowed: "a motion by accelerations".into(),
                }),
                _ => Ok(()),
            };
        };
        if let Self::Force { duration, .. } = self {
            let right = *duration > 0.0 && *duration < f64::INFINITY;
            in_range("duration", *duration, right, "finite and > 0 s")?;
        }
        let length = libm::hypot(direction[0], direction[1]);
        let right = length > 0.0 && length < f64::INFINITY;
        in_range("direction", length, right, "a vector of finite length > 0").map(|_| ())
    }

    /// The push of this size, from this time on.
    fn of_size(&self, size: f64, time: f64) -> Excitation {
        let along = |direction: &[f64; 2]| {
            let length = libm::hypot(direction[0], direction[1]);
            direction.map(|x| size * (x / length))
        };
        match self {
            Self::Kick { direction, point } => {
                let kick = Kick { time, impulse: along(direction), point: *point };
                Excitation { kicks: vec![kick], ..Excitation::default() }
            }
            Self::Force { direction, duration } => {
                let force = Force { start: time, end: time + duration, force: along(direction) };
                Excitation { forces: vec![force], ..Excitation::default() }
            }
            Self::Record(motion) => {
                let acceleration =
                    motion.acceleration.iter().map(|a| a.map(|x| size * x)).collect();
                let motion = GroundMotion { acceleration, ..motion.clone() };
                Excitation { ground_motion: Some(motion), ..Excitation::default() }
            }
        }
    }

    /// The largest size that is tried unless it is given.
    fn most(&self, posture: &Posture) -> f64 {
        let fields = posture.fields();
        let weight = fields.mass * fields.gravity;
        let impulse = 4.0 * fields.mass * (fields.gravity * posture.size()).sqrt();
        match self {
            Self::Kick { .. } => impulse,
            Self::Force { duration, .. } => impulse / duration + 4.0 * weight,
            Self::Record(_) => 4.0,
        }
    }
}

/// The smallest push of this kind from which `posture` does not come back.
///
/// ```
/// use standfast::push::{Push, PushOptions, smallest_push};
/// use standfast::{Lamina, Posture};
///
/// // A box of 1 m × 2 m that is pushed at its top turns about its corner: ω = J h/I tips it over if I ω²/2 = m g (√5/2 − 1) m.
/// let lamina = Lamina { friction: 2.0, ..Lamina::default() };
/// let body = Posture::block(1.0, 2.0, &lamina)?;
/// let push = Push::Kick { direction: [1.0, 0.0], point: Some([0.0, 2.0]) };
/// let found = smallest_push(&body, &push, &PushOptions::default())?;
/// let inertia = 5.0 / 3.0;
/// let exact = (2.0_f64 * 9.81 * (1.25_f64.sqrt() - 1.0) * inertia).sqrt() / 2.0;
/// assert!((found.intervals[0][0] / exact - 1.0).abs() < 2e-9);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// A direction of no length, a range or an accuracy out of range; what [`robustness`](crate::robustness()) refuses.
pub fn smallest_push(
    posture: &Posture,
    push: &Push,
    options: &PushOptions,
) -> Result<SmallestPush, Error> {
    smallest_push_until(posture, push, options, Resources::default(), &|| false)
}

/// As [`smallest_push`], with these resources; once `cancel` returns true, the result is [`Error::Cancelled`].
///
/// # Errors
///
/// As [`smallest_push`].
pub fn smallest_push_until(
    posture: &Posture,
    push: &Push,
    options: &PushOptions,
    resources: Resources,
    cancel: &dyn Fn() -> bool,
) -> Result<SmallestPush, Error> {
    push.validate()?;
    let PushOptions { at_most, scan, rtol, run } = *options;
    let most = at_most.unwrap_or_else(|| push.most(posture));
    in_range("at_most", most, most > 0.0 && most < f64::INFINITY, "finite and > 0")?;
    in_range("rtol", rtol, (4.0 * f64::EPSILON..1.0).contains(&rtol), "from 4 eps to below 1")?;
    let unusable = |field: &str, value: String, allowed: String| Error::Unusable {
        field: field.into(),
        value,
        allowed,
    };
    if !(1..=MOST_SIZES).contains(&scan) {
        return Err(unusable("scan", scan.to_string(), format!("from 1 to {MOST_SIZES}")));
    }
    run.validate()?;
    if run.stop != Stop::Rest {
        let rest = "rest, because a body that comes back is at rest";
        return Err(unusable("stop", run.stop.to_string(), rest.into()));
    }
    let run = run.acting(posture.frictions())?;
    let stance = Stance::new(posture, &run)?;
    let pushed = |sizes: &[f64]| -> Result<Vec<End>, Error> {
        let states = vec![State::at_rest([0.0; 3]); sizes.len()];
        let pushes: Vec<_> = sizes.iter().map(|size| push.of_size(*size, run.time)).collect();
        let one = std::slice::from_ref(posture);
        let ends = ends(one, &states, &run, &pushes, resources, cancel);
        ends.map_err(|(k, error)| error.at(|| format!("size {:?}", sizes[k])))
    };
    let came_back = |sizes: &[f64]| -> Result<Vec<bool>, Error> {
        Ok(pushed(sizes)?.iter().map(|end| stance.came_back(end)).collect())
    };
    let sizes: Vec<f64> = (1..=scan).map(|k| most * (k as f64 / scan as f64)).collect();
    let back = came_back(&sizes)?;
    // Without a push the body stays.
    let mut changes: Vec<[f64; 2]> = Vec::new();
    let mut before = (0.0, true);
    for (size, back) in sizes.iter().copied().zip(back.iter().copied()) {
        if back != before.1 {
            changes.push([before.0, size]);
        }
        before = (size, back);
    }
    // Every second change is one to bodies that do not come back. All are bisected at once.
    loop {
        let wide = |[low, high]: [f64; 2]| high - low > rtol * high && high > NO_PUSH * most;
        let open: Vec<usize> = (0..changes.len()).filter(|k| wide(changes[*k])).collect();
        if open.is_empty() {
            break;
        }
        let middles: Vec<f64> =
            open.iter().map(|k| 0.5 * (changes[*k][0] + changes[*k][1])).collect();
        for ((k, middle), back) in open.iter().zip(&middles).zip(came_back(&middles)?) {
            // A change down to falling has a lower end from which the body comes back.
            changes[*k][usize::from(back != (k % 2 == 0))] = *middle;
        }
    }
    let outcome = match changes.first() {
        Some([_, from]) => pushed(&[*from])?.first().map(|end| end.outcome),
        None => None,
    };
    let ends = changes.chunks(2).map(|pair| match *pair {
        [[_, from], [to, _]] => [from, to],
        _ => [pair[0][1], most],
    });
    Ok(SmallestPush { at_most: most, intervals: ends.collect(), sizes, came_back: back, outcome })
}
