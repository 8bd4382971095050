//! Sequences of collisions of two contacts without any other event, and the log of a run.

pub(crate) mod full;
pub(crate) mod local;
pub(crate) mod log;
pub(crate) mod regular;
