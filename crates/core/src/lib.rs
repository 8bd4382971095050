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

// In the order in which a motion meets them.
mod auto;
mod batch;
mod clatter;
mod clock;
mod contact;
mod contact_motion;
mod contact_phase;
mod enclosure;
mod error;
mod files;
mod flight;
mod frame;
mod general;
mod hybrid;
mod impact;
mod impact_law;
mod lanes;
mod local;
mod log;
mod modes;
mod own_ground;
mod parallel;
mod posture;
mod roots;
mod rounds;
mod scene;
mod simulate;
mod stability;
mod sweep;
mod terrain;
mod text;
mod tolerance;
mod trajectory;
mod trig;
mod tumble;
mod zeno;
mod zero;

pub use batch::{End, FirstZeno, Resources, simulate_many, simulate_many_until};
pub use contact::Contact;
pub use enclosure::{Bounds, EnclosedImpact, EnclosedZeno, Enclosure, Uncertain};
pub use error::{Error, IoCause};
#[doc(hidden)]
pub use files::write_whole;
pub use flight::Arc;
pub use impact::Simultaneous;
pub use local::LocalModel;
pub use modes::{
    Condition, ContactProblem, FEW, Forces, Jamming, Level, Margin, Method, Mode, ModeAnswer,
    Modes, PairMode, PairModes, ProblemFields, Status, TIE, Word, contact_modes,
};
pub use posture::{Fields, MAX_CONTACTS, Posture};
pub use scene::Scene;
pub use simulate::{Impact, Model, Options, State, Stop, simulate, simulate_until};
/// A column of three: configurations (m, m, rad) and velocities.
pub type Vector3 = nalgebra::Vector3<f64>;
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
pub use terrain::MAX_VERTICES;
pub use tolerance::TOUCH;
pub use trajectory::{
    Cause, ContactNumber, ImpactRecord, Instant, Outcome, Phase, Trajectory, ZenoPoint,
};
