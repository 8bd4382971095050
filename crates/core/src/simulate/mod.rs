//! Runs of a body, and of a local model that is given by its parameters.

pub(crate) mod batch;
pub(crate) mod clocks;
mod limits;
mod mechanism;
pub(crate) mod parallel;
mod reader;
mod sensitivity;
mod simulation;
mod start;
pub(crate) mod trajectory;

pub use batch::{simulate_many, simulate_many_until};
pub use clocks::FilmClock;
pub use mechanism::{simulate_mechanism, simulate_mechanism_until};
pub use parallel::{Answer, FailedAt, Resources, many};
pub use reader::Reader;
pub use simulation::Simulation;
pub use trajectory::{MOST_SAMPLES, Trajectory};

use crate::body::local_model::{LocalModel, LocalState};
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::collisions::log::Spin;
use crate::enclosure;
use crate::error::{Error, dissipative, finite};
use crate::math::unsigned_zero::UnsignedZero;
use crate::motion::Driver;
use crate::motion::subject::Subject;
use crate::options::{Impact, Model, Options};
use crate::outcome::ModelReason;
pub(crate) use crate::simulate::limits::solvable;
use crate::simulate::limits::{LOSES, clatters, ends, reachable, returns, touch};
use crate::simulate::sensitivity::limited;
pub(crate) use crate::simulate::start::Start;
use crate::sustained::frozen::{Frozen, Rows};

/// The motion of `posture` from `state` on.
///
/// ```
/// use standfast::{Lamina, Options, Outcome, Posture, State, simulate};
///
/// // A ball of restitution 1/2 falls 5 m: it comes to rest after √(2h/g)·(1 + e)/(1 − e) = 3 s.
/// let ball = Posture::disc(0.1, 0.0, &Lamina { restitution: 0.5, gravity: 10.0, ..Lamina::default() })?;
/// let run = simulate(&ball, &State::at_rest([0.0, 5.0, 0.0]), &Options::default())?;
/// assert_eq!((run.outcome(), run.time()), (Outcome::Rest, 3.0));
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// An option or a quantity out of range; a state that is not finite, or that penetrates the terrain by more than [`TOUCH`](crate::tolerance::TOUCH) of
/// the size of the body; [`Simultaneous::Together`](crate::options::Simultaneous::Together) with a law of impact for one contact at a time.
pub fn simulate(posture: &Posture, state: &State, options: &Options) -> Result<Trajectory, Error> {
    Simulation::new(posture, *state, *options).run()
}

/// The motion of the gaps and of θ of a local model that is given by its parameters.
///
/// ```
/// use standfast::body::{LocalModel, LocalModelFields, LocalState};
/// use standfast::simulate::simulate_local;
/// use standfast::{Options, Stop};
///
/// // Without coupling each contact bounces as a ball does; contact 1 rests after √(2h/g)·(1 + e)/(1 − e) = 3 s.
/// let (gravity, restitution) = ([10.0; 2], [0.5; 2]);
/// let model = LocalModel::new(LocalModelFields { gravity, restitution, ..LocalModelFields::default() })?;
/// let start = LocalState { gaps: [5.0, 20.0], ..LocalState::default() };
/// let run = simulate_local(&model, &start, &Options { stop: Stop::Zeno, ..Options::default() })?;
/// assert_eq!(run.time(), 3.0);
/// # Ok::<(), standfast::Error>(())
/// ```
///
/// # Errors
///
/// A wrong option, a state that is not finite, a negative gap, or ψ_1ψ_2 = 1, where the two gaps cannot move by themselves.
pub fn simulate_local(
    model: &LocalModel,
    start: &LocalState,
    options: &Options,
) -> Result<Trajectory, Error> {
    simulate_local_until(model, start, options, &|| false)
}

/// As [`simulate_local`]. `cancel` is called from time to time.
///
/// # Errors
///
/// As [`simulate_local`]; [`Error::Cancelled`] once `cancel` returns true.
pub fn simulate_local_until(
    model: &LocalModel,
    start: &LocalState,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Result<Trajectory, Error> {
    options.validate()?;
    limited(options, |options| unlimited_local(model, start, options, cancel))
}

/// The same without a limit of the sensitivity.
fn unlimited_local(
    model: &LocalModel,
    start: &LocalState,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Result<Trajectory, Error> {
    let (gaps, rates) = (start.gaps.unsigned_zero(), start.rates.unsigned_zero());
    let theta = finite("theta", start.theta)?.unsigned_zero();
    let omega = finite("omega", start.omega)?.unsigned_zero();
    let options = &Options { impact: Impact::Newton, ..*options }; // no contact has friction
    let (h, warnings) = checked(model, gaps, rates, options)?;
    let rows = Rows::of_local(model, h).ok_or_else(|| Error::Unusable {
        field: "psi.1 * psi.2".into(),
        value: format!("{:?}", model.psi()[0] * model.psi()[1]),
        allowed:
            "below 1 by more than 16 rounding errors, so that the two gaps can move by themselves"
                .into(),
    })?;
    let frozen = Frozen::of_gaps(rows, h, rates, Spin { theta, omega });
    let subject = Subject::Local(Box::new((*model, LocalState { gaps, rates, theta, omega })));
    let place = h.iter().fold(0.0, |most: f64, h| most.max(*h));
    let mut driver = Driver::of_rows(frozen, place, subject, options, warnings, cancel);
    driver.run()?;
    let run = Trajectory::new(driver.record, Model::Local, ModelReason::Given, *options);
    if !options.certify {
        return Ok(run);
    }
    let enclosure = enclosure::enclose_given(model, h, rates, options, cancel);
    Ok(run.with(enclosure.ok_or(Error::Cancelled)?))
}

/// Checks the start of a run with these options; returns its gaps and warnings.
pub(crate) fn checked(
    model: &LocalModel,
    mut gaps: [f64; 2],
    rates: [f64; 2],
    options: &Options,
) -> Result<([f64; 2], Vec<String>), Error> {
    options.validate()?;
    let gain = model.psi().iter().fold(1.0_f64, |most, psi| most.max(psi.abs()));
    for i in 0..2 {
        finite(format_args!("gaps.{}", i + 1), gaps[i])?;
        finite(format_args!("rates.{}", i + 1), rates[i])?;
        finite(format_args!("rates.{} times the larger psi", i + 1), gain * rates[i])?;
    }
    let most = |values: [f64; 2]| values.iter().fold(0.0_f64, |most, v| v.abs().max(most));
    reachable(gain * most(model.gravity()), options)?;
    ends(model.restitution(), options)?;
    if options.certify {
        dissipative(model.restitution(), LOSES)?;
    }
    let least = model.gravity().into_iter().filter(|g| *g > 0.0).fold(f64::INFINITY, f64::min);
    returns("largest of rates times the larger psi", gain * most(rates), least)?;
    let warnings = touch(&mut gaps, 0.0)?;
    clatters([0, 1].map(|i| (gaps[i], rates[i], model.gravity()[i])))?;
    Ok((gaps, warnings))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::GroundKind;
    use crate::body::Lamina;
    use crate::body::contact::Contact;
    use crate::body::fields::PostureFields;
    use crate::options::{MOST_RECORDED, Stop};
    use crate::outcome::Outcome;
    use crate::simulate::start::never_turns;

    #[test]
    fn a_record_has_an_end() {
        let recorded = Options { event_limit: usize::MAX, ..Options::default() };
        let events = |record: bool, count: usize| Options { record, ..recorded }.events(count);
        assert_eq!((events(true, 2), events(true, 64)), (10_000_000, 312_500));
        assert_eq!(events(false, 2), usize::MAX);
        assert_eq!(Options::default().events(2), 1_000_000);
    }

    /// The lowest of 64 corners bounces under the centre of mass, so that the body does not turn. Bounces of a body with more than two
    /// contacts are not summed.
    #[test]
    fn a_full_record_says_so() {
        let fields = PostureFields {
            mass: 1.0,
            gyration_radius: 10.0,
            center_of_mass: [0.0, 500.0],
            contacts: (-32..32).map(|k| Contact::at(f64::from(k), f64::from(k * k))).collect(),
            restitution: 1.0 - f64::EPSILON,
            gravity: 10.0,
            ground: GroundKind::Shared,
            ..PostureFields::default()
        };
        let posture = Posture::new(fields).unwrap();
        let run = |event_limit| {
            let options = Options { model: Model::Full, event_limit, ..Options::default() };
            simulate(&posture, &State::at_rest([0.0, 1.0, 0.0]), &options).unwrap()
        };
        let says_so = |run: &Trajectory| {
            run.warnings().iter().any(|w| w.starts_with("the record is full after 312500 events"))
        };
        let full = run(usize::MAX);
        assert_eq!(full.outcome(), Outcome::EventLimit);
        assert!(full.collisions() * 64 <= MOST_RECORDED && says_so(&full));
        let short = run(1000);
        assert_eq!(short.outcome(), Outcome::EventLimit);
        assert!(!says_so(&short));
    }

    /// A body with one contact at x = 0 under its centre of mass, which is at this height.
    fn on_one_foot(slope: f64, friction: f64, height: f64) -> Posture {
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.3,
            center_of_mass: [0.0, height],
            contacts: vec![Contact { friction, ..Contact::at(0.0, 0.0) }.on_slope(slope)],
            restitution: 0.3,
            gravity: 9.81,
            ..PostureFields::default()
        })
        .unwrap()
    }

    #[test]
    fn a_body_never_turns_without_torques() {
        let dropped = State::at_rest([0.1, 1.0, 0.0]);
        let thrown = State::new([0.0, 1.0, 0.0], [0.5, 0.0, 0.0]);
        let spinning = State::new([0.0, 1.0, 0.0], [0.0, 0.0, 1e-9]);
        let ball = |friction| on_one_foot(0.0, friction, 0.2);
        assert!(never_turns(&ball(0.0), &dropped) && never_turns(&ball(0.0), &thrown));
        assert!(!never_turns(&ball(0.0), &spinning));
        assert!(never_turns(&ball(0.5), &dropped)); // nothing slides
        assert!(!never_turns(&ball(0.5), &thrown)); // friction turns the ball
        assert!(never_turns(&on_one_foot(0.0, 0.5, 0.0), &thrown)); // a point mass
        assert!(!never_turns(&on_one_foot(0.3, 0.5, 0.2), &dropped)); // the arm is not along the normal
    }

    /// A body on this many feet in a row, on the level floor of this kind.
    fn on_feet(count: usize, ground: GroundKind, terrain: Vec<[f64; 2]>) -> Posture {
        let place = |k: usize| -0.5 + k as f64 / (count - 1) as f64;
        let foot = |k: usize| Contact { friction: 0.3, ..Contact::at(place(k), 0.0) };
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.3,
            center_of_mass: [0.1, 0.4],
            contacts: (0..count).map(foot).collect(),
            restitution: 0.5,
            gravity: 9.81,
            ground,
            terrain,
            ..PostureFields::default()
        })
        .unwrap()
    }

    /// Runs from a fall to rest: the numbers that a long row has are those of its outer feet, to the last bit, and each inner foot follows.
    #[test]
    fn a_row_of_feet_moves_as_its_outer_feet() {
        let start = State::new([0.0, 0.5, 0.2], [0.3, 0.0, 0.5]);
        let floor = vec![[-9.0, 0.0], [9.0, 0.0]];
        let grounds =
            [(GroundKind::Own, vec![]), (GroundKind::Shared, vec![]), (GroundKind::Own, floor)];
        for (ground, terrain) in grounds {
            let [two, all] = [2, 64].map(|n| on_feet(n, ground, terrain.clone()));
            for stop in [Stop::Rest, Stop::Zeno] {
                let options = Options { stop, ..Options::default() };
                let [two, run] = [&two, &all].map(|p| simulate(p, &start, &options).unwrap());
                let end = |run: &Trajectory| (run.outcome(), run.time(), *run.state());
                assert_eq!((end(&run), run.collisions()), (end(&two), two.collisions()));
                assert_eq!(run.posture(), Some(&all));
                let [mode, of_two] =
                    [&run, &two].map(|run| run.phases().last().unwrap().mode.clone());
                let letters: Vec<char> = of_two.chars().collect();
                let inner = if letters.contains(&'S') { 'S' } else { letters[0] };
                let inner: String = std::iter::repeat_n(inner, 62).collect();
                assert_eq!(mode, format!("{}{inner}{}", letters[0], letters[1]));
                let t = 0.5 * run.time();
                let [gaps, of_two] = [&run, &two].map(|run| run.at(t).unwrap().gaps);
                let height = |k: usize| of_two[0] + (of_two[1] - of_two[0]) * k as f64 / 63.0;
                assert!((0..64).all(|k| (gaps[k] - height(k)).abs() < 1e-15));
                let [hit, of_two] = [&run, &two].map(|run| run.impacts().last().unwrap().contact);
                assert_eq!(hit.number(), if of_two.number() == 1 { 1 } else { 64 });
                let unrecorded =
                    simulate(&all, &start, &Options { record: false, ..options }).unwrap();
                assert_eq!(end(&unrecorded), end(&run));
                assert_eq!(unrecorded.touching(), run.touching());
                assert_eq!(run.touching().len(), if stop == Stop::Rest { 64 } else { 1 });
                if stop == Stop::Rest {
                    let forces = run.forces(run.time()).unwrap();
                    let weight: f64 = forces.iter().map(|force| force[1]).sum();
                    assert!((weight - 9.81).abs() < 1e-12 && forces.iter().all(|f| f[1] > 0.0));
                    let zeno = run.zeno_points().last().unwrap();
                    assert!(zeno.contacts.len() >= 63, "{:?}", zeno.contacts);
                }
            }
        }
    }

    /// Feet that come to an edge of the floor one after the other, and a foot with a friction of its own.
    #[test]
    fn inner_feet_that_differ_are_followed() {
        let start = State::new([0.0; 3], [3.0, 0.0, 0.0]);
        let edge = on_feet(16, GroundKind::Own, vec![[-9.0, 0.0], [0.8, 0.0], [9.0, -4.0]]);
        assert!(edge.outer_feet().is_some());
        let run = simulate(&edge, &start, &Options { time_limit: Some(2.0), ..Options::default() });
        let left = |mode: &str| mode.contains('S') && !mode.starts_with('S');
        assert!(run.unwrap().phases().iter().any(|phase| left(&phase.mode)));

        let mut fields = on_feet(16, GroundKind::Own, vec![]).fields().clone();
        fields.contacts[7].friction = 0.2;
        let mixed = Posture::new(fields).unwrap();
        assert_eq!(mixed.outer_feet().unwrap().contacts().len(), 3);
    }

    fn fall(model: Model, record: bool) -> Driver<'static> {
        let rod = Posture::rod(
            0.5,
            &Lamina {
                gyration_radius: Some(0.3),
                restitution: 0.6,
                friction: 0.3,
                ..Lamina::default()
            },
        )
        .expect("a rod");
        let state = State::new([0.0, 0.2, 0.1], [0.3, 0.0, -0.2]);
        let start = Start::new(&rod, &state, model).expect("above the ground");
        let options = Options { record, ..Options::default() };
        start.driver(&rod, &state, &options, &|| false)
    }

    #[test]
    fn an_unrecorded_run_ends_in_the_bits_of_a_recorded_one() {
        for model in [Model::Local, Model::Full] {
            let mut whole = fall(model, true);
            whole.run().expect("an end");
            let whole = whole.record;
            let end = fall(model, false).end().expect("an end");
            assert_eq!((end.outcome, end.state), (Outcome::Rest, whole.end.state));
            assert_eq!((end.elapsed, end.collisions), (whole.end.clock.hi, whole.hits));
        }
    }
}
