//! Random numbers from a counter: the same sequence on every machine.
//!
//! ```text
//! s ← s + γ,   z = (s ⊕ s≫30) m₁,   z ← (z ⊕ z≫27) m₂,   bits = z ⊕ z≫31     (mod 2⁶⁴)
//! ```
//!
//! with γ = 9e3779b97f4a7c15, m₁ = bf58476d1ce4e5b9, m₂ = 94d049bb133111eb (hexadecimal) [Steele, Lea & Flood 2014, SplitMix64].

/// The state s of the generator; its first value is the seed.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// 64 random bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1): a multiple of 2⁻⁵³.
    pub(crate) fn next(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers of the reference implementation for the seed 1234567 (Vigna 2015, splitmix64.c).
    #[test]
    fn the_sequence_is_that_of_the_reference() {
        let mut random = Random(1_234_567);
        for bits in
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        {
            assert_eq!(random.bits(), bits);
        }
        assert!((-1.0..1.0).contains(&random.between(-1.0, 1.0)));
    }
}
