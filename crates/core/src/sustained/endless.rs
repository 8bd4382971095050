//! Motions that never end. Paths in the plane of θ and ω do not cross, so a closed path encloses every motion that starts
//! inside it.

use nalgebra::Vector2;

use crate::collisions::log::Spin;
use crate::modes::Mode;
use crate::sustained::{BodyState, ContactState};
use crate::tolerance::SWING_REPEATS;

impl BodyState {
    /// The only closed contact, if the body cannot reach another one by sliding along the terrain.
    fn only(&self, word: &[Mode]) -> Option<usize> {
        let mut closed = (0..word.len()).filter(|&i| word[i] != Mode::Separate);
        let i = closed.next()?;
        let alone = closed.next().is_none();
        (alone && self.is_uniform(i)).then_some(i)
    }

    /// Whether the ground of all contacts has the direction and the speed of that of contact `i`.
    fn is_uniform(&self, i: usize) -> bool {
        let of = |p: &ContactState| (p.normal, p.surface_speed);
        self.points.iter().all(|p| of(p) == of(&self.points[i]))
    }

    /// Returns true if a body that slides on one contact moves away from the terrain of the others for ever: downhill, or on level ground
    /// in the direction of its centre of mass.
    fn slides_clear(&self, word: &[Mode]) -> bool {
        let mut closed = (0..word.len()).filter(|&i| word[i] != Mode::Separate);
        let (Some(i), None) = (closed.next(), closed.next()) else { return true };
        let (tangent, is_round) = (self.points[i].tangent, self.points[i].radius > 0.0);
        let speed = tangent.dot(&self.center.v);
        let way = if tangent.y == 0.0 { speed } else { -tangent.y };
        let clear = |p: &ContactState| p.normal.dot(&tangent) * way >= 0.0;
        word[i] == Mode::Fixed && !is_round || way * speed >= 0.0 && self.points.iter().all(clear)
    }
}

/// Returns true if one contact is closed.
fn is_single(word: &[Mode]) -> bool {
    word.iter().filter(|&&mode| mode != Mode::Separate).count() == 1
}

/// A motion, since its start, in which θ and ω do not depend on the other coordinates.
pub(super) struct ClosedMotion {
    kind: Drive,
    theta: f64,
    omega: f64,
    /// θ at the last three changes of the sign of ω.
    turned: [f64; 3],
    /// Number of changes of the sign of ω.
    turns: usize,
}

/// The kind of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drive {
    /// No sliding friction: one degree of freedom that keeps its energy.
    Smooth,
    /// The same with a contact that rolls, on level ground or not. Then the place on the ground follows from θ. Only on level ground is the
    /// motion the same after a turn.
    Rolls { level: bool },
    /// One contact slides down terrain that is too steep for friction to hold it: θ and ω do not depend on the other
    /// coordinates.
    Downhill,
    /// Anything else.
    Other,
}

impl ClosedMotion {
    pub(super) fn new(body: &BodyState, word: &[Mode]) -> Self {
        let rubs = |(p, mode): (&ContactState, &Mode)| mode.direction() * p.friction != 0.0;
        let downhill = |i: usize| {
            let p = &body.points[i];
            word[i] != Mode::Separate
                && -word[i].direction() * p.tangent.y > p.friction * p.normal.y
        };
        // Where the side slides on a corner of the ground, or a disc moves about one, its place changes the motion too.
        let slides = |mode: Mode| mode != Mode::Fixed && mode != Mode::Separate;
        let about = |i: usize| word[i] != Mode::Separate && body.points[i].corner.is_some();
        let along = |i: usize| slides(word[i]) && body.side_contact(i).is_some() || about(i);
        let round = |(p, mode): (&ContactState, &Mode)| *mode != Mode::Separate && p.radius > 0.0;
        let rolls = |(p, mode): &(&ContactState, &Mode)| **mode == Mode::Fixed && p.radius > 0.0;
        let pairs = || body.points.iter().zip(word);
        // Over surfaces of one speed the motion is that over a ground at rest, seen from the surfaces.
        let moves = body.points.iter().any(|p| p.surface_speed != 0.0) && !body.is_uniform(0);
        let kind = if moves || (0..word.len()).any(along) {
            Drive::Other
        } else if !pairs().any(rubs) {
            match pairs().find(rolls) {
                Some((p, _)) => Drive::Rolls { level: p.tangent.dot(&body.fall) == 0.0 },
                None => Drive::Smooth,
            }
        } else if is_single(word) && (0..word.len()).any(downhill) && !pairs().any(round) {
            Drive::Downhill
        } else {
            Drive::Other
        };
        let Spin { theta, omega } = body.spin;
        Self { kind, theta, omega, turned: [f64::NAN; 3], turns: 0 }
    }

    /// Returns true if the motion has passed all positions that it can reach: to and fro between two turning points, or once around.
    /// Without an event so far, none will come. With friction too, paths in the plane of θ and ω do not cross: a path whose last turning
    /// point is on or inside the last but two is closed in.
    pub(super) fn is_complete(&mut self, body: &BodyState, word: &[Mode]) -> bool {
        let Spin { theta, omega } = body.spin;
        if self.omega * omega < 0.0 {
            self.turns += 1;
            self.turned = [self.turned[1], self.turned[2], theta];
        }
        self.omega = omega;
        let clear = body.slides_clear(word);
        let around = (theta - self.theta).abs() > std::f64::consts::TAU;
        let [first, other, last] = self.turned;
        match self.kind {
            Drive::Rolls { level } => self.turns > 2 || level && clear && around,
            _ if !clear => false,
            Drive::Smooth => self.turns > 2 || around,
            Drive::Downhill => (last - other).abs() <= (first - other).abs(),
            Drive::Other => false,
        }
    }
}

/// A swing about a fixed contact. It begins where the contact stops sliding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Swing {
    contact: usize,
    /// Directions in which the contact slid, and in which the body turns.
    way: Mode,
    turns_left: bool,
    /// Whether the centre of mass is on the left of the contact.
    hangs_left: bool,
    /// The smallest and the largest rotation since then, in rad.
    turned: [f64; 2],
    /// Energy of the rotation about the contact, per unit mass.
    energy: f64,
}

impl Swing {
    pub(super) fn begins(
        body: &BodyState,
        word: &[Mode],
        stopped: Option<(usize, Mode)>,
    ) -> Option<Self> {
        let contact = body.only(word)?;
        let (i, way) = stopped?;
        if i != contact || word[i] != Mode::Fixed {
            return None;
        }
        let (p, omega) = (&body.points[contact], body.spin.omega);
        if p.place.sides != [f64::INFINITY; 2] || p.radius > 0.0 {
            return None; // it may slip to an end of its terrain, or roll there
        }
        // The centre of mass is at −(t b + n c) from the contact.
        let arm = p.arm();
        let inertia = p.b * p.b + p.c * p.c + body.rho2;
        let energy = 0.5 * omega * omega * inertia + body.fall.dot(&arm);
        let turned = [body.spin.theta; 2];
        let (turns_left, hangs_left) = (omega > 0.0, body.fall.perp(&arm) > 0.0);
        Some(Self { contact, way, turns_left, hangs_left, turned, energy })
    }

    /// Returns true if a later swing has no more energy than this one, and too little energy for any rotation that the body has not passed
    /// since. The energy of the next swing is a function of the energy of the last one. This function is assumed to be increasing, which is
    /// not proved. The energies then never increase again, and the body reaches no new rotation (`docs/theory.md`, motions without end).
    pub(super) fn encloses(&self, later: &Self, body: &BodyState) -> bool {
        let less = later.energy <= self.energy + SWING_REPEATS * self.energy.abs();
        let arm = body.points[self.contact].arm();
        let bounds = |theta: f64| {
            let (sin, cos) = libm::sincos(theta - body.spin.theta);
            let arm = Vector2::new(arm.x * cos - arm.y * sin, arm.x * sin + arm.y * cos);
            body.fall.dot(&arm) >= later.energy - SWING_REPEATS * later.energy.abs()
        };
        self.is_like(later) && less && self.turned.into_iter().all(bounds)
    }

    /// Adds the range of rotations that the body has passed.
    pub(super) fn passes(&mut self, [least, most]: [f64; 2]) {
        self.turned = [self.turned[0].min(least), self.turned[1].max(most)];
    }

    pub(super) fn is_like(&self, other: &Self) -> bool {
        let begin = |swing: &Self| (swing.contact, swing.way, swing.turns_left, swing.hangs_left);
        begin(self) == begin(other)
    }
}
