//! What moves in a run, and its start.

use nalgebra::{DVector, Vector3};

use crate::body::geometry::ContactGeometry;
use crate::body::lines::Feet;
use crate::body::local_model::{LocalModel, LocalState};
use crate::body::posture::Posture;
use crate::body::state::State;
use crate::body::{ContactSpace, Mechanism};
use crate::collisions::full::PairBody;
use crate::collisions::log::{Spin, names};
use crate::error::Error;
use crate::excitation::{Change, MechanismExcitation, NewLoad};
use crate::math::mass_vector::Coordinates;
use crate::math::turn::Turn;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{ContactProblem, ProblemFields};
use crate::motion::moving::Moving;
use crate::sustained::frozen::Frozen;

/// What moves in a run, and its start.
#[expect(
    clippy::large_enum_variant,
    reason = "most runs are of a body, and a box costs an allocation"
)]
#[derive(Debug, Clone)]
pub(crate) enum Subject {
    Body(BodyStart),
    Mechanism(Box<MechanismStart>),
    /// A local model without a body.
    Local(Box<(LocalModel, LocalState)>),
}

/// The start of a run of a body.
#[derive(Debug, Clone)]
pub(crate) struct BodyStart {
    pub(crate) posture: Posture,
    /// The first two contacts.
    pub(crate) pair: PairBody,
    pub(crate) start: State,
}

/// The start of a run of a mechanism.
#[derive(Debug, Clone)]
pub(crate) struct MechanismStart {
    pub(crate) mechanism: Mechanism,
    /// All coordinates and their rates.
    pub(crate) q: Vec<f64>,
    pub(crate) qdot: Vec<f64>,
    /// The hidden motion, see [`ContactSpace`](crate::body::ContactSpace): its pieces, from the start on.
    pub(crate) hidden: Vec<HiddenPiece>,
    pub(crate) excitation: MechanismExcitation,
}

/// A piece of the hidden motion of a mechanism, of constant acceleration.
#[derive(Debug, Clone)]
pub(crate) struct HiddenPiece {
    /// Time since the start, in s.
    pub(crate) elapsed: f64,
    pub(crate) place: DVector<f64>,
    pub(crate) velocity: DVector<f64>,
    pub(crate) acceleration: DVector<f64>,
}

impl HiddenPiece {
    /// The place and the velocity at a time since the start.
    fn at(&self, t: f64) -> [DVector<f64>; 2] {
        let dt = t - self.elapsed;
        let velocity = &self.velocity + &self.acceleration * dt;
        [&self.place + &self.velocity * dt + &self.acceleration * (0.5 * dt * dt), velocity]
    }

    /// The pieces of a run that begins with this one, with these changes.
    pub(crate) fn all(self, space: &ContactSpace, changes: &[Change]) -> Vec<Self> {
        let mut pieces = vec![self];
        for change in changes {
            let Some(last) = pieces.last() else { break };
            let [place, mut velocity] = last.at(change.elapsed);
            let acceleration = match &change.load {
                Some(NewLoad::Load(load)) => space.response(load).1,
                _ => last.acceleration.clone(),
            };
            for (_, impulse) in &change.impulses {
                velocity += space.response(impulse).1;
            }
            pieces.push(Self { elapsed: change.elapsed, place, velocity, acceleration });
        }
        pieces
    }
}

impl MechanismStart {
    /// Place and velocity of the hidden motion.
    pub(crate) fn hidden_at(&self, t: f64) -> [DVector<f64>; 2] {
        let begun = self.hidden.partition_point(|piece| piece.elapsed <= t).max(1);
        self.hidden[begun - 1].at(t)
    }

    /// All coordinates and their rates, in m or rad, `t` seconds after the start.
    pub(crate) fn coordinates(&self, state: &Frozen, t: f64) -> [Vec<f64>; 2] {
        let space = self.mechanism.contact_space();
        let [place, velocity] = self.hidden_at(t);
        [(&state.y, place, &self.q), (&state.v, velocity, &self.qdot)].map(|(y, hidden, start)| {
            let mut all = start.clone();
            for (&k, value) in space.free().iter().zip(space.whole(y, &hidden).iter()) {
                all[k] = value.unsigned_zero();
            }
            all
        })
    }
}

impl BodyStart {
    /// The contact-mode problem of the body in its posture with this acceleration of free fall. `ways`: signs of sliding of its points; `None`:
    /// separate.
    pub(crate) fn problem(
        &self,
        fall: &Coordinates,
        ways: &[Option<i8>],
    ) -> Result<ContactProblem, Error> {
        let (posture, geometry) = (&self.posture, self.posture.geometry());
        let mut fall = fall.iter();
        let arm = |k: &ContactGeometry| k.tangent * k.b + k.normal * k.touching_c();
        ContactProblem::new(ProblemFields {
            mass: posture.fields().mass,
            gyration_radius: posture.fields().gyration_radius,
            arms: geometry.iter().map(|k| arm(k).into()).collect(),
            tangents: geometry.iter().map(|k| k.tangent.into()).collect(),
            friction: geometry.iter().map(|k| k.friction).collect(),
            sliding: posture.per_contact(|k| ways[k]).collect(),
            bias: vec![[0.0; 2]; geometry.len()],
            free_acceleration: std::array::from_fn(|_| fall.next().unwrap_or(0.0)),
            ..ProblemFields::default()
        })
    }
}

impl Subject {
    pub(crate) fn of_body(posture: &Posture, start: &State) -> Self {
        let pair =
            PairBody::new(posture.geometry(), posture.gyration_squared(), posture.fields().gravity);
        Self::Body(BodyStart { posture: posture.clone(), pair, start: *start })
    }

    pub(crate) fn posture(&self) -> Option<&Posture> {
        match self {
            Self::Body(body) => Some(&body.posture),
            _ => None,
        }
    }

    /// The contacts of the body with all its feet.
    pub(crate) fn feet(&self) -> &Feet {
        self.posture().map_or(Feet::ALL, Posture::feet)
    }

    /// "contact 1", "contacts 1 and 2", of contacts counted from 0, with the feet between them.
    pub(crate) fn names(&self, contacts: &[usize]) -> String {
        names(self.feet().numbers(contacts).into_iter())
    }

    pub(crate) fn pair(&self) -> Option<&PairBody> {
        match self {
            Self::Body(body) => Some(&body.pair),
            _ => None,
        }
    }

    pub(crate) fn mechanism(&self) -> Option<&MechanismStart> {
        match self {
            Self::Mechanism(start) => Some(start),
            _ => None,
        }
    }

    pub(crate) fn local(&self) -> Option<&(LocalModel, LocalState)> {
        match self {
            Self::Local(local) => Some(local),
            _ => None,
        }
    }

    /// q and q̇ at the start. Of a model without a body only θ and ω are defined; of a mechanism, nothing.
    pub(crate) fn start(&self) -> State {
        match self {
            Self::Body(body) => body.start,
            Self::Mechanism(_) => State::at_rest([0.0; 3]),
            Self::Local(local) => {
                let LocalState { theta, omega, .. } = local.1;
                State::new([0.0, 0.0, theta], [0.0, 0.0, omega])
            }
        }
    }

    /// q and q̇ of a body. Of a model without a body only θ and ω are defined; of a mechanism, nothing.
    pub(crate) fn state(&self, now: &Frozen) -> State {
        let body = match self {
            Self::Body(body) => body,
            Self::Local(_) => {
                let Spin { theta, omega } = now.spin;
                return State::new([0.0, 0.0, theta], [0.0, 0.0, omega]).unsigned_zero();
            }
            Self::Mechanism(_) => return self.start(),
        };
        let rho = body.posture.gyration_squared().sqrt();
        let value = |of: &Coordinates| {
            let mut of = of.iter();
            Vector3::from_fn(|k, _| of.next().unwrap_or(0.0) / if k == 2 { rho } else { 1.0 })
        };
        State { q: value(&now.y), qdot: value(&now.v) }.unsigned_zero()
    }

    /// q and q̇ in this state.
    pub(crate) fn state_of(&self, now: &Moving) -> State {
        match now {
            Moving::Turning(body) => body.state(),
            Moving::Frozen(rows) => self.state(rows),
        }
    }

    /// Number of contacts.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Body(body) => body.posture.contacts().len(),
            Self::Mechanism(start) => start.mechanism.contacts().len(),
            Self::Local(_) => 2,
        }
    }

    /// The values of all contacts, from those of their points.
    pub(crate) fn per_contact<T>(&self, of: impl Fn(usize) -> T) -> impl Iterator<Item = T> {
        let point = |i: usize| self.posture().map_or(i, |posture| posture.point_of(i));
        (0..self.count()).map(move |i| of(point(i)))
    }

    /// Number of points of the subject among these contacts, and of corners of the ground on sides, which come last.
    pub(crate) fn distinct(&self, closed: &[bool]) -> usize {
        let (own, sides) = closed.split_at(self.count());
        let count = |of: &[bool]| of.iter().filter(|closed| **closed).count();
        count(sides)
            + match self.posture() {
                Some(posture) => posture.distinct().filter(|&i| own[i]).count(),
                None => count(own),
            }
    }

    /// Number of coordinates; a model without a body has none.
    pub(crate) fn dof(&self) -> Option<usize> {
        match self {
            Self::Body(_) => Some(3),
            Self::Mechanism(start) => Some(start.mechanism.dof()),
            Self::Local(_) => None,
        }
    }

    /// ρ²/(b_i² + ρ²) at rotation `theta`, of contact i of two; 1 without a body.
    pub(crate) fn translational_fraction(&self, i: usize, theta: f64) -> f64 {
        self.pair().map_or(1.0, |pair| {
            let (b, _) = pair.contacts[i].turned(&Turn::by(theta));
            pair.rho2 / (b * b + pair.rho2)
        })
    }
}
