//! The start of a run: gaps and rates of the contacts, and the driver of the event loop.

use std::sync::Arc;

use nalgebra::Vector2;

use crate::body::contact::PerContact;
use crate::body::geometry::ContactGeometry;
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::collisions::log::{Center, Spin};
use crate::error::{Error, in_range};
use crate::math::mass_vector::Coordinates;
use crate::math::turn::Turn;
use crate::motion::Driver;
use crate::motion::subject::Subject;
use crate::options::{Model, Options};
use crate::outcome::ContactSet;
use crate::simulate::limits::{clatters, returns, touch};
use crate::sustained::frozen::{Frozen, GapState, Rows};
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::PHASE_LOST;

/// Largest angular velocity ω, in rad/s, and largest product of ω and the size of the body, in m/s. The forces on dependent contacts
/// contain ω⁴, which must not overflow.
const FASTEST_SPIN: f64 = 1e70;

/// Returns true if the body, on straight ground, never turns, so that the local model is exact. The body is upright and does not spin. Normal forces do not turn
/// it, because all arms have b_i = 0. Friction does not turn it, because there is none, or it has no arm, or the body falls straight down on
/// level ground and no contact slides.
pub(super) fn never_turns(posture: &Posture, start: &State) -> bool {
    let every = |holds: &dyn Fn(&ContactGeometry, f64) -> bool| {
        let mut all = posture.geometry().iter().zip(posture.contacts());
        all.all(|(k, contact)| holds(k, contact.friction))
    };
    start.q.z == 0.0
        && start.qdot.z == 0.0
        && every(&|k, _| k.b == 0.0)
        && (every(&|k, friction| friction == 0.0 || k.touching_c() == 0.0)
            || start.qdot.x == 0.0 && every(&|k, _| k.normal.x == 0.0))
}

/// Gaps and rates at the start, in one of the models.
pub(crate) struct Start {
    pub(super) model: Model,
    pub(super) heights: PerContact<f64>,
    rates: PerContact<f64>,
    warnings: Vec<String>,
}

impl Start {
    pub(crate) fn new(posture: &Posture, state: &State, model: Model) -> Result<Self, Error> {
        let local = model == Model::Local;
        let known = local || state.q.z.abs() <= PHASE_LOST;
        in_range(
            "q.theta",
            state.q.z,
            known,
            "in [-1e12, 1e12] rad unless model = \"local\": beyond, at most four digits of a rotation are left",
        )?;
        let v = state.qdot;
        in_range(
            "qdot.theta",
            v.z,
            v.z.abs().max(posture.size() * v.z.abs()) <= FASTEST_SPIN,
            "at most 1e70 rad/s in size, and 1e70 m/s times the size of the body",
        )?;
        let speed = v.x.abs() + v.y.abs() + posture.size() * v.z.abs();
        returns("speed of qdot", speed, posture.fields().gravity)?;
        let turn = Turn::by(if local { 0.0 } else { state.q.z });
        let (mut heights, rates): (PerContact<f64>, PerContact<f64>) = (0..posture
            .geometry()
            .len())
            .map(|i| {
                let under = posture.under_moving(i, state);
                let k = &under.geometry;
                let (mut gap, mut rate) = if local {
                    (k.local_gap(&state.q), k.local_rate(&state.qdot))
                } else {
                    (k.gap(&state.q, &turn), k.gap_rate(&state.qdot, &turn))
                };
                // Within the rounding error of the state, the contact touches and neither leaves nor lands.
                let [place, speed] = k.roundings(&state.q, &state.qdot, (!local).then_some(&turn));
                if gap.abs() <= place && rate.abs() <= speed {
                    (gap, rate) = (0.0, 0.0);
                }
                if local {
                    return (gap, rate);
                }
                let gap = if under.exists { gap } else { f64::INFINITY };
                (posture.signed_gap(i, &state.q, gap), rate)
            })
            .unzip();
        let known = (0..posture.geometry().len()).map(|i| posture.touch(i)).fold(0.0, f64::max);
        let warnings = touch(&mut heights, known)?;
        if heights.len() > 1 {
            let gravity = posture.geometry().iter().map(|k| k.gravity);
            let starts = heights.iter().zip(&rates).zip(gravity);
            clatters(starts.map(|((h, u), g)| (*h, *u, g)))?;
        }
        Ok(Self { model, heights, rates, warnings })
    }

    /// The contacts that touch the ground.
    pub(crate) fn touching(&self) -> ContactSet {
        ContactSet::of_gaps(&self.heights)
    }

    /// The driver of the motion: in the local model with constant rows.
    pub(super) fn driver<'c>(
        self,
        posture: &Posture,
        state: &State,
        options: &Options,
        cancel: &'c dyn Fn() -> bool,
    ) -> Driver<'c> {
        if self.model == Model::Local {
            return self.frozen_driver(posture, state, options, cancel);
        }
        let Self { heights, rates, warnings, .. } = self;
        let subject = Subject::of_body(posture, state);
        let start = Self::body_state(posture, state, &heights, &rates);
        Driver::of_body(posture, start, subject, options, warnings, cancel)
    }

    /// The state of the body, with these gaps (m) and rates (m/s) of its contacts.
    pub(super) fn body_state(
        posture: &Posture,
        state: &State,
        heights: &[f64],
        rates: &[f64],
    ) -> BodyState {
        let turn = Turn::by(state.q.z);
        let points = posture.distinct().map(|i| {
            let under = posture.under_moving(i, state);
            let ContactGeometry { tangent, normal, .. } = under.geometry;
            let (b, c) = under.geometry.turned(&turn);
            let contact = posture.contacts()[i];
            let restitution = [under.geometry.restitution, contact.tangential_restitution];
            let (mut place, h, u) = (under.place, heights[i], rates[i]);
            if (h, u) == (0.0, 0.0) {
                let [known, _] = under.geometry.roundings(&state.q, &state.qdot, Some(&turn));
                let known = known + f64::EPSILON * posture.contacts()[i].point[0].abs();
                place.sides = place.sides.map(|side| if side <= known { 0.0 } else { side });
            }
            let (place_terms, spin) = (b.abs() + c.abs() + posture.size(), b * state.qdot.z);
            let rounding = Rounding::new(
                state.q.xy().norm() + place_terms,
                state.qdot.xy().norm() + spin.abs(),
            );
            ContactState {
                normal,
                tangent,
                friction: under.geometry.friction,
                surface_speed: under.geometry.surface_speed,
                restitution,
                b,
                c,
                radius: under.geometry.radius,
                corner: under.geometry.corner.map(|corner| corner - posture.center()),
                held: None,
                place,
                h,
                depth: 0.0,
                u,
                rounding,
            }
        });
        let mut start = BodyState {
            points: points.collect(),
            sides: Vec::new(),
            center: Center { r: state.q.xy(), v: state.qdot.xy() },
            spin: Spin { theta: state.q.z, omega: state.qdot.z },
            rho2: posture.gyration_squared(),
            fall: Vector2::new(0.0, -posture.fields().gravity),
            gravity: posture.fields().gravity,
            fall_rate: Vector2::zeros(),
        };
        for i in 0..start.points.len() {
            if start.points[i].h > 0.0 {
                start.put_between_lines(i, posture);
            }
        }
        start
    }

    fn frozen_driver<'c>(
        self,
        posture: &Posture,
        state: &State,
        options: &Options,
        cancel: &'c dyn Fn() -> bool,
    ) -> Driver<'c> {
        let Self { heights, rates, warnings, .. } = self;
        let (v, rho) = (state.qdot, posture.gyration_squared().sqrt());
        let (far, fast) = (state.q.xy().norm() + posture.size(), v.xy().norm());
        let point = |i: usize| {
            let (k, h, u) = (&posture.geometry()[i], heights[i], rates[i]);
            let rounding = Rounding::new(far + k.b.abs() + k.c.abs(), fast + (k.b * v.z).abs());
            GapState { h, u, rounding }
        };
        let points = posture.distinct().map(point).collect();
        let y = Coordinates::from_iter([state.q.x, state.q.y, rho * state.q.z]);
        let v = Coordinates::from_iter([v.x, v.y, rho * v.z]);
        let (rows, spin) = (Arc::new(Rows::of_posture(posture)), Spin::default());
        let frozen = Frozen { rows, y, v, points, spin };
        let subject = Subject::of_body(posture, state);
        Driver::of_rows(frozen, posture.size(), subject, options, warnings, cancel)
    }
}
