//! Laws of impact.

pub(crate) mod friction;
pub(crate) mod newton;
