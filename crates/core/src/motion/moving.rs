//! The state of a motion: of a body that turns, or of contacts with constant rows.

use nalgebra::Vector3;

use crate::body::contact::ContactLetters;
use crate::body::terrain::Place;
use crate::impact::friction::{Material, Matrix};
use crate::math::mass_vector::{Coordinates, MassVector};
use crate::modes::Mode;
use crate::sustained::frozen::Frozen;
use crate::sustained::{BodyState, Rounding};
use crate::zeno::Gaps;

/// Impacts between two corrections of rounding errors: of b and c of a body from θ, and of dependent gaps and rates from independent ones.
pub(super) const REFRESH: usize = 32;

/// The state of a motion. Changes of velocity and of place are (x, y, θ) of a body that turns, and vectors of the contact space for constant
/// rows.
#[derive(Debug, Clone)]
pub(crate) enum Moving {
    Turning(Box<BodyState>),
    Frozen(Box<Frozen>),
}

fn of(v: &Vector3<f64>) -> Coordinates {
    Coordinates::of_three([v.x, v.y, v.z])
}

fn vector(v: &Coordinates) -> Vector3<f64> {
    Vector3::of(3, v.iter())
}

impl Moving {
    pub(crate) fn turning(&self) -> Option<&BodyState> {
        match self {
            Self::Turning(body) => Some(body),
            Self::Frozen(_) => None,
        }
    }

    pub(crate) fn frozen(&self) -> Option<&Frozen> {
        match self {
            Self::Turning(_) => None,
            Self::Frozen(rows) => Some(rows),
        }
    }

    /// Moves a body that turns to this state.
    pub(crate) fn set_body(&mut self, state: BodyState) {
        match self {
            Self::Turning(body) => **body = state,
            Self::Frozen(_) => *self = Self::Turning(Box::new(state)),
        }
    }

    /// Moves constant rows to this state.
    pub(crate) fn set_rows(&mut self, state: Frozen) {
        match self {
            Self::Frozen(rows) => **rows = state,
            Self::Turning(_) => *self = Self::Frozen(Box::new(state)),
        }
    }

    /// Number of points: one per contact, and a second one while it is in a vertex.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Turning(body) => body.points.len(),
            Self::Frozen(rows) => rows.points.len(),
        }
    }

    /// Gap (m) and rate (m/s) of a point.
    pub(crate) fn point(&self, i: usize) -> (f64, f64) {
        match self {
            Self::Turning(body) => (body.points[i].h, body.points[i].u),
            Self::Frozen(rows) => (rows.points[i].h, rows.points[i].u),
        }
    }

    /// Gaps and rates of all points.
    pub(crate) fn points(&self) -> impl Iterator<Item = (f64, f64)> + Clone + '_ {
        (0..self.count()).map(|i| self.point(i))
    }

    pub(crate) fn set_point(&mut self, i: usize, (h, u): (f64, f64)) {
        match self {
            Self::Turning(body) => (body.points[i].h, body.points[i].u) = (h, u),
            Self::Frozen(rows) => (rows.points[i].h, rows.points[i].u) = (h, u),
        }
    }

    pub(crate) fn rounding(&mut self, i: usize) -> &mut Rounding {
        match self {
            Self::Turning(body) => &mut body.points[i].rounding,
            Self::Frozen(rows) => &mut rows.points[i].rounding,
        }
    }

    /// The contact that a point belongs to.
    pub(crate) fn contact(&self, i: usize) -> usize {
        match self {
            Self::Turning(body) => body.points[i].place.contact,
            Self::Frozen(rows) => rows.rows.contacts[i],
        }
    }

    pub(crate) fn place(&self, i: usize) -> Place {
        match self {
            Self::Turning(body) => body.points[i].place,
            Self::Frozen(_) => Place::anywhere(self.contact(i)),
        }
    }

    pub(crate) fn friction(&self, i: usize) -> f64 {
        match self {
            Self::Turning(body) => body.points[i].friction,
            Self::Frozen(rows) => rows.rows.friction[i],
        }
    }

    /// Sliding speed of a contact, in m/s.
    pub(crate) fn slip(&self, i: usize) -> f64 {
        match self {
            Self::Turning(body) => body.slip(i),
            Self::Frozen(rows) => rows.slip(i),
        }
    }

    /// Effective gravity into the ground of a contact, in m/s².
    pub(crate) fn pull(&self, i: usize) -> f64 {
        match self {
            Self::Turning(body) => body.known_pull(i),
            Self::Frozen(rows) => rows.space().gravity(i),
        }
    }

    /// Size of the acceleration without contacts, in m/s².
    pub(crate) fn gravity(&self) -> f64 {
        match self {
            Self::Turning(body) => body.gravity,
            Self::Frozen(rows) => rows.space().largest_pull(),
        }
    }

    /// Gaps of two contacts at most.
    pub(crate) fn gaps(&self) -> Gaps {
        match self {
            Self::Turning(body) => body.gaps(),
            Self::Frozen(rows) => rows.gaps(),
        }
    }

    /// The state after a flight of `dt`.
    pub(crate) fn flown(&self, dt: f64) -> Self {
        match self {
            Self::Turning(body) => Self::Turning(Box::new(body.flown(dt))),
            Self::Frozen(rows) => Self::Frozen(Box::new(rows.flown(dt))),
        }
    }

    /// √(2T), per unit mass of a body, in m/s, in the frame of the ground under these points; ∞ if their grounds do not move alike.
    pub(crate) fn total_speed(&self, points: &[usize]) -> f64 {
        match self {
            Self::Turning(body) => body.total_speed(points),
            Self::Frozen(rows) => rows.v.norm(),
        }
    }
}

/// Velocities and their changes.
impl Moving {
    pub(crate) fn displacement(&self) -> Coordinates {
        match self {
            Self::Turning(body) => {
                Coordinates::of_three([body.center.r.x, body.center.r.y, body.spin.theta])
            }
            Self::Frozen(rows) => rows.y.clone(),
        }
    }

    pub(crate) fn velocity(&self) -> Coordinates {
        match self {
            Self::Turning(body) => {
                Coordinates::of_three([body.center.v.x, body.center.v.y, body.spin.omega])
            }
            Self::Frozen(rows) => rows.v.clone(),
        }
    }

    /// The same place with this velocity; gap rates are not changed.
    pub(crate) fn moving(&self, velocity: &Coordinates) -> Self {
        let mut moving = self.clone();
        match &mut moving {
            Self::Turning(body) => {
                let v = vector(velocity);
                (body.center.v, body.spin.omega) = (v.xy(), v.z);
            }
            Self::Frozen(rows) => rows.v = velocity.clone(),
        }
        moving
    }

    /// Size of a change of velocity, in m/s.
    pub(crate) fn size(&self, change: &Coordinates) -> f64 {
        match self {
            Self::Turning(body) => {
                let v = vector(change);
                Vector3::new(v.x, v.y, body.rho2.sqrt() * v.z).norm()
            }
            Self::Frozen(rows) => rows.space().reach() * change.norm(),
        }
    }

    /// Bound of the speeds of the contacts at this velocity, in m/s; `size`: of the body, in m.
    pub(crate) fn speed_of(&self, velocity: &Coordinates, size: f64) -> f64 {
        match self {
            Self::Turning(_) => {
                let v = vector(velocity);
                v.x.abs().max(v.y.abs()).max(size * v.z.abs())
            }
            Self::Frozen(rows) => rows.space().reach() * velocity.norm(),
        }
    }

    /// Change of the gap rate of a contact with this change of velocity, in m/s.
    pub(crate) fn rate_of(&self, i: usize, change: &Coordinates) -> f64 {
        match self {
            Self::Turning(body) => {
                let (p, v) = (&body.points[i], vector(change));
                p.normal.dot(&v.xy()) + p.b * v.z
            }
            Self::Frozen(rows) => rows.space().normal_row(i).dot(change),
        }
    }

    /// Adds a change of velocity; gap rates are not changed.
    pub(crate) fn add(&mut self, change: &Coordinates, factor: f64) {
        match self {
            Self::Turning(body) => {
                let v = vector(change);
                body.center.v += v.xy() * factor;
                body.spin.omega += v.z * factor;
            }
            Self::Frozen(rows) => rows.v.add_scaled(change, factor),
        }
    }

    /// The component along the ground of a velocity or a displacement that keeps all contacts on the ground. Over constant rows the other
    /// component is rounding error.
    pub(crate) fn along(&self, change: Coordinates) -> Coordinates {
        let Self::Frozen(rows) = self else { return change };
        let mut moved = Frozen { v: change, ..Frozen::clone(rows) };
        moved.project(&ContactLetters::from_elem(Mode::Right, rows.points.len()));
        moved.v
    }

    /// How much cycles change within the time `t`: a relative change. `before`: the velocity one cycle before; `longer`: by how much the last
    /// cycle was longer than the ratio of cycles makes it, relative. Geometry that turns changes them, too.
    pub(crate) fn turned(&self, before: &Coordinates, t: f64, longer: f64) -> f64 {
        self.turning().map_or(longer, |body| {
            let angle = body.spin.omega.abs().max(vector(before).z.abs()) * t;
            (angle * angle).max(longer)
        })
    }
}

/// Impacts.
impl Moving {
    /// Impact matrix of a contact, per unit mass of a body.
    pub(crate) fn impact_matrix(&self, i: usize) -> Matrix {
        match self {
            Self::Turning(body) => body.impact_matrix(i),
            Self::Frozen(rows) => rows.impact_matrix(i),
        }
    }

    /// Row of the sliding speed (`tangential`) or of the gap rate of a contact, in the metric of the mass.
    pub(crate) fn row(&self, i: usize, tangential: bool) -> Coordinates {
        match self {
            Self::Turning(body) => body.row(i, tangential),
            Self::Frozen(rows) if tangential => rows.space().tangent(i).clone(),
            Self::Frozen(rows) => rows.space().normal_row(i).clone(),
        }
    }

    /// Applies an impulse (tangential, normal), per unit mass of a body; returns the change of velocity.
    pub(crate) fn push(&mut self, i: usize, impulse: [f64; 2]) -> Coordinates {
        match self {
            Self::Turning(body) => of(&body.apply_impulse(i, impulse)),
            Self::Frozen(rows) => rows.push(i, impulse),
        }
    }

    /// Stops these contacts by impulses along their normals; returns the change of velocity.
    pub(crate) fn arrest(&mut self, stopped: &[bool]) -> Coordinates {
        match self {
            Self::Turning(body) => of(&body.arrest(stopped)),
            Self::Frozen(rows) => rows.arrest(stopped),
        }
    }

    /// Makes gap rates and small gaps consistent with one motion. `place`: size of the displacements, in m.
    pub(crate) fn reconcile(&mut self, place: f64) {
        match self {
            Self::Turning(body) => body.reconcile(place),
            Self::Frozen(rows) => rows.reconcile(place),
        }
    }

    /// Sets all speeds to zero where they are rounding errors.
    pub(crate) fn stand(&mut self) {
        match self {
            Self::Turning(body) => body.stand(),
            Self::Frozen(rows) => {
                rows.v.clear();
                rows.points.iter_mut().for_each(|p| p.u = 0.0);
            }
        }
    }

    /// Impulses (tangential, normal) in the friction cones of these contacts that stop all motion; `None` if there are none.
    pub(crate) fn stopped_by(&self, closed: &[usize]) -> Option<Vec<(usize, [f64; 2])>> {
        match self {
            Self::Turning(body) => body.stopped_by(closed),
            Self::Frozen(rows) => rows.stopped_by(closed),
        }
    }

    pub(crate) fn material(&self, i: usize) -> Material {
        match self {
            Self::Turning(body) => body.points[i].material(),
            Self::Frozen(rows) => rows.rows.material[i],
        }
    }
}
