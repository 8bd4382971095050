//! Vectors of coordinates in which the kinetic energy is ½|v|²: three of them for a rigid body, any number for a mechanism.

use std::fmt::Debug;

use nalgebra::Vector3;
use smallvec::SmallVec;

use crate::tolerance::DEPENDENT_ROW;

/// A vector in the metric of the mass.
pub(crate) trait MassVector: Clone + PartialEq + Debug {
    /// At most as many vectors as they have components.
    type Basis: Basis<Self>;

    /// Zero, with `len` components. A [`Vector3`] always has three.
    fn zeros(len: usize) -> Self;
    /// Number of components.
    fn len(&self) -> usize;
    fn dot(&self, other: &Self) -> f64;
    /// Adds `other` times `factor`.
    fn add_scaled(&mut self, other: &Self, factor: f64);
    /// The largest component, in size.
    fn amax(&self) -> f64;
    /// Each component divided by `by`. With the reciprocal of `by` it would be rounded twice.
    fn divided(&self, by: f64) -> Self;
    fn components(&self) -> impl ExactSizeIterator<Item = f64> + '_;
    /// These components, then zeros up to `len`.
    fn of(len: usize, components: impl IntoIterator<Item = f64>) -> Self;
    /// The vector product, which three components have.
    fn cross(&self, other: &Self) -> Option<Self>;

    fn scaled(&self, factor: f64) -> Self {
        let mut product = Self::zeros(self.len());
        product.add_scaled(self, factor);
        product
    }

    fn plus(&self, other: &Self, factor: f64) -> Self {
        let mut sum = self.clone();
        sum.add_scaled(other, factor);
        sum
    }

    fn norm_squared(&self) -> f64 {
        self.dot(self)
    }

    fn norm(&self) -> f64 {
        self.norm_squared().sqrt()
    }
}

/// Independent vectors.
pub(crate) trait Basis<V>: Clone + PartialEq + Debug {
    fn empty() -> Self;
    fn vectors(&self) -> &[V];
    /// One more vector.
    fn push(&mut self, vector: V);
}

/// Up to three vectors of three components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct UpToThree {
    vectors: [Vector3<f64>; 3],
    len: usize,
}

impl Basis<Vector3<f64>> for UpToThree {
    fn empty() -> Self {
        Self { vectors: [Vector3::zeros(); 3], len: 0 }
    }

    #[inline(always)]
    fn vectors(&self) -> &[Vector3<f64>] {
        &self.vectors[..self.len]
    }

    #[inline(always)]
    fn push(&mut self, vector: Vector3<f64>) {
        self.vectors[self.len] = vector;
        self.len += 1;
    }
}

impl Basis<Coordinates> for SmallVec<[Coordinates; 4]> {
    fn empty() -> Self {
        Self::new()
    }

    fn vectors(&self) -> &[Coordinates] {
        self
    }

    fn push(&mut self, vector: Coordinates) {
        self.push(vector);
    }
}

impl MassVector for Vector3<f64> {
    type Basis = UpToThree;

    fn zeros(len: usize) -> Self {
        debug_assert!(len <= 3, "a vector of three has no room for {len} components");
        Self::zeros()
    }

    fn len(&self) -> usize {
        3
    }

    #[inline(always)]
    fn dot(&self, other: &Self) -> f64 {
        nalgebra::Vector3::dot(self, other)
    }

    #[inline(always)]
    fn add_scaled(&mut self, other: &Self, factor: f64) {
        *self += other * factor;
    }

    #[inline(always)]
    fn amax(&self) -> f64 {
        nalgebra::Vector3::amax(self)
    }

    #[inline(always)]
    fn divided(&self, by: f64) -> Self {
        self / by
    }

    fn components(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.iter().copied()
    }

    fn of(len: usize, components: impl IntoIterator<Item = f64>) -> Self {
        let mut all = <Self as MassVector>::zeros(len);
        all.iter_mut().zip(components).for_each(|(to, from)| *to = from);
        all
    }

    #[inline(always)]
    fn cross(&self, other: &Self) -> Option<Self> {
        Some(nalgebra::Vector3::cross(self, other))
    }

    #[inline(always)]
    fn scaled(&self, factor: f64) -> Self {
        self * factor
    }

    #[inline(always)]
    fn plus(&self, other: &Self, factor: f64) -> Self {
        self + other * factor
    }

    #[inline(always)]
    fn norm_squared(&self) -> f64 {
        nalgebra::Vector3::norm_squared(self)
    }

    #[inline(always)]
    fn norm(&self) -> f64 {
        nalgebra::Vector3::norm(self)
    }
}

/// Any number of components, without allocation for up to four.
#[derive(Debug, PartialEq, Default)]
pub(crate) struct Coordinates(SmallVec<[f64; 4]>);

/// Written by hand: the derived `clone` copies the numbers one by one.
impl Clone for Coordinates {
    #[inline]
    fn clone(&self) -> Self {
        Self(SmallVec::from_slice(&self.0))
    }
}

impl Coordinates {
    pub(crate) fn from_iter(components: impl IntoIterator<Item = f64>) -> Self {
        Self(components.into_iter().collect())
    }

    /// Three components.
    pub(crate) fn of_three(components: [f64; 3]) -> Self {
        Self(SmallVec::from_slice(&components))
    }

    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.0.iter().copied()
    }

    /// Sets all components to zero.
    pub(crate) fn clear(&mut self) {
        self.0.fill(0.0);
    }
}

impl MassVector for Coordinates {
    type Basis = SmallVec<[Self; 4]>;

    fn zeros(len: usize) -> Self {
        Self(SmallVec::from_elem(0.0, len))
    }

    fn len(&self) -> usize {
        self.0.len()
    }

    #[inline]
    fn dot(&self, other: &Self) -> f64 {
        self.0.iter().zip(&other.0).map(|(x, y)| x * y).sum()
    }

    #[inline]
    fn add_scaled(&mut self, other: &Self, factor: f64) {
        self.0.iter_mut().zip(&other.0).for_each(|(x, y)| *x += y * factor);
    }

    #[inline]
    fn amax(&self) -> f64 {
        self.0.iter().fold(0.0, |most, x| most.max(x.abs()))
    }

    #[inline]
    fn divided(&self, by: f64) -> Self {
        let mut divided = self.clone();
        divided.0.iter_mut().for_each(|x| *x /= by);
        divided
    }

    fn components(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.0.iter().copied()
    }

    fn of(len: usize, components: impl IntoIterator<Item = f64>) -> Self {
        let mut all = Self::zeros(len);
        all.0.iter_mut().zip(components).for_each(|(to, from)| *to = from);
        all
    }

    fn cross(&self, _: &Self) -> Option<Self> {
        None
    }
}

/// Independent ones of these rows, with the orthonormal directions that they span: each direction is the part of its row that is orthogonal to
/// the rows before it. The row with the largest part, in units of its length, comes first. `apart`: the least such part.
pub(crate) fn independent<V: MassVector>(rows: &[&V], apart: f64) -> SmallVec<[(usize, V); 4]> {
    let mut left: SmallVec<[(V, f64); 4]> = SmallVec::new();
    left.extend(rows.iter().map(|row| ((*row).clone(), row.norm())));
    let mut basis: SmallVec<[(usize, V); 4]> = SmallVec::new();
    let Some(dimension) = rows.first().map(|row| row.len()) else { return basis };
    while basis.len() < dimension.min(rows.len()) {
        let shares: SmallVec<[f64; 8]> =
            left.iter().map(|(rest, length)| rest.norm() / length).collect();
        let longest = (0..left.len()).max_by(|&i, &j| shares[i].total_cmp(&shares[j]));
        let Some(k) = longest.filter(|&k| shares[k] > apart) else { break };
        let mut axis = left[k].0.divided(left[k].0.norm());
        // The part along earlier directions is rounding error, which a short rest magnifies.
        for (_, before) in &basis {
            let part = before.dot(&axis);
            axis.add_scaled(before, -part);
        }
        axis = axis.divided(axis.norm());
        for (rest, _) in &mut left {
            let part = axis.dot(rest);
            rest.add_scaled(&axis, -part);
        }
        left[k].0 = V::zeros(dimension);
        basis.push((k, axis));
    }
    basis
}

/// The shortest vector with these products with these rows; `None` if rows depend on each other.
pub(crate) fn with_products(rows: &[&Coordinates], products: &[f64]) -> Option<Coordinates> {
    let basis = independent(rows, DEPENDENT_ROW);
    if basis.len() < rows.len() {
        return None;
    }
    let mut x = Coordinates::zeros(rows.first()?.len());
    for (k, axis) in &basis {
        x.add_scaled(axis, (products[*k] - rows[*k].dot(&x)) / rows[*k].dot(axis));
    }
    Some(x)
}
