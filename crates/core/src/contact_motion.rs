//! Smooth motion while contacts are held in a mode, up to the event that ends it.
//!
//! A held contact keeps a_n = 0 by a normal force λ ≥ 0, a fixed one also a_t = 0 by a tangential force τ; where it
//! slides, τ = −σμλ with σ = sign v_t (all per unit mass):
//!
//! ```text
//! n_i·v̇ + b_i ω̇ = c_i ω²,   t_i·v̇ − c_i ω̇ = b_i ω²
//! v̇ = (0, −g) + Σ_j (n_j λ_j + t_j τ_j),   ρ² ω̇ = Σ_j (b_j λ_j − c_j τ_j)
//! ḃ_i = −c_i ω,   ċ_i = b_i ω
//! ```
//!
//! Every right-hand side is a product or a quotient, so the Taylor coefficients of the motion follow from
//! each other exactly, to any order: the step is a polynomial, and its events are roots of polynomials.

mod jam;
pub(crate) mod next_order;
mod rows;
mod series;
mod step;

use nalgebra::Vector2;

pub(crate) use self::step::{ORDERS, Step, StepEnd};
use crate::contact::PerContact;
use crate::log::{Center, Spin};
use crate::modes::Mode;
use crate::terrain::Place;
use crate::trig::Turn;

/// Bounds of the rounding in a gap, since it was last exactly zero (in m), and in its rate (in m/s). In an accumulation of
/// impacts they shrink with the gaps and the rates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rounding {
    pub(crate) gap: f64,
    pub(crate) rate: f64,
}

/// A contact at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) normal: Vector2<f64>,
    pub(crate) tangent: Vector2<f64>,
    pub(crate) friction: f64,
    pub(crate) b: f64,
    pub(crate) c: f64,
    /// (t·r + b, n·r + c) where it began to be held, if it is: its place, up to a constant.
    pub(crate) held: Option<[f64; 2]>,
    pub(crate) place: Place,
    /// Gap and its rate; a gap of ∞ where there is nothing to meet.
    pub(crate) h: f64,
    /// Depth below the piece of terrain over the point, in m, if it came there from beside: its gap is ∞ until it has risen out of it.
    /// Otherwise zero.
    pub(crate) depth: f64,
    pub(crate) u: f64,
    pub(crate) rounding: Rounding,
}

impl Point {
    /// Arm from the centre of mass, world axes, in m.
    pub(crate) fn arm(&self) -> Vector2<f64> {
        self.tangent * self.b + self.normal * self.c
    }

    /// b and c after a turn.
    pub(crate) fn turned(&self, turn: &Turn) -> (f64, f64) {
        let (b, c) = (self.b, self.c);
        (b - (b * turn.versed + c * turn.sin), c - (c * turn.versed - b * turn.sin))
    }
}

/// A body at an instant.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stance {
    pub(crate) points: PerContact<Point>,
    pub(crate) center: Center,
    pub(crate) spin: Spin,
    /// ρ²
    pub(crate) rho2: f64,
    pub(crate) gravity: f64,
    /// ω² of the moment at which b, c and the bend of the paths were frozen; `None`: nothing is.
    pub(crate) frozen: Option<f64>,
}

impl Stance {
    /// Tangential speed v_t = t·v − c ω of a contact point.
    pub(crate) fn slip(&self, i: usize) -> f64 {
        let p = &self.points[i];
        p.tangent.dot(&self.center.v) - p.c * self.spin.omega
    }

    /// Kinetic energy per unit mass.
    fn kinetic(&self) -> f64 {
        0.5 * (self.center.v.norm_squared() + self.rho2 * self.spin.omega * self.spin.omega)
    }

    /// The other point of a contact in a vertex of its terrain.
    pub(crate) fn twin(&self, i: usize) -> Option<usize> {
        let contact = |j: usize| self.points[j].place.contact;
        (0..self.points.len()).find(|&j| j != i && contact(j) == contact(i))
    }

    /// Whether point `i` is fixed by something: by friction, or in a vertex.
    fn sticks(&self, i: usize, modes: &[Mode]) -> bool {
        let held = self.points[i].friction > 0.0 || self.twin(i).is_some();
        modes[i] == Mode::Fixed && held
    }

    /// The other of two fixed points that hold a contact in a vertex. The contact is held while the sum of their forces lies
    /// in the hull of their friction cones; how the force is shared between them has no consequence, so that the rows of
    /// the first of them represent both.
    fn partner(&self, i: usize, modes: &[Mode]) -> Option<usize> {
        let fixed = |j: &usize| modes[*j] == Mode::Fixed;
        self.twin(i).filter(fixed).filter(|_| fixed(&i))
    }

    /// Whether b and c, where they are frozen, belong to the motion itself and not to a moment of it: then they turn a
    /// velocity into the rates of the contacts.
    fn has_rows(&self) -> bool {
        self.frozen.is_none_or(|bend| bend == 0.0)
    }
}
