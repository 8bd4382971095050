//! Runs of mechanisms.

use std::sync::Arc;

use crate::body::Mechanism;
use crate::collisions::log::Spin;
use crate::error::{Error, finite};
use crate::excitation::MechanismExcitation;
use crate::math::compensated_sum;
use crate::motion::Driver;
use crate::motion::subject::{HiddenPiece, MechanismStart, Subject};
use crate::options::{Model, Options};
use crate::outcome::ModelReason;
use crate::simulate::limits::{clatters, ends, touch};
use crate::simulate::sensitivity::limited;
use crate::simulate::trajectory::Trajectory;
use crate::sustained::Rounding;
use crate::sustained::frozen::{Frozen, GapState, Rows};
use crate::tolerance::{FINAL_GAP_ROUNDINGS, TOUCH};

/// The motion of a mechanism near its posture: the rows of its contacts, its mass matrix and its load stay as they are in the posture. `q`
/// and `qdot` (dof): displacement from the posture, in m or rad, and velocity; zero for locked coordinates. The gaps are h_i = N_i q.
///
/// ```
/// use standfast::body::Mechanism;
/// use standfast::simulate::simulate_mechanism;
/// use standfast::{Lamina, Options, Outcome, Posture};
///
/// // A rod is dropped, one end lower than the other: as a mechanism it moves as in the local model of the body.
/// let rod = Posture::rod(0.5, &Lamina { restitution: 0.3, friction: 0.5, ..Lamina::default() })?;
/// let run = simulate_mechanism(&Mechanism::of_posture(&rod)?, &[0.0, 0.011, 0.002], &[0.0; 3], &Options::default())?;
/// assert_eq!(run.outcome(), Outcome::Rest);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// A wrong option; `model` full, because a mechanism has no other geometry than that of its posture; a `q` or `qdot` of another length than
/// the load, or one that moves a locked coordinate; a contact in the ground.
pub fn simulate_mechanism(
    mechanism: &Mechanism,
    q: &[f64],
    qdot: &[f64],
    options: &Options,
) -> Result<Trajectory, Error> {
    simulate_mechanism_until(mechanism, q, qdot, options, &NOTHING, &|| false)
}

static NOTHING: MechanismExcitation = MechanismExcitation { kicks: Vec::new(), loads: Vec::new() };

/// As [`simulate_mechanism`], with kicks and loads. `cancel` is called from time to time.
///
/// ```
/// use standfast::body::Mechanism;
/// use standfast::excitation::MechanismExcitation;
/// use standfast::simulate::simulate_mechanism_until;
/// use standfast::{Lamina, Options, Posture};
///
/// // A block of 2 kg at rest is kicked to 3 m/s; friction stops it after v²/(2 μ g) = 0.9 m.
/// let block = Posture::block(1.0, 0.2, &Lamina { mass: 2.0, friction: 0.5, gravity: 10.0, ..Lamina::default() })?;
/// let excitation = MechanismExcitation { kicks: vec![(1.0, vec![6.0, 0.0, 0.0])], ..Default::default() };
/// let block = Mechanism::of_posture(&block)?;
/// let run = simulate_mechanism_until(&block, &[0.0; 3], &[0.0; 3], &Options::default(), &excitation, &|| false)?;
/// let [q, _] = run.coordinates().expect("of the block");
/// assert!((q[0] - 0.9).abs() < 1e-15);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// As [`simulate_mechanism`]; an excitation that is out of range; [`Error::Cancelled`] once `cancel` returns true.
pub fn simulate_mechanism_until(
    mechanism: &Mechanism,
    q: &[f64],
    qdot: &[f64],
    options: &Options,
    excitation: &MechanismExcitation,
    cancel: &dyn Fn() -> bool,
) -> Result<Trajectory, Error> {
    options.validate()?;
    excitation.validate(options.time, mechanism.dof())?;
    limited(options, |options| unlimited(mechanism, q, qdot, options, excitation, cancel))
}

/// The same without a limit of the sensitivity.
fn unlimited(
    mechanism: &Mechanism,
    q: &[f64],
    qdot: &[f64],
    options: &Options,
    excitation: &MechanismExcitation,
    cancel: &dyn Fn() -> bool,
) -> Result<Trajectory, Error> {
    let unusable = |field: &str, value: String, allowed: String| Error::Unusable {
        field: field.into(),
        value,
        allowed,
    };
    if options.model == Model::Full {
        let allowed = "local or auto, because a mechanism is given by its rows in one posture";
        return Err(unusable("model", "full".into(), allowed.into()));
    }
    if options.certify {
        return Err(unusable("certify", "true".into(), "false for a mechanism".into()));
    }
    let friction = mechanism.contacts().iter().map(|contact| contact.friction);
    let options = &options.acting(friction)?;
    ends((0..mechanism.contacts().len()).map(|i| mechanism.restitution(i)), options)?;
    let dof = mechanism.dof();
    for (name, values) in [("q", q), ("qdot", qdot)] {
        if values.len() != dof {
            return Err(unusable(
                name,
                format!("[{} values]", values.len()),
                format!("one value for each of the {dof} coordinates"),
            ));
        }
        for (k, value) in values.iter().enumerate() {
            finite(format_args!("{name}.{k}"), *value)?;
            if mechanism.fields().locked.contains(&k) && *value != 0.0 {
                let (field, value) = (format!("{name}.{k}"), format!("{value:?}"));
                return Err(unusable(&field, value, "0, because this coordinate is locked".into()));
            }
        }
    }
    let space = mechanism.contact_space();
    let ((y, hidden), (v, hidden_velocity)) = (space.split(q), space.split(qdot));
    // The gap N q of a contact, with the size of its terms; and its rate likewise.
    let product = |i: usize, of: &[f64]| {
        let row = mechanism.contacts()[i].normal.iter().copied();
        let terms = row.zip(of.iter().copied());
        (compensated_sum(terms.clone()), terms.map(|(a, b)| (a * b).abs()).sum::<f64>())
    };
    let count = mechanism.contacts().len();
    let (mut points, mut heights, mut place) = (Vec::new(), Vec::new(), 0.0_f64);
    for i in 0..count {
        let ((mut h, far), (mut u, fast)) = (product(i, q), product(i, qdot));
        let known = FINAL_GAP_ROUNDINGS * f64::EPSILON;
        if h.abs() <= known * far && u.abs() <= known * fast {
            (h, u) = (0.0, 0.0);
        }
        place = place.max(far);
        heights.push(h);
        points.push(GapState { h, u, rounding: Rounding::new(far, fast) });
    }
    let warnings = touch(&mut heights, TOUCH * place)?;
    points.iter_mut().zip(&heights).for_each(|(p, h)| p.h = h + 0.0);
    clatters(points.iter().enumerate().map(|(i, p)| (p.h, p.u, space.gravity(i))))?;
    let rows = Arc::new(Rows::of_mechanism(mechanism));
    let points = points.into_iter().collect();
    let state = Frozen { rows, y, v, points, spin: Spin::default() };
    let changes = excitation.changes(options.time, &mechanism.fields().load);
    let acceleration = space.hidden().clone();
    let first =
        HiddenPiece { elapsed: 0.0, place: hidden, velocity: hidden_velocity, acceleration };
    let subject = Subject::Mechanism(Box::new(MechanismStart {
        mechanism: mechanism.clone(),
        q: q.to_vec(),
        qdot: qdot.to_vec(),
        hidden: first.all(space, &changes),
        excitation: excitation.clone(),
    }));
    let mut driver = Driver::of_rows(state, place, subject, options, warnings, cancel);
    if excitation.is_none() {
        driver.run()?;
    } else {
        driver.run_stages(&changes, options)?;
        driver.record.warnings.extend(excitation.lasting());
    }
    Ok(Trajectory::new(driver.record, Model::Local, ModelReason::Mechanism, *options))
}
