//! Assemblies: bodies that stand on each other and on the ground.
//!
//! A [`System`] is a [`Mechanism`](crate::body::Mechanism) with names, made of bodies in their places: its contacts are found where their outlines touch. Each
//! body has the coordinates (x, y, θ) of its centre of mass, measured from the posture.

mod excitation;
mod least;
mod load;
mod onset;
mod rigid;
mod run;
mod scaled;
mod system;
pub(crate) mod table;
mod touching;

pub use excitation::SystemExcitation;
pub use load::LoadFactor;
pub use onset::SystemMode;
pub use rigid::Rigid;
pub use system::{Ground, Load, System, SystemContact, SystemFields, body_called};
