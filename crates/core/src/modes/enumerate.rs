//! Every consistent mode, by enumeration. This is the reference solver.
//!
//! An acceleration belongs to at most one word, because the signs of its components at the contacts determine each letter.
//! The candidates are therefore not all 4ⁿ words but the cells of the flats of the arrangement of contact rows. A flat is a subspace
//! on which some normal rows vanish, and tangential rows of contacts that stay closed on it, and with them each row that depends on these.
//! Each contact that stays closed on a flat and may slide in both directions divides it in two, and each cell is one word. For a body, with
//! three coordinates, this gives O(n³) words; two contacts at rest in general position have ten. With r coordinates it gives O(nʳ), at most 4ⁿ.

use smallvec::{SmallVec, smallvec};

use crate::math::mass_vector::MassVector;
use crate::modes::answer::{Condition, Forces, Margin, ModeAnswer};
use crate::modes::flats::{Flat, Plane, Words, normal, tangent};
use crate::modes::judge::judge;
use crate::modes::rows::Row;
use crate::modes::scaled::Problem;
use crate::modes::words::{Mode, Word};
use crate::modes::{hyperstatic, pair};
use crate::outcome::ContactNumber;
use crate::tolerance::{DEPENDENT_ROW, FIXED_ACCELERATION};

/// Largest number of words, and of flats, that are enumerated for more than three coordinates: those of eight contacts that move
/// independently. Their answers take 0.1 GB.
const MOST_WORDS: usize = 1 << 16;

/// All words that the state of the contacts allows, each solved; `None` if there may be more than [`MOST_WORDS`].
pub(super) fn enumerate<P: Problem>(problem: &P) -> Option<Vec<ModeAnswer>> {
    let (rows, coordinates) = (problem.rows(), problem.load().len());
    let most = if coordinates > 3 { MOST_WORDS } else { usize::MAX };
    let mut flats = Flats { rows, words: Words::at_most(most), left: most, still: false };
    let all = Flat::everything(coordinates);
    let enough = flats.visit(&all) && flats.close(&all, 0);
    enough.then(|| flats.words.into_iter().map(|word| solve(problem, word)).collect())
}

/// The flats, each visited once for each basis among its rows in their order.
struct Flats<'a, V: MassVector> {
    rows: &'a [Row<V>],
    words: Words,
    /// How many more may be visited.
    left: usize,
    /// Whether the flat that is the origin alone has been visited.
    still: bool,
}

impl<V: MassVector> Flats<'_, V> {
    /// Takes the words of a flat. Returns whether to go on.
    fn visit(&mut self, flat: &Flat<V>) -> bool {
        // Without bias all flats that are points are equal.
        let is_origin = flat.is_point() && flat.point.amax() == 0.0;
        if !(is_origin && self.still) {
            flat.words(self.rows, &mut self.words);
        }
        self.still |= is_origin;
        let goes_on = self.left > 0 && !self.words.full;
        self.left = self.left.saturating_sub(1);
        goes_on
    }

    /// The flats within this one on which a contact from `first` on is closed, too, and those on which contacts are fixed.
    fn close(&mut self, flat: &Flat<V>, first: usize) -> bool {
        if flat.is_point() {
            return true;
        }
        (first..self.rows.len()).all(|i| {
            self.rows[i].sliding.is_none()
                || flat
                    .with(normal(&self.rows[i]))
                    .is_none_or(|cut| self.visit(&cut) && self.close(&cut, i + 1))
        }) && (flat.rank() == 0 || self.fix(flat, &self.held(flat)))
    }

    /// The contacts at rest that stay closed on all of the flat.
    fn held(&self, flat: &Flat<V>) -> SmallVec<[usize; 8]> {
        let rows = self.rows.iter().enumerate();
        rows.filter(|(_, row)| row.sliding == Some(0) && flat.holds(row)).map(|(i, _)| i).collect()
    }

    /// The flats within this one on which some of these contacts are fixed.
    fn fix(&mut self, flat: &Flat<V>, held: &[usize]) -> bool {
        if flat.is_point() {
            return true;
        }
        held.iter().enumerate().all(|(k, &i)| {
            flat.with(tangent(&self.rows[i]))
                .is_none_or(|cut| self.visit(&cut) && self.fix(&cut, &held[k + 1..]))
        })
    }
}

/// The equations of a word and the forces that act: one row per unknown force.
struct Equations<'a, V: MassVector> {
    /// Row and bias that vanish, for each unknown.
    planes: Vec<Plane<'a, V>>,
    /// Direction of the unknown force.
    directions: Vec<V>,
    /// Contact of the unknown, and whether the unknown is a tangential force independent of the normal force.
    owner: Vec<(usize, bool)>,
}

impl<'a, V: MassVector> Equations<'a, V> {
    fn of(rows: &'a [Row<V>], word: Word) -> Self {
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
            all.directions.push(row.normal.plus(&row.tangent, -(mode.direction() * row.friction)));
            all.owner.push((i, false));
            if mode == Mode::Fixed {
                all.planes.push(tangent(row));
                all.directions.push(row.tangent.clone());
                all.owner.push((i, true));
            }
        }
        all
    }
}

/// Solves the word in its own system.
pub(super) fn solve<P: Problem>(problem: &P, word: Word) -> ModeAnswer {
    let (rows, load) = (problem.rows(), problem.load());
    let equations = Equations::of(rows, word);
    let n = equations.planes.len();
    let mut flat = Flat::everything(load.len());
    let mut dependent = Vec::new();
    for (plane, owner) in equations.planes.iter().zip(&equations.owner) {
        if let Some(cut) = flat.with(*plane) {
            flat = cut;
        } else {
            dependent.push((*plane, *owner));
        }
    }
    let square = n == flat.rank();
    if square && let Some(unknown) = isostatic(&equations, load) {
        let (y, forces) = act(rows, load, &equations, word, &unknown);
        return judge(problem, word, &y, &forces, Forces::Unique);
    }
    let ties: Vec<Margin> = dependent
        .into_iter()
        .map(|((row, bias), (i, tangential))| Margin {
            contact: ContactNumber::of(i),
            condition: if tangential { Condition::Sticks } else { Condition::Touches },
            value: -(row.dot(&flat.point) + bias).abs(),
        })
        .filter(|margin| margin.value < -FIXED_ACCELERATION)
        .collect();
    let mut answer = match equations.owner[..] {
        [(i, false), (_, true), (j, false), (_, true)]
            if flat.rank() == 3 && ties.iter().all(Margin::holds) =>
        {
            pair::both_fixed(problem, word, &flat.nearest(load), [i, j])
        }
        _ => hyperstatic::solve(problem, word, &equations.planes, &flat.planes()),
    };
    answer.singular = square; // a regular square system has been solved above
    if answer.determined != Forces::Impossible && !ties.is_empty() {
        answer.margins.extend(ties);
        answer.margins.sort_by_key(|margin| margin.contact);
        answer.consistent = answer.margins.iter().all(Margin::holds);
    }
    answer
}

/// As many unknown forces as independent rows; `None` where the friction matrix row_k·direction_l is singular.
fn isostatic<V: MassVector>(equations: &Equations<'_, V>, load: &V) -> Option<SmallVec<[f64; 3]>> {
    let n = equations.planes.len();
    if n <= 3 {
        return eliminated(equations, load, &mut [0.0; 12], 4);
    }
    eliminated(equations, load, &mut vec![0.0; n * (n + 1)], n + 1)
}

/// Gaussian elimination with pivoting in the matrix `m` of zeros. Its rows have `width` entries, the right-hand side last.
#[inline(always)]
fn eliminated<V: MassVector>(
    equations: &Equations<'_, V>,
    load: &V,
    m: &mut [f64],
    width: usize,
) -> Option<SmallVec<[f64; 3]>> {
    let (n, last) = (equations.planes.len(), width - 1);
    for (k, (row, bias)) in equations.planes.iter().enumerate() {
        for (l, direction) in equations.directions.iter().enumerate() {
            m[k * width + l] = row.dot(direction);
        }
        m[k * width + last] = -(row.dot(load) + bias);
    }
    let size = equations.directions.iter().map(|d| d.amax()).fold(1.0, f64::max);
    for k in 0..n {
        let entry = |i: usize| m[i * width + k].abs();
        let pivot = (k..n).max_by(|&i, &j| entry(i).total_cmp(&entry(j)))?;
        if entry(pivot) <= DEPENDENT_ROW * size {
            return None;
        }
        if pivot != k {
            (0..width).for_each(|l| m.swap(k * width + l, pivot * width + l));
        }
        for i in k + 1..n {
            let factor = m[i * width + k] / m[k * width + k];
            for l in k..width {
                m[i * width + l] -= factor * m[k * width + l];
            }
        }
    }
    let mut x: SmallVec<[f64; 3]> = smallvec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|l| m[k * width + l] * x[l]).sum();
        x[k] = (m[k * width + last] - known) / m[k * width + k];
    }
    Some(x)
}

/// The acceleration, and the forces by contact, of these unknowns.
fn act<V: MassVector>(
    rows: &[Row<V>],
    load: &V,
    equations: &Equations<'_, V>,
    word: Word,
    unknown: &[f64],
) -> (V, Vec<[f64; 2]>) {
    let mut y = load.clone();
    let mut forces = vec![[0.0; 2]; rows.len()];
    for ((&(i, tangential), direction), &f) in
        equations.owner.iter().zip(&equations.directions).zip(unknown)
    {
        y.add_scaled(direction, f);
        if tangential {
            forces[i][0] = f;
        } else {
            forces[i][1] = f;
            forces[i][0] = -word.mode(i).direction() * rows[i].friction * f;
        }
    }
    (y, forces)
}
