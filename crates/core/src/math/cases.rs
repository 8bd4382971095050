//! Random cases of the unit tests: the same in every run.

use proptest::test_runner::{Config, RngSeed};

/// 256 cases from this seed; failures are not written to files.
pub(crate) fn fixed(seed: u64) -> Config {
    Config { failure_persistence: None, rng_seed: RngSeed::Fixed(seed), ..Config::default() }
}
