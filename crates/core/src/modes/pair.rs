//! One or two contacts: every word in closed form, without allocation.
//!
//! In the mass metric normal rows have length one, and a sliding contact has N·γ = 1 − σμ N·T. Words of one closed
//! contact take one division or a system of two, words of two closed contacts one of two or three. Two fixed
//! contacts are hyperstatic: their acceleration follows from three of their rows, their forces form a segment.

use nalgebra::{Vector2, Vector3};

use super::answer::{Forces, ModeAnswer, TIE, test};
use super::enumerate::{DEPENDENT, judge};
use super::problem::{ContactProblem, Row};
use super::words::{Mode, Word};

/// A word of one or two contacts, solved, in scaled quantities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairMode {
    /// Whether every test holds.
    pub consistent: bool,
    /// Whether a test holds or fails by no more than [`TIE`].
    pub near_degenerate: bool,
    letters: [Mode; 2],
    y: Vector3<f64>,
    forces: [[f64; 2]; 2],
    /// Range of the internal force of two fixed contacts, and its value in `forces`.
    internal: Option<([f64; 2], f64)>,
}

/// The words that one or two contacts offer, in no particular order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairModes {
    // Three letters that are not S for each, alone or with those of the other, and SS.
    modes: [Option<PairMode>; 16],
    len: usize,
}

impl PairModes {
    /// The words, solved.
    pub fn iter(&self) -> impl Iterator<Item = &PairMode> {
        self.modes[..self.len].iter().flatten()
    }

    /// The consistent ones.
    pub fn consistent(&self) -> impl Iterator<Item = &PairMode> {
        self.iter().filter(|mode| mode.consistent)
    }

    #[inline]
    fn add(
        &mut self,
        rows: &[&Row; 2],
        letters: [Mode; 2],
        y: Vector3<f64>,
        forces: [[f64; 2]; 2],
    ) {
        let (mut consistent, mut near_degenerate) = (true, false);
        for i in 0..2 {
            test(rows[i], letters[i], &y, forces[i], |condition, value| {
                consistent &= condition.holds(value);
                near_degenerate |= value.abs() <= TIE;
            });
        }
        let internal = None;
        self.modes[self.len] =
            Some(PairMode { consistent, near_degenerate, letters, y, forces, internal });
        self.len += 1;
    }
}

impl PairMode {
    /// Modes of the two contacts; of a contact that is not there: S.
    #[must_use]
    pub fn letters(&self) -> [Mode; 2] {
        self.letters
    }

    /// q̈, in m/s² and rad/s² (impulse level: the velocity after, in m/s and rad/s).
    #[must_use]
    pub fn acceleration(&self, problem: &ContactProblem) -> [f64; 3] {
        problem.acceleration(&self.y)
    }

    /// (f_t, f_n) at the contact with this index, in N (impulse level: N s); the smallest where they are not unique.
    #[must_use]
    pub fn force(&self, problem: &ContactProblem, index: usize) -> [f64; 2] {
        let mut scaled = self.forces[index];
        if let (Some((range, now)), [one, two]) = (self.internal, problem.rows()) {
            // Internal forces τ(e, −e) change nothing; the smallest forces have as little of them as can be.
            let (row, sign) = if index == 0 { (one, 1.0) } else { (two, -1.0) };
            let tau = sign * (0.0_f64.clamp(range[0], range[1]) - now);
            let e = row.turn(towards(one, two));
            scaled[0] += tau * e[0];
            scaled[1] += tau * e[1];
        }
        problem.force(index, scaled)
    }

    pub(super) fn answer(&self, problem: &ContactProblem) -> ModeAnswer {
        let n = problem.rows().len();
        let word = (0..n).fold(Word::separate(n), |word, i| word.with(i, self.letters[i]));
        let determined = self.internal.map_or(Forces::Unique, |_| Forces::Family);
        let mut answer = judge(problem, word, &self.y, &self.forces[..n], determined);
        answer.forces = (0..n).map(|i| self.force(problem, i)).collect();
        answer.force_interval =
            self.internal.map(|(range, _)| range.map(|end| problem.internal_force(end)));
        answer
    }
}

/// Unit vector from contact 1 to contact 2, world axes.
fn towards(one: &Row, two: &Row) -> Vector2<f64> {
    (two.place() - one.place()).normalize()
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
    /// The modes of one or two contacts in closed form: what [`contact_modes`](crate::contact_modes) finds, without
    /// its margins and without allocation.
    ///
    /// `None` for more contacts, and where rows of two contacts depend on each other (contacts at one point, or with
    /// a normal in common).
    #[must_use]
    pub fn pair_modes(&self) -> Option<PairModes> {
        let mut found = PairModes { modes: [None; 16], len: 0 };
        let (solver, count) = match self.rows() {
            [one] => (Solver::new([one, &Row::ABSENT], self.load()), 1),
            [one, two] => (Solver::new([one, two], self.load()), 2),
            _ => return None,
        };
        let rows = &solver.rows;
        found.add(rows, [Mode::Separate; 2], solver.load, [[0.0; 2]; 2]);
        for i in 0..count {
            for &mode in closed_letters(rows[i]) {
                let (y, force) = solver.alone(i, mode)?;
                let (mut letters, mut forces) = ([Mode::Separate; 2], [[0.0; 2]; 2]);
                (letters[i], forces[i]) = (mode, force);
                found.add(rows, letters, y, forces);
            }
        }
        let [one, two] = rows;
        if one.sliding.is_some() && two.sliding.is_some() {
            let line = one.normal.cross(&two.normal);
            let volume = [one.tangent.dot(&line), -two.tangent.dot(&line)]; // N_i·(T_i × N_j), of either sign
            if line.norm_squared() <= DEPENDENT * DEPENDENT
                || volume[0].abs() <= DEPENDENT
                || volume[1].abs() <= DEPENDENT
            {
                return None;
            }
            // At rest without bias nothing pivots, and both slide along one motion, forwards or backwards.
            let quiet = rows.iter().all(|row| row.sliding == Some(0) && row.bias == [0.0; 2]);
            let together = -volume[0] * volume[1] > 0.0;
            let still = |first: Mode, second: Mode| {
                let slide = first.direction() * second.direction();
                slide == 0.0 || (slide > 0.0) != together
            };
            for &first in closed_letters(one) {
                for &second in closed_letters(two) {
                    match (first, second) {
                        (Mode::Fixed, Mode::Fixed) => solver.both_fixed(&mut found),
                        _ if quiet && still(first, second) => {}
                        (Mode::Fixed, _) => solver.pivoting(0, second, &mut found)?,
                        (_, Mode::Fixed) => solver.pivoting(1, first, &mut found)?,
                        _ => solver.both_sliding([first, second], &line, &mut found)?,
                    }
                }
            }
        }
        Some(found)
    }
}

/// Rows, load, and what the rows make of the load.
struct Solver<'a> {
    rows: [&'a Row; 2],
    load: Vector3<f64>,
    /// N_i·w + bias and T_i·w + bias: the accelerations that forces have to undo.
    need: [[f64; 2]; 2],
    /// N_i·T_i and N_i·T_j
    mixed: [f64; 2],
    across: [f64; 2],
    /// N_1·N_2
    cosine: f64,
}

impl<'a> Solver<'a> {
    fn new(rows: [&'a Row; 2], load: Vector3<f64>) -> Self {
        Self {
            rows,
            load,
            need: rows.map(|row| {
                [row.tangent.dot(&load) + row.bias[0], row.normal.dot(&load) + row.bias[1]]
            }),
            mixed: rows.map(|row| row.normal.dot(&row.tangent)),
            across: [0, 1].map(|i: usize| rows[i].normal.dot(&rows[1 - i].tangent)),
            cosine: rows[0].normal.dot(&rows[1].normal),
        }
    }

    /// What a force (tangential, normal) at contact `i` does.
    fn push(&self, i: usize, force: [f64; 2]) -> Vector3<f64> {
        self.rows[i].tangent * force[0] + self.rows[i].normal * force[1]
    }

    /// Acceleration and force where contact `i` alone is closed; `None` if its friction matrix is singular.
    fn alone(&self, i: usize, mode: Mode) -> Option<(Vector3<f64>, [f64; 2])> {
        let row = self.rows[i];
        let [tangential, normal] = self.need[i];
        let force = if mode == Mode::Fixed {
            // [1, N·T; N·T, T·T] (f_n, f_t) = −need: its determinant is |N × T|² > 0.
            let (mixed, own) = (self.mixed[i], row.tangent.norm_squared());
            let det = own - mixed * mixed;
            [(mixed * normal - tangential) / det, (mixed * tangential - own * normal) / det]
        } else {
            let slip = -mode.direction() * row.friction;
            let matrix = 1.0 + slip * self.mixed[i];
            if matrix.abs() <= DEPENDENT * (1.0 + row.friction) {
                return None;
            }
            let f = -normal / matrix;
            [slip * f, f]
        };
        Some((self.load + self.push(i, force), force))
    }

    /// Both slide: a system of two. Offered if some acceleration that keeps both closed slides that way.
    fn both_sliding(
        &self,
        modes: [Mode; 2],
        line: &Vector3<f64>,
        found: &mut PairModes,
    ) -> Option<()> {
        let [one, two] = self.rows;
        // Accelerations p + s·line keep both closed; T_i·(p + s·line) has to have the sign of its letter.
        let p = if one.bias[1] == 0.0 && two.bias[1] == 0.0 {
            Vector3::zeros()
        } else {
            let det = line.norm_squared(); // 1 − cosine²
            one.normal * ((self.cosine * two.bias[1] - one.bias[1]) / det)
                + two.normal * ((self.cosine * one.bias[1] - two.bias[1]) / det)
        };
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for (row, mode) in self.rows.iter().zip(modes) {
            if row.sliding != Some(0) {
                continue;
            }
            let (base, slope) = (
                mode.direction() * (row.tangent.dot(&p) + row.bias[0]),
                mode.direction() * row.tangent.dot(line),
            );
            if slope.abs() <= DEPENDENT {
                if base <= TIE {
                    return Some(()); // never slides that way
                }
            } else {
                let cut = if base == 0.0 { 0.0 } else { -base / slope };
                if slope > 0.0 {
                    low = low.max(cut);
                } else {
                    high = high.min(cut);
                }
            }
        }
        if !(high - low > TIE) {
            return Some(());
        }
        let slip = [0, 1].map(|i| -modes[i].direction() * self.rows[i].friction);
        let m = [
            [1.0 + slip[0] * self.mixed[0], self.cosine + slip[1] * self.across[0]],
            [self.cosine + slip[0] * self.across[1], 1.0 + slip[1] * self.mixed[1]],
        ];
        let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
        let size = (1.0 + one.friction) * (1.0 + two.friction);
        if determinant.abs() <= DEPENDENT * size {
            return None;
        }
        let need = [self.need[0][1], self.need[1][1]];
        let f = [
            (m[0][1] * need[1] - m[1][1] * need[0]) / determinant,
            (m[1][0] * need[0] - m[0][0] * need[1]) / determinant,
        ];
        let forces = [0, 1].map(|i| [slip[i] * f[i], f[i]]);
        let y = self.load + self.push(0, forces[0]) + self.push(1, forces[1]);
        found.add(&self.rows, modes, y, forces);
        Some(())
    }

    /// Contact `i` is fixed, the other slides: three rows determine the acceleration.
    fn pivoting(&self, i: usize, mode: Mode, found: &mut PairModes) -> Option<()> {
        let (fixed, other) = (self.rows[i], self.rows[1 - i]);
        let planes = [fixed.normal, fixed.tangent, other.normal];
        let y = meet(planes, [fixed.bias[1], fixed.bias[0], other.bias[1]]);
        let along = mode.direction() * (other.tangent.dot(&y) + other.bias[0]);
        if other.sliding == Some(0) && along <= TIE {
            return Some(());
        }
        // y − w = N f_n + T f_t + γ f: by the rows that are perpendicular to two of them each.
        let slip = -mode.direction() * other.friction;
        let gamma = other.normal + other.tangent * slip;
        let volume = fixed.normal.cross(&fixed.tangent).dot(&gamma);
        if volume.abs() <= DEPENDENT * (1.0 + other.friction) {
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
        found.add(&self.rows, letters, y, forces);
        Some(())
    }

    /// Both fixed: the acceleration by three rows, if it suits the fourth; forces p + τs, where s squeezes along
    /// the line between the contacts.
    fn both_fixed(&self, found: &mut PairModes) {
        let [one, two] = self.rows;
        let y =
            meet([one.normal, one.tangent, two.normal], [one.bias[1], one.bias[0], two.bias[1]]);
        if (two.tangent.dot(&y) + two.bias[0]).abs() > TIE {
            return;
        }
        // A squeeze does nothing: s_1t T_1 + s_1n N_1 + s_2t T_2 + s_2n N_2 = 0.
        let columns = [one.tangent, one.normal, two.tangent, two.normal];
        let minor = |a: usize, b: usize, c: usize| columns[a].cross(&columns[b]).dot(&columns[c]);
        let squeeze = [minor(1, 2, 3), -minor(0, 2, 3), minor(0, 1, 3), -minor(0, 1, 2)];
        let rest = y - self.load;
        // Without the tangential force of contact 2, then from there along the squeeze.
        let volume = minor(0, 1, 3);
        let solved = |a: usize, b: usize| columns[a].cross(&columns[b]).dot(&rest) / volume;
        let base = [solved(1, 3), solved(3, 0), 0.0, solved(0, 1)];
        let tests = [0, 1].map(|i| {
            let (mu, t, n) = (self.rows[i].friction, 2 * i, 2 * i + 1);
            let unit = 1.0 + mu;
            // f_n ≥ 0 and both sides of the cone, as value + τ slope ≥ 0.
            [
                (base[n], squeeze[n]),
                ((mu * base[n] - base[t]) / unit, (mu * squeeze[n] - squeeze[t]) / unit),
                ((mu * base[n] + base[t]) / unit, (mu * squeeze[n] + squeeze[t]) / unit),
            ]
        });
        let tests = tests.as_flattened();
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for &(value, slope) in tests {
            if slope > 0.0 {
                low = low.max(-value / slope);
            } else if slope < 0.0 {
                high = high.min(-value / slope);
            }
        }
        // Forces well inside; where there is hardly an inside, those that meet the tests best.
        let mut tau = match (low.is_finite(), high.is_finite()) {
            (true, true) => 0.5 * (low + high),
            (true, false) => low + 1.0 + low.abs(),
            _ => high - 1.0 - high.abs(),
        };
        if !(least(tests, tau) > TIE) {
            tau = best(tests, tau);
        }
        if !(low <= high) {
            (low, high) = (tau, tau);
        }
        let f = |k: usize| base[k] + tau * squeeze[k];
        found.add(&self.rows, [Mode::Fixed; 2], y, [[f(0), f(1)], [f(2), f(3)]]);

        // Internal force (f_1 − f_2)·e/2: linear in τ, and zero for the smallest forces of all.
        let e = towards(one, two) * 0.5;
        let along = |f: &[f64; 4]| {
            let pull = |k: usize| columns[k].xy().dot(&e) * f[k];
            pull(0) + pull(1) - pull(2) - pull(3)
        };
        let (start, slope) = (along(&base), along(&squeeze));
        let at = |tau: f64| start + slope * tau;
        let range = if slope > 0.0 { [at(low), at(high)] } else { [at(high), at(low)] };
        if let Some(mode) = &mut found.modes[found.len - 1] {
            mode.internal = Some((range, at(tau)));
        }
    }
}

/// The smallest of the tests value + τ slope.
fn least(tests: &[(f64, f64)], tau: f64) -> f64 {
    tests.iter().map(|(value, slope)| value + tau * slope).fold(f64::INFINITY, f64::min)
}

/// Where the smallest test is largest: two of them are equal there. `tau` is another guess.
#[cold]
fn best(tests: &[(f64, f64)], tau: f64) -> f64 {
    let mut best = tau;
    for (k, (v, s)) in tests.iter().enumerate() {
        for (w, r) in &tests[k + 1..] {
            let tau = (w - v) / (s - r);
            if tau.is_finite() && least(tests, tau) > least(tests, best) {
                best = tau;
            }
        }
    }
    best
}

/// Where three planes row·y + bias = 0 meet.
fn meet(rows: [Vector3<f64>; 3], bias: [f64; 3]) -> Vector3<f64> {
    if bias == [0.0; 3] {
        return Vector3::zeros();
    }
    let [a, b, c] = rows;
    let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
    -(bc * bias[0] + ca * bias[1] + ab * bias[2]) / a.dot(&bc)
}
