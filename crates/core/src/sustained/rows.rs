//! Rows of the contact Jacobian that stay zero while contacts are held, and the velocities that keep them zero.

use nalgebra::{Vector2, Vector3};
use smallvec::SmallVec;

use crate::body::contact::PerContact;
use crate::modes::Mode;
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::{
    CORRECTED_VELOCITY, DEPENDENT_ROW, IMPLIED_ROW, NEARLY_EQUAL_ROWS, PARALLEL_GROUND, UNEVEN_GAP,
};

/// Corrections of a velocity or of a place, at most: loads are up to 1e100 times what moves, and each gains sixteen digits.
pub(super) const AGREES: usize = 8;

/// A force, and the row that it makes vanish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unknown {
    pub(super) contact: usize,
    pub(super) tangential: bool,
}

/// A row that vanishes, per unit mass, in coordinates (x, y, ρθ).
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) unknown: Unknown,
    pub(super) whole: Vector3<f64>,
    /// Unit vector along what the rows before it leave over.
    pub(super) direction: Vector3<f64>,
}

/// A value of a row, and a bound of its rounding.
type Known = (f64, f64);

/// Makes the values of rows those of one velocity, or of one displacement. The best known ones whose rows are independent stay as
/// they are, and the others follow from them, with their roundings. Rows that are `None` are left out, and so
/// are those that are nearly the same as one that stays (two contacts one above the other): the difference of their values is of
/// second order in the rotation, and known better than the values.
fn consistent(rows: &[Option<Vector3<f64>>], values: &mut [Known]) {
    let mut order: PerContact<usize> = (0..rows.len()).filter(|&i| rows[i].is_some()).collect();
    order.sort_by(|&i, &j| {
        let [(one, known), (other, less)] = [values[i], values[j]];
        known.total_cmp(&less).then(one.abs().total_cmp(&other.abs()))
    });
    // Orthonormal directions, and bounds of what roundings add along each.
    let mut basis: SmallVec<[(Vector3<f64>, f64); 3]> = SmallVec::new();
    let left_over = |row: &Vector3<f64>, basis: &[(Vector3<f64>, f64)]| {
        let mut left = *row;
        for _ in 0..2 {
            for (direction, _) in basis {
                left -= direction * direction.dot(&left);
            }
        }
        left
    };
    let bound = |row: &Vector3<f64>, basis: &[(Vector3<f64>, f64)]| -> f64 {
        basis.iter().map(|(d, bound)| d.dot(row).abs() * bound).sum()
    };
    let mut stay: SmallVec<[(usize, Vector3<f64>); 3]> = SmallVec::new();
    let mut follow: PerContact<(usize, Vector3<f64>)> = PerContact::new();
    for i in order {
        let Some(row) = rows[i] else { continue };
        let left = left_over(&row, &basis);
        let length = left.norm();
        if basis.len() < 3 && length > NEARLY_EQUAL_ROWS * row.norm() {
            let rounding = (values[i].1 + bound(&row, &basis)) / length;
            basis.push((left / length, rounding));
            stay.push((i, row));
        } else {
            follow.push((i, row));
        }
    }
    let mut x = Vector3::zeros(); // row · x is the value of each row that stays
    for ((i, row), (direction, _)) in stay.iter().zip(&basis) {
        x += direction * ((values[*i].0 - row.dot(&x)) / row.dot(direction));
    }
    for (i, row) in follow {
        let alike = |(_, other): &(usize, Vector3<f64>)| {
            (row - other).norm() <= NEARLY_EQUAL_ROWS * row.norm()
        };
        let depends = left_over(&row, &basis).norm() <= IMPLIED_ROW * row.norm();
        if depends && !stay.iter().any(alike) {
            let value = row.dot(&x);
            values[i] = (value, bound(&row, &basis) + f64::EPSILON * value.abs());
        }
    }
}

impl BodyState {
    /// The rows that vanish: normal ones of closed contacts, tangential ones of fixed ones.
    pub(super) fn rows(&self, modes: &[Mode]) -> SmallVec<[Row; 4]> {
        let rho = self.rho2.sqrt();
        let mut rows: SmallVec<[Row; 4]> = SmallVec::new();
        for (contact, (p, &mode)) in self.points.iter().zip(modes).enumerate() {
            let mut push = |tangential, axis: Vector2<f64>, lever: f64| {
                let whole = Vector3::new(axis.x, axis.y, lever / rho);
                let unknown = Unknown { contact, tangential };
                rows.push(Row { unknown, whole, direction: whole });
            };
            if self.partner(contact, modes).is_some_and(|first| first < contact) {
                continue;
            }
            if mode != Mode::Separate {
                push(false, p.normal, p.b);
            }
            if self.sticks(contact, modes) {
                push(true, p.tangent, -p.c);
            }
        }
        rows
    }

    /// Those of them that determine the motion, the longest first, each by the part that the ones before it leave over.
    pub(super) fn independent(&self, modes: &[Mode]) -> SmallVec<[Row; 3]> {
        self.independent_but(None, modes)
    }

    /// The same without one of them.
    pub(super) fn independent_but(
        &self,
        without: Option<Unknown>,
        modes: &[Mode],
    ) -> SmallVec<[Row; 3]> {
        let mut rows = self.rows(modes);
        rows.retain(|row| Some(row.unknown) != without);
        let mut chosen: SmallVec<[Row; 3]> = SmallVec::new();
        while chosen.len() < 3 {
            // The last of the longest; a row that is chosen leaves a vector of zero.
            let (mut at, mut longest) = (0, 0.0);
            for (k, row) in rows.iter().enumerate() {
                let length = row.direction.norm_squared();
                if length >= longest {
                    (at, longest) = (k, length);
                }
            }
            if longest <= DEPENDENT_ROW * DEPENDENT_ROW {
                break;
            }
            let direction = rows[at].direction / longest.sqrt();
            chosen.push(Row { direction, ..rows[at] });
            rows[at].direction = Vector3::zeros();
            for other in &mut rows {
                other.direction -= direction * direction.dot(&other.direction);
            }
        }
        chosen
    }

    /// Of independent rows those of the two contacts farthest apart on parallel ground, or nearly so. Off it the body does not move,
    /// and turns only as it moves along it, (b_i − b_j) ω = −(n_i − n_j)·v: by so little that anything but this difference is
    /// rounding.
    pub(super) fn parallel(&self, rows: &[Row]) -> Option<[usize; 2]> {
        let (points, rho) = (&self.points, self.rho2.sqrt());
        let normal = |row: &&Row| !row.unknown.tangential;
        let contacts: SmallVec<[usize; 3]> =
            rows.iter().filter(normal).map(|row| row.unknown.contact).collect();
        let mut found = (0.0, None);
        for (k, &i) in contacts.iter().enumerate() {
            for &j in &contacts[..k] {
                let apart = (points[i].b - points[j].b).abs();
                let bent = rho * (points[i].normal - points[j].normal).amax();
                if apart > found.0 && bent <= PARALLEL_GROUND * apart {
                    found = (apart, Some([i.min(j), i.max(j)]));
                }
            }
        }
        found.1
    }

    /// Whether nothing at all turns a body on two such contacts.
    pub(super) fn is_level(&self, [i, j]: [usize; 2]) -> bool {
        self.points[i].normal == self.points[j].normal
    }

    /// −(n_i − n_j)·x/(b_i − b_j): how far it turns as it moves by x, or how fast.
    pub(super) fn turned_by(&self, [i, j]: [usize; 2], x: Vector2<f64>) -> f64 {
        let (one, two) = (&self.points[i], &self.points[j]);
        0.0 - (one.normal - two.normal).dot(&x) / (one.b - two.b)
    }

    /// Whether the gap of contact `i` follows from those of these others: their normal rows span its own.
    pub(crate) fn depends(&self, i: usize, others: &[bool]) -> bool {
        // A sliding contact has its normal row alone.
        let closed = |on: bool| if on { Mode::Right } else { Mode::Separate };
        let mut modes: PerContact<Mode> = others.iter().map(|&on| closed(on)).collect();
        let rank = self.independent(&modes).len();
        modes[i] = Mode::Right;
        rank > 0 && self.independent(&modes).len() == rank
    }

    /// The part of the velocity, (v, ω), that the rates of these contacts are made of. The rest, orthogonal to it in the metric of
    /// the mass, none of them sees, and no force along their normals changes it. All of it, to the last bit, where that is the
    /// smaller part.
    pub(crate) fn seen(&self, contacts: &[bool]) -> [f64; 3] {
        let rho = self.rho2.sqrt();
        let v = Vector3::new(self.center.v.x, self.center.v.y, rho * self.spin.omega);
        let mode = |on: &bool| if *on { Mode::Right } else { Mode::Separate };
        let modes: PerContact<_> = contacts.iter().map(mode).collect();
        let along = |row: &Row| row.direction * row.direction.dot(&v);
        let mut seen: Vector3<f64> = self.independent(&modes).iter().map(along).sum();
        if seen.norm_squared() >= 0.5 * v.norm_squared() {
            seen = v;
        }
        [seen.x, seen.y, seen.z / rho]
    }

    /// Whether these contacts, closed, leave the body a single motion.
    pub(crate) fn leaves_one_motion(&self, closed: &[bool]) -> bool {
        let mode = |closed: &bool| if *closed { Mode::Right } else { Mode::Separate };
        self.independent(&closed.iter().map(mode).collect::<PerContact<_>>()).len() == 2
    }

    /// Whether the rows that vanish leave no motion at all.
    pub(crate) fn is_fixed(&self, modes: &[Mode]) -> bool {
        self.independent(modes).len() == 3
    }

    /// Takes from the velocity what moves the rows that vanish, as a plastic impact on them would: orthogonally in the
    /// metric of the mass, so that it can only lose energy.
    pub(super) fn project(&mut self, modes: &[Mode]) {
        let rho = self.rho2.sqrt();
        let v = self.center.v;
        let mut velocity = Vector3::new(v.x, v.y, rho * self.spin.omega);
        let rows = self.independent(modes);
        for _ in 0..AGREES {
            let before = velocity.amax();
            for row in &rows {
                velocity -= row.direction * row.direction.dot(&velocity);
            }
            // What is taken away has roundings itself, where it is most of all.
            if velocity.amax() >= CORRECTED_VELOCITY * before {
                break;
            }
        }
        (self.center.v, self.spin.omega) = (velocity.xy(), velocity.z / rho);
        if let Some(pair) = self.parallel(&rows) {
            self.spin.omega = self.turned_by(pair, self.center.v);
        }
    }

    /// Back from a geometry that was frozen for a moment: the body moves with what is closed, and the gaps of the others
    /// with the body.
    pub(crate) fn unfreeze(&mut self) {
        let closed =
            |p: &ContactState| if p.h == 0.0 && p.u == 0.0 { Mode::Right } else { Mode::Separate };
        let modes: PerContact<Mode> = self.points.iter().map(closed).collect();
        self.project(&modes);
        let (v, omega) = (self.center.v, self.spin.omega);
        for p in self.points.iter_mut().filter(|p| p.h > 0.0) {
            p.u = p.normal.dot(&v) + p.b * omega;
        }
    }

    /// The velocity of a body with these contacts closed: what it has left along their normals is rounding.
    pub(crate) fn close(&mut self, closed: &[bool]) {
        if self.has_rows() {
            let mode = |closed: &bool| if *closed { Mode::Right } else { Mode::Separate };
            self.project(&closed.iter().map(mode).collect::<PerContact<_>>());
        }
    }

    /// Stops these contacts: one plastic impact brings their gap rates to zero by impulses along their normals. The rates of all
    /// other contacts change with the velocity of the body. Were they left as they are, the rates of three contacts on one
    /// straight floor would contradict each other after it, as if the floor moved: the body would never come to rest.
    /// Returns the change of (v, ω).
    pub(crate) fn arrest(&mut self, stopped: &[bool]) -> Vector3<f64> {
        let rho = self.rho2.sqrt();
        let mode = |stops: &bool| if *stops { Mode::Right } else { Mode::Separate };
        let modes: PerContact<Mode> = stopped.iter().map(mode).collect();
        // Row by row: each direction is orthogonal to the rows before it.
        let mut change = Vector3::<f64>::zeros();
        for row in &self.independent(&modes) {
            let rate = self.points[row.unknown.contact].u + row.whole.dot(&change);
            change -= row.direction * (rate / row.whole.dot(&row.direction));
        }
        let (push, turn) = (change.xy(), change.z / rho);
        self.center.v += push;
        self.spin.omega += turn;
        for (p, stops) in self.points.iter_mut().zip(stopped) {
            let (straight, twist) = (p.normal.dot(&push), p.b * turn);
            p.u += straight + twist;
            p.rounding.rate += f64::EPSILON * (straight.abs() + twist.abs());
            if *stops {
                (p.h, p.u, p.rounding) = (0.0, 0.0, Rounding::default());
            }
        }
        Vector3::new(push.x, push.y, turn)
    }

    /// Takes all of its velocity from a body that has none but roundings.
    pub(crate) fn stand(&mut self) {
        self.center.v.fill(0.0);
        self.spin.omega = 0.0;
        for p in &mut self.points {
            (p.u, p.rounding.rate) = (0.0, 0.0);
        }
    }

    /// Makes the gap rates those of one rigid velocity, and the gaps those of one rigid displacement where they are so within the
    /// rounding of a place, `size` the size of the body in m. Each is kept by itself, so that a small one keeps its digits beside a
    /// large one; where rows depend on each other (three contacts on one straight floor, any four), what roundings of a larger
    /// motion have left would contradict the small motion that comes after it, as if the floor moved or were uneven, and the
    /// body would rattle for ever. The best known that are independent stay, and the others follow from them.
    pub(crate) fn reconcile(&mut self, size: f64) {
        if self.points.len() < 3 {
            return;
        }
        let rho = self.rho2.sqrt();
        let row = |p: &ContactState| {
            let row = Vector3::new(p.normal.x, p.normal.y, p.b / rho);
            (p.h < f64::INFINITY).then_some(row)
        };
        let rows: PerContact<Option<Vector3<f64>>> = self.points.iter().map(row).collect();
        let mut rates: PerContact<Known> =
            self.points.iter().map(|p| (p.u, p.rounding.rate)).collect();
        consistent(&rows, &mut rates);
        let mut gaps: PerContact<Known> =
            self.points.iter().map(|p| (p.h, p.rounding.gap)).collect();
        consistent(&rows, &mut gaps);
        let place = size + self.center.r.norm();
        for (p, ((h, gap), (u, rate))) in self.points.iter_mut().zip(gaps.into_iter().zip(rates)) {
            if (h - p.h).abs() <= UNEVEN_GAP * f64::EPSILON * place {
                (p.h, p.rounding.gap) = (h.max(0.0), gap);
            }
            (p.u, p.rounding.rate) = (u, rate);
        }
    }

    /// The velocity of a body whose contacts begin to be held in these modes. What it has left along the normals of those
    /// that are closed is rounding: the rates of the others, which are kept beside it, know nothing of that. Sliding too
    /// slow to count is taken from a body that holds on, and the rates of the contacts in the air follow.
    pub(crate) fn hold(&mut self, modes: &[Mode]) {
        if !self.has_rows() {
            return;
        }
        for p in &mut self.points {
            let r = self.center.r;
            p.held = Some([p.tangent.dot(&r) + p.b, p.normal.dot(&r) + p.c]);
        }
        let sliding = |mode: &Mode| if *mode == Mode::Separate { *mode } else { Mode::Right };
        self.project(&modes.iter().map(sliding).collect::<PerContact<_>>());
        let sticks = |(p, mode): (&ContactState, &Mode)| {
            if *mode == Mode::Fixed && p.friction == 0.0 { Mode::Right } else { *mode }
        };
        let sticking: PerContact<Mode> = self.points.iter().zip(modes).map(sticks).collect();
        if !sticking.contains(&Mode::Fixed) {
            return;
        }
        let (v, omega) = (self.center.v, self.spin.omega);
        self.project(&sticking);
        let (change, turn) = (self.center.v - v, self.spin.omega - omega);
        for (p, mode) in self.points.iter_mut().zip(modes) {
            if *mode == Mode::Separate {
                p.u += p.normal.dot(&change) + p.b * turn;
                if p.h == 0.0 {
                    p.u = p.u.max(0.0); // it is leaving: sliding that counts as none brings no other contact back
                }
            }
        }
    }
}
