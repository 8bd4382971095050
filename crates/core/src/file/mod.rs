//! Files: TOML and JSON texts with the line and column of an error, and writing that leaves a whole file or none.

pub(crate) mod text;
pub(crate) mod write;
