//! Tolerances that several modules use, each with its reason; one that only one module uses stands in that module. All are relative,
//! except [`BEYOND`], which is a length.

/// Penetration of a start that counts as touching, relative to the size of the body.
///
/// Positions given in doubles carry rounding of order 1e-16 times their size; a start this close to the
/// terrain means to stand on it. A larger value would hide a wrong start, a smaller one refuse a right one.
pub const TOUCH: f64 = 1e-12;

/// Error of a summed tail, relative to the time elapsed, below which the sum is taken.
///
/// A fortieth of the rounding of the time itself. The estimate of a clattering tail can be 9 times low: with
/// this threshold the truncation stays below half an ulp all the same.
pub(crate) const TAIL: f64 = 5e-18;

/// Remaining time of an accumulation without a closed form, relative to the time elapsed, at which it
/// counts as reached.
pub(crate) const REACHED: f64 = 1e-17;

/// Change of the scale-reduced state over one period that still counts as a repetition.
pub(crate) const SELF_SIMILAR: f64 = 1e-6;

/// A clattering tail is tried once ε²τ is below this times the time elapsed, with τ the last flight and
/// ε = 2gh/(u² + 2gh) the share of gravity in the next.
///
/// The error of the sum grows like ε²τ; the factor above [`TAIL`] covers its constant, so that the filter
/// costs collisions nothing and is passed only a few of them too early.
pub(crate) const TRY_TAIL: f64 = 1e2 * TAIL;

/// Sliding speed at the end of an accumulation that counts as zero where friction can hold it, relative to the largest
/// speed there was; and tangential acceleration that counts as zero, relative to gravity. Sums of rounded impulses leave
/// residues of order 1e-15; a larger value would end nested accumulations too early, by as much of their time.
pub(crate) const STILL: f64 = 3e-14;

/// Difference of two touchdown times, relative to them, below which two contacts land together: each has a few roundings, of
/// its gap, its gravity and their square root.
pub(crate) const SIMULTANEOUS: f64 = 8.0 * f64::EPSILON;

/// Height over a line of ground, relative to the size of the body and the way it has come, that is none where the lines of several
/// contacts are compared: people write coordinates and slopes with three digits or more.
pub(crate) const SAME_GROUND: f64 = 1e-3;

/// Distance, in m, from which on a body has left for ever: its square is soon beyond all doubles.
pub(crate) const BEYOND: f64 = 1e140;
