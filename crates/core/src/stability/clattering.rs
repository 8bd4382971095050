//! Bounds on the coupling of two contacts: whether impacts alternate for ever, and whether gravity then becomes negligible.
//!
//! With ψ = sign(ψ_1)√(ψ_1ψ_2) and p_i = (1+e_i)ψ_i, two alternate impacts without gravity are a linear map of the speeds with
//! determinant e_1e_2 and trace p_1p_2 − e_1 − e_2. Its eigenvalues are real, and impacts endless, iff
//!
//! ```text
//! ψ ≥ (√e_1 + √e_2)/√((1+e_1)(1+e_2))                                                    Goyal's bound
//! ψ > √((e_1 + e_2 + (e_1e_2)^⅓ + (e_1e_2)^⅔)/((1+e_1)(1+e_2)))    ⟺  Λ₊³ > e_1e_2      [Or & Rimon 2008, (10)]
//! ```
//!
//! (for e_1 = e_2 = e: 2√e/(1+e) and (e^⅓ + e^⅔)/(1+e)).

use serde::Serialize;

/// Reduced coupling ψ of (ψ_1, ψ_2), with their sign.
///
/// ```
/// assert_eq!(standfast::stability::coupling([0.25, 1.0]), 0.5);
/// ```
#[must_use]
pub fn coupling(psi: [f64; 2]) -> f64 {
    (psi[0] * psi[1]).max(0.0).sqrt().copysign(psi[0])
}

/// The least coupling for which impacts without gravity alternate for ever (Goyal's bound).
///
/// ```
/// // 2√e/(1 + e) for equal restitutions
/// assert_eq!(standfast::stability::chatter_bound([0.25, 0.25]), 0.8);
/// ```
#[must_use]
pub fn chatter_bound([e1, e2]: [f64; 2]) -> f64 {
    (e1.sqrt() + e2.sqrt()) / ((1.0 + e1) * (1.0 + e2)).sqrt()
}

/// The coupling above which, in addition, gravity becomes negligible: clattering convergence [Or & Rimon 2008, (10)].
///
/// ```
/// // (e^⅓ + e^⅔)/(1 + e) for equal restitutions
/// let bound = standfast::stability::clattering_bound([0.125, 0.125]);
/// assert!((bound - 2.0 / 3.0).abs() < 1e-15);
/// ```
#[must_use]
pub fn clattering_bound([e1, e2]: [f64; 2]) -> f64 {
    let third = libm::cbrt(e1) * libm::cbrt(e2);
    ((e1 + e2 + third + third * third) / ((1.0 + e1) * (1.0 + e2))).sqrt()
}

/// The restitution e up to which impacts alternate for ever at coupling `psi`: √e = ψ/(1 + √(1 − ψ²)); zero for ψ ≤ 0.
///
/// ```
/// assert!((standfast::stability::chatter_restitution(0.8) - 0.25).abs() < 1e-15);
/// ```
#[must_use]
pub fn chatter_restitution(psi: f64) -> f64 {
    let psi = psi.clamp(0.0, 1.0);
    let root = psi / (1.0 + ((1.0 - psi) * (1.0 + psi)).sqrt());
    root * root
}

/// The restitution e below which clattering converges at coupling `psi`; zero for ψ ≤ 0. With x = e^⅓ the bound (10) is (x + 1)(ψx² −
/// (1+ψ)x + ψ) = 0, hence x = 2ψ/(1 + ψ + √((1−ψ)(1+3ψ))).
///
/// ```
/// assert!((standfast::stability::clattering_restitution(2.0 / 3.0) - 0.125).abs() < 1e-15);
/// ```
#[must_use]
pub fn clattering_restitution(psi: f64) -> f64 {
    let psi = psi.clamp(0.0, 1.0);
    let x = 2.0 * psi / (1.0 + psi + ((1.0 - psi) * (1.0 + 3.0 * psi)).sqrt());
    x * x * x
}

/// The self-similar orbit of clattering below the bound, for e_1 = e_2 and equal reduced gravities. From each impact to the next one the
/// contacts exchange their roles, all speeds are multiplied by `factor`, and all gaps by its square.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SelfSimilar {
    /// c, the root of c³ + Kc² + (1 − K − e)c − e = 0 in (e, e^⅓), K = 1 + (1+e)ψ.
    pub factor: f64,
    /// Whether nearby orbits converge to it: c > e^⅖ (a Neimark–Sacker bifurcation at equality).
    pub stable: bool,
    /// Gap rate and gap of the other contact right after an impact with take-off speed 1, at gravity 1.
    pub rate: f64,
    /// See `rate`.
    pub gap: f64,
}

/// The self-similar orbit at restitution `e` and coupling `psi`. There is none, and the result is `None`, at or above the bound of
/// clattering convergence.
///
/// ```
/// use standfast::stability::self_similar;
///
/// let orbit = self_similar(0.5, 0.9).expect("below the bound");
/// let (c, k) = (orbit.factor, 1.0 + 1.5 * 0.9);
/// assert!((((c + k) * c + 0.5 - k) * c - 0.5).abs() < 1e-15); // c³ + Kc² + (1 − K − e)c = e
/// ```
#[must_use]
pub fn self_similar(e: f64, psi: f64) -> Option<SelfSimilar> {
    if !(e > 0.0 && e < 1.0) || psi >= clattering_bound([e, e]) || psi <= -1.0 {
        return None;
    }
    let k = 1.0 + (1.0 + e) * psi;
    let f = |c: f64| {
        let value = ((c + k) * c + (1.0 - k - e)) * c - e;
        // The sign is reversed because the bracketed solver requires f(a) > 0 ≥ f(b).
        (-value, -((3.0 * c + 2.0 * k) * c + (1.0 - k - e)))
    };
    let (low, high) = (e, libm::cbrt(e));
    if !(f(low).0 > 0.0 && f(high).0 <= 0.0) {
        return None;
    }
    let c = crate::math::roots::bracketed(low, high, f);
    let rate = (2.0 - (c + c * c * c) / e) / (1.0 - c * c);
    let tau = rate + c / e;
    (tau > 0.0).then(|| SelfSimilar {
        factor: c,
        stable: c > libm::pow(e, 0.4),
        rate,
        gap: 0.5 * (c / e - rate) * (c / e + rate),
    })
}

/// The coupling at which the self-similar orbit of restitution `e` changes its stability: c = e^⅖ and K = (e + ec − c −
/// c³)/(c² − c), hence ψ = s²(1 + s²)/((1 + s)(1 + e)) with s = e^⅕.
///
/// ```
/// use standfast::stability::{neimark_sacker, self_similar};
///
/// let orbit = self_similar(0.5, neimark_sacker(0.5)).expect("below the bound");
/// assert!((orbit.factor - 0.5_f64.powf(0.4)).abs() < 1e-15);
/// ```
#[must_use]
pub fn neimark_sacker(e: f64) -> f64 {
    let s = libm::pow(e, 0.2);
    s * s * (1.0 + s * s) / ((1.0 + s) * (1.0 + e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_and_critical_restitutions_invert_each_other() {
        for psi in [0.05, 0.3, 0.5, 0.9, 0.99] {
            let (e, goyal) = (clattering_restitution(psi), chatter_restitution(psi));
            assert!((clattering_bound([e, e]) - psi).abs() < 4e-16, "{psi}");
            assert!((chatter_bound([goyal, goyal]) - psi).abs() < 4e-16, "{psi}");
            assert!(e < goyal);
        }
        // The uniform rod, ψ = ½: 9 − 4√5 and 7 − 4√3.
        assert!((clattering_restitution(0.5) * (9.0 + 4.0 * 5f64.sqrt()) - 1.0).abs() < 1e-15);
        assert!((chatter_restitution(0.5) * (7.0 + 4.0 * 3f64.sqrt()) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn the_self_similar_orbit_is_born_at_the_bound() {
        let e = 0.3;
        let bound = clattering_bound([e, e]);
        assert!(self_similar(e, bound).is_none());
        let born = self_similar(e, bound - 1e-9).unwrap();
        assert!((born.factor - libm::cbrt(e)).abs() < 1e-7, "{born:?}");
        assert!(born.stable);
    }
}
