//! Files: TOML and JSON texts with the line and column of an error, and reading and writing of whole files.

pub(crate) mod read;
pub(crate) mod text;
pub(crate) mod write;
