//! Motion with rows of contacts that do not change, of mechanisms, of local models and of bodies in the local model: all accelerations in one contact mode are constant.
//!
//! ```text
//! ÿ = pull + Σ_j (T_jᵀ f_t,j + N_jᵀ f_n,j),    ḧ_i = N_i ÿ,  v̇_t,i = T_i ÿ
//! ```
//!
//! in the coordinates y of the contact space, in which the kinetic energy is ½|ẏ|². Gaps are parabolas and sliding speeds are linear in time.
//! Gaps and gap rates are stored beside y and ẏ, so that a small gap keeps its digits beside a large displacement.

use std::sync::Arc;

use smallvec::SmallVec;

use crate::body::contact::{Contact, ContactLetters, ContactValues, PerContact};
use crate::body::geometry::ContactGeometry;
use crate::body::local_model::{LocalModel, LocalModelFields};
use crate::body::posture::Posture;
use crate::body::{ContactRows, ContactSpace, Mechanism};
use crate::collisions::log::Spin;
use crate::flight::parabola_touchdown;
use crate::impact::friction::{Material, Matrix};
use crate::math::mass_vector::{Coordinates, MassVector, independent, with_products};
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::{Mode, onward};
use crate::sustained::Rounding;
use crate::sustained::rows::{Between, Known, consistent};
use crate::tolerance::{
    CORRECTED_VELOCITY, DEPENDENT_ROW, LANDS_TOGETHER, LANDS_TOGETHER_SPEED, ON_A_LINE,
    PARALLEL_GAP_ROWS, RESTING_COORDINATE, STILL, STOPPED_ROW, UNEVEN_GAP,
};
use crate::zeno::{FrozenModel, Gaps, Impulses};

/// Most corrections of a velocity.
const AGREES: usize = 8;

/// The gap of a contact and its rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GapState {
    pub(crate) h: f64,
    pub(crate) u: f64,
    pub(crate) rounding: Rounding,
}

/// The points of contact: their rows and materials.
#[derive(Debug)]
pub(crate) struct Rows {
    pub(crate) space: Arc<ContactSpace>,
    /// The contacts: of several at one point of a body, the first.
    pub(crate) contacts: Vec<usize>,
    pub(crate) material: Vec<Material>,
    pub(crate) friction: Vec<f64>,
    /// The gaps at y = 0, in m: h_i = N_i y + offset_i.
    offset: Vec<f64>,
    /// The model of the gaps of one or two contacts whose normal rows are independent; `None` if several contacts are at one point.
    pub(crate) gaps: Option<FrozenModel>,
    /// Contacts whose gaps are weighted means of two others.
    between: ContactValues<Option<Between>>,
}

impl Rows {
    pub(crate) fn of_mechanism(mechanism: &Mechanism) -> Self {
        let material = |(i, contact): (usize, &ContactRows)| Material {
            friction: contact.friction,
            restitution: mechanism.restitution(i),
            tangential_restitution: contact.tangential_restitution,
        };
        let all = mechanism.contacts().iter().enumerate().map(material);
        let (material, count) = (all.collect(), mechanism.contacts().len());
        Self::new(mechanism.shared_space(), (0..count).collect(), material, vec![0.0; count])
    }

    /// Of a body in its posture.
    pub(crate) fn of_posture(posture: &Posture) -> Self {
        let material = |i: usize| {
            let Contact { tangential_restitution, .. } = posture.contacts()[i];
            let ContactGeometry { friction, restitution, .. } = posture.geometry()[i];
            Material { friction, restitution, tangential_restitution }
        };
        let contacts: Vec<usize> = posture.distinct().collect();
        let (all, offset) =
            contacts.iter().map(|&i| (material(i), posture.geometry()[i].offset)).unzip();
        let is_one_each = contacts.len() == posture.contacts().len();
        let rows = Self::new(posture.contact_space(), contacts, all, offset);
        Self { gaps: rows.gaps.filter(|_| is_one_each), ..rows }
    }

    /// Of a local model without a body, with these gaps at y = 0; `None` if their rows are parallel.
    pub(crate) fn of_local(model: &LocalModel, offset: [f64; 2]) -> Option<Self> {
        let material = model.restitution().map(|restitution| Material {
            friction: 0.0,
            restitution,
            tangential_restitution: 0.0,
        });
        let space = Arc::new(ContactSpace::of_local(model)?);
        let gaps = Some(FrozenModel::new(model));
        let (friction, offset) = (vec![0.0; 2], offset.to_vec());
        let (material, between) = (material.to_vec(), ContactValues::new());
        let contacts = vec![0, 1];
        Some(Self { space, contacts, material, friction, offset, gaps, between })
    }

    /// The same contacts under another load, of all coordinates.
    pub(crate) fn loaded(&self, load: &[f64]) -> Self {
        let (material, offset) = (self.material.clone(), self.offset.clone());
        let rows =
            Self::new(Arc::new(self.space.loaded(load)), self.contacts.clone(), material, offset);
        Self { gaps: rows.gaps.filter(|_| self.gaps.is_some()), ..rows }
    }

    fn new(
        space: Arc<ContactSpace>,
        contacts: Vec<usize>,
        material: Vec<Material>,
        offset: Vec<f64>,
    ) -> Self {
        let friction: Vec<f64> = material.iter().map(|contact| contact.friction).collect();
        let gaps = gap_model(&space, &material);
        let count = if friction.len() > 2 { friction.len() } else { 0 };
        let found: ContactValues<Option<Between>> =
            (0..count).map(|j| between(&space, &offset, j)).collect();
        let lands = |between: &Between| between.outer.iter().all(|&k| found[k].is_none());
        let between = found.iter().map(|one| one.filter(lands)).collect();
        Self { space, contacts, material, friction, offset, gaps, between }
    }

    /// The rows of the gaps of one or two contacts.
    fn of_gaps(&self) -> SmallVec<[GapRow<'_, Coordinates>; 2]> {
        let space = &self.space;
        let row = |(i, &offset): (usize, &f64)| GapRow {
            normal: space.normal_row(i),
            share: 1.0 / space.normal(i, i),
            offset,
        };
        self.offset.iter().enumerate().map(row).collect()
    }

    /// Directions that these modes keep at rest: normal rows of closed contacts, tangential ones of fixed contacts.
    fn held(&self, modes: &[Mode], apart: f64) -> SmallVec<[(usize, Coordinates); 4]> {
        let mut held: SmallVec<[&Coordinates; 8]> = SmallVec::new();
        for (i, mode) in modes.iter().enumerate() {
            if *mode != Mode::Separate {
                held.push(self.space.normal_row(i));
            }
            if *mode == Mode::Fixed && self.friction[i] > 0.0 {
                held.push(self.space.tangent(i));
            }
        }
        independent(&held, apart)
    }

    /// Removes the part of a velocity, an acceleration or a displacement that violates these modes. A coordinate that they keep at rest
    /// becomes exactly zero: a body that slides on two contacts does not turn by rounding errors.
    pub(crate) fn project(&self, modes: &[Mode], apart: f64, change: &mut Coordinates) {
        if modes.iter().all(|mode| *mode == Mode::Separate) {
            return;
        }
        let held = self.held(modes, apart);
        for _ in 0..AGREES {
            let before = change.amax();
            for (_, axis) in &held {
                let part = axis.dot(change);
                change.add_scaled(axis, -part);
            }
            if change.amax() >= CORRECTED_VELOCITY * before {
                break;
            }
        }
        let count = change.len();
        let rests = |k: usize| {
            let mut left = Coordinates::from_iter((0..count).map(|l| f64::from(u8::from(k == l))));
            for (_, axis) in &held {
                let part = axis.dot(&left);
                left.add_scaled(axis, -part);
            }
            left.norm() <= RESTING_COORDINATE * f64::EPSILON
        };
        let value = |(k, value): (usize, f64)| if rests(k) { 0.0 } else { value };
        *change = Coordinates::from_iter(change.iter().enumerate().map(value));
    }

    /// The two outermost contacts between which a contact is.
    pub(crate) fn between(&self, j: usize) -> Option<Between> {
        *self.between.get(j)?
    }
}

/// Contact j is between others if N_j = w N_i + (1 − w) N_k with 0 < w < 1, and its gap at y = 0 is the same mean. On the line through N_j and
/// another row, N_l = N_j + s_l d, those with the least and the largest s are the outermost ones. These land by themselves.
fn between(space: &ContactSpace, offset: &[f64], j: usize) -> Option<Between> {
    let step =
        |k: usize| (space.normal_row(k).plus(space.normal_row(j), -1.0), offset[k] - offset[j]);
    let size = (0..offset.len()).map(|k| space.normal_row(k).norm()).fold(0.0, f64::max);
    let height = offset.iter().fold(0.0_f64, |most, gap| most.max(gap.abs()));
    (0..offset.len()).find_map(|i| {
        let (way, rise) = step(i);
        let length = way.norm();
        if length <= ON_A_LINE * size {
            return None;
        }
        let (mut first, mut last) = ((0.0, j), (0.0, j));
        for k in 0..offset.len() {
            let (row, up) = step(k);
            let s = way.dot(&row) / (length * length);
            let (off, above) = (row.plus(&way, -s).norm(), (up - s * rise).abs());
            if off > ON_A_LINE * size || above > ON_A_LINE * height {
                continue;
            }
            if s < first.0 {
                first = (s, k);
            }
            if s > last.0 {
                last = (s, k);
            }
        }
        let outer = [first.1, last.1];
        (first.0 < 0.0 && last.0 > 0.0)
            .then(|| Between { outer, weight: last.0 / (last.0 - first.0) })
    })
}

/// The model of the gaps of one or two contacts whose normal rows are independent: ψ_i = −W_12/W_ii and g_i = −b_i.
fn gap_model(space: &ContactSpace, material: &[Material]) -> Option<FrozenModel> {
    match *material {
        [one] => Some(gaps_of([space.gravity(0), 0.0], [0.0; 2], [one.restitution, 0.0])),
        [one, two] => gap_model_of_two(
            [0, 1].map(|i| space.gravity(i)),
            [space.normal(0, 0), space.normal(1, 1)],
            space.normal(0, 1),
            [one.restitution, two.restitution],
        ),
        _ => None,
    }
}

/// The same of two contacts with these W_ii and this W_12.
pub(crate) fn gap_model_of_two(
    gravity: [f64; 2],
    own: [f64; 2],
    cross: f64,
    restitution: [f64; 2],
) -> Option<FrozenModel> {
    let psi = own.map(|own| -cross / own);
    (1.0 - psi[0] * psi[1] > PARALLEL_GAP_ROWS).then(|| gaps_of(gravity, psi, restitution))
}

fn gaps_of(gravity: [f64; 2], psi: [f64; 2], restitution: [f64; 2]) -> FrozenModel {
    let [gravity, psi] = [gravity, psi].map(UnsignedZero::unsigned_zero);
    let phi = [0.0; 2];
    FrozenModel::new(&LocalModel::frozen(LocalModelFields { gravity, psi, restitution, phi }))
}

/// The normal row of a contact, 1/W_ii, and the gap at y = 0 in m.
pub(crate) struct GapRow<'a, V> {
    pub(crate) normal: &'a V,
    pub(crate) share: f64,
    pub(crate) offset: f64,
}

/// Changes the place y and the velocity v at the end of a flight of one or two contacts by frictionless impacts during it: `own` are their
/// effects, as own-rate jumps of both contacts, and `gaps` the gaps and rates at the end.
pub(crate) fn hit<V: MassVector>(
    [y, v]: [&mut V; 2],
    rows: &[GapRow<'_, V>],
    model: &FrozenModel,
    own: &Impulses,
    gaps: &Gaps,
) {
    let push = |change: &mut V, own: [f64; 2]| {
        for (row, own) in rows.iter().zip(own) {
            change.add_scaled(row.normal, row.share * own);
        }
    };
    push(v, own.jump);
    push(y, own.path);
    // The impulses and the fall nearly cancel in y and ẏ, and not in the gaps: y and ẏ are moved along the shortest way to agree with them.
    let (mut rates, mut ways) = ([0.0; 2], [0.0; 2]);
    for (i, row) in rows.iter().enumerate() {
        rates[i] = gaps.u[i] - row.normal.dot(v);
        ways[i] = gaps.h[i] - (row.normal.dot(y) + row.offset);
    }
    push(v, model.solve_coupled(rates));
    push(y, model.solve_coupled(ways));
}

/// Whether an acceleration counts as zero, beside the largest one of a contact without contact forces.
fn is_little<V: MassVector>(acceleration: &V, reach: f64, largest_pull: f64) -> bool {
    reach * acceleration.norm() <= STILL * largest_pull
}

/// Whether two contacts without friction, which rest, stay at rest. `None`: they are not both pressed to the ground. If they are, no other mode is
/// consistent.
/// `reach`: the largest speed of a contact per unit of |ẏ|.
pub(crate) fn lie<V: MassVector>(
    rows: &[GapRow<'_, V>],
    model: &FrozenModel,
    pull: &V,
    reach: f64,
    largest_pull: f64,
) -> Option<bool> {
    let own = model.solve_coupled(model.g);
    let pressed = own[..rows.len()].iter().all(|push| *push > 0.0);
    pressed.then(|| {
        let mut a = pull.clone();
        for (row, push) in rows.iter().zip(own) {
            a.add_scaled(row.normal, push * row.share);
        }
        is_little(&a, reach, largest_pull)
    })
}

/// The state at an instant.
#[derive(Debug)]
pub(crate) struct Frozen {
    pub(crate) rows: Arc<Rows>,
    pub(crate) y: Coordinates,
    pub(crate) v: Coordinates,
    pub(crate) points: PerContact<GapState>,
    /// The rotation of a local model without a body.
    pub(crate) spin: Spin,
}

/// What ends a motion in one contact mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ModeEnd {
    /// This contact lands.
    Landing(usize),
    /// The sliding speed of this contact has decreased to zero.
    Stop(usize),
}

/// Written by hand: the derived `clone` copies the points one by one.
impl Clone for Frozen {
    fn clone(&self) -> Self {
        let points = PerContact::from_slice(&self.points);
        let (rows, y, v) = (Arc::clone(&self.rows), self.y.clone(), self.v.clone());
        Self { rows, y, v, points, spin: self.spin }
    }
}

impl Frozen {
    /// Two gaps with these rates, with y = 0.
    pub(crate) fn of_gaps(rows: Rows, h: [f64; 2], u: [f64; 2], spin: Spin) -> Self {
        let normals = [rows.space.normal_row(0), rows.space.normal_row(1)];
        let v = with_products(&normals, &u).unwrap_or_else(|| Coordinates::zeros(2));
        let point = |(h, u): (f64, f64)| GapState { h, u, rounding: Rounding::new(h, u.abs()) };
        let points = h.into_iter().zip(u).map(point).collect();
        Self { rows: Arc::new(rows), y: Coordinates::zeros(2), v, points, spin }
    }

    pub(crate) fn space(&self) -> &ContactSpace {
        &self.rows.space
    }

    /// Sliding speed of a contact, in m/s.
    pub(crate) fn slip(&self, i: usize) -> f64 {
        self.space().tangent(i).dot(&self.v)
    }

    /// Bound of the speeds of the contacts that this velocity (m/s in the metric of the mass) causes.
    pub(crate) fn speed(&self) -> f64 {
        self.space().reach() * self.v.norm()
    }

    /// Impact matrix of a contact.
    pub(crate) fn impact_matrix(&self, i: usize) -> Matrix {
        let (t, n, w) = (2 * i, 2 * i + 1, self.space().w());
        Matrix { nn: w[(n, n)], nt: w[(t, n)], tt: w[(t, t)] }
    }

    /// Applies an impulse (tangential, normal) at a contact, in N s, or in m/s where the mass is one; returns the change of velocity.
    pub(crate) fn push(&mut self, i: usize, [p_t, p_n]: [f64; 2]) -> Coordinates {
        let space = self.space();
        let change = space.normal_row(i).scaled(p_n).plus(space.tangent(i), p_t);
        self.change(&change);
        change
    }

    /// Changes the velocity, and the gap rates with it.
    pub(crate) fn change(&mut self, change: &Coordinates) {
        let Self { rows, v, points, .. } = self;
        v.add_scaled(change, 1.0);
        for (i, p) in points.iter_mut().enumerate() {
            let row = rows.space.normal_row(i);
            let terms: f64 = row.iter().zip(change.iter()).map(|(a, b)| (a * b).abs()).sum();
            p.u += row.dot(change);
            p.rounding.rate += f64::EPSILON * terms;
        }
    }

    /// The state after `dt` in these modes, with this acceleration.
    pub(crate) fn after(&self, modes: &[Mode], acceleration: &Coordinates, dt: f64) -> Self {
        let mut after = self.clone();
        let mut way = self.v.scaled(dt).plus(acceleration, 0.5 * dt * dt);
        after.v.add_scaled(acceleration, dt);
        self.rows.project(modes, DEPENDENT_ROW, &mut way);
        self.rows.project(modes, DEPENDENT_ROW, &mut after.v);
        after.y.add_scaled(&way, 1.0);
        after.spin.theta += self.spin.omega * dt;
        if let Some(model) = &self.rows.gaps
            && model.phi != [0.0; 2]
        {
            let [one, two] = model.hold([0, 1].map(|i| modes[i] != Mode::Separate));
            let pull = -(model.phi[0] * one + model.phi[1] * two);
            after.spin.theta += 0.5 * pull * dt * dt;
            after.spin.omega += pull * dt;
        }
        for (i, p) in after.points.iter_mut().enumerate() {
            if modes[i] != Mode::Separate {
                (p.h, p.u) = (0.0, 0.0);
                continue;
            }
            let (was, a) = (self.points[i], self.space().normal_row(i).dot(acceleration));
            let [way, gain] = [was.u * dt, a * dt];
            p.rounding = was.rounding.after(
                dt,
                was.h,
                was.h + way.abs() + 0.5 * (gain * dt).abs(),
                was.u.abs() + gain.abs(),
            );
            p.h = (was.h + dt * (was.u + 0.5 * gain)).max(0.0);
            p.u = was.u + gain;
        }
        after
    }

    /// The state after a flight of `dt`.
    pub(crate) fn flown(&self, dt: f64) -> Self {
        let modes = ContactLetters::from_elem(Mode::Separate, self.points.len());
        self.after(&modes, self.space().pull(), dt)
    }

    /// The state after a flight of `dt` of two contacts with frictionless impacts: `own` are their effects since this state, as own-rate jumps
    /// of both contacts, and `gaps` the gaps and rates at the end.
    pub(crate) fn hit(&self, dt: f64, own: &Impulses, gaps: &Gaps) -> Self {
        let mut after = self.flown(dt);
        let Some(model) = &self.rows.gaps else { return after };
        after.spin.theta -= model.phi[0] * own.path[0] + model.phi[1] * own.path[1];
        after.spin.omega -= model.phi[0] * own.jump[0] + model.phi[1] * own.jump[1];
        hit([&mut after.y, &mut after.v], &self.rows.of_gaps(), model, own, gaps);
        for (i, p) in after.points.iter_mut().enumerate() {
            (p.h, p.u) = (gaps.h[i], gaps.u[i]);
        }
        after
    }

    /// The word in which all contacts, which are closed, stay at rest: all speeds are rounding errors (`still`, in m/s), and nothing is
    /// accelerated. `None`: more has to be known.
    pub(crate) fn stands(&self, still: f64) -> Option<ContactLetters<Mode>> {
        if !(self.speed() <= still) {
            return None;
        }
        let (rows, space) = (&self.rows, self.space());
        let count = rows.friction.len();
        let (pull, reach, largest) = (space.pull(), space.reach(), space.largest_pull());
        if let Some(model) = &rows.gaps
            && rows.friction.iter().all(|mu| *mu == 0.0)
            && let Some(rests) = lie(&rows.of_gaps(), model, pull, reach, largest)
        {
            return rests.then(|| ContactLetters::from_elem(Mode::Fixed, count));
        }
        let ways = ContactLetters::from_elem(Some(0), count);
        let mut found = onward(space, &rows.friction, &ways).ok()?;
        let one = found.pop().filter(|one| found.is_empty() && !one.undetermined)?;
        is_little(&one.acceleration, reach, largest).then_some(one.word)
    }

    /// The longest way of a contact along its ground or its normal, in m.
    pub(crate) fn reach_of_contacts(&self) -> f64 {
        let (space, y) = (self.space(), &self.y);
        let way = |i: usize| space.tangent(i).dot(y).abs().max(space.normal_row(i).dot(y).abs());
        (0..space.count()).map(way).fold(0.0, f64::max)
    }

    /// Gaps of two contacts at most.
    pub(crate) fn gaps(&self) -> Gaps {
        let mut gaps = Gaps { h: [f64::INFINITY; 2], u: [0.0; 2] };
        for (i, p) in self.points.iter().take(2).enumerate() {
            (gaps.h[i], gaps.u[i]) = (p.h, p.u);
        }
        gaps
    }

    /// The times of the next touchdowns in flight; ∞ where there is none. A contact between two others lands with them.
    pub(crate) fn touchdowns(&self) -> ContactValues<f64> {
        let time = |(i, p): (usize, &GapState)| match self.rows.between(i) {
            None => parabola_touchdown(p.h, p.u, self.space().gravity(i)),
            Some(_) => f64::INFINITY,
        };
        self.points.iter().enumerate().map(time).collect()
    }

    /// Sets the gaps and rates of contacts between others to the weighted means.
    pub(crate) fn follow_outer(&mut self) {
        for j in 0..self.rows.between.len() {
            let Some(between) = self.rows.between(j) else { continue };
            let of = between.outer.map(|k| {
                let GapState { h, u, rounding } = self.points[k];
                (h, u, rounding)
            });
            let (h, u, rounding) = between.mean(of);
            self.points[j] = GapState { h, u, rounding };
        }
    }

    /// Closes the contacts that land together with these, within their rounding errors, and those between two others that are closed.
    pub(crate) fn land_with(&mut self, coming: &[usize]) {
        for j in 0..self.points.len() {
            let together = coming.iter().any(|&i| self.lands_with(j, &self.points[i]));
            if together && self.points[j].h > 0.0 && self.rows.between(j).is_none() {
                self.points[j].h = 0.0;
            }
        }
        for j in 0..self.rows.between.len() {
            let closed = |between: Between| between.outer.iter().all(|&k| self.points[k].h == 0.0);
            if self.rows.between(j).is_some_and(closed) {
                self.points[j].h = 0.0;
            }
        }
    }

    /// The first event in these modes with this acceleration, and its time in s; `None`: they never end.
    pub(crate) fn first_event(
        &self,
        modes: &[Mode],
        acceleration: &Coordinates,
    ) -> Option<(f64, ModeEnd)> {
        let (space, friction) = (self.space(), &self.rows.friction);
        let mut first: Option<(f64, ModeEnd)> = None;
        for (i, p) in self.points.iter().enumerate() {
            let (t, end) = match modes[i] {
                Mode::Separate if self.rows.between(i).is_some() => continue,
                Mode::Separate => {
                    let a = space.normal_row(i).dot(acceleration);
                    (parabola_touchdown(p.h, p.u, -a), ModeEnd::Landing(i))
                }
                Mode::Fixed => continue,
                mode => {
                    let way = mode.direction();
                    let (speed, a) = (way * self.slip(i), way * space.tangent(i).dot(acceleration));
                    // A speed against the direction of the slide is rounding error: the contact starts from rest.
                    if friction[i] == 0.0 || speed <= 0.0 || a >= 0.0 {
                        continue;
                    }
                    (-speed / a, ModeEnd::Stop(i))
                }
            };
            if t < first.map_or(f64::INFINITY, |(first, _)| first) {
                first = Some((t, end));
            }
        }
        first
    }

    /// Returns true if a gap lands together with that of `first`: it is closing, and below its rounding error plus the distance by which it
    /// closes within the uncertainty of the instant at which `first` lands.
    fn lands_with(&self, i: usize, first: &GapState) -> bool {
        let p = &self.points[i];
        let doubt = first.rounding.gap * (p.u / first.u).abs().min(LANDS_TOGETHER_SPEED);
        p.u < 0.0 && p.h <= LANDS_TOGETHER * (p.rounding.gap + doubt)
    }

    /// Returns true if these modes leave no motion.
    pub(crate) fn is_fixed(&self, modes: &[Mode]) -> bool {
        self.rows.held(modes, DEPENDENT_ROW).len() == self.v.len()
    }

    /// Returns true if the closed contacts leave the mechanism one motion: they slide all together or not at all.
    pub(crate) fn leaves_one_motion(&self, closed: &[bool]) -> bool {
        let rows: SmallVec<[&Coordinates; 8]> =
            (0..closed.len()).filter(|&i| closed[i]).map(|i| self.space().normal_row(i)).collect();
        rows.len() > 1 && independent(&rows, DEPENDENT_ROW).len() + 1 == self.v.len()
    }

    /// Returns true if the gap of contact `i` follows from those of these others.
    pub(crate) fn depends(&self, i: usize, others: &[bool]) -> bool {
        let mut rows: SmallVec<[&Coordinates; 8]> = (0..others.len())
            .filter(|&j| others[j] && j != i)
            .map(|j| self.space().normal_row(j))
            .collect();
        let rank = independent(&rows, DEPENDENT_ROW).len();
        rows.push(self.space().normal_row(i));
        rank > 0 && independent(&rows, DEPENDENT_ROW).len() == rank
    }

    /// Removes the part of the velocity that violates these modes, as a plastic impact would: no energy is added.
    pub(crate) fn project(&mut self, modes: &[Mode]) {
        self.rows.project(modes, STOPPED_ROW, &mut self.v);
    }

    /// Corrects the velocity where contacts begin to be held in these modes. The rates of closed contacts are rounding error. A sliding speed
    /// that counts as zero is removed where contacts are fixed, and the rates of contacts in the air change with it.
    pub(crate) fn hold(&mut self, modes: &[Mode]) {
        let sliding = |mode: &Mode| if *mode == Mode::Separate { *mode } else { Mode::Right };
        self.project(&modes.iter().map(sliding).collect::<ContactLetters<_>>());
        let before = self.v.clone();
        self.project(modes);
        let change = self.v.plus(&before, -1.0);
        let Self { rows, points, .. } = self;
        for (i, p) in points.iter_mut().enumerate() {
            if modes[i] == Mode::Separate {
                p.u += rows.space.normal_row(i).dot(&change);
                if p.h == 0.0 {
                    p.u = p.u.max(0.0); // it separates: removing a slow sliding must not close it
                }
            } else {
                (p.h, p.u) = (0.0, 0.0);
            }
        }
    }

    /// Stops these contacts by impulses along their normals; the rates of the others change. Returns the change of velocity.
    pub(crate) fn arrest(&mut self, stopped: &[bool]) -> Coordinates {
        let all = Arc::clone(&self.rows);
        let numbers: ContactValues<usize> = (0..stopped.len()).filter(|&i| stopped[i]).collect();
        let rows: SmallVec<[&Coordinates; 8]> =
            numbers.iter().map(|&i| all.space.normal_row(i)).collect();
        let mut change = Coordinates::zeros(self.v.len());
        for (k, axis) in independent(&rows, STOPPED_ROW) {
            let rate = self.points[numbers[k]].u + rows[k].dot(&change);
            change.add_scaled(&axis, -rate / rows[k].dot(&axis));
        }
        self.change(&change);
        for i in numbers {
            self.points[i] = GapState { h: 0.0, u: 0.0, rounding: Rounding::default() };
        }
        change
    }

    /// Makes gap rates and small gaps consistent with one motion; see [`consistent`]. `place`: size of the displacements, in m.
    pub(crate) fn reconcile(&mut self, place: f64) {
        if self.points.len() < 3 {
            return;
        }
        let rows: ContactValues<Option<&Coordinates>> =
            (0..self.points.len()).map(|i| Some(self.space().normal_row(i))).collect();
        let rows: Vec<Option<Coordinates>> = rows.into_iter().map(|row| row.cloned()).collect();
        let mut rates: ContactValues<Known> =
            self.points.iter().map(|p| (p.u, p.rounding.rate)).collect();
        consistent(&rows, &mut rates);
        let mut gaps: ContactValues<Known> =
            self.points.iter().map(|p| (p.h, p.rounding.gap)).collect();
        consistent(&rows, &mut gaps);
        for (p, ((h, gap), (u, rate))) in self.points.iter_mut().zip(gaps.into_iter().zip(rates)) {
            if (h - p.h).abs() <= UNEVEN_GAP * f64::EPSILON * place {
                (p.h, p.rounding.gap) = (h.max(0.0), gap);
            }
            (p.u, p.rounding.rate) = (u, rate);
        }
    }
}
