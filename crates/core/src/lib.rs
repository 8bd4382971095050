//! Exact hybrid dynamics of planar rigid bodies on frictional contacts.
//!
//! A body on two contacts is dropped: it flies, bounces and clatters, infinitely often in finite time, and
//! comes to rest. This crate computes that motion event by event and sums the infinitely many impacts to
//! their limit (the *Zeno point*) in closed form, after Y. Or and E. Rimon, "On the Hybrid Dynamics of
//! Planar Mechanisms Supported by Frictional Contacts. II", ICRA 2008.
//!
//! ```
//! use standfast::{Lamina, Options, Posture, State, Stop, simulate};
//!
//! // A rod with its mass near the middle is dropped, one end lower than the other.
//! let lamina = Lamina { gyration_radius: Some(0.2), restitution: 0.1, ..Lamina::default() };
//! let rod = Posture::rod(0.5, &lamina)?;
//! let start = State::at_rest([0.0, 0.011, 0.002_f64.asin()]);
//! let run = simulate(&rod, &start, &Options { stop: Stop::Zeno, ..Options::default() })?;
//!
//! let zeno = &run.zeno_points()[0];
//! assert_eq!(zeno.kind.to_string(), "2-zeno");           // both ends come to rest at once
//! assert!((zeno.time - 0.04778480706422020).abs() < 2e-17);
//! assert!(run.impacts().len() <= 10);                    // the rest is summed
//! # Ok::<(), standfast::Error>(())
//! ```
//!
//! SI units, angles in rad counterclockwise, pairs in the order (tangential, normal).
//!
//! The names that a first program needs are at the root: the bodies, the options, one run and many, the verdict, the scene, the error.
//! Everything else is in the module of its subject:
//!
//! | module | subject |
//! | --- | --- |
//! | [`body`] | postures, contacts, terrain, states, the local model of two contacts |
//! | [`options`], [`outcome`] | what a run is asked for; what it hands back: impacts, Zeno points, phases |
//! | [`excitation`] | kicks, and the motion of the ground, during a run |
//! | [`flight`] | the gap of a contact in flight and its guaranteed earliest touchdown |
//! | [`modes`] | which contacts separate, stay fixed or slide: every consistent answer, none or several |
//! | [`simulate`](mod@simulate) | one run, many runs at once, runs of the local model |
//! | [`stability`](mod@stability) | equilibrium region, clattering convergence, reduced map, verdict |
//! | [`robustness`](mod@robustness) | the share of random kicks of a size that a posture withstands |
//! | [`sweep`] | the same questions on grids of parameters |
//! | [`ask`](mod@ask) | all of them as JSON, for pages and notebooks |
//!
//! | task | names |
//! | --- | --- |
//! | a box that is thrown on stairs | [`Posture::block`] with [`Lamina::terrain`], [`simulate`](simulate()) with [`Impact::Moreau`] |
//! | the motion at any time | [`Trajectory::at`], [`times`](Trajectory::times), [`forces`](Trajectory::forces); [`reader`](Trajectory::reader) for many times |
//! | contact modes of a posture at rest | [`ContactProblem::of_posture`](modes::ContactProblem::of_posture), [`contact_modes`](modes::contact_modes) |
//! | contact modes of a mechanism | [`MechanismProblem`](modes::MechanismProblem), [`contact_modes`](modes::contact_modes) |
//! | is the posture stable, and why | [`stability`](stability()), [`Verdict`](stability::Verdict) |
//! | kicks, or an earthquake, during a run | [`Simulation`], [`Excitation`](excitation::Excitation) |
//! | the kicks that a posture withstands | [`robustness`](robustness()) |
//! | many runs | [`simulate_many`]; [`simulate_many_until`](simulate::simulate_many_until) with a number of threads, or to stop them |
//! | one question about many bodies, on all cores | [`many`](simulate::many) |
//! | a map over parameters | [`Sweep`](sweep::Sweep) |
//! | files | [`Scene::load`], [`AnyScene::load`](mechanism_scene::AnyScene::load), [`Scene::save`], [`Trajectory::save`], [`Verdict::save`](stability::Verdict::save) |
//!
//! # Rust version, features, speed
//!
//! Rust 1.89 or newer. The feature `qp`, on by default, solves contact modes by convex programmes (Clarabel). Without it, forces that are not
//! unique (of three and more contacts) may be others, and so the motions that depend on them.
//!
//! Measure with `--release`: a build without optimisation is about fifty times slower. With these lines of your `Cargo.toml` a build for
//! development is about five times slower:
//!
//! ```toml
//! [profile.dev.package."*"]
//! opt-level = 3
//! ```

#![forbid(unsafe_code)]
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

// From the ground up: a module uses those above it, never those below. The private ones hold the laws: `impact` (Newton, Poisson, Stronge,
// Moreau and others), `zeno` (sums of bounces and of clattering), `sustained` (contacts at rest or sliding: the choice of a mode, and the
// motion until it ends), `motion` (the loop over events), `verified` (the local model in intervals),
// `enclosure` (proved bounds). `docs/architecture.md` lists them with their files.
mod tolerance;
mod math;
mod serial;
pub mod error;
mod file;
pub mod body;
pub mod options;
pub mod excitation;
pub mod outcome;
pub mod flight;
mod zeno;
mod impact;
pub mod modes;
mod collisions;
mod sustained;
mod motion;
mod verified;
mod enclosure;
pub mod simulate;
pub mod stability;
pub mod assembly;
pub mod robustness;
pub mod push;
pub mod sweep;
mod scene;
pub mod mechanism_scene;
pub mod ask;

pub use ask::ask;
pub use body::{Contact, Lamina, Posture, PostureFields, State};
pub use error::Error;
#[doc(hidden)]
pub use file::write::write_whole;
/// The crate of the vectors in this interface, in the version that it uses.
pub use nalgebra;
pub use options::{Impact, Model, Options, Stop};
pub use outcome::Outcome;
pub use push::smallest_push;
pub use robustness::robustness;
pub use scene::Scene;
pub use simulate::{Simulation, Trajectory, simulate, simulate_many};
pub use stability::stability;

/// A column of three: configurations (m, m, rad) and velocities.
pub type Vector3 = nalgebra::Vector3<f64>;

/// The example of the page of the package.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
