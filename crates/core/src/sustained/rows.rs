//! Rows of the contact Jacobian that stay zero while contacts are held, and the velocities that keep them zero.

use nalgebra::{Vector2, Vector3};
use smallvec::SmallVec;

use crate::body::contact::{ContactLetters, ContactValues};
use crate::math::mass_vector::MassVector;
use crate::modes::Mode;
use crate::sustained::{BodyState, ContactState, Rounding};
use crate::tolerance::{
    CORRECTED_VELOCITY, DEPENDENT_ROW, IMPLIED_ROW, NEARLY_EQUAL_ROWS, PARALLEL_GROUND,
    STOPPED_ROW, UNEVEN_GAP, USELESS_BOUND,
};

/// Most corrections of a velocity or position: loads are up to 1e100 times what moves, each correction gains sixteen digits.
pub(super) const AGREES: usize = 8;

/// A force, and the row that it keeps at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unknown {
    pub(super) contact: usize,
    pub(super) tangential: bool,
}

/// A row that stays zero, per unit mass, in coordinates (x, y, ρθ).
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) unknown: Unknown,
    pub(super) whole: Vector3<f64>,
    /// Unit vector along the part of this row that is orthogonal to the rows before it.
    pub(super) direction: Vector3<f64>,
}

/// A value of a row, and a bound of its rounding error.
pub(super) type Known = (f64, f64);

/// Makes the values of rows consistent with one velocity or displacement. The most accurate values of independent rows stay; the others
/// follow from them, with their rounding errors. Rows that are `None` are left out. A row that nearly equals a row that stays (two contacts
/// one above the other) keeps its value too: the difference of the two values is of second order in the rotation, and is more accurate as
/// stored than as computed from other rows.
pub(super) fn consistent<V: MassVector>(rows: &[Option<V>], values: &mut [Known]) {
    let mut order: ContactValues<usize> = (0..rows.len()).filter(|&i| rows[i].is_some()).collect();
    order.sort_by(|&i, &j| {
        let [(one, known), (other, less)] = [values[i], values[j]];
        known.total_cmp(&less).then(one.abs().total_cmp(&other.abs()))
    });
    let Some(dimension) = rows.iter().flatten().next().map(V::len) else { return };
    // Orthonormal directions, and bounds of the rounding errors along each.
    let mut basis: SmallVec<[(V, f64); 3]> = SmallVec::new();
    let left_over = |row: &V, basis: &[(V, f64)]| {
        let mut left = row.clone();
        for _ in 0..2 {
            for (direction, _) in basis {
                let part = direction.dot(&left);
                left.add_scaled(direction, -part);
            }
        }
        left
    };
    let bound = |row: &V, basis: &[(V, f64)]| -> f64 {
        basis.iter().map(|(d, bound)| d.dot(row).abs() * bound).sum()
    };
    let mut stay: SmallVec<[(usize, &V); 3]> = SmallVec::new();
    let mut follow: ContactValues<(usize, &V)> = ContactValues::new();
    for i in order {
        let Some(row) = &rows[i] else { continue };
        let left = left_over(row, &basis);
        let length = left.norm();
        if basis.len() < dimension && length > NEARLY_EQUAL_ROWS * row.norm() {
            let rounding = (values[i].1 + bound(row, &basis)) / length;
            basis.push((left.divided(length), rounding));
            stay.push((i, row));
        } else {
            follow.push((i, row));
        }
    }
    let mut x = V::zeros(dimension); // row · x is the value of each row that stays
    for ((i, row), (direction, _)) in stay.iter().zip(&basis) {
        let missing = (values[*i].0 - row.dot(&x)) / row.dot(direction);
        x.add_scaled(direction, missing);
    }
    for (i, row) in follow {
        let alike = |(_, other): &(usize, &V)| {
            row.plus(other, -1.0).norm() <= NEARLY_EQUAL_ROWS * row.norm()
        };
        let depends = left_over(row, &basis).norm() <= IMPLIED_ROW * row.norm();
        if depends && !stay.iter().any(alike) {
            let (value, (old, rounding)) = (row.dot(&x), values[i]);
            let computed = bound(row, &basis) + f64::EPSILON * value.abs();
            // Where rows nearly depend on each other this bound is large, and grows from event to event. The stored value has a bound, too.
            let useless = computed > USELESS_BOUND * row.norm() * x.norm();
            let error =
                if useless { computed.min(rounding + (value - old).abs()) } else { computed };
            values[i] = (value, error);
        }
    }
}

/// A contact between two others: its gap is a weighted mean of theirs, h = w h_i + (1 − w) h_k with 0 < w < 1, so that it touches the ground
/// only where both do. Computed by itself, its gap could reach zero before, by its rounding error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Between {
    /// i and k, the outermost ones.
    pub(crate) outer: [usize; 2],
    /// w, of the first.
    pub(crate) weight: f64,
}

impl Between {
    /// The gap, its rate and their rounding errors, from those of the outer two.
    pub(crate) fn mean(&self, of: [(f64, f64, Rounding); 2]) -> (f64, f64, Rounding) {
        let [one, other] = of;
        let mean = |a: f64, b: f64| self.weight * a + (1.0 - self.weight) * b;
        let rounding =
            Rounding { gap: mean(one.2.gap, other.2.gap), rate: mean(one.2.rate, other.2.rate) };
        (mean(one.0, other.0), mean(one.1, other.1), rounding)
    }
}

/// Independent ones of these rows, the longest first, each with the part that is orthogonal to those before it; `apart`: the least length
/// of this part.
#[inline(always)]
fn independent(apart: f64, mut rows: SmallVec<[Row; 4]>) -> SmallVec<[Row; 3]> {
    let rows = &mut rows[..];
    let mut chosen: SmallVec<[Row; 3]> = SmallVec::new();
    while chosen.len() < 3 {
        // The last of the longest. A row that is chosen becomes a zero vector.
        let (mut at, mut longest) = (0, 0.0);
        for (k, row) in rows.iter().enumerate() {
            let length = row.direction.norm_squared();
            if length >= longest {
                (at, longest) = (k, length);
            }
        }
        if longest <= apart * apart {
            break;
        }
        let direction = rows[at].direction / longest.sqrt();
        chosen.push(Row { direction, ..rows[at] });
        rows[at].direction = Vector3::zeros();
        for other in &mut *rows {
            other.direction -= direction * direction.dot(&other.direction);
        }
    }
    chosen
}

impl BodyState {
    /// The rows that stay zero: normal ones of closed contacts, tangential ones of fixed contacts.
    #[inline(always)]
    pub(super) fn rows(&self, modes: &[Mode]) -> SmallVec<[Row; 4]> {
        let rho = self.rho2.sqrt();
        let mut rows: SmallVec<[Row; 4]> = SmallVec::new();
        for (contact, (p, &mode)) in self.points.iter().zip(modes).enumerate() {
            if mode == Mode::Separate
                || self.partner(contact, modes).is_some_and(|first| first < contact)
            {
                continue;
            }
            let row = |tangential, axis: Vector2<f64>, lever: f64| {
                let whole = Vector3::new(axis.x, axis.y, lever / rho);
                Row { unknown: Unknown { contact, tangential }, whole, direction: whole }
            };
            rows.push(row(false, p.normal, p.b));
            if self.sticks(contact, modes) {
                rows.push(row(true, p.tangent, -p.touching_c()));
            }
        }
        rows
    }

    /// Independent rows that determine the motion, the longest first, each with the part that is orthogonal to those before it.
    pub(super) fn independent(&self, modes: &[Mode]) -> SmallVec<[Row; 3]> {
        independent(DEPENDENT_ROW, self.rows(modes))
    }

    /// The same without one of the rows.
    pub(super) fn independent_but(&self, without: Unknown, modes: &[Mode]) -> SmallVec<[Row; 3]> {
        let mut rows = self.rows(modes);
        rows.retain(|row| row.unknown != without);
        independent(DEPENDENT_ROW, rows)
    }

    /// The two contacts of independent rows farthest apart on (nearly) parallel ground. The body does not move off this ground, and
    /// turns only as it moves along it: (b_i − b_j) ω = −(n_i − n_j)·v, so little that only the difference of the rows gives it
    /// accurately.
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

    /// Whether the ground of two such contacts is exactly parallel: the body does not turn.
    pub(super) fn is_level(&self, [i, j]: [usize; 2]) -> bool {
        self.points[i].normal == self.points[j].normal
    }

    /// −(n_i − n_j)·x/(b_i − b_j): the rotation for a displacement x, or the spin for a velocity x.
    pub(super) fn turned_by(&self, [i, j]: [usize; 2], x: Vector2<f64>) -> f64 {
        let (one, two) = (&self.points[i], &self.points[j]);
        0.0 - (one.normal - two.normal).dot(&x) / (one.b - two.b)
    }

    /// Returns true if the gap of contact `i` follows from the gaps of these others: their normal rows span its own.
    pub(crate) fn depends(&self, i: usize, others: &[bool]) -> bool {
        // A sliding contact has only its normal row.
        let closed = |on: bool| if on { Mode::Right } else { Mode::Separate };
        let mut modes: ContactLetters<Mode> = others.iter().map(|&on| closed(on)).collect();
        let rank = self.independent(&modes).len();
        modes[i] = Mode::Right;
        rank > 0 && self.independent(&modes).len() == rank
    }

    /// Returns true if these contacts, closed, leave the body one degree of freedom.
    pub(crate) fn leaves_one_motion(&self, closed: &[bool]) -> bool {
        if closed.iter().filter(|&&closed| closed).count() < 2 {
            return false;
        }
        let mode = |closed: &bool| if *closed { Mode::Right } else { Mode::Separate };
        self.independent(&closed.iter().map(mode).collect::<ContactLetters<_>>()).len() == 2
    }

    /// Returns true if more than one contact is closed: the rows of one contact are independent of each other and leave the body a motion.
    pub(super) fn has_rows_of_two(&self, modes: &[Mode]) -> bool {
        modes.iter().filter(|&&mode| mode != Mode::Separate).count() > 1
    }

    /// Returns true if the rows that stay zero leave no motion at all.
    pub(crate) fn is_fixed(&self, modes: &[Mode]) -> bool {
        self.has_rows_of_two(modes) && self.independent(modes).len() == 3
    }

    /// Removes the part of the velocity that violates the rows, as a plastic impact on them would. The projection is orthogonal
    /// in the metric of the mass, so that it cannot add energy. Returns independent ones of the rows.
    pub(super) fn project(&mut self, modes: &[Mode]) -> SmallVec<[Row; 3]> {
        self.project_on(modes, DEPENDENT_ROW)
    }

    /// The same on rows with at least this part orthogonal to the others.
    #[inline(always)]
    fn project_on(&mut self, modes: &[Mode], apart: f64) -> SmallVec<[Row; 3]> {
        let rho = self.rho2.sqrt();
        let v = self.center.v;
        let mut velocity = Vector3::new(v.x, v.y, rho * self.spin.omega);
        // A contact on both pieces of a vertex has no velocity. In a narrow vertex their normal rows determine that badly.
        let closed = |i: usize| modes[i] != Mode::Separate;
        let in_vertex = |i: usize| closed(i) && self.twin(i).is_some_and(closed);
        let held = |i: usize| if in_vertex(i) { Mode::Fixed } else { modes[i] };
        let held: ContactLetters<_> = (0..modes.len()).map(held).collect();
        let rows = independent(apart, self.rows(&held));
        let carried = self.carried(&rows);
        velocity -= carried;
        for _ in 0..AGREES {
            let before = velocity.amax();
            for row in &rows {
                velocity -= row.direction * row.direction.dot(&velocity);
            }
            // The part removed has a rounding error too, which matters if it is nearly the whole velocity.
            if velocity.amax() >= CORRECTED_VELOCITY * before {
                break;
            }
        }
        velocity += carried;
        (self.center.v, self.spin.omega) = (velocity.xy(), velocity.z / rho);
        if let Some(pair) = self.parallel(&rows) {
            self.spin.omega = self.turned_by(pair, self.center.v);
        }
        rows
    }

    /// The smallest velocity with which fixed contacts move as their ground does, in coordinates with the metric of the identity; zero unless
    /// a surface moves.
    fn carried(&self, rows: &[Row]) -> Vector3<f64> {
        let mut velocity = Vector3::zeros();
        if self.points.iter().all(|p| p.surface_speed == 0.0) {
            return velocity;
        }
        for row in rows {
            let Unknown { contact, tangential } = row.unknown;
            let speed = if tangential { self.points[contact].surface_speed } else { 0.0 };
            let off = row.whole.dot(&velocity) - speed;
            velocity -= row.direction * (off / row.whole.dot(&row.direction));
        }
        velocity
    }

    /// The velocity of the ground under those of these points that have friction, in m/s, zero if there are none; `None` if their grounds do not
    /// move alike.
    pub(crate) fn velocity_of_ground(
        &self,
        mut under: impl FnMut(&ContactState, usize) -> bool,
    ) -> Option<Vector2<f64>> {
        let mut found = None;
        for (i, p) in self.points.iter().enumerate() {
            let v = p.tangent * p.surface_speed;
            if under(p, i) && p.friction > 0.0 && *found.get_or_insert(v) != v {
                return None;
            }
        }
        Some(found.unwrap_or_default())
    }

    /// Whether the ground of a contact that is fixed in these modes moves.
    pub(crate) fn rides(&self, modes: &[Mode]) -> bool {
        let held =
            |(p, mode): (&ContactState, &Mode)| *mode == Mode::Fixed && p.surface_speed != 0.0;
        self.points.iter().zip(modes).any(held)
    }

    /// The body, at rest on its ground, moves with it and does not turn. The gaps of other contacts change with its velocity alone. Returns
    /// whether it rides on for ever: no contact lands, and no piece of the ground has an end.
    pub(crate) fn ride(&mut self, modes: &[Mode]) -> bool {
        self.spin.omega = 0.0;
        let (v, closed) = (self.center.v, |mode: Mode| mode != Mode::Separate);
        let moves = |(p, mode): &(&ContactState, &Mode)| p.surface_speed != 0.0 && closed(**mode);
        let level = self.points.iter().zip(modes).find(moves).map(|(p, _)| p.normal);
        for (p, mode) in self.points.iter_mut().zip(modes) {
            let keeps = closed(*mode) || level == Some(p.normal);
            p.u = if keeps { 0.0 } else { p.normal.dot(&v) };
        }
        let stays = |p: &ContactState| p.u >= 0.0 && p.place.sides == [f64::INFINITY; 2];
        self.points.iter().all(stays)
    }

    /// Velocity of the centre of mass over the ground that the body touches, in m/s; its own if it touches grounds that do not move alike.
    pub(crate) fn velocity_over_ground(&self) -> Vector2<f64> {
        self.center.v - self.velocity_of_ground(|p, _| p.h == 0.0).unwrap_or_default()
    }

    /// Corrects the velocity of a body with these contacts closed: its rates along their normals are rounding error.
    pub(crate) fn close(&mut self, closed: &[bool]) {
        let mode = |closed: &bool| if *closed { Mode::Right } else { Mode::Separate };
        self.project_on(&closed.iter().map(mode).collect::<ContactLetters<_>>(), STOPPED_ROW);
    }

    /// Stops these contacts: one plastic impact brings their gap rates to zero by impulses along their normals. The rates of
    /// all other contacts change with the velocity of the body. Without this change, the rates of three contacts on one
    /// straight floor would contradict each other, as if the floor moved, and the body would never come to rest. Returns the
    /// change of (v, ω).
    pub(crate) fn arrest(&mut self, stopped: &[bool]) -> Vector3<f64> {
        let rho = self.rho2.sqrt();
        let mode = |stops: &bool| if *stops { Mode::Right } else { Mode::Separate };
        let modes: ContactLetters<Mode> = stopped.iter().map(mode).collect();
        // Each direction is orthogonal to the rows before it.
        let mut change = Vector3::<f64>::zeros();
        for row in &independent(STOPPED_ROW, self.rows(&modes)) {
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

    /// Sets the velocity of a body over the ground that it touches to zero, where it is rounding error.
    pub(crate) fn stand(&mut self) {
        self.center.v = self.velocity_of_ground(|p, _| p.h == 0.0).unwrap_or_default();
        self.spin.omega = 0.0;
        for p in &mut self.points {
            (p.u, p.rounding.rate) = (0.0, 0.0);
        }
    }

    /// Makes the gap rates consistent with one rigid velocity, and gaps with one rigid displacement if they differ by the rounding
    /// error of a position only. `size`: of the body, in m. Each gap is stored separately, so that a small one keeps its digits
    /// beside a large one. Where rows are dependent (three contacts on one straight floor, any four), rounding errors of a larger
    /// motion would contradict the small motion that follows, as if the floor moved or were uneven, and the body would rattle for
    /// ever. The most accurate independent values stay, and the others follow from them.
    pub(crate) fn reconcile(&mut self, size: f64) {
        if self.points.len() < 3 {
            return;
        }
        let rho = self.rho2.sqrt();
        let row = |p: &ContactState| {
            let row = Vector3::new(p.normal.x, p.normal.y, p.b / rho);
            (p.h < f64::INFINITY).then_some(row)
        };
        let rows: ContactValues<Option<Vector3<f64>>> = self.points.iter().map(row).collect();
        let mut rates: ContactValues<Known> =
            self.points.iter().map(|p| (p.u, p.rounding.rate)).collect();
        consistent(&rows, &mut rates);
        let mut gaps: ContactValues<Known> =
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

    /// Stops the slide of a point that leaves its piece at an end, if it slides away from this end, so slowly that it counts as zero (`limit`,
    /// in m/s). On the other piece it would lift the point off and bring it back here, for ever.
    pub(crate) fn stop_before_end(&mut self, i: usize, side: usize, limit: f64) {
        let inward = if side == 0 { self.slip(i) } else { -self.slip(i) };
        let p = &self.points[i];
        // A moving surface carries the point on.
        if p.surface_speed != 0.0
            || !(inward > 0.0 && inward <= limit && p.friction > 0.0 && p.radius == 0.0)
        {
            return;
        }
        let (v, omega) = (self.center.v, self.spin.omega);
        let mode = |j: usize| match &self.points[j] {
            _ if j == i => Mode::Fixed,
            p if p.h == 0.0 && p.u == 0.0 => Mode::Right,
            _ => Mode::Separate,
        };
        self.project(&(0..self.points.len()).map(mode).collect::<ContactLetters<_>>());
        let (change, turn) = (self.center.v - v, self.spin.omega - omega);
        for p in self.points.iter_mut().filter(|p| p.h > 0.0) {
            p.u += p.normal.dot(&change) + p.b * turn;
        }
    }

    /// Corrects the velocity of a body whose contacts begin to be held in these modes. Its rates along the normals of closed
    /// contacts are rounding error, which the separately stored rates of the others do not have. A sliding speed that counts as
    /// zero is removed where contacts are fixed, and the rates of contacts in the air change with it.
    pub(crate) fn hold(&mut self, modes: &[Mode]) {
        let (r, theta) = (self.center.r, self.spin.theta);
        for i in 0..self.points.len() {
            let turns = self.side_contact(i).is_some();
            let p = &mut self.points[i];
            let along = p.tangent.dot(&r) + p.b;
            let rolled = if p.radius > 0.0 { along + p.radius * theta } else { along };
            p.held = Some(match p.corner {
                Some(_) => [p.radius * (p.bearing() + theta), p.radius],
                None if turns => [p.b, p.c],
                None => [rolled, p.normal.dot(&r) + p.c],
            });
        }
        let sliding = |mode: &Mode| if *mode == Mode::Separate { *mode } else { Mode::Right };
        let rows =
            self.project_on(&modes.iter().map(sliding).collect::<ContactLetters<_>>(), STOPPED_ROW);
        // On exactly parallel ground of two contacts the body does not turn, and keeps its height over all ground of this direction. A rate
        // left over from the bounces would end an endless slide without friction after 1e29 s.
        if let Some(pair) = self.parallel(&rows).filter(|&pair| self.is_level(pair)) {
            let normal = self.points[pair[0]].normal;
            for (p, mode) in self.points.iter_mut().zip(modes) {
                if *mode == Mode::Separate && p.h > 0.0 && p.normal == normal {
                    (p.u, p.rounding.rate) = (0.0, 0.0);
                }
            }
        }
        let sticks = |(p, mode): (&ContactState, &Mode)| {
            if *mode == Mode::Fixed && p.friction == 0.0 { Mode::Right } else { *mode }
        };
        let sticking: ContactLetters<Mode> = self.points.iter().zip(modes).map(sticks).collect();
        if !sticking.contains(&Mode::Fixed) {
            return;
        }
        let (v, omega) = (self.center.v, self.spin.omega);
        self.project_on(&sticking, STOPPED_ROW);
        let (change, turn) = (self.center.v - v, self.spin.omega - omega);
        for (p, mode) in self.points.iter_mut().zip(modes) {
            if *mode == Mode::Separate {
                p.u += p.normal.dot(&change) + p.b * turn;
                if p.h == 0.0 {
                    p.u = p.u.max(0.0); // it separates: removing a slow sliding must not close it
                }
            }
        }
    }
}
