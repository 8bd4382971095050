//! The rows of the contacts of a mechanism in mass-weighted coordinates, enclosed: M = L Lᵀ, A = R L⁻ᵀ. The numbers of the mechanism are taken
//! to be exact.

use nalgebra::DMatrix;

use crate::body::Mechanism;
use crate::math::interval::Interval;
use crate::math::real::Enclosed;

/// Rows of all contacts and the acceleration without contact forces, in units in which the mass is `unit`.
#[derive(Debug, Clone)]
pub(crate) struct EnclosedRows<T> {
    pub(crate) tangents: Vec<Vec<T>>,
    pub(crate) normals: Vec<Vec<T>>,
    pub(crate) pull: Vec<T>,
}

pub(crate) fn dot<T: Enclosed>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::ZERO, |sum, (x, y)| sum + *x * *y)
}

impl<T: Enclosed> EnclosedRows<T> {
    /// `None` if the bounds of a pivot are too wide. Rows are multiplied by √m and the acceleration is divided by it, m the first entry of the
    /// diagonal of M: with the coordinates of a rigid body they are per unit mass.
    pub(crate) fn of(mechanism: &Mechanism) -> Option<Self> {
        let (fields, free) = (mechanism.fields(), mechanism.contact_space().free());
        let exact = |x: f64| T::from(x);
        let f = free.len();
        let entry = |i: usize, j: usize| {
            let (a, b) = (free[i], free[j]);
            let sum = exact(fields.mass_matrix[a][b]) + exact(fields.mass_matrix[b][a]);
            let armature = fields.armature.get(a).copied().filter(|_| i == j).unwrap_or(0.0);
            sum.half() + exact(armature)
        };
        let mut factor: Vec<Vec<T>> = vec![vec![T::ZERO; f]; f];
        for j in 0..f {
            for i in j..f {
                let taken = dot(&factor[i][..j], &factor[j][..j]);
                let left = entry(i, j) - taken;
                factor[i][j] = if i == j { left.root()? } else { left.over(factor[j][j])? };
            }
        }
        let unit = entry(0, 0).root()?;
        let solved = |column: &[f64]| -> Option<Vec<T>> {
            let mut x: Vec<T> = Vec::with_capacity(f);
            for i in 0..f {
                let left = exact(column[free[i]]) - dot(&factor[i][..i], &x);
                x.push(left.over(factor[i][i])?);
            }
            Some(x)
        };
        let row = |column: &[f64]| -> Option<Vec<T>> {
            Some(solved(column)?.into_iter().map(|x| x * unit).collect())
        };
        let all = |of: &dyn Fn(usize) -> Vec<f64>| {
            (0..mechanism.contacts().len()).map(|i| row(&of(i))).collect::<Option<Vec<_>>>()
        };
        let pull = solved(&fields.load)?.into_iter().map(|x| x.over(unit));
        Some(Self {
            tangents: all(&|i| mechanism.contacts()[i].tangential.clone())?,
            normals: all(&|i| mechanism.contacts()[i].normal.clone())?,
            pull: pull.collect::<Option<_>>()?,
        })
    }

    /// Gravity into the ground of a contact, in m/s².
    pub(crate) fn gravity(&self, i: usize) -> T {
        -dot(&self.normals[i], &self.pull)
    }
}

impl EnclosedRows<Interval> {
    /// The parts of all rows along the columns of a matrix.
    pub(crate) fn along(&self, basis: &DMatrix<f64>) -> Self {
        let part = |row: &[Interval], column: &[f64]| {
            row.iter().zip(column).fold(Interval::ZERO, |sum, (x, y)| sum + x.times(*y))
        };
        let each = |row: &Vec<Interval>| {
            basis.column_iter().map(|column| part(row, column.as_slice())).collect::<Vec<_>>()
        };
        Self {
            tangents: self.tangents.iter().map(each).collect(),
            normals: self.normals.iter().map(each).collect(),
            pull: each(&self.pull),
        }
    }

    /// Each entry of a row, and of the acceleration, may differ by this share of its length.
    pub(crate) fn widened(mut self, width: f64) -> Self {
        let all = self.normals.iter_mut().chain(&mut self.tangents).chain([&mut self.pull]);
        for row in all {
            let length = dot(row, row).sqrt().hi;
            row.iter_mut().for_each(|part| *part = part.widened(width * length));
        }
        self
    }
}
