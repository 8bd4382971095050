//! The caps, in instructions on x86-64.

/// Collisions of the runs that are counted: so many that the call around them is nothing.
pub(crate) const LOCAL_COLLISIONS: usize = 100_000;
pub(crate) const FULL_COLLISIONS: usize = 500;
/// Rods that are dropped in one call.
pub(crate) const RODS: u32 = 1000;

/// A collision of the local model: 60.
pub(crate) const LOCAL: u64 = 60 * LOCAL_COLLISIONS as u64;
/// The same, recorded: 108.
pub(crate) const LOCAL_RECORDED: u64 = 108 * LOCAL_COLLISIONS as u64;
/// A collision of the full model where its arcs are concave: 473.
pub(crate) const FULL: u64 = 473 * FULL_COLLISIONS as u64;
/// All contact modes of two contacts at rest: 2085.
pub(crate) const PAIR_MODES: u64 = 2085;
/// A drop of one of many rods, up to rest, in the local model: of one rod 3900, of different ones 7950.
pub(crate) const ONE_ROD_LOCAL: u64 = 3_900 * RODS as u64;
pub(crate) const RODS_LOCAL: u64 = 7_950 * RODS as u64;
/// In the full model: 6650 and 13 500.
pub(crate) const ONE_ROD_FULL: u64 = 6_650 * RODS as u64;
pub(crate) const RODS_FULL: u64 = 13_500 * RODS as u64;
