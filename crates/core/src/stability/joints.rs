//! Stability of two contacts whose four rows are independent: each contact can slide in any direction, whatever the other one does. So it
//! is with joints under torques. The contacts come to rest after every small kick if the following holds:
//!
//! * gravity presses both contacts down, g > 0, and no contact jams alone: k_i = N_iM⁻¹(N_i − σμ_iT_i)ᵀ > 0;
//! * *both stay*: for both closed and the four pairs of signs σ of their sliding, A_ij = N_iM⁻¹(N_j − σ_jμ_jT_j)ᵀ has det A > 0 and λ =
//!   A⁻¹g > 0;
//! * *both stop*: the slide of both closed contacts ends;
//! * landings become slower, see below.
//!
//! Both stay: A is a P-matrix, so that a mode exists and is the only one. With |f_j| ≤ μ_jλ_j instead of sliding, λ > 0 holds by linearity
//! in each column. Forces for contacts that stop exist: a variational inequality on a square. That λ > 0 without friction follows too, so
//! that the energy bounds every frictionless flight, and one contact or both rest at its end. And while contact k slides to the right (R)
//! or to the left (L), or sticks, the other one falls: its gap has the acceleration −a, a = λ_m det A/A_kk > 0.
//!
//! *Both stop.* Let (λ*, f*) be the forces that hold the load, and Σ = S − CD⁻¹Cᵀ with S = TM⁻¹Tᵀ, C = TM⁻¹Nᵀ, D = NM⁻¹Nᵀ. While both are
//! closed v̇ = Σ(f − f*), hence d/dt ½v·Σ⁻¹v = −Σ_i |v_i| (μ_iλ_i + σ_i f*_i), negative if μ_iλ_i + σ_i f*_i > 0 for all four pairs of
//! signs. Otherwise the accelerations in the four quadrants of v and on their edges are followed: each edge slides to 0 or leads to the
//! next one, and one turn about 0 reduces |v|.
//!
//! **Bounded corners.** After a landing at contact j with speed 1 while the other one is closed, a frictionless flight ends with one
//! contact k at rest, the other one in the air with gap h and gap rate u. It lands with at most the speed
//!
//! ```text
//! K_j² = max over X = R, L of { u² + 2a_X h, u² + 2a_Z h, and 2a_Z h + (a_Z/a_X) u² if a_Z > a_X and u > 0 },
//! ```
//!
//! with Z the mode of contact k from rest, which must be unique: it slides in one direction until it stops, and then goes on with Z. If the
//! product of K over every cycle of landings is below 1, landing speeds and times decrease like a geometric series.

use crate::body::Mechanism;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;
use crate::stability::corner::Flights;
use crate::stability::local::{FromRest, Local, solve};
use crate::verified::Flight;

type I = Interval;

const SIDES: [f64; 2] = [1.0, -1.0];

/// Two contacts that slide independently.
struct Apart {
    local: Local,
    /// TM⁻¹Tᵀ
    tt: [[I; 2]; 2],
}

/// Forces and accelerations while both contacts slide, times det A.
struct PairSlide {
    /// det A
    det: I,
    /// λ det A
    force: [I; 2],
    /// v̇ det A
    along: [I; 2],
}

/// What follows when both contacts are closed, contact k slides with the sign σ, and the other one is at rest.
#[derive(Clone, Copy)]
enum Edge {
    /// The other one sticks, and k stops.
    Stops,
    /// The other one slides with this sign, until k stops. Its speed is then the speed of k times the factor.
    Leads(f64, I),
}

/// The growth of the landing speed over cycles of landings, if it is below 1 and the contacts certainly come to rest.
pub(super) fn shrinks(mechanism: &Mechanism, width: f64) -> Option<f64> {
    let (local, across) = Local::apart(mechanism, width)?;
    let tt = [[local.tt[0], across], [across, local.tt[1]]];
    let pair = Apart { local, tt };
    let ends = pair.presses() && pair.both_stay() && pair.both_stop();
    ends.then(|| pair.bounded_corners()).flatten()
}

impl Apart {
    /// Gravity presses both contacts down, and neither jams alone.
    fn presses(&self) -> bool {
        let l = &self.local;
        let soft = |k: usize| SIDES.iter().all(|side| l.stiffness(k, *side).is_positive());
        (0..2).all(|k| l.g[k].is_positive() && soft(k))
    }

    /// Both contacts are closed and slide with these signs.
    fn both_slide(&self, signs: [f64; 2]) -> PairSlide {
        let l = &self.local;
        let rub = [0, 1].map(|j| l.mu[j].times(signs[j]));
        let a = |i: usize, j: usize| l.nn[i][j] - rub[j] * l.tn[j][i];
        let [[a, b], [c, d]] = [[a(0, 0), a(0, 1)], [a(1, 0), a(1, 1)]];
        let det = a * d - b * c;
        let force = [l.g[0] * d - l.g[1] * b, l.g[1] * a - l.g[0] * c];
        let along = [0, 1].map(|i| {
            (0..2).fold(l.pull[i] * det, |sum, j| {
                sum + (l.tn[i][j] - self.tt[i][j] * rub[j]) * force[j]
            })
        });
        PairSlide { det, force, along }
    }

    fn all_slides() -> impl Iterator<Item = [f64; 2]> {
        SIDES.into_iter().flat_map(|one| SIDES.map(|two| [one, two]))
    }

    fn both_stay(&self) -> bool {
        Self::all_slides().all(|signs| {
            let PairSlide { det, force, .. } = self.both_slide(signs);
            det.is_positive() && force.iter().all(|f| f.is_positive())
        })
    }

    fn both_stop(&self) -> bool {
        self.friction_prevails() == Some(true) || self.edges_lead_to_rest() == Some(true)
    }

    /// Whether μ_iλ_i + σ_i f*_i > 0 for all slides; `None` if Σ may be singular.
    fn friction_prevails(&self) -> Option<bool> {
        let l = &self.local;
        // C D⁻¹ as rows, with D symmetric.
        let ratio = l.tn.map(|row| solve(l.nn, row));
        let dot = |x: [I; 2], y: [I; 2]| x[0] * y[0] + x[1] * y[1];
        let sigma = [0, 1].map(|i| [0, 1].map(|j| self.tt[i][j] - dot(ratio[i], l.tn[j])));
        let det = sigma[0][0] * sigma[1][1] - sigma[0][1] * sigma[1][0];
        if !det.is_positive() {
            return None;
        }
        let free = [0, 1].map(|i| -(l.pull[i] + dot(ratio[i], l.g)));
        let held = solve(sigma, free);
        Some(Self::all_slides().all(|signs| {
            let PairSlide { det, force, .. } = self.both_slide(signs);
            (0..2).all(|i| (l.mu[i] * force[i] / det + held[i].times(signs[i])).is_positive())
        }))
    }

    /// Whether every slide of both contacts ends, by the accelerations in the quadrants and on their edges; `None` if that is not certain.
    fn edges_lead_to_rest(&self) -> Option<bool> {
        let leaves = |signs: [f64; 2]| {
            let along = self.both_slide(signs).along;
            !(0..2).any(|i| along[i].times(signs[i]).is_negative())
        };
        if Self::all_slides().any(leaves) {
            return None;
        }
        let place = |side: f64| usize::from(side > 0.0);
        let mut edges = [[Edge::Stops; 2]; 2];
        for k in 0..2 {
            for side in SIDES {
                edges[k][place(side)] = self.edge(k, side)?;
            }
        }
        // The edges follow each other in one turn about 0, if none of them stops.
        let (mut k, mut side, mut factor) = (0, 1.0, I::ONE);
        for _ in 0..4 {
            match edges[k][place(side)] {
                Edge::Stops => return Some(true),
                Edge::Leads(next, by) => (k, side, factor) = (1 - k, next, factor * by),
            }
        }
        Some((I::ONE - factor).is_positive())
    }

    /// Contact k slides with this sign, the other one o is at rest. Its acceleration times det A is linear in σ_o from 1 to −1: it sticks
    /// if friction of either sign turns it back.
    fn edge(&self, k: usize, side: f64) -> Option<Edge> {
        let o = 1 - k;
        let slides = SIDES.map(|other| {
            let mut signs = [side; 2];
            signs[o] = other;
            self.both_slide(signs)
        });
        let [right, left] = slides.each_ref().map(|slide| slide.along[o].sign());
        let way = match (right, left) {
            (Some(-1), Some(1)) => {
                let [right, left] = &slides;
                // σ_o in between, at which o has no acceleration.
                let share = left.along[o] / (left.along[o] - right.along[o]);
                let along = right.along[k] * share + left.along[k] * (I::ONE - share);
                return along.times(side).is_negative().then_some(Edge::Stops);
            }
            (Some(1), Some(1)) => 0,
            (Some(-1), Some(-1)) => 1,
            _ => return None,
        };
        let PairSlide { along, .. } = slides[way];
        let slows = -along[k].times(side);
        slows.is_positive().then(|| Edge::Leads(SIDES[way], along[o].times(SIDES[way]) / slows))
    }

    /// The largest growth of the landing speed per landing in a cycle of landings, if it is below 1.
    fn bounded_corners(&self) -> Option<f64> {
        let l = &self.local;
        // a_R, a_L, a_Z of the other one, for each contact on the terrain.
        let mut falls = [[I::ZERO; 3]; 2];
        for (k, falls) in falls.iter_mut().enumerate() {
            let (FromRest::Fixed(rest) | FromRest::Slides(_, rest)) = l.starts_from_rest(k) else {
                return None;
            };
            let [right, left] = SIDES.map(|side| l.slide(k, side));
            *falls = [-right?.normal, -left?.normal, -rest.normal];
            if !falls.iter().all(|a| a.is_positive()) {
                return None;
            }
        }
        // The largest landing speed at contact m, the other one on the terrain.
        let speed = |m: usize, h: I, u: I| {
            let [right, left, rest] = falls[1 - m];
            let rate = u.square();
            let from_rest = (h * rest).times(2.0);
            let mut most = (rate + from_rest).hi;
            for a in [right, left] {
                most = most.max((rate + (h * a).times(2.0)).hi);
                if rest.hi > a.lo && u.hi > 0.0 {
                    most = most.max((from_rest + rest / a * rate).hi);
                }
            }
            I::from(most).sqrt().hi
        };
        let flights = Flights::of(l, true);
        // growth[j][m]: the largest landing speed at m after a landing at j with speed 1.
        let mut growth = [[0.0_f64; 2]; 2];
        for (j, growth) in growth.iter_mut().enumerate() {
            match (flights.ends[j], flights.cut[j]) {
                (Flight::One { kept, h, u, .. }, _) => growth[1 - kept] = speed(1 - kept, h, u),
                (Flight::Two { .. }, _) => {}
                (Flight::Cut { .. }, Some(end)) => {
                    *growth = [0, 1].map(|m| speed(m, end.h[m], end.u[m]));
                }
                _ => return None,
            }
        }
        let both = (I::from(growth[0][1]) * I::from(growth[1][0])).sqrt().hi;
        let most = growth[0][0].max(growth[1][1]).max(both);
        (most < 1.0).then_some(most)
    }
}
