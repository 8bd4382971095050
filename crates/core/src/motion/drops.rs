//! Drops of a body on two contacts whose impacts have no friction, for their end alone: the fast loops over collisions and the sums of
//! [`plain`](super::plain), on the gaps and the place of the body, up to rest. A [`Driver`] takes up every other motion.

use nalgebra::{Vector2, Vector3};

use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::rows_of;
use crate::body::state::State;
use crate::collisions::full::{FullCollisions, FullState, PairBody};
use crate::collisions::local::{LocalCollisions, LoopExit};
use crate::collisions::log::{Center, Log, Spin};
use crate::error::Error;
use crate::math::turn::Turn;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::Mode;
use crate::motion::bounces::MANY_BOUNCES;
use crate::motion::driver::Driver;
use crate::motion::ground_watch::GroundWatch;
use crate::motion::moving::Moving;
use crate::options::{Edges, Model, Options, Stop};
use crate::outcome::{ContactSet, End, FirstZeno, Outcome};
use crate::sustained::frozen::{GapRow, gap_model_of_two, hit, lie};
use crate::sustained::{lies_level, state_at, still_speed};
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// Largest and smallest coordinate, speed, gap and gravity of a start that is followed here, in SI units, unless zero: products of them are
/// far from the range of doubles.
const ORDINARY: f64 = 1e9;

/// What drops of one posture have in common.
pub(crate) struct Drops {
    /// The options, which act.
    pub(crate) options: Options,
    pair: PairBody,
    /// Size of the body, in m.
    size: f64,
    watch: GroundWatch,
    /// The constants of the local model.
    rows: Option<Rows>,
}

/// The rows of two contacts in the local model, and what they need.
struct Rows {
    normals: [Vector3<f64>; 2],
    /// 1/W_ii
    shares: [f64; 2],
    offsets: [f64; 2],
    pull: Vector3<f64>,
    model: FrozenModel,
    reach: f64,
    largest_pull: f64,
    rho: f64,
}

/// A flight that has not ended at rest: a driver goes on from its end.
pub(crate) struct Flight<'c> {
    log: Log<'c>,
    exit: LoopExit,
    end: FlightEnd,
}

#[expect(clippy::large_enum_variant, reason = "it is boxed as a whole, once a run")]
enum FlightEnd {
    /// Of constant rows: the duration, the effects of the impacts, and the gaps.
    Frozen { dt: f64, sum: Impulses, gaps: Gaps },
    /// Of a body that turns; with the model of its gaps if its geometry has been frozen at the end.
    Turning { state: FullState, model: Option<FrozenModel> },
}

/// How a drop goes on.
pub(crate) enum Dropped<'c> {
    /// It has come to rest.
    Rests(End),
    /// A driver goes on from here.
    Flies(Box<Flight<'c>>),
    /// A driver follows it from its start.
    Other,
}

impl Drops {
    /// Of a posture that can be simulated with these options, which act. `None`: no drop of it is followed here.
    pub(crate) fn new(posture: &Posture, options: Options) -> Option<Self> {
        let [one, two] = posture.geometry() else { return None };
        let ordinary = |size: f64| (1.0 / ORDINARY..=ORDINARY).contains(&size);
        let followed = options.stop == Stop::Rest
            && !options.record
            && !options.certify
            && options.sensitivity_limit.is_none()
            && options.neighbourhood == f64::INFINITY
            && ordinary(posture.fields().gravity)
            && ordinary(posture.size())
            && posture.fields().outline.is_empty()
            && one.friction == 0.0
            && two.friction == 0.0
            && posture.has_constant_rows()
            && options.is_plain(posture);
        if !followed {
            return None;
        }
        let (rho2, gravity) = (posture.gyration_squared(), posture.fields().gravity);
        Some(Self {
            options,
            pair: PairBody::new(posture.geometry(), rho2, gravity),
            size: posture.size(),
            watch: GroundWatch::new(Some(posture), options.edges == Edges::Contact),
            rows: Rows::new([one, two], rho2.sqrt(), gravity),
        })
    }

    /// A drop of this posture from this start, in this model.
    pub(crate) fn follow<'c>(
        &self,
        posture: &Posture,
        model: Model,
        start: &State,
        cancel: &'c dyn Fn() -> bool,
    ) -> Dropped<'c> {
        let near = |q: &Vector3<f64>| !self.watch.is_on() || self.watch.is_near(posture, q);
        let Some(gaps) = self.gaps(model, start).filter(|_| near(&start.q)) else {
            return Dropped::Other;
        };
        let options = &self.options;
        let mut log = Log::new(options, 2, cancel);
        if !log.step() {
            return Dropped::Other;
        }
        log.enter(&[Mode::Separate; 2]);
        let ended = match model {
            Model::Local => self.local(start, gaps, &mut log, &near),
            _ => self.full(start, gaps, &mut log, &near),
        };
        match ended {
            Ok(mut state) => {
                state.qdot.fill(0.0);
                let (time, elapsed) = (options.clock(log.clock), log.clock.hi);
                Dropped::Rests(End {
                    outcome: Outcome::Rest,
                    time,
                    elapsed,
                    state: state.unsigned_zero(),
                    touching: ContactSet::of_gaps(&[0.0; 2]),
                    zeno: Some(FirstZeno { count: 2, contact: None, time, elapsed }),
                    collisions: log.hits,
                    warned: false,
                })
            }
            Err(Some(way)) => Dropped::Flies(Box::new(Flight { log, exit: way.0, end: way.1 })),
            Err(None) => Dropped::Other,
        }
    }

    /// Gaps and rates at this start, if the contacts are in the air and all numbers are ordinary ones.
    fn gaps(&self, model: Model, start: &State) -> Option<Gaps> {
        let turn = (model != Model::Local).then(|| Turn::by(start.q.z));
        let State { q, qdot } = start;
        let numbers = [q.x, q.y, q.z, qdot.x, qdot.y, qdot.z];
        let ordinary = |x: f64| x == 0.0 || (1.0 / ORDINARY..=ORDINARY).contains(&x.abs());
        let mut gaps = Gaps::default();
        for (i, k) in self.pair.contacts.iter().enumerate() {
            (gaps.h[i], gaps.u[i]) = match &turn {
                Some(turn) => (k.gap(q, turn), k.gap_rate(qdot, turn)),
                None => (k.local_gap(q), k.local_rate(qdot)),
            };
        }
        let high = gaps.h.iter().all(|h| *h >= 1.0 / ORDINARY);
        (high && numbers.into_iter().all(ordinary)).then_some(gaps)
    }

    /// The end at rest of a drop in the local model, or how it goes on, see [`Flight`].
    fn local(
        &self,
        start: &State,
        mut gaps: Gaps,
        log: &mut Log,
        near: &dyn Fn(&Vector3<f64>) -> bool,
    ) -> Result<State, Option<Box<(LoopExit, FlightEnd)>>> {
        let Some(rows) = &self.rows else { return Err(None) };
        let model = &rows.model;
        let place = |of: &Vector3<f64>| Vector3::new(of.x, of.y, rows.rho * of.z);
        let (mut y, mut v) = (place(&start.q), place(&start.qdot));
        let fastest = rows.reach * v.norm();
        let mut sum = Impulses::default();
        let exit = match LocalCollisions::begin(model, &mut gaps, &mut sum, log) {
            Ok(collisions) => {
                if self.watch.is_on() {
                    let (mut y, mut v) = (y, v);
                    rows.fly(&mut y, &mut v, log.clock.hi, &sum, &gaps);
                    if !near(&rows.q(&y)) {
                        return Err(None);
                    }
                }
                collisions.run(model, &mut gaps, &mut sum, log)
            }
            Err(exit) => exit,
        };
        let dt = log.clock.hi;
        if let Some(left) = exit.time_to_rest() {
            rows.fly(&mut y, &mut v, dt, &sum, &gaps);
            rows.fly(&mut y, &mut v, left, &model.settle(&gaps, left), &Gaps::default());
            let (q, clock) = (rows.q(&y), log.clock.after(left));
            let slow = rows.reach * v.norm() <= still_speed(fastest, rows.largest_pull, clock);
            if slow && rows.lies() && near(&q) && log.step() {
                log.clock = clock;
                return Ok(State { q, qdot: v });
            }
        }
        Err(Some(Box::new((exit, FlightEnd::Frozen { dt, sum, gaps }))))
    }

    /// The same in the full model.
    fn full(
        &self,
        start: &State,
        gaps: Gaps,
        log: &mut Log,
        near: &dyn Fn(&Vector3<f64>) -> bool,
    ) -> Result<State, Option<Box<(LoopExit, FlightEnd)>>> {
        let center = Center { r: start.q.xy(), v: start.qdot.xy() };
        let spin = Spin { theta: start.q.z, omega: start.qdot.z };
        let fastest = center.v.norm() + self.size * spin.omega.abs();
        let mut state = FullState::new(self.pair, gaps, center, spin);
        let mut exit = LoopExit::Freeze;
        if !state.may_freeze(log) {
            let Some(end) = collide(&mut state, log, near) else { return Err(None) };
            exit = end;
        }
        let mut frozen = None;
        if exit == LoopExit::Freeze {
            let (model, clock) = (state.model(), log.clock);
            let (mut gaps, mut sum) = (state.gaps, Impulses::default());
            exit = match LocalCollisions::begin(&model, &mut gaps, &mut sum, log) {
                Ok(collisions) => collisions.run(&model, &mut gaps, &mut sum, log),
                Err(exit) => exit,
            };
            state = state.renewed().hit(&model, log.clock.since(clock), &sum, &gaps);
            frozen = Some(model);
        }
        if let Some(left) = exit.time_to_rest() {
            let end = match (exit, frozen) {
                (LoopExit::Regular(_), None) => state.at_rest_after(left),
                _ => {
                    let model = frozen.unwrap_or_else(|| state.model());
                    let own = model.settle(&state.gaps, left);
                    state.renewed().hit(&model, left, &own, &Gaps::default())
                }
            };
            let (FullState { center, spin, b, .. }, clock) = (end, log.clock.after(left));
            let most = center.v.x.abs().max(center.v.y.abs()).max(self.size * spin.omega.abs());
            let (contacts, gravity) = (&self.pair.contacts, self.pair.gravity);
            let levels = [0, 1].map(|i| (contacts[i].friction, contacts[i].normal, b[i]));
            let rests = most <= still_speed(fastest, gravity, clock)
                && lies_level(Vector2::new(0.0, -gravity), gravity, levels, &center.v, spin.omega);
            if rests && near(&end.q()) && log.step() {
                log.clock = clock;
                return Ok(state_at((center, spin)));
            }
        }
        Err(Some(Box::new((exit, FlightEnd::Turning { state, model: frozen }))))
    }
}

/// The fast loop in the geometry that turns. `None`: a driver has to look at its steps.
#[inline(never)] // keeps the registers free for the collisions
fn collide(
    state: &mut FullState,
    log: &mut Log,
    near: &dyn Fn(&Vector3<f64>) -> bool,
) -> Option<LoopExit> {
    let mut collisions = FullCollisions::begin(&state.body, log);
    let exit = loop {
        let next = collisions.next(state, log);
        if !near(&state.q()) || next.is_none() && log.hits >= MANY_BOUNCES {
            return None;
        }
        if let Some(exit) = next.or_else(|| collisions.alternate(state, log)) {
            break exit;
        }
    };
    Some(collisions.end(exit, state, log))
}

impl Rows {
    /// `None`: the normal rows depend on each other.
    fn new(contacts: [&ContactGeometry; 2], rho: f64, gravity: f64) -> Option<Self> {
        let rows = contacts.map(|k| rows_of(k, rho).map(Vector3::from));
        let [normals, tangents] = [1, 0].map(|k| [rows[0][k], rows[1][k]]);
        let pull = Vector3::new(0.0, -gravity, 0.0);
        let all = [normals[0], normals[1], tangents[0], tangents[1]];
        let own = normals.map(|row| row.dot(&row));
        let falls = normals.map(|row| -row.dot(&pull));
        let largest = |of: &dyn Fn(&Vector3<f64>) -> f64| all.iter().map(of).fold(0.0, f64::max);
        Some(Self {
            normals,
            shares: own.map(|own| 1.0 / own),
            offsets: contacts.map(|k| k.offset),
            pull,
            model: gap_model_of_two(
                falls,
                own,
                normals[0].dot(&normals[1]),
                contacts.map(|k| k.restitution),
            )?,
            reach: largest(&|row| row.norm_squared()).sqrt(),
            largest_pull: largest(&|row| row.dot(&pull).abs()),
            rho,
        })
    }

    fn of_gaps(&self) -> [GapRow<'_, Vector3<f64>>; 2] {
        [0, 1].map(|i| GapRow {
            normal: &self.normals[i],
            share: self.shares[i],
            offset: self.offsets[i],
        })
    }

    /// Moves to the end of a flight with impacts, see [`hit`].
    fn fly(
        &self,
        y: &mut Vector3<f64>,
        v: &mut Vector3<f64>,
        dt: f64,
        own: &Impulses,
        gaps: &Gaps,
    ) {
        *y += *v * dt + self.pull * (0.5 * dt * dt);
        *v += self.pull * dt;
        hit([y, v], &self.of_gaps(), &self.model, own, gaps);
    }

    /// Displacement of the centre of mass (m) and rotation.
    fn q(&self, y: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(y.x, y.y, y.z / self.rho)
    }

    /// Whether both contacts, at rest, stay at rest.
    fn lies(&self) -> bool {
        let Self { model, pull, reach, largest_pull, .. } = self;
        lie(&self.of_gaps(), model, pull, *reach, *largest_pull) == Some(true)
    }
}

impl<'c> Driver<'c> {
    /// The end of an unrecorded run that goes on from the end of this flight, its first.
    pub(crate) fn end_after(&mut self, flight: Flight<'c>) -> Result<End, Error> {
        let Flight { log, exit, end } = flight;
        self.begin();
        (self.log, self.fresh) = (log, false);
        let left = self.has_left();
        debug_assert!(!left, "a drop without a neighbourhood");
        let end = match end {
            FlightEnd::Frozen { dt, sum, gaps } => match self.plain_model() {
                Some(model) => {
                    self.hit(&model, dt, &sum, &gaps);
                    self.land(exit, &model)
                }
                None => None,
            },
            FlightEnd::Turning { state, model } => {
                if let Moving::Turning(body) = &mut self.state {
                    body.follow(&state);
                }
                match model {
                    Some(model) => self.land(exit, &model),
                    None => self.land_turning(exit, &state),
                }
            }
        };
        let outcome = end.unwrap_or_else(|| self.motion());
        self.finish(outcome)
    }
}
