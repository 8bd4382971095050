//! Small random kicks in the local model: evidence beside a verdict, not a proof.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::body::contact::Contact;
use crate::body::geometry::ContactGeometry;
use crate::body::posture::{Posture, PostureFields};
use crate::body::state::State;
use crate::error::Error;
use crate::math::random::Random;
use crate::options::{Jams, Model, Options};
use crate::outcome::Outcome;
use crate::simulate::Simulation;
use crate::stability::conditions::{touching, with_contacts};
use crate::tolerance::START_LIFT;

/// Speed of a kick, in units of √(g · size). The displacement is the square of this number, in units of the size. The local model has no
/// scale: a smaller kick in the same direction gives the same result.
const KICK: f64 = 1e-3;

/// Displacement, in units of the size, at which a body counts as gone.
const LEFT: f64 = 10.0;

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
/// in the terrain. The same `seed` gives the same numbers. `None` once `cancel` returns true.
///
/// ```
/// use standfast::options::Jams;
/// use standfast::stability::trials;
/// use standfast::{Lamina, Posture};
///
/// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
/// let found = trials(&rod, 100, 0, Jams::None, &|| false)?.expect("nothing stops it");
/// assert_eq!((found.rest, found.kicks), (100, 100));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`simulate`](crate::simulate()).
pub fn trials(
    posture: &Posture,
    kicks: usize,
    seed: u64,
    jams: Jams,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Trials>, Error> {
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
        jams,
        record: false,
        neighbourhood: LEFT * size,
        event_limit: EVENTS,
        ..Options::default()
    };
    let opening = opening(posture);
    let mut random = Random(seed);
    let mut found = Trials { seed, kicks, rest: 0, others: BTreeMap::new() };
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
        let Some(run) = (Simulation { cancel, ..run }).run()? else { return Ok(None) };
        match run.outcome() {
            Outcome::Rest => found.rest += 1,
            other => *found.others.entry(other).or_default() += 1,
        }
    }
    Ok(Some(found))
}
