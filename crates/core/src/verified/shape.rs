//! The state after an impact, up to its size.
//!
//! After an impact at a the *shape* is v = u_b/u_a and y = h_b/u_a²; the size is u_a. The map from impact to impact is the same at every
//! size:
//!
//! ```text
//! hit again:   f = e_a     ∂(v', y')/∂(v, y) = [1/e_a, 0; τ/e_a², 1/e_a²]
//! b lands:     f = e_b s   with s² = v² + 2g_b y,  ∂s = (v, g_b)/s,  ∂τ = (τ, 1)/s,  w = 1 − g_a τ:
//!              ∂v' = −w/(f s) ∂s − g_a/f ∂τ     ∂y' = −2y'/s ∂s + w/f² ∂τ
//! ```
//!
//! with f the factor of the size and τ u_a the duration of the flight.

use crate::math::ball::Ball;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::verified::{Gap, Model, Motion, interval, one};

pub(super) type I = Interval;
pub(super) type Matrix = [[I; 2]; 2];

/// The shape after an impact at `contact`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape<T> {
    pub(super) contact: usize,
    /// (v, y)
    pub(super) at: [T; 2],
}

/// The next impact: its shape, and the flight until then.
pub(super) struct Flown<T> {
    pub(super) shape: Shape<T>,
    factor: T,
    time: T,
}

/// From an impact to the next one, for all of a set of shapes.
pub(super) struct Step {
    pub(super) shape: Shape<I>,
    pub(super) factor: I,
    pub(super) time: I,
    pub(super) tangent: Matrix,
}

impl<T: Enclosed> Shape<T> {
    pub(super) fn of(gaps: [Gap<T>; 2], contact: usize) -> Option<Self> {
        let (u, Gap { h, u: rate }) = (gaps[contact].u, gaps[1 - contact]);
        Some(Self { contact, at: [rate.over(u)?, h.over(u.square())?] })
    }

    /// The gaps at size 1.
    pub(super) fn gaps(&self) -> [Gap<T>; 2] {
        let [u, h] = self.at;
        let mut gaps = [Gap { h, u }; 2];
        gaps[self.contact] = Gap { h: T::ZERO, u: one() };
        gaps
    }

    /// `None` unless the next impact is certain.
    pub(super) fn next(&self, m: &Model<T>) -> Option<Flown<T>> {
        let mut motion = Motion::new(m, self.gaps());
        let (hit, time) = motion.next(self.contact).ok()?;
        Some(Flown { shape: Self::of(motion.gaps, hit)?, factor: motion.gaps[hit].u, time })
    }
}

impl Shape<I> {
    /// `None` unless the next impact is certain.
    pub(super) fn step(&self, m: &Model<I>) -> Option<Step> {
        let (a, [v, y]) = (self.contact, self.at);
        if !y.is_not_negative() {
            return None;
        }
        let Flown { shape, factor: f, time } = self.next(m)?;
        let hit = shape.contact;
        let tangent = if hit == a {
            let inverse = I::ONE.over(f)?;
            [[inverse, I::ZERO], [time * inverse.square(), inverse.square()]]
        } else {
            let s = f.over(m.e[hit])?;
            let w = I::ONE - m.g[a] * time;
            let (of_s, of_time) = ([v / s, m.g[hit] / s], [time / s, I::ONE / s]);
            let row = |by_s: I, by_time: I| [0, 1].map(|k| by_s * of_s[k] + by_time * of_time[k]);
            [
                row(-(w / (f * s)), -(m.g[a] / f)),
                row(-(shape.at[1].scaled(2.0) / s), w / f.square()),
            ]
        };
        Some(Step { shape, factor: f, time, tangent })
    }
}

pub(super) fn product(a: Matrix, b: Matrix) -> Matrix {
    a.map(|row| [0, 1].map(|k| row[0] * b[0][k] + row[1] * b[1][k]))
}

pub(super) fn image(a: Matrix, x: [I; 2]) -> [I; 2] {
    a.map(|row| row[0] * x[0] + row[1] * x[1])
}

pub(super) fn inverse([[a, b], [c, d]]: Matrix) -> Option<Matrix> {
    let one = I::ONE.over(a * d - b * c)?;
    Some([[d * one, -b * one], [-c * one, a * one]])
}

pub(super) fn sum(x: [I; 2], y: [I; 2]) -> [I; 2] {
    [x[0] + y[0], x[1] + y[1]]
}

pub(super) fn difference(x: [I; 2], y: [I; 2]) -> [I; 2] {
    [x[0] - y[0], x[1] - y[1]]
}

/// Shapes c + Q R, with c of 106 bits, a rotation Q and a box R. Q turns with the set, so that a set that becomes long and narrow is not
/// replaced by a square around it [Lohner 1987].
pub(super) struct Frame {
    center: Shape<Ball>,
    turn: Matrix,
    off: [I; 2],
}

impl Frame {
    pub(super) fn new(shape: Shape<Ball>) -> Self {
        let (center, off) = parts(shape);
        Self { center, off, turn: [[I::ONE, I::ZERO], [I::ZERO, I::ONE]] }
    }

    /// A box around all shapes.
    pub(super) fn shapes(&self) -> Shape<I> {
        let Shape { contact, at } = self.center;
        Shape { contact, at: sum(at.map(interval), image(self.turn, self.off)) }
    }

    /// The next impact of all shapes; factor of the size, and time. `None` unless it is certain.
    ///
    /// With c' the image of c and D the derivatives on a box around all shapes, the images lie in c' + D Q R [mean value theorem].
    pub(super) fn step(&mut self, fine: &Model<Ball>, rough: &Model<I>) -> Option<(I, I)> {
        let step = self.shapes().step(rough)?;
        let image_of_center = self.center.next(fine)?.shape;
        if image_of_center.contact != step.shape.contact {
            return None;
        }
        let (center, rounding) = parts(image_of_center);
        let long = product(step.tangent, self.turn);
        let turn = rotation_along(long, self.off);
        let back = inverse(turn)?;
        self.off = sum(image(product(back, long), self.off), image(back, rounding));
        (self.center, self.turn) = (center, turn);
        Some((step.factor, step.time))
    }
}

/// The centre of a shape, and what is off it.
fn parts(shape: Shape<Ball>) -> (Shape<Ball>, [I; 2]) {
    let center = shape.at.map(Ball::center);
    let off = [0, 1].map(|k| interval(shape.at[k] - center[k]));
    (Shape { at: center, ..shape }, off)
}

/// The rotation that turns the first axis along the longer one of the images of two edges of a box.
fn rotation_along(a: Matrix, edges: [I; 2]) -> Matrix {
    let image = |k: usize| {
        let length = edges[k].hi - edges[k].lo;
        a.map(|row| row[k].middle() * length)
    };
    let [first, second] = [image(0), image(1)];
    let length = |x: [f64; 2]| (x[0] * x[0] + x[1] * x[1]).sqrt();
    let longer = if length(first) >= length(second) { first } else { second };
    if !(length(longer) > 0.0) {
        return [[I::ONE, I::ZERO], [I::ZERO, I::ONE]];
    }
    let [x, y] = longer.map(|part| I::from(part / length(longer)));
    [[x, -y], [y, x]]
}
