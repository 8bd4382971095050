//! Random cases of the unit tests, the same in every run, and exact arithmetic to compare with.

use num_bigint::BigInt;
use num_rational::Ratio;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};

/// 256 cases generated from this seed. Failures are not written to files.
pub(crate) fn fixed(seed: u64) -> Config {
    Config { failure_persistence: None, rng_seed: RngSeed::Fixed(seed), ..Config::default() }
}

/// A fraction of whole numbers of any size.
pub(crate) type Fraction = Ratio<BigInt>;

/// A double as a fraction; `None` if it is not finite.
pub(crate) fn exact(x: f64) -> Option<Fraction> {
    let power = (x.to_bits() >> 52 & 0x7ff) as i32;
    let digits = (x.to_bits() & ((1 << 52) - 1)) as i64 + if power > 0 { 1 << 52 } else { 0 };
    // x = ±digits·2^(power − 1075); the digits of subnormal numbers have the power 1.
    let shift = power.max(1) - 1075;
    let digits = BigInt::from(if x < 0.0 { -digits } else { digits });
    let (up, down) = (BigInt::from(1) << shift.max(0), BigInt::from(1) << (-shift).max(0));
    x.is_finite().then(|| Fraction::new(digits * up, down))
}

/// num/den
pub(crate) fn fraction(num: i32, den: i32) -> Fraction {
    Fraction::new(BigInt::from(num), BigInt::from(den))
}

/// Doubles of either sign: ordinary ones, zeros, subnormal and huge ones, and those around one.
pub(crate) fn any_double() -> impl Strategy<Value = f64> {
    let sized = |low: f64, high: f64| {
        (low..high, any::<bool>(), 1.0..2.0).prop_map(|(power, negative, factor): (f64, _, f64)| {
            let size = factor * power.floor().exp2();
            if negative { -size } else { size }
        })
    };
    prop_oneof![
        6 => sized(-10.0, 10.0),
        2 => sized(-300.0, 300.0),
        1 => sized(-1074.0, -1000.0),
        1 => sized(1000.0, 1023.0),
        1 => prop::sample::select(vec![0.0, 1.0, -1.0, f64::MAX, f64::MIN, f64::MIN_POSITIVE, f64::from_bits(1), -f64::from_bits(1)]),
    ]
}
