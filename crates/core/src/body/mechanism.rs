//! A mechanism in a posture, given by its mass matrix, its load and the Jacobian rows of its contacts.
//!
//! With generalised coordinates q, measured from the posture, in which all contacts touch, the equation of motion to first order is
//!
//! ```text
//! M q̈ = load + Σ_i (T_iᵀ f_t,i + N_iᵀ f_n,i),     h_i = N_i q,  v_t,i = T_i q̇,     load = Bτ − h(q₀, 0)
//! ```
//!
//! with constant torques τ. A rigid body is the mechanism with q = (x, y, θ), M = diag(m, m, mρ²) and load = (0, −mg, 0).
//!
//! *Locked* coordinates do not move. *Armature* (the inertia of a rotor, reflected through its gear) is added to the diagonal of M. The
//! matrices W of [`ContactSpace`] are ordered: W with a joint locked ⪯ W with armature ⪯ W with the torque alone.

use std::sync::Arc;

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

use crate::body::contact_space::ContactSpace;
use crate::body::fields::{ContactRows, MechanismFields};
use crate::body::local_model::{LocalModel, LocalModelFields};
use crate::body::posture::{MAX_CONTACTS, Posture};
use crate::error::{Error, finite, friction, in_range, restitution};
use crate::math::mass_vector::Coordinates;
use crate::math::unsigned_zero::UnsignedZero;
use crate::tolerance::ASYMMETRY;

/// The largest number of coordinates of a mechanism.
pub const MAX_DOF: usize = 100;

/// A mechanism with frictional contacts, in a posture. Every field is validated once.
///
/// ```
/// use standfast::body::{ContactRows, Mechanism, MechanismFields};
///
/// // A rod of 2 kg on its two ends, 1 m apart, with ρ = 0.3 m: q = (x, y, θ).
/// let end = |b: f64| ContactRows { normal: vec![0.0, 1.0, b], tangential: vec![1.0, 0.0, 0.0], friction: 0.5, ..ContactRows::default() };
/// let (m, inertia) = (2.0, 2.0 * 0.3 * 0.3);
/// let rod = Mechanism::new(MechanismFields {
///     mass_matrix: vec![vec![m, 0.0, 0.0], vec![0.0, m, 0.0], vec![0.0, 0.0, inertia]],
///     load: vec![0.0, -9.81 * m, 0.0],
///     contacts: vec![end(-0.5), end(0.5)],
///     ..MechanismFields::default()
/// })?;
/// let [psi, _] = rod.local()?.psi(); // (L² − ρ²)/(L² + ρ²)
/// assert!((psi - 0.16 / 0.34).abs() < 1e-15);
/// assert_eq!(rod.contact_space().rank(), 3);
/// # Ok::<(), standfast::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "MechanismFields", into = "MechanismFields")]
pub struct Mechanism(Arc<Parts>);

/// The data of a mechanism. All copies share them, because every run keeps a copy.
#[derive(Debug, Clone, PartialEq)]
struct Parts {
    fields: MechanismFields,
    space: Arc<ContactSpace>,
}

impl TryFrom<MechanismFields> for Mechanism {
    type Error = Error;

    fn try_from(fields: MechanismFields) -> Result<Self, Error> {
        Self::new(fields)
    }
}

impl From<Mechanism> for MechanismFields {
    fn from(mechanism: Mechanism) -> Self {
        Arc::unwrap_or_clone(mechanism.0).fields
    }
}

impl Mechanism {
    /// Validates `fields`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] or [`Error::Unusable`], naming the field, its value and what is allowed: a matrix that is not square, not
    /// symmetric or not positive definite; lists of other lengths than the load; contacts whose normal and tangential row depend on each
    /// other; a load with gravity that points upwards.
    pub fn new(fields: MechanismFields) -> Result<Self, Error> {
        let fields = checked(fields)?;
        let space = ContactSpace::of(&fields)?;
        Ok(Self(Arc::new(Parts { fields, space: Arc::new(space) })))
    }

    /// A rigid body in its nominal posture as a mechanism with q = (x, y, θ): its contacts that touch.
    ///
    /// ```
    /// use standfast::body::Mechanism;
    /// use standfast::{Lamina, Posture};
    ///
    /// let rod = Posture::rod(0.5, &Lamina { friction: 0.5, ..Lamina::default() })?;
    /// let [psi, _] = Mechanism::of_posture(&rod)?.local()?.psi();
    /// assert!((psi - rod.psi()?[0]).abs() < 1e-15);
    /// # Ok::<(), standfast::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Mechanism::new`]; no contact touches; a surface moves.
    pub fn of_posture(posture: &Posture) -> Result<Self, Error> {
        let posture = &posture.at_its_place()?;
        let f = posture.fields();
        let m = f.mass;
        let touching =
            posture.geometry().iter().zip(posture.contacts()).filter(|(k, _)| k.offset == 0.0);
        let contacts = touching.map(|(k, contact)| ContactRows {
            normal: vec![k.normal.x, k.normal.y, k.b],
            tangential: vec![k.tangent.x, k.tangent.y, -k.touching_c()],
            friction: contact.friction,
            restitution: contact.restitution,
            tangential_restitution: contact.tangential_restitution,
        });
        Self::new(MechanismFields {
            mass_matrix: vec![
                vec![m, 0.0, 0.0],
                vec![0.0, m, 0.0],
                vec![0.0, 0.0, m * posture.gyration_squared()],
            ],
            load: vec![0.0, -m * f.gravity, 0.0],
            contacts: contacts.collect(),
            restitution: f.restitution,
            ..MechanismFields::default()
        })
    }

    /// The validated fields.
    #[must_use]
    pub fn fields(&self) -> &MechanismFields {
        &self.0.fields
    }

    /// Number of coordinates, with those that are locked.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.0.fields.load.len()
    }

    /// The contacts, in order.
    #[must_use]
    pub fn contacts(&self) -> &[ContactRows] {
        &self.0.fields.contacts
    }

    /// Coefficient of restitution of a contact, counted from 0.
    pub(crate) fn restitution(&self, contact: usize) -> f64 {
        self.contacts()[contact].restitution.unwrap_or(self.0.fields.restitution)
    }

    /// The dynamics of the contacts: W and b with (ḧ, v̇_t) = b + W f.
    #[must_use]
    pub fn contact_space(&self) -> &ContactSpace {
        &self.0.space
    }

    /// The same mechanism in this space: under its load.
    pub(crate) fn in_space(&self, space: &Arc<ContactSpace>) -> Self {
        if Arc::ptr_eq(&self.0.space, space) {
            return self.clone();
        }
        let mut fields = self.0.fields.clone();
        space.free().iter().zip(space.load().iter()).for_each(|(&k, load)| fields.load[k] = *load);
        Self(Arc::new(Parts { fields, space: Arc::clone(space) }))
    }

    pub(crate) fn shared_space(&self) -> Arc<ContactSpace> {
        Arc::clone(&self.0.space)
    }

    /// The frictionless local model of the gaps of two contacts: ψ_i = −W_12/W_ii and g_i = −b_i of the normal rows. A mechanism has no
    /// single rotation: φ = 0.
    ///
    /// # Errors
    ///
    /// [`Error::Unusable`] naming `contacts` unless there are two.
    pub fn local(&self) -> Result<LocalModel, Error> {
        let count = self.contacts().len();
        if count != 2 {
            return Err(Error::Unusable {
                field: "contacts".into(),
                value: format!("[{count} contacts]"),
                allowed: "exactly 2 contacts for this question".into(),
            });
        }
        let space = self.contact_space();
        let psi = [0, 1].map(|i| -space.normal(0, 1) / space.normal(i, i));
        LocalModel::new(LocalModelFields {
            gravity: [0, 1].map(|i| space.gravity(i)).unsigned_zero(),
            psi: psi.unsigned_zero(),
            phi: [0.0; 2],
            restitution: [0, 1].map(|i| self.restitution(i)),
        })
    }

    /// All coordinates, in m or rad, or their rates, from those of the contact space; locked ones are zero. Without the hidden part.
    pub(crate) fn coordinates(&self, y: &Coordinates) -> Vec<f64> {
        let space = self.contact_space();
        let mut all = vec![0.0; self.dof()];
        let none = DVector::zeros(space.free().len());
        for (&k, value) in space.free().iter().zip(space.whole(y, &none).iter()) {
            all[k] = value.unsigned_zero();
        }
        all
    }

    /// Energy ½ q̇ᵀ(M + armature)q̇ − loadᵀ q, in J, for small displacements q from the posture. The load is constant; locked coordinates
    /// have no part in it.
    ///
    /// # Panics
    ///
    /// If `q` or `qdot` has another length than the load.
    #[must_use]
    pub fn energy(&self, q: &[f64], qdot: &[f64]) -> f64 {
        let space = self.contact_space();
        let (m, load) = (space.mass(), space.load());
        let part = |of: &[f64]| {
            DVector::from_iterator(space.free().len(), space.free().iter().map(|&k| of[k]))
        };
        assert!(q.len() == self.dof() && qdot.len() == self.dof(), "a value for each coordinate");
        let (q, qdot) = (part(q), part(qdot));
        (0.5 * qdot.dot(&(m * &qdot)) - load.dot(&q)).unsigned_zero()
    }
}

/// Checks everything that needs no arithmetic with matrices.
fn checked(mut fields: MechanismFields) -> Result<MechanismFields, Error> {
    let unusable = |field: String, value: String, allowed: String| {
        Err(Error::Unusable { field, value, allowed })
    };
    let dof = fields.load.len();
    if !(1..=MAX_DOF).contains(&dof) {
        return unusable(
            "load".into(),
            format!("[{dof} coordinates]"),
            format!("1 to {MAX_DOF} coordinates"),
        );
    }
    let rows = fields.mass_matrix.len();
    let widths = || fields.mass_matrix.iter().map(Vec::len);
    if let Some(width) = widths().find(|&width| width != dof).or((rows != dof).then_some(dof)) {
        return unusable(
            "mass_matrix".into(),
            format!("[shape ({rows}, {width})]"),
            format!("the shape ({dof}, {dof}), because the load has {dof} coordinates"),
        );
    }
    for (name, values) in [("load", &fields.load), ("armature", &fields.armature)] {
        for (k, value) in values.iter().enumerate() {
            finite(format_args!("{name}.{k}"), *value)?;
        }
    }
    if !fields.armature.is_empty() && fields.armature.len() != dof {
        return unusable(
            "armature".into(),
            format!("[{} entries]", fields.armature.len()),
            format!("one entry for each of the {dof} coordinates, or none at all"),
        );
    }
    for (k, value) in fields.armature.iter().enumerate() {
        in_range(format_args!("armature.{k}"), *value, *value >= 0.0, ">= 0, in kg m^2 or kg")?;
    }
    for i in 0..dof {
        for j in 0..dof {
            finite(format_args!("mass_matrix.{i}.{j}"), fields.mass_matrix[i][j])?;
        }
    }
    for i in 0..dof {
        for j in 0..i {
            let (one, other) = (fields.mass_matrix[i][j], fields.mass_matrix[j][i]);
            let size = fields.mass_matrix[i][i].abs().max(fields.mass_matrix[j][j].abs());
            if (one - other).abs() > ASYMMETRY * size.max(one.abs()) {
                return unusable(
                    format!("mass_matrix.{i}.{j}"),
                    format!("{one:?}"),
                    format!(
                        "{other:?}, its mirror image: a symmetric matrix is needed; if only one triangle is filled, add the other one"
                    ),
                );
            }
        }
    }
    for (k, &locked) in fields.locked.iter().enumerate() {
        if locked >= dof || fields.locked[..k].contains(&locked) {
            return unusable(
                "locked".into(),
                format!("{:?}", fields.locked),
                format!("different coordinates from 0 to {}", dof - 1),
            );
        }
    }
    if fields.locked.len() == dof {
        return unusable(
            "locked".into(),
            format!("{:?}", fields.locked),
            "at least one coordinate that is not locked".into(),
        );
    }
    restitution("restitution", fields.restitution)?;
    let count = fields.contacts.len();
    if count == 0 || count > MAX_CONTACTS {
        return unusable(
            "contacts".into(),
            format!("[{count} contacts]"),
            format!("1 to {MAX_CONTACTS} contacts"),
        );
    }
    for (i, contact) in fields.contacts.iter().enumerate() {
        check_contact(i, contact, dof)?;
    }
    let named = [
        ("coordinate_names", &fields.coordinate_names, dof, "coordinates"),
        ("contact_names", &fields.contact_names, count, "contacts"),
    ];
    for (name, names, needed, what) in named {
        if !names.is_empty() && names.len() != needed {
            return unusable(
                name.into(),
                format!("[{} names]", names.len()),
                format!("one name for each of the {needed} {what}, or none at all"),
            );
        }
    }
    for value in fields.mass_matrix.iter_mut().flatten() {
        *value = value.unsigned_zero();
    }
    fields.load = fields.load.unsigned_zero();
    for contact in &mut fields.contacts {
        contact.normal = std::mem::take(&mut contact.normal).unsigned_zero();
        contact.tangential = std::mem::take(&mut contact.tangential).unsigned_zero();
    }
    Ok(fields)
}

/// Checks the rows and the coefficients of contact `i` (from 0) of a mechanism with `dof` coordinates.
fn check_contact(i: usize, contact: &ContactRows, dof: usize) -> Result<(), Error> {
    let at = format!("contacts.{}", i + 1);
    for (name, row) in [("normal", &contact.normal), ("tangential", &contact.tangential)] {
        if row.len() != dof {
            return Err(Error::Unusable {
                field: format!("{at}.{name}"),
                value: format!("[{} entries]", row.len()),
                allowed: format!("one entry for each of the {dof} coordinates"),
            });
        }
        for (k, value) in row.iter().enumerate() {
            finite(format_args!("{at}.{name}.{k}"), *value)?;
        }
    }
    friction(format_args!("{at}.friction"), contact.friction)?;
    in_range(
        format_args!("{at}.friction"),
        contact.friction,
        contact.friction <= ROUGHEST_CONTACT,
        "at most 1e6 for motion",
    )?;
    if let Some(value) = contact.restitution {
        restitution(format_args!("{at}.restitution"), value)?;
    }
    in_range(
        format_args!("{at}.tangential_restitution"),
        contact.tangential_restitution,
        (0.0..1.0).contains(&contact.tangential_restitution),
        "0 <= tangential_restitution < 1",
    )?;
    Ok(())
}

/// Coefficient of friction up to which forces that count as ties (1e-10 of the load) have friction of at most 1e-4 of it. Beyond, a
/// mode with a normal force just below zero would be driven by its friction.
pub(crate) const ROUGHEST_CONTACT: f64 = 1e6;
