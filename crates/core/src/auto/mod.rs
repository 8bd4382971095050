//! `model = "auto"`: the local model if its error is within the tolerance, else the full model.
//!
//! The local model is exact if the body does not rotate ([`is_exact`]). Otherwise its error is computed along the run. The *shadow* of a
//! local run is the motion of the full model with the same events in the same order. Between two events of a flight the motions of both
//! models are the same parabola in q and q̇. The shadow therefore needs only
//! ```text
//! h = n·δr + b₀ δθ − b₀(θ − sin θ) − c₀(1 − cos θ)     full gap at the instant at which the local gap is zero
//! δt = 2h/(√(u² + 2Gh) − u),   G = g + cω²             delay until the full gap is zero
//! q̇⁺ = q̇⁻ − (1+e) u M⁻¹N(θ)ᵀ/(N(θ)M⁻¹N(θ)ᵀ)           impact at that time
//! ```
//!
//! Here δ means full − local at the same event. The shadow obeys the full equations from event to event. If no contact is below the terrain
//! in between, it *is* the full motion, and its differences from the local run at the end are the errors of the local run. Terms of third
//! order (the change of G within δt) are neglected. Two small parts are estimated: sliding and rolling, by Boole's rule; and the last part
//! of a sum, by bounds of the effect of the changing geometry. [`SHADOW_SAFETY`] covers both. If the order of events is uncertain, there is
//! no shadow, and the full model is solved.

use nalgebra::Vector3;

mod arm;
mod slide;
mod tails;

use crate::body::geometry::{ContactGeometry, couplings};
use crate::body::local_model::{LocalModel, LocalModelFields};
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::collisions::local::time_to_rest;
use crate::math::clock::Clock;
use crate::math::turn::Turn;
use crate::modes::Mode;
use crate::motion::record::{InFrame, Motion, Record, Span, ZenoRecord};
use crate::options::{Options, Stop};
use crate::outcome::{ModelReason, Outcome, ZenoMethod};
use crate::zeno::{FrozenModel, Gaps};

use crate::tolerance::{
    CONCAVE_ARC, FIRST_DEFECT, LANDING_SPEED_CHANGE, SHADOW_SAFETY, SHADOW_TURN, UNFOLLOWED_PART,
};
use arm::Arm;
use slide::Until;

/// Number of collisions between two checks of whether the remaining time is negligible.
const CHECK_INTERVAL: usize = 8;

/// Largest number of events of a local run, counted as in [`Options::event_limit`]; also the largest number of its collisions that the
/// shadow follows. A longer local run would save little, because the full model, too, freezes its geometry in the last moments of an
/// accumulation.
pub(crate) const MOST_EVENTS: usize = 256;
const MOST_COLLISIONS: usize = 96;

/// Whether the local model is exact: neither gravity nor impacts nor friction rotate the body. All arms have b_i = 0, so normal forces have
/// no moment. And friction is zero, or has no arm (c_i = 0), or there is no tangential velocity.
pub(crate) fn is_exact(posture: &Posture, state: &State) -> bool {
    let upright = state.q.z == 0.0 && state.qdot.z == 0.0;
    let every = |holds: &dyn Fn(&ContactGeometry, f64) -> bool| {
        posture.contacts().iter().enumerate().all(|(i, contact)| match posture.ground(i) {
            Some(ground) => ground
                .pieces
                .iter()
                .all(|piece| holds(&posture.on_piece(i, piece), contact.friction)),
            None => holds(&posture.geometry()[i], contact.friction),
        })
    };
    let falls = state.qdot.x == 0.0 && every(&|k, _| k.normal.x == 0.0);
    upright
        && every(&|k, _| k.b == 0.0)
        && (falls || every(&|k, friction| friction == 0.0 || k.touching_c() == 0.0))
}

/// Whether a run can have a shadow. It must have at most two contacts, none of them round, impacts without friction, a terrain of infinite lines that face up,
/// and no limit `neighbourhood`.
pub(crate) fn has_shadow(posture: &Posture, options: &Options) -> bool {
    posture.contacts().len() <= 2
        && options.is_frictionless(posture)
        && options.neighbourhood == f64::INFINITY
        && posture.ground(0).is_none()
        && !posture.has_rounds()
        && posture.geometry().iter().all(|k| k.normal.y > 0.0)
}

/// Whether the requested motion comes to an end: at the first Zeno point, at a given time, or at rest on two contacts. Rest on a slope
/// needs friction. Rest on one contact does not count, because the body tips over.
pub(crate) fn has_end(posture: &Posture, options: &Options) -> bool {
    let contacts = posture.contacts();
    let level = contacts.iter().all(|contact| contact.slope == 0.0);
    options.stop != Stop::Rest
        || contacts.len() == 2 && (level || contacts.iter().any(|contact| contact.friction > 0.0))
}

/// Whether the first flight and impact alone show that the error of the local model exceeds the tolerance.
pub(crate) fn is_hopeless(
    posture: &Posture,
    state: &State,
    heights: &[f64],
    options: &Options,
) -> bool {
    !(first_defect(posture, state, heights) <= FIRST_DEFECT * options.tolerance)
}

/// Relative difference between the models in the first flight, in the first impact and in gravity after it: a rough
/// estimate of the error of the local model.
fn first_defect(posture: &Posture, state: &State, heights: &[f64]) -> f64 {
    let rho2 = posture.gyration_squared();
    let landing = |k: &ContactGeometry, h: f64| {
        let u = k.local_rate(&state.qdot);
        let speed = (u * u + 2.0 * k.gravity * h.max(0.0)).sqrt();
        ((u + speed) / k.gravity, speed)
    };
    let landings = posture.geometry().iter().zip(heights).map(|(k, h)| (k, landing(k, *h)));
    let Some((k, (t, speed))) = landings.min_by(|x, y| x.1.0.total_cmp(&y.1.0)) else { return 0.0 };
    if speed == 0.0 {
        return 0.0;
    }
    let theta = state.q.z + state.qdot.z * t;
    let own = k.b * k.b + rho2;
    let omega = state.qdot.z + (1.0 + k.restitution) * speed * k.b / own;
    // After the impact the body rotates for about the time in which gravity reverses a velocity of this size.
    let later = theta.abs().max((omega * speed / k.gravity).abs());
    let change = later * (k.c * k.b).abs() / own + 0.5 * later * later;
    let early = if t > 0.0 { Arm::of(k, &Turn::by(theta)).sag.abs() / (speed * t) } else { 0.0 };
    let pull = k.c.abs() * omega * omega / k.gravity;
    if t < f64::INFINITY { early.max(change).max(pull) } else { f64::INFINITY }
}

/// State of the local run at an event, and the difference of its shadow at the same event.
struct Shadow<'a> {
    contacts: &'a [ContactGeometry],
    rho2: f64,
    fall: Vector3<f64>,
    /// Initial speed, in m/s.
    speed: f64,
    /// Size of the body divided by ρ.
    lever: f64,
    /// The longest arm divided by the gravity into its terrain, in s².
    reach: f64,
    clock: Clock,
    q: Vector3<f64>,
    qdot: Vector3<f64>,
    /// Gap rates of the local run, as recorded. They are not computed from q̇, because near an accumulation such rates have fewer correct
    /// digits.
    u: [f64; 2],
    /// q of the shadow less q of the local run.
    dq: Vector3<f64>,
    dqdot: Vector3<f64>,
    /// The arms of the shadow.
    arms: [Arm; 2],
    /// Delay of the shadow, in s.
    late: f64,
    /// The largest |late| at a Zeno point.
    latest: f64,
    /// Bound of the time error of those parts of the run that are not followed, in s.
    slack: f64,
    /// Bound of the error of these parts in q, relative to the size of the body.
    loose: f64,
    /// Duration in s. Parts of the run that are shorter need not be followed.
    small: f64,
    /// Duration of the local run, in s.
    whole: f64,
    /// Contacts with zero gap.
    touching: [bool; 2],
}

/// The error of a local run: the larger one of the error of its times, relative to its duration, and of the error of its final q, relative
/// to the size of the body. It includes [`SHADOW_SAFETY`].
pub(crate) fn error(
    posture: &Posture,
    start: &State,
    record: &Record,
    options: &Options,
) -> Result<f64, ModelReason> {
    let contacts = posture.geometry();
    let level = contacts.iter().all(|k| k.normal == contacts[0].normal);
    match record.outcome {
        Outcome::EventLimit => return Err(ModelReason::ManyEvents),
        _ if record.hits > MOST_COLLISIONS => return Err(ModelReason::ManyEvents),
        Outcome::Rest if record.end.gaps.len() < 2 || record.end.gaps.iter().any(|h| *h > 0.0) => {
            return Err(ModelReason::Tips);
        }
        Outcome::Rest | Outcome::Zeno => {}
        Outcome::TimeLimit if options.stop == Stop::Time => {}
        // Two contacts on parallel lines keep their sliding mode. In other cases the mode may change later.
        Outcome::Sliding if level && contacts.len() == 2 => {}
        _ => return Err(ModelReason::NoEnd),
    }
    let elapsed = record.end.clock.hi;
    let mut shadow = Shadow::new(posture, start, elapsed, options.tolerance);
    shadow.follow(record)?;
    let time = if elapsed > 0.0 {
        (shadow.latest.max(shadow.late.abs()) + shadow.slack) / elapsed
    } else {
        0.0
    };
    if record.outcome != Outcome::TimeLimit
        && elapsed * (1.0 + SHADOW_SAFETY * time) > options.end()
    {
        return Err(ModelReason::NoEnd);
    }
    let size = posture.size();
    let length = |q: &Vector3<f64>| (libm::hypot(q.x, q.y) / size).max(q.z.abs());
    let moved = length(&shadow.dq) + length(&shadow.velocity()) * shadow.slack + shadow.loose;
    let error = SHADOW_SAFETY * time.max(moved);
    if error.is_finite() { Ok(error) } else { Err(ModelReason::OtherOrder) }
}

impl<'a> Shadow<'a> {
    fn new(posture: &'a Posture, start: &State, whole: f64, tolerance: f64) -> Self {
        let contacts = posture.geometry();
        let reach = |k: &ContactGeometry| libm::hypot(k.b, k.c) / k.gravity;
        let mut shadow = Self {
            contacts,
            rho2: posture.gyration_squared(),
            fall: Vector3::new(0.0, -posture.fields().gravity, 0.0),
            speed: libm::hypot(start.qdot.x, start.qdot.y) + posture.size() * start.qdot.z.abs(),
            lever: posture.size() / posture.fields().gyration_radius,
            reach: contacts.iter().map(reach).fold(0.0, f64::max),
            clock: Clock::default(),
            q: start.q,
            qdot: start.qdot,
            u: [0.0; 2],
            dq: Vector3::zeros(),
            dqdot: Vector3::zeros(),
            arms: [Arm::nominal(&ContactGeometry::ABSENT); 2],
            late: 0.0,
            latest: 0.0,
            slack: 0.0,
            loose: 0.0,
            small: UNFOLLOWED_PART * tolerance * whole,
            whole,
            touching: [false; 2],
        };
        shadow.turn();
        shadow.measure();
        shadow
    }

    /// Computes the gap rates of the local run from q̇.
    fn measure(&mut self) {
        for (u, k) in self.u.iter_mut().zip(self.contacts) {
            *u = along(k, &self.qdot);
        }
    }

    fn count(&self) -> usize {
        self.contacts.len()
    }

    /// q̇ of the shadow.
    fn velocity(&self) -> Vector3<f64> {
        self.qdot + self.dqdot
    }

    /// Updates the arms of the shadow to its rotation.
    fn turn(&mut self) {
        let turn = Turn::by(self.q.z + self.dq.z);
        for (arm, k) in self.arms.iter_mut().zip(self.contacts) {
            *arm = Arm::of(k, &turn);
        }
    }

    /// Gap rate of the shadow at contact i.
    fn rate(&self, i: usize) -> f64 {
        self.u[i] + self.rate_off(i)
    }

    /// Gap rate of the shadow less that of the local run.
    fn rate_off(&self, i: usize) -> f64 {
        let (k, d) = (&self.contacts[i], &self.dqdot);
        let turned = self.arms[i].change * (self.qdot.z + d.z);
        k.normal.x * d.x + k.normal.y * d.y + k.b * d.z + turned
    }

    /// Sliding velocities of contact i: in the local run, and in its shadow.
    fn slips(&self, i: usize) -> [f64; 2] {
        let (k, v) = (&self.contacts[i], self.velocity());
        let slip = |c: f64, v: &Vector3<f64>| k.tangent.x * v.x + k.tangent.y * v.y - c * v.z;
        [slip(k.c, &self.qdot), slip(self.arms[i].c, &v)]
    }

    /// Gap of the shadow less that of the local run.
    fn gap_off(&self, i: usize) -> f64 {
        let (k, d) = (&self.contacts[i], &self.dq);
        k.normal.x * d.x + k.normal.y * d.y + k.b * d.z + self.arms[i].sag
    }

    fn agrees(&self) -> bool {
        self.q.z == 0.0 && self.dq == Vector3::zeros() && self.dqdot == Vector3::zeros()
    }

    /// Follows all events of a run.
    fn follow(&mut self, record: &Record) -> Result<(), ModelReason> {
        let mut zeno = 0;
        let mut k = 0;
        while k < record.spans.len() {
            if let Err(lost) = self.span(record, k, &mut zeno) {
                // The order of events has become uncertain. This does not matter once both motions have almost come to
                // rest, provided the first Zeno point, whose kind is reported, has been passed.
                if zeno == 0 {
                    return Err(lost);
                }
                let at =
                    record.zeno[zeno..].iter().position(|point| point.closed[..] == [true, true]);
                zeno += at.ok_or(lost)?;
                let point = &record.zeno[zeno];
                self.skip(point).ok_or(lost)?;
                zeno += 1;
                let later = |span: &Span| span.clock.since(point.at.clock) >= 0.0;
                let rest = record.spans[k + 1..].iter().position(later);
                k += rest.map_or(record.spans.len(), |more| more + 1);
            } else {
                k += 1;
            }
        }
        if record.outcome == Outcome::TimeLimit {
            // The shadow is evaluated at the same time as the local run.
            self.shift(-self.late, self.fall);
        }
        Ok(())
    }

    /// Follows the events of a span, and the Zeno points up to its end.
    fn span(&mut self, record: &Record, k: usize, zeno: &mut usize) -> Result<(), ModelReason> {
        let (span, next) = (&record.spans[k], record.spans.get(k + 1));
        let end = next.map_or(record.end.clock, |next| next.clock);
        let last = next.map_or(record.collisions.len(), |next| next.first_collision);
        let collisions = &record.collisions[span.first_collision..last];
        let point = record.zeno.get(*zeno).filter(|point| point.at.clock.since(end) <= 0.0);
        match &span.motion {
            Motion::Flight(_) => {}
            Motion::Modes(body, modes) => {
                let mut word = [Mode::Separate; 2];
                word[..modes.len()].copy_from_slice(modes);
                let State { q, qdot } = body.state();
                (self.q, self.qdot) = (q, qdot);
                let until = collisions.first().map_or(end, |c| c.elapsed);
                // If all contacts come to rest at a touchdown, no collision is listed.
                let sums = next.is_some_and(|next| matches!(next.motion, Motion::Tail(..)));
                let stops = point.is_some_and(|point| point.method == ZenoMethod::Chatter);
                let stop = match collisions.first() {
                    Some(c) => Until::Landing(c.contact),
                    None if sums || stops => Until::Landing(usize::from(word[0] != Mode::Separate)),
                    None if next.is_some() => Until::Stop,
                    None => Until::End,
                };
                self.slide(&word, until.since(self.clock), stop)?;
                self.clock = until;
            }
            Motion::Tail(InFrame { raw, .. }, tail) => {
                let point = point.ok_or(ModelReason::NoEnd)?;
                self.u = raw.gaps.u;
                self.sum(*tail, point, &raw.gaps, end.since(self.clock), next.is_none())?;
                self.clock = end;
            }
            Motion::Held(..)
            | Motion::Cycles { .. }
            | Motion::Jointed { .. }
            | Motion::JointedTail { .. } => return Err(ModelReason::NoEnd),
        }
        for (n, c) in collisions.iter().enumerate() {
            if *zeno > 0
                && n % CHECK_INTERVAL == CHECK_INTERVAL - 1
                && self.is_all_but_over(record, *zeno)
            {
                return Err(ModelReason::OtherOrder);
            }
            let dt = c.elapsed.since(self.clock);
            if dt > 0.0 {
                self.fly(dt)?;
                self.clock = c.elapsed;
                self.u = c.before;
                self.land(c.contact, self.fall)?;
                self.clears(1 - c.contact, c.other_gap)?;
            }
            self.u = c.before;
            if !self.touching[c.contact] {
                // Simultaneous touchdown of both contacts: it is simultaneous in the shadow only if both motions agree.
                self.touching[c.contact] = true;
                self.agrees().then_some(()).ok_or(ModelReason::OtherOrder)?;
            }
            self.hit(c.contact, c.jump)?;
            self.u = c.after;
        }
        let left = end.since(self.clock);
        if left > 0.0 {
            self.fly(left)?;
            self.clock = end;
            self.measure();
        }
        while let Some(point) = record.zeno.get(*zeno)
            && point.at.clock.since(end) <= 0.0
        {
            match point.method {
                ZenoMethod::Chatter => self.chatter()?,
                ZenoMethod::Rest if k == 0 => {
                    self.touching[..point.closed.len()].copy_from_slice(&point.closed);
                }
                _ if matches!(span.motion, Motion::Tail(..)) => {}
                _ => return Err(ModelReason::OtherOrder),
            }
            self.latest = self.latest.max(self.late.abs());
            *zeno += 1;
        }
        Ok(())
    }

    /// Whether both contacts come to rest so soon that the details of the remaining motion are negligible.
    fn is_all_but_over(&self, record: &Record, zeno: usize) -> bool {
        let soon = |point: &&ZenoRecord| {
            point.closed[..] == [true, true] && point.at.clock.since(self.clock) <= self.small
        };
        let point = record.zeno.get(zeno).filter(soon);
        point.is_some() && self.time_to_rest().is_some_and(|t| t <= self.small)
    }

    /// Upper bound on the time until both contacts of the shadow come to rest, by the energy argument.
    fn time_to_rest(&self) -> Option<f64> {
        let full = self.frozen(&self.arms, self.qdot.z + self.dqdot.z);
        let mut gaps = Gaps::default();
        for i in 0..self.count() {
            gaps.h[i] = along(&self.contacts[i], &self.q).abs() + self.gap_off(i).abs();
            gaps.u[i] = self.rate(i);
        }
        time_to_rest(&full, &gaps)
    }

    /// Both contacts come to rest at a Zeno point of the local run, and soon in its shadow. The motion of the shadow until then is bounded,
    /// not followed.
    fn skip(&mut self, point: &ZenoRecord) -> Option<()> {
        if self.count() < 2 {
            return None;
        }
        self.slack += self.time_to_rest()?.max(point.at.clock.since(self.clock));
        self.arrive(point);
        self.latest = self.latest.max(self.late.abs());
        Some(())
    }

    /// A flight of duration `dt`. Contacts with zero gap must separate in the local run and in the shadow.
    #[inline]
    fn fly(&mut self, dt: f64) -> Result<(), ModelReason> {
        let v = self.velocity();
        for i in 0..self.count() {
            if self.touching[i] && !(self.rate(i) > 0.0) {
                return Err(ModelReason::OtherOrder);
            }
        }
        self.touching = [false; 2];
        self.advance(dt, self.fall);
        self.dq += self.dqdot * dt;
        self.turn();
        // A concave gap that is positive at both ends is positive in between.
        let concave = v.z * v.z * self.reach <= CONCAVE_ARC;
        let small = (self.q.z + self.dq.z).abs() <= SHADOW_TURN;
        if concave && small { Ok(()) } else { Err(ModelReason::Turns) }
    }

    /// Advances the local run.
    #[inline]
    fn advance(&mut self, dt: f64, acceleration: Vector3<f64>) {
        self.q += (self.qdot + acceleration * (0.5 * dt)) * dt;
        self.qdot += acceleration * dt;
    }

    /// Advances the shadow alone.
    #[inline]
    fn shift(&mut self, dt: f64, acceleration: Vector3<f64>) {
        let step = (self.velocity() + acceleration * (0.5 * dt)) * dt;
        self.dq += step;
        self.dqdot += acceleration * dt;
        self.late += dt;
        for (arm, k) in self.arms.iter_mut().zip(self.contacts) {
            arm.sag += arm.change * step.z;
            arm.change -= arm.c * step.z;
            arm.c += arm.b * step.z;
            arm.b = k.b + arm.change;
        }
    }

    /// Contact j has landed in the local run. Moves the shadow to the time at which its own gap is zero.
    #[inline]
    fn land(&mut self, j: usize, acceleration: Vector3<f64>) -> Result<(), ModelReason> {
        let (h, u) = (self.gap_off(j), self.rate(j));
        let (n, arm) = (self.contacts[j].normal, &self.arms[j]);
        let omega = self.qdot.z + self.dqdot.z;
        let pull = arm.c * omega * omega
            - (n.x * acceleration.x + n.y * acceleration.y + arm.b * acceleration.z);
        let change = 2.0 * pull * h;
        if !(u < 0.0 && change.abs() <= LANDING_SPEED_CHANGE * u * u) {
            return Err(ModelReason::OtherOrder);
        }
        self.shift(2.0 * h / ((u * u + change).sqrt() - u), acceleration);
        self.touching[j] = true;
        Ok(())
    }

    /// Checks that contact i, whose gap in the local run is `gap`, is above the terrain in the shadow, too.
    #[inline]
    fn clears(&self, i: usize, gap: f64) -> Result<(), ModelReason> {
        let clear = i >= self.count() || self.touching[i] || gap + self.gap_off(i) > 0.0;
        if clear { Ok(()) } else { Err(ModelReason::OtherOrder) }
    }

    /// Impact at contact j with the own-rate jump `jump` in the local run.
    #[inline]
    fn hit(&mut self, j: usize, jump: f64) -> Result<(), ModelReason> {
        let off = self.rate_off(j);
        if !(self.u[j] + off < 0.0) {
            return Err(ModelReason::OtherOrder);
        }
        let (k, arm) = (&self.contacts[j], &self.arms[j]);
        let local = self.velocity_change(k, k.b, jump);
        if !self.agrees() {
            // The difference of both velocity changes, in a form without cancellation.
            let (own, own_full) = (k.b * k.b + self.rho2, arm.b * arm.b + self.rho2);
            let per_own = jump / own;
            let more =
                (-(1.0 + k.restitution) * off - per_own * arm.change * (arm.b + k.b)) / own_full;
            let push = self.rho2 * more;
            let turn = arm.b * more + arm.change * per_own;
            self.dqdot += Vector3::new(k.normal.x * push, k.normal.y * push, turn);
        }
        self.qdot += local;
        Ok(())
    }

    /// Change of q̇ by an impulse that changes the gap rate of contact k by `jump`. The contact has this b.
    #[inline]
    fn velocity_change(&self, k: &ContactGeometry, b: f64, jump: f64) -> Vector3<f64> {
        let per_own = jump / (b * b + self.rho2);
        let push = self.rho2 * per_own;
        Vector3::new(k.normal.x * push, k.normal.y * push, b * per_own)
    }

    /// Change of q̇ by own-rate jumps at both contacts. If `jumps` has the time integrals of the jumps instead, the result is the change of
    /// q.
    fn velocity_changes(&self, arms: &[Arm; 2], jumps: [f64; 2]) -> Vector3<f64> {
        let each = self.contacts.iter().zip(arms).zip(jumps);
        each.map(|((k, arm), jump)| self.velocity_change(k, arm.b, jump)).sum()
    }

    /// The arms of the local run.
    fn nominal(&self) -> [Arm; 2] {
        let mut arms = self.arms;
        for (arm, k) in arms.iter_mut().zip(self.contacts) {
            *arm = Arm::nominal(k);
        }
        arms
    }

    /// The frozen model at these arms, for a body with angular velocity `omega`.
    fn frozen(&self, arms: &[Arm; 2], omega: f64) -> FrozenModel {
        let one = &self.contacts[0];
        let two = self.contacts.get(1).unwrap_or(&ContactGeometry::ABSENT);
        let normal = one.normal.dot(&two.normal);
        let (psi, phi) = couplings(arms[0].b, arms[1].b, normal, self.rho2);
        let pull = |k: &ContactGeometry, arm: &Arm| k.gravity + arm.c * omega * omega;
        let gravity = [pull(one, &arms[0]), pull(two, &arms[1])];
        FrozenModel::new(&LocalModel::frozen(LocalModelFields {
            gravity,
            psi,
            phi,
            restitution: [one.restitution, two.restitution],
        }))
    }

    /// The frozen models of the local run and of its shadow, at this instant.
    fn both_frozen(&self) -> (FrozenModel, FrozenModel) {
        let omega = self.qdot.z + self.dqdot.z;
        (self.frozen(&self.nominal(), 0.0), self.frozen(&self.arms, omega))
    }
}

/// N·q, without compensated summation.
fn along(k: &ContactGeometry, q: &Vector3<f64>) -> f64 {
    k.normal.x * q.x + k.normal.y * q.y + k.b * q.z
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::body::contact::Contact;
    use crate::body::posture::PostureFields;

    /// A body on contacts (x, slope) at y = 0, its centre of mass at this height.
    pub(crate) fn standing(feet: &[(f64, f64)], friction: f64, height: f64) -> Posture {
        let foot =
            |&(x, slope): &(f64, f64)| Contact { friction, ..Contact::at(x, 0.0) }.on_slope(slope);
        Posture::new(PostureFields {
            mass: 1.0,
            gyration_radius: 0.3,
            center_of_mass: [0.0, height],
            contacts: feet.iter().map(foot).collect(),
            restitution: 0.3,
            gravity: 9.81,
            ..PostureFields::default()
        })
        .unwrap()
    }

    #[test]
    fn exact_where_nothing_turns_the_body() {
        let dropped = State::at_rest([0.1, 1.0, 0.0]);
        let thrown = State::new([0.0, 1.0, 0.0], [0.5, 0.0, 0.0]);
        let spinning = State::new([0.0, 1.0, 0.0], [0.0, 0.0, 1e-9]);
        let ball = |friction| standing(&[(0.0, 0.0)], friction, 0.2);
        assert!(is_exact(&ball(0.0), &dropped) && is_exact(&ball(0.0), &thrown));
        assert!(!is_exact(&ball(0.0), &spinning));
        assert!(is_exact(&ball(0.5), &dropped)); // friction has no speed to act against
        assert!(!is_exact(&ball(0.5), &thrown)); // friction rotates the ball
        assert!(is_exact(&standing(&[(0.0, 0.0)], 0.5, 0.0), &thrown)); // a point mass
        assert!(!is_exact(&standing(&[(0.0, 0.3)], 0.5, 0.2), &dropped)); // the arm is not along the normal
    }
}
