//! Flats of the arrangement of contact rows, and the words of their cells: see [`enumerate`](super::enumerate).

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::modes::answer::is_doubtful;
use crate::modes::problem::Row;
use crate::modes::words::{Mode, Word};
use crate::tolerance::{DEPENDENT_ROW, FIXED_ACCELERATION, TIE};

/// A row and its bias: it vanishes where row·y + bias = 0.
pub(super) type Plane = (Vector3<f64>, f64);

pub(super) fn normal(row: &Row) -> Plane {
    (row.normal, row.bias[1])
}

pub(super) fn tangent(row: &Row) -> Plane {
    (row.tangent, row.bias[0])
}

/// The set of accelerations on which some rows vanish: a point of it and an orthonormal basis of those rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flat {
    pub(super) point: Vector3<f64>,
    rows: [Vector3<f64>; 3],
    pub(super) rank: usize,
}

/// The values of a row on a flat.
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

    /// The intersection of this plane with the flat; `None` if it depends on the rows of the flat.
    pub(super) fn with(&self, (row, bias): Plane) -> Option<Self> {
        let rest = self.along(&row);
        let length = rest.norm();
        if self.rank == 3 || length <= DEPENDENT_ROW {
            return None;
        }
        let mut cut = *self;
        let direction = self.along(&(rest / length)).normalize();
        cut.point -= direction * ((row.dot(&self.point) + bias) / row.dot(&direction));
        cut.rows[self.rank] = direction;
        cut.rank += 1;
        Some(cut)
    }

    /// Orthonormal rows that vanish exactly on the flat.
    pub(super) fn planes(&self) -> Vec<Plane> {
        self.rows[..self.rank].iter().map(|row| (*row, -row.dot(&self.point))).collect()
    }

    fn value(&self, (row, bias): Plane) -> On {
        if self.along(&row).norm_squared() > DEPENDENT_ROW * DEPENDENT_ROW {
            On::Free
        } else {
            On::Constant(row.dot(&self.point) + bias)
        }
    }

    /// Whether the contact stays closed on all of the flat.
    pub(super) fn holds(&self, row: &Row) -> bool {
        matches!(self.value(normal(row)), On::Constant(value) if value.abs() <= TIE)
    }

    /// Adds the words of the cells of this flat. If an acceleration is a tie, adds both the words in which it counts as zero and the words
    /// that its sign gives.
    pub(super) fn words(&self, rows: &[Row], words: &mut BTreeSet<Word>) {
        if self.words_above(TIE, rows, words) {
            self.words_above(FIXED_ACCELERATION, rows, words);
        }
    }

    /// Adds the words of the cells if accelerations up to `zero` count as zero. Returns whether one of the accelerations is a tie.
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
            words.insert(letters);
        });
        doubtful
    }

    /// The sign patterns of these planes on the open cells into which they divide the flat.
    fn cells(&self, planes: &[(usize, Plane)], found: &mut impl FnMut(&[bool])) {
        match planes {
            [] => found(&[]),
            [_] => {
                found(&[false]);
                found(&[true]);
            }
            _ => {
                // Each cell has a side on one of the planes, unless all planes are equal.
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

    /// One point of each open piece into which the planes divide this flat, which is a line or a point.
    fn inner_points(&self, planes: &[(usize, Plane)], found: &mut impl FnMut(&Vector3<f64>)) {
        if self.rank == 3 {
            return found(&self.point);
        }
        let direction = self.rows[0].cross(&self.rows[1]);
        let mut cuts: Vec<f64> = planes
            .iter()
            .filter(|(_, (row, _))| row.dot(&direction).abs() > DEPENDENT_ROW)
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
