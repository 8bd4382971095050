//! How values are written: to files and read from them (serde), and as text.

pub(crate) mod numbers;
pub(crate) mod values;

/// Writes these types in the words of their `as_str`.
macro_rules! shown_as_str {
    ($($name:ty),+) => {$(
        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.as_str())
            }
        }
    )+};
}

/// Writes these types in the words of their files.
macro_rules! shown_as_written {
    ($($name:ty),+) => {$(
        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                serde::Serialize::serialize(self, f)
            }
        }
    )+};
}

pub(crate) use {shown_as_str, shown_as_written};
