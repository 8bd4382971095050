//! Runs: checks of start and options, choice of the model, and call of the event loops.

pub(crate) mod batch;
mod excited;
mod limits;
mod reader;
pub(crate) mod parallel;
pub(crate) mod trajectory;

pub use batch::{Resources, simulate_many, simulate_many_excited_until, simulate_many_until};
pub use excited::{simulate_excited, simulate_excited_until};
pub use reader::Reader;
pub use trajectory::Trajectory;

use nalgebra::Vector2;

use crate::body::contact::PerContact;
use crate::body::geometry::ContactGeometry;
use crate::body::local_model::LocalModel;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::collisions::full::{FullState, PairBody};
use crate::collisions::log::{Center, Spin};
use crate::error::{Error, finite, in_range};
use crate::math::turn::Turn;
use crate::math::unsigned_zero::UnsignedZero;
use crate::motion::frame::{Base, Frame, Snapshot};
use crate::motion::record::Record;
use crate::motion::{AnyContacts, Driver, Pair};
use crate::options::{Model, Options};
use crate::outcome::{ContactSet, End};
pub(crate) use crate::simulate::limits::solvable;
use crate::simulate::limits::{clatters, reachable, returns, touch};
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::{PHASE_LOST, TOUCH};
use crate::zeno::Gaps;
use crate::{auto, enclosure};

/// The motion of `posture` from `state` on.
///
/// # Errors
///
/// An option or a quantity out of range; a state that is not finite, or that penetrates the terrain by more than [`TOUCH`] of
/// the size of the body; [`Simultaneous::Newton`](crate::options::Simultaneous::Newton) with an impact law other than Newton's.
pub fn simulate(posture: &Posture, state: &State, options: &Options) -> Result<Trajectory, Error> {
    simulate_until(posture, state, options, &|| false)
        .map(|run| run.unwrap_or_else(|| unreachable!("nothing cancels this run")))
}

/// As [`simulate`]. `cancel` is called from time to time; once it returns true, the result is `None`.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_until(
    posture: &Posture,
    state: &State,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Trajectory>, Error> {
    options.validate()?;
    solvable(posture, options)?;
    state.validate()?;
    let state = &state.unsigned_zero();
    let mut start = Start::new(posture, state, options.model)?;
    let reason = match options.model {
        Model::Local | Model::Full => "set by the option",
        Model::Auto => match try_local(posture, state, &start, options, cancel) {
            Tried::Run(None) => return Ok(None),
            Tried::Run(Some(run)) => return Ok(enclosed(*run, posture, state, options, cancel)),
            Tried::No(reason) => {
                start.model = Model::Full;
                reason
            }
        },
    };
    let Some(run) = start.run(posture, state, options, cancel) else { return Ok(None) };
    Ok(enclosed(run.into_trajectory(reason, *options), posture, state, options, cancel))
}

/// The run with proved bounds of its times, if the options ask for them; `None`: cancelled.
fn enclosed(
    run: Trajectory,
    posture: &Posture,
    state: &State,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Option<Trajectory> {
    if !options.certify {
        return Some(run);
    }
    let enclosure = match run.model() {
        Model::Local => enclosure::enclose_local(posture, state, options, cancel),
        _ => enclosure::enclose_full(posture, state, options, cancel),
    };
    enclosure.map(|enclosure| run.with(enclosure))
}

/// The result of the attempt with the local model.
enum Tried {
    /// Its error is below the tolerance; `None`: cancelled.
    Run(Option<Box<Trajectory>>),
    /// It cannot be used, with the reason.
    No(&'static str),
}

const EXACT: &str = "exact here: the body does not turn";
const MEASURED: &str =
    "its error, measured along the run against the full equations, is below the tolerance";
const TURNS: &str =
    "the body turns too far for the tolerance already in the first flight and impact";
const MISSES: &str = "the local model was tried: its error exceeds the tolerance";
const START: &str = "different contacts touch at the start in the local and in the full model";
const ENDLESS: &str = "the body turns and does not come to rest: in a motion without end the error of the local model grows without bound";
const UNKNOWN: &str = "the body turns, and the error of the local model is not known with three contacts, friction in impacts, bounded terrain or a neighbourhood";

/// Tries the local model. `full`: the start in the full model.
fn try_local(
    posture: &Posture,
    state: &State,
    full: &Start,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Tried {
    let exact = auto::is_exact(posture, state);
    if !exact {
        if !auto::has_shadow(posture, options) {
            return Tried::No(UNKNOWN);
        }
        if !auto::has_end(posture, options) {
            return Tried::No(ENDLESS);
        }
        if auto::is_hopeless(posture, state, &full.heights, options) {
            return Tried::No(TURNS);
        }
    }
    let touches = |start: &Start, i: usize| start.heights[i] == 0.0;
    let start = match Start::new(posture, state, Model::Local) {
        Ok(start) if (0..start.heights.len()).all(|i| touches(&start, i) == touches(full, i)) => {
            start
        }
        _ => return Tried::No(START),
    };
    if exact {
        let run = start.run(posture, state, options, cancel);
        return Tried::Run(run.map(|run| Box::new(run.into_trajectory(EXACT, *options))));
    }
    let event_limit = options.event_limit.min(auto::MOST_EVENTS);
    let recorded = Options { record: true, event_limit, ..*options };
    let Some(mut run) = start.run(posture, state, &recorded, cancel) else {
        return Tried::Run(None);
    };
    match auto::error(posture, state, &run.record, options) {
        Ok(error) if error <= options.tolerance => {
            if !options.record {
                run.record.forget();
            }
            Tried::Run(Some(Box::new(run.into_trajectory(MEASURED, *options))))
        }
        Ok(_) => Tried::No(MISSES),
        Err(lost) => Tried::No(lost),
    }
}

/// Gaps and rates at the start, in one of the models.
pub(crate) struct Start {
    model: Model,
    heights: PerContact<f64>,
    rates: PerContact<f64>,
    warnings: Vec<String>,
}

/// A run before it is converted to a trajectory.
struct Run {
    model: Model,
    record: Box<Record>,
}

impl Run {
    fn into_trajectory(self, reason: &'static str, options: Options) -> Trajectory {
        Trajectory::new(self.record, self.model, reason, options)
    }
}

impl Start {
    pub(crate) fn new(posture: &Posture, state: &State, model: Model) -> Result<Self, Error> {
        let local = model == Model::Local;
        let known = local || state.q.z.abs() <= PHASE_LOST;
        in_range(
            "q.theta",
            state.q.z,
            known,
            "in [-1e12, 1e12] rad unless model = \"local\": beyond, at most four digits of a rotation are left",
        )?;
        let v = state.qdot;
        in_range(
            "qdot.theta",
            v.z,
            v.z.abs().max(posture.size() * v.z.abs()) <= FASTEST_SPIN,
            "at most 1e70 rad/s in size, and 1e70 m/s times the size of the body",
        )?;
        let speed = v.x.abs() + v.y.abs() + posture.size() * v.z.abs();
        returns("speed of qdot", speed, posture.fields().gravity)?;
        let turn = Turn::by(if local { 0.0 } else { state.q.z });
        let (mut heights, rates): (PerContact<f64>, PerContact<f64>) = (0..posture
            .geometry()
            .len())
            .map(|i| {
                let under = posture.under_moving(i, state, local);
                let k = &under.geometry;
                let (mut gap, mut rate) = if local {
                    (k.local_gap(&state.q), k.local_rate(&state.qdot))
                } else {
                    (k.gap(&state.q, &turn), k.gap_rate(&state.qdot, &turn))
                };
                // Within the rounding error of the state, the contact touches and neither leaves nor lands.
                let [place, speed] = k.roundings(&state.q, &state.qdot, (!local).then_some(&turn));
                if gap.abs() <= place && rate.abs() <= speed {
                    (gap, rate) = (0.0, 0.0);
                }
                let gap = posture.signed_gap(i, &state.q, local, gap);
                (if under.exists { gap } else { f64::INFINITY }, rate)
            })
            .unzip();
        let warnings = touch(&mut heights, TOUCH * posture.size())?;
        if heights.len() > 1 {
            let gravity = posture.geometry().iter().map(|k| k.gravity);
            let starts = heights.iter().zip(&rates).zip(gravity);
            clatters(starts.map(|((h, u), g)| (*h, *u, g)))?;
        }
        Ok(Self { model, heights, rates, warnings })
    }

    /// The contacts that touch the ground.
    pub(crate) fn touching(&self) -> ContactSet {
        ContactSet::of_gaps(&self.heights)
    }

    /// Runs to the outcome; `None` if cancelled.
    fn run(
        self,
        posture: &Posture,
        state: &State,
        options: &Options,
        cancel: &dyn Fn() -> bool,
    ) -> Option<Run> {
        let model = self.model;
        if !Self::is_pair(posture, options) {
            let mut driver = self.any_driver(posture, state, options, cancel);
            driver.run()?;
            return Some(Run { model, record: driver.record });
        }
        let mut driver = self.driver(posture, state, options, cancel);
        driver.run()?;
        Some(Run { model, record: driver.record })
    }

    /// The end of an unrecorded run; `None` if cancelled.
    fn end(
        self,
        posture: &Posture,
        state: &State,
        options: &Options,
        cancel: &dyn Fn() -> bool,
    ) -> Option<End> {
        if Self::is_pair(posture, options) {
            self.driver(posture, state, options, cancel).end()
        } else {
            self.any_driver(posture, state, options, cancel).end()
        }
    }

    /// The driver of a motion with any number of contacts, every law and every terrain.
    fn any_driver<'c>(
        self,
        posture: &Posture,
        state: &State,
        options: &Options,
        cancel: &'c dyn Fn() -> bool,
    ) -> Driver<'c, AnyContacts> {
        let Self { model, heights, rates, warnings } = self;
        let body =
            PairBody::new(posture.geometry(), posture.gyration_squared(), posture.fields().gravity);
        let base = Base::of_body(posture, body, state);
        let start = Self::body_state(posture, state, &heights, &rates, model == Model::Local);
        Driver::of_any(posture, start, base, options, warnings, cancel)
    }

    /// The state of the body, with these gaps (m) and rates (m/s) of its contacts.
    fn body_state(
        posture: &Posture,
        state: &State,
        heights: &[f64],
        rates: &[f64],
        local: bool,
    ) -> BodyState {
        let theta = if local { 0.0 } else { state.q.z };
        let turn = Turn::by(theta);
        let points = posture.distinct().map(|i| {
            let under = posture.under_moving(i, state, local);
            let ContactGeometry { tangent, normal, .. } = under.geometry;
            let (b, c) = under.geometry.turned(&turn);
            let friction = posture.contacts()[i].friction;
            let (mut place, h, u) = (under.place, heights[i], rates[i]);
            if (h, u) == (0.0, 0.0) {
                let [known, _] =
                    under.geometry.roundings(&state.q, &state.qdot, (!local).then_some(&turn));
                let known = known + f64::EPSILON * posture.contacts()[i].point[0].abs();
                place.sides = place.sides.map(|side| if side <= known { 0.0 } else { side });
            }
            let (place_terms, spin) = (b.abs() + c.abs() + posture.size(), b * state.qdot.z);
            let rounding = Rounding::new(
                state.q.xy().norm() + place_terms,
                state.qdot.xy().norm() + spin.abs(),
            );
            ContactState {
                normal,
                tangent,
                friction,
                b,
                c,
                held: None,
                place,
                h,
                depth: 0.0,
                u,
                rounding,
            }
        });
        let mut start = BodyState {
            points: points.collect(),
            center: Center { r: state.q.xy(), v: state.qdot.xy() },
            spin: Spin { theta: state.q.z, omega: state.qdot.z },
            rho2: posture.gyration_squared(),
            fall: Vector2::new(0.0, -posture.fields().gravity),
            gravity: posture.fields().gravity,
            frozen: local.then_some(0.0),
        };
        for i in 0..start.points.len() {
            if start.points[i].h > 0.0 {
                start.put_between_lines(i, posture);
            }
        }
        start
    }

    /// Whether a motion has at most two contacts, frictionless Newton impacts and terrain without ends. Two contacts at one
    /// point (ψ = 1) are excluded: no impact separates them.
    pub(crate) fn is_pair(posture: &Posture, options: &Options) -> bool {
        let apart = match posture.geometry() {
            [one, two] => one.apart(two, 1.0) > 0.0,
            few => few.len() <= 1,
        };
        apart && options.is_frictionless() && posture.ground(0).is_none()
    }

    /// The driver of such a motion.
    pub(crate) fn driver<'c>(
        self,
        posture: &Posture,
        state: &State,
        options: &Options,
        cancel: &'c dyn Fn() -> bool,
    ) -> Driver<'c, Pair> {
        let Self { model, heights, rates, warnings, .. } = self;
        let body =
            PairBody::new(posture.geometry(), posture.gyration_squared(), posture.fields().gravity);
        let base = Base::of_body(posture, body, state);
        let mut gaps = Gaps { h: [f64::INFINITY; 2], u: [0.0; 2] };
        for (i, (h, u)) in heights.into_iter().zip(rates).enumerate() {
            (gaps.h[i], gaps.u[i]) = (h, u);
        }
        let (center, spin) = (base.center(), base.spin());
        let start = Snapshot { gaps, center, spin, ..Snapshot::default() };
        let first = match model {
            Model::Local => {
                let nominal = FullState::new(body, gaps, Center::default(), Spin::default());
                Frame::frozen(start, &nominal)
            }
            _ => Frame::full(start),
        };
        Driver::new(first, base, options, warnings, cancel)
    }
}

/// The motion of the gaps and of θ from a state on. `theta` in rad, `omega` in rad/s.
///
/// # Errors
///
/// A wrong option, a state that is not finite, or a negative gap.
pub fn simulate_local(
    model: &LocalModel,
    gaps: [f64; 2],
    rates: [f64; 2],
    theta: f64,
    omega: f64,
    options: &Options,
) -> Result<Trajectory, Error> {
    simulate_local_until(model, gaps, rates, theta, omega, options, &|| false)
        .map(|run| run.unwrap_or_else(|| unreachable!("nothing cancels this run")))
}

/// As [`simulate_local`]. `cancel` is called from time to time; once it returns true, the result is `None`.
///
/// # Errors
///
/// As [`simulate_local`].
pub fn simulate_local_until(
    model: &LocalModel,
    gaps: [f64; 2],
    rates: [f64; 2],
    theta: f64,
    omega: f64,
    options: &Options,
    cancel: &dyn Fn() -> bool,
) -> Result<Option<Trajectory>, Error> {
    let (gaps, rates) = (gaps.unsigned_zero(), rates.unsigned_zero());
    let theta = finite("theta", theta)?.unsigned_zero();
    let omega = finite("omega", omega)?.unsigned_zero();
    let (h, warnings) = checked(model, gaps, rates, options)?;
    let base = Base::of_parameters(model, gaps, rates, [theta, omega]);
    let gaps = Gaps { h, u: rates };
    let start = Snapshot { gaps, spin: base.spin(), ..Snapshot::default() };
    let first = Frame::reduced(start, model);
    let mut driver = Driver::new(first, base, options, warnings, cancel);
    if driver.run().is_none() {
        return Ok(None);
    }
    let run = Trajectory::new(driver.record, Model::Local, "given by its parameters", *options);
    if !options.certify {
        return Ok(Some(run));
    }
    let enclosure = enclosure::enclose_given(model, h, rates, options, cancel);
    Ok(enclosure.map(|enclosure| run.with(enclosure)))
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
    let least = model.gravity().into_iter().filter(|g| *g > 0.0).fold(f64::INFINITY, f64::min);
    returns("largest of rates times the larger psi", gain * most(rates), least)?;
    let warnings = touch(&mut gaps, 0.0)?;
    clatters([0, 1].map(|i| (gaps[i], rates[i], model.gravity()[i])))?;
    Ok((gaps, warnings))
}

/// Largest angular velocity ω, in rad/s, and largest product of ω and the size of the body, in m/s. The forces on dependent contacts
/// contain ω⁴, which must not overflow.
const FASTEST_SPIN: f64 = 1e70;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::auto::tests::standing;
    use crate::body::GroundKind;
    use crate::body::contact::Contact;
    use crate::body::posture::PostureFields;
    use crate::options::{MOST_RECORDED, Stop};
    use crate::outcome::Outcome;
    use crate::tolerance::{SHADOW_SAFETY, UNFOLLOWED_PART};

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
            terrain: Vec::new(),
            ground: GroundKind::Shared,
            outline: Vec::new(),
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

    /// Simulates a scene in both models and compares the estimated error with the difference of the results.
    #[test]
    fn the_error_is_the_difference_of_the_models() {
        let feet = [(-0.5, 0.0), (0.4, 0.0)];
        let valley = [(-0.5, -0.3), (0.4, 0.2)];
        let mut compared = 0;
        for (feet, friction, stop) in [
            (&feet, 0.0, Stop::Zeno),
            (&feet, 0.5, Stop::Rest),
            (&valley, 0.0, Stop::Zeno),
            (&valley, 0.6, Stop::Rest),
        ] {
            for scale in [1e-6, 1e-4, 1e-3] {
                let posture = standing(feet, friction, 0.3);
                let state = State::at_rest([0.0, 2.0 * scale, 0.7 * scale]);
                let options = Options { model: Model::Local, stop, ..Options::default() };
                let local = simulate(&posture, &state, &options).unwrap();
                let full =
                    simulate(&posture, &state, &Options { model: Model::Full, ..options }).unwrap();
                let size = posture.size();
                let off = full.state().q - local.state().q;
                let moved = (libm::hypot(off.x, off.y) / size).max(off.z.abs());
                let zeno = [&local, &full].map(|run| run.zeno_points().last().unwrap().elapsed);
                let late = (full.elapsed() - local.elapsed()).abs().max((zeno[1] - zeno[0]).abs());
                let truth = moved.max(late / local.elapsed());
                let loose = Options { tolerance: 1e-2, ..options };
                if let Ok(error) = local.shadow_error(&state, &loose) {
                    assert!(truth <= error, "{feet:?} {scale}: {truth} {error}");
                    let rest = SHADOW_SAFETY * loose.tolerance * 4.0 * UNFOLLOWED_PART;
                    assert!(
                        error <= SHADOW_SAFETY * 1.1 * truth + rest,
                        "{feet:?} {scale}: {truth} {error}"
                    );
                    compared += 1;
                }
            }
        }
        assert!(compared >= 8, "{compared}");
    }

    #[test]
    fn the_tolerance_decides() {
        let posture = standing(&[(-0.5, 0.0), (0.4, 0.0)], 0.4, 0.3);
        let state = State::at_rest([0.0, 2e-5, 7e-6]);
        let run = |tolerance| {
            simulate(&posture, &state, &Options { tolerance, ..Options::default() }).unwrap()
        };
        let (loose, tight) = (run(1e-3), run(1e-12));
        assert_eq!((loose.model(), tight.model()), (Model::Local, Model::Full));
        let off = (loose.elapsed() - tight.elapsed()).abs() / tight.elapsed();
        assert!(off > 1e-9 && off < 1e-3, "{off}");
        assert!(loose.model_reason().contains("below the tolerance"));
        assert!(tight.model_reason().contains("turns too far"));
    }

    fn fall(model: Model, record: bool) -> Driver<'static, Pair> {
        let rod = Posture::rod(0.5, 0.3, 0.6, 0.3, 9.81).expect("a rod");
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
