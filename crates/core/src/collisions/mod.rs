//! Collisions of two contacts one after the other, as long as nothing else happens, and the log of a run.

pub(crate) mod full;
pub(crate) mod local;
pub(crate) mod log;
