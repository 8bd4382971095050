//! How values are written to files and read from them (serde).

pub(crate) mod numbers;
pub(crate) mod values;
