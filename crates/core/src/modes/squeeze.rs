//! The forces of two fixed contacts, with the internal force between them.

use nalgebra::Vector3;

use crate::math::mass_vector::MassVector;
use crate::modes::flats::{Flat, normal, tangent};
use crate::modes::rows::Row;
use crate::tolerance::{NO_INTERNAL_FORCE, TIE};

/// The forces of two fixed contacts. Three of them follow from the motion; one, the internal force τ, is free.
///
/// Of a body, the sum of the forces and its moment are known, and τ = (f_1 − f_2)·e/2 acts along the line between the contacts. With p = d/ρ,
/// e the unit vector from contact 1 to contact 2 and e⊥ = e turned by +90°:
///
/// ```text
/// f_2 = e (R·e/2 − τ) + e⊥ (M − p_1 × R)/|p_2 − p_1|      f_1 = R − f_2
/// ```
///
/// Of a mechanism, the forces f = (f_t,1, f_n,1, f_t,2, f_n,2) satisfy B f = rest with the rows B = [T_1 N_1 T_2 N_2] (3 × 4):
///
/// ```text
/// f = f_0 + τ z      B z = 0, |z|² = 2, z_k ∝ (−1)ᵏ det(B without column k)      f_0·z = 0
/// ```
///
/// The first component of z that is not zero is positive. For a rigid body z is ±(e, −e).
pub(super) struct Squeeze {
    /// Scaled forces without internal force, and their derivative by it.
    base: [[f64; 2]; 2],
    slope: [[f64; 2]; 2],
    /// Range of the internal forces that friction allows; if it allows none, both ends are the one that comes closest.
    pub(super) low: f64,
    pub(super) high: f64,
    /// One internal force of the range, in its interior if it has one.
    pub(super) inside: f64,
}

impl Squeeze {
    /// Forces whose sum and moment are `rest` = (R, M).
    #[inline(always)]
    pub(super) fn between(rows: [&Row; 2], rest: Vector3<f64>) -> Self {
        let [one, two] = rows;
        let (Some(first), Some(other)) = (one.arm, two.arm) else {
            return Self::of_rows(rows, rest);
        };
        let span = other - first;
        let length = span.norm();
        let e = span / length;
        let total = rest.xy();
        let lift = (rest.z - first.perp(&total)) / length;
        let half = 0.5 * total.dot(&e);
        let second = nalgebra::Vector2::new(half * e.x - lift * e.y, half * e.y + lift * e.x);
        let base = [one.turn(total - second), two.turn(second)];
        let slope = [one.turn(e), two.turn(-e)];
        Self::on(rows, base, slope)
    }

    /// The same for contacts of a mechanism whose rows span three dimensions.
    pub(super) fn spanned<V: MassVector>(rows: [&Row<V>; 2], rest: &V) -> Self {
        let mut span = Flat::everything(rest.len());
        for row in rows {
            for (along, _) in [normal(row), tangent(row)] {
                span = span.with((along, 0.0)).unwrap_or(span);
            }
        }
        let axes = span.planes();
        let along = |of: &V| MassVector::of(3, axes.iter().map(|(axis, _)| axis.dot(of)));
        let [one, two] = rows.map(|row| Row {
            normal: along(&row.normal),
            tangent: along(&row.tangent),
            arm: None,
            bias: row.bias,
            friction: row.friction,
            sliding: row.sliding,
            stretch: row.stretch,
        });
        Self::between([&one, &two], along(rest))
    }

    /// The same without arms.
    #[cold]
    #[inline(never)]
    fn of_rows(rows: [&Row; 2], rest: Vector3<f64>) -> Self {
        const OTHERS: [[usize; 3]; 4] = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
        const SIGNS: [f64; 4] = [1.0, -1.0, 1.0, -1.0];
        let stretch = [0, 0, 1, 1].map(|i: usize| rows[i].stretch);
        let [b0, b1, b2, b3] =
            [&rows[0].tangent, &rows[0].normal, &rows[1].tangent, &rows[1].normal];
        let b = [b0 * stretch[0], b1 * stretch[1], b2 * stretch[2], b3 * stretch[3]];
        let det = |[i, j, k]: [usize; 3]| b[i].dot(&b[j].cross(&b[k]));
        let mut z = [0, 1, 2, 3].map(|k: usize| SIGNS[k] * det(OTHERS[k]));
        let length = (0.5 * z.iter().map(|part| part * part).sum::<f64>()).sqrt();
        for part in &mut z {
            *part = if part.abs() > NO_INTERNAL_FORCE * length { *part } else { 0.0 };
        }
        let first = z.iter().copied().find(|part| *part != 0.0);
        let sign = 1.0_f64.copysign(first.unwrap_or(1.0));
        // With the largest component of z set to zero the three others follow by Cramer's rule, and then the part along z is removed.
        let largest = (0..4).fold(0, |most, k| if z[k].abs() > z[most].abs() { k } else { most });
        let [i, j, k] = OTHERS[largest];
        let volume = det(OTHERS[largest]);
        let mut f = [0.0; 4];
        f[i] = rest.dot(&b[j].cross(&b[k])) / volume;
        f[j] = rest.dot(&b[k].cross(&b[i])) / volume;
        f[k] = rest.dot(&b[i].cross(&b[j])) / volume;
        z = z.map(|part| sign * part / length);
        let along = 0.5 * (0..4).map(|k| f[k] * z[k]).sum::<f64>();
        let scaled = |of: [f64; 4]| {
            [[of[0] * stretch[0], of[1] * stretch[1]], [of[2] * stretch[2], of[3] * stretch[3]]]
        };
        Self::on(rows, scaled([0, 1, 2, 3].map(|k| f[k] - along * z[k])), scaled(z))
    }

    /// The forces base + τ slope of contacts with this friction.
    #[inline(always)]
    fn on(rows: [&Row; 2], base: [[f64; 2]; 2], slope: [[f64; 2]; 2]) -> Self {
        let [one, two] = rows;
        // f_n ≥ 0 and both sides of the cone, as value + τ slope ≥ 0.
        let of = |row: &Row, [f_t, f_n]: [f64; 2], [s_t, s_n]: [f64; 2]| {
            let (mu, unit) = (row.friction, 1.0 / (1.0 + row.friction));
            [
                (f_n, s_n),
                ((mu * f_n - f_t) * unit, (mu * s_n - s_t) * unit),
                ((mu * f_n + f_t) * unit, (mu * s_n + s_t) * unit),
            ]
        };
        let tests = [of(one, base[0], slope[0]), of(two, base[1], slope[1])];
        let tests = tests.as_flattened();
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for &(value, slope) in tests {
            if slope > 0.0 {
                low = low.max(-value / slope);
            } else if slope < 0.0 {
                high = high.min(-value / slope);
            }
        }
        let mut inside = match (low.is_finite(), high.is_finite()) {
            (true, true) => 0.5 * (low + high),
            (true, false) => low + 1.0 + low.abs(),
            _ => high - 1.0 - high.abs(),
        };
        // If friction allows just one internal force, it is taken.
        if low != high && !(least(tests, inside) > TIE) {
            inside = best(tests, inside);
        }
        if !(low <= high) {
            (low, high) = (inside, inside);
        }
        Self { base, slope, low, high, inside }
    }

    /// The smallest forces. The components across the line between the contacts are given, and so is the sum of the components along
    /// it: the smallest forces have the least internal force.
    pub(super) fn smallest(&self) -> [[f64; 2]; 2] {
        self.forces(0.0_f64.max(self.low).min(self.high))
    }

    /// Scaled forces with the internal force `tau`.
    #[inline(always)]
    pub(super) fn forces(&self, tau: f64) -> [[f64; 2]; 2] {
        let at = |i: usize, k: usize| self.base[i][k] + tau * self.slope[i][k];
        [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]]
    }
}

/// The smallest of the tests value + τ slope.
fn least(tests: &[(f64, f64)], tau: f64) -> f64 {
    tests.iter().map(|(value, slope)| value + tau * slope).fold(f64::INFINITY, f64::min)
}

/// The internal force at which the smallest test is largest: two tests are equal there. `tau` is another candidate.
#[cold]
fn best(tests: &[(f64, f64)], tau: f64) -> f64 {
    let mut best = tau;
    for (k, (v, s)) in tests.iter().enumerate() {
        for (w, r) in &tests[k + 1..] {
            let tau = (w - v) / (s - r);
            if tau.is_finite() && least(tests, tau) > least(tests, best) {
                best = tau;
            }
        }
    }
    best
}
