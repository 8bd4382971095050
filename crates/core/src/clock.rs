//! A clock that does not stall.
//!
//! Near an accumulation of impacts the flights are far shorter than the rounding of the time at which
//! they begin. The elapsed time is therefore kept as an unevaluated sum of two doubles.

/// Elapsed time `hi + lo`, |lo| ≤ ½ ulp(hi), in s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Clock {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

impl Clock {
    /// The clock after a further `dt`.
    #[inline]
    pub(crate) fn after(self, dt: f64) -> Self {
        self.unnormalised_after(dt).renormalised()
    }

    /// The same, with |lo| as large as the roundings of all steps since the last renormalisation (Knuth's
    /// two-sum).
    #[inline]
    pub(crate) fn unnormalised_after(self, dt: f64) -> Self {
        let hi = self.hi + dt;
        let part = hi - self.hi;
        let error = (self.hi - (hi - part)) + (dt - part);
        Self { hi, lo: self.lo + error }
    }

    #[inline]
    pub(crate) fn renormalised(self) -> Self {
        let hi = self.hi + self.lo;
        Self { hi, lo: self.lo - (hi - self.hi) }
    }

    /// Time from `earlier` to here, in s.
    pub(crate) fn since(self, earlier: Self) -> f64 {
        (self.hi - earlier.hi) + (self.lo - earlier.lo)
    }

    /// `t0` + elapsed, rounded once.
    pub(crate) fn added_to(self, t0: f64) -> f64 {
        let whole = Self { hi: t0, lo: 0.0 }.after(self.hi).after(self.lo);
        whole.hi + whole.lo
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_below_rounding_are_not_lost() {
        let mut clock = Clock::default().after(1.0);
        for _ in 0..1 << 20 {
            clock = clock.after(2f64.powi(-70));
        }
        assert_eq!(clock.since(Clock { hi: 1.0, lo: 0.0 }), 2f64.powi(-50));
        assert_eq!(clock.added_to(-1.0), 2f64.powi(-50));
    }
}
