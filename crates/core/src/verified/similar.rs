//! Self-similar ends of a flight: a cycle of impacts that repeats for ever, each time smaller by the same factor.
//!
//! Let F be the map of shapes from impact to impact (`shape.rs`), and f the factor of the size u_a. Near a cycle of p impacts at c let J be
//! the product of the derivatives, and X its eigenvectors (real and imaginary part, if they are complex). The box Z = c + X[−r, r]² is
//! mapped into itself by q impacts, q a multiple of p, if
//!
//! ```text
//! X⁻¹(F^q(c) − c) + (X⁻¹ DF^q(Z) X)[−r, r]² ⊂ (−r, r)²     [mean value theorem; the matrices are multiplied first].
//! ```
//!
//! If also the order of the landings is certain on all of Z and its images, then the impacts from Z never end. If a round of q impacts, of
//! duration T u_a, multiplies u_a by f < 1, both gaps and both rates tend to zero within the time u_a T/(1 − f).

use crate::math::ball::Ball;
use crate::math::real::Enclosed;
use crate::tolerance::SIMILAR_BOX;
use crate::verified::shape::{I, Matrix, Shape, Step, difference, image, inverse, product, sum};
use crate::verified::{Model, interval};

/// Longest cycle, and largest number of impacts after which the box must lie in itself.
const LONGEST: usize = 12;
const ROUND: usize = 96;
/// Share of a box that its linear image may fill. The turn of complex eigenvectors makes the image of a square larger by up to √2.
const FILLED: f64 = 0.6;
/// Number of Newton's steps from a shape to the cycle. Their errors shrink quadratically.
const NEWTON_STEPS: usize = 3;
/// Number of proofs that are tried in a flight.
const PROOFS: usize = 4;

/// The eigenvectors of a matrix as columns (real and imaginary part of complex ones), with largest entry 1, and the largest absolute
/// eigenvalue.
fn eigenvectors([[a, b], [c, d]]: [[f64; 2]; 2]) -> ([[f64; 2]; 2], f64) {
    let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
    let square = half * half + b * c;
    let size = |x: [f64; 2]| x[0].abs().max(x[1].abs());
    if square < 0.0 {
        let (real, turn) = ([b, -half], (-square).sqrt());
        let unit = size(real).max(turn);
        return ([[b / unit, 0.0], [-half / unit, turn / unit]], (a * d - b * c).sqrt());
    }
    let root = square.sqrt();
    // (J − λ)x = 0, by the row with the larger entries: λ − a = ±root − half, λ − d = ±root + half.
    let column = |side: f64| {
        let (first, second) = (side * root - half, side * root + half);
        let x = if first.abs() > second.abs() { [b, first] } else { [second, c] };
        x.map(|part| part / size(x))
    };
    let ([p, q], [r, s]) = (column(1.0), column(-1.0));
    ([[p, r], [q, s]], mean.abs() + root)
}

/// The impacts of a flight up to now, to find one of the same shape as a few impacts before.
pub(super) struct Recurrences {
    /// Contact and shape of the last impacts, in a circle.
    last: [(usize, [f64; 2]); LONGEST + 1],
    count: usize,
    proofs: usize,
    /// Largest difference of two shapes that counts as the same.
    limit: f64,
}

impl Recurrences {
    pub(super) fn new() -> Self {
        let limit = SIMILAR_BOX;
        Self { last: [(0, [0.0; 2]); LONGEST + 1], count: 0, proofs: 0, limit }
    }

    /// Adds an impact. The number of impacts since one of the same shape, if there is one.
    pub(super) fn period(&mut self, shape: &Shape<I>) -> Option<usize> {
        let (a, now) = (shape.contact, shape.at.map(I::middle));
        let places = self.last.len();
        let most = if self.proofs < PROOFS { LONGEST.min(self.count) } else { 0 };
        let found = (1..=most).find(|back| {
            let (contact, [v, y]) = self.last[(self.count - back) % places];
            let off = ((now[0] - v).abs() / (1.0 + v.abs())).max((now[1] - y).abs() / y);
            contact == a && off <= self.limit
        });
        self.last[self.count % places] = (a, now);
        self.count += 1;
        if found.is_some() {
            // If the proof fails, the next one is tried much nearer to the cycle.
            self.limit *= 0.1;
            self.proofs += 1;
        }
        found
    }
}

impl Model<I> {
    /// The time until both contacts rest, from the shape `now` and the size 1, if it is about the shape `period` impacts before; `None`
    /// without a proof that the impacts of this cycle repeat for ever. `fine`: the same model with more bits.
    pub(super) fn self_similar(
        &self,
        fine: &Model<Ball>,
        now: Shape<I>,
        period: usize,
    ) -> Option<I> {
        // Newton's steps to the cycle: (1 − J)(c' − c) = F^p(c) − c.
        let unit = [[I::ONE, I::ZERO], [I::ZERO, I::ONE]];
        let mut center = Shape { at: now.at.map(|x| I::from(x.middle())), ..now };
        let mut j = unit;
        for _ in 0..NEWTON_STEPS {
            let mut shape = center;
            j = unit;
            for _ in 0..period {
                let step = shape.step(self)?;
                (shape, j) = (step.shape, product(step.tangent, j));
            }
            let slope = [0, 1].map(|i| difference(unit[i], j[i]));
            let change = image(inverse(slope)?, difference(shape.at, center.at));
            center.at = sum(center.at, change).map(|x| I::from(x.middle()));
        }
        // The units of v and y are 1 + |v| and y.
        let [v, y] = center.at.map(I::middle);
        let unit = [1.0 + v.abs(), y];
        let scaled = |i: usize, k: usize| j[i][k].middle() * unit[k] / unit[i];
        let (x, mu) = eigenvectors([0, 1].map(|i| [0, 1].map(|k| scaled(i, k))));
        let rounds = (libm::log(FILLED) / libm::log(mu)).ceil().max(1.0);
        let impacts = rounds * period as f64;
        if !(mu < 1.0 && impacts <= ROUND as f64) {
            return None;
        }
        let x = [0, 1].map(|i| x[i].map(|part| I::from(part * unit[i])));
        let back = inverse(x)?;
        [1.0, 0.1, 0.01].into_iter().find_map(|smaller| {
            let r = SIMILAR_BOX * smaller;
            let round = self.round(fine, center, x, r, impacts as usize)?;
            let off = image(back, difference(round.shape.at, center.at));
            let spread = image(product(back, round.tangent), [I::new(-r, r); 2]);
            let inside = |x: I| -r < x.lo && x.hi < r;
            let kept = sum(off, spread).into_iter().all(inside)
                && image(back, difference(now.at, center.at)).into_iter().all(inside)
                && round.shape.contact == now.contact
                && round.factor.hi < 1.0;
            kept.then(|| round.time / (I::ONE - round.factor))
        })
    }

    /// This number of impacts: the image of the centre; the matrix A of the image of the box c + X[−r, r]², which lies in this image +
    /// A[−r, r]²; and factor and duration for all of the box.
    fn round(
        &self,
        fine: &Model<Ball>,
        center: Shape<I>,
        x: Matrix,
        r: f64,
        impacts: usize,
    ) -> Option<Step> {
        let mut all = Step { shape: center, factor: I::ONE, time: I::ZERO, tangent: x };
        let mut middle =
            Shape { contact: center.contact, at: center.at.map(|x| Ball::from(x.middle())) };
        for _ in 0..impacts {
            let reach = image(all.tangent, [I::new(-r, r); 2]);
            let at = sum(all.shape.at, reach);
            let step = Shape { at, ..all.shape }.step(self)?;
            middle = middle.next(fine)?.shape;
            if middle.contact != step.shape.contact {
                return None;
            }
            all = Step {
                shape: Shape { contact: middle.contact, at: middle.at.map(interval) },
                time: all.time + all.factor * step.time,
                factor: all.factor * step.factor,
                tangent: product(step.tangent, all.tangent),
            };
        }
        Some(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verified::Flight;

    /// The V of tan β = 8/15 with contacts at (∓1, 8/15), ρ = .4, e = .1, and the centre of mass at (−.9537479270315091,
    /// −.055276381909547756). Each round of two impacts multiplies the distance from the cycle by μ = .57277431 and, on average, the speeds
    /// by exp(−.8157) per impact. The time was computed with 120 digits, impact by impact, until the speeds were below 1e-30.
    #[test]
    fn a_self_similar_flight_ends_with_both_contacts_at_rest() {
        let (g, psi, e) = ([8.655882352941177; 2], [2.0948513629276316, 0.1313191404222805], 0.1);
        let rough = Model::new(g.map(I::from), psi.map(I::from), [I::from(e); 2], 2);
        let fine = Model::new(g.map(Ball::from), psi.map(Ball::from), [Ball::from(e); 2], 2);
        let flight = Flight::after_corner_finely(&rough, &fine, 1, [false; 2], None);
        let Flight::Two { t } = flight else { panic!("{flight:?}") };
        let exact = 1.0451987326589452e-5;
        assert!(t.lo <= exact && exact <= t.hi && t.hi - t.lo < 1e-3 * exact, "{t:?}");
        let after_contact_1 = Flight::after_corner(&rough, 0, [false; 2], None);
        assert!(matches!(after_contact_1, Flight::One { kept: 0, .. }), "{after_contact_1:?}");
    }

    #[test]
    fn eigenvectors_span_an_invariant_plane() {
        for matrix in
            [[[0.3, 0.2], [-0.4, 0.1]], [[0.5, 0.2], [0.1, -0.3]], [[0.2, 0.0], [1.0, 0.4]]]
        {
            let (x, mu) = eigenvectors(matrix);
            let [[p, r], [q, s]] = x;
            let det = p * s - q * r;
            let back = [[s / det, -r / det], [-q / det, p / det]];
            let times = |a: [[f64; 2]; 2], b: [[f64; 2]; 2]| {
                a.map(|row| [0, 1].map(|k| row[0] * b[0][k] + row[1] * b[1][k]))
            };
            // Diagonal, or a rotation times |μ|.
            let [[a, b], [c, d]] = times(back, times(matrix, x));
            let rounding = 1e-15;
            let rotates = (a - d).abs() < rounding && (b + c).abs() < rounding;
            assert!(rotates || b.abs() + c.abs() < rounding, "{matrix:?}");
            let size = if rotates { a.hypot(b) } else { a.abs().max(d.abs()) };
            assert!((size - mu).abs() < rounding, "{matrix:?} {size} {mu}");
        }
    }
}
