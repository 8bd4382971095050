//! Regular motion of a body that turns, on two contacts with one level ground, see [`regular`](crate::collisions::regular).

use nalgebra::{Vector2, Vector3};

use crate::collisions::full::FullState;
use crate::collisions::full::plain::{FullConstants, FullLoopState};
use crate::collisions::log::{Center, Spin};
use crate::collisions::regular::{self, Basis, Cycle, Regular, RegularSum};
use crate::math::clock::Clock;
use crate::math::turn::Turn;
use crate::zeno::Gaps;

/// Most steps to the rotation of a given energy.
const NEWTON: usize = 30;
/// Steps to the rotation of given gaps, from one that is known up to rounding errors of many impacts.
const GAP_STEPS: usize = 2;

/// A motion of this body after impacts at contact `a`.
struct Full<'s> {
    state: &'s FullState,
    constants: FullConstants,
    a: usize,
    /// The energy of the size 1 per unit mass.
    energy: f64,
}

/// Speed of the centre of mass along the normal, spin, and height of the centre of mass above its place at rest.
struct Place {
    speed: f64,
    omega: f64,
    height: f64,
    energy: f64,
}

impl FullState {
    /// Both contacts are over one level ground, and lie on it at θ = 0.
    fn is_level(&self) -> bool {
        let [one, two] = &self.body.contacts;
        one.normal == two.normal && [one.offset, two.offset] == [0.0; 2] && one.gravity > 0.0
    }

    /// The motion of the centre of mass along the normal while contact `a` touches.
    fn place(&self, a: usize) -> Place {
        let (k, rates) = (&self.body.contacts[a], self.gaps.u);
        let omega = (rates[a] - rates[1 - a]) / (self.b[a] - self.b[1 - a]);
        let speed = rates[a] - self.b[a] * omega;
        let turn = Turn::by(self.spin.theta);
        let height = -k.gap(&Vector3::zeros(), &turn);
        let energy = 0.5 * (speed * speed + self.body.rho2 * omega * omega) + k.gravity * height;
        Place { speed, omega, height, energy }
    }

    /// The same state with the rotation that follows from its gaps. Spin and rotation, which follow from the impulses, have more rounding errors.
    fn at_gap(&self, a: usize) -> Self {
        let (b, mut state) = (1 - a, *self);
        for _ in 0..GAP_STEPS {
            let turn = Turn::by(state.spin.theta);
            let [of_a, of_b] = [a, b].map(|i| self.body.contacts[i].gap(&Vector3::zeros(), &turn));
            state.spin.theta += (self.gaps.h[b] - (of_b - of_a)) / (state.b[b] - state.b[a]);
            state = state.renewed();
        }
        state
    }

    /// The sum of all flights of a regular motion from this state, after an impact at contact `a`, see [`regular::sum`].
    #[cold]
    #[inline(never)]
    pub(super) fn regular_sum(&self, a: usize, time: [f64; 2]) -> Option<RegularSum> {
        if !self.is_level() {
            return None;
        }
        let energy = self.at_gap(a).place(a).energy;
        let (root, [u, v]) = (energy.sqrt(), [self.gaps.u[a], self.gaps.u[1 - a]]);
        let constants = FullConstants::new(&self.body, f64::INFINITY);
        let motion = Full { state: self, constants, a, energy };
        regular::sum(&motion, Vector2::new(u, v) / root, root, time)
    }

    /// The state at the end of a regular motion of this duration (s): both contacts rest, and nothing has acted along the ground.
    pub(crate) fn at_rest_after(&self, duration: f64) -> Self {
        let mut center = self.center;
        center.fly(self.body.gravity, duration);
        let normal = self.body.contacts[0].normal;
        center.r -= normal * normal.dot(&center.r);
        center.v -= normal * normal.dot(&center.v);
        Self::new(self.body, Gaps::default(), center, Spin { theta: 0.0, omega: 0.0 })
    }
}

impl Full<'_> {
    /// The state of this shape and size, the centre of mass above the origin.
    fn state(&self, z: &Vector2<f64>, size: f64) -> Option<FullState> {
        let (a, b, energy) = (self.a, 1 - self.a, size * self.energy);
        let root = energy.sqrt();
        let mut state = *self.state;
        (state.gaps.u[a], state.gaps.u[b]) = (z.x * root, z.y * root);
        state.spin.theta = 0.0;
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON {
            state = state.renewed();
            let place = state.place(a);
            // dω/dθ = ω(c_a − c_b)/(b_a − b_b), d(speed)/dθ = c_aω − b_a dω/dθ, d(height)/dθ = −b_a
            let slope = place.omega * (state.c[a] - state.c[b]) / (state.b[a] - state.b[b]);
            let speeds = place.speed * (state.c[a] * place.omega - state.b[a] * slope);
            let change = speeds + state.body.rho2 * place.omega * slope
                - state.body.contacts[a].gravity * state.b[a];
            let step = (energy - place.energy) / change;
            if !(step.abs() < last) {
                break;
            }
            state.spin.theta += step;
            last = step.abs();
        }
        state = state.renewed();
        let Place { speed, omega, height, .. } = state.place(a);
        let normal = state.body.contacts[a].normal;
        state.center = Center { r: normal * height, v: normal * speed };
        state.spin.omega = omega;
        let turn = Turn::by(state.spin.theta);
        state.gaps.h[a] = 0.0;
        state.gaps.h[b] = state.body.contacts[b].gap(&state.q(), &turn);
        (state.gaps.h[b] > 0.0).then_some(state)
    }
}

impl Regular for Full<'_> {
    const BASES: &'static [Basis] =
        &[Basis { degree: 6, powers: 4 }, Basis { degree: 9, powers: 5 }];
    const SIZES: &'static [f64] = &[1.0, 0.5, 0.1];

    fn cycle(&self, z: &Vector2<f64>, size: f64) -> Option<Cycle> {
        let mut at = self.state(z, size)?;
        let (mut tau, mut taken) = (0.0, 0.0);
        for i in [self.a, 1 - self.a] {
            let (fast, hit) = (FullLoopState::of(&at, Clock::default()), 1 - i);
            let next = match i {
                0 => fast.plain_collision::<0>(&self.constants),
                _ => fast.plain_collision::<1>(&self.constants),
            }?;
            next.after.put(&mut at);
            tau += next.dt;
            // (1 − e²)s²/(2D_ii), with the jump (1 + e)s and 1/D_ii = ρ²/(b² + ρ²)
            let lost = 0.5 * (1.0 - at.body.contacts[hit].restitution) * next.jump;
            taken -= lost * next.before[hit] * at.translational_fraction(hit);
        }
        let energy = size * self.energy;
        let (root, [u, v]) = (energy.sqrt(), [at.gaps.u[self.a], at.gaps.u[1 - self.a]]);
        Some(Cycle::new([u / root, v / root], tau / root, taken / energy))
    }
}
