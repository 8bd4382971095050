//! The benchmarks are the files in this folder; each states what it measures.

pub mod harness;

use standfast::body::{LocalModel, LocalModelFields};
use standfast::{Lamina, Posture, State};

/// The self-similar orbit below the bound of clattering convergence, with factor `c` per impact: contacts alternate,
/// gravity does not become negligible, and no sum applies until the precision is exhausted.
#[must_use]
pub fn self_similar(e: f64, c: f64) -> (LocalModel, [f64; 2], [f64; 2]) {
    // c³ + Kc² + (1 − K − e)c − e = 0, K = 1 + (1+e)ψ; start at u_a = 1, g = 1.
    let k = (e - c * c * c - c + e * c) / (c * c - c);
    let psi = (k - 1.0) / (1.0 + e);
    let u_b = (2.0 - (c + c * c * c) / e) / (1.0 - c * c);
    let h_b = 0.5 * ((c / e).powi(2) - u_b * u_b);
    let model = LocalModel::new(LocalModelFields {
        gravity: [1.0; 2],
        psi: [psi; 2],
        restitution: [e; 2],
        ..LocalModelFields::default()
    });
    (model.unwrap_or_else(|e| panic!("{e}")), [0.0, h_b], [1.0, u_b])
}

/// Different rods that are dropped nearly level, and their starts.
///
/// # Panics
///
/// If a rod is refused.
#[must_use]
pub fn rods(count: u32) -> (Vec<Posture>, Vec<State>) {
    let share = |k: u32| f64::from(k) / f64::from(count);
    let rod = |k: u32| {
        let (radius, restitution) = (0.15 + 0.1 * share(k), 0.05 + 0.1 * share(k * 7919 % count));
        let lamina = Lamina { gyration_radius: Some(radius), restitution, ..Lamina::default() };
        Posture::rod(0.5, &lamina).unwrap_or_else(|e| panic!("{e}"))
    };
    let tilt = |k: u32| 0.002 * (0.2 + 0.8 * share(k * 3137 % count));
    let start = |k: u32| State::at_rest([0.0, 0.011, tilt(k)]);
    ((0..count).map(rod).collect(), (0..count).map(start).collect())
}
