//! Compiles and runs the programs of the page "In Rust", which is not in the package of the crate.

#[cfg(doctest)]
#[doc = include_str!("../docs/rust.md")]
struct InRust;
