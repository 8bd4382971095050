//! Exact hybrid dynamics of planar rigid bodies on frictional contacts.
//!
//! A body on two contacts is dropped: it flies, bounces and clatters, infinitely often in finite time, and
//! comes to rest. This crate computes that motion event by event and sums the infinitely many impacts to
//! their limit (the *Zeno point*) in closed form, after Y. Or and E. Rimon, "On the Hybrid Dynamics of
//! Planar Mechanisms Supported by Frictional Contacts. II", ICRA 2008.
//!
//! ```
//! use standfast::{Options, Posture, State, Stop, simulate};
//!
//! // A rod with its mass near the middle is dropped, one end lower than the other.
//! let rod = Posture::rod(0.5, 0.2, 0.1, 0.0, 9.81)?;
//! let start = State::at_rest([0.0, 0.011, 0.002_f64.asin()]);
//! let run = simulate(&rod, &start, &Options { stop: Stop::Zeno, ..Options::default() })?;
//!
//! let zeno = &run.zeno_points()[0];
//! assert_eq!(zeno.kind, "2-zeno");                       // both ends come to rest at once
//! assert!((zeno.time - 0.04778480706422020).abs() < 2e-17);
//! assert!(run.impacts().len() <= 10);                    // the rest is summed
//! # Ok::<(), standfast::Error>(())
//! ```
//!
//! SI units, angles in rad counterclockwise, pairs in the order (tangential, normal).

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

// From the ground up: a module uses those above it, never those below.
mod math;
mod serial;
mod tolerance;
mod error;
mod file;
mod body;
mod options;
mod outcome;
mod flight;
mod zeno;
mod impact;
mod modes;
mod collisions;
mod sustained;
mod motion;
mod auto;
mod enclosure;
mod simulate;
mod stability;
mod sweep;
mod scene;

pub use body::contact::Contact;
pub use body::local_model::LocalModel;
pub use body::posture::{Fields, MAX_CONTACTS, Posture};
pub use body::state::State;
pub use error::{Error, IoCause};
#[doc(hidden)]
pub use file::write::write_whole;
pub use flight::GapArc;
pub use modes::{
    Condition, ContactProblem, FEW, Forces, Jamming, Level, Margin, Method, Mode, ModeAnswer,
    Modes, PairMode, PairModes, ProblemFields, Status, TIE, Word, contact_modes,
};
pub use options::{Impact, Model, Options, Simultaneous, Stop};
pub use outcome::{
    Bounds, Cause, ContactNumber, EnclosedImpact, EnclosedZeno, Enclosure, End, FirstZeno,
    ImpactRecord, Instant, Outcome, Phase, Uncertain, ZenoPoint,
};
pub use scene::Scene;
pub use simulate::batch::{Resources, simulate_many, simulate_many_until};
pub use simulate::{simulate, simulate_local, simulate_local_until, simulate_until};
/// A column of three: configurations (m, m, rad) and velocities.
pub type Vector3 = nalgebra::Vector3<f64>;
pub use body::terrain::MAX_VERTICES;
pub use simulate::trajectory::Trajectory;
pub use stability::{
    BATCHES, By, Conditions, CornerStep, Evidence, Exponents, Fate, FateKind, NoBound, Orbit,
    OrbitEnd, Potential, Reason, ReducedMap, ReducedStep, SelfSimilar, Shape, Stability,
    StaticForces, Trials, Verdict, chatter_bound, chatter_restitution, clattering_bound,
    clattering_restitution, conditions, coupling, equilibrium_region, friction_margin,
    neimark_sacker, self_similar, stability, static_forces, trials,
};
pub use sweep::{
    Axis, Column, Kind, MOST_POINTS, OfConditions, OfVerdict, Quantity, Sweep, grid_size,
};
pub use tolerance::TOUCH;
