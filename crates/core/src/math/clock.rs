//! A clock that advances even if a step is below the rounding error of the time.
//!
//! Near an accumulation of impacts the flights are far shorter than the rounding error of the time at which
//! they begin. The elapsed time is therefore kept as an unevaluated sum of two doubles.

/// Elapsed time `hi + lo`, |lo| ≤ ½ ulp(hi), in s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Clock {
    pub(crate) hi: f64,
    pub(crate) lo: f64,
}

/// The sum hi + lo + dt, with |lo| as large as the rounding errors of all steps since it was last renormalised (Knuth's two-sum).
#[inline(always)]
pub(crate) fn unnormalised_after(hi: f64, lo: f64, dt: f64) -> (f64, f64) {
    let sum = hi + dt;
    let part = sum - hi;
    let error = (hi - (sum - part)) + (dt - part);
    (sum, lo + error)
}

/// The same sum with |lo| ≤ ½ ulp(hi).
#[inline(always)]
pub(crate) fn renormalised((hi, lo): (f64, f64)) -> (f64, f64) {
    let sum = hi + lo;
    (sum, lo - (sum - hi))
}

impl Clock {
    /// The clock after a further `dt`.
    #[inline]
    pub(crate) fn after(self, dt: f64) -> Self {
        let (hi, lo) = renormalised(unnormalised_after(self.hi, self.lo, dt));
        Self { hi, lo }
    }

    #[inline]
    pub(crate) fn renormalised(self) -> Self {
        let (hi, lo) = renormalised((self.hi, self.lo));
        Self { hi, lo }
    }

    /// Time from `earlier` to here, in s.
    pub(crate) fn since(self, earlier: Self) -> f64 {
        (self.hi - earlier.hi) + (self.lo - earlier.lo)
    }

    /// The longest step that does not lead beyond `end`, in s.
    pub(crate) fn until(self, end: f64) -> f64 {
        let left = Self { hi: end, lo: 0.0 }.since(self);
        if self.after(left).hi > end { left.next_down() } else { left }
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
