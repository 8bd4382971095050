//! One or two contacts: every word in closed form, without allocation.
//!
//! In the mass metric normal rows have length one, and a sliding contact has N·γ = 1 − σμ N·T. Words of one closed
//! contact take one division or a system of two, words of two closed contacts one of two or three. Two fixed
//! contacts are hyperstatic: their acceleration follows from three of their rows, their forces form a segment.

use nalgebra::Vector3;

use crate::math::mass_vector::MassVector;
use crate::math::unsigned_zero::UnsignedZero;
use crate::modes::answer::{Condition, Forces, Margin, ModeAnswer, is_doubtful, test};
use crate::modes::judge::{judge, leans_on_a_tie};
use crate::modes::problem::ContactProblem;
use crate::modes::rows::Row;
use crate::modes::scaled::Problem;
use crate::modes::squeeze::Squeeze;
use crate::modes::words::{Mode, Word};
use crate::outcome::ContactNumber;
use crate::tolerance::{DEPENDENT_ROW, FIXED_ACCELERATION, TIE};

/// A word of one or two contacts, solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairMode {
    /// Whether every test holds.
    pub consistent: bool,
    /// Whether a test holds or fails by no more than [`TIE`].
    pub near_degenerate: bool,
    letters: [Mode; 2],
    /// Scaled, (tangential, normal).
    forces: [[f64; 2]; 2],
}

/// The words that the state of one or two contacts allows, in no particular order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairModes {
    // SS, six words with one contact closed, FF; a line on which both stay closed has three pieces, and two words pivot.
    modes: [PairMode; 13],
    len: usize,
    /// Whether a word is consistent with a force outside its cone, by a tie.
    leans: bool,
}

impl PairModes {
    fn none() -> Self {
        let (consistent, near_degenerate) = (false, false);
        let (letters, forces) = ([Mode::Separate; 2], [[0.0; 2]; 2]);
        Self {
            modes: [PairMode { consistent, near_degenerate, letters, forces }; 13],
            len: 0,
            leans: false,
        }
    }

    /// The words, solved.
    pub fn iter(&self) -> impl Iterator<Item = &PairMode> {
        self.modes[..self.len].iter()
    }

    /// The consistent ones.
    pub fn consistent(&self) -> impl Iterator<Item = &PairMode> {
        self.iter().filter(|mode| mode.consistent)
    }

    /// Returns true if the consistent words are the same without ties.
    fn is_decided(&self) -> bool {
        let any = |test: fn(&PairMode) -> bool| self.iter().any(test);
        !self.leans && (any(|mode| mode.consistent) || !any(|mode| mode.near_degenerate))
    }

    #[inline(always)]
    fn add(&mut self, solver: &Solver<'_>, letters: [Mode; 2], forces: [[f64; 2]; 2]) {
        let (mut consistent, mut near_degenerate, mut missing) = (true, false, false);
        for i in 0..2 {
            let tangential = || solver.tangential(i, &forces);
            let normal = || solver.normal(i, forces[1 - i]);
            let row = solver.rows[i];
            test(row, letters[i], tangential, normal, forces[i], |condition, value| {
                consistent &= condition.holds(value);
                near_degenerate |= value.abs() <= TIE;
                missing |= value < -FIXED_ACCELERATION && !condition.is_strict();
            });
        }
        self.leans |= consistent && missing;
        self.modes[self.len] = PairMode { consistent, near_degenerate, letters, forces };
        self.len += 1;
    }
}

impl PairMode {
    /// Modes of the two contacts; S for an absent contact.
    #[must_use]
    pub fn letters(&self) -> [Mode; 2] {
        self.letters
    }

    /// q̈, in m/s² and rad/s² (impulse level: the velocity after, in m/s and rad/s).
    #[must_use]
    pub fn acceleration(&self, problem: &ContactProblem) -> [f64; 3] {
        problem.motion(&self.motion_of(problem.rows(), problem.load())).unsigned_zero()
    }

    /// With three closed rows: the point where they vanish. Otherwise Newton's law.
    fn motion_of(&self, rows: &[Row], load: Vector3<f64>) -> Vector3<f64> {
        let apart = self.letters.contains(&Mode::Separate);
        match (rows, self.letters) {
            ([one, two], [Mode::Fixed, _]) if !apart => pivot(one, two),
            ([one, two], [_, Mode::Fixed]) if !apart => pivot(two, one),
            (rows, _) => {
                rows.iter().zip(self.forces).fold(load, |y, (row, force)| row.pushed(&y, force))
            }
        }
    }

    /// (f_t, f_n) at the contact with this index, in N (impulse level: N s); the smallest where they are not unique.
    #[must_use]
    pub fn force(&self, problem: &ContactProblem, index: usize) -> [f64; 2] {
        let scaled = self.family(problem).map_or(self.forces, |family| family.smallest());
        problem.force(index, scaled[index]).unsigned_zero()
    }

    /// The forces of two fixed contacts.
    fn family(&self, problem: &ContactProblem) -> Option<Squeeze> {
        match (problem.rows(), self.letters) {
            ([one, two], [Mode::Fixed, Mode::Fixed]) => {
                let (rows, load) = (problem.rows(), problem.load());
                Some(Squeeze::between([one, two], self.motion_of(rows, load) - load))
            }
            _ => None,
        }
    }

    /// The word and its tests, with the bits of [`ModeAnswer`], without allocation.
    pub(crate) fn judged(&self, problem: &ContactProblem) -> Judged {
        let rows = problem.rows();
        let y = self.motion_of(rows, problem.load());
        let n = rows.len();
        let word = (0..n).fold(Word::separate(n), |word, i| word.with(i, self.letters[i]));
        let mut judged = Judged { word, consistent: true, margins: [Judged::NONE; 4], len: 0 };
        for (i, row) in rows.iter().enumerate() {
            let tangential = || row.tangential(&y);
            let normal = || row.opening(&y);
            let force = self.forces[i];
            test(row, self.letters[i], tangential, normal, force, |condition, value| {
                let contact = ContactNumber::of(i);
                judged.margins[judged.len] = Margin { contact, condition, value };
                judged.len += 1;
            });
        }
        let margins = judged.margins();
        judged.consistent = margins.iter().all(Margin::holds) && !leans_on_a_tie(margins);
        judged
    }

    fn answer(&self, problem: &impl Problem<V = Vector3<f64>>) -> ModeAnswer {
        let n = problem.rows().len();
        let word = (0..n).fold(Word::separate(n), |word, i| word.with(i, self.letters[i]));
        let y = self.motion_of(problem.rows(), *problem.load());
        if self.letters == [Mode::Fixed; 2] {
            return both_fixed(problem, word, &y, [0, 1]);
        }
        judge(problem, word, &y, &self.forces[..n], Forces::Unique)
    }
}

/// A word and its tests, at most two for each of two contacts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judged {
    pub(crate) word: Word,
    pub(crate) consistent: bool,
    margins: [Margin; 4],
    len: usize,
}

impl Judged {
    const NONE: Margin =
        Margin { contact: ContactNumber::of(0), condition: Condition::Opens, value: 0.0 };

    pub(crate) fn margins(&self) -> &[Margin] {
        &self.margins[..self.len]
    }
}

/// The answer for a word in which just these two contacts are closed, both fixed, with the acceleration `y`.
pub(super) fn both_fixed<P: Problem>(
    problem: &P,
    word: Word,
    y: &P::V,
    closed: [usize; 2],
) -> ModeAnswer {
    let rows = problem.rows();
    let family = problem.squeeze(closed, &y.plus(problem.load(), -1.0));
    let spread = |two: [[f64; 2]; 2]| {
        let mut forces = vec![[0.0; 2]; rows.len()];
        (forces[closed[0]], forces[closed[1]]) = (two[0], two[1]);
        forces
    };
    let inside = spread(family.forces(family.inside));
    let mut answer = judge(problem, word, y, &inside, Forces::Family);
    let smallest = spread(family.smallest());
    answer.forces = (0..rows.len()).map(|i| problem.force(i, smallest[i])).collect();
    answer.force_interval = Some([family.low, family.high].map(|f| problem.internal_force(f)));
    answer
}

/// Letters that the sliding of a contact allows besides S.
fn closed_letters(row: &Row) -> &'static [Mode] {
    match row.sliding {
        None => &[],
        Some(0) => &[Mode::Fixed, Mode::Right, Mode::Left],
        Some(1) => &[Mode::Right],
        Some(_) => &[Mode::Left],
    }
}

impl ContactProblem {
    /// The modes of one or two contacts in closed form: the words of [`contact_modes`](crate::modes::contact_modes) without margins and
    /// without allocation.
    ///
    /// `None` for more contacts, where rows of two contacts depend on each other (contacts at one point, or with a
    /// common normal), and where a tie decides which words exist.
    ///
    /// ```
    /// use standfast::modes::ContactProblem;
    /// use standfast::{Lamina, Posture, State};
    ///
    /// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
    /// let problem = ContactProblem::of_posture(&rod, &State::at_rest([0.0; 3]), [0.0; 3])?;
    /// let modes = problem.pair_modes().expect("two contacts at two points");
    /// assert_eq!(modes.consistent().count(), 1);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    #[must_use]
    pub fn pair_modes(&self) -> Option<PairModes> {
        solve(self.rows(), self.load())
    }
}

/// All words of one or two contacts, solved, if they have closed forms.
pub(super) fn answers(problem: &impl Problem<V = Vector3<f64>>) -> Option<Vec<ModeAnswer>> {
    let modes = solve(problem.rows(), *problem.load())?;
    Some(modes.iter().map(|mode| mode.answer(problem)).collect())
}

#[inline(always)]
fn solve(rows: &[Row], load: Vector3<f64>) -> Option<PairModes> {
    let rows = match rows {
        [one] => [one, &Row::ABSENT],
        [one, two] => [one, two],
        _ => return None,
    };
    let mut found = Some(PairModes::none()); // built in place, because moving it costs more than one word
    Solver::new(rows, load).words(found.as_mut()?)?;
    if !found.as_ref()?.is_decided() {
        return None;
    }
    found
}

/// The one consistent word of up to two contacts and its scaled acceleration; `None` if there are several words or none,
/// or no closed form.
pub(crate) fn only_mode(rows: &[Row], load: Vector3<f64>) -> Option<([Mode; 2], Vector3<f64>)> {
    let found = solve(rows, load)?;
    let mut consistent = found.consistent();
    match (consistent.next(), consistent.next()) {
        (Some(mode), None) => Some((mode.letters, mode.motion_of(rows, load))),
        _ => None,
    }
}

/// Rows, load, and the products of all of them: accelerations follow from forces without leaving the contacts.
struct Solver<'a> {
    rows: [&'a Row; 2],
    load: Vector3<f64>,
    /// T_i·w + bias and N_i·w + bias: the accelerations that forces must cancel.
    need: [[f64; 2]; 2],
    /// N_i·T_i, N_i·T_j and T_i·T_i
    mixed: [f64; 2],
    across: [f64; 2],
    own: [f64; 2],
    /// N_1·N_2 and T_1·T_2
    cosine: f64,
    tangents: f64,
}

impl<'a> Solver<'a> {
    #[inline(always)]
    fn new(rows: [&'a Row; 2], load: Vector3<f64>) -> Self {
        let [one, two] = rows;
        let need =
            |row: &Row| [row.tangent.dot(&load) + row.bias[0], row.normal.dot(&load) + row.bias[1]];
        Self {
            rows,
            load,
            need: [need(one), need(two)],
            mixed: [one.normal.dot(&one.tangent), two.normal.dot(&two.tangent)],
            across: [one.normal.dot(&two.tangent), two.normal.dot(&one.tangent)],
            own: [one.tangent.norm_squared(), two.tangent.norm_squared()],
            cosine: one.normal.dot(&two.normal),
            tangents: one.tangent.dot(&two.tangent),
        }
    }

    /// a_n of contact `i`, which has no force, under the force of the other contact.
    #[inline(always)]
    fn normal(&self, i: usize, [f_t, f_n]: [f64; 2]) -> f64 {
        self.need[i][1] + (self.cosine * f_n + self.across[i] * f_t)
    }

    /// a_t of contact `i` under these forces.
    #[inline(always)]
    fn tangential(&self, i: usize, forces: &[[f64; 2]; 2]) -> f64 {
        let ([f_t, f_n], [g_t, g_n]) = (forces[i], forces[1 - i]);
        self.need[i][0]
            + (self.mixed[i] * f_n + self.own[i] * f_t)
            + (self.across[1 - i] * g_n + self.tangents * g_t)
    }

    /// All words; `None` if rows depend on each other or a friction matrix is singular.
    #[inline(always)]
    fn words(&self, found: &mut PairModes) -> Option<()> {
        found.add(self, [Mode::Separate; 2], [[0.0; 2]; 2]);
        self.alone(0, found)?;
        self.alone(1, found)?;
        let [one, two] = self.rows;
        if one.sliding.is_none() || two.sliding.is_none() {
            return Some(());
        }
        let line = one.normal.cross(&two.normal);
        let volume = [one.tangent.dot(&line), -two.tangent.dot(&line)]; // N_i·(T_i × N_j), of either sign
        if line.norm_squared() <= DEPENDENT_ROW * DEPENDENT_ROW
            || volume[0].abs() <= DEPENDENT_ROW
            || volume[1].abs() <= DEPENDENT_ROW
        {
            return None;
        }
        let still = |row: &Row| row.sliding == Some(0) && row.bias == [0.0; 2];
        if still(one) && still(two) {
            // No contact pivots; both slide along one motion, forwards or backwards.
            self.both_fixed(found);
            return if volume[0] * volume[1] < 0.0 {
                self.both_sliding([Mode::Right, Mode::Right], found)?;
                self.both_sliding([Mode::Left, Mode::Left], found)
            } else {
                self.both_sliding([Mode::Right, Mode::Left], found)?;
                self.both_sliding([Mode::Left, Mode::Right], found)
            };
        }
        self.words_in_motion(&line, found)
    }

    /// The words in which both contacts are closed and at least one slides; `None` also if ties decide which.
    #[inline(never)]
    fn words_in_motion(&self, line: &Vector3<f64>, found: &mut PairModes) -> Option<()> {
        // A tie that no force changes.
        for (fixed, other) in [(0, 1), (1, 0)].map(|(i, j)| (self.rows[i], self.rows[j])) {
            if fixed.sliding == Some(0)
                && other.sliding == Some(0)
                && is_doubtful(other.tangent.dot(&pivot(fixed, other)) + other.bias[0])
            {
                return None;
            }
        }
        for &first in closed_letters(self.rows[0]) {
            for &second in closed_letters(self.rows[1]) {
                match (first, second) {
                    (Mode::Fixed, Mode::Fixed) => self.both_fixed(found),
                    (Mode::Fixed, _) => self.pivoting(0, second, found)?,
                    (_, Mode::Fixed) => self.pivoting(1, first, found)?,
                    _ if self.can_slide([first, second], line) => {
                        self.both_sliding([first, second], found)?;
                    }
                    _ => {}
                }
            }
        }
        Some(())
    }

    /// The words in which contact `i` alone is closed; `None` if a friction matrix is singular.
    #[inline(always)]
    fn alone(&self, i: usize, found: &mut PairModes) -> Option<()> {
        match self.rows[i].sliding {
            None => {}
            Some(0) => {
                self.fixed(i, found);
                self.sliding(i, Mode::Right, found)?;
                self.sliding(i, Mode::Left, found)?;
            }
            Some(1) => self.sliding(i, Mode::Right, found)?,
            Some(_) => self.sliding(i, Mode::Left, found)?,
        }
        Some(())
    }

    #[inline(always)]
    fn closed(&self, i: usize, mode: Mode, force: [f64; 2], found: &mut PairModes) {
        let (mut letters, mut forces) = ([Mode::Separate; 2], [[0.0; 2]; 2]);
        (letters[i], forces[i]) = (mode, force);
        found.add(self, letters, forces);
    }

    /// [1, N·T; N·T, T·T] (f_n, f_t) = −need: its determinant is |N × T|² > 0.
    #[inline(always)]
    fn fixed(&self, i: usize, found: &mut PairModes) {
        let ([tangential, normal], mixed, own) = (self.need[i], self.mixed[i], self.own[i]);
        let det = own - mixed * mixed; // its rounding error is that of the numerators and cancels
        let force =
            [(mixed * normal - tangential) / det, (mixed * tangential - own * normal) / det];
        self.closed(i, Mode::Fixed, force, found);
    }

    /// N·(N ∓ μT) f_n = −need
    #[inline(always)]
    fn sliding(&self, i: usize, mode: Mode, found: &mut PairModes) -> Option<()> {
        let mu = self.rows[i].friction;
        let slip = -mode.direction() * mu;
        let matrix = 1.0 + slip * self.mixed[i];
        if matrix.abs() <= DEPENDENT_ROW * (1.0 + mu) {
            return None;
        }
        let f = -self.need[i][1] / matrix;
        self.closed(i, mode, [slip * f, f], found);
        Some(())
    }

    /// Whether an acceleration that keeps both contacts closed can slide in these directions.
    fn can_slide(&self, modes: [Mode; 2], line: &Vector3<f64>) -> bool {
        let [one, two] = self.rows;
        // Accelerations p + s·line keep both closed; T_i·(p + s·line) has to have the sign of its letter.
        let det = line.norm_squared(); // 1 − cosine²
        let p = one.normal * ((self.cosine * two.bias[1] - one.bias[1]) / det)
            + two.normal * ((self.cosine * one.bias[1] - two.bias[1]) / det);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (row, mode) in self.rows.iter().zip(modes) {
            if row.sliding != Some(0) {
                continue;
            }
            let (base, slope) = (
                mode.direction() * (row.tangent.dot(&p) + row.bias[0]),
                mode.direction() * row.tangent.dot(line),
            );
            if slope.abs() <= DEPENDENT_ROW {
                if base <= TIE {
                    return false;
                }
            } else {
                let cut = -base / slope;
                if slope > 0.0 {
                    low = low.max(cut);
                } else {
                    high = high.min(cut);
                }
            }
        }
        high - low > TIE
    }

    /// Both slide: a system of two. `None` if it is singular.
    #[inline(always)]
    fn both_sliding(&self, modes: [Mode; 2], found: &mut PairModes) -> Option<()> {
        let [one, two] = self.rows;
        let slip = [-modes[0].direction() * one.friction, -modes[1].direction() * two.friction];
        let m = [
            [1.0 + slip[0] * self.mixed[0], self.cosine + slip[1] * self.across[0]],
            [self.cosine + slip[0] * self.across[1], 1.0 + slip[1] * self.mixed[1]],
        ];
        let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        let size = (1.0 + one.friction) * (1.0 + two.friction);
        if determinant.abs() <= DEPENDENT_ROW * size {
            return None;
        }
        let need = [self.need[0][1], self.need[1][1]];
        let f = [
            (m[0][1] * need[1] - m[1][1] * need[0]) / determinant,
            (m[1][0] * need[0] - m[0][0] * need[1]) / determinant,
        ];
        found.add(self, modes, [[slip[0] * f[0], f[0]], [slip[1] * f[1], f[1]]]);
        Some(())
    }

    /// Contact `i` is fixed, the other one slides: three rows determine the acceleration. `None` if the system for the forces is
    /// singular.
    fn pivoting(&self, i: usize, mode: Mode, found: &mut PairModes) -> Option<()> {
        let (fixed, other) = (self.rows[i], self.rows[1 - i]);
        let y = pivot(fixed, other);
        let along = mode.direction() * (other.tangent.dot(&y) + other.bias[0]);
        if other.sliding == Some(0) && along <= TIE {
            return Some(());
        }
        // y − w = N f_n + T f_t + γ f: each force by the row that is perpendicular to the two other directions.
        let slip = -mode.direction() * other.friction;
        let gamma = other.normal + other.tangent * slip;
        let volume = fixed.normal.cross(&fixed.tangent).dot(&gamma);
        if volume.abs() <= DEPENDENT_ROW * (1.0 + other.friction) {
            return None;
        }
        let rest = y - self.load;
        let f = fixed.normal.cross(&fixed.tangent).dot(&rest) / volume;
        let mut forces = [[0.0; 2]; 2];
        forces[i] = [
            gamma.cross(&fixed.normal).dot(&rest) / volume,
            fixed.tangent.cross(&gamma).dot(&rest) / volume,
        ];
        forces[1 - i] = [slip * f, f];
        let letters = if i == 0 { [Mode::Fixed, mode] } else { [mode, Mode::Fixed] };
        found.add(self, letters, forces);
        Some(())
    }

    /// Both fixed: the acceleration from three rows, if it satisfies the fourth; the forces are well inside their cones.
    #[inline(always)]
    fn both_fixed(&self, found: &mut PairModes) {
        let [one, two] = self.rows;
        let y = pivot(one, two);
        if (two.tangent.dot(&y) + two.bias[0]).abs() > TIE {
            return;
        }
        let family = Squeeze::between(self.rows, y - self.load);
        found.add(self, [Mode::Fixed; 2], family.forces(family.inside));
    }
}

/// The acceleration that fixes one contact and keeps another closed.
fn pivot(fixed: &Row, other: &Row) -> Vector3<f64> {
    meet([fixed.normal, fixed.tangent, other.normal], [fixed.bias[1], fixed.bias[0], other.bias[1]])
}

/// The intersection of three planes row·y + bias = 0.
fn meet(rows: [Vector3<f64>; 3], bias: [f64; 3]) -> Vector3<f64> {
    if bias == [0.0; 3] {
        return Vector3::zeros();
    }
    let [a, b, c] = rows;
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    -(bc * bias[0] + ca * bias[1] + ab * bias[2]) / a.dot(&bc)
}
