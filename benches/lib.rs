//! The benchmarks are the files beside this one; see each for what its clock covers.
