//! Small random kicks in the local model: evidence beside a verdict, not a proof.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::body::Mechanism;
use crate::body::contact::Contact;
use crate::body::fields::PostureFields;
use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::error::Error;
use crate::excitation::MechanismExcitation;
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::math::random::Random;
use crate::options::{Impact, Jams, Model, Options};
use crate::outcome::Outcome;
use crate::simulate::{Simulation, simulate_mechanism_until};
use crate::stability::conditions::{touching, with_contacts};
use crate::tolerance::START_LIFT;

/// Speed of a kick, in units of √(g · size). The displacement is the square of this number, in units of the size. The local model has no
/// scale: a smaller kick in the same direction gives the same result.
const KICK: f64 = 1e-3;

/// Displacement, in units of the size, at which a body counts as gone.
const LEFT: f64 = 10.0;

/// Largest number of kicks: hours.
pub const MOST_TRIALS: usize = 100_000_000;

/// Largest number of events of one run.
const EVENTS: usize = 200_000;

/// Results of random kicks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trials {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of kicks.
    pub kicks: usize,
    /// Number of kicks after which the body came to rest.
    pub rest: usize,
    /// Outcomes of the other kicks, and their numbers.
    pub others: BTreeMap<Outcome, usize>,
}

impl Trials {
    fn none(seed: u64, kicks: usize) -> Result<Self, Error> {
        if kicks > MOST_TRIALS {
            return Err(Error::Unusable {
                field: "trials".into(),
                value: kicks.to_string(),
                allowed: format!("at most {MOST_TRIALS}"),
            });
        }
        Ok(Self { seed, kicks, rest: 0, others: BTreeMap::new() })
    }

    fn count(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::Rest => self.rest += 1,
            other => *self.others.entry(other).or_default() += 1,
        }
    }
}

/// A displacement (m, m, rad) that opens all contacts: upwards, or in the direction of the force of equal normal forces. `None` if neither does.
fn opening(posture: &Posture) -> Option<Vector3<f64>> {
    let contacts = posture.geometry();
    let rho2 = posture.gyration_squared();
    let push: Vector3<f64> =
        contacts.iter().map(|k| Vector3::new(k.normal.x, k.normal.y, k.b / rho2)).sum();
    let opens = |way: &Vector3<f64>| contacts.iter().all(|k| k.local_gap(way) > 0.0);
    [Vector3::y(), push].into_iter().find(opens)
}

/// `kicks` random small kicks from a posture: position, rotation and velocities uniform in a box, lifted until no contact is
/// in the terrain. The same `seed` gives the same numbers.
///
/// ```
/// use standfast::options::Jams;
/// use standfast::stability::trials;
/// use standfast::{Lamina, Posture};
///
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// let found = trials(&rod, 100, 0, Jams::None, &|| false)?;
/// assert_eq!((found.rest, found.kicks), (100, 100));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`simulate`](crate::simulate()); more than [`MOST_TRIALS`] kicks; [`Error::Cancelled`] once `cancel` returns true.
pub fn trials(
    posture: &Posture,
    kicks: usize,
    seed: u64,
    jams: Jams,
    cancel: &dyn Fn() -> bool,
) -> Result<Trials, Error> {
    // Small motions do not reach the ground of contacts in the air, nor the ends of the pieces of terrain.
    let standing = with_contacts(posture, &touching(posture))?;
    let endless = [f64::NEG_INFINITY, f64::INFINITY];
    let contacts = standing.contacts().iter();
    let straight = contacts.map(|contact| Contact { segment: endless, ..*contact }).collect();
    let posture = &Posture::new(PostureFields { contacts: straight, ..standing.fields().clone() })?;
    let (size, gravity) = (posture.size(), posture.fields().gravity);
    let speed = KICK * (gravity * size).sqrt();
    let options = Options {
        model: Model::Local,
        impact: Impact::Newton,
        jams,
        record: false,
        neighbourhood: LEFT * size,
        event_limit: EVENTS,
        ..Options::default()
    };
    let opening = opening(posture);
    let mut random = Random(seed);
    let mut found = Trials::none(seed, kicks)?;
    for _ in 0..kicks {
        let mut uniform =
            |scale: f64| [scale, scale, scale / size].map(|part| part * random.between(-1.0, 1.0));
        let (mut q, qdot) = (uniform(KICK * KICK * size), uniform(speed));
        match opening {
            // A displacement by `way` increases each gap; the last factor covers rounding errors.
            Some(way) => {
                let lift = |k: &ContactGeometry| -k.local_gap(&q.into()) / k.local_gap(&way);
                let most = posture.geometry().iter().map(lift).fold(0.0, f64::max);
                q = (Vector3::from(q) + way * (most * (1.0 + START_LIFT))).into();
            }
            None => q = [0.0; 3],
        }
        let run = Simulation::new(posture, State::new(q, qdot), options);
        found.count(Simulation { cancel, ..run }.run()?.outcome());
    }
    Ok(found)
}

/// The same for a mechanism: velocities uniform in a box of the coordinates in which the kinetic energy is ½|ẏ|², with contact speeds of up to
/// about 1e-3 √(g · 1 m). Coordinates that the contacts do not feel are not kicked.
///
/// ```
/// use standfast::body::Mechanism;
/// use standfast::options::Jams;
/// use standfast::stability::mechanism_trials;
/// use standfast::{Lamina, Posture};
///
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// let rod = Mechanism::of_posture(&rod)?;
/// let found = mechanism_trials(&rod, 100, 0, Jams::None, &|| false)?;
/// assert_eq!((found.rest, found.kicks), (100, 100));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`simulate_mechanism`](crate::simulate::simulate_mechanism); more than [`MOST_TRIALS`] kicks; [`Error::Cancelled`] once `cancel` returns true.
pub fn mechanism_trials(
    mechanism: &Mechanism,
    kicks: usize,
    seed: u64,
    jams: Jams,
    cancel: &dyn Fn() -> bool,
) -> Result<Trials, Error> {
    let space = mechanism.contact_space();
    let (count, dof) = (mechanism.contacts().len(), space.pull().len());
    let speed = KICK * space.largest_pull().sqrt() / space.reach();
    let options = Options {
        impact: Impact::Newton,
        jams,
        record: false,
        neighbourhood: LEFT,
        event_limit: EVENTS,
        ..Options::default()
    };
    // A displacement along the sum of the normal rows opens all contacts, or there is none.
    let mut way = Coordinates::zeros(dof);
    (0..count).for_each(|i| way.add_scaled(space.normal_row(i), 1.0));
    let opens = |i: usize| space.normal_row(i).dot(&way);
    let can_open = (0..count).all(|i| opens(i) > 0.0);
    let mut random = Random(seed);
    let mut found = Trials::none(seed, kicks)?;
    for _ in 0..kicks {
        let mut uniform = |scale: f64| {
            Coordinates::from_iter((0..dof).map(|_| scale * random.between(-1.0, 1.0)))
        };
        let (mut y, v) = (uniform(KICK * KICK / space.reach()), uniform(speed));
        if can_open {
            let lift = |i: usize| -space.normal_row(i).dot(&y) / opens(i);
            let most = (0..count).map(lift).fold(0.0, f64::max);
            y.add_scaled(&way, most * (1.0 + START_LIFT));
        } else {
            y = Coordinates::zeros(dof);
        }
        let [q, qdot] = [y, v].map(|y| mechanism.coordinates(&y));
        let run = simulate_mechanism_until(
            mechanism,
            &q,
            &qdot,
            &options,
            &MechanismExcitation::default(),
            cancel,
        )?;
        found.count(run.outcome());
    }
    Ok(found)
}
