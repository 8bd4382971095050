//! Flats of the arrangement of contact rows, and the words of their cells: see [`enumerate`](super::enumerate).

use std::collections::BTreeSet;

use crate::math::mass_vector::{Basis, MassVector};
use crate::math::simplex::maximise;
use crate::modes::answer::is_doubtful;
use crate::modes::rows::Row;
use crate::modes::words::{Mode, Word};
use crate::tolerance::{DEPENDENT_ROW, FIXED_ACCELERATION, TIE};

/// A row and its bias: it vanishes where row·y + bias = 0.
pub(super) type Plane<'a, V> = (&'a V, f64);

pub(super) fn normal<V: MassVector>(row: &Row<V>) -> Plane<'_, V> {
    (&row.normal, row.bias[1])
}

pub(super) fn tangent<V: MassVector>(row: &Row<V>) -> Plane<'_, V> {
    (&row.tangent, row.bias[0])
}

/// Words, at most so many.
pub(super) struct Words {
    found: BTreeSet<Word>,
    most: usize,
    /// Whether there are more.
    pub(super) full: bool,
}

impl Words {
    pub(super) fn at_most(most: usize) -> Self {
        Self { found: BTreeSet::new(), most, full: false }
    }

    /// Returns true if there is room for more.
    fn add(&mut self, word: Word) -> bool {
        self.full |= self.found.len() >= self.most;
        if !self.full {
            self.found.insert(word);
        }
        !self.full
    }

    pub(super) fn into_iter(self) -> impl Iterator<Item = Word> {
        self.found.into_iter()
    }
}

/// The set of accelerations on which some rows vanish: a point of it and an orthonormal basis of those rows.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Flat<V: MassVector> {
    pub(super) point: V,
    rows: V::Basis,
}

/// The values of a row on a flat.
enum On {
    Constant(f64),
    Free,
}

impl<V: MassVector> Flat<V> {
    /// All accelerations of so many coordinates.
    pub(super) fn everything(coordinates: usize) -> Self {
        Self { point: V::zeros(coordinates), rows: V::Basis::empty() }
    }

    /// Number of independent rows.
    pub(super) fn rank(&self) -> usize {
        self.rows.vectors().len()
    }

    pub(super) fn is_point(&self) -> bool {
        self.rank() == self.point.len()
    }

    /// The part of `row` along the flat.
    #[inline]
    fn along(&self, row: &V) -> V {
        let mut rest = row.clone();
        for basis in self.rows.vectors() {
            let part = basis.dot(&rest);
            rest.add_scaled(basis, -part);
        }
        rest
    }

    /// The intersection of this plane with the flat; `None` if it depends on the rows of the flat.
    pub(super) fn with(&self, (row, bias): Plane<'_, V>) -> Option<Self> {
        let rest = self.along(row);
        let length = rest.norm();
        if self.is_point() || length <= DEPENDENT_ROW {
            return None;
        }
        let mut cut = self.clone();
        let direction = self.along(&rest.divided(length));
        let direction = direction.divided(direction.norm());
        cut.point.add_scaled(&direction, -((row.dot(&self.point) + bias) / row.dot(&direction)));
        cut.rows.push(direction);
        Some(cut)
    }

    /// Orthonormal rows that vanish exactly on the flat.
    pub(super) fn planes(&self) -> Vec<Plane<'_, V>> {
        self.rows.vectors().iter().map(|row| (row, -row.dot(&self.point))).collect()
    }

    /// The acceleration of the flat that is nearest to `y`: forces along its rows lead from one to the other.
    pub(super) fn nearest(&self, y: &V) -> V {
        if self.is_point() {
            return self.point.clone();
        }
        let mut nearest = y.clone();
        for row in self.rows.vectors() {
            let off = row.dot(&nearest) - row.dot(&self.point);
            nearest.add_scaled(row, -off);
        }
        nearest
    }

    fn value(&self, (row, bias): Plane<'_, V>) -> On {
        if self.along(row).norm_squared() > DEPENDENT_ROW * DEPENDENT_ROW {
            On::Free
        } else {
            On::Constant(row.dot(&self.point) + bias)
        }
    }

    /// Returns true if the contact stays closed on all of the flat.
    pub(super) fn holds(&self, row: &Row<V>) -> bool {
        matches!(self.value(normal(row)), On::Constant(value) if value.abs() <= TIE)
    }

    /// Adds the words of the cells of this flat. If an acceleration is a tie, adds both the words in which it counts as zero and the words
    /// that its sign gives.
    pub(super) fn words(&self, rows: &[Row<V>], words: &mut Words) {
        if self.words_above(TIE, rows, words) {
            self.words_above(FIXED_ACCELERATION, rows, words);
        }
    }

    /// Adds the words of the cells if accelerations up to `zero` count as zero. Returns whether one of the accelerations is a tie.
    fn words_above(&self, zero: f64, rows: &[Row<V>], words: &mut Words) -> bool {
        let mut doubtful = false;
        let mut constant = |value: f64| {
            doubtful |= is_doubtful(value);
            if value.abs() <= zero { 0.0 } else { value }
        };
        let mut word = Word::separate(rows.len());
        let mut undecided: Vec<(usize, Plane<'_, V>)> = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            if row.sliding.is_none() {
                continue;
            }
            match self.value(normal(row)) {
                On::Constant(value) => match constant(value) {
                    ..0.0 => return false, // the contact enters the ground on the whole flat
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
            words.add(letters)
        });
        doubtful
    }

    /// The sign patterns of these planes on the open cells into which they divide the flat, until `found` returns false.
    fn cells(&self, planes: &[(usize, Plane<'_, V>)], found: &mut impl FnMut(&[bool]) -> bool) {
        match planes {
            [] => {
                found(&[]);
            }
            [_] => {
                let _ = found(&[false]) && found(&[true]);
            }
            // In three dimensions, where there is a vector product.
            _ if self.point.cross(&self.point).is_some() => {
                // Each cell has a side on one of the planes, unless all planes are equal.
                let mut signs = vec![false; planes.len()];
                for &(_, plane) in planes {
                    let Some(side) = self.with(plane) else { continue };
                    side.inner_points(planes, &mut |point| {
                        for away in [-1.0, 1.0] {
                            let across = side.rows.vectors()[self.rank()].scaled(away);
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
            _ => self.many_cells(planes, found),
        }
    }

    /// One point of each open piece into which the planes divide this flat, which is a line or a point in three dimensions.
    fn inner_points(&self, planes: &[(usize, Plane<'_, V>)], found: &mut impl FnMut(&V)) {
        if self.is_point() {
            return found(&self.point);
        }
        let Some(direction) = self.rows.vectors()[0].cross(&self.rows.vectors()[1]) else { return };
        let mut cuts: Vec<f64> = planes
            .iter()
            .filter(|(_, (row, _))| row.dot(&direction).abs() > DEPENDENT_ROW)
            .map(|(_, (row, bias))| -(row.dot(&self.point) + bias) / row.dot(&direction))
            .collect();
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| (*a - *b).abs() <= TIE * (1.0 + b.abs()));
        let mut at = |s: f64| found(&self.point.plus(&direction, s));
        match (cuts.first(), cuts.last()) {
            (Some(first), Some(last)) => {
                at(first - 1.0);
                cuts.windows(2).for_each(|pair| at(0.5 * (pair[0] + pair[1])));
                at(last + 1.0);
            }
            _ => at(0.0),
        }
    }

    /// [`cells`](Self::cells) in any dimension: the signs are chosen one after the other. Planes that are independent on the flat have all
    /// patterns; for further planes a linear programme tells whether a cell has an interior.
    fn many_cells(
        &self,
        planes: &[(usize, Plane<'_, V>)],
        found: &mut impl FnMut(&[bool]) -> bool,
    ) {
        let mut span = self.clone();
        let mut independent = 0;
        for (k, (_, plane)) in planes.iter().enumerate() {
            let Some(cut) = span.with((plane.0, 0.0)) else { continue };
            span = cut;
            independent += usize::from(independent == k);
        }
        // Value and slopes of each plane along the new directions, with slopes of length one.
        let sides: Vec<(f64, Vec<f64>)> = planes
            .iter()
            .map(|(_, (row, bias))| {
                let length = self.along(row).norm();
                let slopes =
                    span.rows.vectors()[self.rank()..].iter().map(|axis| axis.dot(row) / length);
                ((row.dot(&self.point) + bias) / length, slopes.collect())
            })
            .collect();
        let mut signs = Vec::with_capacity(planes.len());
        choose(&sides, independent, &mut signs, found);
    }
}

/// Adds signs to `signs` in every way that leaves an open cell. Returns whether to go on.
fn choose(
    sides: &[(f64, Vec<f64>)],
    independent: usize,
    signs: &mut Vec<bool>,
    found: &mut impl FnMut(&[bool]) -> bool,
) -> bool {
    if signs.len() == sides.len() {
        return found(signs);
    }
    for sign in [false, true] {
        signs.push(sign);
        let goes_on = (signs.len() > independent && !is_open(sides, signs))
            || choose(sides, independent, signs, found);
        signs.pop();
        if !goes_on {
            return false;
        }
    }
    true
}

/// Returns true if a point has these signs on the first sides, by more than a tie.
fn is_open(sides: &[(f64, Vec<f64>)], signs: &[bool]) -> bool {
    // max t with sign·(value + slopes·z) ≥ t and t ≤ 1. Variables: z as the difference of two, t, a slack for each row.
    let axes = sides[0].1.len();
    let width = 2 * axes + 1 + signs.len() + 1;
    let mut programme: Vec<(Vec<f64>, f64)> = Vec::with_capacity(signs.len() + 1);
    for (k, ((value, slopes), positive)) in sides.iter().zip(signs).enumerate() {
        let sign = if *positive { 1.0 } else { -1.0 };
        let mut a = vec![0.0; width];
        for (axis, slope) in slopes.iter().enumerate() {
            (a[2 * axis], a[2 * axis + 1]) = (sign * slope, -sign * slope);
        }
        (a[2 * axes], a[2 * axes + 1 + k]) = (-1.0, -1.0);
        programme.push((a, -sign * value));
    }
    let mut cap = vec![0.0; width];
    (cap[2 * axes], cap[width - 1]) = (1.0, 1.0);
    programme.push((cap, 1.0));
    let mut objective = vec![0.0; width];
    objective[2 * axes] = 1.0;
    maximise(&programme, &objective).is_some_and(|x| x[2 * axes] > TIE)
}
