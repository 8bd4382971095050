//! Every consistent mode, by enumeration: the solver of record.
//!
//! An acceleration belongs to one word at most: where it vanishes, where it opens and which way it slides decide
//! every letter. Candidates are therefore not all 4ⁿ words but the flats of the arrangement of contact rows: the
//! subspaces on which up to three rows vanish, and with them every row that depends on those. On a flat, each
//! contact that stays closed and may slide either way cuts it in two, and each cell is one word. In the plane that
//! makes O(n³) words; two contacts at rest in general position have ten.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::modes::answer::{
    Condition, Forces, Margin, ModeAnswer, ROUNDING, TIE, is_doubtful, test,
};
use crate::modes::problem::{ContactProblem, Row};
use crate::modes::words::{Mode, Word};
use crate::modes::{hyperstatic, pair};
use crate::outcome::ContactNumber;

/// Distance of a row of length about one from the span of others below which it depends on them.
///
/// Rows carry rounding of order 1e-16; a larger value would treat contacts that are merely close as one.
pub(super) const DEPENDENT: f64 = 1e-10;

/// All words the contacts of the problem offer, each solved.
pub(super) fn enumerate(problem: &ContactProblem) -> Vec<ModeAnswer> {
    let rows = problem.rows();
    let mut words = BTreeSet::new();
    let mut still = false;
    let mut visit = |flat: &Flat| {
        // Without bias all flats that are points are the same one.
        let is_origin = flat.rank == 3 && flat.point == Vector3::zeros();
        if !(is_origin && still) {
            flat.words(rows, &mut words);
        }
        still |= is_origin;
    };
    let flat = Flat::everything();
    visit(&flat);
    for i in (0..rows.len()).filter(|&i| rows[i].sliding.is_some()) {
        let Some(one) = flat.with(normal(&rows[i])) else { continue };
        visit(&one);
        let fixed = |flat: &Flat, k: usize| {
            (rows[k].sliding == Some(0)).then(|| flat.with(tangent(&rows[k]))).flatten()
        };
        if let Some(two) = fixed(&one, i) {
            visit(&two);
            for j in (0..rows.len()).filter(|&j| j != i && rows[j].sliding.is_some()) {
                if let Some(three) = two.with(normal(&rows[j])) {
                    visit(&three);
                }
                if one.holds(&rows[j])
                    && let Some(three) = fixed(&two, j)
                {
                    visit(&three);
                }
            }
        }
        for j in (i + 1..rows.len()).filter(|&j| rows[j].sliding.is_some()) {
            let Some(two) = one.with(normal(&rows[j])) else { continue };
            visit(&two);
            for k in (0..rows.len()).filter(|&k| rows[k].sliding.is_some()) {
                if k > j
                    && let Some(three) = two.with(normal(&rows[k]))
                {
                    visit(&three);
                }
                if k != i
                    && k != j
                    && two.holds(&rows[k])
                    && let Some(three) = fixed(&two, k)
                {
                    visit(&three);
                }
            }
        }
    }
    words.into_iter().map(|word| solve(problem, word)).collect()
}

/// A row and its bias: it vanishes where row·y + bias = 0.
pub(super) type Plane = (Vector3<f64>, f64);

fn normal(row: &Row) -> Plane {
    (row.normal, row.bias[1])
}

fn tangent(row: &Row) -> Plane {
    (row.tangent, row.bias[0])
}

/// The accelerations on which some rows vanish: a point of it and an orthonormal basis of those rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flat {
    point: Vector3<f64>,
    rows: [Vector3<f64>; 3],
    rank: usize,
}

/// What a row is on a flat.
enum On {
    Constant(f64),
    Free,
}

impl Flat {
    pub(super) fn everything() -> Self {
        Self { point: Vector3::zeros(), rows: [Vector3::zeros(); 3], rank: 0 }
    }

    /// The part of `row` along the flat.
    fn along(&self, row: &Vector3<f64>) -> Vector3<f64> {
        let mut rest = *row;
        for basis in &self.rows[..self.rank] {
            rest -= basis * basis.dot(&rest);
        }
        rest
    }

    /// Where this plane cuts the flat; `None` if it depends on the rows of the flat.
    pub(super) fn with(&self, (row, bias): Plane) -> Option<Self> {
        let rest = self.along(&row);
        let length = rest.norm();
        if self.rank == 3 || length <= DEPENDENT {
            return None;
        }
        let mut cut = *self;
        let direction = self.along(&(rest / length)).normalize();
        cut.point -= direction * ((row.dot(&self.point) + bias) / row.dot(&direction));
        cut.rows[self.rank] = direction;
        cut.rank += 1;
        Some(cut)
    }

    /// Orthonormal rows that vanish on the flat and nowhere else.
    pub(super) fn planes(&self) -> Vec<Plane> {
        self.rows[..self.rank].iter().map(|row| (*row, -row.dot(&self.point))).collect()
    }

    fn value(&self, (row, bias): Plane) -> On {
        if self.along(&row).norm_squared() > DEPENDENT * DEPENDENT {
            On::Free
        } else {
            On::Constant(row.dot(&self.point) + bias)
        }
    }

    /// Whether the contact stays closed on all of the flat.
    fn holds(&self, row: &Row) -> bool {
        matches!(self.value(normal(row)), On::Constant(value) if value.abs() <= TIE)
    }

    /// Adds the words of the cells of this flat: with ties given to the static word, and as the signs say.
    fn words(&self, rows: &[Row], words: &mut BTreeSet<Word>) {
        if self.words_above(TIE, rows, words) {
            self.words_above(ROUNDING, rows, words);
        }
    }

    /// Adds the words, accelerations up to `zero` counting as zero; says whether one of them is a tie.
    fn words_above(&self, zero: f64, rows: &[Row], words: &mut BTreeSet<Word>) -> bool {
        let mut doubtful = false;
        let mut constant = |value: f64| {
            doubtful |= is_doubtful(value);
            if value.abs() <= zero { 0.0 } else { value }
        };
        let mut word = Word::separate(rows.len());
        let mut undecided: Vec<(usize, Plane)> = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            if row.sliding.is_none() {
                continue;
            }
            match self.value(normal(row)) {
                On::Constant(value) => match constant(value) {
                    ..0.0 => return false, // into the ground on all of the flat
                    0.0 => {}
                    _ => continue, // opens
                },
                On::Free => continue, // opens
            }
            word = match row.sliding {
                Some(1) => word.with(i, Mode::Right),
                Some(-1) => word.with(i, Mode::Left),
                _ => match self.value(tangent(row)) {
                    On::Constant(value) => word.with(
                        i,
                        match constant(value) {
                            ..0.0 => Mode::Left,
                            0.0 => Mode::Fixed,
                            _ => Mode::Right,
                        },
                    ),
                    On::Free => {
                        undecided.push((i, tangent(row)));
                        word
                    }
                },
            };
        }
        self.cells(&undecided, &mut |signs| {
            let letters = undecided.iter().zip(signs).fold(word, |word, ((i, _), right)| {
                word.with(*i, if *right { Mode::Right } else { Mode::Left })
            });
            words.insert(letters);
        });
        doubtful
    }

    /// The sign patterns of these planes on the open cells into which they cut the flat.
    fn cells(&self, planes: &[(usize, Plane)], found: &mut impl FnMut(&[bool])) {
        match planes {
            [] => found(&[]),
            [_] => {
                found(&[false]);
                found(&[true]);
            }
            _ => {
                // Every cell has a side on one of the planes, or the planes are all the same one.
                let mut signs = vec![false; planes.len()];
                for &(_, plane) in planes {
                    let Some(side) = self.with(plane) else { continue };
                    side.inner_points(planes, &mut |point| {
                        for away in [-1.0, 1.0] {
                            let across = side.rows[self.rank] * away;
                            for (sign, (_, (row, bias))) in signs.iter_mut().zip(planes) {
                                let value = row.dot(point) + bias;
                                *sign = if value.abs() > TIE {
                                    value > 0.0
                                } else {
                                    row.dot(&across) > 0.0
                                };
                            }
                            found(&signs);
                        }
                    });
                }
            }
        }
    }

    /// One point of each open piece into which the planes cut this flat, a line or a point.
    fn inner_points(&self, planes: &[(usize, Plane)], found: &mut impl FnMut(&Vector3<f64>)) {
        if self.rank == 3 {
            return found(&self.point);
        }
        let direction = self.rows[0].cross(&self.rows[1]);
        let mut cuts: Vec<f64> = planes
            .iter()
            .filter(|(_, (row, _))| row.dot(&direction).abs() > DEPENDENT)
            .map(|(_, (row, bias))| -(row.dot(&self.point) + bias) / row.dot(&direction))
            .collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| (*a - *b).abs() <= TIE * (1.0 + b.abs()));
        let mut at = |s: f64| found(&(self.point + direction * s));
        match (cuts.first(), cuts.last()) {
            (Some(first), Some(last)) => {
                at(first - 1.0);
                cuts.windows(2).for_each(|pair| at(0.5 * (pair[0] + pair[1])));
                at(last + 1.0);
            }
            _ => at(0.0),
        }
    }
}

/// The equations of a word and the forces that act: one row per unknown force.
struct Equations {
    /// Row and bias that vanish, by unknown.
    planes: Vec<Plane>,
    /// Direction of the unknown force.
    directions: Vec<Vector3<f64>>,
    /// Contact of the unknown, and whether it is a tangential force of its own.
    owner: Vec<(usize, bool)>,
}

impl Equations {
    fn of(rows: &[Row], word: Word) -> Self {
        let unknowns = word.modes().map(|mode| match mode {
            Mode::Separate => 0,
            Mode::Fixed => 2,
            Mode::Right | Mode::Left => 1,
        });
        let n = unknowns.sum();
        let mut all = Self {
            planes: Vec::with_capacity(n),
            directions: Vec::with_capacity(n),
            owner: Vec::with_capacity(n),
        };
        for (i, mode) in word.modes().enumerate() {
            if mode == Mode::Separate {
                continue;
            }
            let row = &rows[i];
            all.planes.push(normal(row));
            all.directions.push(row.normal - row.tangent * (mode.direction() * row.friction));
            all.owner.push((i, false));
            if mode == Mode::Fixed {
                all.planes.push(tangent(row));
                all.directions.push(row.tangent);
                all.owner.push((i, true));
            }
        }
        all
    }
}

/// Solves the word in its own system.
pub(super) fn solve(problem: &ContactProblem, word: Word) -> ModeAnswer {
    let (rows, load) = (problem.rows(), problem.load());
    let equations = Equations::of(rows, word);
    let n = equations.planes.len();
    let mut flat = Flat::everything();
    let mut dependent = Vec::new();
    for (plane, owner) in equations.planes.iter().zip(&equations.owner) {
        if let Some(cut) = flat.with(*plane) {
            flat = cut;
        } else {
            dependent.push((*plane, *owner));
        }
    }
    let square = n == flat.rank;
    if square && let Some(unknown) = isostatic(&equations, &load) {
        let (y, forces) = act(rows, &load, &equations, word, &unknown[..n]);
        return judge(problem, word, &y, &forces, Forces::Unique);
    }
    let ties: Vec<Margin> = dependent
        .into_iter()
        .map(|((row, bias), (i, tangential))| Margin {
            contact: ContactNumber::of(i),
            condition: if tangential { Condition::Sticks } else { Condition::Touches },
            value: -(row.dot(&flat.point) + bias).abs(),
        })
        .filter(|margin| margin.value < -ROUNDING)
        .collect();
    let mut answer = match equations.owner[..] {
        [(i, false), (_, true), (j, false), (_, true)]
            if flat.rank == 3 && ties.iter().all(Margin::holds) =>
        {
            pair::both_fixed(problem, word, &flat.point, [i, j])
        }
        _ => hyperstatic::solve(problem, word, &equations.planes, &flat.planes()),
    };
    answer.singular = square; // else it would have been solved
    if answer.determined != Forces::Impossible && !ties.is_empty() {
        answer.margins.extend(ties);
        answer.margins.sort_by_key(|margin| margin.contact);
        answer.consistent = answer.margins.iter().all(Margin::holds);
    }
    answer
}

/// As many unknown forces as independent rows: Gaussian elimination with pivoting; `None` where the friction
/// matrix row_k·direction_l is singular.
fn isostatic(equations: &Equations, load: &Vector3<f64>) -> Option<[f64; 3]> {
    let n = equations.planes.len();
    let mut m = [[0.0; 4]; 3];
    for (k, (row, bias)) in equations.planes.iter().enumerate() {
        for (l, direction) in equations.directions.iter().enumerate() {
            m[k][l] = row.dot(direction);
        }
        m[k][3] = -(row.dot(load) + bias);
    }
    let size = equations.directions.iter().map(|d| d.amax()).fold(1.0, f64::max);
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| m[i][k].abs().total_cmp(&m[j][k].abs()))?;
        if m[pivot][k].abs() <= DEPENDENT * size {
            return None;
        }
        m.swap(k, pivot);
        for i in k + 1..n {
            let factor = m[i][k] / m[k][k];
            for l in k..4 {
                m[i][l] -= factor * m[k][l];
            }
        }
    }
    let mut x = [0.0; 3];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|l| m[k][l] * x[l]).sum();
        x[k] = (m[k][3] - known) / m[k][k];
    }
    Some(x)
}

/// The acceleration, and the forces by contact, of these unknowns.
fn act(
    rows: &[Row],
    load: &Vector3<f64>,
    equations: &Equations,
    word: Word,
    unknown: &[f64],
) -> (Vector3<f64>, Vec<[f64; 2]>) {
    let mut y = *load;
    let mut forces = vec![[0.0; 2]; rows.len()];
    for ((&(i, tangential), direction), &f) in
        equations.owner.iter().zip(&equations.directions).zip(unknown)
    {
        y += direction * f;
        if tangential {
            forces[i][0] = f;
        } else {
            forces[i][1] = f;
            forces[i][0] = -word.mode(i).direction() * rows[i].friction * f;
        }
    }
    (y, forces)
}

/// Puts the word's tests to a solution.
pub(super) fn judge(
    problem: &ContactProblem,
    word: Word,
    y: &Vector3<f64>,
    scaled: &[[f64; 2]],
    determined: Forces,
) -> ModeAnswer {
    if determined == Forces::Impossible {
        let (acceleration, forces) = ([f64::NAN; 3], vec![[f64::NAN; 2]; scaled.len()]);
        let (margins, consistent) = (Vec::new(), false);
        let force_interval = None;
        return ModeAnswer {
            word,
            acceleration,
            forces,
            determined,
            force_interval,
            margins,
            consistent,
            singular: false,
        };
    }
    let mut margins = Vec::with_capacity(2 * scaled.len());
    for (i, row) in problem.rows().iter().enumerate() {
        let tangential = || row.tangent.dot(y) + row.bias[0];
        let normal = || row.normal.dot(y) + row.bias[1];
        test(row, word.mode(i), tangential, normal, scaled[i], |condition, value| {
            margins.push(Margin { contact: ContactNumber::of(i), condition, value });
        });
    }
    let consistent = margins.iter().all(Margin::holds) && !leans_on_a_tie(&margins);
    ModeAnswer {
        word,
        acceleration: problem.acceleration(y),
        forces: scaled.iter().enumerate().map(|(i, force)| problem.force(i, *force)).collect(),
        determined,
        force_interval: None,
        margins,
        consistent,
        singular: false,
    }
}

/// Accelerations that a force outside its cone may buy, per unit of that force: rows are of length about one.
const LEVER: f64 = 100.0;

/// Whether an acceleration that has to differ from zero owes it to a force that is in its cone by a tie only.
pub(super) fn leans_on_a_tie(margins: &[Margin]) -> bool {
    let least = |strict: bool| {
        let of_kind = margins.iter().filter(|m| m.condition.is_strict() == strict);
        of_kind.map(|m| m.value).fold(f64::INFINITY, f64::min)
    };
    let missing = -least(false);
    missing > ROUNDING && least(true) <= TIE + LEVER * missing
}
