//! Smooth frictionless motion of the full model while contacts are held, up to the event that ends it.
//!
//! A held contact keeps h_i = 0 by a normal force λ_i ≥ 0 (per unit mass):
//!
//! ```text
//! Σ_j (n_i·n_j + b_i b_j/ρ²) λ_j = g_i + c_i ω²        held contacts i, j
//! θ̈ = Σ_j b_j λ_j/ρ²,   ḣ_k = u_k,   u̇_k = −g_k − c_k ω² + Σ_j (n_k·n_j + b_k b_j/ρ²) λ_j
//! ḃ_i = −c_i ω,   ċ_i = b_i ω
//! ```
//!
//! Every right-hand side is a product or a quotient, so the Taylor coefficients of the motion follow from
//! each other exactly, to any order: the step is a polynomial, and its events are roots of polynomials.

use crate::flight::parabola_touchdown;
use crate::roots::{ORDER, first_root};
use crate::tumble::Tumble;

type Series = [f64; ORDER];

/// The motion as Taylor series in the time since the start of a step, with `unit` as unit of time.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    theta: Series,
    omega: Series,
    h: [Series; 2],
    u: [Series; 2],
    /// Displacement and velocity of the centre of mass, (x, y).
    r: [Series; 2],
    v: [Series; 2],
    force: [Series; 2],
    held: [bool; 2],
    /// A power of two, in s: coefficients stay in range on any scale of time, and scaling is exact.
    unit: f64,
    /// Time for which the series serve to the last digit, in units.
    reach: f64,
}

/// How a step ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum StepEnd {
    /// Nothing happened: go on with another step.
    Reach,
    /// This contact lands.
    Landing(usize),
    /// The force of this contact has come down to zero: it lifts off.
    LiftOff(usize),
}

fn product(a: &Series, b: &Series, k: usize) -> f64 {
    (0..=k).map(|j| a[j] * b[k - j]).sum()
}

impl Step {
    /// The Taylor series of the motion from this state on, with these contacts held.
    pub(crate) fn new(state: &Tumble, held: [bool; 2]) -> Self {
        let zero = [0.0; ORDER];
        let (rho2, n12) = (state.body.rho2, state.body.n12);
        let unit = unit_of_time(state);
        let square = unit * unit;
        let (mut b, mut c) = ([zero; 2], [zero; 2]);
        let mut s = Self {
            theta: zero,
            omega: zero,
            h: [zero; 2],
            u: [zero; 2],
            r: [zero; 2],
            v: [zero; 2],
            force: [zero; 2],
            held,
            unit,
            reach: f64::INFINITY,
        };
        (s.theta[0], s.omega[0]) = (state.spin.theta, state.spin.omega * unit);
        for i in 0..2 {
            (b[i][0], c[i][0]) = (state.b[i], state.c[i]);
            (s.h[i][0], s.u[i][0]) = (state.gaps.h[i], state.gaps.u[i] * unit);
            (s.r[i][0], s.v[i][0]) = (state.center.r[i], state.center.v[i] * unit);
        }
        let gravity = [0, 1].map(|i| state.body.contacts[i].gravity * square);
        let mut w2 = zero;
        // m[i][j] = n_i·n_j + b_i b_j/ρ², need[i] = g_i + c_i ω², det = m11 m22 − m12².
        let (mut m, mut need, mut det) = ([[zero; 2]; 2], [zero; 2], zero);
        for k in 0..ORDER {
            w2[k] = product(&s.omega, &s.omega, k);
            for i in 0..2 {
                need[i][k] = product(&c[i], &w2, k) + if k == 0 { gravity[i] } else { 0.0 };
                for j in 0..2 {
                    let normals = if i == j { 1.0 } else { n12 };
                    m[i][j][k] =
                        product(&b[i], &b[j], k) / rho2 + if k == 0 { normals } else { 0.0 };
                }
            }
            match held {
                [true, true] => {
                    det[k] = product(&m[0][0], &m[1][1], k) - product(&m[0][1], &m[0][1], k);
                    for i in 0..2 {
                        let j = 1 - i;
                        let top = product(&need[i], &m[j][j], k) - product(&need[j], &m[0][1], k);
                        s.force[i][k] = quotient(top, &s.force[i], &det, k);
                    }
                }
                _ => {
                    for i in 0..2 {
                        if held[i] {
                            s.force[i][k] = quotient(need[i][k], &s.force[i], &m[i][i], k);
                        }
                    }
                }
            }
            if k + 1 == ORDER {
                break;
            }
            let next = 1.0 / (k + 1) as f64;
            let spin = (0..2).map(|j| product(&b[j], &s.force[j], k)).sum::<f64>() / rho2;
            s.theta[k + 1] = s.omega[k] * next;
            s.omega[k + 1] = spin * next;
            for i in 0..2 {
                b[i][k + 1] = -product(&c[i], &s.omega, k) * next;
                c[i][k + 1] = product(&b[i], &s.omega, k) * next;
                let pull = if k == 0 && i == 1 { -state.body.gravity * square } else { 0.0 };
                let push: f64 =
                    (0..2).map(|j| state.body.contacts[j].normal[i] * s.force[j][k]).sum();
                s.r[i][k + 1] = s.v[i][k] * next;
                s.v[i][k + 1] = (push + pull) * next;
                if held[i] {
                    continue; // h_i = u_i = 0 exactly
                }
                s.h[i][k + 1] = s.u[i][k] * next;
                let push: f64 = (0..2).map(|j| product(&m[i][j], &s.force[j], k)).sum();
                s.u[i][k + 1] = (push - need[i][k]) * next;
            }
        }
        let scale = f64::EPSILON * 0.1;
        for series in [&b[0], &b[1], &c[0], &c[1], &s.omega, &s.force[0], &s.force[1]] {
            s.reach = s.reach.min(radius(series, scale));
        }
        s
    }

    /// The first event within the step, and when, in s. `limit`: no event later than this matters.
    pub(crate) fn first_event(&self, limit: f64) -> (f64, StepEnd) {
        let (t, event) = self.first_event_in_units(limit / self.unit);
        (t * self.unit, event)
    }

    fn first_event_in_units(&self, limit: f64) -> (f64, StepEnd) {
        let mut end = (self.reach.min(limit), StepEnd::Reach);
        if end.0 == f64::INFINITY {
            // Nothing turns: the free gap is a parabola.
            for i in (0..2).filter(|&i| !self.held[i] && self.h[i][0].is_finite()) {
                let t = parabola_touchdown(self.h[i][0], self.u[i][0], -self.u[i][1]);
                if t > 0.0 && t < end.0 {
                    end = (t, StepEnd::Landing(i));
                }
            }
            return end;
        }
        for i in 0..2 {
            let (series, event) = if self.held[i] {
                (&self.force[i], StepEnd::LiftOff(i))
            } else {
                (&self.h[i], StepEnd::Landing(i))
            };
            if series[0] < f64::INFINITY
                && let Some(t) = first_root(series, end.0)
                && t < end.0
            {
                end = (t, event);
            }
        }
        end
    }

    fn evaluate(series: &Series, t: f64) -> f64 {
        series.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    /// Whether nothing ever changes: the held contacts slide on uniformly, nothing turns.
    pub(crate) fn is_steady(&self) -> bool {
        self.reach == f64::INFINITY
    }

    /// Forces of the held contacts per unit mass, and the angular acceleration, at the start.
    pub(crate) fn push(&self) -> ([f64; 2], f64) {
        let square = self.unit * self.unit;
        ([self.force[0][0] / square, self.force[1][0] / square], self.omega[1] / square)
    }

    /// The state after `t` (s), which is within reach.
    pub(crate) fn at(&self, state: &Tumble, t: f64) -> Tumble {
        let value = |series: &Series| Self::evaluate(series, t / self.unit);
        let rate = |series: &Series| value(series) / self.unit;
        let mut after = *state;
        after.spin.theta = value(&self.theta);
        after.spin.omega = rate(&self.omega);
        for i in 0..2 {
            if state.gaps.h[i].is_finite() {
                after.gaps.h[i] = value(&self.h[i]).max(0.0);
                after.gaps.u[i] = rate(&self.u[i]);
            }
            after.center.r[i] = value(&self.r[i]);
            after.center.v[i] = rate(&self.v[i]);
        }
        after.refresh();
        after
    }
}

/// The power of two nearest below the time in which the body turns by about a radian, in s: 1/ω, or √(size/g)
/// where that is shorter.
fn unit_of_time(state: &Tumble) -> f64 {
    let size = (0..2).map(|i| libm::hypot(state.b[i], state.c[i])).fold(0.0, f64::max);
    let size = size + state.body.rho2.sqrt();
    let rate = state.spin.omega.abs().max((state.body.gravity / size).sqrt());
    if rate > 0.0 { libm::ldexp(1.0, -libm::ilogb(rate)) } else { 1.0 }
}

/// Coefficient k of top/bottom, given the ones before it.
fn quotient(top: f64, sofar: &Series, bottom: &Series, k: usize) -> f64 {
    let rest: f64 = (0..k).map(|j| sofar[j] * bottom[k - j]).sum();
    (top - rest) / bottom[0]
}

/// Time at which the last two terms of a series fall to `share` of its largest coefficient (times tᵏ).
fn radius(series: &Series, share: f64) -> f64 {
    let n = ORDER - 1;
    // |aₙ| tⁿ ≤ share · |aₖ| tᵏ for the largest of the first terms: take k = 0, else 1.
    let (k, size) = if series[0] != 0.0 { (0, series[0].abs()) } else { (1, series[1].abs()) };
    let reach = |j: usize| {
        if series[j] == 0.0 || size == 0.0 {
            f64::INFINITY
        } else {
            libm::pow(share * size / series[j].abs(), 1.0 / (j - k) as f64)
        }
    };
    reach(n).min(reach(n - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Contact;
    use crate::log::{Center, Spin};
    use crate::posture::{Fields, Posture};
    use crate::tumble::Body;
    use crate::zeno::Gaps;

    fn tall() -> Posture {
        Posture::new(Fields {
            mass: 1.0,
            gyration_radius: 0.4,
            center_of_mass: [0.0, 0.75],
            contacts: vec![Contact::at(-0.5, 0.0), Contact::at(0.5, 0.0)],
            restitution: 0.5,
            gravity: 9.81,
        })
        .unwrap()
    }

    /// Frictionless about one contact: ½ω²(b² + ρ²) − g c is constant.
    #[test]
    fn energy_of_a_held_contact_is_kept() {
        let posture = tall();
        let body = Body::new(posture.geometry(), posture.gyration_squared(), 9.81);
        let q = nalgebra::Vector3::new(0.0, 0.0, -0.2);
        let mut gaps = Gaps::default();
        gaps.h[0] = posture.gaps(&q)[0] - posture.gaps(&q)[1];
        let spin = Spin { theta: -0.2, omega: 0.0 };
        let mut state = Tumble::new(body, gaps, Center::default(), spin);
        let energy = |s: &Tumble| {
            let w = s.spin.omega;
            0.5 * w * w * (s.b[1] * s.b[1] + body.rho2) - 9.81 * s.c[1]
        };
        let (before, mut time) = (energy(&state), 0.0);
        loop {
            let step = Step::new(&state, [false, true]);
            let (t, end) = step.first_event(f64::INFINITY);
            state = step.at(&state, t);
            time += t;
            assert!((energy(&state) - before).abs() < 4e-15 * before.abs());
            if end == StepEnd::Landing(0) {
                break;
            }
            assert_eq!(end, StepEnd::Reach);
        }
        assert!(state.spin.theta.abs() < 1e-15, "{}", state.spin.theta);
        assert!(time > 0.1 && time < 0.5, "{time}");
    }
}
