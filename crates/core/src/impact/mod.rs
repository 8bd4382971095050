//! Laws of impact.

pub(crate) mod friction;
pub(crate) mod newton;
mod pivoting;
pub(crate) mod together;
