//! The motion of a run at any times.

use std::borrow::Cow;

use crate::body::posture::Posture;
use crate::body::state::State;
use crate::body::{ContactSpace, Mechanism};
use crate::collisions::log::{Center, Spin};
use crate::error::Error;
use crate::math::clock::Clock;
use crate::math::roots::ORDER;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{Mode, Word, mechanism_forces};
use crate::motion::moving::Moving;
use crate::motion::record::{Motion, Record, Tail};
use crate::motion::replay::{followed, lead, replayed};
use crate::options::Model;
use crate::outcome::{Instant, Outcome};
use crate::simulate::start::Start;
use crate::simulate::trajectory::{Flight, Piece, Trajectory};
use crate::sustained::flight::flown;
use crate::sustained::{BodyState, Step, state_at};
use crate::tolerance::STILL;

/// The motion of a run at times in any order, from [`Trajectory::reader`]. Each time has the same result as alone, to the last bit.
///
/// It keeps the piece of smooth motion of the last time, with what has been computed of it. Therefore many times are read
/// fastest in their order.
///
/// ```
/// use standfast::{Lamina, Options, Posture, State, simulate};
///
/// let lamina = Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() };
/// let rod = Posture::rod(0.5, &lamina)?;
/// let run = simulate(&rod, &State::at_rest([0.0, 0.011, 0.002]), &Options::default())?;
/// let mut reader = run.reader();
/// for t in run.times(100) {
///     assert_eq!(reader.at(t)?, run.at(t)?);
/// }
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    run: &'a Trajectory,
    /// Index of the piece of the last time.
    index: usize,
    held: Option<Held<'a>>,
    /// Of a sum that is followed event by event: the run of a part of it, and the time up to which this goes, in s since the start of the sum.
    sum: Option<(f64, Box<Trajectory>)>,
}

/// The run of a part of a sum, up to the time `until` in s since its start; `None` if too many events come before.
fn part_of_sum(
    run: &Trajectory,
    start: Moving,
    fastest: f64,
    until: f64,
) -> Option<Box<Trajectory>> {
    let (record, options) = replayed(start, fastest, &run.record.subject, run.options(), until)?;
    Some(Box::new(Trajectory::new(record, run.model(), run.model_reason(), options)))
}

impl Trajectory {
    /// The state `dt` after the start of the run of a part of a sum.
    fn within(&self, dt: f64) -> Option<Now<'static>> {
        let pieces = self.pieces().ok()?;
        let k = pieces.partition_point(|piece| piece.clock.hi <= dt).max(1) - 1;
        let since = Clock { hi: dt, lo: 0.0 }.since(pieces.get(k)?.clock).max(0.0);
        let mut reader = Reader::new(self);
        let (state, modes) = reader.moving(k, since)?;
        Some((state, Cow::Owned(modes.into_owned())))
    }
}

/// The state at an instant, with the mode of each of its points.
pub(super) type Now<'a> = (Moving, Cow<'a, [Mode]>);

impl Trajectory {
    /// The motion of the run at any times; faster than the functions below if there are many.
    #[must_use]
    pub fn reader(&self) -> Reader<'_> {
        Reader::new(self)
    }
}

impl<'a> Reader<'a> {
    pub(super) fn new(run: &'a Trajectory) -> Self {
        Self { run, index: 0, held: None, sum: None }
    }

    /// The motion at time `t` on the clock, exact within a phase. At the time of an impact: after it. After the end of a run that came to rest
    /// ([`Outcome::Rest`]) it is the state of rest.
    ///
    /// The last time is [`Trajectory::time`] itself: a sum or a product that should give it may be rounded up, and then lies outside the run.
    /// [`Trajectory::times`] gives equally spaced times with the exact end.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] if nothing was recorded, if `t` lies outside the run, or if `t` lies so close to the end of a sum of
    /// impacts that more than 100 000 events of the sum (20 million of two contacts in the local model) come before it.
    pub fn at(&mut self, t: f64) -> Result<Instant, Error> {
        let (now, Record { subject, end, .. }) = (self.now(t)?, &*self.run.record);
        let feet = subject.feet();
        let Some((state, _)) = now else { return Ok(end.instant(feet)) };
        let (gaps, rates): (Vec<f64>, Vec<f64>) = match (&state, subject.posture()) {
            (Moving::Turning(body), Some(posture)) => body.gaps_and_rates(posture),
            _ => subject
                .per_contact(|i| state.point(i))
                .map(|(h, u)| (h.unsigned_zero(), u.unsigned_zero()))
                .unzip(),
        };
        let [gaps, rates] = [gaps, rates].map(|values| feet.means(&values));
        Ok(Instant { state: subject.state_of(&state), gaps, rates })
    }

    /// q and q̇ at time `t`; without a body only θ and ω are defined. As [`at`](Self::at), without the gaps.
    ///
    /// # Errors
    ///
    /// As [`at`](Self::at).
    pub fn state(&mut self, t: f64) -> Result<State, Error> {
        if t < self.run.time()
            && let Some((k, dt)) = self.piece_at(t)?
            && let Some(place) = self.flown(k, dt)
        {
            self.go_to(k);
            return Ok(state_at(place));
        }
        Ok(match self.now(t)? {
            None => self.run.record.end.state,
            Some((state, _)) => self.run.record.subject.state_of(&state),
        })
    }

    /// The centre of mass and the rotation of a body `dt` after the start of piece `k`, if it flies.
    fn flown(&self, k: usize, dt: f64) -> Option<(Center, Spin)> {
        let (piece, record) = (self.run.pieces().ok()?.get(k)?, &self.run.record);
        let motion = &record.spans[piece.span].motion;
        let start = motion.start().turning().filter(|body| !body.fall_changes())?;
        let place = match (&piece.flight, motion) {
            (Some(Flight::Body(index)), _) => *record.bodies.get(*index)?,
            (None, Motion::Modes { word, .. })
                if word.iter().all(|mode| *mode == Mode::Separate) =>
            {
                start.place()
            }
            _ => return None,
        };
        Some(flown(place, start.fall, dt))
    }

    /// Keeps what is known of piece `k` alone.
    fn go_to(&mut self, k: usize) {
        if k != self.index {
            (self.index, self.held, self.sum) = (k, None, None);
        }
    }

    /// q and q̇ at time `t`: of a body three values, of a mechanism one for each coordinate; `None` for a model without a body.
    ///
    /// # Errors
    ///
    /// As [`at`](Self::at).
    pub fn coordinates(&mut self, t: f64) -> Result<Option<[Vec<f64>; 2]>, Error> {
        let Some(start) = self.run.record.subject.mechanism() else {
            let State { q, qdot } = self.state(t)?;
            return Ok(self.run.posture().map(|_| [q, qdot].map(|v| v.as_slice().to_vec())));
        };
        let elapsed = t - self.run.options().time;
        Ok(match self.now(t)? {
            Some((Moving::Frozen(rows), _)) => Some(start.coordinates(&rows, elapsed)),
            _ => self.run.coordinates(),
        })
    }

    /// The body at time `t`; `None` at the end of the run.
    fn now(&mut self, t: f64) -> Result<Option<Now<'a>>, Error> {
        let piece = self.piece_at(t)?;
        if t >= self.run.time() {
            return Ok(None);
        }
        piece.and_then(|(k, dt)| self.moving(k, dt)).map(Some).ok_or_else(|| too_deep(t))
    }

    /// The index of the piece of the motion at time `t`, and the time since its start; `None` if the run ends at its start.
    fn piece_at(&mut self, t: f64) -> Result<Option<(usize, f64)>, Error> {
        let pieces = self.run.pieces()?;
        let (start, end) = (self.run.options().time, self.run.time());
        let rests = self.run.outcome() == Outcome::Rest;
        if !(t >= start && (t <= end || rests)) {
            return Err(Error::Unusable {
                field: "t".into(),
                value: format!("{t:?}"),
                allowed: if rests {
                    format!("from {start:?} on: at rest from {end:?} on")
                } else {
                    format!("from {start:?} to {end:?}, the time of the run")
                },
            });
        }
        let last = self.run.record.end.clock;
        if t >= end {
            let since = |piece: &Piece| (pieces.len() - 1, last.since(piece.clock).max(0.0));
            return Ok(pieces.last().map(since));
        }
        let elapsed = t - start;
        let begun = |k: usize| pieces.get(k).is_some_and(|piece| piece.clock.hi <= elapsed);
        let next = if begun(self.index) && !begun(self.index + 1) {
            self.index + 1
        } else {
            pieces.partition_point(|piece| piece.clock.hi <= elapsed)
        };
        let k = next.max(1) - 1;
        // The clock of the pieces is more precise than `t`: no piece is followed beyond its end.
        let end = pieces.get(next).map_or(last, |next| next.clock);
        let dt = Clock { hi: elapsed, lo: 0.0 }.since(pieces[k].clock);
        Ok(Some((k, dt.min(end.since(pieces[k].clock)).max(0.0))))
    }

    /// The motion with which a piece begins; `None`: it begins with a flight after a collision.
    fn motion(&self, k: usize) -> Option<&'a Motion> {
        let piece = self.run.pieces().ok()?.get(k)?;
        piece.flight.is_none().then(|| &self.run.record.spans[piece.span].motion)
    }

    /// The body `dt` after the start of piece `k`; `None` if too many events of a sum come before.
    pub(super) fn moving(&mut self, k: usize, dt: f64) -> Option<Now<'a>> {
        self.go_to(k);
        let Record { subject, spans, .. } = &*self.run.record;
        let piece = self.run.pieces().ok()?.get(k)?;
        if let Some(flight) = &piece.flight {
            let start = spans[piece.span].motion.start();
            let state = match (flight, start) {
                (Flight::Body(index), Moving::Turning(start)) => {
                    Moving::Turning(Box::new(self.run.after_collision(start, *index)?))
                }
                (Flight::Rows(rows), _) => Moving::Frozen(rows.clone()),
                (Flight::Body(_), Moving::Frozen(_)) => return None,
            };
            let modes = vec![Mode::Separate; state.count()];
            return Some((state.flown(dt), Cow::Owned(modes)));
        }
        Some(match &spans[piece.span].motion {
            Motion::Modes { start: Moving::Turning(body), word, .. } => {
                let held = self.held.get_or_insert_with(|| Held::new(body, word));
                let mut now = held.at(dt);
                if held.kind == Kind::Flight
                    && let Some(posture) = subject.posture()
                {
                    now.look_below(posture);
                }
                (Moving::Turning(Box::new(now)), Cow::Borrowed(word))
            }
            Motion::Modes { start: Moving::Frozen(rows), word, acceleration } => {
                let state = rows.after(word, acceleration.as_ref()?, dt);
                (Moving::Frozen(Box::new(state)), Cow::Borrowed(word))
            }
            Motion::Sum { start, fastest, tail } => {
                if *tail == Tail::Collisions {
                    return self.replay(k, dt);
                }
                let (state, left) = lead(start, *tail, subject, dt)?;
                if matches!(tail, Tail::Bounce { .. }) {
                    let modes = vec![Mode::Separate; state.count()];
                    return Some((state.flown(left), Cow::Owned(modes)));
                }
                part_of_sum(self.run, state, *fastest, left)?.within(left)?
            }
        })
    }

    /// The state `dt` after the start of piece `k`, a sum that is followed event by event. The run of a part of it is kept: of the first half, or
    /// of the first three quarters, seven eighths, …. It depends on `dt` alone, so that a time has the same bits in any order.
    fn replay(&mut self, k: usize, dt: f64) -> Option<Now<'a>> {
        let (pieces, record) = (self.run.pieces().ok()?, &self.run.record);
        let Motion::Sum { start, fastest, .. } = &record.spans[pieces[k].span].motion else {
            return None;
        };
        let end = pieces.get(k + 1).map_or(record.end.clock, |next| next.clock);
        let (duration, mut left) = (end.since(pieces[k].clock), 0.5);
        while dt > duration * (1.0 - left) && left > f64::EPSILON {
            left *= 0.5;
        }
        let until = (duration * (1.0 - left)).max(dt);
        if self.sum.as_ref().is_none_or(|(known, _)| *known != until) {
            let Some(part) = part_of_sum(self.run, start.clone(), *fastest, until) else {
                let state =
                    followed(start.clone(), *fastest, &record.subject, self.run.options(), dt)?;
                let modes = vec![Mode::Separate; state.count()];
                return Some((state, Cow::Owned(modes)));
            };
            self.sum = Some((until, part));
        }
        self.sum.as_ref()?.1.within(dt)
    }

    /// The contact forces of the smooth motion at time `t`, (tangential, normal) by contact of [`Trajectory::contacts`] in N, each in the axes
    /// of the piece of terrain, or of the side of the body, that touches. They satisfy the equation of motion with the rows of the contacts,
    ///
    /// ```text
    /// M q̈ = (0, −m g, 0) + Σ_i (T_iᵀ f_t,i + N_iᵀ f_n,i)
    /// ```
    ///
    /// and are zero in flight. Impacts have impulses instead, see [`Trajectory::impacts`]; at the time of an impact or of a change of the
    /// contact modes, the forces are those after it. Where the equation allows several forces (hyperstatic phases), these are the ones with
    /// the least Σ|f|² in the friction cones (in a build without the feature `qp` and with three or more contacts: any). In a vertex, where a
    /// contact touches two pieces, it is the sum of both forces, in the axes of the first piece.
    /// A disc touches the two pieces with two points of its rim: the sum has their force and not their moment.
    ///
    /// They are NaN for a model without a body, where no forces cause the motion (at the singularity of a jam), and at the end of a run
    /// that does not determine what follows: at the Zeno point of [`Stop::Zeno`](crate::Stop::Zeno), and if it is inconsistent or ambiguous.
    ///
    /// # Errors
    ///
    /// As [`at`](Self::at).
    pub fn forces(&mut self, t: f64) -> Result<Vec<[f64; 2]>, Error> {
        let count = self.run.count() + self.run.record.sides.len();
        let unknown = || Ok(vec![[f64::NAN; 2]; count]);
        let piece = self.piece_at(t)?;
        let Some((k, dt)) = piece else { return unknown() };
        let open = [Outcome::Zeno, Outcome::Inconsistent, Outcome::Ambiguous];
        let sum = || matches!(self.motion(k), Some(Motion::Sum { .. }));
        if t >= self.run.time() && (open.contains(&self.run.outcome()) || sum()) {
            return unknown();
        }
        if let Some(mechanism) = self.run.mechanism() {
            let Some((Moving::Frozen(now), modes)) = self.moving(k, dt) else {
                return Err(too_deep(t));
            };
            let forces = forces_of(mechanism, now.space(), &modes);
            return Ok(forces.unwrap_or(vec![[f64::NAN; 2]; count]));
        }
        let subject = &self.run.record.subject;
        let Some(posture) = subject.posture() else { return unknown() };
        let (mut body, mut modes) = match self.moving(k, dt).ok_or_else(|| too_deep(t))? {
            (Moving::Turning(body), modes) => (*body, modes),
            (Moving::Frozen(state), modes) => {
                // The forces are those of the nominal posture.
                let State { q, qdot } = subject.state(&state);
                let straight = |v: nalgebra::Vector3<f64>| [v.x, v.y, 0.0];
                let at = State::new(straight(q), straight(qdot));
                let (gaps, rates): (Vec<f64>, Vec<f64>) =
                    subject.per_contact(|i| state.points[i]).map(|p| (p.h, p.u)).unzip();
                let mut body = Start::body_state(posture, &at, &gaps, &rates);
                let mut pull = state.space().pull().iter();
                let fall = nalgebra::Vector2::from_fn(|_, _| pull.next().unwrap_or(0.0));
                body.set_fall(fall, nalgebra::Vector2::zeros());
                (body, modes)
            }
        };
        let feet = posture.feet();
        if !feet.is_empty() {
            body.set_on(feet);
            modes = feet.modes(&modes, Mode::Separate).collect();
        }
        let mut forces = body.forces(self.run.posture().unwrap_or(posture), &modes)?;
        forces.resize(count, [0.0; 2]);
        Ok(forces)
    }

    /// The positions (x, y) of the contact points of [`Trajectory::contacts`] at time `t`, world axes, in m: x_i + r + (R(θ) − 1) d_i, in the
    /// local model x_i + r + θ (−d_y, d_x); for sides, the corners of the ground. NaN for a model without a body.
    ///
    /// # Errors
    ///
    /// As [`at`](Self::at).
    pub fn points(&mut self, t: f64) -> Result<Vec<[f64; 2]>, Error> {
        let (State { q, .. }, run) = (self.state(t)?, self.run);
        let corners = run.record.sides.iter().map(|(corner, _)| [corner.x, corner.y]);
        let points = |p: &Posture| {
            let own = p.points(&q, run.model() == Model::Local).into_iter();
            own.chain(corners).collect()
        };
        Ok(run.posture().map_or_else(|| vec![[f64::NAN; 2]; run.count()], points))
    }

    /// Energy ½m(|ṙ|² + ρ²θ̇²) + m g r_y at time `t`, in J; of a mechanism ½ q̇ᵀM q̇ − loadᵀq; NaN for a model without a body.
    ///
    /// # Errors
    ///
    /// As [`at`](Self::at).
    pub fn energy(&mut self, t: f64) -> Result<f64, Error> {
        if let Some(mechanism) = self.run.mechanism() {
            let [q, qdot] = self.coordinates(t)?.unwrap_or_default();
            return Ok(mechanism.energy(&q, &qdot));
        }
        let State { q, qdot } = self.state(t)?;
        Ok(self.run.posture().map_or(f64::NAN, |posture| posture.energy(&q, &qdot)))
    }
}

fn word(modes: &[Mode]) -> Word {
    let letters = modes.iter().enumerate();
    letters.fold(Word::separate(modes.len()), |word, (k, mode)| word.with(k, *mode))
}

/// The forces (tangential, normal) of the contacts of a mechanism in these modes, in N; `None` where no forces cause the motion.
fn forces_of(mechanism: &Mechanism, space: &ContactSpace, modes: &[Mode]) -> Option<Vec<[f64; 2]>> {
    let friction: Vec<f64> = mechanism.contacts().iter().map(|contact| contact.friction).collect();
    // Without friction a fixed contact has a normal force only, like a sliding one.
    let pressed = |(mode, mu): (&Mode, &f64)| match mode {
        Mode::Fixed if *mu == 0.0 => Mode::Right,
        mode => *mode,
    };
    let modes: Vec<Mode> = modes.iter().zip(&friction).map(pressed).collect();
    mechanism_forces(space, &friction, word(&modes)).map(UnsignedZero::unsigned_zero)
}

/// The state at `t`, within a sum, cannot be computed.
fn too_deep(t: f64) -> Error {
    Error::Unusable {
        field: "t".into(),
        value: format!("{t:?}"),
        allowed: "a time before which fewer collisions of a summed tail take place".into(),
    }
}

/// A piece of motion in one contact mode, with the Taylor series that follow each other in it.
#[derive(Debug, Clone)]
pub(super) struct Held<'a> {
    start: &'a BodyState,
    modes: &'a [Mode],
    kind: Kind,
    /// The states at which the series begin.
    series: Vec<(BodyState, Box<Step>)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Flight,
    /// All contacts are fixed, or the forces are singular.
    Fixed,
    /// Without velocity, and with an acceleration that is rounding error.
    Still,
    Moving,
}

/// Largest number of Taylor series in a piece; the last one is followed to the end. A piece is one step of the motion and needs one or two.
const SERIES: usize = 1000;

/// Number of series of a piece that are kept. Nearly all pieces have one or two, for a step of the motion needs no more; beyond this
/// number they are computed anew for each time.
const KEPT: usize = 8;

impl<'a> Held<'a> {
    pub(super) fn new(start: &'a BodyState, modes: &'a [Mode]) -> Self {
        let mut held = Self { start, modes, kind: Kind::Flight, series: Vec::new() };
        let changes = start.fall_changes();
        if modes.iter().all(|&mode| mode == Mode::Separate) && !changes {
            return held;
        }
        held.kind = Kind::Fixed;
        if held.push(start.clone()) {
            let still = start.center.v == nalgebra::Vector2::zeros() && start.spin.omega == 0.0;
            let [ax, ay, turn] = held.series[0].1.acceleration();
            let most = ax.abs().max(ay.abs()).max(start.rho2.sqrt() * turn.abs());
            let still = still && !changes && most <= STILL * start.gravity;
            held.kind = if still { Kind::Still } else { Kind::Moving };
        }
        held
    }

    /// The series that begins with this state.
    fn next(&self, from: &BodyState) -> Option<Box<Step>> {
        if from.is_fixed(self.modes) && !from.rides(self.modes) {
            None
        } else {
            Step::new(from, self.modes, ORDER)
        }
    }

    /// Keeps the series that begins with this state; false if there is none.
    fn push(&mut self, from: BodyState) -> bool {
        let step = self.next(&from);
        let found = step.is_some();
        self.series.extend(step.map(|step| (from, step)));
        found
    }

    /// The body `dt` after the start. Each series is followed up to its reach, the last one to the end.
    pub(super) fn at(&mut self, dt: f64) -> BodyState {
        match self.kind {
            Kind::Flight => return self.start.flown(dt),
            Kind::Fixed | Kind::Still => {
                let mut body = self.start.clone();
                body.advance_fall(dt);
                return body;
            }
            Kind::Moving => {}
        }
        let (mut left, mut k, mut own) = (dt, 0, None);
        for _ in 0..SERIES {
            let (from, kept) = own.as_ref().unwrap_or_else(|| &self.series[k]);
            let mut late: Option<Box<Step>> = None;
            loop {
                let step = late.as_ref().unwrap_or(kept);
                let Some(longer) = step.longer(from, self.modes, left.min(step.reach())) else {
                    break;
                };
                late = Some(longer);
            }
            let step = late.as_ref().unwrap_or(kept);
            let reach = step.reach();
            if left <= reach {
                return step.at(from, left);
            }
            let after = step.at(from, reach);
            let keeps = late.is_none() && own.is_none() && k + 1 < KEPT;
            let known = keeps && (k + 1 < self.series.len() || self.push(after.clone()));
            if known {
                k += 1;
            } else if let Some(next) = self.next(&after) {
                own = Some((after, next));
            } else {
                break;
            }
            left -= reach;
        }
        let (from, step) = own.as_ref().unwrap_or_else(|| &self.series[k]);
        step.at(from, left)
    }
}
