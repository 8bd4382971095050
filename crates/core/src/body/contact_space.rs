//! The dynamics of the contacts of a mechanism, whatever its number of coordinates.
//!
//! With R = [T; N] the rows of the contacts in the coordinates that are not locked, contact by contact (tangential, normal), and M with the
//! armature,
//!
//! ```text
//! (v̇_t, ḧ) = b + W f,    Δ(v_t, u) = W P,    W = R M⁻¹ Rᵀ,   b = R M⁻¹ load
//! ```
//!
//! With M = L Lᵀ (Cholesky) and A = R L⁻ᵀ, W is A Aᵀ: the coordinates y = Lᵀq have the kinetic energy ½|ẏ|², and A are the rows in them. If
//! there are more coordinates than A has independent rows, and more than three, only the part of y in the span of these rows is kept. The
//! contacts do not feel the rest, the *hidden* motion, which has a constant acceleration.

use nalgebra::{DMatrix, DVector, Vector2};

use crate::body::fields::MechanismFields;
use crate::body::geometry::ContactGeometry;
use crate::body::local_model::LocalModel;
use crate::error::Error;
use crate::math::mass_vector::{Coordinates, MassVector, independent};
use crate::math::unsigned_zero::UnsignedZero;
use crate::tolerance::{DEPENDENT_ROW, INDEFINITE, ONE_SIZE, PARALLEL_GAP_ROWS};

/// The dynamics of the contacts of a [`Mechanism`](crate::body::Mechanism) in its posture.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactSpace {
    w: DMatrix<f64>,
    b: DVector<f64>,
    rank: usize,
    reach: f64,
    /// The coordinates that are not locked.
    free: Vec<usize>,
    /// M with the armature, its factor L, and the load, of these coordinates.
    mass: DMatrix<f64>,
    factor: DMatrix<f64>,
    load: DVector<f64>,
    /// A (2n, r), contact by contact (tangential, normal).
    rows: Vec<Coordinates>,
    /// Acceleration ÿ without contact forces.
    pull: Coordinates,
    /// The orthonormal directions of y that are kept; `None`: all.
    basis: Option<DMatrix<f64>>,
    /// The acceleration of the hidden motion, in the coordinates Lᵀq.
    hidden: DVector<f64>,
}

impl ContactSpace {
    /// W (2n, 2n), symmetric and positive semidefinite, contact by contact (tangential, normal); in 1/kg if the rows are those of contact
    /// points.
    #[must_use]
    pub fn w(&self) -> &DMatrix<f64> {
        &self.w
    }

    /// b (2n): accelerations of the contacts without contact forces, in the same order, in m/s².
    #[must_use]
    pub fn b(&self) -> &DVector<f64> {
        &self.b
    }

    /// Rank of W: the number of independent rows among those of the contacts. 3 for a rigid body on two contacts, up to 4 for one with free
    /// joints.
    #[must_use]
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Number of contacts.
    pub(crate) fn count(&self) -> usize {
        self.rows.len() / 2
    }

    /// W of the normal rows of two contacts, counted from 0.
    pub(crate) fn normal(&self, i: usize, j: usize) -> f64 {
        self.w[(2 * i + 1, 2 * j + 1)]
    }

    /// The largest acceleration of a contact without contact forces, in m/s².
    pub(crate) fn largest_pull(&self) -> f64 {
        self.b.amax()
    }

    /// Gravity into the ground of a contact, g_i = −b_n,i, in m/s².
    pub(crate) fn gravity(&self, i: usize) -> f64 {
        -self.b[2 * i + 1]
    }

    /// The largest speed of a contact, normal or tangential, per unit speed |ẏ|: the largest √W_kk.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// The coordinates that are not locked, from 0.
    pub(crate) fn free(&self) -> &[usize] {
        &self.free
    }

    /// M with the armature, of the coordinates that are not locked.
    pub(crate) fn mass(&self) -> &DMatrix<f64> {
        &self.mass
    }

    /// The load of these coordinates.
    pub(crate) fn load(&self) -> &DVector<f64> {
        &self.load
    }

    pub(crate) fn tangent(&self, i: usize) -> &Coordinates {
        &self.rows[2 * i]
    }

    pub(crate) fn normal_row(&self, i: usize) -> &Coordinates {
        &self.rows[2 * i + 1]
    }

    /// ÿ without contact forces.
    pub(crate) fn pull(&self) -> &Coordinates {
        &self.pull
    }

    /// The orthonormal directions of Lᵀq that are kept, as columns; `None`: all.
    pub(crate) fn basis(&self) -> Option<&DMatrix<f64>> {
        self.basis.as_ref()
    }

    /// Acceleration of the hidden motion, zero if there is none.
    pub(crate) fn hidden(&self) -> &DVector<f64> {
        &self.hidden
    }

    /// The kept coordinates y of values (a displacement or a velocity) of all coordinates q, and the hidden part.
    pub(crate) fn split(&self, q: &[f64]) -> (Coordinates, DVector<f64>) {
        let own = DVector::from_iterator(self.free.len(), self.free.iter().map(|&k| q[k]));
        let mut whole = self.factor.tr_mul(&own);
        match &self.basis {
            None => (Coordinates::from_iter(whole.iter().copied()), DVector::zeros(own.len())),
            Some(basis) => {
                let kept = basis.tr_mul(&whole);
                whole -= basis * &kept;
                (Coordinates::from_iter(kept.iter().copied()), whole)
            }
        }
    }

    /// The values of the coordinates q that are not locked, from kept coordinates and the hidden part.
    pub(crate) fn whole(&self, y: &Coordinates, hidden: &DVector<f64>) -> DVector<f64> {
        let kept = DVector::from_iterator(y.len(), y.iter());
        let whole = match &self.basis {
            None => kept,
            Some(basis) => basis * kept + hidden,
        };
        self.factor.tr_solve_lower_triangular(&whole).unwrap_or(whole)
    }

    /// q̈ of all coordinates, from ÿ of the kept ones.
    pub(crate) fn acceleration(&self, dof: usize, y: &Coordinates) -> Vec<f64> {
        let mut all = vec![0.0; dof];
        for (&k, value) in self.free.iter().zip(self.whole(y, &self.hidden).iter()) {
            all[k] = value.unsigned_zero();
        }
        all
    }

    /// Of fields whose shapes and ranges have been checked.
    pub(crate) fn of(fields: &MechanismFields) -> Result<Self, Error> {
        let dof = fields.load.len();
        let free: Vec<usize> = (0..dof).filter(|k| !fields.locked.contains(k)).collect();
        let f = free.len();
        let armature = |k: usize| fields.armature.get(k).copied().unwrap_or(0.0);
        let mass = DMatrix::from_fn(f, f, |i, j| {
            let (a, b) = (free[i], free[j]);
            let mean = 0.5 * (fields.mass_matrix[a][b] + fields.mass_matrix[b][a]);
            if i == j { mean + armature(a) } else { mean }
        });
        let factor = cholesky(&mass, &free)?;
        let load = DVector::from_iterator(f, free.iter().map(|&k| fields.load[k]));
        let pull = solve_lower(&factor, load.iter().copied());
        let row = |of: &[f64]| solve_lower(&factor, free.iter().map(|&k| of[k]));
        let mut rows = Vec::with_capacity(2 * fields.contacts.len());
        for contact in &fields.contacts {
            rows.extend([row(&contact.tangential), row(&contact.normal)]);
        }
        for (i, pair) in rows.chunks_exact(2).enumerate() {
            two_directions(i, pair)?;
        }
        let basis: Vec<Coordinates> = independent(&rows.iter().collect::<Vec<_>>(), DEPENDENT_ROW)
            .into_iter()
            .map(|(_, axis)| axis)
            .collect();
        let rank = basis.len();
        let (mut kept_rows, mut kept) = (rows.clone(), None);
        if f > 3 && rank < f {
            kept_rows = rows.iter().map(|row| along(&basis, row)).collect();
            kept = Some(DMatrix::from_iterator(f, rank, basis.iter().flat_map(Coordinates::iter)));
        }
        let (kept_pull, hidden) = parts(kept.as_ref(), &pull);
        let w = products(&kept_rows);
        let b = accelerations(&kept_rows, &kept_pull);
        falls_down(&mass, &load, &b)?;
        Ok(Self {
            reach: w.diagonal().max().sqrt(),
            w,
            b,
            rank,
            free,
            mass,
            factor,
            load,
            rows: kept_rows,
            pull: kept_pull,
            basis: kept,
            hidden,
        })
    }

    /// Of a body of unit mass in its posture, y = (x, y, ρθ), with straight ground at each contact: impulses and forces are per unit mass.
    pub(crate) fn of_body(contacts: &[ContactGeometry], rho2: f64, gravity: f64) -> Self {
        let rho = rho2.sqrt();
        let arm = |k: &ContactGeometry| k.tangent * k.b + k.normal * k.touching_c();
        let rows: Vec<Coordinates> =
            contacts.iter().flat_map(|k| rows_of(k, rho).map(Coordinates::of_three)).collect();
        let pull = Coordinates::from_iter([0.0, -gravity, 0.0]);
        // A contact point has rows in all directions; a second one has another moment.
        let rank = if contacts.iter().all(|k| arm(k) == arm(&contacts[0])) { 2 } else { 3 };
        Self::of_rows(rows, pull, rank, vec![1.0, 1.0, rho])
    }

    /// Of the gaps of a local model: ψ_i = −W_12/W_ii and g_i = −b_i of the normal rows. The tangential rows are zero. `None` if the rows of
    /// the two gaps are parallel.
    pub(crate) fn of_local(model: &LocalModel) -> Option<Self> {
        let ([g1, g2], [psi, other]) = (model.gravity(), model.psi());
        let w = if other == 0.0 { 1.0 } else { psi / other };
        let apart = 1.0 - psi * other;
        if !(apart > PARALLEL_GAP_ROWS) {
            return None;
        }
        let across = (w * apart).sqrt();
        let none = Coordinates::from_iter([0.0, 0.0]);
        let one = Coordinates::from_iter([1.0, 0.0]);
        let two = Coordinates::from_iter([-psi, across]);
        let pull = Coordinates::from_iter([-g1, -(g2 + psi * g1) / across]);
        Some(Self::of_rows(vec![none.clone(), one, none, two], pull, 2, vec![1.0, 1.0]))
    }

    /// Of these rows; `roots`: the roots of the masses of the coordinates.
    fn of_rows(rows: Vec<Coordinates>, pull: Coordinates, rank: usize, roots: Vec<f64>) -> Self {
        let roots = DVector::from_vec(roots);
        let (w, b) = (products(&rows), accelerations(&rows, &pull));
        Self {
            reach: w.diagonal().max().sqrt(),
            w,
            b,
            rank,
            free: (0..roots.len()).collect(),
            mass: DMatrix::from_diagonal(&roots.component_mul(&roots)),
            load: DVector::from_iterator(roots.len(), pull.iter()).component_mul(&roots),
            hidden: DVector::zeros(roots.len()),
            factor: DMatrix::from_diagonal(&roots),
            rows,
            pull,
            basis: None,
        }
    }

    /// The kept coordinates and the hidden part of M⁻¹ times this load or impulse, of all coordinates.
    pub(crate) fn response(&self, load: &[f64]) -> (Coordinates, DVector<f64>) {
        let whole = solve_lower(&self.factor, self.free.iter().map(|&k| load[k]));
        parts(self.basis.as_ref(), &whole)
    }

    /// The same contacts under another load, of all coordinates.
    pub(crate) fn loaded(&self, load: &[f64]) -> Self {
        let (pull, hidden) = self.response(load);
        let load = DVector::from_iterator(self.free.len(), self.free.iter().map(|&k| load[k]));
        Self { b: accelerations(&self.rows, &pull), pull, hidden, load, ..self.clone() }
    }
}

/// The components of a vector along these axes.
fn along(axes: &[Coordinates], whole: &Coordinates) -> Coordinates {
    Coordinates::from_iter(axes.iter().map(|axis| axis.dot(whole)))
}

/// The parts of an acceleration, or of a jump of a velocity, that are kept and hidden.
fn parts(basis: Option<&DMatrix<f64>>, whole: &Coordinates) -> (Coordinates, DVector<f64>) {
    let none = DVector::zeros(whole.len());
    let Some(basis) = basis else { return (whole.clone(), none) };
    let axes: Vec<Coordinates> =
        basis.column_iter().map(|axis| Coordinates::from_iter(axis.iter().copied())).collect();
    let kept = along(&axes, whole);
    let mut rest = whole.clone();
    axes.iter().zip(kept.iter()).for_each(|(axis, part)| rest.add_scaled(axis, -part));
    // What is left of a load within the span is rounding error.
    let is_little = rest.norm() <= DEPENDENT_ROW * whole.norm();
    let hidden = if is_little { none } else { DVector::from_iterator(whole.len(), rest.iter()) };
    (kept, hidden)
}

/// W of rows.
fn products(rows: &[Coordinates]) -> DMatrix<f64> {
    let n = rows.len();
    let mut w = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let value = rows[i].dot(&rows[j]).unsigned_zero();
            (w[(i, j)], w[(j, i)]) = (value, value);
        }
    }
    w
}

/// The tangential and the normal row of a contact of a body in (x, y, ρθ).
pub(crate) fn rows_of(k: &ContactGeometry, rho: f64) -> [[f64; 3]; 2] {
    let row = |axis: &Vector2<f64>, turn: f64| [axis.x, axis.y, turn / rho];
    [row(&k.tangent, -k.touching_c()), row(&k.normal, k.b)]
}

/// b of rows.
fn accelerations(rows: &[Coordinates], pull: &Coordinates) -> DVector<f64> {
    DVector::from_iterator(rows.len(), rows.iter().map(|row| row.dot(pull).unsigned_zero()))
}

/// The factor L of M = L Lᵀ.
fn cholesky(mass: &DMatrix<f64>, free: &[usize]) -> Result<DMatrix<f64>, Error> {
    let f = mass.nrows();
    let mut factor: DMatrix<f64> = DMatrix::zeros(f, f);
    for j in 0..f {
        for i in j..f {
            let mut left = mass[(i, j)];
            for k in 0..j {
                left -= factor[(i, k)] * factor[(j, k)];
            }
            if i > j {
                factor[(i, j)] = left / factor[(j, j)];
            } else if left > INDEFINITE * mass[(j, j)] {
                factor[(j, j)] = left.sqrt();
            } else {
                let least = mass.clone().symmetric_eigenvalues().min();
                return Err(Error::Unusable {
                    field: "mass_matrix".into(),
                    value: format!("[matrix whose least eigenvalue is {least:?}]"),
                    allowed: format!(
                        "a positive definite matrix in the coordinates that are not locked; coordinate {} has no inertia of its own beside those before it",
                        free[j]
                    ),
                });
            }
        }
    }
    Ok(factor)
}

/// L⁻¹ of a column.
fn solve_lower(factor: &DMatrix<f64>, column: impl Iterator<Item = f64>) -> Coordinates {
    let mut solved: Vec<f64> = Vec::with_capacity(factor.nrows());
    for (i, value) in column.enumerate() {
        let mut left = value;
        for (k, known) in solved.iter().enumerate() {
            left -= factor[(i, k)] * known;
        }
        solved.push(left / factor[(i, i)]);
    }
    Coordinates::from_iter(solved)
}

/// Checks that the two rows of a contact are independent.
fn two_directions(contact: usize, pair: &[Coordinates]) -> Result<(), Error> {
    let [tangent, normal] = pair else { return Ok(()) };
    let (long, short) = (normal.norm_squared(), tangent.norm_squared());
    // The part of one across the other; 1 − cos² of the angle between them would not resolve a sine below 1e-8.
    let across = tangent.plus(normal, -normal.dot(tangent) / long);
    if across.norm() > DEPENDENT_ROW * tangent.norm() {
        return Ok(());
    }
    let (field, value) = match (long > 0.0, short > 0.0) {
        (false, _) => ("normal", "zero"),
        (_, false) => ("tangential", "zero"),
        _ => ("tangential", "a multiple of the normal row"),
    };
    Err(Error::Unusable {
        field: format!("contacts.{}.{field}", contact + 1),
        value: format!("[{value} in the coordinates that are not locked]"),
        allowed: "a normal and a tangential row that are independent, so that the contact can move in both directions".into(),
    })
}

/// Refuses a load in which gravity points upwards and lifts all contacts off. Its direction is known where the first two coordinates are the
/// place (x, y) of a floating base, and where a rigid body falls: then all contact points have accelerations of one size.
fn falls_down(mass: &DMatrix<f64>, load: &DVector<f64>, b: &DVector<f64>) -> Result<(), Error> {
    let count = b.len() / 2;
    if (0..count).any(|i| b[2 * i + 1] <= 0.0) {
        return Ok(());
    }
    let near = |x: f64, size: f64| x.abs() <= ONE_SIZE * size.abs();
    let base = load.len() > 1
        && near(mass[(0, 0)] - mass[(1, 1)], mass[(0, 0)])
        && near(mass[(0, 1)], mass[(0, 0)])
        && near(load[0], load[1])
        && load[1] != 0.0;
    let size = |i: usize| libm::hypot(b[2 * i], b[2 * i + 1]);
    let rises = if base {
        load[1] > 0.0
    } else {
        load.len() == 3 && count > 1 && (1..count).all(|i| near(size(i) - size(0), size(0)))
    };
    if !rises {
        return Ok(());
    }
    Err(Error::Unusable {
        field: "load".into(),
        value: "[a load with gravity upwards: it pulls all contacts off the ground]".into(),
        allowed: "B tau - h with gravity downwards: h is the bias of M qdd + h = B tau + J^T f, so that the load of the height of a floating base is -m g; did you mean -load?".into(),
    })
}
