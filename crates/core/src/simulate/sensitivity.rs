//! How much the end of a run depends on its start: the growth of a small change of the state along the run.
//!
//! A change (δq, δv) of the state at one time moves on as the derivative of the motion. Lengths are over the size of the body, speeds over
//! √(g · size), turns are times ρ. From event to event:
//!
//! ```text
//! flight of τ             δq ← δq + τ δv
//! event of gap h          δτ = −N δq / u⁻           the shift of its time
//!                         δq ← δq + v⁻ δτ,  δv ← δv + a⁻ δτ          at the event
//!                         δv ← δv + δ(Σ Nᵀ P_n + Tᵀ P_t)             by the law of impact
//!                         δq ← δq − v⁺ δτ,  δv ← δv − a⁺ δτ          at one time again
//! contacts begin to hold  the part along their forces is taken off that N δv + δN v = 0, N δq = 0 (and T δv + δT v = 0 if they stick)
//! contacts held for τ     the difference of two motions in the same modes
//! ```
//!
//! The start of the change is one direction, with equal parts in all coordinates and speeds, and signs that a mirror image shares. Growth
//! turns it into the direction that grows fastest. Sums of impacts take off the part along the forces, as bounces in constant geometry do
//! exactly.
//!
//! Rounding errors enter at every event. The error of the end is about ε times the sum of the growths from all events to the end.

use nalgebra::{DMatrix, DVector, Vector2};

use crate::body::contact::{ContactLetters, ContactValues};
use crate::error::Error;
use crate::impact::friction::{self, Matrix, Party};
use crate::impact::together::together;
use crate::math::clock::Clock;
use crate::math::mass_vector::{Coordinates, MassVector, independent};
use crate::math::roots::ORDER;
use crate::modes::Mode;
use crate::motion::moving::Moving;
use crate::motion::record::Motion;
use crate::options::{Impact, Options, Simultaneous};
use crate::outcome::Outcome;
use crate::simulate::reader::{Held, Reader};
use crate::simulate::trajectory::{Flight, Piece, Sensitivity, Trajectory};
use crate::sustained::{BodyState, Step};
use crate::tolerance::{
    CLOCK_ROUNDINGS, FEW_DIGITS, FOLLOWED_GROWTH, FRESH_IMPACT, LASTING_PHASE, SENSITIVITY_STEP,
    SINGULAR_HOLD, SLOW_IMPACT, STILL,
};

/// A change of the state at one time, in the metric of the mass.
#[derive(Debug, Clone)]
struct Change {
    way: Coordinates,
    speed: Coordinates,
}

/// The units of lengths and of speeds.
#[derive(Debug, Clone, Copy)]
struct Scale {
    length: f64,
    speed: f64,
}

impl Change {
    fn size(&self, scale: Scale) -> f64 {
        libm::hypot(self.way.norm() / scale.length, self.speed.norm() / scale.speed)
    }

    fn scale(&mut self, factor: f64) {
        (self.way, self.speed) = (self.way.scaled(factor), self.speed.scaled(factor));
    }
}

/// An impact: the contact; the impulse (tangential, normal) per unit mass or, of a plain impact, the change of the own rate; and the rate
/// before; in m/s.
struct Blow {
    contact: usize,
    impulse: Option<[f64; 2]>,
    jump: f64,
    rate: f64,
}

impl Trajectory {
    /// Growth of a small change of the start up to the end of the run: |δ(end)|/|δ(start)|, dimensionless. Lengths are over the size of the
    /// body, speeds over √(g · size), turns are times ρ; if the run ends at rest, the shift of the time of rest, over √(size/g), is part of δ.
    /// The change has equal parts in all coordinates and their speeds; along the ground and of the turn they have the sign of the arm of the
    /// first contact. In a run with growth it turns into the direction that grows fastest.
    /// ∞ where it is above 1e100. `None` unless recorded, or where a state within a sum of impacts cannot be computed.
    ///
    /// It is computed when it is first asked for, from the record: the derivative of the motion along the run, with the shift of the time of
    /// each impact (saltation). Contacts that land at one instant go on to land at one instant in the changed run.
    ///
    /// ```
    /// use standfast::{Lamina, Options, Posture, State, simulate};
    ///
    /// // A rod that clatters on its ends, with little loss: every impact multiplies a change of the start.
    /// let rod = |restitution| Posture::rod(0.5, &Lamina { restitution, gyration_radius: Some(0.2), ..Lamina::default() });
    /// let start = State::at_rest([0.0, 0.4, 0.3]);
    /// let calm = simulate(&rod(0.1)?, &start, &Options::default())?;
    /// let wild = simulate(&rod(0.99)?, &start, &Options::default())?;
    /// assert!(calm.sensitivity().is_some_and(|growth| growth < 100.0));
    /// assert!(wild.sensitivity().is_some_and(|growth| growth > 1e16));
    /// // Rounding errors grow alike: from this time on not one digit of the state is determined.
    /// assert!(wild.determined_until().is_some_and(|t| t < wild.time()));
    /// assert!(wild.warnings()[0].starts_with("nothing is determined from"));
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn sensitivity(&self) -> Option<f64> {
        self.found_sensitivity().map(|found| found.growth)
    }

    /// Time on the clock from which not one digit of the state is determined, because rounding errors have grown to the size of the body, in s.
    /// `None`: there is none, or nothing was recorded.
    #[must_use]
    pub fn determined_until(&self) -> Option<f64> {
        self.found_sensitivity()?.lost.map(|lost| self.clock(lost))
    }

    /// Estimated error of the time of the end, in s, at most the whole time: that of the sums and of the clock, and ε times the sum of the
    /// growths from each event to the end, times √(size/g). Without a record it does not include the growth.
    #[must_use]
    pub fn time_error(&self) -> f64 {
        let end = self.record.end.clock;
        let sums = self.record.zeno.iter().map(|zeno| zeno.error).fold(0.0, f64::max);
        let late = self.found_sensitivity().map(|found| match found.zeno.last() {
            Some(zeno) if self.outcome() == Outcome::Zeno => found.late.max(*zeno),
            _ => found.late,
        });
        self.error_of(end, sums, late)
    }

    pub(super) fn found_sensitivity(&self) -> Option<&Sensitivity> {
        self.sensitivity.get_or_init(|| of_run(self, f64::INFINITY)).as_ref()
    }

    /// The error of a time: of sums, of the clock, and of what has grown, `late` (s) for errors of size 1.
    pub(super) fn error_of(&self, clock: Clock, sums: f64, late: Option<f64>) -> f64 {
        let grown = late.map_or(0.0, |late| (f64::EPSILON * late).min(clock.hi));
        sums + CLOCK_ROUNDINGS * f64::EPSILON * clock.hi + grown
    }

    /// The warning that the end, or a part of the run, depends on rounding errors.
    pub(super) fn depends_on_start(&self) -> Option<String> {
        let found = self.found_sensitivity()?;
        if let Some(lost) = found.lost {
            let t = self.clock(lost);
            return Some(format!(
                "nothing is determined from {t:.6} s on: by then rounding errors, and any change of the start, have grown to the size of the body"
            ));
        }
        let error = f64::EPSILON * found.error;
        (error > FEW_DIGITS).then(|| {
            let digits = (-libm::log10(error)).floor();
            format!(
                "{digits} digits of the end are determined: rounding errors have grown by a factor of {:.0e} until then",
                found.error
            )
        })
    }
}

/// The walk along a run.
struct Walk<'a> {
    run: &'a Trajectory,
    options: Options,
    reader: Reader<'a>,
    scale: Scale,
    /// Of size 1, or 0 once nothing of it is left.
    change: Change,
    /// Its growth since the start, and the sum of the growths since all events, in the units of the motion.
    growth: f64,
    error: f64,
    /// Shift of the time of the last event, in units of time.
    shift: f64,
    /// The largest rate of an impact since contacts were held for long, in m/s.
    fastest: f64,
    found: Sensitivity,
    /// Impacts that have been followed: plain ones, and others.
    done: [usize; 2],
    /// Growth at which to note the time.
    limit: f64,
    /// The modes before this piece, and whether an impact followed, which may end a slide or turn it back at once.
    before: ContactLetters<Mode>,
    struck: bool,
    /// Whether the last impacts were the last ones of an accumulation.
    fades: bool,
    /// Whether no impact has friction, and no contact has been held since one was held for long: the change is known to all digits.
    flies: bool,
    smooth: bool,
    /// The units of the motion, and the size of the change in them.
    own: Scale,
    size: f64,
    /// The largest shift of the time of an event, since contacts were held for long, by errors of size 1 at all events, in s.
    late: f64,
}

/// Events of a run with a limit of the growth before the growth is first asked for; then twice as many, and so on.
const FIRST_EVENTS: usize = 64;

/// A run that ends at the first event after which a small change has grown by more than [`Options::sensitivity_limit`]. `run`: a run with
/// these options, without this limit.
pub(super) fn limited(
    options: &Options,
    run: impl Fn(&Options) -> Result<Trajectory, Error>,
) -> Result<Trajectory, Error> {
    let Some(limit) = options.sensitivity_limit else { return run(options) };
    let free = Options { sensitivity_limit: None, ..*options };
    let mut events = FIRST_EVENTS;
    loop {
        let event_limit = events.min(options.event_limit);
        let part = run(&Options { record: true, certify: false, event_limit, ..free })?;
        let cut = part.outcome() == Outcome::EventLimit && events < options.event_limit;
        if let Some(passed) = of_run(&part, limit).and_then(|found| found.passed) {
            let time_limit = Some(options.clock(passed));
            return Ok(run(&Options { time_limit, ..free })?.ended_by_growth(options));
        }
        if !cut {
            return Ok(run(&free)?.with_options(options));
        }
        events = events.saturating_mul(2);
    }
}

/// How much the end of this run depends on its start; `None` if nothing was recorded, or a state within a sum cannot be computed.
/// `limit`: growth at which to note the time.
pub(super) fn of_run(run: &Trajectory, limit: f64) -> Option<Sensitivity> {
    let pieces = run.pieces().ok()?;
    let mut walk = Walk::new(run, run.record.spans.first()?.motion.start(), limit)?;
    for (k, piece) in pieces.iter().enumerate() {
        walk.pass(k, piece, pieces.get(k + 1))?;
        if walk.error.max(walk.growth) > FOLLOWED_GROWTH {
            (walk.growth, walk.error) = (f64::INFINITY, f64::INFINITY);
            break;
        }
    }
    Some(walk.end())
}

/// (x, y, ρθ) of a velocity or a displacement of a body; as it is for constant rows.
fn in_metric(state: &Moving, mut of: Coordinates) -> Coordinates {
    if let Some(body) = state.turning() {
        let rho = body.rho2.sqrt();
        of = Coordinates::from_iter(
            of.iter().enumerate().map(|(k, x)| if k == 2 { rho * x } else { x }),
        );
    }
    of
}

/// The three coordinates of a body, times this factor.
fn three(of: &Coordinates, factor: f64) -> [f64; 3] {
    let mut of = of.iter().map(|x| factor * x);
    std::array::from_fn(|_| of.next().unwrap_or(0.0))
}

/// The body moved by this way, with its velocity.
fn displaced(body: &BodyState, way: &Coordinates, factor: f64) -> BodyState {
    let mut from = body.clone();
    let [x, y, turn] = three(way, factor);
    (from.center.v, from.spin.omega) = (Vector2::new(x, y), turn / body.rho2.sqrt());
    (from.fall, from.fall_rate) = (Vector2::zeros(), Vector2::zeros());
    let mut after = from.flown(1.0);
    (after.fall, after.fall_rate) = (body.fall, body.fall_rate);
    (after.center.v, after.spin.omega) = (body.center.v, body.spin.omega);
    after
}

/// Changes of the rows of the points with the place, (tangential, normal) of each; empty for constant rows.
fn turned_rows(state: &Moving, way: &Coordinates, scale: Scale) -> Vec<[Coordinates; 2]> {
    let (Some(body), far) = (state.turning(), way.norm()) else { return Vec::new() };
    if far == 0.0 {
        return Vec::new();
    }
    let step = SENSITIVITY_STEP * scale.length / far;
    let [one, two] =
        [-step, step].map(|step| Moving::Turning(Box::new(displaced(body, way, step))));
    let change = |i: usize, tangential: bool| {
        two.row(i, tangential).plus(&one.row(i, tangential), -1.0).scaled(0.5 / step)
    };
    (0..state.count()).map(|i| [change(i, true), change(i, false)]).collect()
}

/// The part of the acceleration of a point (tangential, normal) that the turn of the body makes: (−b ω², −c ω²), in m/s².
fn centripetal(state: &Moving, i: usize) -> [f64; 2] {
    state.turning().map_or([0.0; 2], |body| {
        let (p, square) = (&body.points[i], body.spin.omega * body.spin.omega);
        [-p.b * square, -p.c * square]
    })
}

/// A row and its change, or no change.
fn changed(rows: &[[Coordinates; 2]], i: usize, k: usize) -> Option<&Coordinates> {
    rows.get(i).map(|both| &both[k])
}

impl<'a> Walk<'a> {
    fn new(run: &'a Trajectory, start: &Moving, limit: f64) -> Option<Self> {
        let n = start.velocity().len();
        let speed = in_metric(start, start.velocity()).norm();
        let (g, most) = (start.gravity(), start.points().map(|(h, _)| h).filter(|h| h.is_finite()));
        let length = match (run.posture(), start) {
            (Some(posture), _) => posture.size(),
            // The largest gap, or the height of a throw, in the coordinates of the rows.
            (None, Moving::Frozen(rows)) => {
                let (reach, high) = (rows.space().reach(), most.fold(0.0, f64::max));
                let thrown = if g > 0.0 { reach * speed * speed / g } else { 0.0 };
                (high / reach).max(thrown)
            }
            (None, Moving::Turning(_)) => return None,
        };
        let length = if length > 0.0 { length } else { 1.0 };
        let fall = match start {
            Moving::Turning(_) => g,
            Moving::Frozen(rows) => rows.space().pull().norm(),
        };
        let unit = if fall > 0.0 {
            (fall * length).sqrt()
        } else if speed > 0.0 {
            speed
        } else {
            1.0
        };
        let scale = Scale { length, speed: unit };
        let law = match &run.record.subject {
            subject if subject.posture().is_some() => {
                run.options().acting(run.posture()?.frictions())
            }
            _ => run.options().acting(
                (0..start.count()).map(|i| start.friction(i)).collect::<Vec<_>>().into_iter(),
            ),
        };
        let law = law.ok()?;
        let smooth =
            (0..start.count()).all(|i| start.material(i).in_impacts(law.impact).friction == 0.0);
        // Gaps, rates and the turn have small rounding errors in a small motion.
        let high = start.points().map(|(h, _)| h).filter(|h| h.is_finite()).fold(0.0, f64::max);
        let high = high + 0.5 * speed * speed / fall;
        let own = match run.posture() {
            Some(_) if high > 0.0 && high < f64::INFINITY => {
                Scale { length: high, speed: (fall * high).sqrt() }
            }
            _ => scale,
        };
        // The signs are those of a mirrored motion in a mirrored world.
        let aside =
            start.turning().and_then(|body| body.points.iter().map(|p| p.b).find(|b| *b != 0.0));
        let aside = aside.or_else(|| start.frozen()?.space().normal_row(0).iter().nth(2));
        let aside = if aside.is_some_and(|b| b < 0.0) { -1.0 } else { 1.0 };
        let equal = |size: f64| {
            let part = size / ((2 * n) as f64).sqrt();
            let sign = |k: usize| if run.posture().is_some() && k != 1 { aside } else { 1.0 };
            Coordinates::from_iter((0..n).map(|k| sign(k) * part))
        };
        let change = Change { way: equal(length), speed: equal(scale.speed) };
        Some(Self {
            run,
            options: law,
            reader: run.reader(),
            scale,
            own,
            size: change.size(own),
            change,
            growth: 1.0,
            error: 1.0,
            shift: 0.0,
            fastest: 0.0,
            found: Sensitivity { unit: length / scale.speed, ..Sensitivity::default() },
            done: [0; 2],
            limit,
            before: ContactLetters::from_elem(Mode::Separate, start.count()),
            struck: false,
            fades: false,
            flies: smooth,
            smooth,
            late: 0.0,
        })
    }

    /// Follows the change along a piece, and through the events at its end.
    fn pass(&mut self, k: usize, piece: &Piece, next: Option<&Piece>) -> Option<()> {
        let record = &*self.run.record;
        let end = next.map_or(record.end.clock, |next| next.clock);
        let dt = end.since(piece.clock).max(0.0);
        let motion = piece.flight.is_none().then(|| &record.spans[piece.span].motion);
        let lasts = dt > LASTING_PHASE * self.found.unit || next.is_none();
        if let Some(Motion::Sum { start, .. }) = motion {
            self.sum(k, start, dt, next);
        } else {
            let (start, modes) = self.reader.moving(k, 0.0)?;
            let modes: ContactLetters<Mode> = ContactLetters::from_slice(&modes);
            if modes.iter().any(|mode| *mode != Mode::Separate) {
                self.hold(k, &start, &modes, self.fades && !lasts);
                if k == 0 {
                    (self.growth, self.error) = (1.0, 1.0);
                }
                self.flow_held(&start, &modes, dt);
                // What follows a long phase is a motion of its own, however slow.
                if dt > self.found.unit {
                    (self.fastest, self.fades, self.late) = (0.0, false, 0.0);
                }
                self.flies = self.smooth && dt > self.found.unit;
            } else {
                self.change.way.add_scaled(&self.change.speed, dt);
            }
            if !self.fades || lasts {
                self.before = modes;
            }
        }
        self.struck = false;
        self.renew(end);
        // A run that ends at this time has the same change.
        if self.growth > self.limit && self.found.passed.is_none() {
            self.found.passed = Some(end);
        }
        let blows = self.blows(next);
        if blows.is_empty() && !matches!(motion, Some(Motion::Sum { .. })) {
            self.lands_to_stay(k, dt, next)?;
        }
        if !blows.is_empty() {
            let (state, modes) = self.reader.moving(k, dt)?;
            let modes: ContactLetters<Mode> = ContactLetters::from_slice(&modes);
            self.fades = !blows.iter().any(|blow| self.is_fast(blow.rate));
            if self.fades {
                self.stop(k, &state, modes, &blows);
            } else {
                let before = self.acceleration(k, &state, &modes);
                let after = match next {
                    Some(_) => {
                        let (start, modes) = self.reader.moving(k + 1, 0.0)?;
                        self.acceleration(k + 1, &start, &modes)
                    }
                    None => self.fall(&state),
                };
                self.strike(state, &modes, &blows, before, &after);
            }
            self.struck = true;
            self.renew(end);
        }
        let done = self.found.zeno.len();
        let reached =
            record.zeno[done..].iter().filter(|zeno| zeno.at.clock.since(end) <= 0.0).count();
        let now = self.late;
        self.found.zeno.extend(std::iter::repeat_n(now, reached));
        Some(())
    }

    /// A contact that lands at the end of a piece and is held in the next one, after impacts of one instant that were summed: its time.
    fn lands_to_stay(&mut self, k: usize, dt: f64, next: Option<&Piece>) -> Option<()> {
        let then = next.filter(|next| next.flight.is_none());
        let then = then.map(|next| &self.run.record.spans[next.span].motion);
        let Some(Motion::Modes { word, .. }) = then else { return Some(()) };
        let stays = |(mode, was): (&Mode, &Mode)| *mode != Mode::Separate && *was == Mode::Separate;
        if !word.iter().zip(&self.before).any(stays) {
            return Some(());
        }
        let (state, modes) = self.reader.moving(k, dt)?;
        let new = (0..modes.len().min(word.len())).filter(|&i| stays((&word[i], &modes[i])));
        let fastest = new.min_by(|&i, &j| state.point(i).1.total_cmp(&state.point(j).1));
        if let Some(i) = fastest.filter(|&i| state.point(i).1 < 0.0) {
            let rate = state.point(i).1;
            let late = -state.row(i, false).dot(&self.change.way) / rate;
            if self.is_fast(rate) {
                self.shifts(late, rate);
            }
        }
        Some(())
    }

    /// Makes the change one of size 1.
    fn renew(&mut self, clock: Clock) {
        let size = self.change.size(self.scale);
        let after = self.change.size(self.own);
        // The rounding errors of this event are those of speeds that may be larger than the unit.
        let added = 1.0 + self.fastest / self.own.speed;
        self.error = self.error * (after / self.size) + added;
        // Where contacts hold all of the body, nothing is left but the shift of the time of rest.
        if size > 0.0 {
            self.growth *= size;
            self.change.scale(1.0 / size);
            self.shift /= size;
            self.size = after / size;
        }
        if self.error_of_state() >= 1.0 && self.found.lost.is_none() {
            self.found.lost = Some(clock);
        }
    }

    /// Estimate of the error of the state, in the units of the body.
    fn error_of_state(&self) -> f64 {
        f64::EPSILON * self.error / self.size
    }

    fn end(mut self) -> Sensitivity {
        let rests = self.run.outcome() == Outcome::Rest;
        let size = self.change.size(self.scale);
        let size = if rests { libm::hypot(size, self.shift) } else { size };
        self.found.growth = self.growth * size;
        self.found.error = self.error;
        self.found.late = if rests { self.late } else { 0.0 };
        let all = self.run.record.zeno.len();
        self.found.zeno.resize(all, self.late);
        self.found
    }

    fn fall(&self, state: &Moving) -> Coordinates {
        match state {
            Moving::Turning(body) => Coordinates::of_three([body.fall.x, body.fall.y, 0.0]),
            Moving::Frozen(rows) => rows.space().pull().clone(),
        }
    }

    /// The acceleration of piece `k` in this state.
    fn acceleration(&self, k: usize, state: &Moving, modes: &[Mode]) -> Coordinates {
        // A contact that comes to a vertex gets a second point: the modes before are not those of these points.
        if modes.len() != state.count() || modes.iter().all(|mode| *mode == Mode::Separate) {
            return self.fall(state);
        }
        match state {
            Moving::Turning(body) => {
                let a = Step::new(body, modes, ORDER).map_or([0.0; 3], |step| step.acceleration());
                Coordinates::of_three([a[0], a[1], body.rho2.sqrt() * a[2]])
            }
            Moving::Frozen(_) => {
                let pieces = self.run.pieces().unwrap_or(&[]);
                match pieces.get(k).map(|piece| &self.run.record.spans[piece.span].motion) {
                    Some(Motion::Modes { acceleration: Some(a), .. }) => a.clone(),
                    _ => Coordinates::zeros(state.velocity().len()),
                }
            }
        }
    }

    /// Takes off, along the contact forces, what leaves the contacts that are held in these modes from now on.
    fn hold(&mut self, k: usize, start: &Moving, modes: &[Mode], fades: bool) {
        let v = in_metric(start, start.velocity());
        let rows = turned_rows(start, &self.change.way, self.scale);
        let before: ContactLetters<Mode> = self.before.clone();
        let was = |i: usize| before.get(i).copied().unwrap_or(Mode::Separate);
        let slides = |mode: Mode| matches!(mode, Mode::Left | Mode::Right);
        // A slide that ends or turns back: its time.
        let turns = |&i: &usize| {
            slides(was(i))
                && modes[i] != was(i)
                && modes[i] != Mode::Separate
                && start.friction(i) > 0.0
        };
        if let Some(i) = (0..modes.len()).find(turns).filter(|_| !self.struck && !fades) {
            let a = self.acceleration(k.saturating_sub(1), start, &before);
            let row = start.row(i, true);
            let mut slip = row.dot(&self.change.speed);
            slip += changed(&rows, i, 0).map_or(0.0, |row| row.dot(&v));
            let rate = row.dot(&a) + centripetal(start, i)[0];
            if rate != 0.0 {
                let late = -slip / rate;
                self.shift = late / self.found.unit;
                self.comes_late(late);
                if slides(modes[i]) {
                    let after = self.acceleration(k, start, modes);
                    self.change.speed.add_scaled(&a.plus(&after, -1.0), late);
                }
            }
        }
        let (mut held, mut forces, mut rubs) = (Vec::new(), Vec::new(), false);
        for (i, mode) in modes.iter().enumerate().filter(|(_, mode)| **mode != Mode::Separate) {
            let (t, n) = (start.row(i, true), start.row(i, false));
            let mu = start.friction(i);
            let sticks = *mode == Mode::Fixed && mu > 0.0;
            // Contacts that have landed were stopped by impacts.
            let smooth = self.options.impact == Impact::Newton && was(i) == Mode::Separate;
            rubs |= smooth && mu > 0.0 && slides(*mode);
            let mu = if smooth { 0.0 } else { mu };
            let rate = |row: &Coordinates, k: usize| {
                let turned = changed(&rows, i, k).map_or(0.0, |row| row.dot(&v));
                row.dot(&self.change.speed) + turned
            };
            held.push((n.clone(), rate(&n, 1), n.dot(&self.change.way)));
            forces.push(if sticks { n.clone() } else { n.plus(&t, -mode.direction() * mu) });
            if sticks {
                held.push((t.clone(), rate(&t, 0), 0.0));
                forces.push(t);
            }
        }
        if held.is_empty() {
            return;
        }
        // Of rows that depend on each other, some do.
        let rows: Vec<&Coordinates> = held.iter().map(|row| &row.0).collect();
        let own: Vec<usize> =
            independent(&rows, SINGULAR_HOLD).into_iter().map(|(k, _)| k).collect();
        let matrix =
            DMatrix::from_fn(own.len(), own.len(), |j, l| held[own[j]].0.dot(&forces[own[l]]));
        let factors = matrix.lu();
        let take = |of: Vec<f64>, from: &mut Coordinates| {
            let right = DVector::from_iterator(own.len(), own.iter().map(|&k| of[k]));
            if let Some(parts) = factors.solve(&right) {
                for (part, &k) in parts.iter().zip(&own) {
                    from.add_scaled(&forces[k], -part);
                }
            }
        };
        take(held.iter().map(|row| row.1).collect(), &mut self.change.speed);
        take(held.iter().map(|row| row.2).collect(), &mut self.change.way);
        if rubs && !fades {
            // Until then the ground held without friction.
            let after = self.acceleration(k, start, modes);
            let mut jump = self.fall(start).plus(&after, -1.0);
            let parts = held.iter().map(|row| row.0.dot(&jump)).collect();
            take(parts, &mut jump);
            self.change.speed.add_scaled(&jump, self.shift * self.found.unit);
        }
    }

    /// Follows the change for `dt` while contacts are held.
    fn flow_held(&mut self, start: &Moving, modes: &[Mode], dt: f64) {
        let size = self.change.size(self.scale);
        let (Some(body), true) = (start.turning(), size > 0.0) else {
            self.change.way.add_scaled(&self.change.speed, dt);
            return;
        };
        let step = SENSITIVITY_STEP / size;
        let [one, two] = [-step, step].map(|step| {
            let near = self.near(body, modes, step);
            let after = Moving::Turning(Box::new(Held::new(&near, modes).at(dt)));
            [after.displacement(), after.velocity()].map(|of| in_metric(&after, of))
        });
        self.change.way = two[0].plus(&one[0], -1.0).scaled(0.5 / step);
        self.change.speed = two[1].plus(&one[1], -1.0).scaled(0.5 / step);
    }

    /// The body with this multiple of the change, its contacts held in these modes.
    fn near(&self, body: &BodyState, modes: &[Mode], step: f64) -> BodyState {
        let mut near = displaced(body, &self.change.way, step);
        let [x, y, turn] = three(&self.change.speed, step);
        near.center.v += Vector2::new(x, y);
        near.spin.omega += turn / body.rho2.sqrt();
        let (v, omega) = (near.center.v, near.spin.omega);
        for (p, mode) in near.points.iter_mut().zip(modes) {
            if *mode == Mode::Separate {
                p.u = p.normal.dot(&v) + p.b * omega;
            } else {
                (p.h, p.u) = (0.0, 0.0);
            }
        }
        near
    }

    /// A sum of impacts of this duration. The contacts that come to rest take off the change along their forces.
    fn sum(&mut self, k: usize, start: &Moving, dt: f64, next: Option<&Piece>) {
        let record = &*self.run.record;
        let v = in_metric(start, start.velocity());
        let rows = turned_rows(start, &self.change.way, self.scale);
        // The contact that lands, or has just taken off. In constant geometry all times are in proportion to its speed.
        let moves =
            (0..start.count()).filter(|&i| start.point(i).0 == 0.0 && start.point(i).1 != 0.0);
        let fastest =
            moves.max_by(|&i, &j| start.point(i).1.abs().total_cmp(&start.point(j).1.abs()));
        if let Some(i) = fastest {
            let (row, u) = (start.row(i, false), start.point(i).1);
            let a = match u < 0.0 {
                true => self.acceleration(k.saturating_sub(1), start, &self.before.clone()),
                false => self.fall(start),
            };
            let late = -row.dot(&self.change.way) / u;
            let turned = changed(&rows, i, 1).map_or(0.0, |row| row.dot(&v));
            let falls = row.dot(&a) + centripetal(start, i)[1];
            let faster = row.dot(&self.change.speed) + turned + falls * late;
            self.fades |= !self.is_fast(u);
            if !self.fades {
                self.shifts(late + dt * faster / u, u);
            }
        }
        let then =
            next.filter(|next| next.flight.is_none()).map(|next| &record.spans[next.span].motion);
        let modes: ContactLetters<Mode> = match then {
            Some(Motion::Modes { word, .. }) if word.len() == start.count() => word.clone(),
            _ => {
                let zeno = record.zeno.get(self.found.zeno.len());
                let closed = |i: usize| {
                    zeno.is_some_and(|zeno| zeno.closed.get(start.contact(i)) == Some(&true))
                };
                (0..start.count())
                    .map(|i| if closed(i) { Mode::Right } else { Mode::Separate })
                    .collect()
            }
        };
        if modes.iter().any(|mode| *mode != Mode::Separate) {
            self.hold(k + 1, start, &modes, self.fades);
        }
        self.change.way.add_scaled(&self.change.speed, dt);
        if !self.fades {
            self.before = modes;
        }
    }

    /// The impacts between this piece and the next one, in order.
    fn blows(&mut self, next: Option<&Piece>) -> Vec<Blow> {
        let record = &*self.run.record;
        let until = match next {
            Some(Piece { flight: Some(Flight::Body(index)), .. }) => index + 1,
            Some(Piece { flight: Some(Flight::Rows(_)), .. }) => self.done[0] + 1,
            Some(Piece { span, .. }) => record.spans[*span].first_collision,
            None => record.collisions.len(),
        };
        let end = next.map_or(record.end.clock, |next| next.clock);
        let mut blows = Vec::new();
        loop {
            let [plain, listed] = &mut self.done;
            match record.impacts.get(*listed) {
                Some(hit) if hit.collisions <= *plain && hit.clock.since(end) <= 0.0 => {
                    let at = record.subject.posture().filter(|p| hit.contact < p.contacts().len());
                    let at = at.map_or(hit.contact, |posture| posture.point_of(hit.contact));
                    let rate = hit.before.get(at).copied().unwrap_or(0.0);
                    blows.push(Blow {
                        contact: hit.contact,
                        impulse: Some(hit.impulse),
                        jump: 0.0,
                        rate,
                    });
                    *listed += 1;
                }
                _ if *plain < until => {
                    let hit = &record.collisions[*plain];
                    let (contact, rate) = (hit.contact, hit.before[hit.contact]);
                    blows.push(Blow { contact, impulse: None, jump: hit.jump, rate });
                    *plain += 1;
                }
                _ => return blows,
            }
        }
    }

    /// The impacts of one instant. `before`, `after`: the accelerations of the pieces around it.
    fn strike(
        &mut self,
        mut state: Moving,
        modes: &[Mode],
        blows: &[Blow],
        before: Coordinates,
        after: &Coordinates,
    ) {
        let (mut done, mut a) = (0, before);
        while let Some(first) = blows.get(done) {
            let point = |blow: &Blow| {
                let own = (0..state.count()).filter(|&i| state.contact(i) == blow.contact);
                own.min_by(|&i, &j| state.point(i).0.total_cmp(&state.point(j).0))
            };
            let Some(i) = point(first) else { return };
            let impulse = |blow: &Blow, state: &Moving, i: usize| {
                blow.impulse.unwrap_or([0.0, blow.jump / state.impact_matrix(i).nn])
            };
            if first.rate >= 0.0 {
                // An impact without collision, of a jam.
                state.push(i, impulse(first, &state, i));
                done += 1;
                continue;
            }
            let late = -state.row(i, false).dot(&self.change.way) / first.rate;
            let mut v = in_metric(&state, state.velocity());
            self.change.way.add_scaled(&v, late);
            self.change.speed.add_scaled(&a, late);
            // All that are hit at once, with those that rest.
            let rests =
                |j: &usize| done == 0 && modes.get(*j).is_some_and(|mode| *mode != Mode::Separate);
            let mut hit: Vec<(usize, f64)> = vec![(i, first.rate)];
            let mut count = 1;
            if self.options.policy() == Simultaneous::Together && first.impulse.is_some() {
                for blow in &blows[done + 1..] {
                    match point(blow) {
                        Some(j)
                            if hit.iter().all(|(k, _)| *k != j)
                                && (blow.rate < 0.0 || rests(&j)) =>
                        {
                            hit.push((j, blow.rate));
                            count += 1;
                        }
                        _ => break,
                    }
                }
                if self.options.hits_resting() {
                    let resting: Vec<usize> = (0..state.count()).filter(rests).collect();
                    for j in resting {
                        if hit.iter().all(|(k, _)| *k != j) {
                            hit.push((j, 0.0));
                        }
                    }
                }
            }
            self.blow(&state, &hit);
            for (blow, (j, _)) in blows[done..done + count].iter().zip(&hit) {
                state.push(*j, impulse(blow, &state, *j));
            }
            done += count;
            v = in_metric(&state, state.velocity());
            a = if done < blows.len() { self.fall(&state) } else { after.clone() };
            self.change.way.add_scaled(&v, -late);
            self.change.speed.add_scaled(&a, -late);
            self.shifts(late, first.rate);
        }
    }

    /// The time of an impact at this rate (m/s) shifts by this time, in s. The shifts of the impacts of an accumulation converge, and those of
    /// the last ones are quotients of rounding errors.
    fn shifts(&mut self, late: f64, rate: f64) {
        self.comes_late(late);
        if rate.abs() > SLOW_IMPACT * self.fastest {
            self.shift = late / self.found.unit;
        }
    }

    /// An event shifts by this time, in s.
    fn comes_late(&mut self, late: f64) {
        self.late = self.late.max(self.error * (late.abs() / self.size));
    }

    /// Whether an impact at this rate (m/s) is more than one of the last ones of an accumulation, whose motion is smaller than the change, if this
    /// is as large as rounding errors have become. Between phases of contact the change is known to some digits less.
    fn is_fast(&mut self, rate: f64) -> bool {
        self.fastest = self.fastest.max(rate.abs());
        let noise = match (self.flies, self.fades) {
            (true, _) => f64::EPSILON,
            (false, false) => SLOW_IMPACT,
            (false, true) => FRESH_IMPACT,
        };
        // Once nothing is determined, the growth is that of this run alone.
        let known = self.found.lost.is_none();
        let lost = if known { self.error_of_state() * self.scale.speed } else { 0.0 };
        rate.abs() > lost.min(FRESH_IMPACT * self.fastest).max(noise * self.fastest)
    }

    /// The last impacts of an accumulation. Their motion is smaller than a change of it that counts: the contacts count as held from now on.
    fn stop(&mut self, k: usize, state: &Moving, mut modes: ContactLetters<Mode>, blows: &[Blow]) {
        for blow in blows {
            for i in (0..state.count()).filter(|&i| state.contact(i) == blow.contact) {
                let mu = state.material(i).in_impacts(self.options.impact).friction;
                let [t, n] = blow.impulse.unwrap_or([0.0, 1.0]);
                modes[i] = match t.abs() < (1.0 - STILL) * mu * n {
                    true => Mode::Fixed,
                    false if t > 0.0 => Mode::Left,
                    false => Mode::Right,
                };
            }
        }
        self.hold(k, state, &modes, true);
    }

    /// The change of the impulses of these points, which are hit at once at these rates.
    fn blow(&mut self, state: &Moving, hit: &[(usize, f64)]) {
        let law = self.options.impact;
        let v = in_metric(state, state.velocity());
        let turned = turned_rows(state, &self.change.way, self.scale);
        let rows: Vec<Coordinates> =
            hit.iter().flat_map(|&(i, _)| [true, false].map(|t| state.row(i, t))).collect();
        let changes: Vec<Coordinates> = hit
            .iter()
            .flat_map(|&(i, _)| {
                [0, 1]
                    .map(|k| changed(&turned, i, k).cloned().unwrap_or(Coordinates::zeros(v.len())))
            })
            .collect();
        let rates: Vec<f64> = hit.iter().flat_map(|&(i, rate)| [state.slip(i), rate]).collect();
        let faster: Vec<f64> = rows
            .iter()
            .zip(&changes)
            .map(|(row, turn)| row.dot(&self.change.speed) + turn.dot(&v))
            .collect();
        // The law is homogeneous in the rates. Its derivative, by a step that is small beside the fastest rate.
        let fastest = hit.iter().fold(0.0_f64, |most, (_, rate)| most.max(rate.abs()));
        let turn = changes.iter().fold(0.0_f64, |most, row| most.max(row.norm()));
        let most = faster.iter().fold(turn * fastest, |most, rate| most.max(rate.abs()));
        if most == 0.0 {
            return;
        }
        let step = SENSITIVITY_STEP * fastest / most;
        let impulses = |step: f64| -> Option<Vec<[f64; 2]>> {
            let rows: Vec<Coordinates> =
                rows.iter().zip(&changes).map(|(row, turn)| row.plus(turn, step)).collect();
            let rate = |k: usize| rates[k] + step * faster[k];
            if let [(i, _)] = hit {
                let w = Matrix {
                    nn: rows[1].dot(&rows[1]),
                    nt: rows[0].dot(&rows[1]),
                    tt: rows[0].dot(&rows[0]),
                };
                return friction::impulse(law, &w, [rate(0), rate(1)], &state.material(*i))
                    .map(|one| vec![one]);
            }
            let parties: ContactValues<Party> = hit
                .iter()
                .enumerate()
                .map(|(k, &(i, u))| Party {
                    // A contact at rest stays on its ground.
                    before: [rate(2 * k), if u == 0.0 { 0.0 } else { rate(2 * k + 1) }],
                    material: state.material(i).in_impacts(law),
                })
                .collect();
            together(&parties, |k, l| rows[k].dot(&rows[l]), v.len())
                .map(|found| found.impulses.to_vec())
        };
        let all = [0.0, -step, step].map(impulses);
        let [Some(now), Some(one), Some(two)] = all else { return };
        for (k, now) in now.iter().enumerate() {
            for part in 0..2 {
                let row = 2 * k + part;
                self.change
                    .speed
                    .add_scaled(&rows[row], (two[k][part] - one[k][part]) / (2.0 * step));
                self.change.speed.add_scaled(&changes[row], now[part]);
            }
        }
    }
}
